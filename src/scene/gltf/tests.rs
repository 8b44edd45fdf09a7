use crate::scene::model::testing::{Reader, read as load, read_part, survives_damage};
use crate::scene::{Fresnel, SceneError};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// A GLB of `json` and `bin`.
fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + text.len() + bin.len()).to_le_bytes().iter().take(4));
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

/// A document with one triangle (0 0 0), (1 0 0), (0 1 0): positions as floats from byte 0, 8-bit indices at byte 36.
fn triangle() -> (Value, Vec<u8>) {
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bin: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    bin.extend([0, 1, 2, 0]);
    let json = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "one" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "m", "pbrMetallicRoughness": { "metallicFactor": 0 } }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 3 },
        ],
        "buffers": [{ "byteLength": bin.len() }],
    });
    (json, bin)
}

/// [`triangle`] with changes to its JSON: pairs of a pointer and a value.
fn changed(changes: &[(&str, Value)]) -> Result<Reader, SceneError> {
    let (mut json, bin) = triangle();
    for (pointer, value) in changes {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match json.pointer_mut(parent).unwrap() {
            Value::Array(items) => items[key.parse::<usize>().unwrap()] = value.clone(),
            object => object[key] = value.clone(),
        }
    }
    load("m.glb", &glb(&json, &bin))
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).abs().max_element() < 1e-12
}

#[test]
fn nodes_place_scale_and_mirror() {
    // By hand: scaled by (2, 3, 1), turned by 90 degrees about z, moved to (5, 0, 0), then mirrored in x by the parent.
    let nodes = json!([
        { "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "children": [1] },
        { "mesh": 0, "translation": [5, 0, 0], "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2], "scale": [2, 3, 1] },
    ]);
    let read = changed(&[("/nodes", nodes)]).unwrap();
    let [[a, b, c]] = read.triangles()[..] else { panic!("{read:?}") };
    let corners = [v(-5.0, 0.0, 0.0), v(-5.0, 2.0, 0.0), v(-2.0, 0.0, 0.0)];
    assert!(corners.iter().all(|corner| [a, b, c].iter().any(|x| near(*x, *corner))));
    // The outside, +z in the file, is +z still.
    assert!((b - a).cross(c - a).z > 0.0);
    let flat = changed(&[("/nodes/0/scale", json!([1, 0, 1]))]).unwrap_err();
    assert!(flat.message.contains("no triangles"), "{flat}");
}

#[test]
fn all_component_types_strides_and_sparse_changes() {
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": 1, "byteOffset": 2, "componentType": 5121 },
        "values": { "bufferView": 0, "byteOffset": 12 },
    });
    // The third corner becomes the second one's position.
    let read = changed(&[("/accessors/0/sparse", sparse.clone())]).unwrap();
    assert_eq!(read.triangles(), [[DVec3::ZERO, DVec3::X, DVec3::X]]);
    // Without bytes of its own all is zero first.
    let read = changed(&[
        ("/accessors/0", json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse })),
        ("/meshes/0/primitives/0/indices", Value::Null),
    ])
    .unwrap();
    assert_eq!(read.triangles(), [[DVec3::ZERO, DVec3::ZERO, DVec3::X]]);

    let (json, _) = triangle();
    // Integers, plain and normalised, each element four components apart: KHR_mesh_quantization.
    let numbers: [[i32; 3]; 3] = [[0, 0, 0], [100, 0, 0], [0, 127, 5]];
    for (code, bytes, greatest) in
        [(5120, 1, 127.0), (5121, 1, 255.0), (5122, 2, 32_767.0), (5123, 2, 65_535.0)]
    {
        for normalized in [false, true] {
            let mut bin = Vec::new();
            for [x, y, z] in numbers {
                bin.extend([x, y, z, 77].iter().flat_map(|n| n.to_le_bytes()[..bytes].to_vec()));
            }
            let size = bin.len();
            bin.extend([0, 1, 2, 0]);
            let mut json = json.clone();
            json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            json["accessors"][0]["componentType"] = json!(code);
            json["accessors"][0]["normalized"] = json!(normalized);
            json["bufferViews"] = json!([
                { "buffer": 0, "byteLength": size, "byteStride": 4 * bytes },
                { "buffer": 0, "byteOffset": size, "byteLength": 3 },
            ]);
            let read = load("m.glb", &glb(&json, &bin)).unwrap();
            let unit = if normalized { greatest } else { 1.0 };
            let expected = numbers.map(|[x, y, z]| v(f64::from(x), f64::from(y), f64::from(z)) / unit);
            assert_eq!(read.triangles(), [expected], "{code} {normalized}");
        }
    }
}

