//! Reflections of the picture: a mirror against the mirrored camera, rough surfaces against integrals over their lobe,
//! and pictures that they have to leave alone.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::plain_request;
use crate::common::reflected::{Lobe, glowing, load, metal, pixel_of, places, without};
use crate::common::shadows::{perspective, radiance, shared};
use glam::{Mat4, Quat, Vec3};
use manypass::{Background, Environment, FogMode, FrameRequest, Path, PixelSamples, Renderer, Resolution};
use manypass_scene::{Material, Node, Projection, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::compare::{Picture, Tolerance, assert_same, difference};
use std::f32::consts::FRAC_PI_2;

const SIZE: (u32, u32) = (192, 124);

/// So large a share of a mirror's pixels may be off by more than a tenth, with rays of half the size and of the whole, where
/// the picture shows what they reflect: its edges are a large part of a picture this small.
const LIMIT_SEEN: f32 = 0.03;

/// The same where the picture hides that, as the undersides of bodies.
const LIMIT_HIDDEN: f32 = 0.55;

/// Bodies of many colours over the plane y = 0, which is a mirror if it is there.
fn bodies(has_mirror: bool) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.3, 1.6, 6.0), Vec3::new(0.0, 0.5, 0.0), perspective());
    if has_mirror {
        builder.put(primitives::plane(40.0), metal(0.0), Node::default());
    }
    for i in 0..24u8 {
        let [x, y] = [i % 6, i / 6].map(f32::from);
        let color = [0.2 + 0.15 * x, 0.9 - 0.2 * y, f32::from(i % 5) / 5.0];
        let place = Vec3::new(0.5 * x - 1.4, 0.6 + 0.3 * y, -0.4 * y);
        builder.put(primitives::cube(Vec3::new(0.5, 0.3, 0.3)), glowing(color), at(place));
    }
    builder.put(primitives::uv_sphere(0.4, 48, 24), glowing([0.1, 0.8, 0.3]), at(Vec3::new(-1.5, 0.6, 1.5)));
    builder.put(primitives::uv_sphere(0.3, 48, 24), glowing([0.9, 0.1, 0.1]), at(Vec3::new(1.4, 0.7, 1.6)));
    builder.finish()
}

/// Even light from everywhere, and reflections at full size.
fn request(scene: &Scene, environment: f32) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([environment; 3]);
        settings.reflections.enabled = true.into();
        settings.reflections.resolution = Resolution::Full;
        settings.reflections.roughness_max = 1.0;
        settings.reflections.steps = 512;
    })
}

#[test]
fn a_flat_mirror_shows_what_the_mirrored_camera_sees() {
    let mut renderer = shared();
    let [scene, above] = [true, false].map(bodies);
    let straight = request(&scene, 0.0);
    let mut parallel = straight.clone();
    parallel.camera.projection = Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 100.0 };
    for request in [straight, parallel] {
        load(&mut renderer, &scene);
        let found = radiance(&mut renderer, &scene, &request, 1);
        let places_seen = places(&mut renderer, &scene, &request);
        let mut mirrored = without(&request);
        mirrored.camera.world_from_view = Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0)) * request.camera.world_from_view;
        load(&mut renderer, &above);
        let expected = radiance(&mut renderer, &above, &mirrored, 1);
        let places_mirrored = places(&mut renderer, &above, &mirrored);
        let (mut checked, mut off, mut sum) = (0, 0, 0.0);
        let width = SIZE.0 as usize;
        for pixel in width..found.len() - width {
            let (position, normal) = places_mirrored[pixel];
            // The mirror is all that lies at 0 and looks up; there are no normals where there is nothing.
            let is_mirror = places_seen[pixel].0.y.abs() < 1e-4 && places_seen[pixel].1.y > 0.99;
            if !is_mirror || normal.length() < 0.5 {
                continue;
            }
            // The middle of a body, away from the picture's edge and not seen from the side, that the picture shows as
            // well.
            let around = [pixel - 1, pixel + 1, pixel - width, pixel + width];
            let direction = (position - places_seen[pixel].0).normalize();
            let (x, y) = pixel_of(&request.camera, SIZE, position);
            let from_edge = (x / SIZE.0 as f32).min(1.0 - x / SIZE.0 as f32).min(y / SIZE.1 as f32);
            let is_inner = around.iter().all(|other| expected[*other] == expected[pixel]);
            if !is_inner || from_edge.min(1.0 - y / SIZE.1 as f32) < 0.09 || direction.dot(normal) > -0.12 {
                continue;
            }
            let shown = y as usize * width + x as usize;
            let around = [shown, shown - 1, shown + 1, shown - width, shown + width];
            if around.iter().any(|other| places_seen[*other].0.distance(position) > 0.06) {
                continue;
            }
            checked += 1;
            let error = (0..3).map(|c| (found[pixel][c] - expected[pixel][c]).abs()).fold(0.0, f32::max);
            sum += error;
            off += usize::from(error > 0.01);
        }
        let mean = sum / checked as f32;
        println!("{checked} pixels, {off} are off, mean {mean}");
        assert!(checked > 400, "{checked}");
        assert!(mean < 0.01 && off * 100 < checked, "{off} of {checked}, {mean}");
    }
}

