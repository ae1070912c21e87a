//! The chain of effects: its order, what effects read of each other and of the frame, and which are drawn together.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::{plain_request, renderer};
use manypass::{Effect, EffectFile, FrameRequest, Renderer, WgslEffect};
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

fn error(sources: &[&str]) -> String {
    let files: Vec<EffectFile> = sources.iter().map(|source| EffectFile::parse("mine.wgsl", source).unwrap()).collect();
    EffectFile::check_chain(&files).unwrap_err().to_string()
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
fn what_cannot_be_read_is_said() {
    let other = |name: &str, reads: &str, texture: &str| {
        let variable = reads.replace('.', "_");
        format!(
            "//! effect {name}
            //! reads: {reads}
            //! passes: fs_a -> {texture}, fs_b
            @fragment fn fs_a(@builtin(position) p: vec4f) -> @location(0) vec4f {{ return textureLoad({variable}, vec2i(0), 0); }}
            @fragment fn fs_b(@builtin(position) p: vec4f) -> @location(0) vec4f {{ return textureLoad({texture}, vec2i(0), 0); }}"
        )
    };
    let (a, b) = (other("a", "b.y", "x"), other("b", "a.x", "y"));
    let circle = error(&[&a, &b]);
    assert!(circle.contains("a reads of b reads of a"), "{circle}");
    let alone = error(&[READER]);
    assert!(alone.contains("`reader`") && alone.contains("no effect `writer`"), "{alone}");
    let wrong = error(&[&other("c", "writer.whole", "x"), WRITER]);
    assert!(wrong.contains("`writer` writes no texture `whole`; it writes: half"), "{wrong}");
    let off: Vec<EffectFile> = [WRITER, READER]
        .iter()
        .map(|source| {
            let mut file = EffectFile::parse("mine.wgsl", source).unwrap();
            if source == &WRITER {
                file.set("writer.enabled", "false").unwrap();
            }
            file
        })
        .collect();
    let off = EffectFile::check_chain(&off).unwrap_err().to_string();
    assert!(off.contains("`writer` is off; set writer.enabled=true, or reader.enabled=false"), "{off}");
    let display = "//! effect shown
        //! reads: display, writer.half
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return display_at(vec2i(p.xy)) + textureLoad(writer_half, vec2i(0), 0);
        }";
    let sides = error(&[WRITER, display]);
    assert!(sides.contains("two sides of the tone curve"), "{sides}");
    let parse = |source: &str| EffectFile::parse("mine.wgsl", source).unwrap_err().to_string();
    let main = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f";
    for (source, expected) in [
        ("//! pixel: no\nfn f() {}".to_owned(), "mine.wgsl:1:12: error: there is no function `no`"),
        ("//! pixel: 2d".to_owned(), "mine.wgsl:1:12: error: this is no name of a function"),
        (
            "//! pixel: f\nfn f(c: vec4f) -> vec4f { return c; }".to_owned(),
            "mine.wgsl:2:4: error: `f` is no function of a pixel",
        ),
        (
            "//! pixel: f\nfn f(c: vec4f, p: vec2f) -> vec4f { return radiance_at(vec2i(p)); }".to_owned(),
            "mine.wgsl:2:4: error: `f` reads `radiance`",
        ),
        (
            format!("//! pixel: f\nfn f(c: vec4f, p: vec2f) -> vec4f {{ return c; }}\n{main} {{ return vec4f(1.0); }}"),
            "has neither `//! passes:` nor `@fragment` functions",
        ),
        (
            format!("{main} {{ var x = 0.0;\n  loop {{ x += 1.0; }}\n return vec4f(x); }}"),
            "mine.wgsl:2:3: error: this loop never ends",
        ),
        (
            format!(
                "fn f() {{ var i = 0; loop {{ loop {{ i++; if i > 4 {{ break; }} }} }} }}\n{main} {{ f(); return vec4f(1.0); }}"
            ),
            "mine.wgsl:1:21: error: this loop never ends",
        ),
        (format!("{main} {{\n  while true {{ }}\n return p; }}"), "mine.wgsl:2:3: error: this loop never ends"),
        (format!("{main} {{ for (var i = 0; 1 < 2; i++) {{ }} return p; }}"), "error: this loop never ends"),
        (format!("const GO_ON = true;\n{main} {{ while GO_ON {{ }} return p; }}"), "error: this loop never ends"),
        (format!("{main} {{ loop {{ if false {{ break; }} }} return p; }}"), "error: this loop never ends"),
        (
            format!("{main} {{ var i = 0; loop {{ i++; continuing {{ break if false; }} }} return p; }}"),
            "error: this loop never ends",
        ),
        (format!("//! reads: glow.\n{main} {{ return vec4f(1.0); }}"), "there is no `glow.` to read"),
        (
            format!("//! reads: glow.wide\nvar<private> glow_wide: f32;\n{main} {{ return vec4f(glow_wide); }}"),
            "is called `glow_wide` in the shader, which is declared already",
        ),
        (
            format!("{main} {{ return textureLoad(occlusion, vec2i(0), 0); }}"),
            "`//! reads: occlusion` (or `motion`, or `ids`) in the header declares it",
        ),
    ] {
        let found = parse(&source);
        assert!(found.contains(expected), "{source}\n{found}\nshould say {expected}");
    }
    for body in [
        "loop { if p.x > 1.0 { break; } }",
        "for (;;) { switch i32(p.x) { default { return p; } } }",
        "while p.x > 2.0 { }",
        "while true { if p.x > 1.0 { break; } }",
        "while true { return p; }",
        "for (var i = 0; true; i++) { if i > 4 { break; } }",
        "while false { }",
        "var i = 0; loop { i++; continuing { break if i > 4; } }",
    ] {
        EffectFile::parse("mine.wgsl", &format!("{main} {{ {body} return p; }}"))
            .unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn a_word_too_many_in_reads_is_a_warning_and_asks_nothing_of_the_frame() {
    let (mut renderer, scene, mut request) = drawn();
    let main =
        "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return radiance_at(vec2i(p.xy)); }";
    let exact = format!("//! reads: radiance\n{main}");
    let needless = format!("//! reads: radiance, ids, glow.wide\n{main}");
    assert!(EffectFile::parse("mine.wgsl", &exact).unwrap().warnings().is_empty());
    assert_eq!(
        EffectFile::parse("mine.wgsl", &needless).unwrap().warnings(),
        [
            "mine.wgsl:1:5: the shader does not read ids, glow.wide; `//! reads: radiance` is right, and so is no such line"
        ]
    );
    // Neither is there an effect `glow`, nor are ids drawn.
    let [exact, needless] = [exact, needless].map(|source| {
        request.effects = effects(&renderer, &[&source]);
        renderer.plan(&scene, &request).unwrap().to_text()
    });
    assert_eq!(exact, needless);
    renderer.render(&scene, &request).unwrap();
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

/// A table of colours of so many along each side, or a curve.
fn cube(size: usize, is_solid: bool, color: impl Fn([f32; 3]) -> [f32; 3]) -> String {
    let at = |index: usize| index as f32 / (size - 1) as f32;
    let count = if is_solid { size.pow(3) } else { size };
    let places = (0..count).map(|index| {
        if is_solid { [at(index % size), at(index / size % size), at(index / size / size)] } else { [at(index); 3] }
    });
    let lines: String = places.map(color).map(|[r, g, b]| format!("{r} {g} {b}\n")).collect();
    format!("TITLE \"test\"\n# A remark.\nLUT_{}D_SIZE {size}\n{lines}", if is_solid { 3 } else { 1 })
}

#[test]
fn a_table_of_colours_changes_what_displays_show() {
    let (mut renderer, scene, mut request) = drawn();
    request.settings.tone_map.dither = 0.0;
    let mut picture = |cubes: &[(&str, String)]| {
        let table = |(file, text): &(&str, String)| {
            Arc::new(WgslEffect::new(renderer.gpu(), file, text).unwrap_or_else(|error| panic!("{error}")))
                as Arc<dyn Effect>
        };
        request.effects = cubes.iter().map(table).collect();
        renderer.render(&scene, &request).unwrap();
        renderer.read_display().unwrap()
    };
    let plain = picture(&[]);
    let most = |found: &[u8], expected: &dyn Fn(&[u8]) -> [f32; 3]| {
        let pixels = found.chunks_exact(4).zip(plain.chunks_exact(4));
        let off = pixels.map(|(found, plain)| {
            let expected = expected(plain);
            (0..3).map(|i| (f32::from(found[i]) - expected[i]).abs()).fold(0.0, f32::max)
        });
        off.fold(0.0, f32::max)
    };
    let same = |p: &[u8]| [p[0], p[1], p[2]].map(f32::from);
    for (size, is_solid) in [(2, true), (17, true), (33, true), (2, false), (4096, false)] {
        let found = picture(&[("2 same.cube", cube(size, is_solid, |color| color))]);
        assert!(most(&found, &same) <= 1.0, "{size} {is_solid}");
    }
    // Linear in the channels: exact within a tetrahedron of any of the six kinds.
    let mixed = |[r, g, b]: [f32; 3]| [0.5 * g + 0.25 * b, 1.0 - r, 0.2 * r + 0.7 * b];
    let found = picture(&[("mixed.cube", cube(5, true, mixed))]);
    let expected =
        |p: &[u8]| mixed([p[0], p[1], p[2]].map(|value| f32::from(value) / 255.0)).map(|value| value * 255.0);
    assert!(most(&found, &expected) <= 1.5, "{}", most(&found, &expected));
    let found = picture(&[
        ("a.cube", cube(5, true, |[r, g, b]| [g, b, r])),
        ("b.CUBE", cube(9, false, |[r, ..]| [1.0 - r; 3])),
    ]);
    let expected = |p: &[u8]| [p[1], p[2], p[0]].map(|value| 255.0 - f32::from(value));
    assert!(most(&found, &expected) <= 1.5, "{}", most(&found, &expected));
    let plan = renderer.plan(&scene, &request).unwrap().to_text();
    assert!(plan.contains("a+b"), "{plan}");
    let domain = cube(3, true, |color| color).replace("LUT_3D", "DOMAIN_MIN 0 0 0\nDOMAIN_MAX 0.5 0.5 0.5\nLUT_3D");
    let mut wide = EffectFile::parse("wide.cube", &domain).unwrap();
    wide.set("wide.strength", "0.5").unwrap();
    assert!(
        EffectFile::parse("wide.cube", "LUT_3D_SIZE 2\n").unwrap_err().to_string().starts_with("wide.cube:1:1: error")
    );
}

/// An effect on display colours that shows one colour, with more lines of its header.
fn flat(name: &str, header: &str, red: f32) -> String {
    format!(
        "//! effect {name}
        //! reads: display
        {header}
        @fragment fn fs_{name}(@builtin(position) position: vec4f) -> @location(0) vec4f {{
            return vec4f({red:.2}, 0.0, 0.0, 1.0) + 0.0 * textureLoad(display, vec2i(position.xy), 0);
        }}"
    )
}

#[test]
fn where_time_is_short_effects_are_drawn_as_the_cheaper_ones_that_they_name() {
    let (mut renderer, scene, plain) = drawn();
    let fxaa = common::built_in(&renderer, "fxaa") as Arc<dyn Effect>;
    let smaa = common::built_in(&renderer, "smaa") as Arc<dyn Effect>;
    let [stays, goes, falls] =
        [flat("stays", "", 0.25), flat("goes", "//! fallback: none", 0.5), flat("falls", "//! fallback: fxaa", 0.75)];
    let [stays, goes, falls] = [&stays, &goes, &falls].map(|source| effect(&renderer, source) as Arc<dyn Effect>);
    let display = |renderer: &mut Renderer, effects: &[&Arc<dyn Effect>], fallbacks: bool| {
        let effects = effects.iter().map(|effect| (*effect).clone()).collect();
        let request = FrameRequest { effects, ..plain.with(|settings| settings.effects.fallbacks = fallbacks) };
        renderer.render(&scene, &request).unwrap();
        renderer.read_display().unwrap()
    };
    let none = display(&mut renderer, &[], true);
    let with_fxaa = display(&mut renderer, &[&fxaa], false);
    let with_smaa = display(&mut renderer, &[&smaa], false);
    assert!(none != with_fxaa && with_fxaa != with_smaa && with_smaa != none, "three pictures");
    // Nothing changes where time is not short; where it is, another effect takes the place, or none.
    assert!(display(&mut renderer, &[&smaa], true) == with_fxaa);
    assert!(display(&mut renderer, &[&falls], true) == with_fxaa);
    assert!(display(&mut renderer, &[&goes], true) == none);
    assert!(display(&mut renderer, &[&goes], false) != none);
    assert!(display(&mut renderer, &[&stays], true) == display(&mut renderer, &[&stays], false));
    // One that is there anyway, or that two name, is drawn once.
    assert!(display(&mut renderer, &[&smaa, &fxaa], true) == with_fxaa);
    assert!(display(&mut renderer, &[&smaa, &falls], true) == with_fxaa);
    // An effect that is off has no place to take.
    let off = common::built_in(&renderer, "smaa");
    off.set("smaa.enabled", "false").unwrap();
    assert!(display(&mut renderer, &[&(off as Arc<dyn Effect>)], true) == none);
    // One whose textures others read stays.
    let source = "//! effect wide
        //! reads: display
        //! passes: fs_first -> wide_texture, fs_second
        //! fallback: none
        @fragment fn fs_first(@builtin(position) p: vec4f) -> @location(0) vec4f { return vec4f(0.5, 0.0, 0.0, 1.0); }
        @fragment fn fs_second(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return textureLoad(wide_texture, vec2i(p.xy), 0) + 0.0 * textureLoad(display, vec2i(p.xy), 0);
        }";
    let reader = "//! effect reader
        //! reads: display, wide.wide_texture
        @fragment fn fs_reader(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return textureLoad(wide_wide_texture, vec2i(p.xy), 0) + 0.0 * textureLoad(display, vec2i(p.xy), 0);
        }";
    let wide = effect(&renderer, source) as Arc<dyn Effect>;
    assert!(display(&mut renderer, &[&wide], true) == none);
    let reader = effect(&renderer, reader) as Arc<dyn Effect>;
    let both = [&wide, &reader];
    assert!(display(&mut renderer, &both, true) == display(&mut renderer, &both, false));
}

#[test]
fn another_text_has_another_fallback() {
    let (mut renderer, scene, plain) = drawn();
    let source = flat("mine", "//! fallback: fxaa", 0.5);
    let mine = effect(&renderer, &source);
    let request = plain.with(|settings| settings.effects.fallbacks = true);
    let request = FrameRequest { effects: vec![mine.clone()], ..request };
    let mut display = || {
        renderer.render(&scene, &request).unwrap();
        renderer.read_display().unwrap()
    };
    let (first, again) = (display(), display());
    assert!(first == again);
    mine.replace(&source.replace("fxaa", "none")).unwrap();
    let none = display();
    assert!(none != first);
    assert!(mine.replace(&source.replace("fxaa", "bloom")).unwrap_err().to_string().contains("an effect on radiance"));
    assert!(display() == none, "what is broken changes nothing");
}

/// Green of 1 where ids are looked at and a surface is, of 0.5 where they are not; blue what motion is taken to be.
fn conditional(name: &str) -> String {
    format!(
        "//! effect {name}
        //! reads: radiance, ids if by_object or numbers.more, motion if moves
        //! pixel: changed
        struct Numbers {{
            // = 0 in 0..1
            by_object: u32,
            // = 0
            more: f32,
            // = 0
            moves: f32,
            padding: f32,
        }}
        @group(2) @binding(0) var<uniform> numbers: Numbers;
        fn changed(color: vec4f, position: vec2f) -> vec4f {{
            let pixel = vec2i(position);
            var green = 0.5;
            if numbers.by_object != 0u || numbers.more != 0.0 {{ green = f32(min(textureLoad(ids, pixel, 0).r, 1u)); }}
            var blue = 0.5;
            if numbers.moves != 0.0 {{ blue = textureLoad(motion, pixel, 0).r; }}
            return vec4f(color.r, green, blue, color.a);
        }}"
    )
}

#[test]
fn what_is_read_for_some_settings_alone_is_there_only_with_them() {
    let (mut renderer, scene, mut request) = drawn();
    let [first, second] = ["first", "second"].map(|name| effect(&renderer, &conditional(name)));
    let passes = |renderer: &mut Renderer, request: &FrameRequest| -> Vec<String> {
        let plan = renderer.plan(&scene, request).unwrap();
        plan.passes.iter().map(|pass| pass.name.to_string()).filter(|name| name == "ids" || name == "motion").collect()
    };
    request.effects = vec![first.clone()];
    assert_eq!(passes(&mut renderer, &request), [] as [&str; 0]);
    // Green and blue of the pixel that has most of each: of a surface, where ids tell them apart.
    let of_surface = |pixels: Vec<f32>| {
        [1, 2].map(|channel| pixels.chunks_exact(4).map(|pixel| pixel[channel]).fold(f32::MIN, f32::max))
    };
    assert_eq!(of_surface(radiance(&mut renderer, &scene, &request)), [0.5, 0.5]);
    // Forward paths have none, and need none.
    let forward = request.with(|settings| settings.render.path = manypass::Path::Forward);
    assert_eq!(of_surface(radiance(&mut renderer, &scene, &forward)), [0.5, 0.5]);
    first.set("first.by_object", "1").unwrap();
    assert_eq!(passes(&mut renderer, &request), ["ids"]);
    assert_eq!(of_surface(radiance(&mut renderer, &scene, &request)), [1.0, 0.5]);
    let error = renderer.render(&scene, &forward).unwrap_err().to_string();
    assert!(error.contains("it reads `ids`, which this frame does not have"), "{error}");
    first.set("first.by_object", "0").unwrap();
    first.set("first.moves", "1").unwrap();
    assert_eq!(passes(&mut renderer, &request), ["motion"]);
    assert_eq!(of_surface(radiance(&mut renderer, &scene, &request)), [0.5, 0.0]);
    // Of two that share a pass either may want it.
    request.effects = vec![first.clone(), second.clone()];
    first.set("first.moves", "0").unwrap();
    assert_eq!(passes(&mut renderer, &request), [] as [&str; 0]);
    assert_eq!(of_surface(radiance(&mut renderer, &scene, &request)), [0.5, 0.5]);
    second.set("second.more", "-2").unwrap();
    assert_eq!(passes(&mut renderer, &request), ["ids"]);
    assert_eq!(of_surface(radiance(&mut renderer, &scene, &request)), [1.0, 0.5]);
    assert!(renderer.plan(&scene, &request).unwrap().passes.iter().any(|pass| pass.name == "first+second"));
    // What is off wants nothing.
    second.set("second.enabled", "false").unwrap();
    assert_eq!(passes(&mut renderer, &request), [] as [&str; 0]);
}

#[test]
fn settings_for_which_something_is_read_are_those_of_the_effect() {
    let text = conditional("mine").replace("ids if by_object", "ids if by_objects");
    let error = EffectFile::parse("mine.wgsl", &text).unwrap_err().to_string();
    assert!(
        error.contains("mine.wgsl:2:37: error: `by_objects` is no setting of the effect that is one number"),
        "{error}"
    );
    let vector =
        conditional("mine").replace("more: f32", "more: vec2f").replace("numbers.more != 0.0", "numbers.more.x != 0.0");
    let error =
        EffectFile::parse("mine.wgsl", &vector.replace("// = 0\n            more", "// = 0, 0\n            more"));
    assert!(error.unwrap_err().to_string().contains("`numbers.more` is no setting"));
}
