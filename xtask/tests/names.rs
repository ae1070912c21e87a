//! The names of types: a noun that says what it holds, and neither a participle (`Asked`) nor a filler (`Part`) alone.

use crate::programs::below;
use manypass_testkit::pages::root;
use std::collections::BTreeSet;

/// Words that are no names by themselves: participles that do not end in `ed`, and what fits whatever a type holds.
const WORDS: [&str; 44] = [
    "Along",
    "Around",
    "Arriving",
    "Before",
    "Brought",
    "Built",
    "Casting",
    "Chosen",
    "Common",
    "Cut",
    "Drawn",
    "Flat",
    "Found",
    "From",
    "Given",
    "Has",
    "Held",
    "Kept",
    "Known",
    "Laid",
    "Left",
    "Lit",
    "Made",
    "Many",
    "Moving",
    "Own",
    "Part",
    "Pending",
    "Preparing",
    "Read",
    "Ready",
    "Running",
    "Seen",
    "Sent",
    "Several",
    "Shown",
    "Special",
    "Then",
    "Told",
    "Undrawn",
    "Unread",
    "Wanting",
    "Written",
    "Wrong",
];
/// Nouns that end as participles do.
const NOUNS: [&str; 4] = ["Feed", "Need", "Seed", "Speed"];

/// The name of the type or trait that a line declares.
fn declared(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let line = match line.strip_prefix("pub(") {
        Some(rest) => rest.split_once(')')?.1.trim_start(),
        None => line.strip_prefix("pub ").unwrap_or(line),
    };
    let kinds = ["struct ", "enum ", "union ", "trait ", "type "];
    let name = kinds.iter().find_map(|kind| line.strip_prefix(kind))?;
    name.split(|letter: char| !letter.is_alphanumeric()).next().filter(|name| !name.is_empty())
}

/// Whether a name says what a type holds.
fn is_noun(name: &str) -> bool {
    let is_participle = name.ends_with("ed") && !NOUNS.iter().any(|noun| name.ends_with(noun));
    !is_participle && !WORDS.contains(&name)
}

#[test]
fn types_have_nouns_for_names() {
    let (mut files, mut faults, mut count) = (BTreeSet::new(), Vec::new(), 0);
    for folder in ["crates", "xtask"] {
        below(&root().join(folder), &mut files);
    }
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        for (index, line) in text.lines().enumerate() {
            let Some(name) = declared(line) else { continue };
            count += 1;
            if !is_noun(name) {
                faults.push(format!("{}:{}: {name}", file.display(), index + 1));
            }
        }
    }
    assert!(count > 1_000, "{count} types");
    assert!(faults.is_empty(), "name these by a noun for what they hold:\n{}", faults.join("\n"));
}

#[test]
fn participles_and_fillers_are_found() {
    let refused =
        ["struct Seen;", "pub(crate) enum Asked {", "    pub struct NotDrawnAsNeeded<'a>(u8);", "type Part = u8;"];
    for line in refused {
        assert!(!is_noun(declared(line).expect("a type")), "{line}");
    }
    for line in ["pub struct ViewRequest {", "enum ExrPart {", "struct Need {", "pub trait FocusSpeed: Sync {"] {
        assert!(is_noun(declared(line).expect("a type")), "{line}");
    }
    for line in ["/// struct Seen", "let struct_ = 1;", "impl Seen {", "public struct Seen;"] {
        assert_eq!(declared(line), None, "{line}");
    }
}
