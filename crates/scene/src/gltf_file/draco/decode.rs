//! Draco's bitstream to the elements of accessors.

use super::accessors::packed_accessors;
use crate::gltf_file::accessor::header;
use crate::gltf_file::component::Component;
use crate::gltf_file::document::{DecodedAccessor, Document};
use crate::gltf_file::error::LoadError;
use crate::gltf_file::json::Json;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};
use std::collections::BTreeMap;

/// What the decoder holds of a triangle meanwhile: the corners with their neighbours, and what has been visited.
const TRIANGLE_BYTES: u64 = 64;

/// Unpacks the accessors of a primitive, by their indices.
///
/// # Errors
/// The data are broken, or are others than the accessors say.
pub(super) fn unpack_accessors(
    document: &mut Document,
    json: &Json,
    extension: &Json,
) -> Result<BTreeMap<usize, DecodedAccessor>, LoadError> {
    if !matches!(json.integer("mode")?, None | Some(4 | 5)) {
        return Err(json.error("mode", "expected triangles, 4 or 5: only they can be packed"));
    }
    let accessors = packed_accessors(document, json, extension)?;
    let mesh = decode(document, extension)?;
    let (point_count, face_count) = (mesh.num_points(), mesh.num_faces());
    let mut unpacked = BTreeMap::new();
    for (pointer, accessor, unique_id) in accessors {
        let accessor_json = document.accessors.get(accessor).cloned();
        let head = header(&accessor_json.ok_or_else(|| LoadError::invalid(&pointer, "expected an accessor"))?)?;
        let elements = match unique_id {
            None => {
                document.spend(face_count as u64 * 12, &pointer)?;
                let corners = mesh.faces().iter().flatten();
                let bytes = corners.flat_map(|PointIndex(index)| index.to_le_bytes()).collect();
                DecodedAccessor { component: Component::U32, count: 3 * face_count, bytes }
            }
            Some(unique_id) => {
                let attribute = mesh.attribute_by_unique_id(unique_id).ok_or_else(|| {
                    LoadError::invalid(&pointer, format!("the packed data have no attribute {unique_id}"))
                })?;
                if usize::from(attribute.num_components()) != head.width {
                    let found = attribute.num_components();
                    let message = format!("expected {} components, as the accessor says, found {found}", head.width);
                    return Err(LoadError::invalid(&pointer, message));
                }
                document.spend((point_count * head.width * 4) as u64, &pointer)?;
                let bytes = elements(attribute, point_count, head.component);
                DecodedAccessor { component: head.component, count: point_count, bytes }
            }
        };
        if elements.count != head.count {
            let message = format!("the packed data have {} elements, the accessor says {}", elements.count, head.count);
            document.warn(&pointer, &message);
        }
        unpacked.insert(accessor, elements);
    }
    Ok(unpacked)
}

fn decode(document: &Document, extension: &Json) -> Result<Mesh, LoadError> {
    let view = extension.require_integer("bufferView")?;
    let (bytes, _) = document.view_bytes(view, &extension.at("bufferView"))?;
    let limits = DecodeLimits::default()
        .with_max_faces(document.budget_bytes / TRIANGLE_BYTES)
        .with_max_points(document.budget_bytes / TRIANGLE_BYTES)
        .with_max_decoded_bytes(document.budget_bytes);
    let mut mesh = Mesh::new();
    let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh);
    decoded.map_err(|error| {
        let message = error.to_string().replace(char::is_control, " ");
        extension.error("bufferView", format!("the packed data are broken: {message}"))
    })?;
    Ok(mesh)
}

/// The values of an attribute at every point, as an accessor of `component` would hold them.
fn elements(attribute: &PointAttribute, point_count: usize, component: Component) -> Vec<u8> {
    let width = usize::from(attribute.num_components());
    let value_bytes = attribute.data_type().byte_length();
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0);
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(point_count * width * component.bytes());
    for point in 0..point_count {
        let index = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let element = index.checked_mul(stride).and_then(|start| data.get(start..)).unwrap_or_default();
        for i in 0..width {
            let value = element.get(i * value_bytes..(i + 1) * value_bytes).unwrap_or_default();
            push(&mut bytes, component, number(attribute.data_type(), value));
        }
    }
    bytes
}

/// A value of the packed data; 0 for what glTF has no numbers for.
fn number(kind: DataType, bytes: &[u8]) -> f64 {
    match (kind, bytes) {
        (DataType::Int8, &[a]) => f64::from(a as i8),
        (DataType::Uint8 | DataType::Bool, &[a]) => f64::from(a),
        (DataType::Int16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (DataType::Uint16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (DataType::Int32, &[a, b, c, d]) => f64::from(i32::from_le_bytes([a, b, c, d])),
        (DataType::Uint32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (DataType::Float32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => 0.0,
    }
}

fn push(bytes: &mut Vec<u8>, component: Component, value: f64) {
    match component {
        Component::I8 => bytes.extend((value as i8).to_le_bytes()),
        Component::U8 => bytes.extend((value as u8).to_le_bytes()),
        Component::I16 => bytes.extend((value as i16).to_le_bytes()),
        Component::U16 => bytes.extend((value as u16).to_le_bytes()),
        Component::U32 => bytes.extend((value as u32).to_le_bytes()),
        Component::F32 => bytes.extend((value as f32).to_le_bytes()),
    }
}
