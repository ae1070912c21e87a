//! Surfaces that alpha covers: whatever the order in which they come, and in every way in which they become one
//! picture.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec3, Vec4};
use manypass::gpu::Floor;
use manypass::{
    Background, FogMode, FrameRequest, Gpu, Masks, Path, PixelSamples, Renderer, Tonemap, TransparencyMode,
};
use manypass_scene::material::{Clearcoat, Specular, TexturedFactor, Volume};
use manypass_scene::{
    AlphaMode, Light, LightKind, Material, Node, Primitive, Projection, Scene, ShadingModel, Topology, primitives,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::f32::consts::FRAC_PI_2;

const SIZE: (u32, u32) = (32, 32);

const PATHS: [Path; 4] = [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud];

/// A step of a display.
const STEP: f32 = 1.0 / 255.0;

/// A picture of 2 m, seen from 5 m above with parallel rays.
fn seen_from_above() -> SceneBuilder {
    SceneBuilder::new(Vec3::Y * 5.0, Vec3::ZERO, Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 20.0 })
}

fn pane(color: [f32; 4]) -> Material {
    Material {
        shading_model: ShadingModel::Unlit,
        alpha_mode: AlphaMode::Blend,
        base_color_factor: Vec4::from(color),
        double_sided: true,
        ..Material::default()
    }
}

const RED: [f32; 4] = [0.9, 0.1, 0.1, 0.5];
const GREEN: [f32; 4] = [0.1, 0.8, 0.2, 0.6];
const BLUE: [f32; 4] = [0.2, 0.3, 0.9, 0.3];

/// Panes that go through each other, put in this order.
fn crossing(order: &[usize]) -> Scene {
    let mut builder = seen_from_above();
    let panes = [(RED, 0.6), (GREEN, -0.6), (BLUE, 0.0)];
    for index in order {
        let (color, turn_rad) = panes[*index];
        let node = Node { rotation: Quat::from_rotation_z(turn_rad), ..Node::default() };
        builder.put(primitives::plane(3.0), pane(color), node);
    }
    builder.finish()
}

/// The same panes one above the other.
fn stacked(colors: &[[f32; 4]]) -> Scene {
    let mut builder = seen_from_above();
    for (index, color) in colors.iter().enumerate() {
        builder.put(primitives::plane(3.0), pane(*color), at(Vec3::Y * index as f32 * 0.5));
    }
    builder.finish()
}

/// Panes from the farthest to the nearest over black.
fn over(colors: &[[f32; 4]]) -> [f32; 3] {
    let blend = |below: [f32; 3], [r, g, b, a]: &[f32; 4]| {
        let above = [r, g, b];
        std::array::from_fn(|channel| above[channel] * a + below[channel] * (1.0 - a))
    };
    colors.iter().fold([0.0; 3], blend)
}

fn request(scene: &Scene, mode: TransparencyMode) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| settings.transparency.mode = mode)
}

fn radiance_of(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    renderer.load(scene).unwrap();
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_radiance().unwrap()
}

fn greatest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn the_weighted_mean_is_the_same_in_any_order() {
    let mut renderer = renderer();
    let mut picture = |order: &[usize], mode| {
        let scene = crossing(order);
        radiance_of(&mut renderer, &scene, &request(&scene, mode))
    };
    let orders: [&[usize]; 3] = [&[0, 1, 2], &[2, 1, 0], &[1, 2, 0]];
    let [first, others @ ..] = orders.map(|order| picture(order, TransparencyMode::Weighted));
    for other in others {
        // Sums of half floats are rounded otherwise: by 2^-11 of them each time.
        let difference = greatest_difference(&first, &other);
        assert!(difference < 0.002, "{difference}");
    }
    let sorted = orders.map(|order| picture(order, TransparencyMode::Sorted));
    assert!(greatest_difference(&sorted[0], &sorted[1]) > 0.1, "panes whose middles are one have no order");
}

