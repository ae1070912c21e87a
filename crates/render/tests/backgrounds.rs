//! What lies behind surfaces: a colour, nothing, or the studio's backdrop.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use glam::{Mat4, Quat, Vec3};
use manypass::scene::primitives::{cube, torus};
use manypass::scene::{AlphaMode, Material, Mesh, Node, Primitive, Projection, Scene};
use manypass::{Averaging, Background, Environment, Exposure, FrameRequest, Ground, Renderer, Tonemap, View};

const SIDE: usize = 96;

fn put(scene: &mut Scene, mut primitive: Primitive, color: [f32; 4], translation: Vec3) {
    primitive.material = Some(scene.materials.len());
    let alpha_mode = if color[3] < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
    scene.materials.push(Material {
        base_color_factor: color.into(),
        metallic_factor: 0.0,
        roughness_factor: 0.4,
        alpha_mode,
        double_sided: true,
        ..Material::default()
    });
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), translation, ..Node::default() });
}

/// A ring with panes of 0.03, 0.2 and 0.6 alpha before it, before one another and before nothing.
fn panes() -> Scene {
    let mut scene = Scene::default();
    put(&mut scene, torus(0.8, 0.25, 48, 24), [0.9, 0.7, 0.5, 1.0], Vec3::ZERO);
    for (alpha, x, color) in [(0.03, -0.7, [1.0; 3]), (0.2, 0.0, [0.1, 0.9, 0.2]), (0.6, 0.7, [0.2, 0.2, 1.0])] {
        let [r, g, b] = color;
        put(&mut scene, cube(Vec3::new(0.9, 1.9, 0.02)), [r, g, b, alpha], Vec3::new(x, 0.1, 1.0 + 0.1 * x));
    }
    scene.update_transforms();
    scene
}

fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[u8; 4]> {
    let mut request = FrameRequest { sample_count: 4, ..request.clone() };
    for sample_index in 0..4 {
        request.sample_index = sample_index;
        renderer.render(scene, &request).unwrap();
    }
    renderer.read_display().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

fn linear(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn encoded(linear: f64) -> f64 {
    255.0 * if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn a_background_colour_is_that_colour_and_edges_are_composited_over_it() {
    let scene = panes();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = FrameRequest::of_scene(&scene, SIDE as u32, SIDE as u32);
    request.settings.ground.mode = Ground::None;
    for (tonemap, stops) in [
        (Tonemap::Neutral, 0.0),
        (Tonemap::None, 1.0),
        (Tonemap::Aces, -2.0),
        (Tonemap::Agx, 0.0),
        (Tonemap::Reinhard, 3.0),
        (Tonemap::Exponential, 0.0),
    ] {
        (request.settings.tone_map.curve, request.settings.exposure.stops) = (tonemap, Exposure::Stops(stops));
        request.settings.background.source = Background::Transparent;
        let transparent = picture(&mut renderer, &scene, &request);
        for color in [[0xffu8, 0xff, 0xff], [0x33, 0x66, 0x99], [0, 0, 0], [1, 128, 254]] {
            request.settings.background.source = Background::Color(color.map(|byte| linear(byte) as f32));
            let over = picture(&mut renderer, &scene, &request);
            let (mut nothing, mut blended) = (0, 0);
            for (at, (found, cut)) in over.iter().zip(&transparent).enumerate() {
                assert_eq!(found[3], 255);
                if cut[3] == 0 {
                    assert_eq!(found[..3], color, "{tonemap:?}, pixel {at}: nothing is there");
                    nothing += 1;
                    continue;
                }
                blended += usize::from(cut[3] < 255);
                let alpha = f64::from(cut[3]) / 255.0;
                for channel in 0..3 {
                    let expected = encoded(alpha * linear(cut[channel]) + (1.0 - alpha) * linear(color[channel]));
                    let off = (f64::from(found[channel]) - expected.round()).abs();
                    assert!(off <= 1.0, "{tonemap:?} over {color:?}, pixel {at}: {found:?} for {cut:?}");
                }
            }
            assert!(nothing > 1000 && blended > 1000, "{nothing} {blended}");
        }
    }
}

#[test]
fn in_linear_outputs_a_background_colour_is_what_the_exposure_shows_so() {
    let scene = panes();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = FrameRequest::of_scene(&scene, SIDE as u32, SIDE as u32);
    request.settings.ground.mode = Ground::None;
    (request.averaging, request.settings.exposure.stops) = (Averaging::Radiance, Exposure::Stops(2.0));
    request.settings.background.source = Background::Transparent;
    picture(&mut renderer, &scene, &request);
    let transparent = renderer.read_radiance().unwrap();
    request.settings.background.source = Background::Color([0.8, 0.4, 0.0]);
    picture(&mut renderer, &scene, &request);
    for (over, cut) in renderer.read_radiance().unwrap().chunks_exact(4).zip(transparent.chunks_exact(4)) {
        for channel in 0..3 {
            let expected = cut[channel] + (1.0 - cut[3]) * [0.2, 0.1, 0.0][channel];
            assert!((over[channel] - expected).abs() < 1e-6, "{over:?} for {cut:?}");
        }
        assert_eq!(over[3], 1.0);
    }
}

#[test]
fn the_studio_is_a_calm_backdrop_from_every_side() {
    let scene = Scene::default();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None };
    let mut seen = |yaw_rad: f32, pitch_rad: f32, environment: Environment| {
        let rotation = Quat::from_rotation_y(yaw_rad) * Quat::from_rotation_x(-pitch_rad);
        let view = View { world_from_view: Mat4::from_rotation_translation(rotation, rotation * Vec3::Z), projection };
        let mut request = FrameRequest::new(SIDE as u32, SIDE as u32, view);
        request.settings.environment.source = environment;
        request.settings.tone_map.dither = 0.0;
        picture(&mut renderer, &scene, &request)
    };
    for (pitch_rad, environment) in
        [(0.35, Environment::Studio), (0.0, Environment::Studio), (-0.3, Environment::Fill), (0.6, Environment::Fill)]
    {
        let front = seen(0.0, pitch_rad, environment);
        for y in 0..SIDE {
            let row = &front[y * SIDE..(y + 1) * SIDE];
            let level = row[0][1];
            assert!(row.iter().all(|p| p[1].abs_diff(level) <= 1), "row {y} is no row of one level");
            assert!((1..200).contains(&level), "row {y}: {level}");
            let below = front[(y + 1).min(SIDE - 1) * SIDE][1];
            assert!(below <= level && level - below <= 3, "rows {y} and {}: {level}, {below}", y + 1);
        }
        assert!(front[0][1] > front[(SIDE - 1) * SIDE][1] + 10, "the backdrop has no depth");
        for yaw_rad in [0.7, 2.0, -2.6] {
            let turned = seen(yaw_rad, pitch_rad, environment);
            let same = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).all(|c| a[c].abs_diff(b[c]) <= 1);
            assert!(front.iter().zip(&turned).all(same), "at {yaw_rad} the backdrop differs");
        }
    }
    // Nothing and a colour are what they were.
    assert!(seen(0.3, 0.3, Environment::None).iter().all(|p| *p == [0, 0, 0, 255]));
    let grey = seen(0.3, 0.3, Environment::Color([0.5; 3]));
    assert!(grey.iter().all(|p| *p == grey[0]) && grey[0][0] > 100);
}
