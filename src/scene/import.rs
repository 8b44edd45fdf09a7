//! The scene around a model as text.

use super::{Fresnel, Light, Material, Scene};
use crate::units::plural;
use glam::DVec3;
use std::fmt::Write;

/// The text of `scene`, which was made around one model; `file` is the model's path from the text's folder. Read again,
/// it gives the same camera, lights and shapes, bit for bit.
pub fn import(scene: &Scene, file: &str) -> String {
    let mut text =
        format!("# Written by `whitted import`: {}", plural(scene.triangle_count() as u64, "triangle"));
    if !scene.spheres.is_empty() {
        text += &format!(", {}", plural(scene.spheres.len() as u64, "sphere"));
    }
    // Writing to a String cannot fail.
    let _ = write_camera(&mut text, scene);
    for Light { position, intensity } in &scene.lights {
        let _ = write!(
            text,
            "\n[[light]]\nposition  = {}\nintensity = {}\n",
            vector(*position),
            grey_or_color(*intensity)
        );
    }
    let _ = write!(text, "\n[[mesh]]\nfile = {}\n", quoted(file));
    if !scene.materials.is_empty() {
        text += "\n# The file's materials. To change the whole mesh, write one of your own and `material = \"NAME\"` above.\n";
    }
    for material in &scene.materials {
        let table = table(material);
        table.lines().for_each(|line| text += &format!("# {line}\n"));
    }
    text
}

fn write_camera(text: &mut String, scene: &Scene) -> std::fmt::Result {
    let (camera, render) = (&scene.camera, &scene.render);
    writeln!(text, "\n\n[camera]")?;
    writeln!(text, "look_from = {}", vector(camera.look_from))?;
    writeln!(text, "look_at   = {}", vector(camera.look_at))?;
    writeln!(text, "up        = {}", vector(camera.up))?;
    writeln!(text, "fov       = {}", degrees(camera.fov))?;
    writeln!(text, "width     = {}\nheight    = {}", camera.width, camera.height)?;
    writeln!(text, "\n[render]\nsamples    = {}\ndepth      = {}", render.samples, render.depth)?;
    writeln!(text, "background = {}", grey_or_color(render.background))
}

/// A material as a table of the scene format.
pub(crate) fn table(material: &Material) -> String {
    let Material { name, diffuse, ambient, secondary, fresnel, ior, priority, .. } = material;
    let mut text = format!(
        "[material.{}]\ndiffuse = {}\nambient = {}\n",
        quoted(name),
        vector(*diffuse),
        number(*ambient)
    );
    if *secondary > 0.0 {
        let law = match fresnel {
            Fresnel::Constant(share) => number(*share),
            Fresnel::Schlick => "\"schlick\"".into(),
            Fresnel::Exact => "\"exact\"".into(),
        };
        text += &format!("secondary = {}\nfresnel = {law}\nior = {}\n", number(*secondary), number(*ior));
    }
    if *priority != 0 {
        text += &format!("priority = {priority}\n");
    }
    text
}

/// The degrees that are read as `radians`: the nearest number may come back some steps off.
fn degrees(radians: f64) -> String {
    let near = radians.to_degrees();
    let steps =
        (1..=4).flat_map(|n| [n, -n]).map(|n: i64| f64::from_bits(near.to_bits().wrapping_add_signed(n)));
    let mut candidates = [near.round(), near].into_iter().chain(steps);
    number(candidates.find(|d| d.to_radians() == radians).unwrap_or(near))
}

/// The shortest decimals that are read as `x`.
fn number(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() < 1e9 { format!("{x}") } else { format!("{x:?}") }
}

fn vector(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(number);
    format!("[{x}, {y}, {z}]")
}

fn grey_or_color(color: DVec3) -> String {
    if color == DVec3::splat(color.x) { number(color.x) } else { vector(color) }
}

/// A TOML string.
fn quoted(text: &str) -> String {
    let escaped = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\u{:04x}", c as u32),
        c => c.to_string(),
    };
    format!("\"{}\"", text.chars().map(escaped).collect::<String>())
}
