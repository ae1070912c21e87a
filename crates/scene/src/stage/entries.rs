//! A stage that was read: its entries, and what they change of a scene.

use super::decals::DecalEntry;
use super::file_name::is_stage;
use super::keys::{
    DECALS, LIGHTS, MATERIALS, MIRRORS, MONITORS, NODES, OVERLAY, PARTICLES, PORTALS, PROBES, REFLECTION_PROBES,
    SETTINGS_TABLES, SIMULATIONS, StageTable, TABLES, WATER,
};
use super::light_files::LightFiles;
use super::lights::LightEntry;
use super::materials::{MaterialChange, StageImages};
use super::mirrors::MirrorEntry;
use super::monitors::MonitorEntry;
use super::names::Pattern;
use super::older::{self, value};
use super::overlay::OverlayEntry;
use super::particles::ParticlesEntry;
use super::portals::PortalEntry;
use super::probes::ProbesEntry;
use super::simulations::SimulationEntry;
use super::surroundings::SurroundingsEntry;
use super::table::{Source, SpannedValue, Table, document, tables};
use super::water::WaterEntry;
use super::{lights, monitors, overlay};
use crate::light::LIGHTS_MAX;
use crate::overlay::Overlay;
use crate::renamed::NameChange;
use crate::{Diagnostic, Scene};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// A stage file that was read; see the [module](super).
#[derive(Clone, Debug)]
pub struct Stage {
    pub(super) source: Source,
    model: SpannedValue<String>,
    pub(super) light_files: LightFiles,
    lights: Vec<LightEntry>,
    nodes: Vec<NodeChange>,
    materials: Vec<MaterialChange>,
    monitors: Vec<MonitorEntry>,
    mirrors: Vec<MirrorEntry>,
    simulations: Vec<SimulationEntry>,
    particles: Vec<ParticlesEntry>,
    decals: Vec<DecalEntry>,
    water: Vec<WaterEntry>,
    portals: Vec<PortalEntry>,
    surroundings: Vec<SurroundingsEntry>,
    probes: Vec<ProbesEntry>,
    overlay: Vec<OverlayEntry>,
    older_names: Vec<&'static NameChange>,
}

/// What is changed of nodes that have a name.
#[derive(Clone, Debug)]
struct NodeChange {
    names: SpannedValue<Pattern>,
    casts_shadow: Option<bool>,
    layers: Option<u32>,
}

impl Stage {
    /// Reads the `text` of a stage. `file` appears in errors.
    ///
    /// # Errors
    /// The text is not TOML, or a key or value is none of [`keys`](super::keys); with file, line and column.
    pub fn parse(file: &str, text: &str) -> Result<Self, Box<Diagnostic>> {
        let source = Source { file: file.into(), text: text.into() };
        let document = document(&source)?;
        let root = document.get_ref();
        let settings = SETTINGS_TABLES.map(|(name, _)| name);
        let lists = [
            LIGHTS.name,
            NODES.name,
            MATERIALS.name,
            MONITORS.name,
            MIRRORS.name,
            SIMULATIONS.name,
            PARTICLES.name,
            DECALS.name,
            WATER.name,
            PORTALS.name,
            REFLECTION_PROBES.name,
            PROBES.name,
            OVERLAY.name,
        ];
        let [beginning, ..] = &TABLES;
        // The whole text is no place for what is missing.
        let top = Table::read(&source, (root, 0..0), beginning, &[&lists[..], &settings[..]].concat())?;
        let model = checked_model(&source, top.text("model"))?;
        for name in settings {
            match value(root, name) {
                Some(value) if !matches!(value.get_ref(), DeValue::Table(_)) => {
                    let message = format!("`{name}` is a table of settings: write [{name}] above them");
                    return Err(source.fault(value.span(), message));
                }
                _ => {}
            }
        }
        let light_files = LightFiles::of(root);
        let lights = list(&source, root, &LIGHTS, LightEntry::read)?;
        let nodes = list(&source, root, &NODES, NodeChange::read)?;
        let materials = list(&source, root, &MATERIALS, MaterialChange::read)?;
        let monitors = list(&source, root, &MONITORS, MonitorEntry::read)?;
        monitors::check(&monitors, &source)?;
        let mirrors = list(&source, root, &MIRRORS, MirrorEntry::read)?;
        let simulations = list(&source, root, &SIMULATIONS, SimulationEntry::read)?;
        let particles = list(&source, root, &PARTICLES, ParticlesEntry::read)?;
        let decals = list(&source, root, &DECALS, DecalEntry::read)?;
        let water = list(&source, root, &WATER, WaterEntry::read)?;
        let portals = list(&source, root, &PORTALS, PortalEntry::read)?;
        let surroundings = list(&source, root, &REFLECTION_PROBES, SurroundingsEntry::read)?;
        let probes = list(&source, root, &PROBES, ProbesEntry::read)?;
        ProbesEntry::check(&probes, &source)?;
        let overlay = list(&source, root, &OVERLAY, OverlayEntry::read)?;
        let older_names = older::older_names(root, &model.value);
        Ok(Self {
            model,
            light_files,
            lights,
            nodes,
            materials,
            monitors,
            mirrors,
            simulations,
            particles,
            decals,
            water,
            portals,
            surroundings,
            probes,
            overlay,
            older_names,
            source,
        })
    }

