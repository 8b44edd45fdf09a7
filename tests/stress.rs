//! The extremes: every case passes on the device at every precision it is for, and fails when the
//! mistake it guards against is put back.

use whitted::kernel::defects::Defect::{self, *};
use whitted::lab::stress::{Harness, Tracer, Twins, cases};
use whitted::render::Renderer;
use whitted::settings::{DeviceChoice, Origin, Precision};

/// Planted mistakes that make a case fail.
const GUARDS: &[(&str, &[Defect])] = &[
    ("scale", &[WorldFrame]),
    ("offset", &[WorldFrame]),
    ("far-body", &[OneFrame]),
    ("wide-ground", &[OneFrame, Uncut]),
    ("ball-as-ground", &[OneFrame]),
    ("far-light", &[OneFrame, Uncut]),
    ("long-lens", &[OneFrame]),
    ("two-scales-in-mirrors", &[OneFrame, Uncut]),
    ("two-scales-in-glass", &[OneFrame, Uncut]),
    ("watertight", &[MoellerTrumbore]),
    ("far-watertight", &[MoellerTrumbore]),
    ("seams", &[MoellerTrumbore]),
    ("flat-boxes", &[NarrowSlab]),
    ("sphere-distance", &[NaiveQuadratic]),
    ("sphere-planet", &[NoWide]),
    ("sphere-roots", &[SmallerRoot]),
    ("sphere-rim", &[NaiveQuadratic]),
    ("sphere-reintersect", &[NoIdentity]),
    ("silhouette", &[EyeOrigin]),
    ("horizon", &[NoWide]),
    ("planet-shadow", &[NoWide]),
    ("concentric", &[NoOffset]),
    ("acne", &[WorldFrame]),
    ("triangle-reintersect", &[NoIdentity, NoOffset]),
    ("mirror-box", &[WorldFrame]),
    ("below-surface", &[BelowSurface]),
    ("corner-escape", &[NoInset]),
    ("dark-room", &[NoInset]),
    ("light-at-surface", &[LightContact]),
    ("light-on-ceiling", &[ToTheLight]),
    ("hierarchy", &[Unconfined]),
    ("axis-rays", &[Octant]),
    ("no-extent", &[KeepDegenerate]),
    ("unusable-rays", &[NanAccepted]),
    ("nested", &[ShortStack]),
    ("equal-indices", &[EqualIndices]),
    ("critical-angle", &[ClampedCritical]),
    ("snell", &[FlippedEta, CosineForm]),
    ("fresnel", &[SchlickInside]),
    ("thin-sheet", &[SchlickInside]),
    ("slab", &[FlippedEta]),
    ("ball-lens", &[SmallerRoot, FlippedEta]),
    ("nested-media", &[OneMedium, NoPriority]),
    ("eye-in-solids", &[EyeInAir]),
    ("shells", &[SilentMedia]),
    ("inverse-square", &[WorldFrame]),
    ("light-contact", &[LightContact]),
    ("light-segment", &[ShadowBeyond]),
    ("constant-image", &[NaiveSum]),
    ("facing-mirrors", &[Bailout]),
    ("furnace", &[Bailout, SmallerRoot]),
    ("mirror-ball-centre", &[SmallerRoot]),
    ("normals-that-cancel", &[BlindNormalise]),
    ("field-of-view", &[EyeOrigin]),
    ("eye-places", &[LightContact]),
    ("tiny-triangles", &[MoellerTrumbore]),
    ("slivers", &[MoellerTrumbore]),
    ("no-area", &[KeepDegenerate]),
    ("in-plane", &[Octant]),
    ("hit-point", &[WorldFrame]),
    ("huge-coordinates", &[WorldFrame]),
    ("coincident", &[TraversalTies]),
    ("order", &[TraversalTies]),
    ("needles", &[ForgottenStack]),
    ("overlapping-boxes", &[ForgottenStack]),
    ("fan", &[ForgottenStack]),
    ("stacked-triangles", &[ForgottenHit]),
    ("hair-and-lights", &[ForgottenShadow]),
];

/// Cases that fail where rays start 0.1 of the user's units along their way and may hit what they left.
const GUARDS_OF_ORIGIN: &[&str] =
    &["planet-shadow", "touching", "huge-and-tiny", "mirror-box", "contact-shadow", "thin-gap", "dark-room"];

fn renderer() -> Renderer {
    Renderer::new(&DeviceChoice::Cpu).expect("a Vulkan device")
}

fn all_pass(tracer: &mut dyn Tracer, precision: Precision) {
    let mut failed = Vec::new();
    for case in cases() {
        let figure = (case.run)(&mut Harness::new(tracer, precision)).expect(case.name);
        if !figure.passes() {
            failed.push(format!("{}: {figure}", case.name));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn every_case_passes_on_the_device() {
    all_pass(&mut renderer(), Precision::Robust);
}

#[test]
fn every_case_passes_in_double_precision() {
    all_pass(&mut renderer(), Precision::Double);
}

#[test]
fn every_case_passes_on_the_twins() {
    all_pass(&mut Twins::default(), Precision::Robust);
}

/// Half the vector width: a subgroup of 4 in place of 8.
#[test]
fn every_case_passes_with_a_subgroup_of_four() {
    let out = std::process::Command::new(env!("CARGO_BIN_EXE_whitted"))
        .args(["stress", "--device", "cpu"])
        .env("LP_NATIVE_VECTOR_WIDTH", "128")
        // Code compiled for other vectors must not come from a cache.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .output()
        .expect("the program runs");
    assert!(
        out.status.success(),
        "{}{}",
        String::from_utf8_lossy(&out.stdout),
        String::from_utf8_lossy(&out.stderr)
    );
}

#[test]
fn every_case_has_a_name_of_its_own() {
    let mut names: Vec<&str> = cases().iter().map(|c| c.name).collect();
    names.sort_unstable();
    let count = names.len();
    names.dedup();
    assert_eq!(names.len(), count);
}

fn passes(name: &str, harness: &mut Harness<'_>) -> bool {
    let case = cases().into_iter().find(|c| c.name == name).expect(name);
    (case.run)(harness).is_ok_and(|figure| figure.passes())
}

#[test]
fn every_case_guards_against_something() {
    for case in cases() {
        let guards = GUARDS.iter().any(|(name, defects)| *name == case.name && !defects.is_empty());
        assert!(guards || GUARDS_OF_ORIGIN.contains(&case.name), "{}", case.name);
    }
}

/// A case that cannot fail proves nothing. An error counts as failing: it is no silent pass.
#[test]
fn every_case_fails_with_the_mistake_it_guards_against() {
    let mut renderer = renderer();
    let mut blind = Vec::new();
    for (name, defects) in GUARDS {
        for defect in *defects {
            renderer.plant(*defect);
            if passes(name, &mut Harness::new(&mut renderer, Precision::Robust)) {
                blind.push(format!("{name} passes with {defect:?}"));
            }
        }
    }
    renderer.plant(Nothing);
    for name in GUARDS_OF_ORIGIN {
        let mut harness = Harness::new(&mut renderer, Precision::Robust);
        harness.origin = Origin::Fixed(0.1);
        if passes(name, &mut harness) {
            blind.push(format!("{name} passes with a fixed origin"));
        }
    }
    assert!(blind.is_empty(), "{}", blind.join("\n"));
}
