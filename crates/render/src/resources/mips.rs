//! Mips: every image is halved until one texel is left.

use crate::colour::{linear_from_srgb, srgb_from_linear};
use manypass_scene::{BlockFormat, Blocks, PixelFormat, Pixels};

/// An image with all its mips, the largest first; or several of one size, whose texels follow each other in every
/// level.
pub(super) struct MipChain {
    pub levels: Vec<Pixels>,
    /// How many images.
    pub layers: u32,
    /// What the bytes of levels are.
    pub texels: Texels,
}

/// What the bytes of a level are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Texels {
    /// Four bytes a texel.
    Bytes,
    /// Four half floats a texel.
    HalfFloats,
    /// Three numbers of nine bits and the exponent of all, in four bytes a texel.
    OneExponent,
    /// Compressed blocks.
    Blocks(BlockFormat),
}

impl MipChain {
    /// Of `base`, whose colours are sRGB or which is data.
    pub fn of(base: Pixels, is_srgb: bool) -> Self {
        let mut levels = vec![base];
        while let Some(last) = levels.last()
            && (last.width > 1 || last.height > 1)
        {
            let next = half(last, is_srgb);
            levels.push(next);
        }
        Self { levels, layers: 1, texels: Texels::Bytes }
    }

    /// The levels of a compressed image.
    pub fn of_blocks(levels: Vec<Blocks>, format: BlockFormat) -> Self {
        let level = |Blocks { width, height, data }| Pixels { width, height, format: PixelFormat::Rgba8, data };
        Self { levels: levels.into_iter().map(level).collect(), layers: 1, texels: Texels::Blocks(format) }
    }

    /// Its format on the device.
    pub fn format(&self, is_srgb: bool) -> wgpu::TextureFormat {
        let (linear, srgb) = match self.texels {
            Texels::Bytes => (wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Rgba8UnormSrgb),
            Texels::HalfFloats => (wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Rgba16Float),
            Texels::OneExponent => (wgpu::TextureFormat::Rgb9e5Ufloat, wgpu::TextureFormat::Rgb9e5Ufloat),
            Texels::Blocks(BlockFormat::Bc7) => {
                (wgpu::TextureFormat::Bc7RgbaUnorm, wgpu::TextureFormat::Bc7RgbaUnormSrgb)
            }
            Texels::Blocks(BlockFormat::Etc2) => {
                (wgpu::TextureFormat::Etc2Rgba8Unorm, wgpu::TextureFormat::Etc2Rgba8UnormSrgb)
            }
            Texels::Blocks(BlockFormat::Astc) => {
                let astc = |channel| wgpu::TextureFormat::Astc { block: wgpu::AstcBlock::B4x4, channel };
                (astc(wgpu::AstcChannel::Unorm), astc(wgpu::AstcChannel::UnormSrgb))
            }
        };
        if is_srgb { srgb } else { linear }
    }

    /// Adds the images of another one of the same size.
    pub fn append(&mut self, other: Self) {
        self.layers += other.layers;
        for (level, of_other) in self.levels.iter_mut().zip(other.levels) {
            level.data.extend(of_other.data);
        }
    }
}

/// Linear values of sRGB bytes, scaled to 16 bits, and back through 12 bits (4,096 steps keep the error below one
/// byte).
struct SrgbTables {
    linear: [u16; 256],
    srgb: [u8; 4096],
}

static SRGB: std::sync::LazyLock<SrgbTables> = std::sync::LazyLock::new(|| SrgbTables {
    linear: std::array::from_fn(|i| (linear_from_srgb(i as f32 / 255.0) * 65535.0).round() as u16),
    srgb: std::array::from_fn(|i| (srgb_from_linear(i as f32 / 4095.0) * 255.0).round() as u8),
});

/// Half the width and height by a box filter, in linear light for colours; where a size is 1 it stays.
pub(super) fn half(pixels: &Pixels, is_srgb: bool) -> Pixels {
    if [pixels.width, pixels.height].iter().any(|size| *size > 1 && size % 2 == 1) {
        return half_of_odd(pixels, is_srgb);
    }
    let (width, height) = ((pixels.width / 2).max(1), (pixels.height / 2).max(1));
    let tables = &*SRGB;
    let linear_sum = |texels: [u8; 4]| texels.iter().map(|t| u32::from(tables.linear[usize::from(*t)])).sum::<u32>();
    // The mean of four 16-bit values, rounded to 12 bits.
    let color = |texels: [u8; 4]| tables.srgb[(((linear_sum(texels) + 32) >> 6) as usize).min(4095)];
    let value = |texels: [u8; 4]| ((texels.iter().map(|t| u32::from(*t)).sum::<u32>() + 2) / 4) as u8;
    let mut data = vec![0; (width * height * 4) as usize];
    let stride = pixels.width as usize * 4;
    for (y, row) in data.chunks_exact_mut(width as usize * 4).enumerate() {
        let row_of = |y: usize| &pixels.data[y.min(pixels.height as usize - 1) * stride..][..stride];
        let (row0, row1) = (row_of(2 * y), row_of(2 * y + 1));
        // Two texels become one; where the width is 1, the one is both.
        let step = if pixels.width == 1 { 4 } else { 8 };
        let right = step - 4;
        for ((texel, above), below) in row.chunks_exact_mut(4).zip(row0.chunks_exact(step)).zip(row1.chunks_exact(step))
        {
            let four = |c: usize| [above[c], above[right + c], below[c], below[right + c]];
            if is_srgb {
                texel.copy_from_slice(&[color(four(0)), color(four(1)), color(four(2)), value(four(3))]);
            } else {
                texel.copy_from_slice(&[value(four(0)), value(four(1)), value(four(2)), value(four(3))]);
            }
        }
    }
    Pixels { width, height, format: pixels.format, data }
}

