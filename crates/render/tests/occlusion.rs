//! Ambient occlusion: planes and edges against closed forms, means over samples, and light that it has to leave alone.
//!
//! Surfaces are as rough as can be, so that specular light is occluded as diffuse light is, and light comes evenly from
//! everywhere: the share of light that is left is the visibility.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::plain_request;
use crate::common::shadows::{light, perspective, radiance, shared};
use glam::{DVec3, Quat, Vec3};
use manypass::{Environment, FrameRequest, OcclusionMethod, Path, PixelSamples, Renderer, Resolution, View};
use manypass_scene::material::{HeightMap, HeightMethod};
use manypass_scene::{
    AlphaMode, Image, ImageSource, LightKind, Material, Node, Sampler, Scene, Texture, TextureRef, TextureTransform,
    primitives,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::compare::{Picture, Tolerance, assert_same, difference};
use std::f64::consts::{FRAC_PI_2, PI};
use std::io::Cursor;

const SIZE: (u32, u32) = (120, 80);
/// How far surfaces occlude each other.
const RADIUS_M: f64 = 1.0;

fn rough(albedo: f32) -> Material {
    Material { roughness_factor: 1.0, ..grey(albedo) }
}

/// A floor before the eye.
fn floor(eye: Vec3, target: Vec3) -> SceneBuilder {
    let mut builder = SceneBuilder::new(eye, target, perspective());
    builder.put(primitives::plane(40.0), rough(0.5), Node::default());
    builder
}

/// A wall at right angles to z, as large as the floor.
fn wall_z(builder: &mut SceneBuilder) {
    let rotation = Quat::from_rotation_x(FRAC_PI_2 as f32);
    builder.put(primitives::plane(40.0), rough(0.5), Node { rotation, ..Node::default() });
}

/// A floor and a wall that meet at a right angle along the x-axis, both far larger than the radius; and one more along
/// the z-axis.
fn corner(eye: Vec3, target: Vec3, has_third: bool) -> Scene {
    let mut builder = floor(eye, target);
    wall_z(&mut builder);
    if has_third {
        let rotation = Quat::from_rotation_z(-FRAC_PI_2 as f32);
        builder.put(primitives::plane(40.0), rough(0.5), Node { rotation, ..Node::default() });
    }
    builder.finish()
}

/// At full size, without light that surfaces reflect to each other.
fn request(scene: &Scene, method: OcclusionMethod) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.occlusion.enabled = true.into();
        settings.occlusion.method = method;
        settings.occlusion.resolution = Resolution::Full;
        settings.occlusion.radius_m = RADIUS_M as f32;
        settings.occlusion.multi_bounce = false;
    })
}

