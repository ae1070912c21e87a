//! Water of a stage.

use super::materials::StageImages;
use super::surfaces::{LYING, Surface, nodes_called};
use super::table::{Source, SpannedValue, Table};
use crate::capture::LAYERS_ALL;
use crate::water::{Clarity, WATER_IOR, WATER_MAX, Water};
use crate::{Diagnostic, Material, NodeId, Scene, Wrap};
use glam::Vec3;

/// Keys that name an image.
pub(super) const IMAGES: [&str; 1] = ["normal_map"];

/// The wind where nobody says: a light breeze.
const WIND_M_S: f32 = 2.0;

/// The share of what is drawn for reflections in waves where nobody says: waves hide what is finer.
const SCALE_OF_WAVES: f32 = 0.5;

/// The least height of the unit normal of a surface that lies.
const LYING_MIN: f32 = 0.5;

/// An entry of `[[water]]`.
#[derive(Clone, Debug)]
pub(super) struct WaterEntry {
    surface: Surface,
    name: Option<String>,
    /// Without a node, and with the name of the entry.
    water: Water,
    normal_map: Option<SpannedValue<String>>,
    simulation: Option<SpannedValue<String>>,
}

impl WaterEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let surface = Surface::read(table, "water", LYING)?;
        let clarity = table.text("clarity").and_then(|word| Clarity::named(&word.value)).unwrap_or(Clarity::Clear);
        let name = table.text("name").map(|name| name.value).filter(|name| !name.trim().is_empty());
        let plain = Water::new("water", NodeId(0), clarity);
        let wind_m_s = table.number("wind_m_s").unwrap_or(WIND_M_S);
        let color =
            |key: &str, other: Vec3| match table.vector(key) {
                Some(color) if color.min_element() < 0.0 => Err(table
                    .fault(key, format!("`{key}` is a share of light that is lost in a metre: no number is below 0"))),
                color => Ok(color.unwrap_or(other)),
            };
        let water = Water {
            absorption_per_m: color("absorption_per_m", plain.absorption_per_m)?,
            scattering_per_m: color("scattering_per_m", plain.scattering_per_m)?,
            ior: table.number("ior").unwrap_or(WATER_IOR),
            wind_m_s,
            wind_rad: table.number("wind_deg").unwrap_or(0.0).to_radians(),
            wave_m: table.number("wave_m").unwrap_or(plain.wave_m),
            foam_depth_m: table.number("foam_depth_m").unwrap_or(0.0),
            caustics: table.number("caustics").unwrap_or(0.0),
            scale: table.number("scale").unwrap_or(if wind_m_s > 0.0 { SCALE_OF_WAVES } else { 1.0 }),
            layers: table.layers("layers").unwrap_or(LAYERS_ALL),
            quality: table.text("quality").map(|word| word.value),
            ..plain
        };
        let (normal_map, simulation) = (table.text("normal_map"), table.text("simulation"));
        if simulation.is_some()
            && let Some(key) = ["normal_map", "wind_m_s"].into_iter().find(|key| table.place(key).is_some())
        {
            return Err(table.fault(key, format!("the waves are those of `simulation`; leave out `{key}`, or that")));
        }
        Ok(Self { surface, name, water, normal_map, simulation })
    }

    /// The image that it names.
    pub(super) fn images(&self) -> impl Iterator<Item = &SpannedValue<String>> {
        self.normal_map.iter()
    }

    /// Fills its surfaces with water. Transforms are up to date.
    ///
    /// # Errors
    /// The model has no node of that name, it is not flat, or there are too many.
    pub(super) fn apply(
        &self,
        source: &Source,
        scene: &mut Scene,
        images: &StageImages,
    ) -> Result<(), Box<Diagnostic>> {
        let normal_map = self.normal_map.as_ref().map(|image| images.texture(scene, image, Wrap::Repeat));
        let simulation = self.simulation.as_ref().map(|name| {
            let is_it = |known: &crate::simulation::Simulation| known.name == name.value;
            scene.simulations.iter().position(is_it).ok_or_else(|| {
                let message = format!("there is no simulation called `{}`; [[simulations]] lists them", name.value);
                let known = scene.simulations.iter().map(|known| known.name.as_str());
                source.unknown(name.range.clone(), message, &name.value, known)
            })
        });
        let simulation = simulation.transpose()?;
        let (found, range) = match &self.surface {
            Surface::Nodes(nodes) => (nodes_called(nodes, source, scene)?, &nodes.range),
            Surface::New(rectangle) => {
                let name = self.name.as_deref().unwrap_or("water");
                let material = Material { name: "water".into(), ..Material::default() };
                (vec![rectangle.put(scene, name, material)], &rectangle.range)
            }
        };
        for id in found {
            let node = scene.node(id).name.clone();
            let fault = |message: String| Err(source.fault(range.clone(), message));
            if scene.water.iter().any(|water| water.node == id) {
                return fault(format!("the node `{node}` is water already"));
            }
            if scene.mirrors.iter().any(|mirror| mirror.node == id) {
                return fault(format!("the node `{node}` is a mirror; it cannot be water, too"));
            }
            if let Err(what) = scene.panel(id) {
                return fault(format!("a surface of water is flat, and the node `{node}` {what}"));
            }
            if scene.panel(id).is_ok_and(|panel| panel.normal_world.y.abs() < LYING_MIN) {
                return fault(format!("a surface of water lies, and the node `{node}` stands"));
            }
            if simulation.is_some() && scene.water.iter().any(|water| water.simulation == simulation) {
                return fault("a simulation has the waves of one surface of water alone".into());
            }
            let place = simulation.and_then(|index| scene.simulations.get(index)?.place);
            if place.is_some_and(|place| place != id) {
                return fault(format!("the simulation lies over another node than `{node}`; leave out its `over`"));
            }
            if scene.water.len() == WATER_MAX {
                return fault(format!("there are more surfaces of water than {WATER_MAX}"));
            }
            let name = self.name.clone().unwrap_or(node);
            scene.water.push(Water { name, node: id, normal_map, simulation, ..self.water.clone() });
        }
        Ok(())
    }
}
