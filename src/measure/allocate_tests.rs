use super::super::synthetic::{Feature, Painter, Picture, Points, squared_error};
use super::*;
use rayon::prelude::*;

const CONFIDENCE: f64 = 0.95;

#[derive(Debug, Clone, Copy)]
enum Kind {
    Edges,
    Thin,
    DotsOnGradient,
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
    };
    Picture::new(side, ramp, features)
}

fn rmse2(allocation: &Allocation, picture: &Picture) -> f64 {
    let gathered = allocation.gathered();
    let image: Vec<[f64; 3]> = (0..gathered.samples.len()).map(|p| gathered.mean(p)).collect();
    squared_error(&image, &picture.truth()) / image.len() as f64
}

/// One run to the target: true error over target, samples of uniform sampling over those taken.
fn promise(kind: Kind, side: u32, target: f64, replicates: u32, seed: u32) -> (f64, f64) {
    let picture = picture(kind, side, seed);
    let painter = || Painter { picture: &picture, points: Points::Owen, replicates, seed, traced: 0 };
    let pixels = (side * side) as usize;
    let goal = Goal::for_target(target, CONFIDENCE, pixels, replicates as usize, 1 << 16);
    let mut allocation = Allocation::new(side, side, replicates as usize, goal);
    let mut source = painter();
    let Ok(outcome) = run(&mut allocation, &mut source, |_| true);
    assert_eq!(outcome, Outcome::Reached);
    assert_eq!(source.traced, allocation.samples());
    // Uniform: doubled until its bound is at the target.
    let mut uniform = goal.pilot;
    let all: Vec<u32> = (0..side * side).collect();
    loop {
        let Ok(traced) = painter().trace(&all, 0..uniform);
        let noise: Noise = traced.sums.chunks(replicates as usize).map(|sums| Noise::of(sums, uniform)).sum();
        if noise.bound(replicates as usize, CONFIDENCE).bound <= target {
            break;
        }
        uniform *= 2;
    }
    let saved = f64::from(uniform) * pixels as f64 / allocation.samples() as f64;
    (rmse2(&allocation, &picture).sqrt() / target, saved)
}

#[test]
fn the_promise_is_kept_with_fewer_samples_than_uniform() {
    for (kind, target) in [(Kind::Edges, 0.002), (Kind::Thin, 0.002), (Kind::DotsOnGradient, 0.002)] {
        let runs: Vec<(f64, f64)> =
            (0..300u32).into_par_iter().map(|seed| promise(kind, 128, target, 4, seed)).collect();
        let kept = runs.iter().filter(|r| r.0 <= 1.0).count() as f64 / runs.len() as f64;
        let middle = |of: fn(&(f64, f64)) -> f64| {
            super::super::stats::median(&runs.iter().map(of).collect::<Vec<_>>()).expect("runs")
        };
        let (error, saved) = (middle(|r| r.0), middle(|r| r.1));
        println!("{kind:?}: kept {kept:.3}, error/target {error:.2}, uniform takes {saved:.2} x as many");
        assert!(kept >= 0.935, "{kind:?}: {kept}");
        assert!(saved > 1.0, "{kind:?}: {saved}");
    }
}
