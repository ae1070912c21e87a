//! What the samples of a picture take: one alone has no means, and lists of lights are made once for all of them.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::Vec3;
use manypass::graph::Plan;
use manypass::{
    Averaging, Background, Environment, FrameRequest, FrameStats, LightCulling, Path, RenderError, Renderer,
};
use manypass::{Tonemap, WgslEffect};
use manypass_scene::{LightKind, Projection, Scene};
use manypass_testkit::scenes;
use std::sync::Arc;

/// Pixels of a picture in 4K.
const LARGE: u64 = 3840 * 2160;

fn names(plan: &Plan) -> String {
    let passes = plan.passes.iter().map(|pass| pass.name.as_ref());
    passes.chain(plan.textures.iter().map(|texture| texture.name.as_ref())).collect::<Vec<_>>().join(" ")
}

#[test]
fn one_sample_takes_neither_means_nor_the_pass_that_makes_them() {
    let test = scenes::one_light_on_one_plane();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let request = |averaging, sample_count, light_rounds| FrameRequest {
        averaging,
        sample_count,
        light_rounds,
        ..plain_request(&test.scene, (3840, 2160))
    };
    // So many means of 16 bytes a pixel beside the picture itself. Where lights take turns, what glows has its own.
    for (averaging, samples, rounds, means) in [
        (Averaging::Display, 1, None, 0),
        (Averaging::Radiance, 1, None, 1),
        (Averaging::Both, 1, None, 1),
        (Averaging::Display, 2, Some(1), 2),
        (Averaging::Radiance, 2, None, 2),
        (Averaging::Both, 2, None, 4),
        (Averaging::Display, 2, Some(2), 4),
        (Averaging::Radiance, 2, Some(2), 2),
        (Averaging::Both, 2, Some(2), 6),
    ] {
        for scale in [1.0, 0.5] {
            let request = request(averaging, samples, rounds).with(|settings| settings.render.scale = scale);
            let plan = renderer.plan(&test.scene, &request).unwrap();
            assert_eq!(names(&plan).contains("accumulate"), means > 0, "{averaging:?} {samples}: {}", names(&plan));
            assert_eq!(plan.bytes().imported, LARGE * (4 + 16 * means), "{averaging:?} {samples}");
            // What is refused is what would be made; nothing is drawn for it.
            renderer.set_memory_budget(Some(1));
            match renderer.render(&test.scene, &request).unwrap_err() {
                RenderError::Memory { needed_bytes, budget_bytes } => {
                    assert_eq!((needed_bytes, budget_bytes), (LARGE * (4 + 16 * means), 1), "{averaging:?} {samples}");
                }
                error => panic!("{error}"),
            }
        }
    }
}

/// Writes numbers that are none, limits and negative ones into some pixels.
const FAULTY: &str = "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = radiance_at(vec2i(position.xy));
    let pixel = vec2u(position.xy);
    let zero = here.a - 1.0;
    if pixel.x % 7u == 0u {
        let wrong = select(1e9, zero / zero, pixel.y % 2u == 0u);
        return vec4f(wrong, -1.0, here.b, select(1.0, wrong, pixel.y % 3u == 0u));
    }
    return select(here, vec4f(here.rgb, -0.5), pixel.x % 5u == 0u);
}";

#[test]
fn the_picture_of_one_sample_is_the_same_with_and_without_a_mean() {
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "faulty.wgsl", FAULTY).unwrap());
    for (curve, background, scale, path) in [
        (Tonemap::Neutral, Background::Transparent, 1.0, Path::Deferred),
        (Tonemap::Agx, Background::Color([0.1, 0.5, 0.9]), 1.0, Path::Forward),
        (Tonemap::Aces, Background::Color([0.1, 0.5, 0.9]), 0.5, Path::Deferred),
        (Tonemap::None, Background::Environment, 2.0, Path::Forward),
    ] {
        for effects in [vec![], vec![effect.clone() as Arc<dyn manypass::Effect>]] {
            let mut request = plain_request(&test.scene, (64, 48)).with(|settings| {
                settings.environment.source = Environment::Studio;
                (settings.tone_map.curve, settings.tone_map.dither) = (curve, 1.0);
                (settings.background.source, settings.render.scale, settings.render.path) = (background, scale, path);
            });
            request.effects = effects;
            let pictures = [Averaging::Display, Averaging::Radiance].map(|averaging| {
                request.averaging = averaging;
                renderer.render(&test.scene, &request).unwrap();
                renderer.read_display().unwrap()
            });
            assert!(pictures[0] == pictures[1], "{curve:?} at {scale}");
        }
    }
}

