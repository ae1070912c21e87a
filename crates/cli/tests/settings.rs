//! Settings of the frame and of effects: what `settings` lists, what `--set` and `--settings` take, and errors that
//! keep their places and lines.

use crate::common::{self, Folder, has_adapter, run_in, triangle_glb};

const LINES: &str = "//! effect lines
//! reads: radiance
struct Style {
    /// Colour of everything, linear
    // = 0.5, 0.25, 0 in 0..1
    color: vec3f,
    /// How much of the picture stays, share
    // = 0 in 0..1
    rest: f32,
}
@group(2) @binding(0) var<uniform> style: Style;

@fragment
fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(style.color + style.rest * radiance_at(vec2i(position.xy)).rgb, 1.0);
}
";

#[test]
fn settings_are_listed() {
    let folder = Folder::new("settings");
    folder.write("file.wgsl", LINES.as_bytes());
    let table = run_in(&folder, &["settings"]).expect(0).text();
    let line = table.lines().find(|line| line.starts_with("clusters.tile_px ")).unwrap_or_default();
    let words = line.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(table.starts_with("key ") && words.starts_with("clusters.tile_px u32 16 8 to 128 px"), "{table}");
    let text = run_in(&folder, &["settings", "--json", "--effect", "file.wgsl"]).expect(0).text();
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let entries = json.as_array().expect("an array");
    let keys = ["choices", "default", "doc", "key", "max", "min", "needs", "type", "unit"];
    for entry in entries {
        let mut found: Vec<&str> = entry.as_object().expect("an object").keys().map(String::as_str).collect();
        found.sort_unstable();
        assert_eq!(found, keys);
    }
    let color = entries.iter().find(|entry| entry["key"] == "lines.color").expect("the effect's");
    assert_eq!(color["default"], serde_json::json!([0.5, 0.25, 0.0]));
    assert!(color["type"] == "vec3f" && color["unit"] == "linear" && color["max"] == 1.0, "{color}");
    let scale = entries.iter().find(|entry| entry["key"] == "render.scale").expect("the frame's");
    assert!(
        scale["min"] == 0.25
            && scale["max"] == 2.0
            && scale["type"] == "f32"
            && scale["choices"] == serde_json::json!([])
    );
    let slices = entries.iter().find(|entry| entry["key"] == "clusters.slices").expect("of the lists");
    assert_eq!(
        (&slices["needs"], &scale["needs"]),
        (&serde_json::json!(["lights.culling=clustered"]), &serde_json::json!([]))
    );
    let curve = entries.iter().find(|entry| entry["key"] == "tone_map.curve").expect("the curve's");
    assert!(curve["type"] == "choice" && curve["default"] == "neutral" && curve["choices"][1] == "aces", "{curve}");
    let text = run_in(&folder, &["settings", "--schema", "--effect", "file.wgsl"]).expect(0).text();
    let schema: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(schema["properties"]["clusters"]["properties"]["slices"]["maximum"], 64);
    assert_eq!(schema["properties"]["lines"]["properties"]["color"]["maxItems"], 3);
    run_in(&folder, &["settings", "--schema", "--json"]).expect(2);
    let help = run_in(&folder, &["render", "--help"]).expect(0).text();
    assert!(help.contains("`manypass settings` lists the keys"), "{help}");
}

