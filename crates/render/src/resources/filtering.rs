//! How textures of surfaces are filtered in one of the frames of a still.

use crate::gpu::Capabilities;

/// The most samples along the long side of a pixel's footprint that adapters take.
const ANISOTROPY_MAX: f32 = 16.0;

/// The most levels by which mips are finer: those for 16 samples. More samples fill a pixel no more evenly to the eye.
const MIP_GAIN_MAX: f32 = 2.0;

/// How the samplers of textures filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Sampling {
    /// The most samples along the long side of a pixel's footprint; 1 is none but the one.
    pub anisotropy: u16,
    /// Whether texels are blended between two mips where the scene asks for it, not taken from the nearer one.
    pub blends_mips: bool,
}

/// How textures are filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureFiltering {
    /// Of the samplers.
    pub sampling: Sampling,
    /// By how many levels mips are finer than for a single sample.
    pub mip_gain: f32,
}

impl TextureFiltering {
    /// For one of `sample_count` frames that are averaged. Samples of a still lie apart by a pixel's side divided by
    /// √n, so each needs only that much of the pixel's footprint: mips finer by log2(√n), and a √n-th of the
    /// anisotropy. What anisotropy the adapter lacks the samples make up for, see `surface_mip_bias`.
    ///
    pub fn new(sample_count: u32, capabilities: &Capabilities) -> Self {
        let count = sample_count.max(1) as f32;
        let anisotropy = if capabilities.anisotropy { (ANISOTROPY_MAX / count.sqrt()).max(1.0) } else { 1.0 };
        let mip_gain = (0.5 * count.log2()).min(MIP_GAIN_MAX);
        // Where texels are four times as fine as pixels, the average of the samples hides which of two mips they are
        // from; the second one would double the price of a texture. WebGPU wants it for anisotropy.
        let blends_mips = mip_gain < MIP_GAIN_MAX || anisotropy > 1.0;
        Self { sampling: Sampling { anisotropy: anisotropy.round() as u16, blends_mips }, mip_gain }
    }
}
