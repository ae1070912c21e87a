// gouraud: light is computed at the vertices, and interpolated over triangles. The base colour stays the pixel's: what
// is interpolated is diffuse light for a base colour of 1, and specular light with the vertex's own base colour.
// Reads: the lists of lights of objects, the environment. Writes: radiance (premultiplied), depth if opaque; with
// `counts_pairs` vertices are drawn as points anywhere, and the numbers of pairs of vertex and light are written.
// Program: gouraud, also for points. Axes: textures.

import package::view::{view, direction_to_eye_world};
import package::gbuffer::{Surface, SHADING_MODEL_UNLIT, SHADING_MODEL_STANDARD};
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, masked, surface_varying, object_id, is_without_normals};
import package::shaders::level_fade::{fades, is_faded};
import package::shaders::surface_material::{material_factors, material_uv, surface_sample};
import package::shaders::surface_material::surface_mip_bias;
import package::shaders::surface_material::{occlusion_apart, textured};
@if(textures) import package::shaders::surface_material::{
    base_color_texture, base_color_sampler, metallic_roughness_texture, metallic_roughness_sampler, occlusion_texture,
    occlusion_sampler,
};
import package::shaders::brdf::set_lamp_terms;
import package::shaders::shaded_place::shading_at;
import package::shaders::shadows::shadowed;
import package::shaders::lights::{counts_pairs, pair_counts};
import package::shaders::light_lists::object_light_sums;
import package::shaders::ambient::ambient_radiance;
import package::shaders::fog::{fogged, fog_transmittance};
import package::shaders::fog_light::light_in_fog_before;
import package::shaders::colour::half_float_clamped;
import package::shaders::glow::glow_share;
import package::shaders::mask::is_masked_out;
import package::shaders::transparency::{ShadedTargets, is_let_through, is_peeled, shaded_targets};

// As many as there are.
const ALL_LIGHTS: u32 = 0xffffffffu;
// 1 if the light that fog scatters before the surface is added, which blended surfaces alone do for themselves.
override in_lit_fog: u32 = 0u;

struct GouraudVarying {
    @invariant @builtin(position) position_clip: vec4f,
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) uv: vec4f,
    @location(3) color: vec4f,
    @location(4) diffuse: vec3f,
    @location(5) specular: vec3f,
    @location(6) @interpolate(flat, either) object: u32,
    @if(points) @location(7) corner: vec2f,
    @if(!points) @location(7) position_object: vec3f,
}

// The material at a vertex: the finest texels, because a vertex has no footprint. Normal maps are left out.
fn surface_at_vertex(in: SurfaceVarying) -> Surface {
    var surface: Surface;
    var base_color = material_factors.base_color.rgb * in.color.rgb;
    surface.metallic = material_factors.metallic;
    surface.roughness_perceptual = material_factors.roughness;
    surface.occlusion = 1.0 - material_factors.occlusion_strength;
    @if(textures) {
        if textured != 0u {
            base_color *= textureSampleLevel(base_color_texture, base_color_sampler, material_uv(in.uv, 0u), 0.0).rgb;
            let rough_metal_uv = material_uv(in.uv, 1u);
            let rough_metal = textureSampleLevel(metallic_roughness_texture, metallic_roughness_sampler, rough_metal_uv, 0.0);
            surface.roughness_perceptual *= rough_metal.g;
            surface.metallic *= rough_metal.b;
            var occluded = rough_metal.r;
            if occlusion_apart != 0u {
                occluded = textureSampleLevel(occlusion_texture, occlusion_sampler, material_uv(in.uv, 3u), 0.0).r;
            }
            surface.occlusion = 1.0 + material_factors.occlusion_strength * (occluded - 1.0);
        }
    }
    surface.base_color = clamp(base_color, vec3f(0.0), vec3f(1.0));
    surface.metallic = clamp(surface.metallic, 0.0, 1.0);
    surface.roughness_perceptual = clamp(surface.roughness_perceptual, 0.0, 1.0);
    surface.f0_dielectric = 0.04;
    surface.shading_model = SHADING_MODEL_STANDARD;
    // Of what has two sides the one that faces the eye is lit.
    let faces_away = dot(in.normal_world, direction_to_eye_world(in.position_world)) < 0.0;
    surface.normal_world = in.normal_world * select(1.0, -1.0, faces_away & (material_factors.double_sided > 0.5));
    return surface;
}

