//! fog: distance fog over opaque surfaces, and over the environment behind them where that is asked for. Blended
//! surfaces, and all surfaces of `--path forward`, are in the same fog where they are shaded.
//!
//! Source: Beer-Lambert, see `shaders/fog.wgsl`. Reads: linear_depth. Writes: radiance; coverage stays what it is, so
//! that a transparent background stays transparent.

use crate::environment::Background;
use crate::fog::{FogMode, FogSettings, FogUniform};
use crate::gbuffer::RADIANCE;
use crate::pass_info::{PassInfo, Reach};
use crate::record::{ADD, PicturePart, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { off: Some("fog.mode=none"), tiers: &[], ..PassInfo::new("fog") };

/// How far it looks; none if settings switch it off. Light in fog is that of half the pixels, or of what lies before
/// converged tiles, too.
pub fn reach(settings: &FogSettings) -> Option<Reach> {
    let reach = if settings.scatters() { Reach::EverySample } else { Reach::OwnPixel };
    (settings.mode != FogMode::None).then_some(reach)
}

/// Fog over what is there, by the share that does not come through: where there is something, coverage is 1, and
/// stays 1.
const OVER: wgpu::BlendState = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;

/// The noise of so many samples averages out by itself, without losing what is fine.
const UNFILTERED_SAMPLES: u32 = 32;

/// Records the pass over opaque surfaces; none if their distances are not given, because they have their fog.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &FogSettings,
    linear_depth: Option<&Handle>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let Some(linear_depth) = linear_depth.filter(|_| settings.mode != FogMode::None) else { return Ok(radiance) };
    let uniform = FogUniform::new(settings, r.view.uniform.pre_exposure);
    let step = r.fullscreen("fog", "fog", &[]).uniform("fog", &uniform).read("linear_depth", linear_depth);
    step.over(PicturePart::Surfaces, depth).blend(OVER).draw_into(radiance, ColorLoad::Keep)
}

/// Records the pass over the environment where it is seen and shall be hidden. A background without radiance, a colour
/// or nothing, is in no fog.
///
/// # Errors
/// A program that does not compile.
pub fn record_background(
    r: &mut Recorder<'_, '_>,
    settings: &FogSettings,
    background: Background,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if settings.mode == FogMode::None || !settings.background || background != Background::Environment {
        return Ok(radiance);
    }
    let uniform = FogUniform::new(settings, r.view.uniform.pre_exposure);
    let step = r.fullscreen("fog.background", "fog_background", &[]).uniform("fog", &uniform);
    step.over(PicturePart::Background, depth).blend(OVER).draw_into(radiance, ColorLoad::Keep)
}

/// Records the passes that add the light which fog scatters from lights towards the eye, before opaque surfaces and
/// before what lies behind them, if the settings ask for it. Blended surfaces add what lies before them where they are
/// shaded.
///
/// # Errors
/// A program that does not compile.
pub fn record_light(
    r: &mut Recorder<'_, '_>,
    settings: &FogSettings,
    linear_depth: Option<&Handle>,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let has_light = settings.scatters() && r.view.light_count > 0;
    let Some(linear_depth) = linear_depth.filter(|_| has_light) else { return Ok(radiance) };
    let uniform = FogUniform::new(settings, r.view.uniform.pre_exposure);
    let axes = r.view.light_axes();
    if !settings.half {
        let step = r.fullscreen("fog.light", "fog_light", axes).uniform("fog", &uniform);
        return step.read("linear_depth", linear_depth).blend(ADD).draw_into(radiance, ColorLoad::Keep);
    }
    let half = TextureDesc::new_2d(r.view.size.0.div_ceil(2), r.view.size.1.div_ceil(2), RADIANCE);
    let target = r.texture_of("fog.light", half);
    let step = r.fullscreen("fog.light", "fog_light", &[&["halves"], axes].concat()).uniform("fog", &uniform);
    let mut light = step.read("linear_depth", linear_depth).draw_into(target, ColorLoad::Discard)?;
    if r.view.sample_count < UNFILTERED_SAMPLES {
        let target = r.texture_of("fog.filter", half);
        let step = r.fullscreen("fog.filter", "fog_filter", &[]).read("linear_depth", linear_depth);
        light = step.read("half_light", &light).draw_into(target, ColorLoad::Discard)?;
    }
    let step = r.fullscreen("fog.upsample", "fog_upsample", &[]).read("linear_depth", linear_depth);
    step.read("half_light", &light).blend(ADD).draw_into(radiance, ColorLoad::Keep)
}
