//! Runs one kernel on the buffers in host memory.

use super::memory::Memory;
use super::structs::Push;
use super::{
    fused_depth, gather, generate, intersect, light, place, resolve, scan, shade, shadow, spawn, walk,
};
use crate::kernel::abi::Specialisation;
use crate::kernel::table::Kernel;

impl Memory {
    /// Runs one kernel.
    pub fn run(&mut self, kernel: Kernel, spec: &Specialisation, push: &Push) {
        match kernel {
            Kernel::Generate => self.generate(spec, push),
            Kernel::Intersect => self.intersect(spec, push),
            Kernel::Shade => self.shade(spec, push),
            Kernel::Scan => self.scan(spec, push),
            Kernel::Spawn => self.spawn(spec),
            Kernel::Shadow => self.shadow(spec, push),
            Kernel::Walk => self.walk(spec, push),
            Kernel::Light => self.light(spec, push),
            Kernel::Gather => self.gather(),
            // No pass of a batch: `crate::render::self_test` judges what it writes.
            Kernel::SelfTest => {}
            Kernel::FusedDepth => self.fused_depth(spec, push),
            Kernel::Place => self.place(spec),
            Kernel::Resolve => self.resolve(spec, push),
        }
    }
}

// One function per kernel: its arguments are its bindings, in the kernel's order.
impl Memory {
    fn generate(&mut self, spec: &Specialisation, push: &Push) {
        generate::generate(
            spec,
            push,
            &self.camera,
            &self.eye_media,
            &self.pixels,
            &mut self.rays,
            &mut self.media,
            &mut self.paths,
        );
    }

    fn intersect(&mut self, spec: &Specialisation, push: &Push) {
        intersect::intersect(
            spec,
            push,
            &self.triangles,
            &self.spheres,
            &self.extended_spheres,
            &self.nodes,
            &self.compressed_nodes,
            &self.rays,
            &self.queue,
            &mut self.hits,
            &mut self.paths,
            &mut self.counters,
        );
    }

    fn shade(&mut self, spec: &Specialisation, push: &Push) {
        shade::shade(
            spec,
            push,
            &self.triangles,
            &self.flat_normals,
            &self.corner_normals,
            &self.spheres,
            &self.extended_spheres,
            &self.materials,
            &self.solid_iors,
            &self.solid_priorities,
            &self.rays,
            &self.media,
            &self.queue,
            &self.hits,
            &mut self.surfaces,
            &mut self.child_counts,
            &mut self.paths,
        );
    }

    fn scan(&mut self, spec: &Specialisation, push: &Push) {
        scan::scan(
            spec,
            push,
            &self.queue,
            &self.child_counts,
            &self.child_masks,
            &mut self.offsets,
            &mut self.next_queue,
            &mut self.depth_counts,
            &mut self.counters,
        );
    }

    fn spawn(&mut self, spec: &Specialisation) {
        spawn::spawn(
            spec,
            &self.camera,
            &self.materials,
            &self.rays,
            &self.media,
            &self.queue,
            &self.next_queue,
            &self.surfaces,
            &self.offsets,
            &mut self.next_rays,
            &mut self.next_media,
            &mut self.counters,
        );
    }

    fn shadow(&mut self, spec: &Specialisation, push: &Push) {
        shadow::shadow(
            spec,
            push,
            &self.camera,
            &self.triangles,
            &self.spheres,
            &self.extended_spheres,
            &self.nodes,
            &self.compressed_nodes,
            &self.materials,
            &self.lights,
            &self.rays,
            &self.queue,
            &self.surfaces,
            &mut self.contributions,
            &mut self.sample_radiance,
            &mut self.paths,
            &mut self.depth_counts,
            &mut self.counters,
        );
    }

    fn walk(&mut self, spec: &Specialisation, push: &Push) {
        walk::walk(
            spec,
            push,
            &self.camera,
            &self.triangles,
            &self.spheres,
            &self.extended_spheres,
            &self.nodes,
            &self.compressed_nodes,
            &self.materials,
            &self.lights,
            &self.rays,
            &self.queue,
            &self.surfaces,
            &mut self.hits,
            &mut self.paths,
            &mut self.counters,
        );
    }

    fn light(&mut self, spec: &Specialisation, push: &Push) {
        light::light(
            spec,
            push,
            &self.camera,
            &self.triangles,
            &self.spheres,
            &self.materials,
            &self.lights,
            &self.rays,
            &self.queue,
            &self.hits,
            &self.surfaces,
            &mut self.contributions,
            &mut self.sample_radiance,
            &mut self.paths,
            &mut self.depth_counts,
            &mut self.counters,
        );
    }

    fn gather(&mut self) {
        gather::gather(&self.queue, &self.contributions, &mut self.sample_radiance, &mut self.counters);
    }

    fn fused_depth(&mut self, spec: &Specialisation, push: &Push) {
        fused_depth::fused_depth(
            spec,
            push,
            &self.camera,
            &self.triangles,
            &self.flat_normals,
            &self.corner_normals,
            &self.spheres,
            &self.extended_spheres,
            &self.nodes,
            &self.compressed_nodes,
            &self.materials,
            &self.lights,
            &self.solid_iors,
            &self.solid_priorities,
            &self.rays,
            &mut self.next_rays,
            &self.media,
            &mut self.next_media,
            &self.queue,
            &mut self.child_masks,
            &self.ray_indices,
            &mut self.contributions,
            &mut self.sample_radiance,
            &mut self.paths,
            &mut self.depth_counts,
            &mut self.counters,
        );
    }

    fn place(&mut self, spec: &Specialisation) {
        place::place(
            spec,
            &self.queue,
            &self.next_queue,
            &self.child_masks,
            &self.offsets,
            &mut self.ray_indices,
        );
    }

    fn resolve(&mut self, spec: &Specialisation, push: &Push) {
        resolve::resolve(spec, push, &self.sample_radiance, &self.paths, &mut self.film, &mut self.marks);
    }
}
