//! Hostile inputs: effects that compilers cannot bear, pipes and devices in place of files, names that hold commands to
//! terminals, and outputs that are devices. Each ends soon, with one clear error, and leaves nothing behind.

mod common;

use common::watch::{WatchedRun, watch};
use common::{Folder, has_adapter, run_in};
use std::fmt::Write as _;
use std::time::Duration;

/// The longest that any of these may take, with room for a machine that does other things.
const LIMIT: Duration = Duration::from_secs(20);
/// The most time of processors after which an error is there.
const CPU_LIMIT: Duration = Duration::from_secs(5);
/// The most memory that any of these may take.
const LIMIT_MIB: u64 = 300;

/// A model of one triangle.
fn model(extra: serde_json::Value) -> String {
    let position = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let mut model = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }], "buffers": [{ "byteLength": 36, "uri": position }],
    });
    for (key, value) in extra.as_object().into_iter().flatten() {
        model[key] = value.clone();
    }
    model.to_string()
}

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("m.gltf", model(serde_json::json!({})).as_bytes());
    folder
}

/// Runs a command that has to fail soon, in little memory, with words that say what is wrong.
#[track_caller]
fn refused(folder: &Folder, args: &[&str], said: &str) {
    let WatchedRun { run, peak_mib, time, cpu } = watch(folder, args, LIMIT);
    assert!([1, 2].contains(&run.code), "{args:?}: {} {}", run.code, run.stderr);
    assert!(run.stderr.contains(said), "{args:?}: {}\nshould say {said}", run.stderr);
    assert!(peak_mib < LIMIT_MIB && cpu < CPU_LIMIT, "{args:?}: {peak_mib} MiB, {cpu:?} of processors in {time:?}");
}

#[test]
fn effects_that_compilers_cannot_bear_are_refused_at_their_place() {
    let folder = folder("large-effects");
    let mut doubling = String::from("//! pixel: f\nfn g0(a: f32) -> f32 { return a * 2.0; }\n");
    for i in 1..40 {
        let before = i - 1;
        writeln!(doubling, "fn g{i}(a: f32) -> f32 {{ return g{before}(a) + g{before}(a); }}").expect("written");
    }
    doubling.push_str("fn f(color: vec4f, position: vec2f) -> vec4f { return color * g39(1.0); }\n");
    let cases: String = (0..20_000).map(|i| format!("case {i}: {{ return color * {i}.5; }}\n")).collect();
    let body = |text: &str| format!("//! pixel: f\nfn f(color: vec4f, position: vec2f) -> vec4f {{\n{text}\n}}\n");
    let array =
        |count: &str| body(&format!("var a: array<f32, {count}>; a[u32(position.x)] = 1.0; return vec4f(a[5]);"));
    let private = "//! pixel: f\nvar<private> a: array<vec4f, 4000000>;\nfn f(color: vec4f, position: vec2f) -> vec4f {\n\
                   a[u32(position.x)] = color; return a[5]; }\n";
    let value = body("let a = array<vec4f, 1000000>(); return a[u32(position.x)];");
    let switch = body(&format!("switch u32(position.x) {{\n{cases}default: {{ return color; }}\n}}"));
    for (text, said) in [
        (doubling.as_str(), "error: `g12` has more than 50000 expressions"),
        (&switch, "x.wgsl:3:1: error: a `switch` has at most 1000 cases"),
        (&array("1000000"), "x.wgsl:3:1: error: `a` makes the variables of this shader larger than 16 KiB"),
        (&array("100000000"), "x.wgsl:3:1: error: `a` makes the variables of this shader larger than 16 KiB"),
        (private, "x.wgsl:2:"),
        (&value, "makes the variables of this shader larger than 16 KiB"),
    ] {
        folder.write("x.wgsl", text.as_bytes());
        refused(&folder, &["settings", "--effect", "x.wgsl"], said);
        refused(&folder, &["render", "m.gltf", "--effect", "x.wgsl"], said);
    }
    folder.write("x.wgsl", array("1000").as_bytes());
    run_in(&folder, &["settings", "--effect", "x.wgsl"]).expect(0);
    folder.write("x.wgsl", doubling.replace("g39(1.0)", "g5(1.0)").split("fn g6").next().expect("a text").as_bytes());
    refused(&folder, &["settings", "--effect", "x.wgsl"], "there is no function `f`");
}

#[test]
fn decals_are_counted_before_they_are_made() {
    let folder = folder("many-decals");
    let text = format!("model = \"m.gltf\"\n[[decals]]\ncount = 4096\npositions = [{}]\n", "[0,0,0],".repeat(24_000));
    folder.write("a.stage.toml", text.as_bytes());
    refused(&folder, &["info", "a.stage.toml"], "there are more decals than 4096: 98304000 of this entry");
}

