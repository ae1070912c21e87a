//! The demo and the fields of lights: the frame against forward and brute force, and the pass `direct` against the
//! limit.

use super::Bench;
use super::limit::Limit;
use super::measure::{Scene, Verdict};
use super::way::{BRUTE_FORCE, CLUSTERED, Effort, FORWARD, Way};
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result, ensure};
use manypass_testkit::needs;

/// Prints the table.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let limit = bench.measure_limit()?;
    let title = "Clustered lights without shadows and anti-aliasing (pairs: of pixel and light)";
    let columns = [
        ("scene", 18),
        ("lights", 6),
        ("median ms", 9),
        ("direct ms", 9),
        ("limit ms", 8),
        ("direct/limit", 12),
        ("forward", 7),
        ("brute", 7),
        ("visited/in range", 8),
        ("culling ms", 7),
        ("in lists", 8),
        ("triangles", 9),
        ("picture", 14),
    ];
    bench.report.begin(title, &columns);
    for (lights, scene) in scenes(bench)? {
        // Whatever has more lights than a field takes as long as the next field.
        let effort = |way: &'static Way| (way, way.effort(lights));
        let ways = [(&CLUSTERED, Effort::Frames), effort(&FORWARD), effort(&BRUTE_FORCE)];
        bench.measurements.measure_in_turns(&scene, &ways);
        // What an earlier table measured is from another minute than the limit.
        bench.measurements.measure_again(&scene, &CLUSTERED);
        if let Err(error) = print_row(bench, &scene, &limit) {
            bench.failures.push(format!("{}: {error:#}", scene.name));
        }
    }
    let again = bench.measure_limit()?;
    bench.report.note(&format!(
        "The limit is a bare loop over lights, {:.2} ns a pair in range and {:.2} ms a frame of 960x540 (the least that was \
         measured until the end: {:.2} ns and {:.2} ms). `forward` and `brute` (one frame where it takes long) are ratios to \
         median ms.",
        limit.ns_per_pair, limit.fixed_ms, again.ns_per_pair, again.fixed_ms
    ));
    Ok(())
}

/// The demo, the fields, and many surfaces behind each other.
fn scenes(bench: &Bench) -> Result<Vec<(usize, Scene)>> {
    let mut scenes = vec![(usize::MAX, Scene::new("demo:hall", "demo:hall", (960, 540)))];
    let fields = bench.field_scenes(false)?;
    if fields.is_empty() {
        println!("    (the fields of lights are not on this machine; they are left out)");
    }
    scenes.extend(fields);
    let overdraw = needs::assets_folder().join("lightfield/overdraw.glb");
    if overdraw.is_file() {
        scenes.push((usize::MAX, Scene::new("overdraw", &overdraw.display().to_string(), (480, 270))));
    }
    Ok(scenes)
}

fn print_row(bench: &mut Bench, scene: &Scene, limit: &Limit) -> Result<()> {
    let measured = |way| bench.measurements.cell(scene, way)?.context("it was not measured");
    let (clustered, forward, brute_force) = (measured(&CLUSTERED)?, measured(&FORWARD)?, measured(&BRUTE_FORCE)?);
    let verdict = bench.measurements.verdict(scene, &CLUSTERED, &BRUTE_FORCE)?;
    let number = |key: &str| clustered.number(key);
    let limit_ms = limit.ms(number("pairs_in_range"), scene.pixels());
    let row = vec![
        scene.name.clone(),
        number("lights").to_string(),
        milliseconds(clustered.median_ms),
        milliseconds(clustered.direct_ms),
        milliseconds(limit_ms),
        ratio(clustered.direct_ms / limit_ms),
        ratio(forward.median_ms / clustered.median_ms),
        ratio(brute_force.median_ms / clustered.median_ms),
        ratio(number("visited_over_in_range")),
        milliseconds(number("culling_ms")),
        number("list_entries").to_string(),
        number("triangles").to_string(),
        (if verdict == Verdict::Same { "as brute force" } else { "DIFFERS" }).to_owned(),
    ];
    let passes = clustered.info["passes"].clone();
    bench.report.row(row);
    for pass in passes.as_array().into_iter().flatten() {
        let name = pass["name"].as_str().unwrap_or_default();
        let ms = |key: &str| pass[key].as_f64().map_or_else(|| "-".to_owned(), milliseconds);
        println!("    {name:16} {:>8} ms, recorded in {} ms", ms("gpu_ms"), ms("cpu_ms"));
    }
    ensure!(verdict == Verdict::Same, "the picture is not that of brute force: {verdict:?}");
    Ok(())
}
