//! Probes against closed forms, in walls, and twice.

use crate::common::{add, matte};
use glam::{Quat, Vec3};
use manypass_bake::{DistantLight, ProbeBaker, ProbeSettings, Surfaces};
use manypass_scene::probes::{ProbeBasis, ProbeGrid};
use manypass_scene::surroundings::Region;
use manypass_scene::{Light, LightKind, LightMode, Node, Primitive, Scene, primitives};
use std::f32::consts::PI;

fn hollow(radius_m: f32) -> Primitive {
    let mut sphere = primitives::uv_sphere(radius_m, 96, 48);
    sphere.indices.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
    sphere.normals.iter_mut().flatten().for_each(|part| *part = -*part);
    sphere
}

fn grid(half_m: f32, counts: [u32; 3]) -> ProbeGrid {
    let region = Region { center_world: Vec3::ZERO, half_m: Vec3::splat(half_m) };
    ProbeGrid::new("probes", region, counts).expect("a grid")
}

fn bake(scene: &Scene, around: Option<&dyn DistantLight>, grid: &ProbeGrid, settings: ProbeSettings) -> ProbeGrid {
    let surfaces = Surfaces::new(scene);
    let baker = ProbeBaker::new(scene, &surfaces, around, vec![grid.clone()], &settings).expect("settings");
    baker.run(&(), &()).expect("it bakes").remove(0)
}

fn directions() -> impl Iterator<Item = Vec3> {
    [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z, Vec3::ONE.normalize()].into_iter()
}

#[test]
fn a_white_furnace_is_white_in_both_bases() {
    let mut scene = Scene::default();
    add(&mut scene, hollow(1.0), matte(0.5, 0.5), Node::default());
    let mut open = Scene::default();
    add(&mut open, primitives::plane(0.01), matte(1.0, 0.0), Node::default());
    for basis in [ProbeBasis::Harmonics, ProbeBasis::AmbientCube] {
        let grid = ProbeGrid { basis, ..grid(0.4, [2, 2, 2]) };
        // What shines with 0.5 and sends back half of all light has 1 after many bounces.
        let within = bake(&scene, None, &grid, ProbeSettings { samples: 2048, bounces: 12 });
        let without = bake(&open, Some(&Vec3::ONE), &grid, ProbeSettings { samples: 1024, bounces: 0 });
        for probe in within.probes.iter().chain(&without.probes).flat_map(|probes| probes.iter()) {
            assert!(probe.is_on);
            for direction in directions() {
                let irradiance = probe.light.irradiance(direction).x;
                assert!((irradiance - 1.0).abs() < 0.01, "{basis:?} {direction} {irradiance}");
            }
        }
    }
}

#[test]
fn an_integrating_sphere_lights_probes_as_its_walls() {
    let (radius, reflectance, intensity) = (2.0, 0.75f32, 30.0);
    let mut scene = Scene::default();
    add(&mut scene, hollow(radius), matte(reflectance, 0.0), Node::default());
    scene.lights.push(Light { intensity, kind: LightKind::Point, ..Light::default() });
    scene.add_node(None, Node { light: Some(0), ..Node::default() });
    scene.update_transforms();
    for bounces in [0, 1, 3, 16] {
        let probes = bake(&scene, None, &grid(0.8, [2, 1, 1]), ProbeSettings { samples: 1024, bounces });
        // What comes straight from the lamp is the frame's.
        let sum: f32 = (1..=bounces).map(|round| reflectance.powi(round as i32)).sum();
        let expected = intensity / (radius * radius) / PI * sum;
        for direction in directions() {
            let found = probes.probes.as_ref().unwrap()[0].light.irradiance(direction).x;
            assert!((found - expected).abs() <= 0.02 * expected, "{bounces} {direction} {found} {expected}");
        }
    }
}

