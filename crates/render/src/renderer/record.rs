//! Declares the passes of a frame on its graph, each view with what those before it left.

use super::ask::{FrameViews, ViewRequest};
use super::counts::light_draws;
use super::monitors::{MonitorPicture, record_screens};
use super::output::ViewState;
use super::portals::Doors;
use super::prepare::PreparedFrame;
use super::prepare_view::ViewSetup;
use super::purpose::Purpose;
use super::record_view::record_view;
use super::shadows::Atlas;
use super::surroundings::{self, FrameSurroundings, SideView, SurroundingsState};
use super::water::Surfaces;
use crate::aov::AovExports;
use crate::frame;
use crate::mirror_picture::MirrorPicture;
use crate::overlay::draw::OverlayDraw;
use crate::passes::fisheye::FaceRadiance;
use crate::passes::particles::ParticlesDraw;
use crate::passes::probe_capture::{CapturedProbe, ProbeSide};
use crate::record::{Frame, PreparedView, Recorder};
use crate::request::RenderError;
use manypass_graph::{Export, Graph, Handle, Plan};
use manypass_scene::Scene;
use std::collections::BTreeMap;

/// What recording a view leaves to fetch.
#[derive(Default)]
pub(super) struct ViewExports {
    pub variables: AovExports,
    pub export: Option<Export>,
    /// The stops of an exposure that adapts.
    pub adapted: Option<Export>,
    /// Whether there is glass before a background that is none of radiance.
    pub has_tint: bool,
}

/// What of a scene its views show beside surfaces.
pub(super) struct SceneFeatures<'s> {
    pub scene: &'s Scene,
    pub water: Surfaces,
    pub doors: Doors,
    pub particles: Vec<ParticlesDraw>,
    pub surroundings: Option<(&'s SurroundingsState, &'s FrameSurroundings)>,
    /// Where what views around probes show belongs, in their order; and of which view it is put there.
    pub probes: Option<(&'s PreparedView, &'s [Option<CapturedProbe>])>,
}

impl<'s> SceneFeatures<'s> {
    pub fn new(
        prepared: &'s PreparedFrame<'s>,
        particles: Vec<ParticlesDraw>,
        surroundings: &'s SurroundingsState,
    ) -> Self {
        let scene = prepared.scene.scene;
        Self {
            scene,
            water: Surfaces::of(scene),
            doors: Doors::of(scene),
            particles,
            surroundings: prepared.surroundings.as_ref().map(|of_frame| (surroundings, of_frame)),
            probes: prepared.shared_view.as_ref().map(|view| (view, &prepared.captured[..])),
        }
    }
}

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

/// A view that is recorded.
pub(super) struct RecordInputs<'v, 'f> {
    pub asked: &'f ViewRequest,
    pub state: &'v mut ViewState,
    pub setup: &'f ViewSetup,
    pub overlay: &'v Option<OverlayDraw>,
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

/// What views left for those that follow them.
#[derive(Default)]
pub(super) struct EarlierResults<'f> {
    /// The sides of a fisheye picture.
    pub faces: Vec<FaceRadiance>,
    /// What cameras of monitors see, which screens do not show yet.
    pub seen: Vec<MonitorPicture<'f>>,
    /// The sides of the pictures around places.
    pub sides: BTreeMap<SideView, Handle>,
    /// The sides of what is around a probe, and how many probes came before it.
    pub around: Vec<ProbeSide>,
    pub probes: usize,
    /// What is behind mirrors, by the names of the views.
    pub behind: BTreeMap<String, MirrorPicture>,
    /// Radiance of what is seen through portals, by the names of the views.
    pub through: BTreeMap<String, Handle>,
}
