//! Traces given rays through the kernels of one depth and returns hits, surfaces and spawned rays.
//! For tests of kernels without pictures.

use crate::kernel::abi::{self, Buf, GpuStruct, Queue, Specialisation};
use crate::kernel::table::Kernel;
use crate::plan::dispatches::Step;
use crate::plan::passes::{PER_DEPTH, Pass, walk};
use crate::plan::{Limits, Plan, PlannedScene, element_bytes};
use crate::prepare::{Packed, Recipe};
use crate::reference::twin::single::Memory;
use crate::render::{Batches, RenderError, Renderer};
use crate::scene::Scene;
use crate::settings::forced_features::Feature;
use crate::settings::{Precision, Settings};
use crate::vk::Dispatch;
use glam::DVec3;

/// Most rays traced at once.
const BATCH: usize = 1 << 14;

/// A ray in the local frame ([`crate::prepare::local_frame::LocalFrame`]); rounded to the kernels'
/// precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeRay {
    /// Local coordinates.
    pub origin: DVec3,
    /// Any length; a unit vector for shading and spawning.
    pub direction: DVec3,
    /// Index in scene order of the primitive it starts on.
    pub skip: Option<u32>,
    /// Solids around it, outermost first (from 1: meshes, then spheres); `None` for those around
    /// the camera.
    pub media: Option<[u32; 2]>,
}

impl ProbeRay {
    /// A ray that starts in free space.
    pub fn new(origin: DVec3, direction: DVec3) -> ProbeRay {
        ProbeRay { origin, direction, skip: None, media: None }
    }
}

/// A hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeHit {
    /// Index in scene order (triangles after triangulation, then spheres).
    pub id: u32,
    /// Distance in units of the ray's direction.
    pub t: f64,
    /// Barycentric weights of corners b and c.
    pub uv: [f64; 2],
    /// Local coordinates.
    pub position: DVec3,
    /// Shading normal on the ray's side.
    pub normal: DVec3,
    /// Ray offset on the ray's side.
    pub offset: DVec3,
    /// Index on the ray's side / index on the other side.
    pub eta: f64,
    /// Reflectance.
    pub share: f64,
}

/// A ray spawned by another.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeChild {
    /// Index of its parent among the given rays.
    pub parent: usize,
    /// True for a refraction ray.
    pub refracted: bool,
    /// Local coordinates.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Weight.
    pub throughput: [f32; 3],
    /// Index in scene order of the primitive it starts on.
    pub skip: Option<u32>,
    /// Solids around it, outermost first, 0 = none.
    pub media: Vec<u32>,
}

/// Results of a batch of rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Probed {
    /// One entry per ray.
    pub hits: Vec<Option<ProbeHit>>,
    /// In order of their parents, reflection first.
    pub children: Vec<ProbeChild>,
    /// Counters, indexed by `abi::COUNTER_*`.
    pub counters: [u64; abi::COUNTERS as usize],
}

/// Reads and writes the fields of a device struct by name, at either precision.
struct Layout {
    shape: &'static GpuStruct,
    stride: usize,
    double: bool,
}

impl Layout {
    fn of(name: &str, precision: Precision) -> Layout {
        let double = precision == Precision::Double;
        let structs = if double { abi::double::STRUCTS } else { abi::single::STRUCTS };
        let shape = structs.iter().find(|s| s.name == name).expect("a shared struct's name");
        Layout { shape, stride: element_bytes(name, precision) as usize, double }
    }

    fn at(&self, item: usize, field: &str) -> usize {
        let offset = self.shape.fields.iter().find(|f| f.0 == field).map_or(0, |f| f.1);
        item * self.stride + offset
    }

    fn real(&self, bytes: &[u8], at: usize) -> f64 {
        if self.double {
            f64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
        } else {
            f64::from(single(bytes, at))
        }
    }

    fn real3(&self, bytes: &[u8], item: usize, field: &str) -> DVec3 {
        let (at, step) = (self.at(item, field), if self.double { 8 } else { 4 });
        DVec3::from(std::array::from_fn(|i| self.real(bytes, at + i * step)))
    }

