#!/usr/bin/env python3
"""Holds `whitted` against POV-Ray 3.7 (Debian package `povray`): the same scenes, the same primary rays, in turn.

First, with one ray through the middle of every pixel, it compares pictures and counts rays. Then it times both in
turn: the render phase as each reports it, and the whole process by the clock on the wall and by the CPU time of all
cores. POV-Ray traces N samples of a pixel as a picture of N times as many pixels. Needs Python 3.11. Without POV-Ray it says so and ends.
"""

import argparse
import json
import math
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
try:
    import pov_scene
except ModuleNotFoundError as error:
    if error.name != "tomllib":
        raise
    sys.exit("povray.py: this needs Python 3.11 or newer, for its reader of TOML")

BENCHES = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(BENCHES)
NAMES = ["cornell", "flake", "flake2", "mesh1k", "mesh70k", "mesh280k", "mesh1m"]
USUAL = ["cornell", "flake", "mesh70k"]
# RMSE in linear light above which pictures of scenes that both can express are not the same. Facing mirrors
# on spheres magnify rounding (the flake: 2e-3); a wrong falloff or weight is above 3e-2.
PICTURES_APART = 0.01
# Share by which rays may differ and still be called equal work.
RAYS_APART = 0.01
# A run that takes longer than this many seconds is given up.
PATIENCE = 3600


def fail(message):
    sys.exit(f"povray.py: {message}")


class Spent(float):
    """Seconds by the clock on the wall, and in `cpu` those of all cores."""

    def __new__(cls, wall, cpu):
        spent = super().__new__(cls, wall)
        spent.cpu = cpu
        return spent


def cpu_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command):
    begin, cpu = time.perf_counter(), cpu_of_children()
    done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=PATIENCE)
    seconds = Spent(time.perf_counter() - begin, cpu_of_children() - cpu)
    if done.returncode:
        fail(f"{command[0]} failed ({done.returncode}): {(done.stderr or done.stdout).strip()[-2000:]}")
    return seconds, done.stdout + done.stderr


class Job:
    """A scene at a size, for both programs."""

    def __init__(self, options, scene, folder):
        with open(scene, "rb") as file:
            text = pov_scene.tomllib.load(file)
        camera, render = text["camera"], text.get("render", {})
        self.options, self.scene, self.folder = options, scene, folder
        self.name = os.path.splitext(os.path.basename(scene))[0]
        self.width, self.height = options.size or (camera.get("width", 600), camera.get("height", 500))
        self.samples = options.samples or render.get("samples", 1)
        self.depth = options.depth or render.get("depth", 4)

    def title(self):
        many = "s" if self.samples > 1 else ""
        return f"{self.name}, {self.width}x{self.height}, {self.samples} sample{many}, depth {self.depth}"

    def path(self, name):
        return os.path.join(self.folder, f"{self.name}-{name}")

    def whitted(self, samples, image):
        """Report and seconds of the whole process."""
        report = self.path("report.json")
        wall, _ = run([
            self.options.whitted, "render", self.scene, "-o", image, "--quiet", "--report", report,
            "--size", f"{self.width}x{self.height}", "--samples", str(samples), "--depth", str(self.depth),
        ])
        with open(report) as file:
            return json.load(file), wall

    def povray(self, pov, samples, image, bits=8):
        """What POV-Ray counts, and seconds of the whole process."""
        # As many primary rays, one through the middle of each pixel of a finer picture.
        finer = math.sqrt(samples)
        wall, said = run([
            self.options.povray, "+I" + pov, "+O" + image, f"+FN{bits}", "File_Gamma=sRGB",
            f"+W{round(self.width * finer)}", f"+H{round(self.height * finer)}",
            "-D", "-A", f"+WT{self.options.threads}", "-V", "+WL0",
        ])

        def number(pattern):
            found = re.search(pattern, said)
            return float(found.group(1)) if found else 0.0

        counted = {
            "primary": number(r"Pixels:\s+(\d+)"),
            "rays": number(r"Rays:\s+(\d+)"),
            "shadow": number(r"Shadow Ray Tests:\s+(\d+)"),
            "trace": number(r"Trace Time:.*?\(([\d.]+) seconds"),
        }
        if not counted["trace"]:
            fail("POV-Ray does not say how long it traced; a larger size or more samples would make it measurable")
        return counted, wall

    def converted(self, depth, mend):
        out = pov_scene.convert(self.scene, depth, mend, self.options.planted_power)
        path = self.path(f"depth{depth}{'-mended' if mend else ''}.pov")
        with open(path, "w") as file:
            file.writelines(out.text)
        return path, out


def traced(rays):
    return rays["primary"] + rays["reflection"] + rays["refraction"]


