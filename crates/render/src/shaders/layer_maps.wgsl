// The factors and maps of what a material has beyond metallic-roughness: layers (`layers.wgsl`), detail
// (`surface_detail.wgsl`) and relief (`relief.wgsl`). Which there are is constant when a shader runs, so that others
// cost nothing.

import package::shaders::surface_vertex::SurfaceVarying;
import package::view::view;

struct LayerFactors {
    // The colour of a dielectric's reflection at normal incidence; the weight of all of it.
    specular: vec4f,
    // Reflectance at normal incidence as the refractive index makes it; that index; glossiness; dispersion.
    refraction: vec4f,
    // Weight, perceptual roughness and normal scale of the clear coat; transmission.
    coat: vec4f,
    // Colour and perceptual roughness of the sheen.
    sheen: vec4f,
    // Strength; cosine and sine of the rotation; zero.
    anisotropy: vec4f,
    // Weight and refractive index of the film, its least and its greatest thickness in nanometres.
    film: vec4f,
    // Colour and weight of scattered transmission.
    diffuse_transmission: vec4f,
    // What is absorbed in a metre, as an exponent; thickness in metres of the mesh's space.
    volume: vec4f,
    // How far below the triangles a height of 0 lies, in metres of the mesh's space; factor of baked light; scale of
    // detail normals; zero.
    detail: vec4f,
    // Rows of the matrices that place the maps, as of `MaterialFactors`; in w of the second row the layer of the
    // texture.
    maps: array<vec4f, 34>,
    // Those of baked light.
    light_map_rows: array<vec4f, 2>,
}

@group(2) @binding(11) var<uniform> layer_factors: LayerFactors;
// The maps that are data, and those that are colours.
@group(2) @binding(12) var layer_data: texture_2d_array<f32>;
@group(2) @binding(13) var layer_data_sampler: sampler;
@group(2) @binding(14) var layer_colors: texture_2d_array<f32>;
@group(2) @binding(15) var layer_colors_sampler: sampler;
@group(2) @binding(16) var light_map_texture: texture_2d<f32>;
@group(2) @binding(17) var light_map_sampler: sampler;

// The layers that there are, by the bits of `constants.rs`, and below these the maps, by the order of `LayerMap`.
override material_layers: u32 = 0u;
// 1 if the lower half of the light map holds where the light of its upper half comes from; 2 if a normal bends it, too.
override directed_light: u32 = 0u;

const MAP_SPECULAR: u32 = 0u;
const MAP_SPECULAR_COLOR: u32 = 1u;
const MAP_CLEARCOAT: u32 = 2u;
const MAP_CLEARCOAT_ROUGHNESS: u32 = 3u;
const MAP_CLEARCOAT_NORMAL: u32 = 4u;
const MAP_SHEEN_COLOR: u32 = 5u;
const MAP_SHEEN_ROUGHNESS: u32 = 6u;
const MAP_ANISOTROPY: u32 = 7u;
const MAP_IRIDESCENCE: u32 = 8u;
const MAP_IRIDESCENCE_THICKNESS: u32 = 9u;
const MAP_TRANSMISSION: u32 = 10u;
const MAP_THICKNESS: u32 = 11u;
const MAP_DIFFUSE_TRANSMISSION: u32 = 12u;
const MAP_DIFFUSE_TRANSMISSION_COLOR: u32 = 13u;
const MAP_HEIGHT: u32 = 14u;
const MAP_DETAIL_NORMAL: u32 = 15u;
const MAP_DETAIL_COLOR: u32 = 16u;

// How UVs change from pixel to pixel on the triangle: those of a relief jump where one height hides another.
@if(relief) var<private> drawn_uv_dx: vec4f;
@if(relief) var<private> drawn_uv_dy: vec4f;

fn has_layer(bit: u32) -> bool {
    return (material_layers & bit) != 0u;
}

fn has_map(map: u32) -> bool {
    return (material_layers & (1u << map)) != 0u;
}

// The UVs that two rows make of the surface's; `w` is 1 for UVs, and 0 for what is added to them.
fn placed_uv(uv: vec4f, w: f32, row0: vec4f, row1: vec4f) -> vec2f {
    let source = vec3f(select(uv.xy, uv.zw, row0.w > 0.5), w);
    return vec2f(dot(row0.xyz, source), dot(row1.xyz, source));
}

fn map_uv(uv: vec4f, map: u32) -> vec2f {
    return placed_uv(uv, 1.0, layer_factors.maps[map * 2u], layer_factors.maps[map * 2u + 1u]);
}

// What is added to the UVs of a map where `step` is added to those of the surface.
fn map_uv_step(step: vec4f, map: u32) -> vec2f {
    return placed_uv(step, 0.0, layer_factors.maps[map * 2u], layer_factors.maps[map * 2u + 1u]);
}

