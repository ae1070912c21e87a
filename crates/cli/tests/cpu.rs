//! What pictures take of processors, beside others of the same program on the same machine, however fast that is and
//! whatever else it does.

#![cfg(target_os = "linux")]

mod common;

use common::watch::{start_with, wait};
use common::{Folder, has_adapter, run_in};
use manypass_testkit::growth::GrowthAxis;
use manypass_testkit::needs;
use std::time::Duration;

/// Seconds of processors that a run takes.
fn cpu_s(folder: &Folder, args: &[&str], variables: &[(&str, &str)]) -> f64 {
    let variables = [&[("MANYPASS_NO_CACHE", "1")][..], variables].concat();
    let watched = wait(start_with(folder, args, &variables), Duration::from_secs(120));
    assert_eq!(watched.run.code, 0, "{}", watched.run.stderr);
    assert!(!watched.cpu.is_zero(), "nothing was measured");
    watched.cpu.as_secs_f64()
}

/// A file with each `from` of its bytes as `to`, which is as long.
fn replaced(mut bytes: Vec<u8>, from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let places = Vec::from_iter((0..bytes.len()).filter(|at| bytes[*at..].starts_with(from)));
    assert!(!places.is_empty(), "there is nothing to replace");
    for at in places {
        bytes[at..at + to.len()].copy_from_slice(to);
    }
    bytes
}

/// Glass took 30 to 44 s of processors, since the driver compiled its shaders anew in every sample.
#[test]
fn glass_takes_at_most_four_times_what_the_same_model_takes_opaque() {
    let Some(models) = needs::assets("khronos-sample-assets/Models/AttenuationTest/glTF-Binary") else { return };
    if !has_adapter() {
        return;
    }
    let glass = std::fs::read(models.join("AttenuationTest.glb")).expect("a model");
    let folder = Folder::new("cpu-glass");
    folder.write("opaque.glb", &replaced(glass.clone(), b"KHR_materials_transmission", b"XXX_materials_transmission"));
    folder.write("glass.glb", &glass);
    let take = |model: &str, cache: &str| {
        // Nothing is compiled before, so that both compile all that they draw with. Reflections, which both have, take
        // most of that, and would hide the difference.
        std::fs::create_dir(folder.join(cache)).expect("a folder");
        let cache = folder.join(cache).to_string_lossy().into_owned();
        let still = ["render", model, "-o", "a.png", "--size", "64x64", "--set", "reflections.enabled=false", "-q"];
        cpu_s(&folder, &still, &[("MESA_SHADER_CACHE_DIR", cache.as_str())])
    };
    let (opaque_s, glass_s) = (take("opaque.glb", "a"), take("glass.glb", "b"));
    println!("{glass_s:.2} s of glass, {opaque_s:.2} s opaque");
    // 2.1 times, as measured; 9 times when every sample compiled.
    assert!(glass_s < 4.0 * opaque_s, "{glass_s} s of glass, {opaque_s} s opaque");
}

/// Later samples leave out points that are settled, and what lies behind others.
#[test]
fn sixteen_samples_of_many_points_take_at_most_four_times_what_one_takes() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("cpu-points");
    folder.write("cloud.ply", GrowthAxis::Points.text(100_000).as_bytes());
    // The driver keeps its compiled shaders, for all that follows.
    run_in(&folder, &["render", "cloud.ply", "-o", "a.png", "--size", "16x9", "-q"]).expect(0);
    let take = |samples: &str| cpu_s(&folder, &["render", "cloud.ply", "-o", "a.png", "--samples", samples, "-q"], &[]);
    let (one_s, all_s) = (take("1"), take("16"));
    println!("{one_s:.2} s for one sample, {all_s:.2} s for 16");
    // 2.4 times, as measured; 3.2 times before samples left anything out.
    assert!(all_s < 4.0 * one_s, "{one_s} s for one sample, {all_s} s for 16");
}
