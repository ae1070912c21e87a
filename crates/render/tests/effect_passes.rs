//! Effects of several passes, and those on display colours: what they make, and what is said where they are wrong.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{built_in, plain_request, renderer};
use manypass::{Averaging, Background, EffectFile, EffectStage, FrameRequest, Renderer, Tonemap, WgslEffect};
use manypass_scene::Scene;
use manypass_testkit::scenes;
use std::sync::Arc;

const SIZE: (u32, u32) = (65, 65);

/// One bright pixel in the middle.
const IMPULSE: &str = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
    return vec4f(select(0.0, 1000.0, all(vec2i(p.xy) == vec2i(32))));
}";

fn effect(renderer: &Renderer, source: &str) -> Arc<WgslEffect> {
    Arc::new(WgslEffect::new(renderer.gpu(), "mine.wgsl", source).unwrap_or_else(|error| panic!("{error}")))
}

/// A renderer and something to draw.
fn drawn() -> (Renderer, Scene, FrameRequest) {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = plain_request(&scene, SIZE);
    (renderer, scene, request)
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap()
}

/// The picture of so many samples.
fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<u8> {
    let request = FrameRequest { sample_count: samples, ..request.clone() };
    for sample_index in 0..samples {
        let request = FrameRequest { sample_index, ..request.clone() };
        if sample_index + 1 < samples {
            renderer.accumulate(scene, &request).unwrap();
        } else {
            renderer.render(scene, &request).unwrap();
        }
    }
    renderer.read_display().unwrap()
}

#[test]
fn a_blur_keeps_energy_and_is_the_same_in_every_direction() {
    let (mut renderer, scene, mut request) = drawn();
    let blur = built_in(&renderer, "blur");
    blur.set("blur.sigma_px", "5").unwrap();
    request.effects = vec![effect(&renderer, IMPULSE), blur];
    let blurred = radiance(&mut renderer, &scene, &request);
    let at = |x: usize, y: usize| f64::from(blurred[4 * (y * SIZE.0 as usize + x)]);
    let sum: f64 = blurred.chunks_exact(4).map(|pixel| f64::from(pixel[0])).sum();
    assert!((sum / 1000.0 - 1.0).abs() < 0.01, "{sum}");
    let peak = 1000.0 / (2.0 * std::f64::consts::PI * 25.0);
    for distance in 0..15 {
        let expected = peak * (-0.5 * (distance as f64 / 5.0).powi(2)).exp();
        let around = [at(32 + distance, 32), at(32 - distance, 32), at(32, 32 + distance), at(32, 32 - distance)];
        for found in around {
            assert!((found / expected - 1.0).abs() < 0.03, "{distance}: {found} instead of {expected}");
        }
        let [most, least] = [f64::max, f64::min].map(|of| around.into_iter().reduce(of).unwrap());
        assert!(most / least < 1.01, "{distance}: {around:?}");
    }
    // In between, too: 9 and 12 are a triangle's sides of 15, 6 and 8 of 10, 3 and 4 of 5. And along the diagonal, at the
    // distance of √2 · d, between those along the axis.
    for (across, down, distance) in [(9, 12, 15), (12, 9, 15), (6, 8, 10), (3, 4, 5)] {
        let [between, along] = [at(32 + across, 32 + down), at(32 + distance, 32)];
        println!("{distance} px away: {between:.4} between the axes, {along:.4} along one");
        assert!((between / along - 1.0).abs() < 0.01, "{distance}: {between} {along}");
    }
    for distance in 1..=10 {
        let expected = peak * (-(distance as f64 / 5.0).powi(2)).exp();
        let found = at(32 + distance, 32 + distance);
        println!("{distance}, {distance}: {:.4} of the bell curve", found / expected);
        assert!((found / expected - 1.0).abs() < 0.03, "{distance}: {found} instead of {expected}");
    }
}

