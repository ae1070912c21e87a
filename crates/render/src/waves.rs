//! The map of waves that water without a normal map has.

use crate::gpu::Gpu;
use half::f16;
use std::f32::consts::TAU;

/// Its width and height in texels.
const WAVES_SIDE: usize = 256;

/// What a simulation calls its picture of slopes and their squares.
pub const SIMULATED: &str = "waves";

/// How many of the longest waves follow each other along a side.
pub const WAVES_ACROSS: f32 = 4.0;

/// The shortest waves are so many to a side.
const SHORTEST: f32 = 56.0;

/// A level of the map: slopes along x and y and their squares, so that filtering keeps both moments.
struct WavesLevel {
    /// Width and height.
    side: usize,
    /// Four numbers a texel.
    texels: Vec<[f16; 4]>,
}

/// The map with its mips, which repeats itself on all sides: waves that go towards +x or so, and whose slopes have a mean
/// square of 1, of both directions together.
///
/// Source: a sum of waves of chance phases whose slopes are as strong in every octave, as in the equilibrium range of wind
/// waves (Phillips 1958), and which spread about the wind by the square of the cosine of half their angle to the fourth
/// power (Longuet-Higgins, Cartwright & Smith 1963); by the fast Fourier transform (Tessendorf 2001).
fn waves() -> Vec<WavesLevel> {
    let side = WAVES_SIDE;
    // The first spectrum's real part becomes slopes along x, its imaginary part those along y.
    let mut field = vec![(0.0f32, 0.0f32); side * side];
    let mut bits = 0x9e37_79b9u32;
    for row in 0..side {
        for column in 0..side {
            let wave = |at: usize| if at < side / 2 { at as f32 } else { at as f32 - side as f32 };
            let (kx, ky) = (wave(column), wave(row));
            bits = mixed(bits.wrapping_add(0x6d2b_79f5));
            let length = kx.hypot(ky);
            if !(WAVES_ACROSS..=SHORTEST).contains(&length) {
                continue;
            }
            let cosine_half_squared = 0.5 + 0.5 * kx / length;
            let amplitude = cosine_half_squared.powi(4) / (length * length);
            let phase = bits as f32 / 4_294_967_296.0 * TAU;
            // A wave's part at -k is its conjugate; both go into the sum, so that it is real.
            let (re, im) = (amplitude * phase.cos(), amplitude * phase.sin());
            let mut add = |row: usize, column: usize, sign: f32| {
                // i k h of both directions: i kx h + i (i ky h).
                let (kx, ky, im) = (sign * kx, sign * ky, sign * im);
                let place = &mut field[row * side + column];
                place.0 += -kx * im - ky * re;
                place.1 += kx * re - ky * im;
            };
            add(row, column, 1.0);
            add((side - row) % side, (side - column) % side, -1.0);
        }
    }
    for _ in 0..2 {
        for row in field.chunks_exact_mut(side) {
            transform(row);
        }
        transpose(&mut field, side);
    }
    let square: f32 = field.iter().map(|(x, y)| x * x + y * y).sum::<f32>() / (side * side) as f32;
    let scale = square.max(f32::MIN_POSITIVE).sqrt().recip();
    let texel = |(x, y): &(f32, f32)| {
        let (x, y) = (x * scale, y * scale);
        [x, y, x * x, y * y]
    };
    let mut level: Vec<[f32; 4]> = field.iter().map(texel).collect();
    let mut levels = Vec::new();
    let mut side = side;
    loop {
        levels.push(WavesLevel { side, texels: level.iter().map(|texel| texel.map(f16::from_f32)).collect() });
        if side == 1 {
            return levels;
        }
        side /= 2;
        let mean = |at: usize| {
            let (x, y) = (2 * (at % side), 2 * (at / side));
            let of = |x: usize, y: usize| level[y * 2 * side + x];
            let four = [of(x, y), of(x + 1, y), of(x, y + 1), of(x + 1, y + 1)];
            std::array::from_fn(|part| 0.25 * four.iter().map(|texel| texel[part]).sum::<f32>())
        };
        level = (0..side * side).map(mean).collect();
    }
}

