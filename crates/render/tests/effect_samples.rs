//! The effects of docs/samples.md: the page names them and their settings, they say what these do, and they do something.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{self, plain_request, renderer, sample, sample_names, sample_with};
use manypass::gpu::Floor;
use manypass::{Effect, Gpu, Renderer, WgslEffect};
use manypass_testkit::scenes;
use std::sync::Arc;

const PAGE: &str = include_str!("../../../docs/samples.md");

#[test]
fn the_page_has_every_sample_and_all_of_its_settings() {
    for name in sample_names() {
        let effect = sample(&name);
        assert_eq!(effect.name(), name, "a sample's file is called as its effect");
        let link = format!("[`{name}`](examples/effects/{name}.wgsl)");
        let row = PAGE.lines().find(|line| line.contains(&link)).unwrap_or_else(|| panic!("no row has {link}"));
        let own = effect.settings().iter().filter(|setting| setting.key != format!("{name}.enabled"));
        for setting in own {
            let key = setting.key.rsplit('.').next().unwrap();
            assert!(row.contains(&format!("`{key}`")), "the row of {name} has no `{key}`");
            assert!(!setting.doc.is_empty(), "{}", setting.key);
            assert!(setting.default.is_some() && setting.min.is_some(), "{}", setting.key);
        }
    }
    let rows = PAGE.lines().filter(|line| line.contains("](examples/effects/")).count();
    assert_eq!(rows, sample_names().len());
}

#[test]
fn a_sample_of_pixels_shares_a_pass_with_its_neighbour() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).unwrap()).unwrap();
    renderer.load(&scene).unwrap();
    let mut request = plain_request(&scene, (64, 48));
    let compiled = |name: &str| -> Arc<dyn Effect> { sample_with(&renderer, name, &[]) };
    request.effects = ["thermal", "mist", "scanlines"].map(compiled).to_vec();
    request.effects.push(common::built_in(&renderer, "film"));
    let plan = renderer.plan(&scene, &request).unwrap();
    for name in ["thermal+mist", "scanlines+film"] {
        assert!(plan.passes.iter().any(|pass| pass.name == name), "{name}: {}", plan.to_text());
    }
}

/// A picture of one sample with `effects`.
fn drawn(renderer: &mut Renderer, scene: &scenes::TestScene, effects: Vec<Arc<WgslEffect>>) -> Vec<u8> {
    let mut request = plain_request(&scene.scene, (64, 48));
    request.effects = effects.into_iter().map(|effect| effect as Arc<dyn Effect>).collect();
    renderer.render(&scene.scene, &request).unwrap();
    renderer.read_display().unwrap()
}

#[test]
fn each_setting_of_a_sample_does_something_and_no_value_of_it_is_too_much() {
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let plain = drawn(&mut renderer, &test, Vec::new());
    // So that what is looked for is there: the nodes that are chosen, glow to be reflected, mist in front of things.
    let shown = |name: &str| match name {
        "chosen" => vec!["nodes=0,5"],
        "flare" => vec!["strength=8"],
        "mist" => vec!["color=0.5,0.5,0.5", "half_m=1"],
        "glitch" => vec!["bands=0.9", "slip=0.4", "band_px=5"],
        _ => Vec::new(),
    };
    for name in sample_names() {
        let with = |renderer: &Renderer, key_and_value: Option<(&str, &str)>| {
            let effect = sample_with(renderer, &name, &shown(&name));
            if let Some((key, value)) = key_and_value {
                effect.set(key, value).unwrap();
            }
            let before = (name == "flare").then(|| common::built_in_with(renderer, "glow", &["threshold=0"]));
            before.into_iter().chain([effect]).collect::<Vec<_>>()
        };
        let effects = with(&renderer, None);
        let usual = drawn(&mut renderer, &test, effects);
        // A still has no frame before it.
        assert_eq!(usual == plain, name == "trails", "{name}");
        for setting in sample(&name).settings().iter().filter(|setting| setting.min.is_some()) {
            let key = setting.key.as_ref();
            let components = setting.default.as_ref().unwrap().to_string().split(',').count();
            let mut changes = false;
            for value in [setting.min.unwrap(), setting.max.unwrap_or(1e6)] {
                let value = vec![format!("{value}"); components].join(",");
                let effects = with(&renderer, Some((key, &value)));
                let found = drawn(&mut renderer, &test, effects);
                changes |= found != usual;
            }
            assert!(changes || name == "trails", "{key} changes nothing");
        }
    }
    renderer.gpu().check().unwrap();
}