#[test]
fn a_blur_in_one_direction_leaves_all_light_in_its_row_or_column() {
    let (mut renderer, scene, mut request) = drawn();
    let blur = built_in(&renderer, "blur");
    blur.set("blur.sigma_px", "5").unwrap();
    request.effects = vec![effect(&renderer, IMPULSE), blur.clone()];
    // Of one dimension.
    let peak = 1000.0 / (5.0 * (2.0 * std::f64::consts::PI).sqrt());
    for (direction, step) in [("1,0", (1, 0)), ("0,1", (0, 1))] {
        blur.set("blur.direction", direction).unwrap();
        let blurred = radiance(&mut renderer, &scene, &request);
        let at = |x: usize, y: usize| f64::from(blurred[4 * (y * SIZE.0 as usize + x)]);
        let sum: f64 = blurred.chunks_exact(4).map(|pixel| f64::from(pixel[0])).sum();
        assert!((sum / 1000.0 - 1.0).abs() < 0.01, "{direction}: {sum}");
        for distance in 0..15 {
            let expected = peak * (-0.5 * (distance as f64 / 5.0).powi(2)).exp();
            let along = at(32 + step.0 * distance, 32 + step.1 * distance);
            assert!((along / expected - 1.0).abs() < 0.03, "{direction}, {distance}: {along} instead of {expected}");
            let across = at(32 + step.1 * (distance + 1), 32 + step.0 * (distance + 1));
            assert!(across < 0.01 * peak, "{direction}, {distance}: {across} beside it");
        }
    }
}

#[test]
fn a_pass_is_drawn_as_often_as_its_setting_says() {
    let (mut renderer, scene, mut request) = drawn();
    let count = effect(
        &renderer,
        "//! effect count
        //! passes: fs_begin -> number 1/4, fs_add -> number 1/4 x rounds, fs_add -> number 1/4 x 2, fs_end
        // = 3 in 1..8
        @group(2) @binding(0) var<uniform> rounds: u32;
        fn here(p: vec4f) -> vec4f { return textureLoad(number, vec2i(p.xy), 0); }
        @fragment fn fs_begin(@builtin(position) p: vec4f) -> @location(0) vec4f { return vec4f(drawn.size_px.x, 0.0, 0.0, 1.0); }
        @fragment fn fs_add(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return here(p) + vec4f(0.0, 1.0, f32(drawn.round) + 100.0 * f32(drawn.rounds), 0.0);
        }
        @fragment fn fs_end(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return textureSampleLevel(number, nearest_clamp, uv_at(p.xy), 0.0) + 0.0 * f32(rounds);
        }",
    );
    request.effects = vec![count.clone()];
    // 65 / 4, rounded up.
    let expected = |rounds: f32, sum: f32| [17.0, rounds + 2.0, sum + 401.0, 1.0];
    let found = radiance(&mut renderer, &scene, &request);
    assert!(found.chunks_exact(4).all(|pixel| pixel == expected(3.0, 903.0)), "{:?}", &found[..4]);
    count.set("count.rounds", "1").unwrap();
    let found = radiance(&mut renderer, &scene, &request);
    assert!(found.chunks_exact(4).all(|pixel| pixel == expected(1.0, 100.0)), "{:?}", &found[..4]);
    let plan = format!("{:?}", renderer.plan(&scene, &request).unwrap());
    // Of one function three rounds in two passes, each with a name of its own.
    for name in ["count.begin", "count.add", "count.add.2", "count.add.3", "count.end"] {
        assert!(plan.contains(&format!("\"{name}\"")), "{name} in\n{plan}");
    }
}

#[test]
fn display_colours_come_after_the_curve_and_over_the_background() {
    let (mut renderer, scene, mut request) = drawn();
    request.settings.tone_map.dither = 0.0;
    request.settings.tone_map.curve = Tonemap::Neutral;
    request.averaging = Averaging::Display;
    let same = effect(
        &renderer,
        "//! reads: display
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return display_at(vec2i(p.xy)); }",
    );
    assert_eq!(manypass::Effect::stage(&*same), EffectStage::Display);
    let backgrounds = [
        Background::Transparent,
        Background::Color([0.2, 0.4, 0.8]),
        Background::Gradient([[0.1, 0.2, 0.4], [0.8, 0.6, 0.2]]),
    ];
    for background in backgrounds {
        for samples in [1, 4] {
            request.settings.background.source = background;
            request.effects.clear();
            let plain = picture(&mut renderer, &scene, &request, samples);
            request.effects = vec![same.clone()];
            let through = picture(&mut renderer, &scene, &request, samples);
            let off = plain.iter().zip(&through).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(off <= 1, "{background:?}, {samples} samples: {off}");
        }
    }
    // What an effect on radiance makes goes through the curve, what one on display colours makes does not.
    let grey = |reads: &str| {
        let source = format!(
            "//! reads: {reads}
            @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                return vec4f(vec3f(0.9), 1.0) + 0.0 * {reads}_at(vec2i(p.xy));
            }}"
        );
        effect(&renderer, &source)
    };
    let [of_radiance, of_display] = ["radiance", "display"].map(grey);
    let mut found = [of_radiance, of_display].map(|effect| {
        request.effects = vec![effect];
        picture(&mut renderer, &scene, &request, 1)[0]
    });
    assert_eq!(found[1], 243, "0.9 in sRGB");
    found.sort_unstable();
    assert!(found[0] < 240, "{found:?}");
    // Effects of one stage follow each other, whatever stands between them in the list.
    let double = |reads: &str| {
        let source = format!(
            "//! reads: {reads}
            @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                return vec4f({reads}_at(vec2i(p.xy)).rgb * 0.5, 1.0);
            }}"
        );
        effect(&renderer, &source)
    };
    let [on_radiance, on_display] = ["radiance", "display"].map(double);
    request.effects = vec![on_display.clone(), on_radiance.clone()];
    let first = picture(&mut renderer, &scene, &request, 1);
    request.effects = vec![on_radiance, on_display];
    assert_eq!(picture(&mut renderer, &scene, &request, 1), first);
}

