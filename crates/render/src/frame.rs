//! The whole frame, top to bottom: from surfaces to radiance here, from there to the picture in `frame/picture.rs`.

mod glass;
mod lighting;
mod monitors;
mod picture;
mod shared;
mod surfaces;

use glass::Translucent;
use lighting::light_passes;
pub use monitors::{Monitored, darken_monitor, monitor_passes};
pub(crate) use picture::fisheye_passes;
pub use picture::{
    Means, Picture, Tint, effect_passes, enlarged_passes, exposure_passes, output_passes, temporal_passes,
    upscale_passes,
};
pub use shared::shared_passes;
pub(crate) use shared::{environment_passes, ground_passes, probe_light_passes, surroundings_passes};
pub use surfaces::{Variables, variable_passes};
use surfaces::{begin_depth, surface_passes};

use crate::environment::Background;
use crate::fog::{FogMode, FogSettings};
use crate::gbuffer::{Gbuffer, LightTarget, ViewOutputs};
use crate::mirror_picture::MirrorPicture;
use crate::occlusion::Occlusion;
use crate::passes::debug::DebugView;
use crate::passes::forward::{LayeredDepth, OpaqueDepth};
use crate::passes::mirrors::ShownMirror;
use crate::passes::particles::ShownParticles;
use crate::passes::portals::ShownPortal;
use crate::passes::water::ShownWater;
use crate::passes::{
    background, coverage, fog, forward, geometry, gi, gouraud, ground, ids, linear_depth, mips, mirrors, occlusion,
    particles, portals, probes, reflections, resolve, transmittance, transparency, water,
};
use crate::record::Recorder;
pub use crate::render_settings::Path;
use crate::screen_space::{InPicture, Reflections};
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use crate::transparency::{Blended, Peel, Side, TransparencyMode};
use manypass_graph::{DepthLoad, Handle};

/// What a view shows beside its surfaces: flat ones, whose own views came before, and particles.
#[derive(Debug, Default)]
pub struct Flat {
    /// Mirrors.
    pub mirrors: Vec<ShownMirror>,
    /// Water, the farthest first.
    pub water: Vec<ShownWater>,
    /// Ends of portals.
    pub portals: Vec<ShownPortal>,
    /// Particles, which are no surfaces, and are drawn with them.
    pub particles: Vec<ShownParticles>,
}

/// Everything from geometry to radiance, for one camera.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn view_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    flat: &Flat,
) -> Result<ViewOutputs, ProgramError> {
    if settings.render.path != Path::Deferred {
        return forward_view_passes(r, settings, variables, flat);
    }
    let fills_background = settings.background.source == Background::Environment;
    let (outputs, gbuffer) = surface_passes(r, settings, variables, fills_background)?;
    let occlusion = {
        let seen =
            occlusion::Seen { normal: &gbuffer.normal, linear_depth: &gbuffer.linear_depth, depth: &outputs.depth };
        let occlusion = occlusion::record(r, &settings.occlusion, variables.reads_occlusion, seen)?;
        occlusion.map(|occlusion| gi::without_bounces(&settings.gi, occlusion))
    };
    let hidden = occlusion.as_ref();
    let kept = reflections::Kept::new(r, &settings.reflections);
    let found = InPicture { occlusion: hidden, reflections: kept.found() };
    let (radiance, depth) = light_passes(r, settings, &gbuffer, found, outputs.depth, outputs.radiance)?;
    let (radiance, depth) = forward::record_layered(r, None, found, radiance, LayeredDepth::There(depth))?;
    let mirrored = mirrored_passes(r, &flat.mirrors, &gbuffer, &depth)?;
    let seen =
        reflections::Seen { gbuffer: &gbuffer, occlusion: hidden, depth: &depth, radiance: None, mirrored: None };
    let radiance = compose_mirrors(r, mirrored.as_ref(), seen, radiance)?;
    let (radiance, found) = gi::record(r, &settings.gi, &gbuffer, hidden.is_some(), &depth, radiance)?;
    let radiance = match found {
        Some(found) => forward::record_layered_light(r, &found, &depth, radiance)?,
        None => radiance,
    };
    let mirrored = mirrored.as_ref().map(|mirrored| &mirrored.texture);
    let seen = reflections::Seen { mirrored, ..seen };
    let radiance = reflection_passes(r, settings, (seen, kept), radiance)?;
    let radiance = background::record(r, &settings.background, &depth, radiance)?;
    let radiance = ground::record(r, &depth, radiance)?;
    let Watered { radiance, depth, linear_depth } =
        water_passes(r, &flat.water, &gbuffer.linear_depth, (radiance, depth))?;
    let linear_depth = linear_depth.as_ref().unwrap_or(&gbuffer.linear_depth);
    let radiance = fog::record(r, &settings.fog, linear_depth, &depth, radiance)?;
    let radiance = fog::record_background(r, &settings.fog, settings.background.source, &depth, radiance)?;
    let radiance = fog::record_light(r, &settings.fog, linear_depth, radiance)?;
    let (radiance, depth) = portals::record(r, &flat.portals, (radiance, depth))?;
    let (radiance, depth) = probe_passes(r, settings, (radiance, depth))?;
    let radiance = particle_passes(r, settings, flat, (linear_depth, &depth), radiance)?;
    let Translucent { radiance, depth, transmittance } = translucent_passes(r, settings, radiance, depth)?;
    let tint = tint_passes(r, transmittance, &radiance)?;
    let occlusion = occlusion.map(|occlusion| occlusion.texture);
    Ok(ViewOutputs { radiance, depth, gbuffer: Some(gbuffer), occlusion, tint, ..outputs })
}

