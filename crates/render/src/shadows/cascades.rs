//! Where the cascades of a directional light lie.
//!
//! Source: the practical split of Zhang et al. 2006 ("Parallel-Split Shadow Maps for Large-scale Virtual Environments").
//! It begins where the nearest surface may be seen, and not at a share of the scene's extent, so that shadows beside the
//! eye are as fine on a plain of 100 km as in a room.

use super::ShadowSettings;
use super::dealing::is_wide;
use super::demand::{Aim, Viewer};
use super::projection::looking_along;
use crate::draws::WorldDraws;
use crate::lights::TableLight;
use glam::{Mat4, Vec2, Vec3};
use manypass_scene::Aabb;

/// From this share of the scene on, a cascade shows all of it, and none is needed beyond: of lights with sharp edges,
/// and of wide ones.
const WHOLE_SHARES: [f32; 2] = [0.75, 0.6];
/// Each cascade ends so many times as far away as it begins: twice where [`PARTS`] of them are enough, else four times.
/// With twice as many texels across as the picture has pixels, and half of that where more than four maps share the
/// atlas, a texel is one to five pixels wide at the most.
const RATIOS: [f32; 2] = [2.0, 4.0];
/// So many equal parts there are where the scene is seen from outside, or by parallel rays.
const PARTS: u32 = 4;

/// The next power of √2 below a length, so that cascades keep their size while the camera moves a little.
fn stepped_down(length_m: f32) -> f32 {
    (0.5 * (2.0 * length_m.log2()).floor()).exp2()
}

/// The next power of √2 above a length.
fn stepped_up(length_m: f32) -> f32 {
    (0.5 * (2.0 * length_m.log2()).ceil()).exp2()
}

/// The distances between which cascades of a view lie, the nearest to the eye first.
fn slices(viewer: &Viewer<'_>, world: &WorldDraws, settings: &ShadowSettings) -> Vec<[f32; 2]> {
    let bounds = &world.bounds_world;
    let (center, radius) = (bounds.center(), bounds.radius_m());
    let eye = viewer.view.world_from_view.w_axis.truncate();
    let forward = -viewer.view.world_from_view.z_axis.truncate().normalize_or_zero();
    let half_extent = half_extent(viewer);
    let mut far_m = stepped_up((eye.distance(center) + radius).max(1e-3));
    if settings.distance_m > 0.0 {
        far_m = far_m.min(settings.distance_m);
    }
    if viewer.view.is_orthographic() {
        // A pixel is as wide at all distances.
        return splits(0.0, far_m / 256.0, far_m, 0.0, settings.cascades.min(PARTS));
    }
    // What is seen at this distance from the eye is at least so far away along the view, at a corner of the picture.
    let along_view = (1.0 + half_extent.length_squared()).sqrt().recip();
    // Nothing that is seen is nearer than the scene.
    let scene_m = along_view * (eye.distance(center) - radius);
    let is_before = !viewer.sees_air && scene_m > far_m / 16.0;
    let first_m = stepped_down(scene_m.max(far_m / 32.0)).min(0.5 * far_m);
    if is_before {
        // From outside the scene is seen by few equal parts.
        return splits(first_m, first_m, far_m, settings.split, settings.cascades.min(PARTS));
    }
    let nearest_m = (along_view * world.nearest_m(eye, forward).max(0.0)).max(viewer.range.near_m);
    let is_enough = |ratio: &f32| far_m * ratio.powi(-(settings.cascades.min(PARTS) as i32)) <= nearest_m;
    let ratio = RATIOS.into_iter().find(is_enough).unwrap_or(RATIOS[1]);
    let reached = |count: u32| far_m * ratio.powi(-(count as i32));
    // The ladder hangs on its far end, so that a camera that comes nearer adds cascades and changes none.
    let count = (1..settings.cascades).find(|count| reached(*count) <= nearest_m).unwrap_or(settings.cascades);
    let near_m = reached(count);
    let begins_m = if viewer.sees_air || near_m > nearest_m { 0.0 } else { near_m };
    splits(begins_m, near_m, far_m, settings.split, count)
}

fn half_extent(viewer: &Viewer<'_>) -> Vec2 {
    let (width, height) = viewer.size;
    viewer.view.half_extent(width as f32 / height.max(1) as f32)
}

/// The cascades of a directional light, the nearest to the eye first.
pub(super) fn of_directional(
    light: &TableLight,
    viewer: &Viewer<'_>,
    world: &WorldDraws,
    settings: &ShadowSettings,
) -> Vec<Aim> {
    let bounds: &Aabb = &world.bounds_world;
    let rotation = looking_along(light.direction);
    let (center, radius) = (bounds.center(), bounds.radius_m());
    if bounds.is_empty() || !radius.is_finite() {
        return Vec::new();
    }
    let depth = depth_of((rotation.inverse() * center).z, radius, settings);
    if settings.extent_m > 0.0 {
        return vec![Aim::Parallel { rotation, center, half_m: 0.5 * settings.extent_m, depth }];
    }
    if viewer.is_around {
        return vec![Aim::Parallel { rotation, center, half_m: radius, depth }];
    }
    let whole_share = WHOLE_SHARES[usize::from(is_wide(light))];
    let aim = |range: [f32; 2]| {
        let view = viewer.view;
        let slice = slice_sphere(&view.world_from_view, half_extent(viewer), view.is_orthographic(), range);
        // A cascade that would be about as large as the scene, or larger, shows the scene.
        let (center, half_m) = if slice.1 < whole_share * radius { slice } else { (center, radius) };
        Aim::Parallel { rotation, center, half_m, depth }
    };
    let mut aims: Vec<Aim> = slices(viewer, world, settings).into_iter().map(aim).collect();
    let is_whole = |aim: &Aim| matches!(aim, Aim::Parallel { half_m, .. } if *half_m >= radius);
    if let Some(first) = aims.iter().position(is_whole) {
        aims.truncate(first + 1);
    }
    aims
}

