//! Stage files as the renderer reads them: their tables of settings, and the schema by which editors check all of them.

use crate::diagnostic::Diagnostic;
use crate::effect::{self, EffectFile};
use crate::setting::{SettingInput, SettingsFile, color_schema, deprecated, schema, unknown_key};
use crate::settings::{Settings, SettingsError};
use manypass_scene::Stage;
use manypass_scene::renamed::{NameChange, NameKind, RENAMED};
use manypass_scene::stage::keys::{SETTINGS_TABLES, StageKey, StageTable, StageType, TABLES};
use serde_json::{Map, Value, json};

/// How a stage calls the environment of one colour, and the setting that it is.
const COLOR: (&str, &str) = ("environment.color", "environment.source");

/// The settings that are paths.
const FILES: [&str; 4] =
    ["environment.file", "environment.irradiance_file", "environment.prefiltered_file", "environment.brdf_file"];

impl Settings {
    /// Takes the settings of a stage: of its tables `[environment]`, `[fog]`, `[effects]` and `[settings]`; those of
    /// `effects` go to them.
    ///
    /// # Errors
    /// An unknown key, or a value of another type or outside its range, with its place; those above it are taken.
    pub fn apply_stage(&mut self, stage: &Stage, effects: &mut [EffectFile]) -> Result<(), Box<Diagnostic>> {
        settings_of(stage)?.apply(|key, written| {
            let setting = if key == COLOR.0 { COLOR.1 } else { key };
            // Paths in a stage are seen from its folder.
            let name = written.text().filter(|name| FILES.contains(&key) && !name.is_empty());
            let path = name.map(|name| SettingInput::Text(stage.path_of(&name).to_string_lossy().into_owned()));
            let given = effect::set_of_file(self, effects, setting, path.as_ref().unwrap_or(written));
            given.map_err(|error| match error {
                SettingsError::UnknownKey { key, .. } => {
                    let known = effects.iter().flat_map(EffectFile::settings).chain(Self::declared());
                    unknown_key(&key, known.map(|info| &*info.key).chain([COLOR.0]))
                }
                error => error,
            })
        })
    }

    /// The chain of effects of a stage, if it has one; its files are seen from its folder.
    ///
    /// # Errors
    /// The stage is not TOML, or has two.
    pub fn stage_chain(stage: &Stage) -> Result<Option<Vec<String>>, Box<Diagnostic>> {
        Self::chain_of_file(&settings_of(stage)?)
    }

    /// The older names that a stage uses, those of settings, too: each once.
    pub fn stage_older_names(stage: &Stage) -> Vec<&'static NameChange> {
        let of_settings = settings_of(stage).map(|file| file.older_names()).unwrap_or_default();
        stage.older_names().iter().copied().chain(of_settings).collect()
    }

    /// The settings of a stage, as a file of settings has them.
    ///
    /// # Errors
    /// The stage is not TOML.
    pub fn stage_settings(stage: &Stage) -> Result<SettingsFile, Box<Diagnostic>> {
        settings_of(stage)
    }
}

/// The settings of a stage by their keys, but those of [`COLOR`].
fn settings_of(stage: &Stage) -> Result<SettingsFile, Box<Diagnostic>> {
    let [environment, fog, effects, settings] = SETTINGS_TABLES.map(|(name, _)| name);
    let prefixes = [(environment, "environment."), (fog, "fog."), (effects, "effects."), (settings, "")];
    SettingsFile::of_tables(stage.file(), stage.text(), &prefixes)
}

