//! Surfaces that something is seen through: glass (`frame/glass.rs`), and blended ones, which alpha covers.

use super::glass::{self, TranslucencyTargets};
use crate::passes::{forward, gouraud, resolve, transmittance, transparency};
use crate::record::Recorder;
use crate::render_settings::Path;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use crate::transparency::{BlendTargets, Peel, Side, TransparencyMode};
use manypass_graph::Handle;

/// Glass, before what lies behind it, then blended surfaces. With stochastic transparency each fragment is opaque, so
/// that blended surfaces behind glass come before the glass.
pub(super) fn translucent_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    radiance: Handle,
    depth: Handle,
) -> Result<TranslucencyTargets, ProgramError> {
    if !r.view.has_transmissive() {
        return Ok(TranslucencyTargets::new(blended_passes(r, settings, None, radiance, depth)?, None));
    }
    if r.view.counts_pairs() {
        let (pairs, depth) = glass::counting_passes(r, settings, radiance, depth)?;
        return Ok(TranslucencyTargets::new(blended_passes(r, settings, None, pairs, depth)?, None));
    }
    let is_split = settings.transparency.mode == TransparencyMode::Stochastic && r.view.has_blended();
    let nearest_m = if is_split { Some(glass::nearest_transmissive(r)?) } else { None };
    let peel = |side| nearest_m.as_ref().map(|nearest_m| Peel { side, nearest_m });
    let (radiance, depth) =
        if is_split { blended_passes(r, settings, peel(Side::Behind), radiance, depth)? } else { (radiance, depth) };
    let TranslucencyTargets { radiance, depth, transmittance } =
        glass::transmissive_passes(r, settings, radiance, depth)?;
    let blended = blended_passes(r, settings, peel(Side::Before), radiance, depth)?;
    Ok(TranslucencyTargets::new(blended, transmittance))
}

/// What glass lets through of the background beside what alpha says.
pub(super) fn tint_passes(
    r: &mut Recorder<'_, '_>,
    transmittance: Option<Handle>,
    radiance: &Handle,
) -> Result<Option<Handle>, ProgramError> {
    let Some(transmittance) = transmittance else { return Ok(None) };
    let transmittance = resolve::record(r, "transmittance.resolve", transmittance);
    Ok(Some(transmittance::record_tint(r, &transmittance, radiance)?))
}

/// Blended surfaces, or what `peel` says of them, in the mode of the settings. Also gives depth.
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
    let blended = BlendTargets::new(r, settings.transparency.mode, radiance, depth);
    let blended = match settings.render.path {
        Path::Gouraud => gouraud::record_blended(r, &settings.fog, blended, peel)?,
        Path::Deferred | Path::Forward | Path::ForwardBatched => {
            forward::record_blended(r, &settings.fog, blended, peel)?
        }
    };
    let blended = resolve::record_blended(r, blended);
    transparency::record(r, blended)
}