/// Half covered, and in a part of the picture bright: a plane with normals, points, a coat, under a light, in fog.
fn layers_of_all_kinds() -> Scene {
    let mut builder = seen_from_above();
    builder.put(primitives::plane(0.8), grey(0.5), at(Vec3::new(0.5, -0.5, 0.5)));
    let coat = Clearcoat {
        weight: TexturedFactor::new(1.0),
        roughness: TexturedFactor::new(0.2),
        normal_texture: None,
        normal_scale: 1.0,
    };
    let lit = Material { alpha_mode: AlphaMode::Blend, base_color_factor: Vec4::new(0.8, 0.6, 0.4, 0.25), ..grey(0.5) };
    builder.put(primitives::plane(0.8), lit.clone(), at(Vec3::new(-0.5, 0.0, -0.5)));
    let coated = Material { clearcoat: Some(coat), ..lit.clone() };
    builder.put(primitives::plane(0.8), coated, at(Vec3::new(0.5, 0.2, 0.5)));
    let glowing = Material { emissive_factor: Vec3::new(40.0, 2.0, 0.1), ..lit.clone() };
    builder.put(primitives::plane(0.8), glowing, at(Vec3::new(0.5, 0.4, -0.5)));
    let places = (0..16).map(|i| [(i % 4) as f32 * 0.2 - 0.8, 0.0, (i / 4) as f32 * 0.2 + 0.2]).collect();
    let points = Primitive { topology: Topology::Points, positions: places, ..Primitive::default() };
    builder.put(points, lit, at(Vec3::ZERO));
    let sun = Light { color_linear: Vec3::ONE, intensity: 3.0, kind: LightKind::Directional, ..Light::default() };
    builder.light(sun, Vec3::ZERO, Vec3::new(0.3, -1.0, 0.2));
    builder.finish()
}

#[test]
fn one_layer_is_the_same_sorted_and_weighted() {
    let scene = layers_of_all_kinds();
    let mut renderer = renderer();
    for path in PATHS {
        let [sorted, weighted] = [TransparencyMode::Sorted, TransparencyMode::Weighted].map(|mode| {
            let request = request(&scene, mode).with(|settings| {
                settings.render.path = path;
                (settings.fog.mode, settings.fog.density_per_m) = (FogMode::Exponential, 0.1);
            });
            radiance_of(&mut renderer, &scene, &request)
        });
        let mut covered = 0;
        for (a, b) in sorted.chunks_exact(4).zip(weighted.chunks_exact(4)) {
            covered += u32::from(a[3] > 0.0);
            for channel in 0..4 {
                // Beyond white a step is one of what is shown of it.
                let allowed = STEP * a[channel].max(1.0);
                assert!((a[channel] - b[channel]).abs() < allowed, "{path:?}: {a:?}, weighted {b:?}");
            }
        }
        assert!(covered > 500, "{path:?}: {covered} pixels show something");
    }
}

#[test]
fn one_layer_is_the_same_sorted_and_stochastic_on_every_path() {
    let scene = layers_of_all_kinds();
    let mut renderer = renderer();
    for path in PATHS {
        let [sorted, stochastic] = [TransparencyMode::Sorted, TransparencyMode::Stochastic].map(|mode| {
            let request = request(&scene, mode).with(|settings| settings.render.path = path);
            radiance_of(&mut renderer, &scene, &FrameRequest { sample_count: 16, ..request })
        });
        let (mut covered, mut same) = (0, 0);
        for (a, b) in sorted.chunks_exact(4).zip(stochastic.chunks_exact(4)) {
            covered += u32::from(a[3] > 0.0);
            let is_same = (0..4).all(|channel| (a[channel] - b[channel]).abs() < STEP * a[channel].max(1.0));
            same += u32::from(a[3] > 0.0 && is_same);
        }
        println!("{path:?}: {same} of {covered}");
        // Four of sixteen samples show a quarter of a layer, but for edges, which are in some samples alone.
        assert!(covered > 500 && same * 5 > covered * 3, "{path:?}: {same} of {covered}");
    }
}

