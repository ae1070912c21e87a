//! Shadows against the ray caster, pixel by pixel.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::inner_pixels;
use crate::common::shadows::{
    ATLAS_PX, SIZE, SPOT, light, perspective, radiance, request, shared, shares, surfaces, unshadowed, world_of,
};
use glam::{DVec3, Quat, Vec3};
use manypass::FrameRequest;
use manypass_scene::{AlphaMode, Light, LightKind, Material, Node, Primitive, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::raycast::{Emission, Options, World};

/// A texel of a shadow map where it falls on a place: the axis along which the map looks, and the texel's side there.
type TexelAt<'t> = &'t dyn Fn(DVec3) -> (DVec3, f64);

/// Texels of the only light, of a map with so many to a side; `parallel_m` is half the side of a parallel map.
fn texel_at(world: &World, parallel_m: f64) -> impl Fn(DVec3) -> (DVec3, f64) {
    let light = world.lights[0].clone();
    // Four texels on each side are border.
    let texel = |side: f64| 2.0 / (side - 8.0);
    move |position: DVec3| {
        let away = position - light.position_world;
        match light.emission {
            Emission::Directional => {
                let side = f64::from((2 * SIZE.0.next_power_of_two()).min(ATLAS_PX / 2));
                (light.direction_world, parallel_m * texel(side))
            }
            Emission::Spot { outer_cone_rad, .. } => {
                let axis = light.direction_world;
                (axis, outer_cone_rad.tan() * away.dot(axis) * texel(f64::from(ATLAS_PX / 4)))
            }
            Emission::Point => {
                let greatest = away.abs().max_element();
                let axis = if away.x.abs() == greatest {
                    DVec3::X * away.x.signum()
                } else if away.y.abs() == greatest {
                    DVec3::Y * away.y.signum()
                } else {
                    DVec3::Z * away.z.signum()
                };
                (axis, greatest * texel(f64::from(ATLAS_PX / 8)))
            }
        }
    }
}

/// What [`compare_edges`] found.
#[derive(Debug, Default)]
struct Edges {
    compared: usize,
    in_shadow: usize,
    /// Pixels that are lit where the ray caster has shadow within so many texels all around, or the other way round.
    wrong: Vec<(usize, usize, f32)>,
}

/// Compares whether pixels are lit with the ray caster. One that differs has to lie within `texels` of an exact edge:
/// within that distance in the plane of the map, the ray caster has both light and shadow.
fn compare_edges(world: &World, found: &[Option<f32>], texel_at: TexelAt, texels: f64) -> Edges {
    let frame = surfaces(world);
    let size = (frame.width, frame.height);
    let hard = Options { light_samples_per_axis: 0, ..Options::default() };
    let is_lit = |position: DVec3| world.visibility_at(0, position, hard) > 0.5;
    let mut edges = Edges::default();
    for pixel in inner_pixels(&frame.object_id, size) {
        let (position, normal) = (frame.position_world[pixel], frame.normal_world[pixel]);
        let (to_light, ..) = world.lights[0].arriving_at(position);
        let Some(share) = found[pixel] else { continue };
        if frame.object_id[pixel] == 0 || normal.dot(to_light) < 0.03 {
            continue;
        }
        let expected = is_lit(position);
        edges.compared += 1;
        edges.in_shadow += usize::from(!expected);
        if (share > 0.5) == expected {
            continue;
        }
        let (axis, texel_m) = texel_at(position);
        let (u, v) = axis.any_orthonormal_pair();
        let is_edge_near = (1..=8).flat_map(|ring| (0..32).map(move |turn| (ring, turn))).any(|(ring, turn)| {
            let (sin, cos) = (f64::from(turn) * std::f64::consts::TAU / 32.0).sin_cos();
            let offset = (u * cos + v * sin) * (texel_m * texels * f64::from(ring) / 8.0);
            // Along the light's ray back to the surface.
            let slide = offset.dot(normal) / to_light.dot(normal);
            is_lit(position + offset - to_light * slide) != expected
        });
        if !is_edge_near {
            edges.wrong.push((pixel % size.0, pixel / size.0, share));
        }
    }
    edges
}

fn assert_edges(name: &str, scene: &Scene, parallel_m: f64, texels: f64) {
    let world = world_of(scene);
    assert_edges_by_texels(name, scene, &world, &texel_at(&world, parallel_m), texels);
}

fn assert_edges_by_texels(name: &str, scene: &Scene, world: &World, texel_at: TexelAt, texels: f64) {
    let found = shares(scene, &request(scene), 1);
    let edges = compare_edges(world, &found, texel_at, texels);
    println!(
        "{name}: {} pixels, {} in shadow, {} wrong: {:?}",
        edges.compared,
        edges.in_shadow,
        edges.wrong.len(),
        &edges.wrong[..edges.wrong.len().min(12)]
    );
    assert!(edges.compared > 4000 && edges.in_shadow > 200, "{name}: nothing to look at");
    // None on software; adapters may take a pixel where two faces meet to lie on either.
    assert!(edges.wrong.len() <= 2, "{name}: {} pixels", edges.wrong.len());
    // The test can fail: the picture moved by twelve pixels has edges elsewhere.
    let moved: Vec<_> = (0..found.len()).map(|pixel| found[(pixel + 12) % found.len()]).collect();
    let edges = compare_edges(world, &moved, texel_at, texels);
    assert!(edges.wrong.len() > 20, "{name}: {} wrong pixels where all are moved", edges.wrong.len());
}

/// A box, a ring and a ball over a floor before a wall, under one light.
fn still_life(lamp: Light, place: Vec3, direction: Vec3) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(1.0, 3.0, 6.0), Vec3::new(0.0, 0.6, 0.0), perspective());
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    let upright =
        Node { rotation: Quat::from_rotation_x(std::f32::consts::FRAC_PI_2), ..at(Vec3::new(0.0, 4.0, -4.0)) };
    builder.put(primitives::plane(8.0), grey(0.5), upright);
    let turned = Node { rotation: Quat::from_rotation_y(0.5), ..at(Vec3::new(-1.2, 0.4, 0.4)) };
    builder.put(primitives::cube(Vec3::new(0.6, 0.8, 0.6)), grey(0.5), turned);
    let tilted = Node { rotation: Quat::from_rotation_x(0.9), ..at(Vec3::new(0.3, 0.9, -0.8)) };
    builder.put(primitives::torus(0.5, 0.15, 96, 48), grey(0.5), tilted);
    builder.put(primitives::uv_sphere(0.4, 192, 96), grey(0.5), at(Vec3::new(1.3, 0.7, 0.6)));
    builder.light(lamp, place, direction);
    builder.finish()
}

