//! Ways of lighting by numbers of lights, without shadows and with them.

use super::Bench;
use super::measure::{Cell, Scene, Verdict};
use super::way::{BRUTE_FORCE, CLUSTERED, Effort, WAYS, Way};
use crate::table::{Column, milliseconds, ratio};
use anyhow::Result;

/// What a cell of the table is.
enum State<'a> {
    LeftOut,
    Failed,
    Differs,
    Measured { cell: &'a Cell, is_compared: bool },
}

impl State<'_> {
    fn compared_ms(&self) -> Option<f64> {
        match self {
            Self::Measured { cell, is_compared: true } => Some(cell.median_ms),
            _ => None,
        }
    }

    /// The ratio to the cheapest of the row, and milliseconds.
    fn text(&self, cheapest_ms: f64) -> String {
        match self {
            Self::LeftOut => "-".into(),
            Self::Failed => "FAILED".into(),
            Self::Differs => "DIFFERS".into(),
            Self::Measured { cell, .. } => {
                format!("{}{} ({})", about(cell), ratio(cell.median_ms / cheapest_ms), milliseconds(cell.median_ms))
            }
        }
    }
}

/// Marks what is of the first frame, with all that is made once.
const fn about(cell: &Cell) -> &'static str {
    if cell.is_first_frame { "~" } else { "" }
}

