//! `settings`: every key, for people, as JSON, or as a schema for editors.

use crate::chosen::key_value;
use crate::failure::{Failure, Kind};
use crate::job::check_settings;
use crate::older::ToldNames;
use crate::request::effect_files;
use crate::session::list;
use manypass::settings::schema;
use manypass::{EffectFile, Quality, SettingInfo, Settings, effect};
use manypass_scene::renamed::{NameKind, current, renamed};
use std::path::PathBuf;

/// Where lines of descriptions break.
const LINE_CHARACTERS: usize = 110;
/// The narrowest column of descriptions.
const DOC_CHARACTERS: usize = 30;

/// Runs `settings`: the keys of the frame, then those of `effects`.
///
/// # Errors
/// A file that cannot be read or is no effect.
pub fn settings(effects: &[PathBuf], as_json: bool, as_schema: bool) -> Result<(), Failure> {
    let effects = effect_files(effects)?;
    let infos: Vec<&SettingInfo> =
        Settings::declared().iter().chain(effects.iter().flat_map(EffectFile::settings)).collect();
    if as_schema {
        return list(&format!("{:#}\n", schema(infos)));
    }
    if as_json {
        let text = serde_json::to_string_pretty(&infos)
            .map_err(|error| Failure::new(Kind::Failed, error, "leave --json out"))?;
        return list(&format!("{text}\n"));
    }
    list(&table(&infos))
}

/// Runs `settings --stage-schema`.
///
/// # Errors
/// Standard output is full.
pub fn stage_schema() -> Result<(), Failure> {
    list(&format!("{:#}\n", manypass::stage_schema()))
}

/// Runs `settings --quality` and `settings --set`: what a tier and then pairs of `KEY=VALUE` set, as TOML; each key once,
/// with the value that counts.
///
/// # Errors
/// A file that is no effect; a wrong key or value, or what does not go together; standard output is full.
pub fn chosen(quality: Option<Quality>, set: &[String], effects: &[PathBuf]) -> Result<(), Failure> {
    let mut files = effect_files(effects)?;
    let mut text = String::new();
    let mut pairs: Vec<(String, String)> = Vec::new();
    let mut settings = Settings::default();
    if let Some(quality) = quality {
        let is_default = if quality.table().is_empty() { ": everything as it is by default" } else { "" };
        text.push_str(&format!("# The tier `{}`{is_default}.\n", quality.name()));
        pairs.extend(quality.table().iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())));
        settings.apply_quality(quality).map_err(|error| Failure::usage(error, "report this"))?;
    }
    for pair in set {
        let (written, value) = key_value(pair)?;
        let key = current(NameKind::Setting, written);
        effect::set_of_file(&mut settings, &mut files, key, &value.into()).map_err(|error| {
            Failure::usage(error, "`manypass settings` lists the keys, and with --effect NAME those of an effect")
        })?;
        pairs.retain(|(known, _)| known != key);
        pairs.push((key.to_owned(), value.to_owned()));
    }
    check_settings(&settings)?;
    for (key, value) in pairs {
        text.push_str(&format!("{key} = {}\n", toml_value(&settings, &files, &key, &value)));
    }
    let older: Vec<_> = set.iter().filter_map(|pair| renamed(NameKind::Setting, key_value(pair).ok()?.0)).collect();
    ToldNames::default().say("--set", &older);
    list(&text)
}

/// The value of a key as TOML has it, with the type of its setting.
fn toml_value(settings: &Settings, effects: &[EffectFile], key: &str, value: &str) -> String {
    if value.parse::<f64>().is_ok_and(f64::is_finite) || value.parse::<bool>().is_ok() {
        return value.to_owned();
    }
    let (group, field) = key.split_once('.').unwrap_or(("effects", key));
    let of_effects = || effects.iter().flat_map(EffectFile::values).find(|(known, _)| known == key);
    let typed = match of_effects() {
        Some((_, value)) => serde_json::to_value(value),
        None => serde_json::to_value(settings).map(|settings| settings[group][field].clone()),
    };
    match typed {
        Ok(typed) if !typed.is_null() => typed.to_string(),
        // Of a built-in effect that is in no chain.
        _ if value.contains(',') => format!("[{value}]"),
        _ => format!("{value:?}"),
    }
}

fn table(infos: &[&SettingInfo]) -> String {
    let header = ["key", "type", "default", "range", "unit", "what it does"].map(str::to_owned);
    let rows: Vec<[String; 6]> = std::iter::once(header).chain(infos.iter().map(|info| row(info))).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 5] = std::array::from_fn(width);
    let indent = widths.iter().sum::<usize>() + 2 * widths.len();
    let doc_width = LINE_CHARACTERS.saturating_sub(indent).max(DOC_CHARACTERS);
    let mut text = String::new();
    for row in &rows {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(widths) {
            line.push_str(&format!("{cell:width$}  "));
        }
        for doc in wrapped(&row[5], doc_width) {
            line.push_str(&doc);
            text.push_str(line.trim_end());
            text.push('\n');
            line = " ".repeat(indent);
        }
    }
    text
}

fn row(info: &SettingInfo) -> [String; 6] {
    [
        info.key.to_string(),
        info.kind.to_string(),
        info.default.as_ref().map_or("must be given".into(), ToString::to_string),
        info.range(),
        info.unit.as_deref().unwrap_or_default().to_owned(),
        info.sentences(""),
    ]
}

/// Lines of at most `width` characters, broken between words; at least one.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let Some(line) = lines.last_mut() else { break };
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= width {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}
