//! The ground: what hangs over it against closed forms, where shadows fall, and what knows nothing of it.

#![allow(clippy::unwrap_used, reason = "tests panic where they expect something")]

use crate::common::ground::{encoded, linear, product_shot, scene_of};
use crate::common::renderer;
use glam::{Mat4, Quat, Vec2, Vec3};
use manypass::{Aov, Averaging, Background, Environment, FrameRequest, Ground, Path, Renderer, Tonemap, View};
use manypass_scene::material::Specular;
use manypass_scene::{
    AlphaMode, EnvironmentMap, Light, LightKind, Material, Mesh, Node, Primitive, Projection, Scene, TexturedFactor,
    primitives,
};
use std::f32::consts::{FRAC_PI_2, TAU};

const SIZE: u32 = 96;
/// What the picture shows of the world, in metres.
const HEIGHT_M: f32 = 8.0;

/// A sphere of 1 m over the origin of the ground.
fn scene(middle_m: f32) -> Scene {
    scene_of(primitives::uv_sphere(1.0, 48, 24), middle_m)
}

/// From above, or from below: +X is on the right.
fn request(pitch_rad: f32, ground: Ground) -> FrameRequest {
    let rotation = Quat::from_rotation_x(-pitch_rad);
    let projection = Projection::Orthographic { height_m: HEIGHT_M, near_m: 0.1, far_m: 40.0 };
    let world_from_view = Mat4::from_rotation_translation(rotation, rotation * Vec3::new(0.0, 0.0, 20.0));
    let mut request = FrameRequest {
        averaging: Averaging::Both,
        ground_height_m: Some(0.0),
        ..FrameRequest::new(SIZE, SIZE, View { world_from_view, projection })
    };
    request.settings.environment.source = Environment::Color([1.0; 3]);
    request.settings.background.source = Background::Transparent;
    request.settings.tone_map.curve = Tonemap::None;
    request.settings.ground.mode = ground;
    request
}

/// A directional light from the left, 45° above.
fn light_from_the_left(scene: &mut Scene) {
    scene.lights.push(Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() });
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(1.0, -1.0, 0.0).normalize());
    scene.add_node(None, Node { light: Some(0), rotation, ..Node::default() });
    scene.update_transforms();
}

