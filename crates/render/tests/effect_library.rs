//! Properties of the built-in effects that need a scene: what each must do, and what it must leave alone.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{self, built_in_with as with, renderer};
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
fn outlines_tell_objects_apart_where_nothing_else_does() {
    let mut renderer = renderer();
    let (width, height) = (64u32, 16u32);
    let mut scene = Scene::default();
    // Two walls of one colour in one plane, which meet in the middle; then a third with the material of the second.
    for x in [-2.0, 0.0, 2.0] {
        put(&mut scene, cube(Vec3::new(2.0, 2.0, 0.1)), Vec3::splat(0.5), Vec3::new(x, 0.0, 0.0));
    }
    let shared = scene.meshes[1].primitives[0].material;
    Arc::make_mut(&mut scene.meshes[2]).primitives[0].material = shared;
    let projection = Projection::Orthographic { height_m: 1.0, near_m: 0.1, far_m: 10.0 };
    let mut request = request(&mut scene, (width, height), Vec3::Z * 5.0, Vec3::ZERO, projection);
    renderer.load(&scene).unwrap();
    let mut lines = |settings: &[&str]| -> Vec<usize> {
        request.effects = vec![with(&renderer, "outline", &[&["color=5,0,0", "width_px=2"][..], settings].concat())];
        let found = radiance(&mut renderer, &scene, &request);
        let row = &found[8 * width as usize..9 * width as usize];
        assert!(row.iter().all(|pixel| (pixel[1] - 0.5).abs() < 0.01 || pixel[1] < 0.01), "{row:?}");
        row.iter().enumerate().filter(|(_, pixel)| pixel[0] > 4.0).map(|(x, _)| x).collect()
    };
    // The picture shows x from -2 to 2: walls meet at -1 and 1, columns 16 and 48.
    assert_eq!(lines(&[]), [] as [usize; 0], "depth and normals tell nothing");
    assert_eq!(lines(&["object=1"]), [15, 16, 47, 48]);
    assert_eq!(lines(&["material=1"]), [15, 16]);
    // Surfaces are drawn once more for ids only where a setting wants them.
    for (settings, expected) in
        [(&[][..], false), (&["object=1"], true), (&["material=0.3"], true), (&["object=0"], false)]
    {
        request.effects = vec![with(&renderer, "outline", settings)];
        let plan = renderer.plan(&scene, &request).unwrap();
        assert_eq!(plan.passes.iter().any(|pass| pass.name == "ids"), expected, "{settings:?}");
    }
    // Forward paths have no ids, and say so.
    request.settings.render.path = manypass::Path::Forward;
    let error = renderer.render(&scene, &request).unwrap_err().to_string();
    assert!(error.contains("render.path=deferred"), "{error}");
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

/// The display colours of so many samples.
fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<u8> {
    for sample_index in 0..samples {
        let request = FrameRequest { sample_count: samples, sample_index, ..request.clone() };
        if sample_index + 1 < samples {
            renderer.accumulate(scene, &request).unwrap();
        } else {
            renderer.render(scene, &request).unwrap();
        }
    }
    renderer.read_display().unwrap()
}

/// The ratio of white to the difference of two pictures, dB.
fn psnr_db(a: &[u8], b: &[u8]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
    10.0 * (255.0f64.powi(2) * a.len() as f64 / squares).log10()
}

/// Bars and a cube turned by so many degrees before a dark background.
fn edges(turned_deg: f32) -> Scene {
    let mut scene = Scene::default();
    for i in -2i8..=2 {
        let color = [Vec3::splat(0.9), Vec3::new(0.9, 0.5, 0.1), Vec3::new(0.2, 0.5, 0.9)][i.unsigned_abs() as usize];
        put(&mut scene, cube(Vec3::new(0.25, 3.0, 0.25)), color, Vec3::X * 0.6 * f32::from(i));
    }
    let turned = glam::Quat::from_rotation_z(turned_deg.to_radians());
    for at in 0..scene.nodes.len() {
        let node = &mut scene.nodes[at];
        (node.rotation, node.translation) = (turned, turned * node.translation);
    }
    scene
}

#[test]
fn smaa_is_nearer_to_many_samples_than_fxaa_and_leaves_flat_areas_alone() {
    let mut renderer = renderer();
    let effects = ["fxaa", "smaa"].map(|name| with(&renderer, name, &[]));
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    let mut measure = |scene: &Scene, mut request: FrameRequest, name: &str| {
        renderer.load(scene).unwrap();
        let reference = picture(&mut renderer, scene, &request, 64);
        let plain = picture(&mut renderer, scene, &request, 1);
        let [fxaa, smaa] = effects.clone().map(|effect| {
            request.effects = vec![effect];
            picture(&mut renderer, scene, &request, 1)
        });
        let found = [&plain, &fxaa, &smaa].map(|picture| psnr_db(picture, &reference));
        println!("{name}: {:.2} dB without, {:.2} dB with fxaa, {:.2} dB with smaa", found[0], found[1], found[2]);
        sums = [0, 1, 2].map(|at| sums[at] + found[at]);
        count += 1.0;
        // Pixels that differ little from those around them are as they were.
        let (width, height) = (request.width as usize, request.height as usize);
        let at = |x: usize, y: usize| &plain[4 * (y * width + x)..][..4];
        let (mut flat, mut changed) = (0, 0);
        for (x, y) in (1..width - 1).flat_map(|x| (1..height - 1).map(move |y| (x, y))) {
            let around = [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)];
            if around.iter().flat_map(|other| other.iter().zip(at(x, y))).all(|(a, b)| a.abs_diff(*b) < 4) {
                flat += 1;
                changed += usize::from(smaa[4 * (y * width + x)..][..4] != *at(x, y));
            }
        }
        assert!(flat > width * height / 8 && changed == 0, "{name}: {changed} of {flat}");
    };
    for turned_deg in [0.0, 3.0, 11.0, 45.0, 52.0] {
        let mut scene = edges(turned_deg);
        let camera = Projection::Orthographic { height_m: 3.6, near_m: 0.1, far_m: 20.0 };
        let request = request(&mut scene, (96, 96), Vec3::new(0.013, 0.007, 5.0), Vec3::new(0.013, 0.007, 0.0), camera);
        measure(&scene, request, &format!("{turned_deg}°"));
    }
    let spheres = manypass_testkit::scenes::rows_of_spheres().scene;
    measure(&spheres, common::plain_request(&spheres, (97, 65)), "spheres");
    let [plain, fxaa, smaa] = sums.map(|sum| sum / count);
    println!("mean: {plain:.2} dB without, {fxaa:.2} dB with fxaa, {smaa:.2} dB with smaa");
    assert!(smaa > fxaa + 0.3 && smaa > plain + 3.0, "{plain} {fxaa} {smaa}");
}

