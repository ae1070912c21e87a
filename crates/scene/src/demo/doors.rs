//! Two chambers far apart, with a doorway in a wall of each, and two openings in the first: places for portals.

use super::builder::{Demo, pose};
use super::paint::{cover, slabs};
use crate::primitives::{cube, cylinder, plane, torus, uv_sphere};
use crate::{Animation, Camera, Channel, Interpolation, Keyframes, Light, LightKind, Node, NodeId, Projection, Scene};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Half the side of a chamber, its height, and how thick its walls are, in metres.
const HALF_M: f32 = 3.0;
const HEIGHT_M: f32 = 2.9;
const WALL_M: f32 = 0.2;
/// How far apart chambers are.
const APART_M: f32 = 40.0;
/// The width and height of doorways; width, height and middle of the openings.
const DOOR: Vec2 = Vec2::new(1.6, 2.2);
const OPENING: Vec3 = Vec3::new(1.8, 1.4, 1.55);
/// How far panes reach into walls.
const EDGE_M: f32 = 0.03;
/// When the ball has gone through the doorway, and when it stops, in seconds.
const THROUGH_SECS: f32 = 2.0;
const END_SECS: f32 = 4.0;
const BALL_M: f32 = 0.32;

/// A warm chamber, and 40 metres to its right a cool one. In the back wall of the first is the doorway `Door.1`, in the
/// front wall of the other `Door.2`; in the left and right walls of the first are the openings `Window.1` and `Window.2`. The ball
/// `Goer.Ball` rolls into the first doorway and is in the other chamber after 2 seconds; `Goer.Lamp` hangs in that one.
/// Camera `Main`.
pub fn doors() -> Scene {
    let mut doors = Demo::default();
    let projection = Projection::Perspective { fov_y_rad: 1.02, near_m: 0.05, far_m: None };
    doors.scene.cameras.push(Camera { name: "Main".into(), projection, aspect: None });
    let eye = Vec3::new(0.9, 1.6, 2.75);
    let camera = Node { name: "Main".into(), camera: Some(0), ..pose(eye, Vec3::new(-0.55, 1.15, -2.0)) };
    doors.scene.add_node(None, camera);
    let warm = [[0.5, 0.36, 0.26], [0.44, 0.4, 0.35], [0.16, 0.09, 0.05]];
    let cool = [[0.22, 0.34, 0.36], [0.36, 0.4, 0.41], [0.04, 0.09, 0.12]];
    chamber(&mut doors, Vec3::ZERO, warm, true);
    chamber(&mut doors, APART_M * Vec3::X, cool, false);
    let stone = slabs(&mut doors.scene);
    for material in 0..doors.scene.materials.len() {
        if doors.scene.materials[material].name == "Floor" {
            cover(&mut doors.scene, material, stone, Vec2::splat(3.2));
            // Smooth but for its joints, because it is polished.
            doors.scene.materials[material].normal_scale = 0.25;
        }
    }
    things(&mut doors);
    lamps(&mut doors);
    let ball = goers(&mut doors);
    let mut scene = doors.scene;
    scene.animations.push(rolling(ball));
    scene.update_transforms();
    scene
}

