//! Records the passes of a frame's views, each with what those before it left.

use super::Purpose;
use super::asked::{Asked, ViewPart};
use super::captures::MonitorView;
use super::fisheye::uv_from_place;
use super::mirrors::{MirrorSeen, MirrorView, Reflector};
use super::output::ViewState;
use super::portals::Doors;
use super::prepare::{Ready, output_of};
use super::surroundings::{self, FrameSurroundings, SideView, SurroundingsState};
use super::water::Surfaces;
use crate::aov::AovExports;
use crate::environment::lobe::FACES;
use crate::frame::{self, Means, MonitorInputs, Picture, SceneLayers, Tint};
use crate::gbuffer::{Gbuffer, ViewOutputs};
use crate::mirror_picture::MirrorPicture;
use crate::outline::rectangle_of;
use crate::overlay::draw::OverlayDraw;
use crate::passes::adaptive::ConvergedTiles;
use crate::passes::fisheye::FaceRadiance;
use crate::passes::mirrors::MirrorDraw;
use crate::passes::particles::ParticlesDraw;
use crate::passes::present::Target;
use crate::passes::probe_capture::{CapturedProbe, ProbeSide};
use crate::passes::{adaptive, meter};
use crate::record::{Frame, PreparedView, Recorder};
use crate::request::RenderError;
use crate::resources::monitor_desc;
use manypass_graph::{Export, Graph, Handle};
use manypass_scene::Scene;
use std::collections::BTreeMap;

/// What recording a view leaves to fetch.
#[derive(Default)]
pub(super) struct Recorded {
    pub variables: AovExports,
    pub export: Option<Export>,
    /// The stops of an exposure that adapts.
    pub adapted: Option<Export>,
    /// Whether there is glass before a background that is none of radiance.
    pub has_tint: bool,
}

/// What of a scene all of its views show.
pub(super) struct OfScene<'s> {
    scene: &'s Scene,
    water: Surfaces,
    doors: Doors,
    particles: Vec<ParticlesDraw>,
    surroundings: Option<(&'s SurroundingsState, &'s FrameSurroundings)>,
    /// Where what views around probes show belongs, in their order; and of which view it is put there.
    probes: Option<(&'s PreparedView, &'s [Option<CapturedProbe>])>,
}

impl<'s> OfScene<'s> {
    pub fn new(
        scene: &'s Scene,
        particles: Vec<ParticlesDraw>,
        surroundings: Option<(&'s SurroundingsState, &'s FrameSurroundings)>,
        probes: Option<(&'s PreparedView, &'s [Option<CapturedProbe>])>,
    ) -> Self {
        Self { scene, water: Surfaces::of(scene), doors: Doors::of(scene), particles, surroundings, probes }
    }
}

/// A view that is recorded.
pub(super) struct RecordedView<'v, 'f> {
    pub asked: &'f Asked,
    pub state: &'v mut ViewState,
    pub ready: &'f Ready,
    pub overlay: &'v Option<OverlayDraw>,
}

/// Records all passes of views, innermost first.
pub(super) fn record_views<'v, 'f: 'v>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    of_scene: &OfScene<'f>,
    views: impl Iterator<Item = RecordedView<'v, 'f>>,
    purpose: &Purpose<'_>,
) -> Result<Vec<Recorded>, RenderError> {
    let mut before = Before::default();
    let mut first_side = None;
    let mut recorded = Vec::new();
    for view in views {
        let RecordedView { asked, ready, .. } = &view;
        // Those that are captured again have the light of what was captured before.
        let bounce = if let ViewPart::Side(side) = &asked.part { Some(side.bounce) } else { None };
        if before.sides.keys().next().is_some_and(|side| Some(side.bounce) != bounce)
            && let (Some((state, surroundings)), Some(first)) = (of_scene.surroundings, first_side)
        {
            surroundings::record(graph, frame, (state, surroundings, first), &mut before.sides)?;
        }
        if bounce == Some(0) {
            // What draws tiles is of a view that has none.
            first_side.get_or_insert(&ready.view);
        }
        // Those at one level see what there was before all of them.
        if before.seen.first().is_some_and(|seen| Some(seen.view.level) != asked.level) {
            record_monitors(graph, frame, of_scene.scene, &mut before.seen)?;
        }
        recorded.push(record_view(graph, frame, of_scene, view, &mut before, purpose)?);
    }
    Ok(recorded)
}

/// What views left for those that follow them.
#[derive(Default)]
struct Before<'f> {
    /// The sides of a fisheye picture.
    faces: Vec<FaceRadiance>,
    /// What cameras of monitors see, which screens do not show yet.
    seen: Vec<Seen<'f>>,
    /// The sides of the pictures around places.
    sides: BTreeMap<SideView, Handle>,
    /// The sides of what is around a probe, and how many probes came before it.
    around: Vec<ProbeSide>,
    probes: usize,
    /// What is behind mirrors, by the names of the views.
    behind: BTreeMap<String, MirrorPicture>,
    /// Radiance of what is seen through portals, by the names of the views.
    through: BTreeMap<String, Handle>,
}

