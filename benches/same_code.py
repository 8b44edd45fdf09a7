#!/usr/bin/env python3
"""Compares two sets of compiled kernels as a driver sees them: with their specialisation constants frozen.

    benches/same_code.py BEFORE AFTER

BEFORE and AFTER are folders of NAME.FORM.spv (target/debug/build/whitted-*/out). Needs spirv-opt and spirv-dis.
For each kernel that both have: instructions of main, and whether they are the same up to the names of values.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Constants by name; those that a set does not know are left out.
HIERARCHY = dict(triangle_count=1000, sphere_count=40, light_count=2, use_bvh=1, smooth_normals=1, media_capacity=2, branching=1)
BRUTE_FORCE = dict(triangle_count=12, sphere_count=2, light_count=1, smooth_normals=1, media_capacity=2, branching=1)
PACKET = dict(texels=1, lanes=8, stack_size=31)


def ids(commit):
    """Names of the specialisation constants in the order of their ids."""
    path = "src/kernel/abi/specialisation.rs"
    text = (ROOT / path).read_text() if commit is None else subprocess.run(
        ["git", "-C", ROOT, "show", f"{commit}:{path}"], capture_output=True, text=True, check=True).stdout
    return re.findall(r"^    (\w+): [\w]+;$", text.split("specialisation! {")[1], re.M)


def main_of(file, names, values):
    """The instructions of the kernel, with names that depend on nothing but their order."""
    with tempfile.NamedTemporaryFile(suffix=".spv") as out:
        constants = " ".join(f"{names.index(k)}:{v}" for k, v in values.items() if k in names)
        subprocess.run(["spirv-opt", "--set-spec-const-default-value", constants, "--freeze-spec-const",
                        "--fold-spec-const-op-composite", "--unify-const", "-O", "-O", "-O", "--eliminate-dead-const",
                        file, "-o", out.name], check=True)
        text = subprocess.run(["spirv-dis", "--no-header", "--raw-id", out.name], capture_output=True, text=True, check=True).stdout
    lines = [line.strip() for line in text.splitlines()]
    defined = dict(m.groups() for m in (re.match(r"(%\d+) = (.*)", line) for line in lines) if m)
    bindings = dict(m.groups() for m in (re.match(r"OpDecorate (%\d+) Binding (\d+)", line) for line in lines) if m)
    body = lines[next(i for i, line in enumerate(lines) if "OpFunction " in line):]
    local = {m[1] for m in (re.match(r"(%\d+) =", line) for line in body) if m}
    known, order = {}, {}

    def outer(name):
        if name not in known:
            text = defined.get(name, "?")
            struct = text.startswith("OpTypeStruct")
            known[name] = f"binding {bindings[name]}" if name in bindings else "struct" if struct else (
                "(" + re.sub(r"%\d+", lambda m: outer(m[0]), text) + ")")
        return known[name]

    def renamed(match):
        name = match[0]
        return order.setdefault(name, f"%{len(order)}") if name in local else outer(name)

    return [re.sub(r"%\d+", renamed, line) for line in body]


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    before, after = map(pathlib.Path, sys.argv[1:3])
    # The commit of BEFORE, if its constants have other ids.
    names = ids(sys.argv[3] if len(sys.argv) == 4 else None), ids(None)
    different = 0
    for file in sorted(after.glob("*.spv")):
        if not (before / file.name).exists():
            continue
        for what, values in (("hierarchy", HIERARCHY), ("brute force", BRUTE_FORCE)):
            values = values | (PACKET if "packet" in file.name else {}) | ({"fused": 1} if "fused" in file.name else {})
            a, b = main_of(before / file.name, names[0], values), main_of(file, names[1], values)
            counting = main_of(file, names[1], values | {"counting": 1})
            different += a != b
            print(f"{file.name:24} {what:12} {len(a):6} {len(b):6} {'same' if a == b else 'differs':8} counting {len(counting)}")
    sys.exit(1 if different else 0)


if __name__ == "__main__":
    main()
