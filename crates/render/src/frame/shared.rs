//! What the views of a frame share: shadow maps, the environment, probes, the ground.

use crate::draws::Tile;
use crate::environment::lobe::{Lobe, LobeTable};
use crate::environment::tiles::Tile as EnvironmentTile;
use crate::ground::GroundMap;
use crate::passes::probe_capture::{CapturedProbe, SeenSide};
use crate::passes::{environment, ground, probe_capture, shadows};
use crate::record::Recorder;
use crate::resources::environment::{EnvironmentTiles, Unfinished};
use crate::shader::program::ProgramError;
use crate::shadows::FrameShadows;
use manypass_graph::Handle;

/// What all views of a frame share: the maps of their shadows.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn shared_passes(r: &mut Recorder<'_, '_>, shadows: &FrameShadows, atlas: Handle) -> Result<(), ProgramError> {
    shadows::record(r, shadows, atlas)
}

/// What surfaces reflect of a picture of the environment, once it is new.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn environment_passes(
    r: &mut Recorder<'_, '_>,
    tiles: &EnvironmentTiles,
    unfinished: &Unfinished,
) -> Result<(), ProgramError> {
    let picture = r.graph.import("environment.picture", unfinished.picture_desc, unfinished.picture.clone());
    let target = r.graph.import("environment", tiles.desc, tiles.view.clone());
    let drawn = environment::record(r, (tiles, unfinished), &picture, target)?;
    r.graph.export(drawn);
    Ok(())
}

/// What stands for the environment in a part of the scene, from what was seen around a place: six sides of a cube.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn surroundings_passes(
    r: &mut Recorder<'_, '_>,
    lobes: (&[Lobe], &LobeTable),
    faces: &[Handle; 6],
    tile: impl Fn(u32) -> EnvironmentTile,
    target: Handle,
) -> Result<(), ProgramError> {
    let drawn = environment::record_surroundings(r, lobes, faces, tile, target)?;
    r.graph.export(drawn);
    Ok(())
}

/// The light of a probe, of what is to be seen around it.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn probe_light_passes(
    r: &mut Recorder<'_, '_>,
    probe: &CapturedProbe,
    sides: &[SeenSide],
    target: Handle,
) -> Result<(), ProgramError> {
    let drawn = probe_capture::record(r, probe, sides, target)?;
    r.graph.export(drawn);
    Ok(())
}

/// What the ground gets of light, once that or the scene changed: the map of the plane, in `target`.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn ground_passes(
    r: &mut Recorder<'_, '_>,
    map: &GroundMap,
    tiles: &[Tile],
    target: Handle,
) -> Result<(), ProgramError> {
    let drawn = ground::record_map(r, map, tiles, target)?;
    r.graph.export(drawn);
    Ok(())
}
