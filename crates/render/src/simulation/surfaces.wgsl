// What a simulation finds declared that reads the surfaces which a camera of the scene sees.

struct Seen {
    // The camera's space from the world's.
    view_from_world: mat4x4f,
    // Half the width and height of its picture: in metres with parallel rays, else in a distance of 1 m.
    half_extent: vec2f,
    // 1 with parallel rays.
    is_orthographic: f32,
    // 1 if there is a camera.
    is_there: f32,
}

@group(1) @binding(2) var<uniform> seen: Seen;
// The normal in world space, and the distance along the camera's axis in metres.
@group(1) @binding(3) var seen_surfaces: texture_2d<f32>;

// What is met on the way from one place of world space to another: the normal, and how deep within the surface the way ends; 0
// where nothing is met. What is far behind a surface has not come through it.
fn seen_surface(before_m: vec3f, after_m: vec3f) -> vec4f {
    let place = (seen.view_from_world * vec4f(after_m, 1.0)).xyz;
    let distance_m = -place.z;
    let ndc = place.xy / seen.half_extent / select(max(distance_m, 1e-6), 1.0, seen.is_orthographic != 0.0);
    let within = clamp(ndc, vec2f(-0.9999), vec2f(0.9999));
    let size = vec2f(textureDimensions(seen_surfaces));
    let surface = textureLoad(seen_surfaces, vec2i((0.5 + 0.5 * within * vec2f(1.0, -1.0)) * size), 0);
    let behind_m = distance_m - surface.w;
    let axis = -vec3f(seen.view_from_world[0].z, seen.view_from_world[1].z, seen.view_from_world[2].z);
    let way_m = abs(dot(after_m - before_m, axis));
    let is_met = (behind_m > 0.0) & (behind_m <= way_m + 0.05) & (distance_m > 0.0) & all(within == ndc) & (seen.is_there != 0.0);
    let met = vec4f(surface.xyz, behind_m * max(-dot(surface.xyz, axis), 0.0));
    return select(vec4f(0.0), met, is_met);
}

// How far beyond a place of world space the surface is that the camera sees there, along its axis, in metres: below 0 where it is
// before the place; 1e6 where there is none.
fn surface_beyond(place_m: vec3f) -> f32 {
    let place = (seen.view_from_world * vec4f(place_m, 1.0)).xyz;
    let distance_m = -place.z;
    let ndc = place.xy / seen.half_extent / select(max(distance_m, 1e-6), 1.0, seen.is_orthographic != 0.0);
    let size = vec2i(textureDimensions(seen_surfaces));
    let texel = (0.5 + 0.5 * clamp(ndc, vec2f(-1.0), vec2f(1.0)) * vec2f(1.0, -1.0)) * vec2f(size) - 0.5;
    let share = fract(texel);
    var beyond = 0.0;
    var nothing = 0.0;
    for (var at = 0u; at < 4u; at++) {
        let corner = vec2i(i32(at & 1u), i32(at >> 1u));
        let surface = textureLoad(seen_surfaces, clamp(vec2i(floor(texel)) + corner, vec2i(0), size - 1), 0);
        let part = mix(1.0 - share, share, vec2f(corner));
        let is_nothing = surface.w >= 1e6;
        beyond += part.x * part.y * select(surface.w - distance_m, 0.0, is_nothing);
        nothing += part.x * part.y * select(0.0, 1.0, is_nothing);
    }
    let is_there = (nothing < 0.5) & (distance_m > 0.0) & all(abs(ndc) <= vec2f(1.0)) & (seen.is_there != 0.0);
    return select(1e6, beyond / max(1.0 - nothing, 1e-3), is_there);
}
