//! The whole frame, top to bottom, on one page.

use crate::aov::AovPasses;
use crate::draws::Tile;
use crate::effect::{self, Effect, EffectStage, FrameTextures};
use crate::fisheye::FisheyeLens;
use crate::gbuffer::{Gbuffer, LightTarget, RADIANCE, ViewOutputs};
use crate::ground::GroundMap;
use crate::lights::LightCulling;
use crate::occlusion::Occlusion;
use crate::overlay::draw::OverlayDraw;
use crate::passes::accumulate::Part;
use crate::passes::direct::Lights;
use crate::passes::forward::{LayeredDepth, OpaqueDepth, SeenThrough};
use crate::passes::present::Target;
use crate::passes::upscale::UpscaleMethod;
use crate::passes::{
    accumulate, adaptive, background, behind, coverage, direct, emission, environment, fisheye, fog, forward, geometry,
    gi, gouraud, ground, ids, indirect, linear_depth, meter, motion, nearest, occlusion, overlay, present, reflections,
    resolve, scrub, shadows, taa, tile_depth, tone_map, transparency, upscale, volumes,
};
use crate::record::Recorder;
pub use crate::render_settings::Path;
use crate::resources::environment::{EnvironmentTiles, Unfinished};
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use crate::shadows::FrameShadows;
use crate::transparency::{Blended, Peel, Side, TransparencyMode};
use crate::view::CameraStep;
use manypass_graph::{DepthLoad, Handle, TextureDesc};
use std::sync::Arc;

/// What all views of a frame share: the maps of their shadows.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn shared_passes(r: &mut Recorder<'_, '_>, shadows: &FrameShadows, atlas: Handle) -> Result<(), ProgramError> {
    shadows::record(r, shadows, atlas)
}

/// What surfaces reflect of a picture of the environment, once it is new.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn environment_passes(
    r: &mut Recorder<'_, '_>,
    tiles: &EnvironmentTiles,
    unfinished: &Unfinished,
) -> Result<(), ProgramError> {
    let picture = r.graph.import("environment.picture", unfinished.picture_desc, unfinished.picture.clone());
    let target = r.graph.import("environment", tiles.desc, tiles.view.clone());
    let drawn = environment::record(r, (tiles, unfinished), &picture, target)?;
    r.graph.export(drawn);
    Ok(())
}

/// What the ground gets of light, once that or the scene changed: the map of the plane, in `target`.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn ground_passes(
    r: &mut Recorder<'_, '_>,
    map: &GroundMap,
    tiles: &[Tile],
    target: Handle,
) -> Result<(), ProgramError> {
    let drawn = ground::record_map(r, map, tiles, target)?;
    r.graph.export(drawn);
    Ok(())
}

