//! Water: at rest the picture of the mirrored camera times Fresnel's share, and what lies below where Snell's law has it,
//! less what Beer and Lambert's says; waves, and what is not drawn.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{matte_white, plain_request, renderer};
use glam::{Mat4, Vec2, Vec3, Vec4};
use manypass::{Environment, FrameRequest, Path, Renderer, View};
use manypass_scene::framing::look_along;
use manypass_scene::primitives::plane;
use manypass_scene::water::{Clarity, WATER_IOR, Water};
use manypass_scene::{Camera, Material, Mesh, Node, NodeId, Primitive, Projection, Scene, ShadingModel};
use manypass_testkit::scenes;

const SIZE: (u32, u32) = (96, 72);

/// Adds a square of a size with a material, and turns it into nothing else.
fn add_square(scene: &mut Scene, (center, size_m): (Vec3, f32), material: Material) -> NodeId {
    scene.materials.push(material);
    let square = Primitive { material: Some(scene.materials.len() - 1), ..plane(1.0) };
    scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
    let mesh = Some(scene.meshes.len() - 1);
    let node = Node { mesh, translation: center, scale: Vec3::new(size_m, 1.0, size_m), ..Node::default() };
    let id = scene.add_node(None, node);
    scene.update_transforms();
    id
}

/// Water that takes all light that goes into it.
fn black(node: NodeId) -> Water {
    let water = Water::new("lake", node, Clarity::Clear);
    Water { absorption_per_m: Vec3::splat(1e5), scattering_per_m: Vec3::ZERO, ..water }
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

/// Where rays through the middles of pixels start, and where they go.
fn rays(request: &FrameRequest) -> Vec<(Vec3, Vec3)> {
    let (width, height) = (request.width, request.height);
    let half = request.camera.half_extent(width as f32 / height as f32);
    let matrix = request.camera.world_from_view;
    let ray = |at: u32| {
        let ndc = Vec2::new((at % width) as f32 + 0.5, (at / width) as f32 + 0.5)
            / Vec2::new(width as f32, height as f32)
            * Vec2::new(2.0, -2.0)
            + Vec2::new(-1.0, 1.0);
        let place = ndc * half;
        match request.camera.is_orthographic() {
            false => (matrix.w_axis.truncate(), matrix.transform_vector3(place.extend(-1.0)).normalize()),
            true => (matrix.transform_point3(place.extend(0.0)), -matrix.z_axis.truncate()),
        }
    };
    (0..width * height).map(ray).collect()
}

/// Fresnel's equations, written out by both polarisations.
fn fresnel(cosine: f32, ior: f32) -> f32 {
    let sine = (1.0 - cosine * cosine).sqrt() / ior;
    let inner = (1.0 - sine * sine).sqrt();
    let s = (cosine - ior * inner) / (cosine + ior * inner);
    let p = (inner - ior * cosine) / (inner + ior * cosine);
    0.5 * (s * s + p * p)
}

/// Balls that glow, above a pond in which they are to be seen.
fn pond() -> (Scene, FrameRequest) {
    let mut scene = scenes::rows_of_spheres().scene;
    for node in &mut scene.nodes {
        node.light = None;
    }
    for (at, material) in scene.materials.iter_mut().enumerate() {
        material.emissive_factor = Vec3::new(0.3 + 0.1 * at as f32, 0.8 - 0.07 * at as f32, 0.5);
    }
    let pond = add_square(&mut scene, (Vec3::new(0.0, 0.25, 3.0), 14.0), Material::default());
    scene.water.push(black(pond));
    let request = plain_request(&scene, SIZE);
    (scene, request)
}

#[test]
fn water_at_rest_is_a_mirror_with_fresnel() {
    let (scene, request) = pond();
    let mut renderer = renderer();
    let mirrored = {
        let matrix = Mat4::from_translation(0.5 * Vec3::Y) * Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0));
        View { world_from_view: matrix * request.camera.world_from_view, ..request.camera }
    };
    let mut dry = scene.clone();
    dry.water.clear();
    dry.nodes.last_mut().unwrap().mesh = None;
    dry.update_transforms();
    for path in [Path::Deferred, Path::Forward, Path::ForwardBatched] {
        let request = request.with(|settings| settings.render.path = path);
        let shown = radiance(&mut renderer, &scene, &request);
        assert_eq!((renderer.stats().captures, renderer.stats().captures_left_out), (1, 0));
        let clip_plane_world = Some(Vec4::new(0.0, 1.0, 0.0, -0.251));
        let truth = FrameRequest { camera: mirrored, clip_plane_world, ..request.clone() };
        let truth = radiance(&mut renderer, &dry, &truth);
        // What rises out of the water, or is before it, is as without.
        let without = radiance(&mut renderer, &dry, &request);
        let (mut count, mut off, mut lit) = (0, 0, 0);
        for (at, (eye, ray)) in rays(&request).into_iter().enumerate() {
            let length_m = (0.25 - eye.y) / ray.y;
            let place = eye + ray * length_m;
            let is_pond = length_m > 0.0 && place.x.abs() < 6.8 && (place.z - 3.0).abs() < 6.8;
            // Balls are before it where the picture without it has them above it.
            if !is_pond || shown[at] == without[at] {
                continue;
            }
            let share = fresnel(-ray.y, WATER_IOR);
            let expected = truth[at].map(|value| value * share);
            let most = expected.iter().copied().fold(0.0, f32::max);
            let differs = shown[at].iter().zip(expected).any(|(a, b)| (a - b).abs() > 0.01 * most.max(0.02));
            (count, off, lit) = (count + 1, off + i32::from(differs), lit + i32::from(most > 0.01));
        }
        assert!(count > 1500 && lit > 500, "{path:?}: {count} pixels of water, {lit} lit");
        assert!(off * 100 <= 2 * count, "{path:?}: {off} of {count} are off");
    }
    // Without views the environment is reflected.
    let off = request.with(|settings| {
        settings.captures.enabled = false;
        settings.environment.source = Environment::Color([0.5; 3]);
    });
    let shown = radiance(&mut renderer, &scene, &off);
    assert_eq!(renderer.stats().captures, 0);
    let straight = rays(&off)
        .into_iter()
        .zip(&shown)
        .filter(|((_, ray), shown)| (shown[0] - 0.5 * fresnel(-ray.y, WATER_IOR)).abs() < 0.003 && ray.y < 0.0);
    assert!(straight.count() > 1000);
}

