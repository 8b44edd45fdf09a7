"""A scene of docs/scene-format.md in the language of POV-Ray 3.7. Needs Python 3.11, nothing else.

Both programs shade alike, so that a scene means the same light: ambient, and for each light that is not
hidden its intensity times the cosine over the squared distance; reflected and refracted light by fixed weights
or Fresnel's law. What has no such twin is listed in `Converted.differs`.
"""

import math
import os
import tomllib

# A light of POV-Ray fades by 2 / (1 + (d / fade_distance)^2). With this share of the eye's distance from what
# it looks at as fade_distance, that is 2 (fade_distance / d)^2 but for a part in 1e8 at that distance.
FADE_SHARE = 1e-4
# POV-Ray's light passes through clear surfaces, ours does not. An opaque sphere that only shadow rays see,
# smaller than the clear one by this share of its radius (one of the same size is skipped with it), mends that.
SHADOW_SHRINK = 1e-4


class Converted:
    """The text for POV-Ray, and in words what it cannot say as we do."""

    def __init__(self):
        self.text = []
        self.differs = []
        self.clear = False  # something refracts: shadows differ unless they are mended

    def differ(self, what):
        if what not in self.differs:
            self.differs.append(what)


def vector(v):
    return "<%.17g,%.17g,%.17g>" % tuple(v)


def rgb(value):
    return [value] * 3 if isinstance(value, (int, float)) else value


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def length(v):
    return math.sqrt(sum(x * x for x in v))


def scaled(v, s):
    return [x * s for x in v]


class Material:
    def __init__(self, diffuse, ambient=0.1, secondary=0.0, fresnel=1.0, ior=1.5):
        self.diffuse, self.ambient, self.secondary, self.ior = diffuse, ambient, secondary, ior
        self.law = fresnel if isinstance(fresnel, str) else None
        self.fresnel = fresnel
        self.refracts = secondary > 0 and (self.law is not None or fresnel < 1)

    def texture(self, out):
        """POV-Ray weighs pigment by 1 - transmit, and a reflection by its own factor: out = (1 - t) own +
        r reflected + t refracted, to be (1 - s) own + s f reflected + s (1 - f) refracted."""
        s = self.secondary
        reflection = ""
        if self.law is None:
            t, r = s * (1 - self.fresnel), s * self.fresnel
            reflection = "reflection{%.17g}" % r if r > 0 else ""
        else:
            # conserve_energy takes the reflected share from what is transmitted: exact where secondary is 1.
            t = s
            reflection = "reflection{0,%.17g fresnel on} conserve_energy" % s if s > 0 else ""
            if s not in (0, 1):
                out.differ("Fresnel's law with a `secondary` below 1")
            if self.law == "schlick" and s > 0:
                out.differ("Schlick's law, for which Fresnel's stands in")
        own = (1 - s) / (1 - t) if t < 1 else 0.0
        return "texture{pigment{color rgb %s transmit %.17g}finish{ambient %.17g diffuse %.17g %s}}" % (
            vector(self.diffuse), t, self.ambient * own, own, reflection)

    def interior(self):
        return "interior{ior %.17g}" % self.ior if self.refracts else ""


def scene_material(table):
    return Material(**{k: v for k, v in table.items() if k != "priority"})


