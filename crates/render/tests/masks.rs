//! Masks whose texels are smaller than pixels: hashed, as much of them stays as covers the pixels, in every pass alike.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, ids, plain_request, renderer};
use glam::{Vec2, Vec3};
use manypass::{Aov, Background, Environment, FrameRequest, Masks, Path, PixelSamples, Pose, Renderer};
use manypass_scene::material::{HeightMap, HeightMethod};
use manypass_scene::{
    AlphaMode, Image, ImageSource, Light, LightKind, Material, PixelFormat, Pixels, Projection, Sampler, Scene,
    ShadingModel, Texture, TextureRef, TextureTransform, primitives,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::f32::consts::TAU;
use std::sync::Arc;

const SIZE: (u32, u32) = (64, 64);

/// Of the texels of [`sieve`].
const SHARE: f32 = 0.25;

/// A sheet of 2 m at a height of 1 m, seen from above; of its texels, `tiles` times 32 a side, one of four is there.
fn sieve(tiles: f32, shading_model: ShadingModel) -> SceneBuilder {
    let material = Material { shading_model, ..grey(1.0) };
    sieve_from(Vec3::Y * 5.0, tiles, material)
}

/// The same of another material, seen from `eye`.
fn sieve_from(eye: Vec3, tiles: f32, material: Material) -> SceneBuilder {
    let is_there = |i: u32| i.is_multiple_of(2) && (i / 32).is_multiple_of(2);
    masked_sheet(eye, tiles, material, (32, |i| if is_there(i) { 255 } else { 0 }))
}

/// The same with a mask of so many texels a side, whose alpha is a function of their places in rows.
fn masked_sheet(eye: Vec3, tiles: f32, material: Material, (side, alpha): (u32, impl Fn(u32) -> u8)) -> SceneBuilder {
    let parallel = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 20.0 };
    let mut builder = SceneBuilder::new(eye, Vec3::ZERO, parallel);
    let data = (0..side * side).flat_map(|i| [255, 255, 255, alpha(i)]).collect();
    let pixels = Pixels { width: side, height: side, format: PixelFormat::Rgba8, data };
    builder.scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
    builder.scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    let transform = TextureTransform { scale: Vec2::splat(tiles), ..TextureTransform::default() };
    let mask = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        base_color_texture: Some(TextureRef { texture: 0, uv_set: 0, transform }),
        double_sided: true,
        ..material
    };
    builder.put(primitives::plane(2.0), mask, at(Vec3::Y));
    builder
}

fn request(scene: &Scene, masks: Masks) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| settings.transparency.masks = masks)
}

