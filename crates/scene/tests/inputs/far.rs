//! Places far from the origin keep the digits that files have: floats are half a metre apart there.

use super::threemf::packed;
use super::{check, load};
use glam::Vec3;
use manypass_scene::{LoadedScene, Scene};

/// A triangle with legs of a centimetre, at a place of UTM coordinates in metres.
const CORNERS: [&str; 3] = ["500000.25 4649776.125 100", "500000.26 4649776.125 100", "500000.25 4649776.135 100"];

fn lines(before: &str, after: &str) -> String {
    CORNERS.map(|corner| format!("{before}{corner}{after}")).concat()
}

/// The vertices of each node in world space.
fn places_world(scene: &Scene) -> Vec<Vec<Vec3>> {
    let of_node = |node: &manypass_scene::Node| {
        let primitives = &scene.meshes[node.mesh?].primitives;
        let positions = primitives.iter().flat_map(|primitive| &primitive.positions);
        Some(positions.map(|position| node.world_from_object.transform_point3((*position).into())).collect())
    };
    scene.nodes.iter().filter_map(of_node).collect()
}

/// Brings it near, and looks whether every node shows the triangle there.
fn near(mut loaded: LoadedScene, name: &str) -> Vec<Vec<Vec3>> {
    check(&loaded);
    assert!(loaded.scene.bring_near(), "{name}");
    let nodes = places_world(&loaded.scene);
    for places in &nodes {
        let mut sides_m = [0, 1, 2].map(|i| places[i].distance(places[(i + 1) % 3]));
        sides_m.sort_by(f32::total_cmp);
        let expected = [0.01, 0.01, 0.02_f32.sqrt() * 0.1];
        assert!(
            sides_m.iter().zip(expected).all(|(side, expected)| (side - expected).abs() < 1e-6),
            "{name}: {sides_m:?}"
        );
    }
    nodes
}

#[test]
fn a_centimetre_is_one_in_every_format() {
    let ply = |encoding: &str| {
        let coordinates = ["x", "y", "z"].map(|axis| format!("property double {axis}\n")).concat();
        let faces = "element face 1\nproperty list uchar int vertex_indices\n";
        format!("ply\nformat {encoding} 1.0\nelement vertex 3\n{coordinates}{faces}end_header\n")
    };
    let mut bytes = ply("binary_little_endian").into_bytes();
    let numbers = CORNERS.iter().flat_map(|corner| corner.split(' ')).map(|word| word.parse::<f64>().unwrap());
    bytes.extend(numbers.flat_map(f64::to_le_bytes));
    bytes.push(3);
    bytes.extend([0_i32, 1, 2].into_iter().flat_map(i32::to_le_bytes));
    let facet = format!("facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n", lines("vertex ", "\n"));
    let files: [(&str, Vec<u8>); 4] = [
        ("a.obj", (lines("v ", "\n") + "f 1 2 3\n").into_bytes()),
        ("a.stl", format!("solid a\n{facet}endsolid a\n").into_bytes()),
        ("text.ply", (ply("ascii") + &lines("", "\n") + "3 0 1 2\n").into_bytes()),
        ("bytes.ply", bytes),
    ];
    for (name, bytes) in files {
        let loaded = load(name, &bytes).unwrap();
        let translation = loaded.scene.nodes[0].translation.abs();
        assert!((translation.x - 500_000.0).abs() < 1.0 && translation.max_element() > 4_649_775.0, "{name}");
        assert_eq!(near(loaded, name).len(), 1, "{name}");
    }
}

#[test]
fn meshes_and_items_of_3mf_keep_their_digits() {
    let vertices =
        |corners: [[f64; 3]; 3]| corners.map(|[x, y, z]| format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")).concat();
    let object = |id: u32, vertices: String| {
        let triangle = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>";
        format!(
            "<object id=\"{id}\"><mesh><vertices>{vertices}</vertices><triangles>{triangle}</triangles></mesh></object>"
        )
    };
    let here = object(1, vertices([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]]));
    let [x, y] = [500_000_250.0, 4_649_776_125.0];
    let there = object(2, vertices([[x, y, 0.0], [x + 10.0, y, 0.0], [x, y + 10.0, 0.0]]));
    let item = |id: u32, x: f64, y: f64| format!("<item objectid=\"{id}\" transform=\"1 0 0 0 1 0 0 0 1 {x} {y} 0\"/>");
    // Two beside each other, and the other mesh beside those.
    let items = [item(1, x, y), item(1, x + 20.0, y), item(2, 40.0, 0.0)].concat();
    let model =
        format!("<model unit=\"millimeter\"><resources>{here}{there}</resources><build>{items}</build></model>");
    let nodes = near(load("a.3mf", &packed(&model)).unwrap(), "a.3mf");
    let first: Vec<Vec3> = nodes.iter().map(|places| places[0]).collect();
    assert_eq!(first.len(), 3);
    for (place, expected_m) in first.iter().zip([0.0, 0.02, 0.04]) {
        assert!(place.distance(first[0] + expected_m * Vec3::X) < 1e-6, "{first:?}");
    }
}
