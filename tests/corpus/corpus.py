#!/usr/bin/env python3
"""Loads model files of published packages with whitted and compares them with trimesh, and pictures of some with Embree.

Every file of a format is loaded as `[[mesh]] file = ...` by the test `corpus` of this crate. Where trimesh (an independent reader)
loads it as well, the number of triangles and the bounds must be equal. Of some that both load a picture is drawn: the pixels whose
centre's ray hits the model must be those of Embree, by trimesh's triangles, but for rays within rounding of an outline. What is refused must be refused for a reason that
is listed below, file by file. The exit code is 0 if all of this holds, 1 if not, 2 if a package could not be fetched (then the
rest was still tried).

Packages are fetched at the pinned version by their ordinary clients (apt-get download, npm pack, pip download, cargo fetch) into a
cache folder, once. Needed: python3 with venv, cargo, and the clients of the packages that are asked for.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TRIMESH = ["trimesh==5.2.0", "numpy", "networkx", "embreex==4.4.0.post1", "pillow"]

# Client, package, version (Debian's is that of the release the machine runs), formats to look for.
PACKAGES = [
    ("apt", "assimp-testmodels", "", "gltf ply stl obj"),
    ("npm", "@webxr-input-profiles/assets", "1.0.20", "gltf"),
    ("cargo", "kiss3d", "0.47.0", "gltf obj stl"),
    ("cargo", "easy-gltf", "1.1.5", "gltf"),
    ("pip", "pyvista", "0.49.1", "ply stl obj"),
    ("pip", "dm_control", "1.0.50", "stl obj"),
    ("pip", "robosuite", "1.5.2", "stl obj"),
    ("pip", "robosuite_models", "1.0.0", "stl obj"),
    ("pip", "pybullet", "3.2.7", "obj stl"),
    ("apt", "embree-tools", "", "obj"),
    ("apt", "glmark2-data", "", "obj"),
]

SUFFIXES = {"gltf": [".gltf", ".glb"], "ply": [".ply"], "stl": [".stl"], "obj": [".obj"]}

# Files that are to be refused: the end of the path, and words of the reason. All others are valid.
REFUSED = {
    # Khronos withdrew glTF 1.0; its materials are WebGL programs.
    "glTF/BoxTextured-glTF/BoxTextured.gltf": "glTF 1.0",
    "glTF/BoxTextured-glTF-Binary/BoxTextured.glb": "glTF 1.0",
    "glTF/BoxTextured-glTF-Embedded/BoxTextured.gltf": "glTF 1.0",
    "glTF/BoxTextured-glTF-MaterialsCommon/BoxTextured.gltf": "glTF 1.0",
    "glTF/CesiumMilkTruck/CesiumMilkTruck.gltf": "glTF 1.0",
    "glTF/IncorrectVertexArrays/Cube_v1.gltf": "glTF 1.0",
    "glTF/TwoBoxes/TwoBoxes.gltf": "glTF 1.0",
    # Made to be refused, as assimp's tests do.
    "glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb": "not finite",
    "glTF2/IndexOutOfRange/AllIndicesOutOfRange.gltf": "names vertex 65535",
    "glTF2/IndexOutOfRange/IndexOutOfRange.gltf": "names vertex 255",
    "glTF2/MissingBin/BoxTextured.gltf": "no such file",
    "glTF2/RecursiveNodes/RecursiveNodes.gltf": "below itself",
    "glTF2/SchemaFailures/sceneWrongType.gltf": "no glTF 2.0",
    "glTF2/TestNoRootNode/NoScene.gltf": "scene 0 is named",
    "glTF2/TestNoRootNode/SceneWithoutNodes.gltf": "no triangles",
    "glTF2/wrongTypes/badArray.gltf": "no glTF 2.0",
    "glTF2/wrongTypes/badObject.gltf": "no glTF 2.0",
    "glTF2/wrongTypes/badUint.gltf": "no glTF 2.0",
    "invalid/empty.ply": "no PLY file",
    "PLY/issue623.ply": "the file cannot hold",
    "PLY/pond.0.ply": "more than the file can hold",
    # Eighty bytes, and a header alone.
    "kinova3/meshes/end_effector_link.stl": "80 bytes are no STL file",
    "tiago/meshes/wheels/suspension_rear_link.stl": "no facets",
    # Compressed, by a library that is not used here.
    "glTF2/draco/2CylinderEngine.gltf": "KHR_draco_mesh_compression",
    # Points and lines only.
    "PLY/points.ply": "a cloud of points",
}
REFUSED |= {
    f"Mesh_PrimitiveMode/Mesh_PrimitiveMode_{i:02}.gltf": "no triangles" for i in (0, 1, 2, 3, 7, 8, 9, 10)
}

# Files that trimesh reads otherwise, with the reason.
DIFFERENT = {
    # Relative numbers that reach back over several objects: trimesh leaves out the ceiling.
    "embree3/models/cornell_box.obj": "bounds off by",
}

# Least share of the files that must be read: all but those listed above; OBJ files are a corpus of their own.
LEAST_OBJ = 0.97

# Bounds may differ by the rounding of trimesh's own transforms, relative to the greatest coordinate.
BOUNDS = 1e-6


# Pixels of a picture that is compared with Embree, and those that may differ: both trace in single precision, from differently
# rounded corners, so that a ray in some thousands passes an outline on the other side.
SIZE = (160, 120)
OFF_OUTLINE = 6


def run(command, **options):
    return subprocess.run([str(c) for c in command], check=True, **options)


def fetch(client, package, version, folder):
    """Unpacks the package into `folder`."""
    part = folder.with_suffix(".part")
    if part.exists():
        shutil.rmtree(part)
    part.mkdir(parents=True)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    if client == "apt":
        run(["apt-get", "download", package], cwd=part, **quiet)
        run(["dpkg-deb", "-x", next(part.glob("*.deb")), part], **quiet)
    elif client == "npm":
        run(["npm", "pack", f"{package}@{version}"], cwd=part, **quiet)
        with tarfile.open(next(part.glob("*.tgz"))) as archive:
            archive.extractall(part, filter="data")
    elif client == "pip":
        command = [sys.executable, "-m", "pip", "download", "--no-deps", f"{package}=={version}", "-d", part]
        run(command, **quiet)
        for wheel in part.glob("*.whl"):
            zipfile.ZipFile(wheel).extractall(part)
        for source in part.glob("*.tar.gz"):
            with tarfile.open(source) as archive:
                archive.extractall(part, filter="data")
    elif client == "cargo":
        # A package of its own, so that cargo fetches this one and whatever it needs.
        (part / "src").mkdir()
        (part / "src/lib.rs").write_text("")
        (part / "Cargo.toml").write_text(
            f'[package]\nname = "fetch"\nversion = "0.0.0"\nedition = "2021"\n[workspace]\n'
            f'[dependencies]\n{package} = "={version}"\n'
        )
        command = ["cargo", "metadata", "--quiet", "--format-version", "1"]
        done = run(command, cwd=part, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        packages = json.loads(done.stdout)["packages"]
        source = next(Path(p["manifest_path"]).parent for p in packages if p["name"] == package)
        shutil.copytree(source, part / package)
    part.rename(folder)


def corpus(args):
    """Paths by format, and the packages that could not be fetched."""
    found, missing = {name: [] for name in SUFFIXES}, []
    for client, package, version, formats in PACKAGES:
        wanted = [f for f in formats.split() if f in args.formats]
        if not wanted or (args.packages and package not in args.packages):
            continue
        folder = args.cache / client / package.replace("/", "_").lstrip("@")
        if not folder.exists():
            print(f"fetching {package} {version}", file=sys.stderr)
            try:
                fetch(client, package, version, folder)
            except (subprocess.CalledProcessError, OSError, StopIteration) as error:
                detail = getattr(error, "stderr", None) or str(error)
                detail = detail.decode(errors="replace") if isinstance(detail, bytes) else detail
                missing.append(f"{package}: {detail.strip().splitlines()[-1:] or error}")
                continue
        for path in sorted(folder.rglob("*")):
            for name in wanted:
                if path.suffix.lower() in SUFFIXES[name] and path.is_file():
                    found[name].append(path.resolve())
    if args.limit:
        found = {name: paths[:: max(1, len(paths) // args.limit)] for name, paths in found.items()}
    return found, missing


def python_with_trimesh(cache):
    """The interpreter of an environment that has trimesh."""
    python = cache / "venv/bin/python"
    if not python.exists():
        run([sys.executable, "-m", "venv", cache / "venv"])
    has = subprocess.run([python, "-c", "import trimesh, embreex, PIL"], capture_output=True)
    if has.returncode:
        run([python, "-m", "pip", "install", "--quiet", *TRIMESH])
    return python


def ours(args, listed):
    """What whitted says of each file."""
    environment = dict(os.environ, WHITTED_CORPUS=str(listed))
    command = args.loader or ["cargo", "test", "--quiet", "--test", "corpus", "--"]
    command = [*command, "--ignored", "--nocapture", "load_what_is_listed"]
    done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit("the loader failed: a panic is a failure whatever the file")
    return objects(done.stdout)


ORACLE = """
import json, sys, warnings, logging
import trimesh
warnings.filterwarnings("ignore"); logging.disable(logging.CRITICAL)
for line in open(sys.argv[1]):
    said = {"file": line.rstrip("\\n")}
    try:
        loaded = trimesh.load(said["file"], process=False, skip_materials=True)
        mesh = loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded
        corners = mesh.vertices[mesh.faces].reshape(-1, 3)
        said |= {"triangles": len(mesh.faces), "lo": corners.min(0).tolist(), "hi": corners.max(0).tolist()}
    except BaseException as error:
        said["error"] = type(error).__name__
    print(json.dumps(said), flush=True)
