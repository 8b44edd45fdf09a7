//! A scene's triangles by number: those of polygons, then those of meshes, in the scene's order. Computed from the scene whenever one is asked for: twice is cheaper than storing them.

use super::rounding::{Rounding, normalized};
use super::solids::Solid;
use crate::kernel::abi::{self, double};
use crate::prepare::bvh::Prim;
use crate::prepare::local_frame::{LocalFrame, PointMap};
use crate::prepare::winding_number;
use crate::scene::bounds::Bounds;
use crate::scene::{Mesh, Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Faces that a thread takes at a time where what it sums up must not depend on how many there are.
const CHUNK: usize = 1 << 15;

/// One triangle before it is rounded.
struct Flat {
    corners: [DVec3; 3],
    normal: Option<DVec3>,
    smooth: Option<[DVec3; 3]>,
    material: usize,
    solid: u32,
    inner_edges: u32,
}

/// All triangles of a scene.
pub(super) struct Triangles<'a> {
    scene: &'a Scene,
    map: PointMap,
    round: Rounding,
    /// As in `Recipe`.
    degenerate_normal: Option<DVec3>,
    /// Polygon, and number in it, of each triangle that is of a polygon.
    of_polygons: Vec<(u32, u32)>,
    /// Number of each mesh's first triangle, and one past the last.
    starts: Vec<usize>,
    /// Solid that a mesh bounds where it refracts, from 1.
    solids: Vec<u32>,
    refracts: Vec<bool>,
    /// Some triangle has corner normals.
    pub any_smooth: bool,
    /// Materials in use.
    pub used: Vec<bool>,
}

/// The triangles that are kept, as the hierarchy's builder wants them.
pub(super) struct Kept {
    /// In the scene's order.
    pub prims: Vec<Prim>,
    /// Triangles without area.
    pub degenerate: u64,
    /// The boxes are as they are in f32.
    pub exact: bool,
}

/// `Prim::kind` of a triangle to drop.
const DEGENERATE: u32 = 2;
const BURIED: u32 = 3;

