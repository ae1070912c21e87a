//! A box of sand, on which a ball rolls and a stamp hops: a place for trails.

use super::builder::{Demo, pose};
use super::paint::{cloud, colors, cover, slabs};
use crate::primitives::{cube, cylinder, plane, uv_sphere};
use crate::{Animation, Camera, Channel, Interpolation, Keyframes, Light, LightKind, Node, NodeId, Projection, Scene};
use glam::{Quat, UVec2, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Width and depth of the sand, in metres.
const SAND_M: Vec2 = Vec2::new(2.4, 1.6);
const BALL_M: f32 = 0.16;
/// How long the ball takes for a round, in seconds.
const ROUND_SECS: f32 = 12.0;
/// The side of the stamp, how often it comes down in a second, and how many steps a round has.
const STAMP_M: f32 = 0.2;
const HOPS_PER_S: f32 = 1.25;
const HOPS: u16 = 15;

/// Sand of 2.4 by 1.6 metres (node and material `Sand`) in a wooden frame, a `Ball` that rolls over it in loops of 12 seconds, and a `Stamp` that hops
/// around it. Cameras `Main` and `Below`, which sees from below with parallel rays what stands on the sand; a low sun, and light from above.
pub fn sandbox() -> Scene {
    let mut place = Demo::default();
    let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.05, far_m: None };
    place.scene.cameras.push(Camera { name: "Main".into(), projection, aspect: None });
    let (eye, target) = (Vec3::new(0.9, 1.75, 2.35), Vec3::new(0.02, 0.0, 0.02));
    place.scene.add_node(None, Node { name: "Main".into(), camera: Some(0), ..pose(eye, target) });
    let projection = Projection::Orthographic { height_m: SAND_M.x, near_m: 0.05, far_m: 4.0 };
    place.scene.cameras.push(Camera { name: "Below".into(), projection, aspect: None });
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    let below = Node { name: "Below".into(), camera: Some(1), translation: Vec3::NEG_Y, rotation, ..Node::default() };
    place.scene.add_node(None, below);
    ground(&mut place);
    let moving = [ball(&mut place), stamp(&mut place)];
    sun(&mut place);
    let mut scene = place.scene;
    scene.animations.push(rounds(moving));
    scene.pose(0, 0.0);
    scene.update_transforms();
    scene
}

fn ground(place: &mut Demo) {
    let sand = place.material("Sand", [0.58, 0.49, 0.37], 0.0, 0.95);
    let stone = place.material("Stone", [0.3, 0.3, 0.29], 0.0, 0.8);
    let wood = place.material("Wood", [0.42, 0.26, 0.14], 0.0, 0.6);
    let of_stone = slabs(&mut place.scene);
    cover(&mut place.scene, stone, of_stone, Vec2::splat(6.0));
    let grain = |uv: Vec2| Vec3::splat(0.85 + 0.6 * cloud(uv, UVec2::splat(7), 3));
    let grain = colors(&mut place.scene, "wood", 128, grain);
    place.scene.materials[wood].base_color_texture = Some(grain);
    let (sand, stone, wood) =
        (place.mesh(plane(1.0), sand), place.mesh(plane(12.0), stone), place.mesh(cube(Vec3::ONE), wood));
    let scale = Vec3::new(SAND_M.x, 1.0, SAND_M.y);
    place.scene.add_node(None, Node { name: "Sand".into(), mesh: Some(sand), scale, ..Node::default() });
    place.put(stone, -0.06 * Vec3::Y, Vec3::ONE);
    let (half, thick_m) = (0.5 * SAND_M, 0.09);
    for side in [-1.0, 1.0] {
        let x = side * (half.x + 0.5 * thick_m);
        place.put(wood, Vec3::new(x, 0.0, 0.0), Vec3::new(thick_m, 0.16, SAND_M.y + 2.0 * thick_m));
        let z = side * (half.y + 0.5 * thick_m);
        place.put(wood, Vec3::new(0.0, 0.0, z), Vec3::new(SAND_M.x, 0.16, thick_m));
    }
}

fn ball(place: &mut Demo) -> NodeId {
    let red = place.material("Red", [0.7, 0.06, 0.03], 0.0, 0.3);
    let ball = place.mesh(uv_sphere(BALL_M, 64, 32), red);
    place.scene.add_node(None, Node { name: "Ball".into(), mesh: Some(ball), ..Node::default() })
}