/// The JSON Schema (draft 2020-12) of stage files, by which editors complete and check them.
pub fn stage_schema() -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for table in &TABLES {
        let schema = of_table(table);
        if table.name.is_empty() {
            properties.extend(schema["properties"].as_object().cloned().unwrap_or_default());
            required.push(schema["required"].clone());
        } else {
            properties.insert(table.name.into(), json!({ "type": "array", "items": schema, "description": table.doc }));
            for row in renamed_to(NameKind::StageTable, table.name) {
                let same = json!({ "$ref": format!("#/properties/{}", table.name) });
                properties.insert(row.older.into(), deprecated(same, row));
            }
        }
    }
    let built_in: Vec<EffectFile> =
        EffectFile::built_in_names().filter_map(EffectFile::built_in).filter_map(Result::ok).collect();
    let all = schema(Settings::declared().iter().chain(built_in.iter().flat_map(EffectFile::settings)));
    for (name, doc) in SETTINGS_TABLES {
        let group = &all["properties"][name];
        let mut of_group = if group.is_null() {
            // Tables of effects of one's own have any name.
            json!({ "type": "object", "additionalProperties": { "type": "object" }, "properties": all["properties"] })
        } else {
            group.clone()
        };
        if COLOR.0.split_once('.').is_some_and(|(table, _)| table == name) {
            of_group["properties"]["color"] = described(color_schema(), "What surrounds the scene, of one colour.");
        }
        properties.insert(name.into(), described(of_group, doc));
    }
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Stages of Manypass",
        "type": "object",
        "additionalProperties": false,
        "required": required.into_iter().next().unwrap_or_default(),
        "properties": properties,
    })
}

fn described(mut schema: Value, doc: &str) -> Value {
    schema["description"] = doc.into();
    schema
}

/// The older names of what is called `name` today.
fn renamed_to(kind: NameKind, name: &str) -> impl Iterator<Item = &'static NameChange> {
    RENAMED.iter().filter(move |row| row.kind == kind && row.name == name)
}

fn of_table(table: &StageTable) -> Value {
    let mut properties: Map<String, Value> =
        table.keys.iter().map(|key| (key.name.into(), described(of_key(key), key.doc))).collect();
    for key in table.keys {
        let older = renamed_to(NameKind::StageKey(table.name), key.name);
        properties.extend(older.map(|row| (row.older.into(), deprecated(of_key(key), row))));
    }
    let required: Vec<&str> = table.keys.iter().filter(|key| key.is_required).map(|key| key.name).collect();
    json!({ "type": "object", "additionalProperties": false, "required": required, "properties": properties })
}

/// A list of so many numbers.
fn numbers(count: usize) -> Value {
    json!({ "type": "array", "items": { "type": "number" }, "minItems": count, "maxItems": count })
}

