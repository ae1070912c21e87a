//! Every map of a layer by the second set of texture coordinates and with a transform: where both give the coordinates
//! of the first set, the picture is the same.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use crate::common::files::{File, SIDE_PX, keep, picture};
use glam::{Mat4, Vec3};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use manypass::View;
use manypass_scene::Projection;
use manypass_testkit::compare::{Picture, assert_looks_same};
use serde_json::{Value, json};

/// An extension, a map of it, and what else it needs to show.
const MAPS: [(&str, &str, &str); 14] = [
    ("clearcoat", "clearcoatTexture", r#"{ "clearcoatFactor": 1 }"#),
    ("clearcoat", "clearcoatRoughnessTexture", r#"{ "clearcoatFactor": 1, "clearcoatRoughnessFactor": 1 }"#),
    ("clearcoat", "clearcoatNormalTexture", r#"{ "clearcoatFactor": 1 }"#),
    ("sheen", "sheenColorTexture", r#"{ "sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.5 }"#),
    ("sheen", "sheenRoughnessTexture", r#"{ "sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 1 }"#),
    ("specular", "specularTexture", "{}"),
    ("specular", "specularColorTexture", r#"{ "specularColorFactor": [4, 4, 4] }"#),
    ("iridescence", "iridescenceTexture", r#"{ "iridescenceFactor": 1 }"#),
    ("iridescence", "iridescenceThicknessTexture", r#"{ "iridescenceFactor": 1 }"#),
    ("anisotropy", "anisotropyTexture", r#"{ "anisotropyStrength": 1 }"#),
    ("transmission", "transmissionTexture", r#"{ "transmissionFactor": 1 }"#),
    (
        "volume",
        "thicknessTexture",
        r#"{ "thicknessFactor": 1, "attenuationDistance": 0.4, "attenuationColor": [0.9, 0.3, 0.1] }"#,
    ),
    ("diffuse_transmission", "diffuseTransmissionTexture", r#"{ "diffuseTransmissionFactor": 1 }"#),
    ("diffuse_transmission", "diffuseTransmissionColorTexture", r#"{ "diffuseTransmissionFactor": 1 }"#),
];
const COLUMNS: usize = 4;
/// Vertices along a side of a patch.
const STEPS: u16 = 9;

/// Where the transform moves coordinates to, how it scales and how far it turns them (KHR_texture_transform).
const OFFSET: [f32; 2] = [0.3, -0.2];
// Uneven scales change directions by what tangents do not tell.
const SCALE: [f32; 2] = [0.75, 0.75];
const ROTATION_RAD: f32 = 0.6;

/// How a map finds its texels.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// By the first set.
    First,
    /// By the second set and the transform.
    Second,
    /// By the second set alone.
    Untransformed,
}

impl Way {
    fn slot(self) -> Value {
        match self {
            Self::First => json!({ "index": 0 }),
            Self::Untransformed => json!({ "index": 0, "texCoord": 1 }),
            // The extension's set stands in place of the slot's.
            Self::Second => json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform": {
                "offset": OFFSET, "scale": SCALE, "rotation": ROTATION_RAD, "texCoord": 1,
            } } }),
        }
    }
}

/// Squares of every colour, alpha included.
fn image() -> Vec<u8> {
    let texel = |i: u32| {
        let (x, y) = (i % 64 / 8, i / 64 / 8);
        let value = |salt: u32| {
            let mixed = ((x + 8 * y + 64 * salt).wrapping_mul(0x9e37_79b9) >> 15).wrapping_mul(0x85eb_ca6b);
            (mixed >> 24) as u8
        };
        // As a normal it does not point inwards.
        [value(1), value(2), value(3) / 2 + 127, value(4)]
    };
    let texels: Vec<u8> = (0..64 * 64).flat_map(texel).collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(&texels, 64, 64, ExtendedColorType::Rgba8).unwrap();
    png
}

/// A patch for every map, bent so that it mirrors much of what is around, and a striped wall behind them.
fn file(way: Way) -> File {
    let mut values: [Vec<f32>; 5] = Default::default();
    let (sin, cos) = ROTATION_RAD.sin_cos();
    // Tangents lie along the set that maps of directions are on.
    let turn = if way == Way::First { [1.0, 0.0] } else { [cos, sin] };
    for i in 0..STEPS * STEPS {
        let [u, v] = [i % STEPS, i / STEPS].map(|step| f32::from(step) / f32::from(STEPS - 1));
        let [x, y] = [u - 0.5, 0.5 - v];
        let normal = Vec3::new(1.4 * x, 1.4 * y, 1.0).normalize();
        values[0].extend([x, y, -0.7 * (x * x + y * y)]);
        values[1].extend(normal.to_array());
        let along = (Vec3::X - normal * normal.x).normalize();
        let tangent = turn[0] * along + turn[1] * normal.cross(along);
        values[2].extend(tangent.extend(1.0).to_array());
        values[3].extend([u, v]);
        // The transform's inverse.
        let [s, t] = [u - OFFSET[0], v - OFFSET[1]];
        values[4].extend([(cos * s - sin * t) / SCALE[0], (sin * s + cos * t) / SCALE[1]]);
    }
    let steps = (0..STEPS - 1).flat_map(|y| (0..STEPS - 1).map(move |x| y * STEPS + x));
    let indices: Vec<u16> = steps.flat_map(|i| [i, i + STEPS, i + 1, i + 1, i + STEPS, i + STEPS + 1]).collect();
    let kinds = ["VEC3", "VEC3", "VEC4", "VEC2", "VEC2"];
    let mut parts: Vec<Vec<u8>> =
        values.iter().map(|values| values.iter().flat_map(|value| value.to_le_bytes()).collect()).collect();
    parts.push(indices.iter().flat_map(|index| index.to_le_bytes()).collect());
    parts.push(image());
    let count = usize::from(STEPS * STEPS);
    let mut accessors: Vec<Value> =
        (0..5).map(|i| json!({ "bufferView": i, "componentType": 5126, "type": kinds[i], "count": count })).collect();
    accessors[0]["min"] = json!([-0.5, -0.5, -0.35]);
    accessors[0]["max"] = json!([0.5, 0.5, 0.0]);
    accessors.push(json!({ "bufferView": 5, "componentType": 5123, "type": "SCALAR", "count": indices.len() }));
    let (mut buffer, mut views) = (Vec::new(), Vec::new());
    for part in parts {
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        views.push(json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": part.len() }));
        buffer.extend(part);
    }
    let mut materials: Vec<Value> = MAPS.iter().map(|map| material(*map, way)).collect();
    materials.push(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicFactor": 0.0, "roughnessFactor": 1.0 },
    }));
    let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3, "TEXCOORD_1": 4 });
    let mesh = |material| json!({ "primitives": [{ "attributes": attributes, "indices": 5, "material": material }] });
    let mut nodes: Vec<Value> = (0..MAPS.len())
        .map(|i| json!({ "mesh": i, "translation": [center(i)[0], center(i)[1], 0.0], "scale": [0.9, 0.9, 0.9] }))
        .collect();
    nodes.push(json!({ "mesh": MAPS.len(), "translation": [0.0, 0.0, -1.0], "scale": [6.0, 6.0, 0.001] }));
    let json = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "extensionsUsed": ["KHR_texture_transform"],
        "nodes": nodes, "meshes": (0..materials.len()).map(mesh).collect::<Vec<_>>(), "materials": materials,
        "images": [{ "bufferView": 6, "mimeType": "image/png" }], "textures": [{ "source": 0 }],
        "accessors": accessors, "bufferViews": views, "buffers": [{ "uri": "", "byteLength": buffer.len() }],
    });
    File::new(json, buffer)
}

fn material((extension, slot, rest): (&str, &str, &str), way: Way) -> Value {
    let mut layer: Value = serde_json::from_str(rest).unwrap();
    layer[slot] = way.slot();
    let mut extensions = json!({});
    extensions[format!("KHR_materials_{extension}")] = layer;
    if extension == "volume" {
        extensions["KHR_materials_transmission"] = json!({ "transmissionFactor": 1.0 });
    }
    let metallic = if extension == "anisotropy" { 1.0 } else { 0.0 };
    // What lies below glossy layers is dark, so that they show.
    let is_bright = ["anisotropy", "transmission", "volume", "diffuse_transmission"].contains(&extension);
    let color = if is_bright { [0.8, 0.8, 0.8, 1.0] } else { [0.02, 0.02, 0.02, 1.0] };
    json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": color, "metallicFactor": metallic, "roughnessFactor": 0.3,
        },
        "extensions": extensions,
    })
}

