//! What is said of chains of effects and of effects that are wrong: where, what was meant, and which exit code. No
//! adapter is there.

use crate::common::{self, Folder, Run, run_in, triangle_glb};

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    folder
}

/// The plan of a frame, with these words behind `graph`.
fn graph(folder: &Folder, words: &[&str]) -> Run {
    run_in(folder, &[&["graph"], words, &["--limits", "webgl2", "--size", "64x36"]].concat())
}

#[test]
fn a_word_too_many_in_reads_is_a_warning() {
    let folder = folder("needless");
    let main =
        "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return radiance_at(vec2i(p.xy)); }";
    folder.write("mine.wgsl", format!("//! reads: depth, radiance\n{main}").as_bytes());
    let expected = "mine.wgsl:1:5: the shader does not read depth; `//! reads: radiance` is right";
    let run = graph(&folder, &["tri.glb", "--effect", "mine.wgsl"]).expect(0);
    assert!(run.stderr.contains(&format!("warning: tri.glb: {expected}")), "{}", run.stderr);
    // A word that is missing stays an error.
    folder.write("other.wgsl", format!("//! reads: depth\n{main}").as_bytes());
    let run = graph(&folder, &["tri.glb", "--effect", "other.wgsl"]).expect(1);
    assert!(run.stderr.contains("other.wgsl:1:5: error: the shader also reads radiance"), "{}", run.stderr);
    if !common::has_adapter() {
        return;
    }
    let words = ["render", "tri.glb", "--size", "8x8", "--samples", "1", "--effect", "mine.wgsl", "-o", "a.png"];
    let run = run_in(&folder, &words).expect(0);
    assert!(run.stderr.contains(&format!("warning: --effect: {expected}")), "{}", run.stderr);
    let strict = run_in(&folder, &[&words[..8], &["--strict", "-o", "strict.png"]].concat()).expect(1);
    assert!(strict.stderr.contains(expected) && !folder.join("strict.png").exists(), "{}", strict.stderr);
}

