//! Flags that several subcommands share: what the frame is, what lies around the scene, and the cache.

use clap::Args;
use clap::builder::PossibleValuesParser;
use std::path::PathBuf;

/// Flags that change settings, in every subcommand that draws. One that is left out changes nothing, so that a file of
/// settings decides.
#[derive(Debug, Default, PartialEq, Args)]
pub struct ChangeArgs {
    /// Which shading path draws opaque surfaces; short for --set render.path [default: deferred].
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(manypass::Path::NAMES))]
    pub path: Option<String>,
    /// The method of light culling; short for --set lights.culling [default: clustered].
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(manypass::LightCulling::NAMES))]
    pub light_culling: Option<String>,
    /// The quality tier: a table of settings that comes before all others [default: medium].
    ///
    /// `manypass settings --quality NAME` prints it.
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(manypass::Quality::NAMES))]
    pub quality: Option<String>,
    /// Put an effect before or after the tone curve, by its name or in a WGSL file of your own; may be given again.
    ///
    /// Built in are bloom, blur, dof, film, fxaa, glow, grade, lens, motion_blur, outline, sharpen, smaa and toon; docs/effects.md
    /// has the form of a file. Each declares its settings with their defaults; `manypass settings --effect
    /// NAME|FILE.wgsl` lists them.
    #[arg(long = "effect", value_name = "NAME|FILE.wgsl")]
    pub effects: Vec<PathBuf>,
    /// Change a setting; `manypass settings` lists the keys; may be given again.
    ///
    /// It comes after every flag: `--tonemap aces --set tone_map.curve=agx` is agx. A setting of an effect is
    /// EFFECT.MEMBER. Vectors and colours have commas between their numbers: `--set own_pass.line_color=0.9,0.7,0.4`.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Flags of the environment, for all subcommands that draw or bake.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub struct EnvironmentArgs {
    /// The environment: auto, studio, fill (a faint studio), sky (--set environment.sun_elevation_deg=20), none, or a
    /// colour, sRGB (ff8800) or linear (1,0.25,0). Or an environment map: equirectangular (FILE.hdr, FILE.exr), a cube
    /// map (FILE.ktx2), or a folder with six faces (px, nx, py, ny, pz, nz) [default: auto: fill if the file has lights,
    /// else studio].
    #[arg(long, value_name = "ENV")]
    pub environment: Option<String>,
    /// Rotate the environment map about the vertical, counter-clockwise seen from above [default: 0].
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub environment_rotation: Option<String>,
    /// Multiply the environment's radiance [default: 1].
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub environment_intensity: Option<String>,
}

/// Flags of the frame, for `render`, `graph` and `diff` of models.
#[derive(Debug, Default, PartialEq, Args)]
pub struct FrameArgs {
    /// A set of settings for a purpose. product: the studio and its ground, without the file's lights. scene: only the
    /// file's lights and environment. data: raw radiance, with exposure 0 and no environment, ground, effects or tone
    /// curve. It comes after a stage's settings; flags come after it.
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(crate::preset::Preset::NAMES))]
    pub preset: Option<String>,
    /// Width and height in pixels; the vertical field of view stays.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: String,
    /// The number of samples a pixel: jittered frames that are averaged. Later ones skip converged tiles
    /// (adaptive.threshold in docs/settings.md).
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub samples: u32,
    /// A scene of the file [default: the one that the file names].
    #[arg(long, value_name = "NAME|INDEX")]
    pub scene: Option<String>,
    /// A material variant of the file; or `all` of them, each a picture [default: the file's own materials].
    #[arg(long, value_name = "NAME|INDEX|all")]
    pub variant: Option<String>,
    /// A camera of the file; `all`, each a picture; or `auto`, which shows the whole model, or a room from inside.
    #[arg(long, value_name = "NAME|INDEX|auto|all", conflicts_with_all = ["eye", "orbit", "target", "up", "fov_y", "ortho_height", "near", "far"])]
    pub camera: Option<String>,
    /// Where the camera is, in metres.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "orbit")]
    pub eye: Option<String>,
    /// Orbit the camera around the target: degrees, degrees, metres (or `auto`).
    #[arg(long, value_name = "YAW,PITCH,RADIUS", allow_hyphen_values = true)]
    pub orbit: Option<String>,
    /// What the camera looks at [default: the middle of the model, or as the file's camera does].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub target: Option<String>,
    /// What is up [default: 0,1,0, or as for the file's camera].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub up: Option<String>,
    /// The vertical field of view in degrees [default: 45, or the file's camera's].
    #[arg(long, value_name = "DEG", conflicts_with = "ortho_height")]
    pub fov_y: Option<f32>,
    /// Parallel rays: the height of the picture in metres.
    #[arg(long, value_name = "M")]
    pub ortho_height: Option<f32>,
    /// The near plane in metres [default: fitted, or the file's camera's].
    #[arg(long, value_name = "M")]
    pub near: Option<f32>,
    /// The far plane in metres [default: none, or the file's camera's].
    #[arg(long, value_name = "M")]
    pub far: Option<f32>,
    #[command(flatten)]
    pub around: EnvironmentArgs,
    /// The background: environment, transparent or a colour, sRGB (ff8800) or linear (1,0.25,0). Two colours
    /// (ff8800,112233) are a gradient from the lower to the upper edge. Tone mapping and exposure do not change colours
    /// [default: environment].
    #[arg(long, value_name = "WHAT")]
    pub background: Option<String>,
    /// The ground under the model: shadow (a shadow catcher), none, or a colour (a floor) [default: auto: shadow in the
    /// studio, also fill, under the sky and in a picture, unless the background is transparent, else none].
    #[arg(long, value_name = "WHAT")]
    pub ground: Option<String>,
    /// The exposure in stops. Or auto: metered, with compensation as in auto+1 or auto-0.5. Or scene: what the file
    /// states, else auto if it has lights, under the sky or with an environment map, else 0 [default: scene].
    ///
    /// 0 shows radiance as it is. `auto` meters the log-average luminance of the surfaces, under the file's lights and
    /// its glow. It does so at time 0, before a turntable turns, at the same size for every --size. Within half a stop
    /// of mid grey (0.18) nothing changes. Beyond that, of t stops t / (1 + t) remain, so that night stays darker than
    /// day. Under the sky and with an environment map it is the environment's exposure. Surfaces move that by half a
    /// stop, and bright saturated colours lower it by up to one (docs/exposure.md). .exr stays scene-linear without any
    /// exposure.
    #[arg(long, value_name = "STOPS|auto|scene", allow_hyphen_values = true)]
    pub exposure: Option<String>,
    /// The tone mapper; short for --set tone_map.curve [default: neutral].
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(manypass::Tonemap::NAMES))]
    pub tonemap: Option<String>,
    /// `all`, or names with commas: layers of .exr, or .png files of their own; --help says what each holds.
    #[arg(long, value_name = "all|LIST", long_help = manypass_offline::aov_docs::help())]
    pub aov: Option<String>,
    #[command(flatten)]
    pub change: ChangeArgs,
    /// A TOML file of settings, such as `vignette = 0.9` below `[own_pass]`. It comes after a stage's settings, and
    /// before flags and `--set`.
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
}

/// Flags of the cache, for all subcommands that draw more than once.
#[derive(Debug, Args)]
pub struct CacheArgs {
    /// Do not use the cache of prefiltered environment maps and of meshes' levels of detail.
    ///
    /// The cache is the folder `manypass` in $XDG_CACHE_HOME, or where the system has caches, and holds 512 MiB at most.
    /// MANYPASS_NO_CACHE=1 is the same.
    #[arg(long)]
    pub no_cache: bool,
}
