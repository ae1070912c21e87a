//! What passes of a view are recorded from: what was prepared, and what views before it left.

use super::ask::ViewRequest;
use super::output::ViewState;
use super::portals::Doors;
use super::prepare::PreparedFrame;
use super::prepare_view::ViewSetup;
use super::surroundings::{FrameSurroundings, SurroundingsState};
use super::view_kind::{MonitorView, SideView};
use super::water::Surfaces;
use crate::aov::AovExports;
use crate::frame::Means;
use crate::mirror_picture::MirrorPicture;
use crate::overlay::draw::OverlayDraw;
use crate::passes::adaptive::ConvergedTiles;
use crate::passes::fisheye::FaceRadiance;
use crate::passes::particles::ParticlesDraw;
use crate::passes::probe_capture::{CapturedProbe, ProbeSide};
use crate::record::PreparedView;
use manypass_graph::{Export, Handle};
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

/// A view that is recorded.
pub(super) struct RecordInputs<'v, 'f> {
    pub asked: &'f ViewRequest,
    pub state: &'v mut ViewState,
    pub setup: &'f ViewSetup,
    pub overlay: &'v Option<OverlayDraw>,
}

/// What the camera of a monitor sees.
pub(super) struct MonitorPicture<'f> {
    pub view: &'f MonitorView,
    pub asked: &'f ViewRequest,
    pub setup: &'f ViewSetup,
    pub radiance: Handle,
    pub depth: Handle,
    pub means: Means,
    pub settling: Option<ConvergedTiles>,
    /// The stops of an exposure that adapts.
    pub adapted: Option<Handle>,
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
