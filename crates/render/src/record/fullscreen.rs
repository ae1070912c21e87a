//! Passes that draw one triangle over all of a target.

use super::bind_groups::Resource;
use super::uniforms::Uniform;
use super::{Frame, PreparedView};
use crate::lights::Rectangle;
use crate::shader::Program;
use crate::shader::cache::{DepthTest, FullscreenPipeline, FullscreenTarget, SETTLED_BIT, StencilUse};
use crate::shader::program::{Constant, ProgramError};
use bytemuck::Pod;
use manypass_graph::{ColorLoad, DepthLoad, Handle, Pass, PassContext, ReadKey, TextureDesc};
use std::borrow::Cow;
use std::sync::Arc;

/// Adds colour to the target and leaves its alpha, the coverage, alone (the source's alpha is 0).
pub const ADD: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: component, alpha: component }
};

/// A part of the picture, selected by depth and stencil tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PicturePart {
    /// Where there is an opaque or masked surface.
    Surfaces,
    /// Where there is none.
    Background,
    /// Where samples are still added to the picture; everywhere in frames that leave nothing out.
    Unsettled,
    /// Where there is a surface that samples are still added to.
    Lit,
}

/// Which pipeline draws.
pub(super) enum Shading {
    /// A program of the renderer's, with the axes that are on.
    Program(&'static str, Vec<&'static str>),
    /// One from elsewhere, with a bind group of its own as group 2.
    Own(Arc<FullscreenPipeline>, Option<wgpu::BindGroup>),
}

enum Binding {
    Read(ReadKey),
    Uniform(Uniform),
    Table(wgpu::TextureView),
}

/// The declaration of a full-screen pass: its bindings of group 1 by WGSL name, and its targets.
#[must_use = "nothing is drawn before `draw_into`"]
pub struct Fullscreen<'r, 'f> {
    pub(super) pass: Pass<'r, 'f>,
    pub(super) frame: &'f Frame<'f>,
    pub(super) view: &'f PreparedView,
    pub(super) shading: Shading,
    bindings: Vec<(Cow<'static, str>, Binding)>,
    pub(super) blend: Option<wgpu::BlendState>,
    depth: Option<DepthTest>,
    /// Whether nothing is drawn where tiles are settled.
    leaves_out: bool,
    rectangles: Option<Vec<Rectangle>>,
    /// How many pixels a texel has along a side, if nothing is drawn beside surfaces.
    surfaces_side_px: Option<u32>,
    constants: Vec<Constant>,
    /// Vertices and instances.
    elements: (u32, u32),
    /// Whether the vertex stage places them in the whole target, whatever rectangles are drawn into.
    is_placed_in_target: bool,
}

impl<'r, 'f> Fullscreen<'r, 'f> {
    pub(super) fn new(pass: Pass<'r, 'f>, frame: &'f Frame<'f>, view: &'f PreparedView, shading: Shading) -> Self {
        Self {
            pass,
            frame,
            view,
            shading,
            bindings: Vec::new(),
            blend: None,
            depth: None,
            leaves_out: false,
            rectangles: None,
            surfaces_side_px: None,
            constants: Vec::new(),
            elements: (3, 1),
            is_placed_in_target: false,
        }
    }

    /// The view that it belongs to.
    pub fn view(&self) -> &'f PreparedView {
        self.view
    }

    /// The shader reads `handle` under `name`.
    pub fn read(mut self, name: impl Into<Cow<'static, str>>, handle: &Handle) -> Self {
        let read = self.pass.read(handle);
        self.bindings.push((name.into(), Binding::Read(read)));
        self
    }

    /// The shader reads `handle` under `name` as a texture of another dimension, such as a cube.
    pub fn read_as(mut self, name: &'static str, handle: &Handle, dimension: wgpu::TextureViewDimension) -> Self {
        let read = self.pass.read_as(handle, dimension);
        self.bindings.push((name.into(), Binding::Read(read)));
        self
    }

    /// The shader's `override` constant `name` is `value`: branches that depend on it alone are gone when it runs.
    pub fn constant(mut self, name: &'static str, value: u32) -> Self {
        self.constants.push((name, value));
        self
    }

    /// As [`Self::constant`], of several.
    pub fn constants(mut self, constants: &[Constant]) -> Self {
        self.constants.extend(constants);
        self
    }

