//! Metering, pre-exposure, the faint studio beside a scene's own lights, and what is averaged over the samples.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::Vec3;
use manypass::exposure::{MID_GREY, picture_level_stops};
use manypass::scene::primitives::cube;
use manypass::scene::{AlphaMode, Light, LightKind, Material, Mesh, Node, Scene};
use manypass::{
    Aov, Averaging, Background, Environment, Exposure, FrameRequest, Metering, Path, Renderer, Tonemap, WgslEffect,
};
use manypass_testkit::raycast::Options;
use manypass_testkit::scenes;

const SIZE: (u32, u32) = (96, 96);

/// A testkit scene with its lights so many stops stronger.
fn stronger(mut test: scenes::TestScene, stops: f32) -> scenes::TestScene {
    test.scene.lights.iter_mut().for_each(|light| light.intensity *= stops.exp2());
    test.world.lights.iter_mut().for_each(|light| light.intensity *= f64::from(stops).exp2());
    test
}

/// A renderer that has loaded `scene`, and a request for it as the command line makes it without flags.
fn default_request(renderer: &mut Renderer, scene: &Scene) -> FrameRequest {
    renderer.load(scene).unwrap();
    let mut request = FrameRequest::of_scene(scene, SIZE.0, SIZE.1);
    renderer.expose(scene, &mut request, Exposure::of_scene(scene)).unwrap();
    request
}

fn accumulate(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) {
    let mut request = FrameRequest { sample_count: samples, ..request.clone() };
    for sample_index in 0..samples {
        request.sample_index = sample_index;
        renderer.render(scene, &request).unwrap();
    }
}

fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<[u8; 4]> {
    accumulate(renderer, scene, request, samples);
    renderer.read_display().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

/// The log-average luminance of all that the ray caster sees, with the weights that metering states.
fn log_average(pixels: &[[f32; 3]]) -> f64 {
    let luminances: Vec<f64> = pixels
        .iter()
        .map(|[r, g, b]| 0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b))
        .filter(|luminance| *luminance > 0.0)
        .collect();
    let mean = luminances.iter().sum::<f64>() / luminances.len() as f64;
    let weight = |luminance: f64| luminance / (luminance + mean / 64.0);
    let weights: f64 = luminances.iter().map(|l| weight(*l)).sum();
    (luminances.iter().map(|l| weight(*l) * l.log2()).sum::<f64>() / weights).exp2()
}

#[test]
fn metering_agrees_with_the_ray_caster_at_every_strength() {
    let mut renderer = renderer();
    let mut last: Option<(f64, f64)> = None;
    for stops in [-40.0, -12.0, -3.0, 0.0, 1.0, 4.0, 13.0, 22.0, 60.0] {
        let test = stronger(scenes::one_light_on_one_plane(), stops);
        let truth = log_average(&test.world.render(96, 96, Options::default()).radiance);
        let request = default_request(&mut renderer, &test.scene);
        let metering = request.metering.unwrap();
        let found = metering.log_average_luminance.unwrap();
        assert!((found / truth).log2().abs() < 0.02, "{stops} stops: {found}, the ray caster has {truth}");
        // What is stated: nothing within 2 stops of grey, and beyond that the curve.
        let level = (found / MID_GREY).log2();
        assert!((f64::from(request.exposure_stops()) - (picture_level_stops(level) - level)).abs() < 1e-4);
        assert!(level.abs() > 0.5 || request.exposure_stops() == 0.0);
        // More light is a brighter picture, and no picture is white or black.
        let pixels = picture(&mut renderer, &test.scene, &request, 1);
        let mean = pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / pixels.len() as f64;
        assert!((25.0..240.0).contains(&mean), "{stops} stops: the picture's mean is {mean}");
        if let Some((last_stops, last_mean)) = last {
            assert!(mean >= last_mean - 0.05, "{last_stops} to {stops} stops: {last_mean} to {mean}");
        }
        last = Some((stops.into(), mean));
    }
}

#[test]
fn metering_does_not_depend_on_the_size_or_on_what_was_drawn() {
    let mut renderer = renderer();
    let test = stronger(scenes::rows_of_spheres(), 9.0);
    renderer.load(&test.scene).unwrap();
    let mut meter = |width, height| {
        let request = FrameRequest::of_scene(&test.scene, width, height);
        renderer.meter(&test.scene, &request).unwrap()
    };
    let first = meter(1280, 720);
    assert_eq!([meter(64, 36), meter(3840, 2160)], [first; 2]);
    // Metering leaves the last picture as it was.
    let request = FrameRequest { want_aovs: vec![Aov::Depth], ..plain_request(&test.scene, SIZE) };
    renderer.render(&test.scene, &request).unwrap();
    let before = (renderer.read_display().unwrap(), renderer.read_radiance().unwrap(), renderer.stats().draws);
    renderer.meter(&test.scene, &FrameRequest::of_scene(&test.scene, 640, 360)).unwrap();
    let after = (renderer.read_display().unwrap(), renderer.read_radiance().unwrap(), renderer.stats().draws);
    assert_eq!(before, after);
    assert!(renderer.read_aov(Aov::Depth).is_ok());
}

