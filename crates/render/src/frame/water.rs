//! What water and mirrors show: surfaces of water over all that is opaque, and the picture that a mirror's view leaves.

use crate::mirror_picture::MirrorPicture;
use crate::passes::water::WaterDraw;
use crate::passes::{linear_depth, mips, resolve, water};
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::Handle;

/// What water leaves.
#[derive(Debug)]
pub(super) struct WaterTargets {
    pub radiance: Handle,
    pub depth: Handle,
    /// Linear depth of water and of what is before it, if there is water and a pixel has one sample.
    pub linear_depth: Option<Handle>,
}

/// Surfaces of water over all that is opaque and what lies behind that. `linear_depth` is that of opaque surfaces.
pub(super) fn water_passes(
    r: &mut Recorder<'_, '_>,
    all: &[WaterDraw],
    linear_depth: Option<&Handle>,
    (radiance, depth): (Handle, Handle),
) -> Result<WaterTargets, ProgramError> {
    let (Some(linear_depth), false, false) = (linear_depth, all.is_empty(), r.view.counts_pairs()) else {
        return Ok(WaterTargets { radiance, depth, linear_depth: None });
    };
    let (radiance, below) = behind_passes(r, "water.below", radiance)?;
    let (mut radiance, depth) = water::record(r, all, (&below, linear_depth), (radiance, depth))?;
    let after = match depth.desc().samples {
        1 => Some(linear_depth::record(r, "water.linear_depth", &depth)?),
        _ => None,
    };
    if let Some(within) = all.iter().find(|water| water.holds_eye) {
        radiance = water::record_within(r, within, (linear_depth, after.as_ref().unwrap_or(linear_depth)), radiance)?;
    }
    Ok(WaterTargets { radiance, depth, linear_depth: after })
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

/// Radiance itself, and the picture so far with mips.
fn behind_passes(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    radiance: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    let (radiance, mean) = resolve::record_between(r, format!("{name}.resolve"), radiance);
    let behind = mips::record_of(r, name, mean.as_ref().unwrap_or(&radiance))?;
    Ok((radiance, behind))
}
