//! Scene text, piece by piece.

use super::view::View;
use glam::DVec3;
use std::fmt::Write;

/// Share of reflection at a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    /// The same at every angle.
    Share(f64),
    /// Schlick's approximation.
    Schlick,
    /// The dielectric equations.
    Exact,
}

/// A material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    /// Linear RGB.
    pub(super) diffuse: [f64; 3],
    /// Own light, relative to `diffuse`.
    pub(super) ambient: f64,
    /// Weight of reflection and refraction.
    pub(super) secondary: f64,
    /// Share of reflection.
    pub(super) law: Law,
    /// Index of refraction.
    pub(super) ior: f64,
}

impl Surface {
    /// Neither reflects nor refracts.
    pub(super) fn matte(diffuse: [f64; 3], ambient: f64) -> Surface {
        Surface { diffuse, ambient, secondary: 0.0, law: Law::Share(1.0), ior: 1.5 }
    }

    /// The same colour without any light: radiance `diffuse` everywhere.
    pub(super) fn glowing(radiance: [f64; 3]) -> Surface {
        Surface::matte(radiance, 1.0)
    }

    /// A mirror that keeps `secondary` of the light.
    pub(super) fn mirror(diffuse: [f64; 3], secondary: f64) -> Surface {
        Surface { secondary, ..Surface::matte(diffuse, 0.1) }
    }

    /// Glass without a colour of its own.
    pub(super) fn glass(law: Law, ior: f64, secondary: f64) -> Surface {
        Surface { secondary, law, ior, ..Surface::matte([0.3; 3], 0.2) }
    }
}

/// A scene under construction.
#[derive(Debug)]
pub(super) struct Text {
    text: String,
    materials: u32,
    /// Width and height of the image, pixels.
    pub(super) size: [u32; 2],
}

impl Text {
    pub(super) fn new(size: [u32; 2]) -> Text {
        Text { text: String::new(), materials: 0, size }
    }

    /// A comment.
    pub(super) fn note(&mut self, note: &str) {
        self.line(format_args!("# {note}"));
    }

    /// Camera and defaults of the render.
    pub(super) fn camera(&mut self, view: &View, depth: u32, background: [f64; 3]) {
        let [width, height] = view.size;
        self.line(format_args!("\n[camera]\nlook_from = {}\nlook_at = {}", point(view.from), point(view.at)));
        self.line(format_args!("up = {}\nfov = {}", point(view.up), number(view.fov)));
        self.line(format_args!("width = {width}\nheight = {height}"));
        self.line(format_args!(
            "\n[render]\nsamples = 16\ndepth = {depth}\nbackground = {}",
            list(background)
        ));
    }

    /// A point light.
    pub(super) fn light(&mut self, position: DVec3, intensity: [f64; 3]) {
        self.line(format_args!(
            "\n[[light]]\nposition = {}\nintensity = {}",
            point(position),
            list(intensity)
        ));
    }

    /// A material; gives its name.
    pub(super) fn material(&mut self, surface: &Surface) -> String {
        self.materials += 1;
        let name = format!("m{}", self.materials);
        let law = match surface.law {
            Law::Share(share) => number(share),
            Law::Schlick => "\"schlick\"".into(),
            Law::Exact => "\"exact\"".into(),
        };
        self.line(format_args!("\n[material.{name}]\ndiffuse = {}", list(surface.diffuse)));
        self.line(format_args!(
            "ambient = {}\nsecondary = {}",
            number(surface.ambient),
            number(surface.secondary)
        ));
        self.line(format_args!("fresnel = {law}\nior = {}", number(surface.ior)));
        name
    }

    /// A sphere.
    pub(super) fn sphere(&mut self, center: DVec3, radius: f64, material: &str) {
        let (center, radius) = (point(center), number(radius));
        self.line(format_args!(
            "\n[[sphere]]\ncenter = {center}\nradius = {radius}\nmaterial = \"{material}\""
        ));
    }

    /// A planar convex polygon.
    pub(super) fn polygon(&mut self, corners: &[DVec3], material: &str) {
        let corners: Vec<String> = corners.iter().map(|c| point(*c)).collect();
        let corners = corners.join(", ");
        self.line(format_args!("\n[[polygon]]\nvertices = [{corners}]\nmaterial = \"{material}\""));
    }

    /// A parallelogram about `center` with these half sides.
    pub(super) fn quad(&mut self, center: DVec3, a: DVec3, b: DVec3, material: &str) {
        self.polygon(&[center - a - b, center + a - b, center + a + b, center - a + b], material);
    }

    /// A box about `center` with these half sides, as six polygons.
    pub(super) fn cuboid(&mut self, center: DVec3, sides: [DVec3; 3], material: &str) {
        for axis in 0..3 {
            let [out, a, b] = [sides[axis], sides[(axis + 1) % 3], sides[(axis + 2) % 3]];
            self.quad(center + out, a, b, material);
            self.quad(center - out, b, a, material);
        }
    }

    /// The text.
    pub(super) fn finish(self) -> String {
        self.text
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{line}");
    }
}

fn point(p: DVec3) -> String {
    list(p.to_array())
}

fn list(numbers: [f64; 3]) -> String {
    format!("[{}]", numbers.map(number).join(", "))
}

/// Nine significant digits: far less than what a scene may be off, and free of the last bits of sines and logarithms,
/// in which machines differ.
fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.8e}").parse().unwrap_or(x);
    // Not -0.0.
    format!("{:?}", rounded + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_toml_floats_of_nine_digits() {
        let cases = [0.0, -0.0, 1.0, 1.0 / 3.0, -2.5e-7, 1e20];
        assert_eq!(cases.map(number), ["0.0", "0.0", "1.0", "0.333333333", "-2.5e-7", "1e20"]);
    }
}
