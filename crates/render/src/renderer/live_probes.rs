//! Probes whose light frames find: what is asked of the views around them, and where what they show belongs.

use super::Renderer;
use super::ask::ViewRequest;
use super::next::NextState;
use super::part::{Captures, PlannedView};
use super::probe_lighting::{ProbeLighting, environment_of};
use super::probes::{DueProbe, place_of};
use super::purpose::Purpose;
use super::record_inputs::{EarlierResults, SceneFeatures};
use super::resolve::ResolvedFrame;
use super::surroundings::{FrameSurroundings, side_request};
use super::view_kind::{CapturedLight, Drawing, ProbeSide, ViewKind};
use crate::constants::PROBE_FACE_SIDE;
use crate::environment::lobe::FACES;
use crate::frame;
use crate::gpu::readback;
use crate::ground::Ground;
use crate::passes::probe_capture::CapturedProbe;
use crate::probes::{DISTANCE_MAX_M, known, read_probe};
use crate::record::{Frame, Recorder};
use crate::request::{FrameRequest, RenderError};
use crate::setting::Switch;
use glam::Vec4;
use half::f16;
use manypass_graph::Graph;
use manypass_scene::probes::{Probe, ProbeGrid};
use manypass_scene::{Projection, Scene};

/// Around so many probes a frame looks that a still has before its first.
const AT_ONCE: usize = 8;

/// What is nearer to a probe is not seen, as a share of the least distance between probes.
const NEAR_SHARE: f32 = 0.02;

/// What is asked of a side of what is around a probe where `request` is asked of the picture: all light and all shadows, and
/// nothing that is found in the picture.
fn request_of(grid: &ProbeGrid, probe: usize, face: usize, request: &FrameRequest) -> Option<FrameRequest> {
    let (position_world, _) = place_of(grid, probe)?;
    let layers = grid.live.unwrap_or_default().layers;
    let side = side_request((position_world, face), (layers, None), PROBE_FACE_SIDE, request).ok()?;
    let mut side = side.with(|settings| {
        settings.environment = environment_of(settings);
        settings.ground.mode = Ground::None;
        settings.occlusion.enabled = Switch::Off;
        settings.reflections.enabled = Switch::Off;
        settings.gi.enabled = false;
        settings.shadows.contact_m = 0.0;
        settings.lights.min_px = 0.0;
    });
    // Walls are nearer to probes that are nearer to each other.
    let least_m = NEAR_SHARE * grid.spacing_m().min_element();
    if let Projection::Perspective { near_m, .. } = &mut side.camera.projection {
        *near_m = near_m.min(least_m);
    }
    Some(FrameRequest { light_rounds: None, ..side })
}

/// A side of what is around a probe. Suns are known to those who add up what sides show. A probe in a wall sees the wall,
/// and nothing beyond.
fn kind_of(side: ProbeSide) -> ViewKind {
    ViewKind {
        constants: &[("shows_light", 2), ("backs_are_black", 1)],
        // How far the eye is from a probe says nothing of how its light is seen.
        simplifies_far_light: false,
        shows_backs: true,
        is_around: true,
        captured_light: CapturedLight::Irradiance,
        ..ViewKind::within(Drawing::Probe(side))
    }
}

/// The views around probes. Their names are those of their places among them, so that few are kept.
fn parts_of(grids: &[&ProbeGrid], due: &[DueProbe], is_apart: bool, request: &FrameRequest) -> Vec<PlannedView> {
    let views = due.iter().enumerate().flat_map(|(slot, of)| (0..FACES.len()).map(move |face| (slot, *of, face)));
    let part = |(slot, of, face): (usize, DueProbe, usize)| {
        let asked = request_of(grids.get(of.grid)?, of.probe, face, request)?;
        let side = ProbeSide { of, face, is_apart };
        Some(PlannedView::new(format!("probes/{slot}.{face}"), asked, kind_of(side)))
    };
    views.filter_map(part).collect()
}

/// Finds the light of a probe of what its sides show.
pub(super) fn record_probe<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    before: &mut EarlierResults<'_>,
) -> Result<(), RenderError> {
    let (sides, at) = (std::mem::take(&mut before.around), before.probes);
    before.probes += 1;
    let (Some((_, surroundings)), Some((view, probes))) = (features.surroundings, features.probes) else {
        return Ok(());
    };
    let Some(Some(probe)) = probes.get(at) else { return Ok(()) };
    let mut r = Recorder::new(graph, frame, view);
    let target = surroundings.import(&mut r, format!("probes.{at}"));
    frame::probe_light_passes(&mut r, probe, &sides, target)?;
    Ok(())
}

