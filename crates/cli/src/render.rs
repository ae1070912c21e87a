//! `render`: pictures of one or more inputs.

use crate::ahead::ReadAhead;
use crate::args::RenderArgs;
use crate::coverage;
use crate::deliver::{Delivery, check_ids};
use crate::exposure::{self, Taken};
use crate::failure::{Failure, Kind, say};
use crate::gather::{Inputs, Item};
use crate::interrupt;
use crate::job::Job;
use crate::memory;
use crate::output;
use crate::places::Places;
use crate::provenance::{InputFile, input_files};
use crate::report::{Entry, Outputs, Phases, Report};
use crate::request::{effect_files, effect_values, effects, hidden_settings, picture_info, request};
use crate::session::{self, ms_since, still_failure};
use crate::shot::{pose, previous_pose, time_secs, view};
use crate::{camera, chosen, scenes, shot};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use manypass::{Effect, Environment, FrameRequest, PairCounts, RenderError, Renderer, Settings};
use manypass_offline::still::{accumulate, aov_names};
use manypass_scene::{Framing, Scene};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// What the pictures of one `render` share.
struct Batch<'a> {
    args: &'a RenderArgs,
    job: &'a Job,
    settings: Settings,
    renderer: Renderer,
    /// The first input, if it is being read already.
    ahead: Option<ReadAhead>,
    effects: Vec<Arc<dyn Effect>>,
    /// What the report says of them.
    effect_values: Vec<serde_json::Value>,
    report: Option<Report>,
    bar: ProgressBar,
    /// What is read and written.
    places: Places,
    /// Whether messages name their input.
    has_several_inputs: bool,
    /// Milliseconds from the start of the process to the renderer; the first picture's report takes them.
    start_ms: f64,
}

/// An input in memory and on the device.
struct LoadedInput {
    scene: Scene,
    /// What an automatic camera shows whole.
    framing: Framing,
    exposure: Taken,
    warnings: Vec<String>,
    /// The files it was read from; only with a report.
    files: Vec<InputFile>,
}

/// Runs `render`; `started` is when the process started.
///
/// # Errors
/// The failure of the only input, or how many of several failed.
pub fn render(args: &RenderArgs, started: Instant) -> Result<(), Failure> {
    let inputs = Inputs::gather(&args.inputs, args.recursive)?;
    let job = Job::new(args, inputs.items.len() > 1, &aov_names())?;
    let mut effect_files = effect_files(&args.frame.change.effects)?;
    let settings = chosen::of_frame(&args.frame, &mut effect_files)?;
    job.check(&settings)?;
    let places = Places::new(args, &job, &inputs.items)?;
    let (first, last) = job.frames.unwrap_or((0, 0));
    let count = inputs.items.len() as u64 * (u64::from(last - first) + 1);
    interrupt::heed(args.quiet);
    // Where memory is scarce, reading and the driver's start shall not meet at their peaks.
    let ahead = inputs.items.first().filter(|_| !args.skip_existing && !memory::is_limited());
    let ahead = ahead.and_then(|item| ReadAhead::start(&item.input));
    let renderer = session::open(args.adapter.as_deref())?;
    let hidden = hidden_settings(&effect_files);
    let effect_values = effect_files.iter().map(effect_values).collect();
    let effects = effects(&renderer, effect_files)?;
    let is_lines = inputs.is_batch || job.frames.is_some();
    let mut batch = Batch {
        args,
        job: &job,
        settings,
        renderer,
        ahead,
        effects,
        effect_values,
        report: args.report.as_ref().map(|path| Report::create(path, is_lines, args.skip_existing)).transpose()?,
        bar: progress_bar(count, args.quiet),
        places,
        has_several_inputs: inputs.items.len() > 1,
        start_ms: ms_since(started),
    };
    batch.warn("the inputs", &inputs.warnings)?;
    batch.warn("--effect", &hidden)?;
    let result = batch.render_all(&inputs.items);
    batch.bar.finish_and_clear();
    let finished = batch.report.map_or(Ok(()), Report::finish);
    result.and(finished)
}

