//! The command line of `bake`.

use super::frame::EnvironmentArgs;
use clap::Args;
use clap::builder::PossibleValuesParser;
use manypass_bake::{BakeSettings, Encoding, LayoutSettings};
use manypass_scene::LightMode;
use std::path::PathBuf;

/// The words of `--what`.
pub const WHAT: [&str; 7] = ["lightmap", "occlusion", "probes", "reflection", "ambient-cubes", "emission", "all"];

/// The text below the help of `bake`.
pub const EXAMPLES: &str = "Examples:
  manypass bake room.glb -o baked.glb                     light maps and occlusion, 16 texels a metre
  manypass bake room.glb -o baked.glb --density 64 --samples 1024 --bounces 5
  manypass bake room.glb -o baked.glb --lights baked      lamps are in the maps, too, and cost frames nothing
  manypass bake hall.stage.toml -o baked.glb              with the stage's lights; writes baked.stage.toml as well
  manypass bake room.glb -o baked.glb --directional       directional light maps, in which normal maps show, too
  manypass bake room.glb -o baked.glb --environment sky.hdr
  manypass bake part.glb -o baked.glb --what occlusion    an occlusion texture, which every viewer shows
  manypass bake room.glb -o baked.glb --what all          with probes, which light moving objects
  manypass bake room.glb -o baked.glb --what probes --probe-spacing 0.5
  manypass bake room.glb -o baked.glb --what emission     a room that looks lit in every viewer
  manypass render baked.glb                               draws it

Static surfaces get a second UV set and a light map (MOZ_lightmap, linear OpenEXR). It holds light from the environment, from \
emissive surfaces, and indirect light. Frames add the direct light of lamps, unless --lights says otherwise. \
Animated and skinned meshes and transmissive surfaces are left out. docs/baking.md says more.

An interrupted bake leaves OUT.glb.part. The same command resumes it and writes the same file. With other flags or another scene it \
starts again. An existing file of the same scene and flags stays as it is.";

/// Flags of `bake`.
#[derive(Debug, Args)]
pub struct BakeArgs {
    /// A model (.glb, .gltf, .obj, .stl, .ply, .3mf), a .stage.toml file, `-` for standard input, or demo:NAME.
    pub input: String,
    /// The glTF file to write, a .glb. Stages, demos that have one, and flags of the environment also write
    /// OUT.stage.toml, from which frames are drawn.
    #[arg(short, long, value_name = "OUT.glb")]
    pub output: PathBuf,
    /// What to bake: lightmap, occlusion, probes, reflection, all of these (all), ambient-cubes, or emission; several with commas.
    ///
    /// lightmap: light maps of surfaces, as MOZ_lightmap. occlusion: ambient occlusion, as the occlusion texture that
    /// every viewer of glTF reads, in place of the file's own; it also darkens reflections in corners. probes: irradiance
    /// probes on a grid, as spherical harmonics, for moving objects and surfaces without light maps. They lie where
    /// [[probes]] of a stage says, else all over the scene. reflection: reflection probes, where [[reflection_probes]] of
    /// a stage says, else around the middle of the scene (not for all). ambient-cubes: irradiance probes as ambient cubes
    /// of six colours, which are smaller in the file and coarser. emission: in place of light maps, all outgoing light of
    /// surfaces, as the emissive texture that every viewer reads. Surfaces have no other colour then, and lamps are baked.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "lightmap,occlusion",
          value_parser = PossibleValuesParser::new(WHAT))]
    pub what: Vec<String>,
    /// Texels a metre of surface.
    #[arg(long, value_name = "N", default_value_t = LayoutSettings::default().texels_per_m)]
    pub density: f32,
    /// The number of bounces of indirect light, up to 64.
    #[arg(long, value_name = "N", default_value_t = BakeSettings::default().bounces)]
    pub bounces: u32,
    /// Rays from every texel for each bounce, up to 65536. A probe has four times as many, a texel of a reflection probe
    /// a quarter. Four times the number halves the noise.
    #[arg(long, value_name = "N", default_value_t = BakeSettings::default().samples)]
    pub samples: u32,
    /// The distance in metres over which occlusion fades to nothing. With inf all surfaces occlude alike, and everything
    /// in a closed room is occluded.
    #[arg(long, value_name = "M", default_value_t = BakeSettings::default().occlusion_distance_m)]
    pub occlusion_distance: f32,
    /// The distance between probes in metres, in one grid over the scene, if no stage gives it [default: about 2,000
    /// probes].
    #[arg(long, value_name = "M")]
    pub probe_spacing: Option<f32>,
    /// Bake directional light maps: one direction a texel, so that normal maps, detail maps and bumps show in baked light.
    /// They are a second image in the file, 8-bit PNG. Baking takes 24 bytes a texel more.
    #[arg(long)]
    pub directional: bool,
    /// Do not denoise.
    #[arg(long)]
    pub no_denoise: bool,
    /// The largest width and height of a map in texels, 16 to 8192; surfaces that do not fit go into more maps.
    #[arg(long, value_name = "N", default_value_t = LayoutSettings::default().side_max)]
    pub side_max: u32,
    /// Padding: empty texels around each chart of a map.
    #[arg(long, value_name = "N", default_value_t = LayoutSettings::default().padding)]
    pub padding: u32,
    /// Which light of lamps is baked [default: each light's mode in the file, else mixed].
    ///
    /// dynamic: none; frames compute all of it. mixed: indirect light; frames add direct light with highlights and
    /// shadows. baked: all of it is in light maps and probes, and only surfaces with those have it.
    #[arg(long, value_name = "MODE", value_parser = PossibleValuesParser::new(LightMode::NAMES))]
    pub lights: Option<String>,
    /// The encoding of light maps: exr, half floats; rgbe, shared exponents, within 1 %; rgbm, PNG, plain glTF.
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
