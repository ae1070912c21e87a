//! What the command line and the page are told of a case.

use super::{Case, ECHO, Echo};
use crate::browser::{made, turn};
use crate::step::root;
use anyhow::Result;
use serde_json::{Value, json};
use std::path::Path;

impl Case {
    /// The items that the page draws over the picture.
    ///
    /// # Errors
    /// They are no JSON.
    pub fn overlay(&self) -> Result<Value> {
        Ok(self.overlay.map_or(Ok(Value::Null), serde_json::from_str)?)
    }

    /// What is found in the picture has cases of its own and is off in nearly all others; then those of the case.
    fn all_settings(&self) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        let is_told = |key: &str| self.settings.iter().any(|(told, _)| *told == key);
        let off = ["occlusion.enabled", "reflections.enabled"].into_iter();
        let off = off.filter(move |key| !self.has_defaults && !is_told(key));
        off.map(|key| (key, "false")).chain(self.settings.iter().copied())
    }

    /// The flags of the command line.
    pub fn arguments(&self) -> Vec<String> {
        // The page draws a frame at a time, in which no light can wait for its turn.
        let mut arguments = vec!["--set".to_owned(), "shadows.spread_over_samples=false".to_owned()];
        arguments.extend(self.all_settings().flat_map(|(key, value)| ["--set".to_owned(), format!("{key}={value}")]));
        if self.is_forward {
            arguments.extend(["--path", "forward"].map(String::from));
        }
        if self.turntable > 0 {
            arguments.extend(turn::arguments(self.turntable));
        }
        if self.time_secs > 0.0 {
            arguments.extend(["--time".to_owned(), self.time_secs.to_string()]);
        }
        arguments.extend(self.camera.iter().flat_map(|name| ["--camera", name]).map(String::from));
        arguments.extend(self.variant.iter().flat_map(|name| ["--variant", name]).map(String::from));
        if self.is_dazzling {
            let flags = ["--environment", "studio", "--environment-intensity", "1000000", "--exposure", "0"];
            arguments.extend(flags.map(String::from));
        }
        arguments.extend(self.effects.iter().flat_map(|name| ["--effect", name].map(String::from)));
        if let Some(Echo { share, gain }) = self.echo {
            arguments.extend(["--effect".into(), ECHO.into()]);
            arguments.extend([
                "--set".into(),
                format!("echo.share={share}"),
                "--set".into(),
                format!("echo.gain={gain}"),
            ]);
        }
        arguments
    }

    /// The views of the frames that the page draws, if they turn.
    pub fn orbits(&self) -> Option<Value> {
        (self.turntable > 0).then(|| turn::page(self.turntable, self.frames))
    }

    /// What the page is told: options of `configure`, and effects.
    pub fn page(&self) -> Result<(Value, Value)> {
        let mut options = json!({});
        let mut settings: serde_json::Map<String, Value> = self
            .all_settings()
            .map(|(key, value)| (key.to_owned(), value.parse().unwrap_or_else(|_| value.into())))
            .collect();
        if self.is_forward {
            options["path"] = "forward".into();
        }
        if self.is_dazzling {
            options["environment"] = "studio".into();
            options["exposure"] = 0.into();
            settings.insert("environment.intensity".into(), 1e6.into());
        }
        if !settings.is_empty() {
            options["settings"] = settings.into();
        }
        let effect = |name: &&str| -> Result<Value> {
            if !name.contains('/') {
                return Ok(json!({ "name": name }));
            }
            Ok(json!({ "file": name, "source": std::fs::read_to_string(root().join(name))? }))
        };
        let mut effects: Vec<Value> = self.effects.iter().map(effect).collect::<Result<_>>()?;
        if let Some(Echo { share, gain }) = self.echo {
            let settings = json!({ "echo.share": share, "echo.gain": gain });
            effects.push(
                json!({ "file": ECHO, "source": std::fs::read_to_string(root().join(ECHO))?, "settings": settings }),
            );
        }
        Ok((options, effects.into()))
    }

    /// What the command line is given in place of the model: a stage that draws the overlay over it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn native_input(&self, input: &str) -> Result<String> {
        let Some(items) = self.overlay else { return Ok(input.to_owned()) };
        made::write_stage(self.name, input, &serde_json::from_str(items)?)
    }

    /// What the command line and the browser are given; none if this machine does not have the model.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn input(&self, assets: &Path) -> Result<Option<String>> {
        if self.settings.iter().any(|(_, value)| *value == made::CUBE) {
            made::write_cube()?;
        }
        made::write_cornell(self.model)?;
        if self.model.starts_with("demo:") {
            return Ok(Some(self.model.to_owned()));
        }
        let name = self.name;
        let path = match self.model {
            "" => assets.join(format!("khronos-sample-assets/Models/{name}/glTF-Binary/{name}.glb")),
            model if ["xtask/", "docs/", "target/"].iter().any(|start| model.starts_with(start)) => root().join(model),
            model => assets.join(model),
        };
        let whole = path.is_file().then(|| made::whole(path, name)).transpose()?;
        Ok(whole.map(|path| path.display().to_string()))
    }
}
