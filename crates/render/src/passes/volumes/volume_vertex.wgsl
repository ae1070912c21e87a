// The meshes of volumes, placed around what a light reaches.

import package::constants::DATA_WIDTH;
import package::view::view;

// 1 if they are cones, and no balls.
override cones: u32 = 0u;

struct VolumeVarying {
    @builtin(position) position_clip: vec4f,
    @location(0) @interpolate(flat, either) light: u32,
}

// What `LightReaches` holds of volumes: see `lights/volumes.rs`.
@group(1) @binding(4) var light_reaches: texture_2d<f32>;

fn reach_texel(index: u32) -> vec4f {
    return textureLoad(light_reaches, vec2i(i32(index % DATA_WIDTH), i32(index / DATA_WIDTH)), 0);
}

// The enlargement of a cone to all sides, as a share of its range: rounding must not cut off what it reaches.
const CONE_SLACK: f32 = 0.002;

// What a cone of half angle a cuts out of a ball of radius 1 lies within a cone up to its rim, at cos a, and from there
// within the planes that touch the ball at the rim and at the end of the axis: they meet at the tangent of a / 2.
fn corner_of_cone(corner: vec3f, first: u32) -> vec3f {
    let tip = reach_texel(first);
    let axis = reach_texel(first + 1u);
    let cos_angle = inverseSqrt(1.0 + axis.w * axis.w);
    let sin_angle = axis.w * cos_angle;
    let ring = u32(corner.x);
    var along = select(1.0 + CONE_SLACK, cos_angle, ring == 1u);
    along = select(along, -CONE_SLACK, ring == 0u);
    // The tip and the middle of the end lie on the axis, where y and z are 0.
    let wide = select(sin_angle / (1.0 + cos_angle), sin_angle, ring == 1u) + CONE_SLACK;
    // Any two directions across the axis whose cross product it is.
    let helper = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(axis.y) > 0.7);
    let across = normalize(cross(helper, axis.xyz));
    let beside = cross(axis.xyz, across);
    return tip.xyz + tip.w * (axis.xyz * along + (across * corner.y + beside * corner.z) * wide);
}

fn corner_of_ball(corner: vec3f, first: u32) -> vec3f {
    let ball = reach_texel(first);
    return ball.xyz + ball.w * corner;
}

fn corner_world(corner: vec3f, first: u32) -> vec3f {
    if cones != 0u {
        return corner_of_cone(corner, first);
    }
    return corner_of_ball(corner, first);
}

fn volume_varying(corner: vec3f, instance: u32) -> VolumeVarying {
    let first = instance * 3u;
    let flags = reach_texel(first + 2u);
    var out: VolumeVarying;
    out.position_clip = view.clip_from_world * vec4f(corner_world(corner, first), 1.0);
    // What would be cut open where depth ends lies there as a whole, behind every surface.
    out.position_clip.z = select(out.position_clip.z, 0.0, flags.y > 0.5);
    out.light = u32(flags.x);
    return out;
}
