//! Pictures, from the command line to the file.

use crate::common::{Folder, Run, has_adapter, run_in, run_with_input, triangle_glb};
use image::RgbaImage;
use std::path::Path;

const SMALL: [&str; 4] = ["--size", "64x36", "--samples", "1"];

fn render(folder: &Path, args: &[&str]) -> Run {
    run_in(folder, &[&["render"], args, &SMALL].concat())
}

fn picture(path: &Path) -> RgbaImage {
    image::open(path).expect("a picture").to_rgba8()
}

/// The mean difference of channels, of 255.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.as_raw().len() as f64
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn the_hall_renders_the_same_bytes_twice_and_nearly_the_same_forward() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("hall");
    for out in ["a.png", "b.png"] {
        render(&folder, &["demo:hall", "-o", out]).expect(0);
    }
    render(&folder, &["demo:hall", "-o", "forward.png", "--path", "forward"]).expect(0);
    assert_eq!(folder.names(), ["a.png", "b.png", "forward.png"]);
    let a = picture(&folder.join("a.png"));
    assert_eq!(a.dimensions(), (64, 36));
    assert!(a.pixels().any(|p| p.0[0] > 60) && a.pixels().any(|p| p.0[0] < 40), "the hall is lit, and not everywhere");
    assert!(std::fs::read(folder.join("a.png")).expect("a") == std::fs::read(folder.join("b.png")).expect("b"));
    let forward = picture(&folder.join("forward.png"));
    assert!(difference(&a, &forward) < 0.5, "{}", difference(&a, &forward));
    // The comparison would find a wrong picture.
    assert!(difference(&a, &image::imageops::flip_vertical(&a)) > 2.0);
    assert!(difference(&a, &RgbaImage::new(64, 36)) > 2.0);
}

#[test]
fn the_hall_has_settings_of_its_own_which_others_replace() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("hall_settings");
    let bytes = |out: &str, flags: &[&str]| {
        render(&folder, &[&["demo:hall", "-o", out], flags].concat()).expect(0);
        std::fs::read(folder.join(out)).expect("a picture")
    };
    let own = bytes("own.png", &[]);
    assert!(own == bytes("told.png", &["--set", "chain=bloom", "--set", "bloom.strength=0.12"]));
    let bare = bytes("bare.png", &["--set", "chain="]);
    assert!(own != bare && bare == bytes("disabled.png", &["--set", "bloom.enabled=false"]));
    assert!(own != bytes("more.png", &["--set", "bloom.strength=0.4"]));
    let measured = run_in(&folder, &["bench", "demo:hall", "--size", "64x36", "--count", "1", "--json"]).expect(0);
    let last = json(measured.text().lines().last().expect("a line of JSON"));
    assert_eq!(last["info"]["effects"], serde_json::json!([]), "what is measured is bare");
    // A stage of the user's has its own.
    folder.write("a.stage.toml", b"model = \"demo:hall\"\n");
    render(&folder, &["a.stage.toml", "-o", "stage.png"]).expect(0);
    assert!(bare == std::fs::read(folder.join("stage.png")).expect("a picture"));
}

#[test]
fn an_effect_changes_the_picture_and_a_wrong_one_is_named() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("effect");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    let swap =
        b"@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return radiance_at(vec2i(p.xy)).bgra; }";
    folder.write("swap.wgsl", swap);
    folder.write("back.wgsl", swap);
    folder.write("wrong.wgsl", b"@fragment fn fs() -> @location(0) vec4f {\n    return nothing; }");
    let plain = ["tri.glb", "-o", "a.png", "--background", "000000"];
    render(&folder, &plain).expect(0);
    let once = ["tri.glb", "-o", "b.png", "--background", "000000", "--effect", "swap.wgsl"];
    render(&folder, &once).expect(0);
    let twice = ["tri.glb", "-o", "c.png", "--background", "000000", "--effect", "swap.wgsl", "--effect", "back.wgsl"];
    render(&folder, &twice).expect(0);
    let [a, b] = ["a.png", "b.png"].map(|name| picture(&folder.join(name)));
    assert!(difference(&a, &b) > 5.0, "{}", difference(&a, &b));
    assert!(a.pixels().zip(b.pixels()).all(|(a, b)| a.0[0].abs_diff(b.0[2]) <= 1 && a.0[2].abs_diff(b.0[0]) <= 1));
    assert!(difference(&a, &picture(&folder.join("c.png"))) < 0.01, "swapped twice");
    for (file, expected) in [("wrong.wgsl", "wrong.wgsl:2:12"), ("absent.wgsl", "absent.wgsl")] {
        let run = render(&folder, &["tri.glb", "-o", "d.png", "--effect", file]).expect(1);
        assert!(run.stderr.contains(expected), "{}", run.stderr);
        assert!(!folder.join("d.png").exists());
    }
}

