//! The sphereflake ("balls") of Haines' Standard Procedural Databases (1987): nine smaller spheres on
//! each sphere, six about its equator and three above. No trigonometry, so the same bits everywhere.

use glam::{DMat3, DVec3};
use std::io::{Result, Write};

/// A sphere of the flake: centre and radius, metres.
pub type Ball = (DVec3, f64);

/// Radius of the first sphere, metres, as in the SPD.
const RADIUS: f64 = 0.5;
/// Each generation is this much smaller.
const SHRINK: f64 = 1.0 / 3.0;

/// All spheres of the flake with `level` generations below the first: the first at the origin, each
/// followed by its offspring.
pub fn sphereflake(level: u32) -> Vec<Ball> {
    let mut balls = Vec::new();
    grow(&mut balls, &offspring(), level, DVec3::ZERO, DVec3::Z, RADIUS);
    balls
}

fn grow(balls: &mut Vec<Ball>, offspring: &[DVec3; 9], level: u32, center: DVec3, up: DVec3, radius: f64) {
    balls.push((center, radius));
    if level == 0 {
        return;
    }
    let turn = z_to(up);
    for direction in offspring {
        let up = (turn * *direction).normalize();
        let center = center + up * (radius * (1.0 + SHRINK));
        grow(balls, offspring, level - 1, center, up, radius * SHRINK);
    }
}

/// Directions to the nine spheres on a sphere whose pole is z.
fn offspring() -> [DVec3; 9] {
    let d = 0.5f64.sqrt();
    // Three of the twelve nearest neighbours in a face-centred cubic packing, turned about (1, -1, 0) so
    // that (1, 1, 1) becomes the pole: sine 2 / sqrt 6, cosine 1 / sqrt 3.
    let tilt = about(DVec3::new(d, -d, 0.0), 2.0 / 6f64.sqrt(), 1.0 / 3f64.sqrt());
    let trio = [DVec3::new(d, d, 0.0), DVec3::new(d, 0.0, -d), DVec3::new(0.0, d, -d)].map(|v| tilt * v);
    // Then turned by 0, 120 and 240 degrees about the pole.
    let s = 3f64.sqrt() / 2.0;
    let turns = [DMat3::IDENTITY, about(DVec3::Z, s, -0.5), about(DVec3::Z, -s, -0.5)];
    let mut all = [DVec3::ZERO; 9];
    for (i, slot) in all.iter_mut().enumerate() {
        *slot = turns[i / 3] * trio[i % 3];
    }
    // The three that are not on the equator go above it.
    let above = all.iter().map(|v| v.z).sum::<f64>() >= 0.0;
    all.map(|v| if above { v } else { DVec3::new(v.x, v.y, -v.z) })
}

/// Rotation about a unit axis by the angle with that sine and cosine (Rodrigues).
fn about(axis: DVec3, sine: f64, cosine: f64) -> DMat3 {
    let column = |v: DVec3| v * cosine + axis.cross(v) * sine + axis * (axis.dot(v) * (1.0 - cosine));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// The smallest rotation that takes z to `direction`.
fn z_to(direction: DVec3) -> DMat3 {
    let axis = DVec3::Z.cross(direction);
    let sine = axis.length();
    // Below this the axis is rounding: z or -z itself.
    if sine <= 4.0 * f64::EPSILON {
        return if direction.z > 0.0 { DMat3::IDENTITY } else { about(DVec3::Y, 0.0, -1.0) };
    }
    about(axis / sine, sine, direction.z)
}

/// Writes the scene: the SPD's camera, lights and colours, with the floor under the first sphere.
pub(super) fn write(out: &mut dyn Write, balls: &[Ball], level: u32, color: DVec3) -> Result<()> {
    writeln!(out, "# Sphereflake, level {level}: {} spheres. z is up.", balls.len())?;
    writeln!(out, "[camera]\nlook_from = [2.1, 1.3, 1.7]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 45")?;
    writeln!(out, "width = 512\nheight = 512\n")?;
    writeln!(out, "[render]\ndepth = 5\nbackground = [0.078, 0.361, 0.753]\n")?;
    for position in ["[4, 3, 2]", "[1, -4, 4]", "[-3, 1, 5]"] {
        writeln!(out, "[[light]]\nposition = {position}\nintensity = 10\n")?;
    }
    writeln!(out, "[material.floor]\ndiffuse = [1, 0.75, 0.33]\n")?;
    writeln!(out, "[material.ball]\ndiffuse = [{}, {}, {}]\nsecondary = 0.5\n", color.x, color.y, color.z)?;
    writeln!(
        out,
        "[[polygon]]\nvertices = [[12, 12, -0.5], [-12, 12, -0.5], [-12, -12, -0.5], [12, -12, -0.5]]"
    )?;
    writeln!(out, "material = \"floor\"")?;
    for (center, radius) in balls {
        // Single precision is what is rendered; adding 0 turns -0 into 0.
        let [x, y, z] = center.to_array().map(|x| x as f32 + 0.0);
        let radius = *radius as f32;
        writeln!(out, "\n[[sphere]]\ncenter = [{x}, {y}, {z}]\nradius = {radius}\nmaterial = \"ball\"")?;
    }
    Ok(())
}

/// The same as NFF, as the SPD's own program writes it: with lights that do not fall with distance.
pub(super) fn write_nff(out: &mut dyn Write, balls: &[Ball], level: u32, color: DVec3) -> Result<()> {
    writeln!(out, "# Sphereflake, level {level}: {} spheres. z is up.", balls.len())?;
    writeln!(out, "v\nfrom 2.1 1.3 1.7\nat 0 0 0\nup 0 0 1\nangle 45\nhither 0.01\nresolution 512 512")?;
    writeln!(out, "b 0.078 0.361 0.753\nl 4 3 2\nl 1 -4 4\nl -3 1 5")?;
    writeln!(out, "f 1 0.75 0.33 1 0 0 0 0\np 4\n12 12 -0.5\n-12 12 -0.5\n-12 -12 -0.5\n12 -12 -0.5")?;
    writeln!(out, "f {} {} {} 0.5 0.5 3.0827 0 0", color.x, color.y, color.z)?;
    for (center, radius) in balls {
        let [x, y, z] = center.to_array().map(|x| x as f32 + 0.0);
        writeln!(out, "s {x} {y} {z} {}", *radius as f32)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_touch_their_parent_and_each_other_only() {
        let balls = sphereflake(2);
        assert_eq!(balls.len(), 91);
        assert_eq!(balls[0], (DVec3::ZERO, 0.5));
        for (i, (a, r)) in balls.iter().enumerate() {
            for (b, s) in &balls[i + 1..] {
                assert!(a.distance(*b) >= (r + s) * (1.0 - 1e-9));
            }
        }
        // The nine spheres of the first generation: six about the equator, three above.
        let first: Vec<&Ball> = balls.iter().filter(|b| (b.1 - 0.5 / 3.0).abs() < 1e-12).collect();
        assert_eq!(first.len(), 9);
        assert_eq!(first.iter().filter(|b| b.0.z.abs() < 1e-12).count(), 6);
        assert!(first.iter().all(|b| (b.0.length() - 2.0 / 3.0).abs() < 1e-12 && b.0.z > -1e-12));
    }
}