/// Bodies of one colour each, over a mirror if it is there, so that the side that is met looks as the one that is seen.
fn closed_bodies(has_mirror: bool) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(1.6, 1.5, 4.4), Vec3::new(0.0, 0.2, 0.0), perspective());
    if has_mirror {
        builder.put(primitives::plane(40.0), metal(0.0), Node::default());
    }
    for i in 0..9u8 {
        let [x, z] = [i % 3, i / 3].map(f32::from);
        let color = [0.3 + 0.3 * x, 0.9 - 0.3 * z, f32::from(i % 4) / 4.0];
        let place = Vec3::new(1.3 * x - 1.3, 0.6, 1.1 * z - 1.6);
        if i % 2 == 0 {
            builder.put(primitives::uv_sphere(0.5, 64, 32), glowing(color), at(place));
        } else {
            builder.put(primitives::cube(Vec3::new(0.7, 0.9, 0.7)), glowing(color), at(place));
        }
    }
    builder.finish()
}

/// Of a mirror's pixels that reflect bodies, the shares that are wrong: where the picture shows what they reflect, and where
/// it hides that.
fn wrong_shares(renderer: &mut Renderer, [scene, above]: &[Scene; 2], request: &FrameRequest) -> [f32; 2] {
    load(renderer, scene);
    let found = radiance(renderer, scene, request, 16);
    let seen = places(renderer, scene, request);
    let mut mirrored = without(request);
    mirrored.camera.world_from_view = Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0)) * request.camera.world_from_view;
    load(renderer, above);
    let expected = radiance(renderer, above, &mirrored, 16);
    let places_mirrored = places(renderer, above, &mirrored);
    let (mut checked, mut wrong) = ([0usize; 2], [0usize; 2]);
    for pixel in 0..found.len() {
        let (position, normal) = places_mirrored[pixel];
        let is_mirror = seen[pixel].0.y.abs() < 1e-4 && seen[pixel].1.y > 0.99;
        let (x, y) = pixel_of(&request.camera, SIZE, position);
        let [across, down] = [x / SIZE.0 as f32, y / SIZE.1 as f32].map(|share| share.min(1.0 - share));
        // What lies outside of the picture, or fades towards its edges, is none of what is asked here.
        if !is_mirror || normal.length() < 0.5 || across.min(down) < 0.09 {
            continue;
        }
        let shown = seen[y as usize * SIZE.0 as usize + x as usize].0;
        let is_hidden = usize::from(shown.distance(position) > 0.06);
        let error = (0..3).map(|c| (found[pixel][c] - expected[pixel][c]).abs()).fold(0.0, f32::max);
        checked[is_hidden] += 1;
        wrong[is_hidden] += usize::from(error > 0.1);
    }
    assert!(checked.iter().all(|count| *count > 500), "{checked:?}");
    println!("{wrong:?} of {checked:?} pixels are wrong");
    [0, 1].map(|i| wrong[i] as f32 / checked[i] as f32)
}

