//! Reads back from SPIR-V what host and kernels must agree on, and marks float arithmetic
//! `NoContraction`. Shared by `build.rs` and the tests. Opcode numbers: SPIR-V specification 1.6,
//! section 3.

use std::collections::{BTreeMap, BTreeSet};

const MAGIC: u32 = 0x0723_0203;
const HEADER_WORDS: usize = 5;

/// Opcodes read here.
mod op {
    pub const NAME: u16 = 5;
    pub const MEMBER_NAME: u16 = 6;
    pub const EXT_INST: u16 = 12;
    pub const TYPE_STRUCT: u16 = 30;
    pub const VARIABLE: u16 = 59;
    pub const DECORATE: u16 = 71;
    pub const MEMBER_DECORATE: u16 = 72;
    pub const DOT: u16 = 148;
    /// OpFNegate needs no mark: it is exact. FAdd, FSub, FMul, FDiv.
    pub const FLOAT_ARITHMETIC: [u16; 4] = [129, 131, 133, 136];
    pub const FMOD: u16 = 141;
    pub const VECTOR_TIMES_SCALAR: u16 = 142;
    pub const MATRIX_OPS: std::ops::RangeInclusive<u16> = 143..=147;
}

/// Decorations read here.
mod decoration {
    pub const NON_WRITABLE: u32 = 24;
    pub const NON_READABLE: u32 = 25;
    pub const BINDING: u32 = 33;
    pub const OFFSET: u32 = 35;
    pub const NO_CONTRACTION: u32 = 42;
}

const STORAGE_CLASS_UNIFORM_CONSTANT: u32 = 0;
const STORAGE_CLASS_STORAGE_BUFFER: u32 = 12;

/// GLSL.std.450 instructions whose roundings no one states, so that the numeric core may not use
/// them: 46 FMix, 50 Fma, 66 Length, 67 Distance, 68 Cross, 69 Normalize, 71 Reflect,
/// 72 Refract (numbers of the extended instruction set specification).
const BANNED_EXT_INST: [u32; 8] = [46, 50, 66, 67, 68, 69, 71, 72];

/// How a kernel uses one storage buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// Binding number in set 0.
    pub binding: u32,
    /// The kernel may load from it.
    pub reads: bool,
    /// The kernel may store to it.
    pub writes: bool,
}

/// What a module says of itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Module {
    /// Storage buffers, by binding number.
    pub bindings: Vec<Binding>,
    /// Texel buffers, by binding number.
    pub texels: Vec<u32>,
    /// Byte offsets of struct members, by struct name: (member name, offset).
    pub structs: BTreeMap<String, Vec<(String, u32)>>,
    /// Float arithmetic without `NoContraction`.
    pub contractible: usize,
    /// Float arithmetic in all.
    pub arithmetic: usize,
    /// Instructions that the numeric core may not use, by name.
    pub banned: Vec<String>,
}

fn instructions(words: &[u32]) -> impl Iterator<Item = (u16, &[u32])> {
    let mut at = HEADER_WORDS;
    std::iter::from_fn(move || {
        let head = *words.get(at)?;
        let (code, length) = ((head & 0xffff) as u16, (head >> 16) as usize);
        let operands = words.get(at + 1..at + length)?;
        at += length.max(1);
        Some((code, operands))
    })
}

fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).take_while(|b| *b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn is_marked_arithmetic(code: u16) -> bool {
    op::FLOAT_ARITHMETIC.contains(&code) || code == op::VECTOR_TIMES_SCALAR
}

/// Reads a module. Struct and member names are there only if it was compiled with debug information.
pub fn read(words: &[u32]) -> Result<Module, String> {
    if words.first() != Some(&MAGIC) {
        return Err("not a SPIR-V module".into());
    }
    let mut names: BTreeMap<u32, String> = BTreeMap::new();
    let mut member_names: BTreeMap<(u32, u32), String> = BTreeMap::new();
    let mut offsets: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut member_flags: BTreeSet<(u32, u32)> = BTreeSet::new();
    let mut bindings: BTreeMap<u32, u32> = BTreeMap::new();
    let mut flags: BTreeSet<(u32, u32)> = BTreeSet::new();
    let mut structs: Vec<(u32, usize)> = Vec::new();
    let mut pointers: BTreeMap<u32, u32> = BTreeMap::new();
    let mut variables: Vec<(u32, u32)> = Vec::new();
    let mut images: Vec<u32> = Vec::new();
    let mut module = Module::default();
    let mut marked: BTreeSet<u32> = BTreeSet::new();
    for (code, o) in instructions(words) {
        match code {
            op::NAME => drop(names.insert(o[0], text(&o[1..]))),
            op::MEMBER_NAME => drop(member_names.insert((o[0], o[1]), text(&o[2..]))),
            op::TYPE_STRUCT => structs.push((o[0], o.len() - 1)),
            32 => drop(pointers.insert(o[0], o[2])),
            op::VARIABLE if o[2] == STORAGE_CLASS_STORAGE_BUFFER => variables.push((o[1], o[0])),
            op::VARIABLE if o[2] == STORAGE_CLASS_UNIFORM_CONSTANT => images.push(o[1]),
            op::DECORATE if o[1] == decoration::BINDING => drop(bindings.insert(o[0], o[2])),
            op::DECORATE if o[1] == decoration::NO_CONTRACTION => drop(marked.insert(o[0])),
            op::DECORATE => drop(flags.insert((o[0], o[1]))),
            op::MEMBER_DECORATE if o[2] == decoration::OFFSET => drop(offsets.insert((o[0], o[1]), o[3])),
            op::MEMBER_DECORATE => drop(member_flags.insert((o[0], o[2]))),
            _ => {}
        }
    }
    for (code, o) in instructions(words) {
        if is_marked_arithmetic(code) {
            module.arithmetic += 1;
            module.contractible += usize::from(!marked.contains(&o[1]));
        }
        match code {
            op::DOT => module.banned.push("OpDot".into()),
            op::FMOD => module.banned.push("OpFMod".into()),
            c if op::MATRIX_OPS.contains(&c) => module.banned.push(format!("matrix op {c}")),
            op::EXT_INST if BANNED_EXT_INST.contains(&o[3]) => {
                module.banned.push(format!("GLSL.std.450 instruction {}", o[3]));
            }
            _ => {}
        }
    }
    for (id, members) in structs {
        let Some(name) = names.get(&id).filter(|n| !n.is_empty()) else { continue };
        let fields: Vec<(String, u32)> = (0..members as u32)
            .filter_map(|m| Some((member_names.get(&(id, m))?.clone(), *offsets.get(&(id, m))?)))
            .collect();
        if fields.len() == members && members > 0 {
            module.structs.insert(name.clone(), fields);
        }
    }
    for (variable, pointer) in variables {
        let Some(&binding) = bindings.get(&variable) else { continue };
        let block = pointers.get(&pointer).copied().unwrap_or_default();
        let has = |d| flags.contains(&(variable, d)) || member_flags.contains(&(block, d));
        module.bindings.push(Binding {
            binding,
            reads: !has(decoration::NON_READABLE),
            writes: !has(decoration::NON_WRITABLE),
        });
    }
    module.bindings.sort_by_key(|b| b.binding);
    module.texels = images.iter().filter_map(|v| bindings.get(v).copied()).collect();
    Ok(module)
}

/// Decorates every float addition, subtraction, multiplication and division `NoContraction`, so that
/// no driver may fuse them: GLSL's `precise` stops at function borders (numerics.md, Contraction).
pub fn forbid_contraction(words: &[u32]) -> Vec<u32> {
    let mut marked = BTreeSet::new();
    let mut wanted = Vec::new();
    // Decorations come before the first type declaration; OpTypeVoid (19) .. OpTypeForwardPointer (39).
    let mut at = HEADER_WORDS;
    let mut first_type = None;
    while at < words.len() {
        let (code, length) = ((words[at] & 0xffff) as u16, (words[at] >> 16) as usize);
        if first_type.is_none() && (19..=39).contains(&code) {
            first_type = Some(at);
        }
        if code == op::DECORATE && words[at + 2] == decoration::NO_CONTRACTION {
            marked.insert(words[at + 1]);
        }
        if is_marked_arithmetic(code) {
            wanted.push(words[at + 2]);
        }
        at += length.max(1);
    }
    let split = first_type.unwrap_or(words.len());
    let mut out = words[..split].to_vec();
    for id in wanted.into_iter().filter(|id| !marked.contains(id)) {
        out.extend([3 << 16 | u32::from(op::DECORATE), id, decoration::NO_CONTRACTION]);
    }
    out.extend_from_slice(&words[split..]);
    out
}
