//! Settings and a scene in, an image and a report out: tiles, batches, submits.

use crate::abi::{self, Buf, DepthCount, Film, Push, Queue, Specialisation};
use crate::coincident;
use crate::kernels::Kernel;
use crate::pack::{Packed, pack};
use crate::passes::{EPILOGUE, PER_DEPTH, PROLOGUE, Pass, Size, When};
use crate::plan::{Plan, PlanError};
use crate::report::{
    Counters, DepthInfo, LocalFrameInfo, PassInfo, PlanInfo, Report, SceneInfo, SettingsInfo, TimeInfo,
};
use crate::scene::Scene;
use crate::settings::{DeviceChoice, Precision, Settings};
use crate::vk::{Buffers, DISPATCHES_MAX, Device, Dispatch, Pipelines, Recorder, Timed, VkError};
use bytemuck::Pod;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// An image with the story of its making.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Rows from the top, linear RGB, unclamped. Pixels that were not reached are black.
    pub linear: Vec<[f32; 3]>,
    /// Share of the work that was done; 1 unless interrupted.
    pub done: f64,
    /// Everything that was counted and timed (the file names in it are the caller's to fill).
    pub report: Report,
}

/// Told of the progress between submits; may end the render.
pub trait Observer {
    /// `done` of `total` units of work (samples) are finished.
    fn progress(&mut self, done: u64, total: u64);
    /// True once the render should stop after the submit in flight.
    fn cancelled(&self) -> bool;
}

/// An observer that only lets things run.
pub struct Quiet;

impl Observer for Quiet {
    fn progress(&mut self, _done: u64, _total: u64) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// Why there is no image.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No Vulkan, no device, or not the one asked for.
    #[error("{0}")]
    NoDevice(String),
    /// The device stopped answering.
    #[error("{0}")]
    DeviceLost(String),
    /// The scene or the settings cannot be rendered on this device; says what would fit.
    #[error("{0}")]
    DoesNotFit(String),
    /// Any other failed call.
    #[error("{0}")]
    Failed(String),
}

impl From<VkError> for RenderError {
    fn from(error: VkError) -> Self {
        match error {
            VkError::NoDevice(_) => RenderError::NoDevice(error.to_string()),
            VkError::Lost { .. } => RenderError::DeviceLost(error.to_string()),
            VkError::Memory { .. } => RenderError::DoesNotFit(error.to_string()),
            VkError::Call { .. } => RenderError::Failed(error.to_string()),
        }
    }
}

impl From<PlanError> for RenderError {
    fn from(error: PlanError) -> Self {
        RenderError::DoesNotFit(error.to_string())
    }
}

/// Device time of one submit to aim at: well under the two seconds after which some systems take a
/// device for hung, and often enough for a progress bar.
const SUBMIT_SECONDS: f64 = 0.25;

/// A device, ready to render.
pub struct Renderer {
    device: Rc<Device>,
    /// Kernel variants built so far, by precision and specialisation.
    variants: BTreeMap<(bool, Vec<u32>), Rc<Pipelines>>,
    opened: Duration,
    brute_force: Option<bool>,
    omitted_barrier: Option<Kernel>,
}

impl Renderer {
    /// Opens a device; with `validate`, under the validation layer.
    pub fn new(choice: &DeviceChoice, validate: bool) -> Result<Renderer, RenderError> {
        let start = Instant::now();
        let device = Rc::new(Device::new(choice, validate)?);
        Ok(Renderer {
            device,
            variants: BTreeMap::new(),
            opened: start.elapsed(),
            brute_force: None,
            omitted_barrier: None,
        })
    }

