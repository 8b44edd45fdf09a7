//! The oracle against closed forms: nothing here is compared with another renderer.

mod build;
mod image;
mod lambert;
mod mirrors;
mod priorities;
mod refraction;
mod solids;
