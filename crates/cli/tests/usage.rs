//! What the program refuses, without a GPU: exit codes and messages.

use crate::common::{self, Folder, run_in, triangle_glb};

#[test]
fn wrong_usage_ends_with_2_and_says_what_is_wrong() {
    let folder = Folder::new("usage");
    let wrong: &[(&[&str], &str)] = &[
        (&["render"], "<INPUTS>"),
        (&["paint", "a.glb"], "paint"),
        (&["render", "a.glb", "--sise", "1x1"], "--size"),
        (&["render", "a.glb", "--size", "0x10"], "0x10"),
        (&["render", "a.glb", "--size", "0"], "`0` is not a size"),
        (&["render", "a.glb", "--size", "999999999x999999999"], "999999999"),
        (&["render", "a.glb", "--samples", "0"], "--samples"),
        (&["render", "a.glb", "--tonemap", "filmic"], "neutral"),
        (&["render", "a.glb", "-o", "a.jpg", "--background", "transparent"], "jpg has no transparency"),
        (&["render", "a.glb", "--set", "cluster.slice=4"], "clusters.slices"),
        (&["render", "a.glb", "--set", "render.scale=99"], "from 0.25 to 2"),
        (&["render", "a.glb", "--set", "render.scale"], "KEY=VALUE"),
        (&["render", "a.glb", "--orbit", "1,2"], "--orbit"),
        (&["render", "a.glb", "--eye", "1,2,3", "--orbit", "1,2,3"], "--orbit"),
        (&["render", "a.glb", "--camera", "0", "--eye", "1,2,3"], "--eye"),
        (&["render", "a.glb", "--frames", "3..1"], "3..1"),
        (&["render", "a.glb", "--frames", "0..3", "--fps", "0"], "--fps 0"),
        (&["render", "a.glb", "--exposure", "nan"], "--exposure"),
        (&["render", "a.glb", "--environment-intensity", "inf"], "--environment-intensity"),
        (&["render", "a.glb", "--aov", "dpth"], "depth"),
        (&["render", "a.glb", "--aov", "all,dpth"], "unknown AOV `dpth`"),
        (&["render", "a.glb", "--aov", "depth", "--path", "forward"], "deferred"),
        (&["render", "a.glb", "-o", "-"], "--format"),
        (&["a.glb"], "write `manypass render a.glb`"),
        (&["render", "-a.glb"], "write ./-a.glb"),
        (&["render", "a.glb", "-o", ""], "`` is not the name of an output"),
        (&["render", "a.glb", "-o", ".png"], "`.png` is not the name of an output"),
        (&["render", "a.glb", "-o", "a.gif"], "gif"),
        (&["render", "a.glb", "-o", "a.jpg", "--format", "png"], "--format png and `a.jpg` disagree"),
        (&["render", "a.glb", "b.glb", "-o", "same.png"], "same.png"),
        (&["render", "a.glb", "a.depth.glb", "--aov", "depth"], "a.depth.png"),
        (&["render", "a.glb", "--frames", "0..4294967295", "-o", "one.png"], "one.png"),
        (&["render", "a.glb", "--frames", "3..3", "-o", "one.png"], "one.png"),
        (&["render", "a.glb", "--turntable", "1", "-o", "one.png"], "one.png"),
        (&["render", "a.glb", "--frames", "3..3", "--contact-sheet", "one.png"], "one.png"),
        (&["render", "a.glb", "--frames", "0..1", "-o", "-", "--format", "png"], "one picture"),
        (
            &["render", "a.glb", "-o", "{foo}.png"],
            "{parent}, {stem}, {variant}, {camera}, {frame}, {frame:04} and {aov}",
        ),
        (&["render", "a.glb", "--dump-passes", "{stam}"], "unknown placeholder `{stam}`"),
        (&["render", "a.glb", "-o", "-", "--format", "png", "--report", "-"], "standard output"),
        (&["render", "a.glb", "-o", "-", "--format", "png", "--report", "/dev/stdout"], "standard output"),
        (&["render", "a.glb", "--frames", "-3..2"], "-3..2"),
        (&["render", "a.glb", "--near", "-1"], "--near -1 is out of range"),
        (&["render", "a.glb", "--fov-y", "-5"], "--fov-y -5 is out of range"),
        (&["render", "a.glb", "--time", "-inf"], "--time -inf is out of range"),
        (&["render", "a.glb", "--size", "-1x4"], "`-1x4` is not a size"),
        (&["render", "a.glb", "--turntable", "-1"], "'-1' for '--turntable"),
        (&["render", "a.glb", "--background", "-1"], "`-1` is not a value of --background"),
        (&["render", "demo:hell"], "hall"),
        (&["render", ""], "the name of an input is empty"),
        (&["render", "a.glb", "--eye", "1e38,1e38,1e38"], "--eye 1e38,1e38,1e38 is out of range"),
        (&["render", "a.glb", "--target", "0,1e99,0"], "--target 0,1e99,0 is out of range"),
        (&["render", "a.glb", "--orbit", "0,0,0"], "RADIUS must be above 0"),
        (&["render", "a.glb", "--orbit", "0,0,-2"], "RADIUS must be above 0"),
        (&["render", "a.glb", "--orbit", "1e38,0,auto"], "out of range"),
        (&["render", "a.glb", "--set", "fx.strength=0.1"], "settings of effects need --effect NAME|FILE.wgsl"),
        (&["render", "a.glb", "--report", "r_{stem}.json"], "one file for the whole call"),
        (&["render", "a.glb", "--frames", "0..1", "--dump-passes", "d/"], "d/ is one place for all frames"),
        (&["bench", "a.glb", "--png", "x.jpg"], "does not end in .png"),
        (&["bench", "a.glb", "--png", "-"], "--png FILE.png"),
        (&["bench", "a.glb", "--count", "0"], "--count"),
        (&["bench", "a.glb", "--budget-ms", "0"], "--budget-ms"),
        (&["bench", "a.glb", "--first-frame", "--count", "3"], "--first-frame"),
        (&["graph", "a.glb", "--format", "dot"], "mermaid"),
    ];
    for (args, part) in wrong {
        let run = run_in(&folder, args);
        assert_eq!(run.code, 2, "{args:?}: {}", run.stderr);
        let lines: Vec<&str> = run.stderr.lines().collect();
        assert!(matches!(lines[..], [e, h] if e.starts_with("error: ") && h.starts_with("hint: ")), "{}", run.stderr);
        assert!(run.stderr.contains(part), "{args:?}: {}", run.stderr);
        assert!(!run.stderr.contains("-- -"), "{args:?}: {}", run.stderr);
        assert!(run.stdout.is_empty());
    }
    assert!(folder.names().is_empty());
}

