//! Heights as texels: 16 bits in two channels of eight, which `height.wgsl` puts together again.

use super::mips::{MipChain, Texels};
use manypass_scene::{Heights, PixelFormat, Pixels};

/// All mips of heights. They are halved before their bits are parted, so that no level loses any.
pub(super) fn mip_chain(heights: Heights) -> MipChain {
    let mut levels = vec![texels(&heights)];
    let mut last = heights;
    while last.width > 1 || last.height > 1 {
        last = half(&last);
        levels.push(texels(&last));
    }
    MipChain { levels, layers: 1, texels: Texels::Bytes }
}

/// The upper eight bits in red, the lower in green.
fn texels(heights: &Heights) -> Pixels {
    let data = heights.data.iter().flat_map(|height| {
        let [upper, lower] = height.to_be_bytes();
        [upper, lower, 0, 255]
    });
    Pixels { width: heights.width, height: heights.height, format: PixelFormat::Rgba8, data: data.collect() }
}

/// Half the width and height; where a size is odd the last texel is the mean of three.
fn half(heights: &Heights) -> Heights {
    let (width, height) = ((heights.width / 2).max(1), (heights.height / 2).max(1));
    // Of the larger side the texels that one of the smaller covers.
    let covered = |at: u32, from: u32, to: u32| {
        let first = (at * 2).min(from - 1);
        let end = if at + 1 == to { from } else { first + 2 };
        first..end
    };
    let mut data = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut count) = (0_u64, 0_u64);
            for from_y in covered(y, heights.height, height) {
                for from_x in covered(x, heights.width, width) {
                    let at = from_y as usize * heights.width as usize + from_x as usize;
                    sum += u64::from(heights.data.get(at).copied().unwrap_or(0));
                    count += 1;
                }
            }
            data.push(((sum + count / 2) / count.max(1)) as u16);
        }
    }
    Heights { width, height, data }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mips_keep_the_mean_of_heights_to_the_last_bit() {
        for (width, height) in [(8, 4), (7, 5), (1, 6), (3, 1)] {
            let data: Vec<u16> = (0..width * height).map(|at| (at * 2617 % 65536) as u16).collect();
            let chain = mip_chain(Heights { width, height, data: data.clone() });
            let last = chain.levels.last().map(|level| (level.width, level.height, level.data.clone()));
            let Some((1, 1, texel)) = last else { panic!("{width} by {height}: {last:?}") };
            assert_eq!(chain.levels[0].data.len(), data.len() * 4);
            let found = u16::from_be_bytes([texel[0], texel[1]]);
            let (low, high) = (data.iter().min().copied().unwrap_or(0), data.iter().max().copied().unwrap_or(0));
            assert!((low..=high).contains(&found), "{width} by {height}: {found}");
            if (width, height) == (8, 4) {
                let mean = data.iter().map(|height| f64::from(*height)).sum::<f64>() / data.len() as f64;
                // Each of three levels rounds once.
                assert!((f64::from(found) - mean).abs() <= 1.5, "{found} {mean}");
            }
        }
    }
}
