//! What the layers of a material are on the device: which there are, their factors, and where their maps lie.

use super::packing::{ImageSource, layer_image, layer_images, light_map};
use super::textures::{SampledTexture, Textures};
use crate::constants::{
    LAYER_ANISOTROPY, LAYER_BUMP, LAYER_CLEARCOAT, LAYER_DIFFUSE_TRANSMISSION, LAYER_DISPERSION, LAYER_GLOSSINESS,
    LAYER_IRIDESCENCE, LAYER_LIGHT_MAP, LAYER_PARALLAX, LAYER_SELF_SHADOW, LAYER_SHEEN, LAYER_STEPS,
    LAYER_TRANSMISSION, LAYER_VOLUME,
};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3, Vec4};
use manypass_scene::material::HeightMethod;
use manypass_scene::{AlphaMode, LayerMap, Material, Sampler, Scene, ShadingModel, TextureRef};

/// The factors of the material that a draw binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FactorsOf {
    /// All of it.
    Whole,
    /// Without layers.
    Plain,
    /// Without layers and textures.
    Untextured,
}

/// The bit of reflection that is not as a refractive index makes it, which costs no shader anything.
const LAYER_SPECULAR: u32 = 1 << 26;

/// The bits of a material for which the G-buffer has no room, so that it is shaded where it is drawn.
pub(crate) const SHADED_WHERE_DRAWN: u32 = LAYER_SPECULAR
    | LAYER_GLOSSINESS
    | LAYER_CLEARCOAT
    | LAYER_SHEEN
    | LAYER_ANISOTROPY
    | LAYER_IRIDESCENCE
    | LAYER_TRANSMISSION
    | LAYER_DIFFUSE_TRANSMISSION
    | LAYER_VOLUME
    | LAYER_DISPERSION
    | LAYER_SELF_SHADOW;

/// The bits of relief: what shifts maps.
pub(crate) const RELIEF: u32 = LAYER_PARALLAX | LAYER_STEPS;

/// The bit of a map.
const fn bit_of(map: LayerMap) -> u32 {
    1 << map as u32
}

/// What surfaces do without that are seen small: clear coats, relief and the normals of details, with their maps.
pub(crate) const SEEN_LARGE: u32 = LAYER_CLEARCOAT
    | RELIEF
    | LAYER_BUMP
    | LAYER_SELF_SHADOW
    | bit_of(LayerMap::Clearcoat)
    | bit_of(LayerMap::ClearcoatRoughness)
    | bit_of(LayerMap::ClearcoatNormal)
    | bit_of(LayerMap::Height)
    | bit_of(LayerMap::DetailNormal);

/// The bits that change what a surface is before light reaches it, maps among them.
pub(crate) const DETAIL: u32 = RELIEF
    | LAYER_BUMP
    | LAYER_LIGHT_MAP
    | bit_of(LayerMap::Height)
    | bit_of(LayerMap::DetailNormal)
    | bit_of(LayerMap::DetailColor);

/// The bits of what bends normals, beside normal maps.
pub(crate) const BENDS: u32 = LAYER_BUMP | bit_of(LayerMap::DetailNormal);

/// The bits by which shadow maps hold relief.
pub(crate) const CAST_RELIEF: u32 = RELIEF | bit_of(LayerMap::Height);

/// The G-buffer holds reflectance up to this.
const F0_DEFERRED_MAX: f32 = 0.2;

/// The uniform of `layers.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct LayerFactors {
    /// The colour of a dielectric's reflection at normal incidence; the weight of all of it.
    pub specular: Vec4,
    /// Reflectance at normal incidence as the refractive index makes it; that index; glossiness; dispersion.
    pub refraction: Vec4,
    /// Weight, perceptual roughness and normal scale of the clear coat; transmission.
    pub coat: Vec4,
    /// Colour and perceptual roughness of the sheen.
    pub sheen: Vec4,
    /// Strength; cosine and sine of the rotation; zero.
    pub anisotropy: Vec4,
    /// Weight and refractive index of the film, its least and its greatest thickness in nanometres.
    pub film: Vec4,
    /// Colour and weight of scattered transmission.
    pub diffuse_transmission: Vec4,
    /// What is absorbed in a metre, as an exponent; thickness in metres of the mesh's space.
    pub volume: Vec4,
    /// How far below the triangles a height of 0 lies, in metres of the mesh's space; factor of baked light; scale of
    /// detail normals; zero.
    pub detail: Vec4,
    /// Two rows for each of [`LayerMap::ALL`]: as of `MaterialFactors::uv_rows`, with the layer of the texture in w of
    /// the second.
    pub maps: [Vec4; 2 * LayerMap::ALL.len()],
    /// Those of baked light.
    pub light_map_rows: [Vec4; 2],
}

