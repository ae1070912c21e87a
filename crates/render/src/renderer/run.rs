//! One frame: what its views are asked for, and what is read of it afterwards.

use super::asked::Asked;
use super::captures::{Captures, Part};
use super::counts::sum_pairs;
use super::execute::Executed;
use super::fisheye::parts_of;
use super::next::NextState;
use super::output::{Unsettled, ViewState};
use super::temporal::{TemporalAsked, move_mirrors};
use super::{Purpose, Renderer};
use crate::draws::UnsettledTiles;
use crate::environment::{Environment, stored};
use crate::gpu::readback;
use crate::passes::adaptive;
use crate::record::Legends;
use crate::request::{FrameRequest, RenderError, SceneDefaults};
use manypass_graph::{Export, Plan, Run};
use manypass_scene::Scene;
use std::cell::LazyCell;

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
        let mut next = NextState::of(self, purpose);
        let captures = match purpose.has_captures() {
            true => self.captures(scene, parts, purpose, &mut next)?,
            false => Captures { parts, ..Captures::default() },
        };
        self.run_views(scene, captures, next, purpose).await
    }

    /// Runs a frame of views whose captures are known. What it leaves for the next one is `next`, once it is submitted.
    pub(super) async fn run_views(
        &mut self,
        scene: &Scene,
        captures: Captures,
        next: NextState,
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
                let kept = if next.is_run { self.views.remove(&asked.name) } else { None };
                let mut state = kept.unwrap_or_else(|| ViewState::new(&self.gpu));
                state.is_within = asked.part.is_within();
                state
            })
            .collect();
        for (asked, state) in asked.iter_mut().zip(&states) {
            asked.temporal = TemporalAsked::new(&mut asked.request, state, scene);
        }
        move_mirrors(&mut asked);
        let is_run = next.is_run;
        let executed = self.execute(scene, (&asked, left_out), &mut states, next, purpose);
        if executed.is_err() {
            states.iter_mut().for_each(ViewState::forget_undrawn);
            self.gpu.forget_refused();
        }
        if is_run {
            self.views.extend(asked.iter().map(|asked| asked.name.clone()).zip(states));
        }
        if matches!(executed, Err(RenderError::Gpu(_))) {
            // Nobody knows what was drawn of what anti-aliasing over time keeps.
            self.cut();
        }
        let Executed { plan, run, exports, legends } = executed?;
        if let Some(run) = run {
            self.forget_gone_views(scene, &asked);
            self.fetch(run, &exports, &legends, purpose).await?;
            self.keep_environment().await?;
            if purpose.is_picture() {
                self.find_unsettled(&asked).await?;
            }
        }
        Ok(plan)
    }

    /// Finds the parts of pictures that later samples of stills are added to, after tiles were looked for that are
    /// settled. A live view does not wait for that: there depth alone leaves them out.
    async fn find_unsettled(&mut self, asked: &[Asked]) -> Result<(), RenderError> {
        let has_looked = |asked: &&Asked| matches!(asked.adaptive_step(), adaptive::Step::Settle { .. });
        for asked in asked.iter().filter(has_looked).filter(|asked| !asked.request.goes_on) {
            let Some(state) = self.views.get_mut(&asked.name) else { continue };
            let Some(settled) = state.settled_texture() else { continue };
            let texels = readback::read_texture(&self.gpu, settled).await?;
            state.unsettled = Some(Unsettled {
                rectangles: adaptive::unsettled_rectangles(&texels, asked.output_size).into(),
                tiles: UnsettledTiles::new(&texels, asked.output_size).into(),
            });
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
            let texture = run.exported(*export).ok_or(RenderError::Internal("an exported texture is missing"))?;
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
