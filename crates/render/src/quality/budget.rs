//! A budget of time for live frames: a ladder of tables of settings, on which measured times lead up and down.

use super::Quality;
use super::controller::Controller;
use crate::settings::Settings;
use serde_json::Value;
use std::collections::BTreeMap;

/// Settings that are read when a model is loaded: a change of them would be a stall. They are those of the best tier.
const OF_LOADING: [&str; 2] = ["textures.max_px", "lod.simplify"];

/// A rung: a tier, the scale at which it is shaded if that is another one, and what a frame takes beside those of
/// `medium`, as the table of docs/quality.md has it on the whole. Times that are measured correct it.
const LADDER: [(&str, Quality, Option<&str>, f64); 8] = [
    ("ultra", Quality::Ultra, None, 2.5),
    ("high", Quality::High, None, 1.5),
    ("medium", Quality::Medium, None, 1.0),
    ("medium, 0.83", Quality::Medium, Some("0.83"), 0.8),
    ("low", Quality::Low, None, 0.42),
    ("low, 0.5", Quality::Low, Some("0.5"), 0.32),
    ("low, 0.35", Quality::Low, Some("0.35"), 0.24),
    ("low, 0.25", Quality::Low, Some("0.25"), 0.2),
];

/// One of the ladder, with what was chosen by hand.
#[derive(Clone, Debug)]
struct Rung {
    name: &'static str,
    settings: Settings,
    cost: f64,
    /// What it has in place of the settings without a budget.
    changed: BTreeMap<String, Value>,
}

/// The frame-time budget: chooses the settings of live frames by what frames took, to keep to `quality.budget_ms`. What
/// was chosen by hand stays.
///
/// ```
/// # use manypass::{Quality, QualityBudget, Settings, SettingsError};
/// let chosen = |mut settings: Settings| {
///     settings.set("quality.budget_ms", "16")?;
///     settings.set("shadows.filter", "pcss")?;
///     Ok::<_, SettingsError>(settings)
/// };
/// let mut budget = QualityBudget::new(Quality::Ultra, chosen)?.expect("a budget");
/// for _ in 0..30 {
///     // Frames that take 40 ms at any settings.
///     budget.take(40.0);
/// }
/// assert_eq!(budget.rung(), "low, 0.25");
/// assert_eq!(budget.settings().shadows.filter, manypass::ShadowFilter::Pcss);
/// # Ok::<(), SettingsError>(())
/// ```
#[derive(Clone, Debug)]
pub struct QualityBudget {
    rungs: Vec<Rung>,
    controller: Controller,
    budget_ms: f32,
}

impl QualityBudget {
    /// A budget for what `chosen` makes of a table of settings, which are those of the ladder up to the tier `best`; none
    /// if `quality.budget_ms` is 0. Rungs that do not go together with what was chosen, and those that are as the one
    /// before, are left out.
    ///
    /// # Errors
    /// What `chosen` says.
    pub fn new<E>(best: Quality, mut chosen: impl FnMut(Settings) -> Result<Settings, E>) -> Result<Option<Self>, E> {
        let plain = chosen(Settings::default())?;
        let budget_ms = plain.quality.budget_ms;
        if !(budget_ms.is_finite() && budget_ms > 0.0) {
            return Ok(None);
        }
        let mut rungs: Vec<Rung> = Vec::new();
        let mut start = 0;
        for (name, tier, scale, cost) in LADDER.into_iter().filter(|(_, tier, ..)| *tier as u8 <= best as u8) {
            let settings = chosen(table(tier, scale, best))?;
            let is_known = rungs.last().is_some_and(|rung| rung.settings == settings);
            if is_known || settings.check().is_err() {
                continue;
            }
            if cost >= 1.0 {
                start = rungs.len();
            }
            let changed = differences(&plain, &settings);
            rungs.push(Rung { name, settings, cost, changed });
        }
        if rungs.is_empty() {
            rungs.push(Rung { name: "medium", settings: plain, cost: 1.0, changed: BTreeMap::new() });
        }
        let costs = rungs.iter().map(|rung| rung.cost).collect();
        let controller = Controller::new(f64::from(budget_ms), costs, start);
        Ok(Some(Self { rungs, controller, budget_ms }))
    }

    /// Takes what a frame took, milliseconds, and says whether the next one has other settings. What is no time changes
    /// nothing.
    pub fn take(&mut self, frame_ms: f64) -> bool {
        self.controller.take(frame_ms)
    }

    /// The settings of the next frame.
    pub fn settings(&self) -> &Settings {
        &self.here().settings
    }

    /// The name of the rung: a tier, and the scale at which it is shaded if that is another one.
    pub fn rung(&self) -> &'static str {
        self.here().name
    }

    /// The names of all rungs, the best first.
    pub fn rungs(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.rungs.iter().map(|rung| rung.name)
    }

    /// What the rung has in place of the settings without a budget, by key.
    pub fn changed(&self) -> &BTreeMap<String, Value> {
        &self.here().changed
    }

    /// The budget in milliseconds.
    pub fn budget_ms(&self) -> f32 {
        self.budget_ms
    }

    /// How often settings changed.
    pub fn changes(&self) -> u32 {
        self.controller.changes()
    }

    /// How many frames there were up to the last change.
    pub fn settled_after(&self) -> u32 {
        self.controller.settled_after()
    }

    /// The median of the last frames of this rung, milliseconds; none before there are any that count.
    pub fn median_ms(&self) -> Option<f64> {
        self.controller.median_ms()
    }

    fn here(&self) -> &Rung {
        // There is one at least, and the controller knows how many.
        &self.rungs[self.controller.rung().min(self.rungs.len() - 1)]
    }
}

