//! Renders a scene in single and in double precision, and prints how far the two images are apart.
//!
//! `cargo run --release --example compare -- scenes/cornell.toml`
#![allow(clippy::print_stdout)] // An example speaks on standard output.

use whitted::{DeviceChoice, Precision, Renderer, Scene, Settings, compare};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("usage: compare SCENE")?;
    let scene = Scene::load(file)?;
    let mut renderer = Renderer::new(&DeviceChoice::Best)?;
    let settings = Settings { width: 120, height: 100, samples: 4, ..Settings::of(&scene) };
    let single = renderer.render(&scene, &Settings { precision: Precision::Robust, ..settings.clone() })?;
    let double = renderer.render(&scene, &Settings { precision: Precision::Double, ..settings })?;
    let apart = compare(&single.linear, &double.linear)?;
    println!("RMSE {:.2e}, greatest error {:.2e}", apart.rmse, apart.max_abs);
    println!("{} pixels differ in their 8-bit codes", apart.code_differing_pixels);
    Ok(())
}
