//! The command line of `diff`.

use super::frame::{CacheArgs, FrameArgs};
use clap::{Args, Parser};
use manypass_flip::{PIXELS_PER_DEGREE, PIXELS_PER_DEGREE_RANGE};
use std::path::PathBuf;

/// The text below the help of `diff`.
pub const EXAMPLES: &str = "Examples:
  manypass diff before.png after.png                      mean and largest difference
  manypass diff before.png after.png -o diff.png          both beside the map of differences
  manypass diff before.exr after.exr --json               radiance, at every exposure that matters
  manypass diff golden.png new.png --threshold 0.005      exit code 5 if they look different
  manypass diff before.glb after.glb -o diff.png          two models: did geometry, material or light change?
  manypass diff a.glb b.glb --orbit 90,20,auto --environment sky.hdr --size 640x640

FLIP (Andersson et al. 2020; for EXR HDR-FLIP, Andersson et al. 2021) measures how much each pixel changes when one flips between \
the two on a display: 0 is the same, 1 is blue for green. The mean over all pixels is the number to quote.
Transparent pixels are composited over mid grey, so that pixels that are transparent in both are the same.
A is the reference: for EXR, exposures are chosen from it. For other pictures A and B may change places.

Two models are drawn by one camera that sees both whole, unless flags say otherwise, in the light that A would have. Besides FLIP of their \
pictures, every AOV of `render --aov` is compared where both show a surface. So one can tell whether geometry, material or \
light changed. The flags of the camera, the light and the frame are those of `render`, and need models.";

/// Flags of `diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// The reference: a PNG, JPEG, WebP or EXR file, or a model as in `render`.
    pub a: String,
    /// The picture or model to compare: a picture of the same size, EXR if A is; a model if A is.
    pub b: String,
    /// Write A, B and the map of differences into one picture; for models also every AOV that differs.
    ///
    /// The map goes from black (no difference) over purple and orange to light yellow (1). Pictures above 640 pixels
    /// are shown smaller. FILE may not be A or B.
    #[arg(short, long, value_name = "FILE.png")]
    pub output: Option<PathBuf>,
    /// Print one JSON object: {"flip": {"mean", "largest", "largest_at_px", …}, …}.
    #[arg(long)]
    pub json: bool,
    /// Exit with code 5 if the mean is above this, from 0 to 1; everything is printed and written before.
    #[arg(long, value_name = "MEAN", value_parser = threshold)]
    pub threshold: Option<f64>,
    /// Pixels per degree of the field of view: 67 for a display of 3840 pixels and 0.7 m, seen from 0.7 m.
    ///
    /// Fewer are a display seen from nearer, on which smaller differences are visible.
    #[arg(long, value_name = "N", default_value_t = PIXELS_PER_DEGREE, value_parser = pixels_per_degree)]
    pub pixels_per_degree: f32,
    /// What the pictures of models are like.
    #[command(flatten, next_help_heading = "Two models")]
    pub frame: FrameArgs,
    /// Render models on the adapter whose name contains this.
    #[arg(long, value_name = "NAME", help_heading = "Two models")]
    pub adapter: Option<String>,
    /// Whether there is a cache.
    #[command(flatten, next_help_heading = "Two models")]
    pub cache: CacheArgs,
}

impl DiffArgs {
    /// Whether a flag is given that only models have.
    pub fn describes_models(&self) -> bool {
        #[derive(Parser)]
        struct Plain {
            #[command(flatten)]
            args: DiffArgs,
        }
        let plain = Plain::try_parse_from(["diff", "a", "b"]).map(|plain| plain.args);
        self.adapter.is_some() || self.cache.no_cache || plain.is_ok_and(|plain| plain.frame != self.frame)
    }
}

fn threshold(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (0.0..=1.0).contains(value));
    value.ok_or_else(|| "write a number from 0 to 1".into())
}

fn pixels_per_degree(text: &str) -> Result<f32, String> {
    let (first, last) = (PIXELS_PER_DEGREE_RANGE.start(), PIXELS_PER_DEGREE_RANGE.end());
    let value = text.parse().ok().filter(|value| PIXELS_PER_DEGREE_RANGE.contains(value));
    value.ok_or_else(|| format!("write a number from {first} to {last}"))
}
