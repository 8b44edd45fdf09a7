//! Two programs drawing the same pictures in turn, each in a process of its own: this build's and, for
//! instance, that of a baseline commit (`benches/against.sh`).

use crate::cases::Case;
use crate::paired::{Run, in_turn, rows, work};
use crate::tell::{ORDER, Picture, Teller, Told};
use crate::twins::of_report;
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;
use whitted::compare::metrics;
use whitted::report::Report;

/// Runs every case with `own` and `other`.
pub fn run(
    own: &Path,
    other: &Path,
    name: &str,
    folder: &Path,
    cases: &[&Case],
    repeats: usize,
    teller: &mut Teller,
) -> Result<()> {
    for case in cases {
        let mut ours = Program::new(own, folder, case, "this");
        let mut theirs = Program::new(other, folder, case, "that");
        // Warm-up: compiled kernels go to the caches of driver and program.
        let device = ours.draw("png")?.1.device;
        theirs.draw("png")?;
        teller.device(&device);
        let mut first = || ours.draw("png").map(|drawn| drawn.0);
        let mut second = || theirs.draw("png").map(|drawn| drawn.0);
        let pairs = in_turn(repeats, &mut first, &mut second)?;
        let work = work(&pairs);
        let picture = match work.same_bits {
            Some(true) => None,
            _ => Some(apart(&mut ours, &mut theirs)?),
        };
        let rows = rows(&pairs, &ORDER);
        teller.tell(&Told {
            case,
            first: "this build",
            second: Some(name),
            pairs: repeats,
            rows,
            work,
            picture,
        });
    }
    Ok(())
}

/// A program with all it needs to draw a case.
struct Program<'a> {
    path: &'a Path,
    scene: PathBuf,
    /// Where image and report go, without an extension.
    out: PathBuf,
    case: &'a Case,
}

impl<'a> Program<'a> {
    fn new(path: &'a Path, folder: &Path, case: &'a Case, name: &str) -> Program<'a> {
        let scene = folder.join(case.scene).with_extension("toml");
        Program { path, scene, out: folder.join(format!("{}-{name}", case.scene)), case }
    }

    /// Draws to an image of that kind and reads the report.
    fn draw(&mut self, kind: &str) -> Result<(Run, Report)> {
        let Case { size: [width, height], samples, depth, .. } = self.case;
        let report = self.out.with_extension("json");
        let mut command = Command::new(self.path);
        command.arg("render").arg(&self.scene).arg("--quiet").arg("-o").arg(self.out.with_extension(kind));
        command.arg("--report").arg(&report).arg("--size").arg(format!("{width}x{height}"));
        command.arg("--samples").arg(samples.to_string()).arg("--depth").arg(depth.to_string());
        let (start, cpu) = (Instant::now(), cpu_of_children());
        let output = command.stdin(Stdio::null()).output();
        let wall = start.elapsed().as_secs_f64();
        let cpu = cpu_of_children().zip(cpu).map(|(after, before)| after - before);
        let output = output.with_context(|| format!("cannot run {}", self.path.display()))?;
        if !output.status.success() {
            bail!("{}: {}", self.path.display(), String::from_utf8_lossy(&output.stderr).trim());
        }
        let text = std::fs::read(&report).with_context(|| format!("cannot read {}", report.display()))?;
        let report: Report = serde_json::from_slice(&text)
            .with_context(|| format!("the report of {} has another form", self.path.display()))?;
        let mut run = Run { picture: report.image.linear_sha256.clone(), ..of_report(&report) };
        run.seconds.insert("wall".into(), wall);
        // Neighbours on the machine take time by the wall, but hardly CPU time.
        run.seconds.extend(cpu.map(|seconds| ("cpu".to_owned(), seconds)));
        run.seconds.insert("build".into(), report.time.build);
        run.seconds.insert("first dispatch".into(), report.time.first_dispatch);
        Ok((run, report))
    }
}

/// Seconds on all cores, of the system and of their own, that ended child processes have used; None where
/// there is no /proc. Fields 16 and 17 of proc(5) in ticks of a hundredth of a second, as Linux tells every
/// program; the second field may hold blanks, but ends with the last parenthesis.
fn cpu_of_children() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |number: usize| fields.get(number - 3)?.parse::<f64>().ok();
    Some((ticks(16)? + ticks(17)?) / 100.0)
}

/// How far the two programs' pictures are apart, in linear light.
fn apart(ours: &mut Program, theirs: &mut Program) -> Result<Picture> {
    ours.draw("exr")?;
    theirs.draw("exr")?;
    let [a, b] = [&ours.out, &theirs.out].map(|out| whitted::Picture::read(out.with_extension("exr")));
    let m = metrics::compare(&a?.linear, &b?.linear)?;
    let pixels = u64::from(ours.case.size[0]) * u64::from(ours.case.size[1]);
    Ok(Picture { rmse: m.rmse, max: m.max_abs, differing: m.differing_pixels as f64 / pixels as f64 })
}
