//! Runs the examples as they were built with the tests, and judges their pictures.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use manypass::{FrameRequest, scene};
use manypass_testkit::compare::{Picture, difference};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the example `name`; the last argument is the picture it writes.
fn run(name: &str, arguments: &[&str]) -> Picture {
    run_and_hear(name, arguments).0
}

/// Where the example `name` was built.
fn example(name: &str) -> PathBuf {
    // Cargo puts tests into `deps`, and examples beside that folder.
    let deps = std::env::current_exe().unwrap();
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let example = deps.parent().and_then(Path::parent).unwrap().join("examples").join(file);
    assert!(
        example.exists(),
        "{} is not built; `cargo test -p manypass` builds it, `--test all` does not",
        example.display()
    );
    example
}

/// As [`run`], with what the example says.
fn run_and_hear(name: &str, arguments: &[&str]) -> (Picture, String) {
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
    let output = Command::new(example(name)).args(arguments).arg(&out).output().unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let decoded = image::open(&out).unwrap().to_rgba8();
    let picture = Picture::from_rgba8(decoded.width() as usize, decoded.height() as usize, decoded.as_raw());
    (picture, String::from_utf8_lossy(&output.stdout).into_owned())
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

/// The part of `picture` at this row and column of two each.
fn quarter(picture: &Picture, row: usize, column: usize) -> Picture {
    let (width, height) = (picture.width / 2, picture.height / 2);
    let at = |y: usize| (row * height + y) * picture.width + column * width;
    let pixels = (0..height).flat_map(|y| picture.pixels[at(y)..at(y) + width].iter().copied()).collect();
    Picture { width, height, pixels }
}

/// Layouts share nothing with our frame but the frame graph and the scene: their reflectance, falloff, camera and
/// targets are their own. They round the sum of 16 lights to 8 bits of sRGB after each, by up to half a step: 8 steps
/// at the most beside the rounding of our own, and 1 in the mean.
#[test]
fn textbook_layouts_make_the_picture_of_our_frame() {
    let (picture, table) = run_and_hear("textbook_layouts", &["128", "72", "1"]);
    assert_eq!((picture.width, picture.height), (256, 144));
    assert!(toned_share(&picture) > 0.8);
    for row in 0..2 {
        let [theirs, ours] = [0, 1].map(|column| quarter(&picture, row, column));
        let difference = difference(&ours, &theirs, 9);
        assert!(difference.share > 0.998 && difference.mean < 1.2, "layout {row}: {difference:?}");
    }
    // The rows differ in what surfaces are made of.
    let [alike, different] = [0, 1].map(|row| quarter(&picture, row, 1));
    let difference = difference(&alike, &different, 9);
    assert!(difference.share < 0.98, "{difference:?}");

    let bytes = |name: &str| -> [f64; 3] {
        let line =
            table.lines().find(|line| line.starts_with(&format!("| {name}"))).unwrap_or_else(|| panic!("{table}"));
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        [2, 3, 4].map(|column| cells[column].parse().unwrap())
    };
    // Three targets of 8 bytes and depth of 4, shared by all lights; each light writes them, and the picture.
    assert_eq!(bytes("three targets"), [3.0 * 8.0 + 4.0, 28.0 + 4.0, 16.0 * (28.0 + 4.0)]);
    // Two targets of 16 bytes, diffuse colour, accumulation and depth with stencil; the last two are written by the
    // volumes as well. The diffuse colour's memory is the picture's in the end.
    let held = 2.0 * 16.0 + 3.0 * 4.0;
    assert_eq!(bytes("float positions, two geometry passes"), [held, held, held + 8.0 + 4.0]);
    let ours = bytes("ours |");
    assert!(ours[0] < held && ours[2] < held + 12.0, "{table}");
}

#[test]
fn an_effect_in_rust_keeps_what_frames_before_have_shown() {
    assert!(include_str!("../examples/rust_pass.rs").lines().count() <= 120);
    let picture = run("rust_pass", &[]);
    assert_eq!((picture.width, picture.height), (320, 180));
    let red_at = |x: usize| u32::from(picture.pixels[90 * 320 + x][0]);
    // The ball is in the middle. It came from the left, where it fades, and was never to the right of where it is.
    assert!(red_at(160) > 150, "the ball is {}", red_at(160));
    let [left, right] = [[100, 90, 80, 70], [220, 230, 240, 250]].map(|columns| columns.map(red_at));
    assert!(left.iter().all(|red| *red > 10), "the afterimage is {left:?}");
    assert!(right.iter().all(|red| *red < 5), "beside it is {right:?}");
    assert!(left.is_sorted_by(|near, far| near >= far), "it fades with its age: {left:?}");
}

#[test]
fn a_scene_built_in_code_is_drawn() {
    let picture = run("scene_in_code", &[]);
    assert_eq!((picture.width, picture.height), (640, 360));
    assert!(toned_share(&picture) > 0.8);
    let at = |x: usize, y: usize| picture.pixels[y * 640 + x].map(u32::from);
    // The front of the pyramid is red, the sphere to its left is of gold, and the floor is grey.
    let [red, green, blue, _] = at(320, 190);
    assert!(red > 80 && red > 2 * green && red > 2 * blue, "the pyramid is {:?}", at(320, 190));
    let sphere: Vec<[u32; 4]> = (150..225).map(|y| at(150, y)).collect();
    assert!(sphere.iter().any(|[red, _, blue, _]| *red > blue + 15), "the sphere is {sphere:?}");
    let [red, green, blue, _] = at(320, 340);
    assert!(red > 20 && red.abs_diff(green) < 40 && green.abs_diff(blue) < 60, "the floor is {:?}", at(320, 340));
}

/// A display without a screen, which ends with it.
struct Xvfb(std::process::Child, String);

impl Xvfb {
    /// None where the program is not installed.
    fn start() -> Option<Self> {
        let mut command = Command::new("Xvfb");
        // It writes the number of the display that it has chosen, and closes its output.
        command.args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp"]);
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::null());
        let mut child = command.spawn().ok()?;
        let mut number = String::new();
        let output = child.stdout.take().unwrap();
        std::io::BufRead::read_line(&mut std::io::BufReader::new(output), &mut number).unwrap();
        Some(Self(child, format!(":{}", number.trim())))
    }
}

impl Drop for Xvfb {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_window_shows_a_thousand_lights_that_move() {
    assert!(include_str!("../examples/window/main.rs").lines().count() <= 90);
    if !cfg!(target_os = "linux") {
        return manypass_testkit::needs::skip("only Linux has displays without a screen");
    }
    let Some(display) = Xvfb::start() else {
        return manypass_testkit::needs::skip("no Xvfb; on Debian and Ubuntu the package xvfb brings it");
    };
    let frames = |count: &str| {
        let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("window_{count}.png"));
        let mut command = Command::new(example("window"));
        command.args(["--frames", count, "--out"]).arg(&out).env("DISPLAY", &display.1);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let decoded = image::open(&out).unwrap().to_rgba8();
        Picture::from_rgba8(decoded.width() as usize, decoded.height() as usize, decoded.as_raw())
    };
    let [first, later] = ["1", "5"].map(frames);
    assert_eq!((first.width, first.height), (later.width, later.height));
    assert!(toned_share(&first) > 0.3, "{}", toned_share(&first));
    let moved = difference(&first, &later, 8);
    assert!((0.005..0.98).contains(&(1.0 - moved.share)), "lamps move, and the floor stays: {moved:?}");
}
