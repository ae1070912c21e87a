//! Batches and sequences: which files they find, what they call theirs, what they say, and what a killed one leaves.

use crate::common::watch::start;
use crate::common::{Folder, Run, has_adapter, run_in, triangle_glb};
use std::path::Path;
use std::time::{Duration, Instant};

const SMALL: [&str; 4] = ["--size", "16x16", "--samples", "1"];

fn render(folder: &Path, args: &[&str]) -> Run {
    run_in(folder, &[&["render"], args, &SMALL].concat())
}

fn lines(text: &str) -> Vec<serde_json::Value> {
    text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

/// The files below a folder, by path.
fn files(folder: &Path) -> Vec<String> {
    let (mut found, mut pending) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(next) = pending.pop() {
        for path in std::fs::read_dir(&next).expect("listed").map(|entry| entry.expect("entry").path()) {
            match path.is_dir() {
                true => pending.push(path),
                false => found.push(path.strip_prefix(folder).expect("below").to_string_lossy().into_owned()),
            }
        }
    }
    found.sort();
    found
}

#[test]
fn folders_below_are_found_and_names_tell_models_apart() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("recursion");
    for file in ["models/m.glb", "models/red/m.glb", "models/red/deep/n.glb", "models/.hidden/h.glb", "models/.h.glb"] {
        folder.write(file, &triangle_glb([1.0, 0.5, 0.0]));
    }
    // A .gltf beside the .glb; its buffer is in it.
    folder.write("models/m.gltf", br#"{"asset":{"version":"2.0"},"scenes":[{}],"scene":0}"#);
    render(&folder, &["models", "-o", "a", "--quiet"]).expect(0);
    assert_eq!(files(&folder.join("a")), ["m.glb.png", "m.gltf.png"]);
    render(&folder, &["models", "--recursive", "-o", "b/{parent}/{stem}.png", "--quiet"]).expect(0);
    let all = ["deep/n.png", "models/m.glb.png", "models/m.gltf.png", "red/m.png"];
    assert_eq!(files(&folder.join("b")), all);
    render(&folder, &["models/**/*.glb", "-o", "c/{parent}-{stem}.png", "--report", "r.jsonl"]).expect(0);
    assert_eq!(files(&folder.join("c")), ["deep-n.png", "models-m.png", "red-m.png"]);
    let report = lines(&std::fs::read_to_string(folder.join("r.jsonl")).expect("report"));
    assert_eq!(report.len(), 3);
    let run = render(&folder, &["models", "--recursive", "-o", "d/"]).expect(0);
    assert!(run.stderr.contains("draws nothing"), "{}", run.stderr);
    assert_eq!(files(&folder.join("d")), ["m.glb.png", "m.gltf.png", "m.png", "n.png"]);
    let run = render(&folder, &["nothing/**/*.glb"]).expect(1);
    assert!(run.stderr.contains("no model matches"), "{}", run.stderr);
}

#[test]
fn folders_and_patterns_without_a_model_do_not_hinder_other_inputs() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("empty-folder");
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    std::fs::create_dir(folder.join("empty")).expect("a folder");
    let report = |name: &str| lines(&std::fs::read_to_string(folder.join(name)).expect("report"));
    let run = render(&folder, &["empty", "gone*.glb", "tri.glb", "-o", "out/", "--report", "r.jsonl"]).expect(1);
    for part in ["cannot read empty: it holds no", "matches `gone*.glb`", "2 of 3 inputs failed", "the others are done"]
    {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
    assert_eq!(files(&folder.join("out")), ["tri.png"]);
    let found: Vec<_> =
        report("r.jsonl").iter().map(|line| (line["input"].clone(), line["error"].is_string())).collect();
    assert_eq!(found, [("empty".into(), true), ("gone*.glb".into(), true), ("tri.glb".into(), false)]);

    let run = render(&folder, &["empty", "gone*.glb", "-o", "none/", "--report", "n.jsonl"]).expect(1);
    assert!(run.stderr.ends_with("error: 2 of 2 inputs failed\nhint: the messages above say why\n"), "{}", run.stderr);
    assert!(report("n.jsonl").len() == 2 && !folder.join("none").exists());

    // A model that cannot be read is not one that is not there.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere.glb", folder.join("empty/lost.glb")).expect("a link");
        for input in ["empty", "empty/*.glb"] {
            let run = render(&folder, &[input, "tri.glb", "-o", "link/"]).expect(1);
            let is_said = run.stderr.contains("empty/lost.glb") && run.stderr.contains("1 of 2 inputs failed");
            assert!(is_said, "{}", run.stderr);
        }
    }
}

#[test]
fn a_frame_alone_has_its_number() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("one-frame");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    render(&folder, &["tri.glb", "--frames", "7..7", "--report", "r.jsonl"]).expect(0);
    render(&folder, &["tri.glb", "--turntable", "1", "-o", "turn/"]).expect(0);
    assert_eq!(files(&folder), ["r.jsonl", "tri.glb", "tri_0007.png", "turn/tri_0000.png"]);
    let report = std::fs::read_to_string(folder.join("r.jsonl")).expect("report");
    assert_eq!((report.lines().count(), lines(&report)[0]["frame"].as_u64()), (1, Some(7)));
    let run = render(&folder, &["tri.glb", "--frames", "7..7", "-o", "-", "--format", "png"]).expect(0);
    assert!(run.stdout == std::fs::read(folder.join("tri_0007.png")).expect("read"));
}

