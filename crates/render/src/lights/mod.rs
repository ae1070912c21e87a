//! lights: the table of lights, and the list of lights of every cluster.
//!
//! Clusters are tiles of the picture times slices of distance, spaced by powers and fitted to the scene's bounds
//! (Olsson, Billeter & Assarsson 2012, "Clustered Deferred and Forward Shading"). A light is put into a cluster if its
//! sphere touches the cluster's box in view space: for every slice the sphere's cross-section is a disc, for every row
//! of tiles the disc's chord gives the first and the last tile. The lists are built on the CPU, because the floor has
//! no compute. A spot must touch the cluster with its cone, too. They are kept from frame to frame while nothing
//! changes that they were made of; jitter is none of it, because a sample stays within its pixel. Writes: `lights`,
//! which holds the records of lists, too, and `cluster_lights`; read through `light_table.wgsl` alone.

mod cached_lists;
mod clusters;
mod decals;
mod grid;
mod lit;
mod objects;
mod reach;
mod reaches;
mod record;
mod settings;
mod small;
mod volumes;

pub use cached_lists::{CachedLists, LightListInputs};
pub use clusters::{ClusterLists, ClusterUniform, ListLimits};
pub(crate) use decals::DecalLists;
pub use grid::Target;
pub use lit::Rectangle;
pub use objects::ObjectBounds;
pub use reach::Reach;
pub use reaches::LightReaches;
pub use record::ListRecord;
pub use settings::{ClusterSettings, LightCulling, LightSettings};
pub use small::LeastLights;
#[cfg(test)]
pub use volumes::BALL_CORNER;
pub use volumes::{CONE_CORNER, CONE_SIDES, VolumeDraw, VolumeShape, VolumeStep, without_shadows};

use crate::colour::finite_product;
use crate::constants::{CASTING_POINTS, CASTING_SPOTS, LIGHTS_PER_ROW, TEXELS_PER_LIGHT};
use glam::{Vec3, Vec4};
use manypass_scene::{EnvironmentLight, LightKind, LightMode, NodeId, Scene};

/// More lights than this cannot be told apart in the 16 bits of the lists; those beyond are left out with a warning.
pub use manypass_scene::light::LIGHTS_MAX;

/// The constant of pipelines that says which classes of lights there are.
pub const LIGHT_CLASSES: &str = "light_classes";
/// Classes of lights that have a range and cast shadows.
pub const CASTING_LIGHTS: u32 = CASTING_POINTS | CASTING_SPOTS;

// Shaders find a light's column in the low byte of its index, and its row in the high one.
const _: () = assert!(LIGHTS_PER_ROW == 256);

/// What a table of lights is made for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TableOf {
    /// What intensities are multiplied by.
    pub pre_exposure: f32,
    /// What those of the scene's lights are multiplied by beside that, and that of the environment is not; not 0.
    pub lamp_scale: f32,
    /// (k, n): of the scene's lights only every n-th, beginning with the k-th.
    pub subset: Option<(u32, u32)>,
    /// The light of the environment, as it is turned and scaled; it is in every subset, as the rest of the environment
    /// is.
    pub environment: Option<EnvironmentLight>,
    /// How large lights have to be seen to keep their range; none if all do.
    pub least: Option<LeastLights>,
}

/// What one light of a table is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    /// None of the light of the environment.
    node: Option<NodeId>,
    kind: LightKind,
    color_linear: Vec3,
    intensity: f32,
    /// The range, if it has one that ends anywhere.
    range_m: Option<f32>,
    /// What is left of it, as a share, where the light is seen small; nothing of one that is left out.
    range_share: f32,
    radius_m: f32,
    casts_shadows: bool,
    /// The last two axes of the node's matrix: −direction, of any length, and place.
    z_axis: Vec3,
    position: Vec3,
}

impl Source {
    /// Whither it shines, of length 1.
    fn direction(&self) -> Vec3 {
        (-self.z_axis).normalize_or(Vec3::NEG_Z)
    }

    /// The same with as much of its range as `least` leaves.
    fn limited(self, least: &LeastLights) -> Self {
        match (self.kind, self.range_m) {
            (LightKind::Directional, _) | (_, None) => self,
            (kind, Some(range_m)) => {
                let range_share = least.share(kind, self.position, self.direction(), range_m);
                Self { range_share, ..self }
            }
        }
    }

    /// How far it reaches, in metres; none of one that is in no list.
    fn reach_m(&self) -> Option<f32> {
        self.range_m.map(|range_m| range_m * self.range_share)
    }
}

