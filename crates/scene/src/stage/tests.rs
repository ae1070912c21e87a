#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod effects;
mod views;

use super::keys::TABLES;
use super::*;
use crate::light::LIGHTS_MAX;
use crate::material::LightEncoding;
use crate::{Levels, Light, LightKind, Material, Mesh, Node, Primitive, Scene, SceneRoots};
use glam::Vec3;
use std::path::Path;

/// A model with a lamp on a node called `Post`, a sun, a floor and a glass.
fn model() -> Scene {
    let mut scene = Scene::default();
    scene.materials.push(Material { name: "glass".into(), ..Material::default() });
    for (name, kind) in [("Lamp", LightKind::Point), ("Sun", LightKind::Directional)] {
        scene.lights.push(Light { name: name.into(), kind, ..Light::default() });
    }
    for (name, light) in [("Post", Some(0)), ("Sky", Some(1)), ("Floor", None)] {
        scene.add_node(None, Node { name: name.into(), light, ..Node::default() });
    }
    scene.scenes = ["day", "night"].map(|name| SceneRoots { name: name.into(), roots: scene.roots.clone() }).into();
    scene
}

fn applied(text: &str) -> Result<Scene, String> {
    let stage =
        Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
    let mut scene = model();
    stage.apply(&mut scene).map_err(|error| error.to_string())?;
    Ok(scene)
}

#[test]
fn lights_stand_where_the_stage_says_and_shine_there_in_every_scene_of_the_file() {
    let scene = applied(
        "[[lights]]\nkind = \"spot\"\nname = \"key\"\nposition = [1, 2, 3]\ntarget = [1, 0, 3]\ncolor = \"#ff8000\"\n\
         intensity = 500\nrange_m = 20\ninner_cone_deg = 20\nouter_cone_deg = 30.5\nradius_m = 0.1\ncast = false\n\
         [[lights]]\nkind = \"directional\"\ndirection = [0, 0, 1e-30]\nangle_deg = 0.53\ncolor = [1, 0.5, 0]\n\
         [[lights]]\nkind = \"point\"\nposition = [-1, 0.5, 0]\n",
    )
    .unwrap();
    let [_, _, spot, sun, point] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    let LightKind::Spot { inner_cone_rad, outer_cone_rad } = spot.kind else { panic!("{spot:?}") };
    assert!((inner_cone_rad.to_degrees() - 20.0).abs() < 1e-4 && (outer_cone_rad.to_degrees() - 30.5).abs() < 1e-4);
    // 128 / 255 in sRGB is 0.2158605 in linear light.
    assert!(spot.color_linear.abs_diff_eq(Vec3::new(1.0, 0.215_860_5, 0.0), 1e-6), "{spot:?}");
    assert_eq!((spot.intensity, spot.range_m, spot.radius_m, spot.casts_shadows), (500.0, Some(20.0), 0.1, false));
    assert_eq!((sun.kind, sun.color_linear), (LightKind::Directional, Vec3::new(1.0, 0.5, 0.0)));
    // The sun's radius over its distance: 695,700 km over 149.6 million km is 0.00465.
    assert!((sun.radius_m - 0.004_65).abs() < 5e-5, "{sun:?}");
    assert_eq!((point.intensity, point.range_m, point.casts_shadows), (1.0, None, true));
    for (node, place, shines) in [(3, [1.0, 2.0, 3.0], Vec3::NEG_Y), (4, [0.0; 3], Vec3::Z)] {
        let world = scene.nodes[node].world_from_object;
        assert!(world.w_axis.truncate().abs_diff_eq(Vec3::from(place), 1e-6), "{world}");
        assert!((-world.z_axis.truncate()).abs_diff_eq(shines, 1e-6), "{world}");
    }
    for roots in scene.scenes.iter().map(|roots| &roots.roots).chain([&scene.roots]) {
        assert_eq!(roots.iter().map(|id| id.0).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    }
}

#[test]
fn what_the_model_has_is_changed_by_name() {
    let scene = applied(
        "[[lights]]\nname = \"Post\"\nintensity = 0\nradius_m = 0.2\n[[lights]]\nname = \"*\"\ncast = false\n\
         [[lights]]\nname = \"S*n\"\nangle_deg = 90\ncast = true\n\
         [[nodes]]\nname = \"Floor\"\ncast_shadow = false\n[[materials]]\nname = \"g*\"\ncast_shadow = false\n",
    )
    .unwrap();
    let [lamp, sun] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!((lamp.intensity, lamp.radius_m, lamp.casts_shadows), (0.0, 0.2, false));
    assert!((sun.radius_m - 1.0).abs() < 1e-6 && sun.intensity == 1.0 && sun.casts_shadows, "{sun:?}");
    let casts: Vec<bool> = scene.nodes.iter().map(|node| node.casts_shadow).collect();
    assert_eq!((casts, scene.materials[0].casts_shadow), (vec![true, true, false], false));
}

/// One white texel.
const TEXEL: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 1, 0, 0, 0, 1, 8, 0, 0, 0, 0, 58, 126, 155,
    85, 0, 0, 0, 10, 73, 68, 65, 84, 120, 156, 99, 248, 15, 0, 1, 1, 1, 0, 27, 182, 238, 86, 0, 0, 0, 0, 73, 69, 78,
    68, 174, 66, 96, 130,
];

