//! Effects: what they may read, and that a wrong one is an error that names file, line and name; never a panic.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use manypass::{FrameRequest, Path, Renderer, Target, WgslEffect};
use manypass_testkit::compare::Picture;
use manypass_testkit::scenes;
use std::sync::Arc;

/// The whole of an effect but its body.
fn effect(renderer: &Renderer, body: &str) -> Result<WgslEffect, String> {
    let source = format!("@fragment\nfn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {{\n{body}\n}}\n");
    WgslEffect::new(renderer.gpu(), "folder/mine.wgsl", &source).map_err(|error| error.to_string())
}

#[test]
fn every_variable_of_the_frame_can_be_read() {
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let mut request = common::plain_request(&test.scene, (64, 48));
    let plain = picture(&mut renderer, &test.scene, &request);
    let mut seen: Vec<Picture> = Vec::new();
    for body in [
        "return vec4f(radiance_at(vec2i(position.xy)).brg, 1.0);",
        "return vec4f(surface_at(vec2i(position.xy)).normal_world * 0.5 + 0.5, 1.0);",
        "return vec4f(vec3f(0.1 * distance_at(vec2i(position.xy))), 1.0);",
        "return vec4f(surface_at(vec2i(position.xy)).base_color, 1.0);",
        "return vec4f(vec3f(textureLoad(material, vec2i(position.xy), 0).g), 1.0);",
        "return textureSampleLevel(radiance, linear_clamp, uv_from_pixel(position.yx), 0.0);",
        "return textureSampleLevel(linear_depth, nearest_clamp, uv_from_pixel(position.xy), 0.0);",
        "return vec4f(fract(position_world_from_pixel(position.xy, distance_at(vec2i(position.xy)))), 1.0);",
    ] {
        request.effects = vec![Arc::new(effect(&renderer, body).unwrap())];
        let found = picture(&mut renderer, &test.scene, &request);
        assert!(found != plain && !seen.contains(&found), "{body}");
        seen.push(found);
    }
    // A chain: swapping red and green twice gives the picture back.
    let swap = "return radiance_at(vec2i(position.xy)).grba;";
    request.effects = vec![Arc::new(effect(&renderer, swap).unwrap()), Arc::new(effect(&renderer, swap).unwrap())];
    assert_eq!(picture(&mut renderer, &test.scene, &request), plain);
    // The forward path has radiance, and no G-buffer.
    request.path = Path::Forward;
    picture(&mut renderer, &test.scene, &request);
    request.effects =
        vec![Arc::new(effect(&renderer, "return surface_at(vec2i(position.xy)).normal_world.xyzz;").unwrap())];
    let error = renderer.render(&test.scene, &request).unwrap_err().to_string();
    assert!(error.contains("`normal`") || error.contains("`base_color`"), "{error}");
}

fn picture(renderer: &mut Renderer, scene: &manypass::scene::Scene, request: &FrameRequest) -> Picture {
    renderer.render(scene, request).unwrap();
    Picture::from_rgba8(request.width as usize, request.height as usize, &renderer.read_display().unwrap())
}

