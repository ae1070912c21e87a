//! Declares the passes of a frame's views on its graph, each view with what those before it left.

use super::ask::{FrameViews, ViewRequest};
use super::captures::MonitorView;
use super::counts::light_draws;
use super::fisheye::uv_from_place;
use super::mirrors::{MirrorLink, MirrorView, Reflector};
use super::output::ViewState;
use super::portals::Doors;
use super::prepare::PreparedFrame;
use super::prepare_view::{ViewSetup, output_of};
use super::purpose::Purpose;
use super::shadows::Atlas;
use super::surroundings::{self, FrameSurroundings, SideView, SurroundingsState};
use super::view_kind::Drawing;
use super::water::Surfaces;
use crate::aov::AovExports;
use crate::environment::lobe::FACES;
use crate::frame::{self, Flat, Means, Monitored, Picture, Tint};
use crate::gbuffer::{Gbuffer, ViewOutputs};
use crate::mirror_picture::MirrorPicture;
use crate::outline::rectangle_of;
use crate::overlay::draw::OverlayDraw;
use crate::passes::adaptive::Settling;
use crate::passes::fisheye::FaceRadiance;
use crate::passes::mirrors::ShownMirror;
use crate::passes::particles::ShownParticles;
use crate::passes::probe_capture::{CapturedProbe, SeenSide};
use crate::passes::{adaptive, meter};
use crate::record::{Frame, PreparedView, Recorder};
use crate::request::RenderError;
use crate::resources::monitor_desc;
use manypass_graph::{Export, Graph, Handle, Plan};
use manypass_scene::Scene;
use std::collections::BTreeMap;

/// What recording a view leaves to fetch.
#[derive(Default)]
pub(super) struct ViewExports {
    pub variables: AovExports,
    pub export: Option<Export>,
    /// The stops of an exposure that adapts.
    pub adapted: Option<Export>,
    /// Whether there is glass before a background that is none of radiance.
    pub has_tint: bool,
}

/// What of a scene its views show beside surfaces.
pub(super) struct SceneFeatures<'s> {
    scene: &'s Scene,
    water: Surfaces,
    doors: Doors,
    particles: Vec<ShownParticles>,
    surroundings: Option<(&'s SurroundingsState, &'s FrameSurroundings)>,
    /// Where what views around probes show belongs, in their order; and of which view it is put there.
    probes: Option<(&'s PreparedView, &'s [Option<CapturedProbe>])>,
}

impl<'s> SceneFeatures<'s> {
    pub fn new(
        prepared: &'s PreparedFrame<'s>,
        particles: Vec<ShownParticles>,
        surroundings: &'s SurroundingsState,
    ) -> Self {
        let scene = prepared.scene.scene;
        Self {
            scene,
            water: Surfaces::of(scene),
            doors: Doors::of(scene),
            particles,
            surroundings: prepared.surroundings.as_ref().map(|of_frame| (surroundings, of_frame)),
            probes: prepared.shared_view.as_ref().map(|view| (view, &prepared.captured[..])),
        }
    }
}

/// A frame whose passes are declared and planned.
pub(super) struct RecordedFrame<'f> {
    pub graph: Graph<'f>,
    pub plan: Plan,
    /// Of each view.
    pub views: Vec<ViewExports>,
    /// What the purpose of the frame reads.
    pub exports: Vec<Export>,
    /// Draws that only light.
    pub light_draws: u32,
}

/// Declares and plans all passes of a frame.
pub(super) fn record_frame<'f>(
    mut graph: Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    prepared: &'f PreparedFrame<'_>,
    views: &'f mut FrameViews,
    purpose: &Purpose<'_>,
) -> Result<RecordedFrame<'f>, RenderError> {
    let FrameViews { requests, states, .. } = views;
    let (requests, setups) = (&*requests, &prepared.setups);
    if let (Some(view), Some((shadows, atlas))) = (&prepared.shared_view, &prepared.shadows) {
        let mut r = Recorder::new(&mut graph, frame, view);
        let texture = r.graph.import("shadows.atlas", Atlas::desc(atlas.side), atlas.view.clone());
        frame::shared_passes(&mut r, shadows, texture)?;
    }
    let inputs = requests.iter().zip(states).zip(setups).zip(&prepared.overlays);
    let inputs = inputs.map(|(((asked, state), setup), overlay)| RecordInputs { asked, state, setup, overlay });
    let views = record_views(&mut graph, frame, features, inputs, purpose)?;
    let plan = graph.plan()?;
    let of_view = |(setup, asked): (&ViewSetup, &ViewRequest)| light_draws(&setup.view, asked, frame.world);
    let light_draws = setups.iter().zip(requests).map(of_view).sum();
    let exports = views.iter().filter_map(|exported| exported.export).chain(frame.scrubbed.exports()).collect();
    Ok(RecordedFrame { graph, plan, views, exports, light_draws })
}

