//! From the radiance of a view to its picture: what frames before and effects add, means over samples, the display
//! transform, and what is drawn over all of it.

use crate::effect::{self, Effect, EffectStage, FrameTextures};
use crate::fisheye::FisheyeLens;
use crate::gbuffer::{Gbuffer, RADIANCE, ViewOutputs};
use crate::overlay::draw::OverlayDraw;
use crate::passes::accumulate::SamplePart;
use crate::passes::present::Target;
use crate::passes::tone_map::ToneMapSettings;
use crate::passes::upscale::UpscaleMethod;
use crate::passes::{
    accumulate, adaptive, debug, fisheye, forward, meter, nearest, overlay, present, scrub, taa, tone_map, upscale,
};
use crate::record::Recorder;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use manypass_graph::{Handle, TextureDesc};
use std::sync::Arc;

/// The picture of a fisheye, of those of all sides; it has no G-buffer, and nothing looks at its depth.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn fisheye_passes(
    r: &mut Recorder<'_, '_>,
    lens: &FisheyeLens,
    sample: (u32, u32),
    faces: Vec<fisheye::FaceRadiance>,
) -> Result<ViewOutputs, ProgramError> {
    let radiance = fisheye::record(r, lens, sample, faces)?;
    let depth = r.texture("depth", wgpu::TextureFormat::Depth32Float);
    Ok(ViewOutputs::new(radiance, depth))
}

/// Anti-aliasing by the frames before, where those follow each other.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn temporal_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    frame: Option<&taa::TemporalFrame>,
    outputs: ViewOutputs,
) -> Result<ViewOutputs, ProgramError> {
    // Forward paths are refused with the settings.
    let (Some(frame), Some(gbuffer), Some(motion)) = (frame, &outputs.gbuffer, &outputs.motion) else {
        return Ok(outputs);
    };
    let inputs = taa::FrameInputs { radiance: &outputs.radiance, linear_depth: &gbuffer.linear_depth, motion };
    let radiance = taa::record(r, &settings.taa, frame, inputs)?;
    Ok(ViewOutputs { radiance, ..outputs })
}

/// What effects may read of a frame, at the size of the picture that it is enlarged to; what none of them reads is culled.
///
/// # Errors
/// A program that does not compile.
pub fn enlarged_passes(
    r: &mut Recorder<'_, '_>,
    output_size: (u32, u32),
    outputs: ViewOutputs,
) -> Result<ViewOutputs, ProgramError> {
    let mut enlarged = |name, texture: &Handle| nearest::record(r, name, texture, output_size);
    let gbuffer = match &outputs.gbuffer {
        Some(gbuffer) => Some(Gbuffer {
            base_color: enlarged("base_color", &gbuffer.base_color)?,
            normal: enlarged("normal", &gbuffer.normal)?,
            material: enlarged("material", &gbuffer.material)?,
            linear_depth: enlarged("linear_depth", &gbuffer.linear_depth)?,
        }),
        None => None,
    };
    let occlusion = outputs.occlusion.as_ref().map(|occlusion| enlarged("occlusion", occlusion)).transpose()?;
    let motion = outputs.motion.as_ref().map(|motion| enlarged("motion", motion)).transpose()?;
    let ids = outputs.ids.as_ref().map(|ids| enlarged("ids", ids)).transpose()?;
    Ok(ViewOutputs { gbuffer, occlusion, motion, ids, ..outputs })
}

/// The effects on radiance, each on that of the one before.
///
/// # Errors
/// As [`Effect::record`].
pub fn effect_passes<'f>(
    r: &mut Recorder<'_, 'f>,
    effects: &'f [Arc<dyn Effect>],
    outputs: ViewOutputs,
) -> Result<ViewOutputs, ProgramError> {
    let ViewOutputs { radiance, gbuffer, occlusion, motion, ids, .. } = outputs;
    let of_frame = FrameTextures {
        gbuffer: gbuffer.as_ref(),
        occlusion: occlusion.as_ref(),
        motion: motion.as_ref(),
        ids: ids.as_ref(),
    };
    let radiance = effect::record(r, effects, EffectStage::Radiance, &of_frame, radiance)?;
    if effects.iter().any(|effect| effect.is_on() && effect.stage() == EffectStage::Radiance) {
        scrub::count(r, "scrub.last.count".into(), &radiance)?;
    }
    Ok(ViewOutputs { radiance, gbuffer, occlusion, motion, ids, ..outputs })
}

/// The exposure of a frame that goes on from those before: its stops, in one texel.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn exposure_passes(
    r: &mut Recorder<'_, '_>,
    adapting: Option<&meter::AdaptationStep>,
    radiance: &Handle,
) -> Result<Option<Handle>, ProgramError> {
    adapting.map(|adapting| meter::record_adapted(r, adapting, radiance)).transpose()
}

