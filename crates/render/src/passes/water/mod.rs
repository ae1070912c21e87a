//! water: surfaces of water, with all that is seen in them and through them; see `water.wgsl`.
//!
//! A quad of the world, drawn over the picture after opaque surfaces and the background, before fog and what is blended.
//! Reads: the picture so far, linear_depth, radiance and linear_depth of the view behind the surface. Writes: radiance,
//! depth.

use crate::ground::ViewGround;
use crate::mirror_picture::{MirrorPicture, MirrorUniform};
use crate::pass_info::PassInfo;
use crate::record::{ADD, Recorder};
use crate::shader::program::ProgramError;
use crate::waves::WAVES_ACROSS;
use glam::{Vec2, Vec3, Vec4};
use manypass_graph::{ColorLoad, Handle};
use manypass_scene::capture::{OUTLINE_CORNERS_MAX, Panel};
use manypass_scene::simulation::Place;
use manypass_scene::water::Water;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("water");

/// Rays of a pixel of moving water, in each sample of a still of several, and in a picture of few.
const RAYS: u32 = 2;
const RAYS_OF_FEW_SAMPLES: u32 = 8;

/// Cox & Munk 1954: the mean square of slopes for every metre a second of wind.
const SLOPES_OF_WIND: f32 = 0.005_12;

/// The wind at which a normal map is as steep as its texels say.
const WIND_OF_MAPS_M_S: f32 = 5.0;

/// How far the two copies of the map turn from the wind to either side, in radians; and how much smaller the second is.
const TURN_RAD: f32 = 0.35;
const SECOND_SHARE: f32 = 0.618;

/// Where waves of so many metres and of a steepness gather light: their length, divided by the product of both.
const FOCUS: f32 = 9.0;

/// Over which share of the longest waves slopes are compared for that.
const STEP_SHARE: f32 = 0.03;

/// Where the waves of a simulation gather light at most, in metres, because how sharp they are is not known before.
const FOCUS_OF_SIMULATIONS_M: f32 = 1.0;

/// The acceleration of gravity in m/s², which sets how fast waves go.
const GRAVITY: f32 = 9.81;

/// After so many seconds waves begin anew.
const PERIOD_SECS: f64 = 86_400.0;

/// A surface of water that a view shows.
#[derive(Debug)]
pub struct WaterDraw {
    /// What it is made of.
    pub water: Water,
    /// Its plane.
    pub panel: Panel,
    /// Its outline in world space, at most [`OUTLINE_CORNERS_MAX`] corners.
    pub corners_world: Vec<Vec3>,
    /// The time by which its waves go.
    pub time_secs: f32,
    /// Whether the eye is below its surface.
    pub is_from_below: bool,
    /// Whether it is below the outline, too, and so in the water.
    pub holds_eye: bool,
    /// Its normal map, if it has one.
    pub normal_map: Option<wgpu::TextureView>,
    /// The waves that a simulation has made, if one does, and the rectangle that they lie over.
    pub simulated: Option<(wgpu::TextureView, Place)>,
    /// What is behind it, if there is a view of that.
    pub picture: Option<MirrorPicture>,
}

/// The uniform of `uniform.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct WaterUniform {
    corners: [Vec4; OUTLINE_CORNERS_MAX],
    normal: Vec4,
    x_world: Vec4,
    y_world: Vec4,
    copies: [Vec4; 2],
    absorption_per_m: Vec3,
    ior: f32,
    scattering_per_m: Vec3,
    steepness: f32,
    foam_depth_m: f32,
    caustics: f32,
    from_below: f32,
    focus_m: f32,
    time_secs: f32,
    step_m: f32,
    ground_m: f32,
    padding_b: f32,
}

