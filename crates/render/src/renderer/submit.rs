//! Runs the passes of a frame, submits them, and stores what lasts of it.

use super::Renderer;
use super::ask::{FrameViews, ViewRequest};
use super::drawing::FrameNotes;
use super::ground::FrameGround;
use super::next::NextState;
use super::output::ViewState;
use super::prepare::{MadeCounts, PreparedFrame, check_budget};
use super::purpose::Purpose;
use super::record::{RecordedFrame, record_frame};
use super::record_inputs::{SceneFeatures, ViewExports};
use crate::aov::MissingExport;
use crate::draws::Tile;
use crate::frame;
use crate::gpu::Gpu;
use crate::passes::adaptive;
use crate::record::{Frame, Legends, PreparedView, Recorder, ScrubMasks};
use crate::request::{FrameStats, RenderError};
use manypass_graph::{Executor, Export, Limits, Plan, Run, RunOptions};

/// A frame that was planned, and submitted if it was not only to be planned.
pub(super) struct SubmittedFrame {
    pub plan: Plan,
    pub run: Option<Run>,
    /// What the purpose reads of a frame that is no picture.
    pub exports: Vec<Export>,
    pub legends: Legends,
    /// In how many rounds lights take turns in the atlas of shadow maps.
    pub light_rounds: u32,
}

impl SubmittedFrame {
    /// A frame that is not run.
    pub fn planned(plan: Plan, exports: Vec<Export>, legends: Legends, next: &NextState) -> Self {
        Self { plan, run: None, exports, legends, light_rounds: next.stats.light_rounds.max(1) }
    }
}

/// A run of a frame's passes.
struct FrameRun {
    run: Run,
    /// Of each view.
    views: Vec<ViewExports>,
    /// Bytes of the textures that the run had to create.
    missing_bytes: u64,
}

impl Renderer {
    /// Records and plans the passes of a frame. Unless it is only to be planned, it also runs and submits them, and
    /// stores what lasts.
    pub(super) fn record_and_submit(
        &mut self,
        prepared: PreparedFrame<'_>,
        views: &mut FrameViews,
        mut next: NextState,
        purpose: &Purpose<'_>,
    ) -> Result<SubmittedFrame, RenderError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.copy_surroundings(&prepared, &mut next, &mut encoder);
        let particles = self.simulations.particles(prepared.scene.scene);
        let features = SceneFeatures::new(&prepared, particles, &next.surroundings);
        let notes = FrameNotes { scrubbed: ScrubMasks::new(purpose.counts_scrubbed), ..FrameNotes::default() };
        let frame = self.drawing.frame(&self.gpu, &self.resources, &prepared.scene.draws, &notes);
        let limits = limits_of(&self.gpu);
        let RecordedFrame { graph, plan, views: exported, exports, light_draws } =
            record_frame(self.executor.graph(limits), &frame, &features, &prepared, views, purpose)?;
        if !purpose.is_run {
            return Ok(SubmittedFrame::planned(plan, exports, notes.legends.take(), &next));
        }
        count_plan(&mut next.stats, &plan);
        next.stats.light_draws = light_draws;
        let options = purpose.run_options();
        let missing_bytes = self.executor.missing_bytes(&plan, &options);
        check_budget(self.memory_budget_bytes, prepared.room.needed_bytes + missing_bytes)?;
        let run = self.executor.run(graph, &plan, &mut encoder, &options)?;
        // Done before the frame, but recorded after it, so that frames with it and without it put their uniforms alike.
        let mut first = self.gpu.device.create_command_encoder(&Default::default());
        if let Some(view) = &prepared.shared_view {
            draw_environments(&mut self.executor, limits, (&frame, view), &prepared.unfinished, &mut first)?;
        }
        if let Some((ground, tiles)) =
            prepared.ground.as_ref().and_then(|ground| Some((ground, ground.tiles.as_ref()?)))
            && let Some(view) = self.ground_view(&prepared, views)
        {
            draw_ground(&mut self.executor, limits, (&frame, &view), (ground, tiles), &mut first)?;
        }
        next.stats.uploaded_bytes += self.drawing.uniforms.upload(&self.gpu.queue);
        self.gpu.queue.submit([first.finish(), encoder.finish()]);
        let light_rounds = next.stats.light_rounds;
        let of_frame = FrameRun { run, views: exported, missing_bytes };
        let run = self.commit(of_frame, prepared, views, next, purpose)?;
        Ok(SubmittedFrame { plan, run: Some(run), exports, legends: notes.legends.take(), light_rounds })
    }

    /// Copies what surroundings show that are not captured, where the frame is run.
    fn copy_surroundings(
        &self,
        prepared: &PreparedFrame<'_>,
        next: &mut NextState,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        if prepared.surroundings.is_some() && next.is_run {
            let are_new = !prepared.unfinished.is_empty();
            next.surroundings.copy_environment(encoder, prepared.environment.as_ref(), are_new);
            next.surroundings.copy_pictures(encoder, (prepared.scene.scene, &self.resources), are_new);
        }
    }

    /// What draws the map of the ground.
    fn ground_view(&self, prepared: &PreparedFrame<'_>, views: &FrameViews) -> Option<PreparedView> {
        let (asked, setup, state) = (views.requests.first()?, prepared.setups.first()?, views.states.first()?);
        Some(self.shared_view(asked, setup, state, &self.ground.instances))
    }

    /// Stores what lasts of a frame that was submitted.
    fn commit(
        &mut self,
        of_frame: FrameRun,
        prepared: PreparedFrame<'_>,
        views: &mut FrameViews,
        mut next: NextState,
        purpose: &Purpose<'_>,
    ) -> Result<Run, RenderError> {
        let FrameRun { run, views: exported, missing_bytes } = of_frame;
        if prepared.shared_view.is_some() {
            next.environments.clone_from(&prepared.unfinished);
        }
        let scene = prepared.scene.scene;
        let (setups, made) = (prepared.setups, prepared.made);
        self.world_draws = prepared.scene.draws;
        self.check_drawn()?;
        self.end_frame(&run, &mut next.stats, made, missing_bytes);
        next.commit(self);
        let scene_version = self.shadows.scene_version;
        let FrameViews { requests, states, .. } = views;
        for (((asked, state), setup), exported) in requests.iter().zip(states).zip(&setups).zip(exported) {
            if purpose.draws_picture {
                keep_picture(asked, state, setup.is_adaptive, &exported, purpose.shows_picture);
            }
            if let Some(temporal) = asked.temporal.as_ref().filter(|_| purpose.is_picture) {
                state.temporal = Some(temporal.kept(&asked.request, scene, scene_version));
            }
            if purpose.is_picture {
                state.adapted = exported.adapted.and_then(|adapted| run.exported(adapted).cloned());
            }
            if asked.wants_variables && purpose.keeps_variables {
                let textures = exported.variables.textures(&run, setup.variables_uniform, asked.request.origin_m);
                state.aovs =
                    textures.map_err(|MissingExport| RenderError::Internal("an exported texture is missing"))?;
            }
        }
        if purpose.keeps_variables && requests.iter().any(|asked| asked.wants_variables) {
            self.executor.release_exports(&run);
        }
        Ok(run)
    }

    /// Ends a frame that was submitted, for which textures of so many bytes were missing, with its numbers.
    fn end_frame(&mut self, run: &Run, stats: &mut FrameStats, before: MadeCounts, missing_bytes: u64) {
        // The other runs, of the ground and of environments, export nothing and have no histories.
        self.executor.end_frame(run);
        let MadeCounts { pipelines, textures } = self.made();
        stats.pipelines_made = pipelines - before.pipelines;
        stats.textures_made = textures - before.textures;
        self.drawing.count(stats);
        if missing_bytes > 0 {
            // The executor gave textures of other shapes back, and nobody else shall keep them.
            self.drawing.bind_groups.forget_unused();
        }
    }
}

