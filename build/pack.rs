//! `glsl/kernels.pack`: the compiled kernels as they travel with the package, for machines without libshaderc.
//!
//! A text head, an empty line, a zlib stream. The head names the digest of the sources, the tools, and what
//! `spirv::read` found in each module before the optimiser took its names away. The stream holds the SPIR-V: each
//! operand as its difference from the operand at that place of the last instruction with the same opcode and
//! length, in variable-length bytes, sorted by place. zlib alone makes 28 % of the kernels, this makes 8 %.

use crate::spirv::{self, Binding};
use std::collections::HashMap;
use std::fmt::Write as _;

/// Where the package keeps it.
pub const FILE: &str = "glsl/kernels.pack";

const FIRST_LINE: &str = "whitted kernels 1";
const HEADER_WORDS: usize = 5;
/// Instruction heads, first operands, second operands, all other operands.
const STREAMS: usize = 4;

/// One kernel in one form.
#[derive(Debug, Clone, PartialEq)]
pub struct Compiled {
    /// Name of the kernel.
    pub kernel: String,
    /// Name of the form.
    pub form: String,
    /// Layouts and buffers, read before the optimiser took the names away.
    pub module: spirv::Module,
    /// SPIR-V, optimised.
    pub words: Vec<u32>,
}

/// The content of a pack.
pub struct Pack {
    /// SHA-256 of the sources it was made from, hexadecimal.
    pub digest: String,
    /// Versions of the compilers.
    pub tools: String,
    /// Kernels and forms in the order of compilation.
    pub kernels: Vec<Compiled>,
}

/// The bytes of a pack.
pub fn write(digest: &str, tools: &str, kernels: &[Compiled]) -> Result<Vec<u8>, String> {
    let mut head = format!("{FIRST_LINE}\nsources {digest}\ntools {tools}\n");
    let mut streams: [Vec<u8>; STREAMS] = Default::default();
    for k in kernels {
        encode(&k.words, &mut streams).ok_or_else(|| format!("{}.{}: not SPIR-V", k.kernel, k.form))?;
        let _ = writeln!(head, "kernel {} {} {}", k.kernel, k.form, k.words.len());
        for b in &k.module.bindings {
            let _ = writeln!(head, "binding {} {} {}", b.binding, b.reads, b.writes);
        }
        for binding in &k.module.texels {
            let _ = writeln!(head, "texels {binding}");
        }
        for (name, fields) in &k.module.structs {
            let fields = fields.iter().map(|(field, offset)| format!(" {field} {offset}"));
            let _ = writeln!(head, "struct {name}{}", fields.collect::<String>());
        }
    }
    head.push_str("streams");
    streams.iter().for_each(|s| _ = write!(head, " {}", s.len()));
    head.push_str("\n\n");
    let level = miniz_oxide::deflate::CompressionLevel::BestCompression as u8;
    Ok([head.into_bytes(), miniz_oxide::deflate::compress_to_vec_zlib(&streams.concat(), level)].concat())
}

