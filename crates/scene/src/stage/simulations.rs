//! Simulations of a stage.

use super::cameras::camera_called;
use super::names::Pattern;
use super::screens::Screen;
use super::surfaces::nodes_called;
use super::table::{Source, SpannedValue, Table, whole};
use crate::capture::LAYERS_ALL;
use crate::simulation::{BODIES_MAX, CELLS_SIDE_MAX, Program, SIMULATIONS_MAX, Simulation};
use crate::{Diagnostic, Image, NodeId, Scene, Wrap};
use std::ops::Range;

/// The picture that materials show where nobody says.
const PICTURE: &str = "color";

/// An entry of `[[simulations]]`.
#[derive(Clone, Debug)]
pub(super) struct SimulationEntry {
    name: SpannedValue<String>,
    file: SpannedValue<String>,
    /// Without its program, nodes and what chance begins with.
    simulation: Simulation,
    over: Option<SpannedValue<Pattern>>,
    bodies: Vec<SpannedValue<Pattern>>,
    walls: Vec<SpannedValue<Pattern>>,
    picture: String,
    normal_picture: Option<String>,
    sees: Option<SpannedValue<String>>,
    screen: Screen,
    range: Range<usize>,
}

/// Whether a program is a file, and not one that is built in.
pub(super) fn is_file(name: &str) -> bool {
    name.to_ascii_lowercase().ends_with(".wgsl")
}

