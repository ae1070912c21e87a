//! Declares the passes of one view.

use super::ask::ViewRequest;
use super::fisheye::uv_from_place;
use super::live_probes::record_probe;
use super::monitors::{darken_monitors, record_monitor};
use super::prepare_view::output_of;
use super::purpose::Purpose;
use super::record_inputs::{EarlierResults, RecordInputs, SceneFeatures, ViewExports};
use super::record_mirrors;
use super::view_kind::Drawing;
use crate::aov::AovExports;
use crate::environment::lobe::FACES;
use crate::frame::{self, Picture, SceneLayers, Tint, Variables};
use crate::gbuffer::{Gbuffer, ViewOutputs};
use crate::passes::fisheye::FaceRadiance;
use crate::passes::probe_capture::ProbeSide;
use crate::passes::{adaptive, meter};
use crate::record::{Frame, Recorder};
use crate::request::RenderError;
use manypass_graph::Graph;

/// Records all passes of a view.
pub(super) fn record_view<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    mut view: RecordInputs<'_, 'f>,
    before: &mut EarlierResults<'f>,
    purpose: &Purpose<'_>,
) -> Result<ViewExports, RenderError> {
    let RecordInputs { asked, setup, .. } = view;
    let request = &asked.request;
    if purpose.draws_variables_alone {
        let mut r = Recorder::new(graph, frame, &setup.view);
        let outputs = frame::variable_passes(&mut r, &request.settings, &setup.variables)?;
        return Ok(ViewExports { variables: AovExports::new(r.graph, outputs), ..ViewExports::default() });
    }
    let (variables, of_view) = match &setup.variables_view {
        Some(view) => {
            let mut r = Recorder::new(graph, frame, view);
            (Some(frame::variable_passes(&mut r, &request.settings, &setup.variables)?), setup.of_effects)
        }
        None => (None, setup.variables.and(&setup.of_effects)),
    };
    if purpose.counts_pairs {
        return record_pairs(&mut Recorder::new(graph, frame, &setup.view), asked);
    }
    let Some(outputs) = record_surfaces(graph, frame, features, &mut view, &of_view, before, purpose)? else {
        return Ok(ViewExports::default());
    };
    let mut r = Recorder::new(graph, frame, &setup.view);
    let outputs = frame::temporal_passes(&mut r, &request.settings, setup.temporal.as_ref(), outputs)?;
    let (mut r, outputs) = match &setup.enlarged_view {
        Some(view) => {
            let outputs = frame::enlarged_passes(&mut r, view.size, outputs)?;
            (Recorder::new(graph, frame, view), outputs)
        }
        None => (r, outputs),
    };
    let mut outputs = frame::effect_passes(&mut r, &request.effects, outputs)?;
    let recorded = record_picture(&mut r, view, &mut outputs, purpose)?;
    let variables = if asked.wants_variables {
        AovExports::new(r.graph, variables.unwrap_or(outputs))
    } else {
        AovExports::default()
    };
    Ok(ViewExports { variables, ..recorded })
}

