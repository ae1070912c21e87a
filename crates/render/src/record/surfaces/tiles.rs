//! Passes that draw the world many times over, each time into another part of one depth texture.

use super::encode::encode;
use super::pipelines::Targets;
use super::prepared::{BoundShapes, Chunk, PassDraws};
use super::{DecalUse, DrawSelection};
use crate::draws::Tile;
use crate::record::fullscreen::is_drawable;
use crate::record::{Frame, PreparedView};
use crate::shader::program::ProgramError;
use manypass_graph::{DepthLoad, Handle, Pass};

/// A pass of tiles that is being declared.
#[must_use = "nothing is drawn before `draw_into`"]
pub struct TilePass<'r, 'f> {
    pass: Pass<'r, 'f>,
    frame: &'f Frame<'f>,
    view: &'f PreparedView,
    program: &'static str,
}

impl<'r, 'f> TilePass<'r, 'f> {
    pub(in crate::record) fn new(
        pass: Pass<'r, 'f>,
        frame: &'f Frame<'f>,
        view: &'f PreparedView,
        program: &'static str,
    ) -> Self {
        Self { pass, frame, view, program }
    }

    /// Declares the pass: it draws `tiles`, each over a background of depth 0, and leaves the rest of `target` alone,
    /// or with `is_first` clears it. Returns the version of `target` that holds the result.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    pub(crate) fn draw_into(self, target: Handle, is_first: bool, tiles: &[Tile]) -> Result<Handle, ProgramError> {
        let Self { mut pass, frame, view, program } = self;
        let format = target.desc().format;
        let targets = Targets {
            colors: Vec::new(),
            blend: None,
            depth: format,
            samples: 1,
            depth_write: true,
            constants: view.constants_of(program),
            vertices_alone: false,
            marked: false,
            backs: false,
        };
        if !is_drawable(&[], Some(format), target.desc().samples) {
            return Ok(pass.depth_stencil(target, DepthLoad::Keep));
        }
        let clear = if is_first { None } else { Some(frame.shaders.depth_clear(format)?) };
        let preparing = PassDraws {
            frame,
            view,
            program,
            targets: &targets,
            of_pass: &[],
            pass_axes: &[],
            casts: true,
            decals: DecalUse::LeftOut,
            clouds: None,
        };
        let mut shapes = BoundShapes::default();
        let prepare =
            |tile: &Tile| Ok((tile.rectangle, preparing.prepare(&tile.draws, DrawSelection::All, &mut shapes)?));
        let prepared: Vec<([u32; 4], Vec<Chunk>)> = tiles.iter().map(prepare).collect::<Result<_, ProgramError>>()?;
        let load = if is_first { DepthLoad::Clear { depth: 0.0, stencil: 0 } } else { DepthLoad::Keep };
        let target = pass.depth_stencil(target, load);
        let clears = if clear.is_some() { prepared.len() } else { 0 };
        let draws: usize = prepared.iter().flat_map(|(_, chunks)| chunks).map(Chunk::draws).sum();
        pass.count_draws(clears + draws);
        pass.draw(move |context| {
            let render_pass = &mut *context.render_pass;
            for ([x, y, width, height], chunks) in &prepared {
                render_pass.set_viewport(*x as f32, *y as f32, *width as f32, *height as f32, 0.0, 1.0);
                render_pass.set_scissor_rect(*x, *y, *width, *height);
                if let Some(clear) = &clear {
                    render_pass.set_pipeline(clear);
                    render_pass.set_bind_group(0, &view.group, &[]);
                    render_pass.draw(0..3, 0..1);
                }
                chunks.iter().for_each(|chunk| encode(chunk, render_pass, frame, view));
            }
        });
        Ok(target)
    }
}
