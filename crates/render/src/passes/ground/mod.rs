//! ground: the plane under the scene, where no opaque surface is before it; blended ones are drawn over it later.
//!
//! What it gets of light is read from a map of the plane, which is drawn when it is not that of the scene any more:
//! shadows of the parallel light with penumbrae (Fernando 2005, "Percentage-Closer Soft Shadows"), and form factors of
//! what hangs over it, by fixed points of importance; a pass `ground.smooth` takes the noise of both out of it. Reads:
//! the environment, depth; its map: what casts shadows. Writes: radiance.

use crate::draws::Tile;
use crate::gbuffer::LightTarget;
use crate::ground::GroundMap;
use crate::pass_info::PassInfo;
use crate::record::{PicturePart, Recorder, Texels};
use crate::shader::program::ProgramError;
use glam::{Mat4, Vec2, Vec3};
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { off: Some("ground.mode=none"), ..PassInfo::new("ground") };

/// Records the passes that draw `map` into `target`, from what `tiles` show.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn record_map(
    r: &mut Recorder<'_, '_>,
    map: &GroundMap,
    tiles: &[Tile],
    target: Handle,
) -> Result<Handle, ProgramError> {
    let depths = r.texture_of("ground.depths", map.depths());
    let depths = r.tiles("ground.depths", "shadows").draw_into(depths, true, tiles)?;
    let shares = r.texture_of("ground.shares", map.texture());
    r.declare_texels(&shares, Texels::Share);
    let step = r.fullscreen("ground.map", "ground_map", &[]).read_depth("depths", &depths);
    let shares = step.uniform("ground_map", &map.uniform()).draw_into(shares, ColorLoad::Discard)?;
    let step = r.fullscreen("ground.smooth", "ground_smooth", &[]).read("shares", &shares);
    step.draw_into(target, ColorLoad::Discard)
}

/// The pixels around what lies between `corners`: x and y of the first, width and height. All of the picture where one
/// is not before the eye.
fn rectangle(corners: &[Vec3; 4], clip_from_world: &Mat4, (width, height): (u32, u32)) -> [u32; 4] {
    let clip = corners.map(|corner| *clip_from_world * corner.extend(1.0));
    if clip.iter().any(|corner| corner.w.is_nan() || corner.w <= 1e-6) {
        return [0, 0, width, height];
    }
    let size = Vec2::new(width as f32, height as f32);
    let pixels = clip.map(|corner| (Vec2::new(corner.x, -corner.y) / corner.w * 0.5 + 0.5) * size);
    // Samples lie beside the middle of their pixel.
    let room = Vec2::splat(2.0);
    let [low, high] =
        [pixels.into_iter().fold(Vec2::MAX, Vec2::min) - room, pixels.into_iter().fold(Vec2::MIN, Vec2::max) + room]
            .map(|corner| corner.clamp(Vec2::ZERO, size));
    let [left, top] = low.floor().as_uvec2().to_array();
    let [right, bottom] = high.ceil().as_uvec2().to_array();
    [left, top, right.saturating_sub(left), bottom.saturating_sub(top)]
}

/// Records the pass, if the view has a ground.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, depth: &Handle, radiance: Handle) -> Result<Handle, ProgramError> {
    let view = r.view;
    let Some(ground) = &view.ground else { return Ok(radiance) };
    let step = r.fullscreen("ground", "ground", &[]).table("ground_light", &ground.map);
    let rectangle = ground.shadow.as_ref().map(|corners| rectangle(corners, &view.uniform.clip_from_world, view.size));
    let step = step.uniform("ground", &ground.uniform).over(PicturePart::Background, depth);
    let step = match rectangle {
        Some([.., 0, _] | [.., 0]) => return Ok(radiance),
        Some(rectangle) => step.within(rectangle),
        None => step,
    };
    step.blend(LightTarget::blend_over(view)).draw_into(radiance, ColorLoad::Keep)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{DepthRange, View};
    use glam::Quat;
    use manypass_scene::Projection;

    #[test]
    fn the_rectangle_holds_what_lies_between_its_corners() {
        let world_from_view = Mat4::from_rotation_translation(Quat::from_rotation_x(-0.4), Vec3::new(0.3, 2.0, 5.0));
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        let range = DepthRange { near_m: 0.1, far_m: 10.0 };
        let clip = View { world_from_view, projection }.uniform(range, 400, 200, Vec2::ZERO, 1.0, 0).clip_from_world;
        let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)];
        let [left, top, width, height] = rectangle(&corners, &clip, (400, 200));
        assert!(width < 200 && height < 100);
        for i in 0..121u8 {
            let at = clip * corner(f32::from(i % 11) / 5.0 - 1.0, f32::from(i / 11) / 5.0 - 1.0).extend(1.0);
            let (x, y) = ((at.x / at.w * 0.5 + 0.5) * 400.0, (0.5 - at.y / at.w * 0.5) * 200.0);
            assert!(x > left as f32 && x < (left + width) as f32 && y > top as f32 && y < (top + height) as f32);
        }
        let behind = corners.map(|corner| corner + Vec3::Z * 5.0);
        assert_eq!(rectangle(&behind, &clip, (400, 200)), [0, 0, 400, 200]);
        let beside = corners.map(|corner| corner - Vec3::X * 90.0);
        assert_eq!(rectangle(&beside, &clip, (400, 200))[2], 0);
    }
}
