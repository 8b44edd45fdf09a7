//! Two mirrors that face each other, with objects between them: light of many orders.

use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let half = draw.between(0.8, 2.5);
    let view = View {
        from: DVec3::new(draw.between(-0.7, 0.7) * half, draw.between(0.6, 1.8), 4.0),
        at: DVec3::new(draw.sign() * draw.between(0.5, 2.0) * half, draw.between(0.5, 1.2), 0.0),
        up: DVec3::Y,
        fov: draw.between(35.0, 65.0),
        size: text.size,
    };
    text.camera(&view, draw.count(3, 40), draw.color(0.0, 0.6));
    for _ in 0..draw.whole(1, 3) {
        let position = draw.inside([-0.8 * half, 1.5, -1.0], [0.8 * half, 2.8, 3.5]);
        let strength = draw.log(1.0, 15.0);
        text.light(position, draw.color(0.5, 1.0).map(|c| c * strength));
    }
    let keep = draw.of(&[0.5, 0.7, 0.8, 0.9, 0.95, 0.98]);
    let mirror = text.material(&Surface::mirror(draw.color(0.1, 0.8), keep));
    // Slightly turned in half of the scenes: then images leave the corridor after some orders.
    let turn = if draw.chance(0.5) { 0.0 } else { draw.between(-0.05, 0.05) };
    for side in [-1.0, 1.0] {
        let along = DVec3::new(side * turn.sin(), 0.0, turn.cos());
        text.quad(DVec3::new(side * half, 1.5, 0.0), along * 6.0, DVec3::Y * 1.5, &mirror);
    }
    let floor = text.material(&Surface::matte(draw.color(0.1, 0.9), 0.1));
    text.quad(DVec3::ZERO, DVec3::X * (half * 1.2), DVec3::Z * 6.0, &floor);
    if draw.chance(0.5) {
        let back = text.material(&Surface::matte(draw.color(0.1, 0.9), 0.2));
        text.quad(DVec3::new(0.0, 1.5, -5.9), DVec3::X * (half * 1.2), DVec3::Y * 1.6, &back);
    }
    for _ in 0..draw.whole(1, 12) {
        let surface = match draw.chance(0.25) {
            true => Surface::mirror(draw.color(0.2, 0.9), draw.between(0.3, 0.9)),
            false => Surface::matte(draw.color(0.0, 1.0), 0.15),
        };
        let material = text.material(&surface);
        let radius = draw.log(0.03, 0.45);
        let center = draw.inside([-0.6 * half, radius, -3.0], [0.6 * half, 1.8, 2.0]);
        match draw.chance(0.6) {
            true => text.sphere(center, radius, &material),
            false => {
                let sides = [DVec3::X * (radius * 0.3), DVec3::Y * radius, DVec3::Z * (radius * 0.3)];
                text.cuboid(center, sides, &material);
            }
        }
    }
}
