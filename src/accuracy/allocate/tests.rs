use super::super::synthetic::{Feature, Painter, Picture, Points, squared_error};
use super::super::unseen::Cap;
use super::*;

const CONFIDENCE: f64 = 0.95;

#[derive(Debug, Clone, Copy)]
enum Kind {
    Edges,
    Thin,
    DotsOnGradient,
    /// One across every pixel, at about the same place.
    Bars,
}

fn picture(kind: Kind, side: u32, seed: u32) -> Picture {
    let r = |i: u32| Picture::random(seed, i);
    let s = f64::from(side);
    let line = |i: u32| {
        let a = r(10 * i) * std::f64::consts::TAU;
        let n = [a.cos(), a.sin()];
        (n, n[0] * s * r(10 * i + 1) + n[1] * s * r(10 * i + 2))
    };
    let (ramp, features) = match kind {
        Kind::Edges => {
            let edge = |i| {
                let (n, offset) = line(i);
                (Feature::Edge { n, offset }, 0.8)
            };
            ([0.05, 0.0, 0.0], (0..3).map(edge).collect())
        }
        Kind::Thin => {
            let thin = |i| {
                let (n, offset) = line(i);
                (Feature::Line { n, offset, width: 0.05 }, 0.9)
            };
            ([0.05, 0.0, 0.0], (0..4).map(thin).collect())
        }
        Kind::DotsOnGradient => {
            let dot = |i: u32| {
                let center = [11, 12].map(|j| (r(20 * i + j) * s).floor() + 0.5);
                (Feature::Dot { center, radius: 0.1 + 0.3 * r(20 * i + 13) }, 0.8)
            };
            ([0.1, 0.1 / s, 0.1 / s], (0..60).map(dot).collect())
        }
        Kind::Bars => {
            let bar = |i: u32| {
                let offset = f64::from(i) * 1.002 + 0.1 + 0.4 * r(1);
                (Feature::Line { n: [0.0, 1.0], offset, width: 0.7 + 0.25 * r(2) }, 0.24)
            };
            ([0.01, 0.0, 0.0], (0..side).map(bar).collect())
        }
    };
    Picture::new(side, ramp, features)
}

fn image_of(allocation: &Allocation) -> Vec<[f64; 3]> {
    let gathered = allocation.gathered();
    (0..gathered.samples.len()).map(|p| gathered.mean(p)).collect()
}

fn rmse2(allocation: &Allocation, picture: &Picture) -> f64 {
    squared_error(&image_of(allocation), &picture.truth()) / allocation.gathered().samples.len() as f64
}

/// One run to the target: true error over target, samples.
fn promise(picture: &Picture, (target, caps): (f64, Caps), seed: u32) -> (f64, f64) {
    let (side, replicates) = (picture.side, 1);
    let goal = Goal::for_target(target, CONFIDENCE, (side * side) as usize, &caps, 1 << 16);
    let mut allocation = Allocation::new(side, side, replicates, goal, caps);
    let mut source = Painter { picture, points: Points::Owen, replicates: 1, seed, traced: 0 };
    let Ok(outcome) = run(&mut allocation, &mut source, |_| true);
    assert_eq!(outcome, Outcome::Reached);
    assert_eq!((source.traced, source.traced), (allocation.samples(), allocation.rays()));
    (rmse2(&allocation, picture).sqrt() / target, allocation.samples() as f64)
}

/// Samples that uniform sampling takes, doubled until its bound is at the target.
fn uniform(picture: &Picture, target: f64, seed: u32) -> f64 {
    let all: Vec<u32> = (0..picture.side * picture.side).collect();
    let mut samples = 4;
    loop {
        let mut source = Painter { picture, points: Points::Owen, replicates: 1, seed, traced: 0 };
        let Ok(traced) = source.trace(&all, 0..samples);
        let mut image = PixelSums::new(picture.side, picture.side, 1);
        image.add(&all, samples, &traced);
        let unseen = image.unseen(&Caps::default()).squares(CONFIDENCE);
        if image.noise().bound(1, CONFIDENCE, unseen).bound <= target {
            return source.traced as f64;
        }
        samples *= 2;
    }
}

