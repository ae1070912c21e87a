//! Values of files, whose types count: which a setting takes, and what is to be done where it does not.

use super::{NumberType, SettingType, SettingValue, Switch};

impl SettingValue {
    /// The entries of a list or vector; none of what is neither.
    pub(crate) fn entries(&self) -> Option<Vec<Self>> {
        match self {
            Self::Integers(values) => Some(values.iter().copied().map(Self::Integer).collect()),
            Self::Numbers(values) => Some(values.iter().copied().map(Self::Number).collect()),
            Self::List(values) => Some(values.clone()),
            Self::Boolean(_) | Self::Integer(_) | Self::Number(_) | Self::Text(_) => None,
        }
    }

    fn is_number(&self) -> bool {
        matches!(self, Self::Integer(_) | Self::Number(_))
    }
}

impl SettingType {
    /// Whether a value of a file has this type, as the schema says; ranges and words are not looked at.
    pub(super) fn admits(&self, value: &SettingValue) -> bool {
        let are_numbers = |count: usize| {
            let entries = value.entries().filter(|entries| entries.len() == count);
            entries.is_some_and(|entries| entries.iter().all(SettingValue::is_number))
        };
        let is_text = matches!(value, SettingValue::Text(_));
        match self {
            Self::Number(NumberType { count: 1, .. }) => value.is_number(),
            Self::Number(NumberType { count, .. }) => are_numbers((*count).into()),
            Self::Boolean => matches!(value, SettingValue::Boolean(_)),
            Self::Switch => match value {
                SettingValue::Text(text) => text == Switch::AUTO,
                value => matches!(value, SettingValue::Boolean(_)),
            },
            Self::Choice | Self::Text | Self::Path => is_text,
            // Three numbers in one text are for the command line.
            Self::Color | Self::ChoiceOrColor => {
                matches!(value, SettingValue::Text(text) if !text.contains(',')) || are_numbers(3)
            }
            Self::ChoiceOrColors => {
                matches!(value, SettingValue::Text(text) if text.matches(',').count() < 2 && !text.contains(' '))
                    || are_numbers(3)
            }
            Self::Exposure => match value {
                SettingValue::Text(text) => text.parse::<f64>().is_err() && text.trim() == text,
                value => value.is_number(),
            },
            Self::List(entry) => value.entries().is_some_and(|entries| entries.iter().all(|value| entry.admits(value))),
        }
    }

    /// What is to be done about the way in which a file writes a value, if that is what is wrong.
    pub(super) fn remedy(&self, value: &SettingValue) -> &'static str {
        let is_text = matches!(value, SettingValue::Text(_));
        let is_number = |text: &str| text.parse::<f64>().is_ok();
        match self {
            Self::Number(NumberType { count: 1, .. }) | Self::Boolean | Self::Switch if is_text => {
                "; write it without quotes"
            }
            Self::Exposure if matches!(value, SettingValue::Text(text) if is_number(text)) => {
                "; write it without quotes"
            }
            Self::Number(NumberType { count: 2.., .. }) if value.entries().is_none() => "; write it in brackets",
            Self::List(_) if value.entries().is_none() => "; write it in brackets",
            Self::Choice | Self::Text | Self::Path | Self::Color | Self::ChoiceOrColor | Self::ChoiceOrColors
                if value.is_number() =>
            {
                "; write it in quotes"
            }
            Self::Number(NumberType { count: 1, .. })
            | Self::Boolean
            | Self::Switch
            | Self::Choice
            | Self::Text
            | Self::Path
                if value.entries().is_some() =>
            {
                "; write it without brackets"
            }
            _ => "",
        }
    }
}
