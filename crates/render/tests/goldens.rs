//! Goldens: small pictures of one subject each, in `goldens/NAME.png`. `cargo xtask goldens` writes them again; look at
//! every change before you commit it. A missing golden fails, and so does one that no subject has.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod subjects;

use crate::common;
use manypass::{Adaptation, Effect, EffectFile, FrameRequest, Renderer, WgslEffect};
use manypass_testkit::compare::{Picture, Tolerance, assert_rejects_mutations, difference};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use subjects::Subject;

/// Software adapters differ by two to three levels from host to host (they use other vector units), and at edges, where
/// a quarter of a pixel more is covered. Four samples a pixel leave few edges: the share. With the vector units of
/// other hosts (Mesa can be told to do without) at most 4 such pixels hang together, and 1 that shows nothing of what
/// is beside it; twice that is allowed. More is a thing that is missing, of a wrong colour or in a wrong place.
const TOLERANCE: Tolerance =
    Tolerance { within: 3, share: 0.99, share_between: 0.998, mean: 0.5, area_px: 8, area_between_px: 2 };

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens")
}

fn read(path: &Path) -> Option<Picture> {
    let decoded = image::open(path).ok()?.to_rgba8();
    Some(Picture::from_rgba8(decoded.width() as usize, decoded.height() as usize, decoded.as_raw()))
}

fn write(path: &Path, picture: &Picture) {
    let (width, height) = (picture.width as u32, picture.height as u32);
    image::save_buffer(path, picture.pixels.as_flattened(), width, height, image::ColorType::Rgba8).unwrap();
}

/// How many frames those are that a golden of frames that follow each other shows the last of.
const FRAMES: u32 = 10;
/// From each to the next.
const FRAME_SECS: f32 = 0.05;

/// The last of frames that follow each other, while the camera comes to where the request has it.
fn draw_live(renderer: &mut Renderer, subject: &Subject, request: &FrameRequest) -> Vec<u8> {
    renderer.cut();
    for frame in 1..=FRAMES {
        let adaptation = if frame == 1 { Adaptation::Begins } else { Adaptation::After { secs: FRAME_SECS } };
        let mut request = FrameRequest { goes_on: true, adaptation, ..request.clone() };
        request.camera.world_from_view.w_axis.x += 0.02 * (FRAMES - frame) as f32;
        renderer.render(&subject.scene, &request).unwrap();
    }
    renderer.read_display().unwrap()
}

