//! Wires at all angles before a wall: parallelograms, triangles that run to a point, and thin boxes.

use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = View {
        from: DVec3::new(draw.between(-1.0, 1.0), draw.between(0.8, 2.5), 6.0),
        at: DVec3::new(draw.between(-0.5, 0.5), draw.between(0.8, 1.6), 0.0),
        up: DVec3::Y,
        fov: draw.between(25.0, 60.0),
        size: text.size,
    };
    let background = draw.color(0.0, 0.9);
    text.camera(&view, draw.whole(1, 3), background);
    for _ in 0..draw.whole(1, 3) {
        let position = draw.inside([-4.0, 2.0, 2.0], [4.0, 6.0, 7.0]);
        let strength = draw.log(4.0, 40.0);
        text.light(position, draw.color(0.5, 1.0).map(|c| c * strength));
    }
    if draw.chance(0.7) {
        let ambient = draw.between(0.05, 0.5);
        let wall = text.material(&Surface::matte(draw.color(0.1, 1.0), ambient));
        text.quad(DVec3::new(0.0, 1.5, -4.0), DVec3::X * 20.0, DVec3::Y * 20.0, &wall);
    }
    if draw.chance(0.6) {
        let floor = match draw.chance(0.3) {
            true => Surface::mirror(draw.color(0.2, 0.8), draw.between(0.1, 0.5)),
            false => Surface::matte(draw.color(0.2, 0.8), 0.1),
        };
        let floor = text.material(&floor);
        text.quad(DVec3::new(0.0, -1.0, 0.0), DVec3::X * 20.0, DVec3::Z * 10.0, &floor);
    }
    let shades: Vec<String> = (0..4)
        .map(|_| {
            let low = draw.of(&[0.0, 0.3, 0.8]);
            let ambient = draw.between(0.05, 0.6);
            text.material(&Surface::matte(draw.color(low, low + 0.2), ambient))
        })
        .collect();
    let fixed = draw.chance(0.5).then(|| draw.log(0.02, 2.0));
    for _ in 0..draw.count(5, 120) {
        let width = fixed.unwrap_or_else(|| draw.log(0.02, 2.0));
        let shade = shades[draw.whole(0, 3) as usize].clone();
        wire(draw, text, &view, width, &shade);
    }
}

/// One wire across the image, `width` pixels thick.
pub(super) fn wire(draw: &mut Draw, text: &mut Text, view: &View, width: f64, material: &str) {
    let [columns, rows] = view.size.map(f64::from);
    let distance = draw.between(2.0, 8.0);
    let [right, up, forward] = view.axes();
    let middle = view.point(draw.between(0.0, columns), draw.between(0.0, rows), distance);
    let along = draw.direction(right, up) + forward * draw.between(-0.5, 0.5);
    let half = along * (draw.between(0.05, 0.8) * rows * view.pixel(distance));
    let across = along.cross(forward).normalize() * (0.5 * width * view.pixel(distance));
    match draw.whole(0, 3) {
        0 => text.polygon(&[middle - half - across, middle - half + across, middle + half], material),
        1 => {
            let deep = across.cross(half).normalize() * across.length();
            text.cuboid(middle, [half, across, deep], material);
        }
        _ => text.quad(middle, half, across, material),
    }
}
