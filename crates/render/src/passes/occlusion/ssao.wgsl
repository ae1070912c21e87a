// occlusion: of the environment's diffuse light the share that reaches a surface, by points above it that lie behind
// what the picture shows.
// Source: Mittring 2007, "Finding Next Gen: CryEngine 2", in the form with a hemisphere around the normal, noise that
// turns it, and a check of the range. Differs from it: points are spread by the cosine, so that open surfaces are
// weighted as their light is; what occludes has to rise over the tangent plane, so that planes do not occlude
// themselves. Reads: normal, linear_depth. Writes: occlusion (r), and the mean direction of what is left (gba, in world
// space, its length tells nothing).
// Program: occlusion_ssao.

import package::view::{pixel_from_position_view, pixel_step_from_step_view};
import package::shaders::brdf::PI;
import package::shaders::screen_space::{Center, seen_from, tangents_of};
import package::passes::occlusion::taps::{center_of_texel, noise_at, occlusion, texel_of_background, texel_of_loss};

// In so many points it looks.
override kernel: u32 = 16u;
// Steps that leave no gaps and no rows, in one and in two dimensions (Roberts 2018, "The Unreasonable Effectiveness of
// Quasirandom Sequences").
const GOLDEN: f32 = 0.618034;
const PLASTIC: f32 = 0.754878;

// So many points tell apart what the picture shows within the radius: one for each pixel of a disc that is half a pixel
// wider. Where the radius is less than half a pixel, they lie before the center's own pixel and nothing occludes.
fn points_within(center: Center, points: u32) -> u32 {
    let reach_px = length(pixel_step_from_step_view(center.position, vec3f(occlusion.radius_m, 0.0, 0.0))) + 0.5;
    return u32(clamp(ceil(PI * reach_px * reach_px), 1.0, f32(points)));
}

@fragment
fn fs_occlusion_ssao(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let center = center_of_texel(vec2i(position.xy));
    if !center.is_surface {
        return texel_of_background();
    }
    let noise = noise_at(position.xy);
    // The normal is turned towards the eye, so that its z is never -1.
    let n = center.normal;
    let tangents = tangents_of(n);
    let count = points_within(center, max(kernel, 1u));
    var lost = 0.0;
    var lost_direction = vec3f(0.0);
    for (var i = 0u; i < count; i++) {
        let share = (f32(i) + noise.y) / f32(count);
        let turn = 2.0 * PI * (f32(i) * GOLDEN + noise.x);
        let place = fract(f32(i) * PLASTIC + noise.y);
        let direction = sqrt(share) * (tangents * vec2f(cos(turn), sin(turn))) + sqrt(1.0 - share) * n;
        // Denser near the surface.
        let point = center.position + direction * (occlusion.radius_m * mix(0.1, 1.0, place * place));
        let seen = seen_from(center, pixel_from_position_view(point));
        let rises = dot(seen.xyz, n) > occlusion.bias * occlusion.radius_m;
        let hides = center.position.z + seen.z > point.z && point.z < 0.0;
        let range = smoothstep(0.0, 1.0, occlusion.radius_m / max(abs(seen.z), 1e-6));
        let loss = select(0.0, range * seen.w, rises && hides);
        lost += loss;
        lost_direction += loss * direction;
    }
    return texel_of_loss(center, lost / f32(count), lost_direction / f32(count));
}
