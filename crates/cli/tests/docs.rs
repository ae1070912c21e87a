//! Commands of the pages that take no time are run as they stand there, and those that draw at a tiny size. Stages and
//! settings of the pages are drawn, too.

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

/// Commands that are parsed alone (crates/cli/src/snippets/commands.rs): their page, or any if it is empty, what they
/// hold, and why.
const PARSED: [(&str, &str, &str); 14] = [
    ("", "demo:", DEMO),
    ("", "hall.stage.toml", DEMO),
    ("", "manypass bake", "crates/cli/tests/baking.rs bakes what has light"),
    ("docs/commands.md", "--environment sky", LIGHT),
    ("docs/baking.md", "render baked.glb", OWN),
    ("docs/camera.md", "--cameras", OWN),
    ("docs/diff.md", "--environment sky.hdr", LIGHT),
    ("docs/environment.md", "--environment", LIGHT),
    ("docs/environment.md", "dusk.stage.toml", LIGHT),
    ("docs/materials.md", "shoe.gltf", OWN),
    ("docs/probes.md", "render baked.glb", OWN),
    ("docs/shadows.md", ".stage.toml", OWN),
    ("docs/streams.md", "--variant", OWN),
    ("docs/surface_detail.md", "yard.stage.toml", OWN),
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

/// Runs every second of the commands that draw, from `first` on, in a folder of its own. Gives how many, and what is
/// wrong with them.
fn draw(first: usize, cache: &str) -> (usize, Vec<String>) {
    let folder = Folder::new(&format!("docs-drawn-{first}"));
    let variables = [("XDG_CACHE_HOME", cache), ("MANYPASS_NO_CACHE", "")];
    let run = |words: &[&str]| run_with(&folder, words, &variables);
    folder.write("models/tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    for picture in ["still.png", "still.exr"] {
        run(&[&["render", "models/tri.glb", "-o", picture][..], &STILL[..]].concat()).expect(0);
    }
    let (mut count, mut faults) = (0, Vec::new());
    let all = commands();
    let drawn = all.iter().filter(|command| !draws_nothing(&words(command)) && parsed_alone(command).is_none());
    for command in drawn.skip(first).step_by(2) {
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
        if run.code != 0 {
            faults.push(format!("{}: {}: {}", command.place, words.join(" "), run.stderr));
        } else if let Some(output) = output.filter(|output| **output != "-" && !output.contains('{'))
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
    assert!(count >= 50, "{count} commands");
    let used: HashSet<usize> = commands().iter().filter_map(parsed_alone).collect();
    for (at, (page, part, reason)) in PARSED.iter().enumerate() {
        assert!(used.contains(&at), "{page} has no command with {part:?}, which is not run: {reason}");
    }
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

/// A .glb with what stages name: quads as nodes `Lake` (it lies), `Glass`, `Door.1`, `Door.2`, `Goer.1` and `Wall`, a
/// node with a camera, and materials.
fn room_glb() -> Vec<u8> {
    let corners: [f32; 20] = [
        -1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0, // Positions, then UVs.
        0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0,
    ];
    let mut bin: Vec<u8> = corners.iter().flat_map(|value| value.to_le_bytes()).collect();
    bin.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    let mut nodes = vec![r#"{"name":"Lake","mesh":0,"rotation":[-0.70710678,0,0,0.70710678]}"#.to_owned()];
    for (at, name) in ["Glass", "Door.1", "Door.2", "Goer.1", "Wall"].iter().enumerate() {
        nodes.push(format!(r#"{{"name":"{name}","mesh":{},"translation":[{},0,0]}}"#, (at + 1) % 3, at + 1));
    }
    nodes.push(r#"{"name":"Ceiling camera","camera":0,"translation":[0,2,6]}"#.to_owned());
    let quad = r#""attributes":{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":1},"indices":2"#;
    let meshes = [0, 1, 2].map(|at| format!(r#"{{"primitives":[{{{quad},"material":{at}}}]}}"#)).join(",");
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,2,3,4,5,6]}}],"nodes":[{}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.8,"znear":0.1}}}}],"meshes":[{meshes}],
        "materials":[{{"name":"Screen"}},{{"name":"wall"}},{{"name":"roof"}}],
        "accessors":[
            {{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]}},
            {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
            {{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},
            {{"buffer":0,"byteOffset":80,"byteLength":12}}],
        "buffers":[{{"byteLength":92}}]}}"#,
        nodes.join(",")
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let (json_bytes, bin_bytes) = (json.len() as u32, bin.len() as u32);
    let head = [0x4654_6c67, 2, 28 + json_bytes + bin_bytes, json_bytes, 0x4e4f_534a].map(u32::to_le_bytes).concat();
    [head, json, [bin_bytes, 0x004e_4942].map(u32::to_le_bytes).concat(), bin].concat()
}

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
