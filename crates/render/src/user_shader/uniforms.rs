//! The uniforms of an effect as settings: found by reflection, with defaults and ranges from the comments above them.

use super::scan::{Declaration, Scan};
use super::source::Source;
use crate::diagnostic::Diagnostic;
use crate::settings::{NumberType, Scalar, SettingInfo, SettingInput, SettingType, SettingValue, SettingsError};
use naga::{Handle, Module, Type, TypeInner};
use std::collections::HashMap;
use std::ops::Range;

/// The uniforms of an effect, and the settings that their members are.
#[derive(Clone, Debug, Default)]
pub(crate) struct Uniforms {
    /// The settings, in the order of their declaration; those of members that text can give.
    pub settings: Vec<SettingInfo>,
    fields: Vec<Field>,
    /// Every uniform's name and bytes.
    pub blocks: Vec<Block>,
    /// Whether the effect is left out.
    pub is_off: bool,
    /// Which setting says so; none if a member has that name.
    switch: Option<usize>,
}

/// The setting by which an effect is left out.
const SWITCH: &str = "enabled";

/// A uniform variable.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// The WGSL name.
    pub name: String,
    /// Its bytes as WGSL lays them out.
    pub bytes: Vec<u8>,
    /// Whether the shader uses it.
    pub is_used: bool,
}

/// A number or a vector somewhere in a uniform, or what else is there.
#[derive(Clone, Debug)]
struct Field {
    /// The uniform's name and those of the members that lead to it.
    path: Vec<String>,
    block: usize,
    offset: usize,
    /// Which setting it is, and its type; none if text cannot give it.
    setting: Option<(usize, NumberType)>,
    /// What is wrong while it has no value.
    missing: Option<Box<Diagnostic>>,
}

/// What the comments above a declaration say.
#[derive(Debug, Default)]
struct Remarks {
    doc: String,
    unit: Option<String>,
    /// The bytes of what follows `// =`.
    default: Option<Range<usize>>,
}

/// The largest uniform that every device has; WebGL 2 promises no more.
const BLOCK_BYTES_MAX: usize = 16384;
/// The group of an effect's own uniforms.
pub(crate) const OWN_GROUP: u32 = 2;

impl Uniforms {
    /// The uniforms of a valid module; `used` are the names of those that its entry point uses.
    ///
    /// # Errors
    /// A default that is none; its place.
    pub fn reflect(
        effect: &str,
        source: Source<'_>,
        scan: &Scan,
        module: &Module,
        used: &[&str],
    ) -> Result<Self, Box<Diagnostic>> {
        let mut reflection = Reflection { source, scan, module, uniforms: Self::default(), path: Vec::new() };
        for (_, global) in module.global_variables.iter() {
            let is_own = global.space == naga::AddressSpace::Uniform
                && global.binding.is_some_and(|binding| binding.group == OWN_GROUP);
            let (true, Some(name)) = (is_own, &global.name) else { continue };
            let size = module.types[global.ty].inner.size(module.to_ctx()) as usize;
            if size > BLOCK_BYTES_MAX {
                let place = scan.variables.get(name).map_or(0..0, |declared| declared.name.clone());
                let message = format!("`{name}` has {size} bytes; a uniform has at most {BLOCK_BYTES_MAX}");
                return Err(source.fault(place, message));
            }
            let block = Block { name: name.clone(), bytes: vec![0; size], is_used: used.contains(&name.as_str()) };
            reflection.uniforms.blocks.push(block);
            reflection.path.push(name.clone());
            reflection.visit(global.ty, 0, scan.variables.get(name))?;
            reflection.path.clear();
        }
        let mut uniforms = reflection.uniforms;
        uniforms.name_keys(effect);
        uniforms.add_switch(effect);
        Ok(uniforms)
    }

    /// Adds the setting by which the effect is left out, and that all others need it; unless a member has that name.
    fn add_switch(&mut self, effect: &str) {
        let switch = SettingInfo::of_field(SWITCH, &["Whether the effect is drawn."], &true).of_group(effect);
        if self.field(effect, &switch.key).is_some() {
            return;
        }
        for info in &mut self.settings {
            info.needs.push(format!("{}=true", switch.key).into());
        }
        self.switch = Some(self.settings.len());
        self.settings.push(switch);
    }

    fn switch(&self) -> Option<&SettingInfo> {
        self.settings.get(self.switch?)
    }

