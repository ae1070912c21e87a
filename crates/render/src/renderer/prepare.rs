//! Everything that the views of a frame are recorded from: the scene on the device, draws, lights, shadows, uniforms.

use super::Renderer;
use super::ask::{FrameViews, ViewRequest};
use super::ground::FrameGround;
use super::next::NextState;
use super::output::{Output, ViewState};
use super::prepare_view::{SharedInputs, ViewSetup};
use super::purpose::Purpose;
use super::shadows::Atlas;
use super::surroundings::FrameSurroundings;
use super::visible::{FrameScene, VisibleSet};
use crate::draws::WorldDraws;
use crate::environment::lobe::FACES;
use crate::fisheye::FisheyeLens;
use crate::overlay::draw::OverlayDraw;
use crate::overlay::{OverlayView, Room};
use crate::passes::adaptive;
use crate::passes::probe_capture::CapturedProbe;
use crate::pose::Deformation;
use crate::record::PreparedView;
use crate::request::{FrameStats, RenderError};
use crate::shadows::FrameShadows;
use manypass_scene::Scene;

/// How many pipelines and textures a renderer has made.
#[derive(Clone, Copy)]
pub(super) struct MadeCounts {
    pub pipelines: u64,
    pub textures: u64,
}

/// What is known of a frame as it begins.
pub(super) struct FrameStart {
    /// Bytes that its pictures and shadow maps take beyond those that there are.
    pub output_bytes: u64,
    pub made: MadeCounts,
}

/// The scene as a frame draws it, before its views are prepared.
pub(super) struct PreparedScene<'s> {
    pub scene: FrameScene<'s>,
    /// Of each view.
    pub visible: Vec<VisibleSet>,
    pub shadows: Option<(FrameShadows, Atlas)>,
}

/// What the views of a frame are recorded from.
pub(super) struct PreparedFrame<'s> {
    pub scene: FrameScene<'s>,
    pub shadows: Option<(FrameShadows, Atlas)>,
    pub ground: Option<FrameGround>,
    pub surroundings: Option<FrameSurroundings>,
    /// The tiles of the environment that is around them.
    pub environment: Option<wgpu::TextureView>,
    /// Of each view.
    pub setups: Vec<ViewSetup>,
    /// What views around probes show, in their order.
    pub captured: Vec<Option<CapturedProbe>>,
    /// Of each view.
    pub overlays: Vec<Option<OverlayDraw>>,
    /// Environments, by their numbers, that are to be drawn.
    pub unfinished: Vec<usize>,
    /// What draws what all views share, if anything is.
    pub shared_view: Option<PreparedView>,
    pub room: Room,
    /// What had been made before.
    pub made: MadeCounts,
}

impl Renderer {
    /// Begins what is made anew with each frame, if its pictures have room.
    pub(super) fn begin_frame(
        &mut self,
        scene: &Scene,
        views: &FrameViews,
        purpose: &Purpose<'_>,
    ) -> Result<FrameStart, RenderError> {
        let picture_bytes = missing_output_bytes(views, purpose)?;
        let output_bytes = picture_bytes + self.missing_shadow_bytes(&views.requests, scene);
        check_budget(self.memory_budget_bytes, output_bytes)?;
        // They hold the textures whose place others take. An atlas that grows clears them itself; other textures are
        // destroyed, and bind groups of theirs are no longer found and go after a few frames.
        if picture_bytes > 0 {
            self.drawing.bind_groups.clear();
        }
        self.drawing.begin_frame();
        Ok(FrameStart { output_bytes, made: self.made() })
    }