/// As [`view_passes`], of surfaces that are shaded where they are drawn.
fn forward_view_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    flat: &Flat,
) -> Result<ViewOutputs, ProgramError> {
    let (begun, before) = before_forward(r, settings, variables, &flat.mirrors)?;
    let Before { occlusion, reflects, linear_depth, mirrored } = before;
    let of_middles = |r: &mut Recorder<'_, '_>, depth: &Handle| {
        let of_middles = if r.view.pixel_samples > 1 { Some(forward::record_depth(r, "forward.depth")?) } else { None };
        linear_depth::record(r, "linear_depth", of_middles.as_ref().unwrap_or(depth))
    };
    // Where something comes between surfaces and their fog, that has a pass of its own.
    let no_fog = FogSettings { mode: FogMode::None, ..FogSettings::default() };
    let is_fogged_later = reflects.is_some() || !flat.water.is_empty();
    let own_fog = if is_fogged_later { &no_fog } else { &settings.fog };
    let (radiance, depth) = forward_passes(r, settings, own_fog, begun, occlusion.as_ref())?;
    let radiance = match &reflects {
        None => radiance,
        Some(gbuffer) => {
            let found = (occlusion.as_ref(), mirrored.as_ref());
            reflected_passes(r, settings, gbuffer, found, (radiance, &depth))?
        }
    };
    let linear_depth = reflects.map(|gbuffer| gbuffer.linear_depth).or(linear_depth);
    let radiance = coverage::record_masks(r, &depth, radiance)?;
    let radiance = background::record(r, &settings.background, &depth, radiance)?;
    let radiance = ground::record(r, &depth, radiance)?;
    let needs_distances = !flat.water.is_empty() || !flat.particles.is_empty() || settings.fog.scatters();
    let linear_depth = match linear_depth {
        None if needs_distances => Some(of_middles(r, &depth)?),
        linear_depth => linear_depth,
    };
    let (radiance, depth, linear_depth) = match linear_depth {
        None => (radiance, depth, None),
        Some(linear_depth) => {
            let watered = water_passes(r, &flat.water, &linear_depth, (radiance, depth))?;
            (watered.radiance, watered.depth, watered.linear_depth.or(Some(linear_depth)))
        }
    };
    let radiance = match linear_depth.as_ref().filter(|_| is_fogged_later) {
        Some(linear_depth) => fog::record(r, &settings.fog, linear_depth, &depth, radiance)?,
        None => radiance,
    };
    let radiance = fog::record_background(r, &settings.fog, settings.background.source, &depth, radiance)?;
    let radiance = match linear_depth.as_ref().filter(|_| settings.fog.scatters()) {
        Some(linear_depth) => fog::record_light(r, &settings.fog, linear_depth, radiance)?,
        None => radiance,
    };
    let (radiance, depth) = portals::record(r, &flat.portals, (radiance, depth))?;
    let (radiance, depth) = probe_passes(r, settings, (radiance, depth))?;
    let radiance = match &linear_depth {
        Some(linear_depth) => particle_passes(r, settings, flat, (linear_depth, &depth), radiance)?,
        None => radiance,
    };
    let Translucent { radiance, depth, transmittance } = translucent_passes(r, settings, radiance, depth)?;
    let radiance = resolve::record(r, "resolve", radiance);
    let tint = tint_passes(r, transmittance, &radiance)?;
    let occlusion = occlusion.map(|occlusion| occlusion.texture);
    Ok(ViewOutputs {
        radiance,
        depth,
        gbuffer: None,
        emission: None,
        ids: None,
        motion: None,
        occlusion,
        occlusion_screen: None,
        tint,
    })
}