"""


def theirs(python, listed):
    """What trimesh says of each file."""
    done = subprocess.run([python, "-c", ORACLE, listed], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return objects(done.stdout)


MASKS = """
import json, sys, tomllib, warnings, logging
import numpy as np, trimesh
from PIL import Image
from embreex import rtcore_scene as rtcs
from embreex.mesh_construction import TriangleMesh
warnings.filterwarnings("ignore"); logging.disable(logging.CRITICAL)
for line in open(sys.argv[1]):
    said = json.loads(line)
    loaded = trimesh.load(said["file"], process=False, skip_materials=True)
    mesh = loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded
    camera = tomllib.load(open(said["scene"], "rb"))["camera"]
    eye, at, up = (np.array(camera[name], float) for name in ("look_from", "look_at", "up"))
    forward = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(forward, up); right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    w, h = camera["width"], camera["height"]
    half = np.tan(np.radians(camera["fov"]) / 2)
    x = ((np.arange(w) + 0.5) / w * 2 - 1) * half * w / h
    y = (1 - (np.arange(h) + 0.5) / h * 2) * half
    d = forward + x[None, :, None] * right + y[:, None, None] * up
    # Around the eye, and of its size: single precision has most digits there.
    size = np.linalg.norm(at - eye)
    corners = ((mesh.vertices[mesh.faces] - eye) / size).astype(np.float32)
    scene = rtcs.EmbreeScene(robust=True)
    TriangleMesh(scene, corners)
    d = (d / np.linalg.norm(d, axis=2, keepdims=True)).reshape(-1, 3).astype(np.float32)
    hit = scene.run(np.zeros_like(d), d).reshape(h, w) >= 0
    ours = np.array(Image.open(said["picture"]))[:, :, 3] > 0
    differ = hit != ours
    near = np.zeros_like(hit)
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            near |= np.roll(hit, (dy, dx), (0, 1)) != hit
    said |= {"hit": int(hit.sum()), "differ": int(differ.sum()), "inside": int((differ & ~near).sum())}
    print(json.dumps(said), flush=True)
