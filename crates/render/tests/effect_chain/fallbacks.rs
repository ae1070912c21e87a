//! Effects that are drawn as cheaper ones where time is short.

use super::{common, drawn, effect};
use manypass::{Effect, FrameRequest, Renderer};
use std::sync::Arc;

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
