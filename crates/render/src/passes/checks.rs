//! Which settings go together: what the passes that they switch on need of each other and of the path.

use super::debug::DebugView;
use super::upscale::UpscaleMethod;
use super::{PASSES, Pass};
use crate::camera_settings::Fisheye;
use crate::pass_info::PassInfo;
use crate::render_settings::Path;
use crate::setting::SettingsError;
use crate::settings::Settings;

impl Settings {
    /// Checks what no setting knows alone: whether they go together.
    ///
    /// # Errors
    /// Multisampling, ambient occlusion or another screen-space pass on a path that lacks it. A lens that cannot be. A
    /// pass or lens that fisheye pictures lack.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.camera.check()?;
        self.exposure.check()?;
        let path = self.render.path;
        if self.msaa.samples.count() > 1 && path != Path::Forward {
            let key = format!("msaa.samples={}", self.msaa.samples.count());
            return Err(SettingsError::Needs { key, needs: "render.path=forward", found: path.name() });
        }
        if let Some((group, _)) = self.switched_passes().find(|(_, info)| !info.paths.contains(&path)) {
            let key = format!("{group}.enabled=true");
            return Err(SettingsError::Needs { key, needs: "render.path=deferred", found: path.name() });
        }
        if self.shadows.contact_m > 0.0 && path != Path::Deferred {
            let key = format!("shadows.contact_m={}", self.shadows.contact_m);
            return Err(SettingsError::Needs { key, needs: "render.path=deferred", found: path.name() });
        }
        if self.upscale.method == UpscaleMethod::Temporal && !self.taa.enabled {
            let key = format!("upscale.method={}", self.upscale.method.name());
            return Err(SettingsError::Needs { key, needs: "taa.enabled=true", found: "false" });
        }
        if self.camera.fisheye != Fisheye::None {
            let key = format!("camera.fisheye={}", self.camera.fisheye.name());
            let view = self.debug.view;
            let pass = self.switched_passes().find(|(_, info)| !info.in_fisheye);
            let needs = pass.and_then(|(_, info)| info.off);
            let refused = [
                (needs.is_some(), needs.unwrap_or_default(), "true"),
                (self.shadows.contact_m > 0.0, "shadows.contact_m=0", "above 0"),
                (self.camera.f_stop > 0.0, "camera.f_stop=0", "above 0"),
                (view != DebugView::Off, "debug.view=off", view.name()),
            ];
            if let Some((_, needs, found)) = refused.into_iter().find(|(is_refused, ..)| *is_refused) {
                return Err(SettingsError::Needs { key, needs, found });
            }
        }
        Ok(())
    }

    /// Passes that are on and that a setting `enabled` switches off, with the group of that setting.
    fn switched_passes(&self) -> impl Iterator<Item = (&'static str, &'static PassInfo)> {
        let is_on = |pass: &&Pass| (pass.reach)(self).is_some();
        let key = |pass: &'static Pass| Some((pass.info.off?.strip_suffix(".enabled=false")?, &pass.info));
        PASSES.iter().filter(is_on).filter_map(key)
    }
}
