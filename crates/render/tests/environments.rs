//! Light of pictures of the environment against integrals over all of their texels, which know neither cube maps,
//! samples nor suns.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use crate::common::skies::{SIDE, Surroundings, place, radiance, request, room, scene};
use glam::{DVec3, Mat4, Quat, Vec3};
use manypass::gpu::Gpu;
use manypass::{Background, Environment, Exposure, FrameRequest, LightCulling, Path, Renderer, Settings, Tonemap};
use manypass_scene::{
    EnvironmentLight, EnvironmentMap, Light, LightKind, Material, Mesh, Node, Projection, Scene, Sky, primitives,
};

/// Levels are taken as they are; irradiance, which a few levels seldom hold well, is that of the first.
#[test]
fn levels_that_a_file_brings_are_what_rough_surfaces_reflect() {
    let halves = |level: u32| {
        let value = if level == 0 { 1.0 } else { 2.0 + level as f32 };
        [value, 0.5 * value, 0.25, 1.0].iter().flat_map(|value| half::f16::from_f32(*value).to_le_bytes()).collect()
    };
    let bytes = manypass_testkit::ktx2::cube_map(97, 32, 5, halves);
    let map = EnvironmentMap::decode("levels.ktx2", &bytes).unwrap();
    let scene = scene(map, Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None });
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for (roughness, expected) in [(0.0, 1.0), (0.25, 3.0), (0.5, 4.0), (0.625, 4.5), (0.875, 5.5), (1.0, 1.0)] {
        let mut request = request(&scene, Quat::from_rotation_y(0.7), 0.0);
        request.settings.background.source = Background::Environment;
        request.settings.background.blur = roughness;
        for found in radiance(&mut renderer, &scene, &request) {
            let truth = DVec3::new(expected, 0.5 * expected, 0.25);
            assert!((found - truth).length() < 0.01 * truth.length(), "at {roughness}: {found}, expected {truth}");
        }
    }
}

#[test]
fn a_picture_larger_than_the_adapter_takes_is_made_smaller_and_named() {
    let seen = |to: Vec3| Vec3::new(1.5 + to.x, 1.5 + to.y, 1.5 + to.z);
    let map = EnvironmentMap::from_fn("wide", 4096, 2048, seen);
    let scene = scene(map, Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None });
    let mut gpu = Gpu::headless(None).unwrap();
    gpu.capabilities.max_texture_size = 2048;
    let mut renderer = Renderer::new(gpu).unwrap();
    renderer.load(&scene).unwrap();
    let expected =
        "environment \"wide\": 4096x2048 is larger than the adapter's 2048 texels a side; made smaller, 2048x1024";
    assert_eq!(renderer.warnings(), [expected]);
    let mut request = request(&scene, Quat::IDENTITY, 0.0);
    request.settings.background.source = Background::Environment;
    let found = radiance(&mut renderer, &scene, &request);
    for (at, found) in found.iter().enumerate().step_by(97) {
        let (x, y) = place(at);
        let half = 0.5f64.tan();
        let truth = seen(DVec3::new(x * half, y * half, -1.0).normalize().as_vec3()).as_dvec3();
        assert!((found - truth).length() < 0.01 * truth.length(), "{found}, expected {truth}");
    }
}

/// A floor of every roughness beside the next, under a camera that looks along it.
fn with_floor(scene: &mut Scene) {
    for strip in 0..6u8 {
        let x = f32::from(strip) - 2.5;
        let mut plane = primitives::plane(1.0);
        plane.positions.iter_mut().for_each(|position| position[0] += x);
        plane.material = Some(scene.materials.len());
        let metallic_factor = f32::from(strip % 2);
        let roughness_factor = 0.3 + 0.14 * f32::from(strip);
        scene.materials.push(Material { metallic_factor, roughness_factor, ..Material::default() });
        plane.bounds = manypass_scene::Aabb::from_points(plane.positions.iter().copied().map(Vec3::from));
        scene.meshes.push(Mesh { primitives: vec![plane], ..Mesh::default() }.into());
        scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), ..Node::default() });
    }
    scene.update_transforms();
}