/// A pool with a bright ground that begins at x = 0, seen at a slant; the ground lies so deep below the surface at 0.
fn pool(depth_m: f32) -> (Scene, FrameRequest) {
    let mut scene = Scene::default();
    let glow = |radiance: f32| Material {
        shading_model: ShadingModel::Unlit,
        base_color_factor: Vec3::splat(radiance).extend(1.0),
        double_sided: true,
        ..Material::default()
    };
    add_square(&mut scene, (Vec3::new(50.0, -depth_m, 0.0), 100.0), glow(1.0));
    add_square(&mut scene, (Vec3::new(-50.0, -depth_m, 0.0), 100.0), glow(0.1));
    let surface = add_square(&mut scene, (Vec3::ZERO, 60.0), Material::default());
    scene.water.push(Water {
        absorption_per_m: Vec3::new(0.5, 0.1, 0.0),
        scattering_per_m: Vec3::ZERO,
        ..Water::new("pool", surface, Clarity::Clear)
    });
    scene.cameras.push(Camera {
        name: "slant".into(),
        projection: Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None },
        aspect: None,
    });
    let eye = Vec3::new(-3.0, 2.5, 0.0);
    let rotation = look_along(Vec3::new(0.0, -0.3, 0.0) - eye, Vec3::Y).unwrap();
    scene.add_node(None, Node { translation: eye, rotation, camera: Some(0), ..Node::default() });
    scene.update_transforms();
    let request = plain_request(&scene, SIZE);
    (scene, request)
}