    /// The shader reads the depth of `handle` under `name`.
    pub fn read_depth(mut self, name: &'static str, handle: &Handle) -> Self {
        let read = self.pass.read_depth(handle);
        self.bindings.push((name.into(), Binding::Read(read)));
        self
    }

    /// The shader finds `value` in the uniform `name`.
    pub fn uniform<T: Pod>(mut self, name: &'static str, value: &T) -> Self {
        self.bindings.push((name.into(), Binding::Uniform(self.frame.uniforms.push(value))));
        self
    }

    /// The shader finds the table `texture`, which is no part of the graph, under `name`.
    pub fn table(mut self, name: impl Into<Cow<'static, str>>, texture: &wgpu::TextureView) -> Self {
        self.bindings.push((name.into(), Binding::Table(texture.clone())));
        self
    }

    /// The shader's constants keep it from looking at its texture `name`, but something has to be bound: a white texel.
    pub fn stand_in(self, name: &'static str) -> Self {
        let white = self.frame.resources.textures.white();
        self.table(name, white)
    }

    /// How what is drawn and what is there become one; without it what is drawn replaces it.
    pub fn blend(mut self, blend: wgpu::BlendState) -> Self {
        self.blend = Some(blend);
        self
    }

    /// Draws over the pixels that `part` means alone; the others cost nothing. `depth` is attached, read-only.
    pub fn over(mut self, part: PicturePart, depth: &Handle) -> Self {
        // Depth is reversed and cleared to 0. What is settled is nearest of all, so that it is no background; what is
        // lit is told alike in all samples of a still, because a large shader's pipeline takes long to make.
        let (compare, stencil) = match part {
            PicturePart::Surfaces => (wgpu::CompareFunction::Less, StencilUse::Ignored),
            PicturePart::Background => (wgpu::CompareFunction::GreaterEqual, StencilUse::Ignored),
            PicturePart::Unsettled => (wgpu::CompareFunction::Always, StencilUse::Unsettled),
            PicturePart::Lit => (wgpu::CompareFunction::Less, StencilUse::Unsettled),
        };
        self.pass.depth_stencil_read_only(depth);
        self.depth = Some(DepthTest { format: depth.desc().format, compare, writes: false, stencil });
        self.leave_out_settled()
    }

    /// What is drawn where tiles of a still are settled means nothing: it is left out as far as that is known.
    pub fn leave_out_settled(mut self) -> Self {
        self.leaves_out = true;
        self
    }

    /// Draws within a rectangle around the view's surfaces alone, and texels of the target have `side_px` pixels along a
    /// side. What the target is cleared to has to be what the shader gives where there is no surface.
    pub fn within_surfaces(mut self, side_px: u32) -> Self {
        self.surfaces_side_px = Some(side_px);
        self
    }

    /// Draws `count` quads in place of the triangle, as instances of six vertices, which the program's own vertex stage
    /// places.
    pub fn quads(mut self, count: u32) -> Self {
        self.elements = (6, count);
        self
    }

    /// As [`Self::quads`], of tiles of the target, of which the vertex stage leaves out some (`drawn_tiles.wgsl`).
    pub fn tiles(mut self, count: u32) -> Self {
        self.is_placed_in_target = true;
        self.quads(count)
    }

    /// Draws `count` triangles in its place, which the program's own vertex stage places.
    pub fn triangles(mut self, count: u32) -> Self {
        self.elements = (count.saturating_mul(3), 1);
        self
    }

    /// Draws into a rectangle alone: x and y of its corner, width and height, in texels.
    pub fn within(self, rectangle: [u32; 4]) -> Self {
        self.within_each(&[rectangle])
    }

    /// Draws into each of `rectangles` alone, which do not overlap.
    pub fn within_each(mut self, rectangles: &[[u32; 4]]) -> Self {
        self.rectangles = Some(rectangles.to_vec());
        self
    }

