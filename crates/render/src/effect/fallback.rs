//! What is drawn in place of an effect where time is short: the word `fallback` of its header, and the setting
//! `effects.fallbacks`.

use super::header::{Header, NO_FALLBACK};
use super::library::text_of;
use super::{Effect, EffectFile, EffectStage, WgslEffect};
use crate::diagnostic::Diagnostic;
use crate::shader::program::ProgramError;
use crate::user_shader::Source;
use crate::user_shader::scan::scan;
use std::ops::Range;
use std::sync::Arc;

/// What is drawn in place of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fallback {
    /// Nothing.
    Nothing,
    /// The built-in effect of this name.
    BuiltIn(&'static str),
}

impl Fallback {
    /// As a header has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => NO_FALLBACK,
            Self::BuiltIn(name) => name,
        }
    }
}

/// What the header of the effect `name`, which makes `stage` new, says.
///
/// # Errors
/// There is no such effect, it is the effect itself, or it stands on the other side of the tone curve.
pub(super) fn checked(
    source: Source<'_>,
    name: &str,
    stage: EffectStage,
    (said, place): &(String, Range<usize>),
) -> Result<Fallback, Box<Diagnostic>> {
    if said == NO_FALLBACK {
        return Ok(Fallback::Nothing);
    }
    let fault = |message: String, note: &str| Box::new(source.fault(place.clone(), message).note(note));
    let Some((known, text)) = text_of(said) else {
        let known: Vec<&str> = EffectFile::built_in_names().collect();
        let message = format!("no built-in effect is called `{said}`; there is: {}", known.join(", "));
        return Err(fault(message, "`//! fallback: none` leaves the effect out where time is short"));
    };
    if said == name {
        return Err(fault("an effect is no cheaper than itself".into(), "name another one, or `none`"));
    }
    let other = Header::parse(Source { file: known, text }, &scan(text))?;
    let other = if other.reads_display() { EffectStage::Display } else { EffectStage::Radiance };
    if other != stage {
        let word = |stage| if stage == EffectStage::Display { "display colours" } else { "radiance" };
        let message = format!("`{said}` is an effect on {}, and `{name}` one on {}", word(other), word(stage));
        return Err(fault(message, "they stand on different sides of the tone curve; name one of the same side"));
    }
    Ok(Fallback::BuiltIn(known))
}

/// The effects of a chain, with the cheaper ones in place of those that name one. An effect that is off, or whose textures
/// another one reads, stays; a cheaper one that is in the chain anyway is drawn once.
///
/// # Errors
/// The device refuses what comes with the renderer.
pub(crate) fn cheaper(effects: &[Arc<dyn Effect>]) -> Result<Vec<Arc<dyn Effect>>, ProgramError> {
    let on = || effects.iter().filter(|effect| effect.is_on()).filter_map(|effect| effect.wgsl());
    let is_read = |name: &str| {
        on().any(|effect| {
            effect
                .needs()
                .borrowed
                .iter()
                .any(|borrowed| borrowed.of_effect().is_some_and(|(effect, _)| effect == name))
        })
    };
    let mut drawn: Vec<Arc<dyn Effect>> = Vec::with_capacity(effects.len());
    let mut added: Vec<&str> = Vec::new();
    for effect in effects {
        let own = effect.wgsl().filter(|own| effect.is_on() && !is_read(own.name()));
        let Some((own, fallback)) = own.and_then(|own| Some((own, own.fallback()?))) else {
            drawn.push(effect.clone());
            continue;
        };
        let Fallback::BuiltIn(name) = fallback else { continue };
        if added.contains(&name) || on().any(|other| other.name() == name) {
            continue;
        }
        added.push(name);
        drawn.push(own.cheaper(name)?);
    }
    Ok(drawn)
}

impl WgslEffect {
    /// The built-in effect that is drawn in its place; it is compiled once.
    fn cheaper(&self, name: &str) -> Result<Arc<dyn Effect>, ProgramError> {
        if let Some(known) = self.compiled_fallback().filter(|known| known.name() == name) {
            return Ok(known);
        }
        let Some(file) = EffectFile::built_in(name).transpose()? else {
            let message = format!("no built-in effect is called `{name}`");
            return Err(ProgramError::Misplaced { pass: self.name().into(), message });
        };
        let compiled = Arc::new(Self::compile(self.gpu(), file)?);
        self.keep_fallback(compiled.clone());
        Ok(compiled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(header: &str) -> Result<Option<String>, String> {
        let text = format!(
            "//! effect mine\n//! reads: display\n{header}\n@fragment fn fs_mine(@builtin(position) p: vec4f) -> \
             @location(0) vec4f {{ return textureLoad(display, vec2i(p.xy), 0); }}"
        );
        let parsed = EffectFile::parse("mine.wgsl", &text).map_err(|error| error.to_string())?;
        Ok(parsed.fallback().map(str::to_owned))
    }

    #[test]
    fn a_header_names_a_built_in_effect_of_its_side_or_none() {
        assert_eq!(parse(""), Ok(None));
        assert_eq!(parse("//! fallback: none"), Ok(Some("none".into())));
        assert_eq!(parse("//!fallback:  fxaa "), Ok(Some("fxaa".into())));
        for (header, expected) in [
            (
                "//! fallback: fxaaa",
                "mine.wgsl:3:15: error: no built-in effect is called `fxaaa`; there is: bloom, blur",
            ),
            ("//! fallback: fxaaa", "^^^^^"),
            ("//! fallback: mine", "no built-in effect is called `mine`"),
            ("//! fallback: fxaa, blur", "no built-in effect is called `fxaa, blur`"),
            (
                "//! fallback: bloom",
                "mine.wgsl:3:15: error: `bloom` is an effect on radiance, and `mine` one on display",
            ),
        ] {
            let error = parse(header).expect_err(header);
            assert!(error.contains(expected), "{header}\n{error}\nshould say {expected}");
        }
    }

    #[test]
    fn fallbacks_of_built_in_effects_have_none_of_their_own() {
        for name in EffectFile::built_in_names() {
            let file = EffectFile::built_in(name).expect("a name of the library").expect("a valid text");
            let Some(fallback) = file.fallback().filter(|name| *name != NO_FALLBACK) else { continue };
            let other = EffectFile::built_in(fallback).expect("a name of the library").expect("a valid text");
            assert_eq!(other.fallback(), None, "{name}");
        }
    }
}
