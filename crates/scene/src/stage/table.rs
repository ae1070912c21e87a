//! A table of a stage file whose keys and values are those that are declared, with their places.

use super::keys::{StageKey, StageTable, StageType};
use super::older;
use crate::colour::linear_from_srgb;
use crate::light::LIGHTS_MAX;
use crate::renamed::{NameKind, current};
use crate::{Diagnostic, spelling};
use glam::{Vec2, Vec3};
use std::fmt::Display;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a stage and its name in errors.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) file: String,
    pub(super) text: String,
}

impl Source {
    /// An error at a place in the text.
    pub(super) fn fault(&self, range: Range<usize>, message: impl Display) -> Box<Diagnostic> {
        Box::new(Diagnostic::new(&self.file, &self.text, range, message))
    }

    /// An error of a name that is not known.
    pub(super) fn unknown<'k>(
        &self,
        range: Range<usize>,
        message: impl Display,
        name: &str,
        known: impl Iterator<Item = &'k str>,
    ) -> Box<Diagnostic> {
        let nearest = spelling::nearest(name, known).map(|nearest| format!("; did you mean `{nearest}`?"));
        self.fault(range, format!("{message}{}", nearest.unwrap_or_default()))
    }
}

/// The most tables of lists that are parsed: so many of each kind are possible, and parsed tables are far larger than
/// their text.
const MOST_TABLES: usize = 4 * LIGHTS_MAX as usize;

/// The tables of a text.
///
/// # Errors
/// It is not TOML, or has too many.
pub(super) fn document(source: &Source) -> Result<Spanned<DeTable<'_>>, Box<Diagnostic>> {
    let starts = std::iter::once(0).chain(source.text.match_indices('\n').map(|(at, _)| at + 1));
    let is_table = |start: &usize| source.text.get(*start..).is_some_and(|rest| rest.starts_with("[["));
    if let Some(start) = starts.filter(is_table).nth(MOST_TABLES) {
        let message = format!("more than {MOST_TABLES} tables of lists; {LIGHTS_MAX} of a kind are possible");
        return Err(source.fault(start..start + 2, message));
    }
    DeTable::parse(&source.text).map_err(|error| {
        let end = source.text.len();
        source.fault(error.span().unwrap_or(end..end), error.message())
    })
}

/// Where what is looked for may belong.
const SETTINGS_NOTE: &str =
    "settings, those of effects too, stand in [settings.NAME], and the chain of effects in [effects]";

/// A value, and where it stands.
#[derive(Clone, Debug)]
pub(super) struct SpannedValue<T> {
    pub(super) value: T,
    pub(super) range: Range<usize>,
}

/// A value of one of the declared types.
#[derive(Clone, Debug)]
enum Value {
    Text(String),
    Boolean(bool),
    Number(f32),
    Pair(Vec2),
    Vector(Vec3),
    Layers(u32),
    Pairs(Vec<Vec2>),
    Vectors(Vec<Vec3>),
    Texts(Vec<SpannedValue<String>>),
    Values(Vec<(String, String)>),
}

/// A table that was checked.
pub(super) struct Table<'s> {
    pub(super) source: &'s Source,
    /// Where it begins.
    pub(super) range: Range<usize>,
    values: Vec<(&'static str, SpannedValue<Value>)>,
}

