//! Variables of the frame: those that the page reads against those that the program writes, of one view of the demo
//! that turned since the frame before.

use super::{BACKENDS, cases::WIDE};
use crate::step::{check, program, root};
use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};
use std::path::PathBuf;

/// The model whose variables are compared.
pub(super) const MODEL: &str = "demo:hall";

/// A variable, and how far two values of it may lie apart: the step of the PNG file, and that rasterizers snap vertices
/// to different grids, so that surfaces which are seen at an angle move by a thirtieth of a pixel.
struct Variable {
    name: &'static str,
    kind: Kind,
    within: f64,
    /// The smallest share of pixels that agree, 0 to 1, and of those that agree or lie between the pixels around them.
    shares: [f64; 2],
}

/// On SwiftShader 0.33 % of the pixels differ, and 0.016 % from all around them. Of normals, which turn within a pixel
/// where spheres and mouldings are small, 1.2 % and 0.25 % do.
const SHARES: [f64; 2] = [0.995, 0.9995];

/// How a PNG holds a variable; `docs/aovs.md` has the same.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Id,
    Signed,
    Range,
    Symmetric,
}

const VARIABLES: [Variable; 6] = [
    Variable { name: "depth", kind: Kind::Range, within: 0.02, shares: SHARES },
    Variable { name: "normal", kind: Kind::Signed, within: 0.01, shares: [0.98, 0.996] },
    Variable { name: "position", kind: Kind::Range, within: 0.02, shares: SHARES },
    Variable { name: "motion", kind: Kind::Symmetric, within: 0.02, shares: SHARES },
    Variable { name: "object_id", kind: Kind::Id, within: 0.0, shares: SHARES },
    Variable { name: "material_id", kind: Kind::Id, within: 0.0, shares: SHARES },
];

/// Among the lights of the hall; yaw, pitch, radius in degrees and metres, what is looked at in metres.
const ORBIT: [f64; 3] = [3.0, 2.0, 18.0];
const TARGET: [f64; 3] = [0.0, 2.0, 0.0];
/// The vertical field of view of the demo's own camera, which the page keeps: 0.9 radians.
const FOV_Y_DEG: &str = "51.56620156";
/// The view turns by a degree a frame.
const TURNTABLE: &str = "360";

fn folder() -> PathBuf {
    root().join("target/browser")
}

fn list(values: [f64; 3]) -> String {
    values.map(|value| value.to_string()).join(",")
}

/// Draws the second frame of the turn with the program, with all variables.
pub(super) fn draw_natively() -> Result<()> {
    let size = format!("{}x{}", WIDE.0, WIDE.1);
    let (orbit, target, aovs) = (list(ORBIT), list(TARGET), VARIABLES.map(|variable| variable.name).join(","));
    let mut command = program()?;
    command.args(["render", MODEL, "--samples", "1", "--quiet"]);
    command.args(["--size", &size, "--orbit", &orbit, "--target", &target, "--fov-y", FOV_Y_DEG]);
    command.args(["--turntable", TURNTABLE, "--frames", "1..1", "--aov", &aovs]);
    command.arg("--report").arg(folder().join("variables.json")).arg("-o").arg(folder().join("variables-{frame}.png"));
    check(&mut command)
}

/// What the page is told: the orbits of both frames, and the names of the variables.
pub(super) fn page() -> Value {
    let orbit =
        |turn_deg: f64| json!({ "yaw": ORBIT[0] + turn_deg, "pitch": ORBIT[1], "radius": ORBIT[2], "target": TARGET });
    json!({ "orbits": [orbit(0.0), orbit(1.0)], "names": VARIABLES.map(|variable| variable.name) })
}

/// Values of a variable, some a pixel.
#[derive(Clone)]
struct Values {
    width: usize,
    channels: usize,
    data: Vec<f64>,
}

impl Values {
    fn pixel(&self, at: usize) -> &[f64] {
        &self.data[at * self.channels..(at + 1) * self.channels]
    }

    fn pixel_count(&self) -> usize {
        self.data.len() / self.channels
    }

    /// The places of the 3×3 pixels around one.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.width, self.pixel_count() / self.width);
        let (x, y) = (at % width, at / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |row| (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column))
    }

    /// The same values, each pixel's from another place and changed.
    fn mutated(&self, place: impl Fn(usize, usize) -> usize, change: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let pixels = (0..self.pixel_count()).map(|at| self.pixel(place(at % self.width, at / self.width)));
        Self { data: pixels.flat_map(change).collect(), ..*self }
    }

    /// Spoilt in ways that a comparison must refuse.
    fn mutations(&self) -> Vec<(&'static str, Self)> {
        let (width, height) = (self.width, self.pixel_count() / self.width);
        let keep = |pixel: &[f64]| pixel.to_vec();
        vec![
            ("flipped in x", self.mutated(|x, y| y * width + width - 1 - x, keep)),
            ("flipped in y", self.mutated(|x, y| (height - 1 - y) * width + x, keep)),
            ("shifted by a pixel in x", self.mutated(|x, y| y * width + x.saturating_sub(1), keep)),
            ("shifted by a pixel in y", self.mutated(|x, y| y.saturating_sub(1) * width + x, keep)),
            ("negated", self.mutated(|x, y| y * width + x, |pixel| pixel.iter().map(|value| -value).collect())),
            (
                "4 % too large",
                self.mutated(|x, y| y * width + x, |pixel| pixel.iter().map(|value| 1.04 * value).collect()),
            ),
            ("zero", self.mutated(|x, y| y * width + x, |pixel| vec![0.0; pixel.len()])),
        ]
    }
}

/// How two pictures of a variable differ.
struct Difference {
    /// The share of pixels that agree.
    share: f64,
    /// The share of those that agree, or lie between the pixels around them in the first.
    share_between: f64,
}

