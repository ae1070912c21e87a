//! The pictures that `debug.view` shows: each is judged by numbers that are known beforehand, and by its own legend.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec2, Vec3, Vec4};
use manypass::gpu::Floor;
use manypass::{Background, FrameRequest, Gpu, LegendEntry, Path, Renderer, Settings, Tonemap};
use manypass_scene::probes::{DISTANCE_SIDE, Probe, ProbeGrid};
use manypass_scene::surroundings::Region;
use manypass_scene::{
    Aabb, AlphaMode, Camera, Image, ImageSource, Light, LightKind, Material, Mesh, Node, PixelFormat, Pixels,
    Primitive, Projection, Sampler, Scene, ShadingModel, Texture, TextureRef, TextureTransform, primitives,
};
use manypass_testkit::build::SceneBuilder;
use std::sync::Arc;

const VIEWS: [&str; 10] = [
    "lights",
    "overdraw",
    "uv",
    "normals",
    "texel_density",
    "flags",
    "clusters",
    "cascades",
    "levels",
    "probe_weights",
];

/// A scene with a camera that sees 1 m by 1 m across the view axis, along −Z.
fn scene() -> Scene {
    let projection = Projection::Orthographic { height_m: 1.0, near_m: 0.1, far_m: 10.0 };
    let mut scene = Scene::default();
    scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
    scene.add_node(None, Node { translation: Vec3::Z * 5.0, camera: Some(0), ..Node::default() });
    scene
}

/// A square that faces +Z, u to the right and v down, from 0 to 1.
fn square(side_m: f32) -> Primitive {
    let half = side_m * 0.5;
    Primitive {
        positions: [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[x, y]| [x, y, 0.0]).to_vec(),
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uv0: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    }
}

/// Middle grey.
fn matte() -> Material {
    Material { base_color_factor: Vec4::new(0.2, 0.2, 0.2, 1.0), metallic_factor: 0.0, ..Material::default() }
}

fn put(scene: &mut Scene, mut primitive: Primitive, material: Material, translation: Vec3) {
    primitive.material = Some(scene.materials.len());
    primitive.bounds = Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
    scene.materials.push(material);
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), translation, ..Node::default() });
}

/// A texture of one colour.
fn texture(scene: &mut Scene, side: u32, texel: [u8; 4]) -> TextureRef {
    let data = texel.repeat((side * side) as usize);
    let pixels = Pixels { width: side, height: side, format: PixelFormat::Rgba8, data };
    scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(Arc::new(pixels)) });
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Sampler::default() });
    TextureRef { texture: scene.textures.len() - 1, uv_set: 0, transform: TextureTransform::default() }
}

/// A picture with its legend.
struct DebugPicture {
    width: usize,
    rgba8: Vec<u8>,
    legend: Vec<LegendEntry>,
}

impl DebugPicture {
    fn color(&self, x: usize, y: usize) -> [u8; 3] {
        self.rgba8[(y * self.width + x) * 4..][..3].try_into().unwrap()
    }

    /// What the legend says of a colour.
    fn meaning(&self, color: [u8; 3]) -> &str {
        let entry = self.legend.iter().find(|entry| entry.color_srgb == color);
        &entry.unwrap_or_else(|| panic!("{color:?} is not in {:?}", self.legend)).label
    }

    /// What the legend says of a pixel.
    fn at(&self, x: usize, y: usize) -> &str {
        self.meaning(self.color(x, y))
    }

    fn meanings(&self) -> impl Iterator<Item = &str> {
        self.rgba8.chunks_exact(4).map(|pixel| self.meaning(pixel[..3].try_into().unwrap()))
    }
}

fn request(scene: &mut Scene, size: (u32, u32), view: &str) -> FrameRequest {
    scene.update_transforms();
    plain_request(scene, size).with(|settings| settings.set("debug.view", view).unwrap())
}