/// Of each pixel the share of light that is left.
fn visibility(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<f64> {
    renderer.unload();
    renderer.load(scene).unwrap();
    let open = radiance(renderer, scene, &request.with(|settings| settings.occlusion.enabled = false.into()), samples);
    let found = radiance(renderer, scene, request, samples);
    found.iter().zip(&open).map(|(found, open)| f64::from(found[1]) / f64::from(open[1])).collect()
}

/// The direction of the ray through the middle of a pixel, and where it begins.
fn ray(view: &View, pixel: usize) -> (DVec3, DVec3) {
    let (x, y) = (pixel % SIZE.0 as usize, pixel / SIZE.0 as usize);
    let half = (0.5 * 0.8f64).tan();
    let aspect = f64::from(SIZE.0) / f64::from(SIZE.1);
    let across = (2.0 * (x as f64 + 0.5) / f64::from(SIZE.0) - 1.0) * half * aspect;
    let up = (1.0 - 2.0 * (y as f64 + 0.5) / f64::from(SIZE.1)) * half;
    let world_from_view = view.world_from_view.as_dmat4();
    (world_from_view.w_axis.truncate(), world_from_view.transform_vector3(DVec3::new(across, up, -1.0)))
}

/// Of each pixel of a corner how far it is from the other planes, if all within the radius around it is in the picture.
fn distances(view: &View, has_third: bool) -> Vec<Option<[f64; 2]>> {
    let inside = |position: DVec3| {
        let seen = view.world_from_view.as_dmat4().inverse().transform_point3(position);
        let half = (0.5 * 0.8f64).tan();
        let aspect = f64::from(SIZE.0) / f64::from(SIZE.1);
        seen.z < -0.1 && seen.y.abs() < -seen.z * half && seen.x.abs() < -seen.z * half * aspect
    };
    let least = DVec3::new(if has_third { 0.0 } else { f64::MIN }, 0.0, 0.0);
    let of = |pixel| {
        let (eye, direction) = ray(view, pixel);
        let hits = (0..3).filter(|axis| least[*axis] == 0.0).map(|axis| -eye[axis] / direction[axis]);
        let position = eye + direction * hits.filter(|t| *t > 0.0).fold(f64::INFINITY, f64::min);
        let around = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
        let around = around.map(|step| (position + step * RADIUS_M).max(least));
        // Of the plane that it is on it is 0, or next to that.
        let mut planes = [if has_third { position.x } else { f64::INFINITY }, position.y, position.z];
        planes.sort_by(f64::total_cmp);
        around.into_iter().all(inside).then_some([planes[1], planes[2]])
    };
    (0..(SIZE.0 * SIZE.1) as usize).map(of).collect()
}

/// The share of light, by the cosine, that reaches a point so far from two walls at right angles to each other and to
/// its plane, where they hide what they do within `radius_m` of the point. By Nusselt's analogy it is of the unit disc,
/// the plane's hemisphere from above, what lies on this side of two chords: a ray whose direction has the component c
/// towards a wall meets it after the distance / c.
fn closed_form(distances_m: [f64; 2], radius_m: f64) -> f64 {
    let [a, b] = distances_m.map(|distance| (distance / radius_m).min(1.0));
    let segment = |c: f64| c.acos() - c * (1.0 - c * c).sqrt();
    let beyond = |c: f64, other: f64| c * ((1.0 - c * c).sqrt() - other);
    let both = if a * a + b * b < 1.0 { 0.5 * (a.acos() - b.asin() - beyond(a, b) - beyond(b, a)) } else { 0.0 };
    1.0 - (segment(a) + segment(b) - both) / PI
}

#[test]
fn the_closed_form_is_an_integral() {
    for distances_m in [[0.05, 9.0], [0.3, 9.0], [0.8, 9.0], [0.1, 0.2], [0.5, 0.3], [0.7, 0.8]] {
        let (mut seen, mut all) = (0.0, 0.0);
        for i in 0..200 {
            for j in 0..400 {
                let (up, around) = ((f64::from(i) + 0.5) / 200.0 * FRAC_PI_2, (f64::from(j) + 0.5) / 400.0 * 2.0 * PI);
                let weight = up.cos() * up.sin();
                let towards = [up.sin() * around.cos(), up.sin() * around.sin()];
                let is_hidden = towards.iter().zip(distances_m).any(|(c, distance)| *c > 0.0 && distance / c < 1.0);
                all += weight;
                seen += if is_hidden { 0.0 } else { weight };
            }
        }
        assert!((seen / all - closed_form(distances_m, 1.0)).abs() < 2e-3, "{distances_m:?}");
    }
}

#[test]
fn a_plane_is_open() {
    let mut renderer = shared();
    for (eye, target) in [
        (Vec3::new(0.0, 2.0, 4.0), Vec3::ZERO),
        (Vec3::new(0.0, 0.6, 4.0), Vec3::new(0.5, 0.3, 0.0)),
        // At a grazing angle.
        (Vec3::new(0.0, 0.05, 4.0), Vec3::new(0.0, 0.0, 0.0)),
    ] {
        let scene = floor(eye, target).finish();
        for method in [OcclusionMethod::Gtao, OcclusionMethod::Ssao] {
            for (resolution, samples) in
                [(Resolution::Full, 1), (Resolution::Full, 8), (Resolution::Half, 1), (Resolution::Quarter, 8)]
            {
                let request = request(&scene, method).with(|settings| settings.occlusion.resolution = resolution);
                let found = visibility(&mut renderer, &scene, &request, samples);
                let floor: Vec<f64> = found.into_iter().filter(|share| share.is_finite()).collect();
                let least = floor.iter().copied().fold(f64::INFINITY, f64::min);
                let most = floor.iter().copied().fold(0.0, f64::max);
                println!(
                    "{eye} {method:?} {resolution:?}, {samples} samples: {least:.5} to {most:.5} of {} pixels",
                    floor.len()
                );
                assert!(floor.len() > 2000 && least > 0.995 && most < 1.005, "{method:?}: {least} to {most}");
            }
        }
    }
}

#[test]
fn corners_are_as_dark_as_their_closed_form() {
    let mut renderer = shared();
    for (eye, target, has_third) in [
        (Vec3::new(0.0, 2.5, 4.5), Vec3::new(0.0, 0.4, 0.4), false),
        (Vec3::new(2.6, 2.0, 4.5), Vec3::new(0.0, 0.4, 0.4), false),
        (Vec3::new(0.5, 4.5, 2.0), Vec3::new(0.0, 0.4, 0.4), false),
        (Vec3::new(3.0, 3.0, 3.0), Vec3::new(0.3, 0.3, 0.3), true),
        (Vec3::new(2.0, 2.5, 4.0), Vec3::new(0.4, 0.3, 0.3), true),
    ] {
        let scene = corner(eye, target, has_third);
        let request = request(&scene, OcclusionMethod::Gtao);
        let distances = distances(&request.camera, has_third);
        // The radius as an edge, as the closed form has it.
        let hard = request.with(|settings| settings.occlusion.falloff = 0.0);
        let found = visibility(&mut renderer, &scene, &hard, 64);
        for from_m in [0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85] {
            let near = distances.iter().zip(&found).filter_map(|(distances, share)| {
                let distances = distances.filter(|distances| (distances[0] - from_m).abs() < 0.03)?;
                Some(share / closed_form(distances, RADIUS_M))
            });
            let ratios: Vec<f64> = near.collect();
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            let worst = ratios.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
            println!(
                "{eye}, {from_m} m: {mean:.4} of the closed form, at most {worst:.4} off, {} pixels",
                ratios.len()
            );
            assert!(ratios.len() > 20 && (mean - 1.0).abs() < 0.05, "{eye} {from_m} m: {mean}, {}", ratios.len());
        }
        if has_third {
            continue;
        }
        // What fades out over the last half of the radius lies between what ends at its beginning and what ends at its
        // end.
        let faded = visibility(&mut renderer, &scene, &request, 64);
        for (distances, share) in distances.iter().zip(&faded) {
            let Some(distances) = distances.filter(|distances| distances[0] > 0.05) else { continue };
            let [least, most] = [RADIUS_M, 0.5 * RADIUS_M].map(|radius_m| closed_form(distances, radius_m));
            assert!(*share > 0.93 * least && *share < 1.1 * most, "{distances:?} m: {share}, {least} to {most}");
        }
    }
}

/// Points lie at 0.1 to 1 of the radius, the denser the nearer (0.1 + 0.9 · u²), and hide what is behind them: the mean of
/// closed forms for these radii.
#[test]
fn corners_by_points_are_as_dark_as_the_mean_over_their_distances() {
    let mut renderer = shared();
    let of_points = |distances: [f64; 2]| {
        let radius_m = |i: u32| RADIUS_M * (0.1 + 0.9 * ((f64::from(i) + 0.5) / 256.0).powi(2));
        (0..256).map(|i| closed_form(distances, radius_m(i))).sum::<f64>() / 256.0
    };
    for (eye, target, has_third) in [
        (Vec3::new(0.0, 2.5, 4.5), Vec3::new(0.0, 0.4, 0.4), false),
        (Vec3::new(2.6, 2.0, 4.5), Vec3::new(0.0, 0.4, 0.4), false),
        (Vec3::new(3.0, 3.0, 3.0), Vec3::new(0.3, 0.3, 0.3), true),
    ] {
        let scene = corner(eye, target, has_third);
        let request = request(&scene, OcclusionMethod::Ssao);
        let distances = distances(&request.camera, has_third);
        let found = visibility(&mut renderer, &scene, &request, 64);
        for from_m in [0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85] {
            let near = distances.iter().zip(&found).filter_map(|(distances, share)| {
                let distances = distances.filter(|distances| (distances[0] - from_m).abs() < 0.03)?;
                Some([share / of_points(distances), share / closed_form(distances, RADIUS_M)])
            });
            let ratios: Vec<[f64; 2]> = near.collect();
            let mean = |which: usize| ratios.iter().map(|ratio| ratio[which]).sum::<f64>() / ratios.len() as f64;
            println!("{eye}, {from_m} m: {:.4} of its own closed form, {:.4} of the radius'", mean(0), mean(1));
            assert!(ratios.len() > 20 && (mean(0) - 1.0).abs() < 0.02, "{eye} {from_m} m: {}", mean(0));
        }
    }
}

/// Boxes and a ball on a floor before a wall.
fn room() -> Scene {
    let eye = Vec3::new(2.2, 2.2, 4.5);
    let mut builder = floor(eye, Vec3::new(0.0, 0.5, 0.4));
    wall_z(&mut builder);
    builder.put(primitives::cube(Vec3::splat(0.8)), rough(0.8), at(Vec3::new(-0.8, 0.4, 0.7)));
    builder.put(primitives::cube(Vec3::new(0.3, 1.6, 0.3)), rough(0.2), at(Vec3::new(0.2, 0.8, 0.5)));
    builder.put(primitives::uv_sphere(0.4, 48, 24), rough(0.6), at(Vec3::new(0.9, 0.4, 0.9)));
    builder.finish()
}

const METHODS: [OcclusionMethod; 2] = [OcclusionMethod::Gtao, OcclusionMethod::Ssao];

#[test]
fn few_samples_are_as_dark_as_many() {
    let mut renderer = shared();
    let scene = room();
    for method in METHODS {
        let request = request(&scene, method);
        let [few, many] = [16, 256].map(|samples| visibility(&mut renderer, &scene, &request, samples));
        let pairs: Vec<(f64, f64)> = few.into_iter().zip(many).filter(|(few, _)| few.is_finite()).collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
        let darkest = pairs.iter().map(|(_, many)| *many).fold(1.0, f64::min);
        let (all, bias) = (mean(&|pair| pair.1), mean(&|(few, many)| few - many));
        let rms = mean(&|(few, many)| (few - many).powi(2)).sqrt();
        println!(
            "{method:?}: mean {all:.4}, darkest {darkest:.3}, bias {bias:.5}, rms {rms:.5} of {} pixels",
            pairs.len()
        );
        assert!(darkest < 0.5 && all < 0.95, "{method:?}: there is something to see: {darkest}, {all}");
        assert!(bias.abs() < 0.002 && rms < 0.02, "{method:?}: {bias}, {rms}");
    }
}

/// Where a picture is smooth: its neighbours within two pixels differ little.
fn is_smooth(picture: &[f64], pixel: usize) -> bool {
    let width = SIZE.0 as usize;
    let (x, y) = (pixel % width, pixel / width);
    let around = |x: usize, y: usize| (picture[y * width + x] - picture[pixel]).abs() < 0.02;
    let inside = x >= 4 && y >= 4 && x + 4 < width && y + 4 < SIZE.1 as usize;
    inside && (y - 4..=y + 4).all(|y| (x - 4..=x + 4).all(|x| around(x, y)))
}

#[test]
fn smaller_pictures_agree_away_from_edges() {
    let mut renderer = shared();
    let scene = room();
    for method in METHODS {
        for samples in [1, 16] {
            let base = request(&scene, method);
            let mut at = |resolution| {
                let request = base.with(|settings| settings.occlusion.resolution = resolution);
                visibility(&mut renderer, &scene, &request, samples)
            };
            let full = at(Resolution::Full);
            for resolution in [Resolution::Half, Resolution::Quarter] {
                let coarse = at(resolution);
                let off = |pixel: usize| (coarse[pixel] - full[pixel]).abs();
                let smooth: Vec<usize> = (0..full.len()).filter(|pixel| is_smooth(&full, *pixel)).collect();
                let mean = smooth.iter().map(|pixel| off(*pixel)).sum::<f64>() / smooth.len() as f64;
                let most = smooth.iter().map(|pixel| off(*pixel)).fold(0.0, f64::max);
                let all = (0..full.len()).filter(|pixel| full[*pixel].is_finite()).map(off);
                let all: Vec<f64> = all.collect();
                let everywhere = all.iter().sum::<f64>() / all.len() as f64;
                println!(
                    "{method:?} {resolution:?} {samples}: {mean:.5}, at most {most:.4} off in {} smooth pixels; {everywhere:.5} in all",
                    smooth.len()
                );
                assert!(smooth.len() > 500 && mean < 0.01 && most < 0.06, "{method:?} {resolution:?}: {mean} {most}");
                assert!(everywhere > 1e-4 && everywhere < 0.05, "{method:?} {resolution:?}: {everywhere}");
            }
        }
    }
}

#[test]
fn a_picture_of_one_sample_keeps_no_pattern() {
    let mut renderer = shared();
    let scene = room();
    for method in METHODS {
        for resolution in [Resolution::Full, Resolution::Half] {
            let request = request(&scene, method).with(|settings| settings.occlusion.resolution = resolution);
            let [one, many] = [1, 64].map(|samples| visibility(&mut renderer, &scene, &request, samples));
            let side = 4 * resolution.side_px() as usize;
            // The mean of what is off at each place of the squares that noise repeats in.
            let mut off = vec![(0.0, 0.0); side * side];
            for pixel in (0..many.len()).filter(|pixel| is_smooth(&many, *pixel)) {
                let (x, y) = (pixel % SIZE.0 as usize, pixel / SIZE.0 as usize);
                let place = &mut off[y % side * side + x % side];
                *place = (place.0 + one[pixel] - many[pixel], place.1 + 1.0);
            }
            let means: Vec<f64> = off.iter().map(|(sum, count)| sum / count).collect();
            let mean = means.iter().sum::<f64>() / means.len() as f64;
            let most = means.iter().map(|of| (of - mean).abs()).fold(0.0, f64::max);
            println!("{method:?} {resolution:?}: {mean:.5} off in the mean, a pattern of {most:.5}");
            // A step of 255 is 0.004.
            assert!(most < 0.003 && mean.abs() < 0.02, "{method:?} {resolution:?}: {most}, {mean}");
        }
    }
}

#[test]
fn pictures_are_the_same_every_time() {
    let mut renderer = shared();
    let scene = room();
    renderer.unload();
    renderer.load(&scene).unwrap();
    for method in METHODS {
        let request = request(&scene, method).with(|settings| settings.occlusion.resolution = Resolution::Half);
        let [first, second] = [1, 9].map(|samples| {
            let [a, b] = [0, 1].map(|_| radiance(&mut renderer, &scene, &request, samples));
            assert!(a == b, "{method:?}, {samples} samples");
            a
        });
        assert!(first != second);
    }
}

#[test]
fn intensity_and_bounces_change_what_is_lost() {
    let mut renderer = shared();
    let scene = room();
    let base = request(&scene, OcclusionMethod::Gtao);
    let mut mean = |change: &dyn Fn(&mut manypass::settings::Settings)| {
        let found = visibility(&mut renderer, &scene, &base.with(change), 1);
        let found: Vec<f64> = found.into_iter().filter(|share| share.is_finite()).collect();
        1.0 - found.iter().sum::<f64>() / found.len() as f64
    };
    let whole = mean(&|_| {});
    let half = mean(&|settings| settings.occlusion.intensity = 0.5);
    let none = mean(&|settings| settings.occlusion.intensity = 0.0);
    let bounced = mean(&|settings| settings.occlusion.multi_bounce = true);
    println!("lost: {whole:.4}, half of it {half:.4}, none {none:.5}, with bounces {bounced:.4}");
    assert!(whole > 0.05 && (half / whole - 0.5).abs() < 0.02 && none.abs() < 1e-3);
    assert!(bounced < 0.9 * whole && bounced > 0.3 * whole, "{bounced} of {whole}");
}

#[test]
fn bent_normals_look_away_from_walls() {
    let mut renderer = shared();
    let scene = corner(Vec3::new(0.0, 2.5, 4.5), Vec3::new(0.0, 0.4, 0.4), false);
    let base = request(&scene, OcclusionMethod::Gtao).with(|settings| {
        // It has no lights of its own.
        settings.environment.source = Environment::Fill;
        settings.occlusion.falloff = 0.0;
        settings.occlusion.steps = 24;
        settings.occlusion.slices = 8;
        settings.occlusion.resolution = Resolution::Half;
    });
    // Next to the edge light comes from a quarter of all directions, whose mean by the cosine is between the two
    // planes: of components 1 / 3 along the normal and 2 / (3 π) away from the wall.
    let turned = (2.0 / PI).atan();
    let mut open = |normal: DVec3| {
        let mut builder = SceneBuilder::new(normal.as_vec3() * 3.0, Vec3::ZERO, perspective());
        let rotation = Quat::from_rotation_arc(Vec3::Y, normal.as_vec3());
        builder.put(primitives::plane(1.0), rough(0.5), Node { rotation, ..Node::default() });
        let scene = builder.finish();
        renderer.unload();
        renderer.load(&scene).unwrap();
        let request = FrameRequest { camera: request(&scene, OcclusionMethod::Gtao).camera, ..base.clone() };
        let request = request.with(|settings| settings.occlusion.enabled = false.into());
        f64::from(radiance(&mut renderer, &scene, &request, 1)[(SIZE.1 / 2 * SIZE.0 + SIZE.0 / 2) as usize][1])
    };
    let towards = |angle: f64| DVec3::new(0.0, angle.cos(), angle.sin());
    let floor_expected = open(towards(turned)) / open(DVec3::Y);
    let wall_expected = open(towards(FRAC_PI_2 - turned)) / open(DVec3::Z);
    for method in METHODS {
        let base = base.with(|settings| settings.occlusion.method = method);
        let straight = visibility(&mut renderer, &scene, &base, 16);
        let bent = visibility(&mut renderer, &scene, &base.with(|settings| settings.occlusion.bent_normals = true), 16);
        let (mut wall, mut floor, mut far) = ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0));
        for (pixel, distances) in distances(&base.camera, false).iter().enumerate() {
            let Some([distance, _]) = distances else { continue };
            let (eye, direction) = ray(&base.camera, pixel);
            let is_wall = eye.z / -direction.z < eye.y / -direction.y;
            let sum = match (is_wall, *distance) {
                (_, 1.1..) => &mut far,
                (true, 0.03..0.1) => &mut wall,
                (false, 0.03..0.1) => &mut floor,
                _ => continue,
            };
            *sum = (sum.0 + bent[pixel] / straight[pixel], sum.1 + 1.0);
        }
        let [wall, floor, far] = [wall, floor, far].map(|(sum, count)| sum / count);
        println!(
            "{method:?}: wall {wall:.3} ({wall_expected:.3}), floor {floor:.3} ({floor_expected:.3}), open {far:.4}"
        );
        assert!((wall_expected - 1.0).abs() > 0.05 && (floor_expected - 1.0).abs() > 0.05);
        assert!((far - 1.0).abs() < 0.01, "{method:?}: {far}");
        for (found, expected) in [(wall, wall_expected), (floor, floor_expected)] {
            // Some of the light is specular, and points lie at a distance from the edge.
            let share = (found - 1.0) / (expected - 1.0);
            assert!((0.35..1.1).contains(&share), "{method:?}: {found} {expected}");
        }
    }
}

