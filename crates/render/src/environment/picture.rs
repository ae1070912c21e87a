//! The picture of the environment on the device.

use super::lobe::{Lobe, LobeTable, roughness_of_level};
use super::{ENVIRONMENT_FORMAT, stored, studio};
use crate::constants::ENVIRONMENT_LEVEL_LAST;
use crate::environment_tiles::{Tile, TileSides, texture_size};
use crate::gpu::{Gpu, destroy};
use glam::Vec3;
use half::f16;
use manypass_graph::TextureDesc;
use manypass_scene::Cache;
use manypass_scene::environment::RADIANCE_MAX;
use manypass_scene::environment::suns::{Suns, suns};
use manypass_scene::{EnvironmentLight, EnvironmentMap};
use std::sync::{Arc, Weak};

/// The least and the largest side of the faces that lobes are sampled from.
const SOURCE_SIDES: (u32, u32) = (16, 512);

/// What surfaces reflect of a picture: tiles of a texture, one for each level of roughness.
#[derive(Debug)]
pub(crate) struct EnvironmentTiles {
    pub view: wgpu::TextureView,
    /// Of the texture.
    pub desc: TextureDesc,
    pub sides: TileSides,
    pub suns: Suns,
    /// The light of the map, which is in none of the tiles.
    pub light: Option<EnvironmentLight>,
    /// The map; of the studio none.
    of: Weak<EnvironmentMap>,
    /// Whether it is what is to be seen around a place.
    is_of_place: bool,
    unfinished: Option<TileSources>,
    /// What is to be said of the picture.
    warning: Option<String>,
    /// The name under which a cache lacks them.
    missing: Option<String>,
}

/// What the tiles are drawn from.
#[derive(Debug)]
pub(crate) struct TileSources {
    pub picture: wgpu::TextureView,
    pub picture_desc: TextureDesc,
    /// The side of the faces that lobes are sampled from.
    pub source_side: u32,
    pub lobes: Vec<Lobe>,
    /// Whether the tiles between the mirror's and that of irradiance are there already.
    pub is_prefiltered: bool,
    /// Whether that of irradiance is.
    pub has_irradiance: bool,
    pub table: LobeTable,
}

impl EnvironmentTiles {
    /// Of a map: as the cache has them, or yet to be drawn from its picture, which is uploaded.
    pub fn new(gpu: &Gpu, map: &Arc<EnvironmentMap>, cache: Option<&dyn Cache>) -> Self {
        let sides = TileSides::of_picture(map.width, gpu.capabilities.max_texture_size);
        // A map with a light of its own has none in its texels, and what files bring beside it holds its suns.
        let has_suns = map.light.is_none() && map.prefiltered.is_none() && map.irradiance.is_none();
        Self::with_sides(gpu, map, (sides, has_suns), cache)
    }

    /// Of a picture of what is to be seen around a place: small bright sources stay in it.
    pub fn of_surroundings(gpu: &Gpu, map: &Arc<EnvironmentMap>, cache: Option<&dyn Cache>) -> Self {
        let tiles = Self::with_sides(gpu, map, (crate::surroundings::SIDES, false), cache);
        Self { is_of_place: true, ..tiles }
    }

    fn with_sides(
        gpu: &Gpu,
        map: &Arc<EnvironmentMap>,
        (sides, has_suns): (TileSides, bool),
        cache: Option<&dyn Cache>,
    ) -> Self {
        let (width, height) = texture_size(sides);
        let desc = TextureDesc::new_2d(width, height, gpu.capabilities.tiles_format);
        let texture = create(gpu, "environment", desc, wgpu::TextureUsages::RENDER_ATTACHMENT);
        let view = texture.create_view(&Default::default());
        let of = Arc::downgrade(map);
        let factor = shrink_factor(map, gpu.capabilities.max_texture_size);
        let picture_size = (map.width / factor, map.height / factor);
        let warning = (factor > 1).then(|| shrink_warning(map, picture_size, gpu.capabilities.max_texture_size));
        let missing = cache.map(|_| stored::name_of(gpu, map, (sides, has_suns)));
        let entry = cache.zip(missing.as_ref()).and_then(|(cache, name)| cache.get(name));
        if let Some((suns, texels)) = entry.as_ref().and_then(|entry| stored::tiles_of(entry, desc.bytes() as usize)) {
            write_bytes(gpu, (&texture, [0, 0]), (width, height), texels);
            return Self {
                view,
                desc,
                sides,
                suns,
                light: map.light,
                of,
                is_of_place: false,
                unfinished: None,
                warning,
                missing: None,
            };
        }
        let last = ENVIRONMENT_LEVEL_LAST as u32;
        if let Some(prefiltered) = &map.prefiltered {
            // Not the last, which is that of irradiance, too: levels made elsewhere are often too few for it.
            for level in 1..last {
                let roughness = roughness_of_level(level as f32);
                write_tile(gpu, &texture, Tile::of_level(level, sides), |to| prefiltered.reflected(to, roughness));
            }
        }
        if let Some(irradiance) = &map.irradiance {
            write_tile(gpu, &texture, Tile::of_level(last, sides), |to| irradiance.seen(to));
        }
        let picture_desc = TextureDesc::new_2d(picture_size.0, picture_size.1, ENVIRONMENT_FORMAT);
        let picture = create(gpu, "environment.picture", picture_desc, wgpu::TextureUsages::empty());
        match factor {
            1 => write(gpu, &picture, picture_size, &map.texels),
            _ => write(gpu, &picture, picture_size, &shrunk(map, factor)),
        }
        let source_side = source_side(map.width);
        let lobes = Lobe::of_levels(source_side);
        Self {
            view,
            desc,
            sides,
            suns: if has_suns { suns(map) } else { Suns::default() },
            light: map.light,
            of,
            is_of_place: false,
            warning,
            missing,
            unfinished: Some(TileSources {
                picture: picture.create_view(&Default::default()),
                picture_desc,
                source_side,
                table: LobeTable::new(gpu, &lobes),
                lobes,
                is_prefiltered: map.prefiltered.is_some(),
                has_irradiance: map.irradiance.is_some(),
            }),
        }
    }

