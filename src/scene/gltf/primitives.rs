//! Primitives of a glTF mesh as triangles.

use super::accessors::Accessors;
use super::json::{self, Primitive, Root};
use super::materials::Materials;
use crate::scene::error::SceneError;
use crate::scene::library::Library;
use crate::scene::mesh_builder::MeshBuilder;
use crate::scene::model_file::ModelFile;
use crate::scene::{Mesh, Transform};
use glam::DVec3;
use std::collections::HashMap;
use std::rc::Rc;

/// Most corners of all triangles, with all repetitions: a few bytes may repeat a mesh without end, and the triangles of
/// 2^28 corners in a list take 3.6 gigabytes.
const MOST: usize = 1 << 28;

/// Refuses meshes that nodes repeat beyond [`MOST`], before any is read: `meshes` are the indices of the nodes' meshes.
pub fn check_repetitions(
    file: ModelFile,
    root: &Root,
    meshes: impl Iterator<Item = usize>,
) -> Result<(), SceneError> {
    let corners = |primitive: &Primitive| {
        let listed = primitive.indices.or(primitive.attributes.position);
        let count = listed.and_then(|index| root.accessors.get(index)).map_or(0, |a| a.count);
        // A count that no file can hold is refused where it is read.
        count.min(MOST)
    };
    let of_mesh = |mesh: &json::Mesh| mesh.primitives.iter().map(corners).fold(0, usize::saturating_add);
    let counts: Vec<usize> = root.meshes.iter().map(of_mesh).collect();
    let all = meshes.filter_map(|mesh| counts.get(mesh)).fold(0, |sum: usize, n| sum.saturating_add(*n));
    if all > MOST {
        return Err(file.error(
            format!("its nodes repeat its meshes to {all} corners, more than {MOST}"),
            "take a part of it with `node`",
        ));
    }
    Ok(())
}

/// Counts of what is left out.
#[derive(Debug, Default)]
pub struct LeftOut {
    /// Primitives of points or lines.
    pub thin: usize,
    /// Primitives without positions.
    pub empty: usize,
    /// Vertices after the last whole triangle.
    pub rest: usize,
    /// Triangles with a corner that is not finite.
    pub lost: usize,
}

/// Positions and normals of the primitives of one mesh, which often share them.
#[derive(Default)]
struct Shared(HashMap<usize, Rc<Vec<[f64; 3]>>>);

impl Shared {
    fn vectors(
        &mut self,
        accessors: &mut Accessors,
        index: usize,
        what: &str,
    ) -> Result<Rc<Vec<[f64; 3]>>, SceneError> {
        if let Some(known) = self.0.get(&index) {
            return Ok(known.clone());
        }
        let vectors = Rc::new(accessors.vectors::<3>(index, what, false)?);
        self.0.insert(index, vectors.clone());
        Ok(vectors)
    }
}

/// Reads the meshes of nodes.
pub struct Primitives<'s, 'a, 'r> {
    pub accessors: &'s mut Accessors<'a, 'r>,
    pub materials: &'s mut Materials,
    pub library: &'s mut Library,
    pub left_out: LeftOut,
}

