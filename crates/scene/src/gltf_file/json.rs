//! A JSON object together with its pointer, so that every error can name its place.

use super::LoadError;
use serde_json::{Map, Value};
use std::collections::BTreeSet;

/// An object of the file, and where it is.
#[derive(Clone)]
pub(super) struct Json<'a> {
    map: &'a Map<String, Value>,
    pub(super) pointer: String,
}

impl<'a> Json<'a> {
    pub(super) fn root(value: &'a Value) -> Result<Self, LoadError> {
        Self::new(value, String::new())
            .map_err(|_| LoadError::invalid("", "not a glTF file: its JSON is not an object"))
    }

    fn new(value: &'a Value, pointer: String) -> Result<Self, LoadError> {
        match value.as_object() {
            Some(map) => Ok(Self { map, pointer }),
            None => Err(LoadError::invalid(&pointer, "expected an object")),
        }
    }

    pub(super) fn at(&self, key: impl std::fmt::Display) -> String {
        format!("{}/{key}", self.pointer)
    }

    pub(super) fn error(&self, key: &str, message: impl Into<String>) -> LoadError {
        LoadError::invalid(&self.at(key), message)
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.map.keys().map(String::as_str)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.map.contains_key(key)
    }

    fn get<T>(
        &self,
        key: &str,
        expected: &str,
        read: impl FnOnce(&'a Value) -> Option<T>,
    ) -> Result<Option<T>, LoadError> {
        let Some(value) = self.map.get(key) else { return Ok(None) };
        read(value).map(Some).ok_or_else(|| self.error(key, format!("expected {expected}")))
    }

    pub(super) fn object(&self, key: &str) -> Result<Option<Self>, LoadError> {
        self.map.get(key).map(|value| Self::new(value, self.at(key))).transpose()
    }

    pub(super) fn require_object(&self, key: &str) -> Result<Self, LoadError> {
        self.object(key)?.ok_or_else(|| self.error(key, "expected an object, found nothing"))
    }

    /// The object of an extension on this object.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Self>, LoadError> {
        match self.object("extensions")? {
            Some(extensions) => extensions.object(name),
            None => Ok(None),
        }
    }

    fn array(&self, key: &str) -> Result<&'a [Value], LoadError> {
        Ok(self.get(key, "an array", |value| value.as_array().map(Vec::as_slice))?.unwrap_or(&[]))
    }

    /// The objects of an array; none if there is no such array.
    pub(super) fn objects(&self, key: &str) -> Result<Vec<Self>, LoadError> {
        let items = self.array(key)?.iter().enumerate();
        items.map(|(i, value)| Self::new(value, format!("{}/{i}", self.at(key)))).collect()
    }

    pub(super) fn string(&self, key: &str) -> Result<Option<&'a str>, LoadError> {
        self.get(key, "a string", Value::as_str)
    }

    /// Whether an application put `false` beside what glTF says.
    pub(super) fn denies(&self, key: &str) -> bool {
        self.map.get("extras").and_then(|extras| extras.get(key)) == Some(&Value::Bool(false))
    }

    /// A number that an application put beside what glTF says.
    pub(super) fn extra_number(&self, key: &str) -> Option<f32> {
        let number = self.map.get("extras")?.get(key)?.as_f64()? as f32;
        number.is_finite().then_some(number)
    }

    /// A text that an application put beside what glTF says, where anything may be.
    pub(super) fn extra(&self, key: &str) -> Option<&'a str> {
        self.map.get("extras")?.get(key)?.as_str()
    }

    /// The name of the object; empty if it has none, or one that is no string.
    pub(super) fn name(&self) -> String {
        self.map.get("name").and_then(Value::as_str).unwrap_or_default().to_owned()
    }

    /// The UV sets that textures below this object are on.
    pub(super) fn texture_sets(&self) -> BTreeSet<u32> {
        fn add(map: &Map<String, Value>, sets: &mut BTreeSet<u32>) {
            for (key, value) in map {
                let Some(inner) = value.as_object() else { continue };
                if inner.contains_key("index") {
                    let transform = inner.get("extensions").and_then(|all| all.get("KHR_texture_transform"));
                    let of_transform = transform.and_then(|transform| transform.get("texCoord"));
                    let set = of_transform.or(inner.get("texCoord")).and_then(integer);
                    let set = set.unwrap_or(usize::from(key == "MOZ_lightmap"));
                    sets.extend(u32::try_from(set));
                }
                add(inner, sets);
            }
        }
        let mut sets = BTreeSet::new();
        add(self.map, &mut sets);
        sets
    }

    pub(super) fn strings(&self, key: &str) -> Result<Vec<&'a str>, LoadError> {
        let items = self.array(key)?.iter();
        items.map(|value| value.as_str().ok_or_else(|| self.error(key, "expected an array of strings"))).collect()
    }

    pub(super) fn bool(&self, key: &str, default: bool) -> Result<bool, LoadError> {
        Ok(self.get(key, "true or false", Value::as_bool)?.unwrap_or(default))
    }

    /// An integer that is not negative.
    pub(super) fn integer(&self, key: &str) -> Result<Option<usize>, LoadError> {
        self.get(key, "an integer that is not negative", integer)
    }

    pub(super) fn require_integer(&self, key: &str) -> Result<usize, LoadError> {
        self.integer(key)?.ok_or_else(|| self.error(key, "expected an integer that is not negative, found nothing"))
    }

    /// An index below `length`, the number of `what`.
    pub(super) fn index(&self, key: &str, length: usize, what: &str) -> Result<Option<usize>, LoadError> {
        let index = self.integer(key)?;
        match index {
            Some(index) if index >= length => {
                Err(self.error(key, format!("refers to {what} {index}, but there are {length}")))
            }
            _ => Ok(index),
        }
    }

    /// An array of indices below `length`.
    pub(super) fn indices(&self, key: &str, length: usize, what: &str) -> Result<Vec<usize>, LoadError> {
        let items = self.array(key)?.iter();
        items
            .map(|value| {
                integer(value)
                    .filter(|&index| index < length)
                    .ok_or_else(|| self.error(key, format!("expected indices of {what} below {length}")))
            })
            .collect()
    }

    pub(super) fn number(&self, key: &str) -> Result<Option<f32>, LoadError> {
        self.get(key, "a finite number", number)
    }

    pub(super) fn number_in(&self, key: &str, default: f32, min: f32, max: f32) -> Result<f32, LoadError> {
        let value = self.number(key)?.unwrap_or(default);
        if value < min || value > max {
            return Err(self.error(key, format!("expected a number from {min} to {max}, found {value}")));
        }
        Ok(value)
    }

    pub(super) fn number_list(&self, key: &str) -> Result<Option<Vec<f32>>, LoadError> {
        self.get(key, "an array of finite numbers", |value| value.as_array()?.iter().map(number).collect())
    }

    pub(super) fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f32; N]>, LoadError> {
        match self.number_list(key)? {
            Some(list) => match list.try_into() {
                Ok(array) => Ok(Some(array)),
                Err(_) => Err(self.error(key, format!("expected {N} numbers"))),
            },
            None => Ok(None),
        }
    }
}

fn integer(value: &Value) -> Option<usize> {
    match value.as_u64() {
        Some(integer) => usize::try_from(integer).ok(),
        None => {
            let number = value.as_f64().filter(|number| number.fract() == 0.0)?;
            (0.0..=f64::from(u32::MAX)).contains(&number).then_some(number as usize)
        }
    }
}

fn number(value: &Value) -> Option<f32> {
    value.as_f64().map(|number| number as f32).filter(|number| number.is_finite())
}
