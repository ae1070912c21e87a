//! Whether the file of a picture goes on to its end, told without decoding it.

use std::io::{self, Read, Seek, SeekFrom};

/// How these files begin. What ends within that is cut off, or empty.
const STARTS: [&[u8]; 4] = [b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"RIFF", b"\x76\x2f\x31\x01"];
/// The last twelve bytes of every PNG: its empty chunk IEND, with its checksum.
const PNG_END: [u8; 12] = [0, 0, 0, 0, b'I', b'E', b'N', b'D', 0xae, 0x42, 0x60, 0x82];
/// The last two bytes of every JPEG.
const JPEG_END: [u8; 2] = [0xff, 0xd9];
/// The most bytes of the header of an EXR that are looked through for its parts.
const EXR_HEADER_BYTES_MAX: u64 = 16 << 20;

/// Whether a PNG, JPEG, WebP or EXR is whole. What is none of them is, unless it is empty.
///
/// # Errors
/// It cannot be read.
pub fn is_whole(file: &mut (impl Read + Seek)) -> io::Result<bool> {
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let mut start = Vec::new();
    file.by_ref().take(12).read_to_end(&mut start)?;
    if STARTS.iter().any(|picture| picture.starts_with(&start)) {
        return Ok(false);
    }
    if start.starts_with(b"\x89PNG") {
        return ends_with(file, length, &PNG_END);
    }
    if start.starts_with(&[0xff, 0xd8]) {
        return ends_with(file, length, &JPEG_END);
    }
    if let Some(size) = start.strip_prefix(b"RIFF").and_then(|rest| rest.first_chunk()) {
        return Ok(length >= 8 + u64::from(u32::from_le_bytes(*size)));
    }
    if start.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return is_whole_exr(file, length);
    }
    Ok(length > 0)
}

fn ends_with(file: &mut (impl Read + Seek), length: u64, end: &[u8]) -> io::Result<bool> {
    if length < end.len() as u64 {
        return Ok(false);
    }
    file.seek(SeekFrom::Start(length - end.len() as u64))?;
    let mut last = vec![0; end.len()];
    file.read_exact(&mut last)?;
    Ok(last == end)
}

/// Whether all chunks that the headers of an EXR announce are there. The table of their places follows the headers; the
/// chunk that lies last says how long it is.
fn is_whole_exr(file: &mut (impl Read + Seek), length: u64) -> io::Result<bool> {
    file.rewind()?;
    let mut headers = CountingReader { inner: io::BufReader::new(file.by_ref().take(EXR_HEADER_BYTES_MAX)), count: 0 };
    let Ok(meta) = exr::meta::MetaData::read_from_buffered(&mut headers, false) else { return Ok(false) };
    let header_bytes = headers.count;
    drop(headers);
    let chunk_count: usize = meta.headers.iter().map(|header| header.chunk_count).sum();
    let is_multi_part = meta.headers.len() > 1;
    file.seek(SeekFrom::Start(header_bytes))?;
    let mut table = Vec::new();
    file.by_ref().take(8 * chunk_count as u64).read_to_end(&mut table)?;
    let places = table.chunks_exact(8).map(|place| place.try_into().map_or(0, u64::from_le_bytes));
    let (true, Some(last)) = (table.len() == 8 * chunk_count, places.max()) else { return Ok(false) };
    // The number of its part, then its first line, then its bytes.
    let before = if is_multi_part { 8 } else { 4 };
    if last < header_bytes || last + before + 4 > length {
        return Ok(false);
    }
    file.seek(SeekFrom::Start(last + before))?;
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes)?;
    Ok(length >= last + before + 4 + u64::from(u32::from_le_bytes(bytes)))
}

/// Counts what is read.
struct CountingReader<R> {
    inner: R,
    count: u64,
}

impl<R: Read> Read for CountingReader<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.count += count as u64;
        Ok(count)
    }
}
