//! `glsl/kernels.pack`: the compiled kernels as they travel with the package, for machines without libshaderc.
//!
//! A text head, an empty line, a zlib stream. The head names the digest of the sources and the tools. The stream
//! holds a manifest, which gives what `spirv::read` found in each module before the optimiser took its names away,
//! and the SPIR-V: each operand as its difference from the operand at that place of the last instruction with the
//! same opcode and length, in variable-length bytes, sorted by place. zlib alone leaves 28 % of the SPIR-V's bytes,
//! this leaves 8 %.

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
    let mut manifest = String::new();
    let mut streams: [Vec<u8>; STREAMS] = Default::default();
    for k in kernels {
        encode(&k.words, &mut streams).ok_or_else(|| format!("{}.{}: not SPIR-V", k.kernel, k.form))?;
        let _ = writeln!(manifest, "kernel {} {} {}", k.kernel, k.form, k.words.len());
        for b in &k.module.bindings {
            let _ = writeln!(manifest, "binding {} {} {}", b.binding, b.reads, b.writes);
        }
        for binding in &k.module.texels {
            let _ = writeln!(manifest, "texels {binding}");
        }
        for (name, fields) in &k.module.structs {
            let fields = fields.iter().map(|(field, offset)| format!(" {field} {offset}"));
            let _ = writeln!(manifest, "struct {name}{}", fields.collect::<String>());
        }
    }
    let lengths = [manifest.len()].into_iter().chain(streams.iter().map(Vec::len));
    let lengths: Vec<String> = lengths.map(|n| n.to_string()).collect();
    let head = format!("{FIRST_LINE}\nsources {digest}\ntools {tools}\nlengths {}\n\n", lengths.join(" "));
    let content = [manifest.into_bytes(), streams.concat()].concat();
    let level = miniz_oxide::deflate::CompressionLevel::BestCompression as u8;
    Ok([head.into_bytes(), miniz_oxide::deflate::compress_to_vec_zlib(&content, level)].concat())
}

/// Reads a pack. A pack that is cut short or whose stream is damaged is an error.
pub fn read(bytes: &[u8]) -> Result<Pack, String> {
    let end = bytes.windows(2).position(|w| w == b"\n\n").ok_or("no head")?;
    let head = std::str::from_utf8(&bytes[..end]).map_err(|e| e.to_string())?;
    let mut lines = head.lines();
    if lines.next() != Some(FIRST_LINE) {
        return Err("not a pack of kernels of this version".into());
    }
    let mut line = |key: &str| {
        let line = lines.next().and_then(|line| line.strip_prefix(key)?.strip_prefix(' '));
        line.ok_or_else(|| format!("no line `{key}`"))
    };
    let (digest, tools) = (line("sources")?.to_owned(), line("tools")?.to_owned());
    let lengths: Result<Vec<usize>, _> = line("lengths")?.split(' ').map(str::parse).collect();
    let lengths = lengths.map_err(|e| format!("lengths: {e}"))?;
    let content =
        miniz_oxide::inflate::decompress_to_vec_zlib(&bytes[end + 2..]).map_err(|e| e.to_string())?;
    if lengths.len() != 1 + STREAMS || lengths.iter().sum::<usize>() != content.len() {
        return Err("the lengths do not add up".into());
    }
    let (manifest, mut rest) = content.split_at(lengths[0]);
    let mut streams = [rest; STREAMS];
    for (stream, length) in streams.iter_mut().zip(&lengths[1..]) {
        (*stream, rest) = rest.split_at(*length);
    }
    let mut kernels = Vec::new();
    for line in std::str::from_utf8(manifest).map_err(|e| e.to_string())?.lines() {
        read_line(line, &mut kernels, &mut streams).ok_or_else(|| format!("line {line:?}"))?;
    }
    Ok(Pack { digest, tools, kernels })
}

/// A line of the manifest: a new kernel with its words, or a fact about the last one.
fn read_line(line: &str, kernels: &mut Vec<Compiled>, streams: &mut [&[u8]; STREAMS]) -> Option<()> {
    let tokens: Vec<&str> = line.split(' ').collect();
    let module = kernels.last_mut().map(|k| &mut k.module);
    match (tokens.as_slice(), module) {
        (["kernel", kernel, form, count], _) => {
            let words = decode(count.parse().ok()?, streams)?;
            let (kernel, form) = ((*kernel).to_owned(), (*form).to_owned());
            kernels.push(Compiled { kernel, form, module: spirv::Module::default(), words });
        }
        (["binding", binding, reads, writes], Some(module)) => module.bindings.push(Binding {
            binding: binding.parse().ok()?,
            reads: reads.parse().ok()?,
            writes: writes.parse().ok()?,
        }),
        (["texels", binding], Some(module)) => module.texels.push(binding.parse().ok()?),
        (["struct", name, fields @ ..], Some(module)) => {
            let field = |f: &[&str]| Some((f[0].to_owned(), f.get(1)?.parse().ok()?));
            let fields: Option<_> = fields.chunks(2).map(field).collect();
            module.structs.insert((*name).to_owned(), fields?);
        }
        _ => return None,
    }
    Some(())
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
