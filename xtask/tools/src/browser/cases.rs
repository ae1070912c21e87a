//! What is drawn, and in which ways.

mod told;

use super::{made, turn, variables};
use manypass_testkit::compare::Tolerance;

/// A model that is drawn natively and in the browser.
pub(super) struct Case {
    pub name: &'static str,
    /// `demo:NAME`, a file of this repository, or one below the shared assets.
    pub model: &'static str,
    pub size: (u32, u32),
    /// By the forward path instead of the deferred one.
    is_forward: bool,
    /// By a camera of the file.
    camera: Option<&'static str>,
    /// In a variant of the file.
    pub variant: Option<&'static str>,
    /// With the effect [`ECHO`], and its settings.
    pub echo: Option<Echo>,
    /// Built-in effects by their names, as they are, and others by files of this repository.
    effects: &'static [&'static str],
    /// Whether the variables of a frame are read too; of [`variables::MODEL`].
    pub has_variables: bool,
    /// In the studio at a million times its light, without exposure.
    is_dazzling: bool,
    /// How far pictures of two rasterizers may differ. Where something is steep but shows no other side, what they
    /// round differently hangs together; twice what was seen is allowed.
    pub tolerance: Tolerance,
    /// How far apart backends may meter it, in stops.
    pub exposure_within_stops: f64,
    /// How many frames are drawn one after the other, of which the last one is compared; each goes on from those before it.
    pub frames: u32,
    /// Whether they end in one that stays as it is; otherwise one more is to be another picture.
    pub settles: bool,
    /// How many frames a full turn of the view takes, of [`turn::MODEL`]; 0 if it stands. A frame is then a tenth of a
    /// second.
    turntable: u32,
    /// The time that is shown, in seconds; 0 for none.
    pub time_secs: f32,
    /// With what is found in the picture where nobody says, which other cases leave out.
    has_defaults: bool,
    /// More settings.
    settings: &'static [(&'static str, &'static str)],
    /// Settings that, after its own, take away what a case is for: the comparison has to refuse each such picture.
    pub without: &'static [&'static [(&'static str, &'static str)]],
    /// Items drawn over the picture, as JSON: the page is given them, the command line a stage that has them.
    overlay: Option<&'static str>,
}

/// Settings of the effect that adds what it made in the frame before.
#[derive(Clone, Copy)]
pub(super) struct Echo {
    share: f64,
    gain: f64,
}

const ECHO: &str = "xtask/browser/echo.wgsl";

/// The cases whose lights are also drawn in eight groups that must add up.
pub(super) const GROUPS: [&str; 2] = ["hall", "lightfield_10000"];
const SQUARE: (u32, u32) = (256, 256);
pub(super) const WIDE: (u32, u32) = (320, 180);
const FAINT: Option<Echo> = Some(Echo { share: 0.25, gain: 0.5 });
const WHOLE: Option<Echo> = Some(Echo { share: 1.0, gain: 1.0 });

const fn case(name: &'static str, model: &'static str, size: (u32, u32)) -> Case {
    Case {
        name,
        model,
        size,
        is_forward: false,
        camera: None,
        variant: None,
        echo: None,
        effects: &[],
        has_variables: false,
        is_dazzling: false,
        tolerance: Tolerance::RASTERIZERS,
        exposure_within_stops: 0.02,
        frames: 1,
        settles: false,
        turntable: 0,
        time_secs: 0.0,
        has_defaults: false,
        settings: &[],
        without: &[],
        overlay: None,
    }
}

/// So many pixels may differ and hang together, and so many of those that lie between no others.
const fn together(area_px: usize, area_between_px: usize) -> Tolerance {
    Tolerance { area_px, area_between_px, ..Tolerance::RASTERIZERS }
}

/// A letter, words behind the middle of the model and before it, and lines.
const ITEMS: &str = r#"[
    { "text": "Äg 4 µm", "position": [6, 6], "size_px": 24, "background": "101820", "background_opacity": 0.5, "padding_px": 4 },
    { "text": "behind", "at_world": [0, 0, 0], "size_px": 20, "color": "ff4020", "depth_test": true },
    { "text": "before", "at_world": [0, 0, 0], "size_px": 20, "position": [0, 30], "color": "40ff20", "depth_test": true, "depth_offset_m": 3 },
    { "points": [[10, -10], [60, -40], [110, -10], [-10.5, -10]], "width_px": 3, "opacity": 0.7 },
    { "points_world": [[-2, -0.5, 0], [2, -0.5, 0]], "width_px": 2, "depth_test": true, "color": "ffd030" }
]"#;
const SHADOWLESS: &[(&str, &str)] = &[("shadows.enabled", "false")];
const SPOTS: &str = "renderling/shadow_mapping_spots.glb";
const SPHERES: &str =
    "khronos-sample-assets/Models/MetalRoughSpheresNoTextures/glTF-Binary/MetalRoughSpheresNoTextures.glb";
