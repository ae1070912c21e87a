//! `manypass bake`, from the command line to the file and its picture.

use crate::common::{Folder, Run, has_adapter, run_in};
use manypass_scene::gltf_file::{Parts, load_path};
use std::process::{Command, Stdio};
use std::time::Duration;

const QUICK: [&str; 4] = ["--density", "24", "--samples", "16"];

fn bake(folder: &Folder, args: &[&str]) -> Run {
    run_in(folder, &[&["bake"], args, &QUICK].concat())
}

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn two_bakes_are_the_same_file_and_a_third_is_not_made() {
    let folder = Folder::new("baked");
    bake(&folder, &["demo:cornell", "-o", "a.glb"]).expect(0);
    let run = bake(&folder, &["demo:cornell", "-o", "b.glb"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.starts_with("b.glb and b.stage.toml: 2 maps of "), "{}", run.stderr);
    assert!(read(&folder, "a.glb") == read(&folder, "b.glb"));
    assert_eq!(
        read(&folder, "a.stage.toml"),
        b"# Written by `manypass bake`.\nmodel = \"a.glb\"\n[environment]\nsource = \"none\"\n"
    );
    let run = bake(&folder, &["demo:cornell", "-o", "b.glb"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("b.glb is up to date"), "{}", run.stderr);
    // Other flags are another bake.
    let run = bake(&folder, &["demo:cornell", "-o", "b.glb", "--bounces", "0", "--what", "lightmap", "--json"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!((&report["maps"]["light"], &report["maps"]["occlusion"]), (&1.into(), &0.into()));
    let json = Parts::json_of(&folder.join("b.glb")).expect("a GLB");
    assert_eq!(json["asset"]["extras"]["bake"]["lightMap"]["bounces"], 0);
    assert!(!folder.names().iter().any(|name| name.ends_with(".part")), "{:?}", folder.names());
}

#[test]
fn light_maps_have_directions_where_they_are_asked_for() {
    let folder = Folder::new("directional");
    let light = ["demo:cornell", "--what", "lightmap", "--bounces", "1"];
    let run = bake(&folder, &[&light[..], &["-o", "a.glb", "--directional", "--json"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!((&report["maps"]["light"], &report["maps"]["directions"]), (&1.into(), &1.into()));
    bake(&folder, &[&light[..], &["-o", "b.glb"]].concat()).expect(0);
    let read = |name: &str| {
        let loaded = load_path(&folder.join(name)).expect("it is read");
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.scene
    };
    let (with, without) = (read("a.glb"), read("b.glb"));
    assert_eq!((with.images.len(), without.images.len()), (2, 1));
    assert!(without.materials.iter().all(|of| of.light_map.is_none_or(|map| map.direction.is_none())));
    let map = with.materials.iter().find_map(|material| material.light_map).expect("a light map");
    let directions = with.images[with.textures[map.direction.expect("directions").texture].image].decode();
    let light = with.images[with.textures[map.light.texture.expect("light").texture].image].decode_light();
    let (directions, light) = (directions.expect("a PNG"), light.expect("OpenEXR"));
    assert_eq!((directions.width, directions.height), (light.width, light.height));
    // Where light is, it comes from somewhere: as even as it may be, two thirds along the normal are left.
    let length = |texel: &[u8]| texel.iter().take(3).map(|part| (f32::from(*part) / 127.5 - 1.0).powi(2)).sum::<f32>();
    let lit = directions.data.chunks_exact(4).zip(&light.texels).filter(|(_, light)| light[1].to_f32() > 0.0);
    let lengths: Vec<f32> = lit.map(|(texel, _)| length(texel).sqrt()).collect();
    let mean = lengths.iter().sum::<f32>() / lengths.len() as f32;
    assert!(lengths.len() > 1000 && (0.6..0.95).contains(&mean), "{} of {mean}", lengths.len());
    let run = bake(&folder, &["demo:cornell", "-o", "c.glb", "--what", "occlusion", "--directional"]);
    assert!(run.code == 2 && run.stderr.contains("--directional is for light maps"), "{}", run.stderr);
}

#[test]
fn an_interrupted_bake_goes_on() {
    let folder = Folder::new("interrupted_bake");
    let slow = ["bake", "demo:cornell", "-o", "a.glb", "--density", "40", "--samples", "64"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(slow).current_dir(folder.join("")).stdin(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("it starts");
    let part = folder.join("a.glb.part");
    for _ in 0..3000 {
        if part.metadata().is_ok_and(|file| file.len() > 100_000) {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    // As a power cut does it, in the middle of a record.
    child.kill().expect("it is killed");
    child.wait().expect("it ends");
    let bytes = read(&folder, "a.glb.part");
    std::fs::write(&part, &bytes[..bytes.len() - 7]).expect("written");
    assert!(!folder.names().contains(&"a.glb".to_owned()));
    let run = run_in(&folder, &slow);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("goes on from a.glb.part"), "{}", run.stderr);
    let again: Vec<&str> = slow.iter().map(|word| if *word == "a.glb" { "b.glb" } else { word }).collect();
    run_in(&folder, &again).expect(0);
    assert!(read(&folder, "a.glb") == read(&folder, "b.glb"));
    // A file of that name that is none of a bake stays.
    std::fs::write(folder.join("f.glb.part"), b"half a download").expect("written");
    bake(&folder, &["demo:cornell", "-o", "f.glb"]).expect(0);
    assert!(read(&folder, "f.glb.part") == b"half a download");
    // What is left of another bake is not taken.
    std::fs::write(folder.join("c.glb.part"), &bytes).expect("written");
    let run = bake(&folder, &["demo:cornell", "-o", "c.glb"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("c.glb.part is of another scene or other flags"), "{}", run.stderr);
    assert!(!folder.names().contains(&"c.glb.part".to_owned()));
}

#[cfg(unix)]
#[test]
fn a_bake_that_finds_no_room_leaves_nothing_behind() {
    // No byte, and so not even the first line of the journal; and 1024, which cut a record off.
    for blocks in ["0", "1"] {
        let folder = Folder::new(&format!("no-room-{blocks}"));
        let script = format!("ulimit -f {blocks}; exec \"$0\" bake demo:cornell -o a.glb {}", QUICK.join(" "));
        let mut bash = Command::new("bash");
        bash.args(["-c", &script, env!("CARGO_BIN_EXE_manypass")]).current_dir(&*folder).stdin(Stdio::null());
        let run: Run = bash.output().expect("bash runs").into();
        assert_eq!(run.code, 1, "{blocks}: {}", run.stderr);
        assert!(run.stderr.contains("a.glb.part: ") && run.stderr.contains("ulimit -f"), "{blocks}: {}", run.stderr);
        assert!(folder.names().is_empty(), "{blocks}: {:?}", folder.names());
    }
}

#[test]
fn what_is_wrong_is_said_and_nothing_is_lost() {
    let folder = Folder::new("unbaked");
    bake(&folder, &["demo:cornell", "-o", "a.glb"]).expect(0);
    let before = read(&folder, "a.glb");
    std::fs::write(folder.join("s.stage.toml"), "model = \"a.glb\"\n[[lights]]\nname = \"no\"\nmode = \"baked\"\n")
        .expect("written");
    for (arguments, code, expected) in [
        (&["a.glb", "-o", "a.glb"][..], 2, "a.glb would replace the model a.glb"),
        (&["a.glb", "-o", "a.gltf"], 2, "does not end in .glb"),
        (&["missing.glb", "-o", "b.glb"], 1, "missing.glb"),
        (&["s.stage.toml", "-o", "b.glb"], 1, "s.stage.toml:3:8: error: the model has no light called `no`"),
        (&["a.glb", "-o", "b.glb", "--side-max", "65536"], 2, "light maps of 65536 texels a side; write 16 to 8192"),
        (&["a.glb", "-o", "b.glb", "--bounces", "100"], 2, "100 bounces; write 0 to 64"),
        (&["a.glb", "-o", "b.glb", "--what", "probe"], 2, "probe"),
        (&["a.glb", "-o", "b.glb", "--what", "all,ambient-cubes"], 2, "as spherical harmonics or as ambient cubes"),
        (&["a.glb", "-o", "b.glb", "--probe-spacing", "1"], 2, "--probe-spacing is for probes, which are not baked"),
        (
            &["a.glb", "-o", "b.glb", "--what", "probes", "--probe-spacing", "0.02"],
            2,
            "101 x 101 x 101 probes; a grid has 1 to 16384",
        ),
        (&["a.glb", "-o", "b.glb", "--set", "environment.sorce=sky"], 2, "environment.sorce"),
    ] {
        let run = bake(&folder, arguments);
        assert_eq!(run.code, code, "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.contains(expected), "{}\nshould say {expected}", run.stderr);
        assert!(run.stderr.contains("hint: "), "{}", run.stderr);
        assert!(!folder.names().contains(&"b.glb".to_owned()));
    }
    let run = run_in(&folder, &["bake", "a.glb", "-o", "b.glb", "--density", "1e6"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("texels a metre are possible"), "{}", run.stderr);
    assert!(read(&folder, "a.glb") == before);
}

#[test]
fn probes_are_baked_where_a_stage_says_and_light_what_is_there() {
    let folder = Folder::new("probes");
    let probes = ["--what", "probes", "--probe-spacing", "0.4"];
    let run = bake(&folder, &[&["demo:cornell", "-o", "a.glb"], &probes[..]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("216 probes (6 x 6 x 6; "), "{}", run.stderr);
    bake(&folder, &[&["demo:cornell", "-o", "b.glb"], &probes[..]].concat()).expect(0);
    assert!(read(&folder, "a.glb") == read(&folder, "b.glb"));
    let run = bake(&folder, &[&["demo:cornell", "-o", "b.glb"], &probes[..]].concat());
    assert!(run.stderr.contains("b.glb is up to date"), "{}", run.stderr);
    // A stage says where, and how light is known; the stage that is written finds it by its name.
    folder.write(
        "s.stage.toml",
        b"model = \"demo:cornell\"\n[environment]\nsource = \"none\"\n[[probes]]\nname = \"front\"\ncenter = [0, 1, 0.5]\n\
          size_m = [2, 2, 1]\ncounts = [3, 4, 2]\nbasis = \"ambient-cube\"\n",
    );
    let run = bake(&folder, &["s.stage.toml", "-o", "c.glb", "--what", "all", "--json"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!((&report["maps"]["light"], &report["probes"]["count"]), (&1.into(), &24.into()));
    let json = Parts::json_of(&folder.join("c.glb")).expect("a GLB");
    let grid = &json["extensions"]["MANYPASS_probes"]["grids"][0];
    assert_eq!((&grid["name"], &grid["basis"]), (&"front".into(), &"ambient-cube".into()));
    if !has_adapter() {
        return;
    }
    let middle = |name: &str| {
        let picture = ["-o", "x.png", "--size", "96x96", "--samples", "4", "--no-cache"];
        let run = run_in(&folder, &[&["render", name], &picture[..]].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let picture = image::open(folder.join("x.png")).expect("a PNG").into_rgb8();
        (run.stderr, color(&picture, (30, 20)))
    };
    let (_, lit) = middle("a.stage.toml");
    // Without a word frames would find the light.
    let stage = std::fs::read_to_string(folder.join("s.stage.toml")).expect("a stage");
    folder.write("dark.stage.toml", format!("{stage}live = false\n").as_bytes());
    let (warned, dark) = middle("dark.stage.toml");
    assert!(warned.contains("the probes `front` have no light yet"), "{warned}");
    let (sum, none) = (lit.iter().sum::<f32>(), dark.iter().sum::<f32>());
    assert!(sum > 60.0 && none < 10.0, "{lit:?} {dark:?}");
    let run = bake(&folder, &["c.stage.toml", "-o", "d.glb", "--what", "probes", "--probe-spacing", "1"]);
    assert!(run.code == 2 && run.stderr.contains("another distance than [[probes]]"), "{}", run.stderr);
    // The flag says six colours, whatever the stage does.
    let cubes = ["s.stage.toml", "-o", "e.glb", "--what", "ambient-cubes"];
    bake(&folder, &cubes).expect(0);
    let (warned, _) = middle("e.stage.toml");
    assert!(!warned.contains("no light"), "{warned}");
    let (warned, _) = middle("c.stage.toml");
    assert!(!warned.contains("no light"), "{warned}");
}

#[test]
fn what_is_reflected_is_baked_where_a_stage_says() {
    let folder = Folder::new("reflection");
    let run = bake(&folder, &["demo:cornell", "-o", "a.glb", "--what", "reflection", "--bounces", "1"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("1 reflection probe"), "{}", run.stderr);
    let json = Parts::json_of(&folder.join("a.glb")).expect("a GLB");
    let place = &json["extensions"]["MANYPASS_surroundings"]["places"][0];
    assert_eq!((&place["name"], place["position"][1].as_f64().map(f64::round)), (&"room".into(), Some(1.0)));
    // Without a word of reflection probes `all` has none; a stage says where, and finds it by its name.
    folder.write(
        "s.stage.toml",
        b"model = \"demo:cornell\"\n[environment]\nsource = \"none\"\n[[reflection_probes]]\nname = \"box\"\ncenter = [0, 1, 0]\n\
          size_m = [2, 2, 2]\nposition = [0, 1.2, 0.3]\n",
    );
    let all = ["-o", "b.glb", "--what", "occlusion,reflection", "--json"];
    let run = bake(&folder, &[&["s.stage.toml"], &all[..]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!(report["surroundings"], 1);
    if !has_adapter() {
        return;
    }
    let captures = |name: &str| {
        let picture = ["-o", "x.png", "--size", "64x64", "--samples", "1", "--no-cache", "--report", "r.json"];
        run_in(&folder, &[&["render", name], &picture[..]].concat()).expect(0);
        let report: serde_json::Value = serde_json::from_slice(&read(&folder, "r.json")).expect("JSON");
        report["captures"].as_u64()
    };
    assert_eq!(captures("b.stage.toml"), Some(0));
    assert!(captures("s.stage.toml") > Some(0));
}

#[test]
fn what_was_baked_in_some_light_is_drawn_in_it() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("baked_light");
    folder.write("a.obj", b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    let mean = |name: &str, flags: &[&str]| {
        let picture = ["-o", "x.png", "--size", "96x96", "--samples", "4", "--no-cache"];
        run_in(&folder, &[&["render", name], &picture[..], flags].concat()).expect(0);
        let picture = image::open(folder.join("x.png")).expect("a PNG").into_rgb8();
        color(&picture, (48, 52))
    };
    // Without a word about light: in the studio, and without a stage.
    let hint = "hint: a.obj: it has no lights, so the light of the studio is baked; --environment none leaves it out\n";
    assert_eq!(bake(&folder, &["a.obj", "-o", "b.glb"]).expect(0).stderr.matches(hint).count(), 1);
    assert!(!folder.names().contains(&"b.stage.toml".to_owned()));
    // Under a sky: the stage that is written says so.
    let told =
        bake(&folder, &["a.obj", "-o", "c.glb", "--environment", "sky", "--set", "environment.turbidity=4"]).expect(0);
    assert!(!told.stderr.contains("the studio is baked"), "{}", told.stderr);
    let stage = String::from_utf8(read(&folder, "c.stage.toml")).expect("text");
    assert!(stage.contains("[environment]") && stage.contains("turbidity = 4.0"), "{stage}");
    let sky = ["--environment", "sky", "--set", "environment.turbidity=4"];
    for (baked, plain) in [(mean("b.glb", &[]), mean("a.obj", &[])), (mean("c.stage.toml", &[]), mean("a.obj", &sky))] {
        for (baked, plain) in baked.iter().zip(plain) {
            assert!((baked - plain).abs() < 0.06 * plain + 2.0, "{baked} and {plain}");
        }
    }
    // A stage that has changed is written again, though the light is the same; its lamps are not there twice.
    folder.write(
        "s.stage.toml",
        b"model = \"a.obj\"\n[[lights]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = 5\n",
    );
    bake(&folder, &["s.stage.toml", "-o", "t.glb"]).expect(0);
    let json = Parts::json_of(&folder.join("t.glb")).expect("a GLB");
    assert!(json["extensions"]["KHR_lights_punctual"].is_null(), "{json}");
    let stage = String::from_utf8(read(&folder, "s.stage.toml")).expect("text") + "[fog]\nmode = \"linear\"\n";
    folder.write("s.stage.toml", stage.as_bytes());
    bake(&folder, &["s.stage.toml", "-o", "t.glb"]).expect(0);
    assert!(String::from_utf8(read(&folder, "t.stage.toml")).expect("text").contains("[fog]"));
    // A stage of somebody's own stays, and a file that was cut off is made again.
    folder.write("d.stage.toml", b"model = \"a.obj\"\n");
    let run = bake(&folder, &["a.obj", "-o", "d.glb", "--environment", "sky"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(read(&folder, "d.stage.toml") == b"model = \"a.obj\"\n");
    let whole = read(&folder, "b.glb");
    folder.write("b.glb", &whole[..whole.len() - 100]);
    bake(&folder, &["a.obj", "-o", "b.glb"]).expect(0);
    assert!(read(&folder, "b.glb") == whole);
    // Baked again, it holds no maps of before.
    bake(&folder, &["b.glb", "-o", "e.glb"]).expect(0);
    let json = Parts::json_of(&folder.join("e.glb")).expect("a GLB");
    assert_eq!(json["images"].as_array().map(Vec::len), Some(2));
}

/// The mean colour of a square of pixels around a place.
fn color(picture: &image::RgbImage, (x, y): (u32, u32)) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (dx, dy) in (0..5).flat_map(|y| (0..5).map(move |x| (x, y))) {
        let pixel = picture.get_pixel(x + dx - 2, y + dy - 2).0;
        sum.iter_mut().zip(pixel).for_each(|(sum, part)| *sum += f32::from(part) / 25.0);
    }
    sum
}

#[test]
fn a_baked_room_shows_what_its_walls_send_each_other() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("cornell");
    bake(&folder, &["demo:cornell", "-o", "direct.glb", "--bounces", "0"]).expect(0);
    bake(&folder, &["demo:cornell", "-o", "all.glb", "--bounces", "4"]).expect(0);
    bake(&folder, &["demo:cornell", "-o", "glowing.glb", "--bounces", "4", "--what", "emission,occlusion"]).expect(0);
    let picture = |name: &str, model: &str| {
        run_in(&folder, &["render", model, "-o", name, "--size", "200x200", "--samples", "4", "--no-cache"]).expect(0);
        image::open(folder.join(name)).expect("a PNG").into_rgb8()
    };
    // The demo has live probes of its own.
    folder.write("none.stage.toml", b"model = \"demo:cornell\"\n[environment]\nsource = \"none\"\n");
    let (none, direct, all) = (
        picture("none.png", "none.stage.toml"),
        picture("direct.png", "direct.stage.toml"),
        picture("all.png", "all.stage.toml"),
    );
    let (ceiling, tall_left, small_right, floor) = ((100, 38), (58, 130), (152, 148), (60, 186));
    for place in [ceiling, tall_left, small_right, floor] {
        assert_eq!(color(&none, place), [0.0; 3]);
    }
    let live = picture("live.png", "demo:cornell");
    assert!(color(&live, ceiling)[0] > 20.0 && color(&live, floor)[0] > 20.0, "the demo brings its light");
    // The lamp does not see the ceiling; the walls do.
    assert!(color(&direct, ceiling).iter().sum::<f32>() < 6.0 && color(&all, ceiling)[0] > 20.0);
    let [red, green, _] = color(&all, tall_left);
    assert!(red > 3.0 * green, "the red wall on the tall box: {red} {green}");
    let [red, green, _] = color(&all, small_right);
    assert!(green > 1.2 * red, "the green wall on the small box: {red} {green}");
    assert!(color(&all, floor)[0] > color(&direct, floor)[0]);
    // On every path.
    for path in ["forward", "forward-batched", "gouraud"] {
        let arguments =
            ["render", "all.stage.toml", "-o", "path.png", "--size", "200x200", "--samples", "4", "--no-cache"];
        run_in(&folder, &[&arguments[..], &["--path", path]].concat()).expect(0);
        let picture = image::open(folder.join("path.png")).expect("a PNG").into_rgb8();
        for place in [ceiling, tall_left, small_right, floor] {
            for (one, other) in color(&all, place).iter().zip(color(&picture, place)) {
                assert!((one - other).abs() < 2.0, "{path}: {one} and {other} at {place:?}");
            }
        }
    }
    // As emission it looks the same, in bytes of sRGB.
    let glowing = picture("glowing.png", "glowing.stage.toml");
    for place in [ceiling, tall_left, small_right, floor, (100, 100), (100, 32)] {
        for (one, other) in color(&all, place).iter().zip(color(&glowing, place)) {
            assert!((one - other).abs() < 4.0, "{one} and {other} at {place:?}");
        }
    }
    let json = Parts::json_of(&folder.join("glowing.glb")).expect("a GLB");
    let used = json["extensionsUsed"].as_array().expect("a list");
    assert!(!used.contains(&"MOZ_lightmap".into()) && used.contains(&"KHR_materials_emissive_strength".into()));
}
