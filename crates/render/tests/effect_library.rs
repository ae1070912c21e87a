//! Properties of the built-in effects that need a scene: what each must do, and what it must leave alone.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::{built_in_with as with, renderer};
use glam::Vec3;
use manypass::scene::primitives::{cube, plane};
use manypass::scene::{Material, Mesh, Node, Primitive, Projection, Scene, ShadingModel};
use manypass::{Averaging, Background, Environment, FrameRequest, Renderer, Tonemap, View, WgslEffect};
use std::sync::Arc;

fn put(scene: &mut Scene, mut primitive: Primitive, color: Vec3, translation: Vec3) {
    primitive.material = Some(scene.materials.len());
    let base_color_factor = color.extend(1.0);
    scene.materials.push(Material { base_color_factor, shading_model: ShadingModel::Unlit, ..Material::default() });
    let mesh = Some(scene.meshes.len());
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh, translation, ..Node::default() });
}

fn request(
    scene: &mut Scene,
    (width, height): (u32, u32),
    eye: Vec3,
    target: Vec3,
    projection: Projection,
) -> FrameRequest {
    scene.update_transforms();
    let world_from_view = glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y).inverse();
    let mut request = FrameRequest::new(width, height, View { world_from_view, projection });
    request.settings.environment.source = Environment::None;
    request.settings.background.source = Background::Color([0.0; 3]);
    request.settings.tone_map.curve = Tonemap::None;
    request.settings.tone_map.dither = 0.0;
    request.settings.shadows.enabled = false;
    request.averaging = Averaging::Both;
    request
}

fn perspective(fov_y_deg: f32) -> Projection {
    Projection::Perspective { fov_y_rad: fov_y_deg.to_radians(), near_m: 0.01, far_m: None }
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 4]> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().as_chunks().0.to_vec()
}

/// An effect that makes every pixel of this radiance.
fn flat(renderer: &Renderer, color: Vec3) -> Arc<WgslEffect> {
    let [r, g, b] = color.to_array();
    let source = format!("@fragment fn fs() -> @location(0) vec4f {{ return vec4f({r:?}, {g:?}, {b:?}, 1.0); }}");
    Arc::new(WgslEffect::new(renderer.gpu(), "flat.wgsl", &source).unwrap())
}

/// Nothing at all, and a camera.
fn nothing(size: (u32, u32)) -> (Scene, FrameRequest) {
    let mut scene = Scene::default();
    let request = request(&mut scene, size, Vec3::Z, Vec3::ZERO, perspective(45.0));
    (scene, request)
}

/// Linear Rec. 709 of a black body of luminance 1: chromaticities by Kim et al. 2002, which owe nothing to the effect.
fn black_body(kelvin: f64) -> Vec3 {
    let of = |c: [f64; 4], t: f64| c[0] * t.powi(3) + c[1] * t.powi(2) + c[2] * t + c[3];
    let t = 1000.0 / kelvin;
    let low = [-0.2661239, -0.2343589, 0.8776956, 0.179910];
    let x = of(if kelvin < 4000.0 { low } else { [-3.0258469, 2.1070379, 0.2226347, 0.240390] }, t);
    let y = if kelvin < 2222.0 {
        of([-1.1063814, -1.34811020, 2.18555832, -0.20219683], x)
    } else if kelvin < 4000.0 {
        of([-0.9549476, -1.37418593, 2.09137015, -0.16748867], x)
    } else {
        of([3.0817580, -5.87338670, 3.75112997, -0.37001483], x)
    };
    let [x, y, z] = [x / y, 1.0, (1.0 - x - y) / y];
    let rgb = [
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    ];
    Vec3::from(rgb.map(|c| c as f32))
}

