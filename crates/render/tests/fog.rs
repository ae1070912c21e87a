//! Distance fog against its closed form, in linear light: over opaque surfaces, over blended ones, over the
//! environment.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use glam::{DVec3, Mat4, Vec3, Vec4};
use manypass::scene::primitives::cube;
use manypass::scene::{AlphaMode, Material, Mesh, Node, Projection, Scene, ShadingModel};
use manypass::settings::LinearColor;
use manypass::{Averaging, Background, Environment, FogMode, FrameRequest, Path, Renderer, Settings, Tonemap, View};

const SIZE: (u32, u32) = (64, 48);
const WALL: [f64; 3] = [0.9, 0.3, 0.1];
const PANE: [f64; 3] = [0.1, 0.8, 0.4];
const PANE_ALPHA: f64 = 0.6;
const FOG: [f64; 3] = [0.5, 0.6, 0.7];
const SKY: [f64; 3] = [0.2, 0.4, 0.8];
const FOV_Y: f64 = 1.0;
const HEIGHT_M: f64 = 6.0;

/// A wall 10 m ahead on the left, and a pane 4 m ahead above; what they show is their colour, whatever light there is.
fn scene() -> Scene {
    let mut scene = Scene::default();
    for (color, alpha, size, center) in [
        (WALL, 1.0, Vec3::new(100.0, 200.0, 1.0), Vec3::new(-50.0, 0.0, -10.5)),
        (PANE, PANE_ALPHA, Vec3::new(200.0, 100.0, 0.01), Vec3::new(0.0, 50.0, -4.005)),
    ] {
        let mut primitive = cube(size);
        primitive.material = Some(scene.materials.len());
        let [r, g, b] = color.map(|value| value as f32);
        scene.materials.push(Material {
            base_color_factor: Vec4::new(r, g, b, alpha as f32),
            shading_model: ShadingModel::Unlit,
            alpha_mode: if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque },
            ..Material::default()
        });
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        let node = Node { mesh: Some(scene.meshes.len() - 1), translation: center, ..Node::default() };
        scene.add_node(None, node);
    }
    scene.update_transforms();
    scene
}

fn request(is_orthographic: bool) -> FrameRequest {
    let projection = if is_orthographic {
        Projection::Orthographic { height_m: HEIGHT_M as f32, near_m: 0.1, far_m: 100.0 }
    } else {
        Projection::Perspective { fov_y_rad: FOV_Y as f32, near_m: 0.1, far_m: None }
    };
    let mut request = FrameRequest::new(SIZE.0, SIZE.1, View { world_from_view: Mat4::IDENTITY, projection });
    request.averaging = Averaging::Radiance;
    request.settings.environment.source = Environment::Color(SKY.map(|value| value as f32));
    request.settings.tone_map.curve = Tonemap::None;
    request.settings.fog.color = LinearColor(FOG.map(|value| value as f32));
    request
}

/// The share that comes through, written from the definition of each mode.
fn transmittance(settings: &Settings, distance_m: f64) -> f64 {
    let fog = &settings.fog;
    let (density, start, end) = (f64::from(fog.density_per_m), f64::from(fog.start_m), f64::from(fog.end_m));
    let beyond = (distance_m - start).max(0.0);
    match fog.mode {
        FogMode::None => 1.0,
        FogMode::Linear => ((end - distance_m) / (end - start)).clamp(0.0, 1.0),
        FogMode::Exponential => (-density * beyond).exp(),
        FogMode::ExponentialSquared => (-(density * beyond).powi(2)).exp(),
    }
}

