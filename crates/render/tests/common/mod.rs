//! What the tests that need an adapter share; the software one will do.

#![allow(dead_code, clippy::unwrap_used, reason = "each test file uses a part, and panics where it expects something")]

pub mod files;
pub mod flat;
pub mod ground;
pub mod levels;
pub mod reflected;
pub mod shadows;
pub mod skies;

use glam::{Mat4, Quat, Vec3, Vec4};
use manypass::{AovPixels, Averaging, Background, Environment, FrameRequest, Gpu, Renderer, Switch, Tonemap, View};
use manypass_scene::material::Specular;
use manypass_scene::{Aabb, Material, Projection, Scene, TexturedFactor};
use std::path::PathBuf;

/// A renderer on the first adapter.
pub fn renderer() -> Renderer {
    Renderer::new(Gpu::headless(None).unwrap()).unwrap()
}

/// A renderer on the first adapter, with tiles and texels of probes as they are where adapters are no software: half floats,
/// of which probes are loaded and not filtered.
pub fn half_float_renderer() -> Renderer {
    let mut gpu = Gpu::headless(None).unwrap();
    gpu.capabilities.tiles_format = wgpu::TextureFormat::Rgba16Float;
    gpu.capabilities.filters_exactly = false;
    Renderer::new(gpu).unwrap()
}

/// A renderer on the software adapter, which all machines have in nearly the same form; on the first adapter, with a
/// message, where there is none.
pub fn software_renderer() -> Renderer {
    let software = Gpu::adapters().into_iter().find(|adapter| adapter.device_type == "Software");
    if software.is_none() {
        eprintln!("NOTE: there is no software adapter; pictures may differ more");
    }
    Renderer::new(Gpu::headless(software.as_ref().map(|adapter| adapter.name.as_str())).unwrap()).unwrap()
}

/// The scene's first camera, no environment, no shadows, nothing that is found in the picture, black behind, no tone
/// curve, no dither; radiance can be read.
pub fn plain_request(scene: &Scene, (width, height): (u32, u32)) -> FrameRequest {
    let node = scene.nodes.iter().find(|node| node.camera.is_some()).unwrap();
    let projection = scene.cameras[node.camera.unwrap()].projection;
    let mut request = FrameRequest::new(width, height, View { world_from_view: node.world_from_object, projection });
    request.settings.environment.source = Environment::None;
    request.settings.background.source = Background::Color([0.0; 3]);
    request.settings.tone_map.curve = Tonemap::None;
    request.settings.tone_map.dither = 0.0;
    request.settings.shadows.enabled = false;
    request.settings.occlusion.enabled = Switch::Off;
    request.settings.reflections.enabled = Switch::Off;
    request.averaging = Averaging::Both;
    request
}

/// White and matte, with nothing that it mirrors.
pub fn matte_white() -> Material {
    Material {
        base_color_factor: Vec4::ONE,
        metallic_factor: 0.0,
        roughness_factor: 1.0,
        specular: Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() }),
        ..Material::default()
    }
}

/// A camera that sees all of `bounds` from the right and above.
pub fn framed(bounds: &Aabb) -> View {
    let radius_m = bounds.corners().iter().map(|c| c.distance(bounds.center())).fold(1e-4, f32::max);
    let rotation = Quat::from_rotation_y(0.5) * Quat::from_rotation_x(-0.35);
    let fov_y_rad = 0.7f32;
    let distance_m = radius_m / (0.5 * fov_y_rad).sin();
    let eye = bounds.center() + rotation * Vec3::Z * distance_m;
    let projection = Projection::Perspective { fov_y_rad, near_m: 1e-3 * distance_m, far_m: None };
    View { world_from_view: Mat4::from_rotation_translation(rotation, eye), projection }
}

