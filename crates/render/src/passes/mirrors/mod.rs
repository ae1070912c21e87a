//! mirrors: what flat mirrors reflect, off the picture and behind the eye, too.
//!
//! Source: planar reflections; see `mirrors.wgsl`. The view behind a mirror, whose eye is the eye mirrored in its plane, is
//! drawn before: a pixel of the mirror shows what that has at the same place, or of a rough mirror the mean of what rays
//! meet there. `mirrors.compose` puts it in the place of the environment's specular light, as it does with reflections in the
//! picture. Which pixels show a mirror is told by ids, which its surface alone draws again. Reads: depth, G-buffer, and of
//! each view behind a mirror radiance and linear_depth. Writes: what is reflected, and a share of 1 where it is.

use crate::gbuffer::{Gbuffer, RADIANCE};
use crate::mirror_picture::{MirrorPicture, MirrorUniform};
use crate::outline::Outline;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use glam::Vec3;
use manypass_graph::{ColorLoad, DepthLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("mirrors");

/// Rays of a pixel of a rough mirror, in each sample of a still of several, and in a picture of few.
const RAYS: u32 = 8;
const RAYS_OF_FEW_SAMPLES: u32 = 16;

/// The rays of so many samples together stand for all that a pixel reflects, of stills of so many times as many: what each
/// brings of the picture overlaps, so that no noise is left where later samples leave out what is settled.
const SAMPLES_OF_LOBE: u32 = 8;
const SAMPLES_A_SHARE: u32 = 8;

/// A mirror that a view shows.
#[derive(Debug)]
pub struct MirrorDraw {
    /// Its object: the index of its node, plus 1.
    pub object: u32,
    /// The unit normal of its plane in world space, towards the eye.
    pub normal_world: Vec3,
    /// Whether each pixel shows one direction, because the material is smooth and has no normal map.
    pub is_smooth: bool,
    /// The part of the picture that it lies in: x and y of the corner, width and height in pixels.
    pub rectangle: [u32; 4],
    /// What is behind it.
    pub picture: MirrorPicture,
}

/// Draws what the mirrors of a view reflect; `ids` tells their objects where they are seen.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    mirrors: &[MirrorDraw],
    gbuffer: &Gbuffer,
    ids: &Handle,
) -> Result<Handle, ProgramError> {
    let mut target = r.texture("mirrors", RADIANCE);
    let mut load = ColorLoad::Clear(wgpu::Color::TRANSPARENT);
    let few = r.view.shows_few_samples();
    let rays_of_rough = if few { RAYS_OF_FEW_SAMPLES } else { RAYS };
    let samples = if few { 1 } else { (r.view.sample_count / SAMPLES_A_SHARE).clamp(1, SAMPLES_OF_LOBE) };
    for MirrorDraw { object, normal_world, is_smooth, rectangle, picture } in mirrors {
        let rays = if *is_smooth { 0 } else { rays_of_rough };
        let normal_view = r.view.uniform.view_from_world.transform_vector3(*normal_world);
        let uniform = MirrorUniform::new(*object, Some(picture), normal_view, rays.max(1) * samples);
        let step = gbuffer.read_by(r.fullscreen("mirrors", "mirrors", &[])).constant("rays", rays);
        let step = step.uniform("mirror", &uniform).read("ids", ids).read("behind_radiance", &picture.radiance);
        let step = step.read("behind_distances", &picture.linear_depth).within(*rectangle);
        target = step.draw_into(target, load)?;
        load = ColorLoad::Keep;
    }
    Ok(target)
}

/// The depth that a view behind a mirror begins with, whose `outline` is that of the mirror: the far plane, and outside of
/// it the near one, where the stencil says that nothing is to be drawn.
///
/// # Errors
/// A program that does not compile.
pub fn begin_depth(r: &mut Recorder<'_, '_>, outline: &Outline) -> Result<(Handle, DepthLoad), ProgramError> {
    let depth = r.texture("geometry.depth", r.frame.gpu.capabilities.depth_format);
    let step = r.fullscreen("mirrors.outline", "mirrors_outline", &[]).uniform("outline", outline).leave_out_settled();
    Ok((step.draw_unsettled_into(depth)?, DepthLoad::Keep))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_outline_has_one_layout() {
        assert_same_layout!("mirrors_outline", "Outline", Outline, [edges]);
    }
}
