// fog.background: the environment behind all surfaces is infinitely far away: nothing of it comes through, unless fog
// thins out before.
// Writes: radiance.
// Program: fog_background.

import package::view::{position_world_from_pixel, ray_direction_world_from_pixel};
import package::shaders::fog::{fog, fog_transmittance_along};

// So far that uniform fog of any density that is seen at all lets nothing through, and still a number.
const SKY_DISTANCE_M: f32 = 1e9;

@fragment
fn fs_fog_background(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let origin_world = position_world_from_pixel(position.xy, 0.0);
    let direction_world = ray_direction_world_from_pixel(position.xy);
    let transmittance = fog_transmittance_along(origin_world, direction_world, SKY_DISTANCE_M);
    return vec4f(fog.radiance * (1.0 - transmittance), 1.0 - transmittance);
}
