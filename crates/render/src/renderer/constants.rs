//! What the pipelines of a view know when they are made.

use super::ask::ViewRequest;
use super::shadows::takes_one_tap;
use super::surroundings::FrameSurroundings;
use crate::decals::DECALS;
use crate::draws::WorldDraws;
use crate::environment::Environment;
use crate::environment::picture::EnvironmentTiles;
use crate::lights::{self, LightTable};
use crate::record::COUNTS_PAIRS;
use crate::shader::program::Constant;
use crate::shadows::{ShadowFilter, ViewShadows};

/// The `override` constants of a view's pipelines.
pub(super) fn constants_of(
    (asked, world): (&ViewRequest, &WorldDraws),
    table: &LightTable,
    shadows: Option<&ViewShadows>,
    (tiles, surroundings): (Option<&EnvironmentTiles>, Option<&FrameSurroundings>),
    decal_parts: u32,
) -> Vec<Constant> {
    let settings = &asked.request.settings;
    let mut constants = settings.shading.constants();
    constants.extend(settings.relief.constants());
    if settings.lod.enabled && settings.lod.lighting_m > 0.0 && asked.kind.simplifies_far_light {
        constants.push(("lambert_from", settings.lod.lighting_m.to_bits()));
    }
    constants.extend(settings.transparency.masks.constants());
    constants.push((lights::LIGHT_CLASSES, table.classes()));
    if (table.directional_count(), table.global_count()) == (1, 1) {
        constants.push(("one_directional", 1));
    }
    // In a live view cascades come and go, and pipelines would be made again.
    if asked.request.sample_count > 1
        && shadows.is_some_and(|shadows| shadows.has_one_cascade(table.directional_count()))
    {
        constants.push(("one_cascade", 1));
    }
    if asked.request.sample().0 > 0 {
        constants.push(("takes_one_texel", 1));
    }
    if settings.shadows.enabled && settings.shadows.filter == ShadowFilter::Pcss {
        constants.push(("penumbrae", 1));
    }
    if settings.shadows.enabled && settings.shadows.filter == ShadowFilter::Pcf && settings.shadows.kernel != 2 {
        constants.push(("kernel_side", settings.shadows.kernel));
    }
    if takes_one_tap(&asked.request, world, table) {
        constants.push(("takes_one_tap", 1));
    }
    if settings.shadows.has_contact() {
        constants.push(("contact_steps", settings.shadows.contact_length()));
    }
    if let Some(tiles) = tiles {
        let shows_picture = u32::from(matches!(settings.environment.source, Environment::File | Environment::Sky));
        constants.extend([("has_picture", 1), ("shows_picture", shows_picture), ("sun_count", tiles.sun_count())]);
    }
    constants.extend(asked.kind.constants);
    if let Some(surroundings) = surroundings {
        if surroundings.count > 0 {
            constants.push(("surrounding_count", surroundings.count));
        }
        constants.extend(surroundings.probes.constants());
    }
    if decal_parts > 0 {
        constants.push((DECALS, decal_parts));
    }
    if asked.counts_pairs {
        constants.push(COUNTS_PAIRS);
    }
    constants
}
