//! The passes of the frame, one folder each. No pass imports another; outputs reach their consumers as arguments.

pub mod accumulate;
pub mod adaptive;
pub mod background;
mod checks;
pub mod coverage;
pub mod debug;
pub mod direct;
pub mod emission;
pub mod environment;
pub mod fisheye;
pub mod fog;
pub mod forward;
pub mod geometry;
pub mod gi;
pub mod glass;
pub mod gouraud;
pub mod ground;
pub mod ids;
pub mod indirect;
pub mod linear_depth;
pub mod meter;
pub mod mips;
pub mod mirrors;
pub mod motion;
pub mod nearest;
pub mod occlusion;
pub mod overlay;
pub mod particles;
pub mod portals;
pub mod present;
pub mod probe_capture;
pub mod probes;
pub mod reflections;
pub mod resolve;
pub mod scrub;
pub mod shadows;
pub mod taa;
pub mod tile_depth;
pub mod tone_map;
pub mod transmittance;
pub mod transparency;
pub mod upscale;
pub mod volumes;
pub mod water;

use crate::pass_info::{PassInfo, Reach};
use crate::settings::Settings;

/// A pass in the list of all.
pub(crate) struct Pass {
    /// What it says of itself.
    pub info: PassInfo,
    /// How far it looks under these settings; none if they switch it off.
    pub reach: fn(&Settings) -> Option<Reach>,
}

impl Pass {
    /// A pass that looks at its own pixel alone, or is not part of a still's samples.
    const fn of_own_pixel(info: PassInfo) -> Self {
        Self { info, reach: |_| Some(Reach::OwnPixel) }
    }
}

