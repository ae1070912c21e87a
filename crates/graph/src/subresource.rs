//! Ranges of mips and layers.

use std::ops::Range;

use serde::Serialize;

use crate::TextureDesc;

/// Mips `mip..mip + mips` of layers `layer..layer + layers` of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct SubresourceRange {
    /// The first mip level.
    pub mip: u32,
    /// How many mip levels.
    pub mips: u32,
    /// The first array layer.
    pub layer: u32,
    /// How many array layers.
    pub layers: u32,
}

impl SubresourceRange {
    /// All of a texture.
    pub(crate) fn whole(desc: &TextureDesc) -> Self {
        Self { mip: 0, mips: desc.mips, layer: 0, layers: desc.layers }
    }

    /// A part of this part; `None` if it is empty or not within.
    pub(crate) fn inner(self, mips: &Range<u32>, layers: &Range<u32>) -> Option<Self> {
        let fits = |range: &Range<u32>, count: u32| range.start < range.end && range.end <= count;
        (fits(mips, self.mips) && fits(layers, self.layers)).then(|| Self {
            mip: self.mip + mips.start,
            mips: mips.end - mips.start,
            layer: self.layer + layers.start,
            layers: layers.end - layers.start,
        })
    }

    /// Places of its subresources within the texture, in the order of [`TextureDesc::subresources`].
    pub(crate) fn subresources(self, desc: &TextureDesc) -> impl Iterator<Item = u32> + use<> {
        let row = desc.mips;
        (self.layer..self.layer + self.layers)
            .flat_map(move |layer| (self.mip..self.mip + self.mips).map(move |mip| layer * row + mip))
    }

    pub(crate) fn overlaps(self, other: Self) -> bool {
        let meet = |a: u32, a_count: u32, b: u32, b_count: u32| a < b + b_count && b < a + a_count;
        meet(self.mip, self.mips, other.mip, other.mips) && meet(self.layer, self.layers, other.layer, other.layers)
    }

    /// Whether it is one mip of one layer, as an attachment must be.
    pub(crate) fn is_one(self) -> bool {
        self.mips == 1 && self.layers == 1
    }

    /// The shape of the part, with its first mip as mip 0.
    pub(crate) fn desc(self, whole: &TextureDesc) -> TextureDesc {
        TextureDesc { layers: self.layers, mips: self.mips, ..whole.of_mip(self.mip) }
    }

    /// What distinguishes its name from that of the whole texture.
    pub(crate) fn suffix(self, whole: &TextureDesc) -> String {
        let range = |what: &str, first: u32, count: u32, of: u32| match count {
            _ if count == of => String::new(),
            1 => format!(".{what}{first}"),
            _ => format!(".{what}s{first}-{}", (first + count).saturating_sub(1)),
        };
        let layers = range("layer", self.layer, self.layers, whole.layers);
        layers + &range("mip", self.mip, self.mips, whole.mips)
    }
}
