#!/bin/sh
# Writes the benchmark's scenes by rule, with `whitted generate`: the same bytes every time.
set -eu

usage() {
    cat <<'TEXT'
usage: benches/scenes.sh WHITTED FOLDER NAME...

Writes FOLDER/NAME.toml and the OBJ files it needs with the program WHITTED.

  cornell   24 triangles and 2 spheres, one of glass; 600x500, 20 samples, depth 4
  flake     sphereflake of 7,381 spheres; 512x512, 1 sample, depth 5
  flake2    sphereflake of 91 spheres; as flake
  mesh1k, mesh70k, mesh280k, mesh1m
            a mesh of 1,280, 69,620, 278,480 or 1,113,920 triangles in a room of mirrors; 512x512, 1 sample, depth 4
TEXT
}

fail() { printf '%s\n' "scenes.sh: $*" >&2; exit 1; }

# Standard input becomes the file, whole or not at all.
appear() { cat >"$1.new.$$" && mv "$1.new.$$" "$1"; }

# A wall, floor or ceiling of the room: material, then four corners.
wall() {
    printf '\n[[polygon]]\nmaterial = "%s"\nvertices = [%s, %s, %s, %s]\n' "$@"
}

# The room is 10 wide, high and deep, its floor at y = 0: back, left, right, floor, ceiling, front.
room() {
    wall "$1" '[-5, 0, -5]' '[5, 0, -5]' '[5, 10, -5]' '[-5, 10, -5]'
    wall "$2" '[-5, 0, -5]' '[-5, 10, -5]' '[-5, 10, 5]' '[-5, 0, 5]'
    wall "$3" '[5, 0, -5]' '[5, 0, 5]' '[5, 10, 5]' '[5, 10, -5]'
    wall "$4" '[-5, 0, -5]' '[-5, 0, 5]' '[5, 0, 5]' '[5, 0, -5]'
    wall "$5" '[-5, 10, -5]' '[5, 10, -5]' '[5, 10, 5]' '[-5, 10, 5]'
    wall "$6" '[-5, 0, 5]' '[-5, 10, 5]' '[5, 10, 5]' '[5, 0, 5]'
}

# Name, diffuse colour, secondary, share of reflection, index of refraction.
material() {
    printf '\n[material.%s]\ndiffuse = %s\nambient = 0.1\nsecondary = %s\nfresnel = %s\nior = %s\n' "$@"
}

cornell() {
    "$whitted" generate rotated-cube --size 2.4 --rotate 12,35,0 --translate=-2.1,1.55,-1.5 -o "$folder/cornell_cube.obj"
    {
        cat <<'TEXT'
# A closed room with a mirror at its back, a cube, a mirror sphere and a glass sphere.

[camera]
look_from = [0, 4.5, 4.9]
look_at = [0, 3.6, -5]
fov = 66
width = 600
height = 500

[render]
samples = 20
depth = 4

[[light]]
position = [0.5, 8.5, 3.0]
intensity = 30
TEXT
        material mirror '[0.7, 0.7, 0.7]' 0.8 1 1
        material red '[0.8, 0.15, 0.15]' 0 1 1
        material green '[0.15, 0.8, 0.15]' 0 1 1
        material white '[0.8, 0.8, 0.8]' 0 1 1
        material blue '[0.4, 0.5, 0.8]' 0 1 1
        material cube '[0.85, 0.7, 0.2]' 0 1 1
        material metal '[0.6, 0.6, 0.7]' 0.6 1 1
        material glass '[0.8, 0.9, 1.0]' 0.8 0.1 1.5
        room mirror red green white white blue
        printf '\n[[mesh]]\nfile = "cornell_cube.obj"\nmaterial = "cube"\n'
        printf '\n[[sphere]]\ncenter = [-0.3, 0.9, 0.3]\nradius = 0.9\nmaterial = "metal"\n'
        printf '\n[[sphere]]\ncenter = [2.3, 2.2, -1.6]\nradius = 1.9\nmaterial = "glass"\n'
    } | appear "$folder/cornell.toml"
}

# Name, number of triangles.
mesh() {
    "$whitted" generate displaced-sphere --triangles "$2" --size 1.9 --translate 0,4,-1 -o "$folder/$1.obj"
    {
        cat <<'TEXT'
# A rough closed mesh in a room with mirrors on all four sides.

[camera]
look_from = [0.7, 5.5, 4.8]
look_at = [0, 4, -5]
fov = 66
width = 512
height = 512

[render]
samples = 1
depth = 4

[[light]]
position = [-2.5, 9.3, 3.5]
intensity = 30
TEXT
        material mirror '[0.6, 0.6, 0.6]' 0.8 1 1
        material floor '[0.8, 0.7, 0.55]' 0 1 1
        material ceiling '[0.8, 0.8, 0.8]' 0 1 1
        material blob '[0.45, 0.65, 0.9]' 0.3 1 1
        room mirror mirror mirror floor ceiling mirror
        printf '\n[[mesh]]\nfile = "%s.obj"\nmaterial = "blob"\n' "$1"
    } | appear "$folder/$1.toml"
}

case "${1:-}" in -h | --help) usage; exit 0 ;; esac
[ $# -ge 3 ] || { usage >&2; exit 2; }
whitted=$1 folder=$2
shift 2
[ -x "$whitted" ] || fail "$whitted is no program; build it with cargo build --release"
mkdir -p "$folder"
for name in "$@"; do
    case "$name" in
    cornell) cornell ;;
    flake) "$whitted" generate sphereflake --level 4 -o "$folder/flake.toml" ;;
    flake2) "$whitted" generate sphereflake --level 2 -o "$folder/flake2.toml" ;;
    mesh1k) mesh mesh1k 1280 ;;
    mesh70k) mesh mesh70k 69620 ;;
    mesh280k) mesh mesh280k 278480 ;;
    mesh1m) mesh mesh1m 1113920 ;;
    *) usage >&2; fail "there is no scene called $name" ;;
    esac
done
