//! occlusion: what opaque surfaces hide of the environment from each other, as far as the picture shows it.
//!
//! Sources: horizons (Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion"), or points
//! in a hemisphere (Mittring 2007, "Finding Next Gen: CryEngine 2"); what differs from them stands in `gtao.wgsl` and
//! `ssao.wgsl`. Each sample of a still has other noise, so that their mean converges; that of few samples is a pattern
//! of 4 × 4 texels, which `occlusion.blur` takes out. `occlusion.upsample` brings a smaller picture to the full size.
//! Reads: normal, linear_depth. Writes: occlusion, the share of diffuse light of the environment that reaches a
//! surface, and where it is asked for its mean direction.

mod settings;

pub use settings::{OcclusionMethod, OcclusionSettings};

use crate::constants::DISTANCE_BACKGROUND_M;
use crate::occlusion::{Occlusion, OcclusionCache};
use crate::pass_info::{PassInfo, Reach};
use crate::record::{Fullscreen, PicturePart, Recorder, Texels, UNFILTERED_SAMPLES};
use crate::render_settings::Path;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, History, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo {
    off: Some("occlusion.enabled=false"),
    paths: &[Path::Deferred, Path::Forward, Path::ForwardBatched],
    in_fisheye: false,
    tiers: &["medium", "high", "ultra"],
    variables: &["occlusion_screen"],
    effect_inputs: &["occlusion"],
    ..PassInfo::new("occlusion")
};

/// How far it looks; none if settings switch it off. With its direction occlusion takes all samples to converge.
pub fn reach(settings: &OcclusionSettings) -> Option<Reach> {
    let reach = if settings.bent_normals { Reach::EverySample } else { Reach::FirstSamples };
    settings.enabled.is_on().then_some(reach)
}

/// The share of light that is left, which may lie outside of 0 to 1 where a sample looks in few directions.
const VISIBILITY: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// The same, and the mean direction of that light.
const BENT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The mean of what samples of a still found of a pixel, and of how many it is.
const MEAN: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Float;

/// The share, and how far away surfaces are, so that passes that look for those find both in one texel.
const WITH_DISTANCES: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// The variable, in a format that every backend reads back.
const VARIABLE: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Of the radius: so far from the tangent plane another surface begins; as `taps.wgsl` has it.
const THICKNESS: f32 = 0.1;

/// The mean of so many samples shows nothing of their noise, in narrow gaps neither, where each loses all or nothing.
const UNFILTERED_MEAN: u32 = 256;

/// Where there is no surface.
const OPEN: ColorLoad = ColorLoad::Clear(wgpu::Color { r: 1.0, g: 0.0, b: 0.0, a: 0.0 });

/// The same in smaller pictures, as shaders write it: texels may say how far away their surface is.
fn open_texel(has_distances: bool) -> ColorLoad {
    let distance_m = if has_distances { f64::from(DISTANCE_BACKGROUND_M) } else { 0.0 };
    ColorLoad::Clear(wgpu::Color { r: 1.0, g: distance_m, b: 0.0, a: 0.0 })
}

/// The radius, where the settings leave it open, as a share of the extent of what is seen.
const RADIUS_SHARE: f32 = 0.05;

/// The uniform of `taps.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct OcclusionUniform {
    radius_m: f32,
    /// 1 / the length over which occlusion fades out before the radius ends.
    fade_per_m: f32,
    thinness: f32,
    intensity: f32,
    /// Of the radius, what rises less than that occludes nothing where points look.
    bias: f32,
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

impl OcclusionUniform {
    fn new(settings: &OcclusionSettings, extent_m: f32) -> Self {
        let radius_m = if settings.radius_m > 0.0 { settings.radius_m } else { RADIUS_SHARE * extent_m };
        let radius_m = if radius_m.is_finite() { radius_m.clamp(1e-6, 1e6) } else { 1.0 };
        let fade_per_m = 1.0 / (radius_m * settings.falloff.max(1e-4));
        let OcclusionSettings { thinness, intensity, bias, .. } = *settings;
        Self { radius_m, fade_per_m, thinness, intensity, bias, padding_0: 0.0, padding_1: 0.0, padding_2: 0.0 }
    }
}

