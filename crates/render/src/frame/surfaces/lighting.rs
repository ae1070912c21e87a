//! Light of opaque surfaces: of the environment, and of lights in the way that the settings name.

use crate::gbuffer::Gbuffer;
use crate::lights::LightCulling;
use crate::passes::direct::Lights;
use crate::passes::{direct, indirect, tile_depth, volumes};
use crate::record::Recorder;
use crate::screen_space::ScreenSpaceEffects;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use manypass_graph::Handle;

/// All light that reaches opaque surfaces from the environment, and from lights in the way that the settings name. Also
/// gives depth.
pub(super) fn light_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    gbuffer: &Gbuffer,
    effects: ScreenSpaceEffects<'_>,
    depth: Handle,
    radiance: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    match settings.lights.culling {
        LightCulling::Clustered | LightCulling::None => {
            Ok((surface_light_passes(r, &Lights::Clusters, gbuffer, effects, &depth, radiance)?, depth))
        }
        LightCulling::Tiled => {
            let tile_depth = tile_depth::record(r, &gbuffer.linear_depth)?;
            Ok((surface_light_passes(r, &Lights::Tiles(&tile_depth), gbuffer, effects, &depth, radiance)?, depth))
        }
        LightCulling::Volumes | LightCulling::VolumesStencil => {
            let radiance = surface_light_passes(r, &Lights::Global, gbuffer, effects, &depth, radiance)?;
            volumes::record(r, gbuffer, depth, radiance)
        }
    }
}

/// Light of the environment and of `lights`: in one pass, which reads the G-buffer once for both, where one of them
/// reaches every pixel.
fn surface_light_passes(
    r: &mut Recorder<'_, '_>,
    lights: &Lights<'_>,
    gbuffer: &Gbuffer,
    effects: ScreenSpaceEffects<'_>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let is_apart = !lights.adds_ambient(r) && !r.view.counts_pairs();
    let radiance = if is_apart { indirect::record(r, gbuffer, effects, depth, radiance)? } else { radiance };
    direct::record(r, lights, gbuffer, effects, depth, radiance)
}
