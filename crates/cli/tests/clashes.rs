//! Nothing that a call reads is replaced by what it writes, and nothing that it writes by what else it writes.

use crate::common::{self, Folder, has_adapter, run_in, triangle_glb};
use std::path::Path;

const SMALL: [&str; 4] = ["--size", "16x16", "--samples", "1"];

/// A model with a buffer and an image of its own, an effect and settings.
fn textured(name: &str) -> Folder {
    let folder = Folder::new(name);
    let floats = [-1_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    folder.write("in/m.bin", &floats.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::new(2, 2).write_to(&mut png, image::ImageFormat::Png).expect("encoded");
    folder.write("in/m.png", &png.into_inner());
    folder.write(
        "in/m.gltf",
        br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "materials":[{"doubleSided":true,"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"m.png"}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"m.bin"}]}"#,
    );
    folder.write("in/e.wgsl", b"@fragment fn fs() -> @location(0) vec4f { return vec4f(0.0); }");
    folder.write("in/s.toml", b"[render]\nscale = 1.0\n");
    folder
}

/// The bytes of all files in a folder.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).expect("listed").map(|entry| entry.expect("entry").path());
    let mut files: Vec<_> = entries
        .filter(|path| path.is_file())
        .map(|path| (path.display().to_string(), std::fs::read(&path).expect("read")))
        .collect();
    files.sort();
    files
}

#[track_caller]
fn refused(folder: &Folder, args: &[&str], part: &str) {
    let before = contents(&folder.join("in"));
    let run = run_in(folder, &[args, &SMALL].concat()).expect(2);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert!(matches!(lines[..], [e, h] if e.starts_with("error: ") && h.starts_with("hint: ")), "{}", run.stderr);
    assert!(run.stderr.contains(part), "{args:?}: {}", run.stderr);
    assert!(contents(&folder.join("in")) == before, "{args:?}");
}

#[test]
fn an_output_that_is_read_is_refused() {
    let folder = textured("clash-read");
    let model = "in/m.gltf";
    folder.write("in/other.glb", &triangle_glb([1.0, 1.0, 1.0]));
    std::fs::create_dir(folder.join("dump")).expect("a folder");
    #[cfg(unix)]
    {
        std::fs::hard_link(folder.join("in/m.png"), folder.join("hard.png")).expect("linked");
        std::os::unix::fs::symlink("in/m.png", folder.join("soft.png")).expect("linked");
        std::os::unix::fs::symlink("../in/m.png", folder.join("dump/03-direct.png")).expect("linked");
        for args in [["-o", "hard.png"], ["-o", "soft.png"], ["--dump-passes", "dump"], ["--report", "soft.png"]] {
            refused(&folder, &[&["render", model], &args[..]].concat(), "in/m.gltf names");
        }
    }
    for (flag, path) in [
        ("-o", "in/m.png"),
        ("-o", "in/"),
        ("-o", "in/{stem}.png"),
        ("-o", "./new/../in/m.png"),
        ("--contact-sheet", "in/m.png"),
        ("--report", "in/m.bin"),
        ("--report", "in/m.gltf"),
    ] {
        refused(&folder, &["render", model, flag, path], "would replace");
    }
    refused(&folder, &["render", model, "--effect", "in/e.wgsl", "--report", "in/e.wgsl"], "the effect in/e.wgsl");
    refused(&folder, &["render", model, "--settings", "in/s.toml", "--report", "in/s.toml"], "the settings in/s.toml");
    // What another picture of the batch reads.
    refused(&folder, &["render", "in/other.glb", model, "-o", "in/m.png"], "would replace");
    refused(&folder, &["render", model, "--frames", "7..7", "--report", "r", "-o", "in/m.png"], "{frame");
    let run = run_in(&folder, &["bench", model, "--png", "in/m.png"]).expect(2);
    assert!(run.stderr.contains("would replace"), "{}", run.stderr);
}

#[test]
fn a_variable_that_is_read_as_an_image_is_refused() {
    let folder = textured("clash-aov");
    let text = std::fs::read_to_string(folder.join("in/m.gltf")).expect("read").replace("m.png", "m.depth.png");
    folder.write("in/m.gltf", text.as_bytes());
    std::fs::rename(folder.join("in/m.png"), folder.join("in/m.depth.png")).expect("renamed");
    refused(&folder, &["render", "in/m.gltf", "-o", "in/m.png", "--aov", "depth"], "in/m.depth.png would replace");
    refused(&folder, &["render", "in/m.gltf", "-o", "in/m.{aov}.png", "--aov", "depth"], "would replace");
}

#[test]
fn what_a_model_names_is_safe_even_where_it_may_not_be_read() {
    let folder = textured("clash-named");
    let text = std::fs::read_to_string(folder.join("in/m.gltf")).expect("read");
    std::fs::create_dir(folder.join("tex")).expect("a folder");
    std::fs::rename(folder.join("in/m.png"), folder.join("tex/a.png")).expect("renamed");
    let absolute = folder.join("tex/a.png").display().to_string();
    let file = format!("file://{absolute}");
    for uri in ["../tex/a.png", "./gone/../../tex/a.png", r"..\\tex\\a.png", &absolute, &file] {
        folder.write("in/m.gltf", text.replace("m.png", uri).as_bytes());
        for args in [["-o", "tex/a.png"], ["--report", "tex/../tex/a.png"], ["-o", &absolute]] {
            refused(&folder, &[&["render", "in/m.gltf"], &args[..]].concat(), "in/m.gltf names");
        }
    }
}

/// Open files are compared by what they are, and only where they are regular files.
#[cfg(unix)]
#[test]
fn an_open_file_that_is_read_or_written_otherwise_is_refused() {
    let folder = textured("clash-open");
    folder.write("in/other.glb", &triangle_glb([1.0, 1.0, 1.0]));
    for (script, part) in [
        ("in/other.glb -o - --format png >> in/other.glb", "would replace the model in/other.glb"),
        ("in/m.gltf -o - --format png 1<>in/m.png", "would replace a file that in/m.gltf names"),
        ("in/m.gltf -o /dev/fd/3 --format png 3>>in/m.bin", "would replace a file that in/m.gltf names"),
        ("in/m.gltf -o /dev/stdout --format png >>in/m.bin", "would replace a file that in/m.gltf names"),
        ("in/m.gltf -o x.png --report - >> in/m.gltf", "would replace the model"),
        ("in/m.gltf -o x.png --report /dev/stdout >> in/m.gltf", "would replace the model"),
        ("in/m.gltf -o x.png --report /dev/fd/3 3>> in/m.png", "would replace a file"),
        ("- -o - --format png < in/other.glb 1<>in/other.glb", "would replace the model on standard input"),
        ("in/m.gltf -o x.png --report - > x.png", "two outputs"),
        ("in/m.gltf -o /dev/fd/3 --format png --report /dev/fd/3 3> x.png", "two outputs"),
        ("in/m.gltf -o /dev/fd/3 --format png --report r 3> r", "two outputs"),
    ] {
        let before = contents(&folder.join("in"));
        let mut command = std::process::Command::new("bash");
        command.args(["-c", &format!("\"$0\" render {script}"), env!("CARGO_BIN_EXE_manypass")]);
        let run = common::Run::from(command.current_dir(&*folder).output().expect("bash runs")).expect(2);
        assert!(run.stderr.contains(part), "{script}: {}", run.stderr);
        assert!(contents(&folder.join("in")) == before, "{script}");
    }
}

#[test]
fn two_outputs_of_one_call_are_two_files() {
    let folder = textured("clash-written");
    for name in ["a.glb", "a.depth.glb", "a1.glb"] {
        folder.write(&format!("in/{name}"), &triangle_glb([1.0, 1.0, 1.0]));
    }
    std::fs::create_dir(folder.join("real")).expect("a folder");
    #[cfg(unix)]
    std::os::unix::fs::symlink("real", folder.join("link")).expect("linked");
    #[cfg(unix)]
    refused(&folder, &["render", "in/a.glb", "-o", "link/x.png", "--report", "real/x.png"], "two outputs");
    for args in [
        &["in/a.glb", "-o", "x.png", "--report", "./x.png"][..],
        &["in/a.glb", "-o", "x.png", "--contact-sheet", "x.png"],
        &["in/a.glb", "in/a1.glb", "-o", "x.png"],
        &["in/a.glb", "in/a1.glb", "-o", "{stem}.png", "--contact-sheet", "x.png"],
        &["in/a.glb", "in/a.depth.glb", "--aov", "depth"],
        // Frame 11 of the one is frame 1 of the other.
        &["in/a.glb", "in/a1.glb", "--frames", "0..11", "-o", "{stem}{frame}.png"],
    ] {
        refused(&folder, &[&["render"], args].concat(), "two outputs");
    }
    refused(&folder, &["render", "in/a.glb", "in/a1.glb", "--dump-passes", "d"], "the passes of two pictures");
    refused(&folder, &["render", "in/a.glb", "-o", "d/01-a.png", "--dump-passes", "d"], "--dump-passes could");
    assert_eq!(folder.names().iter().filter(|name| name.contains('.')).count(), 0, "{:?}", folder.names());
}

#[test]
fn a_picture_beside_its_texture_leaves_it_alone() {
    if !has_adapter() {
        return;
    }
    let folder = textured("clash-beside");
    let before = contents(&folder.join("in"));
    run_in(&folder.join("in"), &[&["render", "m.gltf"], &SMALL[..]].concat()).expect(2);
    run_in(&folder.join("in"), &[&["render", "m.gltf", "-o", "n.png", "--report", "/dev/null"], &SMALL[..]].concat())
        .expect(0);
    let after = contents(&folder.join("in"));
    assert!(after.len() == before.len() + 1 && before.iter().all(|file| after.contains(file)));
}
