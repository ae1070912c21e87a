//! probe_capture: what is to be seen around a probe becomes its light and the distances that it knows.
//!
//! Source: spherical harmonics of order 2 (Ramamoorthi & Hanrahan 2001) or an ambient cube (McTaggart 2004), and the moments of
//! distances of Majercik et al. 2019, "Dynamic Diffuse Global Illumination with Ray-Traced Irradiance Fields". Where it
//! differs: what is to be seen is drawn, not traced. Reads: radiance and linear depth of six views. Writes: texels of
//! `probes.wgsl`.

use crate::constants::{PROBE_FACE_SIDE, PROBE_HEIGHT, PROBE_WIDTH};
use crate::environment::ENVIRONMENT_FORMAT;
use crate::environment::lobe::FACES;
use crate::pass_info::PassInfo;
use crate::probes::TILE_SIDE;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use manypass_scene::environment::suns::SUNS_MAX;
use std::f32::consts::PI;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("probe_capture");

/// The coefficients of light.
const COEFFICIENTS: u32 = 9;

/// The texels of what is found of a probe's light: eight coefficients or six colours, and what else is known before them.
const FOUND_TEXELS: u32 = 9;

/// `CubeSides` of `cube_sides.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SidesUniform {
    /// To the right.
    right: [Vec4; 6],
    /// Down.
    down: [Vec4; 6],
    /// From the middle of the cube to that of the side.
    forward: [Vec4; 6],
}

impl SidesUniform {
    fn new() -> Self {
        let axis = |at: usize| FACES.map(|face| face[at].extend(0.0));
        Self { right: axis(0), down: axis(1), forward: axis(2) }
    }
}

/// The uniform of `face.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeFace {
    /// The first texel of the side; one divided by half its length in texels; the largest distance that counts.
    corner: Vec4,
}

/// The uniform of `sums.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeSums {
    /// What makes the sum over all texels an integral over all directions; zeros.
    scale: Vec4,
    /// The axes of the sides.
    sides: SidesUniform,
}

impl ProbeSums {
    fn new() -> Self {
        let place = |at: u32| (2 * at + 1) as f32 / PROBE_FACE_SIDE as f32 - 1.0;
        let weight = |x: u32, y: u32| (1.0 + place(x).powi(2) + place(y).powi(2)).powf(-1.5);
        let of_row = |y: u32| (0..PROBE_FACE_SIDE).map(|x| weight(x, y)).sum::<f32>();
        let of_side: f32 = (0..PROBE_FACE_SIDE).map(of_row).sum();
        Self { scale: Vec4::X * (4.0 * PI / (6.0 * of_side)), sides: SidesUniform::new() }
    }
}

/// The uniform of `light.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeCapture {
    /// How far the probe was moved; what radiance is multiplied by.
    place: Vec4,
    /// 1 if light is six colours; zeros.
    basis: Vec4,
    /// The axes of the sides.
    sides: SidesUniform,
    /// Suns of the environment.
    sun_directions: [Vec4; SUNS_MAX],
    sun_irradiances: [Vec4; SUNS_MAX],
}

/// The uniform of `texels.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeTexels {
    /// The first texel; 1 if light is six colours; zero.
    corner: Vec4,
}

/// The uniform of `distances.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeDistances {
    /// The first texel of its map; the largest distance that counts; zero.
    corner: Vec4,
    /// The axes of the sides.
    sides: SidesUniform,
}

/// Where what is found of a probe belongs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CapturedProbe {
    /// How far it was moved, in metres.
    pub offset_m: Vec3,
    /// What radiance of its views is multiplied by.
    pub scale: f32,
    /// Whether its light is six colours.
    pub is_cube: bool,
    /// The first texels of its light and of its distances.
    pub light: [u32; 2],
    pub distances: [u32; 2],
    /// Surfaces that are farther count as if they were so far, in metres.
    pub distance_max_m: f32,
    /// Where suns of the environment are, with their spread, and their irradiance as the views have it.
    pub sun_directions: [Vec4; SUNS_MAX],
    pub sun_irradiances: [Vec4; SUNS_MAX],
}

