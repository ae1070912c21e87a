//! Textures: images are decoded, given their mips and uploaded one after the other, few at a time in memory.

use super::filtering::Sampling;
use super::packing::{ImageSource, shared_texel, wanted};
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
            packed.entry((occlusion.texture, rough_metal.texture)).or_insert_with(|| {
                let source = ImageSource::Packed { occlusion: occlusion_image, metallic_roughness };
                entries.push([uploaded.get(&source).copied().unwrap_or(Self::WHITE); 2]);
                sampler_of.push(sampler_of[rough_metal.texture + 1]);
                entries.len() - 1
            });
        }
        let (samplers, device) = (RefCell::default(), gpu.device.clone());
        Self { views, kinds, samplers, device, entries, sampler_of, packed, decode_ms }
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

    /// A key for [`Self::view`] and [`Self::sampler`]: the texture of the scene, as colour or as data.
    pub fn index_of(&self, texture: usize, is_srgb: bool) -> usize {
        if texture + 1 < self.entries.len() { (texture + 1) * 2 + usize::from(is_srgb) } else { Self::WHITE }
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
            warnings.push(format!("image {image} `{name}` cannot be decoded and is white: {error}"));
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

static SRGB: std::sync::LazyLock<SrgbTables> = std::sync::LazyLock::new(|| {
    let linear_of = |s: f64| if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
    let srgb_of = |l: f64| if l <= 0.0031308 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    SrgbTables {
        linear: std::array::from_fn(|i| (linear_of(i as f64 / 255.0) * 65535.0).round() as u16),
        srgb: std::array::from_fn(|i| (srgb_of(i as f64 / 4095.0) * 255.0).round() as u8),
    }
});

/// Half the width and height by a box filter, in linear light for colours. Odd sizes repeat their last row or column.
fn half(pixels: &Pixels, is_srgb: bool) -> Pixels {
    let (width, height) = ((pixels.width / 2).max(1), (pixels.height / 2).max(1));
    let tables = &*SRGB;
    let mut data = Vec::with_capacity((width * height * 4) as usize);
    let stride = pixels.width as usize * 4;
    for y in 0..height as usize {
        let y0 = (2 * y).min(pixels.height as usize - 1);
        let y1 = (2 * y + 1).min(pixels.height as usize - 1);
        let (row0, row1) = (&pixels.data[y0 * stride..][..stride], &pixels.data[y1 * stride..][..stride]);
        for x in 0..width as usize {
            let x0 = (2 * x).min(pixels.width as usize - 1) * 4;
            let x1 = (2 * x + 1).min(pixels.width as usize - 1) * 4;
            for channel in 0..4 {
                let texels = [row0[x0 + channel], row0[x1 + channel], row1[x0 + channel], row1[x1 + channel]];
                data.push(if is_srgb && channel < 3 {
                    let sum: u32 = texels.iter().map(|t| u32::from(tables.linear[usize::from(*t)])).sum();
                    // The mean of four 16-bit values, rounded to 12 bits.
                    tables.srgb[(((sum + 32) >> 6) as usize).min(4095)]
                } else {
                    ((texels.iter().map(|t| u32::from(*t)).sum::<u32>() + 2) / 4) as u8
                });
            }
        }
    }
    Pixels { width, height, format: pixels.format, data }
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
        // Without mips only the first level is there to sample.
        lod_max_clamp: if sampler.mip_linear.is_some() { 32.0 } else { 0.0 },
        anisotropy_clamp: if is_linear { sampling.anisotropy } else { 1 },
        ..Default::default()
    })
}