/// From the size at which the frame was shaded to that of its picture; none where it has that size, or where the passes that
/// follow read linearly what lies between pixels.
///
/// # Errors
/// A program that does not compile.
pub fn upscale_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    exposure: f32,
    radiance: &Handle,
    output_size: (u32, u32),
) -> Result<Option<Handle>, ProgramError> {
    match settings.upscale.method {
        UpscaleMethod::Bilinear => Ok(None),
        UpscaleMethod::Edges | UpscaleMethod::Temporal => upscale::record(r, exposure, radiance, output_size),
    }
}

/// From radiance to the picture: accumulation over the samples of a still if there are several, the display transform,
/// and the caller's target if there is one.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn output_passes<'f>(
    r: &mut Recorder<'_, 'f>,
    settings: &Settings,
    radiance: &Handle,
    means: Means,
    picture: Picture<'_>,
    effects: &'f [Arc<dyn Effect>],
) -> Result<(), ProgramError> {
    let Picture {
        display,
        target,
        is_shown,
        sample_index,
        exposure,
        adapted,
        depth,
        adaptive_step,
        overlay,
        settling,
        tint,
    } = picture;
    // Before what comes over it, where that cannot be blended with it.
    let (display, over) = match overlay {
        Some(_) if may_be_transparent(settings) => (r.texture_of("overlay.below", display.desc()), Some(display)),
        _ => (display, None),
    };
    let curve = settings.tone_map.curve;
    let share = |average, part| accumulate::Share { average, part, sample_index, exposure };
    let of_display = share(accumulate::Average::Display(curve), SamplePart::Whole);
    let of_radiance = share(accumulate::Average::Radiance, SamplePart::Whole);
    let background = settings.background.source;
    let is_done = tone_map::Display { background, is_mean: true, ..tone_map::ENCODING };
    let is_linear = tone_map::Display { curve, exposure, ..is_done };
    let mut glow = None;
    let (mean, left) = match means {
        Means::None => (None, tone_map::Display { is_mean: false, ..is_linear }),
        Means::Display(mean) => {
            let mean = accumulate::record_unsettled(r, of_display, radiance, depth, mean)?;
            if let Some(settling) = settling {
                adaptive::record(r, &settings.adaptive, (adaptive_step, sample_index), &mean, settling)?;
            }
            (Some(mean), is_done)
        }
        Means::Radiance(mean) => (Some(accumulate::record(r, "accumulate", of_radiance, radiance, mean)?), is_linear),
        Means::Both([mean, mean_of_radiance]) => {
            // Beside the other it has a name of its own.
            let linear = accumulate::record(r, "accumulate.radiance", of_radiance, radiance, mean_of_radiance)?;
            r.graph.export(linear);
            (Some(accumulate::record(r, "accumulate", of_display, radiance, mean)?), is_done)
        }
        Means::Parts { rest, glow: mean_of_glow, radiance: mean_of_radiance } => {
            if let Some(mean) = mean_of_radiance {
                let of_radiance = share(accumulate::Average::Radiance, SamplePart::Marked);
                let linear = accumulate::record(r, "accumulate.radiance", of_radiance, radiance, mean)?;
                r.graph.export(linear);
            }
            let of_glow = share(accumulate::Average::Display(curve), SamplePart::Glow);
            glow = Some(accumulate::record(r, "accumulate.glow", of_glow, radiance, mean_of_glow)?);
            let of_rest = share(accumulate::Average::Radiance, SamplePart::Rest);
            (Some(accumulate::record(r, "accumulate", of_rest, radiance, rest)?), is_linear)
        }
    };
    let radiance = mean.as_ref().unwrap_or(radiance);
    let tint = tint.map(|tint| tint_passes(r, of_radiance, tint)).transpose()?;
    let inputs =
        tone_map::DisplayInputs { radiance, glow: glow.as_ref(), adapted, tint: tint.as_ref().map(|(tint, _)| tint) };
    let is_of_display =
        |effect: &&Arc<dyn Effect>| is_shown && effect.is_on() && effect.stage() == EffectStage::Display;
    let on_display = effects.iter().any(|effect| is_of_display(&effect)).then_some(effects);
    let display = display_passes(r, &settings.tone_map, (left, inputs), on_display, display)?;
    let display = debug::record(r, &settings.debug, display)?;
    let display = overlay_passes(r, overlay, display, over)?;
    for mean in mean.into_iter().chain(glow) {
        r.graph.export(mean);
    }
    if let Some((mean, true)) = tint {
        r.graph.export(mean);
    }
    if let Some(target) = target {
        present::record(r, &display, target)?;
    }
    // Otherwise the passes that make it are culled.
    if is_shown {
        r.graph.export(display);
    }
    Ok(())
}

