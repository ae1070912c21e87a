//! An effect as its file has it, before a device compiles it.

use super::EffectStage;
use super::declarations::{Borrowed, FIRST_TEXTURE, declarations, table_declarations, texture_declaration};
use super::fused::{PIXEL_ENTRY, entry_point};
use super::header::{Header, READS, Source};
use super::lut::{self, Table};
use super::scan::{Scan, scan};
use super::steps::{self, Rounds, STEPS_MAX, Step};
use super::uniforms::{OWN_GROUP, Uniforms};
use crate::diagnostic::Diagnostic;
use crate::settings::{SettingInfo, SettingValue, SettingsError, Written};
use crate::shader::locate;
use crate::shader::program::{ProgramError, Slot};
use crate::shader::reflection::reflect_bindings_of;
use std::ops::Range;
use std::sync::Arc;

/// A stage of WebGL 2 has so many textures.
const TEXTURES_MAX: usize = 16;

/// The text of a [`super::WgslEffect`], checked without a device: its name, its settings and their values.
#[derive(Clone, Debug)]
pub struct EffectFile {
    /// Its name in errors.
    pub(super) file: String,
    /// The text.
    pub(super) text: String,
    pub(super) name: String,
    pub(super) module: naga::Module,
    /// What its header lets it find declared beside the prelude.
    pub(super) further: String,
    /// Its passes in their order, each with what it binds by group.
    pub(super) steps: Vec<(Step, Vec<Vec<Slot>>)>,
    pub(super) stage: EffectStage,
    pub(super) uniforms: Uniforms,
    /// What it reads that only its header declares, beside its own textures.
    pub(super) borrowed: Vec<Borrowed>,
    /// The function that changes a pixel and knows that one alone.
    pub(super) pixel: Option<String>,
    /// The table that it reads, if it is one of colours.
    pub(super) table: Option<Arc<Table>>,
}

impl EffectFile {
    /// Checks `text`. `file` appears in errors; its name without the ending is the effect's where the header gives
    /// none. A file that ends in `.cube` is a table of colours, by which display colours are changed.
    ///
    /// # Errors
    /// The text is not WGSL, or not of fragment shaders that fit the frame, or its header or a default is not of the form;
    /// it is no table of colours; with file, line and column.
    pub fn parse(file: &str, text: &str) -> Result<Self, ProgramError> {
        if !lut::is_cube(file) {
            return Self::parse_shader(file, text, None);
        }
        let (text, table) = lut::effect(Source { file, text: text.strip_prefix('\u{feff}').unwrap_or(text) })?;
        Self::parse_shader(file, &text, Some(table))
    }

    fn parse_shader(file: &str, text: &str, table: Option<Table>) -> Result<Self, ProgramError> {
        // Some editors begin files with a byte order mark, which WGSL does not know.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source { file, text };
        let scan = scan(text);
        if let Some(place) = &scan.overlong {
            return Err(source.fault(place.clone(), "the shader is too long or nested too deeply from here on").into());
        }
        let header = Header::parse(source, &scan)?;
        check_names(source, &scan, &header)?;
        let mut further = further_declarations(&header);
        further.push_str(&table_declarations(table.iter().map(|table| table.variable.as_str())));
        let parsed =
            |further: &str| locate::parse(file, text, further).map_err(|fault| fault_of_names(source, &header, fault));
        let (mut module, mut info) = parsed(&further)?;
        let stage = if header.reads_display() { EffectStage::Display } else { EffectStage::Radiance };
        if let Some(pixel) = &header.pixel {
            check_pixel(source, &scan, &header, pixel, (&module, &info))?;
            further.push_str(&entry_point(stage, std::iter::once(pixel.0.as_str())));
            (module, info) = parsed(&further)?;
        }
        check_module(source, &scan, &module)?;
        let composed = locate::composed(text, &further);
        let with_slots = |(step, index): (Step, usize)| {
            let slots = reflect_bindings_of(&module, &info, &composed, index..index + 1);
            check_slots(source, &scan, &slots).map(|()| (step, slots))
        };
        let steps = found_steps(source, &scan, &header.steps, &module)?;
        let steps = steps.into_iter().map(with_slots).collect::<Result<Vec<_>, _>>()?;
        let names = |group: usize| -> Vec<&str> {
            let slots = steps.iter().filter_map(|(_, slots)| slots.get(group)).flatten();
            slots.map(|slot| slot.name.as_str()).collect()
        };
        header.check(source, &names(1))?;
        check_textures(source, &scan, &steps)?;
        let borrowed = header.borrowed();
        let pixel = header.pixel.map(|(function, _)| function);
        let name = header.name.unwrap_or_else(|| {
            let stem = std::path::Path::new(file).file_stem();
            stem.map_or(file.into(), |stem| stem.to_string_lossy().into_owned())
        });
        let uniforms = Uniforms::reflect(&name, source, &scan, &module, &names(OWN_GROUP as usize))?;
        for (step, _) in &steps {
            check_rounds(source, step, &name, &uniforms)?;
        }
        Ok(Self {
            file: file.into(),
            text: text.into(),
            name,
            module,
            further,
            steps,
            stage,
            uniforms,
            borrowed,
            pixel,
            table: table.map(Arc::new),
        })
    }

