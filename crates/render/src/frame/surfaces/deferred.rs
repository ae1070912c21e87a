//! Deferred shading: surfaces are drawn into the G-buffer, lights read that, and screen-space light is added.
//!
//! Source: Saito & Takahashi 1990, "Comprehensible Rendering of 3-D Shapes".

use super::lighting::light_passes;
use super::{OpaqueSurfaces, Variables, begin_depth, compose_mirrors, mirror_passes, reflection_passes};
use crate::environment::Background;
use crate::gbuffer::{Gbuffer, LightTarget, ViewOutputs};
use crate::passes::forward::LayeredDepth;
use crate::passes::mirrors::MirrorDraw;
use crate::passes::{coverage, emission, forward, geometry, gi, ids, linear_depth, motion, occlusion, reflections};
use crate::record::Recorder;
use crate::screen_space::ScreenSpaceEffects;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use manypass_graph::Handle;

/// All opaque surfaces with their light; no fog.
pub(super) fn opaque_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    mirrors: &[MirrorDraw],
) -> Result<OpaqueSurfaces, ProgramError> {
    let fills_background = settings.background.source == Background::Environment;
    let (outputs, gbuffer) = gbuffer_passes(r, settings, variables, fills_background)?;

    // Lights, and what is known in screen space before they are added.
    let inputs = occlusion_inputs(&gbuffer, &outputs.depth);
    let occlusion = occlusion::record(r, &settings.occlusion, variables.reads_occlusion, inputs)?;
    let occlusion = occlusion.map(|occlusion| gi::without_bounces(&settings.gi, occlusion));
    let cached = reflections::CachedReflections::new(r, &settings.reflections);
    let effects = ScreenSpaceEffects { occlusion: occlusion.as_ref(), reflections: cached.reflections() };
    let (radiance, depth) = light_passes(r, settings, &gbuffer, effects, outputs.depth, outputs.radiance)?;
    let (radiance, depth) = forward::record_layered(r, None, effects, radiance, LayeredDepth::There(depth))?;

    // Screen-space light: what surfaces send each other.
    let mirrored = mirror_passes(r, mirrors, &gbuffer, &depth)?;
    let inputs = reflections::ScreenInputs {
        gbuffer: &gbuffer,
        occlusion: occlusion.as_ref(),
        depth: &depth,
        radiance: None,
        mirrored: None,
    };
    let radiance = compose_mirrors(r, mirrored.as_ref(), inputs, radiance)?;
    let (radiance, gi) = gi::record(r, &settings.gi, &gbuffer, occlusion.is_some(), &depth, radiance)?;
    let radiance = match gi {
        Some(gi) => forward::record_layered_light(r, &gi, &depth, radiance)?,
        None => radiance,
    };
    let inputs = reflections::ScreenInputs { mirrored: mirrored.as_ref().map(|mirrored| &mirrored.texture), ..inputs };
    let radiance = reflection_passes(r, settings, (inputs, cached), radiance)?;

    let occlusion = occlusion.map(|occlusion| occlusion.texture);
    let outputs = ViewOutputs { radiance, depth, gbuffer: Some(gbuffer), occlusion, ..outputs };
    Ok(OpaqueSurfaces { outputs, linear_depth: None, is_fogged: false })
}

/// Surfaces before light reaches them: depth, the G-buffer, and what variables need. `radiance` of the outputs holds
/// emission so far. `fills_background` is as for [`geometry::record`].
pub(super) fn gbuffer_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    fills_background: bool,
) -> Result<(ViewOutputs, Gbuffer), ProgramError> {
    let begun = begin_depth(r)?;
    let geometry = geometry::record(r, begun, fills_background)?;
    let linear_depth = linear_depth::record(r, "linear_depth", &geometry.depth)?;
    let radiance = geometry.radiance.map_or_else(|| coverage::record(r, &geometry.depth), Ok)?;
    let gbuffer =
        Gbuffer { base_color: geometry.base_color, normal: geometry.normal, material: geometry.material, linear_depth };
    let wanted = variables.passes;
    let emission = wanted.emission.then(|| emission::record(r, &radiance)).transpose()?;
    let ids = wanted.ids.then(|| ids::record(r, &geometry.depth)).transpose()?;
    let step = variables.camera_step.as_ref();
    let motion = wanted.motion.then(|| motion::record(r, &geometry.depth, step)).transpose()?;
    let inputs = occlusion_inputs(&gbuffer, &geometry.depth);
    let occlusion_screen =
        wanted.occlusion_screen.then(|| occlusion::record_variable(r, &settings.occlusion, inputs)).transpose()?;
    let outputs = ViewOutputs::new(radiance, geometry.depth);
    Ok((ViewOutputs { emission, ids, motion, occlusion_screen, ..outputs }, gbuffer))
}

/// The numbers of pairs of a light and a pixel of opaque surfaces, in place of light; and depth.
pub(super) fn pair_passes(r: &mut Recorder<'_, '_>, settings: &Settings) -> Result<(Handle, Handle), ProgramError> {
    let (outputs, gbuffer) = gbuffer_passes(r, settings, &Variables::default(), false)?;
    let pairs = LightTarget::new(r).cleared(r.graph);
    let effects = ScreenSpaceEffects::default();
    let (pairs, depth) = light_passes(r, settings, &gbuffer, effects, outputs.depth, pairs)?;
    forward::record_layered(r, None, effects, pairs, LayeredDepth::There(depth))
}

fn occlusion_inputs<'h>(gbuffer: &'h Gbuffer, depth: &'h Handle) -> occlusion::ScreenInputs<'h> {
    occlusion::ScreenInputs { normal: &gbuffer.normal, linear_depth: &gbuffer.linear_depth, depth }
}
