//! What the pass is given: it stands apart from where that comes from, so that the pass imports no settings.

/// An overlay that can be drawn over one picture.
#[derive(Clone, Debug)]
pub struct OverlayDraw {
    /// Six texels a rectangle.
    pub(crate) quads: wgpu::TextureView,
    pub(crate) atlas: wgpu::TextureView,
    /// Width and height of the atlas in texels.
    pub(crate) atlas_side: [u32; 2],
    /// Rectangles that follow each other, in the order in which they are drawn.
    pub(crate) runs: Vec<OverlayRun>,
    /// Whether depth is compared.
    pub(crate) tests_depth: bool,
}

/// Rectangles that show one texture.
#[derive(Clone, Debug)]
pub struct OverlayRun {
    pub(crate) first: u32,
    pub(crate) count: u32,
    /// What a monitor shows; none for those that show the atlas.
    pub(crate) monitor: Option<wgpu::TextureView>,
}

impl OverlayRun {
    /// Those of `count` rectangles, of which `monitors` show each a texture of their own; those whose texture is not there
    /// are left out.
    pub(crate) fn all(count: u32, monitors: &[(u32, Option<wgpu::TextureView>)]) -> Vec<Self> {
        let mut runs = Vec::new();
        let mut next = 0;
        let of_atlas = |from: u32, to: u32, runs: &mut Vec<Self>| {
            if to > from {
                runs.push(Self { first: from, count: to - from, monitor: None });
            }
        };
        for (first, texture) in monitors {
            of_atlas(next, *first, &mut runs);
            runs.extend(texture.clone().map(|texture| Self { first: *first, count: 1, monitor: Some(texture) }));
            next = first + 1;
        }
        of_atlas(next, count, &mut runs);
        runs
    }
}
