//! Textures on the device: those that materials use, by the images that they are made from.

use super::decode::{DecodedImage, Limits, decode_all};
use super::filtering::Sampling;
use super::mips::{MipChain, Texels};
use super::packing::{ImageSource, layer_images, wanted};
use super::{ResourceChanges, STAGED_BYTES, WRITE_BYTES};
use crate::gpu::{Gpu, destroy};
use manypass_graph::TextureDesc;
use manypass_scene::capture::MONITOR_SIDE_MAX;
use manypass_scene::material::LightEncoding;
use manypass_scene::simulation::SimulatedImage;
use manypass_scene::{BlockFormat, Pixels, Sampler, Scene, Wrap};
use std::cell::RefCell;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU32;
use std::sync::{Arc, Weak};

/// An image's place in memory. As long as somebody holds on to it no other image takes the place.
#[derive(Clone, Debug)]
enum ImageHold {
    Encoded { _held: Weak<[u8]> },
    Pixels { _held: Weak<Pixels> },
}

/// What tells two images apart.
pub(crate) type Address = usize;

/// A texture, and what it is sampled with.
pub(crate) type SampledTexture = (wgpu::TextureView, Sampler);

/// What tells two textures apart.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Content {
    /// Images, and whether they are heights.
    Layers {
        images: Vec<(Address, bool)>,
        is_srgb: bool,
    },
    Image {
        image: Address,
        is_srgb: bool,
    },
    Light {
        image: Address,
        encoding: LightEncoding,
        direction: Option<Address>,
    },
    Packed {
        occlusion: Address,
        metallic_roughness: Address,
    },
    /// What the monitor of an image shows, by the image's index: whatever its camera sees, it is one texture.
    Monitor {
        image: usize,
        size: (u32, u32),
    },
    /// A picture of a simulation.
    Simulation(SimulatedImage),
}

#[derive(Debug, Default)]
struct TextureUpload {
    /// None if the image cannot be decoded.
    view: Option<wgpu::TextureView>,
    /// Its first mip of at most [`COARSE_SIDE`] texels a side, unless it is compressed or has layers.
    coarse: Option<Pixels>,
    bytes: u64,
    warnings: Vec<String>,
    /// The images that it was made from.
    _made_from: Vec<ImageHold>,
}

/// What is known of a texture beside the device: fine enough to tell parts of it apart, and 1 KiB.
const COARSE_SIDE: u32 = 16;

/// The textures of a scene.
#[derive(Debug)]
pub(crate) struct Textures {
    device: wgpu::Device,
    white: wgpu::TextureView,
    /// The same as a texture of one layer.
    white_layer: wgpu::TextureView,
    uploaded: BTreeMap<Content, TextureUpload>,
    /// The pictures of simulations.
    simulated: BTreeMap<SimulatedImage, wgpu::TextureView>,
    /// Whether any of them took the place of another one.
    has_lost: bool,
    /// The greatest width and height that is wanted, if any is.
    max_px: Option<NonZeroU32>,
    /// Whether what is uploaded was made for another one.
    is_stale: bool,
    /// Samplers by what the scene asks for and how they filter.
    samplers: RefCell<BTreeMap<(Sampler, Sampling), wgpu::Sampler>>,
    /// Milliseconds in which decoding, which runs beside the uploads, held them up, when textures were last uploaded.
    pub decode_ms: f64,
}

impl Textures {
    /// No textures yet.
    pub fn new(gpu: &Gpu) -> Self {
        let white = Pixels { width: 1, height: 1, format: manypass_scene::PixelFormat::Rgba8, data: vec![255; 4] };
        let white = MipChain::of(white, false);
        Self {
            white: create(gpu, "white", &white, false, false),
            white_layer: create(gpu, "white", &white, false, true),
            device: gpu.device.clone(),
            uploaded: BTreeMap::new(),
            simulated: BTreeMap::new(),
            has_lost: false,
            max_px: None,
            is_stale: false,
            samplers: RefCell::default(),
            decode_ms: 0.0,
        }
    }

    /// Sets the greatest width and height, 0 for none; true if it was another one.
    pub fn limit(&mut self, max_px: u32) -> bool {
        let max_px = NonZeroU32::new(max_px);
        let is_other = self.max_px != max_px;
        self.is_stale |= is_other;
        self.max_px = max_px;
        is_other
    }