#[test]
fn a_plane_is_lit_by_itself_from_any_angle() {
    for kind in [LightKind::Directional, LightKind::Point, SPOT] {
        for angle_deg in [2.0_f32, 4.0, 8.0, 20.0, 45.0, 70.0, 88.0] {
            let mut builder = SceneBuilder::new(Vec3::new(0.0, 3.0, 5.0), Vec3::ZERO, perspective());
            builder.put(
                primitives::plane(6.0),
                grey(0.5),
                Node { rotation: Quat::from_rotation_y(0.4), ..at(Vec3::ZERO) },
            );
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let to_light = Vec3::new(0.8 * cos, sin, 0.6 * cos);
            builder.light(light(kind, 100.0), 5.0 * to_light, -to_light);
            let scene = builder.finish();
            let world = world_of(&scene);
            let frame = surfaces(&world);
            let found = shares(&scene, &request(&scene), 1);
            let (mut count, mut darkest) = (0, f32::MAX);
            for pixel in inner_pixels(&frame.object_id, (frame.width, frame.height)) {
                let on_plane = frame.position_world[pixel];
                let (to_light, ..) = world.lights[0].arriving_at(on_plane);
                let is_asked = (1.99..=88.01).contains(&to_light.y.asin().to_degrees());
                if frame.object_id[pixel] != 2 || !is_asked {
                    continue;
                }
                let Some(share) = found[pixel] else { continue };
                count += 1;
                darkest = darkest.min(share);
            }
            println!("{kind:?} at {angle_deg}°: {count} pixels, at least {darkest} lit");
            assert!(count > 300 && darkest >= 0.99, "{kind:?} at {angle_deg}°: {darkest} of {count}");
        }
    }
}

/// Of the pixels of a ball over a floor, around `middle`, how much of the light each gets.
fn ball_around(middle: Vec3) -> Vec<Option<f32>> {
    let mut builder = SceneBuilder::new(middle + Vec3::new(0.0, 3.0, 5.0), middle, perspective());
    builder.put(primitives::plane(6.0), grey(0.5), at(middle));
    builder.put(primitives::uv_sphere(0.8, 96, 48), grey(0.5), at(middle + Vec3::new(0.0, 1.0, 0.0)));
    let down = Vec3::new(-0.6, -0.7, 0.3).normalize();
    builder.light(light(LightKind::Directional, 100.0), middle - 5.0 * down, down);
    let scene = builder.finish();
    shares(&scene, &request(&scene), 1)
}

