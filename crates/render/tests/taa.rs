//! Anti-aliasing over time: against stills of 64 samples where nothing moves and where the camera does, and what it must
//! not leave behind what moves.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::flat::{
    bar, bars, begin, body_before_wall, difference, fence, flat, flat_scene, ghost, live, picture, squared, still,
};
use crate::common::renderer;
use crate::common::shadows::shared;
use glam::{Quat, Vec3};
use manypass::{FrameRequest, Path, Renderer};
use manypass_scene::{
    Image, ImageSource, Light, LightKind, Node, NodeId, PixelFormat, Pixels, Sampler, Scene, Skin, Texture, TextureRef,
    primitives,
};
use manypass_testkit::build::{at, grey};

#[test]
fn a_static_fence_converges_to_its_still_and_does_not_shimmer() {
    let scene = fence();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let request = live(&scene);
    let still = still(&mut renderer, &scene, &request);
    // Where something moves elsewhere, as the height of a ground that is not there, frames do not know that the fence
    // stands still.
    let of = |renderer: &mut Renderer, request: &FrameRequest, moves: bool| {
        renderer.cut();
        let moved = |frame: u16| FrameRequest { ground_height_m: moves.then(|| frame.into()), ..request.clone() };
        let frames: Vec<_> = (0..192).map(|frame| picture(renderer, &scene, &moved(frame))).collect();
        let settled = &frames[128..];
        let mean: Vec<f64> = (0..still.len())
            .map(|at| settled.iter().map(|frame| f64::from(frame[at])).sum::<f64>() / settled.len() as f64)
            .collect();
        let off = mean.iter().zip(&still).map(|(mean, still)| (mean - f64::from(*still)).abs()).sum::<f64>();
        let steps: Vec<_> = settled.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
        let shimmer = steps.iter().map(|(mean, _)| mean).sum::<f64>() / steps.len() as f64;
        let last = difference(&frames[191], &still).0;
        (off / mean.len() as f64, last, shimmer, steps.iter().map(|(_, most)| *most).max().unwrap())
    };
    let mut least = (f64::INFINITY, f64::INFINITY);
    for (moves, most_off, most_step) in [(false, 1.0, 12), (true, 1.15, 96)] {
        let (off, last, shimmer, most) = of(&mut renderer, &request, moves);
        println!("off by {off:.3}, the last frame by {last:.3}, from frame to frame {shimmer:.4}, at most {most}");
        assert!(
            off < most_off && last < most_off && shimmer < 0.25 && most < most_step,
            "{off} {last} {shimmer} {most}"
        );
        least = (least.0.min(last), least.1.min(shimmer));
    }
    // The same frames without those before them.
    let alone = request.with(|settings| (settings.taa.samples, settings.taa.feedback) = (1, 0.0));
    let (_, last, shimmer, _) = of(&mut renderer, &alone, false);
    println!("alone: {last:.3}, {shimmer:.4}");
    assert!(last > 4.0 * least.0 && shimmer > 40.0 * least.1, "{last} {shimmer}");
}

#[test]
fn a_body_leaves_no_ghost_behind() {
    let mut renderer = shared();
    // Near the wall depth tells nothing, and colours alone do.
    for distance_m in [1.5, 0.05] {
        let (scene, body) = body_before_wall(distance_m);
        let scenes: Vec<Scene> = (0..8)
            .map(|frame| {
                let mut moved = scene.clone();
                moved.node_mut(body).translation.x = -1.5 + frame as f32 / 3.0;
                moved.update_transforms();
                moved
            })
            .collect();
        let request = live(&scene);
        let dark = picture(&mut renderer, &scene, &request)[4 * (96 * 2 + 90) + 1];
        let found = ghost(&mut renderer, &scenes, &request);
        println!("{distance_m} m before the wall of {dark}: {found}");
        assert!(found <= dark + 3, "{distance_m} m: {found}, the wall is {dark}");
    }
}