impl WaterUniform {
    fn new(shown: &WaterDraw, ground_m: Option<f32>) -> Self {
        let WaterDraw { water, panel, corners_world, time_secs, is_from_below, .. } = shown;
        let normal = panel.normal_world;
        // From above, x goes to the right and y up, as on a map.
        let x_world = (Vec3::X - normal * normal.x).try_normalize().unwrap_or(Vec3::Z);
        let y_world = normal.cross(x_world);
        let number = |value: f32, least: f32, most: f32, other: f32| {
            if value.is_finite() { value.clamp(least, most) } else { other }
        };
        let wave_m = number(water.wave_m, 1e-3, 1e4, 1.0);
        let wind_rad = number(water.wind_rad, -1e4, 1e4, 0.0);
        // In 64 bits, and from one day to the next, so that waves stay as smooth as they are.
        let secs = f64::from(number(*time_secs, -1e30, 1e30, 0.0)) % PERIOD_SECS;
        let copy = |share: f32, turn_rad: f32| {
            let longest_m = wave_m * share;
            let side_m = WAVES_ACROSS * longest_m;
            let speed = (GRAVITY * longest_m / std::f32::consts::TAU).sqrt();
            let moved = (secs * f64::from(speed / side_m)).fract() as f32;
            let turned = Vec2::from_angle(wind_rad + turn_rad) / side_m;
            turned.extend(-moved).extend(0.0)
        };
        let wind_m_s = number(water.wind_m_s, 0.0, 100.0, 0.0);
        // What is at rest has no time.
        let secs = if wind_m_s > 0.0 { secs } else { 0.0 };
        let steepness = match water.normal_map {
            // Each of the two has half of it.
            None => (0.5 * SLOPES_OF_WIND * wind_m_s).sqrt(),
            Some(_) => (0.5 * wind_m_s / WIND_OF_MAPS_M_S).sqrt(),
        };
        let color = |color: Vec3| color.map(|value| number(value, 0.0, 1e6, 0.0));
        let (mut copies, mut focus_m, mut step_m) = (
            [copy(1.0, TURN_RAD), copy(SECOND_SHARE, -TURN_RAD)],
            wave_m / (FOCUS * steepness).max(1e-3),
            STEP_SHARE * wave_m,
        );
        if let Some((map, place)) = &shown.simulated {
            let axis = |axis: Vec4, side_m: f32| {
                let axis = Vec2::new(axis.truncate().dot(x_world), axis.truncate().dot(y_world)) / side_m.max(1e-6);
                let middle = place.world_from_place.w_axis.truncate();
                let begin = 0.5 - axis.dot(Vec2::new(middle.dot(x_world), middle.dot(y_world)));
                axis.extend(begin).extend(0.0)
            };
            let matrix = &place.world_from_place;
            copies = [axis(matrix.x_axis, place.size_m.x), axis(matrix.y_axis, place.size_m.y)];
            focus_m = FOCUS_OF_SIMULATIONS_M;
            step_m = place.size_m.x / map.texture().width().max(1) as f32;
        }
        Self {
            corners: std::array::from_fn(|at| corners_world.get(at).copied().unwrap_or_default().extend(1.0)),
            normal: normal.extend(normal.dot(panel.center_world)),
            x_world: x_world.extend(0.0),
            y_world: y_world.extend(0.0),
            copies,
            absorption_per_m: color(water.absorption_per_m),
            ior: number(water.ior, 1.0001, 4.0, manypass_scene::water::WATER_IOR),
            scattering_per_m: color(water.scattering_per_m),
            steepness,
            foam_depth_m: number(water.foam_depth_m, 0.0, 1e3, 0.0),
            caustics: number(water.caustics, 0.0, 1.0, 0.0),
            from_below: f32::from(u8::from(*is_from_below)),
            // Waves bend light by their curvature, the root of whose mean square is about that.
            focus_m,
            time_secs: (secs % 3600.0) as f32,
            step_m,
            ground_m: ground_m.unwrap_or(0.0),
            padding_b: 0.0,
        }
    }
}