impl Renderer {
    /// Whether frames of a live view as `request` asks for have yet to look around probes ([`ProbeGrid::live`]). Until then each
    /// has other light than the one before: a mean of several is to begin anew.
    pub fn is_finding_light(&self, request: &FrameRequest) -> bool {
        request.settings.captures.enabled && self.surroundings.probes.is_finding()
    }

    /// Brings the device up to date, and says what lights live probes.
    fn probe_lighting(&mut self, scene: &Scene, request: &FrameRequest) -> ProbeLighting {
        self.limit_textures(request.settings.textures.max_px);
        self.follow(scene);
        ProbeLighting::new(scene, self.shadows.scene_version, request)
    }

    /// The views around the probes that a frame of a live view looks around. A still has looked around all before.
    pub(super) fn probe_parts(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        next: &mut NextState,
    ) -> Vec<PlannedView> {
        let grids = known(scene, request.settings.captures.enabled);
        if !request.goes_on || !request.settings.captures.enabled || grids.iter().all(|grid| grid.live.is_none()) {
            return Vec::new();
        }
        let most = request.settings.captures.probes as usize;
        if !next.is_run {
            // A plan looks around as many as a frame may.
            let at = grids.iter().position(|grid| grid.live.is_some()).unwrap_or(0);
            let due: Vec<DueProbe> =
                (0..most.min(grids[at].count())).map(|probe| DueProbe { grid: at, probe }).collect();
            return parts_of(&grids, &due, false, request);
        }
        let lighting = self.probe_lighting(scene, request);
        let is_new = next.surroundings.is_relit(lighting);
        let due = next.surroundings.probes.due(&grids, is_new, most, request.pre_exposure());
        parts_of(&grids, &due, false, request)
    }