    fn set_real3(&self, bytes: &mut [u8], item: usize, field: &str, v: DVec3) {
        let at = self.at(item, field);
        for (i, x) in v.to_array().into_iter().enumerate() {
            if self.double {
                bytes[at + 8 * i..][..8].copy_from_slice(&x.to_le_bytes());
            } else {
                bytes[at + 4 * i..][..4].copy_from_slice(&(x as f32).to_le_bytes());
            }
        }
    }
}

fn single(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

/// Maps storage indices to indices in scene order, and back.
struct Ids {
    by_primitive: Vec<u32>,
    by_id: std::collections::HashMap<u32, u32>,
}

impl Ids {
    fn of(packed: &Packed) -> Ids {
        let by_primitive: Vec<u32> =
            packed.triangles.iter().map(|t| t.id).chain(packed.spheres.iter().map(|s| s.id)).collect();
        let by_id = by_primitive.iter().enumerate().map(|(i, id)| (*id, i as u32)).collect();
        Ids { by_primitive, by_id }
    }

    fn id(&self, primitive: u32) -> Option<u32> {
        self.by_primitive.get(primitive as usize).copied()
    }

    fn primitive(&self, id: u32) -> u32 {
        self.by_id.get(&id).copied().unwrap_or(abi::NONE)
    }
}

/// Runs the kernels of one depth: on a device, or as twins.
trait Bank {
    fn write(&mut self, buffer: Buf, bytes: &[u8]) -> Result<(), RenderError>;
    fn run(&mut self, push: abi::Push) -> Result<(), RenderError>;
    fn read(&mut self, buffer: Buf) -> Result<Vec<u8>, RenderError>;
}

/// The kernels of a probe, in order.
fn stages() -> impl Iterator<Item = &'static Pass> {
    let wanted =
        |p: &&Pass| matches!(p.kernel, Kernel::Intersect | Kernel::Shade | Kernel::Scan | Kernel::Spawn);
    PER_DEPTH.iter().filter(wanted)
}

struct OnDevice(Batches);

impl Bank for OnDevice {
    fn write(&mut self, buffer: Buf, bytes: &[u8]) -> Result<(), RenderError> {
        Ok(self.0.recorder.upload(&mut self.0.buffers, buffer, bytes)?)
    }

    fn run(&mut self, push: abi::Push) -> Result<(), RenderError> {
        let batches = &mut self.0;
        batches.recorder.begin()?;
        batches.recorder.fill(&batches.buffers, Buf::Counters, 0);
        batches.recorder.fill(&batches.buffers, Buf::DepthCounts, 0);
        for pass in stages() {
            let d = Dispatch { pass, depth: 1, push, items: 0 };
            batches.recorder.dispatch(&batches.pipelines, &batches.buffers, &d);
        }
        batches.recorder.submit(&batches.buffers)?;
        let counters = batches.recorder.read(&mut batches.buffers, Buf::Counters)?;
        if word(&counters, 4 * abi::COUNTER_UNFINISHED as usize) != 0 {
            self.run_in_parts(push)?;
        }
        Ok(())
    }

    fn read(&mut self, buffer: Buf) -> Result<Vec<u8>, RenderError> {
        Ok(self.0.recorder.read(&mut self.0.buffers, buffer)?)
    }
}

impl OnDevice {
    /// The same once more, with walks that go on until they end.
    fn run_in_parts(&mut self, push: abi::Push) -> Result<(), RenderError> {
        let batches = &mut self.0;
        batches.prepare_parts()?;
        batches.recorder.begin()?;
        batches.recorder.fill(&batches.buffers, Buf::Counters, 0);
        batches.recorder.fill(&batches.buffers, Buf::DepthCounts, 0);
        batches.recorder.submit(&batches.buffers)?;
        let steps: Vec<Step> = [walk()]
            .into_iter()
            .chain(stages().skip(1))
            .map(|pass| Step { pass, depth: 1, lights: [0, 0] })
            .collect();
        let lost = batches.run_in_parts(&steps, push, |_| 0, &mut Vec::new(), &mut || false)?;
        // As in a tally: walks that went on have ended, but for those that were given up.
        let counters = batches.recorder.read(&mut batches.buffers, Buf::Counters)?;
        let mut words: Vec<u32> = bytemuck::pod_collect_to_vec(&counters);
        words[abi::COUNTER_UNFINISHED as usize] = 0;
        words[abi::COUNTER_LOOP_CAP as usize] += lost.unwrap_or(0) as u32;
        batches.recorder.upload(&mut batches.buffers, Buf::Counters, bytemuck::cast_slice(&words))?;
        Ok(())
    }
}

