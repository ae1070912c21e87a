//! The command line as it is typed. [`crate::job`] makes sense of it.

#[cfg(feature = "bake")]
pub mod bake;
pub mod diff;
mod frame;

pub use frame::{CacheArgs, ChangeArgs, FrameArgs};

#[cfg(feature = "bake")]
use bake::BakeArgs;
use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use diff::DiffArgs;
use std::ffi::OsString;
use std::path::PathBuf;

/// Renders glTF files, and OBJ, STL, PLY and 3MF, with a GPU or without, in many passes.
#[derive(Debug, Parser)]
#[command(name = "manypass", version, arg_required_else_help = true, after_help = EXAMPLES)]
#[command(args_override_self = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "Examples:
  manypass render helmet.glb                              helmet.png in this folder
  manypass render part.stl --orbit 30,20,auto             part.png, seen from another side
  manypass render helmet.glb -o out.exr --aov all         linear colour, depth, normals, … as layers
  manypass render models/ -o 'shots/{stem}.png'           every model of a folder
  manypass render 'models/**/*.glb' -o 'shots/{parent}_{stem}.png'
  manypass render shoe.glb --variant all                  shoe_VARIANT.png, one for each set of materials
  manypass render helmet.glb --turntable 36 -o 'turn/{frame:04}.png'
  manypass render helmet.glb --cameras transforms.json -o 'views/{camera}.png'
  manypass render hall.stage.toml                         a model with lights and fog of yours (docs/stage.md)
  manypass bake room.glb -o baked.glb                     light maps: light that walls send each other (docs/baking.md)
  manypass graph helmet.glb --format mermaid              the passes of the frame
  manypass graph helmet.glb --format table                as a table: targets, formats, megabytes
  manypass graph helmet.glb --limits webgl2 --aov all     planned without any adapter
  manypass diff before.png after.png -o diff.png          how different two pictures look, and where
  manypass diff before.glb after.glb                      whether geometry, material or light changed
  manypass settings                                       every key of --set, with its range
  manypass adapters                                       what can render on this machine

