//! Surface detail: light that was baked, normals by both conventions and from heights, and relief against the mesh that
//! it stands for.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{look, plain_request, radiance};
use glam::{Vec2, Vec3, Vec4};
use image::{ImageBuffer, ImageFormat, Luma, Rgba};
use manypass::{Environment, FrameRequest, Path};
use manypass_scene::material::{DetailMaps, HeightMap, HeightMethod, LightEncoding, LightMap, TexturedFactor};
use manypass_scene::{
    Aabb, Image, ImageSource, Light, LightKind, Material, Node, Primitive, Projection, Sampler, Scene, ShadingModel,
    Texture, TextureRef, TextureTransform, Wrap, primitives,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::f32::consts::TAU;
use std::io::Cursor;

const SIZE: (u32, u32) = (256, 192);

fn png<P: image::PixelWithColorType>(image: &ImageBuffer<P, Vec<P::Subpixel>>) -> ImageSource
where
    [P::Subpixel]: image::EncodableLayout,
{
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).unwrap();
    ImageSource::Encoded(bytes.into())
}

/// Adds an image and a texture that shows it.
fn texture(scene: &mut Scene, source: ImageSource, sampler: Sampler) -> TextureRef {
    scene.images.push(Image { name: String::new(), source });
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler });
    TextureRef { texture: scene.textures.len() - 1, uv_set: 0, transform: TextureTransform::default() }
}

fn nearest() -> Sampler {
    let wrap = Wrap::ClampToEdge;
    Sampler { wrap_u: wrap, wrap_v: wrap, mag_linear: false, min_linear: false, mip_linear: None }
}

/// A square of `side_m` on the ground with `steps` × `steps` cells, u along +x and v along +z; heights and their slopes
/// by `height` at UVs. The second UV set is the first one mirrored.
fn grid(side_m: f32, steps: u32, height: impl Fn(Vec2) -> (f32, Vec2)) -> Primitive {
    let mut primitive = Primitive::default();
    for z in 0..=steps {
        for x in 0..=steps {
            let uv = Vec2::new(x as f32, z as f32) / steps as f32;
            let (y, slope) = height(uv);
            let place = (uv - 0.5) * side_m;
            primitive.positions.push([place.x, y, place.y]);
            primitive.normals.push(Vec3::new(-slope.x / side_m, 1.0, -slope.y / side_m).normalize().to_array());
            primitive.tangents.push([1.0, 0.0, 0.0, 1.0]);
            primitive.uv0.push(uv.to_array());
            primitive.uv1.push([1.0 - uv.x, uv.y]);
        }
    }
    let row = steps + 1;
    for z in 0..steps {
        for x in 0..steps {
            let first = z * row + x;
            primitive.indices.extend([first, first + row, first + 1, first + 1, first + row, first + row + 1]);
        }
    }
    let bounds = |all: Aabb, at: &[f32; 3]| all.union(&Aabb { min: Vec3::from(*at), max: Vec3::from(*at) });
    primitive.bounds = primitive.positions.iter().fold(Aabb::EMPTY, bounds);
    primitive
}

fn perspective() -> Projection {
    Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None }
}

/// A camera that sees a square of 2 m on the ground from straight above, edge to edge in height.
fn above() -> SceneBuilder {
    let projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 10.0 };
    SceneBuilder::new(Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO, projection)
}