#[test]
fn mirrors_are_right_where_the_picture_shows_what_they_reflect() {
    let mut renderer = shared();
    let scenes = [true, false].map(closed_bodies);
    let full = request(&scenes[0], 0.0);
    let half = full.with(|settings| settings.reflections.resolution = Resolution::Half);
    for (name, request) in [("half", half), ("full", full.clone())] {
        let [of_seen, of_hidden] = wrong_shares(&mut renderer, &scenes, &request);
        // Backs are known, so that many of those are met, in the colour of the side that is seen.
        assert!(of_seen < LIMIT_SEEN && of_hidden < LIMIT_HIDDEN, "{name}: {of_seen} {of_hidden}");
    }
    // As surfaces without backs are: thin.
    let thin = full.with(|settings| settings.reflections.thickness_m = 0.04);
    let [_, of_thin] = wrong_shares(&mut renderer, &scenes, &thin);
    assert!(of_thin > 1.2 * LIMIT_HIDDEN, "{of_thin}");
}

/// A floor before a glowing panel at z = 0, 2 m wide and 1.5 m high, that is all in the picture.
fn panel(roughness: f32) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.2, 5.5), Vec3::new(0.0, 0.4, 0.0), perspective());
    builder.put(primitives::plane(40.0), metal(roughness), Node::default());
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    let panel = primitives::plane(1.0);
    let scale = Vec3::new(2.0, 1.0, 1.5);
    let node = Node { rotation, scale, ..at(Vec3::new(0.0, 0.75, 0.0)) };
    builder.put(panel, glowing([0.8; 3]), node);
    builder.finish()
}

/// The share of what the floor reflects that comes from the panel, by the lobe itself.
fn panel_share(position: Vec3, eye: Vec3, roughness: f32) -> f32 {
    let lobe = Lobe { normal: Vec3::Y, roughness, f0: 1.0 };
    let to_eye = (eye - position).normalize();
    let (mut met, mut all) = (0.0, 0.0);
    for i in 0..64u8 {
        for j in 0..96u8 {
            let place = [(f32::from(i) + 0.5) / 64.0, (f32::from(j) + 0.5) / 96.0];
            let Some((towards, weight)) = lobe.reflected(to_eye, place) else { continue };
            let hit = position + towards * (-position.z / towards.z);
            all += weight;
            met += if towards.z < 0.0 && hit.x.abs() < 1.0 && hit.y < 1.5 { weight } else { 0.0 };
        }
    }
    met / all
}

#[test]
fn a_rough_surface_converges_to_its_lobe() {
    const ENVIRONMENT: f32 = 0.25;
    let mut renderer = shared();
    for (roughness, tolerance) in [(0.2, 0.02), (0.45, 0.03)] {
        let scene = panel(roughness);
        load(&mut renderer, &scene);
        let request = request(&scene, ENVIRONMENT).with(|settings| settings.reflections.brightness_max = 0.0);
        let eye = request.camera.world_from_view.w_axis.truncate();
        // Pixels of the floor before the panel, and how much the panel is to be trusted there.
        let places = places(&mut renderer, &scene, &request);
        let fade = ((1.0f32 - roughness) / 0.2).min(1.0);
        let picked: Vec<(usize, f32)> = (0..places.len())
            .filter(|pixel| {
                let position = places[*pixel].0;
                position.y.abs() < 1e-4 && position.x.abs() < 1.2 && (0.1..1.6).contains(&position.z)
            })
            .map(|pixel| {
                (pixel, ENVIRONMENT + fade * panel_share(places[pixel].0, eye, roughness) * (0.8 - ENVIRONMENT))
            })
            .collect();
        assert!(picked.len() > 500, "{}", picked.len());
        let mut errors = |samples: u32| {
            let found = radiance(&mut renderer, &scene, &request, samples);
            let off = |(pixel, expected): &(usize, f32)| f64::from(found[*pixel][1] - expected);
            let bias = picked.iter().map(off).sum::<f64>() / picked.len() as f64;
            let square = picked.iter().map(|pixel| off(pixel).powi(2)).sum::<f64>() / picked.len() as f64;
            println!("roughness {roughness}, {samples} samples: {bias:.4} in the mean, {:.4} rms", square.sqrt());
            (bias.abs(), square.sqrt())
        };
        let [few, many] = [8, 64].map(&mut errors);
        assert!(many.0 < 0.01 && many.1 < tolerance, "{roughness}: {many:?}");
        assert!(many.1 < 0.6 * few.1, "{roughness}: {few:?} {many:?}");
        // One sample, filtered, has the same mean but for what is blurred over edges, by the filter and by what its few rays stand for.
        let one = errors(1);
        assert!(one.0 < 0.04, "{roughness}: {one:?}");
    }
}

