//! Runs the examples as they were built with the tests, and judges their pictures.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use manypass::{FrameRequest, scene};
use manypass_testkit::compare::{Picture, difference};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the example `name`; the last argument is the picture it writes.
fn run(name: &str, arguments: &[&str]) -> Picture {
    // Cargo puts tests into `deps`, and examples beside that folder.
    let deps = std::env::current_exe().unwrap();
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let example = deps.parent().and_then(Path::parent).unwrap().join("examples").join(file);
    assert!(
        example.exists(),
        "{} is not built; `cargo test -p manypass` builds it, `--test examples` does not",
        example.display()
    );
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
    let output = Command::new(example).args(arguments).arg(&out).output().unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let decoded = image::open(&out).unwrap().to_rgba8();
    Picture::from_rgba8(decoded.width() as usize, decoded.height() as usize, decoded.as_raw())
}

/// The share of pixels that are neither black nor white.
fn toned_share(picture: &Picture) -> f64 {
    let toned = picture.pixels.iter().filter(|[r, g, b, _]| ![[0; 3], [255; 3]].contains(&[*r, *g, *b])).count();
    toned as f64 / picture.pixels.len() as f64
}

#[test]
fn a_still_is_fifteen_lines_and_shows_the_model() {
    assert!(include_str!("../examples/still.rs").lines().count() <= 16, "fifteen lines and a doc comment");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let model = folder.join("still_triangle.gltf");
    std::fs::write(&model, TRIANGLE).unwrap();
    let picture = run("still", &[model.to_str().unwrap()]);
    assert_eq!((picture.width, picture.height), (960, 540));
    let [r, g, b, _] = picture.pixels[270 * 960 + 480];
    assert!(r > 100 && r > 2 * g && r > 2 * b, "the middle of the red triangle is {r} {g} {b}");
}

/// A red triangle around the origin; positions are those of three corners, in base64.
const TRIANGLE: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1],"metallicFactor":0},"doubleSided":true}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]}]}"#;

#[test]
fn an_own_pass_changes_the_picture() {
    let picture = run("own_pass", &[]);
    let hall = scene::demo::hall();
    let mut renderer = common::renderer();
    renderer.load(&hall).unwrap();
    renderer.render(&hall, &FrameRequest::of_scene(&hall, 640, 360)).unwrap();
    let plain = Picture::from_rgba8(640, 360, &renderer.read_display().unwrap());
    assert!(toned_share(&plain) > 0.9 && toned_share(&picture) > 0.9);
    // Lines are bright: some pixels gain, and those in the corners lose.
    let luminance = |[r, g, b, _]: [u8; 4]| u32::from(r) + u32::from(g) + u32::from(b);
    let brighter = plain.pixels.iter().zip(&picture.pixels).filter(|(a, b)| luminance(**b) > luminance(**a) + 150);
    let share = brighter.count() as f64 / plain.pixels.len() as f64;
    assert!((0.02..0.4).contains(&share), "{share} of the pixels are lines");
    let corner = |picture: &Picture| (0..40).map(|x| luminance(picture.pixels[359 * 640 + x])).sum::<u32>();
    assert!(corner(&picture) < corner(&plain), "the vignette darkens the corner");
    assert!(difference(&plain, &picture, 2).share < 0.9);
}

#[test]
fn a_picture_is_embedded_between_the_callers_commands() {
    let picture = run("embed", &[]);
    assert_eq!((picture.width, picture.height), (320, 200));
    let border = picture.pixels[0];
    let is_border = |x: usize, y: usize| picture.pixels[y * 320 + x] == border;
    assert!((0..320).all(|x| (0..10).all(|y| is_border(x, y) && is_border(x, 199 - y))));
    assert!((0..160).all(|y| (0..10).all(|x| is_border(x, y) && is_border(319 - x, y))));
}
