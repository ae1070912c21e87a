//! The effects that come with the renderer: files like everybody's.

use super::EffectFile;
use crate::shader::program::ProgramError;
use manypass_scene::spelling;

/// Their names and texts.
const LIBRARY: [(&str, &str); 13] = [
    ("bloom", include_str!("../../effects/bloom.wgsl")),
    ("blur", include_str!("../../effects/blur.wgsl")),
    ("dof", include_str!("../../effects/dof.wgsl")),
    ("film", include_str!("../../effects/film.wgsl")),
    ("fxaa", include_str!("../../effects/fxaa.wgsl")),
    ("glow", include_str!("../../effects/glow.wgsl")),
    ("grade", include_str!("../../effects/grade.wgsl")),
    ("lens", include_str!("../../effects/lens.wgsl")),
    ("motion_blur", include_str!("../../effects/motion_blur.wgsl")),
    ("outline", include_str!("../../effects/outline.wgsl")),
    ("sharpen", include_str!("../../effects/sharpen.wgsl")),
    ("smaa", include_str!("../../effects/smaa.wgsl")),
    ("toon", include_str!("../../effects/toon.wgsl")),
];

/// The name and the text of one of them.
pub(super) fn text_of(name: &str) -> Option<(&'static str, &'static str)> {
    LIBRARY.into_iter().find(|(known, _)| *known == name)
}

impl EffectFile {
    /// The names of the effects that come with the renderer; docs/effects.md says what each does.
    pub fn built_in_names() -> impl Iterator<Item = &'static str> {
        LIBRARY.iter().map(|(name, _)| *name)
    }

    /// What is said of a name that no effect has: of those that come with the renderer, and of `others`.
    pub fn unknown_name<'n>(name: &str, others: impl Iterator<Item = &'n str>) -> String {
        if name.is_empty() {
            return "a name of an effect is missing".into();
        }
        let built_in = LIBRARY.iter().map(|(name, _)| -> &'n str { name });
        let nearest = spelling::nearest(name, built_in.chain(others));
        let suggestion = nearest.map(|nearest| format!("; did you mean `{nearest}`?")).unwrap_or_default();
        format!("no effect is called `{name}`{suggestion}")
    }

    /// Whether an effect of this name comes with the renderer.
    pub fn is_built_in(name: &str) -> bool {
        Self::built_in_names().any(|known| known == name)
    }

    /// The effect of this name that comes with the renderer; none if there is none.
    ///
    /// # Errors
    /// As [`Self::parse`], which a test rules out.
    pub fn built_in(name: &str) -> Option<Result<Self, ProgramError>> {
        let (name, text) = text_of(name)?;
        Some(Self::parse(name, text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::back::glsl;

    /// Translates every entry point of an effect.
    fn assert_webgl2_takes(effect: &EffectFile) {
        let version = glsl::Version::Embedded { version: 300, is_webgl: true };
        let options = glsl::Options { version, ..Default::default() };
        let (name, module) = (effect.name(), &effect.module);
        let mut validator = naga::valid::Validator::new(Default::default(), naga::valid::Capabilities::empty());
        let info = validator.validate(module).unwrap_or_else(|error| panic!("{name}: {error:?}"));
        assert!(!module.entry_points.is_empty(), "{name}");
        for entry in &module.entry_points {
            let entry_point = entry.name.clone();
            let pipeline = glsl::PipelineOptions { shader_stage: entry.stage, entry_point, multiview: None };
            let mut text = String::new();
            let written = glsl::Writer::new(&mut text, module, &info, &options, &pipeline, Default::default())
                .and_then(|mut writer| writer.write());
            let textures = written.unwrap_or_else(|error| panic!("{name}.{}: {error}", entry.name)).texture_mapping;
            assert!(textures.len() <= 16, "{name}.{}", entry.name);
        }
    }

    #[test]
    fn built_in_effects_become_shaders_of_webgl2() {
        for name in EffectFile::built_in_names() {
            let effect = EffectFile::built_in(name).expect("a name of the library").expect("a valid text");
            assert_webgl2_takes(&effect);
            assert!(effect.warnings().is_empty(), "{:?}", effect.warnings());
        }
    }

    #[test]
    fn the_effects_of_the_documents_become_shaders_of_webgl2() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/examples/effects");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).expect("the documents") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|ending| ending == "wgsl") {
                let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
                let text = std::fs::read_to_string(&path).expect("a text");
                let effect = EffectFile::parse(name, &text).unwrap_or_else(|error| panic!("{error}"));
                assert_webgl2_takes(&effect);
                assert!(effect.warnings().is_empty(), "{:?}", effect.warnings());
                count += 1;
            }
        }
        assert!(count >= 12, "{count} effects");
    }
}
