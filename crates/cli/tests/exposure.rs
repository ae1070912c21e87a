//! Exposure and bright light from the command line.

#![allow(clippy::expect_used, reason = "a test says what it expects by panicking")]

use crate::common::{Folder, has_adapter, run_in};
use exr::prelude::{FlatImage, FlatSamples, ReadChannels, ReadLayers, read};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// A file whose lamp of `intensity_cd` moves away from a box within 2 s.
fn lamp(intensity_cd: f64) -> String {
    let corners = [[-1, -1], [1, -1], [-1, 1], [1, 1]];
    let mut buffer: Vec<f32> = corners.iter().flat_map(|[x, z]| [*x as f32 * 2.0, 0.0, *z as f32 * 2.0]).collect();
    buffer.extend([0.0, 1.0, 0.0].repeat(4));
    buffer.extend([0.0, 2.0, 0.0, 1.0, 0.0, 0.5, 6.0, 0.5]);
    let mut bytes: Vec<u8> = buffer.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0u16, 2, 1, 1, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    let mut uri = String::from("data:application/octet-stream;base64,");
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0u32, |word, byte| word << 8 | u32::from(*byte)) << (8 * (3 - chunk.len()));
        for digit in 0..4 {
            let letter = DIGITS[(word >> (18 - 6 * digit) & 63) as usize];
            let _ = write!(uri, "{}", if digit > chunk.len() { '=' } else { char::from(letter) });
        }
    }
    let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let accessor = |view: usize, kind: &str, count: usize| json!({ "bufferView": view, "componentType": 5126, "type": kind, "count": count, "min": [-2, 0, -2], "max": [2, 1, 2] });
    let mut times = accessor(2, "SCALAR", 2);
    (times["min"], times["max"]) = (json!([0]), json!([2]));
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": intensity_cd }] } },
        "nodes": [{ "mesh": 0 }, { "translation": [0, 1, 0.5], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 4, "material": 0 }] }],
        "animations": [{ "samplers": [{ "input": 2, "output": 3 }], "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }] }],
        "accessors": [accessor(0, "VEC3", 4), accessor(1, "VEC3", 4), times, accessor(3, "VEC3", 2),
            { "bufferView": 4, "componentType": 5123, "type": "SCALAR", "count": 6 }],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 8), view(104, 24), view(128, 12)],
        "buffers": [{ "byteLength": bytes.len(), "uri": uri }],
    })
    .to_string()
}

fn report(folder: &Folder, name: &str) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join(name)).expect("a report");
    let lines = text.lines().map(serde_json::from_str).collect::<Result<Vec<Value>, _>>();
    lines.unwrap_or_else(|_| vec![serde_json::from_str(&text).expect("one value")])
}

#[test]
fn a_frame_is_the_same_alone_and_in_its_range() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-frames");
    folder.write("lamp.gltf", lamp(4e4).as_bytes());
    let common = ["--size", "48x48", "--samples", "2", "--fps", "1", "--quiet", "--orbit", "20,50,7"];
    let render = |more: &[&str]| {
        let args: Vec<&str> = ["render", "lamp.gltf"].iter().chain(&common).chain(more).copied().collect();
        run_in(&folder, &args).expect(0);
    };
    render(&["--frames", "0..2", "-o", "range/{frame:04}.png", "--report", "range.json"]);
    render(&["--time", "2", "-o", "time.png", "--report", "time.json"]);
    let bytes = |name: &str| std::fs::read(folder.join(name)).expect("a picture");
    assert!(bytes("range/0002.png") == bytes("time.png"), "frame 2 alone differs");
    assert!(bytes("range/0000.png") != bytes("time.png"), "the test shows nothing");
    // All of them take the exposure of time 0, which is far from 0 stops.
    let (lines, time) = (report(&folder, "range.json"), report(&folder, "time.json"));
    assert!(lines.iter().all(|line| line["exposure"] == time[0]["exposure"]), "{lines:?}");
    assert_eq!(time[0]["exposure"]["mode"], "auto");
    assert!(time[0]["exposure"]["stops"].as_f64() < Some(-4.0), "{}", time[0]["exposure"]);
    assert!(time[0]["exposure"]["log_average_luminance"].as_f64() > Some(100.0));
    // A number is that number, whatever is metered for the faint studio; `auto+1` is one stop more.
    render(&["--time", "0", "--exposure", "-3", "-o", "number.png", "--report", "number.json"]);
    let number = &report(&folder, "number.json")[0]["exposure"];
    assert_eq!((&number["mode"], number["stops"].as_f64()), (&json!("stops"), Some(-3.0)));
    render(&["--time", "0", "--exposure", "auto+1", "-o", "plus.png", "--report", "plus.json"]);
    let stops = |name: &str| report(&folder, name)[0]["exposure"]["stops"].as_f64().unwrap_or(f64::NAN);
    assert!((stops("plus.json") - stops("time.json") - 1.0).abs() < 1e-5);
}