    /// Makes keys of the last names of paths; where those are not unique, of whole paths.
    fn name_keys(&mut self, effect: &str) {
        let mut counts: HashMap<String, usize> = HashMap::new();
        for field in &self.fields {
            *counts.entry(field.path.last().cloned().unwrap_or_default()).or_default() += 1;
        }
        for field in &self.fields {
            let Some(info) = field.setting.and_then(|(setting, _)| self.settings.get_mut(setting)) else { continue };
            let last = field.path.last().cloned().unwrap_or_default();
            let name = if counts.get(&last) == Some(&1) { last } else { field.path.join(".") };
            info.key = format!("{effect}.{name}").into();
        }
    }

    /// The field of a key: its setting's, or the name of the effect and the whole path.
    fn field(&self, effect: &str, key: &str) -> Option<usize> {
        let path = key.strip_prefix(effect).and_then(|rest| rest.strip_prefix('.'));
        self.fields.iter().position(|field| {
            let Some((setting, _)) = field.setting else { return false };
            self.settings[setting].key == key || path.is_some_and(|path| field.path.join(".") == path)
        })
    }

    /// The range of the setting of a key, if it is a single `u32` that has both ends.
    pub fn range_of_count(&self, effect: &str, key: &str) -> Option<(f64, f64)> {
        let (setting, _) = self.fields.get(self.field(effect, key)?)?.setting?;
        let info = self.settings.get(setting)?;
        let is_count = matches!(info.kind, SettingType::Number(NumberType { scalar: Scalar::U32, count: 1 }));
        info.min.zip(info.max).filter(|_| is_count)
    }

    /// The present value of the setting of a key, if that is one number.
    pub fn number(&self, effect: &str, key: &str) -> Option<f64> {
        let field = self.fields.get(self.field(effect, key)?)?;
        let (_, kind) = field.setting.filter(|(_, kind)| kind.count == 1)?;
        read(&self.blocks.get(field.block)?.bytes, field.offset, kind).first().copied()
    }

    /// Whether one of `settings` is other than 0, if there are any.
    pub fn wants(&self, effect: &str, settings: &[String]) -> bool {
        let is_on = |setting: &String| self.number(effect, &format!("{effect}.{setting}")) != Some(0.0);
        settings.is_empty() || settings.iter().any(is_on)
    }

    /// The present value of the number that a key sets.
    pub fn count(&self, effect: &str, key: &str) -> Option<u32> {
        let field = self.fields.get(self.field(effect, key)?)?;
        let (_, kind) = field.setting?;
        let components = read(&self.blocks.get(field.block)?.bytes, field.offset, kind);
        components.first().map(|count| *count as u32)
    }

    /// Whether [`Self::set`] knows the key.
    pub fn has(&self, effect: &str, key: &str) -> bool {
        self.field(effect, key).is_some() || self.switch().is_some_and(|switch| switch.key == key)
    }

    /// Sets the setting of a key, and gives the index of its block, if it lies in one.
    ///
    /// # Errors
    /// An unknown key, or a value that it does not take.
    pub fn set(&mut self, effect: &str, key: &str, written: &SettingInput) -> Result<Option<usize>, SettingsError> {
        if let Some(switch) = self.switch().filter(|switch| switch.key == key) {
            self.is_off = !switch.read::<bool>(written)?;
            return Ok(None);
        }
        let known = || self.settings.iter().map(|info| &*info.key);
        let found = self.field(effect, key).map(|index| &mut self.fields[index]);
        let Some((field, (setting, kind))) = found.and_then(|field| field.setting.map(|setting| (field, setting)))
        else {
            return Err(crate::setting::unknown_key(key, known()));
        };
        let components = self.settings[setting].components(written)?;
        write(&mut self.blocks[field.block].bytes, field.offset, kind, &components);
        field.missing = None;
        Ok(Some(field.block))
    }

    /// Sets a whole uniform to bytes of its size.
    pub fn set_block(&mut self, block: usize, bytes: &[u8]) {
        self.blocks[block].bytes.copy_from_slice(bytes);
        self.fields.iter_mut().filter(|field| field.block == block).for_each(|field| field.missing = None);
    }

    /// The first member of a used uniform that has no value yet: its setting, if text can give it, and what is wrong.
    pub fn missing(&self) -> Option<(Option<&SettingInfo>, &Diagnostic)> {
        self.fields.iter().filter(|field| self.blocks[field.block].is_used).find_map(|field| {
            let setting = field.setting.map(|(setting, _)| &self.settings[setting]);
            field.missing.as_deref().map(|missing| (setting, missing))
        })
    }