#[test]
fn lines_are_counted_and_what_is_not_finite_left_out() {
    let (json, bin) = triangle();
    let primitive = json["meshes"][0]["primitives"][0].clone();
    let mut lines = primitive.clone();
    lines["mode"] = json!(1);
    let none = json!({ "attributes": {} });
    let read_with = |primitives: Value, bin: &[u8]| {
        let mut json = json.clone();
        json["meshes"][0]["primitives"] = primitives;
        load("m.glb", &glb(&json, bin))
    };
    let read = read_with(json!([primitive, lines, none]), &bin).unwrap();
    assert_eq!(read.triangles(), [[DVec3::ZERO, DVec3::X, DVec3::Y]]);
    assert!(read.notes_hold("points or lines") && read.notes_hold("without positions"));
    assert!(read_with(json!([lines]), &bin).unwrap_err().message.contains("no triangles"));
    let mut infinite = bin.clone();
    infinite[..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert!(read_with(json!([primitive]), &infinite).unwrap_err().message.contains("not finite"));
}

#[test]
fn a_node_is_taken_with_all_below_it() {
    let (mut json, bin) = triangle();
    json["nodes"] = json!([
        { "name": "car", "translation": [1, 0, 0], "children": [1, 2] },
        { "name": "wheel", "mesh": 0, "translation": [0, 1, 0], "children": [3] },
        { "name": "door", "mesh": 0 },
        { "name": "hub", "mesh": 0, "translation": [0, 0, 1] },
    ]);
    let part = |name: &str| read_part("m.glb", &glb(&json, &bin), Some(name), false);
    let firsts = |name: &str| part(name).unwrap().triangles().iter().map(|t| t[0]).collect::<Vec<_>>();
    assert_eq!(firsts("wheel"), [v(1.0, 1.0, 0.0), v(1.0, 1.0, 1.0)]);
    assert_eq!(firsts("car").len(), 3);
    let error = part("whel").unwrap_err();
    assert!(error.message.contains("there is no node `whel`; did you mean `wheel`?"), "{error}");
    assert!(error.remedy.contains("`door`"), "{error}");
    // Every node in the scene's list: each is still taken once, below its parent.
    json["scenes"][0]["nodes"] = json!([3, 2, 1, 0]);
    assert_eq!(load("m.glb", &glb(&json, &bin)).unwrap().triangles().len(), 3);
    json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(load("m.glb", &glb(&json, &bin)).unwrap().triangles().len(), 3);
}

#[test]
fn mistakes_are_named() {
    for (pointer, value, message) in [
        ("/nodes/0/children", json!([0]), "node 0 `one` is below itself"),
        (
            "/nodes",
            json!([{ "children": [1, 2] }, { "children": [2] }, { "name": "\u{1b}[0m" }]),
            "node 2 `\\u{1b}[0m` has two parents",
        ),
        ("/nodes/0/children", json!([7]), "node 7 is named, but the file has 1"),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "rotation has length 0"),
        ("/nodes/0/mesh", json!(1), "mesh 1 is named"),
        ("/scene", json!(4), "scene 4 is named"),
        (
            "/accessors/1/count",
            json!(4),
            "accessor 1 (indices) has 4 elements, more than buffer view 1 of 3 bytes",
        ),
        ("/accessors/0/count", json!(u64::MAX), "more than buffer view 0"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "more than buffer view 0"),
        (
            "/accessors/0",
            json!({ "componentType": 5126, "count": 1u64 << 40, "type": "VEC3" }),
            "but no bytes",
        ),
        ("/accessors/0/count", json!(2), "names vertex 2, but it has 2"),
        ("/accessors/0/type", json!("VEC4"), "has the type `VEC4`"),
        ("/accessors/0/componentType", json!(5130), "component type 5130"),
        ("/accessors/1/componentType", json!(5120), "other than unsigned"),
        ("/bufferViews/0/byteStride", json!(8), "more than the stride 8"),
        ("/bufferViews/0/byteLength", json!(4000), "reaches beyond buffer 0"),
        ("/bufferViews/0/buffer", json!(3), "buffer 3 is named"),
        ("/buffers/0/uri", json!("no such.bin"), "there is no such file"),
        ("/buffers/0/uri", json!("/dev/zero"), "there is no such file"),
        ("/buffers/0/uri", json!("https://example.org/a.bin"), "nothing is fetched"),
        ("/buffers/0/uri", json!("data:;base64,?"), "is no base64"),
        ("/meshes/0/primitives/0/mode", json!(9), "has the mode 9"),
        ("/meshes/0/primitives/0/material", json!(9), "material 9 is named"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "compressed with KHR_draco_mesh_compression",
        ),
        (
            "/extensionsRequired",
            json!(["EXT_meshopt_compression"]),
            "compressed with EXT_meshopt_compression",
        ),
        ("/extensionsRequired", json!(["XYZ_new"]), "requires the extension `XYZ_new`"),
        ("/asset/version", json!("1.0"), "glTF 1.0"),
        ("/asset/version", json!(1), "glTF 1.0"),
        ("/asset/version", json!("3.0"), "version `3.0`"),
        ("/nodes/0/mesh", json!("first"), "its JSON is no glTF 2.0"),
        ("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "last row"),
    ] {
        let error = changed(&[(pointer, value.clone())]).unwrap_err();
        assert!(error.message.contains(message), "{pointer} = {value}: {error}");
        assert_eq!(error.object, "mesh `m`");
    }
    // A text has lines.
    let error = load("m.gltf", b"{\n\"asset\": 3}").unwrap_err();
    assert_eq!(error.line, 2, "{error}");
}

#[test]
fn repetitions_of_a_mesh_are_bounded() {
    let (mut json, _) = triangle();
    let count = 1 << 20;
    let bin: Vec<u8> =
        (0..3).flat_map(|_| [0.0f32; 3]).flat_map(f32::to_le_bytes).chain(vec![0; count]).collect();
    json["accessors"][1]["count"] = json!(count);
    json["bufferViews"][1]["byteLength"] = json!(count);
    let one = json["meshes"][0]["primitives"][0].clone();
    json["meshes"][0]["primitives"] = json!(vec![one; 10]);
    json["nodes"] = json!(vec![json!({ "mesh": 0 }); 100]);
    json["scenes"][0]["nodes"] = json!((0..100).collect::<Vec<_>>());
    let error = load("m.glb", &glb(&json, &bin)).unwrap_err();
    assert!(error.message.contains("repeat its meshes"), "{error}");
}

/// A PNG of one pixel as a data URI.
fn png(pixel: [u8; 4]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut png = std::io::Cursor::new(Vec::new());
    let picture = image::RgbaImage::from_pixel(1, 1, image::Rgba(pixel));
    picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let mut text = String::from("data:image/png;base64,");
    for three in png.get_ref().chunks(3) {
        let bits = three.iter().fold(0u32, |bits, b| bits << 8 | u32::from(*b)) << (8 * (3 - three.len()));
        let digits = (0..=three.len()).map(|i| DIGITS[(bits >> (18 - 6 * i) & 63) as usize] as char);
        text.extend(digits);
    }
    text
}

#[test]
fn materials_become_mirrors_glass_and_glow() {
    let made = |material: Value| {
        let images = json!([{ "uri": png([188, 255, 0, 128]) }]);
        let read = changed(&[
            ("/materials/0", material),
            ("/images", images),
            ("/textures", json!([{ "source": 0 }])),
        ])
        .unwrap();
        (read.materials[0].clone(), read.notes)
    };
    let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
    // A metal of roughness 0.25 and colour (1, 0.5, 0.3): 0.75 of the mean 0.6.
    let (m, notes) = made(json!({ "name": "gold", "pbrMetallicRoughness":
        { "baseColorFactor": [1, 0.5, 0.3, 1], "metallicFactor": 1, "roughnessFactor": 0.25 } }));
    assert!(close(m.secondary, 0.45) && m.fresnel == Fresnel::Constant(1.0) && m.ambient == 0.1);
    assert!(notes[0].contains("mirrors") && notes[0].contains("`gold`"), "{notes:?}");
    // Of a picture's pixel (188, 255, 0): green 1 is roughness, blue 0 is metallic; sRGB 188 is 0.5029.
    let (m, notes) = made(json!({ "pbrMetallicRoughness":
        { "baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": { "index": 0 },
          "metallicRoughnessTexture": { "index": 0 } } }));
    assert!((m.diffuse - v(0.25143, 0.5, 0.0)).abs().max_element() < 1e-4, "{m:?}");
    assert_eq!(m.secondary, 0.0);
    assert!(notes[0].contains("textures become their mean: `material 0`"), "{notes:?}");
    let (m, _) = made(json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.9 },
        "KHR_materials_ior": { "ior": 1.33 } }, "pbrMetallicRoughness": { "metallicFactor": 0 } }));
    assert_eq!((m.secondary, m.fresnel, m.ior), (0.9, Fresnel::Exact, 1.33));
    // Half the factor, and 128 of 255 of the picture.
    let (m, _) = made(json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": { "metallicFactor": 0,
        "baseColorFactor": [1, 1, 1, 0.5], "baseColorTexture": { "index": 0 } } }));
    assert!(close(m.secondary, 1.0 - 0.5 * 128.0 / 255.0) && m.ior == 1.0);
    assert_eq!(m.fresnel, Fresnel::Constant(0.0));
    let (m, _) = made(json!({ "emissiveFactor": [0.2, 0.4, 0.4], "extensions":
        { "KHR_materials_emissive_strength": { "emissiveStrength": 5 } },
        "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorFactor": [0.25, 0.5, 0.5, 1] } }));
    assert!(close(m.ambient, 4.1), "{m:?}");
    let (m, _) = made(json!({ "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "baseColorFactor": [0.25, 0.5, 0.75, 1] } }));
    assert!(near(m.ambient * m.diffuse, v(0.25, 0.5, 0.75)) && m.secondary == 0.0);
    // A picture that is none.
    let broken = changed(&[
        (
            "/materials/0/pbrMetallicRoughness",
            json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 0 }),
        ),
        ("/images", json!([{ "uri": "data:image/ktx2;base64,AAAA" }])),
        ("/textures", json!([{ "source": 0 }])),
    ]);
    assert!(broken.unwrap().notes_hold("cannot be read count as white"));
}