def mtl_materials(path):
    """The materials of an MTL file, by the table of docs/scene-format.md."""
    found, rows = {}, {}
    with open(path) as lines:
        for words in map(str.split, lines):
            if words and words[0] == "newmtl":
                rows = found.setdefault(" ".join(words[1:]), {})
            elif words:
                rows[words[0]] = words[1:]

    def color(row, absent):
        if row is None:
            return absent
        values = [float(x) for x in row[:3]]
        return values if len(values) == 3 else [values[0]] * 3

    def mean(v):
        return sum(v) / 3

    materials = {}
    for name, row in found.items():
        kd, ka, ks = color(row.get("Kd"), [0.8] * 3), color(row.get("Ka"), None), color(row.get("Ks"), None)
        ambient = 0.1 if ka is None else min(mean(ka) / mean(kd), 1.0) if mean(kd) > 0 else 0.0
        clear = 1 - float(row["d"][0]) if "d" in row else float(row["Tr"][0]) if "Tr" in row else None
        illum = float(row.get("illum", ["0"])[0])
        secondary, fresnel = 0.0, 1.0
        if illum in (3, 5, 8):
            secondary = mean(ks) if ks else 0.0
        elif illum in (4, 6, 7, 9):
            given = [x for x in (mean(ks) if ks else None, clear) if x is not None]
            secondary, fresnel = max(given) if given else 1.0, "exact"
        ambient = float(row.get("whitted_ambient", [ambient])[0])
        secondary = float(row.get("whitted_secondary", [secondary])[0])
        law = row.get("whitted_fresnel", [fresnel])[0]
        fresnel = law if law in ("exact", "schlick") else float(law)
        materials[name] = Material(kd, ambient, secondary, fresnel, float(row.get("Ni", ["1.5"])[0]))
    return materials


def rotation(degrees):
    """About x, then y, then z, counter-clockwise seen from the axis's end: three rows."""
    (a, b, c) = (math.radians(d) for d in degrees)
    x = [[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]]
    y = [[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]]
    z = [[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]]

    def times(p, q):
        return [[sum(p[i][k] * q[k][j] for k in range(3)) for j in range(3)] for i in range(3)]

    return times(z, times(y, x))


def mesh(table, folder, materials, out):
    """A mesh2 with all materials of the OBJ file."""
    path = os.path.join(folder, table["file"])
    whole = materials[table["material"]] if "material" in table else None
    turn, scale, move = rotation(table.get("rotate", [0, 0, 0])), table.get("scale", 1), table.get("translate", [0, 0, 0])
    plain = "rotate" not in table and "scale" not in table and "translate" not in table
    vertices, normals, faces, smooth, used, current = [], [], [], [], [], whole
    library = {}

    def direction(v):
        return v if plain else [sum(m * x for m, x in zip(row, v)) for row in turn]

    def point(v):
        return v if plain else [x + y for x, y in zip(direction(scaled(v, scale)), move)]

    def index(text, count):
        i = int(text)
        return i - 1 if i > 0 else count + i

    with open(path) as lines:
        for words in map(str.split, lines):
            if not words:
                continue
            if words[0] == "v":
                vertices.append(point([float(x) for x in words[1:4]]))
            elif words[0] == "vn":
                normals.append(direction([float(x) for x in words[1:4]]))
            elif words[0] == "f":
                if current is None:
                    current = Material([0.8] * 3)
                if current not in used:
                    used.append(current)
                corners = [w.split("/") for w in words[1:]]
                v = [index(c[0], len(vertices)) for c in corners]
                n = [index(c[2], len(normals)) for c in corners if len(c) > 2 and c[2]]
                for k in range(1, len(v) - 1):
                    faces.append((v[0], v[k], v[k + 1], used.index(current)))
                    smooth.append((n[0], n[k], n[k + 1]) if len(n) == len(v) else None)
            elif words[0] == "mtllib" and whole is None:
                library.update(mtl_materials(os.path.join(os.path.dirname(path), " ".join(words[1:]))))
            elif words[0] == "usemtl" and whole is None:
                current = library[" ".join(words[1:])]
    write_mesh(vertices, normals, faces, smooth, used, out)