/// What is known of the surfaces in the picture.
#[derive(Clone, Copy, Debug)]
pub struct ScreenInputs<'h> {
    /// World normal, as the G-buffer has it.
    pub normal: &'h Handle,
    /// Metres along the view axis.
    pub linear_depth: &'h Handle,
    /// Depth, with one sample a pixel.
    pub depth: &'h Handle,
}

/// Whether the settings ask for it and there is light to be hidden, or whether it `is_read` by an effect.
pub fn is_needed(r: &Recorder<'_, '_>, settings: &OcclusionSettings, is_read: bool) -> bool {
    settings.enabled.is_on() && (is_read || !r.view.is_environment_dark) && !r.view.counts_pairs()
}

/// Records the passes, if the settings ask for them and there is light to be hidden, or if it `is_read` by an effect.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &OcclusionSettings,
    is_read: bool,
    inputs: ScreenInputs<'_>,
) -> Result<Option<Occlusion>, ProgramError> {
    if !is_needed(r, settings, is_read) {
        return Ok(None);
    }
    let (texture, cache) = match r.view.whole_samples {
        None => (record_found(r, settings, inputs)?, None),
        Some(whole) if whole < UNFILTERED_SAMPLES => {
            let (look, before) = record_look(r, settings, inputs)?;
            (look, Some(before))
        }
        Some(whole) => {
            let mean = r.history("occlusion.mean", r.view.desc(MEAN));
            r.declare_texels(&mean.next, Texels::Share);
            let is_there = r.view.uniform.sample_index >= whole && !mean.is_first;
            (if is_there { mean.previous } else { record_mean(r, settings, inputs, (mean, whole))? }, None)
        }
    };
    let (is_multi_bounce, is_bent) = (settings.multi_bounce, settings.bent_normals);
    Ok(Some(Occlusion { texture, cache, is_multi_bounce, is_bent }))
}

/// What a sample finds by itself.
fn record_found(
    r: &mut Recorder<'_, '_>,
    settings: &OcclusionSettings,
    inputs: ScreenInputs<'_>,
) -> Result<Handle, ProgramError> {
    let finding = OcclusionPasses::new(r, settings, r.view.shows_few_samples());
    finding.record_whole(r, inputs, if settings.bent_normals { BENT } else { VISIBILITY })
}

/// The variable: what the view's first sample finds, at the full size and without its noise. It has passes of its own,
/// so that the picture is the same beside it, with occlusion or without.
///
/// # Errors
/// A program that does not compile.
pub fn record_variable(
    r: &mut Recorder<'_, '_>,
    settings: &OcclusionSettings,
    inputs: ScreenInputs<'_>,
) -> Result<Handle, ProgramError> {
    // The variable is the share alone.
    let settings = OcclusionSettings { bent_normals: false, ..settings.clone() };
    let names = ["occlusion.variable", "occlusion.variable.blur", "occlusion.variable.upsample"];
    let finding = OcclusionPasses { names, ..OcclusionPasses::new(r, &settings, true) };
    finding.record_whole(r, inputs, VARIABLE)
}

/// Of a still of few samples whose later ones leave tiles out: its first one looks around, takes the pattern of its
/// noise out, and keeps what it found for all. Where they shade a surface, they take what lies on it, so that occlusion
/// is as smooth along edges as the picture.
fn record_look(
    r: &mut Recorder<'_, '_>,
    settings: &OcclusionSettings,
    inputs: ScreenInputs<'_>,
) -> Result<(Handle, OcclusionCache), ProgramError> {
    let finding = OcclusionPasses::new(r, settings, true);
    // Where nothing is blurred, what looks around is what is kept.
    let has_distances = finding.has_distances || !finding.is_filtered;
    let finding = OcclusionPasses { keeps_distances: true, has_distances, bridges_grooves: true, ..finding };
    let look = r.history("occlusion.look", TextureDesc { format: WITH_DISTANCES, ..finding.desc });
    r.declare_texels(&look.next, Texels::Share);
    let looks = look.is_first || r.view.uniform.sample_index == 0;
    let texture = if looks { finding.record(r, inputs, look.next)? } else { look.previous };
    Ok((texture, OcclusionCache { side_px: finding.side_px, reach_m: THICKNESS * finding.uniform.radius_m }))
}