const HELMET: &str = "khronos-sample-assets/Models/DamagedHelmet/glTF-Binary/DamagedHelmet.glb";
const MASKS: &str = "khronos-sample-assets/Models/AlphaBlendModeTest/glTF-Binary/AlphaBlendModeTest.glb";
const POINTS: &str = "renderling/shadow_mapping_points.glb";

pub(super) static CASES: [Case; 70] = [
    Case { echo: FAINT, ..case("hall-echo", variables::MODEL, WIDE) },
    Case { echo: FAINT, is_forward: true, has_variables: true, ..case("hall-forward", variables::MODEL, WIDE) },
    // Groups of its lights find more room for their shadow maps than all of them, and then would not add up.
    Case { has_variables: true, settings: SHADOWLESS, ..case("hall", variables::MODEL, WIDE) },
    // Lights and fog that a stage adds to the hall, on top of surfaces, behind blended ones, and over the environment.
    case("hall-stage", "docs/examples/hall.stage.toml", WIDE),
    // Screens that show what cameras of the scene see, within each other, too; a smooth mirror and a rough one.
    // What screens show of steep edges is a texel to the side here and there.
    Case {
        tolerance: Tolerance { mean: 0.4, ..together(240, 8) },
        ..case("monitors", "docs/examples/monitors.stage.toml", WIDE)
    },
    // Lamps in what the rough one reflects are met by some rays and missed by others, which round differently.
    Case {
        tolerance: Tolerance { share_between: 0.998, ..together(144, 30) },
        ..case("mirror", "docs/examples/mirror.stage.toml", WIDE)
    },
    // Waves, what they reflect and refract, absorption, foam; sparkles are met by some rays and missed by others, and hills
    // and sand have detail of a pixel.
    Case {
        tolerance: Tolerance { share: 0.956, share_between: 0.996, mean: 0.75, ..together(144, 30) },
        ..case("water", "docs/examples/water.stage.toml", WIDE)
    },
    // Two places that lead into each other, and a ball and a lamp that go through.
    // Slabs and plaster have detail of a pixel.
    Case {
        tolerance: Tolerance { mean: 0.55, ..together(120, 6) },
        ..case("portals", "docs/examples/portals.stage.toml", WIDE)
    },
    // A room as the environment of what is in it.
    // Mirrors make more of what two rasterizers round differently.
    Case {
        tolerance: Tolerance { share: 0.976, mean: 0.6, ..together(208, 4) },
        ..case("reflection_probes", "docs/examples/reflection_probes.stage.toml", WIDE)
    },
    // Waves around a ball, a pattern, and smoke, after a second: what is rounded differently grows from step to step.
    Case {
        time_secs: 1.0,
        tolerance: Tolerance { mean: 0.6, ..together(144, 30) },
        ..case("simulations", "docs/examples/simulations.stage.toml", WIDE)
    },
    // Rain, sparks and smoke: what meets an edge goes another way.
    Case {
        time_secs: 2.0,
        tolerance: Tolerance { mean: 0.6, ..together(144, 30) },
        ..case("particles", "docs/examples/particles.stage.toml", WIDE)
    },
    // Markings, cracks, leaves, dents and a sign on what lies below.
    Case {
        tolerance: Tolerance { mean: 0.6, ..Tolerance::RASTERIZERS },
        ..case("decals", "docs/examples/decals.stage.toml", WIDE)
    },
    // Tracks and prints in sand, after 2 seconds.
    Case {
        time_secs: 2.0,
        tolerance: Tolerance { mean: 0.5, ..Tolerance::RASTERIZERS },
        ..case("trails", "docs/examples/trails.stage.toml", WIDE)
    },
    // Light maps with directions and occlusion of the Cornell box, which the program baked.
    case("baked", made::BAKED, SQUARE),
    // The same lit by probes, as harmonics on both kinds of paths, and as cubes.
    case("probes", made::PROBES, SQUARE),
    Case { is_forward: true, ..case("probes-forward", made::PROBES, SQUARE) },
    case("ambient-cubes", made::CUBES, SQUARE),
    // A lamp's light that comes back from walls, found by frames. Here each look finds what others of its round have found, in
    // a still of the program it does not: after eight rounds that is the same but for a part in a hundred.
    Case {
        tolerance: Tolerance { mean: 0.6, ..together(168, 4) },
        settings: &[("captures.probes", "32")],
        frames: 9,
        settles: true,
        ..case("live-probes", made::LIVE_PROBES, SQUARE)
    },
    // Text, lines and a sprite over the picture, from a stage; depth is compared, too.
    case("labels", "docs/examples/labels.stage.toml", WIDE),
    // Others from the page's own calls.
    Case {
        overlay: Some(ITEMS),
        ..case("labels-page", "khronos-sample-assets/Models/BoxTextured/glTF-Binary/BoxTextured.glb", SQUARE)
    },
    // Which of two steps meets the heights first is a matter of rounding along every groove.
    Case {
        tolerance: Tolerance { share: 0.93, share_between: 0.994, mean: 0.75, ..together(52, 16) },
        ..case("relief", "docs/examples/relief.stage.toml", SQUARE)
    },
    // Effects of several passes, and of display colours; `sharpen` would sharpen what rasterizers round differently.
    Case {
        effects: &["bloom", "glow", "smaa", "film"],
        // Whether there is an edge is decided by colours that are rounded differently.
        tolerance: Tolerance { share_between: 0.9976, ..Tolerance::RASTERIZERS },
        ..case("hall-effects", variables::MODEL, WIDE)
    },
    // Frames that are anti-aliased by those before them; the same of half the size; and one enlarged along its edges. What
    // two rasterizers round differently of a lamp that is narrower than a pixel is as much larger there.
    Case { frames: 6, settings: &[("taa.enabled", "true")], ..case("hall-taa", variables::MODEL, WIDE) },
    Case {
        frames: 6,
        settings: &[("taa.enabled", "true"), ("render.scale", "0.5"), ("upscale.method", "temporal")],
        tolerance: Tolerance { share: 0.944, share_between: 0.994, mean: 0.56, ..together(120, 14) },
        ..case("hall-temporal", variables::MODEL, WIDE)
    },
    // The hall's bloom would spread those.
    Case {
        settings: &[("render.scale", "0.5"), ("upscale.method", "edges"), ("chain", "")],
        tolerance: Tolerance { share: 0.885, share_between: 0.984, mean: 0.96, ..together(336, 60) },
        ..case("hall-edges", variables::MODEL, WIDE)
    },
    // What surfaces hide of the environment from each other, filtered as in a picture of one sample.
    Case { settings: &[("occlusion.enabled", "true")], ..case("hall-occlusion", variables::MODEL, WIDE) },
    // The default frame: occlusion and reflections, filtered as in a picture of one sample, and the bloom that the hall
    // brings. A ray that just meets a lamp, or passes it, is filtered over a square.
    Case {
        has_defaults: true,
        tolerance: Tolerance { share: 0.94, share_between: 0.989, mean: 0.5, ..together(290, 130) },
        without: &[&[("reflections.enabled", "false")], &[("chain", "")]],
        ..case("hall-default", variables::MODEL, WIDE)
    },
    Case {
        has_defaults: true,
        // Rays along bumpy metal meet its edges, or pass them.
        tolerance: Tolerance { share: 0.96, share_between: 0.998, mean: 0.54, ..together(108, 14) },
        ..case("helmet-default", HELMET, SQUARE)
    },
    // Boxes send each other and the floor light, beside occlusion by points in a hemisphere.
    Case {
        settings: &[
            ("gi.enabled", "true"),
            ("occlusion.enabled", "true"),
            ("occlusion.method", "ssao"),
            ("environment.source", "studio"),
            ("reflections.enabled", "false"),
            ("shadows.enabled", "false"),
        ],
        // What one texel finds is filtered over a square: 49 pixels by 3 or 4 levels.
        tolerance: together(98, 4),
        without: &[&[("gi.enabled", "false")], &[("occlusion.method", "gtao")]],
        ..case("boxes-gi", turn::MODEL, SQUARE)
    },
    // Shadow maps as coarse, and as far from what casts, as they can be, and what the search of the picture makes of it.
    // A texel of a shadow map that falls to the other side is large here: without contact there are no shadows.
    Case {
        settings: &[
            ("shadows.contact_m", "0.2"),
            ("shadows.atlas_px", "256"),
            ("shadows.bias_texels", "16"),
            ("occlusion.enabled", "false"),
            ("reflections.enabled", "false"),
        ],
        without: &[&[("shadows.contact_m", "0")]],
        ..case("boxes-contact", turn::MODEL, SQUARE)
    },
    // The exposure goes on from frame to frame while the view turns from light to shade: neither at once nor not at all.
    Case {
        frames: 4,
        turntable: 18,
        settings: &[
            ("exposure.adapt", "true"),
            ("exposure.adapt_to_dark_s", "0.3"),
            ("occlusion.enabled", "false"),
            ("reflections.enabled", "false"),
            ("shadows.enabled", "false"),
        ],
        without: &[&[("exposure.adapt_to_dark_s", "0.01")], &[("exposure.adapt_to_dark_s", "3600")]],
        ..case("boxes-adapting", turn::MODEL, SQUARE)
    },
    // Effects that look around, each in passes of its own, while the view turns. Of them all, `fxaa` changes least.
    Case {
        frames: 2,
        turntable: 120,
        settings: &[
            ("chain", "toon,outline,dof,motion_blur,blur,lens,fxaa,sharpen"),
            // Steep steps of light show how half floats are rounded.
            ("toon.softness", "1"),
            ("dof.f_stop", "0.2"),
            ("motion_blur.shutter", "1"),
            ("blur.sigma_px", "1"),
            ("lens.k1", "-0.15"),
            // What is blurred has few edges left.
            ("fxaa.threshold", "0.03"),
            ("fxaa.threshold_dark", "0"),
            ("fxaa.subpixel", "1"),
            ("occlusion.enabled", "false"),
            ("reflections.enabled", "false"),
            ("shadows.enabled", "false"),
        ],
        // Where corners are snapped apart, their smears are too, which hang together over 74 pixels; and eight effects
        // after each other round half floats by a level.
        tolerance: Tolerance { mean: 0.75, ..together(148, 6) },
        without: &[&[("fxaa.enabled", "false")]],
        ..case("boxes-chain", turn::MODEL, SQUARE)
    },
    // Functions of a pixel, two in a pass before the tone curve and two in one after it. Of them all, `look` changes least.
    Case {
        effects: &["xtask/browser/haze.wgsl", "xtask/browser/look.cube"],
        settings: &[
            ("chain", "haze,grade,look,film"),
            ("haze.density_per_m", "0.3"),
            ("grade.temperature_k", "4500"),
            ("look.strength", "0.6"),
            ("occlusion.enabled", "false"),
            ("reflections.enabled", "false"),
            ("shadows.enabled", "false"),
        ],
        without: &[&[("look.enabled", "false")]],
        ..case("boxes-pixels", turn::MODEL, SQUARE)
    },
    // A picture of the environment, with a sun; the page is given its bytes.
    Case { settings: &[("environment.file", "docs/examples/dusk.hdr")], ..case("dusk", SPHERES, WIDE) },
    // The sky is computed in the page, too, and metered.
    Case {
        settings: &[("environment.source", "sky"), ("environment.sun_elevation_deg", "12")],
        ..case("sky", SPHERES, WIDE)
    },
    // Every other way in which lights reach surfaces, where thousands do.
    Case { settings: &[("lights.culling", "tiled")], ..case("hall-tiled", variables::MODEL, WIDE) },
    Case { settings: &[("lights.culling", "volumes")], ..case("hall-volumes", variables::MODEL, WIDE) },
    Case { settings: &[("lights.culling", "volumes-stencil")], ..case("hall-stencil", variables::MODEL, WIDE) },
    Case { settings: &[("render.path", "forward-batched")], ..case("spots-batched", SPOTS, SQUARE) },
    // At corners that light only just reaches, rounding decides whether they are in shadow, and corners are shared.
    Case {
        settings: &[("render.path", "gouraud"), ("shadows.enabled", "false")],
        ..case("hall-gouraud", variables::MODEL, WIDE)
    },
    // Lamps behind columns, and the shafts of their light in mist.
    case("shafts", "docs/examples/shafts.stage.toml", WIDE),
    // A white floor under three lights of 10⁶ cd, a part of which glows: emission, lights and studio all end at the
    // limit of half floats, and the effect adds that to itself.
    Case { echo: WHOLE, is_dazzling: true, ..case("bright", "xtask/browser/bright.gltf", SQUARE) },
    case("shadow_mapping_spots", SPOTS, SQUARE),
    case("shadow_mapping_points", POINTS, SQUARE),
    Case { settings: &[("shadows.filter", "pcss")], ..case("points-pcss", POINTS, SQUARE) },
    case("DirectionalLight", "", SQUARE),
    Case { settings: SHADOWLESS, ..case("lightfield_1024", "lightfield/lightfield_1024.glb", (960, 540)) },
    Case { settings: SHADOWLESS, ..case("lightfield_10000", "lightfield/lightfield_10000.glb", (960, 540)) },
    // Soft boxes of the studio, which have edges, in bumpy metal: 50 pixels by 3 to 5 levels.
    Case { tolerance: together(100, 4), ..case("DamagedHelmet", "", SQUARE) },
    // Levels of meshes and of materials that fade into each other. Where a ball ends, two of its levels do, whose
    // vertices are snapped each for itself. Seen twice bent through a ball, a step of depth behind it is several pixels
    // of the wall: 857 that hang together, nearly all of which show what is beside them.
    Case {
        tolerance: Tolerance { share: 0.93, share_between: 0.995, mean: 0.9, ..together(1714, 18) },
        ..case("levels", "xtask/browser/levels.stage.toml", WIDE)
    },
    // The ground's shadow is steep along the edge on which the box stands: 73 pixels by 3 levels.
    Case { tolerance: together(146, 4), ..case("BoxTextured", "", SQUARE) },
    case("NormalTangentMirrorTest", "", SQUARE),
    case("AlphaBlendModeTest", "", SQUARE),
    // Edges and masks of four samples a pixel. Where alpha hardly changes, rounding decides which of two numbers of
    // samples chance gives: 38 pixels by the share of a sample, and 4 of them between no others.
    Case {
        is_forward: true,
        tolerance: together(76, 8),
        settings: &[("msaa.samples", "4"), ("transparency.masks", "hashed")],
        ..case("masks-multisampled", MASKS, SQUARE)
    },
    case("CesiumMan", "", SQUARE),
    case("MorphStressTest", "", SQUARE),
    case("TextureSettingsTest", "", SQUARE),
    // Layers of materials: maps in textures of layers, and what is seen through glass.
    case("ClearCoatTest", "", SQUARE),
    // Texels of a shadow, refracted and blurred: 44 pixels by 3 to 6 levels.
    Case { tolerance: together(88, 38), ..case("AttenuationTest", "", SQUARE) },
    Case { is_forward: true, ..case("SpecularTest", "", SQUARE) },
    // Metered at 128 pixels, in the dark but for lamps: mirrored in edges of glass these are a few pixels, which weigh
    // much. 0.032 stops were seen.
    Case { exposure_within_stops: 0.06, ..case("IridescenceSuzanne", "", SQUARE) },
    // Sheen, and glass that refracts colours apart, smooth and rough. Stripes along the edges of balls, twice bent, are
    // narrower than pixels: 68 by more than 2 levels, one of them between no others.
    Case {
        tolerance: Tolerance { share_between: 0.998, ..together(136, 4) },
        ..case("layers", "xtask/browser/layers.gltf", SQUARE)
    },
    // Light that comes through from behind, and specular-glossiness, both in a variant.
    // The ground's shadow is steep where they stand: 73 pixels by 3 to 5 levels.
    Case {
        tolerance: together(146, 4),
        variant: Some("layered"),
        ..case("scattering", "xtask/browser/scattering.gltf", SQUARE)
    },
    // Textures of KTX2 (UASTC), one of which has directions of anisotropy.
    case("AnisotropyBarnLamp", "bevy/AnisotropyBarnLamp/AnisotropyBarnLamp.gltf", SQUARE),
    case("meshopt", "loaders.gl/BoxTextured_meshopt.glb", SQUARE),
    // The bytes tell the format: the page is given this one as a .glb, too. It is grey, which no comparison of colours
    // would fail at.
    Case { settings: &[("background.source", "c06030")], ..case("part", "xtask/browser/part.stl", SQUARE) },
    // The page shows what the file's camera does, and the command line would take another, because the duck is small.
    Case { camera: Some("0"), ..case("Draco", "khronos-sample-assets/Models/Duck/glTF-Draco/Duck.gltf", SQUARE) },
    // Six faces, which the page is given as one container.
    Case { settings: &[("environment.file", made::CUBE)], ..case("cube", SPHERES, WIDE) },
    // Two targets of one blend state: sums, and weights.
    Case {
        settings: &[("transparency.mode", "weighted")],
        ..case("panes-weighted", "docs/examples/panes.gltf", SQUARE)
    },
    // What is blended before glass and behind it, each in a pass of its own. One sample is noise: along an edge of a
    // pane that two rasterizers end a pixel apart, 77 pixels hang together, each of which shows what is beside it.
    Case {
        tolerance: together(154, 4),
        settings: &[("transparency.mode", "stochastic")],
        ..case("glass-stochastic", "xtask/browser/glass.gltf", SQUARE)
    },
];
