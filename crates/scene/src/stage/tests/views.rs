//! What shows or lights the scene from other places: monitors, mirrors, portals, probes, reflection probes.

use super::*;
use crate::NodeId;

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
        (monitor("target = [0, 2, 0]\n"), "5:10: error: `position` and `target` are the same point"),
        (monitor("camera = \"Top\"\n"), "4:12: error: `camera` says from where already; leave out `position`"),
        (monitor("target = [0, 0, 0]\nsize_px = [0, 10]\n"), "6:11: error: `size_px` is a width and a height"),
        (monitor("target = [0, 0, 0]\nsize_px = [-3, 10]\n"), "6:11: error: `size_px` is a width and a height"),
        (monitor("target = [0, 0, 0]\nsize_px = [1e9, 10]\n"), "6:11: error: `size_px` is a width and a height"),
        (monitor("target = [0, 0, nan]\n"), "5:10: error:"),
        (monitor("target = [0, 0, 0]\nfov_deg = 0\n"), "6:11: error: `0` is not a value of `fov_deg`"),
        (monitor("target = [0, 0, 0]\nlayers = [32]\n"), "6:10: error: `[32]` is not a value of `layers`"),
        (monitor("target = [0, 0, 0]\nlayers = [0.5]\n"), "6:10: error: `[0.5]` is not a value of `layers`"),
        (monitor("target = [0, 0, 0]\nslot = \"base_color\"\n"), "6:8: error: `slot` says how materials show it"),
        (
            monitor("target = [0, 0, 0]\nmaterial = \"glas\"\n"),
            "6:12: error: the model has no material called `glas`; did you mean `glass`?",
        ),
        (monitor("target = [0, 0, 0]\nupdate = \"once\"\nevery = 2\n"), "7:9: error: `every` does not go with"),
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
fn reflection_probes_are_boxes() {
    let applied = |text: &str| {
        let stage =
            Stage::parse("a.stage.toml", &format!("model = \"m.glb\"\n{text}")).map_err(|error| error.to_string())?;
        let mut scene = model();
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok::<Scene, String>(scene)
    };
    let scene = applied(
        "[[reflection_probes]]\nname = \"hall\"\ncenter = [0, 1, 0]\nsize_m = [4, 2, 6]\nupdate = \"once\"\n\
         [[reflection_probes]]\ncenter = [9, 1, 0]\nsize_m = [1, 1, 1]\nposition = [9, 2, 0]\n\
         parallax_correction = false\nfade_m = 0.2\nlayers = [0]\n",
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
            "center = [0, 0, 0]\nsize_m = [1, 1, 1]\nparallax_center = [0, 0, 0]\n",
            "5:19: error: a box has a middle and a size",
        ),
        (
            "center = [0, 0, 0]\nsize_m = [1, 1, 1]\nparallax_correction = false\nparallax_center = [0, 0, 0]\n\
             parallax_size_m = [1, 1, 1]\n",
            "5:23: error: without parallax correction there is no box for it",
        ),
        (
            "center = [0, 0, 0]\nsize_m = [1, 1, 1]\nupdate = \"once\"\nevery = 3\n",
            "6:9: error: `every` does not go with",
        ),
    ] {
        let text = format!("[[reflection_probes]]\n{text}");
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many = "[[reflection_probes]]\ncenter = [0, 0, 0]\nsize_m = [1, 1, 1]\n".repeat(5);
    assert!(applied(&many).expect_err("5").contains("there are more reflection probes than 4"));
}

#[test]
fn reflection_probes_have_the_picture_of_their_place() {
    use crate::surroundings::{Region, Surroundings};
    let text = "model = \"m.glb\"\n[[reflection_probes]]\ncenter = [0, 1, 0]\nsize_m = [4, 2, 6]\nlayers = [0]\n";
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
        ("live = false\nbounces = 2\n", "4:11: error: `bounces` is only for live probes"),
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
        ("node = \"Pane.1\"\nscale = 0\n", "4:9: error: `0` is not a value of `scale`"),
        ("node = \"Pane.1\"\nroughness = 2\n", "4:13: error: `2` is not a value of `roughness`"),
    ] {
        let text = format!("[[mirrors]]\n{text}");
        let error = applied(&text).expect_err(&text);
        assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{text}\n{error}");
    }
    let many = "[[mirrors]]\nposition = [0, 0, 0]\nfacing = [0, 1, 0]\nsize_m = [1, 1]\n".repeat(65);
    assert!(applied(&many).expect_err("65").contains("there are more mirrors than 64"));
}