/// A limb of stripes that a skin turns around its end, before a wall; in frames that follow each other.
fn limb() -> Vec<Scene> {
    let mut builder = flat_scene();
    builder.put(bar(9.0, 9.0), flat(0.02), at(Vec3::Z * -1.0));
    let mut scene = builder.finish();
    let joint = scene.add_node(None, at(Vec3::new(-0.8, -0.9, 0.0)));
    scene.skins.push(Skin { joints: vec![joint], inverse_bind_matrices: Vec::new() });
    for stripe in 0..12 {
        let mut primitive = bar(0.09, 0.4);
        primitive.positions.iter_mut().for_each(|position| position[0] += 0.25 + 0.15 * stripe as f32);
        primitive.bounds = manypass_scene::Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
        primitive.joints = vec![[0; 4]; primitive.positions.len()];
        primitive.weights = vec![[1.0, 0.0, 0.0, 0.0]; primitive.positions.len()];
        primitive.material = Some(scene.materials.len());
        scene.materials.push(flat(0.7));
        let mesh = Some(scene.meshes.len());
        let mesh_of = manypass_scene::Mesh { primitives: vec![primitive], ..Default::default() };
        scene.meshes.push(mesh_of.into());
        let node = scene.add_node(None, Node { mesh, ..Node::default() });
        scene.node_mut(node).skin = Some(0);
    }
    let turned = |frame: usize| {
        let mut scene = scene.clone();
        scene.node_mut(joint).rotation = Quat::from_rotation_z(0.1 * frame as f32);
        scene.update_transforms();
        scene
    };
    (0..10).map(turned).collect()
}

#[test]
fn the_limbs_of_a_skinned_figure_are_followed() {
    let scenes = limb();
    let mut renderer = shared();
    let request = live(&scenes[0]);
    begin(&mut renderer, &scenes[0]);
    let dark = picture(&mut renderer, &scenes[0], &request)[4 * (96 * 60 + 90) + 1];
    let found = ghost(&mut renderer, &scenes, &request);
    println!("behind the limb {found}, the wall is {dark}");
    assert!(found <= dark + 3, "behind the limb {found}, the wall is {dark}");
    // Who knows where stripes were has smooth edges of them.
    let last = scenes.last().unwrap();
    let still = still(&mut renderer, last, &request);
    let mut error = |request: &FrameRequest| {
        renderer.cut();
        let shown = scenes.iter().map(|scene| picture(&mut renderer, scene, request)).last().unwrap();
        squared(&shown, &still)
    };
    let (smooth, bare) = (error(&request), error(&request.with(|settings| settings.taa.enabled = false)));
    println!("squared error {smooth:.1}, without {bare:.1}");
    assert!(smooth < 0.7 * bare, "squared error {smooth}, without {bare}");
}

/// Frames of a wall before its light changes, so that all means are of many.
const FRAMES_BEFORE: usize = 32;
/// The light of a wall, of which its shadow takes away all but the second one.
const LUX: [f32; 2] = [2.4, 0.6];
/// How far before it the caster of its shadow stands.
const BEFORE_WALL_M: f32 = 6.0;

/// A wall of one grey, or with texels as fine as pixels, which a sun from the right lights beside a light without
/// shadows; and the caster of its shadow, half a metre wide, which stands behind the camera, as far to the right of its
/// shadow as before the wall.
fn lit_wall(is_textured: bool) -> (Scene, NodeId) {
    let mut builder = flat_scene();
    let mut wall = grey(0.6);
    if is_textured {
        const SIDE: u32 = 256;
        // Greys from 0.35 to 0.9, in no order.
        let texels = (0..SIDE * SIDE).flat_map(|texel| {
            let grey = 160 + (texel.wrapping_mul(0x9e37_79b9) >> 16) as u8 % 86;
            [grey, grey, grey, 255]
        });
        let pixels = Pixels { width: SIDE, height: SIDE, format: PixelFormat::Rgba8, data: texels.collect() };
        builder.scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
        builder.scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
        wall.base_color_texture = Some(TextureRef { texture: 0, uv_set: 0, transform: Default::default() });
    }
    let upright = Node { rotation: Quat::from_rotation_x(std::f32::consts::FRAC_PI_2), ..Node::default() };
    builder.put(primitives::plane(9.0), wall, upright);
    let caster = builder.put(bar(0.5, 9.0), grey(0.5), at(Vec3::new(-6.0, 0.0, BEFORE_WALL_M)));
    let sun = Light { kind: LightKind::Directional, intensity: LUX[0], ..Light::default() };
    builder.light(sun.clone(), Vec3::ZERO, Vec3::new(-1.0, 0.0, -1.0));
    builder.light(Light { intensity: LUX[1], casts_shadows: false, ..sun }, Vec3::ZERO, Vec3::new(-1.0, 0.0, -1.0));
    (builder.finish(), caster)
}

