//! Exposure under the sky and in a picture: that of the environment, which surfaces move within bounds.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use glam::{Mat4, Vec3};
use manypass::exposure::{MID_GREY, picture_level_stops};
use manypass::{Environment, Exposure, FrameRequest, Metering, Renderer, View};
use manypass_scene::primitives::cube;
use manypass_scene::{EnvironmentLight, EnvironmentMap, Light, LightKind, Material, Mesh, Node, Projection, Scene};

/// A matte cube of 1 m in an environment.
fn cube_in(map: EnvironmentMap, base_color: Vec3) -> Scene {
    let mut scene = Scene { environment: Some(map.into()), ..Scene::default() };
    let base_color_factor = base_color.extend(1.0);
    let (metallic_factor, roughness_factor) = (0.0, 0.9);
    scene.materials.push(Material { base_color_factor, metallic_factor, roughness_factor, ..Material::default() });
    let mut primitive = cube(Vec3::ONE);
    primitive.material = Some(0);
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    scene
}

fn even(radiance: f32) -> EnvironmentMap {
    EnvironmentMap::from_fn("even", 64, 32, |_| Vec3::splat(radiance))
}

/// A sun behind the camera of a request for the whole model, in an even sky: a mean of 1.1.
fn sunny() -> EnvironmentMap {
    let direction = Vec3::new(0.5, 0.5, 0.7).normalize();
    let irradiance = Vec3::splat(4.0 * std::f32::consts::PI);
    EnvironmentMap { light: Some(EnvironmentLight { direction, irradiance, half_angle_tan: 0.005 }), ..even(0.1) }
}

/// A lamp of so many candela two metres before the cube.
fn with_lamp(mut scene: Scene, intensity: f32) -> Scene {
    scene.lights.push(Light { intensity, kind: LightKind::Point, ..Light::default() });
    scene.add_node(None, Node { light: Some(0), translation: Vec3::new(0.7, 0.8, 2.0), ..Node::default() });
    scene.update_transforms();
    scene
}

/// The exposure that nobody states, and what was metered for it.
fn exposed(renderer: &mut Renderer, scene: &Scene, mut request: FrameRequest) -> (f64, Metering) {
    renderer.load(scene).unwrap();
    renderer.expose(scene, &mut request, Exposure::Scene).unwrap();
    assert_eq!(request.settings.exposure.stops, Exposure::AUTO);
    (request.exposure_stops().into(), request.metering.unwrap())
}

fn whole(scene: &Scene) -> FrameRequest {
    FrameRequest::of_scene(scene, 64, 64)
}

/// The exposure of surfaces alone.
fn of_surfaces(metering: &Metering) -> f64 {
    let level = (metering.log_average_luminance.unwrap() / MID_GREY).log2();
    picture_level_stops(level) - level
}

#[test]
fn a_catalogue_in_one_picture_has_one_exposure_within_bounds() {
    let mut renderer = renderer();
    // A surface of 0.36 in a mean of 1.1 is 1.1375 stops above mid grey; of these the curve leaves 0.8893.
    let anchor = -0.2482;
    let mut found = Vec::new();
    for grey in [0.0, 0.03, 0.2126, 0.5, 0.95] {
        let scene = cube_in(sunny(), Vec3::splat(grey));
        let (stops, metering) = exposed(&mut renderer, &scene, whole(&scene));
        let difference = of_surfaces(&metering) - anchor;
        let expected = anchor + difference / (1.0 + 2.0 * difference.abs());
        let [unlowered, shown] = [expected, stops].map(|stops| metering.peak * stops.exp2());
        if unlowered < 1.0 {
            assert!((stops - expected).abs() < 2e-3, "{grey}: {stops}, not {expected}");
        } else {
            // The face that is turned to the sun comes to white; it is even but for a faint gloss.
            assert!(
                stops < expected + 2e-3 && (0.99..1.1).contains(&shown),
                "{grey}: {shown} at {stops} of {expected}"
            );
        }
        found.push((stops, metering.log_average_luminance.unwrap(), unlowered));
    }
    let (darkest, palest) = (found[0], found[4]);
    assert!(palest.1 / darkest.1 > 6.0, "the test shows nothing: {found:?}");
    assert!(found[2].2 < 1.0 && palest.2 > 1.4, "the test shows nothing: {found:?}");
    assert!(darkest.0 - palest.0 < 2.0 && darkest.0 > palest.0, "{found:?}");
    // Red as bright as a grey of 0.2126, whose largest component is nearly five times as much.
    for color in [Vec3::X, Vec3::Z] {
        let scene = cube_in(sunny(), color);
        let (stops, _) = exposed(&mut renderer, &scene, whole(&scene));
        assert!(stops < found[2].0 - 0.3 && stops >= anchor - 1.001, "{color}: {stops}, grey has {}", found[2].0);
    }
}

#[test]
fn what_fills_the_picture_is_exposed_by_itself() {
    let mut renderer = renderer();
    let scene = cube_in(even(0.01), Vec3::splat(0.5));
    let projection = Projection::Perspective { fov_y_rad: 0.4, near_m: 0.1, far_m: None };
    let near = View { world_from_view: Mat4::from_translation(Vec3::Z * 1.5), projection };
    let (stops, metering) = exposed(&mut renderer, &scene, FrameRequest::new(64, 64, near));
    assert!(metering.surface_share > 0.999, "{metering:?}");
    assert!((stops - of_surfaces(&metering)).abs() < 1e-4, "{stops}: {metering:?}");
    // A spot is what it meters, whatever is around it.
    let spot = whole(&scene).with(|settings| settings.exposure.metering = manypass::MeteringPattern::Spot);
    let (stops, metering) = exposed(&mut renderer, &scene, spot);
    assert!((stops - of_surfaces(&metering)).abs() < 1e-4, "{stops}: {metering:?}");
}

