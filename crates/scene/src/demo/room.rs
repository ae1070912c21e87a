//! A room with dark screens, a polished panel and a mobile that turns: a place for pictures within pictures.

use super::builder::{Demo, pose};
use crate::primitives::{cube, cylinder, plane, torus, uv_sphere};
use crate::{
    Animation, Camera, Channel, Image, ImageSource, Interpolation, Keyframes, Light, LightKind, Node, NodeId,
    PixelFormat, Pixels, Projection, Sampler, Scene, Texture, TextureRef, TextureTransform,
};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Half its width and depth, and its height, in metres.
const HALF: Vec2 = Vec2::new(4.0, 3.5);
const HEIGHT_M: f32 = 3.0;
/// How long the mobile takes to turn around, in seconds.
const TURN_SECS: f32 = 8.0;

/// A room of 8 by 7 metres under five lamps, whose floor is lit with a few hundred lux: three dark screens (materials `Screen.1` to `Screen.3`), a polished panel
/// (node and material `Mirror`), things on a table, and a mobile that turns in 8 seconds. Cameras `Main`, `Ceiling` and
/// `Desk`.
pub fn room() -> Scene {
    let mut room = Demo::default();
    cameras(&mut room);
    shell(&mut room);
    screens(&mut room);
    table(&mut room);
    let mobile = mobile(&mut room);
    lamps(&mut room);
    let mut scene = room.scene;
    scene.animations.push(turning(mobile));
    scene.update_transforms();
    scene
}

/// The room with three balls in its middle: polished, brushed, and glossy.
pub fn gallery() -> Scene {
    let mut gallery = Demo { scene: room() };
    let balls = [
        ("Polished", [0.95, 0.95, 0.96], 1.0, 0.02, 0.5, Vec2::new(0.75, 0.35)),
        ("Brushed", [0.91, 0.78, 0.6], 1.0, 0.28, 0.32, Vec2::new(-0.15, 1.15)),
        ("Glossy", [0.02, 0.09, 0.22], 0.0, 0.05, 0.26, Vec2::new(1.35, 1.25)),
    ];
    for (name, color, metallic, roughness, radius_m, place) in balls {
        let material = gallery.material(name, color, metallic, roughness);
        let ball = gallery.mesh(uv_sphere(radius_m, 96, 48), material);
        gallery.put(ball, Vec3::new(place.x, radius_m, place.y), Vec3::ONE);
    }
    gallery.scene.update_transforms();
    gallery.scene
}

fn cameras(room: &mut Demo) {
    let all = [
        ("Main", Vec3::new(2.3, 1.65, 3.1), Vec3::new(-0.75, 1.2, -1.2), 62.0_f32),
        ("Ceiling", Vec3::new(3.7, 2.75, -3.1), Vec3::new(-0.4, 0.7, 0.4), 70.0),
        ("Desk", Vec3::new(-1.2, 1.5, 0.6), Vec3::new(0.3, 1.5, -3.5), 75.0),
    ];
    for (name, eye, target, fov_deg) in all {
        let projection = Projection::Perspective { fov_y_rad: fov_deg.to_radians(), near_m: 0.05, far_m: None };
        room.scene.cameras.push(Camera { name: name.into(), projection, aspect: None });
        let camera = Some(room.scene.cameras.len() - 1);
        room.scene.add_node(None, Node { name: name.into(), camera, ..pose(eye, target) });
    }
}

fn shell(room: &mut Demo) {
    let tiles = room.material("Floor", [0.9; 3], 0.0, 0.45);
    room.scene.materials[tiles].base_color_texture = Some(TextureRef {
        transform: TextureTransform { scale: Vec2::splat(4.0), ..TextureTransform::default() },
        texture: chequers(&mut room.scene),
        ..TextureRef::default()
    });
    let wall = room.material("Wall", [0.42, 0.38, 0.33], 0.0, 0.85);
    let ceiling = room.material("Ceiling", [0.75, 0.74, 0.7], 0.0, 0.9);
    let skirting = room.material("Skirting", [0.16, 0.09, 0.05], 0.0, 0.5);
    let floor = room.mesh(plane(8.0), tiles);
    room.put(floor, Vec3::ZERO, Vec3::new(1.0, 1.0, HALF.y / HALF.x));
    let unit = cube(Vec3::ONE);
    let (walls, above, below) =
        (room.mesh(unit.clone(), wall), room.mesh(unit.clone(), ceiling), room.mesh(unit, skirting));
    room.put(above, Vec3::new(0.0, HEIGHT_M + 0.05, 0.0), Vec3::new(8.4, 0.1, 7.4));
    for side in [-1.0, 1.0] {
        let (x, z) = (side * (HALF.x + 0.1), side * (HALF.y + 0.1));
        room.put(walls, Vec3::new(x, 0.5 * HEIGHT_M, 0.0), Vec3::new(0.2, HEIGHT_M, 7.4));
        room.put(walls, Vec3::new(0.0, 0.5 * HEIGHT_M, z), Vec3::new(8.0, HEIGHT_M, 0.2));
        room.put(below, Vec3::new(side * (HALF.x - 0.01), 0.06, 0.0), Vec3::new(0.02, 0.12, 7.0));
        room.put(below, Vec3::new(0.0, 0.06, side * (HALF.y - 0.01)), Vec3::new(8.0, 0.12, 0.02));
    }
}

