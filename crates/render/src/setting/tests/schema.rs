//! The schema and the reader of files against each other: what one takes the other takes.

use super::{Everything, give};
use crate::setting::{SettingInput, SettingType, SettingsError, SettingsFile, schema};
use crate::settings::Settings;
use manypass_scene::renamed::{NameKind, RENAMED};
use regex::Regex;
use serde_json::Value;

/// Values as a file writes them: every form that the documentation has, and forms near to them.
const LITERALS: &[&str] = &[
    "0",
    "1",
    "2",
    "3",
    "5",
    "-1",
    "-65",
    "64",
    "65",
    "16",
    "+16",
    "0x10",
    "0o20",
    "0b1",
    "1_6",
    "202428",
    "5000000000",
    "0.5",
    "16.0",
    "1.5",
    "-0.5",
    "1e39",
    "-1e39",
    "1e300",
    "3.4e38",
    "64.5",
    "true",
    "false",
    "\"\"",
    "\"0.5\"",
    "\"16\"",
    "\"true\"",
    "\"True\"",
    "\"yes\"",
    "\" true\"",
    "\"a, b\"",
    "\"1,0,0\"",
    "\"a.ktx2\"",
    "\"auto\"",
    "\"auto+1\"",
    "\"auto-0.5\"",
    "\"auto+64\"",
    "\"auto+64.0\"",
    "\"auto+64.1\"",
    "\"auto-65\"",
    "\"auto+1e0\"",
    "\"auto+.5\"",
    "\"auto+1.\"",
    "\"auto+.\"",
    "\"auto+\"",
    "\"auto1\"",
    "\"auto+007\"",
    "\"auto++1\"",
    "\"auto \"",
    "\"auto+1 \"",
    "\"Auto\"",
    "\"scene\"",
    "\" scene\"",
    "\"inf\"",
    "\"nan\"",
    "\"ff8800\"",
    "\"FF8800\"",
    "\"#ff8800\"",
    "\"##f8800\"",
    "\"ff880\"",
    "\"112233\"",
    "\" ff8800\"",
    "\"gg8800\"",
    "[]",
    "[true]",
    "[0.5]",
    "[1]",
    "[1, 2]",
    "[1, -1]",
    "[1.5, 2]",
    "[0.5, 1]",
    "[0.5, 2]",
    "[0, 0.25, 1]",
    "[0, 1, 7]",
    "[1, -1, 0]",
    "[1e39, 0, 0]",
    "[\"1\", \"0\", \"0\"]",
    "[[1, 0], 0]",
    "[1, 2, 3, 4]",
    "[\"agx\"]",
    "[\"round\"]",
    "[\"round\", \"square\"]",
    "[\"oval\"]",
    "[\"round,square\"]",
    "\"round,square\"",
    "\"round\"",
    "\"0,1,0\"",
];

/// Whether `value` is valid, by the words of JSON Schema that our schemas use; another one fails the test.
fn is_valid(schema: &Value, value: &Value) -> bool {
    let number = |name: &str| schema[name].as_f64();
    schema.as_object().unwrap().keys().all(|word| match word.as_str() {
        "type" => match schema[word].as_str().unwrap() {
            "number" => value.is_number(),
            "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
            "boolean" => value.is_boolean(),
            "string" => value.is_string(),
            "array" => value.is_array(),
            "object" => value.is_object(),
            other => panic!("type {other}"),
        },
        "enum" => schema[word].as_array().unwrap().contains(value),
        "anyOf" => schema[word].as_array().unwrap().iter().any(|schema| is_valid(schema, value)),
        "pattern" => {
            let pattern = Regex::new(schema[word].as_str().unwrap()).unwrap();
            value.as_str().is_none_or(|text| pattern.is_match(text))
        }
        "minimum" => value.as_f64().is_none_or(|value| value >= number(word).unwrap()),
        "maximum" => value.as_f64().is_none_or(|value| value <= number(word).unwrap()),
        "items" => value.as_array().is_none_or(|items| items.iter().all(|item| is_valid(&schema[word], item))),
        "minItems" => value.as_array().is_none_or(|items| items.len() as f64 >= number(word).unwrap()),
        "maxItems" => value.as_array().is_none_or(|items| items.len() as f64 <= number(word).unwrap()),
        "properties" => value.as_object().is_none_or(|entries| {
            let known = |(name, value): (&String, &Value)| schema[word].get(name).is_none_or(|s| is_valid(s, value));
            entries.iter().all(known)
        }),
        "additionalProperties" => {
            value.as_object().is_none_or(|entries| entries.keys().all(|name| schema["properties"].get(name).is_some()))
        }
        "$schema" | "title" | "description" | "default" | "deprecated" => true,
        other => panic!("the test knows no `{other}`"),
    })
}