    /// Uploads every image that a material uses and that is not there yet, and gives back those that none uses any
    /// more.
    pub fn follow(&mut self, gpu: &Gpu, scene: &Scene) -> ResourceChanges {
        let started = web_time::Instant::now();
        let all: Vec<(ImageSource, Content)> =
            wanted(scene).into_iter().filter_map(|source| Some((source, content_of(scene, source)?))).collect();
        let contents: BTreeSet<Content> = all.iter().map(|(_, content)| content.clone()).collect();
        let known = self.uploaded.len();
        let is_stale = std::mem::take(&mut self.is_stale);
        self.uploaded.retain(|content, uploaded| {
            let is_kept = !is_stale && contents.contains(content);
            // Simulations hold their pictures themselves.
            if let Some(view) =
                uploaded.view.as_ref().filter(|_| !is_kept && !matches!(content, Content::Simulation(_)))
            {
                destroy(view);
            }
            is_kept
        });
        let has_moved = std::mem::take(&mut self.has_lost) || self.uploaded.len() < known;
        let is_new = |(_, content): &&(ImageSource, Content)| !self.uploaded.contains_key(content);
        let new: BTreeMap<Content, ImageSource> =
            all.iter().filter(is_new).map(|(source, content)| (content.clone(), *source)).collect();
        let limits = Limits {
            side: gpu.capabilities.max_texture_size,
            wanted: self.max_px,
            blocks: gpu.capabilities.block_format,
        };
        let (mut upload_ms, mut written_bytes) = (0.0, 0);
        let is_monitor = |content: &Content| matches!(content, Content::Monitor { .. });
        for content in new.keys().filter(|content| is_monitor(content)) {
            if let Content::Monitor { image, size } = *content {
                let name = scene.images.get(image).map_or("", |image| &image.name);
                self.uploaded.insert(content.clone(), TextureUpload::of_monitor(gpu, name, size));
            }
        }
        for content in new.keys() {
            if let Content::Simulation(image) = content {
                let uploaded = TextureUpload { view: self.simulated.get(image).cloned(), ..TextureUpload::default() };
                self.uploaded.insert(content.clone(), uploaded);
            }
        }
        let is_file = |content: &Content| !matches!(content, Content::Monitor { .. } | Content::Simulation(_));
        let of_files = new.into_iter().filter(|(content, _)| is_file(content));
        let mut sources: Vec<ImageSource> = of_files.map(|(_, source)| source).collect();
        // What takes longest comes first, so that no thread is left alone with it at the end.
        let bytes_of = |image: &usize| scene.images.get(*image).map_or(0, |image| image.source.bytes());
        sources.sort_by_key(|source| (Reverse(source.images(scene).iter().map(bytes_of).sum::<u64>()), *source));
        decode_all(scene, &sources, limits, &mut |source, DecodedImage { chain, warnings }| {
            let Some(content) = content_of(scene, source) else { return };
            let started = web_time::Instant::now();
            let images = source.images(scene);
            let name = images.last().and_then(|image| scene.images.get(*image)).map_or("", |image| &image.name);
            let view = chain.as_ref().map(|chain| create(gpu, name, chain, source.is_srgb(), source.has_layers()));
            let bytes = chain.iter().flat_map(|chain| &chain.levels).map(|level| level.data.len() as u64).sum();
            let coarse = chain.as_ref().filter(|_| !source.has_layers()).and_then(coarse_of);
            let _made_from = images.iter().filter_map(|image| Some(texels_of(scene, *image)?.1)).collect();
            self.uploaded.insert(content, TextureUpload { view, coarse, bytes, warnings, _made_from });
            written_bytes += bytes;
            upload_ms += started.elapsed().as_secs_f64() * 1e3;
        });
        self.decode_ms = (started.elapsed().as_secs_f64() * 1e3 - upload_ms).max(0.0);
        ResourceChanges { written_bytes, has_changed: true, has_moved }
    }

    /// What could not be decoded.
    pub fn warnings(&self) -> impl Iterator<Item = &String> {
        self.uploaded.values().flat_map(|uploaded| &uploaded.warnings)
    }

    /// All textures of the scene.
    pub fn views(&self) -> impl Iterator<Item = &wgpu::TextureView> {
        self.uploaded.values().filter_map(|uploaded| uploaded.view.as_ref())
    }

    /// Bytes of all textures.
    pub fn bytes(&self) -> u64 {
        self.uploaded.values().map(|uploaded| uploaded.bytes).sum()
    }

    /// A white texel.
    pub fn white(&self) -> &wgpu::TextureView {
        &self.white
    }

    /// A white texel in a texture of layers.
    pub fn white_layer(&self) -> &wgpu::TextureView {
        &self.white_layer
    }

    /// What was made from `source`; none if that cannot be decoded, or no material uses it.
    pub(super) fn view(&self, scene: &Scene, source: ImageSource) -> Option<&wgpu::TextureView> {
        self.uploaded.get(&content_of(scene, source)?)?.view.as_ref()
    }

    /// What a texture of the scene shows, as numbers that are no colours.
    pub fn linear(&self, scene: &Scene, texture: usize) -> Option<&wgpu::TextureView> {
        let image = scene.textures.get(texture)?.image;
        self.view(scene, ImageSource::Image { image, is_srgb: false })
    }

