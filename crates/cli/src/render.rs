//! `render`: pictures of one or more inputs.

use crate::args::RenderArgs;
use crate::failure::{Failure, Kind};
use crate::input::Input;
use crate::job::Job;
use crate::memory;
use crate::output;
use crate::pattern::expand;
use crate::report::{Entry, Phases, Report};
use crate::request::{effect, request, settings};
use crate::session::{self, ms_since, still_failure};
use crate::shot::{pose, previous_pose, time_secs, view};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use manypass::{Effect, FrameRequest, PairCounts, RenderError, Renderer, Settings};
use manypass_offline::still::{accumulate, aov_names, read_picture};
use manypass_offline::{Format, atomic};
use manypass_scene::{Aabb, Scene};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

static STOP: AtomicBool = AtomicBool::new(false);

/// What the pictures of one `render` share.
struct Batch<'a> {
    args: &'a RenderArgs,
    job: &'a Job,
    settings: Settings,
    renderer: Renderer,
    effects: Vec<Arc<dyn Effect>>,
    report: Option<Report>,
    bar: ProgressBar,
    /// Whether messages name their input.
    has_several_inputs: bool,
    /// Milliseconds from the start of the process to the renderer; the first picture's report takes them.
    start_ms: f64,
}

/// An input in memory and on the device.
struct LoadedInput {
    scene: Scene,
    /// What an automatic camera shows whole.
    bounds: Aabb,
    warnings: Vec<String>,
}