impl From<EnvironmentLight> for Source {
    fn from(light: EnvironmentLight) -> Self {
        Self {
            node: None,
            kind: LightKind::Directional,
            color_linear: light.irradiance,
            intensity: 1.0,
            range_m: None,
            range_share: 1.0,
            radius_m: light.half_angle_tan,
            casts_shadows: true,
            z_axis: light.direction,
            position: Vec3::ZERO,
        }
    }
}

/// The light of the environment, and those of the visible `nodes`.
fn sources(scene: &Scene, nodes: &[NodeId], of: &TableOf) -> impl Iterator<Item = Source> {
    let TableOf { lamp_scale, least, .. } = *of;
    let of_node = move |id: &NodeId| {
        let node = scene.node(*id);
        let light = scene.lights.get(node.light?).filter(|light| light.mode != LightMode::Baked)?;
        let [z_axis, position] = [node.world_from_object.z_axis, node.world_from_object.w_axis].map(Vec4::truncate);
        Some(Source {
            node: Some(*id),
            kind: light.kind,
            color_linear: light.color_linear,
            intensity: light.intensity * lamp_scale,
            range_m: light.range_m.filter(|range| *range > 0.0 && range.is_finite()),
            range_share: 1.0,
            radius_m: light.radius_m,
            casts_shadows: light.casts_shadows,
            z_axis,
            position,
        })
    };
    let (k, n) = of.subset.map_or((0, 1), |(k, n)| (k, n.max(1)));
    let numbered = (0..LIGHTS_MAX).zip(nodes.iter().filter_map(of_node));
    let limited = move |source: Source| least.map_or(source, |least| source.limited(&least));
    let of_scene = numbered.filter(move |(number, _)| number % n == k).map(move |(_, source)| limited(source));
    of.environment.map(Source::from).into_iter().chain(of_scene)
}

/// Where a light of a table is, as far as its shadows depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableLight {
    /// The node that holds it; none of the light of the environment.
    pub node: Option<NodeId>,
    /// The shape of its emission.
    pub kind: LightKind,
    /// Its place in world space.
    pub position: Vec3,
    /// Whither it shines, of length 1.
    pub direction: Vec3,
    /// How far it reaches, in metres, however small it is seen: its shadow map is that of all views.
    pub range_m: Option<f32>,
    /// Its radius in metres; of directional light the tangent of half the angle it takes in the sky.
    pub radius_m: f32,
    /// Whether surfaces keep its light from what lies behind them.
    pub casts_shadows: bool,
}

/// The lights of a scene, those that no list holds first; those in lists by their class.
#[derive(Clone, Debug, Default)]
pub struct LightTable {
    /// What it was made of.
    sources: Vec<Source>,
    of: TableOf,
    /// Four texels a light: position and 1/range², intensity and cone scale, direction and cone offset, zero.
    pub texels: Vec<[f32; 4]>,
    /// What every light reaches that has a range, in world space.
    pub reaches: Vec<Reach>,
    /// The numbers of the lights before which each class ends: directional ones, others without a range, point lights
    /// that cast no shadow, that cast one, spots that cast one, that cast none.
    pub class_ends: [u32; 6],
    /// The lights, in the order of their texels.
    pub lights: Vec<TableLight>,
    /// Lights that are left out because they are seen too small.
    pub left_out: u32,
    /// Their classes, as bits.
    left_out_classes: u32,
}

