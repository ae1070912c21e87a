//! OBJ, STL, PLY and 3MF beside glTF: one body, one picture; and every place where a model can be named.

use crate::common::{Folder, has_adapter, packed_3mf, picture, run_in, run_with_input};
use manypass_scene::{Primitive, primitives};
use manypass_testkit::compare::{Picture, Tolerance, assert_looks_same, assert_same, difference, flip};
use std::fmt::Write as _;

/// A box with edges and a smooth ball, apart from each other, with their normals in closed form.
fn body() -> Primitive {
    let mut body = primitives::cube(glam::Vec3::new(1.0, 0.8, 0.6));
    let mut ball = primitives::uv_sphere(0.5, 32, 16);
    ball.positions.iter_mut().for_each(|[x, y, _]| (*x, *y) = (*x + 1.2, *y + 0.2));
    let first = body.positions.len() as u32;
    body.positions.extend(ball.positions);
    body.normals.extend(ball.normals);
    body.indices.extend(ball.indices.iter().map(|index| first + index));
    body
}

/// The same place with Z up.
fn z_up([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, -z, y]
}

fn glb(body: &Primitive) -> Vec<u8> {
    let vectors = body.positions.iter().chain(&body.normals).flatten();
    let mut bin: Vec<u8> = vectors.flat_map(|value| value.to_le_bytes()).collect();
    bin.extend(body.indices.iter().flat_map(|index| index.to_le_bytes()));
    let (count, indices) = (body.positions.len(), body.indices.len());
    // The grey without gloss that docs/inputs.md names.
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"scene":0,"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":2,"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.19,0.22,0.26,1],"metallicFactor":0,"roughnessFactor":0.6}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3"}},
            {{"bufferView":0,"byteOffset":{0},"componentType":5126,"count":{count},"type":"VEC3"}},
            {{"bufferView":0,"byteOffset":{1},"componentType":5125,"count":{indices},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{2}}}],"buffers":[{{"byteLength":{2}}}]}}"#,
        12 * count,
        24 * count,
        bin.len()
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), kind, bytes].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &bin)].concat();
    let header = [&b"glTF\x02\0\0\0"[..], &(chunks.len() as u32 + 12).to_le_bytes()].concat();
    [header, chunks].concat()
}