impl<'s> Table<'s> {
    /// The keys of `table` that `declared` has; others must be among `beside`.
    ///
    /// # Errors
    /// The first key or value from the top that is none of those declared, or a required one that is missing.
    pub(super) fn read(
        source: &'s Source,
        (table, range): (&DeTable<'_>, Range<usize>),
        declared: &StageTable,
        beside: &[&str],
    ) -> Result<Self, Box<Diagnostic>> {
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let mut values = Vec::new();
        for (key, value) in entries {
            let written: &str = key.get_ref();
            let is_of_stage = declared.name.is_empty();
            let kind = if is_of_stage { NameKind::StageTable } else { NameKind::StageKey(declared.name) };
            let name = current(kind, written);
            if name != written && older::value(table, name).is_some() {
                let message =
                    format!("`{written}` is an older name of `{name}`, which is here, too; write `{name}` alone");
                return Err(source.fault(key.span(), message));
            }
            if let Some(known) = declared.keys.iter().find(|known| known.name == name) {
                let read = read(known, value.get_ref()).ok_or_else(|| refused(source, known, value))?;
                values.push((known.name, SpannedValue { value: read, range: value.span() }));
            } else if !beside.contains(&name) {
                let place = if is_of_stage { "a stage" } else { declared.name };
                let known = declared.keys.iter().map(|known| known.name).chain(beside.iter().copied());
                let fault = source.unknown(key.span(), format!("no key of {place} is called `{name}`"), name, known);
                return Err(if is_of_stage { Box::new(fault.note(SETTINGS_NOTE)) } else { fault });
            }
        }
        if let Some(missing) =
            declared.keys.iter().find(|key| key.is_required && !values.iter().any(|(name, _)| *name == key.name))
        {
            return Err(source.fault(range, format!("`{}` is missing: {}", missing.name, missing.kind.expected())));
        }
        Ok(Self { source, range, values })
    }

    fn value(&self, key: &str) -> Option<&SpannedValue<Value>> {
        self.values.iter().find(|(name, _)| *name == key).map(|(_, value)| value)
    }

    /// Where the value of a key stands, if it is there.
    pub(super) fn place(&self, key: &str) -> Option<Range<usize>> {
        self.value(key).map(|placed| placed.range.clone())
    }

    pub(super) fn text(&self, key: &str) -> Option<SpannedValue<String>> {
        let SpannedValue { value: Value::Text(text), range } = self.value(key)? else { return None };
        Some(SpannedValue { value: text.clone(), range: range.clone() })
    }

    pub(super) fn boolean(&self, key: &str) -> Option<bool> {
        if let Value::Boolean(flag) = self.value(key)?.value { Some(flag) } else { None }
    }

    pub(super) fn number(&self, key: &str) -> Option<f32> {
        if let Value::Number(number) = self.value(key)?.value { Some(number) } else { None }
    }

    pub(super) fn vector(&self, key: &str) -> Option<Vec3> {
        if let Value::Vector(vector) = self.value(key)?.value { Some(vector) } else { None }
    }

    pub(super) fn pair(&self, key: &str) -> Option<Vec2> {
        if let Value::Pair(pair) = self.value(key)?.value { Some(pair) } else { None }
    }

    /// A bit for each layer.
    pub(super) fn layers(&self, key: &str) -> Option<u32> {
        if let Value::Layers(layers) = self.value(key)?.value { Some(layers) } else { None }
    }

    pub(super) fn pairs(&self, key: &str) -> Option<&[Vec2]> {
        if let Value::Pairs(pairs) = &self.value(key)?.value { Some(pairs) } else { None }
    }

    pub(super) fn vectors(&self, key: &str) -> Option<&[Vec3]> {
        if let Value::Vectors(vectors) = &self.value(key)?.value { Some(vectors) } else { None }
    }

    pub(super) fn texts(&self, key: &str) -> Option<&[SpannedValue<String>]> {
        if let Value::Texts(texts) = &self.value(key)?.value { Some(texts) } else { None }
    }

    /// Names, and numbers with commas between those of a list.
    pub(super) fn values(&self, key: &str) -> Option<&[(String, String)]> {
        if let Value::Values(values) = &self.value(key)?.value { Some(values) } else { None }
    }

    /// An error at a key's value, or where the table begins if it is not there.
    pub(super) fn fault(&self, key: &str, message: impl Display) -> Box<Diagnostic> {
        self.source.fault(self.place(key).unwrap_or_else(|| self.range.clone()), message)
    }
}

/// The tables of a list `[[name]]`, and where each begins.
///
/// # Errors
/// What is there is no list of tables.
pub(super) fn tables<'t, 'i>(
    source: &Source,
    name: &str,
    value: &'t Spanned<DeValue<'i>>,
) -> Result<Vec<(&'t DeTable<'i>, Range<usize>)>, Box<Diagnostic>> {
    let wrong = |range| source.fault(range, format!("`{name}` is a list of tables: write [[{name}]] above each"));
    let DeValue::Array(entries) = value.get_ref() else { return Err(wrong(value.span())) };
    let of_entry = |entry: &'t Spanned<DeValue<'i>>| match entry.get_ref() {
        DeValue::Table(table) => Ok((table, entry.span())),
        _ => Err(wrong(entry.span())),
    };
    entries.iter().map(of_entry).collect()
}

/// A whole number.
pub(super) fn whole(table: &Table<'_>, key: &str, number: f32) -> Result<u32, Box<Diagnostic>> {
    if number.fract() == 0.0 { Ok(number as u32) } else { Err(table.fault(key, format!("`{key}` is a whole number"))) }
}

fn refused(source: &Source, key: &StageKey, value: &Spanned<DeValue<'_>>) -> Box<Diagnostic> {
    let shown = source.text.get(value.span()).unwrap_or_default();
    let shown: String = shown.chars().take(40).collect();
    source
        .fault(value.span(), format!("`{shown}` is not a value of `{}`, which takes {}", key.name, key.kind.expected()))
}

fn read(key: &StageKey, value: &DeValue<'_>) -> Option<Value> {
    match (key.kind, value) {
        (StageType::Text, DeValue::String(text)) => Some(Value::Text(text.to_string())),
        (StageType::Word(words), DeValue::String(text)) => {
            words.contains(&&**text).then(|| Value::Text(text.to_string()))
        }
        (StageType::Boolean, DeValue::Boolean(flag)) => Some(Value::Boolean(*flag)),
        (StageType::Color, DeValue::String(text)) => color_of_hex(text).map(Value::Vector),
        (StageType::Color, value) => vector(value).filter(|color| color.min_element() >= 0.0).map(Value::Vector),
        (StageType::Vector, value) => vector(value).map(Value::Vector),
        (StageType::Pair, value) => numbers(value).map(|pair| Value::Pair(Vec2::from_array(pair))),
        (StageType::Layers, value) => layers(value).map(Value::Layers),
        (StageType::Pairs, value) => points(value, |pair| Some(Vec2::from_array(numbers(pair)?))).map(Value::Pairs),
        (StageType::Vectors, value) => points(value, vector).map(Value::Vectors),
        (StageType::Texts, value) => texts(value).map(Value::Texts),
        (StageType::Values, DeValue::Table(table)) => values(table).map(Value::Values),
        (StageType::Number { min, is_above, max }, value) => {
            let number = number(value)?;
            let is_within = number <= max && number >= min && !(is_above && number <= min);
            is_within.then_some(Value::Number(number as f32))
        }
        _ => None,
    }
}

/// A number that 32 bits hold; not infinite, and not "not a number".
fn number(value: &DeValue<'_>) -> Option<f64> {
    let number: f64 = match value {
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix()).ok()? as f64,
        DeValue::Float(number) => number.as_str().parse().ok()?,
        _ => return None,
    };
    (number.abs() <= f64::from(f32::MAX)).then_some(number)
}

