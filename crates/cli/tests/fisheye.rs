//! Fisheye pictures as the program draws them.

use crate::common::{Folder, has_adapter, run_in, triangle_glb};
use serde_json::Value;

const FISHEYE: &str = "render tri.glb --size 96x64 --eye 0,0,3 --target 0,0,0 --background transparent \
    --set camera.fisheye=equisolid --set camera.fisheye_fov_deg=200";

fn args(more: &str) -> Vec<&str> {
    FISHEYE.split_whitespace().chain(more.split_whitespace()).collect()
}

#[test]
fn a_fisheye_is_drawn_reported_and_described() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("fisheye");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let run = run_in(&folder, &args("--samples 4 -o a.png --report report.json --contact-sheet sheet.png")).expect(0);
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    let picture = image::open(folder.join("a.png")).expect("a picture").to_rgba8();
    assert!(picture.get_pixel(48, 32).0[3] == 255 && picture.get_pixel(20, 32).0[3] == 0);
    let text = std::fs::read_to_string(folder.join("report.json")).expect("a report");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let (views, ray_px) = (&report["fisheye"]["views"], report["fisheye"]["ray_px"].as_f64().expect("a number"));
    assert!(views[0]["name"] == "front" && views.as_array().map(Vec::len) == Some(5), "{views}");
    assert!(views[0]["width"].as_u64() > Some(32) && ray_px > 1.0 && ray_px <= 1.5001, "{views} {ray_px}");
    let camera = &report["camera"];
    assert!(camera["kind"] == "fisheye" && camera["opencv"].is_null() && camera["fov_y_deg"].is_null(), "{camera}");
    assert!(camera["fisheye"]["map"] == "equisolid" && camera["fisheye"]["radius_px"] == 32.0, "{camera}");
    // An EXR file says the same, and nothing of a projection that it has not.
    run_in(&folder, &args("--samples 2 -o a.exr")).expect(0);
    let image = exr::prelude::read_first_rgba_layer_from_file(
        folder.join("a.exr"),
        |size, _| vec![[0f32; 4]; size.area()],
        |pixels, at, (r, g, b, a): (f32, f32, f32, f32)| pixels[at.1 * 96 + at.0] = [r, g, b, a],
    )
    .expect("an EXR file");
    let attributes = &image.layer_data.attributes;
    assert!(attributes.world_to_camera.is_some() && attributes.world_to_normalized_device.is_none());
    assert!(attributes.vertical_field_of_view.is_none());
    assert!(image.layer_data.channel_data.pixels[32 * 96 + 48][3] == 1.0);
    // Nothing is in view behind the camera but for a fisheye.
    let run = run_in(&folder, &args("--target 0,0.4,4 --up 0,1,0 -o behind.png")).expect(0);
    assert!(run.stderr.contains("the picture is empty"), "{}", run.stderr);
    let run = run_in(&folder, &args("--target 1,0,3 --fov-y 30 -o beside.png")).expect(0);
    assert!(!run.stderr.contains("empty") && run.stderr.contains("--fov-y does nothing"), "{}", run.stderr);
    let beside = image::open(folder.join("beside.png")).expect("a picture").to_rgba8();
    let left = beside.enumerate_pixels().filter(|(x, _, pixel)| *x < 24 && pixel.0[3] > 0).count();
    assert!(left > 10, "a quarter turn to the left: {left}");
}

#[test]
fn what_a_fisheye_does_without_is_refused_in_words() {
    let folder = Folder::new("fisheye-refused");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    for (more, expected) in [
        ("--aov depth -o a.png", "a fisheye picture has no AOVs"),
        ("--set occlusion.enabled=true -o a.png", "needs `occlusion.enabled=false`"),
        ("--set camera.f_stop=2 --samples 4 -o a.png", "needs `camera.f_stop=0`"),
        ("--set camera.fisheye_fov_deg=221 -o a.png", "takes a number from 1 to 220"),
        ("--set camera.fisheye=fish -o a.png", "takes none, equidistant, equisolid or stereographic"),
    ] {
        let run = run_in(&folder, &args(more)).expect(2);
        assert!(run.stderr.contains(expected), "{more}: {}", run.stderr);
    }
    if has_adapter() {
        let run = run_in(&folder, &args("--ortho-height 3 -o a.png")).expect(1);
        assert!(run.stderr.contains("camera.fisheye") && run.stderr.contains("parallel rays"), "{}", run.stderr);
    }
}