/// An effect that draws the result of an expression of `p`, the place of the pixel's middle.
fn drawing(renderer: &Renderer, expression: &str) -> Arc<WgslEffect> {
    let source = format!(
        "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {{
            let p = position.xy;
            return {expression};
        }}"
    );
    Arc::new(WgslEffect::new(renderer.gpu(), "drawing.wgsl", &source).unwrap_or_else(|error| panic!("{error}")))
}

#[test]
fn a_lens_moves_what_is_drawn_as_its_formula_says_and_keeps_the_frame_full() {
    let mut renderer = renderer();
    let (width, height) = (128usize, 72usize);
    let (scene, mut request) = nothing((128, 72));
    renderer.load(&scene).unwrap();
    // The place of every pixel in units of the picture's half diagonal, around 1 because light is never below 0.
    let half_px = f64::from(64.0f32.hypot(36.0));
    let places = drawing(&renderer, "vec4f((p - 0.5 * view.size_px) / (0.5 * length(view.size_px)) + 1.0, 1.0, 1.0)");
    let mut seen = |settings: &[&str]| {
        request.effects = vec![places.clone(), with(&renderer, "lens", settings)];
        radiance(&mut renderer, &scene, &request)
    };
    for (k1, k2) in [(-0.2, 0.0), (0.3, 0.0), (-0.1, 0.15), (0.2, -0.05)] {
        let k = [format!("k1={k1}"), format!("k2={k2}"), "chromatic=0".into()];
        let k: Vec<&str> = k.iter().map(String::as_str).collect();
        let found = seen(&[&k[..], &["fill=0"]].concat());
        let mut compared = 0;
        for (at, pixel) in found.iter().enumerate() {
            let drawn_at = [at % width, at / width];
            let drawn_at = [drawn_at[0] as f64 + 0.5 - 64.0, drawn_at[1] as f64 + 0.5 - 36.0].map(|x| x / half_px);
            let place = [f64::from(pixel[0]) - 1.0, f64::from(pixel[1]) - 1.0];
            // At the border a lookup is half a pixel inside; outside there is nothing.
            if pixel[2] < 0.999 || place[0].abs() * half_px > 63.0 || place[1].abs() * half_px > 35.0 {
                continue;
            }
            let r2 = place[0].powi(2) + place[1].powi(2);
            let stretch = 1.0 + k1 * r2 + k2 * r2 * r2;
            let off_px = (0..2).map(|i| (place[i] * stretch - drawn_at[i]).abs() * half_px).fold(0.0, f64::max);
            // Half floats of 1 to 2 are 0.001 apart, which is 0.07 px, and lookups lie between them.
            assert!(off_px < 0.25, "{k1}, {k2}: {off_px} px at {drawn_at:?}");
            compared += 1;
        }
        assert!(compared > 4000, "{compared}");
        // With a zoom nothing is empty, and somewhere the border shows the frame's own.
        let found = seen(&k);
        assert!(found.iter().all(|pixel| pixel[2] == 1.0 && pixel[3] == 1.0), "{k1}, {k2}");
        let outermost =
            |i: usize| found.iter().map(|pixel| (pixel[i] - 1.0).abs()).fold(0.0, f32::max) * half_px as f32;
        let left_px = (64.0 - outermost(0)).min(36.0 - outermost(1));
        assert!((0.0..1.5).contains(&left_px), "{k1}, {k2}: {left_px} px are out of the frame");
    }
    let neutral = ["k1=0", "k2=0", "chromatic=0"];
    for (at, pixel) in seen(&neutral).iter().enumerate() {
        let x = ((at % width) as f64 + 0.5 - 64.0) / half_px + 1.0;
        assert!((f64::from(pixel[0]) - x).abs() < 0.003, "{pixel:?} is not {x}");
    }
    // Light at the corners falls by the fourth power of the cosine, whose square is 1 / (1 + tan²).
    let tangent = (22.5f64.to_radians().tan() * half_px / 36.0) * (1.0 - 0.5 * 2f64.sqrt() / half_px);
    let corner = f64::from(seen(&[&neutral[..], &["vignette=1"]].concat())[0][2]);
    assert!((corner * (1.0 + tangent.powi(2)).powi(2) - 1.0).abs() < 0.02, "{corner}, {tangent}");
    // Red is drawn farther out than blue, white stays white.
    let wide = drawing(&renderer, "vec4f(vec3f(max(length(p - 0.5 * view.size_px) / 36.0, 0.0)), 1.0)");
    request.effects = vec![wide, with(&renderer, "lens", &["k1=0", "chromatic=0.05"])];
    let found = radiance(&mut renderer, &scene, &request);
    let [red, green, blue, _] = found[(height / 2) * width + 10];
    let apart = (blue - red) / green;
    assert!((0.025..0.05).contains(&apart), "{red} {green} {blue}");
    request.effects = vec![flat(&renderer, Vec3::splat(0.5)), with(&renderer, "lens", &["chromatic=0.05"])];
    let found = radiance(&mut renderer, &scene, &request);
    assert!(found.iter().flat_map(|pixel| &pixel[..3]).all(|c| (c - 0.5).abs() < 0.002), "white stays white");
}

