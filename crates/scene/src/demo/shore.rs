//! The shore of a lake: sand that goes down into the water, boulders, a jetty, and a stone basin; dry, a place for water.

use super::builder::{Demo, pose};
use super::land::{self, BASIN, chance, height_m, rough};
use super::paint::{cloud, colors, normals, ridges};
use super::shapes::lathe;
use crate::primitives::{cube, cylinder, plane, torus, uv_sphere};
use crate::{Animation, Camera, Channel, Interpolation, Keyframes, Node, NodeId, Projection, Scene};
use glam::{Quat, UVec2, Vec2, Vec3};
use std::f32::consts::TAU;

/// How long the buoy takes to rise and fall, in seconds, and how far it goes, in metres.
const SWELL_SECS: f32 = 2.4;
const SWELL_M: f32 = 0.03;
/// A bay of about 60 metres with hills behind it, whose ground is at −4 m in the deepest place: where water is to be, the
/// plane `Lake` lies at a height of 0, and `Pool` in a basin at 0.62 m. A jetty, boulders, columns that stand in the lake, and a `Buoy`
/// that goes up and down in 2.4 seconds. Camera `Shore`. There is no light but that of the environment.
pub fn shore() -> Scene {
    let mut shore = Demo::default();
    let projection = Projection::Perspective { fov_y_rad: 0.98, near_m: 0.1, far_m: None };
    shore.scene.cameras.push(Camera { name: "Shore".into(), projection, aspect: None });
    let eye = Vec3::new(0.6, 2.5, 5.0);
    shore.scene.add_node(None, Node { name: "Shore".into(), camera: Some(0), ..pose(eye, Vec3::new(0.8, 0.45, -1.0)) });
    land::add(&mut shore);
    water(&mut shore);
    boulders(&mut shore);
    jetty(&mut shore);
    columns(&mut shore);
    basin(&mut shore);
    let buoy = buoy(&mut shore);
    let mut scene = shore.scene;
    scene.animations.push(swell(buoy));
    scene.update_transforms();
    scene
}

/// Panes of dark glass where water is to be.
fn water(shore: &mut Demo) {
    let glass = shore.material("Surface", [0.01, 0.014, 0.016], 0.0, 0.05);
    let square = shore.mesh(plane(1.0), glass);
    let disc = lathe(&[Vec2::ZERO, Vec2::X].map(|point| point.with_y(0.0)), 48, false, TAU);
    let disc = shore.mesh(disc, glass);
    for (name, mesh, translation, scale) in [
        ("Lake", square, Vec3::new(0.0, 0.0, -14.0), Vec3::new(62.0, 1.0, 44.0)),
        ("Pool", disc, BASIN.with_y(0.62), Vec3::splat(1.11)),
    ] {
        let node = Node { name: name.into(), mesh: Some(mesh), translation, scale, ..Node::default() };
        shore.scene.add_node(None, node);
    }
}

