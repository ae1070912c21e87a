//! `RenderOptions` of the TypeScript section.

use manypass::scene::renamed::{NameChange, NameKind, RENAMED, current, renamed};
use manypass::scene::{Scene, Stage};
use manypass::settings::SettingInput;
use manypass::{EffectFile, Exposure, Fisheye, FrameRequest, Quality, QualityBudget, Settings, effect};
use wasm_bindgen::prelude::*;

/// How frames are drawn.
#[derive(Clone, Debug, Default)]
pub struct Options {
    light_subset: Option<(u32, u32)>,
    /// The tier whose settings come before all others, if one was chosen.
    quality: Option<Quality>,
    /// What was chosen, by key, in its order.
    chosen: Vec<(String, SettingInput)>,
    /// The older keys by which something was chosen.
    older: Vec<&'static NameChange>,
    /// The stage that is shown.
    stage: Option<Stage>,
    /// Effects whose texts were given.
    given: Vec<EffectFile>,
    /// Of the stage that is shown, then what was chosen.
    settings: Settings,
    /// Those of the chain, in its order, with their settings.
    effects: Vec<EffectFile>,
}

/// Options that are short ways to settings.
const SHORT: [(&str, &str); 4] = [
    ("path", "render.path"),
    ("lightCulling", "lights.culling"),
    ("environment", "environment.source"),
    ("tonemap", "tone_map.curve"),
];

impl Options {
    /// The exposure of frames of `scene`.
    pub fn exposure(&self, scene: &Scene) -> Exposure {
        self.settings.exposure.resolved(scene, self.settings.environment.source)
    }

    /// Whether meshes are given coarser levels.
    pub fn simplifies(&self) -> bool {
        self.settings.lod.simplify
    }

    /// The greatest width and height of textures of models; 0 for any.
    pub fn textures_max_px(&self) -> u32 {
        self.settings.textures.max_px
    }

