//! What the texels of targets hold: targets that pack several things are looked at by what their passes say of them.

use std::cell::RefCell;

/// The meaning of a target's texels, by which they are unpacked for display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texels {
    /// Colours, or radiance, which is clipped.
    Color,
    /// A share from 0 to 1 in the first channel, whatever the others hold: grey from black to white.
    Share,
    /// A number in the first channel: the least is black, the greatest white.
    Number,
    /// Metres in the first channel: what is near is bright, what is infinitely far away black.
    Distance,
    /// Depth of an attachment, which is 1 at the near plane and 0 infinitely far away.
    Depth,
    /// A direction in two octahedral channels of 16 bits: each axis from -1 to 1 is a colour from 0 to 1.
    Direction,
    /// Pixels moved, to the right and down: grey where nothing moves, 32 pixels to either side.
    Motion,
    /// The ids of a node and of a material: a colour of its own for each node, shaded by the material.
    Ids,
}

impl Texels {
    /// What a target of this format holds, if its pass says nothing; none if there is nothing to look at.
    pub fn of_format(format: wgpu::TextureFormat) -> Option<Self> {
        use wgpu::TextureFormat as F;
        Some(match format {
            F::Rgba8Unorm | F::Rgba8UnormSrgb | F::Rgba16Float | F::Rgba32Float => Self::Color,
            F::R8Unorm | F::R16Float | F::Rg16Float => Self::Share,
            F::R32Float => Self::Distance,
            F::Depth32Float => Self::Depth,
            F::Rg16Uint => Self::Direction,
            F::Rg32Float => Self::Motion,
            F::Rg32Uint => Self::Ids,
            _ => return None,
        })
    }
}

/// What passes say of their targets in a frame, each with the name of the target in the graph.
#[derive(Debug, Default)]
pub(crate) struct TargetTexels(RefCell<Vec<(String, Texels)>>);

impl TargetTexels {
    /// Adds what the target `name` holds.
    pub fn add(&self, name: &str, texels: Texels) {
        self.0.borrow_mut().push((name.into(), texels));
    }

    /// All of it, for whoever outlives the frame; nothing is left here.
    pub fn take(&self) -> Self {
        Self(RefCell::new(self.0.take()))
    }

    /// What the target `name`, or a view of some mips or layers of it, holds, if a pass said so.
    pub fn of(&self, name: &str) -> Option<Texels> {
        let is_of = |known: &str| {
            name.strip_prefix(known)
                .is_some_and(|view| view.is_empty() || view.starts_with(".mip") || view.starts_with(".layer"))
        };
        self.0.borrow().iter().find(|(known, _)| is_of(known)).map(|(_, texels)| *texels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_hold_what_their_texture_does_and_other_names_do_not() {
        let all = TargetTexels::default();
        all.add("occlusion", Texels::Share);
        all.add("occlusion.look.next", Texels::Distance);
        assert_eq!(all.of("occlusion"), Some(Texels::Share));
        assert_eq!(all.of("occlusion.mip2"), Some(Texels::Share));
        assert_eq!(all.of("occlusion.mips1-3"), Some(Texels::Share));
        assert_eq!(all.of("occlusion.layer1"), Some(Texels::Share));
        assert_eq!(all.of("occlusion.look.next"), Some(Texels::Distance));
        assert_eq!((all.of("occlusion.blur"), all.of("mirror/occlusion")), (None, None));
        assert_eq!((all.take().of("occlusion"), all.of("occlusion")), (Some(Texels::Share), None));
    }
}