fn map_layer(map: u32) -> i32 {
    return i32(layer_factors.maps[map * 2u + 1u].w);
}

fn data_map(in: SurfaceVarying, map: u32) -> vec4f {
    if !has_map(map) {
        return vec4f(1.0);
    }
    @if(relief) {
        let sharper = exp2(-view.mip_gain);
        return textureSampleGrad(layer_data, layer_data_sampler, map_uv(in.uv, map), map_layer(map),
            map_uv_step(drawn_uv_dx, map) * sharper, map_uv_step(drawn_uv_dy, map) * sharper);
    }
    @if(!relief) {
        return textureSampleBias(layer_data, layer_data_sampler, map_uv(in.uv, map), map_layer(map), -view.mip_gain);
    }
}

fn color_map(in: SurfaceVarying, map: u32) -> vec4f {
    if !has_map(map) {
        return vec4f(1.0);
    }
    @if(relief) {
        let sharper = exp2(-view.mip_gain);
        return textureSampleGrad(layer_colors, layer_colors_sampler, map_uv(in.uv, map), map_layer(map),
            map_uv_step(drawn_uv_dx, map) * sharper, map_uv_step(drawn_uv_dy, map) * sharper);
    }
    @if(!relief) {
        return textureSampleBias(layer_colors, layer_colors_sampler, map_uv(in.uv, map), map_layer(map), -view.mip_gain);
    }
}

// How much of light that was baked about the normal `vertex` comes to a normal `bent`, of which `direction` is the mean
// of unit vectors towards it, each weighted by its share of irradiance. With k its length and d its unit vector, light on
// a normal m is taken for proportional to a + m·d, a = 3 (1 - k), and divided by that of `vertex`, so that what is not
// bent stays exactly as it was baked (after the dominant direction of Enlighten's and Unity's directional light maps,
// whose half Lambert is divided by its own value in the same way). Two points make a: light of one distant place has k = 1
// and goes by m·d; even light of half a sphere has k = 2/3 about its axis d, the integral of cosine squared over that of
// the cosine, and goes by (1 + m·d) / 2. In between it is a line; the less light has one direction, the less is bent.
fn bent_light_share(direction: vec3f, vertex: vec3f, bent: vec3f) -> f32 {
    let k = length(direction);
    let to_light = direction / max(k, 1e-6);
    let ambient = 3.0 * max(1.0 - k, 0.0);
    // Light that grazes `vertex` may come to what is bent towards it many times over; but bytes and the filter then
    // decide by how much, so that it ends at four times, which is a light 14 degrees above the horizon met head-on.
    let height = dot(vertex, to_light);
    let share = clamp((ambient + dot(bent, to_light)) / max(ambient + height, 1e-3), 0.0, 4.0);
    // No light comes from below the mesh: a texel that says so is of another surface beside this one, for which it is too
    // coarse. Nothing is known of light on this one but how much it is; over 4 degrees what is known fades in.
    // And bytes tell directions apart by 1/127: light that comes from everywhere alike has none that is to be trusted.
    return mix(1.0, share, clamp(16.0 * height, 0.0, 1.0) * clamp(8.0 * k - 0.125, 0.0, 1.0));
}

// What a white surface sends back of light that was baked about the mesh's normal `vertex`, where its normal is `bent`.
fn baked_light(in: SurfaceVarying, vertex: vec3f, bent: vec3f) -> vec3f {
    let row0 = layer_factors.light_map_rows[0];
    let row1 = layer_factors.light_map_rows[1];
    let uv = placed_uv(in.uv, 1.0, row0, row1);
    if directed_light != 0u {
        // Half a texel inside each half, so that the filter mixes nothing of the other one. There are no mips.
        let margin = vec2f(0.5, 1.0) / vec2f(textureDimensions(light_map_texture));
        let upper = clamp(uv, margin, 1.0 - margin) * vec2f(1.0, 0.5);
        let light = textureSampleLevel(light_map_texture, light_map_sampler, upper, 0.0).rgb * layer_factors.detail.y;
        if directed_light == 1u {
            return light;
        }
        let lower = upper + vec2f(0.0, 0.5);
        let direction = textureSampleLevel(light_map_texture, light_map_sampler, lower, 0.0).xyz;
        return light * bent_light_share(direction, vertex, bent);
    }
    @if(relief) {
        let sharper = exp2(-view.mip_gain);
        let texel = textureSampleGrad(light_map_texture, light_map_sampler, uv,
            placed_uv(drawn_uv_dx, 0.0, row0, row1) * sharper, placed_uv(drawn_uv_dy, 0.0, row0, row1) * sharper);
        return texel.rgb * layer_factors.detail.y;
    }
    @if(!relief) {
        return textureSampleBias(light_map_texture, light_map_sampler, uv, -view.mip_gain).rgb * layer_factors.detail.y;
    }
}
