//! portals: what is seen through flat places that lead to others; see `portals.wgsl`.
//!
//! Drawn over all that is opaque, after fog, which the view that is seen has for itself, and before what is blended. Reads:
//! radiance of the view behind. Writes: radiance, depth.

use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use glam::{Vec3, Vec4};
use manypass_graph::{ColorLoad, Handle};
use manypass_scene::capture::OUTLINE_CORNERS_MAX;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("portals");

/// An end of a portal that a view shows.
#[derive(Debug)]
pub struct PortalDraw {
    /// Its outline in world space, at most [`OUTLINE_CORNERS_MAX`] corners.
    pub corners_world: Vec<Vec3>,
    /// The radiance of what is seen through it.
    pub radiance: Handle,
}

/// The uniform of `portals.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct PortalUniform {
    corners: [Vec4; OUTLINE_CORNERS_MAX],
}

/// Draws what is seen through portals. Returns radiance and depth.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    portals: &[PortalDraw],
    (mut radiance, mut depth): (Handle, Handle),
) -> Result<(Handle, Handle), ProgramError> {
    if r.view.counts_pairs() {
        return Ok((radiance, depth));
    }
    for portal in portals {
        let corner = |at: usize| portal.corners_world.get(at).copied().unwrap_or_default().extend(1.0);
        let uniform = PortalUniform { corners: std::array::from_fn(corner) };
        let triangles = portal.corners_world.len().min(OUTLINE_CORNERS_MAX).saturating_sub(2);
        let step = r.fullscreen("portals", "portals", &[]).triangles(triangles as u32);
        let step = step.uniform("portal", &uniform).read("seen_through", &portal.radiance);
        (radiance, depth) = step.draw_nearer_into(radiance, ColorLoad::Keep, depth)?;
    }
    Ok((radiance, depth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("portals", "Portal", PortalUniform, [corners]);
    }
}
