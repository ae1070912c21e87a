//! Settings of the whole frame, composed from those that each pass declares in its own folder. `passes/checks.rs` says
//! which go together.

mod effect;
mod quality;

pub use crate::setting::{
    Group, LinearColor, NumberType, Scalar, SettingField, SettingInfo, SettingInput, SettingType, SettingValue,
    SettingsError, SettingsFile, Switch, schema,
};

use crate::diagnostic::Diagnostic;
use crate::passes::upscale::UpscaleMethod;
use crate::setting::unknown_key;
use manypass_scene::renamed::{NameKind, current, renamed};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Makes [`Settings`] of lines `group: Type`; keys are `group.field`. The types can be named from here.
macro_rules! compose {
    ($($group:ident: $($segment:ident)::+,)*) => {
        $(pub use $($segment)::+;)*

        /// Every setting, with its value, in groups. Start from the defaults and assign fields: later versions have more.
        ///
        /// ```
        /// let mut settings = manypass::Settings::default();
        /// settings.occlusion.radius_m = 0.3;
        /// settings.set("tone_map.curve", "agx")?;
        /// # Ok::<(), manypass::SettingsError>(())
        /// ```
        #[derive(Clone, Debug, Default, PartialEq, Serialize)]
        #[non_exhaustive]
        pub struct Settings {
            $(#[doc = concat!("The settings whose keys begin with `", stringify!($group), ".`.")] pub $group: $($segment)::+,)*
        }

        impl Settings {
            fn every_group() -> Vec<SettingInfo> {
                let groups = [$((stringify!($group), <$($segment)::+ as Group>::declared())),*];
                let of_group = |(name, infos): (&str, Vec<SettingInfo>)| {
                    infos.into_iter().map(|info| info.of_group(name)).collect::<Vec<_>>()
                };
                groups.into_iter().flat_map(of_group).collect()
            }

            fn group(&mut self, name: &str) -> Option<&mut dyn Group> {
                match name {
                    $(stringify!($group) => Some(&mut self.$group),)*
                    _ => None,
                }
            }
        }
    };
}

compose! {
    quality: crate::settings::quality::QualitySettings,
    render: crate::render_settings::RenderSettings,
    camera: crate::camera_settings::CameraSettings,
    environment: crate::environment::EnvironmentSettings,
    background: crate::passes::background::BackgroundSettings,
    ground: crate::ground::GroundSettings,
    captures: crate::capture_settings::CaptureSettings,
    exposure: crate::exposure::ExposureSettings,
    fog: crate::fog::FogSettings,
    lights: crate::lights::LightSettings,
    lod: crate::levels::LodSettings,
    textures: crate::resources::TextureSettings,
    relief: crate::relief_settings::ReliefSettings,
    msaa: crate::passes::resolve::MultisamplingSettings,
    clusters: crate::lights::ClusterSettings,
    shading: crate::shading_settings::ShadingSettings,
    shadows: crate::shadows::ShadowSettings,
    occlusion: crate::passes::occlusion::OcclusionSettings,
    reflections: crate::passes::reflections::ReflectionSettings,
    gi: crate::passes::gi::GiSettings,
    taa: crate::passes::taa::TaaSettings,
    upscale: crate::passes::upscale::UpscaleSettings,
    adaptive: crate::passes::adaptive::AdaptiveSettings,
    transparency: crate::transparency::TransparencySettings,
    aov: crate::aov::AovSettings,
    effects: crate::settings::effect::EffectSettings,
    tone_map: crate::passes::tone_map::ToneMapSettings,
    debug: crate::passes::debug::DebugSettings,
}

/// A map of groups, each a map of its fields. What is left out has its default. An older key sets what it is called now,
/// unless that stands there as well.
impl<'de> Deserialize<'de> for Settings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let groups = BTreeMap::<String, BTreeMap<String, SettingInput>>::deserialize(deserializer)?;
        let mut settings = Self::default();
        let mut written = Vec::new();
        for (group, fields) in groups {
            if settings.group(&group).is_none() {
                let known = Self::declared().iter().filter_map(|info| Some(info.key.split_once('.')?.0));
                return Err(D::Error::custom(unknown_key(&group, known)));
            }
            written.extend(fields.into_iter().map(|(field, value)| (format!("{group}.{field}"), value)));
        }
        written.sort_by_key(|(key, _)| renamed(NameKind::Setting, key).is_none());
        for (key, value) in &written {
            settings.give(key, value).map_err(D::Error::custom)?;
        }
        Ok(settings)
    }
}