#[test]
fn what_lies_below_is_where_snell_says_and_as_dark_as_beer_and_lambert_say() {
    let mut renderer = renderer();
    for depth_m in [0.4, 1.5] {
        let (scene, request) = pool(depth_m);
        let shown = radiance(&mut renderer, &scene, &request);
        let (mut count, mut off, mut straight_off) = (0, 0, 0);
        for (at, (eye, ray)) in rays(&request).into_iter().enumerate() {
            let place = eye - ray * (eye.y / ray.y);
            let sine = (1.0 - ray.y * ray.y).sqrt() / WATER_IOR;
            let cosine = (1.0 - sine * sine).sqrt();
            let bottom =
                |sine: f32, cosine: f32| place + Vec3::new(ray.x, 0.0, ray.z).normalize() * (depth_m * sine / cosine);
            let (below, straight) = (bottom(sine, cosine), bottom((1.0 - ray.y * ray.y).sqrt(), -ray.y));
            let ground = if below.x > 0.0 { 1.0 } else { 0.1 };
            // What is not absorbed tells what is there: an edge a pixel beside where it is to be is right.
            let is_edge = below.x.abs() < 0.03 * place.distance(eye);
            let reflected = 1.0 - fresnel(-ray.y, WATER_IOR);
            let through = |absorbed: f32| {
                let way_m = depth_m / cosine + 1.15 * depth_m;
                ground * reflected * (-absorbed * way_m).exp()
            };
            let expected = [0.5, 0.1, 0.0].map(through);
            if !is_edge {
                count += 1;
                off += usize::from(shown[at].iter().zip(expected).any(|(a, b)| (a - b).abs() > 0.012 * b + 1e-4));
                straight_off += usize::from((straight.x > 0.0) != (below.x > 0.0));
            }
        }
        assert!(count > 5000 && off * 200 <= count, "{depth_m} m: {off} of {count} are off");
        // Rays that were not bent would show other ground.
        assert!(depth_m < 1.0 || straight_off > 100, "{straight_off}");
    }
}

#[test]
fn a_white_ground_below_clear_water_is_as_bright_as_even_light() {
    // What is lost nowhere is there: the share that is reflected and what comes through are all of the light.
    let (mut scene, request) = pool(1.5);
    scene.materials[0] = matte_white();
    scene.materials[1] = matte_white();
    scene.water[0].absorption_per_m = Vec3::ZERO;
    let request = request.with(|settings| {
        settings.captures.enabled = false;
        settings.environment.source = Environment::Color([1.0; 3]);
    });
    let shown = radiance(&mut renderer(), &scene, &request);
    let off = shown.iter().flatten().map(|value| (value - 1.0).abs()).fold(0.0, f32::max);
    assert!(off < 0.02, "{off}");
}

#[test]
fn a_bent_ray_finds_ground_where_a_straight_one_meets_nothing() {
    // A square on the ground, and nothing beside it.
    let (depth_m, half_m, middle_x) = (1.5, 1.5, 0.5);
    let (mut scene, request) = pool(depth_m);
    scene.materials[0].base_color_factor = Vec4::ONE;
    scene.nodes[0].translation.x = middle_x;
    scene.nodes[0].scale = Vec3::new(2.0 * half_m, 1.0, 2.0 * half_m);
    scene.nodes[1].mesh = None;
    scene.update_transforms();
    let shown = radiance(&mut renderer(), &scene, &request);
    let view_from_world = request.camera.world_from_view.inverse();
    let half = request.camera.half_extent(SIZE.0 as f32 / SIZE.1 as f32);
    // How far within the square, in metres: a pixel is about 0.1 m long there.
    let inside_m = |place: Vec3| half_m - (place.x - middle_x).abs().max(place.z.abs());
    let is_in_picture = |place: Vec3| {
        let place = view_from_world.transform_point3(place);
        (place.truncate() / -place.z).abs().cmplt(0.99 * half).all()
    };
    let (mut count, mut straight_misses, mut off) = (0, 0, 0);
    for (at, (eye, ray)) in rays(&request).into_iter().enumerate() {
        let surface = eye - ray * (eye.y / ray.y);
        let sine = (1.0 - ray.y * ray.y).sqrt() / WATER_IOR;
        let cosine = (1.0 - sine * sine).sqrt();
        let below = surface + Vec3::new(ray.x, 0.0, ray.z).normalize() * (depth_m * sine / cosine);
        if inside_m(below) < 0.15 || !is_in_picture(below) {
            continue;
        }
        let way_m = depth_m / cosine + 1.15 * depth_m;
        let expected =
            [0.5, 0.1, 0.0].map(|absorbed: f32| (1.0 - fresnel(-ray.y, WATER_IOR)) * (-absorbed * way_m).exp());
        count += 1;
        straight_misses += usize::from(inside_m(surface - ray * (depth_m / ray.y)) < 0.0);
        off += usize::from(shown[at].iter().zip(expected).any(|(a, b)| (a - b).abs() > 0.012 * b + 1e-4));
    }
    assert!(count > 2000 && straight_misses * 8 > count, "{straight_misses} of {count}");
    assert!(off * 100 <= count, "{off} of {count} are off; {straight_misses} meet nothing straight on");
}

