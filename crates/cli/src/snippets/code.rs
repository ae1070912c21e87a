//! Snippets of languages that are compiled elsewhere: what they show stands where it is compiled.

use manypass_testkit::pages::{Snippet, root};
use std::collections::HashSet;
use std::path::Path;
use std::process::{Command, Stdio};

/// Where the types of the page's module are.
const TYPES: [&str; 2] = ["crates/web/module/manypass_web.d.ts", "crates/web/src/types.rs"];
/// What pages of the docs show of Rust stands in such a file: a module of doc tests.
const DOC_TESTS: &str = "snippets.rs";

/// Options of F3D 4.0.0 that say how it draws: what begins with `render.` of `f3d.Options().get_all_names()` of the
/// package at <https://pypi.org/project/f3d/4.0.0/>, and the axes of its window.
const F3D_OPTIONS: [&str; 29] = [
    "render.armature.enable",
    "render.axes_grid.enable",
    "render.backface_type",
    "render.background.blur_coc",
    "render.background.color",
    "render.background.skybox",
    "render.effect.ambient_occlusion",
    "render.effect.antialiasing.mode",
    "render.effect.blending.mode",
    "render.effect.display_depth",
    "render.effect.final_shader",
    "render.effect.tone_mapping",
    "render.grid.absolute",
    "render.grid.color",
    "render.grid.enable",
    "render.grid.opacity",
    "render.grid.reflection",
    "render.grid.subdivisions",
    "render.grid.unit",
    "render.hdri.ambient",
    "render.hdri.file",
    "render.light.intensity",
    "render.line_width",
    "render.point_size",
    "render.raytracing.denoise",
    "render.raytracing.enable",
    "render.raytracing.samples",
    "render.show_edges",
    "ui.axis",
];

/// A file of the repository.
struct Source {
    name: String,
    text: String,
    /// Whether it is part of the module for browsers.
    is_of_web: bool,
}

/// The files below a folder with an ending.
fn files(folder: &Path, ending: &str, found: &mut Vec<Source>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()) {
        if path.is_dir() {
            files(&path, ending, found);
        } else if path.extension().is_some_and(|end| end == ending) {
            let text = std::fs::read_to_string(&path).expect("a text");
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            found.push(Source { name, text, is_of_web: path.to_string_lossy().contains("crates/web/") });
        }
    }
}

fn sources(ending: &str) -> Vec<Source> {
    let mut found = Vec::new();
    for folder in ["crates", "docs/examples", "xtask"] {
        files(&root().join(folder), ending, &mut found);
    }
    assert!(found.len() > 20, "{} files .{ending}", found.len());
    found
}

/// A line without the marks of doc comments, comments at its end and spaces that mean nothing.
fn plain(line: &str) -> String {
    let line = line.trim_start();
    let line = ["/// ", "//! "].iter().find_map(|mark| line.strip_prefix(mark)).unwrap_or(line);
    let code = line.split(" //").next().unwrap_or_default().trim();
    if code.starts_with("//") { String::new() } else { code.split_whitespace().collect::<Vec<_>>().join(" ") }
}

/// What is wrong with Rust: of the docs, lines that no doc test has one after the other; of the architecture, which
/// shows parts of what is there, lines that no source has.
pub fn rust_faults(snippet: &Snippet) -> Vec<String> {
    let sources = sources("rs");
    let wanted: Vec<(usize, String)> = snippet.text.lines().map(plain).enumerate().collect();
    let wanted: Vec<&(usize, String)> = wanted.iter().filter(|(_, line)| !line.is_empty()).collect();
    if snippet.page == "ARCHITECTURE.md" {
        let known: HashSet<String> = sources.iter().flat_map(|file| file.text.lines()).map(plain).collect();
        let missing = wanted.iter().filter(|(_, line)| !known.contains(line));
        return missing.map(|(at, line)| format!("{}: no source has `{line}`", snippet.place(*at))).collect();
    }
    let tested = |text: &str| {
        let mut left = wanted.iter().peekable();
        for line in text.lines().map(plain) {
            left.next_if(|(_, wanted)| *wanted == line);
        }
        left.next().map(|(at, line)| (*at, line.clone()))
    };
    let doc_tests = sources.iter().filter(|file| file.name == DOC_TESTS && file.text.contains(&snippet.page));
    let missing: Vec<Option<(usize, String)>> = doc_tests.map(|file| tested(&file.text)).collect();
    if missing.contains(&None) {
        return Vec::new();
    }
    let first = missing.into_iter().flatten().max().or_else(|| wanted.first().map(|found| (*found).clone()));
    let (at, line) = first.unwrap_or_default();
    vec![format!("{}: no doc test in a file {DOC_TESTS} of {} has `{line}`", snippet.place(at), snippet.page)]
}

