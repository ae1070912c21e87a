//! Spots are in the lists of the clusters that their cones touch, not of all that their ranges reach.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::{LightCulling, PairCounts, Renderer};
use manypass_scene::{LightKind, Scene};
use manypass_testkit::scenes;

const SIZE: (u32, u32) = (96, 72);

/// The scene's lights as cones of this half angle that look in all directions.
fn with_spots(mut scene: Scene, outer_cone_rad: f32) -> Scene {
    let inner_cone_rad = 0.5 * outer_cone_rad;
    scene.lights.iter_mut().for_each(|light| light.kind = LightKind::Spot { inner_cone_rad, outer_cone_rad });
    let nodes = scene.nodes.iter_mut().filter(|node| node.light.is_some());
    for (node, i) in nodes.zip(0u16..) {
        let turn = Quat::from_rotation_y(2.4 * f32::from(i));
        let direction = turn * Vec3::new(0.8, if i % 2 == 0 { -0.9 } else { 0.2 }, 0.0).normalize();
        node.rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
        // At several heights, so that the floor cuts cones at their tips and at their ends.
        node.translation.y += 0.3 * f32::from(i % 3);
    }
    scene.update_transforms();
    scene
}

/// Radiance, and pairs of pixel and light.
fn shot(renderer: &mut Renderer, scene: &Scene, light_culling: LightCulling) -> (Vec<f32>, PairCounts) {
    let mut request = plain_request(scene, SIZE);
    request.settings.lights.culling = light_culling;
    renderer.render(scene, &request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    (radiance, renderer.count_pairs(scene, &request).unwrap())
}

#[test]
fn narrow_spots_are_visited_by_fewer_pixels_and_shade_the_same() {
    let points = scenes::many_points(300).scene;
    let mut renderer = renderer();
    let mut visited_by_angle = Vec::new();
    for angle_deg in [10.0f32, 30.0, 44.0, 46.0, 60.0, 80.0, 90.0] {
        let scene = with_spots(points.clone(), angle_deg.to_radians());
        renderer.load(&scene).unwrap();
        let (lists, pairs) = shot(&mut renderer, &scene, LightCulling::Clustered);
        let (all, all_pairs) = shot(&mut renderer, &scene, LightCulling::None);
        println!("{angle_deg}°: {pairs:?}, without lists {all_pairs:?}");
        assert!(lists == all, "{angle_deg}°: a light is missing");
        assert!(pairs.pairs_shaded > 500, "{angle_deg}°: all is dark");
        assert_eq!((pairs.pairs_shaded, pairs.pairs_in_range), (all_pairs.pairs_shaded, all_pairs.pairs_in_range));
        visited_by_angle.push(pairs.pairs_visited);
    }
    let [ten, thirty, .., ninety] = visited_by_angle[..] else { panic!() };
    assert!(visited_by_angle.is_sorted(), "{visited_by_angle:?}");
    assert!(7 * ten < ninety && 3 * thirty < ninety, "{visited_by_angle:?}");
}
