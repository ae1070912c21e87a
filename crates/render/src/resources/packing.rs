//! Which images become one texture: the occlusion of a material lies in the red channel that its metallic-roughness map
//! leaves free, wherever both are placed and sampled alike. One sample and one upload less; the values are the same.

use manypass_scene::material::LightEncoding;
use manypass_scene::{LayerMap, Material, Sampler, Scene, Texture, TextureRef};
use std::collections::BTreeSet;

/// What becomes one texture on the device; that which takes longest to decode first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ImageSource {
    /// What the layers of a material need, one layer of a texture for each image, all of one size.
    Layers {
        /// The index of the material.
        material: usize,
        /// Those that are colours, or those that are data.
        is_srgb: bool,
    },
    /// Occlusion in red, the rest from metallic-roughness; indices of two images of one size.
    Packed {
        /// The image whose red channel is occlusion.
        occlusion: usize,
        /// The image whose green and blue channels are roughness and metallic.
        metallic_roughness: usize,
    },
    /// Light that was baked, of half floats; where it comes from lies below it in the same texture, which has no mips
    /// then. So it needs no texture unit of its own, of which WebGL 2 has none left, and light without directions has the
    /// texture that it had: of layers, which WebGL 2 has no less than two of, it would be twice as large there.
    Light {
        /// The image's index.
        image: usize,
        /// How its texels are written, if it is not a file of light.
        encoding: LightEncoding,
        /// The image of directions.
        direction: Option<usize>,
    },
    /// An image, as colour or as data. One that is used as both is there twice.
    Image {
        /// Its index.
        image: usize,
        /// Whether it is colour.
        is_srgb: bool,
    },
}

impl ImageSource {
    /// The images that it is made from; that which names it last.
    pub fn images(self, scene: &Scene) -> Vec<usize> {
        match self {
            Self::Layers { material, is_srgb } => {
                let layers = |material| layer_images(scene, material, is_srgb);
                let layers = scene.materials.get(material).map_or(Vec::new(), layers);
                layers.into_iter().map(|layer| layer.image).collect()
            }
            Self::Packed { occlusion, metallic_roughness } => vec![occlusion, metallic_roughness],
            Self::Light { image, direction, .. } => direction.into_iter().chain([image]).collect(),
            Self::Image { image, .. } => vec![image],
        }
    }

    /// Whether its values are sRGB colours.
    pub fn is_srgb(self) -> bool {
        matches!(self, Self::Image { is_srgb: true, .. } | Self::Layers { is_srgb: true, .. })
    }

    /// Whether its texels are half floats.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Light { .. })
    }

    /// Whether it is a texture of layers.
    pub fn has_layers(self) -> bool {
        matches!(self, Self::Layers { .. })
    }
}

/// An image as one layer of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LayerImage {
    /// Its index.
    pub image: usize,
    /// Whether its red is taken for heights of 16 bits.
    pub is_height: bool,
}

/// The image of a place in a material's layers.
pub(super) fn layer_image(scene: &Scene, material: &Material, map: LayerMap) -> Option<LayerImage> {
    let texture = scene.textures.get(material.layer_texture(map)?.texture)?;
    let image = Some(texture.image).filter(|image| *image < scene.images.len())?;
    Some(LayerImage { image, is_height: map == LayerMap::Height })
}

/// The images that the layers of a material show, as colour or as data, each once. Their order is that of the texture's
/// layers.
pub(super) fn layer_images(scene: &Scene, material: &Material, is_srgb: bool) -> Vec<LayerImage> {
    let mut images = Vec::new();
    for map in LayerMap::ALL.into_iter().filter(|map| map.is_srgb() == is_srgb) {
        let image = layer_image(scene, material, map);
        images.extend(image.filter(|image| !images.contains(image)));
    }
    images
}

/// Whether the layers of a material, as colour or as data, ask for more than the one sampler that a texture has.
pub(super) fn layer_samplers_differ(scene: &Scene, material: &Material, is_srgb: bool) -> bool {
    let maps = LayerMap::ALL.into_iter().filter(|map| map.is_srgb() == is_srgb);
    let textures = maps.filter_map(|map| scene.textures.get(material.layer_texture(map)?.texture));
    let mut samplers = textures.map(|texture| texture.sampler);
    let first = samplers.next();
    samplers.any(|sampler| Some(sampler) != first)
}

/// The images of a material's occlusion and metallic-roughness if one sample gives both; they may be one image.
pub(super) fn shared_texel(scene: &Scene, material: &Material) -> Option<(usize, usize)> {
    let (occlusion, rough_metal) = (material.occlusion_texture?, material.metallic_roughness_texture?);
    let texture = |reference: TextureRef| scene.textures.get(reference.texture);
    let (occlusion_texture, rough_metal_texture) = (texture(occlusion)?, texture(rough_metal)?);
    let dimensions = |image: usize| scene.images.get(image).and_then(|image| image.dimensions().ok());
    let (first, second) = (occlusion_texture.image, rough_metal_texture.image);
    let is_shared = occlusion.uv_set == rough_metal.uv_set
        && occlusion.transform == rough_metal.transform
        && occlusion_texture.sampler == rough_metal_texture.sampler
        && (first == second || (dimensions(first).is_some() && dimensions(first) == dimensions(second)));
    is_shared.then_some((first, second))
}

