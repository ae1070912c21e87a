//! A yard between two walls, and images for what lies and sticks on them: a place for decals.

use super::builder::{Demo, pose};
use super::paint;
use crate::chance::unit;
use crate::primitives::{cube, cylinder, plane};
use crate::{Camera, Image, ImageSource, Light, LightKind, Node, NodeId, PixelFormat, Pixels, Projection, Scene};
use glam::{Quat, Vec2, Vec3, Vec4};

/// A paved yard with a back wall along X and one along Z, a crate (`Crate`) and a smaller one on it, a drum (`Drum`), a pipe,
/// steps, two lamps over the walls, and images that no material shows: `Leaf`, `Crack`, `Poster`, `Stain`, `Bolt` (which glows),
/// and `Dents` (normals).
pub fn yard() -> Scene {
    let mut place = Demo::default();
    let projection = Projection::Perspective { fov_y_rad: 0.75, near_m: 0.05, far_m: None };
    place.scene.cameras.push(Camera { name: "Main".into(), projection, aspect: None });
    let (eye, target) = (Vec3::new(2.6, 2.1, 4.4), Vec3::new(-0.35, 0.75, -0.6));
    place.scene.add_node(None, Node { name: "Main".into(), camera: Some(0), ..pose(eye, target) });
    walls(&mut place);
    things(&mut place);
    lamps(&mut place);
    images(&mut place.scene);
    place.scene.update_transforms();
    place.scene
}

fn named(place: &mut Demo, name: &str, mesh: usize, translation: Vec3, turn_rad: f32) -> NodeId {
    let rotation = Quat::from_rotation_y(turn_rad);
    place.scene.add_node(None, Node { name: name.into(), mesh: Some(mesh), translation, rotation, ..Node::default() })
}

fn walls(place: &mut Demo) {
    let paving = place.material("Paving", [0.21, 0.21, 0.2], 0.0, 0.85);
    let plaster = place.material("Plaster", [0.5, 0.43, 0.34], 0.0, 0.9);
    let (of_paving, of_plaster) = (paint::slabs(&mut place.scene), paint::plaster(&mut place.scene));
    paint::cover(&mut place.scene, paving, of_paving, Vec2::splat(8.0));
    paint::cover(&mut place.scene, plaster, of_plaster, Vec2::new(8.0, 1.5));
    let stone = place.material("Stone", [0.33, 0.32, 0.3], 0.0, 0.7);
    let (paving, plaster, stone) =
        (place.mesh(plane(1.0), paving), place.mesh(cube(Vec3::ONE), plaster), place.mesh(cube(Vec3::ONE), stone));
    place.put(paving, Vec3::ZERO, Vec3::new(16.0, 1.0, 16.0));
    place.put(plaster, Vec3::new(0.0, 1.5, -2.1), Vec3::new(16.0, 3.0, 0.2));
    place.put(plaster, Vec3::new(-2.6, 1.5, 2.0), Vec3::new(0.2, 3.0, 8.0));
    // Copings and a plinth.
    place.put(stone, Vec3::new(0.0, 3.05, -2.1), Vec3::new(16.0, 0.1, 0.32));
    place.put(stone, Vec3::new(-2.6, 3.05, 2.0), Vec3::new(0.32, 0.1, 8.0));
    place.put(stone, Vec3::new(0.0, 0.11, -1.97), Vec3::new(16.0, 0.22, 0.06));
    place.put(stone, Vec3::new(-2.47, 0.11, 2.0), Vec3::new(0.06, 0.22, 8.0));
    for step in 0..3_u8 {
        let (high, deep) = (0.16 * f32::from(3 - step), 0.3 * f32::from(step));
        place.put(stone, Vec3::new(2.1, 0.5 * high, -1.75 + deep), Vec3::new(1.3, high, 0.3));
    }
}

fn things(place: &mut Demo) {
    let wood = place.material("Wood", [0.42, 0.27, 0.14], 0.0, 0.65);
    let paint = place.material("Paint", [0.06, 0.16, 0.3], 0.0, 0.3);
    let steel = place.material("Steel", [0.62, 0.63, 0.65], 1.0, 0.35);
    let (large, small) = (place.mesh(cube(Vec3::splat(0.8)), wood), place.mesh(cube(Vec3::splat(0.42)), wood));
    named(place, "Crate", large, Vec3::new(-1.35, 0.4, -1.15), 0.28);
    named(place, "Crate.Small", small, Vec3::new(-1.45, 1.01, -1.2), -0.35);
    let drum = place.mesh(cylinder(0.34, 0.95, 64), paint);
    named(place, "Drum", drum, Vec3::new(0.35, 0.475, -1.25), 0.0);
    let pipe = place.mesh(cylinder(0.06, 3.0, 32), steel);
    named(place, "Pipe", pipe, Vec3::new(1.15, 1.5, -1.9), 0.0);
}