#[test]
fn effects_on_display_colours_let_later_samples_leave_tiles_out() {
    let (mut renderer, scene, mut request) = drawn();
    request.averaging = Averaging::Display;
    request.effects = vec![effect(
        &renderer,
        "//! reads: display, previous
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return vec4f(previous_at(vec2i(p.xy)).rgb * 0.0 + display_at(vec2i(p.xy)).rgb, 1.0);
        }",
    )];
    let with = picture(&mut renderer, &scene, &request, 16);
    assert!(renderer.read_samples_mean().unwrap() < 16.0, "settled tiles are left out as without effects");
    request.effects.clear();
    let without = picture(&mut renderer, &scene, &request, 16);
    let off = with.iter().zip(&without).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert_eq!(off, 0);
}

#[test]
fn what_is_shown_of_one_picture_is_not_in_the_next() {
    let (mut renderer, scene, mut request) = drawn();
    request.averaging = Averaging::Display;
    let trail = effect(
        &renderer,
        "//! reads: display, previous
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return vec4f(0.5 * previous_at(vec2i(p.xy)).rgb + 0.25 * display_at(vec2i(p.xy)).rgb, 1.0);
        }",
    );
    request.effects = vec![trail];
    let alone = picture(&mut renderer, &scene, &request, 4);
    let bright = request.with(|settings| settings.exposure.stops = manypass::Exposure::Stops(4.0));
    picture(&mut renderer, &scene, &bright, 4);
    assert_eq!(picture(&mut renderer, &scene, &request, 4), alone);
    // A live view goes on with what it showed.
    let live = FrameRequest { goes_on: true, ..request.clone() };
    picture(&mut renderer, &scene, &bright, 1);
    assert_ne!(picture(&mut renderer, &scene, &live, 1), alone);
}

#[test]
fn display_colours_have_the_size_of_the_picture() {
    let (mut renderer, scene, mut request) = drawn();
    request.settings.tone_map.dither = 0.0;
    request.effects = vec![effect(
        &renderer,
        "//! reads: display
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return vec4f(uv_at(p.xy), 0.0, 1.0) + 0.0 * display_at(vec2i(p.xy));
        }",
    )];
    let whole = picture(&mut renderer, &scene, &request, 1);
    assert_eq!(whole[whole.len() - 4..whole.len() - 2], [254, 254]);
    request.settings.render.scale = 0.5;
    assert_eq!(picture(&mut renderer, &scene, &request, 1), whole);
}

#[test]
fn an_effect_that_is_off_is_as_if_it_were_not_listed() {
    let (mut renderer, scene, mut request) = drawn();
    request.averaging = Averaging::Display;
    request.settings.background.source = Background::Color([0.2, 0.4, 0.8]);
    let plain = picture(&mut renderer, &scene, &request, 16);
    let samples = renderer.read_samples_mean().unwrap();
    for (name, key) in [("film", "film.enabled"), ("glow", "glow.enabled")] {
        let effect = built_in(&renderer, name);
        effect.set(key, "false").unwrap();
        request.effects = vec![effect];
        assert_eq!(picture(&mut renderer, &scene, &request, 16), plain, "{key}");
        assert_eq!(renderer.read_samples_mean().unwrap(), samples, "{key}");
    }
}

