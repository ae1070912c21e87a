//! `RenderOptions` of the TypeScript section.

use manypass::scene::Scene;
use manypass::{Environment, Exposure, FrameRequest, LightCulling, Path, Settings, Tonemap};
use wasm_bindgen::prelude::*;

/// How frames are drawn.
#[derive(Clone, Debug, Default)]
pub struct Options {
    path: Path,
    light_culling: LightCulling,
    /// None: the studio, faint where the scene has lights.
    environment: Option<Environment>,
    tonemap: Tonemap,
    /// None: that of the scene.
    exposure: Option<Exposure>,
    light_subset: Option<(u32, u32)>,
    settings: Settings,
}

impl Options {
    /// The exposure of frames of `scene`.
    pub fn exposure(&self, scene: &Scene) -> Exposure {
        self.exposure.unwrap_or_else(|| Exposure::of_scene(scene))
    }

    /// Whether surfaces get the same light as with `other`.
    pub fn has_light_of(&self, other: &Self) -> bool {
        self.environment == other.environment
    }

    /// Puts the options, but for the exposure, into a request for a frame of `scene`.
    pub fn apply(&self, request: &mut FrameRequest, scene: &Scene) {
        request.environment = self.environment.unwrap_or_else(|| Environment::of_scene(scene));
        request.path = self.path;
        request.light_culling = self.light_culling;
        request.tonemap = self.tonemap;
        request.light_subset = self.light_subset;
        request.settings = self.settings.clone();
    }

    /// The options with what `object` holds in place of their own.
    pub fn changed(&self, object: &JsValue) -> Result<Self, JsError> {
        let mut options = self.clone();
        let Some(object) = object.dyn_ref::<js_sys::Object>() else {
            return Err(JsError::new("options are an object, such as { path: \"forward\" }"));
        };
        for entry in js_sys::Object::entries(object).iter() {
            let entry = js_sys::Array::from(&entry);
            let key = entry.get(0).as_string().unwrap_or_default();
            options.change(&key, &entry.get(1))?;
        }
        Ok(options)
    }

    fn change(&mut self, key: &str, value: &JsValue) -> Result<(), JsError> {
        if value.is_undefined() {
            return Ok(());
        }
        match key {
            "path" => self.path = choice(key, value, &[("deferred", Path::Deferred), ("forward", Path::Forward)])?,
            "lightCulling" => {
                let known = [("clustered", LightCulling::Clustered), ("none", LightCulling::None)];
                self.light_culling = choice(key, value, &known)?;
            }
            "environment" => {
                let known = [("auto", None), ("studio", Some(Environment::Studio)), ("none", Some(Environment::None))];
                self.environment = choice(key, value, &known)?;
            }
            "tonemap" => {
                let known = [
                    ("neutral", Tonemap::Neutral),
                    ("aces", Tonemap::Aces),
                    ("agx", Tonemap::Agx),
                    ("reinhard", Tonemap::Reinhard),
                    ("exponential", Tonemap::Exponential),
                    ("none", Tonemap::None),
                ];
                self.tonemap = choice(key, value, &known)?;
            }
            "exposure" if value.is_null() => self.exposure = None,
            "exposure" => {
                let text = value.as_f64().map(|stops| stops.to_string()).or_else(|| value.as_string());
                self.exposure = Some(text.unwrap_or_default().parse()?);
            }
            "lightSubset" => self.light_subset = light_subset(value)?,
            "settings" => {
                let settings = value.dyn_ref::<js_sys::Object>();
                let settings = settings.ok_or_else(|| JsError::new("settings is an object of numbers by key"))?;
                for entry in js_sys::Object::entries(settings).iter() {
                    let entry = js_sys::Array::from(&entry);
                    let key = entry.get(0).as_string().unwrap_or_default();
                    let value = entry.get(1).as_f64().map_or_else(|| "no number".to_owned(), |v| v.to_string());
                    self.settings.set(&key, &value)?;
                }
            }
            _ => return Err(JsError::new(&format!("there is no option `{key}`"))),
        }
        Ok(())
    }
}

fn light_subset(value: &JsValue) -> Result<Option<(u32, u32)>, JsError> {
    if value.is_null() {
        return Ok(None);
    }
    let pair = js_sys::Array::from(value);
    match (pair.get(0).as_f64(), pair.get(1).as_f64()) {
        (Some(k), Some(n)) if k >= 0.0 && n > k && k.fract() == 0.0 && n.fract() == 0.0 => {
            Ok(Some((k as u32, n as u32)))
        }
        _ => Err(JsError::new("lightSubset takes whole numbers [k, n] with 0 ≤ k < n, or null")),
    }
}

fn choice<T: Copy>(key: &str, value: &JsValue, known: &[(&str, T)]) -> Result<T, JsError> {
    let name = value.as_string().unwrap_or_else(|| format!("{value:?}"));
    known.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        JsError::new(&format!("{key} is `{name}`: expected {}", names.join(", ")))
    })
}
