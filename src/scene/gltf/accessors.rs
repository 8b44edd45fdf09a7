//! Accessors: typed numbers in a buffer, with strides, sparse changes and normalised integers, as f64.

use super::buffers::{Buffers, missing};
use super::json::{Accessor, Root};
use crate::scene::error::SceneError;
use crate::scene::model_file::{ModelFile, shown};

/// Most elements of an accessor that has no bytes of its own (all zero, or sparse): nothing else bounds them.
const MOST_ZEROS: usize = 1 << 24;

/// Component types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Component> {
        Some(match code {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The number in `b`, which has as many bytes as [`Component::size`]; normalised integers by the specification's
    /// section 3.11.
    fn number(self, b: &[u8], normalized: bool) -> f64 {
        let (number, greatest) = match self {
            Component::I8 => (f64::from(b[0] as i8), 127.0),
            Component::U8 => (f64::from(b[0]), 255.0),
            Component::I16 => (f64::from(i16::from_le_bytes([b[0], b[1]])), 32_767.0),
            Component::U16 => (f64::from(u16::from_le_bytes([b[0], b[1]])), 65_535.0),
            Component::U32 => (f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4_294_967_295.0),
            Component::F32 => return f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        };
        if normalized { (number / greatest).max(-1.0) } else { number }
    }
}

/// Numbers of one element of a type.
fn width(kind: &str) -> Option<usize> {
    Some(match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => return None,
    })
}

/// Reads accessors of one document.
pub struct Accessors<'a, 'r> {
    pub file: ModelFile<'a>,
    pub root: &'r Root,
    pub buffers: Buffers<'a>,
}

impl<'r> Accessors<'_, 'r> {
    /// The elements of accessor `index`, each of `N` numbers; `what` says what they are, for messages. Elements of
    /// `N` + 1 numbers lose the last if `cut` (the alpha of colours).
    pub fn vectors<const N: usize>(
        &mut self,
        index: usize,
        what: &str,
        cut: bool,
    ) -> Result<Vec<[f64; N]>, SceneError> {
        let (accessor, component, width) = self.accessor(index, what)?;
        if width != N && !(cut && width == N + 1) {
            return Err(self.wrong(index, what, &format!("has the type `{}`", shown(&accessor.kind))));
        }
        let normalized = accessor.normalized;
        let size = width * component.size();
        let read = |element: &[u8]| -> [f64; N] {
            std::array::from_fn(|i| component.number(&element[i * component.size()..], normalized))
        };
        let mut vectors: Vec<[f64; N]> = match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) =
                    self.elements(index, what, view, accessor.byte_offset, accessor.count, size)?;
                bytes.chunks(stride).take(accessor.count).map(read).collect()
            }
            None if accessor.count <= MOST_ZEROS => vec![[0.0; N]; accessor.count],
            None => {
                return Err(self.wrong(
                    index,
                    what,
                    &format!("has {} elements but no bytes", accessor.count),
                ));
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let indices = Component::of(sparse.indices.component_type)
                .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
                .ok_or_else(|| self.wrong(index, what, "has sparse indices of a wrong type"))?;
            let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset);
            let (bytes, stride) = self.elements(index, what, view, offset, sparse.count, indices.size())?;
            let places: Vec<usize> =
                bytes.chunks(stride).take(sparse.count).map(|b| indices.number(b, false) as usize).collect();
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
            let (bytes, stride) = self.elements(index, what, view, offset, sparse.count, size)?;
            let values: Vec<[f64; N]> = bytes.chunks(stride).take(sparse.count).map(read).collect();
            for (place, value) in places.into_iter().zip(values) {
                let count = vectors.len();
                *vectors.get_mut(place).ok_or_else(|| {
                    self.wrong(index, what, &format!("changes element {place} of {count}"))
                })? = value;
            }
        }
        Ok(vectors)
    }

    /// The elements of accessor `index` as whole numbers of vertices.
    pub fn indices(&mut self, index: usize) -> Result<Vec<u32>, SceneError> {
        const WHAT: &str = "indices";
        let (_, component, _) = self.accessor(index, WHAT)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(self.wrong(index, WHAT, "has a component type other than unsigned integers"));
        }
        Ok(self.vectors::<1>(index, WHAT, false)?.into_iter().map(|[i]| i as u32).collect())
    }

    fn accessor(&self, index: usize, what: &str) -> Result<(&'r Accessor, Component, usize), SceneError> {
        let root = self.root;
        let accessor = root
            .accessors
            .get(index)
            .ok_or_else(|| missing(self.file, "accessor", index, root.accessors.len()))?;
        let component = Component::of(accessor.component_type).ok_or_else(|| {
            self.wrong(index, what, &format!("has the component type {}", accessor.component_type))
        })?;
        let width = width(&accessor.kind)
            .ok_or_else(|| self.wrong(index, what, &format!("has the type `{}`", shown(&accessor.kind))))?;
        Ok((accessor, component, width))
    }

    /// Bytes of `count` elements of `size` bytes from `offset` of buffer view `view`, and the distance between two.
    fn elements(
        &mut self,
        index: usize,
        what: &str,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<(&[u8], usize), SceneError> {
        let (file, root) = (self.file, self.root);
        let (bytes, stride) = self.buffers.view(root, view)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            let message =
                format!("has elements of {size} bytes, more than the stride {stride} of buffer view {view}");
            return Err(wrong(file, index, what, &message));
        }
        let held = bytes.len();
        // The last element may end before its stride does.
        let needed = match count {
            0 => Some(0),
            _ => stride.checked_mul(count - 1).and_then(|n| n.checked_add(size)),
        };
        let end = needed.and_then(|needed| offset.checked_add(needed)).filter(|end| *end <= held);
        match end {
            Some(end) => Ok((&bytes[offset.min(end)..end], stride)),
            None => Err(wrong(
                file,
                index,
                what,
                &format!("has {count} elements, more than buffer view {view} of {held} bytes holds"),
            )),
        }
    }

    fn wrong(&self, index: usize, what: &str, message: &str) -> SceneError {
        wrong(self.file, index, what, message)
    }
}

fn wrong(file: ModelFile, index: usize, what: &str, message: &str) -> SceneError {
    file.error(
        format!("accessor {index} ({what}) {message}"),
        "the file is damaged: export it again; https://github.khronos.org/glTF-Validator lists all mistakes",
    )
}