#[test]
fn what_is_opaque_is_the_same_in_every_way() {
    let mut builder = seen_from_above();
    builder.put(primitives::uv_sphere(0.7, 24, 12), grey(0.6), at(Vec3::ZERO));
    builder.light(Light { intensity: 3.0, ..Light::default() }, Vec3::new(0.5, 3.0, 0.5), Vec3::NEG_Y);
    let scene = builder.finish();
    let mut renderer = renderer();
    let pictures = [TransparencyMode::Sorted, TransparencyMode::Weighted, TransparencyMode::Stochastic].map(|mode| {
        let request = request(&scene, mode);
        let picture = radiance_of(&mut renderer, &scene, &request);
        // Without blended surfaces there is no pass for them.
        (picture, renderer.plan(&scene, &request).unwrap().passes.len())
    });
    assert!(pictures[0] == pictures[1] && pictures[0] == pictures[2]);
}

#[test]
fn every_way_fits_the_floor() {
    let scene = stacked(&[RED, GREEN]);
    let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).unwrap()).unwrap();
    renderer.load(&scene).unwrap();
    for path in PATHS {
        for (mode, resolves) in
            [(TransparencyMode::Sorted, 0), (TransparencyMode::Weighted, 1), (TransparencyMode::Stochastic, 0)]
        {
            let request = request(&scene, mode).with(|settings| {
                (settings.render.path, settings.transparency.masks) = (path, Masks::Hashed);
            });
            let plan = renderer.plan(&scene, &request).unwrap();
            let found = plan.passes.iter().filter(|pass| pass.name == "transparency").count();
            assert_eq!(found, resolves, "{path:?} {mode:?}");
        }
    }
}

#[test]
fn chance_adds_passes_only_where_there_is_glass_and_something_blended() {
    let mut glass = seen_from_above();
    glass.put(primitives::plane(1.0), clear_glass(), at(Vec3::ZERO));
    let scenes = [(stacked(&[RED]), false), (glass.finish(), false), (pane_before_ball(0.0), true)];
    let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).unwrap()).unwrap();
    for (scene, has_both) in &scenes {
        renderer.load(scene).unwrap();
        for (path, layers) in PATHS.iter().flat_map(|path| [(*path, 1), (*path, 2)]) {
            let [sorted, stochastic] = [TransparencyMode::Sorted, TransparencyMode::Stochastic].map(|mode| {
                let request = request(scene, mode).with(|settings| {
                    (settings.render.path, settings.transparency.refractive_layers) = (path, layers);
                });
                let plan = renderer.plan(scene, &request).unwrap();
                plan.passes.into_iter().map(|pass| pass.name).collect::<Vec<_>>()
            });
            let mut added = stochastic.clone();
            added.retain(|name| !sorted.contains(name));
            let blended = if path == Path::Gouraud { "gouraud.behind" } else { "forward.behind" };
            let expected: &[&str] =
                if *has_both { &["transmissive.depth", "transmissive.linear_depth", blended] } else { &[] };
            assert_eq!(added, expected, "{path:?} {layers}");
            let kept: Vec<_> = stochastic.iter().filter(|name| !added.contains(name)).collect();
            assert!(kept.into_iter().eq(&sorted), "{stochastic:?} and {sorted:?}");
        }
    }
}

/// The pixel in the middle of the left half, and that of the right.
fn halves(picture: &[f32]) -> [[f32; 4]; 2] {
    [SIZE.0 / 4, SIZE.0 * 3 / 4].map(|x| {
        let at = ((SIZE.1 / 2 * SIZE.0 + x) * 4) as usize;
        picture[at..at + 4].try_into().unwrap()
    })
}

