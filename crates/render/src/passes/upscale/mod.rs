//! upscale: from the size at which a frame is shaded to that of its picture, along the edges that it shows.
//!
//! Source: Lottes 2021, "FidelityFX Super Resolution 1.0", edge-adaptive spatial upsampling: a windowed kernel like
//! Lanczos's over twelve texels, turned along the local gradient, longer along an edge and narrower across it, and kept
//! within what the four nearest texels show. Differences: colours are filtered in linear light, compressed as for
//! temporal anti-aliasing, and edges are looked for in their square roots; a plane is taken out of the colours before,
//! so that what rises evenly stays as it is, which Lanczos's kernel alone does not keep; coverage is a fourth colour.
//!
//! Reads: radiance. Writes: radiance of the picture's size (rgba16float), pre-exposed, with coverage.

mod settings;

pub use settings::{UpscaleMethod, UpscaleSettings};

use crate::gbuffer::RADIANCE;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { off: Some("upscale.method=bilinear"), tiers: &[], ..PassInfo::new("upscale") };

/// The uniform of `upscale.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct UpscaleUniform {
    /// Texels of radiance for each pixel of the picture.
    texels_per_px: [f32; 2],
    /// From pre-exposed radiance to what the tone curve takes.
    exposure: f32,
    /// Zero.
    padding: f32,
}

/// Records the pass; none where radiance is not smaller than the picture.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    exposure: f32,
    radiance: &Handle,
    (width, height): (u32, u32),
) -> Result<Option<Handle>, ProgramError> {
    let from = radiance.desc();
    let is_smaller = from.width <= width && from.height <= height && (from.width, from.height) != (width, height);
    if !is_smaller {
        return Ok(None);
    }
    let texels_per_px = [from.width as f32 / width as f32, from.height as f32 / height as f32];
    let uniform = UpscaleUniform { texels_per_px, exposure, padding: 0.0 };
    let target = r.texture_of("upscale", TextureDesc::new_2d(width, height, RADIANCE));
    let step = r.fullscreen("upscale", "upscale", &[]).uniform("upscale", &uniform).read("radiance", radiance);
    step.draw_into(target, ColorLoad::Discard).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("upscale", "Upscale", UpscaleUniform, [texels_per_px, exposure, padding]);
    }
}