#[test]
fn more_samples_cut_less_of_what_is_bright() {
    let mut renderer = shared();
    let scene = panel(0.2);
    load(&mut renderer, &scene);
    // A single sample cuts the panel's 0.8 to a fourth.
    let cut = request(&scene, 0.0).with(|settings| settings.reflections.brightness_max = 0.2 * 0.2 * 0.2);
    let uncut = cut.with(|settings| settings.reflections.brightness_max = 0.0);
    let mut light = |request: &FrameRequest, samples: u32| {
        let found = radiance(&mut renderer, &scene, request, samples);
        let bare = radiance(&mut renderer, &scene, &without(request), samples);
        found.iter().zip(&bare).map(|(with, without)| f64::from(with[1] - without[1])).sum::<f64>()
    };
    let ratios = [1, 4, 16, 63, 64, 256].map(|samples| light(&cut, samples) / light(&uncut, samples));
    println!("of what is uncut: {ratios:.4?}");
    assert!(ratios.is_sorted_by(|fewer, more| *more > fewer - 0.005), "{ratios:?}");
    // Texels that are bright for that cut count less in the filter, too.
    assert!(ratios[0] < 0.5 && ratios[2] > 0.6 && ratios[3] > 0.7 && ratios[4] > 0.99, "{ratios:?}");
}

#[test]
fn what_reflects_nothing_in_the_picture_stays_as_it_is() {
    let mut renderer = shared();
    let mut same = |scene: &Scene, request: &FrameRequest, what: &str| {
        load(&mut renderer, scene);
        for samples in [1, 8] {
            let plain = radiance(&mut renderer, scene, &without(request), samples);
            assert!(plain.iter().any(|pixel| pixel[1] > 0.05), "{what}");
            let found = radiance(&mut renderer, scene, request, samples);
            let off = found.iter().zip(&plain).filter(|(a, b)| a != b).count();
            let largest = found.iter().zip(&plain).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f32::max);
            println!("{what}, {samples} samples: {off} pixels are another, by {largest} at the most");
            // Triangles of a round body may rise a little over each other's planes along its silhouette.
            let (most, most_by) = if what == "a ball" && samples > 1 { (found.len() / 60, 0.02) } else { (0, 0.0) };
            assert!(off <= most && largest <= most_by, "{what}, {samples} samples: {off} pixels by {largest}");
        }
    };
    // Planes, down to grazing angles, and a ball: they do not meet themselves.
    let eyes = [Vec3::new(0.0, 3.0, 4.0), Vec3::new(1.0, 0.6, 4.0), Vec3::new(0.3, 0.04, 4.0)];
    for roughness in [0.0, 0.3] {
        for eye in eyes {
            let mut builder = SceneBuilder::new(eye, Vec3::new(0.2, 0.0, 0.0), perspective());
            builder.put(primitives::plane(40.0), metal(roughness), Node::default());
            let scene = builder.finish();
            let request = request(&scene, 0.0).with(|settings| {
                settings.environment.source = Environment::Studio;
                settings.background.source = Background::Environment;
            });
            same(&scene, &request, &format!("a plane from {eye}, roughness {roughness}"));
            let mut parallel = request.clone();
            parallel.camera.projection = Projection::Orthographic { height_m: 3.0, near_m: 0.01, far_m: 100.0 };
            same(&scene, &parallel, &format!("a plane from {eye} in parallel, roughness {roughness}"));
        }
        let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, perspective());
        builder.put(primitives::uv_sphere(1.2, 64, 32), metal(roughness), Node::default());
        let scene = builder.finish();
        let request = request(&scene, 0.0).with(|settings| settings.environment.source = Environment::Studio);
        same(&scene, &request, "a ball");
    }
    // Rays that leave the picture: a floor from above, and a wall beside it.
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 3.0, 0.01), Vec3::ZERO, perspective());
    builder.put(primitives::plane(40.0), metal(0.0), Node::default());
    builder.put(primitives::cube(Vec3::new(1.0, 4.0, 9.0)), glowing([1.0, 0.0, 0.0]), at(Vec3::new(4.0, 2.0, 0.0)));
    let scene = builder.finish();
    let request = request(&scene, 0.0).with(|settings| settings.environment.source = Environment::Studio);
    same(&scene, &request, "rays that leave the picture");
}