#[test]
fn a_chain_is_that_of_the_stage_the_file_or_the_command_line() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("chain");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    let channel = |name: &str, what: &str| {
        let text = format!(
            "//! pixel: changed
            // = 1 in 0..1
            @group(2) @binding(0) var<uniform> share: f32;
            fn changed(color: vec4f, position: vec2f) -> vec4f {{ return mix(color, color.{what}, share); }}"
        );
        folder.write(&format!("fx/{name}.wgsl"), text.as_bytes());
    };
    // Red becomes green, and green blue; the other way round nothing is left of red but green.
    channel("green", "brga");
    channel("grey", "ggga");
    folder.write("fx/s.toml", b"chain = [\"green.wgsl\", \"grey.wgsl\"]\n[bloom]\nstrength = 0.5\n[grey]\nshare = 1\n");
    folder.write(
        "fx/a.stage.toml",
        b"model = \"../tri.glb\"\n[effects]\nchain = [\"grey.wgsl\"]\n[settings.grey]\nshare = 1\n",
    );
    let mean = |name: &str| {
        let picture = picture(&folder.join(name));
        let sum = |channel: usize| picture.pixels().map(|pixel| u64::from(pixel.0[channel])).sum::<u64>();
        [0, 1, 2].map(|channel| sum(channel) / u64::from(picture.width() * picture.height()))
    };
    let drawn = |output: &str, args: &[&str]| {
        render(&folder, &[args, &["-o", output, "--background", "000000", "--ground", "none"]].concat()).expect(0);
        mean(output)
    };
    let [red, green, blue] = drawn("a.png", &["tri.glb"]);
    assert!(red > green + 10 && green.abs_diff(blue) < 8, "{red} {green} {blue}");
    let [r, g, b] = drawn("b.png", &["tri.glb", "--settings", "fx/s.toml"]);
    assert!(r.abs_diff(red) < 2 && g.abs_diff(red) < 2 && b.abs_diff(red) < 2, "grey of red: {r} {g} {b}");
    // --set comes after the file, and what the file says of others does nothing.
    let [r, g, b] =
        drawn("c.png", &["tri.glb", "--settings", "fx/s.toml", "--set", "chain=fx/grey.wgsl,fx/green.wgsl"]);
    assert!(r.abs_diff(green) < 2 && g.abs_diff(green) < 2 && b.abs_diff(green) < 2, "grey of green: {r} {g} {b}");
    let [r, g, _] = drawn("d.png", &["fx/a.stage.toml"]);
    assert!(r.abs_diff(green) < 2 && g.abs_diff(green) < 2, "the stage's: {r} {g}");
    let [r, g, _] = drawn("e.png", &["fx/a.stage.toml", "--settings", "fx/s.toml", "--set", "grey.enabled=false"]);
    assert!(g.abs_diff(red) < 2 && r < red, "the file's, after the stage's: {r} {g}");
    assert_eq!(drawn("f.png", &["fx/a.stage.toml", "--set", "effects.enabled=false"]), [red, green, blue]);
    // What is said of effects that only the stage lists, or that are left out of its chain, is no mistake.
    assert_eq!(drawn("g.png", &["fx/a.stage.toml", "--set", "grey.enabled=false"]), [red, green, blue]);
    assert_eq!(drawn("h.png", &["fx/a.stage.toml", "--set", "chain="]), [red, green, blue]);
    folder.write("fx/s.cube", b"LUT_1D_SIZE 2\n1 1 1\n0 0 0\n");
    let [r, g, _] = drawn("i.png", &["tri.glb", "--effect", "fx/green.wgsl", "--set", "chain=fx/s.cube,fx/green.wgsl"]);
    assert!(r + 20 > 255 - green && g < r, "inverted after green: {r} {g}");
    for (args, code, expected) in [
        (["--set", "chain=glue"], 2, "no effect is called `glue`"),
        (["--set", "chain=bloom,bloom"], 2, "`bloom` cannot be used here: it stands twice in the chain"),
        (["--set", "chain=fx/none.wgsl"], 1, "fx/none.wgsl"),
        (["--set", "grey.share=0.5"], 2, "need --effect NAME|FILE.wgsl"),
    ] {
        let run = render(&folder, &[&["tri.glb", "-o", "x.png"], &args[..]].concat()).expect(code);
        assert!(run.stderr.contains(expected), "{}", run.stderr);
    }
    let run = render(&folder, &["fx/a.stage.toml", "-o", "fx/grey.wgsl", "--format", "png"]).expect(2);
    assert!(run.stderr.contains("grey.wgsl"), "{}", run.stderr);
    let plan = run_in(&folder, &["graph", "tri.glb", "--settings", "fx/s.toml"]).expect(0).text();
    assert!(plan.contains("green+grey"), "{plan}");
}