    /// Whether it says where probes are.
    pub fn has_probes(&self) -> bool {
        !self.probes.is_empty()
    }

    /// The file, as [`Self::parse`] was told.
    pub fn file(&self) -> &str {
        &self.source.file
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.source.text
    }

    /// The older names that it uses of tables, of their keys and of a built-in scene: each once.
    pub fn older_names(&self) -> &[&'static NameChange] {
        &self.older_names
    }

    /// The model, as it is written: a path from the stage's folder, or `demo:NAME`.
    pub fn model(&self) -> &str {
        &self.model.value
    }

    /// The text with another model in it, written as [`Self::model`] is.
    pub fn text_with_model(&self, model: &str) -> String {
        let text = self.text();
        let (before, after) = (text.get(..self.model.range.start), text.get(self.model.range.end..));
        format!("{}{}{}", before.unwrap_or_default(), toml::Value::from(model), after.unwrap_or_default())
    }

    /// The picture of the environment, as it is written in `[environment]`: a path from the stage's folder.
    pub fn environment(&self) -> Option<&str> {
        self.light_files.picture.as_ref().map(|file| &*file.value)
    }

    /// Whether its environment names a picture, or files of its light.
    pub fn names_light(&self) -> bool {
        self.light_files.names().next().is_some()
    }

    /// The images that its materials, decals and water name, the sprites and fonts of its overlay, and the files of its
    /// simulations, and what its environment names beside the picture, as they are written: paths from the stage's
    /// folder. Each once.
    pub fn images(&self) -> Vec<&str> {
        let of_materials = self.materials.iter().flat_map(MaterialChange::images);
        let of_overlay = self.overlay.iter().flat_map(OverlayEntry::files);
        let of_water = self.water.iter().flat_map(WaterEntry::images);
        let of_decals = self.decals.iter().flat_map(DecalEntry::images);
        let mut names: Vec<&str> =
            of_materials.chain(of_water).chain(of_decals).chain(of_overlay).map(|name| name.value.as_str()).collect();
        names.extend(self.light_files.single_files());
        names.extend(self.simulations.iter().filter_map(SimulationEntry::file));
        names.extend(self.particles.iter().filter_map(ParticlesEntry::file));
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Where a file lies that the stage names, seen from where [`Self::file`] is.
    pub fn path_of(&self, name: &str) -> PathBuf {
        Path::new(self.file()).parent().unwrap_or(Path::new("")).join(name)
    }

    /// Changes the model's scene as [`Self::apply_with`] does, where materials get no images.
    ///
    /// # Errors
    /// As [`Self::apply_with`]; and if they do.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let mut none = |name: &str| Err(format!("`{name}` was not given with the stage"));
        self.apply_with(scene, &mut none).map(drop)
    }

