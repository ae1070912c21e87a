//! Forward shading: surfaces are shaded where they are drawn, by pixel (`forward`, `forward-batched`) or by vertex
//! (`gouraud`). What screen-space effects need of surfaces is drawn before, and only then.
//!
//! Source: Olsson et al. 2012 (clustered forward); see `passes/forward` and `passes/gouraud`.

use super::{OpaqueSurfaces, Variables, begin_depth, compose_mirrors, mirror_passes, reflection_passes};
use crate::fog::{FogMode, FogSettings};
use crate::frame::SceneLayers;
use crate::gbuffer::{Gbuffer, ViewOutputs};
use crate::occlusion::Occlusion;
use crate::passes::forward::{LayeredDepth, OpaqueDepth};
use crate::passes::mirrors::MirrorDraw;
use crate::passes::{coverage, forward, geometry, gouraud, linear_depth, occlusion, reflections, resolve};
use crate::record::Recorder;
use crate::render_settings::Path;
use crate::screen_space::{Reflections, ScreenSpaceEffects};
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use manypass_graph::{DepthLoad, Handle};

/// All opaque surfaces with their light, and with fog if nothing comes between them and their fog.
pub(super) fn opaque_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    layers: &SceneLayers,
) -> Result<OpaqueSurfaces, ProgramError> {
    let (begun, prepass) = prepass(r, settings, variables, &layers.mirrors)?;
    let SurfacePrepass { occlusion, gbuffer, linear_depth, mirrored } = prepass;
    // Reflections and water come between surfaces and their fog, which then has a pass of its own.
    let is_fogged = gbuffer.is_none() && layers.water.is_empty();
    let no_fog = FogSettings { mode: FogMode::None, ..FogSettings::default() };
    let fog = if is_fogged { &settings.fog } else { &no_fog };
    let (radiance, depth) = shading_passes(r, settings, fog, begun, occlusion.as_ref())?;
    let radiance = match &gbuffer {
        None => radiance,
        Some(gbuffer) => {
            let known = (occlusion.as_ref(), mirrored.as_ref());
            screen_light_passes(r, settings, gbuffer, known, (radiance, &depth))?
        }
    };
    let radiance = coverage::record_masks(r, &depth, radiance)?;
    let linear_depth = gbuffer.map(|gbuffer| gbuffer.linear_depth).or(linear_depth);
    let occlusion = occlusion.map(|occlusion| occlusion.texture);
    let outputs = ViewOutputs { occlusion, ..ViewOutputs::new(radiance, depth) };
    Ok(OpaqueSurfaces { outputs, linear_depth, is_fogged })
}

/// The numbers of pairs of a light and a fragment or vertex of opaque surfaces, in place of light; and depth.
pub(super) fn pair_passes(r: &mut Recorder<'_, '_>, settings: &Settings) -> Result<(Handle, Handle), ProgramError> {
    let (begun, _) = prepass(r, settings, &Variables::default(), &[])?;
    shading_passes(r, settings, &settings.fog, begun, None)
}

/// What is known of surfaces before they are shaded.
#[derive(Debug, Default)]
struct SurfacePrepass {
    /// What they hide of the environment from each other, if that is needed.
    occlusion: Option<Occlusion>,
    /// The G-buffer, if surfaces reflect each other in screen space or in mirrors.
    gbuffer: Option<Gbuffer>,
    /// Their linear depth, if it is there and not part of the G-buffer.
    linear_depth: Option<Handle>,
    /// What mirrors among them reflect.
    mirrored: Option<Reflections>,
}

/// Draws surfaces for the screen-space effects that are needed. Also gives the depth that surfaces are shaded with.
fn prepass(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    mirrors: &[MirrorDraw],
) -> Result<(OpaqueDepth, SurfacePrepass), ProgramError> {
    let (depth, load) = begin_depth(r)?;
    let begun = OpaqueDepth { depth, load, is_drawn: false };
    let has_mirrors = !mirrors.is_empty() && !r.view.counts_pairs();
    let reflects = has_mirrors || reflections::is_needed(r, &settings.reflections);
    if !(reflects || occlusion::is_needed(r, &settings.occlusion, variables.reads_occlusion)) {
        return Ok((begun, SurfacePrepass::default()));
    }
    // With several samples a pixel the depth of the pixel's middle is a texture of its own.
    let (of_samples, of_middles) = if r.view.pixel_samples > 1 { (Some(begun), None) } else { (None, Some(begun)) };
    let begun = of_middles.map(|begun| (begun.depth, begun.load));
    let geometry::Prepass { base_color, normal, material, depth } = geometry::record_prepass(r, begun, reflects)?;
    let linear_depth = linear_depth::record(r, "linear_depth", &depth)?;
    let inputs = occlusion::ScreenInputs { normal: &normal, linear_depth: &linear_depth, depth: &depth };
    let occlusion = occlusion::record(r, &settings.occlusion, variables.reads_occlusion, inputs)?;
    let prepass = match material {
        Some(material) => {
            let gbuffer = Gbuffer { base_color, normal, material, linear_depth };
            let mirrored = mirror_passes(r, mirrors, &gbuffer, &depth)?;
            SurfacePrepass { occlusion, gbuffer: Some(gbuffer), linear_depth: None, mirrored }
        }
        None => SurfacePrepass { occlusion, gbuffer: None, linear_depth: Some(linear_depth), mirrored: None },
    };
    let drawn = OpaqueDepth { depth, load: DepthLoad::Keep, is_drawn: true };
    Ok((of_samples.unwrap_or(drawn), prepass))
}

/// Shades surfaces where they are drawn: radiance and depth.
fn shading_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    fog: &FogSettings,
    begun: OpaqueDepth,
    occlusion: Option<&Occlusion>,
) -> Result<(Handle, Handle), ProgramError> {
    match settings.render.path {
        Path::Deferred | Path::Forward => forward::record_opaque(r, fog, begun, occlusion),
        Path::ForwardBatched => forward::record_batched(r, fog, begun, occlusion),
        Path::Gouraud => {
            let begun = (begun.depth, begun.load);
            let (radiance, depth) = gouraud::record_opaque(r, fog, begun)?;
            let fog = if r.view.counts_pairs() { None } else { Some(fog) };
            forward::record_layered(r, fog, ScreenSpaceEffects::default(), radiance, LayeredDepth::Missing(depth))
        }
    }
}

/// What surfaces reflect in mirrors and in screen space, over their radiance.
fn screen_light_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    gbuffer: &Gbuffer,
    (occlusion, mirrored): (Option<&Occlusion>, Option<&Reflections>),
    (radiance, depth): (Handle, &Handle),
) -> Result<Handle, ProgramError> {
    let inputs = reflections::ScreenInputs { gbuffer, occlusion, depth, radiance: None, mirrored: None };
    let radiance = compose_mirrors(r, mirrored, inputs, radiance)?;
    // Rays look at one sample a pixel.
    let (radiance, mean) = resolve::record_between(r, "reflections.resolve", radiance);
    let mirrored = mirrored.map(|mirrored| &mirrored.texture);
    let inputs = reflections::ScreenInputs { radiance: mean.as_ref(), mirrored, ..inputs };
    let cached = reflections::CachedReflections::new(r, &settings.reflections);
    reflection_passes(r, settings, (inputs, cached), radiance)
}