    /// Warnings and errors of the validation layer so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.device.validation_messages()
    }

    /// The device.
    pub fn device(&self) -> &Rc<Device> {
        &self.device
    }

    /// Tests every primitive (`true`) or walks the hierarchy (`false`), whatever the scene's size.
    pub fn force_brute_force(&mut self, brute_force: Option<bool>) {
        self.brute_force = brute_force;
    }

    pub(crate) fn brute_force(&self) -> Option<bool> {
        self.brute_force
    }

    /// Plants a missing barrier, for a test of the validation.
    pub fn omit_barrier_after(&mut self, kernel: Option<Kernel>) {
        self.omitted_barrier = kernel;
    }

    /// Renders `scene`.
    pub fn render(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        let start = Instant::now();
        self.check_precision(settings)?;
        let packed = pack(scene, settings, self.brute_force);
        let plan = Plan::new(&packed, settings, &self.device.limits())?;
        let built = start.elapsed();

        let start = Instant::now();
        let (pipelines, fresh) = self.pipelines(&plan.specialisation, settings.precision)?;
        let mut frame = Frame::new(&self.device, pipelines, &packed, scene, settings, &plan)?;
        frame.recorder.omit_barrier_after(self.omitted_barrier);
        if fresh {
            frame.warm_up()?;
        }
        let first_dispatch = start.elapsed() + std::mem::take(&mut self.opened);

        let start = Instant::now();
        let (linear, done) = frame.render(observer)?;
        let render = start.elapsed().as_secs_f64();
        let [x0, y0, x1, y1] = settings.region();
        let device = self.device.info();
        let mut report = frame.tally.report(settings, &packed, &plan);
        report.device = device;
        report.warnings = coincident::warnings(scene);
        report.time = TimeInfo {
            build: built.as_secs_f64(),
            first_dispatch: first_dispatch.as_secs_f64(),
            device: report.passes.iter().map(|p| p.seconds).sum(),
            render,
            ..TimeInfo::default()
        };
        Ok(Rendered { width: x1 - x0, height: y1 - y0, linear, done, report })
    }

    pub(crate) fn check_precision(&self, settings: &Settings) -> Result<(), RenderError> {
        if settings.precision == Precision::Double && !self.device.has_double() {
            return Err(RenderError::NoDevice(format!(
                "`{}` has no double precision (shaderFloat64); take --precision robust or another device",
                self.device.info().name
            )));
        }
        Ok(())
    }

    pub(crate) fn pipelines(
        &mut self,
        s: &Specialisation,
        precision: Precision,
    ) -> Result<(Rc<Pipelines>, bool), RenderError> {
        let double = precision == Precision::Double;
        let key = (double, s.values());
        if let Some(found) = self.variants.get(&key) {
            return Ok((Rc::clone(found), false));
        }
        let built = Rc::new(Pipelines::new(&self.device, s, double)?);
        self.variants.insert(key, Rc::clone(&built));
        Ok((built, true))
    }
}

/// A rectangle of pixels, in image coordinates.
#[derive(Debug, Clone, Copy)]
struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Tile {
    fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// Two halves along the longer side, or nothing for a single pixel.
    fn halves(&self) -> Option<[Tile; 2]> {
        let t = *self;
        if t.pixels() == 1 {
            None
        } else if t.height > 1 {
            let h = t.height / 2;
            Some([Tile { height: h, ..t }, Tile { y: t.y + h, height: t.height - h, ..t }])
        } else {
            let w = t.width / 2;
            Some([Tile { width: w, ..t }, Tile { x: t.x + w, width: t.width - w, ..t }])
        }
    }
}

/// Tiles of at most `pixels` pixels, rows first; the first tile last, so that `pop` takes it first.
fn tiles(region: [u32; 4], pixels: u32) -> Vec<Tile> {
    let [x0, y0, x1, y1] = region;
    let width = (x1 - x0).min(pixels);
    let height = (pixels / width).clamp(1, y1 - y0);
    let mut all = Vec::new();
    for y in (y0..y1).step_by(height as usize) {
        for x in (x0..x1).step_by(width as usize) {
            all.push(Tile { x, y, width: width.min(x1 - x), height: height.min(y1 - y) });
        }
    }
    all.reverse();
    all
}

/// What was counted and timed.
#[derive(Debug, Clone, Default)]
struct Tally {
    depths: Vec<[u64; 4]>,
    passes: BTreeMap<(u32, usize), (u64, f64)>,
    counters: [u64; abi::COUNTERS as usize],
    tiles: u64,
    batches: u64,
    samples: u64,
    pixels: u64,
}