#[test]
fn radiance_that_nobody_asked_for_is_an_error_that_says_so() {
    let test = scenes::one_light_on_one_plane();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let both = plain_request(&test.scene, (16, 16));
    let request = FrameRequest { averaging: Averaging::Display, ..both.clone() };
    renderer.render(&test.scene, &request).unwrap();
    let error = renderer.read_radiance().unwrap_err().to_string();
    assert!(error.contains("averaging") && error.contains("want_aovs"), "{error}");
    for request in [both.clone(), FrameRequest { want_aovs: vec![manypass::Aov::Radiance], ..request.clone() }] {
        renderer.render(&test.scene, &request).unwrap();
        assert_eq!(renderer.read_radiance().unwrap().len(), 4 * 16 * 16);
    }
    // A sample that would be added to nothing.
    let second = FrameRequest { sample_index: 1, ..request.clone() };
    let several = FrameRequest { sample_count: 3, ..request.clone() };
    let wider = FrameRequest { sample_index: 1, width: 17, ..several.clone() };
    let linear = FrameRequest { sample_index: 1, averaging: Averaging::Radiance, ..several.clone() };
    for wrong in [second, wider, linear] {
        renderer.render(&test.scene, &several).unwrap();
        let error = renderer.render(&test.scene, &wrong).unwrap_err().to_string();
        assert!(error.contains("`sample_count`"), "{error}");
        let next = FrameRequest { sample_index: 1, ..several.clone() };
        renderer.render(&test.scene, &next).unwrap();
    }
}

/// Lights of a range, every other one a spot that looks down.
fn lights(count: usize) -> Scene {
    let mut scene = scenes::many_points(count).scene;
    for light in scene.lights.iter_mut().step_by(2) {
        light.kind = LightKind::Spot { inner_cone_rad: 0.2, outer_cone_rad: 0.5 };
    }
    let down = glam::Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(0.3, -1.0, 0.1).normalize());
    scene.nodes.iter_mut().filter(|node| node.light.is_some()).for_each(|node| node.rotation = down);
    scene.update_transforms();
    scene
}