def check(job):
    """Pictures and rays with one ray a pixel."""
    mended, out = job.converted(job.depth, True)
    ours, theirs = job.path("ours.exr"), job.path("theirs.png")
    report, _ = job.whitted(1, ours)
    counted, _ = job.povray(mended, 1, theirs, bits=16)
    # POV-Ray counts rays beyond the last level too, which it does not trace. With one level less, those are
    # the last that it does trace here.
    if job.depth > 1:
        counted["rays"] = job.povray(job.converted(job.depth - 1, False)[0], 1, job.path("less.png"))[0]["rays"]
    else:
        counted["rays"] = counted["primary"]
    _, said = run([job.options.whitted, "compare", ours, theirs, "--json", "-", "--quiet"])
    metrics = json.loads(said[said.index("{"):])["metrics"]
    rays = traced(report["rays"])
    return {
        "rmse": metrics["rmse"],
        "differing_codes": metrics["code_differing_pixels"] / (job.width * job.height),
        "rays": rays,
        "rays_povray": counted["rays"],
        "rays_apart": counted["rays"] / rays - 1,
        "shadow_rays": report["rays"]["shadow"],
        "shadow_tests_povray": counted["shadow"],
        "differs": out.differs,
        "clear": out.clear,
        "device": report["device"]["name"],
    }


def quartiles(values):
    if len(values) == 1:
        return values * 3
    # Type 7 of Hyndman and Fan, as the program's own.
    return statistics.quantiles(map(float, values), n=4, method="inclusive")


def measure(job):
    pov, _ = job.converted(job.depth, False)
    ours, theirs = job.path("timed.png"), job.path("timed-povray.png")
    # Kernels compiled, caches and files read.
    report, _ = job.whitted(job.samples, ours)
    job.povray(pov, job.samples, theirs)
    rows = []
    for i in range(job.options.repeats):
        pair = {}
        for who in ("whitted", "povray") if i % 2 == 0 else ("povray", "whitted"):
            if who == "whitted":
                report, pair["wall"] = job.whitted(job.samples, ours)
                pair["render"], pair["cpu"] = report["time"]["render"], pair["wall"].cpu
            else:
                counted, pair["wall_povray"] = job.povray(pov, job.samples, theirs)
                pair["render_povray"], pair["cpu_povray"] = counted["trace"], pair["wall_povray"].cpu
        rows.append(pair)
    told = {key: quartiles([row[key] for row in rows]) for key in rows[0]}
    for phase in ("render", "wall", "cpu"):
        told[f"{phase}_ratio"] = quartiles([row[f"{phase}_povray"] / row[phase] for row in rows])
    told["primary"], told["primary_povray"] = report["rays"]["primary"], counted["primary"]
    told["all_rays"] = traced(report["rays"]) + report["rays"]["shadow"]
    return told


def tell(job, picture, times):
    apart = picture["rays_apart"]
    lines = [
        job.title(),
        f"  picture   RMSE {picture['rmse']:.2e} in linear light, {100 * picture['differing_codes']:.2f} % of the pixels "
        "differ in 8 bits; one ray a pixel" + (", POV-Ray's clear spheres made to cast shadows" if picture["clear"] else ""),
        f"  rays      {picture['rays']:,.0f} against POV-Ray's {picture['rays_povray']:,.0f} ({100 * apart:+.2f} %)"
        + (": not the same work" if abs(apart) > RAYS_APART else "")
        + f"; shadow rays {picture['shadow_rays']:,.0f}, POV-Ray's shadow tests {picture['shadow_tests_povray']:,.0f}",
    ]
    lines += [f"  differs   {what}" for what in picture["differs"]]
    if picture["clear"]:
        lines.append("  differs   timed as POV-Ray is used: it lets light through clear things, and follows it")
    if times:
        lower, median, upper = range(3)
        for phase, name in (("render", "render"), ("wall", "process"), ("cpu", "CPU time")):
            a, b, r = times[phase], times[f"{phase}_povray"], times[f"{phase}_ratio"]
            lines.append(
                f"  {name:9} {a[median]:.3f} s ({a[lower]:.3f} to {a[upper]:.3f}), POV-Ray {b[median]:.3f} s "
                f"({b[lower]:.3f} to {b[upper]:.3f}): {r[median]:.2f} times as fast ({r[lower]:.2f} to {r[upper]:.2f})")
    print("\n".join(lines), flush=True)