    /// Of the studio.
    pub fn of_studio(gpu: &Gpu) -> Self {
        let sides = studio::SIDES;
        let (width, height) = texture_size(sides);
        let desc = TextureDesc::new_2d(width, height, gpu.capabilities.tiles_format);
        let texture = create(gpu, "environment.studio", desc, wgpu::TextureUsages::empty());
        write(gpu, &texture, (width, height), studio::texels());
        let view = texture.create_view(&Default::default());
        let (suns, of) = (Suns::default(), Weak::new());
        Self {
            view,
            desc,
            sides,
            suns,
            light: None,
            of,
            is_of_place: false,
            unfinished: None,
            warning: None,
            missing: None,
        }
    }

    /// Whether they are those of `map`, as an environment or as what is to be seen around a place.
    pub fn are_of(&self, map: &Arc<EnvironmentMap>, is_of_place: bool) -> bool {
        self.is_of_place == is_of_place && std::ptr::eq(self.of.as_ptr(), Arc::as_ptr(map))
    }

    /// What is to be drawn, if it was not yet.
    pub fn unfinished(&self) -> Option<&TileSources> {
        self.unfinished.as_ref()
    }

    /// Says that they are drawn, by a frame that was submitted, and frees the picture that they were drawn from.
    pub fn finish(&mut self) {
        if let Some(drawn) = self.unfinished.take() {
            destroy(&drawn.picture);
        }
    }

    /// The name under which a cache lacks them, once, as soon as they are drawn.
    pub fn take_missing(&mut self) -> Option<String> {
        if self.unfinished.is_some() { None } else { self.missing.take() }
    }

    /// What is to be said of the picture.
    pub fn warning(&self) -> Option<&String> {
        self.warning.as_ref()
    }

    /// How many suns it has; they are the first.
    pub fn sun_count(&self) -> u32 {
        self.suns.iter().filter(|sun| sun.irradiance != Vec3::ZERO).count() as u32
    }

    /// Bytes of the texture.
    pub fn bytes(&self) -> u64 {
        self.desc.bytes()
    }
}

/// The side of the faces that lobes are sampled from, of a picture of a width.
fn source_side(width: u32) -> u32 {
    (width / 2).clamp(SOURCE_SIDES.0, SOURCE_SIDES.1).next_power_of_two()
}

/// By which whole factor a picture is made smaller so that no side is longer than `limit` texels.
fn shrink_factor(map: &EnvironmentMap, limit: u32) -> u32 {
    map.width.max(map.height).div_ceil(limit).max(1)
}

fn shrink_warning(map: &EnvironmentMap, (width, height): (u32, u32), limit: u32) -> String {
    let EnvironmentMap { name, width: from_width, height: from_height, .. } = map;
    format!(
        "environment \"{name}\": {from_width}x{from_height} is larger than the adapter's {limit} texels a side; \
         made smaller, {width}x{height}"
    )
}

/// The texels of a picture that is smaller by a whole factor: means.
fn shrunk(map: &EnvironmentMap, factor: u32) -> Vec<[f16; 4]> {
    let (width, height) = (map.width / factor, map.height / factor);
    let mean = |i: u32| {
        let (left, top) = (i % width * factor, i / width * factor);
        let rows = (top..top + factor).map(|row| (row * map.width + left) as usize);
        let texels = rows.flat_map(|first| &map.texels[first..][..factor as usize]);
        let sum = texels.fold(Vec3::ZERO, |sum, [r, g, b, _]| sum + Vec3::new(r.to_f32(), g.to_f32(), b.to_f32()));
        let [r, g, b] = (sum / (factor * factor) as f32).to_array().map(f16::from_f32);
        [r, g, b, f16::ONE]
    };
    (0..width * height).map(mean).collect()
}

