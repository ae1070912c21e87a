//! Images are decoded and given their mips on threads of their own, few at a time in memory.

use super::mips::{MipChain, half};
use super::packing::{ImageSource, LayerImage, layer_images, layer_samplers_differ, layer_size};
use super::{baked, heights};
use manypass_scene::material::LightEncoding;
use manypass_scene::{BlockFormat, Blocks, HalfFloats, Heights, PixelFormat, Pixels, Scene};
use std::num::NonZeroU32;

/// An image for the device, with what there is to say about it.
pub(super) struct DecodedImage {
    pub chain: Option<MipChain>,
    pub warnings: Vec<String>,
}

/// What the device takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// The largest side in texels.
    pub side: u32,
    /// The largest side that somebody wants.
    pub wanted: Option<NonZeroU32>,
    /// Compressed blocks.
    pub blocks: Option<BlockFormat>,
}

impl Limits {
    /// The largest side, for whatever reason.
    fn side_max(self) -> u32 {
        self.wanted.map_or(self.side, |wanted| self.side.min(wanted.get()))
    }
}

/// An image by itself that stays compressed, if it and the device can.
fn transcode(scene: &Scene, source: ImageSource, limits: Limits) -> Option<MipChain> {
    let ImageSource::Image { image, .. } = source else { return None };
    let (image, format) = (scene.images.get(image)?, limits.blocks?);
    let (width, height) = image.dimensions().ok()?;
    let mut levels = if width.max(height) <= limits.side { image.transcode(format) } else { None }?;
    // What is too large for those who want less is left out: the file has the smaller levels. If it has none that are
    // small enough, or the first of them would not be whole blocks, the image is unpacked.
    let is_small = |level: &Blocks| level.width.max(level.height) <= limits.side_max();
    let first = levels.iter().position(is_small)?;
    levels.drain(..first);
    let is_whole = |level: &Blocks| [level.width, level.height].iter().all(|side| side % BlockFormat::SIDE == 0);
    let fits = first == 0 || levels.first().is_some_and(is_whole);
    fits.then(|| MipChain::of_blocks(levels, format))
}

fn decode(scene: &Scene, source: ImageSource, limits: Limits) -> DecodedImage {
    let mut warnings = Vec::new();
    if let Some(chain) = transcode(scene, source, limits) {
        if let ImageSource::Image { image, is_srgb } = source {
            warnings.extend(color_warning(scene, image, is_srgb));
        }
        return DecodedImage { chain: Some(chain), warnings };
    }
    let (base, is_srgb) = match source {
        ImageSource::Layers { material: index, is_srgb } => {
            let material = scene.materials.get(index);
            if let Some(material) = material.filter(|material| layer_samplers_differ(scene, material, is_srgb)) {
                let (name, what) = (&material.name, if is_srgb { "colours" } else { "data" });
                warnings.push(format!(
                    "material {index} `{name}`: its layers' maps of {what} are one texture, and ask for different samplers; that of the first counts"
                ));
            }
            let images = material.map(|material| layer_images(scene, material, is_srgb)).unwrap_or_default();
            let decode = |layer: &LayerImage| match layer.is_height {
                true => decode_heights(scene, layer.image, limits, &mut warnings).map(Layer::Heights),
                false => decode_base(scene, layer.image, is_srgb, limits, &mut warnings).map(Layer::Pixels),
            };
            let decoded: Vec<_> = images.iter().map(decode).collect();
            warnings.extend(shrinking_warning(scene, index, is_srgb, &images, &decoded));
            return DecodedImage { chain: layers(decoded, is_srgb), warnings };
        }
        ImageSource::Light { image, encoding, direction } => {
            let light = decode_light(scene, (image, encoding), (limits, direction.is_some()), &mut warnings);
            let chain = light.map(|(light, of_file)| match direction {
                Some(direction) => {
                    let sizes = (of_file, (light.width, light.height));
                    baked::with_directions(light, decode_directions(scene, direction, sizes, &mut warnings))
                }
                None => baked::mip_chain(light),
            });
            return DecodedImage { chain, warnings };
        }
        ImageSource::Image { image, is_srgb } => (decode_base(scene, image, is_srgb, limits, &mut warnings), is_srgb),
        ImageSource::Packed { occlusion, metallic_roughness } => {
            let decode = |image| {
                let mut warnings = Vec::new();
                (decode_base(scene, image, false, limits, &mut warnings), warnings)
            };
            let both = at_once(|| decode(occlusion), || decode(metallic_roughness));
            let ((occlusion, of_occlusion), (rough_metal, of_rough_metal)) = both;
            warnings.extend(of_occlusion.into_iter().chain(of_rough_metal));
            (pack(occlusion, rough_metal), false)
        }
    };
    let chain = base.map(|base| MipChain::of(base, is_srgb));
    DecodedImage { chain, warnings }
}