fn lamps(place: &mut Demo) {
    let lamp = place.material("Bulb", [0.0; 3], 0.0, 1.0);
    place.scene.materials[lamp].emissive_factor = Vec3::new(900.0, 760.0, 520.0);
    let bulb = place.mesh(cube(Vec3::new(0.18, 0.07, 0.18)), lamp);
    let of_lamp = |name: &str, intensity, kind| Light {
        name: name.into(),
        color_linear: Vec3::new(1.0, 0.86, 0.66),
        intensity,
        kind,
        range_m: Some(14.0),
        ..Light::default()
    };
    let spot = LightKind::Spot { inner_cone_rad: 0.5, outer_cone_rad: 1.25 };
    place.scene.lights = vec![of_lamp("Lamp", 520.0, spot)];
    for (at, target) in
        [(Vec3::new(0.2, 3.9, 1.1), Vec3::new(-0.3, 0.0, -0.7)), (Vec3::new(4.2, 3.6, 0.4), Vec3::new(1.8, 0.4, -0.9))]
    {
        let node = Node { mesh: Some(bulb), translation: at + 0.06 * Vec3::Y, casts_shadow: false, ..Node::default() };
        place.scene.add_node(None, node);
        place.scene.add_node(None, Node { name: "Lamp".into(), light: Some(0), ..pose(at, target) });
    }
    place.scene.lights.push(Light {
        name: "Moon".into(),
        color_linear: Vec3::new(0.6, 0.75, 1.0),
        intensity: 26.0,
        kind: LightKind::Directional,
        ..Light::default()
    });
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(-0.5, -1.0, -0.55).normalize());
    place.scene.add_node(None, Node { name: "Moon".into(), light: Some(1), rotation, ..Node::default() });
}

/// Smooth noise from 0 to 1, of which waves are 1 long (Perlin 1985, "value noise").
fn noise(at: Vec2) -> f32 {
    let cell = at.floor();
    let share = at - cell;
    let share = share * share * (3.0 - 2.0 * share);
    let (x, y) = (cell.x as i32, cell.y as i32);
    let unit = |x: i32, y: i32| unit(x as u32, y as u32);
    let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
    mix(mix(unit(x, y), unit(x + 1, y), share.x), mix(unit(x, y + 1), unit(x + 1, y + 1), share.x), share.y)
}

/// Noise of four octaves, from 0 to 1.
fn cloud(at: Vec2) -> f32 {
    (0..4_u8)
        .map(|octave| {
            noise(at * f32::from(1_u8 << octave) + 17.0 * f32::from(octave)) * 0.5_f32.powi(i32::from(octave) + 1)
        })
        .sum::<f32>()
        / 0.9375
}