#[test]
fn materials_get_maps_that_the_model_has_not() {
    let text = "model = \"m.glb\"\n[[materials]]\nname = \"glass\"\nnormal_convention = \"directx\"\n\
                light_map = \"a.png\"\nlight_map_intensity = 2\nlight_map_encoding = \"srgb\"\nlight_map_direction = \"d.png\"\n\
                occlusion_map = \"b.png\"\nocclusion_texcoord = 0\nemissive_map = \"a.png\"\n\
                height_map = \"c.png\"\nheight_depth_m = 0.25\nheight_method = \"steep\"\n\
                detail_normal_map = \"d.png\"\ndetail_color_map = \"a.png\"\ndetail_scale = 4\n";
    let stage = Stage::parse("a.stage.toml", text).unwrap();
    assert_eq!(stage.images(), ["a.png", "b.png", "c.png", "d.png"]);
    let (mut scene, mut asked) = (model(), Vec::new());
    let mut resolve = |name: &str| {
        asked.push(name.to_owned());
        Ok(TEXEL.to_vec())
    };
    stage.apply_with(&mut scene, &mut resolve).unwrap();
    // Each is read once, whatever it is for.
    asked.sort();
    assert_eq!(asked, stage.images());
    let material = &scene.materials[0];
    let image = |texture: Option<crate::TextureRef>| {
        let texture = texture.unwrap();
        (scene.images[scene.textures[texture.texture].image].name.as_str(), texture.uv_set)
    };
    let baked = material.light_map.unwrap();
    assert_eq!(
        (image(baked.light.texture), baked.light.factor, baked.encoding),
        (("a.png", 1), 2.0, LightEncoding::Srgb)
    );
    assert_eq!(image(baked.direction), ("d.png", 1));
    assert_eq!((image(material.occlusion_texture), image(material.emissive_texture)), (("b.png", 0), ("a.png", 1)));
    assert_eq!((material.emissive_factor, material.has_normals_down), (Vec3::ONE, true));
    let height = material.height.unwrap();
    assert_eq!((image(Some(height.texture)), height.depth_m, height.self_shadow), (("c.png", 0), 0.25, false));
    assert_eq!(height.method, crate::material::HeightMethod::Steep);
    let detail = material.detail.unwrap();
    assert_eq!((image(detail.normal_texture), image(detail.base_color_texture)), (("d.png", 0), ("a.png", 0)));
    assert_eq!(detail.normal_texture.unwrap().transform.scale.x, 4.0);
    let error = stage.apply_with(&mut model(), &mut |_| Ok(b"no image".to_vec())).unwrap_err().to_string();
    assert!(error.starts_with("a.stage.toml:5:13: error: image \"a.png\"") || error.contains("b.png"), "{error}");
}

/// A pixel of light.
const LIGHT: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x83";

