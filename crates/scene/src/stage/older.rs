//! Values and lists of a stage by their names, and the older names that it uses.

use crate::renamed::{NameChange, NameKind, RENAMED, current};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The value that is called `name` in the text.
pub(super) fn value<'t, 'i>(table: &'t DeTable<'i>, name: &str) -> Option<&'t Spanned<DeValue<'i>>> {
    table.iter().find(|(key, _)| &**key.get_ref() == name).map(|(_, value)| value)
}

/// The list of tables that is called `name` today, whichever name it has in the text.
pub(super) fn list_of<'t, 'i>(root: &'t DeTable<'i>, name: &str) -> Option<&'t Spanned<DeValue<'i>>> {
    root.iter().find(|(key, _)| current(NameKind::StageTable, key.get_ref()) == name).map(|(_, value)| value)
}

/// The older names in a stage, in the order of [`RENAMED`]; those of settings are not looked for.
pub(super) fn older_names(root: &DeTable<'_>, model: &str) -> Vec<&'static NameChange> {
    let is_used = |renamed: &&NameChange| match renamed.kind {
        NameKind::StageTable => value(root, renamed.older).is_some(),
        NameKind::StageKey(table) => {
            let entries = list_of(root, table).and_then(|list| list.get_ref().as_array());
            let mut entries = entries.into_iter().flatten().filter_map(|entry| entry.get_ref().as_table());
            entries.any(|entry| value(entry, renamed.older).is_some())
        }
        NameKind::Demo => model.strip_prefix("demo:") == Some(renamed.older),
        NameKind::Setting => false,
    };
    RENAMED.iter().filter(is_used).collect()
}