/// Radiance of one frame, red, green and blue.
pub fn radiance(scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    let mut renderer = renderer();
    renderer.load(scene).unwrap();
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

/// Writes pictures side by side where `MANYPASS_LOOK` names a folder.
pub fn look(name: &str, pictures: &[&[[f32; 3]]], (width, height): (u32, u32)) {
    let Some(folder) = std::env::var_os("MANYPASS_LOOK") else { return };
    let encode = |value: f32| (value.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
    let count = pictures.len() as u32;
    let sheet = image::ImageBuffer::from_fn(width * count, height, |x, y| {
        let pixel = pictures[(x / width) as usize][(y * width + x % width) as usize];
        image::Rgba([encode(pixel[0]), encode(pixel[1]), encode(pixel[2]), 255])
    });
    sheet.save(std::path::Path::new(&folder).join(format!("{name}.png"))).unwrap();
}

/// The folder of the sample models; none where they are not on this machine: the test is skipped.
pub fn sample_models() -> Option<PathBuf> {
    manypass_testkit::needs::assets("khronos-sample-assets")
}

/// Pixels whose neighbours all show the same object; at silhouettes triangles and exact shapes differ by a pixel.
pub fn inner_pixels(ids: &[u32], (width, height): (usize, usize)) -> Vec<usize> {
    let mut inner = Vec::new();
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let at = y * width + x;
            let same =
                |dx: isize, dy: isize| ids[(y as isize + dy) as usize * width + (x as isize + dx) as usize] == ids[at];
            if (-1..=1).all(|dy| (-1..=1).all(|dx| same(dx, dy))) {
                inner.push(at);
            }
        }
    }
    inner
}

/// The values of a variable that is made of floats.
pub fn floats(aov: AovPixels) -> Vec<f32> {
    match aov {
        AovPixels::Float { data, .. } => data,
        AovPixels::Id(_) => panic!("ids are not floats"),
    }
}

/// The values of a variable that is made of ids.
pub fn ids(aov: AovPixels) -> Vec<u32> {
    match aov {
        AovPixels::Id(ids) => ids,
        AovPixels::Float { .. } => panic!("floats are not ids"),
    }
}

/// The folder of the effects that docs/samples.md shows.
pub fn samples() -> PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/examples/effects")
}

/// The names of those effects, in their order.
pub fn sample_names() -> Vec<String> {
    let files = std::fs::read_dir(samples()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = files.filter_map(|file| file.strip_suffix(".wgsl").map(str::to_owned)).collect();
    names.sort_unstable();
    names
}

/// The text of one of them, parsed.
pub fn sample(name: &str) -> manypass::EffectFile {
    let text = std::fs::read_to_string(samples().join(format!("{name}.wgsl"))).unwrap();
    manypass::EffectFile::parse(name, &text).unwrap_or_else(|error| panic!("{error}"))
}

/// As [`built_in_with`], of one of them.
pub fn sample_with(renderer: &Renderer, name: &str, settings: &[&str]) -> std::sync::Arc<manypass::WgslEffect> {
    let effect = manypass::WgslEffect::compile(renderer.gpu(), sample(name)).unwrap();
    for setting in settings {
        let (key, value) = setting.split_once('=').expect("KEY=VALUE");
        effect.set(&format!("{name}.{key}"), value).unwrap();
    }
    effect.into()
}

/// A built-in effect on the renderer's device, with settings `KEY=VALUE` without the effect's name.
pub fn built_in_with(renderer: &Renderer, name: &str, settings: &[&str]) -> std::sync::Arc<manypass::WgslEffect> {
    let effect = built_in(renderer, name);
    for setting in settings {
        let (key, value) = setting.split_once('=').expect("KEY=VALUE");
        effect.set(&format!("{name}.{key}"), value).unwrap();
    }
    effect
}

/// A built-in effect on the renderer's device.
pub fn built_in(renderer: &Renderer, name: &str) -> std::sync::Arc<manypass::WgslEffect> {
    let file = manypass::EffectFile::built_in(name).expect("a name of the library").expect("a valid text");
    std::sync::Arc::new(manypass::WgslEffect::compile(renderer.gpu(), file).unwrap())
}
