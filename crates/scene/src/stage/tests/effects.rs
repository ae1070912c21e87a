//! Simulations, decals and water.

use super::*;
use crate::{Image, ImageSource, PixelFormat, Pixels};

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
        ("node = \"Pond\"\nclarity = \"dirty\"\n", "4:11: error: `\"dirty\"` is not a value of `clarity`"),
        ("node = \"Pond\"\nior = 1\n", "4:7: error: `1` is not a value of `ior`"),
        ("node = \"Pond\"\nwind_m_s = -1\n", "4:12: error: `-1` is not a value of `wind_m_s`"),
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
        ("name = \"a\"\nprogram = \"bytes.wgsl\"\n", "4:11: error: `bytes.wgsl` is not UTF-8 text"),
        ("name = \"a\"\nprogram = \"fluid\"\ncells = [0, 4]\n", "5:9: error: `cells` is a width and a height"),
        ("name = \"a\"\nprogram = \"fluid\"\ncells = [4096, 4]\n", "5:9: error: `cells` is a width and a height"),
        ("name = \"a\"\nprogram = \"fluid\"\nrate_hz = 0\n", "5:11: error: `0` is not a value of `rate_hz`"),
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
        (
            "name = \"a\"\nprogram = \"fluid\"\nbodies = \"Pond\"\n",
            "5:10: error: `\"Pond\"` is not a value of `bodies`",
        ),
        (
            "name = \"a\"\nprogram = \"fluid\"\nparameters = { a = \"b\" }\n",
            "5:14: error: `{ a = \"b\" }` is not a value",
        ),
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
        ("preset = \"snow\"\n", "3:10: error: `\"snow\"` is not a value of `preset`"),
        ("preset = \"rain\"\ncount = 0\n", "4:9: error: `0` is not a value of `count`"),
        ("preset = \"rain\"\ncount = 2e6\n", "4:9: error: `2e6` is not a value of `count`"),
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
        ("depth_m = 0\n", "3:11: error: `0` is not a value of `depth_m`"),
        ("direction = [0, 0, 0]\n", "3:13: error: `direction` has no length"),
        ("up = [0, 0, 0]\n", "3:6: error: `up` has no length"),
        ("count = 3\nspread_m = [-1, 0, 0]\n", "4:12: error: `spread_m` is an extent"),
        ("angle_deg = [0, 0]\n", "3:13: error: `angle_deg` is where surfaces begin to show less"),
        ("angle_deg = [80, 60]\n", "3:13: error: `angle_deg` is where surfaces begin to show less"),
        ("opacity = 1.5\n", "3:11: error: `1.5` is not a value of `opacity`"),
        ("normal_scale = 2\n", "3:16: error: `normal_scale` needs `normal_map`"),
        ("seed = 2\n", "3:8: error: `seed` needs `count`"),
        ("count = 1e9\n", "3:9: error: `1e9` is not a value of `count`"),
        ("position = [nan, 0, 0]\n", "3:12: error: `[nan, 0, 0]` is not a value of `position`"),
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
