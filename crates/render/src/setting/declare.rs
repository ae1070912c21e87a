//! How settings are declared.

/// Declares the settings of a pass, in its folder:
///
/// ```ignore
/// settings! {
///     /// Settings of ambient occlusion.
///     pub struct OcclusionSettings {
///         /// How far surfaces occlude each other.
///         radius_m: f32 = 0.5, in 0.01..=10.0, unit "m";
///         /// Whether it is computed at half the width and height.
///         half: bool = true, needs "render.path=deferred";
///     }
/// }
/// ```
///
/// Every field has its doc comment, a type that is a [`crate::setting::SettingField`], and its default. These may
/// follow, in this order: `in` and the range of its numbers (`a..=b`, `a..` or `..=b`; of every component of a vector
/// and every entry of a list), its unit, and the keys and values without which it does nothing. That makes the struct
/// with `Default`, serde and [`crate::setting::Group`]; one line in `settings.rs` names the group, and with that the
/// keys.
macro_rules! settings {
    (
        $(#[doc = $struct_doc:literal])+
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                $field:ident : $type:ty = $default:expr
                $(, in $range:expr)? $(, unit $unit:literal)? $(, needs $needs:literal)* ;
            )*
        }
    ) => {
        $(#[doc = $struct_doc])+
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = concat!(
                    "\n\nDefault: `", stringify!($default), "`"
                    $(, "; range: `", stringify!($range), "`")? $(, "; unit: ", $unit)? $(, "; needs `", $needs, "`")*, "."
                )]
                pub $field: $type,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),* }
            }
        }

        impl $crate::setting::Group for $name {
            fn declared() -> Vec<$crate::setting::SettingInfo> {
                let defaults = Self::default();
                vec![$(
                    $crate::setting::SettingInfo::of_field(stringify!($field), &[$($doc),+], &defaults.$field)
                        $(.within(&($range)))? $(.in_unit($unit))? $(.needing($needs))*
                ),*]
            }

            fn value(&self, field: &str) -> Option<$crate::setting::SettingValue> {
                match field {
                    $(stringify!($field) => Some($crate::setting::SettingField::value(&self.$field)),)*
                    _ => None,
                }
            }

            fn give(
                &mut self,
                field: &str,
                info: &$crate::setting::SettingInfo,
                written: &$crate::setting::SettingInput,
            ) -> Result<(), $crate::setting::SettingsError> {
                match field {
                    $(stringify!($field) => self.$field = info.read(written)?,)*
                    _ => return Err($crate::setting::unknown_key(field, [$(stringify!($field)),*].into_iter())),
                }
                Ok(())
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $crate::setting::serialize_group(self, serializer)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                $crate::setting::deserialize_group(deserializer)
            }
        }
    };
}

/// Declares a choice among words, the type of a setting; each variant has its word:
///
/// ```ignore
/// choices! {
///     /// Where shading happens.
///     pub enum Path {
///         /// Opaque surfaces into the G-buffer, light afterwards.
///         #[default]
///         Deferred = "deferred",
///         /// Every surface where it is drawn.
///         Forward = "forward",
///     }
/// }
/// ```
macro_rules! choices {
    (
        $(#[doc = $enum_doc:literal])+
        pub enum $name:ident { $($(#[$meta:meta])+ $variant:ident = $word:literal,)+ }
    ) => {
        $(#[doc = $enum_doc])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum $name { $($(#[$meta])+ $variant,)+ }

        impl $name {
            /// Their words in files and on the command line, in the order of their declaration.
            pub const NAMES: &'static [&'static str] = &[$($word),+];

            /// The word in files and on the command line.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $word),+ }
            }

            /// The one of a word.
            pub fn named(name: &str) -> Option<Self> {
                match name { $($word => Some(Self::$variant),)+ _ => None }
            }
        }

        impl $crate::setting::SettingField for $name {
            fn kind() -> $crate::setting::SettingType {
                $crate::setting::SettingType::Choice
            }

            fn choices() -> &'static [&'static str] {
                Self::NAMES
            }

            fn read(written: &$crate::setting::SettingInput) -> Option<Self> {
                Self::named(&written.text()?)
            }

            fn value(&self) -> $crate::setting::SettingValue {
                $crate::setting::SettingValue::Text(self.name().into())
            }
        }
    };
}

pub(crate) use {choices, settings};
