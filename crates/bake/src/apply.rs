//! Puts light maps into a scene.

use crate::encode::{Encoding, LightFile, direction_png, emission_png, grey_png, light_file};
use crate::{BakeError, BakedMaps, UnwrappedPrimitive};
use glam::{Vec3, Vec4};
use manypass_scene::material::{LightEncoding, LightMap};
use manypass_scene::{
    Image, ImageSource, LayerMap, Material, MorphTarget, NodeId, Primitive, Sampler, Scene, Texture, TextureRef,
    TextureTransform, TexturedFactor, Wrap,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// How light maps are sampled: what is beyond an edge belongs to nothing.
const SAMPLER: Sampler = Sampler {
    wrap_u: Wrap::ClampToEdge,
    wrap_v: Wrap::ClampToEdge,
    mag_linear: true,
    min_linear: true,
    mip_linear: None,
};

/// The textures of a material that stay: light maps, and occlusion on the second UV set, are of a bake before.
pub(crate) fn textures(material: &Material) -> impl Iterator<Item = TextureRef> + '_ {
    let plain = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.occlusion_texture.filter(|texture| texture.uv_set == 0),
        material.emissive_texture,
    ];
    plain.into_iter().flatten().chain(LayerMap::ALL.iter().filter_map(|map| material.layer_texture(*map)))
}

/// A primitive with the vertices of its place in the maps.
pub(crate) fn remade(primitive: &Primitive, unwrapped: &UnwrappedPrimitive, is_mirrored: bool) -> Primitive {
    fn picked<T: Copy>(values: &[T], unwrapped: &UnwrappedPrimitive) -> Vec<T> {
        let vertices = unwrapped.vertices.iter();
        if values.is_empty() { Vec::new() } else { vertices.map(|(index, _)| values[*index as usize]).collect() }
    }
    let mut indices = unwrapped.indices.clone();
    if is_mirrored {
        indices.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
    }
    let target = |target: &MorphTarget| MorphTarget {
        positions: picked(&target.positions, unwrapped),
        normals: picked(&target.normals, unwrapped),
        tangents: picked(&target.tangents, unwrapped),
    };
    Primitive {
        topology: primitive.topology,
        positions: picked(&primitive.positions, unwrapped),
        normals: picked(&primitive.normals, unwrapped),
        tangents: picked(&primitive.tangents, unwrapped),
        uv0: picked(&primitive.uv0, unwrapped),
        uv1: unwrapped.vertices.iter().map(|(_, uv)| uv.to_array()).collect(),
        colors: picked(&primitive.colors, unwrapped),
        joints: picked(&primitive.joints, unwrapped),
        weights: picked(&primitive.weights, unwrapped),
        indices,
        material: primitive.material,
        variant_materials: primitive.variant_materials.clone(),
        morph_targets: primitive.morph_targets.iter().map(target).collect(),
        levels: Vec::new(),
        bounds: primitive.bounds,
    }
}

/// Whether what a material gives of its own stays as it is, where light is baked as emission.
fn shines(material: &Material) -> bool {
    material.emissive_factor.max_element() > 0.0
}

/// The texture of each map of a page.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PageTextures {
    /// With what it is multiplied by.
    pub light: Option<(usize, f32)>,
    /// Where that comes from.
    pub direction: Option<usize>,
    pub occlusion: Option<usize>,
}

/// The file of a map, what it is called and its media type.
pub(crate) struct MapFile {
    pub name: String,
    pub mime_type: &'static str,
    pub bytes: Vec<u8>,
    /// The extension of textures that have it, if plain glTF has none such.
    pub extension: Option<&'static str>,
}

