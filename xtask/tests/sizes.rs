//! How long files and functions are: what is longer is two things.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const FILE_LINES_MAX: usize = 500;
/// Of functions outside tests.
const FUNCTION_LINES_MAX: usize = 90;

/// Tests that are longer, with their lines. The list may only become shorter, and its numbers smaller.
const LONGER: &[(&str, usize)] = &[
    ("crates/render/tests/effect_library.rs", 529),
    ("crates/render/tests/goldens/subjects.rs", 741),
    ("crates/render/tests/occlusion.rs", 643),
    ("crates/render/tests/overlay.rs", 509),
    ("crates/render/tests/surface_detail.rs", 569),
];

/// Folders of what is made or fetched.
const NOT_WRITTEN: [&str; 3] = ["node_modules", "pkg", "target"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The Rust and WGSL files below `folder`, by their path from the repository, with their texts.
fn read(folder: &Path, files: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(root().join(folder)).expect("listed") {
        let entry = entry.expect("an entry");
        let path = folder.join(entry.file_name());
        if root().join(&path).is_dir() {
            let name = entry.file_name();
            let is_written =
                !NOT_WRITTEN.iter().any(|other| name == *other) && !name.to_string_lossy().starts_with('.');
            if is_written {
                read(&path, files);
            }
        } else if path.extension().is_some_and(|end| end == "rs" || end == "wgsl") {
            let text = std::fs::read_to_string(root().join(&path)).expect("read");
            files.insert(path.to_string_lossy().replace('\\', "/"), text);
        }
    }
}

fn files() -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    ["crates", "xtask"].iter().for_each(|folder| read(Path::new(folder), &mut files));
    assert!(files.len() > 500, "{} files", files.len());
    files
}

/// Whether all of a file is a test's.
fn is_test(file: &str) -> bool {
    file.split('/').any(|part| part == "tests" || part == "tests.rs")
}

/// The name of the function that begins in a line.
fn function_name(line: &str) -> Option<&str> {
    const BEFORE: [&str; 6] = ["pub", "const", "async", "unsafe", "extern", "\"C\""];
    let (before, after) = line.trim_start().split_once("fn ")?;
    let is_visibility = |word: &str| word.starts_with("pub(") || word.ends_with(')');
    let begins = before.split_whitespace().all(|word| BEFORE.contains(&word) || is_visibility(word));
    let name = after.split(|letter: char| letter != '_' && !letter.is_alphanumeric()).next()?;
    (begins && !name.is_empty()).then_some(name)
}

/// The functions of a text, as rustfmt writes it, with their lines; those of tests at its end are left out.
fn functions(text: &str) -> Vec<(&str, usize)> {
    let text = text.split_once("#[cfg(test)]\nmod tests {").map_or(text, |(before, _)| before);
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let Some(name) = function_name(line) else { continue };
        if line.ends_with([';', '}']) {
            continue;
        }
        let indent = &line[..line.len() - line.trim_start().len()];
        let is_end = |line: &str| {
            line.strip_prefix(indent).is_some_and(|rest| rest == "}" || rest.starts_with(')') && rest.ends_with(';'))
        };
        let count = lines[start..].iter().position(|line| is_end(line)).map(|end| end + 1);
        found.extend(count.map(|count| (name, count)));
    }
    found
}

#[test]
fn functions_are_found_with_their_lines() {
    let text = "fn one() {}\n\npub(in crate::a) const fn two<T>(\n    a: T,\n) -> bool {\n    if x {\n    }\n}\n\n\
                impl A {\n    pub async fn three(&self) {\n        b\n    }\n}\n\ntrait B {\n    fn four(\n        a: A,\n    );\n}\n\n\
                // fn five() {\n#[cfg(test)]\nmod tests {\n    fn six() {\n        a\n    }\n}\n";
    assert_eq!(functions(text), [("two", 6), ("three", 3), ("four", 3)]);
}

#[test]
fn files_are_short() {
    let files = files();
    let allowed = |file: &str| LONGER.iter().find(|(name, _)| *name == file).map_or(FILE_LINES_MAX, |(_, most)| *most);
    let counts = || files.iter().map(|(file, text)| (file.as_str(), text.lines().count()));
    let longer: Vec<_> = counts().filter(|(file, count)| *count > allowed(file)).collect();
    assert!(longer.is_empty(), "ask what two things each is: {longer:?}");
    let is_longer = |file: &str| counts().any(|(name, count)| name == file && count > FILE_LINES_MAX);
    let shorter: Vec<_> = LONGER.iter().filter(|(file, _)| !is_longer(file)).collect();
    assert!(shorter.is_empty(), "they are short now: take them off the list: {shorter:?}");
}

#[test]
fn functions_are_short() {
    let files = files();
    let code = || files.iter().filter(|(file, _)| file.ends_with(".rs") && !is_test(file));
    let all: Vec<_> = code().flat_map(|(file, text)| functions(text).into_iter().map(move |of| (file, of))).collect();
    assert!(all.len() > 2_000, "{} functions", all.len());
    let longer: Vec<_> = all.into_iter().filter(|(_, (_, count))| *count > FUNCTION_LINES_MAX).collect();
    assert!(longer.is_empty(), "{longer:?}");
}
