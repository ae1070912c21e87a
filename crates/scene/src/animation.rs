//! Skins, and animations evaluated at a given time.

mod property;

pub use property::{
    CameraProperty, LightProperty, MaterialFactor, Property, PropertyChannel, TextureSlot, TransformPart,
};

use crate::skins::PosedSkins;
use crate::{Aabb, Node, NodeId, Scene};
use glam::{Mat4, Quat, Vec3};

/// The joints that deform a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// The nodes whose transforms deform the mesh.
    pub joints: Vec<NodeId>,
    /// `joint_from_mesh` in the bind pose, one a joint.
    pub inverse_bind_matrices: Vec<Mat4>,
}

/// The interpolation between two keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The earlier value holds.
    Step,
    /// Linear; spherical for rotations.
    Linear,
    /// Cubic Hermite splines; every keyframe holds in-tangent, value, out-tangent.
    CubicSpline,
}

/// The values of a channel, one a keyframe, or three with [`Interpolation::CubicSpline`].
#[derive(Clone, Debug, PartialEq)]
pub enum Keyframes {
    /// Translations in metres.
    Translation(Vec<Vec3>),
    /// Rotations.
    Rotation(Vec<Quat>),
    /// Scales.
    Scale(Vec<Vec3>),
    /// Weights of morph targets, all of a keyframe together.
    MorphWeights {
        /// The weights of a keyframe: the number of morph targets.
        count: usize,
        /// All weights, keyframe by keyframe.
        values: Vec<f32>,
    },
}

/// One animated property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The node that moves.
    pub node: NodeId,
    /// The times of the keyframes in seconds, ascending.
    pub times_secs: Vec<f32>,
    /// What happens between keyframes.
    pub interpolation: Interpolation,
    /// The values.
    pub keyframes: Keyframes,
}

/// A named set of channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// The channels that move nodes.
    pub channels: Vec<Channel>,
    /// The channels of all else.
    pub properties: Vec<PropertyChannel>,
}

impl Animation {
    /// The time of the last keyframe in seconds; 0 without channels.
    pub fn duration_secs(&self) -> f32 {
        let of_nodes = self.channels.iter().map(|channel| &channel.times_secs);
        let times = of_nodes.chain(self.properties.iter().map(|channel| &channel.times_secs));
        times.filter_map(|times_secs| times_secs.last()).fold(0.0, |end, &time| end.max(time))
    }
}

/// The keyframes around a time: `from`, `to`, the fraction between them and their distance in seconds.
struct Span {
    from: usize,
    to: usize,
    fraction: f32,
    length_secs: f32,
}

fn span(times_secs: &[f32], time_secs: f32) -> Option<Span> {
    let last = times_secs.len().checked_sub(1)?;
    let time_secs = if time_secs.is_finite() { time_secs } else { 0.0 };
    let to = times_secs.partition_point(|&key_secs| key_secs <= time_secs);
    let from = to.saturating_sub(1);
    if to == 0 || to > last {
        return Some(Span { from, to: from, fraction: 0.0, length_secs: 0.0 });
    }
    let (start_secs, end_secs) = (*times_secs.get(from)?, *times_secs.get(to)?);
    let length_secs = end_secs - start_secs;
    Some(Span { from, to, fraction: ((time_secs - start_secs) / length_secs).clamp(0.0, 1.0), length_secs })
}

/// The weights of value, out-tangent, next value and next in-tangent of a cubic Hermite spline (glTF 2.0, appendix
/// C.4).
fn hermite(span: &Span) -> [f32; 4] {
    let t = span.fraction;
    let (t2, t3) = (t * t, t * t * t);
    [
        2.0 * t3 - 3.0 * t2 + 1.0,
        span.length_secs * (t3 - 2.0 * t2 + t),
        -2.0 * t3 + 3.0 * t2,
        span.length_secs * (t3 - t2),
    ]
}

fn sample<T: Copy>(
    values: &[T],
    interpolation: Interpolation,
    span: &Span,
    linear: impl Fn(T, T, f32) -> T,
    sum: impl Fn([(T, f32); 4]) -> T,
) -> Option<T> {
    let get = |i: usize| values.get(i).copied();
    match interpolation {
        Interpolation::Step => get(span.from),
        Interpolation::Linear => Some(linear(get(span.from)?, get(span.to)?, span.fraction)),
        Interpolation::CubicSpline if span.from == span.to => get(3 * span.from + 1),
        Interpolation::CubicSpline => {
            let [value, tangent, next_value, next_tangent] = hermite(span);
            Some(sum([
                (get(3 * span.from + 1)?, value),
                (get(3 * span.from + 2)?, tangent),
                (get(3 * span.to + 1)?, next_value),
                (get(3 * span.to)?, next_tangent),
            ]))
        }
    }
}

