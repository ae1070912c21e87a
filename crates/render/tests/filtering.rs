//! Textures of surfaces seen at a slant, and averaged over samples: as sharp as the picture can show, and no sharper.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::{Aov, Averaging, Gpu, Renderer};
use manypass_scene::material::{Clearcoat, TexturedFactor};
use manypass_scene::{
    Camera, Image, ImageSource, Material, Mesh, Node, PixelFormat, Pixels, Projection, Sampler, Scene, ShadingModel,
    Texture, TextureRef, TextureTransform, Wrap, primitives,
};
use manypass_testkit::ktx2::solid_block;
use std::sync::Arc;

const SIZE: (u32, u32) = (96, 64);

fn image(side: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let data = (0..side * side).flat_map(|i| texel(i % side, i / side)).collect();
    let pixels = Pixels { width: side, height: side, format: PixelFormat::Rgba8, data };
    Image { name: "made".into(), source: ImageSource::Pixels(Arc::new(pixels)) }
}

/// A floor of 40 m by 40 m with light and dark stripes of 12.5 cm that run away from the camera, which stands half a
/// metre above it. Neither light nor environment: the floor is unlit.
fn striped_floor() -> Scene {
    let mut scene = Scene::default();
    let stripe = |x: u32, _| if x % 8 < 4 { [230, 230, 230, 255] } else { [20, 20, 20, 255] };
    scene.images.push(image(64, stripe));
    scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    let transform = TextureTransform { scale: glam::Vec2::splat(20.0), ..TextureTransform::default() };
    scene.materials.push(Material {
        base_color_texture: Some(TextureRef { texture: 0, uv_set: 0, transform }),
        shading_model: ShadingModel::Unlit,
        ..Material::default()
    });
    let mut floor = primitives::plane(40.0);
    floor.material = Some(0);
    scene.meshes.push(Mesh { primitives: vec![floor], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    let projection = Projection::Perspective { fov_y_rad: 45f32.to_radians(), near_m: 0.05, far_m: None };
    scene.cameras.push(Camera { name: "eye".into(), projection, aspect: None });
    scene.add_node(
        None,
        Node {
            camera: Some(0),
            // Off the middle of a stripe, and turned a little, so that no stripe lies along a column of pixels.
            translation: Vec3::new(0.03, 0.5, 18.0),
            rotation: Quat::from_rotation_y(0.02) * Quat::from_rotation_x(-0.15),
            ..Node::default()
        },
    );
    scene.update_transforms();
    scene
}

/// Red of every pixel, linear, of `samples` frames.
fn picture(renderer: &mut Renderer, scene: &Scene, size: (u32, u32), samples: u32) -> Vec<f32> {
    let mut request = plain_request(scene, size);
    request.sample_count = samples;
    request.averaging = Averaging::Radiance;
    for sample in 0..samples {
        request.sample_index = sample;
        renderer.render(scene, &request).unwrap();
    }
    renderer.read_radiance().unwrap().chunks_exact(4).map(|pixel| pixel[0]).collect()
}

/// What the floor looks like through the squares of the pixels: 24 by 24 rays each; rows above the horizon are dark.
fn true_picture(scene: &Scene) -> Vec<f32> {
    let (_, world_from_view, projection) = scene.placed_cameras()[0];
    let Projection::Perspective { fov_y_rad, .. } = projection else { panic!("the scene's camera has perspective") };
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let half_height = (0.5 * fov_y_rad).tan();
    let linear = |byte: f32| ((byte / 255.0 + 0.055) / 1.055).powf(2.4);
    let (light, dark) = (linear(230.0), linear(20.0));
    const SIDE: usize = 24;
    let at = |x: f32, y: f32| {
        let ndc = Vec3::new(2.0 * x / width as f32 - 1.0, 1.0 - 2.0 * y / height as f32, 0.0);
        let plane = Vec3::new(ndc.x * half_height * width as f32 / height as f32, ndc.y * half_height, -1.0);
        let direction = world_from_view.transform_vector3(plane);
        let eye = world_from_view.w_axis.truncate();
        let hit = eye - direction * (eye.y / direction.y);
        if direction.y >= 0.0 || hit.x.abs() > 20.0 || hit.z.abs() > 20.0 {
            0.0
        } else if ((hit.x + 20.0) * 8.0).rem_euclid(2.0) < 1.0 {
            light
        } else {
            dark
        }
    };
    let of_pixel = |x: usize, y: usize| {
        let rays = (0..SIDE * SIDE).map(|i| {
            let part = |i: usize| (i as f32 + 0.5) / SIDE as f32;
            at(x as f32 + part(i % SIDE), y as f32 + part(i / SIDE))
        });
        rays.sum::<f32>() / (SIDE * SIDE) as f32
    };
    (0..width * height).map(|i| of_pixel(i % width, i / width)).collect()
}

/// The mean difference of neighbours.
fn contrast(row: &[f32]) -> f32 {
    row.windows(2).map(|pair| (pair[0] - pair[1]).abs()).sum::<f32>() / (row.len() - 1) as f32
}

#[test]
fn floors_seen_at_a_slant_are_as_sharp_as_the_picture_can_show() {
    let scene = striped_floor();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let best = true_picture(&scene);
    let (one, many) = (picture(&mut renderer, &scene, SIZE, 1), picture(&mut renderer, &scene, SIZE, 16));
    // The floor at distances of 4 to 6 m, where a pixel is a third of a stripe wide and ten times as long.
    for row in [26, 28, 30] {
        let pixels = row * SIZE.0 as usize..(row + 1) * SIZE.0 as usize;
        let [best_here, one, many] = [&best, &one, &many].map(|picture| contrast(&picture[pixels.clone()]));
        println!("row {row}: contrast {best_here:.3}, of one sample {one:.3}, of sixteen {many:.3}");
        assert!(best_here > 0.1, "the test cannot fail");
        assert!(many > 0.8 * best_here && many < 1.2 * best_here, "row {row}: {many} for {best_here}");
        // A single sample needs the adapter's help.
        if renderer.gpu().capabilities.anisotropy {
            assert!(one > 0.4 * best_here && one < 1.2 * best_here, "row {row}: {one} for {best_here}");
        }
    }
    let lower_half = one.len() / 2..one.len();
    for (name, samples) in [("one sample", &one), ("sixteen samples", &many)] {
        let mean = |values: &[f32]| values[lower_half.clone()].iter().sum::<f32>() / lower_half.len() as f32;
        let (found, expected) = (mean(samples), mean(&best));
        assert!((found - expected).abs() < 0.01, "{name}: the mean is {found} for {expected}");
    }
}

#[test]
fn variables_do_not_depend_on_the_number_of_samples() {
    let scene = striped_floor();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut base_color_of = |sample_count: u32| {
        let mut request = plain_request(&scene, SIZE);
        request.want_aovs = vec![Aov::BaseColor];
        request.sample_count = sample_count;
        renderer.render(&scene, &request).unwrap();
        floats(renderer.read_aov(Aov::BaseColor).unwrap())
    };
    assert!(base_color_of(1) == base_color_of(16));
}

/// A square of 1 m seen from above with parallel rays, which fills the picture.
fn square(material: Material) -> Scene {
    let mut scene = Scene::default();
    let mut square = primitives::plane(1.0);
    square.material = Some(0);
    scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
    scene.materials.push(material);
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    let projection = Projection::Orthographic { height_m: 1.0, near_m: 0.1, far_m: 10.0 };
    scene.cameras.push(Camera { name: "eye".into(), projection, aspect: None });
    let rotation = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    scene.add_node(None, Node { camera: Some(0), translation: Vec3::Y, rotation, ..Node::default() });
    scene.update_transforms();
    scene
}

/// A use of the first texture.
fn first_texture() -> Option<TextureRef> {
    Some(TextureRef { texture: 0, uv_set: 0, transform: TextureTransform::default() })
}

#[test]
fn without_mips_smaller_textures_are_filtered_as_the_sampler_says() {
    let unlit =
        Material { shading_model: ShadingModel::Unlit, base_color_texture: first_texture(), ..Material::default() };
    let mut scene = square(unlit);
    // Two texels a pixel, whose middle is the corner of four: two white, two black.
    scene.images.push(image(64, |x, y| if (x + y) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }));
    let mut renderer = renderer();
    for (mag_linear, min_linear) in [(false, true), (true, false), (true, true), (false, false)] {
        let sampler = Sampler { mag_linear, min_linear, mip_linear: None, ..Sampler::default() };
        scene.textures = vec![Texture { image: 0, sampler }];
        renderer.load(&scene).unwrap();
        let values = picture(&mut renderer, &scene, (32, 32), 1);
        let is_gray = |value: &f32| (value - 0.5).abs() < 0.02;
        let gray = values.iter().filter(|value| is_gray(value)).count();
        let expected = if min_linear { values.len() } else { 0 };
        assert_eq!(gray, expected, "magnified linearly: {mag_linear}, minified linearly: {min_linear}");
    }
}

#[test]
fn a_texture_that_cannot_be_decoded_is_as_if_the_material_had_none() {
    let mut renderer = renderer();
    let mut variables_of = |material: Material, warns: bool| {
        let mut scene = square(material);
        scene
            .images
            .push(Image { name: "broken".into(), source: ImageSource::Encoded(b"no picture".as_slice().into()) });
        scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
        renderer.load(&scene).unwrap();
        assert_eq!(renderer.warnings().iter().any(|warning| warning.contains("`broken`")), warns);
        let mut request = plain_request(&scene, (8, 8));
        let variables = [Aov::BaseColor, Aov::Normal, Aov::Roughness, Aov::Metallic, Aov::Occlusion, Aov::Emission];
        request.want_aovs = variables.to_vec();
        renderer.render(&scene, &request).unwrap();
        variables.map(|aov| floats(renderer.read_aov(aov).unwrap()))
    };
    let plain = Material {
        base_color_factor: glam::Vec4::new(0.5, 0.25, 0.125, 1.0),
        metallic_factor: 0.5,
        roughness_factor: 0.25,
        emissive_factor: Vec3::new(0.5, 0.0, 2.0),
        ..Material::default()
    };
    let broken = Material {
        base_color_texture: first_texture(),
        metallic_roughness_texture: first_texture(),
        normal_texture: first_texture(),
        occlusion_texture: first_texture(),
        emissive_texture: first_texture(),
        ..plain.clone()
    };
    let mut expected = variables_of(plain, false);
    assert!(expected[1][1] > 0.9999, "a flat square");
    // Emission alone would shine all over, which its texture hinders.
    expected[5].fill(0.0);
    assert!(variables_of(broken, true) == expected);
}

#[test]
fn infinite_emission_is_black_where_its_texture_is() {
    let emissive_factor = Vec3::new(f32::INFINITY, f32::MAX, f32::NAN);
    let mut scene = square(Material { emissive_factor, emissive_texture: first_texture(), ..Material::default() });
    scene.images.push(image(4, |_, _| [0, 0, 0, 255]));
    scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = plain_request(&scene, (8, 8));
    request.want_aovs = vec![Aov::Emission];
    renderer.render(&scene, &request).unwrap();
    assert!(floats(renderer.read_aov(Aov::Emission).unwrap()).iter().all(|value| *value == 0.0));
    assert!(renderer.read_radiance().unwrap().chunks_exact(4).all(|pixel| pixel == [0.0, 0.0, 0.0, 1.0]));
}

/// A plane that fills the picture, with a picture of Basis Universal: two colours side by side.
fn compressed_plane() -> Scene {
    let [left, right] = [[200, 40, 60, 255], [20, 90, 230, 255]].map(solid_block);
    let level = |blocks: usize| [[left].repeat(blocks), [right].repeat(blocks)].concat().repeat(2 * blocks).concat();
    let levels = [level(2), level(1), left.to_vec(), left.to_vec(), left.to_vec()];
    let levels: Vec<&[u8]> = levels.iter().map(Vec::as_slice).collect();
    let bytes = manypass_testkit::ktx2::picture(0, [16, 16], 0, &levels);
    let unlit =
        Material { shading_model: ShadingModel::Unlit, base_color_texture: first_texture(), ..Material::default() };
    let mut scene = square(unlit);
    scene.images.push(Image { name: "basis".into(), source: ImageSource::Encoded(bytes.into()) });
    scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    scene
}

#[test]
fn textures_that_stay_compressed_look_the_same_in_a_quarter_of_the_memory() {
    let scene = compressed_plane();
    let of = |compressed: bool, max_px: u32| {
        let mut gpu = Gpu::headless(None).unwrap();
        if gpu.adapter.device_type == "Software" {
            assert_eq!(gpu.capabilities.block_format, None, "a software adapter unpacks blocks for every texel");
        }
        let blocks = manypass::gpu::block_format(gpu.device.features());
        if compressed && blocks.is_none() {
            return None;
        }
        gpu.capabilities.block_format = blocks.filter(|_| compressed);
        let mut renderer = Renderer::new(gpu).unwrap();
        renderer.limit_textures(max_px);
        renderer.load(&scene).unwrap();
        let bytes = renderer.scene_bytes();
        let picture = picture(&mut renderer, &scene, (64, 64), 1);
        Some((bytes, picture))
    };
    let plain = of(false, 0).unwrap();
    let Some(compressed) = of(true, 0) else {
        manypass_testkit::needs::skip("the adapter has no compressed textures");
        return;
    };
    // 16 blocks, 4, 1, 1 and 1; against 256 + 64 + 16 + 4 + 1 texels.
    assert_eq!(plain.0 - compressed.0, 341 * 4 - 23 * 16);
    let worst = compressed.1.iter().zip(&plain.1).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 0.01, "{worst}");
    assert!(plain.1.iter().any(|red| *red > 0.5) && plain.1.iter().any(|red| *red < 0.05));
    // The levels that are wanted stay compressed as long as the largest of them is whole blocks.
    for (max_px, bytes) in [(8, 7 * 16), (6, 3 * 16), (2, 5 * 4)] {
        let smaller = of(true, max_px).unwrap();
        assert_eq!(plain.0 - smaller.0, 341 * 4 - bytes, "{max_px}");
    }
}

