//! OpenEXR files: the picture as part `rgba`, and one part for every AOV. They are written part by part and band by
//! band, so that a picture need not be in memory as a whole.

use crate::encode::{EncodeError, check_length};
use crate::exr_header::{self, ExrPart, PictureInfo};
use crate::still::{AovLayer, Samples};
use exr::block::chunk::Chunk;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::error::Error;
use exr::meta::header::Header;
use exr::prelude::Vec2;
use manypass::Aov;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::ops::Range;

/// The rows of a band are a multiple of this: the rows of the largest block of [`crate::ExrCompression`], which are a
/// multiple of those of every other.
const BAND_ROWS_STEP: u32 = 32;

/// A band of rows that is in memory at a time has at most about this many bytes.
pub(crate) const BAND_BYTES: u64 = if cfg!(test) { 1 << 16 } else { 32 << 20 };

/// Why a file could not be written; `E` is why there are no pixels.
#[derive(Debug)]
pub enum WriteError<E> {
    /// The caller has no pixels.
    Pixels(E),
    /// The pixels do not fit their part, or OpenEXR does not allow them.
    Encode(EncodeError),
    /// The bytes could not be written.
    Io(io::Error),
}

impl<E> From<Error> for WriteError<E> {
    fn from(error: Error) -> Self {
        match error {
            Error::Io(error) => Self::Io(error),
            other => Self::Encode(EncodeError::Encoder { format: "EXR", reason: other.to_string() }),
        }
    }
}

impl<E> From<io::Error> for WriteError<E> {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl ExrPart {
    /// The picture: scene-linear radiance with associated alpha.
    pub fn picture() -> Self {
        Self { name: "rgba".into(), channels: vec!["R", "G", "B", "A"], is_id: false }
    }

