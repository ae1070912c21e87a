//! Decals: the table of their boxes and looks. `resources/decal_atlas.rs` has the texture of their images,
//! `lights/decals.rs` the list of those in every cluster, `draws/decals.rs` the surfaces that they may touch.
//!
//! Surfaces look decals up where they are evaluated, in the G-buffer's pass and where they are shaded as they are drawn
//! alike (`shaders/decals.wgsl`), rather than that boxes are drawn over the G-buffer: every path shows the same, each
//! part has an opacity of its own on devices that cannot blend targets differently, and the surface's own normal and
//! layers are at hand. Records and entries of their lists lie in the textures of those of lights, because a stage on
//! WebGL 2 has no textures to spare; so do their images, beside the table of directional albedo.
//!
//! Source: clustered decals (Sousa & Geffroy 2016, "The devil is in the details: idTech 666").

use crate::constants::{
    DECAL_COLOR_IMAGES, DECAL_EMISSION, DECAL_EMISSION_IMAGES, DECAL_LAYERS, DECAL_NORMALS, DECAL_ROUGHNESS,
    DECAL_ROUGHNESS_IMAGES, DECAL_TEXELS, DECALS_SHOWN,
};
use crate::resources::{DecalAtlas, ImageUse};
use glam::{Mat4, Vec3, Vec4};
use manypass_scene::Scene;
use manypass_scene::capture::LAYERS_ALL;
use manypass_scene::decal::{DECALS_MAX, Decal, DecalLook};
use std::sync::Arc;

/// The `override` constant that says what decals there are, by the bits of `constants.rs`.
pub(crate) const DECALS: &str = "decals";

/// The layers of so many nodes are looked up at most.
const LAYERED_NODES_MAX: usize = 1 << 19;

/// The decals of a frame, in the order in which they lie over each other.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct DecalTable {
    /// [`DECAL_TEXELS`] each.
    pub texels: Vec<[f32; 4]>,
    /// `world_from_box` of each.
    pub boxes: Vec<Mat4>,
    /// The layers of nodes by object id, two of them a texel: low and high halves. Empty where no decal asks.
    pub layers: Vec<[f32; 4]>,
    /// What there is of them, by the bits of `constants.rs`.
    pub parts: u32,
}

impl DecalTable {
    /// Those of a scene, whose images lie in `atlas`.
    pub fn new(scene: &Scene, atlas: &DecalAtlas) -> Self {
        let mut shown: Vec<(&Decal, Mat4)> = scene
            .shown_decals()
            .into_iter()
            .take(DECALS_MAX)
            .filter_map(|(index, world_from_box)| Some((scene.decals.get(index)?, world_from_box)))
            // Without its shape it would be a rectangle.
            .filter(|(decal, _)| {
                decal.look.color_image.is_none_or(|image| atlas.place(image, ImageUse::Color).is_some())
            })
            .collect();
        // Of equal order those that come first stay first.
        shown.sort_by_key(|(decal, _)| decal.order);
        let mut table = Self::default();
        let asks = |(decal, _): &(&Decal, Mat4)| decal.layers != LAYERS_ALL;
        if shown.iter().any(asks) && scene.nodes.len() < LAYERED_NODES_MAX {
            table.layers = layers_of_nodes(scene);
            table.parts |= DECAL_LAYERS;
        }
        for (decal, world_from_box) in shown {
            table.parts |= DECALS_SHOWN | parts_of(&decal.look);
            table.texels.extend(texels(decal, &world_from_box, atlas));
            table.boxes.push(world_from_box);
        }
        table
    }
}

/// What is wrong with decals of a scene.
pub(crate) fn faults(scene: &Scene) -> Vec<String> {
    let flat = scene.decals.iter().filter(|decal| Decal::is_flat(&decal.parent_from_box));
    let mut faults: Vec<String> = flat
        .take(8)
        .map(|decal| format!("the decal `{}` is left out: its box has no volume, or too large a one", decal.name))
        .collect();
    if scene.decals.len() > DECALS_MAX {
        faults.push(format!(
            "there are {} decals; only the first {DECALS_MAX} that are shown are drawn",
            scene.decals.len()
        ));
    }
    if scene.nodes.len() >= LAYERED_NODES_MAX && scene.decals.iter().any(|decal| decal.layers != LAYERS_ALL) {
        faults.push(format!(
            "decals are on all layers: the layers of at most {LAYERED_NODES_MAX} nodes can be looked up"
        ));
    }
    faults
}