#[test]
fn files_take_what_the_schema_takes() {
    let mut settings = Settings::default();
    let mut group = Everything::default();
    let mut set = |key: &str, written: &SettingInput| -> Result<(), SettingsError> {
        if key.starts_with("everything.") { give(&mut group, key, written) } else { settings.give(key, written) }
    };
    let infos: Vec<_> = Settings::declared().iter().cloned().chain(super::infos()).collect();
    let schema = schema(&infos);
    let mut taken = 0;
    for info in &infos {
        let words = info.choices.iter().map(|word| format!("\"{word}\""));
        for literal in LITERALS.iter().map(|literal| (*literal).to_owned()).chain(words) {
            let text = format!("{} = {literal}", info.key);
            // The reader of the library itself, which knows no setting.
            let value: Value = toml::from_str(&text).unwrap();
            let read = SettingsFile::parse("a.toml", &text).and_then(|file| file.apply(&mut set));
            assert_eq!(read.is_ok(), is_valid(&schema, &value), "{text}: {read:?}");
            taken += usize::from(read.is_ok());
        }
    }
    assert!(taken > 100, "{taken}");
}

#[test]
fn older_keys_are_deprecated_in_the_schema_and_take_what_they_are_called_now() {
    let schema = schema(Settings::declared());
    let of_key = |key: &str| {
        let (group, field) = key.split_once('.').unwrap();
        &schema["properties"][group]["properties"][field]
    };
    for row in RENAMED.iter().filter(|row| row.kind == NameKind::Setting) {
        let [older, now] = [row.older, row.name].map(of_key);
        assert_eq!(older["deprecated"], Value::Bool(true), "{row}");
        assert_eq!((&older["type"], &now["deprecated"]), (&now["type"], &Value::Null), "{row}");
        assert!(older["description"].as_str().unwrap().contains(row.name), "{older}");
    }
}

#[test]
fn what_the_command_line_takes_a_file_takes_in_its_form() {
    for info in Settings::declared() {
        for word in info.choices {
            let mut settings = [Settings::default(), Settings::default()];
            settings[0].set(&info.key, word).unwrap();
            // Numbers of which it takes a few alone are numbers there.
            let is_number = matches!(info.kind, SettingType::Number(_));
            let in_file = if is_number { word.parse().unwrap() } else { Value::from(*word) };
            settings[1].give(&info.key, &serde_json::from_value(in_file).unwrap()).unwrap();
            assert_eq!(settings[0], settings[1], "{}={word}", info.key);
        }
    }
}

#[test]
fn refusals_in_files_show_the_value_as_it_stands_and_name_the_remedy() {
    let mut settings = Settings::default();
    let mut refused = |text: &str| {
        let read = SettingsFile::parse("a.toml", text).and_then(|file| file.apply(|key, to| settings.give(key, to)));
        read.unwrap_err().to_string()
    };
    for (text, expected) in [
        ("tone_map.curve = [\"agx\"]", "`[\"agx\"]` is not a value of `tone_map.curve`, which takes neutral,"),
        ("tone_map.curve = [\"agx\"]", "exponential or none; write it without brackets"),
        (
            "render.scale = \"0.5\"",
            "`0.5` is not a value of `render.scale`, which takes a number from 0.25 to 2; write it without q",
        ),
        ("background.source = 202428", "such as ff8800,112233; write it in quotes"),
        ("exposure.stops = \"1.5\"", "such as auto+1 or auto-0.5; write it without quotes"),
        (
            "environment.intensity = 1e39",
            "`1e39` is not a value of `environment.intensity`, which takes a number of at",
        ),
        ("environment.intensity = 1e39", "; 32 bits hold numbers up to 3.4028235e38"),
        ("environment.intensity = inf", "`inf` is not a value"),
    ] {
        let error = refused(text);
        assert!(error.contains(expected), "{text}: {error}");
    }
    let error = settings.set("environment.intensity", "1e39").unwrap_err().to_string();
    assert!(error.ends_with("; 32 bits hold numbers up to 3.4028235e38"), "{error}");
}
