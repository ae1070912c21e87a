//! What comes out of bakes: always the same, no light through walls, files that are read again, and errors in place of
//! nonsense.

use crate::common::{add, at, bake, matte, mean, settings};
use glam::{Vec2, Vec3};
use manypass_bake::{BakeError, BakeSettings, Baker, Encoding, Keeper, LayoutSettings, Progress, Stage, Surfaces};
use manypass_scene::gltf_file::{Parts, load_bytes};
use manypass_scene::{
    Channel, Interpolation, Keyframes, Light, LightMode, Material, Node, NodeId, Primitive, Scene, demo, primitives,
};
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

fn small() -> BakeSettings {
    BakeSettings { samples: 16, bounces: 2, occlusion: true, ..settings(12.0, 16, 2) }
}

fn cornell() -> Scene {
    demo::cornell()
}

/// Keeps blocks in memory.
#[derive(Default)]
struct Memory(Mutex<HashMap<(u32, u32), Vec<u8>>>);

impl Keeper for Memory {
    fn get(&self, round: u32, block: u32) -> Option<Vec<u8>> {
        self.0.lock().ok()?.get(&(round, block)).cloned()
    }

    fn put(&self, round: u32, block: u32, bytes: &[u8]) {
        if let Ok(mut blocks) = self.0.lock() {
            blocks.insert((round, block), bytes.to_vec());
        }
    }
}

/// Says to stop after so many steps.
struct StopAfter(AtomicU32);

impl Progress for StopAfter {
    fn step(&self, _: Stage, _: u64, _: u64) -> bool {
        self.0.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |left| left.checked_sub(1)).is_ok()
    }
}

#[test]
fn an_interrupted_bake_ends_as_one_that_was_not() {
    let scene = cornell();
    let whole = bake(&scene, None, &small());
    assert_eq!(bake(&scene, None, &small()).light, whole.light);
    let surfaces = Surfaces::new(&scene);
    let memory = Memory::default();
    let mut interruptions = 0;
    let again = loop {
        let baker = Baker::new(&scene, &surfaces, None, &small(), &()).unwrap();
        match baker.run(&StopAfter(AtomicU32::new(7 * (interruptions + 1))), &memory) {
            Ok(baked) => break baked,
            Err(error) => assert_eq!(error, BakeError::Interrupted),
        }
        interruptions += 1;
    };
    assert!(interruptions > 2, "{interruptions}");
    assert_eq!((&again.light, &again.occlusion), (&whole.light, &whole.occlusion));
}

#[test]
fn directions_are_the_same_again_and_leave_light_as_it_is() {
    let scene = cornell();
    let plain = bake(&scene, None, &small());
    assert!(plain.direction.is_empty());
    let directional = BakeSettings { directional: true, ..small() };
    let whole = bake(&scene, None, &directional);
    assert_eq!((&whole.light, &whole.occlusion), (&plain.light, &plain.occlusion));
    let surfaces = Surfaces::new(&scene);
    let memory = Memory::default();
    let mut steps = 20;
    let again = loop {
        let baker = Baker::new(&scene, &surfaces, None, &directional, &()).unwrap();
        if let Ok(baked) = baker.run(&StopAfter(AtomicU32::new(steps)), &memory) {
            break baked;
        }
        steps += 20;
    };
    assert!(steps > 20);
    assert_eq!(again.direction, whole.direction);
    // Light comes from the side that is lit. What lies within a texel may be round or have two sides.
    let lengths = whole.direction.iter().map(|of| Vec3::from(*of).length());
    assert!(lengths.clone().all(|length| length <= 1.0 + 1e-6));
    let lit = whole.light.iter().zip(lengths).filter(|(light, _)| light[0] > 0.0);
    assert!(lit.clone().filter(|(_, length)| *length > 0.3).count() as f32 > 0.99 * lit.count() as f32);
}

