//! Targets of passes as something to look at.

use super::pixels::f32_from_half;
use crate::colour::srgb_from_linear;
use crate::constants::DISTANCE_BACKGROUND_M;
use crate::octahedral::direction_from_octahedral;
use glam::Vec2;

/// A tapped target as something to look at: colours as they are, radiance clipped and encoded, depth as near = bright.
pub(crate) fn tap_picture(tap: &manypass_graph::TapPixels) -> Option<crate::PassPicture> {
    let count = (tap.width * tap.height) as usize;
    let float = |at: usize| {
        let b = &tap.data[at..at + 4];
        f32::from_le_bytes([b[0], b[1], b[2], b[3]])
    };
    let gray = |values: Vec<f32>| {
        let finite = || values.iter().copied().filter(|value| *value < DISTANCE_BACKGROUND_M);
        let (low, high) = finite().fold((f32::INFINITY, 0.0f32), |(low, high), v| (low.min(v), high.max(v)));
        let shade = |v: f32| ((1.0 - (v - low) / (high - low).max(1e-6)).clamp(0.0, 1.0) * 230.0 + 25.0) as u8;
        values
            .iter()
            .flat_map(|v| {
                let g = if *v < DISTANCE_BACKGROUND_M { shade(*v) } else { 0 };
                [g, g, g, 255]
            })
            .collect::<Vec<u8>>()
    };
    let encode = |linear: f32| (srgb_from_linear(linear.clamp(0.0, 1.0)) * 255.0).round() as u8;
    let rgba8 = match tap.format {
        wgpu::TextureFormat::Rgba8Unorm | wgpu::TextureFormat::Rgba8UnormSrgb => {
            tap.data.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2], 255]).collect()
        }
        wgpu::TextureFormat::Rg16Uint => (0..count)
            .flat_map(|i| {
                let c = |k: usize| {
                    f32::from(u16::from_le_bytes([tap.data[i * 4 + k], tap.data[i * 4 + k + 1]])) / 65535.0 * 2.0 - 1.0
                };
                let n = direction_from_octahedral(Vec2::new(c(0), c(2))) * 127.5 + 127.5;
                [n.x as u8, n.y as u8, n.z as u8, 255]
            })
            .collect(),
        wgpu::TextureFormat::Rgba16Float => tap
            .data
            .chunks_exact(8)
            .flat_map(|p| {
                let c = |k: usize| encode(f32_from_half(u16::from_le_bytes([p[k], p[k + 1]])));
                [c(0), c(2), c(4), 255]
            })
            .collect(),
        wgpu::TextureFormat::Rgba32Float => (0..count)
            .flat_map(|i| [encode(float(i * 16)), encode(float(i * 16 + 4)), encode(float(i * 16 + 8)), 255])
            .collect(),
        // Motion: grey where nothing moves, 32 pixels to either side.
        wgpu::TextureFormat::Rg32Float => (0..count)
            .flat_map(|i| {
                let c = |at: usize| (float(at).clamp(-32.0, 32.0) * (127.5 / 32.0) + 127.5).round() as u8;
                [c(i * 8), c(i * 8 + 4), 128, 255]
            })
            .collect(),
        // Ids: a colour of its own for each node, shaded by the material.
        wgpu::TextureFormat::Rg32Uint => {
            (0..count).flat_map(|i| id_color(float(i * 8).to_bits(), float(i * 8 + 4).to_bits())).collect()
        }
        wgpu::TextureFormat::R32Float => gray((0..count).map(|i| float(i * 4)).collect()),
        wgpu::TextureFormat::Depth32Float => gray((0..count).map(|i| 1.0 - float(i * 4)).collect()),
        _ => return None,
    };
    let name = if tap.texture.starts_with(&tap.pass) {
        tap.texture.clone()
    } else {
        format!("{} > {}", tap.pass, tap.texture)
    };
    Some(crate::PassPicture { name, width: tap.width, height: tap.height, rgba8, legend: Vec::new() })
}

/// Odd factors give 256 neighbouring ids 256 different values.
fn id_color(node: u32, material: u32) -> [u8; 4] {
    if node == 0 {
        return [0, 0, 0, 255];
    }
    [node.wrapping_mul(151) as u8 | 32, node.wrapping_mul(87) as u8 | 32, material.wrapping_mul(59) as u8 | 32, 255]
}