/// An image no larger than `limits` have it; none, with a warning, if it cannot be decoded.
fn decode_base(
    scene: &Scene,
    image: usize,
    is_srgb: bool,
    limits: Limits,
    warnings: &mut Vec<String>,
) -> Option<Pixels> {
    let source = &scene.images[image];
    let name = &source.name;
    let mut pixels = match source.decode() {
        Ok(pixels) => pixels,
        Err(error) => {
            warnings.push(format!("image {image} `{name}` cannot be decoded, and materials do without it: {error}"));
            return None;
        }
    };
    warnings.extend(color_warning(scene, image, is_srgb));
    warnings.extend(halving_warning(image, name, (pixels.width, pixels.height), limits.side));
    while pixels.width.max(pixels.height) > limits.side_max() {
        pixels = half(&pixels, is_srgb);
    }
    Some(pixels)
}

/// What is said of an image whose file declares other colours than it is read as.
fn color_warning(scene: &Scene, image: usize, is_srgb: bool) -> Option<String> {
    let source = scene.images.get(image)?;
    source.color_warning(is_srgb).map(|warning| format!("image {image} `{}`: {warning}", source.name))
}

/// What is said of an image that is larger than the adapter's `limit` texels a side, and so is halved until it is not.
fn halving_warning(image: usize, name: &str, (width, height): (u32, u32), limit: u32) -> Option<String> {
    let is_halved = width.max(height) > limit;
    is_halved.then(|| {
        format!("image {image} `{name}`: {width}x{height} is larger than the adapter's {limit} texels a side; halved")
    })
}

/// Heights no larger than `limits` have it; none, with a warning, if they cannot be decoded.
fn decode_heights(scene: &Scene, image: usize, limits: Limits, warnings: &mut Vec<String>) -> Option<Heights> {
    let source = &scene.images[image];
    let name = &source.name;
    let heights = match source.decode_heights() {
        Ok(heights) => heights,
        Err(error) => {
            warnings.push(format!("image {image} `{name}` cannot be decoded, and surfaces stay flat: {error}"));
            return None;
        }
    };
    let most = heights.width.max(heights.height);
    let limit = limits.side_max();
    if most <= limit {
        return Some(heights);
    }
    let scaled = |side: u32| (u64::from(side) * u64::from(limit) / u64::from(most)).max(1) as u32;
    let (width, height) = (scaled(heights.width), scaled(heights.height));
    if most > limits.side {
        warnings.push(format!(
            "image {image} `{name}`: {}x{} is larger than the adapter's {} texels a side; made smaller, {width}x{height}",
            heights.width, heights.height, limits.side
        ));
    }
    Some(heights.resized(width, height))
}

/// Light that was baked, no larger than `limits` have it, with room below it for where it comes from if it has directions;
/// none, with a warning, if it cannot be decoded.
fn decode_light(
    scene: &Scene,
    (image, encoding): (usize, LightEncoding),
    (limits, has_directions): (Limits, bool),
    warnings: &mut Vec<String>,
) -> Option<(HalfFloats, (u32, u32))> {
    let source = scene.images.get(image)?;
    let name = &source.name;
    let light = match (source.holds_light(), encoding) {
        (true, _) => source.decode_light(),
        (false, LightEncoding::Rgbm) => source.decode_rgbm(),
        (false, encoding) => source.decode().map(|pixels| baked::of_bytes(&pixels, encoding == LightEncoding::Srgb)),
    };
    let light = match light {
        Ok(light) => light,
        Err(error) => {
            warnings.push(format!("image {image} `{name}` cannot be decoded, and materials do without it: {error}"));
            return None;
        }
    };
    if light.cut_count > 0 {
        let count = light.cut_count;
        warnings.push(format!(
            "image {image} `{name}`: {count} values are not valid light, or too bright; NaN counts as 0"
        ));
    }
    let halves = if has_directions { 2 } else { 1 };
    warnings.extend(halving_warning(image, name, (light.width, halves * light.height), limits.side));
    let size = (light.width, light.height);
    // Who wants less means the light; the adapter means both halves.
    Some((baked::limited(baked::limited(light, limits.side_max(), 1), limits.side, halves), size))
}