/// The program of a file that a stage names; `text_of` gives files by their names.
///
/// # Errors
/// It cannot be read, or is no text.
pub(super) fn program_of(
    source: &Source,
    file: &SpannedValue<String>,
    text_of: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<Program, Box<Diagnostic>> {
    let fault = |message: String| source.fault(file.range.clone(), message);
    let bytes = text_of(&file.value).map_err(fault)?;
    let text = String::from_utf8(bytes).map_err(|_| fault(format!("`{}` is not UTF-8 text", file.value)))?;
    let folder = std::path::Path::new(&source.file).parent().unwrap_or(std::path::Path::new(""));
    Ok(Program::Text { file: folder.join(&file.value).display().to_string(), text: text.into() })
}

impl SimulationEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let missing = |key: &str| table.fault(key, format!("`{key}` is empty"));
        let text = |key: &str| table.text(key).filter(|text| !text.value.trim().is_empty());
        let (name, file) =
            (text("name").ok_or_else(|| missing("name"))?, text("program").ok_or_else(|| missing("program"))?);
        let cells = match table.pair("cells") {
            None => None,
            Some(cells) => {
                let is_side = |side: f32| side.fract() == 0.0 && (1.0..=CELLS_SIDE_MAX as f32).contains(&side);
                if !is_side(cells.x) || !is_side(cells.y) {
                    let message = format!("`cells` is a width and a height, whole numbers from 1 to {CELLS_SIDE_MAX}");
                    return Err(table.fault("cells", message));
                }
                Some((cells.x as u32, cells.y as u32))
            }
        };
        let seed = table.number("seed").map(|seed| whole(table, "seed", seed)).transpose()?;
        let names = |key: &str| -> Vec<SpannedValue<Pattern>> {
            let texts = table.texts(key).unwrap_or_default();
            texts
                .iter()
                .map(|name| SpannedValue { value: Pattern::new(&name.value), range: name.range.clone() })
                .collect()
        };
        let screen = Screen::read(table)?;
        if let Some(picture) = text("picture").filter(|_| !screen.has_materials()) {
            return Err(table.source.fault(picture.range, "`picture` is what materials show, and needs `material`"));
        }
        if let Some(picture) = text("normal_picture").filter(|_| !screen.has_materials()) {
            let message = "`normal_picture` is what bends normals of materials, and needs `material`";
            return Err(table.source.fault(picture.range, message));
        }
        let simulation = Simulation {
            cells,
            rate_hz: table.number("rate_hz"),
            seed: seed.unwrap_or(0),
            parameters: table.values("parameters").unwrap_or_default().to_vec(),
            layers: table.layers("layers").unwrap_or(LAYERS_ALL),
            ..Simulation::built_in(name.value.clone(), &file.value)
        };
        Ok(Self {
            simulation,
            over: table.text("over").map(|name| SpannedValue { value: Pattern::new(&name.value), range: name.range }),
            bodies: names("bodies"),
            walls: names("walls"),
            picture: text("picture").map_or_else(|| PICTURE.into(), |picture| picture.value),
            normal_picture: text("normal_picture").map(|picture| picture.value),
            sees: table.text("sees"),
            screen,
            range: table.range.clone(),
            name,
            file,
        })
    }

    /// The file that it names.
    pub(super) fn file(&self) -> Option<&str> {
        Some(self.file.value.as_str()).filter(|file| is_file(file))
    }

    /// Adds it to the scene, and shows it where it says; `text_of` gives files by their names. Transforms are up to date.
    ///
    /// # Errors
    /// The model has no node or material of a name, a place is not flat, the file cannot be read, or there are too many.
    pub(super) fn apply(
        &self,
        source: &Source,
        scene: &mut Scene,
        text_of: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
        warnings: &mut Vec<String>,
    ) -> Result<(), Box<Diagnostic>> {
        let name = &self.name.value;
        if scene.simulations.iter().any(|known| known.name == *name) {
            return Err(source.fault(self.name.range.clone(), format!("two simulations are called `{name}`")));
        }
        if scene.simulations.len() == SIMULATIONS_MAX {
            let message = format!("there are more simulations than {SIMULATIONS_MAX}");
            return Err(source.fault(self.range.clone(), message));
        }
        let mut simulation = self.simulation.clone();
        if self.file().is_some() {
            simulation.program = program_of(source, &self.file, text_of)?;
        }
        let all = |names: &[SpannedValue<Pattern>], scene: &Scene| -> Result<Vec<NodeId>, Box<Diagnostic>> {
            let found: Vec<_> = names.iter().map(|name| nodes_called(name, source, scene)).collect::<Result<_, _>>()?;
            Ok(found.concat())
        };
        (simulation.bodies, simulation.walls) = (all(&self.bodies, scene)?, all(&self.walls, scene)?);
        if simulation.bodies.len() + simulation.walls.len() > BODIES_MAX {
            let message =
                format!("the simulation `{name}` has more bodies and walls than {BODIES_MAX}: name fewer nodes");
            return Err(source.fault(self.range.clone(), message));
        }
        if let Some(over) = &self.over {
            let found = nodes_called(over, source, scene)?;
            let place = found.first().copied().unwrap_or(NodeId(u32::MAX));
            if let Err(what) = scene.panel(place) {
                let node = over.value.text();
                let message = format!("a simulation lies over a flat surface, and the node `{node}` {what}");
                return Err(source.fault(over.range.clone(), message));
            }
            simulation.place = Some(place);
        }
        if let Some(sees) = &self.sees {
            simulation.sees = Some(camera_called(source, scene, sees)?);
        }
        scene.simulations.push(simulation);
        if let Some(picture) = &self.normal_picture {
            scene.images.push(Image::of_simulation(name, scene.simulations.len() - 1, picture));
            self.screen.bend_normals_by_last_image(source, scene)?;
        }
        if self.screen.has_materials() {
            let image = Image::of_simulation(name, scene.simulations.len() - 1, &self.picture);
            scene.images.push(image);
            let what = format!("the simulation `{name}`");
            self.screen.show_last_image(source, scene, (&what, Wrap::ClampToEdge), warnings)?;
        }
        Ok(())
    }

    /// Says of a simulation that nothing shows it.
    pub(super) fn unshown(&self, scene: &Scene) -> Option<String> {
        let name = &self.name.value;
        let index = scene.simulations.iter().position(|known| known.name == *name)?;
        let in_water = scene.water.iter().any(|water| water.simulation == Some(index));
        (!self.screen.has_materials() && !in_water).then(|| {
            format!(
                "nothing shows the simulation `{name}`: give it `material`, or [[water]] with simulation = \"{name}\""
            )
        })
    }
}