    /// Changes the model's scene: what casts shadows, materials, lights, monitors, mirrors, simulations, particles, decals, water, portals,
    /// reflection probes, probes, what is drawn over it.
    /// Brings its transforms up to date. `resolve` gives images and fonts by the names of [`Self::images`]. Gives warnings.
    ///
    /// # Errors
    /// The model has no light, node, camera or material of a name, a mirror, water or an end of a portal is not flat, or an image or font cannot be read; the scene may be changed
    /// in part.
    pub fn apply_with(
        &self,
        scene: &mut Scene,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Vec<String>, Box<Diagnostic>> {
        let mut warnings = Vec::new();
        for change in &self.nodes {
            change.apply(&self.source, scene)?;
        }
        let others = self.water.iter().flat_map(WaterEntry::images);
        let others = others.chain(self.decals.iter().flat_map(DecalEntry::images));
        let images = StageImages::read(&self.source, self.materials.iter(), others, scene, resolve)?;
        for change in &self.materials {
            change.apply(&self.source, scene, &images, &mut warnings)?;
        }
        // New lights come with nodes, which are none of the model's.
        lights::apply(&self.lights, &self.source, scene)?;
        scene.lights_are_photometric = false;
        let over_picture: Vec<&str> = self.overlay.iter().filter_map(OverlayEntry::monitor).collect();
        for monitor in &self.monitors {
            monitor.apply(&self.source, scene, &over_picture, &mut warnings)?;
        }
        if !self.overlay.is_empty() {
            scene.overlay = overlay::overlay(&self.overlay, &self.source, scene, resolve)?.into();
        }
        scene.update_transforms();
        for mirror in &self.mirrors {
            mirror.apply(&self.source, scene)?;
        }
        for simulation in &self.simulations {
            simulation.apply(&self.source, scene, resolve, &mut warnings)?;
        }
        for particles in &self.particles {
            particles.apply(&self.source, scene, resolve)?;
        }
        for decal in &self.decals {
            decal.apply(&self.source, scene, &images)?;
        }
        for water in &self.water {
            water.apply(&self.source, scene, &images)?;
        }
        for portal in &self.portals {
            portal.apply(&self.source, scene)?;
        }
        for surroundings in &self.surroundings {
            surroundings.apply(&self.source, scene)?;
        }
        for probes in &self.probes {
            probes.apply(&self.source, scene)?;
        }
        warnings.extend(self.simulations.iter().filter_map(|simulation| simulation.unshown(scene)));
        Ok(warnings)
    }

    /// An error at the name of the model.
    pub(super) fn model_fault(&self, message: impl std::fmt::Display) -> Box<Diagnostic> {
        self.source.fault(self.model.range.clone(), message)
    }
}

/// The entries of a list of tables, if it is there.
fn list<T>(
    source: &Source,
    root: &DeTable<'_>,
    declared: &StageTable,
    read: impl Fn(&Table<'_>) -> Result<T, Box<Diagnostic>>,
) -> Result<Vec<T>, Box<Diagnostic>> {
    let Some(value) = older::list_of(root, declared.name) else { return Ok(Vec::new()) };
    let entries = tables(source, declared.name, value)?;
    if let Some((_, range)) = entries.get(LIGHTS_MAX as usize) {
        let message = format!("there are {} [[{}]], and {LIGHTS_MAX} are possible", entries.len(), declared.name);
        return Err(source.fault(range.clone(), message));
    }
    let of_entry = |entry: (&DeTable<'_>, Range<usize>)| read(&Table::read(source, entry, declared, &[])?);
    entries.into_iter().map(of_entry).collect()
}

/// Reads what is drawn over pictures of `scene` from a text that has tables `[[overlay]]` alone, as those of stages.
/// `file` appears in errors; `resolve` gives sprites and fonts by the names that the text gives them.
///
/// # Errors
/// The text is not TOML, a key or value is none of [`keys`](super::keys), a file cannot be read, or the scene has no node of a name;
/// with file, line and column.
///
/// ```
/// # use manypass_scene::{Scene, stage::read_overlay};
/// let text = "[[overlay]]\ntext = \"draft\"\nanchor = \"center\"\nsize_px = 40\nopacity = 0.5\n";
/// let overlay = read_overlay("labels.toml", text, &Scene::default(), &mut |name| Err(format!("no {name}")))?;
/// assert_eq!(overlay.items.len(), 1);
/// # Ok::<(), Box<manypass_scene::Diagnostic>>(())
/// ```
pub fn read_overlay(
    file: &str,
    text: &str,
    scene: &Scene,
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<Overlay, Box<Diagnostic>> {
    let source = Source { file: file.into(), text: text.into() };
    let document = document(&source)?;
    let root = document.get_ref();
    const TOP: StageTable = StageTable { name: "", doc: "", keys: &[] };
    Table::read(&source, (root, 0..0), &TOP, &[OVERLAY.name])?;
    let entries = list(&source, root, &OVERLAY, OverlayEntry::read)?;
    overlay::overlay(&entries, &source, scene, resolve)
}

/// The name of the model; a stage is none.
fn checked_model(
    source: &Source,
    model: Option<SpannedValue<String>>,
) -> Result<SpannedValue<String>, Box<Diagnostic>> {
    let model = model.ok_or_else(|| source.fault(0..0, "`model` is missing"))?;
    let name = &model.value;
    if name.trim().is_empty() {
        return Err(source.fault(model.range, "the name of the model is empty; name a file such as lamp.glb"));
    }
    if is_stage(std::path::Path::new(name)) {
        let message = format!("the model `{name}` is a stage, too; a stage names a model, such as a .glb file");
        return Err(source.fault(model.range, message));
    }
    Ok(model)
}

impl NodeChange {
    fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let name = table.text("name").ok_or_else(|| table.fault("name", "`name` is missing"))?;
        let names = SpannedValue { value: Pattern::new(&name.value), range: name.range };
        Ok(Self { names, casts_shadow: table.boolean("cast_shadow"), layers: table.layers("layers") })
    }

    fn apply(&self, source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let pattern = &self.names.value;
        let mut is_found = false;
        for node in scene.nodes.iter_mut().filter(|node| pattern.matches(&node.name)) {
            is_found = true;
            node.casts_shadow = self.casts_shadow.unwrap_or(node.casts_shadow);
            node.layers = self.layers.unwrap_or(node.layers);
        }
        if is_found {
            return Ok(());
        }
        let message = format!("the model has no node called `{}`", pattern.text());
        let known = scene.nodes.iter().map(|node| node.name.as_str());
        Err(source.unknown(self.names.range.clone(), message, pattern.text(), known))
    }
}