#[test]
fn orbits_begin_with_a_minus_in_one_word_or_two() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("orbit");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    render(&folder, &["tri.glb", "-o", "a.png", "--orbit", "-30,10,2"]).expect(0);
    render(&folder, &["tri.glb", "-o", "b.png", "--orbit=-30,10,2"]).expect(0);
    render(&folder, &["tri.glb", "-o", "c.png", "--orbit=30,10,2"]).expect(0);
    let [a, b, c] = ["a.png", "b.png", "c.png"].map(|name| picture(&folder.join(name)));
    assert!(a == b && a != c);
}

#[test]
fn what_fails_leaves_nothing_behind() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("fails");
    let glb = triangle_glb([1.0, 1.0, 1.0]);
    folder.write("tri.glb", &glb);
    folder.write("cut.glb", &glb[..glb.len() / 2]);
    let run = render(&folder, &["cut.glb"]).expect(1);
    assert!(run.stderr.starts_with("error: cut.glb: ") && !run.stderr.contains("cut.glb: cut.glb"), "{}", run.stderr);
    let run = render(&folder, &["gone.glb"]).expect(1);
    assert!(
        run.stderr.starts_with("error: gone.glb: ") && !run.stderr.contains("gone.glb: gone.glb"),
        "{}",
        run.stderr
    );
    let run = render(&folder, &["tri.glb", "-o", "tri.glb/x.png"]).expect(1);
    assert!(run.stderr.contains("tri.glb"), "{}", run.stderr);
    let run = render(&folder, &["tri.glb", "--adapter", "no such adapter"]).expect(3);
    assert!(run.stderr.contains("manypass adapters"), "{}", run.stderr);
    let run = render(&folder, &["tri.glb", "--camera", "Side"]).expect(2);
    assert!(run.stderr.contains("Side"), "{}", run.stderr);
    let run = render(&folder, &["tri.glb", "--animation", "Walk"]).expect(2);
    assert!(run.stderr.contains("Slide"), "{}", run.stderr);
    assert_eq!(folder.names(), ["cut.glb", "tri.glb"]);
}

#[test]
fn standard_input_and_output_carry_the_same_picture() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("stdio");
    let glb = triangle_glb([0.2, 0.8, 0.2]);
    folder.write("tri.glb", &glb);
    render(&folder, &["tri.glb"]).expect(0);
    let args = [&["render", "-", "-o", "-", "--format", "png"], &SMALL[..]].concat();
    let run = run_with_input(&folder, &args, &glb).expect(0);
    assert!(run.stdout == std::fs::read(folder.join("tri.png")).expect("written"));
}

