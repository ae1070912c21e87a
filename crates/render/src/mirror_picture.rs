//! What is behind a flat surface that reflects, as the view there left it, and how passes read it.

use glam::{Vec2, Vec3};
use manypass_graph::Handle;

/// What is behind a mirror, as a view left it.
#[derive(Debug)]
pub struct MirrorPicture {
    /// Radiance, with mips if the mirror is rough.
    pub radiance: Handle,
    /// Metres along the view axis.
    pub linear_depth: Handle,
    /// The offset of the sample within its pixels.
    pub jitter_ndc: Vec2,
    /// Half its extent in view space, at a distance of 1 m if the projection is perspective.
    pub view_from_ndc_scale: Vec2,
}

/// The uniform of `behind_mirror.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MirrorUniform {
    normal_view: Vec3,
    /// The mirror's object: the index of its node, plus 1.
    object: u32,
    jitter_ndc: Vec2,
    inverse_size_px: Vec2,
    view_from_ndc_scale: Vec2,
    share_of_ray: f32,
    padding: f32,
}

impl MirrorUniform {
    /// Of a surface of an object, whose plane has a unit normal in view space towards the eye, and each pixel of which has so
    /// many rays.
    pub fn new(object: u32, picture: Option<&MirrorPicture>, normal_view: Vec3, rays: u32) -> Self {
        let size = picture.map_or(Vec2::ONE, |picture| {
            let desc = picture.radiance.desc();
            Vec2::new(desc.width as f32, desc.height as f32)
        });
        Self {
            normal_view,
            object,
            jitter_ndc: picture.map_or(Vec2::ZERO, |picture| picture.jitter_ndc),
            inverse_size_px: size.recip(),
            view_from_ndc_scale: picture.map_or(Vec2::ONE, |picture| picture.view_from_ndc_scale),
            share_of_ray: 1.0 / rays.max(1) as f32,
            padding: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "mirrors",
            "Mirror",
            MirrorUniform,
            [normal_view, object, jitter_ndc, inverse_size_px, view_from_ndc_scale, share_of_ray, padding]
        );
    }
}
