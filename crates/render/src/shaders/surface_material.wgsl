// The material of a surface at a fragment: glTF 2.0's metallic-roughness model.

import package::view::{view, direction_to_eye_world};
import package::gbuffer::{Surface, SHADING_MODEL_UNLIT};
@if(!relief) import package::shaders::surface_lift::lift_px_of;
import package::shaders::surface_vertex::{SurfaceVarying, is_without_normals, object_id};
import package::shaders::decals::{Decaled, decaled_surface, has_decals};
@if(detailed) import package::constants::LAYER_LIGHT_MAP;
@if(detailed) import package::shaders::facet::{Facet, facet_of};
@if(detailed) import package::shaders::layer_maps::{MAP_DETAIL_COLOR, baked_light, color_map, has_layer, has_map};
@if(detailed) import package::shaders::surface_detail::detailed_normal;
@if(relief) import package::shaders::layer_maps::{drawn_uv_dx, drawn_uv_dy};

struct MaterialFactors {
    base_color: vec4f,
    // Linear, may exceed 1.
    emissive: vec3f,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    // Of the texture; without textures, how much is occluded.
    occlusion_strength: f32,
    // Fragments with less alpha are dropped.
    alpha_cutoff: f32,
    // As `gbuffer.wgsl` numbers them.
    shading_model: f32,
    material_id: u32,
    // Alpha of the surface without blending is 1.
    blended: f32,
    // 1 if both sides are drawn.
    double_sided: f32,
    // Reflectance at normal incidence of what is not metal.
    f0_dielectric: f32,
    // The share of light that comes through where the surface casts a shadow, divided by the mean of its base colour; 1
    // if it casts a shadow in part, by its alpha or as light comes through.
    cast_through: f32,
    casts_in_part: f32,
    // −1 if green of normal maps points down, as DirectX has it.
    normal_y_sign: f32,
    // Rows of the matrices that place the textures: base colour, metallic-roughness, normal, occlusion, emissive.
    // xyz of the first row, and in w the UV set; xyz of the second.
    uv_rows: array<vec4f, 10>,
}

struct SurfaceSample {
    surface: Surface,
    emission: vec3f,
    alpha: f32,
}

// 1 if there is any texture but the normal map.
override textured: u32 = 0u;
// 1 if occlusion has a texture of its own, beside that of metallic-roughness.
override occlusion_apart: u32 = 0u;
// 1 if there is a normal map.
override normal_map: u32 = 0u;
// 1 if any texture is placed by a matrix or has the second UVs. Software adapters look for texels of several textures at
// one place at little more than the price of one.
override places_uvs: u32 = 1u;

// White texels stand in for textures that there are not.
@group(2) @binding(0) var<uniform> material_factors: MaterialFactors;
@if(textures || masks) @group(2) @binding(1) var base_color_texture: texture_2d<f32>;
@if(textures || masks) @group(2) @binding(2) var base_color_sampler: sampler;
@if(textures) @group(2) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@if(textures) @group(2) @binding(4) var metallic_roughness_sampler: sampler;
@if(textures) @group(2) @binding(5) var occlusion_texture: texture_2d<f32>;
@if(textures) @group(2) @binding(6) var occlusion_sampler: sampler;
@if(textures) @group(2) @binding(7) var emissive_texture: texture_2d<f32>;
@if(textures) @group(2) @binding(8) var emissive_sampler: sampler;
@if(textures) @group(2) @binding(9) var normal_texture: texture_2d<f32>;
@if(textures) @group(2) @binding(10) var normal_sampler: sampler;

fn material_uv(uv: vec4f, slot: u32) -> vec2f {
    if places_uvs == 0u {
        return uv.xy;
    }
    let row0 = material_factors.uv_rows[slot * 2u];
    let row1 = material_factors.uv_rows[slot * 2u + 1u];
    let source = vec3f(select(uv.xy, uv.zw, row0.w > 0.5), 1.0);
    return vec2f(dot(row0.xyz, source), dot(row1.xyz, source));
}

