//! Commands of the pages that take no time are run as they stand there, and those that draw at a tiny size.

mod common;

use common::{Folder, has_adapter, run_in, run_with, triangle_glb};
use manypass_testkit::pages::{self, Command, root};
use std::collections::HashSet;

/// Where files are that pages name without a folder.
const FOLDERS: [&str; 3] = ["", "crates/render/examples", "docs/examples/effects"];
/// The size of stills; the last of a flag that is given twice counts.
const STILL: [&str; 4] = ["--size", "32x18", "--samples", "1"];

const DEMO: &str = "a demo takes more than a second; crates/cli and crates/render draw them";
const LIGHT: &str = "an environment is prefiltered for seconds; crates/cli/tests/environment.rs";
const OWN: &str = "files of the user's that no file of the repository stands in for";
const SETTING: &str = "it differs from a command that is run in settings alone, whose values are parsed";

/// Commands that are parsed alone (crates/cli/src/snippets/commands.rs): their page, or any if it is empty, what they
/// hold, and why.
const PARSED: [(&str, &str, &str); 32] = [
    ("", "demo:", DEMO),
    ("", "hall.stage.toml", DEMO),
    ("", "manypass bake", "crates/cli/tests/baking.rs bakes what has light"),
    ("README.md", "--environment sky", LIGHT),
    ("docs/antialiasing.md", "", SETTING),
    ("docs/baking.md", "render baked.glb", OWN),
    ("docs/camera.md", "--cameras", OWN),
    ("docs/camera.md", "camera.f_stop", SETTING),
    ("docs/camera.md", "camera.fisheye", SETTING),
    ("docs/camera.md", "camera.shutter_deg", SETTING),
    ("docs/diff.md", "--environment sky.hdr", LIGHT),
    ("docs/diff.md", "diff before.glb after.glb -o", SETTING),
    ("docs/effects.md", "--effect bloom", SETTING),
    ("docs/environment.md", "--background 203040,a0c0e0", SETTING),
    ("docs/environment.md", "--background ffffff", SETTING),
    ("docs/environment.md", "--environment", LIGHT),
    ("docs/environment.md", "--ground c8b8a0", SETTING),
    ("docs/environment.md", "--ground none", SETTING),
    ("docs/environment.md", "dusk.stage.toml", LIGHT),
    ("docs/exposure.md", "", SETTING),
    ("docs/gi.md", "", SETTING),
    ("docs/materials.md", "shoe.gltf", OWN),
    ("docs/occlusion.md", "", SETTING),
    ("docs/probes.md", "render baked.glb", OWN),
    ("docs/reflections.md", "", SETTING),
    ("docs/shadows.md", ".stage.toml", OWN),
    ("docs/shadows.md", "--set shadows.", SETTING),
    ("docs/streams.md", "--turntable", SETTING),
    ("docs/streams.md", "--frames", SETTING),
    ("docs/streams.md", "--variant", OWN),
    ("docs/surface_detail.md", "yard.stage.toml", OWN),
    ("docs/transparency.md", "--set", SETTING),
];

/// The commands of all pages that stand in snippets, each once.
fn commands() -> Vec<Command> {
    let mut known = HashSet::new();
    let of_page = |(page, text): &(String, String)| pages::commands(page, text);
    let mut commands: Vec<Command> = pages::pages().iter().flat_map(of_page).collect();
    commands.retain(|command| {
        let is_ours = !command.is_mentioned && command.words[0] == "manypass";
        is_ours && known.insert(command.words.clone())
    });
    commands
}

/// Its words behind the program's name.
fn words(command: &Command) -> Vec<&str> {
    command.words.iter().skip(1).map(String::as_str).collect()
}

fn draws_nothing(words: &[&str]) -> bool {
    match words.first() {
        Some(&("settings" | "info")) => true,
        Some(&"graph") => words.contains(&"--limits"),
        _ => false,
    }
}

