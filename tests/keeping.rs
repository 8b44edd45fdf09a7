//! What was done is kept, and nothing is overwritten or wrong without a word: outputs against inputs, interrupts, closed and
//! full outputs, damaged caches, scarce threads and memory. Renders run on the software device.

#![cfg(unix)]
// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
const SMALL: [&str; 8] = ["--size", "24x20", "--samples", "2", "--depth", "3", "--device", "cpu"];
/// A render that no test waits for.
const LONG: [&str; 8] = ["--size", "96x80", "--samples", "5000", "--tile-pixels", "64", "--device", "cpu"];

/// A folder with a scene, its mesh and its materials, and a cache of its own.
struct Bench(TempDir);

impl Bench {
    fn new() -> Bench {
        let bench = Bench(tempfile::tempdir().unwrap());
        for name in ["cornell.toml", "rotated_cube.obj", "rotated_cube.mtl"] {
            fs::copy(Path::new(SCENES).join(name), bench.at(name)).unwrap();
        }
        fs::create_dir(bench.at("d")).unwrap();
        bench
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The program in this folder.
    fn whitted(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
        command.args(words).current_dir(self.0.path()).env_remove("WHITTED_DEVICE");
        command.env("XDG_CACHE_HOME", self.at("cache")).stdin(Stdio::null());
        command
    }

    fn render(&self, words: &[&str]) -> Command {
        let mut command = self.whitted(&["render", "cornell.toml"]);
        command.args(SMALL).args(words);
        command
    }

    /// By a shell, `$W` being the program, the scene and the settings of a small render.
    fn shell(&self, line: &str) -> Output {
        let mut words = vec![env!("CARGO_BIN_EXE_whitted"), "render", "cornell.toml"];
        words.extend(SMALL);
        let mut command = Command::new("sh");
        command.args(["-c", &line.replace("$W", &words.join(" "))]).current_dir(self.0.path());
        command.env("XDG_CACHE_HOME", self.at("cache")).env_remove("WHITTED_DEVICE");
        command.stdin(Stdio::null()).output().unwrap()
    }

    /// Starts a long render; once it is under way, runs `line` in a shell, with `$PID` the process.
    fn signalled(&self, words: &[&str], line: &str) -> (String, Option<i32>) {
        let mut command = self.whitted(&["render", "cornell.toml", "-v"]);
        let mut child = command.args(LONG).args(words).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
        assert!(lines.any(|line| line.starts_with("rendering: ")), "it ended before it was stopped");
        let line = line.replace("$PID", &child.id().to_string());
        assert!(Command::new("sh").args(["-c", &line]).status().unwrap().success());
        let said = lines.collect::<Vec<_>>().join("\n");
        (said, child.wait().unwrap().code())
    }

    /// Names and bytes of all files here, caches left out.
    fn files(&self) -> Vec<(String, Vec<u8>)> {
        let entries = fs::read_dir(self.0.path()).unwrap().map(Result::unwrap);
        let files = entries.filter(|e| e.file_type().unwrap().is_file());
        let mut files: Vec<_> =
            files.map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap())).collect();
        files.sort();
        files
    }

    fn names(&self) -> Vec<String> {
        self.files().into_iter().map(|(name, _)| name).collect()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn no_output_overwrites_an_input_or_another_output() {
    let bench = Bench::new();
    assert!(bench.render(&["-o", "a.png"]).status().unwrap().success());
    fs::write(bench.at("b.png"), fs::read(bench.at("a.png")).unwrap()).unwrap();
    std::os::unix::fs::symlink("a.png", bench.at("link.png")).unwrap();
    std::os::unix::fs::symlink("later.json", bench.at("dangling.json")).unwrap();
    fs::hard_link(bench.at("cornell.toml"), bench.at("hard.toml")).unwrap();
    let before = bench.files();
    let render = "render cornell.toml --device cpu --size 8x6 --samples 2";
    let cases = [
        format!("{render} -o new.png --report cornell.toml"),
        format!("{render} -o new.png --report d/../cornell.toml"),
        format!("{render} -o new.png --report hard.toml"),
        format!("{render} -o new.png --report rotated_cube.obj"),
        format!("{render} -o new.png --report rotated_cube.mtl"),
        format!("{render} -o d/new.png --report d/../d/new.png"),
        "profile cornell.toml --json later.json --trace dangling.json".to_owned(),
        format!("{render} -o new.png --reference a.png --report link.png"),
        format!("{render} -o link.png --reference a.png"),
        format!("{render} -o new.png --budget --aov samples --report new.samples.png"),
        format!("{render} -o new.png --report new.png.partial"),
        format!("{render} -o new.png --report new.incomplete.png"),
        "profile cornell.toml --trace cornell.toml".to_owned(),
        "profile cornell.toml --trace new.json --json d/../new.json".to_owned(),
        "profile cornell.toml --trace rotated_cube.obj".to_owned(),
        "plan cornell.toml --json cornell.toml".to_owned(),
        "plan cornell.toml --json d/../rotated_cube.mtl".to_owned(),
        "compare a.png b.png --diff d/../a.png".to_owned(),
        "compare a.png b.png --json link.png".to_owned(),
        "compare a.png b.png --diff new.png --json d/../new.png".to_owned(),
        "compare . d --json b.png".to_owned(),
        "sweep cornell.toml --over samples=1 -o d/..".to_owned(),
        "gallery cornell.toml -o .".to_owned(),
        "calibrate cornell.toml -o cornell.toml".to_owned(),
        "calibrate --families wires -o new.md --page d/../new.jsonl".to_owned(),
        "stress --report d/../new.md --page new.md".to_owned(),
        "stress --page new.md --report epsilon.svg".to_owned(),
        "generate rotated-cube -o new.mtl".to_owned(),
    ];
    for case in &cases {
        let output = bench.whitted(&case.split(' ').collect::<Vec<_>>()).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{case}: {said}");
        let why = ["name the same file", "would overwrite", "would fill the folder"];
        assert!(why.iter().any(|why| said.contains(why)), "{case}: {said}");
        assert!(output.stdout.is_empty(), "{case}");
        assert!(bench.files() == before, "{case}");
    }
    // Standard output that goes to the report's file.
    let output = bench.shell("$W -o - --report out.json > out.json");
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
}

#[test]
fn an_image_for_a_closed_or_full_output_is_an_error() {
    let bench = Bench::new();
    for (line, code) in [
        ("$W -o - >&-", 2),
        ("$W -o - > /dev/full", 1),
        ("$W -o a.png --report /dev/full", 1),
        ("$W -o - > /dev/null", 0),
    ] {
        let output = bench.shell(line);
        assert_eq!(output.status.code(), Some(code), "{line}: {}", text(&output.stderr));
        assert_eq!(code == 0, !text(&output.stderr).contains("error: "), "{line}: {}", text(&output.stderr));
    }
    // A reader that has gone.
    let output = bench.shell("{ $W -o -; echo $? >&2; } | sleep 0");
    let said = text(&output.stderr);
    assert!(said.trim_end().ends_with('1') && said.contains("standard output"), "{said}");
}

/// Of what an interrupt leaves, nothing has the name of a complete file; what cannot be written keeps nothing else from
/// being saved.
#[test]
fn an_interrupt_saves_what_can_be_saved() {
    let bench = Bench::new();
    let before = bench.names().len();
    let words = ["-o", "a.png", "--report", "a.json"];
    // `timeout` signals twice.
    let twice = "kill -TERM $PID; kill -TERM $PID; kill -CONT $PID";
    let (said, code) = bench.signalled(&words, twice);
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("continue with --resume (state in a.png.partial)"), "{said}");
    let names = bench.names();
    for name in ["a.incomplete.json", "a.incomplete.png", "a.png.partial"] {
        assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
    }
    assert_eq!(names.len(), before + 3, "{names:?}");

    // Another render leaves the state as it is, interrupted or not.
    let state = fs::read(bench.at("a.png.partial")).unwrap();
    let (said, code) = bench.signalled(&["-o", "a.png", "--seed", "7"], "kill -INT $PID");
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("a.png.partial.2: rename it to a.png.partial"), "{said}");
    assert!(fs::read(bench.at("a.png.partial")).unwrap() == state);
    let names = bench.names();
    assert!(names.iter().any(|n| n == "a.png.partial.2") && !names.iter().any(|n| n == "a.png"), "{names:?}");

    // The report's folder goes while it renders.
    fs::create_dir(bench.at("gone")).unwrap();
    let line = format!("rm -r '{}'; kill -INT $PID", bench.at("gone").display());
    let (said, code) = bench.signalled(&["-o", "b.png", "--report", "gone/b.json"], &line);
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("error: cannot write gone") && said.contains("state in b.png.partial"), "{said}");
    assert!(bench.at("b.png.partial").exists() && bench.at("b.incomplete.png").exists());
}