#[test]
fn empty_and_endless_files_are_refused() {
    let folder = Folder::new("empty");
    folder.write("e.glb", b"");
    let run = run_in(&folder, &["info", "e.glb"]).expect(1);
    assert!(run.stderr.contains("e.glb: the file is empty"), "{}", run.stderr);
    let run = run_in(&folder, &["info", "-"]).expect(1);
    assert!(run.stderr.contains("standard input: it is empty"), "{}", run.stderr);
    #[cfg(unix)]
    for flag in ["--settings", "--effect"] {
        let run = run_in(&folder, &["render", "e.glb", flag, "/dev/zero"]).expect(1);
        assert!(run.stderr.contains("/dev/zero: it is not a regular file"), "{}", run.stderr);
    }
    let run = run_in(&folder, &["render", "e.glb", "--frames", "0..1", "--dump-passes", "d/"]).expect(2);
    assert!(run.stderr.ends_with("hint: write {frame:04} into the name\n"), "{}", run.stderr);
}

#[test]
fn without_arguments_there_is_help_and_2() {
    let folder = Folder::new("help");
    let run = run_in(&folder, &[]).expect(2);
    assert!(run.stderr.contains("Usage: manypass") && run.stderr.contains("render"), "{}", run.stderr);
    assert!(run_in(&folder, &["--help"]).expect(0).text().contains("Exit codes"));
    assert!(run_in(&folder, &["--version"]).expect(0).text().starts_with("manypass "));
    assert!(run_in(&folder, &["completions", "bash"]).expect(0).text().contains("manypass"));
}

