//! A scene on the device: geometry, materials, textures, and the tables that animation changes.

pub mod estimate;
pub mod filtering;
pub mod geometry;
mod packing;
pub mod textures;

use crate::constants::DATA_WIDTH;
use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use bytemuck::{Pod, Zeroable};
use geometry::{Geometry, GpuPrimitive};
use glam::{Vec3, Vec4};
use manypass_scene::{AlphaMode, Material, Scene, ShadingModel, TextureRef};
use std::cell::RefCell;
use textures::Textures;

/// The uniform of `surface_material.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct MaterialFactors {
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
    /// Strength of the occlusion texture.
    pub occlusion_strength: f32,
    /// Fragments with less alpha are dropped.
    pub alpha_cutoff: f32,
    /// 1 unlit, 0 lit.
    pub unlit: f32,
    /// Index of the material.
    pub material_id: u32,
    /// 1 if alpha covers.
    pub blended: f32,
    /// Zero.
    pub padding: f32,
    /// Two rows for each of the five textures.
    pub uv_rows: [Vec4; 10],
}

/// A material on the device.
#[derive(Debug)]
pub struct GpuMaterial {
    /// The material's factors.
    pub uniform: wgpu::Buffer,
    /// Whether any texture but the normal map is used.
    pub textured: bool,
    /// Whether occlusion has a texture of its own, beside that of metallic-roughness.
    pub occlusion_apart: bool,
    /// Whether there is a normal map.
    pub normal_map: bool,
    /// Whether fragments are dropped by alpha.
    pub masked: bool,
    /// Whether alpha covers what lies behind.
    pub blended: bool,
    /// Whether back faces are drawn.
    pub double_sided: bool,
    /// The textures: base colour, metallic-roughness, normal, occlusion, emissive; indices into [`Textures`].
    pub textures: [usize; 5],
    /// Bind groups with the program that each was made for, and how its samplers filter.
    pub bind_groups: RefCell<Vec<(u32, filtering::Sampling, wgpu::BindGroup)>>,
}

/// A scene on the device.
#[derive(Debug)]
pub struct SceneResources {
    /// Vertices and indices.
    pub geometry: Geometry,
    /// The scene's materials, and the default material last.
    pub materials: Vec<GpuMaterial>,
    /// The textures of all materials.
    pub textures: Textures,
    /// Rows of `world_from_mesh` for every joint of every skinned node.
    pub joint_matrices: DataTexture,
    /// Displacements of morph targets.
    pub morph_displacements: DataTexture,
    /// Weights of morph targets of every node that has some.
    pub morph_weights: DataTexture,
    /// Transforms of all nodes in the previous frame, and where their joints and weights are; see `motion.wgsl`.
    pub previous_nodes: DataTexture,
    /// What was left out, or replaced.
    pub warnings: Vec<String>,
}

impl SceneResources {
    /// Uploads a scene.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Self {
        let mut warnings = Vec::new();
        let textures = Textures::new(gpu, scene, &mut warnings);
        let mut morph_displacements =
            DataTexture::new(&gpu.device, "morph_displacements", wgpu::TextureFormat::Rgba32Float, DATA_WIDTH);
        let geometry = Geometry::new(gpu, scene, &mut morph_displacements, &mut warnings);
        let default = Material::default();
        let materials = scene
            .materials
            .iter()
            .chain([&default])
            .enumerate()
            .map(|(index, material)| upload_material(gpu, scene, material, index as u32, &textures))
            .collect();
        Self {
            geometry,
            materials,
            textures,
            joint_matrices: DataTexture::new(
                &gpu.device,
                "joint_matrices",
                wgpu::TextureFormat::Rgba32Float,
                DATA_WIDTH,
            ),
            morph_displacements,
            morph_weights: DataTexture::new(&gpu.device, "morph_weights", wgpu::TextureFormat::R32Float, DATA_WIDTH),
            previous_nodes: DataTexture::new(
                &gpu.device,
                "previous_nodes",
                wgpu::TextureFormat::Rgba32Float,
                DATA_WIDTH,
            ),
            warnings,
        }
    }

    /// The material of a primitive; the default material if it has none.
    pub fn material_of(&self, primitive: &GpuPrimitive) -> (usize, &GpuMaterial) {
        let last = self.materials.len() - 1;
        let index = primitive.material.unwrap_or(last).min(last);
        (index, &self.materials[index])
    }
}

