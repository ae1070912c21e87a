//! Models at UTM coordinates: they are drawn as at the origin, by every command, whatever they are written in.

use crate::common::{self, Folder, has_adapter, packed_3mf, picture, run_in};
use manypass_testkit::compare::{Picture, difference};
use manypass_testkit::data_uri;
use serde_json::{Value, json};

const SMALL: [&str; 6] = ["--size", "96x64", "--samples", "4", "--format", "png"];

/// Where the cube is: floats are whole multiples of half a metre there in y, and of 1/32 m in x.
const FAR: [f64; 3] = [500_000.0, 4_649_776.0, 100.0];
const NEAR: [f64; 3] = [0.0; 3];

/// Half a side of the cube, which is no multiple of half a metre.
const HALF_M: f64 = 0.45;

/// The sides of the cube by its corners, seen from outside counter-clockwise.
const SIDES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The corners of the cube around a point.
fn corners([x, y, z]: [f64; 3]) -> [[f64; 3]; 8] {
    let side = |is_far: usize| if is_far == 0 { -HALF_M } else { HALF_M };
    std::array::from_fn(|i| [x + side(i & 1), y + side(i >> 1 & 1), z + side(i >> 2)])
}

/// Its triangles.
fn triangles() -> impl Iterator<Item = [usize; 3]> {
    SIDES.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
}

/// The same place with Z up.
fn z_up([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

/// Numbers with blanks between them.
fn words(numbers: impl IntoIterator<Item = f64>) -> String {
    numbers.into_iter().map(|number| number.to_string()).collect::<Vec<_>>().join(" ")
}

/// What writes the cube around a place in some format.
type CubeWriter = fn([f64; 3]) -> Vec<u8>;

fn gltf(place: [f64; 3]) -> Vec<u8> {
    let positions = corners(NEAR).into_iter().flatten().flat_map(|value| (value as f32).to_le_bytes());
    let indices = triangles().flatten().flat_map(|index| (index as u16).to_le_bytes());
    let buffer = data_uri("application/octet-stream", &positions.chain(indices).collect::<Vec<u8>>());
    let (least, most) = ([-HALF_M as f32; 3], [HALF_M as f32; 3]);
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "translation": place }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": least, "max": most },
            { "bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 96 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 72 },
        ],
        "buffers": [{ "uri": buffer, "byteLength": 168 }],
    })
    .to_string()
    .into_bytes()
}

fn obj(place: [f64; 3]) -> Vec<u8> {
    let vertices = corners(place).map(|corner| format!("v {}\n", words(corner))).concat();
    let faces = SIDES.map(|side| format!("f {}\n", words(side.map(|index| index as f64 + 1.0))));
    (vertices + &faces.concat()).into_bytes()
}

fn stl(place: [f64; 3]) -> Vec<u8> {
    let corners = corners(place);
    let vertex = |index: usize| format!("vertex {}\n", words(z_up(corners[index])));
    let facet = |triangle: [usize; 3]| {
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", triangle.map(vertex).concat())
    };
    format!("solid cube\n{}endsolid cube\n", triangles().map(facet).collect::<String>()).into_bytes()
}

/// The header of a cube whose coordinates have a type.
fn ply_header(encoding: &str, kind: &str) -> String {
    let coordinates = ["x", "y", "z"].map(|axis| format!("property {kind} {axis}\n")).concat();
    let faces = "element face 6\nproperty list uchar int vertex_indices\n";
    format!("ply\nformat {encoding} 1.0\nelement vertex 8\n{coordinates}{faces}end_header\n")
}

/// Text whose header, as many do, names floats and means digits.
fn ply(place: [f64; 3]) -> Vec<u8> {
    let vertices = corners(place).map(|corner| format!("{}\n", words(corner))).concat();
    let faces = SIDES.map(|side| format!("4 {}\n", words(side.map(|index| index as f64)))).concat();
    (ply_header("ascii", "float") + &vertices + &faces).into_bytes()
}

