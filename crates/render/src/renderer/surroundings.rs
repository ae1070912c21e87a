//! Surroundings of a frame: which are drawn anew, what is asked of their views, and the texture that has their tiles and
//! the texels of probes beside those of the environment.

use super::Renderer;
use super::part::{PlannedView, settings_of};
use super::probe_lighting::ProbeLighting;
use super::probes::{PlacedProbes, ProbeTexels};
use super::view_kind::{CapturedLight, Drawing, SideView, ViewKind};
use crate::environment::lobe::{FACES, Lobe, LobeTable};
use crate::environment::{Background, EnvironmentUniform};
use crate::frame;
use crate::gpu::{Gpu, destroy};
use crate::passes::resolve::PixelSamples;
use crate::probes::{self, ProbeLayout};
use crate::record::{Frame, PreparedView, Recorder};
use crate::render_settings::Path;
use crate::request::{FrameRequest, RenderError};
use crate::resources::SceneResources;
use crate::surroundings::{
    Atlas, FACE_SIDE, SIDES, SurroundingsUniform, SurroundingsUniforms, face_camera, is_sound, known_surroundings,
};
use crate::view::View;
use bytemuck::Zeroable;
use glam::{Vec3, Vec4};
use manypass_graph::{Graph, Handle, TextureDesc};
use manypass_scene::capture::Update;
use manypass_scene::probes::ProbeGrid;
use manypass_scene::surroundings::{BOUNCES_MAX, SURROUNDINGS_MAX, Surroundings};
use manypass_scene::{Projection, Scene};
use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

/// A side of a reflection probe. What lies behind everything is what surfaces get light of.
fn kind_of(side: SideView) -> ViewKind {
    ViewKind {
        is_capture: true,
        constants: &[("shows_light", 1)],
        // Those that are captured first have the environment's light alone: the texture of the others is being drawn.
        captured_light: if side.bounce == 0 { CapturedLight::None } else { CapturedLight::All },
        bounce: Some(side.bounce),
        ..ViewKind::within(Drawing::Side(side))
    }
}

/// What the renderer keeps of surroundings.
#[derive(Clone, Debug, Default)]
pub(super) struct SurroundingsState {
    /// What tiles are drawn from, once there are any.
    lobes: Option<Arc<(Vec<Lobe>, LobeTable)>>,
    texture: Option<Tiles>,
    /// The texels of probes that are in it.
    pub probes: ProbeTexels,
    /// What lit live probes when frames last looked around them.
    probe_lighting: Option<Arc<ProbeLighting>>,
    /// What each slot shows, and with which pre-exposure it was drawn.
    drawn: [Option<CapturedSurroundings>; SURROUNDINGS_MAX],
    /// Whether the texture has no room for the probes of the last frame.
    pub lacks_probes: bool,
    /// Counts frames.
    frame: u64,
}

#[derive(Clone, Debug)]
struct CapturedSurroundings {
    of: Surroundings,
    pre_exposure: f32,
    frame: u64,
}

/// The texture of all tiles.
#[derive(Clone, Debug)]
struct Tiles {
    atlas: Atlas,
    view: wgpu::TextureView,
    /// The texture of the environment that was copied into it, and those of pictures of surroundings.
    copied: Option<wgpu::Texture>,
    pictures: [Option<wgpu::Texture>; SURROUNDINGS_MAX],
}

/// The texture of a frame's views that have surroundings or probes.
#[derive(Clone, Debug)]
pub(super) struct FrameSurroundings {
    pub view: wgpu::TextureView,
    pub atlas: Atlas,
    /// For radiance that is not pre-exposed.
    uniforms: SurroundingsUniforms,
    pub count: u32,
    pub probes: PlacedProbes,
    /// The texture of the environment whose tiles are there: views with another one have no surroundings.
    environment: Option<wgpu::Texture>,
}

impl SurroundingsState {
    /// Whether what lights live probes is another than when this was last asked.
    pub fn is_relit(&mut self, lighting: ProbeLighting) -> bool {
        if self.probe_lighting.as_deref() == Some(&lighting) {
            return false;
        }
        self.probe_lighting = Some(Arc::new(lighting));
        true
    }

    /// Copies the tiles of the environment beside those of surroundings, unless they are there; `is_new` says that they were
    /// drawn anew.
    pub fn copy_environment(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        environment: Option<&wgpu::TextureView>,
        is_new: bool,
    ) {
        let Some(tiles) = &mut self.texture else { return };
        let Some(from) = environment.map(|view| view.texture().clone()) else { return };
        if tiles.copied.as_ref() == Some(&from) && !is_new {
            return;
        }
        let extent = wgpu::Extent3d { width: from.width(), height: from.height(), depth_or_array_layers: 1 };
        encoder.copy_texture_to_texture(from.as_image_copy(), tiles.view.texture().as_image_copy(), extent);
        tiles.copied = Some(from);
    }

