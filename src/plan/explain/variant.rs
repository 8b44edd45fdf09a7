//! The kernels of a plan, and the values of their specialisation constants.

use crate::kernel::abi::{self, Specialisation};
use crate::kernel::table::{Kernel, KernelCode};
use crate::plan::Plan;
use crate::plan::dispatches::dispatches;
use crate::plan::passes;
use crate::prepare::MEDIA_MAX;
use crate::report::explain::{Constant, KernelRow};
use crate::settings::{Precision, Settings};

/// The kernels that run, in the order of the pass table, with their dispatches in one batch.
pub(super) fn kernels(plan: &Plan, settings: &Settings) -> Vec<KernelRow> {
    let steps: Vec<Kernel> = dispatches(plan, plan.last_depth).map(|s| s.pass.kernel).collect();
    passes::all()
        .filter(|p| steps.contains(&p.kernel))
        .map(|p| KernelRow {
            kernel: p.kernel.name(),
            form: form(p.kernel.code(), plan, settings),
            launches: steps.iter().filter(|k| **k == p.kernel).count() as u64,
        })
        .collect()
}

/// Which of its compiled forms a kernel of `plan` runs in.
pub(crate) fn form(code: &KernelCode, plan: &Plan, settings: &Settings) -> &'static str {
    // Kernels that test no shapes have no such form, those that count by subgroups no other.
    let has_packet = code.packet.0 != code.single.0 || code.double.0 == code.single.0;
    match (settings.precision, has_packet, plan.specialisation.lanes) {
        (Precision::Double, ..) => "f64",
        (_, false, _) | (_, _, 0) => "f32",
        _ => "packet",
    }
}

/// Constants that differ from the general kernel, and counts that loops are unrolled for.
pub(super) fn constants(plan: &Plan) -> Vec<Constant> {
    rows(&plan.specialisation).into_iter().filter(|c| Some(c.value) != c.general).collect()
}

/// All constants that follow from a scene.
fn rows(s: &Specialisation) -> Vec<Constant> {
    let count = |n: u32, what: &str| match n {
        0 => format!("no code for {what}"),
        _ => format!("loops over {what} have a constant length"),
    };
    let one_by_one = s.use_bvh == 0 && s.triangle_count + s.sphere_count <= abi::UNROLL_MAX;
    let rows = [
        ("triangle_count", s.triangle_count, None, count(s.triangle_count, "triangles")),
        ("sphere_count", s.sphere_count, None, count(s.sphere_count, "spheres")),
        ("light_count", s.light_count, None, count(s.light_count, "lights")),
        (
            "use_bvh",
            s.use_bvh,
            Some(1),
            if one_by_one { "no traversal: unrolled tests" } else { "no traversal: a loop over all shapes" }
                .into(),
        ),
        (
            "smooth_normals",
            s.smooth_normals,
            Some(1),
            "no interpolation of normals, no correction of its reflections".into(),
        ),
        (
            "media_capacity",
            s.media_capacity,
            Some(MEDIA_MAX),
            if s.media_capacity == 0 {
                "no list of the solids around a ray"
            } else {
                "shorter lists of solids"
            }
            .into(),
        ),
        (
            "extended_spheres_used",
            s.extended_spheres_used,
            Some(1),
            "no sphere test in double-length arithmetic".into(),
        ),
        ("robust", s.robust, Some(1), "no exact rechecks (--precision fast)".into()),
        (
            "origin_fixed",
            s.origin_fixed,
            Some(0),
            "rays start a fixed distance off the surface (--origin)".into(),
        ),
        (
            "branching",
            s.branching,
            Some(1),
            "at most one ray per sample and depth: no sums over several".into(),
        ),
        ("survey", s.survey, Some(1), "pixels in rows, no record of paths".into()),
        ("surface_layer", s.surface_layer, Some(abi::LAYER_LIGHT), "first surfaces instead of light".into()),
        ("counting", s.counting, Some(0), "box and primitive tests are counted".into()),
        ("lanes", s.lanes, Some(0), "packets: the rays of a subgroup traverse together".into()),
        (
            "stack_size",
            s.stack_size,
            Some(abi::STACK_SIZE),
            "traversal stack as deep as this hierarchy needs".into(),
        ),
        ("texels", s.texels, Some(0), "loads through texel views".into()),
        (
            "triangles_outside",
            s.triangles_outside,
            Some(0),
            "the few triangles are outside the hierarchy".into(),
        ),
        ("spheres_outside", s.spheres_outside, Some(0), "the few spheres are outside the hierarchy".into()),
        ("fused", s.fused, Some(0), "one fused kernel for the stages that handle a ray by itself".into()),
    ];
    rows.into_iter().map(|(name, value, general, why)| Constant { name, value, general, why }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constants that do not depend on the scene.
    const SILENT: [&str; 5] = ["workgroup", "loop_cap", "sampler_kind", "replicates", "parts"];

    #[test]
    fn no_constant_is_forgotten() {
        let mut listed: Vec<&str> =
            rows(&Specialisation::default()).iter().map(|c| c.name).chain(SILENT).collect();
        let mut all: Vec<&str> = abi::SPECIALISATION.iter().map(|(name, _)| *name).collect();
        listed.sort_unstable();
        all.sort_unstable();
        assert_eq!(listed, all);
    }
}
