//! Built hierarchies on disk, by what they were built of: a scene that is rendered again finds its own.
//!
//! A file is a header with the key, the nodes of each form that was wanted, the order, and a checksum of all of that.
//! The key is the hash of everything that the tree follows from, and the file's name begins it. A file that is damaged,
//! of another version, or of other primitives under this name, is none: the hierarchy is built and the file written
//! anew.

use super::pairs::Prim;
use super::wide::Form;
use super::{Bvh, CompressedNode, Wanted};
use crate::atomic_file;
use crate::kernel::abi::{LEAF_BIT, LEAF_FIRST_BITS, double, single};
use crate::settings::Hierarchy;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Changes whenever the same primitives may give another tree.
const BUILDER: u32 = 4;
const MAGIC: &[u8; 12] = b"whitted bvh\n";
/// Bytes of a SHA-256.
const CHECKSUM: usize = 32;
/// Place of the numbers, after the magic and the key.
const NUMBERS: usize = 12 + CHECKSUM;
/// Numbers of a file before its nodes, u32 each: builder, nodes, compressed nodes, items, depth, both stacks.
const COUNTS: usize = 7;
/// Bytes of all that.
const HEADER: usize = NUMBERS + 4 * COUNTS;

/// Hash of everything that a tree follows from.
type Key = [u8; CHECKSUM];
/// Bytes that one thread hashes at a time.
const PIECE: usize = 1 << 20;

/// A folder of built hierarchies.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: PathBuf,
    /// Bytes of all files, at most: the least recently used go first.
    limit: u64,
    /// Primitives from which on a hierarchy is kept, by quality.
    least: fn(Hierarchy) -> usize,
}

/// Bytes that the user's cache may take.
const LIMIT: u64 = 1 << 30;

/// Below these, building takes no longer than a file.
fn worth(quality: Hierarchy) -> usize {
    match quality {
        Hierarchy::Balanced => 1 << 17,
        Hierarchy::Best => 1 << 14,
    }
}

impl Cache {
    /// That of the user, beside the compiled kernels; none without a cache folder.
    pub fn of_user() -> Option<Cache> {
        Some(Cache {
            folder: crate::host::cache_folder::path()?.join("hierarchies"),
            limit: LIMIT,
            least: worth,
        })
    }

    /// One in `folder` that holds `limit` bytes and hierarchies of any size.
    pub fn new(folder: &Path, limit: u64) -> Cache {
        Cache { folder: folder.to_owned(), limit, least: |_| 0 }
    }

    /// The file for these primitives, if they are many enough to be worth one. `prims` as they come from
    /// the scene, which tells everything that the tree depends on.
    pub(super) fn file(&self, prims: &[Prim], wanted: &Wanted) -> Option<Entry<'_>> {
        if prims.len() < (self.least)(wanted.quality) {
            return None;
        }
        let mut hash = Sha256::new();
        hash.update(MAGIC);
        hash.update(BUILDER.to_le_bytes());
        let outside = wanted.outside.map(u8::from);
        hash.update([wanted.quality as u8, wanted.forms as u8, outside[0], outside[1]]);
        hash.update(digest(bytemuck::cast_slice(prims)));
        let key: Key = hash.finalize().into();
        let name: String = key.iter().take(16).map(|b| format!("{b:02x}")).collect();
        Some(Entry { cache: self, path: self.folder.join(name), key, items: prims.len() })
    }

    /// Removes the least recently used files until the rest and `more` bytes keep the limit.
    fn make_room(&self, more: u64) {
        let Ok(entries) = fs::read_dir(&self.folder) else { return };
        let mut files: Vec<(SystemTime, u64, PathBuf)> = entries
            .filter_map(|entry| {
                let entry = entry.ok()?;
                let about = entry.metadata().ok()?;
                Some((about.modified().ok()?, about.len(), entry.path()))
            })
            .collect();
        files.sort();
        let mut total = more + files.iter().map(|f| f.1).sum::<u64>();
        for (_, bytes, path) in files {
            if total <= self.limit {
                break;
            }
            // What another process removed first is gone as well.
            drop(fs::remove_file(path));
            total -= bytes;
        }
    }
}

/// Where the hierarchy of certain primitives is kept.
pub(super) struct Entry<'a> {
    cache: &'a Cache,
    path: PathBuf,
    key: Key,
    items: usize,
}

impl Entry<'_> {
    /// The hierarchy, if there is one and it is whole.
    pub fn load(&self) -> Option<Bvh> {
        let about = fs::metadata(&self.path).ok()?;
        // A pipe would wait for its writer; what is larger than the cache was not written here.
        if !about.is_file() || about.len() > self.cache.limit {
            return None;
        }
        let bytes = fs::read(&self.path).ok()?;
        let bvh = decode(&bytes, &self.key, self.items)?;
        if let Ok(file) = fs::File::open(&self.path) {
            // It was used now; if that cannot be noted, it goes a little sooner.
            drop(file.set_modified(SystemTime::now()));
        }
        Some(bvh)
    }

    /// Keeps it. Failing to is no failure of the render.
    pub fn store(&self, bvh: &Bvh) {
        let bytes = encode(bvh, &self.key);
        if bytes.len() as u64 > self.cache.limit || fs::create_dir_all(&self.cache.folder).is_err() {
            return;
        }
        self.cache.make_room(bytes.len() as u64);
        // A file that a power cut leaves half written fails its checksum: no need to wait for the disk.
        drop(atomic_file::write_unsynced(&self.path, &bytes));
    }
}