/// A wall at so many metres.
fn wall(distance_m: f32) -> (Scene, FrameRequest) {
    let mut scene = Scene::default();
    put(&mut scene, cube(Vec3::new(400.0, 400.0, 0.01)), Vec3::splat(0.5), Vec3::NEG_Z * (distance_m + 0.005));
    let request = request(&mut scene, (128, 128), Vec3::ZERO, Vec3::NEG_Z, perspective(45.0));
    (scene, request)
}

#[test]
fn depth_of_field_leaves_what_is_sharp_and_spreads_light_over_the_disk_of_a_thin_lens() {
    let mut renderer = renderer();
    let noise = drawing(
        &renderer,
        "vec4f(fract(sin(dot(floor(p), vec2f(12.9898, 78.233))) * vec3f(43758.5, 23421.6, 9182.1)), 1.0)",
    );
    let (scene, mut request) = wall(5.0);
    renderer.load(&scene).unwrap();
    request.effects = vec![noise.clone()];
    let plain = radiance(&mut renderer, &scene, &request);
    for focus in ["focus_m=5", "focus_m=0"] {
        request.effects = vec![noise.clone(), with(&renderer, "dof", &["f_stop=0.1", focus])];
        assert_eq!(radiance(&mut renderer, &scene, &request), plain, "{focus}");
    }
    // A small bright spot in front of, and behind, what is sharp.
    for (distance_m, focus_m, f_stop) in [(20.0, 2.0, 0.25), (8.0, 2.0, 0.5), (2.0, 8.0, 0.3), (3.0, 30.0, 0.4)] {
        let (scene, mut request) = wall(distance_m);
        renderer.load(&scene).unwrap();
        let spot = drawing(&renderer, "vec4f(vec3f(select(0.0, 100.0, all(abs(p - 64.0) < vec2f(2.0)))), 1.0)");
        let dof = with(&renderer, "dof", &[&format!("focus_m={focus_m}"), &format!("f_stop={f_stop}"), "taps=128"]);
        request.effects = vec![spot, dof];
        let found = radiance(&mut renderer, &scene, &request);
        let (mut sum, mut moment) = (0.0, 0.0);
        for (at, pixel) in found.iter().enumerate() {
            let (x, y) = ((at % 128) as f64 + 0.5 - 64.0, (at / 128) as f64 + 0.5 - 64.0);
            sum += f64::from(pixel[0]);
            moment += f64::from(pixel[0]) * (x * x + y * y);
        }
        // The circle of confusion by similar triangles, in metres on a sensor of 24 mm.
        let focal_m = 0.012 / 22.5f64.to_radians().tan();
        let image = |m: f64| 1.0 / (1.0 / focal_m - 1.0 / m);
        let [sharp, here] = [focus_m, f64::from(distance_m)].map(image);
        let radius_px = 0.5 * focal_m / f_stop * (here - sharp).abs() / here / 0.024 * 128.0;
        // A disk's mean square of distances is half of its radius' square; that of the spot adds to it.
        let found_px = (2.0 * (moment / sum - 16.0 / 6.0)).sqrt();
        println!(
            "{distance_m} m, focus {focus_m} m: radius {found_px:.2} px, should be {radius_px:.2}; sum {}",
            sum / 1600.0
        );
        assert!((found_px / radius_px - 1.0).abs() < 0.15, "{found_px} px instead of {radius_px}");
        assert!((sum / 1600.0 - 1.0).abs() < 0.05, "{} of the light", sum / 1600.0);
    }
}

