//! What surfaces do with light, as far as diffuse light knows: how much they send back, how much they give, and where
//! they are not there.

use glam::{Mat3, Vec2, Vec3, Vec4};
use manypass_scene::colour::linear_from_srgb;
use manypass_scene::{AlphaMode, Material, Scene, ShadingModel, TextureRef, Wrap};
use std::hash::{DefaultHasher, Hasher as _};
use std::sync::Arc;

/// The longest side of an image that is kept: what a surface sends back is spread over the room.
const SIDE_MAX: u32 = 256;

/// No surface sends back more than this share of light, so that bounces end.
const REFLECTANCE_MAX: f32 = 0.99;

/// The mean of Schlick's fifth power over all directions, as dense as their cosine.
const SCHLICK_MEAN: f32 = 1.0 / 21.0;

/// The linear values of all bytes of sRGB.
fn linear_of_srgb() -> [f32; 256] {
    std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0))
}

/// Texels of an image that was made small.
struct Texels {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

/// A hash stands for the texels.
impl std::fmt::Debug for Texels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut hasher = DefaultHasher::new();
        hasher.write(&self.rgba);
        write!(f, "Texels({}x{}, {:016x})", self.width, self.height, hasher.finish())
    }
}

/// A texture as a material uses it.
#[derive(Clone, Debug)]
struct Map {
    texels: Arc<Texels>,
    uv_set: u32,
    placed: Mat3,
    wraps: [Wrap; 2],
}

impl Map {
    /// The texel at a place, from 0 to 1 each.
    fn at(&self, uv: [Vec2; 2]) -> [u8; 4] {
        let uv = self.placed.transform_point2(uv[(self.uv_set as usize).min(1)]);
        let place = |value: f32, wrap: Wrap, count: u32| -> u32 {
            let value = match wrap {
                Wrap::Repeat => value - value.floor(),
                Wrap::MirroredRepeat => 1.0 - (value - 2.0 * (0.5 * value).floor() - 1.0).abs(),
                Wrap::ClampToEdge => value,
            };
            // Of what is not finite this is 0.
            ((value * count as f32) as u32).min(count - 1)
        };
        let (x, y) = (place(uv.x, self.wraps[0], self.texels.width), place(uv.y, self.wraps[1], self.texels.height));
        let index = 4 * (y as usize * self.texels.width as usize + x as usize);
        self.texels.rgba.get(index..index + 4).and_then(|texel| texel.try_into().ok()).unwrap_or([255; 4])
    }
}

/// What a place of a surface does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shade {
    /// The share of the light that arrives which leaves again.
    pub reflectance: Vec3,
    /// Its own radiance.
    pub emission: Vec3,
}

/// A material, without what diffuse light does not ask for.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// Whether light goes through it as if it were not there: glass, and what is blended.
    pub is_clear: bool,
    /// Whether it has two sides; the back of others is black.
    pub double_sided: bool,
    /// Whether it keeps light from what lies behind.
    pub casts_shadow: bool,
    /// Whether anything of it may shine.
    pub shines: bool,
    base: Vec4,
    base_map: Option<Map>,
    cutoff: Option<f32>,
    metallic: f32,
    metallic_map: Option<Map>,
    specular: (Vec3, f32),
    emission: Vec3,
    emission_map: Option<Map>,
    is_unlit: bool,
}

/// All materials of a scene, and behind them the one of surfaces that have none.
#[derive(Debug)]
pub(crate) struct Surfacing {
    surfaces: Vec<Surface>,
    linear: [f32; 256],
}

/// Images of a scene, decoded when they are first asked for.
struct Images<'s> {
    scene: &'s Scene,
    known: Vec<Option<Option<Arc<Texels>>>>,
    warnings: Vec<String>,
}