/// A plane with a clear coat whose weight and roughness come from textures of the same plane, by their indices.
fn lacquered(scene: &mut Scene, weight: usize, roughness: usize) {
    let map = |texture| {
        let texture = TextureRef { texture, uv_set: 0, transform: TextureTransform::default() };
        TexturedFactor { factor: 1.0, texture: Some(texture) }
    };
    scene.materials[0] = Material {
        name: "lacquer".into(),
        clearcoat: Some(Clearcoat { weight: map(weight), roughness: map(roughness), ..Clearcoat::default() }),
        ..Material::default()
    };
}

#[test]
fn layers_that_ask_for_different_samplers_are_named() {
    let mut scene = compressed_plane();
    scene.images.push(image(4, |_, _| [255; 4]));
    scene.textures.push(Texture { image: 1, sampler: Sampler::default() });
    scene.textures.push(Texture { image: 1, sampler: Sampler { wrap_u: Wrap::ClampToEdge, ..Sampler::default() } });
    let mut renderer = renderer();
    for (texture, is_named) in [(1, false), (2, true)] {
        lacquered(&mut scene, 1, texture);
        renderer.load(&scene).unwrap();
        let warnings = renderer.warnings();
        let names = |warning: &String| warning.contains("`lacquer`") && warning.contains("different samplers");
        assert_eq!(warnings.iter().any(names), is_named, "{warnings:?}");
        renderer.unload();
    }
}

