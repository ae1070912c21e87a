//! Shadows against what is known of them.

use super::super::*;
use crate::build::{SceneBuilder, at, grey};
use crate::scenes;
use crate::shadow_edges::{share_of_disc_beside, visibility_beside_edge};
use glam::Vec3;
use manypass_scene::{AlphaMode, LightKind, Material, Node, Projection, Scene, primitives};

const PROJECTION: Projection = Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 100.0 };

fn from_above() -> SceneBuilder {
    SceneBuilder::new(10.0 * Vec3::Y, Vec3::ZERO, PROJECTION)
}

fn world_of(scene: &Scene) -> World {
    World::of_scene(scene, Camera::of_scene(scene).unwrap())
}

fn lamp(kind: LightKind, radius_m: f32) -> manypass_scene::Light {
    manypass_scene::Light { kind, radius_m, ..Default::default() }
}

#[test]
fn meshes_throw_the_shadows_of_their_shapes() {
    let test = scenes::sun();
    let world = world_of(&test.scene);
    let mut shadowed = 0;
    for i in 0..40 {
        for j in 0..40 {
            let place = DVec3::new(f64::from(i) / 10.0 - 2.0, 0.0, f64::from(j) / 10.0 - 2.0);
            let exact = test.world.visibility_at(0, place, Options::default());
            let to_light = -test.world.lights[0].direction_world;
            let near_rim = test.world.objects.iter().any(|object| match object.shape {
                Shape::Sphere { center_world, radius_m } => {
                    (to_light.cross(center_world - place).length() - radius_m).abs() < 2e-3
                }
                Shape::Quad { .. } => false,
            });
            assert!(near_rim || world.visibility_at(0, place, Options::default()) == exact, "{place}");
            shadowed += usize::from(exact == 0.0);
        }
    }
    assert!(shadowed > 60, "{shadowed}");
}

#[test]
fn a_plane_is_lit_by_itself_from_any_angle() {
    for angle_deg in [0.01_f32, 0.5, 2.0, 45.0, 88.0] {
        let mut builder = from_above();
        builder.put(
            primitives::plane(8.0),
            grey(0.5),
            Node { rotation: glam::Quat::from_rotation_y(0.3), ..at(Vec3::Y * 0.1) },
        );
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        builder.light(lamp(LightKind::Directional, 0.0), Vec3::ZERO, Vec3::new(-cos, -sin, 0.1 * cos));
        let world = world_of(&builder.finish());
        let lit = world.render(16, 16, Options::default()).radiance;
        assert_eq!(world.render(16, 16, Options { shadows: true, ..Options::default() }).radiance, lit, "{angle_deg}");
        assert!(lit.iter().all(|pixel| pixel[0] > 0.0));
    }
}

/// The middle of a plane below a quad of a material with a lamp above; the share of its light that is left.
fn left_below(quad: Material, node: Node, change: impl FnOnce(&mut Scene)) -> f64 {
    let mut builder = from_above();
    builder.put(primitives::plane(4.0), grey(0.5), at(Vec3::ZERO));
    builder.put(primitives::plane(1.0), quad, Node { translation: Vec3::Y, ..node });
    builder.light(lamp(LightKind::Point, 0.0), Vec3::Y * 3.0, Vec3::NEG_Y);
    change(&mut builder.scene);
    let world = world_of(&builder.finish());
    world.visibility_at(0, DVec3::ZERO, Options::default())
}