    /// Declares the pass. Returns the version of `target` that holds the result.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    pub fn draw_into(mut self, target: Handle, load: ColorLoad) -> Result<Handle, ProgramError> {
        let desc = target.desc();
        let target = self.pass.color(target, load);
        self.draw(Some(desc.format), desc)?;
        Ok(target)
    }

    /// Declares the pass, which draws where what it draws is nearer than `depth`, and replaces that. Returns the versions
    /// of `target` and `depth` that hold the result.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    pub fn draw_nearer_into(
        mut self,
        target: Handle,
        load: ColorLoad,
        depth: Handle,
    ) -> Result<(Handle, Handle), ProgramError> {
        let (desc, format) = (target.desc(), depth.desc().format);
        let target = self.pass.color(target, load);
        let depth = self.pass.depth_stencil(depth, DepthLoad::Keep);
        let compare = wgpu::CompareFunction::Greater;
        self.depth = Some(DepthTest { format, compare, writes: true, stencil: StencilUse::Ignored });
        self.draw(Some(desc.format), desc)?;
        Ok((target, depth))
    }

    /// Declares the pass: depth is that of the near plane, and the stencil says that it is settled; but wherever the
    /// shader discards nothing, depth is that of the far plane, and nothing is settled. Returns the version of `depth`
    /// that holds the result.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    pub fn draw_unsettled_into(mut self, depth: Handle) -> Result<Handle, ProgramError> {
        let desc = depth.desc();
        let depth = self.pass.depth_stencil(depth, DepthLoad::Clear { depth: 1.0, stencil: SETTLED_BIT });
        let compare = wgpu::CompareFunction::Always;
        self.depth = Some(DepthTest { format: desc.format, compare, writes: true, stencil: StencilUse::Unsettles });
        self.draw(None, desc)?;
        Ok(depth)
    }

    /// Declares the pass, which draws into textures of the shape `desc`, and into colours of `format`.
    fn draw(self, format: Option<wgpu::TextureFormat>, desc: TextureDesc) -> Result<(), ProgramError> {
        if !is_drawable(format.as_slice(), self.depth.map(|depth| depth.format), desc.samples) {
            return Ok(());
        }
        let (pipeline, own) = match &self.shading {
            Shading::Program(name, axes) => {
                let samples = desc.samples;
                let target = FullscreenTarget { format, samples, blend: self.blend, depth: self.depth };
                let constants = [&self.constants[..], &self.view.constants].concat();
                (self.frame.shaders.fullscreen(name, axes, target, &constants)?, None)
            }
            Shading::Own(pipeline, own) => (pipeline.clone(), own.clone()),
        };
        let program = pipeline.program.clone();
        let slots = self.slots(&program)?;
        let rectangles = self.drawn_rectangles(desc);
        let Self { mut pass, frame, view, elements: (vertices, instances), is_placed_in_target, .. } = self;
        pass.count_draws(rectangles.as_ref().map_or(1, Vec::len));
        pass.draw(move |context| {
            let resources: Option<Vec<_>> = slots.into_iter().map(|slot| slot.resource(context)).collect();
            let Some(resources) = resources else { return };
            let group = frame.bind_groups.of_program(context.device, &program, 1, resources);
            let render_pass = &mut *context.render_pass;
            render_pass.set_pipeline(&pipeline.pipeline);
            render_pass.set_bind_group(0, &view.group, &[]);
            if let Some(group) = &group {
                render_pass.set_bind_group(1, group, &[]);
            }
            if let Some(own) = &own {
                render_pass.set_bind_group(2, own, &[]);
            }
            let Some(rectangles) = rectangles else { return render_pass.draw(0..vertices, 0..instances) };
            for [x, y, width, height] in rectangles {
                if !is_placed_in_target {
                    render_pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
                }
                render_pass.set_scissor_rect(x, y, width, height);
                render_pass.draw(0..vertices, 0..instances);
            }
        });
        Ok(())
    }

    /// The rectangles of a target of the shape `desc` that are drawn into; none where that is all of it.
    fn drawn_rectangles(&self, desc: TextureDesc) -> Option<Vec<Rectangle>> {
        let whole = [[0, 0, desc.width, desc.height]];
        let unsettled = self.view.unsettled.as_deref().filter(|_| self.leaves_out);
        let around_surfaces = self.surface_texels().map(|rectangle| [rectangle]);
        let limits = unsettled.into_iter().chain(around_surfaces.as_ref().map(<[_; 1]>::as_slice));
        limits.fold(self.rectangles.clone(), |rectangles, limit| {
            Some(intersections(rectangles.as_deref().unwrap_or(&whole), limit))
        })
    }

    /// The rectangle of the target around surfaces, if nothing is drawn beside them and it is not all of the target.
    fn surface_texels(&self) -> Option<Rectangle> {
        let side_px = self.surfaces_side_px?;
        let [x, y, width, height] = self.view.surfaces(self.frame.world)?;
        let (left, top) = (x / side_px, y / side_px);
        let (right, bottom) = ((x + width).div_ceil(side_px), (y + height).div_ceil(side_px));
        Some([left, top, right - left, bottom - top])
    }

    /// What goes into group 1 of `program`. Names are looked up now; when the pass runs, only the views of what it
    /// reads are still to come.
    pub(super) fn slots(&self, program: &Program) -> Result<Vec<Slot>, ProgramError> {
        let known = || {
            let names = self.bindings.iter().map(|(name, _)| &**name);
            names.chain(["linear_clamp", "linear_repeat", "nearest_clamp"]).collect::<Vec<_>>().join(", ")
        };
        let slots = program.slots(1).iter().map(|slot| {
            let found = self.bindings.iter().find(|(name, _)| *name == slot.name).map(|(_, binding)| match binding {
                Binding::Read(read) => Slot::Read(*read),
                Binding::Uniform(uniform) => Slot::Ready(Resource::Uniform(uniform.clone())),
                Binding::Table(texture) => Slot::Ready(Resource::Texture(texture.clone())),
            });
            let sampler = || Some(Slot::Ready(Resource::Sampler(self.frame.tables.sampler(&slot.name)?)));
            found.or_else(sampler).ok_or_else(|| slot.unbound(program, 1, known()))
        });
        slots.collect()
    }
}