/// Reads a pack. A pack that is cut short or whose stream is damaged is an error.
pub fn read(bytes: &[u8]) -> Result<Pack, String> {
    let end = bytes.windows(2).position(|w| w == b"\n\n").ok_or("no head")?;
    let head = std::str::from_utf8(&bytes[..end]).map_err(|e| e.to_string())?;
    let content = miniz_oxide::inflate::decompress_to_vec_zlib(&bytes[end + 2..]).map_err(|e| e.to_string())?;
    let mut lines = head.lines();
    if lines.next() != Some(FIRST_LINE) {
        return Err("not a pack of kernels of this version".into());
    }
    let mut pack = Pack { digest: String::new(), tools: String::new(), kernels: Vec::new() };
    let mut counts = Vec::new();
    let mut lengths = Vec::new();
    for line in lines {
        let tokens: Vec<&str> = line.split(' ').collect();
        let wrong = || format!("line {line:?}");
        let number = |text: &str| text.parse::<usize>().map_err(|_| wrong());
        let module = pack.kernels.last_mut().map(|k| &mut k.module);
        match (tokens.as_slice(), module) {
            (["sources", digest], _) => pack.digest = (*digest).to_owned(),
            (["tools", tools @ ..], _) => pack.tools = tools.join(" "),
            (["kernel", kernel, form, count], _) => {
                let (kernel, form) = ((*kernel).to_owned(), (*form).to_owned());
                pack.kernels.push(Compiled { kernel, form, module: spirv::Module::default(), words: Vec::new() });
                counts.push(number(count)?);
            }
            (["binding", binding, reads, writes], Some(module)) => module.bindings.push(Binding {
                binding: number(binding)? as u32,
                reads: reads.parse().map_err(|_| wrong())?,
                writes: writes.parse().map_err(|_| wrong())?,
            }),
            (["texels", binding], Some(module)) => module.texels.push(number(binding)? as u32),
            (["struct", name, fields @ ..], Some(module)) => {
                let fields: Result<_, String> = fields
                    .chunks(2)
                    .map(|f| Ok((f[0].to_owned(), number(f.get(1).ok_or_else(wrong)?)? as u32)))
                    .collect();
                module.structs.insert((*name).to_owned(), fields?);
            }
            (["streams", all @ ..], _) => lengths = all.iter().map(|n| number(n)).collect::<Result<_, _>>()?,
            _ => return Err(wrong()),
        }
    }
    let mut rest = content.as_slice();
    let mut streams = [rest; STREAMS];
    if lengths.len() != STREAMS || lengths.iter().sum::<usize>() != rest.len() {
        return Err("lengths of the streams".into());
    }
    for (stream, length) in streams.iter_mut().zip(lengths) {
        (*stream, rest) = rest.split_at(length);
    }
    for (kernel, count) in pack.kernels.iter_mut().zip(counts) {
        kernel.words = decode(count, &mut streams)
            .ok_or_else(|| format!("{}.{}: damaged", kernel.kernel, kernel.form))?;
    }
    Ok(pack)
}

fn put(stream: &mut Vec<u8>, mut value: u32) {
    while value >= 0x80 {
        stream.push(value as u8 | 0x80);
        value >>= 7;
    }
    stream.push(value as u8);
}

fn take(stream: &mut &[u8]) -> Option<u32> {
    let mut value = 0;
    for shift in (0..32).step_by(7) {
        let (&byte, rest) = stream.split_first()?;
        *stream = rest;
        value |= u32::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

/// Appends a module to the streams. None if instruction lengths do not add up.
fn encode(words: &[u32], streams: &mut [Vec<u8>; STREAMS]) -> Option<()> {
    let (header, mut rest) = words.split_at_checked(HEADER_WORDS)?;
    header.iter().for_each(|word| put(&mut streams[0], *word));
    let mut last: HashMap<u32, &[u32]> = HashMap::new();
    while let Some(&head) = rest.first() {
        let (instruction, after) = rest.split_at_checked((head >> 16) as usize)?;
        let operands = instruction.get(1..)?;
        put(&mut streams[0], head.rotate_left(16));
        let before = last.insert(head, operands);
        for (i, &word) in operands.iter().enumerate() {
            let step = word.wrapping_sub(before.map_or(0, |b| b[i])) as i32;
            put(&mut streams[(1 + i).min(STREAMS - 1)], (step << 1 ^ step >> 31) as u32);
        }
        rest = after;
    }
    Some(())
}

/// Takes a module of `count` words from the streams.
fn decode(count: usize, streams: &mut [&[u8]; STREAMS]) -> Option<Vec<u32>> {
    let mut words = Vec::new();
    for _ in 0..HEADER_WORDS {
        words.push(take(&mut streams[0])?);
    }
    let mut last: HashMap<u32, usize> = HashMap::new();
    while words.len() < count {
        let head = take(&mut streams[0])?.rotate_right(16);
        words.push(head);
        let at = words.len();
        let before = last.insert(head, at);
        for i in 0..((head >> 16) as usize).checked_sub(1)? {
            let folded = take(&mut streams[(1 + i).min(STREAMS - 1)])?;
            let step = (folded >> 1) ^ (folded & 1).wrapping_neg();
            words.push(before.map_or(0, |b| words[b + i]).wrapping_add(step));
        }
    }
    (words.len() == count).then_some(words)
}
