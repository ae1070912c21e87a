//! Arbitrary output variables: what the frame knows of every pixel besides its colour.

use crate::view::ViewUniform;
use glam::{Vec2, Vec3};

/// A variable of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Aov {
    /// Base colour, linear.
    BaseColor,
    /// Occlusion of the material.
    Occlusion,
    /// Unit normal in world space.
    Normal,
    /// Unit normal in view space.
    NormalView,
    /// Position in world space, metres.
    Position,
    /// Distance along the view axis, metres; +∞ where there is no surface.
    Depth,
    /// Metallic.
    Metallic,
    /// Perceptual roughness.
    Roughness,
}

impl Aov {
    /// Every variable.
    pub const ALL: &[Self] = &[
        Self::BaseColor,
        Self::Occlusion,
        Self::Normal,
        Self::NormalView,
        Self::Position,
        Self::Depth,
        Self::Metallic,
        Self::Roughness,
    ];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::BaseColor => "base_color",
            Self::Occlusion => "occlusion",
            Self::Normal => "normal",
            Self::NormalView => "normal_view",
            Self::Position => "position",
            Self::Depth => "depth",
            Self::Metallic => "metallic",
            Self::Roughness => "roughness",
        }
    }
}

/// The values of a variable, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum AovPixels {
    /// Floats, `components` a pixel.
    Float {
        /// Values a pixel.
        components: u32,
        /// All values.
        data: Vec<f32>,
    },
    /// One integer a pixel; 0 where there is no surface.
    Id(Vec<u32>),
}

/// The G-buffer of the first, unjittered frame, in memory.
#[derive(Clone, Debug)]
pub(crate) struct GbufferPixels {
    pub view: ViewUniform,
    pub base_color: Vec<u8>,
    pub normal: Vec<u8>,
    pub material: Vec<u8>,
    pub linear_depth: Vec<u8>,
}

/// The distance that stands for infinity in `linear_depth.wgsl`.
const DISTANCE_BACKGROUND_M: f32 = 1.0e38;

impl GbufferPixels {
    pub fn read(&self, aov: Aov) -> AovPixels {
        let width = self.view.size_px.x as usize;
        let count = width * self.view.size_px.y as usize;
        let (components, value): (u32, Box<dyn Fn(usize) -> Vec3 + '_>) = match aov {
            Aov::BaseColor => {
                (3, Box::new(|i| Vec3::from([0, 1, 2].map(|c| linear_from_srgb(self.base_color[i * 4 + c])))))
            }
            Aov::Occlusion => (1, Box::new(|i| Vec3::splat(unorm(self.base_color[i * 4 + 3])))),
            Aov::Metallic => (1, Box::new(|i| Vec3::splat(unorm(self.material[i * 4])))),
            Aov::Roughness => (1, Box::new(|i| Vec3::splat(unorm(self.material[i * 4 + 1])))),
            Aov::Depth => (1, Box::new(|i| Vec3::splat(self.distance_m(i).unwrap_or(f32::INFINITY)))),
            Aov::Normal => (3, Box::new(|i| self.distance_m(i).map_or(Vec3::ZERO, |_| self.normal_world(i)))),
            Aov::NormalView => (
                3,
                Box::new(|i| {
                    let rotate = |normal| self.view.view_from_world.transform_vector3(normal);
                    self.distance_m(i).map_or(Vec3::ZERO, |_| rotate(self.normal_world(i)))
                }),
            ),
            Aov::Position => (3, Box::new(|i| self.position_world(i, width))),
        };
        let mut data = Vec::with_capacity(count * components as usize);
        for i in 0..count {
            data.extend_from_slice(&value(i).to_array()[..components as usize]);
        }
        AovPixels::Float { components, data }
    }

    fn distance_m(&self, i: usize) -> Option<f32> {
        let bytes = &self.linear_depth[i * 4..i * 4 + 4];
        let distance = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        (distance < DISTANCE_BACKGROUND_M).then_some(distance)
    }

    fn normal_world(&self, i: usize) -> Vec3 {
        let component = |c: usize| {
            let at = i * 4 + c * 2;
            f32::from(u16::from_le_bytes([self.normal[at], self.normal[at + 1]])) / 65535.0 * 2.0 - 1.0
        };
        direction_from_octahedral(Vec2::new(component(0), component(1)))
    }

    fn position_world(&self, i: usize, width: usize) -> Vec3 {
        let Some(distance) = self.distance_m(i) else { return Vec3::ZERO };
        let pixel = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let uv = pixel * self.view.inverse_size_px;
        let ndc = Vec2::new(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0);
        let plane = (ndc - self.view.jitter_ndc) * self.view.view_from_ndc_scale;
        let plane = if self.view.orthographic > 0.5 { plane } else { plane * distance };
        self.view.world_from_view.transform_point3(plane.extend(-distance))
    }
}

/// The twin of `octahedral.wgsl`.
pub(crate) fn direction_from_octahedral(v: Vec2) -> Vec3 {
    let z = 1.0 - v.x.abs() - v.y.abs();
    let wrap = |a: f32, b: f32| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    let xy = if z >= 0.0 { v } else { Vec2::new(wrap(v.x, v.y), wrap(v.y, v.x)) };
    xy.extend(z).normalize()
}

fn unorm(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}

fn linear_from_srgb(byte: u8) -> f32 {
    let s = unorm(byte);
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

/// A tapped target as something to look at: colours as they are, radiance clipped and encoded, depth as near = bright.
#[cfg(not(target_arch = "wasm32"))]
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
    let encode = |linear: f32| {
        let l = linear.clamp(0.0, 1.0);
        ((if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 }) * 255.0).round() as u8
    };
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
        wgpu::TextureFormat::R32Float => gray((0..count).map(|i| float(i * 4)).collect()),
        wgpu::TextureFormat::Depth32Float => gray((0..count).map(|i| 1.0 - float(i * 4)).collect()),
        _ => return None,
    };
    let name = if tap.texture.starts_with(&tap.pass) {
        tap.texture.clone()
    } else {
        format!("{} > {}", tap.pass, tap.texture)
    };
    Some(crate::PassPicture { name, width: tap.width, height: tap.height, rgba8 })
}

#[cfg(not(target_arch = "wasm32"))]
fn f32_from_half(bits: u16) -> f32 {
    let exponent = i32::from(bits >> 10 & 31);
    let mantissa = f32::from(bits & 1023);
    let magnitude = match exponent {
        0 => mantissa * 2f32.powi(-24),
        31 => f32::INFINITY,
        _ => (1.0 + mantissa / 1024.0) * 2f32.powi(exponent - 15),
    };
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}
