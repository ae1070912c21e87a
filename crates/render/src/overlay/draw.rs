//! What the pass is given: it stands apart from where that comes from, so that the pass imports no settings.

/// An overlay that can be drawn over one picture.
#[derive(Clone, Debug)]
pub struct OverlayDraw {
    /// Six texels a rectangle.
    pub(crate) quads: wgpu::TextureView,
    pub(crate) atlas: wgpu::TextureView,
    /// Width and height of the atlas in texels.
    pub(crate) atlas_side: [u32; 2],
    pub(crate) quad_count: u32,
    /// Whether depth is compared.
    pub(crate) tests_depth: bool,
}
