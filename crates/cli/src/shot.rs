//! One picture of a sequence: the time and the pose of its scene, and from where it is seen.

use crate::args::RenderArgs;
use crate::camera;
use crate::failure::Failure;
use crate::job::Job;
use crate::listing::choices;
use crate::looks::Look;
use manypass::{Adaptation, Aov, EffectFile, Pose, View};
use manypass_scene::particles::Particles;
use manypass_scene::water::Water;
use manypass_scene::{Framing, Scene};
use std::sync::Arc;

/// What an automatic camera shows whole in every picture of a scene, whichever are drawn: where a time, frames or an
/// animation are asked for, everything over the whole animation.
pub fn framing(scene: &mut Scene, args: &RenderArgs) -> Result<Framing, Failure> {
    let framing = match animation(scene, args)? {
        Some(index) => Framing::of_animation(scene, index),
        None => Framing::of_scene(scene),
    };
    // A turntable takes no camera of the file; a room turns around who stands in it.
    let turns_by_itself = args.turntable.is_some() && args.frame.orbit.is_none();
    let is_automatic = args.frame.camera.as_deref() == Some(camera::AUTOMATIC);
    Ok(if turns_by_itself || is_automatic { framing.looking_inside(scene) } else { framing })
}

/// The camera at a frame of a turntable, of which a full turn takes as many frames as `--turntable` says; elsewhere all
/// frames have the same.
pub fn view(
    scene: &Scene,
    framing: &Framing,
    args: &RenderArgs,
    (job, look): (&Job, &Look),
    frame: f32,
) -> Result<View, Failure> {
    // A frame is the same whether it is drawn alone or in a range, and after a full turn as before.
    let turn_deg = args.turntable.map_or(0.0, |count| 360.0 * (frame.rem_euclid(count as f32) / count as f32));
    let aspect = job.width as f32 / job.height as f32;
    let (world_from_view, projection) = camera::resolve(&look.camera, scene, framing, aspect, turn_deg)?;
    Ok(View { world_from_view, projection })
}

/// Puts the scene as it is at a moment of a frame while the shutter is open, from −0.5 when it opens to 0.5 when it
/// closes, and gives the camera; the frame is at 0.
pub fn moment(
    scene: &mut Scene,
    framing: &Framing,
    args: &RenderArgs,
    (job, look): (&Job, &Look),
    frame: u32,
    (shutter_deg, position): (f32, f32),
) -> Result<View, Failure> {
    let frames = position * shutter_deg / 360.0;
    pose(scene, args, Some(time_secs(args, frame).unwrap_or(0.0) + frames * step_secs(args)))?;
    view(scene, framing, args, (job, look), frame as f32 + frames)
}

/// Whether anything can move from frame to frame.
pub fn moves(scene: &Scene, args: &RenderArgs) -> bool {
    let is_animated = !scene.animations.is_empty() || has_waves(scene);
    let plays = args.time.is_some() || args.frames.is_some() || args.animation.is_some();
    args.turntable.is_some() || is_animated && plays
}

/// Whether time alone moves anything: waves, or a simulation.
pub fn has_waves(scene: &Scene) -> bool {
    scene.water.iter().any(Water::has_waves) || scene.has_simulations()
}

/// What to say where particles are to be seen and nobody asks for a time: the first are born at 0.
pub fn unborn_hint(scene: &Scene, args: &RenderArgs) -> Option<String> {
    let life_secs = scene.particles.iter().map(Particles::life_secs).reduce(f32::max)?;
    let is_timed = args.time.is_some_and(|secs| secs != 0.0) || args.frames.is_some();
    (!is_timed)
        .then(|| format!("its particles are born from time 0 on, and none is there yet; --time {life_secs} shows them"))
}

/// What `camera.focus_m` is where nobody says: the distance of what the camera is told to look at, or else of the middle
/// of everything over the whole animation, so that a sequence keeps its focus.
pub fn focus_m(scene: &Scene, framing: &Framing, look: &Look, camera: &View) -> f32 {
    let target = look.camera.in_world_at(scene.origin_m).target_world();
    let target_m = target.map(|target| camera.distance_m(target)).filter(|distance_m| *distance_m > 0.0);
    target_m.unwrap_or_else(|| camera.automatic_focus_m(framing.bounds_world()))
}

/// The time from one frame to the next.
fn step_secs(args: &RenderArgs) -> f32 {
    // A turntable at one time turns the camera, and the time stands still.
    if args.frames.is_none() && args.turntable.is_some() { 0.0 } else { 1.0 / args.fps }
}

/// How the exposure of a frame follows from that of the frame before, if it is not the first.
pub fn adaptation(args: &RenderArgs, is_first: bool) -> Adaptation {
    match (args.frames.is_some() || args.turntable.is_some(), is_first) {
        (false, _) => Adaptation::Still,
        (true, true) => Adaptation::Begins,
        (true, false) => Adaptation::After { secs: 1.0 / args.fps },
    }
}

/// The frame before, if motion is asked for, or `effects` read it, and anything can have moved. It leaves the scene in
/// that pose.
pub fn previous_pose(
    scene: &mut Scene,
    framing: &Framing,
    (args, effects): (&RenderArgs, &[EffectFile]),
    (job, look): (&Job, &Look),
    frame: u32,
) -> Result<Option<Arc<Pose>>, Failure> {
    let time_secs = time_secs(args, frame).map(|time_secs| time_secs - step_secs(args));
    let is_still = time_secs.is_none() && args.turntable.is_none();
    let is_read =
        job.aovs.iter().any(|name| name == Aov::Motion.name()) || effects.iter().any(EffectFile::reads_motion);
    if is_still || !is_read {
        return Ok(None);
    }
    pose(scene, args, time_secs)?;
    let camera = view(scene, framing, args, (job, look), frame as f32 - 1.0)?;
    Ok(Some(Arc::new(Pose::capture(scene, camera))))
}

/// The time of a frame, if a time or frames are asked for.
pub fn time_secs(args: &RenderArgs, frame: u32) -> Option<f32> {
    if args.frames.is_some() { Some(frame as f32 / args.fps) } else { args.time }
}

/// Poses the scene where a time, frames or an animation are asked for.
pub fn pose(scene: &mut Scene, args: &RenderArgs, time_secs: Option<f32>) -> Result<(), Failure> {
    // What moves without keyframes, too.
    scene.time_secs = time_secs.unwrap_or(0.0);
    if let Some(index) = animation(scene, args)? {
        scene.pose(index, time_secs.unwrap_or(0.0));
        scene.update_transforms();
    }
    Ok(())
}

/// The animation that is asked for; the first where only a time or frames are.
fn animation(scene: &Scene, args: &RenderArgs) -> Result<Option<usize>, Failure> {
    let named = |name: &String| scene.animations.iter().position(|a| a.name == *name).or_else(|| name.parse().ok());
    let is_timed = args.time.is_some() || args.frames.is_some();
    let index = match &args.animation {
        // The caller warns of it: a batch may well hold models that stand still.
        _ if scene.animations.is_empty() => return Ok(None),
        None if !is_timed => return Ok(None),
        None => Some(0),
        Some(name) => named(name),
    };
    let index = index.filter(|index| *index < scene.animations.len()).ok_or_else(|| {
        let names = scene.animations.iter().map(|animation| animation.name.as_str()).enumerate();
        let asked = args.animation.as_deref().unwrap_or_default();
        Failure::usage(format!("there is no animation `{asked}`"), choices("animations", names))
    })?;
    Ok(Some(index))
}