fn boulders(shore: &mut Demo) {
    let stone = shore.material("Stone", [0.23, 0.215, 0.2], 0.0, 0.85);
    let relief = normals(&mut shore.scene, "stone relief", 256, 1.0, |uv| 0.035 * ridges(uv, UVec2::new(6, 4), 4));
    shore.scene.materials[stone].normal_texture = Some(relief);
    let of_kind = |seed: f32| {
        let mut boulder = uv_sphere(1.0, 48, 24);
        for (position, normal) in boulder.positions.iter_mut().zip(&mut boulder.normals) {
            let at = Vec3::from(*position);
            let bulge = |at: Vec3| {
                let turned = Vec2::new(at.x + 0.7 * at.y, at.z - 0.6 * at.y);
                1.0 + 0.45 * rough(turned * 0.9 + seed) + 0.25 * rough(Vec2::new(at.y, at.x - at.z) * 1.7 - seed)
            };
            let (a, b) = at.any_orthonormal_pair();
            let moved = |at: Vec3| at.normalize() * bulge(at.normalize());
            let (ahead, aside) = (moved(at + 0.05 * a) - moved(at), moved(at + 0.05 * b) - moved(at));
            *normal = ahead.cross(aside).normalize_or(at).to_array();
            *position = moved(at).to_array();
        }
        boulder.bounds = crate::Aabb::from_points(boulder.positions.iter().copied().map(Vec3::from));
        boulder
    };
    let kinds = [of_kind(0.0), of_kind(5.1), of_kind(9.7)];
    let kinds = kinds.map(|kind| shore.mesh(kind, stone));
    let all = [
        (-3.3, 1.6, 0.85),
        (-2.35, 0.85, 0.42),
        (-4.6, 0.2, 0.6),
        (-1.5, 1.9, 0.26),
        (6.3, 0.3, 0.7),
        (7.2, 1.1, 0.45),
        (4.6, -2.2, 0.55),
        (-7.5, -1.6, 1.1),
        (1.0, 2.5, 0.14),
        (-0.7, 1.35, 0.12),
        (11.5, -6.0, 1.6),
        (-12.5, -7.5, 1.9),
        (0.15, 1.2, 0.2),
    ];
    for (index, (x, z, size)) in (0u8..).zip(all) {
        let turn = f32::from(index) * 2.4;
        let node = Node {
            mesh: Some(kinds[usize::from(index) % 3]),
            translation: Vec3::new(x, height_m(x, z) + 0.25 * size, z),
            rotation: Quat::from_rotation_y(turn),
            scale: Vec3::new(size, 0.72 * size, 0.85 * size),
            ..Node::default()
        };
        shore.scene.add_node(None, node);
    }
}

fn jetty(shore: &mut Demo) {
    let wood = shore.material("Wood", [0.27, 0.19, 0.12], 0.0, 0.75);
    let grey = shore.material("Old wood", [0.33, 0.28, 0.23], 0.0, 0.8);
    let grain = |uv: Vec2| Vec3::splat(0.85 + 0.6 * cloud(uv, UVec2::new(2, 12), 3));
    let grain = colors(&mut shore.scene, "wood", 128, grain);
    for material in [wood, grey] {
        shore.scene.materials[material].base_color_texture = Some(grain);
    }
    let boards =
        [shore.mesh(cube(Vec3::new(1.3, 0.05, 0.19)), wood), shore.mesh(cube(Vec3::new(1.3, 0.05, 0.19)), grey)];
    let post = shore.mesh(cylinder(0.07, 3.6, 20), wood);
    let rail = shore.mesh(cube(Vec3::new(0.1, 0.12, 8.4)), wood);
    let x = -1.35;
    for i in 0..40u8 {
        let z = 1.1 - 0.21 * f32::from(i);
        let lean = 0.02 * (chance(f32::from(i), 3.0) - 0.5);
        let node = Node {
            mesh: Some(boards[usize::from(chance(f32::from(i), 8.0) > 0.6)]),
            translation: Vec3::new(x + lean, 0.45, z),
            rotation: Quat::from_rotation_y(lean),
            ..Node::default()
        };
        shore.scene.add_node(None, node);
    }
    for side in [-0.55, 0.55] {
        shore.put(rail, Vec3::new(x + side, 0.37, -3.0), Vec3::ONE);
        for z in [-0.4, -2.5, -4.6, -6.7] {
            shore.put(post, Vec3::new(x + 1.05 * side, -1.0, z), Vec3::ONE);
        }
    }
}