#[test]
fn the_faint_studio_is_as_faint_beside_every_lamp() {
    // One face of the box turns away from the lamp: it shows the studio alone.
    let mut scene = Scene::default();
    let material = Material { base_color_factor: Vec3::splat(0.8).extend(1.0), ..matte() };
    put(&mut scene, material, Vec3::ZERO);
    scene.lights.push(Light {
        color_linear: Vec3::ONE,
        intensity: 1.0,
        range_m: None,
        kind: LightKind::Point,
        ..Light::default()
    });
    scene.add_node(None, Node { light: Some(0), translation: Vec3::new(-4.0, 0.5, 1.0), ..Node::default() });
    let mut renderer = renderer();
    let mut darkest = |intensity: f32, environment: Option<Environment>| {
        scene.lights[0].intensity = intensity;
        scene.update_transforms();
        renderer.load(&scene).unwrap();
        let mut request = FrameRequest::of_scene(&scene, SIZE.0, SIZE.1);
        assert_eq!(request.settings.environment.source, Environment::Fill);
        request.settings.environment.source = environment.unwrap_or(request.settings.environment.source);
        request.settings.background.source = Background::Transparent;
        renderer.expose(&scene, &mut request, Exposure::AUTO).unwrap();
        let pixels = picture(&mut renderer, &scene, &request, 1);
        pixels.iter().filter(|p| p[3] == 255).map(|p| p[1]).min().unwrap()
    };
    let faint = [0.3, 100.0, 1e6].map(|intensity| darkest(intensity, None));
    assert!(faint.iter().all(|level| (8..90).contains(level)), "{faint:?}");
    assert!(faint.iter().all(|level| level.abs_diff(faint[0]) <= 2), "{faint:?}");
    assert_eq!(darkest(1e6, Some(Environment::None)), 0, "without the studio that face is black");
    // A light that reaches nothing leaves the studio as it is.
    assert!(darkest(0.0, None) > faint[0] + 20);
    // What states its exposure is meant as it is.
    let stated = Scene { exposure_stops: Some(1.5), ..scenes::sun().scene };
    assert_eq!(
        (Environment::of_scene(&stated), Exposure::of_scene(&stated)),
        (Environment::None, Exposure::Stops(1.5))
    );
    let unlit = Scene::default();
    assert_eq!(
        (Environment::of_scene(&unlit), Exposure::of_scene(&unlit)),
        (Environment::Studio, Exposure::Stops(0.0))
    );
}

fn matte() -> Material {
    Material { metallic_factor: 0.0, roughness_factor: 0.9, ..Material::default() }
}

/// A cube of 1 m at `translation`.
fn put(scene: &mut Scene, material: Material, translation: Vec3) {
    let mut primitive = cube(Vec3::ONE);
    primitive.material = Some(scene.materials.len());
    scene.materials.push(material);
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), translation, ..Node::default() });
}

#[test]
fn radiance_of_bright_lights_is_not_clamped() {
    let mut renderer = renderer();
    for stops in [0.0, 20.0] {
        let test = stronger(scenes::one_light_on_one_plane(), stops);
        let truth = test.world.render(96, 96, Options::default()).radiance;
        renderer.load(&test.scene).unwrap();
        let mut request = FrameRequest { averaging: Averaging::Radiance, ..plain_request(&test.scene, SIZE) };
        // The exposure is a number; radiance is metered all the same.
        renderer.expose(&test.scene, &mut request, Exposure::Stops(3.0)).unwrap();
        renderer.render(&test.scene, &request).unwrap();
        let found = renderer.read_radiance().unwrap();
        let brightest = truth.iter().map(|p| p[1]).fold(0.0, f32::max);
        assert!(stops == 0.0 || brightest > 100_000.0, "half floats hold {brightest}");
        for (at, pixel) in truth.iter().enumerate() {
            assert!((found[at * 4 + 1] / pixel[1] - 1.0).abs() < 0.02, "{at}: {} {}", found[at * 4 + 1], pixel[1]);
        }
        assert_eq!(renderer.clamped_pixels(), 0);
    }
    // Without metering it is clamped, and counted; the mean of several samples counts a pixel once.
    let test = stronger(scenes::one_light_on_one_plane(), 20.0);
    let request = FrameRequest { averaging: Averaging::Radiance, ..plain_request(&test.scene, SIZE) };
    renderer.load(&test.scene).unwrap();
    accumulate(&mut renderer, &test.scene, &request, 3);
    let radiance = renderer.read_radiance().unwrap();
    let clamped = radiance.chunks_exact(4).filter(|p| p[1] >= 20_900.0).count() as u64;
    assert!(clamped > 1000 && renderer.clamped_pixels() >= clamped, "{clamped} {}", renderer.clamped_pixels());
    assert!(radiance.chunks_exact(4).all(|p| p[3] == 1.0), "the mark is not in the alpha that is read");
}