/// Of a still whose later samples leave tiles out: the `mean` of what its first samples find, who draw all that
/// occludes, and are as many as take the noise out.
fn record_mean(
    r: &mut Recorder<'_, '_>,
    settings: &OcclusionSettings,
    inputs: ScreenInputs<'_>,
    (mean, whole): (History, u32),
) -> Result<Handle, ProgramError> {
    let finding = OcclusionPasses::new(r, settings, whole < UNFILTERED_MEAN);
    let target = share_texture(r, finding.last_name(), finding.desc);
    let found = finding.record(r, inputs, target)?;
    let step = finding.upsample(r, inputs, &found);
    let step = if mean.is_first {
        step.constant("keeps_mean", 1).stand_in("previous_occlusion")
    } else {
        step.constant("keeps_mean", 2).read("previous_occlusion", &mean.previous)
    };
    step.draw_into(mean.next, ColorLoad::Discard)
}

/// A texture whose first channel is the share of light that is left, whatever the others are.
fn share_texture(r: &mut Recorder<'_, '_>, name: &'static str, desc: TextureDesc) -> Handle {
    let texture = r.texture_of(name, desc);
    r.declare_texels(&texture, Texels::Share);
    texture
}

/// How a picture of occlusion is made, at its size.
struct OcclusionPasses<'s> {
    /// Of the pass that looks around, of the one that takes noise out, and of the one that brings it to the full size.
    names: [&'static str; 3],
    settings: &'s OcclusionSettings,
    uniform: OcclusionUniform,
    desc: TextureDesc,
    side_px: u32,
    /// Whether its noise is a pattern, which is taken out.
    is_filtered: bool,
    /// Whether what looks around writes how far away surfaces are beside what it found.
    has_distances: bool,
    /// Whether that is in the last texture, too.
    keeps_distances: bool,
    /// Whether a texel of a groove thinner than a pixel stands for the surface around that.
    bridges_grooves: bool,
}

impl<'s> OcclusionPasses<'s> {
    fn new(r: &Recorder<'_, '_>, settings: &'s OcclusionSettings, is_filtered: bool) -> Self {
        let side_px = settings.resolution.side_px();
        // Directions take the other channels. At the full size distances are there as they are.
        let has_distances = side_px > 1 && !settings.bent_normals;
        let format = match settings.bent_normals {
            true => BENT,
            false if has_distances => WITH_DISTANCES,
            false => VISIBILITY,
        };
        Self {
            names: ["occlusion", "occlusion.blur", "occlusion.upsample"],
            settings,
            uniform: OcclusionUniform::new(settings, r.extent_m()),
            desc: settings.resolution.desc(r.view, format),
            side_px,
            is_filtered: is_filtered && settings.blur,
            has_distances,
            keeps_distances: has_distances,
            bridges_grooves: false,
        }
    }