Exit codes: 0 done, 1 an input or output failed, 2 wrong usage, 3 no usable adapter, 4 device lost, 5 `diff` found more than \
--threshold, 130 interrupted.
A picture that does not fit into memory (`ulimit -v`, a container's limit, what is free) is refused with 1, a limit \
below what a driver needs with 3.";

const RENDER_EXAMPLES: &str = "Examples:
  manypass render a.glb --orbit -30,10,auto --size 1920x1080
  manypass render a.glb --eye 2,1,3 --target 0,0.5,0 --fov-y 35
  manypass render a.glb --background transparent -o cut-out.png
  manypass render a.glb --animation Walk --frames 0..47 --fps 24 -o 'walk/{frame:04}.png'
  cat a.glb | manypass render - -o - --format png > a.png
  manypass render a.glb --turntable 96 -o - --format y4m | ffmpeg -i - turn.mp4
  manypass render models/ --aov depth,normal -o data.npz

Without --camera, --eye and --orbit: the file's first camera, which --target, --up, --fov-y, --ortho-height, --near and \
--far change; else, and where that camera shows less than a tenth of the model or the model in less than a tenth of the picture, \
the whole model from yaw 30, pitch 28, a margin of 6 % around it; a room without a camera from inside. \
With --time, --frames or --animation the whole model is all that it covers while the animation plays.
Yaw 0 looks along -Z from +Z and grows towards +X; positive pitch looks down from above.
Without --environment it is `studio`; where the file has lights it is faint, and exposure is `auto`. \
Under the sky and in a picture exposure is `auto`, too, and a shadow lies under the model.";

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render pictures of one or more inputs.
    #[command(after_help = RENDER_EXAMPLES)]
    Render(Box<RenderArgs>),
    /// Say what is in a file, without a GPU.
    Info {
        /// A model (.glb, .gltf, .obj, .stl, .ply, .3mf), a .stage.toml file, `-` for standard input, or demo:NAME.
        input: OsString,
        /// A scene of the file [default: the one that the file names].
        #[arg(long, value_name = "NAME|INDEX")]
        scene: Option<String>,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Print the passes of the frame that `render` draws, with the same flags.
    Graph(Box<GraphArgs>),
    /// Say how different two pictures look, a FLIP error from 0 (the same) to 1, or how two models differ.
    #[command(after_help = diff::EXAMPLES)]
    Diff(Box<DiffArgs>),
    /// Compute light beforehand: a glTF file with light maps, which is drawn with the light that surfaces send each other.
    #[cfg(feature = "bake")]
    #[command(after_help = bake::EXAMPLES)]
    Bake(Box<BakeArgs>),
    /// Measure milliseconds per frame: with the file's camera and lights alone, without environment and tone curve.
    Bench(Box<BenchArgs>),
    /// List the adapters of this machine.
    Adapters {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// List the keys of `--set` and of files of `--settings`, without a GPU.
    Settings {
        /// List the keys of this effect too; may be given again.
        #[arg(long = "effect", value_name = "NAME|FILE.wgsl")]
        effects: Vec<PathBuf>,
        /// Print JSON: an array of objects with key, type, default, min, max, choices, unit, needs, doc.
        ///
        /// `needs` lists every KEY=VALUE without which the key does nothing.
        #[arg(long)]
        json: bool,
        /// Print a JSON Schema of files of --settings, for editors.
        #[arg(long, conflicts_with = "json")]
        schema: bool,
        /// Print the JSON Schema of stages, NAME.stage.toml, for editors.
        #[arg(long, conflicts_with_all = ["json", "schema", "effects"])]
        stage_schema: bool,
        /// Print what comes of this as a file of --settings has it, after the tier if there is one; may be given again.
        #[arg(long, value_name = "KEY=VALUE", conflicts_with_all = ["json", "schema", "stage_schema"])]
        set: Vec<String>,
        /// Print the settings of a tier of --quality, as a file of --settings has them.
        #[arg(long, value_name = "NAME", conflicts_with_all = ["json", "schema", "stage_schema"],
              value_parser = PossibleValuesParser::new(manypass::Quality::NAMES))]
        quality: Option<String>,
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
    Table,
    Json,
    Mermaid,
}

/// Flags of `graph`.
#[derive(Debug, Args)]
pub struct GraphArgs {
    /// A model (.glb, .gltf, .obj, .stl, .ply, .3mf), a .stage.toml file, `-` for standard input, or demo:NAME.
    pub input: String,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// How to print them; table: a line for each target, with draw calls and megabytes (10⁶ bytes).
    #[arg(long, default_value = "text")]
    pub format: GraphFormat,
    /// Plan for the adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Plan, without any adapter, for what every adapter of WebGPU or of WebGL 2 offers.
    #[arg(long, value_name = "NAME", conflicts_with = "adapter", value_parser = PossibleValuesParser::new(manypass::gpu::Floor::NAMES))]
    pub limits: Option<String>,
}

/// Flags of `bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// A model (.glb, .gltf, .obj, .stl, .ply, .3mf), a .stage.toml file, `-` for standard input, or demo:NAME.
    pub input: String,
    /// A scene of the file [default: the one that the file names].
    #[arg(long, value_name = "NAME|INDEX")]
    pub scene: Option<String>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: String,
    /// How many frames to measure.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    pub count: u32,
    /// Stop after this many milliseconds, whatever the count.
    #[arg(long, value_name = "MS")]
    pub budget_ms: Option<f64>,
    /// Draw the first frame alone, for what takes minutes: neither passes are timed nor pairs counted.
    #[arg(long, conflicts_with_all = ["count", "budget_ms"])]
    pub first_frame: bool,
    /// Draw frames as a page does: with the settings of `render`, each of one sample and over what effects keep of the one
    /// before. Only so does --set quality.budget_ms choose settings by what frames take; the summary says which.
    #[arg(long)]
    pub live: bool,
    /// Write the last frame here.
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Print the line of JSON alone, without the summary and the table of passes before it.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub change: ChangeArgs,
    /// Render on the adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Whether there is a cache.
    #[command(flatten)]
    pub cache: CacheArgs,
}

