//! What a surface is drawn with: less of its material where it is seen small.

/// How much of its material a surface has. Later ones have less.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum SurfaceForm {
    /// All.
    #[default]
    Whole,
    /// All but normal maps, relief and clear coats.
    Smooth,
    /// What the G-buffer holds: no layers.
    Plain,
    /// That, and the means of textures in their place.
    Untextured,
}

impl SurfaceForm {
    /// Those with less than all, that which has most first.
    pub const REDUCED: [Self; 3] = [Self::Smooth, Self::Plain, Self::Untextured];
}

/// A set of [`SurfaceForm::REDUCED`]: those of a surface that are another than the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SurfaceForms(u8);

impl SurfaceForms {
    /// Of those for which `is_there` says so.
    pub fn of(is_there: impl Fn(SurfaceForm) -> bool) -> Self {
        Self(SurfaceForm::REDUCED.into_iter().filter(|form| is_there(*form)).fold(0, |set, form| set | 1 << form as u8))
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether one is there.
    pub fn has(self, form: SurfaceForm) -> bool {
        self.0 & 1 << form as u8 != 0
    }

    /// That of a step of all of them; 0 is the whole material.
    pub fn at(self, step: u32) -> SurfaceForm {
        let mut forms = SurfaceForm::REDUCED.into_iter().filter(|form| self.has(*form));
        let before = step.checked_sub(1);
        before.and_then(|before| forms.nth(before as usize)).unwrap_or_default()
    }
}
