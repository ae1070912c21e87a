//! Material variants of a file: other materials for the same surfaces (`KHR_materials_variants`).

use crate::{Primitive, Scene};

impl Scene {
    /// The index in [`Scene::variants`] of the variant with this name, or else with this index.
    pub fn variant_named(&self, name_or_index: &str) -> Option<usize> {
        let by_name = self.variants.iter().position(|name| name == name_or_index);
        by_name.or_else(|| name_or_index.parse().ok().filter(|index| *index < self.variants.len()))
    }
}

/// The index of a material in a variant: that which `of_variants`, pairs of a variant and a material, has for it, else
/// `own`.
pub fn material_in(own: Option<usize>, of_variants: &[(usize, usize)], variant: Option<usize>) -> Option<usize> {
    let of_variant = |variant| of_variants.iter().find(|(of, _)| *of == variant);
    variant.and_then(of_variant).map_or(own, |(_, material)| Some(*material))
}

impl Primitive {
    /// The index of its material in a variant; without one, or where the variant says nothing of it, its own.
    pub fn material_in(&self, variant: Option<usize>) -> Option<usize> {
        material_in(self.material, &self.variant_materials, variant)
    }
}