    /// Takes the pictures of simulations, which materials and water show from now on.
    pub fn show_simulations(&mut self, pictures: BTreeMap<SimulatedImage, wgpu::TextureView>) {
        let is_same = |image: &SimulatedImage| self.simulated.get(image) == pictures.get(image);
        let known = self.uploaded.len();
        self.uploaded.retain(|content, _| !matches!(content, Content::Simulation(image) if !is_same(image)));
        self.has_lost |= self.uploaded.len() < known;
        self.simulated = pictures;
    }

    /// A picture of a simulation.
    pub fn simulated(&self, simulation: usize, picture: &str) -> Option<&wgpu::TextureView> {
        self.simulated.get(&SimulatedImage { simulation, picture: picture.into() })
    }

    /// How many monitors there are.
    pub fn monitor_count(&self) -> usize {
        self.uploaded.keys().filter(|content| matches!(content, Content::Monitor { .. })).count()
    }

    /// What the monitor of an image is drawn into, if there is such a texture.
    pub fn monitor(&self, scene: &Scene, image: usize) -> Option<&wgpu::TextureView> {
        self.view(scene, ImageSource::Image { image, is_srgb: true })
    }

    /// A small mip of what was made from `source`, four bytes a texel; none of what is compressed, has layers or is not
    /// there.
    pub(super) fn coarse(&self, scene: &Scene, source: ImageSource) -> Option<&Pixels> {
        self.uploaded.get(&content_of(scene, source)?)?.coarse.as_ref()
    }

    /// What samples textures as `sampler` says.
    pub fn sampler(&self, sampler: Sampler, sampling: Sampling) -> wgpu::Sampler {
        let mut samplers = self.samplers.borrow_mut();
        let known = samplers.entry((sampler, sampling));
        known.or_insert_with(|| create_sampler(&self.device, &sampler, sampling)).clone()
    }
}