/// Radiance and numbers of every sample of `request`; before each the scene is changed.
fn samples(
    renderer: &mut Renderer,
    mut scene: Scene,
    request: &FrameRequest,
    change: impl Fn(&mut Scene, u32),
) -> Vec<(Vec<f32>, FrameStats)> {
    renderer.load(&scene).unwrap();
    let sample = |sample_index| {
        change(&mut scene, sample_index);
        scene.update_transforms();
        renderer.render(&scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
        (renderer.read_radiance().unwrap(), renderer.stats())
    };
    (0..request.sample_count).map(sample).collect()
}

#[test]
fn lists_are_made_once_for_all_samples_and_hold_every_light_of_each() {
    let scene = lights(200);
    let mut renderer = renderer();
    let plain = FrameRequest { sample_count: 4, averaging: Averaging::Radiance, ..plain_request(&scene, (70, 50)) };
    let parallel = Projection::Orthographic { height_m: 6.0, near_m: 0.01, far_m: 100.0 };
    // Small tiles have most edges.
    for (path, scale, projection, tile_px) in [
        (Path::Deferred, 1.0, plain.camera.projection, 8),
        (Path::Forward, 1.0, parallel, 8),
        (Path::Deferred, 0.5, parallel, 8),
        (Path::Forward, 1.25, plain.camera.projection, 16),
    ] {
        let mut request = plain.with(|settings| {
            (settings.render.path, settings.render.scale) = (path, scale);
            settings.clusters.tile_px = tile_px;
        });
        request.camera.projection = projection;
        let clustered = samples(&mut renderer, scene.clone(), &request, |_, _| ());
        request.settings.lights.culling = LightCulling::None;
        let all = samples(&mut renderer, scene.clone(), &request, |_, _| ());
        for (index, ((found, stats), (expected, _))) in clustered.iter().zip(&all).enumerate() {
            assert!(found == expected, "{path:?} at {scale}, sample {index}: a light is missing");
            assert!(stats.list_entries > 200 && stats.lights == 200, "{stats:?}");
            assert_eq!(stats.light_lists_made, u32::from(index == 0), "sample {index}");
            // Lists and lights are tens of thousands of bytes, uniforms some hundreds.
            assert!(index == 0 || stats.uploaded_bytes < 2048, "sample {index}: {} bytes", stats.uploaded_bytes);
        }
        assert!(clustered[0].0.iter().any(|value| *value > 0.01), "all is dark");
    }
}

#[test]
fn lists_of_all_samples_miss_no_pair_in_range() {
    // Light ends so softly that a picture does not show a pair which is missed at the end of its range.
    let scene = lights(150);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut pairs = |culling, tile_px| {
        let request = plain_request(&scene, (90, 60)).with(|settings| {
            (settings.lights.culling, settings.clusters.tile_px) = (culling, tile_px);
        });
        let of_sample = |sample_index| {
            let counts =
                renderer.count_pairs(&scene, &FrameRequest { sample_index, sample_count: 8, ..request.clone() });
            (counts.unwrap().pairs_in_range, renderer.stats().light_lists_made)
        };
        (0..8).map(of_sample).collect::<Vec<_>>()
    };
    let all = pairs(LightCulling::None, 8);
    let clustered = pairs(LightCulling::Clustered, 8);
    assert_eq!(clustered, all);
    assert!(all[0].0 > 1000 && all.iter().map(|(_, made)| made).sum::<u32>() == 1, "{all:?}");
}

#[test]
fn lists_are_made_again_where_lights_move_between_samples() {
    let mut renderer = renderer();
    let scene = lights(100);
    let mut request =
        FrameRequest { sample_count: 5, averaging: Averaging::Radiance, ..plain_request(&scene, (64, 48)) };
    let change = |scene: &mut Scene, sample: u32| match sample {
        // Brighter is the same lists; farther away and farther reaching are others.
        1 => scene.lights.iter_mut().for_each(|light| light.intensity *= 1.5),
        2 => {
            let node = scene.nodes.iter().position(|node| node.light.is_some()).unwrap();
            scene.nodes[node].translation += Vec3::new(0.4, 0.0, 0.3);
        }
        3 => scene.lights[7].range_m = scene.lights[7].range_m.map(|range| 2.0 * range),
        _ => (),
    };
    let clustered = samples(&mut renderer, scene.clone(), &request, change);
    request.settings.lights.culling = LightCulling::None;
    let all = samples(&mut renderer, scene.clone(), &request, change);
    assert!(clustered.iter().zip(&all).all(|((found, _), (expected, _))| found == expected));
    assert!(clustered.windows(2).take(3).all(|pair| pair[0].0 != pair[1].0), "the light changes");
    let made: Vec<u32> = clustered.iter().map(|(_, stats)| stats.light_lists_made).collect();
    assert_eq!(made, [1, 0, 1, 1, 0]);
    // Brighter lights are uploaded, and no lists.
    let table_bytes = 100 * 4 * 16;
    assert!((table_bytes..table_bytes + 2048).contains(&clustered[1].1.uploaded_bytes), "{:?}", clustered[1].1);
}

#[test]
fn lists_follow_all_that_they_are_made_of() {
    let scene = lights(100);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let plain = plain_request(&scene, (64, 48));
    let mut made = |request: &FrameRequest| {
        renderer.render(&scene, request).unwrap();
        renderer.stats().light_lists_made
    };
    assert_eq!([made(&plain), made(&plain)], [1, 0]);
    let mut moved = plain.clone();
    moved.camera.world_from_view.w_axis.y += 0.01;
    let mut narrower = plain.clone();
    if let Projection::Perspective { fov_y_rad, .. } = &mut narrower.camera.projection {
        *fov_y_rad *= 0.9;
    }
    let others = [
        ("camera", moved),
        ("field of view", narrower),
        ("size", FrameRequest { width: 65, ..plain.clone() }),
        ("subset", FrameRequest { light_subset: Some((1, 2)), ..plain.clone() }),
        ("scale", plain.with(|settings| settings.render.scale = 0.5)),
        ("tiles", plain.with(|settings| settings.clusters.tile_px = 32)),
        ("slices", plain.with(|settings| settings.clusters.slices = 8)),
        ("culling", plain.with(|settings| settings.lights.culling = LightCulling::None)),
    ];
    for (what, request) in others {
        assert_eq!([made(&request), made(&request), made(&plain)], [1, 0, 1], "{what}");
    }
    // What lists know nothing of.
    assert_eq!(made(&plain.with(|settings| settings.environment.source = Environment::Color([0.5; 3]))), 0);
    assert_eq!(made(&FrameRequest { sample_count: 2, ..plain.clone() }), 0);
}

#[test]
fn without_lights_of_a_range_there_are_no_lists() {
    let mut renderer = renderer();
    for scene in [scenes::sun().scene, scenes::furnace(4, [1.0, 1.0]).scene] {
        renderer.load(&scene).unwrap();
        let uploaded = [LightCulling::Clustered, LightCulling::None].map(|culling| {
            let request = plain_request(&scene, (64, 48)).with(|settings| settings.lights.culling = culling);
            renderer.render(&scene, &request).unwrap();
            let stats = renderer.stats();
            assert!(stats.lights > 0 && stats.list_entries == 0, "{stats:?}");
            stats.uploaded_bytes
        });
        // There is one cluster with an empty list, as there is without culling: neither table nor grid is another.
        assert!(uploaded[0] > 0 && uploaded[1] == 0, "{uploaded:?}");
    }
}