#[test]
fn simulations_have_limits_of_rates_and_work() {
    let folder = folder("much-simulation");
    let stage = |entry: &str| format!("model = \"m.gltf\"\n{entry}\n");
    folder.write("a.stage.toml", stage("[[particles]]\npreset = \"smoke\"\ncount = 10\nrate_hz = 1000000").as_bytes());
    refused(&folder, &["info", "a.stage.toml"], "a.stage.toml:5:11: error: ");
    if !has_adapter() {
        return;
    }
    folder.write("b.stage.toml", stage("[[particles]]\npreset = \"smoke\"\ncount = 1048576").as_bytes());
    let bare = ["--size", "16x16", "--samples", "1", "--time"];
    refused(&folder, &[&["render", "b.stage.toml"], &bare[..], &["1000"]].concat(), "cells, and 68719476736 at most");
    refused(&folder, &[&["render", "b.stage.toml"], &bare[..], &["10000"]].concat(), "and 108000 are made at most");
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_in_place_of_files_are_refused() {
    use std::os::unix::fs::symlink;
    let folder = folder("pipes");
    for name in ["p.wgsl", "p.cube", "p.gltf", "p.glb", "p.obj", "p.png", "p.toml", "p.stage.toml", "p.hdr", "p.bin"] {
        let made = std::process::Command::new("mkfifo").arg(folder.join(name)).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo");
    }
    std::fs::create_dir(folder.join("cube")).expect("a folder");
    for name in ["px", "nx", "py", "ny", "pz", "nz"] {
        symlink("../p.hdr", folder.join(&format!("cube/{name}.hdr"))).expect("linked");
    }
    folder.write("a.stage.toml", b"model = \"m.gltf\"\n[effects]\nchain = [\"p.wgsl\"]\n");
    folder.write("b.stage.toml", b"model = \"m.gltf\"\n[environment]\nfile = \"/dev/zero\"\n");
    folder.write("c.stage.toml", b"model = \"p.glb\"\n");
    folder.write(
        "d.stage.toml",
        b"model = \"m.gltf\"\n[[simulations]]\nname = \"a\"\nprogram = \"p.wgsl\"\nmaterial = \"*\"\n",
    );
    let no_file = "not a regular file";
    for args in [
        &["render", "p.gltf"][..],
        &["render", "p.obj"],
        &["info", "p.glb"],
        &["render", "p.stage.toml"],
        &["render", "a.stage.toml"],
        &["render", "b.stage.toml"],
        &["render", "c.stage.toml"],
        &["render", "d.stage.toml"],
        &["render", "m.gltf", "--effect", "p.wgsl"],
        &["render", "m.gltf", "--effect", "p.cube"],
        &["render", "m.gltf", "--settings", "p.toml"],
        &["render", "m.gltf", "--environment", "p.hdr"],
        &["render", "m.gltf", "--environment", "cube"],
        &["diff", "p.png", "p.png"],
        &["diff", "/dev/zero", "p.png"],
    ] {
        refused(&folder, args, no_file);
    }
    folder.write(
        "buffer.gltf",
        model(serde_json::json!({ "buffers": [{ "byteLength": 36, "uri": "p.bin" }] })).as_bytes(),
    );
    refused(&folder, &["render", "buffer.gltf"], no_file);
}

#[cfg(unix)]
#[test]
fn an_effect_that_is_a_link_shows_no_line_of_another_file() {
    let folder = folder("linked-effect");
    folder.write("secret", b"the password is swordfish\n");
    std::os::unix::fs::symlink("secret", folder.join("a.wgsl")).expect("linked");
    let run = run_in(&folder, &["settings", "--effect", "a.wgsl"]).expect(1);
    assert!(run.stderr.contains("it is a link to a file that does not end in .wgsl"), "{}", run.stderr);
    assert!(!run.stderr.contains("swordfish"), "{}", run.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn process_substitution_is_read() {
    use std::process::{Command, Stdio};
    let folder = folder("substitution");
    folder.write("e.wgsl", b"//! pixel: f\nfn f(color: vec4f, position: vec2f) -> vec4f { return color; }\n");
    let program = env!("CARGO_BIN_EXE_manypass");
    let drawn = "-o - --format png --size 8x8 --samples 1";
    for (line, expected) in [
        (format!("{program} info <(cat m.gltf)"), "triangles: 1"),
        (format!("{program} settings --effect <(cat e.wgsl)"), ".enabled"),
        (format!("{program} render <(cat m.gltf) --effect <(cat e.wgsl) {drawn}"), "PNG"),
    ] {
        if line.contains(drawn) && !has_adapter() {
            continue;
        }
        let mut bash = Command::new("bash");
        bash.env("MANYPASS_NO_CACHE", "1");
        let run = bash.args(["-c", &line]).current_dir(&*folder).stdin(Stdio::null()).output().expect("bash");
        let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        assert!(run.status.success() && out.contains(expected), "{line}: {out} {err}");
    }
}

#[test]
fn names_that_hold_commands_do_not_reach_the_terminal() {
    let folder = Folder::new("escapes");
    let name = "a\u{1b}[2J\u{7}b\u{9b}c";
    let named = serde_json::json!({
        "nodes": [{ "mesh": 0, "name": name }], "materials": [{ "name": name }],
        "scenes": [{ "nodes": [0], "name": name }],
        "animations": [{ "name": name, "channels": [], "samplers": [] }],
    });
    folder.write("m.gltf", model(named).as_bytes());
    for args in [
        &["info", "m.gltf"][..],
        &["info", "m.gltf", "--json"],
        &["info", "m.gltf", "--scene", name],
        &["info", "m.gltf", "--scene", "gone"],
        &["render", "m.gltf", "--animation", "gone"],
        &["render", "m.gltf", "--settings", name],
    ] {
        let run = run_in(&folder, args);
        let said = run.text() + &run.stderr;
        let is_command = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
        assert!(!said.contains(is_command), "{args:?}: {said:?}");
    }
    let run = run_in(&folder, &["info", "m.gltf", "--json"]).expect(0);
    assert!(serde_json::from_slice::<serde_json::Value>(&run.stdout).is_ok());
}

#[test]
fn a_long_name_of_a_variant_is_shortened_in_names_of_files() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("long-names");
    let (long, other) = ("v".repeat(5000), format!("{}w", "v".repeat(4999)));
    let variants = serde_json::json!({
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": { "KHR_materials_variants": { "variants": [{ "name": long }, { "name": other }, { "name": "red" }] } },
    });
    folder.write("m.gltf", model(variants).as_bytes());
    let args =
        ["render", "m.gltf", "--variant", "all", "-o", "o/{variant}.png", "--size", "8x8", "--samples", "1", "-q"];
    run_in(&folder, &args).expect(0);
    let names: Vec<String> = std::fs::read_dir(folder.join("o"))
        .expect("listed")
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    assert!(names.len() == 3 && names.contains(&"red.png".to_owned()), "{names:?}");
    assert!(names.iter().all(|name| name.len() < 100), "{names:?}");
}

/// Outputs that are devices stay what they are, whatever becomes of what is written to them.
#[cfg(target_os = "linux")]
#[test]
fn nodes_are_never_replaced() {
    use std::os::unix::fs::FileTypeExt as _;
    if !has_adapter() {
        return;
    }
    let folder = folder("nodes");
    let bare = ["--size", "8x8", "--samples", "1", "-q"];
    let render = |flags: &[&str]| run_in(&folder, &[&["render", "m.gltf"], &bare[..], flags].concat());
    render(&["-o", "a.png", "--dump-passes", "passes"]).expect(0);
    let mut passes = std::fs::read_dir(folder.join("passes")).expect("pictures").flatten();
    let pass = passes.next().expect("one").file_name();
    let [null_pass, full_pass] = ["null", "full"].map(|kind| format!("{kind}-passes/{}", pass.to_string_lossy()));
    let made = |name: &str, numbers: [&str; 2]| {
        std::fs::create_dir_all(folder.join(name).parent().expect("a folder")).expect("made");
        let [major, minor] = numbers;
        let mut mknod = std::process::Command::new("mknod");
        mknod.arg(folder.join(name)).args(["c", major, minor]).stderr(std::process::Stdio::null());
        mknod.status().is_ok_and(|status| status.success())
    };
    let null = ["null.png", "null.json", "null.glb", "null.glb.part", null_pass.as_str()];
    let full = ["full.png", "full.json", "full.glb", full_pass.as_str()];
    let is_root = null.iter().all(|name| made(name, ["1", "3"])) && full.iter().all(|name| made(name, ["1", "7"]));
    // Some file systems take nodes, and do not let anybody use them.
    if !is_root || !made("tty.png", ["5", "0"]) || std::fs::write(folder.join("null.png"), b"x").is_err() {
        manypass_testkit::needs::skip("only root makes devices");
        return;
    }
    for (null, full) in [("null", 0), ("full", 1)] {
        let [png, json, glb, passes] = [".png", ".json", ".glb", "-passes"].map(|end| format!("{null}{end}"));
        render(&["-o", &png]).expect(full);
        render(&["-o", "a.png", "--report", &json]).expect(full);
        render(&["-o", "b.png", "--contact-sheet", &png]).expect(full);
        render(&["-o", "c.png", "--dump-passes", &passes]).expect(full);
        run_in(&folder, &["bench", "m.gltf", "--size", "8x8", "--first-frame", "--json", "--png", &png]).expect(full);
        run_in(&folder, &["diff", "a.png", "a.png", "-o", &png]);
        run_in(&folder, &["bake", "m.gltf", "-o", &glb, "--samples", "1", "-q"]);
    }
    // In a session of its own there is no terminal to write to.
    let mut alone = std::process::Command::new("setsid");
    alone.args(["-w", env!("CARGO_BIN_EXE_manypass"), "render", "m.gltf", "-o", "tty.png"]).args(bare);
    let said = alone.current_dir(&*folder).output();
    assert!(said.is_err() || said.is_ok_and(|run| run.status.code() == Some(1)));
    let slow = ["render", "m.gltf", "-o", "null.png", "--report", "null.json", "--samples", "65536", "-q"];
    let mut killed = common::watch::start(&folder, &[&slow[..], &["--dump-passes", "null-passes"]].concat());
    std::thread::sleep(Duration::from_millis(1500));
    killed.kill().and_then(|()| killed.wait()).expect("killed");
    for name in null.iter().chain(&full).chain(&["tty.png"]) {
        let kind = std::fs::symlink_metadata(folder.join(name)).map(|there| there.file_type().is_char_device());
        assert!(matches!(kind, Ok(true)), "{name} is no device any more");
    }
    assert!(!folder.names().iter().any(|name| name.ends_with(".partial")), "{:?}", folder.names());
}

#[test]
fn pictures_that_were_cut_off_are_drawn_again() {
    if !has_adapter() {
        return;
    }
    let folder = folder("torn");
    let draw = |name: &str| {
        let args = ["render", "m.gltf", "-o", name, "--size", "32x32", "--samples", "1", "--skip-existing", "-q"];
        run_in(&folder, &args).expect(0);
        std::fs::read(folder.join(name)).expect("a picture")
    };
    for name in ["a.png", "a.jpg", "a.webp", "a.exr"] {
        let whole = draw(name);
        for length in [0, 3, 40, whole.len() / 2, whole.len() - 1] {
            folder.write(name, &whole[..length]);
            assert_eq!(draw(name).len(), whole.len(), "{name} of {length} bytes");
        }
        // What is whole stays, whatever it is.
        let written =
            |name: &str| std::fs::metadata(folder.join(name)).and_then(|file| file.modified()).expect("a time");
        let before = written(name);
        draw(name);
        assert_eq!(written(name), before, "{name}");
    }
}

#[test]
fn pictures_of_passes_that_were_cut_off_are_drawn_again() {
    if !has_adapter() {
        return;
    }
    let folder = folder("torn-passes");
    let draw = || {
        let args = ["render", "m.gltf", "-o", "a.png", "--size", "16x16", "--samples", "1", "--skip-existing", "-q"];
        run_in(&folder, &[&args[..], &["--dump-passes", "passes"]].concat()).expect(0);
        std::fs::read_dir(folder.join("passes")).expect("pictures").count()
    };
    let count = draw();
    let first = std::fs::read_dir(folder.join("passes")).expect("pictures").flatten().next().expect("one").path();
    let whole = std::fs::read(&first).expect("a picture");
    std::fs::write(&first, &whole[..whole.len() / 2]).expect("written");
    assert!(count > 1 && draw() == count);
    assert!(std::fs::read(&first).expect("a picture") == whole);
}

#[test]
fn a_turntable_of_a_still_model_has_no_warning() {
    if !has_adapter() {
        return;
    }
    let folder = folder("turntable");
    // Of the frames from which its one side is seen.
    let bare = ["--turntable", "8", "--frames", "6..7", "--size", "8x8", "--samples", "1", "--strict"];
    let run = run_in(&folder, &[&["render", "m.gltf"], &bare[..]].concat()).expect(0);
    assert_eq!(run.stderr, "");
}

#[cfg(target_os = "linux")]
#[test]
fn a_name_that_is_no_utf_8_names_a_model() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let folder = folder("odd-names");
    let name = OsStr::from_bytes(b"m\xff.gltf");
    std::fs::rename(folder.join("m.gltf"), std::path::Path::new(&*folder).join(name)).expect("renamed");
    let run = |first: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_manypass"));
        command.arg(first).arg(name).current_dir(&*folder).env("MANYPASS_NO_CACHE", "1");
        if first == "render" {
            command.args(["-o", "a.png", "--size", "8x8", "--samples", "1", "-q"]);
        }
        command.output().expect("the program starts")
    };
    let info = run("info");
    assert!(info.status.success(), "{}", String::from_utf8_lossy(&info.stderr));
    if has_adapter() {
        let render = run("render");
        assert!(render.status.success(), "{}", String::from_utf8_lossy(&render.stderr));
    }
}