/// Runs `render`; `started` is when the process started.
///
/// # Errors
/// The failure of the only input, or how many of several failed.
pub fn render(args: &RenderArgs, started: Instant) -> Result<(), Failure> {
    let mut inputs = Vec::new();
    for argument in &args.inputs {
        inputs.extend(Input::parse(argument)?);
    }
    let job = Job::new(args, inputs.len() > 1, &aov_names())?;
    let settings = settings(args, &job)?;
    let stems: Vec<String> = inputs.iter().map(Input::stem).collect();
    let extra: Vec<&Path> = args.contact_sheet.iter().chain(&args.dump_passes).map(PathBuf::as_path).collect();
    let single: Vec<&Path> = args.report.iter().map(PathBuf::as_path).collect();
    output::check_distinct(&job, &stems, &extra, &single)?;
    let (first, last) = job.frames.unwrap_or((0, 0));
    let count = inputs.len() as u64 * (u64::from(last - first) + 1);
    // Without a handler an interrupt ends the program as the system does it.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            atomic::remove_unfinished();
            std::process::exit(130);
        }
    });
    let renderer = session::open(args.adapter.as_deref())?;
    let effects = args.effects.iter().map(|path| effect(&renderer, path)).collect::<Result<_, _>>()?;
    let mut batch = Batch {
        args,
        job: &job,
        settings,
        renderer,
        effects,
        report: args.report.as_ref().map(|path| Report::create(path, count > 1)).transpose()?,
        bar: progress_bar(count, args.quiet),
        has_several_inputs: inputs.len() > 1,
        start_ms: ms_since(started),
    };
    let result = batch.render_all(&inputs);
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
    fn render_all(&mut self, inputs: &[Input]) -> Result<(), Failure> {
        let mut first_kind = None;
        let mut failed_count = 0;
        for input in inputs {
            let Err(mut failure) = self.render_input(input) else { continue };
            if let Some(report) = &mut self.report {
                report.failed(&input.name(), &failure)?;
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
            let message = format!("{failed_count} of {} inputs failed", inputs.len());
            Err(Failure::new(kind, message, "the messages above say why; the others are done"))
        })
    }

    fn render_input(&mut self, input: &Input) -> Result<(), Failure> {
        let (first, last) = self.job.frames.unwrap_or((0, 0));
        let mut loaded: Option<LoadedInput> = None;
        for frame in first..=last {
            let shown = self.job.frames.map(|_| frame);
            self.bar.set_message(input.stem());
            let files = output::files(self.job, &input.stem(), frame);
            let output = files.as_ref().map_or("-".into(), |(target, _)| target.display().to_string());
            let is_there = files.is_some_and(|(target, aovs)| target.exists() && aovs.iter().all(|path| path.exists()));
            if self.args.skip_existing && is_there {
                if let Some(report) = &mut self.report {
                    report.skipped(&input.name(), &output, shown)?;
                }
            } else {
                let mut phases = Phases { start: std::mem::take(&mut self.start_ms), ..Phases::default() };
                let loaded = match &mut loaded {
                    Some(loaded) => loaded,
                    slot => slot.insert(self.load(input, first, &mut phases)?),
                };
                self.render_frame(input, loaded, frame, &output, phases)?;
            }
            self.bar.inc(1);
            if STOP.load(Ordering::SeqCst) {
                return Err(still_failure(&manypass_offline::still::StillError::Stopped));
            }
        }
        Ok(())
    }

    fn load(&mut self, input: &Input, first_frame: u32, phases: &mut Phases) -> Result<LoadedInput, Failure> {
        let start = Instant::now();
        let (mut scene, mut warnings) = input.load()?;
        // One box for all frames, so that the camera stands still while the model moves.
        pose(&mut scene, self.args, time_secs(self.args, first_frame))?;
        let bounds = scene.framing_bounds_world();
        phases.load = ms_since(start);
        memory::check_scene(&scene, &self.renderer.gpu().adapter)?;
        let start = Instant::now();
        self.renderer.load(&scene).map_err(failed)?;
        phases.decode = self.renderer.decode_ms();
        phases.upload = ms_since(start) - phases.decode;
        warnings.extend(self.renderer.warnings());
        if !self.args.quiet {
            self.bar.suspend(|| warnings.iter().for_each(|warning| eprintln!("warning: {}: {warning}", input.name())));
        }
        Ok(LoadedInput { scene, bounds, warnings })
    }

    fn render_frame(
        &mut self,
        input: &Input,
        LoadedInput { scene, bounds, warnings }: &mut LoadedInput,
        frame: u32,
        output: &str,
        mut phases: Phases,
    ) -> Result<(), Failure> {
        let (args, job) = (self.args, self.job);
        let previous = previous_pose(scene, bounds, args, job, frame)?;
        pose(scene, args, time_secs(args, frame))?;
        let camera = view(scene, bounds, args, job, frame as f32)?;
        let effects = self.effects.clone();
        let request = FrameRequest { previous, effects, ..request(args, job, &self.settings, camera, scene) };
        let renderer = &mut self.renderer;
        let start = Instant::now();
        let compiled_ms = renderer.compile_ms();
        let shows_passes = args.dump_passes.is_some() || args.contact_sheet.is_some();
        let budget = memory::budget(job, &request, &renderer.gpu().adapter, shows_passes, self.report.is_some())?;
        renderer.set_memory_budget(budget.as_ref().and_then(|budget| budget.texture_bytes));
        accumulate(renderer, scene, &request, args.samples, |_| !STOP.load(Ordering::SeqCst)).map_err(|error| {
            let refused = budget.as_ref().and_then(|budget| budget.failure(job, &error));
            refused.unwrap_or_else(|| still_failure(&error))
        })?;
        renderer.set_memory_budget(None);
        renderer.wait();
        phases.compile = renderer.compile_ms() - compiled_ms;
        phases.frames = ms_since(start) - phases.compile;
        let stats = renderer.stats();
        let start = Instant::now();
        let picture =
            read_picture(renderer, &request, job.format == Format::Exr).map_err(|error| still_failure(&error))?;
        phases.readback = ms_since(start);
        let start = Instant::now();
        let depth_range_m = output::write(&picture, job, &input.stem(), frame)?;
        phases.encode = ms_since(start);

        // The rest is in frames of their own, of one sample, that no phase counts.
        let alone = FrameRequest { sample_count: 1, ..request };
        if shows_passes {
            let pictures = renderer.passes(scene, &alone).map_err(failed)?;
            let named = |path: &PathBuf| expand(&path.to_string_lossy(), &input.stem(), frame, "rgba");
            if let Some(folder) = &args.dump_passes {
                output::write_passes(&named(folder), &pictures)?;
            }
            if let Some(file) = &args.contact_sheet {
                output::write_sheet(&named(file), &pictures)?;
            }
        }
        if let Some(report) = &mut self.report {
            let alone = FrameRequest { want_aovs: Vec::new(), ..alone };
            let plan = renderer.plan(scene, &alone).map_err(failed)?;
            let pass_times = renderer.pass_times(scene, &alone).map_err(failed)?;
            let pairs = if stats.lights == 0 {
                PairCounts::default()
            } else {
                renderer.count_pairs(scene, &alone).map_err(failed)?
            };
            report.rendered(&Entry {
                input: &input.name(),
                output,
                frame: job.frames.map(|_| frame),
                size: (job.width, job.height),
                samples: args.samples,
                adapter: &renderer.gpu().adapter,
                phases,
                stats: &stats,
                plan: &plan,
                pass_times: &pass_times,
                pairs,
                depth_range_m,
                warnings,
            })?;
        }
        Ok(())
    }
}

fn failed(error: RenderError) -> Failure {
    still_failure(&error.into())
}