/// Where the patch of a map is.
fn center(map: usize) -> [f32; 2] {
    [(map % COLUMNS) as f32 - 1.5, 1.5 - (map / COLUMNS) as f32]
}

/// The mean difference of channels within the patch of a map, in levels of 255. A metre has an eighth of a picture's
/// pixels to either side.
fn difference(map: usize, [a, b]: [&Picture; 2]) -> f64 {
    let metre_px = SIDE_PX as f32 / 4.0;
    let [x, y] = center(map);
    let first = [(x - 0.4 + 2.0) * metre_px, (1.6 - y) * metre_px].map(|place| place as usize);
    let side = (0.8 * metre_px) as usize;
    let places = (0..side * side).map(|i| (first[1] + i / side) * SIDE_PX as usize + first[0] + i % side);
    let channels = places.flat_map(|at| (0..3).map(move |channel| (at, channel)));
    let sum: u32 = channels.map(|(at, c)| u32::from(a.pixels[at][c].abs_diff(b.pixels[at][c]))).sum();
    f64::from(sum) / (3 * side * side) as f64
}

#[test]
fn maps_of_layers_take_either_set_and_a_transform() {
    let mut renderer = common::renderer();
    let projection = Projection::Orthographic { height_m: 4.0, near_m: 0.01, far_m: 20.0 };
    let view = View { world_from_view: Mat4::from_translation(Vec3::Z * 5.0), projection };
    let [first, second, untransformed] =
        [Way::First, Way::Second, Way::Untransformed].map(|way| picture(&mut renderer, &file(way).scene(), view));
    keep("maps", &[("first", &first), ("second", &second), ("untransformed", &untransformed)]);
    for (map, (extension, slot, _)) in MAPS.iter().enumerate() {
        let (same, other) = (difference(map, [&first, &second]), difference(map, [&first, &untransformed]));
        println!("{slot}: {same:.3} levels, without the transform {other:.2}");
        // Tangents that are turned back are rounded.
        assert!(same < 0.2, "{extension}, {slot}: {same:.3} levels");
        // Each shows, so that a map which is read wrongly is seen.
        assert!(other > 2.0, "{extension}, {slot}: hardly seen, by {other:.2} levels");
    }
    assert_looks_same(&first, &second, 1e-3);
}
