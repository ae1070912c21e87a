//! Light that was baked: as three numbers of one exponent with mips, or as half floats above where it comes from.

use super::mips::{MipChain, Texels, footprint};
use crate::colour::linear_from_srgb;
use half::f16;
use manypass_scene::{HalfFloats, PixelFormat, Pixels};

/// `light` as half floats.
pub(super) fn of_bytes(light: &Pixels, is_srgb: bool) -> HalfFloats {
    let value = |byte: u8| {
        let value = f32::from(byte) / 255.0;
        f16::from_f32(if is_srgb { linear_from_srgb(value) } else { value })
    };
    let texels = light.data.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [value(*r), value(*g), value(*b), f16::ONE]);
    HalfFloats { width: light.width, height: light.height, texels: texels.collect(), cut_count: 0 }
}

/// `light`, so small that `halves` of its height lie one below the other in no more than `limit` texels a side.
pub(super) fn limited(mut light: HalfFloats, limit: u32, halves: u32) -> HalfFloats {
    while light.width.max(halves * light.height) > limit && light.width.max(light.height) > 1 {
        light = halved(&light);
    }
    light
}

/// `light`, and where it comes from below it, each part of a direction from -1 to 1; 0 where that is not known.
pub(super) fn with_directions(mut light: HalfFloats, directions: Option<Pixels>) -> MipChain {
    let part = |byte: u8| f16::from_f32(f32::from(byte) / 127.5 - 1.0);
    let count = light.texels.len();
    let directions = directions.iter().flat_map(|pixels| pixels.data.as_chunks::<4>().0);
    light.texels.extend(directions.map(|[x, y, z, _]| [part(*x), part(*y), part(*z), f16::ONE]));
    light.texels.resize(2 * count, [f16::ZERO; 4]);
    light.height *= 2;
    MipChain { levels: vec![level(&light)], layers: 1, texels: Texels::HalfFloats }
}

/// All mips of `light`, in half as many bytes as half floats take.
pub(super) fn mip_chain(mut light: HalfFloats) -> MipChain {
    let mut levels = vec![level_of_one_exponent(&light)];
    while light.width > 1 || light.height > 1 {
        light = halved(&light);
        levels.push(level_of_one_exponent(&light));
    }
    MipChain { levels, layers: 1, texels: Texels::OneExponent }
}

/// Three numbers from 0 on as nine bits each, times a power of two that the largest of them chooses
/// (`EXT_texture_shared_exponent`).
fn of_one_exponent(texel: [f16; 4]) -> u32 {
    const BIAS: i32 = 15;
    const BITS: i32 = 9;
    let color: [f32; 3] = std::array::from_fn(|channel| texel[channel].to_f32().clamp(0.0, 65_408.0));
    let most = color[0].max(color[1]).max(color[2]);
    let whole = |value: f32, exponent: i32| (value * 2f32.powi(BITS + BIAS - exponent)).round() as u32;
    let mut exponent = most.max(2f32.powi(-BIAS - 1)).log2().floor() as i32 + 1 + BIAS;
    // What rounds up to one bit more.
    if whole(most, exponent) >> BITS > 0 {
        exponent += 1;
    }
    let [red, green, blue] = color.map(|value| whole(value, exponent));
    red | green << 9 | blue << 18 | (exponent as u32) << 27
}

fn level_of_one_exponent(light: &HalfFloats) -> Pixels {
    let data = light.texels.iter().flat_map(|texel| of_one_exponent(*texel).to_le_bytes()).collect();
    Pixels { width: light.width, height: light.height, format: PixelFormat::Rgba8, data }
}

fn level(light: &HalfFloats) -> Pixels {
    let data = bytemuck::cast_slice(&light.texels).to_vec();
    Pixels { width: light.width, height: light.height, format: PixelFormat::Rgba8, data }
}

/// Half the width and height by a box filter; where a size is 1 it stays.
fn halved(light: &HalfFloats) -> HalfFloats {
    let (from_width, from_height) = (light.width as usize, light.height as usize);
    let (width, height) = ((from_width / 2).max(1), (from_height / 2).max(1));
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        let (first_row, row_weights) = footprint(from_height, y);
        for x in 0..width {
            let (first, weights) = footprint(from_width, x);
            let (mut sum, mut total) = ([0.0_f32; 4], 0.0);
            for (row, row_weight) in (first_row..from_height).zip(row_weights) {
                for (column, weight) in (first..from_width).zip(weights) {
                    let weight = (row_weight * weight) as f32;
                    total += weight;
                    let texel = light.texels.get(row * from_width + column).copied().unwrap_or_default();
                    sum = std::array::from_fn(|channel| sum[channel] + texel[channel].to_f32() * weight);
                }
            }
            texels.push(sum.map(|sum| f16::from_f32(sum / total)));
        }
    }
    HalfFloats { width: width as u32, height: height as u32, texels, cut_count: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color_of(bits: u32) -> [f32; 3] {
        let scale = 2f32.powi((bits >> 27) as i32 - 24);
        [bits, bits >> 9, bits >> 18].map(|whole| (whole & 511) as f32 * scale)
    }

    #[test]
    fn mips_keep_the_mean_of_light() {
        for (width, height) in [(8, 4), (7, 5), (1, 6), (3, 1)] {
            let texel = |at: u32| [f16::from_f32((at * 2617 % 500) as f32), f16::ZERO, f16::ONE, f16::ONE];
            let texels: Vec<_> = (0..width * height).map(texel).collect();
            let mean = texels.iter().map(|texel| texel[0].to_f32()).sum::<f32>() / texels.len() as f32;
            let chain = mip_chain(HalfFloats { width, height, texels, cut_count: 0 });
            assert_eq!(chain.levels[0].data.len(), (width * height * 4) as usize);
            let last = chain.levels.last().map(|level| (level.width, level.height, level.data.clone()));
            let Some((1, 1, last)) = last else { panic!("{width} by {height}: {last:?}") };
            let last = color_of(u32::from_le_bytes(last.try_into().unwrap()));
            // Each level rounds to 11 bits, and the last to 9 of the largest number.
            assert!((last[0] - mean).abs() < 0.004 * mean && last[1] == 0.0, "{last:?} {mean}");
            assert!((last[2] - 1.0).abs() < 0.002 * mean, "{last:?} {mean}");
            let wide = HalfFloats { width: 16, height: 2, texels: vec![[f16::ONE; 4]; 32], cut_count: 0 };
            let limited = limited(wide, 8, 1);
            assert_eq!((limited.width, limited.height), (8, 1));
        }
    }

    #[test]
    fn numbers_of_one_exponent_come_back() {
        for color in
            [[0.0; 3], [1.0; 3], [0.5, 0.25, 3e-5], [65_000.0, 1.0, 0.0], [1.9985, 0.1, 1.0], [6e-8, 0.0, 1e-6]]
        {
            let texel = [color[0], color[1], color[2], 1.0].map(f16::from_f32);
            let back = color_of(of_one_exponent(texel));
            let most = color.into_iter().fold(0f32, f32::max);
            for (found, expected) in back.into_iter().zip(color) {
                assert!((found - expected).abs() <= most / 500.0 + 6e-8, "{back:?} {color:?}");
            }
        }
    }
}