/// Red and alpha of the radiance at x metres to the right of the middle and z before it, seen from above.
fn at(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, places: &[(f32, f32)]) -> Vec<[f32; 2]> {
    renderer.render(scene, request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    let pixel = |m: f32| ((m / HEIGHT_M + 0.5) * SIZE as f32) as usize;
    let texel = |(x, z): &(f32, f32)| 4 * (pixel(*z) * SIZE as usize + pixel(*x));
    places.iter().map(|place| [radiance[texel(place)], radiance[texel(place) + 3]]).collect()
}

#[test]
fn a_sphere_takes_its_form_factor_of_the_light_from_everywhere() {
    let mut renderer = renderer();
    for middle_m in [1.0f32, 3.0] {
        let places: Vec<(f32, f32)> = [1.3f32, 1.7, 2.2, 3.0].iter().map(|across| (*across, 0.0)).collect();
        let found = at(&mut renderer, &scene(middle_m), &request(FRAC_PI_2, Ground::Color([1.0; 3])), &places);
        for ((across, _), [radiance, alpha]) in places.iter().zip(found) {
            let distance = across.hypot(middle_m);
            let truth = 1.0 - middle_m / distance.powi(3);
            println!("{middle_m} m, {across} m: {radiance}, {truth}");
            assert!((radiance - truth).abs() < 0.08 && (alpha - 1.0).abs() < 1e-3, "{middle_m} {across}: {radiance}");
        }
    }
}

#[test]
fn the_shadow_of_a_directional_light_lies_where_it_falls() {
    let mut renderer = renderer();
    let mut scene = scene(2.0);
    light_from_the_left(&mut scene);
    let places = [(2.0, 0.0), (2.9, 0.0), (2.0, 0.8), (-2.0, 0.0), (2.0, 1.4), (3.8, 0.0), (2.0, -3.0)];
    let mut pictures = Vec::new();
    for path in [Path::Deferred, Path::Forward] {
        let dark = request(FRAC_PI_2, Ground::Shadow).with(|settings| {
            settings.environment.source = Environment::None;
            settings.render.path = path;
        });
        let found = at(&mut renderer, &scene, &dark, &places);
        let alphas: Vec<f32> = found.iter().map(|[_, alpha]| *alpha).collect();
        // Something is seen of the background in the darkest shadow, and the picture shows the scene as a whole: far from
        // it the shadow fades towards the border.
        let [under, far, beside, ref lit @ ..] = alphas[..] else { panic!("{alphas:?}") };
        let is_dark = |alpha: f32| (0.7..0.81).contains(&alpha);
        assert!(is_dark(under) && is_dark(beside) && (0.3..under).contains(&far), "{path:?}: {alphas:?}");
        assert!(lit.iter().all(|alpha| *alpha < 0.03), "{path:?}: {alphas:?}");
        assert!(found.iter().all(|[radiance, _]| *radiance == 0.0), "{path:?}: a shadow gives no light");
        pictures.push(renderer.read_display().unwrap());
        let open = dark.with(|settings| settings.shadows.enabled = false);
        assert!(at(&mut renderer, &scene, &open, &places).iter().all(|[_, alpha]| *alpha == 0.0));
    }
    let apart = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(apart < pictures[0].len() / 500, "{apart}");
}

#[test]
fn a_broad_source_of_a_picture_casts_a_shadow_and_is_counted_once() {
    // A sun behind clouds on the left, 45° above: of the light on the ground about two fifths.
    let to_sun = Vec3::new(-1.0, 1.0, 0.0).normalize();
    let under = |peak: f32| {
        let map = EnvironmentMap::from_fn("cloudy", 256, 128, |to| {
            let from_sun = to.dot(to_sun).clamp(-1.0, 1.0).acos().to_degrees() / 8.0;
            Vec3::splat(0.6 + peak * (-from_sun * from_sun).exp())
        });
        Scene { environment: Some(map.into()), ..scene(2.0) }
    };
    let of = |ground| request(FRAC_PI_2, ground).with(|settings| settings.environment.source = Environment::File);
    let mut renderer = renderer();
    let places = [(2.0, 0.0), (-2.0, 0.0)];
    let mut alphas = |scene: &Scene, request: &FrameRequest| {
        at(&mut renderer, scene, request, &places).iter().map(|[_, alpha]| *alpha).collect::<Vec<f32>>()
    };
    // What is left there is 0.59 of light from everywhere, less what the sphere covers of it.
    let [shadow, lit] = alphas(&under(30.0), &of(Ground::Shadow))[..] else { panic!("two places") };
    assert!(shadow > 0.4 && lit < 0.15, "{shadow} {lit}");
    let open = of(Ground::Shadow).with(|settings| settings.shadows.enabled = false);
    for found in [alphas(&under(30.0), &open), alphas(&under(0.0), &of(Ground::Shadow))] {
        assert!(found.iter().all(|alpha| *alpha < 0.2), "{found:?}");
    }
    // Beside the shadow a white floor has all of it: 0.6, and 30 π (8°)² cos 45° / π.
    let expected = 0.6 + 30.0 * 8.0f32.to_radians().powi(2) * std::f32::consts::FRAC_1_SQRT_2;
    let found = at(&mut renderer, &under(30.0), &of(Ground::Color([1.0; 3])), &[(0.0, 3.0)])[0];
    assert!((0.88..1.05).contains(&(found[0] / expected)), "{found:?}, not {expected}");
}

#[test]
fn it_is_seen_from_above_alone_and_by_no_variable() {
    let mut renderer = renderer();
    let scene = scene(1.0);
    for (pitch_rad, shows) in [(0.6, true), (-0.6, false), (0.0, false)] {
        let request = |ground| FrameRequest {
            want_aovs: vec![Aov::Depth, Aov::ObjectId, Aov::Position],
            ..request(pitch_rad, ground)
        };
        let mut draw = |ground| {
            renderer.render(&scene, &request(ground)).unwrap();
            let variables = [Aov::Depth, Aov::ObjectId, Aov::Position].map(|aov| renderer.read_aov(aov).unwrap());
            (renderer.read_display().unwrap(), variables)
        };
        let (without, variables) = draw(Ground::None);
        for ground in [Ground::Shadow, Ground::Color([0.5; 3])] {
            let (with, same) = draw(ground);
            assert_eq!(with != without, shows, "{pitch_rad}: {ground:?}");
            assert!(format!("{variables:?}") == format!("{same:?}"), "{pitch_rad}: {ground:?} is in a variable");
        }
    }
}

#[test]
fn the_studio_has_one_shadow_on_its_own() {
    let mut renderer = renderer();
    let scene = scene(1.0);
    let by_default = FrameRequest::of_scene(&scene, SIZE, SIZE);
    assert_eq!(
        (by_default.settings.ground.mode, by_default.ground_height_m.map(|m| m.abs() < 1e-3)),
        (Ground::Auto, Some(true))
    );
    let level = |renderer: &mut Renderer, request: &FrameRequest| {
        renderer.render(&scene, request).unwrap();
        renderer.read_display().unwrap().iter().map(|value| f64::from(*value)).sum::<f64>()
    };
    let with = level(&mut renderer, &by_default);
    assert_eq!((renderer.stats().lights, renderer.stats().shadowed_lights), (0, 1));
    let without = level(&mut renderer, &by_default.with(|settings| settings.ground.mode = Ground::None));
    assert!(with < 0.99 * without, "{with} {without}");
    let cut_out = |ground| {
        by_default
            .with(|settings| (settings.background.source, settings.ground.mode) = (Background::Transparent, ground))
    };
    assert_eq!(level(&mut renderer, &cut_out(Ground::Auto)), level(&mut renderer, &cut_out(Ground::None)));
    // A map that is right is not drawn again.
    let draws = [0; 2].map(|_| {
        level(&mut renderer, &by_default);
        renderer.stats().draws
    });
    assert!(draws[0] == draws[1], "{draws:?}");
}

/// How far the pixels of the border, and of all of the picture without surfaces, are from white.
fn shade(pixels: &[u8], (width, height): (u32, u32)) -> (u32, u32) {
    let mut sums = (0, 0);
    for (index, pixel) in (0..).zip(pixels.chunks_exact(4)) {
        let (x, y) = (index % width, index / width);
        let dark = pixel[..3].iter().map(|value| u32::from(255 - value)).sum::<u32>();
        if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
            sums.0 += dark;
        }
        sums.1 += dark;
    }
    sums
}