impl Tally {
    fn add(&mut self, other: &Tally) {
        if self.depths.len() < other.depths.len() {
            self.depths.resize(other.depths.len(), [0; 4]);
        }
        for (a, b) in self.depths.iter_mut().zip(&other.depths) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        }
        for (key, (launches, seconds)) in &other.passes {
            let row = self.passes.entry(*key).or_default();
            *row = (row.0 + launches, row.1 + seconds);
        }
        self.counters.iter_mut().zip(other.counters).for_each(|(a, b)| *a += b);
        self.tiles += other.tiles;
        self.batches += other.batches;
        self.samples += other.samples;
        self.pixels += other.pixels;
    }

    fn add_timings(&mut self, timed: &[Timed]) {
        for t in timed {
            let place = frame_place(t.kernel);
            let row = self.passes.entry((t.depth, place)).or_default();
            *row = (row.0 + 1, row.1 + t.seconds);
        }
    }

    fn report(&self, settings: &Settings, packed: &Packed, plan: &Plan) -> Report {
        let mut report = Report {
            scene: SceneInfo {
                file: String::new(),
                triangles: packed.triangles.len() as u64,
                spheres: packed.spheres.len() as u64,
                lights: packed.lights.len() as u64,
                local_frame: LocalFrameInfo {
                    center: packed.frame.center.to_array(),
                    scale_log2: packed.frame.scale_log2,
                },
            },
            settings: SettingsInfo {
                width: settings.width,
                height: settings.height,
                samples: settings.samples,
                depth: settings.depth,
                sampler: "random".into(),
                precision: settings.precision.name().into(),
                seed: settings.seed,
                origin: settings.origin.name(),
                crop: settings.crop,
            },
            plan: PlanInfo {
                features: plan.features.iter().map(|f| (*f).to_owned()).collect(),
                bytes: plan.bytes(),
                tiles: self.tiles,
                batches: self.batches,
            },
            counters: Counters {
                degenerate_triangles: packed.degenerate_triangles,
                nan_rays: self.counters[abi::COUNTER_NAN_RAYS as usize],
                clamped_lights: self.counters[abi::COUNTER_CLAMPED_LIGHTS as usize],
                stack_overflow: self.counters[abi::COUNTER_STACK_OVERFLOW as usize],
                loop_cap: self.counters[abi::COUNTER_LOOP_CAP as usize],
                media_overflow: self.counters[abi::COUNTER_MEDIA_OVERFLOW as usize]
                    + packed.eye_media_dropped,
            },
            ..Report::default()
        };
        for (i, [traced, reflections, refractions, shadow]) in self.depths.iter().enumerate() {
            if *traced == 0 {
                break;
            }
            report.rays.primary += if i == 0 { *traced } else { 0 };
            report.rays.reflection += reflections;
            report.rays.refraction += refractions;
            report.rays.shadow += shadow;
            report.rays.by_depth.push(DepthInfo { depth: i as u32 + 1, traced: *traced, shadow: *shadow });
        }
        let mut rows: Vec<_> = self.passes.iter().collect();
        rows.sort_by_key(|((depth, place), _)| (row_group(*depth, *place), *depth, *place));
        for ((depth, place), (launches, seconds)) in rows {
            let pass = crate::passes::all().nth(*place).unwrap_or(&PROLOGUE[0]);
            let at = self.depths.get((*depth).max(1) as usize - 1).map_or(0, |d| d[0]);
            let items = match pass.size {
                Size::Rays => at,
                Size::Samples => self.samples,
                Size::Pixels => self.pixels,
                Size::One => *launches,
            };
            report.passes.push(PassInfo {
                name: pass.kernel.name().into(),
                depth: *depth,
                launches: *launches,
                seconds: *seconds,
                items,
            });
        }
        report
    }
}

/// Position of a kernel in the frame.
fn frame_place(kernel: Kernel) -> usize {
    crate::passes::all().position(|p| p.kernel == kernel).unwrap_or(0)
}

/// Prologue, depths, epilogue.
fn row_group(depth: u32, place: usize) -> u32 {
    match (depth, place) {
        (0, 0) => 0,
        (0, _) => 2,
        _ => 1,
    }
}