/// Where a node is, seen from the one above it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LocalTransform {
    translation: Vec3,
    rotation: Quat,
    scale: Vec3,
}

impl Channel {
    /// What it makes of where a node is.
    fn moved(&self, mut local: LocalTransform, time_secs: f32) -> LocalTransform {
        let Some(span) = span(&self.times_secs, time_secs) else { return local };
        match &self.keyframes {
            Keyframes::Translation(values) => {
                local.translation = sample_vec3(values, self.interpolation, &span).unwrap_or(local.translation);
            }
            Keyframes::Rotation(values) => {
                local.rotation = sample_quat(values, self.interpolation, &span).unwrap_or(local.rotation);
            }
            Keyframes::Scale(values) => {
                local.scale = sample_vec3(values, self.interpolation, &span).unwrap_or(local.scale);
            }
            Keyframes::MorphWeights { .. } => {}
        }
        local
    }
}

/// How a node moves in an animation, with all above it.
#[derive(Clone, Debug)]
pub struct Path<'s> {
    /// From the node upwards.
    links: Vec<Link<'s>>,
}

#[derive(Clone, Debug)]
struct Link<'s> {
    node: &'s Node,
    channels: Vec<&'s Channel>,
}

impl Path<'_> {
    /// [`Node::world_from_object`] at a time; what the animation does not move is as it is.
    pub fn world_from_object(&self, time_secs: f32) -> Mat4 {
        let local = |link: &Link<'_>| {
            let Link { node: Node { translation, rotation, scale, .. }, channels } = link;
            let local = LocalTransform { translation: *translation, rotation: *rotation, scale: *scale };
            let local = channels.iter().fold(local, |local, channel| channel.moved(local, time_secs));
            Mat4::from_scale_rotation_translation(local.scale, local.rotation, local.translation)
        };
        self.links.iter().rev().fold(Mat4::IDENTITY, |matrix, link| matrix * local(link))
    }

    /// Whether the animation moves it.
    pub fn moves(&self) -> bool {
        self.links.iter().any(|link| !link.channels.is_empty())
    }
}

fn sample_vec3(values: &[Vec3], interpolation: Interpolation, span: &Span) -> Option<Vec3> {
    let sum = |terms: [(Vec3, f32); 4]| terms.iter().map(|&(value, weight)| value * weight).sum();
    sample(values, interpolation, span, Vec3::lerp, sum)
}

fn sample_quat(values: &[Quat], interpolation: Interpolation, span: &Span) -> Option<Quat> {
    let unit = |q: Quat| if q.length_squared() > 1e-12 { q.normalize() } else { Quat::IDENTITY };
    let sum = |terms: [(Quat, f32); 4]| terms.iter().fold(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), |q, t| q + t.0 * t.1);
    sample(values, interpolation, span, |a, b, t| unit(a).slerp(unit(b), t), sum).map(unit)
}

fn sample_weights(values: &[f32], count: usize, interpolation: Interpolation, span: &Span) -> Option<Vec<f32>> {
    let keys_a_frame = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let key = |frame: usize, part: usize, i: usize| values.get((frame * keys_a_frame + part) * count + i).copied();
    let sample_one = |i: usize| {
        // The keyframes of one weight, gathered so that `from` and `to` lie side by side.
        let local = Span { from: 0, to: usize::from(span.to != span.from), ..*span };
        let mut gathered = [0.0; 6];
        for (frame, index) in [span.from, span.to].into_iter().enumerate() {
            for part in 0..keys_a_frame {
                *gathered.get_mut(frame * keys_a_frame + part)? = key(index, part, i)?;
            }
        }
        let sum = |terms: [(f32, f32); 4]| terms.iter().map(|&(value, weight)| value * weight).sum();
        sample(&gathered, interpolation, &local, |a, b, t| a + (b - a) * t, sum)
    };
    (0..count).map(sample_one).collect()
}