fn stamp(place: &mut Demo) -> NodeId {
    let steel = place.material("Steel", [0.6, 0.62, 0.65], 1.0, 0.35);
    let blue = place.material("Blue", [0.05, 0.14, 0.4], 0.0, 0.4);
    let (foot, post) =
        (place.mesh(cube(Vec3::new(STAMP_M, 0.05, STAMP_M)), steel), place.mesh(cylinder(0.05, 0.25, 32), blue));
    let id = place.scene.add_node(None, Node { name: "Stamp".into(), mesh: Some(foot), ..Node::default() });
    place.scene.add_node(Some(id), Node { mesh: Some(post), translation: 0.14 * Vec3::Y, ..Node::default() });
    id
}

fn sun(place: &mut Demo) {
    place.scene.lights.push(Light {
        name: "Sun".into(),
        color_linear: Vec3::new(1.0, 0.9, 0.76),
        intensity: 4.0,
        kind: LightKind::Directional,
        ..Light::default()
    });
    // What the sky gives, from above.
    place.scene.lights.push(Light {
        name: "Sky".into(),
        color_linear: Vec3::new(0.62, 0.78, 1.0),
        intensity: 1.3,
        kind: LightKind::Directional,
        casts_shadows: false,
        ..Light::default()
    });
    for (light, (name, direction)) in
        [("Sun", Vec3::new(0.85, -0.62, 0.1)), ("Sky", Vec3::new(-0.1, -1.0, -0.25))].into_iter().enumerate()
    {
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction.normalize());
        place.scene.add_node(None, Node { name: name.into(), light: Some(light), rotation, ..Node::default() });
    }
}

/// The ball over the sand in loops, and the stamp around it, hop by hop.
fn rounds([ball, stamp]: [NodeId; 2]) -> Animation {
    let keys = 240_u16;
    let secs = |key: u16| f32::from(key) * ROUND_SECS / f32::from(keys);
    let at = |key: u16| {
        let angle = f32::from(key) * TAU / f32::from(keys);
        Vec3::new(0.82 * angle.sin(), BALL_M - 0.012, 0.42 * (2.0 * angle + 0.6).sin())
    };
    // It rolls without slipping.
    let mut turn = Quat::IDENTITY;
    let mut turns = vec![turn];
    for key in 1..=keys {
        let step = at(key) - at(key - 1);
        let axis = Vec3::Y.cross(step).normalize_or(Vec3::X);
        turn = Quat::from_axis_angle(axis, step.length() / BALL_M) * turn;
        turns.push(turn.normalize());
    }
    let times_secs: Vec<f32> = (0..=keys).map(secs).collect();
    let steps = 12_u16;
    let hops = |hop: u16| {
        let (sin, cos) = (f32::from(hop) * TAU / f32::from(HOPS) + 2.2).sin_cos();
        Vec2::new(0.98 * cos, 0.6 * sin)
    };
    let of_stamp = |key: u16| {
        let (hop, share) = (key / steps, f32::from(key % steps) / f32::from(steps));
        // It stands for the first half of a hop.
        let flight = (2.0 * share - 1.0).max(0.0);
        let place = hops(hop).lerp(hops(hop + 1), flight);
        let high_m = 0.9 * flight * (1.0 - flight);
        Vec3::new(place.x, 0.025 - 0.02 + high_m, place.y)
    };
    let stamp_keys = HOPS * steps;
    let channel =
        |node, times_secs, keyframes| Channel { node, times_secs, interpolation: Interpolation::Linear, keyframes };
    let stamp_secs = (0..=stamp_keys).map(|key| f32::from(key) / f32::from(steps) / HOPS_PER_S).collect();
    Animation {
        name: "Rounds".into(),
        channels: vec![
            channel(ball, times_secs.clone(), Keyframes::Translation((0..=keys).map(at).collect())),
            channel(ball, times_secs, Keyframes::Rotation(turns)),
            channel(stamp, stamp_secs, Keyframes::Translation((0..=stamp_keys).map(of_stamp).collect())),
        ],
        ..Animation::default()
    }
}