/// The texture of two by two squares.
pub(super) fn chequers(scene: &mut Scene) -> usize {
    let side = 64;
    let texel = |at: u32| {
        let (x, y) = (at % side, at / side);
        let level = if (x * 2 / side + y * 2 / side).is_multiple_of(2) { 150 } else { 52 };
        [level, level, (f32::from(level) * 0.94) as u8, 255]
    };
    let data = (0..side * side).flat_map(texel).collect();
    let pixels = Pixels { width: side, height: side, format: PixelFormat::Rgba8, data };
    scene.images.push(Image { name: "chequers".into(), source: ImageSource::Pixels(pixels.into()) });
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Sampler::default() });
    scene.textures.len() - 1
}

/// A panel of a size on a wall, in a frame; `turn` leads from the wall at the back to its own.
fn panel(room: &mut Demo, (name, material): (&str, usize), center: Vec3, size: Vec2, turn: Quat) {
    let frame = room.material("Frame", [0.03; 3], 0.0, 0.4);
    let (frame, glass) = (room.mesh(cube(Vec3::ONE), frame), room.mesh(plane(1.0), material));
    let border = 0.05;
    let put = |room: &mut Demo, mesh: usize, name: &str, offset: Vec3, scale: Vec3, rotation: Quat| {
        let (translation, rotation, mesh) = (center + turn * offset, turn * rotation, Some(mesh));
        room.scene.add_node(None, Node { name: name.into(), mesh, translation, rotation, scale, ..Node::default() });
    };
    for side in [-1.0, 1.0] {
        let (across, up) = (Vec3::X * side * 0.5 * (size.x + border), Vec3::Y * side * 0.5 * (size.y + border));
        put(room, frame, "", across, Vec3::new(border, size.y + 2.0 * border, 0.06), Quat::IDENTITY);
        put(room, frame, "", up, Vec3::new(size.x, border, 0.06), Quat::IDENTITY);
    }
    put(room, glass, name, Vec3::Z * 0.01, Vec3::new(size.x, 1.0, size.y), Quat::from_rotation_x(FRAC_PI_2));
}

fn screens(room: &mut Demo) {
    let screens = [
        ("Screen.1", Vec3::new(0.25, 1.62, -3.47), Vec2::new(2.4, 1.35)),
        ("Screen.2", Vec3::new(2.45, 1.98, -3.47), Vec2::new(1.12, 0.63)),
        ("Screen.3", Vec3::new(2.45, 1.26, -3.47), Vec2::new(1.12, 0.63)),
    ];
    for (name, center, size) in screens {
        let material = room.material(name, [0.01; 3], 0.0, 0.25);
        panel(room, (name, material), center, size, Quat::IDENTITY);
    }
    let mirror = room.material("Mirror", [0.95, 0.96, 0.95], 1.0, 0.0);
    let center = Vec3::new(-3.97, 1.45, -0.6);
    panel(room, ("Mirror", mirror), center, Vec2::new(3.2, 2.0), Quat::from_rotation_y(FRAC_PI_2));
}

fn table(room: &mut Demo) {
    let wood = room.material("Wood", [0.36, 0.19, 0.09], 0.0, 0.5);
    let leg = room.mesh(cube(Vec3::new(0.06, 0.7, 0.06)), wood);
    let top = room.mesh(cube(Vec3::new(1.7, 0.05, 0.75)), wood);
    let at = Vec3::new(-2.3, 0.0, -2.75);
    room.put(top, at + 0.725 * Vec3::Y, Vec3::ONE);
    for (x, z) in [(-0.78, -0.31), (0.78, -0.31), (-0.78, 0.31), (0.78, 0.31)] {
        room.put(leg, at + Vec3::new(x, 0.35, z), Vec3::ONE);
    }
    let copper = room.material("Copper", [0.95, 0.64, 0.54], 1.0, 0.25);
    let china = room.material("China", [0.9, 0.92, 0.95], 0.0, 0.15);
    let green = room.material("Green", [0.08, 0.3, 0.12], 0.0, 0.35);
    let ball = room.mesh(uv_sphere(0.17, 48, 24), copper);
    let ring = room.mesh(torus(0.14, 0.06, 48, 24), china);
    let book = room.mesh(cube(Vec3::new(0.34, 0.06, 0.24)), green);
    room.put(ball, at + Vec3::new(-0.45, 0.92, 0.0), Vec3::ONE);
    room.put(ring, at + Vec3::new(0.05, 0.81, 0.1), Vec3::ONE);
    room.put(book, at + Vec3::new(0.52, 0.78, 0.0), Vec3::ONE);
}

