use super::{check, load, primitives, refusal, survives};
use manypass_scene::{AlphaMode, LoadedScene};
use proptest::prelude::*;
use std::io::{Cursor, Write};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

fn archive(parts: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        archive.start_file(*name, SimpleFileOptions::default().compression_method(method)).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

const RELATIONSHIPS: &str = r#"<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/part.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

const MESH: &str = r#"<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="10" y="0" z="0"/><vertex x="0" y="0" z="10"/><vertex x="0" y="10" z="0"/></vertices>
<triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="2" v3="3" pid="4" p1="1"/><triangle v1="0" v2="3" v3="1" pid="5" p1="0" p2="1" p3="0"/></triangles></mesh>"#;

/// A model of an object with three kinds of triangles, shown by itself and twice within another.
fn model() -> String {
    format!(
        r##"<?xml version="1.0" encoding="UTF-8"?><model unit="centimeter" xmlns="core" xmlns:m="material"><resources>
<basematerials id="4"><base name="black" displaycolor="#000000"/><base name="a &amp; b" displaycolor="#FF000080"/></basematerials>
<m:colorgroup id="5"><m:color color="#00FF00"/><m:color color="#0000FFFF"/></m:colorgroup>
<object id="1" name="corner">{MESH}</object>
<object id="2"><components><component objectid="1"/><component objectid="1" transform="1 0 0 0 1 0 0 0 1 100 200 300"/></components></object>
</resources><build><item objectid="1"/><item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 0"/></build></model>"##
    )
}

pub(super) fn packed(model: &str) -> Vec<u8> {
    archive(
        &[("_rels/.rels", RELATIONSHIPS.as_bytes()), ("3D/part.model", model.as_bytes())],
        CompressionMethod::Deflated,
    )
}

fn positions_world(loaded: &LoadedScene, node: usize) -> Vec<[i32; 3]> {
    let node = &loaded.scene.nodes[node];
    let mesh = &loaded.scene.meshes[node.mesh.unwrap()];
    let positions = mesh.primitives.iter().flat_map(|primitive| &primitive.positions);
    positions
        .map(|&p| (1000.0 * node.world_from_object.transform_point3(p.into())).round().as_ivec3().to_array())
        .collect()
}

#[test]
fn parts_stand_in_metres_with_z_up_and_in_their_places() {
    let loaded = load("a", &packed(&model())).unwrap();
    check(&loaded);
    assert_eq!(loaded.scene.meshes.len(), 1);
    let names: Vec<&str> = loaded.scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["", "corner", "", "corner", "corner"]);
    // Ten centimetres up, and ten backwards.
    let first = positions_world(&loaded, 1);
    assert!(first.contains(&[0, 100, 0]) && first.contains(&[0, 0, -100]) && first.contains(&[100, 0, 0]), "{first:?}");
    // (100, 200, 300) of the component, then a quarter turn about Z: (-200, 100, 300).
    assert!(positions_world(&loaded, 4).contains(&[-2000, 3000, -1000]), "{:?}", positions_world(&loaded, 4));
}

#[test]
fn base_materials_and_colours_of_corners_are_read() {
    let loaded = load("a.3mf", &packed(&model())).unwrap();
    let [grey, red, colours] = &primitives(&loaded)[..] else { panic!("three") };
    let material = |primitive: &manypass_scene::Primitive| loaded.scene.materials[primitive.material.unwrap()].clone();
    assert!(material(grey).name.is_empty() && grey.colors.is_empty());
    assert_eq!((material(red).name.as_str(), material(red).alpha_mode), ("a & b", AlphaMode::Blend));
    assert_eq!(material(red).base_color_factor.to_array(), [1.0, 0.0, 0.0, 128.0 / 255.0]);
    assert_eq!(colours.colors, [[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0]]);
}

