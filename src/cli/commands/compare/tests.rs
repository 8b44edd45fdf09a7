//! What the comparer must notice, on files that it reads itself.

use super::pair::judge;
use super::*;
use crate::cli::args::Verbosity;
use crate::compare::metrics;
use crate::image::{Bits, Format, View};
use std::fs::{self, File};
use std::path::PathBuf;
use tempfile::TempDir;

const WIDTH: usize = 40;
const HEIGHT: usize = 30;

fn picture() -> Vec<[f32; 3]> {
    (0..WIDTH * HEIGHT)
        .map(|i| {
            let (x, y) = ((i % WIDTH) as f32 / 40.0, (i / WIDTH) as f32 / 30.0);
            [x, y, if x > y { 0.9 } else { 0.1 }]
        })
        .collect()
}

fn silent() -> Console {
    Console::on(Box::new(std::io::sink()), Verbosity { quiet: true, verbose: false })
}

struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Bench {
        Bench { folder: tempfile::tempdir().expect("a folder") }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn save(&self, name: &str, width: usize, linear: &[[f32; 3]]) -> PathBuf {
        let path = self.at(name);
        let format = match Format::of(&path).expect("a format") {
            Format::Png(_) => Format::Png(Bits::Sixteen),
            other => other,
        };
        let view = View { width: width as u32, height: (linear.len() / width) as u32, linear };
        let mut file = File::create(&path).expect("a file");
        format.encode(view, &Metadata::default(), &mut file).expect("an image");
        path
    }

    fn args(&self, a: PathBuf, b: PathBuf) -> CompareArgs {
        CompareArgs {
            a,
            b,
            diff: None,
            output: None,
            full_scale: None,
            json: Some(self.at("figures.json")),
            metric: Metric::Rmse,
            threshold: None,
            statistical: false,
            significance: None,
            quiet: true,
        }
    }

    /// The exit code and the figures.
    fn compare(&self, args: &CompareArgs) -> (u8, serde_json::Value) {
        let result = run(args, &mut silent());
        let json = fs::read(self.at("figures.json")).expect("figures");
        (result.err().map_or(0, |e| e.exit_code()), serde_json::from_slice(&json).expect("JSON"))
    }

    /// The picture against itself with a defect, the threshold at 0.
    fn against(&self, metric: Metric, defect: impl Fn(&mut Vec<[f32; 3]>)) -> (u8, serde_json::Value) {
        let mut wrong = picture();
        defect(&mut wrong);
        let (a, b) = (self.save("a.exr", WIDTH, &wrong), self.save("b.exr", WIDTH, &picture()));
        self.compare(&CompareArgs { metric, threshold: Some(0.0), ..self.args(a, b) })
    }

    fn refused(&self, args: &CompareArgs) -> String {
        let failure = run(args, &mut silent());
        let failure = failure.expect_err("a refusal");
        assert_eq!(failure.exit_code(), 1);
        failure.to_string()
    }
}

const ALL: [Metric; 6] =
    [Metric::Rmse, Metric::Mean, Metric::Max, Metric::P999, Metric::Flip, Metric::Pixels];

#[test]
fn a_swapped_channel_and_a_shift_are_noticed_by_every_figure() {
    let bench = Bench::new();
    for metric in ALL {
        let (code, _) = bench.against(metric, |_| ());
        assert_eq!(code, 0, "{metric:?}: equal pictures");
        let (code, figures) = bench.against(metric, |image| image.iter_mut().for_each(|p| p.swap(0, 2)));
        assert_eq!(code, 6, "{metric:?}: {figures}");
        assert!(figures["metrics"]["flip"].as_f64().unwrap() > 0.1, "{figures}");
        let (code, figures) = bench.against(metric, |image| image.rotate_right(1));
        assert_eq!(
            (code, &figures["metrics"]["differing_pixels"]),
            (6, &1200.into()),
            "{metric:?}: {figures}"
        );
    }
}