fn linear(encoded: u8) -> f32 {
    let value = f32::from(encoded) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[test]
fn baked_light_times_base_colour_is_what_is_seen() {
    const FACTOR: Vec4 = Vec4::new(0.25, 0.5, 0.75, 1.0);
    let color = |x: u32, y: u32| Rgba([40 * x as u8 + 60, 200 - 30 * y as u8, 128, 255]);
    let baked = |x: u32, y: u32| Rgba([255 - 50 * x as u8, 20 + 60 * y as u8, 90 + 10 * x as u8, 255 - 70 * y as u8]);
    // Software adapters decode sRGB to about 1/150; half floats have 11 bits, the last of which may be cut off.
    const SRGB_SHARE: f32 = 1.0 / 100.0;
    const EXACT: f32 = 1.0 / 1000.0;
    let (plain, srgb, rgbm) = (LightEncoding::Linear, LightEncoding::Srgb, LightEncoding::Rgbm);
    for (has_texture, encoding, metallic, model) in [
        (false, plain, 0.0, ShadingModel::Standard),
        (true, plain, 0.0, ShadingModel::Standard),
        (false, srgb, 0.0, ShadingModel::Standard),
        (false, plain, 0.25, ShadingModel::Standard),
        (false, plain, 0.0, ShadingModel::Unlit),
        (false, rgbm, 0.0, ShadingModel::Standard),
    ] {
        let mut builder = above();
        let base = texture(&mut builder.scene, png(&ImageBuffer::from_fn(4, 4, color)), nearest());
        let light = texture(&mut builder.scene, png(&ImageBuffer::from_fn(4, 4, baked)), nearest());
        let light = TextureRef { uv_set: 1, ..light };
        let material = Material {
            base_color_factor: if has_texture { Vec4::ONE } else { FACTOR },
            base_color_texture: has_texture.then_some(base),
            metallic_factor: metallic,
            shading_model: model,
            light_map: Some(LightMap {
                light: TexturedFactor { factor: 1.5, texture: Some(light) },
                encoding,
                direction: None,
            }),
            ..Material::default()
        };
        builder.put(grid(2.0, 1, |_| (0.0, Vec2::ZERO)), material, at(Vec3::ZERO));
        let scene = builder.finish();
        for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
            let request = plain_request(&scene, (64, 64)).with(|settings| settings.render.path = path);
            let pixels = radiance(&scene, &request);
            for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (x, y))) {
                let found = pixels[((y * 16 + 8) * 64 + x * 16 + 8) as usize];
                // The second UV set is mirrored.
                let (base, light) = (color(x, y), baked(3 - x, y));
                let light_of = |texel: u8| {
                    1.5 * match encoding {
                        LightEncoding::Linear => f32::from(texel) / 255.0,
                        LightEncoding::Srgb => linear(texel),
                        LightEncoding::Rgbm => f32::from(texel) * f32::from(light[3]) / (255.0 * 255.0),
                    }
                };
                for channel in 0..3 {
                    let base = if has_texture { linear(base[channel]) } else { FACTOR[channel] };
                    let expected = base * (1.0 - metallic) * light_of(light[channel]);
                    let off = (found[channel] - expected).abs();
                    let most = expected * if has_texture || encoding == srgb { SRGB_SHARE } else { EXACT };
                    // Colours of one exponent go by 1/256 of the brightest number, or less.
                    let brightest = light_of([0, 1, 2].map(|channel| light[channel]).into_iter().max().unwrap());
                    let step = if encoding == rgbm { base * (1.0 - metallic) * brightest / 512.0 } else { 0.0 };
                    assert!(off <= most + step, "{path:?}, {has_texture} {encoding:?}, {x} {y}: {found:?}, {expected}");
                }
            }
        }
    }
}

#[test]
fn baked_light_of_radiance_files_exceeds_one() {
    // Powers of two, which shared exponents hold exactly.
    let baked = |x: u32, y: u32| [2.0_f32.powi(x as i32), 2.0_f32.powi(-(y as i32)), 0.5];
    let texels: Vec<_> = (0..16).map(|i| image::Rgb(baked(i % 4, i / 4))).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, 4, 4).unwrap();
    let mut builder = above();
    let light = texture(&mut builder.scene, ImageSource::Encoded(bytes.into()), nearest());
    // What is linear stays so, whatever a material says of its encoding.
    let light = TexturedFactor { factor: 4.0, texture: Some(TextureRef { uv_set: 1, ..light }) };
    let material = Material {
        light_map: Some(LightMap { light, encoding: LightEncoding::Srgb, direction: None }),
        metallic_factor: 0.0,
        ..grey(0.5)
    };
    builder.put(grid(2.0, 1, |_| (0.0, Vec2::ZERO)), material, at(Vec3::ZERO));
    let scene = builder.finish();
    for path in [Path::Deferred, Path::Forward] {
        let pixels = radiance(&scene, &plain_request(&scene, (64, 64)).with(|settings| settings.render.path = path));
        for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (x, y))) {
            let found = pixels[((y * 16 + 8) * 64 + x * 16 + 8) as usize];
            for (found, light) in found.iter().zip(baked(3 - x, y)) {
                let expected = 0.5 * 4.0 * light;
                assert!((found - expected).abs() < expected * 0.005, "{path:?} {x} {y}: {found}, {expected}");
            }
        }
    }
}

