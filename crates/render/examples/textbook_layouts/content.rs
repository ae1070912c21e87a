//! What is drawn: spheres on a plane under sixteen lights, as a scene and as the vertices that layouts draw.

use bytemuck::{Pod, Zeroable};
use glam::camera::rh::proj::directx;
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Quat, Vec2, Vec3, Vec4};
use manypass::scene::{Camera, Light, Material, Mesh, Node, Primitive, Projection, Scene, primitives};
use std::f32::consts::TAU;

/// Radiance that comes from everywhere alike.
const AMBIENT: Vec3 = Vec3::new(0.02, 0.025, 0.035);
const FOV_Y_RAD: f32 = 0.6;
const NEAR_M: f32 = 0.1;
const FAR_M: f32 = 60.0;

/// Perceptual roughness in 255ths, which the G-buffer of our frame holds exactly.
const ROUGHNESS: f32 = 80.0 / 255.0;

/// How much the surfaces of a scene differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variety {
    /// In their diffuse colour alone.
    Colour,
    /// In gloss as well; one is a grey metal, and one glows.
    Everything,
}

/// A scene as layouts draw it.
#[derive(Debug)]
pub struct Content {
    /// What the renderer is given.
    pub scene: Scene,
    pub vertices: Vec<SurfaceVertex>,
    pub indices: Vec<u32>,
    pub lights: Vec<LightVertex>,
}

/// A corner of a triangle; `SurfaceVertex` of the shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct SurfaceVertex {
    position_world: [f32; 3],
    normal_world: [f32; 3],
    diffuse: [f32; 3],
    emission: [f32; 3],
    /// Intensity and power.
    specular: [f32; 2],
}

/// A light; `LightVertex` of the shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LightVertex {
    /// The range in metres is the fourth.
    position_world: Vec4,
    /// In candela; the fourth is 1 for the first light alone.
    intensity: Vec4,
}

/// `Frame` of the shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FrameUniform {
    clip_from_world: Mat4,
    view_from_world: Mat4,
    eye_world: Vec4,
    ambient: Vec4,
    specular: Vec4,
}

impl FrameUniform {
    /// For a picture whose width is `aspect` times its height.
    pub fn new(aspect: f32) -> Self {
        let world_from_view = world_from_view();
        let view_from_world = world_from_view.inverse();
        Self {
            clip_from_world: directx::perspective(FOV_Y_RAD, aspect, NEAR_M, FAR_M) * view_from_world,
            view_from_world,
            eye_world: world_from_view.w_axis,
            ambient: AMBIENT.extend(0.0),
            specular: specular(&material(Vec3::ONE, ROUGHNESS)).extend(0.0).extend(0.0),
        }
    }
}

fn world_from_view() -> Mat4 {
    look_at_mat4(Vec3::new(0.0, 3.9, 6.6), Vec3::new(0.0, 0.0, 0.35), Vec3::Y).inverse()
}

fn material(color: Vec3, roughness_factor: f32) -> Material {
    Material { base_color_factor: color.extend(1.0), metallic_factor: 0.0, roughness_factor, ..Material::default() }
}

/// Specular intensity, which is f0, and the power of Blinn-Phong's lobe that is as wide as Beckmann's (Walter et al.
/// 2007).
fn specular(material: &Material) -> Vec2 {
    let roughness_alpha = material.roughness_factor * material.roughness_factor;
    let intensity = 0.04 + (material.base_color_factor.x - 0.04) * material.metallic_factor;
    Vec2::new(intensity, 2.0 / (roughness_alpha * roughness_alpha) - 2.0)
}

