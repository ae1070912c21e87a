//! forward: surfaces shaded where they are drawn: blended ones, and with `--path forward` all of them, with the same
//! reflectance model, lights and lists as the deferred path.
//!
//! Source: Olsson et al. 2012 (clustered forward); blending after Porter & Duff 1984, sorted from back to front, or
//! otherwise as `transparency.rs` says. Reads: lists of lights, the environment, depth, occlusion, what the picture
//! shows in the environment's place, the distances of the nearest surfaces that light comes through if it draws what
//! lies on one side of them; of such surfaces themselves the picture so far, and where rays leave their bodies. Writes:
//! radiance (premultiplied), and depth if opaque; or sums for a weighted mean; or, for the report, the numbers of pairs
//! of light and fragment.

use crate::constants::LIGHTS_PER_BATCH;
use crate::draws::Draw;
use crate::fog::{FogMode, FogSettings, FogUniform, IN_LIT_FOG};
use crate::gbuffer::LightTarget;
use crate::occlusion::Occlusion;
use crate::pass_info::PassInfo;
use crate::record::{ADD, DrawSelection, Recorder, SurfacePass};
use crate::screen_space::{ScreenSpaceEffects, ScreenSpaceLight};
use crate::shader::program::ProgramError;
use crate::transparency::{BlendTargets, GLASS_DISTANCES, Peel, Side, Weighting};
use manypass_graph::{ColorLoad, DepthLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { effect_inputs: &["radiance"], ..PassInfo::new("forward") };

/// The uniform of `forward.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct LightBatch {
    /// The first light of the batch; zeros.
    first: [u32; 4],
}

/// The constant of `forward.wgsl` that says which lights, and its values beside that of clusters.
const LIGHTS_OF: &str = "lights_of";
/// Where the depth of what is drawn is there already.
const DRAWS_AGAIN: &str = "draws_again";
const FIRST_BATCH: u32 = 1;
const LATER_BATCH: u32 = 2;
/// In place of lights.
const REFLECTIONS: u32 = 3;
const SURFACES: u32 = 4;

/// The depth that opaque surfaces are shaded with, one sample for each of their targets'.
#[derive(Debug)]
pub struct OpaqueDepth {
    /// The texture.
    pub depth: Handle,
    /// How it is loaded.
    pub load: DepthLoad,
    /// Whether a pass before drew all of it, so that it stays as it is.
    pub is_drawn: bool,
}

impl OpaqueDepth {
    /// Makes it that of `pass`. Returns the version that holds the result.
    fn begin(self, pass: &mut SurfacePass<'_, '_>) -> Handle {
        if !self.is_drawn {
            return pass.depth(self.depth, self.load);
        }
        pass.depth_read_only(&self.depth);
        pass.constant(DRAWS_AGAIN, 1);
        self.depth
    }
}

