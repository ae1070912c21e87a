//! `EXT_meshopt_compression` and its successor `KHR_meshopt_compression`: bufferViews that are unpacked when the file
//! is read. After this nothing else knows of them; their bytes lie in buffers of their own.
//!
//! Source: the two specifications of those names (Kapoulkine et al.), with the bitstream and the filters in their
//! appendices; `meshoptimizer-rs` decodes. The successor adds version 1 of the stream of attributes and the filter for
//! colours.

#[cfg(not(feature = "meshopt"))]
#[path = "meshopt/absent.rs"]
mod decode;
#[cfg(feature = "meshopt")]
mod decode;

use super::container::{self, Resolve};
use super::document::{Document, View};
use super::error::LoadError;
use super::files::MAX_FILE_BYTES;
use super::json::Json;
use super::packed::{NAMES, extension, is_fallback};
use std::borrow::Cow;

/// What all packed bufferViews of a file may take unpacked: 256 MiB, and more for larger files, but no more than a file
/// that is not packed could hold. So a few kilobytes that many bufferViews share cannot claim all memory.
fn budget_bytes(buffer_bytes: u64) -> u64 {
    ((256 << 20) + buffer_bytes.saturating_mul(128)).min(MAX_FILE_BYTES)
}

/// Unpacks every packed bufferView. One that cannot be unpacked is read from its own buffer instead, with a warning,
/// where the file does not require the extension and that buffer has bytes.
///
/// # Errors
/// If a bufferView cannot be unpacked and there is nothing in its stead.
pub(super) fn unpack_views(document: &mut Document, resolve: &mut Resolve) -> Result<(), LoadError> {
    let required = document.root.strings("extensionsRequired")?;
    let buffer_bytes = document.buffers.iter().flatten().map(|bytes| bytes.len() as u64).sum();
    let mut budget_bytes = budget_bytes(buffer_bytes);
    let buffers = document.root.objects("buffers")?;
    for (index, json) in document.root.objects("bufferViews")?.iter().enumerate() {
        let Some(extension) = extension(json)? else {
            if document.check_view(index).is_err() {
                continue;
            }
            fetch_fallback(document, &buffers, index, resolve)?;
            continue;
        };
        let is_required = NAMES.iter().any(|name| required.contains(name) && extension.pointer.ends_with(name));
        match decode::unpack(document, &extension, index, &mut budget_bytes) {
            Ok(bytes) => {
                if let Some(view) = document.views.get_mut(index) {
                    *view =
                        View { buffer: document.buffers.len(), offset: 0, length: bytes.len(), stride: view.stride };
                    document.buffers.push(Some(Cow::Owned(bytes)));
                }
            }
            Err(error) if is_required => return Err(error),
            Err(error) => {
                fetch_fallback(document, &buffers, index, resolve)?;
                if !document.has_bytes(index) {
                    return Err(error);
                }
                let message = format!("{}; the buffer that is not packed is used", error.into_message());
                document.warn(&extension.pointer, &message);
            }
        }
    }
    Ok(())
}

/// Reads the buffer of a bufferView that is not packed, or whose packed data are broken, if it has been put off.
fn fetch_fallback(
    document: &mut Document,
    buffers: &[Json],
    view: usize,
    resolve: &mut Resolve,
) -> Result<(), LoadError> {
    let index = document.views.get(view).map_or(usize::MAX, |view| view.buffer);
    if let (Some(slot @ None), Some(json)) = (document.buffers.get_mut(index), buffers.get(index))
        && is_fallback(json)?
        && let Some(uri) = json.string("uri")?
    {
        *slot = Some(Cow::Owned(container::fetch_buffer(json, uri, resolve)?));
    }
    Ok(())
}
