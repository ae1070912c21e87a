//! Where light ends on smooth bodies of few triangles: along the smooth surface, and not along triangles.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::{light, radiance, shared, shares, unshadowed};
use crate::common::{matte_white, plain_request};
use glam::{DVec3, Vec3};
use manypass::{FrameRequest, Path};
use manypass_scene::{LightKind, Projection, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at};

/// Of the pictures, and how many metres their height shows.
const SIZE: (u32, u32) = (320, 240);
const HEIGHT_M: f64 = 2.2;
/// The cosine whose line is compared. Beyond it a pixel is a hundredth of the radius.
const LEVEL: f64 = 0.06;

/// A camera whose rays are parallel to z.
fn seen_along_z() -> SceneBuilder {
    let lens = Projection::Orthographic { height_m: HEIGHT_M as f32, near_m: 0.1, far_m: 10.0 };
    SceneBuilder::new(Vec3::Z * 4.0, Vec3::ZERO, lens)
}

/// A ball of radius 1 and of 120 triangles with the normals of the ball.
fn ball(to_light: Vec3) -> SceneBuilder {
    let mut builder = seen_along_z();
    builder.put(primitives::uv_sphere(1.0, 12, 6), matte_white(), at(Vec3::ZERO));
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, -to_light);
    builder
}

fn request(scene: &Scene, path: Path) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.shadows.enabled = true;
        settings.render.path = path;
    })
}

/// Where a pixel shows the exact ball; none beside it and near its outline.
fn on_ball(pixel: usize) -> Option<DVec3> {
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let step = HEIGHT_M / f64::from(SIZE.1);
    let of = |index: usize, side: usize| (index as f64 + 0.5 - 0.5 * side as f64) * step;
    let (x, y) = (of(pixel % width, width), -of(pixel / width, height));
    let z_squared = 1.0 - x * x - y * y;
    (z_squared > 0.1).then(|| DVec3::new(x, y, z_squared.sqrt()))
}

/// Where each row of the picture reaches a cosine, in pixels; only rows that begin on the dark side.
fn line(cosines: &[Option<f64>]) -> Vec<Option<f64>> {
    let of_row = |row: &[Option<f64>]| {
        let first = row.iter().position(|cosine| cosine.is_some_and(|cosine| cosine >= LEVEL))?;
        let (before, at) = (row.get(first.checked_sub(1)?).copied()??, row[first]?);
        Some(first as f64 - (at - LEVEL) / (at - before).max(1e-9))
    };
    cosines.chunks_exact(SIZE.0 as usize).map(of_row).collect()
}

/// By how many pixels the line where light ends lies off the closed form's: its mean, its standard deviation and the
/// most.
fn line_off(found: &[Option<f64>], exact: &[Option<f64>]) -> (f64, f64, f64) {
    let off = Vec::from_iter(line(found).iter().zip(line(exact)).filter_map(|(found, exact)| Some((*found)? - exact?)));
    assert!(off.len() > 100, "nothing to look at: {} rows", off.len());
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let variance = off.iter().map(|off| (off - mean).powi(2)).sum::<f64>() / off.len() as f64;
    (mean, variance.sqrt(), off.iter().map(|off| off.abs()).fold(0.0, f64::max))
}

/// The cosine to the sun by which Lambert's law has the radiance of each pixel of the ball.
fn found_cosines(renderer: &mut manypass::Renderer, scene: &Scene, request: &FrameRequest) -> Vec<Option<f64>> {
    let found = radiance(renderer, scene, request, 1);
    // 3 lux on white.
    let cosine = |pixel: &[f32; 3]| f64::from(pixel[1]) * std::f64::consts::PI / 3.0;
    found.iter().enumerate().map(|(index, pixel)| on_ball(index).map(|_| cosine(pixel))).collect()
}

