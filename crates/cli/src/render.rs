//! `render`: pictures of one or more inputs.

mod live_probes;
mod load;
mod picture;
mod simulate;

use crate::ahead::ReadAhead;
use crate::args::RenderArgs;
use crate::chosen::Chosen;
use crate::failure::{self, Failure, Kind, say, shown};
use crate::gather::{Inputs, Item};
use crate::interrupt;
use crate::job::Job;
use crate::looks::Subject;
use crate::memory;
use crate::older::Told;
use crate::output;
use crate::places::Places;
use crate::report::{Phases, Report};
use crate::request::{effect_warnings, effects};
use crate::session::{self, ms_since, still_failure};
use crate::stream;
use crate::surroundings::{self, Surroundings};
use crate::tally::Tally;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use load::Loaded;
use manypass::{Effect, EffectFile, RenderError, Renderer, Settings};
use manypass_offline::Stream;
use manypass_offline::still::aov_names;
use std::io::IsTerminal;
use std::mem::ManuallyDrop;
use std::sync::Arc;
use std::time::Instant;

/// What the pictures of one `render` share.
struct Batch<'a> {
    args: &'a RenderArgs,
    job: &'a Job,
    chosen: &'a Chosen<'a>,
    /// Of inputs that bring none.
    plain_settings: &'a Settings,
    /// Of the input that was read last.
    settings: Settings,
    /// Never dropped: the process ends with it, and the system takes back at once what would be given back piece by
    /// piece.
    renderer: ManuallyDrop<Renderer>,
    surroundings: Surroundings,
    /// The first input, if it is being read already.
    ahead: Option<ReadAhead>,
    /// Those of the input that is drawn.
    effects: Vec<Arc<dyn Effect>>,
    /// Their files, and those of inputs without a stage.
    effect_files: Vec<EffectFile>,
    plain_effect_files: &'a [EffectFile],
    report: Option<Report>,
    /// All pictures, if they go into one stream; from the first picture on.
    stream: Option<Stream>,
    bar: ProgressBar,
    /// The older names that were told of.
    told: Told,
    /// What is read and written.
    places: Places,
    /// Milliseconds from the start of the process to the renderer; the first picture's report takes them.
    start_ms: f64,
}

/// Runs `render`; `started` is when the process started.
///
/// # Errors
/// The failure of the only input, or how many of several failed.
pub fn render(args: &RenderArgs, started: Instant) -> Result<(), Failure> {
    let inputs = Inputs::gather(&args.inputs, args.recursive)?;
    let mut job = Job::new(args, inputs.count() > 1, &aov_names())?;
    let meets_stages = inputs.items.iter().any(|item| item.input.has_settings());
    let chosen = Chosen::of_frame(&args.frame)?.meeting_stages(meets_stages);
    let (settings, effect_files) = chosen.settings(Settings::default(), None)?;
    job.check(&settings)?;
    job.read_views(args.cameras.as_deref())?;
    let places = Places::new(args, &job, &inputs.items, (&surroundings::files(&settings), &effect_files))?;
    let is_lines = inputs.is_batch || job.several.any();
    let open_report =
        || args.report.as_ref().map(|path| Report::create(path, is_lines, args.skip_existing)).transpose();
    if inputs.items.is_empty() {
        return nothing_found(inputs, open_report()?);
    }
    let (first, last) = job.frames.unwrap_or((0, 0));
    let count = inputs.items.len() as u64 * (u64::from(last - first) + 1);
    interrupt::heed(args.quiet);
    if !args.quiet {
        session::note_cache(!args.cache.no_cache);
    }
    // Where memory is scarce, reading and the driver's start shall not meet at their peaks.
    let ahead = inputs.items.first().filter(|_| !args.skip_existing && !memory::is_limited());
    let ahead = ahead.and_then(|item| ReadAhead::start(&item.input));
    if ahead.is_some() {
        settings.environment.source.begin(session::cache(!args.cache.no_cache));
    }
    let renderer = session::open(args.adapter.as_deref(), !args.cache.no_cache)?;
    let effect_warnings = effect_warnings(&effect_files, job.format);
    let effects = effects(&renderer, effect_files.clone())?;
    let mut batch = Batch {
        args,
        job: &job,
        chosen: &chosen,
        plain_settings: &settings,
        settings: settings.clone(),
        renderer: ManuallyDrop::new(renderer),
        surroundings: Surroundings::new(session::cache(!args.cache.no_cache)),
        ahead,
        effects,
        effect_files: effect_files.clone(),
        plain_effect_files: &effect_files,
        report: open_report()?,
        stream: None,
        bar: progress_bar(count, args.quiet),
        told: Told::default(),
        places,
        start_ms: ms_since(started),
    };
    batch.warn("the inputs", &inputs.warnings)?;
    batch.warn("--effect", &effect_warnings)?;
    batch.warn("--cameras", &job.views.warnings)?;
    let result = batch.render_all(inputs);
    batch.bar.finish_and_clear();
    // Before what may take longer than an interrupted program has.
    let finished = batch.report.take().map_or(Ok(()), Report::finish);
    // A software driver that still compiles for what was submitted would crash when the process ends.
    batch.renderer.wait();
    result.and(finished)
}

