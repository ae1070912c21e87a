//! What is declared of a key and of a table.

/// The type of a key's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StageType {
    /// Any text.
    Text,
    /// `true` or `false`.
    Boolean,
    /// One of these words.
    Word(&'static [&'static str]),
    /// `rrggbb` in sRGB, `#` optional, or three numbers of at least 0 in linear Rec. 709.
    Color,
    /// Two finite numbers.
    Pair,
    /// Three finite numbers.
    Vector,
    /// A list of whole numbers from 0 to 31.
    Layers,
    /// A list of two or more pairs of finite numbers.
    Pairs,
    /// A list of two or more times three finite numbers.
    Vectors,
    /// A list of texts.
    Texts,
    /// A table of numbers, and of lists of up to four.
    Values,
    /// A finite number of 32 bits.
    Number {
        /// The least one.
        min: f64,
        /// Whether the least one is excluded.
        is_above: bool,
        /// The largest one.
        max: f64,
    },
}

/// A key of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageKey {
    /// Its name.
    pub name: &'static str,
    /// The type of its value.
    pub kind: StageType,
    /// Whether the table needs it.
    pub is_required: bool,
    /// Its description: sentences, with unit and default.
    pub doc: &'static str,
}

/// A list of tables, `[[name]]`, or the keys before the first table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageTable {
    /// Its name; empty for the keys before all tables.
    pub name: &'static str,
    /// The description of one table.
    pub doc: &'static str,
    /// The keys of one table.
    pub keys: &'static [StageKey],
}

impl StageType {
    /// The expected value, in words.
    pub fn expected(&self) -> String {
        match self {
            Self::Text => "a text in quotes".into(),
            Self::Boolean => "true or false".into(),
            Self::Word([before @ .., last]) if !before.is_empty() => {
                format!("\"{}\" or \"{last}\"", before.join("\", \""))
            }
            Self::Word(words) => words.join(", "),
            Self::Color => "a colour such as \"ff8800\", or [r, g, b] of at least 0 in linear light".into(),
            Self::Pair => "two finite numbers in brackets, [x, y]".into(),
            Self::Vector => "three finite numbers in brackets, [x, y, z]".into(),
            Self::Layers => "a list of whole numbers from 0 to 31, [0, 3]".into(),
            Self::Pairs => "a list of points of two finite numbers, [[x, y], [x, y]]".into(),
            Self::Vectors => "a list of points of three finite numbers, [[x, y, z], [x, y, z]]".into(),
            Self::Texts => "a list of texts in quotes, [\"a\", \"b\"]".into(),
            Self::Values => "a table of numbers and lists of numbers, { strength = 0.5, center = [0, 1] }".into(),
            Self::Number { min, is_above, max } => {
                let least = if *is_above { format!("above {min}") } else { format!("of at least {min}") };
                if *max < f64::from(f32::MAX) {
                    return format!("a number {least} and at most {max}");
                }
                format!("a finite number {least}")
            }
        }
    }

    /// Its name in a table.
    pub fn name(&self) -> String {
        match self {
            Self::Text => "text".into(),
            Self::Boolean => "bool".into(),
            Self::Word(words) => words.join(", "),
            Self::Color => "color".into(),
            Self::Pair => "vec2f".into(),
            Self::Vector => "vec3f".into(),
            Self::Layers => "list of u32".into(),
            Self::Pairs => "list of vec2f".into(),
            Self::Vectors => "list of vec3f".into(),
            Self::Texts => "list of text".into(),
            Self::Values => "table".into(),
            Self::Number { min, is_above, max } => {
                let sign = if *is_above { ">" } else { "≥" };
                let most = if *max < f64::from(f32::MAX) { format!(", ≤ {max}") } else { String::new() };
                format!("f32 {sign} {min}{most}")
            }
        }
    }
}

/// A key that may be left out.
pub(super) const fn key(name: &'static str, kind: StageType, doc: &'static str) -> StageKey {
    StageKey { name, kind, is_required: false, doc }
}

/// A key that must be there.
pub(super) const fn required(name: &'static str, kind: StageType, doc: &'static str) -> StageKey {
    StageKey { name, kind, is_required: true, doc }
}

/// A number of at least `min`.
pub(super) const fn from(min: f64) -> StageType {
    StageType::Number { min, is_above: false, max: f32::MAX as f64 }
}

/// A UV set.
pub(super) const UV_SET: StageType = StageType::Number { min: 0.0, is_above: false, max: 1.0 };

/// From 0 to 1.
pub(super) const SHARE: StageType = StageType::Number { min: 0.0, is_above: false, max: 1.0 };

/// A length above 0.
pub(super) const fn length(max: f32) -> StageType {
    StageType::Number { min: 0.0, is_above: true, max: max as f64 }
}

/// Any finite number.
pub(super) const FINITE: StageType = StageType::Number { min: f32::MIN as f64, is_above: false, max: f32::MAX as f64 };