#[test]
fn nearer_surfaces_weigh_more_and_as_much_comes_through_as_of_sorted_ones() {
    let mut renderer = renderer();
    let mut find = |colors: &[[f32; 4]]| {
        let scene = stacked(colors);
        let request = request(&scene, TransparencyMode::Weighted).with(|settings| {
            settings.background.source = Background::Transparent;
        });
        halves(&radiance_of(&mut renderer, &scene, &request))[0]
    };
    let (red, green) = ([1.0, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 0.5]);
    let (red_above, green_above) = (find(&[green, red]), find(&[red, green]));
    for found in [red_above, green_above] {
        assert!((found[3] - 0.75).abs() < 0.002 && (found[0] + found[1] - 0.75).abs() < 0.004, "{found:?}");
    }
    // Sorted, it would be 0.5 and 0.25.
    assert!(red_above[0] > 1.1 * red_above[1] && red_above[1] > 0.1, "{red_above:?}");
    assert!((red_above[0] - green_above[1]).abs() < 0.002, "{red_above:?} {green_above:?}");
}

#[test]
fn many_bright_surfaces_leave_numbers() {
    let mut builder = seen_from_above();
    for index in 0..100_u8 {
        let material = Material { emissive_factor: Vec3::splat(1e6), ..pane([1.0, 1.0, 1.0, 0.9]) };
        let lit = Material { shading_model: ShadingModel::Standard, ..material };
        builder.put(primitives::plane(3.0), lit, at(Vec3::Y * f32::from(index) * 0.01));
    }
    let scene = builder.finish();
    let found = radiance_of(&mut renderer(), &scene, &request(&scene, TransparencyMode::Weighted));
    assert!(found.iter().all(|value| value.is_finite()));
    assert!(found[0] > 10_000.0, "{:?}", &found[..4]);
}

/// Root of the mean square, and the greatest, of the differences to a colour that all pixels should have.
fn errors(found: &[f32], expected: [f32; 3]) -> (f32, f32) {
    let differences = || found.chunks_exact(4).flat_map(|pixel| (0..3).map(|c| (pixel[c] - expected[c]).abs()));
    let square = differences().map(|difference| difference * difference).sum::<f32>() / (differences().count() as f32);
    (square.sqrt(), differences().fold(0.0, f32::max))
}

#[test]
fn stochastic_surfaces_converge_to_sorted_ones() {
    let mut renderer = renderer();
    for colors in [&[RED][..], &[GREEN, RED], &[RED, BLUE, GREEN]] {
        let scene = stacked(colors);
        let expected = over(colors);
        let sorted = radiance_of(&mut renderer, &scene, &request(&scene, TransparencyMode::Sorted));
        let (_, greatest) = errors(&sorted, expected);
        assert!(greatest < 0.001, "sorted, {greatest}");
        // One layer is exact from the start. Of several the greatest error in the picture is some four times the mean
        // one.
        let steps: &[(u32, f32)] =
            if colors.len() == 1 { &[(16, 0.1)] } else { &[(16, 20.0), (256, 4.0), (4096, 1.0)] };
        for (samples, allowed) in steps {
            let mut request = request(&scene, TransparencyMode::Stochastic);
            (request.width, request.height, request.sample_count) = (16, 16, *samples);
            let (rms, greatest) = errors(&radiance_of(&mut renderer, &scene, &request), expected);
            println!("{} layers, {samples} samples: {:.3} {:.3}", colors.len(), rms / STEP, greatest / STEP);
            assert!(rms < allowed * STEP, "{} layers, {samples} samples: {}", colors.len(), rms / STEP);
        }
    }
}

