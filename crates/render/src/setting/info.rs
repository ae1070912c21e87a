//! What is known of a setting.

use super::{SettingField, SettingInput, SettingsError};
use serde::{Deserialize, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};
use std::ops::{Bound, RangeBounds};

/// A setting's description: plain data for `--set`, panels and documentation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingInfo {
    /// The dotted key.
    pub key: Cow<'static, str>,
    /// What values it takes.
    #[serde(rename = "type")]
    pub kind: SettingType,
    /// The value without any setting; none if one must be given.
    pub default: Option<SettingValue>,
    /// The smallest value, of every component; none if there is no limit.
    pub min: Option<f64>,
    /// The largest value, of every component; none if there is no limit.
    pub max: Option<f64>,
    /// The words it takes, or the few numbers; else empty.
    pub choices: &'static [&'static str],
    /// The unit.
    pub unit: Option<Cow<'static, str>>,
    /// Without all of these, each `key=value`, it does nothing.
    pub needs: Vec<Cow<'static, str>>,
    /// What it does.
    pub doc: Cow<'static, str>,
}

/// The kind of number that a setting's value consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// A finite number of 32 bits.
    F32,
    /// A whole number of 32 bits.
    I32,
    /// A whole number of 32 bits that is not negative.
    U32,
}

/// A number or a vector of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberType {
    /// What each component is.
    pub scalar: Scalar,
    /// How many components there are, 1 to 4.
    pub count: u8,
}

/// The type of a setting's value; numbers are written as in WGSL: `f32`, `u32`, `vec3f`, ….
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SettingType {
    /// A number or a vector.
    Number(NumberType),
    /// `true` or `false`.
    Boolean,
    /// `true`, `false`, or `auto` for wherever the rest of the settings allow it.
    Switch,
    /// One of the words of [`SettingInfo::choices`].
    Choice,
    /// `rrggbb` in sRGB, `#` optional, or three numbers in linear Rec. 709.
    Color,
    /// One of the words, or a colour.
    ChoiceOrColor,
    /// One of the words, a colour, or two of `rrggbb` with a comma between.
    ChoiceOrColors,
    /// One of the words, stops, or `auto` with stops.
    Exposure,
    /// Any text.
    Text,
    /// The path of a file.
    Path,
    /// Any number of values of one type.
    List(Box<SettingType>),
}

/// A value of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SettingValue {
    /// Yes or no.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// The components of a vector of whole numbers.
    Integers(Vec<i64>),
    /// The components of a vector.
    Numbers(Vec<f64>),
    /// A word, a colour, a text or a path.
    Text(String),
    /// The entries of a list.
    List(Vec<SettingValue>),
}

impl Display for NumberType {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (name, letter) = match self.scalar {
            Scalar::F32 => ("f32", 'f'),
            Scalar::I32 => ("i32", 'i'),
            Scalar::U32 => ("u32", 'u'),
        };
        if self.count == 1 { f.write_str(name) } else { write!(f, "vec{}{letter}", self.count) }
    }
}

impl Display for SettingType {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(numbers) => numbers.fmt(f),
            Self::Boolean => f.write_str("bool"),
            Self::Switch => f.write_str("switch"),
            Self::Choice => f.write_str("choice"),
            Self::Color => f.write_str("color"),
            Self::ChoiceOrColor => f.write_str("choice or color"),
            Self::ChoiceOrColors => f.write_str("choice, color or two colors"),
            Self::Exposure => f.write_str("exposure"),
            Self::Text => f.write_str("text"),
            Self::Path => f.write_str("path"),
            Self::List(entry) => write!(f, "list of {entry}"),
        }
    }
}

impl Serialize for SettingType {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// As it is written on the command line.
impl Display for SettingValue {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        fn joined<T: ToString>(values: &[T]) -> String {
            values.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
        }
        match self {
            Self::Boolean(value) => value.fmt(f),
            Self::Integer(value) => value.fmt(f),
            Self::Number(value) => value.fmt(f),
            Self::Integers(values) => f.write_str(&joined(values)),
            Self::Numbers(values) => f.write_str(&joined(values)),
            Self::Text(text) => f.write_str(text),
            Self::List(values) => f.write_str(&joined(values)),
        }
    }
}

/// The largest number of 32 bits.
pub(super) const F32_MAX: f64 = f32::MAX as f64;

impl Scalar {
    /// The number of a text; none if it is none of this kind.
    pub(crate) fn read(self, text: &str) -> Option<f64> {
        let number: f64 = text.parse().ok()?;
        let fits = match self {
            Self::F32 => number.abs() <= F32_MAX,
            Self::I32 => number.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&number),
            Self::U32 => number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number),
        };
        fits.then_some(number)
    }
}

