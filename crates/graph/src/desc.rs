//! What a texture is, and what an adapter allows.

use serde::{Serialize, Serializer};

/// The shape of a texture. Textures with equal descriptors can share memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct TextureDesc {
    /// Width of mip 0 in texels.
    pub width: u32,
    /// Height of mip 0 in texels.
    pub height: u32,
    /// Number of array layers; 6 for a cube map.
    pub layers: u32,
    /// Number of mip levels.
    pub mips: u32,
    /// Samples per texel; 1 without multisampling.
    pub samples: u32,
    /// Format of the texels. Serialised as wgpu's name of it.
    #[serde(serialize_with = "format_name")]
    pub format: wgpu::TextureFormat,
}

fn format_name<S: Serializer>(format: &wgpu::TextureFormat, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{format:?}"))
}

impl TextureDesc {
    /// One layer, one mip, one sample.
    pub const fn new_2d(width: u32, height: u32, format: wgpu::TextureFormat) -> Self {
        Self { width, height, layers: 1, mips: 1, samples: 1, format }
    }

    /// The descriptor of one layer of one mip.
    #[must_use]
    pub fn of_mip(&self, mip: u32) -> Self {
        let halve = |extent: u32| extent.checked_shr(mip).unwrap_or(0).max(1);
        Self { width: halve(self.width), height: halve(self.height), layers: 1, mips: 1, ..*self }
    }

    /// Memory of all mips, layers and samples. Depth formats whose size is up to
    /// the driver count as the largest common one (`Depth32FloatStencil8`: 8).
    pub fn bytes(&self) -> u64 {
        use wgpu::TextureFormat as F;
        let texel_bytes = match self.format {
            F::Depth24Plus | F::Depth24PlusStencil8 => 4,
            F::Depth32FloatStencil8 => 8,
            other => other.block_copy_size(None).unwrap_or(16),
        };
        let (block_width, block_height) = self.format.block_dimensions();
        let levels = (0..self.mips.min(32)).map(|mip| self.of_mip(mip));
        let blocks_of =
            |level: Self| u64::from(level.width.div_ceil(block_width)) * u64::from(level.height.div_ceil(block_height));
        // A shape that no adapter has is refused by the plan, and may have more bytes than a number.
        let blocks = levels.map(blocks_of).fold(0, u64::saturating_add);
        let counts = [self.layers, self.samples, texel_bytes];
        counts.into_iter().fold(blocks, |bytes, count| bytes.saturating_mul(u64::from(count)))
    }

    pub(crate) fn has_depth(&self) -> bool {
        self.format.has_depth_aspect()
    }

    /// Subresources are counted layer by layer: `layer * mips + mip`.
    pub(crate) fn subresources(&self) -> u32 {
        self.layers.saturating_mul(self.mips)
    }

    pub(crate) fn max_mips(&self) -> u32 {
        self.width.max(self.height).max(1).ilog2() + 1
    }
}

/// What planning checks against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Colour targets of one pass.
    pub max_color_attachments: u32,
    /// Bytes per sample of all colour targets of one pass, counted by WebGPU's
    /// rules (`Rgba8Unorm` counts 8).
    pub max_color_bytes_per_sample: u32,
    /// Largest width and height in texels.
    pub max_texture_size: u32,
    /// Whether a pass may sample the depth that it is attached to read-only; on OpenGL and WebGL 2 that is feedback.
    pub samples_attached_depth: bool,
}

impl Limits {
    /// What every WebGL 2 adapter offers.
    pub const WEBGL2: Self = Self {
        max_color_attachments: 4,
        max_color_bytes_per_sample: 32,
        max_texture_size: 2048,
        samples_attached_depth: false,
    };
}

impl From<&wgpu::Limits> for Limits {
    fn from(limits: &wgpu::Limits) -> Self {
        Self {
            max_color_attachments: limits.max_color_attachments,
            max_color_bytes_per_sample: limits.max_color_attachment_bytes_per_sample,
            max_texture_size: limits.max_texture_dimension_2d,
            // Not a limit of `wgpu`'s: who knows the backend says so.
            samples_attached_depth: false,
        }
    }
}