/// A bar for several pictures, on a terminal only.
fn progress_bar(count: u64, quiet: bool) -> ProgressBar {
    if count < 2 || quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {eta} left  {wide_msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

impl Batch<'_> {
    fn render_all(&mut self, items: &[Item]) -> Result<(), Failure> {
        let mut first_kind = None;
        let mut failed_count = 0;
        for (item_index, item) in (0..).zip(items) {
            let (input, mut frame) = (&item.input, None);
            let Err(mut failure) = self.render_input(item_index, item, &mut frame) else { continue };
            if let Some(report) = &mut self.report {
                report.failed(&input.name(), frame, &failure)?;
            }
            if !self.has_several_inputs || matches!(failure.kind, Kind::DeviceLost | Kind::Interrupted) {
                return Err(failure);
            }
            if !failure.message.contains(&input.name()) {
                failure.message = format!("{}: {}", input.name(), failure.message);
            }
            self.bar.suspend(|| failure.print());
            first_kind.get_or_insert(failure.kind);
            failed_count += 1;
        }
        first_kind.map_or(Ok(()), |kind| {
            let message = format!("{failed_count} of {} inputs failed", items.len());
            Err(Failure::new(kind, message, "the messages above say why; the others are done"))
        })
    }

    /// Says what is wrong without hindering the picture; with `--strict` it hinders it.
    ///
    /// # Errors
    /// With `--strict`, if there is a warning.
    fn warn(&self, name: &str, warnings: &[String]) -> Result<(), Failure> {
        let is_error = self.args.strict && !warnings.is_empty();
        if is_error {
            let message = format!("{name}: {}", warnings.join("; "));
            return Err(Failure::new(Kind::Failed, message, "leave --strict out to be warned instead"));
        }
        if !self.args.quiet {
            self.bar.suspend(|| warnings.iter().for_each(|warning| say(format_args!("warning: {name}: {warning}"))));
        }
        Ok(())
    }

    /// `failing` is the frame that failed, if it is one of a sequence and there is an error.
    fn render_input(&mut self, item_index: u64, item: &Item, failing: &mut Option<u32>) -> Result<(), Failure> {
        let input = &item.input;
        let (first, last) = self.job.frames.unwrap_or((0, 0));
        let mut loaded: Option<LoadedInput> = None;
        for frame in first..=last {
            let shown = self.job.frames.map(|_| frame);
            self.bar.set_message(input.stem());
            *failing = shown;
            self.places.check(item_index, self.job, item, frame)?;
            let files = output::files(self.job, &item.names, frame);
            let output = files.as_ref().map_or("-".into(), |(target, _)| target.display().to_string());
            if self.args.skip_existing && output::are_there(self.job, &item.names, frame) {
                if let Some(report) = &mut self.report {
                    report.skipped(&input.name(), &output, shown)?;
                }
            } else {
                let mut phases = Phases { start: std::mem::take(&mut self.start_ms), ..Phases::default() };
                let loaded = match &mut loaded {
                    Some(loaded) => loaded,
                    slot => slot.insert(self.load(item, &mut phases)?),
                };
                self.render_frame(item, loaded, frame, &output, phases)?;
            }
            self.bar.inc(1);
            interrupt::check()?;
        }
        Ok(())
    }

    fn load(&mut self, item: &Item, phases: &mut Phases) -> Result<LoadedInput, Failure> {
        let start = Instant::now();
        // Two scenes at once need not fit into memory.
        self.renderer.unload();
        let (mut scene, mut warnings) = ReadAhead::take(&mut self.ahead, &item.input)?;
        interrupt::check()?;
        check_ids(self.job, &scene)?;
        let files = self.report.as_ref().map(|_| input_files(&item.input)).unwrap_or_default();
        scenes::show(&mut scene, self.args.frame.scene.as_deref(), &mut warnings)?;
        memory::check_scene(&scene, &self.renderer.gpu().adapter)?;
        let framing = shot::framing(&mut scene, self.args)?;
        phases.load = ms_since(start);
        let start = Instant::now();
        self.renderer.load(&scene).map_err(failed)?;
        phases.decode = self.renderer.decode_ms();
        phases.upload = ms_since(start) - phases.decode;
        interrupt::check()?;
        warnings.extend(self.renderer.warnings());
        let args = self.args;
        if scene.animations.is_empty() && (args.time.is_some() || args.frames.is_some() || args.animation.is_some()) {
            warnings.push("it has no animation; every time shows it as it stands".into());
        }
        if self.settings.environment.source == Environment::None && coverage::is_dark(&scene) {
            warnings.push("nothing lights it: the file has no lights, and --environment is none".into());
        }
        self.warn(&item.input.name(), &warnings)?;
        if let Some(hint) = camera::hint(&self.job.camera, &scene, &framing).filter(|_| !args.quiet) {
            self.bar.suspend(|| say(format_args!("hint: {}: {hint}", item.input.name())));
        }
        let start = Instant::now();
        let exposure = self.meter(&mut scene, &framing)?;
        phases.meter = ms_since(start);
        Ok(LoadedInput { scene, framing, exposure, warnings, files })
    }

    /// At time 0 and before a turntable turns, whatever the frame: so a frame is the same alone and in its sequence.
    fn meter(&mut self, scene: &mut Scene, framing: &Framing) -> Result<Taken, Failure> {
        let (args, job) = (self.args, self.job);
        pose(scene, args, time_secs(args, 0).map(|_| 0.0))?;
        let camera = view(scene, framing, args, job, 0.0)?;
        Taken::new(&mut self.renderer, scene, &request(args, job, &self.settings, camera, scene))
    }

    fn render_frame(
        &mut self,
        item: &Item,
        LoadedInput { scene, framing, exposure, warnings, files }: &mut LoadedInput,
        frame: u32,
        output: &str,
        mut phases: Phases,
    ) -> Result<(), Failure> {
        let (args, job, input) = (self.args, self.job, &item.input);
        let previous = previous_pose(scene, framing, args, job, frame)?;
        pose(scene, args, time_secs(args, frame))?;
        let camera = view(scene, framing, args, job, frame as f32)?;
        let effects = self.effects.clone();
        let mut request = FrameRequest { previous, effects, ..request(args, job, &self.settings, camera, scene) };
        exposure.expose(&mut request);
        let mut warnings = warnings.clone();
        let compiled_ms = self.renderer.compile_ms();
        if coverage::is_empty(&mut self.renderer, scene, &request).map_err(failed)? {
            let warning = ["the picture is empty: no surface is in view".to_owned()];
            self.warn(&input.name(), &warning)?;
            warnings.extend(warning);
        }
        let renderer = &mut self.renderer;
        let shows_passes = job.dump_passes.is_some() || job.contact_sheet.is_some();
        let budget = memory::budget(job, &request, &renderer.gpu().adapter, shows_passes, self.report.is_some())?;
        renderer.set_memory_budget(budget.as_ref().and_then(|budget| budget.texture_bytes));
        let start = Instant::now();
        let looked_ms = renderer.compile_ms();
        let drawn =
            accumulate(renderer, scene, &request, args.frame.samples, |_| !interrupt::STOP.load(Ordering::SeqCst));
        // The budget is this picture's alone, whether it was drawn or not.
        renderer.set_memory_budget(None);
        drawn.map_err(|error| {
            let refused = budget.as_ref().and_then(|budget| budget.failure(job, &error));
            refused.unwrap_or_else(|| still_failure(&error))
        })?;
        renderer.wait();
        phases.compile = renderer.compile_ms() - compiled_ms;
        phases.frames = ms_since(start) - (renderer.compile_ms() - looked_ms);
        let stats = renderer.stats();
        let info = picture_info(args, job, &request, scene, job.frames.map(|_| frame));
        let mut delivery = Delivery::begin(renderer, &request, job, &info, (&item.names, frame))?;
        let clamped_pixels = request.averages_radiance().then(|| renderer.clamped_pixels());
        if let Some(warning) = exposure::clamped_warning(clamped_pixels.unwrap_or(0)) {
            self.warn(&input.name(), std::slice::from_ref(&warning))?;
            warnings.push(warning);
        }
        delivery.finish()?;
        let renderer = &mut self.renderer;
        // Their memory is the next picture's.
        renderer.forget_variables();
        (phases.readback, phases.encode) = (delivery.readback_ms, delivery.encode_ms);

        // The rest is in frames of their own, that no phase counts: what shows or counts pixels is of one sample.
        let alone = FrameRequest { sample_count: 1, ..request.clone() };
        let mut outputs = Outputs { picture: output, aovs: &delivery.aovs, contact_sheet: None, passes: Vec::new() };
        if shows_passes {
            let pictures = renderer.passes(scene, &alone).map_err(failed)?;
            if let Some(folder) = &job.dump_passes {
                outputs.passes = output::write_passes(&folder.expand(&item.names, frame, "rgba"), &pictures)?;
            }
            if let Some(file) = &job.contact_sheet {
                let path = file.expand(&item.names, frame, "rgba");
                output::write_sheet(&path, &pictures)?;
                outputs.contact_sheet = Some(path.display().to_string());
            }
        }
        if let Some(report) = &mut self.report {
            let plan = renderer.plan(scene, &request).map_err(failed)?;
            let pass_times = renderer.pass_times(scene, &request).map_err(failed)?;
            let pairs = if stats.lights == 0 {
                PairCounts::default()
            } else {
                renderer.count_pairs(scene, &alone).map_err(failed)?
            };
            report.rendered(&Entry {
                input: &input.name(),
                input_files: files,
                outputs,
                info: &info,
                effects: &self.effect_values,
                settings: &self.settings,
                size: (job.width, job.height),
                samples: args.frame.samples,
                adapter: &renderer.gpu().adapter,
                phases,
                stats: &stats,
                plan: &plan,
                pass_times: &pass_times,
                pairs,
                aov_ranges: &delivery.aov_ranges,
                exposure: exposure.report(),
                clamped_pixels,
                warnings: &warnings,
            })?;
        }
        // The frames of the report had variables, too.
        self.renderer.forget_variables();
        Ok(())
    }
}

fn failed(error: RenderError) -> Failure {
    still_failure(&error.into())
}