/// At least 93.5 % of runs: 95 % less 1.2 sigma of 300. In images this small what no sample met weighs
/// much, and the promise is kept more often than that.
#[test]
fn the_promise_is_kept_with_fewer_samples_than_uniform() {
    let cases =
        [(Kind::Edges, 96, 0.002, 1.5), (Kind::Thin, 96, 0.002, 1.5), (Kind::DotsOnGradient, 48, 0.003, 1.0)];
    for (kind, side, target, least_saved) in cases {
        let runs: Vec<(f64, f64)> = (0..300u32)
            .into_par_iter()
            .map(|seed| {
                let picture = picture(kind, side, seed);
                let (error, samples) = promise(&picture, (target, Caps::default()), seed);
                let saved = if seed < 40 { uniform(&picture, target, seed) / samples } else { f64::NAN };
                (error, saved)
            })
            .collect();
        let kept = runs.iter().filter(|r| r.0 <= 1.0).count() as f64 / runs.len() as f64;
        let middle = |values: Vec<f64>| crate::stats::median(&values).expect("runs");
        let error = middle(runs.iter().map(|r| r.0).collect());
        let saved = middle(runs[..40].iter().map(|r| r.1).collect());
        println!("{kind:?}: kept {kept:.3}, error/target {error:.2}, uniform takes {saved:.2} x as many");
        assert!(kept >= 0.935, "{kind:?}: {kept}");
        // An allocation that gives all pixels alike saves nothing; one that overshoots errs far less.
        assert!(saved >= least_saved && error > 0.3, "{kind:?}: {saved} {error}");
    }
}

/// From one sample of every pixel on. A pixel whose one sample and whose pair's are bright can hide less than others, under
/// this cap less by a class: were it sorted by that, those that agree by chance would be a class that seems right.
#[test]
fn the_promise_is_kept_where_pixels_agree_with_their_pairs_by_chance() {
    let caps = || Caps::uniform(Cap { radiance: 0.52, ..Cap::WHITE });
    for target in [0.06, 0.04, 0.03, 0.02] {
        let runs: Vec<(f64, u32)> = (0..200u32)
            .into_par_iter()
            .map(|seed| {
                let picture = picture(Kind::Bars, 40, seed);
                let goal = Goal::for_target(target, CONFIDENCE, 1600, &caps(), 1 << 16);
                (promise(&picture, (target, caps()), seed).0, goal.pilot)
            })
            .collect();
        let kept = runs.iter().filter(|r| r.0 <= 1.0).count() as f64 / runs.len() as f64;
        println!("{target}: kept {kept:.3}, pilot {}", runs[0].1);
        assert!(kept >= 0.935, "{target}: {kept}");
    }
}

/// Every pixel has a dot of the same small area, in half of the image only.
fn dotted(side: u32, area: f64) -> Picture {
    let radius = (area / std::f64::consts::PI).sqrt();
    let dot = |p: u32| {
        let center = [f64::from(p % side) + 0.5, f64::from(p / side) + 0.5];
        (Feature::Dot { center, radius }, 1.0)
    };
    Picture::new(side, [0.0; 3], (0..side * side).filter(|p| p % side < side / 2).map(dot).collect())
}