#[test]
fn one_changed_pixel_is_noticed() {
    let bench = Bench::new();
    let defect = |image: &mut Vec<[f32; 3]>| image[777][1] += 0.25;
    for metric in [Metric::Rmse, Metric::Mean, Metric::Max, Metric::Flip, Metric::Pixels, Metric::Codes] {
        let (code, figures) = bench.against(metric, defect);
        assert_eq!((code, &figures["metrics"]["differing_pixels"]), (6, &1.into()), "{metric:?}: {figures}");
        assert_eq!(figures["judged"]["above"], true);
    }
    // A hundred-thousandth of one channel: no code changes, the others do.
    let small = |image: &mut Vec<[f32; 3]>| image[777][1] += 1e-5;
    assert_eq!(bench.against(Metric::Codes, small).0, 0);
    assert_eq!(bench.against(Metric::Max, small).0, 6);
}

#[test]
fn psnr_is_judged_the_other_way_round() {
    let bench = Bench::new();
    let (a, b) = (bench.save("a.png", WIDTH, &picture()), bench.save("b.exr", WIDTH, &picture()));
    let judge = |threshold| {
        let args = bench.args(a.clone(), b.clone());
        bench.compare(&CompareArgs { metric: Metric::Psnr, threshold: Some(threshold), ..args }).0
    };
    // Sixteen bits cost some 1e-5: about 100 dB.
    assert_eq!((judge(80.0), judge(120.0)), (0, 6));
    let (code, figures) = bench.compare(&CompareArgs { metric: Metric::Psnr, ..bench.args(b.clone(), b) });
    assert_eq!((code, &figures["metrics"]["psnr"]), (0, &serde_json::Value::Null));
}

#[test]
fn the_threshold_itself_is_allowed() {
    let bench = Bench::new();
    let mut wrong = picture();
    wrong[0] = [1.0, 0.0, 0.1];
    let (a, b) = (bench.save("a.exr", WIDTH, &wrong), bench.save("b.exr", WIDTH, &picture()));
    let at = |threshold| {
        let args = bench.args(a.clone(), b.clone());
        bench.compare(&CompareArgs { metric: Metric::Max, threshold: Some(threshold), ..args }).0
    };
    assert_eq!((at(1.0), at(1.0f64.next_down())), (0, 6));
}

#[test]
fn the_picture_of_the_difference_shows_where() {
    let bench = Bench::new();
    let mut wrong = picture();
    wrong[777][2] += 0.05;
    let (a, b) = (bench.save("a.exr", WIDTH, &wrong), bench.save("b.exr", WIDTH, &picture()));
    let args = CompareArgs { diff: Some(bench.at("diff.png")), ..bench.args(a, b) };
    let (_, figures) = bench.compare(&args);
    let image = ::image::open(bench.at("diff.png")).unwrap().into_rgb8();
    let (x, y) = ((777 % WIDTH) as u32, (777 / WIDTH) as u32);
    for (column, row, pixel) in image.enumerate_pixels().filter(|(x, y, _)| *x < 40 && *y < 30) {
        let expected = heat::heat(if (column, row) == (x, y) { 1.0 } else { 0.0 });
        assert_eq!(pixel.0, expected, "({column}, {row})");
    }
    let top = figures["diff"]["scale"][1].as_f64().unwrap();
    assert!((top - 0.05).abs() < 1e-6);
    // With the scale given, the same difference is a tenth of it.
    bench.compare(&CompareArgs { full_scale: Some(10.0 * top), ..args });
    let image = ::image::open(bench.at("diff.png")).unwrap().into_rgb8();
    assert_eq!(image.get_pixel(x, y).0, heat::heat(0.1));
}

#[test]
fn what_cannot_be_compared_says_why() {
    let bench = Bench::new();
    let good = bench.save("good.exr", WIDTH, &picture());
    let other = bench.save("other.exr", 2 * WIDTH, &picture());
    let text = bench.refused(&bench.args(good.clone(), other));
    assert!(text.contains("40x30") && text.contains("80x15"), "{text}");
    let text = bench.refused(&bench.args(good.clone(), bench.at("none.exr")));
    assert!(text.contains("none.exr"), "{text}");
    let mut broken = picture();
    broken[41][0] = f32::NAN;
    let text = bench.refused(&bench.args(bench.save("nan.exr", WIDTH, &broken), good.clone()));
    assert!(text.contains("nan.exr has 1 pixels") && text.contains("(1, 1)"), "{text}");
    let over = CompareArgs { json: Some(good.clone()), ..bench.args(good.clone(), good) };
    let failure = run(&over, &mut silent()).unwrap_err();
    assert_eq!(failure.exit_code(), 2);
}