/// Loads and draws the scene; the picture is that which every caller gets.
fn shown(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> DebugPicture {
    renderer.load(scene).unwrap();
    renderer.render(scene, request).unwrap();
    let rgba8 = renderer.read_display().unwrap();
    let passes = renderer.passes(scene, request).unwrap();
    let legend = passes.into_iter().find(|picture| picture.name.starts_with("debug >")).unwrap().legend;
    DebugPicture { width: request.width as usize, rgba8, legend }
}

#[test]
fn overdraw_counts_what_is_hidden_and_what_is_blended() {
    let mut scene = scene();
    put(&mut scene, square(0.5), matte(), Vec3::ZERO);
    put(&mut scene, square(0.25), matte(), Vec3::NEG_Z);
    let mut renderer = renderer();
    let stacked = request(&mut scene, (16, 16), "overdraw");
    let found = shown(&mut renderer, &scene, &stacked);
    assert_eq!([found.at(8, 8), found.at(5, 5), found.at(1, 1)], ["2", "1", "no surface"]);
    assert_eq!(found.meanings().filter(|meaning| *meaning == "2").count(), 4 * 4);
    put(&mut scene, square(0.25), Material { alpha_mode: AlphaMode::Blend, ..matte() }, Vec3::Z);
    let found = shown(&mut renderer, &scene, &stacked);
    assert_eq!([found.at(8, 8), found.at(5, 5)], ["3", "1"]);
}

#[test]
fn lights_are_as_many_as_the_report_counts() {
    let mut renderer = renderer();
    for test_scene in [manypass_testkit::scenes::rows_of_spheres(), manypass_testkit::scenes::many_points(8)] {
        let mut scene = test_scene.scene;
        for (path, scale) in [(Path::Deferred, 1.0), (Path::Forward, 1.0), (Path::Deferred, 0.5)] {
            let asked = request(&mut scene, (64, 36), "lights").with(|settings| {
                settings.render.path = path;
                settings.render.scale = scale;
            });
            let found = shown(&mut renderer, &scene, &asked);
            let number = |meaning: &str| if meaning == "no surface" { 0 } else { meaning.parse::<u64>().unwrap() };
            let sum: u64 = found.meanings().map(number).sum();
            let pairs = renderer.count_pairs(&scene, &asked).unwrap();
            // At half the size every shaded pixel is four of the picture's.
            let pixels = if scale < 1.0 { 4 } else { 1 };
            assert!(sum > 0);
            // Forward shading lights what is hidden later, too.
            let is_right = match path {
                Path::Deferred => sum == pixels * pairs.pairs_visited,
                _ => (sum..2 * sum).contains(&pairs.pairs_visited),
            };
            assert!(is_right, "{path:?}, {scale}: {sum}, {pairs:?}");
        }
    }
}

#[test]
fn coordinates_normals_and_densities_have_their_colours() {
    let mut scene = scene();
    let base_color_texture = Some(texture(&mut scene, 64, [128; 4]));
    // 64 texels over 32 pixels.
    put(&mut scene, square(0.5), Material { base_color_texture, ..matte() }, Vec3::ZERO);
    let mut plain = square(0.2);
    plain.normals = vec![[0.0, 1.0, 0.0]; 4];
    put(&mut scene, plain, matte(), Vec3::new(0.4, 0.4, 0.0));
    let mut renderer = renderer();
    let mut seen = |view: &str| {
        let asked = request(&mut scene, (64, 64), view);
        shown(&mut renderer, &scene, &asked)
    };
    let near = |found: [u8; 3], expected: [f32; 3]| {
        found.iter().zip(expected).all(|(found, expected)| (f32::from(*found) - expected).abs() <= 1.0)
    };
    let uv = seen("uv");
    // The middle of the pixel that is 4 and 8 from the corner, in a bright square; one square further it is dark.
    let (u, v) = (4.5 / 32.0, 10.5 / 32.0);
    assert!(near(uv.color(20, 26), [u * 255.0 * 0.6, v * 255.0 * 0.6, 63.75 * 0.6]), "{:?}", uv.color(20, 26));
    assert!(near(uv.color(24, 26), [8.5 / 32.0 * 255.0, v * 255.0, 63.75]), "{:?}", uv.color(24, 26));
    let normals = seen("normals");
    assert!(near(normals.color(32, 32), [127.5, 127.5, 255.0]) && near(normals.color(57, 7), [127.5, 255.0, 127.5]));
    let density = seen("texel_density");
    assert_eq!([density.at(32, 32), density.at(57, 7), density.at(2, 40)], ["2 to 4", "no texture", "no surface"]);
}

#[test]
fn wrong_inputs_are_flagged() {
    let mut scene = scene();
    let flat = Some(texture(&mut scene, 2, [128, 128, 255, 255]));
    let gray = |value: f32| Material { base_color_factor: Vec4::new(value, value, value, 1.0), ..matte() };
    let with_tangents = Primitive { tangents: vec![[1.0, 0.0, 0.0, 1.0]; 4], ..square(0.15) };
    let broken = |spoil: fn(&mut Primitive)| {
        let mut primitive = square(0.15);
        spoil(&mut primitive);
        primitive
    };
    let metal = Material { metallic_factor: 1.0, ..gray(0.97) };
    let unlit = Material { shading_model: ShadingModel::Unlit, ..gray(1.0) };
    let mapped = Material { normal_texture: flat, ..matte() };
    let right = "nothing wrong";
    let subjects = [
        (square(0.15), matte(), right),
        // sRGB 30 and 240, then what lies next to them.
        (square(0.15), gray(0.012_98), right),
        (square(0.15), gray(0.8714), right),
        (square(0.15), gray(0.0119), "base colour under sRGB 30"),
        (square(0.15), gray(0.8879), "base colour over sRGB 240"),
        (square(0.15), metal, right),
        (square(0.15), unlit, right),
        (square(0.15), Material { metallic_factor: 0.5, ..matte() }, "metallic neither 0 nor 1"),
        (with_tangents, mapped.clone(), right),
        (square(0.15), mapped, "normal map without tangents"),
        (broken(|p| p.positions[2][2] = f32::NAN), matte(), "not a number"),
        (broken(|p| p.normals[0][1] = f32::NAN), matte(), "not a number"),
        (broken(|p| p.uv0[2][0] = f32::INFINITY), matte(), "not a number"),
    ];
    for (i, (primitive, material, _)) in subjects.iter().enumerate() {
        let (column, row) = ((i % 4) as f32, (i / 4) as f32);
        put(&mut scene, primitive.clone(), material.clone(), Vec3::new(column - 1.5, 1.5 - row, 0.0) * 0.25);
    }
    let mut renderer = renderer();
    let asked = request(&mut scene, (64, 64), "flags");
    let found = shown(&mut renderer, &scene, &asked);
    for (i, (_, _, expected)) in subjects.iter().enumerate() {
        // A pixel of either triangle; what is wrong is so at a corner that they share.
        let (x, y) = (i % 4 * 16, i / 4 * 16);
        assert_eq!([found.at(x + 10, y + 9), found.at(x + 5, y + 6)], [*expected; 2], "subject {i}");
    }
}

#[test]
fn slices_of_clusters_follow_each_other() {
    let mut scene = scene();
    put(&mut scene, square(0.4), matte(), Vec3::new(-0.25, 0.0, 0.0));
    put(&mut scene, square(0.4), matte(), Vec3::new(0.25, 0.0, -4.0));
    // One that is in lists.
    scene.lights.push(Light { range_m: Some(20.0), ..Light::default() });
    scene.add_node(None, Node { light: Some(0), translation: Vec3::Z, ..Node::default() });
    let asked =
        request(&mut scene, (32, 32), "clusters").with(|settings| settings.set("clusters.slices", "8").unwrap());
    let found = shown(&mut renderer(), &scene, &asked);
    let slice = |meaning: &str| {
        let number = meaning.strip_prefix("slice ").and_then(|rest| rest.split(',').next());
        number.unwrap_or_else(|| panic!("{meaning}")).parse::<u32>().unwrap()
    };
    let (near, far) = (slice(found.at(8, 16)), slice(found.at(24, 16)));
    // 5 m and 9 m are at least a slice apart, in eight of 0.1 m to 10 m.
    assert!(near < far, "{near} {far}");
    assert_eq!([found.at(4, 12), found.at(28, 20), found.at(16, 1)], [found.at(8, 16), found.at(24, 16), "no surface"]);
}

#[test]
fn cascades_follow_each_other_away_from_the_eye() {
    let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: Some(100.0) };
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.5, 25.0), Vec3::new(0.0, 0.5, 0.0), projection);
    builder.put(primitives::plane(60.0), matte(), Node::default());
    for place in 0..8 {
        let translation = Vec3::new(1.0, 0.5, 22.0 - 6.0 * place as f32);
        builder.put(primitives::cube(Vec3::splat(0.5)), matte(), Node { translation, ..Node::default() });
    }
    let mut scene = builder.finish();
    scene.lights.push(Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() });
    let rotation = Quat::from_rotation_y(0.6) * Quat::from_rotation_x(-0.9);
    scene.add_node(None, Node { light: Some(0), rotation, ..Node::default() });
    let mut renderer = renderer();
    let asked = request(&mut scene, (48, 64), "cascades").with(|settings| settings.shadows.enabled = true);
    let found = shown(&mut renderer, &scene, &asked);
    let number = |meaning: &str| meaning.strip_prefix("cascade ").map(|number| number.parse::<u32>().unwrap());
    let upwards: Vec<u32> = (0..64).rev().filter_map(|y| number(found.at(20, y))).collect();
    println!("cascades away from the eye: {upwards:?}");
    assert!(upwards.len() > 20 && upwards.is_sorted() && upwards.first() < upwards.last(), "{upwards:?}");
    let one = shown(&mut renderer, &scene, &asked.with(|settings| settings.shadows.cascades = 1));
    assert!(one.meanings().any(|meaning| meaning == "cascade 1"));
    assert!(one.meanings().all(|meaning| number(meaning).unwrap_or(1) == 1));
    let none = shown(&mut renderer, &scene, &asked.with(|settings| settings.shadows.enabled = false));
    assert!(none.meanings().all(|meaning| ["no cascade", "no surface"].contains(&meaning)));
}

