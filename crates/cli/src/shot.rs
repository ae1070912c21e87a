//! One picture of a sequence: the time and the pose of its scene, and from where it is seen.

use crate::args::RenderArgs;
use crate::camera;
use crate::failure::Failure;
use crate::job::Job;
use crate::listing::choices;
use manypass::{Aov, Pose, View};
use manypass_scene::{Aabb, Scene};
use std::sync::Arc;

/// The camera at a frame of a turntable; elsewhere all frames have the same.
pub fn view(scene: &Scene, bounds: &Aabb, args: &RenderArgs, job: &Job, frame: f32) -> Result<View, Failure> {
    let turn_deg = args.turntable.map_or(0.0, |count| 360.0 * frame / count as f32);
    let aspect = job.width as f32 / job.height as f32;
    let (world_from_view, projection) = camera::resolve(&job.camera, scene, bounds, aspect, turn_deg)?;
    Ok(View { world_from_view, projection })
}

/// The frame before, if motion is asked for and anything can have moved. It leaves the scene in that pose.
pub fn previous_pose(
    scene: &mut Scene,
    bounds: &Aabb,
    args: &RenderArgs,
    job: &Job,
    frame: u32,
) -> Result<Option<Arc<Pose>>, Failure> {
    let time_secs = time_secs(args, frame).map(|time_secs| time_secs - 1.0 / args.fps);
    let is_still = time_secs.is_none() && args.turntable.is_none();
    if is_still || !job.aovs.iter().any(|name| name == Aov::Motion.name()) {
        return Ok(None);
    }
    pose(scene, args, time_secs)?;
    let camera = view(scene, bounds, args, job, frame as f32 - 1.0)?;
    Ok(Some(Arc::new(Pose::capture(scene, camera))))
}

/// The time of a frame, if a time or frames are asked for.
pub fn time_secs(args: &RenderArgs, frame: u32) -> Option<f32> {
    if args.frames.is_some() { Some(frame as f32 / args.fps) } else { args.time }
}

/// Poses the scene where a time, frames or an animation are asked for.
pub fn pose(scene: &mut Scene, args: &RenderArgs, time_secs: Option<f32>) -> Result<(), Failure> {
    let named = |name: &String| scene.animations.iter().position(|a| a.name == *name).or_else(|| name.parse().ok());
    let index = match &args.animation {
        // The caller warns of it: a batch may well hold models that stand still.
        _ if scene.animations.is_empty() => return Ok(()),
        None if time_secs.is_none() => return Ok(()),
        None => Some(0),
        Some(name) => named(name),
    };
    let index = index.filter(|index| *index < scene.animations.len()).ok_or_else(|| {
        let names = scene.animations.iter().map(|animation| animation.name.as_str()).enumerate();
        let asked = args.animation.as_deref().unwrap_or_default();
        Failure::usage(format!("there is no animation `{asked}`"), choices("animations", names))
    })?;
    scene.pose(index, time_secs.unwrap_or(0.0));
    scene.update_transforms();
    Ok(())
}
