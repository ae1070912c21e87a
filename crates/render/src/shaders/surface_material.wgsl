// The material of a surface at a fragment: glTF 2.0's metallic-roughness model.

import package::view::{view, direction_to_eye_world};
import package::gbuffer::{Surface, SHADING_MODEL_UNLIT};
import package::shaders::surface_vertex::{SurfaceVarying, is_without_normals};

struct MaterialFactors {
    base_color: vec4f,
    // Linear, may exceed 1.
    emissive: vec3f,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
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
    // What alpha is multiplied by where the surface casts a shadow, and 1 if it casts one in part, as alpha says.
    cast_alpha: f32,
    casts_in_part: f32,
    padding: f32,
    // Rows of the matrices that place the textures: base colour, metallic-roughness, normal, occlusion, emissive.
    // xyz of the first row, and in w the UV set; xyz of the second.
    uv_rows: array<vec4f, 10>,
}

struct SurfaceSample {
    surface: Surface,
    emission: vec3f,
    alpha: f32,
}

@group(2) @binding(0) var<uniform> material_factors: MaterialFactors;
@if(textured) @group(2) @binding(1) var base_color_texture: texture_2d<f32>;
@if(textured) @group(2) @binding(2) var base_color_sampler: sampler;
@if(textured) @group(2) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@if(textured) @group(2) @binding(4) var metallic_roughness_sampler: sampler;
@if(occlusion_apart) @group(2) @binding(5) var occlusion_texture: texture_2d<f32>;
@if(occlusion_apart) @group(2) @binding(6) var occlusion_sampler: sampler;
@if(textured) @group(2) @binding(7) var emissive_texture: texture_2d<f32>;
@if(textured) @group(2) @binding(8) var emissive_sampler: sampler;
@if(normal_map) @group(2) @binding(9) var normal_texture: texture_2d<f32>;
@if(normal_map) @group(2) @binding(10) var normal_sampler: sampler;

fn material_uv(uv: vec4f, slot: u32) -> vec2f {
    let row0 = material_factors.uv_rows[slot * 2u];
    let row1 = material_factors.uv_rows[slot * 2u + 1u];
    let source = vec3f(select(uv.xy, uv.zw, row0.w > 0.5), 1.0);
    return vec2f(dot(row0.xyz, source), dot(row1.xyz, source));
}

// What is added to the mip level of textures. A pixel's footprint on a surface seen at a slant is 1 / n.v times as long as
// wide, and what samplers do not make up for of that, they blur by its length. But n samples, which lie apart in every
// direction, need no coarser texels than the n-th part of the footprint's area, nor finer ones than of its length.
fn surface_mip_bias(in: SurfaceVarying) -> f32 {
    let length_squared = dot(in.normal_world, in.normal_world);
    let n_dot_v = abs(dot(in.normal_world, direction_to_eye_world(in.position_world)))
        * inverseSqrt(max(length_squared, 1e-30));
    let elongation = 1.0 / max(n_dot_v * view.anisotropy, 1e-3);
    return -view.mip_gain - clamp(0.5 * log2(elongation), 0.0, view.mip_gain);
}

// The normal of the mesh on the side that is seen. Interpolation shortens normals; a vanishing one must not become a NaN.
fn vertex_normal_of(in: SurfaceVarying, front_facing: bool) -> vec3f {
    let length_squared = dot(in.normal_world, in.normal_world);
    return select(vec3f(0.0, 1.0, 0.0), in.normal_world * inverseSqrt(max(length_squared, 1e-30)),
        length_squared > 1e-20) * select(-1.0, 1.0, front_facing);
}

// That normal bent as a texel of a normal map says.
fn bent_normal(in: SurfaceVarying, front_facing: bool, texel: vec3f, scale: f32) -> vec3f {
    let vertex_normal = vertex_normal_of(in, front_facing);
    let facing = select(-1.0, 1.0, front_facing);
    let encoded = texel * 2.0 - 1.0;
    let offset = vec3f(encoded.xy * scale, encoded.z);
    let tangent = in.tangent_world.xyz;
    let bitangent = cross(in.normal_world, tangent) * in.tangent_world.w;
    let bent = (tangent * offset.x + bitangent * offset.y) * facing + vertex_normal * offset.z;
    let length_squared = dot(bent, bent);
    return select(vertex_normal, bent * inverseSqrt(max(length_squared, 1e-30)), length_squared > 1e-12);
}

fn shading_normal(in: SurfaceVarying, bias: f32, front_facing: bool) -> vec3f {
    @if(normal_map) {
        let texel = textureSampleBias(normal_texture, normal_sampler, material_uv(in.uv, 2u), bias).xyz;
        return bent_normal(in, front_facing, texel, material_factors.normal_scale);
    }
    @if(!normal_map) {
        return vertex_normal_of(in, front_facing);
    }
}

// Base colour and alpha, by one expression, so that a pass which draws a surface again drops the same fragments.
fn surface_base_color(in: SurfaceVarying, bias: f32) -> vec4f {
    let factors = material_factors.base_color * in.color;
    @if(textured) {
        let uv = material_uv(in.uv, 0u);
        return factors * textureSampleBias(base_color_texture, base_color_sampler, uv, bias);
    }
    @if(!textured) {
        return factors;
    }
}

fn surface_sample(in: SurfaceVarying, front_facing: bool) -> SurfaceSample {
    var out: SurfaceSample;
    let bias = surface_mip_bias(in);
    let base_color = surface_base_color(in, bias);
    var metallic = material_factors.metallic;
    var roughness = material_factors.roughness;
    var occlusion = 1.0;
    var emission = material_factors.emissive;
    @if(textured) {
        let rough_metal_uv = material_uv(in.uv, 1u);
        let rough_metal =
            textureSampleBias(metallic_roughness_texture, metallic_roughness_sampler, rough_metal_uv, -view.mip_gain);
        roughness *= rough_metal.g;
        metallic *= rough_metal.b;
        var occluded = rough_metal.r;
        @if(occlusion_apart) {
            occluded = textureSampleBias(occlusion_texture, occlusion_sampler, material_uv(in.uv, 3u), -view.mip_gain).r;
        }
        occlusion = 1.0 + material_factors.occlusion_strength * (occluded - 1.0);
        emission *= textureSampleBias(emissive_texture, emissive_sampler, material_uv(in.uv, 4u), bias).rgb;
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
    return out;
}
