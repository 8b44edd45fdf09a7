//! Nearly black images: little light, and a few faint or small things in it.

use super::dark_dots::dot;
use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use super::wires::wire;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = View {
        from: DVec3::new(draw.between(-1.0, 1.0), draw.between(0.5, 2.0), 5.0),
        at: DVec3::new(0.0, 0.8, 0.0),
        up: DVec3::Y,
        fov: draw.between(30.0, 60.0),
        size: text.size,
    };
    text.camera(&view, draw.whole(1, 4), [0.0; 3]);
    // Radiance of what is lit best, about.
    let level = draw.log(3e-4, 0.05);
    for _ in 0..draw.whole(1, 2) {
        let position = draw.inside([-2.0, 2.0, 1.0], [2.0, 4.0, 5.0]);
        let strength = 16.0 * level;
        text.light(position, draw.color(0.5, 1.0).map(|c| c * strength));
    }
    if draw.chance(0.6) {
        let floor = text.material(&Surface::matte(draw.color(0.1, 0.5), 0.0));
        text.quad(DVec3::ZERO, DVec3::X * 10.0, DVec3::Z * 10.0, &floor);
    }
    let faint = text.material(&Surface::matte(draw.color(0.3, 1.0), draw.log(1e-3, 0.1)));
    for _ in 0..draw.whole(1, 6) {
        let radius = draw.log(0.05, 0.6);
        text.sphere(draw.inside([-1.5, radius, -2.0], [1.5, 1.5, 2.0]), radius, &faint);
    }
    for _ in 0..draw.whole(0, 10) {
        let width = draw.log(0.05, 1.0);
        wire(draw, text, &view, width, &faint);
    }
    // In half of the scenes a few dots of ordinary brightness: then nearly all error is theirs.
    if draw.chance(0.5) {
        let lit = text.material(&Surface::glowing(draw.color(0.3, 1.0)));
        for _ in 0..draw.count(1, 20) {
            let diameter = draw.log(0.05, 1.0);
            dot(draw, text, &view, diameter, &lit);
        }
    }
}
