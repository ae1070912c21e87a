//! Textures: images are decoded, given their mips and uploaded one after the other, few at a time in memory.

use super::filtering::Sampling;
use super::packing::{ImageSource, shared_texel, wanted};
use crate::colour::{linear_from_srgb, srgb_from_linear};
use crate::gpu::Gpu;
use manypass_scene::{Material, Pixels, Sampler, Scene, Wrap};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// The textures of a scene.
#[derive(Debug)]
pub struct Textures {
    views: Vec<wgpu::TextureView>,
    /// The ways of sampling that the scene's textures ask for.
    kinds: Vec<Sampler>,
    /// Samplers by index of their kind and how they filter.
    samplers: RefCell<BTreeMap<(usize, Sampling), wgpu::Sampler>>,
    device: wgpu::Device,
    /// For every texture of the scene: the index of its view as data and as colour, and of its sampler.
    entries: Vec<[usize; 2]>,
    sampler_of: Vec<usize>,
    /// How many of the entries, after the first, are the scene's; the others are packed.
    texture_count: usize,
    /// Indices of the entries of packed textures, by the textures of occlusion and of metallic-roughness.
    packed: BTreeMap<(usize, usize), usize>,
    /// Milliseconds in which decoding, which runs beside the uploads, held them up.
    pub decode_ms: f64,
}

/// An image with all its mips, the largest first.
struct MipChain {
    levels: Vec<Pixels>,
}

impl Textures {
    /// The index of a white texel.
    pub const WHITE: usize = 0;

    /// Uploads every image that a material uses.
    pub fn new(gpu: &Gpu, scene: &Scene, warnings: &mut Vec<String>) -> Self {
        let white = Pixels { width: 1, height: 1, format: manypass_scene::PixelFormat::Rgba8, data: vec![255; 4] };
        let mut views = vec![create(gpu, "white", &MipChain { levels: vec![white] }, false)];
        let mut uploaded: BTreeMap<ImageSource, usize> = BTreeMap::new();
        let limit = gpu.capabilities.max_texture_size;
        let started = web_time::Instant::now();
        let mut upload_ms = 0.0;
        decode_all(scene, &wanted(scene), limit, &mut |source, decoded| {
            warnings.extend(decoded.warnings);
            let Some(chain) = decoded.chain else { return };
            let started = web_time::Instant::now();
            let (image, is_srgb) = match source {
                ImageSource::Image { image, is_srgb } => (image, is_srgb),
                ImageSource::Packed { metallic_roughness, .. } => (metallic_roughness, false),
            };
            uploaded.insert(source, views.len());
            views.push(create(gpu, &scene.images[image].name, &chain, is_srgb));
            upload_ms += started.elapsed().as_secs_f64() * 1e3;
        });
        let decode_ms = (started.elapsed().as_secs_f64() * 1e3 - upload_ms).max(0.0);
        let mut kinds: Vec<Sampler> = vec![Sampler::default()];
        let mut sampler_of = vec![0];
        let mut entries = vec![[Self::WHITE; 2]];
        for texture in &scene.textures {
            let sampler = kinds.iter().position(|known| *known == texture.sampler).unwrap_or_else(|| {
                kinds.push(texture.sampler);
                kinds.len() - 1
            });
            sampler_of.push(sampler);
            let view = |is_srgb| {
                let source = ImageSource::Image { image: texture.image, is_srgb };
                uploaded.get(&source).copied().unwrap_or(Self::WHITE)
            };
            entries.push([view(false), view(true)]);
        }
        let mut packed = BTreeMap::new();
        for material in &scene.materials {
            let (Some(occlusion), Some(rough_metal), Some((occlusion_image, metallic_roughness))) = (
                material.occlusion_texture,
                material.metallic_roughness_texture,
                shared_texel(scene, material).filter(|(first, second)| first != second),
            ) else {
                continue;
            };
            let source = ImageSource::Packed { occlusion: occlusion_image, metallic_roughness };
            let Some(view) = uploaded.get(&source) else { continue };
            packed.entry((occlusion.texture, rough_metal.texture)).or_insert_with(|| {
                entries.push([*view; 2]);
                sampler_of.push(sampler_of[rough_metal.texture + 1]);
                entries.len() - 1
            });
        }
        let (samplers, device) = (RefCell::default(), gpu.device.clone());
        let texture_count = scene.textures.len();
        Self { views, kinds, samplers, device, entries, sampler_of, texture_count, packed, decode_ms }
    }

