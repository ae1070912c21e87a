//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: streams written by hand after the specification, a small
//! encoder, files of other programs beside their twins, and broken streams.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::twins;
use manypass_scene::{LoadError, LoadedScene, load_bytes, load_path};
use manypass_testkit::needs::assets;
use proptest::prelude::*;
use serde_json::{Value, json};

const EXT: &str = "EXT_meshopt_compression";
const KHR: &str = "KHR_meshopt_compression";

/// A file with packed indices of 300 points.
fn indices(name: &str, mode: &str, data: &[u8], count: usize, stride: usize) -> Value {
    let (component, length) = (if stride == 2 { 5123 } else { 5125 }, count * stride);
    let packed = json!({ "buffer": 0, "byteLength": data.len(), "byteStride": stride, "count": count, "mode": mode });
    json!({
        "asset": { "version": "2.0" }, "extensionsUsed": [name], "extensionsRequired": [name], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "mode": 0, "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [{ "componentType": 5126, "type": "VEC3", "count": 300 },
            { "bufferView": 0, "componentType": component, "type": "SCALAR", "count": count }],
        "bufferViews": [{ "buffer": 1, "byteLength": length, "extensions": { name: packed } }],
        "buffers": [{ "byteLength": data.len(), "uri": "packed.bin" },
            { "byteLength": length, "extensions": { name: { "fallback": true } } }],
    })
}

/// A file with packed positions, four bytes or halves each with one over.
fn positions(name: &str, data: &[u8], count: usize, stride: usize) -> Value {
    let mut file = indices(name, "ATTRIBUTES", data, count, stride);
    let component = if stride == 4 { 5121 } else { 5123 };
    file["accessors"] = json!([{ "bufferView": 0, "componentType": component, "type": "VEC3", "count": count }]);
    file["meshes"][0]["primitives"][0] = json!({ "mode": 0, "attributes": { "POSITION": 0 } });
    file["bufferViews"][0]["byteStride"] = json!(stride);
    file
}

fn load(file: &Value, packed: &[u8]) -> Result<LoadedScene, LoadError> {
    let mut resolve = |uri: &str| if uri == "packed.bin" { Ok(packed.to_vec()) } else { Err(format!("no {uri}")) };
    load_bytes(file.to_string().as_bytes(), &mut resolve, "test.gltf")
}

#[track_caller]
fn loaded_indices(file: &Value, packed: &[u8]) -> Vec<u32> {
    load(file, packed).unwrap().scene.meshes[0].primitives[0].indices.clone()
}

/// Every way to store a triangle, followed by hand through the text of the specification.
const TRIANGLES: [u8; 33] = [
    0xe1, // header
    0xf0, 0x10, 0x02, 0x1f, 0x0d, 0x0e, 0xf1, 0xfe, 0xff, 0x00, // codes
    0x14, 0xf1, 0x05, 0x00, 0xc8, 0x01, // +10; next, explicit −3, recent 0; start again, explicit +100
    0x00, 0x12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // table
];

#[test]
fn triangles_and_sequences_of_every_kind() {
    let expected = [
        [0, 1, 2],
        [2, 1, 3],
        [2, 3, 1],
        [1, 3, 10],
        [1, 10, 9],
        [1, 9, 10],
        [4, 10, 9],
        [5, 7, 4],
        [107, 0, 1],
        [107, 1, 2],
    ];
    for (name, stride) in [(EXT, 2), (KHR, 4)] {
        let file = indices(name, "TRIANGLES", &TRIANGLES, 30, stride);
        assert_eq!(loaded_indices(&file, &TRIANGLES), expected.as_flattened());
        // +5 from the first baseline, +3 and +197 from the second, −1 from the first.
        let sequence = [0xd1, 20, 13, 0x95, 0x06, 2, 0, 0, 0, 0];
        let file = indices(name, "INDICES", &sequence, 4, stride);
        assert_eq!(loaded_indices(&file, &sequence), [5, 3, 200, 4]);
    }
}

#[test]
fn the_group_that_the_specification_explains() {
    let mut data = vec![0xa0, 2, 0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5, 0, 0, 0];
    data.extend([0; 28]);
    data.extend([100, 0, 7, 0]);
    let differences = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0];
    let sums = differences.iter().scan(100_i32, |sum, difference| {
        *sum += difference;
        Some([*sum as f32, 0.0, 7.0])
    });
    let loaded = load(&positions(EXT, &data, 16, 4), &data).unwrap();
    assert_eq!(loaded.scene.meshes[0].primitives[0].positions, sums.collect::<Vec<_>>());
}

