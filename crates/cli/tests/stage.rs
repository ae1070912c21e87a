//! Stages as inputs: what they change, what they stand for, what is wrong with them, and what is kept from being
//! overwritten.

use crate::common::{Folder, Run, has_adapter, run_in, run_with_input, triangle_glb};

/// A light before the triangle, and settings.
const LIT: &str = "model = \"m.glb\"\n[environment]\ncolor = \"000000\"\n[settings.exposure]\nstops = 0\n\
    [settings.tone_map]\ncurve = \"none\"\n[[lights]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = 12\n";

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("m.glb", &triangle_glb([1.0, 1.0, 1.0]));
    folder.write("lit.stage.toml", LIT.as_bytes());
    folder
}

/// The colour in the middle of a picture.
fn middle(folder: &Folder, name: &str) -> [u8; 3] {
    let picture = image::open(folder.join(name)).expect("a picture").to_rgb8();
    picture.get_pixel(picture.width() / 2, picture.height() / 2).0
}

fn json(run: &Run) -> serde_json::Value {
    serde_json::from_slice(&run.stdout).expect("JSON")
}

const CAMERA: [&str; 8] = ["--size", "32x32", "--samples", "1", "--orbit", "0,0,4", "--target", "0,0,0"];

#[test]
fn a_stage_lights_its_model_and_flags_come_after_its_settings() {
    if !has_adapter() {
        return;
    }
    let folder = folder("stage");
    folder.write("in/far.stage.toml", LIT.replace("m.glb", "../m.glb").as_bytes());
    folder.write("night.toml", b"[environment]\nsource = \"00ff00\"\n");
    let render = |stage: &str, out: &str, more: &[&str]| {
        run_in(&folder, &[&["render", stage, "-o", out, "--quiet"], &CAMERA[..], more].concat()).expect(0);
        middle(&folder, out)
    };
    let report = ["--report", "lit.json"];
    // A white Lambertian surface, 12 cd 2 m before it: 3 lux / pi of radiance, beside a little of the highlight.
    let lit = render("lit.stage.toml", "lit.png", &report);
    assert!(lit[0] > 240 && lit[0] == lit[1] && lit[1] == lit[2], "{lit:?}");
    let text = std::fs::read_to_string(folder.join("lit.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let paths: Vec<&str> =
        report["input_files"].as_array().expect("files").iter().filter_map(|f| f["path"].as_str()).collect();
    assert_eq!(paths, ["lit.stage.toml", "m.glb"]);
    assert_eq!((&report["settings"]["tone_map"]["curve"], &report["lights"]), (&"none".into(), &1.into()));
    assert_eq!(render("in/far.stage.toml", "far.png", &[]), lit);
    // A stage's environment gives way to a file of settings, that to a flag, that to `--set`.
    let dark = ["--set", "lights.culling=clustered"];
    assert_eq!(render("lit.stage.toml", "same.png", &dark), lit);
    let green = render("lit.stage.toml", "green.png", &["--settings", "night.toml"]);
    assert!(green[1] > lit[1] || green[1] == 255, "{green:?}");
    folder.write("dim.stage.toml", LIT.replace("intensity = 12", "intensity = 0.1").as_bytes());
    let dim = render("dim.stage.toml", "dim.png", &[]);
    let green = render("dim.stage.toml", "green.png", &["--settings", "night.toml"]);
    assert!(dim[1] < 60 && green[1] > 200 && green[0] < 60, "{dim:?} {green:?}");
    let flags = ["--settings", "night.toml", "--environment", "ff0000"];
    let red = render("dim.stage.toml", "red.png", &flags);
    assert!(red[0] > 200 && red[1] < 60, "{red:?}");
    let blue = render("dim.stage.toml", "blue.png", &[&flags[..], &["--set", "environment.source=0000ff"]].concat());
    assert!(blue[2] > 200 && blue[0] < 60, "{blue:?}");
}

#[test]
fn a_stage_stands_for_its_model_in_a_folder_and_nothing_it_reads_is_replaced() {
    if !has_adapter() {
        return;
    }
    let folder = folder("stages");
    folder.write("models/a b.glb", &triangle_glb([1.0, 0.0, 0.0]));
    folder.write("models/other.glb", &triangle_glb([0.0, 1.0, 0.0]));
    folder.write("models/day (1).stage.toml", b"model = \"a b.glb\"\n");
    folder.write("models/night.stage.toml", LIT.replace("m.glb", "./a b.glb").as_bytes());
    let run = run_in(&folder, &[&["render", "models", "-o", "shots/{stem}.png", "--quiet"], &CAMERA[..]].concat());
    run.expect(0);
    let mut names: Vec<_> = std::fs::read_dir(folder.join("shots"))
        .expect("listed")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["day (1).png", "night.png", "other.png"]);
    // Settings of one stage are none of the next input's.
    assert_ne!(middle(&folder, "shots/night.png"), middle(&folder, "shots/day (1).png"));
    // Without the stage's name the model is drawn by itself; with both there are two pictures.
    let run = run_in(&folder, &[&["render", "models/*.glb", "-o", "own/{stem}.png", "--quiet"], &CAMERA[..]].concat());
    run.expect(0);
    assert!(folder.join("own/a b.png").is_file() && folder.join("own/other.png").is_file());
    folder.write("m.stage.toml", LIT.as_bytes());
    let both = ["render", "m.glb", "m.stage.toml", "-o", "both/{stem}.png", "--quiet"];
    run_in(&folder, &[&both, &CAMERA[..]].concat()).expect(0);
    assert!(folder.join("both/m.glb.png").is_file() && folder.join("both/m.stage.toml.png").is_file());
    // A broken stage is one input that fails, and the rest is done.
    folder.write("models/night.stage.toml", b"model = \"a b.glb\"\nx = 1\n");
    let run = run_in(&folder, &[&["render", "models", "-o", "some/{stem}.png"], &CAMERA[..]].concat()).expect(1);
    assert!(run.stderr.contains("night.stage.toml:2:1: error: no key of a stage is called `x`"), "{}", run.stderr);
    assert!(folder.join("some/day (1).png").is_file() && folder.join("some/other.png").is_file());
    assert!(!folder.join("some/a b.png").exists());
    for (read, what) in [("a b.glb", "the model"), ("day (1).stage.toml", "the stage")] {
        let call = ["render", "models/day (1).stage.toml", "--report", &format!("models/{read}")];
        let run = run_in(&folder, &call).expect(2);
        assert!(run.stderr.contains(&format!("would replace {what} ")), "{}", run.stderr);
    }
}

#[test]
fn stages_are_described_planned_and_measured() {
    if !has_adapter() {
        return;
    }
    let folder = folder("described");
    let fog = format!("{LIT}[fog]\nmode = \"linear\"\n");
    folder.write("fog.stage.toml", fog.as_bytes());
    let info = json(&run_in(&folder, &["info", "lit.stage.toml", "--json"]).expect(0));
    assert_eq!((&info["lights"]["point"], &info["input"]), (&1.into(), &"lit.stage.toml".into()));
    let plan = |stage: &str, more: &[&str]| {
        run_in(&folder, &[&["graph", stage, "--limits", "webgl2"], more].concat()).expect(0).text()
    };
    let has_fog = |plan: String| plan.lines().any(|line| line.contains(" fog"));
    assert!(has_fog(plan("fog.stage.toml", &[])) && !has_fog(plan("lit.stage.toml", &[])));
    assert!(!has_fog(plan("fog.stage.toml", &["--set", "fog.mode=none"])));
    let bench = ["bench", "fog.stage.toml", "--size", "16x16", "--count", "1", "--json"];
    let info = json(&run_in(&folder, &bench).expect(0))["info"].clone();
    assert_eq!((&info["settings"]["fog"]["mode"], &info["lights"]), (&"linear".into(), &1.into()));
    // What the stage does not say is as bare as always.
    assert_eq!(info["settings"]["tone_map"]["dither"], 0.0);
    let schema = json(&run_in(&folder, &["settings", "--stage-schema"]).expect(0));
    assert_eq!(schema["required"], serde_json::json!(["model"]));
}

/// Files, and what the error begins with and contains.
const BROKEN: &[(&str, &str, &str, &str)] = &[
    ("gone.stage.toml", "model = \"gone.glb\"\n", "gone.stage.toml:1:9: error: cannot read the model gone.glb", ""),
    (
        "self.stage.toml",
        "model = \"self.stage.toml\"\n",
        "self.stage.toml:1:9: error: the model `self.stage.toml` is a stage",
        "",
    ),
    (
        "cycle.stage.toml",
        "model = \"lit.stage.toml\"\n",
        "cycle.stage.toml:1:9: error: the model `lit.stage.toml` is a stage",
        "",
    ),
    ("demo.stage.toml", "model = \"demo:x\"\n", "demo.stage.toml:1:9: error: there is no `demo:x`", "demo:hall"),
    ("text.stage.toml", "model = \"text.txt\"\n", "error: text.txt: not a glTF file", ""),
    ("folder.stage.toml", "model = \".\"\n", "error: ", "is not a regular file"),
    ("toml.stage.toml", "model = \"m.glb\n", "toml.stage.toml:1:", ""),
    ("empty.stage.toml", "", "empty.stage.toml:1:1: error: `model` is missing", ""),
    (
        "light.stage.toml",
        "model = \"m.glb\"\n[[lights]]\nintensty = 1\n",
        "light.stage.toml:3:1: error: no key of lights is called `intensty`; did you mean `intensity`?",
        "3 | intensty = 1\n  | ^^^^^^^^",
    ),
    (
        "set.stage.toml",
        "model = \"m.glb\"\n[settings.render]\nscale = 9\n",
        "set.stage.toml:3:9: error: `9` is not a value of `render.scale`",
        "from 0.25 to 2",
    ),
    ("latin.stage.toml", "", "error: latin.stage.toml: it is not UTF-8 text", ""),
    ("stage.toml", "model = \"m.glb\"\n", "error: stage.toml: it is neither a model nor a stage", "NAME.stage.toml"),
];

#[test]
fn broken_stages_are_refused_with_their_place() {
    let folder = folder("broken-stages");
    folder.write("text.txt", b"no model");
    for (name, text, start, part) in BROKEN {
        folder.write(name, text.as_bytes());
        if *name == "latin.stage.toml" {
            folder.write(name, b"model = \"\xe9.glb\"\n");
        }
        let run = run_in(&folder, &["info", name]);
        let is_told = run.stderr.starts_with(start) && run.stderr.contains(part) && run.stderr.contains("\nhint: ");
        // Settings are read by whoever draws.
        if *name == "set.stage.toml" {
            assert_eq!(run.code, 0, "{}", run.stderr);
            continue;
        }
        assert!(run.code == 1 && is_told, "{name}: {}\n{}", run.code, run.stderr);
    }
    if has_adapter() {
        let (_, _, start, part) = BROKEN.iter().find(|broken| broken.0 == "set.stage.toml").expect("listed");
        let run = run_in(&folder, &["graph", "set.stage.toml", "--limits", "webgpu"]).expect(1);
        assert!(run.stderr.starts_with(start) && run.stderr.contains(part), "{}", run.stderr);
        // What would be written is looked for in what is read, which here has no end.
        folder.write("other.stage.toml", b"model = \"another.stage.toml\"\n");
        folder.write("another.stage.toml", b"model = \"other.stage.toml\"\n");
        for name in ["self", "other"] {
            let run = run_in(&folder, &["render", &format!("{name}.stage.toml")]).expect(1);
            assert!(run.stderr.contains(".stage.toml` is a stage"), "{}", run.stderr);
        }
    }
    let run = run_in(&folder, &["info", "none.stage.toml"]).expect(1);
    assert!(run.stderr.contains("none.stage.toml: No such file"), "{}", run.stderr);
    run_with_input(&folder, &["info", "-"], LIT.as_bytes()).expect(1);
}