/// The twins of single precision; those of double precision have padding, and no bytes to show.
struct OnTwins(Memory, Specialisation);

impl Bank for OnTwins {
    fn write(&mut self, buffer: Buf, bytes: &[u8]) -> Result<(), RenderError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
        self.0.words_mut(buffer)[..words.len()].copy_from_slice(&words);
        Ok(())
    }

    fn run(&mut self, push: abi::Push) -> Result<(), RenderError> {
        self.0.words_mut(Buf::Counters).fill(0);
        self.0.words_mut(Buf::DepthCounts).fill(0);
        stages().for_each(|pass| self.0.run(pass.kernel, &self.1, &push));
        Ok(())
    }

    fn read(&mut self, buffer: Buf) -> Result<Vec<u8>, RenderError> {
        Ok(self.0.bytes(buffer).to_vec())
    }
}

/// A scene planned for probing some rays at once.
struct Probe(PlannedScene);

impl Probe {
    fn new(
        recipe: Recipe,
        scene: &Scene,
        settings: &Settings,
        rays: usize,
        forced: Option<bool>,
        limits: &Limits,
    ) -> Probe {
        let width = rays.clamp(1, BATCH) as u32;
        let mut settings =
            Settings { width, height: 1, samples: 1, depth: 2, crop: None, ..settings.clone() };
        // Children are asked for even where there can be none; what is between the stages is read.
        settings.schedule.forced_features =
            settings.schedule.forced_features.with(Feature::Secondary).with(Feature::SplitKernels);
        Probe(PlannedScene::for_twins(recipe, scene, &settings, limits, forced))
    }

    fn trace(&self, bank: &mut dyn Bank, rays: &[ProbeRay]) -> Result<Probed, RenderError> {
        let PlannedScene { packed, settings, .. } = &self.0;
        let (plan, ids) = (self.0.plan()?, Ids::of(packed));
        let mut all = Probed { hits: Vec::new(), children: Vec::new(), counters: Default::default() };
        for part in rays.chunks(plan.capacity.min(settings.width) as usize) {
            let batch = batch(bank, packed, &ids, settings, plan, part)?;
            let base = all.hits.len();
            all.hits.extend(batch.hits);
            all.children
                .extend(batch.children.into_iter().map(|c| ProbeChild { parent: c.parent + base, ..c }));
            all.counters.iter_mut().zip(batch.counters).for_each(|(a, b)| *a += b);
        }
        Ok(all)
    }
}

/// Traces `rays` with the single-precision twins of the kernels.
pub fn probe_twins(
    scene: &Scene,
    settings: &Settings,
    rays: &[ProbeRay],
    brute_force: Option<bool>,
    limits: &Limits,
) -> Result<Probed, RenderError> {
    if settings.precision == Precision::Double {
        return Err(RenderError::NoDouble { device: "a probe of the kernels' twins".into() });
    }
    let p =
        Probe::new(Recipe::of(scene).for_any_ray(scene), scene, settings, rays.len(), brute_force, limits);
    let (packed, plan) = (&p.0.packed, p.0.plan()?);
    let memory = Memory::new(&plan.buffer_bytes, packed, &packed.camera(scene, &p.0.settings));
    p.trace(&mut OnTwins(memory, plan.specialisation), rays)
}

impl Renderer {
    /// Traces `rays` against `scene` and spawns their children.
    pub fn probe(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        rays: &[ProbeRay],
    ) -> Result<Probed, RenderError> {
        self.check_precision(settings)?;
        let (recipe, forced, limits) =
            (self.recipe(scene).for_any_ray(scene), self.forced_brute_force(), self.device().limits());
        let p = Probe::new(recipe, scene, settings, rays.len(), forced, &limits);
        let (packed, plan) = (&p.0.packed, p.0.plan()?);
        let (pipelines, _) = self.pipelines(plan, settings.precision)?;
        let device = std::rc::Rc::clone(self.device());
        let camera = packed.camera(scene, &p.0.settings);
        let batches = Batches::new(&device, pipelines, packed, camera, &p.0.settings, plan)?;
        p.trace(&mut OnDevice(batches), rays)
    }
}

