//! The declarations of all modules: most are in many of them, and each text is kept once.

use std::collections::{BTreeSet, HashMap};

/// Each declaration once, in the order in which they were met.
#[derive(Debug, Default)]
pub struct Table {
    texts: Vec<String>,
    indices: HashMap<String, u16>,
}

impl Table {
    /// The places of a module's declarations.
    pub fn indices(&mut self, module: Vec<String>) -> Vec<u16> {
        module.into_iter().map(|text| self.index(text)).collect()
    }

    fn index(&mut self, text: String) -> u16 {
        if let Some(index) = self.indices.get(&text) {
            return *index;
        }
        let index = u16::try_from(self.texts.len()).expect("shaders have less than 65,536 declarations");
        self.texts.push(text.clone());
        self.indices.insert(text, index);
        index
    }

    /// The declarations.
    pub fn texts(&self) -> &[String] {
        &self.texts
    }
}

/// The names of the `override` constants that any of some modules declares.
pub fn constants(modules: &[Vec<String>]) -> BTreeSet<&str> {
    let declarations = modules.iter().flatten();
    declarations.filter_map(|text| text.strip_prefix("override ")?.split(':').next()).collect()
}