    /// Whether frames have the same settings as with `other`.
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.settings == other.settings && self.quality == other.quality
    }

    /// What chooses settings by what frames take, if `quality.budget_ms` asks for it: tiers up to the chosen one.
    pub fn budget(&self) -> Result<Option<QualityBudget>, JsError> {
        let best = self.quality.unwrap_or(Quality::Ultra);
        QualityBudget::new(best, |tier| self.over(tier).map(|(settings, _)| settings))
    }

    /// Whether surfaces get the same light as with `other`.
    pub fn has_light_of(&self, other: &Self) -> bool {
        let light = |options: &Self| {
            let settings = &options.settings;
            // Where exposure is metered, lamps of files have another unit.
            let is_metered = matches!(settings.exposure.stops, Exposure::Auto { .. });
            (settings.environment.clone(), settings.fog.clone(), settings.shadows.clone(), is_metered)
        };
        light(self) == light(other)
    }

    /// The options for what a stage shows, or a model without one: what was chosen comes after the stage's settings.
    pub fn for_stage(&self, stage: Option<&Stage>) -> Result<Self, JsError> {
        Self { stage: stage.cloned(), ..self.clone() }.settled()
    }

    /// The options with other effects beside those that the chain names.
    pub fn with_effects(&self, given: Vec<EffectFile>) -> Result<Self, JsError> {
        Self { given, ..self.clone() }.settled()
    }

    /// The options with another text of the effect `name`; what was set of it stays where the text takes it.
    pub fn with_text_of(&self, name: &str, source: &str) -> Result<Self, JsError> {
        let known = self.given.iter().position(|file| file.name() == name);
        let Some(index) = known else {
            let known: Vec<_> = self.given.iter().map(EffectFile::name).collect();
            let known = known.join(", ");
            return Err(JsError::new(&format!("no effect `{name}` was given by `setEffects`; there is: {known}")));
        };
        let mut given = self.given.clone();
        given[index] = given[index].replaced(source)?;
        self.with_effects(given)
    }

    /// The notices of older names by which the stage says or somebody chose something; each once.
    pub fn notices(&self) -> Vec<String> {
        let mut used: Vec<_> = self.stage.iter().flat_map(Settings::stage_older_names).collect();
        used.extend(&self.older);
        RENAMED.iter().filter(|renamed| used.contains(renamed)).map(ToString::to_string).collect()
    }

    /// The effects of the chain, in its order.
    pub fn effects(&self) -> &[EffectFile] {
        &self.effects
    }

    /// The settings and the chain anew, from the tier, the stage and what was chosen.
    fn settled(self) -> Result<Self, JsError> {
        let mut tier = Settings::default();
        tier.apply_quality(self.quality.unwrap_or_default())?;
        let (settings, effects) = self.over(tier)?;
        Ok(Self { settings, effects, ..self })
    }

    /// The settings and the chain of the stage and what was chosen, over those of `tier`.
    fn over(&self, tier: Settings) -> Result<(Settings, Vec<EffectFile>), JsError> {
        let failed = |error: &dyn std::fmt::Display| JsError::new(&error.to_string());
        let of_chosen =
            |key: &str| self.chosen.iter().rev().find(|(known, _)| known == key).map(|(_, written)| written);
        let of_chosen = Settings::chain_of(of_chosen);
        let is_of_stage = of_chosen.is_none();
        let names = match (of_chosen, &self.stage) {
            (Some(names), _) => names,
            (None, Some(stage)) => Settings::stage_chain(stage).map_err(|error| failed(&error))?.unwrap_or_default(),
            (None, None) => Vec::new(),
        };
        let unknown = |name: &str| -> Result<EffectFile, JsError> {
            let known: Vec<_> = EffectFile::built_in_names().collect();
            let known = known.join(", ");
            let message = EffectFile::unknown_name(name, self.given.iter().map(EffectFile::name));
            let message = format!("{message}; there is: {known}. The texts of others are given by `setEffects`");
            let file =
                self.stage.as_ref().filter(|_| is_of_stage).and_then(|stage| Settings::stage_settings(stage).ok());
            let placed = file.and_then(|file| Settings::refusal_in_chain(&file, name, &message));
            Err(placed.map_or_else(|| JsError::new(&message), |placed| failed(&placed)))
        };
        let mut effects = EffectFile::chain(&names, self.given.clone(), unknown)?;
        let mut settings = tier;
        if let Some(stage) = &self.stage {
            settings.apply_stage(stage, &mut effects).map_err(|error| failed(&error))?;
        }
        for (key, written) in &self.chosen {
            effect::set(&mut settings, &mut effects, key, written)?;
        }
        EffectFile::check_chain(&effects)?;
        if settings.camera.fisheye != Fisheye::None {
            return Err(JsError::new(
                "camera.fisheye is for stills of the command line: the page's camera has perspective",
            ));
        }
        Ok((settings, effects))
    }

    /// Changes a setting by choice.
    fn give(&mut self, key: &str, written: SettingInput) {
        if let Some(older) = renamed(NameKind::Setting, key).filter(|older| !self.older.contains(older)) {
            self.older.push(older);
        }
        let key = current(NameKind::Setting, key);
        self.chosen.retain(|(known, _)| known != key);
        self.chosen.push((key.into(), written));
    }

    /// A request for a frame of `scene` with the options, or with the settings that a budget has in place of theirs.
    pub fn applied(&self, request: FrameRequest, of_budget: Option<&Settings>, scene: &Scene) -> FrameRequest {
        let (light_subset, settings) = (self.light_subset, of_budget.unwrap_or(&self.settings).clone());
        // What effects keep from frame to frame lasts while the page shows one scene.
        FrameRequest { light_subset, settings, goes_on: true, ..request }.resolved(scene)
    }

    /// The options with what `object` holds in place of their own.
    pub fn changed(&self, object: &JsValue) -> Result<Self, JsError> {
        let mut options = self.clone();
        let Some(object) = object.dyn_ref::<js_sys::Object>() else {
            return Err(JsError::new("options are an object, such as { path: \"forward\" }"));
        };
        for entry in js_sys::Object::entries(object).iter() {
            let entry = js_sys::Array::from(&entry);
            let key = entry.get(0).as_string().unwrap_or_default();
            options.change(&key, &entry.get(1))?;
        }
        options.settled()
    }

    fn change(&mut self, key: &str, value: &JsValue) -> Result<(), JsError> {
        if value.is_undefined() {
            return Ok(());
        }
        if let Some((_, setting)) = SHORT.iter().find(|(option, _)| *option == key) {
            self.give(setting, written(value));
            return Ok(());
        }
        match key {
            "exposure" if value.is_null() => self.give("exposure.stops", SettingInput::from("scene")),
            "exposure" => {
                // It says what is wrong in words of its own.
                let _: Exposure = scalar(value).parse()?;
                self.give("exposure.stops", SettingInput::Text(scalar(value)));
            }
            "quality" if value.is_null() => self.quality = None,
            "quality" => {
                let name = scalar(value);
                let expected = || format!("quality is `{name}`: expected {}", Quality::NAMES.join(", "));
                self.quality = Some(Quality::named(&name).ok_or_else(|| JsError::new(&expected()))?);
            }
            "lightSubset" => self.light_subset = light_subset(value)?,
            "settings" => {
                if !value.is_object() {
                    return Err(JsError::new("settings is an object of values by key"));
                }
                for (key, value) in entries(value) {
                    self.give(&key, value);
                }
            }
            _ => return Err(JsError::new(&format!("there is no option `{key}`"))),
        }
        Ok(())
    }
}

/// The keys of an object with their values, as settings take them.
pub fn entries(object: &JsValue) -> Vec<(String, SettingInput)> {
    let entries = object.dyn_ref::<js_sys::Object>().map(js_sys::Object::entries).unwrap_or_default();
    let entry = |entry: JsValue| {
        let entry = js_sys::Array::from(&entry);
        (entry.get(0).as_string().unwrap_or_default(), written(&entry.get(1)))
    };
    entries.iter().map(entry).collect()
}

/// A value of a setting: a number, a boolean, a text, or an array of them.
fn written(value: &JsValue) -> SettingInput {
    match value.dyn_ref::<js_sys::Array>() {
        Some(values) => SettingInput::List(values.iter().map(|value| scalar(&value)).collect()),
        None => SettingInput::Text(scalar(value)),
    }
}

/// A number, a boolean or a text as text; what else there is shows in the error.
fn scalar(value: &JsValue) -> String {
    let number = value.as_f64().map(|number| number.to_string());
    let word = || value.as_bool().map(|flag| flag.to_string()).or_else(|| value.as_string());
    number.or_else(word).unwrap_or_else(|| format!("{value:?}"))
}

fn light_subset(value: &JsValue) -> Result<Option<(u32, u32)>, JsError> {
    if value.is_null() {
        return Ok(None);
    }
    let pair = js_sys::Array::from(value);
    match (pair.get(0).as_f64(), pair.get(1).as_f64()) {
        (Some(k), Some(n)) if k >= 0.0 && n > k && k.fract() == 0.0 && n.fract() == 0.0 => {
            Ok(Some((k as u32, n as u32)))
        }
        _ => Err(JsError::new("lightSubset takes whole numbers [k, n] with 0 ≤ k < n, or null")),
    }
}