impl NumberType {
    /// The value of these components.
    pub(crate) fn value(self, components: &[f64]) -> SettingValue {
        let integers = || components.iter().map(|component| *component as i64).collect::<Vec<_>>();
        match (self.scalar, components) {
            (Scalar::F32, [one]) => SettingValue::Number(*one),
            (Scalar::F32, all) => SettingValue::Numbers(all.to_vec()),
            (_, [one]) => SettingValue::Integer(*one as i64),
            _ => SettingValue::Integers(integers()),
        }
    }

    /// The limits that the type itself has.
    pub(crate) fn limits(self) -> (Option<f64>, Option<f64>) {
        match self.scalar {
            Scalar::F32 => (None, None),
            Scalar::I32 => (Some(i32::MIN.into()), Some(i32::MAX.into())),
            Scalar::U32 => (Some(0.0), Some(u32::MAX.into())),
        }
    }

    /// In words, without their number.
    fn expected(self) -> &'static str {
        match (self.count, self.scalar == Scalar::F32) {
            (1, true) => "a number",
            (1, false) => "a whole number",
            (_, true) => "numbers with commas between",
            (_, false) => "whole numbers with commas between",
        }
    }
}

impl SettingType {
    /// The numbers that it consists of, or its entries.
    fn numbers(&self) -> Option<NumberType> {
        match self {
            Self::Number(numbers) => Some(*numbers),
            Self::List(entry) => entry.numbers(),
            _ => None,
        }
    }
}

impl SettingInfo {
    /// What the declaration of a field says: its name, the lines of its comment, and its default.
    pub(crate) fn of_field<T: SettingField>(name: &'static str, doc: &[&str], default: &T) -> Self {
        let kind = T::kind();
        let (min, max) = kind.numbers().map_or((None, None), NumberType::limits);
        Self {
            key: name.into(),
            kind,
            default: Some(default.value()),
            min,
            max,
            choices: T::choices(),
            unit: None,
            needs: Vec::new(),
            doc: doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ").into(),
        }
    }

    /// With a range.
    pub(crate) fn within<N: Into<f64> + Copy>(mut self, range: &impl RangeBounds<N>) -> Self {
        // An end that is left out is that of the type.
        let end = |bound: Bound<&N>, of_type| match bound {
            Bound::Included(end) | Bound::Excluded(end) => Some((*end).into()),
            Bound::Unbounded => of_type,
        };
        (self.min, self.max) = (end(range.start_bound(), self.min), end(range.end_bound(), self.max));
        self
    }