    /// A variable.
    pub fn of(aov: Aov) -> Self {
        let info = aov.info();
        let is_id = matches!(info.png, manypass::PngEncoding::Id16);
        Self { name: info.name.into(), channels: info.channels.to_vec(), is_id }
    }
}

/// The rows that are read at a time of a picture whose pixels have `components` values of 32 bits.
pub(crate) fn band_rows(width: u32, components: usize) -> u32 {
    let row_bytes = u64::from(width.max(1)) * components as u64 * 4;
    let rows = (BAND_BYTES / row_bytes).clamp(1, 1 << 20) as u32;
    rows.next_multiple_of(BAND_ROWS_STEP)
}

/// Writes a file of `parts`, floats and whole numbers of 32 bits, packed as `info` says. `pixels` gives the values of
/// some rows of the part with that index; it is asked for one part after the other, from the top down.
///
/// # Errors
/// If there are no pixels, no parts, values that do not fit, or the writer fails.
pub fn write<W: Write + Seek, E>(
    out: &mut W,
    (width, height): (u32, u32),
    parts: &[ExrPart],
    info: &PictureInfo,
    mut pixels: impl FnMut(usize, Range<u32>) -> Result<Samples, E>,
) -> Result<(), WriteError<E>> {
    let headers = exr_header::headers(width, height, parts, info);
    let mut head = Vec::new();
    exr_header::write(&headers, &mut head)?;
    let tables_start = head.len() as u64;
    let chunk_count: usize = headers.iter().map(|header| header.chunk_count).sum();
    head.resize(head.len() + chunk_count * 8, 0);
    out.write_all(&head)?;
    let mut position = head.len() as u64;
    let mut offsets: Vec<u8> = Vec::with_capacity(chunk_count * 8);
    for (index, part) in parts.iter().enumerate() {
        let rows_a_band = band_rows(width, part.channels.len());
        for first in (0..height).step_by(rows_a_band as usize) {
            let rows = first..height.min(first.saturating_add(rows_a_band));
            let samples = pixels(index, rows.clone()).map_err(WriteError::Pixels)?;
            check_length(width, rows.len() as u32, part.channels.len(), samples.len()).map_err(WriteError::Encode)?;
            let blocks = blocks((index, part), (width, rows), info.compression.block_rows(), &samples);
            for chunk in compressed(blocks, &headers) {
                let mut bytes = Vec::new();
                chunk?.write(&mut bytes, headers.len())?;
                out.write_all(&bytes)?;
                offsets.extend_from_slice(&position.to_le_bytes());
                position += bytes.len() as u64;
            }
        }
    }
    out.seek(SeekFrom::Start(tables_start))?;
    out.write_all(&offsets)?;
    Ok(out.flush()?)
}

/// The blocks of some rows. In a block, each row has all values of the first channel by name, then those of the next.
fn blocks(
    (layer, part): (usize, &ExrPart),
    (width, rows): (u32, Range<u32>),
    rows_a_block: u32,
    samples: &Samples,
) -> impl Iterator<Item = UncompressedBlock> {
    let width = width as usize;
    let step = part.channels.len();
    let mut order: Vec<usize> = (0..step).collect();
    order.sort_by_key(|channel| part.channels.get(*channel));
    rows.clone().step_by(rows_a_block as usize).map(move |first| {
        let block_rows = first..rows.end.min(first + rows_a_block);
        let mut data = Vec::with_capacity(block_rows.len() * width * step * 4);
        for row in block_rows.clone() {
            let start = (row - rows.start) as usize * width * step;
            for channel in &order {
                samples.append_to(start + channel..start + width * step, step, &mut data);
            }
        }
        let index = BlockIndex {
            layer,
            pixel_position: Vec2(0, first as usize),
            pixel_size: Vec2(width, block_rows.len()),
            level: Vec2(0, 0),
        };
        UncompressedBlock { index, data }
    })
}

/// Compresses blocks on all cores, and gives them in their order.
fn compressed(blocks: impl Iterator<Item = UncompressedBlock>, headers: &[Header]) -> Vec<Result<Chunk, Error>> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut queue: Vec<(usize, UncompressedBlock)> = blocks.enumerate().collect();
    let count = queue.len();
    if threads < 2 || count < 2 {
        return queue.into_iter().map(|(_, block)| block.compress_to_chunk(headers)).collect();
    }
    queue.reverse();
    let queue = std::sync::Mutex::new(queue);
    let work = || {
        let mut done = Vec::new();
        loop {
            let next = queue.lock().unwrap_or_else(std::sync::PoisonError::into_inner).pop();
            let Some((index, block)) = next else { return done };
            done.push((index, block.compress_to_chunk(headers)));
        }
    };
    let mut chunks: Vec<(usize, Result<Chunk, Error>)> = std::thread::scope(|scope| {
        // Where no further thread can be had, the others do its work.
        let spawn = |_| std::thread::Builder::new().spawn_scoped(scope, work).ok();
        let workers: Vec<_> = (1..threads.min(count)).filter_map(spawn).collect();
        let mut chunks = work();
        for worker in workers {
            chunks.extend(worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        chunks
    });
    chunks.sort_by_key(|(index, _)| *index);
    chunks.into_iter().map(|(_, chunk)| chunk).collect()
}

/// A file in memory of scene-linear radiance (associated alpha; none leaves the part out) and `aovs`.
///
/// # Errors
/// If a layer's values do not fit the size, or there is no layer at all.
pub fn encode(
    width: u32,
    height: u32,
    radiance: Option<&[f32]>,
    aovs: &[AovLayer],
    info: &PictureInfo,
) -> Result<Vec<u8>, EncodeError> {
    let mut layers: Vec<(ExrPart, Samples)> = Vec::new();
    if let Some(radiance) = radiance {
        layers.push((ExrPart::picture(), Samples::Float { components: 4, data: radiance.to_vec() }));
    }
    layers.extend(aovs.iter().map(|layer| (ExrPart::of(layer.aov), layer.samples.clone())));
    for (part, samples) in &layers {
        check_length(width, height, part.channels.len(), samples.len())?;
    }
    let parts: Vec<ExrPart> = layers.iter().map(|(part, _)| part.clone()).collect();
    let mut bytes = Cursor::new(Vec::new());
    let rows = |part: usize, rows: Range<u32>| {
        let samples = layers.get(part).map(|(_, samples)| samples.rows(width, rows));
        samples.ok_or_else(|| EncodeError::Encoder { format: "EXR", reason: "there is no such part".into() })
    };
    write(&mut bytes, (width, height), &parts, info, rows).map_err(|error| match error {
        WriteError::Pixels(error) | WriteError::Encode(error) => error,
        WriteError::Io(error) => EncodeError::Encoder { format: "EXR", reason: error.to_string() },
    })?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::*;

    fn float(aov: Aov, components: usize, data: Vec<f32>) -> AovLayer {
        AovLayer { aov, samples: Samples::Float { components, data } }
    }

    #[test]
    fn layers_and_channels_come_back() {
        let radiance: Vec<f32> = (0..24).map(|value| value as f32 * 1000.5).collect();
        let aovs = [
            float(Aov::Normal, 3, (0..18).map(|value| value as f32 - 9.0).collect()),
            float(Aov::Depth, 1, vec![1.0, 2.0, 3.0, 4.0, 5.0, f32::INFINITY]),
            AovLayer { aov: Aov::ObjectId, samples: Samples::Id(vec![0, 1, u32::MAX, 3, 4, 16_777_217]) },
        ];
        let bytes = encode(3, 2, Some(&radiance), &aovs, &PictureInfo::default()).expect("encoded");
        let image = read_all_flat_layers_from_memory(bytes);
        let layer = |name: &str| {
            let named = |layer: &&Layer<AnyChannels<FlatSamples>>| layer.attributes.layer_name == Some(name.into());
            image.layer_data.iter().find(named).expect("layer")
        };
        let channel = |name: &str, channel: &str| {
            let channels = &layer(name).channel_data.list;
            channels.iter().find(|c| c.name.eq(channel)).expect("channel").sample_data.clone()
        };
        assert_eq!(channel("rgba", "A"), FlatSamples::F32(radiance.iter().copied().skip(3).step_by(4).collect()));
        assert_eq!(channel("rgba", "R"), FlatSamples::F32(radiance.iter().copied().step_by(4).collect()));
        assert_eq!(channel("normal", "Z"), FlatSamples::F32(vec![-7.0, -4.0, -1.0, 2.0, 5.0, 8.0]));
        assert_eq!(channel("depth", "Z"), FlatSamples::F32(vec![1.0, 2.0, 3.0, 4.0, 5.0, f32::INFINITY]));
        assert_eq!(channel("object_id", "Id"), FlatSamples::U32(vec![0, 1, u32::MAX, 3, 4, 16_777_217]));
        assert!(image.layer_data.iter().all(|layer| layer.encoding.compression == Compression::ZIP16));
    }

    /// The bits of all values of a file, part by part and channel by channel.
    fn bits(bytes: Vec<u8>) -> Vec<Vec<u32>> {
        let channels = |layer: Layer<AnyChannels<FlatSamples>>| layer.channel_data.list.into_iter();
        let of_channel = |channel: AnyChannel<FlatSamples>| match channel.sample_data {
            FlatSamples::F32(values) => values.into_iter().map(f32::to_bits).collect(),
            FlatSamples::U32(values) => values,
            FlatSamples::F16(_) => panic!("no half floats are written"),
        };
        read_all_flat_layers_from_memory(bytes).layer_data.into_iter().flat_map(channels).map(of_channel).collect()
    }

    #[test]
    fn every_compression_gives_back_every_bit() {
        use crate::{ExrCompression, picture_end};
        // Several bands of radiance, and last blocks that are not full. Flat at the top; below are random bits, some of
        // which are no numbers.
        let (width, height) = (128, 2 * 32 + 5);
        let count = (width * height) as usize;
        let mut state = 1u32;
        let mut noise = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state
        };
        let mut values = |flat: u32, components: usize| -> Vec<u32> {
            (0..components * count).map(|at| if at < components * count / 2 { flat } else { noise() }).collect()
        };
        let floats = |bits: Vec<u32>| bits.into_iter().map(f32::from_bits).collect::<Vec<f32>>();
        let radiance = floats(values(0.25f32.to_bits(), 4));
        let aovs = [
            float(Aov::Depth, 1, floats(values(f32::INFINITY.to_bits(), 1))),
            float(Aov::Normal, 3, floats(values((-0.0f32).to_bits(), 3))),
            AovLayer { aov: Aov::ObjectId, samples: Samples::Id(values(0, 1)) },
        ];
        assert!(band_rows(width, 4) < height);
        let file = |compression: ExrCompression| {
            let info = PictureInfo { compression, ..Default::default() };
            encode(width, height, Some(&radiance), &aovs, &info).expect("encoded")
        };
        let plain = file(ExrCompression::None);
        let expected = bits(plain.clone());
        assert_eq!(expected.len(), 4 + 1 + 3 + 1);
        let alpha: Vec<u32> = radiance.iter().skip(3).step_by(4).map(|value| value.to_bits()).collect();
        assert!(expected[0] == alpha, "channels are sorted by name");
        for name in ExrCompression::NAMES {
            let compression = ExrCompression::named(name).expect(name);
            let bytes = file(compression);
            let is_smaller = bytes.len() < plain.len();
            assert_eq!(is_smaller, compression != ExrCompression::None, "{name}: {} of {}", bytes.len(), plain.len());
            let is_whole = |bytes: &[u8]| picture_end::is_whole(&mut Cursor::new(bytes)).expect("read");
            assert!(is_whole(&bytes) && !is_whole(&bytes[..bytes.len() - 1]), "{name}");
            assert!(bits(bytes.clone()) == expected, "{name}");
            let image = read_all_flat_layers_from_memory(bytes);
            let says = |layer: &Layer<AnyChannels<FlatSamples>>| layer.encoding.compression == compression.of_header();
            assert!(image.layer_data.iter().all(says), "{name}");
        }
        // The smallest picture, of which there is nothing to pack.
        for name in ExrCompression::NAMES {
            let compression = ExrCompression::named(name).expect(name);
            let info = PictureInfo { compression, ..Default::default() };
            let bytes = encode(1, 1, Some(&[0.0, 0.0, 0.0, 1.0]), &[], &info).expect(name);
            assert_eq!(bits(bytes), [vec![1.0f32.to_bits()], vec![0], vec![0], vec![0]], "{name}");
        }
    }

    #[test]
    fn bands_join_and_the_same_pixels_are_the_same_bytes() {
        // Wide enough for three bands, with a last block that is not full.
        let (width, height) = (512, 3 * 32 + 3);
        let rows_a_band = band_rows(width, 1);
        assert!(rows_a_band < height / 2, "{rows_a_band}");
        let value = |row: u32, x: u32| (row * 7 + x / 64) as f32;
        let info =
            PictureInfo { time_secs: Some(0.5), frame: Some(3), frames_per_second: Some(24.0), ..Default::default() };
        let file = |height: u32| {
            let mut asked = Vec::new();
            let mut bytes = Cursor::new(Vec::new());
            write(&mut bytes, (width, height), &[ExrPart::of(Aov::Depth)], &info, |_, rows| {
                asked.push(rows.clone());
                let data = rows.flat_map(|row| (0..width).map(move |x| value(row, x))).collect();
                Ok::<_, ()>(Samples::Float { components: 1, data })
            })
            .expect("written");
            (bytes.into_inner(), asked)
        };
        let (bytes, asked) = file(height);
        assert!(asked.len() >= 3 && asked.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert_eq!(bytes, file(height).0);
        let image = read_all_flat_layers_from_memory(bytes);
        let FlatSamples::F32(values) = &image.layer_data[0].channel_data.list[0].sample_data else { panic!("floats") };
        for at in (0..values.len()).step_by(997) {
            assert_eq!(values[at], value(at as u32 / width, at as u32 % width));
        }
        let attributes = &image.layer_data[0].attributes;
        assert_eq!(attributes.frames_per_second, Some((24, 1)));
        assert_eq!(attributes.other.get(&Text::from("manypass/frame")), Some(&AttributeValue::I32(3)));
    }

    fn read_all_flat_layers_from_memory(bytes: Vec<u8>) -> FlatImage {
        let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        reader.non_parallel().from_buffered(Cursor::new(bytes)).expect("read")
    }

    #[test]
    fn nothing_and_wrong_lengths_are_errors() {
        let info = PictureInfo::default();
        assert!(encode(1, 1, None, &[], &info).is_err());
        assert!(encode(2, 1, Some(&[0.0; 4]), &[], &info).is_err());
        let full = |_: &[u8]| Err::<usize, _>(io::Error::from(io::ErrorKind::StorageFull));
        struct Full<F>(F);
        impl<F: FnMut(&[u8]) -> io::Result<usize>> Write for Full<F> {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                (self.0)(bytes)
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        impl<F> Seek for Full<F> {
            fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
                Ok(0)
            }
        }
        let pixels = |_, _| Ok::<_, ()>(Samples::Id(vec![1]));
        let error = write(&mut Full(full), (1, 1), &[ExrPart::of(Aov::ObjectId)], &info, pixels).expect_err("full");
        assert!(matches!(error, WriteError::Io(error) if error.kind() == io::ErrorKind::StorageFull));
    }
}