#[test]
fn built_in_effects_with_nothing_to_do_leave_the_picture() {
    let (mut renderer, scene, mut request) = drawn();
    request.settings.tone_map.dither = 0.0;
    let mut before = request.camera;
    before.world_from_view.w_axis += 0.2 * before.world_from_view.x_axis;
    request.previous = Some(Arc::new(manypass::Pose::capture(&scene, before)));
    let plain = picture(&mut renderer, &scene, &request, 1);
    let nothing = [
        ("bloom", "strength", "0"),
        ("blur", "sigma_px", "0.1"),
        ("dof", "f_stop", "1024"),
        ("film", "enabled", "false"),
        ("fxaa", "threshold_dark", "1"),
        ("glow", "strength", "0"),
        ("grade", "contrast", "1"),
        ("lens", "enabled", "false"),
        ("motion_blur", "shutter", "0"),
        ("outline", "strength", "0"),
        ("sharpen", "strength", "0"),
        ("smaa", "threshold", "1"),
        ("toon", "realism", "1"),
    ];
    // As they are, all but these do something.
    let something = [("grade", "grade.contrast", "1.2"), ("dof", "dof.f_stop", "0.05")];
    assert!(EffectFile::built_in_names().eq(nothing.map(|(name, ..)| name)), "every one has its line here");
    assert!(EffectFile::built_in("blom").is_none() && !EffectFile::is_built_in("blom"));
    for (name, setting, value) in nothing {
        let effect = built_in(&renderer, name);
        assert_eq!(effect.name(), name);
        assert!(effect.settings().iter().all(|info| info.default.is_some() && !info.doc.is_empty()), "{name}");
        for (_, key, value) in something.iter().filter(|(changed, ..)| *changed == name) {
            effect.set(key, value).unwrap();
        }
        request.effects = vec![effect.clone()];
        assert_ne!(picture(&mut renderer, &scene, &request, 1), plain, "{name}");
        effect.set(&format!("{name}.{setting}"), value).unwrap();
        let without = picture(&mut renderer, &scene, &request, 1);
        let far = without.iter().zip(&plain).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(far <= 1, "{name}: {far}");
    }
}

#[test]
fn bloom_spreads_light_and_adds_none() {
    let (mut renderer, scene, mut request) = drawn();
    let bloom = built_in(&renderer, "bloom");
    bloom.set("bloom.strength", "0.5").unwrap();
    let flat = effect(&renderer, "@fragment fn fs() -> @location(0) vec4f { return vec4f(0.25, 0.5, 2.0, 1.0); }");
    request.effects = vec![flat, bloom.clone()];
    let found = radiance(&mut renderer, &scene, &request);
    let far = found.chunks_exact(4).flat_map(|pixel| [pixel[0] - 0.25, pixel[1] - 0.5, pixel[2] - 2.0, pixel[3] - 1.0]);
    assert!(far.map(f32::abs).fold(0.0, f32::max) < 0.004, "what is flat stays flat");
    // Far from the edges, where nothing is lost. A threshold leaves what is darker where it was.
    (request.width, request.height) = (256, 256);
    for threshold in ["0", "500"] {
        bloom.set("bloom.threshold", threshold).unwrap();
        bloom.set("bloom.spread", "0.5").unwrap();
        let middle = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return vec4f(select(0.0, 1000.0, all(vec2i(p.xy) / 4 == vec2i(32))));
        }";
        request.effects = vec![effect(&renderer, middle), bloom.clone()];
        let found = radiance(&mut renderer, &scene, &request);
        let sum: f64 = found.chunks_exact(4).map(|pixel| f64::from(pixel[0])).sum();
        assert!((sum / 16_000.0 - 1.0).abs() < 0.01, "{sum}");
        let of = |x: usize, y: usize| found[4 * (y * 256 + x)];
        assert!(of(130, 130) < 900.0 && of(120, 130) > 0.1, "{} {}", of(130, 130), of(120, 130));
    }
}

