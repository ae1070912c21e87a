//! The vertices that a scene draws, in world space, in one pose or in those of an animation.

use crate::turns::{Turns, at_once, give_turn};
use crate::{Node, NodeId, Primitive, Scene};
use glam::{Mat4, Quat, Vec3};
use std::sync::Arc;

/// Above so many posed vertices their boxes are framed: 120 MB of them.
const MOST_VERTICES: usize = 10_000_000;

/// So many times of an animation are looked at.
const TIMES: u16 = 32;

/// The vertices as of the last [`Scene::update_transforms`].
pub(super) fn posed(scene: &Scene) -> Vec<Vec3> {
    at_once(posed_in_turns(scene, &mut || None))
}

/// As [`posed`]; `turns` is asked after every primitive.
pub(super) async fn posed_in_turns(scene: &Scene, turns: &mut Turns<'_>) -> Vec<Vec3> {
    for has_vertices in [true, false] {
        let mut collector = Collector::new(scene, has_vertices, turns).await;
        if collector.add(scene, turns).await {
            return collector.points;
        }
    }
    Vec::new()
}

/// The vertices over an animation; of the pose as it is where there is no such animation.
pub(super) fn animated(scene: &mut Scene, animation: usize) -> Vec<Vec3> {
    let Some((start_secs, end_secs)) = span_secs(scene, animation) else { return posed(scene) };
    let last = if end_secs > start_secs { TIMES - 1 } else { 0 };
    let times = (0..=last).map(|i| start_secs + (end_secs - start_secs) * f32::from(i) / f32::from(last.max(1)));
    let times: Vec<f32> = times.collect();
    let (kept, time_secs) = (kept_properties(scene, animation), scene.time_secs);
    let mut collect = |has_vertices| {
        let mut collector = at_once(Collector::new(scene, has_vertices, &mut || None));
        for at_secs in &times {
            scene.pose(animation, *at_secs);
            scene.update_transforms();
            if !at_once(collector.add(scene, &mut || None)) {
                return None;
            }
        }
        Some(collector.points)
    };
    let points = collect(true).or_else(|| collect(false)).unwrap_or_default();
    for (id, translation, rotation, scale, morph_weights) in kept {
        let node = scene.node_mut(id);
        (node.translation, node.rotation, node.scale, node.morph_weights) =
            (translation, rotation, scale, morph_weights);
    }
    scene.time_secs = time_secs;
    scene.update_transforms();
    points
}

/// The times of the first and of the last keyframe.
fn span_secs(scene: &Scene, animation: usize) -> Option<(f32, f32)> {
    let animation = scene.animations.get(animation)?;
    let starts = animation.channels.iter().filter_map(|channel| channel.times_secs.first().copied());
    Some((starts.reduce(f32::min)?, animation.duration_secs()))
}

/// What an animation changes, as it is now.
fn kept_properties(scene: &Scene, animation: usize) -> Vec<(NodeId, Vec3, Quat, Vec3, Vec<f32>)> {
    let channels = scene.animations.get(animation).map_or(&[][..], |animation| &animation.channels);
    let mut ids: Vec<NodeId> = channels.iter().map(|channel| channel.node).collect();
    ids.sort_unstable();
    ids.dedup();
    let properties = ids.into_iter().filter_map(|id| {
        let node = scene.nodes.get(id.0 as usize)?;
        Some((id, node.translation, node.rotation, node.scale, node.morph_weights.clone()))
    });
    properties.collect()
}

/// How a node's mesh was posed when its vertices were added.
#[derive(Clone, Debug)]
struct NodePose {
    world_from_object: Mat4,
    morph_weights: Vec<f32>,
    /// Those of [`Collector::skins`]; none without a skin.
    joints: Option<Arc<[Mat4]>>,
}

impl NodePose {
    /// Whether the other is the same pose. Joints that stayed are the same in memory, too.
    fn is(&self, other: &Self) -> bool {
        let is_same_skin = match (&self.joints, &other.joints) {
            (Some(joints), Some(others)) => Arc::ptr_eq(joints, others),
            (joints, others) => joints.is_none() && others.is_none(),
        };
        is_same_skin && self.world_from_object == other.world_from_object && self.morph_weights == other.morph_weights
    }
}

/// Gathers vertices pose by pose. What has not moved since the pose before is not added again.
struct Collector {
    /// Of each mesh and primitive, the vertices that its indices name; nothing where all are drawn.
    drawn: Vec<Vec<Option<Vec<u32>>>>,
    has_vertices: bool,
    last: Vec<Option<NodePose>>,
    /// The joints of each skin, which its nodes share; as they were where none has moved.
    skins: Vec<Arc<[Mat4]>>,
    points: Vec<Vec3>,
}