/// What plans are checked against.
pub(super) fn limits_of(gpu: &Gpu) -> Limits {
    let capabilities = &gpu.capabilities;
    Limits { samples_attached_depth: capabilities.samples_attached_depth, ..Limits::from(&capabilities.limits) }
}

/// Puts the bytes of a plan into the numbers of its frame.
fn count_plan(stats: &mut FrameStats, plan: &Plan) {
    let bytes = plan.bytes();
    (stats.texture_bytes, stats.texture_bytes_unaliased) = (bytes.aliased, bytes.unaliased);
    stats.written_bytes = plan.written_bytes();
}

/// Draws the levels of environments that are new.
fn draw_environments(
    executor: &mut Executor,
    limits: Limits,
    (frame, view): (&Frame<'_>, &PreparedView),
    unfinished: &[usize],
    encoder: &mut wgpu::CommandEncoder,
) -> Result<(), RenderError> {
    for tiles in unfinished.iter().filter_map(|at| frame.resources.environments.get(*at)) {
        let Some(unfinished) = tiles.unfinished() else { continue };
        let mut graph = executor.graph(limits);
        frame::environment_passes(&mut Recorder::new(&mut graph, frame, view), tiles, unfinished)?;
        let plan = graph.plan()?;
        executor.run(graph, &plan, encoder, &RunOptions::default())?;
    }
    Ok(())
}

/// Draws the map of the ground from `tiles`.
fn draw_ground(
    executor: &mut Executor,
    limits: Limits,
    (frame, view): (&Frame<'_>, &PreparedView),
    (ground, tiles): (&FrameGround, &[Tile]),
    encoder: &mut wgpu::CommandEncoder,
) -> Result<(), RenderError> {
    let mut graph = executor.graph(limits);
    let target = graph.import("ground.map", ground.map.texture(), ground.texture.clone());
    frame::ground_passes(&mut Recorder::new(&mut graph, frame, view), &ground.map, tiles, target)?;
    let plan = graph.plan()?;
    executor.run(graph, &plan, encoder, &RunOptions::default())?;
    Ok(())
}

/// Leaves in `state` what a frame that made a picture left of its view.
fn keep_picture(asked: &ViewRequest, state: &mut ViewState, is_adaptive: bool, exported: &ViewExports, is_shown: bool) {
    state.latest_sum = 1 - asked.previous_sum(state);
    state.output.iter_mut().for_each(|output| output.is_drawn = true);
    let goes_on = state.has_settled && asked.request.sample_index > 0;
    let looks = matches!(asked.adaptive_step(), adaptive::Step::Settle { .. });
    (_, state.sample_count) = asked.request.sample();
    state.was_shown = is_shown;
    state.unsettled = state.unsettled.take().filter(|_| goes_on);
    state.has_settled = is_adaptive && (goes_on || looks);
    state.means_of = asked.means_of;
    state.pre_exposure = asked.request.pre_exposure();
    state.has_tint = exported.has_tint;
    state.background_radiance = asked.request.background_radiance();
}
