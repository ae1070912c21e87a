// particles: billboards that face the eye, along their way where they are drawn for some time of it, and fade before surfaces.
// Those that hide something leave sums: radiance times optical depth, and the square root of what comes through all of them;
// so that what is seen is the mean of all by optical depth, whatever their order; what is behind others came with less
// radiance (`shade.wgsl`). Others add light.
// Source: mean of a medium's source by optical depth (Chandrasekhar 1950), in place of sorting; soft particles (Lorach 2007).
// Ragged ones lose smooth noise of two octaves at their edges, each another part of it.
// Reads: the states of what moves them, their light, linear_depth. Writes: sums, or radiance.
// Program: particles.

import package::view::view;
import package::passes::particles::uniform::{OPACITY_MAX, opacity_at, particles, place, radius_at, velocity};

@group(1) @binding(4) var light: texture_2d<f32>;
@group(1) @binding(5) var linear_depth: texture_2d<f32>;

// 1 if they add light and hide nothing.
override adds: u32 = 0u;
// 1 if the view is cut by a plane, as one behind a mirror is.
override is_cut: u32 = 0u;

// Nothing is nearer than that.
const NEAR_M: f32 = 0.02;
// What is thinner is drawn as wide as that in pixels, and fainter.
const RADIUS_MIN_PX: f32 = 0.6;
// Waves of the noise in the radius of a ragged one, its contrast, how much it takes at the edge, and how fast it turns.
const RAGS: f32 = 1.8;
const RAGS_CONTRAST: f32 = 2.4;
const RAGGED_LOSS: f32 = 1.6;
const TURN_RAD_S: f32 = 0.12;

struct ParticleVarying {
    @builtin(position) position_clip: vec4f,
    // From -1 to 1 across and along.
    @location(0) place: vec2f,
    @location(1) @interpolate(flat, either) radiance: vec3f,
    // How much its middle hides, or the share of its light; the distance along the view's axis.
    @location(2) @interpolate(flat, either) strength: vec2f,
    // In the noise of ragged edges.
    @location(3) noise_place: vec2f,
}

@vertex
fn vs_particles(@builtin(vertex_index) vertex: u32, @builtin(instance_index) index: u32) -> ParticleVarying {
    let cell = vec2i(vec2u(index % particles.columns, index / particles.columns));
    let at = textureLoad(place, cell, 0);
    let moves = textureLoad(velocity, cell, 0);
    let lit = textureLoad(light, cell, 0);
    var out: ParticleVarying;
    // Behind the eye, where nothing is drawn.
    out.position_clip = vec4f(0.0, 0.0, 2.0, 1.0);
    let middle = (view.view_from_world * vec4f(at.xyz, 1.0)).xyz;
    if (at.w < 0.0) | (lit.a == 0.0) | ((view.orthographic == 0.0) & (-middle.z < NEAR_M)) {
        return out;
    }
    let share = clamp(at.w / max(moves.w, 1e-6), 0.0, 1.0);
    let half_way = 0.5 * particles.stretch_secs * (view.view_from_world * vec4f(moves.xyz, 0.0)).xyz;
    let scale = mix(-middle.z, 1.0, view.orthographic);
    let metres_a_pixel = 2.0 * view.view_from_ndc_scale.y * view.inverse_size_px.y * scale;
    let radius_m = radius_at(share);
    let drawn_m = max(radius_m, RADIUS_MIN_PX * metres_a_pixel);
    // As much is hidden in all, or shone, over a wider strip.
    var thin = radius_m / drawn_m;
    let length_m = length(half_way.xy);
    let along = select(vec2f(0.0, 1.0), half_way.xy / max(length_m, 1e-9), length_m > 1e-9);
    let reach_m = max(radius_m + length_m, drawn_m);
    thin *= (radius_m + length_m) / reach_m;
    // What is stretched is as bright in all as it is at rest.
    let stretched = select(1.0, radius_m / (radius_m + length_m), adds != 0u);
    // 0, 1, 2 and 3, 2, 1.
    let corner = select(vertex, 6u - vertex, vertex > 2u);
    let sides = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let across = vec2f(along.y, -along.x);
    let offset = sides.x * across * drawn_m + sides.y * along * reach_m;
    // The middle of the way is moved no further along the view's axis, where it would cross the eye.
    let corner_view = vec3f(middle.xy + offset, middle.z);
    out.position_clip = view.clip_from_world * (view.world_from_view * vec4f(corner_view, 1.0));
    if is_cut != 0u {
        let middle_clip = view.clip_from_world * vec4f(at.xyz, 1.0);
        if middle_clip.z > middle_clip.w {
            out.position_clip = vec4f(0.0, 0.0, 2.0, 1.0);
            return out;
        }
    }
    // The near and the far plane lie around surfaces; distances are compared below.
    out.position_clip.z = 0.5 * out.position_clip.w;
    // What the eye is in does not hide everything at once.
    let nears = select(1.0, clamp(-middle.z / (2.0 * radius_m) - 0.25, 0.0, 1.0), particles.softness_m > 0.0);
    out.place = sides;
    out.radiance = lit.rgb;
    out.strength = vec2f(select(opacity_at(share), stretched, adds != 0u) * thin * nears, -middle.z);
    // Neighbours have other parts of the noise, and turn to other sides. Places stay above 0.
    let number = f32(index % 4093u);
    let turn = TURN_RAD_S * at.w * (4.0 * fract(0.5 * number) - 1.0) + 6.2831853 * fract(0.618034 * number);
    let turned = vec2f(cos(turn) * sides.x - sin(turn) * sides.y, sin(turn) * sides.x + cos(turn) * sides.y);
    out.noise_place = RAGS * turned + 61.0 * fract(number * vec2f(0.7548777, 0.5698403)) + 4.0;
    return out;
}