/// Of a material that has layers.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    /// Which: the bits of `constants.rs`, and those of the maps that there are.
    pub bits: u32,
    /// Their factors.
    pub factors: LayerFactors,
    /// Their maps that are data, and those that are colours.
    pub textures: [SampledTexture; 2],
    /// Light that was baked.
    pub light_map: SampledTexture,
    /// Whether that has where it comes from below it.
    pub has_light_directions: bool,
}

/// Reflectance at normal incidence, seen from a vacuum (Fresnel).
pub(crate) fn f0_of_ior(ior: f32) -> f32 {
    let ratio = (ior - 1.0) / (ior + 1.0);
    ratio * ratio
}

/// The share of light that comes through a body of a material which lets `transmission` of it through, divided by the
/// mean of its base colour, on the mean of its channels: for shadows, which hold one number.
///
/// What both of its walls reflect is left out, as the mean of Schlick's Fresnel over a sphere, which shows light every
/// angle as light from everywhere does: f0 + (1 − f0) / 21. So is what it absorbs along its thickness.
pub(crate) fn share_through(material: &Material, transmission: f32) -> f32 {
    let f0 = f0_of_ior(material.ior);
    let weight = material.specular.map_or(1.0, |specular| specular.weight.factor);
    let entering = 1.0 - weight * (f0 + (1.0 - f0) / 21.0);
    let body = material.volume.filter(|volume| volume.thickness.factor > 0.0);
    let left = body.map_or(Vec3::ONE, |volume| {
        volume.attenuation_color.powf(volume.thickness.factor / volume.attenuation_distance_m.max(1e-20))
    });
    let base_color = material.base_color_factor.truncate().clamp(Vec3::splat(1e-6), Vec3::ONE);
    let colored = (base_color * left).element_sum() / base_color.element_sum();
    transmission * (1.0 - material.metallic_factor) * entering * entering * colored
}

/// Detail that a material needs, without the bits of maps. What is seen without light has no self-shadow.
fn needed_detail(material: &Material) -> u32 {
    let height = material.height;
    let method = height.map(|height| height.method);
    let is_lit = material.shading_model != ShadingModel::Unlit;
    let has_steps = matches!(method, Some(HeightMethod::Steep | HeightMethod::Occlusion));
    let all = [
        (LAYER_LIGHT_MAP, material.light_map.is_some()),
        // A normal map knows the normals better.
        (
            LAYER_BUMP,
            height.is_some() && (method == Some(HeightMethod::Bump) || material.normal_texture.is_none()) && is_lit,
        ),
        (LAYER_PARALLAX, matches!(method, Some(HeightMethod::Parallax | HeightMethod::Occlusion))),
        (LAYER_STEPS, has_steps),
        (LAYER_SELF_SHADOW, has_steps && is_lit && height.is_some_and(|height| height.self_shadow)),
    ];
    all.iter().filter(|(_, is_there)| *is_there).fold(0, |bits, (bit, _)| bits | bit)
}

/// The layers that a material needs, without the bits of maps and of detail; 0 if the G-buffer holds all that it is.
fn needed(material: &Material) -> u32 {
    if material.shading_model == ShadingModel::Unlit {
        return 0;
    }
    let is_plain = |specular: &manypass_scene::material::Specular| {
        (specular.weight.factor, specular.color.factor) == (1.0, Vec3::ONE)
            && specular.weight.texture.is_none()
            && specular.color.texture.is_none()
    };
    let transmits = material.transmission.is_some();
    let has_specular = material.specular.is_some_and(|specular| !is_plain(&specular));
    let all = [
        (LAYER_SPECULAR, has_specular || f0_of_ior(material.ior) > F0_DEFERRED_MAX),
        (LAYER_GLOSSINESS, material.specular.is_some_and(|specular| specular.glossiness.is_some())),
        (LAYER_CLEARCOAT, material.clearcoat.is_some()),
        (LAYER_SHEEN, material.sheen.is_some()),
        (LAYER_ANISOTROPY, material.anisotropy.is_some()),
        (LAYER_IRIDESCENCE, material.iridescence.is_some()),
        (LAYER_TRANSMISSION, transmits),
        (LAYER_DIFFUSE_TRANSMISSION, material.diffuse_transmission.is_some()),
        (LAYER_VOLUME, material.volume.is_some() && (transmits || material.diffuse_transmission.is_some())),
        (LAYER_DISPERSION, material.dispersion > 0.0 && material.volume.is_some() && transmits),
    ];
    all.iter().filter(|(_, is_there)| *is_there).fold(0, |bits, (bit, _)| bits | bit)
}

