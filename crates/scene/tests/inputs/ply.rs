use super::{check, load, primitives, refusal, survives};
use manypass_scene::Topology;
use proptest::prelude::*;

const HEADER: &str = "comment by hand\nobj_info x\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z
property uchar red\nproperty uchar green\nproperty uchar blue\nproperty list uchar int neighbours\nproperty short quality\n";
const FACES: &str = "element face 2\nproperty list uchar uint vertex_indices\nproperty uchar flags\nelement extra 1\nproperty float f\nend_header\n";
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn text() -> String {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z} 255 188 0 2 7 8 -3\n")).collect();
    format!("ply\nformat ascii 1.0\n{HEADER}{FACES}{vertices}4 0 1 2 3 9\n3 2 1 0 9\n1.5\n")
}

/// The same as bytes, in either order.
fn bytes(is_big: bool) -> Vec<u8> {
    let order =
        |bytes: &[u8]| -> Vec<u8> { if is_big { bytes.iter().rev().copied().collect() } else { bytes.to_vec() } };
    let name = if is_big { "big" } else { "little" };
    let mut file = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}{FACES}").into_bytes();
    for [x, y, z] in CORNERS {
        file.extend(order(&x.to_le_bytes()));
        file.extend(order(&f64::from(y).to_le_bytes()));
        file.extend(order(&z.to_le_bytes()));
        file.extend([255, 188, 0, 2]);
        file.extend(
            [order(&7_i32.to_le_bytes()), order(&8_i32.to_le_bytes()), order(&(-3_i16).to_le_bytes())].concat(),
        );
    }
    for face in [&[0_u32, 1, 2, 3][..], &[2, 1, 0]] {
        file.push(face.len() as u8);
        face.iter().for_each(|index| file.extend(order(&index.to_le_bytes())));
        file.push(9);
    }
    file.extend(order(&1.5_f32.to_le_bytes()));
    file
}

#[test]
fn text_and_bytes_of_both_orders_are_the_same_mesh() {
    let expected = load("a", text().as_bytes()).unwrap();
    check(&expected);
    let mesh = primitives(&expected)[0].clone();
    assert_eq!(mesh.indices.len(), 9);
    // The second face lies on the first and looks the other way.
    assert_eq!(mesh.positions.len(), 4 + 3);
    assert!(mesh.colors.iter().all(|[r, g, b, a]| (*r, *b, *a) == (1.0, 0.0, 1.0) && (g - 0.503).abs() < 1e-3));
    for is_big in [false, true] {
        let loaded = load("a", &bytes(is_big)).unwrap();
        assert_eq!(primitives(&loaded)[0], &mesh, "{is_big}");
    }
    let windows = text().replace('\n', "\r\n");
    assert_eq!(primitives(&load("a", windows.as_bytes()).unwrap())[0], &mesh);
}

#[test]
fn points_without_faces_are_a_cloud_and_normals_are_kept() {
    let cloud = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float nx
property float ny\nproperty float nz\nelement face 0\nproperty list uchar int vertex_index\nend_header\n1 2 3 0 0 2\n4 5 6 1 0 0";
    let loaded = load("a", cloud.as_bytes()).unwrap();
    check(&loaded);
    let found = primitives(&loaded)[0];
    assert_eq!((found.topology, &found.positions), (Topology::Points, &vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]));
    assert_eq!(found.normals, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    let strips = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1
property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 2 1 0\n";
    let loaded = load("a", strips.as_bytes()).unwrap();
    assert_eq!(primitives(&loaded)[0].indices.len(), 9);
    let above = primitives(&loaded)[0].normals.iter().filter(|normal| normal[2] == 1.0).count();
    assert_eq!(above, 4);
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    for (from, to, expected) in [
        ("1 0 0 255", "1 one 0 255", "\"one\" is not a number"),
        ("4 0 1 2 3 9", "4 0 1 2 4 9", "face 0: vertex 4 is named, and the file has 4"),
        ("3 2 1 0 9", "3 2 1 0", "line 2"),
        ("vertex 4", "vertex 4000000000", "counts 4000000000 of the element \"vertex\""),
        ("vertex 4", "vertex 5", "line "),
        ("property float x", "property float w", "no number \"x\""),
        ("property float x", "property list uchar float x", "no number \"x\""),
        ("element vertex", "element vortex", "no element \"vertex\""),
        ("property float f", "comment", "no properties"),
        ("end_header", "", "line "),
    ] {
        let found = refusal("a.ply", text().replacen(from, to, 1).as_bytes());
        assert!(found.to_lowercase().contains(expected), "{expected}: {found}");
    }
    let cut = bytes(false);
    assert!(refusal("a.ply", &cut[..cut.len() - 30]).contains("after byte "));
    assert!(!refusal("a.ply", b"").is_empty() && !refusal("a.ply", b"ply\n").is_empty());
    let endless =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z
property list uint double l\nend_header\n\0\0\0\u{7f}\u{7f}\u{7f}\u{7f}";
    assert!(refusal("a.ply", endless.as_bytes()).contains("after byte"));
}

proptest! {
    #[test]
    fn any_change_ends_without_a_panic(changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..6), cut in any::<usize>()) {
        survives("a.ply", text().as_bytes(), &changes, cut);
        survives("a.ply", &bytes(true), &changes, cut);
    }
}
