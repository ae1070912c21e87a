//! Which images become one texture: the occlusion of a material lies in the red channel that its metallic-roughness map
//! leaves free, wherever both are placed and sampled alike. One sample and one upload less; the values are the same.

use manypass_scene::{Material, Scene, TextureRef};

/// What becomes one texture on the device; that which takes longest to decode first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ImageSource {
    /// Occlusion in red, the rest from metallic-roughness; indices of two images of one size.
    Packed {
        /// The image whose red channel is occlusion.
        occlusion: usize,
        /// The image whose green and blue channels are roughness and metallic.
        metallic_roughness: usize,
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
    pub fn images(self) -> Vec<usize> {
        match self {
            Self::Packed { occlusion, metallic_roughness } => vec![occlusion, metallic_roughness],
            Self::Image { image, .. } => vec![image],
        }
    }

    /// Whether its values are sRGB colours.
    pub fn is_srgb(self) -> bool {
        matches!(self, Self::Image { is_srgb: true, .. })
    }
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

/// What the materials of a scene use.
pub(super) fn wanted(scene: &Scene) -> Vec<ImageSource> {
    let mut wanted = std::collections::BTreeSet::new();
    for material in &scene.materials {
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
    }
    wanted.into_iter().collect()
}