impl<'a> Triangles<'a> {
    /// Numbers them, and adds the solids that meshes bound to `solids`. `eye` in the local frame.
    pub fn new(
        scene: &'a Scene,
        frame: &LocalFrame,
        round: Rounding,
        degenerate_normal: Option<DVec3>,
        eye: DVec3,
        solids: &mut Vec<Solid>,
    ) -> Triangles<'a> {
        let map = frame.map();
        let refracts: Vec<bool> = scene.materials.iter().map(|m| m.refracts()).collect();
        let mut used = vec![false; scene.materials.len()];
        let others =
            scene.polygons.iter().map(|p| p.material).chain(scene.spheres.iter().map(|s| s.material));
        others.for_each(|m| used[m] = true);
        let mut of_polygons = Vec::new();
        for (i, p) in scene.polygons.iter().enumerate() {
            of_polygons.extend((0..p.triangle_count() as u32).map(|k| (i as u32, k)));
        }
        let (mut start, mut starts, mut own) = (of_polygons.len(), Vec::new(), Vec::new());
        let mut any_smooth = false;
        for mesh in &scene.meshes {
            let census = Census::of(mesh);
            census.materials.keys().for_each(|m| used[*m] = true);
            any_smooth |= census.smooth;
            let first_refracting =
                census.materials.iter().filter(|(m, _)| refracts[**m]).min_by_key(|(_, first)| **first);
            own.push(first_refracting.map_or(0, |(material, _)| {
                let bounds = mesh_bounds(mesh, &map);
                solids.push(Solid {
                    bounds,
                    ior: scene.materials[*material].ior,
                    priority: scene.materials[*material].priority,
                    // A closed shell does not wind around what is outside its box.
                    contains_eye: bounds.touches(&Bounds { lo: eye, hi: eye })
                        && winding_number::contains(mesh.faces.len(), |f| corners(mesh, f, &map), eye),
                });
                solids.len() as u32
            }));
            starts.push(start);
            start += mesh.faces.len();
        }
        starts.push(start);
        Triangles {
            scene,
            map,
            round,
            degenerate_normal,
            of_polygons,
            starts,
            solids: own,
            refracts,
            any_smooth,
            used,
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    fn get(&self, id: u32) -> Flat {
        let id = id as usize;
        if let Some((polygon, k)) = self.of_polygons.get(id) {
            let p = &self.scene.polygons[*polygon as usize];
            let [a, b, c] = p.triangle(*k as usize);
            let inner = |from: usize, to: usize| (from + 1) % p.vertices.len() != to;
            return Flat {
                corners: [a, b, c].map(|i| self.map.point(p.vertices[i])),
                normal: Some(p.normal),
                smooth: None,
                material: p.material,
                solid: 0,
                inner_edges: if inner(a, b) { abi::INNER_AB } else { 0 }
                    | if inner(c, a) { abi::INNER_CA } else { 0 },
            };
        }
        let at = self.starts.partition_point(|start| *start <= id) - 1;
        let mesh = &self.scene.meshes[at];
        let i = id - self.starts[at];
        let face = &mesh.faces[i];
        Flat {
            corners: corners(mesh, i, &self.map),
            normal: None,
            smooth: face.normals.map(|n| n.map(|n| mesh.normals[n as usize])),
            material: face.material,
            solid: if self.refracts[face.material] { self.solids[at] } else { 0 },
            inner_edges: 0,
        }
    }

    /// Normal of the rounded corners; none where they have no area.
    fn geometric(&self, corners: &[DVec3; 3]) -> Option<DVec3> {
        // From the rounded corners, in f64, where products of f32 numbers are exact and the rest is
        // good to 2^-52: zero means no area (numerics.md, Local frame).
        normalized((corners[1] - corners[0]).cross(corners[2] - corners[0])).or(self.degenerate_normal)
    }

    /// Box of a triangle, padded as the kernels do.
    pub fn bounds(&self, id: u32) -> Bounds {
        self.padded(&self.get(id).corners.map(|c| self.round.point(c)))
    }

    fn padded(&self, corners: &[DVec3; 3]) -> Bounds {
        let bounds = corners.iter().fold(Bounds::EMPTY, |b, c| b.with(*c));
        self.round.padded(bounds.lo, bounds.hi)
    }

    /// Those with an area, and of piles of equal ones the first few.
    pub fn kept(&self) -> Kept {
        let exact = AtomicBool::new(true);
        let piles = Piles::new(self.len());
        let mut prims: Vec<Prim> = (0..self.len() as u32)
            .into_par_iter()
            .map(|id| {
                let corners = self.get(id).corners.map(|c| self.round.point(c));
                if self.geometric(&corners).is_none() {
                    return Prim { index: id, kind: DEGENERATE, ..Prim::default() };
                }
                piles.count(&corners);
                let (prim, same) = Prim::of(id, &self.padded(&corners), false);
                if !same {
                    exact.store(false, Ordering::Relaxed);
                }
                prim
            })
            .collect();
        if piles.some_high() {
            let mut seen = HashMap::new();
            for prim in prims.iter_mut().filter(|p| p.kind == 0) {
                let corners = self.get(prim.index).corners.map(|c| self.round.point(c));
                if piles.is_buried(&corners, &mut seen) {
                    prim.kind = BURIED;
                }
            }
        }
        let degenerate = prims.par_iter().filter(|p| p.kind == DEGENERATE).count() as u64;
        if degenerate != 0 || piles.some_high() {
            prims.retain(|p| p.kind == 0);
        }
        Kept { prims, degenerate, exact: exact.into_inner() }
    }

    /// The triangles numbered `order` as the kernels want them, with their shading normals.
    pub fn packed(&self, order: &[u32]) -> (Vec<double::Triangle>, Vec<double::FlatNormal>) {
        let (mut triangles, mut normals) = (Vec::new(), Vec::new());
        let one = |id: &u32| {
            let t = self.get(*id);
            let corners = t.corners.map(|c| self.round.point(c));
            let geometric = self.geometric(&corners).unwrap_or_default();
            let normal = t.normal.map_or(geometric, |n| if n.dot(geometric) < 0.0 { -n } else { n });
            let [a, b, c] = corners.map(|c| c.to_array());
            let [normal_x, normal_y, normal_z] = geometric.to_array();
            let (material, solid, inner_edges) = (t.material as u32, t.solid, t.inner_edges);
            let triangle = double::Triangle {
                a,
                normal_x,
                b,
                normal_y,
                c,
                normal_z,
                material,
                solid,
                inner_edges,
                id: *id,
            };
            (triangle, double::FlatNormal { normal: normal.to_array(), pad: 0.0 })
        };
        order.par_iter().map(one).unzip_into_vecs(&mut triangles, &mut normals);
        (triangles, normals)
    }

    /// Their corner normals; zero for the flat ones.
    pub fn corner_normals(&self, order: &[u32]) -> Vec<double::CornerNormals> {
        let one = |id: &u32| {
            let [a, b, c] = self.get(*id).smooth.map_or([[0.0; 3]; 3], |n| n.map(|n| n.to_array()));
            double::CornerNormals { a, b, c }
        };
        order.par_iter().map(one).collect()
    }
}

/// Local corners of a face.
fn corners(mesh: &Mesh, face: usize, map: &PointMap) -> [DVec3; 3] {
    mesh.faces[face].vertices.map(|v| map.point(mesh.vertices[v as usize]))
}

/// Local box of a mesh's faces.
fn mesh_bounds(mesh: &Mesh, map: &PointMap) -> Bounds {
    let world = mesh.bounds();
    // Maps keep the order of numbers, so that the box of the mapped corners is the mapped box.
    Bounds { lo: map.point(world.lo), hi: map.point(world.hi) }
}

/// What the faces of a mesh have.
#[derive(Default)]
struct Census {
    /// Materials, and the first face of each.
    materials: HashMap<usize, usize>,
    smooth: bool,
}

impl Census {
    fn of(mesh: &Mesh) -> Census {
        let part = |(chunk, faces): (usize, &[crate::scene::Face])| {
            let (mut census, mut last) = (Census::default(), usize::MAX);
            for (i, face) in faces.iter().enumerate() {
                census.smooth |= face.normals.is_some();
                if face.material != last {
                    last = face.material;
                    census.add(last, chunk * CHUNK + i);
                }
            }
            census
        };
        let parts: Vec<Census> = mesh.faces.par_chunks(CHUNK).enumerate().map(part).collect();
        let mut all = Census::default();
        for part in parts {
            all.smooth |= part.smooth;
            part.materials.into_iter().for_each(|(m, first)| all.add(m, first));
        }
        all
    }