#[test]
fn keys_are_those_of_scene_and_settings() {
    let key = |scene: &Scene, settings: &BakeSettings| {
        let surfaces = Surfaces::new(scene);
        Baker::new(scene, &surfaces, None, settings, &()).unwrap().key()
    };
    let scene = cornell();
    let first = key(&scene, &small());
    assert_eq!(key(&scene.clone(), &small()), first);
    assert_ne!(key(&scene, &BakeSettings { bounces: 1, ..small() }), first);
    assert_ne!(key(&scene, &BakeSettings { directional: true, ..small() }), first);
    let mut other = scene.clone();
    other.materials[1].base_color_factor.x += 0.01;
    assert_ne!(key(&other, &small()), first);
    let mut other = scene.clone();
    let tall = other.nodes.iter_mut().find(|node| node.name == "Box.Tall").unwrap();
    tall.translation.x += 0.01;
    other.update_transforms();
    assert_ne!(key(&other, &small()), first);
    let mut other = scene;
    other.lights.push(Light::default());
    other.add_node(None, Node { light: Some(0), ..Node::default() });
    other.update_transforms();
    assert_ne!(key(&other, &small()), first);
}

/// A closed room of 2 m around `x`, of walls that are 2 cm thin where rooms meet.
fn room(scene: &mut Scene, x: f32, emission: f32) -> usize {
    let mut walls = primitives::cube(Vec3::splat(2.0));
    walls.indices.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
    walls.normals.iter_mut().flatten().for_each(|part| *part = -*part);
    let place = scene.nodes.len();
    add(scene, walls, matte(0.7, emission), Node { translation: Vec3::new(x, 0.0, 0.0), ..Node::default() });
    place
}

#[test]
fn no_light_comes_through_a_thin_wall() {
    let mut scene = Scene::default();
    room(&mut scene, 0.0, 0.5);
    room(&mut scene, 2.02, 0.0);
    let baked = bake(&scene, None, &settings(16.0, 128, 4));
    let (bright, dark) = (mean(&baked, 0), mean(&baked, 1));
    assert!(bright > 1.0, "{bright}");
    assert!(dark < 0.001 * bright, "{dark} beside {bright}");
    // Not at the edges, either, where what lies beside a chart might come in.
    let of = &baked.layout.unwrapped[1];
    let brightest = of.indices.chunks_exact(3).flat_map(|corners| {
        let corners = [0, 1, 2].map(|corner| of.vertices[corners[corner] as usize].1);
        (0..=64).map(move |step| corners[0].lerp(corners[1], step as f32 / 64.0))
    });
    let brightest = brightest.map(|uv| at(&baked, of.page, uv)).fold(0.0, f32::max);
    assert!(brightest < 0.01 * bright, "{brightest} beside {bright}");
}

#[test]
fn what_stands_on_a_floor_leaves_no_dark_rim() {
    let mut scene = Scene::default();
    add(&mut scene, primitives::plane(4.0), matte(0.0, 0.0), Node::default());
    // A box that reaches into the floor: texels below it see it from inside.
    let put = Node { translation: Vec3::new(0.0, 0.05, 0.0), ..Node::default() };
    add(&mut scene, primitives::cube(Vec3::new(1.0, 0.2, 1.0)), matte(0.0, 0.0), put);
    let baked = bake(&scene, Some(&Vec3::ONE), &settings(10.0, 256, 0));
    let of = &baked.layout.unwrapped[0];
    let (low, high) =
        of.vertices.iter().fold((Vec2::ONE, Vec2::ZERO), |(low, high), (_, uv)| (low.min(*uv), high.max(*uv)));
    // Beside the box half of the sky above the horizon is open at least, and below it texels take what is beside it.
    for step in 0..=100 {
        let uv = low.lerp(high, step as f32 / 100.0);
        let found = at(&baked, of.page, uv.clamp(low + 0.001, high - 0.001));
        assert!((0.3..1.02).contains(&found), "{found} at {step} of 100");
    }
}

#[test]
fn lamps_are_in_maps_as_their_mode_says() {
    let lit = |mode: LightMode, bounces: u32| {
        let mut scene = Scene::default();
        add(&mut scene, primitives::plane(2.0), matte(0.5, 0.0), Node::default());
        let above = Node {
            translation: Vec3::new(0.0, 1.0, 0.0),
            rotation: glam::Quat::from_rotation_x(std::f32::consts::PI),
            ..Node::default()
        };
        add(&mut scene, primitives::plane(2.0), matte(0.5, 0.0), above);
        scene.lights.push(Light { intensity: 10.0, mode, ..Light::default() });
        scene.add_node(None, Node { translation: Vec3::new(0.0, 0.5, 0.0), light: Some(0), ..Node::default() });
        scene.update_transforms();
        mean(&bake(&scene, None, &settings(10.0, 64, bounces)), 0)
    };
    assert_eq!(lit(LightMode::Dynamic, 2), 0.0);
    assert_eq!(lit(LightMode::Mixed, 0), 0.0);
    let (direct, all, sent_back) = (lit(LightMode::Baked, 0), lit(LightMode::Baked, 2), lit(LightMode::Mixed, 2));
    assert!(direct > 1.0 && sent_back > 0.1);
    assert!((direct + sent_back - all).abs() < 0.01 * all, "{direct} + {sent_back} is not {all}");
}

