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
  manypass bake room.glb -o baked.glb                     light maps: baked indirect light (docs/baking.md)
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

Without --camera, --eye and --orbit it is the file's first camera, changed by --target, --up, --fov-y, --ortho-height, \
--near and --far. It is replaced if it shows less than a tenth of the model, or the model in less than a tenth of the picture. \
Then, and without any camera, the whole model is shown from yaw 30, pitch 28 with a margin of 6 %. A room without a camera is \
shown from inside. With --time, --frames or --animation the whole model is all that it covers while the animation plays.
Yaw 0 looks along -Z from +Z and grows towards +X; positive pitch looks down from above.
The default of --environment is `studio`. If the file has lights, it is `fill` (a faint studio), and exposure is `auto`. \
Under the sky and in a picture exposure is `auto`, too, and a shadow catcher lies under the model.";

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
    /// Bake light: write a glTF file with light maps, which hold the indirect light.
    #[cfg(feature = "bake")]
    #[command(after_help = bake::EXAMPLES)]
    Bake(Box<BakeArgs>),
    /// Measure milliseconds per frame, with only the file's camera and lights, without environment and tone curve.
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
        /// Print the changed settings as a file of --settings, after those of the tier; may be given again.
        #[arg(long, value_name = "KEY=VALUE", conflicts_with_all = ["json", "schema", "stage_schema"])]
        set: Vec<String>,
        /// Print the settings of a quality tier as a file of --settings.
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
    /// The form of output; table: a line for each target, with draw calls and megabytes (10⁶ bytes).
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
    /// Draw only the first frame, for frames that take minutes: passes are not timed and pairs are not counted.
    #[arg(long, conflicts_with_all = ["count", "budget_ms"])]
    pub first_frame: bool,
    /// Draw live frames as a page does: with the settings of `render`, one sample a frame, and temporal histories. Only
    /// then does the frame-time budget (--set quality.budget_ms) choose settings; the summary names them.
    #[arg(long)]
    pub live: bool,
    /// Write the last frame here.
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Print only the line of JSON, without the summary and the table of passes.
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
    /// A stage names its model and adds lights, environment, fog and settings to it (docs/stage.md). In a folder or a
    /// pattern it replaces that model, which is not drawn by itself, too. A model never reads a stage. In a quoted
    /// pattern * and ? stand for letters of a name and ** for any folders. Hidden files and folders are left out.
    #[arg(required = true)]
    pub inputs: Vec<OsString>,
    /// Look into the folders of folders, too.
    #[arg(long)]
    pub recursive: bool,
    /// A file, a folder, a pattern, a device or pipe, or `-` for standard output [default: STEM.png].
    ///
    /// A name without an ending, or with a slash at its end, is a folder, which is made if it is missing.
    /// A pattern holds {parent} (the name of the input's folder), {stem}, {variant}, {camera}, {frame} or {frame:04}, and
    /// {aov}. {stem} is the input's name without its ending, or with it if a folder has both m.glb and m.gltf. With
    /// --frames and --turntable a folder gets STEM_FRAME, and a file must hold {frame}. The same holds for --variant all,
    /// --camera all and --cameras. With --format y4m, npz or tar, or such an ending, one stream takes all pictures of the
    /// call, as in `-o - --format y4m | ffplay -` (docs/streams.md). An output that is also read, or written twice, is
    /// refused. Files named .manypass-….partial are outputs in progress; delete those that a killed process left.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<String>,
    /// The format of pictures: png, jpg, webp or exr, also for standard output, a folder or another ending. Or a stream
    /// of all pictures, with -o - or a file: y4m, npz, tar [default: by the ending of OUT, else png].
    ///
    /// y4m is raw video (YUV 4:4:4, BT.709, limited range) at --fps, without alpha. npz holds NumPy's arrays: frames
    /// (picture, row, column, RGBA; uint8), and an array of numbers for each AOV of --aov. tar holds .png files, or
    /// .exr with --aov, named as in a folder.
    #[arg(long)]
    pub format: Option<String>,
    /// The lossless compression of .exr: zip (16 rows), zips (one row), rle (runs of equal bytes), piz (wavelets, 32
    /// rows), none [default: zip].
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(manypass_offline::ExrCompression::NAMES))]
    pub exr_compression: Option<String>,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Many views at once. Poses and fields of view come from a NeRF transforms.json, or from a COLMAP folder (or its
    /// sparse/0) with .bin or .txt files. {camera} is the name of each image.
    ///
    /// `manypass render a.glb --cameras transforms.json --size 800x800 -o 'out/{camera}.png'` reads the model once.
    /// World axes are the model's. A camera looks along -Z with +Y up in transforms.json, along +Z with +Y down in
    /// COLMAP. Pictures have square pixels, the middle as principal point and no distortion. A file that says otherwise
    /// causes a warning. Give --exposure 0 for the same exposure in all pictures. See docs/camera.md.
    #[arg(long, value_name = "FILE.json|DIR", conflicts_with_all =
          ["camera", "eye", "orbit", "target", "up", "fov_y", "ortho_height", "turntable"])]
    pub cameras: Option<PathBuf>,
    /// Write the picture of every pass into this folder.
    #[arg(long, value_name = "DIR")]
    pub dump_passes: Option<PathBuf>,
    /// Write a contact sheet: the pictures of all passes in one, grouped by pass, with legends.
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
    /// Frames a second. `--time` uses it only for motion, `--turntable` for video and eye adaptation.
    #[arg(long, default_value_t = 24.0, requires = "times")]
    pub fps: f32,
    /// Turn the camera around the target once in N frames: frames 0 to N - 1, or those of `--frames`, which play
    /// meanwhile. With `--time` the animation stands still. The camera orbits the whole model, even if the file has a
    /// camera, unless --orbit gives the distance. In a room it turns in the middle.
    #[arg(long, value_name = "N", conflicts_with_all = ["camera", "eye"], value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub turntable: Option<u32>,
    /// Render on the adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Whether there is a cache.
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Write a report as JSON to a file or `-`; as JSON Lines if there may be several pictures.
    ///
    /// Several pictures: more than one input, a folder or a pattern, --frames, --turntable, --variant all, --camera
    /// all or --cameras. Each line is written as soon as its picture is done. With --skip-existing lines are appended,
    /// and the report of a single skipped picture stays as it is. If the report of one picture goes to standard output,
    /// a table of its passes goes to standard error, unless --quiet.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Skip pictures that exist, with their contact sheets and passes if those are asked for.
    #[arg(long)]
    pub skip_existing: bool,
    /// Treat warnings as errors; the picture is not written.
    #[arg(long)]
    pub strict: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use manypass_testkit::sentences;

    /// The texts of a subcommand and of its flags, with their names.
    fn texts(command: &clap::Command) -> Vec<(String, String)> {
        let about = command.get_long_about().or(command.get_about());
        let flags = command.get_arguments().filter_map(|flag| {
            Some((flag.get_id().to_string(), flag.get_long_help().or(flag.get_help())?.to_string()))
        });
        let own = about.map(|about| (command.get_name().to_owned(), about.to_string()));
        own.into_iter().chain(flags).chain(command.get_subcommands().flat_map(texts)).collect()
    }

    /// A text without what it says of defaults.
    fn without_default(text: &str) -> &str {
        text.split_once(" [default:").map_or(text, |(before, _)| before)
    }

    #[test]
    fn help_is_plain() {
        let texts = texts(&Cli::command());
        assert!(texts.len() > 80, "{} texts", texts.len());
        for (name, text) in &texts {
            for sentence in text.split("\n\n").flat_map(|part| sentences::of_text(without_default(part))) {
                assert_eq!(sentence.fault(), None, "{name}: {}", sentence.text);
            }
        }
    }
}