#[test]
fn lamps_darken_the_day_as_highlights_do_and_are_metered_at_night() {
    let mut renderer = renderer();
    let scene = with_lamp(cube_in(even(1.0), Vec3::splat(0.5)), 1000.0);
    let of = |source: Environment, intensity: f32| {
        whole(&scene).with(|settings| {
            (settings.environment.source, settings.environment.intensity) = (source, intensity);
        })
    };
    // Of a mean of 1 the level is 1 stop, of which the curve leaves 0.8333. Surfaces take half a stop off, and what
    // the lamp makes of them, highlights, 1.5.
    let (day, metering) = exposed(&mut renderer, &scene, of(Environment::File, 1.0));
    assert!(of_surfaces(&metering) < -4.0, "the test shows nothing: {metering:?}");
    assert!((-0.1667 - 2.0..-0.1667 - 1.5).contains(&day), "{day}");
    let (noon, metering) = exposed(&mut renderer, &scene, of(Environment::Sky, 1.0));
    assert!(of_surfaces(&metering) < -4.0 && (-1.8..-1.2).contains(&noon), "{noon}: {metering:?}");
    let (night, metering) = exposed(&mut renderer, &scene, of(Environment::File, 1e-4));
    assert!((night - of_surfaces(&metering)).abs() < 1e-4, "{night}: {metering:?}");
    // Without the lamp it is night all the same: brightened, and darker than day.
    let unlit = cube_in(even(1e-4), Vec3::splat(0.5));
    let (stops, metering) = exposed(&mut renderer, &unlit, whole(&unlit));
    let level = (metering.log_average_luminance.unwrap() / MID_GREY).log2() + stops;
    assert!(stops > 9.0 && (-2.5..-0.9).contains(&level), "{stops}, shown at {level}");
}

/// The share of the surfaces of a picture that has no background whose three components are near white.
fn white_share(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> f64 {
    renderer.render(scene, request).unwrap();
    let pixels = renderer.read_display().unwrap();
    let surfaces: Vec<&[u8]> = pixels.chunks_exact(4).filter(|pixel| pixel[3] == 255).collect();
    let white = surfaces.iter().filter(|pixel| pixel[..3].iter().all(|value| *value >= 245));
    white.count() as f64 / surfaces.len().max(1) as f64
}

#[test]
fn a_pale_model_in_a_low_sun_is_not_white() {
    let mut renderer = renderer();
    // Three quarters of the light come from the sun, behind the camera.
    let direction = Vec3::new(0.3, 0.15, 1.0).normalize();
    let irradiance = Vec3::splat(12.0);
    let light = EnvironmentLight { direction, irradiance, half_angle_tan: 0.005 };
    let scene = cube_in(EnvironmentMap { light: Some(light), ..even(0.3) }, Vec3::splat(0.8));
    let mut request = whole(&scene).with(|settings| settings.background.source = manypass::Background::Transparent);
    renderer.load(&scene).unwrap();
    renderer.expose(&scene, &mut request, Exposure::Scene).unwrap();
    let share = white_share(&mut renderer, &scene, &request);
    assert!(share < 0.03, "{share} of the model is white");
    // The mean is 0.3 + 12 / (4 π) = 1.255: 1.33 stops above mid grey, of which the curve leaves 0.95. Half a stop less
    // is the least that surfaces alone ask for.
    let without_highlights = Exposure::Stops(-0.88);
    renderer.expose(&scene, &mut request, without_highlights).unwrap();
    let share = white_share(&mut renderer, &scene, &request);
    assert!(share > 0.2, "the test shows nothing: {share}");
}

#[test]
fn lamps_of_a_file_do_not_outshine_the_day() {
    let mut renderer = renderer();
    let plain = cube_in(sunny(), Vec3::splat(0.5));
    let lamp = Scene { lights_are_photometric: true, ..with_lamp(plain.clone(), 50_000.0) };
    let of = |scene: &Scene, source: Environment| {
        whole(scene).with(|settings| {
            settings.environment.source = source;
            settings.background.source = manypass::Background::Transparent;
        })
    };
    for source in [Environment::File, Environment::Sky] {
        let (unlit, _) = exposed(&mut renderer, &plain, of(&plain, source));
        let (day, metering) = exposed(&mut renderer, &lamp, of(&lamp, source));
        // It gives half of what the sun does at the most.
        assert!((day - unlit).abs() < 0.6, "{day} and {unlit}: {metering:?}");
        assert!((-15.0..-4.0).contains(&metering.lamp_stops), "{metering:?}");
        let mut request = of(&lamp, source);
        renderer.expose(&lamp, &mut request, Exposure::Scene).unwrap();
        let share = white_share(&mut renderer, &lamp, &request);
        assert!(share < 0.05, "{share} of the model is white");
        // Given an exposure the lamp is as it is, and so is one that was put there by code.
        renderer.expose(&lamp, &mut request, Exposure::Stops(day as f32)).unwrap();
        assert!(white_share(&mut renderer, &lamp, &request) > 0.2, "the test shows nothing");
        let by_code = Scene { lights_are_photometric: false, ..lamp.clone() };
        let (_, metering) = exposed(&mut renderer, &by_code, of(&by_code, source));
        assert_eq!(metering.lamp_stops, 0.0);
    }
    // At night it lights.
    let at_night = of(&lamp, Environment::Sky).with(|settings| settings.environment.sun_elevation_deg = -12.0);
    let (lit, metering) = exposed(&mut renderer, &lamp, at_night);
    assert!((lit - of_surfaces(&metering)).abs() < 1e-4, "{lit}: {metering:?}");
}
