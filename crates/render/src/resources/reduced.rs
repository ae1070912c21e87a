//! What of materials is drawn where their surfaces are seen small: factors without layers, and factors with the means
//! of textures in their place. They are made only for frames that ask for it, and only of what changed.

use super::layers::{FactorsOf, f0_without_layers};
use super::materials::{
    GpuMaterial, MaterialFactors, Materials, SHADING_MODEL_BAKED, SHADING_MODEL_STANDARD, UNIFORM_ALIGNMENT_BYTES,
    binding, is_shaded_where_drawn,
};
use super::means::{SurfaceTexture, means};
use super::pages::{Pages, Place};
use super::textures::{SampledTexture, Textures};
use crate::gpu::Gpu;
use glam::{Vec3, Vec4};
use manypass_scene::{Material, Scene};
use std::collections::{HashMap, HashSet};

/// A primitive of a mesh.
type Surface = (u32, u32);

/// The linear means of a material's five textures.
type Means = [Vec4; 5];

/// Factors with the means of textures may differ by so much between the surfaces of a material, in units of the
/// display: where one shows other parts of a texture than most, it keeps the texture.
const DIFFERENCE_MAX: f32 = 0.05;

/// Of one material.
#[derive(Debug, Default)]
struct MaterialMeans {
    /// What the means are of.
    made_of: Option<([SampledTexture; 5], [Vec4; 10])>,
    /// Means over each of its surfaces, and over all together.
    means: Option<(Means, Vec<(Surface, Means)>)>,
    /// Surfaces that show other parts of the textures than most.
    unlike: HashSet<Surface>,
    plain: Option<PlacedFactors>,
    untextured: Option<PlacedFactors>,
}

/// Factors on the device.
#[derive(Debug)]
struct PlacedFactors {
    place: Place,
    factors: MaterialFactors,
}

/// The reduced forms of a scene's materials.
#[derive(Debug)]
pub(crate) struct ReducedMaterials {
    pages: Pages,
    materials: Vec<MaterialMeans>,
    /// The surfaces of each material.
    surfaces: Option<HashMap<usize, Vec<Surface>>>,
    is_current: bool,
}

impl ReducedMaterials {
    /// None yet.
    pub fn new() -> Self {
        let bytes = size_of::<MaterialFactors>().next_multiple_of(UNIFORM_ALIGNMENT_BYTES);
        Self {
            pages: Pages::new("reduced_factors", wgpu::BufferUsages::UNIFORM, bytes),
            materials: Vec::new(),
            surfaces: None,
            is_current: false,
        }
    }

    /// Materials or textures changed.
    pub fn forget_materials(&mut self) {
        (self.surfaces, self.is_current) = (None, false);
    }

    /// Meshes changed.
    pub fn forget_meshes(&mut self) {
        self.forget_materials();
        self.materials.iter_mut().for_each(|reduced| reduced.made_of = None);
    }

    /// Brings all up to date, and says how many bytes that wrote.
    pub fn follow(&mut self, gpu: &Gpu, scene: &Scene, materials: &Materials, textures: &Textures) -> u64 {
        if self.is_current {
            return 0;
        }
        let count = scene.materials.len();
        for dropped in self.materials.drain(count.min(self.materials.len())..) {
            dropped.plain.iter().chain(&dropped.untextured).for_each(|placed| self.pages.give_back(&placed.place));
        }
        self.materials.resize_with(count, MaterialMeans::default);
        let surfaces = self.surfaces.take().unwrap_or_else(|| surfaces_of(scene));
        for (index, (material, reduced)) in scene.materials.iter().zip(&mut self.materials).enumerate() {
            let whole = materials.get(index);
            let plain = plain_of(material, whole);
            reduced.follow_means(scene, whole, textures, surfaces.get(&index).map_or(&[], Vec::as_slice));
            let untextured =
                reduced.means.as_ref().map(|(means, _)| untextured_of(plain.unwrap_or(whole.factors), means));
            let has_moved = [(&mut reduced.plain, plain), (&mut reduced.untextured, untextured)]
                .map(|(known, factors)| place(gpu, &mut self.pages, (known, factors), (count - index) as u64));
            if has_moved.contains(&true) {
                whole.forget_reduced();
            }
        }
        (self.surfaces, self.is_current) = (Some(surfaces), true);
        self.pages.flush(&gpu.queue);
        self.pages.trim();
        self.pages.take_written_bytes()
    }

