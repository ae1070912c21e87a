//! Bricks and cobbles that are flat but for their heights, and light that was baked.

use crate::material::{DetailMaps, HeightMap, HeightMethod, LightEncoding, LightMap, TexturedFactor};
use crate::{
    Camera, Image, ImageSource, Light, LightKind, Material, Mesh, Node, PixelFormat, Pixels, Primitive, Projection,
    Sampler, Scene, Texture, TextureRef, TextureTransform, Wrap, primitives,
};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Texels along the sides of images.
const SIDE: u32 = 256;

/// A wall of bricks and a floor of cobbles, each a single square with heights, in the raking light of a lamp. Light of
/// a window that is not there was baked into the wall; a ball has detail of its own.
pub fn relief() -> Scene {
    let mut scene = Scene::default();
    let bricks = of_heights(&mut scene, "bricks", brick, Vec3::new(0.42, 0.13, 0.07));
    let cobbles = of_heights(&mut scene, "cobbles", cobble, Vec3::new(0.2, 0.19, 0.17));
    let window = texture(&mut scene, "window", Wrap::ClampToEdge, |uv| {
        let pane = |at: f32, from: f32, to: f32| soft(at - from) * soft(to - at);
        let across = pane(uv.x, 0.56, 0.69) + pane(uv.x, 0.71, 0.84);
        let up = pane(uv.y, 0.3, 0.47) + pane(uv.y, 0.49, 0.66);
        let light = across * up;
        Vec3::new(0.05, 0.055, 0.07) + Vec3::new(0.75, 0.5, 0.24) * light
    });
    let light_map = LightMap {
        light: TexturedFactor { factor: 1.6, texture: Some(TextureRef { uv_set: 1, ..window }) },
        encoding: LightEncoding::Linear,
        direction: None,
    };
    let wall = Material { name: "wall".into(), light_map: Some(light_map), ..surface(bricks, 0.035) };
    let floor = Material { name: "floor".into(), ..surface(cobbles, 0.045) };
    put(
        &mut scene,
        plane(2.6),
        wall,
        Node { translation: Vec3::new(0.0, 1.3, -1.3), rotation: Quat::from_rotation_x(FRAC_PI_2), ..Node::default() },
    );
    put(&mut scene, plane(2.6), floor, Node::default());
    let grain = texture(&mut scene, "grain", Wrap::Repeat, |uv| {
        let slope = Vec2::new((uv.x * TAU * 4.0).cos(), (uv.y * TAU * 4.0).cos()) * 0.35;
        Vec3::new(-slope.x, slope.y, 1.0).normalize() * 0.5 + 0.5
    });
    let transform = TextureTransform { scale: Vec2::new(8.0, 4.0), ..TextureTransform::default() };
    let detail = DetailMaps {
        normal_texture: Some(TextureRef { transform, ..grain }),
        normal_scale: 1.0,
        base_color_texture: None,
    };
    let ball = Material {
        name: "ball".into(),
        base_color_factor: Vec3::new(0.05, 0.2, 0.24).extend(1.0),
        metallic_factor: 0.0,
        roughness_factor: 0.35,
        detail: Some(detail),
        ..Material::default()
    };
    let sphere = primitives::uv_sphere(0.3, 64, 32);
    put(&mut scene, sphere, ball, Node { translation: Vec3::new(-0.35, 0.29, -0.1), ..Node::default() });
    lights_and_camera(&mut scene);
    scene.update_transforms();
    scene
}

fn lights_and_camera(scene: &mut Scene) {
    let lamp = Light {
        name: "lamp".into(),
        kind: LightKind::Point,
        color_linear: Vec3::new(1.0, 0.93, 0.82),
        intensity: 5.0,
        radius_m: 0.02,
        ..Light::default()
    };
    scene.lights.push(lamp);
    let translation = Vec3::new(-1.15, 1.25, -0.55);
    scene.add_node(None, Node { name: "lamp".into(), translation, light: Some(0), ..Node::default() });
    let projection = Projection::Perspective { fov_y_rad: 0.62, near_m: 0.1, far_m: None };
    scene.cameras.push(Camera { name: "front".into(), projection, aspect: None });
    let eye = Vec3::new(0.75, 1.15, 2.55);
    let rotation = looking(Vec3::new(-0.02, 0.66, -0.6) - eye);
    scene.add_node(None, Node { translation: eye, rotation, camera: Some(0), ..Node::default() });
}

/// The rotation of a camera that looks along `direction`, with its right side level.
fn looking(direction: Vec3) -> Quat {
    let back = -direction.normalize_or(Vec3::NEG_Z);
    let right = Vec3::Y.cross(back).normalize_or(Vec3::X);
    Quat::from_mat3(&glam::Mat3::from_cols(right, back.cross(right), back))
}

/// Base colour and heights of a surface.
type Maps = (TextureRef, TextureRef);