#[test]
fn direct_light_stays_what_it_is() {
    let mut renderer = shared();
    let lamps = |scene: &mut SceneBuilder| {
        scene.light(light(LightKind::Point, 20.0), Vec3::new(1.0, 3.0, 2.0), Vec3::NEG_Y);
        scene.light(light(LightKind::Directional, 2.0), Vec3::ZERO, Vec3::new(-0.3, -1.0, -0.6));
    };
    let dark = room();
    let mut lit = SceneBuilder { scene: dark.clone() };
    lamps(&mut lit);
    let lit = lit.finish();
    let gtao = request(&lit, OcclusionMethod::Gtao);
    let mut draw = |scene: &Scene, enabled: bool, environment| {
        let request = gtao.with(|settings| {
            settings.occlusion.enabled = enabled.into();
            settings.environment.source = environment;
        });
        renderer.unload();
        renderer.load(scene).unwrap();
        radiance(&mut renderer, scene, &request, 1)
    };
    let [without, with] = [false, true].map(|enabled| draw(&lit, enabled, Environment::None));
    assert!(without.iter().any(|pixel| pixel[1] > 0.1) && without == with);
    // Where one pass adds both, what lamps add to the environment's light is the same up to the steps of half floats.
    let even = Environment::Color([1.0; 3]);
    for enabled in [false, true] {
        let [both, alone] = [&lit, &dark].map(|scene| draw(scene, enabled, even));
        for ((both, alone), lamps) in both.iter().zip(&alone).zip(&without) {
            let off = (both[1] - alone[1] - lamps[1]).abs();
            assert!(off < 2e-3 * (both[1] + 1.0), "{enabled}: {both:?} {alone:?} {lamps:?}");
        }
    }
}

