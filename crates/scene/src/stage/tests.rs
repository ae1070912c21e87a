#![allow(clippy::unwrap_used, reason = "a test may panic")]

use super::*;
use crate::material::LightEncoding;
use crate::{
    Image, ImageSource, Levels, Light, LightKind, Material, Mesh, Node, NodeId, PixelFormat, Pixels, Primitive,
    SceneRoots,
};
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
    for (name, expected) in [("f.ttf", "4:8: error: `f.ttf` is no font"), ("a.png", "7:10: error: image \"a.png\"")] {
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
    ("[[lights]]\nkind = \"sun\"", "3:8: error: `\"sun\"` is no value of `kind`", "\"spot\" or \"directional\""),
    ("[[lights]]\nkind = \"point\"", "3:8: error: a point light needs `position`", ""),
    ("[[lights]]\nkind = \"spot\"\nposition = [0, 1, 0]", "3:8: error: a spot light needs `direction` or `target`", ""),
    ("[[lights]]\nkind = \"directional\"\ntarget = [0, 0, 0]", "4:10: error: `target` needs `position`", ""),
    ("[[lights]]\nkind = \"directional\"\ndirection = [0, 0, 0]", "4:13: error: a direction of no length", ""),
    ("[[lights]]\nkind = \"point\"\nposition = [0, 0, 0]\ntarget = [0, 1, 0]", "5:10: error: a point light has no", ""),
    ("[[lights]]\nkind = \"point\"\nposition = [0, nan, 0]", "4:12: error:", "three finite numbers"),
    ("[[lights]]\nkind = \"point\"\nposition = [0, 0]", "4:12: error:", "[x, y, z]"),
    ("[[lights]]\nintensity = 3", "2:1: error: a light needs `kind` if it is new", ""),
    ("[[lights]]\nname = \"Lamp\"\nposition = [0, 0, 0]", "4:12: error: `position` is of new lights", ""),
    ("[[lights]]\nname = \"Lampe\"", "3:8: error: the model has no light called `Lampe`; did you mean `Lamp`?", ""),
    (
        "[[lights]]\nname = \"Sun\"\nradius_m = 1",
        "3:8: error: `Sun` is directional light, which has no `radius_m`: give it `angle_deg`",
        "",
    ),
    ("[[lights]]\nname = \"Lamp\"\nangle_deg = 1", "3:8: error: `Lamp` is no directional light", ""),
    ("[[nodes]]\ncast_shadow = true", "2:1: error: `name` is missing", ""),
    ("[[nodes]]\nname = \"floor\"\ncast_shadow = true", "3:8: error: the model has no node called `floor`", "`Floor`"),
    ("[[materials]]\nname = \"x\"\ncast_shadow = 1", "4:15: error: `1` is no value of `cast_shadow`", "true or false"),
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
        "5:18: error: `0` is no value of `height_depth_m`",
        "above 0",
    ),
    (
        "[[materials]]\nname = \"glass\"\nheight_map = \"a.png\"\nheight_depth_m = 1\nheight_method = \"relief\"",
        "6:17: error: `\"relief\"` is no value of `height_method`",
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
        "4:11: error: `nan` is no value of `size_px`",
        "above 0 and at most 1000",
    ),
    ("[[overlay]]\ntext = \"a\"\nsize_px = 0", "4:11: error:", "above 0"),
    ("[[overlay]]\ntext = \"a\"\nsize_px = 1e9", "4:11: error:", "at most 1000"),
    ("[[overlay]]\ntext = \"a\"\nposition = [1e9, 0]", "4:12: error:", "farther than 1000000 pixels"),
    ("[[overlay]]\ntext = \"a\"\nposition = [1]", "4:12: error:", "[x, y]"),
    (
        "[[overlay]]\ntext = \"a\"\nanchor = \"middle\"",
        "4:10: error: `\"middle\"` is no value of `anchor`",
        "\"center\"",
    ),
    ("[[overlay]]\ntext = \"a\"\ndepth_test = true", "4:14: error: what is told in pixels", "`at_world`"),
    ("[[overlay]]\ntext = \"a\"\nwidth_px = 2", "4:12: error: `width_px` is of what has `points`", "`sprite`"),
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