/// Flags of `render`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("times").args(["time", "frames", "turntable"]).multiple(true)))]
pub struct RenderArgs {
    /// Models (.glb, .gltf, .obj, .stl, .ply, .3mf; docs/inputs.md), .stage.toml files, folders of them, patterns
    /// ('models/**/*.glb'), `-` for standard input, or demo:NAME.
    ///
    /// A stage names its model and adds lights, environment, fog and settings to it (docs/stage.md). In a folder, and
    /// among what a pattern matches, it stands for that model, which is not drawn by itself, too; a model never reads a
    /// stage. In a quoted pattern * and ? stand for letters of a name and ** for any folders. Hidden files and folders
    /// are left out.
    #[arg(required = true)]
    pub inputs: Vec<OsString>,
    /// Look into the folders of folders, too.
    #[arg(long)]
    pub recursive: bool,
    /// A file, a folder, a pattern, a device or pipe, or `-` for standard output [default: STEM.png].
    ///
    /// A name without an ending, or with a slash at its end, is a folder, which is made if it is not there.
    /// A pattern holds {parent} (the name of the input's folder), {stem} (the input's name without its ending; with it
    /// where a folder has both m.glb and m.gltf), {variant}, {camera}, {frame} or {frame:04}, and {aov}. With --frames
    /// and --turntable a folder gets STEM_FRAME, and a file must hold {frame}; with --variant all, --camera all and
    /// --cameras likewise. With --format y4m, npz or tar, or such an ending, one stream takes all pictures of the call, as
    /// in `-o - --format y4m | ffplay -` (docs/streams.md). An output that is also read, or written twice, is refused.
    /// Files named .manypass-….partial beside it are being written; those that a killed process left may be deleted.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<String>,
    /// png, jpg, webp or exr, for standard output, a folder or another ending, too; or all pictures in one stream, with
    /// -o - or a file: y4m, npz, tar [default: by the ending of OUT, else png].
    ///
    /// y4m is raw video (YUV 4:4:4, BT.709, limited range) at --fps, without alpha. npz holds NumPy's arrays: frames
    /// (picture, row, column, RGBA; uint8), and one of numbers for each variable of --aov. tar holds .png files, or
    /// .exr with --aov, named as in a folder.
    #[arg(long)]
    pub format: Option<String>,
    /// How the pixels of .exr are packed, each way without loss: zip (16 rows at a time), zips (row by row), rle (runs
    /// of equal bytes), piz (wavelets, 32 rows at a time), none [default: zip].
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(manypass_offline::ExrCompression::NAMES))]
    pub exr_compression: Option<String>,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Many views at once: poses and fields of view from a NeRF transforms.json, or from a COLMAP folder with
    /// cameras and images (.bin or .txt; sparse/0 below it is found, too). {camera} is the name of each image.
    ///
    /// `manypass render a.glb --cameras transforms.json --size 800x800 -o 'out/{camera}.png'` reads the model once.
    /// Axes of the world are the model's. A camera looks along -Z with +Y up in transforms.json, along +Z with +Y down
    /// in COLMAP. Pictures have square pixels, the middle as principal point and no distortion; where the file says
    /// otherwise there is a warning. Give --exposure 0 for the same exposure in all of them. See docs/camera.md.
    #[arg(long, value_name = "FILE.json|DIR", conflicts_with_all =
          ["camera", "eye", "orbit", "target", "up", "fov_y", "ortho_height", "turntable"])]
    pub cameras: Option<PathBuf>,
    /// Write the picture of every pass into this folder.
    #[arg(long, value_name = "DIR")]
    pub dump_passes: Option<PathBuf>,
    /// Write the pictures of all passes into one picture, grouped by pass, with the legends of those that have one.
    #[arg(long, value_name = "FILE.png")]
    pub contact_sheet: Option<PathBuf>,
    /// The time of the animation in seconds.
    #[arg(long, value_name = "SECS", conflicts_with = "frames", allow_negative_numbers = true)]
    pub time: Option<f32>,
    /// An animation of the file [default: the first, if a time or frames are given].
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,
    /// Frames from A to B, both included, at frame / fps seconds.
    #[arg(long, value_name = "A..B")]
    pub frames: Option<String>,
    /// Frames a second; `--time` uses it for motion alone, `--turntable` for video and what adapts from frame to frame.
    #[arg(long, default_value_t = 24.0, requires = "times")]
    pub fps: f32,
    /// Turn around the target, once in N frames: frames 0 to N - 1, or those of `--frames`, which play meanwhile. With
    /// `--time` the animation stands still. It goes around the whole model from outside, whether the file has a camera
    /// or not, unless --orbit says how far; in a room it turns in the middle.
    #[arg(long, value_name = "N", conflicts_with_all = ["camera", "eye"], value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub turntable: Option<u32>,
    /// Render on the adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Whether there is a cache.
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Write what was done, as JSON, to a file or `-`; as JSON Lines wherever there may be several pictures.
    ///
    /// Several pictures: more than one input, a folder or a pattern, --frames, --turntable, --variant all, --camera
    /// all or --cameras. Each line is there as soon as its picture is done. With --skip-existing lines are added to
    /// those that are there, and a report of one picture that is left alone stays as it is. Beside the report of one
    /// picture on standard output, a table of its passes goes to standard error, unless --quiet.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Leave pictures alone that exist, with their contact sheet and passes where those are asked for.
    #[arg(long)]
    pub skip_existing: bool,
    /// Fail where there would be a warning; the picture is not written.
    #[arg(long)]
    pub strict: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
}