def write_table(path, results, repeats):
    """Replaces the block of the README."""
    rows = [
        "| scene | rays | render phase, POV-Ray's time over ours | whole process | its CPU time | pictures apart, RMSE |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for job, picture, times in results:
        def ratio(key):
            lower, median, upper = times[key]
            return f"{median:.2f} ({lower:.2f} to {upper:.2f})"

        rows.append(f"| {job.title()} | {times['all_rays'] / 1e6:.3g} M | {ratio('render_ratio')} | {ratio('wall_ratio')} | {ratio('cpu_ratio')} | {picture['rmse']:.1e} |")
    device = results[0][1]["device"]
    rows.append(f"\n{time.strftime('%Y-%m-%d')}: medians and quartiles of {repeats} pairs of runs, on `{device}` with {os.cpu_count()} cores. Above 1 is faster than POV-Ray 3.7.")
    begin, end = "<!-- povray: written by benches/povray.py -->\n", "<!-- end of povray -->"
    with open(path) as file:
        text = file.read()
    if begin not in text or end not in text:
        fail(f"{path} has no place for the table: {begin.strip()} ... {end}")
    head, rest = text.split(begin, 1)
    text = head + begin + "\n".join(rows) + "\n" + end + rest.split(end, 1)[1]
    write_whole(path, text)


def write_whole(path, text):
    with open(path + ".new", "w") as file:
        file.write(text)
    os.replace(path + ".new", path)


def size(text):
    found = re.fullmatch(r"(\d+)x(\d+)", text)
    if not found:
        raise argparse.ArgumentTypeError("write it as 512x512")
    return int(found.group(1)), int(found.group(2))


def positive(text):
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError("a whole number from 1 upward")
    return int(text)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"scene text, or one of {', '.join(NAMES)} [default: {' '.join(USUAL)}]")
    parser.add_argument("--whitted", default=os.path.join(ROOT, "target/release/whitted"), help="the program [default: target/release/whitted]")
    parser.add_argument("--povray", default="povray", help="POV-Ray's program [default: povray]")
    parser.add_argument("--repeats", type=positive, default=5, help="pairs of runs [default: 5]")
    parser.add_argument("--threads", type=positive, default=os.cpu_count(), help="POV-Ray's threads [default: all cores]")
    parser.add_argument("--size", type=size, metavar="WxH", help="[default: the scene's]")
    parser.add_argument("--samples", type=positive, help="[default: the scene's]")
    parser.add_argument("--depth", type=positive, help="[default: the scene's]")
    parser.add_argument("--pictures-only", action="store_true", help="compare pictures and rays, time nothing")
    parser.add_argument("--json", metavar="FILE", help="write each scene's figures as a line of JSON")
    parser.add_argument("--readme", metavar="FILE", help="write the table between its marks in FILE")
    parser.add_argument("--keep", metavar="FOLDER", help="keep scenes and pictures there")
    # Another falloff of light, as tests plant it: the comparison of pictures must find it.
    parser.add_argument("--planted-power", type=float, default=2.0, help=argparse.SUPPRESS)
    return parser.parse_args()


def main():
    options = arguments()
    if not shutil.which(options.povray):
        print("povray.py: POV-Ray is not installed, so nothing was measured; on Debian it is `apt-get install povray`")
        return 0
    if not os.access(options.whitted, os.X_OK):
        fail(f"{options.whitted} is no program; build it with `cargo build --release`, or name it by --whitted")
    if options.readme and options.pictures_only:
        fail("--readme needs times; leave out --pictures-only")
    folder = options.keep or tempfile.mkdtemp(prefix="whitted-povray-")
    os.makedirs(folder, exist_ok=True)
    results, apart = [], []
    try:
        for scene in options.scenes or USUAL:
            if scene in NAMES:
                run(["sh", os.path.join(BENCHES, "scenes.sh"), options.whitted, folder, scene])
                scene = os.path.join(folder, scene + ".toml")
            elif not os.path.exists(scene):
                fail(f"there is no scene {scene}; name a file, or one of {', '.join(NAMES)}")
            job = Job(options, scene, folder)
            picture = check(job)
            times = None if options.pictures_only else measure(job)
            tell(job, picture, times)
            results.append((job, picture, times))
            if picture["rmse"] > PICTURES_APART and not picture["differs"]:
                apart.append(job.name)
    finally:
        if not options.keep:
            shutil.rmtree(folder, ignore_errors=True)
    if options.json:
        keys = ("name", "width", "height", "samples", "depth")
        lines = [json.dumps({k: getattr(j, k) for k in keys} | p | (t or {})) + "\n" for j, p, t in results]
        write_whole(options.json, "".join(lines))
    if options.readme:
        write_table(options.readme, results, options.repeats)
    if apart:
        fail(f"pictures differ by more than an RMSE of {PICTURES_APART}: {', '.join(apart)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