#[test]
fn a_wrong_effect_is_an_error_that_says_where() {
    let renderer = common::renderer();
    let gpu = renderer.gpu();
    let main = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {";
    for (source, expected) in [
        ("", "0"),
        ("this is no WGSL", "mine.wgsl:1:1"),
        (&format!("{main}\n\n    return radianc_at(vec2i(p.xy)); }}"), "mine.wgsl:3:12"),
        (&format!("{main}\n    return vec3f(1.0); }}"), "mine.wgsl:2"),
        (&format!("{main} loop {{ }} }}"), "mine.wgsl"),
        ("@compute @workgroup_size(1) fn cs() {}", "`cs` is not a `@fragment`"),
        (&format!("{main} return vec4f(1.0); }}\n@fragment fn two() {{}}"), "not 2"),
        ("@fragment fn fs(@location(0) uv: vec2f) -> @location(0) vec4f { return uv.xyxy; }", "takes nothing but"),
        ("@fragment fn fs() -> @location(1) vec4f { return vec4f(1.0); }", "`@location(0) vec4f`"),
        ("@fragment fn fs() -> @location(0) vec4u { return vec4u(1); }", "`@location(0) vec4f`"),
        ("@fragment fn fs() -> @builtin(frag_depth) f32 { return 1.0; }", "`@location(0) vec4f`"),
        (&format!("override x: f32;\n{main} return vec4f(x); }}"), "override"),
        (
            &format!("\n@group(1) @binding(9) var t: texture_2d<f32>;\n{main} return textureLoad(t, vec2i(0), 0); }}"),
            "mine.wgsl:2: `t`",
        ),
        (&format!("@group(7) @binding(0) var<uniform> u: f32;\n{main} return vec4f(u); }}"), "`u` in group 7"),
        (&format!("@group(2) @binding(0) var<storage> b: f32;\n{main} return vec4f(b); }}"), "mine.wgsl:1: `b`"),
        (&format!("{main} return textureSampleLevel(linear_depth, linear_clamp, p.xy, 0.0); }}"), "cannot be filtered"),
        (&format!("var<private> radiance: f32;\n{main} return vec4f(radiance); }}"), "mine.wgsl:1"),
    ] {
        let error = WgslEffect::new(gpu, "mine.wgsl", source).map(drop).unwrap_err().to_string();
        assert!(error.contains("mine") && error.contains(expected), "{source}:\n{error}\nshould say {expected}");
    }
    gpu.check().unwrap();
}

#[test]
fn uniforms_are_set_by_name_and_size() {
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let source = "@group(2) @binding(1) var<uniform> tint: vec4f;
        @group(2) @binding(0) var<uniform> scale: f32;
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return tint * scale; }";
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "tint", source).unwrap());
    assert_eq!(effect.name(), "tint");
    for (name, size, expected) in [("tnit", 16, "scale"), ("tint", 12, "16 bytes"), ("scale", 16, "4 bytes")] {
        let error = effect.set_uniform(name, &vec![0; size]).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(expected), "{error}");
    }
    let mut request = common::plain_request(&test.scene, (8, 8));
    request.effects = vec![effect.clone()];
    renderer.render(&test.scene, &request).unwrap();
    let is_black = |pixel: &[f32]| pixel[..3] == [0.0; 3];
    assert!(renderer.read_radiance().unwrap().chunks(4).all(is_black), "uniforms are zero at first");
    effect.set_uniform("scale", &0.5f32.to_le_bytes()).unwrap();
    effect.set_uniform("tint", bytemuck::cast_slice(&[1f32, 2.0, 3.0, 2.0])).unwrap();
    renderer.render(&test.scene, &request).unwrap();
    assert!(renderer.read_radiance().unwrap().chunks(4).all(|pixel| pixel == [0.5, 1.0, 1.5, 1.0]));
    // Another device's effect is refused.
    let mut other = common::renderer();
    other.load(&test.scene).unwrap();
    let error = other.render(&test.scene, &request).unwrap_err().to_string();
    assert!(error.contains("another device"), "{error}");
}

#[test]
fn a_target_that_cannot_be_drawn_to_is_an_error() {
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let texture = |format| {
        renderer.gpu().device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 16, height: 16, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    };
    let good = texture(wgpu::TextureFormat::Bgra8Unorm);
    let good_target = Target::whole(&good);
    let outside = Target { rectangle: [8, 0, 9, 16], ..good_target.clone() };
    let empty = Target { rectangle: [0, 0, 0, 16], ..good_target.clone() };
    let wrapping = Target { rectangle: [u32::MAX, 0, 2, 16], ..good_target.clone() };
    let integers = Target::whole(&texture(wgpu::TextureFormat::Rgba8Uint));
    let request = common::plain_request(&test.scene, (16, 16));
    for target in [outside, empty, wrapping, integers] {
        let error = renderer.render_to(&test.scene, &request, &target).unwrap_err().to_string();
        assert!(error.starts_with("the target cannot be drawn to"), "{error}");
    }
    // At the same size and format without sRGB, the target holds the picture itself, blue first.
    renderer.render_to(&test.scene, &request, &good_target).unwrap();
    let found = pollster::block_on(manypass::gpu::readback::read_texture(renderer.gpu(), &good)).unwrap();
    let display = renderer.read_display().unwrap();
    for (found, shown) in found.chunks(4).zip(display.chunks(4)) {
        assert!((0..3).all(|c| found[2 - c].abs_diff(shown[c]) <= 1), "{found:?} {shown:?}");
    }
}
