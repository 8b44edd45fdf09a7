//! Which kernels run, and what they are specialised to.

use crate::kernel::abi::{self, Specialisation};
use crate::kernel::table::KernelCode;
use crate::plan::Plan;
use crate::plan::passes::{self, When};
use crate::prepare::MEDIA_MAX;
use crate::report::explain::{Constant, KernelRow};
use crate::settings::{Precision, Settings};

/// The kernels that run, in the frame's order.
pub(super) fn kernels(plan: &Plan, settings: &Settings) -> Vec<KernelRow> {
    let runs = plan.kernels();
    let depths = u64::from(plan.last_depth);
    let lights = u64::from(plan.specialisation.light_count.max(1).div_ceil(plan.lights_per_pass.max(1)));
    let per_depth = |kernel| passes::PER_DEPTH.iter().any(|p| p.kernel == kernel);
    passes::all()
        .filter(|p| runs.contains(&p.kernel))
        .map(|p| KernelRow {
            kernel: p.kernel.name(),
            form: form(p.kernel.code(), plan, settings),
            launches: match p.when {
                When::Always if !per_depth(p.kernel) => 1,
                When::Always => depths,
                When::NotLast | When::Branching => depths - 1,
                When::PerLights => depths * lights,
            },
        })
        .collect()
}

fn form(code: &KernelCode, plan: &Plan, settings: &Settings) -> &'static str {
    // Kernels that test no shapes have two forms only.
    let tests_shapes = code.few.0 != code.single.0;
    match (settings.precision, tests_shapes, plan.specialisation.lanes) {
        (Precision::Double, ..) => "f64",
        (_, false, _) | (_, _, 0) => "f32",
        _ if plan.specialisation.few_known != 0 => "few",
        _ => "packet",
    }
}

/// Constants that are not as in the kernel that has everything, or are counts that tests are written out for.
pub(super) fn constants(plan: &Plan) -> Vec<Constant> {
    rows(&plan.specialisation).into_iter().filter(|c| Some(c.value) != c.general).collect()
}

/// All constants that follow from a scene.
fn rows(s: &Specialisation) -> Vec<Constant> {
    let count = |n: u32, what: &str| match n {
        0 => format!("no code for {what}"),
        _ => format!("loops over {what} have a known end"),
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
            if one_by_one { "no walk: tests are written out" } else { "no walk: a loop over all" }.into(),
        ),
        ("smooth_normals", s.smooth_normals, Some(1), "no interpolation, nothing bends back".into()),
        (
            "media_capacity",
            s.media_capacity,
            Some(MEDIA_MAX),
            if s.media_capacity == 0 { "no lists of solids" } else { "shorter lists of solids" }.into(),
        ),
        ("wide_spheres_used", s.wide_spheres_used, Some(1), "no test in double length".into()),
        ("robust", s.robust, Some(1), "no exact rechecks (--precision fast)".into()),
        ("origin_fixed", s.origin_fixed, Some(0), "rays start a fixed way off (--origin)".into()),
        ("branching", s.branching, Some(1), "one ray of a sample at a depth: no sums over several".into()),
        ("survey", s.survey, Some(1), "pixels by rows, no record of paths".into()),
        ("lanes", s.lanes, Some(0), "the lanes of a subgroup work together".into()),
        (
            "stack_size",
            s.stack_size,
            Some(abi::STACK_SIZE),
            "a packet's stack as deep as this hierarchy needs".into(),
        ),
        ("texels", s.texels, Some(0), "loads through texel views".into()),
        ("loose_triangles", s.loose_triangles, Some(0), "few triangles: outside the hierarchy".into()),
        ("loose_spheres", s.loose_spheres, Some(0), "few spheres: outside the hierarchy".into()),
        ("fused", s.fused, Some(0), "one kernel for the stages that work on a ray alone".into()),
        ("few_known", s.few_known, Some(0), "shapes are constants: no loads in their tests".into()),
    ];
    rows.into_iter().map(|(name, value, general, why)| Constant { name, value, general, why }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How work is cut, what the sampler does, and planted defects.
    const SILENT: [&str; 5] = ["workgroup", "loop_cap", "sampler_kind", "replicates", "defect"];

    #[test]
    fn no_constant_is_forgotten() {
        let mut told: Vec<&str> =
            rows(&Specialisation::default()).iter().map(|c| c.name).chain(SILENT).collect();
        let mut all: Vec<&str> = abi::SPECIALISATION.iter().map(|(name, _)| *name).collect();
        told.sort_unstable();
        all.sort_unstable();
        assert_eq!(told, all);
    }
}