    /// What it makes new.
    pub fn stage(&self) -> EffectStage {
        self.stage
    }

    /// Whether it draws the same as another: of one file and text, with the same values.
    pub fn is_same(&self, other: &Self) -> bool {
        self.has_text_of(other) && self.values() == other.values()
    }

    /// Whether it is of the same file and text as another.
    pub fn has_text_of(&self, other: &Self) -> bool {
        self.file == other.file && self.text == other.text && self.table == other.table
    }

    /// The effect of another text for the same file. Settings that it has too keep their values where it takes them;
    /// others have their defaults.
    ///
    /// # Errors
    /// As [`Self::parse`]; another name, or a setting without a value.
    pub fn replaced(&self, text: &str) -> Result<Self, ProgramError> {
        Self::parse_replacing((&self.file, &self.name), self.values(), text)
    }

    /// As [`Self::replaced`], of an effect of that file, name and values.
    pub(super) fn parse_replacing(
        (file, name): (&str, &str),
        values: Vec<(String, SettingValue)>,
        text: &str,
    ) -> Result<Self, ProgramError> {
        let mut effect = Self::parse(file, text)?;
        if effect.name != name {
            let message = format!(
                "the new text of {file} is called `{}`; an effect keeps its name: `//! effect {name}`",
                effect.name
            );
            return Err(ProgramError::Misplaced { pass: name.into(), message });
        }
        for (key, value) in values {
            // A default takes the place of a value that the new text does not take.
            let _ = effect.give(&key, &value.into());
        }
        match effect.missing() {
            Some((_, missing)) => Err(Box::new(missing.clone()).into()),
            None => Ok(effect),
        }
    }

    /// Whether it is drawn and reads how far surfaces moved since the frame before.
    pub fn reads_motion(&self) -> bool {
        !self.uniforms.is_off && self.borrowed.iter().any(|borrowed| borrowed.key == "motion")
    }

    /// The file, as [`Self::parse`] was told.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The values of its settings, by their keys.
    pub fn values(&self) -> Vec<(String, SettingValue)> {
        self.uniforms.values()
    }

    /// The effect's name, with which the keys of its settings begin.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The members of its uniforms that text can give, in the order of their declaration; then whether it is drawn.
    pub fn settings(&self) -> &[SettingInfo] {
        &self.uniforms.settings
    }

    /// Whether `key` is one of this effect's.
    pub fn has(&self, key: &str) -> bool {
        self.uniforms.has(&self.name, key)
    }

    /// Sets `key`, `EFFECT.MEMBER` or `EFFECT.UNIFORM.MEMBER`, to `value`: numbers, with commas between those of a
    /// vector.
    ///
    /// # Errors
    /// An unknown key, another number of numbers, or one outside the range.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), SettingsError> {
        self.give(key, &value.into())
    }

    /// As [`Self::set`], with what was written on the command line or in a file.
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn give(&mut self, key: &str, written: &Written) -> Result<(), SettingsError> {
        self.uniforms.set(&self.name, key, written).map(drop)
    }

    /// The first member of a uniform without default and value, and its place; its setting is none if no text is a
    /// value of its type.
    pub fn missing(&self) -> Option<(Option<&SettingInfo>, &Diagnostic)> {
        self.uniforms.missing()
    }
}

