//! The compressed pixels of a PNG file, in bands of rows that threads compress at the same time.
//!
//! Each band is a stream of deflate by itself, which ends at a byte and begins without a dictionary, so that they follow
//! each other as one (RFC 1951; the way of `pigz`). Their number depends on the picture alone, so that its file does.

use flate2::{Compress, Compression, FlushCompress, Status};
use std::num::NonZeroUsize;
use std::ops::Range;
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
/// The modulus of Adler-32 (RFC 1950).
const ADLER: u32 = 65_521;

/// The stream of zlib for a picture whose rows have `row_bytes`, and its texels `texel_bytes`.
pub(crate) fn compressed(data: &[u8], row_bytes: usize, texel_bytes: usize) -> Vec<u8> {
    let rows = data.len() / row_bytes.max(1);
    let rows_of_band = (BAND_BYTES / row_bytes.max(1)).max(1);
    let bands: Vec<Range<usize>> =
        (0..rows).step_by(rows_of_band).map(|first| first..(first + rows_of_band).min(rows)).collect();
    let band = |index: usize| {
        let rows = bands.get(index)?.clone();
        let bytes = &data[rows.start * row_bytes..rows.end * row_bytes];
        Some(Band::of(bytes, row_bytes, texel_bytes, index + 1 == bands.len()))
    };
    let mut done = at_once(bands.len(), band);
    done.sort_by_key(|(index, _)| *index);
    let length: usize = done.iter().map(|(_, band)| band.bytes.len()).sum();
    // A window of 32 KiB, a fast level.
    let mut stream = Vec::with_capacity(length + 6);
    stream.extend([0x78, 0x5e]);
    let mut adler = 1;
    for (_, band) in &done {
        stream.extend(&band.bytes);
        adler = adler_of_both(adler, band.adler, band.filtered_bytes);
    }
    if done.is_empty() {
        stream.extend([0x03, 0x00]);
    }
    stream.extend(adler.to_be_bytes());
    stream
}

/// What `of` gives for every index below `count`, on as many threads as there are processors, in any order.
fn at_once<T: Send>(count: usize, of: impl Fn(usize) -> Option<T> + Sync) -> Vec<(usize, T)> {
    let processors = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let others = processors.min(THREADS_MAX).min(count).saturating_sub(1);
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::with_capacity(count)));
    let work = || {
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && index < count
        {
            let Some(result) = of(index) else { return };
            done.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
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
    done.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// A part of the stream.
struct Band {
    bytes: Vec<u8>,
    /// Of the bytes before they were compressed.
    adler: u32,
    filtered_bytes: usize,
}

impl Band {
    fn of(rows: &[u8], row_bytes: usize, texel_bytes: usize, is_last: bool) -> Self {
        let mut filtered = Vec::with_capacity(rows.len() + rows.len() / row_bytes);
        for row in rows.chunks_exact(row_bytes) {
            filtered.push(FILTER_SUB);
            let (first, rest) = row.split_at(texel_bytes.min(row.len()));
            filtered.extend_from_slice(first);
            filtered.extend(rest.iter().zip(row).map(|(byte, left)| byte.wrapping_sub(*left)));
        }
        let bytes = deflated(&filtered, if is_last { FlushCompress::Finish } else { FlushCompress::Sync });
        Self { bytes, adler: simd_adler32::adler32(&&filtered[..]), filtered_bytes: filtered.len() }
    }
}

/// A raw stream of deflate.
fn deflated(bytes: &[u8], flush: FlushCompress) -> Vec<u8> {
    let mut compress = Compress::new(Compression::new(LEVEL), false);
    let mut out = Vec::with_capacity(bytes.len() / 2 + 64);
    loop {
        let taken = compress.total_in() as usize;
        let result = compress.compress_vec(&bytes[taken..], &mut out, flush);
        let is_done = match result {
            Ok(Status::StreamEnd) => true,
            // All of it is out if there was room for more.
            Ok(_) => {
                flush != FlushCompress::Finish
                    && compress.total_in() as usize == bytes.len()
                    && out.len() < out.capacity()
            }
            // There was no room.
            Err(_) => false,
        };
        if is_done {
            return out;
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
            let stream = compressed(&data, row_bytes, 4);
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
            assert_eq!(stream, compressed(&data, row_bytes, 4));
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
