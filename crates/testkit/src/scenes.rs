//! Small scenes, each given to the renderer and to the ray caster.

use crate::raycast::{self, Emission, Lens, Shape, Surface, World};
use glam::{DVec3, Quat, Vec2, Vec3};
use manypass_scene::{Aabb, Camera, Light, LightKind, Material, Mesh, Node, Primitive, Projection, Scene};
use std::f32::consts::PI;

/// One scene in both forms. Meshes are fine enough that they differ from the exact shapes by less than 0.1 %.
#[derive(Clone, Debug)]
pub struct TestScene {
    /// A name for messages and files.
    pub name: &'static str,
    /// For the renderer; the only camera is that of `world`, and transforms are up to date.
    pub scene: Scene,
    /// For the ray caster.
    pub world: World,
}

pub(crate) fn as_rgb(color: DVec3) -> [f32; 3] {
    color.as_vec3().to_array()
}

/// Builds both forms at once.
struct Builder {
    scene: Scene,
    world: World,
}

impl Builder {
    fn new(eye_world: Vec3, target_world: Vec3, projection: Projection) -> Self {
        let forward = (target_world - eye_world).normalize();
        let right = forward.cross(if forward.y.abs() > 0.99 { Vec3::NEG_Z } else { Vec3::Y }).normalize();
        let rotation = Quat::from_mat3(&glam::Mat3::from_cols(right, right.cross(forward), -forward)).normalize();
        let lens = match projection {
            Projection::Perspective { fov_y_rad, .. } => Lens::Perspective { fov_y_rad: fov_y_rad.into() },
            Projection::Orthographic { height_m, .. } => Lens::Orthographic { height_m: height_m.into() },
        };
        let camera = raycast::Camera {
            position_world: eye_world.as_dvec3(),
            world_from_view: rotation.as_dquat().normalize(),
            lens,
        };
        let mut scene = Scene::default();
        scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
        scene.add_node(None, Node { translation: eye_world, rotation, camera: Some(0), ..Node::default() });
        Self { scene, world: World::new(camera) }
    }

    fn object(&mut self, shape: Shape, mut primitive: Primitive, color: Vec3, metallic: f32, roughness: f32) {
        let surface = Surface {
            base_color: color.as_dvec3(),
            metallic: metallic.into(),
            roughness_perceptual: roughness.into(),
            emission: DVec3::ZERO,
        };
        self.world.objects.push(raycast::Object { shape, surface });
        primitive.material = Some(self.scene.materials.len());
        self.scene.materials.push(Material {
            base_color_factor: color.extend(1.0),
            metallic_factor: metallic,
            roughness_factor: roughness,
            double_sided: matches!(shape, Shape::Quad { .. }),
            ..Material::default()
        });
        let mesh = self.scene.meshes.len();
        self.scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        self.scene.add_node(None, Node { mesh: Some(mesh), ..Node::default() });
    }

    fn sphere(&mut self, center: Vec3, radius_m: f32, color: Vec3, metallic: f32, roughness: f32) {
        let shape = Shape::Sphere { center_world: center.as_dvec3(), radius_m: radius_m.into() };
        self.object(shape, sphere(center, radius_m), color, metallic, roughness);
    }

    /// A rectangle in the plane y = 0 around the origin.
    fn floor(&mut self, half: Vec2, color: Vec3, metallic: f32, roughness: f32) {
        let (half_u, half_v) = (Vec3::X * half.x, Vec3::NEG_Z * half.y);
        let shape =
            Shape::Quad { center_world: DVec3::ZERO, half_u_world: half_u.as_dvec3(), half_v_world: half_v.as_dvec3() };
        self.object(shape, quad(half_u, half_v), color, metallic, roughness);
    }