/// Says that none of several folders and patterns has an input.
fn nothing_found(inputs: Inputs, mut report: Option<Report>) -> Result<(), Failure> {
    let mut tally = Tally::of(inputs.count());
    for (argument, failure) in inputs.unfound {
        tally.add(&argument, None, failure, report.as_mut())?.print();
    }
    let finished = report.map_or(Ok(()), Report::finish);
    tally.result().and(finished)
}

/// A bar for several pictures, on a terminal only.
fn progress_bar(count: u64, quiet: bool) -> ProgressBar {
    if count < 2 || quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    counting_bar(count)
}

fn counting_bar(count: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {eta} left  {wide_msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

impl Batch<'_> {
    fn render_all(&mut self, inputs: Inputs) -> Result<(), Failure> {
        let mut tally = Tally::of(inputs.count());
        for (argument, failure) in inputs.unfound {
            let failure = tally.add(&argument, None, failure, self.report.as_mut())?;
            self.bar.suspend(|| failure.print());
        }
        for (item_index, item) in (0..).zip(&inputs.items) {
            let mut frame = None;
            let Err(failure) = self.render_input(item_index, item, &mut frame) else { continue };
            let failure = tally.add(&item.input.name(), frame, failure, self.report.as_mut())?;
            if self.stream.as_ref().is_some_and(Stream::is_broken) {
                return Err(failure);
            }
            self.bar.suspend(|| failure.print());
        }
        stream::finish(self.stream.take())?;
        tally.result()
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
        let mut phases = Phases::default();
        let mut loaded: Option<Loaded> = None;
        let mut looks = vec![self.job.look.clone()];
        if self.job.several.has_looks() {
            self.bar.set_message(shown(&input.stem()).into_owned());
            looks = loaded.insert(self.load(item, &mut phases)?).looks.clone();
            let further = looks.len().saturating_sub(1) as u64;
            self.bar.inc_length(further * (u64::from(last - first) + 1));
        }
        for (look_index, look) in looks.iter().enumerate() {
            let mut is_metered = false;
            for frame in first..=last {
                let shown = self.job.frames.map(|_| frame);
                let subject = Subject { names: &item.names, look, frame };
                self.bar.set_message(failure::shown(&input.stem()).into_owned());
                *failing = shown;
                self.places.check(item_index, self.job, subject)?;
                let files = output::files(self.job, subject);
                let output = output::shown(self.job, files.as_ref());
                if self.args.skip_existing && output::are_there(self.job, subject) {
                    if let Some(loaded) = &mut loaded {
                        loaded.goes_on = false;
                    }
                    if let Some(report) = &mut self.report {
                        report.skipped(&input.name(), &output, shown)?;
                    }
                } else {
                    let loaded = match &mut loaded {
                        Some(loaded) => loaded,
                        slot => slot.insert(self.load(item, &mut phases)?),
                    };
                    if !is_metered {
                        self.meter(&input.name(), loaded, look_index, &mut phases)?;
                        is_metered = true;
                    }
                    // The camera may be another than is typed, where that hardly shows the model.
                    let look = loaded.looks.get(look_index).cloned().unwrap_or_else(|| look.clone());
                    let subject = Subject { look: &look, ..subject };
                    phases.start = std::mem::take(&mut self.start_ms);
                    self.render_picture(item, loaded, subject, &output, std::mem::take(&mut phases))?;
                }
                self.bar.inc(1);
                interrupt::check()?;
            }
        }
        Ok(())
    }
}

fn failed(error: RenderError) -> Failure {
    still_failure(&error.into())
}
