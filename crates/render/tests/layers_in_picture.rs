//! What the picture shows in the place of the environment's light, on materials with layers: occlusion, reflections and
//! light that surfaces send each other, against plain materials, whose own tests have closed forms.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::plain_request;
use crate::common::shadows::{perspective, radiance, shared};
use glam::{Quat, Vec3};
use manypass::{Averaging, Environment, FrameRequest, Path, Renderer, Resolution, Settings};
use manypass_scene::material::{Clearcoat, Sheen, Specular, TexturedFactor};
use manypass_scene::{Material, Node, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, grey};
use std::f32::consts::FRAC_PI_2;

const SIZE: (u32, u32) = (96, 64);

/// Linear grey and roughness that the G-buffer's bytes hold exactly: 188/255 in sRGB, and 51/255.
const GREY: f32 = 0.502_886_5;
const ROUGHNESS: f32 = 0.2;

fn plain(albedo: f32, roughness_factor: f32) -> Material {
    Material { roughness_factor, ..grey(albedo) }
}

fn specular(weight: f32, color: f32) -> Option<Specular> {
    Some(Specular {
        weight: TexturedFactor::new(weight),
        color: TexturedFactor::new(Vec3::splat(color)),
        glossiness: None,
    })
}

fn coat(weight: f32, roughness: f32) -> Option<Clearcoat> {
    Some(Clearcoat {
        weight: TexturedFactor::new(weight),
        roughness: TexturedFactor::new(roughness),
        ..Clearcoat::default()
    })
}

fn sheen(color: f32, roughness: f32) -> Option<Sheen> {
    Some(Sheen { color: TexturedFactor::new(Vec3::splat(color)), roughness: TexturedFactor::new(roughness) })
}

/// A floor, and behind it a wall that glows.
fn corner(floor: Material, wall: [f32; 3]) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(1.5, 1.2, 3.5), Vec3::new(0.0, 0.2, 0.3), perspective());
    builder.put(primitives::plane(20.0), floor, Node::default());
    let base_color_factor = Vec3::from(wall).extend(1.0);
    let glowing = Material { base_color_factor, shading_model: ShadingModel::Unlit, ..Material::default() };
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    builder.put(primitives::plane(20.0), glowing, Node { rotation, ..Node::default() });
    builder.finish()
}

/// Light of 1 from everywhere, and nothing that is found in the picture yet; at full size if it is.
fn request(scene: &Scene) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.occlusion.radius_m = 1.0;
        settings.gi.radius_m = 1.0;
        settings.gi.brightness_max = 0.0;
        settings.reflections.brightness_max = 0.0;
        settings.occlusion.resolution = Resolution::Full;
        settings.gi.resolution = Resolution::Full;
        settings.reflections.resolution = Resolution::Full;
    })
}

fn occluded(settings: &mut Settings) {
    settings.occlusion.enabled = true.into();
}

fn reflecting(settings: &mut Settings) {
    settings.reflections.enabled = true.into();
}

fn lit(settings: &mut Settings) {
    settings.gi.enabled = true;
}

fn picture(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    change: impl FnOnce(&mut Settings),
) -> Vec<[f32; 3]> {
    renderer.unload();
    renderer.load(scene).unwrap();
    radiance(renderer, scene, &request.with(change), 1)
}

/// The mean and the greatest difference of two pictures.
fn apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> (f32, f32) {
    let both = a.as_flattened().iter().zip(b.as_flattened());
    let differences: Vec<f32> = both.map(|(a, b)| (a - b).abs()).collect();
    (differences.iter().sum::<f32>() / differences.len() as f32, differences.into_iter().fold(0.0, f32::max))
}