/// Radiance and depth of all opaque and masked surfaces, drawn once with emission, ambient light and the first eight of
/// the lights that reach them, and once more for each eight others, which are added where the depth is the same. What
/// is drawn twice at exactly the same place is lit by the later batches of both.
///
/// Source: several lights a pass, added up (Hargreaves & Harris 2004, on multi-pass lighting).
///
/// # Errors
/// A program that does not compile.
pub fn record_batched(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    depth: OpaqueDepth,
    occlusion: Option<&Occlusion>,
) -> Result<(Handle, Handle), ProgramError> {
    let radiance = LightTarget::new(r);
    let (view, world) = (r.view, r.frame.world);
    // Lists are in the order of classes, so that few batches have lights that cast shadows.
    let axes_of = |first| view.light_axes_of(&(first..first + LIGHTS_PER_BATCH), world);
    let fog = FogUniform::new(fog, view.uniform.pre_exposure);
    let mut pass = r.surfaces("forward_batched", "forward");
    pass.axes(axes_of(0));
    pass.uniform("fog", &fog);
    let mut radiance = radiance.begin(&mut pass);
    let depth = depth.begin(&mut pass);
    pass.leave_out_settled();
    pass.constant(LIGHTS_OF, FIRST_BATCH);
    ScreenSpaceEffects { occlusion, reflections: None }.bind(&mut pass);
    bind_opaque(&mut pass);
    pass.draw_opaque(DrawSelection::All)?;
    let most = view.most_lights(world);
    for first in (LIGHTS_PER_BATCH..most).step_by(LIGHTS_PER_BATCH as usize) {
        let mut pass = r.surfaces(format!("forward_batched.{}", first / LIGHTS_PER_BATCH), "forward");
        pass.axes(axes_of(first));
        pass.uniform("fog", &fog);
        radiance = pass.color(radiance, ColorLoad::Keep);
        pass.depth_read_only(&depth);
        pass.blend(ADD);
        pass.constant(LIGHTS_OF, LATER_BATCH);
        ScreenSpaceEffects::default().bind(&mut pass);
        pass.constant(DRAWS_AGAIN, 1);
        pass.uniform("light_batch", &LightBatch { first: [first, 0, 0, 0] });
        pass.uniform("weighting", &Weighting::default());
        pass.draw_opaque_lit_by(first + 1)?;
    }
    Ok((radiance, depth))
}

/// Radiance and depth of all opaque and masked surfaces, less what `occlusion` says.
///
/// # Errors
/// A program that does not compile.
pub fn record_opaque(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    depth: OpaqueDepth,
    occlusion: Option<&Occlusion>,
) -> Result<(Handle, Handle), ProgramError> {
    let radiance = LightTarget::new(r);
    let axes = r.view.light_axes();
    let fog = FogUniform::new(fog, r.view.uniform.pre_exposure);
    let mut pass = r.surfaces("forward.opaque", "forward");
    pass.leave_out_settled();
    ScreenSpaceEffects { occlusion, reflections: None }.bind(&mut pass);
    bind_opaque(&mut pass);
    pass.axes(axes);
    let radiance = radiance.begin(&mut pass);
    let depth = depth.begin(&mut pass);
    pass.uniform("fog", &fog);
    pass.draw_opaque(DrawSelection::All)?;
    Ok((radiance, depth))
}