#[test]
fn exr_holds_a_million_candela() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-exr");
    folder.write("lamp.gltf", lamp(1e6).as_bytes());
    let args = "render lamp.gltf -o out.exr --size 33x33 --samples 2 --quiet --environment none --report r.json";
    let camera = ["--eye", "0,4,0.5", "--target", "0,0,0.5", "--fov-y", "20", "--exposure", "1"];
    let args: Vec<&str> = args.split(' ').chain(camera).collect();
    run_in(&folder, &args).expect(0);
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image: FlatImage = reader.non_parallel().from_file(folder.join("out.exr")).expect("an EXR");
    let channels = &image.layer_data[0].channel_data.list;
    let green = channels.iter().find(|channel| channel.name.eq("G")).expect("green");
    let FlatSamples::F32(green) = &green.sample_data else { panic!("floats") };
    // Lambert, less what the surface reflects as a mirror: about 0.8 / π · 10⁶ cd / 1 m².
    let middle = green[16 * 33 + 16];
    assert!((200_000.0..300_000.0).contains(&middle), "{middle}");
    let report = &report(&folder, "r.json")[0];
    assert_eq!((&report["clamped_pixels"], &report["warnings"]), (&json!(0), &json!([])));
    assert!(report["exposure"]["pre_exposure_stops"].as_i64() < Some(-10), "{}", report["exposure"]);
}

#[test]
fn exr_holds_numbers_whatever_the_intensity() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-extremes");
    let lamps = [("strongest", 3.4e38), ("weakest", 1e-44), ("strong", 1e20)];
    for (name, intensity) in lamps {
        folder.write(&format!("{name}.gltf"), lamp(intensity).as_bytes());
    }
    // Without metering, and with the exposure that multiplies most.
    let args = "render strongest.gltf weakest.gltf strong.gltf -o out/ --format exr --size 16x16 --samples 2 --quiet";
    let more = "--exposure 64 --eye 0,4,0.5 --target 0,0,0.5 --fov-y 20 --environment studio";
    run_in(&folder, &args.split(' ').chain(more.split(' ')).collect::<Vec<_>>()).expect(0);
    for (name, _) in lamps {
        let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let path = folder.join("out").join(format!("{name}.exr"));
        let image: FlatImage = reader.non_parallel().from_file(path).expect("an EXR");
        for channel in &image.layer_data[0].channel_data.list {
            let FlatSamples::F32(values) = &channel.sample_data else { panic!("floats") };
            assert!(values.iter().all(|value| value.is_finite() && *value >= 0.0), "{name} {}", channel.name);
        }
    }
}

#[test]
fn the_demo_states_its_exposure() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-demo");
    let run = |out: &str, more: &[&str]| {
        let args = ["render", "demo:hall", "-o", out, "--size", "64x36", "--samples", "1", "--quiet"];
        run_in(&folder, &args.iter().chain(more).copied().collect::<Vec<_>>()).expect(0);
        std::fs::read(folder.join(out)).expect("a picture")
    };
    let stated = run("a.png", &["--report", "r.json"]);
    assert!(stated == run("b.png", &["--exposure", "0", "--environment", "none"]));
    let exposure = &report(&folder, "r.json")[0]["exposure"];
    assert_eq!((&exposure["mode"], exposure["stops"].as_f64()), (&json!("stops"), Some(0.0)));
}

