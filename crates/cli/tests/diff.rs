//! `diff`: numbers of the authors' program, the sheet, and what is refused.

use crate::common::{Folder, run_in};
use exr::prelude::write_rgba_file;
use image::{DynamicImage, ImageFormat, RgbImage, RgbaImage};
use serde_json::Value;
use std::io::Cursor;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).expect("encoded");
    bytes.into_inner()
}

/// A pattern, and the same redder by `more` in its right half.
fn pattern(more: u32) -> RgbImage {
    RgbImage::from_fn(WIDTH, HEIGHT, |x, y| {
        let more = if x >= WIDTH / 2 { more } else { 0 };
        image::Rgb([(4 * x % 256 + more).min(255) as u8, (5 * y % 256) as u8, (x * y % 256) as u8])
    })
}

/// Five orders of magnitude of radiance, darker by `factor` in the right half.
fn write_radiance(folder: &Folder, name: &str, factor: f32) {
    let pixel = |x: usize, y: usize| {
        let value = ((x * x + 1) as f64 * 0.01 * (1 + y) as f64) as f32;
        let factor = if x >= 32 { factor } else { 1.0 };
        (value * factor, value * 0.8 * factor, value * 0.5 * factor, 1.0_f32)
    };
    write_rgba_file(folder.join(name), WIDTH as usize, HEIGHT as usize, pixel).expect("written");
}

fn json(folder: &Folder, args: &[&str]) -> Value {
    let run = run_in(folder, &[&["diff"], args, &["--json"]].concat()).expect(0);
    assert_eq!(run.stderr, "");
    serde_json::from_str(&run.text()).expect("JSON")
}

#[track_caller]
fn refused(folder: &Folder, args: &[&str], code: i32, parts: &[&str]) {
    let run = run_in(folder, &[&["diff"], args].concat()).expect(code);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert!(matches!(lines[..], [e, h] if e.starts_with("error: ") && h.starts_with("hint: ")), "{}", run.stderr);
    assert!(parts.iter().all(|part| run.stderr.contains(part)), "{args:?}: {}", run.stderr);
    assert!(run.stdout.is_empty(), "{args:?}");
}

/// The expected means are those of the authors' package `flip-evaluator` 1.7 for the same pixels.
#[test]
fn means_are_those_of_the_authors_program() {
    let folder = Folder::new("diff-means");
    folder.write("a.png", &encoded(pattern(0), ImageFormat::Png));
    folder.write("b.png", &encoded(pattern(20), ImageFormat::Png));
    folder.write("b.webp", &encoded(pattern(20), ImageFormat::WebP));
    let value = json(&folder, &["a.png", "b.png"]);
    let flip = &value["flip"];
    let near = |found: &Value, expected: f64| (found.as_f64().expect("a number") - expected).abs() < 2e-4;
    assert!(near(&flip["mean"], 0.127_662) && near(&flip["largest"], 0.329_151), "{value}");
    assert_eq!((&value["a"], &value["b"], &value["size_px"]), (&"a.png".into(), &"b.png".into(), &[64, 48][..].into()));
    assert_eq!(
        (&flip["kind"], &flip["pixels_per_degree"], &flip["exposures"]),
        (&"ldr".into(), &67.0.into(), &Value::Null)
    );
    assert!(flip["largest_at_px"][0].as_u64() >= Some(31), "{value}");
    assert_eq!(json(&folder, &["a.png", "b.webp"])["flip"], *flip);
    assert_eq!(json(&folder, &["b.png", "b.webp"])["flip"]["largest"], 0.0);
    let nearer = json(&folder, &["a.png", "b.png", "--pixels-per-degree", "20"]);
    assert!(nearer["flip"]["mean"] != flip["mean"] && nearer["flip"]["pixels_per_degree"] == 20.0, "{nearer}");

    write_radiance(&folder, "a.exr", 1.0);
    write_radiance(&folder, "b.exr", 0.7);
    let value = json(&folder, &["a.exr", "b.exr"]);
    let flip = &value["flip"];
    assert!(near(&flip["mean"], 0.173_517) && near(&flip["largest"], 0.421_506), "{value}");
    let exposures = &flip["exposures"];
    assert!(flip["kind"] == "hdr" && exposures["count"] == 4, "{value}");
    assert!((exposures["start_ev"].as_f64().expect("a number") + 9.527_94).abs() < 1e-3, "{value}");
}