/// A view that is recorded.
struct RecordInputs<'v, 'f> {
    pub asked: &'f ViewRequest,
    pub state: &'v mut ViewState,
    pub setup: &'f ViewSetup,
    pub overlay: &'v Option<OverlayDraw>,
}

/// Records all passes of views, innermost first.
fn record_views<'v, 'f: 'v>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    views: impl Iterator<Item = RecordInputs<'v, 'f>>,
    purpose: &Purpose<'_>,
) -> Result<Vec<ViewExports>, RenderError> {
    let mut before = EarlierResults::default();
    let mut first_side = None;
    let mut recorded = Vec::new();
    for view in views {
        let RecordInputs { asked, setup, .. } = &view;
        // Those that are captured again have the light of what was captured before.
        let bounce = asked.kind.bounce;
        if before.sides.keys().next().is_some_and(|side| Some(side.bounce) != bounce)
            && let (Some((state, surroundings)), Some(first)) = (features.surroundings, first_side)
        {
            surroundings::record(graph, frame, (state, surroundings, first), &mut before.sides)?;
        }
        if bounce == Some(0) {
            // What draws tiles is of a view that has none.
            first_side.get_or_insert(&setup.view);
        }
        // Those at one level see what there was before all of them.
        if before.seen.first().is_some_and(|seen| Some(seen.view.level) != asked.level) {
            record_monitors(graph, frame, features.scene, &mut before.seen)?;
        }
        recorded.push(record_view(graph, frame, features, view, &mut before, purpose)?);
    }
    Ok(recorded)
}

/// What views left for those that follow them.
#[derive(Default)]
struct EarlierResults<'f> {
    /// The sides of a fisheye picture.
    faces: Vec<FaceRadiance>,
    /// What cameras of monitors see, which screens do not show yet.
    seen: Vec<MonitorPicture<'f>>,
    /// The sides of the pictures around places.
    sides: BTreeMap<SideView, Handle>,
    /// The sides of what is around a probe, and how many probes came before it.
    around: Vec<SeenSide>,
    probes: usize,
    /// What is behind mirrors, by the names of the views.
    behind: BTreeMap<String, MirrorPicture>,
    /// Radiance of what is seen through portals, by the names of the views.
    through: BTreeMap<String, Handle>,
}

impl EarlierResults<'_> {
    /// The mirrors of a view.
    fn mirrors(&mut self, asked: &ViewRequest, setup: &ViewSetup) -> Vec<ShownMirror> {
        let shown = |seen: &MirrorLink| {
            let Reflector::Node(node) = seen.of else { return None };
            Some(ShownMirror {
                object: node.0 + 1,
                normal_world: seen.normal_world,
                is_smooth: seen.is_smooth,
                rectangle: rectangle_of(&setup.view.uniform, seen.corners_world, setup.view.size),
                picture: self.behind.remove(&seen.view)?,
            })
        };
        asked.mirrors.iter().filter_map(shown).collect()
    }
}

/// What the camera of a monitor sees.
struct MonitorPicture<'f> {
    view: &'f MonitorView,
    asked: &'f ViewRequest,
    setup: &'f ViewSetup,
    radiance: Handle,
    depth: Handle,
    means: Means,
    settling: Option<Settling>,
    /// The stops of an exposure that adapts.
    adapted: Option<Handle>,
}

/// Makes screens show what their cameras saw.
fn record_monitors<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    scene: &Scene,
    seen: &mut Vec<MonitorPicture<'f>>,
) -> Result<(), RenderError> {
    for MonitorPicture { view, asked, setup, radiance, depth, means, settling, adapted } in seen.drain(..) {
        let mut r = Recorder::new(graph, frame, &setup.view);
        let Some(texture) = import_monitor(&mut r, scene, view.image) else { continue };
        let request = &asked.request;
        let monitored = Monitored {
            radiance: &radiance,
            depth: &depth,
            means,
            adaptive_step: adaptive_step(asked, setup),
            settling,
            sample_index: request.sample_index,
            exposure: request.known_exposure() * view.exposure_stops.clamp(-64.0, 64.0).exp2(),
            adapted: adapted.as_ref(),
        };
        frame::monitor_passes(&mut r, &request.settings, monitored, texture)?;
    }
    Ok(())
}

/// Finds the light of a probe of what its sides show.
fn record_probe<'f>(
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

/// The texture that shows what the monitor of an image does.
fn import_monitor(r: &mut Recorder<'_, '_>, scene: &Scene, image: usize) -> Option<Handle> {
    let monitor = scene.images.get(image)?.monitor()?;
    let view = r.frame.resources.textures.monitor(scene, image)?;
    let desc = monitor_desc((monitor.width, monitor.height));
    Some(r.graph.import(format!("monitor.{image}"), desc, view.clone()))
}

