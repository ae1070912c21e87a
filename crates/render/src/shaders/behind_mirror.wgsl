// The picture of what is behind a flat mirror, from the eye that is mirrored in it, and where rays meet what it shows.
// In the space of the eye the world behind the mirror is as far away as what it is the image of: a ray that is reflected
// goes on straight there.

import package::view::view;
import package::shaders::samplers::nearest_clamp;
import package::shaders::screen_space::FARTHEST_M;
import package::shaders::shading::linear_clamp;

struct Mirror {
    // The plane's unit normal in view space, towards the eye; the mirror's object.
    normal_view: vec3f,
    object: u32,
    // The offset of the sample within the pixels of the view behind it.
    jitter_ndc: vec2f,
    // 1 / its width and height in pixels.
    inverse_size_px: vec2f,
    // Half its extent in view space, as that of the view.
    view_from_ndc_scale: vec2f,
    // 1 / the number of rays of which a pixel shows the mean.
    share_of_ray: f32,
    padding: f32,
}

@group(1) @binding(5) var<uniform> mirror: Mirror;
@group(1) @binding(7) var behind_radiance: texture_2d<f32>;
@group(1) @binding(8) var behind_distances: texture_2d<f32>;

// How often a ray looks again where it meets what is behind the mirror.
const LOOKS: u32 = 4u;

// Where a ray meets what is behind: the place in the picture, how long the ray is, and how wide a pixel is there.
struct Meeting {
    uv: vec2f,
    length_m: f32,
    pixel_m: f32,
}

fn behind_uv(position: vec3f) -> vec2f {
    let plane = position.xy / mix(max(-position.z, 1e-6), 1.0, view.orthographic);
    return (plane / mirror.view_from_ndc_scale + mirror.jitter_ndc) * vec2f(0.5, -0.5) + 0.5;
}

// What the view behind shows at a place, as far away as it lies.
fn behind_position(uv: vec2f) -> vec3f {
    let distance_m = min(textureSampleLevel(behind_distances, nearest_clamp, uv, 0.0).r, FARTHEST_M);
    let plane = (vec2f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0) - mirror.jitter_ndc) * mirror.view_from_ndc_scale;
    return vec3f(plane * mix(distance_m, 1.0, view.orthographic), -distance_m);
}

// Radiance of a level, less the mark of what glows.
fn behind_radiance_at(uv: vec2f, level: f32) -> vec3f {
    return textureSampleLevel(behind_radiance, linear_clamp, uv, level).rgb;
}

// Where a ray that leaves a point of the mirror meets what is behind it; `image` is its direction there.
fn meeting_behind(position: vec3f, image: vec3f) -> Meeting {
    var length_m = length(behind_position(behind_uv(position)) - position);
    for (var look = 0u; look < LOOKS; look++) {
        let uv = clamp(behind_uv(position + image * length_m), vec2f(0.0), vec2f(1.0));
        let found = behind_position(uv) - position;
        length_m = max(dot(found, image), 1e-4 * length(found));
    }
    let met = position + image * length_m;
    let away_m = max(-met.z, 1e-6);
    let pixel_m = mix(away_m, 1.0, view.orthographic) * 2.0 * mirror.view_from_ndc_scale.y * mirror.inverse_size_px.y;
    return Meeting(clamp(behind_uv(met), vec2f(0.0), vec2f(1.0)), length_m, pixel_m);
}