    /// The present values of all settings, by their keys.
    pub fn values(&self) -> Vec<(String, SettingValue)> {
        let settings = self.fields.iter().filter_map(|field| Some((field, field.setting?)));
        settings
            .map(|(field, (setting, kind))| {
                let components = read(&self.blocks[field.block].bytes, field.offset, kind);
                (self.settings[setting].key.to_string(), kind.value(&components))
            })
            .chain(self.switch().map(|switch| (switch.key.to_string(), SettingValue::Boolean(!self.is_off))))
            .collect()
    }
}

fn write(bytes: &mut [u8], offset: usize, kind: NumberType, components: &[f64]) {
    for (slot, component) in bytes[offset..].chunks_exact_mut(4).zip(components) {
        slot.copy_from_slice(&match kind.scalar {
            Scalar::F32 => (*component as f32).to_le_bytes(),
            Scalar::I32 => (*component as i32).to_le_bytes(),
            Scalar::U32 => (*component as u32).to_le_bytes(),
        });
    }
}

fn read(bytes: &[u8], offset: usize, kind: NumberType) -> Vec<f64> {
    let words =
        bytes[offset..].chunks_exact(4).take(usize::from(kind.count)).map(|word| [word[0], word[1], word[2], word[3]]);
    let component = |word| match kind.scalar {
        // By way of its shortest text, so that 0.6 does not come back as 0.6000000238.
        Scalar::F32 => f32::from_le_bytes(word).to_string().parse().unwrap_or(f64::NAN),
        Scalar::I32 => i32::from_le_bytes(word).into(),
        Scalar::U32 => u32::from_le_bytes(word).into(),
    };
    words.map(component).collect()
}

/// Whether a member only fills space, so that it needs no value.
fn is_padding(name: &str) -> bool {
    name.starts_with("padding") || name.starts_with('_')
}

/// The type of a setting, if text can give a value of `inner`.
fn setting_type(inner: &TypeInner) -> Option<NumberType> {
    let (scalar, count) = match *inner {
        TypeInner::Scalar(scalar) => (scalar, 1),
        TypeInner::Vector { size, scalar } => (scalar, size as u8),
        _ => return None,
    };
    let scalar = match scalar {
        naga::Scalar::F32 => Scalar::F32,
        naga::Scalar::I32 => Scalar::I32,
        naga::Scalar::U32 => Scalar::U32,
        _ => return None,
    };
    Some(NumberType { scalar, count })
}

struct Reflection<'t> {
    source: Source<'t>,
    scan: &'t Scan,
    module: &'t Module,
    uniforms: Uniforms,
    path: Vec<String>,
}

