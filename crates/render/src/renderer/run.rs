//! One frame: its views are made ready, recorded, planned and run.

use super::captures::{Captures, Part};
use super::counts::{light_draws, sum_pairs};
use super::fisheye::parts_of;
use super::output::{Output, ViewState};
use super::prepare::{Asked, Lit, Ready, ViewPart, World};
use super::recording::{OfScene, Recorded, RecordedView, record_views};
use super::shadows::Atlas;
use super::temporal::{TemporalAsked, move_mirrors};
use super::{Purpose, Renderer};
use crate::draws::Deformation;
use crate::environment::lobe::FACES;
use crate::environment::{Environment, stored};
use crate::frame;
use crate::gpu::readback;
use crate::overlay::Room;
use crate::overlay::draw::OverlayDraw;
use crate::passes::adaptive;
use crate::record::{Frame, Legends, Recorder, Scrubbed};
use crate::request::{FrameRequest, FrameStats, RenderError, SceneDefaults};
use crate::resources::environment::Unfinished;
use manypass_graph::{Export, Limits, Plan, Run, RunOptions, Taps, Timing};
use manypass_scene::Scene;
use std::cell::LazyCell;

/// A frame that was planned, and run if it was not only to be planned.
struct Executed {
    plan: Plan,
    run: Option<Run>,
    /// What the purpose reads of a frame that is no picture.
    exports: Vec<Export>,
    legends: Legends,
}

impl Renderer {
    /// Runs a frame of `views`, innermost first, for a purpose; those that are no picture have one view.
    pub(super) async fn run(
        &mut self,
        scene: &Scene,
        views: &[(&str, &FrameRequest)],
        purpose: &mut Purpose<'_>,
    ) -> Result<Plan, RenderError> {
        // Samples of an open shutter are at other times than the picture.
        let begins = |request: &FrameRequest| {
            request.sample_index == 0 && (request.settings.camera.shutter_deg == 0.0 || request.sample_count == 1)
        };
        if purpose.goes_on() && views.iter().all(|(_, request)| begins(request)) {
            self.simulate(scene, &mut |_| true)?;
        } else {
            self.follow_simulations(scene)?;
        }
        let capabilities = &self.gpu.capabilities;
        let defaults = LazyCell::new(|| SceneDefaults::of(scene));
        let mut requests: Vec<FrameRequest> = views.iter().map(|(_, request)| request.resolved_by(&defaults)).collect();
        if purpose.has_effects() {
            requests.iter_mut().try_for_each(|request| self.add_effects_to(request))?;
        }
        self.computed.follow(requests.iter().map(|request| &request.settings.environment));
        let parts = views.iter().zip(requests).flat_map(|((name, _), mut request)| {
            // A fisheye is a still, whatever follows it.
            request.settings.allow_taa(purpose.has_effects() && !request.is_fisheye());
            parts_of(name, request, capabilities.max_texture_size)
        });
        let parts: Vec<Part> = parts.collect();
        if purpose.has_captures()
            && !purpose.is_plan()
            && let Some(first) = parts.first().map(|part| &part.request)
            && !first.goes_on
            && first.sample_index == 0
        {
            // Readings of a meter look at what is known, however it was exposed.
            let is_exposed = !matches!(purpose, Purpose::Meter(_));
            self.light_probes(scene, first, is_exposed, &mut |_, _| true).await?;
        }
        let captures = match purpose.has_captures() {
            true => self.captures(scene, parts, purpose),
            false => Ok(Captures { parts, ..Captures::default() }),
        };
        let run = match captures {
            Ok(captures) => self.run_views(scene, captures, purpose).await,
            Err(error) => Err(error),
        };
        if run.is_err() {
            // Nobody knows what of it was drawn.
            self.surroundings.clear();
        }
        run
    }