/// One side of what is to be seen around a probe.
#[derive(Debug)]
pub(crate) struct ProbeSide {
    pub radiance: Handle,
    pub linear_depth: Handle,
}

/// Records the passes that find the texels of a probe in `target` from its six sides.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn record(
    r: &mut Recorder<'_, '_>,
    probe: &CapturedProbe,
    sides: &[ProbeSide],
    target: Handle,
) -> Result<Handle, ProgramError> {
    let side = PROBE_FACE_SIDE;
    let mut all = r.texture_of("probe.sides", TextureDesc::new_2d(6 * side, side, ENVIRONMENT_FORMAT));
    for (face, ProbeSide { radiance, linear_depth }) in (0..6).zip(sides) {
        let corner = Vec4::new((face * side) as f32, 0.0, 2.0 / side as f32, probe.distance_max_m);
        let step = r.fullscreen("probe_capture.face", "probe_face", &[]).read("view_radiance", radiance);
        let step = step.read("linear_depth", linear_depth).uniform("probe_face", &ProbeFace { corner });
        let load = if face == 0 { ColorLoad::Discard } else { ColorLoad::Keep };
        all = step.within([face * side, 0, side, side]).draw_into(all, load)?;
    }
    let columns = r.texture_of("probe.columns", TextureDesc::new_2d(6 * side, COEFFICIENTS, ENVIRONMENT_FORMAT));
    let step = r.fullscreen("probe_capture.sums", "probe_sums", &[]).read("probe_sides", &all);
    let columns = step.uniform("probe_sums", &ProbeSums::new()).draw_into(columns, ColorLoad::Discard)?;
    let is_cube = if probe.is_cube { 1.0 } else { 0.0 };
    let uniform = ProbeCapture {
        place: probe.offset_m.extend(probe.scale),
        basis: Vec4::X * is_cube,
        sides: SidesUniform::new(),
        sun_directions: probe.sun_directions,
        sun_irradiances: probe.sun_irradiances,
    };
    let found = r.texture_of("probe.light", TextureDesc::new_2d(FOUND_TEXELS, 1, ENVIRONMENT_FORMAT));
    let step = r.fullscreen("probe_capture.light", "probe_light", &[]).read("probe_sides", &all);
    let step = step.read("probe_columns", &columns).uniform("probe_capture", &uniform);
    let found = step.draw_into(found, ColorLoad::Discard)?;
    let [x, y] = probe.light;
    let corner = Vec4::new(x as f32, y as f32, is_cube, 0.0);
    let step = r.fullscreen("probe_capture.texels", "probe_texels", &[]).read("probe_found", &found);
    let step = step.uniform("probe_texels", &ProbeTexels { corner }).within([x, y, PROBE_WIDTH, PROBE_HEIGHT]);
    let target = step.draw_into(target, ColorLoad::Keep)?;
    let [x, y] = probe.distances;
    let corner = Vec4::new(x as f32, y as f32, probe.distance_max_m, 0.0);
    let step = r.fullscreen("probe_capture.distances", "probe_distances", &[]).read("probe_sides", &all);
    let step = step.uniform("probe_distances", &ProbeDistances { corner, sides: SidesUniform::new() });
    step.within([x, y, TILE_SIDE, TILE_SIDE]).draw_into(target, ColorLoad::Keep)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniforms_have_one_layout() {
        assert_same_layout!("probe_light", "CubeSides", SidesUniform, [right, down, forward]);
        assert_same_layout!("probe_sums", "ProbeSums", ProbeSums, [scale, sides]);
        assert_same_layout!("probe_face", "ProbeFace", ProbeFace, [corner]);
        assert_same_layout!(
            "probe_light",
            "ProbeCapture",
            ProbeCapture,
            [place, basis, sides, sun_directions, sun_irradiances]
        );
        assert_same_layout!("probe_texels", "ProbeTexels", ProbeTexels, [corner]);
        assert_same_layout!("probe_distances", "ProbeDistances", ProbeDistances, [corner, sides]);
    }
}