#[test]
fn light_ends_on_the_great_circle_of_a_ball_of_few_triangles() {
    for to_light in [Vec3::new(0.93, 0.34, 0.3), Vec3::new(0.9, 0.42, 0.0), Vec3::new(0.97, 0.1, 0.2)] {
        let scene = ball(to_light).finish();
        let sun = to_light.as_dvec3().normalize();
        let exact: Vec<_> =
            (0..(SIZE.0 * SIZE.1) as usize).map(|pixel| on_ball(pixel).map(|place| place.dot(sun).max(0.0))).collect();
        let mut renderer = shared();
        renderer.unload();
        renderer.load(&scene).unwrap();
        for path in [Path::Deferred, Path::Forward] {
            let request = request(&scene, path);
            let found = found_cosines(&mut renderer, &scene, &request);
            let plain = found_cosines(&mut renderer, &scene, &unshadowed(&request));
            let (mean, deviation, most) = line_off(&found, &exact);
            let (of_plain, ..) = line_off(&plain, &exact);
            let is_dark = |pixel: &usize| {
                exact[*pixel].is_some_and(|exact| exact > LEVEL)
                    && found[*pixel].zip(plain[*pixel]).is_some_and(|(found, plain)| found < 0.5 * plain)
            };
            let teeth = (0..found.len()).filter(is_dark).count();
            println!("{to_light} {path:?}: {mean:.2} px off, without shadows {of_plain:.2}, deviation {deviation:.2}");
            println!("    at most {most:.2} px, {teeth} pixels are dark");
            // Interpolated normals are not exactly the ball's. With teeth 200 pixels are dark, and the line is 6 to 10
            // pixels off.
            assert!((mean - of_plain).abs() < 0.1, "{to_light} {path:?}: {mean} px off, {of_plain} without shadows");
            assert!(deviation < 0.8 && most < 3.0, "{to_light} {path:?}: {deviation}, {most} px");
            assert!(teeth == 0, "{to_light} {path:?}: {teeth} pixels are dark");
        }
    }
}

/// What is before the ball casts its shadow where light ends, too.
#[test]
fn shadows_of_other_things_stay_where_light_ends() {
    let to_light = Vec3::new(0.93, 0.34, 0.3).normalize();
    // On the great circle that the sun goes through and the eye looks at, where the sun's cosine is 0.12.
    let across = (Vec3::Z - to_light * to_light.z).normalize();
    let middle = to_light * 0.12 + across * (1.0f32 - 0.12 * 0.12).sqrt();
    let mut builder = ball(to_light);
    let away_m = 0.8;
    builder.put(primitives::cube(Vec3::splat(0.4)), matte_white(), at(middle + to_light * away_m));
    let scene = builder.finish();
    let box_middle = (middle + to_light * away_m).as_dvec3();
    let sun = to_light.as_dvec3();
    // Within 0.12 m of the ray through the middle of the box, whose sides are 0.2 m away.
    let is_behind = |place: DVec3| {
        let towards = box_middle - place;
        towards.dot(sun) > 0.3 && towards.reject_from_normalized(sun).length() < 0.12
    };
    for path in [Path::Deferred, Path::Forward] {
        let found = shares(&scene, &request(&scene, path), 1);
        let behind = |(pixel, share): (usize, &Option<f32>)| {
            let place = on_ball(pixel)?;
            // What the box hides from the eye is none of the ball.
            let box_is_before = (box_middle - place).truncate().abs().max_element() < 0.25;
            (place.dot(sun) > 0.02 && is_behind(place) && !box_is_before).then_some((*share)?)
        };
        let shares = Vec::from_iter(found.iter().enumerate().filter_map(behind));
        let lit = shares.iter().filter(|share| **share > 0.02).count();
        println!("{path:?}: {} pixels behind the box, {lit} are lit", shares.len());
        assert!(shares.len() > 100, "nothing to look at: {} pixels", shares.len());
        assert!(lit == 0, "{path:?}: {lit} of {} pixels behind the box are lit", shares.len());
    }
}

/// A flat side that is turned away from the sun stays dark, whatever its normals say.
#[test]
fn flat_sides_that_are_turned_away_stay_dark() {
    let mut builder = seen_along_z();
    let mut primitive = primitives::cube(Vec3::ONE);
    let leaning = Vec3::new(0.4, 0.0, 0.9).normalize();
    for normal in &mut primitive.normals {
        if Vec3::from_array(*normal).z > 0.5 {
            *normal = leaning.to_array();
        }
    }
    builder.put(primitive, matte_white(), at(Vec3::ZERO));
    let to_light = Vec3::new(1.0, 0.1, -0.1);
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, -to_light);
    let scene = builder.finish();
    assert!(leaning.dot(to_light) > 0.2, "the normals face the sun");
    for path in [Path::Deferred, Path::Forward] {
        let found = shares(&scene, &request(&scene, path), 1);
        let step = HEIGHT_M / f64::from(SIZE.1);
        let is_inside = |pixel: usize| {
            let (column, row) = (pixel % SIZE.0 as usize, pixel / SIZE.0 as usize);
            let of = |index: usize, side: u32| ((index as f64 + 0.5 - 0.5 * f64::from(side)) * step).abs();
            of(column, SIZE.0) < 0.4 && of(row, SIZE.1) < 0.4
        };
        let inside = Vec::from_iter(
            found.iter().enumerate().filter(|(pixel, _)| is_inside(*pixel)).filter_map(|(_, share)| *share),
        );
        let lit = inside.iter().filter(|share| **share > 0.02).count();
        println!("{path:?}: {} pixels of the side, {lit} are lit", inside.len());
        assert!(inside.len() > 4000 && lit == 0, "{path:?}: {lit} of {} pixels are lit", inside.len());
    }
}
