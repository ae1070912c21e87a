//! ground: the plane under the scene, where no opaque surface is before it; blended ones are drawn over it later.
//!
//! What it gets of light is read from a map of the plane, which is drawn when it is not that of the scene any more: shadows of the
//! parallel light with penumbrae (Fernando 2005, "Percentage-Closer Soft Shadows"), and form factors of what hangs over it, by fixed
//! points of importance. Reads: the environment, depth; its map: what casts shadows. Writes: radiance.

use crate::draws::Tile;
use crate::gbuffer::LightTarget;
use crate::ground::{GROUND_DEPTHS, GroundMap};
use crate::record::{PicturePart, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

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
    let depths = r.texture_of("ground.depths", GROUND_DEPTHS);
    let depths = r.tiles("ground.depths", "shadows").draw_into(depths, true, tiles)?;
    let step = r.fullscreen("ground.map", "ground_map", &[]).read_depth("depths", &depths);
    step.uniform("ground_map", &map.uniform()).draw_into(target, ColorLoad::Discard)
}

/// Records the pass, if the view has a ground.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, depth: &Handle, radiance: Handle) -> Result<Handle, ProgramError> {
    let view = r.view;
    let Some(ground) = &view.ground else { return Ok(radiance) };
    let step = r.fullscreen("ground", "ground", &[]).table("ground_light", &ground.map);
    let step = step.uniform("ground", &ground.uniform).over(PicturePart::Background, depth);
    step.blend(LightTarget::blend_over(view)).draw_into(radiance, ColorLoad::Keep)
}
