//! Targets of passes as something to look at.

use super::PassPicture;
use super::pixels::f32_from_half;
use crate::colour::srgb_from_linear;
use crate::constants::DISTANCE_BACKGROUND_M;
use crate::octahedral::direction_from_octahedral;
use crate::record::Texels;
use glam::Vec2;
use manypass_graph::TapPixels;
use wgpu::TextureFormat as F;

/// Motion that is shown as black or white, in pixels.
const MOTION_MAX_PX: f32 = 32.0;

/// A tapped target as something to look at, by what its pass says that it holds, or else by its format; none where it
/// has a format that does not hold that.
pub(crate) fn tap_picture(tap: &TapPixels, texels: Option<Texels>) -> Option<PassPicture> {
    let rgba8 = match texels.or_else(|| Texels::of_format(tap.format))? {
        Texels::Color => colors(tap)?,
        Texels::Share => grey(first_channel(tap)?.into_iter().map(byte)),
        Texels::Number => grey(numbers(&first_channel(tap)?)),
        Texels::Distance => grey(distances(&first_channel(tap)?)),
        Texels::Depth => {
            let from_near: Vec<f32> = first_channel(tap)?.iter().map(|depth| 1.0 - depth).collect();
            grey(distances(&from_near))
        }
        Texels::Direction if tap.format == F::Rg16Uint => directions(tap),
        Texels::Motion if tap.format == F::Rg32Float => motion(tap),
        Texels::Ids if tap.format == F::Rg32Uint => ids(tap),
        Texels::Direction | Texels::Motion | Texels::Ids => return None,
    };
    let name = if tap.texture.starts_with(&tap.pass) {
        tap.texture.clone()
    } else {
        format!("{} > {}", tap.pass, tap.texture)
    };
    Some(PassPicture { name, width: tap.width, height: tap.height, rgba8, legend: Vec::new() })
}

/// The byte of a share from 0 to 1; 0 of what is no number.
fn byte(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u8
}

fn grey(values: impl IntoIterator<Item = u8>) -> Vec<u8> {
    values.into_iter().flat_map(|value| [value, value, value, 255]).collect()
}

fn float(bytes: &[u8]) -> f32 {
    bytes.first_chunk().map_or(0.0, |bytes| f32::from_le_bytes(*bytes))
}

fn half(bytes: &[u8]) -> f32 {
    bytes.first_chunk().map_or(0.0, |bytes| f32_from_half(u16::from_le_bytes(*bytes)))
}

fn unit(bytes: &[u8]) -> f32 {
    bytes.first().map_or(0.0, |byte| f32::from(*byte) / 255.0)
}

/// The first channel of every texel; none of formats that hold no such numbers.
fn first_channel(tap: &TapPixels) -> Option<Vec<f32>> {
    let (texel_bytes, value): (usize, fn(&[u8]) -> f32) = match tap.format {
        F::R8Unorm => (1, unit),
        F::Rgba8Unorm => (4, unit),
        F::R16Float => (2, half),
        F::Rg16Float => (4, half),
        F::Rgba16Float => (8, half),
        F::R32Float | F::Depth32Float => (4, float),
        F::Rg32Float => (8, float),
        F::Rgba32Float => (16, float),
        _ => return None,
    };
    Some(tap.data.chunks_exact(texel_bytes).map(value).collect())
}

/// From the least to the greatest.
fn numbers(values: &[f32]) -> Vec<u8> {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    values.iter().map(|value| byte((value - low) / (high - low).max(1e-6))).collect()
}

/// What is near is bright.
fn distances(values: &[f32]) -> Vec<u8> {
    let finite = values.iter().copied().filter(|value| *value < DISTANCE_BACKGROUND_M);
    let (low, high) = finite.fold((f32::INFINITY, 0.0f32), |(low, high), v| (low.min(v), high.max(v)));
    let shade = |v: f32| ((1.0 - (v - low) / (high - low).max(1e-6)).clamp(0.0, 1.0) * 230.0 + 25.0) as u8;
    values.iter().map(|value| if *value < DISTANCE_BACKGROUND_M { shade(*value) } else { 0 }).collect()
}

