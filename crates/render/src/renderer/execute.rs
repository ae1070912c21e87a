//! A frame whose views are asked for: they are made ready, recorded, planned and run.

use super::asked::{Asked, ViewPart};
use super::counts::light_draws;
use super::ground::FrameGround;
use super::lit::{Lit, World};
use super::next::NextState;
use super::output::{Output, ViewState};
use super::prepare::Ready;
use super::recording::{OfScene, Recorded, RecordedView, record_views};
use super::shadows::Atlas;
use super::surroundings::FrameSurroundings;
use super::{Purpose, Renderer};
use crate::draws::{Deformation, Tile};
use crate::environment::lobe::FACES;
use crate::frame;
use crate::gpu::Gpu;
use crate::overlay::Room;
use crate::overlay::draw::OverlayDraw;
use crate::passes::adaptive;
use crate::passes::probe_capture::CapturedProbe;
use crate::record::{Frame, Legends, PreparedView, Recorder, Scrubbed};
use crate::request::{FrameStats, RenderError};
use crate::shadows::FrameShadows;
use manypass_graph::{Executor, Export, Limits, Plan, Run, RunOptions, Taps, Timing};
use manypass_scene::Scene;

/// A frame that was planned, and run if it was not only to be planned.
pub(super) struct Executed {
    pub plan: Plan,
    pub run: Option<Run>,
    /// What the purpose reads of a frame that is no picture.
    pub exports: Vec<Export>,
    pub legends: Legends,
}

/// How many pipelines and textures a renderer has made.
#[derive(Clone, Copy)]
struct MadeCounts {
    pipelines: u64,
    textures: u64,
}

/// What the views of a frame are recorded from.
struct FrameParts<'s> {
    world: World<'s>,
    shadows: Option<(FrameShadows, Atlas)>,
    ground: Option<FrameGround>,
    surroundings: Option<FrameSurroundings>,
    /// The tiles of the environment that is around them.
    environment: Option<wgpu::TextureView>,
    ready: Vec<Ready>,
    /// What views around probes show, in their order.
    captured: Vec<Option<CapturedProbe>>,
    overlays: Vec<Option<OverlayDraw>>,
    /// Environments, by their numbers, that are to be drawn.
    unfinished: Vec<usize>,
    /// What draws what all views share, if anything is.
    shared_view: Option<PreparedView>,
    room: Room,
}

impl Renderer {
    /// Runs a frame of views whose captures are known, of which so many were left out.
    pub(super) fn execute(
        &mut self,
        scene: &Scene,
        (asked, captures_left_out): (&[Asked], u32),
        states: &mut [ViewState],
        mut next: NextState,
        purpose: &mut Purpose<'_>,
    ) -> Result<Executed, RenderError> {
        let output_bytes = self.begin_frame((scene, asked), states, purpose)?;
        let made_before = self.made();
        let mut stats = stats_of_captures(asked, captures_left_out);

        let (mut world, has_previous) = self.world(scene, asked, &mut stats);

        let lit: Vec<Lit> = asked
            .iter()
            .zip(&mut *states)
            .map(|(asked, state)| self.light(asked, &mut world, state, &mut stats))
            .collect();
        // What fades has instances that only now are known.
        stats.uploaded_bytes += self.instances.write(&self.gpu, &world.draws.instances);
        let shadows = self.prepare_shadows(asked, &lit, &world, (&mut stats, &mut next), purpose);
        if let Purpose::Rounds(rounds) = purpose {
            *rounds = stats.light_rounds.max(1);
            self.world_draws = world.draws;
            // Nothing is recorded, so that no pipeline is made that the picture may not need.
            let plan = self.executor.graph(limits_of(&self.gpu)).plan()?;
            return Ok(Executed { plan, run: None, exports: Vec::new(), legends: Legends::default() });
        }
        let lit = (world, has_previous, lit, shadows);
        let parts = self.prepare_views((scene, asked), states, lit, (output_bytes, &mut stats), &mut next, purpose)?;
        self.draw((scene, asked), states, parts, (stats, made_before), next, purpose)
    }