impl Difference {
    fn new(first: &Values, second: &Values, variable: &Variable) -> Self {
        let within = variable.within;
        let agrees = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a == b || (a - b).abs() <= within);
        let is_between = |at: usize| {
            let found = second.pixel(at);
            if variable.kind == Kind::Id {
                return first.around(at).any(|near| agrees(first.pixel(near), found));
            }
            found.iter().enumerate().all(|(channel, value)| {
                let near = first.around(at).map(|near| first.pixel(near)[channel]);
                let (low, high) =
                    near.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
                (low - within..=high + within).contains(value)
            })
        };
        let count = first.pixel_count();
        let share =
            |is_good: &dyn Fn(usize) -> bool| (0..count).filter(|at| is_good(*at)).count() as f64 / count as f64;
        let is_same = |at: usize| agrees(first.pixel(at), second.pixel(at));
        Self { share: share(&is_same), share_between: share(&|at| is_same(at) || is_between(at)) }
    }

    /// Whether they are the same to rasterizers of other grids.
    fn is_within(&self, variable: &Variable) -> bool {
        self.share >= variable.shares[0] && self.share_between >= variable.shares[1]
    }
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.3} % agree, {:.3} % with those at edges", 100.0 * self.share, 100.0 * self.share_between)
    }
}

/// What is wrong with the variables of the case `case`, if anything.
pub(super) fn faults(case: &str) -> Result<Vec<String>> {
    let report = serde_json::from_slice(&std::fs::read(folder().join("variables.json"))?)?;
    let mut faults = Vec::new();
    let mut agreement = BACKENDS.map(|_| Vec::new());
    for variable in &VARIABLES {
        let native = native(variable, &report)?;
        for (name, spoilt) in native.mutations() {
            // Numbers of nodes have no size.
            let is_spoilt = variable.kind != Kind::Id || !name.ends_with("large");
            let found = Difference::new(&native, &spoilt, variable);
            let is_accepted = found.is_within(variable);
            ensure!(!is_spoilt || !is_accepted, "the comparison would accept {} {name}: {found}", variable.name);
        }
        for (backend, agreement) in BACKENDS.into_iter().zip(&mut agreement) {
            let found = Difference::new(&native, &of_the_page(case, backend, variable, &native)?, variable);
            agreement.push(format!("{} {:.2} %", variable.name, 100.0 * found.share));
            if !found.is_within(variable) {
                faults.push(format!("{} on {backend} differs from native: {found}", variable.name));
            }
        }
    }
    for (backend, agreement) in BACKENDS.into_iter().zip(agreement) {
        println!("    {case:24} {backend:6} against native: {}", agreement.join(", "));
    }
    Ok(faults)
}

/// What the program wrote.
fn native(variable: &Variable, report: &Value) -> Result<Values> {
    let path = folder().join(format!("variables-1.{}.png", variable.name));
    let image = image::open(&path).with_context(|| format!("reading {}", path.display()))?;
    let (width, stored) = (image.width() as usize, usize::from(image.color().channel_count()));
    let raw: Vec<f64> = if stored == 1 {
        image.into_luma16().into_raw().into_iter().map(f64::from).collect()
    } else {
        image.into_rgb16().into_raw().into_iter().map(f64::from).collect()
    };
    let range = &report["aov_ranges"][variable.name];
    let end = |name: &str, channel: usize| -> f64 {
        let ends = range[name].as_array().map_or(&[][..], Vec::as_slice);
        ends.get(channel).or(ends.first()).and_then(Value::as_f64).unwrap_or(f64::NAN)
    };
    let decode = |pixel: &[f64]| -> Vec<f64> {
        let is_background = match variable.kind {
            Kind::Range => pixel.iter().all(|v| *v == 65535.0),
            Kind::Signed => pixel.iter().all(|v| *v == 0.0),
            Kind::Id | Kind::Symmetric => false,
        };
        let background = if variable.name == "depth" { f64::INFINITY } else { 0.0 };
        let value = |(channel, v): (usize, &f64)| match variable.kind {
            _ if is_background => background,
            Kind::Id => *v,
            Kind::Signed => 2.0 * v / 65535.0 - 1.0,
            Kind::Range => end("low", channel) + v / 65534.0 * (end("high", channel) - end("low", channel)),
            Kind::Symmetric => (v - 32768.0) / 32767.0 * end("high", 0),
        };
        // The third channel of a file with two variables is empty.
        let channels = if variable.kind == Kind::Symmetric { 2 } else { stored };
        pixel.iter().enumerate().map(value).take(channels).collect()
    };
    let channels = if variable.kind == Kind::Symmetric { 2 } else { stored };
    let data: Vec<f64> = raw.chunks_exact(stored).flat_map(decode).collect();
    ensure!(data.iter().all(|value| !value.is_nan()), "{} has no range in the report", variable.name);
    Ok(Values { width, channels, data })
}

/// What the page read, of the shape of `native`.
fn of_the_page(case: &str, backend: &str, variable: &Variable, native: &Values) -> Result<Values> {
    let path = folder().join(format!("{case}-{backend}-{}.bin", variable.name));
    let bytes = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
    let word = |bytes: &[u8]| {
        let word = [bytes[0], bytes[1], bytes[2], bytes[3]];
        if variable.kind == Kind::Id { u32::from_le_bytes(word).into() } else { f32::from_le_bytes(word).into() }
    };
    let data: Vec<f64> = bytes.chunks_exact(4).map(word).collect();
    ensure!(data.len() == native.data.len(), "{case} on {backend}: {} has {} values", variable.name, data.len());
    Ok(Values { data, ..*native })
}
