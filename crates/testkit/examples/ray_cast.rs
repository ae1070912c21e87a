//! Writes what the ray caster sees of a scene.
//!
//! `cargo run --release -p manypass-testkit --example ray_cast -- demo:hall|MODEL.glb OUT.exr [WIDTH HEIGHT [RAYS]]
//! [KEY=VALUE…]`
//!
//! Keys: `shadows` (1 or 0), `light_rays` (per axis, for lights with a size), `radius` (of all lights, metres), `sun`
//! (lux of a slanting sun that is added), `fog` (density per metre), `fog_height` (metres in which it falls to 1/e),
//! `anisotropy`, `steps`. With `demo:hall` alone this is the reference of the tests: 240 × 135 pixels of 16 rays each.

use glam::{DVec3, Vec3};
use manypass_scene::{Light, LightKind, Node, Scene, framing::Framing};
use manypass_testkit::build::rotation_along;
use manypass_testkit::radiance_file::RadiancePicture;
use manypass_testkit::raycast::{Camera, Medium, Options, PixelPattern, World};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, path, rest @ ..] = &arguments[..] else { return Err("a scene and a file to write are needed".into()) };
    let keys: Vec<(&str, &str)> = rest.iter().filter_map(|argument| argument.split_once('=')).collect();
    let value = |key: &str| keys.iter().find(|pair| pair.0 == key).map(|pair| pair.1.parse::<f64>()).transpose();
    let numbers: Vec<usize> = rest.iter().filter_map(|argument| argument.parse().ok()).collect();
    let (width, height) = match numbers[..] {
        [] => (240, 135),
        [width, height, ..] if width > 0 && height > 0 => (width, height),
        _ => return Err("the size is not two numbers".into()),
    };
    let mut scene = match input.as_str() {
        "demo:hall" => manypass_scene::demo::hall(),
        file => manypass_scene::gltf_file::load_path(file.as_ref())?.scene,
    };
    if let Some(lux) = value("sun")? {
        add_sun(&mut scene, lux as f32);
    }
    let aspect = width as f32 / height as f32;
    let (world_from_view, projection) =
        scene.first_camera(aspect).unwrap_or_else(|| Framing::of_scene(&scene).automatic(aspect));
    let mut world = World::of_scene(&scene, Camera::new(world_from_view, projection));
    if let Some(radius_m) = value("radius")? {
        world.lights.iter_mut().for_each(|light| light.radius_m = radius_m);
    }
    if let Some(density_per_m) = value("fog")? {
        world.medium = Some(Medium {
            density_per_m,
            scale_height_m: value("fog_height")?.unwrap_or(f64::INFINITY),
            anisotropy: value("anisotropy")?.unwrap_or(0.0),
            albedo: DVec3::ONE,
            ..Medium::default()
        });
    }
    let rays = numbers.get(2).copied().unwrap_or(16) as f64;
    let options = Options {
        shadows: value("shadows")? != Some(0.0),
        pixel_pattern: PixelPattern::Sequence,
        samples_per_axis: rays.sqrt().round() as u32,
        light_samples_per_axis: value("light_rays")?.unwrap_or(4.0) as u32,
        medium_steps: value("steps")?.unwrap_or(16.0) as u32,
        ..Options::default()
    };
    let glowing = world.lights.iter().filter(|light| !light.glows_around.is_empty()).count();
    println!("{} triangles, {} lights, of which {glowing} glow", world.meshes.triangle_count(), world.lights.len());
    let started = std::time::Instant::now();
    let frame = world.render(width, height, options);
    let bytes = RadiancePicture { width, height, pixels: frame.radiance }.to_exr();
    println!("{:.1} s, {} bytes", started.elapsed().as_secs_f64(), bytes.len());
    std::fs::write(path, bytes)?;
    Ok(())
}

fn add_sun(scene: &mut Scene, lux: f32) {
    scene.lights.push(Light { kind: LightKind::Directional, intensity: lux, ..Light::default() });
    let light = Some(scene.lights.len() - 1);
    let rotation = rotation_along(Vec3::new(-0.6, -1.0, -0.5));
    scene.add_node(None, Node { rotation, light, ..Node::default() });
    scene.update_transforms();
}
