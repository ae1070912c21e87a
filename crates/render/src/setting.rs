//! What one setting is: how a pass declares it, what text and files may give it, and what is told of it.
//!
//! Nothing here knows a pass; [`crate::settings`] composes what the passes declare.

mod color;
mod declare;
mod field;
mod file;
mod info;
mod rounded;
mod schema;
mod switch;
mod typed;

pub use color::LinearColor;
pub(crate) use color::{read_word_or_color, word_or_color};
pub(crate) use declare::{choices, settings};
pub use field::SettingField;
pub use file::SettingsFile;
pub use info::{NumberType, Scalar, SettingInfo, SettingType, SettingValue};
pub(crate) use rounded::rounded_up;
pub use schema::schema;
pub(crate) use schema::{color_schema, deprecated};
pub use switch::Switch;

use crate::diagnostic::Diagnostic;
use manypass_scene::spelling::edit_distance;
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use serde::ser::{SerializeMap, Serializer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// The error of a setting that was refused.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum SettingsError {
    /// No setting has that key.
    #[error("no setting is called `{key}`{}", suggestion(nearest.as_deref()))]
    UnknownKey {
        /// The key that was given.
        key: String,
        /// The key most like it, if any is like it.
        nearest: Option<String>,
    },
    /// The value has another type or lies outside its range.
    #[error("`{value}` is not a value of `{key}`, which takes {expected}")]
    BadValue {
        /// The key.
        key: String,
        /// The value that was given.
        value: String,
        /// The type and the range, in words.
        expected: String,
    },
    /// A setting that does not go with the value of another.
    #[error("`{key}` needs `{needs}`, which is `{found}`")]
    Needs {
        /// The key with its value.
        key: String,
        /// The key and value of the other.
        needs: &'static str,
        /// The value that the other has.
        found: &'static str,
    },
    /// A file of settings is wrong.
    #[error(transparent)]
    File(#[from] Box<Diagnostic>),
}

/// A value as somebody wrote it: on the command line, where commas stand between the parts of a vector or list unless it
/// is an array as in a file, or in a file, whose values have types.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(from = "SettingValue")]
pub enum SettingInput {
    /// One text, of a value of any type.
    Text(String),
    /// The texts of the parts of a list.
    List(Vec<String>),
    /// A value of a file. It must have the type that [`schema()`] says: a text in quotes is no number.
    Typed(SettingValue),
}

impl SettingInput {
    /// The text, without space around it if it has no type; none of a list.
    pub fn text(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Text(text) => Some(text.trim().into()),
            Self::List(_) => None,
            Self::Typed(SettingValue::Text(text)) => Some(text.into()),
            Self::Typed(value) => value.entries().is_none().then(|| value.to_string().into()),
        }
    }

    /// The parts of a list, or of a text with commas between them; an empty text has none.
    pub fn parts(&self) -> Vec<Cow<'_, str>> {
        if let Some(entries) = self.entries() {
            return entries.iter().map(|entry| entry.to_string().into()).collect();
        }
        match self {
            Self::Text(text) if text.trim().is_empty() => Vec::new(),
            Self::Text(text) => text.split(',').map(|part| part.trim().into()).collect(),
            Self::List(parts) => parts.iter().map(|part| part.trim().into()).collect(),
            Self::Typed(value) => vec![value.to_string().into()],
        }
    }

    /// The entries of an array, be it of a file or a text in the form of one, which may hold commas.
    fn entries(&self) -> Option<Vec<SettingValue>> {
        match self {
            Self::Text(text) => file::array(text)?.entries(),
            Self::List(_) => None,
            Self::Typed(value) => value.entries(),
        }
    }
}

impl From<&str> for SettingInput {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<SettingValue> for SettingInput {
    fn from(value: SettingValue) -> Self {
        Self::Typed(value)
    }
}

/// As it stands, but for the quotes of a text that is no part of a list.
impl Display for SettingInput {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text.trim()),
            Self::List(parts) => f.write_str(&parts.join(",")),
            // JSON knows no infinity.
            Self::Typed(SettingValue::Text(text)) => f.write_str(text),
            Self::Typed(SettingValue::Number(number)) => write!(f, "{number:?}"),
            Self::Typed(value) => f.write_str(&serde_json::to_string(value).map_err(|_| fmt::Error)?),
        }
    }
}

/// The settings of one pass; the macro `settings!` makes it.
pub trait Group {
    /// What is declared. Keys are names of fields.
    fn declared() -> Vec<SettingInfo>
    where
        Self: Sized;

    /// The value of a field.
    fn value(&self, field: &str) -> Option<SettingValue>;

    /// Gives a field the value that was written; `info` is what is declared of it, with its whole key.
    ///
    /// # Errors
    /// No field has that name, or the value is none of its type or outside its range.
    fn give(&mut self, field: &str, info: &SettingInfo, written: &SettingInput) -> Result<(), SettingsError>;
}

/// A group as a map of its fields.
pub(crate) fn serialize_group<G: Group, S: Serializer>(group: &G, serializer: S) -> Result<S::Ok, S::Error> {
    let infos = G::declared();
    let mut map = serializer.serialize_map(Some(infos.len()))?;
    for info in &infos {
        map.serialize_entry(&info.key, &group.value(&info.key))?;
    }
    map.end()
}

/// A group of a map of its fields: what is left out has its default, and ranges are checked.
pub(crate) fn deserialize_group<'de, G: Group + Default, D: Deserializer<'de>>(deserializer: D) -> Result<G, D::Error> {
    let infos = G::declared();
    let mut group = G::default();
    for (field, written) in BTreeMap::<String, SettingInput>::deserialize(deserializer)? {
        let info = infos.iter().find(|info| info.key == field);
        let known = || infos.iter().map(|info| &*info.key);
        let info = info.ok_or_else(|| D::Error::custom(unknown_key(&field, known())))?;
        group.give(&field, info, &written).map_err(D::Error::custom)?;
    }
    Ok(group)
}

/// The error of a key that is not among `known`.
pub(crate) fn unknown_key<'k>(key: &str, known: impl Iterator<Item = &'k str>) -> SettingsError {
    SettingsError::UnknownKey { key: key.into(), nearest: nearest_key(key, known).map(Into::into) }
}

fn suggestion(nearest: Option<&str>) -> String {
    nearest.map(|nearest| format!("; did you mean `{nearest}`?")).unwrap_or_default()
}

/// The known key with the smallest edit distance (Levenshtein 1966), if two of three letters stay; where the key has
/// the last part of known keys, or is like the name of their group, among those. A key of a group that is not known at
/// all has nothing in common with others but that last part.
fn nearest_key<'k>(key: &str, known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    let last = |key: &str| key.rsplit('.').next().map(str::to_owned);
    let is_like = |known: &str| 3 * edit_distance(key, known) <= key.len();
    let known: Vec<&str> = known.collect();
    let group = |key: &str| key.split_once('.').map(|(group, _)| group.to_owned());
    let has_known_group = group(key).is_none() || known.iter().any(|known| group(known) == group(key));
    let has_last = |known: &str| has_known_group && last(known) == last(key);
    let is_other = |known: &str| !has_last(known) && !known.split('.').next().is_some_and(is_like);
    // Of several that are as near the first one that is declared.
    let (is_other, _, nearest) = known
        .into_iter()
        .map(|known| (is_other(known), edit_distance(key, known), known))
        .min_by_key(|(is_other, distance, _)| (*is_other, *distance))?;
    (!is_other || is_like(nearest)).then_some(nearest)
}

#[cfg(test)]
mod tests;