/// A pedestal with what turns above it.
fn mobile(room: &mut Demo) -> NodeId {
    let stone = room.material("Stone", [0.4, 0.4, 0.42], 0.0, 0.6);
    let gold = room.material("Gold", [1.0, 0.77, 0.34], 1.0, 0.22);
    let red = room.material("Red", [0.7, 0.05, 0.03], 0.0, 0.3);
    let blue = room.material("Blue", [0.04, 0.13, 0.55], 0.0, 0.3);
    let pedestal = room.mesh(cylinder(0.34, 0.8, 48), stone);
    room.put(pedestal, Vec3::new(-0.6, 0.4, -0.5), Vec3::ONE);
    let parts = [
        (room.mesh(torus(0.42, 0.07, 64, 24), gold), Vec3::ZERO, Quat::from_rotation_x(1.2)),
        (room.mesh(uv_sphere(0.14, 48, 24), red), Vec3::new(0.42, 0.12, 0.0), Quat::IDENTITY),
        (room.mesh(cube(Vec3::splat(0.2)), blue), Vec3::new(-0.42, -0.1, 0.0), Quat::from_rotation_y(0.6)),
    ];
    let root = Node { name: "Mobile".into(), translation: Vec3::new(-0.6, 1.35, -0.5), ..Node::default() };
    let root = room.scene.add_node(None, root);
    for (mesh, translation, rotation) in parts {
        room.scene.add_node(Some(root), Node { mesh: Some(mesh), translation, rotation, ..Node::default() });
    }
    root
}

fn turning(node: NodeId) -> Animation {
    let steps = 8_u8;
    let share = |step: u8| f32::from(step) / f32::from(steps);
    let channel = Channel {
        node,
        times_secs: (0..=steps).map(|step| TURN_SECS * share(step)).collect(),
        interpolation: Interpolation::Linear,
        keyframes: Keyframes::Rotation((0..=steps).map(|step| Quat::from_rotation_y(TAU * share(step))).collect()),
    };
    Animation { name: "turning".into(), channels: vec![channel], ..Animation::default() }
}

fn lamps(room: &mut Demo) {
    let shade = room.material("Shade", [0.0; 3], 0.0, 1.0);
    room.scene.materials[shade].emissive_factor = Vec3::new(2000.0, 1720.0, 1360.0);
    let bulb = room.mesh(cylinder(0.09, 0.03, 24), shade);
    let kind = LightKind::Spot { inner_cone_rad: 0.5, outer_cone_rad: 1.3 };
    let warm = Vec3::new(1.0, 0.86, 0.68);
    for (x, z) in [(-2.4, -2.0), (0.6, -1.6), (-2.2, 1.6), (1.8, 1.5), (2.9, -1.7)] {
        let translation = Vec3::new(x, HEIGHT_M - 0.03, z);
        room.put(bulb, translation, Vec3::ONE);
        let light = Light { color_linear: warm, intensity: 2400.0, kind, radius_m: 0.09, ..Light::default() };
        room.scene.lights.push(light);
        let light = Some(room.scene.lights.len() - 1);
        let below = translation - 0.04 * Vec3::Y;
        room.scene.add_node(None, Node { name: "Lamp".into(), light, ..pose(below, below - Vec3::Y) });
    }
    // In place of light that floor and walls give back.
    for x in [-1.9, 1.9] {
        let color_linear = Vec3::new(1.0, 0.93, 0.84);
        room.scene.lights.push(Light { color_linear, intensity: 150.0, casts_shadows: false, ..Light::default() });
        let light = Some(room.scene.lights.len() - 1);
        let translation = Vec3::new(x, 1.1, 0.4);
        room.scene.add_node(None, Node { name: "Fill".into(), light, translation, ..Node::default() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_has_what_its_stages_name() {
        let scene = room();
        for name in ["Main", "Ceiling", "Desk", "Mirror", "Mobile"] {
            assert!(scene.nodes.iter().any(|node| node.name == name), "{name}");
        }
        let screens = scene.materials.iter().filter(|material| material.name.starts_with("Screen.")).count();
        assert_eq!((screens, scene.animations[0].duration_secs()), (3, TURN_SECS));
    }
}