/// Where light comes from, in the size that the light has, which is another one in its file; none, with a warning, if that cannot be decoded.
fn decode_directions(
    scene: &Scene,
    image: usize,
    (of_light, (width, height)): ((u32, u32), (u32, u32)),
    warnings: &mut Vec<String>,
) -> Option<Pixels> {
    let source = scene.images.get(image)?;
    let name = &source.name;
    let pixels = match source.decode() {
        Ok(pixels) => pixels,
        Err(error) => {
            let message = "cannot be decoded, and normal maps do not change baked light";
            warnings.push(format!("image {image} `{name}` {message}: {error}"));
            return None;
        }
    };
    warnings.extend(color_warning(scene, image, false));
    if (pixels.width, pixels.height) != of_light {
        let ((from_width, from_height), (width, height)) = ((pixels.width, pixels.height), of_light);
        warnings.push(format!(
            "image {image} `{name}`: directions of {from_width}x{from_height} are made as large as their light, {width}x{height}"
        ));
    }
    Some(pixels.resized(width, height))
}

/// What becomes a layer of a texture.
enum Layer {
    Pixels(Pixels),
    Heights(Heights),
}

impl Layer {
    fn size(&self) -> (u32, u32) {
        match self {
            Self::Pixels(image) => (image.width, image.height),
            Self::Heights(heights) => (heights.width, heights.height),
        }
    }
}

/// The size that all of `layers` get; none where none is there.
fn size_of_all(layers: &[Option<Layer>]) -> Option<(u32, u32)> {
    layer_size(&layers.iter().flatten().map(Layer::size).collect::<Vec<_>>())
}

/// What is said of the layers' maps of a material that are larger than the texture which they share, and lose texels.
fn shrinking_warning(
    scene: &Scene,
    material: usize,
    is_srgb: bool,
    images: &[LayerImage],
    layers: &[Option<Layer>],
) -> Option<String> {
    let (width, height) = size_of_all(layers)?;
    let is_larger = |layer: &&Layer| layer.size().0 > width || layer.size().1 > height;
    let larger =
        images.iter().zip(layers).filter_map(|(of, layer)| Some((of.image, layer.as_ref().filter(is_larger)?)));
    let named: Vec<String> = larger
        .map(|(image, layer)| {
            let (width, height) = layer.size();
            format!("image {image} `{}` ({width}x{height})", scene.images[image].name)
        })
        .collect();
    let (name, what) = (&scene.materials[material].name, if is_srgb { "colours" } else { "data" });
    (!named.is_empty()).then(|| {
        format!(
            "material {material} `{name}`: its layers' maps of {what} are one texture of {width}x{height}; made smaller: {}",
            named.join(", ")
        )
    })
}

/// Images as the layers of one texture, all of one size. What is missing is white.
fn layers(images: Vec<Option<Layer>>, is_srgb: bool) -> Option<MipChain> {
    let (width, height) = size_of_all(&images)?;
    let white = || {
        let data = vec![255; width as usize * height as usize * 4];
        Pixels { width, height, format: PixelFormat::Rgba8, data }
    };
    let mut chain: Option<MipChain> = None;
    for image in images {
        let next = match image {
            Some(Layer::Heights(heights)) => heights::mip_chain(heights.resized(width, height)),
            Some(Layer::Pixels(image)) => MipChain::of(image.resized(width, height), is_srgb),
            None => MipChain::of(white(), is_srgb),
        };
        match &mut chain {
            Some(chain) => chain.append(next),
            None => chain = Some(next),
        }
    }
    chain
}

/// What both give, the first of them on a thread of its own where there may be one more.
fn at_once<T: Send>(first: impl Fn() -> T + Sync, second: impl FnOnce() -> T) -> (T, T) {
    #[cfg(not(target_arch = "wasm32"))]
    let first_apart = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().spawn_scoped(scope, &first).ok();
        let second = second();
        (thread.and_then(|thread| thread.join().ok()), second)
    });
    #[cfg(target_arch = "wasm32")]
    let first_apart = (None, second());
    let (known, second) = first_apart;
    (known.unwrap_or_else(first), second)
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

/// Decodes on up to four threads, and hands over as results come; a thread has one image in memory, and waits until it
/// is taken.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn decode_all(
    scene: &Scene,
    wanted: &[ImageSource],
    limits: Limits,
    take: &mut dyn FnMut(ImageSource, DecodedImage),
) {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let next = AtomicUsize::new(0);
    let workers = std::thread::available_parallelism().map_or(1, usize::from).clamp(1, 4).min(wanted.len().max(1));
    let (sender, receiver) = std::sync::mpsc::sync_channel(0);
    std::thread::scope(|scope| {
        let mut has_worker = false;
        for _ in 0..workers {
            let (sender, next) = (sender.clone(), &next);
            let work = move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(key) = wanted.get(index) else { return };
                    if sender.send((*key, decode(scene, *key, limits))).is_err() {
                        return;
                    }
                }
            };
            has_worker |= std::thread::Builder::new().spawn_scoped(scope, work).is_ok();
        }
        drop(sender);
        // A process that may have no more threads decodes on this one.
        for key in wanted.iter().filter(|_| !has_worker) {
            take(*key, decode(scene, *key, limits));
        }
        for (key, result) in receiver {
            take(key, result);
        }
    });
}