fn radiance_of(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_radiance().unwrap().chunks_exact(4).map(|pixel| pixel[0]).collect()
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

#[test]
fn masks_and_their_shadows_lie_where_matrices_and_second_uvs_say() {
    // Once by the first UVs as they are, once by a matrix, once by the second UVs: the same texels in all.
    let place = |uv: [f32; 2]| [3.0 * uv[0] + 0.25, 2.0 * uv[1] - 0.125];
    let transform = TextureTransform { offset: Vec2::new(0.25, -0.125), rotation_rad: 0.0, scale: Vec2::new(3.0, 2.0) };
    let scene_of = |uv_set: u32, transform: TextureTransform, is_placed: bool| {
        let mut builder = sieve_from(Vec3::new(0.0, 5.0, 3.0), 1.0, grey(0.8));
        let mesh = Arc::make_mut(builder.scene.meshes.last_mut().unwrap());
        let sheet = &mut mesh.primitives[0];
        let placed: Vec<[f32; 2]> = sheet.uv0.iter().map(|uv| place(*uv)).collect();
        match (uv_set, is_placed) {
            (0, true) => sheet.uv0 = placed,
            (1, _) => sheet.uv1 = placed,
            _ => (),
        }
        let texture = TextureRef { texture: 0, uv_set, transform };
        builder.scene.materials.last_mut().unwrap().base_color_texture = Some(texture);
        builder.put(primitives::plane(6.0), grey(0.5), at(Vec3::ZERO));
        let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
        builder.light(sun, Vec3::ZERO, Vec3::new(-0.4, -1.0, -0.2));
        builder.finish()
    };
    let mut renderer = renderer();
    let mut picture = |scene: &Scene| {
        renderer.unload();
        renderer.load(scene).unwrap();
        let request = request(scene, Masks::Cutoff).with(|settings| settings.shadows.enabled = true);
        radiance_of(&mut renderer, scene, &request)
    };
    let expected = picture(&scene_of(0, TextureTransform::default(), true));
    let raw = picture(&scene_of(0, TextureTransform::default(), false));
    let differing = |found: &[f32]| expected.iter().zip(found).filter(|(a, b)| (*a - *b).abs() > 0.02).count();
    assert!(differing(&raw) > 300, "{} pixels tell how texels lie", differing(&raw));
    for found in [picture(&scene_of(0, transform, false)), picture(&scene_of(1, TextureTransform::default(), false))] {
        assert!(differing(&found) < 20, "{} pixels differ", differing(&found));
    }
}

#[test]
fn as_much_of_a_distant_mask_stays_as_covers_its_pixels() {
    // Eight texels a pixel.
    let scene = sieve(16.0, ShadingModel::Unlit).finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let cut = radiance_of(&mut renderer, &scene, &request(&scene, Masks::Cutoff));
    assert!(cut.iter().all(|value| *value == 0.0), "nothing is left of it");
    let mut one = request(&scene, Masks::Hashed);
    let first = radiance_of(&mut renderer, &scene, &one);
    assert!(first.iter().all(|value| *value == 0.0 || *value > 0.99));
    // Of 4,096 pixels, whose standard deviation is 0.007.
    assert!((mean(&first) - SHARE).abs() < 0.03, "{}", mean(&first));
    one.sample_count = 64;
    let many = radiance_of(&mut renderer, &scene, &one);
    let farthest = many.iter().map(|value| (value - SHARE).abs()).fold(0.0, f32::max);
    // The samples are filtered less, so that alpha is no longer the same everywhere.
    assert!((mean(&many) - SHARE).abs() < 0.01 && farthest < 0.2, "{} {farthest}", mean(&many));
}

#[test]
fn distant_masks_of_stills_keep_their_coverage_by_default() {
    let scene = sieve(16.0, ShadingModel::Unlit).finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let of_default = manypass::Settings::default().transparency.masks;
    let mut still = request(&scene, of_default);
    // Of one sample there would be a pattern.
    assert_eq!(mean(&radiance_of(&mut renderer, &scene, &still)), 0.0);
    still.sample_count = 16;
    let kept = mean(&radiance_of(&mut renderer, &scene, &still));
    assert!((kept - SHARE).abs() < 0.03, "{kept} of {SHARE}");
}

#[test]
fn masks_that_are_near_are_cut_as_ever() {
    // Eight pixels a texel.
    let scene = sieve(0.25, ShadingModel::Unlit).finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let [cut, hashed] =
        [Masks::Cutoff, Masks::Hashed].map(|masks| radiance_of(&mut renderer, &scene, &request(&scene, masks)));
    assert!(mean(&cut) > 0.1 && cut == hashed);
}

#[test]
fn alpha_that_rises_slowly_is_cut_where_it_is_the_cutoff_at_any_distance() {
    // Eight texels a pixel, whose alpha rises along x.
    let material = Material { shading_model: ShadingModel::Unlit, ..grey(1.0) };
    let scene = masked_sheet(Vec3::Y * 5.0, 1.0, material, (512, |i| (i % 512 / 2) as u8)).finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for paths in [Path::Deferred, Path::Forward] {
        let of = |masks| {
            let request = request(&scene, masks).with(|settings| settings.render.path = paths);
            FrameRequest { sample_count: 16, ..request }
        };
        let [cut, hashed] = [Masks::Cutoff, Masks::Hashed].map(|masks| radiance_of(&mut renderer, &scene, &of(masks)));
        assert!((mean(&cut) - 0.5).abs() < 0.02, "{}", mean(&cut));
        let differs = cut.iter().zip(&hashed).filter(|(a, b)| (*a - *b).abs() > 0.01).count();
        // In the first column alpha is 0 to 3 of 255, and may be as unlike as that.
        assert!(differs <= SIZE.1 as usize, "{paths:?}: {differs} of 4,096 pixels");
    }
}

/// Alpha that says how many of four samples of a pixel are covered.
fn to_coverage(request: &FrameRequest) -> FrameRequest {
    request.with(|settings| (settings.render.path, settings.msaa.samples) = (Path::Forward, PixelSamples::Four))
}

#[test]
fn edges_of_near_masks_are_smooth_where_pixels_have_samples() {
    // Five pixels a texel or so, none of whose edges lie between pixels.
    let scene = sieve(0.41, ShadingModel::Unlit).finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let one = request(&scene, Masks::Cutoff);
    let cut = radiance_of(&mut renderer, &scene, &one);
    // Textures are filtered as those of one sample are.
    let truth = FrameRequest { sample_count: 64, ..one.clone() };
    let truth = radiance_of(&mut renderer, &scene, &truth);
    let error = |found: &[f32]| found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum::<f32>() / 4096.0;
    for masks in [Masks::Cutoff, Masks::Hashed] {
        let found = radiance_of(&mut renderer, &scene, &to_coverage(&request(&scene, masks)));
        println!(
            "{} {} {} of {}: {} {}",
            masks.name(),
            mean(&found),
            mean(&cut),
            mean(&truth),
            error(&found),
            error(&cut)
        );
        assert!((mean(&found) - mean(&truth)).abs() < 0.01, "{} {}", mean(&found), mean(&truth));
        assert!(error(&found) < 0.5 * error(&cut), "{} {}", error(&found), error(&cut));
    }
}

#[test]
fn alpha_says_how_many_samples_of_a_distant_mask_are_covered() {
    // Eight texels a pixel, of which a part is there of one in four.
    let mut builder = sieve(16.0, ShadingModel::Unlit);
    builder.scene.materials[0].base_color_factor.w = 0.6;
    let share = 0.6 * SHARE;
    let scene = builder.finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let cut = radiance_of(&mut renderer, &scene, &to_coverage(&request(&scene, Masks::Cutoff)));
    assert!(cut.iter().all(|value| *value == 0.0), "all of it is below the cutoff");
    let mut hashed = request(&scene, Masks::Hashed);
    let single = radiance_of(&mut renderer, &scene, &hashed);
    let found = radiance_of(&mut renderer, &scene, &to_coverage(&hashed));
    println!("{} {} of {share}", mean(&found), mean(&single));
    // One sample of four is covered in 0.6 of 4,096 pixels, whose standard deviation is 0.002.
    assert!(found.iter().all(|value| *value == 0.0 || (value - 0.25).abs() < 1e-3));
    assert!((mean(&found) - share).abs() < 0.01, "{}", mean(&found));
    assert!((mean(&single) - share).abs() < 0.03, "{}", mean(&single));
    // By chance again in every sample of a still.
    hashed.sample_count = 16;
    let many = radiance_of(&mut renderer, &scene, &to_coverage(&hashed));
    assert!((mean(&many) - share).abs() < 0.01, "{}", mean(&many));
}

/// Alpha is what says how many samples are covered, and what lies in them; what a picture holds is whether they are.
#[test]
fn what_alpha_covers_is_opaque() {
    for tiles in [0.41, 2.3, 16.0] {
        let scene = sieve(tiles, ShadingModel::Unlit).finish();
        let mut renderer = renderer();
        renderer.load(&scene).unwrap();
        let request = to_coverage(&request(&scene, Masks::Hashed));
        let request = request.with(|settings| settings.background.source = Background::Transparent);
        renderer.render(&scene, &request).unwrap();
        let radiance = renderer.read_radiance().unwrap();
        let partly = radiance.chunks_exact(4).filter(|texel| texel[3] > 0.0 && texel[3] < 1.0).count();
        assert!(partly > 500, "{partly} of 4,096 pixels are covered in part");
        for texel in radiance.chunks_exact(4) {
            assert!((texel[0] - texel[3]).abs() < 1e-3, "white of {} in a pixel covered by {}", texel[0], texel[3]);
        }
    }
}

#[test]
fn a_mask_whose_alpha_is_the_cutoff_is_there() {
    for (cutoff, alpha) in [(1.0, 1.0), (0.5, 0.5), (0.0, 0.0)] {
        let parallel = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 20.0 };
        let mut builder = SceneBuilder::new(Vec3::Y * 5.0, Vec3::ZERO, parallel);
        let mut even = Material { shading_model: ShadingModel::Unlit, ..grey(1.0) };
        even.alpha_mode = AlphaMode::Mask { cutoff };
        even.base_color_factor.w = alpha;
        builder.put(primitives::plane(3.0), even, at(Vec3::Y));
        let scene = builder.finish();
        let mut renderer = renderer();
        renderer.load(&scene).unwrap();
        let found = radiance_of(&mut renderer, &scene, &to_coverage(&request(&scene, Masks::Cutoff)));
        assert!(found.iter().all(|value| (value - 1.0).abs() < 1e-3), "{cutoff}");
    }
}

