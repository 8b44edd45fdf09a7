//! Lights close to surfaces: under each there is a spot smaller than a pixel that is far brighter than white.

use super::draw::Draw;
use super::text::{Surface, Text};
use super::view::View;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = View {
        from: DVec3::new(draw.between(-2.0, 2.0), draw.between(0.8, 3.0), 5.0),
        at: DVec3::new(0.0, draw.between(0.0, 0.8), 0.0),
        up: DVec3::Y,
        fov: draw.between(30.0, 55.0),
        size: text.size,
    };
    text.camera(&view, draw.whole(1, 4), draw.color(0.0, 0.3));
    let floor = match draw.chance(0.3) {
        true => Surface::mirror(draw.color(0.2, 0.9), draw.between(0.1, 0.5)),
        false => Surface::matte(draw.color(0.2, 0.9), 0.1),
    };
    let floor = text.material(&floor);
    text.quad(DVec3::ZERO, DVec3::X * 12.0, DVec3::Z * 12.0, &floor);
    let wall = text.material(&Surface::matte(draw.color(0.2, 0.9), 0.1));
    text.quad(DVec3::new(0.0, 4.0, -3.0), DVec3::X * 12.0, DVec3::Y * 4.0, &wall);
    let ball = text.material(&Surface::matte(draw.color(0.2, 0.9), 0.1));
    let balls: Vec<(DVec3, f64)> = (0..draw.whole(0, 4))
        .map(|_| {
            let radius = draw.between(0.15, 0.6);
            (draw.inside([-2.0, radius, -1.5], [2.0, radius, 2.0]), radius)
        })
        .collect();
    balls.iter().for_each(|(center, radius)| text.sphere(*center, *radius, &ball));
    for _ in 0..draw.whole(1, 5) {
        let gap = draw.log(5e-4, 0.5);
        let position = match (draw.whole(0, 3), balls.first()) {
            (0, _) => draw.inside([-2.0, 0.3, -3.0 + gap], [2.0, 2.5, -3.0 + gap]),
            (1, Some((center, radius))) => {
                let away = DVec3::new(draw.between(-1.0, 1.0), draw.between(0.0, 1.0), 1.0).normalize();
                *center + away * (radius + gap)
            }
            _ => draw.inside([-2.0, gap, -2.0], [2.0, gap, 2.5]),
        };
        // Either a given light on the room, or a given radiance of the spot.
        let intensity = match draw.chance(0.5) {
            true => draw.log(0.01, 3.0),
            false => draw.log(1.0, 1e4) * gap * gap,
        };
        text.light(position, draw.color(0.5, 1.0).map(|c| c * intensity));
    }
    if draw.chance(0.7) {
        let strength = draw.log(2.0, 20.0);
        text.light(draw.inside([-3.0, 3.0, 1.0], [3.0, 5.0, 5.0]), [strength; 3]);
    }
}
