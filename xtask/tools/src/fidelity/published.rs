//! The table of published pictures.

use super::Fidelity;
use super::as_published::as_published;
use super::pictures::{Distance, Encoding, RenderedPicture, size_of};
use super::scenarios::{self, Scenario};
use crate::table::median;
use anyhow::{Context, Result};
use manypass_testkit::needs;
use serde_json::{Value, json};

const SAMPLE_VIEWER: &str = "gltf-sample-viewer";
const CYCLES: &str = "blender-cycles";
const FILAMENT: &str = "filament";

/// A scene that was compared.
#[derive(Clone, Debug)]
struct Row {
    name: String,
    to_viewer: Pair,
    to_cycles: Pair,
    /// Why it counts for no median.
    reason: Option<&'static str>,
    rendered: RenderedPicture,
}

/// Our distance and Filament's from the same picture.
#[derive(Clone, Copy, Debug)]
struct Pair {
    ours: Distance,
    filament: Distance,
}

/// Where columns stand that are beside both: the other encoding of both pictures; packed ones, since Filament's are
/// packed already.
const OTHER_COLUMN: usize = 3;
const PACKED_COLUMN: usize = 5;

/// What is read of a distance.
type Measure = fn(&Distance) -> f64;
const WHOLE: Measure = |distance| distance.rmse.whole;
const COVERED: Measure = |distance| distance.rmse.covered;
const OTHER: Measure = |distance| distance.rmse_other;
const PACKED: Measure = |distance| distance.rmse_packed;
/// The most that our median may be of Filament's, both as lossy files and by a power of 1/2.2: what we aim at.
const SHARE_MAX: f64 = 0.9;
const FLIP: Measure = |distance| distance.flip;

/// Renders, compares, prints the table and writes `fidelity.json`.
///
/// # Errors
/// There are no scenes, or none is called as asked for.
pub(super) fn print(run: &mut Fidelity) -> Result<()> {
    let scenarios = scenarios::chosen(scenarios::read(&needs::assets_folder())?, run.options)?;
    let columns = [
        ("scene", 24),
        ("RMSE", 6),
        ("Filament", 8),
        ("as sRGB", 7),
        ("Filament by gamma", 8),
        ("packed", 6),
        ("covered", 7),
        ("Filament", 8),
        ("FLIP", 6),
        ("Filament", 8),
        ("Cycles: RMSE", 6),
        ("Filament", 8),
        ("FLIP", 6),
        ("Filament", 8),
    ];
    run.report.begin("Distance to the glTF Sample Viewer and to Cycles, ours and Filament's", &columns);
    let mut rows: Vec<Row> = Vec::new();
    for scenario in &scenarios {
        match row(run, scenario) {
            Ok(Some(row)) => {
                run.report.row(cells(&row));
                rows.push(row);
            }
            Ok(None) => run.report.row(empty(format!("{}*", scenario.name), columns.len())),
            Err(error) => {
                run.report.row(empty(format!("{} (failed)", scenario.name), columns.len()));
                run.failures.push(format!("{}: {error:#}", scenario.name));
            }
        }
    }
    let medians = print_medians(run, &rows);
    for scenario in &scenarios {
        if let Some(reason) = scenario.not_comparable() {
            run.report.note(&format!("* {}: {reason}.", scenario.name));
        }
    }
    for Row { name, rendered, .. } in &rows {
        for warning in &rendered.warnings {
            println!("{name}: {warning}");
        }
    }
    let value = json!({ "scenes": rows.iter().map(value).collect::<Vec<_>>(), "medians": medians });
    let path = run.folder.join("fidelity.json");
    std::fs::write(&path, format!("{value:#}\n")).with_context(|| format!("writing {}", path.display()))
}

/// Compares one scene. None where nothing can be rendered that would be like the published pictures.
fn row(run: &Fidelity, scenario: &Scenario) -> Result<Option<Row>> {
    let Some(environment) = &scenario.environment else { return Ok(None) };
    let model = scenario.model.as_ref().context("its model is not on this machine")?;
    let [viewer, cycles, filament] = [SAMPLE_VIEWER, CYCLES, FILAMENT].map(|renderer| scenario.picture(renderer));
    let model = as_published(&scenario.name, model, &run.folder)?;
    let rendered = run.render(scenario, &model, environment, size_of(&viewer)?)?;
    let name = &scenario.name;
    let pair = |reference, sheet: String| -> Result<Pair> {
        let ours = run.compare(reference, (&rendered.path, Encoding::Gamma), Some(&sheet))?;
        Ok(Pair { ours, filament: run.compare(reference, (&filament, Encoding::Srgb), None)? })
    };
    let to_viewer = pair(&viewer, format!("{name}.viewer.png"))?;
    let to_cycles = pair(&cycles, format!("{name}.cycles.png"))?;
    Ok(Some(Row { name: name.clone(), to_viewer, to_cycles, reason: scenario.not_comparable(), rendered }))
}