#[test]
fn a_written_file_is_the_scene_with_its_maps() {
    for (encoding, extension) in [(Encoding::Exr, "MANYPASS_texture_exr"), (Encoding::Rgbm, "MOZ_lightmap")] {
        let scene = cornell();
        let directional = encoding == Encoding::Exr;
        let baked = bake(&scene, None, &BakeSettings { directional, ..small() });
        let mut in_memory = scene.clone();
        baked.apply(&mut in_memory).unwrap();
        let (mut parts, notes) = Parts::of_scene(&scene);
        assert!(notes.is_empty(), "{notes:?}");
        baked.write(&mut parts, &scene, encoding).unwrap();
        let bytes = parts.clone().to_glb().unwrap();
        let read = load_bytes(&bytes, &mut |_| unreachable!("it is one file"), "baked.glb").unwrap();
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        let read = read.scene;
        assert!(read.extensions_used.iter().any(|used| used == extension));
        for (one, other) in in_memory.visible_nodes().into_iter().zip(read.visible_nodes()) {
            let mesh = |scene: &Scene, id: NodeId| scene.node(id).mesh.map(|mesh| scene.meshes[mesh].clone());
            let (Some(one), Some(other)) = (mesh(&in_memory, one), mesh(&read, other)) else { continue };
            for (one, other) in one.primitives.iter().zip(&other.primitives) {
                assert_eq!((&one.positions, &one.normals, &one.uv1), (&other.positions, &other.normals, &other.uv1));
                assert_eq!(one.indices, other.indices);
                let of = |scene: &Scene, primitive: &Primitive| scene.materials[primitive.material.unwrap()].clone();
                let (one, other): (Material, Material) = (of(&in_memory, one), of(&read, other));
                assert_eq!((one.name, one.base_color_factor), (other.name, other.base_color_factor));
                let light_map = other.light_map.unwrap();
                let map = light_map.light;
                assert_eq!(map.texture.unwrap().uv_set, 1);
                assert_eq!(light_map.direction.is_some(), directional);
                if let Some(direction) = light_map.direction {
                    assert_eq!(direction.uv_set, 1);
                    let pixels = read.images[read.textures[direction.texture].image].decode().unwrap();
                    for (found, expected) in pixels.data.chunks_exact(4).zip(&baked.direction) {
                        for (byte, part) in found.iter().zip(expected) {
                            assert!(
                                (f32::from(*byte) / 127.5 - 1.0 - part).abs() < 0.5 / 127.0,
                                "{byte} is not {part}"
                            );
                        }
                    }
                }
                assert_eq!(other.occlusion_texture.unwrap().uv_set, 1);
                let image = read.textures[map.texture.unwrap().texture].image;
                let light = if encoding == Encoding::Rgbm {
                    read.images[image].decode_rgbm()
                } else {
                    read.images[image].decode_light()
                };
                let light = light.unwrap();
                assert_eq!((light.width, light.height), (baked.layout.width, baked.layout.height));
                for (found, expected) in light.texels.iter().zip(&baked.light) {
                    let most = expected.iter().copied().fold(0.0, f32::max).max(1e-3);
                    let off = (found[0].to_f32() * map.factor - expected[0]).abs();
                    assert!(off < 0.01 * most + 1e-4, "{encoding:?}: {found:?} is not {expected:?}");
                }
            }
        }
        // Baked again, the file's own second UV set is taken, and its maps are replaced.
        let again = bake(&read, None, &small());
        assert_eq!(again.layout.unwrapped.len(), baked.layout.unwrapped.len());
        again.write(&mut parts, &read, encoding).unwrap();
        let used = |name: &str| parts.json["extensionsUsed"].as_array().unwrap().iter().any(|used| used == name);
        assert!(!used("MANYPASS_light_direction") && used("MOZ_lightmap"));
        assert_eq!(parts.json["images"].as_array().map(Vec::len), Some(2));
    }
}