#[test]
fn the_border_of_a_product_shot_is_white_and_the_shadow_is_there() {
    let mut renderer = renderer();
    let shapes = [
        primitives::uv_sphere(1.0, 48, 24),
        primitives::cube(Vec3::splat(2.0)),
        primitives::cube(Vec3::new(0.4, 3.0, 0.4)),
        primitives::cube(Vec3::new(4.0, 0.1, 3.0)),
        primitives::cube(Vec3::new(6.0, 1.0, 0.5)),
    ];
    for (index, shape) in shapes.into_iter().enumerate() {
        let scene = scene_of(shape, 0.0);
        for size in [(96, 72), (64, 64), (60, 100)] {
            for pitch_deg in [3.0, 15.0, 28.0, 60.0] {
                let shot = product_shot(&scene, size, [30.0, pitch_deg]);
                renderer.render(&scene, &shot).unwrap();
                let with = shade(&renderer.read_display().unwrap(), size);
                assert_eq!(with.0, 0, "shape {index}, {size:?}, {pitch_deg} degrees: the border is not white");
                let bare = shot.with(|settings| settings.ground.mode = Ground::None);
                renderer.render(&scene, &bare).unwrap();
                let without = shade(&renderer.read_display().unwrap(), size);
                assert!(with.1 > without.1, "shape {index}, {size:?}, {pitch_deg} degrees: no shadow");
            }
        }
    }
}