#[test]
fn errors_begin_with_file_line_and_column_and_keep_their_lines() {
    let folder = Folder::new("places");
    folder.write("lines.wgsl", LINES.as_bytes());
    folder.write("cut.wgsl", &LINES.as_bytes()[..LINES.len() - 24]);
    folder.write("wrong.wgsl", LINES.replace("radiance_at", "radianc_at").as_bytes());
    folder.write("bare.wgsl", LINES.replace("    // = 0 in 0..1\n", "").as_bytes());
    folder.write("header.wgsl", format!("//! colour: red\n{LINES}").as_bytes());
    folder.write("key.toml", b"[lines]\nrest = 0.5\n\n[clusters]\nslises = 4\n");
    folder.write("value.toml", b"[lines]\ncolor = [0.5, 2, 0]\n");
    folder.write("syntax.toml", b"[lines]\nrest = = 1\n");
    let cases: &[(&[&str], i32, &str, &str)] = &[
        (&["--effect", "cut.wgsl"], 1, "cut.wgsl:15:", "^ the file ends here"),
        (&["--effect", "wrong.wgsl"], 1, "wrong.wgsl:15:45: error: no definition", "^^^^^^^^^^ unknown identifier"),
        (
            &["--effect", "header.wgsl"],
            1,
            "header.wgsl:1:5: error: `colour: red` begins with no word",
            "effect, reads, passes, pixel",
        ),
        (&["--effect", "bare.wgsl"], 2, "bare.wgsl:8:5: error: `rest` has neither", "hint: add --set lines.rest=N"),
        (
            &["--effect", "lines.wgsl", "--settings", "key.toml"],
            2,
            "key.toml:5:1: error: no setting",
            "clusters.slices",
        ),
        (
            &["--effect", "lines.wgsl", "--settings", "value.toml"],
            2,
            "value.toml:2:9: error: `[0.5,2,0]`",
            "each from 0 to 1",
        ),
        // Without the effect its table is unknown.
        (
            &["--settings", "value.toml"],
            2,
            "value.toml:2:1: error: no setting is called `lines.color`\n",
            "need --effect NAME|FILE.wgsl",
        ),
        (&["--set", "lines.x=1"], 2, "error: no setting is called `lines.x`\n", "need --effect NAME|FILE.wgsl"),
        (&["--settings", "syntax.toml"], 2, "syntax.toml:2:8: error: ", "2 | rest = = 1\n  |        ^"),
        (
            &["--effect", "lines.wgsl", "--set", "lines.rest=2"],
            2,
            "error: `2` is not a value of `lines.rest`",
            "from 0 to 1",
        ),
        (&["--effect", "lines.wgsl", "--set", "lines.rset=1"], 2, "error: no setting", "did you mean `lines.rest`?"),
        (
            &["--effect", "lines.wgsl", "--effect", "lines.wgsl"],
            2,
            "error: the effect `lines.wgsl` is there twice",
            "//! effect NAME",
        ),
        (&["--settings", "absent.toml"], 1, "error: absent.toml: ", "hint: "),
    ];
    for (flags, code, beginning, part) in cases {
        let run = run_in(&folder, &[&["render", "a.glb"], *flags].concat()).expect(*code);
        assert!(run.stderr.starts_with(beginning), "{flags:?}\n{}\nshould begin {beginning}", run.stderr);
        assert!(run.stderr.contains(part), "{flags:?}\n{}\nshould say {part}", run.stderr);
        let hints = run.stderr.lines().filter(|line| line.starts_with("hint: ")).count();
        assert!(
            hints == 1 && run.stderr.lines().last().is_some_and(|line| line.starts_with("hint: ")),
            "{}",
            run.stderr
        );
    }
}

/// The passes of `graph` for what every adapter of WebGL 2 offers; no adapter is there.
fn passes(folder: &Folder, flags: &[&str]) -> Vec<String> {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(["graph", "tri.glb", "--limits", "webgl2", "--format", "json", "--size", "64x36"]).args(flags);
    command.current_dir(&**folder).env("VK_DRIVER_FILES", "/nowhere.json").env("VK_ICD_FILENAMES", "/nowhere.json");
    let run = common::Run::from(command.output().expect("the program starts")).expect(0);
    let json: serde_json::Value = serde_json::from_str(&run.text()).expect("JSON");
    let passes = json["plan"]["passes"].as_array().expect("passes");
    passes.iter().filter_map(|pass| pass["name"].as_str()).map(str::to_owned).collect()
}

#[test]
fn a_value_comes_from_the_file_then_the_flags_then_set_and_graph_takes_them_without_an_adapter() {
    let folder = Folder::new("precedence");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    folder.write("lines.wgsl", LINES.as_bytes());
    folder.write("forward.toml", b"[render]\npath = \"forward\"\n");
    let has = |flags: &[&str], name: &str| passes(&folder, flags).iter().any(|pass| pass == name);
    let file = ["--settings", "forward.toml"];
    assert!(has(&[], "geometry") && !has(&[], "forward.opaque"));
    assert!(has(&file, "forward.opaque"));
    let flag = [&file[..], &["--path", "deferred"]].concat();
    assert!(has(&flag, "geometry") && !has(&flag, "forward.opaque"));
    assert!(has(&[&["--set", "render.path=forward"], &flag[..]].concat(), "forward.opaque"));
    // What else changes the frame.
    assert!(has(&["--effect", "lines.wgsl"], "lines") && has(&["--aov", "object_id"], "aov/ids"));
    assert!(!has(&["--background", "ff0000"], "background") && has(&[], "background"));
    for (flags, code, part) in [
        (&["--settings", "forward.toml", "--aov", "depth"][..], 2, "only --path deferred"),
        (&["--limits", "webgl2", "--size", "4096x16"], 1, "each side must be 1 to 2048"),
        (&["--limits", "webgl2", "--adapter", "x"], 2, "--adapter"),
        (&["--limits", "webgl1"], 2, "webgl2"),
    ] {
        let run = run_in(&folder, &[&["graph", "tri.glb"], flags].concat()).expect(code);
        assert!(run.stderr.contains(part), "{flags:?}: {}", run.stderr);
    }
}