#[test]
fn passes_are_there_as_they_are_needed() {
    let mut renderer = shared();
    let scene = room();
    renderer.unload();
    renderer.load(&scene).unwrap();
    let mut passes = |request: &FrameRequest| {
        let plan = renderer.plan(&scene, request).unwrap();
        let names = plan.passes.iter().map(|pass| pass.name.to_string());
        names.filter(|name| name.starts_with("occlusion")).collect::<Vec<_>>()
    };
    let gtao = request(&scene, OcclusionMethod::Gtao);
    assert_eq!(passes(&gtao.with(|settings| settings.occlusion.enabled = false.into())), [""; 0]);
    assert_eq!(passes(&gtao), ["occlusion", "occlusion.blur"]);
    let half = gtao.with(|settings| settings.occlusion.resolution = Resolution::Half);
    assert_eq!(passes(&half), ["occlusion", "occlusion.blur", "occlusion.upsample"]);
    // Stills converge without a filter; the first frame of a live view is shown before the others are there.
    let still = FrameRequest { sample_count: 16, ..request(&scene, OcclusionMethod::Ssao) };
    assert_eq!(passes(&still), ["occlusion"]);
    assert_eq!(passes(&FrameRequest { sample_count: 16, ..half }), ["occlusion", "occlusion.upsample"]);
    assert_eq!(passes(&FrameRequest { sample_count: 7, ..still.clone() }), ["occlusion", "occlusion.blur"]);
    assert_eq!(passes(&FrameRequest { goes_on: true, ..still }), ["occlusion", "occlusion.blur"]);
    let dark = gtao.with(|settings| settings.environment.source = Environment::None);
    assert_eq!(passes(&dark), [""; 0]);
}