#[test]
fn fxaa_smooths_edges_and_leaves_flat_areas_alone() {
    let (mut renderer, scene, mut request) = drawn();
    request.settings.tone_map.dither = 0.0;
    let plain = picture(&mut renderer, &scene, &request, 1);
    let reference = picture(&mut renderer, &scene, &request, 64);
    let fxaa = built_in(&renderer, "fxaa");
    request.effects = vec![fxaa.clone()];
    let smooth = picture(&mut renderer, &scene, &request, 1);
    let rms = |picture: &[u8]| {
        let squares = picture.iter().zip(&reference).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
        (squares.sum::<f64>() / picture.len() as f64).sqrt()
    };
    println!("rms to 64 samples: {:.2} with, {:.2} without", rms(&smooth), rms(&plain));
    assert!(rms(&smooth) < 0.7 * rms(&plain));
    // Pixels that differ little from those around them are as they were.
    let at = |x: usize, y: usize| &plain[4 * (y * SIZE.0 as usize + x)..][..4];
    let (mut flat, mut changed) = (0, 0);
    for (x, y) in (1..SIZE.0 as usize - 1).flat_map(|x| (1..SIZE.1 as usize - 1).map(move |y| (x, y))) {
        let around = [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)];
        if around.iter().flat_map(|other| other.iter().zip(at(x, y))).all(|(a, b)| a.abs_diff(*b) < 4) {
            flat += 1;
            changed += u32::from(smooth[4 * (y * SIZE.0 as usize + x)..][..4] != *at(x, y));
        }
    }
    assert!(flat > 500 && changed == 0, "{changed} of {flat}");
}

#[test]
fn sharpening_makes_no_halos() {
    let (mut renderer, scene, mut request) = drawn();
    request.settings.tone_map.dither = 0.0;
    let plain = picture(&mut renderer, &scene, &request, 1);
    request.effects = vec![built_in(&renderer, "sharpen")];
    let sharp = picture(&mut renderer, &scene, &request, 1);
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    for (x, y) in (1..width - 1).flat_map(|x| (1..height - 1).map(move |y| (x, y))) {
        for channel in 0..3 {
            let at = |x: usize, y: usize| 4 * (y * width + x) + channel;
            let around = [at(x, y), at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)].map(|at| plain[at]);
            let [low, high] = [around.iter().min(), around.iter().max()].map(|found| *found.unwrap());
            let found = sharp[at(x, y)];
            assert!(
                found >= low.saturating_sub(1) && found <= high.saturating_add(1),
                "{found} at {x}, {y} of {around:?}"
            );
        }
    }
}

#[test]
fn built_in_effects_are_named_wherever_they_are_listed() {
    let help = include_str!("../../cli/src/args/frame.rs");
    let page = include_str!("../../web/module/manypass_settings.d.ts");
    let docs = include_str!("../../../docs/effects.md");
    let help = help.split("Built in are ").nth(1).and_then(|rest| rest.split(';').next()).unwrap();
    for name in EffectFile::built_in_names() {
        assert!(help.contains(name), "--help lacks {name}");
        assert!(page.contains(&format!("\"{name}\"")), "the page's types lack {name}");
        assert!(docs.contains(&format!("| `{name}` |")), "docs/effects.md lacks {name}");
    }
}

