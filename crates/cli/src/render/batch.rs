//! What the pictures of one `render` share.

use crate::ahead::ReadAhead;
use crate::args::RenderArgs;
use crate::chosen::SettingsChoice;
use crate::failure::{Failure, Kind, say};
use crate::job::Job;
use crate::older::ToldNames;
use crate::places::Places;
use crate::report::Report;
use crate::session::still_failure;
use crate::surroundings::Surroundings;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use manypass::{Effect, EffectFile, RenderError, Renderer, Settings};
use manypass_offline::Stream;
use std::io::IsTerminal;
use std::mem::ManuallyDrop;
use std::sync::Arc;

/// What the pictures of one `render` share.
pub(super) struct Batch<'a> {
    pub(super) args: &'a RenderArgs,
    pub(super) job: &'a Job,
    pub(super) chosen: &'a SettingsChoice<'a>,
    /// Of inputs that bring none.
    pub(super) plain_settings: &'a Settings,
    /// Of the input that was read last.
    pub(super) settings: Settings,
    /// Never dropped: the process ends with it, and the system takes back at once what would be given back piece by
    /// piece.
    pub(super) renderer: ManuallyDrop<Renderer>,
    pub(super) surroundings: Surroundings,
    /// The first input, if it is being read already.
    pub(super) ahead: Option<ReadAhead>,
    /// Those of the input that is drawn.
    pub(super) effects: Vec<Arc<dyn Effect>>,
    /// Their files, and those of inputs without a stage.
    pub(super) effect_files: Vec<EffectFile>,
    pub(super) plain_effect_files: &'a [EffectFile],
    pub(super) report: Option<Report>,
    /// All pictures, if they go into one stream; from the first picture on.
    pub(super) stream: Option<Stream>,
    pub(super) bar: ProgressBar,
    /// The older names that were told of.
    pub(super) told: ToldNames,
    /// What is read and written.
    pub(super) places: Places,
    /// Milliseconds from the start of the process to the renderer; the first picture's report takes them.
    pub(super) start_ms: f64,
}

impl Batch<'_> {
    /// Says what is wrong without hindering the picture; with `--strict` it hinders it.
    ///
    /// # Errors
    /// With `--strict`, if there is a warning.
    pub(super) fn warn(&self, name: &str, warnings: &[String]) -> Result<(), Failure> {
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
}

/// A bar for several pictures, on a terminal only.
pub(super) fn progress_bar(count: u64, quiet: bool) -> ProgressBar {
    if count < 2 || quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    counting_bar(count)
}

/// A bar with a count and what is drawn.
pub(super) fn counting_bar(count: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {eta} left  {wide_msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// What an error of the renderer means to the user.
pub(super) fn failed(error: RenderError) -> Failure {
    still_failure(&error.into())
}