impl Scene {
    /// Sets all that is animated to its value at a time; before the first keyframe and after the last
    /// they stay as there. Call [`Scene::update_transforms`] afterwards. An animation that does not exist does nothing.
    pub fn pose(&mut self, animation: usize, time_secs: f32) {
        self.time_secs = time_secs;
        self.posed = Some(animation);
        self.pose_properties(animation, time_secs);
        let Self { nodes, animations, .. } = self;
        for channel in animations.get(animation).into_iter().flat_map(|animation| &animation.channels) {
            let index = channel.node.0 as usize;
            let Some(node) = nodes.get(index) else { continue };
            // Nodes that stay as they are are not borrowed to change them.
            if let Keyframes::MorphWeights { count, values } = &channel.keyframes {
                let weights = span(&channel.times_secs, time_secs)
                    .and_then(|span| sample_weights(values, *count, channel.interpolation, &span));
                if let Some(weights) = weights.filter(|weights| *weights != node.morph_weights) {
                    nodes[index].morph_weights = weights;
                }
            } else {
                let known =
                    LocalTransform { translation: node.translation, rotation: node.rotation, scale: node.scale };
                let local = channel.moved(known, time_secs);
                if local != known {
                    let node = &mut nodes[index];
                    (node.translation, node.rotation, node.scale) = (local.translation, local.rotation, local.scale);
                }
            }
        }
    }

    /// How a node moves in the animation that was last posed, with all above it.
    pub fn path_of(&self, id: NodeId) -> Path<'_> {
        let channels = self.posed.and_then(|index| self.animations.get(index)).map_or(&[][..], |posed| &posed.channels);
        let (mut links, mut next) = (Vec::new(), Some(id));
        while let Some((id, node)) = next.and_then(|id| Some((id, self.nodes.get(id.0 as usize)?))) {
            let own = channels.iter().filter(|channel| channel.node == id);
            links.push(Link { node, channels: own.collect() });
            // A tree has no way that is longer.
            next = node.parent.filter(|_| links.len() < self.nodes.len());
        }
        Path { links }
    }

    /// `world_from_mesh` of every joint: the joint's `world_from_object` times its inverse bind matrix, as of the last
    /// [`Scene::update_transforms`]. Empty for a skin that does not exist.
    pub fn joint_matrices(&self, skin: usize) -> Vec<Mat4> {
        let Some(skin) = self.skins.get(skin) else { return Vec::new() };
        let inverse_binds = skin.inverse_bind_matrices.iter().copied().chain(std::iter::repeat(Mat4::IDENTITY));
        let joints = skin.joints.iter().zip(inverse_binds);
        joints
            .map(|(joint, inverse_bind)| {
                let node = self.nodes.get(joint.0 as usize);
                node.map_or(Mat4::IDENTITY, |node| node.world_from_object) * inverse_bind
            })
            .collect()
    }

    /// A box in world space around everything that is drawn, posed by skins and morph targets, as of the last
    /// [`Scene::update_transforms`]; it may be too large, never too small.
    pub fn posed_bounds_world(&self) -> Aabb {
        self.visible_nodes().into_iter().fold(Aabb::EMPTY, |bounds, id| bounds.union(&self.node(id).bounds_world))
    }

    /// What [`Node::bounds_world`] is to be.
    pub(crate) fn posed_bounds_of(&self, node: &Node, skins: &mut PosedSkins) -> Aabb {
        let Some((index, mesh)) = node.mesh.and_then(|index| Some((index, self.meshes.get(index)?))) else {
            return Aabb::EMPTY;
        };
        let weights = if node.morph_weights.is_empty() { &mesh.default_morph_weights } else { &node.morph_weights };
        let mut bounds = Aabb::EMPTY;
        for (slot, primitive) in mesh.primitives.iter().enumerate() {
            let mut local = primitive.bounds;
            for (target, &weight) in primitive.morph_targets.iter().zip(weights) {
                let deltas = target.positions.iter().map(|&delta| Vec3::from(delta) * weight);
                let reach = Aabb::from_points(deltas.chain([Vec3::ZERO]));
                local = Aabb { min: local.min + reach.min, max: local.max + reach.max };
            }
            let posed = match node.skin.filter(|_| !primitive.joints.is_empty()) {
                Some(skin) if primitive.morph_targets.is_empty() => skins.bounds_of((skin, index, slot), &local, self),
                Some(skin) => skins.bounds(skin, &local, self),
                None => local.transformed(&node.world_from_object),
            };
            bounds = bounds.union(&posed);
        }
        bounds
    }
}