/// Spheres for probes, where settings ask for them.
fn probe_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    (radiance, depth): (Handle, Handle),
) -> Result<(Handle, Handle), ProgramError> {
    match settings.debug.view {
        DebugView::Probes => probes::record(r, (radiance, depth)),
        _ => Ok((radiance, depth)),
    }
}

/// Particles over all that is opaque; `linear_depth` is that of it without portals.
fn particle_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    flat: &Flat,
    (linear_depth, depth): (&Handle, &Handle),
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if flat.particles.is_empty() || r.view.counts_pairs() {
        return Ok(radiance);
    }
    let with_portals = match depth.desc().samples {
        1 if !flat.portals.is_empty() => Some(linear_depth::record(r, "particles.linear_depth", depth)?),
        _ => None,
    };
    particles::record(r, &flat.particles, &settings.fog, with_portals.as_ref().unwrap_or(linear_depth), radiance)
}

/// What water leaves.
struct Watered {
    radiance: Handle,
    depth: Handle,
    /// Distances of water and of what is before it, if any is there and a pixel has one sample.
    linear_depth: Option<Handle>,
}

/// Surfaces of water over all that is opaque and what lies behind that.
fn water_passes(
    r: &mut Recorder<'_, '_>,
    all: &[ShownWater],
    linear_depth: &Handle,
    (radiance, depth): (Handle, Handle),
) -> Result<Watered, ProgramError> {
    if all.is_empty() || r.view.counts_pairs() {
        return Ok(Watered { radiance, depth, linear_depth: None });
    }
    let (radiance, below) = behind_passes(r, "water.below", radiance)?;
    let (mut radiance, depth) = water::record(r, all, (&below, linear_depth), (radiance, depth))?;
    let after = match depth.desc().samples {
        1 => Some(linear_depth::record(r, "water.linear_depth", &depth)?),
        _ => None,
    };
    if let Some(within) = all.iter().find(|water| water.holds_eye) {
        radiance = water::record_within(r, within, (linear_depth, after.as_ref().unwrap_or(linear_depth)), radiance)?;
    }
    Ok(Watered { radiance, depth, linear_depth: after })
}

/// What is known of surfaces before they are shaded where they are drawn.
#[derive(Debug, Default)]
struct Before {
    /// What they occlude in the picture, if that is needed.
    occlusion: Option<Occlusion>,
    /// All of the G-buffer, if they reflect the picture.
    reflects: Option<Gbuffer>,
    /// Their linear depth, if it is there and no part of the G-buffer.
    linear_depth: Option<Handle>,
    /// What mirrors among them reflect.
    mirrored: Option<Reflections>,
}

