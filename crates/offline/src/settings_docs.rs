//! What is said of settings in documentation, from the declarations that the passes make.

use manypass::Settings;
use std::fmt::Write as _;

/// The table of `docs/settings.md`, in Markdown.
pub fn markdown_table() -> String {
    let mut text = String::from(
        "| key | type | default | range | unit | what it does | does nothing without |\n|---|---|---|---|---|---|---|\n",
    );
    for info in Settings::declared() {
        let default = info.default.as_ref().map_or("must be given".into(), |default| format!("`{default}`"));
        let unit = info.unit.as_deref().unwrap_or_default();
        let needs = info.needs.iter().map(|needs| format!("`{needs}`")).collect::<Vec<_>>().join(" ");
        // A cell without a word has one space.
        let line = format!(
            "| `{}` | {} | {default} | {} | {unit} | {} | {needs} |",
            info.key,
            info.kind,
            info.range(),
            info.doc
        );
        let _ = writeln!(text, "{}", line.replace("|  |", "| |").replace("|  |", "| |"));
    }
    text
}