/// One render in progress: buffers, recorder, and the state of the plan as it meets the scene.
pub(crate) struct Frame<'a> {
    pub(crate) pipelines: Rc<Pipelines>,
    pub(crate) buffers: Buffers,
    pub(crate) recorder: Recorder,
    settings: &'a Settings,
    plan: &'a Plan,
    lights: u32,
    batch_samples: u32,
    tally: Tally,
    /// Device seconds per sample so far, to size the next submit.
    rate: f64,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(
        device: &Rc<Device>,
        pipelines: Rc<Pipelines>,
        packed: &Packed,
        scene: &Scene,
        settings: &'a Settings,
        plan: &'a Plan,
    ) -> Result<Frame<'a>, VkError> {
        let film = plan.buffer_bytes[Buf::Film as usize];
        let counts = plan.buffer_bytes[Buf::DepthCounts as usize] + plan.buffer_bytes[Buf::Counters as usize];
        let mut buffers = Buffers::new(device, &plan.buffer_bytes, film.max(counts))?;
        let mut recorder = Recorder::new(device, &pipelines, &buffers, plan.specialisation.workgroup)?;
        let camera = [packed.camera(scene, settings)];
        let double = settings.precision == Precision::Double;
        let uploads = [
            (Buf::Camera, device_bytes::<_, abi::single::Camera>(&camera, double)),
            (Buf::Triangles, device_bytes::<_, abi::single::Triangle>(&packed.triangles, double)),
            (
                Buf::TriangleInfos,
                device_bytes::<_, abi::single::TriangleInfo>(&packed.triangle_infos, double),
            ),
            (
                Buf::CornerNormals,
                device_bytes::<_, abi::single::CornerNormals>(&packed.corner_normals, double),
            ),
            (Buf::Spheres, device_bytes::<_, abi::single::Sphere>(&packed.spheres, double)),
            (Buf::WideSpheres, device_bytes::<_, abi::single::WideSphere>(&packed.wide_spheres, double)),
            (Buf::SphereInfos, device_bytes::<_, abi::single::SphereInfo>(&packed.sphere_infos, double)),
            (Buf::Nodes, device_bytes::<_, abi::single::Node>(&packed.nodes, double)),
            (Buf::Materials, device_bytes::<_, abi::single::Material>(&packed.materials, double)),
            (Buf::Lights, device_bytes::<_, abi::single::Light>(&packed.lights, double)),
            (Buf::SolidIors, Cow::Borrowed(bytemuck::cast_slice(&packed.solid_iors))),
            (Buf::SolidPriorities, Cow::Borrowed(bytemuck::cast_slice(&packed.solid_priorities))),
            (Buf::EyeMedia, Cow::Borrowed(bytemuck::cast_slice(&packed.eye_media))),
        ];
        for (buffer, bytes) in uploads {
            recorder.upload(&mut buffers, buffer, &bytes)?;
        }
        Ok(Frame {
            pipelines,
            buffers,
            recorder,
            settings,
            plan,
            lights: packed.lights.len() as u32,
            batch_samples: plan.batch_samples,
            tally: Tally::default(),
            rate: 0.0,
        })
    }

    /// Runs every kernel once on one pixel: a software device compiles at the first dispatch.
    fn warm_up(&mut self) -> Result<(), RenderError> {
        let [x, y, ..] = self.settings.region();
        let tile = Tile { x, y, width: 1, height: 1 };
        self.recorder.begin()?;
        self.recorder.fill(&self.buffers, Buf::Film, 0);
        self.recorder.fill(&self.buffers, Buf::DepthCounts, 0);
        self.recorder.fill(&self.buffers, Buf::Counters, 0);
        self.batch(&tile, 0, 1, self.settings.depth.min(2));
        self.recorder.submit(&self.buffers)?;
        Ok(())
    }

    /// All tiles, until done or cancelled; the linear image and the share of samples done.
    fn render(&mut self, observer: &mut dyn Observer) -> Result<(Vec<[f32; 3]>, f64), RenderError> {
        let region = self.settings.region();
        let [x0, y0, x1, y1] = region;
        let width = x1 - x0;
        let mut linear = vec![[0.0; 3]; width as usize * (y1 - y0) as usize];
        let total = linear.len() as u64 * u64::from(self.settings.samples);
        let mut work = tiles(region, self.plan.tile_pixels);
        let mut done = 0;
        while let Some(tile) = work.pop() {
            match self.tile(&tile, observer, done, total)? {
                TileEnd::Done(samples) => {
                    let film = self.film(&tile)?;
                    for (i, pixel) in film.iter().enumerate() {
                        let (x, y) =
                            (tile.x - x0 + i as u32 % tile.width, tile.y - y0 + i as u32 / tile.width);
                        linear[(y * width + x) as usize] = mean(pixel, samples);
                    }
                    done += u64::from(tile.pixels()) * u64::from(samples);
                    if samples < self.settings.samples {
                        break;
                    }
                }
                TileEnd::Overflow if self.batch_samples > 1 => {
                    self.batch_samples /= 2;
                    work.push(tile);
                }
                TileEnd::Overflow => match tile.halves() {
                    Some([first, second]) => work.extend([second, first]),
                    None => return Err(self.pixel_too_deep(&tile)),
                },
            }
            if observer.cancelled() && !work.is_empty() {
                break;
            }
        }
        Ok((linear, done as f64 / total as f64))
    }

    fn pixel_too_deep(&self, tile: &Tile) -> RenderError {
        RenderError::DoesNotFit(format!(
            "one sample of pixel ({}, {}) has more than {} rays alive at one depth, more than a queue of this device holds; \
             try a smaller --depth",
            tile.x, tile.y, self.plan.capacity
        ))
    }

    /// All samples of one tile.
    fn tile(
        &mut self,
        tile: &Tile,
        observer: &mut dyn Observer,
        done: u64,
        total: u64,
    ) -> Result<TileEnd, RenderError> {
        let mut tally = Tally { tiles: 1, pixels: u64::from(tile.pixels()), ..Tally::default() };
        let mut first = 0;
        while first < self.settings.samples {
            self.recorder.begin()?;
            if first == 0 {
                self.recorder.fill(&self.buffers, Buf::Film, 0);
            }
            self.recorder.fill(&self.buffers, Buf::DepthCounts, 0);
            self.recorder.fill(&self.buffers, Buf::Counters, 0);
            let begin = first;
            let most = self.samples_per_submit(tile);
            let mut per_batch = 0;
            while first < self.settings.samples
                && (first == begin || first - begin < most)
                && self.recorder.dispatches() + per_batch <= DISPATCHES_MAX
            {
                let samples = self.batch_samples.min(self.settings.samples - first);
                let before = self.recorder.dispatches();
                self.batch(tile, first, samples, self.settings.depth);
                per_batch = self.recorder.dispatches() - before;
                first += samples;
                tally.batches += 1;
            }
            let counts = self.buffers.bytes(Buf::DepthCounts);
            self.recorder.download(&self.buffers, Buf::DepthCounts, counts, 0);
            self.recorder.download(&self.buffers, Buf::Counters, self.buffers.bytes(Buf::Counters), counts);
            let timed = self.recorder.submit(&self.buffers)?;
            if self.read_counts(&mut tally) {
                return Ok(TileEnd::Overflow);
            }
            let samples = u64::from(first - begin) * u64::from(tile.pixels());
            tally.depths[0][0] += samples;
            tally.samples += samples;
            tally.add_timings(&timed);
            let seconds: f64 = timed.iter().map(|t| t.seconds).sum();
            self.rate = seconds / samples as f64;
            observer.progress(done + u64::from(first) * u64::from(tile.pixels()), total);
            if observer.cancelled() {
                break;
            }
        }
        self.tally.add(&tally);
        Ok(TileEnd::Done(first))
    }

    /// Samples of a pixel in the next submit: one batch until the pace is known, then as many as
    /// fill the aimed time, within what the 32-bit counts of a submit can hold.
    fn samples_per_submit(&self, tile: &Tile) -> u32 {
        if self.rate <= 0.0 {
            return 1;
        }
        let per_sample = self.rate * f64::from(tile.pixels());
        let rays = f64::from(self.plan.capacity) / f64::from(self.batch_samples);
        let counted = f64::from(u32::MAX) / (rays * f64::from(self.lights.max(1)));
        (SUBMIT_SECONDS / per_sample).min(counted).max(1.0) as u32
    }

    /// Adds the submit's counts; true if a queue was too small.
    fn read_counts(&mut self, tally: &mut Tally) -> bool {
        let bytes = self.buffers.bytes(Buf::DepthCounts) as usize;
        let staging = self.buffers.staging_bytes();
        let depths: Vec<DepthCount> = bytemuck::pod_collect_to_vec(&staging[..bytes]);
        let counters: Vec<u32> =
            bytemuck::pod_collect_to_vec(&staging[bytes..bytes + 4 * abi::COUNTERS as usize]);
        if counters[abi::COUNTER_QUEUE_OVERFLOW as usize] != 0 {
            return true;
        }
        let counted = Tally {
            depths: depths
                .iter()
                .map(|d| [d.traced, d.reflections, d.refractions, d.shadow].map(u64::from))
                .collect(),
            counters: std::array::from_fn(|i| u64::from(counters[i])),
            ..Tally::default()
        };
        tally.add(&counted);
        false
    }

    /// Records the frame for `samples` samples of every pixel of `tile`.
    fn batch(&mut self, tile: &Tile, first_sample: u32, samples: u32, last_depth: u32) {
        let items = tile.pixels() * samples;
        let push = Push {
            tile_x: tile.x,
            tile_y: tile.y,
            tile_width: tile.width,
            tile_pixels: tile.pixels(),
            first_sample,
            batch_samples: samples,
            samples: self.settings.samples,
            seed: self.settings.seed,
            depth: 0,
            last_depth,
            light_begin: 0,
            light_end: 0,
            capacity: self.plan.capacity,
            items,
        };
        let groups = items.div_ceil(self.plan.specialisation.workgroup);
        let queue = Queue {
            groups_x: groups.min(abi::GROUPS_PER_ROW),
            groups_y: groups.div_ceil(abi::GROUPS_PER_ROW),
            groups_z: 1,
            count: items,
            reflections: 0,
        };
        self.recorder.update(&self.buffers, Buf::Queue, bytemuck::bytes_of(&queue));
        for pass in PROLOGUE {
            self.dispatch(pass, 0, push, items);
        }
        for depth in 1..=last_depth {
            let push = Push { depth, ..push };
            for pass in PER_DEPTH {
                match pass.when {
                    When::Always => self.dispatch(pass, depth, push, 0),
                    When::NotLast if depth < last_depth => self.dispatch(pass, depth, push, 0),
                    When::Branching if self.plan.specialisation.branching != 0 => {
                        self.dispatch(pass, depth, push, 0);
                    }
                    When::PerLights => {
                        let mut begin = 0;
                        loop {
                            let end = (begin + self.plan.lights_per_pass).min(self.lights);
                            let push = Push { light_begin: begin, light_end: end, ..push };
                            self.dispatch(pass, depth, push, 0);
                            begin = end;
                            if begin >= self.lights {
                                break;
                            }
                        }
                    }
                    When::NotLast | When::Branching => {}
                }
            }
        }
        for pass in EPILOGUE {
            self.dispatch(pass, 0, push, tile.pixels());
        }
    }

    fn dispatch(&mut self, pass: &'static Pass, depth: u32, push: Push, items: u32) {
        self.recorder.dispatch(&self.pipelines, &self.buffers, &Dispatch { pass, depth, push, items });
    }

    /// The tile's running sums.
    fn film(&mut self, tile: &Tile) -> Result<Vec<Film>, RenderError> {
        let bytes = u64::from(tile.pixels()) * size_of::<Film>() as u64;
        self.recorder.begin()?;
        self.recorder.download(&self.buffers, Buf::Film, bytes, 0);
        self.recorder.submit(&self.buffers)?;
        Ok(bytemuck::pod_collect_to_vec(&self.buffers.staging_bytes()[..bytes as usize]))
    }
}

/// Host structs as the kernels want them: f64 as they are, or each number rounded to f32.
fn device_bytes<W: Pod, N: Pod + for<'w> From<&'w W>>(wide: &[W], double: bool) -> Cow<'_, [u8]> {
    if double {
        return Cow::Borrowed(bytemuck::cast_slice(wide));
    }
    let narrow: Vec<N> = wide.iter().map(N::from).collect();
    Cow::Owned(bytemuck::cast_slice(&narrow).to_vec())
}

enum TileEnd {
    /// So many samples of every pixel are in the film.
    Done(u32),
    /// A queue was too small; nothing of the tile counts.
    Overflow,
}

/// Mean of `samples` samples; both parts of the sum in f64, rounded once.
fn mean(film: &Film, samples: u32) -> [f32; 3] {
    std::array::from_fn(|c| {
        ((f64::from(film.sum[c]) + f64::from(film.compensation[c])) / f64::from(samples.max(1))) as f32
    })
}
