//! The compressed pixels of a PNG file, in bands of rows that threads compress at the same time.
//!
//! Each band is a stream of deflate by itself, which ends at a byte and begins without a dictionary, so that they follow
//! each other as one (RFC 1951; the way of `pigz`). Their number depends on the picture alone, so that its file does.

use flate2::{Compress, CompressError, Compression, FlushCompress, Status};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Bytes of a band, about: enough that what it cannot refer to is lost in it.
const BAND_BYTES: usize = 512 << 10;
/// The most bands that are compressed at a time.
const THREADS_MAX: usize = 8;
/// Rows are differences of neighbours (PNG specification, section 9.2).
const FILTER_SUB: u8 = 1;
/// On rendered pictures files are as small as with the default of zlib, in less than half the time.
const LEVEL: u32 = 3;
/// Of a stream with a window of 32 KiB, compressed fast (RFC 1950, section 2.2).
const HEADER: [u8; 2] = [0x78, 0x5e];
/// The modulus of Adler-32 (RFC 1950).
const ADLER: u32 = 65_521;

/// The stream of zlib for a picture of whole rows of `row_bytes`, whose texels have `texel_bytes`; both are more than 0.
///
/// # Errors
/// What zlib says.
pub(crate) fn compressed(data: &[u8], row_bytes: usize, texel_bytes: usize) -> Result<Vec<u8>, CompressError> {
    let bands: Vec<&[u8]> = data.chunks((BAND_BYTES / row_bytes).max(1) * row_bytes).collect();
    let last = bands.len().saturating_sub(1);
    let done = each_at_once(&bands, |index, rows| Band::of(rows, row_bytes, texel_bytes, index == last));
    let done = done.into_iter().collect::<Result<Vec<_>, _>>()?;
    let length: usize = done.iter().map(|band| band.bytes.len()).sum();
    let mut stream = Vec::with_capacity(HEADER.len() + length + size_of::<u32>());
    stream.extend(HEADER);
    // That of nothing.
    let mut adler = 1;
    for band in &done {
        stream.extend(&band.bytes);
        adler = adler_of_both(adler, band.adler, band.filtered_bytes);
    }
    stream.extend(adler.to_be_bytes());
    Ok(stream)
}

/// What `of` makes of each of `items`, in their order, on as many threads as there are processors.
fn each_at_once<I: Sync, T: Send>(items: &[I], of: impl Fn(usize, &I) -> T + Sync) -> Vec<T> {
    let processors = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let others = processors.min(THREADS_MAX).min(items.len()).saturating_sub(1);
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::with_capacity(items.len())));
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(index) else { return };
            let made = of(index, item);
            done.lock().unwrap_or_else(PoisonError::into_inner).push((index, made));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..others {
            // A process that may have no more threads does the rest on this one.
            if std::thread::Builder::new().spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        work();
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, made)| made).collect()
}

/// A part of the stream.
struct Band {
    bytes: Vec<u8>,
    /// Of the bytes before they were compressed.
    adler: u32,
    filtered_bytes: usize,
}

impl Band {
    fn of(rows: &[u8], row_bytes: usize, texel_bytes: usize, is_last: bool) -> Result<Self, CompressError> {
        let mut filtered = Vec::with_capacity(rows.len() + rows.len() / row_bytes);
        for row in rows.chunks_exact(row_bytes) {
            filtered.push(FILTER_SUB);
            let (first, rest) = row.split_at(texel_bytes.min(row.len()));
            filtered.extend_from_slice(first);
            filtered.extend(rest.iter().zip(row).map(|(byte, left)| byte.wrapping_sub(*left)));
        }
        let bytes = deflated(&filtered, if is_last { FlushCompress::Finish } else { FlushCompress::Sync })?;
        Ok(Self { bytes, adler: simd_adler32::adler32(&&filtered[..]), filtered_bytes: filtered.len() })
    }
}

/// A raw stream of deflate.
fn deflated(bytes: &[u8], flush: FlushCompress) -> Result<Vec<u8>, CompressError> {
    let mut compress = Compress::new(Compression::new(LEVEL), false);
    let mut out = Vec::with_capacity(bytes.len() / 2 + 64);
    loop {
        let taken = compress.total_in() as usize;
        let status = compress.compress_vec(&bytes[taken..], &mut out, flush)?;
        // What is flushed is all out once there was room for more.
        let is_flushed =
            flush == FlushCompress::Sync && compress.total_in() as usize == bytes.len() && out.len() < out.capacity();
        if status == Status::StreamEnd || is_flushed {
            return Ok(out);
        }
        out.reserve(out.capacity().max(64));
    }
}

/// The checksum of what two checksums are of, one after the other, of which the second has `bytes`.
fn adler_of_both(first: u32, second: u32, bytes: usize) -> u32 {
    let [(a1, b1), (a2, b2)] = [first, second].map(|adler| (adler & 0xffff, adler >> 16));
    let length = (bytes % ADLER as usize) as u32;
    let a = (a1 + a2 + ADLER - 1) % ADLER;
    let moved = u64::from(length) * u64::from((a1 + ADLER - 1) % ADLER) % u64::from(ADLER);
    let b = (u64::from(b1) + u64::from(b2) + moved) % u64::from(ADLER);
    (b as u32) << 16 | a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_of_many_bands_gives_every_byte_back() {
        // Noise, which does not get smaller, and a ramp, which does.
        for noise in [0u32, 255] {
            let (row_bytes, rows) = (4 * 1021, 700);
            let mut state = 1u32;
            let data: Vec<u8> = (0..row_bytes * rows)
                .map(|i| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    ((i / 64) as u32 + (state >> 24 & noise)) as u8
                })
                .collect();
            let stream = compressed(&data, row_bytes, 4).expect("compressed");
            let mut inflated = Vec::new();
            std::io::Read::read_to_end(&mut flate2::read::ZlibDecoder::new(&stream[..]), &mut inflated)
                .expect("inflated");
            let mut rows_of = data.chunks_exact(row_bytes);
            for row in inflated.chunks_exact(row_bytes + 1) {
                let mut found = row[1..].to_vec();
                (4..row_bytes).for_each(|at| found[at] = found[at].wrapping_add(found[at - 4]));
                assert_eq!((row[0], &found[..]), (FILTER_SUB, rows_of.next().expect("a row")));
            }
            assert!(rows_of.next().is_none());
            assert_eq!(Ok(stream), compressed(&data, row_bytes, 4).map_err(|error| error.to_string()));
        }
    }

    #[test]
    fn checksums_add_up() {
        let bytes: Vec<u8> = (0..200_000u32).map(|i| (i.wrapping_mul(i) % 253) as u8).collect();
        for at in [0, 1, 65_521, 65_522, 131_042, 199_999, 200_000] {
            let [first, second] = [&bytes[..at], &bytes[at..]].map(|part| simd_adler32::adler32(&part));
            assert_eq!(adler_of_both(first, second, bytes.len() - at), simd_adler32::adler32(&&bytes[..]), "{at}");
        }
    }
}