#[test]
fn an_eye_in_the_water_sees_through_as_much_as_lies_between() {
    let (mut scene, mut request) = pool(1.5);
    let eye = Vec3::new(8.0, -0.7, 0.0);
    let rotation = look_along(Vec3::new(1.0, -0.5, 0.2), Vec3::Y).unwrap();
    request.camera.world_from_view = Mat4::from_rotation_translation(rotation, eye);
    let mut renderer = renderer();
    let expected = |at: usize, (eye, ray): (Vec3, Vec3)| {
        let way_m = (-1.5 - eye.y) / ray.y;
        ([0.5f32, 0.1, 0.0].map(|absorbed| (-absorbed * way_m).exp()), ray.y < -0.1, at)
    };
    let shown = radiance(&mut renderer, &scene, &request);
    let (mut count, mut off) = (0, 0);
    for (at, ray) in rays(&request).into_iter().enumerate() {
        let (expected, is_ground, at) = expected(at, ray);
        if is_ground {
            count += 1;
            off += usize::from(shown[at].iter().zip(expected).any(|(a, b)| (a - b).abs() > 0.01 * b + 1e-4));
        }
    }
    assert!(count > 3000 && off * 100 <= count, "{off} of {count} are off");
    // Beside the pool, below its surface, the eye is in no water.
    request.camera.world_from_view.w_axis.x = 40.0;
    let beside = radiance(&mut renderer, &scene, &request);
    assert!(beside.contains(&[1.0; 3]));
    // What is scattered has the light that comes down.
    scene.water[0].scattering_per_m = Vec3::splat(0.3);
    request.camera.world_from_view = Mat4::from_rotation_translation(rotation, eye);
    let lit = request.with(|settings| settings.environment.source = Environment::Color([0.0, 4.0, 0.0]));
    let murky = radiance(&mut renderer, &scene, &lit);
    assert!(murky.iter().zip(&shown).filter(|(murky, clear)| murky[1] > clear[1] + 0.05).count() > 3000);
}

#[test]
fn waves_go_on_with_time_and_are_the_same_twice() {
    let (mut scene, request) = pond();
    scene.water[0] = Water { wind_m_s: 4.0, wave_m: 0.7, foam_depth_m: 0.1, caustics: 1.0, ..scene.water[0].clone() };
    let mut first = renderer();
    let mut at = |scene: &mut Scene, secs: f32| {
        scene.time_secs = secs;
        radiance(&mut first, scene, &request)
    };
    let (start, later) = (at(&mut scene, 0.0), at(&mut scene, 0.25));
    assert!(at(&mut scene, 0.0) == start, "the same time is another picture");
    let changed = start.iter().zip(&later).filter(|(a, b)| a != b).count();
    assert!(changed > 500, "{changed} pixels move");
    // Another renderer, which begins there.
    let mut second = renderer();
    assert!(radiance(&mut second, &scene, &request) == start, "another renderer draws another picture");
    scene.time_secs = 0.25;
    assert!(radiance(&mut second, &scene, &request) == later, "what was drawn before counts");
    // Water at rest has no time.
    scene.water[0].wind_m_s = 0.0;
    assert!(at(&mut scene, 0.0) == at(&mut scene, 7.0), "water at rest moves");
    for secs in [1e9, -3.0, f32::MAX, f32::NAN, f32::INFINITY] {
        scene.water[0].wind_m_s = 4.0;
        let picture = at(&mut scene, secs);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{secs}");
    }
}

