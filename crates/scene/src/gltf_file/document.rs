//! What the parts of the reader share.

use super::component::Component;
use super::error::LoadError;
use super::faults::{Faults, List};
use super::json::Json;
use crate::tally::Tally;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A checked range of a buffer.
pub(super) struct View {
    pub(super) buffer: usize,
    pub(super) offset: usize,
    pub(super) length: usize,
    pub(super) stride: Option<usize>,
}

/// The elements of an accessor, tightly packed.
pub(super) struct DecodedAccessor {
    pub(super) component: Component,
    pub(super) count: usize,
    pub(super) bytes: Vec<u8>,
}

/// What the parts of the reader share.
pub(super) struct Document<'a> {
    pub(super) root: Json<'a>,
    pub(super) accessors: Vec<Json<'a>>,
    pub(super) views: Vec<View>,
    pub(super) buffers: Vec<Option<Cow<'a, [u8]>>>,
    pub(super) warnings: Tally,
    /// What is broken and may not be needed.
    pub(super) faults: Faults,
    /// Accessors of the primitive that is read, if it is packed.
    pub(super) unpacked: BTreeMap<usize, DecodedAccessor>,
    /// The UV sets of the file that vertices have for each material.
    pub(super) uv_sets: Vec<[u32; 2]>,
    /// The names of the file's variants.
    pub(super) variants: Vec<String>,
    /// Bytes that may still be decoded, so that accessors which share bytes cannot multiply them without end.
    pub(super) budget_bytes: u64,
    /// The same for accessors without bytes of their own.
    pub(super) zeros_budget_bytes: u64,
}

impl Document<'_> {
    /// Counts a warning. Those of the same kind differ in numbers alone, those of their places too.
    pub(super) fn warn(&mut self, pointer: &str, message: &str) {
        let kind: String = format!("{pointer} {message}").chars().filter(|c| !c.is_ascii_digit()).collect();
        let place = if pointer.is_empty() { String::new() } else { format!("at \"{pointer}\"") };
        self.warnings.add_as(&kind, place, message);
    }

    /// Numbers of at least 0 and at most `max`; those outside are moved there, with a warning.
    pub(super) fn clamped<const N: usize>(
        &mut self,
        json: &Json,
        key: &str,
        default: [f32; N],
        max: f32,
    ) -> Result<[f32; N], LoadError> {
        let given = json.numbers(key)?.unwrap_or(default);
        Ok(self.clamp(json, key, given, max))
    }

    /// As [`Self::clamped`], for a single number.
    pub(super) fn clamped_number(&mut self, json: &Json, key: &str, default: f32, max: f32) -> Result<f32, LoadError> {
        let given = [json.number(key)?.unwrap_or(default)];
        let [number] = self.clamp(json, key, given, max);
        Ok(number)
    }

    fn clamp<const N: usize>(&mut self, json: &Json, key: &str, given: [f32; N], max: f32) -> [f32; N] {
        let numbers = given.map(|number| number.clamp(0.0, max));
        if numbers != given {
            let upper = if max == f32::MAX { String::new() } else { format!(" and at most {max}") };
            self.warn(&json.at(key), &format!("expected at least 0{upper}, found {given:?}; {numbers:?} is used"));
        }
        numbers
    }
}

impl Document<'_> {
    /// Whether the buffer of a view has bytes; glTF allows one without a URI.
    pub(super) fn has_bytes(&self, view: usize) -> bool {
        let buffer = self.views.get(view).and_then(|view| self.buffers.get(view.buffer));
        buffer.is_some_and(Option::is_some)
    }

    /// What is wrong with a view or its buffer.
    ///
    /// # Errors
    /// Something is.
    pub(super) fn check_view(&self, index: usize) -> Result<(), LoadError> {
        self.faults.check(List::Views, index)?;
        self.views.get(index).map_or(Ok(()), |view| self.faults.check(List::Buffers, view.buffer))
    }

    /// The bytes of a buffer view that `pointer` refers to.
    pub(super) fn view_bytes(&self, index: usize, pointer: &str) -> Result<(&[u8], Option<usize>), LoadError> {
        let view = self.views.get(index).ok_or_else(|| {
            LoadError::invalid(pointer, format!("refers to bufferView {index}, but there are {}", self.views.len()))
        })?;
        self.check_view(index)?;
        let bytes = self.buffers.get(view.buffer).and_then(Option::as_ref);
        let bytes = bytes.and_then(|bytes| bytes.get(view.offset..view.offset.saturating_add(view.length)));
        let bytes = bytes.ok_or_else(|| {
            LoadError::invalid(pointer, "refers to a buffer that has no bytes; give the buffer a uri")
        })?;
        Ok((bytes, view.stride))
    }
}
