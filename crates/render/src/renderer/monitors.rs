//! Monitors: what their cameras see is recorded, and screens show it.

use super::prepare_view::output_of;
use super::purpose::Purpose;
use super::record_inputs::{MonitorPicture, RecordInputs};
use super::view_kind::MonitorView;
use crate::frame::{self, Means, MonitorInputs};
use crate::gbuffer::ViewOutputs;
use crate::passes::adaptive;
use crate::record::{Frame, Recorder};
use crate::request::RenderError;
use crate::resources::monitor_desc;
use manypass_graph::{Graph, Handle};
use manypass_scene::Scene;

/// Makes screens show what their cameras saw.
pub(super) fn record_screens<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    scene: &Scene,
    seen: &mut Vec<MonitorPicture<'f>>,
) -> Result<(), RenderError> {
    for MonitorPicture { view, asked, setup, radiance, depth, means, settling, adapted } in seen.drain(..) {
        let mut r = Recorder::new(graph, frame, &setup.view);
        let Some(texture) = import_monitor(&mut r, scene, view.image) else { continue };
        let request = &asked.request;
        let monitored = MonitorInputs {
            radiance: &radiance,
            depth: &depth,
            means,
            adaptive_step: setup.adaptive_step(asked),
            settling,
            sample_index: request.sample_index,
            exposure: request.known_exposure() * view.exposure_stops.clamp(-64.0, 64.0).exp2(),
            adapted: adapted.as_ref(),
        };
        frame::monitor_passes(&mut r, &request.settings, monitored, texture)?;
    }
    Ok(())
}

/// The texture that shows what the monitor of an image does.
fn import_monitor(r: &mut Recorder<'_, '_>, scene: &Scene, image: usize) -> Option<Handle> {
    let monitor = scene.images.get(image)?.monitor()?;
    let view = r.frame.resources.textures.monitor(scene, image)?;
    let desc = monitor_desc((monitor.width, monitor.height));
    Some(r.graph.import(format!("monitor.{image}"), desc, view.clone()))
}

/// Makes the monitors dark that would be too deep in what the camera of another one sees.
pub(super) fn darken_monitors(r: &mut Recorder<'_, '_>, scene: &Scene, view: &MonitorView) {
    for image in &view.darkens {
        let Some(texture) = import_monitor(r, scene, *image) else { continue };
        frame::darken_monitor(r, texture);
    }
}

/// What the camera of a monitor sees, with the exposure and the mean of its own.
pub(super) fn record_monitor<'f>(
    r: &mut Recorder<'_, 'f>,
    view: &'f MonitorView,
    inputs: &mut RecordInputs<'_, 'f>,
    outputs: ViewOutputs,
    purpose: &Purpose<'_>,
) -> Result<MonitorPicture<'f>, RenderError> {
    let (asked, setup, state) = (inputs.asked, inputs.setup, &mut *inputs.state);
    let request = &asked.request;
    let outputs = frame::temporal_passes(r, &request.settings, setup.temporal.as_ref(), outputs)?;
    let ViewOutputs { radiance, depth, .. } = outputs;
    let adapting = request.adapting(state.adapted.is_some());
    let adapted = frame::exposure_passes(r, adapting.as_ref(), &radiance)?;
    let (previous_sum, settles) = (asked.previous_sum(state), setup.adaptive_step(asked) != adaptive::Step::None);
    let output = if asked.has_output() {
        output_of(r.frame.gpu, asked, &mut state.output, (purpose, settles), false)
    } else {
        None
    };
    let means = output.map_or(Means::None, |output| output.means(r.graph, asked.means_of, previous_sum));
    let settling = output.filter(|_| settles).and_then(|output| output.settling(r.graph));
    Ok(MonitorPicture { view, asked, setup, radiance, depth, means, settling, adapted })
}
