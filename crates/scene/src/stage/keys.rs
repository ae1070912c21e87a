//! The keys of stage files, declared once for the reader, the schema and the documentation.

mod declaration;
mod effects;
mod overlay;
mod scene;
mod views;

pub use declaration::{StageKey, StageTable, StageType};
pub(super) use effects::{DECALS, PARTICLES, SIMULATIONS, WATER};
pub(super) use overlay::OVERLAY;
pub(super) use scene::{LIGHTS, MATERIALS, NODES};
pub(super) use views::{MIRRORS, MONITORS, PORTALS, PROBES, REFLECTION_PROBES};

use declaration::required;

/// Tables of settings: name and description.
pub const SETTINGS_TABLES: [(&str, &str); 4] = [
    ("environment", "The settings `environment.*`; `color` is `source` as a colour."),
    ("fog", "The settings `fog.*`."),
    (
        "effects",
        "The settings `effects.*`: `chain = [\"bloom\", \"own.wgsl\"]`; paths are from the folder of the stage.",
    ),
    (
        "settings",
        "Any other setting, as in files of `--settings`: `[settings.tone_map]`, `curve = \"agx\"`; of effects too.",
    ),
];

/// The beginning of a file.
const FILE: StageTable = StageTable {
    name: "",
    doc: "The beginning of a stage.",
    keys: &[required(
        "model",
        StageType::Text,
        "The model: a .glb, .gltf, .obj, .stl, .ply or .3mf file, its path from the folder of the stage; or demo:hall, demo:materials, demo:relief, demo:crowd, demo:room, demo:monitors, demo:mirror, demo:shore, demo:water, demo:doors, demo:portals, demo:gallery, demo:reflection_probes, demo:laboratory, demo:simulations, demo:particles, demo:yard, demo:decals, demo:sandbox, demo:trails, demo:cornell.",
    )],
};

/// All tables except those of settings.
pub const TABLES: [StageTable; 14] = [
    FILE,
    LIGHTS,
    NODES,
    MATERIALS,
    MONITORS,
    MIRRORS,
    SIMULATIONS,
    PARTICLES,
    DECALS,
    WATER,
    PORTALS,
    REFLECTION_PROBES,
    PROBES,
    OVERLAY,
];