#[test]
fn probes_that_light_a_pixel_have_their_colours() {
    let mut scene = scene();
    put(&mut scene, primitives::uv_sphere(0.4, 64, 32), matte(), Vec3::ZERO);
    // One to the left of the ball, and one to the right, which see nothing else.
    let region = Region { center_world: Vec3::ZERO, half_m: Vec3::splat(2.0) };
    let distances = [Vec2::new(10.0, 100.0); DISTANCE_SIDE * DISTANCE_SIDE];
    let probe = Probe { is_on: true, distances, ..Probe::default() };
    let probes = Some(Arc::new(vec![probe.clone(), probe]));
    scene.probes.push(ProbeGrid { probes, ..ProbeGrid::new("probes", region, [2, 1, 1]).unwrap() });
    let mut renderer = renderer();
    let asked = request(&mut scene, (32, 32), "probe_weights");
    let found = shown(&mut renderer, &scene, &asked);
    let is_near = |color: [u8; 3], expected: [u8; 3], most: u8| {
        color.iter().zip(expected).all(|(found, expected)| found.abs_diff(expected) <= most)
    };
    let colors = [found.color(6, 16), found.color(26, 16), found.color(16, 16)];
    assert!(is_near(colors[0], [51, 51, 51], 2) && is_near(colors[1], [204, 51, 51], 2), "{colors:?}");
    // In the middle both count.
    assert!((80..175).contains(&colors[2][0]) && is_near([51, colors[2][1], colors[2][2]], [51; 3], 2), "{colors:?}");
    assert_eq!([found.meaning([204, 51, 51]), found.at(1, 1)], ["probe: x odd, y even, z even", "no surface"]);
    scene.probes.clear();
    let found = shown(&mut renderer, &scene, &asked);
    assert_eq!([found.at(6, 16), found.at(16, 16)], ["no probe"; 2]);
}