#[test]
fn presets_are_whole_sets_and_flags_come_after_them() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-presets");
    folder.write("lamp.gltf", lamp(4e4).as_bytes());
    folder.write("s.stage.toml", b"model = \"lamp.gltf\"\n[settings.tone_map]\ncurve = \"aces\"\n");
    let of = |input: &str, more: &[&str]| {
        let common = ["render", input, "--size", "16x16", "--samples", "1", "-o", "p.png", "--report", "r.json"];
        run_in(&folder, &[&common, more].concat()).expect(0);
        report(&folder, "r.json").remove(0)
    };
    let source = |value: &Value| value["settings"]["environment"]["source"].clone();
    let product = of("lamp.gltf", &["--preset", "product"]);
    assert_eq!((source(&product), &product["exposure"]["mode"]), (json!("studio"), &json!("stops")));
    assert_eq!((&product["lights"], &product["settings"]["ground"]["mode"]), (&json!(0), &json!("shadow")));
    let scene = of("lamp.gltf", &["--preset", "scene"]);
    assert_eq!(
        (source(&scene), &scene["exposure"]["mode"], &scene["lights"]),
        (json!("none"), &json!("auto"), &json!(1))
    );
    let data = of("s.stage.toml", &["--preset", "data", "--exposure", "1"]);
    assert_eq!((source(&data), data["exposure"]["stops"].as_f64()), (json!("none"), Some(1.0)));
    assert_eq!(data["settings"]["tone_map"]["curve"], "none", "it comes after the stage");
    let sky = of("lamp.gltf", &["--preset", "scene", "--environment", "sky"]);
    assert_eq!(source(&sky), "sky");
    assert_eq!(run_in(&folder, &["render", "lamp.gltf", "--preset", "nice"]).code, 2);
}

#[test]
fn by_day_lamps_of_a_model_file_are_weak_and_those_of_a_stage_as_they_are() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-lamps-by-day");
    folder.write("lamp.gltf", lamp(4e4).as_bytes());
    folder.write("s.stage.toml", b"model = \"lamp.gltf\"\n");
    let stops = |input: &str, more: &[&str]| {
        let common = ["render", input, "--size", "16x16", "--samples", "1", "-o", "p.png", "--report", "r.json"];
        run_in(&folder, &[&common, more].concat()).expect(0);
        report(&folder, "r.json").remove(0)["exposure"]["lamp_stops"].as_f64()
    };
    let by_day = stops("lamp.gltf", &["--environment", "sky"]);
    assert!(by_day.is_some_and(|stops| (-15.0..-4.0).contains(&stops)), "{by_day:?}");
    assert_eq!(stops("lamp.gltf", &["--environment", "sky", "--environment-intensity", "32768"]), Some(0.0));
    assert_eq!(stops("lamp.gltf", &["--environment", "sky", "--exposure", "1"]), Some(0.0));
    assert_eq!(stops("lamp.gltf", &[]), Some(0.0));
    assert_eq!(stops("s.stage.toml", &["--environment", "sky"]), Some(0.0));
}

#[test]
fn a_picture_of_one_tone_says_so_once_a_sequence() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-tone");
    folder.write("lamp.gltf", lamp(4e4).as_bytes());
    let of = |more: &[&str]| {
        let common = ["render", "lamp.gltf", "--size", "32x32", "--samples", "1", "--strict", "--report", "r.json"];
        let run = run_in(&folder, &[&common, more].concat()).expect(0);
        let hints: usize =
            report(&folder, "r.json").iter().map(|line| line["hints"].to_string().matches("99 %").count()).sum();
        (run.stderr.matches("hint: lamp.gltf: 99 % of the picture or more is").count(), hints, run.stderr)
    };
    let dark = ["--environment", "none", "--exposure", "-40"];
    for output in ["d.png", "d.exr"] {
        let (said, reported, text) = of(&[&dark[..], &["-o", output]].concat());
        assert_eq!((said, reported), (1, 1), "{output}: {text}");
        assert!(text.contains("black: --exposure auto"), "{text}");
    }
    let (said, reported, text) = of(&[&dark[..], &["--frames", "0..2", "--fps", "1", "-o", "d{frame}.png"]].concat());
    assert!(said == 1 && reported >= 1, "{said} {reported}: {text}");
    let (said, _, text) = of(&["--environment", "none", "--exposure", "40", "-o", "w.png", "--orbit", "0,90,0.5"]);
    assert!(said == 1 && text.contains("white: --exposure auto"), "{text}");
    let (said, _, text) = of(&["--background", "336699", "--ground", "none", "--orbit", "0,30,60", "-o", "e.png"]);
    assert!(said == 1 && text.contains("the background: --orbit"), "{text}");
    for quiet in [&["--aov", "depth", "-o", "a.png"][..], &["--background", "transparent", "-o", "t.png"]] {
        assert_eq!(of(&[&dark[..], quiet].concat()).0, 0, "{quiet:?}");
    }
}