/// What goes into a slot of group 1.
pub(super) enum Slot {
    Read(ReadKey),
    Ready(Resource),
}

impl Slot {
    /// What it is when the pass runs; nothing if that has not declared it, which is an error of the frame.
    pub fn resource(self, context: &PassContext<'_, '_>) -> Option<Resource> {
        match self {
            Self::Read(read) => context.view(read).cloned().map(Resource::Texture),
            Self::Ready(resource) => Some(resource),
        }
    }
}

/// Whether pipelines can draw into targets of these formats, of so many samples a texel. Where they cannot, the plan
/// refuses the pass, and none is made: the device would refuse it in a later frame.
pub(super) fn is_drawable(colors: &[wgpu::TextureFormat], depth: Option<wgpu::TextureFormat>, samples: u32) -> bool {
    let is_color =
        |format: &wgpu::TextureFormat| !format.is_depth_stencil_format() && format.target_pixel_byte_cost().is_some();
    let is_depth = depth.is_none_or(|format| format.is_depth_stencil_format());
    is_depth && colors.iter().all(is_color) && matches!(samples, 1 | 2 | 4 | 8 | 16)
}

/// What each of some rectangles has in common with each of others.
fn intersections(rectangles: &[Rectangle], others: &[Rectangle]) -> Vec<Rectangle> {
    let with_each = |of: Rectangle| others.iter().filter_map(move |other| intersection(of, *other));
    rectangles.iter().copied().flat_map(with_each).collect()
}

/// What two rectangles have in common, if anything.
fn intersection(a: Rectangle, b: Rectangle) -> Option<Rectangle> {
    let low = [a[0].max(b[0]), a[1].max(b[1])];
    let ends = |[x, y, width, height]: Rectangle| [x.saturating_add(width), y.saturating_add(height)];
    let [[a_x, a_y], [b_x, b_y]] = [ends(a), ends(b)];
    let high = [a_x.min(b_x), a_y.min(b_y)];
    (low[0] < high[0] && low[1] < high[1]).then(|| [low[0], low[1], high[0] - low[0], high[1] - low[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_two_rectangles_have_in_common() {
        assert_eq!(intersection([0, 0, 10, 10], [5, 6, 10, 2]), Some([5, 6, 5, 2]));
        assert_eq!(intersection([0, 0, 10, 10], [10, 0, 1, 1]), None);
        assert_eq!(intersection([5, 0, u32::MAX, 10], [0, 0, 10, 10]), Some([5, 0, 5, 10]));
        let of_two = intersections(&[[0, 0, 4, 4], [8, 0, 4, 4]], &[[2, 1, 8, 2], [20, 0, 1, 1]]);
        assert_eq!(of_two, [[2, 1, 2, 2], [8, 1, 2, 2]]);
        assert!(intersections(&[[0, 0, 4, 4]], &[[0, 0, 0, 0]]).is_empty());
    }
}