    /// The same of the tiles of pictures that surroundings have, which lie in `resources`; `are_new` says that some were drawn
    /// anew.
    pub fn copy_pictures(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        (scene, resources): (&Scene, &SceneResources),
        are_new: bool,
    ) {
        let Some(tiles) = &mut self.texture else { return };
        for (index, (of, copied)) in known_surroundings(scene).zip(&mut tiles.pictures).enumerate() {
            let picture = of.picture.as_ref().and_then(|picture| resources.picture_of_place(picture));
            let Some(from) = picture.map(|tiles| tiles.view.texture()) else {
                *copied = None;
                continue;
            };
            if copied.as_ref() == Some(from) && !are_new {
                continue;
            }
            let extent = wgpu::Extent3d { width: from.width(), height: from.height(), depth_or_array_layers: 1 };
            let [x, y] = tiles.atlas.corner(index);
            let origin = wgpu::Origin3d { x, y, z: 0 };
            let to = wgpu::TexelCopyTextureInfo { origin, ..tiles.view.texture().as_image_copy() };
            encoder.copy_texture_to_texture(from.as_image_copy(), to, extent);
            *copied = Some(from.clone());
            // Nothing that was captured is there any more.
            if let Some(drawn) = self.drawn.get_mut(index) {
                *drawn = None;
            }
        }
    }

    /// The texture of all tiles, and where the texels of probes begin in it.
    pub fn texels(&self) -> Option<(&wgpu::Texture, [u32; 2])> {
        self.texture.as_ref().map(|tiles| (tiles.view.texture(), tiles.atlas.probes))
    }

    /// Nothing is known to be there any more.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// The texture of all tiles, once there is one.
    pub fn texture(&self) -> Option<&wgpu::TextureView> {
        self.texture.as_ref().map(|tiles| &tiles.view)
    }
}

/// What is wrong with surroundings of a scene, which are not drawn then.
pub(super) fn faults(scene: &Scene) -> Vec<String> {
    let fault = |of: &&Surroundings| !is_sound(of);
    let said = |of: &Surroundings| {
        format!("the reflection probe `{}` is left out: its boxes are invalid, or too large", of.name)
    };
    let mut faults: Vec<String> = scene.surroundings.iter().take(SURROUNDINGS_MAX).filter(fault).map(said).collect();
    if scene.surroundings.len() > SURROUNDINGS_MAX {
        faults.push(format!(
            "only the first {SURROUNDINGS_MAX} of {} reflection probes are drawn",
            scene.surroundings.len()
        ));
    }
    faults
}

/// What is asked of a side of what is around a place, so many pixels wide, where `request` is asked of the picture: of some
/// layers, and of a tier of quality.
///
/// # Errors
/// There is no such tier.
pub(super) fn side_request(
    (position_world, face): (Vec3, usize),
    (layers, quality): (u32, Option<&str>),
    side_px: u32,
    request: &FrameRequest,
) -> Result<FrameRequest, RenderError> {
    let mut settings = settings_of(quality, &request.settings)?;
    settings.background.source = Background::Environment;
    settings.render.path = Path::Deferred;
    settings.msaa.samples = PixelSamples::default();
    settings.allow_taa(false);
    let projection = Projection::Perspective { fov_y_rad: FRAC_PI_2, near_m: 0.02, far_m: None };
    let axes = FACES.get(face).copied().unwrap_or_default();
    let side = FrameRequest {
        width: side_px,
        height: side_px,
        camera: View { world_from_view: face_camera(axes, position_world), projection },
        clip_plane_world: None,
        layers,
        sample_index: 0,
        sample_count: 1,
        ..request.within(settings)
    };
    Ok(side.with_switches_resolved())
}

