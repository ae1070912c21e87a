//! One picture of a batch: drawn, put into its files, reported.

use super::batch::{Batch, failed};
use super::load::LoadedInput;
use super::simulate;
use crate::deliver::Delivery;
use crate::failure::{Failure, say};
use crate::gather::Item;
use crate::looks::Subject;
use crate::one_tone::OneTone;
use crate::report::{self, Entry, Outputs, Phases};
use crate::request::{effect_values, picture_info, request};
use crate::session::{ms_since, still_failure};
use crate::shot::{adaptation, focus_m, moment, moves, pose, previous_pose, time_secs, view};
use crate::{coverage, exposure, interrupt, memory, output, table};
use manypass::{Background, FrameRequest, FrameStats, PairCounts, SimulationReport};
use manypass_offline::still::{StillError, accumulate, accumulate_moving};
use manypass_offline::{Format, PictureInfo, manifest};
use manypass_scene::Scene;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// A picture that is drawn, and what its report says of it.
struct DrawnPicture {
    /// How many samples its pixels have on average, if there is a report.
    samples_mean: f64,
    request: FrameRequest,
    info: PictureInfo,
    phases: Phases,
    /// Of its last sample.
    stats: FrameStats,
    /// What the report says of its shadows.
    shadows: serde_json::Value,
    forward_materials: Vec<serde_json::Value>,
    simulations: Vec<SimulationReport>,
    /// Pixels of radiance that half floats clamped; none if no radiance was read.
    clamped_pixels: Option<u64>,
    /// Pixels that effects left as no numbers; none if nobody counted them.
    scrubbed_pixels: Option<u64>,
    warnings: Vec<String>,
}

/// Why a picture was not drawn.
enum DrawFault {
    Still(StillError),
    /// The scene has no pose for a sample.
    Pose(Failure),
}

impl From<StillError> for DrawFault {
    fn from(error: StillError) -> Self {
        Self::Still(error)
    }
}