/// Walls in the colours of walls, floor and frames; with a doorway at the back and openings at the sides, or with a
/// doorway at the front.
fn chamber(doors: &mut Demo, at: Vec3, [walls, floor, frames]: [[f32; 3]; 3], is_first: bool) {
    let wall = doors.material("Wall", walls, 0.0, 0.85);
    let floor = doors.material("Floor", floor, 0.0, 0.3);
    let ceiling = doors.material("Ceiling", [0.7, 0.69, 0.66], 0.0, 0.9);
    let frame = doors.material("Frame", frames, 0.0, 0.4);
    let unit = cube(Vec3::ONE);
    let [wall, floor, ceiling, frame] =
        [wall, floor, ceiling, frame].map(|material| doors.mesh(unit.clone(), material));
    let side = 2.0 * HALF_M + 2.0 * WALL_M;
    doors.put(floor, at - 0.5 * WALL_M * Vec3::Y, Vec3::new(side, WALL_M, side));
    doors.put(ceiling, at + (HEIGHT_M + 0.5 * WALL_M) * Vec3::Y, Vec3::new(side, WALL_M, side));
    // Each wall as it is seen from within, with what is cut out of it: width, height, and the height of its middle.
    let door = DOOR.extend(0.5 * DOOR.y);
    let holes =
        if is_first { [Some(door), Some(OPENING), None, Some(OPENING)] } else { [None, None, Some(door), None] };
    for (index, hole) in (0u8..).zip(holes) {
        let turn = Quat::from_rotation_y(f32::from(index) * FRAC_PI_2);
        let mut put = |mesh: usize, offset: Vec3, scale: Vec3| {
            let translation = at + turn * (offset - (HALF_M + 0.5 * WALL_M) * Vec3::Z);
            let node = Node { mesh: Some(mesh), translation, rotation: turn, scale, ..Node::default() };
            doors.scene.add_node(None, node);
        };
        let hole = hole.unwrap_or(Vec3::new(0.0, 0.0, HEIGHT_M));
        let (low, high) = (hole.z - 0.5 * hole.y, hole.z + 0.5 * hole.y);
        let beside = HALF_M - 0.5 * hole.x;
        for side in [-1.0, 1.0] {
            let middle = Vec3::new(side * (0.5 * hole.x + 0.5 * beside), 0.5 * HEIGHT_M, 0.0);
            put(wall, middle, Vec3::new(beside, HEIGHT_M, WALL_M));
        }
        for (from, to) in [(0.0, low), (high, HEIGHT_M)] {
            if hole.x > 0.0 && to > from {
                put(wall, Vec3::new(0.0, 0.5 * (from + to), 0.0), Vec3::new(hole.x, to - from, WALL_M));
            }
        }
        if hole.x > 0.0 {
            // Over the edges of the wall, so that no two faces lie in one plane.
            let (border, depth, inset) = (0.08, WALL_M + 0.04, 0.012);
            for side in [-1.0, 1.0] {
                let middle = Vec3::new(side * (0.5 * (hole.x + border) - inset), 0.5 * (low + high), 0.0);
                put(frame, middle, Vec3::new(border, high - low, depth));
            }
            for (height, is_there) in [(high + 0.5 * border - inset, true), (low - 0.5 * border + inset, low > 0.0)] {
                if is_there {
                    put(frame, height * Vec3::Y, Vec3::new(hole.x + 2.0 * border, border, depth));
                }
            }
        }
    }
    // Dark panes where portals are to be.
    let dark = doors.material("Pane", [0.01; 3], 0.0, 0.5);
    let pane = doors.mesh(plane(1.0), dark);
    let mut place = |name: &str, size: Vec2, height_m: f32, quarter: f32| {
        let turn = Quat::from_rotation_y(quarter * FRAC_PI_2);
        let node = Node {
            name: name.into(),
            mesh: Some(pane),
            translation: at + height_m * Vec3::Y + turn * (-(HALF_M + 0.5 * WALL_M) * Vec3::Z),
            rotation: turn * Quat::from_rotation_x(FRAC_PI_2),
            // Its edges lie within the walls, where nobody sees them.
            scale: Vec3::new(size.x + 2.0 * EDGE_M, 1.0, size.y + 2.0 * EDGE_M),
            ..Node::default()
        };
        doors.scene.add_node(None, node);
    };
    if is_first {
        place("Door.1", DOOR, 0.5 * DOOR.y, 0.0);
        place("Window.1", OPENING.truncate(), OPENING.z, 1.0);
        place("Window.2", OPENING.truncate(), OPENING.z, 3.0);
    } else {
        place("Door.2", DOOR, 0.5 * DOOR.y, 2.0);
    }
}

fn things(doors: &mut Demo) {
    let stone = doors.material("Stone", [0.4, 0.4, 0.42], 0.0, 0.6);
    let gold = doors.material("Gold", [1.0, 0.77, 0.34], 1.0, 0.22);
    let china = doors.material("China", [0.88, 0.9, 0.93], 0.0, 0.15);
    let green = doors.material("Green", [0.06, 0.26, 0.1], 0.0, 0.4);
    let pedestal = doors.mesh(cylinder(0.3, 0.9, 48), stone);
    let ring = doors.mesh(torus(0.32, 0.09, 64, 24), gold);
    let vase = doors.mesh(uv_sphere(0.27, 48, 24), china);
    let block = doors.mesh(cube(Vec3::new(0.5, 0.5, 0.5)), green);
    let cool = APART_M * Vec3::X;
    for (mesh, translation, rotation) in [
        (pedestal, cool + Vec3::new(-0.75, 0.45, -1.7), Quat::IDENTITY),
        (ring, cool + Vec3::new(-0.75, 1.35, -1.7), Quat::from_rotation_x(1.2) * Quat::from_rotation_z(0.4)),
        (block, cool + Vec3::new(0.95, 0.25, -2.1), Quat::from_rotation_y(0.5)),
        (pedestal, Vec3::new(-1.9, 0.45, -1.7), Quat::IDENTITY),
        (vase, Vec3::new(-1.9, 1.17, -1.7), Quat::IDENTITY),
        (block, Vec3::new(1.9, 0.25, -2.0), Quat::from_rotation_y(0.3)),
    ] {
        doors.scene.add_node(None, Node { mesh: Some(mesh), translation, rotation, ..Node::default() });
    }
}