#[test]
fn the_mean_of_waves_is_what_the_waves_that_are_too_fine_are_shaded_with() {
    // From far above a whole map of waves is a few pixels wide: the mean is that of a picture whose pixels show every wave.
    let mut scene = Scene::default();
    let sea = add_square(&mut scene, (Vec3::ZERO, 400.0), Material::default());
    scene.water.push(Water { wind_m_s: 6.0, wave_m: 0.5, ..black(sea) });
    scene.cameras.push(Camera {
        name: "above".into(),
        projection: Projection::Perspective { fov_y_rad: 0.02, near_m: 1.0, far_m: None },
        aspect: None,
    });
    let eye = Vec3::new(0.0, 150.0, 150.0);
    let rotation = look_along(-eye, Vec3::Y).unwrap();
    scene.add_node(None, Node { translation: eye, rotation, camera: Some(0), ..Node::default() });
    scene.update_transforms();
    let request = plain_request(&scene, (512, 512)).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.captures.enabled = false;
    });
    let mut renderer = renderer();
    let mut mean = |size: u32| {
        let request = FrameRequest { width: size, height: size, ..request.clone() };
        let picture = radiance(&mut renderer, &scene, &request);
        picture.iter().map(|pixel| pixel[0]).sum::<f32>() / picture.len() as f32
    };
    let (fine, coarse) = (mean(512), mean(4));
    let flat = fresnel(std::f32::consts::FRAC_1_SQRT_2, WATER_IOR);
    assert!((fine / coarse - 1.0).abs() < 0.05 && fine > 1.03 * flat, "{fine} {coarse}, flat {flat}");
}

#[test]
fn what_is_not_seen_costs_nothing_and_odd_water_is_none() {
    let (mut scene, request) = pond();
    let mut renderer = renderer();
    let before = radiance(&mut renderer, &scene, &request);
    let captures = |renderer: &mut Renderer, scene: &Scene, request: &FrameRequest| {
        radiance(renderer, scene, request);
        (renderer.stats().captures, renderer.stats().captures_left_out)
    };
    let up = View { world_from_view: request.camera.world_from_view * Mat4::from_rotation_x(1.4), ..request.camera };
    assert_eq!(captures(&mut renderer, &scene, &FrameRequest { camera: up, ..request.clone() }), (0, 1));
    let node = scene.water[0].node;
    scene.node_mut(node).layers = 2;
    let first = FrameRequest { layers: 1, ..request.clone() };
    assert_eq!(captures(&mut renderer, &scene, &first), (0, 1));
    scene.node_mut(node).layers = 1;
    // From below, and in the plane itself.
    for (eye, target) in
        [(Vec3::new(0.0, -0.6, 6.0), Vec3::new(0.0, 0.6, 0.0)), (Vec3::new(0.0, 0.25, 6.0), Vec3::new(0.0, 0.25, 0.0))]
    {
        let world_from_view = Mat4::from_rotation_translation(look_along(target - eye, Vec3::Y).unwrap(), eye);
        let camera = View { world_from_view, ..request.camera };
        let picture = radiance(&mut renderer, &scene, &FrameRequest { camera, ..request.clone() });
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{eye}");
    }
    for odd in [f32::NAN, f32::INFINITY, -1.0, 1e30, 0.0] {
        let plain = scene.water[0].clone();
        scene.water[0] = Water {
            absorption_per_m: Vec3::splat(odd),
            scattering_per_m: Vec3::splat(odd),
            ior: odd,
            wind_m_s: odd,
            wind_rad: odd,
            wave_m: odd,
            foam_depth_m: odd,
            caustics: odd,
            scale: odd,
            normal_map: Some(77),
            ..plain.clone()
        };
        let picture = radiance(&mut renderer, &scene, &request);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{odd}");
        scene.water[0] = plain;
    }
    assert!(radiance(&mut renderer, &scene, &request) == before, "what was odd stays");
    for scale in [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::splat(1e30)] {
        scene.node_mut(node).scale = scale;
        scene.update_transforms();
        let picture = radiance(&mut renderer, &scene, &request);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{scale}");
    }
    scene.water.push(Water::new("odd", NodeId(1_000_000), Clarity::Murky));
    scene.water.extend(vec![scene.water[0].clone(); 20]);
    renderer.load(&scene).unwrap();
    let warnings = renderer.warnings();
    for expected in
        ["water `odd` is not drawn: its surface is flat, and its node is not there", "only the first 16 of 22 "]
    {
        assert!(warnings.iter().any(|warning| warning.contains(expected)), "{expected}: {warnings:?}");
    }
}