/// Everything from geometry to radiance, for one camera. Mirrors and probes call it again with other cameras.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn view_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
) -> Result<ViewOutputs, ProgramError> {
    if settings.render.path != Path::Deferred {
        let (begun, before) = before_forward(r, settings, variables)?;
        let (linear_depth, occlusion) = before.unzip();
        let (radiance, depth) = forward_passes(r, settings, begun, occlusion.as_ref())?;
        let radiance = coverage::record_masks(r, &depth, radiance)?;
        let radiance = background::record(r, &settings.background, &depth, radiance)?;
        let radiance = ground::record(r, &depth, radiance)?;
        let radiance = fog::record_background(r, &settings.fog, settings.background.source, &depth, radiance)?;
        let radiance = if settings.fog.scatters() {
            let linear_depth = match linear_depth {
                Some(linear_depth) => linear_depth,
                None => {
                    let of_middles =
                        if r.view.pixel_samples > 1 { Some(forward::record_depth(r, "forward.depth")?) } else { None };
                    linear_depth::record(r, "linear_depth", of_middles.as_ref().unwrap_or(&depth))?
                }
            };
            fog::record_light(r, &settings.fog, &linear_depth, radiance)?
        } else {
            radiance
        };
        let (radiance, depth) = translucent_passes(r, settings, radiance, depth)?;
        let radiance = resolve::record(r, "resolve", radiance);
        let occlusion = occlusion.map(|occlusion| occlusion.texture);
        return Ok(ViewOutputs { radiance, depth, gbuffer: None, emission: None, ids: None, motion: None, occlusion });
    }
    let (outputs, gbuffer) = surface_passes(r, variables)?;
    let occlusion = {
        let seen =
            occlusion::Seen { normal: &gbuffer.normal, linear_depth: &gbuffer.linear_depth, depth: &outputs.depth };
        let occlusion = occlusion::record(r, &settings.occlusion, variables.reads_occlusion, seen)?;
        occlusion.map(|occlusion| gi::without_bounces(&settings.gi, occlusion))
    };
    let hidden = occlusion.as_ref();
    let (radiance, depth) = light_passes(r, settings, &gbuffer, hidden, outputs.depth, outputs.radiance)?;
    let (radiance, depth) = forward::record_layered(r, None, radiance, LayeredDepth::There(depth))?;
    let radiance = gi::record(r, &settings.gi, &gbuffer, hidden.is_some(), &depth, radiance)?;
    let radiance = reflections::record(r, &settings.reflections, &gbuffer, hidden, &depth, radiance)?;
    let radiance = fog::record(r, &settings.fog, &gbuffer.linear_depth, &depth, radiance)?;
    let radiance = background::record(r, &settings.background, &depth, radiance)?;
    let radiance = ground::record(r, &depth, radiance)?;
    let radiance = fog::record_background(r, &settings.fog, settings.background.source, &depth, radiance)?;
    let radiance = fog::record_light(r, &settings.fog, &gbuffer.linear_depth, radiance)?;
    let (radiance, depth) = translucent_passes(r, settings, radiance, depth)?;
    let occlusion = occlusion.map(|occlusion| occlusion.texture);
    Ok(ViewOutputs { radiance, depth, gbuffer: Some(gbuffer), occlusion, ..outputs })
}

/// Where surfaces are shaded where they are drawn, and what they occlude in the picture is needed: their linear depth,
/// and that. First gives the depth that they are shaded with.
fn before_forward(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
) -> Result<(OpaqueDepth, Option<(Handle, Occlusion)>), ProgramError> {
    let (depth, load) = adaptive::begin_depth(r)?;
    let begun = OpaqueDepth { depth, load, is_drawn: false };
    if !occlusion::is_needed(r, &settings.occlusion, variables.reads_occlusion) {
        return Ok((begun, None));
    }
    // Of several samples a pixel the depth of the middle is not that of all.
    let (of_samples, of_middles) = if r.view.pixel_samples > 1 { (Some(begun), None) } else { (None, Some(begun)) };
    let (normal, depth) = geometry::record_normals(r, of_middles.map(|begun| (begun.depth, begun.load)))?;
    let linear_depth = linear_depth::record(r, "linear_depth", &depth)?;
    let seen = occlusion::Seen { normal: &normal, linear_depth: &linear_depth, depth: &depth };
    let occlusion = occlusion::record(r, &settings.occlusion, variables.reads_occlusion, seen)?;
    let drawn = || OpaqueDepth { depth, load: DepthLoad::Keep, is_drawn: true };
    Ok((of_samples.unwrap_or_else(drawn), occlusion.map(|occlusion| (linear_depth, occlusion))))
}

/// Opaque surfaces that are shaded where they are drawn: radiance and depth.
fn forward_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    begun: OpaqueDepth,
    occlusion: Option<&Occlusion>,
) -> Result<(Handle, Handle), ProgramError> {
    match settings.render.path {
        Path::Deferred | Path::Forward => forward::record_opaque(r, &settings.fog, begun, occlusion),
        Path::ForwardBatched => forward::record_batched(r, &settings.fog, begun, occlusion),
        Path::Gouraud => {
            let begun = (begun.depth, begun.load);
            let fog = if r.view.counts_pairs() { None } else { Some(&settings.fog) };
            let (radiance, depth) = gouraud::record_opaque(r, &settings.fog, begun)?;
            forward::record_layered(r, fog, radiance, LayeredDepth::Missing(depth))
        }
    }
}