#[test]
fn a_white_room_in_white_light_stays_white() {
    let mut renderer = shared();
    let mut builder = SceneBuilder::new(Vec3::new(0.4, 1.8, 5.0), Vec3::new(0.0, 0.7, 0.0), perspective());
    builder.put(primitives::plane(40.0), metal(0.0), Node::default());
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    builder.put(primitives::plane(40.0), metal(0.35), Node { rotation, ..at(Vec3::new(0.0, 0.0, -2.0)) });
    builder.put(primitives::cube(Vec3::ONE), metal(0.1), at(Vec3::new(-1.2, 0.5, 0.0)));
    builder.put(primitives::uv_sphere(0.6, 48, 24), metal(0.0), at(Vec3::new(0.3, 0.6, -0.4)));
    builder.put(primitives::torus(0.4, 0.15, 48, 24), grey(1.0), at(Vec3::new(1.4, 0.5, 0.4)));
    let glossy = Material { roughness_factor: 0.15, ..grey(1.0) };
    builder.put(primitives::cube(Vec3::new(0.6, 1.4, 0.6)), glossy, at(Vec3::new(1.6, 0.7, -1.0)));
    let scene = builder.finish();
    load(&mut renderer, &scene);
    for resolution in [Resolution::Full, Resolution::Half] {
        let request = request(&scene, 1.0).with(|settings| {
            settings.reflections.resolution = resolution;
            // Light is cut to white at most for surfaces rougher than that.
            settings.reflections.roughness_max = 0.5;
        });
        for samples in [1, 8] {
            let found = radiance(&mut renderer, &scene, &request, samples);
            let [least, most] = [f32::min as fn(f32, f32) -> f32, f32::max]
                .map(|pick| found.iter().flatten().copied().filter(|value| *value > 0.0).reduce(pick).unwrap());
            println!("{resolution:?}, {samples} samples: from {least} to {most}");
            assert!(least > 0.99 && most < 1.01, "{resolution:?}, {samples} samples: from {least} to {most}");
        }
        // The test can fail: the same rays do meet something, as is seen where that is no white.
        let tinted = request.with(|settings| settings.environment.source = Environment::Color([1.0, 0.5, 0.5]));
        let [found, plain] = [&tinted, &without(&tinted)].map(|request| radiance(&mut renderer, &scene, request, 1));
        assert!(found.iter().zip(&plain).all(|(a, b)| (a[1] - b[1]).abs() < 0.01));
    }
}

#[test]
fn passes_are_there_as_they_are_needed() {
    let mut renderer = shared();
    let scene = bodies(true);
    load(&mut renderer, &scene);
    let mut passes = |request: &FrameRequest| {
        let plan = renderer.plan(&scene, request).unwrap();
        let names = plan.passes.iter().map(|pass| pass.name.to_string());
        let of_reflections = names.filter(|name| name.starts_with("reflections") && name.matches('.').count() < 2);
        of_reflections.collect::<Vec<_>>()
    };
    const BACKS: [&str; 2] = ["reflections.backs", "reflections.back_distances"];
    let few = request(&scene, 1.0);
    let all = ["reflections", "reflections.cells", "reflections.tiles", "reflections.filter", "reflections.compose"];
    assert_eq!(passes(&few), [&BACKS[..], &all].concat());
    let still = FrameRequest { sample_count: 64, ..few.clone() };
    let unfiltered = all.iter().copied().filter(|name| *name != "reflections.filter");
    assert_eq!(passes(&still), BACKS.into_iter().chain(unfiltered).collect::<Vec<_>>());
    assert_eq!(passes(&FrameRequest { goes_on: true, ..still }).len(), 7);
    assert_eq!(passes(&without(&few)), [""; 0]);
    assert_eq!(passes(&few.with(|settings| settings.reflections.roughness_max = 0.0)), [""; 0]);
    let request = few.with(|settings| settings.render.path = Path::Gouraud);
    let error = renderer.render(&scene, &request).unwrap_err().to_string();
    assert!(error.contains("`reflections.enabled=true` needs `render.path=deferred`"), "{error}");
}