/// What a texel of the next mip covers along one side of `size` texels: the first texel and the weights from there on.
/// An odd size 2 m + 1 becomes m, each of them as wide as 2 + 1/m texels, so that every texel counts for the same
/// (polyphase box filter; Guthe & Heckbert 2005, "Non-power-of-two mipmap creation").
pub(super) fn footprint(size: usize, index: usize) -> (usize, [u64; 3]) {
    let half = size / 2;
    let weights = match size {
        1 => [1, 0, 0],
        _ if size.is_multiple_of(2) => [1, 1, 0],
        _ => [half - index, half, index + 1].map(|weight| weight as u64),
    };
    (2 * index, weights)
}

/// [`half`] for any size.
fn half_of_odd(pixels: &Pixels, is_srgb: bool) -> Pixels {
    let (from_width, from_height) = (pixels.width as usize, pixels.height as usize);
    let (width, height) = ((from_width / 2).max(1), (from_height / 2).max(1));
    let tables = &*SRGB;
    let weight_sum = |size| footprint(size, 0).1.iter().sum::<u64>();
    let total = weight_sum(from_width) * weight_sum(from_height);
    let stride = from_width * 4;
    let mut data = Vec::with_capacity(width * height * 4);
    // Weighted sums of the rows that a row of the result covers.
    let mut sums = vec![0u64; stride];
    for y in 0..height {
        sums.fill(0);
        let (first, weights) = footprint(from_height, y);
        for (row, weight) in pixels.data.chunks_exact(stride).skip(first).zip(weights) {
            for (at, (byte, sum)) in row.iter().zip(&mut sums).enumerate() {
                let is_color = is_srgb && at % 4 < 3;
                let value = if is_color { tables.linear[usize::from(*byte)] } else { u16::from(*byte) };
                *sum += weight * u64::from(value);
            }
        }
        for x in 0..width {
            let (first, weights) = footprint(from_width, x);
            for channel in 0..4 {
                let columns = sums[channel..].iter().step_by(4).skip(first).zip(weights);
                let sum: u64 = columns.map(|(sum, weight)| sum * weight).sum();
                data.push(if is_srgb && channel < 3 {
                    // The mean of 16-bit values, rounded to 12 bits.
                    tables.srgb[((sum + 8 * total) / (16 * total)).min(4095) as usize]
                } else {
                    ((sum + total / 2) / total) as u8
                });
            }
        }
    }
    Pixels { width: width as u32, height: height as u32, format: pixels.format, data }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, level: impl Fn(u32, u32) -> u8) -> Pixels {
        let texel = |i: u32| [[level(i % width, i / width); 3].as_slice(), &[255]].concat();
        Pixels {
            width,
            height,
            format: manypass_scene::PixelFormat::Rgba8,
            data: (0..width * height).flat_map(texel).collect(),
        }
    }

    fn levels(pixels: &Pixels) -> Vec<u8> {
        pixels.data.chunks_exact(4).map(|texel| texel[0]).collect()
    }

    #[test]
    fn every_texel_counts_for_the_same_in_the_next_mip() {
        // A row of three becomes one texel, a row of five two: 2/5, 2/5, 1/5 and the other way round.
        assert_eq!(levels(&half(&grey(3, 1, |x, _| [0, 0, 255][x as usize]), false)), [85]);
        assert_eq!(levels(&half(&grey(1, 3, |_, y| [0, 0, 255][y as usize]), false)), [85]);
        assert_eq!(levels(&half(&grey(5, 1, |x, _| [0, 0, 250, 0, 0][x as usize]), false)), [50, 50]);
        assert_eq!(levels(&half(&grey(5, 1, |x, _| [250, 0, 0, 0, 0][x as usize]), false)), [100, 0]);
        // In linear light a third of white is 0.333, which is 156 in sRGB.
        assert_eq!(levels(&half(&grey(3, 1, |x, _| [0, 0, 255][x as usize]), true)), [156]);
        for (width, height) in [(7, 5), (9, 4), (4, 9), (37, 1), (1, 37), (641, 3)] {
            // Whatever stands in a corner, and a pattern, leave the mean as it is but for rounding.
            for pattern in [|x: u32, y: u32| ((x * 89 + y * 57) % 256) as u8, |x, y| if x + y == 0 { 240 } else { 9 }] {
                let image = grey(width, height, pattern);
                let mean = |pixels: &Pixels| {
                    let levels = levels(pixels);
                    levels.iter().map(|level| f64::from(*level)).sum::<f64>() / levels.len() as f64
                };
                let (before, after) = (mean(&image), mean(&half(&image, false)));
                assert!((before - after).abs() <= 0.5, "{width}x{height}: {before} becomes {after}");
            }
        }
    }

    #[test]
    fn mips_of_even_sizes_are_means_of_four_texels() {
        let image = grey(4, 2, |x, y| [[10, 20, 255, 255], [30, 41, 255, 0]][y as usize][x as usize]);
        assert_eq!(levels(&half(&image, false)), [25, 191]);
        assert_eq!(levels(&half(&image, true)), [27, 225]);
        assert_eq!(levels(&half(&grey(2, 1, |x, _| [10, 21][x as usize]), false)), [16]);
        for is_srgb in [false, true] {
            assert_eq!(half(&image, is_srgb), half_of_odd(&image, is_srgb));
        }
    }
}
