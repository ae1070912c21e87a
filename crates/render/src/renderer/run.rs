//! One frame: its views are made ready, recorded, planned and run.

use super::captures::{Captures, MonitorView, Part};
use super::counts::{light_draws, sum_pairs};
use super::fisheye::{parts_of, uv_from_place};
use super::mirrors::{MirrorSeen, Reflector};
use super::output::{Output, ViewState};
use super::portals::Doors;
use super::prepare::{Asked, Lit, Ready, ViewPart, World, output_of};
use super::shadows::Atlas;
use super::surroundings::{self, SideView};
use super::temporal::{TemporalAsked, move_mirrors};
use super::water::Surfaces;
use super::{Purpose, Renderer};
use crate::aov::AovExports;
use crate::draws::Deformation;
use crate::environment::{Environment, stored};
use crate::frame::{self, Flat, Means, Monitored, Picture};
use crate::gbuffer::ViewOutputs;
use crate::gpu::readback;
use crate::ground::GROUND_MAP;
use crate::mirror_picture::MirrorPicture;
use crate::outline::rectangle_of;
use crate::overlay::Room;
use crate::overlay::draw::OverlayDraw;
use crate::passes::adaptive::Settling;
use crate::passes::fisheye::FaceRadiance;
use crate::passes::mirrors::ShownMirror;
use crate::passes::present::Target;
use crate::passes::{adaptive, meter};
use crate::record::{Frame, Legends, Recorder, Scrubbed};
use crate::request::{FrameRequest, FrameStats, RenderError, SceneDefaults};
use crate::resources::environment::Unfinished;
use crate::resources::monitor_desc;
use manypass_graph::{Export, Graph, Handle, Limits, Plan, Run, RunOptions, Taps, Timing};
use manypass_scene::Scene;
use std::cell::LazyCell;
use std::collections::BTreeMap;

/// A frame that was planned, and run if it was not only to be planned.
struct Executed {
    plan: Plan,
    run: Option<Run>,
    /// What the purpose reads of a frame that is no picture.
    exports: Vec<Export>,
    legends: Legends,
}

/// What recording a view leaves to fetch.
#[derive(Default)]
struct Recorded {
    variables: AovExports,
    export: Option<Export>,
    /// The stops of an exposure that adapts.
    adapted: Option<Export>,
}

impl Renderer {
    /// Runs a frame of `views`, innermost first, for a purpose; those that are no picture have one view.
    pub(super) async fn run(
        &mut self,
        scene: &Scene,
        views: &[(&str, &FrameRequest)],
        purpose: &mut Purpose<'_>,
    ) -> Result<Plan, RenderError> {
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
        let captures = match purpose.has_captures() {
            true => self.captures(scene, parts, purpose.is_plan())?,
            false => Captures { parts, ..Captures::default() },
        };
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
        let mut stats = FrameStats { captures, captures_left_out, ..FrameStats::default() };

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
        let surroundings =
            of_surroundings.and_then(|asked| self.prepare_surroundings(scene, &asked.request, of_environment.as_ref()));
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
            (Some(asked), Some(ready), Some(state)) if shadows.is_some() || !unfinished.is_empty() => {
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
        }
        let mut graph = self.executor.graph(limits);
        if let (Some(view), Some((shadows, atlas))) = (&shared_view, &shadows) {
            let mut r = Recorder::new(&mut graph, &frame, view);
            let texture = r.graph.import("shadows.atlas", Atlas::desc(atlas.side), atlas.view.clone());
            frame::shared_passes(&mut r, shadows, texture)?;
        }
        let mut before = Before::default();
        let mut first_side = None;
        let (water, doors) = (Surfaces::of(scene), Doors::of(scene));
        let mut recorded: Vec<Recorded> = Vec::with_capacity(asked.len());
        for (((asked, state), ready), overlay) in asked.iter().zip(&mut *states).zip(&ready).zip(&overlays) {
            // Those that are captured again have the light of what was captured before.
            let bounce = if let ViewPart::Side(side) = &asked.part { Some(side.bounce) } else { None };
            if before.sides.keys().next().is_some_and(|side| Some(side.bounce) != bounce)
                && let (Some(surroundings), Some(view)) = (&surroundings, first_side)
            {
                let of_state = (&self.surroundings, surroundings, view);
                surroundings::record(&mut graph, &frame, of_state, &mut before.sides)?;
            }
            if bounce == Some(0) {
                // What draws tiles is of a view that has none.
                first_side.get_or_insert(&ready.view);
            }
            // Those at one level see what there was before all of them.
            if before.seen.first().is_some_and(|seen| Some(seen.view.level) != asked.level) {
                record_monitors(&mut graph, &frame, scene, &mut before.seen)?;
            }
            recorded.push(record_view(
                &mut graph,
                &frame,
                (scene, (&water, &doors), asked),
                (ready, overlay),
                (state, &mut before),
                purpose,
            )?);
        }
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
            let target = graph.import("ground.map", GROUND_MAP, ground.texture.clone());
            frame::ground_passes(&mut Recorder::new(&mut graph, &frame, &view), &ground.map, tiles, target)?;
            let plan = graph.plan()?;
            self.executor.run(graph, &plan, &mut first, &RunOptions::default());
        }
        stats.uploaded_bytes += self.uniforms.upload(&self.gpu.queue);
        self.gpu.queue.submit([first.finish(), encoder.finish()]);
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
                    let picture = crate::aov::tap_picture(tap)?;
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

/// What views left for those that follow them.
#[derive(Default)]
struct Before<'f> {
    /// The sides of a fisheye picture.
    faces: Vec<FaceRadiance>,
    /// What cameras of monitors see, which screens do not show yet.
    seen: Vec<Seen<'f>>,
    /// The sides of the pictures around places.
    sides: BTreeMap<SideView, Handle>,
    /// What is behind mirrors, by the names of the views.
    behind: BTreeMap<String, MirrorPicture>,
    /// Radiance of what is seen through portals, by the names of the views.
    through: BTreeMap<String, Handle>,
}