fn ply_of_doubles(place: [f64; 3]) -> Vec<u8> {
    let mut bytes = ply_header("binary_little_endian", "double").into_bytes();
    bytes.extend(corners(place).into_iter().flatten().flat_map(f64::to_le_bytes));
    for side in SIDES {
        bytes.push(4);
        bytes.extend(side.into_iter().flat_map(|index| (index as i32).to_le_bytes()));
    }
    bytes
}

/// An archive with the cube around `place` in millimetres, as an item `moved_m` away.
fn archive(place: [f64; 3], moved_m: [f64; 3]) -> Vec<u8> {
    let millimetres = |place: [f64; 3]| z_up(place).map(|metres| 1000.0 * metres);
    let vertex = |corner: [f64; 3]| {
        let [x, y, z] = millimetres(corner);
        format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")
    };
    let triangle = |[a, b, c]: [usize; 3]| format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
    let text = format!(
        "<model unit=\"millimeter\"><resources><object id=\"1\"><mesh><vertices>{}</vertices><triangles>{}</triangles>\
         </mesh></object></resources><build><item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 {}\"/></build></model>",
        corners(place).map(vertex).concat(),
        triangles().map(triangle).collect::<String>(),
        words(millimetres(moved_m)),
    );
    packed_3mf(&text)
}

fn read(folder: &Folder, name: &str) -> Picture {
    picture(&std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}")))
}

/// Whether two pictures are one, but for samples that edges go through.
#[track_caller]
fn assert_one(near: &Picture, far: &Picture, what: &str) {
    let found = difference(near, far, 1);
    assert!(found.share >= 0.999, "{what}: {found:?}");
    let levels = near.pixels.iter().map(|pixel| pixel[0]);
    assert!(levels.clone().max() > levels.min().map(|least| least.saturating_add(20)), "{what}: nothing is seen");
}

/// The flags of a camera that stands beside a place and looks at it.
fn camera([x, y, z]: [f64; 3]) -> [String; 2] {
    [
        format!("--eye={},{},{}", x + 2.13, y + 1.37, z + 2.71),
        format!("--target={},{},{}", x + 0.03, y - 0.02, z + 0.01),
    ]
}

/// A picture of a model at a place, by a camera that stands beside that.
fn drawn(folder: &Folder, name: &str, place: [f64; 3]) -> Picture {
    let [eye, target] = camera(place);
    let run = run_in(folder, &[&["render", name, "-o", "-", &eye, &target][..], &SMALL].concat()).expect(0);
    assert!(!run.stderr.contains("warning"), "{name}: {}", run.stderr);
    picture(&run.stdout)
}

#[test]
fn a_cube_far_away_is_that_at_the_origin_in_every_format() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("far-formats");
    let formats: [(&str, CubeWriter); 7] = [
        ("cube.gltf", gltf),
        ("cube.obj", obj),
        ("cube.stl", stl),
        ("cube.ply", ply),
        ("doubles.ply", ply_of_doubles),
        ("mesh.3mf", |place| archive(place, NEAR)),
        ("item.3mf", |place| archive(NEAR, place)),
    ];
    for (name, written) in formats {
        let [near, far] = [("near", NEAR), ("far", FAR)].map(|(distance, place)| {
            let file = format!("{distance}-{name}");
            folder.write(&file, &written(place));
            drawn(&folder, &file, place)
        });
        assert_one(&near, &far, name);
    }
}

