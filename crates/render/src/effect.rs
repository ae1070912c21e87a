//! Effects: passes of the user's own between shading and accumulation or after the tone curve, most of them one WGSL
//! file.

mod chain;
mod checks;
mod compiled;
mod declarations;
mod draw;
mod fallback;
mod file;
mod fused;
mod header;
mod library;
mod lut;
mod rename;
mod steps;
mod wgsl;

pub use crate::settings::EffectSettings;
pub use file::EffectFile;
pub use wgsl::WgslEffect;

pub(crate) use chain::{FrameTextures, is_read, record};
pub(crate) use fallback::cheaper;

use crate::gbuffer::Gbuffer;
use crate::record::Recorder;
use crate::settings::{SettingInput, Settings, SettingsError};
use crate::shader::program::ProgramError;
use manypass_graph::Handle;
use std::fmt::Debug;

/// The stage of a frame at which an effect runs: on radiance or on display colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EffectStage {
    /// Radiance, of every sample: after the surfaces, before the tone curve.
    #[default]
    Radiance,
    /// Display colours, of the mean of all samples: after the tone curve and over the background, before they become
    /// 8 bits. Linear files, which hold radiance, know nothing of it.
    Display,
}

/// A pass, or several, that make new radiance of a view's radiance, or new display colours.
/// [`crate::FrameRequest::effects`] lists them in their order; those of one stage follow each other.
///
/// [`WgslEffect`] is the one of full-screen shaders in one file. Implement this trait for anything else, such as passes
/// with pipelines, buffers or targets of their own: the example `rust_pass` has a history.
pub trait Effect: Debug + wgpu::WasmNotSendSync {
    /// Records the passes and returns what holds the new radiance: the format of `radiance`, pre-exposed, with coverage
    /// in alpha. `gbuffer` is none on the forward path. At [`EffectStage::Display`] it is given display colours, linear
    /// and multiplied by alpha, and no `gbuffer`.
    ///
    /// Whatever it does wrong with the graph is an error of the frame, which then changes nothing.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    fn record<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        gbuffer: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError>;

    /// What it makes new.
    fn stage(&self) -> EffectStage {
        EffectStage::Radiance
    }

    /// Whether it draws anything in the next frame; where it does not, the frame is as if it were not listed.
    fn is_on(&self) -> bool {
        true
    }

    /// The effect as one of WGSL files, if it is one: those know each other's textures, and those that follow each other
    /// and change pixels alone are drawn in one pass.
    fn wgsl(&self) -> Option<&WgslEffect> {
        None
    }
}

/// Sets `key` to what was written among the settings of `effects` and those of the frame. Keys of effects come first,
/// so that a setting which a later version adds takes nothing from a file that works today.
///
/// # Errors
/// A key that nobody has, or a value that it does not take.
pub fn set(
    settings: &mut Settings,
    effects: &mut [EffectFile],
    key: &str,
    written: &SettingInput,
) -> Result<(), SettingsError> {
    if let Some(effect) = effects.iter_mut().find(|effect| effect.has(key)) {
        return effect.give(key, written);
    }
    let result = settings.give(key, written);
    if !matches!(result, Err(SettingsError::UnknownKey { .. })) {
        return result;
    }
    let own = effects.iter().flat_map(EffectFile::settings);
    Err(crate::setting::unknown_key(key, own.chain(Settings::declared()).map(|info| &*info.key)))
}

/// As [`set`], of a file that several chains are drawn with: what it says of a built-in effect that is in none of them
/// is checked, and does nothing.
///
/// # Errors
/// As [`set`].
pub fn set_of_file(
    settings: &mut Settings,
    effects: &mut [EffectFile],
    key: &str,
    written: &SettingInput,
) -> Result<(), SettingsError> {
    let name = key.split_once('.').map_or(key, |(name, _)| name);
    let is_drawn = effects.iter().any(|effect| effect.name() == name);
    let absent = EffectFile::built_in(name).filter(|_| !is_drawn).and_then(Result::ok);
    match absent {
        Some(mut effect) => effect.give(key, written),
        None => set(settings, effects, key, written),
    }
}
