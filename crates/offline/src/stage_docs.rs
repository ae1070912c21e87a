//! The documentation of stage files, from the declarations of their reader.

use manypass_scene::renamed::{NameKind, RENAMED};
use manypass_scene::stage::keys::{SETTINGS_TABLES, TABLES};
use std::fmt::Write as _;

/// The tables of `docs/stage.md`, in Markdown.
pub fn markdown_tables() -> String {
    let mut text = String::new();
    for table in &TABLES {
        let title = if table.name.is_empty() { "Before all tables".into() } else { format!("`[[{}]]`", table.name) };
        let _ = writeln!(text, "### {title}\n\n{}\n\n| key | type | what it does |\n|---|---|---|", wrapped(table.doc));
        for key in table.keys {
            let needed = if key.is_required { " Required." } else { "" };
            let _ = writeln!(text, "| `{}` | {} | {}{needed} |", key.name, key.kind.name(), key.doc);
        }
        text.push('\n');
    }
    text.push_str("### Tables of settings\n\n| table | what it holds |\n|---|---|\n");
    for (name, doc) in SETTINGS_TABLES {
        let _ = writeln!(text, "| `[{name}]` | {doc} |");
    }
    text.push_str("\n### Older names\n\n| older name | name | where |\n|---|---|---|\n");
    for row in &RENAMED {
        let place = match row.kind {
            NameKind::StageTable => "stages".into(),
            NameKind::StageKey(table) => format!("`[[{table}]]` of stages"),
            NameKind::Setting => "settings".into(),
            NameKind::Demo => "built-in scenes".into(),
        };
        let _ = writeln!(text, "| `{}` | `{}` | {place} |", row.written(row.older), row.written(row.name));
    }
    text.push_str(OLDER_NAMES);
    text
}

/// The text on older names.
const OLDER_NAMES: &str = "
Older names work in this version alone. A hint names the name of today, once a run; `--strict` does not refuse it. On
the page the hint is one of `viewer.warnings()`. The older name of a table or key beside the name of today in one stage
is an error. Of two names of a setting the last line counts. The schema of stages, that of settings and the page's
types mark older names as deprecated.
";

/// Prose in lines of at most 120 characters, as all pages have it.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= 120 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}

/// The JSON Schema of stage files, as `docs/stage.schema.json` has it.
pub fn schema() -> String {
    format!("{:#}\n", manypass::stage_schema())
}
