//! The G-buffer: 12 bytes a pixel beside radiance and depth. Packed and unpacked in `gbuffer.wgsl` alone.

use manypass_graph::{Handle, Pass, Read};

/// The format of `base_color`: base colour, occlusion of the material.
pub const BASE_COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// The format of `normal`: world normal, octahedral.
pub const NORMAL: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Uint;
/// The format of `material`: metallic, perceptual roughness, reflectance, shading model.
pub const MATERIAL: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// The format of `radiance`: pre-exposed radiance, coverage.
pub const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// The format of `linear_depth`: metres along the view axis.
pub const LINEAR_DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// What the geometry pass leaves behind, once the linear depth has been made of the depth attachment.
#[derive(Debug)]
pub struct Gbuffer {
    /// Base colour; occlusion of the material.
    pub base_color: Handle,
    /// World normal.
    pub normal: Handle,
    /// Metallic, roughness, reflectance, shading model.
    pub material: Handle,
    /// Metres along the view axis.
    pub linear_depth: Handle,
}

/// The G-buffer as a pass reads it.
#[derive(Clone, Copy, Debug)]
pub struct GbufferReads {
    base_color: Read,
    normal: Read,
    material: Read,
    linear_depth: Read,
}

impl Gbuffer {
    /// Declares that `pass` reads the whole G-buffer.
    pub fn read(&self, pass: &mut Pass<'_, '_>) -> GbufferReads {
        GbufferReads {
            base_color: pass.read(&self.base_color),
            normal: pass.read(&self.normal),
            material: pass.read(&self.material),
            linear_depth: pass.read(&self.linear_depth),
        }
    }
}

impl GbufferReads {
    /// The names of `gbuffer_textures.wgsl` with what they stand for.
    pub fn named(self) -> [(&'static str, Read); 4] {
        [
            ("base_color", self.base_color),
            ("normal", self.normal),
            ("material", self.material),
            ("linear_depth", self.linear_depth),
        ]
    }
}