/// The depth of all opaque and masked surfaces in the middle of each pixel, for passes that read it where surfaces
/// cover several samples.
///
/// # Errors
/// A program that does not compile.
pub fn record_depth(r: &mut Recorder<'_, '_>, name: &'static str) -> Result<Handle, ProgramError> {
    let depth = r.texture(name, r.frame.gpu.capabilities.depth_format);
    let mut pass = r.surfaces(name, "geometry");
    let depth = pass.depth(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    pass.draw_opaque(DrawSelection::All)?;
    Ok(depth)
}

/// What of the G-buffer's depth those are that [`record_layered`] draws.
#[derive(Debug)]
pub enum LayeredDepth {
    /// They are there already, and hide what lies behind them.
    There(Handle),
    /// They are not.
    Missing(Handle),
}

/// What else passes find in group 1 that draw opaque surfaces, from the first of their lights on.
fn bind_opaque(pass: &mut SurfacePass<'_, '_>) {
    pass.uniform("light_batch", &LightBatch::default());
    pass.uniform("weighting", &Weighting::default());
}

/// Shades opaque and masked surfaces that other passes leave alone, which are those with layers, over what is there of
/// `radiance`, with what was `found` in the picture; with `fog`, if no pass adds it later. Also gives depth.
///
/// # Errors
/// A program that does not compile.
pub fn record_layered(
    r: &mut Recorder<'_, '_>,
    fog: Option<&FogSettings>,
    found: ScreenSpaceEffects<'_>,
    radiance: Handle,
    depth: LayeredDepth,
) -> Result<(Handle, Handle), ProgramError> {
    let world = r.frame.world;
    let (which, is_there) = match depth {
        LayeredDepth::There(_) => (DrawSelection::ShadedWhereDrawn, world.is_shaded_where_drawn),
        LayeredDepth::Missing(_) => (DrawSelection::Layered, world.has_layers),
    };
    if !is_there {
        let (LayeredDepth::There(depth) | LayeredDepth::Missing(depth)) = depth;
        return Ok((radiance, depth));
    }
    let view = r.view;
    let no_fog = FogSettings { mode: FogMode::None, ..FogSettings::default() };
    let fog = FogUniform::new(fog.unwrap_or(&no_fog), view.uniform.pre_exposure);
    let mut pass = r.surfaces("layered", "forward");
    found.bind(&mut pass);
    bind_opaque(&mut pass);
    pass.axes(view.light_axes());
    let radiance = pass.color(radiance, ColorLoad::Keep);
    if view.counts_pairs() {
        pass.blend(ADD);
    }
    pass.uniform("fog", &fog);
    let depth = match depth {
        LayeredDepth::There(depth) => {
            pass.depth_read_only(&depth);
            pass.constant(DRAWS_AGAIN, 1);
            depth
        }
        LayeredDepth::Missing(depth) => pass.depth(depth, DepthLoad::Keep),
    };
    pass.draw_opaque(which)?;
    Ok((radiance, depth))
}

/// Draws again what [`record_layered`] does, and adds what it reflects of the picture in the place of the environment,
/// once `found` is there, which has a texel for each pixel. `depth` is that of `radiance`.
///
/// # Errors
/// A program that does not compile.
pub fn record_layered_reflections(
    r: &mut Recorder<'_, '_>,
    found: ScreenSpaceEffects<'_>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let mut pass = r.surfaces("layered.reflections", "forward");
    found.bind(&mut pass);
    bind_opaque(&mut pass);
    pass.constant(LIGHTS_OF, REFLECTIONS);
    add_layered(pass, depth, radiance)
}

/// The same of light that surfaces of the picture send them.
///
/// # Errors
/// A program that does not compile.
pub fn record_layered_light(
    r: &mut Recorder<'_, '_>,
    found: &ScreenSpaceLight,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let mut pass = r.surfaces("layered.gi", "forward");
    found.bind(&mut pass);
    bind_opaque(&mut pass);
    pass.constant(LIGHTS_OF, SURFACES);
    add_layered(pass, depth, radiance)
}

/// Adds what the pass draws where surfaces with layers are.
fn add_layered(mut pass: SurfacePass<'_, '_>, depth: &Handle, radiance: Handle) -> Result<Handle, ProgramError> {
    // What is added lies below fog.
    let no_fog = FogSettings { mode: FogMode::None, ..FogSettings::default() };
    pass.uniform("fog", &FogUniform::new(&no_fog, 1.0));
    pass.constant(DRAWS_AGAIN, 1);
    pass.blend(ADD);
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_read_only(depth);
    pass.draw_opaque(DrawSelection::ShadedWhereDrawn)?;
    Ok(radiance)
}

/// Surfaces that light comes through of which none lies behind another in the picture, and what is seen through them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GlassLayer<'h> {
    /// The surfaces, farther ones first.
    pub draws: &'h [Draw],
    /// What the names of its passes end with.
    pub suffix: &'h str,
    /// The picture so far with its mips; none if nothing is seen through them.
    pub behind: Option<&'h Handle>,
    /// Where rays leave bodies, and how far away what lies behind is, if there are bodies among them.
    pub bodies: Option<&'h Handle>,
}

impl GlassLayer<'_> {
    /// Binds what is seen through its surfaces.
    fn bind(&self, pass: &mut SurfacePass<'_, '_>) {
        pass.uniform("weighting", &Weighting::default());
        if let Some(behind) = self.behind {
            pass.constant("transmissive", 1);
            pass.read("behind", behind);
        } else {
            pass.stand_in("behind");
        }
        if let Some(bodies) = self.bodies {
            pass.constant("has_bodies", 1);
            pass.read(GLASS_DISTANCES, bodies);
        } else {
            pass.stand_in(GLASS_DISTANCES);
        }
    }
}