#[test]
fn stages_lists_of_cameras_benchmarks_and_bakes_show_it_so() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("far-commands");
    for (name, [x, y, z]) in [("near", NEAR), ("far", FAR)] {
        folder.write(&format!("{name}.obj"), &obj([x, y, z]));
        let light = format!("kind = \"point\"\nposition = [{x:.1}, {:.1}, {:.1}]\nintensity = 40\n", y + 2.0, z + 3.0);
        let stage = format!("model = \"{name}.obj\"\n[[lights]]\n{light}");
        folder.write(&format!("{name}.stage.toml"), stage.as_bytes());
        let rows =
            [[1.0, 0.0, 0.0, x + 0.13], [0.0, 1.0, 0.0, y + 0.07], [0.0, 0.0, 1.0, z + 2.9], [0.0, 0.0, 0.0, 1.0]];
        let frame = json!({ "file_path": format!("{name}-view.png"), "transform_matrix": rows });
        let cameras = json!({ "camera_angle_x": 0.8, "frames": [frame] });
        folder.write(&format!("{name}.json"), cameras.to_string().as_bytes());
        let (model, list) = (format!("{name}.obj"), format!("{name}.json"));
        let views = ["render", &model, "--cameras", &list, "-o", "{camera}.png"];
        run_in(&folder, &[&views[..], &SMALL].concat()).expect(0);
        let measured = format!("{name}-bench.png");
        let bench = ["bench", &model, "--first-frame", "--png", &measured, "--size", "96x64"];
        run_in(&folder, &[&bench[..], &["--set", "environment.source=studio"]].concat()).expect(0);
        let baked = format!("{name}-baked.glb");
        let bake = ["bake", &model, "-o", &baked, "--what", "lightmap", "--density", "8", "--samples", "16", "--quiet"];
        run_in(&folder, &bake).expect(0);
    }
    for name in ["view", "bench"] {
        let [near, far] = ["near", "far"].map(|distance| read(&folder, &format!("{distance}-{name}.png")));
        assert_one(&near, &far, name);
    }
    for name in [".stage.toml", "-baked.glb"] {
        let [near, far] = [("near", NEAR), ("far", FAR)].map(|(distance, place)| {
            let file = format!("{distance}{name}");
            drawn(&folder, &file, place)
        });
        assert_one(&near, &far, name);
    }
}

/// What `diff` says of two models.
fn compared(folder: &Folder, models: [&str; 2]) -> (Value, String) {
    let args = [&["diff"][..], &models, &["--size", "64x64", "--samples", "1"]].concat();
    let value = run_in(folder, &[&args[..], &["--json"]].concat()).expect(0).text();
    (serde_json::from_str(&value).expect("JSON"), run_in(folder, &args).expect(0).text())
}

#[test]
fn a_difference_of_places_is_one() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("far-diff");
    folder.write("near.obj", &obj(NEAR));
    folder.write("far.obj", &obj(FAR));
    let [x, y, z] = FAR;
    folder.write("beside.obj", &obj([x + 0.3, y, z]));
    let number = |value: &Value| value.as_f64().expect("a number");
    let offset = |value: &Value| [0, 1, 2].map(|axis| number(&value["offset_m"][axis]));

    let (same, _) = compared(&folder, ["far.obj", "far.obj"]);
    assert_eq!((number(&same["flip"]["mean"]), &same["is_far"]), (0.0, &json!(false)), "{same}");

    // Less than floats can tell there.
    let (beside, text) = compared(&folder, ["far.obj", "beside.obj"]);
    let found = offset(&beside);
    assert!((found[0] - 0.3).abs() < 1e-4 && found[1].abs() < 1e-4 && found[2].abs() < 1e-4, "{beside}");
    assert!(number(&beside["changed"]["geometry"]) > 0.1 && beside["is_far"] == false, "{beside}");
    assert!(!text.contains(" m from A"), "{text}");
    let eye = &beside["camera"]["eye_world_m"];
    assert!((number(&eye[1]) - y).abs() < 10.0, "{beside}");

    let (apart, text) = compared(&folder, ["near.obj", "far.obj"]);
    let distance_m = FAR.map(|value| value * value).iter().sum::<f64>().sqrt();
    assert!(text.contains(&format!("B lies {distance_m:.0} m from A")), "{text}");
    assert!(apart["is_far"] == true && number(&apart["flip"]["mean"]) > 0.01, "{apart}");
    assert_eq!((&apart["changed"]["geometry"], &apart["only"]["a"]), (&json!(1.0), &json!(1.0)), "{apart}");
    let found = offset(&apart);
    assert!((0..3).all(|axis| (found[axis] - FAR[axis]).abs() < 0.5), "{apart}");
}

