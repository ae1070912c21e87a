// Light from everywhere: a constant, or a picture of all directions. What surfaces of some roughness reflect of a
// picture, and its irradiance, are read from the tiles of `environment_tiles.wgsl`.

import package::shaders::brdf::PI;
import package::constants::ENVIRONMENT_LEVEL_LAST;
import package::shaders::shading::linear_clamp;
import package::shaders::environment_suns::disc_share;
import package::shaders::environment_uniform::{environment, environment_tiles};
import package::shaders::probes::{probe_grids, probe_light};
import package::shaders::octahedral::octahedral_from_direction;
import package::shaders::environment_tiles::{environment_level, environment_texel};

// 1 if the light of the environment is a picture, which is dear where it is none; 1 if the camera sees it, too.
override has_picture: u32 = 0u;
override shows_picture: u32 = 0u;
// How many surroundings there are; the others have no size.
override surrounding_count: u32 = 0u;
// How many suns the picture has.
override sun_count: u32 = 0u;

// The direction in the picture of a direction in the world.
fn picture_direction(direction: vec3f) -> vec3f {
    let cosine = environment.picture.z;
    let sine = environment.picture.w;
    return vec3f(cosine * direction.x - sine * direction.z, direction.y, cosine * direction.z + sine * direction.x);
}

fn tile_at(place: vec2f, level: f32) -> vec3f {
    let texel = environment_texel(place, level, environment.tile_sides);
    return textureSampleLevel(environment_tiles, linear_clamp, texel * environment.picture_backdrop.zw, 0.0).rgb;
}

fn picture_at(direction: vec3f, level: f32) -> vec3f {
    let place = octahedral_from_direction(picture_direction(direction));
    let smooth_level = floor(level);
    let rough_level = min(smooth_level + 1.0, ENVIRONMENT_LEVEL_LAST);
    return mix(tile_at(place, smooth_level), tile_at(place, rough_level), level - smooth_level);
}

// The part of a sun in the lobe about a direction in which the camera sees it.
fn sun_backdrop(sun_direction: vec4f, sun_irradiance: vec4f, direction: vec3f) -> vec3f {
    let n_dot_l = max(dot(direction, sun_direction.xyz), 0.0);
    let a2 = environment.backdrop_lobe.x;
    let d = 1.0 - 0.5 * (1.0 + n_dot_l) * (1.0 - a2);
    let disc = disc_share(sqrt(a2), 0.5 + 0.5 * n_dot_l, sun_direction.w);
    return sun_irradiance.rgb * (n_dot_l * a2 / (4.0 * PI * d * d) * environment.backdrop_lobe.y * disc);
}

// What the camera sees of a picture where there is no surface.
fn picture_backdrop(direction: vec3f) -> vec3f {
    let suns = sun_backdrop(environment.sun_directions[0], environment.sun_irradiances[0], direction)
        + sun_backdrop(environment.sun_directions[1], environment.sun_irradiances[1], direction)
        + sun_backdrop(environment.sun_directions[2], environment.sun_irradiances[2], direction)
        + sun_backdrop(environment.sun_directions[3], environment.sun_irradiances[3], direction);
    // Where it sets, the horizon hides a part of it.
    let is_disc = direction.y > 0.0 && dot(direction, environment.sun_directions[0].xyz) > environment.sun_disc.w;
    let disc = select(vec3f(0.0), environment.sun_disc.rgb, is_disc);
    return picture_at(direction, environment.picture_backdrop.y) * environment.picture_backdrop.x + suns + disc;
}

// What the camera sees where there is no surface, by the sine of the elevation. It is apart from the light and depends
// on no other angle, so that it stays while the camera turns around the model.
fn environment_backdrop(elevation_sin: f32) -> vec3f {
    let share = smoothstep(-1.0, 1.0, elevation_sin);
    return mix(environment.backdrop_below.rgb, environment.backdrop_above.rgb, share);
}

// Where the surface is that is shaded, and the shares of the surroundings there.
var<private> surrounded_world: vec3f;
var<private> surrounding_shares: vec4f;

// From then on it is a place's environment that the functions here give.
fn enter_surroundings(position_world: vec3f) {
    if surrounding_count > 0u || probe_grids > 0u {
        surrounded_world = position_world;
    }
    if surrounding_count > 0u {
        var left = 1.0;
        var shares = vec4f(0.0);
        for (var i = 0u; i < surrounding_count; i++) {
            let seen_from = environment.surroundings[i];
            let inside_m = seen_from.half_m.xyz - abs(position_world - seen_from.center.xyz);
            let nearest_m = min(inside_m.x, min(inside_m.y, inside_m.z));
            let share = left * clamp(nearest_m * seen_from.center.w, 0.0, 1.0);
            shares += share * vec4f(vec4u(i) == vec4u(0u, 1u, 2u, 3u));
            left -= share;
        }
        surrounding_shares = shares;
    }
}

// The share of the environment itself.
fn outside_share() -> f32 {
    if surrounding_count == 0u {
        return 1.0;
    }
    return max(1.0 - dot(surrounding_shares, vec4f(1.0)), 0.0);
}

