//! What tells the pipelines of one pass apart: the shape of a draw, and the programs that draw special materials.

use crate::constants::{LAYER_LIGHT_MAP, LAYER_STEPS, LAYER_TRANSMISSION};
use crate::draws::{AXES, Axes, DEFORMED, Draw, Faces, Item, MASKED, NORMAL_MAP, PLACES_UVS, TEXTURED};
use crate::resources::layers::{BENDS, CAST_RELIEF, DETAIL, RELIEF};
use crate::shader::compose;
use manypass_scene::Topology;

/// What tells the pipelines of one pass apart, as a number below [`Shape::COUNT`].
pub(super) struct Shape {
    pub axes: Axes,
    pub topology: Topology,
    pub faces: Faces,
    pub mirrored: bool,
    /// The bits of layers, if the program is another one where a material has some.
    pub layers: u32,
    /// How baked light is read, as `directed_light` of `layer_maps.wgsl` says it. Only of what has layers.
    pub directed_light: u32,
    /// Whether two levels fade into each other.
    pub fades: bool,
    /// Whether decals are shown on it.
    pub is_decaled: bool,
}

/// The programs that draw special materials in place of a pass's own.
#[derive(Clone, Copy)]
pub(super) struct SpecialPrograms {
    layered: Option<&'static str>,
    detailed: Option<&'static str>,
    relief: Option<&'static str>,
}

impl SpecialPrograms {
    pub fn of(program: &str) -> Self {
        let (layered, detailed) = (compose::layered_of(program), compose::detailed_of(program));
        Self { layered, detailed, relief: compose::relief_of(program) }
    }

    /// The bits of `layers` that matter to a pass: none if its own program draws the material.
    pub fn bits(self, layers: u32, casts: bool) -> u32 {
        // What light comes through has no relief.
        let layers = if layers & LAYER_TRANSMISSION != 0 { layers & !RELIEF } else { layers };
        let has_relief = self.relief.is_some() && layers & RELIEF != 0;
        if casts {
            // A single shift moves nothing.
            return if has_relief && layers & LAYER_STEPS != 0 { layers & CAST_RELIEF } else { 0 };
        }
        match self {
            Self { layered: Some(_), .. } => layers,
            Self { detailed: Some(_), .. } => layers & DETAIL,
            _ if has_relief => layers & DETAIL,
            _ => 0,
        }
    }

    /// The program for a material with the bits that [`Self::bits`] gave.
    pub fn program(self, bits: u32) -> Option<&'static str> {
        let with_relief = self.relief.filter(|_| bits & RELIEF != 0);
        with_relief.or(self.layered).or(self.detailed).filter(|_| bits != 0)
    }
}

impl Shape {
    pub const COUNT: usize = (1 << AXES.len()) * 3 * 3 * 2 * 2 * 2;

    /// Of what keeps light from others: all that it needs is whether fragments are dropped, and moved vertices. A
    /// surface with one side is there for light as it is for the eye: where it shows its front.
    pub fn of_caster(item: &Item, faces: Faces, is_blended: bool, layers: u32) -> Self {
        // Fragments of relief are shaded for their depth.
        let is_tested = item.masked || is_blended || layers != 0;
        let tested = if is_tested { (item.axes & (TEXTURED | PLACES_UVS)) | MASKED } else { 0 };
        let axes = tested | item.axes & DEFORMED;
        Self {
            axes,
            topology: item.topology,
            faces,
            mirrored: item.mirrored,
            layers,
            directed_light: 0,
            fades: false,
            is_decaled: false,
        }
    }

    pub fn of(item: &Item, draw: &Draw, is_reflected: bool, layers: u32, tests_alpha: bool) -> Self {
        // Discs face the eye however their object is mirrored.
        let mirrored = (item.mirrored && item.topology != Topology::Points) != is_reflected;
        let Draw { faces, fades, form, is_decaled, .. } = *draw;
        let axes = item.axes_in(form.surface) | if tests_alpha { MASKED } else { 0 };
        let bends = axes & NORMAL_MAP != 0 || layers & BENDS != 0 || is_decaled;
        let directed_light = match item.has_light_directions && layers & LAYER_LIGHT_MAP != 0 {
            true => 1 + u32::from(bends),
            false => 0,
        };
        Self { axes, topology: item.topology, faces, mirrored, layers, directed_light, fades, is_decaled }
    }

    pub fn index(&self) -> usize {
        let topology = match self.topology {
            Topology::Points => 0,
            Topology::Lines => 1,
            Topology::Triangles => 2,
        };
        let faces = match self.faces {
            Faces::Both => 0,
            Faces::Front => 1,
            Faces::Back => 2,
        };
        let flags = [self.mirrored, self.fades, self.is_decaled];
        let shape = (self.axes as usize * 3 + topology) * 3 + faces;
        flags.into_iter().fold(shape, |index, flag| index * 2 + usize::from(flag))
    }
}