impl LightTable {
    /// Collects the lights of `nodes` and that of the environment.
    pub fn new(scene: &Scene, nodes: &[NodeId], of: TableOf) -> Self {
        let mut classes: [Vec<([[f32; 4]; 4], TableLight)>; 6] = Default::default();
        let mut reaches: [Vec<Reach>; 4] = Default::default();
        let sources: Vec<Source> = sources(scene, nodes, &of).collect();
        let mut left_out_classes = 0;
        for light in &sources {
            let (position, direction) = (light.position, light.direction());
            let intensity = (light.color_linear * of.pre_exposure).map(|color| finite_product(color, light.intensity));
            // cos·scale + offset goes from 0 at the outer cone to 1 at the inner one (glTF, KHR_lights_punctual).
            let (scale, offset) = match light.kind {
                LightKind::Spot { inner_cone_rad, outer_cone_rad } => {
                    let scale = 1.0 / (inner_cone_rad.cos() - outer_cone_rad.cos()).max(1e-3);
                    (scale, -outer_cone_rad.cos() * scale)
                }
                LightKind::Directional | LightKind::Point => (0.0, 1.0),
            };
            // Highlights of a source that takes an angle are wider by half of it, as half vectors turn by half of what
            // light does.
            let scale = if light.kind == LightKind::Directional { 0.5 * light.radius_m } else { scale };
            let range = light.reach_m();
            let texels = [
                position.extend(range.map_or(0.0, |range| 1.0 / (range * range))).to_array(),
                intensity.extend(scale).to_array(),
                direction.extend(offset).to_array(),
                [0.0; 4],
            ];
            let class = match (light.kind, range) {
                (LightKind::Directional, _) => 0,
                (_, None) => 1,
                (_, Some(range)) => {
                    let listed = match (scale > 0.0, light.casts_shadows) {
                        (false, casts) => usize::from(casts),
                        (true, casts) => 3 - usize::from(casts),
                    };
                    if light.range_share <= 0.0 {
                        left_out_classes |= 1 << (2 + listed);
                        continue;
                    }
                    reaches[listed].push(Reach::of_light(light.kind, position, direction, range));
                    2 + listed
                }
            };
            let Source { node, kind, range_m, radius_m, casts_shadows, .. } = *light;
            let light = TableLight { node, kind, position, direction, range_m, radius_m, casts_shadows };
            classes[class].push((texels, light));
        }
        let mut end = 0;
        let class_ends = classes.each_ref().map(|class| {
            end += class.len() as u32;
            end
        });
        let (texels, lights): (Vec<_>, Vec<_>) = classes.into_iter().flatten().unzip();
        let left_out = sources.len() as u32 - lights.len() as u32;
        Self {
            sources,
            of,
            left_out,
            left_out_classes,
            texels: texels.into_iter().flatten().collect(),
            reaches: reaches.concat(),
            class_ends,
            lights,
        }
    }

    /// Whether [`Self::new`] would make the same again.
    pub fn is_of(&self, scene: &Scene, nodes: &[NodeId], of: &TableOf) -> bool {
        // How small lights are seen counts only as far as it changes any of them.
        TableOf { least: of.least, ..self.of } == *of && self.sources.iter().copied().eq(sources(scene, nodes, of))
    }

    /// The number of lights that the scene has, be they too small or not; that of the environment is none of them.
    pub fn scene_lights(&self) -> u32 {
        self.len() + self.left_out - u32::from(self.of.environment.is_some())
    }

    /// Whether lists of both are the same: the lights may differ, but not in number and in what they reach.
    fn has_lists_of(&self, other: &Self) -> bool {
        self.class_ends == other.class_ends && self.reaches == other.reaches
    }

    /// Which classes of lights there are, a bit for each, as `constants.rs` has them; those of lights that are left out,
    /// too, so that a moving camera asks for no other pipelines.
    pub fn classes(&self) -> u32 {
        let mut begin = 0;
        let bits = self
            .class_ends
            .into_iter()
            .enumerate()
            .map(|(class, end)| u32::from(std::mem::replace(&mut begin, end) < end) << class);
        bits.sum::<u32>() | self.left_out_classes
    }

    /// The class of the light with a number, as a bit.
    pub fn class_of(&self, light: u32) -> u32 {
        1 << self.class_ends.iter().filter(|end| **end <= light).count()
    }

    /// The number of directional lights.
    pub const fn directional_count(&self) -> u32 {
        self.class_ends[0]
    }

    /// The number of lights before the first that has a range.
    pub const fn global_count(&self) -> u32 {
        self.class_ends[1]
    }

    /// The number of lights.
    pub fn len(&self) -> u32 {
        self.texels.len() as u32 / TEXELS_PER_LIGHT
    }

    /// The lists of a view, within its limits if there are several.
    pub fn cluster(&self, of: &LightListInputs) -> ClusterLists {
        let LightListInputs { view, range, target, culling, settings, limits, .. } = of;
        match culling {
            _ if !of.wants_lists => ClusterLists::nothing(self, target.size),
            LightCulling::Clustered | LightCulling::Volumes | LightCulling::VolumesStencil => {
                ClusterLists::build(self, view, *range, target, settings, *limits)
            }
            LightCulling::Tiled => {
                let settings = ClusterSettings { slices: 1, ..settings.clone() };
                ClusterLists::build(self, view, *range, target, &settings, *limits)
            }
            LightCulling::None => ClusterLists::everything(self, target.size),
        }
    }
}
