//! What a frame is asked for of each view, checked.

use super::Renderer;
use super::output::{MeansOf, ViewState};
use super::part::{Captures, PlannedView};
use super::purpose::Purpose;
use super::temporal::TemporalRequest;
use super::view_kind::{MirrorLink, ViewKind};
use crate::environment::{Environment, studio};
use crate::gpu::Capabilities;
use crate::lens::SampleView;
use crate::lights::Rectangle;
use crate::outline::{Outline, rectangle_of};
use crate::passes::adaptive;
use crate::passes::upscale::UpscaleMethod;
use crate::request::{FrameRequest, RenderError};
use crate::view::{DepthRange, ViewUniform};
use glam::{Vec2, Vec4};
use manypass_scene::{EnvironmentLight, EnvironmentMap, Scene};
use std::sync::Arc;

/// For how many samples textures are filtered where frames before add theirs.
const TEMPORAL_SAMPLES: u32 = 4;

/// One view of the frame, as it was asked for.
pub(super) struct ViewRequest {
    pub name: String,
    pub request: FrameRequest,
    /// The picture of its environment, if that is one.
    pub environment: Option<Arc<EnvironmentMap>>,
    /// The light that the environment brings, turned and scaled.
    pub environment_light: Option<EnvironmentLight>,
    /// The size at which it is shaded; the picture itself is as large as the request says.
    pub size: (u32, u32),
    pub output_size: (u32, u32),
    pub means_of: MeansOf,
    /// The passes that its variables need, and whether any variable is wanted.
    pub wants_variables: bool,
    /// Whether pairs of light and what it may reach are counted in place of light.
    pub counts_pairs: bool,
    pub kind: ViewKind,
    /// The mirrors that it shows.
    pub mirrors: Vec<MirrorLink>,
    /// In how many other pictures the monitor is seen for whose sake it is drawn.
    pub level: Option<u32>,
    /// What is known of the frames before, if it is anti-aliased by them.
    pub temporal: Option<TemporalRequest>,
    /// By how many of its pixels a view behind a mirror is moved with the view that shows it, for the sake of the latter's
    /// other frames.
    pub viewer_jitter_px: Vec2,
}

impl ViewRequest {
    pub fn new(
        PlannedView { name, request, kind, mirrors, level }: PlannedView,
        environment: Option<Arc<EnvironmentMap>>,
        purpose: &Purpose<'_>,
        capabilities: &Capabilities,
    ) -> Result<Self, RenderError> {
        request.settings.check()?;
        if request.settings.camera.f_stop > 0.0 && request.samples_lens_or_shutter() && request.camera.is_orthographic()
        {
            return Err(RenderError::ParallelLens);
        }
        if !kind.draws_surfaces && request.camera.is_orthographic() {
            return Err(RenderError::Fisheye("needs a camera with perspective, and this one has parallel rays"));
        }
        if !kind.draws_surfaces && (!request.want_aovs.is_empty() || purpose.draws_variables_alone) {
            return Err(RenderError::Fisheye("has no variables (AOVs)"));
        }
        let limit = capabilities.max_texture_size;
        // The views are shaded at that scale.
        let scale = if !kind.draws_surfaces { 1.0 } else { request.settings.render.scale };
        let shaded = |side: u32| ((side as f32 * scale).round() as u32).max(1);
        let (width, height) = (request.width, request.height);
        let size = (shaded(width), shaded(height));
        let fits = |side: u32| (1..=limit).contains(&side);
        if ![width, height].into_iter().all(fits) {
            return Err(RenderError::Size { width, height, limit });
        }
        if ![size.0, size.1].into_iter().all(fits) {
            return Err(RenderError::ShadedSize { width, height, shaded: size, limit });
        }
        let light = match request.settings.environment.source {
            Environment::Studio => Some(studio::key_light()),
            _ => environment.as_ref().and_then(|map| map.light),
        };
        Ok(Self {
            name,
            mirrors,
            level,
            environment_light: light.and_then(|light| request.environment_light(&light)),
            environment,
            size,
            output_size: (width, height),
            means_of: if kind.has_means { MeansOf::request(&request) } else { MeansOf::Nothing },
            wants_variables: request.sample_index == 0 && !request.want_aovs.is_empty(),
            counts_pairs: purpose.counts_pairs,
            kind,
            temporal: None,
            viewer_jitter_px: Vec2::ZERO,
            request,
        })
    }