    /// Whether [`Self::follow`] has nothing to do.
    pub fn is_current(&self) -> bool {
        self.is_current
    }

    /// Whether a material has a form without layers.
    pub fn has_plain(&self, material: u32) -> bool {
        self.materials.get(material as usize).is_some_and(|reduced| reduced.plain.is_some())
    }

    /// Whether the means of a material's textures may take their place on a surface.
    pub fn has_untextured(&self, material: u32, surface: Surface) -> bool {
        let reduced = self.materials.get(material as usize);
        reduced.is_some_and(|reduced| reduced.untextured.is_some() && !reduced.unlike.contains(&surface))
    }

    /// The uniform of a material in a form; none of the whole.
    pub fn factors(&self, material: u32, of: FactorsOf) -> Option<wgpu::BindingResource<'_>> {
        let reduced = self.materials.get(material as usize)?;
        let placed = match of {
            FactorsOf::Whole => None,
            FactorsOf::Plain => reduced.plain.as_ref(),
            FactorsOf::Untextured => reduced.untextured.as_ref(),
        };
        binding(&self.pages, &placed?.place, size_of::<MaterialFactors>())
    }
}

impl MaterialMeans {
    /// The means of the textures of a material, if it has some that can be left out.
    fn follow_means(&mut self, scene: &Scene, whole: &GpuMaterial, textures: &Textures, surfaces: &[Surface]) {
        let is_wanted = whole.textured && !whole.masked && !whole.blended && !whole.is_baked;
        if !is_wanted {
            (self.made_of, self.means) = (None, None);
            return;
        }
        let made_of = (whole.textures.clone(), whole.factors.uv_rows);
        if self.made_of.as_ref() != Some(&made_of) {
            self.means = means_of(scene, whole, textures, surfaces);
            self.made_of = Some(made_of);
        }
        self.unlike.clear();
        if let Some((all, of_surfaces)) = &self.means {
            let shown = |means| shown_of(&untextured_of(whole.factors, means));
            let of_all = shown(all);
            let is_unlike = |means| shown(means).iter().zip(of_all).any(|(a, b)| (a - b).abs() > DIFFERENCE_MAX);
            let unlike = of_surfaces.iter().filter(|(_, means)| is_unlike(means));
            self.unlike.extend(unlike.map(|(surface, _)| *surface));
        }
    }
}

/// Puts factors in their place, if they are not there; true if they moved.
fn place(
    gpu: &Gpu,
    pages: &mut Pages,
    (known, factors): (&mut Option<PlacedFactors>, Option<MaterialFactors>),
    expected: u64,
) -> bool {
    let Some(factors) = factors else {
        let former = known.take();
        former.iter().for_each(|former| pages.give_back(&former.place));
        return former.is_some();
    };
    if let Some(known) = known {
        if bytemuck::bytes_of(&known.factors) != bytemuck::bytes_of(&factors) {
            pages.write(&gpu.queue, &known.place, [factors]);
            known.factors = factors;
        }
        return false;
    }
    let Some(place) = pages.take(&gpu.device, 1, expected) else { return false };
    pages.write(&gpu.queue, &place, [factors]);
    *known = Some(PlacedFactors { place, factors });
    true
}

