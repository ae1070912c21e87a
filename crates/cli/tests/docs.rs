//! Commands of the pages are run: as they stand there where they draw nothing, else at a tiny size. Stages and settings
//! of the pages are drawn, too.

use crate::common::stand_ins::{self, room_glb};
use crate::common::{Folder, has_adapter, run_in, run_with, triangle_glb};
use manypass_testkit::pages::{self, Command, root};
use std::collections::HashSet;

/// Where files are that pages name without a folder.
const FOLDERS: [&str; 4] = ["", "crates/render/examples", "docs/examples/effects", "docs/examples"];
/// The size of stills; the last of a flag that is given twice counts.
const STILL: [&str; 4] = ["--size", "32x18", "--samples", "1"];
const BAKE: [&str; 4] = ["--density", "1", "--samples", "1"];

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

/// The file that a command writes, if it says so.
fn output<'a>(words: &[&'a str]) -> Option<&'a str> {
    let at = words.iter().position(|word| *word == "-o")?;
    words.get(at + 1).copied()
}

/// Brings what a command names: files of the repository, and small ones for the user's own.
fn stand_in(folder: &Folder, words: &[&str]) {
    let output = output(words);
    // The hall takes a quarter of a minute.
    let is_too_much = |name: &str| words.first() == Some(&"bake") && name.ends_with(".stage.toml");
    for word in words.iter().filter(|word| Some(**word) != output) {
        // A setting may name one, too.
        let name = word.rsplit('=').next().unwrap_or_default();
        let known = FOLDERS.iter().map(|folder| root().join(folder).join(name)).find(|path| path.is_file());
        if let Some(path) = known.filter(|_| !is_too_much(name)) {
            folder.write(name, &std::fs::read(path).expect("a file of the repository"));
        } else if let Some(bytes) = stand_ins::of(name) {
            folder.write(name, &bytes);
        }
    }
}

