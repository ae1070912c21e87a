//! The form of the pages: how long lines are, where links lead, and that what they name is there.

use manypass_testkit::pages::{self, prose, root};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Lines of text are at most so long, in characters.
const LINE_MAX: usize = 120;
/// The README is at most so long, in bytes.
const README_BYTES_MAX: usize = 8000;
/// The command and the picture of a page stand above this line.
const OPENING_LINES: usize = 30;
/// Pages that nobody has drawn a picture for yet.
const WITHOUT_PICTURE: [&str; 13] = [
    "antialiasing",
    "aovs",
    "fidelity",
    "gi",
    "glossary",
    "inputs",
    "occlusion",
    "performance",
    "quality",
    "settings",
    "shaders",
    "streams",
    "support",
];

/// All pages by their path from the root.
fn all() -> BTreeMap<String, String> {
    let mut all: BTreeMap<String, String> = pages::pages().into_iter().collect();
    let changelog = std::fs::read_to_string(root().join("CHANGELOG.md")).expect("the changelog");
    all.insert("CHANGELOG.md".to_owned(), changelog);
    all
}

/// Numbers of lines that are too long and neither code nor of a table.
fn long_lines(text: &str) -> Vec<usize> {
    let lines = prose(text).into_iter();
    let long = lines.filter(|(_, line)| !line.trim_start().starts_with('|') && line.chars().count() > LINE_MAX);
    long.map(|(number, _)| number).collect()
}

/// The anchors of a page's headings, as GitHub makes them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text).into_iter().filter(|(_, line)| line.starts_with('#'));
    let anchor = |line: &str| -> String {
        let heading = line.trim_start_matches('#').trim().to_lowercase();
        let kept = heading.chars().filter(|letter| letter.is_alphanumeric() || [' ', '-', '_'].contains(letter));
        kept.map(|letter| if letter == ' ' { '-' } else { letter }).collect()
    };
    headings.map(|(_, line)| anchor(line)).collect()
}

/// What a page links to within the repository: the line, the path and the anchor, each empty if there is none.
fn links(text: &str) -> Vec<(usize, String, String)> {
    let mut links = Vec::new();
    for (number, line) in prose(text) {
        let prose: String = line.split('`').step_by(2).collect();
        for target in prose.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if !target.contains("://") {
                let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
                links.push((number, path.to_owned(), anchor.to_owned()));
            }
        }
    }
    links
}