def write_mesh(vertices, normals, faces, smooth, used, out):
    many = len(used) > 1
    text = out.text
    text.append("mesh2{vertex_vectors{%d," % len(vertices))
    text.append(",".join(map(vector, vertices)) + "}\n")
    if any(smooth):
        if not all(smooth):
            out.differ("meshes that are smooth in part; here they are flat")
        else:
            text.append("normal_vectors{%d,%s}\n" % (len(normals), ",".join(map(vector, normals))))
    if many:
        text.append("texture_list{%d,%s}\n" % (len(used), ",".join(m.texture(out) for m in used)))
    row = "<%d,%d,%d>,%d" if many else "<%d,%d,%d>"
    text.append("face_indices{%d,%s}\n" % (len(faces), ",".join(row % (f if many else f[:3]) for f in faces)))
    if any(smooth) and all(smooth):
        text.append("normal_indices{%d,%s}\n" % (len(smooth), ",".join("<%d,%d,%d>" % n for n in smooth)))
    if not many:
        text.append(used[0].texture(out))
    clear = next((m for m in used if m.refracts), None)
    if clear:
        out.clear = True
        out.differ("shadows of meshes that refract: here light passes through")
        text.append(clear.interior())
    text.append("}\n")


def polygon(table, materials, out):
    material = materials[table["material"]]
    v = table["vertices"]
    if material.refracts and material.law is not None:
        out.differ("Fresnel's law on thin sheets")
    if material.refracts:
        out.clear = True
        out.differ("shadows of thin sheets: here light passes through")
    faces = ",".join("<0,%d,%d>" % (k, k + 1) for k in range(1, len(v) - 1))
    # Without an interior what is refracted goes straight on, as in a sheet.
    out.text.append("mesh2{vertex_vectors{%d,%s}face_indices{%d,%s}%s}\n" % (
        len(v), ",".join(map(vector, v)), len(v) - 2, faces, material.texture(out)))


def convert(path, depth, mend_shadows=False, fade_power=2):
    """The scene of that file. `mend_shadows` makes clear spheres cast full shadows, which costs POV-Ray time;
    `fade_power` other than 2 is a mistake that a comparison of pictures has to find."""
    with open(path, "rb") as file:
        scene = tomllib.load(file)
    out = Converted()
    text = out.text
    camera, render = scene["camera"], scene.get("render", {})
    eye, target = camera["look_from"], camera["look_at"]
    forward = scaled(sub(target, eye), 1 / length(sub(target, eye)))
    right = cross(forward, camera.get("up", [0, 1, 0]))
    right = scaled(right, 1 / length(right))
    up = cross(right, forward)
    height = 2 * math.tan(math.radians(camera.get("fov", 45)) / 2)
    text.append("#version 3.7;\nglobal_settings{assumed_gamma 1 max_trace_level %d adc_bailout 0}\n" % depth)
    text.append("background{rgb %s}\n" % vector(rgb(render.get("background", 0))))
    text.append("camera{perspective location %s direction %s right %s*image_width/image_height up %s}\n" % (
        vector(eye), vector(forward), vector(scaled(right, height)), vector(scaled(up, height))))
    fade = FADE_SHARE * length(sub(target, eye))
    for light in scene.get("light", []):
        color = scaled(rgb(light["intensity"]), 1 / (2 * fade * fade))
        text.append("light_source{%s color rgb %s fade_distance %.17g fade_power %g}\n" % (
            vector(light["position"]), vector(color), fade, fade_power))
    materials = {name: scene_material(m) for name, m in scene.get("material", {}).items()}
    for table in scene.get("polygon", []):
        polygon(table, materials, out)
    for table in scene.get("mesh", []):
        mesh(table, os.path.dirname(os.path.abspath(path)), materials, out)
    names = {}
    for number, (name, material) in enumerate(materials.items()):
        names[name] = "T%d" % number
        text.append("#declare T%d = %s\n" % (number, material.texture(out)))
    for sphere in scene.get("sphere", []):
        material = materials[sphere["material"]]
        text.append("sphere{%s,%.17g texture{%s}%s}\n" % (
            vector(sphere["center"]), sphere["radius"], names[sphere["material"]], material.interior()))
        if material.refracts:
            out.clear = True
            if mend_shadows:
                text.append("sphere{%s,%.17g pigment{rgb 0} no_image no_reflection}\n" % (
                    vector(sphere["center"]), sphere["radius"] * (1 - SHADOW_SHRINK)))
    if any(m.get("priority", 0) for m in scene.get("material", {}).values()):
        out.differ("priorities of overlapping solids")
    return out
