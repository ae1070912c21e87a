//! The light that shadows leave, against closed forms: penumbrae, panes of glass, and edges under a camera that moves.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::reflected::{load, pixel_of};
use crate::common::shadows::{SIZE, SPOT, light, perspective, radiance, request, shared, shares, unshadowed, world_of};
use glam::{DVec3, Vec3, Vec4};
use manypass::{FrameRequest, ShadowFilter, View};
use manypass_scene::{AlphaMode, Light, LightKind, Material, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::raycast::Options;
use manypass_testkit::shadow_edges::visibility_beside_edge;

/// The height of the eye that looks down on a floor, below all that casts shadows on it.
const EYE_M: f32 = 0.45;

/// A floor seen from above.
fn floor(size_m: f32) -> SceneBuilder {
    let mut builder = SceneBuilder::new(Vec3::Y * EYE_M, Vec3::ZERO, perspective());
    builder.put(primitives::plane(size_m), grey(0.5), at(Vec3::ZERO));
    builder
}

/// Where the middle of a pixel lies on the floor.
fn on_floor(column: u32, row: u32) -> DVec3 {
    let half_m = f64::from(EYE_M) * 0.4f64.tan();
    let of_height = |pixel: u32, side: u32| (2.0 * f64::from(pixel) + 1.0 - f64::from(side)) / f64::from(SIZE.1);
    DVec3::new(half_m * of_height(column, SIZE.0), 0.0, half_m * of_height(row, SIZE.1))
}

/// A light above a wall that begins at x = 0 and keeps it from the left of the floor.
#[derive(Debug)]
struct Penumbra {
    kind: LightKind,
    radius_m: f32,
    wall_m: f32,
    /// The height of the light above the wall; 1 of parallel light.
    light_m: f32,
}

impl Penumbra {
    fn scene(&self) -> Scene {
        let mut builder = floor(8.0);
        builder.put(primitives::plane(4.0), grey(0.5), at(Vec3::new(-2.0, self.wall_m, 0.0)));
        let lamp = Light { radius_m: self.radius_m, ..light(self.kind, 10.0) };
        builder.light(lamp, Vec3::Y * (self.wall_m + self.light_m), Vec3::NEG_Y);
        builder.finish()
    }

    /// What is lit of every column, as closed form.
    fn expected(&self) -> Vec<f64> {
        let [radius, wall, light] = [self.radius_m, self.wall_m, self.light_m].map(f64::from);
        (0..SIZE.0).map(|column| visibility_beside_edge(on_floor(column, 0).x, radius, wall, light)).collect()
    }

    /// The mean of every column.
    fn found(&self, request: impl Fn(&Scene) -> FrameRequest, samples: u32) -> Vec<f64> {
        let scene = self.scene();
        let found = shares(&scene, &request(&scene), samples);
        let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
        let share = |column: usize, row: usize| f64::from(found[row * width + column].unwrap());
        (0..width).map(|column| (0..height).map(|row| share(column, row)).sum::<f64>() / height as f64).collect()
    }
}

/// Where a rising row of numbers first reaches `level`, in columns.
fn reaches(row: &[f64], level: f64) -> f64 {
    let after = row.iter().position(|value| *value >= level).unwrap().max(1);
    let [before, at] = [row[after - 1], row[after]];
    after as f64 - (at - level) / (at - before).max(1e-9)
}

fn penumbrae() -> Vec<Penumbra> {
    let of = |kind, radius_m, wall_m, light_m| Penumbra { kind, radius_m, wall_m, light_m };
    vec![
        of(LightKind::Point, 0.2, 0.5, 1.0),
        of(LightKind::Point, 0.06, 1.0, 0.5),
        of(LightKind::Point, 0.03, 1.0, 0.25),
        of(SPOT, 0.2, 0.5, 1.0),
        of(SPOT, 0.06, 1.0, 0.5),
        of(LightKind::Directional, 0.2, 0.5, 1.0),
        of(LightKind::Directional, 0.1, 1.0, 1.0),
    ]
}

#[test]
fn penumbrae_of_blocker_searches_are_as_wide_as_those_of_area_lights() {
    let with =
        |filter: ShadowFilter| move |scene: &Scene| request(scene).with(|settings| settings.shadows.filter = filter);
    for penumbra in penumbrae() {
        let expected = penumbra.expected();
        let width = |row: &[f64]| reaches(row, 0.85) - reaches(row, 0.15);
        let soft = penumbra.found(with(ShadowFilter::Pcss), 1);
        let ratio = width(&soft) / width(&expected);
        let moved = (reaches(&soft, 0.5) - reaches(&expected, 0.5)) / width(&expected);
        // The test can fail: another filter's penumbra does not depend on the light.
        let other = width(&penumbra.found(with(ShadowFilter::Hard), 1)) / width(&expected);
        println!("{penumbra:?}: width {ratio:.3}, middle moved by {moved:.3}; not filtered {other:.3}");
        assert!((0.75..=1.25).contains(&ratio), "{penumbra:?}: {ratio} times as wide");
        assert!(moved.abs() < 0.25, "{penumbra:?}: moved by {moved} of its width");
        assert!(other < 0.75, "{penumbra:?}: {other} without a filter");
    }
}

#[test]
fn penumbrae_of_many_samples_are_those_of_area_lights() {
    for (penumbra, filter) in [(0, ShadowFilter::Pcf), (3, ShadowFilter::Pcss), (5, ShadowFilter::Pcss)] {
        let penumbra = &penumbrae()[penumbra];
        let found = penumbra.found(|scene| request(scene).with(|settings| settings.shadows.filter = filter), 64);
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        let worst = found.iter().zip(&penumbra.expected()).map(off).fold(0.0, f64::max);
        let one = penumbra.found(request, 1);
        let of_one = one.iter().zip(&penumbra.expected()).map(off).fold(0.0, f64::max);
        println!("{penumbra:?}, {filter:?}: {worst:.3} off, of one sample {of_one:.3}");
        assert!(worst < 0.05, "{penumbra:?}: {worst} off");
        assert!(of_one > 0.2, "{penumbra:?}: the test cannot fail");
    }
}

#[test]
fn panes_of_glass_stop_their_part_and_those_behind_each_other_the_product() {
    let glass = |alpha: f32| Material {
        alpha_mode: AlphaMode::Blend,
        base_color_factor: Vec4::new(1.0, 1.0, 1.0, alpha),
        ..Material::default()
    };
    for kind in [LightKind::Point, LightKind::Directional] {
        // Small, so that a pane has many texels.
        let mut builder = floor(1.2);
        for (x, y, alpha) in [(-0.15, 0.7, 0.3), (0.15, 0.7, 0.3), (0.15, 0.9, 0.5)] {
            builder.put(primitives::plane(0.18), glass(alpha), at(Vec3::new(x, y, 0.0)));
        }
        builder.light(light(kind, 10.0), Vec3::Y * 2.0, Vec3::NEG_Y);
        let scene = builder.finish();
        let (world, found) = (world_of(&scene), shares(&scene, &request(&scene), 32));
        // Of the ray caster's shares, the number of pixels and the sum of what they have here.
        let mut sums = [(0.7, 0, 0.0), (0.35, 0, 0.0), (1.0, 0, 0.0)];
        for (pixel, share) in (0..).zip(&found) {
            let place = on_floor(pixel % SIZE.0, pixel / SIZE.0);
            let truth = |offset: DVec3| world.visibility_at(0, place + offset, Options::default());
            let is_near = |x: f64, y: f64| (x - y).abs() < 1e-6;
            for (expected, count, sum) in &mut sums {
                let around = [DVec3::ZERO, DVec3::X, -DVec3::X, DVec3::Z, -DVec3::Z];
                if around.iter().all(|offset| is_near(truth(*offset * 0.04), *expected)) {
                    *count += 1;
                    *sum += f64::from(share.unwrap());
                }
            }
        }
        for (expected, count, sum) in sums {
            let mean = sum / f64::from(count);
            println!("{kind:?}: {mean:.4} of {count} pixels, {expected} expected");
            assert!(count > 200 && (mean - expected).abs() < 0.02, "{kind:?}: {mean} against {expected}");
        }
    }
}

#[test]
fn a_moving_camera_makes_no_shadow_shimmer() {
    const MOVES: usize = 60;
    // An eye that looks straight down sees the same points of a floor again, whole pixels away. All casters hang above
    // it.
    let height_m = 4.0f32;
    let mut builder = SceneBuilder::new(Vec3::Y * height_m, Vec3::ZERO, perspective());
    builder.put(primitives::plane(60.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..40_u8 {
        let (sin, cos) = (2.4 * f32::from(i)).sin_cos();
        let away_m = 0.22 * f32::from(i);
        builder.put(primitives::cube(Vec3::splat(0.7)), grey(0.5), at(Vec3::new(away_m * cos, 5.0, away_m * sin)));
    }
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, Vec3::new(0.3, -1.0, 0.2));
    let scene = builder.finish();
    let request = request(&scene);
    let pixel_m = 2.0 * height_m * 0.4f32.tan() / SIZE.1 as f32;
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let mut first: Option<Vec<f32>> = None;
    let (mut drawn, mut worst, mut in_shadow) = (0, 0.0f32, 0);
    for step in 0..=MOVES {
        let offset_m = Vec3::new(pixel_m, 0.0, pixel_m) * step as f32;
        let world_from_view = glam::Mat4::from_translation(offset_m) * request.camera.world_from_view;
        let request = FrameRequest { camera: View { world_from_view, ..request.camera }, ..request.clone() };
        let lit = radiance(&mut renderer, &scene, &unshadowed(&request), 1);
        let shadowed = radiance(&mut renderer, &scene, &request, 1);
        drawn += renderer.stats().shadow_tiles_drawn;
        let shares: Vec<f32> = lit.iter().zip(&shadowed).map(|(lit, shadowed)| shadowed[1] / lit[1]).collect();
        let Some(first) = &first else {
            in_shadow = shares.iter().filter(|share| **share < 0.5).count();
            first = Some(shares);
            continue;
        };
        for (row, column) in (step..height).flat_map(|row| (step..width).map(move |column| (row, column))) {
            // The eye goes right and down.
            let here = shares[(row - step) * width + column - step];
            worst = worst.max((here - first[row * width + column]).abs());
        }
    }
    println!("{in_shadow} pixels in shadow, {drawn} maps drawn, {worst} at most");
    assert!(in_shadow > 2000 && drawn > MOVES as u32 / 2, "nothing to look at: {in_shadow}, {drawn}");
    assert!(worst <= 1.0 / 255.0, "the same point changed by {worst}");
}

/// From sixteen samples on each compares once, and the places of the filter take turns.
#[test]
fn places_of_a_filter_that_take_turns_are_the_filter() {
    let with =
        |filter: ShadowFilter| move |scene: &Scene| request(scene).with(|settings| settings.shadows.filter = filter);
    for kind in [LightKind::Point, SPOT, LightKind::Directional] {
        let penumbra = Penumbra { kind, radius_m: 0.0, wall_m: 0.5, light_m: 1.0 };
        let of = |filter, samples| penumbra.found(with(filter), samples);
        let filtered = of(ShadowFilter::Pcf, 15);
        let difference = |other: &[f64]| {
            let all = filtered.iter().zip(other).map(|(a, b)| (a - b).abs());
            (all.clone().sum::<f64>() / filtered.len() as f64, all.fold(0.0, f64::max))
        };
        let (mean, most) = difference(&of(ShadowFilter::Pcf, 16));
        let (_, hard) = difference(&of(ShadowFilter::Hard, 16));
        println!("{kind:?}: mean {mean:.5}, most {most:.4}; without a filter {hard:.4}");
        // Sixteen samples are four at each place, which fifteen whole ones are not just like.
        assert!(mean < 0.003 && most < 0.05, "{kind:?}: {mean}, {most}");
        assert!(hard > 2.0 * most, "{kind:?}: the test cannot tell a filter from none: {hard}");
    }
}

#[test]
fn an_edge_is_as_many_texels_wide_as_the_kernel_has_comparisons() {
    let edge = Penumbra { kind: LightKind::Directional, radius_m: 0.0, wall_m: 0.5, light_m: 1.0 };
    let width = |kernel: u32| {
        let with = |scene: &Scene| {
            request(scene).with(|settings| (settings.shadows.kernel, settings.shadows.cascades) = (kernel, 1))
        };
        let row = edge.found(with, 1);
        (reaches(&row, 0.9) - reaches(&row, 0.1)) / 0.8
    };
    let of_one = width(1);
    for kernel in 2..=5 {
        let ratio = width(kernel) / of_one;
        println!("{kernel}: {ratio:.3} times as wide as one comparison");
        assert!((ratio / f64::from(kernel) - 1.0).abs() < 0.1, "{kernel} comparisons are {ratio} times as wide as one");
    }
}

/// Where the sun stands low, leaks through walls are looked for, with two comparisons across alone: edges of what is far
/// before a floor stay where three have them, and as wide as two make them.
#[test]
fn edges_under_a_low_sun_stay_where_leaks_are_looked_for() {
    let mut builder = floor(8.0);
    builder.put(primitives::plane(4.0), grey(0.5), at(Vec3::new(-1.5, 0.5, 0.0)));
    builder.light(light(LightKind::Directional, 10.0), Vec3::ZERO, Vec3::new(-1.0, -1.0, 0.0));
    let scene = builder.finish();
    let edge = |kernel: u32| {
        let request = request(&scene).with(|settings| {
            settings.shadows.kernel = kernel;
            settings.shadows.map_px = 128;
            settings.shadows.extent_m = 4.0;
        });
        let found = shares(&scene, &request, 1);
        let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
        let column = |x: usize| (0..height).map(|y| f64::from(found[y * width + x].unwrap())).sum::<f64>();
        let row = Vec::from_iter((0..width).map(|x| column(x) / height as f64));
        (reaches(&row, 0.5), reaches(&row, 0.9) - reaches(&row, 0.1))
    };
    let ((middle, width), (expected, wide)) = (edge(2), edge(3));
    let ratio = wide / width;
    println!("middle at {middle:.2} px, of the wider filter at {expected:.2}; {width:.2} px wide, {ratio:.3} times");
    assert!((middle - expected).abs() < 0.25, "at {middle} px instead of {expected}");
    assert!((ratio / 1.5 - 1.0).abs() < 0.05, "{wide} px of three comparisons are {ratio} times {width} px of two");
}

/// With one comparison an edge is as wide as a texel, which is the width of what a map shows by its texels, less three
/// at each side for filters.
#[test]
fn a_texel_is_as_wide_as_the_size_and_the_extent_of_a_map_make_it() {
    const EXTENT_M: f64 = 4.0;
    let pixel_m = on_floor(1, 0).x - on_floor(0, 0).x;
    for (kind, across_m) in [(LightKind::Directional, EXTENT_M), (SPOT, 2.0 * 0.7f64.tan() * 1.5)] {
        let edge = Penumbra { kind, radius_m: 0.0, wall_m: 0.5, light_m: 1.0 };
        for map_px in [64, 128] {
            let with = |scene: &Scene| {
                request(scene).with(|settings| {
                    settings.shadows.kernel = 1;
                    settings.shadows.map_px = map_px;
                    settings.shadows.extent_m = EXTENT_M as f32;
                })
            };
            let row = edge.found(with, 1);
            let width_m = (reaches(&row, 0.9) - reaches(&row, 0.1)) / 0.8 * pixel_m;
            let expected_m = across_m / f64::from(map_px - 6);
            println!("{kind:?}, {map_px} texels: {width_m:.4} m, expected {expected_m:.4} m");
            assert!(
                (width_m / expected_m - 1.0).abs() < 0.1,
                "{kind:?}, {map_px}: {width_m} m instead of {expected_m} m"
            );
        }
    }
}

/// A pane is in the map by chance, texel by texel. Under a sun of some width its shadow on a floor is even nevertheless.
#[test]
fn shadows_of_panes_have_little_grain() {
    let eye = Vec3::new(3.0, 1.2, 0.0);
    let mut builder = SceneBuilder::new(eye, Vec3::new(-0.5, 0.0, 0.0), perspective());
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    let pane = Material { alpha_mode: AlphaMode::Blend, base_color_factor: Vec4::new(0.5, 0.5, 0.5, 0.5), ..grey(0.5) };
    builder.put(primitives::plane(2.4), pane, at(Vec3::new(-1.5, 1.5, 0.0)));
    let to_light = Vec3::new(-1.0, 2.0, 0.0);
    let sun = Light { radius_m: 0.02, ..light(LightKind::Directional, 3.0) };
    builder.light(sun, Vec3::ZERO, -to_light);
    let scene = builder.finish();
    let mut renderer = shared();
    load(&mut renderer, &scene);
    let found = radiance(&mut renderer, &scene, &request(&scene), 16);
    let view = request(&scene).camera;
    // The middle of the shadow, as pixels, and what light there is of the floor without it.
    let pixel = |position: Vec3| {
        let (x, y) = pixel_of(&view, SIZE, position);
        found[y as usize * SIZE.0 as usize + x as usize][1]
    };
    let steps = (0..20).flat_map(|x| (0..20).map(move |z| (x as f32 / 19.0 - 0.5, z as f32 / 19.0 - 0.5)));
    let within: Vec<f32> = steps.map(|(x, z)| pixel(Vec3::new(-0.75 + 1.2 * x, 0.0, 1.2 * z))).collect();
    let lit = pixel(Vec3::new(1.2, 0.0, 0.0));
    let mean = within.iter().sum::<f32>() / within.len() as f32;
    let deviation = (within.iter().map(|of| (of - mean).powi(2)).sum::<f32>() / within.len() as f32).sqrt();
    println!("{:.3} of the light, grain of {:.4}", mean / lit, deviation / lit);
    assert!((mean / lit - 0.5).abs() < 0.03, "{} of the light comes through", mean / lit);
    // 0.043; with one comparison a sample 0.086.
    assert!(deviation / lit < 0.055, "grain of {}", deviation / lit);
}
