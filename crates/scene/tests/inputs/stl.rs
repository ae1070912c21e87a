use super::{check, load, primitives, refusal, survives};
use proptest::prelude::*;

fn bytes_of(header: &str, count: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    for triangle in triangles {
        bytes.extend([[f32::NAN; 3]].iter().chain(triangle).flatten().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

/// A roof: two triangles that meet at a right angle.
const ROOF: [[[f32; 3]; 3]; 2] =
    [[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]], [[0.0, 1.0, 1.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]];

const TEXT: &str =
    "solid my part\n facet normal 0 0 0\n  outer loop\n   vertex 0 0 1\n   vertex 1 0 0\n   vertex 0 1 1e0\n  endloop
 endfacet\nendsolid my part\r\nSOLID other\nendsolid\n";

#[test]
fn bytes_that_begin_with_solid_are_bytes_and_z_points_up() {
    for header in ["", "solid", "solid facet of a part"] {
        let loaded = load("a", &bytes_of(header, 2, &ROOF)).unwrap();
        check(&loaded);
        let found = primitives(&loaded)[0];
        // Two corners are shared and lie at a crease.
        assert_eq!((found.positions.len(), found.indices.len()), (6, 6));
        assert!(found.positions.contains(&[0.0, 1.0, -1.0]) && found.positions.contains(&[1.0, 0.0, 0.0]));
        assert!(found.normals.iter().all(|normal| normal[1] > 0.7));
        let material = &loaded.scene.materials[0];
        assert!(material.double_sided && material.metallic_factor == 0.0);
    }
}

#[test]
fn text_has_solids_with_names() {
    let loaded = load("a", TEXT.as_bytes()).unwrap();
    check(&loaded);
    assert_eq!(loaded.scene.nodes.len(), 1);
    assert_eq!(loaded.scene.nodes[0].name, "my part");
    let found = primitives(&loaded)[0];
    assert_eq!(found.positions, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, -1.0]]);
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let whole = bytes_of("", 2, &ROOF);
    assert!(refusal("a.stl", &whole[..150]).contains("byte 80: the header counts 2 triangles"));
    assert!(refusal("a.stl", &bytes_of("", u32::MAX, &ROOF)).contains("byte 80"));
    assert!(refusal("a.stl", &whole[..60]).contains("60 bytes"));
    assert!(refusal("a.stl", b"").contains("0 bytes"));
    let mut infinite = ROOF;
    infinite[1][2][0] = f32::INFINITY;
    assert!(refusal("a.stl", &bytes_of("", 2, &infinite)).contains("byte 170: a corner of triangle 1"));
    let text = |from: &str, to: &str| refusal("a.stl", TEXT.replacen(from, to, 1).as_bytes());
    assert!(text("vertex 1 0 0", "vertex 1 nan 0").contains("line 5: expected a finite number, found \"nan\""));
    assert!(text("vertex 1 0 0", "vertex 1 0").contains("line 5: expected 3 numbers"));
    assert!(text("   vertex 1 0 0\n", "").contains("line 7: a facet ends that does not have three vertices"));
    assert!(text(" endfacet\nendsolid my part\r\nSOLID other\nendsolid", "").contains("is it cut off?"));
    assert!(text("outer", "outre").contains("line 3: \"outre\" is not a word of STL"));
    let trailing = [&whole[..], b"more"].concat();
    assert!(load("a.stl", &trailing).unwrap().warnings[0].contains("byte 184"));
    assert!(load("a.stl", &bytes_of("", 0, &[])).unwrap().warnings[0].contains("draws nothing"));
}

proptest! {
    #[test]
    fn any_change_ends_without_a_panic(changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..6), cut in any::<usize>()) {
        survives("a.stl", &bytes_of("", 2, &ROOF), &changes, cut);
        survives("a.stl", TEXT.as_bytes(), &changes, cut);
    }
}
