//! A file of settings: TOML, whose tables are the groups of keys.

use super::{SettingInput, SettingValue, SettingsError};
use crate::diagnostic::Diagnostic;
use manypass_scene::renamed::{NameChange, NameKind, RENAMED};
use std::fmt::Display;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A file of settings that is valid TOML; what its keys mean is not known yet.
#[derive(Clone, Debug)]
pub struct SettingsFile {
    file: String,
    text: String,
    entries: Vec<Entry>,
}

/// One value, and where it and its key stand.
#[derive(Clone, Debug)]
struct Entry {
    key: String,
    key_range: Range<usize>,
    value: SettingInput,
    value_range: Range<usize>,
}

impl SettingsFile {
    /// Reads the keys and values of a TOML `text`. `file` appears in errors.
    ///
    /// # Errors
    /// The text is not TOML.
    pub fn parse(file: &str, text: &str) -> Result<Self, Box<Diagnostic>> {
        Self::of_document(file, text, |document, entries| collect(document, "", entries))
    }

    fn of_document(
        file: &str,
        text: &str,
        collect: impl FnOnce(&DeTable<'_>, &mut Vec<Entry>),
    ) -> Result<Self, Box<Diagnostic>> {
        let table = DeTable::parse(text).map_err(|error| {
            let range = error.span().unwrap_or(text.len()..text.len());
            Box::new(Diagnostic::new(file, text, range, error.message()))
        })?;
        let mut entries = Vec::new();
        collect(table.get_ref(), &mut entries);
        // Errors are told from the top.
        entries.sort_by_key(|entry| entry.key_range.start);
        Ok(Self { file: file.into(), text: text.into(), entries })
    }

    /// Reads some of the tables of a TOML `text`, each with what its keys begin with in place of its name.
    ///
    /// # Errors
    /// The text is not TOML.
    pub(crate) fn of_tables(file: &str, text: &str, tables: &[(&str, &str)]) -> Result<Self, Box<Diagnostic>> {
        Self::of_document(file, text, |document, entries| {
            for (name, value) in document {
                let prefix = tables.iter().find(|(table, _)| *table == &**name.get_ref()).map(|(_, prefix)| prefix);
                if let (Some(prefix), DeValue::Table(table)) = (prefix, value.get_ref()) {
                    collect(table, prefix, entries);
                }
            }
        })
    }

    /// What it says of the setting `key`, if it does; of several the last.
    pub fn last(&self, key: &str) -> Option<&SettingInput> {
        self.entries.iter().rev().find(|entry| entry.key == key).map(|entry| &entry.value)
    }

    /// The older keys that it uses, each once.
    pub fn older_names(&self) -> Vec<&'static NameChange> {
        let is_used = |row: &&NameChange| row.kind == NameKind::Setting && self.last(row.older).is_some();
        RENAMED.iter().filter(is_used).collect()
    }

    /// The refusal of the value of `key`, of several the last, at its place: of the text `part` in it, if that stands there.
    pub(crate) fn refusal(&self, key: &str, part: Option<&str>, message: impl Display) -> Option<Box<Diagnostic>> {
        let entry = self.entries.iter().rev().find(|entry| entry.key == key)?;
        let whole = entry.value_range.clone();
        let value = self.text.get(whole.clone())?;
        let quoted = |part: &str| {
            let found = ['"', '\''].iter().find_map(|quote| {
                let text = format!("{quote}{part}{quote}");
                Some((value.rfind(&text)?, text.len()))
            });
            found.map(|(at, length)| whole.start + at..whole.start + at + length)
        };
        let range = part.and_then(quoted).unwrap_or(whole.clone());
        Some(Box::new(Diagnostic::new(&self.file, &self.text, range, message)))
    }

    /// Gives every key and value to `set`, from the top.
    ///
    /// # Errors
    /// The first one that `set` refuses, with its place in the file.
    pub fn apply(
        &self,
        mut set: impl FnMut(&str, &SettingInput) -> Result<(), SettingsError>,
    ) -> Result<(), Box<Diagnostic>> {
        for Entry { key, key_range, value, value_range } in &self.entries {
            let Err(error) = set(key, value) else { continue };
            let range = if matches!(error, SettingsError::UnknownKey { .. }) { key_range } else { value_range };
            return Err(Box::new(Diagnostic::new(&self.file, &self.text, range.clone(), error)));
        }
        Ok(())
    }
}

fn collect(table: &DeTable<'_>, prefix: &str, entries: &mut Vec<Entry>) {
    for (name, value) in table {
        let key = format!("{prefix}{}", name.get_ref());
        match value.get_ref() {
            DeValue::Table(inner) => collect(inner, &format!("{key}."), entries),
            inner => {
                let written = match inner {
                    // No type of a setting.
                    DeValue::Datetime(time) => SettingInput::Text(time.to_string()),
                    inner => typed(inner).into(),
                };
                entries.push(Entry { key, key_range: name.span(), value: written, value_range: value.span() });
            }
        }
    }
}

/// What a text is that is an array of TOML, as files have it; none of another text.
pub(super) fn array(text: &str) -> Option<SettingValue> {
    if !text.trim_start().starts_with('[') {
        return None;
    }
    let document = format!("value = {text}");
    let document = DeTable::parse(&document).ok()?;
    // A text of several lines may go on behind the array.
    let values = document.get_ref();
    let value = values.get("value").filter(|_| values.len() == 1)?.get_ref();
    matches!(value, DeValue::Array(_)).then(|| typed(value))
}

/// A value with its type. What no setting takes becomes a text that none takes.
fn typed(value: &DeValue<'_>) -> SettingValue {
    match value {
        DeValue::String(text) => SettingValue::Text(text.to_string()),
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
            .map_or_else(|_| SettingValue::Text(number.to_string()), SettingValue::Integer),
        DeValue::Float(number) => {
            number.as_str().parse().map_or_else(|_| SettingValue::Text(number.to_string()), SettingValue::Number)
        }
        DeValue::Boolean(flag) => SettingValue::Boolean(*flag),
        DeValue::Datetime(time) => SettingValue::Text(time.to_string()),
        DeValue::Array(values) => SettingValue::List(values.iter().map(Spanned::get_ref).map(typed).collect()),
        DeValue::Table(_) => SettingValue::Text("a table".into()),
    }
}