/// Records all passes of a view.
fn record_view<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    features: &SceneFeatures<'f>,
    view: RecordInputs<'_, 'f>,
    before: &mut EarlierResults<'f>,
    purpose: &Purpose<'_>,
) -> Result<ViewExports, RenderError> {
    let RecordInputs { asked, state, setup, overlay } = view;
    let SceneFeatures { scene, water, doors, particles, .. } = features;
    let request = &asked.request;
    if purpose.draws_variables_alone {
        let mut r = Recorder::new(graph, frame, &setup.view);
        let outputs = frame::variable_passes(&mut r, &request.settings, &setup.variables)?;
        return Ok(ViewExports { variables: AovExports::new(r.graph, outputs), ..ViewExports::default() });
    }
    let (variables, of_view) = match &setup.variables_view {
        Some(view) => {
            let mut r = Recorder::new(graph, frame, view);
            (Some(frame::variable_passes(&mut r, &request.settings, &setup.variables)?), setup.of_effects)
        }
        None => (None, setup.variables.and(&setup.of_effects)),
    };
    let mut r = Recorder::new(graph, frame, &setup.view);
    if purpose.counts_pairs {
        return record_pairs(&mut r, asked);
    }
    let flat = Flat {
        mirrors: before.mirrors(asked, setup),
        water: water.shown((*scene, &frame.resources.textures), (asked, setup), &mut before.behind),
        portals: doors.shown(asked, &mut before.through),
        particles: particles.clone(),
    };
    let outputs = match &asked.kind.drawing {
        Drawing::Picture => frame::view_passes(&mut r, &request.settings, &of_view, &flat)?,
        Drawing::Mirror(view) => {
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            record_mirrored(&mut r, view, asked, outputs, before)?;
            return Ok(ViewExports::default());
        }
        Drawing::Side(side) => {
            let ViewOutputs { radiance, .. } = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            before.sides.insert(*side, radiance);
            return Ok(ViewExports::default());
        }
        Drawing::Probe(_) => {
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            if let ViewOutputs { radiance, gbuffer: Some(Gbuffer { linear_depth, .. }), .. } = outputs {
                before.around.push(SeenSide { radiance, linear_depth });
            }
            if before.around.len() == FACES.len() {
                record_probe(graph, frame, features, before)?;
            }
            return Ok(ViewExports::default());
        }
        Drawing::Face(face) => {
            let ViewOutputs { radiance, .. } = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            let uv_from_place = uv_from_place(face, request, asked.size);
            before.faces.push(FaceRadiance { side: face.side, radiance, uv_from_place });
            return Ok(ViewExports::default());
        }
        Drawing::Monitor(view) => {
            darken_monitors(&mut r, scene, view);
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &flat)?;
            before.seen.push(record_monitored(&mut r, view, (asked, state, setup), outputs, purpose)?);
            return Ok(ViewExports::default());
        }
        Drawing::Fisheye(of_fisheye) => {
            frame::fisheye_passes(&mut r, &of_fisheye.lens, request.sample(), std::mem::take(&mut before.faces))?
        }
    };
    let outputs = frame::temporal_passes(&mut r, &request.settings, setup.temporal.as_ref(), outputs)?;
    let (mut r, outputs) = match &setup.enlarged_view {
        Some(view) => {
            let outputs = frame::enlarged_passes(&mut r, view.size, outputs)?;
            (Recorder::new(graph, frame, view), outputs)
        }
        None => (r, outputs),
    };
    let mut outputs = frame::effect_passes(&mut r, &request.effects, outputs)?;
    let recorded = record_picture(&mut r, (asked, state, setup), overlay.as_ref(), &mut outputs, purpose)?;
    let variables = if asked.wants_variables {
        AovExports::new(r.graph, variables.unwrap_or(outputs))
    } else {
        AovExports::default()
    };
    Ok(ViewExports { variables, ..recorded })
}

/// Counts the pairs of a view; none of a fisheye, whose sides are counted.
fn record_pairs(r: &mut Recorder<'_, '_>, asked: &ViewRequest) -> Result<ViewExports, RenderError> {
    if !asked.kind.draws_surfaces {
        return Ok(ViewExports::default());
    }
    let pairs = frame::pair_passes(r, &asked.request.settings)?;
    Ok(ViewExports { export: Some(r.graph.export(pairs)), ..ViewExports::default() })
}

/// Makes the monitors dark that would be too deep in what the camera of another one sees.
fn darken_monitors(r: &mut Recorder<'_, '_>, scene: &Scene, view: &MonitorView) {
    for image in &view.darkens {
        let Some(texture) = import_monitor(r, scene, *image) else { continue };
        frame::darken_monitor(r, texture);
    }
}