#[test]
fn maps_of_layers_that_are_made_smaller_to_share_a_texture_are_named() {
    let mut scene = compressed_plane();
    // A wide one and a high one would be a texture of many more texels than both have.
    for (name, width, height) in [("small", 4, 4), ("wide", 8192, 1), ("high", 1, 2048)] {
        let data = vec![255; 4 * (width * height) as usize];
        let pixels = Pixels { width, height, format: PixelFormat::Rgba8, data };
        scene.images.push(Image { name: name.into(), source: ImageSource::Pixels(pixels.into()) });
        scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Sampler::default() });
    }
    let mut renderer = renderer();
    let named = "material 0 `lacquer`: its layers' maps of data are one texture of 4096x1024; made smaller: \
                 image 3 `high` (1x2048), image 2 `wide` (8192x1)";
    for (maps, expected) in [([1, 2], vec![]), ([3, 2], vec![named])] {
        lacquered(&mut scene, maps[0], maps[1]);
        renderer.load(&scene).unwrap();
        assert_eq!(renderer.warnings(), expected);
        renderer.unload();
    }
}

#[test]
fn images_larger_than_the_adapter_takes_are_halved_and_named() {
    let unlit =
        Material { shading_model: ShadingModel::Unlit, base_color_texture: first_texture(), ..Material::default() };
    let mut scene = square(unlit);
    // Columns of black and white, whose means are grey: linear ones, because colours are.
    let texel = |x: u32, _| if x.is_multiple_of(2) { [0, 0, 0, 255] } else { [255; 4] };
    scene.images.push(image(128, texel));
    scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    let of = |limit: u32, size: u32| {
        let mut gpu = Gpu::headless(None).unwrap();
        gpu.capabilities.max_texture_size = limit;
        let mut renderer = Renderer::new(gpu).unwrap();
        renderer.load(&scene).unwrap();
        let bytes = renderer.scene_bytes();
        (renderer.warnings(), bytes, picture(&mut renderer, &scene, (size, size), 1))
    };
    let (warnings, whole_bytes, whole) = of(128, 128);
    assert_eq!(warnings, [""; 0]);
    assert!(whole.iter().any(|red| *red > 0.9) && whole.iter().any(|red| *red < 0.1));
    for (limit, side) in [(127, 64), (64, 64), (63, 32)] {
        let (warnings, bytes, halved) = of(limit, 48);
        let expected = format!("image 0 `made`: 128x128 is larger than the adapter's {limit} texels a side; halved");
        assert_eq!(warnings, [expected]);
        // All mips.
        let texels = |side: u64| (side * side * 4 - 1) / 3;
        assert_eq!(whole_bytes - bytes, 4 * (texels(128) - texels(side)));
        assert!(halved.iter().all(|red| (red - 0.5).abs() < 0.01), "{limit}");
    }
}

