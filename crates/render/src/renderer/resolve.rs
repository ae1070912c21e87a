//! From what a caller asks for to the views of a frame, whose settings all have values.

use super::Renderer;
use super::fisheye::parts_of;
use super::mirrors::{Mirrors, VIEWS_MAX};
use super::next::NextState;
use super::part::{Captures, PlannedView};
use super::purpose::Purpose;
use crate::request::{FrameRequest, RenderError, SceneDefaults};
use manypass_scene::Scene;
use std::cell::LazyCell;
use std::collections::BTreeSet;

/// The views of a frame, and what the frame leaves for the next one once it is submitted.
pub(super) struct ResolvedFrame {
    pub captures: Captures,
    pub next: NextState,
}

impl Renderer {
    /// Steps simulations, gives values to settings that are `auto` or `scene`, and adds the views that fisheyes, monitors,
    /// mirrors, portals and probes need.
    pub(super) async fn resolve(
        &mut self,
        scene: &Scene,
        views: &[(&str, &FrameRequest)],
        purpose: &Purpose<'_>,
    ) -> Result<ResolvedFrame, RenderError> {
        // Samples of an open shutter are at other times than the picture.
        let begins = |request: &FrameRequest| {
            request.sample_index == 0 && (request.settings.camera.shutter_deg == 0.0 || request.sample_count == 1)
        };
        if purpose.steps_simulations && views.iter().all(|(_, request)| begins(request)) {
            self.simulate(scene, &mut |_| true)?;
        } else {
            self.follow_simulations(scene)?;
        }
        let parts = self.resolve_parts(scene, views, purpose)?;
        if purpose.draws_captures
            && purpose.is_run
            && let Some(first) = parts.first().map(|part| &part.request)
            && !first.goes_on
            && first.sample_index == 0
        {
            // Readings of a meter look at what is known, however it was exposed.
            self.light_probes(scene, first, purpose.is_exposed, &mut |_, _| true).await?;
        }
        let mut next = NextState::of(self, purpose);
        let captures = match purpose.draws_captures {
            true => self.captures(scene, parts, purpose, &mut next)?,
            false => Captures { parts, ..Captures::default() },
        };
        Ok(ResolvedFrame { captures, next })
    }

    /// The views that pictures are made of: one each, or those of a fisheye.
    fn resolve_parts(
        &mut self,
        scene: &Scene,
        views: &[(&str, &FrameRequest)],
        purpose: &Purpose<'_>,
    ) -> Result<Vec<PlannedView>, RenderError> {
        let defaults = LazyCell::new(|| SceneDefaults::of(scene));
        let mut requests: Vec<FrameRequest> = views.iter().map(|(_, request)| request.resolved_by(&defaults)).collect();
        if purpose.draws_picture {
            requests.iter_mut().try_for_each(|request| self.add_effects_to(request))?;
        }
        self.computed.follow(requests.iter().map(|request| &request.settings.environment));
        let limit_px = self.gpu.capabilities.max_texture_size;
        let parts = views.iter().zip(requests).flat_map(|((name, _), mut request)| {
            // A fisheye is a still, whatever follows it.
            request.settings.allow_taa(purpose.draws_picture && !request.is_fisheye());
            parts_of(name, request, limit_px)
        });
        Ok(parts.collect())
    }

    /// `parts`, and the views of what they show of monitors and mirrors. Whose turn it was is in `next`.
    ///
    /// # Errors
    /// A monitor or mirror asks for a tier of quality that there is not.
    fn captures(
        &mut self,
        scene: &Scene,
        parts: Vec<PlannedView>,
        purpose: &Purpose<'_>,
        next: &mut NextState,
    ) -> Result<Captures, RenderError> {
        let Some(first) = parts.first().map(|part| part.request.clone()) else { return Ok(Captures::default()) };
        if !first.settings.captures.enabled {
            return Ok(Captures { parts, ..Captures::default() });
        }
        let mirrors = Mirrors::of(scene, self.gpu.capabilities.max_texture_size);
        let depth = first.settings.captures.depth.max(1);
        let (mut drawn, mut shown) = (0, BTreeSet::new());
        let of_picture = mirrors.before(scene, parts, depth, (&mut drawn, &mut shown))?;
        let (monitors, monitors_left_out) = self.monitors(scene, &of_picture, &mut next.captures)?;
        // A meter exposes its readings otherwise than pictures are.
        let mut all = if purpose.is_exposed { self.probe_parts(scene, &first, next) } else { Vec::new() };
        all.extend(self.sides(scene, &first, &mut next.surroundings)?);
        all.extend(mirrors.before(scene, monitors, depth, (&mut drawn, &mut shown))?);
        all.extend(of_picture);
        let beyond = drawn.saturating_sub(VIEWS_MAX) as u32;
        let left_out = monitors_left_out + (mirrors.len() - shown.len()) as u32 + beyond;
        Ok(Captures { parts: all, left_out })
    }
}