impl Renderer {
    /// The views of the sides of surroundings that a frame draws anew, as `state` knows from then on.
    ///
    /// # Errors
    /// Surroundings ask for a tier of quality that there is not.
    pub(super) fn sides(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        state: &mut SurroundingsState,
    ) -> Result<Vec<PlannedView>, RenderError> {
        let (mut parts, mut due) = (Vec::new(), Vec::new());
        if scene.surroundings.is_empty() {
            return Ok(parts);
        }
        state.frame += 1;
        let lobes = self.surroundings.lobes.get_or_insert_with(|| {
            let lobes = Lobe::of_levels(FACE_SIDE);
            let table = LobeTable::new(&self.gpu, &lobes);
            Arc::new((lobes, table))
        });
        state.lobes = Some(lobes.clone());
        for (index, of) in known_surroundings(scene).enumerate().filter(|(_, of)| of.picture.is_none()) {
            let last = state.drawn.get(index).and_then(Option::as_ref).filter(|drawn| drawn.of == *of);
            let is_due = last.is_none_or(|last| match (request.goes_on, of.update) {
                // The samples of a still have those of its first.
                (false, _) => request.sample_index == 0,
                (true, Update::Always) => true,
                (true, Update::Every(frames)) => state.frame - last.frame >= u64::from(frames.max(1)),
                (true, Update::Once) => false,
            });
            if !is_due {
                continue;
            }
            if let Some(drawn) = state.drawn.get_mut(index) {
                let pre_exposure = request.pre_exposure();
                *drawn = Some(CapturedSurroundings { of: of.clone(), pre_exposure, frame: state.frame });
            }
            due.push((index, of));
        }
        for bounce in 0..BOUNCES_MAX {
            for (index, of) in due.iter().filter(|(_, of)| bounce < of.bounces.max(1)) {
                let twin = known_surroundings(scene).take(*index).filter(|other| other.name == of.name).count();
                let twin = if twin > 0 { format!(".{}", twin + 1) } else { String::new() };
                let again = if bounce > 0 { format!("/{}", bounce + 1) } else { String::new() };
                for face in 0..FACES.len() {
                    let name = format!("surroundings/{}{twin}.{face}{again}", of.name);
                    let side = SideView { bounce, index: *index, face };
                    let of_place = (of.layers, of.quality.as_deref());
                    let asked = side_request((of.position_world, face), of_place, FACE_SIDE, request)?;
                    parts.push(PlannedView::new(name, asked, kind_of(side)));
                }
            }
        }
        Ok(parts)
    }

    /// The texture for the tiles of a frame's surroundings and the texels of its probes, beside the tiles of the environment,
    /// if a scene has any and the adapter has room for it; where that is too little, probes are left out. `state` knows of
    /// it from then on; a plan (`is_run` is false) writes nothing.
    pub(super) fn prepare_surroundings(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        environment: Option<&wgpu::TextureView>,
        (state, is_run): (&mut SurroundingsState, bool),
    ) -> Option<FrameSurroundings> {
        // Pictures that were found beforehand are none that are captured.
        let is_shown = |of: &Surroundings| request.settings.captures.enabled || of.picture.is_some();
        let has_any = known_surroundings(scene).any(is_shown);
        let all: Vec<&Surroundings> = known_surroundings(scene).filter(|_| has_any).collect();
        let grids = probes::known(scene, request.settings.captures.enabled);
        if all.is_empty() && grids.is_empty() {
            state.lacks_probes = false;
            state.probes.forget();
            return None;
        }
        let of_environment = environment.map(|view| view.texture().clone());
        let size = of_environment.as_ref().map_or((0, 0), |texture| (texture.width(), texture.height()));
        let limit = self.gpu.capabilities.max_texture_size;
        let count = grids.len();
        let fitting = fitting(&all, grids, size, limit);
        state.lacks_probes = fitting.as_ref().map_or(0, |(_, layout, _)| layout.places.len()) < count;
        if fitting.is_none() {
            state.probes.forget();
        }
        let (atlas, layout, grids) = fitting?;
        let is_known = state.texture.as_ref().is_some_and(|tiles| tiles.atlas == atlas);
        if !is_known && is_run {
            if let Some(former) = state.texture.take() {
                destroy(&former.view);
            }
            self.surroundings.clear();
            let view = create(&self.gpu, &atlas);
            let tiles = Tiles { atlas, view, copied: None, pictures: Default::default() };
            // A frame that fails leaves the texture, of which nothing is known.
            self.surroundings.texture = Some(tiles.clone());
            state.texture = Some(tiles);
            state.probes = ProbeTexels::default();
            // What was drawn into another texture is to be drawn again; until the next frame there is none of it.
            let frame = state.frame;
            state.drawn.iter_mut().for_each(|drawn| *drawn = drawn.take().filter(|drawn| drawn.frame == frame));
        }
        let mut uniforms = SurroundingsUniforms::zeroed();
        for (index, (uniform, of)) in uniforms.iter_mut().zip(&all).enumerate() {
            let drawn = state.drawn.get(index).and_then(Option::as_ref);
            let of_drawn = drawn.map_or(0.0, |drawn| drawn.pre_exposure.recip());
            let scale = if of.picture.is_some() { 1.0 } else { of_drawn };
            *uniform = SurroundingsUniform::new(of, atlas.corner(index), if scale.is_finite() { scale } else { 0.0 });
            if !is_shown(of) {
                uniform.half_m = Vec4::ZERO;
            }
        }
        if is_run && !state.probes.hold(&layout, &grids) {
            // Texels are written at once.
            self.surroundings.probes.forget();
        }
        let placed = match &state.texture {
            Some(tiles) if is_run => state.probes.write(
                &self.gpu,
                (tiles.view.texture(), atlas.probes),
                &layout,
                &grids,
                request.pre_exposure(),
            ),
            _ => PlacedProbes::of_plan(&self.gpu, &layout, &grids),
        };
        // Nobody looks at that of a plan.
        let view = match &state.texture {
            Some(tiles) if is_known || is_run => tiles.view.clone(),
            _ => self.drawing.tables.no_environment.clone(),
        };
        Some(FrameSurroundings {
            view,
            atlas,
            uniforms,
            count: all.len() as u32,
            probes: placed,
            environment: of_environment,
        })
    }
}

