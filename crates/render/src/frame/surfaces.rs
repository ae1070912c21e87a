//! Opaque surfaces with their light: the part of the frame in which the paths differ. Each path has a file.

mod deferred;
mod forward;
mod lighting;

use super::SceneLayers;
use crate::aov::AovPasses;
use crate::gbuffer::{Gbuffer, ViewOutputs};
use crate::passes::forward::record_layered_reflections;
use crate::passes::mirrors::MirrorDraw;
use crate::passes::{adaptive, ids, mirrors, reflections};
use crate::record::Recorder;
use crate::render_settings::Path;
use crate::screen_space::{Reflections, ScreenSpaceEffects};
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use crate::view::CameraStep;
use manypass_graph::{DepthLoad, Handle};

/// What the opaque surfaces of a view leave, whatever the path.
#[derive(Debug)]
pub(super) struct OpaqueSurfaces {
    /// Their radiance and depth, and what variables and effects read of them.
    pub outputs: ViewOutputs,
    /// Their linear depth, if there is no G-buffer that has it and it is known.
    pub linear_depth: Option<Handle>,
    /// Whether they were fogged where they were drawn. Then linear depth may be unknown.
    pub is_fogged: bool,
}

/// What a view records for variables alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Variables {
    /// Which passes.
    pub passes: AovPasses,
    /// From where to where the camera moved, if there is a previous frame.
    pub camera_step: Option<CameraStep>,
    /// Whether occlusion is found for an effect, too.
    pub reads_occlusion: bool,
}

impl Variables {
    /// What one of the two wants.
    pub fn and(mut self, other: &Self) -> Self {
        self.passes.motion |= other.passes.motion;
        self.passes.ids |= other.passes.ids;
        self.reads_occlusion |= other.reads_occlusion;
        self
    }
}

/// All opaque surfaces of a view with their light, before anything lies behind or before them.
pub(super) fn opaque_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    layers: &SceneLayers,
) -> Result<OpaqueSurfaces, ProgramError> {
    match settings.render.path {
        Path::Deferred => deferred::opaque_passes(r, settings, variables, &layers.mirrors),
        Path::Forward | Path::ForwardBatched | Path::Gouraud => forward::opaque_passes(r, settings, variables, layers),
    }
}

/// The numbers of pairs of a light and what is shaded of opaque surfaces, in place of light; and depth.
pub(super) fn pair_passes(r: &mut Recorder<'_, '_>, settings: &Settings) -> Result<(Handle, Handle), ProgramError> {
    match settings.render.path {
        Path::Deferred => deferred::pair_passes(r, settings),
        Path::Forward | Path::ForwardBatched | Path::Gouraud => forward::pair_passes(r, settings),
    }
}

/// The variables of the frame in a view of their own, for pictures that are shaded at another size: all that is known
/// of surfaces before light reaches them.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn variable_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
) -> Result<ViewOutputs, ProgramError> {
    let (outputs, gbuffer) = deferred::gbuffer_passes(r, settings, variables, false)?;
    Ok(ViewOutputs { gbuffer: Some(gbuffer), ..outputs })
}

/// The depth that a view begins with. Where nothing is to be drawn, in converged tiles and outside of a mirror's
/// outline, it is nearest of all.
fn begin_depth(r: &mut Recorder<'_, '_>) -> Result<(Handle, DepthLoad), ProgramError> {
    match r.view.outline {
        Some(outline) => mirrors::begin_depth(r, &outline),
        None => adaptive::begin_depth(r),
    }
}

/// What the mirrors of a view reflect; `depth` has one sample a pixel.
fn mirror_passes(
    r: &mut Recorder<'_, '_>,
    mirrors: &[MirrorDraw],
    gbuffer: &Gbuffer,
    depth: &Handle,
) -> Result<Option<Reflections>, ProgramError> {
    if mirrors.is_empty() || r.view.counts_pairs() {
        return Ok(None);
    }
    let objects: Vec<u32> = mirrors.iter().map(|mirror| mirror.object).collect();
    let ids = ids::record_of(r, "mirrors.ids", &objects, depth)?;
    let texture = mirrors::record(r, mirrors, gbuffer, &ids)?;
    Ok(Some(Reflections { texture, side_px: 1, roughness_max: 1.0 }))
}

/// Puts what mirrors reflect in the place of the environment's specular light.
fn compose_mirrors(
    r: &mut Recorder<'_, '_>,
    mirrored: Option<&Reflections>,
    inputs: reflections::ScreenInputs<'_>,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    match mirrored {
        Some(mirrored) => reflections::record_composed(r, "mirrors.compose", inputs, (mirrored, None), radiance),
        None => Ok(radiance),
    }
}

/// Screen-space reflections of surfaces, then of those that are shaded where they are drawn, over their radiance.
fn reflection_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    (inputs, cached): (reflections::ScreenInputs<'_>, reflections::CachedReflections),
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let (radiance, reflections) = reflections::record(r, &settings.reflections, (inputs, cached), radiance)?;
    let Some(reflections) = reflections else { return Ok(radiance) };
    let effects = ScreenSpaceEffects { occlusion: inputs.occlusion, reflections: Some(&reflections) };
    record_layered_reflections(r, effects, inputs.depth, radiance)
}