#[test]
fn grading_makes_the_chosen_light_white_and_does_its_arithmetic_on_light() {
    let mut renderer = renderer();
    let (scene, mut request) = nothing((4, 4));
    renderer.load(&scene).unwrap();
    let mut graded = |color: Vec3, settings: &[&str]| {
        request.effects = vec![flat(&renderer, color), with(&renderer, "grade", settings)];
        Vec3::from_slice(&radiance(&mut renderer, &scene, &request)[5][..3])
    };
    let white = black_body(6500.0);
    for kelvin in [2000.0, 3000.0, 4500.0, 6500.0, 9000.0, 14000.0] {
        let found = graded(0.5 * black_body(kelvin), &[&format!("temperature_k={kelvin}")]);
        let off = (found / (0.5 * white) - 1.0).abs().max_element();
        assert!(off < 0.02, "{kelvin} K: {found} instead of {}", 0.5 * white);
    }
    // Greenish light is made white by purple, and only its colour changes.
    let green = graded(Vec3::splat(0.5), &["tint=20"]);
    assert!(green.y < 0.47 && green.x > 0.5 && green.z > 0.5, "{green}");
    let color = Vec3::new(0.1, 0.4, 3.0);
    let close = |found: Vec3, expected: Vec3| {
        assert!((found - expected).abs().max_element() < 0.004 * expected.max_element(), "{found}: {expected}");
    };
    close(graded(color, &[]), color);
    close(graded(color, &["gain=2,1,0.5", "lift=0.1,0,-0.1"]), Vec3::new(0.3, 0.4, 1.4));
    close(graded(color, &["gamma=2,1,0.5"]), Vec3::new(0.1f32.sqrt(), 0.4, 9.0));
    close(graded(color, &["contrast=2"]), color * color / 0.18);
    close(graded(color, &["contrast=0"]), Vec3::splat(0.18));
    let grey = color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    close(graded(color, &["saturation=0"]), Vec3::splat(grey));
    close(graded(color, &["saturation=0.5"]), 0.5 * (color + grey));
    // What is darker than nothing is black, and what is brighter than half floats hold is as bright as they hold.
    close(graded(color, &["lift=-1,-1,0"]), Vec3::new(0.0, 0.0, 3.0));
    let bright = graded(Vec3::splat(60_000.0), &["gain=16,16,16", "contrast=4"]);
    assert!(bright.is_finite() && bright.min_element() > 20_000.0, "{bright}");
}

/// How many pixels differ from `plain`, of those that `is_asked`.
fn changed(found: &[[f32; 4]], plain: &[[f32; 4]], is_asked: impl Fn(usize) -> bool) -> usize {
    found.iter().zip(plain).enumerate().filter(|(at, (a, b))| is_asked(*at) && a != b).count()
}

#[test]
fn outlines_are_where_something_ends_and_not_on_oblique_planes() {
    let mut renderer = renderer();
    let (width, height) = (96u32, 64u32);
    // A floor seen from 1 to 60 degrees above it, as far as one can see, by both kinds of cameras.
    let mut scene = Scene::default();
    put(&mut scene, plane(2000.0), Vec3::splat(0.5), Vec3::ZERO);
    for (elevation_deg, projection) in [
        (1.0, perspective(50.0)),
        (5.0, perspective(90.0)),
        (30.0, perspective(50.0)),
        (60.0, perspective(50.0)),
        (4.0, Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 1000.0 }),
    ] {
        let elevation = f32::to_radians(elevation_deg);
        let eye = 10.0 * Vec3::new(0.3 * elevation.cos(), elevation.sin(), elevation.cos());
        let mut request = request(&mut scene, (width, height), eye, Vec3::ZERO, projection);
        renderer.load(&scene).unwrap();
        let plain = radiance(&mut renderer, &scene, &request);
        request.effects = vec![with(&renderer, "outline", &["color=5,0,0", "width_px=1"])];
        let found = radiance(&mut renderer, &scene, &request);
        // Only near the horizon, which is the floor's end, there may be a line.
        let row = width as usize;
        let is_floor = |at: usize| {
            let first = at.saturating_sub(3 * row);
            plain[first..(at + 3 * row).min(plain.len())].iter().all(|pixel| pixel[0] > 0.4)
        };
        let asked = (0..plain.len()).filter(|at| is_floor(*at)).count();
        assert!(asked > plain.len() / 4, "{elevation_deg}°: {asked}");
        assert_eq!(changed(&found, &plain, is_floor), 0, "{elevation_deg}°");
    }
    // A cube on the floor, seen so that three faces show: its sides, and the creases between them, have lines of the width
    // asked for.
    put(&mut scene, cube(Vec3::splat(2.0)), Vec3::splat(0.5), Vec3::new(0.0, 1.0, 0.0));
    let mut request =
        request(&mut scene, (width, height), Vec3::new(4.0, 4.0, 4.0), Vec3::new(0.0, 1.0, 0.0), perspective(50.0));
    renderer.load(&scene).unwrap();
    let covered = |renderer: &mut Renderer, request: &mut FrameRequest, settings: &[&str]| -> f32 {
        request.effects = vec![with(renderer, "outline", settings)];
        let found = radiance(renderer, &scene, request);
        // Along a row that meets both sides and the crease between them.
        found[35 * width as usize..][..width as usize].iter().map(|pixel| (pixel[0] - 0.5) / 4.5).sum()
    };
    for width_px in [1.0f32, 2.0, 4.0] {
        let settings = [format!("width_px={width_px}"), "color=5,0,0".into()];
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let below = covered(&mut renderer, &mut request, &settings);
        assert!((below / (3.0 * width_px) - 1.0).abs() < 0.25, "{below} of three lines of {width_px} px");
        let sides = covered(&mut renderer, &mut request, &[&settings[..], &["crease_deg=180"]].concat());
        assert!((sides / (2.0 * width_px) - 1.0).abs() < 0.25, "{sides} of two lines of {width_px} px");
    }
    assert!(covered(&mut renderer, &mut request, &["color=5,0,0", "width_px=0"]).abs() < 0.01);
}