#[test]
fn a_batch_goes_on_after_a_broken_file_and_skips_what_is_there() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("batch");
    folder.write("models/a.glb", &triangle_glb([1.0, 0.0, 0.0]));
    folder.write("models/b.glb", b"glTF but not really");
    folder.write("models/c.glb", &triangle_glb([0.0, 0.0, 1.0]));
    let run = render(&folder, &["models", "-o", "out/", "--report", "r.jsonl"]).expect(1);
    assert!(run.stderr.contains("b.glb") && run.stderr.contains("1 of 3 inputs failed"), "{}", run.stderr);
    let [a, c] = ["out/a.png", "out/c.png"].map(|name| picture(&folder.join(name)));
    assert_ne!(a, c);
    assert!(!folder.join("out/b.png").exists());
    let report = std::fs::read_to_string(folder.join("r.jsonl")).expect("report");
    let lines: Vec<serde_json::Value> = report.lines().map(json).collect();
    assert_eq!(lines.len(), 3);
    assert!(lines[1]["error"].is_string() && lines[2]["milliseconds"]["total"].as_f64() > Some(0.0));

    std::fs::write(folder.join("out/a.png"), b"mine").expect("written");
    std::fs::remove_file(folder.join("out/c.png")).expect("removed");
    std::fs::remove_file(folder.join("models/b.glb")).expect("removed");
    render(&folder, &["models", "-o", "out/", "--skip-existing"]).expect(0);
    assert_eq!(std::fs::read(folder.join("out/a.png")).expect("kept"), b"mine");
    assert_eq!(picture(&folder.join("out/c.png")), c);
}

#[test]
fn frames_follow_the_animation() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("frames");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let camera = ["--eye", "0,0,6", "--target", "0,0,0"];
    render(&folder, &[&["tri.glb", "--frames", "0..2", "--fps", "2", "-o", "{frame:03}.png"], &camera[..]].concat())
        .expect(0);
    render(&folder, &[&["tri.glb", "--animation", "Slide", "-o", "start.png"], &camera[..]].concat()).expect(0);
    render(&folder, &[&["tri.glb", "--time", "1", "-o", "end.png"], &camera[..]].concat()).expect(0);
    let at = |name: &str| picture(&folder.join(name));
    assert_eq!(at("000.png"), at("start.png"));
    assert_eq!(at("002.png"), at("end.png"));
    assert_ne!(at("000.png"), at("001.png"));
    assert!(!folder.join("003.png").exists());
}

#[test]
fn effects_go_on_from_frame_to_frame_of_a_sequence() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("keeps");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    let count = "//! effect count\n//! reads: display, previous\n@fragment\n\
        fn fs_count(@builtin(position) position: vec4f) -> @location(0) vec4f {\n\
        let pixel = vec2i(position.xy);\n\
        return max(vec4f(textureLoad(previous, pixel, 0).rgb + 0.1, 1.0), 0.0 * display_at(pixel));\n}\n";
    folder.write("count.wgsl", count.as_bytes());
    let same = ["tri.glb", "--effect", "count.wgsl", "--ground", "none", "--background", "000000", "--size", "16x9"];
    for samples in ["1", "5"] {
        let words = ["--samples", samples, "--turntable", "4", "--frames", "0..2", "-o", "{frame}.png"];
        run_in(&folder, &[&["render"], &same[..], &words].concat()).expect(0);
        // 0.1, 0.2 and 0.3 in sRGB: the effect adds to what it made in the frame before.
        for (frame, expected) in [89u8, 124, 149].into_iter().enumerate() {
            let corner = picture(&folder.join(&format!("{frame}.png"))).get_pixel(0, 0).0[0];
            assert!(corner.abs_diff(expected) <= 1, "{samples} samples, frame {frame}: {corner}, not {expected}");
        }
    }
    // A still has none before it.
    run_in(&folder, &[&["render"], &same[..], &["--samples", "1", "-o", "still.png"]].concat()).expect(0);
    assert!(picture(&folder.join("still.png")).get_pixel(0, 0).0[0].abs_diff(89) <= 1);
}

#[test]
fn exr_files_hold_the_layers() {
    if !has_adapter() {
        return;
    }
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let folder = Folder::new("exr");
    render(&folder, &["demo:hall", "-o", "a.exr", "--aov", "all"]).expect(0);
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = reader.from_file(folder.join("a.exr")).expect("EXR");
    let channels = |name: &str| -> Vec<String> {
        let mut layers = image.layer_data.iter();
        let layer = layers.find(|layer| layer.attributes.layer_name.as_ref().is_some_and(|n| n.eq(name)));
        let layer = layer.unwrap_or_else(|| panic!("no layer {name}"));
        assert_eq!((layer.size.0, layer.size.1), (64, 36));
        layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect()
    };
    assert_eq!(channels("rgba"), ["A", "B", "G", "R"]);
    assert_eq!(channels("depth"), ["Z"]);
    assert_eq!(channels("normal"), ["X", "Y", "Z"]);
    assert_eq!(channels("base_color"), ["B", "G", "R"]);
}