    /// The keys of a material's metallic-roughness and occlusion. Where one sample gives both, occlusion has none of its
    /// own.
    pub fn rough_metal_occlusion(&self, scene: &Scene, material: &Material) -> (usize, Option<usize>) {
        let [rough_metal, occlusion] = [material.metallic_roughness_texture, material.occlusion_texture];
        let key = |texture: usize| self.index_of(texture, false);
        let rough_metal_key = rough_metal.map_or(Self::WHITE, |reference| key(reference.texture));
        match (rough_metal, occlusion, shared_texel(scene, material)) {
            (Some(rough_metal), Some(occlusion), Some(_)) => {
                let packed = self.packed.get(&(occlusion.texture, rough_metal.texture));
                (packed.map_or(rough_metal_key, |entry| entry * 2), None)
            }
            _ => (rough_metal_key, occlusion.map(|reference| key(reference.texture))),
        }
    }

    /// Whether occlusion and metallic-roughness of a material are one texture that is neither of the two images.
    pub fn is_packed(&self, material: &Material) -> bool {
        let [rough_metal, occlusion] = [material.metallic_roughness_texture, material.occlusion_texture];
        let textures = occlusion.zip(rough_metal).map(|(first, second)| (first.texture, second.texture));
        textures.is_some_and(|textures| self.packed.contains_key(&textures))
    }

    /// Whether the texture of the scene has an image; materials do without one that has none, as if they did not name it.
    pub fn is_there(&self, texture: usize, is_srgb: bool) -> bool {
        self.entries[self.index_of(texture, is_srgb) / 2][usize::from(is_srgb)] != Self::WHITE
    }

    /// A key for [`Self::view`] and [`Self::sampler`]: the texture of the scene, as colour or as data.
    pub fn index_of(&self, texture: usize, is_srgb: bool) -> usize {
        if texture < self.texture_count { (texture + 1) * 2 + usize::from(is_srgb) } else { Self::WHITE }
    }

    /// The view behind a key.
    pub fn view(&self, key: usize) -> &wgpu::TextureView {
        &self.views[self.entries[key / 2][key % 2]]
    }

    /// The sampler behind a key.
    pub fn sampler(&self, key: usize, sampling: Sampling) -> wgpu::Sampler {
        let kind = self.sampler_of[key / 2];
        let mut samplers = self.samplers.borrow_mut();
        samplers
            .entry((kind, sampling))
            .or_insert_with(|| create_sampler(&self.device, &self.kinds[kind], sampling))
            .clone()
    }
}

/// An image for the device, with what there is to say about it.
struct Decoded {
    chain: Option<MipChain>,
    warnings: Vec<String>,
}

fn decode(scene: &Scene, source: ImageSource, limit: u32) -> Decoded {
    let mut warnings = Vec::new();
    let (base, is_srgb) = match source {
        ImageSource::Image { image, is_srgb } => (decode_base(scene, image, is_srgb, limit, &mut warnings), is_srgb),
        ImageSource::Packed { occlusion, metallic_roughness } => {
            let mut decode = |image| decode_base(scene, image, false, limit, &mut warnings);
            let (occlusion, rough_metal) = (decode(occlusion), decode(metallic_roughness));
            (pack(occlusion, rough_metal), false)
        }
    };
    let chain = base.map(|base| {
        let mut levels = vec![base];
        while let Some(last) = levels.last()
            && (last.width > 1 || last.height > 1)
        {
            let next = half(last, is_srgb);
            levels.push(next);
        }
        MipChain { levels }
    });
    Decoded { chain, warnings }
}

/// An image no larger than `limit` texels; none, with a warning, if it cannot be decoded.
fn decode_base(scene: &Scene, image: usize, is_srgb: bool, limit: u32, warnings: &mut Vec<String>) -> Option<Pixels> {
    let source = &scene.images[image];
    let name = &source.name;
    let mut pixels = match source.decode() {
        Ok(pixels) => pixels,
        Err(error) => {
            warnings.push(format!("image {image} `{name}` cannot be decoded, and materials do without it: {error}"));
            return None;
        }
    };
    if pixels.width.max(pixels.height) > limit {
        warnings.push(format!("image {image} `{name}` is larger than the adapter's {limit} texels; halved"));
    }
    while pixels.width.max(pixels.height) > limit {
        pixels = half(&pixels, is_srgb);
    }
    Some(pixels)
}

