//! Renders a scene that is written in the program, and prints where the time went.
//!
//! `cargo run --release --example render -- ball.png`
#![allow(clippy::print_stdout)] // An example speaks on standard output.

use whitted::{DeviceChoice, Renderer, Scene, Settings};

const SCENE: &str = r#"
camera = { look_from = [0, 1.5, 5], look_at = [0, 0.9, 0], fov = 40 }

[material.floor]
diffuse = [0.8, 0.8, 0.75]

[material.mirror]
diffuse = [0.1, 0.1, 0.1]
secondary = 0.9

[[light]]
position = [2, 5, 3]
intensity = 20

[[sphere]]
center = [0, 1, 0]
radius = 1
material = "mirror"

[[polygon]]
vertices = [[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]]
material = "floor"
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene: Scene = SCENE.parse()?;
    let settings = Settings { width: 300, height: 250, samples: 4, ..Settings::of(&scene) };
    let image = Renderer::new(&DeviceChoice::Best)?.render(&scene, &settings)?;
    for pass in &image.report.passes {
        println!("{:>10} {}: {:8.3} ms", pass.name, pass.depth, 1e3 * pass.seconds);
    }
    Ok(image.save(std::env::args().nth(1).as_deref().unwrap_or("ball.png"))?)
}
