//! Tiles of a picture, and of the studio, as bytes for a cache.
//!
//! An entry is a line of text that says what it is, a hash of all that follows it, the suns of a picture, and the
//! texels. One that is not whole, or is of something else, is none.

use crate::environment_tiles::TileSides;
use crate::gpu::Gpu;
use glam::Vec3;
use half::f16;
use manypass_scene::EnvironmentMap;
use manypass_scene::environment::suns::{SUNS_MAX, Sun, Suns};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Rises whenever tiles of the same picture become others.
const VERSION: u32 = 3;

const MAGIC: &[u8] = b"manypass environment 1\n";

/// Numbers of a sun: direction, irradiance, surroundings, spread.
const SUN_NUMBERS: usize = 10;

/// Bytes before the texels.
const HEAD: usize = MAGIC.len() + 8 + 4 * SUN_NUMBERS * SUNS_MAX;

/// The name of the tiles of `map` on a device: of what the map holds, how the tiles are made, and who draws them,
/// because adapters round each in a way of their own.
pub(crate) fn name_of(gpu: &Gpu, map: &EnvironmentMap, (sides, has_suns): (TileSides, bool)) -> String {
    let mut hasher = DefaultHasher::new();
    let adapter = &gpu.adapter;
    (&adapter.name, &adapter.backend, &adapter.driver).hash(&mut hasher);
    (VERSION, gpu.capabilities.tiles_format, map.width, map.height, map.light.is_some(), sides, has_suns)
        .hash(&mut hasher);
    format!("{:?}", map.layout).hash(&mut hasher);
    hasher.write(bytemuck::cast_slice(&map.texels));
    let prefiltered = map.prefiltered.iter().flat_map(|prefiltered| prefiltered.texels());
    prefiltered.for_each(|texels| hasher.write(bytemuck::cast_slice(texels)));
    if let Some(irradiance) = &map.irradiance {
        hasher.write(b"irradiance");
        hasher.write(bytemuck::cast_slice(irradiance.texels()));
    }
    map.peaks.iter().for_each(|(index, beyond)| (index, beyond.to_array().map(f32::to_bits)).hash(&mut hasher));
    format!("environment-{:016x}", hasher.finish())
}

fn hash_of(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish()
}

/// The entry of tiles.
pub(crate) fn entry(suns: &Suns, texels: &[u8]) -> Vec<u8> {
    let mut entry = Vec::with_capacity(HEAD + texels.len());
    entry.extend_from_slice(MAGIC);
    entry.extend_from_slice(&[0; 8]);
    for Sun { direction, irradiance, surroundings, spread } in suns {
        let numbers = [direction, irradiance, surroundings].into_iter().flat_map(|of| of.to_array());
        numbers.chain([*spread]).for_each(|number| entry.extend_from_slice(&number.to_le_bytes()));
    }
    entry.extend_from_slice(texels);
    let hash = hash_of(&entry[MAGIC.len() + 8..]);
    entry[MAGIC.len()..MAGIC.len() + 8].copy_from_slice(&hash.to_le_bytes());
    entry
}

/// Suns and the bytes of texels of an entry, if these are so many.
pub(crate) fn tiles_of(entry: &[u8], count: usize) -> Option<(Suns, &[u8])> {
    let (hash, rest) = entry.strip_prefix(MAGIC)?.split_at_checked(8)?;
    if rest.len() != HEAD - MAGIC.len() - 8 + count || hash_of(rest).to_le_bytes() != *hash {
        return None;
    }
    let (of_suns, of_texels) = rest.split_at_checked(4 * SUN_NUMBERS * SUNS_MAX)?;
    let number = |bytes: &[u8]| bytes.try_into().map_or(0.0, f32::from_le_bytes);
    let mut suns = Suns::default();
    for (sun, bytes) in suns.iter_mut().zip(of_suns.chunks_exact(4 * SUN_NUMBERS)) {
        let [direction, irradiance, surroundings] =
            [0, 3, 6].map(|at| Vec3::from([0, 1, 2].map(|part| number(&bytes[4 * (at + part)..4 * (at + part) + 4]))));
        *sun = Sun { direction, irradiance, surroundings, spread: number(&bytes[36..40]) };
    }
    Some((suns, of_texels))
}

