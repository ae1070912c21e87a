//! Passes that draw the scene's surfaces.

mod bundles;
mod encode;
mod pipelines;
mod prepared;
mod shape;
mod tiles;

pub(crate) use bundles::Bundles;
pub(crate) use pipelines::SurfacePipelines;
pub use tiles::TilePass;

use super::bind_groups::Resource;
use super::fullscreen::is_drawable;
use super::{Frame, PreparedView};
use crate::draws::{Draw, WorldDraws, faded_id, object_id};
use crate::resources::layers::SHADED_WHERE_DRAWN;
use crate::shader::program::ProgramError;
use bundles::PassKey;
use bytemuck::Pod;
use encode::encode;
use manypass_graph::{ColorLoad, DepthLoad, Handle, Pass, ReadKey, TextureDesc};
use pipelines::Targets;
use prepared::{BoundShapes, Chunk, PassDraws};
use std::borrow::Cow;

/// The surfaces of the draw list that a pass draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawSelection {
    /// Every one.
    All,
    /// Those whose fragments are never dropped and lie where their triangles do: triangles without a mask and without
    /// relief.
    Hiding,
    /// Those whose materials have more than the G-buffer holds.
    ShadedWhereDrawn,
    /// Those whose materials have layers or detail.
    Layered,
    /// Those whose materials have neither.
    Plain,
}

/// The use of decals in a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DecalUse {
    /// What they may touch shows them.
    #[default]
    Shown,
    /// Nothing does.
    LeftOut,
    /// All that is drawn shows them, where pixels are marked for them.
    Marked,
}