#[test]
fn a_sun_in_a_picture_is_a_directional_light() {
    let mut renderer = renderer();
    let sun = Vec3::new(0.5, 0.4, -0.7).normalize();
    let (disc, radiance_of_sun) = (0.99993f32, 20_000.0f32);
    let map = EnvironmentMap::from_fn("sun", 2048, 1024, |to| {
        if to.dot(sun) > disc { Vec3::splat(radiance_of_sun) } else { Vec3::ZERO }
    });
    // Of the texels that are drawn.
    let irradiance: f64 = Surroundings::of(&map).integral().x;
    let mut scene = scene(map, Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None });
    with_floor(&mut scene);
    let view = Quat::from_rotation_x(-0.5);
    for rotation_deg in [0.0f32, 75.0] {
        for path in [Path::Deferred, Path::Forward] {
            let mut lit = request(&scene, view, 6.0);
            lit.settings.render.path = path;
            lit.settings.environment.rotation_deg = rotation_deg;
            renderer.load(&scene).unwrap();
            let found = radiance(&mut renderer, &scene, &lit);
            let mut with_light = scene.clone();
            with_light.environment = None;
            with_light.lights.push(Light {
                kind: LightKind::Directional,
                intensity: irradiance as f32,
                ..Light::default()
            });
            let to_sun = Quat::from_rotation_y(rotation_deg.to_radians()) * sun;
            let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, -to_sun);
            with_light.add_node(None, Node { light: Some(0), rotation, ..Node::default() });
            with_light.update_transforms();
            renderer.load(&with_light).unwrap();
            let truth = radiance(
                &mut renderer,
                &with_light,
                &lit.with(|settings| settings.environment.source = Environment::None),
            );
            let level = truth.iter().map(|value| value.x).sum::<f64>() / truth.len() as f64;
            let error = truth.iter().zip(&found).map(|(a, b)| (a.x - b.x).abs()).fold(0.0, f64::max);
            println!("{rotation_deg}°, {}: {error} of {level}", path.name());
            assert!(
                level > 0.05 && error < 0.02 * level.max(1.0),
                "{rotation_deg}°, {}: {error} of {level}",
                path.name()
            );
        }
    }
}

#[test]
fn an_even_picture_is_an_even_environment() {
    let mut renderer = renderer();
    let map = EnvironmentMap::from_fn("even", 64, 32, |_| Vec3::splat(0.7));
    let mut scene = scene(map, Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None });
    with_floor(&mut scene);
    renderer.load(&scene).unwrap();
    let mut lit = request(&scene, Quat::from_rotation_x(-0.5), 6.0);
    lit.settings.background.source = Background::Environment;
    let even = lit.with(|settings| settings.environment.source = Environment::Color([0.7; 3]));
    let [found, truth] = [&lit, &even].map(|request| radiance(&mut renderer, &scene, request));
    let error = truth.iter().zip(&found).map(|(a, b)| (a - b).abs().max_element()).fold(0.0, f64::max);
    assert!(error < 0.002, "{error}");
    // The picture goes with its scene.
    scene.environment = None;
    assert!(radiance(&mut renderer, &scene, &lit).iter().all(|value| *value == DVec3::ZERO));
}

/// The light of `map` as a light of the scene.
fn with_light_of(scene: &Scene, map: &EnvironmentMap, rotation_deg: f32) -> Scene {
    let light = map.light.unwrap();
    let mut scene = Scene { environment: None, ..scene.clone() };
    let kind = LightKind::Directional;
    scene.lights.push(Light {
        kind,
        color_linear: light.irradiance,
        radius_m: light.half_angle_tan,
        ..Light::default()
    });
    let to_light = Quat::from_rotation_y(rotation_deg.to_radians()) * light.direction;
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, -to_light);
    scene.add_node(None, Node { light: Some(scene.lights.len() - 1), rotation, ..Node::default() });
    scene.update_transforms();
    scene
}

#[test]
fn the_light_of_a_map_is_a_directional_light_with_shadows() {
    let mut renderer = renderer();
    let light = EnvironmentLight {
        direction: Vec3::new(0.5, 0.7, -0.3).normalize(),
        irradiance: Vec3::new(3.0, 2.0, 1.0),
        half_angle_tan: 0.05,
    };
    let map = EnvironmentMap { light: Some(light), ..EnvironmentMap::from_fn("dark", 64, 32, |_| Vec3::ZERO) };
    let mut scene = scene(map.clone(), Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None });
    with_floor(&mut scene);
    let lid = Node { mesh: Some(2), translation: Vec3::new(0.4, 0.8, 0.0), ..Node::default() };
    scene.add_node(None, lid);
    scene.update_transforms();
    let of_scene = with_light_of(&scene, &map, 40.0);
    let mut ways: Vec<(Path, LightCulling)> =
        [Path::Forward, Path::ForwardBatched, Path::Gouraud].map(|path| (path, LightCulling::Clustered)).into();
    ways.extend(
        [LightCulling::Clustered, LightCulling::Tiled, LightCulling::Volumes, LightCulling::None]
            .map(|culling| (Path::Deferred, culling)),
    );
    for (path, culling) in ways {
        let mut lit = request(&scene, Quat::from_rotation_x(-0.5), 6.0);
        lit.settings.render.path = path;
        lit.settings.lights.culling = culling;
        lit.settings.shadows.enabled = true;
        lit.settings.environment.rotation_deg = 40.0;
        lit.settings.environment.intensity = 0.5;
        let of_light = lit.with(|settings| settings.environment.source = Environment::None);
        let open = lit.with(|settings| settings.shadows.enabled = false);
        let found = radiance(&mut renderer, &scene, &lit);
        assert_eq!((renderer.stats().lights, renderer.stats().shadowed_lights), (0, 1));
        let unshadowed = radiance(&mut renderer, &scene, &open);
        let truth = radiance(&mut renderer, &of_scene, &of_light);
        let level = truth.iter().map(|value| 0.5 * value.x).sum::<f64>();
        let apart =
            |other: &[DVec3]| other.iter().zip(&truth).map(|(a, b)| (*a - 0.5 * *b).abs().x).sum::<f64>() / level;
        let (error, of_open) = (apart(&found), apart(&unshadowed));
        println!("{}, {}: {error}; without shadows {of_open}", path.name(), culling.name());
        assert!(level > 1.0 && error < 0.003, "{}, {}: {error}", path.name(), culling.name());
        assert!(of_open > 0.03, "{}, {}: nothing lies in the shadow: {of_open}", path.name(), culling.name());
    }
}