#[test]
fn chains_are_refused_with_their_place_and_one_exit_code_for_one_mistake() {
    let folder = folder("chains");
    let stage = |name: &str, chain: &str| {
        folder.write(name, format!("model = \"tri.glb\"\n[effects]\nchain = {chain}\n").as_bytes());
    };
    let file = |name: &str, text: &str| folder.write(name, text.as_bytes());
    for (name, chain) in [("name", r#"["film", "blom"]"#), ("twice", r#"["film", "bloom", "bloom"]"#)] {
        stage(&format!("{name}.stage.toml"), chain);
        file(&format!("{name}.toml"), &format!("# A remark.\nchain = {chain}\n"));
    }
    stage("absent.stage.toml", r#"["fx/none.wgsl"]"#);
    file("absent.toml", "[effects]\nchain = [\"film\", 'fx/none.wgsl']\n");
    file("both.toml", "chain = [\"bloom\"]\n[effects]\nchain = [\"film\"]\n");
    file("both.stage.toml", "model = \"tri.glb\"\n[effects]\nchain = [\"bloom\"]\n[settings]\nchain = [\"film\"]\n");
    let nearest = "no effect is called `blom`; did you mean `bloom`?";
    let twice = "it stands twice in the chain";
    let both = "stands here and as `chain` as well; leave one of them out";
    let cases: &[(&[&str], i32, &str, &str)] = &[
        // Wrong usage, whichever flag it is said by.
        (&["tri.glb", "--effect", "blom"], 2, "error: ", nearest),
        (&["tri.glb", "--set", "chain=film,blom"], 2, "error: ", nearest),
        (&["tri.glb", "--set", "effects.chain=bloom,bloom"], 2, "error: ", twice),
        (&["tri.glb", "--set", "chain=bloom", "--set", "effects.chain=film"], 2, "error: ", "leave one of them out"),
        (&["tri.glb", "--settings", "name.toml"], 2, "name.toml:2:18: error: ", nearest),
        (&["tri.glb", "--settings", "twice.toml"], 2, "twice.toml:2:27: error: ", twice),
        (&["tri.glb", "--settings", "both.toml"], 2, "both.toml:3:9: error: ", both),
        // An input that is wrong.
        (&["name.stage.toml"], 1, "name.stage.toml:3:18: error: ", nearest),
        (&["twice.stage.toml"], 1, "twice.stage.toml:3:27: error: ", twice),
        (&["both.stage.toml"], 1, "both.stage.toml:3:9: error: ", both),
        // A file that cannot be read.
        (&["absent.stage.toml"], 1, "absent.stage.toml:3:10: error: ", "none.wgsl: "),
        (&["tri.glb", "--settings", "absent.toml"], 1, "absent.toml:2:18: error: ", "none.wgsl: "),
        (&["tri.glb", "--set", "chain=none.wgsl"], 1, "error: none.wgsl: ", "built-in effect"),
        (&["tri.glb", "--effect", "none.wgsl"], 1, "error: none.wgsl: ", "built-in effect"),
        // Shells take quotes away.
        (&["tri.glb", "--set", "chain=[bloom]"], 2, "error: ", "bloom,film or '[\"bloom\", \"film\"]'"),
        (&["tri.glb", "--set", "chain=[\"film\", \"blom\"]"], 2, "error: ", nearest),
    ];
    for (words, code, beginning, part) in cases {
        let run = graph(&folder, words).expect(*code);
        assert!(run.stderr.starts_with(beginning), "{words:?}\n{}\nshould begin {beginning}", run.stderr);
        assert!(run.stderr.contains(part), "{words:?}\n{}\nshould say {part}", run.stderr);
    }
}

#[test]
fn effects_that_do_not_go_together_are_wrong_usage() {
    let folder = folder("circles");
    let of = |name: &str, other: &str| {
        format!(
            "//! effect {name}\n//! reads: {other}.t\n//! passes: fs_t -> t, fs
            @fragment fn fs_t(@builtin(position) p: vec4f) -> @location(0) vec4f {{ return textureLoad({other}_t, vec2i(p.xy), 0); }}
            @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{ return textureLoad(t, vec2i(p.xy), 0); }}"
        )
    };
    folder.write("a.wgsl", of("a", "b").as_bytes());
    folder.write("b.wgsl", of("b", "a").as_bytes());
    folder.write("s.toml", b"chain = [\"a.wgsl\", \"b.wgsl\"]\n");
    for (words, place) in [
        (&["--effect", "a.wgsl", "--effect", "b.wgsl"][..], "error: the effect `a`"),
        (&["--set", "chain=a.wgsl,b.wgsl"], "error: the effect `a`"),
        (&["--settings", "s.toml"], "s.toml:1:9: error: the effect `a`"),
    ] {
        let run = graph(&folder, &[&["tri.glb"], words].concat()).expect(2);
        assert!(run.stderr.starts_with(place) && run.stderr.contains("a reads of b reads of a"), "{}", run.stderr);
    }
    // Off, it reads nothing.
    graph(&folder, &["tri.glb", "--settings", "s.toml", "--set", "a.enabled=false", "--set", "b.enabled=false"])
        .expect(0);
}

#[test]
fn every_path_has_every_tier() {
    let folder = folder("tiers-of-paths");
    for (path, has_occlusion) in [("forward", true), ("gouraud", false)] {
        for tier in ["low", "medium", "high", "ultra"] {
            let planned = graph(&folder, &["tri.glb", "--quality", tier, "--path", path]).expect(0).text();
            assert_eq!(planned.contains("occlusion"), has_occlusion && tier != "low", "{tier} {path}: {planned}");
        }
    }
    let run = graph(&folder, &["tri.glb", "--path", "gouraud", "--set", "reflections.enabled=true"]).expect(2);
    assert!(run.stderr.contains("`reflections.enabled=true` needs `render.path=deferred`"), "{}", run.stderr);
}

#[test]
fn faults_of_files_say_what_is_right() {
    let folder = folder("faults");
    let entry = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return vec4f(1.0); }\n";
    let cases = [
        (
            format!("@group(0) @binding(9) var mine: texture_2d<f32>;\n{}", entry.replace("vec4f(1.0)", "textureLoad(mine, vec2i(p.xy), 0)")),
            "e.wgsl:1:27: error: `mine` in group 0",
            "an effect's own textures are only look-up tables",
        ),
        (
            format!("@group(0) @binding(0) var<uniform> mine: f32;\n{}", entry.replace("1.0", "mine")),
            "e.wgsl:1:36: error: `mine` in group 0",
            "groups 0 and 1 are the frame's; write `@group(2) @binding(0) var<uniform> mine: …`",
        ),
        (
            format!("struct S {{\n    // = 1\n    on: bool,\n}}\n@group(2) @binding(0) var<uniform> mine: S;\n{}", entry.replace("1.0", "select(0.0, 1.0, mine.on)")),
            "e.wgsl:3:9: error: `on` is a `bool`",
            "write `on: u32` with `// = 1 in 0..1` above it",
        ),
        (
            entry.replace("@location(0) vec4f", "@location(0) vec3f").replace("vec4f(1.0)", "vec3f(1.0)"),
            "e.wgsl:1:14: error: `fs` has to return `@location(0) vec4f`",
            "coverage as alpha",
        ),
        (entry.replace("return vec4f", "return vec3f"), "e.wgsl:1:77: error: ", "of a `vec3f`, `vec4f(color, 1.0)`"),
        (
            "//! pixel: f\nfn dark(x: f32) {\n    if x < 0.1 { discard; }\n}\nfn f(color: vec4f, position: vec2f) -> vec4f {\n    dark(color.r);\n    return color;\n}\n".into(),
            "e.wgsl:3:18: error: `f` changes a pixel, and `discard`",
            "give back `color` as it is",
        ),
    ];
    for (text, beginning, part) in cases {
        folder.write("e.wgsl", text.as_bytes());
        let run = graph(&folder, &["tri.glb", "--effect", "e.wgsl"]).expect(1);
        assert!(run.stderr.starts_with(beginning), "{text}\n{}\nshould begin {beginning}", run.stderr);
        assert!(run.stderr.contains(part) && run.stderr.contains("^"), "{text}\n{}\nshould say {part}", run.stderr);
    }
}