#[test]
fn every_view_is_the_same_on_every_path_and_under_every_curve() {
    let mut scene = manypass_testkit::scenes::spot_lights().scene;
    let mut renderer = renderer();
    for view in VIEWS {
        let asked = request(&mut scene, (48, 32), view);
        let found = shown(&mut renderer, &scene, &asked);
        assert!(found.legend.len() > 4, "{view}");
        let others: [fn(&mut Settings); 3] = [
            |settings| settings.render.path = Path::Forward,
            |settings| (settings.tone_map.curve, settings.tone_map.dither) = (Tonemap::Agx, 2.0),
            |settings| {
                (settings.background.source, settings.exposure.stops) = (Background::Transparent, "6".parse().unwrap())
            },
        ];
        for change in others {
            renderer.render(&scene, &asked.with(change)).unwrap();
            assert!(renderer.read_display().unwrap() == found.rgba8, "{view}");
        }
        // Texels and lights are those of the shaded pixels; the rest is the same at another size but for edges.
        renderer.render(&scene, &asked.with(|settings| settings.render.scale = 2.0)).unwrap();
        let finer = renderer.read_display().unwrap();
        let same = finer
            .chunks_exact(4)
            .zip(found.rgba8.chunks_exact(4))
            .filter(|(a, b)| a.iter().zip(*b).all(|(a, b)| a.abs_diff(*b) < 24));
        let share = if view == "lights" { 0.6 } else { 0.9 };
        assert!(same.count() as f64 > share * f64::from(48 * 32), "{view}");
    }
}

#[test]
fn every_view_fits_the_floor() {
    let mut scene = manypass_testkit::scenes::spot_lights().scene;
    let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).unwrap()).unwrap();
    renderer.load(&scene).unwrap();
    for view in VIEWS {
        for path in [Path::Deferred, Path::Forward] {
            let asked = request(&mut scene, (48, 32), view).with(|settings| settings.render.path = path);
            let plan = renderer.plan(&scene, &asked).unwrap();
            assert!(plan.passes.iter().any(|pass| pass.name == "debug"), "{view}");
        }
    }
    let plan = renderer.plan(&scene, &plain_request(&scene, (48, 32))).unwrap();
    assert!(plan.passes.iter().all(|pass| !pass.name.starts_with("debug")), "off by default");
}