fn stl(body: &Primitive) -> Vec<u8> {
    let mut bytes = b"solid body, written as bytes".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((body.indices.len() as u32 / 3).to_le_bytes());
    for triangle in body.indices.chunks_exact(3) {
        bytes.extend([0; 12]);
        let corners = triangle.iter().flat_map(|&index| z_up(body.positions[index as usize]));
        bytes.extend(corners.flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(body: &Primitive) -> Vec<u8> {
    let mut text = String::from("# by code\n");
    for [x, y, z] in &body.positions {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [x, y, z] in &body.normals {
        let _ = writeln!(text, "vn {x} {y} {z}");
    }
    for triangle in body.indices.chunks_exact(3) {
        let corners: Vec<String> = triangle.iter().map(|index| format!("{0}//{0}", index + 1)).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text.into_bytes()
}

fn ply(body: &Primitive) -> Vec<u8> {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        body.positions.len(),
        body.indices.len() / 3
    );
    for [x, y, z] in &body.positions {
        let _ = writeln!(text, "{x} {y} {z}");
    }
    for triangle in body.indices.chunks_exact(3) {
        let _ = writeln!(text, "3 {} {} {}", triangle[0], triangle[1], triangle[2]);
    }
    text.into_bytes()
}

fn threemf(body: &Primitive) -> Vec<u8> {
    let mut text = String::from("<model unit=\"millimeter\"><resources><object id=\"1\"><mesh><vertices>");
    for &position in &body.positions {
        let [x, y, z] = z_up(position).map(|metres| 1000.0 * metres);
        let _ = write!(text, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
    }
    text += "</vertices><triangles>";
    for triangle in body.indices.chunks_exact(3) {
        let _ = write!(text, "<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>", triangle[0], triangle[1], triangle[2]);
    }
    text += "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build></model>";
    packed_3mf(&text)
}

const SMALL: [&str; 4] = ["--size", "128x96", "--samples", "4"];

#[test]
fn one_body_in_every_format_is_one_picture() {
    if !has_adapter() {
        return;
    }
    let (folder, body) = (Folder::new("formats"), body());
    folder.write("in/glb.glb", &glb(&body));
    folder.write("in/stl.stl", &stl(&body));
    folder.write("in/obj.obj", &obj(&body));
    folder.write("in/ply.ply", &ply(&body));
    folder.write("in/threemf.3MF", &threemf(&body));
    let run = run_in(&folder, &[&["render", "in", "-o", "out/", "--strict"][..], &SMALL].concat()).expect(0);
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    let read = |name: &str| picture(&std::fs::read(folder.join(&format!("out/{name}.png"))).expect(name));
    let reference = read("glb");
    // Normals of the ball are those of the sphere here, and means of its faces' there: about half a degree apart.
    let tolerance =
        Tolerance { within: 2, share: 0.995, share_between: 0.998, mean: 0.1, area_px: 8, area_between_px: 4 };
    for name in ["stl", "obj", "ply", "threemf"] {
        assert_same(&reference, &read(name), tolerance);
        assert_looks_same(&reference, &read(name), 0.005);
    }
    // A ball with flat faces, or one that lies on its side, would be seen.
    let mut turned = body.clone();
    turned.positions.iter_mut().for_each(|position| *position = z_up(*position));
    folder.write("turned.stl", &stl(&turned));
    run_in(&folder, &[&["render", "turned.stl", "-o", "out/turned.png"][..], &SMALL].concat()).expect(0);
    assert!(!difference(&reference, &read("turned"), tolerance.within).is_within(tolerance));
    assert!(flip(&reference, &read("turned")).mean() > 0.05);
}

#[test]
fn what_has_no_material_stands_out_against_the_studio_and_white() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("formats-contrast");
    folder.write("body.stl", &stl(&body()));
    // A pyramid whose sides face a camera at the default place.
    let places = ["0 0 0", "1 0 0", "0 0 -1", "0 1.2 -0.2"].map(|place| format!("v {place}\n")).concat();
    folder.write("pyramid.obj", (places + "f 1 2 4\nf 2 3 4\nf 3 1 4\nf 3 2 1\n").as_bytes());
    for model in ["body.stl", "pyramid.obj"] {
        let drawn = |more: &[&str]| {
            let args = [&["render", model, "-o", "-", "--format", "png", "--size", "64x64"][..], more].concat();
            picture(&run_in(&folder, &args).expect(0).stdout)
        };
        let mask = drawn(&["--background", "transparent", "--ground", "none"]);
        for more in [&[][..], &["--background", "ffffff"]] {
            let seen = drawn(more);
            let differs = |at: usize| {
                // The backdrop has the same levels all along a row.
                let backdrop = seen.pixels[at - at % seen.width];
                (0..3).any(|channel| seen.pixels[at][channel].abs_diff(backdrop[channel]) >= 10)
            };
            let inside: Vec<usize> = (0..mask.pixels.len()).filter(|at| mask.pixels[*at][3] == 255).collect();
            let lost = inside.iter().filter(|at| !differs(**at)).count();
            assert!(inside.len() > 400 && lost * 20 < inside.len(), "{model} {more:?}: {lost} of {}", inside.len());
        }
    }
}

#[test]
fn models_of_any_format_can_be_named_wherever_gltf_can() {
    if !has_adapter() {
        return;
    }
    let (folder, body) = (Folder::new("formats-places"), body());
    folder.write("part.stl", &stl(&body));
    folder.write(
        "part.stage.toml",
        b"model = \"part.stl\"\n[[lights]]\nkind = \"point\"\nposition = [0, 3, 2]\nintensity = 40\n",
    );
    run_in(&folder, &[&["render", "part.stl"][..], &SMALL].concat()).expect(0);
    let named = std::fs::read(folder.join("part.png")).expect("a picture");
    let args = [&["render", "-", "-o", "-", "--format", "png"][..], &SMALL].concat();
    let piped = run_with_input(&folder, &args, &stl(&body)).expect(0).stdout;
    assert!(picture(&named) == picture(&piped));
    run_in(&folder, &[&["render", "part.stage.toml", "-o", "lit.png"][..], &SMALL].concat()).expect(0);
    let info = run_in(&folder, &["info", "part.stl", "--json"]).expect(0).text();
    let info: serde_json::Value = serde_json::from_str(&info).expect("JSON");
    assert_eq!(info["triangles"], body.indices.len() / 3);
    run_in(&folder, &["graph", "part.stl", "--limits", "webgl2"]).expect(0);
    folder.write("cut.stl", &stl(&body)[..500]);
    let error = run_in(&folder, &["info", "cut.stl"]).expect(1).stderr;
    assert!(error.starts_with("error: cut.stl: byte 80: the header counts") && error.contains("\nhint: "), "{error}");
}

#[test]
fn files_that_an_obj_names_are_not_replaced() {
    let folder = Folder::new("formats-named");
    folder.write("a.obj", b"mtllib lib/a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("lib/a.mtl", b"newmtl a\nmap_Kd wood.png\n");
    folder.write("lib/wood.png", b"kept");
    for output in ["lib/wood.png", "lib/../lib/wood.png", "a.obj", "lib/a.mtl"] {
        let error = run_in(&folder, &["render", "a.obj", "-o", output]).expect(2).stderr;
        assert!(error.starts_with("error: "), "{error}");
    }
    assert_eq!(std::fs::read(folder.join("lib/wood.png")).expect("there"), b"kept");
}

/// Four by four bumps on a square of a metre: heights, and the normals of what is `depth_m` deep.
fn bumps(depth_m: f32) -> [image::RgbImage; 2] {
    const SIDE: u32 = 128;
    let turn = 4.0 * std::f32::consts::TAU;
    let at = |pixel: u32| turn * (pixel as f32 + 0.5) / SIDE as f32;
    let byte = |value: f32| (value * 255.0).round().clamp(0.0, 255.0) as u8;
    let heights = |x: u32, y: u32| image::Rgb([byte(0.5 + 0.5 * at(x).cos() * at(y).cos()); 3]);
    let normals = |x: u32, y: u32| {
        // Rows count downwards, and +Y of normals upwards.
        let slope = [-at(x).sin() * at(y).cos(), at(x).cos() * at(y).sin()].map(|slope| 0.5 * turn * depth_m * slope);
        let normal = glam::Vec3::new(-slope[0], -slope[1], 1.0).normalize();
        image::Rgb((0.5 + 0.5 * normal).to_array().map(byte))
    };
    [image::RgbImage::from_fn(SIDE, SIDE, heights), image::RgbImage::from_fn(SIDE, SIDE, normals)]
}

#[test]
fn heights_of_an_obj_bend_normals_as_a_map_of_such_normals_does() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("bumps");
    // A hundredth of the diagonal for each unit of -bm.
    let [heights, normals] = bumps(0.02 * 2f32.sqrt());
    heights.save(folder.join("heights.png")).expect("a file");
    normals.save(folder.join("normals.png")).expect("a file");
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n";
    let libraries = [("flat", ""), ("normals", "norm normals.png"), ("heights", "map_Bump -bm 2 heights.png")];
    for (name, map) in libraries.into_iter().chain([("hollows", "bump -bm -2 heights.png")]) {
        folder.write(&format!("{name}.mtl"), format!("newmtl m\nKd 0.6 0.5 0.4\nPr 0.5\n{map}\n").as_bytes());
        folder.write(&format!("{name}.obj"), format!("mtllib {name}.mtl\n{square}").as_bytes());
        let out = format!("seen_{name}.png");
        let args = ["render", &format!("{name}.obj"), "-o", &out, "--size", "192x192", "--orbit", "20,30,auto"];
        let run = run_in(&folder, &[&args[..], &["--samples", "4", "--quiet"]].concat()).expect(0);
        assert_eq!(run.stderr, "");
    }
    let [flat, normals, heights, hollows] = ["flat", "normals", "heights", "hollows"].map(|name| {
        let picture = image::open(folder.join(&format!("seen_{name}.png"))).expect("a picture").to_rgba8();
        Picture::from_rgba8(192, 192, picture.as_raw())
    });
    let errors = [&heights, &flat, &hollows].map(|other| flip(&normals, other).mean());
    println!("heights, none and hollows beside normals: {errors:?}");
    assert!(errors[0] < 0.01 && errors[1] > 0.05 && errors[2] > 0.05, "{errors:?}");
}
