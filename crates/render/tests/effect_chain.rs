//! The chain of effects: its order, what effects read of each other and of the frame, and which are drawn together.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod conditions;
mod fallbacks;
mod messages;
mod tables;

use crate::common::{self, plain_request, renderer};
use manypass::{Effect, FrameRequest, Renderer, WgslEffect};
use manypass_scene::Scene;
use manypass_testkit::scenes;
use std::sync::Arc;

const SIZE: (u32, u32) = (64, 48);

/// A renderer and something to draw.
fn drawn() -> (Renderer, Scene, FrameRequest) {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = plain_request(&scene, SIZE);
    (renderer, scene, request)
}

fn effects(renderer: &Renderer, sources: &[&str]) -> Vec<Arc<dyn Effect>> {
    let compiled = sources.iter().map(|source| effect(renderer, source) as Arc<dyn Effect>);
    compiled.collect()
}

fn effect(renderer: &Renderer, source: &str) -> Arc<WgslEffect> {
    Arc::new(WgslEffect::new(renderer.gpu(), "mine.wgsl", source).unwrap_or_else(|error| panic!("{error}")))
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap()
}

/// An effect that adds and then multiplies, of pixels alone.
fn linear(name: &str, share: f32, more: f32) -> String {
    format!(
        "//! effect {name}
        //! pixel: changed
        struct Numbers {{
            // = {share}
            share: f32,
            // = {more}
            more: f32,
            padding: vec2f,
        }}
        @group(2) @binding(0) var<uniform> numbers: Numbers;
        const changed_by = 1.0;
        fn changed(color: vec4f, position: vec2f) -> vec4f {{
            return vec4f(color.rgb * numbers.share + numbers.more * changed_by, color.a);
        }}"
    )
}

#[test]
fn effects_of_pixels_are_drawn_in_one_pass_in_their_order() {
    let (mut renderer, scene, mut request) = drawn();
    let before = radiance(&mut renderer, &scene, &request);
    let [twice, plus, half] = [linear("twice", 2.0, 0.0), linear("plus", 1.0, 0.25), linear("half", 0.5, 0.0)];
    let of =
        |change: fn(f32) -> f32| move |(at, value): (usize, &f32)| if at % 4 == 3 { *value } else { change(*value) };
    let near = |found: &[f32], expected: Vec<f32>| {
        let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs() / b.abs().max(1.0)).fold(0.0, f32::max);
        assert!(off < 2e-3, "{off}");
    };
    request.effects = effects(&renderer, &[&twice, &plus, &half]);
    let plan = renderer.plan(&scene, &request).unwrap().to_text();
    assert!(plan.contains("twice+plus+half") && !plan.contains("plus.radiance"), "{plan}");
    let found = radiance(&mut renderer, &scene, &request);
    near(&found, before.iter().enumerate().map(of(|x| (x * 2.0 + 0.25) * 0.5)).collect());
    // The other way round they make something else.
    request.effects.reverse();
    let found = radiance(&mut renderer, &scene, &request);
    near(&found, before.iter().enumerate().map(of(|x| (x * 0.5 + 0.25) * 2.0)).collect());
    // One that is off is none of them, from one frame to the next, and values of each are its own.
    let one = effect(&renderer, &plus);
    request.effects = vec![effect(&renderer, &twice), one.clone(), effect(&renderer, &half)];
    near(
        &radiance(&mut renderer, &scene, &request),
        before.iter().enumerate().map(of(|x| (x * 2.0 + 0.25) * 0.5)).collect(),
    );
    one.set("plus.more", "0.75").unwrap();
    near(
        &radiance(&mut renderer, &scene, &request),
        before.iter().enumerate().map(of(|x| (x * 2.0 + 0.75) * 0.5)).collect(),
    );
    one.set("plus.enabled", "false").unwrap();
    near(&radiance(&mut renderer, &scene, &request), before.clone());
    let plan = renderer.plan(&scene, &request).unwrap().to_text();
    assert!(plan.contains("twice+half"), "{plan}");
}

#[test]
fn what_looks_at_other_pixels_stands_between_those_that_do_not() {
    let (mut renderer, scene, mut request) = drawn();
    let shift = "//! effect shift
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return radiance_at(vec2i(p.xy) + 1); }";
    let [a, b, c] = [linear("a", 2.0, 0.0), linear("b", 1.0, 0.5), linear("c", 0.5, 0.0)];
    request.effects = effects(&renderer, &[&a, &b, shift, &c]);
    let plan = renderer.plan(&scene, &request).unwrap().to_text();
    assert!(plan.contains("a+b") && !plan.contains("+shift") && !plan.contains("+c"), "{plan}");
    // A hundred of them are drawn, eight at once.
    let many: Vec<String> = (0..100).map(|index| linear(&format!("n{index}"), 1.0, 0.015625)).collect();
    request.effects = effects(&renderer, &many.iter().map(String::as_str).collect::<Vec<_>>());
    let before = {
        let request = FrameRequest { effects: Vec::new(), ..request.clone() };
        radiance(&mut renderer, &scene, &request)
    };
    let found = radiance(&mut renderer, &scene, &request);
    // Half floats between them hold what is brighter with fewer places.
    let dark = found.chunks_exact(4).zip(before.chunks_exact(4)).filter(|(_, before)| before[0] < 0.5);
    let off = dark.map(|(found, before)| (found[0] - before[0] - 1.5625).abs()).fold(0.0, f32::max);
    assert!(off < 0.02, "{off}");
    let plan = renderer.plan(&scene, &request).unwrap().to_text();
    assert!(plan.contains("n0+n1+n2+n3+n4+n5+n6+n7") && !plan.contains("n7+n8"), "{plan}");
}

