//! Materials that a stage changes: what casts shadows, and maps that the model has not.

use super::heights::HeightChange;
use super::names::Pattern;
use super::table::{Source, SpannedValue, Table};
use crate::gltf_file::{MAX_FILE_BYTES, texel_budget_bytes};
use crate::material::{DetailMaps, LightEncoding, LightMap, TexturedFactor};
use crate::{Diagnostic, Image, ImageSource, Material, Sampler, Scene, Texture, TextureRef, TextureTransform, Wrap};
use glam::{Vec2, Vec3};
use std::collections::{HashMap, HashSet};

/// Keys that say how a map is used, and the key of that map.
const OF_MAPS: [(&str, &[&str]); 8] = [
    ("occlusion_texcoord", &["occlusion_map"]),
    ("emissive_texcoord", &["emissive_map"]),
    ("detail_normal_scale", &["detail_normal_map"]),
    ("detail_scale", &["detail_normal_map", "detail_color_map"]),
    ("light_map_texcoord", &["light_map"]),
    ("light_map_intensity", &["light_map"]),
    ("light_map_encoding", &["light_map"]),
    ("light_map_direction", &["light_map"]),
];

/// Keys that name an image.
pub(super) const MAPS: [&str; 7] = [
    "occlusion_map",
    "emissive_map",
    "height_map",
    "detail_normal_map",
    "detail_color_map",
    "light_map",
    "light_map_direction",
];

/// What changes of the materials that have a name.
#[derive(Clone, Debug)]
pub(super) struct MaterialChange {
    pub(super) names: SpannedValue<Pattern>,
    pub(super) casts_shadow: Option<bool>,
    has_normals_down: Option<bool>,
    occlusion: Option<(SpannedValue<String>, u32)>,
    emissive: Option<(SpannedValue<String>, u32)>,
    height: Option<HeightChange>,
    detail: Option<Detail>,
    light_map: Option<(SpannedValue<String>, LightMap, u32)>,
    light_direction: Option<SpannedValue<String>>,
}

#[derive(Clone, Debug)]
struct Detail {
    normal: Option<SpannedValue<String>>,
    normal_scale: f32,
    color: Option<SpannedValue<String>>,
    repeats: f32,
}

/// A texture whose place in the scene is not known yet.
fn unplaced(uv_set: u32) -> TextureRef {
    TextureRef { texture: 0, uv_set, transform: TextureTransform::default() }
}