#[test]
fn most_of_a_model_below_16_of_255_gets_a_hint() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-dark");
    folder.write("lit.gltf", lamp(4e4).as_bytes());
    // A second plate, which has the lamp below it and is seen from above.
    let mut model: Value = serde_json::from_str(&lamp(4e4)).expect("JSON");
    let nodes = model["nodes"].as_array_mut().expect("nodes");
    nodes.push(json!({ "mesh": 0, "translation": [4.5, 1.5, 0] }));
    model["scenes"][0]["nodes"] = json!([0, 1, 2]);
    folder.write("dark.gltf", model.to_string().as_bytes());
    let of = |input: &str, more: &[&str]| {
        let common = ["render", input, "--size", "64x64", "--samples", "1", "--background", "transparent", "--strict"];
        let run = run_in(&folder, &[&common[..], &["-o", "p.png", "--report", "r.json"], more].concat()).expect(0);
        let hints = report(&folder, "r.json")[0]["hints"].clone();
        let first = hints[0].as_str().unwrap_or_default().to_owned();
        assert_eq!(run.stderr.matches("is darker than 16 of 255").count(), first.matches("16 of 255").count());
        first
    };
    let alone = ["--environment", "none"];
    let said = of("dark.gltf", &alone);
    let end = " % of the visible model is darker than 16 of 255: --preset product shows it in the studio, and \
               --environment fill adds a faint one";
    let percent: f64 = said.strip_suffix(end).and_then(|share| share.parse().ok()).expect(&said);
    // The picture has as much of it, but for its edges.
    let picture = image::open(folder.join("p.png")).expect("a picture").to_rgba8();
    let seen: Vec<u8> = picture.pixels().filter(|pixel| pixel.0[3] > 0).map(|pixel| pixel.0[1]).collect();
    let share = 100.0 * seen.iter().filter(|level| **level < 16).count() as f64 / seen.len().max(1) as f64;
    assert!((55.0..75.0).contains(&percent) && (percent - share).abs() < 3.0, "{percent} % and {share} %");
    // None where it can be read: lit, or in the faint studio that a file with lamps has by itself.
    assert_eq!((of("lit.gltf", &alone), of("dark.gltf", &[])), (String::new(), String::new()));
}

#[test]
fn demos_bring_their_light_and_the_hall_turns_inside() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("exposure-demos");
    let small = ["--size", "32x18", "--samples", "1", "-q", "--report", "r.json"];
    // Those that are drawn in a second; `demo:cornell` is in the test of what is baked of it.
    let demos = ["room", "mirror", "doors", "portals", "laboratory", "simulations", "trails", "decals"];
    let demos = demos.map(|name| format!("demo:{name}"));
    let inputs: Vec<&str> = demos.iter().map(String::as_str).collect();
    run_in(&folder, &[&["render"], &inputs[..], &["-o", "all/"], &small].concat()).expect(0);
    // A room turns around who stands in it.
    run_in(&folder, &[&["render", "demo:hall", "--turntable", "2", "-o", "all/{frame}.png"], &small[..]].concat())
        .expect(0);
    let turn = report(&folder, "r.json");
    let eyes: Vec<&Value> = turn.iter().map(|line| &line["camera"]["eye_world_m"]).collect();
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    assert!(eyes.len() == 2 && eyes[0] == eyes[1], "{eyes:?}");
    assert!(number(&eyes[0][0]).abs() < 7.0 && number(&eyes[0][2]).abs() < 21.0, "{eyes:?}");
    let directions: Vec<f64> = turn.iter().map(|line| number(&line["camera"]["world_from_view"][2][2])).collect();
    assert!((directions[0] + directions[1]).abs() < 1e-5 && directions[0].abs() > 0.5, "{directions:?}");
    let mut names: Vec<String> = std::fs::read_dir(folder.join("all"))
        .expect("listed")
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names.len(), demos.len() + 2, "{names:?}");
    for name in names {
        let picture = image::open(folder.join("all").join(&name)).expect("a picture").to_luma8();
        let levels: Vec<u8> = picture.pixels().map(|pixel| pixel.0[0]).collect();
        let (count, mean) =
            (levels.len(), levels.iter().map(|level| usize::from(*level)).sum::<usize>() / levels.len());
        let most = (0..=255).map(|tone| levels.iter().filter(|level| **level == tone).count()).max().unwrap_or(0);
        assert!(mean > 15 && most * 2 < count, "{name}: a mean of {mean}, {most} of {count} pixels of one tone");
    }
}