/// Bytes of vectors whose parts are from -1 to 1.
fn bytes_of(vector: Vec3) -> Rgba<u8> {
    let [x, y, z] = ((vector * 0.5 + 0.5) * 255.0).round().to_array().map(|part| part as u8);
    Rgba([x, y, z, 255])
}

/// A square of one colour of baked light, with directions if they are given, whose normals a texture tilts: one of the
/// material, or of its detail.
fn tilted(tilt: Vec3, is_detail: bool, direction: Option<Vec3>, eye_y: f32) -> Scene {
    let projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 10.0 };
    let mut builder = SceneBuilder::new(Vec3::new(0.0, eye_y, 0.0), Vec3::ZERO, projection);
    let mut filled = |color: Rgba<u8>, side: u32| {
        texture(&mut builder.scene, png(&ImageBuffer::from_pixel(side, side, color)), nearest())
    };
    let normals = filled(bytes_of(tilt), 2);
    let light = TextureRef { uv_set: 1, ..filled(Rgba([204, 102, 51, 255]), 4) };
    let direction = direction.map(|direction| TextureRef { uv_set: 1, ..filled(bytes_of(direction), 4) });
    let detail = DetailMaps { normal_texture: Some(normals), normal_scale: 1.0, base_color_texture: None };
    let light = TexturedFactor { factor: 2.0, texture: Some(light) };
    let material = Material {
        normal_texture: (!is_detail).then_some(normals),
        detail: is_detail.then_some(detail),
        light_map: Some(LightMap { light, encoding: LightEncoding::Linear, direction }),
        double_sided: true,
        ..grey(0.5)
    };
    builder.put(grid(2.0, 1, |_| (0.0, Vec2::ZERO)), material, at(Vec3::ZERO));
    builder.finish()
}

#[test]
fn normals_bend_baked_light_by_where_it_comes_from() {
    // Tangents run along x and bitangents against z, and normals along y.
    let tilt = Vec3::new(0.5, -0.2, 0.842_6);
    let normal = Vec3::new(tilt.x, tilt.z, -tilt.y);
    let sun = Vec3::new(0.6, 0.8, 0.0);
    let even = (Vec3::Y * (2.0 / 3.0), 0.5 + 0.5 * normal.y);
    let of_sun = (sun, normal.dot(sun) / sun.y);
    // Behind what is bent.
    let behind = Vec3::new(-0.96, 0.28, 0.0);
    // Of another surface: no light comes from below.
    let below = Vec3::new(0.6, -0.7, 0.0);
    let of_none = [Some((Vec3::ZERO, 1.0)), Some((below, 1.0)), None];
    let cases = [&[Some(even), Some(of_sun), Some((behind, 0.0))][..], &of_none].concat();
    let paths = [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud];
    for (is_detail, eye_y) in [(false, 5.0), (true, 5.0), (false, -5.0)] {
        for (case, path) in cases.iter().flat_map(|case| paths.map(|path| (*case, path))) {
            let scene = tilted(tilt, is_detail, case.map(|(direction, _)| direction), eye_y);
            let request = plain_request(&scene, (16, 16)).with(|settings| settings.render.path = path);
            let found = radiance(&scene, &request)[8 * 16 + 8];
            let share = case.map_or(1.0, |(_, share)| share);
            for (found, texel) in found.iter().zip([204.0, 102.0, 51.0]) {
                let expected = 0.5 * 2.0 * texel / 255.0 * share;
                assert!(
                    (found - expected).abs() <= 0.01 * expected,
                    "{path:?} {is_detail} {case:?}: {found}, {expected}"
                );
            }
        }
    }
}