    /// Begins what is made anew with each frame, if its pictures have room. Gives the bytes that they take.
    fn begin_frame(
        &mut self,
        (scene, asked): (&Scene, &[Asked]),
        states: &[ViewState],
        purpose: &Purpose<'_>,
    ) -> Result<u64, RenderError> {
        let picture_bytes = missing_output_bytes(asked, states, purpose)?;
        let output_bytes = picture_bytes + self.missing_shadow_bytes(asked, scene);
        check_budget(self.memory_budget_bytes, output_bytes)?;
        // They hold the textures whose place others take. An atlas that grows clears them itself; other textures are
        // destroyed, and bind groups of theirs are no longer found and go after a few frames.
        if picture_bytes > 0 {
            self.bind_groups.clear();
        }
        self.uniforms.begin();
        self.bind_groups.begin();
        self.bundles.begin();
        Ok(output_bytes)
    }

    /// Makes the views of a frame ready whose lights are known, and what they share.
    fn prepare_views<'s>(
        &mut self,
        (scene, asked): (&Scene, &[Asked]),
        states: &mut [ViewState],
        (world, has_previous, lit, shadows): (World<'s>, bool, Vec<Lit>, Option<(FrameShadows, Atlas)>),
        (output_bytes, stats): (u64, &mut FrameStats),
        next: &mut NextState,
        purpose: &Purpose<'_>,
    ) -> Result<FrameParts<'s>, RenderError> {
        let ground = self.prepare_ground(asked, &lit, &world, stats, next);
        let of_surroundings = asked.iter().find(|asked| !matches!(asked.part, ViewPart::Side(_)));
        let environment = of_surroundings.and_then(|asked| self.tiles_of(asked)).map(|tiles| tiles.view.clone());
        let surroundings = of_surroundings
            .and_then(|asked| self.prepare_surroundings(scene, &asked.request, environment.as_ref(), next));
        let ready: Vec<Ready> = asked
            .iter()
            .zip(states.iter_mut().zip(lit))
            .enumerate()
            .map(|(at, (asked, lit))| {
                let of_view = shadows.as_ref().and_then(|(shadows, atlas)| Some((shadows.views.get(at)?, atlas)));
                let of_frame = (of_view, ground.as_ref(), surroundings.as_ref());
                self.ready((scene, &world.draws, asked), lit, of_frame, has_previous, stats)
            })
            .collect();
        let captured = self.captured_probes(scene, asked, surroundings.as_ref());
        let mut room = Room { budget_bytes: self.memory_budget_bytes, needed_bytes: output_bytes };
        let overlays = self.prepare_overlays((scene, asked), states, (&mut room, stats), purpose)?;
        let environments = self.resources.environments.iter().enumerate();
        let unfinished: Vec<usize> =
            environments.filter(|(_, tiles)| tiles.unfinished().is_some()).map(|(at, _)| at).collect();
        let shared_view = match (asked.first(), ready.first(), states.first()) {
            (Some(asked), Some(ready), Some(state))
                if shadows.is_some() || !unfinished.is_empty() || !captured.is_empty() =>
            {
                Some(self.shared_view(asked, ready, state, &self.shadows.instances))
            }
            _ => None,
        };
        Ok(FrameParts {
            world,
            shadows,
            ground,
            surroundings,
            environment,
            ready,
            captured,
            overlays,
            unfinished,
            shared_view,
            room,
        })
    }

    /// What is drawn over the pictures of a frame.
    fn prepare_overlays(
        &self,
        (scene, asked): (&Scene, &[Asked]),
        states: &mut [ViewState],
        (room, stats): (&mut Room, &mut FrameStats),
        purpose: &Purpose<'_>,
    ) -> Result<Vec<Option<OverlayDraw>>, RenderError> {
        asked
            .iter()
            .zip(states.iter_mut())
            .map(|(asked, state)| {
                if asked.part.is_within() || !purpose.shows_picture() {
                    return Ok(None);
                }
                let overlay =
                    state.overlay.prepare((&self.gpu, &self.resources.textures), scene, &asked.request, *room)?;
                stats.uploaded_bytes += overlay.uploaded_bytes;
                room.needed_bytes += overlay.texture_bytes;
                Ok(overlay.draw)
            })
            .collect()
    }

    /// Records, plans and runs the passes of a frame, unless it is only to be planned.
    fn draw(
        &mut self,
        (scene, asked): (&Scene, &[Asked]),
        states: &mut [ViewState],
        parts: FrameParts<'_>,
        (mut stats, made_before): (FrameStats, MadeCounts),
        mut next: NextState,
        purpose: &Purpose<'_>,
    ) -> Result<Executed, RenderError> {
        let FrameParts { world, shadows, ground, surroundings, environment, ready, .. } = parts;
        let FrameParts { captured, overlays, unfinished, shared_view, room, .. } = parts;
        let limits = limits_of(&self.gpu);
        let legends = Legends::default();
        let scrubbed = Scrubbed::new(matches!(purpose, Purpose::Scrubbed(_)));
        let frame = Frame {
            gpu: &self.gpu,
            shaders: &self.shaders,
            surface_pipelines: &self.surface_pipelines,
            resources: &self.resources,
            world: &world.draws,
            tables: &self.tables,
            uniforms: &self.uniforms,
            bind_groups: &self.bind_groups,
            bundles: &self.bundles,
            volumes: &self.volumes,
            decal_marks: &self.decal_marks,
            legends: &legends,
            scrubbed: &scrubbed,
        };
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        if surroundings.is_some() && next.is_run {
            let are_new = !unfinished.is_empty();
            next.surroundings.copy_environment(&mut encoder, environment.as_ref(), are_new);
            next.surroundings.copy_pictures(&mut encoder, (scene, &self.resources), are_new);
        }
        let mut graph = self.executor.graph(limits);
        if let (Some(view), Some((shadows, atlas))) = (&shared_view, &shadows) {
            let mut r = Recorder::new(&mut graph, &frame, view);
            let texture = r.graph.import("shadows.atlas", Atlas::desc(atlas.side), atlas.view.clone());
            frame::shared_passes(&mut r, shadows, texture)?;
        }
        let of_scene = OfScene::new(
            scene,
            self.simulations.particles(scene),
            surroundings.as_ref().map(|of_frame| (&next.surroundings, of_frame)),
            shared_view.as_ref().map(|view| (view, &captured[..])),
        );
        let views = asked.iter().zip(&mut *states).zip(&ready).zip(&overlays);
        let views = views.map(|(((asked, state), ready), overlay)| RecordedView { asked, state, ready, overlay });
        let recorded = record_views(&mut graph, &frame, &of_scene, views, purpose)?;
        let plan = graph.plan()?;
        count_plan(&mut stats, &plan);
        stats.light_draws =
            ready.iter().zip(asked).map(|(ready, asked)| light_draws(&ready.view, asked, &world.draws)).sum();
        let exports = recorded.iter().filter_map(|recorded| recorded.export).chain(scrubbed.exports()).collect();
        if !next.is_run {
            return Ok(Executed { plan, run: None, exports, legends: legends.take() });
        }
        let options = options_of(purpose);
        let missing_bytes = self.executor.missing_bytes(&plan, &options);
        check_budget(self.memory_budget_bytes, room.needed_bytes + missing_bytes)?;
        let run = self.executor.run(graph, &plan, &mut encoder, &options)?;
        // Done before the frame, but recorded after it, so that frames with it and without it put their uniforms alike.
        let mut first = self.gpu.device.create_command_encoder(&Default::default());
        if let Some(view) = &shared_view {
            draw_environments(&mut self.executor, limits, (&frame, view), &unfinished, &mut first)?;
            next.environments = unfinished;
        }
        if let (Some(ground), [asked, ..], [ready, ..], [state, ..]) = (&ground, asked, &ready[..], &*states)
            && let Some(tiles) = &ground.tiles
        {
            let view = self.shared_view(asked, ready, state, &self.ground.instances);
            draw_ground(&mut self.executor, limits, (&frame, &view), (ground, tiles), &mut first)?;
        }
        stats.uploaded_bytes += self.uniforms.upload(&self.gpu.queue);
        self.gpu.queue.submit([first.finish(), encoder.finish()]);
        self.world_draws = world.draws;
        self.check_drawn()?;
        self.end_frame(&run, (stats, made_before), missing_bytes);
        next.commit(self);
        keep((scene, self.shadows.scene_version, asked), states, &ready, recorded, &run, purpose)?;
        if purpose.has_variables() && asked.iter().any(|asked| asked.wants_variables) {
            self.executor.release_exports(&run);
        }
        Ok(Executed { plan, run: Some(run), exports, legends: legends.take() })
    }

    /// How many pipelines and textures were made so far.
    fn made(&self) -> MadeCounts {
        MadeCounts { pipelines: self.shaders.made(), textures: self.executor.textures_made() }
    }

    /// Ends a frame that was submitted, for which textures of so many bytes were missing, with its numbers.
    fn end_frame(&mut self, run: &Run, (mut stats, before): (FrameStats, MadeCounts), missing_bytes: u64) {
        // The other runs, of the ground and of environments, export nothing and have no histories.
        self.executor.end_frame(run);
        let MadeCounts { pipelines, textures } = self.made();
        stats.pipelines_made = pipelines - before.pipelines;
        stats.textures_made = textures - before.textures;
        stats.bind_groups_made = self.bind_groups.made();
        stats.bundles_executed = self.bundles.executed();
        stats.binding_changes = self.bundles.changes();
        if missing_bytes > 0 {
            // The executor gave textures of other shapes back, and nobody else shall keep them.
            self.bind_groups.forget_unused();
        }
        self.stats = stats;
    }

    /// Brings the device up to date with the scene, once for all views. Also says whether it knows where everything was
    /// before.
    fn world<'s>(&mut self, scene: &'s Scene, asked: &[Asked], stats: &mut FrameStats) -> (World<'s>, bool) {
        if let Some(asked) = asked.first() {
            self.limit_textures(asked.request.settings.textures.max_px);
        }
        stats.uploaded_bytes += self.follow(scene);
        if asked.iter().any(|asked| asked.request.settings.lod.reduces_materials()) {
            stats.uploaded_bytes += self.resources.reduce_materials(&self.gpu, scene);
        }
        let mut world = World::new(scene, &self.resources, std::mem::take(&mut self.world_draws));
        self.light_count = world.draws.lit.len();
        let wanting = asked.iter().filter(|asked| asked.request.needs_motion());
        let previous = wanting.filter_map(|asked| asked.request.previous.as_deref()).next();
        let has_previous = previous.is_some_and(|previous| {
            let texels = previous.append_to(scene, &mut world.draws.deformation);
            let written = self.resources.write_previous_nodes(&self.gpu, &texels);
            stats.uploaded_bytes += written.unwrap_or(0);
            written.is_some()
        });
        let Deformation { joint_rows, morph_weights, .. } = &world.draws.deformation;
        stats.uploaded_bytes += self.resources.write_deformation(&self.gpu, joint_rows, morph_weights);
        (world, has_previous)
    }
}