"""


def masks(args, python, paths):
    """Draws models and compares the pixels that are covered with those that Embree's rays hit; the number of failures."""
    folder = args.cache / "masks"
    folder.mkdir(exist_ok=True)
    program = args.program
    if program is None:
        run(["cargo", "build", "--release", "--quiet", "--bin", "whitted"], cwd=ROOT)
        program = ROOT / "target/release/whitted"
    jobs = []
    for number, path in enumerate(paths):
        scene, picture = folder / f"{number}.toml", folder / f"{number}.png"
        size = f"{SIZE[0]}x{SIZE[1]}"
        run([program, "import", path, "-o", scene, "--size", size, "-q"])
        draw = [program, "render", path, "-o", picture, "--size", size, "--samples", 1, "--depth", 1, "--alpha", "-q"]
        run([*draw, "--device", "cpu"])
        jobs.append({"file": str(path), "scene": str(scene), "picture": str(picture)})
    listed = folder / "jobs.json"
    listed.write_text("".join(json.dumps(job) + "\n" for job in jobs))
    done = subprocess.run([python, "-c", MASKS, listed], stdout=subprocess.PIPE, text=True)
    said = objects(done.stdout)
    failures = 0
    for path in paths:
        found = said.get(str(path), {"hit": 0, "differ": SIZE[0] * SIZE[1], "inside": 0})
        if not found["hit"] or found["differ"] > OFF_OUTLINE or found["inside"]:
            failures += 1
            print(f"    FAILED {path}: of {found['hit']} pixels hit {found['differ']} differ, {found['inside']} inside")
    differ = sum(s["differ"] for s in said.values())
    print(f"pictures: {len(paths)} compared with Embree, {differ} of {sum(s['hit'] for s in said.values())} pixels differ")
    return failures