#[test]
fn what_moves_is_left_out() {
    let mut scene = cornell();
    let tall = NodeId(scene.nodes.iter().position(|node| node.name == "Box.Tall").unwrap() as u32);
    scene.animations.push(manypass_scene::Animation {
        channels: vec![Channel {
            node: tall,
            times_secs: vec![0.0, 1.0],
            interpolation: Interpolation::Linear,
            keyframes: Keyframes::Translation(vec![Vec3::ZERO, Vec3::X]),
        }],
        ..manypass_scene::Animation::default()
    });
    let baked = bake(&scene, None, &small());
    assert!(baked.layout.unwrapped.iter().all(|of| of.place.node != tall));
    assert_eq!(baked.layout.unwrapped.len(), 7);
}

#[test]
fn nonsense_is_refused_or_passed_over() {
    let of = |scene: &Scene, settings: BakeSettings| manypass_bake::bake(scene, None, &settings, &()).map(|_| ());
    assert_eq!(of(&Scene::default(), small()), Err(BakeError::Nothing));
    let layout = |texels_per_m: f32, side_max: u32, padding: u32| BakeSettings {
        layout: LayoutSettings { texels_per_m, side_max, padding },
        ..small()
    };
    for bad in [
        layout(0.0, 4096, 2),
        layout(f32::NAN, 4096, 2),
        layout(16.0, 0, 2),
        layout(16.0, 65_536, 2),
        layout(16.0, 64, 60),
        BakeSettings { samples: 0, ..small() },
        BakeSettings { bounces: 1000, ..small() },
        BakeSettings { occlusion_distance_m: -1.0, ..small() },
        BakeSettings { directional: true, light: false, ..small() },
        BakeSettings { directional: true, as_emission: true, ..small() },
    ] {
        assert!(matches!(of(&cornell(), bad), Err(BakeError::Setting(_))), "{bad:?}");
    }
    assert!(matches!(of(&cornell(), layout(1e5, 4096, 2)), Err(BakeError::TooLarge { .. })));
    // One triangle; triangles without area; normals and UVs that are no numbers; overlapping UVs.
    let one = |change: &dyn Fn(&mut Primitive)| {
        let mut triangle = Primitive {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            indices: vec![0, 1, 2, 1, 3, 2],
            ..Primitive::default()
        };
        change(&mut triangle);
        let mut scene = Scene::default();
        add(&mut scene, triangle, matte(0.5, 1.0), Node::default());
        let baked = manypass_bake::bake(&scene, Some(&Vec3::ONE), &small(), &());
        if let Ok(baked) = &baked {
            assert!(baked.light.iter().flatten().all(|value| value.is_finite()), "{baked:?}");
        }
        baked.map(|baked| baked.layout.unwrapped.len())
    };
    assert_eq!(one(&|of| of.indices.truncate(3)), Ok(1));
    assert_eq!(one(&|of| of.positions = vec![[1.0; 3]; 4]), Err(BakeError::Nothing));
    assert_eq!(one(&|of| of.normals = vec![[f32::NAN; 3]; 4]), Ok(1));
    assert_eq!(one(&|of| of.positions[3] = [f32::NAN; 3]), Ok(1));
    assert_eq!(one(&|of| of.uv1 = vec![[f32::INFINITY; 2]; 4]), Ok(1));
    assert_eq!(one(&|of| of.uv1 = vec![[0.5, 0.5]; 4]), Ok(1));
    assert_eq!(one(&|of| of.uv1 = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]), Ok(1));
}

#[test]
fn what_does_not_fit_goes_into_more_maps_or_has_fewer_texels() {
    let scene = cornell();
    let layout = LayoutSettings { texels_per_m: 40.0, side_max: 128, padding: 1 };
    let baked = bake(&scene, None, &BakeSettings { layout, samples: 1, bounces: 0, ..small() });
    assert!(baked.layout.page_count > 1 && baked.layout.width <= 128 && baked.layout.height <= 128);
    let layout = LayoutSettings { texels_per_m: 100.0, side_max: 64, padding: 1 };
    let baked = bake(&scene, None, &BakeSettings { layout, samples: 1, bounces: 0, ..small() });
    assert!(baked.layout.width <= 64 && baked.light.iter().flatten().all(|value| value.is_finite()));
}