    /// Brings the device up to date with the scene, and finds what each view draws, its lights and their shadows.
    pub(super) fn prepare_scene<'s>(
        &mut self,
        scene: &'s Scene,
        views: &mut FrameViews,
        next: &mut NextState,
        purpose: &Purpose<'_>,
    ) -> PreparedScene<'s> {
        let FrameViews { requests, states, captures_left_out } = views;
        next.stats = stats_of_captures(requests, *captures_left_out);
        let mut scene = self.frame_scene(scene, requests, &mut next.stats);
        // What the device refuses from here on is nothing of the scene.
        self.gpu.begin_frame();
        let mut visible = Vec::with_capacity(requests.len());
        for (asked, state) in requests.iter().zip(states) {
            visible.push(self.visible_set(asked, &mut scene, state, &mut next.stats));
        }
        // What fades has instances that only now are known.
        let WorldDraws { instances, .. } = &scene.draws;
        let version = scene.draws.instances_version();
        next.stats.uploaded_bytes += self.instances.write_version(&self.gpu, instances, version);
        (next.stats.items_posed, next.stats.draw_lists_made) = (scene.draws.items_posed(), scene.draws.lists_made());
        let shadows = self.prepare_shadows(requests, &visible, &scene, next, purpose);
        PreparedScene { scene, visible, shadows }
    }

    /// Prepares the views of a frame, and what they share.
    pub(super) fn prepare_views<'s>(
        &mut self,
        prepared: PreparedScene<'s>,
        views: &mut FrameViews,
        start: FrameStart,
        next: &mut NextState,
        purpose: &Purpose<'_>,
    ) -> Result<PreparedFrame<'s>, RenderError> {
        let PreparedScene { scene, visible, shadows } = prepared;
        let requests = &views.requests;
        let ground = self.prepare_ground(requests, &visible, &scene, next);
        let of_surroundings = requests.iter().find(|asked| asked.kind.bounce.is_none());
        let environment = of_surroundings.and_then(|asked| self.tiles_of(asked)).map(|tiles| tiles.view.clone());
        let surroundings = of_surroundings.and_then(|asked| {
            self.prepare_surroundings(
                scene.scene,
                &asked.request,
                environment.as_ref(),
                (&mut next.surroundings, next.is_run),
            )
        });
        let mut setups = Vec::with_capacity(requests.len());
        for (at, (asked, of_view)) in requests.iter().zip(views.states.iter_mut().zip(visible)).enumerate() {
            let shared = SharedInputs {
                shadows: shadows.as_ref().and_then(|(shadows, atlas)| Some((shadows.views.get(at)?, atlas))),
                ground: ground.as_ref(),
                surroundings: surroundings.as_ref(),
            };
            setups.push(self.setup(&scene, asked, of_view, &shared, &mut next.stats));
        }
        let captured = self.captured_probes(scene.scene, requests, surroundings.as_ref());
        let mut room = Room { budget_bytes: self.memory_budget_bytes, needed_bytes: start.output_bytes };
        let overlays = self.prepare_overlays(scene.scene, views, &mut room, next, purpose)?;
        let environments = self.resources.environments.iter().enumerate();
        let unfinished: Vec<usize> =
            environments.filter(|(_, tiles)| tiles.unfinished().is_some()).map(|(at, _)| at).collect();
        let is_shared = shadows.is_some() || !unfinished.is_empty() || !captured.is_empty();
        let shared_view = match (views.requests.first(), setups.first(), views.states.first()) {
            (Some(asked), Some(setup), Some(state)) if is_shared => {
                Some(self.shared_view(asked, setup, state, &self.shadows.instances))
            }
            _ => None,
        };
        Ok(PreparedFrame {
            scene,
            shadows,
            ground,
            surroundings,
            environment,
            setups,
            captured,
            overlays,
            unfinished,
            shared_view,
            room,
            made: start.made,
        })
    }

    /// What is drawn over the pictures of a frame.
    fn prepare_overlays(
        &self,
        scene: &Scene,
        views: &mut FrameViews,
        room: &mut Room,
        next: &mut NextState,
        purpose: &Purpose<'_>,
    ) -> Result<Vec<Option<OverlayDraw>>, RenderError> {
        let mut overlays = Vec::with_capacity(views.requests.len());
        for (asked, state) in views.requests.iter().zip(&mut views.states) {
            if asked.kind.is_within || !purpose.shows_picture {
                overlays.push(None);
                continue;
            }
            let request = &asked.request;
            let size_px = (request.width, request.height);
            let lens = FisheyeLens::new(&request.settings.camera, size_px);
            let view = OverlayView { overlay: &request.overlay, camera: &request.camera, size_px, lens };
            let overlay = state.overlay.prepare((&self.gpu, &self.resources.textures), scene, view, *room)?;
            next.stats.uploaded_bytes += overlay.uploaded_bytes;
            room.needed_bytes += overlay.texture_bytes;
            overlays.push(overlay.draw);
        }
        Ok(overlays)
    }

    /// How many pipelines and textures were made so far.
    pub(super) fn made(&self) -> MadeCounts {
        MadeCounts { pipelines: self.drawing.shaders.made(), textures: self.executor.textures_made() }
    }

    /// Brings the device up to date with the scene, once for all views.
    fn frame_scene<'s>(&mut self, scene: &'s Scene, asked: &[ViewRequest], stats: &mut FrameStats) -> FrameScene<'s> {
        if let Some(asked) = asked.first() {
            self.limit_textures(asked.request.settings.textures.max_px);
        }
        stats.uploaded_bytes += self.follow(scene);
        if asked.iter().any(|asked| asked.request.settings.lod.reduces_materials()) {
            stats.uploaded_bytes += self.resources.reduce_materials(&self.gpu, scene);
        }
        let mut world = FrameScene::new(scene, &self.resources, std::mem::take(&mut self.world_draws));
        self.faults.light_count = world.draws.lit.len();
        let wanting = asked.iter().filter(|asked| asked.request.needs_motion());
        let previous = wanting.filter_map(|asked| asked.request.previous.as_deref()).next();
        world.has_previous = previous.is_some_and(|previous| {
            let deformation = &mut world.draws.deformation;
            let written = self.resources.write_previous_nodes(&self.gpu, (scene, previous), deformation);
            stats.uploaded_bytes += written.unwrap_or(0);
            written.is_some()
        });
        let Deformation { joint_rows, morph_weights, .. } = &world.draws.deformation;
        stats.uploaded_bytes += self.resources.write_deformation(&self.gpu, joint_rows, morph_weights);
        world
    }
}

