//! Stripes of a ground, or steps, that become thinner than a pixel towards the horizon.

use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let height = draw.log(0.3, 3.0);
    let view = View {
        from: DVec3::new(0.0, height, 0.0),
        at: DVec3::new(0.0, height - draw.between(0.0, 0.35), -1.0),
        up: DVec3::new(draw.between(-0.2, 0.2), 1.0, 0.0),
        fov: draw.between(30.0, 70.0),
        size: text.size,
    };
    text.camera(&view, 2, draw.color(0.1, 1.0));
    for _ in 0..draw.whole(1, 3) {
        let far = draw.log(3.0, 60.0);
        let position = DVec3::new(draw.between(-10.0, 10.0), draw.between(3.0, 20.0), -far);
        let strength = position.length_squared() * draw.between(0.3, 1.2);
        text.light(position, draw.color(0.6, 1.0).map(|c| c * strength));
    }
    let ambient = draw.between(0.2, 0.9);
    let light = text.material(&Surface::matte(draw.color(0.5, 1.0), ambient));
    let dark = match draw.chance(0.25) {
        true => Surface::mirror(draw.color(0.0, 0.2), draw.between(0.2, 0.6)),
        false => Surface::matte(draw.color(0.0, 0.2), ambient),
    };
    let dark = text.material(&dark);
    // Stripes across the view, turned by up to half a right angle.
    let turn = draw.between(-0.7, 0.7) * f64::from(u8::from(draw.chance(0.6)));
    let (along, away) = (DVec3::new(turn.cos(), 0.0, turn.sin()), DVec3::new(turn.sin(), 0.0, -turn.cos()));
    let period = draw.log(0.1, 1.5);
    let duty = draw.between(0.15, 0.85);
    let rise = if draw.chance(0.4) { draw.between(0.02, 0.3) * period } else { 0.0 };
    // Equal stripes at first; further out each wider by a constant factor, so that a hundred reach the horizon.
    let growth = draw.of(&[1.0, 1.01, 1.03, 1.05]);
    let (mut near, mut width, mut level) = (0.3 * height, period, 0.0);
    for _ in 0..draw.whole(40, 140) {
        let (edge, end) = (near + duty * width, near + width);
        let reach = 4.0 + 2.0 * end;
        strip(text, [near, edge], level, (along * reach, away), &light);
        strip(text, [edge, end], level, (along * reach, away), &dark);
        if rise > 0.0 {
            let middle = away * end + DVec3::Y * (level + rise / 2.0);
            text.quad(middle, along * reach, DVec3::Y * (rise / 2.0), &dark);
            // Steps climb as far as the eye sees their tops.
            level = (level + rise).min(0.8 * height);
        }
        near = end;
        width *= growth;
    }
}

fn strip(text: &mut Text, [near, far]: [f64; 2], level: f64, (along, away): (DVec3, DVec3), material: &str) {
    let middle = away * (0.5 * (near + far)) + DVec3::Y * level;
    text.quad(middle, along, away * (0.5 * (far - near)), material);
}