/// That each line of a header stands in a file of the same language.
pub fn check_lines(snippet: &Snippet, ending: &str) -> Result<(), String> {
    let sources = sources(ending);
    for (at, line) in snippet.text.lines().map(str::trim).enumerate().filter(|(_, line)| !line.is_empty()) {
        if !sources.iter().any(|file| file.text.lines().any(|known| known.trim() == line)) {
            return Err(format!("{}: no .{ending} file has the line `{line}`", snippet.place(at)));
        }
    }
    Ok(())
}

/// Names of the module's calls, and of keys of what they take and give, that the module's types do not have.
pub fn script_faults(snippet: &Snippet) -> Vec<String> {
    let types = TYPES.map(|file| std::fs::read_to_string(root().join(file)).expect("the module's types")).concat();
    let calls: String = sources("rs").into_iter().filter(|file| file.is_of_web).map(|file| file.text).collect();
    let calls = calls + &types;
    let has = |text: &str, forms: &[String]| forms.iter().any(|form| text.contains(form.as_str()));
    let mut faults = Vec::new();
    for (at, line) in snippet.text.lines().enumerate() {
        for (name, kind) in names(line) {
            let is_known = match kind {
                Name::Call => has(
                    &calls,
                    &[
                        format!("pub fn {name}("),
                        format!("pub async fn {name}("),
                        format!("js_name = {name})"),
                        format!("  {name}("),
                    ],
                ),
                Name::Import => has(&types, &[format!("export function {name}("), format!("export class {name} ")]),
                Name::Key => has(&types, &[format!(" {name}: "), format!(" {name}?: ")]),
            };
            if !is_known {
                faults.push(format!("{}: `{name}` is in no type of the module", snippet.place(at)));
            }
        }
    }
    faults
}

#[derive(Clone, Copy)]
enum Name {
    /// After `viewer.`.
    Call,
    /// Between the braces of an import.
    Import,
    /// Of an object, or between braces before `=`.
    Key,
}

/// The names of a line of JavaScript that are the module's.
fn names(line: &str) -> Vec<(String, Name)> {
    let code = line.split("//").next().unwrap_or_default();
    // What stands between quotes is no name.
    let code: String = code.split('"').step_by(2).collect::<Vec<_>>().join("\"\"");
    let is_name = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let end_name = |text: &str| text.chars().rev().take_while(|letter| is_name(*letter)).collect::<Vec<_>>();
    let mut found = Vec::new();
    for after in code.split("viewer.").skip(1) {
        found.push((after.chars().take_while(|letter| is_name(*letter)).collect(), Name::Call));
    }
    let kind = if code.trim_start().starts_with("import") { Name::Import } else { Name::Key };
    for (before, after) in code.split('{').skip(1).filter_map(|part| part.split_once('}')) {
        // `{ a, b } = …` and `import { a }` name without colons.
        if after.trim_start().starts_with('=') || matches!(kind, Name::Import) {
            found.extend(before.split(',').map(|name| (name.trim().to_owned(), kind)));
        }
    }
    let mut parts: Vec<&str> = code.split(':').collect();
    parts.pop();
    for part in parts {
        let name: String = end_name(part.trim_end()).into_iter().rev().collect();
        if !name.is_empty() {
            found.push((name, Name::Key));
        }
    }
    found
}

/// Keys of a table of options that F3D does not have, of a snippet that calls it.
pub fn f3d_faults(snippet: &Snippet) -> Vec<String> {
    let mut faults = Vec::new();
    for (at, line) in snippet.text.lines().enumerate().filter(|_| snippet.text.contains("import f3d")) {
        let parts: Vec<&str> = line.split('"').collect();
        // Between quotes stands every other part, and a key is what a colon follows.
        for pair in parts.get(1..).unwrap_or_default().chunks_exact(2) {
            if pair[1].trim_start().starts_with(':') && !F3D_OPTIONS.contains(&pair[0]) {
                faults.push(format!("{}: F3D has no option `{}`", snippet.place(at), pair[0]));
            }
        }
    }
    faults
}

/// What Python says of a snippet that it cannot parse, at its line. Without Python nothing is said.
pub fn python_faults(snippet: &Snippet) -> Vec<String> {
    let script = "import ast, sys\ntry: ast.parse(sys.argv[1])\nexcept SyntaxError as e: print(f'{e.lineno}:{e.msg}')";
    let mut command = Command::new("python3");
    let Ok(output) = command.args(["-c", script, snippet.text.as_str()]).stdin(Stdio::null()).output() else {
        return Vec::new();
    };
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let fault = said.trim().split_once(':').map(|(line, message)| {
        let line: usize = line.parse().unwrap_or(1);
        format!("{}: {message}", snippet.place(line.saturating_sub(1)))
    });
    fault.into_iter().collect()
}