#[test]
fn reports_passes_and_contact_sheets_are_written() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("report");
    let flags = ["--aov", "depth", "--report", "r.json", "--dump-passes", "passes", "--contact-sheet", "sheet.png"];
    // With shadows the one sample would be several frames, and the numbers those of the last.
    let bare = ["demo:hall", "--set", "shadows.enabled=false"];
    render(&folder, &[&bare, &flags[..]].concat()).expect(0);
    let report = json(&std::fs::read_to_string(folder.join("r.json")).expect("report"));
    for key in ["start", "load", "decode", "upload", "compile", "frames", "readback", "encode", "total"] {
        assert!(report["milliseconds"][key].as_f64() >= Some(0.0), "{key}");
    }
    let count = |key: &str| report[key].as_u64().unwrap_or_else(|| panic!("no {key}"));
    // Of the one sample, for which all is new.
    assert!(["bind_groups_made", "pipelines_made", "uploaded_bytes"].iter().all(|key| count(key) > 0), "{report}");
    assert!(count("lights") > 1000 && count("draws") > 0 && count("triangles") > 0 && count("texture_bytes") > 0);
    // A list holds every light that reaches its pixels, so what is in range is visited.
    assert!(count("pairs_visited") >= count("pairs_in_range") && count("pairs_in_range") >= count("pairs_shaded"));
    assert!(count("pairs_shaded") > 0);
    let passes = report["passes"].as_array().expect("passes");
    assert!(passes.len() > 5 && passes.iter().all(|pass| pass["cpu_ms"].as_f64() >= Some(0.0)), "{passes:?}");
    // Each with its draw calls and bytes, as in the table for people.
    let sum = |key: &str| passes.iter().filter_map(|pass| pass[key].as_u64()).sum::<u64>();
    assert!(["draws", "read_bytes", "written_bytes"].iter().all(|key| sum(key) > 0), "{passes:?}");
    // The software adapter has timestamps.
    assert!(passes.iter().filter_map(|pass| pass["gpu_ms"].as_f64()).sum::<f64>() > 0.0, "{passes:?}");
    let range = report["depth_range_m"].as_array().expect("range");
    assert!(range[0].as_f64() > Some(0.0) && range[0].as_f64() < range[1].as_f64());
    let depth = image::open(folder.join("hall.depth.png")).expect("depth");
    assert_eq!((depth.color(), depth.width()), (image::ColorType::L16, 64));
    let passes = std::fs::read_dir(folder.join("passes")).expect("passes").count();
    assert!(passes >= 5 && picture(&folder.join("sheet.png")).width() > 128);

    // Several samples have a pass that adds them up, in the plan and among the pictures.
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 1.0]));
    let flags = ["--size", "64x36", "--samples", "2", "--dump-passes", "two", "--report", "two.json"];
    run_in(&folder, &[&["render", "tri.glb"], &flags[..]].concat()).expect(0);
    let report = json(&std::fs::read_to_string(folder.join("two.json")).expect("report"));
    let has_mean = |list: &serde_json::Value| list.to_string().contains("accumulate");
    assert!(
        has_mean(&report["passes"]) && has_mean(&report["plan"]) && has_mean(&report["outputs"]["passes"]),
        "{report}"
    );
}

