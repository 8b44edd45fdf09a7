//! The report describes its two pictures in a few sentences. Each test here is one of them, asked of the
//! scenes `cornell` and `cornell_glass` as the oracle sees them.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec3};
use std::path::Path;
use whitted::image::code8;
use whitted::reference::oracle::{Oracle, OracleImage};
use whitted::scene::{Fresnel, Scene};
use whitted::settings::Settings;

const NAMES: [&str; 2] = ["cornell", "cornell_glass"];
/// Index of the small sphere and of the big one.
const SMALL: usize = 0;
const BIG: usize = 1;

fn load(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    Scene::load(folder.join(name).with_extension("toml")).unwrap()
}

/// What a primary ray hits first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Object {
    Back,
    Front,
    Left,
    Right,
    Floor,
    Ceiling,
    Cube,
    Sphere(usize),
}

/// The planes in the order of the scene text.
const PLANES: [Object; 6] =
    [Object::Back, Object::Front, Object::Left, Object::Right, Object::Floor, Object::Ceiling];

/// A picture by the oracle, one sample in the middle of each pixel.
struct Picture {
    settings: Settings,
    image: OracleImage,
}

impl Picture {
    /// Half as high as the report's mirror picture.
    fn of(scene: &Scene, depth: u32) -> Picture {
        Picture::render(scene, Settings { depth, ..sized(scene, 250) })
    }

    /// The column of pixels in the middle, as high as the report's mirror picture.
    fn column(scene: &Scene, depth: u32) -> Picture {
        let settings = sized(scene, 500);
        let x = settings.width / 2;
        Picture::render(scene, Settings { depth, crop: Some([x, 0, x + 1, settings.height]), ..settings })
    }

    fn render(scene: &Scene, settings: Settings) -> Picture {
        Picture { image: Oracle::new(scene).render(&settings), settings }
    }

    fn objects(&self) -> impl Iterator<Item = Object> {
        self.image.first_hit.iter().map(|hit| match hit.unwrap() {
            id @ 0..12 => PLANES[id as usize / 2],
            12..24 => Object::Cube,
            id => Object::Sphere(id as usize - 24),
        })
    }

    /// What each pixel shows, and its colour.
    fn pixels(&self) -> Vec<(Object, DVec3)> {
        self.objects().zip(self.image.linear.iter().copied()).collect()
    }

    /// Colours of the pixels that show an object.
    fn colours(&self, shown: Object) -> Vec<DVec3> {
        self.pixels().into_iter().filter(|(object, _)| *object == shown).map(|(_, colour)| colour).collect()
    }
}

fn sized(scene: &Scene, height: u32) -> Settings {
    let own = Settings::of(scene);
    Settings { width: own.width * height / own.height, height, samples: 1, ..own }
}

/// The share of `pixels` that are as asked.
fn share<T>(pixels: &[T], is: impl Fn(&T) -> bool) -> f64 {
    pixels.iter().filter(|p| is(p)).count() as f64 / pixels.len() as f64
}

fn mean(colours: &[DVec3]) -> DVec3 {
    colours.iter().map(|c| c.clamp(DVec3::ZERO, DVec3::ONE)).sum::<DVec3>() / colours.len() as f64
}

/// The largest difference of two pixels' sRGB codes.
fn codes_apart(a: DVec3, b: DVec3) -> u8 {
    let code = |c: f64| code8(c as f32);
    (0..3).map(|i| code(a[i]).abs_diff(code(b[i]))).max().unwrap()
}

/// The scene with nothing but one material's diffuse light: black where it is in shadow or not seen.
fn only(scene: &Scene, material: &str) -> Scene {
    let mut scene = scene.clone();
    for m in &mut scene.materials {
        m.ambient = 0.0;
        m.diffuse = if m.name == material { DVec3::ONE } else { DVec3::ZERO };
    }
    scene
}

/// The scene with nothing but one material that glows, in shadow too: black where it is not seen.
fn glowing(scene: &Scene, material: &str) -> Scene {
    let mut scene = only(scene, material);
    scene.lights.clear();
    scene.materials.iter_mut().for_each(|m| m.ambient = 1.0);
    scene
}

fn is_black(colour: DVec3) -> bool {
    colour == DVec3::ZERO
}

fn is_red(c: DVec3) -> bool {
    c.x > 0.02 && c.x > 2.0 * c.y && c.x > 2.0 * c.z
}

