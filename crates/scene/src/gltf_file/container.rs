//! The outside of a file: the chunks of GLB, URIs, buffers and buffer views.

use super::document::View;
use super::error::LoadError;
use super::faults::{Faults, List};
use super::json::Json;
use super::packed::is_fallback;
use std::borrow::Cow;

/// UTF-8's mark, which some exporters write all the same.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The first bytes of a GLB.
pub(super) const GLB_MAGIC: &[u8] = b"glTF";

/// Fetches the bytes of a relative URI.
pub(super) type Resolve<'r> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'r;

/// The JSON, and the binary chunk of a GLB.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), LoadError> {
    if !bytes.starts_with(GLB_MAGIC) {
        return Ok((bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes), None));
    }
    let broken = |message: &str| LoadError::invalid("", format!("broken GLB: {message}; export the model again"));
    let version = read_u32(bytes, 4).ok_or_else(|| broken("the header ends early"))?;
    if version != 2 {
        return Err(broken(&format!("expected version 2, found {version}")));
    }
    let length = read_u32(bytes, 8).ok_or_else(|| broken("the header ends early"))? as usize;
    let bytes = bytes.get(..length).ok_or_else(|| broken("the file is shorter than its header says"))?;
    let (mut json, mut binary, mut at) = (None, None, 12_usize);
    while at < bytes.len() {
        let header = read_u32(bytes, at).zip(read_u32(bytes, at + 4));
        let (chunk_length, kind) = header.ok_or_else(|| broken("a chunk's header ends early"))?;
        let start = at + 8;
        let end = start.checked_add(chunk_length as usize).ok_or_else(|| broken("a chunk is too long"))?;
        let chunk = bytes.get(start..end).ok_or_else(|| broken("a chunk is longer than the file"))?;
        let slot = match kind {
            0x4E4F_534A => &mut json,
            0x004E_4942 if json.is_some() => &mut binary,
            _ if json.is_none() => return Err(broken("the first chunk is not JSON")),
            _ => {
                at = end;
                continue;
            }
        };
        if slot.replace(chunk).is_some() {
            return Err(broken("a chunk appears twice"));
        }
        at = end;
    }
    Ok((json.ok_or_else(|| broken("there is no JSON chunk"))?, binary))
}

fn read_u32(bytes: &[u8], at: usize) -> Option<u32> {
    let end = at.checked_add(4)?;
    Some(u32::from_le_bytes(bytes.get(at..end)?.try_into().ok()?))
}

/// The bytes that a URI stands for.
pub(super) fn fetch(uri: &str, resolve: &mut Resolve) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (header, body) = data.split_once(',').ok_or("expected a comma in the data URI")?;
        let bytes = percent_decode(body).ok_or("a percent sign in the data URI is not followed by two digits")?;
        if header.ends_with(";base64") {
            return base64_decode(&bytes).ok_or_else(|| "the base64 of the data URI is broken".to_owned());
        }
        return Ok(bytes);
    }
    resolve(&decoded_uri(uri)?)
}

/// A relative URI without its percent signs.
pub(super) fn decoded_uri(uri: &str) -> Result<String, String> {
    if uri.contains(':') || uri.starts_with(['/', '\\']) {
        return Err(format!("\"{uri}\" is not a relative path; put the file beside the model and name it plainly"));
    }
    let decoded = percent_decode(uri).and_then(|bytes| String::from_utf8(bytes).ok());
    decoded.ok_or_else(|| format!("\"{uri}\" is not a percent-encoded URI"))
}

pub(super) fn percent_decode(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let high = char::from(rest.next()?).to_digit(16)?;
        let low = char::from(rest.next()?).to_digit(16)?;
        bytes.push((high * 16 + low) as u8);
    }
    Some(bytes)
}

fn base64_decode(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut bit_count) = (0_u32, 0);
    let end = text.iter().rposition(|&c| c != b'=').map_or(0, |last| last + 1);
    for &c in text.get(..end)? {
        let digit = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'\r' | b'\n' | b' ' => continue,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(digit);
        bit_count += 6;
        if bit_count >= 8 {
            bit_count -= 8;
            bytes.push((bits >> bit_count) as u8);
            bits &= (1 << bit_count) - 1;
        }
    }
    Some(bytes)
}