/// Surfaces that light comes through, before what lies behind them; then those that alpha covers, of which those behind
/// come before if each of their fragments is opaque. Also gives depth.
fn translucent_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    radiance: Handle,
    depth: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    if !r.view.has_transmissive() {
        return blended_passes(r, settings, None, radiance, depth);
    }
    if r.view.counts_pairs() {
        let (pairs, depth) = forward::record_transmissive(r, &settings.fog, None, radiance, depth)?;
        return blended_passes(r, settings, None, pairs, depth);
    }
    let is_split = settings.transparency.mode == TransparencyMode::Stochastic && r.view.has_blended();
    let has_far = settings.transparency.refractive_layers > 1;
    let nearest_m = if is_split || has_far { Some(nearest_transmissive(r)?) } else { None };
    let peel = |side| nearest_m.as_ref().filter(|_| is_split).map(|nearest_m| Peel { side, nearest_m });
    let (radiance, depth) =
        if is_split { blended_passes(r, settings, peel(Side::Behind), radiance, depth)? } else { (radiance, depth) };
    let far = nearest_m.as_ref().filter(|_| has_far);
    let (radiance, depth) = transmissive_passes(r, settings, far, radiance, depth)?;
    blended_passes(r, settings, peel(Side::Before), radiance, depth)
}

/// The distances of the nearest surfaces that light comes through.
fn nearest_transmissive(r: &mut Recorder<'_, '_>) -> Result<Handle, ProgramError> {
    let depth = forward::record_nearest_transmissive(r)?;
    linear_depth::record(r, "transmissive.linear_depth", &depth)
}

/// Surfaces that light comes through, before what lies behind them: that of others, too, if it is given how far away
/// the nearest are. Also gives depth.
fn transmissive_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    nearest_m: Option<&Handle>,
    radiance: Handle,
    depth: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    let (radiance, depth) = if nearest_m.is_some() {
        let (radiance, behind) = behind_passes(r, "behind.far", radiance)?;
        let seen = SeenThrough { behind: &behind, beyond: nearest_m };
        forward::record_transmissive(r, &settings.fog, Some(seen), radiance, depth)?
    } else {
        (radiance, depth)
    };
    let (radiance, behind) = behind_passes(r, "behind", radiance)?;
    let seen = SeenThrough { behind: &behind, beyond: None };
    forward::record_transmissive(r, &settings.fog, Some(seen), radiance, depth)
}

/// The picture so far with mips, after radiance itself.
fn behind_passes(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    radiance: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    let (radiance, mean) = resolve::record_between(r, format!("{name}.resolve"), radiance);
    let behind = behind::record(r, name, mean.as_ref().unwrap_or(&radiance))?;
    Ok((radiance, behind))
}

/// Surfaces that alpha covers, or what `peel` says of them, in the way that the settings name. Also gives depth.
fn blended_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    peel: Option<Peel<'_>>,
    radiance: Handle,
    depth: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    if !r.view.has_blended() {
        return Ok((radiance, depth));
    }
    let blended = Blended::new(r, settings.transparency.mode, radiance, depth);
    let blended = match settings.render.path {
        Path::Gouraud => gouraud::record_blended(r, &settings.fog, blended, peel)?,
        _ => forward::record_blended(r, &settings.fog, blended, peel)?,
    };
    let blended = resolve::record_blended(r, blended);
    transparency::record(r, blended)
}