#[test]
fn baked_lamps_are_in_probes_and_others_are_not() {
    for (mode, expected) in [(LightMode::Baked, 5.0), (LightMode::Mixed, 0.0)] {
        let mut scene = Scene::default();
        add(&mut scene, primitives::plane(0.01), matte(1.0, 0.0), Node::default());
        scene.lights.push(Light { intensity: 5.0, kind: LightKind::Directional, mode, ..Light::default() });
        // It shines straight down.
        let node = Node { rotation: Quat::from_rotation_x(-0.5 * PI), light: Some(0), ..Node::default() };
        scene.add_node(None, node);
        scene.update_transforms();
        let probes = bake(&scene, None, &grid(4.0, [2, 2, 2]), ProbeSettings { samples: 16, bounces: 2 });
        // The mean of irradiance over all normals is a quarter of that across the light.
        let light = probes.probes.as_ref().unwrap()[7].light;
        let mean =
            (0..6).map(|at| light.irradiance([Vec3::X, Vec3::Y, Vec3::Z][at / 2] * (1.0 - 2.0 * (at % 2) as f32)).x);
        let (above, below) = (light.irradiance(Vec3::Y).x, light.irradiance(Vec3::NEG_Y).x);
        assert!((above * PI - expected).abs() <= 0.12 * expected && below <= 0.02 * expected, "{above} {below}");
        assert!((mean.sum::<f32>() / 6.0 * PI - 0.25 * expected).abs() <= 0.1 * expected);
    }
}

/// A closed box of a metre in the middle of white surroundings, and probes in and around it.
#[test]
fn probes_in_walls_move_out_or_are_off() {
    let mut scene = Scene::default();
    add(&mut scene, primitives::cube(Vec3::ONE), matte(0.5, 0.0), Node::default());
    let settings = ProbeSettings { samples: 256, bounces: 1 };
    // Cells of a metre, whose middles lie 10 cm within the box: it takes a probe less than half a cell to come out.
    let shifted = Region { center_world: Vec3::new(0.4, 0.0, 0.0), half_m: Vec3::splat(0.5) };
    let moved = bake(&scene, Some(&Vec3::ONE), &ProbeGrid::new("a", shifted, [1, 1, 1]).unwrap(), settings);
    let probe = &moved.probes.as_ref().unwrap()[0];
    assert!(probe.is_on && probe.offset_m.x > 0.15 && probe.offset_m.x <= 0.451, "{:?}", probe.offset_m);
    assert!((probe.light.irradiance(Vec3::X).x - 1.0).abs() < 0.03, "{}", probe.light.irradiance(Vec3::X).x);
    // In the middle of a box of four metres there is no way out.
    let mut solid = Scene::default();
    add(&mut solid, primitives::cube(Vec3::splat(4.0)), matte(0.5, 0.0), Node::default());
    let off = bake(&solid, Some(&Vec3::ONE), &grid(0.5, [1, 1, 1]), settings);
    assert!(!off.probes.as_ref().unwrap()[0].is_on);
    assert!(off.probes.as_ref().unwrap()[0].light.colors().iter().all(|color| *color == Vec3::ZERO));
}

#[test]
fn distances_are_those_of_walls_and_no_larger_than_what_counts() {
    let mut scene = Scene::default();
    add(&mut scene, hollow(1.0), matte(0.5, 0.0), Node::default());
    let near = bake(&scene, None, &grid(1.0, [1, 1, 1]), ProbeSettings { samples: 2048, bounces: 0 });
    let far = bake(&scene, None, &grid(0.1, [1, 1, 1]), ProbeSettings { samples: 2048, bounces: 0 });
    for distance in near.probes.as_ref().unwrap()[0].distances {
        assert!((distance.x - 1.0).abs() < 0.01 && (distance.y - distance.x * distance.x).abs() < 0.01, "{distance}");
    }
    let most_m = grid(0.1, [1, 1, 1]).distance_max_m();
    assert!(far.probes.as_ref().unwrap()[0].distances.iter().all(|distance| (distance.x - most_m).abs() < 1e-5));
}

#[test]
fn twice_the_same_comes_out_and_wrong_settings_are_refused() {
    let mut scene = Scene::default();
    add(&mut scene, hollow(1.0), matte(0.5, 0.5), Node::default());
    let settings = ProbeSettings { samples: 32, bounces: 2 };
    let grid = grid(0.6, [5, 4, 3]);
    assert_eq!(bake(&scene, None, &grid, settings), bake(&scene, None, &grid, settings));
    let surfaces = Surfaces::new(&scene);
    for (settings, expected) in [
        (ProbeSettings { samples: 0, ..settings }, "0 rays from a probe"),
        (ProbeSettings { samples: 100_000, ..settings }, "100000 rays from a probe"),
        (ProbeSettings { bounces: 65, ..settings }, "65 bounces"),
    ] {
        let error = ProbeBaker::new(&scene, &surfaces, None, vec![grid.clone()], &settings).err().unwrap();
        assert!(error.to_string().contains(expected), "{error}");
    }
}
