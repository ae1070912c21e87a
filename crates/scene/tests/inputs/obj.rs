use super::{check, load, load_with, primitives, refusal, survives};
use manypass_scene::material::HeightMethod;
use manypass_scene::{AlphaMode, Topology, Wrap};
use proptest::prelude::*;

/// A picture of one texel.
fn png(rgb: [u8; 3]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(1, 1, image::Rgb(rgb)).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

const SQUARE: &str = "\
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0.25
vn 0 0 2
";

#[test]
fn faces_count_from_one_or_backwards_and_attributes_may_be_missing() {
    for face in ["f 1//1 2//1 3//1 4//1", "f -4//-1 -3//-1 -2//-1 -1//-1", "f 1//1 2//1 \\\n 3//1 4//1"] {
        let loaded = load("a", format!("{SQUARE}{face}\n").as_bytes()).unwrap();
        check(&loaded);
        let found = primitives(&loaded)[0];
        assert_eq!(found.indices, [0, 1, 2, 0, 2, 3], "{face}");
        assert_eq!(found.normals, [[0.0, 0.0, 1.0]; 4]);
        assert!(found.uv0.is_empty() && found.colors.is_empty());
    }
    let loaded = load("a", format!("{SQUARE}f 1/1/1 2/2 3\n").as_bytes()).unwrap();
    check(&loaded);
    let found = primitives(&loaded)[0];
    assert_eq!(found.uv0, [[0.0, 1.0], [1.0, 0.75], [0.0, 0.0]]);
    assert_eq!(found.normals, [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn objects_are_nodes_and_materials_are_primitives() {
    let text = format!("{SQUARE}o a\ng x\nf 1 2 3\nusemtl m\nf 1 3 4\no b\nf 1 2 3\no a\nf 1 2 4\n");
    let loaded = load("a.obj", text.as_bytes()).unwrap();
    check(&loaded);
    let names: Vec<&str> = loaded.scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!(loaded.scene.meshes[0].primitives.len(), 2);
    assert_eq!(loaded.scene.meshes[0].primitives[1].indices.len(), 6);
    let grouped = load("a.obj", format!("{SQUARE}g x\nf 1 2 3\ng y\nf 1 3 4\n").as_bytes()).unwrap();
    assert_eq!(grouped.scene.nodes.iter().map(|node| &node.name).collect::<Vec<_>>(), ["x", "y"]);
}

/// A roof of two quads that are one surface.
const ROOF: &str = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nv 1 2 0\nv 0 2 0\ns 1\n";

#[test]
fn backs_that_look_as_their_fronts_are_left_out_and_counted() {
    let alone = load("a.obj", format!("{ROOF}f 1 2 3 4\nf 4 3 5 6\n").as_bytes()).unwrap();
    let backs_of = [
        // Of the same vertices, from another corner on.
        "f 1 2 3 4\nf 3 2 1 4\nf 4 3 5 6\nf 5 3 4 6\n",
        // Fronts first, then backs in another order.
        "f 1 2 3 4\nf 4 3 5 6\nf 6 5 3 4\nf 4 3 2 1\n",
        // Of vertices of their own.
        "f 1 2 3 4\nf 4 3 5 6\nv 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nf -1 -2 -3 -4\nv 1 2 0\nv 0 2 0\nf -1 -2 -4 -3\n",
    ];
    for (faces, line) in backs_of.into_iter().zip([9, 10, 14]) {
        let loaded = load("a.obj", format!("{ROOF}{faces}").as_bytes()).unwrap();
        check(&loaded);
        assert_eq!(primitives(&loaded), primitives(&alone), "{faces}");
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        assert!(warning.starts_with(&format!("line {line} (first of 2): a face repeats another one")), "{warning}");
        assert!(loaded.scene.materials.iter().all(|material| material.double_sided));
    }
    assert!(alone.warnings.is_empty());
}

#[test]
fn backs_that_look_otherwise_are_drawn_from_their_side_alone() {
    let of_materials = format!("{ROOF}usemtl a\nf 1 2 3 4\nf 4 3 5 6\nusemtl b\nf 4 3 2 1\n");
    let loaded = load("a.obj", of_materials.as_bytes()).unwrap();
    check(&loaded);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let looks: Vec<(String, bool, usize)> = primitives(&loaded)
        .iter()
        .map(|primitive| {
            let material = &loaded.scene.materials[primitive.material.unwrap()];
            (material.name.clone(), material.double_sided, primitive.indices.len())
        })
        .collect();
    let expected =
        [("a", true, 6_usize), ("a", false, 6), ("b", false, 6)].map(|(name, both, n)| (name.to_owned(), both, n));
    assert_eq!(looks, expected);
    // The back is smoothed by itself, and the front with the other side of the roof.
    let back = glam::Vec3::new(0.0, 1.0, -1.0).normalize();
    assert!(primitives(&loaded)[2].normals.iter().all(|normal| back.abs_diff_eq((*normal).into(), 1e-6)));
    assert!(primitives(&loaded)[1].normals.iter().any(|normal| glam::Vec3::Z.abs_diff_eq((*normal).into(), 1e-6)));

    // Other coordinates on the texture, other colours.
    let uvs = format!("{SQUARE}f 1/1 2/2 3/1\nf 3/2 2/2 1/1\n");
    let colors =
        "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 0 0 0 0 0 1\nv 1 0 0 0 0 1\nv 0 1 0 0 0 1\nf 1 2 3\nf 6 5 4\n";
    for text in [uvs.as_str(), colors] {
        let loaded = load("a.obj", text.as_bytes()).unwrap();
        check(&loaded);
        let [both] = primitives(&loaded)[..] else { panic!("{text}") };
        assert!(!loaded.scene.materials[both.material.unwrap()].double_sided && loaded.warnings.is_empty(), "{text}");
        assert_eq!(both.normals, [[[0.0, 0.0, 1.0]; 3], [[0.0, 0.0, -1.0]; 3]].concat(), "{text}");
    }
}

#[test]
fn backs_with_normals_of_the_file_stay() {
    let text = format!("{SQUARE}vn 0 0 -1\nf 1//1 2//1 3//1\nf 3//2 2//2 1//2\n");
    let loaded = load("a.obj", text.as_bytes()).unwrap();
    check(&loaded);
    assert!(primitives(&loaded)[0].indices.len() == 6 && loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert!(loaded.scene.materials[0].double_sided);
}

#[test]
fn colours_of_vertices_lines_and_points_are_read() {
    let text = "v 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 0 0 0\nl 1 2 3\np 1 2\nf 1 2 3\n";
    let loaded = load("a.obj", text.as_bytes()).unwrap();
    check(&loaded);
    let [triangle, lines, points] = primitives(&loaded)[..] else { panic!("three") };
    assert_eq!(
        [triangle.topology, lines.topology, points.topology],
        [Topology::Triangles, Topology::Lines, Topology::Points]
    );
    assert_eq!((lines.indices.as_slice(), points.indices.len()), (&[0, 1, 1, 2][..], 2));
    // 0.5 of sRGB is 0.214 of light.
    let [red, blue] = [triangle.colors[0][0], triangle.colors[0][2]];
    assert!(red == 1.0 && (blue - 0.2140).abs() < 1e-3 && triangle.colors[1] == [1.0; 4]);
    assert_eq!(loaded.scene.materials[0].base_color_factor, glam::Vec4::ONE);
}

#[test]
fn materials_become_those_of_metallic_roughness() {
    let library = "# made by hand\nnewmtl plain\nKd 0.5 0.25 0\nKs 0 0 0\nNs 500\nnewmtl glossy\nKs 1 1 1\nNs 30\nKe 0 2 0\n\
        newmtl metal\nPr 0.25\nPm 1\nTr 0.25\nnewmtl cut\nKd 0 0 0\nmap_Kd -s 2 3 1 -o 0.5 0.25 -clamp on in/a b.png\nmap_d in\\a b.png\n\
        map_Bump -bm 0.5 n.png\nnewmtl grey\nmap_bump -bm -3 grey.png\nmap_Kd gone.png\n";
    let uses: String = ["plain", "glossy", "metal", "cut", "grey", "none"]
        .iter()
        .map(|name| format!("usemtl {name}\nf 1/1 2/2 3/1\n"))
        .collect();
    let text = format!("mtllib lib/m.mtl\n{SQUARE}{uses}");
    let files = [
        ("lib/m.mtl", library.as_bytes()),
        ("lib/in/a b.png", &png([200, 10, 10])),
        ("lib/n.png", &png([128, 128, 255])),
        ("lib/grey.png", &png([90; 3])),
    ];
    let loaded = load_with("a.obj", text.as_bytes(), &files);
    check(&loaded);
    let [plain, glossy, metal, cut, grey, none] = &loaded.scene.materials[..] else { panic!("six") };
    assert_eq!((plain.name.as_str(), plain.base_color_factor.to_array()), ("plain", [0.5, 0.25, 0.0, 1.0]));
    assert_eq!((plain.roughness_factor, plain.metallic_factor), (1.0, 0.0));
    // docs/lighting.md: n = 2 / α² − 2, with α the square of the roughness.
    let alpha = glossy.roughness_factor.powi(2);
    assert!((2.0 / (alpha * alpha) - 2.0 - 30.0).abs() < 1e-3, "{}", glossy.roughness_factor);
    assert_eq!(glossy.emissive_factor.to_array(), [0.0, 2.0, 0.0]);
    assert_eq!((metal.roughness_factor, metal.metallic_factor), (0.25, 1.0));
    assert_eq!((metal.alpha_mode, metal.base_color_factor.w), (AlphaMode::Blend, 0.75));
    let texture = cut.base_color_texture.unwrap();
    assert_eq!(cut.base_color_factor.to_array(), [1.0; 4]);
    assert_eq!(cut.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(loaded.scene.textures[texture.texture].sampler.wrap_u, Wrap::ClampToEdge);
    // The file's coordinate (u, v) looks up (2 u + 0.5, 3 v + 0.25), counted from below.
    let looked_up = texture.transform.matrix() * glam::Vec3::new(0.5, 1.0 - 0.25, 1.0);
    assert!(looked_up.abs_diff_eq(glam::Vec3::new(1.5, 1.0 - 1.0, 1.0), 1e-6), "{looked_up}");
    assert_eq!((cut.normal_texture.is_some(), cut.normal_scale), (true, 0.5));
    assert!(grey.normal_texture.is_none() && grey.base_color_texture.is_none() && none.name == "none");
    // Of a square of a metre: a hundredth of its diagonal for each unit.
    let height = grey.height.unwrap();
    let image = loaded.scene.textures[height.texture.texture].image;
    assert_eq!((height.method, loaded.scene.images[image].name.as_str()), (HeightMethod::Bump, "lib/grey.png"));
    assert!((height.depth_m + 0.03 * 2f32.sqrt()).abs() < 1e-6 && !height.self_shadow, "{height:?}");
    assert!(cut.height.is_none());
    let has_tangents = primitives(&loaded).iter().filter(|primitive| !primitive.tangents.is_empty()).count();
    assert_eq!(has_tangents, 1);
    for expected in ["\"lib/gone.png\": there is no lib/gone.png", "no library has the material \"none\""] {
        assert!(loaded.warnings.iter().any(|warning| warning.contains(expected)), "{expected}: {:?}", loaded.warnings);
    }
}

#[test]
fn displacement_is_relief() {
    let library = "newmtl wall\ndisp -mm 0.5 3 h.png\nmap_Bump n.png\nnewmtl both\nmap_Bump h.png\nmap_disp h.png\n\
        newmtl hollow\ndisp -mm 0 -2 h.png\nnewmtl flat\ndisp -mm 0 0 h.png\n";
    let uses: String =
        ["wall", "both", "hollow", "flat"].iter().map(|name| format!("usemtl {name}\nf 1/1 2/2 3/1\n")).collect();
    let text = format!("mtllib m.mtl\n{SQUARE}{uses}");
    let files = [("m.mtl", library.as_bytes()), ("h.png", &png([90; 3])), ("n.png", &png([128, 128, 255]))];
    let loaded = load_with("a.obj", text.as_bytes(), &files);
    check(&loaded);
    let heights: Vec<_> = loaded.scene.materials.iter().map(|material| material.height).collect();
    let [Some(wall), Some(both), Some(hollow), None] = heights[..] else { panic!("{heights:?}") };
    // Hundredths of the diagonal of a square of a metre.
    for (height, hundredths) in [(wall, 3.0), (both, 1.0)] {
        assert!((height.depth_m - 0.01 * hundredths * 2f32.sqrt()).abs() < 1e-6, "{height:?}");
        assert!(height.method == HeightMethod::Occlusion && height.self_shadow, "{height:?}");
    }
    assert!(hollow.method == HeightMethod::Bump && hollow.depth_m < 0.0 && !hollow.self_shadow, "{hollow:?}");
    assert!(loaded.scene.materials[0].normal_texture.is_some(), "normals of map_Bump stay beside it");
    let said = "material \"both\": disp takes the place of the heights of map_Bump";
    assert_eq!(loaded.warnings.iter().filter(|warning| warning.contains(said)).count(), 1, "{:?}", loaded.warnings);
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let with = |rest: &str| refusal("a.obj", format!("{SQUARE}{rest}\n").as_bytes());
    assert!(with("f 1 2 5").contains("line 8: v 5 is named, and the file has 4"));
    assert!(with("f 1 2 -5").contains("line 8: \"-5\" is not a vertex"));
    assert!(with("f 1 2 0").contains("line 8: \"0\" is not a vertex"));
    assert!(with("f 1/1 2/1 3/9").contains("line 8: vt 9"));
    assert!(with("f 1//2 2 3").contains("line 8: vn 2"));
    assert!(with("f 1 2 99999999999999999999").contains("line 8"));
    assert!(with("\nv 1 inf 2").contains("line 9: expected a finite number, found \"inf\""));
    assert!(with("v 1e99 1 2").contains("line 8"));
    assert!(with("v 1 2").contains("line 8: expected 3 numbers"));
    assert!(refusal("a.obj", b"# nothing\n").contains("it has no vertices"));
    assert!(refusal("a.obj", b"").contains("it has no vertices"));
    assert!(refusal("a.obj", &[0xff; 200]).contains("it has no vertices"));
    // Names need not be UTF-8.
    let loaded = load("a.obj", &[SQUARE.as_bytes(), b"o caf\xe9\nmtllib no.mtl\nf 1 2 3\n"].concat()).unwrap();
    assert_eq!(loaded.scene.nodes[0].name, "café");
    assert!(loaded.warnings[0].contains("no.mtl"));
}

#[test]
fn every_file_that_is_named_is_known() {
    let folder = std::env::temp_dir().join(format!("manypass-obj-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("lib")).unwrap();
    std::fs::write(folder.join("a.obj"), "mtllib lib/m.mtl\nmtllib ../out.mtl\nv 1 2 3\n").unwrap();
    std::fs::write(folder.join("lib/m.mtl"), "newmtl a\nmap_Kd a b.png\nmap_Bump -bm 2 C:\\n.png\nmap_Ke ../e.png\n")
        .unwrap();
    let model = folder.join("a.obj");
    let read = |name: &str| std::fs::read(folder.join(name)).map_err(|error| error.to_string());
    let named = manypass_scene::formats::named_files(&std::fs::read(&model).unwrap(), &mut |name| read(name));
    let inside = ["lib/m.mtl", "e.png", "lib/a b.png", "lib/n.png"];
    assert_eq!(named, inside);
    let expected = inside.map(|name| folder.join(name));
    assert_eq!(manypass_scene::formats::references(&model).unwrap(), expected);
    let mentions = manypass_scene::formats::mentions(&model).unwrap();
    for name in ["lib/m.mtl", "lib/a b.png", "e.png"] {
        assert!(mentions.contains(&folder.join(name)), "{name}: {mentions:?}");
    }
    assert!(mentions.contains(&folder.parent().unwrap().join("out.mtl")));
    let _ = std::fs::remove_dir_all(folder);
}

proptest! {
    #[test]
    fn any_change_ends_without_a_panic(changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..6), cut in any::<usize>()) {
        let text = format!("{SQUARE}mtllib m.mtl\nusemtl m\ns 1\nf 1/1 2/2/1 3 4\np 1 2\nl 1 2\nv 0 0 0 1 1 1\nf 1 2 -1 3 4\n");
        survives("a.obj", text.as_bytes(), &changes, cut);
        let mut library = b"newmtl m\nKd 1 1 1\nmap_Kd -s 1 2 -o 1 2 a.png\nNs 4\nd 0.5\nmap_Bump -bm 2 b.png\n".to_vec();
        for (place, byte) in changes {
            let place = place % library.len();
            library[place] = byte;
        }
        load_with("a.obj", text.as_bytes(), &[("m.mtl", &library), ("a.png", &png([1, 2, 3])), ("b.png", &library)]);
    }
}
