//! Materials on the device: their factors lie in pages, so that a change of one is one write.

use super::filtering::Sampling;
use super::layers::{FactorsOf, LayerFactors, Layers, SHADED_WHERE_DRAWN, f0_of_ior, share_through};
use super::packing::{ImageSource, shared_texel};
use super::pages::{Pages, Place};
use super::textures::{SampledTexture, Textures};
use crate::constants::{
    LAYER_CLEARCOAT, LAYER_GLOSSINESS, LAYER_LIGHT_MAP, LAYER_TRANSMISSION, SHADING_MODEL_COATED_ROUGH,
    SHADING_MODEL_COATED_SMOOTH, SHADING_MODEL_UNTRACED,
};
use crate::gpu::Gpu;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use manypass_scene::{AlphaMode, Material, Sampler, Scene, ShadingModel, TextureRef};
use std::cell::RefCell;

/// The alpha from which on a blended surface is met.
const BLENDED_ALPHA_MIN: f32 = 1.0 / 255.0;

/// The uniform of `surface_material.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MaterialFactors {
    /// Base colour and alpha.
    pub base_color: Vec4,
    /// Emission.
    pub emissive: Vec3,
    /// Metallic.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Scale of the normal map.
    pub normal_scale: f32,
    /// Strength of the occlusion texture; 0 if there is none. Of what is drawn without its textures, how much is
    /// occluded.
    pub occlusion_strength: f32,
    /// Fragments with less alpha are dropped.
    pub alpha_cutoff: f32,
    /// The shading model, as `gbuffer.wgsl` numbers them.
    pub shading_model: f32,
    /// Index of the material.
    pub material_id: u32,
    /// 1 if alpha covers.
    pub blended: f32,
    /// 1 if both sides are drawn.
    pub double_sided: f32,
    /// Reflectance at normal incidence of what is not metal.
    pub f0_dielectric: f32,
    /// The share of light that comes through where the surface casts a shadow, divided by the mean of its base colour.
    pub cast_through: f32,
    /// 1 if it casts a shadow in part, by its alpha or as light comes through.
    pub casts_in_part: f32,
    /// −1 if green of normal maps points down.
    pub normal_y_sign: f32,
    /// Two rows for each of the five textures.
    pub uv_rows: [Vec4; 10],
}

/// Every backend can bind a uniform at multiples of so many bytes.
pub(super) const UNIFORM_ALIGNMENT_BYTES: usize = 256;

/// Shading models as `gbuffer.wgsl` numbers them.
const SHADING_MODEL_UNLIT: f32 = 0.0;
pub(super) const SHADING_MODEL_STANDARD: f32 = 1.0;
pub(super) const SHADING_MODEL_BAKED: f32 = 204.0 / 255.0;
const SHADING_MODEL_FORWARD: f32 = 128.0 / 255.0;

/// Whether a shading model is one of surfaces that are shaded where they are drawn.
pub(super) fn is_shaded_where_drawn(shading_model: f32) -> bool {
    shading_model > SHADING_MODEL_UNLIT && shading_model < SHADING_MODEL_BAKED
}

/// The shading model of a material that has these bits of layers.
fn shading_model_of(material: &Material, layers: u32) -> f32 {
    if material.shading_model == ShadingModel::Unlit {
        return SHADING_MODEL_UNLIT;
    }
    if layers & SHADED_WHERE_DRAWN == 0 {
        return if layers & LAYER_LIGHT_MAP != 0 { SHADING_MODEL_BAKED } else { SHADING_MODEL_STANDARD };
    }
    let coat = material.clearcoat.as_ref().filter(|_| layers & LAYER_CLEARCOAT != 0);
    match coat.map(|coat| (coat.weight.factor, coat.roughness.factor)) {
        Some((weight, roughness)) if weight > 0.0 => {
            let roughness = if roughness.is_nan() { 0.0 } else { roughness.clamp(0.0, 1.0) };
            SHADING_MODEL_COATED_SMOOTH + (SHADING_MODEL_COATED_ROUGH - SHADING_MODEL_COATED_SMOOTH) * roughness
        }
        _ if layers & LAYER_GLOSSINESS != 0 => SHADING_MODEL_UNTRACED,
        _ => SHADING_MODEL_FORWARD,
    }
}