const MAGIC_OF_STUDIO: &[u8] = b"manypass studio 1\n";

/// The name of the studio's tiles: of the text of what draws them, so that they are no other's.
pub(crate) fn name_of_studio() -> String {
    const OF_CONSTANTS: u64 = hash_of_text(include_bytes!("../constants.rs"), FNV_OFFSET);
    const OF_LOBE: u64 = hash_of_text(include_bytes!("lobe.rs"), OF_CONSTANTS);
    const OF_TILES: u64 = hash_of_text(include_bytes!("../environment_tiles.rs"), OF_LOBE);
    const HASH: u64 = hash_of_text(include_bytes!("studio.rs"), OF_TILES);
    format!("studio-{HASH:016x}")
}

const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a (Fowler, Noll & Vo 1991), which goes on from `hash`: the standard library has none that compilers compute.
const fn hash_of_text(text: &[u8], mut hash: u64) -> u64 {
    let mut index = 0;
    while index < text.len() {
        hash = (hash ^ text[index] as u64).wrapping_mul(0x100_0000_01b3);
        index += 1;
    }
    hash
}

/// The entry of grey texels, each a number.
pub(crate) fn entry_of_greys(texels: &[[f16; 4]]) -> Vec<u8> {
    let greys: Vec<u8> = texels.iter().flat_map(|[grey, ..]| grey.to_le_bytes()).collect();
    [MAGIC_OF_STUDIO, &hash_of(&greys).to_le_bytes(), &greys].concat()
}

/// The texels of an entry, if it is one of `count` grey ones. Those that are 0 lie between tiles, and so has their alpha
/// to be.
pub(crate) fn greys_of(entry: &[u8], count: usize) -> Option<Vec<[f16; 4]>> {
    let (hash, greys) = entry.strip_prefix(MAGIC_OF_STUDIO)?.split_at_checked(8)?;
    if greys.len() != 2 * count || hash_of(greys).to_le_bytes() != *hash {
        return None;
    }
    let texel = |bytes: &[u8]| match f16::from_le_bytes([bytes[0], bytes[1]]) {
        grey if grey == f16::ZERO => [f16::ZERO; 4],
        grey => [grey, grey, grey, f16::ONE],
    };
    Some(greys.chunks_exact(2).map(texel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_back_and_broken_ones_do_not() {
        let mut suns = Suns::default();
        suns[0] = Sun {
            direction: Vec3::Y,
            irradiance: Vec3::new(1.0, 2.0, 3.0),
            surroundings: Vec3::splat(0.5),
            spread: 0.1,
        };
        let texels: Vec<u8> = (0..12).collect();
        let whole = entry(&suns, &texels);
        assert_eq!(tiles_of(&whole, 12), Some((suns, &texels[..])));
        assert_eq!(tiles_of(&whole, 11), None);
        assert_eq!(tiles_of(&whole[..whole.len() - 1], 12), None);
        assert_eq!(tiles_of(&[], 12), None);
        for at in [0, MAGIC.len(), MAGIC.len() + 9, HEAD - 1, HEAD, whole.len() - 1] {
            let mut broken = whole.clone();
            broken[at] ^= 1;
            assert_eq!(tiles_of(&broken, 12), None, "byte {at}");
        }
    }

    #[test]
    fn the_studio_comes_back_as_it_is() {
        let texels = crate::environment::studio::texels();
        let whole = entry_of_greys(texels);
        assert!(greys_of(&whole, texels.len()).is_some_and(|back| back == texels));
        assert!(greys_of(&whole, texels.len() - 1).is_none() && greys_of(&whole[1..], texels.len()).is_none());
        let mut broken = whole;
        broken[100] ^= 1;
        assert!(greys_of(&broken, texels.len()).is_none());
    }
}