/// The radiance and coverage of a pixel.
fn expected(request: &FrameRequest, (x, y): (u32, u32)) -> [f64; 4] {
    let (width, height) = (f64::from(SIZE.0), f64::from(SIZE.1));
    let ndc = [(f64::from(x) + 0.5) / width * 2.0 - 1.0, 1.0 - (f64::from(y) + 0.5) / height * 2.0];
    let is_orthographic = matches!(request.camera.projection, Projection::Orthographic { .. });
    let half_height = if is_orthographic { 0.5 * HEIGHT_M } else { (0.5 * FOV_Y).tan() };
    let plane = DVec3::new(ndc[0] * half_height * width / height, ndc[1] * half_height, -1.0);
    // The length of the ray to a plane so far ahead.
    let length_m = |ahead_m: f64| if is_orthographic { ahead_m } else { plane.length() * ahead_m };
    let settings = &request.settings;
    let seen = |color: [f64; 3], ahead_m: f64| {
        let through = transmittance(settings, length_m(ahead_m));
        [0, 1, 2].map(|c| color[c] * through + FOG[c] * (1.0 - through))
    };
    let hides_sky = settings.fog.background && settings.fog.mode != FogMode::None;
    let (behind, coverage) = match settings.background.source {
        _ if ndc[0] < 0.0 => (seen(WALL, 10.0), 1.0),
        Background::Environment => (if hides_sky { FOG } else { SKY }, 1.0),
        _ => ([0.0; 3], 0.0),
    };
    let alpha = if ndc[1] > 0.0 { PANE_ALPHA } else { 0.0 };
    let before = seen(PANE, 4.0);
    let [r, g, b] = [0, 1, 2].map(|c| before[c] * alpha + behind[c] * (1.0 - alpha));
    [r, g, b, alpha + coverage * (1.0 - alpha)]
}

fn check(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) {
    renderer.render(scene, request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    for (at, found) in (0..).zip(radiance.chunks_exact(4)) {
        let pixel = (at % SIZE.0, at / SIZE.0);
        let expected = expected(request, pixel);
        for (found, expected) in found.iter().zip(expected) {
            // Half floats have 11 bits, and are rounded at each of four passes.
            let off = (f64::from(*found) - expected).abs();
            assert!(off < 0.002 * expected.max(0.1), "{pixel:?}: {found:?}, not {expected:?}: {:?}", request.settings);
        }
    }
}

#[test]
fn fog_is_its_closed_form_on_both_paths() {
    let scene = scene();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for path in [Path::Deferred, Path::Forward] {
        for (mode, start_m, is_orthographic, background, hides_sky) in [
            (FogMode::None, 0.0, false, Background::Environment, true),
            (FogMode::Linear, 2.0, false, Background::Environment, false),
            (FogMode::Exponential, 0.0, false, Background::Transparent, true),
            (FogMode::Exponential, 5.0, false, Background::Environment, true),
            (FogMode::ExponentialSquared, 1.0, false, Background::Environment, false),
            (FogMode::Exponential, 0.0, true, Background::Transparent, false),
        ] {
            let mut request = request(is_orthographic);
            let settings = &mut request.settings;
            (settings.render.path, settings.background.source) = (path, background);
            (settings.fog.mode, settings.fog.start_m, settings.fog.background) = (mode, start_m, hides_sky);
            (settings.fog.density_per_m, settings.fog.end_m) = (0.12, 12.0);
            check(&mut renderer, &scene, &request);
        }
    }
}

#[test]
fn exposure_does_not_change_the_radiance_of_fog_and_a_frame_without_fog_has_no_pass_of_it() {
    let scene = scene();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = request(false);
    let passes = |renderer: &mut Renderer, request: &FrameRequest| {
        let plan = renderer.plan(&scene, request).unwrap().to_text();
        plan.lines().filter(|line| line.contains("fog")).count()
    };
    assert_eq!(passes(&mut renderer, &request), 0);
    request.settings.fog.mode = FogMode::Exponential;
    assert!(passes(&mut renderer, &request) > 0);
    // Eight stops of exposure, which the frame is given beforehand.
    request.settings.exposure.stops = manypass::Exposure::Stops(8.0);
    check(&mut renderer, &scene, &request);
}
