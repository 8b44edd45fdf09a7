//! The default render against brute force (or, in small scenes, against the hierarchy), and against the
//! kernels' twins on the CPU, all in this process.

use crate::cases::{Case, Second};
use crate::paired::{Run, in_turn, rows, work};
use crate::tell::{ORDER, Teller, Told};
use anyhow::{Context, Result, bail};
use std::path::Path;
use std::time::Instant;
use whitted::image::linear_sha256;
use whitted::plan::{Plan, pack_for};
use whitted::prepare::Packed;
use whitted::render::{Rendered, Renderer};
use whitted::report::Report;
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Settings};

/// Runs every case on one device.
pub fn run(folder: &Path, cases: &[&Case], repeats: usize, teller: &mut Teller) -> Result<()> {
    let choice: DeviceChoice =
        std::env::var("WHITTED_DEVICE").ok().map_or(Ok(DeviceChoice::Best), |text| text.parse())?;
    let mut renderer = Renderer::new(&choice)?;
    teller.device(&renderer.device().info());
    for case in cases {
        let path = folder.join(case.scene).with_extension("toml");
        let scene = Scene::load(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let mut settings = Settings::of(&scene);
        [settings.width, settings.height] = case.size;
        (settings.samples, settings.depth) = (case.samples, case.depth);
        one(case, &scene, &settings, &mut renderer, repeats, teller)?;
    }
    Ok(())
}

fn one(
    case: &Case,
    scene: &Scene,
    settings: &Settings,
    renderer: &mut Renderer,
    repeats: usize,
    teller: &mut Teller,
) -> Result<()> {
    let limits = renderer.device().limits();
    let packed = pack_for(scene, settings, &limits);
    let plan = Plan::new(&packed, settings, &limits)?;
    let brute = plan.specialisation.use_bvh == 0;
    let own = if brute { "brute force" } else { "hierarchy" };
    let other = if brute { "hierarchy" } else { "brute force" };
    let device = std::cell::RefCell::new(renderer);
    let draw = |forced: Option<bool>| {
        let mut renderer = device.borrow_mut();
        renderer.force_brute_force(forced);
        let rendered = renderer.render(scene, settings)?;
        Ok::<Run, anyhow::Error>(of_render(&rendered))
    };
    // Warm-up: kernels are compiled, caches filled.
    let warm = draw(None)?;
    let (second, pairs) = match case.second {
        Second::Nothing => {
            let runs: Vec<Run> = (0..repeats).map(|_| draw(None)).collect::<Result<_>>()?;
            // Beside itself: the table then shows no ratio.
            (None, runs.into_iter().map(|run| (run.clone(), run)).collect())
        }
        Second::OtherWalk => {
            let forced = Some(!brute);
            draw(forced)?;
            (Some(other), in_turn(repeats, &mut || draw(None), &mut || draw(forced))?)
        }
        Second::Twins => {
            let mut twins = || twin(scene, settings, &packed, &plan, warm.rays);
            (Some("CPU twins"), in_turn(repeats, &mut || draw(None), &mut twins)?)
        }
    };
    let work = work(&pairs);
    if work.same_bits == Some(false) {
        bail!("{}: {own} and {} differ in bits; that is a bug", case.scene, second.unwrap_or("itself"));
    }
    teller.tell(&Told {
        case,
        first: own,
        second,
        pairs: repeats,
        rows: rows(&pairs, &ORDER),
        work,
        picture: None,
    });
    Ok(())
}

/// One render's times by pass, the sum of all depths.
pub fn of_report(report: &Report) -> Run {
    let mut run = Run { rays: report.rays.total(), ..Run::default() };
    run.seconds.insert("render".into(), report.time.render);
    run.seconds.insert("device".into(), report.time.device);
    for pass in &report.passes {
        *run.seconds.entry(pass.name.clone()).or_default() += pass.seconds;
    }
    run
}

fn of_render(rendered: &Rendered) -> Run {
    Run { picture: linear_sha256(&rendered.linear), ..of_report(&rendered.report) }
}

fn twin(scene: &Scene, settings: &Settings, packed: &Packed, plan: &Plan, rays: u64) -> Result<Run> {
    let start = Instant::now();
    let Some((linear, counts)) = whitted::reference::twin::render(packed, scene, settings, plan) else {
        bail!("a sample has more rays at one depth than the twins' queue holds");
    };
    let seconds = start.elapsed().as_secs_f64();
    let traced: u64 = counts.depths.iter().map(|d| d[0] + d[3]).sum();
    if traced != rays {
        bail!("the twins traced {traced} rays, the kernels {rays}; that is a bug");
    }
    let seconds = [("render".to_owned(), seconds)].into();
    Ok(Run { seconds, rays: traced, picture: linear_sha256(&linear) })
}
