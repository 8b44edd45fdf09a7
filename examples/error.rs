//! Renders a scene to an error instead of a number of samples, and prints what the error is made of.
//!
//! `cargo run --release --example error -- scenes/cornell_glass.toml 0.02 glass.png`
#![allow(clippy::print_stdout)] // An example speaks on standard output.

use whitted::{DeviceChoice, Renderer, Request, Scene, Settings};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, file, error, output] = &args[..] else {
        return Err("usage: error SCENE ERROR IMAGE".into());
    };
    let scene = Scene::load(file)?;
    let settings = Settings { width: 120, height: 100, ..Settings::of(&scene) };
    let request = Request::error(error.parse()?);
    let image = Renderer::new(&DeviceChoice::Best)?.render_bounded(&scene, &settings, &request)?;
    let bound = image.report.error.as_ref().ok_or("some pixels have no samples")?;
    println!("RMSE at most {:.2e} with {:.0} % confidence", bound.total, 100.0 * bound.confidence);
    println!("sampling {:.2e}, truncation {:.2e}", bound.sampling, bound.truncation);
    println!("rounding {:.2e}", bound.rounding.unwrap_or(f64::NAN));
    if let Some(why) = &image.report.asked.unmet_why {
        println!("{error} was not reached: {why}");
    }
    Ok(image.save(output)?)
}
