//! A Whitted (1980) ray tracer as raw Vulkan compute, which knows what its accuracy costs.
//!
//! It renders without a window, on any device with Vulkan 1.2: a GPU, or Mesa's software driver lavapipe. The same
//! scene, settings and device give the same bits on every run.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use whitted::{DeviceChoice, Renderer, Scene, Settings};
//!
//! let scene = Scene::load("scenes/cornell.toml")?;
//! let settings = Settings { width: 60, height: 50, samples: 2, ..Settings::of(&scene) };
//! let mut renderer = Renderer::new(&DeviceChoice::Best)?;
//! let image = renderer.render(&scene, &settings)?;
//! println!("{} rays in {:.3} s", image.report.rays.total(), image.report.time.render);
//! image.save(std::env::temp_dir().join("cornell.png"))?;
//! # assert_eq!(image.linear.len(), 60 * 50);
//! # Ok(())
//! # }
//! ```
//!
//! - A [`Scene`] is read from a TOML text and the OBJ and MTL files that it names, or built by hand.
//! - [`Settings`] say what is rendered: size, samples, depth, precision.
//! - A [`Renderer`] is an open device with the kernels compiled so far; one serves many scenes.
//! - [`Renderer::render`] gives [`Rendered`]: linear pixels and a [`Report`] of times and rays by pass and depth.
//! - [`Renderer::render_bounded`] takes a [`Request`] instead of samples and depth, an error or a time, and gives a
//!   [`BoundedImage`] with an upper bound on its error.
//! - [`compare`] tells how far one image is from another.
//!
//! `examples/` has a program for each. No call prints, reads arguments, or catches signals; an [`Observer`] sees the
//! progress and may cancel.
#![deny(unsafe_code)]

// The rooms stand from the bottom up: a room uses those above it in this list, never those below. What is hidden here
// is open to this repository's tests, benches and command line, and changes without notice.
#[doc(hidden)]
pub mod atomic_file;
mod host;
#[doc(hidden)]
pub mod stats;
#[doc(hidden)]
pub mod units;

pub mod scene;
#[doc(hidden)]
pub mod kernel;
pub mod settings;
#[doc(hidden)]
pub mod prepare;
pub mod report;
#[doc(hidden)]
pub mod plan;
#[doc(hidden)]
pub mod vk;
#[doc(hidden)]
pub mod image;
#[doc(hidden)]
pub mod compare;
#[doc(hidden)]
pub mod render;
#[doc(hidden)]
pub mod accuracy;
#[doc(hidden)]
pub mod reference;
#[doc(hidden)]
pub mod lab;
#[doc(hidden)]
pub mod cli;

pub use accuracy::promise::{Bounded, BoundedImage, Layer, Request, Target};
pub use compare::metrics::{Metrics, SizeMismatch, compare};
pub use glam::DVec3;
pub use image::{Picture, ReadError, SaveError};
pub use plan::PlanError;
pub use render::{
    Convergence, ImageSoFar, Mismatch, Observer, Prepared, Quiet, RenderError, Rendered, Renderer,
    ResumeState, Sums,
};
pub use report::Report;
pub use scene::{Scene, SceneError};
pub use settings::{DeviceChoice, Precision, Settings, SettingsError};
pub use vk::VkError;