impl Reflection<'_> {
    /// Adds what lies at `offset` of the last block.
    fn visit(
        &mut self,
        ty: Handle<Type>,
        offset: usize,
        declared: Option<&Declaration>,
    ) -> Result<(), Box<Diagnostic>> {
        let Type { name, inner } = &self.module.types[ty];
        let remarks = declared.map(|declared| remarks(self.source, declared)).transpose()?.unwrap_or_default();
        let kind = setting_type(inner);
        if let (None, Some(default)) = (kind, &remarks.default) {
            let message =
                "a default stands above a member that is neither a number (f32, i32, u32) nor a vector of them";
            return Err(self.source.fault(default.clone(), message));
        }
        if let TypeInner::Struct { members, .. } = inner {
            for member in members {
                let member_name = member.name.clone().unwrap_or_default();
                if is_padding(&member_name) {
                    continue;
                }
                let declared = self.scan.members.get(&(name.clone().unwrap_or_default(), member_name.clone()));
                self.path.push(member_name);
                self.visit(member.ty, offset + member.offset as usize, declared)?;
                self.path.pop();
            }
            return Ok(());
        }
        let block = self.uniforms.blocks.len() - 1;
        let member = self.path.last().cloned().unwrap_or_default();
        let place = declared.map_or(0..0, |declared| declared.name.clone());
        let Some(kind) = kind else {
            let ty = declared.map_or("?", |declared| &self.source.text[declared.ty.clone()]);
            let message = format!("`{member}` is a `{ty}`, which no setting can be");
            let note =
                "settings are f32, i32, u32 and vectors of them; a program sets others by `WgslEffect::set_uniform`";
            let missing = Some(Box::new(self.source.fault(place, message).note(note)));
            self.uniforms.fields.push(Field { path: self.path.clone(), block, offset, setting: None, missing });
            return Ok(());
        };
        let info = self.setting(kind, remarks)?;
        let missing = info.default.is_none().then(|| {
            let example =
                ["0.5", "0.5, 0.5", "0.5, 0.5, 0.5", "0.5, 0.5, 0.5, 0.5"][usize::from(kind.count - 1).min(3)];
            let example = if kind.scalar == Scalar::F32 { example.into() } else { example.replace("0.5", "1") };
            let fault = self.source.fault(place, format!("`{member}` has neither a default nor a value"));
            Box::new(fault.note(format!("a default is a line above it, such as `// = {example} in 0..1`")))
        });
        if let Some(default) = &info.default {
            // The default was parsed as a value of this type.
            let components = info.components(&default.clone().into()).unwrap_or_default();
            write(&mut self.uniforms.blocks[block].bytes, offset, kind, &components);
        }
        let setting = Some((self.uniforms.settings.len(), kind));
        self.uniforms.fields.push(Field { path: self.path.clone(), block, offset, setting, missing });
        self.uniforms.settings.push(info);
        Ok(())
    }

    /// The setting of a member, its key still missing.
    fn setting(&self, kind: NumberType, remarks: Remarks) -> Result<SettingInfo, Box<Diagnostic>> {
        let (min, max) = kind.limits();
        let mut info = SettingInfo {
            key: "".into(),
            kind: SettingType::Number(kind),
            default: None,
            min,
            max,
            choices: &[],
            unit: remarks.unit.map(Into::into),
            needs: Vec::new(),
            doc: remarks.doc.into(),
        };
        let Some(place) = remarks.default else { return Ok(info) };
        let text = &self.source.text[place.clone()];
        let fault = |message: String| {
            self.source
                .fault(place.clone(), message)
                .note("the form is `// = DEFAULT in MIN..MAX`; both ends are included")
        };
        let (default, range) = match text.split_once(" in ") {
            Some((default, range)) => (default, Some(range.trim())),
            None => (text, None),
        };
        if let Some(range) = range {
            let ends = range.split_once("..").map(|(min, max)| (bound(min), bound(max)));
            let Some((Ok(low), Ok(high))) = ends else {
                return Err(Box::new(fault(format!("`{range}` is not a range"))));
            };
            if low.zip(high).is_some_and(|(low, high)| low > high) {
                return Err(Box::new(fault(format!("`{range}` is an empty range"))));
            }
            // A type's own limits stay where the range is wider.
            info.min = low.map_or(min, |low| Some(min.map_or(low, |min| min.max(low))));
            info.max = high.map_or(max, |high| Some(max.map_or(high, |max| max.min(high))));
        }
        info.key = self.path.last().cloned().unwrap_or_default().into();
        let components = info.components(&default.into()).map_err(|error| Box::new(fault(error.to_string())))?;
        info.default = Some(kind.value(&components));
        Ok(info)
    }
}

/// An end of a range: a number, or nothing where there is no limit.
fn bound(text: &str) -> Result<Option<f64>, ()> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(None);
    }
    text.parse().ok().filter(|number: &f64| number.is_finite()).map(Some).ok_or(())
}

/// What the comments above a declaration say: `/// text, unit` and `// = default in min..max`.
fn remarks(source: Source<'_>, declared: &Declaration) -> Result<Remarks, Box<Diagnostic>> {
    let mut remarks = Remarks::default();
    let mut lines = Vec::new();
    for range in &declared.comments {
        let comment = &source.text[range.clone()][2..];
        if let Some(doc) = comment.strip_prefix('/').filter(|doc| !doc.starts_with('/')) {
            lines.push(doc.trim());
        } else if let Some(default) = comment.trim_start().strip_prefix('=').filter(|rest| !rest.starts_with('=')) {
            if remarks.default.is_some() {
                return Err(source.fault(range.clone(), "a second default stands above the same member"));
            }
            let start = range.end - default.trim_start().len();
            remarks.default = Some(start..start + default.trim().len());
        }
    }
    let doc = lines.join(" ");
    // A sentence that ends as one names no unit.
    match doc.rsplit_once(',') {
        Some((text, unit)) if !doc.ends_with('.') => {
            remarks.doc = text.trim().into();
            remarks.unit = Some(unit.trim().into()).filter(|unit: &String| !unit.is_empty());
        }
        _ => remarks.doc = doc,
    }
    Ok(remarks)
}
