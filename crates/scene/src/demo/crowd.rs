//! Many small things, to see and to measure what levels of detail spare.

use super::paint::{cloud, colors, tiled};
use crate::material::{Clearcoat, Sheen, TexturedFactor};
use crate::{
    Camera, Image, ImageSource, Light, LightKind, Material, Mesh, Node, PixelFormat, Pixels, Primitive, Projection,
    Scene, Texture, TextureRef, TextureTransform, primitives,
};
use glam::{Quat, UVec2, Vec2, Vec3};

/// Bodies of a row, and rows.
const COLUMNS: usize = 50;
const ROWS: usize = 200;
/// Different bodies, each with a material of its own.
const KINDS: usize = 16;
/// Metres between them.
const STEP_M: f32 = 0.35;
/// Texels of a side of their textures.
const TEXELS: u32 = 128;

/// A field of 10,000 pebbles of sixteen kinds, each with 1,472 triangles, colours and a normal map; one in four has a
/// clear coat, and one in four is of velvet. They lie on bare earth. In a picture of 960 x 540 the balls around the
/// nearest are 16 pixels wide and those around the farthest 3.
pub fn crowd() -> Scene {
    let mut scene = Scene::default();
    for kind in 0..KINDS {
        let material = Some(scene.materials.len());
        let material_of_kind = material_of(&mut scene, kind);
        scene.materials.push(material_of_kind);
        let body = Primitive { material, ..pebble(kind) };
        scene.meshes.push(Mesh { name: format!("pebble {kind}"), primitives: vec![body], ..Mesh::default() }.into());
    }
    for at in 0..COLUMNS * ROWS {
        let (column, row) = (at % COLUMNS, at / COLUMNS);
        let turn = 2.4 * at as f32;
        // Kinds follow each other without a pattern.
        let kind = (at.wrapping_mul(2_654_435_761) >> 16) % KINDS;
        let place = Vec3::new(column as f32 - 0.5 * (COLUMNS - 1) as f32, 0.0, -(row as f32));
        scene.add_node(
            None,
            Node {
                mesh: Some(kind),
                translation: STEP_M * place,
                rotation: Quat::from_rotation_y(turn),
                ..Node::default()
            },
        );
    }
    ground(&mut scene);
    scene.lights.push(Light { intensity: 3.0, kind: LightKind::Directional, ..Light::default() });
    let sun = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.8);
    scene.add_node(None, Node { rotation: sun, light: Some(0), ..Node::default() });
    let projection = Projection::Perspective { fov_y_rad: 0.6, near_m: 0.1, far_m: None };
    scene.cameras.push(Camera { name: "field".into(), projection, aspect: None });
    let (eye, target) = (Vec3::new(0.0, 9.0, 15.0), Vec3::new(0.0, 0.0, -12.0));
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, (target - eye).normalize());
    scene.add_node(None, Node { translation: eye, rotation, camera: Some(0), ..Node::default() });
    scene.update_transforms();
    scene
}

/// Bare earth below them, on which their shadows lie.
fn ground(scene: &mut Scene) {
    let earth = colors(scene, "earth", 256, |uv| {
        let patch = cloud(uv, UVec2::splat(4), 6);
        Vec3::new(0.3, 0.26, 0.21) * (1.0 + 0.6 * patch + 0.3 * cloud(uv, UVec2::splat(64), 2))
    });
    let times = Vec2::splat(32.0);
    scene.materials.push(Material {
        name: "earth".into(),
        base_color_texture: Some(tiled(earth, times)),
        metallic_factor: 0.0,
        roughness_factor: 0.95,
        ..Material::default()
    });
    let square = Primitive { material: Some(scene.materials.len() - 1), ..primitives::plane(160.0) };
    scene.meshes.push(Mesh { name: "earth".into(), primitives: vec![square], ..Mesh::default() }.into());
    let translation = Vec3::new(0.0, -0.07, -30.0);
    scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), translation, ..Node::default() });
}

/// A ball with hollows.
fn pebble(kind: usize) -> Primitive {
    let mut body = primitives::uv_sphere(0.08, 32, 24);
    let phase = kind as f32;
    for (position, normal) in body.positions.iter_mut().zip(&mut body.normals) {
        let direction = Vec3::from(*normal);
        let bent = 5.0 * direction + phase;
        let height = 1.0 + 0.15 * bent.x.sin() * bent.y.cos() * bent.z.cos();
        let slope = 0.75 * Vec3::new(bent.x.cos() * bent.y.cos(), -bent.x.sin() * bent.y.sin(), 0.0) * bent.z.cos();
        *position = (height * Vec3::from(*position)).to_array();
        *normal = (direction - (slope - direction * slope.dot(direction)) * 0.5).normalize().to_array();
    }
    body.bounds = crate::Aabb::from_points(body.positions.iter().map(|position| Vec3::from(*position)));
    body
}

fn material_of(scene: &mut Scene, kind: usize) -> Material {
    let hue = kind as f32 / KINDS as f32;
    let color = |share: f32| Vec3::new(hue, (hue + share).fract(), (1.7 * hue + 0.4).fract()) * 0.6 + 0.3;
    let paint = texture(scene, |x, y| {
        let is_dark = (x / 8 + y / 8) % 2 == 0;
        color(if is_dark { 0.1 } else { 0.5 }) * if is_dark { 0.6 } else { 1.0 }
    });
    let bumps = texture(scene, |x, y| {
        let slope = Vec3::new((0.4 * x as f32).sin(), (0.4 * y as f32).cos(), 4.0).normalize();
        0.5 * slope + 0.5
    });
    let weight = TexturedFactor::new(1.0);
    let coat = Clearcoat { weight, roughness: TexturedFactor::new(0.1), normal_texture: None, normal_scale: 1.0 };
    let velvet = Sheen { color: TexturedFactor::new(Vec3::splat(0.3)), roughness: TexturedFactor::new(0.5) };
    Material {
        name: format!("pebble {kind}"),
        base_color_texture: Some(paint),
        normal_texture: Some(bumps),
        metallic_factor: 0.0,
        roughness_factor: 0.5,
        clearcoat: (kind % 4 == 1).then_some(coat),
        sheen: (kind % 4 == 3).then_some(velvet),
        ..Material::default()
    }
}

fn texture(scene: &mut Scene, texel: impl Fn(u32, u32) -> Vec3) -> TextureRef {
    let bytes = |at: u32| {
        let color = 255.0 * texel(at % TEXELS, at / TEXELS).clamp(Vec3::ZERO, Vec3::ONE);
        [color.x as u8, color.y as u8, color.z as u8, 255]
    };
    let data = (0..TEXELS * TEXELS).flat_map(bytes).collect();
    let pixels = Pixels { width: TEXELS, height: TEXELS, format: PixelFormat::Rgba8, data };
    let texture = scene.textures.len();
    scene.textures.push(Texture { image: scene.images.len(), sampler: Default::default() });
    scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
    TextureRef { texture, uv_set: 0, transform: TextureTransform::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pebbles_are_a_little_sunk_into_the_ground() {
        let scene = crowd();
        let grounds: Vec<_> = scene.nodes.iter().filter(|node| node.mesh == Some(KINDS)).collect();
        let lowest = scene.meshes[..KINDS].iter().map(|mesh| mesh.primitives[0].bounds.min.y).fold(0.0, f32::min);
        assert!(grounds.len() == 1 && grounds[0].translation.y > lowest && grounds[0].translation.y < 0.75 * lowest);
    }
}
