//! A JSON Schema of files of settings, by which editors complete and check them.

use super::info::F32_MAX;
use super::{LinearColor, NumberType, Scalar, SettingInfo, SettingType, Switch};
use manypass_scene::renamed::{NameChange, NameKind, RENAMED};
use serde_json::{Map, Value, json};

/// `auto` with at most 64 stops.
const AUTO_PATTERN: &str = r"^auto[+-]0*((64(\.0*)?|([1-5]?[0-9]|6[0-3])(\.[0-9]*)?)|\.[0-9]+)$";

/// The schema (draft 2020-12) of a file that may hold all of `infos`: their dotted keys as nested tables, and their older
/// keys, which are deprecated.
///
/// It is made of the descriptions that all else is made of, because those of effects are known only at run time.
pub fn schema<'i>(infos: impl IntoIterator<Item = &'i SettingInfo>) -> Value {
    let mut tables = Table::default();
    for info in infos {
        tables.insert(&info.key, described(info));
        let of_info = |row: &&NameChange| row.kind == NameKind::Setting && row.name == info.key;
        for row in RENAMED.iter().filter(of_info) {
            tables.insert(row.older, deprecated(typed(info, &info.kind), row));
        }
    }
    let mut root = tables.schema();
    root.insert("$schema".into(), "https://json-schema.org/draft/2020-12/schema".into());
    root.insert("title".into(), "Settings of Manypass".into());
    Value::Object(root)
}

/// What a table of a file may hold.
#[derive(Default)]
struct Table {
    tables: Vec<(String, Table)>,
    values: Map<String, Value>,
}

impl Table {
    fn insert(&mut self, key: &str, value: Value) {
        let Some((name, rest)) = key.split_once('.') else {
            self.values.insert(key.into(), value);
            return;
        };
        let index = self.tables.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
            self.tables.push((name.into(), Table::default()));
            self.tables.len() - 1
        });
        self.tables[index].1.insert(rest, value);
    }

    fn schema(self) -> Map<String, Value> {
        let mut properties = self.values;
        properties.extend(self.tables.into_iter().map(|(name, table)| (name, Value::Object(table.schema()))));
        let mut schema = Map::new();
        schema.insert("type".into(), "object".into());
        schema.insert("additionalProperties".into(), false.into());
        schema.insert("properties".into(), Value::Object(properties));
        schema
    }
}

/// One setting: its type, and what is said of it.
fn described(info: &SettingInfo) -> Value {
    let mut value = typed(info, &info.kind);
    let unit = info.unit.as_ref().map(|unit| format!(" Unit: {unit}.")).unwrap_or_default();
    value["description"] = info.sentences(&unit).into();
    if let Some(default) = &info.default {
        value["default"] = json!(default);
    }
    value
}

/// What an older name takes, with the notice of the name of today.
pub(crate) fn deprecated(mut schema: Value, row: &NameChange) -> Value {
    schema["deprecated"] = true.into();
    schema["description"] = format!("{row}.").into();
    schema
}

/// A colour: text in sRGB, or linear numbers.
pub(crate) fn color_schema() -> Value {
    json!({ "anyOf": colors() })
}

fn colors() -> Vec<Value> {
    let linear = json!({ "type": "number", "minimum": 0, "maximum": F32_MAX });
    let linear = json!({ "type": "array", "items": linear, "minItems": 3, "maxItems": 3 });
    vec![json!({ "type": "string", "pattern": LinearColor::PATTERN }), linear]
}

fn typed(info: &SettingInfo, kind: &SettingType) -> Value {
    let words = || json!({ "enum": info.choices });
    match kind {
        SettingType::Number(_) if !info.choices.is_empty() => {
            let numbers = info.choices.iter().filter_map(|number| Some(whole(number.parse().ok()?)));
            json!({ "enum": numbers.collect::<Vec<_>>() })
        }
        SettingType::Number(NumberType { scalar, count }) => {
            let mut number = json!({ "type": if *scalar == Scalar::F32 { "number" } else { "integer" } });
            // What 32 bits do not hold is refused, too.
            let end = (*scalar == Scalar::F32).then_some(F32_MAX);
            info.min.or(end.map(|end| -end)).inspect(|min| number["minimum"] = whole(*min));
            info.max.or(end).inspect(|max| number["maximum"] = whole(*max));
            if *count == 1 {
                return number;
            }
            json!({ "type": "array", "items": number, "minItems": count, "maxItems": count })
        }
        SettingType::Boolean => json!({ "type": "boolean" }),
        SettingType::Switch => json!({ "enum": [Switch::AUTO, true, false] }),
        SettingType::Choice => words(),
        SettingType::Color => color_schema(),
        SettingType::ChoiceOrColor => {
            let both = [vec![words()], colors()].concat();
            json!({ "anyOf": both })
        }
        SettingType::ChoiceOrColors => {
            let pair = json!({ "type": "string", "pattern": LinearColor::PAIR_PATTERN });
            let all = [vec![words()], colors(), vec![pair]].concat();
            json!({ "anyOf": all })
        }
        SettingType::Exposure => json!({ "anyOf": [
            words(),
            { "type": "number", "minimum": -64, "maximum": 64 },
            { "type": "string", "pattern": AUTO_PATTERN },
        ] }),
        SettingType::Text | SettingType::Path => json!({ "type": "string" }),
        SettingType::List(entry) => json!({ "type": "array", "items": typed(info, entry) }),
    }
}

/// A number without `.0`.
fn whole(number: f64) -> Value {
    if number.fract() == 0.0 && number.abs() < 1e15 { json!(number as i64) } else { json!(number) }
}
