//! fisheye: the radiance of a fisheye picture, of that of views with perspective of several sides.
//!
//! Sources: see `fisheye.rs`, which says what is where. Reads: radiance of each side. Writes: radiance (pre-exposed); nothing
//! is outside of the circle that the lens shows. Every pixel is the mean of four rays, of which each looks at four
//! texels, so that it has no more than one and a half of them beside each other.

use crate::camera_settings::Fisheye;
use crate::fisheye::{FisheyeLens, RAYS_A_SIDE, Side};
use crate::gbuffer::RADIANCE;
use crate::pass_info::{PassInfo, Reach};
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use crate::view;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { off: Some("camera.fisheye=none"), tiers: &[], ..PassInfo::new("fisheye") };

/// How far it looks; none if settings switch it off.
pub fn reach(fisheye: Fisheye) -> Option<Reach> {
    (fisheye != Fisheye::None).then_some(Reach::EverySample)
}

/// The uniform of `fisheye.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct FisheyeUniform {
    /// From a place on each side to its texture: by the first two numbers and more by the others.
    uv_from_place: [[f32; 4]; Side::ALL.len()],
    /// The middle of the picture.
    middle_px: [f32; 2],
    /// 1 / the radius of the circle.
    inverse_radius_px: f32,
    /// What a distance from the middle, 1 at the rim, is multiplied by to be θ, sin(θ / 2) or tan(θ / 2).
    slope: f32,
}

/// What is known of one side.
#[derive(Debug)]
pub(crate) struct FaceRadiance {
    /// Which.
    pub side: Side,
    /// As its view left it.
    pub radiance: Handle,
    /// From a place at a distance of 1 to the texture: by the first two numbers and more by the others.
    pub uv_from_place: [f32; 4],
}

/// The names of the sides in the shader.
const TEXTURES: [&str; Side::ALL.len()] = ["front", "right", "left", "up", "down"];

/// Records the pass, of a sample by index and number.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn record(
    r: &mut Recorder<'_, '_>,
    lens: &FisheyeLens,
    (sample_index, sample_count): (u32, u32),
    faces: Vec<FaceRadiance>,
) -> Result<Handle, ProgramError> {
    let target = r.texture("radiance", RADIANCE);
    let (width, height) = (target.desc().width, target.desc().height);
    let half_rad = 0.5 * lens.half_angle_rad;
    let (map, slope) = match lens.map {
        Fisheye::None | Fisheye::Equidistant => (0, lens.half_angle_rad),
        Fisheye::Equisolid => (1, half_rad.sin()),
        Fisheye::Stereographic => (2, half_rad.tan()),
    };
    let jitter = view::jitter_px(sample_index, sample_count);
    let mut uniform = FisheyeUniform {
        uv_from_place: [[0.0; 4]; Side::ALL.len()],
        // The other way than that of the sides, so that no pixel keeps its place between theirs.
        middle_px: [0.5 * width as f32 - jitter.x, 0.5 * height as f32 - jitter.y],
        inverse_radius_px: (1.0 / lens.radius_px) as f32,
        slope: slope as f32,
    };
    // What lies outside is known without a look: the rest is a square, or all.
    let half_px = lens.radius_px.ceil() as u32 + 1;
    let [x, y] = [width, height].map(|side| (side / 2).saturating_sub(half_px));
    let rectangle = [x, y, width - 2 * x, height - 2 * y];
    for face in &faces {
        uniform.uv_from_place[face.side as usize] = face.uv_from_place;
    }
    // Rays of many samples lie in the pixel as evenly.
    let rays = if sample_count >= RAYS_A_SIDE * RAYS_A_SIDE { 1 } else { RAYS_A_SIDE };
    let mut step = r
        .fullscreen("fisheye", "fisheye", &[])
        .constants(&[("fisheye_map", map), ("rays_a_side", rays), ("face_count", faces.len() as u32)])
        .uniform("fisheye", &uniform);
    for (side, name) in Side::ALL.into_iter().zip(TEXTURES) {
        step = match faces.iter().find(|face| face.side == side) {
            Some(face) => step.read(name, &face.radiance),
            None => step.stand_in(name),
        };
    }
    step.within(rectangle).draw_into(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("fisheye", "Fisheye", FisheyeUniform, [uv_from_place, middle_px, inverse_radius_px, slope]);
    }
}
