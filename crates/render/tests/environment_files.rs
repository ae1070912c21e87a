//! Irradiance, prefiltered pictures and the table of reflectance from files, in place of what the renderer works out.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use crate::common::skies::{Surroundings, radiance, request, room, scene};
use glam::{DVec3, Quat, Vec3};
use manypass::{FrameRequest, Ground, Path, Renderer};
use manypass_scene::environment::BrdfTable;
use manypass_scene::{EnvironmentMap, Material, Mesh, Node, Projection, Scene, primitives};
use std::sync::Arc;

const BASE_COLOR: Vec3 = Vec3::new(0.8, 0.5, 0.2);

/// A table of one scale and one bias: bytes of a Radiance file, an exponent for all.
fn table(rgbe: [u8; 4]) -> Arc<BrdfTable> {
    let bytes = [&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n"[..], &rgbe].concat();
    BrdfTable::decode("table.hdr", &bytes).unwrap().into()
}

/// Mirrors f0 of all light, and nothing.
const ALL: [u8; 4] = [128, 0, 0, 129];
const NOTHING: [u8; 4] = [0; 4];

/// A floor that fills the picture, and how it is seen: aslant.
fn floor(map: EnvironmentMap, (metallic_factor, roughness_factor): (f32, f32)) -> (Scene, FrameRequest) {
    let mut scene = scene(map, Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None });
    let base_color_factor = BASE_COLOR.extend(1.0);
    scene.materials.push(Material { base_color_factor, metallic_factor, roughness_factor, ..Material::default() });
    let plane = manypass_scene::Primitive { material: Some(0), ..primitives::plane(100.0) };
    scene.meshes.push(Mesh { primitives: vec![plane], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    let mut request = request(&scene, Quat::from_rotation_x(-0.9), 6.0);
    request.settings.ground.mode = Ground::None;
    (scene, request)
}

/// On both paths, in every pixel.
fn assert_is(renderer: &mut Renderer, (scene, request): (&Scene, &FrameRequest), expected: Vec3) {
    renderer.load(scene).unwrap();
    // The G-buffer holds base colours in bytes.
    for (path, tolerance) in [(Path::Forward, 0.003), (Path::Deferred, 0.02)] {
        let request = request.with(|settings| settings.render.path = path);
        let truth = expected.as_dvec3();
        for found in radiance(renderer, scene, &request) {
            let error = (found - truth).abs().max_element();
            assert!(error < tolerance * truth.max_element(), "{}: {found}, expected {truth}", path.name());
        }
    }
}

#[test]
fn an_even_irradiance_is_the_diffuse_light() {
    let light = Vec3::new(0.5, 1.5, 0.25);
    let file = EnvironmentMap::from_fn("even", 8, 4, |_| light);
    let (mut scene, request) = floor(room().with_irradiance(&file), (0.0, 0.5));
    scene.brdf = Some(table(NOTHING));
    assert_is(&mut renderer(), (&scene, &request), light * BASE_COLOR);
}

#[test]
fn what_is_mirrored_is_the_prefiltered_light_times_f0() {
    let halves = |level: u32| {
        let value = 1.0 + 0.5 * level as f32;
        [value, 0.5 * value, 0.25, 1.0].iter().flat_map(|value| half::f16::from_f32(*value).to_le_bytes()).collect()
    };
    let file = EnvironmentMap::decode("levels.ktx2", &manypass_testkit::ktx2::cube_map(97, 32, 5, halves)).unwrap();
    let mut renderer = renderer();
    for roughness in [0.25, 0.5, 0.875] {
        // Another picture's light.
        let (mut scene, request) = floor(room().with_prefiltered(file.clone()), (1.0, roughness));
        scene.brdf = Some(table(ALL));
        let value = 1.0 + 2.0 * roughness;
        assert_is(&mut renderer, (&scene, &request), Vec3::new(value, 0.5 * value, 0.25) * BASE_COLOR);
    }
}

#[test]
fn a_table_comes_and_goes_with_its_scene() {
    let mut renderer = renderer();
    let even = EnvironmentMap::from_fn("even", 8, 4, |_| Vec3::ONE);
    let (mut scene, request) = floor(even, (1.0, 0.5));
    renderer.load(&scene).unwrap();
    let own = radiance(&mut renderer, &scene, &request);
    scene.brdf = Some(table(NOTHING));
    assert!(radiance(&mut renderer, &scene, &request).iter().all(|value| *value == DVec3::ZERO));
    scene.brdf = None;
    assert_eq!(radiance(&mut renderer, &scene, &request), own);
}

/// The integral over all texels as a file, turned, is what the renderer works out itself, from the same side.
#[test]
fn irradiance_of_a_file_is_that_of_the_picture() {
    let map = room();
    let truth = Surroundings::of(&map);
    let file = EnvironmentMap::from_fn("integral", 64, 32, |to| truth.reflection(to.as_dvec3(), 1.0).as_vec3());
    let mut pictures = Vec::new();
    let mut renderer = renderer();
    for map in [map.clone(), map.with_irradiance(&file)] {
        let (mut scene, mut request) = floor(map, (0.0, 0.5));
        let ball = manypass_scene::Primitive { material: Some(0), ..primitives::uv_sphere(1.0, 32, 16) };
        scene.meshes[0] = Mesh { primitives: vec![ball], ..Mesh::default() }.into();
        scene.update_transforms();
        scene.brdf = Some(table(NOTHING));
        request.camera.projection = Projection::Perspective { fov_y_rad: 0.3, near_m: 0.1, far_m: None };
        request.settings.environment.rotation_deg = 75.0;
        renderer.load(&scene).unwrap();
        pictures.push(radiance(&mut renderer, &scene, &request));
    }
    let (own, read) = (&pictures[0], &pictures[1]);
    let level = own.iter().map(|value| value.y).fold(0.0, f64::max);
    let darkest = own.iter().map(|value| value.y).filter(|value| *value > 0.0).fold(f64::MAX, f64::min);
    let worst = own.iter().zip(read).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
    println!("{worst} of {darkest} to {level}");
    assert!(darkest < 0.7 * level, "the light has no sides: {darkest} to {level}");
    // The renderer's own is of fewer texels: 2.1 % off in the darkest places.
    assert!(worst < 0.025 * level, "{worst} of {level}");
}