/// The factors of a material without its layers, if it has some that can be left out.
fn plain_of(material: &Material, whole: &GpuMaterial) -> Option<MaterialFactors> {
    whole.layers.as_ref()?;
    let mut factors = whole.factors;
    if is_shaded_where_drawn(factors.shading_model) {
        factors.f0_dielectric = f0_without_layers(material)?;
        factors.shading_model = if whole.is_baked { SHADING_MODEL_BAKED } else { SHADING_MODEL_STANDARD };
    }
    Some(factors)
}

/// Factors with the means of base colour, metallic-roughness, normals, occlusion and emission in them.
fn untextured_of(mut factors: MaterialFactors, means: &Means) -> MaterialFactors {
    let [base_color, rough_metal, _, occlusion, emissive] = means;
    factors.base_color *= base_color.truncate().extend(1.0);
    factors.metallic *= rough_metal.z;
    factors.roughness *= rough_metal.y;
    factors.emissive *= emissive.truncate();
    // Without a texture that is all of it.
    factors.occlusion_strength *= 1.0 - occlusion.x;
    factors
}

/// What is seen of factors, about as a display shows it.
fn shown_of(factors: &MaterialFactors) -> [f32; 9] {
    let displayed = |color: Vec3| (color / (Vec3::ONE + color)).map(f32::sqrt).to_array();
    let [r, g, b] = factors.base_color.truncate().map(|x| x.max(0.0).sqrt()).to_array();
    let [glow_r, glow_g, glow_b] = displayed(factors.emissive.max(Vec3::ZERO));
    [r, g, b, factors.metallic, factors.roughness, factors.occlusion_strength, glow_r, glow_g, glow_b]
}

fn means_of(
    scene: &Scene,
    whole: &GpuMaterial,
    textures: &Textures,
    surfaces: &[Surface],
) -> Option<(Means, Vec<(Surface, Means)>)> {
    let mut laid = [const { None }; 5];
    for (slot, laid) in laid.iter_mut().enumerate() {
        let Some(source) = whole.sources[slot] else { continue };
        let rows = [whole.factors.uv_rows[2 * slot], whole.factors.uv_rows[2 * slot + 1]];
        let is_srgb = source.is_srgb();
        // Without the mean of one the others are of no use; but normals have none.
        *laid = match textures.coarse(scene, source) {
            Some(texels) => Some(SurfaceTexture { texels, is_srgb, sampler: whole.textures[slot].1, rows }),
            None if slot == 2 => None,
            None => return None,
        };
    }
    let (mut sum, mut area_m2, mut of_surfaces) = ([Vec4::ZERO; 5], 0.0, Vec::new());
    for (mesh, index) in surfaces {
        let primitive = scene.meshes.get(*mesh as usize).and_then(|mesh| mesh.primitives.get(*index as usize));
        if let Some((means, area)) = primitive.and_then(|primitive| means(primitive, &laid)) {
            sum.iter_mut().zip(means).for_each(|(sum, mean)| *sum += mean * area);
            area_m2 += area;
            of_surfaces.push(((*mesh, *index), means));
        }
    }
    (area_m2 > 0.0).then(|| (sum.map(|sum| sum / area_m2), of_surfaces))
}

/// The surfaces of each material, in any variant of the scene and at any level.
fn surfaces_of(scene: &Scene) -> HashMap<usize, Vec<Surface>> {
    let mut surfaces: HashMap<usize, Vec<Surface>> = HashMap::new();
    for (mesh, of_mesh) in scene.meshes.iter().enumerate() {
        for (index, primitive) in of_mesh.primitives.iter().enumerate() {
            let of_variants = primitive.variant_materials.iter().map(|(_, material)| *material);
            for material in primitive.material.into_iter().chain(of_variants) {
                let levels = scene.materials.get(material).and_then(|material| material.levels.as_ref());
                let coarser = levels.iter().flat_map(|levels| levels.coarser.iter().copied());
                for material in std::iter::once(material).chain(coarser) {
                    surfaces.entry(material).or_default().push((mesh as u32, index as u32));
                }
            }
        }
    }
    surfaces
}
