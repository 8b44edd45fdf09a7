//! Dots smaller than a pixel that are brighter than white: by their own light, or by a light close to them. Few samples
//! meet one, and each that does moves its pixel to white.

use super::dark_dots::{dot, view};
use super::draw::Draw;
use super::text::{Surface, Text};
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = view(draw, text.size);
    text.camera(&view, 2, draw.color(0.0, 0.2));
    let position = draw.inside([-3.0, 1.0, 2.0], [3.0, 5.0, 5.0]);
    let strength = draw.log(1.0, 20.0);
    text.light(position, [strength; 3]);
    let wall = text.material(&Surface::matte(draw.color(0.0, 0.5), 0.2));
    text.quad(DVec3::new(0.0, 1.0, -2.0), DVec3::X * 30.0, DVec3::Y * 30.0, &wall);
    let radiance = draw.log(1.5, 1e4);
    // What a dot adds to its pixel, if it is all there: its area in pixels times its radiance.
    let equal = draw.chance(0.5).then(|| draw.log(0.01, 0.9));
    let glow = text.material(&Surface::glowing(draw.color(0.5, 1.0).map(|c| c * radiance)));
    for _ in 0..draw.count(3, 800) {
        let diameter = equal.unwrap_or_else(|| draw.log(0.01, 0.9));
        dot(draw, text, &view, diameter, &glow);
    }
    // Balls of less than a pixel, each with a light a few radii before it.
    let white = text.material(&Surface::matte(draw.color(0.5, 1.0), 0.1));
    for _ in 0..draw.whole(0, 4) {
        let distance = draw.between(3.0, 6.0);
        let [columns, rows] = view.size.map(f64::from);
        let middle = view.point(draw.between(0.0, columns), draw.between(0.0, rows), distance);
        let radius = 0.5 * draw.log(0.03, 0.9) * view.pixel(distance);
        let gap = radius * draw.between(0.5, 3.0);
        text.sphere(middle, radius, &white);
        let [_, _, forward] = view.axes();
        let radiance = draw.log(1.5, 1e4);
        text.light(middle - forward * (radius + gap), [radiance * gap * gap; 3]);
    }
}