#[test]
fn directions_leave_light_as_it_is_where_nothing_is_bent_and_at_its_edges() {
    let light = |x: u32, y: u32| Rgba([60 + 40 * x as u8, 250 - 60 * y as u8, if y == 3 { 255 } else { 10 }, 255]);
    let wrap = Wrap::ClampToEdge;
    let linear = Sampler { wrap_u: wrap, wrap_v: wrap, mip_linear: None, ..Sampler::default() };
    // With a normal map that bends nothing, and without any.
    let seen = |has_directions: bool, has_normals: bool, path: Path| {
        let mut builder = above();
        let mut put = |source: ImageSource| TextureRef { uv_set: 1, ..texture(&mut builder.scene, source, linear) };
        let normals = put(png(&ImageBuffer::from_pixel(1, 1, Rgba([128u8, 128, 255, 255]))));
        let direction = put(png(&ImageBuffer::from_fn(4, 4, |x, y| {
            bytes_of(Vec3::new(0.4 - 0.2 * x as f32, 0.7, 0.3 - 0.2 * y as f32))
        })));
        let texture = put(png(&ImageBuffer::from_fn(4, 4, light)));
        let light = TexturedFactor { factor: 1.0, texture: Some(texture) };
        let direction = has_directions.then_some(direction);
        let material = Material {
            normal_texture: has_normals.then_some(normals),
            light_map: Some(LightMap { light, encoding: LightEncoding::Linear, direction }),
            ..grey(0.5)
        };
        builder.put(grid(2.0, 1, |_| (0.0, Vec2::ZERO)), material, at(Vec3::ZERO));
        let scene = builder.finish();
        radiance(&scene, &plain_request(&scene, (64, 64)).with(|settings| settings.render.path = path))
    };
    for (path, has_normals) in [
        (Path::Deferred, true),
        (Path::Forward, true),
        (Path::Deferred, false),
        (Path::Forward, false),
        (Path::ForwardBatched, false),
        (Path::Gouraud, false),
    ] {
        for (with, without) in seen(true, has_normals, path).iter().zip(seen(false, has_normals, path)) {
            for (with, without) in with.iter().zip(without) {
                // Software adapters filter bytes in steps of 1/256, and half floats finer.
                let is_near = (with - without).abs() <= 0.01 * without + 0.002;
                assert!(is_near, "{path:?}, {has_normals}: {with} and {without}");
            }
        }
    }
}

#[test]
fn baked_light_takes_the_place_of_the_environments_diffuse_light_alone() {
    let mut builder = above();
    let black = texture(&mut builder.scene, png(&ImageBuffer::from_pixel(2, 2, Rgba([0u8, 0, 0, 255]))), nearest());
    let light = TexturedFactor { factor: 1.0, texture: Some(black) };
    let light_map = LightMap { light, encoding: LightEncoding::Linear, direction: None };
    builder.put(grid(2.0, 1, |_| (0.0, Vec2::ZERO)), grey(0.8), at(Vec3::ZERO));
    let plain = builder.finish();
    let mut baked = plain.clone();
    baked.materials[0].light_map = Some(light_map);
    let mut lit = baked.clone();
    lit.lights.push(Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() });
    let down = manypass_testkit::build::rotation_along(Vec3::NEG_Y);
    lit.add_node(None, Node { light: Some(0), rotation: down, ..Node::default() });
    lit.update_transforms();
    for path in [Path::Deferred, Path::Forward] {
        let seen = |scene: &Scene| {
            let request = plain_request(scene, (32, 32)).with(|settings| {
                settings.render.path = path;
                settings.environment.source = Environment::Color([1.0; 3]);
            });
            radiance(scene, &request)[16 * 32 + 16][1]
        };
        let (plain, baked, lit) = (seen(&plain), seen(&baked), seen(&lit));
        // A rough dielectric reflects one or two per cent, and sends back 0.8 of the rest.
        assert!((plain - 0.8).abs() < 0.02 && (0.005..0.03).contains(&baked), "{path:?}: {plain} {baked}");
        assert!(lit > baked + 0.6, "{path:?}: {lit}");
    }
}