/// The greatest and the least z in light space that maps show of a ball with its middle at `z`: all of it, unless the
/// settings have a near or a far plane.
fn depth_of(z: f32, radius_m: f32, settings: &ShadowSettings) -> [f32; 2] {
    // A little room, because bounds touch the surfaces that they enclose.
    let whole = [z + 1.001 * radius_m + 1e-3, z - 1.001 * radius_m - 1e-3];
    let given = [settings.near_m, settings.far_m].map(|plane_m| (plane_m > 0.0).then_some(z + radius_m - plane_m));
    [given[0].unwrap_or(whole[0]), given[1].unwrap_or(whole[1])]
}

/// The view's part between two distances, as a sphere around it in world space that depends on nothing but its shape
/// and place, so that a view that turns keeps its radius.
fn slice_sphere(
    world_from_view: &Mat4,
    half_extent: Vec2,
    is_orthographic: bool,
    [near_m, far_m]: [f32; 2],
) -> (Vec3, f32) {
    let corner = half_extent.length();
    let (near_corner, far_corner) = if is_orthographic { (corner, corner) } else { (corner * near_m, corner * far_m) };
    // On the axis, equally far from the corners of both ends, unless that lies beyond the far end.
    let middle = 0.5 * ((far_m * far_m + far_corner * far_corner) - (near_m * near_m + near_corner * near_corner))
        / (far_m - near_m).max(1e-6 * far_m);
    let middle = middle.max(near_m).min(far_m);
    let radius = Vec2::new(far_m - middle, far_corner).length().max(Vec2::new(middle - near_m, near_corner).length());
    (world_from_view.transform_point3(Vec3::new(0.0, 0.0, -middle)), radius)
}

/// The distances between which `count` cascades lie, from equal steps (`split` 0) to equal ratios (1). The first begins
/// at `first_m`.
fn splits(first_m: f32, near_m: f32, far_m: f32, split: f32, count: u32) -> Vec<[f32; 2]> {
    let at = |index: u32| {
        let share = index as f32 / count as f32;
        let (step, ratio) = (near_m + (far_m - near_m) * share, near_m * (far_m / near_m).powf(share));
        step + (ratio - step) * split
    };
    (0..count).map(|index| [if index == 0 { first_m } else { at(index) }, at(index + 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_slice_lies_in_its_sphere() {
        let view = Mat4::from_rotation_translation(Quat::from_rotation_y(0.7), Vec3::new(3.0, 2.0, 1.0));
        let half = Vec2::new(0.8, 0.45);
        for is_orthographic in [false, true] {
            for range in [[0.1f32, 1.0], [1.0, 30.0], [0.0, 0.5]] {
                let (center, radius) = slice_sphere(&view, half, is_orthographic, range);
                let mut greatest = 0.0f32;
                for distance_m in range {
                    let scale = if is_orthographic { 1.0 } else { distance_m };
                    for corner in [Vec2::ONE, Vec2::NEG_ONE, Vec2::new(1.0, -1.0), Vec2::new(-1.0, 1.0)] {
                        let corner = view.transform_point3((corner * half * scale).extend(-distance_m));
                        greatest = greatest.max(corner.distance(center));
                    }
                }
                assert!((greatest - radius).abs() < 1e-4 * radius, "{greatest} {radius}");
            }
        }
    }

    #[test]
    fn planes_that_are_given_take_the_place_of_those_of_the_scene() {
        let of = |near_m, far_m| depth_of(2.0, 10.0, &ShadowSettings { near_m, far_m, ..ShadowSettings::default() });
        let [nearest, farthest] = of(0.0, 0.0);
        assert!(nearest > 12.0 && farthest < -8.0 && nearest - farthest < 20.1, "{nearest} {farthest}");
        assert_eq!(of(3.0, 15.0), [9.0, -3.0]);
        assert_eq!(of(3.0, 0.0), [9.0, farthest]);
    }

    #[test]
    fn cascades_cover_the_depth_without_a_gap() {
        for split in [0.0, 0.5, 1.0] {
            let slices = splits(0.0, 0.5, 100.0, split, 4);
            assert!(slices[0][0] == 0.0 && (slices[3][1] - 100.0).abs() < 1e-3);
            assert!(slices.windows(2).all(|pair| pair[0][1] == pair[1][0] && pair[0][1] < pair[1][1]));
        }
        let ends = |splits: Vec<[f32; 2]>| splits.into_iter().map(|[_, end]| end.round()).collect::<Vec<_>>();
        assert_eq!(ends(splits(0.0, 1.0, 16.0, 1.0, 4)), [2.0, 4.0, 8.0, 16.0]);
        assert_eq!(ends(splits(0.0, 1.0, 17.0, 0.0, 4)), [5.0, 9.0, 13.0, 17.0]);
    }
}
