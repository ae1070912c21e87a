//! environment: a picture of the environment becomes what surfaces of more and more roughness reflect of it, tiles of
//! one texture. It is drawn once, when the picture is new, and not in every frame.
//!
//! Source: filtered importance sampling (Colbert & Křivánek 2007) of GGX, seen along the normal (Karis 2013). Where it
//! differs: samples lie on a spiral that turns by the golden angle, and are denser far from the lobe's middle than its
//! importance asks for; above roughness 0.5 what is reflected is the sum over all directions; strong small sources are
//! taken out, and surfaces are lit by them as by discs; and the 21 levels of roughness are tiles of their own,
//! octahedral maps (Cigolle et al. 2014), because levels of a cube map are too few for what lies between.
//! Reads: the equirectangular picture. Writes: the tiles.

use crate::environment::ENVIRONMENT_FORMAT;
use crate::environment::lobe::{FACES, Lobe, LobeTable};
use crate::environment::picture::{EnvironmentTiles, TileSources};
use crate::environment_tiles::Tile;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use crate::surroundings::FACE_SIDE;
use bytemuck::{Pod, Zeroable};
use glam::{UVec4, Vec4};
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use manypass_scene::environment::suns::{SUNS_MAX, Sun};
use wgpu::TextureViewDimension::Cube;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("environment");

/// `CubeFace` of `cube.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct FaceUniform {
    /// To the right; one divided by the side in texels.
    right: Vec4,
    /// Down; zero.
    down: Vec4,
    /// From the middle of the cube to that of the face; zero.
    forward: Vec4,
}

impl FaceUniform {
    fn new(face: usize, side: u32) -> Self {
        let [right, down, forward] = FACES[face];
        Self { right: right.extend(1.0 / side as f32), down: down.extend(0.0), forward: forward.extend(0.0) }
    }
}

/// A sun of `environment_suns.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SunUniform {
    /// Where it is, and the cosine of the angle that holds it.
    direction: Vec4,
    /// The radiance of its surroundings; zero.
    surroundings: Vec4,
}

impl From<Sun> for SunUniform {
    fn from(sun: Sun) -> Self {
        Self { direction: sun.direction.extend(sun.cos()), surroundings: sun.surroundings.extend(0.0) }
    }
}

/// The uniform of `face.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct EnvironmentFace {
    /// The face.
    face: FaceUniform,
    /// What is cut.
    suns: [SunUniform; SUNS_MAX],
}

/// The uniform of `mirror.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct TileUniform {
    /// The first texel behind the border, and one divided by the side in texels; zero.
    corner: Vec4,
}

impl TileUniform {
    fn new(tile: Tile) -> Self {
        let [x, y] = tile.corner.map(|at| at as f32);
        Self { corner: Vec4::new(x, y, 1.0 / tile.side as f32, 0.0) }
    }
}

/// The uniform of `prefilter.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct PrefilterUniform {
    /// As of [`TileUniform`].
    corner: Vec4,
    /// The row of the samples, and their number; zeros.
    samples: UVec4,
    /// For all directions: the square of alpha, less what the source is blurred by, and the level of the source; zeros.
    scales: Vec4,
}

/// Records the passes that draw the tiles of `target` from `picture`.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub(crate) fn record(
    r: &mut Recorder<'_, '_>,
    (tiles, unfinished): (&EnvironmentTiles, &TileSources),
    picture: &Handle,
    target: Handle,
) -> Result<Handle, ProgramError> {
    let TileSources { lobes, table, source_side, .. } = unfinished;
    let source = halves(r, tiles, picture, *source_side)?;
    let mirror = Tile::of_level(0, tiles.sides);
    let step = r.fullscreen("environment.mirror", "environment_mirror", &[]).read("equirectangular", picture);
    let step = step.uniform("environment_tile", &TileUniform::new(mirror)).within(mirror.rectangle());
    // What files bring is there already.
    let TileSources { is_prefiltered, has_irradiance, .. } = *unfinished;
    let is_kept = is_prefiltered || has_irradiance;
    let load = if is_kept { ColorLoad::Keep } else { ColorLoad::Clear(wgpu::Color::BLACK) };
    let mut target = step.draw_into(target, load)?;
    let last = lobes.len() as u32 - 1;
    let is_drawn = |row: u32| if row == last { !has_irradiance } else { !is_prefiltered };
    for (row, lobe) in (0..).zip(lobes).filter(|(row, _)| is_drawn(*row)) {
        let tile = Tile::of_level(row + 1, tiles.sides);
        target = prefilter(r, (&source, table), (row, lobe), tile, target)?;
    }
    Ok(target)
}