#[test]
fn vertex_colours_and_missing_materials() {
    let primitive = json!({ "attributes": { "POSITION": 0, "COLOR_0": 0 }, "indices": 1 });
    let read = changed(&[("/meshes/0/primitives/0", primitive)]).unwrap();
    // The positions as colours: their mean is a third of red and green.
    assert!(near(read.materials[0].diffuse, 0.8 * v(1.0, 1.0, 0.0) / 3.0), "{read:?}");
    assert!(read.notes_hold("without a material") && read.notes_hold("colours of vertices"));
}

#[test]
fn lights_and_cameras() {
    let light = |kind: &str| json!({ "type": kind, "color": [1, 0.5, 0.25], "intensity": 10 });
    let read = changed(&[
        ("/extensions", json!({ "KHR_lights_punctual":
            { "lights": [light("point"), light("spot"), light("directional"), light("laser")] } })),
        ("/cameras", json!([{ "type": "perspective", "perspective": { "yfov": 0.8, "aspectRatio": 1.5 } },
            { "type": "orthographic" }])),
        ("/scenes/0/nodes", json!([0, 1, 2, 3, 4, 5, 6])),
        ("/nodes", json!([
            { "mesh": 0 },
            { "translation": [1, 2, 3], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "translation": [1, 2, 4], "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            // Turned by -90 degrees about x: -z becomes -y.
            { "rotation": [-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2], "extensions": { "KHR_lights_punctual": { "light": 2 } } },
            { "extensions": { "KHR_lights_punctual": { "light": 3 } } },
            { "translation": [0, 0, 5], "camera": 0 },
            { "camera": 1 },
        ])),
    ])
    .unwrap();
    let color = v(1.0, 0.5, 0.25);
    let [point, spot, sun] = read.model.lights[..] else { panic!("{read:?}") };
    assert!(point.position == v(1.0, 2.0, 3.0) && near(point.intensity, color * 10.0 / PI));
    assert!(spot.position == v(1.0, 2.0, 4.0) && near(spot.intensity, color * 10.0 / PI));
    // 10 lux from above on each corner of the triangle: the radiance of white is 10 / pi.
    for corner in read.triangles()[0] {
        let way = sun.position - corner;
        let irradiance = sun.intensity * way.normalize().y / way.length_squared();
        assert!(((irradiance - color * 10.0 / PI) / (color * 10.0 / PI)).abs().max_element() < 0.0021);
        assert!(way.normalize().y > 0.06f64.to_radians().cos());
    }
    for words in ["directional light", "spot light", "unknown type", "orthographic"] {
        assert!(read.notes_hold(words), "{words}");
    }
    let [camera] = read.model.cameras[..] else { panic!("{read:?}") };
    assert_eq!(
        (camera.look_from, camera.fov, camera.width, camera.height),
        (v(0.0, 0.0, 5.0), 0.8, 750, 500)
    );
    assert!(camera.axes().iter().zip([DVec3::X, DVec3::Y, DVec3::NEG_Z]).all(|(a, b)| near(*a, b)));
}

#[test]
fn buffers_are_data_uris_too_and_bins_may_hold_more() {
    let (mut json, bin) = triangle();
    let text: String = bin.iter().map(|b| format!("%{b:02x}")).collect();
    json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream,{text}"));
    let read_text = load("m.gltf", json.to_string().as_bytes()).unwrap();
    let (json, mut bin) = triangle();
    bin.extend([0; 40]);
    let read_glb = load("m.glb", &glb(&json, &bin)).unwrap();
    assert_eq!(read_text.triangles(), read_glb.triangles());
}

#[test]
fn damage_is_survived() {
    let (json, bin) = triangle();
    survives_damage("m.glb", &glb(&json, &bin));
}