#[test]
fn bench_ends_with_a_line_of_json() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("bench");
    let text = run_in(&folder, &["bench", "demo:hall", "--size", "64x36", "--count", "4", "--png", "b.png"]).expect(0);
    let text = text.text();
    assert!(text.contains("median"), "{text}");
    let value = json(text.lines().last().expect("a line"));
    assert_eq!(value["frames"].as_array().map(Vec::len), Some(4));
    // Before it, a table has a row for every pass, and their sum.
    let (_, table) = text.split_once("\npass ").expect("a table");
    let passes = value["info"]["passes"].as_array().expect("passes");
    let names = passes.iter().map(|pass| pass["name"].as_str().expect("a name"));
    let rows: Vec<&str> = table.lines().skip(1).take(passes.len() + 1).collect();
    assert!(names.chain(["sum"]).zip(&rows).all(|(name, row)| row.starts_with(&format!("{name} "))), "{text}");
    assert!(rows.len() == passes.len() + 1 && rows.iter().all(|row| row.chars().count() <= 100), "{text}");
    // Each pass says how many draws it takes: together those of surfaces, and one for the whole picture.
    let draws = |name: &str| passes.iter().find(|pass| pass["name"] == name).and_then(|pass| pass["draws"].as_u64());
    let (opaque, others) = (draws("geometry").expect("draws"), draws("forward").expect("draws"));
    assert!(opaque > 0 && Some(opaque + others) >= value["info"]["draws"].as_u64(), "{text}");
    assert_eq!(draws("tone_map"), Some(1), "{text}");
    let sum: u64 = passes.iter().map(|pass| pass["draws"].as_u64().expect("draws")).sum();
    let last = rows.last().expect("a sum").split_whitespace().nth(3);
    assert!(text.contains("  draws  ") && last == Some(sum.to_string().as_str()), "{text}");
    assert!(value["timeToFirstFrame"].as_f64() > Some(0.0) && value["info"]["lights"].as_u64() > Some(1000));
    assert!(value["info"]["visited_over_in_range"].as_f64() >= Some(1.0));
    assert_eq!(picture(&folder.join("b.png")).dimensions(), (64, 36));
    let budget = ["bench", "demo:hall", "--size", "64x36", "--count", "1000", "--budget-ms", "1", "--json"];
    let value = json(&run_in(&folder, &budget).expect(0).text());
    assert_eq!(value["frames"].as_array().map(Vec::len), Some(1));
}

#[test]
fn bench_of_the_first_frame_draws_it_and_measures_nothing_else() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("bench-first");
    let shadowed = ["--set", "shadows.enabled=true", "--set", "shadows.maps=40", "--json"];
    let first = ["bench", "demo:hall", "--size", "64x36", "--first-frame", "--png", "b.png"];
    let value = json(&run_in(&folder, &[&first[..], &shadowed[..]].concat()).expect(0).text());
    assert_eq!(value["frames"].as_array().map(Vec::len), Some(0));
    let info = &value["info"];
    assert!(info["first_frame_ms"].as_f64() > Some(0.0) && info["pairs_visited"].is_null(), "{info}");
    assert!(info["shadow_tiles_drawn_first"].as_u64() > Some(4), "{info}");
    assert_eq!(info["shadow_tiles_drawn_first"], info["shadows"]["tiles_drawn"], "the first frame is the last");
    assert_eq!(picture(&folder.join("b.png")).dimensions(), (64, 36));
}

#[test]
fn graphs_print_in_every_format() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("graph");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 1.0]));
    let graph = |format| run_in(&folder, &["graph", "tri.glb", "--format", format]).expect(0).text();
    assert!(graph("text").contains("geometry"));
    assert!(json(&graph("json"))["plan"]["passes"].as_array().is_some_and(|passes| passes.len() > 3));
    assert!(graph("mermaid").starts_with("flowchart"));
    // A long name is cut, and keeps its beginning.
    let table = graph("table");
    let plan = json(&graph("json"));
    let passes = plan["plan"]["passes"].as_array().expect("passes").iter();
    let mut starts =
        passes.clone().map(|pass| pass["name"].as_str().and_then(|name| name.get(..6)).unwrap_or_default());
    assert!(starts.all(|start| table.lines().any(|line| line.starts_with(start))), "{table}");
    assert!(table.starts_with("pass ") && table.contains("Rgba16Float") && table.contains("\nsum "), "{table}");
    assert!(table.lines().all(|line| line.chars().count() <= 100), "{table}");
    // The one triangle is a draw of its own.
    let geometry = passes.clone().find(|pass| pass["name"] == "geometry");
    assert_eq!(geometry.and_then(|pass| pass["draws"].as_u64()), Some(1), "{table}");
    assert!(table.lines().next().is_some_and(|titles| titles.contains("  draws  ")), "{table}");
    assert!(json(&run_in(&folder, &["adapters", "--json"]).expect(0).text())[0]["name"].is_string());
}
