//! Many glass spheres over stripes.

use super::draw::Draw;
use super::text::{Law, Surface, Text};
use super::view::View;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = View {
        from: DVec3::new(draw.between(-2.0, 2.0), draw.between(1.0, 3.0), 6.0),
        at: DVec3::new(0.0, 0.8, 0.0),
        up: DVec3::Y,
        fov: draw.between(25.0, 45.0),
        size: text.size,
    };
    text.camera(&view, draw.whole(4, 10), draw.color(0.1, 0.9));
    for _ in 0..draw.whole(1, 2) {
        let strength = draw.log(10.0, 60.0);
        text.light(draw.inside([-4.0, 3.0, 0.0], [4.0, 6.0, 6.0]), [strength; 3]);
    }
    striped_floor(draw, text);
    let kinds: Vec<String> = (0..3).map(|_| glass(draw, text)).collect();
    let scale = draw.log(0.08, 0.45);
    let mut balls: Vec<(DVec3, f64)> = Vec::new();
    for _ in 0..draw.count(15, 150) {
        let radius = scale * draw.between(0.5, 1.5);
        let center = draw.inside([-2.2, radius, -2.0], [2.2, 2.2, 2.0]);
        let clear = |(other, r): &(DVec3, f64)| center.distance(*other) > (radius + r) * 1.001;
        // One in ten scenes' worth of overlap: glass that runs into glass.
        if balls.iter().all(clear) || draw.chance(0.05) {
            balls.push((center, radius));
            text.sphere(center, radius, &kinds[draw.whole(0, 2) as usize]);
        }
    }
}

/// A material of clear glass.
pub(super) fn glass(draw: &mut Draw, text: &mut Text) -> String {
    let law = match draw.whole(0, 3) {
        0 => Law::Share(draw.between(0.03, 0.3)),
        1 => Law::Schlick,
        _ => Law::Exact,
    };
    let (ior, secondary) = (draw.between(1.2, 1.9), draw.between(0.8, 1.0));
    text.material(&Surface::glass(law, ior, secondary))
}

/// A floor of stripes in two shades.
pub(super) fn striped_floor(draw: &mut Draw, text: &mut Text) {
    let ambient = draw.between(0.1, 0.5);
    let shades = [(0.5, 1.0), (0.0, 0.4)].map(|(low, high)| {
        let color = draw.color(low, high);
        text.material(&Surface::matte(color, ambient))
    });
    let count = draw.count(4, 60);
    let width = 16.0 / f64::from(count);
    for i in 0..count {
        let x = -8.0 + (f64::from(i) + 0.5) * width;
        let shade = &shades[i as usize % 2];
        text.quad(DVec3::new(x, 0.0, 0.0), DVec3::X * (width / 2.0), DVec3::Z * 10.0, shade);
    }
}
