//! What the extension says of a bufferView, and its bytes unpacked.

mod filters;

use crate::gltf_file::document::Document;
use crate::gltf_file::error::LoadError;
use crate::gltf_file::json::Json;
use crate::gltf_file::packed::NAMES;
use meshoptimizer_rs::{Error, Limits, Workspace, codec};

/// Why a stream cannot be decoded.
#[derive(Debug, thiserror::Error)]
enum StreamError {
    /// It is shorter or longer than what it stands for needs, or no encoder writes it.
    #[error("the packed data end early or are broken")]
    Broken,
    /// The first byte.
    #[error("the packed data begin with {found:#04x}, expected {expected:#04x}; is the mode right?")]
    Header {
        /// What the mode asks for.
        expected: u8,
        /// What is there.
        found: u8,
    },
    /// An index of a triangle is one of those that the decoder sets out with.
    #[error("the packed data are broken: an index refers to what was before the first one")]
    BeforeFirst,
    /// What the decoder finds besides.
    #[error("the packed data cannot be unpacked: {0}")]
    Refused(Error),
}

impl From<Error> for StreamError {
    fn from(error: Error) -> Self {
        if error == Error::InvalidStream { Self::Broken } else { Self::Refused(error) }
    }
}

/// How elements are packed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// What the extension says of a bufferView.
struct CompressedBufferView<'b> {
    data: &'b [u8],
    mode: Mode,
    filter: Option<filters::Filter>,
    count: usize,
    stride: usize,
    /// Whether version 1 of the stream of attributes may come.
    is_successor: bool,
}

impl CompressedBufferView<'_> {
    fn decode(&self) -> Result<Vec<u8>, StreamError> {
        self.check_header()?;
        // How much all views may take has been checked. The decoder looks at how long a stream is before it takes any.
        let mut workspace = Workspace::new(Limits { max_bytes: usize::MAX, ..Limits::default() });
        let (count, stride, data) = (self.count, self.stride, self.data);
        match self.mode {
            Mode::Attributes => {
                let mut elements = codec::decode_vertex_buffer(count, stride, data, &mut workspace)?;
                if let Some(filter) = self.filter {
                    filters::apply(filter, &mut elements, stride, &mut workspace)?;
                }
                Ok(elements)
            }
            Mode::Triangles => {
                let indices = codec::decode_index_buffer(count, stride, data, &mut workspace)?;
                // The greatest number is no index in glTF.
                let is_unset = |index: &[u8]| index.iter().all(|byte| *byte == 0xff);
                if indices.chunks_exact(stride).any(is_unset) {
                    return Err(StreamError::BeforeFirst);
                }
                Ok(indices)
            }
            Mode::Indices => Ok(codec::decode_index_sequence(count, stride, data, &mut workspace)?),
        }
    }

    /// The versions that the extensions have; the decoder knows more of them.
    fn check_header(&self) -> Result<(), StreamError> {
        let expected = match self.mode {
            Mode::Attributes => 0xa0,
            Mode::Triangles => 0xe1,
            Mode::Indices => 0xd1,
        };
        let found = *self.data.first().ok_or(StreamError::Broken)?;
        let is_version_1 = self.mode == Mode::Attributes && self.is_successor && found == 0xa1;
        if found == expected || is_version_1 { Ok(()) } else { Err(StreamError::Header { expected, found }) }
    }
}

/// The bytes of the bufferView with the index `view`, which the extension at `json` packs.
///
/// # Errors
/// They are broken, others than the bufferView says, or more than is left of `budget_bytes`.
pub(super) fn unpack(
    document: &Document,
    json: &Json,
    view: usize,
    budget_bytes: &mut u64,
) -> Result<Vec<u8>, LoadError> {
    let packed = read(document, json)?;
    let length = packed.count.checked_mul(packed.stride);
    let expected = document.views.get(view).map_or(0, |view| view.length);
    if length != Some(expected) {
        let message = format!(
            "{} elements of {} bytes are not the {expected} bytes of the bufferView",
            packed.count, packed.stride
        );
        return Err(json.error("count", message));
    }
    *budget_bytes = budget_bytes.checked_sub(expected as u64).ok_or_else(|| {
        json.error("count", "the packed bufferViews unpack to far more than the file holds; do not repeat them")
    })?;
    packed.decode().map_err(|error| LoadError::invalid(&json.pointer, error.to_string()))
}

/// Checks what the extension says of a bufferView.
fn read<'b>(document: &'b Document, json: &Json) -> Result<CompressedBufferView<'b>, LoadError> {
    let is_successor = json.pointer.ends_with(NAMES[0]);
    let mode = match json.string("mode")?.unwrap_or("nothing") {
        "ATTRIBUTES" => Mode::Attributes,
        "TRIANGLES" => Mode::Triangles,
        "INDICES" => Mode::Indices,
        other => return Err(json.error("mode", format!("expected ATTRIBUTES, TRIANGLES or INDICES, found {other}"))),
    };
    let filter = match json.string("filter")?.unwrap_or("NONE") {
        "NONE" => None,
        "OCTAHEDRAL" => Some(filters::Filter::Octahedral),
        "QUATERNION" => Some(filters::Filter::Quaternion),
        "EXPONENTIAL" => Some(filters::Filter::Exponential),
        "COLOR" if is_successor => Some(filters::Filter::Color),
        other => {
            let color = if is_successor { ", COLOR" } else { "" };
            let message = format!("expected NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL{color}, found {other}");
            return Err(json.error("filter", message));
        }
    };
    let (count, stride) = (json.require_integer("count")?, json.require_integer("byteStride")?);
    let is_right = match (mode, filter) {
        (Mode::Attributes, None | Some(filters::Filter::Exponential)) => (4..=256).contains(&stride) && stride % 4 == 0,
        (Mode::Attributes, Some(filters::Filter::Quaternion)) => stride == 8,
        (Mode::Attributes, Some(_)) => stride == 4 || stride == 8,
        (Mode::Triangles | Mode::Indices, None) => stride == 2 || stride == 4,
        (Mode::Triangles | Mode::Indices, Some(_)) => {
            return Err(json.error("filter", "only the mode ATTRIBUTES has filters; expected NONE"));
        }
    };
    if !is_right {
        return Err(json.error("byteStride", format!("{stride} bytes do not fit the mode and the filter")));
    }
    if mode == Mode::Triangles && count % 3 != 0 {
        return Err(json.error("count", format!("expected a multiple of 3, found {count}")));
    }
    let (buffer, offset) = (json.require_integer("buffer")?, json.integer("byteOffset")?.unwrap_or(0));
    let length = json.require_integer("byteLength")?;
    let Some(bytes) = document.buffers.get(buffer).and_then(Option::as_ref) else {
        return Err(json.error("buffer", "refers to a buffer that has no bytes; give the buffer a uri"));
    };
    let data = offset.checked_add(length).and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
        let message = format!("byteOffset {offset} + byteLength {length} exceed the buffer's {} bytes", bytes.len());
        json.error("byteLength", message)
    })?;
    Ok(CompressedBufferView { data, mode, filter, count, stride, is_successor })
}
