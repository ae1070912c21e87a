//! Graphs that are no part of a frame's picture: maps of the environment, reflection and irradiance probes and the
//! ground, which last over frames; and pairs of lights, which a report counts.

use super::surfaces;
use super::translucent::translucent_passes;
use crate::draws::Tile;
use crate::environment::lobe::{Lobe, LobeTable};
use crate::environment::picture::{EnvironmentTiles, TileSources};
use crate::environment_tiles::Tile as EnvironmentTile;
use crate::ground::GroundMap;
use crate::passes::probe_capture::{CapturedProbe, ProbeSide};
use crate::passes::{environment, ground, probe_capture};
use crate::record::Recorder;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use manypass_graph::Handle;

/// What surfaces reflect of a picture of the environment, once it is new.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn environment_passes(
    r: &mut Recorder<'_, '_>,
    tiles: &EnvironmentTiles,
    unfinished: &TileSources,
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
    sides: &[ProbeSide],
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

/// The numbers of pairs that the same lighting visits, in place of light, of a view that counts them: visited, shaded,
/// in range and passed over, to be added up over all texels. What light is computed for are pixels of opaque surfaces,
/// or where these are lit as they are drawn all of their fragments, or vertices; and those of blended surfaces.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn pair_passes(r: &mut Recorder<'_, '_>, settings: &Settings) -> Result<Handle, ProgramError> {
    let (pairs, depth) = surfaces::pair_passes(r, settings)?;
    Ok(translucent_passes(r, settings, pairs, depth)?.radiance)
}