/// The next of frames of it.
fn live_wall(scene: &Scene) -> FrameRequest {
    live(scene).with(|settings| settings.shadows.enabled = true)
}

/// Of each column, the mean of a picture, of 255.
fn columns(picture: &[u8]) -> Vec<f64> {
    let mean = |column: usize| (0..64).map(|row| f64::from(picture[4 * (96 * row + column) + 1])).sum::<f64>() / 64.0;
    (0..96).map(mean).collect()
}

/// How many columns a shadow between two edges, in pixels, is longer than it should be behind it, and how many are
/// missing at its front: those beyond what the frame alone shows, by a fifth of the contrast.
fn trail(shown: &[u8], alone: &[u8], lit: &[u8], [behind, front]: [f32; 2]) -> (usize, usize) {
    let [shown, alone, lit] = [shown, alone, lit].map(columns);
    let dark = alone.iter().copied().fold(f64::INFINITY, f64::min);
    let share = |of: &[f64], column: usize| (lit[column] - of[column]) / (lit[column] - dark).max(1.0);
    let off = |column: usize| share(&shown, column) - share(&alone, column);
    let middle = ((0.5 * (behind + front)).max(0.0) as usize).min(96);
    let longer = (0..middle).filter(|column| off(*column) > 0.2).count();
    (longer, (middle..96).filter(|column| off(*column) < -0.2).count())
}

#[test]
fn a_shadow_that_moves_over_a_still_floor_leaves_no_trail() {
    let mut renderer = shared();
    for (is_textured, speed_px) in [(false, 2.0), (false, 8.0), (true, 2.0), (true, 8.0)] {
        let (scene, caster) = lit_wall(is_textured);
        let request = live_wall(&scene);
        begin(&mut renderer, &scene);
        let alone = request.with(|settings| settings.taa.enabled = false);
        let lit = (0..FRAMES_BEFORE).map(|_| picture(&mut renderer, &scene, &request)).last().unwrap();
        let (mut worst, mut in_shadow) = ((0, 0), 0);
        for frame in 0..(96.0 / speed_px) as usize {
            let front_px = speed_px * frame as f32;
            let mut moved = scene.clone();
            // The picture is 4 m wide, and the middle of the shadow a quarter of a metre behind its front.
            moved.node_mut(caster).translation.x = front_px / 24.0 - 2.0 - 0.25 + BEFORE_WALL_M;
            moved.update_transforms();
            let shown = picture(&mut renderer, &moved, &request);
            let bare = picture(&mut renderer, &moved, &alone);
            let (longer, missing) = trail(&shown, &bare, &lit, [front_px - 12.0, front_px]);
            worst = (worst.0.max(longer), worst.1.max(missing));
            let (bare, lit) = (columns(&bare), columns(&lit));
            in_shadow += bare.iter().zip(&lit).filter(|(bare, lit)| **bare < 0.7 * **lit).count();
        }
        println!("textured: {is_textured}, {speed_px} px a frame: {worst:?} columns, {in_shadow} in shadow");
        assert!(in_shadow > 60, "the test looks at {in_shadow} columns");
        assert!(worst.0 <= 3 && worst.1 <= 3, "textured: {is_textured}, {speed_px} px a frame: {worst:?} columns");
    }
}

#[test]
fn a_lamp_that_changes_is_seen_at_once() {
    let mut renderer = shared();
    for is_textured in [false, true] {
        let (scene, _) = lit_wall(is_textured);
        let request = live_wall(&scene);
        begin(&mut renderer, &scene);
        for _ in 0..FRAMES_BEFORE {
            renderer.render(&scene, &request).unwrap();
        }
        let mean = |picture: &[u8]| columns(picture).iter().sum::<f64>() / 96.0;
        let was = mean(&renderer.read_display().unwrap());
        let mut dimmed = scene.clone();
        dimmed.lights[0].intensity *= 0.2;
        let shown = mean(&picture(&mut renderer, &dimmed, &request));
        let alone = mean(&picture(&mut renderer, &dimmed, &request.with(|settings| settings.taa.enabled = false)));
        println!("textured: {is_textured}: {was:.1}, then {shown:.1}; the frame alone {alone:.1}");
        assert!(was - alone > 40.0, "the lamp does not change: {was} and {alone}");
        assert!((shown - alone).abs() < 0.1 * (was - alone), "{shown} and not {alone} after {was}");
    }
}