    fn light(
        &mut self,
        kind: LightKind,
        position: Vec3,
        direction: Vec3,
        color: Vec3,
        intensity: f32,
        range: Option<f32>,
    ) {
        let direction = direction.normalize();
        let emission = match kind {
            LightKind::Directional => Emission::Directional,
            LightKind::Point => Emission::Point,
            LightKind::Spot { inner_cone_rad, outer_cone_rad } => {
                Emission::Spot { inner_cone_rad: inner_cone_rad.into(), outer_cone_rad: outer_cone_rad.into() }
            }
        };
        self.world.lights.push(raycast::Light {
            emission,
            position_world: position.as_dvec3(),
            direction_world: direction.as_dvec3().normalize(),
            intensity: color.as_dvec3() * f64::from(intensity),
            range_m: range.map(f64::from),
            ..raycast::Light::default()
        });
        let light = Some(self.scene.lights.len());
        self.scene.lights.push(Light { color_linear: color, intensity, range_m: range, kind, ..Light::default() });
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
        self.scene.add_node(None, Node { translation: position, rotation, light, ..Node::default() });
    }

    fn finish(mut self, name: &'static str) -> TestScene {
        self.scene.update_transforms();
        TestScene { name, scene: self.scene, world: self.world }
    }
}

/// A grid of `columns` by `rows` cells; `vertex(u, v)` gives position and normal, and u × v points outwards.
fn grid(columns: u32, rows: u32, vertex: impl Fn(f32, f32) -> (Vec3, Vec3)) -> Primitive {
    let mut primitive = Primitive::default();
    for i in 0..(columns + 1) * (rows + 1) {
        let u = (i % (columns + 1)) as f32 / columns as f32;
        let v = (i / (columns + 1)) as f32 / rows as f32;
        let (position, normal) = vertex(u, v);
        primitive.positions.push(position.to_array());
        primitive.normals.push(normal.to_array());
        primitive.uv0.push([u, 1.0 - v]);
    }
    for cell in 0..columns * rows {
        let a = cell % columns + (cell / columns) * (columns + 1);
        let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
        primitive.indices.extend([a, b, c, c, b, d]);
    }
    primitive.bounds = Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
    primitive
}

/// A sphere of 192 × 96 cells, whose chords lie within 0.03 % of the radius.
fn sphere(center: Vec3, radius_m: f32) -> Primitive {
    grid(192, 96, |u, v| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((2.0 * PI * u).sin_cos(), (PI * v).sin_cos());
        let normal = Vec3::new(sin_v * sin_u, -cos_v, sin_v * cos_u).normalize();
        (center + radius_m * normal, normal)
    })
}

/// A rectangle around the origin, of 64 × 64 cells for shading by vertex.
fn quad(half_u: Vec3, half_v: Vec3) -> Primitive {
    let normal = half_u.cross(half_v).normalize();
    grid(64, 64, |u, v| ((2.0 * u - 1.0) * half_u + (2.0 * v - 1.0) * half_v, normal))
}

fn perspective(fov_y_deg: f32) -> Projection {
    Projection::Perspective { fov_y_rad: fov_y_deg.to_radians(), near_m: 0.1, far_m: Some(100.0) }
}

/// A white Lambert-like plane (rough dielectric) of 4 m, seen from above, orthographically, so that the picture is the
/// plane; 1 cd at 1 m above its middle.
pub fn one_light_on_one_plane() -> TestScene {
    let projection = Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 10.0 };
    let mut builder = Builder::new(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, projection);
    builder.floor(Vec2::splat(4.0), Vec3::ONE, 0.0, 1.0);
    builder.light(LightKind::Point, Vec3::Y, Vec3::NEG_Y, Vec3::ONE, 1.0, None);
    builder.finish("one_light_on_one_plane")
}

