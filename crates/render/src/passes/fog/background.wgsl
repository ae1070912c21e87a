// fog.background: the environment behind all surfaces is infinitely far away: nothing of it comes through.
// Writes: radiance.
// Program: fog_background.

import package::shaders::fog::fog;

@fragment
fn fs_fog_background() -> @location(0) vec4f {
    return vec4f(fog.radiance, 0.0);
}