/// The cells of a scene without numbers.
fn empty(name: String, columns: usize) -> Vec<String> {
    let mut cells = vec![name];
    cells.resize(columns, "-".into());
    cells
}

fn cells(row: &Row) -> Vec<String> {
    let mut cells = vec![row.name.clone() + if row.reason.is_some() { "*" } else { "" }];
    for (pair, measures) in [(&row.to_viewer, &[WHOLE, COVERED, FLIP][..]), (&row.to_cycles, &[WHOLE, FLIP])] {
        for (index, measure) in measures.iter().enumerate() {
            let digits = if index + 1 == measures.len() { 4 } else { 2 };
            cells.extend([pair.ours, pair.filament].map(|distance| format!("{:.digits$}", measure(&distance))));
        }
    }
    let Pair { ours, filament } = &row.to_viewer;
    let other = [ours, filament].map(|distance| format!("{:.2}", OTHER(distance)));
    cells.splice(OTHER_COLUMN..OTHER_COLUMN, other);
    cells.insert(PACKED_COLUMN, format!("{:.2}", PACKED(ours)));
    cells
}

/// Prints the medians of all that can be compared, and fails where ours to the sample viewer is above Filament's.
fn print_medians(run: &mut Fidelity, rows: &[Row]) -> Value {
    let compared = || rows.iter().filter(|row| row.reason.is_none());
    let viewer: Vec<Pair> = compared().map(|row| row.to_viewer).collect();
    let cycles: Vec<Pair> = compared().map(|row| row.to_cycles).collect();
    let of = |pairs: &[Pair], measure: Measure| {
        let numbers = |which: fn(&Pair) -> &Distance| pairs.iter().map(|pair| measure(which(pair))).collect();
        (median(numbers(|pair| &pair.ours)), median(numbers(|pair| &pair.filament)))
    };
    let mut value = json!({ "scenes": viewer.len() });
    let mut row = vec![format!("median of {}", viewer.len())];
    for (key, pairs, measure, digits) in [
        ("viewer_rmse", &viewer, WHOLE, 2),
        ("viewer_rmse_covered", &viewer, COVERED, 2),
        ("viewer_flip", &viewer, FLIP, 4),
        ("cycles_rmse", &cycles, WHOLE, 2),
        ("cycles_flip", &cycles, FLIP, 4),
    ] {
        let (ours, filament) = of(pairs, measure);
        value[key] = json!({ "ours": ours, "filament": filament });
        let cell = |number: Option<f64>| number.map_or("-".into(), |number| format!("{number:.digits$}"));
        row.extend([cell(ours), cell(filament)]);
        let is_judged = run.options.only.is_empty() && key.starts_with("viewer_rmse");
        if let (true, Some(ours), Some(filament)) = (is_judged, ours, filament)
            && ours > filament
        {
            run.failures.push(format!("the median of {key} is {ours:.2}, above Filament's, {filament:.2}"));
        }
    }
    let (ours, filament) = of(&viewer, OTHER);
    value["viewer_rmse_other_encoding"] = json!({ "ours": ours, "filament": filament });
    let cell = |number: Option<f64>| number.map_or("-".into(), |number| format!("{number:.2}"));
    row.splice(OTHER_COLUMN..OTHER_COLUMN, [cell(ours), cell(filament)]);
    let packed = median(viewer.iter().map(|pair| PACKED(&pair.ours)).collect());
    value["viewer_rmse_packed"] = json!({ "ours": packed });
    if let (true, Some(ours), Some(filament)) = (run.options.only.is_empty(), packed, filament)
        && ours > SHARE_MAX * filament
    {
        run.failures.push(format!(
            "the median of viewer_rmse_packed is {ours:.2}, above {SHARE_MAX} of Filament's in the same encoding, {filament:.2}"
        ));
    }
    row.insert(PACKED_COLUMN, cell(packed));
    run.report.row(row);
    value
}

fn value(row: &Row) -> Value {
    let distance = |distance: &Distance| json!({ "rmse": distance.rmse.whole, "rmse_other_encoding": distance.rmse_other, "rmse_packed": distance.rmse_packed, "rmse_covered": distance.rmse.covered, "flip": distance.flip });
    let pair = |pair: &Pair| json!({ "ours": distance(&pair.ours), "filament": distance(&pair.filament) });
    json!({
        "name": row.name,
        "viewer": pair(&row.to_viewer),
        "cycles": pair(&row.to_cycles),
        "not_comparable": row.reason,
        "warnings": row.rendered.warnings,
    })
}
