use super::*;
use crate::cli::args::{Cli, Command, Verbosity};
use crate::render::Rendered;
use crate::report::{DepthInfo, Report};
use crate::scene::Scene;
use crate::settings::Schedule;
use crate::settings::sampler::Sampler;
use crate::settings::{Hierarchy, Origin, Precision, Settings};
use clap::Parser;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::{Arc, Mutex};

/// A writer whose text can be read afterwards.
#[derive(Clone, Default)]
struct Tape(Arc<Mutex<Vec<u8>>>);

impl Write for Tape {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Tape {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }
}

fn arguments(words: &[&str]) -> RenderArgs {
    let all = ["whitted", "render", "a.toml"].iter().chain(words);
    let Command::Render(args) = Cli::try_parse_from(all).unwrap().command else { panic!("render expected") };
    *args
}

fn own_settings(args: &RenderArgs, scene: &Scene) -> Result<Settings, Failure> {
    render_settings(args, scene)
}

fn scene() -> Scene {
    crate::lab::gallery::tests::subject("a", 60, 20).scene
}

fn rendered(done: f64) -> Rendered {
    let mut report = Report::default();
    (report.settings.width, report.settings.height) = (3, 2);
    (report.settings.samples, report.settings.depth) = (20, 4);
    (report.rays.primary, report.rays.shadow) = (1_000_000, 234_000);
    report.rays.by_depth = vec![DepthInfo::of(1, [1_000_000, 0, 0, 234_000])];
    report.time.render = 1.5;
    Rendered { width: 3, height: 2, linear: vec![[0.5; 3]; 6], done, report, state: None }
}

fn deliver_to(folder: &Path, more: &[&str], done: f64) -> (Result<(), Failure>, String) {
    let (image, report) = (folder.join("a.png"), folder.join("a.json"));
    let mut words = vec!["-o", image.to_str().unwrap(), "--report", report.to_str().unwrap()];
    words.extend(more);
    let args = arguments(&words);
    let tape = Tape::default();
    let Verbosity { quiet, verbose } = args.verbosity;
    let mut console = Console::on(Box::new(tape.clone()), Verbosity { quiet, verbose });
    let format = check(&args, None).unwrap();
    let surfaces = &FirstSurfaces::default();
    let deliver = Deliver { args: &args, format, layers: &[], surfaces, before: 0.0, complete: done == 1.0 };
    let delivered = deliver.deliver(rendered(done), Instant::now(), |_| Ok(None), &mut console);
    let result = delivered.and_then(|Delivered { report, kept }| match done {
        1.0 => Ok(()),
        _ => Err(interrupted(&args, &report, done, kept)),
    });
    (result, tape.text())
}

#[test]
fn options_override_the_scene() {
    let own = own_settings(&arguments(&["-o", "a.png"]), &scene()).unwrap();
    assert_eq!(own, Settings::of(&scene()));
    let words = "-o a.png --size 40x30 --samples 7 --depth 9 --cutoff 0.01 --sampler stratified --seed 5 --precision f64 --origin fixed:0.5 --crop 1,2,40,30 \
                 --tile-pixels 64 --batch-samples 3 --workgroup 128 --bvh best --general spheres,hierarchy";
    let given = own_settings(&arguments(&words.split_whitespace().collect::<Vec<_>>()), &scene()).unwrap();
    let schedule = Schedule {
        tile_pixels: Some(64),
        batch_samples: Some(3),
        workgroup: Some(128),
        hierarchy: Hierarchy::Best,
        forced_features: "spheres,hierarchy".parse().unwrap(),
        ..Schedule::default()
    };
    let want = Settings {
        width: 40,
        height: 30,
        samples: 7,
        depth: 9,
        cutoff: 0.01,
        sampler: Sampler::Stratified,
        replicates: 1,
        seed: 5,
        precision: Precision::Double,
        origin: Origin::Fixed(0.5),
        crop: Some([1, 2, 40, 30]),
        schedule,
    };
    assert_eq!(given, want);
}

#[test]
fn a_crop_outside_the_image_is_a_usage_error() {
    for crop in ["0,0,61,5", "0,0,60,6"] {
        let failure = own_settings(&arguments(&["-o", "a.png", "--crop", crop]), &scene()).unwrap_err();
        assert_eq!(failure.exit_code(), 2, "{failure}");
    }
    assert!(own_settings(&arguments(&["-o", "a.png", "--crop", "0,0,60,5"]), &scene()).is_ok());
}

#[test]
fn outputs_are_checked_first() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let code = |words: &[&str]| check(&arguments(words), None).map_err(|f| f.exit_code());
    assert_eq!(code(&["-o", &at("none/a.png")]), Err(1));
    assert_eq!(code(&["-o", &at("a.png"), "--report", &at("none/a.json")]), Err(1));
    assert_eq!(code(&["-o", &at("a.png"), "--report", &at("a.png")]), Err(2));
    assert_eq!(code(&["-o", &at("a.exr"), "--bits", "16"]), Err(2));
    assert_eq!(code(&["-o", &at("a.png"), "--bits", "16"]), Ok(Format::Png(Bits::Sixteen)));
    assert_eq!(code(&["-o", &at("a.hdr")]), Ok(Format::Hdr));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn one_line_tells_what_was_done() {
    let folder = tempfile::tempdir().unwrap();
    let (result, text) = deliver_to(folder.path(), &[], 1.0);
    result.unwrap();
    for part in ["a.png", "3x2 pixels", "20 samples", "depth 4", "1.23 M rays", "1.50 s"] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    assert_eq!(text.lines().count(), 1);
    assert_eq!(deliver_to(folder.path(), &["-q"], 1.0).1, "");

    let json = fs::read_to_string(folder.path().join("a.json")).unwrap();
    let report: Report = serde_json::from_str(&json).unwrap();
    assert!(report.image.file.ends_with("a.png"));
    assert_eq!(::image::open(folder.path().join("a.png")).unwrap().width(), 3);
}

#[test]
fn an_interrupted_render_saves_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let failure = deliver_to(folder.path(), &[], 0.375).0.unwrap_err();
    assert_eq!(failure.exit_code(), 130);
    assert!(failure.to_string().contains("37.5 % of the work is done"), "{failure}");
    let names = ["a.incomplete.png", "a.incomplete.json"].map(|name| folder.path().join(name));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing has the name of a complete file");
    assert!(names.iter().all(|name| name.exists()));
    let bytes = fs::read(&names[0]).unwrap();
    let note = b"interrupted with 37.5 % done";
    assert!(bytes.windows(note.len()).any(|w| w == note), "the image itself says it is partial");
}

#[test]
fn nothing_is_saved_of_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.png"), "an earlier image").unwrap();
    let failure = deliver_to(folder.path(), &[], 0.0).0.unwrap_err();
    assert_eq!(failure.exit_code(), 130);
    assert_eq!(fs::read_to_string(folder.path().join("a.png")).unwrap(), "an earlier image");
}

#[test]
fn validation_messages_are_failures_even_when_quiet() {
    let tape = Tape::default();
    let mut console = Console::on(Box::new(tape.clone()), Verbosity { quiet: true, verbose: false });
    validated(&[], &mut console).unwrap();
    assert_eq!(validated(&["VUID-1".into()], &mut console).unwrap_err().exit_code(), 1);
    assert_eq!(tape.text(), "VUID-1\n");
}