/// Prints the table of times and that of counters.
pub(super) fn print(bench: &mut Bench, is_shadowed: bool) -> Result<()> {
    let scenes = bench.field_scenes(is_shadowed)?;
    if scenes.is_empty() {
        println!("\nThe fields of lights are not on this machine: ways of lighting are left out.");
        return Ok(());
    }
    let title = if is_shadowed {
        "Ways of lighting with every tenth light shadowed, 960x540: ratio to the cheapest of the row (median ms)"
    } else {
        "Ways of lighting without shadows, 960x540: ratio to the cheapest of the row (median ms)"
    };
    let mut columns: Vec<Column> = vec![("lights", 14)];
    columns.extend(WAYS.iter().map(|way| (way.name, 15)));
    bench.report.begin(title, &columns);
    for (lights, scene) in &scenes {
        let ways: Vec<(&'static Way, Effort)> = WAYS.iter().map(|way| (*way, way.effort(*lights))).collect();
        bench.measurements.measure_in_turns(scene, &ways);
        print_times(bench, *lights, scene);
    }
    bench.report.note(
        "`none` visits every light for every pixel; a cell counts only if its picture is that of `none`, but for `gouraud`, \
         whose picture is another one: its ratio is that to the cheapest of the others. `~`: the first frame alone, with all that \
         is made once. `-`: left out, because it takes minutes.",
    );
    columns.truncate(1);
    columns.extend(WAYS.iter().map(|way| (way.name, 10)));
    bench.report.begin(if is_shadowed { "Their counters, with shadows" } else { "Their counters" }, &columns);
    for (lights, scene) in &scenes {
        for (what, count) in COUNTERS {
            let cell = |way: &&Way| match bench.measurements.cell(scene, way) {
                Ok(Some(cell)) => count(cell, way, scene),
                Ok(None) | Err(_) => "-".into(),
            };
            let cells = WAYS.iter().map(cell);
            let row = std::iter::once(format!("{lights} {what}")).chain(cells).collect();
            bench.report.row(row);
        }
    }
    bench.report.note(
        "Draws are those of surfaces + those that only light. Pairs of a light and what it may reach are visited ones, in millions: \
         pixels, with forward ways all fragments that are drawn, with `gouraud` vertices; those of first frames (~) are not \
         counted. MB are written, if each pass covers its targets once; volumes blend 8 bytes a pair.",
    );
    if is_shadowed {
        print_shadows(bench, &scenes);
    }
    Ok(())
}

fn print_times(bench: &mut Bench, lights: usize, scene: &Scene) {
    let mut failures = Vec::new();
    let states: Vec<State> = WAYS
        .iter()
        .map(|way| match bench.measurements.cell(scene, way) {
            Ok(None) => State::LeftOut,
            Ok(Some(cell)) => match bench.measurements.verdict(scene, way, &BRUTE_FORCE) {
                Ok(Verdict::Differs(how)) => {
                    failures
                        .push(format!("{}, {}: the picture is not that of brute force: {how}", scene.name, way.name));
                    State::Differs
                }
                Ok(verdict) => State::Measured { cell, is_compared: verdict == Verdict::Same },
                Err(error) => {
                    failures.push(format!("{error:#}"));
                    State::Differs
                }
            },
            Err(error) => {
                failures.push(format!("{error:#}"));
                State::Failed
            }
        })
        .collect();
    let cheapest_ms = states.iter().filter_map(State::compared_ms).fold(f64::NAN, f64::min);
    let cells = states.iter().map(|state| state.text(cheapest_ms));
    let row = std::iter::once(lights.to_string()).chain(cells).collect();
    bench.report.row(row);
    bench.failures.extend(failures);
}

/// The counters of a cell: what they are called, and how they are told.
type Counter = (&'static str, fn(&Cell, &Way, &Scene) -> String);

const COUNTERS: [Counter; 3] = [("draws", draws), ("pairs, M", pairs), ("MB", megabytes)];

fn draws(cell: &Cell, _: &Way, _: &Scene) -> String {
    format!("{}{}+{}", about(cell), cell.number("draws"), cell.number("light_draws"))
}

/// A first frame counts none.
fn pairs(cell: &Cell, _: &Way, _: &Scene) -> String {
    if cell.is_first_frame { "-".into() } else { ratio(1e-6 * cell.number("pairs_visited")) }
}

/// Volumes are counted as one that covers the picture; it gives way to what they cover.
fn megabytes(cell: &Cell, way: &Way, scene: &Scene) -> String {
    let blended = if way.blends_pairs { 8.0 * (cell.number("pairs_visited") - scene.pixels()) } else { 0.0 };
    about(cell).to_owned() + &milliseconds(1e-6 * (cell.number("written_bytes") + blended))
}

/// What was shadowed, and how many maps were drawn for it, first and later.
fn print_shadows(bench: &mut Bench, scenes: &[(usize, Scene)]) {
    let columns = [
        ("lights", 14),
        ("shadowed", 9),
        ("beyond the atlas", 0),
        ("maps at first", 0),
        ("later", 6),
        ("atlas, MiB", 0),
    ];
    bench.report.begin("Their shadows", &columns);
    for (lights, scene) in scenes {
        let Ok(Some(clustered)) = bench.measurements.cell(scene, &CLUSTERED) else {
            continue;
        };
        let shadows = &clustered.info["shadows"];
        let count = |key: &str| shadows[key].to_string();
        let later = WAYS
            .iter()
            .filter_map(|way| bench.measurements.cell(scene, way).ok().flatten())
            .filter(|cell| !cell.is_first_frame)
            .filter_map(|cell| cell.info["shadows"]["tiles_drawn"].as_u64())
            .fold(0, u64::max);
        if later > 0 {
            let failure =
                format!("{}: a frame after the first draws {later} shadow maps of a scene at rest", scene.name);
            bench.failures.push(failure);
        }
        let mebibytes = shadows["bytes"].as_f64().unwrap_or(f64::NAN) / f64::from(1 << 20);
        bench.report.row(vec![
            lights.to_string(),
            count("lights"),
            count("lights_beyond_atlas"),
            clustered.info["shadow_tiles_drawn_first"].to_string(),
            later.to_string(),
            milliseconds(mebibytes),
        ]);
    }
    bench.report.note(
        "Shadowed are every tenth light of the file, if anything in view can be lit by them. A point light has up to six maps: \
         a map into which nothing casts is not drawn. `later` is the most that any way drew in its last frame.",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn cell(frames: serde_json::Value) -> Cell {
        let info = json!({
            "first_frame_ms": 300.0, "draws": 21, "light_draws": 14, "pairs_visited": 2_000_000, "written_bytes": 10_000_000
        });
        Cell::new(&json!({ "frames": frames, "info": info }), Default::default()).expect("a cell")
    }

    #[test]
    fn cells_are_ratios_to_the_cheapest_that_counts() {
        let (measured, single) = (cell(json!([150.0])), cell(json!([])));
        let counted = |cell, is_compared| State::Measured { cell, is_compared };
        assert_eq!(counted(&measured, true).text(100.0), "1.50 (150)");
        assert_eq!(counted(&single, true).text(100.0), "~3.00 (300)");
        assert_eq!(State::Differs.text(100.0), "DIFFERS");
        assert_eq!(counted(&measured, true).compared_ms(), Some(150.0));
        assert_eq!([counted(&measured, false), State::LeftOut].map(|state| state.compared_ms()), [None; 2]);
    }

    #[test]
    fn counters_are_of_the_way() {
        let (cell, scene) = (cell(json!([1.0])), Scene::new("s", "s.glb", (1000, 500)));
        let of = |way: &Way| COUNTERS.map(|(_, count)| count(&cell, way, &scene));
        assert_eq!(of(&CLUSTERED), ["21+14", "2.00", "10.0"]);
        // 8 bytes for each of 2 million pairs in place of each of half a million pixels.
        assert_eq!(of(WAYS[2]), ["21+14", "2.00", "22.0"]);
        assert_eq!(of(WAYS[4]), ["21+14", "2.00", "10.0"]);
    }
}