/// The room, and before it what is not drawn as plain triangles are: a pane with holes and a plate with relief.
fn room_with_panes() -> Scene {
    let mut builder = SceneBuilder { scene: room() };
    let dots = image::RgbaImage::from_fn(16, 16, |x, y| {
        let value = if (x / 2 + y / 2) % 2 == 0 { 255 } else { 0 };
        image::Rgba([255, 255, value, value])
    });
    let heights = image::GrayImage::from_fn(16, 16, |x, y| image::Luma([if x / 4 % 2 == y / 4 % 2 { 255 } else { 0 }]));
    let mut pngs = [Vec::new(), Vec::new()].map(Cursor::new);
    dots.write_to(&mut pngs[0], image::ImageFormat::Png).unwrap();
    heights.write_to(&mut pngs[1], image::ImageFormat::Png).unwrap();
    for (x, png) in [-1.2f32, 0.6].into_iter().zip(pngs) {
        let source = ImageSource::Encoded(png.into_inner().into());
        let texture = builder.scene.textures.len();
        builder.scene.images.push(Image { name: String::new(), source });
        builder.scene.textures.push(Texture { image: texture, sampler: Sampler::default() });
        let map = TextureRef { texture, uv_set: 0, transform: TextureTransform::default() };
        let material = if x < 0.0 {
            Material { base_color_texture: Some(map), alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..rough(0.8) }
        } else {
            let method = HeightMethod::Occlusion;
            let height = HeightMap { texture: map, depth_m: 0.1, method, self_shadow: false };
            Material { height: Some(height), ..rough(0.6) }
        };
        let rotation = Quat::from_rotation_x(if x < 0.0 { FRAC_PI_2 as f32 } else { 0.3 });
        let translation = Vec3::new(x, 0.6, 1.6);
        builder.put(primitives::plane(0.9), material, Node { rotation, translation, ..Node::default() });
    }
    builder.finish()
}