impl Before<'_> {
    /// The mirrors of a view.
    fn mirrors(&mut self, asked: &Asked, ready: &Ready) -> Vec<ShownMirror> {
        let shown = |seen: &MirrorSeen| {
            let Reflector::Node(node) = seen.of else { return None };
            Some(ShownMirror {
                object: node.0 + 1,
                normal_world: seen.normal_world,
                is_smooth: seen.is_smooth,
                rectangle: rectangle_of(&ready.view.uniform, seen.corners_world, ready.view.size),
                picture: self.behind.remove(&seen.view)?,
            })
        };
        asked.mirrors.iter().filter_map(shown).collect()
    }
}

/// What the camera of a monitor sees.
struct Seen<'f> {
    view: &'f MonitorView,
    asked: &'f Asked,
    ready: &'f Ready,
    radiance: Handle,
    depth: Handle,
    means: Means,
    settling: Option<Settling>,
    /// The stops of an exposure that adapts.
    adapted: Option<Handle>,
}

/// Makes screens show what their cameras saw.
fn record_monitors<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    scene: &Scene,
    seen: &mut Vec<Seen<'f>>,
) -> Result<(), RenderError> {
    for Seen { view, asked, ready, radiance, depth, means, settling, adapted } in seen.drain(..) {
        let mut r = Recorder::new(graph, frame, &ready.view);
        let Some(texture) = import_monitor(&mut r, scene, view.image) else { continue };
        let request = &asked.request;
        let monitored = Monitored {
            radiance: &radiance,
            depth: &depth,
            means,
            adaptive_step: adaptive_step(asked, ready),
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

/// Records all passes of a view.
fn record_view<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    (scene, (water, doors), asked): (&Scene, (&Surfaces, &Doors), &'f Asked),
    (ready, overlay): (&'f Ready, &Option<OverlayDraw>),
    (state, before): (&mut ViewState, &mut Before<'f>),
    purpose: &Purpose<'_>,
) -> Result<Recorded, RenderError> {
    let request = &asked.request;
    if matches!(purpose, Purpose::Variables) {
        let mut r = Recorder::new(graph, frame, &ready.view);
        let outputs = frame::variable_passes(&mut r, &ready.variables)?;
        return Ok(Recorded { variables: AovExports::new(r.graph, outputs), ..Recorded::default() });
    }
    let (variables, of_view) = match &ready.variables_view {
        Some(view) => {
            let mut r = Recorder::new(graph, frame, view);
            (Some(frame::variable_passes(&mut r, &ready.variables)?), ready.of_effects)
        }
        None => (None, ready.variables.and(&ready.of_effects)),
    };
    let mut r = Recorder::new(graph, frame, &ready.view);
    if matches!(purpose, Purpose::Pairs(_)) {
        if asked.part.is_fisheye() {
            return Ok(Recorded::default());
        }
        let pairs = frame::pair_passes(&mut r, &request.settings)?;
        return Ok(Recorded { export: Some(r.graph.export(pairs)), ..Recorded::default() });
    }
    let flat = Flat {
        mirrors: before.mirrors(asked, ready),
        water: water.shown((scene, &frame.resources.textures), (asked, ready), &mut before.behind),
        portals: doors.shown(asked, &mut before.through),
    };
    let outputs = match &asked.part {
        ViewPart::Whole => frame::view_passes(&mut r, &request.settings, &of_view, &flat)?,
        ViewPart::Mirror(view) => {
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            let ViewOutputs { radiance, gbuffer, .. } = outputs;
            if let Reflector::Portal(..) = view.of {
                before.through.insert(asked.name.clone(), radiance);
            } else if let Some(gbuffer) = gbuffer {
                let picture = frame::mirror_picture_passes(&mut r, view.is_smooth, radiance, gbuffer.linear_depth)?;
                before.behind.insert(asked.name.clone(), picture);
            }
            return Ok(Recorded::default());
        }
        ViewPart::Side(side) => {
            let ViewOutputs { radiance, .. } = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            before.sides.insert(*side, radiance);
            return Ok(Recorded::default());
        }
        ViewPart::Face(face) => {
            let ViewOutputs { radiance, .. } = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            let uv_from_place = uv_from_place(face, request, asked.size);
            before.faces.push(FaceRadiance { side: face.side, radiance, uv_from_place });
            return Ok(Recorded::default());
        }
        ViewPart::Monitor(view) => {
            for image in &view.darkens {
                let Some(texture) = import_monitor(&mut r, scene, *image) else { continue };
                frame::darken_monitor(&mut r, texture);
            }
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            let outputs = frame::temporal_passes(&mut r, &request.settings, ready.temporal.as_ref(), outputs)?;
            let ViewOutputs { radiance, depth, .. } = outputs;
            let adapting = request.adapting(state.adapted.is_some());
            let adapted = frame::exposure_passes(&mut r, adapting.as_ref(), &radiance)?;
            let (previous_sum, settles) =
                (asked.previous_sum(state), adaptive_step(asked, ready) != adaptive::Step::None);
            let output = if asked.has_output() {
                output_of(frame.gpu, asked, &mut state.output, (purpose, settles))
            } else {
                None
            };
            let means = output.map_or(Means::None, |output| output.means(r.graph, asked.means_of, previous_sum));
            let settling = output.filter(|_| settles).and_then(|output| output.settling(r.graph));
            before.seen.push(Seen { view, asked, ready, radiance, depth, means, settling, adapted });
            return Ok(Recorded::default());
        }
        ViewPart::Fisheye(of_fisheye) => {
            frame::fisheye_passes(&mut r, &of_fisheye.lens, request.sample(), std::mem::take(&mut before.faces))?
        }
    };
    let outputs = frame::temporal_passes(&mut r, &request.settings, ready.temporal.as_ref(), outputs)?;
    let (mut r, outputs) = match &ready.enlarged_view {
        Some(view) => {
            let outputs = frame::enlarged_passes(&mut r, view.size, outputs)?;
            (Recorder::new(graph, frame, view), outputs)
        }
        None => (r, outputs),
    };
    let outputs = frame::effect_passes(&mut r, &request.effects, outputs)?;
    let (mut export, mut adapted) = (None, None);
    let previous_sum = asked.previous_sum(state);
    let step = adaptive_step(asked, ready);
    match output_of(frame.gpu, asked, &mut state.output, (purpose, step != adaptive::Step::None)) {
        None => {
            let meter = meter::record(&mut r, &outputs.radiance)?;
            export = Some(r.graph.export(meter));
        }
        Some(output) => {
            let adapting = request.adapting(state.adapted.is_some());
            let stops = frame::exposure_passes(&mut r, adapting.as_ref(), &outputs.radiance)?;
            let (settings, shaded) = (&request.settings, &outputs.radiance);
            let enlarged =
                frame::upscale_passes(&mut r, settings, request.display_exposure(), shaded, asked.output_size)?;
            let means = output.means(r.graph, asked.means_of, previous_sum);
            let picture = Picture {
                display: output.display(r.graph),
                target: target_of(purpose),
                is_shown: !matches!(purpose, Purpose::Sample),
                sample_index: request.sample_index,
                exposure: request.known_exposure(),
                adapted: stops.as_ref(),
                depth: &outputs.depth,
                adaptive_step: step,
                overlay: overlay.as_ref(),
                settling: if step == adaptive::Step::None { None } else { output.settling(r.graph) },
            };
            let radiance = enlarged.as_ref().unwrap_or(shaded);
            frame::output_passes(&mut r, settings, radiance, means, picture, &request.effects)?;
            adapted = stops.map(|stops| r.graph.export(stops));
        }
    }
    let variables = if asked.wants_variables {
        AovExports::new(r.graph, variables.unwrap_or(outputs))
    } else {
        AovExports::default()
    };
    Ok(Recorded { variables, export, adapted })
}

/// What the view does after this sample.
fn adaptive_step(asked: &Asked, ready: &Ready) -> adaptive::Step {
    if ready.is_adaptive { asked.adaptive_step() } else { adaptive::Step::None }
}

fn target_of<'t>(purpose: &Purpose<'t>) -> Option<&'t Target> {
    if let Purpose::Target(target) = purpose { Some(target) } else { None }
}

/// Fails if a frame may not allocate `needed_bytes`.
fn check_budget(budget_bytes: Option<u64>, needed_bytes: u64) -> Result<(), RenderError> {
    match budget_bytes {
        Some(budget_bytes) if needed_bytes > budget_bytes => Err(RenderError::Memory { needed_bytes, budget_bytes }),
        _ => Ok(()),
    }
}