/// The short name of a setting, at the top of a file and on the command line, and its key.
const CHAIN: (&str, &str) = ("chain", "effects.chain");

impl Settings {
    /// The chain of effects that `written` finds under one of the two names of that setting.
    pub fn chain_of<'w>(written: impl Fn(&str) -> Option<&'w SettingInput>) -> Option<Vec<String>> {
        let written = written(CHAIN.0).or_else(|| written(CHAIN.1))?;
        // What is no list of texts is told where all settings are read.
        <Vec<String> as SettingField>::read(written)
    }

    /// The chain of effects of a file, if it has one.
    ///
    /// # Errors
    /// It stands there under both of its names.
    pub fn chain_of_file(file: &SettingsFile) -> Result<Option<Vec<String>>, Box<Diagnostic>> {
        let message = format!("the chain of effects stands here and as `{}` as well; leave one of them out", CHAIN.0);
        match file.refusal(CHAIN.1, None, message).filter(|_| file.last(CHAIN.0).is_some()) {
            Some(twice) => Err(twice),
            None => Ok(Self::chain_of(|key| file.last(key))),
        }
    }

    /// What is wrong with the entry `name` of the chain of a file, with its place there.
    pub fn refusal_in_chain(file: &SettingsFile, name: &str, message: &str) -> Option<Box<Diagnostic>> {
        [CHAIN.0, CHAIN.1].into_iter().find_map(|key| file.refusal(key, Some(name), message))
    }

    /// Every setting there is, beside those of effects.
    pub fn declared() -> &'static [SettingInfo] {
        static DECLARED: LazyLock<Vec<SettingInfo>> = LazyLock::new(Settings::every_group);
        &DECLARED
    }

    /// Sets `key` to `value`, both as text; commas stand between the numbers of a vector and the entries of a list.
    ///
    /// # Errors
    /// An unknown key, or a value of another type or outside its range.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), SettingsError> {
        self.give(key, &value.into())
    }

    /// Sets `key`, or what an older key is called now, to what was written on the command line or in a file.
    ///
    /// # Errors
    /// An unknown key, or a value of another type or outside its range.
    pub fn give(&mut self, key: &str, written: &SettingInput) -> Result<(), SettingsError> {
        let key = if key == CHAIN.0 { CHAIN.1 } else { current(NameKind::Setting, key) };
        let info = Self::declared().iter().find(|info| info.key == key);
        let group = key.split_once('.').and_then(|(group, field)| Some((self.group(group)?, field)));
        match (info, group) {
            (Some(info), Some((group, field))) => group.give(field, info, written),
            _ => Err(unknown_key(key, Self::declared().iter().map(|info| &*info.key))),
        }
    }

    /// Switches anti-aliasing over time off unless it is allowed, and what needs it.
    pub(crate) fn allow_taa(&mut self, is_allowed: bool) {
        if self.taa.enabled && !is_allowed {
            self.taa.enabled = false;
            if self.upscale.method == UpscaleMethod::Temporal {
                self.upscale.method = UpscaleMethod::Edges;
            }
        }
    }

    /// Reads settings from TOML; what it does not name keeps its default. `file` appears in errors.
    ///
    /// # Errors
    /// Text that is not TOML, an unknown key, or a value outside its range; with file, line and column.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, SettingsError> {
        let mut settings = Self::default();
        SettingsFile::parse(file, text)?.apply(|key, written| settings.give(key, written))?;
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use crate::render_settings::Path;
    use manypass_scene::renamed::RENAMED;

    #[test]
    fn every_setting_takes_its_default_and_is_well_described() {
        let mut settings = Settings::default();
        for info in Settings::declared() {
            settings.set(&info.key, &info.default.as_ref().unwrap().to_string()).unwrap();
            assert!(info.doc.ends_with('.'), "{}: a sentence", info.key);
            for needs in &info.needs {
                let (key, value) = needs.split_once('=').unwrap();
                Settings::default().set(key, value).unwrap();
            }
        }
        assert_eq!(settings, Settings::default());
        let json = serde_json::to_value(&settings).unwrap();
        assert_eq!(serde_json::from_value::<Settings>(json.clone()).unwrap(), settings);
        assert_eq!(json["clusters"], serde_json::json!({ "tile_px": 16, "slices": 32 }));
        for (wrong, expected) in [
            (r#"{ "cluster": { "slices": 4 } }"#, "did you mean `clusters`?"),
            (r#"{ "clusters": { "slice": 4 } }"#, "did you mean `clusters.slices`?"),
            (r#"{ "clusters": { "slices": 99 } }"#, "which takes a whole number from 1 to 64"),
        ] {
            let error = serde_json::from_str::<Settings>(wrong).unwrap_err().to_string();
            assert!(error.contains(expected), "{wrong}: {error}");
        }
    }

    #[test]
    fn older_keys_set_what_they_are_called_now() {
        for row in RENAMED.iter().filter(|row| row.kind == NameKind::Setting) {
            let info = Settings::declared().iter().find(|info| info.key == row.name).expect(row.name);
            assert!(Settings::declared().iter().all(|info| info.key != row.older), "{row}");
            let other = match info.kind {
                SettingType::Boolean => (info.default != Some(SettingValue::Boolean(true))).to_string(),
                ref kind => panic!("say here what `{}` takes beside its default: {kind}", row.name),
            };
            let [mut older, mut now] = [Settings::default(), Settings::default()];
            older.set(row.older, &other).unwrap();
            now.set(row.name, &other).unwrap();
            assert!(older == now && now != Settings::default(), "{row}");
            let file = |key: &str| SettingsFile::parse("a.toml", &format!("{key} = {other}")).unwrap();
            assert_eq!((file(row.older).older_names(), file(row.name).older_names()), (vec![row], Vec::new()));
            let json = |keys: &[(&str, &str)]| {
                let fields = keys.iter().map(|(key, value)| {
                    let field = key.split_once('.').unwrap().1;
                    format!("\"{field}\": {value}")
                });
                let group = row.name.split_once('.').unwrap().0;
                let text = format!("{{ \"{group}\": {{ {} }} }}", fields.collect::<Vec<_>>().join(", "));
                serde_json::from_str::<Settings>(&text).unwrap()
            };
            assert!(json(&[(row.older, &*other)]) == now, "{row}");
            let default = info.default.as_ref().unwrap().to_string();
            assert!(json(&[(row.name, &*other), (row.older, &*default)]) == now, "{row}: today's name counts");
            let error = older.set(row.older, "many").unwrap_err().to_string();
            assert!(error.starts_with(&format!("`many` is not a value of `{}`", row.name)), "{error}");
        }
    }

    #[test]
    fn refusals_name_the_nearest_key_and_the_range() {
        let mut settings = Settings::default();
        assert_eq!(
            settings.set("cluster.slice", "4").unwrap_err().to_string(),
            "no setting is called `cluster.slice`; did you mean `clusters.slices`?"
        );
        let nearest = settings.set("dither", "1").unwrap_err().to_string();
        assert!(nearest.contains("`tone_map.dither`?"), "{nearest}");
        for (key, expected) in [
            ("tonemap", Some("tone_map.curve")),
            ("exposure", Some("exposure.stops")),
            ("own_pass.x", None),
            ("", None),
        ] {
            let SettingsError::UnknownKey { nearest, .. } = settings.set(key, "1").unwrap_err() else {
                panic!("{key}")
            };
            assert_eq!(nearest.as_deref(), expected, "{key}");
        }
        let error = settings.set("render.scale", "9").unwrap_err().to_string();
        assert!(error.contains("takes a number from 0.25 to 2"), "{error}");
        let error = settings.set("clusters.slices", "1.5").unwrap_err().to_string();
        assert!(error.contains("takes a whole number from 1 to 64"), "{error}");
        let error = settings.set("render.path", "deferrd").unwrap_err().to_string();
        assert!(error.contains("takes deferred, forward, forward-batched or gouraud"), "{error}");
        let error = settings.set("environment.source", "12345").unwrap_err().to_string();
        assert!(error.contains("studio") && error.contains("a colour such as ff8800"), "{error}");
    }

    #[test]
    fn samples_of_pixels_are_one_or_four_and_of_one_path() {
        let mut settings = Settings::default();
        for number in ["3", "2", "0", "8", "1.5", "four"] {
            let error = settings.set("msaa.samples", number).unwrap_err().to_string();
            assert_eq!(error, format!("`{number}` is not a value of `msaa.samples`, which takes 1 or 4"));
        }
        settings.set("msaa.samples", "4").unwrap();
        for path in Path::NAMES {
            settings.set("render.path", path).unwrap();
            let error = settings.check().err().map(|error| error.to_string());
            let expected = format!("`msaa.samples=4` needs `render.path=forward`, which is `{path}`");
            assert_eq!(error, (*path != "forward").then_some(expected));
        }
        settings.set("msaa.samples", "1").unwrap();
        assert_eq!(settings.check(), Ok(()));
        settings.set("occlusion.enabled", "true").unwrap();
        let error = settings.check().unwrap_err().to_string();
        assert_eq!(error, "`occlusion.enabled=true` needs `render.path=deferred`, which is `gouraud`");
        settings.set("render.path", "forward-batched").unwrap();
        assert_eq!(settings.check(), Ok(()));
        settings.set("render.path", "gouraud").unwrap();
        settings.set("occlusion.enabled", "false").unwrap();
        settings.set("reflections.enabled", "true").unwrap();
        let error = settings.check().unwrap_err().to_string();
        assert_eq!(error, "`reflections.enabled=true` needs `render.path=deferred`, which is `gouraud`");
        settings.set("render.path", "deferred").unwrap();
        assert_eq!(settings.check(), Ok(()));
        let read = |text| Settings::from_toml("my.toml", text).map_err(|error| error.to_string());
        assert_eq!(read("[msaa]\nsamples = 4").unwrap().msaa.samples.count(), 4);
        let error = read("[msaa]\nsamples = \"4\"").unwrap_err();
        assert!(error.contains("which takes 1 or 4; write it without quotes"), "{error}");
    }

    #[test]
    fn files_are_refused_with_the_place() {
        let read = |text| Settings::from_toml("my.toml", text).map_err(|error| error.to_string());
        assert!(read("[render]\nscale = 0.5").unwrap().render.scale == 0.5);
        assert!(read("render.scale = 0.5").unwrap().render.scale == 0.5);
        let curve = read("[tone_map]\ncurve = \"aces\"").unwrap().tone_map.curve;
        assert_eq!(curve, crate::Tonemap::Aces);
        for (text, expected) in [
            (
                "[render]\nscael = 0.5",
                "my.toml:2:1: error: no setting is called `render.scael`; did you mean `render.scale`?",
            ),
            (
                "\n[render]\n  scale = 9",
                "my.toml:3:11: error: `9` is not a value of `render.scale`, which takes a number from",
            ),
            ("scale = 1", "my.toml:1:1: error: no setting is called `scale`; did you mean `render.scale`?"),
            ("[render]\nscale = [1, 2]", "my.toml:2:9: error: `[1,2]` is not a value of `render.scale`"),
            ("[render]\nscale = 1979-05-27", "my.toml:2:9: error: `1979-05-27` is not a value of"),
            ("[tone_map]\ndither = 1\n[render]\nscale = ", "my.toml:4:"),
            ("[clusters]\nslices = 4\nslices = 5", "my.toml:3:"),
            ("[clusters]\ntile_px = 1\nslices = 99", "my.toml:2:11: error: `1` is not a value"),
            (
                "[render]\npath = \"foward\"",
                "my.toml:2:8: error: `foward` is not a value of `render.path`, which takes",
            ),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(expected), "{text}\n{error}\nshould begin {expected}");
        }
    }
}
