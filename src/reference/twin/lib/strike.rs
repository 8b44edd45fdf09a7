//! Twin of `glsl/lib/optics/strike.glsl`.

use super::super::real::{Real, Real3, float, real};
use super::super::structs::{
    CornerNormals, ExtendedSphere, FlatNormal, Hit, Material, Path, Push, Ray, Sphere, Surface, Triangle,
};
use super::fresnel::reflection_share;
use super::media::{is_inside, medium};
use super::numeric::dot3;
use super::surface::{smooth_normal, sphere_point, triangle_point, wide_sphere_point};
use crate::kernel::abi::{
    CHILD_REFLECTED, CHILD_REFRACTED, CUT_ONE, FRESNEL_CONSTANT, LEAVES, NONE, PASSES, Specialisation,
};

fn greatest(v: [f32; 3]) -> f32 {
    v[0].max(v[1].max(v[2]))
}

/// The scene as `strike` sees it.
pub struct Scene<'a> {
    /// What the kernel is compiled for.
    pub spec: &'a Specialisation,
    /// Of the pass.
    pub push: &'a Push,
    /// By primitive.
    pub triangles: &'a [Triangle],
    /// Parallel to `triangles`.
    pub flat_normals: &'a [FlatNormal],
    /// Parallel to `triangles`, or empty.
    pub corner_normals: &'a [CornerNormals],
    /// By primitive, less the triangles.
    pub spheres: &'a [Sphere],
    /// As `Sphere::wide` says.
    pub extended_spheres: &'a [ExtendedSphere],
    /// By material.
    pub materials: &'a [Material],
    /// By solid.
    pub solid_iors: &'a [f32],
    /// By solid.
    pub solid_priorities: &'a [i32],
}

impl Scene<'_> {
    /// What a ray met at `h`; `inside`: its list of solids.
    pub fn strike(&self, ray: &Ray, inside: &[u32], h: &Hit, paths: &mut [Path]) -> Surface {
        let mut s = Surface { primitive: h.primitive, ..Surface::default() };
        if h.primitive == NONE {
            return s;
        }
        let (o, d) = (Real3::from(ray.origin), Real3::from(ray.direction));
        let mut p;
        if h.primitive < self.spec.triangle_count {
            let at = h.primitive as usize;
            let (t, flat) = (&self.triangles[at], self.flat_normals[at].normal.into());
            p = triangle_point(t, flat, h.u, h.v, self.spec.robust != 0);
            if self.spec.smooth_normals != 0 {
                p.normal = smooth_normal(&self.corner_normals[at], flat, p.geometric, h.u, h.v);
            }
            (s.material, s.solid) = (t.material, t.solid);
        } else {
            let at = (h.primitive - self.spec.triangle_count) as usize;
            let sphere = &self.spheres[at];
            p = if self.spec.extended_spheres_used != 0 && sphere.wide != NONE {
                wide_sphere_point(&self.extended_spheres[sphere.wide as usize], o, d, h.t)
            } else {
                sphere_point(sphere, o, d, h.t)
            };
            (s.material, s.solid) = (sphere.material, sphere.solid);
        }
        let behind = dot3(d, p.geometric) > 0.0;
        let toward = |v: Real3| if behind { -v } else { v };
        let mut normal = toward(p.normal);
        let mut c = -dot3(d, normal);
        if c < 0.0 {
            normal = toward(p.geometric);
            c = -dot3(d, normal);
        }
        s.position = p.position.into();
        s.offset = toward(p.offset).into();
        s.normal = normal.into();
        s.cosine = if c < 1.0 { if c > 0.0 { c } else { 0.0 } } else { 1.0 };

        let m = &self.materials[s.material as usize];
        let (mut here, mut beyond): (Real, Real) = (1.0, 1.0);
        s.eta = 1.0;
        if m.secondary > 0.0 && !(m.fresnel_kind == FRESNEL_CONSTANT && m.fresnel >= 1.0) {
            let ior = |solid: u32| real(self.solid_iors[solid as usize]);
            let priority = |solid: u32| self.solid_priorities[solid as usize];
            here = ior(medium(inside, 0, self.solid_priorities));
            if s.solid != 0 {
                s.flags |= if is_inside(inside, s.solid) { LEAVES } else { 0 };
                let others = medium(inside, s.solid, self.solid_priorities);
                if others != 0 && priority(others) > priority(s.solid) {
                    s.share = 0.0;
                    let last = self.push.depth == self.push.last_depth;
                    s.flags |= PASSES | if last { 0 } else { CHILD_REFRACTED };
                    if last {
                        self.note_cut(ray, greatest(ray.throughput), paths);
                    }
                    return s;
                }
                beyond = ior(if s.flags & LEAVES != 0 { others } else { s.solid });
                s.eta = here / beyond;
            } else {
                beyond = real(m.ior);
            }
        }
        s.share = float(reflection_share(m, here, beyond, d, normal, s.cosine));
        if m.secondary > 0.0 {
            let w = greatest(ray.throughput) * m.secondary;
            s.flags |= self.child(ray, CHILD_REFLECTED, s.share * w, paths);
            s.flags |= self.child(ray, CHILD_REFRACTED, (1.0 - s.share) * w, paths);
        }
        s
    }

    fn note_cut(&self, ray: &Ray, throughput: f32, paths: &mut [Path]) {
        if self.spec.survey != 0 {
            paths[ray.sample_index as usize].cut += (throughput * CUT_ONE as f32) as u32 + 1;
        }
    }

    fn child(&self, ray: &Ray, kind: u32, throughput: f32, paths: &mut [Path]) -> u32 {
        if !(throughput > 0.0) {
            return 0;
        }
        if self.push.depth < self.push.last_depth && !(throughput < self.push.cutoff) {
            return kind;
        }
        self.note_cut(ray, throughput, paths);
        0
    }
}
