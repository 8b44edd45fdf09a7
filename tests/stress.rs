//! The extremes: every case passes on the device at every precision it is for, and fails when the
//! mistake it guards against is put back.

use whitted::lab::stress::{Harness, Tracer, Twins, cases};
use whitted::render::Renderer;
use whitted::settings::{DeviceChoice, Precision};

fn renderer() -> Renderer {
    Renderer::new(&DeviceChoice::Cpu).expect("a Vulkan device")
}

fn all_pass(tracer: &mut dyn Tracer, precision: Precision) {
    let mut failed = Vec::new();
    for case in cases() {
        let figure = (case.run)(&mut Harness::new(tracer, precision, None)).expect(case.name);
        if !figure.passes() {
            failed.push(format!("{}: {} > {} {}", case.name, figure.value, figure.bound, figure.unit));
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

/// A case that cannot fail proves nothing. An error counts as failing: it is no silent pass.
#[test]
fn every_case_fails_with_the_mistake_it_guards_against() {
    let mut renderer = renderer();
    let mut blind = Vec::new();
    for case in cases() {
        assert!(!case.guards.is_empty(), "{} guards against nothing", case.name);
        for defect in case.guards {
            let outcome = (case.run)(&mut Harness::new(&mut renderer, Precision::Robust, Some(*defect)));
            if outcome.is_ok_and(|figure| figure.passes()) {
                blind.push(format!("{} passes with {defect:?}", case.name));
            }
        }
    }
    assert!(blind.is_empty(), "{}", blind.join("\n"));
}
