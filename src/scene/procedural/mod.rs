//! Shapes and scenes made by rule and written as files: the report's rotated cube, the sphereflake, and
//! closed meshes of any size. The same flags give the same bytes on every run.

mod cube;
pub mod families;
mod flake;
mod geodesic;
mod noise;
pub(crate) mod shapes;
mod solid;

pub use cube::rotated_cube;
pub use flake::sphereflake;
pub use geodesic::{displaced_sphere, frequency};
pub use solid::{Corners, Solid};

use crate::atomic_file;
use anyhow::{Context, bail};
use glam::DVec3;
use std::io::Write;
use std::path::{Path, PathBuf};

const CUBE_HELP: &str = "\
Example:
  whitted generate rotated-cube --size 2.4 --rotate 15,35,10 -o cube.obj";

const FLAKE_HELP: &str = "\
Example:
  whitted generate sphereflake --level 2 -o flake.toml";

const DISPLACED_HELP: &str = "\
Example:
  whitted generate displaced-sphere --triangles 20000 --roughness 0.5 -o rock.obj";

/// What `whitted generate` can write.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum Shape {
    /// Write a cube rotated about three axes, as OBJ and MTL
    #[command(after_help = CUBE_HELP)]
    RotatedCube(CubeArgs),
    /// Write the sphereflake of Haines' Standard Procedural Databases, as a scene
    #[command(after_help = FLAKE_HELP)]
    Sphereflake(FlakeArgs),
    /// Write a closed mesh of about N triangles: a geodesic sphere displaced by gradient noise, as OBJ and MTL
    #[command(after_help = DISPLACED_HELP)]
    DisplacedSphere(DisplacedArgs),
}

/// Where a shape goes and what it looks like.
#[derive(Debug, Clone, clap::Args)]
pub struct Placement {
    /// Angles about the x, y and z axes, degrees, applied in this order.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = triple, allow_hyphen_values = true)]
    pub rotate: DVec3,
    /// Position of the centre, metres.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = triple, allow_hyphen_values = true)]
    pub translate: DVec3,
    /// Diffuse colour, linear RGB, each from 0 to 1.
    #[arg(long, value_name = "R,G,B", default_value = "0.8,0.8,0.8", value_parser = color)]
    pub color: DVec3,
    /// File to write; an `.mtl` file of the same name goes beside it. `-` writes the OBJ text, without
    /// a material, to standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Flags of `generate rotated-cube`.
#[derive(Debug, Clone, clap::Args)]
pub struct CubeArgs {
    /// Length of an edge, metres.
    #[arg(long, value_name = "LENGTH", default_value_t = 1.0, value_parser = length)]
    pub size: f64,
    /// Placement and colour.
    #[command(flatten)]
    pub placement: Placement,
}

/// Flags of `generate sphereflake`.
#[derive(Debug, Clone, clap::Args)]
pub struct FlakeArgs {
    /// Generations of smaller spheres; level L has (9^(L+1) - 1) / 8 spheres in all.
    // 9^8 / 8 = 5.4 million spheres, about half a gigabyte of text, is where scene text ends.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=7))]
    pub level: u32,
    /// Diffuse colour of the spheres, linear RGB, each from 0 to 1.
    #[arg(long, value_name = "R,G,B", default_value = "1,0.9,0.7", value_parser = color)]
    pub color: DVec3,
    /// File to write: a scene, or NFF if the name ends so; `-` writes a scene to standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Flags of `generate displaced-sphere`.
#[derive(Debug, Clone, clap::Args)]
pub struct DisplacedArgs {
    /// Number of triangles; the nearest 20 f^2 is taken.
    // 20 f^2 with about ten times the largest mesh that was asked for; more overflows no index but memory.
    #[arg(long, value_name = "N", default_value_t = 70_000, value_parser = clap::value_parser!(u64).range(20..=100_000_000))]
    pub triangles: u64,
    /// Radius before displacement, metres.
    #[arg(long, value_name = "RADIUS", default_value_t = 1.0, value_parser = length)]
    pub size: f64,
    /// Height of the displacement: 0 leaves a sphere, 1 moves the surface by up to 75 % of the radius.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    pub roughness: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 7)]
    pub seed: u32,
    /// Placement and colour.
    #[command(flatten)]
    pub placement: Placement,
}

/// Makes `shape` and writes it.
///
/// # Errors
/// If the file cannot be written; then no partial file is left.
pub fn run(shape: &Shape) -> anyhow::Result<()> {
    match shape {
        Shape::RotatedCube(args) => {
            let p = &args.placement;
            write_solid(&rotated_cube(args.size, p.rotate, p.translate), p)
        }
        Shape::DisplacedSphere(args) => {
            let p = &args.placement;
            let mut solid = displaced_sphere(frequency(args.triangles), args.roughness, args.seed);
            solid.place(args.size, p.rotate, p.translate);
            write_solid(&solid, p)
        }
        Shape::Sphereflake(args) => {
            let is_nff = args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("nff"));
            let write = if is_nff { flake::write_nff } else { flake::write };
            write_text(&args.output, |out| write(out, &sphereflake(args.level), args.level, args.color))
        }
    }
}

/// Writes an OBJ file and its MTL file.
fn write_solid(solid: &Solid, placement: &Placement) -> anyhow::Result<()> {
    let obj = &placement.output;
    if obj == Path::new("-") {
        return write_text(obj, |out| solid.write_obj(out, None));
    }
    let mtl = obj.with_extension("mtl");
    let Some(name) = mtl.file_name() else { bail!("{} is no file name; write -o NAME.obj", obj.display()) };
    if mtl == *obj {
        bail!("{} would be both OBJ and MTL; write -o NAME.obj", obj.display());
    }
    // The MTL comes first, so that the OBJ never names a file that is not there.
    write_text(&mtl, |out| solid.write_mtl(out, placement.color))?;
    write_text(obj, |out| solid.write_obj(out, Some(&name.to_string_lossy())))
}

/// Writes to a file that appears whole or not at all, or to standard output if the path is `-`.
fn write_text(path: &Path, text: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> anyhow::Result<()> {
    if path != Path::new("-") {
        return atomic_file::write(path, text).with_context(|| format!("cannot write {}", path.display()));
    }
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    match text(&mut out).and_then(|()| out.flush()) {
        // The reader has what it wanted (`| head`).
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => other.context("cannot write to standard output"),
    }
}

/// Reads `x,y,z`.
fn triple(text: &str) -> Result<DVec3, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|n| n.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect::<Option<_>>()
        .ok_or("write three finite numbers with commas between, such as 1,2.5,-3")?;
    match numbers[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("{} numbers; write three with commas between, such as 1,2.5,-3", numbers.len())),
    }
}

