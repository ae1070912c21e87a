//! The command line as it is typed. [`crate::job`] makes sense of it.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Renders glTF files, with a GPU or without, in many passes.
#[derive(Debug, Parser)]
#[command(name = "manypass", version, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "Examples:
  manypass render helmet.glb                              helmet.png in this folder
  manypass render helmet.glb -o out.exr --aov all         linear colour, depth, normals, … as layers
  manypass render models/ -o 'shots/{stem}.png'           every model of a folder
  manypass render helmet.glb --turntable 36 -o 'turn/{frame:04}.png'
  manypass graph helmet.glb --format mermaid              the passes of the frame
  manypass adapters                                       what can render on this machine

Exit codes: 0 done, 1 an input or output failed, 2 wrong usage, 3 no usable adapter, 4 device lost, 130 interrupted.
A picture that does not fit into memory (`ulimit -v`, a container's limit, what is free) is refused with 1, a limit
below what a driver needs with 3.";

const RENDER_EXAMPLES: &str = "Examples:
  manypass render a.glb --orbit -30,10,auto --size 1920x1080
  manypass render a.glb --eye 2,1,3 --target 0,0.5,0 --fov-y 35
  manypass render a.glb --background transparent -o cut-out.png
  manypass render a.glb --animation Walk --frames 0..47 --fps 24 -o 'walk/{frame:04}.png'
  cat a.glb | manypass render - -o - --format png > a.png

Without a camera flag: the file's first camera, else the whole model from yaw 30, pitch 20.
Yaw 0 looks along -Z from +Z and grows towards +X; positive pitch looks down from above.
Without lights in the file and without --environment, the environment is `studio`.";

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render pictures of one or more inputs.
    #[command(after_help = RENDER_EXAMPLES)]
    Render(Box<RenderArgs>),
    /// Say what is in a file, without a GPU.
    Info {
        /// A .glb or .gltf file, `-` for standard input, or demo:NAME.
        input: String,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Print the passes of a frame.
    Graph {
        /// A .glb or .gltf file, `-` for standard input, or demo:NAME.
        input: String,
        /// How to print them.
        #[arg(long, default_value = "text")]
        format: GraphFormat,
        /// Render on the adapter whose name contains this.
        #[arg(long)]
        adapter: Option<String>,
    },
    /// Measure milliseconds per frame: with the file's camera and lights alone, without environment and tone curve.
    Bench(BenchArgs),
    /// List the adapters of this machine.
    Adapters {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// How `graph` prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names say it")]
pub enum GraphFormat {
    Text,
    Json,
    Mermaid,
}

/// Which shading path draws opaque surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names say it")]
pub enum PathArg {
    Deferred,
    Forward,
}

/// How lights are found for a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names say it")]
pub enum CullingArg {
    Clustered,
    None,
}

/// The tone mapper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names say it")]
pub enum TonemapArg {
    Neutral,
    Aces,
    Agx,
    Reinhard,
    Exponential,
    None,
}

/// Flags of `bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// A .glb or .gltf file, `-` for standard input, or demo:NAME.
    pub input: String,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: String,
    /// How many frames to measure.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    pub count: u32,
    /// Stop after this many milliseconds, whatever the count.
    #[arg(long, value_name = "MS")]
    pub budget_ms: Option<f64>,
    /// Write the last frame here.
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Print the line of JSON alone, without the summary before it.
    #[arg(long)]
    pub json: bool,
    /// Which shading path draws opaque surfaces.
    #[arg(long, default_value = "deferred")]
    pub path: PathArg,
    /// How lights are found for a pixel.
    #[arg(long, default_value = "clustered")]
    pub light_culling: CullingArg,
    /// Render on the adapter whose name contains this.
    #[arg(long)]
    pub adapter: Option<String>,
}

/// Flags of `render`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("times").args(["time", "frames"])))]
pub struct RenderArgs {
    /// .glb or .gltf files, folders of them, `-` for standard input, or demo:NAME.
    #[arg(required = true)]
    pub inputs: Vec<String>,
    /// A file, a folder, a pattern with {stem}, {frame:04} and {aov}, or `-` for standard output [default: STEM.png].
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<String>,
    /// png, jpg, webp or exr [default: by the name of OUT].
    #[arg(long)]
    pub format: Option<String>,
    /// Width and height in pixels; the vertical field of view stays.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: String,
    /// Jittered frames that are averaged.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub samples: u32,
    /// A camera of the file.
    #[arg(long, value_name = "NAME|INDEX", conflicts_with_all = ["eye", "orbit", "target", "up", "fov_y", "ortho_height", "near", "far"])]
    pub camera: Option<String>,
    /// Where the camera is, in metres.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "orbit")]
    pub eye: Option<String>,
    /// The camera around the target: degrees, degrees, metres (or `auto`).
    #[arg(long, value_name = "YAW,PITCH,RADIUS", allow_hyphen_values = true)]
    pub orbit: Option<String>,
    /// What the camera looks at [default: the middle of the model].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub target: Option<String>,
    /// What is up [default: 0,1,0].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub up: Option<String>,
    /// The vertical field of view in degrees [default: 45].
    #[arg(long, value_name = "DEG", conflicts_with = "ortho_height")]
    pub fov_y: Option<f32>,
    /// Parallel rays: the height of the picture in metres.
    #[arg(long, value_name = "M")]
    pub ortho_height: Option<f32>,
    /// The near plane in metres [default: fitted].
    #[arg(long, value_name = "M")]
    pub near: Option<f32>,
    /// The far plane in metres [default: none].
    #[arg(long, value_name = "M")]
    pub far: Option<f32>,
    /// studio, none or an sRGB colour.
    #[arg(long, value_name = "ENV")]
    pub environment: Option<String>,
    /// Multiplies the environment.
    #[arg(long, default_value_t = 1.0)]
    pub environment_intensity: f32,
    /// environment, transparent or an sRGB colour.
    #[arg(long, default_value = "environment")]
    pub background: String,
    /// Exposure compensation in stops; .exr stays scene-linear without it.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// The tone mapper.
    #[arg(long, default_value = "neutral")]
    pub tonemap: TonemapArg,
    /// Which shading path draws opaque surfaces.
    #[arg(long, default_value = "deferred")]
    pub path: PathArg,
    /// How lights are found for a pixel.
    #[arg(long, default_value = "clustered")]
    pub light_culling: CullingArg,
    /// `all`, or names with commas: layers of .exr, or .png files of their own.
    ///
    /// Names: base_color, occlusion, normal, normal_view, position, depth, metallic, roughness, emission, motion,
    /// object_id, material_id, radiance. They show opaque and masked surfaces, not blended ones, and come from the first
    /// sample; radiance alone is the average of all, with everything. Ids are indices plus 1, and 0 is nothing. Motion
    /// is in pixels since the frame before (`--frames`, `--time`, `--turntable`), +x right, +y down; its PNG holds
    /// 0.5 + motion / 64. PNGs of normals hold 0.5 + normal / 2.
    #[arg(long, value_name = "all|LIST")]
    pub aov: Option<String>,
    /// Write the picture of every pass into this folder.
    #[arg(long, value_name = "DIR")]
    pub dump_passes: Option<PathBuf>,
    /// Write the pictures of all passes into one picture.
    #[arg(long, value_name = "FILE.png")]
    pub contact_sheet: Option<PathBuf>,
    /// The time of the animation in seconds.
    #[arg(long, value_name = "SECS", conflicts_with = "frames", allow_negative_numbers = true)]
    pub time: Option<f32>,
    /// An animation of the file [default: the first, if a time or frames are given].
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,
    /// Frames from A to B, both included, at frame / fps seconds.
    #[arg(long, value_name = "A..B", conflicts_with = "turntable")]
    pub frames: Option<String>,
    /// Frames a second; `--time` uses it for motion alone.
    #[arg(long, default_value_t = 24.0, requires = "times")]
    pub fps: f32,
    /// N frames around the target.
    #[arg(long, value_name = "N", conflicts_with_all = ["camera", "eye"], value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub turntable: Option<u32>,
    /// Put a pass of your own, one WGSL file, before the tone curve; may be given again.
    #[arg(long = "effect", value_name = "FILE.wgsl")]
    pub effects: Vec<PathBuf>,
    /// Change a setting; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// A TOML file of settings.
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
    /// Render on the adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Write what was done, as JSON (JSON Lines for several pictures).
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Leave pictures alone that exist.
    #[arg(long)]
    pub skip_existing: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
}