/// The settings of a rung alone, with those of loading of the best tier.
fn table(tier: Quality, scale: Option<&'static str>, best: Quality) -> Settings {
    let mut settings = Settings::default();
    let own = tier.table().iter().copied().filter(|(key, _)| !OF_LOADING.contains(key));
    let of_loading = best.table().iter().copied().filter(|(key, _)| OF_LOADING.contains(key));
    for (key, value) in own.chain(of_loading).chain(scale.map(|scale| ("render.scale", scale))) {
        // A test takes all of them.
        let _ = settings.set(key, value);
    }
    settings
}

/// What `settings` has in place of `plain`, by key.
fn differences(plain: &Settings, settings: &Settings) -> BTreeMap<String, Value> {
    let groups = |settings: &Settings| match serde_json::to_value(settings) {
        Ok(Value::Object(groups)) => groups,
        _ => serde_json::Map::new(),
    };
    let plain = groups(plain);
    let mut changed = BTreeMap::new();
    for (group, fields) in groups(settings) {
        for (field, value) in fields.as_object().into_iter().flatten() {
            if plain.get(&group).and_then(|fields| fields.get(field)) != Some(value) {
                changed.insert(format!("{group}.{field}"), value.clone());
            }
        }
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SettingsError;

    fn budget(best: Quality, pairs: &[(&str, &str)]) -> Option<QualityBudget> {
        let chosen = |mut settings: Settings| {
            pairs.iter().try_for_each(|(key, value)| settings.set(key, value))?;
            Ok::<_, SettingsError>(settings)
        };
        QualityBudget::new(best, chosen).expect("known settings")
    }

    #[test]
    fn rungs_are_tables_of_known_settings_and_get_cheaper() {
        let all = budget(Quality::Ultra, &[("quality.budget_ms", "16")]).expect("a budget");
        assert_eq!(all.rungs().collect::<Vec<_>>(), LADDER.map(|(name, ..)| name));
        assert_eq!((all.rung(), all.changed().len()), ("medium", 0), "it begins as without a budget");
        assert!(LADDER.windows(2).all(|pair| pair[0].3 > pair[1].3));
        for (name, tier, scale, _) in LADDER {
            for (key, value) in tier.table().iter().filter(|(key, _)| !OF_LOADING.contains(key)) {
                let mut same = table(tier, scale, Quality::Ultra);
                same.set(key, value).expect("a setting");
                assert!(same == table(tier, scale, Quality::Ultra) || *key == "render.scale", "{name}: {key}");
            }
        }
        assert!(all.rungs.iter().all(|rung| OF_LOADING.iter().all(|key| !rung.changed.contains_key(*key))));
    }

    #[test]
    fn what_was_chosen_by_hand_is_never_another() {
        let pairs =
            [("quality.budget_ms", "16"), ("render.scale", "1.5"), ("shadows.filter", "pcf"), ("lod.bias", "0")];
        let mut budget = budget(Quality::Ultra, &pairs).expect("a budget");
        // Those of `low` differ by scale alone, and `medium` too.
        assert_eq!(budget.rungs().collect::<Vec<_>>(), ["ultra", "high", "medium", "low"]);
        for ms in [100.0, 1.0, 100.0] {
            for _ in 0..5000 {
                budget.take(ms);
                let settings = budget.settings();
                assert_eq!((settings.render.scale, settings.lod.bias), (1.5, 0.0));
                assert_eq!(settings.shadows.filter, crate::ShadowFilter::Pcf);
                assert_eq!(settings.quality.budget_ms, 16.0);
            }
            assert_eq!(budget.rung(), if ms > 16.0 { "low" } else { "ultra" });
        }
        assert!(budget.changed().contains_key("shadows.cascades") && !budget.changed().contains_key("render.scale"));
    }

    #[test]
    fn what_does_not_go_together_is_no_rung() {
        let deferred = budget(Quality::Ultra, &[("quality.budget_ms", "16"), ("msaa.samples", "4")]);
        let rungs = deferred.expect("a budget");
        assert!(rungs.rungs().eq(["medium"]), "several samples a pixel need the forward path");
        let high = budget(Quality::High, &[("quality.budget_ms", "1000")]).expect("a budget");
        assert_eq!(high.rungs().next(), Some("high"));
        let low = budget(Quality::Low, &[("quality.budget_ms", "1000")]).expect("a budget");
        assert_eq!((low.rung(), low.changed()["render.scale"].as_f64().map(|x| x as f32)), ("low", Some(0.67)));
        let loaded = low.rungs.iter().map(|rung| rung.settings.textures.max_px);
        assert!(loaded.eq([1024; 4]), "what is loaded is what the tier says, on all rungs");
    }

    #[test]
    fn no_budget_is_none_and_bad_ones_are_refused() {
        assert!(budget(Quality::Ultra, &[]).is_none());
        assert!(budget(Quality::Ultra, &[("quality.budget_ms", "0")]).is_none());
        for value in ["-1", "NaN", "inf", "1e9", "soon"] {
            let error = Settings::default().set("quality.budget_ms", value).expect_err(value).to_string();
            assert!(error.contains("from 0 to 100000"), "{error}");
        }
    }

    #[test]
    fn a_huge_budget_gives_the_best_and_an_impossible_one_the_least() {
        for (budget_ms, rung) in [("100000", "ultra"), ("0.001", "low, 0.25")] {
            let mut budget = budget(Quality::Ultra, &[("quality.budget_ms", budget_ms)]).expect("a budget");
            for _ in 0..30 {
                budget.take(20.0);
            }
            assert_eq!(budget.rung(), rung);
        }
    }
}
