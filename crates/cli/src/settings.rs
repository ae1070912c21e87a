//! `settings`: every key, for people, as JSON, or as a schema for editors.

use crate::failure::{Failure, Kind};
use crate::request::effect_files;
use crate::session::print;
use manypass::settings::schema;
use manypass::{EffectFile, Quality, SettingInfo, Settings};
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
        return print(&format!("{:#}\n", schema(infos)));
    }
    if as_json {
        let text = serde_json::to_string_pretty(&infos)
            .map_err(|error| Failure::new(Kind::Failed, error, "leave --json out"))?;
        return print(&format!("{text}\n"));
    }
    print(&table(&infos))
}

/// Runs `settings --stage-schema`.
///
/// # Errors
/// Standard output is closed.
pub fn stage_schema() -> Result<(), Failure> {
    print(&format!("{:#}\n", manypass::stage_schema()))
}

/// Runs `settings --quality`: the settings of a tier as TOML.
///
/// # Errors
/// Standard output is closed.
pub fn tier(quality: Quality) -> Result<(), Failure> {
    let mut text = format!("# The tier `{}`", quality.name());
    text.push_str(if quality.table().is_empty() { ": everything as it is by default.\n" } else { ".\n" });
    for (key, value) in quality.table() {
        let is_plain = value.parse::<f64>().is_ok() || value.parse::<bool>().is_ok();
        let quote = if is_plain { "" } else { "\"" };
        text.push_str(&format!("{key} = {quote}{value}{quote}\n"));
    }
    print(&text)
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
