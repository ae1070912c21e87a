//! present: the finished picture, drawn over what a target of the caller's holds.
//!
//! Source: Porter & Duff 1984, "over". Reads: display. Writes: the target, within a rectangle. The picture's alpha
//! blends it with what the target held: in linear light where the target's format is sRGB, else in display colours.

use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("present");

/// A render target of the caller: the texture to which a picture is drawn.
#[derive(Clone, Debug)]
pub struct Target {
    /// A view of one mip and layer.
    pub texture_view: wgpu::TextureView,
    /// Its format: 8-bit, sRGB or not, or half floats.
    pub format: wgpu::TextureFormat,
    /// Its width in texels.
    pub width: u32,
    /// Its height in texels.
    pub height: u32,
    /// Where in it the picture goes: x and y of the corner, from the top left, then width and height, in texels.
    /// Outside of it nothing changes. A picture of another size is filtered linearly.
    pub rectangle: [u32; 4],
}

impl Target {
    /// All of a texture's first mip and layer, such as that of a window's surface. It needs the usage
    /// `RENDER_ATTACHMENT`.
    pub fn whole(texture: &wgpu::Texture) -> Self {
        let (width, height) = (texture.width(), texture.height());
        let texture_view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            mip_level_count: Some(1),
            array_layer_count: Some(1),
            ..Default::default()
        });
        Self { texture_view, format: texture.format(), width, height, rectangle: [0, 0, width, height] }
    }

    /// Why the target cannot be drawn to, if so.
    pub(crate) fn fault(&self) -> Option<String> {
        let [x, y, width, height] = self.rectangle;
        let fits = |start: u32, length: u32, limit: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= limit)
        };
        if !fits(x, width, self.width) || !fits(y, height, self.height) {
            let (w, h) = (self.width, self.height);
            return Some(format!(
                "the rectangle {width} × {height} at ({x}, {y}) does not lie in its {w} × {h} texels"
            ));
        }
        use wgpu::TextureFormat as F;
        let blends = [F::Rgba8Unorm, F::Rgba8UnormSrgb, F::Bgra8Unorm, F::Bgra8UnormSrgb, F::Rgba16Float];
        (!blends.contains(&self.format)).then(|| format!("its format {:?} is not among {blends:?}", self.format))
    }
}

/// The uniform of `present.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct PresentUniform {
    /// The corner of the rectangle in the target.
    offset_px: [f32; 2],
    /// 1 / width and height of the rectangle.
    inverse_size_px: [f32; 2],
}

impl PresentUniform {
    /// For the rectangle of `target`.
    fn new(target: &Target) -> Self {
        let [x, y, width, height] = target.rectangle.map(|texels| texels as f32);
        Self { offset_px: [x, y], inverse_size_px: [1.0 / width, 1.0 / height] }
    }
}

/// Colour times alpha over what is there.
const OVER: wgpu::BlendState = wgpu::BlendState::ALPHA_BLENDING;

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, display: &Handle, target: &Target) -> Result<(), ProgramError> {
    let desc = TextureDesc::new_2d(target.width, target.height, target.format);
    let imported = r.graph.import("target", desc, target.texture_view.clone());
    let step = r
        .fullscreen("present", "present", &[])
        .constant("srgb_target", u32::from(target.format.is_srgb()))
        .blend(OVER)
        .within(target.rectangle);
    let step = step.uniform("present", &PresentUniform::new(target)).read("display", display);
    let output = step.draw_into(imported, ColorLoad::Keep)?;
    r.graph.export(output);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("present", "Present", PresentUniform, [offset_px, inverse_size_px]);
    }
}
