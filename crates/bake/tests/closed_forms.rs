//! Light maps against radiosity's closed forms.

use crate::common::{add, at, bake, matte, mean, settings, texel};
use glam::{Quat, Vec2, Vec3};
use manypass_bake::{BakeSettings, BakedMaps, DistantLight};
use manypass_scene::{Light, LightKind, LightMode, Material, Node, Primitive, Scene, primitives};
use std::f32::consts::PI;

/// A sphere that is seen from inside.
fn hollow(radius_m: f32) -> Primitive {
    let mut sphere = primitives::uv_sphere(radius_m, 96, 48);
    sphere.indices.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
    sphere.normals.iter_mut().flatten().for_each(|part| *part = -*part);
    sphere
}

fn assert_near(found: f32, expected: f32, tolerance: f32) {
    assert!((found / expected - 1.0).abs() <= tolerance, "{found} is not within {tolerance} of {expected}");
}

#[test]
fn light_sums_up_in_a_sphere_that_shines() {
    for (reflectance, bounces) in [(0.5, 0), (0.5, 3), (0.8, 6)] {
        let mut scene = Scene::default();
        add(&mut scene, hollow(1.0), matte(reflectance, 0.7), Node::default());
        let maps = bake(&scene, None, &settings(12.0, 64, bounces));
        let expected = 0.7 * (0..=bounces).map(|round| reflectance.powi(round as i32)).sum::<f32>();
        assert_near(mean(&maps, 0), expected, 0.01);
    }
}

#[test]
fn an_integrating_sphere_has_the_light_of_its_lamp_over_one_less_reflectance() {
    let (radius, reflectance, intensity) = (2.0, 0.75, 30.0);
    let mut scene = Scene::default();
    add(&mut scene, hollow(radius), matte(reflectance, 0.0), Node::default());
    scene.lights.push(Light { intensity, kind: LightKind::Point, mode: LightMode::Baked, ..Light::default() });
    scene.add_node(None, Node { light: Some(0), ..Node::default() });
    scene.update_transforms();
    for bounces in [0, 2, 24] {
        let maps = bake(&scene, None, &settings(6.0, 64, bounces));
        let sum: f32 = (0..=bounces).map(|round| reflectance.powi(round as i32)).sum();
        assert_near(mean(&maps, 0), intensity / (radius * radius) / PI * sum, 0.02);
    }
}

/// Two plates of a metre, `gap_m` apart, facing each other.
fn plates(size_m: f32, gap_m: f32, below: Material, above: Material) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, primitives::plane(size_m), below, Node::default());
    let turned =
        Node { translation: Vec3::new(0.0, gap_m, 0.0), rotation: Quat::from_rotation_x(PI), ..Node::default() };
    add(&mut scene, primitives::plane(size_m), above, turned);
    scene
}

/// The share of what reaches a point that comes from a square of side `size_m` at `gap_m` above it, over its middle
/// (the configuration factor of a differential element to a parallel rectangle, four corners of it).
fn square_factor(size_m: f32, gap_m: f32) -> f32 {
    let x = 0.5 * size_m / gap_m;
    let root = (1.0 + x * x).sqrt();
    4.0 / (2.0 * PI) * (2.0 * x / root * (x / root).atan())
}

#[test]
fn a_plate_lights_the_middle_of_another_one_by_its_form_factor() {
    for (size, gap) in [(1.0, 1.0), (1.0, 0.25), (2.0, 3.0)] {
        let scene = plates(size, gap, matte(0.5, 0.0), matte(0.0, 2.0));
        let maps = bake(&scene, None, &settings(17.0 / size, 1024, 0));
        let of = &maps.layout.unwrapped[0];
        let middle = of.vertices.iter().map(|vertex| vertex.1).sum::<glam::Vec2>() / of.vertices.len() as f32;
        assert_near(at(&maps, of.page, middle), 2.0 * square_factor(size, gap), 0.02);
    }
}

#[test]
fn light_goes_to_and_fro_between_wide_plates() {
    let (of_below, of_above, emission) = (0.6, 0.7, 1.5);
    let scene = plates(400.0, 1.0, matte(of_below, 0.0), matte(of_above, emission));
    let bounces = 5;
    let maps = bake(&scene, None, &settings(0.1, 256, bounces));
    let of = &maps.layout.unwrapped[0];
    let middle = of.vertices.iter().map(|vertex| vertex.1).sum::<glam::Vec2>() / of.vertices.len() as f32;
    // Of wide plates each sees the other alone: what reaches the lower one after two bounces more is as much again times
    // both reflectances.
    let expected = emission * (1.0 + of_below * of_above + (of_below * of_above).powi(2));
    assert_near(at(&maps, of.page, middle), expected, 0.02);
}

