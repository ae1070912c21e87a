//! Accessors: typed arrays in buffers, with strides, normalised integers and sparse replacements.

use super::component::Component;
use super::document::Document;
use super::error::LoadError;
use super::json::Json;
use crate::turns::{Turns, at_once, in_slices};
use std::ops::Range;

/// What an accessor says of itself.
pub(super) struct Header {
    pub(super) component: Component,
    pub(super) normalized: bool,
    /// Components an element.
    pub(super) width: usize,
    pub(super) count: usize,
}

/// The header of the accessor at `json`.
pub(super) fn header(json: &Json) -> Result<Header, LoadError> {
    let component = match json.require_integer("componentType")? {
        5120 => Component::I8,
        5121 => Component::U8,
        5122 => Component::I16,
        5123 => Component::U16,
        5125 => Component::U32,
        5126 => Component::F32,
        other => return Err(json.error("componentType", format!("expected 5120 to 5126 but 5124, found {other}"))),
    };
    let width = match json.string("type")?.unwrap_or("nothing") {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        "MAT4" => 16,
        other => {
            return Err(json.error("type", format!("expected SCALAR, VEC2 to VEC4 or MAT2 to MAT4, found {other}")));
        }
    };
    let count = json.require_integer("count")?;
    if count == 0 {
        return Err(json.error("count", "expected at least 1 element"));
    }
    Ok(Header { component, normalized: json.bool("normalized", false)?, width, count })
}

/// Warns of accessors that are broken. Those that are needed are refused where they are read.
pub(super) fn check_all(document: &mut Document) {
    for json in document.accessors.clone() {
        if let Err(error) = check(document, &json) {
            let pointer = error.pointer().to_owned();
            document.warn(&pointer, &format!("{}; nothing that is shown needs it", error.into_message()));
        }
    }
}

/// Checks the type and range of an accessor.
fn check(document: &Document, json: &Json) -> Result<(), LoadError> {
    let header = header(json)?;
    if json.has("byteOffset") && !json.has("bufferView") {
        return Err(json.error("byteOffset", "needs a bufferView"));
    }
    if let Some(index) = json.index("bufferView", document.views.len(), "bufferView")?
        && document.check_view(index).is_ok()
        && let Some(view) = document.views.get(index)
    {
        let offset = json.integer("byteOffset")?.unwrap_or(0);
        check_range(json, offset, header.count, header.width * header.component.bytes(), view.length, view.stride)?;
    }
    if let Some(sparse) = json.object("sparse")? {
        let count = sparse.require_integer("count")?;
        if count == 0 || count > header.count {
            return Err(sparse.error("count", format!("expected 1 to {} elements, found {count}", header.count)));
        }
        for key in ["indices", "values"] {
            sparse.require_object(key)?.index("bufferView", document.views.len(), "bufferView")?;
        }
    }
    Ok(())
}

/// The stride, if `count` elements from `offset` lie inside `length` bytes.
fn check_range(
    json: &Json,
    offset: usize,
    count: usize,
    element_bytes: usize,
    length: usize,
    stride: Option<usize>,
) -> Result<usize, LoadError> {
    let stride = stride.unwrap_or(element_bytes);
    if stride < element_bytes {
        let message = format!("the stride of {stride} bytes is less than an element of {element_bytes} bytes");
        return Err(json.error("bufferView", message));
    }
    let end = count.checked_sub(1).and_then(|last| last.checked_mul(stride));
    let end = end.and_then(|end| end.checked_add(offset)).and_then(|end| end.checked_add(element_bytes));
    if end.is_none_or(|end| end > length) {
        let message = format!(
            "{count} elements of {element_bytes} bytes from byte {offset} exceed the {length} bytes of the bufferView"
        );
        return Err(json.error("count", message));
    }
    Ok(stride)
}