/// Bytes that the tiles of a map take while they are drawn: its picture and a copy on the way, the tiles, the cube map
/// with its halves.
pub(crate) fn upload_bytes_of(map: &EnvironmentMap) -> u64 {
    let texel_bytes = 8;
    let (width, height) = texture_size(TileSides::of_picture(map.width, u32::MAX));
    let source_side = u64::from(source_side(map.width));
    // Tiles may be 32-bit floats, and there is a copy of those, too, on the way to a cache or from it.
    let texels = 2 * u64::from(map.width) * u64::from(map.height)
        + 4 * u64::from(width) * u64::from(height)
        + 6 * source_side * source_side * 4 / 3;
    texels * texel_bytes
}

/// A texture without light, for views whose environment is no picture.
pub(crate) fn no_tiles(gpu: &Gpu) -> wgpu::TextureView {
    let desc = TextureDesc::new_2d(1, 1, gpu.capabilities.tiles_format);
    let texture = create(gpu, "no_environment", desc, wgpu::TextureUsages::empty());
    write(gpu, &texture, (1, 1), &[[f16::ZERO; 4]]);
    texture.create_view(&Default::default())
}

fn create(gpu: &Gpu, label: &str, desc: TextureDesc, usage: wgpu::TextureUsages) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: desc.width, height: desc.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: desc.format,
        usage: usage
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Writes a tile, with its border, of what `radiance` gives by direction.
fn write_tile(gpu: &Gpu, texture: &wgpu::Texture, tile: Tile, radiance: impl Fn(Vec3) -> Vec3) {
    let [left, top, width, height] = tile.rectangle();
    let texel = |i: u32| {
        let radiance = radiance(tile.direction([i % width, i / width]));
        let [red, green, blue] = radiance.min(Vec3::splat(RADIANCE_MAX)).to_array().map(f16::from_f32);
        [red, green, blue, f16::ONE]
    };
    let texels: Vec<[f16; 4]> = (0..width * height).map(texel).collect();
    write_texels(gpu, (texture, [left, top]), (width, height), &texels);
}

fn write(gpu: &Gpu, texture: &wgpu::Texture, size: (u32, u32), texels: &[[f16; 4]]) {
    write_texels(gpu, (texture, [0, 0]), size, texels);
}

/// Writes half floats into a rectangle of a texture that has those, or 32-bit floats.
pub(crate) fn write_texels(gpu: &Gpu, to: (&wgpu::Texture, [u32; 2]), size: (u32, u32), texels: &[[f16; 4]]) {
    if to.0.format() == wgpu::TextureFormat::Rgba32Float {
        let texels: Vec<[f32; 4]> = texels.iter().map(|texel| texel.map(f16::to_f32)).collect();
        write_bytes(gpu, to, size, bytemuck::cast_slice(&texels));
    } else {
        write_bytes(gpu, to, size, bytemuck::cast_slice(texels));
    }
}

fn write_bytes(gpu: &Gpu, (texture, [x, y]): (&wgpu::Texture, [u32; 2]), (width, height): (u32, u32), bytes: &[u8]) {
    let row_bytes = texture.format().block_copy_size(None).map(|texel_bytes| texel_bytes * width);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: row_bytes, rows_per_image: None };
    let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let place = wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: 0 }, ..texture.as_image_copy() };
    gpu.queue.write_texture(place, bytes, layout, extent);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_fits_the_adapter_and_keeps_its_light() {
        let map = EnvironmentMap::from_fn("wide", 64, 32, |to| Vec3::new(to.x + 1.0, 2.0 * to.y + 2.0, 4.0));
        assert_eq!([64, 4096].map(|limit| shrink_factor(&map, limit)), [1, 1]);
        let factor = shrink_factor(&map, 20);
        let texels = shrunk(&map, factor);
        assert_eq!((factor, texels.len()), (4, 16 * 8));
        let small = EnvironmentMap::from_fn("small", 16, 8, |to| Vec3::new(to.x + 1.0, 2.0 * to.y + 2.0, 4.0));
        for (found, expected) in texels.iter().zip(&small.texels) {
            // Four texels are a quarter of a radian wide, and what they see goes as a sine.
            let differ = |channel: usize| (found[channel].to_f32() - expected[channel].to_f32()).abs();
            assert!((0..4).map(differ).fold(0.0, f32::max) < 0.03, "{found:?} {expected:?}");
        }
        let warning = shrink_warning(&map, (16, 8), 20);
        assert!(warning.contains("\"wide\": 64x32") && warning.ends_with("16x8"), "{warning}");
    }
}
