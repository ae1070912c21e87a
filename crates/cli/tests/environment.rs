//! Pictures of the environment: named by flag, setting and stage; turned; refused; and kept from being overwritten.

use crate::common::{Folder, has_adapter, run_in, run_with, triangle_glb};

/// A Radiance file of 4 by 2 texels: `left` in the half whose directions have x below zero, `right` in the other.
fn picture(left: [u8; 4], right: [u8; 4]) -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    for _ in 0..2 {
        // u = 0 looks along −X, and u = 0.5 along +X.
        [left, right, right, left].iter().for_each(|texel| bytes.extend(texel));
    }
    bytes
}

/// Radiance 1, 0.25, 0; radiance 0, 0.25, 1; shared exponents of 2⁰.
const RED: [u8; 4] = [128, 32, 0, 129];
const BLUE: [u8; 4] = [0, 32, 128, 129];

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("m.glb", &triangle_glb([1.0, 1.0, 1.0]));
    folder.write("red.hdr", &picture(RED, RED));
    folder.write("sides.hdr", &picture(BLUE, RED));
    folder
}

const CAMERA: [&str; 12] = [
    "--size",
    "48x32",
    "--samples",
    "1",
    "--orbit",
    "0,0,4",
    "--target",
    "0,0,0",
    "--tonemap",
    "none",
    "--exposure",
    "0",
];

/// The colours of a picture in the middle, and at the left and the right edge.
fn colours(folder: &Folder, name: &str) -> [[u8; 3]; 3] {
    let picture = image::open(folder.join(name)).expect("a picture").to_rgb8();
    [(24, 16), (0, 16), (47, 16)].map(|(x, y)| picture.get_pixel(x, y).0)
}

fn is_near(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 3)
}