#[test]
fn toon_light_has_few_steps_and_keeps_hues() {
    let mut renderer = renderer();
    let mut scene = Scene::default();
    put(&mut scene, plane(200.0), Vec3::new(0.8, 0.4, 0.2), Vec3::ZERO);
    let mut request = request(&mut scene, (128, 8), Vec3::Y * 5.0, Vec3::new(0.0, 0.0, 0.01), perspective(40.0));
    renderer.load(&scene).unwrap();
    // Light from dark to bright from left to right, on one surface.
    let ramp = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
        return vec4f(vec3f(0.8, 0.4, 0.2) * exp2(p.x / 12.0 - 7.0), 1.0);
    }";
    let ramp = Arc::new(WgslEffect::new(renderer.gpu(), "ramp.wgsl", ramp).unwrap());
    for steps in [2usize, 4, 7] {
        let settings = [format!("steps={steps}"), "softness=0.1".into(), "saturation=1".into(), "smooth_px=2".into()];
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        request.effects = vec![ramp.clone(), with(&renderer, "toon", &settings)];
        let found = radiance(&mut renderer, &scene, &request);
        let row = &found[4 * 128..5 * 128];
        for pixel in row {
            assert!((pixel[0] / pixel[1] - 2.0).abs() < 0.01 && (pixel[1] / pixel[2] - 2.0).abs() < 0.01, "{pixel:?}");
        }
        assert!(row.is_sorted_by(|a, b| a[0] <= 1.001 * b[0]), "more light is never darker");
        let is_flat = |pair: &&[[f32; 4]]| (pair[1][0] / pair[0][0] - 1.0).abs() < 0.002;
        let mut levels: Vec<f32> = row.windows(2).filter(is_flat).map(|pair| pair[0][0]).collect();
        assert!(levels.len() * 10 > row.len() * 7, "{steps} steps: {} pixels are as the next", levels.len());
        levels.dedup_by(|a, b| (*a / *b - 1.0).abs() < 0.01);
        assert_eq!(levels.len(), steps, "{levels:?}");
    }
    // What is no surface stays as it is.
    let (empty, mut request) = nothing((16, 8));
    renderer.load(&empty).unwrap();
    request.effects = vec![ramp.clone()];
    let plain = radiance(&mut renderer, &empty, &request);
    request.effects = vec![ramp, with(&renderer, "toon", &[]), with(&renderer, "outline", &[])];
    assert_eq!(radiance(&mut renderer, &empty, &request), plain);
}