/// A material on the device.
#[derive(Debug)]
pub(crate) struct GpuMaterial {
    place: Place,
    /// Where the factors of its layers are, and what they are there, if it has any.
    placed_layers: Option<(Place, LayerFactors)>,
    described: MaterialDescription,
    bind_groups: RefCell<Vec<(BindGroupKey, wgpu::BindGroup)>>,
}

/// What a bind group of a material is for: the program, how its samplers filter, and its factors.
pub(crate) type BindGroupKey = (u32, Sampling, FactorsOf);

impl GpuMaterial {
    /// What was kept for a use.
    pub fn bind_group(&self, key: BindGroupKey) -> Option<wgpu::BindGroup> {
        let known = self.bind_groups.borrow();
        known.iter().find(|(of, _)| *of == key).map(|(_, group)| group.clone())
    }

    /// Keeps a bind group as long as it binds what the material has.
    pub fn keep_bind_group(&self, key: BindGroupKey, group: wgpu::BindGroup) {
        self.bind_groups.borrow_mut().push((key, group));
    }

    /// Forgets those that bind other factors than the whole material's, because they moved.
    pub(super) fn forget_reduced(&self) {
        self.bind_groups.borrow_mut().retain(|((_, _, of), _)| *of == FactorsOf::Whole);
    }
}

/// What a material is for shaders and pipelines.
#[derive(Clone, Debug)]
pub(crate) struct MaterialDescription {
    pub(super) factors: MaterialFactors,
    /// What the textures are made from.
    pub(super) sources: [Option<ImageSource>; 5],
    /// Base colour, metallic-roughness, normal, occlusion, emissive.
    pub textures: [SampledTexture; 5],
    /// What the G-buffer does not hold; its surfaces are shaded where they are drawn.
    pub layers: Option<Box<Layers>>,
    /// Whether any texture but the normal map is used.
    pub textured: bool,
    /// Whether occlusion has a texture of its own, beside that of metallic-roughness.
    pub occlusion_apart: bool,
    /// Whether there is a normal map.
    pub normal_map: bool,
    /// Whether a texture lies otherwise than the first UVs say: by a matrix, or by the second ones.
    pub places_uvs: bool,
    /// Whether fragments are dropped by alpha.
    pub masked: bool,
    /// Whether alpha covers what lies behind.
    pub blended: bool,
    /// Whether back faces are drawn.
    pub double_sided: bool,
    /// Whether it emits light.
    pub emits: bool,
    /// Whether its base colour is seen as it is, without light.
    pub unlit: bool,
    /// Whether its surfaces keep light from what lies behind them.
    pub casts_shadow: bool,
    /// Whether it has light that was baked.
    pub is_baked: bool,
}

impl std::ops::Deref for GpuMaterial {
    type Target = MaterialDescription;

    fn deref(&self) -> &MaterialDescription {
        &self.described
    }
}

/// The materials of a scene, and the default material last.
#[derive(Debug)]
pub(crate) struct Materials {
    pages: Pages,
    layer_pages: Pages,
    materials: Vec<GpuMaterial>,
    warnings: Vec<String>,
}

