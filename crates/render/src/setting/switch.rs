//! Switches of what is done wherever it can be, unless somebody says otherwise.

use super::{SettingField, SettingInput, SettingType, SettingValue};

/// A switch: on, off or automatic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Switch {
    /// Wherever the rest of the settings allow it.
    #[default]
    Auto,
    /// Yes; settings that do not allow it are an error.
    On,
    /// No.
    Off,
}

impl Switch {
    /// The word that leaves it open.
    pub(super) const AUTO: &'static str = "auto";

    /// Whether it is done without question; a request that is resolved leaves nothing open.
    pub fn is_on(self) -> bool {
        self == Self::On
    }

    /// Yes or no, where the rest of the settings allow it or not.
    pub(crate) fn resolved(self, is_possible: bool) -> Self {
        match self {
            Self::Auto => is_possible.into(),
            Self::On | Self::Off => self,
        }
    }
}

impl From<bool> for Switch {
    fn from(is_on: bool) -> Self {
        if is_on { Self::On } else { Self::Off }
    }
}

impl SettingField for Switch {
    fn kind() -> SettingType {
        SettingType::Switch
    }

    fn read(written: &SettingInput) -> Option<Self> {
        match &*written.text()? {
            Self::AUTO => Some(Self::Auto),
            text => text.parse::<bool>().ok().map(Into::into),
        }
    }

    fn value(&self) -> SettingValue {
        match self {
            Self::Auto => SettingValue::Text(Self::AUTO.into()),
            Self::On | Self::Off => SettingValue::Boolean(self.is_on()),
        }
    }
}