#[test]
fn textures_are_halved_until_they_are_as_small_as_somebody_wants() {
    let unlit =
        Material { shading_model: ShadingModel::Unlit, base_color_texture: first_texture(), ..Material::default() };
    let mut scene = square(unlit);
    // Columns of black and white, whose mean is grey in linear light: 188 of 255 in sRGB.
    let texel = |x: u32, _| if x.is_multiple_of(2) { [0, 0, 0, 255] } else { [255; 4] };
    scene.images.push(image(128, texel));
    scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let whole_bytes = renderer.scene_bytes();
    let whole = picture(&mut renderer, &scene, (128, 128), 1);
    assert!(whole.iter().any(|red| *red > 0.9) && whole.iter().any(|red| *red < 0.1));
    let texels = |side: u64| (side * side * 4 - 1) / 3;
    // It holds where a model is loaded, and is no warning.
    for (max_px, side) in [(64, 64), (127, 64), (63, 32), (1, 1), (128, 128), (65_536, 128), (0, 128)] {
        renderer.limit_textures(max_px);
        renderer.load(&scene).unwrap();
        assert_eq!(whole_bytes - renderer.scene_bytes(), 4 * (texels(128) - texels(side)), "{max_px}");
        assert_eq!(renderer.warnings(), [""; 0]);
    }
    // And where a frame brings another number; those after it, too.
    for (max_px, side) in [(16, 16), (0, 128)] {
        let request = plain_request(&scene, (128, 128)).with(|settings| settings.textures.max_px = max_px);
        renderer.render(&scene, &request).unwrap();
        assert_eq!(whole_bytes - renderer.scene_bytes(), 4 * (texels(128) - texels(side)), "{max_px}");
        let red: Vec<f32> = renderer.read_radiance().unwrap().chunks_exact(4).map(|pixel| pixel[0]).collect();
        assert_eq!(red.iter().all(|red| (red - 0.5).abs() < 0.01), side == 16, "{max_px}");
        renderer.render(&scene, &request).unwrap();
        assert!(renderer.stats().uploaded_bytes < 16_384, "no texture is uploaded twice");
    }
}