/// Colours as they are; radiance clipped and encoded.
fn colors(tap: &TapPixels) -> Option<Vec<u8>> {
    let encoded = |linear: f32| byte(srgb_from_linear(linear.clamp(0.0, 1.0)));
    Some(match tap.format {
        F::Rgba8Unorm | F::Rgba8UnormSrgb => {
            tap.data.chunks_exact(4).flat_map(|texel| [texel[0], texel[1], texel[2], 255]).collect()
        }
        F::Rgba16Float => {
            let color = |texel: &[u8]| [0, 2, 4].map(|at| encoded(half(&texel[at..])));
            tap.data.chunks_exact(8).map(color).flat_map(|[r, g, b]| [r, g, b, 255]).collect()
        }
        F::Rgba32Float => {
            let color = |texel: &[u8]| [0, 4, 8].map(|at| encoded(float(&texel[at..])));
            tap.data.chunks_exact(16).map(color).flat_map(|[r, g, b]| [r, g, b, 255]).collect()
        }
        _ => return None,
    })
}

fn directions(tap: &TapPixels) -> Vec<u8> {
    let direction = |texel: &[u8]| {
        let axis = |at: usize| f32::from(u16::from_le_bytes([texel[at], texel[at + 1]])) / 65535.0 * 2.0 - 1.0;
        let n = direction_from_octahedral(Vec2::new(axis(0), axis(2))) * 127.5 + 127.5;
        [n.x as u8, n.y as u8, n.z as u8, 255]
    };
    tap.data.chunks_exact(4).flat_map(direction).collect()
}

fn motion(tap: &TapPixels) -> Vec<u8> {
    let shade =
        |pixels: f32| (pixels.clamp(-MOTION_MAX_PX, MOTION_MAX_PX) * (127.5 / MOTION_MAX_PX) + 127.5).round() as u8;
    tap.data.chunks_exact(8).flat_map(|texel| [shade(float(texel)), shade(float(&texel[4..])), 128, 255]).collect()
}

fn ids(tap: &TapPixels) -> Vec<u8> {
    let color = |texel: &[u8]| id_color(float(texel).to_bits(), float(&texel[4..]).to_bits());
    tap.data.chunks_exact(8).flat_map(color).collect()
}

/// Odd factors give 256 neighbouring ids 256 different values.
fn id_color(node: u32, material: u32) -> [u8; 4] {
    if node == 0 {
        return [0, 0, 0, 255];
    }
    [node.wrapping_mul(151) as u8 | 32, node.wrapping_mul(87) as u8 | 32, material.wrapping_mul(59) as u8 | 32, 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tap(format: F, data: Vec<u8>) -> TapPixels {
        TapPixels { pass: "a".into(), texture: "a".into(), width: 2, height: 1, format, data }
    }

    /// The red bytes of the picture.
    fn shown(format: F, data: Vec<u8>, texels: Option<Texels>) -> Option<Vec<u8>> {
        Some(tap_picture(&tap(format, data), texels)?.rgba8.chunks_exact(4).map(|texel| texel[0]).collect())
    }

    #[test]
    fn what_is_packed_is_shown_by_what_its_pass_says() {
        // A share, beside a distance.
        let packed: Vec<u8> = [0.25f32, 7.0, 1.0, 3.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        assert_eq!(shown(F::Rg32Float, packed.clone(), Some(Texels::Share)), Some(vec![64, 255]));
        assert_eq!(shown(F::Rg32Float, packed.clone(), Some(Texels::Number)), Some(vec![0, 255]));
        assert_eq!(shown(F::Rg32Float, packed.clone(), Some(Texels::Distance)), Some(vec![255, 25]));
        // Without a word it is motion, as the format says; and it cannot be ids.
        assert_eq!(shown(F::Rg32Float, packed.clone(), None), Some(vec![128, 131]));
        assert_eq!(shown(F::Rg32Float, packed, Some(Texels::Ids)), None);
        let halves = vec![0x00, 0x38, 0x00, 0x3c];
        assert_eq!(shown(F::R16Float, halves, None), Some(vec![128, 255]));
        assert_eq!(shown(F::R8Unorm, vec![9, 200], None), Some(vec![9, 200]));
        let no_number: Vec<u8> = [f32::NAN, 2.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        assert_eq!(shown(F::R32Float, no_number, Some(Texels::Share)), Some(vec![0, 255]));
    }
}