fn numbers<const N: usize>(value: &DeValue<'_>) -> Option<[f32; N]> {
    let DeValue::Array(entries) = value else { return None };
    let numbers: Option<Vec<f32>> = entries.iter().map(|entry| number(entry.get_ref()).map(|n| n as f32)).collect();
    numbers?.try_into().ok()
}

/// A bit for each number of a list.
fn layers(value: &DeValue<'_>) -> Option<u32> {
    let DeValue::Array(entries) = value else { return None };
    let bit = |entry: &Spanned<DeValue<'_>>| {
        let layer = number(entry.get_ref()).filter(|layer| layer.fract() == 0.0 && (0.0..32.0).contains(layer))?;
        Some(1 << layer as u32)
    };
    entries.iter().try_fold(0, |layers, entry| Some(layers | bit(entry)?))
}

fn vector(value: &DeValue<'_>) -> Option<Vec3> {
    numbers(value).map(Vec3::from_array)
}

fn points<T>(value: &DeValue<'_>, read: impl Fn(&DeValue<'_>) -> Option<T>) -> Option<Vec<T>> {
    let DeValue::Array(entries) = value else { return None };
    let points: Vec<T> = entries.iter().map(|entry| read(entry.get_ref())).collect::<Option<_>>()?;
    (points.len() >= 2).then_some(points)
}

fn texts(value: &DeValue<'_>) -> Option<Vec<SpannedValue<String>>> {
    let DeValue::Array(entries) = value else { return None };
    let text = |entry: &Spanned<DeValue<'_>>| match entry.get_ref() {
        DeValue::String(text) if !text.is_empty() => {
            Some(SpannedValue { value: text.to_string(), range: entry.span() })
        }
        _ => None,
    };
    entries.iter().map(text).collect()
}

/// Names with numbers, or with lists of up to four.
fn values(table: &DeTable<'_>) -> Option<Vec<(String, String)>> {
    let text = |value: &DeValue<'_>| match value {
        DeValue::Array(entries) => {
            let numbers: Option<Vec<f64>> = entries.iter().map(|entry| number(entry.get_ref())).collect();
            let numbers = numbers.filter(|numbers| (1..=4).contains(&numbers.len()))?;
            Some(numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(","))
        }
        value => number(value).map(|number| number.to_string()),
    };
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    entries.into_iter().map(|(key, value)| Some((key.get_ref().to_string(), text(value.get_ref())?))).collect()
}

/// The linear colour of six hexadecimal digits in sRGB (IEC 61966-2-1), `#` optional.
fn color_of_hex(text: &str) -> Option<Vec3> {
    let hex = text.strip_prefix('#').unwrap_or(text);
    if hex.len() != 6 || !hex.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let value = u32::from_str_radix(hex, 16).ok()?;
    let linear = |shift: u32| linear_from_srgb((value >> shift & 255) as f32 / 255.0);
    Some(Vec3::new(linear(16), linear(8), linear(0)))
}
