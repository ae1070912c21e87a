// forward: surfaces shaded where they are drawn: blended ones, and with `--path forward` all of them. The same
// reflectance model, lights and lists as the deferred path.
// With `forward-batched` it is drawn once for each eight lights that reach its object (`light_batch`).
// Surfaces with layers are drawn again for what the picture shows in the place of the environment's light, once what
// they send themselves is known (`layered.reflections`, `layered.gi`).
// Reads: the tables of lights and clusters, the environment, occlusion, what was found in the picture. Writes: radiance
// (premultiplied), depth if opaque; with `counts_pairs` the numbers of pairs in place of radiance; or a difference.
// Program: forward, also for points, also with layers, also with relief. Axes: textures, skins.

import package::view::{view, pixel_height_m};
import package::gbuffer::{SHADING_MODEL_UNLIT, Surface};
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, masked, object_id, surface_varying};
import package::shaders::level_fade::{fades, is_faded};
import package::shaders::mask::mask_coverage;
import package::shaders::surface_material::surface_mip_bias;
import package::shaders::surface_material::surface_sample;
import package::shaders::shaded_place::shading_at;
import package::shaders::shading::FLAT_LIKENESS_MIN;
import package::shaders::shadows::shadowed;
import package::constants::LIGHTS_PER_BATCH;
import package::shaders::light_lists::{light_sums, object_light_sums};
import package::shaders::lights::{LightSums, counts_pairs, pair_counts};
import package::shaders::ambient::Seen;
import package::shaders::brdf::Shading;
import package::shaders::coarse_occlusion::seen_by_sample;
@if(!layered) import package::shaders::ambient::ambient_radiance_seen;
@if(layered) import package::shaders::layered_ambient::{
    layered_ambient, light_in_place, reflected_in_place, transmitted_share,
};
@if(layered) import package::shaders::layers::{below_coat, layer_sample, layered_roughness, set_layers};
@if(layered) import package::shaders::transmission::{behind, seen_behind, shows_transmittance};
import package::shaders::fog::{fogged, fog_transmittance};
import package::shaders::fog_light::light_in_fog_before;
import package::shaders::colour::half_float_clamped;
import package::shaders::glow::glow_share;
import package::shaders::surface_material::material_factors;
import package::shaders::transparency::{ShadedTargets, is_let_through, is_peeled, shaded_targets};
@if(relief) import package::shaders::relief::{Sunk, depth_again, has_coarse_steps, sunk};
@if(relief) import package::shaders::surface_material::detailed_sample;

// Which lights: those of clusters, or a batch of the object's own; the first is drawn with emission and ambient light.
const LIGHTS_OF_CLUSTERS: u32 = 0u;
const LIGHTS_OF_FIRST_BATCH: u32 = 1u;
const LIGHTS_OF_LATER_BATCH: u32 = 2u;
// Or in their place, where layers are drawn again: what the surface reflects of the picture, or light that surfaces of
// the picture send it.
const LIGHTS_OF_REFLECTIONS: u32 = 3u;
const LIGHTS_OF_SURFACES: u32 = 4u;
override lights_of: u32 = LIGHTS_OF_CLUSTERS;
// 1 if the light that fog scatters before the surface is added, which blended surfaces alone do for themselves.
override in_lit_fog: u32 = 0u;
// 1 if the depth of what is drawn is there already.
@if(relief) override draws_again: u32 = 0u;

// 1 if what lies behind is seen through surfaces; else a texel stands in for it.
@if(layered) override transmissive: u32 = 0u;
// 1 if surfaces that light comes through take the place of what is there, and do not blend with it.
@if(layered) override replaces: u32 = 0u;
// 1 if what was found in the picture lies in `behind`, which no opaque surface needs: WebGL 2 has no more textures.
@if(layered) override takes_found: u32 = 0u;

struct LightBatch {
    // The first light of the batch; the others are padding.
    first: vec4u,
}

@group(1) @binding(1) var<uniform> light_batch: LightBatch;

