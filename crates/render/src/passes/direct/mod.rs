//! direct: every light that reaches a pixel, added to `radiance`; and that of the environment where one of the lights
//! reaches every pixel, so that the G-buffer is read once for both.
//!
//! Source: clustered shading (Olsson et al. 2012), or tiled shading (Olsson & Assarsson 2011), lists in data textures.
//! Reads: G-buffer, depth, lists of lights, occlusion, the environment. Writes: radiance, in the rectangles of the
//! picture that lights reach; or, for the report, the numbers of pairs of pixel and light.

use crate::gbuffer::Gbuffer;
use crate::lights::Rectangle;
use crate::pass_info::PassInfo;
use crate::record::{ADD, PicturePart, Recorder};
use crate::screen_space::ScreenSpaceEffects;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};
use std::sync::Arc;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { effect_inputs: &["radiance"], ..PassInfo::deferred("direct") };

/// Which lights.
#[derive(Debug)]
pub enum Lights<'t> {
    /// Those that are in no list, and those of clusters.
    Clusters,
    /// Those that are in no list, and those of tiles, with the bounds of depth that `tile_depth` leaves.
    Tiles(&'t Handle),
    /// Those that are in no list.
    Global,
}

impl Lights<'_> {
    /// The rectangles of the picture that they reach.
    fn rectangles(&self, r: &Recorder<'_, '_>) -> Arc<[Rectangle]> {
        let (width, height) = r.view.size;
        match self {
            Self::Clusters | Self::Tiles(_) => r.view.lit_rectangles.clone(),
            Self::Global => (r.view.global_light_count > 0).then_some([0, 0, width, height]).into_iter().collect(),
        }
    }

    /// Whether their pass adds the light of the environment as well: where one of the lights reaches every pixel.
    pub fn adds_ambient(&self, r: &Recorder<'_, '_>) -> bool {
        let (width, height) = r.view.size;
        let is_wanted = !r.view.is_environment_dark && !r.view.counts_pairs();
        is_wanted && self.rectangles(r)[..] == [[0, 0, width, height]]
    }
}

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    lights: &Lights<'_>,
    gbuffer: &Gbuffer,
    found: ScreenSpaceEffects<'_>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let lit = lights.rectangles(r);
    if lit.is_empty() {
        return Ok(radiance);
    }
    let adds_ambient = lights.adds_ambient(r);
    let reaches = r.view.light_reaches.clone();
    let axis: &[&'static str] = match lights {
        Lights::Clusters => &[],
        Lights::Tiles(_) => &["tiled"],
        Lights::Global => &["without_lists"],
    };
    let step = r.fullscreen("direct", "direct", &[r.view.light_axes(), axis].concat());
    let step = found.read_by(gbuffer.read_by_light(step, depth));
    let step = match lights {
        Lights::Tiles(tile_depth) => step.read("tile_depth", tile_depth).table("light_reaches", &reaches),
        Lights::Clusters | Lights::Global => step,
    };
    let step = step
        .constant("adds_ambient", u32::from(adds_ambient))
        .within_each(&lit)
        .over(PicturePart::Lit, depth)
        .blend(ADD);
    step.draw_into(radiance, ColorLoad::Keep)
}
