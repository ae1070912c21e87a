//! Surfaces of water: flat, with waves that are seen in what they reflect and refract, and not in their outline.
//!
//! ```
//! # use manypass_scene::water::{Clarity, Water};
//! # use manypass_scene::{Mesh, Node, Scene, primitives::plane};
//! # let mut scene = Scene::default();
//! scene.meshes.push(Mesh { primitives: vec![plane(20.0)], ..Mesh::default() }.into());
//! let node = scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), ..Node::default() });
//! scene.water.push(Water { wind_m_s: 3.0, ..Water::new("pond", node, Clarity::Murky) });
//! scene.time_secs = 2.5; // Waves go on with the scene's time.
//! ```

use crate::NodeId;
use crate::capture::LAYERS_ALL;
use glam::Vec3;

/// The most surfaces of water of a scene that are drawn.
pub const WATER_MAX: usize = 16;

/// The refractive index of water for yellow light at 20 °C.
pub const WATER_IOR: f32 = 1.333;

/// What water takes of light in a metre, by the wavelengths that stand for red, green and blue: 650, 550 and 450 nm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clarity {
    /// Pure water, and as few particles as in a swimming pool or far out at sea: of 10 m down, most is seen.
    Clear,
    /// A pond with algae and what leaves leave: the ground is gone after a metre.
    Murky,
}

impl Clarity {
    /// The words that name one.
    pub const NAMES: &'static [&'static str] = &["clear", "murky"];

    /// The one with a name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "clear" => Some(Self::Clear),
            "murky" => Some(Self::Murky),
            _ => None,
        }
    }

    /// The share of light that is absorbed, per metre.
    ///
    /// Sources: pure water of Pope & Fry 1997 ("Absorption spectrum (380–700 nm) of pure water"); dissolved organic matter
    /// falls by exp(−0.014 (λ − 440 nm)) from 1.2/m at 440 nm (Bricaud, Morel & Prieur 1981), and chlorophyll adds 0.2/m
    /// of red.
    pub fn absorption_per_m(self) -> Vec3 {
        let pure = Vec3::new(0.34, 0.0565, 0.0092);
        match self {
            Self::Clear => pure,
            Self::Murky => pure + Vec3::new(0.063 + 0.2, 0.257, 1.04),
        }
    }

    /// The share of light that is scattered, per metre, as if it went on to all sides alike: with the asymmetry g = 0.924
    /// of particles in natural water (Petzold 1972, in Mobley 1994, "Light and Water"), 0.076 of what they scatter.
    pub fn scattering_per_m(self) -> Vec3 {
        match self {
            // 0.04/m of particles, and of pure water 0.0005, 0.001 and 0.0024/m (Smith & Baker 1981).
            Self::Clear => Vec3::new(0.0035, 0.004, 0.0054),
            // 12/m of particles, the more the shorter the wave.
            Self::Murky => Vec3::new(0.84, 0.91, 0.99),
        }
    }
}

/// A surface of water.
///
/// It is as flat as the node's mesh, and as large as a rectangle around that; the mesh itself is not drawn. What rises out
/// of it hides it, so that shores need no outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    /// Its name: in the names of passes.
    pub name: String,
    /// The node whose mesh it fills: a flat one.
    pub node: NodeId,
    /// The share of light that is absorbed, per metre of the way through it; linear red, green and blue.
    pub absorption_per_m: Vec3,
    /// The share of light that is scattered, per metre, as if it went on to all sides alike.
    pub scattering_per_m: Vec3,
    /// Its refractive index.
    pub ior: f32,
    /// The wind that raises waves, in metres a second at a height of 12.5 m; 0 for a surface at rest. The mean square of
    /// slopes is 0.00512 times it (Cox & Munk 1954, "Measurement of the Roughness of the Sea Surface").
    pub wind_m_s: f32,
    /// Where the wind goes: an angle in radians, from the +X of the surface to its −Z (east to north of a lake that is
    /// seen from above).
    pub wind_rad: f32,
    /// How long the longest waves are, in metres.
    pub wave_m: f32,
    /// A normal map in place of the built-in waves, whose side is 4 times the longest waves: an index into
    /// [`crate::Scene::textures`]. Two of it move over each other.
    pub normal_map: Option<usize>,
    /// A simulation whose picture `waves` its waves are, in place of those of the wind, over the rectangle around the node:
    /// an index into [`crate::Scene::simulations`].
    pub simulation: Option<usize>,
    /// Where the water is as shallow as that, in metres, foam begins; 0 for none.
    pub foam_depth_m: f32,
    /// How strongly waves gather light on what lies below, from 0 (not at all) to 1 (all of the light comes from one
    /// direction).
    pub caustics: f32,
    /// Width and height of what is drawn for its reflection, as a share of those of the picture that shows it.
    pub scale: f32,
    /// The layers that it reflects ([`crate::Node::layers`]), a bit each.
    pub layers: u32,
    /// The tier of quality whose passes draw what it reflects; none for that of the picture that shows it.
    pub quality: Option<String>,
}

impl Water {
    /// Whether it has waves, which go by the scene's time.
    pub fn has_waves(&self) -> bool {
        self.wind_m_s > 0.0 || self.simulation.is_some()
    }

    /// At rest, without foam; what it reflects is as fine as the picture.
    pub fn new(name: impl Into<String>, node: NodeId, clarity: Clarity) -> Self {
        Self {
            name: name.into(),
            node,
            absorption_per_m: clarity.absorption_per_m(),
            scattering_per_m: clarity.scattering_per_m(),
            ior: WATER_IOR,
            wind_m_s: 0.0,
            wind_rad: 0.0,
            wave_m: 1.0,
            normal_map: None,
            simulation: None,
            foam_depth_m: 0.0,
            caustics: 0.0,
            scale: 1.0,
            layers: LAYERS_ALL,
            quality: None,
        }
    }
}