// What is added to the UVs of a texture where `step` is added to those of the surface.
@if(relief) fn material_uv_step(step: vec4f, slot: u32) -> vec2f {
    return material_uv(step, slot) - material_uv(vec4f(0.0), slot);
}

// How UVs of a texture change from pixel to pixel on the triangle, for mips that are finer by `-bias` levels.
@if(relief) fn material_uv_dx(slot: u32, bias: f32) -> vec2f {
    return material_uv_step(drawn_uv_dx, slot) * exp2(bias);
}

@if(relief) fn material_uv_dy(slot: u32, bias: f32) -> vec2f {
    return material_uv_step(drawn_uv_dy, slot) * exp2(bias);
}

// What is added to the mip level of textures. A pixel's footprint on a surface seen at a slant is 1 / n.v times as long
// as wide, and what samplers do not make up for of that, they blur by its length. But n samples, which lie apart in
// every direction, need no coarser texels than the n-th part of the footprint's area, nor finer ones than of its
// length.
fn surface_mip_bias(in: SurfaceVarying) -> f32 {
    let length_squared = dot(in.normal_world, in.normal_world);
    let n_dot_v = abs(dot(in.normal_world, direction_to_eye_world(in.position_world)))
        * inverseSqrt(max(length_squared, 1e-30));
    let elongation = 1.0 / max(n_dot_v * view.anisotropy, 1e-3);
    return -view.mip_gain - clamp(0.5 * log2(elongation), 0.0, view.mip_gain);
}

// The normal of the mesh on the side that is seen. Interpolation shortens normals; a vanishing one must not become a
// NaN.
fn vertex_normal_of(in: SurfaceVarying, front_facing: bool) -> vec3f {
    let length_squared = dot(in.normal_world, in.normal_world);
    return select(vec3f(0.0, 1.0, 0.0), in.normal_world * inverseSqrt(max(length_squared, 1e-30)),
        length_squared > 1e-20) * select(-1.0, 1.0, front_facing);
}

// A direction along the surface, by tangent and bitangent of the UVs that two rows make of the mesh's, by those of the
// mesh. Tangents are for the mesh's UVs, and a map that is turned turns what it says: of UVs M (u, v) the tangent is the
// first column of the inverse of M, and the bitangent, against v, is across it.
fn unplaced_direction(direction: vec2f, row0: vec4f, row1: vec4f) -> vec2f {
    let length_squared = dot(row1.xy, row1.xy);
    let side = select(-1.0, 1.0, row0.x * row1.y >= row0.y * row1.x);
    let turn = select(vec2f(1.0, 0.0), row1.yx * inverseSqrt(max(length_squared, 1e-36)), length_squared > 1e-30);
    let along = direction.x * side;
    return vec2f(turn.x * along - turn.y * direction.y, turn.y * along + turn.x * direction.y);
}

// That normal bent as a texel of a normal map says, whose UVs the rows make of the mesh's.
fn bent_normal(
    in: SurfaceVarying, front_facing: bool, texel: vec3f, scale: f32, row0: vec4f, row1: vec4f,
) -> vec3f {
    let vertex_normal = vertex_normal_of(in, front_facing);
    let facing = select(-1.0, 1.0, front_facing);
    let encoded = texel * 2.0 - 1.0;
    let placed = vec2f(encoded.x, encoded.y * material_factors.normal_y_sign) * scale;
    let offset = vec3f(unplaced_direction(placed, row0, row1), encoded.z);
    let tangent = in.tangent_world.xyz;
    let bitangent = cross(in.normal_world, tangent) * in.tangent_world.w;
    let bent = (tangent * offset.x + bitangent * offset.y) * facing + vertex_normal * offset.z;
    let length_squared = dot(bent, bent);
    return select(vertex_normal, bent * inverseSqrt(max(length_squared, 1e-30)), length_squared > 1e-12);
}