#[test]
fn forward_paths_reflect_as_the_deferred_one_does() {
    let mut renderer = shared();
    let scene = bodies(true);
    load(&mut renderer, &scene);
    let mut shown = |request: &FrameRequest, path| {
        let request = request.with(|settings| settings.render.path = path);
        renderer.render(&scene, &request).unwrap();
        Picture::from_rgba8(SIZE.0 as usize, SIZE.1 as usize, &renderer.read_display().unwrap())
    };
    // Base colour has eight bits on the deferred path.
    let same = Tolerance { mean: 0.75, ..Tolerance::default() };
    for resolution in [Resolution::Full, Resolution::Half] {
        for occlusion in [false, true] {
            let request = request(&scene, 0.3).with(|settings| {
                settings.reflections.resolution = resolution;
                settings.occlusion.enabled = occlusion.into();
                settings.fog.mode = FogMode::Exponential;
                settings.fog.density_per_m = 0.05;
            });
            let truth = shown(&request, Path::Deferred);
            let open = shown(&without(&request), Path::Forward);
            assert!(!difference(&truth, &open, 2).is_within(same), "nothing is reflected");
            for path in [Path::Forward, Path::ForwardBatched] {
                let found = shown(&request, path);
                println!("{resolution:?}, {}: {}", path.name(), difference(&truth, &found, 2));
                assert_same(&truth, &found, same);
            }
            // Of four samples a pixel those at edges take what was found for the middle, and mirrors show edges of bodies.
            let of_four = request.with(|settings| settings.msaa.samples = PixelSamples::Four);
            let inside =
                Tolerance { share: 0.93, share_between: 0.97, mean: 2.0, area_px: 900, area_between_px: 300, ..same };
            let found = shown(&of_four, Path::Forward);
            println!("{resolution:?}, four samples: {}", difference(&truth, &found, 2));
            assert_same(&truth, &found, inside);
            let open = shown(&without(&of_four), Path::Forward);
            assert!(!difference(&truth, &open, 2).is_within(inside), "nothing is reflected");
        }
    }
}

#[test]
fn extreme_settings_and_sizes_leave_numbers() {
    let mut renderer = shared();
    let scene = bodies(true);
    load(&mut renderer, &scene);
    let numbers = [(0.0, 0.0, 1), (1e6, 1e6, 1024), (1e-6, 1e-6, 7), (0.5, 1e6, 64)];
    for (i, (width, height)) in [(1, 1), (1, 4096), (64, 3), (48, 32)].into_iter().enumerate() {
        for (j, resolution) in [Resolution::Full, Resolution::Half, Resolution::Quarter].into_iter().enumerate() {
            let (distance_m, thickness_m, steps) = numbers[(i + j) % numbers.len()];
            let request = FrameRequest { width, height, ..request(&scene, 0.3) }.with(|settings| {
                let reflections = &mut settings.reflections;
                (reflections.distance_m, reflections.thickness_m) = (distance_m, thickness_m);
                (reflections.steps, reflections.resolution) = (steps, resolution);
            });
            let found = radiance(&mut renderer, &scene, &request, 1);
            let are_numbers = found.iter().flatten().all(|value| value.is_finite() && *value >= 0.0);
            assert!(are_numbers && found.iter().any(|pixel| pixel[1] > 0.0), "{width} × {height}, {resolution:?}");
        }
    }
}
