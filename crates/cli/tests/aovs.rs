//! Variables and `render.scale`, from the command line to the file.

use crate::common::{Folder, has_adapter, run_in, triangle_glb};
use exr::prelude::{FlatImage, FlatSamples, ReadChannels, ReadLayers, read};
use std::path::Path;

const NAMES: [&str; 14] = [
    "base_color",
    "occlusion",
    "occlusion_screen",
    "normal",
    "normal_view",
    "position",
    "depth",
    "metallic",
    "roughness",
    "emission",
    "motion",
    "object_id",
    "material_id",
    "radiance",
];

/// Sees the triangle from 6 m: a metre at its distance is `18 / (6 · tan 22.5°)` pixels.
const CAMERA: [&str; 6] = ["--eye", "0,0,6", "--target", "0,0,0", "--samples", "1"];
const METRE_PX: f32 = 7.242_64;

fn opened(path: &Path) -> FlatImage {
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    reader.from_file(path).expect("EXR")
}

fn samples(image: &FlatImage, layer: &str, channel: &str) -> FlatSamples {
    let named = image.layer_data.iter().find(|l| l.attributes.layer_name.as_ref().is_some_and(|name| name.eq(layer)));
    let layer_data = named.unwrap_or_else(|| panic!("no layer {layer}"));
    assert_eq!((layer_data.size.0, layer_data.size.1), (64, 36), "{layer}");
    let mut channels = layer_data.channel_data.list.iter();
    let found = channels.find(|c| c.name.eq(channel)).unwrap_or_else(|| panic!("no channel {layer}.{channel}"));
    found.sample_data.clone()
}

fn floats(image: &FlatImage, layer: &str, channel: &str) -> Vec<f32> {
    match samples(image, layer, channel) {
        FlatSamples::F32(values) => values,
        other => panic!("{layer}.{channel} is {other:?}"),
    }
}

fn ids(image: &FlatImage, layer: &str) -> Vec<u32> {
    match samples(image, layer, "Id") {
        FlatSamples::U32(values) => values,
        other => panic!("{layer} is {other:?}"),
    }
}

#[test]
fn every_variable_of_a_moving_triangle_is_right() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("aov-exr");
    folder.write("tri.glb", &triangle_glb([0.2, 0.5, 0.8]));
    // At 0.5 s it has moved by 1 m along x, and by 0.4 m since 0.3 s.
    let args = ["render", "tri.glb", "-o", "a.exr", "--aov", "all", "--time", "0.5", "--fps", "5", "--size", "64x36"];
    run_in(&folder, &[&args[..], &CAMERA].concat()).expect(0);
    let image = opened(&folder.join("a.exr"));
    assert_eq!(image.layer_data.len(), NAMES.len() + 1);
    let (depth, object, material) =
        (floats(&image, "depth", "Z"), ids(&image, "object_id"), ids(&image, "material_id"));
    let [x, y, z] = ["X", "Y", "Z"].map(|channel| floats(&image, "position", channel));
    let [right, down] = ["X", "Y"].map(|channel| floats(&image, "motion", channel));
    let mut covered = 0;
    for at in 0..64 * 36 {
        assert_eq!((object[at], material[at]), if depth[at].is_finite() { (1, 1) } else { (0, 0) });
        if depth[at].is_infinite() {
            assert_eq!((right[at], down[at]), (0.0, 0.0));
            continue;
        }
        covered += 1;
        assert!((depth[at] - 6.0).abs() < 1e-4, "depth {}", depth[at]);
        assert!(
            (right[at] - 0.4 * METRE_PX).abs() < 0.05 && down[at].abs() < 0.05,
            "motion {} {}",
            right[at],
            down[at]
        );
        let pixel = [32.0 + x[at] * METRE_PX, 18.0 - y[at] * METRE_PX];
        let center = [(at % 64) as f32 + 0.5, (at / 64) as f32 + 0.5];
        assert!((pixel[0] - center[0]).abs() < 0.01 && (pixel[1] - center[1]).abs() < 0.01, "{pixel:?} {center:?}");
        assert!(z[at].abs() < 1e-4);
    }
    // Half of 2 × 2 m.
    let expected = 2.0 * METRE_PX * METRE_PX;
    assert!((covered as f32 - expected).abs() < 0.1 * expected, "{covered} pixels");
    assert!(floats(&image, "emission", "G").iter().all(|value| *value == 0.0));
    assert_eq!(floats(&image, "radiance", "B"), floats(&image, "rgba", "B"));
    let blue = floats(&image, "base_color", "B").into_iter().fold(0.0f32, f32::max);
    assert!((blue - 0.8).abs() < 0.01, "{blue}");
    assert_eq!(floats(&image, "normal_view", "Z").into_iter().fold(0.0f32, f32::max), 1.0);
}

