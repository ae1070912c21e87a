//! The stream of attributes: elements are split into their bytes, and the differences from element to element are
//! packed in groups of sixteen.

use super::{Stream, StreamError};

/// Elements whose differences share a width.
const GROUP_ELEMENTS: usize = 16;
/// The most elements of a block.
const BLOCK_ELEMENTS: usize = 256;
/// The most bytes of a block.
const BLOCK_BYTES: usize = 8192;
/// What one byte of a stream stands for at most: blocks without differences, four bytes of every element in one byte.
const MAX_RATIO: usize = 4 * BLOCK_ELEMENTS;

/// Differences in one byte of all elements of a block.
type Plane = [u8; BLOCK_ELEMENTS];

/// How four bytes of an element follow from those of the one before.
#[derive(Clone, Copy)]
enum Channel {
    /// Four differences of one byte.
    Bytes,
    /// Two differences of two bytes.
    Halves,
    /// The bits that differ, rotated left by so many.
    Bits(u32),
}

impl Channel {
    fn new(code: u8) -> Result<Self, StreamError> {
        match (code & 15, code >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Halves),
            (2, rotation) => Ok(Self::Bits(u32::from(rotation))),
            _ => Err(StreamError::Broken("a way to store differences is not known")),
        }
    }

    fn next(self, before: [u8; 4], stored: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => {
                let mut next = before;
                for (byte, stored) in next.iter_mut().zip(stored) {
                    *byte = byte.wrapping_add((stored >> 1) ^ 0_u8.wrapping_sub(stored & 1));
                }
                next
            }
            Self::Halves => {
                let half = |before: [u8; 2], stored: [u8; 2]| {
                    let stored = u16::from_le_bytes(stored);
                    let difference = (stored >> 1) ^ 0_u16.wrapping_sub(stored & 1);
                    u16::from_le_bytes(before).wrapping_add(difference).to_le_bytes()
                };
                let [a, b, c, d] = before;
                let [s, t, u, v] = stored;
                let ([a, b], [c, d]) = (half([a, b], [s, t]), half([c, d], [u, v]));
                [a, b, c, d]
            }
            Self::Bits(rotation) => {
                let difference = u32::from_le_bytes(stored).rotate_right(rotation);
                (u32::from_le_bytes(before) ^ difference).to_le_bytes()
            }
        }
    }
}

/// `count` elements of `stride` bytes, a multiple of 4 up to 256.
///
/// # Errors
/// If the stream is broken. No more memory is taken than the stream can fill.
pub(super) fn decode(data: &[u8], count: usize, stride: usize, may_be_version_1: bool) -> Result<Vec<u8>, StreamError> {
    let mut stream = Stream(data);
    let is_version_1 = match stream.byte()? {
        0xa0 => false,
        0xa1 if may_be_version_1 => true,
        found => return Err(StreamError::Header { expected: 0xa0, found }),
    };
    let channel_count = stride / 4;
    let tail_bytes = if is_version_1 { (stride + channel_count).max(24) } else { stride.max(32) };
    let body_bytes = stream.0.len().checked_sub(tail_bytes).ok_or(StreamError::Ends)?;
    let (body, tail) = stream.0.split_at(body_bytes);
    let (tail, codes) = tail.split_at(if is_version_1 { tail.len() - channel_count } else { tail.len() });
    let mut baseline = tail.get(tail.len() - stride..).unwrap_or_default().to_vec();
    let mut channels = vec![Channel::Bytes; channel_count];
    for (channel, code) in channels.iter_mut().zip(codes) {
        *channel = Channel::new(*code)?;
    }

    let mut stream = Stream(body);
    let block_elements = ((BLOCK_BYTES / stride) & !(GROUP_ELEMENTS - 1)).min(BLOCK_ELEMENTS);
    let mut elements = Vec::with_capacity((count * stride).min(data.len().saturating_mul(MAX_RATIO)));
    let mut left = count;
    while left > 0 {
        let block = left.min(block_elements);
        let controls = if is_version_1 { Some(stream.take(channel_count)?) } else { None };
        let start = elements.len();
        elements.resize(start + block * stride, 0);
        let target = elements.get_mut(start..).unwrap_or_default();
        for (at, channel) in channels.iter().enumerate() {
            let control = controls.and_then(|controls| controls.get(at)).copied();
            let planes = read_planes(&mut stream, control, block)?;
            let mut before = baseline.get(4 * at..).and_then(|bytes| bytes.first_chunk()).copied().unwrap_or_default();
            for (i, element) in target.chunks_exact_mut(stride).enumerate() {
                before = channel.next(before, planes.each_ref().map(|plane| plane.get(i).copied().unwrap_or(0)));
                if let Some(slot) = element.get_mut(4 * at..4 * at + 4) {
                    slot.copy_from_slice(&before);
                }
            }
        }
        baseline = target.rchunks_exact(stride).next().unwrap_or_default().to_vec();
        left -= block;
    }
    stream.end()?;
    Ok(elements)
}

/// The differences in four bytes of the elements of a block. `control`, in version 1, has two bits for each byte.
fn read_planes(stream: &mut Stream, control: Option<u8>, count: usize) -> Result<[Plane; 4], StreamError> {
    let mut planes = [[0; BLOCK_ELEMENTS]; 4];
    for (at, plane) in planes.iter_mut().enumerate() {
        let widths = match control.map(|control| (control >> (2 * at)) & 3) {
            None => [0, 2, 4, 8],
            Some(0) => [0, 1, 2, 4],
            Some(1) => [1, 2, 4, 8],
            Some(2) => continue,
            Some(_) => {
                let literal = stream.take(count)?;
                for (slot, byte) in plane.iter_mut().zip(literal) {
                    *slot = *byte;
                }
                continue;
            }
        };
        let group_count = count.div_ceil(GROUP_ELEMENTS);
        let header = stream.take(group_count.div_ceil(4))?;
        let codes = header.iter().flat_map(|byte| [0, 2, 4, 6].map(|shift| usize::from((byte >> shift) & 3)));
        for (group, code) in plane.chunks_exact_mut(GROUP_ELEMENTS).take(group_count).zip(codes) {
            read_group(stream, widths.get(code).copied().unwrap_or(0), group)?;
        }
    }
    Ok(planes)
}

/// Sixteen differences of `width` bits. One with all bits set stands for a whole byte that follows the group.
fn read_group(stream: &mut Stream, width: usize, group: &mut [u8]) -> Result<(), StreamError> {
    match width {
        0 => group.fill(0),
        8 => group.copy_from_slice(stream.take(GROUP_ELEMENTS)?),
        _ => {
            let packed = stream.take(GROUP_ELEMENTS * width / 8)?;
            let mask = (1_u8 << width) - 1;
            let slots = 8 / width;
            for (bytes, packed) in group.chunks_exact_mut(slots).zip(packed) {
                for (slot, byte) in bytes.iter_mut().enumerate() {
                    // Single bits start at the low end of a byte, the others at its high end.
                    let shift = if width == 1 { slot } else { 8 - width * (slot + 1) };
                    *byte = (packed >> shift) & mask;
                    if *byte == mask {
                        *byte = stream.byte()?;
                    }
                }
            }
        }
    }
    Ok(())
}