@vertex
fn vs_forward(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@if(!relief) @fragment
fn fs_forward(in: SurfaceVarying, @builtin(front_facing) front_facing: bool) -> ShadedTargets {
    return forward_targets(in, front_facing);
}

@if(relief) struct ReliefTargets {
    @location(0) radiance: vec4f,
    @location(1) weight: vec4f,
    @builtin(frag_depth) depth: f32,
}

@if(relief) @fragment
fn fs_forward(in: SurfaceVarying, @builtin(front_facing) front_facing: bool) -> ReliefTargets {
    let seen = sunk(in);
    let depth = select(seen.depth_ndc, depth_again(seen.depth_ndc), draws_again != 0u);
    let targets = forward_targets(seen.surface, front_facing, seen);
    return ReliefTargets(targets.radiance, targets.weight, depth);
}

// What takes the place of what is there, of a surface that light comes through: all of it, or where alpha covers it in part
// that share.
@if(layered) fn over_what_is_there(in: SurfaceVarying, of_surface: vec4f, alpha: f32) -> vec4f {
    let there = textureLoad(behind, vec2i(in.position_clip.xy), 0);
    return mix(there, of_surface, mix(1.0, clamp(alpha, 0.0, 1.0), material_factors.blended));
}

// What nothing hides of the environment, and what the picture shows in its place.
fn seen_of_surface(in: SurfaceVarying, surface: Surface, shading: Shading) -> Seen {
    let distance_m = -(view.view_from_world * vec4f(in.position_world, 1.0)).z;
    var seen = seen_by_sample(in.position_clip.xy, distance_m, surface, shading);
    @if(layered) {
        if takes_found != 0u {
            seen.reflected = textureLoad(behind, vec2i(in.position_clip.xy), 0);
        }
    }
    return seen;
}

// The difference that what was found in the picture makes.
@if(layered) fn found_radiance(in: SurfaceVarying, surface: Surface, shading: Shading) -> vec3f {
    if lights_of == LIGHTS_OF_SURFACES {
        return light_in_place(surface, shading, textureLoad(behind, vec2i(in.position_clip.xy), 0));
    }
    return reflected_in_place(surface, shading, seen_of_surface(in, surface, shading));
}

// Whether a fragment is none of this layer, of this level of detail, or of a point's disc.
fn is_left_out(in: SurfaceVarying) -> bool {
    var is_out = is_peeled(in.position_clip, in.position_world);
    if fades != 0u {
        is_out = is_out | is_faded(in.position_clip.xy, in.object);
    }
    @if(points) {
        is_out = is_out | (dot(in.corner, in.corner) > 1.0);
    }
    return is_out;
}

// What the targets take of the radiance of a surface, of which `coverage` hides what lies behind.
fn targets_of(
    in: SurfaceVarying,
    radiance: vec3f,
    sums: LightSums,
    emission: vec3f,
    coverage: f32,
    alpha: f32,
) -> ShadedTargets {
    if lights_of >= LIGHTS_OF_REFLECTIONS {
        return ShadedTargets(vec4f(radiance, 0.0), vec4f(0.0));
    }
    if counts_pairs != 0u {
        return ShadedTargets(pair_counts(sums), vec4f(0.0));
    }
    if lights_of == LIGHTS_OF_LATER_BATCH {
        // Coverage and the light of fog are there already: what is left is what comes through.
        let added = fogged(radiance, in.position_world) - fogged(vec3f(0.0), in.position_world);
        return ShadedTargets(vec4f(half_float_clamped(added), 0.0), vec4f(0.0));
    }
    var seen = fogged(radiance, in.position_world);
    if in_lit_fog != 0u {
        seen += light_in_fog_before(in.position_clip.xy, in.position_world);
    }
    let glow = glow_share(half_float_clamped(emission * view.pre_exposure));
    let opaque_alpha = coverage + glow * fog_transmittance(in.position_world);
    @if(layered) {
        if replaces != 0u {
            let of_surface = vec4f(half_float_clamped(seen), opaque_alpha);
            return ShadedTargets(over_what_is_there(in, of_surface, alpha), vec4f(0.0));
        }
    }
    return shaded_targets(seen, opaque_alpha, alpha, in.position_world);
}

fn forward_targets(in: SurfaceVarying, front_facing: bool, @if(relief) seen: Sunk) -> ShadedTargets {
    @if(!layered) let sample = surface_sample(in, front_facing);
    @if(layered && !relief) var sample = surface_sample(in, front_facing);
    @if(relief) var sample = detailed_sample(in, seen.facet, front_facing);
    @if(layered) let layers = layer_sample(in, front_facing);
    @if(layered) {
        sample.surface.roughness_perceptual = layered_roughness(sample.surface, layers);
    }
    @if(!relief) let facet = cross(dpdx(in.position_world), dpdy(in.position_world));
    // Neighbours that coarse steps put apart are on no plane.
    @if(relief) let facet = select(
        cross(dpdx(in.position_world), dpdy(in.position_world)), seen.facet.across, has_coarse_steps(),
    );
    let facet_normal = facet * inverseSqrt(max(dot(facet, facet), 1e-30));
    if is_left_out(in) {
        discard;
    }
    var covered = 1.0;
    if masked != 0u {
        covered = mask_coverage(in, sample.alpha, surface_mip_bias(in));
        if covered <= 0.0 {
            discard;
        }
    }
    if is_let_through(in, sample.alpha, front_facing) {
        discard;
    }
    var radiance = vec3f(0.0);
    if lights_of < LIGHTS_OF_LATER_BATCH {
        radiance = sample.emission * view.pre_exposure;
    }
    var coverage = 1.0;
    @if(layered) var transmittance = vec4f(0.0);
    var sums: LightSums;
    // The branch depends on more than uniforms, see docs/decisions/006.
    if (in.position_clip.x >= 0.0) & (sample.surface.shading_model != SHADING_MODEL_UNLIT) {
        var shading = shading_at(sample.surface, in.position_world);
        let distance_m = -(view.view_from_world * vec4f(in.position_world, 1.0)).z;
        if shadowed != 0u {
            shading.facet_normal = select(-facet_normal, facet_normal, dot(facet_normal, shading.to_eye) >= 0.0);
            // What light comes through is not whole in shadow maps, where walls are looked for beside flat surfaces.
            var is_whole = material_factors.blended < 0.5;
            @if(layered) {
                is_whole = is_whole & (transmissive == 0u);
            }
            shading.is_flat = is_whole & (dot(shading.facet_normal, shading.normal) > FLAT_LIKENESS_MIN);
            shading.lift_m = sample.surface.lift_px * pixel_height_m(distance_m);
        }
        @if(relief) {
            shading.relief = seen.shadows;
        }
        @if(layered) {
            set_layers(&shading, sample.surface, layers);
            radiance *= below_coat(shading.layers) * shading.layers.through;
        }
        @if(layered) {
            if lights_of >= LIGHTS_OF_REFLECTIONS {
                radiance = found_radiance(in, sample.surface, shading);
            }
        }
        if lights_of < LIGHTS_OF_LATER_BATCH {
            let seen = seen_of_surface(in, sample.surface, shading);
            @if(layered) {
                radiance += layered_ambient(sample.surface, shading, seen);
            }
            @if(!layered) {
                radiance += ambient_radiance_seen(sample.surface, shading, seen);
            }
            @if(layered) {
                if transmissive != 0u {
                    let share = transmitted_share(shading);
                    let seen = seen_behind(shading, in.position_world);
                    radiance += share * seen.rgb;
                    // Before nothing what is seen through is nothing, too.
                    coverage = 1.0 - (1.0 - clamp(seen.a, 0.0, 1.0)) * dot(share, vec3f(1.0 / 3.0));
                    transmittance = vec4f(share, dot(share, vec3f(1.0 / 3.0))) * seen;
                }
            }
        }
        if lights_of == LIGHTS_OF_CLUSTERS {
            sums = light_sums(in.position_clip.xy, distance_m, in.position_world, shading);
        } else if lights_of < LIGHTS_OF_REFLECTIONS {
            let first = light_batch.first.x;
            let object = object_id(in.object);
            sums = object_light_sums(object, first, LIGHTS_PER_BATCH, in.position_world, shading);
        }
        radiance += sums.radiance;
    }
    @if(layered) {
        if shows_transmittance != 0u {
            let through = vec4f(transmittance.rgb * fog_transmittance(in.position_world), transmittance.a);
            return ShadedTargets(over_what_is_there(in, through, sample.alpha), vec4f(0.0));
        }
    }
    return targets_of(in, radiance, sums, sample.emission, covered * coverage, sample.alpha);
}