/// The bytes of every buffer; none for a buffer without a URI that is not the binary chunk. The first buffer of a GLB
/// is that chunk, unless it has a URI. Buffers that packed bufferViews stand in for are left out; see [`is_fallback`].
pub(super) fn read_buffers<'a>(
    root: &Json<'a>,
    binary: Option<&'a [u8]>,
    is_glb: bool,
    resolve: &mut Resolve,
    faults: &mut Faults,
) -> Result<Vec<Option<Cow<'a, [u8]>>>, LoadError> {
    let mut buffers = Vec::new();
    for (i, buffer) in root.objects("buffers")?.into_iter().enumerate() {
        let mut read = || {
            let length = buffer.require_integer("byteLength")?;
            let bytes = match buffer.string("uri")? {
                Some(_) if is_fallback(&buffer)? => None,
                Some(uri) => Some(Cow::Owned(fetch_buffer(&buffer, uri, resolve)?)),
                None if i == 0 && is_glb && binary.is_none() => {
                    return Err(buffer.error("uri", "the GLB has no binary chunk for it; export the model again"));
                }
                None if i == 0 => binary.map(Cow::Borrowed),
                None => None,
            };
            if let Some(bytes) = &bytes {
                check_length(&buffer, length, bytes)?;
            }
            Ok(bytes)
        };
        let read = read();
        buffers.push(faults.or(List::Buffers, i, read, None));
    }
    Ok(buffers)
}

/// The bytes that the `uri` of a buffer stands for, as many as the buffer says.
pub(super) fn fetch_buffer(buffer: &Json, uri: &str, resolve: &mut Resolve) -> Result<Vec<u8>, LoadError> {
    let bytes = fetch(uri, resolve).map_err(|message| buffer.error("uri", message))?;
    check_length(buffer, buffer.require_integer("byteLength")?, &bytes)?;
    Ok(bytes)
}

fn check_length(buffer: &Json, length: usize, bytes: &[u8]) -> Result<(), LoadError> {
    if bytes.len() < length {
        let message = format!("expected {length} bytes, the buffer has {}; is the file cut off?", bytes.len());
        return Err(buffer.error("byteLength", message));
    }
    Ok(())
}

/// Every buffer view, its range inside its buffer.
pub(super) fn read_views(
    root: &Json,
    buffers: &[Option<Cow<[u8]>>],
    faults: &mut Faults,
) -> Result<Vec<View>, LoadError> {
    // What is wrong with a buffer is said of that.
    let length = |buffer: &Json| buffer.require_integer("byteLength").unwrap_or(usize::MAX);
    let lengths: Vec<usize> = root.objects("buffers")?.iter().map(length).collect();
    let nothing = || View { buffer: usize::MAX, offset: 0, length: 0, stride: None };
    let views = root.objects("bufferViews")?;
    let read = |(i, view): (usize, &Json)| faults.or(List::Views, i, read_view(view, buffers, &lengths), nothing());
    Ok(views.iter().enumerate().map(read).collect())
}

fn read_view(view: &Json, buffers: &[Option<Cow<[u8]>>], lengths: &[usize]) -> Result<View, LoadError> {
    let buffer = view.index("buffer", buffers.len(), "buffer")?;
    let buffer = buffer.ok_or_else(|| view.error("buffer", "expected the index of a buffer"))?;
    let offset = view.integer("byteOffset")?.unwrap_or(0);
    let length = view.require_integer("byteLength")?;
    let stride = view.integer("byteStride")?;
    if stride.is_some_and(|stride| !(4..=252).contains(&stride)) {
        return Err(view.error("byteStride", "expected 4 to 252 bytes"));
    }
    let buffer_length = lengths.get(buffer).copied().unwrap_or(0);
    if offset.checked_add(length).is_none_or(|end| end > buffer_length) {
        let message = format!("byteOffset {offset} + byteLength {length} exceed the buffer's {buffer_length} bytes");
        return Err(view.error("byteLength", message));
    }
    Ok(View { buffer, offset, length, stride })
}
