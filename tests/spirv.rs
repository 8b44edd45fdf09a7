//! The compiled kernels, as the build left them: no float operation may be contracted, nothing with
//! unstated rounding is used. lavapipe contracts nothing, so a rendering could not show it.

use whitted::kernel::defects;
use whitted::kernel::spirv::{forbid_contraction, read};
use whitted::kernel::table::{KERNELS, Kernel, KernelSet, Spirv};

const OP_DECORATE: u32 = 71;
const NO_CONTRACTION: u32 = 42;

/// Without the `n`-th NoContraction decoration, or without any.
fn stripped(words: &[u32], which: Option<usize>) -> Vec<u32> {
    let mut out = words[..5].to_vec();
    let (mut at, mut seen) = (5, 0);
    while at < words.len() {
        let length = (words[at] >> 16) as usize;
        let mark = words[at] & 0xffff == OP_DECORATE && words[at + 2] == NO_CONTRACTION;
        if !mark || which.is_some_and(|n| n != seen) {
            out.extend_from_slice(&words[at..at + length]);
        }
        seen += usize::from(mark);
        at += length;
    }
    out
}

#[test]
fn no_kernel_can_be_contracted() {
    for code in &KERNELS {
        for spirv in [code.single, code.double] {
            let module = read(&spirv.words()).unwrap();
            assert_eq!(module.contractible, 0, "{}", code.name);
            assert!(module.banned.is_empty(), "{}: {:?}", code.name, module.banned);
        }
    }
    let intersect = KERNELS.iter().find(|k| k.name == "intersect").unwrap();
    assert!(read(&intersect.single.words()).unwrap().arithmetic > 100, "the reader sees no arithmetic");
}

#[test]
fn one_missing_mark_is_seen() {
    let words = KERNELS.iter().find(|k| k.name == "intersect").unwrap().single.words();
    assert_eq!(read(&stripped(&words, Some(7))).unwrap().contractible, 1);
    let bare = stripped(&words, None);
    let module = read(&bare).unwrap();
    assert_eq!(module.contractible, module.arithmetic);
    assert_eq!(read(&forbid_contraction(&bare)).unwrap().contractible, 0);
}

#[test]
fn a_banned_instruction_is_seen() {
    let mut words = KERNELS[0].single.words();
    // OpDot %1 %2 %3 %4: five words, opcode 148.
    words.extend([5 << 16 | 148, 1, 2, 3, 4]);
    assert_eq!(read(&words).unwrap().banned, ["OpDot"]);
    // OpExtInst %1 %2 %3 Fma %4 %5 %6: eight words, opcode 12, instruction 50.
    words.extend([8 << 16 | 12, 1, 2, 3, 50, 4, 5, 6]);
    assert_eq!(read(&words).unwrap().banned.len(), 2);
}

/// Whether a module has the specialisation constant that chooses a planted mistake.
fn has_mistakes(spirv: Spirv) -> bool {
    const SPEC_ID: u32 = 1;
    let words = spirv.words();
    let mut at = 5;
    while at < words.len() {
        if words[at] & 0xffff == OP_DECORATE && words[at + 2..at + 4] == [SPEC_ID, defects::ID] {
            return true;
        }
        at += (words[at] >> 16) as usize;
    }
    false
}

#[test]
fn shipped_kernels_have_no_planted_mistakes() {
    for code in &KERNELS {
        for spirv in [code.single, code.double, code.packet] {
            assert!(!has_mistakes(spirv), "{}", code.name);
        }
    }
    let planted = KernelSet::planted(defects::Defect::Nothing).code(Kernel::Intersect);
    assert!(has_mistakes(planted.single) && has_mistakes(planted.double) && has_mistakes(planted.packet));
}

#[test]
fn what_is_no_module_is_an_error() {
    assert!(read(&[]).is_err());
    assert!(read(&[1, 2, 3, 4, 5]).is_err());
}
