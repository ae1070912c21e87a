//! Built-in effects at the ends of their settings, and chains longer than anyone's.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::{built_in, plain_request, renderer};
use manypass::settings::{Scalar, SettingType};
use manypass::{Effect, EffectFile, FrameRequest, Pose, Renderer, SettingInfo, WgslEffect};
use manypass_testkit::scenes;
use std::sync::Arc;

fn effect(renderer: &Renderer, source: &str) -> Arc<WgslEffect> {
    Arc::new(WgslEffect::new(renderer.gpu(), "mine.wgsl", source).unwrap_or_else(|error| panic!("{error}")))
}

/// The least and the largest value of a setting, or what is next to the largest number where there is no limit.
fn ends(info: &SettingInfo) -> [String; 2] {
    match &info.kind {
        SettingType::Boolean => ["false".into(), "true".into()],
        SettingType::Number(kind) => {
            let far = match kind.scalar {
                Scalar::F32 => [-1e38, 1e38],
                Scalar::I32 => [f64::from(i32::MIN), f64::from(i32::MAX)],
                Scalar::U32 => [0.0, f64::from(u32::MAX)],
            };
            let ends = [info.min.unwrap_or(far[0]), info.max.unwrap_or(far[1])];
            ends.map(|end| vec![end.to_string(); usize::from(kind.count)].join(","))
        }
        kind => panic!("{} is a {kind}", info.key),
    }
}

#[test]
fn built_in_effects_leave_numbers_at_the_ends_of_their_settings() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = plain_request(&scene, (33, 18));
    let mut before = request.camera;
    before.world_from_view.w_axis += 0.5 * before.world_from_view.x_axis;
    request.previous = Some(Arc::new(Pose::capture(&scene, before)));
    // All that radiance can be, black and the brightest side by side; and the picture itself.
    let drawing = effect(
        &renderer,
        "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
            let noise = fract(sin(dot(floor(position.xy), vec2f(12.9898, 78.233))) * vec3f(43758.5, 23421.6, 9182.1));
            let strong = select(pow(noise, vec3f(20.0)) * 20000.0, vec3f(0.0), noise < vec3f(0.3));
            let here = radiance_at(vec2i(position.xy));
            return select(vec4f(strong, noise.x), here, position.x < 12.0);
        }",
    );
    let mut drawn = 0;
    for name in EffectFile::built_in_names() {
        let tried = built_in(&renderer, name);
        request.effects = vec![drawing.clone(), tried.clone()];
        let mut draw = |what: &str| {
            let count = renderer.count_scrubbed(&scene, &request).unwrap();
            assert_eq!(count, 0, "pixels that are no numbers of {name} with {what}");
            drawn += 1;
        };
        let settings = tried.settings();
        for info in &settings {
            for end in ends(info) {
                tried.set(&info.key, &end).unwrap_or_else(|error| panic!("{error}"));
                draw(&format!("{}={end}", info.key));
            }
            tried.set(&info.key, &info.default.as_ref().unwrap().to_string()).unwrap();
        }
        // All of them at once.
        for side in [0, 1] {
            for info in settings.iter().filter(|info| info.kind != SettingType::Boolean) {
                tried.set(&info.key, &ends(info)[side]).unwrap();
            }
            draw(["all at their least", "all at their largest"][side]);
        }
    }
    assert!(drawn > 100, "{drawn} pictures");
}

#[test]
fn a_hundred_effects_that_cannot_be_drawn_together_are_drawn_one_after_the_other() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let plain = plain_request(&scene, (40, 30));
    let chain = |renderer: &Renderer, count: usize| -> Vec<Arc<dyn Effect>> {
        let of = |index: usize| -> Arc<dyn Effect> {
            effect(
                renderer,
                &format!(
                    "//! effect n{index}
                    @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                        let beside = radiance_at(vec2i(i32(p.x) - 1, i32(p.y)));
                        return vec4f(select(beside.rgb, vec3f({index}.0), p.x < 1.0), 1.0);
                    }}"
                ),
            )
        };
        (0..count).map(of).collect()
    };
    let mut request = FrameRequest { effects: chain(&renderer, 100), ..plain };
    renderer.render(&scene, &request).unwrap();
    let found = renderer.read_radiance().unwrap();
    // Each moves all before it by a pixel, and leaves its number in the first column: the last forty are to be seen.
    for (at, pixel) in found.chunks_exact(4).enumerate() {
        assert_eq!(pixel[0], (99 - at % 40) as f32, "pixel {at}");
    }
    // They need no more memory than four of them.
    let many = renderer.plan(&scene, &request).unwrap();
    let drawn = many.passes.iter().filter(|pass| pass.name.starts_with('n')).count();
    assert!(drawn >= 100, "{}", many.to_text());
    request.effects.truncate(4);
    let few = renderer.plan(&scene, &request).unwrap();
    assert_eq!(many.bytes().aliased, few.bytes().aliased);
    assert!(many.bytes().unaliased > 10 * few.bytes().unaliased, "{:?}", many.bytes());
}