const WRITER: &str = "//! effect writer
    //! passes: fs_a -> half 1/2, fs_b
    @fragment fn fs_a(@builtin(position) p: vec4f) -> @location(0) vec4f { return vec4f(3.0, 0.0, 0.0, 1.0); }
    @fragment fn fs_b(@builtin(position) p: vec4f) -> @location(0) vec4f {
        return radiance_at(vec2i(p.xy)) + 0.0 * textureLoad(half, vec2i(0), 0);
    }";
const READER: &str = "//! effect reader
    //! reads: writer.half
    @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
        return textureSampleLevel(writer_half, linear_clamp, uv_from_pixel(p.xy), 0.0);
    }";

#[test]
fn an_effect_reads_what_another_wrote_and_comes_after_it() {
    let (mut renderer, scene, mut request) = drawn();
    for sources in [[WRITER, READER], [READER, WRITER]] {
        request.effects = effects(&renderer, &sources);
        let found = radiance(&mut renderer, &scene, &request);
        assert!(found.chunks_exact(4).all(|pixel| pixel == [3.0, 0.0, 0.0, 1.0]), "{:?}", &found[..4]);
    }
}

#[test]
fn effects_read_occlusion_and_motion_where_the_frame_has_them() {
    let (mut renderer, scene, mut request) = drawn();
    let reads = |name: &str| {
        format!(
            "//! reads: {name}
            @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                return vec4f(textureLoad({name}, vec2i(p.xy), 0).r + 10.0, 0.0, 0.0, 1.0);
            }}"
        )
    };
    request.effects = effects(&renderer, &[&reads("occlusion")]);
    let missing = renderer.render(&scene, &request).unwrap_err().to_string();
    assert!(missing.contains("it needs occlusion.enabled=true"), "{missing}");
    request.settings.occlusion.enabled = true.into();
    let found = radiance(&mut renderer, &scene, &request);
    let of = |found: &[f32]| {
        found.iter().step_by(4).fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(*x), high.max(*x)))
    };
    let (low, high) = of(&found);
    assert!(low < 10.7 && (10.99..11.2).contains(&high), "{low} {high}");
    // Nothing moved.
    request.effects = effects(&renderer, &[&reads("motion")]);
    let found = radiance(&mut renderer, &scene, &request);
    assert_eq!(of(&found), (10.0, 10.0));
    // The camera goes to the left by a tenth of a metre; what is seen, to the right.
    let pose = Arc::new(manypass::Pose::capture(&scene, request.camera));
    let mut moved = request.camera;
    moved.world_from_view.w_axis -= 0.1 * moved.world_from_view.x_axis;
    let request = FrameRequest { camera: moved, previous: Some(pose), ..request };
    let (low, high) = of(&radiance(&mut renderer, &scene, &request));
    assert!(high > 10.2 && low >= 10.0, "{low} {high}");
}

#[test]
fn no_effects_are_drawn_where_all_are_off() {
    let (mut renderer, scene, mut request) = drawn();
    let before = radiance(&mut renderer, &scene, &request);
    request.effects = effects(&renderer, &[&linear("plus", 1.0, 0.25)]);
    request.settings.occlusion.enabled = true.into();
    request.settings.reflections.enabled = true.into();
    assert_ne!(radiance(&mut renderer, &scene, &request), before);
    request.settings.effects.enabled = false;
    assert_eq!(radiance(&mut renderer, &scene, &request), before);
}

#[test]
fn a_new_text_takes_the_place_of_an_effects_and_a_broken_one_does_not() {
    let (mut renderer, scene, mut request) = drawn();
    let before = radiance(&mut renderer, &scene, &request);
    let plus = effect(&renderer, &linear("plus", 1.0, 0.25));
    request.effects = vec![plus.clone()];
    plus.set("plus.more", "0.5").unwrap();
    let added = |renderer: &mut Renderer| {
        let found = radiance(renderer, &scene, &request);
        found[0] - before[0]
    };
    assert!((added(&mut renderer) - 0.5).abs() < 0.01);
    // Values stay.
    plus.replace(&linear("plus", 1.0, 0.25).replace("changed_by = 1.0", "changed_by = 4.0")).unwrap();
    assert!((added(&mut renderer) - 2.0).abs() < 0.01);
    let broken =
        plus.replace(&linear("plus", 1.0, 0.25).replace("color.rgb *", "colour.rgb *")).unwrap_err().to_string();
    assert!(broken.starts_with("mine.wgsl:13:26: error: ") && broken.contains("^"), "{broken}");
    let renamed = plus.replace(&linear("minus", 1.0, 0.25)).unwrap_err().to_string();
    assert!(renamed.contains("`//! effect plus`"), "{renamed}");
    assert!((added(&mut renderer) - 2.0).abs() < 0.01);
}