impl Before<'_> {
    /// The mirrors of a view.
    fn mirrors(&mut self, asked: &Asked, ready: &Ready) -> Vec<MirrorDraw> {
        let shown = |seen: &MirrorSeen| {
            let Reflector::Node(node) = seen.of else { return None };
            Some(MirrorDraw {
                object: node.0 + 1,
                normal_world: seen.normal_world,
                is_smooth: seen.is_smooth,
                rectangle: rectangle_of(&ready.view.uniform, seen.corners_world, ready.view.size),
                picture: self.behind.remove(&seen.view)?,
            })
        };
        asked.mirrors.iter().filter_map(shown).collect()
    }
}

/// What the camera of a monitor sees.
struct Seen<'f> {
    view: &'f MonitorView,
    asked: &'f Asked,
    ready: &'f Ready,
    radiance: Handle,
    depth: Handle,
    means: Means,
    settling: Option<ConvergedTiles>,
    /// The stops of an exposure that adapts.
    adapted: Option<Handle>,
}

/// Makes screens show what their cameras saw.
fn record_monitors<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    scene: &Scene,
    seen: &mut Vec<Seen<'f>>,
) -> Result<(), RenderError> {
    for Seen { view, asked, ready, radiance, depth, means, settling, adapted } in seen.drain(..) {
        let mut r = Recorder::new(graph, frame, &ready.view);
        let Some(texture) = import_monitor(&mut r, scene, view.image) else { continue };
        let request = &asked.request;
        let inputs = MonitorInputs {
            radiance: &radiance,
            depth: &depth,
            means,
            adaptive_step: adaptive_step(asked, ready),
            settling,
            sample_index: request.sample_index,
            exposure: request.known_exposure() * view.exposure_stops.clamp(-64.0, 64.0).exp2(),
            adapted: adapted.as_ref(),
        };
        frame::monitor_passes(&mut r, &request.settings, inputs, texture)?;
    }
    Ok(())
}

/// Finds the light of a probe of what its sides show.
fn record_probe<'f>(
    graph: &mut Graph<'f>,
    frame: &'f Frame<'f>,
    of_scene: &OfScene<'f>,
    before: &mut Before<'_>,
) -> Result<(), RenderError> {
    let (sides, at) = (std::mem::take(&mut before.around), before.probes);
    before.probes += 1;
    let (Some((_, surroundings)), Some((view, probes))) = (of_scene.surroundings, of_scene.probes) else {
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
    of_scene: &OfScene<'f>,
    view: RecordedView<'_, 'f>,
    before: &mut Before<'f>,
    purpose: &Purpose<'_>,
) -> Result<Recorded, RenderError> {
    let RecordedView { asked, state, ready, overlay } = view;
    let OfScene { scene, water, doors, particles, .. } = of_scene;
    let request = &asked.request;
    if matches!(purpose, Purpose::Variables) {
        let mut r = Recorder::new(graph, frame, &ready.view);
        let outputs = frame::variable_passes(&mut r, &request.settings, &ready.variables)?;
        return Ok(Recorded { variables: AovExports::new(r.graph, outputs), ..Recorded::default() });
    }
    let (variables, of_view) = match &ready.variables_view {
        Some(view) => {
            let mut r = Recorder::new(graph, frame, view);
            (Some(frame::variable_passes(&mut r, &request.settings, &ready.variables)?), ready.of_effects)
        }
        None => (None, ready.variables.and(&ready.of_effects)),
    };
    let mut r = Recorder::new(graph, frame, &ready.view);
    if matches!(purpose, Purpose::Pairs(_)) {
        return record_pairs(&mut r, asked);
    }
    let layers = SceneLayers {
        mirrors: before.mirrors(asked, ready),
        water: water.shown((*scene, &frame.resources.textures), (asked, ready), &mut before.behind),
        portals: doors.shown(asked, &mut before.through),
        particles: particles.clone(),
    };
    let outputs = match &asked.part {
        ViewPart::Whole => frame::view_passes(&mut r, &request.settings, &of_view, &layers)?,
        ViewPart::Mirror(view) => {
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &layers)?;
            record_mirrored(&mut r, view, asked, outputs, before)?;
            return Ok(Recorded::default());
        }
        ViewPart::Side(side) => {
            let ViewOutputs { radiance, .. } = frame::view_passes(&mut r, &request.settings, &of_view, &layers)?;
            before.sides.insert(*side, radiance);
            return Ok(Recorded::default());
        }
        ViewPart::Probe(_) => {
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &layers)?;
            if let ViewOutputs { radiance, gbuffer: Some(Gbuffer { linear_depth, .. }), .. } = outputs {
                before.around.push(ProbeSide { radiance, linear_depth });
            }
            if before.around.len() == FACES.len() {
                record_probe(graph, frame, of_scene, before)?;
            }
            return Ok(Recorded::default());
        }
        ViewPart::Face(face) => {
            let ViewOutputs { radiance, .. } = frame::view_passes(&mut r, &request.settings, &of_view, &layers)?;
            let uv_from_place = uv_from_place(face, request, asked.size);
            before.faces.push(FaceRadiance { side: face.side, radiance, uv_from_place });
            return Ok(Recorded::default());
        }
        ViewPart::Monitor(view) => {
            darken_monitors(&mut r, scene, view);
            let outputs = frame::view_passes(&mut r, &request.settings, &of_view, &layers)?;
            before.seen.push(record_monitored(&mut r, view, (asked, state, ready), outputs, purpose)?);
            return Ok(Recorded::default());
        }
        ViewPart::Fisheye(of_fisheye) => {
            frame::fisheye_passes(&mut r, &of_fisheye.lens, request.sample(), std::mem::take(&mut before.faces))?
        }
    };
    let outputs = frame::temporal_passes(&mut r, &request.settings, ready.temporal.as_ref(), outputs)?;
    let (mut r, outputs) = match &ready.enlarged_view {
        Some(view) => {
            let outputs = frame::enlarged_passes(&mut r, view.size, outputs)?;
            (Recorder::new(graph, frame, view), outputs)
        }
        None => (r, outputs),
    };
    let mut outputs = frame::effect_passes(&mut r, &request.effects, outputs)?;
    let recorded = record_picture(&mut r, (asked, state, ready), overlay.as_ref(), &mut outputs, purpose)?;
    let variables = if asked.wants_variables {
        AovExports::new(r.graph, variables.unwrap_or(outputs))
    } else {
        AovExports::default()
    };
    Ok(Recorded { variables, ..recorded })
}