/// What the mirrors of a view reflect; `depth` has one sample a pixel.
fn mirrored_passes(
    r: &mut Recorder<'_, '_>,
    mirrors: &[ShownMirror],
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
    seen: reflections::Seen<'_>,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    match mirrored {
        Some(mirrored) => reflections::record_composed(r, "mirrors.compose", seen, (mirrored, None), radiance),
        None => Ok(radiance),
    }
}

/// Radiance and distances of a view behind a mirror, for whoever shows it; with mips of radiance if the mirror is rough.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn mirror_picture_passes(
    r: &mut Recorder<'_, '_>,
    is_smooth: bool,
    radiance: Handle,
    linear_depth: Handle,
) -> Result<MirrorPicture, ProgramError> {
    let (jitter_ndc, view_from_ndc_scale) = (r.view.uniform.jitter_ndc, r.view.uniform.view_from_ndc_scale);
    if is_smooth {
        return Ok(MirrorPicture { radiance, linear_depth, jitter_ndc, view_from_ndc_scale });
    }
    let (_, behind) = behind_passes(r, "mirror.picture", radiance)?;
    Ok(MirrorPicture { radiance: behind, linear_depth, jitter_ndc, view_from_ndc_scale })
}

/// Where surfaces are shaded where they are drawn: what effects in the picture need of them. First gives the depth that
/// they are shaded with.
fn before_forward(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    mirrors: &[ShownMirror],
) -> Result<(OpaqueDepth, Before), ProgramError> {
    let (depth, load) = begin_depth(r)?;
    let begun = OpaqueDepth { depth, load, is_drawn: false };
    let has_mirrors = !mirrors.is_empty() && !r.view.counts_pairs();
    let reflects = has_mirrors || reflections::is_needed(r, &settings.reflections);
    if !(reflects || occlusion::is_needed(r, &settings.occlusion, variables.reads_occlusion)) {
        return Ok((begun, Before::default()));
    }
    // Of several samples a pixel the depth of the middle is not that of all.
    let (of_samples, of_middles) = if r.view.pixel_samples > 1 { (Some(begun), None) } else { (None, Some(begun)) };
    let begun = of_middles.map(|begun| (begun.depth, begun.load));
    let geometry::Unshaded { base_color, normal, material, depth } = geometry::record_unshaded(r, begun, reflects)?;
    let linear_depth = linear_depth::record(r, "linear_depth", &depth)?;
    let seen = occlusion::Seen { normal: &normal, linear_depth: &linear_depth, depth: &depth };
    let occlusion = occlusion::record(r, &settings.occlusion, variables.reads_occlusion, seen)?;
    let before = match material {
        Some(material) => {
            let gbuffer = Gbuffer { base_color, normal, material, linear_depth };
            let mirrored = mirrored_passes(r, mirrors, &gbuffer, &depth)?;
            Before { occlusion, reflects: Some(gbuffer), linear_depth: None, mirrored }
        }
        None => Before { occlusion, reflects: None, linear_depth: Some(linear_depth), mirrored: None },
    };
    let drawn = OpaqueDepth { depth, load: DepthLoad::Keep, is_drawn: true };
    Ok((of_samples.unwrap_or(drawn), before))
}

/// What surfaces reflect of the picture that are shaded where they are drawn, over their radiance, before fog.
fn reflected_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    gbuffer: &Gbuffer,
    (occlusion, mirrored): (Option<&Occlusion>, Option<&Reflections>),
    (radiance, depth): (Handle, &Handle),
) -> Result<Handle, ProgramError> {
    let seen = reflections::Seen { gbuffer, occlusion, depth, radiance: None, mirrored: None };
    let radiance = compose_mirrors(r, mirrored, seen, radiance)?;
    let (radiance, mean) = resolve::record_between(r, "reflections.resolve", radiance);
    let mirrored = mirrored.map(|mirrored| &mirrored.texture);
    let seen = reflections::Seen { gbuffer, occlusion, depth, radiance: mean.as_ref(), mirrored };
    let kept = reflections::Kept::new(r, &settings.reflections);
    reflection_passes(r, settings, (seen, kept), radiance)
}

