//! What is known of a setting.

use super::SettingsError;
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};

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
    /// The values there are, if they are words; else empty.
    pub choices: &'static [&'static str],
    /// The unit.
    pub unit: Option<Cow<'static, str>>,
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

/// The type of a setting's value, written as in WGSL: `f32`, `u32`, `vec3f`, ….
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SettingType {
    /// What each component is.
    pub scalar: Scalar,
    /// How many components there are, 1 to 4.
    pub count: u8,
}

/// A value of a setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SettingValue {
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// The components of a vector of whole numbers.
    Integers(Vec<i64>),
    /// The components of a vector.
    Numbers(Vec<f64>),
}

impl Display for SettingType {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (name, letter) = match self.scalar {
            Scalar::F32 => ("f32", 'f'),
            Scalar::I32 => ("i32", 'i'),
            Scalar::U32 => ("u32", 'u'),
        };
        if self.count == 1 { f.write_str(name) } else { write!(f, "vec{}{letter}", self.count) }
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
        let join = |values: Vec<String>| values.join(",");
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::Number(value) => value.fmt(f),
            Self::Integers(values) => f.write_str(&join(values.iter().map(i64::to_string).collect())),
            Self::Numbers(values) => f.write_str(&join(values.iter().map(f64::to_string).collect())),
        }
    }
}

impl SettingType {
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
}

impl SettingInfo {
    /// A setting of one number.
    pub const fn f32(
        key: &'static str,
        doc: &'static str,
        unit: Option<&'static str>,
        default: f64,
        (min, max): (f64, f64),
    ) -> Self {
        let kind = SettingType { scalar: Scalar::F32, count: 1 };
        Self::built_in(key, doc, unit, kind, SettingValue::Number(default), (min, max))
    }

    /// A setting of one whole number.
    pub const fn u32(
        key: &'static str,
        doc: &'static str,
        unit: Option<&'static str>,
        default: u32,
        (min, max): (u32, u32),
    ) -> Self {
        let kind = SettingType { scalar: Scalar::U32, count: 1 };
        Self::built_in(key, doc, unit, kind, SettingValue::Integer(default as i64), (min as f64, max as f64))
    }

    const fn built_in(
        key: &'static str,
        doc: &'static str,
        unit: Option<&'static str>,
        kind: SettingType,
        default: SettingValue,
        (min, max): (f64, f64),
    ) -> Self {
        let unit = match unit {
            Some(unit) => Some(Cow::Borrowed(unit)),
            None => None,
        };
        Self {
            key: Cow::Borrowed(key),
            kind,
            default: Some(default),
            min: Some(min),
            max: Some(max),
            choices: &[],
            unit,
            doc: Cow::Borrowed(doc),
        }
    }

    /// The components of a value written as text: as many as the type has, with commas between them.
    ///
    /// # Errors
    /// The text is another number of components, one of them is no number of the type, or lies outside the range.
    pub fn parse(&self, text: &str) -> Result<Vec<f64>, SettingsError> {
        let components: Option<Vec<f64>> = text.split(',').map(|part| self.component(part.trim())).collect();
        let components = components.filter(|components| components.len() == usize::from(self.kind.count));
        components.ok_or_else(|| self.refuse(text))
    }

    fn component(&self, text: &str) -> Option<f64> {
        let number: f64 = text.parse().ok()?;
        let fits = match self.kind.scalar {
            Scalar::F32 => (number as f32).is_finite(),
            Scalar::I32 | Scalar::U32 => number.fract() == 0.0,
        };
        let is_inside = self.min.is_none_or(|min| number >= min) && self.max.is_none_or(|max| number <= max);
        (fits && is_inside).then_some(number)
    }

    /// That `value` is none of this setting's.
    pub(crate) fn refuse(&self, value: &str) -> SettingsError {
        SettingsError::BadValue { key: self.key.to_string(), value: value.trim().into(), expected: self.expected() }
    }

    /// The type and the range, in words.
    fn expected(&self) -> String {
        let is_whole = self.kind.scalar != Scalar::F32;
        let what = match (self.kind.count, is_whole) {
            (1, false) => "a number".into(),
            (1, true) => "a whole number".into(),
            (count, false) => format!("{count} numbers with commas between"),
            (count, true) => format!("{count} whole numbers with commas between"),
        };
        let each = if self.kind.count == 1 { "" } else { ", each" };
        match (self.min, self.max) {
            (None, None) => what,
            (Some(min), None) => format!("{what}{each} at least {min}"),
            (None, Some(max)) => format!("{what}{each} at most {max}"),
            (Some(min), Some(max)) => format!("{what}{each} from {min} to {max}"),
        }
    }
}
