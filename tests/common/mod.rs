//! What the device tests share: a device, the example scenes, buffers that live on both sides, and a
//! comparison word by word.

// Each test program uses its own part of this; a panic is a test's failure report.
#![allow(dead_code, clippy::unwrap_used)]

#[path = "../oracle/build.rs"]
pub mod build;

use std::path::PathBuf;
use std::rc::Rc;
use whitted::kernel::abi::{BUFFERS, Buf, NONE, Push, STRUCTS, Specialisation, Surface};
use whitted::kernel::table::{Kernel, KernelSet};
use whitted::plan::passes;
use whitted::plan::{Plan, element_bytes, pack_for};
use whitted::prepare::Packed;
use whitted::reference::twin::single::Memory;
use whitted::render::{Rendered, Renderer};
use whitted::scene::Scene;
use whitted::settings::sampler::pcg4d;
use whitted::settings::{DeviceChoice, Precision, Settings};
use whitted::vk::{Buffers, Device, Dispatch, Pipelines, Recorder};

/// The software device. A machine without one fails the test.
pub fn device() -> Rc<Device> {
    Rc::new(Device::new(&DeviceChoice::Cpu, false).unwrap_or_else(|e| panic!("these tests need Vulkan: {e}")))
}

pub fn renderer() -> Renderer {
    Renderer::new(&DeviceChoice::Cpu).unwrap_or_else(|e| panic!("these tests need Vulkan: {e}"))
}

pub fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Rendered {
    let rendered = renderer.render(scene, settings).unwrap();
    assert_eq!(rendered.done, 1.0);
    rendered
}

/// The scenes of the repository, by file name.
pub fn scenes() -> Vec<(String, Scene)> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    assert!(files.len() >= 7, "scenes are missing: {files:?}");
    let name = |path: &PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
    files.iter().map(|path| (name(path), Scene::load(path).unwrap())).collect()
}

/// A small version of the scene's own settings.
pub fn small(scene: &Scene, width: u32, samples: u32, seed: u32) -> Settings {
    let own = Settings::of(scene);
    let height = (width * own.height / own.width).max(1);
    Settings { width, height, samples, seed, ..own }
}

/// Counter-based random numbers: the same in every run.
pub struct Rng {
    seed: u32,
    at: u32,
}

impl Rng {
    pub fn new(seed: u32) -> Rng {
        Rng { seed, at: 0 }
    }

    pub fn word(&mut self) -> u32 {
        self.at += 1;
        pcg4d([self.seed, self.at, 0x5eed, 7])[0]
    }

    /// Below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.word()) * u64::from(n)) >> 32) as u32
    }

    /// In [-1, 1).
    pub fn signed(&mut self) -> f32 {
        (self.word() >> 8) as f32 / 8_388_608.0 - 1.0
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.word() >> 8) as f32 / 16_777_216.0
    }

    pub fn vector(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.signed())
    }

    pub fn direction(&mut self) -> [f32; 3] {
        glam::Vec3::from(self.vector()).normalize_or(glam::Vec3::X).into()
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u32) as usize]
    }
}

/// Kernels of one variant on the device, with buffers as long as a `Memory`'s.
pub struct Bench {
    pipelines: Pipelines,
    buffers: Buffers,
    recorder: Recorder,
}

impl Bench {
    pub fn new(device: &Rc<Device>, spec: &Specialisation, memory: &Memory) -> Bench {
        Bench::of(KernelSet::SHIPPED, device, spec, memory)
    }

    pub fn of(set: KernelSet, device: &Rc<Device>, spec: &Specialisation, memory: &Memory) -> Bench {
        let bytes: Vec<u64> = BUFFERS
            .iter()
            .map(|(_, element, b)| {
                (memory.bytes(*b).len() as u64).max(element_bytes(element, Precision::Robust))
            })
            .collect();
        // Those that count by subgroups are made for devices on which these work together.
        let has = |p: &&passes::Pass| p.way != passes::Way::Fused || spec.lanes != 0;
        let kernels = passes::all().filter(has).map(|p| p.kernel);
        let pipelines = Pipelines::new(device, set, kernels, spec, false).unwrap();
        let buffers = Buffers::new(device, &bytes, 0).unwrap();
        let recorder = Recorder::new(device, &pipelines, &buffers, spec.workgroup).unwrap();
        Bench { pipelines, buffers, recorder }
    }