#[test]
fn positions_that_are_rounded_far_from_the_origin_do_not_shadow_themselves() {
    let near = ball_around(Vec3::ZERO);
    let shadowed = near.iter().flatten().filter(|share| **share < 0.5).count();
    // There floats are 1/64 m apart.
    let far = ball_around(Vec3::new(131_072.0, 0.0, -196_608.0));
    let pairs: Vec<_> = near.iter().zip(&far).filter_map(|(near, far)| Some(((*near)?, (*far)?))).collect();
    let differing = pairs.iter().filter(|(near, far)| (near - far).abs() > 0.2).count();
    println!("{} pixels, {shadowed} in shadow, {differing} differ", pairs.len());
    // What differs is the edge of the shadow, which moves.
    assert!(shadowed > 800 && differing < shadowed / 4, "{differing} differ, {shadowed} in shadow");
}

#[test]
fn edges_lie_where_the_ray_caster_says() {
    let scene = still_life(light(LightKind::Directional, 3.0), Vec3::ZERO, Vec3::new(-1.0, -0.9, -0.3));
    let bounds = scene.posed_bounds_world();
    // No cascade is larger than the scene.
    assert_edges("directional", &scene, f64::from(bounds.radius_m()), 1.5);
    let place = Vec3::new(4.0, 3.5, 2.0);
    assert_edges("spot", &still_life(light(SPOT, 60.0), place, Vec3::new(0.0, 0.4, -0.3) - place), 0.0, 1.5);
    // From within, so that shadows lie across the borders of the cube's faces.
    let place = Vec3::new(-0.2, 1.6, 0.6);
    assert_edges("point", &still_life(light(LightKind::Point, 10.0), place, Vec3::NEG_Y), 0.0, 1.5);
}

#[test]
fn a_light_that_is_shaded_without_loops_is_the_same_as_among_others() {
    let sun = light(LightKind::Directional, 3.0);
    let direction = Vec3::new(-1.0, -0.9, -0.3);
    let picture = |lights: u32, samples: u32, cascades: u32| {
        let mut builder = SceneBuilder::new(Vec3::new(0.0, 3.0, 5.0), Vec3::ZERO, perspective());
        builder.put(primitives::plane(6.0), grey(0.5), at(Vec3::ZERO));
        builder.put(primitives::uv_sphere(0.8, 96, 48), grey(0.5), at(Vec3::new(0.0, 1.0, 0.0)));
        builder.light(sun.clone(), Vec3::ZERO, direction);
        // So weak that nothing is added to any half float, and yet a light.
        for _ in 1..lights {
            builder.light(Light { intensity: 1e-20, casts_shadows: false, ..sun.clone() }, Vec3::ZERO, direction);
        }
        let scene = builder.finish();
        let mut renderer = shared();
        renderer.unload();
        let request = request(&scene).with(|settings| settings.shadows.cascades = cascades);
        radiance(&mut renderer, &scene, &request, samples)
    };
    for samples in [1, 4] {
        let (alone, among) = (picture(1, samples, 4), picture(2, samples, 4));
        let brightest = alone.iter().flatten().copied().fold(0.0, f32::max);
        let shadowed = alone.iter().filter(|pixel| pixel[1] < 0.05 * brightest).count();
        assert!(brightest > 0.3 && shadowed > 300, "{brightest}, {shadowed}");
        let most = alone.iter().flatten().zip(among.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most <= 2e-3 * brightest, "{most} of {brightest} at {samples} samples");
    }
    // Of one sample each cascade is looked for; of several, the only one is known: they differ at edges, where samples
    // lie elsewhere.
    let (each, only) = (picture(1, 1, 1), picture(1, 4, 1));
    let brightest = each.iter().flatten().copied().fold(0.0, f32::max);
    let unlike = each.iter().zip(&only).filter(|(each, only)| (each[1] - only[1]).abs() > 0.2 * brightest).count();
    let shadowed = only.iter().filter(|pixel| pixel[1] < 0.05 * brightest).count();
    println!("{unlike} of {} pixels differ, {shadowed} are in shadow", each.len());
    assert!(unlike < each.len() / 50 && shadowed > 300, "{unlike} differ, {shadowed} in shadow");
}

