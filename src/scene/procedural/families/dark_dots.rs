//! Dark dots smaller than a pixel before a bright wall.

use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = view(draw, text.size);
    text.camera(&view, 2, draw.color(0.3, 1.0));
    let position = draw.inside([-3.0, 1.0, 2.0], [3.0, 5.0, 5.0]);
    let strength = draw.log(10.0, 60.0);
    text.light(position, [strength; 3]);
    let ambient = draw.between(0.3, 1.0);
    let wall = text.material(&Surface::matte(draw.color(0.5, 1.0), ambient));
    text.quad(DVec3::new(0.0, 1.0, -2.0), DVec3::X * 30.0, DVec3::Y * 30.0, &wall);
    let dark = text.material(&Surface::matte(draw.color(0.0, 0.3), 0.1));
    let equal = draw.chance(0.5).then(|| draw.log(0.01, 1.0));
    for _ in 0..draw.count(20, 1500) {
        let diameter = equal.unwrap_or_else(|| draw.log(0.01, 1.0));
        dot(draw, text, &view, diameter, &dark);
    }
}

/// A camera for dots.
pub(super) fn view(draw: &mut Draw, size: [u32; 2]) -> View {
    View {
        from: DVec3::new(draw.between(-1.5, 1.5), draw.between(0.2, 2.0), 5.0),
        at: DVec3::new(0.0, 1.0, 0.0),
        up: DVec3::Y,
        fov: draw.between(25.0, 60.0),
        size,
    }
}

/// A sphere or a square somewhere in the image, `diameter` pixels wide.
pub(super) fn dot(draw: &mut Draw, text: &mut Text, view: &View, diameter: f64, material: &str) {
    let [columns, rows] = view.size.map(f64::from);
    let distance = draw.between(3.0, 6.0);
    let middle = view.point(draw.between(0.0, columns), draw.between(0.0, rows), distance);
    let half = 0.5 * diameter * view.pixel(distance);
    if draw.chance(0.5) {
        text.sphere(middle, half, material);
    } else {
        let [right, up, forward] = view.axes();
        let a = draw.direction(right, up);
        text.quad(middle, a * half, a.cross(forward) * half, material);
    }
}