/// A path of a link, from the root: `../README.md` in `docs/a.md` is `README.md`.
fn from_root(page: &str, path: &str) -> String {
    let mut found = PathBuf::new();
    for part in Path::new(page).parent().unwrap_or(Path::new("")).join(path).components() {
        match part {
            Component::ParentDir => {
                found.pop();
            }
            Component::CurDir => {}
            other => found.push(other),
        }
    }
    found.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// The links of a page that lead nowhere.
fn dead_links(page: &str, text: &str, all: &BTreeMap<String, String>) -> Vec<String> {
    let leads = |path: &str, anchor: &str| {
        let target = if path.is_empty() { page.to_owned() } else { from_root(page, path) };
        let has_anchor = || all.get(&target).is_some_and(|text| anchors(text).contains(anchor));
        root().join(&target).exists() && (anchor.is_empty() || has_anchor())
    };
    let dead = links(text).into_iter().filter(|(_, path, anchor)| !leads(path, anchor));
    dead.map(|(line, path, anchor)| format!("{page}:{line}: `{path}#{anchor}` leads nowhere")).collect()
}

/// What stands between backticks in a line.
fn code(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// Rows of the tables of a page, with their cells; a link's text may hold no `|`.
fn rows(text: &str) -> Vec<Vec<&str>> {
    let lines = prose(text).into_iter().map(|(_, line)| line);
    let rows = lines.filter(|line| line.starts_with('|') && !line.starts_with("|---"));
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

#[test]
fn lines_of_pages_are_short() {
    let long = |(page, text): (&String, &String)| -> Vec<String> {
        long_lines(text).iter().map(|line| format!("{page}:{line} has more than {LINE_MAX} characters")).collect()
    };
    let found: Vec<String> = all().iter().flat_map(long).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn long_lines_are_found_outside_of_tables_and_code() {
    let long = "ä".repeat(LINE_MAX + 1);
    let page = format!("{}\n{long}\n| {long} |\n```sh\n{long}\n```\n  {long}\n", "ä".repeat(LINE_MAX));
    assert_eq!(long_lines(&page), [2, 7]);
}

#[test]
fn links_of_pages_lead_somewhere() {
    let all = all();
    let count: usize = all.values().map(|text| links(text).len()).sum();
    assert!(count > 300, "{count} links");
    let found: Vec<String> = all.iter().flat_map(|(page, text)| dead_links(page, text, &all)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn links_that_lead_nowhere_are_found() {
    let all = BTreeMap::from([("docs/stage.md".to_owned(), "## Keys of `[[lights]]`\n".to_owned())]);
    let page =
        "[a](stage.md#keys-of-lights) [b](stage.md#locks)\n[c](../docs/no_such.md) [`d`](https://example.org/e)\n";
    let found = dead_links("docs/a.md", page, &all);
    let expected = ["docs/a.md:1: `stage.md#locks` leads nowhere", "docs/a.md:2: `../docs/no_such.md#` leads nowhere"];
    assert_eq!(found, expected);
}

/// The part of a page under the heading with such an anchor.
fn part_of<'t>(text: &'t str, anchor: &str) -> &'t str {
    let mut parts = text.split("\n## ").skip(1);
    let title = |part: &&str| format!("## {}", part.lines().next().unwrap_or_default());
    parts.find(|part| anchors(&title(part)).contains(anchor)).unwrap_or_default()
}

#[test]
fn the_readme_is_short_and_its_claims_are_those_of_the_table_of_support() {
    let all = all();
    let (readme, support) = (&all["README.md"], &all["docs/support.md"]);
    assert!(readme.len() <= README_BYTES_MAX, "{} bytes", readme.len());
    let (_, part) = readme.split_once("## What works where").expect("the part");
    let part = part.split("\n## ").next().unwrap_or_default();
    let claims: Vec<&str> = part.lines().filter(|line| line.starts_with("| [")).collect();
    assert_eq!(claims.len(), 8);
    for claim in claims {
        let (_, name) = claim.split_once("](docs/support.md#").expect("it names a part of docs/support.md");
        let name = name.split(')').next().unwrap_or_default();
        let of_part = rows(part_of(support, name));
        assert!(of_part.len() > 3, "docs/support.md has no `{name}`");
        // Of WebGPU and WebGL 2, whose cells stand one to the right in docs/support.md.
        let cells: Vec<&str> = claim.trim_matches('|').split('|').map(str::trim).collect();
        for at in [2, 3] {
            let is_whole = of_part.iter().all(|row| !row[at + 1].contains("not tested"));
            assert_eq!(!cells[at].contains("for most"), is_whole, "{claim}, cell {at}");
        }
    }
    assert!(rows(support).len() > 50, "{} rows", rows(support).len());
}

#[test]
fn every_feature_names_tests_that_are_there() {
    let cases = |name: &str| std::fs::read_to_string(root().join("xtask/tools/src/browser").join(name)).expect(name);
    let known = cases("cases.rs") + &cases("cases/told.rs");
    let text = &all()["docs/support.md"];
    let (mut features, mut files) = (0, 0);
    for row in rows(text).iter().filter(|row| row.len() == 7 && row[0] != "feature") {
        let (tests, of_browser) = (row[5], row[6]);
        let paths: Vec<&str> = code(tests).filter(|word| word.starts_with("crates/")).collect();
        assert!(!paths.is_empty(), "{} names no test", row[0]);
        for path in &paths {
            assert!(root().join(path).exists(), "{}: there is no {path}", row[0]);
        }
        for case in code(of_browser).filter(|word| !word.starts_with("cargo ")) {
            assert!(known.contains(&format!("\"{case}\"")), "{}: the browser draws no `{case}`", row[0]);
        }
        let is_compared = row[3].starts_with("same") || row[4].starts_with("same");
        assert!(!is_compared || !of_browser.is_empty(), "{} names no case of the browser", row[0]);
        features += 1;
        files += paths.len();
    }
    assert!(features > 50 && files > 80, "{features} features, {files} files");
}

#[test]
fn the_index_has_every_page() {
    let all = all();
    // Decisions have an index of their own, to which it leads.
    let of = |index: &str| links(&all[index]).iter().map(|(_, path, _)| from_root(index, path)).collect::<Vec<_>>();
    let indexed: BTreeSet<String> = ["docs/README.md", "docs/decisions/README.md"].into_iter().flat_map(of).collect();
    let missing: Vec<&String> =
        all.keys().filter(|page| page.as_str() != "docs/README.md" && !indexed.contains(*page)).collect();
    assert!(missing.is_empty(), "docs/README.md does not lead to {missing:?}");
}

#[test]
fn the_glossary_names_keys_and_tables_that_are_there() {
    let all = all();
    let (glossary, settings, stage) = (&all["docs/glossary.md"], &all["docs/settings.md"], &all["docs/stage.md"]);
    let keys: BTreeSet<&str> = rows(settings).iter().filter_map(|row| code(row[0]).next()).collect();
    let groups: BTreeSet<&str> = keys.iter().filter_map(|key| Some(key.split_once('.')?.0)).collect();
    let mut count = 0;
    for row in rows(glossary).iter().filter(|row| row.len() == 4) {
        for word in code(row[2]) {
            let key = word.split('=').next().unwrap_or_default();
            let is_key = key.split_once('.').is_some_and(|(group, name)| groups.contains(group) && name != "rs");
            assert!(!is_key || key.ends_with(".*") || keys.contains(key), "{}: there is no {key}", row[0]);
            let is_table = word.starts_with("[[");
            assert!(!is_table || stage.contains(&format!("`{word}`")), "{}: there is no {word}", row[0]);
            count += usize::from(is_key || is_table);
        }
    }
    assert!(count > 50, "{count} keys and tables");
}

/// What the opening of a page lacks: what it is for, a command and a picture, before the first heading within.
fn missing_of_opening(text: &str) -> Vec<&'static str> {
    let lines: Vec<&str> = text.lines().skip(1).take(OPENING_LINES).take_while(|line| !line.starts_with('#')).collect();
    let first = lines.iter().find(|line| !line.is_empty()).copied().unwrap_or_default();
    let mut missing = Vec::new();
    if first.is_empty() || ["![", "|", "```", "<!--", "- "].iter().any(|mark| first.starts_with(mark)) {
        missing.push("what it is for");
    }
    let is_command =
        |line: &&str| line.starts_with("manypass ") || line.starts_with("cargo ") || line.contains("`manypass ");
    if !lines.iter().any(is_command) {
        missing.push("a command");
    }
    if !lines.iter().any(|line| line.starts_with("![")) {
        missing.push("a picture");
    }
    missing
}

#[test]
fn pages_begin_with_what_they_are_for_a_command_and_a_picture() {
    let mut found = Vec::new();
    for (page, text) in all() {
        let Some(name) = page.strip_prefix("docs/").and_then(|name| name.strip_suffix(".md")) else { continue };
        if !name.contains('/') {
            let mut missing = missing_of_opening(&text);
            if WITHOUT_PICTURE.contains(&name) {
                assert_eq!(missing.pop(), Some("a picture"), "{page} has a picture: take it out of the list");
            }
            found.extend(missing.iter().map(|missing| format!("{page} does not begin with {missing}")));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn openings_that_lack_something_are_found() {
    let page = "# A\n\nIt is for this.\n\n```sh\nmanypass info a.glb\n```\n\n![A](a.png)\n";
    assert!(missing_of_opening(page).is_empty());
    assert_eq!(missing_of_opening("# A\n\n| a |\n"), ["what it is for", "a command", "a picture"]);
    assert_eq!(missing_of_opening(&page.replace("\n\n!", "\n\n## B\n!")), ["a picture"]);
}