    pub fn upload(&mut self, memory: &Memory) {
        for (_, _, buffer) in BUFFERS {
            self.recorder.upload(&mut self.buffers, *buffer, memory.bytes(*buffer)).unwrap();
        }
    }

    /// Runs one kernel on what was uploaded, with every buffer under its own name.
    pub fn run(&mut self, kernel: Kernel, push: &Push, items: u32) {
        let pass = passes::all().find(|p| p.kernel == kernel).unwrap();
        self.recorder.begin().unwrap();
        self.recorder.dispatch(
            &self.pipelines,
            &self.buffers,
            &Dispatch { pass, depth: 1, push: *push, items },
        );
        self.recorder.submit(&self.buffers).unwrap();
    }

    /// The buffers as they are now, in a copy of `like`.
    pub fn download(&mut self, like: &Memory) -> Memory {
        let mut memory = like.clone();
        for (_, _, buffer) in BUFFERS {
            let words: Vec<u32> =
                bytemuck::pod_collect_to_vec(&self.recorder.read(&mut self.buffers, *buffer).unwrap());
            let to = memory.words_mut(*buffer);
            to.copy_from_slice(&words[..to.len()]);
        }
        memory
    }
}

/// For each word of an element: its field, and whether it is a float.
fn words_of(element: &str) -> Vec<(String, bool)> {
    let Some(found) = STRUCTS.iter().find(|s| s.name == element) else {
        let (count, float) = match element {
            "vec3" => (3, true),
            "float" | "real" => (1, true),
            _ => (1, false),
        };
        return vec![(String::new(), float); count];
    };
    let mut words = Vec::new();
    for line in found.glsl.lines().filter(|l| l.ends_with(';') && l.starts_with(' ')) {
        let (ty, name) = line.trim().trim_end_matches(';').split_once(' ').unwrap();
        let count = if ty.ends_with('3') { 3 } else { 1 };
        words.extend(vec![(format!(".{name}"), ty != "uint"); count]);
    }
    assert_eq!(words.len() * 4, found.size, "{element}");
    words
}

/// Distance of two floats in units of the last place: how many floats lie between them, and one.
fn ulps(a: u32, b: u32) -> u32 {
    let (x, y) = (f32::from_bits(a), f32::from_bits(b));
    if x.is_nan() && y.is_nan() {
        return 0;
    }
    // Monotone over all floats but NaN; -0 and 0 differ by one.
    let order = |w: u32| if w >> 31 == 1 { !w } else { w | 0x8000_0000 };
    order(a).abs_diff(order(b))
}

/// Every word in which two sets of buffers differ, as `buffer[i].field: a != b`. All NaN are alike.
/// Also what the kernels must leave alone is compared.
pub fn differences(a: &Memory, b: &Memory) -> Vec<String> {
    let (mut a, mut b) = (a.clone(), b.clone());
    // What a miss has beside its flags nobody reads.
    for s in a.surfaces.iter_mut().chain(&mut b.surfaces).filter(|s| s.primitive == NONE) {
        *s = Surface { primitive: NONE, flags: s.flags, ..Surface::default() };
    }
    let mut found = Vec::new();
    for (name, element, buffer) in BUFFERS {
        let layout = words_of(element);
        let (x, y) = (a.words_mut(*buffer), b.words_mut(*buffer));
        assert_eq!(x.len(), y.len(), "{name}");
        for (i, (x, y)) in x.iter().zip(y.iter()).enumerate() {
            let (field, float) = &layout[i % layout.len()];
            let at = format_args!("{name}[{}]{field}", i / layout.len()).to_string();
            if *float && ulps(*x, *y) > 0 {
                let (x, y, n) = (f32::from_bits(*x), f32::from_bits(*y), ulps(*x, *y));
                found.push(format!("{at}: {x:e} != {y:e} ({n} ulp)"));
            } else if !*float && x != y {
                found.push(format!("{at}: {x:#x} != {y:#x}"));
            }
        }
    }
    found
}

