//! Glass in glass: concentric shells, bubbles inside a ball, a drop that dips into another.

use super::draw::Draw;
use super::glass_crowd::{glass, striped_floor};
use super::text::{Law, Surface, Text};
use super::view::View;
use glam::DVec3;

pub(super) fn draw(draw: &mut Draw, text: &mut Text) {
    let view = View {
        from: DVec3::new(draw.between(-1.5, 1.5), draw.between(1.0, 3.0), 5.0),
        at: DVec3::new(0.0, 0.9, 0.0),
        up: DVec3::Y,
        fov: draw.between(25.0, 45.0),
        size: text.size,
    };
    text.camera(&view, draw.whole(4, 12), draw.color(0.1, 0.9));
    let strength = draw.log(10.0, 50.0);
    text.light(draw.inside([-4.0, 3.0, 0.0], [4.0, 6.0, 6.0]), [strength; 3]);
    striped_floor(draw, text);
    let core = text.material(&Surface::matte(draw.color(0.1, 0.9), 0.2));
    for i in 0..draw.whole(1, 3) {
        let radius = draw.between(0.5, 0.9);
        let center = DVec3::new(f64::from(i) * 1.9 - 1.6, radius + 0.01, draw.between(-0.8, 0.8));
        let outer = glass(draw, text);
        text.sphere(center, radius, &outer);
        match draw.whole(0, 2) {
            0 => shells(draw, text, center, radius, &core),
            1 => bubbles(draw, text, center, radius),
            _ => {
                let drop = glass(draw, text);
                let away = DVec3::new(draw.between(-1.0, 1.0), 0.6, 0.5).normalize();
                text.sphere(center + away * (0.9 * radius), 0.5 * radius, &drop);
            }
        }
    }
}

/// Shells of different indices, the innermost perhaps opaque.
fn shells(draw: &mut Draw, text: &mut Text, center: DVec3, radius: f64, core: &str) {
    let mut inner = radius;
    for _ in 0..draw.whole(1, 4) {
        // Thin shells and thick ones.
        inner *= 1.0 - draw.log(0.005, 0.4);
        let material = glass(draw, text);
        text.sphere(center, inner, &material);
    }
    if draw.chance(0.4) {
        text.sphere(center, 0.5 * inner, core);
    }
}

/// Air in glass.
fn bubbles(draw: &mut Draw, text: &mut Text, center: DVec3, radius: f64) {
    let air = text.material(&Surface::glass(Law::Exact, 1.0, 1.0));
    for _ in 0..draw.count(2, 30) {
        let size = radius * draw.log(0.02, 0.25);
        let offset = draw.inside([-0.55; 3], [0.55; 3]) * (radius - size);
        text.sphere(center + offset, size, &air);
    }
}