#[test]
fn reports_are_lines_wherever_there_may_be_several_pictures() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("lines");
    folder.write("one/tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let report = |args: &[&str]| render(&folder, &[args, &["-o", "x/", "--report", "-"]].concat()).expect(0).text();
    assert_eq!(report(&["one"]).lines().count(), 1);
    assert_eq!(report(&["one/*.glb"]).lines().count(), 1);
    assert!(report(&["one/tri.glb"]).lines().count() > 1);
    // People find the passes of one picture beside its report.
    let run =
        |args: &[&str]| render(&folder, &[args, &["one/tri.glb", "-o", "x/", "--report", "-"]].concat()).expect(0);
    let (said, quiet) = (run(&[]), run(&["--quiet"]));
    assert!(said.stderr.contains("share %  draws") && said.stderr.contains("\nsum "), "{}", said.stderr);
    assert!(lines(&said.text().replace('\n', " "))[0]["passes"].is_array());
    assert!(!quiet.stderr.contains("share %"), "{}", quiet.stderr);
    // The last of a flag that is given twice wins; those that repeat repeat.
    let twice = ["one/tri.glb", "--format", "exr", "--format", "png", "--report", "r", "--strict", "--strict"];
    let text = report(&[&twice[..], &["--set", "render.scale=0.5", "--set", "render.scale=1"]].concat());
    assert!(text.contains("\"output\": \"x/tri.png\"") && !folder.join("r").exists(), "{text}");
}

#[test]
fn skipping_keeps_what_was_reported_and_looks_for_every_file() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("skipping");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("report");
    let single = ["tri.glb", "-o", "a.png", "--skip-existing", "--report", "r.json"];
    render(&folder, &single).expect(0);
    let first = read("r.json");
    render(&folder, &single).expect(0);
    assert!(first.contains("\"samples\"") && read("r.json") == first);
    for extra in [["--contact-sheet", "s.png"], ["--dump-passes", "d"]] {
        render(&folder, &[&single[..], &extra].concat()).expect(0);
        let again = read("r.json");
        assert!(again != first && folder.join(extra[1]).exists(), "{extra:?}");
        render(&folder, &[&single[..], &extra].concat()).expect(0);
        assert_eq!(read("r.json"), again, "{extra:?}");
    }
    let frames = ["tri.glb", "gone.glb", "-o", "out/", "--frames", "3..4", "--skip-existing", "--report", "r.jsonl"];
    render(&folder, &frames).expect(1);
    render(&folder, &frames).expect(1);
    let report = lines(&read("r.jsonl"));
    assert_eq!(report.len(), 6);
    assert!(report[0]["samples"] == 1 && report[4]["skipped"] == true, "{report:?}");
    assert!(report[5]["frame"] == 3 && report[5]["version"].is_string() && report[5]["error"].is_string());
}

#[cfg(unix)]
#[test]
fn a_killed_batch_leaves_the_lines_of_what_is_done() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("killed");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let args = ["render", "tri.glb", "-o", "out/", "--frames", "0..100000", "--report", "r.jsonl", "--quiet"];
    let mut child = start(&folder, &[&args[..], &SMALL].concat());
    let begun = Instant::now();
    let done = || std::fs::read_to_string(folder.join("r.jsonl")).unwrap_or_default();
    while done().lines().count() < 3 {
        assert!(begun.elapsed() < Duration::from_secs(60), "no lines appear");
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    for line in lines(&done()) {
        let frame = line["frame"].as_u64().expect("a frame");
        assert!(image::open(folder.join(&format!("out/tri_{frame:04}.png"))).is_ok(), "{line}");
    }
}

#[test]
fn warnings_are_errors_where_that_is_asked_for() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("strict");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let floats = [-1_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    folder.write("still.bin", &floats.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
    folder.write(
        "still.gltf",
        br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "materials":[{"doubleSided":true,"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"gone.png"}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"still.bin"}]}"#,
    );
    let away = ["--eye", "0,0,5", "--target", "0,0,9"];
    // The box of the model reaches into this view, the triangle does not.
    let past = ["--eye", "0,0,1", "--target", "0.9,0.9,0", "--fov-y", "5"];
    for (args, part) in [
        (&["still.gltf"][..], "gone.png"),
        (&["still.gltf", "--time", "1"], "it has no animation"),
        (&["still.gltf", "--animation", "Walk"], "it has no animation"),
        (&[&["tri.glb"], &away[..]].concat(), "the picture is empty"),
        (&[&["tri.glb", "--background", "transparent"], &away[..]].concat(), "the picture is empty"),
        (&[&["tri.glb"], &past[..]].concat(), "the picture is empty"),
    ] {
        let run = render(&folder, &[args, &["-o", "warned/"]].concat()).expect(0);
        assert!(run.stderr.starts_with("warning: ") && run.stderr.contains(part), "{args:?}: {}", run.stderr);
        let run = render(&folder, &[args, &["-o", "strict/", "--strict", "--quiet"]].concat()).expect(1);
        assert!(run.stderr.starts_with("error: ") && run.stderr.contains(part), "{args:?}: {}", run.stderr);
        assert!(!folder.join("strict").exists(), "{args:?}");
    }
    for args in [&["tri.glb", "--time", "1"][..], &["tri.glb", "--eye", "0,0,1", "--target", "0,0,0", "--fov-y", "5"]] {
        let run = render(&folder, &[args, &["-o", "fine.png", "--strict"]].concat()).expect(0);
        assert!(run.stderr.is_empty(), "{}", run.stderr);
    }
    let run = render(&folder, &["tri.glb", "--animation", "Walk"]).expect(2);
    assert!(run.stderr.contains("animations by index or name: 0 `Slide`"), "{}", run.stderr);
}
