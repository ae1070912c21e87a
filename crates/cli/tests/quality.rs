//! A budget of time for live frames, and what tiers do to textures.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{Folder, run_in};
use serde_json::Value;

fn live(folder: &Folder, more: &[&str]) -> Value {
    let bench = ["bench", "demo:materials", "--live", "--size", "96x54", "--json"];
    let text = run_in(folder, &[&bench, more].concat()).expect(0).text();
    serde_json::from_str(text.lines().last().unwrap()).unwrap()
}

#[test]
fn a_budget_chooses_settings_and_says_which() {
    let folder = Folder::new("budget");
    // Whatever the machine: no frame takes a microsecond, and every one takes less than a hundred seconds.
    let tiny = live(&folder, &["--count", "12", "--set", "quality.budget_ms=0.001"]);
    let chosen = &tiny["info"]["quality"];
    assert_eq!((chosen["rung"].as_str(), chosen["changes"].as_u64()), (Some("low, 0.25"), Some(1)));
    assert_eq!(chosen["settings"]["render.scale"].as_f64(), Some(0.25));
    assert_eq!(tiny["info"]["settings"]["render"]["scale"].as_f64(), Some(0.25));
    assert!(
        chosen["median_ms"].as_f64().is_some_and(|ms| ms > 0.0) && chosen["settled_after_frames"].as_u64() > Some(2)
    );
    let huge = live(&folder, &["--count", "12", "--set", "quality.budget_ms=100000"]);
    assert_eq!(huge["info"]["quality"]["rung"].as_str(), Some("ultra"));
    assert_eq!(huge["info"]["quality"]["settings"]["occlusion.resolution"].as_str(), Some("full"));
    // What is chosen by hand stays, and a tier is the best.
    let by_hand = ["--count", "12", "--quality", "high", "--set", "reflections.enabled=false"];
    let high = live(&folder, &[&by_hand[..], &["--set", "quality.budget_ms=100000"]].concat());
    assert_eq!(high["info"]["quality"]["rung"].as_str(), Some("high"));
    assert_eq!(high["info"]["settings"]["reflections"]["enabled"].as_bool(), Some(false));
    let none = live(&folder, &["--count", "1"]);
    assert_eq!(none["info"]["quality"], Value::Null);
    let summary =
        ["bench", "demo:materials", "--live", "--size", "96x54", "--count", "9", "--set", "quality.budget_ms=0.001"];
    let summary = run_in(&folder, &summary).expect(0).text();
    assert!(summary.contains("quality: `low, 0.25` for 0.001 ms a frame, after "), "{summary}");
    assert!(summary.contains("more than the budget, and this is the last rung"), "{summary}");
    assert!(summary.contains("\n  render.scale = 0.25\n"), "{summary}");
}

#[test]
fn stills_refuse_a_budget_and_live_frames_bad_ones() {
    let folder = Folder::new("no-budget");
    let set = ["--set", "quality.budget_ms=16"];
    for args in [&["render", "demo:materials"][..], &["graph", "demo:materials"], &["bench", "demo:materials"]] {
        let run = run_in(&folder, &[args, &set].concat()).expect(2);
        assert!(run.stderr.contains("quality.budget_ms=16 is for live drawing"), "{}", run.stderr);
        assert!(run.stderr.contains("bench --live"), "{}", run.stderr);
    }
    for value in ["-1", "nan", "inf", "1e6", "16ms"] {
        let set = format!("quality.budget_ms={value}");
        let run = run_in(&folder, &["bench", "demo:materials", "--live", "--set", &set]).expect(2);
        assert!(run.stderr.contains("from 0 to 100000"), "{value}: {}", run.stderr);
    }
}

#[test]
fn low_is_drawn_with_smaller_textures() {
    let folder = Folder::new("max-px");
    let texture = folder.join("wide.png");
    image::RgbImage::from_fn(2048, 16, |x, _| image::Rgb([(x % 251) as u8, 90, 20])).save(texture).unwrap();
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"wide.png"}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
        {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
        "buffers":[{"uri":"tri.bin","byteLength":60}]}"#;
    folder.write("tri.gltf", json.as_bytes());
    let floats = [0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    folder.write("tri.bin", &floats.map(f32::to_le_bytes).concat());
    let bytes = |more: &[&str]| {
        let bench = ["bench", "tri.gltf", "--live", "--size", "16x16", "--count", "1", "--json"];
        let text = run_in(&folder, &[&bench, more].concat()).expect(0).text();
        let line: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        line["info"]["scene_bytes"].as_u64().unwrap()
    };
    let texels = |width: u32, height: u32| {
        (0..=width.ilog2()).map(|mip| u64::from((width >> mip).max(1) * (height >> mip).max(1))).sum::<u64>()
    };
    let whole = bytes(&[]);
    assert_eq!(whole - bytes(&["--quality", "low"]), 4 * (texels(2048, 16) - texels(1024, 8)));
    assert_eq!(whole - bytes(&["--set", "textures.max_px=100"]), 4 * (texels(2048, 16) - texels(64, 1)));
    assert_eq!(bytes(&["--quality", "low", "--set", "textures.max_px=0"]), whole);
}
