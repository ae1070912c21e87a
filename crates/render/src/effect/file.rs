//! An effect as its file has it, before a device compiles it.

use super::header::{Header, Source};
use super::scan::{Scan, scan};
use super::uniforms::{OWN_GROUP, Uniforms};
use crate::diagnostic::Diagnostic;
use crate::settings::{SettingInfo, SettingValue, SettingsError, Written};
use crate::shader::locate;
use crate::shader::program::{ProgramError, Slot};
use crate::shader::reflection::reflect_bindings;

/// The text of a [`super::WgslEffect`], checked without a device: its name, its settings and their values.
#[derive(Clone, Debug)]
pub struct EffectFile {
    /// Its name in errors.
    pub(super) file: String,
    /// The text.
    pub(super) text: String,
    pub(super) name: String,
    pub(super) module: naga::Module,
    pub(super) slots: Vec<Vec<Slot>>,
    pub(super) uniforms: Uniforms,
}

impl EffectFile {
    /// Checks `text`. `file` appears in errors; its name without the ending is the effect's where the header gives
    /// none.
    ///
    /// # Errors
    /// The text is not WGSL, or not one fragment shader that fits the frame, or its header or a default is not of the
    /// form; with file, line and column.
    pub fn parse(file: &str, text: &str) -> Result<Self, ProgramError> {
        // Some editors begin files with a byte order mark, which WGSL does not know.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source { file, text };
        let scan = scan(text);
        if let Some(place) = &scan.overlong {
            return Err(source.fault(place.clone(), "the shader is too long or nested too deeply from here on").into());
        }
        let header = Header::parse(source, &scan)?;
        let (module, info) = locate::parse(file, text)?;
        let slots = reflect_bindings(&module, &info, &locate::composed(text));
        let entry_point = check_module(source, &scan, &module)?;
        check_slots(source, &scan, &slots)?;
        let names = |group: usize| -> Vec<&str> {
            slots.get(group).map_or(Vec::new(), |slots| slots.iter().map(|slot| slot.name.as_str()).collect())
        };
        header.check(source, &entry_point, &names(1))?;
        let name = header.name.unwrap_or_else(|| {
            let stem = std::path::Path::new(file).file_stem();
            stem.map_or(file.into(), |stem| stem.to_string_lossy().into_owned())
        });
        let uniforms = Uniforms::reflect(&name, source, &scan, &module, &names(OWN_GROUP as usize))?;
        Ok(Self { file: file.into(), text: text.into(), name, module, slots, uniforms })
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

/// The name of the module's entry point, if it is one fragment shader from a position to a colour.
fn check_module(source: Source<'_>, scan: &Scan, module: &naga::Module) -> Result<String, Box<Diagnostic>> {
    use naga::{AddressSpace, Binding, BuiltIn};
    let place = |name: &str| scan.functions.get(name).cloned().unwrap_or(0..0);
    let entry = match module.entry_points.as_slice() {
        [entry] => entry,
        [] => {
            let end = source.text.len();
            return Err(source.fault(end..end, "an effect has one entry point, a `@fragment` function; this has none"));
        }
        [_, second, ..] => {
            let message =
                format!("an effect has one entry point, a `@fragment` function, not {}", module.entry_points.len());
            return Err(source.fault(place(&second.name), message));
        }
    };
    let fault = |message: String| source.fault(place(&entry.name), message);
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
        let message = format!("`{}` returns `@location(0) vec4f`, the new radiance and coverage", entry.name);
        return Err(fault(message));
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
    Ok(entry.name.clone())
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
            if is_filtered && name == "linear_depth" {
                let is_code = |at: &usize| !scan.comments.iter().any(|comment| comment.range.contains(at));
                let at = source.text.match_indices("linear_depth").map(|(at, _)| at).find(is_code).unwrap_or(0);
                let message = "`linear_depth` cannot be filtered; use `distance_at(pixel)` or `nearest_clamp`";
                return Err(source.fault(at..at + name.len(), message));
            }
        }
    }
    Ok(())
}