    /// Finds the light of live probes for the stills of `request` ([`ProbeGrid::live`]), unless it is known. The first frame of a
    /// still does so by itself; whoever shows how far that is, or lets it be stopped, does it before. `progress` is told around
    /// how many probes was looked, and around how many will be, and says whether to go on.
    ///
    /// # Errors
    /// As [`Self::render`]; and [`RenderError::Stopped`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn find_probe_light(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        progress: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<(), RenderError> {
        let defaults = std::cell::LazyCell::new(|| crate::request::SceneDefaults::of(scene));
        let request = request.resolved_by(&defaults);
        self.computed.follow(std::iter::once(&request.settings.environment));
        pollster::block_on(self.light_probes(scene, &request, true, progress))
    }

    /// What the probes of a grid of the scene know as frames read them, in the order of the grid: those that frames have found
    /// ([`Self::find_probe_light`]), which may be kept and drawn as if they had been baked, or those that the grid brought. None
    /// where it is not on the device. `scene` is that of the last frame.
    ///
    /// # Errors
    /// The device was lost.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_probes(&self, scene: &Scene, grid: usize) -> Result<Option<Vec<Probe>>, RenderError> {
        pollster::block_on(self.read_probes_async(scene, grid))
    }

    /// As [`Self::read_probes`], where waiting is not possible.
    ///
    /// # Errors
    /// As [`Self::read_probes`].
    pub async fn read_probes_async(&self, scene: &Scene, grid: usize) -> Result<Option<Vec<Probe>>, RenderError> {
        let (grids, state) = (known(scene, true), &self.surroundings);
        let Some(grid) = scene.probes.get(grid) else { return Ok(None) };
        let at = grids.iter().position(|known| std::ptr::eq(*known, grid));
        let placed = at.and_then(|at| state.probes.placed(&grids, at));
        let (Some(placed), Some((texture, [left, top]))) = (placed, state.texels()) else { return Ok(None) };
        let bytes = readback::read_texture(&self.gpu, texture).await?;
        let is_half = texture.format() == wgpu::TextureFormat::Rgba16Float;
        let number = |at: usize| {
            if is_half {
                f16::from_le_bytes([bytes[2 * at], bytes[2 * at + 1]]).to_f32()
            } else {
                f32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * at + byte]))
            }
        };
        let texel = |x: u32, y: u32| {
            let first = 4 * ((top + y) as usize * texture.width() as usize + (left + x) as usize);
            Vec4::from_array(std::array::from_fn(|at| number(first + at)))
        };
        let probe =
            |index: usize| read_probe(grid, placed.place.of_probe(grid, index, placed.light), placed.scale, texel);
        Ok(Some((0..grid.count()).map(probe).collect()))
    }

    /// Finds the light of live probes for a still, unless it is known: as often as their grids say, each time in the light that
    /// was found before. With `is_exposed` what was found at quite another exposure is found again.
    pub(super) async fn light_probes(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        is_exposed: bool,
        progress: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<(), RenderError> {
        let grids = known(scene, request.settings.captures.enabled);
        if !request.settings.captures.enabled || grids.iter().all(|grid| grid.live.is_none()) {
            return Ok(());
        }
        let pre_exposure = is_exposed.then_some(request.pre_exposure());
        let lighting = self.probe_lighting(scene, request);
        if !self.surroundings.is_relit(lighting) && self.surroundings.probes.is_found(&grids, pre_exposure) {
            return Ok(());
        }
        self.surroundings.probes.forget();
        let bounces = |grid: &ProbeGrid| grid.live.map_or(0, |live| live.bounces.max(1));
        let all: usize = grids.iter().map(|grid| grid.count() * bounces(grid) as usize).sum();
        let (mut done, rounds) = (0, grids.iter().map(|grid| bounces(grid)).max().unwrap_or(0));
        for round in 0..rounds {
            let in_round = || grids.iter().enumerate().filter(|(_, grid)| round < bounces(grid));
            let due = in_round().flat_map(|(grid, of)| (0..of.count()).map(move |probe| DueProbe { grid, probe }));
            let due: Vec<DueProbe> = due.filter(|due| place_of(grids[due.grid], due.probe).is_some()).collect();
            for due in due.chunks(AT_ONCE) {
                // What there is no room for is known once the first of them were drawn.
                if done > 0
                    && self.surroundings.lacks_probes
                    && due.iter().all(|due| !self.surroundings.probes.has(due.grid))
                {
                    continue;
                }
                let parts = parts_of(&grids, due, true, request);
                let next = NextState::of(self, &Purpose::BESIDE);
                let resolved = ResolvedFrame { captures: Captures { parts, left_out: 0 }, next };
                self.run_views(scene, resolved, &Purpose::BESIDE).await?;
                done += due.len();
                if !progress(done, all) {
                    self.surroundings.probes.forget();
                    return Err(RenderError::Stopped);
                }
            }
            in_round().for_each(|(grid, _)| self.surroundings.probes.swap(grid));
        }
        self.surroundings.probes.finish();
        Ok(())
    }

    /// Where what views around probes show belongs, in their order; none of those that there is no room for.
    pub(super) fn captured_probes(
        &self,
        scene: &Scene,
        asked: &[ViewRequest],
        surroundings: Option<&FrameSurroundings>,
    ) -> Vec<Option<CapturedProbe>> {
        let Some(surroundings) = surroundings else { return Vec::new() };
        let grids = known(scene, true);
        let captured = |(asked, of, is_apart): (&ViewRequest, DueProbe, bool)| {
            let (grid, placed) = (grids.get(of.grid)?, surroundings.probes.grids.get(of.grid)?);
            let (_, offset_m) = place_of(grid, of.probe)?;
            let light = if is_apart { 1 - placed.light.min(1) } else { placed.light };
            let [[x, y], [left, top]] = placed.place.of_probe(grid, of.probe, light);
            let corner = surroundings.atlas.probes;
            let uniform = asked.request.environment_uniform(self.tiles_of(asked));
            Some(CapturedProbe {
                offset_m,
                scale: (placed.scale * asked.request.pre_exposure()).recip(),
                is_cube: grid.basis == manypass_scene::probes::ProbeBasis::AmbientCube,
                light: [corner[0] + x, corner[1] + y],
                distances: [corner[0] + left, corner[1] + top],
                distance_max_m: grid.distance_max_m().min(DISTANCE_MAX_M),
                sun_directions: uniform.sun_directions,
                sun_irradiances: uniform.sun_irradiances,
            })
        };
        let first_side = |asked: &'_ ViewRequest| match asked.kind.drawing {
            Drawing::Probe(ProbeSide { of, face: 0, is_apart }) => Some((of, is_apart)),
            _ => None,
        };
        let first_sides =
            asked.iter().filter_map(|asked| first_side(asked).map(|(of, is_apart)| (asked, of, is_apart)));
        first_sides.map(captured).collect()
    }
}