/// What surfaces reflect of the picture, and then those that are shaded where they are drawn, over their radiance.
fn reflection_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    (seen, kept): (reflections::Seen<'_>, reflections::Kept),
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let (radiance, found) = reflections::record(r, &settings.reflections, (seen, kept), radiance)?;
    let Some(found) = found else { return Ok(radiance) };
    let found = InPicture { occlusion: seen.occlusion, reflections: Some(&found) };
    forward::record_layered_reflections(r, found, seen.depth, radiance)
}

/// Opaque surfaces that are shaded where they are drawn: radiance and depth.
fn forward_passes(
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
            forward::record_layered(r, fog, InPicture::default(), radiance, LayeredDepth::Missing(depth))
        }
    }
}

/// Surfaces that light comes through, before what lies behind them; then those that alpha covers, of which those behind
/// come before if each of their fragments is opaque.
fn translucent_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    radiance: Handle,
    depth: Handle,
) -> Result<Translucent, ProgramError> {
    if !r.view.has_transmissive() {
        return Ok(Translucent::new(blended_passes(r, settings, None, radiance, depth)?, None));
    }
    if r.view.counts_pairs() {
        let (pairs, depth) = glass::counting_passes(r, settings, radiance, depth)?;
        return Ok(Translucent::new(blended_passes(r, settings, None, pairs, depth)?, None));
    }
    let is_split = settings.transparency.mode == TransparencyMode::Stochastic && r.view.has_blended();
    let nearest_m = if is_split { Some(glass::nearest_transmissive(r)?) } else { None };
    let peel = |side| nearest_m.as_ref().map(|nearest_m| Peel { side, nearest_m });
    let (radiance, depth) =
        if is_split { blended_passes(r, settings, peel(Side::Behind), radiance, depth)? } else { (radiance, depth) };
    let Translucent { radiance, depth, transmittance } = glass::transmissive_passes(r, settings, radiance, depth)?;
    Ok(Translucent::new(blended_passes(r, settings, peel(Side::Before), radiance, depth)?, transmittance))
}

/// What glass lets through of the background beside what alpha says.
fn tint_passes(
    r: &mut Recorder<'_, '_>,
    transmittance: Option<Handle>,
    radiance: &Handle,
) -> Result<Option<Handle>, ProgramError> {
    let Some(transmittance) = transmittance else { return Ok(None) };
    let transmittance = resolve::record(r, "transmittance.resolve", transmittance);
    Ok(Some(transmittance::record_tint(r, &transmittance, radiance)?))
}

/// The picture so far with mips, after radiance itself.
fn behind_passes(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    radiance: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    let (radiance, mean) = resolve::record_between(r, format!("{name}.resolve"), radiance);
    let behind = mips::record_of(r, name, mean.as_ref().unwrap_or(&radiance))?;
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

/// The numbers of pairs that the same lighting visits, in place of light, of a view that counts them: visited, shaded,
/// in range and passed over, to be added up over all texels. What light is computed for are pixels of opaque surfaces,
/// or where these are lit as they are drawn all of their fragments, or vertices; and those of blended surfaces.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn pair_passes(r: &mut Recorder<'_, '_>, settings: &Settings) -> Result<Handle, ProgramError> {
    let (pairs, depth) = match settings.render.path {
        Path::Deferred => {
            let (ViewOutputs { depth, .. }, gbuffer) = surface_passes(r, settings, &Variables::default(), false)?;
            let pairs = LightTarget::new(r).cleared(r.graph);
            let (pairs, depth) = light_passes(r, settings, &gbuffer, InPicture::default(), depth, pairs)?;
            forward::record_layered(r, None, InPicture::default(), pairs, LayeredDepth::There(depth))?
        }
        _ => {
            let (begun, _) = before_forward(r, settings, &Variables::default(), &[])?;
            forward_passes(r, settings, &settings.fog, begun, None)?
        }
    };
    Ok(translucent_passes(r, settings, pairs, depth)?.radiance)
}
