//! Glass before a background, a colour, two colours, nothing or an environment: what lies behind is multiplied by the
//! light that comes through, channel by channel. Right values are closed forms: nothing shines, so that the picture is
//! the background times the transmittance.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use glam::{Mat4, Vec3};
use manypass::scene::material::{DiffuseTransmission, Specular, TexturedFactor, Volume};
use manypass::scene::primitives::cube;
use manypass::scene::{AlphaMode, Material, Mesh, Node, Projection, Scene};
use manypass::{
    Averaging, Background, Environment, Exposure, FrameRequest, Ground, Path, Renderer, Switch, Tonemap, View,
};

const SIDE: usize = 32;

/// A pane that reflects nothing, so that its base colour alone is what comes through.
fn pane(color: [f32; 3]) -> Material {
    let [r, g, b] = color;
    Material {
        base_color_factor: [r, g, b, 1.0].into(),
        metallic_factor: 0.0,
        roughness_factor: 0.0,
        specular: Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() }),
        transmission: Some(TexturedFactor::new(1.0)),
        ..Material::default()
    }
}

fn volume() -> Option<Volume> {
    let attenuation_color = Vec3::new(0.5, 0.25, 0.9);
    Some(Volume { thickness: TexturedFactor::new(0.5), attenuation_distance_m: 0.5, attenuation_color })
}

const RED: [f32; 3] = [0.9, 0.2, 0.05];
const GREEN: [f32; 3] = [0.3, 0.8, 0.5];

/// What stands before the background, the nearest first; and what comes through all of it.
fn cases() -> Vec<(&'static str, Vec<Material>, [f32; 3])> {
    let covers = |color: [f32; 4]| Material {
        base_color_factor: color.into(),
        metallic_factor: 0.0,
        specular: Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() }),
        alpha_mode: AlphaMode::Blend,
        ..Material::default()
    };
    let half = |all: [f32; 3]| all.map(|share| 0.5 * share);
    let both = [0, 1, 2].map(|at| RED[at] * GREEN[at]);
    let through_volume = [0.5, 0.25, 0.9];
    let leaf = DiffuseTransmission { weight: TexturedFactor::new(1.0), color: TexturedFactor::new(Vec3::ONE) };
    vec![
        ("red", vec![pane(RED)], RED),
        ("grey", vec![pane([0.7; 3])], [0.7; 3]),
        ("rough", vec![Material { roughness_factor: 0.5, ..pane(RED) }], RED),
        ("half of light", vec![Material { transmission: Some(TexturedFactor::new(0.5)), ..pane(RED) }], half(RED)),
        ("volume", vec![Material { volume: volume(), ..pane([1.0; 3]) }], through_volume),
        ("dispersion", vec![Material { volume: volume(), dispersion: 1.0, ..pane([1.0; 3]) }], through_volume),
        (
            "half covered by alpha",
            vec![Material {
                alpha_mode: AlphaMode::Blend,
                base_color_factor: [RED[0], RED[1], RED[2], 0.5].into(),
                ..pane(RED)
            }],
            RED.map(|share| 0.5 + 0.5 * share),
        ),
        ("behind a veil", vec![covers([0.0, 0.0, 0.0, 0.5]), pane(RED)], half(RED)),
        ("red before green", vec![pane(RED), pane(GREEN)], both),
        ("green before red", vec![pane(GREEN), pane(RED)], both),
        (
            "before what is opaque",
            vec![pane(RED), Material { alpha_mode: AlphaMode::Opaque, ..covers([0.0, 0.0, 0.0, 1.0]) }],
            [0.0; 3],
        ),
        ("a leaf", vec![Material { transmission: None, diffuse_transmission: Some(leaf), ..pane(RED) }], [0.0; 3]),
    ]
}

