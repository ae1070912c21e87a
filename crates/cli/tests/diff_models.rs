//! `diff` of two models: which part of them changed, where, and what is refused.

use crate::common::{Folder, has_adapter, run_in, triangle_glb};
use serde_json::Value;

const FRAME: [&str; 4] = ["--size", "96x64", "--samples", "4"];

fn json(folder: &Folder, args: &[&str]) -> Value {
    let run = run_in(folder, &[&["diff"], args, &FRAME, &["--json"]].concat()).expect(0);
    assert_eq!(run.stderr, "");
    serde_json::from_str(&run.text()).expect("JSON")
}

/// The shares of geometry, material and light.
fn changed(value: &Value) -> [f64; 3] {
    ["geometry", "material", "light"].map(|part| value["changed"][part].as_f64().expect("a share"))
}

fn variable<'a>(value: &'a Value, name: &str) -> &'a Value {
    let variables = value["variables"].as_array().expect("variables");
    variables.iter().find(|variable| variable["name"] == name).expect("the variable")
}

/// A triangle in the plane z = 0 that is `width` metres wide and `height` high.
fn stl(width: f32, height: f32) -> String {
    format!(
        "solid t\nfacet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex {width} 0 0\nvertex 0 0 {height}\nendloop\n\
         endfacet\nendsolid t\n"
    )
}

#[test]
fn the_part_that_changed_is_named() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("diff-models");
    folder.write("red.glb", &triangle_glb([0.8, 0.1, 0.1]));
    folder.write("blue.glb", &triangle_glb([0.1, 0.1, 0.8]));
    folder.write("brighter.stage.toml", b"model = \"red.glb\"\n[environment]\nintensity = 2.0\n");
    folder.write("small.stl", stl(1.0, 1.0).as_bytes());
    folder.write("wide.stl", stl(2.0, 1.0).as_bytes());

    let same = json(&folder, &["red.glb", "red.glb", "--threshold", "0"]);
    assert_eq!((&same["flip"]["mean"], changed(&same)), (&0.0.into(), [0.0; 3]), "{same}");
    assert!(same["variables"].as_array().is_some_and(|variables| variables.len() == 13), "{same}");

    let paint = json(&folder, &["red.glb", "blue.glb"]);
    let [geometry, material, light] = changed(&paint);
    assert!(geometry == 0.0 && material == 1.0 && light == 0.0, "{paint}");
    let base = variable(&paint, "base_color");
    // Linear 0.8 - 0.1, stored in bytes of sRGB.
    assert!(base["share"] == 1.0 && (base["mean"].as_f64().expect("a number") - 0.7).abs() < 0.01, "{paint}");
    assert!(["depth", "normal", "roughness", "object_id"].iter().all(|name| variable(&paint, name)["share"] == 0.0));
    assert!(paint["flip"]["mean"].as_f64() > Some(0.05), "{paint}");

    let lit = json(&folder, &["red.glb", "brighter.stage.toml"]);
    let [geometry, material, light] = changed(&lit);
    assert!(geometry == 0.0 && material == 0.0 && light > 0.99, "{lit}");

    let front = ["--orbit", "0,0,auto"];
    let shape = json(&folder, &[&["small.stl", "wide.stl"], &front[..]].concat());
    // Half of the wide triangle is the small one; pixels at the edge between them are lit by samples of both.
    let [geometry, material, light] = changed(&shape);
    assert!((geometry - 0.5).abs() < 0.03 && material == 0.0 && light < 0.06, "{shape}");
    assert!((shape["only"]["b"].as_f64().expect("a share") - geometry).abs() < 1e-9 && shape["only"]["a"] == 0.0);
    // The camera sees the wide one whole: it stands where one for the wide one alone does.
    let alone = json(&folder, &[&["wide.stl", "wide.stl"], &front[..]].concat());
    assert_eq!(shape["camera"]["eye_world_m"], alone["camera"]["eye_world_m"]);
}

#[test]
fn the_sheet_has_a_row_for_each_variable_that_differs() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("diff-models-sheet");
    folder.write("red.glb", &triangle_glb([0.8, 0.1, 0.1]));
    folder.write("blue.glb", &triangle_glb([0.1, 0.1, 0.8]));
    let with = |more: &[&str], code: i32| {
        run_in(&folder, &[&["diff", "red.glb", "blue.glb", "-o", "s.png"], &FRAME[..], more].concat()).expect(code)
    };
    let run = with(&["--threshold", "0.01"], 5);
    let text = run.text();
    assert!(text.contains("material in 100.00 %") && text.contains("  depth            same"), "{text}");
    assert!(text.contains("  base_color       100.00 % of pixels, mean 0.6"), "{text}");
    assert!(run.stderr.contains("hint: s.png shows where"), "{}", run.stderr);
    let all = image::open(folder.join("s.png")).expect("a sheet").to_rgb8();
    // What changed is told by all variables, listed or not.
    let depth_alone = with(&["--aov", "depth"], 0).text();
    assert!(depth_alone.contains("material in 100.00 %") && !depth_alone.contains("base_color"), "{depth_alone}");
    // One variable less is a row less.
    with(&["--aov", "base_color"], 0);
    let one = image::open(folder.join("s.png")).expect("a sheet").to_rgb8();
    assert!(one.height() < all.height() && one.width() == all.width(), "{}, {}", one.height(), all.height());
    let has = |wanted: [u8; 3]| one.pixels().any(|pixel| (0..3).all(|c| pixel.0[c].abs_diff(wanted[c]) < 6));
    // The base colours of both in sRGB.
    assert!(has([231, 89, 89]) && has([89, 89, 231]));
}

#[test]
fn what_are_not_two_models_is_refused() {
    let folder = Folder::new("diff-models-refused");
    folder.write("red.glb", &triangle_glb([0.8, 0.1, 0.1]));
    folder.write("a.png", b"");
    let refused = |args: &[&str], code: i32, parts: &[&str]| {
        let run = run_in(&folder, &[&["diff"], args].concat()).expect(code);
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{args:?}: {}", run.stderr);
        assert!(run.stdout.is_empty(), "{args:?}");
    };
    refused(&["red.glb", "a.png"], 2, &["red.glb is a model, but a.png is a picture", "manypass render red.glb"]);
    refused(&["a.png", "red.glb"], 2, &["red.glb is a model, but a.png is a picture"]);
    refused(&["a.png", "a.png", "--orbit", "30,20,auto"], 2, &["are pictures, and some flags are for models"]);
    refused(&["a.png", "a.png", "--adapter", "x"], 2, &["some flags are for models"]);
    refused(&["red.glb", "none.glb"], 1, &["none.glb"]);
    refused(&["red.glb", "red.glb", "--aov", "colour"], 2, &["unknown AOV `colour`"]);
    refused(&["red.glb", "red.glb", "--path", "forward"], 2, &["only --path deferred has AOVs"]);
    refused(&["red.glb", "red.glb", "-o", "red.glb"], 2, &["does not end in .png"]);
    folder.write("m.gltf", br#"{"asset":{"version":"2.0"},"images":[{"uri":"t.png"}]}"#);
    folder.write("t.png", b"x");
    refused(&["m.gltf", "red.glb", "-o", "t.png"], 2, &["would replace a file that m.gltf names"]);
    assert_eq!(std::fs::read(folder.join("t.png")).expect("read"), b"x");
}