#[test]
fn white_surroundings_are_white_on_what_stands_alone() {
    let mut scene = Scene::default();
    add(&mut scene, primitives::uv_sphere(1.0, 48, 24), matte(0.5, 0.0), Node::default());
    let maps = bake(&scene, Some(&Vec3::ONE), &settings(8.0, 64, 2));
    assert_near(mean(&maps, 0), 1.0, 0.01);
}

/// What a bake with directions finds.
fn bake_directional(scene: &Scene, around: Option<&dyn DistantLight>, of: &BakeSettings) -> BakedMaps {
    bake(scene, around, &BakeSettings { directional: true, ..*of })
}

/// The direction at the middle of the first triangle of a surface.
fn direction(maps: &BakedMaps, which: usize) -> Vec3 {
    let of = &maps.layout.unwrapped[which];
    let corners = of.indices[..3].iter().map(|corner| of.vertices[*corner as usize].1);
    maps.direction[texel(maps, of.page, corners.sum::<Vec2>() / 3.0)].into()
}

#[test]
fn even_light_comes_from_along_the_normal_with_two_thirds() {
    let mut scene = Scene::default();
    let tilted = Quat::from_rotation_z(0.4) * Quat::from_rotation_x(-0.9);
    add(&mut scene, primitives::plane(1.0), matte(0.5, 0.0), Node { rotation: tilted, ..Node::default() });
    let maps = bake_directional(&scene, Some(&Vec3::ONE), &settings(4.0, 1024, 0));
    let (normal, found) = (tilted * Vec3::Y, direction(&maps, 0));
    // The integral of cosine squared over that of the cosine.
    assert_near(found.length(), 2.0 / 3.0, 0.01);
    assert!(found.normalize().dot(normal) > 0.9999, "{found} is not along {normal}");
    // Inside a sphere all light has come to and fro, and each bounce is as even as the first. Where noise is taken out, means
    // of neighbours whose normals differ are shorter.
    let mut scene = Scene::default();
    add(&mut scene, hollow(1.0), matte(0.8, 0.7), Node::default());
    let noisy = BakeSettings { denoise: false, ..settings(12.0, 256, 4) };
    let maps = bake_directional(&scene, None, &noisy);
    let mut lengths: Vec<f32> =
        maps.direction.iter().map(|of| Vec3::from(*of).length()).filter(|length| *length > 0.0).collect();
    lengths.sort_by(f32::total_cmp);
    assert_near(lengths[lengths.len() / 2], 2.0 / 3.0, 0.01);
    assert!(lengths.iter().all(|length| *length <= 1.0 + 1e-6));
}

#[test]
fn light_of_what_is_small_comes_from_there() {
    let to_light = Vec3::new(0.5, 0.7, -0.3).normalize();
    let floor = || {
        let mut scene = Scene::default();
        add(&mut scene, primitives::plane(0.5), matte(0.5, 0.0), Node::default());
        scene
    };
    // A surface that shines, of 2 degrees.
    let mut shining = floor();
    let facing =
        Node { translation: 30.0 * to_light, rotation: Quat::from_rotation_arc(Vec3::Y, -to_light), ..Node::default() };
    add(&mut shining, primitives::plane(1.0), matte(0.0, 100.0), facing);
    // A lamp that maps hold.
    let mut lit = floor();
    let kind = LightKind::Directional;
    lit.lights.push(Light { intensity: 3.0, kind, mode: LightMode::Baked, ..Light::default() });
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, -to_light);
    lit.add_node(None, Node { light: Some(0), rotation, ..Node::default() });
    lit.update_transforms();
    for scene in [shining, lit] {
        let maps = bake_directional(&scene, None, &settings(8.0, 256, 0));
        let found = direction(&maps, 0);
        assert!((0.999..=1.0).contains(&found.length()), "{}", found.length());
        assert!(found.normalize().dot(to_light) > 0.9998, "{found} is not along {to_light}");
    }
    // Of two lamps each counts as much as it adds to irradiance.
    let mut both = floor();
    let directions = [(Vec3::new(0.8, 0.6, 0.0), 2.0), (Vec3::new(0.0, 0.8, 0.6), 5.0)];
    for (index, (to_light, intensity)) in directions.into_iter().enumerate() {
        both.lights.push(Light { intensity, kind, mode: LightMode::Baked, ..Light::default() });
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, -to_light);
        both.add_node(None, Node { light: Some(index), rotation, ..Node::default() });
    }
    both.update_transforms();
    let moment: Vec3 = directions.iter().map(|(to_light, intensity)| *to_light * (intensity * to_light.y)).sum();
    let expected = moment / directions.iter().map(|(to_light, intensity)| intensity * to_light.y).sum::<f32>();
    let found = direction(&bake_directional(&both, None, &settings(8.0, 16, 0)), 0);
    assert!(found.distance(expected) < 1e-3, "{found} is not {expected}");
}
