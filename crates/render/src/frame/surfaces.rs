//! Surfaces before light reaches them: depth, the G-buffer, and what variables need.

use crate::aov::AovPasses;
use crate::gbuffer::{Gbuffer, ViewOutputs};
use crate::passes::{adaptive, coverage, emission, geometry, ids, linear_depth, mirrors, motion, occlusion};
use crate::record::Recorder;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use crate::view::CameraStep;
use manypass_graph::{DepthLoad, Handle};

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

/// The depth that a view begins with: where nothing is to be drawn, because tiles are settled or lie outside of a mirror's
/// outline, it is nearest of all.
pub(super) fn begin_depth(r: &mut Recorder<'_, '_>) -> Result<(Handle, DepthLoad), ProgramError> {
    match r.view.outline {
        Some(outline) => mirrors::begin_depth(r, &outline),
        None => adaptive::begin_depth(r),
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
    let (outputs, gbuffer) = surface_passes(r, settings, variables, false)?;
    Ok(ViewOutputs { gbuffer: Some(gbuffer), ..outputs })
}

/// The G-buffer and the passes that variables need; `radiance` holds emission so far. `fills_background` is as for
/// [`geometry::record`].
pub(super) fn surface_passes(
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
    let seen = occlusion::Seen { normal: &gbuffer.normal, linear_depth: &gbuffer.linear_depth, depth: &geometry.depth };
    let occlusion_screen =
        wanted.occlusion_screen.then(|| occlusion::record_variable(r, &settings.occlusion, seen)).transpose()?;
    let outputs = ViewOutputs {
        radiance,
        depth: geometry.depth,
        gbuffer: None,
        emission,
        ids,
        motion,
        occlusion: None,
        occlusion_screen,
        tint: None,
    };
    Ok((outputs, gbuffer))
}