/// Occlusion in the red channel of metallic-roughness; what is missing is white.
fn pack(occlusion: Option<Pixels>, rough_metal: Option<Pixels>) -> Option<Pixels> {
    match (occlusion, rough_metal) {
        (Some(occlusion), Some(mut rough_metal)) => {
            for (texel, occlusion) in rough_metal.data.chunks_exact_mut(4).zip(occlusion.data.chunks_exact(4)) {
                texel[0] = occlusion[0];
            }
            Some(rough_metal)
        }
        (Some(mut occlusion), None) => {
            occlusion.data.chunks_exact_mut(4).for_each(|texel| texel[1..].fill(255));
            Some(occlusion)
        }
        (None, Some(mut rough_metal)) => {
            rough_metal.data.chunks_exact_mut(4).for_each(|texel| texel[0] = 255);
            Some(rough_metal)
        }
        (None, None) => None,
    }
}

/// Decodes on two threads, and hands over in order as results come; at most four images wait in memory.
#[cfg(not(target_arch = "wasm32"))]
fn decode_all(scene: &Scene, wanted: &[ImageSource], limit: u32, take: &mut dyn FnMut(ImageSource, Decoded)) {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let next = AtomicUsize::new(0);
    let workers = std::thread::available_parallelism().map_or(1, usize::from).clamp(1, 4).min(wanted.len().max(1));
    let (sender, receiver) = std::sync::mpsc::sync_channel(2);
    std::thread::scope(|scope| {
        let mut has_worker = false;
        for _ in 0..workers {
            let (sender, next) = (sender.clone(), &next);
            let work = move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(key) = wanted.get(index) else { return };
                    if sender.send((*key, decode(scene, *key, limit))).is_err() {
                        return;
                    }
                }
            };
            has_worker |= std::thread::Builder::new().spawn_scoped(scope, work).is_ok();
        }
        drop(sender);
        // A process that may have no more threads decodes on this one.
        for key in wanted.iter().filter(|_| !has_worker) {
            take(*key, decode(scene, *key, limit));
        }
        for (key, result) in receiver {
            take(key, result);
        }
    });
}

#[cfg(target_arch = "wasm32")]
fn decode_all(scene: &Scene, wanted: &[ImageSource], limit: u32, take: &mut dyn FnMut(ImageSource, Decoded)) {
    for key in wanted {
        take(*key, decode(scene, *key, limit));
    }
}

/// Linear values of sRGB bytes, scaled to 16 bits, and back through 12 bits (4,096 steps keep the error below one byte).
struct SrgbTables {
    linear: [u16; 256],
    srgb: [u8; 4096],
}

static SRGB: std::sync::LazyLock<SrgbTables> = std::sync::LazyLock::new(|| SrgbTables {
    linear: std::array::from_fn(|i| (linear_from_srgb(i as f32 / 255.0) * 65535.0).round() as u16),
    srgb: std::array::from_fn(|i| (srgb_from_linear(i as f32 / 4095.0) * 255.0).round() as u8),
});

