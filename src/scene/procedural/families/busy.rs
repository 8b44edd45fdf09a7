//! A smooth image with detail in one per cent of its pixels: the mean over the image says little about the part that errs.

use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use glam::DVec3;

/// Share of the pixels with detail.
const SHARE: f64 = 0.01;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = View {
        from: DVec3::new(0.0, 1.5, 6.0),
        at: DVec3::new(draw.between(-0.3, 0.3), 1.2, 0.0),
        up: DVec3::Y,
        fov: draw.between(25.0, 50.0),
        size: text.size,
    };
    text.camera(&view, 2, draw.color(0.1, 0.6));
    let position = draw.inside([-3.0, 2.0, 3.0], [3.0, 5.0, 6.0]);
    let strength = draw.log(15.0, 50.0);
    text.light(position, [strength; 3]);
    let wall = text.material(&Surface::matte(draw.color(0.3, 0.9), 0.2));
    text.quad(DVec3::new(0.0, 1.0, -3.0), DVec3::X * 40.0, DVec3::Y * 40.0, &wall);
    let shades = [(0.0, 0.1), (0.9, 1.0)].map(|(low, high)| {
        let color = draw.color(low, high);
        text.material(&Surface::matte(color, 0.6))
    });
    // A rectangle of pixels.
    let [columns, rows] = view.size.map(f64::from);
    let shape = draw.log(0.3, 3.0);
    let (width, height) = ((SHARE * columns * rows * shape).sqrt(), (SHARE * columns * rows / shape).sqrt());
    let (x, y) = (draw.between(0.0, columns - width), draw.between(0.0, rows - height));
    let [right, up, _] = view.axes();
    let thin = draw.log(0.05, 1.0);
    for i in 0..draw.count(10, 200) {
        let distance = 5.0 + 0.001 * f64::from(i);
        let pixel = view.pixel(distance);
        let middle = view.point(x + width * draw.unit(), y + height * draw.unit(), distance);
        let along = draw.direction(right, up);
        let across = draw.direction(right, up);
        let long = if draw.chance(0.5) { thin } else { draw.between(1.0, 0.5 * width.min(height).max(2.1)) };
        let shade = &shades[draw.whole(0, 1) as usize];
        // Two directions that are not nearly parallel.
        let across = if along.cross(across).length() < 0.2 { along.cross(view.axes()[2]) } else { across };
        text.quad(middle, along * (0.5 * long * pixel), across * (0.5 * thin * pixel), shade);
    }
}