#[test]
fn monitors_are_images_that_materials_and_overlays_show() {
    use crate::capture::{MonitorCamera, Update};
    let text = "[[monitors]]\nname = \"door\"\nposition = [0, 2, 0]\ntarget = [0, 0, 0]\nfov_deg = 60\nmaterial = \"gl*\"\n\
                luminance_cd_m2 = 250\nsize_px = [320, 200]\nexposure_stops = -1\nevery = 4\nlayers = [0, 5]\nquality = \"low\"\n\
                [[monitors]]\nname = \"inset\"\nposition = [1, 0, 0]\ntarget = [0, 0, 0]\n\
                [[nodes]]\nname = \"Floor\"\nlayers = [5, 31]\n\
                [[overlay]]\nmonitor = \"inset\"\nwidth_px = 200\nanchor = \"top-right\"\n";
    let scene = applied(text).unwrap();
    let monitors: Vec<_> = scene.monitors().collect();
    let [(_, door, monitor), (_, inset, of_defaults)] = monitors[..] else { panic!("{monitors:?}") };
    assert_eq!((door.name.as_str(), inset.name.as_str()), ("door", "inset"));
    assert_eq!((monitor.width, monitor.height, monitor.exposure_stops), (320, 200, -1.0));
    assert_eq!((monitor.options.update, monitor.options.layers), (Update::Every(4), 1 << 5 | 1));
    assert_eq!(monitor.options.quality.as_deref(), Some("low"));
    assert_eq!((of_defaults.width, of_defaults.height, of_defaults.options.layers), (512, 288, u32::MAX));
    let MonitorCamera::Fixed { world_from_view, .. } = monitor.camera else { panic!("{monitor:?}") };
    assert!((-world_from_view.z_axis.truncate()).abs_diff_eq(Vec3::NEG_Y, 1e-6), "{world_from_view}");
    let glass = &scene.materials[0];
    let texture = scene.textures[glass.emissive_texture.unwrap().texture];
    assert_eq!((texture.image, glass.emissive_factor), (0, Vec3::splat(250.0)));
    assert_eq!(scene.nodes[2].layers, 1 << 5 | 1 << 31);
    let warnings = {
        let stage = Stage::parse(
            "a.stage.toml",
            "model = \"m.glb\"\n[[monitors]]\nname = \"a\"\nposition = [0, 2, 0]\ntarget = [0, 0, 0]\n",
        );
        stage.unwrap().apply_with(&mut model(), &mut |name| Err(format!("no {name}"))).unwrap()
    };
    assert!(warnings[0].contains("nothing shows the monitor `a`"), "{warnings:?}");
}