/// The numbers of a frame before anything is drawn: how many of its views are pictures within others.
fn stats_of_captures(asked: &[Asked], captures_left_out: u32) -> FrameStats {
    let is_capture =
        |asked: &&Asked| matches!(asked.part, ViewPart::Monitor(_) | ViewPart::Mirror(_) | ViewPart::Side(_));
    let captures = asked.iter().filter(is_capture).count() as u32;
    let probe_views = asked.iter().filter(|asked| matches!(asked.part, ViewPart::Probe(_))).count();
    let probes_captured = (probe_views / FACES.len()) as u32;
    FrameStats { captures, captures_left_out, probes_captured, ..FrameStats::default() }
}

/// What plans are checked against.
fn limits_of(gpu: &Gpu) -> Limits {
    let capabilities = &gpu.capabilities;
    Limits { samples_attached_depth: capabilities.samples_attached_depth, ..Limits::from(&capabilities.limits) }
}

/// What is measured and kept of a frame for a purpose.
fn options_of(purpose: &Purpose<'_>) -> RunOptions<'static> {
    RunOptions {
        taps: if matches!(purpose, Purpose::Pictures(_)) { Taps::All } else { Taps::None },
        time: if matches!(purpose, Purpose::Times(_)) { Timing::Once } else { Timing::Off },
        leaves_histories: !purpose.is_picture(),
    }
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

/// Bytes of the textures that the pictures of a frame take beyond those that its views have.
///
/// # Errors
/// A sample has nothing to be added to.
fn missing_output_bytes(asked: &[Asked], states: &[ViewState], purpose: &Purpose<'_>) -> Result<u64, RenderError> {
    if purpose.is_picture() && !asked.iter().zip(states).all(|(asked, state)| asked.finds_means(state)) {
        return Err(RenderError::SampleWithoutFirst);
    }
    if purpose.is_plan() || matches!(purpose, Purpose::Meter(_) | Purpose::Pairs(_) | Purpose::Variables) {
        return Ok(0);
    }
    let missing_bytes = |(asked, state): (&Asked, &ViewState)| {
        let settles = asked.request.is_adaptive() && asked.adaptive_step() != adaptive::Step::None;
        Output::missing_bytes(state.output.as_ref(), asked.output_size, asked.means_of, settles)
    };
    let pictures = asked.iter().zip(states).filter(|(asked, _)| asked.has_output());
    Ok(pictures.map(missing_bytes).sum())
}

/// Leaves in `states` what the frame left of their views.
fn keep(
    (scene, scene_version, asked): (&Scene, u64, &[Asked]),
    states: &mut [ViewState],
    ready: &[Ready],
    recorded: Vec<Recorded>,
    run: &Run,
    purpose: &Purpose<'_>,
) -> Result<(), RenderError> {
    for (((asked, state), ready), recorded) in asked.iter().zip(states).zip(ready).zip(recorded) {
        if !matches!(purpose, Purpose::Pairs(_) | Purpose::Meter(_) | Purpose::Variables) {
            state.latest_sum = 1 - asked.previous_sum(state);
            state.output.iter_mut().for_each(|output| output.is_drawn = true);
            let goes_on = state.has_settled && asked.request.sample_index > 0;
            let looks = matches!(asked.adaptive_step(), adaptive::Step::Settle { .. });
            (_, state.sample_count) = asked.request.sample();
            state.was_shown = !matches!(purpose, Purpose::Sample);
            state.unsettled = state.unsettled.take().filter(|_| goes_on);
            state.has_settled = ready.is_adaptive && (goes_on || looks);
            state.means_of = asked.means_of;
            state.pre_exposure = asked.request.pre_exposure();
            state.has_tint = recorded.has_tint;
            state.background_radiance = asked.request.background_radiance();
        }
        if let Some(temporal) = asked.temporal.as_ref().filter(|_| purpose.is_picture()) {
            state.temporal = Some(temporal.kept(&asked.request, scene, scene_version));
        }
        if purpose.is_picture() {
            state.adapted = recorded.adapted.and_then(|adapted| run.exported(adapted).cloned());
        }
        if asked.wants_variables && purpose.has_variables() {
            state.aovs = recorded.variables.textures(run, ready.variables_uniform, asked.request.origin_m)?;
        }
    }
    Ok(())
}

/// Fails if a frame may not allocate `needed_bytes`.
fn check_budget(budget_bytes: Option<u64>, needed_bytes: u64) -> Result<(), RenderError> {
    match budget_bytes {
        Some(budget_bytes) if needed_bytes > budget_bytes => Err(RenderError::Memory { needed_bytes, budget_bytes }),
        _ => Ok(()),
    }
}
