//! Materials of the model that show a picture which is none of its own: what a monitor or a simulation makes.

use super::names::Pattern;
use super::table::{Source, SpannedValue, Table, whole};
use super::words::SLOTS;
use crate::gltf_file::geometry::add_tangents;
use crate::{Diagnostic, Image, Primitive, Sampler, Scene, Texture, TextureRef, Wrap};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A picture fills the UV square 0 to 1. UVs that go beyond it by no more than this hide nothing of it that anybody
/// sees.
const UV_MARGIN: f32 = 0.01;

/// Where a picture is shown, by the keys `material`, `slot`, `luminance_cd_m2` and `texcoord`.
#[derive(Clone, Debug)]
pub(super) struct Screen {
    materials: Option<SpannedValue<Pattern>>,
    is_emission: bool,
    luminance_cd_m2: Option<f32>,
    uv_set: Option<u32>,
}

impl Screen {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let materials = table.text("material");
        let is_emission = table.text("slot").is_none_or(|slot| slot.value == SLOTS[0]);
        if !is_emission && table.place("luminance_cd_m2").is_some() {
            let message =
                "`luminance_cd_m2` is only for screens; a base colour is as bright as the light that reaches it";
            return Err(table.fault("luminance_cd_m2", message));
        }
        let of_material = ["slot", "luminance_cd_m2", "texcoord"];
        if let Some(key) = of_material.into_iter().find(|key| table.place(key).is_some() && materials.is_none()) {
            return Err(table.fault(key, format!("`{key}` says how materials show it, and needs `material`")));
        }
        Ok(Self {
            materials: materials.map(|name| SpannedValue { value: Pattern::new(&name.value), range: name.range }),
            is_emission,
            luminance_cd_m2: table.number("luminance_cd_m2"),
            uv_set: table.number("texcoord").map(|set| whole(table, "texcoord", set)).transpose()?,
        })
    }

    /// Whether materials show it.
    pub(super) fn has_materials(&self) -> bool {
        self.materials.is_some()
    }

    /// Makes the scene's last image the normal map of the materials, and gives the meshes that have them tangents.
    ///
    /// # Errors
    /// The model has no material of that name.
    pub(super) fn bend_normals_by_last_image(&self, source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let Some(materials) = &self.materials else { return Ok(()) };
        let sampler = Sampler { wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge, ..Sampler::default() };
        scene.textures.push(Texture { image: scene.images.len().saturating_sub(1), sampler });
        let texture = scene.textures.len() - 1;
        let uv_set = self.uv_set.unwrap_or(0);
        let pattern = &materials.value;
        let named = scene.materials.iter_mut().enumerate().filter(|(_, known)| pattern.matches(&known.name));
        let mut found = Vec::new();
        for (index, material) in named {
            found.push(index);
            material.normal_texture = Some(TextureRef { texture, uv_set, ..TextureRef::default() });
        }
        if found.is_empty() {
            return Err(unknown_material(source, scene, materials));
        }
        let lacks = |primitive: &Primitive| {
            primitive.tangents.is_empty() && primitive.material.is_some_and(|material| found.contains(&material))
        };
        for mesh in scene.meshes.iter_mut().filter(|mesh| mesh.primitives.iter().any(lacks)) {
            for primitive in Arc::make_mut(mesh).primitives.iter_mut().filter(|primitive| lacks(primitive)) {
                add_tangents(primitive, uv_set);
            }
        }
        Ok(())
    }

    /// Makes materials show the scene's last image; `what` it is in messages, such as "the monitor `a`".
    ///
    /// # Errors
    /// The model has no material of that name, or it shows another such picture already.
    pub(super) fn show_last_image(
        &self,
        source: &Source,
        scene: &mut Scene,
        (what, sampler): (&str, Wrap),
        warnings: &mut Vec<String>,
    ) -> Result<(), Box<Diagnostic>> {
        let Some(materials) = &self.materials else { return Ok(()) };
        let sampler = Sampler { wrap_u: sampler, wrap_v: sampler, ..Sampler::default() };
        scene.textures.push(Texture { image: scene.images.len().saturating_sub(1), sampler });
        let texture = scene.textures.len() - 1;
        let pattern = &materials.value;
        // The pictures of that kind that textures show already.
        let of_kind = |image: usize| scene.images.get(image).filter(|image| image.is_drawn());
        let of_textures = scene.textures.iter().enumerate().filter(|(at, _)| *at != texture);
        let shown: BTreeMap<usize, String> =
            of_textures.filter_map(|(at, shown)| Some((at, kind_of(of_kind(shown.image)?)))).collect();
        let mut found = Vec::new();
        for (index, material) in
            scene.materials.iter_mut().enumerate().filter(|(_, known)| pattern.matches(&known.name))
        {
            found.push(index);
            let slot = if self.is_emission { &mut material.emissive_texture } else { &mut material.base_color_texture };
            let placed = slot.unwrap_or_default();
            if let Some(other) = slot.and_then(|slot| shown.get(&slot.texture)) {
                let message = format!("the material `{}` shows {other} already", material.name);
                return Err(source.fault(materials.range.clone(), message));
            }
            let uv_set = self.uv_set.unwrap_or(placed.uv_set);
            *slot = Some(TextureRef { texture, uv_set, ..placed });
            if let Some(luminance_cd_m2) = self.luminance_cd_m2 {
                material.emissive_factor = Vec3::splat(luminance_cd_m2);
            } else if self.is_emission && material.emissive_factor == Vec3::ZERO {
                material.emissive_factor = Vec3::ONE;
            }
        }
        if found.is_empty() {
            return Err(unknown_material(source, scene, materials));
        }
        if lacks_uvs(scene, &found, texture) {
            warnings.push(format!(
                "some surfaces of `{}` lack the UV set that {what} lies on: they show its first texel; give the model UVs",
                pattern.text()
            ));
        }
        let (least, most) = uv_range(scene, &found, texture);
        if least.min_element() < -UV_MARGIN || most.max_element() > 1.0 + UV_MARGIN {
            warnings.push(format!(
                "UVs of `{}` go from ({:.2}, {:.2}) to ({:.2}, {:.2}): {what} fills the square from 0 to 1, and beyond it \
                 its edge is repeated; give the model UVs from 0 to 1",
                pattern.text(),
                least.x,
                least.y,
                most.x,
                most.y
            ));
        }
        Ok(())
    }
}

