//! The types of Rust that settings have.

use super::{NumberType, Scalar, SettingInput, SettingType, SettingValue};
use std::path::PathBuf;

/// A type that a setting can have.
pub trait SettingField: Sized {
    /// What is told of it.
    fn kind() -> SettingType;

    /// The words it takes, if it takes words.
    fn choices() -> &'static [&'static str] {
        &[]
    }

    /// The value of what was written; none if it is not a value of this type. Ranges are checked elsewhere.
    fn read(written: &SettingInput) -> Option<Self>;

    /// As plain data; what [`Self::read`] makes of its text is this value again.
    fn value(&self) -> SettingValue;

    /// The numbers that a range limits.
    fn numbers(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// A number of 32 bits as one of 64, by way of its shortest text, so that 0.6 does not become 0.6000000238.
pub(crate) fn widened(number: f32) -> f64 {
    number.to_string().parse().unwrap_or_else(|_| f64::from(number))
}

macro_rules! number_field {
    ($type:ty, $scalar:ident, $wide:expr, $one:ident, $many:ident) => {
        impl SettingField for $type {
            fn kind() -> SettingType {
                SettingType::Number(NumberType { scalar: Scalar::$scalar, count: 1 })
            }

            fn read(written: &SettingInput) -> Option<Self> {
                Scalar::$scalar.read(&written.text()?).map(|number| number as $type)
            }

            fn value(&self) -> SettingValue {
                SettingValue::$one($wide(*self))
            }

            fn numbers(&self) -> Vec<f64> {
                vec![$wide(*self) as f64]
            }
        }

        impl<const N: usize> SettingField for [$type; N] {
            fn kind() -> SettingType {
                SettingType::Number(NumberType { scalar: Scalar::$scalar, count: N as u8 })
            }

            fn read(written: &SettingInput) -> Option<Self> {
                let parts = written.parts();
                let numbers: Option<Vec<$type>> =
                    parts.iter().map(|part| Scalar::$scalar.read(part).map(|number| number as $type)).collect();
                numbers?.try_into().ok()
            }

            fn value(&self) -> SettingValue {
                SettingValue::$many(self.iter().map(|number| $wide(*number)).collect())
            }

            fn numbers(&self) -> Vec<f64> {
                self.iter().map(|number| $wide(*number) as f64).collect()
            }
        }
    };
}

number_field!(f32, F32, widened, Number, Numbers);
number_field!(u32, U32, i64::from, Integer, Integers);
number_field!(i32, I32, i64::from, Integer, Integers);

impl SettingField for bool {
    fn kind() -> SettingType {
        SettingType::Boolean
    }

    fn read(written: &SettingInput) -> Option<Self> {
        written.text()?.parse().ok()
    }

    fn value(&self) -> SettingValue {
        SettingValue::Boolean(*self)
    }
}

impl SettingField for String {
    fn kind() -> SettingType {
        SettingType::Text
    }

    fn read(written: &SettingInput) -> Option<Self> {
        written.text().map(Into::into)
    }

    fn value(&self) -> SettingValue {
        SettingValue::Text(self.clone())
    }
}

impl SettingField for PathBuf {
    fn kind() -> SettingType {
        SettingType::Path
    }

    fn read(written: &SettingInput) -> Option<Self> {
        written.text().map(|text| PathBuf::from(&*text))
    }

    fn value(&self) -> SettingValue {
        SettingValue::Text(self.to_string_lossy().into_owned())
    }
}

/// On the command line commas stand between the entries, or it is an array as in a file, whose entries may hold commas.
impl<T: SettingField> SettingField for Vec<T> {
    fn kind() -> SettingType {
        SettingType::List(Box::new(T::kind()))
    }

    fn choices() -> &'static [&'static str] {
        T::choices()
    }

    fn read(written: &SettingInput) -> Option<Self> {
        if let Some(entries) = written.entries() {
            return entries.into_iter().map(|entry| T::read(&entry.into())).collect();
        }
        if matches!(written, SettingInput::Typed(_)) {
            return None;
        }
        written.parts().into_iter().map(|part| T::read(&SettingInput::from(&*part))).collect()
    }

    fn value(&self) -> SettingValue {
        SettingValue::List(self.iter().map(T::value).collect())
    }

    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(T::numbers).collect()
    }
}
