//! At which size a pass works that the picture needs no full one of.

use crate::record::PreparedView;
use crate::setting::choices;
use manypass_graph::TextureDesc;

choices! {
    /// The size at which a pass works, relative to the picture.
    pub enum Resolution {
        /// A texel for each pixel.
        Full = "full",
        /// One for 2 × 2 pixels.
        #[default]
        Half = "half",
        /// One for 4 × 4 pixels.
        Quarter = "quarter",
    }
}

impl Resolution {
    /// How many pixels a texel has along a side, as `shaders/coarse.wgsl` takes it.
    pub fn side_px(self) -> u32 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
            Self::Quarter => 4,
        }
    }

    /// A texture of `view` at this size.
    pub fn desc(self, view: &PreparedView, format: wgpu::TextureFormat) -> TextureDesc {
        let side = self.side_px();
        TextureDesc::new_2d(view.size.0.div_ceil(side), view.size.1.div_ceil(side), format)
    }
}
