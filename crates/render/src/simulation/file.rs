//! A simulation as its file has it, before a device compiles it.

use super::header::{Edges, Header, Pass};
use crate::diagnostic::Diagnostic;
use crate::settings::{SettingInfo, SettingValue, SettingsError};
use crate::shader::locate;
use crate::shader::program::{ProgramError, Slot};
use crate::shader::reflection::reflect_bindings_of;
use crate::user_shader::Source;
use crate::user_shader::checks::{check_functions, fault_of_bool};
use crate::user_shader::rounds::check_rounds;
use crate::user_shader::scan::{Scan, scan};
use crate::user_shader::uniforms::{OWN_GROUP, Uniforms};
use std::collections::BTreeSet;
use std::fmt::Write;

/// What every simulation finds declared.
const PRELUDE: &str = include_str!("prelude.wgsl");
/// What those find declared that read surfaces.
const SURFACES: &str = include_str!("surfaces.wgsl");
/// The first binding of states.
const FIRST_STATE: u32 = 10;
/// A simulation has at most so many states.
const STATES_MAX: usize = 8;

/// What entry points are called: this and the name of the function.
pub(super) const ENTRY: &str = "fs_of_";

/// The text of a simulation, checked without a device: its states, its steps, its pictures and its parameters.
///
/// ```
/// # use manypass::SimulationFile;
/// let text = "
///     //! step: spread -> heat
///     //! start: spot -> heat
///     //! shows: color
///
///     fn spot(cell: vec2i) -> vec4f {
///         return vec4f(select(0.0, 1.0, distance(metres_at(cell), vec2f(0.0)) < 0.1));
///     }
///
///     fn spread(cell: vec2i) -> vec4f {
///         let around = heat_at(cell + vec2i(1, 0)) + heat_at(cell - vec2i(1, 0));
///         return 0.25 * (around + heat_at(cell + vec2i(0, 1)) + heat_at(cell - vec2i(0, 1)));
///     }
///
///     fn color(cell: vec2i) -> vec4f { return vec4f(heat_at(cell).rgb, 1.0); }
/// ";
/// let file = SimulationFile::parse("heat.wgsl", &text.replace("\n    ", "\n"))?;
/// assert_eq!((file.name(), file.states()), ("heat", &["heat".to_owned()][..]));
/// # Ok::<(), manypass::shader::ProgramError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SimulationFile {
    pub(super) file: String,
    pub(super) text: String,
    name: String,
    pub(super) module: naga::Module,
    /// What it finds declared.
    pub(super) declared: String,
    states: Vec<String>,
    pub(super) start: Vec<FilePass>,
    pub(super) step: Vec<FilePass>,
    pub(super) shows: Vec<FilePass>,
    cells: (u32, u32),
    rate_hz: f32,
    reads_surfaces: bool,
    pub(super) uniforms: Uniforms,
}

/// A pass and what it binds by group.
#[derive(Clone, Debug)]
pub(super) struct FilePass {
    pub pass: Pass,
    pub slots: Vec<Vec<Slot>>,
}

