//! Frames as a page draws them, with settings that keep to a budget if there is one.

use crate::chosen::SettingsChoice;
use crate::failure::Failure;
use crate::job;
use manypass::{FrameRequest, Quality, QualityBudget, Settings};
use manypass_scene::Stage;
use serde_json::{Value, json};

/// The budget, if there is one.
#[derive(Default)]
pub(super) struct Live {
    budget: Option<QualityBudget>,
}

impl Live {
    /// The budget of `settings`, which are those of `chosen` and a stage. It chooses among tiers up to the one of
    /// `--quality`.
    ///
    /// # Errors
    /// Settings that do not go together.
    pub fn new(chosen: &SettingsChoice<'_>, settings: &Settings, stage: Option<&Stage>) -> Result<Self, Failure> {
        job::check_live_settings(settings)?;
        let best = chosen.quality().unwrap_or(Quality::Ultra);
        let over = |tier| chosen.settings_over(tier, stage).map(|(settings, _)| settings);
        Ok(Self { budget: QualityBudget::new(best, over)? })
    }

    /// Gives the first frame its settings.
    pub fn begin(&self, request: &mut FrameRequest) {
        let Some(budget) = &self.budget else { return };
        let mut settings = budget.settings().clone();
        // Exposure was found before.
        settings.exposure = request.settings.exposure.clone();
        request.settings = settings;
    }

    /// Takes what a frame took, and gives the next one its settings.
    pub fn take(&mut self, frame_ms: f64, request: &mut FrameRequest) {
        if self.budget.as_mut().is_some_and(|budget| budget.take(frame_ms)) {
            self.begin(request);
        }
    }

    /// The settings that were chosen last, if there is a budget.
    pub fn settings(&self) -> Option<&Settings> {
        self.budget.as_ref().map(QualityBudget::settings)
    }

    /// What was chosen, as JSON; null without a budget.
    pub fn numbers(&self) -> Value {
        let Some(budget) = &self.budget else { return Value::Null };
        json!({
            "budget_ms": budget.budget_ms(),
            "rung": budget.rung(),
            "rungs": budget.rungs().collect::<Vec<_>>(),
            "settings": budget.changed(),
            "settled_after_frames": budget.settled_after(),
            "changes": budget.changes(),
            "median_ms": budget.median_ms(),
        })
    }

    /// What was chosen, as lines; none without a budget.
    pub fn summary(&self) -> String {
        let Some(budget) = &self.budget else { return String::new() };
        let median = budget.median_ms().map_or("no frame counts yet".into(), |ms| format!("median {ms:.2} ms"));
        let mut text = format!(
            "quality: `{}` for {} ms a frame, after {} and {}; {median}\n",
            budget.rung(),
            budget.budget_ms(),
            counted(budget.settled_after(), "frame"),
            counted(budget.changes(), "change"),
        );
        let is_last = budget.rungs().last() == Some(budget.rung());
        if is_last && budget.median_ms().is_some_and(|ms| ms > f64::from(budget.budget_ms())) {
            text.push_str(
                "  that is more than the budget, and this is the last rung of the quality ladder: choose a smaller --size\n",
            );
        }
        for (key, value) in budget.changed() {
            text.push_str(&format!("  {key} = {value}\n"));
        }
        text
    }
}

/// So many of something, which has a plural like most.
fn counted(count: u32, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}