fn of_key(key: &StageKey) -> Value {
    let number =
        |number: f64| if number.fract() == 0.0 && number < 1e15 { json!(number as i64) } else { json!(number) };
    match key.kind {
        StageType::Text => json!({ "type": "string" }),
        StageType::Boolean => json!({ "type": "boolean" }),
        StageType::Word(words) => json!({ "enum": words }),
        StageType::Color => color_schema(),
        StageType::Pair => numbers(2),
        StageType::Vector => numbers(3),
        StageType::Layers => json!({ "type": "array", "items": { "type": "integer", "minimum": 0, "maximum": 31 } }),
        StageType::Pairs => json!({ "type": "array", "items": numbers(2), "minItems": 2 }),
        StageType::Vectors => json!({ "type": "array", "items": numbers(3), "minItems": 2 }),
        StageType::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        StageType::Values => {
            let number = json!({ "type": "number" });
            let list = json!({ "type": "array", "items": number, "minItems": 1, "maxItems": 4 });
            json!({ "type": "object", "additionalProperties": { "anyOf": [number, list] } })
        }
        StageType::Number { min, is_above, max } => {
            let least = if is_above { "exclusiveMinimum" } else { "minimum" };
            let mut schema = json!({ "type": "number", "maximum": number(max) });
            schema[least] = number(min);
            schema
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use crate::{Environment, FogMode, Tonemap};

    fn applied(text: &str) -> Result<Settings, String> {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut settings = Settings::default();
        settings.apply_stage(&stage, &mut []).map_err(|error| error.to_string())?;
        Ok(settings)
    }

    #[test]
    fn tables_of_settings_are_settings() {
        let settings = applied(
            "[environment]\ncolor = \"ff0000\"\nintensity = 2\n[fog]\nmode = \"linear\"\nend_m = 30\ncolor = [1, 0.5, 0]\n\
             [settings.tone_map]\ncurve = \"aces\"\n[settings]\nrender.scale = 0.5\n",
        )
        .unwrap();
        assert_eq!(settings.environment.source, Environment::Color([1.0, 0.0, 0.0]));
        assert_eq!(
            (settings.environment.intensity, settings.fog.mode, settings.fog.end_m),
            (2.0, FogMode::Linear, 30.0)
        );
        assert_eq!((settings.fog.color.0, settings.fog.start_m), ([1.0, 0.5, 0.0], 0.0));
        assert_eq!((settings.tone_map.curve, settings.render.scale), (Tonemap::Aces, 0.5));
        assert_eq!(applied("[environment]\nsource = \"none\"").unwrap().environment.source, Environment::None);
    }

    #[test]
    fn older_names_are_told_of_tables_keys_and_settings() {
        let text = "model = \"demo:surroundings\"\n[settings.shadows]\nturns = false\n[[surroundings]]\ncenter = [0, 1, 0]\n\
                    size_m = [4, 2, 6]\n[[surroundings]]\ncenter = [0, 1, 9]\nsize_m = [4, 2, 6]\n";
        let stage = Stage::parse("a.stage.toml", text).unwrap();
        let older: Vec<&str> = Settings::stage_older_names(&stage).iter().map(|renamed| renamed.older).collect();
        assert_eq!(older, ["surroundings", "surroundings", "shadows.turns"], "a table, a demo and a setting");
        let mut settings = Settings::default();
        settings.apply_stage(&stage, &mut []).unwrap();
        assert!(!settings.shadows.spread_over_samples);
    }

    #[test]
    fn the_schema_has_older_names_as_deprecated() {
        let schema = stage_schema();
        let of_table = |name: &str| schema["properties"][name].clone();
        for row in &RENAMED {
            let [older, now] = [row.older, row.name].map(|name| match row.kind {
                NameKind::StageTable => of_table(name),
                NameKind::StageKey(table) => of_table(table)["items"]["properties"][name].clone(),
                NameKind::Setting => {
                    let (group, field) = name.split_once('.').unwrap();
                    of_table("settings")["properties"][group]["properties"][field].clone()
                }
                // A text, as all models are.
                NameKind::Demo => json!({ "deprecated": name == row.older }),
            });
            assert_eq!(older["deprecated"], Value::Bool(true), "{row}");
            assert!(now.is_object() && now["deprecated"] != Value::Bool(true), "{row}: {now}");
        }
        assert_eq!(of_table("surroundings")["$ref"], "#/properties/reflection_probes");
    }

    #[test]
    fn wrong_settings_are_told_with_their_place() {
        for (text, expected) in [
            (
                "[environment]\ncolour = \"ff0000\"",
                "3:1: error: no setting is called `environment.colour`; did you mean `environment.color`?",
            ),
            ("[fog]\nmode = \"thick\"", "3:8: error: `thick` is not a value of `fog.mode`, which takes none, linear"),
            ("[fog]\ndensity_per_m = nan", "3:17: error:"),
            ("[fog]\ndensity_per_m = -1", "3:17: error: `-1` is not a value of `fog.density_per_m`"),
            ("[fog]\nstart_m = inf", "3:11: error:"),
            (
                "[settings.tone_map]\ncurv = \"aces\"",
                "3:1: error: no setting is called `tone_map.curv`; did you mean `tone_map.curve`?",
            ),
            ("[settings]\nmodel = 1", "3:1: error: no setting is called `model`"),
        ] {
            let error = applied(text).expect_err(text);
            assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
        }
    }

    #[test]
    fn the_schema_says_the_same() {
        let schema = stage_schema();
        assert_eq!(schema["required"], json!(["model"]));
        let properties = &schema["properties"];
        let light = &properties["lights"]["items"]["properties"];
        assert_eq!(light["kind"]["enum"], json!(["point", "spot", "directional"]));
        assert_eq!(
            (&light["outer_cone_deg"]["exclusiveMinimum"], &light["outer_cone_deg"]["maximum"]),
            (&json!(0), &json!(90))
        );
        assert_eq!(properties["nodes"]["items"]["required"], json!(["name"]));
        assert_eq!(properties["fog"]["properties"]["start_m"]["minimum"], 0);
        assert!(properties["environment"]["properties"]["color"]["anyOf"].is_array());
        assert_eq!(properties["settings"]["properties"]["render"]["properties"]["scale"]["maximum"], 2);
    }
}