#[test]
fn every_pass_drops_the_same_fragments_of_a_hashed_mask() {
    let mut builder = sieve(5.0, ShadingModel::Standard);
    builder.light(Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() }, Vec3::ZERO, Vec3::NEG_Y);
    let scene = builder.finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = request(&scene, Masks::Hashed);
    request.want_aovs = vec![Aov::Depth, Aov::ObjectId, Aov::Motion];
    // The sheet stands still, and so does what is seen through it; but a camera that moved gives both a motion.
    let mut before = request.camera;
    before.world_from_view.w_axis.x += 0.25;
    request.previous = Some(Arc::new(Pose::capture(&scene, before)));
    let deferred = radiance_of(&mut renderer, &scene, &request);
    let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
    let objects = ids(renderer.read_aov(Aov::ObjectId).unwrap());
    let motion = floats(renderer.read_aov(Aov::Motion).unwrap());
    let is_there: Vec<bool> = depth.iter().map(|depth| depth.is_finite()).collect();
    let count = is_there.iter().filter(|there| **there).count();
    assert!((500..2500).contains(&count), "{count} of 4,096 pixels");
    assert!(is_there.iter().zip(&objects).all(|(there, id)| *there == (*id != 0)), "ids");
    let moved: Vec<bool> = motion.chunks_exact(2).map(|motion| motion[0].abs() > 1.0).collect();
    assert!(is_there == moved, "motion");
    request.want_aovs.clear();
    for path in [Path::Forward, Path::ForwardBatched, Path::Gouraud] {
        let found = radiance_of(&mut renderer, &scene, &request.with(|settings| settings.render.path = path));
        let differs = found.iter().zip(&deferred).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count();
        assert_eq!(differs, 0, "{path:?}");
    }
}