/// What is said behind a command so that it takes no second.
fn smaller(words: &[&str]) -> Vec<&'static str> {
    let is_of_pictures = !words.iter().any(|word| word.ends_with(".glb"));
    match words.first() {
        Some(&"bench") => return vec!["--size", "32x18", "--count", "1"],
        Some(&"bake") => return BAKE.to_vec(),
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

/// Runs every second of the commands that draw, from `first` on, in a folder of its own. Gives how many, and what is
/// wrong with them.
fn draw(first: usize, cache: &str) -> (usize, Vec<String>) {
    let folder = Folder::new(&format!("docs-drawn-{first}"));
    let variables = [("XDG_CACHE_HOME", cache), ("MANYPASS_NO_CACHE", "")];
    let run = |words: &[&str]| run_with(&folder, words, &variables);
    folder.write("models/tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    stand_ins::write_all(&folder);
    run(&[&["bake", "room.glb", "-o", "baked.glb", "--what", "all"][..], &BAKE[..]].concat()).expect(0);
    for picture in ["still.png", "still.exr"] {
        run(&[&["render", "models/tri.glb", "-o", picture][..], &STILL[..]].concat()).expect(0);
    }
    let (mut count, mut faults) = (0, Vec::new());
    let all = commands();
    let drawn = all.iter().filter(|command| !draws_nothing(&words(command)));
    for command in drawn.skip(first).step_by(2) {
        let words = words(command);
        stand_in(&folder, &words);
        let output = output(&words);
        if words[0] == "diff" {
            for word in words.iter().filter(|word| Some(**word) != output) {
                for (ending, still) in [(".png", "still.png"), (".exr", "still.exr")] {
                    if word.ends_with(ending) {
                        folder.write(word, &std::fs::read(folder.join(still)).expect("a picture"));
                    }
                }
            }
        }
        let run = run(&[&words[..], &smaller(&words)[..]].concat());
        if run.code != 0 {
            faults.push(format!("{}: {}: {}", command.place, words.join(" "), run.stderr));
        } else if let Some(output) = output.filter(|output| *output != "-" && !output.contains('{'))
            && !folder.join(output).exists()
        {
            faults.push(format!("{}: there is no {output}", command.place));
        }
        count += 1;
    }
    (count, faults)
}

#[test]
fn commands_of_the_pages_that_draw_run_at_a_tiny_size() {
    if !has_adapter() {
        return;
    }
    // Pipelines are compiled once for all of them.
    let folder = Folder::new("docs-cache");
    let cache = folder.join("cache").display().to_string();
    let cache = cache.as_str();
    let halves = std::thread::scope(|scope| {
        let halves = [0, 1].map(|first| scope.spawn(move || draw(first, cache)));
        halves.map(|half| half.join().expect("it runs them"))
    });
    let count: usize = halves.iter().map(|(count, _)| count).sum();
    let faults: Vec<&str> = halves.iter().flat_map(|(_, faults)| faults).map(String::as_str).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count >= 70, "{count} commands");
}

/// Stages and settings that are parsed alone (crates/cli/src/snippets.rs): the page, a part, and why.
const NOT_DRAWN: [(&str, &str, &str); 3] = [
    ("docs/environment.md", "prefiltered_file", "its KTX2 file has no stand-in; crates/cli/tests/environment.rs"),
    ("docs/probes.md", "spacing_m", "a thousand probes are baked; crates/bake/tests/probes.rs bakes fewer"),
    (
        "docs/surface_detail.md",
        "yard.obj",
        "it takes heights of a library of the user's; crates/scene/tests/inputs/obj.rs",
    ),
];

/// Writes what a page shows of TOML as files that can be drawn: stages, and settings.
fn write_toml(folder: &Folder, page: &str, text: &str) -> [Vec<String>; 2] {
    let snippets = pages::snippets(page, text);
    let (mut stages, mut settings, mut whole) = (Vec::new(), Vec::new(), String::new());
    // The effect that docs/effects.md shows, and names in its chains.
    let shown = snippets.iter().find(|snippet| snippet.language == "wgsl" && page == "docs/effects.md");
    if let Some(effect) = shown {
        folder.write("grow.wgsl", effect.text.as_bytes());
    }
    for snippet in snippets.iter().filter(|snippet| snippet.language == "toml") {
        let is_left_out = |(of, part, _): &(&str, &str, &str)| page == *of && snippet.text.contains(*part);
        if NOT_DRAWN.iter().any(is_left_out) {
            continue;
        }
        let has = |start: &str| snippet.text.lines().any(|line| line.trim_start().starts_with(start));
        let stem = page.trim_start_matches("docs/").trim_end_matches(".md");
        if !["model = ", "[[", "[fog]", "[environment]", "[effects]", "[settings"].into_iter().any(has) {
            settings.push(format!("{stem}-{}.toml", snippet.line));
            folder.write(&settings[settings.len() - 1], snippet.text.as_bytes());
            continue;
        }
        // A part of a stage stands in the one before if it names something of it, and else in one of its own.
        let before = match has("monitor = ") {
            _ if has("model = ") => "",
            true => whole.as_str(),
            false => "model = \"room.glb\"\n",
        };
        let stage = format!("{before}{}", snippet.text);
        stages.push(format!("{stem}-{}.stage.toml", snippet.line));
        folder.write(&stages[stages.len() - 1], stage.as_bytes());
        whole = stage;
    }
    [stages, settings]
}

#[test]
fn stages_and_settings_of_the_pages_are_drawn() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("docs-stages");
    for name in ["room.glb", "bay.glb", "house.glb", "helmet.glb", "yard.glb"] {
        folder.write(name, &room_glb());
    }
    let tiny = ["--size", "8x8", "--samples", "1", "-q"];
    run_in(&folder, &[&["render", "room.glb", "-o", "crack.png"], &tiny[..]].concat()).expect(0);
    let image = std::fs::read(folder.join("crack.png")).expect("a picture");
    for name in ["bricks_height.png", "yard_light.png", "grain.png", "dirt.png"] {
        folder.write(name, &image);
    }
    let (mut stages, mut settings) = (Vec::new(), Vec::new());
    for (page, text) in pages::pages() {
        let [of_stages, of_settings] = write_toml(&folder, &page, &text);
        stages.extend(of_stages);
        settings.extend(of_settings);
    }
    assert!(stages.len() >= 15 && settings.len() >= 2, "{stages:?} {settings:?}");
    let files: Vec<&str> = stages.iter().map(String::as_str).collect();
    run_in(&folder, &[&["render"], &files[..], &["-o", "out/"], &tiny].concat()).expect(0);
    let drawn = std::fs::read_dir(folder.join("out")).expect("drawn").count();
    assert_eq!(drawn, stages.len());
    for file in settings {
        let args = ["render", "room.glb", "--settings", file.as_str(), "-o", "a.png"];
        run_in(&folder, &[&args[..], &tiny].concat()).expect(0);
    }
    for (page, part, reason) in NOT_DRAWN {
        let is_there = pages::pages().iter().any(|(of, text)| of == page && text.contains(part));
        assert!(is_there, "{page} has no {part:?}, which is not drawn: {reason}");
    }
}