#[test]
fn forward_paths_are_occluded_as_the_deferred_one_is() {
    let mut renderer = shared();
    let scene = room();
    renderer.unload();
    renderer.load(&scene).unwrap();
    // Base colour has eight bits on the deferred path.
    let same = Tolerance { mean: 0.75, ..Tolerance::default() };
    let mut shown = |request: &FrameRequest, path| {
        let request = request.with(|settings| settings.render.path = path);
        renderer.render(&scene, &request).unwrap();
        Picture::from_rgba8(SIZE.0 as usize, SIZE.1 as usize, &renderer.read_display().unwrap())
    };
    for (method, resolution, is_full) in
        [(OcclusionMethod::Gtao, Resolution::Half, true), (OcclusionMethod::Ssao, Resolution::Full, false)]
    {
        let request = request(&scene, method).with(|settings| {
            settings.occlusion.resolution = resolution;
            (settings.occlusion.multi_bounce, settings.occlusion.bent_normals) = (is_full, is_full);
        });
        let truth = shown(&request, Path::Deferred);
        let open = shown(&request.with(|settings| settings.occlusion.enabled = false.into()), Path::Forward);
        assert!(!difference(&truth, &open, 2).is_within(same), "{method:?}: nothing is occluded");
        for path in [Path::Forward, Path::ForwardBatched] {
            let found = shown(&request, path);
            println!("{method:?}, {}: {}", path.name(), difference(&truth, &found, 2));
            assert_same(&truth, &found, same);
        }
        // Of four samples a pixel those at edges take the occlusion of the middle.
        let mut of_four = |enabled: bool| {
            let request = request.with(|settings| {
                settings.occlusion.enabled = enabled.into();
                settings.msaa.samples = PixelSamples::Four;
            });
            shown(&request, Path::Forward)
        };
        let (found, open_of_four) = (of_four(true), of_four(false));
        let inside =
            Tolerance { share: 0.97, share_between: 0.99, mean: 1.0, area_px: 80, area_between_px: 26, ..same };
        println!("{method:?}: {}", difference(&truth, &found, 2));
        assert_same(&truth, &found, inside);
        assert!(!difference(&truth, &open_of_four, 2).is_within(inside));
    }
}