/// Half the width and height by a box filter, in linear light for colours; where a size is 1 it stays.
fn half(pixels: &Pixels, is_srgb: bool) -> Pixels {
    if [pixels.width, pixels.height].iter().any(|size| *size > 1 && size % 2 == 1) {
        return half_of_odd(pixels, is_srgb);
    }
    let (width, height) = ((pixels.width / 2).max(1), (pixels.height / 2).max(1));
    let tables = &*SRGB;
    let linear_sum = |texels: [u8; 4]| texels.iter().map(|t| u32::from(tables.linear[usize::from(*t)])).sum::<u32>();
    // The mean of four 16-bit values, rounded to 12 bits.
    let color = |texels: [u8; 4]| tables.srgb[(((linear_sum(texels) + 32) >> 6) as usize).min(4095)];
    let value = |texels: [u8; 4]| ((texels.iter().map(|t| u32::from(*t)).sum::<u32>() + 2) / 4) as u8;
    let mut data = vec![0; (width * height * 4) as usize];
    let stride = pixels.width as usize * 4;
    for (y, row) in data.chunks_exact_mut(width as usize * 4).enumerate() {
        let row_of = |y: usize| &pixels.data[y.min(pixels.height as usize - 1) * stride..][..stride];
        let (row0, row1) = (row_of(2 * y), row_of(2 * y + 1));
        // Two texels become one; where the width is 1, the one is both.
        let step = if pixels.width == 1 { 4 } else { 8 };
        let right = step - 4;
        for ((texel, above), below) in row.chunks_exact_mut(4).zip(row0.chunks_exact(step)).zip(row1.chunks_exact(step))
        {
            let four = |c: usize| [above[c], above[right + c], below[c], below[right + c]];
            if is_srgb {
                texel.copy_from_slice(&[color(four(0)), color(four(1)), color(four(2)), value(four(3))]);
            } else {
                texel.copy_from_slice(&[value(four(0)), value(four(1)), value(four(2)), value(four(3))]);
            }
        }
    }
    Pixels { width, height, format: pixels.format, data }
}

/// What a texel of the next mip covers along one side of `size` texels: the first texel and the weights from there on. An
/// odd size 2 m + 1 becomes m, each of them as wide as 2 + 1/m texels, so that every texel counts for the same (polyphase
/// box filter; Guthe & Heckbert 2005, "Non-power-of-two mipmap creation").
fn footprint(size: usize, index: usize) -> (usize, [u64; 3]) {
    let half = size / 2;
    let weights = match size {
        1 => [1, 0, 0],
        _ if size.is_multiple_of(2) => [1, 1, 0],
        _ => [half - index, half, index + 1].map(|weight| weight as u64),
    };
    (2 * index, weights)
}

/// [`half`] for any size.
fn half_of_odd(pixels: &Pixels, is_srgb: bool) -> Pixels {
    let (from_width, from_height) = (pixels.width as usize, pixels.height as usize);
    let (width, height) = ((from_width / 2).max(1), (from_height / 2).max(1));
    let tables = &*SRGB;
    let weight_sum = |size| footprint(size, 0).1.iter().sum::<u64>();
    let total = weight_sum(from_width) * weight_sum(from_height);
    let stride = from_width * 4;
    let mut data = Vec::with_capacity(width * height * 4);
    // Weighted sums of the rows that a row of the result covers.
    let mut sums = vec![0u64; stride];
    for y in 0..height {
        sums.fill(0);
        let (first, weights) = footprint(from_height, y);
        for (row, weight) in pixels.data.chunks_exact(stride).skip(first).zip(weights) {
            for (at, (byte, sum)) in row.iter().zip(&mut sums).enumerate() {
                let is_color = is_srgb && at % 4 < 3;
                let value = if is_color { tables.linear[usize::from(*byte)] } else { u16::from(*byte) };
                *sum += weight * u64::from(value);
            }
        }
        for x in 0..width {
            let (first, weights) = footprint(from_width, x);
            for channel in 0..4 {
                let columns = sums[channel..].iter().step_by(4).skip(first).zip(weights);
                let sum: u64 = columns.map(|(sum, weight)| sum * weight).sum();
                data.push(if is_srgb && channel < 3 {
                    // The mean of 16-bit values, rounded to 12 bits.
                    tables.srgb[((sum + 8 * total) / (16 * total)).min(4095) as usize]
                } else {
                    ((sum + total / 2) / total) as u8
                });
            }
        }
    }
    Pixels { width: width as u32, height: height as u32, format: pixels.format, data }
}

fn create(gpu: &Gpu, label: &str, chain: &MipChain, is_srgb: bool) -> wgpu::TextureView {
    let base = &chain.levels[0];
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: base.width, height: base.height, depth_or_array_layers: 1 },
        mip_level_count: chain.levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: if is_srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm },
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (level, pixels) in chain.levels.iter().enumerate() {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level: level as u32,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            &pixels.data,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pixels.width * 4), rows_per_image: None },
            wgpu::Extent3d { width: pixels.width, height: pixels.height, depth_or_array_layers: 1 },
        );
    }
    // Staging memory is given back after every image, not after the last.
    gpu.queue.submit([]);
    texture.create_view(&Default::default())
}