fn scene(layers: &[Material]) -> Scene {
    let mut scene = Scene::default();
    for (at, material) in layers.iter().enumerate() {
        let mut primitive = cube(Vec3::new(1.2, 3.0, 0.02));
        primitive.material = Some(at);
        scene.materials.push(material.clone());
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        let translation = Vec3::new(-0.6, 0.0, -(at as f32));
        scene.add_node(None, Node { mesh: Some(at), translation, ..Node::default() });
    }
    scene.update_transforms();
    scene
}

fn request() -> FrameRequest {
    let projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 20.0 };
    let view = View { world_from_view: Mat4::from_translation(Vec3::Z * 5.0), projection };
    let mut request = FrameRequest::new(SIDE as u32, SIDE as u32, view);
    request.settings.environment.source = Environment::None;
    request.settings.ground.mode = Ground::None;
    request.settings.exposure.stops = Exposure::Stops(1.0);
    request.settings.tone_map.dither = 0.0;
    request.settings.occlusion.enabled = Switch::Off;
    request.settings.reflections.enabled = Switch::Off;
    request
}

/// The picture and the radiance in the middle of the pane, and in a place without it.
fn places(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> [([u8; 4], [f32; 4]); 2] {
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    let (display, radiance) = (renderer.read_display().unwrap(), renderer.read_radiance().unwrap());
    [SIDE / 4, 3 * SIDE / 4 + 4].map(|x| {
        let at = 4 * (SIDE / 2 * SIDE + x);
        (*display[at..].first_chunk().unwrap(), *radiance[at..].first_chunk().unwrap())
    })
}

fn linear(byte: u8) -> f32 {
    let c = f32::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn encoded(linear: f32) -> f32 {
    255.0 * if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// What a picture has over nothing: alpha lets the mean of the channels through, and it is right over white.
fn cut_out(through: [f32; 3]) -> ([f32; 3], f32) {
    let mean = through.iter().sum::<f32>() / 3.0;
    (through.map(|share| (share - mean).max(0.0)), 1.0 - mean)
}

fn check(renderer: &mut Renderer, what: &str, scene: &Scene, request: &FrameRequest, through: [f32; 3]) {
    for color in [[0xffu8, 0xff, 0xff], [0xe0, 0x80, 0x30]] {
        let behind = color.map(linear);
        let request = request.with(|settings| settings.background.source = Background::Color(behind));
        let [(seen, radiance), (beside, _)] = places(renderer, scene, &request);
        assert_eq!(beside[..3], color, "{what}: beside it there is the colour");
        for channel in 0..3 {
            let expected = behind[channel] * through[channel];
            let off = (f32::from(seen[channel]) - encoded(expected)).abs();
            assert!(off <= 1.5, "{what} over {color:?}: {seen:?}, channel {channel} is to be {}", encoded(expected));
            let off = (radiance[channel] - 0.5 * expected).abs();
            assert!(off < 2e-3, "{what} over {color:?}: radiance {radiance:?}, is to be {}", 0.5 * expected);
        }
        assert_eq!((seen[3], radiance[3]), (255, 1.0));
    }
    let gradient = Background::Gradient([[0x90, 0x98, 0xa0], [0xa0, 0x9c, 0x90]].map(|color| color.map(linear)));
    let before_gradient = request.with(|settings| settings.background.source = gradient);
    let [(seen, _), (beside, _)] = places(renderer, scene, &before_gradient);
    for channel in 0..3 {
        assert!((0x90..=0xa0).contains(&beside[channel]), "{what}: the middle of a gradient is {beside:?}");
        // What is beside it is itself rounded.
        let expected = encoded(linear(beside[channel]) * through[channel]);
        let off = (f32::from(seen[channel]) - expected).abs();
        assert!(off <= 2.0, "{what} over two colours: {seen:?}, channel {channel} is to be {expected}");
    }
    let request = request.with(|settings| settings.background.source = Background::Transparent);
    let [(seen, radiance), (beside, _)] = places(renderer, scene, &request);
    assert_eq!(beside[3], 0, "{what}: beside it there is nothing");
    let (own, alpha) = cut_out(through);
    assert!((f32::from(seen[3]) - 255.0 * alpha).abs() <= 1.5, "{what}: alpha of {seen:?} is to be {}", 255.0 * alpha);
    assert!((radiance[3] - alpha).abs() < 2e-3, "{what}: alpha of {radiance:?} is to be {alpha}");
    for channel in 0..3 {
        let expected = encoded(own[channel] / alpha);
        let off = (f32::from(seen[channel]) - expected).abs();
        assert!(off <= 2.0, "{what} over nothing: {seen:?}, channel {channel} is to be {expected}");
        assert!((radiance[channel] - 0.5 * own[channel]).abs() < 2e-3, "{what} over nothing: radiance {radiance:?}");
    }
}

/// The same before an environment, whose light glass that mirrors nothing shows nowhere else. Rays are parallel, so
/// that it has one radiance.
fn check_environments(renderer: &mut Renderer, what: &str, scene: &Scene, request: &FrameRequest, through: [f32; 3]) {
    for source in [Environment::Color([0.2, 0.3, 0.1]), Environment::Studio, Environment::Sky] {
        let request = request.with(|settings| {
            settings.environment.source = source;
            settings.background.source = Background::Environment;
        });
        let [(_, seen), (_, beside)] = places(renderer, scene, &request);
        assert!(beside[..3].iter().all(|value| *value > 1e-3), "{what}: {source:?} is dark, {beside:?}");
        for channel in 0..3 {
            let expected = beside[channel] * through[channel];
            let off = (seen[channel] - expected).abs();
            assert!(off < 4e-3 * beside[channel], "{what} before {source:?}: {seen:?} of {beside:?}, {through:?}");
        }
    }
}

#[test]
fn a_background_is_multiplied_by_what_comes_through_glass() {
    let mut renderer = renderer();
    for (what, layers, through) in cases() {
        let scene = scene(&layers);
        renderer.load(&scene).unwrap();
        for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
            for (sample_count, averaging) in [(1, Averaging::Radiance), (3, Averaging::Both), (2, Averaging::Radiance)]
            {
                let mut request = request();
                (request.settings.render.path, request.sample_count, request.averaging) =
                    (path, sample_count, averaging);
                let what = format!("{what}, {path:?}, {sample_count} samples, {averaging:?}");
                check(&mut renderer, &what, &scene, &request, through);
            }
            // Those two show diffuse light, too.
            if !["half of light", "a leaf"].contains(&what) && matches!(path, Path::Deferred | Path::Forward) {
                let mut request = request().with(|settings| settings.render.path = path);
                request.averaging = Averaging::Radiance;
                check_environments(&mut renderer, &format!("{what}, {path:?}"), &scene, &request, through);
            }
        }
    }
}

/// Every curve leaves the background as it is, and so does glass; also where the picture has another size than the
/// frame, and where pixels have several samples.
#[test]
fn glass_leaves_a_background_its_colour_under_every_curve_and_at_every_size() {
    let mut renderer = renderer();
    let scene = scene(&[pane(RED)]);
    renderer.load(&scene).unwrap();
    for curve in [Tonemap::Neutral, Tonemap::Aces, Tonemap::Agx, Tonemap::Reinhard, Tonemap::Exponential] {
        let mut request = request();
        (request.settings.tone_map.curve, request.averaging) = (curve, Averaging::Radiance);
        check(&mut renderer, &format!("{curve:?}"), &scene, &request, RED);
    }
    for sample_count in [1, 2] {
        let mut request = request();
        (request.settings.render.scale, request.sample_count, request.averaging) = (0.5, sample_count, Averaging::Both);
        check(&mut renderer, &format!("half the size, {sample_count} samples"), &scene, &request, RED);
    }
    let mut request = request();
    request.settings.render.path = Path::Forward;
    request.settings.msaa.samples = manypass::PixelSamples::Four;
    request.averaging = Averaging::Radiance;
    check(&mut renderer, "four samples a pixel", &scene, &request, RED);
}