#[test]
fn an_added_effect_is_in_every_picture_until_it_is_removed() {
    let (mut renderer, scene, request) = drawn();
    let before = radiance(&mut renderer, &scene, &request);
    let plus = renderer.add_effect("plus.wgsl", &linear("plus", 1.0, 0.25)).unwrap();
    let twice = renderer.add_effect("plus.wgsl", &linear("plus", 1.0, 0.25)).unwrap_err().to_string();
    assert!(twice.contains("`Renderer::replace_effect`"), "{twice}");
    let added = |renderer: &mut Renderer| radiance(renderer, &scene, &request)[0] - before[0];
    assert!((added(&mut renderer) - 0.25).abs() < 0.01);
    plus.set("plus.more", "0.5").unwrap();
    assert!((added(&mut renderer) - 0.5).abs() < 0.01);
    let broken = renderer.replace_effect("plus", "fn").unwrap_err().to_string();
    assert!(broken.starts_with("plus.wgsl:1:"), "{broken}");
    assert!((added(&mut renderer) - 0.5).abs() < 0.01);
    renderer.replace_effect("plus", &linear("plus", 1.0, 1.0).replace("changed_by = 1.0", "changed_by = 2.0")).unwrap();
    assert!((added(&mut renderer) - 1.0).abs() < 0.01);
    renderer.remove_effect("plus").unwrap();
    assert_eq!(added(&mut renderer), 0.0);
    assert!(renderer.remove_effect("plus").unwrap_err().to_string().contains("no effect of that name"));
}

#[test]
fn what_is_no_number_stays_in_its_pixel() {
    let (mut renderer, scene, mut request) = drawn();
    let here = "select(0.0, 1.0, all(vec2i(p.xy) == vec2i(32, 24)))";
    // 0 / 0 at one pixel, and 1 at all others.
    let by_pass = format!(
        "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{
            let zero = 1.0 - {here};
            return radiance_at(vec2i(p.xy)) * (zero / zero);
        }}"
    );
    let by_function = format!(
        "//! pixel: changed
        fn changed(color: vec4f, p: vec2f) -> vec4f {{ let zero = 1.0 - {here}; return color * (zero / zero); }}"
    );
    request.effects = vec![common::built_in(&renderer, "blur")];
    let blurred = radiance(&mut renderer, &scene, &request);
    let plan = renderer.plan(&scene, &request).unwrap().to_text();
    assert!(plan.contains("scrub") && !plan.contains("scrub.2"), "{plan}");
    for source in [by_pass, by_function] {
        request.effects = effects(&renderer, &[&source]);
        request.effects.push(common::built_in(&renderer, "blur"));
        let found = radiance(&mut renderer, &scene, &request);
        let off = found.chunks_exact(4).zip(blurred.chunks_exact(4));
        let off = off.filter(|(found, before)| (found[0] - before[0]).abs() > 0.5 * before[0]).count();
        assert!(off < 40, "{off} pixels are spoilt");
    }
}

#[test]
fn motion_blur_smears_what_moved_as_an_open_shutter_does() {
    let (mut renderer, scene, request) = drawn();
    let sharp = radiance(&mut renderer, &scene, &request);
    let blur = common::built_in(&renderer, "motion_blur");
    blur.set("motion_blur.shutter", "1").unwrap();
    blur.set("motion_blur.taps", "31").unwrap();
    // Nothing moves: nothing changes.
    let still = FrameRequest {
        effects: vec![blur.clone()],
        previous: Some(Arc::new(manypass::Pose::capture(&scene, request.camera))),
        ..request.clone()
    };
    assert_eq!(radiance(&mut renderer, &scene, &still), sharp);
    let step = 0.35 * request.camera.world_from_view.x_axis;
    let moved = |share: f32| {
        let mut camera = request.camera;
        camera.world_from_view.w_axis += share * step;
        camera
    };
    let before = Arc::new(manypass::Pose::capture(&scene, moved(-1.0)));
    let moving = FrameRequest { previous: Some(before), ..still };
    let blurred = radiance(&mut renderer, &scene, &moving);
    let mut truth = vec![0.0; sharp.len()];
    const TIMES: usize = 32;
    for time in 0..TIMES {
        let share = (time as f32 + 0.5) / TIMES as f32 - 0.5;
        let found = radiance(&mut renderer, &scene, &FrameRequest { camera: moved(share), ..request.clone() });
        truth.iter_mut().zip(found).for_each(|(sum, value)| *sum += value / TIMES as f32);
    }
    let off = |found: &[f32]| found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum::<f32>() / found.len() as f32;
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    let (without, with) = (off(&sharp), off(&blurred));
    assert!(with < 0.55 * without, "{with} {without}");
    assert!((mean(&blurred) / mean(&sharp) - 1.0).abs() < 0.02);
}