fn surface((base_color, heights): Maps, depth_m: f32) -> Material {
    Material {
        base_color_texture: Some(base_color),
        metallic_factor: 0.0,
        roughness_factor: 0.85,
        height: Some(HeightMap { texture: heights, depth_m, method: HeightMethod::Occlusion, self_shadow: true }),
        ..Material::default()
    }
}

/// A square whose second UV set is its first.
fn plane(side_m: f32) -> Primitive {
    let plane = primitives::plane(side_m);
    Primitive { uv1: plane.uv0.clone(), ..plane }
}

fn put(scene: &mut Scene, primitive: Primitive, material: Material, node: Node) {
    let name = material.name.clone();
    let primitive = Primitive { material: Some(scene.materials.len()), ..primitive };
    scene.materials.push(material);
    let mesh = Some(scene.meshes.len());
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { name, mesh, ..node });
}

/// A texture of what `value` gives at UVs.
fn texture(scene: &mut Scene, name: &str, wrap: Wrap, value: impl Fn(Vec2) -> Vec3) -> TextureRef {
    let mut data = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    for at in 0..SIDE * SIDE {
        let uv = (Vec2::new((at % SIDE) as f32, (at / SIDE) as f32) + 0.5) / SIDE as f32;
        let texel = (value(uv).clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round();
        data.extend([texel.x as u8, texel.y as u8, texel.z as u8, 255]);
    }
    let pixels = Pixels { width: SIDE, height: SIDE, format: PixelFormat::Rgba8, data };
    scene.images.push(Image { name: name.into(), source: ImageSource::Pixels(pixels.into()) });
    let sampler = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler });
    TextureRef { texture: scene.textures.len() - 1, uv_set: 0, transform: TextureTransform::default() }
}

/// The maps of a surface of stones: `stone` gives the height and the number of the stone at UVs.
fn of_heights(scene: &mut Scene, name: &str, stone: fn(Vec2) -> (f32, u32), color: Vec3) -> Maps {
    let base_color = texture(scene, name, Wrap::Repeat, |uv| {
        let (height, number) = stone(uv);
        let tint = 0.7 + 0.6 * noise(number, 7);
        let linear = if height > 0.3 { color * tint } else { Vec3::splat(0.23) };
        linear.map(|value| value.powf(1.0 / 2.2))
    });
    let heights = texture(scene, &format!("{name} heights"), Wrap::Repeat, |uv| Vec3::splat(stone(uv).0));
    let transform = TextureTransform { scale: Vec2::splat(2.0), ..TextureTransform::default() };
    (TextureRef { transform, ..base_color }, TextureRef { transform, ..heights })
}

/// 0 below 0, 1 above a little more, and a slope between.
fn soft(distance: f32) -> f32 {
    let t = (distance / 0.012).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 0 to 1, another for every number (the finaliser of MurmurHash3).
fn noise(number: u32, seed: u32) -> f32 {
    let mut hash = number.wrapping_mul(0x9e37_79b9) ^ seed.wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    (hash ^ (hash >> 16)) as f32 / u32::MAX as f32
}

/// Three bricks in a row, eight rows, every other row moved by half a brick.
fn brick(uv: Vec2) -> (f32, u32) {
    let row = (uv.y * 8.0).floor();
    let across = (uv.x + if row % 2.0 == 1.0 { 1.0 / 6.0 } else { 0.0 }).fract() * 3.0;
    let number = row as u32 * 3 + across as u32;
    // From the nearest joint, in UVs.
    let to_joint = |at: f32, size: f32| at.fract().min(1.0 - at.fract()) * size;
    let inside = to_joint(across, 1.0 / 3.0).min(to_joint(uv.y * 8.0, 1.0 / 8.0)) - 0.006;
    let top = 0.8 + 0.2 * noise(number, 3);
    (0.08 + (top - 0.08) * soft(inside), number)
}

/// Round stones, moved a little from the middles of six by six squares.
fn cobble(uv: Vec2) -> (f32, u32) {
    const STONES: f32 = 6.0;
    let (at, mut best, mut number) = (uv * STONES, 0.0f32, 0);
    for (x, y) in (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))) {
        let square = at.floor() + Vec2::new(x as f32, y as f32);
        let wrapped = (square + STONES).rem_euclid(Vec2::splat(STONES));
        let stone = wrapped.y as u32 * STONES as u32 + wrapped.x as u32;
        let middle = square + 0.5 + 0.24 * (Vec2::new(noise(stone, 1), noise(stone, 2)) - 0.5);
        let reach = 0.5 + 0.08 * noise(stone, 3);
        let share = 1.0 - (at - middle).length_squared() / (reach * reach);
        let height = share.max(0.0).sqrt() * (0.85 + 0.15 * noise(stone, 4));
        if height > best {
            (best, number) = (height, stone);
        }
    }
    (best, number)
}
