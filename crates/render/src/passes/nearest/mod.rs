//! nearest: a texture of the frame at another size, each texel as it is, for effects on a picture that is larger than its
//! frames.
//!
//! Reads: the texture, of floats or, as normals are, of whole numbers. Writes: a texture of the same format, of the texel
//! nearest to each pixel's middle where this frame's jitter put that. What nothing reads is not drawn.

use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("nearest");

/// The uniform of `places.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct NearestUniform {
    /// Texels for each texel of what is written.
    texels_per_px: [f32; 2],
    /// Zero.
    padding: [f32; 2],
}

/// Records the pass under the name `nearest.NAME`.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    texture: &Handle,
    (width, height): (u32, u32),
) -> Result<Handle, ProgramError> {
    let from = texture.desc();
    let texels_per_px = [from.width as f32 / width as f32, from.height as f32 / height as f32];
    let is_whole = from.format.sample_type(None, None) == Some(wgpu::TextureSampleType::Uint);
    let (program, read) = if is_whole { ("nearest_whole", "whole") } else { ("nearest", "texture") };
    let name = format!("nearest.{name}");
    let target = r.texture_of(name.clone(), TextureDesc::new_2d(width, height, from.format));
    r.declare_texels_of(&target, texture);
    let step = r.fullscreen(name, program, &[]).read(read, texture);
    let step = step.uniform("nearest", &NearestUniform { texels_per_px, padding: [0.0; 2] });
    step.draw_into(target, ColorLoad::Discard)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("nearest", "Nearest", NearestUniform, [texels_per_px, padding]);
        assert_same_layout!("nearest_whole", "Nearest", NearestUniform, [texels_per_px, padding]);
    }
}
