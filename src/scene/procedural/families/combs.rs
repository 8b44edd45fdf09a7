//! Bars before a wall whose period is close to a simple multiple of the pixel, so that equally placed samples meet them
//! all in the same phase.

use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use glam::DVec3;

/// Most bars of one comb.
const MOST: f64 = 500.0;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = View {
        from: DVec3::new(0.0, 1.0, 5.0),
        at: DVec3::new(0.0, 1.0, 0.0),
        up: DVec3::Y,
        fov: draw.between(20.0, 70.0),
        size: text.size,
    };
    text.camera(&view, 1, draw.color(0.0, 1.0));
    let position = draw.inside([-3.0, 1.0, 4.0], [3.0, 5.0, 6.0]);
    let strength = draw.log(10.0, 40.0);
    text.light(position, [strength; 3]);
    let ambient = draw.between(0.1, 0.9);
    let wall = text.material(&Surface::matte(draw.color(0.5, 1.0), ambient));
    let bars = text.material(&Surface::matte(draw.color(0.0, 0.25), ambient));
    text.quad(DVec3::new(0.0, 1.0, -1.0), DVec3::X * 30.0, DVec3::Y * 30.0, &wall);
    comb(draw, text, &view, 5.0, &bars);
    if draw.chance(0.4) {
        comb(draw, text, &view, 5.5, &bars);
    }
}

/// One comb over the whole image or a part of it, on a plane at `distance` that faces the eye.
fn comb(draw: &mut Draw, text: &mut Text, view: &View, distance: f64, material: &str) {
    let [columns, rows] = view.size.map(f64::from);
    let pixel = view.pixel(distance);
    // In pixels. Exactly aligned in one draw of three, otherwise up to 3 % off.
    let ratio = draw.of(&[0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 1.0, 1.0, 1.5, 2.0, 3.0]);
    let period = ratio * if draw.chance(1.0 / 3.0) { 1.0 } else { 1.0 + draw.between(-0.03, 0.03) };
    let duty = draw.between(0.15, 0.85);
    let phase = if draw.chance(0.3) { 0.0 } else { draw.unit() };
    let tilt = if draw.chance(0.5) { 0.0 } else { draw.between(-0.05, 0.05) };
    let [right, up, _] = view.axes();
    let (across, along) = match draw.chance(0.5) {
        true => (right * tilt.cos() + up * tilt.sin(), up * tilt.cos() - right * tilt.sin()),
        false => (up * tilt.cos() + right * tilt.sin(), right * tilt.cos() - up * tilt.sin()),
    };
    let corner = columns.hypot(rows);
    let count = (corner / period).min(MOST).ceil();
    let half = along * (draw.between(0.3, 0.6) * corner * pixel);
    let middle = view.point(columns / 2.0, rows / 2.0, distance);
    for i in 0..count as u32 {
        let at = (f64::from(i) - (count / 2.0).floor() + phase) * period * pixel;
        text.quad(middle + across * at, half, across * (0.5 * duty * period * pixel), material);
    }
}