#[test]
fn every_pass_drops_the_same_fragments_of_a_hashed_mask_with_relief() {
    // Texels of 0.7 pixels, so that the hash has taken over in part, by how large they are on the triangle: UVs of what
    // is seen jump where one height hides another.
    let height = HeightMap {
        texture: TextureRef { texture: 1, uv_set: 0, transform: TextureTransform::default() },
        depth_m: 0.1,
        method: HeightMethod::Occlusion,
        // Drawn twice: into the G-buffer, and with light.
        self_shadow: true,
    };
    let material = Material { height: Some(height), ..grey(1.0) };
    let mut builder = sieve_from(Vec3::new(3.0, 4.0, 1.0), 1.4, material);
    let wave = |i: u32| (128.0 + 120.0 * ((i % 16) as f32 / 16.0 * TAU).sin()) as u8;
    let data = (0..16 * 16).flat_map(|i| [wave(i), 0, 0, 255]).collect();
    let pixels = Pixels { width: 16, height: 16, format: PixelFormat::Rgba8, data };
    builder.scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
    builder.scene.textures.push(Texture { image: 1, sampler: Sampler::default() });
    builder.light(Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() }, Vec3::ZERO, Vec3::NEG_Y);
    let scene = builder.finish();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = request(&scene, Masks::Hashed);
    request.settings.environment.source = Environment::Color([1.0; 3]);
    request.want_aovs = vec![Aov::Depth, Aov::ObjectId];
    let deferred = radiance_of(&mut renderer, &scene, &request);
    let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
    let objects = ids(renderer.read_aov(Aov::ObjectId).unwrap());
    let is_there: Vec<bool> = depth.iter().map(|depth| depth.is_finite()).collect();
    let count = is_there.iter().filter(|there| **there).count();
    assert!((200..2500).contains(&count), "{count} of 4,096 pixels");
    let differing = |found: &[bool]| found.iter().zip(&is_there).filter(|(a, b)| a != b).count();
    let of_ids: Vec<bool> = objects.iter().map(|id| *id != 0).collect();
    let lit = |found: &[f32]| found.iter().map(|value| *value > 0.0).collect::<Vec<bool>>();
    request.want_aovs.clear();
    let forward = radiance_of(&mut renderer, &scene, &request.with(|settings| settings.render.path = Path::Forward));
    let found = [of_ids, lit(&deferred), lit(&forward)].map(|found| differing(&found));
    assert_eq!(
        found, [0; 3],
        "pixels of ids, and lit ones of the deferred and the forward path, that depth knows otherwise"
    );
}

#[test]
fn a_distant_hashed_mask_keeps_its_share_of_light_from_what_lies_below() {
    let mut builder = sieve(128.0, ShadingModel::Standard);
    // Beside the sheet, which hides what lies straight below.
    builder.put(primitives::plane(20.0), grey(0.5), at(Vec3::NEG_Y * 4.0));
    let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
    builder.light(sun, Vec3::ZERO, Vec3::new(1.0, -1.0, 0.0));
    let mut scene = builder.finish();
    // Over the middle of the shadow.
    let camera = scene.nodes.iter().position(|node| node.camera.is_some()).unwrap();
    scene.node_mut(manypass_scene::NodeId(camera as u32)).translation = Vec3::new(5.0, 5.0, 0.0);
    scene.update_transforms();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut light = |masks, shadows| {
        let request = request(&scene, masks).with(|settings| settings.shadows.enabled = shadows);
        let found = radiance_of(&mut renderer, &scene, &request);
        // Inside of the shadow.
        let inner: Vec<f32> = (16..48).flat_map(|y| found[y * 64 + 16..y * 64 + 48].to_vec()).collect();
        mean(&inner)
    };
    let lit = light(Masks::Cutoff, false);
    let (cut, hashed) = (light(Masks::Cutoff, true) / lit, light(Masks::Hashed, true) / lit);
    // In turn, so that a map that is kept is that of its own masks.
    let again = light(Masks::Cutoff, true) / lit;
    assert!(cut > 0.99 && again == cut, "of what is cut nothing is left: {cut} {again}");
    assert!((hashed - (1.0 - SHARE)).abs() < 0.05, "{hashed}");
}