/// Round bumps: heights of waves, as deep as `depth_m` at most.
fn waves(depth_m: f32, uv: Vec2) -> (f32, Vec2) {
    const WAVES: f32 = 7.0;
    let (a, b) = (uv * WAVES * TAU).into();
    let height = 0.5 + 0.5 * a.cos() * b.cos();
    let slope = Vec2::new(-a.sin() * b.cos(), -a.cos() * b.sin()) * (0.5 * WAVES * TAU * depth_m);
    (-depth_m * (1.0 - height), slope)
}

/// The same as an image of 16 bits.
fn wave_image(side: u32) -> ImageSource {
    png(&ImageBuffer::from_fn(side, side, |x, y| {
        let uv = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / side as f32;
        Luma([((waves(1.0, uv).0 + 1.0) * 65535.0).round().clamp(0.0, 65535.0) as u16])
    }))
}

/// As large as to fill the picture, so that its ends are not seen.
const WAVY_SIDE_M: f32 = 4.2;

/// A wavy square, by its mesh, or by heights on a flat one; a post stands on it.
fn wavy(height: Option<HeightMap>, depth_m: f32, light: (Light, Vec3, Vec3)) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.2, 1.35, 1.45), Vec3::new(0.0, -0.06, 0.02), perspective());
    let texture = texture(&mut builder.scene, wave_image(1024), Sampler::default());
    let height = height.map(|height| HeightMap { texture, ..height });
    let material = Material { roughness_factor: 0.6, height, ..grey(0.6) };
    let primitive = match height {
        Some(_) => grid(WAVY_SIDE_M, 1, |_| (0.0, Vec2::ZERO)),
        None => grid(WAVY_SIDE_M, 560, |uv| waves(depth_m, uv)),
    };
    builder.put(primitive, material, at(Vec3::ZERO));
    builder.put(primitives::cube(Vec3::new(0.12, 0.5, 0.12)), grey(0.5), at(Vec3::new(-0.25, 0.15, -0.2)));
    builder.light(light.0, light.1, light.2);
    builder.finish()
}

fn occlusion(depth_m: f32) -> HeightMap {
    let texture = TextureRef { texture: 0, uv_set: 0, transform: TextureTransform::default() };
    HeightMap { texture, depth_m, method: HeightMethod::Occlusion, self_shadow: false }
}

/// How two pictures of one scene agree away from edges, which are where five by five pixels differ by more than 35 % of
/// the picture's mean: the share of pixels there are, of those the share that differ by more than 3 % of that mean, and
/// how much the means of both pictures differ.
fn agreement(expected: &[[f32; 3]], found: &[[f32; 3]], (width, height): (u32, u32)) -> (f64, f64, f64) {
    let value = |pixels: &[[f32; 3]], x: u32, y: u32| f64::from(pixels[(y * width + x) as usize][1]);
    let mean = |pixels: &[[f32; 3]]| pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / pixels.len() as f64;
    let scale = mean(expected);
    let (mut smooth, mut wrong, mut all) = (0u32, 0u32, 0u32);
    for y in 2..height - 2 {
        for x in 2..width - 2 {
            all += 1;
            let around = (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| value(expected, x, y)));
            let (low, high) = around.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
            if high - low > 0.35 * scale {
                continue;
            }
            smooth += 1;
            wrong += u32::from((value(found, x, y) - value(expected, x, y)).abs() > 0.03 * scale);
        }
    }
    let off = mean(found) / scale - 1.0;
    (f64::from(smooth) / f64::from(all), f64::from(wrong) / f64::from(smooth.max(1)), off)
}

