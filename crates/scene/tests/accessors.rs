//! Accessors of any type, stride, offset and count against a reader that is as simple as can be.

use crate::common::{F32, I8, I16, Model, U8, U16};
use manypass_scene::Primitive;
use proptest::prelude::*;
use serde_json::json;

/// An accessor, and the view that it lies in.
#[derive(Clone, Debug)]
struct Layout {
    component: u32,
    is_normalized: bool,
    width: usize,
    count: usize,
    offset: usize,
    stride: Option<usize>,
    view_offset: usize,
    view_length: usize,
}

fn layouts() -> impl Strategy<Value = Layout> {
    let kind = (prop::sample::select(vec![I8, U8, I16, U16, F32]), any::<bool>(), 2_usize..5);
    let place = (1_usize..9, 0_usize..24, prop::option::of(4_usize..28), 0_usize..24, 0_usize..300);
    (kind, place).prop_map(|((component, is_normalized, width), (count, offset, stride, view_offset, view_length))| {
        Layout { component, is_normalized, width, count, offset, stride, view_offset, view_length }
    })
}

/// One component, or none if it reaches beyond the bytes.
fn component(layout: &Layout, bytes: &[u8], at: usize) -> Option<f32> {
    let byte = |i: usize| bytes.get(at + i).copied();
    let value = match layout.component {
        I8 => f64::from(byte(0)? as i8) / if layout.is_normalized { 127.0 } else { 1.0 },
        U8 => f64::from(byte(0)?) / if layout.is_normalized { 255.0 } else { 1.0 },
        I16 => f64::from(i16::from_le_bytes([byte(0)?, byte(1)?])) / if layout.is_normalized { 32767.0 } else { 1.0 },
        U16 => f64::from(u16::from_le_bytes([byte(0)?, byte(1)?])) / if layout.is_normalized { 65535.0 } else { 1.0 },
        _ => f64::from(f32::from_le_bytes([byte(0)?, byte(1)?, byte(2)?, byte(3)?])),
    };
    let value = if layout.is_normalized && layout.component != F32 { value.max(-1.0) } else { value };
    // The reader of attributes puts 0 where a float is not finite.
    Some(if value.is_finite() { value as f32 } else { 0.0 })
}

/// All components in order, or none if one lies outside, or elements overlap.
fn naive(layout: &Layout, buffer: &[u8]) -> Option<Vec<f32>> {
    let view = buffer.get(layout.view_offset..layout.view_offset + layout.view_length)?;
    let component_bytes = match layout.component {
        I8 | U8 => 1,
        I16 | U16 => 2,
        _ => 4,
    };
    let element_bytes = component_bytes * layout.width;
    let stride = layout.stride.unwrap_or(element_bytes);
    if stride < element_bytes {
        return None;
    }
    let mut values = Vec::new();
    for element in 0..layout.count {
        for i in 0..layout.width {
            values.push(component(layout, view, layout.offset + element * stride + i * component_bytes)?);
        }
    }
    Some(values)
}

/// A model of as many points as the accessor has elements, which is an attribute of its width.
fn model(layout: &Layout, buffer: &[u8]) -> Model {
    let mut model = Model::empty(0);
    buffer.clone_into(&mut model.buffer);
    let mut view = json!({ "buffer": 0, "byteOffset": layout.view_offset, "byteLength": layout.view_length });
    if let Some(stride) = layout.stride {
        view["byteStride"] = json!(stride);
    }
    model.json["bufferViews"] = json!([view]);
    let accessor = |width: usize| json!({ "componentType": layout.component, "type": format!("VEC{width}"), "count": layout.count });
    let mut read = accessor(layout.width);
    read["bufferView"] = json!(0);
    read["byteOffset"] = json!(layout.offset);
    read["normalized"] = json!(layout.is_normalized);
    model.json["accessors"] = json!([read, accessor(3)]);
    let name = match layout.width {
        2 => "TEXCOORD_0",
        3 => "POSITION",
        _ => "COLOR_0",
    };
    model.primitive()["attributes"]["POSITION"] = json!(1);
    model.primitive()["attributes"][name] = json!(0);
    model
}

fn read(primitive: &Primitive, width: usize) -> Vec<f32> {
    match width {
        2 => primitive.uv0.as_flattened().to_vec(),
        4 => primitive.colors.as_flattened().to_vec(),
        _ => primitive.positions.as_flattened().to_vec(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn any_layout_is_read_as_the_simple_reader_does_or_refused(layout in layouts(), buffer in prop::collection::vec(any::<u8>(), 320)) {
        let expected = naive(&layout, &buffer);
        match model(&layout, &buffer).try_load() {
            Ok(loaded) => {
                let found = read(&loaded.scene.meshes[0].primitives[0], layout.width);
                // Colours are clamped, as glTF says.
                let limit = if layout.width == 4 { [0.0, 1.0] } else { [f32::MIN, f32::MAX] };
                let expected = expected.unwrap_or_default();
                prop_assert_eq!(found.len(), expected.len());
                for (found, expected) in found.iter().zip(&expected) {
                    let expected = expected.clamp(limit[0], limit[1]);
                    prop_assert!((found - expected).abs() <= 1e-7 * expected.abs(), "{} {}", found, expected);
                }
            }
            Err(error) => prop_assert!(expected.is_none(), "{}", error),
        }
    }

    #[test]
    fn any_numbers_end_without_a_panic(numbers in prop::array::uniform10(any::<u64>()), kind in 0_usize..8, sparse in any::<bool>()) {
        let [component, count, offset, stride, view_offset, length, buffer, index_type, picks, normalized] = numbers;
        let small = |number: u64, limit: u64| if number.is_multiple_of(3) { number } else { number % limit };
        let types = ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4", "VEC5"];
        let mut model = Model::with_positions((numbers[0] % 8) as u32, &[[0.0; 3]; 3]);
        model.json["bufferViews"][0] = json!({ "buffer": small(buffer, 2), "byteOffset": small(view_offset, 64),
            "byteLength": small(length, 64), "byteStride": small(stride, 40) });
        model.json["accessors"][0] = json!({ "bufferView": 0, "componentType": 5120 + component % 8,
            "type": types[kind], "count": small(count, 9), "byteOffset": small(offset, 40), "normalized": normalized % 2 == 0 });
        if sparse {
            let place = json!({ "bufferView": small(picks, 2), "byteOffset": small(offset, 40), "componentType": 5120 + index_type % 8 });
            model.json["accessors"][0]["sparse"] = json!({ "count": small(picks, 5), "indices": place, "values": place });
        }
        model.primitive()["indices"] = json!(picks % 2);
        model.json["nodes"][0]["skin"] = json!(0);
        model.json["skins"] = json!([{ "joints": [0], "inverseBindMatrices": 0 }]);
        model.json["animations"] = json!([{ "samplers": [{ "input": 0, "output": 0 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }]);
        let _ = model.try_load();
    }
}
