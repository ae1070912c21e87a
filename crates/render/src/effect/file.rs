//! An effect as its file has it, before a device compiles it.

use super::EffectStage;
use super::checks::{check_module, check_names, check_pixel, check_slots, check_textures, fault_of_names};
use super::declarations::{BorrowedTexture, declarations, table_declarations};
use super::fallback::{self, Fallback};
use super::fused::entry_point;
use super::header::Header;
use super::lut::{self, Table};
use super::steps::Step;
use crate::diagnostic::Diagnostic;
use crate::settings::{SettingInfo, SettingInput, SettingValue, SettingsError};
use crate::shader::locate;
use crate::shader::program::{ProgramError, Slot};
use crate::shader::reflection::reflect_bindings_of;
use crate::user_shader::Source;
use crate::user_shader::checks::fault_of_bool;
use crate::user_shader::rounds::check_rounds;
use crate::user_shader::scan::{Scan, scan};
use crate::user_shader::uniforms::{OWN_GROUP, Uniforms};
use std::sync::Arc;

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
    pub(super) borrowed: Vec<BorrowedTexture>,
    /// The function that changes a pixel and knows that one alone.
    pub(super) pixel: Option<String>,
    /// The table that it reads, if it is one of colours.
    pub(super) table: Option<Arc<Table>>,
    /// What is drawn in its place where time is short, if its header says so.
    pub(super) fallback: Option<Fallback>,
    /// What is wrong with it and hinders nothing.
    pub(super) warnings: Vec<String>,
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
        scan.check_length(source)?;
        let header = Header::parse(source, &scan)?;
        check_names(source, &scan, &header)?;
        let mut further = further_declarations(&header);
        further.push_str(&table_declarations(table.iter().map(|table| table.variable.as_str())));
        let parsed = |further: &str| {
            locate::parse(file, text, further)
                .map_err(|fault| fault_of_bool(source, &scan, fault_of_names(source, &header, fault)))
        };
        let (mut module, mut info) = parsed(&further)?;
        let stage = if header.reads_display() { EffectStage::Display } else { EffectStage::Radiance };
        if let Some(pixel) = &header.pixel {
            check_pixel(source, &scan, &header, pixel, (&module, &info))?;
            further.push_str(&entry_point(stage, std::iter::once(pixel.0.as_str())));
            (module, info) = parsed(&further)?;
        }
        check_module(source, &scan, &module, &info)?;
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
        let used = names(1);
        let needless = header.check(source, &used)?;
        check_textures(source, &scan, &steps)?;
        let mut borrowed = header.borrowed();
        // The frame makes nothing for a word too many.
        borrowed.retain(|borrowed| used.contains(&borrowed.variable.as_str()));
        let pixel = header.pixel.as_ref().map(|(function, _)| function.clone());
        let name = header.name.clone().unwrap_or_else(|| {
            let stem = std::path::Path::new(file).file_stem();
            stem.map_or(file.into(), |stem| stem.to_string_lossy().into_owned())
        });
        let fallback = header.fallback.as_ref();
        let fallback = fallback.map(|said| fallback::checked(source, &name, stage, said)).transpose()?;
        let uniforms = Uniforms::reflect(&name, source, &scan, &module, &names(OWN_GROUP as usize))?;
        header.check_conditions(source, |setting| uniforms.number(&name, &format!("{name}.{setting}")).is_some())?;
        for (step, _) in &steps {
            check_rounds(source, (&step.rounds, &step.place), &name, &uniforms)?;
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
            fallback,
            warnings: needless.into_iter().collect(),
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
        let looks = |borrowed: &BorrowedTexture| {
            borrowed.key == "motion" && self.uniforms.wants(&self.name, &borrowed.settings)
        };
        !self.uniforms.is_off && self.borrowed.iter().any(looks)
    }

    /// What is drawn in its place where time is short (`effects.fallbacks`), if its header says so: the name of a built-in
    /// effect, or `none`.
    pub fn fallback(&self) -> Option<&str> {
        self.fallback.map(Fallback::name)
    }

    /// What is wrong with it and hinders nothing, each one line with file, line and column: words of its header that
    /// name what the shader does not read.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
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
    pub fn give(&mut self, key: &str, written: &SettingInput) -> Result<(), SettingsError> {
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
        let message = format!("the `@fragment` function `{unused}` is not a pass of the line `//! passes:`");
        return Err(source.fault(place(unused), message));
    }
    Ok(indexed)
}