#[cfg(unix)]
#[test]
fn words_that_are_no_text_are_names_of_files_and_nothing_else() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new("words");
    let odd = OsStr::from_bytes(b"\xff.glb");
    let render = OsStr::new("render");
    // A file of this name could be there; a command or a size could not.
    for (words, code) in [(vec![odd], 2), (vec![render, odd], 1), (vec![render, OsStr::new("--size"), odd], 2)] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_manypass"));
        let run: common::Run = command.args(&words).current_dir(&*folder).output().expect("run").into();
        assert!(run.code == code && run.stderr.starts_with("error: "), "{words:?}: {run:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_machine_without_a_driver_ends_with_3() {
    let folder = Folder::new("driver");
    for args in [&["adapters"][..], &["adapters", "--json"]] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_manypass"));
        command.env("VK_ICD_FILENAMES", "/nowhere").env("VK_DRIVER_FILES", "/nowhere");
        let run: common::Run = command.args(args).current_dir(&*folder).output().expect("run").into();
        assert!(run.code == 3 && run.stdout.is_empty() && run.stderr.contains("hint: install"), "{args:?}: {run:?}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let folder = Folder::new("missing");
    for command in [&["info", "nothing.glb"][..], &["graph", "nothing.glb"]] {
        let run = run_in(&folder, command).expect(1);
        assert!(run.stderr.starts_with("error: nothing.glb: cannot"), "{}", run.stderr);
    }
}

#[test]
fn info_counts_what_is_in_a_file() {
    let folder = Folder::new("info");
    folder.write("tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    let json = run_in(&folder, &["info", "tri.glb", "--json"]).expect(0).text();
    let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    for (key, expected) in [("meshes", 1), ("primitives", 1), ("triangles", 1), ("triangles_drawn", 1)] {
        assert_eq!(value[key], expected, "{key}");
    }
    assert_eq!(value["animations"][0]["name"], "Slide");
    assert_eq!(value["animations"][0]["duration_secs"], 1.0);
    assert_eq!(value["bounds_m"]["max"], serde_json::json!([1.0, 1.0, 0.0]));
    assert_eq!((&value["nodes"][0]["name"], &value["materials"][0]["name"]), (&"tri".into(), &"paint".into()));
    assert_eq!(value["extensions"], serde_json::json!([]));
    let used = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_materials_unlit","ACME_glow"]}"#;
    folder.write("used.gltf", used.as_bytes());
    let json = run_in(&folder, &["info", "used.gltf", "--json"]).expect(0).text();
    let used: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let expected = [("KHR_materials_unlit", true), ("ACME_glow", false)];
    let expected = expected.map(|(name, is_read)| serde_json::json!({ "name": name, "is_read": is_read }));
    assert_eq!(used["extensions"], serde_json::json!(expected));
    let text = run_in(&folder, &["info", "used.gltf"]).expect(0).text();
    assert!(text.contains("extensions: 2\n  KHR_materials_unlit\n  ACME_glow (not read"), "{text}");
    let text = run_in(&folder, &["info", "tri.glb"]).expect(0).text();
    assert!(text.contains("triangles: 1\n") && text.contains("max 1 1 0"), "{text}");
    let hall = run_in(&folder, &["info", "demo:hall", "--json"]).expect(0).text();
    let hall: serde_json::Value = serde_json::from_str(&hall).expect("JSON");
    assert!(hall["lights"]["point"].as_u64() > Some(500) && hall["lights"]["spot"].as_u64() > Some(50));
}