fn shadowed(scene: &Scene, path: Path) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.shadows.enabled = true;
        settings.render.path = path;
    })
}

#[test]
fn relief_is_the_picture_and_the_shadow_of_the_mesh_that_it_stands_for() {
    const DEPTH_M: f32 = 0.12;
    let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
    let lamp = Light { kind: LightKind::Point, intensity: 6.0, ..Light::default() };
    let lights = [
        // Which share of the picture is away from edges of light, and how much of that is wrong with `self_shadow`.
        ("sun", (sun, Vec3::ZERO, Vec3::new(1.0, -0.55, -0.4)), 0.47, 0.014),
        ("lamp", (lamp, Vec3::new(-0.7, 0.5, 0.5), Vec3::NEG_Y), 0.79, 0.03),
    ];
    let mut wrong_cases = Vec::new();
    for (name, light, least_smooth, most_with_self_shadow) in lights {
        let mesh = wavy(None, DEPTH_M, light.clone());
        // Maps of the two have other depths, by which they are rounded: one pixel or two, and a few more where leaks are
        // looked for, which a tenth of a texel decides.
        for (method, path, most) in [("deferred", Path::Deferred, 0.004), ("forward", Path::Forward, 0.01)] {
            let expected = radiance(&mesh, &shadowed(&mesh, path));
            for (self_shadow, most) in [(false, most), (true, most_with_self_shadow)] {
                let height = HeightMap { self_shadow, ..occlusion(DEPTH_M) };
                let relief = wavy(Some(height), DEPTH_M, light.clone());
                let found = radiance(&relief, &shadowed(&relief, path));
                look(&format!("relief_{name}_{method}_{self_shadow}"), &[&expected, &found], SIZE);
                let (smooth, wrong, off) = agreement(&expected, &found, SIZE);
                println!(
                    "{name} {method} self-shadow {self_shadow}: smooth {smooth:.3} wrong {wrong:.4} mean {off:+.4}"
                );
                let is_right = smooth > least_smooth && wrong < most && off.abs() < 0.005;
                if !is_right {
                    wrong_cases.push(format!("{name}, {method}, self-shadow {self_shadow}: {smooth} {wrong} {off}"));
                }
            }
        }
        // Coarse steps put a pixel on one of a few layers, of which none is in the shadow of its own step.
        for (method, path, self_shadow) in [("deferred", Path::Deferred, false), ("forward", Path::Forward, true)] {
            let expected = radiance(&mesh, &shadowed(&mesh, path));
            let height = HeightMap { self_shadow, method: HeightMethod::Steep, ..occlusion(DEPTH_M) };
            let relief = wavy(Some(height), DEPTH_M, light.clone());
            let found = radiance(&relief, &shadowed(&relief, path));
            look(&format!("relief_{name}_{method}_steep"), &[&expected, &found], SIZE);
            let (_, wrong, off) = agreement(&expected, &found, SIZE);
            println!("{name} {method} steep, self-shadow {self_shadow}: wrong {wrong:.4} mean {off:+.4}");
            assert!(wrong < 0.26 && off.abs() < 0.015, "{name}, {method}, steep: {wrong} {off}");
        }
        // A flat square is another picture, and so is one whose normals alone are bent.
        let expected = radiance(&mesh, &shadowed(&mesh, Path::Deferred));
        for method in [HeightMethod::Bump, HeightMethod::Parallax] {
            let other = wavy(Some(HeightMap { method, ..occlusion(DEPTH_M) }), DEPTH_M, light.clone());
            let found = radiance(&other, &shadowed(&other, Path::Deferred));
            look(&format!("relief_{name}_{method:?}"), &[&expected, &found], SIZE);
            let (_, wrong, _) = agreement(&expected, &found, SIZE);
            println!("{name} {method:?}: wrong {wrong:.4}");
            assert!(wrong > 0.2, "{name}, {method:?}: {wrong}");
        }
    }
    assert!(wrong_cases.is_empty(), "{wrong_cases:#?}");
}