fn shading_normal(in: SurfaceVarying, bias: f32, front_facing: bool) -> vec3f {
    @if(textures) {
        if normal_map != 0u {
            @if(!relief) let texel = textureSampleBias(normal_texture, normal_sampler, material_uv(in.uv, 2u), bias).xyz;
            @if(relief) let texel = textureSampleGrad(normal_texture, normal_sampler, material_uv(in.uv, 2u),
                material_uv_dx(2u, bias), material_uv_dy(2u, bias)).xyz;
            var row0 = vec4f(1.0, 0.0, 0.0, 0.0);
            var row1 = vec4f(0.0, 1.0, 0.0, 0.0);
            if places_uvs != 0u {
                row0 = material_factors.uv_rows[4];
                row1 = material_factors.uv_rows[5];
            }
            return bent_normal(in, front_facing, texel, material_factors.normal_scale, row0, row1);
        }
    }
    return vertex_normal_of(in, front_facing);
}

// Base colour and alpha, by one expression, so that a pass which draws a surface again drops the same fragments.
fn surface_base_color(in: SurfaceVarying, bias: f32) -> vec4f {
    let factors = material_factors.base_color * in.color;
    @if(textures || masks) {
        if textured != 0u {
            let uv = material_uv(in.uv, 0u);
            @if(!relief) let texel = textureSampleBias(base_color_texture, base_color_sampler, uv, bias);
            @if(relief) let texel = textureSampleGrad(base_color_texture, base_color_sampler, uv,
                material_uv_dx(0u, bias), material_uv_dy(0u, bias));
            return factors * texel;
        }
    }
    return factors;
}

@if(!detailed) fn surface_sample(in: SurfaceVarying, front_facing: bool) -> SurfaceSample {
    var out = surface_sample_of(in, front_facing);
    if has_decals() {
        put_decals(&out, in, front_facing, dpdx(in.position_world), dpdy(in.position_world));
    }
    return out;
}

// Lays decals over what the material says.
fn put_decals(sample: ptr<function, SurfaceSample>, in: SurfaceVarying, front_facing: bool, dx: vec3f, dy: vec3f) {
    let surface = (*sample).surface;
    let is_unlit = surface.shading_model == SHADING_MODEL_UNLIT;
    // What is unlit glows in its colour.
    let below = Decaled(
        select(surface.base_color, (*sample).emission, is_unlit),
        surface.metallic,
        surface.roughness_perceptual,
        surface.normal_world,
        select((*sample).emission, vec3f(0.0), is_unlit),
    );
    let vertex = vertex_normal_of(in, front_facing);
    let decaled = decaled_surface(below, in.position_clip.xy, in.position_world, dx, dy, vertex, object_id(in.object));
    (*sample).surface.base_color = clamp(decaled.base_color, vec3f(0.0), vec3f(1.0));
    (*sample).surface.metallic = decaled.metallic;
    (*sample).surface.roughness_perceptual = decaled.roughness_perceptual;
    (*sample).surface.normal_world = decaled.normal_world;
    (*sample).emission = decaled.emission + select(vec3f(0.0), decaled.base_color, is_unlit);
}

@if(detailed) fn surface_sample(in: SurfaceVarying, front_facing: bool) -> SurfaceSample {
    return detailed_sample(in, facet_of(in.position_world, in.uv), front_facing);
}

// With all that is laid over the maps; the triangle is that on which the surface was drawn.
@if(detailed) fn detailed_sample(in: SurfaceVarying, facet: Facet, front_facing: bool) -> SurfaceSample {
    var out = surface_sample_of(in, front_facing);
    let facing = select(-1.0, 1.0, front_facing);
    let vertex = vertex_normal_of(in, front_facing);
    let y_sign = material_factors.normal_y_sign;
    out.surface.normal_world = detailed_normal(in, facet, out.surface.normal_world, vertex, facing, y_sign);
    let is_unlit = out.surface.shading_model == SHADING_MODEL_UNLIT;
    if has_map(MAP_DETAIL_COLOR) {
        let factor = 2.0 * color_map(in, MAP_DETAIL_COLOR).rgb;
        out.surface.base_color = clamp(out.surface.base_color * factor, vec3f(0.0), vec3f(1.0));
        out.emission = select(out.emission, out.emission * factor, is_unlit);
    }
    if has_decals() {
        put_decals(&out, in, front_facing, facet.position_dx, facet.position_dy);
    }
    if has_layer(LAYER_LIGHT_MAP) {
        // Maps are of the front, and what is unlit has no normals.
        let bent = select(out.surface.normal_world, vertex, is_unlit);
        let light = baked_light(in, vertex * facing, bent * facing);
        let reflected = out.surface.base_color * (1.0 - out.surface.metallic) * light;
        out.emission = select(out.emission + reflected, out.emission * light, is_unlit);
    }
    return out;
}