impl Primitives<'_, '_, '_> {
    /// The triangles of glTF mesh `index` in their `place`, one mesh for each material: `name` is what messages call them.
    pub fn mesh(&mut self, index: usize, place: Transform, name: &str) -> Result<Vec<Mesh>, SceneError> {
        let (file, root) = (self.accessors.file, self.accessors.root);
        let mesh = root
            .meshes
            .get(index)
            .ok_or_else(|| super::buffers::missing(file, "mesh", index, root.meshes.len()))?;
        let mut shared = Shared::default();
        let mut parts: Vec<(usize, MeshBuilder)> = Vec::new();
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let what = format!("primitive {i} of mesh {index}");
            self.primitive(primitive, &what, place, &mut shared, &mut parts)?;
        }
        let mut meshes = Vec::new();
        for (_, builder) in parts {
            let (mesh, lost) = builder.finish(name.to_owned());
            self.left_out.lost += lost;
            if !mesh.faces.is_empty() {
                meshes.push(mesh);
            }
        }
        Ok(meshes)
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        what: &str,
        place: Transform,
        shared: &mut Shared,
        parts: &mut Vec<(usize, MeshBuilder)>,
    ) -> Result<(), SceneError> {
        let file = self.accessors.file;
        if primitive.mode < 4 {
            self.left_out.thin += 1;
            return Ok(());
        }
        let Some(position) = primitive.attributes.position else {
            self.left_out.empty += 1;
            return Ok(());
        };
        let unpacked = self.accessors.root.accessors.get(position).is_some_and(|a| a.buffer_view.is_some());
        if primitive.extensions.draco.is_some() && !unpacked {
            return Err(super::extensions::compressed(file, "KHR_draco_mesh_compression"));
        }
        let positions = shared.vectors(self.accessors, position, "positions")?;
        let normals = match primitive.attributes.normal {
            Some(normal) => Some(shared.vectors(self.accessors, normal, "normals")?),
            None => None,
        };
        let order = match primitive.indices {
            Some(indices) => self.accessors.indices(indices)?,
            None => (0..positions.len() as u32).collect(),
        };
        if let Some(wrong) = order.iter().find(|i| **i as usize >= positions.len()) {
            return Err(file.error(
                format!("{what} names vertex {wrong}, but it has {}, from 0", positions.len()),
                "the file is damaged: export it again; https://github.khronos.org/glTF-Validator lists all mistakes",
            ));
        }
        let (triangles, rest) = triangles(primitive.mode, &order).ok_or_else(|| {
            file.error(
                format!("{what} has the mode {}", primitive.mode),
                "modes are 0 to 6; 4 is triangles: export the file again",
            )
        })?;
        self.left_out.rest += rest;
        let tint = self.tint(primitive, &order)?;
        let material = self.materials.index(self.accessors, self.library, primitive.material, tint)?;
        let known = parts.iter().position(|(known, _)| *known == material).unwrap_or_else(|| {
            parts.push((material, MeshBuilder::new(place)));
            parts.len() - 1
        });
        let builder = &mut parts[known].1;
        let normals = normals.as_deref().map(Vec::as_slice);
        add(builder, &positions, normals, &triangles, material);
        Ok(())
    }

    /// Mean colour of the vertices in use; white without colours.
    fn tint(&mut self, primitive: &Primitive, order: &[u32]) -> Result<DVec3, SceneError> {
        let Some(color) = primitive.attributes.color.filter(|_| !self.materials.is_given()) else {
            return Ok(DVec3::ONE);
        };
        let colors = self.accessors.vectors::<3>(color, "colours", true)?;
        let used = || {
            order.iter().filter_map(|i| colors.get(*i as usize)).filter(|c| c.iter().all(|x| x.is_finite()))
        };
        let sum: DVec3 = used().map(|c| DVec3::from_array(*c).clamp(DVec3::ZERO, DVec3::ONE)).sum();
        Ok(match used().count() {
            0 => DVec3::ONE,
            count => sum / count as f64,
        })
    }
}

/// Adds the triangles, and of the vertices only those they use: several primitives may share one long list.
fn add(
    builder: &mut MeshBuilder,
    positions: &[[f64; 3]],
    normals: Option<&[[f64; 3]]>,
    triangles: &[[u32; 3]],
    material: usize,
) {
    const NEW: u32 = u32::MAX;
    let (first_vertex, first_normal) = (builder.vertex_count() as u32, builder.normal_count() as u32);
    let mut places = vec![NEW; positions.len()];
    let mut next = 0;
    for corner in triangles.iter().flatten() {
        let place = &mut places[*corner as usize];
        if *place == NEW {
            *place = next;
            next += 1;
            builder.vertex(DVec3::from_array(positions[*corner as usize]));
            if let Some(normals) = normals {
                let normal = normals.get(*corner as usize).copied().unwrap_or_default();
                builder.normal(DVec3::from_array(normal));
            }
        }
    }
    for triangle in triangles {
        let local = triangle.map(|corner| places[corner as usize]);
        let normals = normals.map(|_| local.map(|i| first_normal + i));
        builder.triangle(local.map(|i| first_vertex + i), normals, material);
    }
}

/// The triangles of a primitive whose vertices come in `order`, and how many vertices are left over (specification, section
/// 3.7.2.1). None for a mode that is no surface.
fn triangles(mode: u32, order: &[u32]) -> Option<(Vec<[u32; 3]>, usize)> {
    let least = if order.is_empty() { 0 } else { order.len() % 3 };
    Some(match mode {
        4 => (order.as_chunks::<3>().0.to_vec(), least),
        5 => {
            let turned = |(i, three): (usize, &[u32])| {
                if i % 2 == 0 { [three[0], three[1], three[2]] } else { [three[0], three[2], three[1]] }
            };
            (
                order.windows(3).enumerate().map(turned).collect(),
                if order.len() < 3 { order.len() } else { 0 },
            )
        }
        6 => {
            let first = order.first().copied().unwrap_or_default();
            let rest = order.get(1..).unwrap_or_default();
            let fan: Vec<_> = rest.windows(2).map(|two| [two[0], two[1], first]).collect();
            (fan, if order.len() < 3 { order.len() } else { 0 })
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::triangles;

    /// The tables of the specification.
    #[test]
    fn lists_strips_and_fans() {
        let order = [10, 11, 12, 13, 14];
        assert_eq!(triangles(4, &order), Some((vec![[10, 11, 12]], 2)));
        assert_eq!(triangles(5, &order), Some((vec![[10, 11, 12], [11, 13, 12], [12, 13, 14]], 0)));
        assert_eq!(triangles(6, &order), Some((vec![[11, 12, 10], [12, 13, 10], [13, 14, 10]], 0)));
        assert_eq!(triangles(5, &order[..2]), Some((vec![], 2)));
        assert_eq!(triangles(6, &[]), Some((vec![], 0)));
        assert_eq!(triangles(7, &order), None);
    }
}