#[test]
fn heights_shadow_each_other_without_shadow_maps() {
    const DEPTH_M: f32 = 0.12;
    let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
    let light = (sun, Vec3::ZERO, Vec3::new(1.0, -0.35, -0.4));
    let without_post = |mut scene: Scene| {
        scene.nodes[2].mesh = None;
        scene.update_transforms();
        scene
    };
    let mesh = without_post(wavy(None, DEPTH_M, light.clone()));
    let expected = radiance(&mesh, &shadowed(&mesh, Path::Deferred));
    let mut shares = Vec::new();
    for self_shadow in [true, false] {
        let height = HeightMap { self_shadow, ..occlusion(DEPTH_M) };
        let relief = without_post(wavy(Some(height), DEPTH_M, light.clone()));
        let found = radiance(&relief, &plain_request(&relief, SIZE));
        look(&format!("self_shadow_{self_shadow}"), &[&expected, &found], SIZE);
        let (smooth, wrong, off) = agreement(&expected, &found, SIZE);
        println!("self-shadow {self_shadow}: smooth {smooth:.3} wrong {wrong:.4} mean {off:+.4}");
        assert!(smooth > 0.38, "{smooth}");
        shares.push(wrong);
    }
    // Where nothing shadows, both are alike.
    assert!(shares[0] < 0.005 && shares[1] > 0.05, "{shares:?}");
}

#[test]
fn heights_bend_normals_as_a_mesh_of_such_normals_has_them() {
    const DEPTH_M: f32 = 0.12;
    let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
    let light = (sun, Vec3::ZERO, Vec3::new(1.0, -0.8, -0.4));
    let bumped = wavy(Some(HeightMap { method: HeightMethod::Bump, ..occlusion(DEPTH_M) }), DEPTH_M, light);
    let mut smooth = bumped.clone();
    smooth.materials[0].height = None;
    let mesh = std::sync::Arc::make_mut(&mut smooth.meshes[0]);
    let material = mesh.primitives[0].material;
    mesh.primitives[0] = Primitive { material, ..grid(WAVY_SIDE_M, 320, |uv| (0.0, waves(DEPTH_M, uv).1)) };
    for path in [Path::Deferred, Path::Forward] {
        let expected = radiance(&smooth, &plain_request(&smooth, SIZE).with(|settings| settings.render.path = path));
        let found = radiance(&bumped, &plain_request(&bumped, SIZE).with(|settings| settings.render.path = path));
        let (share, wrong, off) = agreement(&expected, &found, SIZE);
        println!("{path:?}: smooth {share:.3} wrong {wrong:.4} mean {off:+.4}");
        assert!(share > 0.69 && wrong < 0.001 && off.abs() < 0.001, "{path:?}: {share} {wrong} {off}");
    }
}

/// A texel of a normal map.
fn normal_texel(normal: Vec3) -> Rgba<u8> {
    let [x, y, z] = ((normal.normalize() * 0.5 + 0.5) * 255.0).round().to_array().map(|value| value as u8);
    Rgba([x, y, z, 255])
}

