//! What views that are anti-aliased over time know of their last frame.

use super::Renderer;
use crate::passes::taa::{PreviousFrames, TemporalFrame};
use crate::pose::Pose;
use crate::request::FrameRequest;
use crate::settings::Settings;
use crate::view::{self, CameraStep};
use glam::{Vec2, Vec4};
use manypass_scene::water::Water;
use manypass_scene::{Light, NodeId, Scene};
use std::sync::Arc;

/// The last frame of a view, which its histories are of.
#[derive(Clone, Debug)]
pub(super) struct LastFrame {
    pose: Arc<Pose>,
    shown: Arc<FrameContent>,
    /// How many frames came before it.
    index: u32,
    pre_exposure: f32,
}

/// What a frame shows, beside where everything is.
#[derive(Debug)]
struct FrameContent {
    settings: Settings,
    exposure: f32,
    light_subset: Option<(u32, u32)>,
    clip_plane_world: Option<Vec4>,
    ground_height_m: Option<f32>,
    roots: Vec<NodeId>,
    lights: Vec<Light>,
    water: Vec<Water>,
    /// The scene's time, where anything goes by it.
    time_secs: f32,
    /// Counts what changed of meshes, materials and textures on the device.
    scene_version: u64,
}

impl FrameContent {
    fn new(request: &FrameRequest, scene: &Scene, scene_version: u64) -> Self {
        Self {
            settings: request.settings.clone(),
            exposure: request.display_exposure(),
            light_subset: request.light_subset,
            clip_plane_world: request.clip_plane_world,
            ground_height_m: request.ground_height_m,
            roots: scene.roots.clone(),
            lights: scene.lights.clone(),
            water: scene.water.clone(),
            time_secs: time_of(scene),
            scene_version,
        }
    }

    /// Whether [`Self::new`] would give the same.
    fn is_of(&self, request: &FrameRequest, scene: &Scene, scene_version: u64) -> bool {
        self.scene_version == scene_version
            && self.exposure == request.display_exposure()
            && self.light_subset == request.light_subset
            && self.clip_plane_world == request.clip_plane_world
            && self.ground_height_m == request.ground_height_m
            && self.time_secs == time_of(scene)
            && self.settings == request.settings
            && self.lights == scene.lights
            && self.water == scene.water
            && self.roots == scene.roots
    }
}

/// The scene's time, if anything goes by it.
fn time_of(scene: &Scene) -> f32 {
    if scene.water.is_empty() { 0.0 } else { scene.time_secs }
}

/// What a view is asked for that is anti-aliased over time.
#[derive(Clone, Debug)]
pub(super) struct TemporalRequest {
    /// Which frame it is since the beginning.
    index: u32,
    pose: Arc<Pose>,
    last: Option<LastFrame>,
}

impl TemporalRequest {
    /// For a frame of `request`, if it is anti-aliased over time, after the `last` frame of its view; motion is then
    /// since that.
    pub fn new(request: &mut FrameRequest, last: Option<&LastFrame>, scene: &Scene) -> Option<Self> {
        if !request.resolves_over_time() {
            return None;
        }
        // The history of another scene is that of other surfaces.
        let last = last.filter(|last| request.goes_on && last.pose.is_of(scene)).cloned();
        if let Some(last) = &last {
            request.previous = Some(last.pose.clone());
        }
        let index = last.as_ref().map_or(0, |last| last.index.wrapping_add(1));
        let before = last.as_ref().map(|last| &*last.pose);
        let pose = Pose::capture_after(scene, request.camera, before);
        Some(Self { index, pose: Arc::new(pose), last })
    }

    /// Where in each pixel the frame looks, in pixels from its middle: in the middle at first.
    pub fn jitter_px(&self) -> Vec2 {
        view::jitter_px(self.index, u32::MAX)
    }

    /// What its passes need, where the camera went from the last frame by `step`; the scene on the device is that of
    /// the frame.
    pub fn frame(
        &self,
        request: &FrameRequest,
        (scene, scene_version): (&Scene, u64),
        step: Option<CameraStep>,
        upscaled_to: Option<(u32, u32)>,
    ) -> TemporalFrame {
        let shows = |last: &LastFrame| last.shown.is_of(request, scene, scene_version);
        let before = self.last.as_ref().zip(step).map(|(last, camera_step)| PreviousFrames {
            camera_step,
            gain: request.pre_exposure() / last.pre_exposure,
            stands: last.pose == self.pose && shows(last),
        });
        TemporalFrame { exposure: request.display_exposure(), before, upscaled_to }
    }

    /// What the next frame has to know of it.
    pub fn kept(&self, request: &FrameRequest, scene: &Scene, scene_version: u64) -> LastFrame {
        let known = self.last.as_ref().map(|last| &last.shown);
        let known = known.filter(|shown| shown.is_of(request, scene, scene_version)).cloned();
        let shown = known.unwrap_or_else(|| Arc::new(FrameContent::new(request, scene, scene_version)));
        LastFrame { pose: self.pose.clone(), shown, index: self.index, pre_exposure: request.pre_exposure() }
    }
}

impl Renderer {
    /// From now on pictures have nothing to do with those before: the camera jumps, or the scene is another one. What
    /// anti-aliasing over time (`taa.enabled`) keeps of a view that goes on ([`FrameRequest::goes_on`]) is left, and so is
    /// what exposure adapted to (`exposure.adapt`).
    pub fn cut(&mut self) {
        self.views.values_mut().for_each(|view| (view.temporal, view.adapted) = (None, None));
    }
}