#[test]
fn before_nothing_a_long_shadow_fades_evenly_from_the_model_to_the_border() {
    // Of a box of 1 m and ten times as high, whose shadow goes on beyond the picture.
    let mut scene = scene_of(primitives::cube(Vec3::new(1.0, 10.0, 1.0)), 5.0);
    light_from_the_left(&mut scene);
    let request = request(FRAC_PI_2, Ground::Shadow).with(|settings| settings.environment.source = Environment::None);
    let mut renderer = renderer();
    let places: Vec<(f32, f32)> = (4..24u8).map(|step| (f32::from(step) / 6.0 + 0.04, 0.0)).collect();
    let found = at(&mut renderer, &scene, &request, &places);
    let pixel_m = HEIGHT_M / SIZE as f32;
    for ((x, _), [_, alpha]) in places.iter().zip(found) {
        // From the footprint's border, 0.5 m from the middle, to 0.98 of the way to the picture's.
        let middle_m = ((x / pixel_m).floor() + 0.5) * pixel_m;
        let faded = ((middle_m - 0.5) / (0.98 * 0.5 * HEIGHT_M - 0.5)).clamp(0.0, 1.0);
        let lit = faded.powi(3) * (faded * (faded * 6.0 - 15.0) + 10.0);
        let shadow = 1.0 - lit.powf(1.5);
        let truth = shadow - 0.2 * shadow.powi(4);
        assert!((alpha - truth).abs() < 0.02, "{x} m: {alpha}, {truth}");
    }
    renderer.render(&scene, &request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    let border = (0..SIZE as usize).flat_map(|at| [at, SIZE as usize * at, SIZE as usize * (at + 1) - 1]);
    assert!(border.into_iter().all(|pixel| radiance[4 * pixel + 3] == 0.0), "the border is not free");
}

#[test]
fn before_an_environment_a_shadow_runs_out_of_the_picture() {
    let mut renderer = renderer();
    let scene = scene(2.0);
    // The same metres in the middle of a picture of twice as many, whose border is far away.
    let mut red = |scale: u32| {
        let mut request = request(FRAC_PI_2, Ground::Shadow).with(|settings| {
            settings.environment.source = Environment::Sky;
            settings.environment.sun_elevation_deg = 35.0;
            settings.environment.sun_azimuth_deg = 90.0;
            settings.background.source = Background::Environment;
        });
        (request.width, request.height) = (scale * SIZE, scale * SIZE);
        let Projection::Orthographic { height_m, .. } = &mut request.camera.projection else { panic!("parallel rays") };
        *height_m = scale as f32 * HEIGHT_M;
        renderer.render(&scene, &request).unwrap();
        let radiance = renderer.read_radiance().unwrap();
        let (side, first) = ((scale * SIZE) as usize, ((scale - 1) * SIZE / 2) as usize);
        let pixels = (0..SIZE as usize).flat_map(|row| (0..SIZE as usize).map(move |column| [row, column]));
        pixels.map(|[row, column]| radiance[4 * ((first + row) * side + first + column)]).collect::<Vec<f32>>()
    };
    let [near, far] = [1, 2].map(&mut red);
    let most = far.iter().copied().fold(0.0, f32::max);
    let apart = near.iter().zip(&far).filter(|(near, far)| (*near - *far).abs() > 0.02 * most).count();
    assert!(apart < near.len() / 200, "{apart} pixels follow the border");
    // The sun is on the right: the shadow lies on the left border.
    let side = SIZE as usize;
    let [shadow, open] = [0, side - 1].map(|x| near[side / 2 * side + x]);
    assert!(shadow < 0.6 * open, "{shadow} beside {open}");
}

/// The share of light that is kept from the ground by a ball of glass of index 1.5 whose base colour has this mean: all
/// but what is not reflected at two walls, in the mean of Schlick's Fresnel over the ball, and not absorbed.
fn kept_by_glass(mean: f32) -> f32 {
    let reflected = 0.04 + 0.96 / 21.0;
    1.0 - mean * (1.0 - reflected) * (1.0 - reflected)
}

/// The sphere of glass of a base colour.
fn glass_ball(middle_m: f32, base_color: Vec3) -> Scene {
    let mut scene = scene(middle_m);
    scene.materials[0] = Material {
        base_color_factor: base_color.extend(1.0),
        metallic_factor: 0.0,
        roughness_factor: 0.0,
        transmission: Some(TexturedFactor::new(1.0)),
        ..Material::default()
    };
    scene
}

const GLASSES: [(Vec3, f32); 2] = [(Vec3::ONE, 1.0), (Vec3::new(1.0, 0.2, 0.2), 1.4 / 3.0)];

#[test]
fn glass_keeps_from_the_ground_what_it_reflects_and_absorbs() {
    let mut renderer = renderer();
    // What hangs over the ground, beside the ball that stands on it.
    let around: Vec<(f32, f32)> =
        (0..24u8).map(|step| Vec2::from_angle(f32::from(step) * TAU / 24.0) * 1.3).map(|at| (at.x, at.y)).collect();
    let mean = |found: Vec<[f32; 2]>| found.iter().map(|[radiance, _]| *radiance).sum::<f32>() / found.len() as f32;
    let floor = request(FRAC_PI_2, Ground::Color([1.0; 3]));
    let opaque = 1.0 - mean(at(&mut renderer, &scene(1.0), &floor, &around));
    for (base_color, of_color) in GLASSES {
        let dark = 1.0 - mean(at(&mut renderer, &glass_ball(1.0, base_color), &floor, &around));
        let expected = opaque * kept_by_glass(of_color);
        assert!((dark - expected).abs() < 0.25 * expected, "{base_color}: {dark}, not {expected} of {opaque}");
    }
    // The middle of the shadow of the light, and a place that has none.
    let steps = || (0..5u8).map(|step| 0.2 * f32::from(step) - 0.4);
    let shadow: Vec<(f32, f32)> = steps().flat_map(|x| steps().map(move |z| (2.0 + x, z))).collect();
    let sunny = floor.with(|settings| settings.environment.source = Environment::None);
    for (base_color, of_color) in GLASSES {
        let mut scene = glass_ball(2.0, base_color);
        light_from_the_left(&mut scene);
        let dark = mean(at(&mut renderer, &scene, &sunny, &shadow));
        let open = mean(at(&mut renderer, &scene, &sunny, &[(-2.0, 2.0)]));
        let kept = 1.0 - dark / open;
        assert!((kept - kept_by_glass(of_color)).abs() < 0.03, "{base_color}: {kept}, not {}", kept_by_glass(of_color));
    }
}

#[test]
fn glass_stands_on_white() {
    let (mut renderer, size) = (renderer(), (96, 72));
    let mut shadow_of = |scene: &Scene| {
        let shot = product_shot(scene, size, [30.0, 28.0]);
        let [with, without] = [Ground::Shadow, Ground::None].map(|ground| {
            renderer.render(scene, &shot.with(|settings| settings.ground.mode = ground)).unwrap();
            shade(&renderer.read_display().unwrap(), size)
        });
        assert_eq!(with.0, 0, "the border is not white");
        with.1.saturating_sub(without.1)
    };
    let opaque = shadow_of(&scene(0.0));
    let [clear, red] = GLASSES.map(|(base_color, _)| shadow_of(&glass_ball(0.0, base_color)));
    assert!(10 * clear > opaque && 2 * red > 3 * clear, "{clear}, {red}; {opaque} if it is opaque");
}

#[test]
fn the_shadow_does_not_jump_on_a_turntable() {
    let (mut renderer, size) = (renderer(), (96, 72));
    let scene = scene_of(primitives::cube(Vec3::new(3.0, 1.0, 1.0)), 0.5);
    let mut shadow_at = |request: &FrameRequest| {
        let [with, without] = [Ground::Shadow, Ground::None].map(|ground| {
            renderer.render(&scene, &request.with(|settings| settings.ground.mode = ground)).unwrap();
            shade(&renderer.read_display().unwrap(), size)
        });
        f64::from(with.1 - without.1)
    };
    let shadows: Vec<f64> =
        (0..72u8).map(|frame| shadow_at(&product_shot(&scene, size, [5.0 * f32::from(frame), 20.0]))).collect();
    // The model hides more of it from some sides than from others.
    let most = 0.25 * shadows.iter().copied().fold(0.0, f64::max);
    for (frame, shadow) in shadows.iter().enumerate() {
        let next = shadows[(frame + 1) % shadows.len()];
        assert!((next - shadow).abs() < most, "frame {frame}: {shadow}, then {next}");
    }
}

/// A ball whose shadow lies on its right, and a pane of a material before that, along the light so that it casts no
/// shadow but a line.
fn behind_pane(material: Material) -> Scene {
    let mut scene = scene(2.0);
    light_from_the_left(&mut scene);
    let specular = Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() });
    scene.materials.push(Material { metallic_factor: 0.0, roughness_factor: 0.0, specular, ..material });
    let pane = Primitive { material: Some(1), ..primitives::cube(Vec3::new(1.5, 3.0, 0.02)) };
    scene.meshes.push(Mesh { primitives: vec![pane], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(1), translation: Vec3::new(1.8, 2.5, 1.5), ..Node::default() });
    scene.update_transforms();
    scene
}

