//! A view that turns from frame to frame, around a point a metre before the camera of its model.

use serde_json::{Value, json};

/// Boxes on a floor or a little above it, beside a lamp: small enough for many cases. Their colours are what eight bits
/// hold in sRGB; rasterizers round those between two levels differently.
pub(super) const MODEL: &str = "xtask/browser/boxes.gltf";

/// Where its camera stands, from where light is metered: yaw, pitch, radius in degrees and metres, what is looked at in
/// metres; and its vertical field of view.
const ORBIT: [f64; 3] = [0.0, 34.37747, 1.0];
const TARGET: [f64; 3] = [0.2, 0.73536, 1.07466];
const FOV_Y_DEG: &str = "42.97183";

/// A tenth of a second a frame is the most that the page counts, however long it waits.
const FRAMES_PER_SECOND: u32 = 10;

fn list(values: [f64; 3]) -> String {
    values.map(|value| value.to_string()).join(",")
}

/// The flags of the command line for a full turn of so many frames.
pub(super) fn arguments(frames_per_turn: u32) -> Vec<String> {
    let values = [
        ("--orbit", list(ORBIT)),
        ("--target", list(TARGET)),
        ("--fov-y", FOV_Y_DEG.to_owned()),
        ("--turntable", frames_per_turn.to_string()),
        ("--fps", FRAMES_PER_SECOND.to_string()),
    ];
    values.into_iter().flat_map(|(flag, value)| [flag.to_owned(), value]).collect()
}

/// What the page is told: the orbits of so many frames.
pub(super) fn page(frames_per_turn: u32, frames: u32) -> Value {
    let turn_deg = |frame: u32| 360.0 * f64::from(frame) / f64::from(frames_per_turn);
    let orbit = |frame: u32| json!({ "yaw": ORBIT[0] + turn_deg(frame), "pitch": ORBIT[1], "radius": ORBIT[2], "target": TARGET });
    (0..frames).map(orbit).collect()
}
