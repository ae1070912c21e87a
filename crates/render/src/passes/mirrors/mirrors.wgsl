// mirrors: what a flat mirror reflects, from the picture of the view behind it, whose eye is the eye mirrored.
// Sources: planar reflections (McReynolds & Blythe 1999, "Advanced Graphics Programming Techniques Using OpenGL"); rough
// mirrors by rays to visible normals of GGX (Heitz 2018, by the caps of Dupuy & Benyoub 2023), weighted by how much of the
// light of each gets out (height-correlated masking, Heitz 2014), that meet what is behind the mirror where its distances
// say; each brings the mean of as much of the picture as it stands for (Colbert & Křivánek 2007).
// Reads: ids, G-buffer, linear_depth, radiance and linear_depth of the view behind the mirror. Writes: radiance and how much
// it is to be trusted, 1.
// Program: mirrors.

import package::view::view;
import package::constants::RADIANCE_MAX;
import package::gbuffer::is_lit_deferred;
import package::shaders::behind_mirror::{behind_radiance_at, behind_uv, meeting_behind, mirror};
import package::shaders::gbuffer_textures::surface_at;
import package::shaders::hash::{plastic_turn, seed_of_pixel, unit_from_bits};
import package::shaders::screen_space::{Center, center_at, tangents_of};
import package::shaders::visible_normals::{reflected_likelihood, visible_normal};

@group(1) @binding(6) var ids: texture_2d<u32>;

// Rays of a pixel; 0 where what is reflected is seen straight.
override rays: u32 = 0u;

// Of a normal that the eye sees: the radiance that comes by it, times its weight, and that.
fn reflected(center: Center, alpha: f32, noise: vec2f) -> vec4f {
    let tangents = tangents_of(center.normal);
    let to_eye = vec3f(center.to_eye * tangents, dot(center.to_eye, center.normal));
    let local = visible_normal(to_eye, alpha, noise);
    let visible = tangents * local.xy + center.normal * local.z;
    let direction = reflect(-center.to_eye, visible);
    let rise = dot(direction, center.normal);
    let over_plane = dot(direction, mirror.normal_view);
    if rise <= 0.0 || over_plane <= 0.0 {
        return vec4f(0.0);
    }
    let a2 = max(alpha * alpha, 1e-12);
    // How much of the light of a visible normal gets out, after Smith.
    let of_eye = sqrt(a2 / (to_eye.z * to_eye.z) + 1.0 - a2);
    let of_light = sqrt(a2 / (rise * rise) + 1.0 - a2);
    let weight = (1.0 + of_eye) / (of_eye + of_light);
    let likelihood = reflected_likelihood(local, to_eye, a2);
    // Behind the mirror the ray goes on as its image.
    let image = direction - 2.0 * over_plane * mirror.normal_view;
    let met = meeting_behind(center.position, image);
    let solid_angle = mirror.share_of_ray / likelihood;
    let level = log2(max(0.5 * met.length_m * sqrt(solid_angle) / met.pixel_m, 1e-3));
    return vec4f(behind_radiance_at(met.uv, max(level, 0.0)), 1.0) * weight;
}

@fragment
fn fs_mirrors(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let center = center_at(pixel);
    if textureLoad(ids, pixel, 0).r != mirror.object || !center.is_surface {
        discard;
    }
    let surface = surface_at(pixel);
    var radiance = vec3f(0.0);
    if rays == 0u {
        radiance = behind_radiance_at(behind_uv(center.position), 0.0);
    } else {
        let alpha = surface.roughness_perceptual * surface.roughness_perceptual;
        let seed = vec2f(
            unit_from_bits(seed_of_pixel(position.xy, 61u)),
            unit_from_bits(seed_of_pixel(position.xy, 62u)),
        );
        var sum = vec4f(0.0);
        for (var ray = 0u; ray < rays; ray++) {
            sum += reflected(center, alpha, fract(seed + plastic_turn(view.sample_index * rays + ray)));
        }
        radiance = sum.rgb / max(sum.a, 1e-6);
    }
    let share = select(0.0, 1.0, is_lit_deferred(surface));
    return vec4f(clamp(radiance, vec3f(0.0), vec3f(RADIANCE_MAX)), 1.0) * share;
}