#[test]
fn whatever_the_strength_every_number_is_finite() {
    let mut renderer = renderer();
    for (intensity, emissive) in [(f32::MAX, 0.0), (f32::INFINITY, f32::MAX), (1e30, 1e38), (f32::MIN_POSITIVE, 0.0)] {
        let mut test = scenes::rows_of_spheres();
        for (i, light) in test.scene.lights.iter_mut().enumerate() {
            light.intensity = intensity;
            light.color_linear = [Vec3::X, Vec3::ONE, Vec3::Z][i % 3];
        }
        test.scene.materials[0].emissive_factor = Vec3::new(emissive, 0.0, 1.0);
        test.scene.materials[1].emissive_factor = Vec3::splat(emissive);
        for averaging in [Averaging::Display, Averaging::Radiance] {
            renderer.load(&test.scene).unwrap();
            let mut request = FrameRequest { averaging, ..plain_request(&test.scene, (64, 48)) };
            renderer.expose(&test.scene, &mut request, Exposure::AUTO).unwrap();
            assert!(request.exposure_stops().is_finite(), "{intensity}: {:?}", request.metering);
            accumulate(&mut renderer, &test.scene, &request, 2);
            if averaging == Averaging::Radiance {
                let radiance = renderer.read_radiance().unwrap();
                assert!(radiance.iter().all(|value| value.is_finite() && *value >= 0.0), "{intensity} {emissive}");
            }
        }
    }
}

#[test]
fn whatever_the_environment_every_number_is_finite() {
    let mut renderer = renderer();
    let test = scenes::rows_of_spheres();
    renderer.load(&test.scene).unwrap();
    let (max, inf, nan) = (f32::MAX, f32::INFINITY, f32::NAN);
    for (environment, intensity) in [
        (Environment::Color([1.0, 0.0, 0.5]), inf),
        (Environment::Color([max, 0.0, 1.0]), max),
        (Environment::Color([inf, 0.0, -inf]), 0.0),
        (Environment::Color([nan, 0.0, 1.0]), 1.0),
        (Environment::Studio, inf),
        (Environment::Studio, nan),
    ] {
        for path in [Path::Deferred, Path::Forward] {
            for metering in [None, Some(Metering { pre_exposure_stops: 100, ..Metering::default() })] {
                let mut request = plain_request(&test.scene, (32, 24));
                let settings = &mut request.settings;
                (settings.environment.source, settings.environment.intensity) = (environment, intensity);
                (settings.background.source, settings.render.path) = (Background::Environment, path);
                (request.averaging, request.metering) = (Averaging::Radiance, metering);
                let uniform = manypass::environment::EnvironmentUniform::new(environment, intensity, intensity);
                let numbers: &[f32] = bytemuck::cast_slice(bytemuck::bytes_of(&uniform));
                assert!(numbers.iter().all(|number| number.is_finite()), "{environment:?} {intensity}: {uniform:?}");
                renderer.render(&test.scene, &request).unwrap();
                let radiance = renderer.read_radiance().unwrap();
                let is_number = |value: &f32| value.is_finite() && *value >= 0.0;
                assert!(radiance.iter().all(is_number), "{environment:?} {intensity} {metering:?}");
            }
        }
    }
}

