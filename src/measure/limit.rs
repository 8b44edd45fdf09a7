//! placeholder
use crate::scene::Scene;
/// x
#[derive(Debug, Clone, PartialEq)]
pub struct RadianceLimit {
    /// x
    pub rgb: [f64; 3],
    /// x
    pub unbounded: Option<String>,
}
/// x
pub fn radiance_limit(_scene: &Scene) -> RadianceLimit {
    RadianceLimit { rgb: [1.0; 3], unbounded: None }
}
