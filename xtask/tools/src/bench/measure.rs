//! Running the program: cells, each a scene under a way of lighting, measured in turns and held against brute force.

use super::way::{Effort, Judgement, Way};
use crate::step::{last_json, open_picture};
use crate::table::median;
use anyhow::{Context, Result, bail};
use manypass_testkit::compare::{self, Tolerance};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

/// How often everything that is compared is measured in turn. The least median counts: other work only makes frames
/// slower.
const TURNS: usize = 2;
/// The frames of a turn at most, and the milliseconds after which no more are begun.
const FRAMES: &str = "10";
const BUDGET_MS: &str = "1000";
/// What took longer in its first turn, with the start of the program, has no other: long times vary less, and few of
/// them would take most of the run.
const LONG_TURN: Duration = Duration::from_secs(6);

/// What is drawn.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    /// Names its cells and files.
    pub name: String,
    pub input: String,
    pub size: (u32, u32),
    /// More arguments.
    pub arguments: Vec<String>,
}

impl Scene {
    pub fn new(name: &str, input: &str, size: (u32, u32)) -> Self {
        Self { name: name.to_owned(), input: input.to_owned(), size, arguments: Vec::new() }
    }

    pub fn pixels(&self) -> f64 {
        f64::from(self.size.0) * f64::from(self.size.1)
    }
}

/// What was measured of a scene under a way of lighting.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// The least median of the turns, or what the first frame took.
    pub median_ms: f64,
    /// The least time of the pass `direct`.
    pub direct_ms: f64,
    pub is_first_frame: bool,
    /// Of the first turn, as the program printed it.
    pub info: Value,
    pub picture: PathBuf,
}

impl Cell {
    /// # Errors
    /// The program printed no times.
    pub fn new(result: &Value, picture: PathBuf) -> Result<Self> {
        let info = &result["info"];
        let median_ms = median(numbers(&result["frames"])).or_else(|| info["first_frame_ms"].as_f64());
        let median_ms = median_ms.with_context(|| format!("no times of frames in {result}"))?;
        let passes = info["passes"].as_array().into_iter().flatten();
        let direct = passes.filter(|pass| pass["name"] == "direct").filter_map(|pass| pass["gpu_ms"].as_f64());
        Ok(Self {
            median_ms,
            direct_ms: direct.fold(f64::NAN, f64::min),
            is_first_frame: numbers(&result["frames"]).is_empty(),
            info: info.clone(),
            picture,
        })
    }

    fn take_least(&mut self, other: &Self) {
        self.median_ms = self.median_ms.min(other.median_ms);
        self.direct_ms = self.direct_ms.min(other.direct_ms);
    }

    /// A number that the program printed; NaN if it did not.
    pub fn number(&self, key: &str) -> f64 {
        self.info[key].as_f64().unwrap_or(f64::NAN)
    }
}

/// Whether a picture is that of brute force.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    Same,
    /// Is another one on purpose.
    NotCompared,
    Differs(String),
}

/// All that was measured of one program.
pub(super) struct Measurements {
    pub program: PathBuf,
    /// For pictures.
    pub folder: PathBuf,
    cells: BTreeMap<(String, &'static str), Result<Cell, String>>,
}

impl Measurements {
    pub fn new(program: PathBuf, folder: PathBuf) -> Self {
        Self { program, folder, cells: BTreeMap::new() }
    }

