//! What a frame draws: the world's instances once, and for every view which of them it may show.

mod ball;
mod clouds;
mod decals;
mod extent;
mod fading;
mod glass;
mod leveled;
mod list;
mod posed_primitive;
mod rectangle;
mod still;
mod unsettled;
mod world;

pub(crate) use clouds::VisibleClouds;
pub(crate) use decals::DecalDraws;
pub(crate) use fading::{FADES, faded_id};
pub(crate) use glass::layers_of_glass;
pub(crate) use leveled::Form;
pub(crate) use list::{Draw, DrawList, may_show};
pub(crate) use still::ListOf;
pub(crate) use unsettled::UnsettledTiles;
pub(crate) use world::{BLOCK_ITEMS, Item, WorldDraws, object_id};

/// What draws of surfaces differ in that their programs have to know: `override` constants of shaders. A set of them is
/// a number with their bits.
pub(crate) const AXES: [&str; 6] = ["textured", "occlusion_apart", "normal_map", "masked", "deformed", "places_uvs"];

/// Axes of programs that bind less where none of some of [`AXES`] is on.
pub(crate) const BINDING_AXES: [(&str, Axes); 3] =
    [("textures", TEXTURED | OCCLUSION_APART | NORMAL_MAP), ("masks", MASKED), ("skins", DEFORMED)];

/// A set of [`AXES`].
pub(crate) type Axes = u32;

/// The axis of materials that are textured.
pub(crate) const TEXTURED: Axes = 1;
/// The axis of materials whose occlusion has a texture of its own.
pub(crate) const OCCLUSION_APART: Axes = 1 << 1;
/// The axis of materials with a normal map.
pub(crate) const NORMAL_MAP: Axes = 1 << 2;
/// The axis of materials that drop fragments.
pub(crate) const MASKED: Axes = 1 << 3;
/// The axis of surfaces that skins or morph targets move.
pub(crate) const DEFORMED: Axes = 1 << 4;
/// The axis of materials with a texture that lies otherwise than the first UVs say.
pub(crate) const PLACES_UVS: Axes = 1 << 5;

/// A part of a texture that shows the world on its own.
#[derive(Debug)]
pub struct Tile {
    /// X and y of its corner, width and height, in texels.
    pub rectangle: [u32; 4],
    /// What is drawn there.
    pub(crate) draws: Vec<Draw>,
}

/// Which sides of triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Faces {
    /// Both, in the order of the indices.
    Both,
    /// Those that turn their front to the eye.
    Front,
    /// Those that turn their back to the eye.
    Back,
}
