//! resolve: the mean of the samples of each pixel, where surfaces cover several (`msaa.samples`).
//!
//! It is a mean of radiance, which the device takes of itself: WebGL 2 shows shaders no samples, so that none can be
//! weighted, and a curve that surfaces leave through would spoil what is blended over them. So edges of what is far
//! brighter than white are as hard as without; the samples of a still smooth them. Reads and writes: radiance, or the
//! sums that blended surfaces left.

mod settings;

pub use settings::{MultisamplingSettings, PixelSamples};

use crate::pass_info::{PassInfo, Reach};
use crate::record::Recorder;
use crate::render_settings::Path;
use crate::transparency::BlendTargets;
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use std::borrow::Cow;

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { off: Some("msaa.samples=1"), paths: &[Path::Forward], tiers: &[], ..PassInfo::new("resolve") };

/// How far it looks; none if settings switch it off. Samples of a pixel have one mark of what is converged.
pub fn reach(settings: &MultisamplingSettings) -> Option<Reach> {
    (settings.samples.count() > 1).then_some(Reach::EverySample)
}

/// The mean of the samples of `color`, or `color` itself if each of its pixels has one.
pub fn record(r: &mut Recorder<'_, '_>, name: impl Into<Cow<'static, str>>, color: Handle) -> Handle {
    let (color, mean) = record_between(r, name, color);
    mean.unwrap_or(color)
}

/// The mean of the samples of `color` as it is so far, if each of its pixels has several; and `color`, to be drawn into
/// further.
pub fn record_between(
    r: &mut Recorder<'_, '_>,
    name: impl Into<Cow<'static, str>>,
    color: Handle,
) -> (Handle, Option<Handle>) {
    let desc = color.desc();
    if desc.samples == 1 {
        return (color, None);
    }
    let name = name.into();
    let mean = r.texture_of(name.clone(), TextureDesc { samples: 1, ..desc });
    let mut pass = r.graph.pass(name);
    let color = pass.color(color, ColorLoad::Keep);
    let mean = pass.resolve(mean);
    (color, Some(mean))
}

/// What is left of `blended` to be made one picture: where there are sums, shaders read them, and see one of each
/// pixel.
pub fn record_blended(r: &mut Recorder<'_, '_>, blended: BlendTargets) -> BlendTargets {
    let Some([sum, weights]) = blended.sums else { return blended };
    let sums = Some([record(r, "resolve.sum", sum), record(r, "resolve.weights", weights)]);
    BlendTargets { radiance: record(r, "resolve.opaque", blended.radiance), sums, ..blended }
}
