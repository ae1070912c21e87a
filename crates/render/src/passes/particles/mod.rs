//! particles: many small billboards that a simulation moves; see `particles.wgsl`.
//!
//! Drawn over all that is opaque, after fog, water and portals, and before surfaces that are seen through. Reads: the states
//! of the simulation, linear_depth, the tables of lights. Writes: radiance.

use crate::fog::{FogSettings, FogUniform};
use crate::gbuffer::RADIANCE;
use crate::pass_info::PassInfo;
use crate::record::{ADD, Recorder};
use crate::shader::program::ProgramError;
use crate::transparency::SUM;
use glam::{Vec2, Vec3};
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use manypass_scene::particles::Look;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("particles");

/// How many pairs of particles that shade each other a frame looks at, unless that were fewer than [`OCCLUDERS_MIN`] for
/// each.
const PAIRS_MAX: u32 = 1 << 21;
const OCCLUDERS_MIN: u32 = 64;
const OCCLUDERS_MAX: u32 = 1024;

/// A system of particles that a view shows.
#[derive(Clone, Debug)]
pub struct ParticlesDraw {
    /// Its name.
    pub name: String,
    /// How they look.
    pub look: Look,
    /// The states of what moves them: places and velocities.
    pub states: [wgpu::TextureView; 2],
}

/// The uniform of `uniform.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct ParticlesUniform {
    color: Vec3,
    emission: f32,
    radius_m: Vec2,
    opacity: f32,
    stretch_secs: f32,
    softness_m: f32,
    columns: u32,
    occluders: u32,
    raggedness: f32,
}

impl ParticlesUniform {
    fn new(look: &Look, [columns, rows]: [u32; 2], pre_exposure: f32) -> Self {
        let number = |value: f32, most: f32| if value.is_finite() { value.clamp(0.0, most) } else { 0.0 };
        Self {
            color: look.color.map(|value| number(value, 1e6)),
            emission: number(look.emission, 1e12) * pre_exposure,
            radius_m: Vec2::new(number(look.radius_m.x, 1e4), number(look.radius_m.y, 1e4)),
            opacity: number(look.opacity, 1.0),
            stretch_secs: number(look.stretch_secs, 1e3),
            softness_m: number(look.softness_m, 1e4),
            columns,
            occluders: occluders(look, columns.saturating_mul(rows)),
            raggedness: number(look.raggedness, 1.0),
        }
    }
}

/// How many particles of a system of `cells` shade each of them: all of a small one, and fewer the more pairs there are.
/// What adds light, and streaks, which are thin, shade nothing.
fn occluders(look: &Look, cells: u32) -> u32 {
    if look.opacity > 0.0 && look.stretch_secs <= 0.0 {
        (PAIRS_MAX / cells.max(1)).clamp(OCCLUDERS_MIN, OCCLUDERS_MAX).min(cells)
    } else {
        0
    }
}

/// Draws systems of particles, one after the other.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    all: &[ParticlesDraw],
    fog: &FogSettings,
    linear_depth: &Handle,
    mut radiance: Handle,
) -> Result<Handle, ProgramError> {
    let pre_exposure = r.view.uniform.pre_exposure;
    let fog = FogUniform::new(fog, pre_exposure);
    for ParticlesDraw { name, look, states: [place, velocity] } in all {
        let (columns, rows) = (place.texture().width(), place.texture().height());
        let uniform = ParticlesUniform::new(look, [columns, rows], pre_exposure);
        let desc = TextureDesc::new_2d(columns, rows, RADIANCE);
        let lit = r.texture_of(format!("particles/{name}.light"), desc);
        let step = r.fullscreen(format!("particles/{name}.light"), "particles_light", r.view.light_axes());
        let step = step.uniform("particles", &uniform).uniform("fog", &fog);
        let step = step.table("place", place).table("velocity", velocity);
        let lit = step.draw_into(lit, ColorLoad::Discard)?;
        let (hides, is_cut) = (look.opacity > 0.0, r.view.outline.is_some());
        let sums = hides.then(|| r.texture(format!("particles/{name}.sums"), RADIANCE));
        let step = r.fullscreen(format!("particles/{name}"), "particles", &[]).quads(columns * rows);
        let step = step.constant("is_cut", u32::from(is_cut));
        let step = step.constant("adds", u32::from(!hides)).uniform("particles", &uniform);
        let step = step.table("place", place).table("velocity", velocity);
        let step = step.read("light", &lit).read("linear_depth", linear_depth);
        let Some(sums) = sums else {
            radiance = step.blend(ADD).draw_into(radiance, ColorLoad::Keep)?;
            continue;
        };
        let everything = wgpu::Color { a: 1.0, ..wgpu::Color::TRANSPARENT };
        let sums = step.blend(SUM).draw_into(sums, ColorLoad::Clear(everything))?;
        let step = r.fullscreen(format!("particles/{name}.compose"), "particles_compose", &[]).read("sums", &sums);
        let over = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;
        radiance = step.blend(over).draw_into(radiance, ColorLoad::Keep)?;
    }
    Ok(radiance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "particles",
            "Particles",
            ParticlesUniform,
            [color, emission, radius_m, opacity, stretch_secs, softness_m, columns, occluders, raggedness]
        );
    }

    #[test]
    fn all_of_a_small_system_shade_each_other_and_streaks_nothing() {
        let look = Look::default();
        assert_eq!([0, 1, 500, 10_000, 1 << 20].map(|cells| occluders(&look, cells)), [0, 1, 500, 209, 64]);
        assert_eq!(occluders(&Look { stretch_secs: 0.02, ..look.clone() }, 500), 0);
        assert_eq!(occluders(&Look { opacity: 0.0, ..look }, 500), 0);
    }
}