impl SimulationFile {
    /// Checks `text`. `file` appears in errors; its name without the ending is the simulation's where the header gives
    /// none.
    ///
    /// # Errors
    /// The text is not WGSL, or its header or a default is not of the form; with file, line and column.
    pub fn parse(file: &str, text: &str) -> Result<Self, ProgramError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source { file, text };
        let scan = scan(text);
        scan.check_length(source)?;
        let header = Header::parse(source, &scan)?;
        let states = states_of(source, &scan, &header)?;
        let functions: BTreeSet<&str> =
            [&header.start, &header.step, &header.shows].into_iter().flatten().map(|pass| &*pass.function).collect();
        let plain = declarations((header.edges, header.reads_surfaces), &states);
        let parsed =
            |declared: &str| locate::parse(file, text, declared).map_err(|fault| fault_of_bool(source, &scan, fault));
        let (module, _) = parsed(&plain)?;
        check_signatures(source, &scan, &header, &module)?;
        let shown: BTreeSet<&str> = header.shows.iter().map(|pass| &*pass.function).collect();
        let declared = format!("{plain}{}", entry_points(&functions, &shown));
        let (module, info) = parsed(&declared)?;
        check_functions(source, &module, &info)?;
        let composed = locate::composed(text, &declared);
        let with_slots = |pass: Pass| -> Result<FilePass, ProgramError> {
            let entry = format!("{ENTRY}{}", pass.function);
            let index = module.entry_points.iter().position(|known| known.name == entry).unwrap_or_default();
            let mut slots = reflect_bindings_of(&module, &info, &composed, index..index + 1);
            check_bindings(source, &scan, &slots)?;
            // States are of 32 bits, which nothing filters.
            for slot in slots.iter_mut().flatten() {
                if let wgpu::BindingType::Texture { sample_type, .. } = &mut slot.entry.ty {
                    *sample_type = wgpu::TextureSampleType::Float { filterable: false };
                }
            }
            Ok(FilePass { pass, slots })
        };
        let with_all = |passes: Vec<Pass>| passes.into_iter().map(with_slots).collect::<Result<Vec<_>, _>>();
        let Header { name, cells, rate_hz, reads_surfaces, start, step, shows, .. } = header;
        let (start, step, shows) = (with_all(start)?, with_all(step)?, with_all(shows)?);
        let name = name.unwrap_or_else(|| {
            let stem = std::path::Path::new(file).file_stem();
            stem.map_or(file.into(), |stem| stem.to_string_lossy().into_owned())
        });
        let all = || start.iter().chain(&step).chain(&shows);
        let own = all().filter_map(|pass| pass.slots.get(OWN_GROUP as usize)).flatten();
        let used: Vec<&str> = own.map(|slot| slot.name.as_str()).collect();
        let uniforms = Uniforms::reflect(&name, source, &scan, &module, &used)?;
        if let Some((_, missing)) = uniforms.missing() {
            return Err(Box::new(missing.clone()).into());
        }
        for FilePass { pass, .. } in all() {
            check_rounds(source, (&pass.rounds, &pass.place), &name, &uniforms)?;
        }
        let (file, text) = (file.into(), text.into());
        Ok(Self {
            file,
            text,
            name,
            module,
            declared,
            states,
            start,
            step,
            shows,
            cells,
            rate_hz,
            reads_surfaces,
            uniforms,
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of its states, which are four numbers a cell.
    pub fn states(&self) -> &[String] {
        &self.states
    }

    /// The names of the pictures that it makes.
    pub fn pictures(&self) -> impl Iterator<Item = &str> {
        self.shows.iter().map(|pass| pass.pass.target.as_str())
    }

    /// Width and height in cells where nobody says others.
    pub fn cells(&self) -> (u32, u32) {
        self.cells
    }

    /// Steps in a second where nobody says otherwise.
    pub fn rate_hz(&self) -> f32 {
        self.rate_hz
    }

    /// Whether it reads the surfaces that a camera of the scene sees.
    pub fn reads_surfaces(&self) -> bool {
        self.reads_surfaces
    }

    /// Its parameters, whose keys begin with its name; then whether it goes on.
    pub fn parameters(&self) -> &[SettingInfo] {
        &self.uniforms.settings
    }

    /// The values of its parameters, by their keys.
    pub fn values(&self) -> Vec<(String, SettingValue)> {
        self.uniforms.values()
    }

    /// Sets a parameter, by its name without the simulation's: numbers, with commas between those of a vector.
    ///
    /// # Errors
    /// An unknown one, another number of numbers, or one outside the range.
    pub fn set(&mut self, parameter: &str, value: &str) -> Result<(), SettingsError> {
        self.uniforms.set(&self.name, &format!("{}.{parameter}", self.name), &value.into()).map(drop)
    }
}

/// The states that passes write, each once.
fn states_of(source: Source<'_>, scan: &Scan, header: &Header) -> Result<Vec<String>, Box<Diagnostic>> {
    let mut states: Vec<String> = Vec::new();
    for pass in header.step.iter().chain(&header.start) {
        if states.contains(&pass.target) {
            continue;
        }
        let is_taken = |name: &str| scan.functions.contains_key(name) || scan.variables.contains_key(name);
        let names = [pass.target.clone(), format!("{}_at", pass.target), format!("{}_between", pass.target)];
        let is_of_prelude =
            |name: &str| locate::parse("", "", &declarations((Edges::Clamp, true), &[name.into()])).is_err();
        if names.iter().any(|name| is_taken(name)) || is_of_prelude(&pass.target) {
            let fault = source.fault(pass.place.clone(), format!("a state cannot be called `{}`", pass.target));
            return Err(Box::new(
                fault.note("something of that name, with `_at` or with `_between` is declared already"),
            ));
        }
        states.push(pass.target.clone());
    }
    if states.len() > STATES_MAX {
        return Err(source.fault(0..0, format!("there are {} states, and {STATES_MAX} are possible", states.len())));
    }
    Ok(states)
}

/// What is declared for a text that has no entry points.
fn declarations((edges, reads_surfaces): (Edges, bool), states: &[String]) -> String {
    let mut declared = PRELUDE.to_owned();
    if reads_surfaces {
        declared.push_str(SURFACES);
    }
    let within = match edges {
        Edges::Clamp => "clamp(cell, vec2i(0), simulation.cells - 1)",
        Edges::Wrap => "(cell % simulation.cells + simulation.cells) % simulation.cells",
    };
    let _ = writeln!(declared, "fn cell_within(cell: vec2i) -> vec2i {{ return {within}; }}");
    for (binding, state) in (FIRST_STATE..).zip(states) {
        let _ = writeln!(
            declared,
            "@group(1) @binding({binding}) var {state}: texture_2d<f32>;
fn {state}_at(cell: vec2i) -> vec4f {{ return textureLoad({state}, cell_within(cell), 0); }}
fn {state}_between(place_cells: vec2f) -> vec4f {{
    let corner = place_cells - 0.5;
    let first = vec2i(floor(corner));
    let share = corner - floor(corner);
    let upper = mix({state}_at(first), {state}_at(first + vec2i(1, 0)), share.x);
    let lower = mix({state}_at(first + vec2i(0, 1)), {state}_at(first + vec2i(1, 1)), share.x);
    return mix(upper, lower, share.y);
}}"
        );
    }
    declared
}

/// An entry point for each of `functions`; those of `shown` make pictures.
fn entry_points(functions: &BTreeSet<&str>, shown: &BTreeSet<&str>) -> String {
    functions.iter().fold(String::new(), |mut text, function| {
        let kept = if shown.contains(function) { "pictured" } else { "held" };
        let _ = writeln!(
            text,
            "@fragment fn {ENTRY}{function}(@builtin(position) position: vec4f) -> @location(0) vec4f {{
    return {kept}({function}(vec2i(position.xy)));
}}"
        );
        text
    })
}