#[test]
fn what_is_drawn_again_lies_where_it_was_drawn_before() {
    let mut renderer = shared();
    let scene = room_with_panes();
    renderer.unload();
    renderer.load(&scene).unwrap();
    let request = request(&scene, OcclusionMethod::Gtao).with(|settings| settings.occlusion.intensity = 0.0);
    for path in [Path::Forward, Path::ForwardBatched] {
        let [before, alone] = [true, false].map(|enabled| {
            let request = request.with(|settings| {
                settings.render.path = path;
                settings.occlusion.enabled = enabled.into();
            });
            renderer.render(&scene, &request).unwrap();
            Picture::from_rgba8(SIZE.0 as usize, SIZE.1 as usize, &renderer.read_display().unwrap())
        });
        let found = difference(&alone, &before, 0);
        println!("{}: {found}", path.name());
        assert!(found.is_within(Tolerance { within: 0, ..Tolerance::default() }), "{}: {found}", path.name());
    }
}

#[test]
fn what_has_no_occlusion_is_refused() {
    let mut renderer = shared();
    let scene = room();
    renderer.unload();
    renderer.load(&scene).unwrap();
    let gouraud = request(&scene, OcclusionMethod::Gtao).with(|settings| settings.render.path = Path::Gouraud);
    let error = renderer.render(&scene, &gouraud).unwrap_err().to_string();
    assert!(error.contains("`occlusion.enabled=true` needs `render.path=deferred`"), "{error}");
    let mut settings = request(&scene, OcclusionMethod::Gtao).settings;
    for value in ["-1", "NaN", "inf", "1e7", "wide"] {
        let error = settings.set("occlusion.radius_m", value).unwrap_err().to_string();
        assert!(error.contains("occlusion.radius_m"), "{value}: {error}");
    }
    assert_eq!(settings.occlusion.radius_m, RADIUS_M as f32);
}