/// All light that reaches opaque surfaces from the environment, and from lights in the way that the settings name. Also
/// gives depth.
fn light_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    gbuffer: &Gbuffer,
    occlusion: Option<&Occlusion>,
    depth: Handle,
    radiance: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    match settings.lights.culling {
        LightCulling::Clustered | LightCulling::None => {
            Ok((surface_light_passes(r, &Lights::Clusters, gbuffer, occlusion, &depth, radiance)?, depth))
        }
        LightCulling::Tiled => {
            let tile_depth = tile_depth::record(r, &gbuffer.linear_depth)?;
            Ok((surface_light_passes(r, &Lights::Tiles(&tile_depth), gbuffer, occlusion, &depth, radiance)?, depth))
        }
        LightCulling::Volumes | LightCulling::VolumesStencil => {
            let radiance = surface_light_passes(r, &Lights::Global, gbuffer, occlusion, &depth, radiance)?;
            volumes::record(r, gbuffer, depth, radiance)
        }
    }
}

/// Light of the environment and of `lights`: in one pass, which reads the G-buffer once for both, where one of them
/// reaches every pixel.
fn surface_light_passes(
    r: &mut Recorder<'_, '_>,
    lights: &Lights<'_>,
    gbuffer: &Gbuffer,
    occlusion: Option<&Occlusion>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let is_apart = !lights.adds_ambient(r) && !r.view.counts_pairs();
    let radiance = if is_apart { indirect::record(r, gbuffer, occlusion, depth, radiance)? } else { radiance };
    direct::record(r, lights, gbuffer, occlusion, depth, radiance)
}

/// The picture of a fisheye, of those of all sides; it has no G-buffer, and nothing looks at its depth.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn fisheye_passes(
    r: &mut Recorder<'_, '_>,
    lens: &FisheyeLens,
    sample: (u32, u32),
    faces: Vec<fisheye::FaceRadiance>,
) -> Result<ViewOutputs, ProgramError> {
    let radiance = fisheye::record(r, lens, sample, faces)?;
    let depth = r.texture("depth", wgpu::TextureFormat::Depth32Float);
    Ok(ViewOutputs { radiance, depth, gbuffer: None, emission: None, ids: None, motion: None, occlusion: None })
}

/// The numbers of pairs that the same lighting visits, in place of light, of a view that counts them: visited, shaded,
/// in range and passed over, to be added up over all texels. What light is computed for are pixels of opaque surfaces,
/// or where these are lit as they are drawn all of their fragments, or vertices; and those of blended surfaces.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn pair_passes(r: &mut Recorder<'_, '_>, settings: &Settings) -> Result<Handle, ProgramError> {
    let (pairs, depth) = match settings.render.path {
        Path::Deferred => {
            let (ViewOutputs { depth, .. }, gbuffer) = surface_passes(r, &Variables::default())?;
            let pairs = LightTarget::new(r).cleared(r.graph);
            let (pairs, depth) = light_passes(r, settings, &gbuffer, None, depth, pairs)?;
            forward::record_layered(r, None, pairs, LayeredDepth::There(depth))?
        }
        _ => {
            let (begun, _) = before_forward(r, settings, &Variables::default())?;
            forward_passes(r, settings, begun, None)?
        }
    };
    Ok(translucent_passes(r, settings, pairs, depth)?.0)
}

/// The variables of the frame in a view of their own, for pictures that are shaded at another size: all that is known
/// of surfaces before light reaches them.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn variable_passes(r: &mut Recorder<'_, '_>, variables: &Variables) -> Result<ViewOutputs, ProgramError> {
    let (outputs, gbuffer) = surface_passes(r, variables)?;
    Ok(ViewOutputs { gbuffer: Some(gbuffer), ..outputs })
}