    /// The row of the projection that gives depth before the division by w. Jitter does not change it.
    pub fn depth_row(&self, seen: &SampleView, range: DepthRange) -> Vec4 {
        let Self { request, size, output_size, .. } = self;
        let uniform = seen.camera.uniform_shaded(range, *output_size, *size, Vec2::ZERO, 1.0, 0);
        let uniform = request.clip_plane_world.map_or(uniform, |plane_world| uniform.cut_by(plane_world, range));
        uniform.clip_from_world.row(2)
    }

    /// What an adaptive still does after this sample.
    pub fn adaptive_step(&self) -> adaptive::Step {
        let (sample_index, sample_count) = self.request.sample();
        adaptive::Step::after(sample_index, sample_count)
    }

    /// For how many samples textures are filtered where frames before add theirs: more for pixels of the picture that
    /// are smaller than those of the frame.
    pub fn temporal_samples(&self) -> u32 {
        let area = |size: (u32, u32)| f64::from(size.0) * f64::from(size.1);
        let pixels = self.upscaled_to().map_or(1.0, |size| area(size) / area(self.size));
        (f64::from(TEMPORAL_SAMPLES) * pixels).round() as u32
    }

    /// The picture's size, if frames that follow each other bring it to that from the smaller one at which they are
    /// shaded.
    pub fn upscaled_to(&self) -> Option<(u32, u32)> {
        let is_asked = self.temporal.is_some() && self.request.settings.upscale.method == UpscaleMethod::Temporal;
        let is_smaller = self.size.0 <= self.output_size.0 && self.size.1 <= self.output_size.1;
        (is_asked && is_smaller && self.size != self.output_size).then_some(self.output_size)
    }

    /// By how much the frame is moved for the sake of frames before and after it, in pixels.
    pub fn temporal_jitter_px(&self) -> Vec2 {
        self.temporal.as_ref().map_or(self.viewer_jitter_px, TemporalRequest::jitter_px)
    }

    /// Which of the two sums holds the mean so far.
    pub fn previous_sum(&self, state: &ViewState) -> usize {
        if self.request.sample_index == 0 { 1 } else { state.latest_sum }
    }

    /// The outline that it draws within, and the rectangle around it, if nothing is shown of it beside that.
    pub fn outline(&self, uniform: &ViewUniform) -> Option<(Outline, Rectangle)> {
        let corners_world = self.kind.outline_world?;
        let outline = Outline::new(uniform, corners_world, self.size);
        Some((outline, rectangle_of(uniform, corners_world, self.size)))
    }

    /// Whether it has textures that samples are added to, or shown in.
    pub fn has_output(&self) -> bool {
        !self.kind.is_within || self.means_of.go_on()
    }

    /// Whether a sample that adds to those before it finds what they left.
    pub fn finds_means(&self, state: &ViewState) -> bool {
        let is_first = self.request.sample_index == 0;
        is_first
            || !self.has_output()
            || self.means_of == state.means_of
                && state.output.as_ref().is_some_and(|output| output.is_of(self.output_size))
    }
}

/// Moves the views behind mirrors as those that show them, of which they are parts.
fn move_mirrors(asked: &mut [ViewRequest]) {
    // Those that show others come after them.
    for viewer in (0..asked.len()).rev() {
        let Some(ViewRequest { size, mirrors, .. }) = asked.get(viewer) else { continue };
        let (size, jitter_px) = (*size, asked[viewer].temporal_jitter_px());
        let names: Vec<String> = mirrors.iter().map(|mirror| mirror.view.clone()).collect();
        for behind in asked.iter_mut().filter(|behind| names.contains(&behind.name)) {
            let larger =
                Vec2::new(behind.size.0 as f32, behind.size.1 as f32) / Vec2::new(size.0 as f32, size.1 as f32);
            // What is drawn beyond the viewer's picture makes no pixel larger.
            behind.viewer_jitter_px = jitter_px * larger / behind.kind.margin;
        }
    }
}