impl Images<'_> {
    fn map(&mut self, reference: Option<TextureRef>) -> Option<Map> {
        let reference = reference?;
        let texture = *self.scene.textures.get(reference.texture)?;
        let known = self.known.get_mut(texture.image)?;
        if known.is_none() {
            let image = self.scene.images.get(texture.image)?;
            *known = Some(match image.decode() {
                Ok(pixels) => {
                    let longest = pixels.width.max(pixels.height).max(1);
                    let scaled = |side: u32| if longest > SIDE_MAX { (side * SIDE_MAX / longest).max(1) } else { side };
                    let (width, height) = (scaled(pixels.width), scaled(pixels.height));
                    Some(Arc::new(Texels { width, height, rgba: pixels.resized(width, height).data }))
                }
                Err(error) => {
                    self.warnings.push(format!("{error}; its surfaces are baked without it"));
                    None
                }
            });
        }
        let texels = self.known.get(texture.image)?.clone()??;
        let sampler = texture.sampler;
        let placed = reference.transform.matrix();
        Some(Map { texels, uv_set: reference.uv_set, placed, wraps: [sampler.wrap_u, sampler.wrap_v] })
    }

    fn surface(&mut self, material: &Material) -> Surface {
        let has_light_through = material.transmission.is_some_and(|transmission| transmission.factor > 0.0);
        let emission = if material.emissive_factor.is_finite() { material.emissive_factor } else { Vec3::ZERO };
        let is_unlit = material.shading_model == ShadingModel::Unlit;
        Surface {
            is_clear: material.alpha_mode == AlphaMode::Blend || has_light_through,
            double_sided: material.double_sided,
            casts_shadow: material.casts_shadow,
            shines: is_unlit || emission.max_element() > 0.0,
            base: material.base_color_factor,
            base_map: self.map(material.base_color_texture),
            cutoff: match material.alpha_mode {
                AlphaMode::Mask { cutoff } => Some(cutoff),
                AlphaMode::Opaque | AlphaMode::Blend => None,
            },
            metallic: material.metallic_factor,
            metallic_map: self.map(material.metallic_roughness_texture),
            specular: specular_of(material),
            emission,
            emission_map: self.map(material.emissive_texture),
            is_unlit,
        }
    }
}

/// Reflectance along the normal and at grazing angles of what is not metal.
fn specular_of(material: &Material) -> (Vec3, f32) {
    let ratio = (material.ior - 1.0) / (material.ior + 1.0);
    let (color, weight) =
        material.specular.map_or((Vec3::ONE, 1.0), |specular| (specular.color.factor, specular.weight.factor));
    ((color * (ratio * ratio)).min(Vec3::ONE) * weight, weight)
}

impl Surface {
    /// Whether a mask leaves holes in it.
    pub fn is_masked(&self) -> bool {
        self.cutoff.is_some()
    }
}

impl Surfacing {
    /// All that it knows, for a key.
    pub fn describe(&self) -> String {
        format!("{:?}", self.surfaces)
    }

    /// Of a scene; what cannot be decoded is told in `warnings`.
    pub fn new(scene: &Scene, warnings: &mut Vec<String>) -> Self {
        let mut images = Images { scene, known: vec![None; scene.images.len()], warnings: Vec::new() };
        let mut surfaces: Vec<Surface> = scene.materials.iter().map(|material| images.surface(material)).collect();
        surfaces.push(images.surface(&Material::default()));
        warnings.append(&mut images.warnings);
        Self { surfaces, linear: linear_of_srgb() }
    }

    /// That of a material; of none the default one.
    pub fn surface(&self, material: Option<usize>) -> &Surface {
        let default = self.surfaces.len() - 1;
        &self.surfaces[material.unwrap_or(default).min(default)]
    }

    /// Whether a surface is there, by its mask. `alpha` is that of vertices.
    pub fn is_there(&self, surface: &Surface, uv: [Vec2; 2], alpha: f32) -> bool {
        let Some(cutoff) = surface.cutoff else { return true };
        let of_map = surface.base_map.as_ref().map_or(1.0, |map| f32::from(map.at(uv)[3]) / 255.0);
        of_map * surface.base.w * alpha >= cutoff
    }

    fn color(&self, map: Option<&Map>, uv: [Vec2; 2]) -> Vec3 {
        let Some(map) = map else { return Vec3::ONE };
        let [r, g, b, _] = map.at(uv).map(|byte| self.linear[usize::from(byte)]);
        Vec3::new(r, g, b)
    }

    /// What a place of a surface does. `color` is that of vertices.
    ///
    /// Light that is mirrored counts as if it were scattered: energy stays, while caustics are missing.
    pub fn shade(&self, surface: &Surface, uv: [Vec2; 2], color: Vec3) -> Shade {
        let base = surface.base.truncate() * self.color(surface.base_map.as_ref(), uv) * color;
        let emission = surface.emission * self.color(surface.emission_map.as_ref(), uv);
        if surface.is_unlit {
            return Shade { reflectance: Vec3::ZERO, emission: base };
        }
        let base = base.clamp(Vec3::ZERO, Vec3::ONE);
        let metallic = surface.metallic_map.as_ref().map_or(1.0, |map| f32::from(map.at(uv)[2]) / 255.0);
        let metallic = (surface.metallic * metallic).clamp(0.0, 1.0);
        let (f0, f90) = surface.specular;
        let mirrored = f0 + (Vec3::splat(f90) - f0) * SCHLICK_MEAN;
        let of_dielectric = base * (1.0 - mirrored.max_element()) + mirrored;
        let of_metal = base + (Vec3::ONE - base) * SCHLICK_MEAN;
        let reflectance = of_dielectric.lerp(of_metal, metallic).min(Vec3::splat(REFLECTANCE_MAX));
        Shade { reflectance, emission }
    }
}