/// The declaration of a pass that draws surfaces: its targets, and its bindings of group 1 by WGSL name.
#[must_use = "nothing is drawn before `draw`"]
pub struct SurfacePass<'r, 'f> {
    name: Cow<'static, str>,
    pass: Pass<'r, 'f>,
    frame: &'f Frame<'f>,
    view: &'f PreparedView,
    program: &'static str,
    resources: Vec<(&'static str, Resource)>,
    reads: Vec<(&'static str, ReadKey)>,
    axes: Vec<&'static str>,
    colors: Vec<wgpu::TextureFormat>,
    blend: Option<wgpu::BlendState>,
    depth: Option<(TextureDesc, bool)>,
    constants: Vec<(&'static str, u32)>,
    vertices_alone: bool,
    backs: bool,
    decals: DecalUse,
    leaves_out: bool,
}

impl<'r, 'f> SurfacePass<'r, 'f> {
    pub(super) fn new(
        (name, pass): (Cow<'static, str>, Pass<'r, 'f>),
        frame: &'f Frame<'f>,
        view: &'f PreparedView,
        program: &'static str,
    ) -> Self {
        Self {
            name,
            pass,
            frame,
            view,
            program,
            resources: Vec::new(),
            reads: Vec::new(),
            axes: Vec::new(),
            colors: Vec::new(),
            blend: None,
            depth: None,
            constants: Vec::new(),
            vertices_alone: false,
            backs: false,
            decals: DecalUse::default(),
            leaves_out: false,
        }
    }

    /// The next colour target. Without one no fragment is shaded. Returns the version that holds the result.
    pub fn color(&mut self, target: Handle, load: ColorLoad) -> Handle {
        self.colors.push(target.desc().format);
        self.pass.color(target, load)
    }

    /// Writes depth and tests against it. Returns the version that holds the result.
    pub fn depth(&mut self, target: Handle, load: DepthLoad) -> Handle {
        self.depth = Some((target.desc(), true));
        self.pass.depth_stencil(target, load)
    }

    /// Tests against depth; what lies at the same depth passes.
    pub fn depth_read_only(&mut self, depth: &Handle) {
        self.depth = Some((depth.desc(), false));
        self.pass.depth_stencil_read_only(depth);
    }

    /// The same blend state for all targets, because the floor has one.
    pub fn blend(&mut self, blend: wgpu::BlendState) {
        self.blend = Some(blend);
    }

    /// What is done about decals.
    pub fn decals(&mut self, decals: DecalUse) {
        self.decals = decals;
    }

    /// What is drawn where tiles of a still are settled means nothing, as its depth hides it: clouds of points are left
    /// out there as far as that is known.
    pub fn leave_out_settled(&mut self) {
        self.leaves_out = true;
    }

    /// Axes of the program that are on whatever is drawn, or constants that are 1.
    pub fn axes(&mut self, axes: &[&'static str]) {
        self.axes.extend(axes);
    }

    /// The shader finds `value` in the uniform `name`.
    pub fn uniform<T: Pod>(&mut self, name: &'static str, value: &T) {
        self.resources.push((name, Resource::Uniform(self.frame.uniforms.push(value))));
    }

    /// The shader reads `handle` under `name`.
    pub fn read(&mut self, name: &'static str, handle: &Handle) {
        let read = self.pass.read(handle);
        self.reads.push((name, read));
    }

    /// The same under each of `names`, of which every program of the pass declares its own.
    pub fn read_under(&mut self, names: &[&'static str], handle: &Handle) {
        let read = self.pass.read(handle);
        self.reads.extend(names.iter().map(|name| (*name, read)));
    }

    /// The shader's constants keep it from looking at its texture `name`, but something has to be bound: a white texel.
    pub fn stand_in(&mut self, name: &'static str) {
        self.resources.push((name, Resource::Texture(self.frame.resources.textures.white().clone())));
    }

    /// The shader's `override` constant `name` is `value`: branches that depend on it alone are gone when it runs.
    pub fn constant(&mut self, name: &'static str, value: u32) {
        self.constants.push((name, value));
    }

    /// Draws each vertex once, as a point where the shader puts it, in place of what vertices form.
    pub fn vertices(&mut self) {
        self.vertices_alone = true;
    }

    /// Draws the sides that are turned away, in place of those that are seen: of a closed body its back.
    pub fn backs(&mut self) {
        self.backs = true;
    }

    /// Declares the pass: it draws those of the view's opaque and masked surfaces that have at least `count` lights in
    /// the lists of their objects and in none.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_opaque_lit_by(self, count: u32) -> Result<(), ProgramError> {
        let (view, world) = (self.view, self.frame.world);
        let is_lit = |draw: &&Draw| view.most_lights_of(draw, world) >= count;
        let draws: Vec<Draw> = view.draws.opaque.iter().filter(is_lit).cloned().collect();
        self.draw(draws.into(), DrawSelection::All)
    }

    /// Declares the pass: it draws the view's opaque and masked surfaces.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds; or no depth was given.
    pub fn draw_opaque(self, which: DrawSelection) -> Result<(), ProgramError> {
        let draws = &self.view.draws.opaque[..];
        self.draw(draws.into(), which)
    }

    /// Declares the pass: it draws those of the view's opaque and masked surfaces that are at a level of detail.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_opaque_at(self, level: u32) -> Result<(), ProgramError> {
        let draws = at_level(&self.view.draws.opaque, level, self.frame.world);
        self.draw(draws.into(), DrawSelection::All)
    }

    /// Declares the pass: it draws those of the view's blended surfaces that are at a level of detail.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_blended_at(self, level: u32) -> Result<(), ProgramError> {
        let draws = at_level(&self.view.draws.blended, level, self.frame.world);
        self.draw(draws.into(), DrawSelection::All)
    }

    /// Declares the pass: it draws those of the view's opaque and masked surfaces that decals may touch, where pixels are
    /// marked for them.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_decaled(mut self) -> Result<(), ProgramError> {
        self.decals = DecalUse::Marked;
        let draws = &self.view.draws.decaled[..];
        self.draw(draws.into(), DrawSelection::All)
    }

    /// Declares the pass: it draws those of the view's opaque and masked surfaces that are of some objects, by their ids.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_opaque_of(self, objects: &[u32]) -> Result<(), ProgramError> {
        let world = self.frame.world;
        let is_of = |draw: &Draw, instance: u32| {
            let known = world.instances.get(instance as usize);
            known.is_some_and(|known| objects.contains(&if draw.fades { faded_id(known) } else { object_id(known) }))
        };
        let mut draws: Vec<Draw> = Vec::new();
        for draw in &self.view.draws.opaque {
            for instance in draw.instances.clone().filter(|instance| is_of(draw, *instance)) {
                draws.push(Draw { instances: instance..instance + 1, ..draw.clone() });
            }
        }
        self.draw(draws.into(), DrawSelection::All)
    }

    /// Declares the pass: it draws the view's blended surfaces, farther ones first.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_blended(self) -> Result<(), ProgramError> {
        let draws = &self.view.draws.blended[..];
        self.draw(draws.into(), DrawSelection::All)
    }