#[test]
fn depth_of_field_is_near_to_the_mean_of_many_views_through_the_lens() {
    let mut renderer = renderer();
    let mut scene = Scene::default();
    put(&mut scene, cube(Vec3::new(400.0, 400.0, 0.1)), Vec3::new(0.1, 0.15, 0.3), Vec3::NEG_Z * 40.0);
    for i in 0..7i8 {
        let across = f32::from(i) - 3.0;
        put(&mut scene, cube(Vec3::new(0.8, 12.0, 0.1)), Vec3::new(0.8, 0.7, 0.1), Vec3::new(3.0 * across, 2.0, -20.0));
        put(&mut scene, cube(Vec3::new(0.3, 0.3, 0.1)), Vec3::new(0.9, 0.2, 0.1), Vec3::new(0.8 * across, -0.6, -5.0));
    }
    put(&mut scene, cube(Vec3::new(0.16, 4.0, 0.02)), Vec3::new(0.2, 0.9, 0.4), Vec3::new(-0.5, 0.0, -2.0));
    let size = (128, 96);
    let (focus_m, aperture_m) = (5.0, 0.3);
    let mut request = request(&mut scene, size, Vec3::ZERO, Vec3::NEG_Z, perspective(40.0));
    renderer.load(&scene).unwrap();
    // Views from places of the aperture, each turned to what is in focus: so small an angle is as good as a shifted lens.
    let (views, sharp) = (64, request.camera);
    let mut truth = vec![[0.0f32; 4]; (size.0 * size.1) as usize];
    for i in 0..views {
        let radius = 0.5 * aperture_m * ((i as f32 + 0.5) / views as f32).sqrt();
        let eye = radius * Vec3::new((2.399963 * i as f32).cos(), (2.399963 * i as f32).sin(), 0.0);
        let turned = glam::camera::rh::view::look_at_mat4(eye, Vec3::NEG_Z * focus_m, Vec3::Y).inverse();
        request.camera.world_from_view = turned;
        let found = radiance(&mut renderer, &scene, &request);
        truth.iter_mut().zip(&found).for_each(|(sum, pixel)| {
            (0..4).for_each(|c| sum[c] += pixel[c] / views as f32);
        });
    }
    request.camera = sharp;
    let plain = radiance(&mut renderer, &scene, &request);
    let focal_m = 0.012 / 20f32.to_radians().tan();
    let f_stop = format!("f_stop={}", focal_m / aperture_m);
    request.effects = vec![with(&renderer, "dof", &[&f_stop, "focus_m=5"])];
    let found = radiance(&mut renderer, &scene, &request);
    let psnr_db = |picture: &[[f32; 4]]| {
        let squares = picture.iter().zip(&truth).flat_map(|(a, b)| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)));
        -10.0 * (squares.sum::<f64>() / (3 * truth.len()) as f64).log10()
    };
    let [plain_db, found_db] = [psnr_db(&plain), psnr_db(&found)];
    println!("{plain_db:.2} dB without, {found_db:.2} dB with depth of field");
    assert!(found_db > plain_db + 6.0, "{plain_db} {found_db}");
}