// 1 if surfaces with one side are drawn from behind, too: black.
override backs_are_black: u32 = 0u;

fn surface_sample_of(in: SurfaceVarying, front_facing: bool) -> SurfaceSample {
    var out: SurfaceSample;
    let bias = surface_mip_bias(in);
    let base_color = surface_base_color(in, bias);
    var metallic = material_factors.metallic;
    var roughness = material_factors.roughness;
    // Without a texture the strength is 0, or that of the mean of one.
    var occlusion = 1.0 - material_factors.occlusion_strength;
    var emission = material_factors.emissive;
    @if(textures) {
        if textured != 0u {
            let rough_metal_uv = material_uv(in.uv, 1u);
            @if(!relief) let rough_metal =
                textureSampleBias(metallic_roughness_texture, metallic_roughness_sampler, rough_metal_uv, -view.mip_gain);
            @if(relief) let rough_metal = textureSampleGrad(metallic_roughness_texture, metallic_roughness_sampler, rough_metal_uv,
                material_uv_dx(1u, -view.mip_gain), material_uv_dy(1u, -view.mip_gain));
            roughness *= rough_metal.g;
            metallic *= rough_metal.b;
            var occluded = rough_metal.r;
            if occlusion_apart != 0u {
                let occlusion_uv = material_uv(in.uv, 3u);
                @if(!relief) let texel = textureSampleBias(occlusion_texture, occlusion_sampler, occlusion_uv, -view.mip_gain);
                @if(relief) let texel = textureSampleGrad(occlusion_texture, occlusion_sampler, occlusion_uv,
                    material_uv_dx(3u, -view.mip_gain), material_uv_dy(3u, -view.mip_gain));
                occluded = texel.r;
            }
            occlusion = 1.0 + material_factors.occlusion_strength * (occluded - 1.0);
            @if(!relief) emission *= textureSampleBias(emissive_texture, emissive_sampler, material_uv(in.uv, 4u), bias).rgb;
            @if(relief) emission *= textureSampleGrad(emissive_texture, emissive_sampler, material_uv(in.uv, 4u),
                material_uv_dx(4u, bias), material_uv_dy(4u, bias)).rgb;
        }
    }
    let is_unlit_material = material_factors.shading_model == SHADING_MODEL_UNLIT;
    // What only lacks normals glows as well.
    let unlit = is_unlit_material | is_without_normals(in.object);
    let unlit_radiance = base_color.rgb + select(emission, vec3f(0.0), is_unlit_material);
    out.alpha = base_color.a;
    out.emission = select(emission, unlit_radiance, unlit);
    out.surface.base_color = clamp(base_color.rgb, vec3f(0.0), vec3f(1.0));
    out.surface.occlusion = occlusion;
    out.surface.normal_world = shading_normal(in, -view.mip_gain, front_facing);
    out.surface.metallic = clamp(metallic, 0.0, 1.0);
    out.surface.roughness_perceptual = clamp(roughness, 0.0, 1.0);
    out.surface.f0_dielectric = material_factors.f0_dielectric;
    out.surface.shading_model = select(material_factors.shading_model, SHADING_MODEL_UNLIT, unlit);
    // What is sunk into a triangle lies beside the plane that was interpolated.
    @if(!relief) out.surface.lift_px = lift_px_of(in, front_facing);
    if backs_are_black != 0u {
        if !front_facing && material_factors.double_sided < 0.5 {
            out.emission = vec3f(0.0);
            out.surface.shading_model = SHADING_MODEL_UNLIT;
        }
    }
    return out;
}