/// Where all lies, with as many grids as there is room for, the first ones.
fn fitting<'s>(
    all: &[&Surroundings],
    mut grids: Vec<&'s ProbeGrid>,
    environment: (u32, u32),
    limit: u32,
) -> Option<(Atlas, ProbeLayout, Vec<&'s ProbeGrid>)> {
    loop {
        let layout = ProbeLayout::new(&grids);
        match Atlas::new(all.len(), environment, layout.size, limit) {
            Some(_) if all.is_empty() && grids.is_empty() => return None,
            Some(atlas) => return Some((atlas, layout, grids)),
            None => {
                grids.pop()?;
            }
        }
    }
}

impl FrameSurroundings {
    /// Whether their texture has the tiles of a view's environment.
    pub fn have(&self, environment: Option<&wgpu::TextureView>) -> bool {
        self.environment.as_ref() == environment.map(wgpu::TextureView::texture)
    }

    /// Their texture as one that passes draw into.
    pub fn import(&self, r: &mut Recorder<'_, '_>, name: String) -> Handle {
        let (width, height) = self.atlas.size;
        r.graph.import(name, TextureDesc::new_2d(width, height, self.view.texture().format()), self.view.clone())
    }

    /// Of what views around probes have: probes alone, because surroundings may be drawn only after them.
    pub fn of_probes(&self) -> Self {
        Self { count: 0, ..self.clone() }
    }

    /// Puts them into the uniform of a view's environment, whose radiance is pre-exposed.
    pub fn place(&self, uniform: &mut EnvironmentUniform, pre_exposure: f32) {
        if self.count > 0 {
            uniform.surroundings = self.uniforms;
            for of in &mut uniform.surroundings {
                of.half_m.w *= pre_exposure;
            }
            uniform.surrounding_sides = SIDES.uniform();
        }
        self.probes.place(uniform, pre_exposure);
        let (width, height) = self.atlas.size;
        let inverse = Vec4::new(0.0, 0.0, 1.0 / width as f32, 1.0 / height as f32);
        uniform.picture_backdrop = uniform.picture_backdrop.truncate().truncate().extend(inverse.z).extend(inverse.w);
    }
}

/// Draws the tiles of what the sides of a cube have shown.
pub(super) fn record<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    (state, surroundings, view): (&SurroundingsState, &FrameSurroundings, &'f PreparedView),
    faces: &mut BTreeMap<SideView, Handle>,
) -> Result<(), RenderError> {
    let first: Vec<SideView> = faces.keys().filter(|side| side.face == 0).copied().collect();
    let Some(of_state) = &state.lobes else { return Ok(()) };
    let (lobes, table) = &**of_state;
    for side in first {
        let index = side.index;
        let mut of_side = |face: usize| faces.remove(&SideView { face, ..side });
        let [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)] = [0, 1, 2, 3, 4, 5].map(&mut of_side) else {
            continue;
        };
        let mut r = Recorder::new(graph, frame, view);
        let target = surroundings.import(&mut r, format!("surroundings.{index}"));
        let tile = |level: u32| surroundings.atlas.tile(index, level);
        frame::surroundings_passes(&mut r, (lobes, table), &[a, b, c, d, e, f], tile, target)?;
    }
    faces.clear();
    Ok(())
}

fn create(gpu: &Gpu, atlas: &Atlas) -> wgpu::TextureView {
    let (width, height) = atlas.size;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("surroundings"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: gpu.capabilities.tiles_format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}
