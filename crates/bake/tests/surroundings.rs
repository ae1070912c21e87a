//! Pictures of what is to be seen around places.

use crate::common::{add, matte};
use glam::{Quat, Vec3};
use manypass_bake::{Surfaces, SurroundingsBaker, SurroundingsSettings, picture_file};
use manypass_scene::environment::equirectangular_direction;
use manypass_scene::surroundings::{Region, Surroundings};
use manypass_scene::{EnvironmentMap, Light, LightKind, Node, Scene, primitives};
use std::f32::consts::PI;

fn bake(scene: &Scene, place: Vec3, bounces: u32) -> Surroundings {
    let region = Region { center_world: place, half_m: Vec3::ONE };
    let surfaces = Surfaces::new(scene);
    let settings = SurroundingsSettings { samples: 4, bounces };
    let around = Vec3::splat(0.25);
    let places = vec![Surroundings { layers: 1, ..Surroundings::of_room("room", region) }];
    let baker = SurroundingsBaker::new(scene, &surfaces, Some(&around), places, &settings).expect("settings");
    baker.run(&(), &()).expect("it bakes").remove(0)
}

#[test]
fn what_shines_what_is_lit_and_what_is_around_is_seen_where_it_is() {
    let mut scene = Scene::default();
    // A floor below that a lamp lights, and a panel that shines above.
    add(
        &mut scene,
        primitives::plane(8.0),
        matte(0.5, 0.0),
        Node { translation: Vec3::new(0.0, -1.0, 0.0), ..Node::default() },
    );
    let above = Node { translation: Vec3::new(0.0, 3.0, 0.0), rotation: Quat::from_rotation_x(PI), ..Node::default() };
    add(&mut scene, primitives::plane(1.0), matte(0.0, 7.0), above);
    scene.lights.push(Light { intensity: 100.0 * PI, kind: LightKind::Directional, ..Light::default() });
    scene.add_node(None, Node { rotation: Quat::from_rotation_x(-0.5 * PI), light: Some(0), ..Node::default() });
    scene.update_transforms();
    // The place is in something of another layer.
    add(&mut scene, primitives::cube(Vec3::splat(0.2)), matte(0.0, 0.0), Node { layers: 2, ..Node::default() });
    let picture = bake(&scene, Vec3::ZERO, 0).picture.expect("a picture");
    let at = |to: Vec3| {
        let size = (picture.width, picture.height);
        let nearest = (0..picture.width * picture.height).max_by(|a, b| {
            let near = |i: &u32| equirectangular_direction((i % size.0, i / size.0), size).dot(to);
            near(a).total_cmp(&near(b))
        });
        picture.texels[nearest.expect("texels") as usize][0].to_f32()
    };
    assert_eq!(at(Vec3::Y), 7.0);
    assert_eq!(at(Vec3::new(0.6, 0.8, 0.0)), 0.25);
    // 100 of the lamp, times what the floor sends back, and some of the panel and of what is around.
    let floor = at(Vec3::new(0.8, -0.6, 0.0));
    assert!((floor - 50.0).abs() < 0.7, "{floor}");
    // Through a file nothing is lost.
    let file = picture_file(&picture).expect("a file");
    assert_eq!(EnvironmentMap::decode("a", &file).expect("it is read").texels, picture.texels);
}

#[test]
fn a_room_that_shines_has_one_radiance() {
    let mut scene = Scene::default();
    let mut sphere = primitives::uv_sphere(2.0, 48, 24);
    sphere.indices.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
    sphere.normals.iter_mut().flatten().for_each(|part| *part = -*part);
    add(&mut scene, sphere, matte(0.5, 1.0), Node::default());
    let picture = bake(&scene, Vec3::new(0.5, 0.2, 0.0), 2).picture.expect("a picture");
    // What is made, and what was sent back up to three times.
    let expected = 1.0 + 0.5 + 0.25 + 0.125;
    let mean = picture.texels.iter().map(|texel| texel[0].to_f32()).sum::<f32>() / picture.texels.len() as f32;
    assert!((mean / expected - 1.0).abs() < 0.01, "{mean}");
}
