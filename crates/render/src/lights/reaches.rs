//! What ways of lighting need to know of each light beside lists: where it ends in view space, or the volume that
//! encloses all that it reaches.

use super::volumes::{self, VolumeDraw};
use super::{LightCulling, LightListInputs, LightTable};
use glam::Vec3;
use std::sync::Arc;

/// Room for rounding, which differs between the shader and the CPU: as a factor on radii, and as a share of the
/// distance.
pub(super) const RADIUS_SLACK: f32 = 1.001;
const DISTANCE_SLACK: f32 = 1e-5;

/// The table `light_reaches` of a view. Its texels depend on the way of lighting:
///
/// - tiled: for every light the least and the greatest distance along the view axis that it reaches, 0, 0; zeros if it
///   has no range;
/// - volumes: three texels for every volume, as [`volumes::Volume::texels`] gives them.
#[derive(Clone, Debug)]
pub struct LightReaches {
    /// What the texture holds.
    pub texels: Vec<[f32; 4]>,
    /// How volumes are drawn.
    pub draws: Arc<[VolumeDraw]>,
}

impl LightReaches {
    /// Those of the lights of `table` that the way of `of` needs.
    pub fn new(table: &LightTable, of: &LightListInputs) -> Self {
        let (texels, draws) = match of.culling {
            LightCulling::Tiled => (depth_extents(table, of), Vec::new()),
            LightCulling::Volumes => volumes::all(&volumes::visible(table, of)),
            LightCulling::VolumesStencil => volumes::grouped(&volumes::visible(table, of)),
            LightCulling::Clustered | LightCulling::None => Default::default(),
        };
        Self { texels, draws: draws.into() }
    }
}

fn depth_extents(table: &LightTable, of: &LightListInputs) -> Vec<[f32; 4]> {
    let view_from_world = of.view.world_from_view.inverse();
    let reaches = table.reaches.iter().map(|reach| reach.transformed(&view_from_world));
    let extent = reaches.map(|reach| {
        let [nearest_m, farthest_m] = reach.extent(Vec3::NEG_Z, RADIUS_SLACK);
        let room_m = DISTANCE_SLACK * nearest_m.abs().max(farthest_m.abs());
        [nearest_m - room_m, farthest_m + room_m, 0.0, 0.0]
    });
    // Shaders find a light by its index.
    std::iter::repeat_n([0.0; 4], table.global_count() as usize).chain(extent).collect()
}