impl Batch<'_> {
    /// Draws the picture of a frame and writes its files; `output` is the name of its file for the report.
    ///
    /// # Errors
    /// It cannot be drawn or written, there are warnings where those are errors, or the user has said stop.
    pub(super) fn render_picture(
        &mut self,
        item: &Item,
        loaded: &mut LoadedInput,
        subject: Subject<'_>,
        output: &str,
        phases: Phases,
    ) -> Result<(), Failure> {
        let mut drawn = self.draw(item, loaded, subject, phases)?;
        let mut delivery =
            Delivery::begin(&mut self.renderer, &drawn.request, self.job, &drawn.info, subject, &mut self.stream)?;
        drawn.clamped_pixels = drawn.request.averages_radiance().then(|| self.renderer.clamped_pixels());
        if let Some(warning) = exposure::clamped_warning(drawn.clamped_pixels.unwrap_or(0)) {
            self.warn(&item.input.name(), std::slice::from_ref(&warning))?;
            drawn.warnings.push(warning);
        }
        // They are counted in a frame of its own, which is drawn for those alone who would hear of it.
        let draws_effects = drawn.request.effects.iter().any(|effect| effect.is_on());
        if draws_effects && (self.report.is_some() || self.args.strict) {
            drawn.scrubbed_pixels = Some(self.renderer.count_scrubbed(&loaded.scene, &drawn.request).map_err(failed)?);
        }
        if let Some(warning) = exposure::scrubbed_warning(drawn.scrubbed_pixels.unwrap_or(0)) {
            self.warn(&item.input.name(), std::slice::from_ref(&warning))?;
            drawn.warnings.push(warning);
        }
        self.look_at(&item.input.name(), loaded, &delivery, &drawn.request)?;
        delivery.finish(self.stream.as_mut())?;
        // Their memory is the next picture's.
        self.renderer.forget_variables();
        (drawn.phases.readback, drawn.phases.encode) = (delivery.readback_ms, delivery.encode_ms);

        // The rest is in frames of their own, that no phase counts. Passes are those of the first sample, as in the
        // plan.
        let (contact_sheet, passes) = self.show_passes(loaded, subject, &drawn.request)?;
        if self.report.is_some() {
            let outputs = Outputs { picture: output, aovs: &delivery.aovs, contact_sheet, passes };
            self.report_picture((item, subject), loaded, &drawn, (outputs, &delivery))?;
        }
        // The frames of the report had variables, too.
        self.renderer.forget_variables();
        Ok(())
    }

    /// Hints at a first picture of a sequence that shows nothing. Who asks for variables may want that.
    fn look_at(
        &mut self,
        name: &str,
        loaded: &mut LoadedInput,
        delivery: &Delivery,
        request: &FrameRequest,
    ) -> Result<(), Failure> {
        let background = request.settings.background.source;
        let is_first = !std::mem::replace(&mut loaded.is_looked_at, true);
        if !is_first || !self.job.aovs.is_empty() || background == Background::Transparent {
            return Ok(());
        }
        let tone = match self.job.format {
            Format::Exr => OneTone::of(&self.renderer.read_display().map_err(failed)?, background),
            _ => delivery.one_tone,
        };
        if let Some(tone) = tone {
            self.hint(name, &tone.hint());
            loaded.hints.push(tone.hint());
        }
        Ok(())
    }

    /// Poses the scene and draws all samples.
    fn draw(
        &mut self,
        item: &Item,
        loaded: &mut LoadedInput,
        subject: Subject<'_>,
        mut phases: Phases,
    ) -> Result<DrawnPicture, Failure> {
        let (args, job) = (self.args, self.job);
        let Subject { look, frame, .. } = subject;
        let LoadedInput { scene, framing, exposure, warnings, goes_on, .. } = loaded;
        let mut warnings = warnings.clone();
        let previous = previous_pose(scene, framing, (args, &self.effect_files), (job, look), frame)?;
        pose(scene, args, time_secs(args, frame))?;
        let simulations = self.simulate(scene)?;
        let exploded: Vec<String> = simulations.iter().filter_map(simulate::warning).collect();
        self.warn(&item.input.name(), &exploded)?;
        warnings.extend(exploded);
        let camera = view(scene, framing, args, (job, look), frame as f32)?;
        let effects = self.effects.clone();
        let ground_height_m = framing.lowest_m();
        let mut request =
            FrameRequest { previous, effects, ground_height_m, ..request(args, job, &self.settings, camera, scene) };
        exposure.iter().for_each(|taken| taken.expose(&mut request));
        let is_first = !std::mem::replace(goes_on, true);
        request.goes_on = !is_first && request.is_temporal();
        request.effects_go_on = !is_first;
        request.adaptation = adaptation(args, is_first);
        let lens = &mut request.settings.camera;
        if lens.f_stop > 0.0 && lens.focus_m == 0.0 {
            lens.focus_m = focus_m(scene, framing, look, &camera);
        }
        let compiled_ms = self.renderer.compile_ms();
        warnings.extend(self.warn_of_nothing(item, scene, &request)?);
        let shows_passes = job.dump_passes.is_some() || job.contact_sheet.is_some();
        let renderer = &mut self.renderer;
        let budget = memory::budget(job, &request, &renderer.gpu().adapter, shows_passes, self.report.is_some())?;
        renderer.set_memory_budget(budget.as_ref().and_then(|budget| budget.texture_bytes));
        let (samples, shutter_deg) = (args.frame.samples, request.settings.camera.shutter_deg);
        let is_moving = shutter_deg > 0.0 && samples > 1 && moves(scene, args);
        let start = Instant::now();
        let looked_ms = self.renderer.compile_ms();
        let found = if is_moving { Ok(()) } else { self.find_probe_light(scene, &request) };
        let renderer = &mut self.renderer;
        if found.is_err() {
            renderer.set_memory_budget(None);
        }
        found?;
        let go_on = |_| !interrupt::STOP.load(Ordering::SeqCst);
        let drawn = if is_moving {
            let at = |scene: &mut Scene, position: f32| {
                moment(scene, framing, args, (job, look), frame, (shutter_deg, position)).map_err(DrawFault::Pose)
            };
            accumulate_moving(renderer, scene, &request, samples, at, go_on)
        } else {
            accumulate(renderer, scene, &request, samples, go_on).map_err(DrawFault::from)
        };
        // The budget is this picture's alone, whether it was drawn or not.
        renderer.set_memory_budget(None);
        drawn.map_err(|undrawn| match undrawn {
            DrawFault::Pose(failure) => failure,
            DrawFault::Still(error) => {
                let refused = budget.as_ref().and_then(|budget| budget.failure(job, &error));
                refused.unwrap_or_else(|| still_failure(&error))
            }
        })?;
        renderer.wait();
        phases.compile = renderer.compile_ms() - compiled_ms;
        phases.frames = ms_since(start) - (renderer.compile_ms() - looked_ms);
        let stats = renderer.stats();
        let shadows = report::shadow_numbers(renderer, scene);
        let forward_materials = manifest::forward_materials(scene);
        let info = picture_info(args, job, &request, scene, job.frames.map(|_| frame));
        let samples_mean = if self.report.is_some() { self.renderer.read_samples_mean().map_err(failed)? } else { 0.0 };
        Ok(DrawnPicture {
            samples_mean,
            request,
            info,
            phases,
            stats,
            shadows,
            forward_materials,
            simulations,
            clamped_pixels: None,
            scrubbed_pixels: None,
            warnings,
        })
    }

    /// Warns where no surface is in view; gives the warning.
    fn warn_of_nothing(
        &mut self,
        item: &Item,
        scene: &Scene,
        request: &FrameRequest,
    ) -> Result<Option<String>, Failure> {
        if !coverage::is_empty(&mut self.renderer, scene, request).map_err(failed)? {
            return Ok(None);
        }
        let warning = "the picture is empty: no surface is in view".to_owned();
        self.warn(&item.input.name(), std::slice::from_ref(&warning))?;
        Ok(Some(warning))
    }

    /// Writes the pictures of all passes where they are asked for; gives the paths of the contact sheet and of those
    /// that have files of their own.
    fn show_passes(
        &mut self,
        loaded: &LoadedInput,
        subject: Subject<'_>,
        request: &FrameRequest,
    ) -> Result<(Option<String>, Vec<String>), Failure> {
        let (folder, sheet) = (&self.job.dump_passes, &self.job.contact_sheet);
        if folder.is_none() && sheet.is_none() {
            return Ok((None, Vec::new()));
        }
        let pictures = self.renderer.passes(&loaded.scene, request).map_err(failed)?;
        let mut passes = Vec::new();
        if let Some(folder) = folder {
            passes = output::write_passes(&folder.expand(subject, "rgba"), &pictures)?;
        }
        let Some(sheet) = sheet else { return Ok((None, passes)) };
        let path = sheet.expand(subject, "rgba");
        output::write_sheet(&path, &pictures)?;
        Ok((Some(path.display().to_string()), passes))
    }

    /// Adds a picture to the report. Of one that is shown, people find the passes on standard error, too.
    fn report_picture(
        &mut self,
        (item, subject): (&Item, Subject<'_>),
        loaded: &LoadedInput,
        drawn: &DrawnPicture,
        (outputs, delivery): (Outputs<'_>, &Delivery),
    ) -> Result<(), Failure> {
        let (Some(report), renderer, scene) = (&mut self.report, &mut self.renderer, &loaded.scene) else {
            return Ok(());
        };
        let plan = renderer.plan(scene, &drawn.request).map_err(failed)?;
        let pass_times = renderer.pass_times(scene, &drawn.request).map_err(failed)?;
        let pairs = if drawn.stats.lights == 0 {
            PairCounts::default()
        } else {
            renderer.count_pairs(scene, &drawn.request).map_err(failed)?
        };
        let effects: Vec<_> = self.effect_files.iter().map(effect_values).collect();
        let adapted_stops = renderer.read_adapted_stops().map_err(failed)?;
        report.rendered(&Entry {
            input: &item.input.name(),
            input_files: &loaded.files,
            outputs,
            info: &drawn.info,
            fisheye: renderer.fisheye(&drawn.request),
            look: subject.look,
            effects: &effects,
            settings: &self.settings,
            size: (self.job.width, self.job.height),
            samples: self.args.frame.samples,
            samples_mean: drawn.samples_mean,
            adapter: &renderer.gpu().adapter,
            phases: drawn.phases,
            stats: &drawn.stats,
            shadows: &drawn.shadows,
            forward_materials: &drawn.forward_materials,
            simulations: &drawn.simulations,
            plan: &plan,
            pass_times: &pass_times,
            pairs,
            aov_ranges: &delivery.aov_ranges,
            exposure: loaded.exposure.map(|taken| taken.report(adapted_stops)),
            clamped_pixels: drawn.clamped_pixels,
            scrubbed_pixels: drawn.scrubbed_pixels,
            warnings: &drawn.warnings,
            hints: &loaded.hints,
        })?;
        if report.is_shown() && !self.args.quiet {
            let passes = table::of_times(&pass_times, &plan.pass_work());
            self.bar.suspend(|| say(format_args!("{}", passes.trim_end())));
        }
        Ok(())
    }
}