#[test]
fn the_sum_of_all_terms_at_their_limit_is_finite_and_counted() {
    // A half float ends at 65,504.
    const SUM_MAX: f32 = 3.0 * 20_992.0;
    let mut test = scenes::one_light_on_one_plane();
    test.scene.lights[0].intensity = 1e30;
    test.scene.materials[0].emissive_factor = Vec3::splat(1e30);
    let mut pane = matte();
    (pane.alpha_mode, pane.emissive_factor) = (AlphaMode::Blend, Vec3::splat(1e30));
    pane.base_color_factor.w = 0.5;
    let mut with_pane = test.clone();
    put(&mut with_pane.scene, pane, Vec3::Y);
    with_pane.scene.update_transforms();
    let mut renderer = renderer();
    for (scene, path) in [(&test, Path::Deferred), (&test, Path::Forward), (&with_pane, Path::Deferred)] {
        renderer.load(&scene.scene).unwrap();
        let mut request = plain_request(&scene.scene, (32, 32));
        (request.settings.render.path, request.averaging) = (path, Averaging::Radiance);
        let environment = &mut request.settings.environment;
        (environment.source, environment.intensity) = (Environment::Studio, 1e30);
        accumulate(&mut renderer, &scene.scene, &request, 2);
        let radiance = renderer.read_radiance().unwrap();
        let brightest = radiance.iter().copied().fold(0.0, f32::max);
        assert!(radiance.iter().all(|value| (0.0..=SUM_MAX).contains(value)), "{path:?}: {brightest}");
        assert!(brightest >= 20_900.0, "the test shows nothing: {brightest}");
        assert_eq!(renderer.clamped_pixels(), 32 * 32, "{path:?}");
    }
}

#[test]
fn what_is_no_number_is_scrubbed_and_counted_once() {
    let test = scenes::one_light_on_one_plane();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    // In the first sample alone one pixel in four is no number, and one is beyond half floats.
    let source = "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
        let here = radiance_at(vec2i(position.xy));
        let pixel = vec2u(position.xy) % 2u;
        let zero = here.a - 1.0;
        let wrong = select(1e9, zero / zero, pixel.y == 0u);
        return select(here, vec4f(wrong, 0.0, 0.0, 1.0), pixel.x == 0u && view.sample_index == 0u);
    }";
    let effect = std::sync::Arc::new(WgslEffect::new(renderer.gpu(), "wrong.wgsl", source).unwrap());
    for averaging in [Averaging::Radiance, Averaging::Display] {
        let mut request = plain_request(&test.scene, (16, 16));
        request.averaging = averaging;
        request.effects = vec![effect.clone()];
        let pixels = picture(&mut renderer, &test.scene, &request, 4);
        // Three right samples of four are seen; the fourth is no hole for good.
        assert!(pixels.iter().all(|pixel| pixel[1] > 20), "{averaging:?}");
        if averaging == Averaging::Radiance {
            let radiance = renderer.read_radiance().unwrap();
            assert!(radiance.iter().all(|value| value.is_finite() && *value >= 0.0));
            assert_eq!(renderer.clamped_pixels(), 16 * 16 / 2);
        }
    }
}

/// A glowing cube before black.
fn glowing(radiance: f32) -> Scene {
    let mut scene = Scene::default();
    put(&mut scene, Material { emissive_factor: Vec3::splat(radiance), ..matte() }, Vec3::ZERO);
    scene.update_transforms();
    scene
}