#[test]
fn settings_print_what_comes_of_set() {
    let folder = folder("set-printed");
    let text = |words: &[&str]| run_in(&folder, &[&["settings"], words].concat()).expect(0).text();
    let set = [
        "--set",
        "render.scale=0.5",
        "--set",
        "tone_map.curve=agx",
        "--set",
        "chain=bloom,film",
        "--set",
        "render.scale=2",
    ];
    assert_eq!(text(&set), "tone_map.curve = \"agx\"\nchain = [\"bloom\",\"film\"]\nrender.scale = 2\n");
    let array = set.map(|word| if word.starts_with("chain") { "effects.chain=[\"bloom\", 'film']" } else { word });
    assert_eq!(text(&array), text(&set).replace("chain", "effects.chain"), "an array is the same list");
    let tier = text(&["--quality", "high"]);
    let both = text(&["--quality", "high", "--set", "reflections.enabled=false", "--set", "bloom.strength=0.5"]);
    assert!(
        tier.contains("reflections.enabled = \"auto\"") && !both.contains("reflections.enabled = \"auto\""),
        "{both}"
    );
    assert!(
        both.starts_with("# The tier `high`.\n")
            && both.ends_with("reflections.enabled = false\nbloom.strength = 0.5\n"),
        "{both}"
    );
    // As a file it is the same.
    folder.write("s.toml", both.as_bytes());
    let plan = |words: &[&str]| graph(&folder, &[&["tri.glb"], words].concat()).expect(0).text();
    let by_flags = plan(&["--quality", "high", "--set", "reflections.enabled=false"]);
    assert_eq!(plan(&["--settings", "s.toml"]), by_flags);
    for (words, part) in [
        (&["--set", "render.scael=1"][..], "did you mean `render.scale`?"),
        (&["--set", "render.scale=9"], "from 0.25 to 2"),
        (&["--set", "render.scale"], "has no `=`"),
        (&["--quality", "high", "--set", "msaa.samples=4"], "render.path=forward"),
        (&["--set", "render.scale=1", "--json"], "--json"),
    ] {
        let run = run_in(&folder, &[&["settings"], words].concat()).expect(2);
        assert!(run.stderr.contains(part), "{words:?}: {}", run.stderr);
    }
}

