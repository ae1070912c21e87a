//! What is broken in a file.

use super::error::LoadError;
use std::collections::BTreeMap;

/// Where objects of a file are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum List {
    Buffers,
    Views,
    Meshes,
    Materials,
    Nodes,
    Skins,
    Lights,
}

/// The faults of objects, by their list and index.
#[derive(Debug, Default)]
pub(super) struct Faults(pub(super) BTreeMap<(List, usize), LoadError>);

impl Faults {
    /// What was read, or what stands in its place where it is broken.
    pub(super) fn or<T>(&mut self, list: List, index: usize, read: Result<T, LoadError>, instead: T) -> T {
        read.unwrap_or_else(|error| {
            self.0.insert((list, index), error);
            instead
        })
    }

    /// The first fault of all.
    ///
    /// # Errors
    /// There is one.
    pub(super) fn into_result(self) -> Result<(), LoadError> {
        self.0.into_values().next().map_or(Ok(()), Err)
    }

    /// The fault of an object.
    ///
    /// # Errors
    /// There is one.
    pub(super) fn check(&self, list: List, index: usize) -> Result<(), LoadError> {
        self.0.get(&(list, index)).map_or(Ok(()), |error| Err(error.clone()))
    }
}