fn linear(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[test]
fn edges_of_bright_surfaces_are_smooth() {
    let scene = glowing(60.0);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request =
        FrameRequest::of_scene(&scene, SIZE.0, SIZE.1).with(|settings| settings.environment.source = Environment::None);
    request.settings.tone_map.dither = 0.0;
    request.settings.background.source = Background::Transparent;
    let coverage: Vec<f64> =
        picture(&mut renderer, &scene, &request, 16).iter().map(|p| f64::from(p[3]) / 255.0).collect();
    request.settings.background.source = Background::Color([0.0; 3]);
    for tonemap in [Tonemap::None, Tonemap::Neutral, Tonemap::Aces, Tonemap::Agx, Tonemap::Reinhard] {
        request.settings.tone_map.curve = tonemap;
        let pixels = picture(&mut renderer, &scene, &request, 16);
        let full = linear(pixels[(SIZE.1 / 2 * SIZE.0 + SIZE.0 / 2) as usize][1]);
        let mut partly = 0;
        for (pixel, coverage) in pixels.iter().zip(&coverage) {
            partly += usize::from(*coverage > 0.1 && *coverage < 0.9);
            // As much of the display's light as of the pixel is covered; the samples' mean would be white.
            assert!((linear(pixel[1]) - full * coverage).abs() < 0.01, "{tonemap:?}: {pixel:?} at {coverage}");
        }
        assert!(partly > 100, "{partly}");
    }
    // One sample is the curve of that sample, whatever is averaged.
    let display = picture(&mut renderer, &scene, &request, 1);
    request.averaging = Averaging::Both;
    assert_eq!(picture(&mut renderer, &scene, &request, 1), display);
}

#[test]
fn linear_outputs_are_the_mean_of_radiance() {
    let scene = glowing(60.0);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = FrameRequest::of_scene(&scene, SIZE.0, SIZE.1).with(|settings| {
        settings.environment.source = Environment::None;
        // Where radiance is averaged, no sample is left out.
        settings.adaptive.threshold = 0.0;
    });
    let display = picture(&mut renderer, &scene, &request, 8);
    assert!(renderer.read_radiance().is_err(), "nobody asked for radiance");
    let mut radiance = Vec::new();
    for averaging in [Averaging::Radiance, Averaging::Both] {
        let request = FrameRequest { averaging, ..request.clone() };
        let shown = picture(&mut renderer, &scene, &request, 8);
        assert_eq!(shown == display, averaging == Averaging::Both);
        radiance.push(renderer.read_radiance().unwrap());
    }
    assert_eq!(radiance[0], radiance[1]);
    // Wanting the variable is asking for it.
    let wanting = FrameRequest { want_aovs: vec![Aov::Radiance], ..request.clone() };
    assert_eq!(picture(&mut renderer, &scene, &wanting, 8), display);
    assert_eq!(renderer.read_radiance().unwrap(), radiance[0]);
    // At an edge it is the linear mean: eighths of 60.
    let eighths = |value: f32| (value * 8.0 / 60.0).round();
    let edges = radiance[0].chunks_exact(4).filter(|p| p[0] > 0.0 && p[0] < 59.0);
    let mut count = 0;
    for pixel in edges {
        assert!((pixel[0] - eighths(pixel[0]) * 7.5).abs() < 0.05, "{pixel:?}");
        count += 1;
    }
    assert!(count > 50, "{count}");
}

#[test]
fn an_auto_exposure_is_compensated_and_a_number_is_a_number() {
    let mut renderer = renderer();
    let test = stronger(scenes::sun(), 6.0);
    renderer.load(&test.scene).unwrap();
    let mut request = FrameRequest::of_scene(&test.scene, SIZE.0, SIZE.1);
    let mut stops = |exposure: &str| {
        renderer.expose(&test.scene, &mut request, exposure.parse().unwrap()).unwrap();
        request.exposure_stops()
    };
    let auto = stops("auto");
    assert!(auto < -1.0, "{auto}");
    assert_eq!([stops("auto+1"), stops("auto-0.5"), stops("-3")], [auto + 1.0, auto - 0.5, -3.0]);
    // A number shows radiance times its power of two: the same as without metering, where half floats hold it.
    request.settings.environment.source = Environment::None;
    request.settings.tone_map.dither = 0.0;
    let metered = picture(&mut renderer, &test.scene, &request, 1);
    let plain = FrameRequest { metering: None::<Metering>, ..request };
    assert_eq!(picture(&mut renderer, &test.scene, &plain, 1), metered);
}

#[test]
fn stops_beyond_all_measure_are_refused_and_in_code_leave_numbers() {
    let mut settings = manypass::Settings::default();
    for value in ["nan", "inf", "-inf", "1e30", "-1e30", "65", "auto+1e30", "auto+nan", "auto-inf", ""] {
        let error = settings.set("exposure.stops", value).unwrap_err().to_string();
        assert!(error.contains("exposure.stops") && error.contains("-64 to 64"), "{value}: {error}");
    }
    for value in ["0", "-64", "64", "auto+64"] {
        settings.set("exposure.stops", value).unwrap();
    }
    let test = scenes::one_light_on_one_plane();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    for (stops, expected) in [
        (1e30, Some(255)),
        (f32::INFINITY, Some(255)),
        (-1e30, Some(0)),
        (f32::NEG_INFINITY, Some(0)),
        (f32::NAN, None),
    ] {
        for exposure in [Exposure::Stops(stops), Exposure::Auto { compensation_stops: stops }] {
            for source in [Environment::None, Environment::Studio, Environment::Sky] {
                let mut request = plain_request(&test.scene, (16, 16));
                request.settings.environment.source = source;
                renderer.expose(&test.scene, &mut request, exposure).unwrap();
                let pixels = picture(&mut renderer, &test.scene, &request, 2);
                let radiance = renderer.read_radiance().unwrap();
                assert!(radiance.iter().all(|value| value.is_finite()), "{exposure:?} {source:?}");
                let found = pixels[8 * 16 + 8][1];
                assert!(expected.is_none_or(|expected| expected == found), "{exposure:?} {source:?}: {found}");
            }
        }
    }
}