    /// The name of the texture that holds what is found.
    fn last_name(&self) -> &'static str {
        let [look, blur, _] = self.names;
        if self.is_filtered { blur } else { look }
    }

    /// What all steps have in common.
    fn step<'r, 'f>(&self, step: Fullscreen<'r, 'f>, inputs: ScreenInputs<'_>) -> Fullscreen<'r, 'f> {
        let step = step.constant("side", self.side_px).constant("has_distances", u32::from(self.has_distances));
        let step = step.constant("bridges_grooves", u32::from(self.bridges_grooves));
        step.uniform("occlusion", &self.uniform).read("normal", inputs.normal).read("linear_depth", inputs.linear_depth)
    }

    /// Looks around, and brings what is found to the full size, into a texture of `format`.
    fn record_whole(
        &self,
        r: &mut Recorder<'_, '_>,
        inputs: ScreenInputs<'_>,
        format: wgpu::TextureFormat,
    ) -> Result<Handle, ProgramError> {
        let whole = r.view.desc(format);
        let target = share_texture(r, self.last_name(), if self.side_px == 1 { whole } else { self.desc });
        let found = self.record(r, inputs, target)?;
        if self.side_px == 1 {
            return Ok(found);
        }
        let target = share_texture(r, self.names[2], whole);
        let step = self.upsample(r, inputs, &found).constant("keeps_mean", 0).stand_in("previous_occlusion");
        step.over(PicturePart::Surfaces, inputs.depth).draw_into(target, OPEN)
    }

    /// Looks around, and draws what is found into `target`.
    fn record(
        &self,
        r: &mut Recorder<'_, '_>,
        inputs: ScreenInputs<'_>,
        target: Handle,
    ) -> Result<Handle, ProgramError> {
        let Self { names: [look, blur, _], settings, desc, side_px, is_filtered, .. } = *self;
        let program = match settings.method {
            OcclusionMethod::Gtao => "occlusion_gtao",
            OcclusionMethod::Ssao => "occlusion_ssao",
        };
        let of_surfaces = |step: Fullscreen<'_, '_>, target, depth, has_distances| match side_px {
            1 => step.over(PicturePart::Surfaces, depth).draw_into(target, OPEN),
            _ => step.within_surfaces(side_px).draw_into(target, open_texel(has_distances)),
        };
        let (noisy, blurred) = if is_filtered { (share_texture(r, look, desc), Some(target)) } else { (target, None) };
        let step = self.step(r.fullscreen(look, program, &[]), inputs).constants(&[
            ("patterned", u32::from(is_filtered)),
            ("noisy", u32::from(settings.noise)),
            ("bends", u32::from(settings.bent_normals)),
        ]);
        let [slices, steps] = settings.lengths();
        let step = match settings.method {
            OcclusionMethod::Gtao => step.constant("slices", slices).constant("steps", steps),
            OcclusionMethod::Ssao => step.constant("kernel", settings.points()),
        };
        let found = of_surfaces(step, noisy, inputs.depth, self.has_distances)?;
        let Some(target) = blurred else { return Ok(found) };
        let step = self.step(r.fullscreen(blur, "occlusion_blur", &[]), inputs);
        let step = step.constant("keeps_distances", u32::from(self.keeps_distances)).read("noisy_occlusion", &found);
        of_surfaces(step, target, inputs.depth, self.keeps_distances)
    }

    /// The step that brings what was `found` to the full size.
    fn upsample<'r, 'f>(
        &self,
        r: &'r mut Recorder<'_, 'f>,
        inputs: ScreenInputs<'_>,
        found: &Handle,
    ) -> Fullscreen<'r, 'f> {
        let step = self.step(r.fullscreen(self.names[2], "occlusion_upsample", &[]), inputs);
        step.constant("patterned", u32::from(self.is_filtered)).read("coarse_occlusion", found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "occlusion_gtao",
            "Occlusion",
            OcclusionUniform,
            [radius_m, fade_per_m, thinness, intensity, bias, padding_0, padding_1, padding_2]
        );
    }

    #[test]
    fn the_radius_is_that_of_the_settings_or_of_what_is_seen() {
        let auto = OcclusionSettings::default();
        assert_eq!(OcclusionUniform::new(&auto, 5.0).radius_m, 0.25);
        assert_eq!(OcclusionUniform::new(&OcclusionSettings { radius_m: 2.0, ..auto.clone() }, 5.0).radius_m, 2.0);
        for extent_m in [f32::INFINITY, 0.0, 1.0] {
            let hard = OcclusionUniform::new(&OcclusionSettings { falloff: 0.0, ..auto.clone() }, extent_m);
            assert!(hard.radius_m > 0.0 && hard.fade_per_m.is_finite(), "{hard:?}");
        }
    }
}
