// Normal, light vector and eye vector in camera space, then a full-screen pass.

struct Stored {
    @builtin(position) position_clip: vec4f,
    @location(0) normal_view: vec3f,
    @location(1) towards_light_view: vec3f,
    @location(2) towards_eye_view: vec3f,
    @location(3) diffuse: vec3f,
}

@vertex
fn vs_geometry(surface: SurfaceVertex, light: LightVertex) -> Stored {
    let position_view = (frame.view_from_world * vec4f(surface.position_world, 1.0)).xyz;
    var stored: Stored;
    stored.position_clip = frame.clip_from_world * vec4f(surface.position_world, 1.0);
    stored.normal_view = (frame.view_from_world * vec4f(surface.normal_world, 0.0)).xyz;
    stored.towards_light_view = (frame.view_from_world * vec4f(light.position_world.xyz, 1.0)).xyz - position_view;
    stored.towards_eye_view = -position_view;
    stored.diffuse = surface.diffuse;
    return stored;
}

struct Targets {
    @location(0) normal: vec4f,
    @location(1) light: vec4f,
    @location(2) eye: vec4f,
}

// The light vector keeps its length, from which the full-screen pass knows how much light arrives. The fourth channels
// hold the diffuse colour.
@fragment
fn fs_geometry(stored: Stored) -> Targets {
    return Targets(
        vec4f(normalize(stored.normal_view), stored.diffuse.r),
        vec4f(stored.towards_light_view, stored.diffuse.g),
        vec4f(normalize(stored.towards_eye_view), stored.diffuse.b),
    );
}

@group(0) @binding(1) var normals: texture_2d<f32>;
@group(0) @binding(2) var light_vectors: texture_2d<f32>;
@group(0) @binding(3) var eye_vectors: texture_2d<f32>;

struct Lit {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) intensity: vec4f,
    @location(1) @interpolate(flat) range_m: f32,
}

@vertex
fn vs_light(@builtin(vertex_index) index: u32, light: LightVertex) -> Lit {
    return Lit(clip_of_corner(index), light.intensity, light.position_world.w);
}

// Adds one light; the first brings the ambient light with it. Where there is no surface all is 0.
@fragment
fn fs_light(lit: Lit) -> @location(0) vec4f {
    let pixel = vec2i(lit.position.xy);
    let normal = textureLoad(normals, pixel, 0);
    let towards_light = textureLoad(light_vectors, pixel, 0);
    let to_eye = textureLoad(eye_vectors, pixel, 0);
    let diffuse = vec3f(normal.a, towards_light.a, to_eye.a);
    let distance_squared = dot(towards_light.xyz, towards_light.xyz);
    let to_light = towards_light.xyz * inverseSqrt(max(distance_squared, 1e-12));
    let reflected = blinn_phong(normal.xyz, to_light, to_eye.xyz, diffuse, frame.specular.x, frame.specular.y);
    let radiance = reflected * lit.intensity.rgb * attenuation(distance_squared, lit.range_m);
    return vec4f(radiance + frame.ambient.rgb * diffuse * lit.intensity.a, 1.0);
}