/// A camera alone, whose turn shows `to` in the middle of the picture.
fn looking(to: Vec3) -> Quat {
    Quat::from_rotation_arc(Vec3::NEG_Z, to)
}

#[test]
fn the_sky_is_its_picture_with_its_sun_as_a_light() {
    let mut renderer = renderer();
    let sky = Sky { sun_elevation_deg: 25.0, sun_azimuth_deg: 70.0, turbidity: 3.0, ground_albedo: 0.2 };
    let map = sky.map();
    let sun = map.light.unwrap();
    let mut scene = scene(map, Projection::Perspective { fov_y_rad: 0.1, near_m: 0.1, far_m: None });
    with_floor(&mut scene);
    let mut of_file = request(&scene, looking(sun.direction), 6.0);
    of_file.settings.background.source = Background::Environment;
    of_file.settings.shadows.enabled = true;
    let of_sky = of_file.with(|settings| {
        settings.environment.source = Environment::Sky;
        settings.environment.sun_elevation_deg = sky.sun_elevation_deg;
        settings.environment.sun_azimuth_deg = sky.sun_azimuth_deg;
        settings.environment.turbidity = sky.turbidity;
        settings.environment.ground_albedo = sky.ground_albedo;
    });
    let [seen, of_picture] = [&of_sky, &of_file].map(|request| radiance(&mut renderer, &scene, request));
    assert_eq!(seen, of_picture);
    // A disc of 0.53° in a picture of 0.1 rad is 3.7 pixels wide.
    let brightest = seen.iter().map(|value| value.y).fold(0.0, f64::max);
    let disc = seen.iter().filter(|value| value.y > 0.5 * brightest).count();
    assert!(brightest > 10_000.0 && (8..=16).contains(&disc), "{brightest}, {disc} pixels");
    assert_eq!((renderer.stats().lights, renderer.stats().shadowed_lights), (0, 1));
    // The floor from above.
    let mut floor = of_sky.clone();
    floor.camera.world_from_view = Mat4::from_rotation_x(-1.2) * Mat4::from_translation(Vec3::Z * 6.0);
    let lit = radiance(&mut renderer, &scene, &floor);
    let in_the_dark = floor.with(|settings| settings.environment.intensity = 0.0);
    let dark = radiance(&mut renderer, &scene, &in_the_dark);
    assert!(lit.iter().all(|value| value.x > 0.01) && dark.iter().all(|value| *value == DVec3::ZERO));
    // Its light is metered where nobody says otherwise.
    scene.environment = None;
    let resolved = FrameRequest::new(8, 8, floor.camera)
        .with(|settings| settings.environment.source = Environment::Sky)
        .resolved(&scene);
    assert_eq!(resolved.settings.exposure.stops, Exposure::AUTO);
}

#[test]
fn a_gradient_is_as_it_is_written() {
    let mut renderer = renderer();
    let scene = scene(room(), Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None });
    let mut request = request(&scene, Quat::IDENTITY, 0.0);
    request.settings.set("background.source", "102040,ff8000").unwrap();
    request.settings.tone_map.curve = Tonemap::Aces;
    request.settings.tone_map.dither = 1.0;
    request.settings.exposure.stops = Exposure::Stops(2.0);
    let written = Settings::declared().iter().find(|info| info.key == "background.source").unwrap();
    assert!(written.expected().contains("two colours"), "{}", written.expected());
    renderer.load(&scene).unwrap();
    let found = radiance(&mut renderer, &scene, &request);
    let shown = renderer.read_display().unwrap();
    let side = SIDE as usize;
    for (row, height) in (0..side).map(|row| (row, 1.0 - (row as f32 + 0.5) / SIDE as f32)) {
        for (channel, (below, above)) in [(16.0f32, 255.0), (32.0, 128.0), (64.0, 0.0)].into_iter().enumerate() {
            let byte = below + (above - below) * height;
            let at = (row * side + row) * 4 + channel;
            assert!((f32::from(shown[at]) - byte).abs() <= 1.01, "row {row}: {} of {byte}", shown[at]);
            // Linear values are those that the exposure shows so.
            let linear = f64::from(manypass::colour::linear_from_srgb(byte / 255.0)) / 4.0;
            assert!((found[row * side][channel] - linear).abs() < 1e-4, "row {row}");
        }
    }
    assert!(shown[0] > 200 && shown[4 * side * (side - 1)] < 30, "the first colour is that below");
}