/// What the words of a header let the shader find declared.
fn further_declarations(header: &Header) -> String {
    let mut textures: Vec<&str> = header.steps.iter().filter_map(|step| step.texture.as_deref()).collect();
    textures.sort_unstable();
    textures.dedup();
    let finds_drawn = header.reads_display() || header.steps.len() > 1;
    declarations(header.reads_display(), finds_drawn, &textures, &header.borrowed())
}

/// Whether the function that a header names changes a pixel and looks at no other.
fn check_pixel(
    source: Source<'_>,
    scan: &Scan,
    header: &Header,
    (name, place): &(String, Range<usize>),
    (module, info): (&naga::Module, &naga::valid::ModuleInfo),
) -> Result<(), Box<Diagnostic>> {
    if !header.steps.is_empty() || !module.entry_points.is_empty() {
        let message = "an effect of `//! pixel:` has neither `//! passes:` nor `@fragment` functions";
        return Err(source.fault(place.clone(), message));
    }
    let found = module.functions.iter().find(|(_, function)| function.name.as_deref() == Some(name));
    let Some((handle, function)) = found else {
        return Err(source.fault(place.clone(), format!("there is no function `{name}`")));
    };
    let declared = scan.functions.get(name).cloned().unwrap_or_else(|| place.clone());
    let vector = |size| naga::TypeInner::Vector { size, scalar: naga::Scalar::F32 };
    let (vec2f, vec4f) = (vector(naga::VectorSize::Bi), vector(naga::VectorSize::Quad));
    let arguments: Vec<_> = function.arguments.iter().map(|argument| &module.types[argument.ty].inner).collect();
    let result = function.result.as_ref().map(|result| &module.types[result.ty].inner);
    if arguments != [&vec4f, &vec2f] || result != Some(&vec4f) {
        let message = format!("`{name}` is no function of a pixel");
        let note = format!("write `fn {name}(color: vec4f, position: vec2f) -> vec4f`");
        return Err(Box::new(source.fault(declared, message).note(note)));
    }
    let is_used = |texture: &str| {
        let global = module.global_variables.iter().find(|(_, global)| global.name.as_deref() == Some(texture));
        global.is_some_and(|(global, _)| !info[handle][global].is_empty())
    };
    if let Some(texture) = ["radiance", "display", "previous"].into_iter().find(|texture| is_used(texture)) {
        let message = format!("`{name}` reads `{texture}`, but a function of a pixel is given its colour");
        let note = "what looks at other pixels is a `@fragment` function of its own";
        return Err(Box::new(source.fault(declared, message).note(note)));
    }
    Ok(())
}

/// The passes of an effect, each with the index of its entry point: those that the header names, or the only one.
fn found_steps(
    source: Source<'_>,
    scan: &Scan,
    declared: &[Step],
    module: &naga::Module,
) -> Result<Vec<(Step, usize)>, Box<Diagnostic>> {
    let place = |name: &str| scan.functions.get(name).cloned().unwrap_or(0..0);
    let names: Vec<&str> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
    match (&names[..], declared) {
        ([], _) => {
            let end = source.text.len();
            return Err(source.fault(end..end, "an effect has an entry point, a `@fragment` function; this has none"));
        }
        ([only], []) => return Ok(vec![(Step::only((*only).into()), 0)]),
        ([_, second, ..], []) => {
            let message = format!("an effect of {} passes says in its header what becomes of them", names.len());
            let list = names.join(" -> TEXTURE, ");
            return Err(Box::new(
                source.fault(place(second), message).note(format!("such as `//! passes: {list}`, in their order")),
            ));
        }
        _ => (),
    }
    let indexed = declared.iter().map(|step| match names.iter().position(|name| *name == step.function) {
        Some(index) => Ok((step.clone(), index)),
        None => {
            let message =
                format!("there is no `@fragment` function `{}`; there is: {}", step.function, names.join(", "));
            Err(source.fault(step.place.clone(), message))
        }
    });
    let indexed = indexed.collect::<Result<_, _>>()?;
    if let Some(unused) = names.iter().find(|name| !declared.iter().any(|step| step.function == **name)) {
        let message = format!("the `@fragment` function `{unused}` is no pass of the line `//! passes:`");
        return Err(source.fault(place(unused), message));
    }
    Ok(indexed)
}

