//! Notices of older names that still work. They are hints: `--strict` refuses none, and each is said once a run.

use crate::failure::say;
use crate::input::Input;
use manypass::Settings;
use manypass_scene::Stage;
use manypass_scene::renamed::{NameChange, NameKind, renamed};

/// The older names that were told of.
#[derive(Default)]
pub struct ToldNames(Vec<&'static NameChange>);

impl ToldNames {
    /// Those of `names` that nobody was told of.
    pub fn news(&mut self, names: &[&'static NameChange]) -> Vec<&'static NameChange> {
        let mut news = Vec::new();
        for name in names {
            if !self.0.contains(name) {
                self.0.push(name);
                news.push(*name);
            }
        }
        news
    }

    /// Says on standard error those of `names` that nobody was told of; `subject` uses them.
    pub fn say(&mut self, subject: &str, names: &[&'static NameChange]) {
        self.news(names).iter().for_each(|name| say(format_args!("hint: {subject}: {name}")));
    }
}

/// The older names that an input and its stage use.
pub fn of_input(input: &Input, stage: Option<&Stage>) -> Vec<&'static NameChange> {
    let demo = if let Input::Demo(name) = input { renamed(NameKind::Demo, name) } else { None };
    demo.into_iter().chain(stage.into_iter().flat_map(Settings::stage_older_names)).collect()
}
