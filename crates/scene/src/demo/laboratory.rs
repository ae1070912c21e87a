//! A laboratory with a tiled basin and two dark panels: a place for simulations.

use super::builder::{Demo, pose};
use super::paint::{cover, plaster, slabs};
use super::room::chequers;
use crate::primitives::{cube, cylinder, plane, uv_sphere};
use crate::{
    Animation, Camera, Channel, Interpolation, Keyframes, Light, LightKind, Node, NodeId, Projection, Scene,
    TextureRef, TextureTransform,
};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Half the width and depth of the basin's water, and the heights of it and of the ground below, in metres.
const HALF: Vec2 = Vec2::new(1.2, 0.8);
const WATER_M: f32 = 0.6;
const GROUND_M: f32 = 0.2;
/// How long the ball and the stirrer take for a round, and how long they go on, in seconds.
const ROUND_SECS: f32 = 8.0;
const ROUNDS: u16 = 4;
/// The places of the panels and of the wall behind them, and the side of a panel.
const BACK_M: f32 = -1.9;
const WALL_M: f32 = -1.925;
const PANEL_M: f32 = 1.25;

/// A basin of 2.4 by 1.6 metres whose `Water` is at 0.6 m, with a `Ball` that goes around in it in 8 seconds and two posts
/// (`Post.1`, `Post.2`), before a wall with two dark panels (nodes and materials `Left` and `Right`), in front of the right one of
/// which a `Stirrer` goes to and fro. Cameras `Main` and `Above`, which sees all of it from above with parallel rays; one lamp.
pub fn laboratory() -> Scene {
    let mut place = Demo::default();
    let projection = Projection::Perspective { fov_y_rad: 0.78, near_m: 0.05, far_m: None };
    place.scene.cameras.push(Camera { name: "Main".into(), projection, aspect: None });
    let (eye, target) = (Vec3::new(0.55, 2.15, 3.1), Vec3::new(0.02, 0.92, -0.55));
    place.scene.add_node(None, Node { name: "Main".into(), camera: Some(0), ..pose(eye, target) });
    let projection = Projection::Orthographic { height_m: 8.0, near_m: 0.1, far_m: 6.0 };
    place.scene.cameras.push(Camera { name: "Above".into(), projection, aspect: None });
    let rotation = Quat::from_rotation_x(-FRAC_PI_2);
    let above = Node { name: "Above".into(), camera: Some(1), translation: 5.0 * Vec3::Y, rotation, ..Node::default() };
    place.scene.add_node(None, above);
    shell(&mut place);
    basin(&mut place);
    panels(&mut place);
    let moving = [ball(&mut place), stirrer(&mut place)];
    lamp(&mut place);
    let mut scene = place.scene;
    scene.animations.push(rounds(moving));
    scene.update_transforms();
    scene
}

/// Adds a mesh with a name.
fn named(place: &mut Demo, name: &str, mesh: usize, translation: Vec3, scale: Vec3) -> NodeId {
    let node = Node { name: name.into(), mesh: Some(mesh), translation, scale, ..Node::default() };
    place.scene.add_node(None, node)
}

fn shell(place: &mut Demo) {
    let floor = place.material("Floor", [0.36, 0.34, 0.31], 0.0, 0.6);
    let wall = place.material("Wall", [0.58, 0.55, 0.49], 0.0, 0.9);
    let dado = place.material("Dado", [0.09, 0.2, 0.21], 0.0, 0.35);
    let (of_floor, of_wall) = (slabs(&mut place.scene), plaster(&mut place.scene));
    cover(&mut place.scene, floor, of_floor, Vec2::splat(7.0));
    cover(&mut place.scene, wall, of_wall, Vec2::new(7.0, 2.0));
    let (floor, wall, dado) =
        (place.mesh(plane(1.0), floor), place.mesh(cube(Vec3::ONE), wall), place.mesh(cube(Vec3::ONE), dado));
    place.put(floor, Vec3::ZERO, Vec3::new(14.0, 1.0, 14.0));
    place.put(wall, Vec3::new(0.0, 2.0, WALL_M - 0.1), Vec3::new(14.0, 4.0, 0.2));
    place.put(dado, Vec3::new(0.0, 0.375, WALL_M), Vec3::new(14.0, 0.75, 0.02));
    place.put(dado, Vec3::new(0.0, 0.77, WALL_M), Vec3::new(14.0, 0.04, 0.05));
}