#[test]
fn bench_takes_effects_and_settings() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("bench-settings");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    folder.write("lines.wgsl", LINES.as_bytes());
    let fixed =
        ["bench", "tri.glb", "--size", "8x8", "--count", "1", "--json", "--png", "b.png", "--light-culling", "none"];
    let flags =
        ["--path", "deferred", "--effect", "lines.wgsl", "--set", "render.path=forward", "--set", "lines.color=0,0,1"];
    let text = run_in(&folder, &[&fixed[..], &flags].concat()).expect(0).text();
    let info = serde_json::from_str::<serde_json::Value>(&text).expect("JSON")["info"].clone();
    assert!(info["path"] == "forward" && info["light_culling"] == "none", "{info}");
    assert_eq!(info["settings"]["tone_map"], serde_json::json!({ "curve": "none", "dither": 0.0 }));
    assert!(
        info["passes"].as_array().is_some_and(|passes| passes.iter().any(|pass| pass["name"] == "lines")),
        "{info}"
    );
    let effect = &info["effects"][0];
    assert!(effect["name"] == "lines" && effect["path"] == "lines.wgsl", "{info}");
    assert_eq!(effect["settings"]["lines.color"], serde_json::json!([0.0, 0.0, 1.0]));
    let blue = image::open(folder.join("b.png")).expect("a picture").to_rgb8().get_pixel(4, 4).0;
    assert_eq!(blue, [0, 0, 255]);
    let run = run_in(&folder, &["bench", "tri.glb", "--effect", "lines.wgsl", "--png", "lines.wgsl"]).expect(2);
    assert!(run.stderr.contains(".png") || run.stderr.contains("the effect"), "{}", run.stderr);
}

#[test]
fn uniforms_of_effects_are_set_on_the_command_line_and_in_files() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("uniforms");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    folder.write("lines.wgsl", LINES.as_bytes());
    folder.write("set.toml", b"lines.color = [0, 0, 1]\n[tone_map]\ndither = 0\n");
    let drawn = |flags: &[&str]| {
        let mut args = vec!["render", "tri.glb", "--size", "8x8", "--samples", "1", "-o", "a.png", "--tonemap", "none"];
        args.extend(["--effect", "lines.wgsl", "--set", "tone_map.dither=0"]);
        args.extend(flags);
        run_in(&folder, &args).expect(0);
        image::open(folder.join("a.png")).expect("a picture").to_rgb8().get_pixel(4, 4).0
    };
    // 0.5 and 0.25 of full light are 188 and 137 in sRGB.
    assert_eq!(drawn(&[]), [188, 137, 0]);
    assert_eq!(drawn(&["--set", "lines.color=0,0.25,0.5"]), [0, 137, 188]);
    assert_eq!(drawn(&["--settings", "set.toml"]), [0, 0, 255]);
    // What stands on the command line comes after the file; the whole path is a key, too.
    assert_eq!(drawn(&["--settings", "set.toml", "--set", "lines.style.color=1,0,0"]), [255, 0, 0]);
}

#[test]
fn an_effect_that_hides_settings_of_the_frame_is_warned_of() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("hidden");
    folder.write("model.glb", &triangle_glb([1.0; 3]));
    folder.write("file.wgsl", LINES.replace("effect lines", "effect tone_map").as_bytes());
    let flags = ["render", "model.glb", "--size", "8x8", "--samples", "1", "--effect", "file.wgsl"];
    let run = run_in(&folder, &flags).expect(0);
    assert!(run.stderr.contains("hides `tone_map.*`"), "{}", run.stderr);
    let strict = run_in(&folder, &[flags.as_slice(), &["--strict"]].concat());
    assert!(strict.expect(1).stderr.contains("hides `tone_map.*`"));
}

#[test]
fn graph_says_what_the_limits_leave_out() {
    let folder = Folder::new("limits");
    let floats: [f32; 9] = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    folder.write("tri.bin", &floats.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>());
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0,"targets":[{"POSITION":0}]}],"weights":[0]}],
        "materials":[{"extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":1}}}],
        "extensionsUsed":["KHR_materials_clearcoat"],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"tri.bin","byteLength":36}]}"#;
    folder.write("tri.gltf", json.as_bytes());
    for (limits, has_layers) in [("webgpu", true), ("webgl2", false)] {
        let run = run_in(&folder, &["graph", "tri.gltf", "--limits", limits]).expect(0);
        let warning = "warning: tri.gltf: this adapter has too few textures for materials with layers";
        assert_eq!(run.stderr.starts_with(warning), !has_layers, "{limits}: {}", run.stderr);
        assert_eq!(run.text().lines().any(|line| line.trim_start().starts_with("layered ")), has_layers, "{limits}");
    }
}

#[test]
fn tiers_are_printed_as_files_of_settings_and_come_before_all_others() {
    let folder = Folder::new("tiers");
    for tier in ["low", "medium", "high", "ultra"] {
        let table = run_in(&folder, &["settings", "--quality", tier]).expect(0).text();
        folder.write("tier.toml", table.as_bytes());
        let plan = |args: &[&str]| run_in(&folder, &[&["graph", "demo:materials"], args].concat()).expect(0).text();
        let by_file = plan(&["--settings", "tier.toml"]);
        assert_eq!(plan(&["--quality", tier]), by_file, "{tier}");
        let wants_more = tier != "low";
        assert_eq!(
            (by_file.contains("occlusion"), by_file.contains("reflections")),
            (wants_more, wants_more),
            "{tier}"
        );
    }
    let plan = run_in(&folder, &["graph", "demo:materials", "--quality", "high", "--set", "occlusion.enabled=false"]);
    assert!(!plan.expect(0).text().contains("occlusion"));
    run_in(&folder, &["settings", "--quality", "best"]).expect(2);
}
