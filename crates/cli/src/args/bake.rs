//! The command line of `bake`.

use super::frame::EnvironmentArgs;
use clap::Args;
use clap::builder::PossibleValuesParser;
use manypass_bake::{BakeSettings, Encoding, LayoutSettings};
use manypass_scene::LightMode;
use std::path::PathBuf;

/// The words of `--what`.
pub const WHAT: [&str; 7] = ["lightmap", "occlusion", "probes", "reflection", "ambient-cubes", "emission", "all"];

/// What stands below the help of `bake`.
pub const EXAMPLES: &str = "Examples:
  manypass bake room.glb -o baked.glb                     light maps and occlusion, 16 texels a metre
  manypass bake room.glb -o baked.glb --density 64 --samples 1024 --bounces 5
  manypass bake room.glb -o baked.glb --lights baked      lamps are in the maps, too, and cost frames nothing
  manypass bake hall.stage.toml -o baked.glb              with the stage's lights; writes baked.stage.toml as well
  manypass bake room.glb -o baked.glb --directional       normal maps show in the light of maps, too
  manypass bake room.glb -o baked.glb --environment sky.hdr
  manypass bake part.glb -o baked.glb --what occlusion    an occlusion texture, which every viewer shows
  manypass bake room.glb -o baked.glb --what all          with probes, which light what moves among the surfaces
  manypass bake room.glb -o baked.glb --what probes --probe-spacing 0.5
  manypass bake room.glb -o baked.glb --what emission     a room that looks lit in every viewer
  manypass render baked.glb                               draws it

Surfaces that stay where they are get a second UV set and a light map (MOZ_lightmap, linear OpenEXR): the light that comes from the \
environment, from what shines, and from other surfaces. The light that comes straight from lamps is what frames add, unless --lights says \
otherwise. What an animation moves, skins, and glass are left out. docs/baking.md says more.

A bake that is interrupted leaves OUT.glb.part, and the same command goes on from there to the same file; after other flags, or changes of \
the scene, it begins anew. A file that is there already and is of the same scene and flags is left as it is.";

/// Flags of `bake`.
#[derive(Debug, Args)]
pub struct BakeArgs {
    /// A model (.glb, .gltf, .obj, .stl, .ply, .3mf), a .stage.toml file, `-` for standard input, or demo:NAME.
    pub input: String,
    /// The glTF file to write, a .glb. Of a stage, of demos that have one, and with flags of the environment also
    /// OUT.stage.toml, which frames are drawn from.
    #[arg(short, long, value_name = "OUT.glb")]
    pub output: PathBuf,
    /// What to bake: lightmap, occlusion, probes, reflection, all of these (all), ambient-cubes, or emission; several with commas.
    ///
    /// lightmap: the light of surfaces, as MOZ_lightmap. occlusion: how open each place is, as the occlusion texture that
    /// every viewer of glTF reads, in place of the file's own; it also keeps reflections out of corners. probes: the light that
    /// arrives at places of a grid, as spherical harmonics, for what moves and for surfaces without light maps; where [[probes]] of
    /// a stage says, else all over the scene. reflection: what
    /// is to be seen around places, which surfaces there reflect; where [[reflection_probes]] of a stage say, else around the middle of
    /// the scene (not for all). ambient-cubes: the light of probes as six colours, which are smaller in the file and coarser. emission: in place
    /// of light maps, what surfaces send out of all light, as the emissive texture that every viewer reads; they have no
    /// other colour then, and lamps are baked.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "lightmap,occlusion",
          value_parser = PossibleValuesParser::new(WHAT))]
    pub what: Vec<String>,
    /// Texels a metre of surface.
    #[arg(long, value_name = "N", default_value_t = LayoutSettings::default().texels_per_m)]
    pub density: f32,
    /// How often light is sent back from one surface to others, up to 64.
    #[arg(long, value_name = "N", default_value_t = BakeSettings::default().bounces)]
    pub bounces: u32,
    /// Rays from every texel for each bounce, up to 65536, four times as many from a probe, a
    /// quarter through a texel of what is reflected: four times the number halves
    /// the noise.
    #[arg(long, value_name = "N", default_value_t = BakeSettings::default().samples)]
    pub samples: u32,
    /// At this distance in metres surfaces do not occlude any more, and less the nearer they are to it; inf: all occlude
    /// alike, and in a closed room nothing is open.
    #[arg(long, value_name = "M", default_value_t = BakeSettings::default().occlusion_distance_m)]
    pub occlusion_distance: f32,
    /// How far probes are apart, in metres, in one grid over the scene, where no stage says it [default: so far that there are
    /// some 2,000].
    #[arg(long, value_name = "M")]
    pub probe_spacing: Option<f32>,
    /// Light maps also hold where light comes from, as one direction a texel, so that normal maps, details and bumps of
    /// surfaces show in baked light. A second image in the file, 8-bit PNG; baking takes 24 bytes a texel more.
    #[arg(long)]
    pub directional: bool,
    /// Leave the noise of samples as it is.
    #[arg(long)]
    pub no_denoise: bool,
    /// The largest width and height of a map in texels, 16 to 8192; what does not fit goes into more maps.
    #[arg(long, value_name = "N", default_value_t = LayoutSettings::default().side_max)]
    pub side_max: u32,
    /// Texels around each piece of surface in a map that belong to nothing else.
    #[arg(long, value_name = "N", default_value_t = LayoutSettings::default().padding)]
    pub padding: u32,
    /// Who adds up the light of lamps [default: what each says in the file, else mixed].
    ///
    /// dynamic: frames alone, and nothing of it is baked; mixed: frames add what comes straight from a lamp, with its
    /// highlights and shadows, and maps hold what surfaces send back of it; baked: all of it is in maps and probes, and only
    /// surfaces with those have it.
    #[arg(long, value_name = "MODE", value_parser = PossibleValuesParser::new(LightMode::NAMES))]
    pub lights: Option<String>,
    /// How light maps are written: exr, half floats; rgbe, shared exponents, within 1 %; rgbm, PNG, plain glTF.
    #[arg(long, value_name = "NAME", default_value = "exr", value_parser = PossibleValuesParser::new(Encoding::NAMES))]
    pub encoding: String,
    #[command(flatten)]
    pub around: EnvironmentArgs,
    /// Change a setting of the environment, such as environment.turbidity=4; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// A scene of the file [default: the one that the file names].
    #[arg(long, value_name = "NAME|INDEX")]
    pub scene: Option<String>,
    /// Print what was done as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
}

impl BakeArgs {
    /// Whether flags say what lies around the scene.
    pub fn says_environment(&self) -> bool {
        !self.set.is_empty() || self.around != EnvironmentArgs::default()
    }
}