fn batch(
    bank: &mut dyn Bank,
    packed: &Packed,
    ids: &Ids,
    settings: &Settings,
    plan: &Plan,
    rays: &[ProbeRay],
) -> Result<Probed, RenderError> {
    let layout = |name| Layout::of(name, settings.precision);
    let ray = layout("Ray");
    let mut bytes = vec![0u8; rays.len() * ray.stride];
    let mut media = Vec::new();
    for (i, r) in rays.iter().enumerate() {
        ray.set_real3(&mut bytes, i, "origin", r.origin);
        ray.set_real3(&mut bytes, i, "direction", r.direction);
        for c in 0..3 {
            bytes[ray.at(i, "throughput") + 4 * c..][..4].copy_from_slice(&1f32.to_le_bytes());
        }
        bytes[ray.at(i, "sample_index")..][..4].copy_from_slice(&(i as u32).to_le_bytes());
        let skip = r.skip.map_or(abi::NONE, |id| ids.primitive(id));
        bytes[ray.at(i, "skip")..][..4].copy_from_slice(&skip.to_le_bytes());
        match r.media {
            Some(list) => media.extend((0..plan_media(plan)).map(|j| list.get(j).copied().unwrap_or(0))),
            None => media.extend_from_slice(&packed.eye_media),
        }
    }
    let groups = (rays.len() as u32).div_ceil(plan.specialisation.workgroup);
    let queue =
        Queue { groups_x: groups, groups_y: 1, groups_z: 1, count: rays.len() as u32, reflections: 0 };
    bank.write(Buf::Rays, &bytes)?;
    bank.write(Buf::Media, bytemuck::cast_slice(&media))?;
    bank.write(Buf::Queue, bytemuck::bytes_of(&queue))?;
    bank.run(abi::Push {
        depth: 1,
        last_depth: 2,
        capacity: plan.capacity,
        samples: 1,
        ..Default::default()
    })?;
    let mut read = |buffer| bank.read(buffer);
    let (hits, surfaces) = (read(Buf::Hits)?, read(Buf::Surfaces)?);
    let (queue, next, next_media) = (read(Buf::NextQueue)?, read(Buf::NextRays)?, read(Buf::NextMedia)?);
    let counters = read(Buf::Counters)?;
    let (hit, surface) = (layout("Hit"), layout("Surface"));
    let mut parents = Vec::new();
    let found = (0..rays.len()).map(|i| {
        let id = ids.id(word(&hits, hit.at(i, "primitive")))?;
        let flags = word(&surfaces, surface.at(i, "flags"));
        for (bit, refracted) in [(abi::CHILD_REFLECTED, false), (abi::CHILD_REFRACTED, true)] {
            if flags & bit != 0 {
                parents.push((i, refracted));
            }
        }
        Some(ProbeHit {
            id,
            t: hit.real(&hits, hit.at(i, "t")),
            uv: [hit.real(&hits, hit.at(i, "u")), hit.real(&hits, hit.at(i, "v"))],
            position: surface.real3(&surfaces, i, "position"),
            normal: surface.real3(&surfaces, i, "normal"),
            offset: surface.real3(&surfaces, i, "offset"),
            eta: surface.real(&surfaces, surface.at(i, "eta")),
            share: f64::from(single(&surfaces, surface.at(i, "share"))),
        })
    });
    let hits: Vec<_> = found.collect();
    let count = word(&queue, Layout::of("Queue", settings.precision).at(0, "count")) as usize;
    let m = plan_media(plan);
    let children = (0..count)
        .zip(parents)
        .map(|(i, (parent, refracted))| ProbeChild {
            parent,
            refracted,
            origin: ray.real3(&next, i, "origin"),
            direction: ray.real3(&next, i, "direction"),
            throughput: std::array::from_fn(|c| single(&next, ray.at(i, "throughput") + 4 * c)),
            skip: ids.id(word(&next, ray.at(i, "skip"))),
            media: (0..m).map(|j| word(&next_media, 4 * (i * m + j))).collect(),
        })
        .collect();
    let counters = std::array::from_fn(|i| u64::from(word(&counters, 4 * i)));
    Ok(Probed { hits, children, counters })
}

fn plan_media(plan: &Plan) -> usize {
    plan.specialisation.media_capacity as usize
}