    /// Runs a frame of views whose captures are known.
    pub(super) async fn run_views(
        &mut self,
        scene: &Scene,
        captures: Captures,
        purpose: &mut Purpose<'_>,
    ) -> Result<Plan, RenderError> {
        let capabilities = &self.gpu.capabilities;
        let left_out = captures.left_out;
        let mut asked: Vec<Asked> = captures
            .parts
            .into_iter()
            .map(|mut part| {
                let settings = &mut part.request.settings;
                // Not before, because it depends on the background, which callers choose afterwards.
                settings.ground.mode =
                    settings.ground.mode.resolved(settings.environment.source, settings.background.source);
                let settings = &part.request.settings.environment;
                let of_scene = scene.environment.clone().filter(|_| settings.source == Environment::File);
                let environment = of_scene.or_else(|| self.computed.of(settings));
                Asked::new(part, environment, purpose, capabilities)
            })
            .collect::<Result<_, _>>()?;
        let is_twice = |(at, view): &(usize, &Asked)| asked.iter().skip(at + 1).any(|other| other.name == view.name);
        if let Some((_, view)) = asked.iter().enumerate().find(is_twice) {
            return Err(RenderError::ViewTwice(view.name.clone()));
        }
        let begins = |asked: &&Asked| purpose.has_variables() && asked.request.sample_index == 0;
        let begun: Vec<&str> = asked.iter().filter(begins).map(|asked| asked.name.as_str()).collect();
        self.forget_variables_of(|name| begun.contains(&name));
        // A plan leaves no trace in what the views keep.
        let mut states: Vec<ViewState> = asked
            .iter()
            .map(|asked| {
                let kept = if purpose.is_plan() { None } else { self.views.remove(&asked.name) };
                kept.unwrap_or_else(|| ViewState::new(&self.gpu))
            })
            .collect();
        for (asked, state) in asked.iter_mut().zip(&states) {
            asked.temporal = TemporalAsked::new(&mut asked.request, state, scene);
        }
        move_mirrors(&mut asked);
        let executed = self.execute(scene, (&asked, left_out), &mut states, purpose);
        if !purpose.is_plan() {
            self.views.extend(asked.iter().map(|asked| asked.name.clone()).zip(states));
        }
        let Executed { plan, run, exports, legends } = executed?;
        if let Some(run) = run {
            self.fetch(run, &exports, &legends, purpose).await?;
            self.keep_environment().await?;
            if purpose.is_picture() {
                self.find_unsettled(&asked).await?;
            }
        }
        Ok(plan)
    }

    /// Finds the rectangles that later samples of stills are added to, after tiles were looked for that are settled. A
    /// live view does not wait for that: there depth alone leaves them out.
    async fn find_unsettled(&mut self, asked: &[Asked]) -> Result<(), RenderError> {
        let has_looked = |asked: &&Asked| matches!(asked.adaptive_step(), adaptive::Step::Settle { .. });
        for asked in asked.iter().filter(has_looked).filter(|asked| !asked.request.goes_on) {
            let Some(state) = self.views.get_mut(&asked.name) else { continue };
            let Some(settled) = state.settled_texture() else { continue };
            let texels = readback::read_texture(&self.gpu, settled).await?;
            state.unsettled = Some(adaptive::unsettled_rectangles(&texels, asked.output_size).into());
        }
        Ok(())
    }

    /// Puts tiles that were drawn into the cache that lacks them.
    async fn keep_environment(&mut self) -> Result<(), RenderError> {
        let Some(cache) = &self.cache else { return Ok(()) };
        for tiles in &mut self.resources.environments {
            if let Some(name) = tiles.take_missing() {
                let texels = readback::read_texture(&self.gpu, tiles.view.texture()).await?;
                cache.put(&name, &stored::entry(&tiles.suns, &texels));
            }
        }
        Ok(())
    }