impl Content {
    /// Seven spheres on a plane under two rings of lights.
    pub fn new(variety: Variety) -> Self {
        let scene = Scene::default();
        let mut content = Self { scene, vertices: Vec::new(), indices: Vec::new(), lights: Vec::new() };
        content.add(primitives::plane(14.0), Vec3::ZERO, material(Vec3::splat(0.45), ROUGHNESS));
        let colors = [[0.8, 0.2, 0.15], [0.75, 0.6, 0.2], [0.25, 0.65, 0.3], [0.2, 0.4, 0.8], [0.6, 0.3, 0.7]];
        for (i, color) in colors.into_iter().enumerate() {
            let x = i as f32 - 2.0;
            let mut material = material(color.into(), ROUGHNESS);
            if variety == Variety::Everything {
                material.roughness_factor = (60.0 + 30.0 * i as f32) / 255.0;
            }
            let center = Vec3::new(1.35 * x, 0.6, 0.4 - 0.2 * x * x);
            content.add(primitives::uv_sphere(0.6, 64, 32), center, material);
        }
        let (mut metal, mut glowing) = (material(Vec3::splat(0.6), ROUGHNESS), material(Vec3::splat(0.5), ROUGHNESS));
        if variety == Variety::Everything {
            metal.metallic_factor = 1.0;
            glowing.emissive_factor = Vec3::new(0.5, 0.2, 0.04);
        }
        content.add(primitives::uv_sphere(0.35, 64, 32), Vec3::new(-0.8, 0.35, 1.7), metal);
        content.add(primitives::uv_sphere(0.35, 64, 32), Vec3::new(0.8, 0.35, 1.7), glowing);
        content.add_lights();
        content.add_camera();
        content.scene.update_transforms();
        content
    }

    fn add(&mut self, mut primitive: Primitive, center: Vec3, mut material: Material) {
        let first = self.vertices.len() as u32;
        let diffuse = material.base_color_factor.truncate() * (1.0 - material.metallic_factor);
        self.vertices.extend(primitive.positions.iter().zip(&primitive.normals).map(|(position, normal)| {
            SurfaceVertex {
                position_world: (center + Vec3::from(*position)).to_array(),
                normal_world: *normal,
                diffuse: diffuse.to_array(),
                emission: material.emissive_factor.to_array(),
                specular: specular(&material).to_array(),
            }
        }));
        self.indices.extend(primitive.indices.iter().map(|index| first + index));
        // Our frame has no ambient light of one colour: its surfaces emit what they would reflect of it.
        material.emissive_factor += AMBIENT * diffuse;
        primitive.material = Some(self.scene.materials.len());
        self.scene.materials.push(material);
        let mesh = Some(self.scene.meshes.len());
        self.scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        self.scene.add_node(None, Node { mesh, translation: center, ..Node::default() });
    }

    fn add_lights(&mut self) {
        for i in 0..16_u8 {
            let angle_rad = TAU * f32::from(i) / 16.0;
            let (radius_m, y) = if i % 2 == 0 { (3.4, 1.3) } else { (1.7, 2.0) };
            let position_world = Vec3::new(radius_m * angle_rad.cos(), y, 0.6 + radius_m * angle_rad.sin());
            let wave = |shift: f32| 0.65 + 0.35 * (angle_rad + shift).cos();
            let color_linear = Vec3::new(wave(0.0), wave(TAU / 3.0), wave(2.0 * TAU / 3.0));
            let (intensity, range_m) = (3.0, 3.2);
            let is_first = f32::from(u8::from(i == 0));
            self.lights.push(LightVertex {
                position_world: position_world.extend(range_m),
                intensity: (color_linear * intensity).extend(is_first),
            });
            let light = Some(self.scene.lights.len());
            self.scene.lights.push(Light { color_linear, intensity, range_m: Some(range_m), ..Light::default() });
            self.scene.add_node(None, Node { light, translation: position_world, ..Node::default() });
        }
    }

    fn add_camera(&mut self) {
        let projection = Projection::Perspective { fov_y_rad: FOV_Y_RAD, near_m: NEAR_M, far_m: Some(FAR_M) };
        self.scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
        let (_, rotation, translation) = world_from_view().to_scale_rotation_translation();
        let rotation: Quat = rotation.normalize();
        self.scene.add_node(None, Node { camera: Some(0), translation, rotation, ..Node::default() });
    }
}
