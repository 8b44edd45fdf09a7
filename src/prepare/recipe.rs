//! The choices by which a scene becomes arrays.

use super::cut;
use super::rounding::SINGLE_RADII;
use crate::prepare::bvh;
use crate::prepare::local_frame::LocalFrame;
use crate::scene::Scene;
use glam::DVec3;
use std::ops::RangeInclusive;

/// How a scene is packed. Every render takes [`Recipe::of`].
pub(crate) struct Recipe {
    /// Coordinates of the arrays.
    pub local_frame: LocalFrame,
    /// Where the eye is in them; tells which solids it is in.
    pub eye: DVec3,
    /// Enlargement of boxes, relative to the larger of 1 and the coordinate.
    pub padding: f64,
    /// Normal of triangles without area; `None` drops these triangles.
    pub degenerate_normal: Option<DVec3>,
    /// Local radii of the spheres that single numbers serve.
    pub single_radii: RangeInclusive<f64>,
    /// The scene with its large flat shapes cut into pieces, where it has two scales and such shapes.
    pub cut: Option<Scene>,
    /// As of `Near::largest`; 0 in a scene of one scale.
    pub shape: f64,
}

impl Recipe {
    /// The sound one.
    pub fn of(scene: &Scene) -> Recipe {
        let recipe = Recipe::within(LocalFrame::of(scene), scene);
        let Some(near) = recipe.local_frame.near else { return recipe };
        let cut = cut::cut(scene, near.place());
        let shape = near.largest(cut.as_ref().unwrap_or(scene));
        Recipe { cut, shape, single_radii: near.single_radii(), ..recipe }
    }

    /// This recipe with the frame around everything and nothing cut: for rays that start anywhere, and for which no view
    /// is near.
    pub(crate) fn for_any_ray(self, scene: &Scene) -> Recipe {
        let Some(near) = self.local_frame.near else { return self };
        let whole = Recipe::within(LocalFrame::of_whole(scene), scene);
        Recipe {
            local_frame: whole.local_frame,
            eye: if self.eye.is_finite() { whole.eye } else { self.eye },
            single_radii: if self.single_radii == near.single_radii() {
                SINGLE_RADII
            } else {
                self.single_radii
            },
            cut: None,
            shape: 0.0,
            ..self
        }
    }

    fn within(local_frame: LocalFrame, scene: &Scene) -> Recipe {
        Recipe {
            local_frame,
            eye: local_frame.point(scene.camera.look_from),
            padding: bvh::PADDING,
            degenerate_normal: None,
            single_radii: SINGLE_RADII,
            cut: None,
            shape: 0.0,
        }
    }
}

#[cfg(feature = "defects")]
mod planted {
    use super::Recipe;
    use crate::kernel::defects::Defect;
    use crate::prepare::local_frame::{LocalFrame, times_power_of_two};
    use crate::scene::bounds::Bounds;
    use glam::DVec3;

    impl Recipe {
        /// What makes the recipe with `defect` in it.
        pub(crate) fn planted(defect: Defect) -> fn(&crate::scene::Scene) -> Recipe {
            match defect {
                Defect::WorldFrame => |scene| Recipe::within(world(&LocalFrame::of(scene)), scene),
                Defect::OneFrame => |scene| Recipe::within(LocalFrame::of_whole(scene), scene),
                Defect::Uncut => |scene| Recipe { cut: None, ..Recipe::of(scene) },
                Defect::EyeInAir => |scene| Recipe { eye: DVec3::INFINITY, ..Recipe::of(scene) },
                Defect::TightBoxes => |scene| Recipe { padding: 0.0, ..Recipe::of(scene) },
                Defect::KeepDegenerate => {
                    |scene| Recipe { degenerate_normal: Some(DVec3::Y), ..Recipe::of(scene) }
                }
                Defect::NoWide => |scene| Recipe { single_radii: 0.0..=f64::INFINITY, ..Recipe::of(scene) },
                _ => Recipe::of,
            }
        }
    }

    /// The user's own coordinates.
    fn world(local: &LocalFrame) -> LocalFrame {
        let back = |p: DVec3| p.to_array().map(|x| times_power_of_two(x, -local.scale_log2));
        let bounds = Bounds {
            lo: local.center + DVec3::from(back(local.bounds.lo)),
            hi: local.center + DVec3::from(back(local.bounds.hi)),
        };
        LocalFrame { center: DVec3::ZERO, scale_log2: 0, bounds, near: None }
    }
}
