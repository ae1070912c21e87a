// Positions and normals as floats with specular intensity and power in their fourth channels, then a volume for every
// light.

struct Stored {
    // Two passes have to find the same depth.
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) diffuse: vec3f,
    @location(3) emission: vec3f,
    @location(4) specular: vec2f,
}

@vertex
fn vs_geometry(surface: SurfaceVertex) -> Stored {
    return Stored(
        frame.clip_from_world * vec4f(surface.position_world, 1.0),
        surface.position_world,
        surface.normal_world,
        surface.diffuse,
        surface.emission,
        surface.specular,
    );
}

fn position_texel(stored: Stored) -> vec4f {
    return vec4f(stored.position_world, stored.specular.x);
}

fn normal_texel(stored: Stored) -> vec4f {
    return vec4f(normalize(stored.normal_world), stored.specular.y);
}

// The light that needs no lamp.
fn first_light(stored: Stored) -> vec4f {
    return vec4f(frame.ambient.rgb * stored.diffuse + stored.emission, 1.0);
}

struct Targets {
    @location(0) position: vec4f,
    @location(1) normal: vec4f,
    @location(2) diffuse: vec4f,
    @location(3) accumulation: vec4f,
}

@fragment
fn fs_all(stored: Stored) -> Targets {
    return Targets(position_texel(stored), normal_texel(stored), vec4f(stored.diffuse, 1.0), first_light(stored));
}

struct Vectors {
    @location(0) position: vec4f,
    @location(1) normal: vec4f,
}

@fragment
fn fs_vectors(stored: Stored) -> Vectors {
    return Vectors(position_texel(stored), normal_texel(stored));
}

struct Colours {
    @location(0) diffuse: vec4f,
    @location(1) accumulation: vec4f,
}

@fragment
fn fs_colours(stored: Stored) -> Colours {
    return Colours(vec4f(stored.diffuse, 1.0), first_light(stored));
}

@group(0) @binding(1) var positions: texture_2d<f32>;
@group(0) @binding(2) var normals: texture_2d<f32>;
@group(0) @binding(3) var diffuse_colours: texture_2d<f32>;

struct Volume {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) light_world: vec4f,
    @location(1) @interpolate(flat) intensity: vec4f,
}

@vertex
fn vs_volume(@location(0) corner: vec3f, light: LightVertex) -> Volume {
    // The mesh is that of a ball of 1 m, whose chords are less than 2 % within it.
    let corner_world = light.position_world.xyz + corner * light.position_world.w * 1.02;
    return Volume(frame.clip_from_world * vec4f(corner_world, 1.0), light.position_world, light.intensity);
}

@fragment
fn fs_mark() {}

@fragment
fn fs_volume(volume: Volume) -> @location(0) vec4f {
    let pixel = vec2i(volume.position.xy);
    let position = textureLoad(positions, pixel, 0);
    let normal = textureLoad(normals, pixel, 0);
    let diffuse = textureLoad(diffuse_colours, pixel, 0).rgb;
    let towards_light = volume.light_world.xyz - position.xyz;
    let distance_squared = dot(towards_light, towards_light);
    let to_light = towards_light * inverseSqrt(max(distance_squared, 1e-12));
    let to_eye = normalize(frame.eye_world.xyz - position.xyz);
    let reflected = blinn_phong(normal.xyz, to_light, to_eye, diffuse, position.w, normal.w);
    return vec4f(reflected * volume.intensity.rgb * attenuation(distance_squared, volume.light_world.w), 0.0);
}

@group(0) @binding(4) var accumulation: texture_2d<f32>;

@vertex
fn vs_composite(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return clip_of_corner(index);
}

@fragment
fn fs_composite(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureLoad(accumulation, vec2i(position.xy), 0);
}