/// The texels of a directional light's cascades: each ends four times as far away as it begins, and the first
/// begins before the nearest surface, which is the ground at y = 0 under the eye. Each is a square around the sphere that its part of the view has. Where one ends it goes
/// over into the next, which is coarser.
fn cascade_texel_at(scene: &Scene, world: &World) -> impl Fn(DVec3) -> (DVec3, f64) {
    let bounds = scene.posed_bounds_world();
    let direction = world.lights[0].direction_world;
    let eye = world.camera.position_world;
    let forward = world.camera.world_from_view * DVec3::NEG_Z;
    let far_m = eye.distance(bounds.center().as_dvec3()) + f64::from(bounds.radius_m());
    let far_m = ((2.0 * far_m.log2()).ceil() * 0.5).exp2();
    let corner = 0.4f64.tan() * f64::from(SIZE.0).hypot(f64::from(SIZE.1)) / f64::from(SIZE.1);
    let near_m = eye.y / (1.0 + corner * corner).sqrt();
    assert!(far_m / near_m < 4f64.powi(8), "{near_m} {far_m} are more cascades");
    let count = (far_m / near_m).log(4.0).ceil() as i32;
    let spheres = Vec::from_iter((0..count).map(|index| {
        let [near_m, end_m] = [index, index + 1].map(|at| far_m * 4f64.powi(at - count));
        let middle_m = (0.5 * (near_m + end_m) * (1.0 + corner * corner)).min(end_m);
        let radius_m = (end_m - middle_m).hypot(corner * end_m);
        (end_m, middle_m, radius_m.min(bounds.radius_m().into()))
    }));
    move |position: DVec3| {
        let depth_m = (position - eye).dot(forward);
        let at = spheres.iter().position(|(end_m, ..)| depth_m < *end_m).unwrap_or(spheres.len() - 1);
        let (_, middle_m, radius_m) = spheres[at];
        let is_near_seam = position.distance(eye + middle_m * forward) > 0.9 * radius_m;
        let (.., radius_m) = spheres[(at + usize::from(is_near_seam)).min(spheres.len() - 1)];
        // Three texels on each side are border.
        (direction, 2.0 * radius_m / (f64::from(ATLAS_PX / 2) - 6.0))
    }
}

#[test]
fn edges_lie_where_the_ray_caster_says_across_the_seams_of_cascades() {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 2.5, 3.0), Vec3::new(0.0, 0.0, -10.0), perspective());
    builder.put(primitives::plane(100.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..24_u8 {
        let (side, away_m) = (if i % 2 == 0 { 1.0 } else { -1.0 }, 0.5 * f32::from(i).powf(1.4));
        let turned = Node {
            rotation: Quat::from_rotation_y(0.3 * f32::from(i)),
            ..at(Vec3::new(side * (1.0 + 0.2 * away_m), 1.0, -away_m))
        };
        builder.put(primitives::cube(Vec3::new(0.4, 2.0, 0.4)), grey(0.5), turned);
    }
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, Vec3::new(-1.0, -0.9, -0.3));
    let scene = builder.finish();
    let world = world_of(&scene);
    assert_edges_by_texels("cascades", &scene, &world, &cascade_texel_at(&scene, &world), 1.5);
}