    fn execute(
        &mut self,
        scene: &Scene,
        (asked, captures_left_out): (&[Asked], u32),
        states: &mut [ViewState],
        purpose: &mut Purpose<'_>,
    ) -> Result<Executed, RenderError> {
        let output_bytes = missing_output_bytes(asked, states, purpose)?;
        let output_bytes = output_bytes + self.missing_shadow_bytes(asked, scene);
        check_budget(self.memory_budget_bytes, output_bytes)?;
        if output_bytes > 0 {
            // They hold the textures whose place others take.
            self.bind_groups.clear();
        }
        self.uniforms.begin();
        self.bind_groups.begin();
        self.bundles.begin();
        let pipelines_made = self.shaders.made();
        let is_capture =
            |asked: &&Asked| matches!(asked.part, ViewPart::Monitor(_) | ViewPart::Mirror(_) | ViewPart::Side(_));
        let captures = asked.iter().filter(is_capture).count() as u32;
        let probe_views = asked.iter().filter(|asked| matches!(asked.part, ViewPart::Probe(_))).count();
        let probes_captured = (probe_views / FACES.len()) as u32;
        let mut stats = FrameStats { captures, captures_left_out, probes_captured, ..FrameStats::default() };

        let (mut world, has_previous) = self.world(scene, asked, &mut stats);

        let lit: Vec<Lit> = asked
            .iter()
            .zip(&mut *states)
            .map(|(asked, state)| self.light(asked, &mut world, state, &mut stats))
            .collect();
        // What fades has instances that only now are known.
        stats.uploaded_bytes += self.instances.write(&self.gpu, &world.draws.instances);
        let shadows = self.prepare_shadows(asked, states, &lit, &world, &mut stats, purpose);
        let capabilities = &self.gpu.capabilities;
        let limits = Limits {
            samples_attached_depth: capabilities.samples_attached_depth,
            ..Limits::from(&capabilities.limits)
        };
        if let Purpose::Rounds(rounds) = purpose {
            *rounds = stats.light_rounds.max(1);
            self.world_draws = world.draws;
            // Nothing is recorded, so that no pipeline is made that the picture may not need.
            let plan = self.executor.graph(limits).plan()?;
            return Ok(Executed { plan, run: None, exports: Vec::new(), legends: Legends::default() });
        }
        let ground = self.prepare_ground(asked, states, &world, &mut stats, purpose.is_plan());
        let of_surroundings = asked.iter().find(|asked| !matches!(asked.part, ViewPart::Side(_)));
        let of_environment = of_surroundings.and_then(|asked| self.tiles_of(asked)).map(|tiles| tiles.view.clone());
        let surroundings = of_surroundings.and_then(|asked| {
            self.prepare_surroundings(scene, &asked.request, of_environment.as_ref(), purpose.is_plan())
        });
        let ready: Vec<Ready> = asked
            .iter()
            .zip(states.iter_mut().zip(lit))
            .enumerate()
            .map(|(at, (asked, lit))| {
                let of_view = shadows.as_ref().and_then(|(shadows, atlas)| Some((shadows.views.get(at)?, atlas)));
                self.ready(
                    (scene, asked),
                    lit,
                    (of_view, ground.as_ref(), surroundings.as_ref()),
                    has_previous,
                    &mut stats,
                )
            })
            .collect::<Result<_, _>>()?;
        let captured = self.captured_probes(scene, asked, surroundings.as_ref());
        let mut room = Room { budget_bytes: self.memory_budget_bytes, needed_bytes: output_bytes };
        let overlays: Vec<Option<OverlayDraw>> = asked
            .iter()
            .zip(states.iter_mut())
            .map(|(asked, state)| {
                if asked.part.is_within() || !purpose.shows_picture() {
                    return Ok(None);
                }
                let overlay =
                    state.overlay.prepare((&self.gpu, &self.resources.textures), scene, &asked.request, room)?;
                stats.uploaded_bytes += overlay.uploaded_bytes;
                room.needed_bytes += overlay.texture_bytes;
                Ok(overlay.draw)
            })
            .collect::<Result<_, RenderError>>()?;
        // A plan leaves environments as they are.
        let environments = self.resources.environments.iter_mut().enumerate().filter(|_| !purpose.is_plan());
        let unfinished: Vec<(usize, Unfinished)> =
            environments.filter_map(|(at, tiles)| Some((at, tiles.take_unfinished()?))).collect();
        let shared_view = match (asked.first(), ready.first(), states.first()) {
            (Some(asked), Some(ready), Some(state))
                if shadows.is_some() || !unfinished.is_empty() || !captured.is_empty() =>
            {
                Some(self.shared_view(asked, ready, state, &self.shadows.instances))
            }
            _ => None,
        };

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
        for (at, unfinished) in &unfinished {
            let (Some(view), Some(tiles)) = (&shared_view, self.resources.environments.get(*at)) else { continue };
            let mut graph = self.executor.graph(limits);
            frame::environment_passes(&mut Recorder::new(&mut graph, &frame, view), tiles, unfinished)?;
            let plan = graph.plan()?;
            self.executor.run(graph, &plan, &mut encoder, &RunOptions::default());
        }
        if surroundings.is_some() && !purpose.is_plan() {
            self.surroundings.copy_environment(&mut encoder, of_environment.as_ref(), !unfinished.is_empty());
            self.surroundings.copy_pictures(&mut encoder, (scene, &self.resources), !unfinished.is_empty());
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
            surroundings.as_ref().map(|of_frame| (&self.surroundings, of_frame)),
            shared_view.as_ref().map(|view| (view, &captured[..])),
        );
        let views = asked.iter().zip(&mut *states).zip(&ready).zip(&overlays);
        let views = views.map(|(((asked, state), ready), overlay)| RecordedView { asked, state, ready, overlay });
        let recorded = record_views(&mut graph, &frame, &of_scene, views, purpose)?;
        let plan = graph.plan()?;
        let bytes = plan.bytes();
        (stats.texture_bytes, stats.texture_bytes_unaliased) = (bytes.aliased, bytes.unaliased);
        stats.written_bytes = plan.written_bytes();
        stats.light_draws =
            ready.iter().zip(asked).map(|(ready, asked)| light_draws(&ready.view, asked, &world.draws)).sum();
        let exports = recorded.iter().filter_map(|recorded| recorded.export).chain(scrubbed.exports()).collect();
        if purpose.is_plan() {
            return Ok(Executed { plan, run: None, exports, legends: legends.take() });
        }
        let options = RunOptions {
            taps: if matches!(purpose, Purpose::Pictures(_)) { Taps::All } else { Taps::None },
            time: if matches!(purpose, Purpose::Times(_)) { Timing::Once } else { Timing::Off },
            leaves_histories: !purpose.is_picture(),
        };
        let missing_bytes = self.executor.missing_bytes(&plan, &options);
        check_budget(self.memory_budget_bytes, room.needed_bytes + missing_bytes)?;
        let run = self.executor.run(graph, &plan, &mut encoder, &options);
        // Done before the frame, but recorded after it, so that frames with it and without it put their uniforms alike.
        let mut first = self.gpu.device.create_command_encoder(&Default::default());
        if let (Some(ground), [asked, ..], [ready, ..], [state, ..]) = (&ground, asked, &ready[..], &*states)
            && let Some(tiles) = &ground.tiles
        {
            let view = self.shared_view(asked, ready, state, &self.ground.instances);
            let mut graph = self.executor.graph(limits);
            let target = graph.import("ground.map", ground.map.texture(), ground.texture.clone());
            frame::ground_passes(&mut Recorder::new(&mut graph, &frame, &view), &ground.map, tiles, target)?;
            let plan = graph.plan()?;
            self.executor.run(graph, &plan, &mut first, &RunOptions::default());
        }
        stats.uploaded_bytes += self.uniforms.upload(&self.gpu.queue);
        self.gpu.queue.submit([first.finish(), encoder.finish()]);
        self.executor.destroy_given_back(&run);
        stats.bind_groups_made = self.bind_groups.made();
        stats.bundles_executed = self.bundles.executed();
        stats.binding_changes = self.bundles.changes();
        if missing_bytes > 0 {
            // The executor gave textures of other shapes back, and nobody else shall keep them.
            self.bind_groups.forget_unused();
        }
        self.world_draws = world.draws;
        stats.pipelines_made = self.shaders.made() - pipelines_made;
        self.stats = stats;
        self.gpu.check()?;

        keep((scene, self.shadows.scene_version, asked), states, &ready, recorded, &run, purpose)?;
        if purpose.has_variables() && asked.iter().any(|asked| asked.wants_variables) {
            self.executor.release_exports(&run);
        }
        Ok(Executed { plan, run: Some(run), exports, legends: legends.take() })
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
        let Deformation { joint_rows, morph_weights } = &world.draws.deformation;
        stats.uploaded_bytes += self.resources.write_deformation(&self.gpu, joint_rows, morph_weights);
        (world, has_previous)
    }