pub fn assert_same(what: &str, twin: &Memory, device: &Memory) {
    let found = differences(twin, device);
    let some = found.iter().take(8).cloned().collect::<Vec<_>>().join("\n  ");
    assert!(
        found.is_empty(),
        "{what}: {} words differ from the twin (twin != device):\n  {some}",
        found.len()
    );
}

/// The primitive that each sample's primary ray hits, in the scene's numbering, as kernels see it; a
/// pixel's samples lie side by side.
pub fn first_hits(device: &Rc<Device>, scene: &Scene, settings: &Settings) -> Vec<Option<u32>> {
    let packed = pack_for(scene, settings, &device.limits());
    let plan = Plan::new(&packed, settings, &device.limits()).unwrap();
    let pixels = settings.width * settings.height;
    assert!(plan.tile_pixels == pixels && plan.batch_samples == settings.samples, "one batch, or no map");
    let mut memory = Memory::new(&plan.buffer_bytes, &packed, &packed.camera(scene, settings));
    let push = primary_push(settings, &plan);
    memory.queue[0] = queue_of(push.items, plan.specialisation.workgroup);
    let mut bench = Bench::new(device, &plan.specialisation, &memory);
    bench.upload(&memory);
    bench.run(Kernel::Generate, &push, push.items);
    bench.run(Kernel::Intersect, &Push { depth: 1, ..push }, push.items);
    let memory = bench.download(&memory);
    let slots = |pixel: u32| (0..settings.samples).map(move |k| (k * pixels + pixel) as usize);
    // The queue has blocks of pixels, not rows.
    let mut place = vec![0; push.items as usize];
    memory.rays[..push.items as usize]
        .iter()
        .enumerate()
        .for_each(|(i, ray)| place[ray.sample_index as usize] = i);
    (0..pixels).flat_map(slots).map(|slot| original(&packed, memory.hits[place[slot]].primitive)).collect()
}

/// A primitive's number in the scene's own order.
pub fn original(packed: &Packed, primitive: u32) -> Option<u32> {
    let at = primitive as usize;
    match packed.triangles.get(at) {
        _ if primitive == NONE => None,
        Some(triangle) => Some(triangle.id),
        None => Some(packed.spheres[at - packed.triangles.len()].id),
    }
}

/// Push constants of a whole image in one batch.
pub fn primary_push(settings: &Settings, plan: &Plan) -> Push {
    let pixels = settings.width * settings.height;
    Push {
        tile_width: settings.width,
        tile_pixels: pixels,
        batch_samples: settings.samples,
        samples: settings.samples,
        seed: settings.seed,
        last_depth: settings.depth,
        capacity: plan.capacity,
        items: pixels * settings.samples,
        ..Push::default()
    }
}

/// A queue of `count` rays.
pub fn queue_of(count: u32, workgroup: u32) -> whitted::kernel::abi::Queue {
    let groups = count.div_ceil(workgroup);
    let row = whitted::kernel::abi::GROUPS_PER_ROW;
    whitted::kernel::abi::Queue {
        groups_x: groups.min(row),
        groups_y: groups.div_ceil(row),
        groups_z: 1,
        count,
        reflections: 0,
    }
}

/// Flips the last bit of the first word of `buffer` that is not NaN.
pub fn spoil(memory: &mut Memory, buffer: Buf) {
    let (name, element, _) = BUFFERS[buffer as usize];
    let layout = words_of(element);
    let counts = |i: usize, w: u32| !layout[i % layout.len()].1 || !f32::from_bits(w).is_nan();
    let mut words = memory.words_mut(buffer).iter_mut().enumerate();
    let (_, word) = words.find(|(i, w)| counts(*i, **w)).unwrap_or_else(|| panic!("{name} is all NaN"));
    *word ^= 1;
}