/// Whether each pass reads what is there, and no more than every adapter can bind.
fn check_textures(source: Source<'_>, scan: &Scan, steps: &[(Step, Vec<Vec<Slot>>)]) -> Result<(), Box<Diagnostic>> {
    let is_texture = |slot: &&Slot| matches!(slot.entry.ty, wgpu::BindingType::Texture { .. });
    let mut read = Vec::with_capacity(steps.len());
    for (step, slots) in steps {
        let textures = slots.get(1).into_iter().flatten().filter(is_texture);
        let names: Vec<&str> = textures.map(|slot| slot.name.as_str()).collect();
        if names.len() > TEXTURES_MAX {
            let place = scan.functions.get(&step.function).cloned().unwrap_or(0..0);
            let message =
                format!("`{}` reads {} textures; a pass reads at most {TEXTURES_MAX}", step.function, names.len());
            return Err(source.fault(place, message));
        }
        read.push((step, names));
    }
    steps::check(source, &read)
}

/// Whether the names that a header gives to textures are free: neither the file's own, nor those by which a header calls
/// what is read.
fn check_names(source: Source<'_>, scan: &Scan, header: &Header) -> Result<(), Box<Diagnostic>> {
    let is_taken = |texture: &str| {
        READS.iter().any(|(name, _)| *name == texture)
            || scan.functions.contains_key(texture)
            || scan.variables.contains_key(texture)
            || scan.members.keys().any(|(structure, _)| structure == texture)
    };
    let taken = header.steps.iter().find(|step| step.texture.as_deref().is_some_and(is_taken));
    if let Some(step) = taken {
        return Err(taken_name(source, step));
    }
    let is_own = |name: &str| {
        scan.functions.contains_key(name)
            || scan.variables.contains_key(name)
            || header.steps.iter().any(|step| step.texture.as_deref() == Some(name))
    };
    if let Some(borrowed) = header.borrowed().into_iter().find(|borrowed| is_own(&borrowed.variable)) {
        let Borrowed { key, variable } = borrowed;
        let message = format!("`{key}` is called `{variable}` in the shader, which is declared already");
        return Err(source.fault(header.place_of_reads(), message));
    }
    match scan.functions.get(PIXEL_ENTRY).filter(|_| header.pixel.is_some()) {
        Some(place) => Err(source.fault(place.clone(), format!("`//! pixel:` declares `{PIXEL_ENTRY}` itself"))),
        None => Ok(()),
    }
}

/// The fault of a file that is no WGSL with what its header declares: one of its textures, if that by itself is none
/// beside what effects find declared.
fn fault_of_names(source: Source<'_>, header: &Header, fault: Box<Diagnostic>) -> Box<Diagnostic> {
    let is_fault = |step: &&Step| {
        let Some(texture) = &step.texture else { return false };
        let alone = format!("{}{}", texture_declaration(FIRST_TEXTURE, texture), declarations(true, true, &[], &[]),);
        locate::parse(source.file, &alone, "").is_err()
    };
    header.steps.iter().find(is_fault).map_or_else(|| with_words(fault), |step| taken_name(source, step))
}

fn taken_name(source: Source<'_>, step: &Step) -> Box<Diagnostic> {
    let texture = step.texture.as_deref().unwrap_or_default();
    let fault = source.fault(step.place.clone(), format!("a texture cannot be called `{texture}`"));
    Box::new(fault.note("it is a word of WGSL, or something of that name is declared already"))
}