#[test]
fn what_is_transparent_in_both_is_the_same_and_is_mid_grey() {
    let folder = Folder::new("diff-alpha");
    for (name, pixel) in [("red.png", [255, 0, 0, 0]), ("blue.png", [0, 0, 255, 0]), ("grey.png", [128, 128, 128, 255])]
    {
        folder.write(name, &encoded(RgbaImage::from_pixel(16, 16, image::Rgba(pixel)), ImageFormat::Png));
    }
    folder.write("grey.jpg", &encoded(RgbImage::from_pixel(16, 16, image::Rgb([128; 3])), ImageFormat::Jpeg));
    assert_eq!(json(&folder, &["red.png", "blue.png"])["flip"]["largest"], 0.0);
    for grey in ["grey.png", "grey.jpg"] {
        // A byte has no value for exactly one half.
        let value = json(&folder, &["red.png", grey]);
        assert!(value["flip"]["largest"].as_f64() < Some(0.03), "{value}");
    }
    for (name, alpha) in [("clear.exr", 0.0), ("grey.exr", 1.0)] {
        let value = if alpha == 0.0 { 0.0 } else { 0.18_f32 };
        write_rgba_file(folder.join(name), 16, 16, |_, _| (value, value, value, alpha as f32)).expect("written");
    }
    assert_eq!(json(&folder, &["clear.exr", "grey.exr"])["flip"]["largest"], 0.0);
}

#[test]
fn the_sheet_shows_both_and_where_they_differ() {
    let folder = Folder::new("diff-sheet");
    let green = RgbImage::from_pixel(160, 96, image::Rgb([0, 255, 0]));
    let half = RgbImage::from_fn(160, 96, |x, _| image::Rgb(if x < 80 { [0, 255, 0] } else { [0, 0, 255] }));
    folder.write("a.png", &encoded(green, ImageFormat::Png));
    folder.write("b.png", &encoded(half, ImageFormat::Png));
    let text = run_in(&folder, &["diff", "a.png", "b.png", "-o", "out/sheet.png"]).expect(0).text();
    assert!(text.starts_with("FLIP mean 0.5") && text.contains("largest 1.000000 at column"), "{text}");
    let sheet = image::open(folder.join("out/sheet.png")).expect("a sheet").to_rgb8();
    // Three cells, each as wide as the longest label needs.
    let step = (sheet.width() - 8) / 3;
    let at = |cell: u32, x: u32| sheet.get_pixel(8 + cell * step + x, 8 + 48).0;
    assert_eq!((at(0, 20), at(0, 140), at(1, 20), at(1, 140)), ([0, 255, 0], [0, 255, 0], [0, 255, 0], [0, 0, 255]));
    assert_eq!((at(2, 20), at(2, 140)), ([0, 0, 4], [252, 253, 191]));
    assert_eq!(folder.names(), ["a.png", "b.png", "out"]);
    assert_eq!(std::fs::read_dir(folder.join("out")).expect("listed").count(), 1);
}