/// The numbers of a frame before anything is drawn: how many of its views are pictures within others.
fn stats_of_captures(requests: &[ViewRequest], captures_left_out: u32) -> FrameStats {
    let captures = requests.iter().filter(|asked| asked.kind.is_capture).count() as u32;
    let probe_views = requests.iter().filter(|asked| asked.kind.is_around).count();
    let probes_captured = (probe_views / FACES.len()) as u32;
    FrameStats { captures, captures_left_out, probes_captured, ..FrameStats::default() }
}

/// Bytes of the textures that the pictures of a frame take beyond those that its views have.
///
/// # Errors
/// A sample has nothing to be added to.
fn missing_output_bytes(views: &FrameViews, purpose: &Purpose<'_>) -> Result<u64, RenderError> {
    let FrameViews { requests, states, .. } = views;
    if purpose.is_picture && !requests.iter().zip(states).all(|(asked, state)| asked.finds_means(state)) {
        return Err(RenderError::SampleWithoutFirst);
    }
    if !purpose.is_run || !purpose.draws_picture {
        return Ok(0);
    }
    let missing_bytes = |(asked, state): (&ViewRequest, &ViewState)| {
        let settles = asked.request.is_adaptive() && asked.adaptive_step() != adaptive::Step::None;
        Output::missing_bytes(state.output.as_ref(), asked.output_size, asked.means_of, settles)
    };
    let pictures = requests.iter().zip(states).filter(|(asked, _)| asked.has_output());
    Ok(pictures.map(missing_bytes).sum())
}

/// Fails if a frame may not allocate `needed_bytes`.
pub(super) fn check_budget(budget_bytes: Option<u64>, needed_bytes: u64) -> Result<(), RenderError> {
    match budget_bytes {
        Some(budget_bytes) if needed_bytes > budget_bytes => Err(RenderError::Memory { needed_bytes, budget_bytes }),
        _ => Ok(()),
    }
}
