//! Several cameras in one frame, what a view keeps from frame to frame, and what a frame that is like the last one
//! costs.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, inner_pixels, plain_request, renderer};
use glam::{Mat4, Quat, Vec3};
use manypass::{Aov, Averaging, Background, Environment, FrameRequest, Path, RenderError, Renderer, View, WgslEffect};
use manypass_scene::capture::{Mirror, Monitor, MonitorCamera};
use manypass_scene::{
    Image, Material, Mesh, Node, Primitive, Projection, Sampler, Scene, Texture, TextureRef, primitives,
};
use manypass_testkit::compare::linear_difference;
use manypass_testkit::raycast::Options;
use manypass_testkit::scenes;
use std::sync::Arc;

/// The picture of a view, and its radiance.
fn read(renderer: &Renderer, view: &str) -> (Vec<u8>, Vec<f32>) {
    let view = renderer.rendered(view).unwrap();
    let display = pollster::block_on(view.read_display_async()).unwrap();
    (display, pollster::block_on(view.read_radiance_rows_async(0..u32::MAX)).unwrap())
}

#[test]
fn two_views_of_a_frame_are_the_two_alone() {
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let outer = FrameRequest { sample_count: 3, averaging: Averaging::Both, ..plain_request(&test.scene, (96, 64)) };
    let outer = outer.with(|settings| settings.environment.source = Environment::Studio);
    let mut inner = FrameRequest { width: 40, height: 56, averaging: Averaging::Both, ..outer.clone() };
    inner.camera.world_from_view = Mat4::from_rotation_y(0.7) * inner.camera.world_from_view;
    inner.settings.render.path = Path::Forward;
    inner.settings.background.source = Background::Environment;
    inner.settings.exposure.stops = manypass::Exposure::Stops(1.0);
    let alone: Vec<_> = [&outer, &inner]
        .map(|request| {
            for sample_index in 0..3 {
                renderer.render(&test.scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
            }
            read(&renderer, "")
        })
        .into();
    assert_ne!(alone[0].0.len(), alone[1].0.len());
    // Variables are of the view: another one that begins takes none away.
    let with_depth = FrameRequest { want_aovs: vec![Aov::Depth], ..outer.clone() };
    renderer.render_views(&test.scene, &[("mirror", &inner), ("", &with_depth)]).unwrap();
    let next = FrameRequest { sample_index: 1, ..with_depth };
    renderer.render_views(&test.scene, &[("mirror", &inner), ("", &next)]).unwrap();
    assert!(renderer.read_aov(Aov::Depth).is_ok(), "the mirror took the variables away");
    for sample_index in 0..3 {
        let [outer, inner] = [&outer, &inner].map(|request| FrameRequest { sample_index, ..request.clone() });
        renderer.render_views(&test.scene, &[("mirror", &inner), ("", &outer)]).unwrap();
    }
    assert!(read(&renderer, "") == alone[0], "the outer view is another picture beside the inner one");
    assert!(read(&renderer, "mirror") == alone[1], "the inner view is another picture beside the outer one");
    let twice = renderer.render_views(&test.scene, &[("a", &inner), ("a", &outer)]);
    assert!(matches!(twice, Err(RenderError::ViewTwice(name)) if name == "a"));
}

#[test]
fn what_cannot_be_read_is_told_by_kind() {
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let early = renderer.read_display().unwrap_err();
    assert!(matches!(&early, RenderError::NotRendered { view } if view.is_empty()), "{early}");
    let request = plain_request(&test.scene, (32, 24));
    let request = FrameRequest { sample_count: 2, averaging: Averaging::Display, ..request };
    let later = FrameRequest { sample_index: 1, ..request.clone() };
    let alone = renderer.render(&test.scene, &later).unwrap_err();
    assert!(matches!(alone, RenderError::SampleWithoutFirst), "{alone}");
    renderer.render(&test.scene, &request).unwrap();
    renderer.render(&test.scene, &later).unwrap();
    let other = renderer.rendered("mirror").err().unwrap();
    assert!(matches!(&other, RenderError::NotRendered { view } if view == "mirror"), "{other}");
    assert!(other.to_string().contains("`mirror`") && other.to_string().contains("render_views"), "{other}");
    let radiance = renderer.read_radiance().unwrap_err();
    assert!(matches!(radiance, RenderError::RadianceNotKept), "{radiance}");
    let motion = renderer.read_aov(Aov::Motion).unwrap_err();
    assert!(matches!(motion, RenderError::AovNotKept { aov: Aov::Motion }), "{motion}");
    assert!(motion.to_string().contains("`motion`") && motion.to_string().contains("want_aovs"), "{motion}");
}

#[test]
fn a_reflected_view_is_the_ray_casters_flipped() {
    const SIZE: (usize, usize) = (96, 72);
    for test in [scenes::rows_of_spheres(), scenes::sun()] {
        let truth = test.world.render(SIZE.0, SIZE.1, Options::default());
        let mut renderer = renderer();
        renderer.load(&test.scene).unwrap();
        for path in [Path::Deferred, Path::Forward] {
            let mut request = plain_request(&test.scene, (SIZE.0 as u32, SIZE.1 as u32));
            request.settings.render.path = path;
            // Left and right change places, and triangles turn around.
            request.camera.world_from_view *= Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
            renderer.render(&test.scene, &request).unwrap();
            let found = renderer.read_radiance().unwrap();
            let flipped: Vec<[f32; 3]> = (0..SIZE.0 * SIZE.1)
                .map(|at| {
                    let (x, y) = (at % SIZE.0, at / SIZE.0);
                    let from = (y * SIZE.0 + SIZE.0 - 1 - x) * 4;
                    [found[from], found[from + 1], found[from + 2]]
                })
                .collect();
            let inner = inner_pixels(&truth.object_id, SIZE);
            let pick = |pixels: &[[f32; 3]]| inner.iter().map(|at| pixels[*at]).collect::<Vec<_>>();
            let difference = linear_difference(&pick(&truth.radiance), &pick(&flipped), 0.01);
            let within = difference.share_within(0.01);
            assert!(difference.mean < 0.01 && within > 0.98, "{} {path:?}: {} {within}", test.name, difference.mean);
        }
    }
}

#[test]
fn a_plane_cuts_a_view_and_leaves_distances_right() {
    const SIZE: (u32, u32) = (96, 72);
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let perspective = plain_request(&test.scene, SIZE);
    let mut parallel = perspective.clone();
    parallel.camera.projection = Projection::Orthographic { height_m: 6.0, near_m: 0.01, far_m: 100.0 };
    let mut shot = |request: &FrameRequest| {
        let request = FrameRequest { want_aovs: vec![Aov::Depth, Aov::Position], ..request.clone() };
        renderer.render(&test.scene, &request).unwrap();
        let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
        (depth, floats(renderer.read_aov(Aov::Position).unwrap()), renderer.read_radiance().unwrap())
    };
    for request in [perspective, parallel] {
        let (depth, position, radiance) = shot(&request);
        let seen: Vec<Vec3> =
            position.chunks(3).map(Vec3::from_slice).filter(|position| position.is_finite()).collect();
        let middle = seen.iter().sum::<Vec3>() / seen.len() as f32;
        let ahead = -request.camera.world_from_view.z_axis.truncate();
        // Through the middle of what is seen: upright, slanted, and nearly along the view.
        for normal in [ahead, Vec3::new(0.3, 1.0, -0.2), Vec3::new(1.0, 0.0, -0.3), Vec3::new(-1.0, 0.2, -0.4)] {
            let normal = normal.normalize();
            let plane = normal.extend(-normal.dot(middle) + 0.003);
            let (cut_depth, cut_position, cut_radiance) =
                shot(&FrameRequest { clip_plane_world: Some(plane), ..request.clone() });
            let side = |at: usize, positions: &[f32]| plane.dot(Vec3::from_slice(&positions[3 * at..]).extend(1.0));
            let (mut kept, mut removed) = (0, 0);
            for at in 0..depth.len() {
                if cut_depth[at].is_finite() {
                    assert!(side(at, &cut_position) > -2e-3, "{normal}, pixel {at}: {}", side(at, &cut_position));
                }
                if !depth[at].is_finite() {
                    assert!(!cut_depth[at].is_finite(), "{normal}, pixel {at}");
                } else if side(at, &position) > 1e-3 {
                    let error = (cut_depth[at] / depth[at] - 1.0).abs();
                    assert!(error < 2e-4, "{normal}, pixel {at}: {} instead of {}", cut_depth[at], depth[at]);
                    let brightest = radiance[4 * at].abs().max(0.01);
                    assert!((cut_radiance[4 * at] - radiance[4 * at]).abs() < 0.01 * brightest, "{normal}, pixel {at}");
                    kept += 1;
                } else if side(at, &position) < -1e-3 {
                    assert!(cut_depth[at] > depth[at], "{normal}, pixel {at}");
                    removed += 1;
                }
            }
            assert!(kept > 10 && removed > 10 && kept + removed > 1000, "{normal}: {kept} {removed}");
        }
    }
}

/// An effect that adds what it made in the frame before, halved.
fn echo(renderer: &Renderer) -> Arc<WgslEffect> {
    let source = "//! effect echo
        //! reads: radiance, previous
        /// How much of the frame before stays, share
        // = 0.5 in 0..1
        @group(2) @binding(0) var<uniform> share: f32;
        @fragment fn fs_echo(@builtin(position) position: vec4f) -> @location(0) vec4f {
            let pixel = vec2i(position.xy);
            return vec4f(radiance_at(pixel).rgb + previous_at(pixel).rgb * share, 1.0);
        }";
    Arc::new(WgslEffect::new(renderer.gpu(), "echo.wgsl", source).unwrap())
}

#[test]
fn an_effect_finds_what_it_made_in_the_frame_before() {
    let test = scenes::one_light_on_one_plane();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let plain = FrameRequest { averaging: Averaging::Radiance, ..plain_request(&test.scene, (16, 16)) };
    renderer.render(&test.scene, &plain).unwrap();
    let light = renderer.read_radiance().unwrap()[4 * 136];
    assert!(light > 0.0);
    for path in [Path::Deferred, Path::Forward] {
        let effect = echo(&renderer);
        effect.set("echo.share", "0.25").unwrap();
        let request = FrameRequest { effects: vec![effect], ..plain.clone() };
        let request = request.with(|settings| settings.render.path = path);
        let mut shot = |request: &FrameRequest| {
            renderer.render(&test.scene, request).unwrap();
            renderer.read_radiance().unwrap()[4 * 136] / light
        };
        let live = FrameRequest { goes_on: true, ..request.clone() };
        let near = |found: f32, expected: f32| assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
        // A picture begins anew: where there is no frame before, this one's radiance stands for it.
        near(shot(&request), 1.25);
        near(shot(&request), 1.25);
        near(shot(&live), 1.3125);
        near(shot(&live), 1.328_125);
        near(shot(&request), 1.25);
    }
}

#[test]
fn what_a_view_keeps_survives_the_resize_of_another() {
    let test = scenes::one_light_on_one_plane();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let view = |size: (u32, u32), renderer: &Renderer| FrameRequest {
        averaging: Averaging::Radiance,
        goes_on: true,
        effects: vec![echo(renderer)],
        ..plain_request(&test.scene, size)
    };
    let (kept, small, large) = (view((16, 16), &renderer), view((12, 12), &renderer), view((24, 24), &renderer));
    let mut levels = Vec::new();
    for other in [&small, &small, &large, &small] {
        renderer.render_views(&test.scene, &[("other", other), ("", &kept)]).unwrap();
        let of_other = read(&renderer, "other").1;
        levels.push((renderer.read_radiance().unwrap()[4 * 136], of_other[of_other.len() / 2]));
    }
    // 1.5, 1.75, 1.875, 1.9375 times the light; the other one begins anew at every size.
    assert!(levels.windows(2).all(|pair| pair[1].0 > pair[0].0 * 1.02), "{levels:?}");
    assert!(levels[1].1 > levels[0].1 && levels[2].1 < levels[1].1 * 1.1 && levels[3].1 <= levels[0].1, "{levels:?}");
}

#[test]
fn a_frame_like_the_last_one_makes_and_uploads_nothing() {
    let test = scenes::many_points(200);
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let request = plain_request(&test.scene, (64, 48)).with(|settings| {
        settings.environment.source = Environment::Studio;
        settings.background.source = Background::Environment;
    });
    for averaging in [Averaging::Display, Averaging::Radiance] {
        let request = FrameRequest { averaging, ..request.clone() };
        renderer.render(&test.scene, &request).unwrap();
        let first = renderer.stats();
        assert!(first.bind_groups_made > 0 && first.pipelines_made > 0 && first.uploaded_bytes > 0, "{first:?}");
        for _ in 0..3 {
            renderer.render(&test.scene, &request).unwrap();
            let stats = renderer.stats();
            let made = (stats.bind_groups_made, stats.pipelines_made, stats.uploaded_bytes, stats.light_lists_made);
            assert_eq!(made, (0, 0, 0, 0), "{averaging:?}");
        }
    }
    // Another camera is another uniform, other lists and other instances.
    let mut moved = request.clone();
    moved.camera.world_from_view.w_axis.x += 0.25;
    renderer.render(&test.scene, &moved).unwrap();
    let stats = renderer.stats();
    assert!(stats.uploaded_bytes > 0 && stats.pipelines_made == 0, "{stats:?}");
}

/// A screen and a mirror beside each other, which face +Z; the screen shows what a camera sees that looks away.
fn stage(screen: &str, mirror: &str) -> Scene {
    let mut scene = scenes::one_light_on_one_plane().scene;
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    let world_from_view = Mat4::from_translation(20.0 * Vec3::Z) * Mat4::from_rotation_y(std::f32::consts::PI);
    let monitor = Monitor::new(MonitorCamera::Fixed { world_from_view, projection }, 32, 24);
    scene.images.push(Image::of_monitor(screen, monitor));
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Sampler::default() });
    let texture = TextureRef { texture: scene.textures.len() - 1, ..TextureRef::default() };
    let glowing = Material { emissive_texture: Some(texture), emissive_factor: Vec3::ONE, ..Material::default() };
    let smooth = Material { roughness_factor: 0.0, ..Material::default() };
    let rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    for (material, x_m) in [(glowing, -2.0), (smooth, 2.0)] {
        scene.materials.push(material);
        let square = Primitive { material: Some(scene.materials.len() - 1), ..primitives::plane(1.0) };
        scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
        let (mesh, translation) = (Some(scene.meshes.len() - 1), x_m * Vec3::X);
        let node = scene.add_node(None, Node { mesh, translation, rotation, ..Node::default() });
        if x_m > 0.0 {
            scene.mirrors.push(Mirror::new(mirror, node));
        }
    }
    scene.update_transforms();
    scene
}