#[test]
fn effects_take_pictures_of_any_size_and_refuse_what_is_no_setting() {
    let mut renderer = renderer();
    let mut scene = Scene::default();
    put(&mut scene, cube(Vec3::ONE), Vec3::splat(0.5), Vec3::ZERO);
    for size in [(1, 1), (1, 4096), (33, 2)] {
        let mut request = request(&mut scene, size, Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, perspective(45.0));
        renderer.load(&scene).unwrap();
        for name in manypass::EffectFile::built_in_names() {
            let settings: &[&str] = if name == "dof" { &["f_stop=0.01", "focus_m=0.7"] } else { &[] };
            request.effects = vec![with(&renderer, name, settings)];
            let found = radiance(&mut renderer, &scene, &request);
            assert!(found.as_flattened().iter().all(|c| c.is_finite()), "{name} of {size:?}");
            assert_eq!(renderer.read_display().unwrap().len(), 4 * (size.0 * size.1) as usize, "{name}");
        }
    }
    for name in manypass::EffectFile::built_in_names() {
        let effect = with(&renderer, name, &[]);
        for info in effect.settings() {
            for value in ["nan", "-inf", "inf", "-1e30", ""] {
                let result = effect.set(&info.key, value);
                let is_open = value == "-1e30" && info.min.is_none();
                assert!(result.is_err() || is_open, "{}={value}", info.key);
            }
        }
    }
}
