// particles.light: the radiance of every particle, of what it emits and of the light that it scatters to all sides alike, as
// a puff of smoke does: of the lights of its cluster, of those without range, and of the environment, with their shadows and
// those of other particles of the system (`shade.wgsl`), as if all lamps stood where most of their light comes from; times what
// it counts in the mean of all that are seen in a pixel.
// Reads: the states of what moves them, the tables of lights, clusters and shadows. Writes: pre-exposed radiance, in fog; 0
// where the view does not show one.
// Program: particles_light.

import package::view::{direction_to_eye_world, view};
import package::shaders::colour::half_float_clamped;
import package::shaders::environment::{environment_irradiance, enter_surroundings, outside_probes, sun_count};
import package::shaders::environment_uniform::environment;
import package::shaders::fog::fogged;
import package::shaders::light_lists::cluster_index_at;
import package::shaders::light_table::{
    LIGHT_AXIS, LIGHT_COLOR, LIGHT_POSITION, cluster_at, cluster_grid, cluster_light_at, light_part, light_place, table_rows,
};
import package::shaders::shadows::{directional_visibility_in_air, punctual_visibility_in_air, shadowed};
import package::passes::particles::shade::{comes_through, depths_around, weight_in_sight};
import package::passes::particles::uniform::{particles, place, velocity};

const FOUR_PI: f32 = 12.5663706;
// Beyond the picture by so much a particle is still seen by its radius.
const MARGIN: f32 = 1.5;
const LUMINANCE: vec3f = vec3f(0.2126, 0.7152, 0.0722);
// How much of the optical depth straight up and straight down the light of the environment meets: most of it comes from
// the sides, where rising smoke is thinner.
const AROUND: f32 = 0.5;

// Light of lamps and suns on a particle, and the sum of the directions to them times its luminance.
struct Arriving {
    irradiance: vec3f,
    towards: vec3f,
}

// Adds what a light at a place shines on a particle, from all of it at once.
fn add_punctual(index: u32, position_world: vec3f, sums: ptr<function, Arriving>) {
    let table_uv = light_place(index, table_rows());
    let source = light_part(table_uv, LIGHT_POSITION);
    let towards = source.xyz - position_world;
    let distance_squared = max(dot(towards, towards), 1e-4);
    let ratio_squared = distance_squared * source.w;
    if ratio_squared >= 1.0 {
        return;
    }
    var strength = (1.0 - ratio_squared * ratio_squared) / distance_squared;
    let color = light_part(table_uv, LIGHT_COLOR);
    let to_light = towards * inverseSqrt(distance_squared);
    if color.w != 0.0 {
        let axis = light_part(table_uv, LIGHT_AXIS);
        let cone = clamp(axis.w - dot(axis.xyz, to_light) * color.w, 0.0, 1.0);
        strength *= cone * cone;
    }
    if shadowed != 0u {
        if strength > 0.0 {
            strength *= punctual_visibility_in_air(table_uv, source.xyz, position_world);
        }
    }
    let irradiance = color.rgb * strength;
    (*sums).irradiance += irradiance;
    (*sums).towards += dot(irradiance, LUMINANCE) * to_light;
}

fn add_directional(index: u32, position_world: vec3f, sums: ptr<function, Arriving>) {
    let table_uv = light_place(index, table_rows());
    var irradiance = light_part(table_uv, LIGHT_COLOR).rgb;
    if shadowed != 0u {
        irradiance *= directional_visibility_in_air(table_uv, position_world);
    }
    (*sums).irradiance += irradiance;
    (*sums).towards -= dot(irradiance, LUMINANCE) * light_part(table_uv, LIGHT_AXIS).xyz;
}

// All light on the particle `own` over the whole sphere, and in w what it counts.
fn light_on(own: u32, position_world: vec3f, position_px: vec2f, distance_m: f32) -> vec4f {
    enter_surroundings(position_world);
    // Of the environment from above and from below: twice the irradiance of each side is what a sphere of it gives.
    let above = 2.0 * environment_irradiance(vec3f(0.0, 1.0, 0.0));
    let below = 2.0 * environment_irradiance(vec3f(0.0, -1.0, 0.0));
    var sums = Arriving(vec3f(0.0), vec3f(0.0));
    for (var i = 0u; i < sun_count; i++) {
        let irradiance = environment.sun_irradiances[i].rgb * outside_probes;
        sums.irradiance += irradiance;
        sums.towards += dot(irradiance, LUMINANCE) * environment.sun_directions[i].xyz;
    }
    // How long loops are depends on more than uniforms, see docs/decisions/006.
    let directional_count = select(0u, cluster_grid.directional_count, position_px.x >= 0.0);
    let global_count = select(0u, cluster_grid.global_count, position_px.x >= 0.0);
    for (var i = 0u; i < directional_count; i++) {
        add_directional(i, position_world, &sums);
    }
    for (var i = directional_count; i < global_count; i++) {
        add_punctual(i, position_world, &sums);
    }
    let rows = table_rows();
    let list = cluster_at(cluster_index_at(position_px, distance_m));
    let count = select(0u, list.end - list.first, position_px.x >= 0.0);
    for (var i = 0u; i < count; i++) {
        add_punctual(cluster_light_at(list.first + i, rows), position_world, &sums);
    }
    let strength = length(sums.towards);
    let to_eye = direction_to_eye_world(position_world);
    let depths = depths_around(own, position_world, sums.towards / max(strength, 1e-9), to_eye);
    let through = comes_through(depths.around.xyz * vec3f(1.0, AROUND, AROUND));
    // Lamps on all sides are shaded as the environment is.
    let one_sided = clamp(strength / max(dot(sums.irradiance, LUMINANCE), 1e-9), 0.0, 1.0);
    let direct = sums.irradiance * mix(0.5 * (through.y + through.z), through.x, one_sided);
    return vec4f(above * through.y + below * through.z + direct, weight_in_sight(depths));
}

@fragment
fn fs_particles_light(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = textureLoad(place, vec2i(position.xy), 0);
    let life = textureLoad(velocity, vec2i(position.xy), 0).w;
    let clip = view.clip_from_world * vec4f(at.xyz, 1.0);
    if at.w < 0.0 || clip.w <= 0.0 || any(abs(clip.xy) > vec2f(MARGIN * clip.w)) {
        return vec4f(0.0);
    }
    let left = clamp(1.0 - at.w / max(life, 1e-6), 0.0, 1.0);
    var radiance = particles.color * particles.emission * left;
    // Depends on more than uniforms, see docs/decisions/006.
    if (particles.opacity > 0.0) & (position.x > -1.0) {
        let ndc = clamp(clip.xy / clip.w, vec2f(-1.0), vec2f(0.9999));
        let position_px = (ndc * vec2f(0.5, -0.5) + 0.5) * view.size_px;
        let distance_m = max(-(view.view_from_world * vec4f(at.xyz, 1.0)).z, 1e-3);
        let own = u32(position.y) * particles.columns + u32(position.x);
        let seen_px = clamp(position_px, vec2f(0.0), view.size_px - 1.0);
        let light = light_on(own, at.xyz, seen_px, distance_m);
        radiance = (radiance + particles.color * light.xyz / FOUR_PI) * light.w;
    }
    return vec4f(half_float_clamped(fogged(radiance, at.xyz)), 1.0);
}