fn columns(shore: &mut Demo) {
    let marble = shore.material("Marble", [0.62, 0.59, 0.54], 0.0, 0.5);
    let profile = [
        (0.0, -3.0),
        (0.5, -3.0),
        (0.5, 0.1),
        (0.42, 0.2),
        (0.32, 0.3),
        (0.27, 2.9),
        (0.34, 3.0),
        (0.44, 3.2),
        (0.44, 3.35),
        (0.0, 3.35),
    ];
    let whole = shore.mesh(lathe(&profile.map(Vec2::from), 48, false, TAU), marble);
    let profile = [(0.0, -3.0), (0.5, -3.0), (0.5, 0.1), (0.42, 0.2), (0.32, 0.3), (0.3, 1.3), (0.0, 1.42)];
    let broken = shore.mesh(lathe(&profile.map(Vec2::from), 48, false, TAU), marble);
    for (mesh, x, z) in [(whole, 1.3, -4.4), (whole, 3.5, -5.2), (broken, 5.6, -6.2)] {
        shore.put(mesh, Vec3::new(x, 0.0, z), Vec3::ONE);
    }
    let beam = shore.mesh(cube(Vec3::new(3.3, 0.4, 0.75)), marble);
    let node = Node {
        mesh: Some(beam),
        translation: Vec3::new(2.4, 3.55, -4.8),
        rotation: Quat::from_rotation_y(0.35),
        ..Node::default()
    };
    shore.scene.add_node(None, node);
}

/// A basin of stone on the shore.
fn basin(shore: &mut Demo) {
    let stone = shore.material("Basin", [0.42, 0.39, 0.35], 0.0, 0.7);
    let profile = [
        (0.0, 0.2),
        (1.02, 0.2),
        (1.1, 0.28),
        (1.12, 0.66),
        (1.18, 0.72),
        (1.36, 0.72),
        (1.42, 0.66),
        (1.42, 0.56),
        (1.34, 0.5),
        (1.34, -0.1),
    ];
    // From the inside outwards, so that the profile runs backwards.
    let profile: Vec<Vec2> = profile.iter().rev().map(|point| Vec2::from(*point)).collect();
    let bowl = shore.mesh(lathe(&profile, 72, false, TAU), stone);
    shore.put(bowl, BASIN, Vec3::ONE);
    let ball = shore.material("Bronze", [0.71, 0.43, 0.18], 1.0, 0.3);
    let ball = shore.mesh(uv_sphere(0.24, 48, 24), ball);
    shore.put(ball, BASIN + Vec3::new(0.1, 0.64, -0.1), Vec3::ONE);
}

fn buoy(shore: &mut Demo) -> NodeId {
    let red = shore.material("Red", [0.68, 0.04, 0.02], 0.0, 0.3);
    let white = shore.material("White", [0.85, 0.85, 0.82], 0.0, 0.35);
    let parts = [
        (shore.mesh(torus(0.3, 0.11, 64, 24), red), Vec3::ZERO),
        (shore.mesh(cylinder(0.05, 0.5, 24), white), 0.25 * Vec3::Y),
        (shore.mesh(uv_sphere(0.1, 32, 16), red), 0.55 * Vec3::Y),
    ];
    let root = Node { name: "Buoy".into(), translation: Vec3::new(0.5, 0.03, -1.9), ..Node::default() };
    let root = shore.scene.add_node(None, root);
    for (mesh, translation) in parts {
        shore.scene.add_node(Some(root), Node { mesh: Some(mesh), translation, ..Node::default() });
    }
    root
}

fn swell(node: NodeId) -> Animation {
    let at = swell_times();
    let rise = |secs: &f32| Vec3::new(0.5, 0.03 + SWELL_M * (TAU * secs / SWELL_SECS).sin(), -1.9);
    let channel = Channel {
        node,
        keyframes: Keyframes::Translation(at.iter().map(rise).collect()),
        times_secs: at,
        interpolation: Interpolation::Linear,
    };
    Animation { name: "swell".into(), channels: vec![channel], ..Animation::default() }
}

fn swell_times() -> Vec<f32> {
    (0..=24u8).map(|step| SWELL_SECS * f32::from(step) / 24.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shore_has_what_its_stages_name() {
        let scene = shore();
        for name in ["Lake", "Pool", "Buoy", "Shore"] {
            assert!(scene.nodes.iter().any(|node| node.name == name), "{name}");
        }
    }
}