/// Adds what comes through glass of the background to its mean, if it has one. Returns what there is of it so far, and
/// whether that is a mean.
fn tint_passes(
    r: &mut Recorder<'_, '_>,
    share: accumulate::Share,
    Tint { texture, mean }: Tint,
) -> Result<(Handle, bool), ProgramError> {
    Ok(match mean {
        Some(mean) => (accumulate::record(r, "accumulate.tint", share, &texture, mean)?, true),
        None => (texture, false),
    })
}

/// The display transform of what is `left`, with the effects on display colours between its halves, if there are any.
fn display_passes<'f>(
    r: &mut Recorder<'_, 'f>,
    tone: &ToneMapSettings,
    (left, inputs): (tone_map::Display, tone_map::DisplayInputs<'_>),
    effects: Option<&'f [Arc<dyn Effect>]>,
    display: Handle,
) -> Result<Handle, ProgramError> {
    let Some(effects) = effects else { return tone_map::record(r, "tone_map", tone, left, inputs, display) };
    let linear = r.texture_of("tone_map.linear", TextureDesc { format: RADIANCE, ..display.desc() });
    let left = tone_map::Display { encodes: false, ..left };
    let linear = tone_map::record(r, "tone_map", tone, left, inputs, linear)?;
    let linear = effect::record(r, effects, EffectStage::Display, &FrameTextures::default(), linear)?;
    scrub::count(r, "scrub.display.count".into(), &linear)?;
    let inputs = tone_map::DisplayInputs { radiance: &linear, glow: None, adapted: None, tint: None };
    tone_map::record(r, "tone_map.encode", tone, tone_map::ENCODING, inputs, display)
}

/// Whether a picture may let something through.
fn may_be_transparent(settings: &Settings) -> bool {
    settings.background.source.colors().is_none()
}

/// What is drawn over the finished picture: in place, or together with it into the picture `over`.
fn overlay_passes(
    r: &mut Recorder<'_, '_>,
    overlay: Option<&OverlayDraw>,
    display: Handle,
    over: Option<Handle>,
) -> Result<Handle, ProgramError> {
    let Some(overlay) = overlay else { return Ok(display) };
    // That of the view may be of several samples a pixel, and lacks what is settled.
    let depth = if overlay.tests_depth { Some(forward::record_depth(r, "overlay.depth")?) } else { None };
    match over {
        Some(over) => overlay::record_over(r, overlay, depth.as_ref(), &display, over),
        None => overlay::record(r, overlay, depth.as_ref(), display),
    }
}

/// The means over the samples so far, each with the texture for the next one.
#[derive(Debug)]
pub enum Means {
    /// None: there is one sample, and nobody reads its radiance.
    None,
    /// Of display colours.
    Display(accumulate::Mean),
    /// Of radiance.
    Radiance(accumulate::Mean),
    /// Of display colours, then of radiance.
    Both([accumulate::Mean; 2]),
    /// Of parts of every sample, because lights take turns.
    Parts {
        /// Of what glows, display colours.
        glow: accumulate::Mean,
        /// Of all else, radiance.
        rest: accumulate::Mean,
        /// Of both, radiance, if it is to be read.
        radiance: Option<accumulate::Mean>,
    },
}

/// The picture that a view ends in.
#[derive(Debug)]
pub struct Picture<'t> {
    /// Where it goes.
    pub display: Handle,
    /// Where the caller wants it as well.
    pub target: Option<&'t Target>,
    /// Whether it is shown after this frame, or only added to.
    pub is_shown: bool,
    /// How many frames were added before.
    pub sample_index: u32,
    /// From pre-exposed radiance to what the tone curve takes.
    pub exposure: f32,
    /// The stops that come on top, in one texel, if exposure adapts.
    pub adapted: Option<&'t Handle>,
    /// Depth of the view: where it is nearest, tiles are settled, and keep their mean.
    pub depth: &'t Handle,
    /// What is drawn over it.
    pub overlay: Option<&'t OverlayDraw>,
    /// What is done once this frame was added, if its means are of display colours.
    pub adaptive_step: adaptive::Step,
    /// What that is done to.
    pub settling: Option<adaptive::ConvergedTiles>,
    /// What comes through glass of the background beside what alpha says, if there is any.
    pub tint: Option<Tint>,
}

/// What comes through glass of the background beside what alpha says.
#[derive(Debug)]
pub struct Tint {
    /// Of the frame.
    pub texture: Handle,
    /// The mean that it is added to, where the picture or its radiance is one.
    pub mean: Option<accumulate::Mean>,
}