/// Counts the pairs of a view; none of a fisheye, whose sides are counted.
fn record_pairs(r: &mut Recorder<'_, '_>, asked: &Asked) -> Result<Recorded, RenderError> {
    if asked.part.is_fisheye() {
        return Ok(Recorded::default());
    }
    let pairs = frame::pair_passes(r, &asked.request.settings)?;
    Ok(Recorded { export: Some(r.graph.export(pairs)), ..Recorded::default() })
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
    asked: &Asked,
    outputs: ViewOutputs,
    before: &mut Before<'_>,
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
    (asked, state, ready): (&'f Asked, &mut ViewState, &'f Ready),
    outputs: ViewOutputs,
    purpose: &Purpose<'_>,
) -> Result<Seen<'f>, RenderError> {
    let request = &asked.request;
    let outputs = frame::temporal_passes(r, &request.settings, ready.temporal.as_ref(), outputs)?;
    let ViewOutputs { radiance, depth, .. } = outputs;
    let adapting = request.adapting(state.adapted.is_some());
    let adapted = frame::exposure_passes(r, adapting.as_ref(), &radiance)?;
    let (previous_sum, settles) = (asked.previous_sum(state), adaptive_step(asked, ready) != adaptive::Step::None);
    let output = if asked.has_output() {
        output_of(r.frame.gpu, asked, &mut state.output, (purpose, settles), false)
    } else {
        None
    };
    let means = output.map_or(Means::None, |output| output.means(r.graph, asked.means_of, previous_sum));
    let settling = output.filter(|_| settles).and_then(|output| output.settling(r.graph));
    Ok(Seen { view, asked, ready, radiance, depth, means, settling, adapted })
}

/// What becomes of the radiance of a view whose picture is shown, or metered alone.
fn record_picture<'f>(
    r: &mut Recorder<'_, 'f>,
    (asked, state, ready): (&'f Asked, &mut ViewState, &'f Ready),
    overlay: Option<&OverlayDraw>,
    outputs: &mut ViewOutputs,
    purpose: &Purpose<'_>,
) -> Result<Recorded, RenderError> {
    let request = &asked.request;
    let has_tint = outputs.tint.is_some();
    let (mut export, mut adapted) = (None, None);
    let previous_sum = asked.previous_sum(state);
    let step = adaptive_step(asked, ready);
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
                target: target_of(purpose),
                is_shown: !matches!(purpose, Purpose::Sample),
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
    Ok(Recorded { variables: AovExports::default(), export, adapted, has_tint })
}

/// What the view does after this sample.
fn adaptive_step(asked: &Asked, ready: &Ready) -> adaptive::Step {
    if ready.is_adaptive { asked.adaptive_step() } else { adaptive::Step::None }
}

fn target_of<'t>(purpose: &Purpose<'t>) -> Option<&'t Target> {
    if let Purpose::Target(target) = purpose { Some(target) } else { None }
}