#[test]
fn wrong_lists_of_passes_are_errors_that_say_where() {
    let main = |name: &str, body: &str| {
        format!("@fragment fn {name}(@builtin(position) p: vec4f) -> @location(0) vec4f {{ return {body}; }}\n")
    };
    let load = |name: &str| format!("textureLoad({name}, vec2i(p.xy), 0)");
    let (a, b) = (main("fs_a", "p"), main("fs_b", "p"));
    let [goes_on, reads_wide] = ["fs_c", "fs_b"].map(|name| main(name, &load("wide")));
    for (source, expected) in [
        (format!("{a}{b}"), "mine.wgsl:2:14: error: an effect of 2 passes says in its header"),
        (format!("{a}{b}"), "`//! passes: fs_a -> TEXTURE, fs_b`"),
        (format!("//! passes: fs_a\n{a}{b}"), "`fs_b` is not a pass of the line"),
        (format!("//! passes: fs_a -> wide, fs_c\n{a}{b}"), "there is no `@fragment` function `fs_c`"),
        (format!("//! passes: fs_a -> wide, fs_b\n{a}{b}"), "no later pass reads `wide`"),
        (format!("//! passes: fs_b -> wide, fs_a\n{a}{reads_wide}"), "`fs_b` reads `wide`, which no pass before"),
        (
            format!("//! passes: fs_a -> wide, fs_c -> wide x many, fs_b\n{a}{goes_on}{reads_wide}"),
            "`many` is not a number of rounds",
        ),
        (
            format!(
                "//! passes: fs_a -> wide, fs_c -> wide x many, fs_b\n// = 3 in 1..\n@group(2) @binding(0) var<uniform> many: u32;\n\
                 {a}{goes_on}{reads_wide}"
            ),
            "`many` is not a number of rounds",
        ),
        (format!("//! passes: fs_a -> wide, fs_b\n{a}{}", main("fs_b", &load("wider"))), "`wider`"),
        (format!("//! reads: display, radiance\n{}", main("fs", &load("display"))), "cannot read `radiance`"),
        (
            format!("//! reads: display\n{}", main("fs", "radiance_at(vec2i(0)) + display_at(vec2i(0))")),
            "cannot read `radiance`",
        ),
        (format!("//! reads: display\n{a}"), "reads `display` in one of its passes"),
        (main("fs", &load("display")), "`//! reads: display` in the header declares it"),
        (main("fs", "vec4f(uv_at(p.xy), 0.0, 0.0)"), "a list of several `//! passes:`"),
        (format!("//! passes: fs_a -> fn, fs_b\n{a}{b}"), "mine.wgsl:1:13: error: a texture cannot be called `fn`"),
        (format!("//! passes: fs_a -> depth, fs_b\n{a}{b}"), "a texture cannot be called `depth`"),
        (format!("//! passes: fs_a -> radiance, fs_b\n{a}{b}"), "a texture cannot be called `radiance`"),
        (format!("//! passes: fs_a -> max, fs_b\n{a}{b}"), "a texture cannot be called `max`"),
        (format!("//! passes: fs_a -> vec4f, fs_b\n{a}{b}"), "a texture cannot be called `vec4f`"),
        (format!("//! passes: fs_a -> view, fs_b\n{a}{b}"), "a texture cannot be called `view`"),
        (format!("//! passes: fs_a -> uv_at, fs_b\n{a}{b}"), "a texture cannot be called `uv_at`"),
        (format!("//! passes: fs_a -> fs_b, fs_b\n{a}{b}"), "a texture cannot be called `fs_b`"),
        (format!("//! passes: fs_a -> S, fs_b\nstruct S {{ x: f32 }}\n{a}{b}"), "a texture cannot be called `S`"),
        (format!("//! passes: fs_a -> wide x 2, fs_b\n{a}{reads_wide}"), "of its rounds only the last would count"),
    ] {
        let error = EffectFile::parse("mine.wgsl", &source).map(drop).unwrap_err().to_string();
        assert!(
            error.starts_with("mine.wgsl:") && error.contains(expected),
            "{source}\n{error}\nshould say {expected}"
        );
    }
    let count = 17;
    let names: Vec<String> = (0..count).map(|at| format!("t{at}")).collect();
    let list: String = names.iter().map(|name| format!("fs_a -> {name}, ")).collect();
    let sum = names.iter().map(|name| load(name)).collect::<Vec<_>>().join(" + ");
    let many = format!("//! passes: {list}fs_b\n{a}{}", main("fs_b", &sum));
    let error = EffectFile::parse("mine.wgsl", &many).map(drop).unwrap_err().to_string();
    assert!(error.contains("`fs_b` reads 17 textures; a pass reads at most 10"), "{error}");
    // Two uniforms have a member of the same name, so that it is called by both.
    let both = "// = 2 in 1..4\n{}: u32, padding_a: u32, padding_b: u32, padding_c: u32 }";
    let [first, second] = ["A", "B"].map(|name| format!("struct {name} {{\n{}", both.replace("{}", "rounds")));
    let source = format!(
        "//! passes: fs_a -> wide, fs_c -> wide x b.rounds, fs_b\n{first}\n{second}\n\
         @group(2) @binding(0) var<uniform> a: A;\n@group(2) @binding(1) var<uniform> b: B;\n{a}{}{}",
        main("fs_c", &load("wide")),
        main("fs_b", &format!("{} + f32(a.rounds + b.rounds)", load("wide"))),
    );
    let parsed = EffectFile::parse("mine.wgsl", &source).unwrap_or_else(|error| panic!("{error}"));
    assert!(parsed.has("mine.b.rounds"));
    // Names that only words of a header declare are free without them.
    let own = format!("const drawn = 1.0;\nfn uv_at() -> f32 {{ return drawn; }}\nfn display_at() {{ }}\n{a}");
    EffectFile::parse("mine.wgsl", &own).unwrap_or_else(|error| panic!("{error}"));
}