#[test]
fn stochastic_surfaces_that_cross_converge_to_each_in_its_place() {
    // Turned about the view's vertical axis, the red one is nearer on one side and the green one on the other.
    let mut renderer = renderer();
    let scene = crossing(&[0, 1]);
    let mut request = request(&scene, TransparencyMode::Stochastic);
    request.sample_count = 256;
    let found = halves(&radiance_of(&mut renderer, &scene, &request));
    let expected = [over(&[GREEN, RED]), over(&[RED, GREEN])];
    let is_near = |found: [f32; 4], expected: [f32; 3]| (0..3).all(|c| (found[c] - expected[c]).abs() < 0.03);
    let is_found = |first: usize| is_near(found[0], expected[first]) && is_near(found[1], expected[1 - first]);
    assert!(is_found(0) || is_found(1), "{found:?}, expected {expected:?}");
}

#[test]
fn layers_of_one_object_decide_for_themselves() {
    // Three layers of one primitive, which distances alone tell apart. If all decided alike, half would come through.
    let mut builder = seen_from_above();
    let (mut many, one) = (Primitive::default(), primitives::plane(3.0));
    for y in [0.0, 0.1, 0.2_f32] {
        let first = many.positions.len() as u32;
        many.positions.extend(one.positions.iter().map(|[x, _, z]| [*x, y, *z]));
        many.normals.extend(&one.normals);
        many.indices.extend(one.indices.iter().map(|index| index + first));
    }
    many.bounds = manypass_scene::Aabb::from_points(many.positions.iter().copied().map(Vec3::from));
    builder.put(many, pane([1.0, 1.0, 1.0, 0.5]), Node::default());
    let scene = builder.finish();
    let mut request = request(&scene, TransparencyMode::Stochastic);
    request.sample_count = 256;
    let (rms, _) = errors(&radiance_of(&mut renderer(), &scene, &request), [0.875; 3]);
    assert!(rms < 8.0 * STEP, "{}", rms / STEP);
}

#[test]
fn the_mean_of_stochastic_samples_goes_through_the_tone_curve_as_a_whole() {
    let mut builder = seen_from_above();
    let lamp = Material { emissive_factor: Vec3::splat(8.0), ..grey(0.0) };
    builder.put(primitives::plane(3.0), lamp, at(Vec3::NEG_Y));
    builder.put(primitives::plane(3.0), pane([0.05, 0.1, 0.1, 0.75]), at(Vec3::ZERO));
    let scene = builder.finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let [sorted, stochastic] = [TransparencyMode::Sorted, TransparencyMode::Stochastic].map(|mode| {
        let request = request(&scene, mode).with(|settings| settings.tone_map.curve = Tonemap::Neutral);
        for sample_index in 0..16 {
            let request = FrameRequest { sample_index, sample_count: 16, ..request.clone() };
            renderer.render(&scene, &request).unwrap();
        }
        renderer.read_display().unwrap()
    });
    // 16 samples show three quarters of one layer exactly.
    let greatest = sorted.iter().zip(&stochastic).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(greatest <= Some(1), "{:?} {:?}", &sorted[..4], &stochastic[..4]);
}

/// Glass that is not there but for its depth.
fn clear_glass() -> Material {
    Material {
        roughness_factor: 0.0,
        metallic_factor: 0.0,
        transmission: Some(TexturedFactor::new(1.0)),
        specular: Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() }),
        ..Material::default()
    }
}