/// The G-buffer and the passes that variables need; `radiance` holds emission so far.
fn surface_passes(r: &mut Recorder<'_, '_>, variables: &Variables) -> Result<(ViewOutputs, Gbuffer), ProgramError> {
    let begun = adaptive::begin_depth(r)?;
    let geometry = geometry::record(r, begun)?;
    let linear_depth = linear_depth::record(r, "linear_depth", &geometry.depth)?;
    let radiance = geometry.radiance.map_or_else(|| coverage::record(r, &geometry.depth), Ok)?;
    let gbuffer =
        Gbuffer { base_color: geometry.base_color, normal: geometry.normal, material: geometry.material, linear_depth };
    let wanted = variables.passes;
    let emission = wanted.emission.then(|| emission::record(r, &radiance)).transpose()?;
    let ids = wanted.ids.then(|| ids::record(r, &geometry.depth)).transpose()?;
    let step = variables.camera_step.as_ref();
    let motion = wanted.motion.then(|| motion::record(r, &geometry.depth, step)).transpose()?;
    let depth = geometry.depth;
    Ok((ViewOutputs { radiance, depth, gbuffer: None, emission, ids, motion, occlusion: None }, gbuffer))
}

/// Anti-aliasing by the frames before, where those follow each other.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn temporal_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    frame: Option<&taa::TemporalFrame>,
    outputs: ViewOutputs,
) -> Result<ViewOutputs, ProgramError> {
    // Forward paths are refused with the settings.
    let (Some(frame), Some(gbuffer), Some(motion)) = (frame, &outputs.gbuffer, &outputs.motion) else {
        return Ok(outputs);
    };
    let shown = taa::Shown { radiance: &outputs.radiance, linear_depth: &gbuffer.linear_depth, motion };
    let radiance = taa::record(r, &settings.taa, frame, shown)?;
    Ok(ViewOutputs { radiance, ..outputs })
}

/// What effects may read of a frame, at the size of the picture that it is enlarged to; what none of them reads is culled.
///
/// # Errors
/// A program that does not compile.
pub fn enlarged_passes(
    r: &mut Recorder<'_, '_>,
    output_size: (u32, u32),
    outputs: ViewOutputs,
) -> Result<ViewOutputs, ProgramError> {
    let mut enlarged = |name, texture: &Handle| nearest::record(r, name, texture, output_size);
    let gbuffer = match &outputs.gbuffer {
        Some(gbuffer) => Some(Gbuffer {
            base_color: enlarged("base_color", &gbuffer.base_color)?,
            normal: enlarged("normal", &gbuffer.normal)?,
            material: enlarged("material", &gbuffer.material)?,
            linear_depth: enlarged("linear_depth", &gbuffer.linear_depth)?,
        }),
        None => None,
    };
    let occlusion = outputs.occlusion.as_ref().map(|occlusion| enlarged("occlusion", occlusion)).transpose()?;
    let motion = outputs.motion.as_ref().map(|motion| enlarged("motion", motion)).transpose()?;
    let ids = outputs.ids.as_ref().map(|ids| enlarged("ids", ids)).transpose()?;
    Ok(ViewOutputs { gbuffer, occlusion, motion, ids, ..outputs })
}

/// The effects on radiance, each on that of the one before.
///
/// # Errors
/// As [`Effect::record`].
pub fn effect_passes<'f>(
    r: &mut Recorder<'_, 'f>,
    effects: &'f [Arc<dyn Effect>],
    outputs: ViewOutputs,
) -> Result<ViewOutputs, ProgramError> {
    let ViewOutputs { radiance, gbuffer, occlusion, motion, ids, .. } = outputs;
    let of_frame = FrameTextures {
        gbuffer: gbuffer.as_ref(),
        occlusion: occlusion.as_ref(),
        motion: motion.as_ref(),
        ids: ids.as_ref(),
    };
    let radiance = effect::record(r, effects, EffectStage::Radiance, &of_frame, radiance)?;
    if effects.iter().any(|effect| effect.is_on() && effect.stage() == EffectStage::Radiance) {
        scrub::count(r, "scrub.last.count".into(), &radiance)?;
    }
    Ok(ViewOutputs { radiance, gbuffer, occlusion, motion, ids, ..outputs })
}