#[test]
fn a_threshold_decides_the_exit_code_after_all_is_written() {
    let folder = Folder::new("diff-threshold");
    folder.write("a.png", &encoded(pattern(0), ImageFormat::Png));
    folder.write("b.png", &encoded(pattern(20), ImageFormat::Png));
    let with = |threshold: &str, code: i32| {
        run_in(&folder, &["diff", "a.png", "b.png", "--json", "-o", "s.png", "--threshold", threshold]).expect(code)
    };
    let run = with("0.001", 5);
    let value: Value = serde_json::from_str(&run.text()).expect("JSON");
    assert_eq!((&value["threshold"], &value["is_above_threshold"]), (&0.001.into(), &true.into()));
    assert_eq!(value["sheet"], "s.png");
    assert!(run.stderr.starts_with("error: the mean FLIP 0.12") && run.stderr.contains("hint: s.png shows where"));
    assert!(folder.join("s.png").is_file());
    let value: Value = serde_json::from_str(&with("0.5", 0).text()).expect("JSON");
    assert_eq!(value["is_above_threshold"], false);
    run_in(&folder, &["diff", "a.png", "a.png", "--threshold", "0"]).expect(0);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = Folder::new("diff-refused");
    let png = encoded(pattern(0), ImageFormat::Png);
    folder.write("a.png", &png);
    folder.write("cut.png", &png[..png.len() / 2]);
    folder.write("small.png", &encoded(RgbImage::new(3, 2), ImageFormat::Png));
    folder.write("text.png", b"no picture");
    folder.write("empty.png", b"");
    write_radiance(&folder, "a.exr", 1.0);
    let odd = |x: usize, y: usize| (if (x, y) == (2, 1) { f32::INFINITY } else { 1.0 }, 1.0_f32, 1.0_f32, 1.0_f32);
    write_rgba_file(folder.join("odd.exr"), WIDTH as usize, HEIGHT as usize, odd).expect("written");
    let before = folder.names();
    refused(&folder, &["a.png", "small.png"], 2, &["a.png has 64x48 pixels", "small.png has 3x2 pixels"]);
    refused(&folder, &["a.png", "a.exr"], 2, &["a.png is for a display", "a.exr holds radiance"]);
    refused(&folder, &["a.exr", "odd.exr"], 1, &["odd.exr: the pixel at column 2, row 1"]);
    refused(&folder, &["a.png", "none.png"], 1, &["none.png: "]);
    refused(&folder, &["a.png", "."], 1, &[".: it is a folder"]);
    refused(&folder, &["a.png", "text.png"], 1, &["text.png: it is neither PNG, JPEG, WebP nor EXR"]);
    refused(&folder, &["a.png", "cut.png"], 1, &["cut.png: it cannot be read as PNG"]);
    refused(&folder, &["a.png", "empty.png"], 1, &["empty.png: the file is empty"]);
    refused(&folder, &["a.png", ""], 2, &["the name of a picture is empty"]);
    refused(&folder, &["a.png"], 2, &["<B>"]);
    refused(&folder, &["a.png", "a.png", "--threshold", "1.5"], 2, &["--threshold", "from 0 to 1"]);
    refused(&folder, &["a.png", "a.png", "--threshold", "-1"], 2, &["--threshold"]);
    refused(&folder, &["a.png", "a.png", "--threshold", "nan"], 2, &["--threshold"]);
    refused(&folder, &["a.png", "a.png", "--pixels-per-degree", "0"], 2, &["--pixels-per-degree", "from 1 to 1000"]);
    refused(&folder, &["a.png", "a.png", "-o", "-"], 2, &["cannot go to standard output"]);
    refused(&folder, &["a.png", "a.png", "-o", "s.jpg"], 2, &["s.jpg does not end in .png"]);
    refused(&folder, &["a.png", "small.png", "-o", "./small.png"], 2, &["would replace the picture small.png"]);
    assert_eq!(folder.names(), before);
    assert!(std::fs::read(folder.join("a.png")).expect("read") == png);
    #[cfg(unix)]
    {
        refused(&folder, &["a.png", "/dev/zero"], 1, &["/dev/zero: it is not a regular file"]);
        std::fs::hard_link(folder.join("a.png"), folder.join("hard.png")).expect("linked");
        refused(&folder, &["a.png", "small.png", "-o", "hard.png"], 2, &["would replace the picture a.png"]);
    }
}
