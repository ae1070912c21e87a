//! Stands in for simplification where the feature `simplify` is off.

use crate::{Cache, Scene};

impl Scene {
    /// Makes no levels, and says so: the feature `simplify` is off.
    pub fn simplify(&mut self) -> Vec<String> {
        self.simplify_with(None)
    }

    /// As [`Self::simplify`].
    pub fn simplify_with(&mut self, _cache: Option<&dyn Cache>) -> Vec<String> {
        vec!["meshes are not simplified: this program was built without the feature `simplify`".into()]
    }
}