/// Keeps what is seen behind a mirror or water, or through a portal, for the view that shows it.
fn record_mirrored(
    r: &mut Recorder<'_, '_>,
    view: &MirrorView,
    asked: &ViewRequest,
    outputs: ViewOutputs,
    before: &mut EarlierResults<'_>,
) -> Result<(), RenderError> {
    let ViewOutputs { radiance, gbuffer, .. } = outputs;
    if let Reflector::Portal(..) = view.of {
        before.through.insert(asked.name.clone(), radiance);
    } else if let Some(gbuffer) = gbuffer {
        let picture = frame::mirror_picture_passes(r, view.is_smooth, radiance, gbuffer.linear_depth)?;
        before.behind.insert(asked.name.clone(), picture);
    }
    Ok(())
}

/// What the camera of a monitor sees, with the exposure and the mean of its own.
fn record_monitored<'f>(
    r: &mut Recorder<'_, 'f>,
    view: &'f MonitorView,
    (asked, state, setup): (&'f ViewRequest, &mut ViewState, &'f ViewSetup),
    outputs: ViewOutputs,
    purpose: &Purpose<'_>,
) -> Result<MonitorPicture<'f>, RenderError> {
    let request = &asked.request;
    let outputs = frame::temporal_passes(r, &request.settings, setup.temporal.as_ref(), outputs)?;
    let ViewOutputs { radiance, depth, .. } = outputs;
    let adapting = request.adapting(state.adapted.is_some());
    let adapted = frame::exposure_passes(r, adapting.as_ref(), &radiance)?;
    let (previous_sum, settles) = (asked.previous_sum(state), adaptive_step(asked, setup) != adaptive::Step::None);
    let output = if asked.has_output() {
        output_of(r.frame.gpu, asked, &mut state.output, (purpose, settles), false)
    } else {
        None
    };
    let means = output.map_or(Means::None, |output| output.means(r.graph, asked.means_of, previous_sum));
    let settling = output.filter(|_| settles).and_then(|output| output.settling(r.graph));
    Ok(MonitorPicture { view, asked, setup, radiance, depth, means, settling, adapted })
}

/// What becomes of the radiance of a view whose picture is shown, or metered alone.
fn record_picture<'f>(
    r: &mut Recorder<'_, 'f>,
    (asked, state, setup): (&'f ViewRequest, &mut ViewState, &'f ViewSetup),
    overlay: Option<&OverlayDraw>,
    outputs: &mut ViewOutputs,
    purpose: &Purpose<'_>,
) -> Result<ViewExports, RenderError> {
    let request = &asked.request;
    let has_tint = outputs.tint.is_some();
    let (mut export, mut adapted) = (None, None);
    let previous_sum = asked.previous_sum(state);
    let step = adaptive_step(asked, setup);
    match output_of(r.frame.gpu, asked, &mut state.output, (purpose, step != adaptive::Step::None), has_tint) {
        None => {
            let meter = meter::record(r, &outputs.radiance)?;
            export = Some(r.graph.export(meter));
        }
        Some(output) => {
            let adapting = request.adapting(state.adapted.is_some());
            let stops = frame::exposure_passes(r, adapting.as_ref(), &outputs.radiance)?;
            let (settings, shaded) = (&request.settings, &outputs.radiance);
            let enlarged = frame::upscale_passes(r, settings, request.display_exposure(), shaded, asked.output_size)?;
            let means = output.means(r.graph, asked.means_of, previous_sum);
            let tint = outputs.tint.take().map(|texture| {
                let mean = output.tint_mean(r.graph, asked.means_of, previous_sum);
                Tint { texture, mean }
            });
            let picture = Picture {
                tint,
                display: output.display(r.graph),
                target: purpose.target,
                is_shown: purpose.shows_picture,
                sample_index: request.sample_index,
                exposure: request.known_exposure(),
                adapted: stops.as_ref(),
                depth: &outputs.depth,
                adaptive_step: step,
                overlay,
                settling: if step == adaptive::Step::None { None } else { output.settling(r.graph) },
            };
            let radiance = enlarged.as_ref().unwrap_or(shaded);
            frame::output_passes(r, settings, radiance, means, picture, &request.effects)?;
            adapted = stops.map(|stops| r.graph.export(stops));
        }
    }
    Ok(ViewExports { variables: AovExports::default(), export, adapted, has_tint })
}

/// What the view does after this sample.
fn adaptive_step(asked: &ViewRequest, setup: &ViewSetup) -> adaptive::Step {
    if setup.is_adaptive { asked.adaptive_step() } else { adaptive::Step::None }
}
