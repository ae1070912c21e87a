//! Effects that are drawn in every picture, whatever its request lists.

use super::Renderer;
use crate::effect::{Effect, WgslEffect, cheaper};
use crate::request::FrameRequest;
use crate::shader::program::ProgramError;
use std::sync::Arc;

impl Renderer {
    /// Compiles an effect and draws it in every picture from now on, after those of [`FrameRequest::effects`]. What it
    /// gives back sets its settings.
    ///
    /// # Errors
    /// As [`WgslEffect::new`], and a name that another added effect has.
    pub fn add_effect(&mut self, file: &str, source: &str) -> Result<Arc<WgslEffect>, ProgramError> {
        let effect = Arc::new(WgslEffect::new(&self.gpu, file, source)?);
        if self.added.iter().any(|other| other.name() == effect.name()) {
            let message = "an effect of that name was added before; `Renderer::replace_effect` gives it another text";
            return Err(ProgramError::Misplaced { pass: effect.name().into(), message: message.into() });
        }
        self.added.push(effect.clone());
        Ok(effect)
    }

    /// Gives the added effect `name` another text, as [`WgslEffect::replace`]: what is broken leaves it as it is, so that a
    /// file can be watched while it is written.
    ///
    /// # Errors
    /// As [`WgslEffect::replace`], with file, line and column; there is no such effect.
    pub fn replace_effect(&self, name: &str, source: &str) -> Result<(), ProgramError> {
        self.added_effect(name)?.replace(source)
    }

    /// Draws the added effect `name` no longer.
    ///
    /// # Errors
    /// There is none.
    pub fn remove_effect(&mut self, name: &str) -> Result<(), ProgramError> {
        let removed = self.added_effect(name)?.clone();
        self.added.retain(|effect| !Arc::ptr_eq(effect, &removed));
        Ok(())
    }

    fn added_effect(&self, name: &str) -> Result<&Arc<WgslEffect>, ProgramError> {
        self.added.iter().find(|effect| effect.name() == name).ok_or_else(|| {
            let known: Vec<&str> = self.added.iter().map(|effect| effect.name()).collect();
            let message = format!("no effect of that name was added; there is: {}", known.join(", "));
            ProgramError::Misplaced { pass: name.into(), message }
        })
    }

    /// Puts the added effects behind those of a request, and cheaper ones in place of those that name some, where the
    /// settings ask for that.
    ///
    /// # Errors
    /// The device refuses a cheaper one.
    pub(super) fn add_effects_to(&self, request: &mut FrameRequest) -> Result<(), ProgramError> {
        let settings = &request.settings.effects;
        if settings.enabled {
            request.effects.extend(self.added.iter().map(|effect| effect.clone() as Arc<dyn Effect>));
        }
        if settings.enabled && settings.fallbacks {
            request.effects = cheaper(&request.effects)?;
        }
        Ok(())
    }
}