/// The fault of a file that uses what only words of its header declare, with these words.
fn with_words(fault: Box<Diagnostic>) -> Box<Diagnostic> {
    let is_unknown =
        |name: &str| fault.message.contains("no definition in scope") && fault.message.contains(&format!("`{name}`"));
    let note = if ["display", "display_at"].into_iter().any(is_unknown) {
        "`//! reads: display` in the header declares it"
    } else if ["drawn", "uv_at"].into_iter().any(is_unknown) {
        "`//! reads: display` in the header declares it, and so does a list of several `//! passes:`"
    } else if ["occlusion", "motion"].into_iter().any(is_unknown) {
        "`//! reads: occlusion` (or `motion`) in the header declares it"
    } else {
        return fault;
    };
    Box::new(fault.note(note))
}

/// Whether the setting is there that says how often a pass is drawn, and bounds that.
fn check_rounds(source: Source<'_>, step: &Step, effect: &str, uniforms: &Uniforms) -> Result<(), Box<Diagnostic>> {
    let Rounds::Setting(setting) = &step.rounds else { return Ok(()) };
    let range = uniforms.range_of_count(effect, &format!("{effect}.{setting}"));
    if range.is_some_and(|(least, most)| least >= 1.0 && most <= STEPS_MAX as f64) {
        return Ok(());
    }
    let message =
        format!("`{setting}` is no number of rounds: a setting that is a `u32` and stays within 1..{STEPS_MAX}");
    let note = format!("it is a member of a uniform, `u32`, with a line such as `// = 4 in 1..{STEPS_MAX}` above it");
    let several = "where two uniforms have a member of that name, it is called `UNIFORM.MEMBER`";
    Err(Box::new(source.fault(step.place.clone(), message).note(note).note(several)))
}

/// Whether the module's entry points are fragment shaders from a position to a colour.
fn check_module(source: Source<'_>, scan: &Scan, module: &naga::Module) -> Result<(), Box<Diagnostic>> {
    use naga::AddressSpace;
    for entry in &module.entry_points {
        check_entry_point(source, scan, module, entry)?;
    }
    let functions = module.functions.iter().map(|(_, function)| function);
    for function in functions.chain(module.entry_points.iter().map(|entry| &entry.function)) {
        if let Some(span) = endless_loop(&function.body) {
            let place = span.to_range().filter(|range| range.start < source.text.len()).unwrap_or(0..0);
            let message = "this loop never ends: it has neither a `break` nor a `return`";
            return Err(source.fault(place.start..(place.start + 4).min(source.text.len()), message));
        }
    }
    if let Some((handle, _)) = module.overrides.iter().find(|(_, constant)| constant.init.is_none()) {
        let place = module.overrides.get_span(handle).to_range().unwrap_or(0..0);
        return Err(source.fault(place, "nobody gives a value to an `override` without one; use a uniform"));
    }
    for (handle, global) in module.global_variables.iter() {
        let is_good = matches!(global.space, AddressSpace::Private | AddressSpace::Uniform | AddressSpace::Handle);
        if !is_good {
            let place = module.global_variables.get_span(handle).to_range().unwrap_or(0..0);
            let name = global.name.as_deref().unwrap_or_default();
            return Err(source.fault(place, format!("`{name}` is neither a uniform nor a texture nor a sampler")));
        }
    }
    Ok(())
}

/// The first loop of a block that nothing leaves.
fn endless_loop(block: &naga::Block) -> Option<naga::Span> {
    use naga::Statement;
    block.span_iter().find_map(|(statement, span)| match statement {
        Statement::Loop { body, continuing, break_if } => {
            let is_left = break_if.is_some() || leaves_loop(body) || leaves_loop(continuing);
            if is_left { endless_loop(body).or_else(|| endless_loop(continuing)) } else { Some(*span) }
        }
        Statement::Block(block) => endless_loop(block),
        Statement::If { accept, reject, .. } => endless_loop(accept).or_else(|| endless_loop(reject)),
        Statement::Switch { cases, .. } => cases.iter().find_map(|case| endless_loop(&case.body)),
        _ => None,
    })
}

