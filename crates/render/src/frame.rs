//! The whole frame, top to bottom. [`view_passes`] is the order of passes from surfaces to radiance, whatever the path;
//! what a line there stands for is in the file of that name below `frame/`, or in the folder of the pass. From a view's
//! radiance to the picture `frame/picture.rs` goes on. `renderer/record_view.rs` calls these functions in this order:
//!
//! ```text
//! shared_passes                                     once a frame
//! view_passes                                       each view, innermost first
//! temporal > effect > exposure > upscale > output   the picture, in `frame/picture.rs`
//! ```

mod glass;
mod layers;
mod monitors;
mod picture;
mod separate_graphs;
mod surfaces;
mod translucent;
mod water;

pub use layers::SceneLayers;
pub use monitors::{MonitorInputs, darken_monitor, monitor_passes};
pub(crate) use picture::fisheye_passes;
pub use picture::{
    Means, Picture, Tint, effect_passes, enlarged_passes, exposure_passes, output_passes, temporal_passes,
    upscale_passes,
};
pub use separate_graphs::pair_passes;
pub(crate) use separate_graphs::{environment_passes, ground_passes, probe_light_passes, surroundings_passes};
pub use surfaces::{Variables, variable_passes};
pub(crate) use water::mirror_picture_passes;

use crate::gbuffer::ViewOutputs;
use crate::passes::debug::DebugView;
use crate::passes::{background, fog, forward, ground, linear_depth, particles, portals, probes, resolve, shadows};
use crate::record::Recorder;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use crate::shadows::FrameShadows;
use glass::TranslucencyTargets;
use manypass_graph::Handle;
use surfaces::{OpaqueSurfaces, opaque_passes};
use translucent::{tint_passes, translucent_passes};
use water::{WaterTargets, water_passes};

/// What all views of a frame share: the maps of their shadows.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn shared_passes(
    r: &mut Recorder<'_, '_>,
    frame_shadows: &FrameShadows,
    atlas: Handle,
) -> Result<(), ProgramError> {
    shadows::record(r, frame_shadows, atlas)
}

/// Everything from geometry to radiance, for one camera.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn view_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    variables: &Variables,
    layers: &SceneLayers,
) -> Result<ViewOutputs, ProgramError> {
    // Opaque surfaces with their light. Here alone paths differ: `frame/surfaces/deferred.rs` and `forward.rs`.
    let OpaqueSurfaces { outputs, linear_depth, is_fogged } = opaque_passes(r, settings, variables, layers)?;
    let ViewOutputs { radiance, depth, gbuffer, .. } = outputs;
    let linear_depth = gbuffer.as_ref().map(|gbuffer| &gbuffer.linear_depth).or(linear_depth.as_ref());

    // What lies behind them: the environment if it is the background, the shadow catcher.
    let radiance = background::record(r, &settings.background, &depth, radiance)?;
    let radiance = ground::record(r, &depth, radiance)?;

    // Water, which shows all of that below it. From here on linear depth is that of water, too.
    let middles = linear_depth_passes(r, settings, layers, linear_depth, &depth)?;
    let linear_depth = linear_depth.or(middles.as_ref());
    let water = water_passes(r, &layers.water, linear_depth, (radiance, depth))?;
    let WaterTargets { radiance, depth, linear_depth: with_water } = water;
    let linear_depth = with_water.as_ref().or(linear_depth);

    // Fog over opaque surfaces, unless they have it already; over the environment; then light that scatters in it.
    let unfogged = linear_depth.filter(|_| !is_fogged);
    let radiance = fog::record(r, &settings.fog, unfogged, &depth, radiance)?;
    let radiance = fog::record_background(r, &settings.fog, settings.background.source, &depth, radiance)?;
    let radiance = fog::record_light(r, &settings.fog, linear_depth, radiance)?;

    // What that fog does not cover: pictures in portals, which have theirs, spheres for probes, and particles.
    let (radiance, depth) = portals::record(r, &layers.portals, (radiance, depth))?;
    let (radiance, depth) = probe_passes(r, settings, (radiance, depth))?;
    let radiance = particle_passes(r, settings, layers, (linear_depth, &depth), radiance)?;

    // Translucent surfaces, which add fog where they are shaded: glass, then blended ones.
    let translucent = translucent_passes(r, settings, radiance, depth)?;
    let TranslucencyTargets { radiance, depth, transmittance } = translucent;

    // One sample a pixel from here on.
    let radiance = resolve::record(r, "resolve", radiance);
    let tint = tint_passes(r, transmittance, &radiance)?;
    Ok(ViewOutputs { radiance, depth, gbuffer, tint, ..outputs })
}

/// Linear depth of opaque surfaces, if it is not known and a pass that follows needs it.
fn linear_depth_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    layers: &SceneLayers,
    known: Option<&Handle>,
    depth: &Handle,
) -> Result<Option<Handle>, ProgramError> {
    let is_needed = !layers.water.is_empty() || !layers.particles.is_empty() || settings.fog.scatters();
    if known.is_some() || !is_needed {
        return Ok(None);
    }
    // With several samples a pixel it is that of the pixel's middle.
    let of_middles = if r.view.pixel_samples > 1 { Some(forward::record_depth(r, "forward.depth")?) } else { None };
    linear_depth::record(r, "linear_depth", of_middles.as_ref().unwrap_or(depth)).map(Some)
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

/// Particles over all that is opaque. `linear_depth` is that of it without portals.
fn particle_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    layers: &SceneLayers,
    (linear_depth, depth): (Option<&Handle>, &Handle),
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let particles = &layers.particles;
    let (Some(linear_depth), false, false) = (linear_depth, particles.is_empty(), r.view.counts_pairs()) else {
        return Ok(radiance);
    };
    let with_portals = match depth.desc().samples {
        1 if !layers.portals.is_empty() => Some(linear_depth::record(r, "particles.linear_depth", depth)?),
        _ => None,
    };
    particles::record(r, particles, &settings.fog, with_portals.as_ref().unwrap_or(linear_depth), radiance)
}