/// A still, four samples a pixel unless it asks for more.
fn draw_still(renderer: &mut Renderer, subject: &Subject, request: &FrameRequest) -> Vec<u8> {
    let sample_count = request.sample_count.max(4);
    for sample_index in 0..sample_count {
        renderer.render(&subject.scene, &FrameRequest { sample_count, sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_display().unwrap()
}

/// Effects with `+` between their names, built in or of docs/samples.md, the last one with settings.
fn chain(renderer: &Renderer, names: &str, settings: &[&str]) -> Vec<Arc<dyn Effect>> {
    let last = names.rsplit('+').next();
    let compile = |name| -> Arc<dyn Effect> {
        let settings = if Some(name) == last { settings } else { &[] };
        match EffectFile::is_built_in(name) {
            true => common::built_in_with(renderer, name, settings),
            false => common::sample_with(renderer, name, settings),
        }
    };
    names.split('+').map(compile).collect()
}

/// Draws a subject: its strips below one another, stills or the last of frames that follow each other.
fn draw(renderer: &mut Renderer, subject: &Subject) -> Picture {
    renderer.load(&subject.scene).unwrap();
    let mut pixels = Vec::new();
    let (mut width, mut height) = (0, 0);
    for (strip, request) in subject.strips.iter().enumerate() {
        let mut request = request.clone();
        if let Some((name, settings)) = subject.effects.get(strip) {
            request.effects = chain(renderer, name, settings);
        }
        if let Some((file, text)) = subject.tables.get(strip) {
            request.effects = vec![Arc::new(WgslEffect::new(renderer.gpu(), file, text).unwrap())];
        }
        (width, height) = (request.width as usize, height + request.height as usize);
        let is_live = request.settings.taa.enabled || request.settings.exposure.adapt || request.goes_on;
        let draw = if is_live { draw_live } else { draw_still };
        pixels.extend(draw(renderer, subject, &request));
    }
    Picture::from_rgba8(width, height, &pixels)
}

/// What is wrong with `found`, if anything. A known failure is wrong when it is right.
fn judge(found: &Picture, golden: Option<&Picture>, known_failure: Option<&str>) -> Option<String> {
    let Some(golden) = golden else { return Some("the golden is missing; `cargo xtask goldens` writes it".into()) };
    if (found.width, found.height) != (golden.width, golden.height) {
        return Some(format!("the golden is {} × {} pixels", golden.width, golden.height));
    }
    let difference = difference(golden, found, TOLERANCE.within);
    match (difference.is_within(TOLERANCE), known_failure) {
        (true, None) | (false, Some(_)) => None,
        (false, None) => Some(format!("{difference}; {:?}", difference.worst)),
        (true, Some(reason)) => Some(format!("is no longer wrong ({reason}); delete its reason")),
    }
}

/// Pictures that are the golden of none of `names`.
fn orphans(files: impl Iterator<Item = String>, names: &[String]) -> impl Iterator<Item = String> {
    files.filter(|file| file.ends_with(".png") && !names.contains(file))
}

#[test]
fn goldens_hold() {
    let writes = std::env::var("MANYPASS_GOLDENS").is_ok_and(|value| value == "write");
    let mut renderer = common::software_renderer();
    let (mut wrong, mut names) = (Vec::new(), Vec::new());
    for subject in subjects::all() {
        let path = folder().join(format!("{}.png", subject.name));
        let found = draw(&mut renderer, &subject);
        assert!(found.width <= 128 && found.height <= 128, "{}: goldens are small", subject.name);
        // A golden that accepts a spoilt picture proves nothing.
        println!("{}", subject.name);
        assert_rejects_mutations(&found, TOLERANCE);
        names.push(format!("{}.png", subject.name));
        let golden = read(&path);
        let Some(fault) = judge(&found, golden.as_ref(), subject.known_failure) else { continue };
        if writes {
            println!("writes {}: {fault}", path.display());
            write(&path, &found);
            continue;
        }
        let seen = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.png", subject.name));
        write(&seen, &found);
        wrong.push(format!("{}: {fault}; the picture is at {}", subject.name, seen.display()));
    }
    let files = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    wrong.extend(orphans(files, &names).map(|file| format!("{file} has no subject; delete it")));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_golden_is_judged_strictly() {
    let pixels: Vec<u8> = (0..64 * 64).flat_map(|i| [(i % 64 * 4) as u8, (i / 64 * 4) as u8, 90, 255]).collect();
    let picture = Picture::from_rgba8(64, 64, &pixels);
    let mut noisy = picture.clone();
    noisy.pixels.iter_mut().for_each(|pixel| pixel[2] += 3);
    let mut wrong = picture.clone();
    wrong.pixels.iter_mut().for_each(|pixel| pixel[2] += 4);
    let smaller = Picture::from_rgba8(32, 128, &pixels);
    assert!(judge(&picture, Some(&picture), None).is_none());
    assert!(judge(&noisy, Some(&picture), None).is_some(), "three levels everywhere are too much on average");
    assert!(judge(&wrong, Some(&picture), None).is_some());
    assert!(judge(&smaller, Some(&picture), None).is_some());
    assert!(judge(&picture, None, None).is_some(), "a missing golden fails");
    assert!(judge(&wrong, Some(&picture), Some("reason")).is_none());
    assert!(judge(&picture, Some(&picture), Some("reason")).is_some(), "a known failure that passes fails");
    let files = ["hall.png", "forgotten.png", "subjects.rs"].map(String::from);
    let names = ["hall.png", "lights.png"].map(String::from);
    let found: Vec<String> = orphans(files.into_iter(), &names).collect();
    assert_eq!(found, ["forgotten.png"], "a golden without a subject fails");
}

#[test]
fn a_golden_refuses_a_small_thing_in_a_wrong_colour() {
    let pixels: Vec<u8> = (0..128 * 72).flat_map(|i| [(i % 128) as u8, (i / 128 * 3) as u8, 90, 255]).collect();
    let golden = Picture::from_rgba8(128, 72, &pixels);
    let with_wrong = |is_wrong: &dyn Fn(usize, usize) -> bool| {
        let mut picture = golden.clone();
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            pixel[2] += if is_wrong(i % 128, i / 128) { 40 } else { 0 };
        }
        picture
    };
    // 81 pixels are within the share of one per cent, and their difference within the mean.
    let block = with_wrong(&|x, y| (60..69).contains(&x) && (30..39).contains(&y));
    let fault = judge(&block, Some(&golden), None).expect("81 pixels together");
    assert!(difference(&golden, &block, TOLERANCE.within).share > TOLERANCE.share, "{fault}");
    let apart = with_wrong(&|x, y| x % 32 == 7 && y % 20 == 5);
    assert!(judge(&apart, Some(&golden), None).is_none(), "16 pixels that lie apart");
}