/// Brings what a command names: files of the repository, and triangles for models of the user's.
fn stand_in(folder: &Folder, words: &[&str]) {
    for word in words {
        let known = FOLDERS.iter().map(|folder| root().join(folder).join(word)).find(|path| path.is_file());
        if let Some(path) = known {
            folder.write(word, &std::fs::read(path).expect("a file of the repository"));
        } else if word.ends_with(".glb") && !word.contains('*') {
            folder.write(word, &triangle_glb([1.0, 0.0, 0.0]));
        }
    }
}

/// What is said behind a command so that it takes no second.
fn smaller(words: &[&str]) -> Vec<&'static str> {
    let is_of_pictures = !words.iter().any(|word| word.ends_with(".glb"));
    match words.first() {
        Some(&"bench") => return vec!["--size", "32x18", "--count", "1"],
        Some(&"graph") => return Vec::new(),
        Some(&"diff") if is_of_pictures => return Vec::new(),
        _ => {}
    }
    let mut more = STILL.to_vec();
    for (flag, value) in [("--frames", "0..1"), ("--turntable", "2")] {
        if words.contains(&flag) {
            more.extend([flag, value]);
        }
    }
    more
}

/// The place among [`PARSED`] of a command that is not run.
fn parsed_alone(command: &Command) -> Option<usize> {
    let text = command.words.join(" ");
    PARSED.iter().position(|(page, part, _)| (page.is_empty() || command.page == *page) && text.contains(part))
}

#[test]
fn commands_of_the_pages_that_draw_nothing_run() {
    let folder = Folder::new("docs");
    let mut count = 0;
    for command in commands() {
        let words = words(&command);
        if !draws_nothing(&words) {
            continue;
        }
        stand_in(&folder, &words);
        let run = run_in(&folder, &words);
        assert_eq!(run.code, 0, "{}: {}: {}", command.place, words.join(" "), run.stderr);
        assert!(!run.stdout.is_empty(), "{}: it prints nothing", command.place);
        count += 1;
    }
    assert!(count >= 5, "{count} commands");
}

#[test]
fn commands_of_the_pages_that_draw_run_at_a_tiny_size() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("docs-drawn");
    let cache = folder.join("cache").display().to_string();
    // Pipelines are compiled once for all of them.
    let variables = [("XDG_CACHE_HOME", cache.as_str()), ("MANYPASS_NO_CACHE", "")];
    let run = |words: &[&str]| run_with(&folder, words, &variables);
    folder.write("models/tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    for picture in ["still.png", "still.exr"] {
        run(&[&["render", "models/tri.glb", "-o", picture][..], &STILL[..]].concat()).expect(0);
    }
    let (mut count, mut used) = (0, HashSet::new());
    for command in commands().iter().filter(|command| !draws_nothing(&words(command))) {
        if let Some(at) = parsed_alone(command) {
            used.insert(at);
            continue;
        }
        let words = words(command);
        stand_in(&folder, &words);
        let output = words.iter().position(|word| *word == "-o").and_then(|at| words.get(at + 1));
        if words[0] == "diff" {
            for word in words.iter().filter(|word| Some(*word) != output) {
                for (ending, still) in [(".png", "still.png"), (".exr", "still.exr")] {
                    if word.ends_with(ending) {
                        folder.write(word, &std::fs::read(folder.join(still)).expect("a picture"));
                    }
                }
            }
        }
        let run = run(&[&words[..], &smaller(&words)[..]].concat());
        assert_eq!(run.code, 0, "{}: {}: {}", command.place, words.join(" "), run.stderr);
        if let Some(output) = output.filter(|output| **output != "-" && !output.contains('{')) {
            assert!(folder.join(output).exists(), "{}: there is no {output}", command.place);
        }
        count += 1;
    }
    assert!(count >= 20, "{count} commands");
    for (at, (page, part, reason)) in PARSED.iter().enumerate() {
        assert!(used.contains(&at), "{page} has no command with {part:?}, which is not run: {reason}");
    }
}