impl Materials {
    /// No materials yet.
    pub fn new() -> Self {
        let pages = |label, bytes: usize| {
            Pages::new(label, wgpu::BufferUsages::UNIFORM, bytes.next_multiple_of(UNIFORM_ALIGNMENT_BYTES))
        };
        Self {
            pages: pages("material_factors", size_of::<MaterialFactors>()),
            layer_pages: pages("layer_factors", size_of::<LayerFactors>()),
            materials: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// What was wrong with the materials.
    pub fn warnings(&self) -> impl Iterator<Item = &String> {
        self.warnings.iter()
    }

    /// Brings all materials up to date, whose textures are there already, and says how many bytes that wrote. False if
    /// a uniform could not be placed.
    pub fn follow(&mut self, gpu: &Gpu, scene: &Scene, textures: &Textures) -> u64 {
        let default = Material::default();
        let count = scene.materials.len() + 1;
        for dropped in self.materials.drain(count.min(self.materials.len())..) {
            self.pages.give_back(&dropped.place);
            dropped.placed_layers.iter().for_each(|(place, _)| self.layer_pages.give_back(place));
        }
        self.warnings.clear();
        for (index, material) in scene.materials.iter().chain([&default]).enumerate() {
            let mut described = MaterialDescription::of(scene, material, index, textures);
            if described.make_numbers() {
                let name = &material.name;
                self.warnings
                    .push(format!("material {index} `{name}` has factors that are not numbers; they count as 0"));
            }
            match self.materials.get_mut(index) {
                Some(known) => {
                    if bytemuck::bytes_of(&known.described.factors) != bytemuck::bytes_of(&described.factors) {
                        self.pages.write(&gpu.queue, &known.place, [described.factors]);
                    }
                    let layer_textures = |described: &MaterialDescription| {
                        described.layers.as_ref().map(|layers| (layers.textures.clone(), layers.light_map.clone()))
                    };
                    if known.described.textures != described.textures
                        || layer_textures(&known.described) != layer_textures(&described)
                    {
                        known.bind_groups.borrow_mut().clear();
                    }
                    known.described = described;
                }
                None => {
                    let expected = (count - index) as u64;
                    let Some(place) = self.pages.take(&gpu.device, 1, expected) else { continue };
                    self.pages.write(&gpu.queue, &place, [described.factors]);
                    let bind_groups = RefCell::default();
                    self.materials.push(GpuMaterial { place, placed_layers: None, described, bind_groups });
                }
            }
        }
        self.follow_layers(gpu);
        for pages in [&mut self.pages, &mut self.layer_pages] {
            pages.flush(&gpu.queue);
            pages.trim();
        }
        self.pages.take_written_bytes() + self.layer_pages.take_written_bytes()
    }

    /// Writes the factors of layers that differ.
    fn follow_layers(&mut self, gpu: &Gpu) {
        let Self { layer_pages: pages, materials, .. } = self;
        let expected = materials.iter().filter(|material| material.layers.is_some()).count() as u64;
        for material in materials {
            let Some(layers) = &material.described.layers else {
                if let Some((place, _)) = material.placed_layers.take() {
                    pages.give_back(&place);
                    material.bind_groups.borrow_mut().clear();
                }
                continue;
            };
            let known = material.placed_layers.take();
            let is_written = known.as_ref().is_some_and(|(_, factors)| *factors == layers.factors);
            let place = known.map(|(place, _)| place).or_else(|| pages.take(&gpu.device, 1, expected));
            if let Some(place) = place.as_ref().filter(|_| !is_written) {
                pages.write(&gpu.queue, place, [layers.factors]);
            }
            material.placed_layers = place.map(|place| (place, layers.factors));
        }
    }

    /// A material of the scene; the default material if it has none of that index.
    pub fn index(&self, material: Option<usize>) -> usize {
        let default = self.materials.len().saturating_sub(1);
        material.unwrap_or(default).min(default)
    }

    /// The material at an index that [`Self::index`] gave.
    pub fn get(&self, index: usize) -> &GpuMaterial {
        &self.materials[index]
    }

    /// The uniform of a material.
    pub fn factors(&self, material: &GpuMaterial) -> Option<wgpu::BindingResource<'_>> {
        binding(&self.pages, &material.place, size_of::<MaterialFactors>())
    }

    /// The uniform of a material's layers, if it has any.
    pub fn layer_factors(&self, material: &GpuMaterial) -> Option<wgpu::BindingResource<'_>> {
        binding(&self.layer_pages, &material.placed_layers.as_ref()?.0, size_of::<LayerFactors>())
    }
}

pub(super) fn binding<'p>(pages: &'p Pages, place: &Place, bytes: usize) -> Option<wgpu::BindingResource<'p>> {
    Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: pages.buffer(place.page)?,
        offset: pages.bytes_of(place).start,
        size: wgpu::BufferSize::new(bytes as u64),
    }))
}

/// The farthest from 0 that a factor may be, so that what shaders multiply it with stays a number.
const FACTOR_MAX: f32 = 1e30;

/// Makes 0 of what is no number and [`FACTOR_MAX`] of what is infinite, in factors that are floats, or indices whose bits
/// are those of tiny ones. Says whether anything was no number.
fn made_numbers<T: Pod>(factors: &mut T) -> bool {
    let mut is_wrong = false;
    for factor in bytemuck::cast_slice_mut::<_, f32>(std::slice::from_mut(factors)) {
        is_wrong |= factor.is_nan();
        *factor = if factor.is_nan() { 0.0 } else { factor.clamp(-FACTOR_MAX, FACTOR_MAX) };
    }
    is_wrong
}