// A pixel that few vertices share, for numbers that are added up.
fn pixel_of_vertex_ndc(vertex: u32, object: u32) -> vec2f {
    // Multiplicative hashing (Knuth 1973).
    let scattered = (vertex * 2654435761u) ^ (object * 2246822519u);
    let size_px = vec2u(view.size_px);
    let pixel = (scattered >> 4u) % (size_px.x * size_px.y);
    let middle_px = vec2f(f32(pixel % size_px.x), f32(pixel / size_px.x)) + 0.5;
    return 2.0 * middle_px * view.inverse_size_px - 1.0;
}

@vertex
fn vs_gouraud(in: SurfaceInput) -> GouraudVarying {
    let vertex = surface_varying(in);
    let surface = surface_at_vertex(vertex);
    var shading = shading_at(surface, vertex.position_world);
    if shadowed != 0u {
        shading.facet_normal = surface.normal_world;
    }
    let object = object_id(vertex.object);
    // Reflectance is linear in albedo: what an albedo of 0 leaves is specular, and the rest of that of 1 diffuse.
    shading.albedo = vec3f(0.0);
    set_lamp_terms(&shading);
    let ambient_specular = ambient_radiance(surface, shading);
    shading.albedo = vec3f(1.0 - surface.metallic);
    set_lamp_terms(&shading);
    let sums = object_light_sums(object, 0u, ALL_LIGHTS, vertex.position_world, shading);
    var out: GouraudVarying;
    out.position_clip = vertex.position_clip;
    out.position_world = vertex.position_world;
    out.normal_world = vertex.normal_world;
    out.uv = vertex.uv;
    out.color = vertex.color;
    out.specular = ambient_specular + sums.specular;
    out.diffuse = ambient_radiance(surface, shading) + sums.radiance - out.specular;
    out.object = vertex.object;
    @if(points) {
        out.corner = vertex.corner;
    }
    @if(!points) {
        out.position_object = vertex.position_object;
    }
    if counts_pairs != 0u {
        out.position_clip = vec4f(pixel_of_vertex_ndc(in.vertex, vertex.object), 0.5, 1.0);
        out.color = pair_counts(sums);
    }
    return out;
}

@fragment
fn fs_gouraud(in: GouraudVarying, @builtin(front_facing) front_facing: bool) -> ShadedTargets {
    if counts_pairs != 0u {
        return ShadedTargets(in.color, vec4f(0.0));
    }
    var vertex: SurfaceVarying;
    vertex.position_clip = in.position_clip;
    vertex.position_world = in.position_world;
    vertex.normal_world = in.normal_world;
    vertex.uv = in.uv;
    vertex.color = in.color;
    vertex.object = in.object;
    @if(!points) {
        vertex.position_object = in.position_object;
    }
    let sample = surface_sample(vertex, front_facing);
    if is_peeled(in.position_clip, in.position_world) {
        discard;
    }
    if fades != 0u {
        if is_faded(in.position_clip.xy, in.object) {
            discard;
        }
    }
    @if(points) {
        if dot(in.corner, in.corner) > 1.0 {
            discard;
        }
    }
    if masked != 0u {
        if is_masked_out(vertex, sample.alpha, surface_mip_bias(vertex)) {
            discard;
        }
    }
    if is_let_through(vertex, sample.alpha, front_facing) {
        discard;
    }
    let is_lit = select(1.0, 0.0, sample.surface.shading_model == SHADING_MODEL_UNLIT);
    let light = max(sample.surface.base_color * in.diffuse + in.specular, vec3f(0.0));
    var radiance = fogged(sample.emission * view.pre_exposure + light * is_lit, in.position_world);
    if in_lit_fog != 0u {
        radiance += light_in_fog_before(in.position_clip.xy, in.position_world);
    }
    let glow = glow_share(half_float_clamped(sample.emission * view.pre_exposure));
    let opaque_alpha = 1.0 + glow * fog_transmittance(in.position_world);
    return shaded_targets(radiance, opaque_alpha, sample.alpha, in.position_world);
}
