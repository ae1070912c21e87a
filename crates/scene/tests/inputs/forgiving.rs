//! What the picture does not need is never a reason to refuse: a default is taken, and one warning counts it.

use super::{check, load, load_with, primitives};
use manypass_scene::{AlphaMode, LoadedScene, Topology};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 0\n";

/// A picture of one texel.
fn png() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(1, 1, image::Rgb([200, 10, 10])).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A file is read, draws so many triangles, and says one thing; nothing where that is empty.
#[track_caller]
fn draws(loaded: &LoadedScene, triangles: usize, said: &str, about: &str) {
    check(loaded);
    let found: usize = primitives(loaded).iter().map(|primitive| primitive.indices.len() / 3).sum();
    assert_eq!(found, triangles, "{about}: {:?}", loaded.warnings);
    match said {
        "" => assert!(loaded.warnings.is_empty(), "{about}: {:?}", loaded.warnings),
        _ => assert!(loaded.warnings.len() == 1 && loaded.warnings[0].contains(said), "{about}: {:?}", loaded.warnings),
    }
}

#[test]
fn obj_is_read_whatever_its_lines_hold_besides() {
    for (lines, triangles, said) in [
        ("f 1 2 3 # a face", 1, ""),
        ("f 1 2 4 3#a quad\nv 0 0 0 # v", 2, ""),
        ("f 1\nf 1 2 3\nf 1 2\n", 1, "line 7 (first of 2): a face of fewer than three corners"),
        ("l 1\nf 1 2 3", 1, "line 7: a line of fewer than two vertices"),
        ("p\nf 1 2 3", 1, "points without a vertex"),
        ("cstype bezier\nf 1 2 3\ncstype bezier", 1, "line 7 (first of 2): \"cstype\" is not read"),
        ("xyzzy 1\nplugh\nf 1 2 3", 1, "line 7 (first of 2): \"xyzzy\" is not a statement of OBJ"),
        ("f 1 2 4 \\\n 3", 2, ""),
        ("f 1//1 2//1 3//1", 1, ""),
    ] {
        let loaded = load("a.obj", format!("{OBJ}{lines}\n").as_bytes()).unwrap();
        let zero = "line 6: a normal has no direction";
        let others: Vec<&String> = loaded.warnings.iter().filter(|warning| !warning.contains(zero)).collect();
        assert_eq!(others.len() + 1, loaded.warnings.len(), "{lines}: {:?}", loaded.warnings);
        let loaded = LoadedScene { warnings: others.into_iter().cloned().collect(), ..loaded.clone() };
        draws(&loaded, triangles, said, lines);
        assert!(primitives(&loaded)[0].normals.iter().all(|normal| *normal == [0.0, 0.0, 1.0]), "{lines}");
    }
    let of_old = format!("{OBJ}f 1 2 3\n").replace("vn 0 0 0\n", "").replace('\n', "\r");
    draws(&load("a.obj", of_old.as_bytes()).unwrap(), 1, "", "lines that end in CR");
}

#[test]
fn colours_of_obj_from_0_to_255_are_shares_of_that() {
    let bytes = b"v 0 0 0 255 0 128\nv 1 0 0 0 255 0\nv 0 1 0\nf 1 2 3\n";
    let loaded = load("a.obj", bytes).unwrap();
    draws(&loaded, 1, "from 0 to 255", "colours");
    let colors = &primitives(&loaded)[0].colors;
    assert!(colors[0][0] == 1.0 && (colors[0][2] - 0.2158).abs() < 1e-3 && colors[2] == [1.0; 4], "{colors:?}");
}

#[test]
fn materials_say_opacity_twice_and_name_textures_in_every_way() {
    let of = |statements: &str| {
        let library = format!("newmtl m\nKd 1 0 0\n{statements}\n");
        let text = format!("mtllib m.mtl\n{OBJ}usemtl m\nf 1/1 2/1 3/1\n").replace("vn 0 0 0\n", "");
        load_with("a.obj", text.as_bytes(), &[("m.mtl", library.as_bytes()), ("tex/a.png", &png()), ("a.png", &png())])
    };
    for (statements, alpha, said) in [
        ("d 1.0\nTr 1.0", 1.0, ""),
        ("Tr 0.75\nd 0.25", 0.25, ""),
        ("d 0.5\nTr 0.9", 0.5, "d 0.5 and Tr 0.9 contradict each other"),
        ("Tr 1", 0.0, "Tr 1 without d"),
        ("Tr 0.25", 0.75, ""),
        ("d half", 1.0, "m.mtl: line 3: expected a finite number, found \"half\""),
        ("Ka 1 1 1\nillum 2\nNi 1.45\nPc 0\nTf 1 1 1", 1.0, ""),
        ("Pc 0.5", 1.0, "m.mtl: line 3: \"pc\" is not read"),
        ("refl a.png\nrefl b.png", 1.0, "m.mtl: line 3 (first of 2): \"refl\" is not read"),
    ] {
        let loaded = of(statements);
        draws(&loaded, 1, said, statements);
        let material = &loaded.scene.materials[0];
        assert_eq!(material.base_color_factor.to_array(), [1.0, 0.0, 0.0, alpha], "{statements}");
        assert_eq!(material.alpha_mode == AlphaMode::Blend, alpha < 1.0);
    }
    for (name, said) in [
        ("tex/a.png", ""),
        (".\\tex\\a.png", ""),
        (".\\\\tex\\\\a.png", ""),
        ("x/../tex/a.png", ""),
        ("C:\\Users\\x\\a.png", "\"a.png\" beside the model is taken"),
        ("/home/x/a.png", "\"a.png\" beside the model is taken"),
        ("\\\\server\\share\\a.png", "\"a.png\" beside the model is taken"),
    ] {
        let loaded = of(&format!("map_Kd {name}"));
        draws(&loaded, 1, said, name);
        assert!(loaded.scene.materials[0].base_color_texture.is_some(), "{name}");
    }
    let loaded = of("Kd 255 127 0");
    draws(&loaded, 1, "Kd is above 1; it is taken to be from 0 to 255", "Kd");
    assert_eq!(loaded.scene.materials[0].base_color_factor.x, 1.0);
}