#[test]
fn a_shadow_is_seen_through_glass_as_it_is() {
    let mut renderer = renderer();
    let request = request(0.6, Ground::Shadow).with(|settings| {
        settings.environment.source = Environment::None;
        settings.background.source = Background::Color([1.0; 3]);
        settings.tone_map.dither = 0.0;
        settings.occlusion.enabled = false.into();
        settings.reflections.enabled = false.into();
    });
    let mut seen = |material: Material| {
        renderer.render(&behind_pane(material), &request).unwrap();
        renderer.read_display().unwrap()
    };
    let glass = |color: Vec3| Material {
        base_color_factor: color.extend(1.0),
        transmission: Some(TexturedFactor::new(1.0)),
        ..Material::default()
    };
    let nothing =
        Material { base_color_factor: Vec3::ZERO.extend(0.0), alpha_mode: AlphaMode::Blend, ..Material::default() };
    let bare = seen(nothing);
    let clear = seen(glass(Vec3::ONE));
    assert!(bare.iter().zip(&clear).all(|(bare, clear)| bare.abs_diff(*clear) <= 1), "clear glass shows");
    let color = Vec3::new(0.9, 0.2, 0.05);
    let red = seen(glass(color));
    // The pixels of the pane, without its edges.
    let pixels = (20..46usize).flat_map(|row| (62..76usize).map(move |column| 4 * (row * SIZE as usize + column)));
    let (mut count, mut dark, mut off) = (0, 0, 0);
    for at in pixels {
        let apart = |channel: usize| {
            let expected = encoded(linear(bare[at + channel]) * color[channel]);
            (f32::from(red[at + channel]) - expected).abs()
        };
        let most = (0..3).map(apart).fold(0.0, f32::max);
        assert!(most < 6.0, "{most} levels");
        (count, dark, off) = (count + 1, dark + u32::from(bare[at] < 200), off + u32::from(most > 2.0));
    }
    assert!(dark > 40 && dark < count - 80, "{dark} of {count} in shadow: nothing to look at");
    assert!(20 * off <= count, "{off} of {count}");
}
