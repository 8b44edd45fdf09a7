//! What the crate promises to programs that call it: complete reports, sources of errors, the examples.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use whitted::{DeviceChoice, Picture, RenderError, Renderer, Request, SaveError, Scene, Settings};

const SCENE: &str = "scenes/cornell.toml";

fn small(scene: &Scene) -> Settings {
    Settings { width: 24, height: 20, samples: 4, ..Settings::of(scene) }
}

fn renderer() -> Renderer {
    Renderer::new(&DeviceChoice::Cpu).unwrap()
}

#[test]
fn a_report_is_complete_without_the_command_line() {
    let start = Instant::now();
    let scene = Scene::load(SCENE).unwrap();
    let mut renderer = renderer();
    let image = renderer.render(&scene, &small(&scene)).unwrap();
    let (report, wall) = (&image.report, start.elapsed().as_secs_f64());
    assert_eq!(report.scene.file, SCENE);
    assert_eq!(report.image.linear_sha256, whitted::image::linear_sha256(&image.linear));
    let time = &report.time;
    assert!(
        time.scene > 0.0 && time.build > 0.0 && time.first_dispatch > 0.0 && time.render > 0.0,
        "{time:?}"
    );
    let parts = time.scene + time.build + time.first_dispatch + time.render;
    assert!(time.wall >= parts && time.wall <= wall, "{parts} {} {wall}", time.wall);
    // Opening the device is part of the first render only.
    let again = renderer.render(&scene, &small(&scene)).unwrap().report.time;
    assert!(again.first_dispatch < time.first_dispatch, "{again:?} after {time:?}");
}

#[test]
fn a_bounded_image_needs_no_observer_and_no_replicates() {
    let scene = Scene::load(SCENE).unwrap();
    let mut renderer = renderer();
    let settings = small(&scene);
    let image = renderer.render_bounded(&scene, &settings, &Request::settings()).unwrap();
    let error = image.report.error.as_ref().unwrap();
    assert!(error.sampling > 0.0 && error.sampling < 1.0 && error.total >= error.sampling, "{error:?}");
    assert_eq!(image.report.scene.file, SCENE);
    assert_eq!(image.report.image.linear_sha256, whitted::image::linear_sha256(&image.linear()));
    assert!(image.report.time.wall > 0.0 && image.report.time.scene > 0.0);

    let one = Settings { samples: 1, ..settings.clone() };
    let uneven = Settings { samples: 5, replicates: 2, ..settings.clone() };
    let refused = [
        renderer.render_bounded(&scene, &one, &Request::settings()),
        renderer.render_bounded(&scene, &uneven, &Request::settings()),
        renderer.render_bounded(&scene, &settings, &Request::error(0.0)),
        renderer.render_bounded(&scene, &settings, &Request { confidence: 1.0, ..Request::error(0.1) }),
    ];
    for result in refused {
        assert!(matches!(result, Err(RenderError::Settings(_))), "{:?}", result.err());
    }

    let rough = renderer.render_bounded(&scene, &settings, &Request::error(0.2)).unwrap();
    assert_eq!(rough.report.asked.met, Some(true));
    let timed = renderer.render_bounded(&scene, &settings, &Request::time(Duration::from_secs(1))).unwrap();
    assert_eq!(timed.report.asked.time, Some(1.0));
}

#[test]
fn errors_keep_their_sources() {
    let scene = Scene::load("none/such.toml").unwrap_err();
    let cause = scene.source().and_then(|e| e.downcast_ref::<std::io::Error>()).unwrap();
    assert_eq!(cause.kind(), std::io::ErrorKind::NotFound);
    assert!(!scene.to_string().contains(&cause.to_string()), "the text leaves the cause to the source");

    let picture = Picture::read("none.png").unwrap_err();
    assert!(picture.source().is_some_and(|e| e.is::<std::io::Error>()));

    let scene = Scene::load(SCENE).unwrap();
    let image = renderer().render(&scene, &small(&scene)).unwrap();
    assert!(matches!(image.save("a.jpg"), Err(SaveError::Extension { .. })));
    let unwritable = image.save("none/such/folder/a.png").unwrap_err();
    assert!(unwritable.source().is_some_and(|e| e.is::<std::io::Error>()), "{unwritable:?}");

    let Err(error) = Renderer::new(&DeviceChoice::Index(1000)) else {
        panic!("there are not so many devices")
    };
    assert!(matches!(error, RenderError::NoDevice(_)), "{error:?}");
}

/// The example as cargo has built it for these tests.
fn example(name: &str) -> Command {
    let test = std::env::current_exe().unwrap();
    let folder = test.parent().and_then(Path::parent).unwrap();
    let mut command = Command::new(folder.join("examples").join(name));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

#[test]
fn an_example_runs() {
    let folder = tempfile::tempdir().unwrap();
    let file: PathBuf = folder.path().join("ball.png");
    let out = example("render").arg(&file).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(String::from_utf8_lossy(&out.stdout).contains("intersect 1:"));
    let picture = Picture::read(&file).unwrap();
    assert_eq!((picture.width, picture.height), (300, 250));
    assert!(picture.linear.iter().flatten().any(|c| *c > 0.5), "the picture is not dark");
}