#[test]
fn objects_lie_in_several_parts() {
    let root = r#"<model xmlns:p="x"><resources><object id="1"><components><component objectid="7" p:path="/3D/Objects/o.model"/></components>
        </object></resources><build><item objectid="1"/></build></model>"#;
    let other = format!(r#"<model><resources><object id="7">{MESH}</object></resources><build/></model>"#);
    let parts = [("3D/3dmodel.model", root.as_bytes()), ("3D/Objects/o.model", other.as_bytes())];
    let loaded = load("a.3mf", &archive(&parts, CompressionMethod::Stored)).unwrap();
    check(&loaded);
    assert!(positions_world(&loaded, 2).contains(&[0, 10, 0]));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let with = |from: &str, to: &str| refusal("a.3mf", &packed(&model().replacen(from, to, 1)));
    assert!(with("x=\"10\"", "x=\"inf\"").contains("part \"3D/part.model\", byte "));
    assert!(with("x=\"10\"", "x=\"inf\"").contains("found \"inf\""));
    assert!(with("x=\"10\"", "").contains("<vertex> has no \"x\""));
    assert!(with("v1=\"0\"", "v1=\"4\"").contains("vertex 4 is named, and the mesh has 4"));
    assert!(with("centimeter", "mile").contains("\"unit\""));
    assert!(with("#00FF00", "green").contains("found \"green\""));
    assert!(with("100 200 300", "100 200").contains("twelve finite numbers"));
    assert!(with("<item objectid=\"1\"/>", "<item objectid=\"9\"/>").contains("object 9 is named"));
    assert!(with("</build>", "</bild>").contains("byte"));
    assert!(
        with("<component objectid=\"1\"/>", "<component objectid=\"2\"/>").contains("within each other without end")
    );
    assert!(
        with("objectid=\"1\"/><component", "objectid=\"1\" path=\"/gone.model\"/><component")
            .contains("part \"gone.model\"")
    );
    // Each object shows the one before twice.
    let doubled: String = (3..40)
        .map(|id| format!("<object id=\"{id}\"><components><component objectid=\"{0}\"/><component objectid=\"{0}\"/></components></object>", id - 1))
        .collect();
    let bomb = model()
        .replace("</resources>", &format!("{doubled}</resources>"))
        .replace("item objectid=\"2\"", "item objectid=\"39\"");
    assert!(refusal("a.3mf", &packed(&bomb)).contains("objects, and 20000 are possible"));
    let whole = packed(&model());
    assert!(refusal("a.3mf", &whole[..whole.len() / 2]).contains("not a 3MF file"));
    assert!(refusal("a.3mf", b"").contains("not a 3MF file"));
    let other = archive(&[("word/document.xml", b"<x/>")], CompressionMethod::Stored);
    assert!(refusal("a.docx", &other).contains("no part \"3D/3dmodel.model\""));
    assert!(refusal("a.3mf", &packed("<nothing/>")).contains("expected a <model>"));
    assert!(refusal("a.3mf", &packed("\u{1}")).contains("expected a <model>"));
}

#[test]
fn an_archive_does_not_fill_memory() {
    let spaces = format!("<model>{}</model>", " ".repeat(100 << 20));
    let bomb = packed(&spaces);
    assert!(bomb.len() < 1 << 20);
    assert!(refusal("a.3mf", &bomb).contains("unpacks to more"), "{}", bomb.len());
}

proptest! {
    #[test]
    fn any_change_ends_without_a_panic(changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..6), cut in any::<usize>()) {
        let model = model();
        survives("a.3mf", &packed(&model), &changes, cut);
        let mut bytes = model.into_bytes();
        for (place, byte) in changes {
            let place = place % bytes.len();
            bytes[place] = byte;
        }
        let parts = [("3D/3dmodel.model", &bytes[..])];
        survives("a.3mf", &archive(&parts, CompressionMethod::Stored), &[], cut);
    }
}

#[test]
fn textures_are_on_corners_by_coordinates_whose_v_points_up() {
    let mut png = Cursor::new(Vec::new());
    image::RgbImage::from_pixel(1, 1, image::Rgb([200, 10, 10])).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let textures = r#"<m:texture2d id="7" path="/3D/Textures/a.png" contenttype="image/png" tilestyleu="clamp"/>
        <m:texture2dgroup id="8" texid="7"><m:tex2coord u="0" v="0"/><m:tex2coord u="1" v="0.25"/><m:tex2coord u="0" v="1"/></m:texture2dgroup>"#;
    let model = model()
        .replace("<object id=\"1\"", &format!("{textures}<object id=\"1\""))
        .replace("v2=\"1\" v3=\"2\"/>", "v2=\"1\" v3=\"2\" pid=\"8\" p1=\"0\" p2=\"1\" p3=\"2\"/>");
    let packed = |files: &[(&str, &[u8])]| {
        let parts =
            [&[("_rels/.rels", RELATIONSHIPS.as_bytes()), ("3D/part.model", model.as_bytes())][..], files].concat();
        load("a.3mf", &archive(&parts, CompressionMethod::Deflated)).unwrap()
    };
    let loaded = packed(&[("3D/Textures/a.png", png.get_ref())]);
    check(&loaded);
    assert_eq!(loaded.warnings, [""; 0]);
    let found = primitives(&loaded)[0];
    let texture = loaded.scene.materials[found.material.unwrap()].base_color_texture.unwrap();
    assert_eq!(found.uv0, [[0.0, 1.0], [1.0, 0.75], [0.0, 0.0]]);
    assert_eq!(loaded.scene.textures[texture.texture].sampler.wrap_u, manypass_scene::Wrap::ClampToEdge);
    let gone = packed(&[]);
    check(&gone);
    assert!(gone.warnings.len() == 1 && gone.warnings[0].contains("3D/Textures/a.png"), "{:?}", gone.warnings);
}

#[test]
fn what_is_shown_too_often_is_refused_before_it_is_made() {
    let items = "<item objectid=\"1\"/>".repeat(20_001);
    assert!(refusal("a.3mf", &packed(&model().replace("<item objectid=\"1\"/>", &items))).contains("20004 objects"));
    let triangles = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>".repeat(6000);
    let many = model().replace("<triangles>", &format!("<triangles>{triangles}"));
    let items = "<item objectid=\"1\"/>".repeat(19_000);
    let said = refusal("a.3mf", &packed(&many.replace("<item objectid=\"1\"/>", &items)));
    assert!(said.contains("triangles, and 100000000 are possible"), "{said}");
}

#[test]
fn more_base_materials_than_can_be_drawn_are_colours_of_vertices() {
    let bases: String = (0..3000).map(|i| format!("<base name=\"{i}\" displaycolor=\"#{i:06X}\"/>")).collect();
    let triangles: String =
        (0..3000).map(|i| format!("<triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"9\" p1=\"{i}\"/>")).collect();
    let model = model()
        .replace("<object id=\"1\"", &format!("<basematerials id=\"9\">{bases}</basematerials><object id=\"1\""))
        .replace("<triangles>", &format!("<triangles>{triangles}"));
    let loaded = load("a.3mf", &packed(&model)).unwrap();
    check(&loaded);
    assert!(loaded.scene.materials.len() < 1005, "{}", loaded.scene.materials.len());
    assert!(
        loaded.warnings.iter().any(|warning| warning.contains("more than 1000 materials")),
        "{:?}",
        loaded.warnings
    );
}