impl TextureUpload {
    /// The texture that a monitor's picture is drawn into, dark at first; none where it has a size that is none.
    fn of_monitor(gpu: &Gpu, name: &str, size: (u32, u32)) -> Self {
        let (most, is_possible) = (monitor_side_max(gpu), monitor_fits(gpu, size));
        let sides = format!("{} by {}", size.0, size.1);
        let warning = || format!("monitor `{name}` is dark: {sides} texels are not possible, each side is 1 to {most}");
        let desc = monitor_desc(size);
        let create = || {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(name),
                size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
                mip_level_count: desc.mips,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: desc.format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        Self {
            view: is_possible.then(create),
            coarse: None,
            bytes: if is_possible { desc.bytes() } else { 0 },
            warnings: if is_possible { Vec::new() } else { vec![warning()] },
            _made_from: Vec::new(),
        }
    }
}

fn monitor_side_max(gpu: &Gpu) -> u32 {
    gpu.capabilities.max_texture_size.min(MONITOR_SIDE_MAX)
}

/// Whether a monitor's picture of a size can be drawn.
pub(crate) fn monitor_fits(gpu: &Gpu, (width, height): (u32, u32)) -> bool {
    [width, height].iter().all(|side| (1..=monitor_side_max(gpu)).contains(side))
}

/// The shape of the texture that a monitor's picture is drawn into.
pub(crate) fn monitor_desc((width, height): (u32, u32)) -> TextureDesc {
    let mips = width.max(height).max(1).ilog2() + 1;
    TextureDesc { mips, ..TextureDesc::new_2d(width, height, wgpu::TextureFormat::Rgba8UnormSrgb) }
}

fn coarse_of(chain: &MipChain) -> Option<Pixels> {
    let is_coarse = |level: &&Pixels| level.width.max(level.height) <= COARSE_SIDE;
    chain.levels.iter().find(is_coarse).filter(|_| chain.texels == Texels::Bytes).cloned()
}

/// What is to be known of an image to find out whether it is another one.
pub(crate) fn address_of(image: &manypass_scene::Image) -> Address {
    use manypass_scene::image::ImageSource as Source;
    match &image.source {
        Source::Encoded(bytes) => Arc::as_ptr(bytes).cast::<u8>() as Address,
        Source::Pixels(pixels) => Arc::as_ptr(pixels) as Address,
        Source::Loading(_) => 0,
        Source::Monitor(monitor) => (monitor.width as Address) << 16 | monitor.height as Address,
        Source::Simulation(image) => Arc::as_ptr(image) as Address,
    }
}

fn texels_of(scene: &Scene, image: usize) -> Option<(Address, ImageHold)> {
    use manypass_scene::image::ImageSource as Source;
    let image = scene.images.get(image)?;
    let texels = match &image.source {
        Source::Encoded(bytes) => ImageHold::Encoded { _held: Arc::downgrade(bytes) },
        Source::Pixels(pixels) => ImageHold::Pixels { _held: Arc::downgrade(pixels) },
        Source::Loading(_) | Source::Monitor(_) | Source::Simulation(_) => return None,
    };
    Some((address_of(image), texels))
}

fn content_of(scene: &Scene, source: ImageSource) -> Option<Content> {
    use manypass_scene::image::ImageSource::{Loading, Monitor, Simulation};
    // What is still on its way makes no texture: materials do without it. What a monitor shows has no other form.
    let is_there = |image: &&manypass_scene::Image| !matches!(image.source, Loading(_) | Monitor(_) | Simulation(_));
    let simulated = |image: usize| match &scene.images.get(image)?.source {
        Simulation(simulated) => Some(SimulatedImage::clone(simulated)),
        _ => None,
    };
    let size_of_monitor = |image: usize| {
        let monitor = scene.images.get(image).and_then(manypass_scene::Image::monitor)?;
        Some((monitor.width, monitor.height))
    };
    let address = |image: usize| scene.images.get(image).filter(is_there).map(address_of);
    Some(match source {
        ImageSource::Layers { material, is_srgb } => {
            let layers = layer_images(scene, scene.materials.get(material)?, is_srgb).into_iter();
            let images = layers.map(|layer| Some((address(layer.image)?, layer.is_height)));
            Content::Layers { images: images.collect::<Option<_>>()?, is_srgb }
        }
        ImageSource::Image { image, is_srgb } => match (size_of_monitor(image), simulated(image)) {
            (Some(size), _) => Content::Monitor { image, size },
            (None, Some(simulated)) => Content::Simulation(simulated),
            (None, None) => Content::Image { image: address(image)?, is_srgb },
        },
        ImageSource::Light { image, encoding, direction } => {
            let direction = direction.map(|of| address(of).ok_or(())).transpose().ok()?;
            Content::Light { image: address(image)?, encoding, direction }
        }
        ImageSource::Packed { occlusion, metallic_roughness } => {
            Content::Packed { occlusion: address(occlusion)?, metallic_roughness: address(metallic_roughness)? }
        }
    })
}

fn create(gpu: &Gpu, label: &str, chain: &MipChain, is_srgb: bool, has_layers: bool) -> wgpu::TextureView {
    let base = &chain.levels[0];
    let layers = chain.layers;
    let all_layers = if has_layers { gpu.capabilities.array_layers(layers) } else { layers };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: base.width, height: base.height, depth_or_array_layers: all_layers },
        mip_level_count: chain.levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: chain.format(is_srgb),
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let [unit_texels, unit_bytes] = match chain.texels {
        Texels::Blocks(_) => [BlockFormat::SIDE, BlockFormat::BYTES],
        Texels::HalfFloats => [1, 8],
        Texels::Bytes | Texels::OneExponent => [1, 4],
    };
    let mut staged_bytes = 0;
    for (level, pixels) in chain.levels.iter().enumerate() {
        let (across, down) = (pixels.width.div_ceil(unit_texels), pixels.height.div_ceil(unit_texels));
        let row_bytes = across * unit_bytes;
        let band_rows = (WRITE_BYTES as u32 / row_bytes).max(1);
        let layers = pixels.data.chunks_exact(row_bytes as usize * down as usize).take(layers as usize);
        for (layer, rows) in (0..).zip(layers) {
            for (band, rows) in (0..).zip(rows.chunks(band_rows as usize * row_bytes as usize)) {
                let height = rows.len() as u32 / row_bytes;
                gpu.queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture: &texture,
                        mip_level: level as u32,
                        origin: wgpu::Origin3d { x: 0, y: band * band_rows * unit_texels, z: layer },
                        aspect: wgpu::TextureAspect::All,
                    },
                    rows,
                    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None },
                    // Of blocks that are not full, too, all is written.
                    wgpu::Extent3d {
                        width: across * unit_texels,
                        height: height * unit_texels,
                        depth_or_array_layers: 1,
                    },
                );
                staged_bytes += rows.len();
                if staged_bytes >= STAGED_BYTES {
                    gpu.queue.submit([]);
                    staged_bytes = 0;
                }
            }
        }
    }
    gpu.queue.submit([]);
    let dimension = has_layers.then_some(wgpu::TextureViewDimension::D2Array);
    texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
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
        // Without mips only the first level is there to sample: what is nearest to 0.25. At 0 itself Vulkan takes the
        // filter of magnification for every size (its specification, on `VkSamplerCreateInfo` and filters of OpenGL).
        lod_max_clamp: if sampler.mip_linear.is_some() { 32.0 } else { 0.25 },
        anisotropy_clamp: if is_linear { sampling.anisotropy } else { 1 },
        ..Default::default()
    })
}