fn create_sampler(device: &wgpu::Device, sampler: &Sampler, sampling: Sampling) -> wgpu::Sampler {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        Wrap::ClampToEdge => wgpu::AddressMode::ClampToEdge,
    };
    let filter = |linear| if linear { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest };
    // Whoever asks for unfiltered texels gets them; and WebGPU allows anisotropy only where all else is linear.
    let is_linear = sampler.mag_linear && sampler.min_linear && sampler.mip_linear == Some(true);
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("material"),
        address_mode_u: wrap(sampler.wrap_u),
        address_mode_v: wrap(sampler.wrap_v),
        mag_filter: filter(sampler.mag_linear),
        min_filter: filter(sampler.min_linear),
        mipmap_filter: match sampler.mip_linear {
            Some(true) if sampling.blends_mips => wgpu::MipmapFilterMode::Linear,
            _ => wgpu::MipmapFilterMode::Nearest,
        },
        // Without mips only the first level is there to sample: what is nearest to 0.25. At 0 itself Vulkan takes the filter
        // of magnification for every size (its specification, on `VkSamplerCreateInfo` and filters of OpenGL).
        lod_max_clamp: if sampler.mip_linear.is_some() { 32.0 } else { 0.25 },
        anisotropy_clamp: if is_linear { sampling.anisotropy } else { 1 },
        ..Default::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, level: impl Fn(u32, u32) -> u8) -> Pixels {
        let texel = |i: u32| [[level(i % width, i / width); 3].as_slice(), &[255]].concat();
        Pixels {
            width,
            height,
            format: manypass_scene::PixelFormat::Rgba8,
            data: (0..width * height).flat_map(texel).collect(),
        }
    }

    fn levels(pixels: &Pixels) -> Vec<u8> {
        pixels.data.chunks_exact(4).map(|texel| texel[0]).collect()
    }

    #[test]
    fn every_texel_counts_for_the_same_in_the_next_mip() {
        // A row of three becomes one texel, a row of five two: 2/5, 2/5, 1/5 and the other way round.
        assert_eq!(levels(&half(&grey(3, 1, |x, _| [0, 0, 255][x as usize]), false)), [85]);
        assert_eq!(levels(&half(&grey(1, 3, |_, y| [0, 0, 255][y as usize]), false)), [85]);
        assert_eq!(levels(&half(&grey(5, 1, |x, _| [0, 0, 250, 0, 0][x as usize]), false)), [50, 50]);
        assert_eq!(levels(&half(&grey(5, 1, |x, _| [250, 0, 0, 0, 0][x as usize]), false)), [100, 0]);
        // In linear light a third of white is 0.333, which is 156 in sRGB.
        assert_eq!(levels(&half(&grey(3, 1, |x, _| [0, 0, 255][x as usize]), true)), [156]);
        for (width, height) in [(7, 5), (9, 4), (4, 9), (37, 1), (1, 37), (641, 3)] {
            // Whatever stands in a corner, and a pattern, leave the mean as it is but for rounding.
            for pattern in [|x: u32, y: u32| ((x * 89 + y * 57) % 256) as u8, |x, y| if x + y == 0 { 240 } else { 9 }] {
                let image = grey(width, height, pattern);
                let mean = |pixels: &Pixels| {
                    let levels = levels(pixels);
                    levels.iter().map(|level| f64::from(*level)).sum::<f64>() / levels.len() as f64
                };
                let (before, after) = (mean(&image), mean(&half(&image, false)));
                assert!((before - after).abs() <= 0.5, "{width}x{height}: {before} becomes {after}");
            }
        }
    }

    #[test]
    fn mips_of_even_sizes_are_means_of_four_texels() {
        let image = grey(4, 2, |x, y| [[10, 20, 255, 255], [30, 41, 255, 0]][y as usize][x as usize]);
        assert_eq!(levels(&half(&image, false)), [25, 191]);
        assert_eq!(levels(&half(&image, true)), [27, 225]);
        assert_eq!(levels(&half(&grey(2, 1, |x, _| [10, 21][x as usize]), false)), [16]);
        for is_srgb in [false, true] {
            assert_eq!(half(&image, is_srgb), half_of_odd(&image, is_srgb));
        }
    }
}