/// Layers that add nothing to what the material is without them.
fn idle() -> [(&'static str, Material); 3] {
    let base = plain(GREY, ROUGHNESS);
    [
        ("specular", Material { specular: specular(1.0, 1.000_001), ..base.clone() }),
        ("clear coat", Material { clearcoat: coat(0.0, 0.0), ..base.clone() }),
        ("sheen", Material { sheen: sheen(0.0, 0.5), ..base }),
    ]
}

#[test]
fn layers_that_add_nothing_change_nothing() {
    let mut renderer = shared();
    let wall = [0.8, 0.4, 0.1];
    let base = corner(plain(GREY, ROUGHNESS), wall);
    let all = |settings: &mut Settings| {
        occluded(settings);
        reflecting(settings);
        lit(settings);
    };
    for resolution in [Resolution::Full, Resolution::Half] {
        let request = request(&base).with(|settings| {
            settings.occlusion.resolution = resolution;
            settings.gi.resolution = resolution;
            settings.reflections.resolution = resolution;
        });
        let of_base = picture(&mut renderer, &base, &request, all);
        let open = picture(&mut renderer, &base, &request, |_| ());
        assert!(apart(&of_base, &open).0 > 0.02, "{:?}", apart(&of_base, &open));
        for (name, floor) in idle() {
            let found = picture(&mut renderer, &corner(floor, wall), &request, all);
            let (mean, most) = apart(&found, &of_base);
            println!("{name}, {resolution:?}: {mean} in the mean, {most} at most");
            assert!(most < 1.0 / 255.0, "{name}, {resolution:?}: {most}");
        }
    }
}

/// Layers as they are used.
fn layered() -> [(&'static str, Material); 3] {
    let base = plain(GREY, ROUGHNESS);
    [
        ("specular", Material { specular: specular(0.8, 1.2), ..base.clone() }),
        ("clear coat", Material { clearcoat: coat(1.0, 0.1), ..base.clone() }),
        ("sheen", Material { sheen: sheen(0.3, 0.5), ..base }),
    ]
}

#[test]
fn layers_change_about_as_plain_surfaces_do() {
    let mut renderer = shared();
    let wall = [0.1, 0.2, 0.1];
    let mut changes = |floor: Material| {
        let scene = corner(floor, wall);
        let request = request(&scene);
        let open = picture(&mut renderer, &scene, &request, |_| ());
        [occluded as fn(&mut Settings), reflecting, lit]
            .map(|change| apart(&picture(&mut renderer, &scene, &request, change), &open).0)
    };
    let of_plain = changes(plain(GREY, ROUGHNESS));
    for (name, floor) in layered() {
        let of_layers = changes(floor);
        println!("{name}: {of_layers:?}, plain: {of_plain:?}");
        for (of_layers, of_plain) in of_layers.iter().zip(of_plain) {
            assert!(of_plain > 0.003, "{of_plain}");
            assert!((0.4..3.0).contains(&(of_layers / of_plain)), "{name}: {of_layers}, plain: {of_plain}");
        }
    }
}

/// In even light all that a rough surface sends back is less by the same share, whatever its lobes.
#[test]
fn occlusion_scales_all_lobes_of_rough_layers_alike() {
    let mut renderer = shared();
    let rough = plain(GREY, 1.0);
    let floors = [
        Material { specular: specular(0.5, 1.5), ..rough.clone() },
        Material { clearcoat: coat(1.0, 1.0), ..rough.clone() },
        Material { sheen: sheen(0.4, 0.8), ..rough.clone() },
        Material { sheen: sheen(0.4, 0.8), clearcoat: coat(0.5, 1.0), specular: specular(0.0, 1.0), ..rough.clone() },
    ];
    for path in [Path::Deferred, Path::Forward, Path::ForwardBatched] {
        let mut shares = |floor: &Material| {
            let scene = corner(floor.clone(), [0.5; 3]);
            let request = request(&scene).with(|settings| {
                settings.render.path = path;
                settings.occlusion.multi_bounce = false;
            });
            let open = picture(&mut renderer, &scene, &request, |_| ());
            let found = picture(&mut renderer, &scene, &request, occluded);
            found.iter().zip(open).map(|(found, open)| found[1] / open[1]).collect::<Vec<_>>()
        };
        let expected = shares(&rough);
        assert!(expected.iter().any(|share| *share < 0.7));
        for (at, floor) in floors.iter().enumerate() {
            let worst = shares(floor).iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 0.01, "{path:?}, floor {at}: {worst}");
        }
    }
}

/// A coat over what mirrors nothing is the surface of a dielectric of index 1.5: it follows the same rays.
#[test]
fn a_clear_coat_reflects_as_a_smooth_surface_does() {
    let mut renderer = shared();
    let black = Vec3::ZERO.extend(1.0);
    let smooth = Material { base_color_factor: black, ..plain(0.0, 0.0) };
    let coated = Material { clearcoat: coat(1.0, 0.0), specular: specular(0.0, 1.0), ..plain(0.0, 1.0) };
    // What lies below is too rough to reflect the picture.
    let over_rough = Material { specular: None, ..coated.clone() };
    for path in [Path::Deferred, Path::Forward] {
        let mut found = |floor: &Material, change: fn(&mut Settings)| {
            let scene = corner(floor.clone(), [0.9, 0.5, 0.2]);
            let request = request(&scene).with(|settings| {
                settings.environment.source = Environment::None;
                settings.render.path = path;
            });
            picture(&mut renderer, &scene, &request, change)
        };
        let expected = found(&smooth, reflecting);
        assert!(apart(&expected, &found(&smooth, |_| ())).0 > 0.004);
        for floor in [&coated, &over_rough] {
            let (mean, most) = apart(&found(floor, reflecting), &expected);
            println!("{path:?}: {mean} in the mean, {most} at most");
            assert!(most < 0.01, "{path:?}: {most}");
        }
    }
}

/// Where a wall glows as bright as the environment that it hides, nothing changes.
#[test]
fn what_is_found_takes_the_place_of_the_environment_on_layers() {
    let mut renderer = shared();
    for (name, floor) in layered() {
        let scene = corner(floor, [1.0; 3]);
        let request = request(&scene);
        let open = picture(&mut renderer, &scene, &request, |_| ());
        let reflected = picture(&mut renderer, &scene, &request, reflecting);
        // In a few pixels at the foot of the wall rays end beside it, and the filter is too narrow there to make that less.
        let (mean, most) = apart(&reflected, &open);
        assert!(mean < 0.001 && most < 0.15, "{name}: {mean} in the mean, {most} at most");
        // A single sample may find a share of light above 1, as on plain surfaces.
        let lit = picture(&mut renderer, &scene, &request, lit);
        assert!(apart(&lit, &open).0 < 0.015, "{name}: {:?}", apart(&lit, &open));
    }
}

/// Stills whose first samples find for all what the picture shows.
#[test]
fn later_samples_of_stills_show_on_layers_what_the_first_found() {
    let mut renderer = shared();
    let wall = [0.8, 0.4, 0.1];
    let mut still = |floor: Material, is_on: bool| {
        let scene = corner(floor, wall);
        renderer.unload();
        renderer.load(&scene).unwrap();
        let request = request(&scene).with(|settings| {
            settings.occlusion.enabled = is_on.into();
            settings.reflections.enabled = is_on.into();
            settings.occlusion.resolution = Resolution::Half;
            settings.reflections.resolution = Resolution::Half;
        });
        let request = FrameRequest { averaging: Averaging::Display, sample_count: 16, ..request };
        for sample_index in 0..request.sample_count {
            renderer.render(&scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
        }
        renderer.read_display().unwrap()
    };
    let rms = |a: &[u8], b: &[u8]| {
        let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
        (squares / a.len() as f64).sqrt()
    };
    let [(_, floor), ..] = idle();
    let of_base = still(plain(GREY, ROUGHNESS), true);
    let (found, open) = (still(floor.clone(), true), still(floor, false));
    let (apart, changed) = (rms(&found, &of_base), rms(&open, &of_base));
    println!("{apart:.3}/255 from plain, {changed:.3} without");
    assert!(changed > 3.0 && apart < 0.15 * changed, "{apart} {changed}");
}