impl MaterialChange {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let name = table.text("name").ok_or_else(|| table.fault("name", "`name` is missing"))?;
        for (key, maps) in OF_MAPS {
            if table.place(key).is_some() && !maps.iter().any(|map| table.place(map).is_some()) {
                return Err(table.fault(key, format!("`{key}` needs `{}`", maps.join("` or `"))));
            }
        }
        for key in MAPS {
            if table.text(key).is_some_and(|name| name.value.trim().is_empty()) {
                return Err(table.fault(key, format!("the name of `{key}` is empty; name a file such as bricks.png")));
            }
        }
        let height = HeightChange::read(table)?;
        let on_set = |map: &str, set: &str| -> Result<Option<(SpannedValue<String>, u32)>, Box<Diagnostic>> {
            match table.text(map) {
                Some(image) => Ok(Some((image, uv_set(table, set, 1)?))),
                None => Ok(None),
            }
        };
        let light_map = on_set("light_map", "light_map_texcoord")?.map(|(image, set)| {
            let encoding = table.text("light_map_encoding").and_then(|word| LightEncoding::named(&word.value));
            let encoding = encoding.unwrap_or_default();
            let factor = table.number("light_map_intensity").unwrap_or(1.0);
            (
                image,
                LightMap { light: TexturedFactor { factor, texture: Some(unplaced(set)) }, encoding, direction: None },
                set,
            )
        });
        let (normal, color) = (table.text("detail_normal_map"), table.text("detail_color_map"));
        let detail = (normal.is_some() || color.is_some()).then(|| Detail {
            normal,
            normal_scale: table.number("detail_normal_scale").unwrap_or(1.0),
            color,
            repeats: table.number("detail_scale").unwrap_or(8.0),
        });
        Ok(Self {
            names: SpannedValue { value: Pattern::new(&name.value), range: name.range },
            casts_shadow: table.boolean("cast_shadow"),
            has_normals_down: table.text("normal_convention").map(|word| word.value == "directx"),
            occlusion: on_set("occlusion_map", "occlusion_texcoord")?,
            emissive: on_set("emissive_map", "emissive_texcoord")?,
            height,
            detail,
            light_map,
            light_direction: table.text("light_map_direction"),
        })
    }

    /// The images that it names.
    pub(super) fn images(&self) -> impl Iterator<Item = &SpannedValue<String>> {
        let of_detail = self.detail.iter().flat_map(|detail| detail.normal.iter().chain(&detail.color));
        let others = self.occlusion.iter().chain(&self.emissive).map(|(image, _)| image);
        let of_height = self.height.iter().filter_map(|height| height.image.as_ref());
        let of_light = self.light_map.iter().map(|(image, ..)| image);
        others.chain(of_height).chain(of_detail).chain(of_light).chain(&self.light_direction)
    }

    /// Files of light are for light maps alone, and linear.
    fn check_light(&self, source: &Source, holds_light: impl Fn(&str) -> bool) -> Result<(), Box<Diagnostic>> {
        let baked = self.light_map.as_ref();
        for image in self.images().filter(|image| holds_light(&image.value)) {
            let is_baked = baked.is_some_and(|(light, ..)| light.range == image.range);
            if !is_baked {
                let message = format!("`{}` holds light, which `light_map` alone takes", image.value);
                return Err(
                    source.fault(image.range.clone(), format!("{message}; name a PNG, JPEG, WebP or KTX2 file"))
                );
            }
            if baked.is_some_and(|(_, light_map, _)| light_map.encoding != LightEncoding::Linear) {
                let message = format!("`{}` holds linear light; leave out `light_map_encoding`", image.value);
                return Err(source.fault(image.range.clone(), message));
            }
        }
        Ok(())
    }

    /// Changes all that have the name, with maps that `images` has read. What is odd but does not hinder is told in
    /// `warnings`.
    pub(super) fn apply(
        &self,
        source: &Source,
        scene: &mut Scene,
        images: &StageImages,
        warnings: &mut Vec<String>,
    ) -> Result<(), Box<Diagnostic>> {
        let pattern = &self.names.value;
        let found: Vec<usize> = (0..scene.materials.len())
            .filter(|index| scene.materials.get(*index).is_some_and(|material| pattern.matches(&material.name)))
            .collect();
        if found.is_empty() {
            let message = format!("the model has no material called `{}`", pattern.text());
            let known = scene.materials.iter().map(|material| material.name.as_str());
            return Err(source.unknown(self.names.range.clone(), message, pattern.text(), known));
        }
        if let Some(height) = &self.height {
            let materials = found.iter().filter_map(|index| scene.materials.get(*index));
            height.check(source, materials, pattern)?;
        }
        for index in &found {
            let Some(mut material) = scene.materials.get(*index).cloned() else { continue };
            self.change(&mut material, &mut |image, wrap| images.texture(scene, image, wrap));
            if let Some(material_place) = scene.materials.get_mut(*index) {
                *material_place = material;
            }
        }
        warnings.extend(self.missing_sets(scene, &found));
        Ok(())
    }

    fn change(&self, material: &mut Material, texture: &mut dyn FnMut(&SpannedValue<String>, Wrap) -> usize) {
        material.casts_shadow = self.casts_shadow.unwrap_or(material.casts_shadow);
        material.has_normals_down = self.has_normals_down.unwrap_or(material.has_normals_down);
        if let Some((image, uv_set)) = &self.occlusion {
            material.occlusion_texture =
                Some(TextureRef { texture: texture(image, Wrap::Repeat), ..unplaced(*uv_set) });
        }
        if let Some((image, uv_set)) = &self.emissive {
            material.emissive_texture = Some(TextureRef { texture: texture(image, Wrap::Repeat), ..unplaced(*uv_set) });
            if material.emissive_factor == Vec3::ZERO {
                material.emissive_factor = Vec3::ONE;
            }
        }
        // Heights lie as what they belong to.
        let placed = material.base_color_texture.or(material.normal_texture).unwrap_or(unplaced(0));
        if let Some(height) = &self.height {
            let image = height.image.as_ref();
            let texture = image.map(|image| TextureRef { texture: texture(image, Wrap::Repeat), ..placed });
            let own = material.height.map(|own| (own.texture, Some(own)));
            let found = texture.map(|texture| (texture, None)).or(own);
            material.height = found.map(|(texture, own)| height.of(texture, own));
        }
        if let Some(detail) = &self.detail {
            let transform = TextureTransform { scale: Vec2::splat(detail.repeats), ..TextureTransform::default() };
            let mut placed = |image: &SpannedValue<String>| {
                Some(TextureRef { texture: texture(image, Wrap::Repeat), uv_set: placed.uv_set, transform })
            };
            material.detail = Some(DetailMaps {
                normal_texture: detail.normal.as_ref().and_then(&mut placed),
                normal_scale: detail.normal_scale,
                base_color_texture: detail.color.as_ref().and_then(&mut placed),
            });
        }
        if let Some((image, light_map, uv_set)) = &self.light_map {
            let mut placed =
                |image| Some(TextureRef { texture: texture(image, Wrap::ClampToEdge), ..unplaced(*uv_set) });
            let light = TexturedFactor { texture: placed(image), ..light_map.light };
            let direction = self.light_direction.as_ref().and_then(placed);
            material.light_map = Some(LightMap { light, direction, ..*light_map });
        }
    }

    /// What there is to say where surfaces lack the UV set that a map lies on.
    fn missing_sets(&self, scene: &Scene, materials: &[usize]) -> Vec<String> {
        // Heights and details lie as what they belong to, which may differ from material to material.
        let changed = || materials.iter().filter_map(|index| scene.materials.get(*index));
        let set_of_height = changed().find_map(|material| material.height.map(|height| height.texture.uv_set));
        let set_of_detail = changed().find_map(|material| {
            let detail = material.detail.as_ref()?;
            detail.normal_texture.or(detail.base_color_texture).map(|texture| texture.uv_set)
        });
        let of_detail = self.detail.iter().flat_map(|detail| [&detail.normal, &detail.color]).flatten();
        let with_sets = [
            self.light_map.as_ref().map(|(image, _, set)| (image, *set)),
            self.occlusion.as_ref().map(|(image, set)| (image, *set)),
            self.emissive.as_ref().map(|(image, set)| (image, *set)),
            self.height.as_ref().and_then(|height| height.image.as_ref()).zip(set_of_height),
        ];
        let maps = with_sets.into_iter().flatten().chain(of_detail.zip(set_of_detail.into_iter().cycle()));
        // A material may be shown in a variant alone, or where the surface is small.
        let is_changed = |material: usize| {
            let coarser = scene.materials.get(material).and_then(|material| material.levels.as_ref());
            let mut shown = coarser.into_iter().flat_map(|levels| &levels.coarser);
            materials.contains(&material) || shown.any(|material| materials.contains(material))
        };
        let is_without = |primitive: &crate::Primitive, set: u32| {
            let of_variants = primitive.variant_materials.iter().map(|(_, material)| *material);
            let uv = if set == 0 { &primitive.uv0 } else { &primitive.uv1 };
            uv.is_empty() && primitive.material.into_iter().chain(of_variants).any(is_changed)
        };
        let is_missing = [0, 1].map(|set| {
            let mut primitives = scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
            primitives.any(|primitive| is_without(primitive, set))
        });
        let of_map = |(image, set): (&SpannedValue<String>, u32)| {
            let remedy = match (set, is_missing[0]) {
                (1, false) => "give it `…_texcoord = 0`, or a second UV set to the model",
                (1, true) => "give the model a second UV set",
                _ => "give the model UVs",
            };
            format!(
                "`{}` lies on UV set {set} of `{}`, which some of its surfaces lack: they show the map's first texel; \
                 {remedy}",
                image.value,
                self.names.value.text()
            )
        };
        maps.filter(|(_, set)| is_missing[usize::from(*set != 0)]).map(of_map).collect()
    }
}