#[test]
fn alpha_and_opting_out_let_light_through() {
    let turned = || Node { rotation: glam::Quat::from_rotation_x(3.0), ..Node::default() };
    let blended = |alpha: f32| Material {
        alpha_mode: AlphaMode::Blend,
        base_color_factor: glam::Vec4::new(1.0, 1.0, 1.0, alpha),
        ..Material::default()
    };
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found} against {expected}");
    near(left_below(grey(0.5), Node::default(), |_| {}), 0.0);
    near(left_below(grey(0.5), turned(), |_| {}), 1.0);
    near(left_below(Material { double_sided: true, ..grey(0.5) }, turned(), |_| {}), 0.0);
    near(left_below(blended(0.3), Node::default(), |_| {}), 0.7);
    near(left_below(blended(0.3), turned(), |_| {}), 1.0);
    near(left_below(Material { double_sided: true, ..blended(0.3) }, turned(), |_| {}), 0.7);
    for (alpha, left) in [(0.4, 1.0), (0.6, 0.0)] {
        let masked = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..blended(alpha) };
        near(left_below(masked, Node::default(), |_| {}), left);
    }
    near(left_below(grey(0.5), Node { casts_shadow: false, ..Node::default() }, |_| {}), 1.0);
    near(left_below(Material { casts_shadow: false, ..grey(0.5) }, Node::default(), |_| {}), 1.0);
    near(left_below(grey(0.5), Node::default(), |scene| scene.lights[0].casts_shadows = false), 1.0);
    // A closed pane weakens light once, as it does what is seen through it.
    near(
        left_below(blended(0.3), Node::default(), |scene| {
            scene.meshes[1] = manypass_scene::Mesh {
                primitives: vec![manypass_scene::Primitive { material: Some(1), ..primitives::cube(Vec3::splat(0.2)) }],
                ..Default::default()
            }
            .into();
        }),
        0.7,
    );
}

#[test]
fn what_glows_around_a_light_is_no_caster_for_it_and_for_it_alone() {
    for (emission, left) in [(0.0, 0.0), (1.0, 1.0)] {
        let mut builder = from_above();
        builder.put(primitives::plane(4.0), grey(0.5), at(Vec3::ZERO));
        let bulb = Material { emissive_factor: Vec3::splat(emission), ..grey(0.0) };
        builder.put(primitives::uv_sphere(0.1, 16, 8), bulb, at(Vec3::Y));
        builder.light(lamp(LightKind::Point, 0.0), Vec3::Y, Vec3::NEG_Y);
        builder.light(lamp(LightKind::Point, 0.0), Vec3::Y * 2.0, Vec3::NEG_Y);
        let world = world_of(&builder.finish());
        assert_eq!(world.visibility_at(0, DVec3::ZERO, Options::default()), left, "emission {emission}");
        assert_eq!(world.visibility_at(1, DVec3::ZERO, Options::default()), 0.0, "emission {emission}");
    }
}

/// A wall from x = 0 to the left, at a height of 1 m over the plane, seen by its edge.
fn below_an_edge(light: manypass_scene::Light, place: Vec3) -> World {
    let mut builder = from_above();
    builder.put(primitives::plane(40.0), grey(0.5), at(Vec3::ZERO));
    builder.put(primitives::plane(40.0), grey(0.5), at(Vec3::new(-20.0, 1.0, 0.0)));
    builder.light(light, place, Vec3::NEG_Y);
    world_of(&builder.finish())
}

#[test]
fn penumbrae_are_as_wide_and_as_dark_as_the_source_asks() {
    let options = Options { light_samples_per_axis: 40, ..Options::default() };
    // 40² cells miss the area of a disc that an edge cuts by less than a half of 1/40.
    let close = |found: f64, expected: f64, place: f64| {
        assert!((found - expected).abs() < 0.006, "at {place}: {found} against {expected}");
    };
    let sun = below_an_edge(lamp(LightKind::Directional, 0.05), Vec3::ZERO);
    let bulb = below_an_edge(lamp(LightKind::Point, 0.1), Vec3::Y * 3.0);
    for step in -12..=12 {
        let x = 0.01 * f64::from(step);
        let place = DVec3::new(x, 0.0, 0.3);
        // The source's disc has a radius of 0.05 at a distance of 1; its middle stands x beside the edge.
        close(sun.visibility_at(0, place, options), share_of_disc_beside(x / 0.05), x);
        // Through the edge, 1 m above the floor, the source of 0.1 m is seen 3 m above it.
        close(bulb.visibility_at(0, place, options), visibility_beside_edge(x, 0.1, 1.0, 2.0), x);
    }
    let hard = Options { light_samples_per_axis: 0, ..options };
    assert_eq!([-0.001, 0.001].map(|x| bulb.visibility_at(0, DVec3::X * x, hard)), [0.0, 1.0]);
}