#[cfg(target_arch = "wasm32")]
pub(super) fn decode_all(
    scene: &Scene,
    wanted: &[ImageSource],
    limits: Limits,
    take: &mut dyn FnMut(ImageSource, DecodedImage),
) {
    for key in wanted {
        take(*key, decode(scene, *key, limits));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::Image;

    #[test]
    fn directions_lie_below_their_light_whatever_their_files_are() {
        let limits = Limits { side: 64, wanted: None, blocks: None };
        let image = |width: u32, height: u32, byte: u8| {
            let data = vec![byte; width as usize * height as usize * 4];
            let pixels = Pixels { width, height, format: PixelFormat::Rgba8, data };
            Image { name: "a".into(), source: manypass_scene::ImageSource::Pixels(pixels.into()) }
        };
        let broken = Image { name: "a".into(), source: manypass_scene::ImageSource::Encoded(vec![0; 9].into()) };
        let scene = Scene {
            images: vec![image(4, 3, 51), image(4, 3, 255), image(2, 9, 0), broken, image(8, 48, 51)],
            ..Scene::default()
        };
        // Directions, their first part below the light, and what is said of them.
        for (light, direction, part, said) in [
            (0, 1, 1.0, ""),
            (0, 2, -1.0, "directions of 2x9 are made as large as their light, 4x3"),
            (0, 3, 0.0, "normal maps do not change baked light"),
            (4, 1, 1.0, "8x96 is larger than the adapter's 64 texels a side"),
        ] {
            let source =
                ImageSource::Light { image: light, encoding: LightEncoding::Linear, direction: Some(direction) };
            let DecodedImage { chain: Some(chain), warnings } = decode(&scene, source, limits) else {
                panic!("{light} {direction}");
            };
            assert_eq!(chain.levels.len(), 1);
            let level = &chain.levels[0];
            let size = if light == 4 { (4, 48) } else { (4, 6) };
            assert_eq!((level.width, level.height), size);
            let texels: Vec<half::f16> = bytemuck::pod_collect_to_vec(&level.data);
            let [first, middle] = [0, texels.len() / 2].map(|at| texels[at].to_f32());
            assert!((first - 0.2).abs() < 1e-3 && middle == part, "{first} {middle}");
            let is_said = |warning: &String| !said.is_empty() && warning.contains(said);
            assert_eq!(warnings.iter().any(is_said), !said.is_empty(), "{warnings:?}");
        }
    }

    #[test]
    fn images_that_declare_other_colours_are_warned_of_whether_they_stay_packed_or_not() {
        // UASTC, which declares sRGB with the primaries of Rec. 709; at byte 104 lies its descriptor.
        let block = manypass_testkit::ktx2::solid_block([9, 8, 7, 255]);
        let bytes = manypass_testkit::ktx2::picture(0, [4, 4], 0, &[&block, &block, &block]);
        let warnings = |at: usize, value: u8, is_srgb: bool, blocks: Option<BlockFormat>| {
            let mut bytes = bytes.clone();
            bytes[at] = value;
            let source = manypass_scene::ImageSource::Encoded(bytes.into());
            let scene = Scene { images: vec![Image { name: "a".into(), source }], ..Scene::default() };
            let decoded =
                decode(&scene, ImageSource::Image { image: 0, is_srgb }, Limits { side: 64, wanted: None, blocks });
            assert!(decoded.chain.is_some());
            decoded.warnings
        };
        let descriptor = 80 + 24 * 3;
        let (primaries, transfer) = (descriptor + 13, descriptor + 14);
        for blocks in [None, Some(BlockFormat::Bc7)] {
            assert_eq!(warnings(primaries, 1, true, blocks), Vec::<String>::new());
            assert_eq!(warnings(transfer, 1, false, blocks), Vec::<String>::new());
            let linear = warnings(transfer, 1, true, blocks);
            assert!(
                matches!(&linear[..], [one] if one.contains("image 0 `a`: it declares linear texels, and is read as sRGB"))
            );
            let wide = warnings(primaries, 10, true, blocks);
            assert!(matches!(&wide[..], [one] if one.contains("sRGB texels with the primaries of Display P3")));
            let data = warnings(transfer, 2, false, blocks);
            assert!(matches!(&data[..], [one] if one.contains("it declares sRGB texels, and is read as linear data")));
        }
    }
}