/// A light that hangs somewhere, with a bulb around it.
fn lamp(doors: &mut Demo, name: &str, (at, color, candela): (Vec3, Vec3, f32)) {
    let shade = doors.material("Bulb", [0.0; 3], 0.0, 1.0);
    doors.scene.materials[shade].emissive_factor = color * candela * 4.0;
    let bulb = doors.mesh(uv_sphere(0.06, 24, 12), shade);
    let light = Light {
        color_linear: color,
        intensity: candela,
        kind: LightKind::Point,
        radius_m: 0.06,
        range_m: Some(9.0),
        ..Light::default()
    };
    doors.scene.lights.push(light);
    let light = Some(doors.scene.lights.len() - 1);
    doors.scene.add_node(None, Node { name: name.into(), light, translation: at, ..Node::default() });
    let node = Node { mesh: Some(bulb), translation: at, casts_shadow: false, ..Node::default() };
    doors.scene.add_node(None, node);
}

fn lamps(doors: &mut Demo) {
    let cool = APART_M * Vec3::X;
    lamp(doors, "Lamp", (Vec3::new(-1.2, 2.5, 0.6), Vec3::new(1.0, 0.8, 0.58), 55.0));
    lamp(doors, "Lamp", (cool + Vec3::new(-1.5, 2.5, -1.0), Vec3::new(0.8, 0.93, 1.0), 34.0));
    lamp(doors, "Goer.Lamp", (cool + Vec3::new(0.4, 1.75, 0.9), Vec3::new(0.6, 0.87, 1.0), 75.0));
    for (at, candela) in [(Vec3::new(1.0, 1.2, 1.2), 12.0), (cool + Vec3::new(0.7, 1.3, 1.6), 9.0)] {
        // In place of light that floor and walls give back.
        doors.scene.lights.push(Light {
            intensity: candela,
            casts_shadows: false,
            range_m: Some(7.0),
            ..Light::default()
        });
        let light = Some(doors.scene.lights.len() - 1);
        doors.scene.add_node(None, Node { name: "Fill".into(), light, translation: at, ..Node::default() });
    }
}

fn goers(doors: &mut Demo) -> NodeId {
    let orange = doors.material("Orange", [0.85, 0.21, 0.02], 0.0, 0.25);
    let ball = doors.mesh(uv_sphere(BALL_M, 64, 32), orange);
    let (translation, mesh) = (at_secs(1.8), Some(ball));
    doors.scene.add_node(None, Node { name: "Goer.Ball".into(), mesh, translation, ..Node::default() })
}

/// Where the ball is: in the first chamber until it is through, and from then on in the other.
fn at_secs(secs: f32) -> Vec3 {
    // The planes of the doorways lie in the middle of their walls.
    let plane_m = HALF_M + 0.5 * WALL_M;
    // Whole behind the plane when it is through.
    let gone_m = -plane_m - 1.1 * BALL_M;
    let speed = (0.6 - gone_m) / THROUGH_SECS;
    let z = 0.6 - speed * secs;
    if secs < THROUGH_SECS { Vec3::new(0.25, BALL_M, z) } else { Vec3::new(APART_M + 0.25, BALL_M, z + 2.0 * plane_m) }
}

fn rolling(node: NodeId) -> Animation {
    let before = THROUGH_SECS - 1e-3;
    let times = vec![0.0, before, THROUGH_SECS, END_SECS];
    let channel = Channel {
        node,
        keyframes: Keyframes::Translation(times.iter().map(|secs| at_secs(*secs)).collect()),
        times_secs: times,
        interpolation: Interpolation::Linear,
    };
    Animation { name: "rolling".into(), channels: vec![channel], ..Animation::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chambers_have_what_their_stage_names() {
        let scene = doors();
        for name in ["Main", "Door.1", "Door.2", "Window.1", "Window.2", "Goer.Ball", "Goer.Lamp"] {
            assert_eq!(scene.nodes.iter().filter(|node| node.name == name).count(), 1, "{name}");
        }
        // The ball goes on through the doorway without a jump but that between the chambers.
        let step = at_secs(THROUGH_SECS) - at_secs(THROUGH_SECS - 1e-4);
        assert!((step - Vec3::new(APART_M, 0.0, 2.0 * HALF_M + WALL_M)).length() < 1e-3, "{step}");
    }
}