/// A plane with a hole in it, whose edges a texture draws; a morphed box and one bent by joints.
fn odd_casters(lamp: Light, place: Vec3) -> Scene {
    use manypass_scene::{Image, ImageSource, MorphTarget, PixelFormat, Pixels, Sampler, Skin, Texture, TextureRef};
    let mut builder = SceneBuilder::new(Vec3::new(0.6, 2.4, 4.0), Vec3::new(0.2, 0.5, 0.0), perspective());
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    let checks = (0..16_u8).flat_map(|i| [255, 255, 255, if (i % 4 + i / 4) % 2 == 0 { 255 } else { 0 }]);
    let pixels = Pixels { width: 4, height: 4, format: PixelFormat::Rgba8, data: checks.collect() };
    builder.scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
    let sampler = Sampler { mag_linear: false, min_linear: false, mip_linear: None, ..Sampler::default() };
    builder.scene.textures.push(Texture { image: 0, sampler });
    let masked = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        base_color_texture: Some(TextureRef { texture: 0, uv_set: 0, transform: Default::default() }),
        double_sided: true,
        ..grey(0.5)
    };
    let tilted = Node { rotation: Quat::from_rotation_x(0.3), ..at(Vec3::new(-1.2, 1.0, 0.0)) };
    builder.put(primitives::plane(1.4), masked, tilted);
    // Seen from the light it shows its back.
    let turned_over = Node { rotation: Quat::from_rotation_z(2.9), ..at(Vec3::new(0.2, 0.9, -1.4)) };
    builder.put(primitives::plane(0.8), Material { double_sided: true, ..grey(0.5) }, turned_over);
    let mut morphed = primitives::cube(Vec3::splat(0.4));
    let up = |position: &[f32; 3]| if position[1] > 0.0 { [0.6, 1.0, 0.0] } else { [0.0; 3] };
    let positions = morphed.positions.iter().map(up).collect();
    morphed.morph_targets.push(MorphTarget { positions, ..MorphTarget::default() });
    builder.put(morphed, grey(0.5), Node { morph_weights: vec![0.7], ..at(Vec3::new(0.3, 0.4, 0.8)) });
    let mut bent: Primitive = primitives::cube(Vec3::new(0.2, 1.2, 0.2));
    bent.joints = vec![[0, 1, 0, 0]; bent.positions.len()];
    let shares = |position: &[f32; 3]| if position[1] > 0.0 { [0.0, 1.0, 0.0, 0.0] } else { [1.0, 0.0, 0.0, 0.0] };
    bent.weights = bent.positions.iter().map(shares).collect();
    let id = builder.put(bent, grey(0.5), at(Vec3::new(9.0, 9.0, 9.0)));
    let rotation = Quat::from_rotation_z(0.5);
    let joints = vec![
        builder.scene.add_node(None, at(Vec3::new(1.6, 0.7, 0.0))),
        builder.scene.add_node(None, Node { rotation, ..at(Vec3::new(1.6, 0.9, 0.0)) }),
    ];
    builder.scene.skins.push(Skin { joints, ..Skin::default() });
    builder.scene.node_mut(id).skin = Some(0);
    builder.light(lamp, place, -place);
    builder.finish()
}

#[test]
fn masked_double_sided_skinned_and_morphed_surfaces_cast_their_shadows() {
    let place = Vec3::new(1.2, 5.0, 2.0);
    let scene = odd_casters(light(LightKind::Directional, 3.0), place);
    assert_edges("directional", &scene, f64::from(scene.posed_bounds_world().radius_m()), 1.5);
    assert_edges("spot", &odd_casters(light(SPOT, 60.0), place), 0.0, 1.5);
    assert_edges("point", &odd_casters(light(LightKind::Point, 60.0), place), 0.0, 1.5);
}

#[test]
fn shadows_begin_at_the_foot() {
    let foot = |lamp: Light, place: Vec3| {
        let mut builder = SceneBuilder::new(Vec3::new(-2.0, 2.0, 1.5), Vec3::new(-0.3, 0.0, 0.0), perspective());
        builder.put(primitives::plane(6.0), grey(0.5), at(Vec3::ZERO));
        builder.put(primitives::cube(Vec3::new(0.5, 1.0, 1.5)), grey(0.5), at(Vec3::Y * 0.5));
        builder.light(lamp, place, -place);
        builder.finish()
    };
    let place = Vec3::new(3.0, 3.5, 0.4);
    let scene = foot(light(LightKind::Directional, 3.0), place);
    assert_edges("directional", &scene, f64::from(scene.posed_bounds_world().radius_m()), 2.0);
    assert_edges("spot", &foot(light(SPOT, 60.0), place), 0.0, 2.0);
    assert_edges("point", &foot(light(LightKind::Point, 60.0), place), 0.0, 2.0);
}