/// A stream of attributes in which every group has the least width that `control` allows.
struct Encoder {
    version: u8,
    /// How differences are taken, for every four bytes.
    channels: Vec<u8>,
    /// Of every byte of an element, in version 1.
    controls: Vec<u8>,
}

impl Encoder {
    fn encode(&self, elements: &[Vec<u8>]) -> Vec<u8> {
        let stride = elements[0].len();
        let mut data = vec![0xa0 | self.version];
        let mut before = elements[0].clone();
        for block in elements.chunks(((8192 / stride) & !15).min(256)) {
            let differences: Vec<Vec<u8>> = block
                .iter()
                .map(|element| {
                    let differences = self.differences(&before, element);
                    before.clone_from(element);
                    differences
                })
                .collect();
            let plane = |at: usize| differences.iter().map(|bytes| bytes[at]).collect::<Vec<u8>>();
            let control = |at: usize| match self.controls[at] {
                2 if plane(at).iter().any(|byte| *byte != 0) => 0,
                control => control,
            };
            if self.version == 1 {
                data.extend((0..stride).step_by(4).map(|at| (0..4).fold(0, |b, i| b | (control(at + i) << (2 * i)))));
            }
            for at in 0..stride {
                let widths = match (self.version, control(at)) {
                    (0, _) => [0, 2, 4, 8],
                    (_, 0) => [0, 1, 2, 4],
                    (_, 1) => [1, 2, 4, 8],
                    (_, 2) => continue,
                    _ => {
                        data.extend(plane(at));
                        continue;
                    }
                };
                Self::pack(&plane(at), widths, &mut data);
            }
        }
        let tail_bytes = if self.version == 1 { (stride + stride / 4).max(24) } else { stride.max(32) };
        let codes: &[u8] = if self.version == 1 { &self.channels } else { &[] };
        data.extend(vec![0; tail_bytes - stride - codes.len()]);
        data.extend(&elements[0]);
        data.extend(codes);
        data
    }

    fn differences(&self, before: &[u8], element: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (channel, at) in self.channels.iter().zip((0..element.len()).step_by(4)) {
            let code = if self.version == 0 { 0 } else { *channel };
            let (from, to) = (&before[at..at + 4], &element[at..at + 4]);
            match code & 15 {
                0 => bytes.extend(from.iter().zip(to).map(|(from, to)| {
                    let step = to.wrapping_sub(*from) as i8;
                    ((step << 1) ^ (step >> 7)) as u8
                })),
                1 => {
                    for (from, to) in from.as_chunks().0.iter().zip(to.as_chunks().0) {
                        let step = u16::from_le_bytes(*to).wrapping_sub(u16::from_le_bytes(*from)) as i16;
                        bytes.extend((((step << 1) ^ (step >> 15)) as u16).to_le_bytes());
                    }
                }
                _ => {
                    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
                    bytes.extend((word(from) ^ word(to)).rotate_left(u32::from(code >> 4)).to_le_bytes());
                }
            }
        }
        bytes
    }

    fn pack(plane: &[u8], widths: [u32; 4], data: &mut Vec<u8>) {
        let (mut codes, mut body) = (Vec::new(), Vec::<u8>::new());
        for group in plane.chunks(16) {
            let mut group = group.to_vec();
            group.resize(16, 0);
            let bytes = widths.map(|width| Self::group(&group, width));
            // A width of no bits holds nothing but zeros.
            let fits = |code: &usize| widths[*code] > 0 || group.iter().all(|byte| *byte == 0);
            let code = (0..4).filter(fits).min_by_key(|code| bytes[*code].len()).unwrap();
            codes.push(code as u8);
            body.extend(&bytes[code]);
        }
        data.extend(codes.chunks(4).map(|codes| codes.iter().rev().fold(0, |byte, code| (byte << 2) | code)));
        data.extend(body);
    }

    fn group(group: &[u8], width: u32) -> Vec<u8> {
        if width == 0 || width == 8 {
            return if width == 8 { group.to_vec() } else { Vec::new() };
        }
        let full = ((1_u16 << width) - 1) as u8;
        let mut bytes = Vec::new();
        for slots in group.chunks(8 / width as usize) {
            bytes.push(slots.iter().enumerate().fold(0, |byte, (i, value)| {
                let shift = if width == 1 { i as u32 } else { 8 - width * (i as u32 + 1) };
                byte | (value.min(&full) << shift)
            }));
        }
        bytes.extend(group.iter().filter(|value| **value >= full));
        bytes
    }
}