/// 0 below `low`, 1 above `high`.
fn rise(low: f32, high: f32, value: f32) -> f32 {
    let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Adds an image of `side` texels, whose sRGB colour and alpha a function gives by a place from −1 to 1, Y up.
fn paint(scene: &mut Scene, name: &str, side: u16, texel: impl Fn(Vec2) -> Vec4) {
    let place = |at: u16| (f32::from(at) + 0.5) * 2.0 / f32::from(side) - 1.0;
    let texels = (0..side).flat_map(|y| (0..side).map(move |x| Vec2::new(place(x), -place(y))));
    let bytes = |texel: Vec4| texel.to_array().map(|share| (share.clamp(0.0, 1.0) * 255.0).round() as u8);
    let data: Vec<u8> = texels.flat_map(|at| bytes(texel(at))).collect();
    let pixels = Pixels { width: side.into(), height: side.into(), format: PixelFormat::Rgba8, data };
    scene.images.push(Image { name: name.into(), source: ImageSource::Pixels(pixels.into()) });
}

fn images(scene: &mut Scene) {
    paint(scene, "Leaf", 128, leaf);
    paint(scene, "Crack", 512, crack);
    paint(scene, "Poster", 512, poster);
    paint(scene, "Stain", 256, |at| {
        let edge = at.length() + 0.55 * (cloud(2.2 * at + 9.0) - 0.5);
        Vec3::splat(0.5 + 0.3 * cloud(9.0 * at)).extend(1.0 - rise(0.62, 0.7, edge))
    });
    paint(scene, "Bolt", 256, bolt);
    paint(scene, "Dents", 256, dents);
}

/// A pointed leaf with veins.
fn leaf(at: Vec2) -> Vec4 {
    let along = (0.5 * (at.y + 0.85) / 0.85).clamp(0.0, 1.0);
    let half = 0.62 * (std::f32::consts::PI * along.powf(0.8)).sin() * (1.0 + 0.08 * (28.0 * at.y).sin());
    let (beside, stalk) = (at.x.abs(), at.y < -0.6 && at.x.abs() < 0.035);
    let is_leaf = beside < half && at.y.abs() < 0.85;
    let slant = at.y - 0.8 * beside;
    let vein = (1.0 - rise(0.02, 0.05, beside))
        .max(1.0 - rise(0.04, 0.1, (6.0 * slant).rem_euclid(1.0).min(1.0 - (6.0 * slant).rem_euclid(1.0))) * 1.0);
    let color = Vec3::new(0.78, 0.42, 0.1).lerp(Vec3::new(0.85, 0.68, 0.2), 0.55 * vein + 0.35 * cloud(3.0 * at));
    color.extend(if is_leaf || stalk { 1.0 } else { 0.0 })
}

/// A crack that branches, from the left to the right.
fn crack(at: Vec2) -> Vec4 {
    let line = |x: f32, seed: f32| {
        let wave = |scale: f32| noise(Vec2::new(scale * x + 31.0 * seed, seed)) - 0.5;
        0.7 * wave(1.5) + 0.35 * wave(5.0) + 0.16 * wave(17.0) + 0.06 * wave(60.0)
    };
    let main = line(at.x, 3.0);
    let wide = (0.034 * (1.0 - at.x.abs().powi(3))).max(0.0) * (0.45 + noise(Vec2::new(9.0 * at.x, 5.0)));
    let mut apart = (at.y - main).abs() - wide;
    for (from, slope, seed) in [(-0.55_f32, 1.1_f32, 7.0), (0.0, -0.95, 11.0), (0.35, 0.8, 15.0), (-0.2, 0.7, 19.0)] {
        let reach = at.x - from;
        if (0.0..0.55).contains(&reach) {
            let branch = line(from, 3.0) + slope * reach + 0.5 * (line(2.0 * at.x, seed) - line(2.0 * from, seed));
            apart = apart.min((at.y - branch).abs() - 0.017 * (1.0 - reach / 0.55));
        }
    }
    let worn = 0.55 * (1.0 - rise(0.0, 0.09, apart)) * rise(0.35, 0.75, cloud(7.0 * at));
    let inside = 1.0 - rise(-0.004, 0.006, apart);
    Vec3::new(0.36, 0.33, 0.29).lerp(Vec3::splat(0.05), inside).extend(inside.max(worn))
}

/// A torn poster of a sun over waves.
fn poster(at: Vec2) -> Vec4 {
    let paper = Vec3::new(0.93, 0.88, 0.75);
    let mut color = paper;
    if at.x.abs() < 0.82 && at.y.abs() < 0.88 {
        color = Vec3::new(0.1, 0.35, 0.5).lerp(Vec3::new(0.95, 0.55, 0.3), rise(-0.3, 0.9, -at.y));
        let from_sun = (at - Vec2::new(0.1, 0.3)).length();
        color = color.lerp(Vec3::new(0.98, 0.85, 0.4), 1.0 - rise(0.33, 0.34, from_sun));
        for wave in 0..4_u8 {
            let wave = f32::from(wave);
            let height = -0.2 - 0.19 * wave + 0.06 * (6.0 * at.x + 1.7 * wave).sin();
            let blue = Vec3::new(0.05, 0.2 + 0.07 * wave, 0.4 - 0.05 * wave);
            color = color.lerp(blue, 1.0 - rise(height - 0.006, height + 0.006, at.y));
        }
    }
    color *= 0.85 + 0.2 * cloud(5.0 * at);
    let edge = Vec2::splat(0.96) - at.abs();
    let torn = 0.07 * cloud(6.0 * at) + 0.5 * rise(0.9, 1.5, at.x - at.y) * cloud(4.0 * at + 3.0);
    color.extend(rise(torn - 0.006, torn + 0.006, edge.min_element()))
}

/// A flash in a ring.
fn bolt(at: Vec2) -> Vec4 {
    let ring = 1.0 - rise(0.05, 0.065, (at.length() - 0.8).abs());
    let side = |a: Vec2, b: Vec2| (b - a).perp_dot(at - a);
    let upper = [Vec2::new(0.15, 0.62), Vec2::new(-0.38, -0.08), Vec2::new(0.08, -0.08)];
    let lower = [Vec2::new(-0.15, -0.62), Vec2::new(0.38, 0.08), Vec2::new(-0.08, 0.08)];
    let is_inside = |corners: [Vec2; 3]| {
        let [a, b, c] = corners;
        side(a, b) >= 0.0 && side(b, c) >= 0.0 && side(c, a) >= 0.0
    };
    let flash = if is_inside(upper) || is_inside(lower) { 1.0 } else { 0.0 };
    Vec3::new(1.0, 0.92, 0.55).extend(ring.max(flash))
}

/// Normals of dents, deepest in the middle; alpha fades towards the edge.
fn dents(at: Vec2) -> Vec4 {
    let height = |at: Vec2| {
        let hole =
            |middle: Vec2, radius: f32, deep: f32| -deep * (-(at - middle).length_squared() / (radius * radius)).exp();
        hole(Vec2::ZERO, 0.33, 0.12)
            + hole(Vec2::new(0.42, 0.3), 0.17, 0.06)
            + hole(Vec2::new(-0.4, -0.28), 0.2, 0.07)
            + hole(Vec2::new(-0.3, 0.45), 0.12, 0.04)
    };
    let step = 1e-3;
    let slope = |axis: Vec2| (height(at + axis * step) - height(at - axis * step)) / (2.0 * step);
    let normal = Vec3::new(-slope(Vec2::X), -slope(Vec2::Y), 1.0).normalize();
    (0.5 * normal + 0.5).extend(1.0 - rise(0.75, 0.98, at.length()))
}
