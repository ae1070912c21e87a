//! Declares the passes of a frame on its graph, each view with what those before it left.

use super::ask::{FrameViews, ViewRequest};
use super::counts::light_draws;
use super::monitors::record_screens;
use super::prepare::PreparedFrame;
use super::prepare_view::ViewSetup;
use super::purpose::Purpose;
use super::record_inputs::{EarlierResults, RecordInputs, SceneFeatures, ViewExports};
use super::record_view::record_view;
use super::shadows::Atlas;
use super::surroundings;
use crate::frame;
use crate::record::{Frame, Recorder};
use crate::request::RenderError;
use manypass_graph::{Export, Graph, Plan};

/// A frame whose passes are declared and planned.
pub(super) struct RecordedFrame<'f> {
    pub graph: Graph<'f>,
    pub plan: Plan,
    /// Of each view.
    pub views: Vec<ViewExports>,
    /// What the purpose of the frame reads.
    pub exports: Vec<Export>,
    /// Draws that only light.
    pub light_draws: u32,
}

/// Declares and plans all passes of a frame.
pub(super) fn record_frame<'f>(
    mut graph: Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    prepared: &'f PreparedFrame<'_>,
    views: &'f mut FrameViews,
    purpose: &Purpose<'_>,
) -> Result<RecordedFrame<'f>, RenderError> {
    let FrameViews { requests, states, .. } = views;
    let (requests, setups) = (&*requests, &prepared.setups);
    if let (Some(view), Some((shadows, atlas))) = (&prepared.shared_view, &prepared.shadows) {
        let mut r = Recorder::new(&mut graph, frame, view);
        let texture = r.graph.import("shadows.atlas", Atlas::desc(atlas.side), atlas.view.clone());
        frame::shared_passes(&mut r, shadows, texture)?;
    }
    let inputs = requests.iter().zip(states).zip(setups).zip(&prepared.overlays);
    let inputs = inputs.map(|(((asked, state), setup), overlay)| RecordInputs { asked, state, setup, overlay });
    let views = record_views(&mut graph, frame, features, inputs, purpose)?;
    let plan = graph.plan()?;
    let of_view = |(setup, asked): (&ViewSetup, &ViewRequest)| light_draws(&setup.view, asked, frame.world);
    let light_draws = setups.iter().zip(requests).map(of_view).sum();
    let exports = views.iter().filter_map(|exported| exported.export).chain(frame.scrubbed.exports()).collect();
    Ok(RecordedFrame { graph, plan, views, exports, light_draws })
}

/// Records all passes of views, innermost first.
fn record_views<'v, 'f: 'v>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    views: impl Iterator<Item = RecordInputs<'v, 'f>>,
    purpose: &Purpose<'_>,
) -> Result<Vec<ViewExports>, RenderError> {
    let mut before = EarlierResults::default();
    let mut first_side = None;
    let mut recorded = Vec::new();
    for view in views {
        let RecordInputs { asked, setup, .. } = &view;
        // Those that are captured again have the light of what was captured before.
        let bounce = asked.kind.bounce;
        if before.sides.keys().next().is_some_and(|side| Some(side.bounce) != bounce)
            && let (Some((state, surroundings)), Some(first)) = (features.surroundings, first_side)
        {
            surroundings::record(graph, frame, (state, surroundings, first), &mut before.sides)?;
        }
        if bounce == Some(0) {
            // What draws tiles is of a view that has none.
            first_side.get_or_insert(&setup.view);
        }
        // Those at one level see what there was before all of them.
        if before.seen.first().is_some_and(|seen| Some(seen.view.level) != asked.level) {
            record_screens(graph, frame, features.scene, &mut before.seen)?;
        }
        recorded.push(record_view(graph, frame, features, view, &mut before, purpose)?);
    }
    Ok(recorded)
}
