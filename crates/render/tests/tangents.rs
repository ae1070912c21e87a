//! Maps of directions (normals, clear coat's normals, anisotropy) with a transform of their own: what they say is turned
//! with them, as if the mesh had the coordinates that the transform makes.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use crate::common::files::{File, keep, picture};
use glam::{Mat2, Mat4, Vec2, Vec3};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use manypass::View;
use manypass_scene::Projection;
use manypass_testkit::compare::{Picture, assert_looks_same};
use serde_json::{Value, json};

/// Rotation and scale of KHR_texture_transform. Where it turns and stretches at once, tangents alone do not tell how
/// long the mesh's own coordinates are, so that scales beside a turn are even.
const TRANSFORMS: [(f32, [f32; 2]); 5] = [
    (std::f32::consts::FRAC_PI_2, [1.0, 1.0]),
    (0.6, [1.4, 1.4]),
    (0.0, [-1.0, 1.0]),
    (0.0, [0.5, -1.75]),
    (2.0, [-0.8, 0.8]),
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    Normal,
    CoatNormal,
    /// On the second set of UVs, along which tangents lie then.
    CoatNormalOfSecondSet,
    Anisotropy,
}

/// How the map's coordinates come about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Transformed,
    Baked,
    /// Those of the mesh, without the transform.
    Plain,
}

fn matrix((rotation, scale): (f32, [f32; 2])) -> Mat2 {
    // By rows (c s; -s c), times the scale.
    let (sin, cos) = rotation.sin_cos();
    Mat2::from_cols(Vec2::new(cos, -sin) * scale[0], Vec2::new(sin, cos) * scale[1])
}

/// Waves whose directions lean to one side; as a map of anisotropy stretched along the diagonal.
fn image() -> Vec<u8> {
    let texel = |i: u32| {
        let (x, y) = (i % 64, i / 64);
        let wave = (x as f32 * 0.4).sin() * 40.0 + if y / 16 % 2 == 0 { 30.0 } else { -10.0 };
        [(160.0 + wave) as u8, (110.0 + 0.5 * wave) as u8, 230]
    };
    let texels: Vec<u8> = (0..64 * 64).flat_map(texel).collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(&texels, 64, 64, ExtendedColorType::Rgb8).unwrap();
    png
}

