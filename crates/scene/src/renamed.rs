//! Names that users write and that have changed. An older name works for one version more, and whoever reads it says the
//! name of today.
//!
//! ```
//! # use manypass_scene::renamed::{NameKind, current};
//! assert_eq!(current(NameKind::StageTable, "surroundings"), "reflection_probes");
//! assert_eq!(current(NameKind::StageTable, "lights"), "lights");
//! ```

use std::fmt::{self, Display, Formatter};

/// Where a name stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NameKind {
    /// A list of tables in stages, `[[name]]`.
    StageTable,
    /// A key in the list of tables that has this name today.
    StageKey(&'static str),
    /// The dotted key of a setting.
    Setting,
    /// A built-in scene, `demo:NAME`.
    Demo,
}

/// A name with the older name that still works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NameChange {
    /// Where it stands.
    pub kind: NameKind,
    /// The older name.
    pub older: &'static str,
    /// The name of today.
    pub name: &'static str,
}

/// The table of stages whose keys have older names.
const REFLECTION_PROBES: NameKind = NameKind::StageKey("reflection_probes");

/// All of them. A row goes when the next version is out.
pub static RENAMED: [NameChange; 6] = [
    NameChange { kind: NameKind::StageTable, older: "surroundings", name: "reflection_probes" },
    NameChange { kind: REFLECTION_PROBES, older: "walls", name: "parallax_correction" },
    NameChange { kind: REFLECTION_PROBES, older: "walls_center", name: "parallax_center" },
    NameChange { kind: REFLECTION_PROBES, older: "walls_size_m", name: "parallax_size_m" },
    NameChange { kind: NameKind::Setting, older: "shadows.turns", name: "shadows.spread_over_samples" },
    NameChange { kind: NameKind::Demo, older: "surroundings", name: "reflection_probes" },
];

/// What the older name `name` is called now; none if it is no older name.
pub fn renamed(kind: NameKind, name: &str) -> Option<&'static NameChange> {
    RENAMED.iter().find(|renamed| renamed.kind == kind && renamed.older == name)
}

/// The name of today: that of an older name, or `name` itself.
pub fn current(kind: NameKind, name: &str) -> &str {
    renamed(kind, name).map_or(name, |renamed| renamed.name)
}

impl NameChange {
    /// A name of this kind as users write it.
    pub fn written(&self, name: &str) -> String {
        match self.kind {
            NameKind::StageTable => format!("[[{name}]]"),
            NameKind::StageKey(_) | NameKind::Setting => name.to_owned(),
            NameKind::Demo => format!("demo:{name}"),
        }
    }
}

/// The notice: a sentence without a full stop.
impl Display for NameChange {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (older, name) = (self.written(self.older), self.written(self.name));
        let place = if let NameKind::StageKey(table) = self.kind { format!(" of [[{table}]]") } else { String::new() };
        write!(f, "`{older}`{place} is now called `{name}`; the older name works in this version alone")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn older_names_are_names_no_longer_and_each_stands_once() {
        for (index, row) in RENAMED.iter().enumerate() {
            assert_eq!(renamed(row.kind, row.name), None, "{row}");
            assert_eq!(current(row.kind, row.older), row.name);
            let others = RENAMED[..index].iter();
            assert!(others.clone().all(|other| (other.kind, other.older) != (row.kind, row.older)), "{row}");
        }
    }

    #[test]
    fn notices_name_both() {
        let notice = |kind, name| renamed(kind, name).map(ToString::to_string);
        assert_eq!(
            notice(NameKind::StageTable, "surroundings").as_deref(),
            Some(
                "`[[surroundings]]` is now called `[[reflection_probes]]`; the older name works in this version alone"
            )
        );
        let walls = notice(REFLECTION_PROBES, "walls").unwrap_or_default();
        assert!(walls.starts_with("`walls` of [[reflection_probes]] is now called `parallax_correction`;"), "{walls}");
        assert_eq!(notice(NameKind::StageKey("simulations"), "walls"), None);
    }
}