/// The exposure of a frame that goes on from those before: its stops, in one texel.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn exposure_passes(
    r: &mut Recorder<'_, '_>,
    adapting: Option<&meter::Adapting>,
    radiance: &Handle,
) -> Result<Option<Handle>, ProgramError> {
    adapting.map(|adapting| meter::record_adapted(r, adapting, radiance)).transpose()
}

/// From the size at which the frame was shaded to that of its picture; none where it has that size, or where the passes that
/// follow read linearly what lies between pixels.
///
/// # Errors
/// A program that does not compile.
pub fn upscale_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    exposure: f32,
    radiance: &Handle,
    output_size: (u32, u32),
) -> Result<Option<Handle>, ProgramError> {
    match settings.upscale.method {
        UpscaleMethod::Bilinear => Ok(None),
        UpscaleMethod::Edges | UpscaleMethod::Temporal => upscale::record(r, exposure, radiance, output_size),
    }
}

/// From radiance to the picture: accumulation over the samples of a still if there are several, the display transform,
/// and the caller's target if there is one.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn output_passes<'f>(
    r: &mut Recorder<'_, 'f>,
    settings: &Settings,
    radiance: &Handle,
    means: Means,
    picture: Picture<'_>,
    effects: &'f [Arc<dyn Effect>],
) -> Result<(), ProgramError> {
    let Picture { display, target, is_shown, sample_index, exposure, adapted, depth, adaptive_step, overlay, settling } =
        picture;
    // Before what comes over it, where that cannot be blended with it.
    let (display, over) = match overlay {
        Some(_) if may_be_transparent(settings) => (r.texture_of("overlay.below", display.desc()), Some(display)),
        _ => (display, None),
    };
    let curve = settings.tone_map.curve;
    let share = |average, part| accumulate::Share { average, part, sample_index, exposure };
    let of_display = share(accumulate::Average::Display(curve), Part::Whole);
    let of_radiance = share(accumulate::Average::Radiance, Part::Whole);
    let background = settings.background.source;
    let is_done = tone_map::Display { background, is_mean: true, ..tone_map::ENCODING };
    let is_linear = tone_map::Display { curve, exposure, ..is_done };
    let mut glow = None;
    let (mean, left) = match means {
        Means::None => (None, tone_map::Display { is_mean: false, ..is_linear }),
        Means::Display(mean) => {
            let mean = accumulate::record_unsettled(r, of_display, radiance, depth, mean)?;
            if let Some(settling) = settling {
                adaptive::record(r, &settings.adaptive, (adaptive_step, sample_index), &mean, settling)?;
            }
            (Some(mean), is_done)
        }
        Means::Radiance(mean) => (Some(accumulate::record(r, "accumulate", of_radiance, radiance, mean)?), is_linear),
        Means::Both([mean, mean_of_radiance]) => {
            // Beside the other it has a name of its own.
            let linear = accumulate::record(r, "accumulate.radiance", of_radiance, radiance, mean_of_radiance)?;
            r.graph.export(linear);
            (Some(accumulate::record(r, "accumulate", of_display, radiance, mean)?), is_done)
        }
        Means::Parts { rest, glow: mean_of_glow, radiance: mean_of_radiance } => {
            if let Some(mean) = mean_of_radiance {
                let of_radiance = share(accumulate::Average::Radiance, Part::Marked);
                let linear = accumulate::record(r, "accumulate.radiance", of_radiance, radiance, mean)?;
                r.graph.export(linear);
            }
            let of_glow = share(accumulate::Average::Display(curve), Part::Glow);
            glow = Some(accumulate::record(r, "accumulate.glow", of_glow, radiance, mean_of_glow)?);
            let of_rest = share(accumulate::Average::Radiance, Part::Rest);
            (Some(accumulate::record(r, "accumulate", of_rest, radiance, rest)?), is_linear)
        }
    };
    let radiance = mean.as_ref().unwrap_or(radiance);
    let shown = tone_map::Shown { radiance, glow: glow.as_ref(), adapted };
    let is_of_display =
        |effect: &&Arc<dyn Effect>| is_shown && effect.is_on() && effect.stage() == EffectStage::Display;
    let tone = &settings.tone_map;
    let display = if effects.iter().any(|effect| is_of_display(&effect)) {
        let linear = r.texture_of("tone_map.linear", TextureDesc { format: RADIANCE, ..display.desc() });
        let left = tone_map::Display { encodes: false, ..left };
        let linear = tone_map::record(r, "tone_map", tone, left, shown, linear)?;
        let linear = effect::record(r, effects, EffectStage::Display, &FrameTextures::default(), linear)?;
        scrub::count(r, "scrub.display.count".into(), &linear)?;
        let shown = tone_map::Shown { radiance: &linear, glow: None, adapted: None };
        tone_map::record(r, "tone_map.encode", tone, tone_map::ENCODING, shown, display)?
    } else {
        tone_map::record(r, "tone_map", tone, left, shown, display)?
    };
    let display = crate::passes::debug::record(r, &settings.debug, display)?;
    let display = overlay_passes(r, overlay, display, over)?;
    for mean in mean.into_iter().chain(glow) {
        r.graph.export(mean);
    }
    if let Some(target) = target {
        present::record(r, &display, target)?;
    }
    // Otherwise the passes that make it are culled.
    if is_shown {
        r.graph.export(display);
    }
    Ok(())
}