/// Reflectance at normal incidence of a material without its layers, if it looks much the same then where it is seen
/// small: light does not come through, and what it reflects is about as the G-buffer has it, without colour and up to a
/// fifth.
pub(crate) fn f0_without_layers(material: &Material) -> Option<f32> {
    let specular = material.specular.unwrap_or_default();
    let f0 = f0_of_ior(material.ior) * specular.weight.factor * specular.color.factor;
    let is_grey = f0.max_element() - f0.min_element() <= F0_DEFERRED_MAX / 4.0;
    let has_maps = specular.weight.texture.is_some() || specular.color.texture.is_some();
    let is_alike = f0.max_element() <= F0_DEFERRED_MAX && is_grey && !has_maps && specular.glossiness.is_none();
    let is_opaque = material.transmission.is_none() && material.diffuse_transmission.is_none();
    (is_alike && is_opaque).then(|| f0.element_sum() / 3.0)
}

/// What of a material the G-buffer does not hold, by glTF's words, so that its surfaces are shaded where they are
/// drawn; nothing if light reaches them in the passes of deferred shading.
pub fn layer_names(material: &Material) -> Vec<&'static str> {
    let names = [
        (LAYER_SPECULAR, "specular"),
        (LAYER_GLOSSINESS, "glossiness"),
        (LAYER_CLEARCOAT, "clearcoat"),
        (LAYER_SHEEN, "sheen"),
        (LAYER_ANISOTROPY, "anisotropy"),
        (LAYER_IRIDESCENCE, "iridescence"),
        (LAYER_TRANSMISSION, "transmission"),
        (LAYER_DIFFUSE_TRANSMISSION, "diffuse_transmission"),
        (LAYER_VOLUME, "volume"),
        (LAYER_DISPERSION, "dispersion"),
        (LAYER_SELF_SHADOW, "self_shadow"),
    ];
    let bits = needed(material) | needed_detail(material);
    names.into_iter().filter(|(bit, _)| bits & bit != 0).map(|(_, name)| name).collect()
}

/// The pass that shades the surfaces of a material on the deferred path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadedIn {
    /// In the passes of deferred shading, from the G-buffer.
    Deferred,
    /// Where they are drawn, after the direct light, because of layers for which the G-buffer has no room.
    Layered,
    /// Where they are drawn, after the background, because light comes through them.
    Transmissive,
    /// Where they are drawn, last of all, because they blend.
    Blended,
}

impl ShadedIn {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deferred => "deferred",
            Self::Layered => "layered",
            Self::Transmissive => "transmissive",
            Self::Blended => "blended",
        }
    }

    /// Where those of a material are.
    pub fn of(material: &Material) -> Self {
        let bits = needed(material) | needed_detail(material);
        match material.alpha_mode {
            _ if bits & LAYER_TRANSMISSION != 0 => Self::Transmissive,
            AlphaMode::Blend => Self::Blended,
            _ if bits & SHADED_WHERE_DRAWN != 0 => Self::Layered,
            _ => Self::Deferred,
        }
    }
}