#[test]
fn what_opts_out_and_what_glows_around_the_light_casts_nothing() {
    let scene = |change: fn(&mut SceneBuilder)| {
        let mut builder = SceneBuilder::new(Vec3::new(0.0, 5.0, 4.0), Vec3::ZERO, perspective());
        builder.put(primitives::plane(6.0), grey(0.5), at(Vec3::ZERO));
        builder.put(primitives::uv_sphere(0.5, 48, 24), grey(0.5), at(Vec3::Y));
        builder.light(light(LightKind::Point, 20.0), Vec3::Y * 3.0, Vec3::NEG_Y);
        change(&mut builder);
        builder.finish()
    };
    type Change = (&'static str, fn(&mut SceneBuilder), bool);
    let changes: [Change; 8] = [
        ("all of them cast", |_| (), true),
        ("the node does not", |builder| builder.scene.nodes[2].casts_shadow = false, false),
        ("the material does not", |builder| builder.scene.materials[1].casts_shadow = false, false),
        ("the light does not", |builder| builder.scene.lights[0].casts_shadows = false, false),
        ("what glows elsewhere does", |builder| builder.scene.materials[1].emissive_factor = Vec3::ONE, true),
        ("what encloses it does", |builder| builder.scene.nodes[2].translation.y = 3.0, true),
        (
            "what glows around it does not",
            |builder| {
                builder.scene.materials[1].emissive_factor = Vec3::ONE;
                builder.scene.nodes[2].translation.y = 3.0;
            },
            false,
        ),
        (
            "what glows around it does not where it is smaller than the light",
            |builder| {
                builder.scene.materials[1].emissive_factor = Vec3::ONE;
                builder.scene.nodes[2].translation.y = 3.0;
                builder.scene.lights[0].radius_m = 1.5;
            },
            false,
        ),
    ];
    // With several the light shines from other points than its middle, and a shadow of any of them counts.
    let has_size = |scene: &Scene| scene.lights[0].radius_m > 0.0;
    for (name, change, casts) in changes {
        let scene = scene(change);
        let world = world_of(&scene);
        let (frame, found) = (surfaces(&world), shares(&scene, &request(&scene), if has_size(&scene) { 4 } else { 1 }));
        let most = if has_size(&scene) { 0.95 } else { 0.5 };
        let floor = |pixel: &usize| frame.object_id[*pixel] == 2;
        let pixels = inner_pixels(&frame.object_id, (frame.width, frame.height));
        let dark =
            pixels.iter().filter(|pixel| floor(pixel) && found[**pixel].is_some_and(|share| share < most)).count();
        println!("{name}: {dark} pixels in shadow");
        assert_eq!(dark > 100, casts, "{name}: {dark} pixels in shadow");
    }
}

#[test]
fn groups_of_lights_with_shadows_add_up_to_the_whole() {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 5.0, 7.0), Vec3::ZERO, perspective());
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..6_u8 {
        let (sin, cos) = f32::from(i).sin_cos();
        builder.put(primitives::cube(Vec3::splat(0.5)), grey(0.5), at(Vec3::new(2.0 * cos, 0.6, 2.0 * sin)));
    }
    for i in 0..64_u8 {
        let (sin, cos) = (2.4 * f32::from(i)).sin_cos();
        let radius_m = 0.06 * f32::from(i) + 0.1;
        let place = Vec3::new(radius_m * cos, 1.2 + 0.02 * f32::from(i), radius_m * sin);
        let kind = match i % 3 {
            0 => SPOT,
            _ => LightKind::Point,
        };
        builder.light(Light { range_m: Some(5.0), ..light(kind, 1.0) }, place, Vec3::NEG_Y);
    }
    builder.light(light(LightKind::Directional, 0.5), Vec3::ZERO, Vec3::new(0.4, -1.0, 0.2));
    let scene = builder.finish();
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    // All have room, in tiles of the same size whatever the number of lights.
    let request = request(&scene).with(|settings| settings.shadows.atlas_px = 8192);
    let whole = radiance(&mut renderer, &scene, &request, 1);
    let mut sum = vec![[0.0f32; 3]; whole.len()];
    for group in 0..8 {
        let request = FrameRequest { light_subset: Some((group, 8)), ..request.clone() };
        for (sum, part) in sum.iter_mut().zip(radiance(&mut renderer, &scene, &request, 1)) {
            (0..3).for_each(|channel| sum[channel] += part[channel]);
        }
    }
    let total = |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
    let lit = total(&radiance(&mut renderer, &scene, &unshadowed(&request), 1));
    let (whole_sum, group_sum) = (total(&whole), total(&sum));
    println!("whole {whole_sum}, groups {group_sum}, without shadows {lit}");
    assert!((whole_sum / group_sum - 1.0).abs() < 0.005, "{whole_sum} against {group_sum}");
    assert!(whole_sum < 0.95 * lit, "nothing is in shadow: {whole_sum} of {lit}");
    // And each pixel agrees with the ray caster, but for those at edges.
    let truth =
        world_of(&scene).render(SIZE.0 as usize, SIZE.1 as usize, Options { shadows: true, ..Options::default() });
    let truth_sum = total(&truth.radiance);
    assert!((whole_sum / truth_sum - 1.0).abs() < 0.01, "{whole_sum} against the ray caster's {truth_sum}");
}
