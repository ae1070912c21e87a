//! ARCHITECTURE.md and the pages of decisions: short enough to be read, their links lead somewhere, and the files that
//! they name are there.

use manypass_testkit::pages::prose;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const ARCHITECTURE: &str = "ARCHITECTURE.md";
const DECISIONS: &str = "docs/decisions";
const ARCHITECTURE_BYTES_MAX: usize = 12_000;
/// Letters of a line outside tables and code.
const LINE_MAX: usize = 120;
/// Where files lie that pages name without the folders before them.
const FOLDERS: [&str; 3] = ["", "crates/render/src", "crates/render/src/shaders"];

/// What newcomers ask, as the table «Where is what» has it, and files that its answer names.
const QUESTIONS: [(&str, &[&str]); 5] = [
    ("shadow bias", &["shadows/settings.rs", "shaders/shadows.wgsl"]),
    ("fog and water", &["frame.rs"]),
    ("a new AOV", &["aov.rs", "gbuffer.rs", "frame/surfaces/deferred.rs"]),
    ("a new stage key", &["crates/scene/src/stage/keys/"]),
    ("a new texture file format", &["crates/scene/src/image.rs", "crates/scene/src/image/"]),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(page: &str) -> String {
    std::fs::read_to_string(root().join(page)).expect("a page")
}

/// The files of the decisions, without their index.
fn decisions() -> BTreeSet<String> {
    let entries = std::fs::read_dir(root().join(DECISIONS)).expect("decisions");
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    names.filter(|name| name != "README.md").collect()
}

fn pages() -> Vec<String> {
    let of_decisions = decisions().into_iter().map(|name| format!("{DECISIONS}/{name}"));
    [ARCHITECTURE.to_owned(), format!("{DECISIONS}/README.md")].into_iter().chain(of_decisions).collect()
}

/// Where the links of a line lead, without anchors and other sites.
fn links(line: &str) -> Vec<&str> {
    let targets = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let files = targets.filter_map(|target| target.split('#').next());
    files.filter(|file| !file.is_empty() && !file.contains("://")).collect()
}

/// The files and folders that a line names between backticks; what has `NAME` in it stands for any.
fn named(line: &str) -> Vec<&str> {
    let is_file = |code: &str| {
        let has_ending = [".rs", ".wgsl", ".md"].iter().any(|ending| code.ends_with(ending));
        let is_below = ["crates/", "xtask/", "docs/"].iter().any(|folder| code.starts_with(folder));
        (has_ending || is_below) && !code.contains("NAME") && !code.contains([' ', '*'])
    };
    line.split('`').skip(1).step_by(2).filter(|code| is_file(code)).collect()
}

fn is_there(file: &str) -> bool {
    FOLDERS.iter().any(|folder| root().join(folder).join(file).exists())
}

#[test]
fn the_architecture_is_short() {
    let bytes = read(ARCHITECTURE).len();
    assert!(bytes <= ARCHITECTURE_BYTES_MAX, "{bytes} bytes; what explains one file belongs into its header");
}

#[test]
fn lines_are_short() {
    let mut long = Vec::new();
    for page in pages() {
        let text = read(&page);
        let lines = prose(&text).into_iter().filter(|(_, line)| !line.starts_with('|'));
        long.extend(lines.filter(|(_, line)| line.chars().count() > LINE_MAX).map(|(at, _)| format!("{page}:{at}")));
    }
    assert!(long.is_empty(), "lines of more than {LINE_MAX} letters: {long:?}");
}

#[test]
fn links_lead_to_files_and_named_files_are_there() {
    let (mut wrong, mut count) = (Vec::new(), 0);
    for page in pages() {
        let text = read(&page);
        let folder = root().join(&page).parent().expect("a folder").to_owned();
        for (at, line) in prose(&text) {
            let of_line = (links(line), named(line));
            count += of_line.0.len() + of_line.1.len();
            let dead = of_line.0.into_iter().filter(|link| !folder.join(link).exists());
            wrong.extend(dead.map(|link| format!("{page}:{at}: the link {link}")));
            let missing = of_line.1.into_iter().filter(|file| !is_there(file));
            wrong.extend(missing.map(|file| format!("{page}:{at}: the file {file}")));
        }
    }
    assert!(count > 150, "{count} links and files");
    assert!(wrong.is_empty(), "not there:\n{}", wrong.join("\n"));
}

#[test]
fn the_index_has_every_decision() {
    let index = read(&format!("{DECISIONS}/README.md"));
    let rows = index.lines().filter(|line| line.starts_with("| ["));
    let listed: Vec<String> = rows.flat_map(links).map(str::to_owned).collect();
    let all: Vec<String> = decisions().into_iter().collect();
    assert_eq!(listed, all, "rows of {DECISIONS}/README.md, in the order of their numbers");
}

#[test]
fn the_table_answers_what_newcomers_ask() {
    let text = read(ARCHITECTURE);
    for (question, files) in QUESTIONS {
        let row = prose(&text).into_iter().find(|(_, line)| line.starts_with('|') && line.contains(question));
        let (at, row) = row.unwrap_or_else(|| panic!("no row of {ARCHITECTURE} has {question:?}"));
        let missing: Vec<&&str> = files.iter().filter(|file| !row.contains(&format!("`{file}`"))).collect();
        assert!(missing.is_empty(), "{ARCHITECTURE}:{at} does not name {missing:?}");
    }
}

#[test]
fn what_is_wrong_is_found() {
    assert_eq!(links("see [a](b.md#c), [d](https://e.f) and [g](#h)"), ["b.md"]);
    assert_eq!(named("`frame.rs`, `a b.rs`, `passes/NAME/mod.rs`, `docs/x`, `Vec`"), ["frame.rs", "docs/x"]);
    assert_eq!(prose("a\n```text\nb\n```\nc"), [(1, "a"), (5, "c")]);
    assert!(is_there("frame.rs") && is_there("light_table.wgsl") && !is_there("no_such_file.rs"));
}