impl BakedMaps {
    fn of_page<'t, T>(&self, texels: &'t [T], page: u32) -> &'t [T] {
        let count = self.layout.width as usize * self.layout.height as usize;
        texels.get(page as usize * count..(page as usize + 1) * count).unwrap_or_default()
    }

    /// The textures of all pages, which `add` makes of files.
    pub(crate) fn textures(
        &self,
        encoding: Encoding,
        mut add: impl FnMut(MapFile) -> usize,
    ) -> Result<Vec<PageTextures>, BakeError> {
        let (width, height) = (self.layout.width, self.layout.height);
        let mut pages = Vec::new();
        for page in 0..self.layout.page_count {
            let mut of_page = PageTextures::default();
            let light = self.of_page(&self.light, page);
            if !light.is_empty() && self.is_emission {
                let (bytes, factor) = emission_png(light, (width, height))?;
                let file = MapFile { name: format!("emission {page}"), mime_type: "image/png", bytes, extension: None };
                of_page.light = Some((add(file), factor));
            } else if !light.is_empty() {
                let LightFile { mime_type, bytes, factor } = light_file(encoding, light, (width, height))?;
                let name = format!("light map {page}");
                let file = MapFile { name, mime_type, bytes, extension: encoding.extension() };
                of_page.light = Some((add(file), factor));
            }
            let direction = self.of_page(&self.direction, page);
            if !direction.is_empty() {
                let bytes = direction_png(direction, (width, height))?;
                let name = format!("light direction {page}");
                of_page.direction = Some(add(MapFile { name, mime_type: "image/png", bytes, extension: None }));
            }
            let occlusion = self.of_page(&self.occlusion, page);
            if !occlusion.is_empty() {
                let bytes = grey_png(occlusion, width, height)?;
                let name = format!("occlusion {page}");
                of_page.occlusion = Some(add(MapFile { name, mime_type: "image/png", bytes, extension: None }));
            }
            pages.push(of_page);
        }
        Ok(pages)
    }

    /// The primitives that have a place, node by node.
    pub(crate) fn by_node(&self) -> impl Iterator<Item = (NodeId, &[UnwrappedPrimitive])> {
        let nodes = self.layout.unwrapped.chunk_by(|one, other| one.place.node == other.place.node);
        nodes.filter_map(|of_node| Some((of_node.first()?.place.node, of_node)))
    }

    /// Puts the maps into the scene that they were made of: its surfaces have a second UV set, and materials with maps.
    /// Simplified forms of meshes are gone.
    ///
    /// # Errors
    /// The encoder fails.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), BakeError> {
        let pages = self.textures(Encoding::Exr, |file| {
            scene.images.push(Image { name: file.name, source: ImageSource::Encoded(file.bytes.into()) });
            scene.textures.push(Texture { image: scene.images.len() - 1, sampler: SAMPLER });
            scene.textures.len() - 1
        })?;
        let mut materials: BTreeMap<(Option<usize>, u32), usize> = BTreeMap::new();
        let mut baked_material = |scene: &mut Scene, material: Option<usize>, page: u32| {
            *materials.entry((material, page)).or_insert_with(|| {
                let mut baked = material.and_then(|index| scene.materials.get(index).cloned()).unwrap_or_default();
                let of_page = pages.get(page as usize).copied().unwrap_or_default();
                let reference = |texture| TextureRef { texture, uv_set: 1, transform: TextureTransform::default() };
                baked.light_map = None;
                baked.occlusion_texture = baked.occlusion_texture.filter(|texture| texture.uv_set == 0);
                if let Some((texture, factor)) = of_page.light.filter(|_| self.is_emission) {
                    if !shines(&baked) {
                        (baked.emissive_factor, baked.emissive_texture) =
                            (Vec3::splat(factor), Some(reference(texture)));
                        baked.base_color_factor = Vec4::new(0.0, 0.0, 0.0, baked.base_color_factor.w);
                        baked.metallic_factor = 0.0;
                    }
                } else if let Some((texture, factor)) = of_page.light {
                    let light = TexturedFactor { factor, texture: Some(reference(texture)) };
                    let direction = of_page.direction.map(reference);
                    baked.light_map = Some(LightMap { light, encoding: LightEncoding::Linear, direction });
                }
                if let Some(texture) = of_page.occlusion.map(reference) {
                    (baked.occlusion_texture, baked.occlusion_strength) = (Some(texture), 1.0);
                }
                scene.materials.push(baked);
                scene.materials.len() - 1
            })
        };
        for (node, of_node) in self.by_node() {
            let Some(index) = scene.node(node).mesh else { continue };
            let is_mirrored = scene.node(node).world_from_object.determinant() < 0.0;
            let mut mesh = (*scene.meshes[index]).clone();
            for of in of_node {
                let Some(primitive) = mesh.primitives.get_mut(of.place.primitive) else { continue };
                *primitive = remade(primitive, of, is_mirrored);
                primitive.material = Some(baked_material(scene, primitive.material, of.page));
                for (_, material) in &mut primitive.variant_materials {
                    *material = baked_material(scene, Some(*material), of.page);
                }
            }
            scene.node_mut(node).mesh = Some(scene.meshes.len());
            scene.meshes.push(Arc::new(mesh));
        }
        scene.holds_baked_light |= !self.light.is_empty();
        scene.update_transforms();
        Ok(())
    }
}