/// Every pass. What a setting decides is declared in the pass's folder; here stands which setting that is.
pub(crate) static PASSES: &[Pass] = &[
    Pass::of_own_pixel(accumulate::PASS),
    Pass::of_own_pixel(adaptive::PASS),
    Pass::of_own_pixel(background::PASS),
    Pass::of_own_pixel(coverage::PASS),
    Pass::of_own_pixel(debug::PASS),
    Pass::of_own_pixel(direct::PASS),
    Pass::of_own_pixel(emission::PASS),
    Pass::of_own_pixel(environment::PASS),
    Pass { info: fisheye::PASS, reach: |all| fisheye::reach(all.camera.fisheye) },
    Pass { info: fog::PASS, reach: |all| fog::reach(&all.fog) },
    Pass::of_own_pixel(forward::PASS),
    Pass::of_own_pixel(geometry::PASS),
    Pass { info: gi::PASS, reach: |all| gi::reach(&all.gi) },
    Pass::of_own_pixel(glass::PASS),
    Pass::of_own_pixel(gouraud::PASS),
    Pass::of_own_pixel(ground::PASS),
    Pass::of_own_pixel(ids::PASS),
    Pass::of_own_pixel(indirect::PASS),
    Pass::of_own_pixel(linear_depth::PASS),
    Pass::of_own_pixel(meter::PASS),
    Pass::of_own_pixel(mips::PASS),
    Pass::of_own_pixel(mirrors::PASS),
    Pass::of_own_pixel(motion::PASS),
    Pass::of_own_pixel(nearest::PASS),
    Pass { info: occlusion::PASS, reach: |all| occlusion::reach(&all.occlusion) },
    Pass::of_own_pixel(overlay::PASS),
    Pass::of_own_pixel(particles::PASS),
    Pass::of_own_pixel(portals::PASS),
    Pass::of_own_pixel(present::PASS),
    Pass::of_own_pixel(probe_capture::PASS),
    Pass::of_own_pixel(probes::PASS),
    Pass { info: reflections::PASS, reach: |all| reflections::reach(&all.reflections) },
    Pass { info: resolve::PASS, reach: |all| resolve::reach(&all.msaa) },
    Pass::of_own_pixel(scrub::PASS),
    Pass { info: shadows::PASS, reach: |all| shadows::reach(&all.shadows) },
    Pass { info: taa::PASS, reach: |all| taa::reach(&all.taa) },
    Pass::of_own_pixel(tile_depth::PASS),
    Pass { info: tone_map::PASS, reach: |all| Some(tone_map::reach(all.render.scale)) },
    Pass::of_own_pixel(transmittance::PASS),
    Pass::of_own_pixel(transparency::PASS),
    Pass::of_own_pixel(upscale::PASS),
    Pass::of_own_pixel(volumes::PASS),
    Pass::of_own_pixel(water::PASS),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use crate::aov::Aov;
    use crate::quality::Quality;
    use std::collections::BTreeSet;

    /// Those settings with a pass switched off as it says.
    fn without(settings: &Settings, off: &str) -> Settings {
        let (key, value) = off.split_once('=').unwrap();
        let mut settings = settings.clone();
        settings.set(key, value).unwrap();
        settings
    }

    #[test]
    fn every_folder_is_a_pass_that_says_what_it_is() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/passes");
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
        let folders = entries.filter(|entry| entry.path().is_dir());
        let folders: BTreeSet<String> = folders.map(|entry| entry.file_name().into_string().unwrap()).collect();
        let listed: BTreeSet<String> = PASSES.iter().map(|pass| pass.info.name.to_owned()).collect();
        assert_eq!(listed, folders, "`PASSES` has a line for each folder, and its `PASS` the folder's name");
        assert_eq!(PASSES.len(), listed.len(), "a line each");
    }

    #[test]
    fn passes_are_in_the_tiers_that_they_name() {
        for Pass { info, .. } in PASSES {
            let known = info.tiers.iter().all(|tier| Quality::named(tier).is_some());
            assert!(known, "{}: {:?}", info.name, info.tiers);
            for tier in Quality::NAMES {
                let mut settings = Settings::default();
                settings.apply_quality(Quality::named(tier).unwrap()).unwrap();
                let is_on = info.off.is_none_or(|off| without(&settings, off) != settings);
                assert_eq!(info.tiers.contains(tier), is_on, "{} in {tier}", info.name);
            }
        }
    }

    #[test]
    fn what_switches_a_pass_off_leaves_no_reach() {
        let mut settings = Settings::default();
        for (key, value) in [
            ("occlusion.enabled", "true"),
            ("reflections.enabled", "true"),
            ("gi.enabled", "true"),
            ("taa.enabled", "true"),
            ("fog.mode", "exponential"),
            ("fog.scattering", "1"),
            ("shadows.contact_m", "0.1"),
            ("msaa.samples", "4"),
            ("camera.fisheye", "equidistant"),
        ] {
            settings.set(key, value).unwrap();
        }
        let looks_around = |reach: Option<Reach>| reach.is_some_and(|reach| reach != Reach::OwnPixel);
        let around: Vec<_> = PASSES.iter().filter(|pass| looks_around((pass.reach)(&settings))).collect();
        let names: Vec<_> = around.iter().map(|pass| pass.info.name).collect();
        assert_eq!(names, ["fisheye", "fog", "gi", "occlusion", "reflections", "resolve", "shadows", "taa"]);
        for Pass { info, reach } in around {
            assert_eq!(reach(&without(&settings, info.off.unwrap())), None, "{}", info.name);
        }
        let default = Settings::default();
        assert!(PASSES.iter().all(|pass| (pass.reach)(&default) != Some(Reach::EverySample)));
    }

    #[test]
    fn every_variable_is_of_a_pass() {
        let of_passes: Vec<&str> = PASSES.iter().flat_map(|pass| pass.info.variables).copied().collect();
        for aov in Aov::ALL {
            assert_eq!(of_passes.iter().filter(|name| **name == aov.name()).count(), 1, "{}", aov.name());
        }
        assert_eq!(of_passes.len(), Aov::ALL.len(), "{of_passes:?}");
    }
}