impl MaterialDescription {
    /// Whether its surface or the coat over it may be as smooth as that somewhere; maps may say anything.
    pub fn may_be_smooth(&self, roughness: f32) -> bool {
        let is_coated = self.layers.as_ref().is_some_and(|layers| layers.bits & LAYER_CLEARCOAT != 0);
        !self.unlit && (self.factors.roughness < roughness || self.sources[1].is_some() || is_coated)
    }

    /// Leaves nothing among the factors that would spread through a picture; says whether there was anything. Files
    /// have none, but scenes that code makes may.
    fn make_numbers(&mut self) -> bool {
        let of_layers = self.layers.as_mut().is_some_and(|layers| made_numbers(&mut layers.factors));
        let of_all = made_numbers(&mut self.factors);
        self.emits = self.factors.emissive.max_element() > 0.0;
        of_layers || of_all
    }

    fn of(scene: &Scene, material: &Material, index: usize, textures: &Textures) -> Self {
        let layers = Layers::of(scene, (index, material), textures).map(Box::new);
        let sampled = |reference: Option<TextureRef>, is_srgb: bool| {
            let texture = *scene.textures.get(reference?.texture)?;
            let source = ImageSource::Image { image: texture.image, is_srgb };
            let view = textures.view(scene, source)?;
            Some(((view.clone(), texture.sampler), source))
        };
        let shared = shared_texel(scene, material);
        let (rough_metal, occlusion) = match shared {
            Some(images) => {
                let source = shared_source(images);
                let sampler =
                    material.metallic_roughness_texture.and_then(|reference| scene.textures.get(reference.texture));
                let both = textures.view(scene, source).cloned().zip(sampler.map(|texture| texture.sampler));
                let both = both.map(|sampled| (sampled, source));
                (both.clone(), both)
            }
            None => (sampled(material.metallic_roughness_texture, false), sampled(material.occlusion_texture, false)),
        };
        // What a texture multiplies stays as it is without one, and a normal map without one is flat (glTF 2.0).
        let slots = [
            (material.base_color_texture, sampled(material.base_color_texture, true)),
            (material.metallic_roughness_texture, rough_metal),
            (material.normal_texture, sampled(material.normal_texture, false)),
            (material.occlusion_texture, occlusion),
            (material.emissive_texture, sampled(material.emissive_texture, true)),
        ];
        let is_there = |slot: usize| slots[slot].1.is_some();
        let maps = slots.each_ref().map(|(reference, sampled)| reference.filter(|_| sampled.is_some()));
        let uv_rows = uv_rows_of(maps, material.tangent_uv_set().unwrap_or(0));
        let is_dark = material.emissive_texture.is_some() && !is_there(4);
        let blended = material.alpha_mode == AlphaMode::Blend;
        let has_layer = |bits: u32| layers.as_ref().is_some_and(|layers| layers.bits & bits != 0);
        let transmission = material.transmission.filter(|_| has_layer(LAYER_TRANSMISSION));
        let transmission = transmission.map_or(0.0, |share| share.factor);
        let factors = MaterialFactors {
            base_color: material.base_color_factor,
            // Without its texture, the factor alone would shine all over.
            emissive: if is_dark { Vec3::ZERO } else { material.emissive_factor },
            metallic: material.metallic_factor,
            roughness: material.roughness_factor,
            normal_scale: material.normal_scale,
            // Red of metallic-roughness alone means nothing.
            occlusion_strength: if is_there(3) { material.occlusion_strength } else { 0.0 },
            alpha_cutoff: match material.alpha_mode {
                AlphaMode::Mask { cutoff } => cutoff,
                // Where variables show what is met first.
                AlphaMode::Blend => BLENDED_ALPHA_MIN,
                AlphaMode::Opaque => 0.0,
            },
            shading_model: shading_model_of(material, layers.as_ref().map_or(0, |layers| layers.bits)),
            material_id: index as u32,
            blended: if blended { 1.0 } else { 0.0 },
            double_sided: if material.double_sided { 1.0 } else { 0.0 },
            f0_dielectric: f0_of_ior(material.ior),
            cast_through: share_through(material, transmission),
            casts_in_part: if blended || transmission > 0.0 { 1.0 } else { 0.0 },
            normal_y_sign: if material.has_normals_down { -1.0 } else { 1.0 },
            uv_rows,
        };
        let occlusion_apart = shared.is_none() && is_there(3);
        let textured = [0, 1, 3, 4].into_iter().any(is_there);
        let normal_map = is_there(2);
        let white = (textures.white().clone(), Sampler::default());
        let sources = slots.each_ref().map(|(_, sampled)| sampled.as_ref().map(|(_, source)| *source));
        let mut textures = slots.map(|(_, sampled)| sampled.map_or_else(|| white.clone(), |(sampled, _)| sampled));
        if !occlusion_apart {
            textures[3] = white;
        }
        let emits = factors.emissive.max_element() > 0.0;
        let is_baked = has_layer(LAYER_LIGHT_MAP);
        Self {
            factors,
            sources,
            textures,
            layers,
            textured,
            occlusion_apart,
            normal_map,
            places_uvs: uv_rows != uv_rows_of([None; 5], 0),
            masked: matches!(material.alpha_mode, AlphaMode::Mask { .. }),
            blended,
            double_sided: material.double_sided,
            emits,
            unlit: material.shading_model == ShadingModel::Unlit,
            casts_shadow: material.casts_shadow,
            is_baked,
        }
    }
}