/// A square under a slanting sun.
fn file(slot: Slot, transform: (f32, [f32; 2]), way: Way, has_tangents: bool) -> File {
    let matrix = matrix(transform);
    let corners = [[-1.0f32, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let own = |corner: [f32; 2]| Vec2::new(0.5 + 0.5 * corner[0], 0.5 - 0.5 * corner[1]);
    let uv = |corner| if way == Way::Baked { matrix * own(corner) } else { own(corner) };
    let mut floats: [Vec<f32>; 4] = Default::default();
    for corner in corners {
        floats[0].extend([corner[0], corner[1], 0.0]);
        floats[1].extend([0.0, 0.0, 1.0]);
        floats[2].extend(uv(corner).to_array());
        // u runs along x of the mesh's own coordinates, and v against y.
        let of_uv = if way == Way::Baked { matrix.inverse() } else { Mat2::IDENTITY };
        let tangent = Vec2::new(of_uv.x_axis.x, -of_uv.x_axis.y).normalize();
        floats[3].extend([tangent.x, tangent.y, 0.0, of_uv.determinant().signum()]);
    }
    let mut parts: Vec<Vec<u8>> = floats.iter().map(|all| all.iter().flat_map(|v| v.to_le_bytes()).collect()).collect();
    parts.push([0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()).collect());
    parts.push(image());
    let kinds = ["VEC3", "VEC3", "VEC2", "VEC4"];
    let mut accessors: Vec<Value> =
        (0..4).map(|i| json!({ "bufferView": i, "componentType": 5126, "type": kinds[i], "count": 4 })).collect();
    (accessors[0]["min"], accessors[0]["max"]) = (json!([-1, -1, 0]), json!([1, 1, 0]));
    accessors.push(json!({ "bufferView": 4, "componentType": 5123, "type": "SCALAR", "count": 6 }));
    let (mut buffer, mut views) = (Vec::new(), Vec::new());
    for part in parts {
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        views.push(json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": part.len() }));
        buffer.extend(part);
    }
    let mut attributes = json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 });
    if has_tangents {
        attributes["TANGENT"] = json!(3);
    }
    let mut map = json!({ "index": 0 });
    if way == Way::Transformed {
        let (rotation, scale) = transform;
        map["extensions"] = json!({ "KHR_texture_transform": { "rotation": rotation, "scale": scale } });
    }
    if slot == Slot::CoatNormalOfSecondSet {
        attributes["TEXCOORD_1"] = json!(2);
        map["texCoord"] = json!(1);
    }
    let mut material = json!({ "pbrMetallicRoughness": {
        "baseColorFactor": [0.6, 0.6, 0.6, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5,
    } });
    match slot {
        Slot::Normal => material["normalTexture"] = map,
        Slot::CoatNormal | Slot::CoatNormalOfSecondSet => {
            let coat = json!({ "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.3, "clearcoatNormalTexture": map });
            material["extensions"] = json!({ "KHR_materials_clearcoat": coat });
        }
        Slot::Anisotropy => {
            material["pbrMetallicRoughness"]["metallicFactor"] = json!(1.0);
            let anisotropy = json!({ "anisotropyStrength": 1, "anisotropyRotation": 0.3, "anisotropyTexture": map });
            material["extensions"] = json!({ "KHR_materials_anisotropy": anisotropy });
        }
    }
    let sun = json!({ "lights": [{ "type": "directional", "intensity": 3 }] });
    let json = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "extensionsUsed": ["KHR_texture_transform", "KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": sun },
        "nodes": [
            { "mesh": 0 },
            { "rotation": [-0.28, -0.365, -0.116, 0.88], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": 4, "material": 0 }] }],
        "materials": [material],
        "images": [{ "bufferView": 5, "mimeType": "image/png" }], "textures": [{ "source": 0 }],
        "accessors": accessors, "bufferViews": views, "buffers": [{ "uri": "", "byteLength": buffer.len() }],
    });
    File::new(json, buffer)
}

/// The mean difference of channels, in levels of 255.
fn difference(a: &Picture, b: &Picture) -> f64 {
    let of_pixels = a.pixels.iter().zip(&b.pixels);
    let sum: u32 = of_pixels.flat_map(|(a, b)| (0..3).map(|c| u32::from(a[c].abs_diff(b[c])))).sum();
    f64::from(sum) / (3 * a.pixels.len()) as f64
}

#[test]
fn what_maps_say_of_directions_turns_with_their_transform() {
    let mut renderer = common::renderer();
    let projection = Projection::Orthographic { height_m: 2.0, near_m: 0.01, far_m: 20.0 };
    let view = View { world_from_view: Mat4::from_translation(Vec3::Z * 5.0), projection };
    for slot in [Slot::Normal, Slot::CoatNormal, Slot::CoatNormalOfSecondSet, Slot::Anisotropy] {
        for transform in TRANSFORMS {
            for has_tangents in [false, true] {
                if slot == Slot::CoatNormalOfSecondSet && (has_tangents || transform != TRANSFORMS[0]) {
                    continue;
                }
                let mut seen = |way| picture(&mut renderer, &file(slot, transform, way, has_tangents).scene(), view);
                let [transformed, baked, plain] = [Way::Transformed, Way::Baked, Way::Plain].map(&mut seen);
                let (same, other) = (difference(&transformed, &baked), difference(&plain, &baked));
                println!("{slot:?} {transform:?} {has_tangents}: {same:.3} levels, without the transform {other:.2}");
                keep("tangents", &[("transformed", &transformed), ("baked", &baked)]);
                assert!(same < 0.1, "{slot:?} by {transform:?}, tangents {has_tangents}: {same:.3} levels");
                assert!(other > 1.0, "{slot:?} by {transform:?}: hardly seen, by {other:.2} levels");
                assert_looks_same(&transformed, &baked, 1e-3);
            }
        }
    }
}