const STL: &str = "solid x\nfacet normal 0 -1 0\nouter loop\nvertex -1 0 -1\nvertex 1 0 -1\nvertex 0 0 1\nendloop\nendfacet\nendsolid x\n";

#[test]
fn stl_is_read_however_it_ends() {
    for (from, to, said) in [
        ("endloop", "end loop", "line 7: \"end\" and what ends are two words"),
        ("endsolid", "end solid", "two words"),
        ("endsolid x\n", "", "the file ends before the solid does"),
        ("endsolid x\n", "endsolid x\n\x1a", ""),
        ("endsolid x\n", "endsolid x\n\0\0", ""),
        ("\n", "\r", ""),
        ("\n", "\r\n", ""),
    ] {
        draws(&load("a.stl", STL.replace(from, to).as_bytes()).unwrap(), 1, said, to);
    }
}

#[test]
fn binary_stl_has_colours_of_two_conventions() {
    let file = |header: &[u8], words: [u16; 2]| {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(2_u32.to_le_bytes());
        for word in words {
            let corners = [[0.0_f32; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            bytes.extend(corners.iter().flatten().flat_map(|value| value.to_le_bytes()));
            bytes.extend(word.to_le_bytes());
        }
        let loaded = load("a.stl", &bytes).unwrap();
        draws(&loaded, 2, "", "colours");
        let colors = primitives(&loaded)[0].colors.clone();
        let indices = primitives(&loaded)[0].indices.clone();
        [0, 3].map(|corner| indices.get(corner).and_then(|index| colors.get(*index as usize)).copied())
    };
    let (red, blue, grey) = ([1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0], [0.19, 0.22, 0.26, 1.0]);
    assert_eq!(file(b"", [0xfc00, 0x7c00]), [Some(red), Some(grey)], "VisCAM: bit 15 is set where there is a colour");
    let magics = file(b"COLOR=\x00\x00\xff\xff", [0x001f, 0x8000]);
    assert_eq!(magics, [Some(red), Some(blue)], "Magics: bit 15 is set where the object's colour counts");
    assert_eq!(file(b"", [0, 0]), [None, None]);
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n\
    property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

#[test]
fn ply_is_read_with_what_it_says_besides() {
    for (from, to, triangles, said) in [
        ("1 1 0", "1. +1.e0 .0", 2, ""),
        ("1 1 0", "1 1 -.0 99", 2, ""),
        ("0 1 0\n", "0 nan 0\n", 1, "face 1: a face with a corner without a position"),
        ("0 1 0\n", "0 1.#QNAN 0\n", 1, "face 1: a face with a corner without a position"),
        ("0 1 0\n", "0 inf 0\n", 1, "face 1: a face with a corner without a position"),
        ("3 0 2 3", "2 0 2", 1, "face 1: a face of fewer than three corners"),
        (
            "float z\n",
            "float z\nproperty float quality\n",
            2,
            "1 properties of the element \"vertex\" are not read: quality",
        ),
        ("end_header", "element edge 0\nproperty int vertex1\nend_header", 2, ""),
        (
            "end_header",
            "comment TextureFile a.png\nend_header",
            2,
            "no vertex and no face has coordinates on the texture",
        ),
    ] {
        let mut text = PLY.replacen(from, to, 1);
        if to.contains("quality") {
            for row in ["0 0 0\n", "1 0 0\n", "1 1 0\n", "0 1 0\n"] {
                text = text.replacen(row, &row.replace('\n', " 5\n"), 1);
            }
        }
        draws(&load("a.ply", text.as_bytes()).unwrap(), triangles, said, to);
    }
    let cloud = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\nnan nan nan\n1 1 1\n";
    let loaded = load("a.ply", cloud.as_bytes()).unwrap();
    check(&loaded);
    assert_eq!((primitives(&loaded)[0].topology, primitives(&loaded)[0].positions.len()), (Topology::Points, 2));
    assert!(
        loaded.warnings.len() == 1 && loaded.warnings[0].contains("1 of 3 points have no position"),
        "{:?}",
        loaded.warnings
    );
}

#[test]
fn ply_has_textures_and_colours_of_faces() {
    let wedges = PLY
        .replace("end_header", "property list uchar float texcoord\ncomment TextureFile a.png\nend_header")
        .replace("3 0 1 2", "3 0 1 2 6 0 0 1 0 1 1")
        .replace("3 0 2 3", "3 0 2 3 6 0 .5 1 1 0 1");
    let loaded = load_with("a.ply", wedges.as_bytes(), &[("a.png", &png())]);
    draws(&loaded, 2, "", "wedges");
    let found = primitives(&loaded)[0];
    assert!(loaded.scene.materials[found.material.unwrap()].base_color_texture.is_some());
    let uv_of = |corner: usize| found.uv0[found.indices[corner] as usize];
    assert_eq!(
        [uv_of(0), uv_of(1), uv_of(3)],
        [[0.0, 1.0], [1.0, 1.0], [0.0, 0.5]],
        "a corner at one place has two of them"
    );
    // Of vertices, under each of the names that writers give them.
    for [u, v] in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let of_vertices = PLY
            .replace("float z\n", &format!("float z\nproperty float {u}\nproperty double {v}\n"))
            .replace("end_header\n0 0 0\n1 0 0\n", "comment TextureFile a.png\nend_header\n0 0 0 .25 0\n1 0 0 1 .125\n")
            .replace("1 1 0\n0 1 0\n", "1 1 0 1 1\n0 1 0 0 1\n");
        let loaded = load_with("a.ply", of_vertices.as_bytes(), &[("a.png", &png())]);
        draws(&loaded, 2, "", u);
        let found = primitives(&loaded)[0];
        assert!(loaded.scene.materials[found.material.unwrap()].base_color_texture.is_some(), "{u}");
        assert_eq!(found.uv0, [[0.25, 1.0], [1.0, 0.875], [1.0, 0.0], [0.0, 0.0]], "{u}, {v}");
    }
    let faces = "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header";
    let faces =
        PLY.replace("end_header", faces).replace("3 0 1 2", "3 0 1 2 255 0 0").replace("3 0 2 3", "3 0 2 3 0 255 0");
    let loaded = load("a.ply", faces.as_bytes()).unwrap();
    draws(&loaded, 2, "", "colours of faces");
    let found = primitives(&loaded)[0];
    let color_of = |corner: usize| found.colors[found.indices[corner] as usize];
    assert_eq!([color_of(0), color_of(3)], [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]]);
    let gone = load_with("a.ply", wedges.as_bytes(), &[]);
    draws(&gone, 2, "texture \"a.png\": there is no a.png", "a texture that is not there");
}

#[test]
fn splats_are_named() {
    let properties: String =
        ["x", "y", "z", "f_dc_0", "scale_0", "rot_0"].map(|name| format!("property float {name}\n")).concat();
    let text = format!("ply\nformat ascii 1.0\nelement vertex 1\n{properties}end_header\n0 0 0 1 1 1\n");
    let loaded = load("a.ply", text.as_bytes()).unwrap();
    assert!(
        loaded.warnings.len() == 1 && loaded.warnings[0].contains("Gaussian splats are not drawn as such"),
        "{:?}",
        loaded.warnings
    );
}

/// A comb of so many teeth as a face.
fn comb(teeth: u32) -> String {
    let corner = |i: u32| format!("v {} {} 0\n", f64::from(i) / f64::from(2 * teeth), 0.5 * f64::from(i % 2));
    let vertices: String = (0..=2 * teeth).map(corner).collect();
    let count = 2 * teeth + 3;
    let face: String = (1..=count).map(|i| format!(" {i}")).collect();
    format!("{vertices}v 1 1 0\nv 0 1 0\nf{face}\n")
}

#[test]
fn polygons_of_many_corners_need_not_be_convex() {
    for teeth in [20, 150, 20_000] {
        let loaded = load("a.obj", comb(teeth).as_bytes()).unwrap();
        draws(&loaded, 2 * teeth as usize + 1, "", "comb");
        let found = primitives(&loaded)[0];
        let areas = found.indices.chunks_exact(3).map(|triangle| {
            let [a, b, c] =
                [0, 1, 2].map(|corner| glam::Vec3::from(found.positions[triangle[corner] as usize]).as_dvec3());
            0.5 * (b - a).cross(c - a).z
        });
        let (sum, least) = areas.fold((0.0, f64::MAX), |(sum, least), area| (sum + area, f64::min(least, area)));
        assert!((sum - 0.75).abs() < 1e-3 && least > -1e-7, "{teeth}: {sum} {least}");
    }
}

#[test]
fn lines_that_go_on_take_time_as_they_are_long() {
    let many = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nl {}1 2 3\n", "1 2 3 \\\n".repeat(100_000));
    let loaded = load("a.obj", many.as_bytes()).unwrap();
    assert_eq!(primitives(&loaded)[0].indices.len(), 2 * 300_002);
}