    /// With a unit.
    pub(crate) fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit.into());
        self
    }

    /// With a `key=value` without which it does nothing.
    pub(crate) fn needing(mut self, needs: &'static str) -> Self {
        self.needs.push(needs.into());
        self
    }

    /// As part of a group.
    pub(crate) fn of_group(mut self, group: &str) -> Self {
        self.key = format!("{group}.{}", self.key).into();
        self
    }

    /// The value that was written.
    ///
    /// # Errors
    /// It is none of the type, or one of its numbers lies outside the range.
    pub fn read<T: SettingField>(&self, written: &SettingInput) -> Result<T, SettingsError> {
        let value = self.is_typed(written).then(|| T::read(written)).flatten();
        let value = value.filter(|value| value.numbers().into_iter().all(|number| self.contains(number)));
        value.ok_or_else(|| self.refuse(written))
    }

    /// The components of a number or vector that was written: as many as the type has.
    ///
    /// # Errors
    /// There is another number of components, one of them is no number of the type, or lies outside the range.
    pub fn components(&self, written: &SettingInput) -> Result<Vec<f64>, SettingsError> {
        let numbers = self.kind.numbers().filter(|_| self.is_typed(written));
        let components = numbers.and_then(|numbers| {
            let components: Option<Vec<f64>> = written.parts().iter().map(|part| numbers.scalar.read(part)).collect();
            components.filter(|components| components.len() == usize::from(numbers.count))
        });
        let components = components.filter(|components| components.iter().all(|number| self.contains(*number)));
        components.ok_or_else(|| self.refuse(written))
    }

    fn contains(&self, number: f64) -> bool {
        self.min.is_none_or(|min| number >= min) && self.max.is_none_or(|max| number <= max)
    }

    /// Whether what was written has this setting's type, if it has one.
    fn is_typed(&self, written: &SettingInput) -> bool {
        if let SettingInput::Typed(value) = written { self.kind.admits(value) } else { true }
    }

    /// That a value is none of this setting's.
    pub(crate) fn refuse(&self, written: &SettingInput) -> SettingsError {
        let is_too_large =
            |part: &str| part.parse::<f64>().is_ok_and(|number| number.is_infinite() || number.abs() > F32_MAX);
        let is_f32 = self.kind.numbers().is_some_and(|numbers| numbers.scalar == Scalar::F32);
        let has_no_end = is_f32 && self.max.is_none_or(|max| max > F32_MAX);
        let mut expected = self.expected();
        if has_no_end && written.parts().iter().any(|part| is_too_large(part)) {
            expected.push_str(&format!("; 32 bits hold numbers up to {:e}", f32::MAX));
        }
        if let SettingInput::Typed(value) = written {
            expected.push_str(self.kind.remedy(value));
        }
        SettingsError::BadValue { key: self.key.to_string(), value: written.to_string(), expected }
    }

    /// The type and the range, in words.
    pub fn expected(&self) -> String {
        self.expected_of(&self.kind)
    }

    fn expected_of(&self, kind: &SettingType) -> String {
        let words = || self.choices.join(", ");
        match kind {
            // Of numbers those few that it takes.
            SettingType::Choice | SettingType::Number(_) if !self.choices.is_empty() => match self.choices {
                [before @ .., last] if !before.is_empty() => format!("{} or {last}", before.join(", ")),
                _ => words(),
            },
            SettingType::Number(NumberType { count: 1, .. }) => self.with_range(kind, ""),
            SettingType::Number(NumberType { count, .. }) => format!("{count} {}", self.with_range(kind, ", each")),
            SettingType::Boolean => "true or false".into(),
            SettingType::Switch => "true, false or auto".into(),
            SettingType::Choice => words(),
            SettingType::Color => "a colour such as ff8800, or 3 numbers of at least 0 in linear light".into(),
            SettingType::ChoiceOrColor => {
                format!("{}, a colour such as ff8800, or 3 numbers of at least 0 in linear light", words())
            }
            SettingType::ChoiceOrColors => {
                let words = words();
                format!(
                    "{words}, a colour such as ff8800, 3 numbers of at least 0 in linear light, or two colours such as ff8800,112233"
                )
            }
            SettingType::Exposure => {
                format!("stops from -64 to 64, {}, or auto with stops such as auto+1 or auto-0.5", words())
            }
            SettingType::Text => "a text".into(),
            SettingType::Path => "a path".into(),
            SettingType::List(entry) => format!("a list; each entry is {}", self.expected_of(entry)),
        }
    }

    /// What it does, as a sentence, and what it needs for that.
    pub fn sentences(&self, unit: &str) -> String {
        let doc = self.doc.trim_end();
        let stop = if doc.is_empty() || doc.ends_with(['.', '!', '?', ':']) { "" } else { "." };
        let needs = self.needs.iter().map(|needs| format!(" Needs {needs}.")).collect::<String>();
        format!("{doc}{stop}{unit}{needs}").trim_start().to_owned()
    }

    fn with_range(&self, kind: &SettingType, each: &str) -> String {
        let what = kind.numbers().map_or("", NumberType::expected);
        match (self.min, self.max) {
            (None, None) => what.into(),
            (Some(min), None) => format!("{what}{each} of at least {min}"),
            (None, Some(max)) => format!("{what}{each} of at most {max}"),
            (Some(min), Some(max)) => format!("{what}{each} from {min} to {max}"),
        }
    }

    /// The range or the words, as a table shows them.
    pub fn range(&self) -> String {
        let words = self.choices.join(" ");
        match (&self.kind, self.min, self.max) {
            (SettingType::ChoiceOrColor, ..) => format!("{words} rrggbb r,g,b"),
            (SettingType::ChoiceOrColors, ..) => format!("{words} rrggbb r,g,b rrggbb,rrggbb"),
            (SettingType::Exposure, ..) => format!("{words} auto+N auto-N -64 to 64"),
            (SettingType::Boolean, ..) => "true false".into(),
            (SettingType::Switch, ..) => "auto true false".into(),
            (SettingType::Color, ..) => "rrggbb r,g,b".into(),
            _ if !words.is_empty() => words,
            (_, None, None) => "any".into(),
            (_, Some(min), None) => format!("from {min}"),
            (_, None, Some(max)) => format!("to {max}"),
            (_, Some(min), Some(max)) => format!("{min} to {max}"),
        }
    }

    /// Letters that stand for a value: as many as it has components.
    pub fn placeholder(&self) -> String {
        let count = self.kind.numbers().map_or(1, |numbers| numbers.count);
        vec!["N"; usize::from(count)].join(",")
    }
}