    fn add(&mut self, material: usize, first: usize) {
        self.materials.entry(material).or_insert(first);
    }
}

/// Triangles kept of one pile, all with the same corners in the same order.
const PILE: u32 = 16;

/// Of triangles with the same corners the first in the scene's order is hit, whatever the rest are: t
/// is the same bits, and ties go to the smallest id. A ray would test them all the same, and so many
/// that it came near the loop cap.
///
/// Counted by slots first, as many as triangles, by any thread in any order: only where more than `PILE`
/// share a slot, which by chance one slot in 10^15 does, are they told apart.
struct Piles {
    slots: Vec<AtomicU32>,
    high: AtomicBool,
}

impl Piles {
    fn new(triangles: usize) -> Piles {
        let slots = (0..triangles.next_power_of_two()).map(|_| AtomicU32::new(0)).collect();
        Piles { slots, high: AtomicBool::new(false) }
    }

    /// 64 bits mixed from the corners'.
    fn key(corners: &[DVec3; 3]) -> u64 {
        let words = corners.iter().flat_map(|c| c.to_array()).map(f64::to_bits);
        // The multiplier of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
        words.fold(0u64, |h, w| (h ^ w).wrapping_mul(0xbf58_476d_1ce4_e5b9).rotate_left(29))
    }

    fn slot(&self, key: u64) -> &AtomicU32 {
        &self.slots[(key >> 11) as usize & (self.slots.len() - 1)]
    }

    fn count(&self, corners: &[DVec3; 3]) {
        if self.slot(Piles::key(corners)).fetch_add(1, Ordering::Relaxed) >= PILE {
            self.high.store(true, Ordering::Relaxed);
        }
    }

    fn some_high(&self) -> bool {
        self.high.load(Ordering::Relaxed)
    }

    /// True if PILE triangles with these corners came before. Corners are told by their keys: a false
    /// burial would take 16 collisions at once.
    fn is_buried(&self, corners: &[DVec3; 3], seen: &mut HashMap<u64, u32>) -> bool {
        let key = Piles::key(corners);
        if self.slot(key).load(Ordering::Relaxed) <= PILE {
            return false;
        }
        let count = seen.entry(key).or_default();
        *count += 1;
        *count > PILE
    }
}
