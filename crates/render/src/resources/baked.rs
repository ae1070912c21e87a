//! Light that was baked, as half floats with mips.

use super::mips::{MipChain, Texels, footprint};
use half::f16;
use manypass_scene::{HalfFloats, PixelFormat, Pixels};

/// All mips of `light`, the first no larger than `limit` texels a side.
pub(super) fn mip_chain(mut light: HalfFloats, limit: u32) -> MipChain {
    while light.width.max(light.height) > limit {
        light = halved(&light);
    }
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
            let chain = mip_chain(HalfFloats { width, height, texels, cut_count: 0 }, 8);
            assert_eq!(chain.levels[0].data.len(), (width * height * 8) as usize);
            let last = chain.levels.last().map(|level| (level.width, level.height, level.data.clone()));
            let Some((1, 1, last)) = last else { panic!("{width} by {height}: {last:?}") };
            let last: Vec<f32> =
                bytemuck::pod_collect_to_vec::<u8, f16>(&last).iter().map(|half| half.to_f32()).collect();
            // Each level rounds to 11 bits.
            assert!((last[0] - mean).abs() < 0.002 * mean && last[1..] == [0.0, 1.0, 1.0], "{last:?} {mean}");
            let chain =
                mip_chain(HalfFloats { width: 16, height: 2, texels: vec![[f16::ONE; 4]; 32], cut_count: 0 }, 8);
            assert_eq!((chain.levels[0].width, chain.levels[0].height), (8, 1));
        }
    }
}