// What is seen around a place in a direction, of a level; where there are walls, in the direction of what the ray meets.
fn surroundings_at(index: u32, direction: vec3f, level: f32, meets_walls: f32) -> vec3f {
    let seen_from = environment.surroundings[index];
    let away = surrounded_world - seen_from.walls_center.xyz;
    // Where the ray leaves the box (Lagarde & Zanuttini 2012, "Local Image-Based Lighting with Parallax-Corrected Cubemap").
    let safe = select(vec3f(1e-6), direction, abs(direction) > vec3f(1e-6));
    let ends = (sign(safe) * seen_from.walls_half_m.xyz - away) / safe;
    let met = surrounded_world + direction * max(min(ends.x, min(ends.y, ends.z)), 0.0) - seen_from.place.xyz;
    let seen = mix(direction, met, seen_from.place.w * meets_walls);
    let place = octahedral_from_direction(normalize(seen));
    let smooth_level = floor(level);
    let rough_level = min(smooth_level + 1.0, ENVIRONMENT_LEVEL_LAST);
    let sides = environment.surrounding_sides;
    let smooth_uv = (seen_from.corner.xy + environment_texel(place, smooth_level, sides)) * environment.picture_backdrop.zw;
    let rough_uv = (seen_from.corner.xy + environment_texel(place, rough_level, sides)) * environment.picture_backdrop.zw;
    let smooth_radiance = textureSampleLevel(environment_tiles, linear_clamp, smooth_uv, 0.0).rgb;
    let rough_radiance = textureSampleLevel(environment_tiles, linear_clamp, rough_uv, 0.0).rgb;
    return mix(smooth_radiance, rough_radiance, level - smooth_level) * seen_from.half_m.w;
}

// The sum of all surroundings by their shares.
fn surrounding_radiance(direction: vec3f, level: f32, meets_walls: f32) -> vec3f {
    var radiance = vec3f(0.0);
    for (var i = 0u; i < surrounding_count; i++) {
        let share = dot(surrounding_shares, vec4f(vec4u(i) == vec4u(0u, 1u, 2u, 3u)));
        if share > 0.0 {
            radiance += share * surroundings_at(i, direction, level, meets_walls);
        }
    }
    return radiance;
}

// Radiance averaged over the lobe of GGX about `direction`, seen along it.
fn environment_reflection(direction: vec3f, roughness_alpha: f32) -> vec3f {
    var radiance = environment.constant;
    let level = environment_level(sqrt(roughness_alpha));
    if has_picture != 0u {
        radiance += picture_at(direction, level) * environment.picture.x;
    }
    if surrounding_count > 0u {
        // Of what is wide the middle says where it is seen no more.
        let meets_walls = 1.0 - smoothstep(0.5, 1.0, sqrt(roughness_alpha));
        radiance = radiance * outside_share() + surrounding_radiance(direction, level, meets_walls);
    }
    return radiance;
}

// How much of what a surface mirrors of light from everywhere is that of grazing incidence: the bias of the split sum
// beside f0 times its scale (Karis 2013).
fn grazing_share(f0: vec3f, f90: f32, dfg: vec2f) -> f32 {
    let grazing = f90 * dfg.y;
    return grazing / max(max(f0.r, max(f0.g, f0.b)) * dfg.x + grazing, 1e-4);
}

// Where the lobe of a surface points from which light is mirrored: rough ones ever more along the normal (Lagarde & de
// Rousiers 2014, section 4.9.3, times a fit to integrals of the lobe at grazing angles), but what is reflected by
// grazing incidence is of light that stands as low as the eye, along the mirror's direction.
fn lobe_direction(mirrored: vec3f, normal: vec3f, n_dot_v: f32, roughness_alpha: f32, grazing_share: f32) -> vec3f {
    let smoothness = 1.0 - roughness_alpha;
    let share = smoothness * (sqrt(smoothness) + roughness_alpha)
        * mix(0.55 + 0.45 * n_dot_v, 1.0, smoothness * smoothness * smoothness);
    return normalize(mix(normal, mirrored, mix(share, 1.0, grazing_share)));
}

// Of the environment itself.
fn outer_irradiance(normal: vec3f) -> vec3f {
    return outer_light(normal) * PI;
}

fn outer_light(normal: vec3f) -> vec3f {
    var radiance = environment.constant;
    if has_picture != 0u {
        let place = octahedral_from_direction(picture_direction(normal));
        // Seen along the normal, what roughness 1 reflects is irradiance divided by pi.
        radiance += tile_at(place, ENVIRONMENT_LEVEL_LAST) * environment.picture.x;
    }
    return radiance;
}

// What of the environment's diffuse light is not that of probes, at the place of which irradiance was last asked.
var<private> outside_probes: f32 = 1.0;

fn environment_irradiance(normal: vec3f) -> vec3f {
    return environment_irradiance_about(normal, normal);
}

// Of the environment and of surroundings, divided by pi.
fn distant_light(direction: vec3f) -> vec3f {
    let radiance = outer_light(direction);
    if surrounding_count > 0u {
        return radiance * outside_share() + surrounding_radiance(direction, ENVIRONMENT_LEVEL_LAST, 0.0);
    }
    return radiance;
}

// About a direction, of a surface with a normal.
fn environment_irradiance_about(direction: vec3f, normal: vec3f) -> vec3f {
    if probe_grids == 0u {
        return distant_light(direction) * PI;
    }
    let of_probes = probe_light(surrounded_world, direction, normal);
    outside_probes = 1.0 - of_probes.a;
    var radiance = of_probes.rgb;
    // A loop, because software adapters take all ways of a branch.
    let outside = select(0u, 1u, outside_probes > 0.0);
    for (var i = 0u; i < outside; i++) {
        radiance += distant_light(direction) * outside_probes;
    }
    return radiance * PI;
}