/// A house of 12 m around a point, with its ridge along x and a dormer.
fn house(offset: [f64; 3]) -> String {
    let corners = [[-6.0, -4.0], [6.0, -4.0], [6.0, 4.0], [-6.0, 4.0]];
    let walls = [-3.5, 1.0].into_iter().flat_map(|height| corners.map(|[x, z]| [x, height, z]));
    let roof = [[-6.0, 3.5, 0.0], [6.0, 3.5, 0.0]];
    let dormer = [[-1.07, 1.63, 3.11], [1.07, 1.63, 3.11], [0.0, 3.12, 3.11]];
    let places = walls.chain(roof).chain(dormer);
    let line =
        |place: [f64; 3]| format!("v {} {} {}\n", place[0] + offset[0], place[1] + offset[1], place[2] + offset[2]);
    let faces = "f 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\nf 5 9 10 6\nf 7 10 9 8\nf 6 10 7\nf 8 9 5\nf 11 12 13\n";
    places.map(line).collect::<String>() + faces
}

#[test]
fn a_house_at_utm_coordinates_looks_as_at_the_origin() {
    let folder = Folder::new("formats-far");
    let offset = [432_100.0, 210.5, -5_512_345.0];
    folder.write("near.obj", house([0.0; 3]).as_bytes());
    folder.write("far.obj", house(offset).as_bytes());
    let info = |name: &str| -> serde_json::Value {
        serde_json::from_str(&run_in(&folder, &["info", name, "--json"]).expect(0).text()).expect("JSON")
    };
    let (near, far) = (info("near.obj"), info("far.obj"));
    assert_eq!(far["warnings"], serde_json::json!([]));
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    for (axis, offset) in offset.into_iter().enumerate() {
        let eyes = [&near, &far].map(|info| number(&info["automatic_camera"]["eye_world_m"][axis]));
        assert!((eyes[1] - eyes[0] - offset).abs() < 1e-4, "{eyes:?}");
        let least = [&near, &far].map(|info| number(&info["bounds_m"]["min"][axis]));
        assert_eq!(least[1] - least[0], offset);
    }
    if has_adapter() {
        let drawn = |name: &str| {
            let run = run_in(&folder, &[&["render", name, "-o", "-"][..], &SMALL].concat()).expect(0);
            assert!(!run.stderr.contains("warning"), "{}", run.stderr);
            picture(&run.stdout)
        };
        let (near, far) = (drawn("near.obj"), drawn("far.obj"));
        assert_eq!(difference(&near, &far, 1).share, 1.0);
    }
}

/// A triangle of a metre in an STL of bytes, which has floats alone.
fn triangle(x: f32) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend([0; 12]);
    bytes.extend([[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]].into_iter().flatten().flat_map(f32::to_le_bytes));
    bytes.extend([0; 2]);
    bytes
}

#[test]
fn coarse_positions_far_from_the_origin_are_warned_of() {
    let folder = Folder::new("far-coarse");
    folder.write("far.stl", &triangle(500_000.0));
    folder.write("near.stl", &triangle(50.0));
    let said = |run: common::Run| run.text() + &run.stderr;
    let warning = "it lies 500000 m from the origin and is 1.41 m across: positions there are rounded to 0.0312 m";
    assert!(said(run_in(&folder, &["info", "far.stl", "--json"]).expect(0)).contains(warning));
    assert!(!said(run_in(&folder, &["info", "near.stl", "--json"]).expect(0)).contains("from the origin"));
    if has_adapter() {
        let run = run_in(&folder, &[&["render", "far.stl"][..], &SMALL].concat()).expect(0);
        assert!(run.stderr.contains(&format!("warning: far.stl: {warning}")), "{}", run.stderr);
    }
}