#[test]
fn what_an_interrupt_left_goes_when_the_image_is_complete() {
    let bench = Bench::new();
    let before = bench.names();
    let words = ["-o", "a.png", "--samples", "2000", "--report", "a.json"];
    let long: Vec<&str> = words.into_iter().collect();
    let slow = ["--size", "96x80", "--tile-pixels", "64", "--device", "cpu"];
    let mut command = bench.whitted(&["render", "cornell.toml", "-v"]);
    let mut child = command.args(slow).args(&long).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering: ")), "it ended before it was stopped");
    assert!(
        Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap().success()
    );
    drop(lines.last());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let mut resume = bench.whitted(&["render", "cornell.toml", "--resume"]);
    assert!(resume.args(slow).args(&long).status().unwrap().success());
    let mut after = before;
    after.extend(["a.json".into(), "a.png".into()]);
    after.sort();
    assert_eq!(bench.names(), after);
}

#[test]
fn no_damage_to_a_cache_changes_a_picture() {
    let bench = Bench::new();
    let words = ["-o", "a.png"];
    assert!(bench.render(&words).status().unwrap().success());
    let image = fs::read(bench.at("a.png")).unwrap();
    let cache = bench.at("cache/whitted");
    let mut files: Vec<PathBuf> = fs::read_dir(&cache).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|file| file.is_file());
    assert!(files.len() >= 2, "{files:?}");
    for file in &files {
        let whole = fs::read(file).unwrap();
        let mut flipped: Vec<Vec<u8>> = [0, 20, 60, whole.len() / 2, whole.len() - 1]
            .map(|at: usize| {
                let mut bytes = whole.clone();
                bytes[at] ^= 4;
                bytes
            })
            .into();
        flipped.extend([Vec::new(), whole[..whole.len() / 2].to_vec(), b"{}".to_vec()]);
        // Another cache's file, whole.
        flipped.extend(files.iter().filter(|other| *other != file).map(|other| fs::read(other).unwrap()));
        for bytes in flipped {
            fs::write(file, &bytes).unwrap();
            let output = bench.render(&words).output().unwrap();
            assert!(output.status.success(), "{}: {}", file.display(), text(&output.stderr));
            assert!(fs::read(bench.at("a.png")).unwrap() == image, "{}", file.display());
            assert!(fs::read(file).unwrap() != bytes, "{} is made anew", file.display());
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_with_what_would() {
    let bench = Bench::new();
    for command in ["render cornell.toml -o a.png", "plan cornell.toml --no-trial", "plan cornell.toml"] {
        let mut words: Vec<&str> = command.split(' ').collect();
        words.extend(["--size", "65535x65535", "--samples", "1", "--device", "cpu"]);
        let limited =
            format!("ulimit -v 6000000; exec {} {}", env!("CARGO_BIN_EXE_whitted"), words.join(" "));
        let mut shell = Command::new("sh");
        let output = shell.args(["-c", &limited]).current_dir(bench.0.path()).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{command}: {said}");
        assert!(said.contains("65535x65535 pixels needs") && said.contains("would fit"), "{command}: {said}");
    }
    let plan = bench.whitted(&["plan", "cornell.toml", "--no-trial", "--device", "cpu", "--json", "-"]);
    let json = { plan }.output().unwrap().stdout;
    let plan: serde_json::Value = serde_json::from_slice(&json).unwrap();
    let pixels = plan["settings"]["width"].as_u64().unwrap() * plan["settings"]["height"].as_u64().unwrap();
    assert!(plan["host"]["image"].as_u64().unwrap() >= 12 * pixels);
    assert!(plan["host"]["bounded"].as_u64().unwrap() > plan["host"]["image"].as_u64().unwrap());
}

#[test]
fn the_command_line_has_the_limits_of_scene_texts() {
    let bench = Bench::new();
    for words in [["--depth", "1025"], ["--depth", "1000000"], ["--samples", "16777217"], ["--samples", "0"]]
    {
        for command in ["render", "plan", "profile"] {
            let mut line = vec![command, "cornell.toml"];
            line.extend(words);
            line.extend(["-o", "a.png"].iter().filter(|_| command == "render"));
            let output = bench.whitted(&line).output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{line:?}: {}", text(&output.stderr));
        }
    }
}

/// Under every limit the program does its work or says what is wrong: no panic, no signal.
#[test]
fn scarce_threads_memory_and_stack_are_told() {
    let bench = Bench::new();
    let is_root = fs::metadata("/proc/self").is_ok_and(|m| std::os::unix::fs::MetadataExt::uid(&m) == 0);
    let mut limits: Vec<String> =
        vec!["ulimit -s 256".into(), "ulimit -v 100000".into(), "ulimit -v 500000".into()];
    // The limit on processes is not one of root's.
    if !is_root {
        limits.push("ulimit -u 1".into());
    }
    for limit in limits {
        let output = bench.shell(&format!("{limit} && $W -o a.png"));
        let said = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 1 | 4)), "{limit}: {:?} {said}", output.status);
        assert!(!said.contains("panicked"), "{limit}: {said}");
    }
}

#[test]
fn a_crafted_header_is_refused_by_compare_and_reference() {
    let bench = Bench::new();
    assert!(bench.render(&["-o", "a.exr"]).status().unwrap().success());
    let mut bytes = fs::read(bench.at("a.exr")).unwrap();
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4 + 8;
        bytes[at..at + 8].copy_from_slice(&[0x5f, 0xea, 0, 0, 0x5f, 0xea, 0, 0]);
    }
    fs::write(bench.at("bomb.exr"), bytes).unwrap();
    let compare = bench.whitted(&["compare", "bomb.exr", "a.exr"]).output().unwrap();
    let reference = bench.render(&["-o", "b.png", "--reference", "bomb.exr"]).output().unwrap();
    for output in [compare, reference] {
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("bomb.exr") && said.contains("60000x60000"), "{said}");
    }
}