/// Two rows of five spheres, dielectric above and metal below, with roughness from 0.1 to 1, under three point lights.
pub fn rows_of_spheres() -> TestScene {
    let mut builder = Builder::new(Vec3::new(0.0, 1.2, 7.0), Vec3::new(0.0, 1.2, 0.0), perspective(35.0));
    for i in 0..5_u8 {
        let x = 1.1 * (f32::from(i) - 2.0);
        let roughness = 0.1 + 0.225 * f32::from(i);
        builder.sphere(Vec3::new(x, 1.8, 0.0), 0.5, Vec3::new(0.2, 0.5, 0.8), 0.0, roughness);
        builder.sphere(Vec3::new(x, 0.6, 0.0), 0.5, Vec3::new(1.0, 0.77, 0.34), 1.0, roughness);
    }
    builder.floor(Vec2::splat(6.0), Vec3::splat(0.4), 0.0, 0.6);
    builder.light(LightKind::Point, Vec3::new(-3.0, 4.0, 4.0), Vec3::NEG_Y, Vec3::ONE, 30.0, None);
    builder.light(LightKind::Point, Vec3::new(3.5, 2.5, 3.0), Vec3::NEG_Y, Vec3::new(1.0, 0.4, 0.2), 15.0, None);
    builder.light(LightKind::Point, Vec3::new(0.5, 3.0, -3.0), Vec3::NEG_Y, Vec3::new(0.3, 0.5, 1.0), 20.0, Some(9.0));
    builder.finish("rows_of_spheres")
}

/// Three spot lights of different cones and colours on a floor with two spheres.
pub fn spot_lights() -> TestScene {
    let mut builder = Builder::new(Vec3::new(0.5, 4.0, 6.0), Vec3::new(0.0, 0.3, 0.0), perspective(40.0));
    builder.floor(Vec2::splat(5.0), Vec3::new(0.7, 0.6, 0.5), 0.0, 0.5);
    builder.sphere(Vec3::new(-1.2, 0.5, 0.3), 0.5, Vec3::splat(0.8), 0.0, 0.4);
    builder.sphere(Vec3::new(1.1, 0.6, -0.2), 0.6, Vec3::new(0.95, 0.64, 0.54), 1.0, 0.35);
    let spots = [
        (Vec3::new(-2.0, 3.0, 1.0), Vec3::new(0.4, -1.0, -0.1), Vec3::new(1.0, 0.3, 0.2), 0.0, 0.5),
        (Vec3::new(2.0, 3.5, 0.5), Vec3::new(-0.3, -1.0, -0.1), Vec3::new(0.2, 1.0, 0.4), 0.25, 0.3),
        (Vec3::new(0.0, 3.0, -2.5), Vec3::new(0.0, -1.0, 0.6), Vec3::new(0.3, 0.4, 1.0), 0.3, 0.9),
    ];
    for (position, direction, color, inner_cone_rad, outer_cone_rad) in spots {
        let kind = LightKind::Spot { inner_cone_rad, outer_cone_rad };
        builder.light(kind, position, direction, color, 25.0, Some(8.0));
    }
    builder.finish("spot_lights")
}

/// Spheres of different height on a floor in the light of one slanting sun of 3 lux; good for shadows.
pub fn sun() -> TestScene {
    let mut builder = Builder::new(Vec3::new(1.0, 3.0, 6.0), Vec3::new(0.0, 0.4, 0.0), perspective(40.0));
    builder.floor(Vec2::splat(5.0), Vec3::splat(0.6), 0.0, 0.7);
    for (x, y, z, radius_m) in [(-1.4, 0.5, 0.0, 0.5), (0.2, 0.9, -0.6, 0.4), (1.5, 0.35, 0.8, 0.35)] {
        builder.sphere(Vec3::new(x, y, z), radius_m, Vec3::new(0.8, 0.5, 0.3), 0.0, 0.45);
    }
    let color = Vec3::new(1.0, 0.9, 0.7);
    builder.light(LightKind::Directional, Vec3::ZERO, Vec3::new(-0.6, -1.0, -0.5), color, 3.0, None);
    builder.finish("sun")
}

