//! Frames: drawn, refined while nothing moves, and read; each ends when the device is lost.

use super::Viewer;
use crate::camera;
use crate::types::{OrbitObject, read_orbit};
use manypass::{Averaging, Effect, EffectFile, FrameRequest, Pose, QualityBudget, View};
use std::sync::Arc;
use wasm_bindgen::prelude::*;
use web_time::Instant;

/// So many frames are averaged while nothing moves, as on the command line.
const REFINED_SAMPLES: u32 = 16;

#[wasm_bindgen]
impl Viewer {
    /// Draws one frame at the canvas's size: seen from `orbit`, or else from the model's first camera, or else so that
    /// the whole model is seen. Before it steps simulations to the time of `setTime`.
    ///
    /// # Errors
    /// When no model is loaded, a simulation cannot be run, or the device fails.
    pub async fn render(&mut self, orbit: Option<OrbitObject>) -> Result<(), JsError> {
        let loss = self.loss.clone();
        loss.or(self.draw(orbit)).await
    }

    /// Adds one more frame, moved by a part of a pixel, to the last one, and shows the mean: so edges become smooth
    /// while nothing moves. False when nothing is left to add.
    ///
    /// # Errors
    /// When the device fails.
    pub async fn refine(&mut self) -> Result<bool, JsError> {
        let loss = self.loss.clone();
        loss.or(self.add_sample()).await
    }

    /// The radiance of the last frame: linear RGBA, four floats a pixel, rows from the top. The first call draws the
    /// frame again, and from then on frames keep their radiance.
    ///
    /// # Errors
    /// When nothing was rendered, or the device was lost.
    pub async fn radiance(&mut self) -> Result<Vec<f32>, JsError> {
        let loss = self.loss.clone();
        loss.or(self.read_radiance()).await
    }

    /// The last frame as RGBA, 8 bits each, rows from the top.
    ///
    /// # Errors
    /// When nothing was rendered, or the device was lost.
    pub async fn pixels(&self) -> Result<Vec<u8>, JsError> {
        let loss = self.loss.clone();
        loss.or(self.read_pixels()).await
    }
}

impl Viewer {
    async fn draw(&mut self, orbit: Option<OrbitObject>) -> Result<(), JsError> {
        let begun = Instant::now();
        let had_turns = self.reach_time().await?;
        // What comes before a frame in several slices is no part of what the frame takes.
        let started = if had_turns { Instant::now() } else { begun };
        let (width, height) = self.canvas.size();
        let aspect = self.canvas.aspect();
        let scene = self.scene.as_ref().ok_or_else(|| JsError::new("no model is loaded"))?;
        let orbit = orbit.map(|object| {
            let start = camera::start(scene, &self.framing, aspect);
            read_orbit(&object.into(), start, scene.origin_m)
        });
        let (world_from_view, projection) = camera::resolve(orbit, scene, &self.framing, aspect);
        let ground_height_m = self.framing.lowest_m();
        let camera = View { world_from_view, projection };
        let overlay = scene.overlay.clone();
        let origin_m = scene.origin_m;
        let request = FrameRequest { ground_height_m, overlay, origin_m, ..FrameRequest::new(width, height, camera) };
        let mut request = self.options.applied(request, self.budget.as_ref().map(QualityBudget::settings), scene);
        // It is told in the space of the file.
        request.settings.fog.base_height_m -= origin_m.y;
        request.sample_count = REFINED_SAMPLES;
        request.effects = self.effects.iter().map(|effect| effect.clone() as Arc<dyn Effect>).collect();
        request.averaging = if self.keeps_radiance { Averaging::Both } else { Averaging::Display };
        self.camera_before = self.last.take().map(|last| last.camera);
        self.drawn.clear();
        // Nothing but the view moves in the page.
        let reads_motion = self.options.effects().iter().any(EffectFile::reads_motion);
        let moved_from = self.camera_before.filter(|before| reads_motion && *before != camera);
        request.previous = moved_from.map(|before| Arc::new(Pose::capture(scene, before)));
        let exposure = self.options.exposure(scene);
        if self.metering.is_none() && request.needs_metering(exposure) {
            let (world_from_view, projection) = camera::resolve(None, scene, &self.framing, aspect);
            let first = FrameRequest { camera: View { world_from_view, projection }, ..request.clone() };
            self.metering = Some(self.renderer.meter_async(scene, &first).await?);
        }
        request.expose(exposure, self.metering);
        request.adaptation = self.frame_times.begin();
        self.renderer.render_async(scene, &request).await?;
        self.last = Some(request);
        self.show()?;
        self.take_time(started).await
    }

    async fn add_sample(&mut self) -> Result<bool, JsError> {
        let (Some(scene), Some(request)) = (&self.scene, &mut self.last) else { return Ok(false) };
        let is_adapting = self.frame_times.is_adapting(request);
        if request.sample_index + 1 >= request.sample_count && is_adapting {
            // More samples are no worse, and exposure goes on with each.
            request.sample_count += 1;
        }
        let is_complete = request.sample_index + 1 >= request.sample_count && !self.renderer.is_finding_light(request);
        if is_complete || self.canvas.size() != (request.width, request.height) {
            return Ok(false);
        }
        // What moved stands now, and a mean with what is smeared would stay smeared: it begins anew.
        let has_moved = request.previous.take().is_some();
        // As it does until light is found.
        let is_finding = self.renderer.is_finding_light(request);
        request.sample_index = if has_moved || is_finding { 0 } else { request.sample_index + 1 };
        request.adaptation = self.frame_times.go_on();
        self.renderer.render_async(scene, request).await?;
        let exposure = self.options.exposure(scene);
        if is_finding && !self.renderer.is_finding_light(request) && request.needs_metering(exposure) {
            // Before light was found the picture was darker.
            let (world_from_view, projection) = camera::resolve(None, scene, &self.framing, self.canvas.aspect());
            let first = FrameRequest { camera: View { world_from_view, projection }, ..request.clone() };
            self.metering = Some(self.renderer.meter_async(scene, &first).await?);
            request.expose(exposure, self.metering);
        }
        let is_more_left = request.sample_index + 1 < request.sample_count || is_adapting || is_finding;
        self.show()?;
        Ok(is_more_left)
    }

    pub(super) async fn read_radiance(&mut self) -> Result<Vec<f32>, JsError> {
        self.keeps_radiance = true;
        let (Some(scene), Some(last)) = (&self.scene, &mut self.last) else {
            return Err(JsError::new("nothing was rendered yet"));
        };
        if last.averaging == Averaging::Display {
            (last.averaging, last.sample_index) = (Averaging::Both, 0);
            self.drawn.clear();
            self.renderer.render_async(scene, last).await?;
        }
        Ok(self.renderer.read_radiance_async().await?)
    }

    async fn read_pixels(&self) -> Result<Vec<u8>, JsError> {
        Ok(self.renderer.read_display_async().await?)
    }

    /// Shows the picture of the renderer.
    fn show(&mut self) -> Result<(), JsError> {
        let picture = self.renderer.display_view().ok_or_else(|| JsError::new("nothing was rendered yet"))?;
        self.canvas.show(self.renderer.gpu(), &picture)
    }
}