impl Layers {
    /// Those of a material; none if it has neither layers nor detail.
    pub fn of(scene: &Scene, (index, material): (usize, &Material), textures: &Textures) -> Option<Self> {
        let mut bits = needed(material) | needed_detail(material);
        if bits == 0 && material.detail.is_none() {
            return None;
        }
        let mut factors = factors(material);
        let arrays = [false, true].map(|is_srgb| {
            let view = textures.view(scene, ImageSource::Layers { material: index, is_srgb });
            view.map(|view| (view.clone(), layer_images(scene, material, is_srgb)))
        });
        let mut samplers = [Sampler::default(); 2];
        for (at, map) in LayerMap::ALL.into_iter().enumerate().rev() {
            let array = usize::from(map.is_srgb());
            let (reference, image) = (material.layer_texture(map), layer_image(scene, material, map));
            let (Some(reference), Some(image), Some((_, images))) = (reference, image, &arrays[array]) else {
                factors.maps[2 * at] = Mat3::IDENTITY.row(0).extend(0.0);
                factors.maps[2 * at + 1] = Mat3::IDENTITY.row(1).extend(0.0);
                continue;
            };
            let layer = images.iter().position(|known| *known == image).unwrap_or(0);
            let [row0, row1] = rows(&reference);
            factors.maps[2 * at] = row0;
            factors.maps[2 * at + 1] = row1 + Vec4::W * layer as f32;
            // The sampler of the first, because the loop goes backwards.
            samplers[array] =
                scene.textures.get(reference.texture).map_or_else(Sampler::default, |texture| texture.sampler);
            bits |= 1 << at;
        }
        if bits & bit_of(LayerMap::Height) == 0 {
            bits &= !(RELIEF | LAYER_BUMP | LAYER_SELF_SHADOW);
        }
        let mut has_light_directions = false;
        let baked = light_map(scene, material).and_then(|(reference, sampler, source)| {
            has_light_directions = matches!(source, ImageSource::Light { direction: Some(_), .. });
            Some((reference, (textures.view(scene, source)?.clone(), sampler)))
        });
        match &baked {
            Some((reference, _)) => factors.light_map_rows = rows(reference),
            None => bits &= !LAYER_LIGHT_MAP,
        }
        if bits == 0 {
            return None;
        }
        let light_map = baked.map_or_else(|| (textures.white().clone(), Sampler::default()), |(_, sampled)| sampled);
        let mut samplers = samplers.into_iter();
        let textures = arrays.map(|array| {
            let view = array.map_or_else(|| textures.white_layer().clone(), |(view, _)| view);
            (view, samplers.next().unwrap_or_default())
        });
        Some(Self { bits, factors, textures, light_map, has_light_directions })
    }
}

/// The rows of the matrix that places a texture, with its UV set.
fn rows(reference: &TextureRef) -> [Vec4; 2] {
    let matrix = reference.transform.matrix();
    [matrix.row(0).extend(reference.uv_set as f32), matrix.row(1).extend(0.0)]
}