/// `count` point lights of many colours, 1 to 2.5 m in range, above a glossy floor with a sphere.
pub fn many_points(count: usize) -> TestScene {
    let mut builder = Builder::new(Vec3::new(0.0, 5.0, 8.0), Vec3::ZERO, perspective(45.0));
    builder.floor(Vec2::splat(6.0), Vec3::splat(0.5), 0.0, 0.4);
    builder.sphere(Vec3::new(0.3, 0.8, 0.0), 0.8, Vec3::splat(0.9), 1.0, 0.3);
    let mut random = Lcg(1);
    for _ in 0..count {
        let mut within = |low: f32, high: f32| low + (high - low) * random.next_unit();
        let position = Vec3::new(within(-5.0, 5.0), within(0.2, 1.2), within(-5.0, 5.0));
        let color = Vec3::new(within(0.1, 1.0), within(0.1, 1.0), within(0.1, 1.0));
        let range_m = within(1.0, 2.5);
        builder.light(LightKind::Point, position, Vec3::NEG_Y, color, 0.3, Some(range_m));
    }
    builder.finish("many_points")
}

/// The roughness of the five columns of [`furnace`]. Below the first the highlights are smaller than the gaps between
/// the lights.
pub const FURNACE_ROUGHNESS: [f32; 5] = [0.3, 0.475, 0.65, 0.825, 1.0];

/// Two rows of five spheres, dielectric above and metal below, both of `colors`, seen along −Z with parallel rays; each
/// is hit from everywhere by radiance 1: by `count` suns evenly over the whole sphere.
pub fn furnace(count: u16, colors: [f32; 2]) -> TestScene {
    let projection = Projection::Orthographic { height_m: 2.2, near_m: 0.1, far_m: 10.0 };
    let mut builder = Builder::new(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, projection);
    for (x, roughness) in [-2.2, -1.1, 0.0, 1.1, 2.2].into_iter().zip(FURNACE_ROUGHNESS) {
        builder.sphere(Vec3::new(x, 0.55, 0.0), 0.5, Vec3::splat(colors[0]), 0.0, roughness);
        builder.sphere(Vec3::new(x, -0.55, 0.0), 0.5, Vec3::splat(colors[1]), 1.0, roughness);
    }
    // Each stands for an equal part of the sphere's 4π steradians.
    let lux = 4.0 * PI / f32::from(count);
    for i in 0..count {
        // Equal areas lie between equal heights, and the golden angle spreads what lies at them.
        let y = 1.0 - (2.0 * f32::from(i) + 1.0) / f32::from(count);
        let (sin, cos) = (2.399_963_2 * f64::from(i)).sin_cos();
        let direction = (Vec3::new(cos as f32, 0.0, sin as f32) * (1.0 - y * y).sqrt()).with_y(y);
        builder.light(LightKind::Directional, Vec3::ZERO, direction, Vec3::ONE, lux, None);
    }
    builder.finish("furnace")
}

/// All scenes, small enough for a test each.
pub fn all() -> Vec<TestScene> {
    vec![one_light_on_one_plane(), rows_of_spheres(), spot_lights(), sun(), many_points(200)]
}

/// A linear congruential generator: the same sequence everywhere (Knuth's MMIX constants).
struct Lcg(u64);

impl Lcg {
    /// 0 ≤ x < 1.
    fn next_unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raycast::Options;

    #[test]
    fn triangles_face_the_way_of_their_normals() {
        for scene in all() {
            for primitive in scene.scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
                for triangle in primitive.indices.chunks_exact(3) {
                    let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(primitive.positions[triangle[i] as usize]));
                    let normal = Vec3::from(primitive.normals[triangle[0] as usize]);
                    let cross = (b - a).cross(c - a);
                    assert!(cross.length() < 1e-6 || cross.dot(normal) > 0.0, "{}", scene.name);
                }
            }
        }
    }

    #[test]
    fn every_scene_shows_something_lit() {
        for scene in all() {
            let frame = scene.world.render(24, 16, Options { shadows: true, ..Options::default() });
            let lit = frame.radiance.iter().filter(|pixel| pixel.iter().any(|&channel| channel > 0.01)).count();
            assert!(lit > 60, "{}: {lit} lit pixels", scene.name);
            assert!(frame.radiance.iter().flatten().all(|channel| channel.is_finite()), "{}", scene.name);
        }
    }
}