/// Whether the functions that a header names are there, and are functions of a cell.
fn check_signatures(
    source: Source<'_>,
    scan: &Scan,
    header: &Header,
    module: &naga::Module,
) -> Result<(), Box<Diagnostic>> {
    use naga::{Scalar, TypeInner, VectorSize};
    if let Some(entry) = module.entry_points.first() {
        let place = scan.functions.get(&entry.name).cloned().unwrap_or(0..0);
        let fault =
            source.fault(place, format!("`{}` is an entry point; a simulation has functions alone", entry.name));
        return Err(Box::new(fault.note(format!("write `fn {}(cell: vec2i) -> vec4f`", entry.name))));
    }
    let vec2i = TypeInner::Vector { size: VectorSize::Bi, scalar: Scalar::I32 };
    let vec4f = TypeInner::Vector { size: VectorSize::Quad, scalar: Scalar::F32 };
    for Pass { function: name, place, .. } in [&header.start, &header.step, &header.shows].into_iter().flatten() {
        let found = module.functions.iter().find(|(_, function)| function.name.as_deref() == Some(name));
        let own = scan.functions.get(name);
        let (Some((_, function)), Some(declared)) = (found, own) else {
            let message = format!("there is no function `{name}`");
            return Err(Box::new(
                source.fault(place.clone(), message).note(format!("write `fn {name}(cell: vec2i) -> vec4f`")),
            ));
        };
        let arguments: Vec<_> = function.arguments.iter().map(|argument| &module.types[argument.ty].inner).collect();
        let result = function.result.as_ref().map(|result| &module.types[result.ty].inner);
        if arguments != [&vec2i] || result != Some(&vec4f) {
            let fault = source.fault(declared.clone(), format!("`{name}` is not a cell function"));
            return Err(Box::new(fault.note(format!("write `fn {name}(cell: vec2i) -> vec4f`"))));
        }
    }
    Ok(())
}

/// Whether what the text itself declares are uniforms in group 2.
fn check_bindings(source: Source<'_>, scan: &Scan, groups: &[Vec<Slot>]) -> Result<(), Box<Diagnostic>> {
    for (group, slots) in groups.iter().enumerate() {
        for slot in slots {
            let is_uniform = matches!(slot.entry.ty, wgpu::BindingType::Buffer { .. });
            let own = scan.variables.get(slot.name.as_str());
            if let Some(declared) = own.filter(|_| !(is_uniform && group == OWN_GROUP as usize)) {
                let message = format!("`{}`: a simulation's own bindings are uniforms in group 2", slot.name);
                let note = "its states are declared by its header: `//! step: FUNCTION -> STATE`";
                return Err(Box::new(source.fault(declared.name.clone(), message).note(note)));
            }
        }
    }
    Ok(())
}