#[test]
fn sizes_samples_and_depths_are_the_reports() {
    let settings = NAMES.map(|name| Settings::of(&load(name)));
    let found = settings.map(|s| (s.width, s.height, s.samples, s.depth));
    assert_eq!(found, [(600, 500, 20, 4), (300, 200, 5, 4)]);
}

#[test]
fn six_planes_of_ten_by_ten_with_the_light_in_the_middle() {
    for name in NAMES {
        let scene = load(name);
        let ends = |v: &[DVec3]| {
            v.iter().fold((DVec3::INFINITY, -DVec3::INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
        };
        let all: Vec<DVec3> = scene.polygons.iter().flat_map(|p| p.vertices.clone()).collect();
        let (low, high) = ends(&all);
        assert_eq!((low, high), (DVec3::new(-5.0, 0.0, 0.0), DVec3::new(5.0, 10.0, 10.0)));
        // Each lies in one side of the box and covers it.
        let mut sides = Vec::new();
        for polygon in &scene.polygons {
            let (a, b) = ends(&polygon.vertices);
            let mut extents = (b - a).to_array();
            extents.sort_by(f64::total_cmp);
            assert_eq!(extents, [0.0, 10.0, 10.0]);
            sides.push((a + b).to_array().map(|c| c as i32));
        }
        sides.sort_unstable();
        sides.dedup();
        assert_eq!(sides.len(), 6, "{sides:?}");
        let [light] = scene.lights[..] else { panic!("one light expected") };
        assert_eq!((light.position, light.intensity), ((low + high) / 2.0, DVec3::splat(10.0)));
        assert_eq!(light.position, DVec3::new(0.0, 5.0, 5.0));
    }
}

#[test]
fn the_mirror_shows_the_red_wall_that_is_behind_the_camera() {
    for name in NAMES {
        let scene = load(name);
        let picture = Picture::of(&scene, scene.render.depth);
        assert!(picture.objects().all(|object| object != Object::Front), "{name}: the red wall is in view");
        let in_mirror = share(&picture.colours(Object::Back), |c| is_red(*c));
        assert!(in_mirror > 0.25, "{name}: {in_mirror} of the mirror is red");
        // What does not reflect shows no red.
        let elsewhere = |(object, colour): &(Object, DVec3)| {
            !matches!(object, Object::Back | Object::Sphere(_)) && is_red(*colour)
        };
        assert_eq!(share(&picture.pixels(), elsewhere), 0.0, "{name}");
        // Nor does the mirror, where nothing reflects.
        let flat = Picture::of(&scene, 1);
        assert_eq!(share(&flat.image.linear, |c| is_red(*c)), 0.0, "{name} at depth 1");
    }
}

/// Where a camera ray of the middle of pixel (x, y) meets the floor.
fn on_floor(scene: &Scene, settings: &Settings, x: f64, y: f64) -> DVec2 {
    let camera = &scene.camera;
    let forward = (camera.look_at - camera.look_from).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let half = (camera.fov / 2.0).tan();
    let (width, height) = (f64::from(settings.width), f64::from(settings.height));
    let (u, v) = ((2.0 * x + 1.0 - width) / height * half, (height - 1.0 - 2.0 * y) / height * half);
    let direction = forward + right * u + up * v;
    let p = camera.look_from - direction * (camera.look_from.y / direction.y);
    DVec2::new(p.x, p.z)
}

/// Twice the area of a triangle, positive if it turns from x to z.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// True if `p` lies in the convex hull of `points`, that is, in one of their triangles.
fn in_hull(points: &[DVec2], p: DVec2) -> bool {
    let inside = |a: DVec2, b: DVec2, c: DVec2| {
        let t = [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
        t.iter().all(|t| *t >= 0.0) || t.iter().all(|t| *t <= 0.0)
    };
    let n = points.len();
    (0..n).any(|i| (0..i).any(|j| (0..j).any(|k| inside(points[i], points[j], points[k]))))
}

/// The share of the floor in view on which light and shadow are other than a cube of `corners` throws.
fn shadow_misfit(scene: &Scene, corners: &[DVec3]) -> f64 {
    let mut bare = only(scene, "white");
    bare.spheres.clear();
    let picture = Picture::of(&bare, 1);
    let light = scene.lights[0].position;
    let shadow: Vec<DVec2> = corners
        .iter()
        .map(|c| light + (*c - light) * (light.y / (light.y - c.y)))
        .map(|p| DVec2::new(p.x, p.z))
        .collect();
    let width = picture.settings.width as usize;
    let floor: Vec<(DVec2, DVec3)> = picture
        .objects()
        .zip(&picture.image.linear)
        .enumerate()
        .filter(|(_, (object, _))| *object == Object::Floor)
        .map(|(i, (_, c))| (on_floor(scene, &picture.settings, (i % width) as f64, (i / width) as f64), *c))
        .collect();
    assert!(share(&floor, |(_, c)| is_black(*c)) > 0.05, "the cube throws no shadow");
    share(&floor, |(p, c)| in_hull(&shadow, *p) != is_black(*c))
}

#[test]
fn the_cube_is_slightly_tilted_and_its_shadow_fits() {
    for name in NAMES {
        let scene = load(name);
        let [cube] = &scene.meshes[..] else { panic!("one mesh expected") };
        assert_eq!((cube.vertices.len(), cube.faces.len()), (8, 12));
        // No face is parallel to a plane of the room, and the most upright one leans a little.
        let normals: Vec<DVec3> = cube
            .faces
            .iter()
            .map(|f| f.vertices.map(|v| cube.vertices[v as usize]))
            .map(|[a, b, c]| (b - a).cross(c - a).normalize())
            .collect();
        assert!(normals.iter().all(|n| n.abs().max_element() < 0.999), "{name}");
        let lean = normals.iter().map(|n| n.y).fold(-1.0, f64::max).acos().to_degrees();
        assert!((3.0..30.0).contains(&lean), "{name}: {lean} degrees");
        // The corner that is lowest stands on the floor.
        let lowest = cube.vertices.iter().map(|v| v.y).fold(f64::INFINITY, f64::min);
        assert!((0.0..0.01).contains(&lowest), "{name}: {lowest}");

        let misfit = shadow_misfit(&scene, &cube.vertices);
        assert!(misfit < 0.001, "{name}: {misfit} of the floor");
        // The shadow of a cube that is not tilted would not fit.
        let middle = cube.vertices.iter().sum::<DVec3>() / 8.0;
        let half = (cube.vertices[0] - middle).length() / 3f64.sqrt();
        let upright: Vec<DVec3> =
            cube.vertices.iter().map(|v| middle + (*v - middle).signum() * half).collect();
        let other = shadow_misfit(&scene, &upright);
        assert!(other > 0.02, "{name}: an upright cube fits, too: {other}");
    }
}

/// Rows of lit floor between the small sphere and its shadow, in the column through its middle: where it is
/// seen directly, and in the mirror.
fn gaps(scene: &Scene) -> [usize; 2] {
    let sphere = Picture::column(&glowing(scene, "small_mirror"), 2).pixels();
    let floor = Picture::column(&only(scene, "white"), 2).pixels();
    [Object::Sphere(SMALL), Object::Back].map(|seen_in| {
        let shows = |row: &usize| sphere[*row].0 == seen_in && !is_black(sphere[*row].1);
        let lowest = (0..sphere.len()).filter(shows).max().expect("the sphere is seen");
        let below = lowest + 1..floor.len();
        below.take_while(|row| !is_black(floor[*row].1)).count()
    })
}

#[test]
fn the_small_sphere_in_the_middle_floats_and_only_the_mirror_tells() {
    for name in NAMES {
        let scene = load(name);
        let sphere = &scene.spheres[SMALL];
        let height = sphere.center.y - sphere.radius;
        assert!(height > 0.1 && height < sphere.radius, "{name}: {height} above the floor");
        // In the middle of the picture: within a sixth of its height.
        let picture = Picture::of(&scene, 1);
        let width = picture.settings.width as usize;
        let places: Vec<DVec2> = picture
            .objects()
            .enumerate()
            .filter(|(_, object)| *object == Object::Sphere(SMALL))
            .map(|(i, _)| DVec2::new((i % width) as f64, (i / width) as f64))
            .collect();
        let middle = places.iter().sum::<DVec2>() / places.len() as f64;
        let height = f64::from(picture.settings.height);
        let aside = (middle - DVec2::new(width as f64, height) / 2.0).length() / height;
        assert!(aside < 1.0 / 6.0, "{name}: {aside} of the height beside the middle");

        let [front, mirror] = gaps(&scene);
        assert_eq!(front, 0, "{name}: the floor is seen between the sphere and its shadow");
        assert!(mirror >= 6, "{name}: {mirror} pixels between the sphere and its shadow in the mirror");
        // A sphere that stands on the floor looks so in both.
        let mut standing = scene.clone();
        standing.spheres[SMALL].center.y = sphere.radius;
        assert_eq!(gaps(&standing), [0, 0], "{name}");
    }
}

#[test]
fn shadows_fall_on_the_floor_and_on_the_walls() {
    for name in NAMES {
        let scene = load(name);
        for (plane, material) in [(Object::Floor, "white"), (Object::Left, "blue"), (Object::Right, "green")]
        {
            let lit = Picture::of(&only(&scene, material), 1).colours(plane);
            let dark = share(&lit, |c| is_black(*c));
            assert!(dark > 0.1 && dark < 0.9, "{name}, {plane:?}: {dark} in shadow");
        }
    }
}

#[test]
fn the_big_sphere_on_the_right_is_a_mirror_in_one_picture_and_refracts_in_the_other() {
    for (name, refracts) in NAMES.into_iter().zip([false, true]) {
        let scene = load(name);
        let material = &scene.materials[scene.spheres[BIG].material];
        assert_eq!(material.refracts(), refracts, "{name}");
        assert_eq!(scene.materials.iter().filter(|m| m.refracts()).count(), usize::from(refracts), "{name}");
        assert!(scene.spheres[BIG].radius > 2.0 * scene.spheres[SMALL].radius);
        let picture = Picture::of(&scene, 1);
        let all: Vec<Object> = picture.objects().collect();
        assert!(share(&all, |o| *o == Object::Sphere(BIG)) > 0.08, "{name}");
        let right: Vec<Object> = all
            .chunks(picture.settings.width as usize)
            .flat_map(|row| row[row.len() / 2..].iter().copied())
            .collect();
        let count = |objects: &[Object]| objects.iter().filter(|o| **o == Object::Sphere(BIG)).count();
        assert_eq!(count(&right), count(&all), "{name}: all of it is in the right half");
    }
}

#[test]
fn the_glass_has_a_soft_light_blue_tint_of_its_own() {
    let scene = load("cornell_glass");
    let material = scene.spheres[BIG].material;
    let glass = &scene.materials[material];
    assert!(glass.diffuse.z > glass.diffuse.y && glass.diffuse.y > glass.diffuse.x, "{:?}", glass.diffuse);
    assert_eq!(glass.fresnel, Fresnel::Constant(0.1));
    let look = |diffuse: DVec3| {
        let mut scene = scene.clone();
        scene.materials[material].diffuse = diffuse;
        let colours = Picture::of(&scene, scene.render.depth).colours(Object::Sphere(BIG));
        mean(&colours)
    };
    let (tinted, clear) = (look(glass.diffuse), look(DVec3::ZERO));
    let blue = |c: DVec3| c.z / c.x;
    println!("blue over red: {:.3} tinted, {:.3} clear; {tinted:?} {clear:?}", blue(tinted), blue(clear));
    assert!(blue(tinted) > 1.2 * blue(clear), "{tinted:?} {clear:?}");
    assert!(blue(tinted) > 1.1, "{tinted:?}");
    // Soft: less than half of the light that comes from the sphere is its own.
    let own = (tinted - clear).element_sum() / tinted.element_sum();
    assert!(own < 0.5, "{own}");
}

/// The share of the big sphere's pixels that depth 4 changes visibly against depth 3, and of all others.
fn changed(scene: &Scene) -> [f64; 2] {
    let [three, four] = [3, 4].map(|depth| Picture::of(scene, depth));
    let pairs: Vec<_> = three
        .objects()
        .zip(three.image.linear.iter().zip(&four.image.linear))
        .map(|(object, (a, b))| (object == Object::Sphere(BIG), codes_apart(*a, *b) >= 16))
        .collect();
    [true, false].map(|inside| {
        let here: Vec<bool> = pairs.iter().filter(|p| p.0 == inside).map(|p| p.1).collect();
        share(&here, |c| *c)
    })
}

#[test]
fn depth_four_shows_the_mirror_in_the_glass() {
    let scene = load("cornell_glass");
    let [inside, outside] = changed(&scene);
    println!("changed from depth 3 to 4: {inside:.3} of the sphere, {outside:.3} of the rest");
    assert!(inside > 0.5, "{inside} of the sphere changes");
    assert!(outside < 0.1, "{outside} of the rest changes");
    // It is the mirror on the back wall that shows there.
    let mut blind = scene.clone();
    let mirror = blind.polygons[0].material;
    blind.materials[mirror].secondary = 0.0;
    let [without, _] = changed(&blind);
    assert!(without < inside / 2.0, "without the mirror {without} of the sphere changes");
}