/// What is drawn multiplies what is there.
const MULTIPLY: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::Src,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    },
};

/// Draws what water that the eye is in takes of light, and what it scatters; `before` and `after` are linear depth without
/// its surface and with it.
///
/// # Errors
/// A program that does not compile.
pub fn record_within(
    r: &mut Recorder<'_, '_>,
    water: &WaterDraw,
    (before, after): (&Handle, &Handle),
    mut radiance: Handle,
) -> Result<Handle, ProgramError> {
    let uniform = WaterUniform::new(water, None);
    for (adds, blend) in [(0, MULTIPLY), (1, ADD)] {
        let step = r.fullscreen("water.within", "water_within", r.view.light_axes()).constant("adds", adds);
        let step = step.uniform("water", &uniform).read("linear_depth", before).read("surface_depth", after);
        radiance = step.blend(blend).draw_into(radiance, ColorLoad::Keep)?;
    }
    Ok(radiance)
}

/// Draws surfaces of water over radiance. Returns that and depth; `below` is the picture so far with mips, and
/// `linear_depth` that of what it shows.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    all: &[WaterDraw],
    (below, linear_depth): (&Handle, &Handle),
    (mut radiance, mut depth): (Handle, Handle),
) -> Result<(Handle, Handle), ProgramError> {
    let few = r.view.shows_few_samples();
    let built_in = r.frame.tables.waves(r.frame.gpu).clone();
    let ground_m = r.view.ground.as_ref().map(ViewGround::height_m);
    for shown in all {
        let WaterDraw { water, corners_world, is_from_below, normal_map, simulated, picture, .. } = shown;
        let (uniform, has_waves) = (WaterUniform::new(shown, ground_m), water.has_waves());
        let rays = match (has_waves, few) {
            (false, _) => 0,
            (true, true) => RAYS_OF_FEW_SAMPLES,
            (true, false) => RAYS,
        };
        let normal = if *is_from_below { -uniform.normal } else { uniform.normal };
        let normal_view = r.view.uniform.view_from_world.transform_vector3(normal.truncate());
        let mirror = MirrorUniform::new(0, picture.as_ref(), normal_view, rays);
        let triangles = corners_world.len().min(OUTLINE_CORNERS_MAX).saturating_sub(2);
        let step = r.fullscreen("water", "water", r.view.light_axes()).triangles(triangles as u32);
        let step = step.constant("rays", rays).constant("splits_specular", 1);
        let step = step.constant("has_mirror", u32::from(picture.is_some()));
        let step = step.constant("has_normal_map", u32::from(normal_map.is_some()));
        let step = step.constant("has_simulation", u32::from(simulated.is_some()));
        let step = step.constant("has_ground", u32::from(ground_m.is_some()));
        let step = step.constant("has_caustics", u32::from(has_waves && uniform.caustics > 0.0));
        let step = step.uniform("water", &uniform).uniform("mirror", &mirror);
        let simulated = simulated.as_ref().map(|(waves, _)| waves);
        let step = step.table("waves", simulated.or(normal_map.as_ref()).unwrap_or(&built_in));
        let step = step.read("linear_depth", linear_depth).read("below", below);
        let step = match picture {
            None => step.stand_in("behind_radiance").stand_in("behind_distances"),
            Some(picture) => {
                step.read("behind_radiance", &picture.radiance).read("behind_distances", &picture.linear_depth)
            }
        };
        (radiance, depth) = step.draw_nearer_into(radiance, ColorLoad::Keep, depth)?;
    }
    Ok((radiance, depth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "water",
            "Water",
            WaterUniform,
            [
                corners,
                normal,
                x_world,
                y_world,
                copies,
                absorption_per_m,
                ior,
                scattering_per_m,
                steepness,
                foam_depth_m,
                caustics,
                from_below,
                focus_m,
                time_secs,
                step_m,
                ground_m,
                padding_b
            ]
        );
    }
}