/// A UV set: 0 or 1.
fn uv_set(table: &Table<'_>, key: &str, default: u32) -> Result<u32, Box<Diagnostic>> {
    match table.number(key) {
        None => Ok(default),
        Some(0.0) => Ok(0),
        Some(1.0) => Ok(1),
        Some(other) => Err(table.fault(key, format!("there are the UV sets 0 and 1, and not {other}"))),
    }
}

/// The images of a stage by their names, each read once.
#[derive(Debug, Default)]
pub(super) struct StageImages {
    images: HashMap<String, usize>,
}

impl StageImages {
    /// Reads all images that `changes` and `others` name, and adds them to the scene.
    ///
    /// # Errors
    /// One cannot be read, or all of them take too much memory together.
    pub(super) fn read<'c>(
        source: &Source,
        changes: impl Iterator<Item = &'c MaterialChange> + Clone,
        others: impl Iterator<Item = &'c SpannedValue<String>>,
        scene: &mut Scene,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Self, Box<Diagnostic>> {
        let mut read = Self::default();
        let (mut encoded_bytes, mut texel_bytes) = (0_u64, 0_u64);
        let mut of_light = HashSet::new();
        let others: Vec<&SpannedValue<String>> = others.collect();
        for name in changes.clone().flat_map(MaterialChange::images).chain(others.iter().copied()) {
            if read.images.contains_key(&name.value) {
                continue;
            }
            let fault = |message: String| source.fault(name.range.clone(), message);
            let bytes = resolve(&name.value).map_err(fault)?;
            encoded_bytes += bytes.len() as u64;
            let image = Image { name: name.value.clone(), source: ImageSource::Encoded(bytes.into()) };
            let (width, height) = image.dimensions().map_err(|error| fault(error.to_string()))?;
            let bytes_a_texel = if image.holds_light() { 8 } else { 4 };
            if image.holds_light() {
                of_light.insert(name.value.clone());
            }
            texel_bytes += u64::from(width) * u64::from(height) * bytes_a_texel;
            let budget_bytes = texel_budget_bytes(encoded_bytes);
            if texel_bytes > budget_bytes || encoded_bytes > MAX_FILE_BYTES {
                let most = budget_bytes >> 20;
                return Err(fault(format!("the images of the stage take more than {most} MiB; make them smaller")));
            }
            read.images.insert(name.value.clone(), scene.images.len());
            scene.images.push(image);
        }
        if let Some(name) = others.into_iter().find(|name| of_light.contains(&name.value)) {
            let message = format!("`{}` holds light; name a PNG, JPEG, WebP or KTX2 file", name.value);
            return Err(source.fault(name.range.clone(), message));
        }
        for change in changes {
            change.check_light(source, |name| of_light.contains(name))?;
        }
        Ok(read)
    }

    /// The place of an image that was read among the scene's.
    pub(super) fn index(&self, name: &SpannedValue<String>) -> usize {
        self.images.get(&name.value).copied().unwrap_or(usize::MAX)
    }

    /// The texture that shows an image, which goes on beyond its edges as `wrap` says.
    pub(super) fn texture(&self, scene: &mut Scene, name: &SpannedValue<String>, wrap: Wrap) -> usize {
        let image = self.index(name);
        let texture = Texture { image, sampler: Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() } };
        let known = scene.textures.iter().position(|known| *known == texture);
        known.unwrap_or_else(|| {
            scene.textures.push(texture);
            scene.textures.len() - 1
        })
    }
}