/// Texels that layers may have together whatever the sizes of their images.
const LAYER_TEXELS: u64 = 1 << 24;

/// The size of all layers of a texture whose images have `sizes`: as wide as the widest and as high as the highest; but
/// smaller where a large one among many small ones would make more than twice as many texels as there are.
pub(super) fn layer_size(sizes: &[(u32, u32)]) -> Option<(u32, u32)> {
    let texels = |(width, height): (u32, u32)| u64::from(width) * u64::from(height);
    let (mut width, mut height) = sizes.iter().copied().reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))?;
    let most = sizes.iter().copied().map(texels).sum::<u64>().saturating_mul(2).max(LAYER_TEXELS);
    while texels((width, height)) * sizes.len() as u64 > most {
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
    Some((width, height))
}

/// Where a material's baked light lies and how it is sampled, and what it is made from.
pub(super) fn light_map(scene: &Scene, material: &Material) -> Option<(TextureRef, Sampler, ImageSource)> {
    let baked = material.light_map?;
    let reference = baked.light.texture?;
    let Texture { image, sampler } = *scene.textures.get(reference.texture)?;
    let encoding = if scene.images.get(image)?.holds_light() { None } else { Some(baked.encoding) };
    // What a monitor shows changes, and what is still on its way has none.
    let has_texels = |image: usize| {
        use manypass_scene::ImageSource::{Encoded, Pixels};
        scene.images.get(image).is_some_and(|image| matches!(image.source, Encoded(_) | Pixels(_)))
    };
    let direction = baked.direction.and_then(|direction| scene.textures.get(direction.texture));
    let direction = direction.map(|texture| texture.image).filter(|of| has_texels(*of) && has_texels(image));
    let source = match encoding {
        Some(encoding) if encoding != LightEncoding::Rgbm && direction.is_none() => {
            ImageSource::Image { image, is_srgb: encoding == LightEncoding::Srgb }
        }
        encoding => ImageSource::Light { image, encoding: encoding.unwrap_or_default(), direction },
    };
    Some((reference, sampler, source))
}

/// What the materials of a scene use, and what its monitors show, which overlays may use.
pub(super) fn wanted(scene: &Scene) -> Vec<ImageSource> {
    let mut wanted = BTreeSet::new();
    for (index, material) in scene.materials.iter().enumerate() {
        want(scene, (index, material), &mut wanted);
    }
    let of_water = scene.water.iter().filter_map(|water| scene.textures.get(water.normal_map?));
    let of_water = of_water.map(|texture| texture.image).filter(|image| *image < scene.images.len());
    wanted.extend(of_water.map(|image| ImageSource::Image { image, is_srgb: false }));
    wanted.extend(scene.monitors().map(|(image, ..)| ImageSource::Image { image, is_srgb: true }));
    wanted.into_iter().collect()
}

/// The images of monitors that a material shows, in ascending order.
pub(crate) fn monitors_of(scene: &Scene, (index, material): (usize, &Material)) -> Vec<usize> {
    let mut wanted = BTreeSet::new();
    want(scene, (index, material), &mut wanted);
    let images: BTreeSet<usize> = wanted.iter().flat_map(|source| source.images(scene)).collect();
    let is_monitor = |image: &usize| scene.images.get(*image).is_some_and(|image| image.monitor().is_some());
    images.into_iter().filter(is_monitor).collect()
}

/// Adds what a material uses.
fn want(scene: &Scene, (index, material): (usize, &Material), wanted: &mut BTreeSet<ImageSource>) {
    for is_srgb in [false, true] {
        if !layer_images(scene, material, is_srgb).is_empty() {
            wanted.insert(ImageSource::Layers { material: index, is_srgb });
        }
    }
    let image = |reference: Option<TextureRef>| {
        let texture = reference.and_then(|reference| scene.textures.get(reference.texture));
        texture.map(|texture| texture.image).filter(|image| *image < scene.images.len())
    };
    let mut want = |reference, is_srgb| {
        wanted.extend(image(reference).map(|image| ImageSource::Image { image, is_srgb }));
    };
    want(material.base_color_texture, true);
    want(material.normal_texture, false);
    want(material.emissive_texture, true);
    match shared_texel(scene, material) {
        Some((occlusion, metallic_roughness)) if occlusion != metallic_roughness => {
            wanted.insert(ImageSource::Packed { occlusion, metallic_roughness });
        }
        _ => {
            want(material.metallic_roughness_texture, false);
            want(material.occlusion_texture, false);
        }
    }
    wanted.extend(light_map(scene, material).map(|(_, _, source)| source));
}
