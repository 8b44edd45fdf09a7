//! The same checks on every driver that can be had without hardware: all scenes, the stress suite, the same bits however
//! the work is cut, and silence of the validation layer. Run by `./whitted.sh devices-test`, which brings the drivers.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

#[path = "common/drivers.rs"]
mod drivers;

use drivers::{both, lavapipe, swift_shader, whitted};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;
use whitted::Picture;
use whitted::image::{Bits, Format, Metadata, View};
use whitted::report::Report;

/// Where the program runs.
enum Place {
    /// Here, with the driver of this manifest.
    Here(PathBuf),
    /// In a folder with another system, with that system's lavapipe.
    In(PathBuf),
}

/// A driver and a folder for what its runs write.
struct Lane {
    place: Place,
    folder: TempDir,
}

/// Makes a mount namespace of its own, so that nothing stays mounted, and goes into the other system. The arguments: its
/// folder, this program's folder, the scenes, a folder for files, then the program's own.
const ENTER: &str = r#"
set -e
root=$1 program=$2 scenes=$3 files=$4
shift 4
mkdir -p "$root/whitted/program" "$root/whitted/scenes" "$root/whitted/files"
mount --bind "$program" "$root/whitted/program"
mount --bind "$scenes" "$root/whitted/scenes"
mount --bind "$files" "$root/whitted/files"
mount --bind /proc "$root/proc"
mount --bind /dev "$root/dev"
exec chroot "$root" sh -c 'cd /whitted && exec program/whitted "$@"' whitted "$@"
"#;

impl Lane {
    fn new(place: Place) -> Lane {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("files")).unwrap();
        std::os::unix::fs::symlink(scenes_folder(), folder.path().join("scenes")).unwrap();
        Lane { place, folder }
    }

    /// The program on this driver, in a folder with `scenes` and `files`.
    fn command(&self) -> Command {
        let program = Path::new(env!("CARGO_BIN_EXE_whitted"));
        let mut command = match &self.place {
            Place::Here(manifest) => {
                let mut command = whitted(&[manifest], &self.files().join("cache"));
                command.current_dir(self.folder.path());
                command
            }
            Place::In(root) => {
                let there =
                    ["usr/share/vulkan/icd.d/lvp_icd.json", "usr/share/vulkan/icd.d/lvp_icd.x86_64.json"];
                let manifest = there.iter().find(|file| root.join(file).exists());
                let manifest = manifest.unwrap_or_else(|| panic!("no lavapipe in {}", root.display()));
                let inside = whitted(&[&Path::new("/").join(manifest)], Path::new("/whitted/files/cache"));
                let mut command = Command::new("unshare");
                command.args(["--mount", "sh", "-c", ENTER, "sh"]).arg(root);
                command.arg(program.parent().unwrap()).arg(scenes_folder()).arg(self.files());
                for (name, value) in inside.get_envs() {
                    match value {
                        Some(value) => command.env(name, value),
                        None => command.env_remove(name),
                    };
                }
                command
            }
        };
        // Nothing may come from a cache of another run.
        command.env("MESA_SHADER_CACHE_DISABLE", "true");
        command
    }

    fn files(&self) -> PathBuf {
        self.folder.path().join("files")
    }

    fn run(&self, arguments: &[&str], variables: &[(&str, &str)]) -> Output {
        let output = self.command().args(arguments).envs(variables.iter().copied()).output().unwrap();
        assert!(output.status.success(), "{arguments:?} {variables:?}: {}{}", output.status, both(&output));
        output
    }

    /// Renders a scene; its report.
    fn render(&self, scene: &str, options: &[&str], variables: &[(&str, &str)]) -> Report {
        let scene = format!("scenes/{scene}.toml");
        let mut arguments = vec!["render", &scene, "-o", "files/image.png", "--report", "files/report.json"];
        arguments.extend(options);
        self.run(&arguments, variables);
        serde_json::from_slice(&std::fs::read(self.files().join("report.json")).unwrap()).unwrap()
    }
}

fn scenes_folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"))
}

fn scenes() -> Vec<String> {
    let files = std::fs::read_dir(scenes_folder()).unwrap().map(|entry| entry.unwrap().path());
    let mut names: Vec<String> = files
        .filter(|file| file.extension().is_some_and(|e| e == "toml"))
        .map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    assert!(names.len() >= 7, "scenes are missing: {names:?}");
    names
}

/// Every scene, with its own depth: nothing is counted that ought not to happen, and the image has the bits of the system's lavapipe.
fn every_scene(lane: &Lane) {
    let system = Lane::new(Place::Here(lavapipe()));
    let size = ["--size", "96x72", "--samples", "4"];
    let mut different = Vec::new();
    for scene in scenes() {
        let (found, expected) = (lane.render(&scene, &size, &[]), system.render(&scene, &size, &[]));
        assert_eq!(found.counters, Default::default(), "{scene}");
        assert!(found.warnings.is_empty(), "{scene}: {:?}", found.warnings);
        assert_eq!(found.rays.total(), expected.rays.total(), "{scene}");
        if found.image.linear_sha256 != expected.image.linear_sha256 {
            different.push(scene);
        }
    }
    assert!(different.is_empty(), "other pictures than on lavapipe: {different:?}");
}