/// Whether a block may leave the loop that it stands in, as far as its statements go.
fn leaves_loop(block: &naga::Block) -> bool {
    use naga::Statement;
    // A `break` within a `switch` or another loop leaves that.
    fn returns(block: &naga::Block) -> bool {
        block.iter().any(|statement| match statement {
            Statement::Return { .. } | Statement::Kill => true,
            Statement::Block(block) => returns(block),
            Statement::If { accept, reject, .. } => returns(accept) || returns(reject),
            Statement::Switch { cases, .. } => cases.iter().any(|case| returns(&case.body)),
            Statement::Loop { body, continuing, .. } => returns(body) || returns(continuing),
            _ => false,
        })
    }
    block.iter().any(|statement| match statement {
        Statement::Break | Statement::Return { .. } | Statement::Kill => true,
        Statement::Block(block) => leaves_loop(block),
        Statement::If { accept, reject, .. } => leaves_loop(accept) || leaves_loop(reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| returns(&case.body)),
        Statement::Loop { body, continuing, .. } => returns(body) || returns(continuing),
        _ => false,
    })
}

fn check_entry_point(
    source: Source<'_>,
    scan: &Scan,
    module: &naga::Module,
    entry: &naga::EntryPoint,
) -> Result<(), Box<Diagnostic>> {
    use naga::{Binding, BuiltIn};
    let fault = |message: String| source.fault(scan.functions.get(&entry.name).cloned().unwrap_or(0..0), message);
    if entry.stage != naga::ShaderStage::Fragment {
        return Err(fault(format!("the entry point `{}` is not a `@fragment` function", entry.name)));
    }
    let is_position = |argument: &naga::FunctionArgument| {
        matches!(argument.binding, Some(Binding::BuiltIn(BuiltIn::Position { .. })))
    };
    if !entry.function.arguments.iter().all(is_position) {
        return Err(fault(format!("`{}` takes nothing but `@builtin(position) position: vec4f`", entry.name)));
    }
    let vec4f = naga::TypeInner::Vector { size: naga::VectorSize::Quad, scalar: naga::Scalar::F32 };
    let is_color = entry.function.result.as_ref().is_some_and(|result| {
        matches!(result.binding, Some(Binding::Location { location: 0, .. })) && module.types[result.ty].inner == vec4f
    });
    if !is_color {
        let message = format!("`{}` returns `@location(0) vec4f`: colour, and coverage as alpha", entry.name);
        return Err(fault(message));
    }
    Ok(())
}

/// Whether what the shader itself declares are uniforms in group 2, and filtering is used where formats allow it.
fn check_slots(source: Source<'_>, scan: &Scan, groups: &[Vec<Slot>]) -> Result<(), Box<Diagnostic>> {
    for (group, slots) in groups.iter().enumerate() {
        for slot in slots {
            let name = &slot.name;
            let is_uniform = matches!(slot.entry.ty, wgpu::BindingType::Buffer { .. });
            let own = scan.variables.get(name.as_str());
            if let Some(declared) = own.filter(|_| !(is_uniform && group == OWN_GROUP as usize)) {
                let message = format!("`{name}` in group {group}: an effect's own bindings are uniforms in group 2");
                let note = "textures and samplers of the frame are declared already";
                return Err(Box::new(source.fault(declared.name.clone(), message).note(note)));
            }
            let is_filtered = matches!(
                slot.entry.ty,
                wgpu::BindingType::Texture { sample_type: wgpu::TextureSampleType::Float { filterable: true }, .. }
            );
            if is_filtered && matches!(name.as_str(), "linear_depth" | "motion") {
                let is_code = |at: &usize| !scan.comments.iter().any(|comment| comment.range.contains(at));
                let at = source.text.match_indices(name.as_str()).map(|(at, _)| at).find(is_code).unwrap_or(0);
                let function = if name == "motion" { "textureLoad" } else { "distance_at(pixel)" };
                let message = format!("`{name}` cannot be filtered; use `{function}` or `nearest_clamp`");
                return Err(source.fault(at..at + name.len(), message));
            }
        }
    }
    Ok(())
}