/// A component as a float; normalised integers become −1 to 1 or 0 to 1.
pub(super) fn to_f32(component: Component, normalized: bool, bytes: &[u8]) -> f32 {
    let (value, max) = match (component, bytes) {
        (Component::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        (Component::I8, &[a]) => (f32::from(a as i8), 127.0),
        (Component::U8, &[a]) => (f32::from(a), 255.0),
        (Component::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (Component::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (Component::U32, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, 4_294_967_295.0),
        _ => (0.0, 1.0),
    };
    if normalized { (value / max).max(-1.0) } else { value }
}

/// An unsigned component; 0 for the others.
pub(super) fn to_u32(component: Component, _normalized: bool, bytes: &[u8]) -> u32 {
    match (component, bytes) {
        (Component::U8, &[a]) => u32::from(a),
        (Component::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
        (Component::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

impl<'a> Document<'a> {
    /// The header of accessor `index`, to which `pointer` refers.
    pub(super) fn accessor_header(&self, index: usize, pointer: &str) -> Result<Header, LoadError> {
        let header = header(&self.accessor(index, pointer)?)?;
        Ok(match self.unpacked.get(&index) {
            Some(unpacked) => Header { component: unpacked.component, count: unpacked.count, ..header },
            None => header,
        })
    }

    fn accessor(&self, index: usize, pointer: &str) -> Result<Json<'a>, LoadError> {
        self.accessors.get(index).cloned().ok_or_else(|| {
            LoadError::invalid(pointer, format!("refers to accessor {index}, but there are {}", self.accessors.len()))
        })
    }

    /// Takes `bytes` from what may still be decoded.
    pub(super) fn spend(&mut self, bytes: u64, pointer: &str) -> Result<(), LoadError> {
        let left = self.budget_bytes.checked_sub(bytes);
        self.budget_bytes = left.ok_or_else(|| {
            LoadError::invalid(
                pointer,
                "the model decodes to far more than its buffers hold; do not reuse accessors so often",
            )
        })?;
        Ok(())
    }

    /// All elements of accessor `index`, to which `pointer` refers. `convert` reads one component.
    pub(super) fn read<T: Copy + Default, const N: usize>(
        &mut self,
        index: usize,
        pointer: &str,
        convert: fn(Component, bool, &[u8]) -> T,
    ) -> Result<Vec<[T; N]>, LoadError> {
        at_once(self.read_in_turns(index, pointer, convert, &mut || None))
    }

    /// As [`Self::read`]; `turns` is asked between slices of many elements.
    pub(super) async fn read_in_turns<T: Copy + Default, const N: usize>(
        &mut self,
        index: usize,
        pointer: &str,
        convert: fn(Component, bool, &[u8]) -> T,
        turns: &mut Turns<'_>,
    ) -> Result<Vec<[T; N]>, LoadError> {
        let json = self.accessor(index, pointer)?;
        let head = self.accessor_header(index, pointer)?;
        if head.width != N {
            return Err(json.error("type", format!("expected {N} components for \"{pointer}\", found {}", head.width)));
        }
        let decoded_bytes = (head.count as u64).saturating_mul(size_of::<[T; N]>() as u64);
        let (mut view, offset) = (json.integer("bufferView")?, json.integer("byteOffset")?.unwrap_or(0));
        check(self, &json)?;
        self.spend(decoded_bytes, pointer)?;
        if let Some(view) = view.filter(|_| !self.unpacked.contains_key(&index)) {
            self.check_view(view)?;
        }
        if view.is_some_and(|view| !self.has_bytes(view)) {
            self.warn(&json.at("bufferView"), "refers to a buffer that has no bytes; its values are 0");
            view = None;
        }
        if view.is_none() && !self.unpacked.contains_key(&index) {
            let left = self.zeros_budget_bytes.checked_sub(decoded_bytes);
            self.zeros_budget_bytes =
                left.ok_or_else(|| json.error("count", "more than 256 MiB of zeros; give the accessor a bufferView"))?;
        }

        let element_bytes = N * head.component.bytes();
        let decode = |bytes: &[u8]| -> [T; N] {
            let mut parts = bytes.chunks_exact(head.component.bytes());
            std::array::from_fn(|_| {
                parts.next().map_or(T::default(), |part| convert(head.component, head.normalized, part))
            })
        };
        // The bytes, where the first element begins and how far the next, and how many there are.
        let encoded = match (self.unpacked.get(&index), view) {
            (Some(unpacked), _) => Some((&unpacked.bytes[..], 0, element_bytes, unpacked.bytes.len() / element_bytes)),
            (None, Some(view)) => {
                let (bytes, stride) = self.view_bytes(view, &json.at("bufferView"))?;
                let stride = check_range(&json, offset, head.count, element_bytes, bytes.len(), stride)?;
                Some((bytes, offset, stride, head.count))
            }
            (None, None) => None,
        };
        let mut elements = match encoded {
            Some((bytes, offset, stride, count)) => {
                let mut elements = Vec::with_capacity(count);
                let add = |range: Range<usize>| {
                    let starts = range.map(|i| offset + i * stride);
                    elements.extend(starts.map(|at| decode(bytes.get(at..at + element_bytes).unwrap_or(&[]))));
                };
                in_slices(count, turns, add).await;
                elements
            }
            None => vec![[T::default(); N]; head.count],
        };
        if let Some(sparse) = json.object("sparse")? {
            self.replace_sparse(&sparse, &mut elements, element_bytes, decode)?;
        }
        Ok(elements)
    }

    fn replace_sparse<T>(
        &self,
        sparse: &Json,
        elements: &mut [T],
        element_bytes: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<(), LoadError> {
        let count = sparse.require_integer("count")?;
        let (indices, values) = (sparse.require_object("indices")?, sparse.require_object("values")?);
        let component = match indices.require_integer("componentType")? {
            5121 => Component::U8,
            5123 => Component::U16,
            5125 => Component::U32,
            _ => return Err(indices.error("componentType", "expected 5121, 5123 or 5125")),
        };
        let range = |json: &Json, bytes: usize| -> Result<(&[u8], usize), LoadError> {
            let offset = json.integer("byteOffset")?.unwrap_or(0);
            let (data, _) = self.view_bytes(json.require_integer("bufferView")?, &json.at("bufferView"))?;
            check_range(json, offset, count, bytes, data.len(), None)?;
            Ok((data, offset))
        };
        let (index_bytes, index_offset) = range(&indices, component.bytes())?;
        let (value_bytes, value_offset) = range(&values, element_bytes)?;
        let index_parts = index_bytes.get(index_offset..).unwrap_or(&[]).chunks_exact(component.bytes());
        let value_parts = value_bytes.get(value_offset..).unwrap_or(&[]).chunks_exact(element_bytes);
        for (index, value) in index_parts.zip(value_parts).take(count) {
            let index = to_u32(component, false, index) as usize;
            let slot = elements.get_mut(index);
            *slot.ok_or_else(|| {
                indices.error("bufferView", format!("index {index} is beyond the accessor's count"))
            })? = decode(value);
        }
        Ok(())
    }
}