#[test]
fn what_is_blended_is_seen_through_glass_by_chance_alone() {
    // Glass over the left half; a pane below all of it, or above.
    let card = Material { alpha_mode: AlphaMode::Opaque, ..pane([1.0; 4]) };
    let ways = [TransparencyMode::Sorted, TransparencyMode::Weighted, TransparencyMode::Stochastic];
    let mut renderer = renderer();
    for pane_height_m in [0.5, 1.5] {
        let mut builder = seen_from_above();
        builder.put(primitives::plane(3.0), card.clone(), at(Vec3::ZERO));
        builder.put(primitives::plane(3.0), pane(RED), at(Vec3::Y * pane_height_m));
        builder.put(primitives::plane(3.0), clear_glass(), at(Vec3::new(-1.5, 1.0, 0.0)));
        let scene = builder.finish();
        for (mode, path) in ways.iter().flat_map(|mode| PATHS.map(|path| (*mode, path))) {
            let mut request = request(&scene, mode).with(|settings| settings.render.path = path);
            // So many show half of one layer exactly.
            request.sample_count = 16;
            let [behind_glass, beside] = halves(&radiance_of(&mut renderer, &scene, &request));
            let through_pane = [0.95, 0.55, 0.55];
            let is_seen = mode == TransparencyMode::Stochastic || pane_height_m > 1.0;
            let of_glass = if is_seen { through_pane } else { [1.0; 3] };
            for (name, found, expected) in [("glass", behind_glass, of_glass), ("beside", beside, through_pane)] {
                let off = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
                let label = format!("{mode:?} {path:?}, {name}, pane at {pane_height_m} m");
                assert!(off < STEP, "{label}: {found:?}, not {expected:?}");
            }
        }
    }
}

/// Stripes behind a ball of glass, of which a pane, upright and half red, covers the left half.
fn pane_before_ball(roughness: f32) -> Scene {
    let projection = Projection::Perspective { fov_y_rad: 0.5, near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::Z * 4.0, Vec3::ZERO, projection);
    let upright =
        |translation: Vec3| Node { rotation: Quat::from_rotation_x(FRAC_PI_2), translation, ..Node::default() };
    let stripe = Material { alpha_mode: AlphaMode::Opaque, ..pane([0.2, 0.5, 1.0, 1.0]) };
    for index in -2..=2_i8 {
        builder.put(primitives::plane(0.5), stripe.clone(), upright(Vec3::new(f32::from(index), 0.0, -1.0)));
    }
    let glass = Material {
        base_color_factor: Vec4::ONE,
        roughness_factor: roughness,
        metallic_factor: 0.0,
        transmission: Some(TexturedFactor::new(1.0)),
        volume: Some(Volume { thickness: TexturedFactor::new(0.8), ..Volume::default() }),
        ..Material::default()
    };
    builder.put(primitives::uv_sphere(0.6, 32, 16), glass, at(Vec3::ZERO));
    builder.put(primitives::plane(2.0), pane(RED), upright(Vec3::new(-1.0, 0.0, 1.0)));
    builder.finish()
}

#[test]
fn what_is_blended_before_glass_covers_as_much_by_chance_as_sorted() {
    let mut renderer = renderer();
    for roughness in [0.0, 0.6] {
        let scene = pane_before_ball(roughness);
        let ways = PATHS.map(|path| (path, 1, PixelSamples::One));
        let others = [(Path::Deferred, 2, PixelSamples::One), (Path::Forward, 2, PixelSamples::Four)];
        for (path, layers, samples) in ways.into_iter().chain(others) {
            let [sorted, stochastic] = [TransparencyMode::Sorted, TransparencyMode::Stochastic].map(|mode| {
                let mut request = request(&scene, mode).with(|settings| {
                    (settings.render.path, settings.msaa.samples) = (path, samples);
                    settings.transparency.refractive_layers = layers;
                });
                request.sample_count = 64;
                radiance_of(&mut renderer, &scene, &request)
            });
            let count = sorted.len() as f32;
            let differences = || stochastic.iter().zip(&sorted).map(|(a, b)| a - b);
            let bias = differences().sum::<f32>() / count / STEP;
            let rms = (differences().map(|d| d * d).sum::<f32>() / count).sqrt() / STEP;
            let greatest = greatest_difference(&sorted, &stochastic) / STEP;
            let label = format!("{path:?} {layers} {samples:?}, roughness {roughness}");
            println!("{label}: bias {bias:.3}, rms {rms:.3}, at most {greatest:.3}");
            // If what glass shows had a part of the pane it would be 10, or 4 if it had where no glass is.
            assert!(rms < 1.5 && bias.abs() < 0.1, "{label}: {bias} {rms}");
        }
    }
}
