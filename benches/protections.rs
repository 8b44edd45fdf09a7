//! What each protection of the kernels costs: `cargo bench --bench protections` renders with one
//! protection left out at a time, by the planted mistakes of `whitted::kernel::defects`, and prints the device
//! times as Markdown.

use whitted::kernel::defects::Defect;
use whitted::lab::stress::page::PageError;
use whitted::lab::stress::page::cost::{Variant, measure};
use whitted::render::Renderer;
use whitted::settings::{DeviceChoice, Precision};

/// A row, and the mistake that is planted for it.
macro_rules! without {
    ($name:literal, $defect:ident) => {
        Variant { name: $name, precision: Precision::Robust, prepare: |r| r.plant(Defect::$defect) }
    };
}

const VARIANTS: [Variant; 9] = [
    without!("`robust` again: the noise", Nothing),
    without!("hits not confined to their boxes", Unconfined),
    without!("Moeller and Trumbore's triangle test", MoellerTrumbore),
    without!("the schoolbook quadratic for spheres", NaiveQuadratic),
    without!("huge spheres in plain f32", NoWide),
    without!("box tests without allowance", NarrowSlab),
    without!("boxes without padding", TightBoxes),
    without!("vectors normalised without scaling", BlindNormalise),
    without!("samples added without compensation", NaiveSum),
];

#[allow(clippy::print_stdout)]
fn main() -> Result<(), PageError> {
    let mut renderer = Renderer::new(&DeviceChoice::Best)?;
    let cost = measure(&mut renderer, &VARIANTS, &|| false)?;
    let device = renderer.device().info();
    println!("# What single protections cost\n");
    println!("Made by `cargo bench --bench protections`.\n");
    println!("Device: {} ({}), {}, Vulkan {}.", device.name, device.kind, device.driver, device.api);
    println!("{}", cost.text(&device.kind));
    Ok(())
}
