//! Python of the pages is run as it stands there, beside the files that commands of its page write.

use crate::common::{Folder, has_adapter, python, run_in, triangle_glb};
use manypass_testkit::needs;
use manypass_testkit::pages::{self, Command as Shown, Snippet};
use std::path::Path;
use std::process::{Command, Stdio};

/// What is said behind a command so that it takes no second.
const TINY: [&str; 5] = ["--size", "32x18", "--samples", "1", "--quiet"];

/// Modules of other renderers, which `cargo xtask setup` does not bring.
const OTHERS: [&str; 1] = ["f3d"];

/// What is to be true behind a snippet that holds the first text.
const TRUE: [(&str, &str); 5] = [
    (
        "header[\"worldToNDC\"]",
        r#"
hit = np.isfinite(depth)
assert hit.any() and (w, h) == (32, 18) and list(names.values()) == ["tri"], names
assert np.abs(pixels - np.stack([x, y], -1))[hit].max() < 0.01
with OpenEXR.File("a.exr", separate_channels=True) as file:
    position = {part.name(): part for part in file.parts}["position"].channels
    position = np.stack([position[name].pixels for name in "XYZ"], -1)
assert np.abs(p_world[..., :3] - position)[hit].max() < 1e-3
"#,
    ),
    (
        "a.depth.png",
        r"
hit = np.isfinite(depth)
assert hit.any() and not hit.all() and depth[hit].min() == note['low'][0] and depth[hit].max() == note['high'][0]
",
    ),
    (
        "transform_matrix =",
        "\nassert np.allclose(np.array(transform_matrix)[:3, 3], header['manypass/eye'], atol=1e-4)\n",
    ),
    (
        "data.npz",
        r"
assert data['frames'].shape == (1, 18, 32, 4) and data['frames'].dtype == np.uint8
assert data['depth'].shape == (1, 18, 32, 1) and data['depth'].dtype == np.float32
assert data['normal'].shape == (1, 18, 32, 3) and data['normal'].dtype == np.float32
assert np.isfinite(data['depth']).any()
",
    ),
    ("f3d.png", "\nimport os\nassert os.path.getsize('f3d.png') > 1000\n"),
];

/// The modules that a snippet imports.
fn modules(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    for line in text.lines() {
        let code = line.split('#').next().unwrap_or_default().trim();
        let names: Vec<&str> = match (code.strip_prefix("import "), code.strip_prefix("from ")) {
            (Some(names), _) => names.split(',').collect(),
            (None, Some(name)) => vec![name],
            (None, None) => Vec::new(),
        };
        found.extend(names.into_iter().filter_map(|name| name.split([' ', '.']).find(|word| !word.is_empty())));
    }
    found
}

/// Whether a command writes a file of this name: as it says, or as a variable beside it.
fn writes(shown: &Shown, name: &str) -> bool {
    let output = shown.words.iter().position(|word| word == "-o").and_then(|at| shown.words.get(at + 1));
    let parts = output.and_then(|output| output.rsplit_once('.')).filter(|_| shown.words[0] == "manypass");
    parts.is_some_and(|(stem, ending)| name.starts_with(&format!("{stem}.")) && name.ends_with(&format!(".{ending}")))
}

/// Writes what a snippet reads, by the commands of its page.
fn make(folder: &Folder, snippet: &Snippet, commands: &[Shown]) {
    for name in snippet.text.split('"').skip(1).step_by(2) {
        if let Some(shown) = commands.iter().find(|command| writes(command, name)) {
            let words: Vec<&str> = shown.words.iter().skip(1).map(String::as_str).collect();
            run_in(folder, &[&words[..], &TINY[..]].concat()).expect(0);
        }
    }
}

/// What Python says of a snippet that fails, or of what is not true behind it.
fn fault(folder: &Folder, python: &Path, snippet: &Snippet) -> Option<String> {
    let truth = TRUE.iter().find(|(part, _)| snippet.text.contains(*part)).map_or("", |(_, truth)| *truth);
    // As many lines stand before it as in the page, so that Python names those of the page.
    let text = format!("{}{}{truth}", "\n".repeat(snippet.line.saturating_sub(1)), snippet.text);
    let script = format!("{}.py", snippet.page.replace('/', "_"));
    folder.write(&script, text.as_bytes());
    let mut command = Command::new(python);
    let output = command.arg(&script).current_dir(&**folder).stdin(Stdio::null()).output().expect("Python starts");
    let said = String::from_utf8_lossy(&output.stderr);
    (!output.status.success()).then(|| format!("{}: {said}", snippet.place(0)))
}

/// Runs the snippets whose modules are wanted, and gives how many there are. If a module of one is missing, the others
/// are run, and the test counts as skipped.
fn run_snippets(name: &str, is_wanted: impl Fn(&[&str]) -> bool) -> usize {
    let folder = Folder::new(name);
    for model in ["model.glb", "models/model.glb"] {
        folder.write(model, &triangle_glb([1.0, 0.0, 0.0]));
    }
    let (mut count, mut faults, mut skipped) = (0, Vec::new(), Vec::new());
    for (page, text) in pages::pages() {
        let commands = pages::commands(&page, &text);
        for snippet in pages::snippets(&page, &text).iter().filter(|snippet| snippet.language == "python") {
            let modules = modules(&snippet.text);
            if !is_wanted(&modules) {
                continue;
            }
            count += 1;
            if let Some(python) = python(&modules) {
                make(&folder, snippet, &commands);
                faults.extend(fault(&folder, &python, snippet));
            } else {
                skipped.push(format!("{} ({})", snippet.place(0), modules.join(", ")));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    if !skipped.is_empty() {
        needs::skip(format_args!(
            "no Python with the modules of {}; MANYPASS_PYTHON names one that has them",
            skipped.join(", ")
        ));
    }
    count
}

#[test]
fn python_of_the_pages_runs() {
    if !has_adapter() {
        return;
    }
    let count = run_snippets("docs-python", |modules| !modules.iter().any(|module| OTHERS.contains(module)));
    assert!(count >= 4, "{count} snippets");
}

#[test]
fn python_of_other_renderers_runs_where_they_are() {
    let count = run_snippets("docs-others", |modules| modules.iter().any(|module| OTHERS.contains(module)));
    assert!(count >= 1, "{count} snippets");
}

#[test]
fn what_is_to_be_true_is_of_snippets_that_are_there() {
    let pages = pages::pages();
    let all: Vec<Snippet> = pages.iter().flat_map(|(page, text)| pages::snippets(page, text)).collect();
    for (part, _) in TRUE {
        let count = all.iter().filter(|found| found.language == "python" && found.text.contains(part)).count();
        assert_eq!(count, 1, "snippets with {part:?}");
    }
}

#[test]
fn a_wrong_snippet_is_a_fault_at_its_line() {
    let Some(python) = python(&[]) else {
        needs::skip("no Python");
        return;
    };
    let folder = Folder::new("docs-wrong");
    let of = |text: &str| {
        let (page, language) = ("docs/a.md".to_owned(), "python".to_owned());
        fault(&folder, &python, &Snippet { page, line: 7, language, text: text.to_owned() })
    };
    assert_eq!(of("a = 1\n"), None);
    let said = of("a = 1\nb = c\n").expect("a fault");
    assert!(said.starts_with("docs/a.md:7: ") && said.contains("line 8") && said.contains("NameError"), "{said}");
    assert_eq!(
        modules("import json, numpy as np  # b\nfrom PIL import Image\nimport os.path\n"),
        ["json", "numpy", "PIL", "os"]
    );
}
