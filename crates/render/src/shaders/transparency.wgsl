// What surfaces leave that are shaded where they are drawn, in each way in which blended ones become one picture: see
// `transparency.rs`, whose uniform is declared again here; a test compares the two.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::view;
import package::shaders::colour::half_float_clamped;
import package::shaders::hash::{mixed, seed_of_pixel, stratified};
import package::shaders::surface_material::material_factors;
import package::shaders::surface_vertex::SurfaceVarying;

const BLENDING_WEIGHTED: u32 = 1u;
const BLENDING_STOCHASTIC: u32 = 2u;
// Otherwise one surface lies over the other, in the order in which they are drawn.
override blending: u32 = 0u;

struct Weighting {
    // The logarithm to the base 2 of a weight is that of the distance times x, plus y, within plus and minus z.
    exponent: vec3f,
    // What is nearer lies before all surfaces that light comes through, in metres.
    glass_m: f32,
}

@group(1) @binding(3) var<uniform> weighting: Weighting;

// Which fragments of blended surfaces are drawn, as `transparency/peel.rs` numbers them: all of them, or those behind
// the nearest surface that light comes through, or those before it.
const PEELS_NOTHING: u32 = 0u;
const PEELS_BEHIND: u32 = 1u;
override peels: u32 = PEELS_NOTHING;
// Distances that differ by a smaller share are the same.
const PEEL_SHARE: f32 = 1e-4;
// Where blended surfaces are peeled the distances of the nearest surfaces that light comes through. Where such surfaces
// are drawn themselves `transmission.wgsl` says what it holds: programs have room for one texture.
@group(1) @binding(4) var glass_distances: texture_2d<f32>;

struct ShadedTargets {
    // Premultiplied; or with weights the product with the weight. Alpha is coverage, or what surfaces are blended by.
    @location(0) radiance: vec4f,
    // Alpha times weight. Without a target it goes nowhere.
    @location(1) weight: vec4f,
}

// Surfaces of one object that face one way are apart for chance where their distances differ by more than a share of
// 2^(1/128) - 1.
const CHANCES_PER_OCTAVE: f32 = 128.0;

fn distance_at(position_world: vec3f) -> f32 {
    return -(view.view_from_world * vec4f(position_world, 1.0)).z;
}

// Whether a fragment is one that the pass leaves out by its place.
fn is_peeled(position_clip: vec4f, position_world: vec3f) -> bool {
    if peels == PEELS_NOTHING {
        return false;
    }
    let distance_m = distance_at(position_world);
    let glass_m = textureLoad(glass_distances, vec2i(position_clip.xy), 0).r;
    // Where there is no such surface, what lies before them all is seen through none.
    let first_m = select(glass_m, weighting.glass_m, glass_m >= DISTANCE_BACKGROUND_M);
    let is_before = distance_m < first_m * (1.0 - PEEL_SHARE);
    return is_before == (peels == PEELS_BEHIND);
}

// Whether a sample of a still shows what lies behind a fragment in its place. Surfaces that lie behind each other in a
// pixel decide that independently; of the samples of each of them a share of alpha shows it.
fn is_let_through(in: SurfaceVarying, alpha: f32, front_facing: bool) -> bool {
    if blending == BLENDING_STOCHASTIC {
        let octave = log2(max(distance_at(in.position_world), 1e-30));
        let place = bitcast<u32>(i32(floor(octave * CHANCES_PER_OCTAVE)));
        let surface = in.object ^ mixed(material_factors.material_id * 2u + select(0u, 1u, front_facing));
        return alpha <= stratified(view.sample_index, seed_of_pixel(in.position_clip.xy, surface ^ mixed(place)));
    }
    return false;
}

// Radiance above this has so much less weight that half floats hold the sum of sixty of the nearest surfaces.
const RADIANCE_WEIGHTED: f32 = 16.0;

fn weight_at(distance_m: f32, radiance: vec3f) -> f32 {
    let exponent = log2(max(distance_m, 1e-30)) * weighting.exponent.x + weighting.exponent.y;
    let brightest = max(radiance.r, max(radiance.g, radiance.b));
    return exp2(clamp(exponent, -weighting.exponent.z, weighting.exponent.z)) / max(brightest / RADIANCE_WEIGHTED, 1.0);
}

// What a surface leaves whose material has this alpha. `opaque_alpha` is its coverage, with the mark of `glow.wgsl`,
// where the material does not blend.
fn shaded_targets(radiance: vec3f, opaque_alpha: f32, alpha: f32, position_world: vec3f) -> ShadedTargets {
    let light = half_float_clamped(radiance);
    var out: ShadedTargets;
    if blending == BLENDING_STOCHASTIC {
        out.radiance = vec4f(light, 1.0);
        return out;
    }
    let coverage = mix(opaque_alpha, clamp(alpha, 0.0, 1.0), material_factors.blended);
    out.radiance = vec4f(light * mix(1.0, min(coverage, 1.0), material_factors.blended), coverage);
    if blending == BLENDING_WEIGHTED {
        let weight = weight_at(distance_at(position_world), light);
        out.radiance = vec4f(out.radiance.rgb * weight, coverage);
        out.weight = vec4f(coverage * weight, 0.0, 0.0, coverage);
    }
    return out;
}