/// The texture of the built-in waves.
pub(crate) fn waves_texture(gpu: &Gpu) -> wgpu::TextureView {
    let levels = waves();
    let extent = |side: usize| wgpu::Extent3d { width: side as u32, height: side as u32, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("waves"),
        size: levels.first().map_or(extent(1), |level| extent(level.side)),
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, level) in (0..).zip(&levels) {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() },
            bytemuck::cast_slice(&level.texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(8 * level.side as u32),
                rows_per_image: Some(level.side as u32),
            },
            extent(level.side),
        );
    }
    texture.create_view(&Default::default())
}

/// The finaliser of MurmurHash3.
fn mixed(bits: u32) -> u32 {
    let hash = (bits ^ (bits >> 16)).wrapping_mul(0x85eb_ca6b);
    let hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

fn transpose(field: &mut [(f32, f32)], side: usize) {
    for row in 0..side {
        for column in 0..row {
            field.swap(row * side + column, column * side + row);
        }
    }
}

/// The inverse discrete Fourier transform, without its scale, of a power of two of numbers (Cooley & Tukey 1965).
fn transform(values: &mut [(f32, f32)]) {
    let count = values.len();
    let bits = count.trailing_zeros();
    for at in 0..count {
        let other = at.reverse_bits() >> (usize::BITS - bits);
        if at < other {
            values.swap(at, other);
        }
    }
    let mut half = 1;
    while half < count {
        for at in 0..half {
            let (sin, cos) = (std::f32::consts::PI * at as f32 / half as f32).sin_cos();
            for first in (at..count).step_by(2 * half) {
                let (a, b) = (values[first], values[first + half]);
                let turned = (b.0 * cos - b.1 * sin, b.0 * sin + b.1 * cos);
                values[first] = (a.0 + turned.0, a.1 + turned.1);
                values[first + half] = (a.0 - turned.0, a.1 - turned.1);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_sum_of_waves() {
        let mut values: Vec<(f32, f32)> = (0..16).map(|at| (at as f32, (at * at % 7) as f32)).collect();
        let sum = |at: usize| {
            let term = |(k, value): (usize, &(f32, f32))| {
                let (sin, cos) = (TAU * (k * at) as f32 / 16.0).sin_cos();
                (value.0 * cos - value.1 * sin, value.0 * sin + value.1 * cos)
            };
            values.iter().enumerate().map(term).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
        };
        let expected: Vec<(f32, f32)> = (0..16).map(sum).collect();
        transform(&mut values);
        for (found, expected) in values.iter().zip(&expected) {
            assert!(
                (found.0 - expected.0).abs() < 1e-3 && (found.1 - expected.1).abs() < 1e-3,
                "{found:?} {expected:?}"
            );
        }
    }

    #[test]
    fn slopes_have_a_mean_of_0_and_a_mean_square_of_1_at_every_level() {
        let levels = waves();
        assert_eq!((levels[0].side, levels.len()), (WAVES_SIDE, 9));
        for level in &levels {
            let mean = |part: usize| {
                level.texels.iter().map(|texel| texel[part].to_f32()).sum::<f32>() / level.texels.len() as f32
            };
            assert!(mean(0).abs() < 2e-3 && mean(1).abs() < 2e-3, "{} {}", mean(0), mean(1));
            assert!((mean(2) + mean(3) - 1.0).abs() < 5e-3, "{}", mean(2) + mean(3));
        }
        // A slope is a derivative: along x the sums of rows are 0, because a row closes on itself.
        let row: f32 = levels[0].texels[..WAVES_SIDE].iter().map(|texel| texel[0].to_f32()).sum();
        assert!(row.abs() < 0.1, "{row}");
        // More of it lies along the wind.
        let squares = |part: usize| levels[0].texels.iter().map(|texel| texel[part].to_f32()).sum::<f32>();
        assert!(squares(2) > 1.5 * squares(3), "{} {}", squares(2), squares(3));
    }
}