/// Mean error of red over the dotted pixels and its standard error, over many runs.
fn bias(runs: u32, side: u32, image: impl Fn(u32) -> Vec<[f64; 3]> + Sync, area: f64) -> (f64, f64) {
    let means: Vec<f64> = (0..runs)
        .into_par_iter()
        .map(|seed| {
            let dotted = |(p, c): (usize, &[f64; 3])| (p as u32 % side < side / 2).then_some(c[0] - area);
            let errors: Vec<f64> = image(seed).iter().enumerate().filter_map(dotted).collect();
            errors.iter().sum::<f64>() / errors.len() as f64
        })
        .collect();
    let n = f64::from(runs);
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn no_pixel_is_biased_by_its_own_samples() {
    let (side, area) = (32, 0.1);
    let picture = dotted(side, area);
    let painter =
        |seed| Painter { picture: &picture, points: Points::Random, replicates: 1, seed, traced: 0 };
    let ours = |seed| {
        let goal = Goal { target: Some(0.03), confidence: CONFIDENCE, first: 4, pilot: 4, most: 64 };
        let mut allocation = Allocation::new(side, side, 1, goal, Caps::default());
        let Ok(_) = run(&mut allocation, &mut painter(seed), |_| true);
        let counts = &allocation.gathered().samples;
        assert!(counts.iter().max() > counts.iter().min(), "all alike: nothing was decided");
        image_of(&allocation)
    };
    let (mean, error) = bias(300, side, ours, area);
    println!("bias {mean:.5} +- {error:.5}");
    assert!(mean.abs() <= 3.0 * error, "{mean} {error}");

    // The planted defect: stop where the pixel's own first four samples agree, else go on to 64.
    let stopping = |seed| {
        let all: Vec<u32> = (0..side * side).collect();
        let Ok(few) = painter(seed).trace(&all, 0..4);
        let Ok(many) = painter(seed).trace(&all, 0..64);
        let mean = |sums: &[[f64; 3]], n: f64| [sums.iter().map(|s| s[0]).sum::<f64>() / n, 0.0, 0.0];
        (few.marks.iter().enumerate())
            .map(|(p, mark)| match mark.hash_least == mark.hash_most {
                true => mean(&few.sums[4 * p..][..4], 4.0),
                false => mean(&many.sums[4 * p..][..4], 64.0),
            })
            .collect()
    };
    let (mean, error) = bias(100, side, stopping, area);
    println!("stopped by its own samples: bias {mean:.5} +- {error:.5}");
    // E = p^4 + sum_k C(4, k) p^k (1 - p)^(4 - k) (k + 60 p) / 64.
    let p = area;
    let expected: f64 = p.powi(4)
        + [(1, 4.0), (2, 6.0), (3, 4.0)]
            .map(|(k, c)| c * p.powi(k) * (1.0 - p).powi(4 - k) * (f64::from(k) + 60.0 * p) / 64.0)
            .iter()
            .sum::<f64>()
        - p;
    assert!((expected + 0.0614).abs() < 5e-5 && (mean - expected).abs() <= 3.0 * error, "{mean} {expected}");
    assert!(mean.abs() > 30.0 * error);
}

/// In steps under a budget, saved and loaded between any two: the same image as in one go.
#[test]
fn a_render_in_pieces_is_the_render_in_one() {
    let picture = picture(Kind::Edges, 40, 9);
    let painter = || Painter { picture: &picture, points: Points::Owen, replicates: 1, seed: 1, traced: 0 };
    let goal = Goal { target: Some(0.01), confidence: CONFIDENCE, first: 16, pilot: 16, most: 1024 };
    let mut whole = Allocation::new(40, 40, 1, goal, Caps::default());
    let Ok(outcome) = run(&mut whole, &mut painter(), |_| true);
    assert_eq!(outcome, Outcome::Reached);
    let mut parts = Allocation::new(40, 40, 1, goal, Caps::default());
    while let Some(step) = parts.next_step(f64::INFINITY) {
        let Ok(traced) = painter().trace(&step.pixels, step.samples.clone());
        parts.record(&step, &traced);
        let text = serde_json::to_string(&parts).unwrap();
        let mut loaded: Allocation = serde_json::from_str(&text).unwrap();
        assert_eq!(loaded.next_step(f64::INFINITY), parts.next_step(f64::INFINITY));
        parts = loaded;
    }
    assert_eq!(parts.gathered(), whole.gathered());
}

/// Cut short anywhere, saved and loaded: nothing that was traced is lost, and the image is the same.
#[test]
fn a_step_may_be_cut_anywhere() {
    let picture = picture(Kind::Thin, 40, 9);
    let painter = || Painter { picture: &picture, points: Points::Owen, replicates: 1, seed: 1, traced: 0 };
    let goal = Goal { target: Some(0.003), confidence: CONFIDENCE, first: 16, pilot: 16, most: 1024 };
    let mut whole = Allocation::new(40, 40, 1, goal, Caps::default());
    let Ok(_) = run(&mut whole, &mut painter(), |_| true);
    let mut cut = Allocation::new(40, 40, 1, goal, Caps::default());
    let (mut traced, mut cuts) = (0, 0);
    for round in 0.. {
        let Some(step) = cut.next_step(f64::INFINITY) else { break };
        let first = step.pixels.len() * [3, 7, 8, 0][round % 4] / 8;
        let first = if round > 40 { step.pixels.len() } else { first };
        let mut source = painter();
        let Ok(part) = source.trace(&step.pixels[..first], step.samples.clone());
        cut.record(&step, &part);
        traced += source.traced;
        assert_eq!(cut.samples(), traced);
        cuts += usize::from(cut.is_open());
        let gathered = cut.take_gathered();
        let text = serde_json::to_string(&cut).unwrap();
        cut = serde_json::from_str(&text).unwrap();
        assert!(cut.put_gathered(gathered, Caps::default()));
    }
    assert!(cuts > 3);
    assert_eq!(cut, whole);
}

/// Without a target: every step within its budget, the bound falls, and the cap ends it.
#[test]
fn a_budget_is_kept_and_spent() {
    let picture = picture(Kind::Edges, 40, 9);
    let mut source = Painter { picture: &picture, points: Points::Owen, replicates: 1, seed: 1, traced: 0 };
    let goal = Goal { target: None, confidence: CONFIDENCE, first: 4, pilot: 4, most: 64 };
    let mut allocation = Allocation::new(40, 40, 1, goal, Caps::default());
    assert_eq!((allocation.next_step(3.0), allocation.outcome()), (None, Outcome::Unfinished));
    assert!(allocation.bound().is_none());
    let mut bounds = Vec::new();
    while let Some(step) = allocation.next_step(1000.0) {
        let before = source.traced;
        let Ok(traced) = source.trace(&step.pixels, step.samples.clone());
        allocation.record(&step, &traced);
        assert!(source.traced - before <= 1000);
        bounds.extend(allocation.bound().map(|b| b.bound));
    }
    assert_eq!(allocation.outcome(), Outcome::Capped);
    assert!(allocation.gathered().samples.iter().all(|&n| n == 64));
    assert!(bounds[bounds.len() - 1] < 0.2 * bounds[0], "{bounds:?}");
}

#[test]
fn one_pixel_and_a_flat_image_end() {
    for side in [1, 2, 9] {
        let picture = Picture::new(side, [0.5, 0.0, 0.0], Vec::new());
        let mut source =
            Painter { picture: &picture, points: Points::Owen, replicates: 1, seed: 1, traced: 0 };
        let goal = Goal::for_target(1e-6, CONFIDENCE, (side * side) as usize, &Caps::default(), 256);
        let mut allocation = Allocation::new(side, side, 1, goal, Caps::default());
        let Ok(outcome) = run(&mut allocation, &mut source, |_| true);
        // What no sample met alone keeps the bound above such a target; all that was seen is certain.
        assert_eq!((outcome, allocation.refused()), (Outcome::Reached, Some(Refusal::OutOfReach)));
        assert!(image_of(&allocation).iter().all(|c| (c[0] - 0.5).abs() < 1e-12));
        assert!(allocation.gathered().samples.iter().all(|&n| n == 256));
    }
}

/// What is brighter than white is excluded at its price, or refused at once; never sampled for in vain.
#[test]
fn a_promise_that_costs_too_much_is_refused_after_the_pilot() {
    let side = 16;
    let picture = picture(Kind::Edges, side, 3);
    let run_with = |radiance: f32, target: f64| {
        let caps = Caps::uniform(Cap { radiance, area: 0.01, ..Cap::WHITE });
        let goal = Goal::for_target(target, CONFIDENCE, (side * side) as usize, &caps, 1 << 16);
        let mut allocation = Allocation::new(side, side, 1, goal, caps);
        let mut painter =
            Painter { picture: &picture, points: Points::Owen, replicates: 1, seed: 7, traced: 0 };
        run(&mut allocation, &mut painter, |_| true).unwrap();
        let each = allocation.samples() as f64 / f64::from(side * side);
        (allocation.refused() == Some(Refusal::TooDear), each, allocation.bound().unwrap().bound)
    };
    let (refused, each, bound) = run_with(100.0, 0.02);
    assert!(!refused && bound <= 0.02 && each > 500.0, "{each} {bound}");
    let (refused, each, bound) = run_with(1e5, 0.02);
    assert!(refused && bound > 0.02 && each < 100.0, "{each} {bound}");
    // Nor is the rest sampled for ever.
    let (refused, each, _) = run_with(1e5, 2e-3);
    assert!(refused && each > 100.0 && each <= 1024.0, "{each}");
}

/// What no number of samples can give is refused after the pilot; what many can is not.
#[test]
fn a_target_out_of_reach_is_refused_after_the_pilot() {
    let side = 16;
    let picture = picture(Kind::Edges, side, 3);
    let run_with = |target: f64, most: u32| {
        let goal = Goal::for_target(target, CONFIDENCE, (side * side) as usize, &Caps::default(), most);
        let mut allocation = Allocation::new(side, side, 1, goal, Caps::default());
        let mut painter =
            Painter { picture: &picture, points: Points::Owen, replicates: 1, seed: 7, traced: 0 };
        run(&mut allocation, &mut painter, |_| true).unwrap();
        let most = allocation.gathered().samples.iter().max().copied();
        (allocation.refused(), most, allocation.bound().unwrap().bound <= target)
    };
    assert_eq!(run_with(1e-7, 1 << 16), (Some(Refusal::OutOfReach), Some(1024), false));
    assert_eq!(run_with(1e-3, 1 << 12).0, None);
    let (refused, _, reached) = run_with(1e-3, 1 << 16);
    assert!(refused.is_none() && reached);
}