#[test]
fn the_table_has_every_figure() {
    let bench = Bench::new();
    let (_, figures) = bench.against(Metric::Rmse, |image| image[0][0] = 1.0);
    let keys =
        ["rmse", "mean_abs", "max_abs", "p999", "psnr", "flip", "differing_share", "code_mean", "code_max"];
    for key in keys {
        assert!(figures["metrics"][key].is_number(), "{key}: {figures}");
    }
    let plain = metrics::compare(&[[0.5f32; 3]; 4], &[[0.25f32; 3]; 4]).unwrap();
    let figures = Figures { plain, flip: 0.125, differing_share: 1.0, code_differing_share: 1.0 };
    let judged = judge(&figures, Metric::Flip, Some(0.1));
    let about = || PictureInfo { file: "a.png".into(), width: 2, height: 2, encoding: "linear" };
    let program = ProgramInfo::default();
    let (statistical, diff) = (None, None);
    let text = text::comparison(&Comparison {
        program,
        a: about(),
        b: about(),
        metrics: figures,
        judged,
        statistical,
        diff,
    });
    for word in ["rmse", "0.25", "p999", "12.04", "flip", "threshold 0.1", "4 pixels, 100 %"] {
        assert!(text.contains(word), "{word} is missing:\n{text}");
    }
}

/// The picture with noise of a standard deviation of 0.03, by a linear congruential generator (Knuth's MMIX).
fn noisy(seed: u64) -> Vec<[f32; 3]> {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    picture().iter().map(|p| p.map(|c| 0.2 + 0.5 * c + 0.1 * uniform())).collect()
}

#[test]
fn noise_is_no_difference_and_a_bias_is_one() {
    let bench = Bench::new();
    let mut wrong = noisy(2);
    let (a, b) = (bench.save("a.exr", WIDTH, &noisy(1)), bench.save("b.exr", WIDTH, &wrong));
    let args =
        |a: &PathBuf, b: &PathBuf| CompareArgs { statistical: true, ..bench.args(a.clone(), b.clone()) };
    let (code, figures) = bench.compare(&args(&a, &b));
    let test = &figures["statistical"];
    assert_eq!((code, &test["significant"], &test["exact"]), (0, &false.into(), &false.into()), "{test}");
    // 5 x 3 blocks of 8 pixels, 1 of 32, which is the whole.
    assert_eq!((&test["tests"], &test["significance"]), (&48.into(), &0.01.into()));

    for (x, y) in (8..16).flat_map(|x| (10..20).map(move |y| (x, y))) {
        wrong[y * WIDTH + x][0] += 0.05;
    }
    let c = bench.save("c.exr", WIDTH, &wrong);
    let diff = Some(bench.at("scores.png"));
    let (code, figures) = bench.compare(&CompareArgs { diff, ..args(&a, &c) });
    let worst = &figures["statistical"]["worst"];
    assert_eq!((code, &worst["channel"], &worst["region"]), (6, &"red".into(), &vec![8, 10, 16, 20].into()));
    assert!(bench.at("scores.png").exists() && figures["diff"]["scale"][1].as_f64().unwrap() > 4.0);
    // A looser significance finds no less, a very strict one no more than noise.
    let strict = CompareArgs { significance: Some(1e-14), ..args(&a, &c) };
    assert_eq!(bench.compare(&strict).0, 0);
}

#[test]
fn without_noise_the_test_is_an_exact_comparison() {
    let bench = Bench::new();
    let mut wrong = picture();
    let a = bench.save("a.exr", WIDTH, &wrong);
    let args = |b| CompareArgs { statistical: true, ..bench.args(a.clone(), b) };
    let (code, figures) = bench.compare(&args(a.clone()));
    assert_eq!((code, &figures["statistical"]["exact"]), (0, &true.into()));
    wrong[777][1] += 1e-4;
    let (code, figures) = bench.compare(&args(bench.save("b.exr", WIDTH, &wrong)));
    let test = &figures["statistical"];
    assert_eq!((code, &test["exact"], &test["differing_pixels"]), (6, &true.into(), &1.into()));
    let small = bench.save("small.exr", 2, &picture()[..4]);
    let text = bench.refused(&CompareArgs { statistical: true, ..bench.args(small.clone(), small) });
    assert!(text.contains("cannot compare"), "{text}");
}