#[test]
fn extreme_settings_and_sizes_leave_numbers() {
    let mut renderer = shared();
    let scene = room();
    renderer.unload();
    renderer.load(&scene).unwrap();
    let sizes = [(1, 1), (1, 4096), (64, 3), (48, 32)];
    let numbers = [(0.0, 0.5, 0.1, 4.0), (1e6, 1.0, 1.0, 1.0), (1e-6, 0.0, 0.0, 1.0), (1e6, 0.0, 1.0, 0.0)];
    for method in METHODS {
        for (i, size) in sizes.into_iter().enumerate() {
            for (resolution, (radius_m, falloff, thinness, intensity)) in
                [Resolution::Full, Resolution::Half, Resolution::Quarter]
                    .into_iter()
                    .zip(numbers.into_iter().cycle().skip(i))
            {
                let request = FrameRequest { width: size.0, height: size.1, ..request(&scene, method) };
                let request = request.with(|settings| {
                    let occlusion = &mut settings.occlusion;
                    (occlusion.radius_m, occlusion.falloff, occlusion.thinness) = (radius_m, falloff, thinness);
                    (occlusion.intensity, occlusion.resolution, occlusion.bent_normals) = (intensity, resolution, true);
                });
                let found = radiance(&mut renderer, &scene, &request, 1);
                let are_numbers = found.iter().flatten().all(|value| value.is_finite() && *value >= 0.0);
                assert!(are_numbers && found.iter().any(|pixel| pixel[1] > 0.0), "{method:?} {size:?} {resolution:?}");
            }
        }
    }
}