fn unknown_material(source: &Source, scene: &Scene, named: &SpannedValue<Pattern>) -> Box<Diagnostic> {
    let name = named.value.text();
    let message = format!("the model has no material called `{name}`");
    let known = scene.materials.iter().map(|material| material.name.as_str());
    source.unknown(named.range.clone(), message, name, known)
}

fn kind_of(image: &Image) -> String {
    let kind = if image.monitor().is_some() { "monitor" } else { "simulation" };
    format!("the {kind} `{}`", image.name)
}

/// Of each primitive that has one of `materials`, the UVs on which the map lies that shows `texture`, and that map.
fn mapped<'s>(
    scene: &'s Scene,
    materials: &[usize],
    texture: usize,
) -> impl Iterator<Item = (&'s [[f32; 2]], TextureRef)> {
    let map_of = move |material: usize| {
        let material = scene.materials.get(material).filter(|_| materials.contains(&material))?;
        let maps = [material.emissive_texture, material.base_color_texture];
        maps.into_iter().flatten().find(|map| map.texture == texture)
    };
    scene.meshes.iter().flat_map(|mesh| &mesh.primitives).filter_map(move |primitive| {
        let map = primitive.material.and_then(map_of)?;
        let uvs = if map.uv_set == 0 { &primitive.uv0 } else { &primitive.uv1 };
        Some((&uvs[..], map))
    })
}

/// Whether surfaces of materials lack the UVs that their map lies on.
fn lacks_uvs(scene: &Scene, materials: &[usize], texture: usize) -> bool {
    mapped(scene, materials, texture).any(|(uvs, _)| uvs.is_empty())
}

/// The least and the greatest UVs at which surfaces of materials show their map; infinite where there are none.
fn uv_range(scene: &Scene, materials: &[usize], texture: usize) -> (Vec2, Vec2) {
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for (uvs, map) in mapped(scene, materials, texture) {
        let placement = map.transform.matrix();
        for uv in uvs {
            let uv = placement.transform_point2(Vec2::from(*uv));
            (least, most) = (least.min(uv), most.max(uv));
        }
    }
    (least, most)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use crate::stage::Stage;
    use crate::{Material, Mesh, Primitive, Scene, primitives};

    #[test]
    fn uvs_beyond_the_picture_are_told_once_with_their_numbers() {
        let warnings = |entry: &str, first: f32, size: f32| {
            let mut square = Primitive { material: Some(0), ..primitives::plane(2.0) };
            square.uv0.iter_mut().flatten().for_each(|uv| *uv = first + size * *uv);
            let mut scene = Scene::default();
            scene.materials.push(Material { name: "Screen".into(), ..Material::default() });
            for _ in 0..2 {
                scene.meshes.push(Mesh { primitives: vec![square.clone()], ..Mesh::default() }.into());
            }
            let text = format!("model = \"m.glb\"\n{entry}name = \"a\"\nmaterial = \"Screen\"\n");
            let stage = Stage::parse("a.stage.toml", &text).unwrap();
            stage.apply_with(&mut scene, &mut |name| Err(format!("no {name}"))).unwrap()
        };
        for (entry, what) in [
            ("[[monitors]]\nposition = [0, 2, 0]\ntarget = [0, 0, 0]\n", "the monitor `a`"),
            ("[[simulations]]\nprogram = \"fluid\"\n", "the simulation `a`"),
            ("[[simulations]]\nprogram = \"fluid\"\nnormal_picture = \"normals\"\n", "the simulation `a`"),
        ] {
            let found = warnings(entry, -0.5, 3.0);
            let expected = format!("UVs of `Screen` go from (-0.50, -0.50) to (2.50, 2.50): {what} fills the square");
            assert!(found.len() == 1 && found[0].starts_with(&expected), "{found:?}");
            // Not a hundredth of the picture is beyond it.
            assert_eq!((warnings(entry, 0.0, 1.0), warnings(entry, -0.005, 1.01)), (vec![], vec![]), "{what}");
        }
    }
}
