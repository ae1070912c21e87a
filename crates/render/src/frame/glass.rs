//! Surfaces that light comes through: layer by layer, the farthest first, each before a picture of all behind it.

use crate::draws::{Draw, layers_of_glass};
use crate::environment::Background;
use crate::passes::forward::GlassLayer;
use crate::passes::{forward, glass, linear_depth, mips, resolve, transmittance};
use crate::record::Recorder;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use manypass_graph::Handle;

/// What glass and blended surfaces leave.
pub(super) struct TranslucencyTargets {
    pub radiance: Handle,
    pub depth: Handle,
    /// How much of the background comes through, if radiance does not hold that and there is glass.
    pub transmittance: Option<Handle>,
}

impl TranslucencyTargets {
    pub fn new((radiance, depth): (Handle, Handle), transmittance: Option<Handle>) -> Self {
        Self { radiance, depth, transmittance }
    }
}

/// The distances of the nearest surfaces that light comes through.
pub(super) fn nearest_transmissive(r: &mut Recorder<'_, '_>) -> Result<Handle, ProgramError> {
    let depth = forward::record_nearest_transmissive(r)?;
    linear_depth::record(r, "transmissive.linear_depth", &depth)
}

/// All of them, lit alone: the numbers of pairs of a light and what it may reach.
pub(super) fn counting_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    radiance: Handle,
    depth: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    let view = r.view;
    let layer = GlassLayer { draws: &view.draws.transmissive, suffix: "", behind: None, bodies: None };
    forward::record_transmissive(r, &settings.fog, (layer, false), radiance, depth)
}

/// All of them, before what lies behind them: as many layers as lie behind each other in the picture, and the settings
/// allow.
pub(super) fn transmissive_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    radiance: Handle,
    depth: Handle,
) -> Result<TranslucencyTargets, ProgramError> {
    let (view, world) = (r.view, r.frame.world);
    let most = settings.transparency.refractive_layers;
    let layers = layers_of_glass(&view.draws.transmissive, world, &view.uniform, most);
    let has_bodies = view.draws.transmissive.iter().any(|draw| world.items[draw.item as usize].bends_twice);
    // Of several samples a pixel distances are those of the middle, without glass.
    let is_multisampled = has_bodies && depth.desc().samples > 1;
    let middles = if is_multisampled { Some(forward::record_depth(r, "glass.middles")?) } else { None };
    let mut drawn = TranslucencyTargets { radiance, depth, transmittance: None };
    let mut layers_before = layers.len();
    for draws in &layers {
        layers_before -= 1;
        let suffix = match layers_before {
            0 => String::new(),
            1 => ".far".into(),
            _ => format!(".far.{layers_before}"),
        };
        drawn = layer_passes(r, settings, (draws, &suffix), middles.as_ref(), drawn)?;
    }
    Ok(drawn)
}

/// One layer, before all that is drawn so far.
fn layer_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    (draws, suffix): (&[Draw], &str),
    middles: Option<&Handle>,
    TranslucencyTargets { radiance, depth, transmittance }: TranslucencyTargets,
) -> Result<TranslucencyTargets, ProgramError> {
    let fog = &settings.fog;
    let (radiance, mean) = resolve::record_between(r, format!("behind{suffix}.resolve"), radiance);
    let so_far = mean.as_ref().unwrap_or(&radiance);
    let behind = mips::record_of(r, &format!("behind{suffix}"), so_far)?;
    // A background that is none of radiance is laid behind the picture at its end.
    let is_apart = settings.background.source != Background::Environment;
    let uncovered = match transmittance {
        None if is_apart => Some(transmittance::record_uncovered(r, so_far)?),
        transmittance => transmittance,
    };
    let bodies = body_passes(r, (draws, suffix), middles.unwrap_or(&depth))?;
    let layer = GlassLayer { draws, suffix, behind: Some(&behind), bodies: bodies.as_ref() };
    let (radiance, depth) = forward::record_transmissive(r, fog, (layer, is_apart), radiance, depth)?;
    let Some(uncovered) = uncovered else { return Ok(TranslucencyTargets { radiance, depth, transmittance: None }) };
    let name = format!("transmittance.behind{suffix}");
    let (uncovered, mean) = resolve::record_between(r, format!("{name}.resolve"), uncovered);
    let behind = mips::record_of(r, &name, mean.as_ref().unwrap_or(&uncovered))?;
    let layer = GlassLayer { behind: Some(&behind), ..layer };
    let transmittance = forward::record_transmittance(r, fog, layer, uncovered, &depth)?;
    Ok(TranslucencyTargets { radiance, depth, transmittance: Some(transmittance) })
}

/// Where rays leave the bodies of a layer, if there are any; `depth` is that of what lies behind them.
fn body_passes(
    r: &mut Recorder<'_, '_>,
    (draws, suffix): (&[Draw], &str),
    depth: &Handle,
) -> Result<Option<Handle>, ProgramError> {
    let world = r.frame.world;
    let bends_twice = |draw: &&Draw| world.items[draw.item as usize].bends_twice;
    let bodies: Vec<Draw> = draws.iter().filter(bends_twice).cloned().collect();
    if bodies.is_empty() {
        return Ok(None);
    }
    let linear_depth = linear_depth::record(r, format!("glass{suffix}.linear_depth"), depth)?;
    glass::record(r, (&bodies, suffix), &linear_depth).map(Some)
}