impl Collector {
    async fn new(scene: &Scene, has_vertices: bool, turns: &mut Turns<'_>) -> Self {
        let mut drawn = Vec::new();
        for mesh in scene.meshes.iter().filter(|_| has_vertices) {
            let mut of_mesh = Vec::with_capacity(mesh.primitives.len());
            for primitive in &mesh.primitives {
                of_mesh.push(drawn_vertices(primitive));
                give_turn(turns).await;
            }
            drawn.push(of_mesh);
        }
        let skins: Vec<Arc<[Mat4]>> = vec![Arc::default(); scene.skins.len()];
        Self { drawn, has_vertices, last: vec![None; scene.nodes.len()], skins, points: Vec::new() }
    }

    /// Adds what has moved. False where there would be too many vertices.
    async fn add(&mut self, scene: &Scene, turns: &mut Turns<'_>) -> bool {
        for (skin, known) in self.skins.iter_mut().enumerate() {
            let joints = scene.joint_matrices(skin);
            if known[..] != joints[..] {
                *known = joints.into();
            }
        }
        for id in scene.visible_nodes() {
            let node = scene.node(id);
            let Some((index, mesh)) = node.mesh.and_then(|index| Some((index, scene.meshes.get(index)?))) else {
                continue;
            };
            let own = if node.morph_weights.is_empty() { &mesh.default_morph_weights } else { &node.morph_weights };
            let posed = NodePose {
                world_from_object: node.world_from_object,
                morph_weights: own.clone(),
                joints: node.skin.and_then(|skin| self.skins.get(skin)).cloned(),
            };
            let Some(last) = self.last.get_mut(id.0 as usize) else { continue };
            if last.as_ref().is_some_and(|last| last.is(&posed)) {
                continue;
            }
            for (slot, primitive) in mesh.primitives.iter().enumerate() {
                let named = self.drawn.get(index).and_then(|mesh| mesh.get(slot)?.as_deref());
                if !self.has_vertices {
                    push_box(&mut self.points, node, primitive);
                } else if self.points.len() + named.map_or(primitive.positions.len(), <[u32]>::len) > MOST_VERTICES {
                    return false;
                } else {
                    push_vertices(&mut self.points, &posed, primitive, named);
                    give_turn(turns).await;
                }
            }
            *last = Some(posed);
        }
        true
    }
}

/// The vertices that the indices of a primitive name, in ascending order; nothing if they are all of them.
fn drawn_vertices(primitive: &Primitive) -> Option<Vec<u32>> {
    if primitive.indices.is_empty() {
        return None;
    }
    let mut is_drawn = vec![false; primitive.positions.len()];
    for index in &primitive.indices {
        if let Some(is_drawn) = is_drawn.get_mut(*index as usize) {
            *is_drawn = true;
        }
    }
    if is_drawn.iter().all(|is_drawn| *is_drawn) {
        return None;
    }
    Some((0..).zip(is_drawn).filter(|(_, is_drawn)| *is_drawn).map(|(index, _)| index).collect())
}

fn push_box(points: &mut Vec<Vec3>, node: &Node, primitive: &Primitive) {
    let is_rigid = primitive.morph_targets.is_empty() && (node.skin.is_none() || primitive.joints.is_empty());
    let (bounds, world_from_bounds) = match is_rigid {
        true => (primitive.bounds, node.world_from_object),
        false => (node.bounds_world, Mat4::IDENTITY),
    };
    if !bounds.is_empty() {
        points.extend(bounds.corners().map(|corner| world_from_bounds.transform_point3(corner)));
    }
}

fn push_vertices(points: &mut Vec<Vec3>, posed: &NodePose, primitive: &Primitive, named: Option<&[u32]>) {
    let world_from_object = posed.world_from_object;
    points.reserve(named.map_or(primitive.positions.len(), <[u32]>::len));
    let matrices = posed.joints.as_deref().unwrap_or_default();
    let is_skinned = !matrices.is_empty() && !primitive.joints.is_empty();
    if !is_skinned && primitive.morph_targets.is_empty() {
        let place = |position: &[f32; 3]| world_from_object.transform_point3(Vec3::from(*position));
        match named {
            None => points.extend(primitive.positions.iter().map(place)),
            Some(named) => points.extend(named.iter().filter_map(|i| primitive.positions.get(*i as usize)).map(place)),
        }
        return;
    }
    let place = |index: usize| {
        let mut position = Vec3::from(*primitive.positions.get(index)?);
        for (target, weight) in primitive.morph_targets.iter().zip(&posed.morph_weights) {
            position += target.positions.get(index).map_or(Vec3::ZERO, |delta| Vec3::from(*delta) * *weight);
        }
        let share = |(joint, share): (&u16, &f32)| {
            if *share == 0.0 {
                return None;
            }
            Some(matrices.get(usize::from(*joint))?.transform_point3(position) * *share)
        };
        Some(match (is_skinned, primitive.joints.get(index), primitive.weights.get(index)) {
            (true, Some(joints), Some(shares)) => joints.iter().zip(shares).filter_map(share).sum(),
            _ => world_from_object.transform_point3(position),
        })
    };
    match named {
        None => points.extend((0..primitive.positions.len()).filter_map(place)),
        Some(named) => points.extend(named.iter().filter_map(|index| place(*index as usize))),
    }
}