fn layers_of_nodes(scene: &Scene) -> Vec<[f32; 4]> {
    // The object id of a node is its index, plus 1.
    let halves = |layers: u32| [(layers & 0xffff) as f32, (layers >> 16) as f32];
    let mut of_ids = std::iter::once(0).chain(scene.nodes.iter().map(|node| node.layers)).map(halves);
    let pair = || {
        let first = of_ids.next()?;
        let second = of_ids.next().unwrap_or_default();
        Some([first[0], first[1], second[0], second[1]])
    };
    std::iter::from_fn(pair).collect()
}

fn parts_of(look: &DecalLook) -> u32 {
    let opacity = &look.opacity;
    let parts = [
        (look.color_image.is_some(), DECAL_COLOR_IMAGES),
        (look.normal_image.is_some() && opacity.normal > 0.0, DECAL_NORMALS),
        (opacity.roughness > 0.0, DECAL_ROUGHNESS),
        (look.rough_metal_image.is_some(), DECAL_ROUGHNESS_IMAGES),
        (opacity.emission > 0.0, DECAL_EMISSION),
        (look.emission_image.is_some() && opacity.emission > 0.0, DECAL_EMISSION_IMAGES),
    ];
    parts.into_iter().filter(|(is_there, _)| *is_there).map(|(_, part)| part).sum()
}

fn texels(decal: &Decal, world_from_box: &Mat4, atlas: &DecalAtlas) -> [[f32; 4]; DECAL_TEXELS as usize] {
    let look = &*decal.look;
    let box_from_world = world_from_box.inverse();
    let row = |at: usize| box_from_world.row(at).to_array();
    let place = |image: Option<usize>, of: ImageUse| {
        image.and_then(|image| atlas.place(image, of)).map_or([0.0; 4], |place| place.map(|texels| texels as f32))
    };
    let unit = |value: f32| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
    let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
    let [begin, end] = decal.angle_rad.to_array().map(|angle| finite(angle).clamp(0.0, std::f32::consts::PI));
    // From an angle of 180° on there is nothing to fade to.
    let cos_end = if end >= std::f32::consts::PI { -2.0 } else { end.cos() };
    let share_a_cosine = 1.0 / (begin.min(end).cos() - cos_end).max(1e-3);
    let color = look.color.map(|value| finite(value).clamp(0.0, 1.0));
    let emission = look.emission.map(|value| finite(value).max(0.0));
    // Without an image nothing bends normals.
    let normal = if look.normal_image.is_some() { unit(look.opacity.normal) } else { 0.0 };
    let layers = decal.layers;
    let mut texels = [[0.0; 4]; DECAL_TEXELS as usize];
    texels[..11].copy_from_slice(&[
        row(0),
        row(1),
        row(2),
        [cos_end, share_a_cosine, (layers & 0xffff) as f32, (layers >> 16) as f32],
        color.extend(unit(look.opacity.color)).to_array(),
        place(look.color_image, ImageUse::Color),
        Vec4::new(unit(look.metallic), unit(look.roughness), unit(look.opacity.roughness), normal).to_array(),
        place(look.normal_image, ImageUse::Data),
        emission.extend(unit(look.opacity.emission)).to_array(),
        place(look.emission_image, ImageUse::Color),
        place(look.rough_metal_image, ImageUse::Data),
    ]);
    texels[11] = [finite(look.normal_scale), 0.0, 0.0, 0.0];
    texels[15] = world_from_box.z_axis.truncate().normalize_or_zero().extend(0.0).to_array();
    for (row, texel) in texels[12..15].iter_mut().enumerate() {
        *texel = world_from_box.row(row).to_array();
    }
    texels
}

/// The corners of a box whose sides are 1, of which the bits of their numbers say on which side of each axis they lie.
pub(crate) fn corners_of_box() -> [Vec3; 8] {
    std::array::from_fn(|corner| {
        let side = |bit: usize| if corner >> bit & 1 == 1 { 0.5 } else { -0.5 };
        Vec3::new(side(0), side(1), side(2))
    })
}

/// The decals of a frame, compared by their place in memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct SharedDecals(pub Arc<DecalTable>);

impl PartialEq for SharedDecals {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
