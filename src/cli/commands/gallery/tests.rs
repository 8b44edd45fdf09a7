use super::*;
use crate::cli::args::{Cli, Command, Verbosity};
use clap::Parser;

fn arguments(scene: &Path, folder: &Path) -> GalleryArgs {
    let (scene, folder) = (scene.to_str().unwrap(), folder.to_str().unwrap());
    let cli = Cli::try_parse_from(["whitted", "gallery", scene, "-o", folder, "--scale", "0.5"]).unwrap();
    let Command::Gallery(args) = cli.command else { panic!("gallery expected") };
    args
}

fn drawn(scene: &Scene, settings: &Settings, done: f64) -> Rendered {
    let Settings { width, height, samples, depth, .. } = *settings;
    let mut report = Report::default();
    report.scene.file = scene.file.display().to_string();
    report.settings.samples = samples;
    report.settings.depth = depth;
    report.rays.primary = 12_345;
    report.time.render = 0.25;
    let linear = vec![[depth as f32 / 4.0; 3]; width as usize * height as usize];
    Rendered { width, height, linear, done, report, state: None }
}

fn subject(name: &str) -> Subject {
    let mut subject = gallery::tests::subject(name, 24, 9);
    subject.scene.file = format!("{name}.toml").into();
    subject
}

fn quiet() -> Console {
    Console::new(Verbosity { quiet: true, verbose: false })
}

#[test]
fn all_pictures_their_reports_and_the_sheet_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let args = arguments(Path::new("a.toml"), folder.path());
    let subjects = [subject("a"), subject("a_glass")];
    let mut draw = |scene: &Scene, settings: &Settings, _: &str| Ok(drawn(scene, settings, 1.0));
    make(&args, &subjects, &mut draw, Instant::now(), &mut quiet()).unwrap();

    let mut names: Vec<String> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let want = "contact_sheet.png depth_1.png depth_2.png depth_3.png depth_4.png depth_a_glass_1.png \
                depth_a_glass_2.png depth_a_glass_3.png depth_a_glass_4.png final_a.png final_a_glass.png \
                gallery.json samples_01.png samples_02.png samples_04.png samples_10.png";
    assert_eq!(names.join(" "), want);

    let text = fs::read_to_string(folder.path().join("gallery.json")).unwrap();
    let entries: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(entries.len(), 14);
    assert_eq!(entries[13]["row"], "final");
    assert_eq!(entries[13]["report"]["scene"]["file"], "a_glass.toml");
    assert!(entries[0]["report"]["image"]["file"].as_str().unwrap().ends_with("samples_01.png"));
    assert_eq!(::image::open(folder.path().join("depth_1.png")).unwrap().width(), 12);
}

#[test]
fn an_interrupt_keeps_the_whole_pictures_only() {
    let folder = tempfile::tempdir().unwrap();
    let args = arguments(Path::new("a.toml"), folder.path());
    let mut calls = 0;
    let mut draw = |scene: &Scene, settings: &Settings, _: &str| {
        calls += 1;
        Ok(drawn(scene, settings, if calls == 3 { 0.5 } else { 1.0 }))
    };
    let failure = make(&args, &[subject("a")], &mut draw, Instant::now(), &mut quiet()).unwrap_err();
    assert_eq!(failure.exit_code(), 130);
    assert!(failure.to_string().starts_with("interrupted: 2 of 9 pictures"), "{failure}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}