fn factors(material: &Material) -> LayerFactors {
    let specular = material.specular.unwrap_or_default();
    let mut factors = LayerFactors {
        specular: specular.color.factor.extend(specular.weight.factor),
        refraction: Vec4::new(
            f0_of_ior(material.ior),
            material.ior.max(1.0),
            specular.glossiness.unwrap_or(0.0),
            material.dispersion,
        ),
        ..LayerFactors::zeroed()
    };
    if let Some(coat) = material.clearcoat {
        factors.coat = Vec4::new(coat.weight.factor, coat.roughness.factor, coat.normal_scale, 0.0);
    }
    factors.coat.w = material.transmission.map_or(0.0, |transmission| transmission.factor);
    if let Some(sheen) = material.sheen {
        factors.sheen = sheen.color.factor.extend(sheen.roughness.factor);
    }
    if let Some(anisotropy) = material.anisotropy {
        let (sin, cos) = anisotropy.rotation_rad.sin_cos();
        factors.anisotropy = Vec4::new(anisotropy.strength, cos, sin, 0.0);
    }
    if let Some(film) = material.iridescence {
        factors.film = Vec4::new(film.weight.factor, film.ior, film.thickness_min_nm, film.thickness_max_nm);
        if film.thickness_texture.is_none() {
            factors.film.z = film.thickness_max_nm;
        }
    }
    if let Some(diffuse) = material.diffuse_transmission {
        factors.diffuse_transmission = diffuse.color.factor.extend(diffuse.weight.factor);
    }
    if let Some(volume) = material.volume {
        // Black would absorb infinitely much, and infinity times no thickness is no number.
        let left = volume.attenuation_color.max(Vec3::splat(1e-6));
        let absorbed = left.map(|left| -left.ln() / volume.attenuation_distance_m);
        factors.volume = absorbed.min(Vec3::splat(1e9)).extend(volume.thickness.factor);
    }
    factors.detail = Vec4::new(
        material.height.map_or(0.0, |height| height.depth_m),
        material.light_map.map_or(0.0, |baked| baked.light.factor),
        material.detail.map_or(1.0, |detail| detail.normal_scale),
        0.0,
    );
    factors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;
    use manypass_scene::TexturedFactor;
    use manypass_scene::material::{Clearcoat, Specular, Volume};

    #[test]
    fn a_shadow_of_glass_lacks_what_is_reflected_and_absorbed() {
        let clear = Material { metallic_factor: 0.0, ..Material::default() };
        // 0.04 at normal incidence, 0.0857 in the mean, at two walls.
        let through = share_through(&clear, 1.0);
        assert!((through - 0.9143 * 0.9143).abs() < 1e-3, "{through}");
        assert!((share_through(&clear, 0.5) - 0.5 * through).abs() < 1e-6);
        assert_eq!(share_through(&Material { metallic_factor: 1.0, ..clear.clone() }, 1.0), 0.0);
        let unseen = Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() });
        assert_eq!(share_through(&Material { specular: unseen, ..clear.clone() }, 1.0), 1.0);
        // After twice the distance a quarter of red and 0.01 of the others are left, of a base colour that has no blue.
        let volume = Volume {
            thickness: TexturedFactor::new(2.0),
            attenuation_distance_m: 1.0,
            attenuation_color: Vec3::new(0.5, 0.1, 0.1),
        };
        let base_color_factor = Vec4::new(1.0, 0.5, 0.0, 1.0);
        let dyed = share_through(&Material { volume: Some(volume), base_color_factor, ..clear.clone() }, 1.0);
        assert!((dyed - through * 0.255 / 1.5).abs() < 1e-4, "{dyed}");
        // What absorbs nothing has an infinite distance.
        let open = Volume { thickness: TexturedFactor::new(2.0), ..Volume::default() };
        assert_eq!(share_through(&Material { volume: Some(open), ..clear }, 1.0), through);
    }

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "forward_layered",
            "LayerFactors",
            LayerFactors,
            [
                specular,
                refraction,
                coat,
                sheen,
                anisotropy,
                film,
                diffuse_transmission,
                volume,
                detail,
                maps,
                light_map_rows,
            ]
        );
    }

    #[test]
    fn what_the_gbuffer_holds_has_no_layers() {
        let plain = Material::default();
        assert_eq!(needed(&plain), 0);
        assert_eq!(needed(&Material { ior: 2.4, specular: Some(Specular::default()), ..plain.clone() }), 0);
        // Nothing comes through, so that there is no inside.
        assert_eq!(needed(&Material { volume: Some(Volume::default()), dispersion: 1.0, ..plain.clone() }), 0);
        let coat = Clearcoat {
            weight: TexturedFactor::new(1.0),
            roughness: TexturedFactor::new(0.0),
            normal_texture: None,
            normal_scale: 1.0,
        };
        let coated = Material { clearcoat: Some(coat), ..plain.clone() };
        assert_eq!(needed(&coated), LAYER_CLEARCOAT);
        assert_eq!(needed(&Material { shading_model: ShadingModel::Unlit, ..coated.clone() }), 0);
        let half = Specular { weight: TexturedFactor::new(0.5), ..Specular::default() };
        assert_eq!(needed(&Material { specular: Some(half), ..plain.clone() }), LAYER_SPECULAR);
        assert_eq!(needed(&Material { ior: 0.0, ..plain.clone() }), LAYER_SPECULAR);
        let glass = Material { transmission: Some(TexturedFactor::new(1.0)), dispersion: 1.0, ..plain.clone() };
        assert_eq!(layer_names(&glass), ["transmission"]);
        let thickness = TexturedFactor::new(1.0);
        let glass = Material { volume: Some(Volume { thickness, ..Volume::default() }), ..glass };
        assert_eq!(layer_names(&glass), ["transmission", "volume", "dispersion"]);
        assert!(layer_names(&plain).is_empty());
        let blended = Material { alpha_mode: AlphaMode::Blend, ..plain.clone() };
        let blended_glass = Material { alpha_mode: AlphaMode::Blend, ..glass.clone() };
        let all = [(plain, "deferred"), (coated, "layered"), (glass, "transmissive"), (blended, "blended")];
        for (material, name) in all.into_iter().chain([(blended_glass, "transmissive")]) {
            assert_eq!(ShadedIn::of(&material).name(), name);
        }
    }
}