#[test]
fn motion_follows_frames_and_turntables_and_is_0_without_time() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("aov-motion");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 1.0]));
    // The last picture: motion and position of every pixel of the triangle.
    let motion = |name: &str, args: &[&str]| -> Vec<[f32; 4]> {
        let common = ["render", "tri.glb", "-o", name, "--aov", "motion,position,depth", "--size", "64x36"];
        run_in(&folder, &[&common[..], &["--samples", "1"], args].concat()).expect(0);
        let last = folder.names().into_iter().rfind(|file| file.ends_with(".exr")).expect("a file");
        let image = opened(&folder.join(&last));
        folder.names().iter().filter(|file| file.ends_with(".exr")).for_each(|file| {
            std::fs::remove_file(folder.join(file)).expect("removed");
        });
        let values = [("motion", "X"), ("motion", "Y"), ("position", "X"), ("position", "Y")];
        let values = values.map(|(layer, channel)| floats(&image, layer, channel));
        let depth = floats(&image, "depth", "Z");
        let covered: Vec<_> =
            (0..depth.len()).filter(|at| depth[*at].is_finite()).map(|at| values.each_ref().map(|v| v[at])).collect();
        assert!(covered.len() > 50);
        covered
    };
    let near = |values: &[[f32; 4]], expected: f32| {
        values.iter().all(|[right, down, ..]| (right - expected).abs() < 0.05 && down.abs() < 0.05)
    };
    let camera = ["--eye", "0,0,6", "--target", "0,0,0"];
    let frames = motion("f{frame}.exr", &[&["--frames", "0..1", "--fps", "4"], &camera[..]].concat());
    assert!(near(&frames, 0.5 * METRE_PX), "{frames:?}");
    assert!(near(&motion("still.exr", &camera), 0.0));
    // The first keyframe holds before the animation begins.
    assert!(near(&motion("start.exr", &[&["--time", "0"], &camera[..]].concat()), 0.0));
    // From 340° to 350°.
    let turned = motion("t{frame:02}.exr", &["--turntable", "36", "--orbit", "0,0,6", "--target", "0,0,0"]);
    let mut largest = 0.0f32;
    for [right, down, x, y] in turned {
        let pixel = |yaw_deg: f32| {
            let (sin, cos) = yaw_deg.to_radians().sin_cos();
            [x * cos, -y].map(|plane_m| plane_m * 6.0 * METRE_PX / (6.0 - x * sin))
        };
        let (now, before) = (pixel(350.0), pixel(340.0));
        assert!((right - (now[0] - before[0])).abs() < 0.05 && (down - (now[1] - before[1])).abs() < 0.05, "{x} {y}");
        largest = largest.max(right.abs());
    }
    assert!(largest > 0.3, "the test cannot fail: {largest} px");
}

#[test]
fn png_files_of_all_variables_are_written_and_listed_by_help() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("aov-png");
    folder.write("tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    let args = ["render", "tri.glb", "-o", "{stem}_{aov}.png", "--aov", "all", "--size", "64x36"];
    run_in(&folder, &[&args[..], &CAMERA].concat()).expect(0);
    let help = run_in(&folder, &["render", "--help"]).expect(0).text();
    for name in NAMES {
        let picture = image::open(folder.join(&format!("tri_{name}.png"))).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!((picture.width(), picture.height()), (64, 36), "{name}");
        assert!(help.contains(name), "--help does not name {name}");
    }
}

#[test]
fn the_size_of_the_output_is_the_size_asked_for_at_every_scale() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("scale");
    folder.write("tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    for scale in ["render.scale=0.5", "render.scale=1", "render.scale=2", "render.scale=0.3"] {
        let args = ["render", "tri.glb", "-o", "a.exr", "--aov", "all", "--size", "64x36", "--set", scale];
        run_in(&folder, &[&args[..], &CAMERA].concat()).expect(0);
        let image = opened(&folder.join("a.exr"));
        assert_eq!(floats(&image, "rgba", "R").len(), 64 * 36);
        assert_eq!(ids(&image, "object_id").len(), 64 * 36);
        let args = ["render", "tri.glb", "-o", "a.png", "--size", "63x37", "--set", scale];
        run_in(&folder, &[&args[..], &CAMERA].concat()).expect(0);
        let picture = image::open(folder.join("a.png")).expect("PNG");
        assert_eq!((picture.width(), picture.height()), (63, 37), "{scale}");
    }
}

#[test]
fn the_compression_of_exr_changes_the_size_alone() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exr-compression");
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    let drawn = |name: &str| {
        let file = format!("{name}.exr");
        let args = ["render", "tri.glb", "-o", &file, "--aov", "depth,object_id", "--size", "64x36"];
        run_in(&folder, &[&args[..], &CAMERA[..], &["--exr-compression", name]].concat()).expect(0);
        let (path, image) = (folder.join(&file), opened(&folder.join(&file)));
        let values = [floats(&image, "rgba", "R"), floats(&image, "rgba", "A"), floats(&image, "depth", "Z")];
        (values, ids(&image, "object_id"), std::fs::metadata(path).expect("a file").len())
    };
    let (values, of_object, plain_bytes) = drawn("none");
    assert!(of_object.iter().any(|id| *id != of_object[0]), "the triangle is seen");
    for name in ["zip", "zips", "rle", "piz"] {
        let packed = drawn(name);
        assert!(packed.0 == values && packed.1 == of_object, "{name}");
        assert!(packed.2 < plain_bytes, "{name}: {} of {plain_bytes} bytes", packed.2);
    }
    let run = run_in(&folder, &["render", "tri.glb", "-o", "a.png", "--exr-compression", "zip"]).expect(2);
    assert!(run.stderr.contains("--exr-compression is of .exr"), "{}", run.stderr);
}