fn every_extreme(lane: &Lane) {
    lane.run(&["stress", "--device", "cpu"], &[]);
}

/// `widths`: of lavapipe's vectors, in bits.
fn the_same_bits(lane: &Lane, widths: &[&str]) {
    for scene in ["mesh_glass", "nested_glass"] {
        let size = ["--size", "41x30", "--samples", "5"];
        let hash = |options: &[&str], variables: &[(&str, &str)]| {
            lane.render(scene, &[&size, options].concat(), variables).image.linear_sha256
        };
        let expected = hash(&[], &[]);
        for options in [
            &["--tile-pixels", "100"][..],
            &["--tile-pixels", "37", "--batch-samples", "2"],
            &["--workgroup", "32"],
            &["--workgroup", "256"],
            &["--general", "all"],
        ] {
            assert_eq!(hash(options, &[]), expected, "{scene}: {options:?}");
        }
        for width in widths {
            let variable = ("LP_NATIVE_VECTOR_WIDTH", *width);
            assert_eq!(hash(&[], &[variable]), expected, "{scene}: {variable:?}");
        }
        assert_ne!(hash(&["--seed", "1"], &[]), expected, "{scene}: the seed changes nothing");
    }
}

fn no_message_of_the_validation_layer(lane: &Lane) {
    for scene in scenes() {
        lane.render(
            &scene,
            &["--size", "20x15", "--samples", "2", "--validate", "--tile-pixels", "120"],
            &[],
        );
    }
}

/// A picture of the system's lavapipe is drawn again here: the same bits, or within the bound on rounding. A wrong pixel in
/// it is found.
fn a_picture_of_another_device_is_verified(lane: &Lane) {
    let system = Lane::new(Place::Here(lavapipe()));
    for scene in ["cornell_glass", "mesh_glass"] {
        // One sample in sixteen that takes another way is no wrong pixel; all of a pixel are.
        system.render(scene, &["--size", "48x40", "--samples", "16"], &[]);
        for file in ["image.png", "report.json"] {
            std::fs::copy(system.files().join(file), lane.files().join(file)).unwrap();
        }
        for named in ["files/report.json", "files/image.png"] {
            let said = both(&lane.run(&["verify", named], &[]));
            assert!(said.contains("same bits") || said.contains("within the bound"), "{scene}: {said}");
        }
        // Row 3, column 7.
        let picture = Picture::read(lane.files().join("image.png")).unwrap();
        let mut linear = picture.linear.clone();
        linear[3 * 48 + 7][1] = 1.0 - linear[3 * 48 + 7][1].round();
        let view = View { width: 48, height: 40, linear: &linear };
        let mut bytes = Vec::new();
        Format::Png(Bits::Eight).encode(view, &Metadata::default(), &mut bytes).unwrap();
        std::fs::write(lane.files().join("image.png"), bytes).unwrap();
        let output = lane.command().args(["verify", "files/report.json"]).output().unwrap();
        let said = both(&output);
        assert!(output.status.code() == Some(6) && said.contains("pixel (7, 3): "), "{scene}: {said}");
    }
}

macro_rules! lane {
    ($name:ident, $place:expr, $widths:expr) => {
        mod $name {
            use super::*;

            fn lane() -> Lane {
                Lane::new($place)
            }

            #[test]
            #[ignore = "run by ./whitted.sh devices-test"]
            fn every_scene() {
                super::every_scene(&lane());
            }

            #[test]
            #[ignore = "run by ./whitted.sh devices-test"]
            fn every_extreme() {
                super::every_extreme(&lane());
            }

            #[test]
            #[ignore = "run by ./whitted.sh devices-test"]
            fn the_same_bits() {
                super::the_same_bits(&lane(), &$widths);
            }

            #[test]
            #[ignore = "run by ./whitted.sh devices-test"]
            fn a_picture_of_another_device_is_verified() {
                super::a_picture_of_another_device_is_verified(&lane());
            }

            #[test]
            #[ignore = "run by ./whitted.sh devices-test"]
            fn no_message_of_the_validation_layer() {
                super::no_message_of_the_validation_layer(&lane());
            }
        }
    };
}

lane!(lavapipe, Place::Here(lavapipe()), ["128", "512"]);
lane!(swift_shader, Place::Here(swift_shader()), [""; 0]);
lane!(mesa_25, Place::In(debian_13()), ["128", "512"]);

/// The folder with a Debian 13 that the script has made.
fn debian_13() -> PathBuf {
    let folder = std::env::var_os("WHITTED_DEBIAN_13").filter(|folder| !folder.is_empty());
    PathBuf::from(folder.expect("WHITTED_DEBIAN_13 names no folder: run ./whitted.sh devices-test"))
}