def objects(text):
    # A test runner prints lines of its own between and before them.
    lines = (line[line.find('{"') :] for line in text.splitlines() if '{"' in line)
    return {said["file"]: said for said in map(json.loads, lines)}


def listed_reason(table, path):
    return next((words for end, words in table.items() if str(path).endswith(end)), None)


def difference(a, b):
    """How two readings differ, or None."""
    if a["triangles"] != b["triangles"]:
        return f"{a['triangles']} triangles, trimesh has {b['triangles']}"
    size = max(map(abs, b["lo"] + b["hi"])) or 1.0
    off = max(abs(x - y) for x, y in zip(a["lo"] + a["hi"], b["lo"] + b["hi"])) / size
    return None if off <= BOUNDS else f"bounds off by {off:.2g} of the size"


def judge(name, paths, here, there, cache):
    """Prints one format's rows; returns the number of failures."""
    failures, read, refused, compared = [], 0, {}, 0
    for path in paths:
        short = path.relative_to(cache) if path.is_relative_to(cache) else path
        a, b = here.get(str(path)), there.get(str(path), {"error": "not run"})
        expected = listed_reason(REFUSED, path)
        if a is None:
            failures.append(f"{short}: no answer")
        elif "error" in a:
            reason = expected or re.sub("`[^`]*`", "`...`", a["error"])
            refused.setdefault(reason, []).append(short)
            if name != "obj" and (expected is None or expected not in a["error"]):
                failures.append(f"{short}: refused: {a['error']}")
        else:
            read += 1
            if expected:
                failures.append(f"{short}: read, though it is to be refused: {expected}")
            if "error" not in b:
                compared += 1
                differs = difference(a, b)
                if differs and listed_reason(DIFFERENT, path) is None:
                    failures.append(f"{short}: {differs}; {a['notes']}")
    print(f"{name}: {len(paths)} files, {read} read, {len(paths) - read} refused; {compared} compared with trimesh")
    for reason, names in sorted(refused.items(), key=lambda item: -len(item[1])):
        print(f"    refused {len(names):4}: {reason}   ({names[0]})")
    if name == "obj" and paths and read < LEAST_OBJ * len(paths):
        failures.append(f"only {read} of {len(paths)} OBJ files are read, less than {LEAST_OBJ:.0%}")
    for failure in failures:
        print(f"    FAILED {failure}")
    return len(failures)


def is_read(said, path):
    return "error" not in said.get(str(path), {"error": "not run"})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--formats", default="gltf,ply,stl", help="of gltf, ply, stl, obj; by default %(default)s")
    parser.add_argument("--packages", help="only these packages, divided by commas")
    parser.add_argument("--cache", type=Path, default=ROOT / "target/corpus", help="where packages are kept")
    parser.add_argument("--loader", nargs="+", help="a built test `corpus` to run instead of cargo")
    parser.add_argument("--limit", type=int, help="about so many files of each format, evenly drawn")
    parser.add_argument("--masks", type=int, default=30, help="pictures to compare with Embree; by default %(default)s")
    parser.add_argument("--program", type=Path, help="the built program for pictures; by default cargo builds it")
    parser.add_argument("--json", type=Path, help="write what both said of each file")
    args = parser.parse_args()
    args.formats = args.formats.split(",")
    args.packages = args.packages and args.packages.split(",")
    args.cache = args.cache.resolve()
    args.cache.mkdir(parents=True, exist_ok=True)
    found, missing = corpus(args)
    listed = args.cache / "list.txt"
    listed.write_text("".join(f"{path}\n" for paths in found.values() for path in paths))
    here = ours(args, listed)
    python = python_with_trimesh(args.cache)
    there = theirs(python, listed)
    if args.json:
        args.json.write_text(json.dumps({"whitted": here, "trimesh": there}, indent=1))
    failures = sum(judge(name, paths, here, there, args.cache) for name, paths in found.items() if name in args.formats)
    both = [path for paths in found.values() for path in paths if is_read(here, path) and is_read(there, path)]
    drawn = both[:: max(1, -(-len(both) // args.masks))] if args.masks else []
    failures += masks(args, python, drawn)
    for package in missing:
        print(f"NOT FETCHED {package}")
    files = sum(map(len, found.values()))
    print(f"{files} files, {failures} failures, {len(missing)} packages not fetched")
    return 1 if failures else 2 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