    /// Reads what the purpose is for.
    #[cfg_attr(target_arch = "wasm32", allow(unused_variables, reason = "a browser reads no pictures of passes"))]
    async fn fetch(
        &self,
        run: Run,
        exports: &[Export],
        legends: &Legends,
        purpose: &mut Purpose<'_>,
    ) -> Result<(), RenderError> {
        for export in exports {
            let texture = run.exported(*export).ok_or(RenderError::Missing("an exported texture is missing"))?;
            let bytes = readback::read_texture(&self.gpu, texture).await?;
            match &mut *purpose {
                Purpose::Scrubbed(count) => {
                    let values = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
                    *count += values.filter(|value| *value > 0.5).count() as u64;
                }
                Purpose::Pairs(counts) => *counts += sum_pairs(&bytes, texture.format()),
                Purpose::Meter(pixels) => {
                    *pixels = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
                }
                _ => (),
            }
        }
        #[cfg(not(target_arch = "wasm32"))]
        match purpose {
            Purpose::Pictures(pictures) => {
                let report = run.read(&self.gpu.device);
                let picture = |tap| {
                    let picture = crate::aov::tap_picture(tap, legends.texels.of(&tap.texture))?;
                    Some(crate::request::PassPicture { legend: legends.of(&tap.pass), ..picture })
                };
                *pictures = report.taps.iter().filter_map(picture).collect();
            }
            Purpose::Times(times) => *times = run.read(&self.gpu.device).passes,
            _ => (),
        }
        Ok(())
    }
}

/// Bytes of the textures that the pictures of a frame take beyond those that its views have.
///
/// # Errors
/// A sample has nothing to be added to.
fn missing_output_bytes(asked: &[Asked], states: &[ViewState], purpose: &Purpose<'_>) -> Result<u64, RenderError> {
    if purpose.is_picture() && !asked.iter().zip(states).all(|(asked, state)| asked.finds_means(state)) {
        return Err(RenderError::Missing(
            "there is no mean for this sample to be added to: all samples of a picture have one size, one \
             `sample_count` and one `averaging`",
        ));
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
            state.aovs = recorded.variables.textures(run, ready.variables_uniform)?;
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