/// The views of a frame, innermost first, each with what it keeps from its last frame.
pub(super) struct FrameViews {
    pub requests: Vec<ViewRequest>,
    pub states: Vec<ViewState>,
    /// How many views within pictures are left out.
    pub captures_left_out: u32,
}

impl Renderer {
    /// Checks what a frame is asked for of its views, and takes what they keep. [`Self::keep_views`] puts that back.
    pub(super) fn ask(
        &mut self,
        scene: &Scene,
        captures: Captures,
        purpose: &Purpose<'_>,
    ) -> Result<FrameViews, RenderError> {
        let Captures { parts, left_out: captures_left_out } = captures;
        let mut requests: Vec<ViewRequest> =
            parts.into_iter().map(|part| self.ask_part(scene, part, purpose)).collect::<Result<_, _>>()?;
        let is_twice =
            |(at, view): &(usize, &ViewRequest)| requests.iter().skip(at + 1).any(|other| other.name == view.name);
        if let Some((_, view)) = requests.iter().enumerate().find(is_twice) {
            return Err(RenderError::ViewTwice(view.name.clone()));
        }
        let begins = |asked: &&ViewRequest| purpose.keeps_variables && asked.request.sample_index == 0;
        let begun: Vec<&str> = requests.iter().filter(begins).map(|asked| asked.name.as_str()).collect();
        self.forget_variables_of(|name| begun.contains(&name));
        // A plan leaves no trace in what the views keep.
        let mut take_state = |asked: &ViewRequest| {
            let kept = if purpose.is_run { self.views.remove(&asked.name) } else { None };
            let mut state = kept.unwrap_or_else(|| ViewState::new(&self.gpu));
            state.is_within = asked.kind.is_within;
            state
        };
        let states: Vec<ViewState> = requests.iter().map(&mut take_state).collect();
        for (asked, state) in requests.iter_mut().zip(&states) {
            asked.temporal = TemporalRequest::new(&mut asked.request, state.temporal.as_ref(), scene);
        }
        move_mirrors(&mut requests);
        Ok(FrameViews { requests, states, captures_left_out })
    }

    /// Checks what a frame is asked for of one view.
    fn ask_part(
        &self,
        scene: &Scene,
        mut part: PlannedView,
        purpose: &Purpose<'_>,
    ) -> Result<ViewRequest, RenderError> {
        let settings = &mut part.request.settings;
        // Not before, because it depends on the background, which callers choose afterwards.
        settings.ground.mode = settings.ground.mode.resolved(settings.environment.source, settings.background.source);
        let settings = &part.request.settings.environment;
        let of_scene = scene.environment.clone().filter(|_| settings.source == Environment::File);
        let environment = of_scene.or_else(|| self.computed.of(settings));
        ViewRequest::new(part, environment, purpose, &self.gpu.capabilities)
    }

    /// Puts back what the views of a frame keep, after it was submitted or failed. Gives what they were asked for.
    pub(super) fn keep_views(
        &mut self,
        views: FrameViews,
        fault: Option<&RenderError>,
        purpose: &Purpose<'_>,
    ) -> Vec<ViewRequest> {
        let FrameViews { requests, mut states, .. } = views;
        if fault.is_some() {
            states.iter_mut().for_each(ViewState::forget_undrawn);
            self.gpu.forget_frame();
        } else if !purpose.is_run {
            self.gpu.end_frame();
        }
        if purpose.is_run {
            self.views.extend(requests.iter().map(|asked| asked.name.clone()).zip(states));
        }
        if matches!(fault, Some(RenderError::Gpu(_))) {
            // Nobody knows what was drawn of what anti-aliasing over time keeps.
            self.cut();
        }
        requests
    }
}