/// Records what a view shows of the scene. Pictures go on; what other views leave is kept for those that show it.
fn record_surfaces<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    view: &mut RecordInputs<'_, 'f>,
    variables: &Variables,
    before: &mut EarlierResults<'f>,
    purpose: &Purpose<'_>,
) -> Result<Option<ViewOutputs>, RenderError> {
    let (asked, setup, request) = (view.asked, view.setup, &view.asked.request);
    let SceneFeatures { scene, water, doors, particles, .. } = features;
    let flat = SceneLayers {
        mirrors: record_mirrors::shown((asked, setup), &mut before.behind),
        water: water.shown((*scene, &frame.resources.textures), (asked, setup), &mut before.behind),
        portals: doors.shown(asked, &mut before.through),
        particles: particles.clone(),
    };
    let mut r = Recorder::new(graph, frame, &setup.view);
    if let Drawing::Monitor(monitor) = &asked.kind.drawing {
        darken_monitors(&mut r, scene, monitor);
    }
    if let Drawing::Fisheye(of_fisheye) = &asked.kind.drawing {
        let faces = std::mem::take(&mut before.faces);
        return Ok(Some(frame::fisheye_passes(&mut r, &of_fisheye.lens, request.sample(), faces)?));
    }
    let outputs = frame::view_passes(&mut r, &request.settings, variables, &flat)?;
    match &asked.kind.drawing {
        Drawing::Picture | Drawing::Fisheye(_) => return Ok(Some(outputs)),
        Drawing::Mirror(mirror) => record_mirrors::record_behind(&mut r, mirror, asked, outputs, before)?,
        Drawing::Side(side) => {
            before.sides.insert(*side, outputs.radiance);
        }
        Drawing::Probe(_) => {
            if let ViewOutputs { radiance, gbuffer: Some(Gbuffer { linear_depth, .. }), .. } = outputs {
                before.around.push(ProbeSide { radiance, linear_depth });
            }
            if before.around.len() == FACES.len() {
                record_probe(graph, frame, features, before)?;
            }
        }
        Drawing::Face(face) => {
            let uv_from_place = uv_from_place(face, request, asked.size);
            before.faces.push(FaceRadiance { side: face.side, radiance: outputs.radiance, uv_from_place });
        }
        Drawing::Monitor(monitor) => {
            before.seen.push(record_monitor(&mut r, monitor, view, outputs, purpose)?);
        }
    }
    Ok(None)
}

/// Counts the pairs of a view; none of a fisheye, whose sides are counted.
fn record_pairs(r: &mut Recorder<'_, '_>, asked: &ViewRequest) -> Result<ViewExports, RenderError> {
    if !asked.kind.draws_surfaces {
        return Ok(ViewExports::default());
    }
    let pairs = frame::pair_passes(r, &asked.request.settings)?;
    Ok(ViewExports { export: Some(r.graph.export(pairs)), ..ViewExports::default() })
}

/// What becomes of the radiance of a view whose picture is shown, or metered alone.
fn record_picture<'f>(
    r: &mut Recorder<'_, 'f>,
    view: RecordInputs<'_, 'f>,
    outputs: &mut ViewOutputs,
    purpose: &Purpose<'_>,
) -> Result<ViewExports, RenderError> {
    let RecordInputs { asked, state, setup, overlay } = view;
    let request = &asked.request;
    let has_tint = outputs.tint.is_some();
    let (mut export, mut adapted) = (None, None);
    let previous_sum = asked.previous_sum(state);
    let step = setup.adaptive_step(asked);
    match output_of(r.frame.gpu, asked, &mut state.output, (purpose, step != adaptive::Step::None), has_tint) {
        None => {
            let meter = meter::record(r, &outputs.radiance)?;
            export = Some(r.graph.export(meter));
        }
        Some(output) => {
            let adapting = request.adapting(state.adapted.is_some());
            let stops = frame::exposure_passes(r, adapting.as_ref(), &outputs.radiance)?;
            let (settings, shaded) = (&request.settings, &outputs.radiance);
            let enlarged = frame::upscale_passes(r, settings, request.display_exposure(), shaded, asked.output_size)?;
            let means = output.means(r.graph, asked.means_of, previous_sum);
            let tint = outputs.tint.take().map(|texture| {
                let mean = output.tint_mean(r.graph, asked.means_of, previous_sum);
                Tint { texture, mean }
            });
            let picture = Picture {
                tint,
                display: output.display(r.graph),
                target: purpose.target,
                is_shown: purpose.shows_picture,
                sample_index: request.sample_index,
                exposure: request.known_exposure(),
                adapted: stops.as_ref(),
                depth: &outputs.depth,
                adaptive_step: step,
                overlay: overlay.as_ref(),
                settling: if step == adaptive::Step::None { None } else { output.settling(r.graph) },
            };
            let radiance = enlarged.as_ref().unwrap_or(shaded);
            frame::output_passes(r, settings, radiance, means, picture, &request.effects)?;
            adapted = stops.map(|stops| r.graph.export(stops));
        }
    }
    Ok(ViewExports { variables: AovExports::default(), export, adapted, has_tint })
}