/// The depth of the surfaces that light comes through, and of nothing else.
///
/// # Errors
/// A program that does not compile.
pub fn record_nearest_transmissive(r: &mut Recorder<'_, '_>) -> Result<Handle, ProgramError> {
    let depth = r.texture("transmissive.depth", r.frame.gpu.capabilities.depth_format);
    let mut pass = r.surfaces("transmissive.depth", "geometry");
    let depth = pass.depth(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    pass.draw_transmissive()?;
    Ok(depth)
}

/// How much of the background comes through the surfaces of a layer, which are in `depth` already, into `transmittance`,
/// of which the layer has that of what lies behind them.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn record_transmittance(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    layer: GlassLayer<'_>,
    transmittance: Handle,
    depth: &Handle,
) -> Result<Handle, ProgramError> {
    let fog = FogUniform::new(fog, r.view.uniform.pre_exposure);
    let axes = r.view.light_axes();
    let mut pass = r.surfaces(format!("transmittance{}", layer.suffix), "forward");
    pass.uniform("light_batch", &LightBatch::default());
    layer.bind(&mut pass);
    pass.axes(axes);
    pass.constant("shows_transmittance", 1);
    pass.constant(DRAWS_AGAIN, 1);
    Occlusion::bind_none(&mut pass);
    let transmittance = pass.color(transmittance, ColorLoad::Keep);
    pass.depth_read_only(depth);
    pass.uniform("fog", &fog);
    pass.draw_those(layer.draws)?;
    Ok(transmittance)
}

/// Draws the surfaces of a layer before what is seen through them: over what is there, or with `replaces` in its place.
/// Also gives depth, which they hide other surfaces with.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn record_transmissive(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    (layer, replaces): (GlassLayer<'_>, bool),
    radiance: Handle,
    depth: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    let view = r.view;
    let is_lit = fog.scatters();
    let fog = FogUniform::new(fog, view.uniform.pre_exposure);
    let mut pass = r.surfaces(format!("transmissive{}", layer.suffix), "forward");
    pass.uniform("light_batch", &LightBatch::default());
    layer.bind(&mut pass);
    pass.axes(view.light_axes());
    Occlusion::bind_none(&mut pass);
    let radiance = pass.color(radiance, ColorLoad::Keep);
    let depth = pass.depth(depth, DepthLoad::Keep);
    if replaces {
        pass.constant("replaces", 1);
    } else {
        pass.blend(LightTarget::blend_over(view));
    }
    pass.uniform("fog", &fog);
    if is_lit {
        pass.constant(IN_LIT_FOG, 1);
    }
    pass.draw_those(layer.draws)?;
    Ok((radiance, depth))
}

/// Draws the surfaces that alpha covers, or what `peel` says of them, into what `blended` says. Returns what holds the
/// result.
///
/// # Errors
/// A program that does not compile.
pub fn record_blended(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    blended: BlendTargets,
    peel: Option<Peel<'_>>,
) -> Result<BlendTargets, ProgramError> {
    let (view, weighting) = (r.view, blended.weighting(r));
    let is_lit = fog.scatters();
    let fog = FogUniform::new(fog, view.uniform.pre_exposure);
    let is_behind = peel.is_some_and(|peel| peel.side == Side::Behind);
    let mut pass = r.surfaces(if is_behind { "forward.behind" } else { "forward" }, "forward");
    pass.stand_in("behind");
    Occlusion::bind_none(&mut pass);
    pass.uniform("light_batch", &LightBatch::default());
    weighting.bind(&mut pass, peel);
    pass.axes(view.light_axes());
    let blended = blended.begin(&mut pass, view);
    pass.uniform("fog", &fog);
    if is_lit {
        pass.constant(IN_LIT_FOG, 1);
    }
    pass.draw_blended()?;
    Ok(blended)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("forward", "LightBatch", LightBatch, [first]);
    }
}