    /// Measures what was not measured yet of a scene under several ways: all of them, and then all of them again.
    pub fn measure_in_turns(&mut self, scene: &Scene, ways: &[(&'static Way, Effort)]) {
        let is_open = |(way, effort): &&(&'static Way, Effort)| {
            *effort != Effort::LeftOut && !self.cells.contains_key(&(scene.name.clone(), way.name))
        };
        let mut open: Vec<_> = ways.iter().filter(is_open).copied().collect();
        for _ in 0..TURNS {
            open.retain(|&(way, effort)| {
                let started = Instant::now();
                self.measure(scene, way, effort);
                effort == Effort::Frames && started.elapsed() < LONG_TURN
            });
        }
    }

    /// One more turn of a cell.
    pub fn measure_again(&mut self, scene: &Scene, way: &'static Way) {
        self.measure(scene, way, Effort::Frames);
    }

    fn measure(&mut self, scene: &Scene, way: &'static Way, effort: Effort) {
        let measured = self.run(scene, way, effort).map_err(|error| format!("{error:#}"));
        let slot = self.cells.entry((scene.name.clone(), way.name));
        slot.and_modify(|cell| match (cell, &measured) {
            (Ok(cell), Ok(measured)) => cell.take_least(measured),
            // A turn that failed is not made good by another.
            (Err(_), Ok(_)) => (),
            (cell, Err(error)) => *cell = Err(error.clone()),
        })
        .or_insert(measured);
    }

    fn run(&self, scene: &Scene, way: &Way, effort: Effort) -> Result<Cell> {
        let picture = self.folder.join(format!("{}-{}.png", scene.name.replace(':', "-"), way.name));
        let (width, height) = scene.size;
        let mut command = Command::new(&self.program);
        command.args(["bench", &scene.input, "--json", "--size", &format!("{width}x{height}"), "--png"]);
        command.arg(&picture).args(&scene.arguments).args(way.arguments);
        match effort {
            Effort::Frames => command.args(["--count", FRAMES, "--budget-ms", BUDGET_MS]),
            Effort::FirstFrame | Effort::LeftOut => command.arg("--first-frame"),
        };
        Cell::new(&last_json(&mut command)?, picture)
    }

    /// What was measured of a scene under a way, if anything was.
    ///
    /// # Errors
    /// The program failed.
    pub fn cell(&self, scene: &Scene, way: &Way) -> Result<Option<&Cell>> {
        match self.cells.get(&(scene.name.clone(), way.name)) {
            Some(Ok(cell)) => Ok(Some(cell)),
            Some(Err(error)) => bail!("{}, {}: {error}", scene.name, way.name),
            None => Ok(None),
        }
    }

    /// The adapter on which anything was measured.
    pub fn adapter(&self) -> Option<&str> {
        self.cells.values().flatten().find_map(|cell| cell.info["adapter"].as_str())
    }

    /// Holds the picture of a cell against that of brute force.
    ///
    /// # Errors
    /// There is none of either.
    pub fn verdict(&self, scene: &Scene, way: &Way, brute_force: &Way) -> Result<Verdict> {
        let tolerance = match way.judged {
            Judgement::NotCompared => return Ok(Verdict::NotCompared),
            Judgement::AsDeferred => Tolerance::default(),
            // Deferred surfaces have base colour and roughness in 8 bits: half a step of base colour is up to 0.5/255
            // of a lit surface, and roughness moves the sharpest highlights by more than 2/255.
            Judgement::AsForward => Tolerance { share: 0.99, share_between: 0.99, mean: 0.5, ..Tolerance::default() },
        };
        let picture = |way: &Way| {
            let cell = self.cell(scene, way)?.with_context(|| format!("{}, {}: no picture", scene.name, way.name))?;
            open_picture(&cell.picture)
        };
        let found = compare::difference(&picture(brute_force)?, &picture(way)?, tolerance.within);
        Ok(if found.is_within(tolerance) { Verdict::Same } else { Verdict::Differs(found.to_string()) })
    }
}

/// The numbers of a list.
pub(super) fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_least_of_the_turns_counts() {
        let cell = |ms: f64, direct_ms: Value| {
            let passes = json!([{ "name": "geometry", "gpu_ms": 1.0 }, { "name": "direct", "gpu_ms": direct_ms }]);
            let result = json!({ "frames": [ms, 9.0 * ms, ms], "info": { "passes": passes, "draws": 3 } });
            Cell::new(&result, PathBuf::new()).expect("a cell")
        };
        let mut least = cell(4.0, json!(3.0));
        least.take_least(&cell(5.0, json!(2.0)));
        least.take_least(&cell(6.0, Value::Null));
        assert_eq!((least.median_ms, least.direct_ms, least.is_first_frame), (4.0, 2.0, false));
        assert!((least.number("draws") - 3.0).abs() < 1e-9 && least.number("pairs_visited").is_nan());
    }

    #[test]
    fn a_first_frame_stands_for_itself() {
        let result = json!({ "frames": [], "info": { "first_frame_ms": 7.5 } });
        let cell = Cell::new(&result, PathBuf::new()).expect("a cell");
        assert_eq!((cell.median_ms, cell.is_first_frame), (7.5, true));
        assert!(Cell::new(&json!({ "frames": [], "info": {} }), PathBuf::new()).is_err());
    }
}