/// Elements that change little from one to the next in some bytes and much in others.
fn walk(stride: usize, count: usize, steps: &[u8]) -> Vec<Vec<u8>> {
    let mut element: Vec<u8> = (0..stride).map(|at| 30 * at as u8).collect();
    let mut step = steps.iter().cycle();
    (0..count)
        .map(|_| {
            for (at, byte) in element.iter_mut().enumerate() {
                let range = [1, 2, 4, 9, 40, 255][at % 6];
                *byte = byte.wrapping_add(step.next().unwrap() % range).wrapping_sub(range / 2);
            }
            element.clone()
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn attributes_of_both_versions_come_back(
        is_wide in any::<bool>(), version in 0_u8..2, count in 1_usize..600, steps in prop::collection::vec(any::<u8>(), 997),
        channels in prop::array::uniform2(prop::sample::select(vec![0, 1, 2, 0x32, 0xf2])),
        controls in prop::array::uniform8(0_u8..4),
    ) {
        let stride = if is_wide { 8 } else { 4 };
        let elements = walk(stride, count, &steps);
        let encoder = Encoder { version, channels: channels[..stride / 4].to_vec(), controls: controls.to_vec() };
        let data = encoder.encode(&elements);
        let loaded = load(&positions(KHR, &data, count, stride), &data).unwrap();
        let expected: Vec<[f32; 3]> = elements.iter().map(|element| std::array::from_fn(|i| match stride {
            4 => f32::from(element[i]),
            _ => f32::from(u16::from_le_bytes([element[2 * i], element[2 * i + 1]])),
        })).collect();
        prop_assert_eq!(&loaded.scene.meshes[0].primitives[0].positions, &expected);
        if version == 1 {
            let error = load(&positions(EXT, &data, count, stride), &data).unwrap_err().to_string();
            prop_assert!(error.contains("begin with 0xa1, expected 0xa0"), "{error}");
        }
    }

    #[test]
    fn changed_streams_end_without_a_panic(
        version in 0_u8..2, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), cut in 0_usize..40,
        count in 1_usize..400, other in prop::sample::select(vec!["ATTRIBUTES", "TRIANGLES", "INDICES"]),
        filter in prop::sample::select(vec!["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"]),
    ) {
        let encoder = Encoder { version, channels: vec![0x22, 1], controls: vec![0, 1, 2, 3, 0, 1, 2, 3] };
        for mut data in [encoder.encode(&walk(8, 40, &[3, 7, 200])), TRIANGLES.to_vec()] {
            for (at, byte) in &changes {
                let at = at.index(data.len());
                data[at] = *byte;
            }
            data.truncate(data.len() - cut.min(data.len() - 1));
            for (mode, stride) in [("ATTRIBUTES", 8), (other, 4), (other, 2)] {
                let mut file = positions(KHR, &data, count * 3, stride);
                let packed = &mut file["bufferViews"][0]["extensions"][KHR];
                packed["mode"] = json!(mode);
                packed["filter"] = json!(filter);
                if let Err(error) = load(&file, &data) {
                    let error = error.to_string();
                    prop_assert!(error.starts_with("test.gltf: at \"/") && error.contains(KHR) || !error.contains("packed"), "{error}");
                }
            }
        }
    }
}

/// The error when `key` of the extension is `value`, or when the stream is `packed`.
fn refused(key: &str, value: Value, packed: &[u8]) -> String {
    let mut file = indices(EXT, "TRIANGLES", &TRIANGLES, 30, 2);
    file["bufferViews"][0]["extensions"][EXT][key] = value;
    load(&file, packed).unwrap_err().to_string()
}

#[test]
fn what_is_wrong_is_named() {
    let place = "test.gltf: at \"/bufferViews/0/extensions/EXT_meshopt_compression";
    for (key, value, part) in [
        ("mode", json!("POINTS"), "/mode\": expected ATTRIBUTES, TRIANGLES or INDICES, found POINTS"),
        ("filter", json!("COLOR"), "/filter\": expected NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL, found COLOR"),
        ("filter", json!("OCTAHEDRAL"), "/filter\": only the mode ATTRIBUTES has filters"),
        ("byteStride", json!(3), "/byteStride\": 3 bytes do not fit"),
        ("byteStride", json!(4), "/count\": 30 elements of 4 bytes are not the 60 bytes"),
        ("count", json!(31), "/count\": expected a multiple of 3"),
        ("count", json!(3_000_000_000_u32), "/count\": 3000000000 elements of 2 bytes are not"),
        ("buffer", json!(1), "/buffer\": refers to a buffer that has no bytes"),
        ("buffer", json!(7), "/buffer\": refers to a buffer that has no bytes"),
        ("byteOffset", json!(1), "/byteLength\": byteOffset 1 + byteLength 33 exceed the buffer's 33 bytes"),
        ("byteLength", json!(32), "\": the packed data"),
        ("byteLength", json!(20), "\": the packed data end early"),
    ] {
        let error = refused(key, value, &TRIANGLES);
        assert!(error.starts_with(place) && error.contains(part), "{error}");
    }
    let mut broken = TRIANGLES;
    broken[1] = 0x00;
    assert!(refused("byteOffset", json!(0), &broken).contains("refers to what was before the first one"));
    broken[0] = 0xa0;
    assert!(refused("byteOffset", json!(0), &broken).contains("begin with 0xa0, expected 0xe1"));
}

#[test]
fn counts_that_the_bytes_cannot_hold_take_no_memory() {
    // A block without differences takes one byte for 1 KiB: 200 of them cannot be a gigabyte, nor can views share them.
    let encoder = Encoder { version: 1, channels: vec![0], controls: vec![2; 4] };
    let data = encoder.encode(&vec![vec![9; 4]; 51_200]);
    assert!(data.len() < 300);
    let start = std::time::Instant::now();
    let error = load(&positions(KHR, &data, 1 << 27, 4), &data).unwrap_err().to_string();
    assert!(error.contains("unpack to far more than the file holds"), "{error}");
    let error = load(&positions(KHR, &data, 51_201, 4), &data).unwrap_err().to_string();
    assert!(error.contains("the packed data end early"), "{error}");
    let mut file = positions(KHR, &data, 51_200, 4);
    file["bufferViews"] = Value::Array(vec![file["bufferViews"][0].clone(); 1400]);
    let error = load(&file, &data).unwrap_err().to_string();
    assert!(error.contains("/bufferViews/13") && error.contains("unpack to far more"), "{error}");
    assert!(start.elapsed().as_secs() < 20);
}

#[test]
fn a_broken_stream_that_is_not_required_is_replaced_by_the_buffer_beside_it() {
    let plain: Vec<u8> = [2_u16, 1, 0].repeat(10).into_iter().flat_map(u16::to_le_bytes).collect();
    let mut file = indices(EXT, "TRIANGLES", &TRIANGLES, 30, 2);
    file["buffers"][1]["uri"] = json!("plain.bin");
    let asked = std::cell::RefCell::new(Vec::new());
    let load = |file: &Value, packed: &[u8]| {
        asked.borrow_mut().clear();
        let mut resolve = |uri: &str| {
            asked.borrow_mut().push(uri.to_owned());
            Ok(if uri == "packed.bin" { packed.to_vec() } else { plain.clone() })
        };
        load_bytes(file.to_string().as_bytes(), &mut resolve, "test.gltf")
    };
    let mut broken = TRIANGLES;
    broken[0] = 0;
    assert!(load(&file, &broken).is_err(), "the file requires the extension");
    file["extensionsRequired"] = json!([]);
    let loaded = load(&file, &broken).unwrap();
    assert_eq!(loaded.scene.meshes[0].primitives[0].indices, [2, 1, 0].repeat(10));
    assert!(loaded.warnings.iter().any(|warning| warning.contains("the buffer that is not packed is used")));
    // What is whole does without it.
    let loaded = load(&file, &TRIANGLES).unwrap();
    assert_eq!(loaded.scene.meshes[0].primitives[0].indices[..6], [0, 1, 2, 2, 1, 3]);
    assert_eq!((loaded.warnings, asked.take()), (vec![], vec!["packed.bin".to_owned()]));
}

#[test]
fn packed_boxes_are_those_that_are_not_packed() {
    let Some(assets) = assets("") else { return };
    let models = assets.join("khronos-sample-assets/Models");
    for (packed, plain) in [
        ("gltf-transform/extensions/test/in/BoxMeshopt.gltf", "Box/glTF-Binary/Box.glb"),
        ("gltf-transform/extensions/test/in/BoxMeshopt.glb", "Box/glTF-Binary/Box.glb"),
        ("loaders.gl/BoxTextured_meshopt.glb", "BoxTextured/glTF-Binary/BoxTextured.glb"),
    ] {
        let packed = load_path(&assets.join(packed)).unwrap();
        assert!(packed.warnings.is_empty(), "{:?}", packed.warnings);
        twins::assert_same(&packed.scene, &load_path(&models.join(plain)).unwrap().scene, [1e-4, 0.01, 1e-3]);
    }
}