fn color(text: &str) -> Result<DVec3, String> {
    let rgb = triple(text)?;
    if rgb.min_element() < 0.0 || rgb.max_element() > 1.0 {
        return Err("each channel lies from 0 to 1".to_owned());
    }
    Ok(rgb)
}

fn length(text: &str) -> Result<f64, String> {
    let length = text.parse().map_err(|_| "write a number such as 2.5")?;
    // Vertices are written in single precision.
    let single = f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX);
    if single.contains(&length) {
        Ok(length)
    } else {
        Err("write a length greater than 0, up to 3.4e38".into())
    }
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().map_err(|_| "write a number such as 0.5")?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err("write a number from 0 to 1".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(subcommand)]
        shape: Shape,
    }

    #[test]
    fn flags_are_read_and_checked() {
        let ok = "g rotated-cube --size 2 --rotate -10,20,30 --translate 0,-1,0 --color 1,1,0 -o a.obj";
        let Shape::RotatedCube(args) = Line::try_parse_from(ok.split(' ')).unwrap().shape else { panic!() };
        assert_eq!(args.placement.rotate, DVec3::new(-10.0, 20.0, 30.0));
        for bad in [
            "g rotated-cube",
            "g rotated-cube -o a --size 0",
            "g rotated-cube -o a --size nan",
            "g rotated-cube -o a --rotate 1,2",
            "g rotated-cube -o a --color 1,2,0",
            "g sphereflake -o a --level 8",
            "g displaced-sphere -o a --triangles 0",
            "g displaced-sphere -o a --roughness 2",
        ] {
            assert!(Line::try_parse_from(bad.split(' ')).is_err(), "{bad}");
        }
    }
}