#[test]
fn what_shows_nothing_or_hides_something_is_warned_of() {
    if !common::has_adapter() {
        return;
    }
    let folder = folder("warned");
    folder.write(
        "own.wgsl",
        b"//! effect film\n//! pixel: f\nfn f(color: vec4f, position: vec2f) -> vec4f { return color.brga; }\n",
    );
    let render =
        |words: &[&str]| run_in(&folder, &[&["render", "tri.glb", "--size", "8x8", "--samples", "1"], words].concat());
    let warned = |run: &Run, part: &str| {
        run.stderr.lines().filter(|line| line.starts_with("warning: ") && line.contains(part)).count()
    };
    let motion = "the effect `motion_blur` finds no motion";
    assert_eq!(warned(&render(&["--effect", "motion_blur"]).expect(0), motion), 1);
    let turned = render(&["--effect", "motion_blur", "--turntable", "2", "-o", "{frame}.png"]).expect(0);
    assert_eq!(warned(&turned, motion), 0, "{}", turned.stderr);
    let off = render(&["--effect", "motion_blur", "--set", "motion_blur.enabled=false"]).expect(0);
    assert_eq!(warned(&off, motion), 0, "{}", off.stderr);
    let hidden = "own.wgsl is drawn in place of the built-in effect `film`";
    assert_eq!(warned(&render(&["--effect", "own.wgsl"]).expect(0), hidden), 1);
    assert_eq!(warned(&render(&["--effect", "film"]).expect(0), "in place of"), 0);
}

#[test]
fn a_report_counts_what_effects_leave_as_no_numbers() {
    if !common::has_adapter() {
        return;
    }
    let folder = folder("scrubbed");
    let text = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
        let here = radiance_at(vec2i(p.xy));
        return select(here, vec4f(sqrt(min(-1.0, -here.a)), 0.0, 0.0, 1.0), p.x < 2.0);
    }";
    folder.write("roots.wgsl", text.as_bytes());
    let words = ["render", "tri.glb", "--size", "8x8", "--samples", "1", "--effect", "roots.wgsl", "-o", "a.png"];
    let quiet = run_in(&folder, &words).expect(0);
    assert!(!quiet.stderr.contains("not finite"), "{}", quiet.stderr);
    let strict = run_in(&folder, &[&words[..8], &["--strict", "-o", "strict.png"]].concat()).expect(1);
    assert!(strict.stderr.contains("tri.glb: effects leave 16 pixels that are not finite"), "{}", strict.stderr);
    assert!(!folder.join("strict.png").exists());
    let told = run_in(&folder, &[&words[..], &["--report", "r.json"]].concat()).expect(0);
    assert!(told.stderr.contains("warning: tri.glb: effects leave 16 pixels that are not finite"), "{}", told.stderr);
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("r.json")).expect("a report")).expect("JSON");
    assert_eq!(report["scrubbed_pixels"], 16);
    assert!(report["warnings"].to_string().contains("not finite"), "{}", report["warnings"]);
    let none =
        run_in(&folder, &["render", "tri.glb", "--size", "8x8", "--samples", "1", "-o", "b.png", "--report", "s.json"]);
    none.expect(0);
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("s.json")).expect("a report")).expect("JSON");
    assert!(report["scrubbed_pixels"].is_null(), "{report}");
}