/// Draws a tile of what a surface of a roughness reflects of a cube map with its halves; the lobe is that of a row of the
/// table.
fn prefilter(
    r: &mut Recorder<'_, '_>,
    (source, table): (&Handle, &LobeTable),
    (row, lobe): (u32, &Lobe),
    tile: Tile,
    target: Handle,
) -> Result<Handle, ProgramError> {
    let uniform = PrefilterUniform {
        corner: TileUniform::new(tile).corner,
        samples: UVec4::new(row, lobe.samples.len() as u32, 0, 0),
        scales: Vec4::new(lobe.alpha * lobe.alpha, lobe.source_level, 0.0, 0.0),
    };
    let step = r.fullscreen("environment.prefilter", "environment_prefilter", &[]);
    let step = step.read_as("source", source, Cube).table("lobe", table.view());
    let step = step.constant("is_of_sphere", u32::from(lobe.is_of_sphere));
    let step = step.uniform("environment_prefilter", &uniform).within(tile.rectangle());
    step.draw_into(target, ColorLoad::Keep)
}

/// Records the passes that draw the tiles of surroundings into `target`, which `tile` places by their levels, from the
/// radiance of the six sides of a cube.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn record_surroundings(
    r: &mut Recorder<'_, '_>,
    (lobes, table): (&[Lobe], &LobeTable),
    faces: &[Handle; 6],
    tile: impl Fn(u32) -> Tile,
    mut target: Handle,
) -> Result<Handle, ProgramError> {
    let source = r.texture_of("environment.halves", cube_desc(FACE_SIDE));
    for (face, radiance) in (0..6).zip(faces) {
        let side = r.graph.subview(&source, 0, face);
        let step = r.fullscreen("environment.place", "environment_place", &[]).read("view_radiance", radiance);
        step.draw_into(side, ColorLoad::Discard)?;
    }
    halve(r, &source)?;
    let mirror = tile(0);
    let step = r.fullscreen("environment.mirror", "environment_mirror_of_cube", &[]).read_as("source", &source, Cube);
    let step = step.uniform("environment_tile", &TileUniform::new(mirror)).within(mirror.rectangle());
    target = step.draw_into(target, ColorLoad::Keep)?;
    for (row, lobe) in (0..).zip(lobes) {
        target = prefilter(r, (&source, table), (row, lobe), tile(row + 1), target)?;
    }
    Ok(target)
}

/// A cube map with all its halves.
fn cube_desc(side: u32) -> TextureDesc {
    TextureDesc { layers: 6, mips: side.ilog2() + 1, ..TextureDesc::new_2d(side, side, ENVIRONMENT_FORMAT) }
}

/// A cube map of the picture without suns, each of whose levels is half as large.
fn halves(
    r: &mut Recorder<'_, '_>,
    tiles: &EnvironmentTiles,
    picture: &Handle,
    side: u32,
) -> Result<Handle, ProgramError> {
    let halves = r.texture_of("environment.halves", cube_desc(side));
    let suns = tiles.suns.map(SunUniform::from);
    for face in 0..6 {
        let target = r.graph.subview(&halves, 0, face);
        let step = r.fullscreen("environment.face", "environment_face", &[]).read("equirectangular", picture);
        let uniform = EnvironmentFace { face: FaceUniform::new(face as usize, side), suns };
        step.uniform("environment_face", &uniform).draw_into(target, ColorLoad::Discard)?;
    }
    halve(r, &halves)?;
    Ok(halves)
}

/// Draws all levels of a cube map from its first.
fn halve(r: &mut Recorder<'_, '_>, halves: &Handle) -> Result<(), ProgramError> {
    let desc = halves.desc();
    for level in 1..desc.mips {
        for face in 0..6 {
            let finer = r.graph.subresources(halves, level - 1..level, 0..6);
            let target = r.graph.subview(halves, level, face);
            let step = r.fullscreen("environment.halve", "environment_halve", &[]).read_as("finer", &finer, Cube);
            let step = step.uniform("cube_face", &FaceUniform::new(face as usize, desc.width >> level));
            step.draw_into(target, ColorLoad::Discard)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniforms_have_one_layout() {
        assert_same_layout!("environment_face", "CubeFace", FaceUniform, [right, down, forward]);
        assert_same_layout!("environment_face", "EnvironmentSun", SunUniform, [direction, surroundings]);
        assert_same_layout!("environment_face", "EnvironmentFace", EnvironmentFace, [face, suns]);
        assert_same_layout!("environment_mirror", "EnvironmentTile", TileUniform, [corner]);
        assert_same_layout!("environment_mirror_of_cube", "EnvironmentTile", TileUniform, [corner]);
        assert_same_layout!(
            "environment_prefilter",
            "EnvironmentPrefilter",
            PrefilterUniform,
            [corner, samples, scales]
        );
    }
}