#[test]
fn files_of_light_are_for_light_maps_alone() {
    let apply = |keys: &str| {
        let text = format!("model = \"m.glb\"\n[[materials]]\nname = \"glass\"\n{keys}");
        let mut scene = model();
        let files = |name: &str| Ok(if name.ends_with(".hdr") { LIGHT.to_vec() } else { TEXEL.to_vec() });
        let applied = Stage::parse("a.stage.toml", &text).unwrap().apply_with(&mut scene, &mut { files });
        applied.map(|_| scene).map_err(|error| error.to_string())
    };
    let scene = apply("light_map = \"a.hdr\"\nocclusion_map = \"b.png\"").unwrap();
    let light = scene.images.iter().find(|image| image.holds_light()).unwrap();
    assert_eq!(light.decode_light().unwrap().texels[0].map(f32::from), [4.0, 4.0, 4.0, 1.0]);
    for (keys, expected) in [
        ("emissive_map = \"a.hdr\"", "4:16: error: `a.hdr` holds light, which `light_map` alone takes"),
        ("light_map = \"a.hdr\"\ndetail_color_map = \"a.hdr\"\ndetail_scale = 2", "5:20: error: `a.hdr` holds light"),
        ("light_map = \"a.hdr\"\nlight_map_direction = \"b.hdr\"", "5:23: error: `b.hdr` holds light"),
        ("light_map = \"a.hdr\"\nlight_map_encoding = \"srgb\"", "4:13: error: `a.hdr` holds linear light"),
    ] {
        let error = apply(keys).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn surfaces_that_lack_a_uv_set_are_told_whichever_way_they_show_the_material() {
    let text = "model = \"m.glb\"\n[[materials]]\nname = \"glass\"\nlight_map = \"a.png\"\n";
    let stage = Stage::parse("a.stage.toml", text).unwrap();
    let warnings = |primitive: Primitive, levels: Option<Levels<usize>>| {
        let mut scene = model();
        scene.materials.push(Material { name: "other".into(), levels, ..Material::default() });
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        stage.apply_with(&mut scene, &mut |_| Ok(TEXEL.to_vec())).unwrap()
    };
    let other = || Primitive { material: Some(1), ..Primitive::default() };
    let in_a_variant = || Primitive { variant_materials: vec![(0, 0)], ..other() };
    let coarser = || Some(Levels { coarser: vec![0], screen_coverage: Vec::new() });
    assert!(warnings(other(), None).is_empty());
    for (name, found) in [
        ("own", warnings(Primitive { material: Some(0), ..Primitive::default() }, None)),
        ("variant", warnings(in_a_variant(), None)),
        ("level", warnings(other(), coarser())),
    ] {
        assert!(
            matches!(&found[..], [line] if line.starts_with("`a.png` lies on UV set 1 of `glass`")),
            "{name}: {found:?}"
        );
    }
    for (primitive, levels) in [(in_a_variant(), None), (other(), coarser())] {
        assert!(warnings(Primitive { uv1: vec![[0.0; 2]], ..primitive }, levels).is_empty());
    }
}

#[test]
fn heights_and_details_without_uvs_are_told() {
    let keys =
        "height_map = \"a.png\"\nheight_depth_m = 0.1\ndetail_normal_map = \"b.png\"\ndetail_color_map = \"c.png\"\n";
    let text = format!("model = \"m.glb\"\n[[materials]]\nname = \"glass\"\n{keys}");
    let stage = Stage::parse("a.stage.toml", &text).unwrap();
    let warnings = |uv0: Vec<[f32; 2]>| {
        let mut scene = model();
        let primitive = Primitive { uv0, material: Some(0), ..Primitive::default() };
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        stage.apply_with(&mut scene, &mut |_| Ok(TEXEL.to_vec())).unwrap()
    };
    let found = warnings(Vec::new());
    for image in ["a", "b", "c"] {
        let told = |line: &String| line.starts_with(&format!("`{image}.png` lies on UV set 0 of `glass`"));
        assert!(found.iter().any(told), "{image}: {found:?}");
    }
    assert_eq!((found.len(), warnings(vec![[0.0; 2]])), (3, Vec::new()));
}

#[test]
fn an_overlay_reads_its_files_once() {
    use crate::overlay::{OverlayShape, PlaceOf};
    let text = "model = \"m.glb\"\n[[overlay]]\ntext = \"a\\r\\nb\"\nfont = \"f.ttf\"\nanchor = \"bottom-right\"\n\
                [[overlay]]\nsprite = \"a.png\"\nnode = \"Floor\"\ndepth_test = true\n\
                [[overlay]]\nsprite = \"a.png\"\nwidth_px = 7\n[[overlay]]\npoints = [[0, 0], [1, 2]]\n";
    let stage = Stage::parse("a.stage.toml", text).unwrap();
    assert_eq!(stage.images(), ["a.png", "f.ttf"]);
    let mut png = Vec::new();
    let texel = ::image::RgbaImage::from_pixel(1, 1, ::image::Rgba([255; 4]));
    texel.write_to(&mut std::io::Cursor::new(&mut png), ::image::ImageFormat::Png).unwrap();
    let (mut scene, mut asked) = (model(), Vec::new());
    let mut resolve = |name: &str| {
        asked.push(name.to_owned());
        let font = include_bytes!("../overlay/manypass_sans.ttf");
        Ok(if name == "f.ttf" { font.to_vec() } else { png.clone() })
    };
    stage.apply_with(&mut scene, &mut resolve).unwrap();
    assert_eq!(asked, ["f.ttf", "a.png"]);
    let [text, at_node, sized, _] = &scene.overlay.items[..] else { panic!("{:?}", scene.overlay) };
    let OverlayShape::Text(shown) = &text.shape else { panic!("{text:?}") };
    assert_eq!((shown.text.as_str(), shown.font.as_ref().map(|font| font.name())), ("a\nb", Some("f.ttf")));
    assert_eq!((&at_node.place.of, at_node.depth_test), (&PlaceOf::Node("Floor".into()), true));
    let OverlayShape::Sprite(drawn) = &sized.shape else { panic!("{sized:?}") };
    assert_eq!(drawn.drawn_size_px(), glam::Vec2::new(7.0, 7.0));
    for (name, expected) in
        [("f.ttf", "4:8: error: `f.ttf` is not a readable font"), ("a.png", "7:10: error: image \"a.png\"")]
    {
        let font = include_bytes!("../overlay/manypass_sans.ttf");
        let mut broken = |asked: &str| {
            let whole = if asked == "f.ttf" { font.to_vec() } else { png.clone() };
            Ok(if asked == name { b"broken".to_vec() } else { whole })
        };
        let error = stage.apply_with(&mut model(), &mut broken).unwrap_err().to_string();
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{error}");
    }
}

#[test]
fn a_hundred_thousand_items_are_refused() {
    let item = "[[overlay]]\ntext=\"a\"\nposition=[0,0]\n";
    let error = applied(&item.repeat(100_000)).unwrap_err();
    assert!(error.contains("there are 100000 [[overlay]], and 65535 are possible"), "{}", &error[..200]);
}

/// Texts below `model`, and what the error begins with and contains.
const WRONG: &[(&str, &str, &str)] = &[
    ("[[light]]", "2:3: error: no key of a stage is called `light`; did you mean `lights`?", ""),
    ("colour = 1", "2:1: error: no key of a stage is called `colour`", ""),
    ("chain = [\"bloom\"]", "2:1: error: no key of a stage is called `chain`", "the chain of effects in [effects]"),
    ("[bloom]\nstrength = 2", "2:2: error: no key of a stage is called `bloom`", "stand in [settings.NAME]"),
    ("[lights]\nkind = \"point\"", "2:", "write [[lights]] above each"),
    ("lights = [1]", "2:11: error:", "write [[lights]] above each"),
    ("[[fog]]", "2:", "write [fog] above them"),
    ("environment = \"ff8800\"", "2:15: error:", "write [environment] above them"),
    ("[[lights]]\nkind = \"sun\"", "3:8: error: `\"sun\"` is not a value of `kind`", "\"spot\" or \"directional\""),
    ("[[lights]]\nkind = \"point\"", "3:8: error: a point light needs `position`", ""),
    ("[[lights]]\nkind = \"spot\"\nposition = [0, 1, 0]", "3:8: error: a spot light needs `direction` or `target`", ""),
    ("[[lights]]\nkind = \"directional\"\ntarget = [0, 0, 0]", "4:10: error: `target` needs `position`", ""),
    ("[[lights]]\nkind = \"directional\"\ndirection = [0, 0, 0]", "4:13: error: a direction of no length", ""),
    ("[[lights]]\nkind = \"point\"\nposition = [0, 0, 0]\ntarget = [0, 1, 0]", "5:10: error: a point light has no", ""),
    ("[[lights]]\nkind = \"point\"\nposition = [0, nan, 0]", "4:12: error:", "three finite numbers"),
    ("[[lights]]\nkind = \"point\"\nposition = [0, 0]", "4:12: error:", "[x, y, z]"),
    ("[[lights]]\nintensity = 3", "2:1: error: a light needs `kind` if it is new", ""),
    ("[[lights]]\nname = \"Lamp\"\nposition = [0, 0, 0]", "4:12: error: `position` is only for new lights", ""),
    ("[[lights]]\nname = \"Lampe\"", "3:8: error: the model has no light called `Lampe`; did you mean `Lamp`?", ""),
    (
        "[[lights]]\nname = \"Sun\"\nradius_m = 1",
        "3:8: error: `Sun` is a directional light, which has no `radius_m`: give it `angle_deg`",
        "",
    ),
    ("[[lights]]\nname = \"Lamp\"\nangle_deg = 1", "3:8: error: `Lamp` is not a directional light", ""),
    ("[[nodes]]\ncast_shadow = true", "2:1: error: `name` is missing", ""),
    ("[[nodes]]\nname = \"floor\"\ncast_shadow = true", "3:8: error: the model has no node called `floor`", "`Floor`"),
    (
        "[[materials]]\nname = \"x\"\ncast_shadow = 1",
        "4:15: error: `1` is not a value of `cast_shadow`",
        "true or false",
    ),
    (
        "[[materials]]\nname = \"glas\"",
        "3:8: error: the model has no material called `glas`; did you mean `glass`?",
        "",
    ),
    ("[[materials]]\nname = \"glass\"\nlight_map = \"a.png\"", "4:13: error:", "`a.png` was not given"),
    ("[[materials]]\nname = \"glass\"\nlight_map = \"\"", "4:13: error: the name of `light_map` is empty", ""),
    (
        "[[materials]]\nname = \"glass\"\nlight_map_direction = \"a.png\"",
        "4:23: error: `light_map_direction` needs",
        "",
    ),
    ("[[materials]]\nname = \"glass\"\nlight_map_intensity = 2", "4:23: error: `light_map_intensity` needs", ""),
    (
        "[[materials]]\nname = \"glass\"\nlight_map = \"a.png\"\nlight_map_texcoord = 0.5",
        "5:22: error: there are the UV sets 0 and 1, and not 0.5",
        "",
    ),
    ("[[materials]]\nname = \"glass\"\nheight_map = \"a.png\"", "4:14: error:", "needs `height_depth_m`"),
    (
        "[[materials]]\nname = \"glass\"\nheight_map = \"a.png\"\nheight_depth_m = 0",
        "5:18: error: `0` is not a value of `height_depth_m`",
        "above 0",
    ),
    (
        "[[materials]]\nname = \"glass\"\nheight_map = \"a.png\"\nheight_depth_m = 1\nheight_method = \"relief\"",
        "6:17: error: `\"relief\"` is not a value of `height_method`",
        "\"steep\" or \"occlusion\"",
    ),
    (
        "[[materials]]\nname = \"glass\"\nheight_map = \"a.png\"\nheight_depth_m = 1\nheight_method = \"bump\"\nself_shadow = true",
        "7:15: error: `self_shadow` needs the method",
        "",
    ),
    ("[[lights]]\nname = \"Lamp\"\ncolor = \"red\"", "4:9: error:", "a colour such as"),
    ("[[lights]]\nname = \"Lamp\"\ncolor = [1, -1, 0]", "4:9: error:", "a colour such as"),
    (
        "[[lights]]\nname = \"Lamp\"\nrange_ = 2",
        "4:1: error: no key of lights is called `range_`; did you mean `range_m`?",
        "",
    ),
    ("[[overlay]]\nposition = [0, 0]", "2:1: error: an item needs one of `text`", ""),
    ("[[overlay]]\ntext = \"\"", "3:8: error: the text is empty", ""),
    ("[[overlay]]\ntext = \"a\\u0007b\"", "3:8: error: the text holds the control character U+0007", ""),
    (
        "[[overlay]]\ntext = \"a\"\nsize_px = nan",
        "4:11: error: `nan` is not a value of `size_px`",
        "above 0 and at most 1000",
    ),
    ("[[overlay]]\ntext = \"a\"\nsize_px = 0", "4:11: error:", "above 0"),
    ("[[overlay]]\ntext = \"a\"\nsize_px = 1e9", "4:11: error:", "at most 1000"),
    ("[[overlay]]\ntext = \"a\"\nposition = [1e9, 0]", "4:12: error:", "farther than 1000000 pixels"),
    ("[[overlay]]\ntext = \"a\"\nposition = [1]", "4:12: error:", "[x, y]"),
    (
        "[[overlay]]\ntext = \"a\"\nanchor = \"middle\"",
        "4:10: error: `\"middle\"` is not a value of `anchor`",
        "\"center\"",
    ),
    ("[[overlay]]\ntext = \"a\"\ndepth_test = true", "4:14: error: an item placed in pixels", "`at_world`"),
    ("[[overlay]]\ntext = \"a\"\nwidth_px = 2", "4:12: error: `width_px` is only for items with `points`", "`sprite`"),
    ("[[overlay]]\ntext = \"a\"\nfont = \"\"", "4:8: error: the name of `font` is empty", ".ttf"),
    ("[[overlay]]\ntext = \"a\"\nfont = \"a.ttf\"", "4:8: error:", "`a.ttf` was not given"),
    ("[[overlay]]\ntext = \"a\"\nsprite = \"a.png\"", "4:10: error: an item is one thing: `text` or `sprite`", ""),
    ("[[overlay]]\ntext = \"a\"\nnode = \"Flor\"", "4:8: error: the model has no node called `Flor`", "`Floor`"),
    ("[[overlay]]\ntext = \"a\"\nnode = \"Floor\"\nat_world = [0, 0, 0]", "5:12: error: an item is in one place", ""),
    ("[[overlay]]\nsprite = \"a.png\"", "3:10: error:", "`a.png` was not given"),
    ("[[overlay]]\npoints = [[0, 0]]", "3:10: error:", "[[x, y], [x, y]]"),
    ("[[overlay]]\npoints = [[0, 0], [1, nan]]", "3:10: error:", "two finite numbers"),
    ("[[overlay]]\npoints_world = [[0, 0], [1, 2]]", "3:16: error:", "[[x, y, z], [x, y, z]]"),
    ("[[overlay]]\npoints = [[0, 0], [1, 2]]\nwidth_px = -1", "4:12: error:", "above 0"),
    ("[[overlay]]\ntext = \"a\"\nopacity = 2", "4:11: error:", "at most 1"),
    ("[[overlay]]\ntext = \"a\"\ncolour = \"ff0000\"", "4:1: error: no key of overlay is called `colour`", ""),
    ("[[overlays]]", "2:3: error: no key of a stage is called `overlays`; did you mean `overlay`?", ""),
    ("x = = 1", "2:5: error:", ""),
    ("model = \"n.glb\"", "2:1: error:", ""),
];

#[test]
fn what_is_wrong_is_told_with_line_and_column() {
    for (text, start, part) in WRONG {
        let error = applied(text).expect_err(text);
        assert!(error.starts_with(&format!("a.stage.toml:{start}")) && error.contains(part), "{text}\n{error}");
    }
    for (text, start) in [
        ("", "1:1: error: `model` is missing"),
        ("model = \"\"", "1:9: error: the name of the model is empty"),
        ("model = \"a.stage.toml\"", "1:9: error: the model `a.stage.toml` is a stage, too"),
        ("model = \"../B.Stage.TOML\"", "1:9: error: the model `../B.Stage.TOML` is a stage, too"),
    ] {
        let error = Stage::parse("a.stage.toml", text).expect_err(text).to_string();
        assert!(error.starts_with(&format!("a.stage.toml:{start}")), "{text}\n{error}");
    }
}

#[test]
fn numbers_that_no_light_has_are_refused() {
    for (key, values) in [
        ("intensity", &["-1", "nan", "inf", "-inf", "1e39", "\"5\"", "true"][..]),
        ("range_m", &["0", "-1", "nan", "inf", "1e-9", "[1]"]),
        ("radius_m", &["-0.1", "nan", "inf"]),
        ("inner_cone_deg", &["-1", "91", "nan", "45", "60"]),
        ("outer_cone_deg", &["0", "-0.0", "90.5", "nan", "inf"]),
    ] {
        for value in values {
            let light = "[[lights]]\nkind = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, -1, 0]";
            let error = applied(&format!("{light}\n{key} = {value}")).expect_err(value);
            assert!(error.starts_with("a.stage.toml:6:"), "{key} = {value}: {error}");
        }
    }
    let narrow = "[[lights]]\nkind = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 1, 0]\ninner_cone_deg = 30\nouter_cone_deg = 30";
    let error = applied(narrow).unwrap_err();
    assert!(error.starts_with("a.stage.toml:6:18: error: the inner cone of 30 degrees is not narrower"), "{error}");
}

#[test]
fn a_million_lights_are_refused() {
    let light = "[[lights]]\nkind=\"point\"\nposition=[0,0,0]\n";
    assert_eq!(applied(&light.repeat(3)).unwrap().lights.len(), 5);
    let error = applied(&light.repeat(LIGHTS_MAX as usize + 5)).unwrap_err();
    let start =
        format!("a.stage.toml:{}:1: error: there are 65540 [[lights]], and 65535 are possible", 2 + 3 * LIGHTS_MAX);
    assert!(error.starts_with(&start), "{}", error.lines().next().unwrap());
    let million = light.repeat(1_000_000);
    let error = load_bytes(million.as_bytes(), &mut |_| Err(String::new()), "m").map(drop).unwrap_err().to_string();
    assert_eq!(error, "m: it is larger than 16 MiB");
    let error = applied(&"[[lights]]\n".repeat(1_000_000)).unwrap_err();
    assert!(error.starts_with("a.stage.toml:262142:1: error: more than 262140 tables"), "{}", &error[..200]);
}

#[test]
fn older_names_are_read_and_told_of_but_not_beside_those_of_today() {
    let box_of_probe = "center = [0, 1, 0]\nsize_m = [4, 2, 6]\n";
    let parsed = |text: &str| Stage::parse("a.stage.toml", &format!("model = \"demo:gallery\"\n{text}"));
    let used = |stage: &Stage| stage.older_names().iter().map(|renamed| renamed.older).collect::<Vec<_>>();
    let stage = parsed(&format!("[[surroundings]]\n{box_of_probe}walls = false\n")).unwrap();
    assert_eq!(used(&stage), ["surroundings", "walls"]);
    let mut scene = Scene::default();
    stage.apply(&mut scene).unwrap();
    assert!(scene.surroundings[0].walls.is_none(), "the keys of both names are read");
    // Of another table that is the name of today.
    let simulation = "[[simulations]]\nname = \"a\"\nprogram = \"ripples\"\nwalls = [\"a\"]\n";
    assert!(used(&parsed(simulation).unwrap()).is_empty());
    for (text, expected) in [
        (
            format!("[[surroundings]]\n{box_of_probe}[[reflection_probes]]\n{box_of_probe}"),
            "2:3: error: `surroundings` is an older name of `reflection_probes`, which is here, too",
        ),
        (
            format!("[[reflection_probes]]\n{box_of_probe}walls = true\nparallax_correction = true\n"),
            "5:1: error: `walls` is an older name of `parallax_correction`, which is here, too",
        ),
        ("[[surroundings]]\ncentre = 1\n".into(), "3:1: error: no key of reflection_probes is called `centre`"),
    ] {
        let error = parsed(&text).unwrap_err().to_string();
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
}

#[test]
fn stages_are_known_by_their_names() {
    for (name, expected) in
        [("a.stage.toml", true), ("in/A b.Stage.TOML", true), ("a.toml", false), ("stage.toml", false)]
    {
        assert_eq!(is_stage(Path::new(name)), expected, "{name}");
    }
}

#[test]
fn keys_are_declared_with_sentences_and_read_by_their_names() {
    for table in TABLES {
        assert!(table.doc.ends_with('.'));
        for key in table.keys {
            assert!(key.doc.ends_with('.') && !key.kind.expected().is_empty(), "{}", key.name);
        }
    }
}
