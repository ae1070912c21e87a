//! The documentation of settings, from the declarations of the passes.

use manypass::settings::SettingType;
use manypass::{Aov, EffectFile, Quality, Settings};
use manypass_scene::renamed::{NameKind, RENAMED};
use std::fmt::Write as _;

/// How the types of settings begin.
const TYPES_BEGIN: &str =
    "// Written by `cargo xtask goldens` from the declarations of settings, tiers, variables and effects.

/**
 * Settings by key, as in `--set` on the command line; docs/settings.md describes each. Effects add their own keys,
 * such as `bloom.strength`.
 */
export interface Settings {
";

/// How they end: keys that are not known here are those of effects.
const TYPES_END: &str = "  [key: string]: number | boolean | string | (number | string)[] | undefined;
}
";

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

/// `crates/web/module/manypass_settings.d.ts`: what settings take, and the names of tiers, variables and built-in
/// effects, for TypeScript.
pub fn typescript() -> String {
    let mut text = String::from(TYPES_BEGIN);
    for info in Settings::declared() {
        let ty = typescript_type(&info.kind, info.choices);
        let _ = writeln!(text, "  \"{}\"?: {ty};", info.key);
        for row in RENAMED.iter().filter(|row| row.kind == NameKind::Setting && row.name == info.key) {
            let _ = writeln!(text, "  /** @deprecated {row}. */\n  \"{}\"?: {ty};", row.older);
        }
    }
    text += TYPES_END;
    let names = [
        ("The name of a quality tier (docs/quality.md).", "QualityName", union_of(Quality::NAMES.iter().copied())),
        (
            "The name of an AOV (arbitrary output variable). docs/aovs.md says what each holds.",
            "VariableName",
            union_of(Aov::ALL.iter().map(|aov| aov.name())),
        ),
        ("The name of an effect that is built in.", "BuiltInEffectName", union_of(EffectFile::built_in_names())),
    ];
    for (doc, name, union) in names {
        let _ = writeln!(text, "/** {doc} */\nexport type {name} = {union};");
    }
    text
}

/// Words as TypeScript has them.
fn union_of<'n>(names: impl Iterator<Item = &'n str>) -> String {
    names.map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(" | ")
}

/// What a setting of a type takes in JavaScript; `choices` are its words, or its few numbers.
fn typescript_type(kind: &SettingType, choices: &[&str]) -> String {
    let words = union_of(choices.iter().copied());
    match kind {
        SettingType::Number(numbers) if numbers.count > 1 => "number[]".into(),
        SettingType::Number(_) if !choices.is_empty() => choices.join(" | "),
        SettingType::Number(_) => "number".into(),
        SettingType::Boolean => "boolean".into(),
        SettingType::Switch => "boolean | \"auto\"".into(),
        SettingType::Choice => words,
        SettingType::Color => "string | number[]".into(),
        // Editors offer the words, and any other text is a colour.
        SettingType::ChoiceOrColor | SettingType::ChoiceOrColors => format!("{words} | (string & {{}}) | number[]"),
        SettingType::Exposure => format!("{words} | (string & {{}}) | number"),
        SettingType::Text | SettingType::Path => "string".into(),
        SettingType::List(entry) => format!("string | Array<{}>", typescript_type(entry, choices)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_name_every_word_and_no_more_than_is_taken() {
        let text = typescript();
        for info in Settings::declared() {
            let line = text.lines().find_map(|line| line.trim_start().strip_prefix(&format!("\"{}\"?: ", info.key)));
            let line = line.unwrap_or_else(|| panic!("`{}` has no type", info.key)).trim_end_matches(';');
            let types: Vec<&str> = line.split(" | ").collect();
            for choice in info.choices {
                let typed = [format!("\"{choice}\""), (*choice).to_owned()];
                assert!(types.iter().any(|ty| typed.iter().any(|choice| choice == ty)), "`{}`: {line}", info.key);
                // The renderer takes what the types offer.
                Settings::default().set(&info.key, choice).expect("a choice");
            }
            let takes_words_alone = info.kind == SettingType::Choice;
            assert!(!takes_words_alone || types.len() == info.choices.len(), "`{}` takes more: {line}", info.key);
        }
    }

    #[test]
    fn older_names_have_the_type_of_those_of_today_and_are_deprecated() {
        let text = typescript();
        for row in RENAMED.iter().filter(|row| row.kind == NameKind::Setting) {
            let lines: Vec<&str> = text.lines().collect();
            let at = |key: &str| lines.iter().position(|line| line.starts_with(&format!("  \"{key}\"?: ")));
            let (older, now) = (at(row.older).expect(row.older), at(row.name).expect(row.name));
            assert!(lines[older - 1].starts_with("  /** @deprecated ") && lines[older - 1].contains(row.name), "{row}");
            assert_eq!(lines[older].replace(row.older, row.name), lines[now]);
        }
    }
}