/// Whether a picture may let something through.
fn may_be_transparent(settings: &Settings) -> bool {
    settings.background.source.colors().is_none()
}

/// What is drawn over the finished picture: in place, or together with it into the picture `over`.
fn overlay_passes(
    r: &mut Recorder<'_, '_>,
    overlay: Option<&OverlayDraw>,
    display: Handle,
    over: Option<Handle>,
) -> Result<Handle, ProgramError> {
    let Some(overlay) = overlay else { return Ok(display) };
    // That of the view may be of several samples a pixel, and lacks what is settled.
    let depth = if overlay.tests_depth { Some(forward::record_depth(r, "overlay.depth")?) } else { None };
    match over {
        Some(over) => overlay::record_over(r, overlay, depth.as_ref(), &display, over),
        None => overlay::record(r, overlay, depth.as_ref(), display),
    }
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

/// The means over the samples so far, each with the texture for the next one.
#[derive(Debug)]
pub enum Means {
    /// None: there is one sample, and nobody reads its radiance.
    None,
    /// Of display colours.
    Display(accumulate::Mean),
    /// Of radiance.
    Radiance(accumulate::Mean),
    /// Of display colours, then of radiance.
    Both([accumulate::Mean; 2]),
    /// Of parts of every sample, because lights take turns.
    Parts {
        /// Of what glows, display colours.
        glow: accumulate::Mean,
        /// Of all else, radiance.
        rest: accumulate::Mean,
        /// Of both, radiance, if it is to be read.
        radiance: Option<accumulate::Mean>,
    },
}

/// The picture that a view ends in.
#[derive(Debug)]
pub struct Picture<'t> {
    /// Where it goes.
    pub display: Handle,
    /// Where the caller wants it as well.
    pub target: Option<&'t Target>,
    /// Whether it is shown after this frame, or only added to.
    pub is_shown: bool,
    /// How many frames were added before.
    pub sample_index: u32,
    /// From pre-exposed radiance to what the tone curve takes.
    pub exposure: f32,
    /// The stops that come on top, in one texel, if exposure adapts.
    pub adapted: Option<&'t Handle>,
    /// Depth of the view: where it is nearest, tiles are settled, and keep their mean.
    pub depth: &'t Handle,
    /// What is drawn over it.
    pub overlay: Option<&'t OverlayDraw>,
    /// What is done once this frame was added, if its means are of display colours.
    pub adaptive_step: adaptive::Step,
    /// What that is done to.
    pub settling: Option<adaptive::Settling>,
}