#[test]
fn a_camera_that_pans_keeps_edges_smooth() {
    // Of two pixels and more: what some frames miss is not kept where it moves.
    let scene = bars(0.08);
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let mut error = |is_on: bool| {
        renderer.cut();
        let mut request = live(&scene).with(|settings| settings.taa.enabled = is_on);
        for frame in 0..12 {
            request.camera.world_from_view.w_axis.x = 0.05 * frame as f32;
            request.camera.world_from_view.w_axis.y = -0.02 * frame as f32;
            renderer.render(&scene, &request).unwrap();
        }
        let shown = renderer.read_display().unwrap();
        squared(&shown, &still(&mut renderer, &scene, &request))
    };
    let (smooth, bare) = (error(true), error(false));
    println!("squared error {smooth:.1}, without {bare:.1}");
    assert!(smooth < 0.7 * bare, "squared error {smooth}, without {bare}");
}

#[test]
fn pictures_that_begin_anew_are_as_if_alone() {
    let scene = fence();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = live(&scene);
    let bare = picture(&mut renderer, &scene, &request.with(|settings| settings.taa.enabled = false));
    let near_bare = |shown: &[u8]| assert!(difference(shown, &bare).1 <= 1, "{:?}", difference(shown, &bare));
    near_bare(&picture(&mut renderer, &scene, &request));
    let second = picture(&mut renderer, &scene, &request);
    assert!(difference(&second, &bare).0 > 0.5, "the second frame shows the first one, too");
    // A cut, a frame that follows none, and another size and back.
    renderer.cut();
    near_bare(&picture(&mut renderer, &scene, &request));
    near_bare(&picture(&mut renderer, &scene, &FrameRequest { goes_on: false, ..request.clone() }));
    picture(&mut renderer, &scene, &request);
    picture(&mut renderer, &scene, &FrameRequest { width: 50, height: 20, ..request.clone() });
    renderer.cut();
    near_bare(&picture(&mut renderer, &scene, &request));
    // Looking at its passes in between changes nothing.
    let mut frames = |looks: bool| {
        renderer.cut();
        let mut shown = Vec::new();
        for _ in 0..3 {
            shown = picture(&mut renderer, &scene, &request);
            if looks {
                renderer.passes(&scene, &request).unwrap();
                renderer.pass_times(&scene, &request).unwrap();
            }
        }
        shown
    };
    assert_eq!(frames(false), frames(true));
}

#[test]
fn any_size_goes() {
    let scene = fence();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    for (width, height) in [(1, 1), (1, 4096), (300, 2)] {
        for scale in [1.0, 0.5] {
            let mut request = FrameRequest { width, height, ..live(&scene) };
            request.settings.render.scale = scale;
            renderer.cut();
            for _ in 0..3 {
                let shown = picture(&mut renderer, &scene, &request);
                assert_eq!(shown.len(), (4 * width * height) as usize);
            }
        }
    }
}

#[test]
fn it_is_there_where_frames_follow_each_other_alone() {
    let scene = fence();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let mut passes = |request: &FrameRequest| -> Vec<String> {
        let plan = renderer.plan(&scene, request).unwrap();
        let names = plan.passes.iter().map(|pass| pass.name.to_string());
        names.filter(|name| name.starts_with("taa") || name == "motion").collect()
    };
    let live = live(&scene);
    assert_eq!(passes(&live), ["motion", "taa.surface", "taa"]);
    let alone = FrameRequest { goes_on: false, ..live.clone() };
    assert_eq!(passes(&alone), ["motion", "taa.surface", "taa"]);
    let none: [String; 0] = [];
    assert_eq!(passes(&FrameRequest { sample_count: 4, ..alone.clone() }), none);
    // The frames that refine a live picture.
    assert_eq!(passes(&FrameRequest { sample_count: 4, ..live.clone() }), ["motion", "taa.surface", "taa"]);
    assert_eq!(passes(&alone.with(|settings| settings.effects.enabled = false)), none);
    let forward = live.with(|settings| settings.render.path = Path::Forward);
    let error = renderer.plan(&scene, &forward).unwrap_err().to_string();
    assert!(error.contains("taa.enabled=true") && error.contains("render.path=deferred"), "{error}");
}