fn upload_material(gpu: &Gpu, scene: &Scene, material: &Material, index: u32, textures: &Textures) -> GpuMaterial {
    // What a texture multiplies stays as it is without one, and a normal map without one is flat (glTF 2.0).
    let is_packed = textures.is_packed(material);
    let slots = [
        (material.base_color_texture, true, false),
        (material.metallic_roughness_texture, false, is_packed),
        (material.normal_texture, false, false),
        (material.occlusion_texture, false, is_packed),
        (material.emissive_texture, true, false),
    ]
    .map(|(slot, is_srgb, is_packed)| slot.filter(|slot| is_packed || textures.is_there(slot.texture, is_srgb)));
    let is_dark = material.emissive_texture.is_some() && slots[4].is_none();
    let mut uv_rows = [Vec4::ZERO; 10];
    for (slot, reference) in slots.iter().enumerate() {
        let (matrix, set) = reference.map_or((glam::Mat3::IDENTITY, 0), |r| (r.transform.matrix(), r.uv_set));
        uv_rows[slot * 2] = matrix.row(0).extend(set as f32);
        uv_rows[slot * 2 + 1] = matrix.row(1).extend(0.0);
    }
    let masked = matches!(material.alpha_mode, AlphaMode::Mask { .. });
    let blended = material.alpha_mode == AlphaMode::Blend;
    let factors = MaterialFactors {
        base_color: material.base_color_factor,
        // Without its texture, the factor alone would shine all over.
        emissive: if is_dark { Vec3::ZERO } else { material.emissive_factor },
        metallic: material.metallic_factor,
        roughness: material.roughness_factor,
        normal_scale: material.normal_scale,
        // Red of metallic-roughness alone means nothing.
        occlusion_strength: slots[3].map_or(0.0, |_| material.occlusion_strength),
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Mask { cutoff } => cutoff,
            _ => 0.0,
        },
        unlit: if material.shading_model == ShadingModel::Unlit { 1.0 } else { 0.0 },
        material_id: index,
        blended: if blended { 1.0 } else { 0.0 },
        padding: 0.0,
        uv_rows,
    };
    let uniform = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("material_factors"),
        size: size_of::<MaterialFactors>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&factors));
    let index_of = |reference: Option<TextureRef>, is_srgb: bool| {
        reference.map_or(Textures::WHITE, |reference| textures.index_of(reference.texture, is_srgb))
    };
    let (rough_metal, occlusion) = textures.rough_metal_occlusion(scene, material);
    GpuMaterial {
        uniform,
        textured: [0, 1, 3, 4].iter().any(|slot| slots[*slot].is_some()),
        occlusion_apart: slots[3].is_some() && occlusion.is_some(),
        normal_map: slots[2].is_some(),
        masked,
        blended,
        double_sided: material.double_sided,
        textures: [
            index_of(slots[0], true),
            rough_metal,
            index_of(slots[2], false),
            occlusion.unwrap_or(Textures::WHITE),
            index_of(slots[4], true),
        ],
        bind_groups: RefCell::default(),
    }
}

impl SceneResources {
    /// Uploads the transforms of skins and the weights of morph targets of this frame, if they changed, and says how many
    /// bytes that were.
    pub fn write_deformation(&mut self, gpu: &Gpu, deformation: &crate::draws::Deformation) -> u64 {
        let joints = self.joint_matrices.write(&gpu.device, &gpu.queue, &deformation.joint_rows);
        let weights = self.morph_weights.write(&gpu.device, &gpu.queue, &deformation.morph_weights);
        let message = "the joints or morph weights do not fit a texture of this adapter; they keep their last pose";
        if joints.is_none() || weights.is_none() {
            self.warn_once(message);
        }
        joints.unwrap_or(0) + weights.unwrap_or(0)
    }

    /// Uploads the previous transforms of all nodes, if they changed, and says how many bytes that were. `None`, with a
    /// warning, if they do not fit a texture.
    pub fn write_previous_nodes(&mut self, gpu: &Gpu, texels: &[[f32; 4]]) -> Option<u64> {
        let written = self.previous_nodes.write(&gpu.device, &gpu.queue, texels);
        if written.is_none() {
            self.warn_once("the nodes do not fit a texture of this adapter; motion is 0");
        }
        written
    }

    fn warn_once(&mut self, message: &str) {
        if !self.warnings.iter().any(|warning| warning == message) {
            self.warnings.push(message.into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

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
                unlit,
                material_id,
                blended,
                padding,
                uv_rows,
            ]
        );
    }
}