// From 0 to 1, another number at every corner of the noise.
fn chance_at(corner: vec2f) -> f32 {
    let at = vec2u(corner);
    var bits = (at.x * 0x8da6b343u) ^ (at.y * 0xd8163841u);
    bits = (bits ^ (bits >> 15u)) * 0x2c1b3c6du;
    bits = (bits ^ (bits >> 12u)) * 0x297a2d39u;
    return f32(bits >> 8u) / 16777216.0;
}

fn noise_at(at: vec2f) -> f32 {
    let corner = floor(at);
    let f = at - corner;
    let s = f * f * (3.0 - 2.0 * f);
    let low = mix(chance_at(corner), chance_at(corner + vec2f(1.0, 0.0)), s.x);
    let high = mix(chance_at(corner + vec2f(0.0, 1.0)), chance_at(corner + vec2f(1.0, 1.0)), s.x);
    return mix(low, high, s.y);
}

// What is left of a round profile, from 0 to 1: the middle stays.
fn eroded(round: f32, noise_place: vec2f) -> f32 {
    let noise = 0.65 * noise_at(noise_place) + 0.35 * noise_at(2.3 * noise_place);
    let share = clamp(RAGS_CONTRAST * (noise - 0.5) + 0.5, 0.0, 1.0);
    return round * max(1.0 - RAGGED_LOSS * particles.raggedness * share * (1.0 - round), 0.0);
}

@fragment
fn fs_particles(in: ParticleVarying) -> @location(0) vec4f {
    let surface_m = textureLoad(linear_depth, vec2i(in.position_clip.xy), 0).r;
    let before_m = surface_m - in.strength.y;
    if before_m <= 0.0 {
        discard;
    }
    let soft = select(clamp(before_m / max(particles.softness_m, 1e-6), 0.0, 1.0), 1.0, particles.softness_m <= 0.0);
    var round = max(1.0 - dot(in.place, in.place), 0.0);
    // Conditions on uniforms alone make software adapters compile anew.
    if round * particles.raggedness > 0.0 {
        round = eroded(round, in.noise_place);
    }
    let strength = in.strength.x * round * soft;
    if adds != 0u {
        return vec4f(in.radiance * strength, 0.0);
    }
    let opacity = clamp(strength * round, 0.0, OPACITY_MAX);
    let depth = -log(1.0 - opacity);
    return vec4f(in.radiance * depth, 1.0 - sqrt(1.0 - opacity));
}
