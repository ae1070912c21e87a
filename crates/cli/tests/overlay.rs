//! What a stage draws over its pictures: text at named pixels, in stills, sequences and linear files, and what is wrong.

use crate::common::{Folder, has_adapter, run_in, triangle_glb};

/// Black, and a letter of 32 pixels at (4, 0): its pixels are those of `crates/render/tests/overlay.rs`.
const LETTER: &str = "model = \"m.glb\"\n[settings.background]\nsource = \"000000\"\n[settings.environment]\nsource = \"none\"\n\
    [[overlay]]\ntext = \"H\"\nsize_px = 32\nposition = [4, 0]\n[[overlay]]\nsprite = \"dot.png\"\nposition = [-1, -1]\n";

const CAMERA: [&str; 4] = ["--size", "64x48", "--orbit", "0,0,40"];

fn folder(name: &str, stage: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("m.glb", &triangle_glb([0.0, 0.0, 0.0]));
    folder.write("labels.stage.toml", stage.as_bytes());
    image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 0, 0, 255])).save(folder.join("dot.png")).expect("written");
    folder
}

fn assert_labelled(folder: &Folder, name: &str) {
    let picture = image::open(folder.join(name)).expect("a picture").to_rgb8();
    for (x, y) in [(8, 8), (22, 8), (23, 29), (15, 17)] {
        assert_eq!(picture.get_pixel(x, y).0, [255; 3], "{name}: {x} {y}");
    }
    for (x, y) in [(62, 46), (61, 45)] {
        assert_eq!(picture.get_pixel(x, y).0, [255, 0, 0], "{name}: {x} {y}");
    }
    for (x, y) in [(15, 26), (63, 47), (60, 44)] {
        assert_eq!(picture.get_pixel(x, y).0, [0; 3], "{name}: {x} {y}");
    }
}

#[test]
fn every_picture_of_a_stage_has_its_text_at_named_pixels() {
    if !has_adapter() {
        return;
    }
    let folder = folder("overlay", LETTER);
    let render =
        |more: &[&str]| run_in(&folder, &[&["render", "labels.stage.toml", "--quiet"], &CAMERA[..], more].concat());
    render(&["-o", "one.png", "--samples", "1"]).expect(0);
    render(&["-o", "many.png", "--samples", "5", "--report", "many.json"]).expect(0);
    render(&["-o", "turn-{frame}.png", "--samples", "1", "--turntable", "2"]).expect(0);
    for name in ["one.png", "many.png", "turn-0.png", "turn-1.png"] {
        assert_labelled(&folder, name);
    }
    let report = std::fs::read_to_string(folder.join("many.json")).expect("a report");
    assert!(report.contains("dot.png"), "what the overlay reads is among the files: {report}");
    // What a stage reads is never overwritten.
    let run = render(&["-o", "dot.png", "--samples", "1"]);
    run.expect(2);
}

#[test]
fn what_is_wrong_with_an_overlay_is_told_with_its_place() {
    let with = |item: &str| format!("model = \"m.glb\"\n[[overlay]]\n{item}\n");
    for (name, stage, expected) in [
        ("missing", with("sprite = \"gone.png\""), "labels.stage.toml:3:10: error:"),
        (
            "font",
            with("text = \"a\"\nfont = \"m.glb\""),
            "labels.stage.toml:4:8: error: `m.glb` is not a readable font",
        ),
        ("empty", with("text = \" \""), "labels.stage.toml:3:8: error: the text is empty"),
        (
            "huge",
            with("text = \"a\"\nsize_px = 1e30"),
            "labels.stage.toml:4:11: error: `1e30` is not a value of `size_px`",
        ),
        (
            "node",
            with("text = \"a\"\nnode = \"Door\""),
            "labels.stage.toml:4:8: error: the model has no node called `Door`",
        ),
    ] {
        let folder = folder(&format!("overlay-{name}"), &stage);
        let run = run_in(&folder, &["info", "labels.stage.toml"]);
        assert!(run.code != 0 && run.stderr.contains(expected), "{name}: {}", run.stderr);
    }
}
