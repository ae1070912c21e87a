//! What effects read of the frame for some of their settings alone.

use super::{drawn, effect, radiance};
use manypass::{EffectFile, FrameRequest, Renderer};

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
        error.contains("mine.wgsl:2:37: error: `by_objects` is not a setting of the effect with one number"),
        "{error}"
    );
    let vector =
        conditional("mine").replace("more: f32", "more: vec2f").replace("numbers.more != 0.0", "numbers.more.x != 0.0");
    let error =
        EffectFile::parse("mine.wgsl", &vector.replace("// = 0\n            more", "// = 0, 0\n            more"));
    assert!(error.unwrap_err().to_string().contains("`numbers.more` is not a setting"));
}