#[test]
fn views_of_former_scenes_are_forgotten_and_those_out_of_sight_are_not() {
    let first = stage("screen", "mirror");
    let plain = plain_request(&first, (48, 32)).with(|settings| settings.taa.enabled = true);
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    let toward = View { world_from_view: Mat4::from_translation(10.0 * Vec3::Z), projection };
    let away = View { world_from_view: toward.world_from_view * Mat4::from_rotation_y(2.0), projection };
    let request = FrameRequest { camera: toward, goes_on: true, ..plain };
    let looking_away = FrameRequest { camera: away, ..request.clone() };
    let mut renderer = renderer();
    let mut kept = Vec::new();
    for turn in 0..50 {
        let scene = stage(&format!("screen {turn}"), &format!("mirror {turn}"));
        renderer.load(&scene).unwrap();
        for request in [&request, &looking_away, &request] {
            renderer.render(&scene, request).unwrap();
            // The picture, what the screen shows, and what is behind the mirror.
            assert_eq!(renderer.view_count(), 3, "stage {turn}");
        }
        assert_eq!(renderer.stats().captures, 2, "the camera sees both");
        kept.push((renderer.view_bytes(), renderer.pool_bytes(), renderer.scene_bytes()));
    }
    println!("bytes of views, of passes and of the scene: {:?}", kept[9]);
    let (views, passes, scene) = kept[9];
    let grew = |(of_views, of_passes, of_scene): &(u64, u64, u64)| {
        *of_views > views || *of_passes > passes || *of_scene > scene
    };
    assert!(views > 0 && !kept[9..].iter().any(grew), "{kept:?}");
    // Without them there is the picture alone.
    let mut plain = first;
    plain.images.clear();
    plain.textures.clear();
    plain.materials.iter_mut().for_each(|material| material.emissive_texture = None);
    plain.mirrors.clear();
    renderer.load(&plain).unwrap();
    renderer.render(&plain, &request).unwrap();
    assert_eq!(renderer.view_count(), 1);
}