    /// Declares the pass: it draws the view's surfaces that light comes through, farther ones first.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_transmissive(self) -> Result<(), ProgramError> {
        let draws = &self.view.draws.transmissive[..];
        self.draw(draws.into(), DrawSelection::All)
    }

    /// Declares the pass: it draws some of the view's surfaces, in this order.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub(crate) fn draw_those(self, draws: &[Draw]) -> Result<(), ProgramError> {
        self.draw(draws.to_vec().into(), DrawSelection::All)
    }

    fn draw(self, draws: Cow<'f, [Draw]>, which: DrawSelection) -> Result<(), ProgramError> {
        let Self { name, mut pass, frame, view, program, resources: mut of_pass, reads, axes, .. } = self;
        let Self { colors, blend, depth, constants, vertices_alone, backs, decals, leaves_out, .. } = self;
        let constants = constants.into_iter().chain(view.constants_of(program)).collect();
        let Some((TextureDesc { format: depth, samples, .. }, depth_write)) = depth else {
            let message = "it was given no depth".into();
            return Err(ProgramError::Invalid { pass: program.into(), message });
        };
        if !is_drawable(&colors, Some(depth), samples) {
            return Ok(());
        }
        let marked = decals == DecalUse::Marked;
        let targets = Targets { colors, blend, depth, samples, depth_write, constants, vertices_alone, marked, backs };
        let clouds = match &view.clouds_left {
            Some(left) if leaves_out => left,
            _ => &view.clouds,
        };
        // Vertices that are drawn for themselves lie where no picture is.
        let clouds = (!vertices_alone).then_some(clouds);
        let prepare = move |of_pass: &[(&'static str, Resource)], targets: &Targets| {
            let preparing =
                PassDraws { frame, view, program, targets, of_pass, pass_axes: &axes, casts: false, decals, clouds };
            preparing.prepare(&draws, which, &mut BoundShapes::default())
        };
        if reads.is_empty() {
            let chunks = prepare(&of_pass, &targets)?;
            let key = PassKey { view: view.name.clone(), pass: name };
            pass.count_draws(chunks.iter().map(Chunk::draws).sum());
            pass.draw(move |context| frame.bundles.draw(context.render_pass, (frame, view), (key, targets), chunks));
            return Ok(());
        }
        // What is read is known when the pass runs; names and programs are checked now, with a texel in its place.
        let of_graph = reads.len();
        let white = || Resource::Texture(frame.resources.textures.white().clone());
        of_pass.extend(reads.iter().map(|(name, _)| (*name, white())));
        pass.count_draws(prepare(&of_pass, &targets)?.iter().map(Chunk::draws).sum());
        pass.draw(move |context| {
            of_pass.truncate(of_pass.len() - of_graph);
            for (name, read) in reads {
                let Some(view) = context.view(read) else { return };
                of_pass.push((name, Resource::Texture(view.clone())));
            }
            for chunk in prepare(&of_pass, &targets).unwrap_or_default() {
                frame.bundles.count(&chunk);
                encode(&chunk, context.render_pass, frame, view);
            }
        });
        Ok(())
    }
}

/// Whether some of the view's opaque and masked surfaces have materials with more than the G-buffer holds.
pub(super) fn shows_shaded_where_drawn(view: &PreparedView, world: &WorldDraws) -> bool {
    let is_one = |draw: &Draw| world.items[draw.item as usize].layers_in(draw.form.surface) & SHADED_WHERE_DRAWN != 0;
    world.is_shaded_where_drawn && view.draws.opaque.iter().any(is_one)
}

/// Those of `draws` that are at a level of detail; what has no levels is at the finest.
fn at_level(draws: &[Draw], level: u32, world: &WorldDraws) -> Vec<Draw> {
    draws.iter().filter(|draw| world.level_of(draw) == level).cloned().collect()
}