/// What holds the images of occlusion and of metal and roughness in one texture.
fn shared_source((occlusion, metallic_roughness): (usize, usize)) -> ImageSource {
    if occlusion == metallic_roughness {
        ImageSource::Image { image: occlusion, is_srgb: false }
    } else {
        ImageSource::Packed { occlusion, metallic_roughness }
    }
}

/// Two rows of the matrix of each map, with its UV set in the fourth column of the first; where there is no normal map,
/// with the set of the tangents in its place, which another map may need.
fn uv_rows_of(maps: [Option<TextureRef>; 5], tangent_uv_set: u32) -> [Vec4; 10] {
    let mut rows = [Vec4::ZERO; 10];
    for (pair, map) in rows.chunks_exact_mut(2).zip(maps) {
        let (matrix, set) = map.map_or((glam::Mat3::IDENTITY, 0), |map| (map.transform.matrix(), map.uv_set));
        pair[0] = matrix.row(0).extend(set as f32);
        pair[1] = matrix.row(1).extend(0.0);
    }
    rows[4].w = tangent_uv_set as f32;
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;
    use manypass_scene::TexturedFactor;
    use manypass_scene::material::Clearcoat;

    #[test]
    fn a_byte_of_the_gbuffer_tells_how_rough_a_coat_is() {
        for roughness in [0.0, 0.1, 0.37, 0.5, 1.0] {
            let [weight, roughness_factor] = [1.0, roughness].map(TexturedFactor::new);
            let coat = Clearcoat { weight, roughness: roughness_factor, ..Clearcoat::default() };
            let material = Material { clearcoat: Some(coat), ..Material::default() };
            let byte = (shading_model_of(&material, LAYER_CLEARCOAT) * 255.0).round() / 255.0;
            let range = SHADING_MODEL_COATED_ROUGH - SHADING_MODEL_COATED_SMOOTH;
            assert!(((byte - SHADING_MODEL_COATED_SMOOTH) / range - roughness).abs() < 0.01, "{roughness}: {byte}");
            assert!(is_shaded_where_drawn(byte) && byte > SHADING_MODEL_FORWARD);
        }
        let plain = Material::default();
        assert_eq!(shading_model_of(&plain, LAYER_CLEARCOAT), SHADING_MODEL_FORWARD);
        assert_eq!(shading_model_of(&plain, LAYER_GLOSSINESS), SHADING_MODEL_UNTRACED);
        assert_eq!(shading_model_of(&plain, 0), SHADING_MODEL_STANDARD);
    }

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "forward",
            "MaterialFactors",
            MaterialFactors,
            [
                base_color,
                emissive,
                metallic,
                roughness,
                normal_scale,
                occlusion_strength,
                alpha_cutoff,
                shading_model,
                material_id,
                blended,
                double_sided,
                f0_dielectric,
                cast_through,
                casts_in_part,
                normal_y_sign,
                uv_rows,
            ]
        );
    }
}
