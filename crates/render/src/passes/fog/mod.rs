//! fog: distance fog over opaque surfaces, and over the environment behind them where that is asked for. Blended surfaces,
//! and all surfaces of `--path forward`, are in the same fog where they are shaded.
//!
//! Source: Beer-Lambert, see `shaders/fog.wgsl`. Reads: linear_depth. Writes: radiance; coverage stays what it is, so that
//! a transparent background stays transparent.

use crate::environment::Background;
use crate::fog::{FogMode, FogSettings, FogUniform};
use crate::record::{PicturePart, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What is there times alpha, plus what is drawn; coverage stays.
const THROUGH: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::SrcAlpha,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    },
};

/// Records the pass over opaque surfaces.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &FogSettings,
    linear_depth: &Handle,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if settings.mode == FogMode::None {
        return Ok(radiance);
    }
    let uniform = FogUniform::new(settings, r.view.uniform.pre_exposure);
    let step = r.fullscreen("fog", "fog", &[]).uniform("fog", &uniform).read("linear_depth", linear_depth);
    step.over(PicturePart::Surfaces, depth).blend(THROUGH).draw_into(radiance, ColorLoad::Keep)
}

/// Records the pass over the environment where it is seen and shall be hidden. A background without radiance, a colour or
/// nothing, is in no fog.
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
    step.over(PicturePart::Background, depth).blend(THROUGH).draw_into(radiance, ColorLoad::Keep)
}