fn basin(place: &mut Demo) {
    let tiles = place.material("Tiles", [0.55, 0.86, 0.95], 0.0, 0.35);
    place.scene.materials[tiles].base_color_texture = Some(TextureRef {
        transform: TextureTransform { scale: Vec2::new(6.0, 4.0), ..TextureTransform::default() },
        texture: chequers(&mut place.scene),
        ..TextureRef::default()
    });
    let stone = place.material("Stone", [0.62, 0.6, 0.56], 0.0, 0.55);
    let water = place.material("Water", [0.1, 0.3, 0.4], 0.0, 0.1);
    let (ground, block, surface) =
        (place.mesh(plane(1.0), tiles), place.mesh(cube(Vec3::ONE), stone), place.mesh(plane(1.0), water));
    let size = Vec3::new(2.0 * HALF.x, 1.0, 2.0 * HALF.y);
    place.put(ground, GROUND_M * Vec3::Y, size);
    named(place, "Water", surface, WATER_M * Vec3::Y, size);
    let (rim_m, thick_m) = (WATER_M + 0.1, 0.14);
    for side in [-1.0, 1.0] {
        let (x, z) = (side * (HALF.x + 0.5 * thick_m), side * (HALF.y + 0.5 * thick_m));
        place.put(block, Vec3::new(x, 0.5 * rim_m, 0.0), Vec3::new(thick_m, rim_m, 2.0 * (HALF.y + thick_m)));
        place.put(block, Vec3::new(0.0, 0.5 * rim_m, z), Vec3::new(2.0 * HALF.x, rim_m, thick_m));
    }
    let post = place.mesh(cube(Vec3::new(0.16, 0.75, 0.16)), stone);
    for (name, at) in [("Post.1", Vec2::new(0.62, -0.3)), ("Post.2", Vec2::new(0.8, 0.28))] {
        named(place, name, post, Vec3::new(at.x, GROUND_M + 0.375, at.y), Vec3::ONE);
    }
}

fn panels(place: &mut Demo) {
    let frame = place.material("Frame", [0.04; 3], 0.0, 0.4);
    let frame = place.mesh(cube(Vec3::new(PANEL_M + 0.1, PANEL_M + 0.1, 0.04)), frame);
    for (name, x) in [("Left", -0.78), ("Right", 0.78)] {
        let material = place.material(name, [0.02; 3], 0.0, 0.4);
        let panel = place.mesh(plane(PANEL_M), material);
        let center = Vec3::new(x, 1.62, BACK_M);
        place.put(frame, center - 0.03 * Vec3::Z, Vec3::ONE);
        let rotation = Quat::from_rotation_x(FRAC_PI_2);
        let node = Node { name: name.into(), mesh: Some(panel), translation: center, rotation, ..Node::default() };
        place.scene.add_node(None, node);
    }
}

fn ball(place: &mut Demo) -> NodeId {
    let red = place.material("Red", [0.8, 0.06, 0.03], 0.0, 0.25);
    let white = place.material("White", [0.9, 0.9, 0.88], 0.0, 0.25);
    let (ball, knob) = (place.mesh(uv_sphere(0.13, 64, 32), red), place.mesh(cylinder(0.03, 0.1, 32), white));
    let id = named(place, "Ball", ball, WATER_M * Vec3::Y, Vec3::ONE);
    let knob = Node { mesh: Some(knob), translation: 0.16 * Vec3::Y, ..Node::default() };
    place.scene.add_node(Some(id), knob);
    id
}

fn stirrer(place: &mut Demo) -> NodeId {
    let steel = place.material("Steel", [0.7, 0.72, 0.75], 1.0, 0.25);
    let ball = place.mesh(uv_sphere(0.09, 48, 24), steel);
    named(place, "Stirrer", ball, Vec3::new(0.78, 1.75, BACK_M), Vec3::ONE)
}

fn lamp(place: &mut Demo) {
    place.scene.lights.push(Light {
        name: "Lamp".into(),
        color_linear: Vec3::new(1.0, 0.95, 0.88),
        intensity: 3.6,
        radius_m: 0.02,
        kind: LightKind::Directional,
        ..Light::default()
    });
    let light = Some(place.scene.lights.len() - 1);
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(-0.62, -0.78, -0.6).normalize());
    place.scene.add_node(None, Node { name: "Lamp".into(), light, rotation, ..Node::default() });
}

/// The ball around the basin, and the stirrer across its panel.
fn rounds([ball, stirrer]: [NodeId; 2]) -> Animation {
    let keys = 40 * ROUNDS;
    let secs = |key: u16| f32::from(key) * ROUND_SECS / 40.0;
    let times_secs: Vec<f32> = (0..=keys).map(secs).collect();
    let angle = |key: u16| f32::from(key) * TAU / 40.0;
    let of_ball = |key: u16| {
        let (sin, cos) = angle(key).sin_cos();
        Vec3::new(0.62 * cos - 0.35, WATER_M + 0.015 * (3.0 * angle(key)).sin(), 0.42 * sin)
    };
    let of_stirrer = |key: u16| {
        let (sin, cos) = angle(key).sin_cos();
        Vec3::new(0.78 + 0.3 * sin, 1.62 + 0.12 * cos, BACK_M)
    };
    let channel = |node: NodeId, at: &dyn Fn(u16) -> Vec3| Channel {
        node,
        times_secs: times_secs.clone(),
        interpolation: Interpolation::Linear,
        keyframes: Keyframes::Translation((0..=keys).map(at).collect()),
    };
    Animation {
        name: "Rounds".into(),
        channels: vec![channel(ball, &of_ball), channel(stirrer, &of_stirrer)],
        ..Animation::default()
    }
}