/// SHA-256 of the SHA-256 of each piece.
fn digest(bytes: &[u8]) -> [u8; CHECKSUM] {
    let pieces: Vec<[u8; CHECKSUM]> = bytes.par_chunks(PIECE).map(|p| Sha256::digest(p).into()).collect();
    let mut hash = Sha256::new();
    hash.update((bytes.len() as u64).to_le_bytes());
    pieces.iter().for_each(|p| hash.update(p));
    hash.finalize().into()
}

fn encode(bvh: &Bvh, key: &Key) -> Vec<u8> {
    let node = size_of::<single::Node>();
    let compressed_at = HEADER + node * bvh.nodes.len();
    let compressed: &[u8] = bytemuck::cast_slice(&bvh.compressed);
    let order_at = compressed_at + compressed.len();
    let mut bytes = vec![0; order_at + 4 * bvh.order.len() + CHECKSUM];
    bytes[..12].copy_from_slice(MAGIC);
    bytes[12..NUMBERS].copy_from_slice(key);
    let (nodes, packed) = (bvh.nodes.len(), bvh.compressed.len());
    let counts = [nodes, packed, bvh.order.len(), bvh.depth, bvh.stack, bvh.packet_stack].map(|n| n as u32);
    for (out, count) in bytes[NUMBERS..HEADER].chunks_exact_mut(4).zip([BUILDER].iter().chain(&counts)) {
        out.copy_from_slice(&count.to_le_bytes());
    }
    let write = |(out, wide): (&mut [u8], &double::Node)| {
        // Boxes are those of f32 numbers.
        out.copy_from_slice(bytemuck::bytes_of(&single::Node::from(wide)));
    };
    bytes[HEADER..compressed_at].par_chunks_exact_mut(node).zip(&bvh.nodes).for_each(write);
    bytes[compressed_at..order_at].copy_from_slice(compressed);
    let end = bytes.len() - CHECKSUM;
    bytes[order_at..end].copy_from_slice(bytemuck::cast_slice(&bvh.order));
    let sum = digest(&bytes[..end]);
    bytes[end..].copy_from_slice(&sum);
    bytes
}

/// The hierarchy of `items` primitives in a file's `bytes`; `None` if they are damaged, or of another key.
pub fn decode(bytes: &[u8], key: &[u8; CHECKSUM], items: usize) -> Option<Bvh> {
    let (content, sum) = bytes.split_at_checked(bytes.len().checked_sub(CHECKSUM)?)?;
    if content.len() < HEADER || !content.starts_with(MAGIC) || content[12..NUMBERS] != key[..] {
        return None;
    }
    let count = |i: usize| {
        let at = NUMBERS + 4 * i;
        content[at..at + 4].try_into().map(|b| u32::from_le_bytes(b) as usize).ok()
    };
    let (nodes, compressed, order) = (count(1)?, count(2)?, count(3)?);
    let (node, packed) = (size_of::<single::Node>(), size_of::<CompressedNode>());
    let length = [(node, nodes), (packed, compressed), (4, order)].map(|(size, n)| size as u64 * n as u64);
    let length = HEADER as u64 + length.iter().sum::<u64>();
    if count(0)? != BUILDER as usize || order != items || length != content.len() as u64 {
        return None;
    }
    if digest(content) != sum {
        return None;
    }
    let (single_nodes, rest) = content[HEADER..].split_at(node * nodes);
    let (compressed_nodes, numbers) = rest.split_at(packed * compressed);
    let wide = |bytes: &[u8]| widened(&bytemuck::pod_read_unaligned::<single::Node>(bytes));
    let bvh = Bvh {
        nodes: single_nodes.par_chunks_exact(node).map(wide).collect(),
        compressed: compressed_nodes.par_chunks_exact(packed).map(bytemuck::pod_read_unaligned).collect(),
        order: numbers.par_chunks_exact(4).map(bytemuck::pod_read_unaligned).collect(),
        depth: count(4)?,
        stack: count(5)?,
        packet_stack: count(6)?,
    };
    let whole = is_sound(&bvh.nodes, items) && is_sound(&bvh.compressed, items);
    (nodes + compressed > 0 && whole).then_some(bvh)
}

/// True if every link leads on to a node or to items that there are.
fn is_sound<N: Form + Sync>(nodes: &[N], items: usize) -> bool {
    let sound = |link: u32, at: usize| {
        if link & LEAF_BIT == 0 {
            return (at + 1..nodes.len()).contains(&(link as usize));
        }
        let first = (link & ((1 << LEAF_FIRST_BITS) - 1)) as usize;
        let last = first + ((link & !LEAF_BIT) >> LEAF_FIRST_BITS) as usize;
        last < items
    };
    nodes.par_iter().enumerate().all(|(at, n)| n.children().all(|(link, ..)| sound(link, at)))
}

fn widened(n: &single::Node) -> double::Node {
    let wide = |p: [f32; 3]| p.map(f64::from);
    double::Node {
        lo_0: wide(n.lo_0),
        hi_0: wide(n.hi_0),
        lo_1: wide(n.lo_1),
        hi_1: wide(n.hi_1),
        lo_2: wide(n.lo_2),
        hi_2: wide(n.hi_2),
        lo_3: wide(n.lo_3),
        hi_3: wide(n.hi_3),
        child_0: n.child_0,
        child_1: n.child_1,
        child_2: n.child_2,
        child_3: n.child_3,
    }
}