#[test]
fn normals_whose_green_points_down_are_those_whose_green_points_up() {
    let normals = |x: u32, y: u32| Vec3::new(0.5 * (x as f32).sin(), 0.5 * (y as f32 * 1.3).cos(), 1.0);
    let scene = |is_down: bool, says_down: bool| {
        let mut builder = above();
        let flipped = if is_down { Vec3::new(1.0, -1.0, 1.0) } else { Vec3::ONE };
        let image = ImageBuffer::from_fn(16, 16, |x, y| normal_texel(normals(x, y) * flipped));
        let normal_texture = Some(texture(&mut builder.scene, png(&image), Sampler::default()));
        let material = Material { normal_texture, has_normals_down: says_down, ..grey(0.7) };
        builder.put(grid(2.0, 1, |_| (0.0, Vec2::ZERO)), material, at(Vec3::ZERO));
        let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
        builder.light(sun, Vec3::ZERO, Vec3::new(0.3, -0.6, 0.7));
        builder.finish()
    };
    let seen = |scene: Scene| radiance(&scene, &plain_request(&scene, (64, 64)));
    let (up, down, wrong) = (seen(scene(false, false)), seen(scene(true, true)), seen(scene(true, false)));
    // 127.5 has no byte: green of 128 turned around is 127.
    let worst = |other: &[[f32; 3]]| up.iter().zip(other).map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f32::max);
    assert!(worst(&down) < 0.02, "{}", worst(&down));
    assert!(worst(&wrong) > 0.3, "{}", worst(&wrong));
}

#[test]
fn detail_is_laid_over_what_is_below() {
    let tilt = Vec3::new(0.3, -0.2, 1.0);
    let scene = |base: Option<Vec3>, detail: Option<Vec3>, color: Option<u8>| {
        let mut builder = above();
        let mut map = |normal: Vec3| {
            let image = ImageBuffer::from_pixel(4, 4, normal_texel(normal));
            texture(&mut builder.scene, png(&image), Sampler::default())
        };
        let normal_texture = base.map(&mut map);
        let detail_texture = detail.map(&mut map);
        let color = color.map(|grey| {
            let image = ImageBuffer::from_pixel(4, 4, Rgba([grey, grey, grey, 255u8]));
            texture(&mut builder.scene, png(&image), Sampler::default())
        });
        let detail = (detail.is_some() || color.is_some()).then_some(DetailMaps {
            normal_texture: detail_texture,
            normal_scale: 1.0,
            base_color_texture: color,
        });
        let material =
            Material { normal_texture, detail, base_color_factor: Vec4::new(0.3, 0.4, 0.2, 1.0), ..grey(0.7) };
        builder.put(grid(2.0, 1, |_| (0.0, Vec2::ZERO)), material, at(Vec3::ZERO));
        let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
        builder.light(sun, Vec3::ZERO, Vec3::new(0.3, -0.6, 0.7));
        builder.finish()
    };
    for path in [Path::Deferred, Path::Forward] {
        let seen = |base, detail, color| {
            let scene = scene(base, detail, color);
            radiance(&scene, &plain_request(&scene, (16, 16)).with(|settings| settings.render.path = path))[136]
        };
        let near = |a: [f32; 3], b: [f32; 3], what: &str| {
            let off = (Vec3::from(a) - Vec3::from(b)).abs().max_element();
            assert!(off < 0.01 * Vec3::from(b).max_element(), "{path:?}, {what}: {a:?} {b:?}");
        };
        let (flat, tilted) = (seen(None, None, None), seen(Some(tilt), None, None));
        assert!((tilted[1] / flat[1] - 1.0).abs() > 0.1, "{flat:?} {tilted:?}");
        // One over a flat one, or under it, is as it is alone; without any below it, too.
        near(seen(Some(tilt), Some(Vec3::Z), None), tilted, "flat detail");
        near(seen(Some(Vec3::Z), Some(tilt), None), tilted, "detail over flat");
        near(seen(None, Some(tilt), None), tilted, "detail alone");
        // Turned by the same angle twice.
        let half = Vec3::new(0.0, 0.2f32.sin(), 0.2f32.cos());
        let whole = Vec3::new(0.0, 0.4f32.sin(), 0.4f32.cos());
        near(seen(Some(half), Some(half), None), seen(Some(whole), None, None), "two turns");
        // 188 is 0.5 in linear light.
        near(seen(None, None, Some(188)), flat, "grey detail");
        let (dark, diffuse) = (seen(None, None, Some(137)), flat);
        assert!(dark[1] < 0.6 * diffuse[1] && dark[1] > 0.4 * diffuse[1], "{dark:?} {diffuse:?}");
    }
}
