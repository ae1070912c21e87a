//! Light that was baked, as half floats with mips, or above where it comes from.

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

/// All mips of `light`.
pub(super) fn mip_chain(mut light: HalfFloats) -> MipChain {
    let mut levels = vec![level(&light)];
    while light.width > 1 || light.height > 1 {
        light = halved(&light);
        levels.push(level(&light));
    }
    MipChain { levels, layers: 1, texels: Texels::HalfFloats }
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

    #[test]
    fn mips_keep_the_mean_of_light() {
        for (width, height) in [(8, 4), (7, 5), (1, 6), (3, 1)] {
            let texel = |at: u32| [f16::from_f32((at * 2617 % 500) as f32), f16::ZERO, f16::ONE, f16::ONE];
            let texels: Vec<_> = (0..width * height).map(texel).collect();
            let mean = texels.iter().map(|texel| texel[0].to_f32()).sum::<f32>() / texels.len() as f32;
            let chain = mip_chain(HalfFloats { width, height, texels, cut_count: 0 });
            assert_eq!(chain.levels[0].data.len(), (width * height * 8) as usize);
            let last = chain.levels.last().map(|level| (level.width, level.height, level.data.clone()));
            let Some((1, 1, last)) = last else { panic!("{width} by {height}: {last:?}") };
            let last: Vec<f32> =
                bytemuck::pod_collect_to_vec::<u8, f16>(&last).iter().map(|half| half.to_f32()).collect();
            // Each level rounds to 11 bits.
            assert!((last[0] - mean).abs() < 0.002 * mean && last[1..] == [0.0, 1.0, 1.0], "{last:?} {mean}");
            let wide = HalfFloats { width: 16, height: 2, texels: vec![[f16::ONE; 4]; 32], cut_count: 0 };
            let limited = limited(wide, 8, 1);
            assert_eq!((limited.width, limited.height), (8, 1));
        }
    }
}