#[test]
fn a_picture_lights_and_is_seen() {
    if !has_adapter() {
        return;
    }
    let folder = folder("environment");
    folder.write("in/red.stage.toml", b"model = \"../m.glb\"\n[environment]\nfile = \"../red.hdr\"\n");
    let render = |input: &str, out: &str, more: &[&str]| {
        run_in(&folder, &[&["render", input, "-o", out, "--quiet"], &CAMERA[..], more].concat()).expect(0);
        colours(&folder, out)
    };
    let even = render("m.glb", "even.png", &["--environment", "1,0.25,0"]);
    let lit = render("m.glb", "lit.png", &["--environment", "red.hdr", "--report", "r.json"]);
    assert!(even.iter().zip(lit).all(|(a, b)| is_near(*a, b)), "{lit:?} instead of {even:?}");
    let text = std::fs::read_to_string(folder.join("r.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(report["input_files"][1]["path"], "red.hdr", "{text}");
    assert_eq!(render("m.glb", "set.png", &["--set", "environment.file=red.hdr"]), lit);
    assert_eq!(render("in/red.stage.toml", "stage.png", &[]), lit);
    let studio = render("in/red.stage.toml", "studio.png", &["--environment", "studio"]);
    assert!(!is_near(studio[0], lit[0]), "a flag comes after the stage");
    assert_eq!(
        render("in/red.stage.toml", "other.png", &["--environment", "sides.hdr"]),
        render("m.glb", "o.png", &["--environment", "sides.hdr"])
    );

    // Blurred, what the camera sees on the right turns to the other colour with the picture, counter-clockwise.
    let seen = |out: &str, degrees: &str| {
        let blurred = ["--environment", "sides.hdr", "--environment-rotation", degrees, "--set", "background.blur=0.5"];
        render("m.glb", out, &[&blurred[..], &["--fov-y", "60"]].concat())
    };
    let [_, left, right] = seen("0.png", "0");
    assert!(left[2] > left[0] + 20 && right[0] > right[2] + 20, "{left:?}, {right:?}");
    let [_, left, right] = seen("180.png", "180");
    assert!(left[0] > left[2] + 20 && right[2] > right[0] + 20, "{left:?}, {right:?}");
    // The camera looks along −Z; what was at +X is there after a turn by 90 degrees.
    let [_, left, right] = seen("90.png", "90");
    assert!(left[0] > left[2] + 20 && right[0] > right[2] + 20, "{left:?}, {right:?}");
    // With a scene's own lights, `auto` takes the picture as well.
    let transparent = render("m.glb", "t.png", &["--environment", "red.hdr", "--background", "000000"]);
    assert_eq!((transparent[0], transparent[1]), (lit[0], [0, 0, 0]));
}

#[test]
fn what_is_no_picture_is_refused_and_what_is_read_is_kept() {
    let folder = folder("environment_refused");
    folder.write("square.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n0000000000000000");
    folder.write("text.exr", b"this is no picture");
    folder.write("half.hdr", &picture(RED, BLUE)[..60]);
    folder.write("bad.stage.toml", b"model = \"m.glb\"\n[environment]\nfile = \"none.hdr\"\n");
    folder.write("red.stage.toml", b"model = \"m.glb\"\n[environment]\nfile = \"red.hdr\"\n");
    let refused = |args: &[&str], code: i32| {
        let run = run_in(&folder, &[&["render"], args, &["--quiet"]].concat());
        run.expect(code).stderr
    };
    if has_adapter() {
        for (file, message) in [
            ("none.hdr", "environment \"none.hdr\""),
            ("square.hdr", "twice as wide as high, and it has 2x2 pixels"),
            ("text.exr", "neither Radiance (.hdr) nor OpenEXR (.exr)"),
            ("half.hdr", "environment \"half.hdr\""),
        ] {
            let said = refused(&["m.glb", "-o", "o.png", "--environment", file], 1);
            assert!(said.contains(message) && said.contains("hint:"), "{file}: {said}");
            assert!(!folder.join("o.png").exists());
        }
        let said = refused(&["bad.stage.toml", "-o", "o.png"], 1);
        assert!(said.contains("bad.stage.toml:3:8: error: cannot read the environment none.hdr"), "{said}");
        let said = refused(&["m.glb", "-o", "o.png", "--environment", "file"], 2);
        assert!(said.contains("none is named"), "{said}");
    }
    let before = std::fs::read(folder.join("red.hdr")).expect("the picture");
    for args in [
        &["m.glb", "-o", "red.hdr", "--format", "png", "--environment", "red.hdr"][..],
        &["m.glb", "--report", "red.hdr", "--set", "environment.file=red.hdr"],
        &["red.stage.toml", "--report", "red.hdr"],
    ] {
        let said = refused(args, 2);
        let is_known = said.contains("the environment red.hdr") || said.contains("`red.hdr` ends as an input does");
        assert!(is_known, "{args:?}: {said}");
    }
    assert!(before == std::fs::read(folder.join("red.hdr")).expect("the picture"));
    refused(&["m.glb", "--environment-rotation", "around"], 2);
    refused(&["m.glb", "--environment", "sunrise"], 2);
}

#[test]
fn six_faces_are_a_picture_and_are_not_overwritten() {
    let folder = folder("environment_cube");
    let face_of = |side: u32, rgb: [u8; 3]| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let picture = image::RgbImage::from_pixel(side, side, image::Rgb(rgb));
        picture.write_to(&mut bytes, image::ImageFormat::Png).expect("a PNG");
        bytes.into_inner()
    };
    let face = |rgb| face_of(4, rgb);
    for name in ["px", "py", "ny", "pz", "nz"] {
        folder.write(&format!("cube/{name}.png"), &face([255, 0, 0]));
    }
    let call = |out: &str| {
        let words = ["render", "m.glb", "-o", out, "--quiet", "--environment", "cube"];
        run_in(&folder, &[&words, &CAMERA[..]].concat())
    };
    let lacking = call("lacking.png").expect(1);
    assert!(lacking.stderr.contains("there is no nx.hdr or .exr"), "{}", lacking.stderr);
    folder.write("cube/nx.png", &face_of(8, [0, 0, 255]));
    let larger = call("larger.png").expect(1);
    assert!(larger.stderr.contains("nx.png: it has 8x8 pixels, and the first face 4x4"), "{}", larger.stderr);
    assert!(!folder.join("larger.png").exists());
    folder.write("cube/nx.png", &face([0, 0, 255]));
    let replaced = call("cube/nx.png").expect(2);
    assert!(replaced.stderr.contains("would replace the environment"), "{}", replaced.stderr);
    if !has_adapter() {
        return;
    }
    call("cube.png").expect(0);
    // The camera looks along −Z, so that +X is on the right; there is the face that is called for −X, as three.js has
    // it.
    let words =
        ["render", "m.glb", "-o", "right.png", "--quiet", "--environment", "cube", "--environment-rotation", "90"];
    run_in(&folder, &[&words, &CAMERA[..]].concat()).expect(0);
    let [_, ahead, _] = colours(&folder, "cube.png");
    let [_, turned, _] = colours(&folder, "right.png");
    assert!(is_near(ahead, [255, 0, 0]) && is_near(turned, [0, 0, 255]), "{ahead:?} {turned:?}");
}

#[test]
fn what_is_made_of_a_picture_is_kept_for_the_next_call() {
    if !has_adapter() {
        return;
    }
    let folder = folder("environment_cache");
    let cache = folder.join("cache");
    let place = cache.display().to_string();
    let render = |out: &str, more: &[&str], off: &str| {
        let args =
            [&["render", "m.glb", "-o", out, "--quiet", "--environment", "sides.hdr"], &CAMERA[..], more].concat();
        run_with(&folder, &args, &[("XDG_CACHE_HOME", &place), ("MANYPASS_NO_CACHE", off)]).expect(0);
        std::fs::read(folder.join(out)).expect("a picture")
    };
    let kept = || -> Vec<std::path::PathBuf> {
        let files = std::fs::read_dir(cache.join("manypass")).into_iter().flatten().flatten();
        files.map(|file| file.path()).collect()
    };
    let truth = render("a.png", &["--no-cache"], "");
    assert!(render("b.png", &[], "1") == truth && kept().is_empty());
    assert!(render("c.png", &[], "") == truth);
    let files = kept();
    assert_eq!(files.len(), 1, "{files:?}");
    let entry = std::fs::read(&files[0]).expect("an entry");
    assert!(render("d.png", &[], "0") == truth);
    assert!(std::fs::read(&files[0]).expect("an entry") == entry);
    // What is broken, or cut, is made again.
    for broken in [&entry[..entry.len() / 2], &[0; 100], b""] {
        std::fs::write(&files[0], broken).expect("a broken entry");
        assert!(render("e.png", &[], "") == truth);
        assert!(std::fs::read(&files[0]).expect("an entry") == entry, "it was not mended");
    }
    // Where the folder cannot be made there is no cache, and nobody is told.
    std::fs::remove_dir_all(&cache).expect("it goes");
    std::fs::write(&cache, b"in the way").expect("a file");
    assert!(render("f.png", &[], "") == truth);
}

#[test]
fn coarser_levels_of_meshes_are_kept_in_the_same_place() {
    if !has_adapter() {
        return;
    }
    let folder = folder("levels_cache");
    let cache = folder.join("cache");
    let place = cache.display().to_string();
    // A wavy sheet of 800 triangles.
    let mut sheet = String::new();
    for i in 0..21 * 21 {
        let (x, y) = (f64::from(i % 21) / 10.0, f64::from(i / 21) / 10.0);
        sheet += &format!("v {x} {y} {}\n", 0.2 * (4.0 * x).sin() * (3.0 * y).cos());
    }
    for i in 0..20 * 20 {
        let at = i / 20 * 21 + i % 20 + 1;
        sheet += &format!("f {at} {} {} {}\n", at + 1, at + 22, at + 21);
    }
    std::fs::write(folder.join("sheet.obj"), sheet).expect("a model");
    let render = |out: &str, more: &[&str]| {
        let coarse = ["--set", "lod.simplify=true", "--set", "lod.error_px=20", "--size", "64x64", "--quiet"];
        let args = [&["render", "sheet.obj", "-o", out], &coarse[..], more].concat();
        run_with(&folder, &args, &[("XDG_CACHE_HOME", &place), ("MANYPASS_NO_CACHE", "")]).expect(0);
        std::fs::read(folder.join(out)).expect("a picture")
    };
    let kept = || -> Vec<String> {
        let files = std::fs::read_dir(cache.join("manypass")).into_iter().flatten().flatten();
        let names = files.map(|file| file.file_name().to_string_lossy().into_owned());
        names.filter(|name| name.starts_with("levels-")).collect()
    };
    let truth = render("a.png", &["--no-cache"]);
    assert!(kept().is_empty());
    let diff = |cached: &[&str]| {
        let models =
            ["diff", "sheet.obj", "sheet.obj", "--set", "lod.simplify=true", "--size", "64x64", "--samples", "1"];
        let places = [("XDG_CACHE_HOME", &*place), ("MANYPASS_NO_CACHE", "")];
        run_with(&folder, &[&models[..], cached].concat(), &places).expect(0);
    };
    diff(&["--no-cache"]);
    assert!(kept().is_empty());
    diff(&[]);
    assert_eq!(kept().len(), 1);
    // Pictures have none.
    let pictures = run_with(&folder, &["diff", "a.png", "a.png", "--no-cache"], &[]).expect(2);
    assert!(pictures.stderr.contains("models"), "{}", pictures.stderr);
    std::fs::remove_dir_all(&cache).expect("it goes");
    assert!(render("b.png", &[]) == truth && kept().len() == 1, "{:?}", kept());
    assert!(render("c.png", &[]) == truth && kept().len() == 1);
    assert!(render("d.png", &["--set", "lod.enabled=false"]) != truth);
    // Many calls at once.
    let render = &render;
    std::thread::scope(|scope| {
        let calls = ["e.png", "f.png", "g.png"].map(|out| scope.spawn(move || render(out, &[])));
        calls.into_iter().for_each(|call| assert!(call.join().expect("a picture") == truth));
    });
}

/// A PNG of one texel.
fn texel(rgb: [u8; 3]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let picture = image::RgbImage::from_pixel(1, 1, image::Rgb(rgb));
    picture.write_to(&mut bytes, image::ImageFormat::Png).expect("a PNG");
    bytes.into_inner()
}

#[test]
fn light_of_a_picture_comes_from_files_which_are_kept() {
    let folder = folder("environment_light");
    folder.write("blue.hdr", &picture(BLUE, BLUE));
    folder.write("level_0.hdr", &picture(RED, RED));
    folder.write("level_1.hdr", &picture(BLUE, BLUE));
    // Nothing is mirrored.
    folder.write("none.png", &texel([0, 0, 0]));
    folder.write(
        "in/light.stage.toml",
        b"model = \"../m.glb\"\n[environment]\nfile = \"../red.hdr\"\nirradiance_file = \"../blue.hdr\"\nbrdf_file = \"../none.png\"\n",
    );
    let irradiance = ["--set", "environment.irradiance_file=blue.hdr"];
    let table = ["--set", "environment.brdf_file=none.png"];
    let call =
        |input: &str, more: &[&str]| run_in(&folder, &[&["render", input, "--quiet"], &CAMERA[..], more].concat());
    for args in [&irradiance[..], &["--environment", "red.hdr", "--set", "environment.prefiltered_file=blue.hdr"]] {
        let replaced = call("m.glb", &[args, &["--report", "blue.hdr"]].concat()).expect(2);
        assert!(replaced.stderr.contains("the environment blue.hdr") || replaced.stderr.contains("ends as an input"));
    }
    let replaced = call("in/light.stage.toml", &["-o", "none.png"]).expect(2);
    assert!(replaced.stderr.contains("would replace the environment"), "{}", replaced.stderr);
    if !has_adapter() {
        return;
    }
    let report = |name: &str| -> Vec<String> {
        let text = std::fs::read_to_string(folder.join(name)).expect("a report");
        let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let files = report["input_files"].as_array().expect("files");
        files.iter().map(|file| file["path"].as_str().unwrap_or_default().to_owned()).collect()
    };
    let named = ["--environment", "red.hdr", "-o", "set.png", "--report", "set.json"];
    call("m.glb", &[&named[..], &irradiance, &table].concat()).expect(0);
    let [matte, behind, _] = colours(&folder, "set.png");
    // 0, 0.25 and 1 in sRGB, before the picture.
    assert!(is_near(matte, [0, 137, 255]) && is_near(behind, [255, 137, 0]), "{matte:?} before {behind:?}");
    assert_eq!(report("set.json"), ["m.glb", "red.hdr", "blue.hdr", "none.png"]);
    call("in/light.stage.toml", &["-o", "stage.png"]).expect(0);
    assert_eq!(colours(&folder, "stage.png"), colours(&folder, "set.png"));
    // A picture that a flag names has its own light.
    call("in/light.stage.toml", &["-o", "flag.png", "--environment", "sides.hdr"]).expect(0);
    call("m.glb", &[&["-o", "own.png", "--environment", "sides.hdr"], &table[..]].concat()).expect(0);
    assert_eq!(colours(&folder, "flag.png"), colours(&folder, "own.png"));
    // Levels are the picture, too.
    let levels = ["--set", "environment.prefiltered_file=level_{level}.hdr", "-o", "levels.png", "--report", "l.json"];
    call("m.glb", &levels).expect(0);
    let [_, behind, _] = colours(&folder, "levels.png");
    assert!(is_near(behind, [255, 137, 0]), "{behind:?}");
    assert_eq!(report("l.json"), ["m.glb", "level_0.hdr", "level_1.hdr"]);
    for (args, code, message) in [
        (["-o", "o.png", "--set", "environment.irradiance_file=blue.hdr"], 2, "and none is named"),
        (["-o", "o.png", "--set", "environment.prefiltered_file=red.hdr"], 1, "it has one level"),
        (["-o", "o.png", "--set", "environment.brdf_file=red.png"], 1, "environment \"red.png\""),
        (["-o", "o.png", "--set", "environment.brdf_file=/dev/null"], 1, "not a regular file"),
    ] {
        if cfg!(unix) || !args[3].contains("/dev") {
            let said = call("m.glb", &args).expect(code).stderr;
            assert!(said.contains(message) && said.contains("hint:") && !folder.join("o.png").exists(), "{said}");
        }
    }
}
