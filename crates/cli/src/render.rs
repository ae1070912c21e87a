//! `render`: pictures of one or more inputs.

mod batch;
mod live_probes;
mod load;
mod picture;
mod simulate;

use crate::ahead::ReadAhead;
use crate::args::RenderArgs;
use crate::chosen::SettingsChoice;
use crate::failure::{self, Failure, shown};
use crate::gather::{Inputs, Item};
use crate::interrupt;
use crate::job::Job;
use crate::looks::Subject;
use crate::memory;
use crate::older::ToldNames;
use crate::output;
use crate::places::Places;
use crate::report::{Phases, Report};
use crate::request::{effect_warnings, effects};
use crate::session::{self, ms_since};
use crate::stream;
use crate::surroundings::{self, Surroundings};
use crate::tally::Tally;
use batch::{Batch, progress_bar};
use load::LoadedInput;
use manypass::Settings;
use manypass_offline::Stream;
use manypass_offline::still::aov_names;
use std::mem::ManuallyDrop;
use std::time::Instant;

/// Runs `render`; `started` is when the process started.
///
/// # Errors
/// The failure of the only input, or how many of several failed.
pub fn render(args: &RenderArgs, started: Instant) -> Result<(), Failure> {
    let inputs = Inputs::gather(&args.inputs, args.recursive)?;
    let mut job = Job::new(args, inputs.count() > 1, &aov_names())?;
    let meets_stages = inputs.items.iter().any(|item| item.input.has_settings());
    let chosen = SettingsChoice::of_frame(&args.frame)?.meeting_stages(meets_stages);
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
        told: ToldNames::default(),
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

    /// `failing` is the frame that failed, if it is one of a sequence and there is an error.
    fn render_input(&mut self, item_index: u64, item: &Item, failing: &mut Option<u32>) -> Result<(), Failure> {
        let input = &item.input;
        let (first, last) = self.job.frames.unwrap_or((0, 0));
        let mut phases = Phases::default();
        let mut loaded: Option<LoadedInput> = None;
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