#[test]
fn wrong_monitors_are_told_with_their_place() {
    let monitor = |rest: &str| format!("[[monitors]]\nname = \"m\"\nposition = [0, 2, 0]\n{rest}");
    let two = |first: &str, second: &str| {
        let of = |name: &str| format!("[[monitors]]\nname = \"{name}\"\nposition = [0, 1, 0]\ntarget = [0, 0, 0]\n");
        of(first) + &of(second)
    };
    for (text, expected) in [
        (monitor(""), "2:1: error: a monitor needs `camera`, a camera of the model, or `position` and `target`"),
        (monitor("target = [0, 2, 0]\n"), "5:10: error: `position` and `target` are one place"),
        (monitor("camera = \"Top\"\n"), "4:12: error: `camera` says from where already; leave out `position`"),
        (monitor("target = [0, 0, 0]\nsize_px = [0, 10]\n"), "6:11: error: `size_px` is a width and a height"),
        (monitor("target = [0, 0, 0]\nsize_px = [-3, 10]\n"), "6:11: error: `size_px` is a width and a height"),
        (monitor("target = [0, 0, 0]\nsize_px = [1e9, 10]\n"), "6:11: error: `size_px` is a width and a height"),
        (monitor("target = [0, 0, nan]\n"), "5:10: error:"),
        (monitor("target = [0, 0, 0]\nfov_deg = 0\n"), "6:11: error: `0` is no value of `fov_deg`"),
        (monitor("target = [0, 0, 0]\nlayers = [32]\n"), "6:10: error: `[32]` is no value of `layers`"),
        (monitor("target = [0, 0, 0]\nlayers = [0.5]\n"), "6:10: error: `[0.5]` is no value of `layers`"),
        (monitor("target = [0, 0, 0]\nslot = \"base_color\"\n"), "6:8: error: `slot` says how materials show it"),
        (
            monitor("target = [0, 0, 0]\nmaterial = \"glas\"\n"),
            "6:12: error: the model has no material called `glas`; did you mean `glass`?",
        ),
        (monitor("target = [0, 0, 0]\nupdate = \"once\"\nevery = 2\n"), "7:9: error: what is drawn once"),
        (monitor("target = [0, 0, 0]\nevery = 1.5\n"), "6:9: error: `every` is a whole number"),
        ("[[monitors]]\nname = \"m\"\ncamera = \"Top\"\n".into(), "4:10: error: the model has no camera called `Top`"),
        ("[[monitors]]\nname = \" \"\n".into(), "3:8: error: a monitor needs a name"),
        (two("a", "a"), "7:8: error: two monitors are called `a`"),
        ("[[overlay]]\nmonitor = \"door\"\n".into(), "3:11: error: the stage has no monitor called `door`"),
    ] {
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many: String = (0..10_000)
        .map(|at| format!("[[monitors]]\nname = \"{at}\"\nposition = [0, 1, 0]\ntarget = [0, 0, 0]\n"))
        .collect();
    let error = applied(&many).expect_err("ten thousand");
    assert!(error.contains("there are 10000 [[monitors]], and 64 are possible"), "{error}");
}

#[test]
fn water_lies_in_flat_nodes_or_rectangles() {
    let applied = |text: &str| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = model();
        let square = Primitive { material: Some(0), ..crate::primitives::plane(2.0) };
        scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
        let mesh = Some(scene.meshes.len() - 1);
        scene.add_node(None, Node { name: "Pond".into(), mesh, ..Node::default() });
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok::<Scene, String>(scene)
    };
    let scene = applied(
        "[[water]]\nnode = \"Pond\"\nclarity = \"murky\"\nwind_m_s = 0\nfoam_depth_m = 0.1\nlayers = [1]\n\
         [[water]]\nname = \"sea\"\nposition = [0, -1, 3]\nsize_m = [40, 20]\nturn_deg = 90\nabsorption_per_m = [1, 2, 3]\nwind_deg = 180\n",
    )
    .unwrap();
    let [pond, sea] = &scene.water[..] else { panic!("{:?}", scene.water) };
    assert_eq!((pond.name.as_str(), pond.wind_m_s, pond.scale, pond.layers), ("Pond", 0.0, 1.0, 2));
    assert_eq!(pond.scattering_per_m, crate::water::Clarity::Murky.scattering_per_m());
    assert_eq!((sea.name.as_str(), sea.wind_m_s, sea.scale), ("sea", 2.0, 0.5));
    assert_eq!(sea.absorption_per_m, Vec3::new(1.0, 2.0, 3.0));
    let panel = scene.panel(sea.node).unwrap();
    assert!(
        panel.normal_world.abs_diff_eq(Vec3::Y, 1e-6)
            && panel.center_world.abs_diff_eq(Vec3::new(0.0, -1.0, 3.0), 1e-5)
    );
    let reach = panel.half_edges_world.iter().fold(Vec3::ZERO, |reach, edge| reach + edge.abs());
    assert!(reach.abs_diff_eq(Vec3::new(10.0, 0.0, 20.0), 1e-4), "{reach}");
    for (text, expected) in [
        ("", "2:1: error: water needs `node`, a flat surface of the model, or `position` and `size_m`"),
        ("node = \"Pont\"\n", "3:8: error: the model has no node called `Pont`"),
        ("node = \"Post\"\n", "3:8: error: a surface of water is flat, and the node `Post` has no mesh"),
        ("node = \"Pond\"\nturn_deg = 3\n", "4:12: error: `node` is a surface of the model; leave out `turn_deg`"),
        ("node = \"Pond\"\n[[water]]\nnode = \"Po*d\"\n", "5:8: error: the node `Pond` is water already"),
        ("node = \"Pond\"\n[[mirrors]]\nnode = \"Pond\"\n", "3:8: error: the node `Pond` is a mirror; it cannot be"),
        ("node = \"Pond\"\nabsorption_per_m = [1, -1, 0]\n", "4:20: error: `absorption_per_m` is a share of light"),
        ("node = \"Pond\"\nclarity = \"dirty\"\n", "4:11: error: `\"dirty\"` is no value of `clarity`"),
        ("node = \"Pond\"\nior = 1\n", "4:7: error: `1` is no value of `ior`"),
        ("node = \"Pond\"\nwind_m_s = -1\n", "4:12: error: `-1` is no value of `wind_m_s`"),
        ("node = \"Pond\"\nnormal_map = \"waves.png\"\n", "4:14: error: `waves.png` was not given"),
        ("position = [0, 0, 0]\nsize_m = [0, 1]\n", "4:10: error: `size_m` is a width and a height"),
    ] {
        let text = format!("[[water]]\n{text}");
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many = "[[water]]\nposition = [0, 0, 0]\nsize_m = [1, 1]\n".repeat(17);
    assert!(applied(&many).expect_err("17").contains("there are more surfaces of water than 16"));
}

#[test]
fn simulations_have_programs_places_and_those_who_show_them() {
    let applied = |text: &str| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = model();
        let square = Primitive { material: Some(0), ..crate::primitives::plane(2.0) };
        scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
        let mesh = Some(scene.meshes.len() - 1);
        for name in ["Pond", "Ball.1", "Ball.2"] {
            scene.add_node(None, Node { name: name.into(), mesh, ..Node::default() });
        }
        scene.update_transforms();
        let mut resolve = |name: &str| match name {
            "own.wgsl" => Ok(b"// own".to_vec()),
            "bytes.wgsl" => Ok(vec![255]),
            _ => Err(format!("`{name}` was not given")),
        };
        let warnings = stage.apply_with(&mut scene, &mut resolve).map_err(|error| error.to_string())?;
        Ok::<_, String>((stage, scene, warnings))
    };
    let (stage, scene, warnings) = applied(
        "[[simulations]]\nname = \"waves\"\nprogram = \"ripples\"\ncells = [64, 32]\nrate_hz = 120\nseed = 4\nbodies = [\"Ball.*\"]\n\
         walls = [\"Pond\"]\nparameters = { first_place = [0.25, 1], speed_m_s = 2 }\n\
         [[simulations]]\nname = \"own\"\nprogram = \"own.wgsl\"\nover = \"Pond\"\n\
         [[water]]\nnode = \"Pond\"\nsimulation = \"waves\"\n",
    )
    .unwrap();
    let [waves, own] = &scene.simulations[..] else { panic!("{:?}", scene.simulations) };
    assert_eq!((waves.cells, waves.rate_hz, waves.seed), (Some((64, 32)), Some(120.0), 4));
    assert_eq!((waves.bodies.len(), waves.walls.len()), (2, 1));
    let owned = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    assert_eq!(waves.parameters, [owned("first_place", "0.25,1"), owned("speed_m_s", "2")]);
    let crate::simulation::Program::Text { file, text } = &own.program else { panic!("{own:?}") };
    assert_eq!((file.as_str(), &**text, own.place), ("own.wgsl", "// own", Some(waves.walls[0])));
    assert_eq!((scene.water[0].simulation, stage.images()), (Some(0), vec!["own.wgsl"]));
    assert!(warnings.len() == 1 && warnings[0].starts_with("nothing shows the simulation `own`"), "{warnings:?}");
    assert!(scene.place_of_simulation(0).size_m.abs_diff_eq(glam::Vec2::splat(2.0), 1e-5));
    for (text, expected) in [
        ("name = \"a\"\n", "2:1: error: `program` is missing"),
        ("program = \"ripples\"\n", "2:1: error: `name` is missing"),
        ("name = \"\"\nprogram = \"ripples\"\n", "3:8: error: `name` is empty"),
        ("name = \"a\"\nprogram = \"no.wgsl\"\n", "4:11: error: `no.wgsl` was not given"),
        ("name = \"a\"\nprogram = \"bytes.wgsl\"\n", "4:11: error: `bytes.wgsl` is no text"),
        ("name = \"a\"\nprogram = \"fluid\"\ncells = [0, 4]\n", "5:9: error: `cells` is a width and a height"),
        ("name = \"a\"\nprogram = \"fluid\"\ncells = [4096, 4]\n", "5:9: error: `cells` is a width and a height"),
        ("name = \"a\"\nprogram = \"fluid\"\nrate_hz = 0\n", "5:11: error: `0` is no value of `rate_hz`"),
        ("name = \"a\"\nprogram = \"fluid\"\nseed = 1.5\n", "5:8: error: `seed` is a whole number"),
        ("name = \"a\"\nprogram = \"fluid\"\nbodies = [\"Bal\"]\n", "5:11: error: the model has no node called `Bal`"),
        (
            "name = \"a\"\nprogram = \"trails\"\nsees = \"Below\"\n",
            "5:8: error: the model has no camera called `Below`",
        ),
        (
            "name = \"a\"\nprogram = \"trails\"\nnormal_picture = \"normals\"\n",
            "5:18: error: `normal_picture` is what bends normals of materials, and needs `material`",
        ),
        (
            "name = \"a\"\nprogram = \"trails\"\nmaterial = \"San\"\nnormal_picture = \"normals\"\n",
            "5:12: error: the model has no material called `San`",
        ),
        ("name = \"a\"\nprogram = \"fluid\"\nbodies = \"Pond\"\n", "5:10: error: `\"Pond\"` is no value of `bodies`"),
        ("name = \"a\"\nprogram = \"fluid\"\nparameters = { a = \"b\" }\n", "5:14: error: `{ a = \"b\" }` is no value"),
        ("name = \"a\"\nprogram = \"fluid\"\nover = \"Post\"\n", "5:8: error: a simulation lies over a flat surface"),
        (
            "name = \"a\"\nprogram = \"fluid\"\nmaterial = \"No\"\n",
            "5:12: error: the model has no material called `No`",
        ),
        ("name = \"a\"\nprogram = \"fluid\"\npicture = \"x\"\n", "5:11: error: `picture` is what materials show"),
        (
            "name = \"a\"\nprogram = \"fluid\"\n[[simulations]]\nname = \"a\"\nprogram = \"fluid\"\n",
            "6:8: error: two simulations are called `a`",
        ),
        (
            "name = \"a\"\nprogram = \"fluid\"\n[[water]]\nnode = \"Pond\"\nsimulation = \"b\"\n",
            "7:14: error: there is no simulation called `b`",
        ),
        (
            "name = \"a\"\nprogram = \"fluid\"\nover = \"Ball.1\"\n[[water]]\nnode = \"Pond\"\nsimulation = \"a\"\n",
            "7:8: error: the simulation lies over another node than `Pond`",
        ),
        (
            "name = \"a\"\nprogram = \"fluid\"\n[[water]]\nnode = \"Pond\"\nsimulation = \"a\"\nwind_m_s = 2\n",
            "8:12: error: the waves are those of `simulation`",
        ),
    ] {
        let text = format!("[[simulations]]\n{text}");
        let error = applied(&text).map(drop).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many: String = (0..17).map(|at| format!("[[simulations]]\nname = \"{at}\"\nprogram = \"fluid\"\n")).collect();
    assert!(applied(&many).map(drop).expect_err("17").contains("there are more simulations than 16"));

    let particles = "[[particles]]\npreset = \"rain\"\ncount = 300\ncenter = [0, 4, 0]\nrate_per_s = 50\nradius_m = [0.1, 0.2]\n\
                     parameters = { wind_m_s = [1, 0, 0] }\n[[particles]]\nname = \"fire\"\npreset = \"sparks\"\nopacity = 0.5\n";
    let (_, scene, _) = applied(particles).unwrap();
    let [rain, fire] = &scene.particles[..] else { panic!("{:?}", scene.particles) };
    assert_eq!((rain.name.as_str(), rain.count(), rain.simulation.cells), ("rain", 300, Some((300, 1))));
    for (key, value) in [("count", "300"), ("center", "0,4,0"), ("rate_per_s", "50"), ("wind_m_s", "1,0,0")] {
        assert!(rain.simulation.parameters.contains(&owned(key, value)), "{key}: {:?}", rain.simulation.parameters);
    }
    assert_eq!((rain.look.radius_m, fire.name.as_str(), fire.look.opacity), (glam::Vec2::new(0.1, 0.2), "fire", 0.5));
    for (text, expected) in [
        ("", "2:1: error: `preset` is missing"),
        ("preset = \"snow\"\n", "3:10: error: `\"snow\"` is no value of `preset`"),
        ("preset = \"rain\"\ncount = 0\n", "4:9: error: `0` is no value of `count`"),
        ("preset = \"rain\"\ncount = 2e6\n", "4:9: error: `2e6` is no value of `count`"),
        ("preset = \"rain\"\ncount = 2.5\n", "4:9: error: `count` is a whole number"),
        ("preset = \"rain\"\nsize_m = [1, -1, 1]\n", "4:10: error: `size_m` is an extent"),
        ("preset = \"rain\"\nradius_m = [1, -1]\n", "4:12: error: `radius_m` is a radius"),
        ("preset = \"rain\"\nmeets = \"Abov\"\n", "4:9: error: the model has no camera called `Abov`"),
        ("preset = \"rain\"\n[[particles]]\npreset = \"rain\"\n", "4:1: error: two systems of particles are called"),
    ] {
        let text = format!("[[particles]]\n{text}");
        let error = applied(&text).map(drop).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
}

#[test]
fn portals_have_two_ends() {
    let applied = |text: &str| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = model();
        let square = Primitive { material: Some(0), ..crate::primitives::plane(2.0) };
        scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
        let mesh = Some(scene.meshes.len() - 1);
        for name in ["Door.1", "Door.2", "Goer"] {
            scene.add_node(None, Node { name: name.into(), mesh, ..Node::default() });
        }
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok::<Scene, String>(scene)
    };
    let scene = applied(
        "[[portals]]\nname = \"door\"\nnode = \"Door.1\"\nto_node = \"Door.2\"\ncarries = \"Go*\"\nscale = 0.5\n\
         [[portals]]\nposition = [0, 1, 0]\nfacing = [0, 0, 1]\nto_position = [9, 1, 0]\nto_facing = [1, 0, 0]\nsize_m = [1, 2]\n",
    )
    .unwrap();
    let [door, gate] = &scene.portals[..] else { panic!("{:?}", scene.portals) };
    assert_eq!((door.name.as_str(), door.scale, door.carried.len()), ("door", 0.5, 2));
    assert_eq!((gate.name.as_str(), gate.scale, gate.carried.len()), ("portal", 1.0, 0));
    let [first, second] = gate.nodes.map(|id| scene.panel(id).unwrap());
    assert!(first.normal_world.abs_diff_eq(Vec3::Z, 1e-6) && second.normal_world.abs_diff_eq(Vec3::X, 1e-6));
    for (text, expected) in [
        (
            "",
            "2:1: error: a portal has two ends: `node`, a flat surface of the model, or `position` and `facing`, with",
        ),
        ("node = \"Door.1\"\n", "2:1: error: a portal has two ends: `to_node`, a flat surface"),
        ("node = \"Door.1\"\nto_node = \"Dor.2\"\n", "4:11: error: the model has no node called `Dor.2`"),
        (
            "node = \"Door.*\"\nto_node = \"Door.2\"\n",
            "3:8: error: an end of a portal is one node, and 2 are called `Door.*`",
        ),
        ("node = \"Door.1\"\nto_node = \"Door.1\"\n", "2:1: error: both ends are the node `Door.1`"),
        (
            "node = \"Post\"\nto_node = \"Door.1\"\n",
            "2:1: error: an end of a portal is flat, and the node `Post` has no mesh",
        ),
        (
            "node = \"Door.1\"\nfacing = [0, 0, 1]\nto_node = \"Door.2\"\n",
            "4:10: error: `node` is a surface of the model",
        ),
        ("node = \"Door.1\"\nto_node = \"Door.2\"\nsize_m = [1, 1]\n", "5:10: error: nodes have a size of their own"),
        (
            "node = \"Door.1\"\nto_node = \"Door.2\"\ncarries = \"Comer\"\n",
            "5:11: error: the model has no node called `Comer`",
        ),
        (
            "position = [0, 0, 0]\nfacing = [0, 0, 0]\nsize_m = [1, 1]\nto_node = \"Door.2\"\n",
            "4:10: error: `facing` is a direction, and has no length",
        ),
        (
            "position = [0, 0, 0]\nfacing = [0, 0, 1]\nsize_m = [1, 0]\nto_node = \"Door.2\"\n",
            "5:10: error: `size_m` is a width and a height",
        ),
        (
            "node = \"Door.1\"\nto_node = \"Door.2\"\n[[mirrors]]\nnode = \"Door.2\"\n",
            "2:1: error: the node `Door.2` is a mirror already",
        ),
    ] {
        let text = format!("[[portals]]\n{text}");
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many = "[[portals]]\nposition = [0, 0, 0]\nfacing = [0, 1, 0]\nto_position = [0, 0, 1]\nto_facing = [0, 1, 0]\nsize_m = [1, 1]\n";
    assert!(applied(&many.repeat(17)).expect_err("17").contains("there are more portals than 16"));
}

#[test]
fn surroundings_are_boxes() {
    let applied = |text: &str| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = model();
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok::<Scene, String>(scene)
    };
    let scene = applied(
        "[[surroundings]]\nname = \"hall\"\ncenter = [0, 1, 0]\nsize_m = [4, 2, 6]\nupdate = \"once\"\n\
         [[surroundings]]\ncenter = [9, 1, 0]\nsize_m = [1, 1, 1]\nposition = [9, 2, 0]\nwalls = false\nfade_m = 0.2\nlayers = [0]\n",
    )
    .unwrap();
    let [hall, thing] = &scene.surroundings[..] else { panic!("{:?}", scene.surroundings) };
    assert_eq!(
        (hall.name.as_str(), hall.position_world, hall.region.half_m),
        ("hall", Vec3::Y, Vec3::new(2.0, 1.0, 3.0))
    );
    assert_eq!((hall.walls, hall.update), (Some(hall.region), crate::capture::Update::Once));
    assert_eq!((thing.walls, thing.fade_m, thing.layers, thing.position_world.y), (None, 0.2, 1, 2.0));
    for (text, expected) in [
        ("", "2:1: error: `center` is missing"),
        ("center = [0, 0, 0]\n", "2:1: error: `size_m` is missing"),
        ("center = [0, 0, 0]\nsize_m = [1, 0, 1]\n", "4:10: error: `size_m` has three lengths above 0"),
        (
            "center = [0, 0, 0]\nsize_m = [1, 1, 1]\nwalls_center = [0, 0, 0]\n",
            "5:16: error: a box has a middle and a size",
        ),
        (
            "center = [0, 0, 0]\nsize_m = [1, 1, 1]\nwalls = false\nwalls_center = [0, 0, 0]\nwalls_size_m = [1, 1, 1]\n",
            "5:9: error: without walls they have no place",
        ),
        (
            "center = [0, 0, 0]\nsize_m = [1, 1, 1]\nupdate = \"once\"\nevery = 3\n",
            "6:9: error: what is drawn once is not drawn every",
        ),
    ] {
        let text = format!("[[surroundings]]\n{text}");
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many = "[[surroundings]]\ncenter = [0, 0, 0]\nsize_m = [1, 1, 1]\n".repeat(5);
    assert!(applied(&many).expect_err("5").contains("there are more surroundings than 4"));
}

#[test]
fn surroundings_have_the_picture_of_their_place() {
    use crate::surroundings::{Region, Surroundings};
    let text = "model = \"m.glb\"\n[[surroundings]]\ncenter = [0, 1, 0]\nsize_m = [4, 2, 6]\nlayers = [0]\n";
    for (name, size_m, has_picture) in [("room", 4.0, true), ("room", 5.0, false), ("other", 4.0, false)] {
        let mut scene = model();
        let region = Region { center_world: Vec3::Y, half_m: Vec3::new(0.5 * size_m, 1.0, 3.0) };
        let picture = Some(crate::EnvironmentMap::from_fn("a", 2, 1, |_| Vec3::ONE).into());
        scene.surroundings.push(Surroundings { picture, ..Surroundings::of_room(name, region) });
        Stage::parse("a.stage.toml", text).unwrap().apply(&mut scene).unwrap();
        let room = scene.surroundings.iter().find(|of| of.name == "room").unwrap();
        assert_eq!((room.picture.is_some(), room.layers), (has_picture, 1), "{name} {size_m}");
    }
}

#[test]
fn probes_stand_in_boxes_or_all_over_the_model() {
    let applied = |text: &str, given: Scene| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = given;
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok::<Scene, String>(scene)
    };
    let scene = applied(
        "[[probes]]\nname = \"hall\"\ncenter = [0, 1, 0]\nsize_m = [4, 2, 6]\ncounts = [4, 2, 3]\nfade_m = 0.5\n\
         [[probes]]\ncenter = [9, 1, 0]\nsize_m = [1, 1, 2]\nspacing_m = 0.5\nbasis = \"ambient-cube\"\n",
        model(),
    )
    .unwrap();
    let [hall, other] = &scene.probes[..] else { panic!("{:?}", scene.probes) };
    assert_eq!((hall.name.as_str(), hall.counts, hall.fade_m), ("hall", [4, 2, 3], 0.5));
    assert_eq!((other.name.as_str(), other.counts, other.basis.name()), ("probes", [3, 3, 5], "ambient-cube"));
    // Without light that was found beforehand frames find it.
    assert_eq!(hall.live, Some(crate::probes::LiveProbes::default()));
    // A file's light of the same name is taken where it is of the same places.
    let mut baked = model();
    let probes = Some(std::sync::Arc::new(vec![crate::probes::Probe::default(); hall.count()]));
    baked.probes = vec![crate::probes::ProbeGrid { probes, ..hall.clone() }];
    let of_hall = "[[probes]]\nname = \"hall\"\ncenter = [0, 1, 0]\nsize_m = [4, 2, 6]\nfade_m = 0.1\ncounts = ";
    for (counts, has_light) in [("[4, 2, 3]", true), ("[4, 2, 4]", false)] {
        let scene = applied(&format!("{of_hall}{counts}\n"), baked.clone()).unwrap();
        assert_eq!((scene.probes.len(), scene.probes[0].fade_m), (1, 0.1));
        assert_eq!(scene.probes[0].probes.is_some(), has_light, "{counts}");
        assert_eq!(scene.probes[0].live.is_none(), has_light, "{counts}");
        let scene =
            applied(&format!("{of_hall}{counts}\nlive = true\nbounces = 5\nlayers = [1]\n"), baked.clone()).unwrap();
        assert_eq!(scene.probes[0].live, Some(crate::probes::LiveProbes { bounces: 5, layers: 2 }), "{counts}");
        let scene = applied(&format!("{of_hall}{counts}\nlive = false\n"), baked.clone()).unwrap();
        assert_eq!((scene.probes[0].probes.is_some(), scene.probes[0].live), (has_light, None), "{counts}");
    }
    for (text, expected) in [
        ("center = [0, 0, 0]\n", "3:10: error: a box has a middle and a size"),
        ("counts = [1, 0, 1]\n", "3:10: error: `counts` has three whole numbers above 0"),
        (
            "center = [0, 0, 0]\nsize_m = [1, 1, 1]\ncounts = [100, 100, 100]\n",
            "5:10: error: 100 x 100 x 100 probes; a grid has 1 to 16384",
        ),
        ("center = [0, 0, 0]\nsize_m = [9, 9, 9]\nspacing_m = 0.01\n", "5:13: error: 901 x 901 x 901 probes"),
        ("counts = [1, 1, 1]\nspacing_m = 2\n", "4:13: error: `counts` says already"),
        ("live = false\nbounces = 2\n", "4:11: error: `bounces` is of probes whose light frames find"),
        ("bounces = 1.5\n", "3:11: error: `bounces` is a whole number"),
        ("bounces = 9\n", "3:11: error:"),
        ("center = [0, 0, 0]\nsize_m = [1, 1, 1]\n[[probes]]\n", "5:1: error: two grids of probes are called `probes`"),
    ] {
        let text = format!("[[probes]]\n{text}");
        let error = applied(&text, model()).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many: String = (0..5)
        .map(|number| format!("[[probes]]\nname = \"{number}\"\ncenter = [0, 0, 0]\nsize_m = [1, 1, 1]\n"))
        .collect();
    assert!(applied(&many, model()).expect_err("5").contains("there are more grids of probes than 4"));
}

#[test]
fn mirrors_are_flat_nodes_or_rectangles() {
    let flat = |scene: &mut Scene| {
        let square = Primitive { material: Some(0), ..crate::primitives::plane(2.0) };
        let ball = crate::primitives::uv_sphere(1.0, 8, 4);
        for (name, primitive) in [("Pane.1", square.clone()), ("Pane.2", square), ("Ball", ball)] {
            scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
            let mesh = Some(scene.meshes.len() - 1);
            scene.add_node(None, Node { name: name.into(), mesh, ..Node::default() });
        }
    };
    let applied = |text: &str| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = model();
        flat(&mut scene);
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok::<Scene, String>(scene)
    };
    let scene = applied(
        "[[mirrors]]\nnode = \"Pane*\"\ncolor = \"ffffff\"\nroughness = 0.2\nscale = 0.5\nlayers = [1]\n\
         [[mirrors]]\nname = \"wall\"\nposition = [0, 1, -3]\nfacing = [0, 0, 2]\nsize_m = [4, 2]\n",
    )
    .unwrap();
    let [first, second, wall] = &scene.mirrors[..] else { panic!("{:?}", scene.mirrors) };
    assert_eq!((first.name.as_str(), second.name.as_str(), wall.name.as_str()), ("Pane.1", "Pane.2", "wall"));
    assert_eq!((first.scale, first.layers, wall.scale, wall.layers), (0.5, 2, 1.0, u32::MAX));
    let material = |node: NodeId| {
        let primitive = &scene.meshes[scene.node(node).mesh.unwrap()].primitives[0];
        &scene.materials[primitive.material.unwrap()]
    };
    assert_eq!((material(first.node).metallic_factor, material(first.node).roughness_factor), (1.0, 0.2));
    assert_eq!(scene.materials[0].roughness_factor, Material::default().roughness_factor);
    let panel = scene.panel(wall.node).unwrap();
    assert!(panel.normal_world.abs_diff_eq(Vec3::Z, 1e-6), "{panel:?}");
    let [across, up] = panel.half_edges_world.map(Vec3::abs);
    assert!(across.abs_diff_eq(2.0 * Vec3::X, 1e-5) && up.abs_diff_eq(Vec3::Y, 1e-5), "{panel:?}");
    for (text, expected) in [
        ("", "2:1: error: a mirror needs `node`, a flat surface of the model, or `position`, `facing` and `size_m`"),
        ("node = \"Pan\"\n", "3:8: error: the model has no node called `Pan`"),
        ("node = \"Ball\"\n", "3:8: error: a mirror is flat, and the node `Ball` is not flat"),
        ("node = \"Post\"\n", "3:8: error: a mirror is flat, and the node `Post` has no mesh"),
        ("node = \"Pane.1\"\n[[mirrors]]\nnode = \"Pane*\"\n", "5:8: error: the node `Pane.1` is a mirror already"),
        (
            "node = \"Pane.1\"\nfacing = [0, 1, 0]\n",
            "4:10: error: `node` is a surface of the model; leave out `facing`",
        ),
        (
            "position = [0, 0, 0]\nfacing = [0, 0, 0]\nsize_m = [1, 1]\n",
            "4:10: error: `facing` is a direction, and has no length",
        ),
        (
            "position = [0, 0, 0]\nfacing = [0, 1, 0]\nsize_m = [1, 0]\n",
            "5:10: error: `size_m` is a width and a height",
        ),
        ("node = \"Pane.1\"\nscale = 0\n", "4:9: error: `0` is no value of `scale`"),
        ("node = \"Pane.1\"\nroughness = 2\n", "4:13: error: `2` is no value of `roughness`"),
    ] {
        let text = format!("[[mirrors]]\n{text}");
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many = "[[mirrors]]\nposition = [0, 0, 0]\nfacing = [0, 1, 0]\nsize_m = [1, 1]\n".repeat(65);
    assert!(applied(&many).expect_err("65").contains("there are more mirrors than 64"));
}

#[test]
fn decals_are_placed_strewn_and_hung_on_nodes() {
    let applied = |text: &str| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = model();
        let pixels = Pixels { width: 1, height: 1, format: PixelFormat::Rgba8, data: vec![255; 4] };
        scene.images.push(Image { name: "Leaf".into(), source: ImageSource::Pixels(pixels.into()) });
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok::<Scene, String>(scene)
    };
    let scene = applied(
        "[[decals]]\nimage = \"model:Leaf\"\nposition = [1, 2, 3]\nsize_m = [2, 1]\nroughness = 0.25\nlayers = [2]\norder = -3\n\
         [[decals]]\nname = \"many\"\npositions = [[0, 0, 0], [9, 0, 0]]\ncount = 20\nspread_m = [2, 1, 0]\n\
         [[decals]]\nnode = \"Post*\"\nemission = 5\nemission_color = [1, 0, 0]\nangle_deg = [180, 180]\n",
    )
    .unwrap();
    let one = &scene.decals[0];
    assert_eq!((one.name.as_str(), one.layers, one.order), ("decal", 4, -3));
    let look = &one.look;
    assert_eq!((look.color_image, look.roughness, look.opacity.roughness), (Some(scene.images.len() - 1), 0.25, 1.0));
    assert_eq!((look.opacity.color, look.opacity.normal, look.opacity.emission), (1.0, 0.0, 0.0));
    // Thrown down, with its upper edge towards −Z.
    let corner = one.parent_from_box.transform_point3(Vec3::new(0.5, 0.5, 0.5));
    assert!(corner.abs_diff_eq(Vec3::new(2.0, 2.25, 2.5), 1e-5), "{corner}");
    let many: Vec<_> = scene.decals.iter().filter(|decal| decal.name == "many").collect();
    assert_eq!(many.len(), 40);
    for (at, decal) in many.iter().enumerate() {
        let middle = decal.parent_from_box.w_axis.truncate() - if at < 20 { Vec3::ZERO } else { 9.0 * Vec3::X };
        assert!(middle.x.abs() <= 1.0 && middle.y.abs() <= 0.5 && middle.z == 0.0, "{middle}");
        let side = decal.parent_from_box.x_axis.truncate().length();
        assert!((0.7..=1.3).contains(&side), "{side}");
    }
    let hung: Vec<_> = scene.decals.iter().filter(|decal| decal.node.is_some()).collect();
    assert!(!hung.is_empty() && hung.iter().all(|decal| decal.look.emission == Vec3::new(5.0, 0.0, 0.0)));
    assert_eq!(hung[0].look.opacity.emission, 1.0);
    for (text, expected) in [
        ("image = \"\"\n", "3:9: error: the name of `image` is empty"),
        ("image = \"model:Lea\"\n", "3:9: error: the model has no image called `Lea`; did you mean `Leaf`?"),
        ("image = \"leaf.png\"\n", "3:9: error: `leaf.png` was not given with the stage"),
        ("node = \"Pots\"\n", "3:8: error: the model has no node called `Pots`"),
        ("size_m = [1, 0]\n", "3:10: error: `size_m` is the width and the height of the picture, both above 0"),
        ("depth_m = 0\n", "3:11: error: `0` is no value of `depth_m`"),
        ("direction = [0, 0, 0]\n", "3:13: error: `direction` has no length"),
        ("up = [0, 0, 0]\n", "3:6: error: `up` has no length"),
        ("count = 3\nspread_m = [-1, 0, 0]\n", "4:12: error: `spread_m` is an extent"),
        ("angle_deg = [0, 0]\n", "3:13: error: `angle_deg` is where surfaces begin to show less"),
        ("angle_deg = [80, 60]\n", "3:13: error: `angle_deg` is where surfaces begin to show less"),
        ("opacity = 1.5\n", "3:11: error: `1.5` is no value of `opacity`"),
        ("normal_scale = 2\n", "3:16: error: `normal_scale` needs `normal_map`"),
        ("seed = 2\n", "3:8: error: `seed` needs `count`"),
        ("count = 1e9\n", "3:9: error: `1e9` is no value of `count`"),
        ("position = [nan, 0, 0]\n", "3:12: error: `[nan, 0, 0]` is no value of `position`"),
        (
            "position = [0, 0, 0]\npositions = [[0, 0, 0], [1, 0, 0]]\n",
            "4:13: error: leave out `position`, or `positions`",
        ),
        ("count = 4096\n[[decals]]\n", "4:1: error: there are more decals than 4096"),
    ] {
        let text = format!("[[decals]]\n{text}");
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
}
