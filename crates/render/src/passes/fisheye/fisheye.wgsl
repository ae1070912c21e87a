// fisheye: the radiance of a fisheye picture, of that of views with perspective of up to five sides of a cube around
// the eye. Each pixel is the mean of some rays; a ray looks at the side that it meets, filtered linearly.
// Reads: radiance of the sides. Writes: radiance (pre-exposed), nothing outside of the circle that the lens shows.
// Program: fisheye.

struct Fisheye {
    // From a place on each side to its texture: by xy and more by zw.
    uv_from_place: array<vec4f, 5>,
    // The middle of the picture; with the offset of this sample.
    middle_px: vec2f,
    // 1 / the radius of the circle.
    inverse_radius_px: f32,
    // What a distance from the middle, 1 at the rim, is multiplied by to be θ, sin(θ / 2) or tan(θ / 2).
    slope: f32,
}

@group(1) @binding(0) var<uniform> fisheye: Fisheye;
@group(0) @binding(2) var linear_clamp: sampler;
@group(1) @binding(1) var front: texture_2d<f32>;
@group(1) @binding(2) var right: texture_2d<f32>;
@group(1) @binding(3) var left: texture_2d<f32>;
@group(1) @binding(4) var up: texture_2d<f32>;
@group(1) @binding(5) var down: texture_2d<f32>;

// 0 equidistant, 1 equisolid, 2 stereographic.
override fisheye_map: u32 = 0u;
// A pixel is the mean of so many rays by so many.
override rays_a_side: u32 = 2u;
// How many sides there are; one is that in front.
override face_count: u32 = 5u;

// The angle from the axis at a distance from the middle that the slope was multiplied by.
fn angle_at(distance: f32) -> f32 {
    if fisheye_map == 1u {
        return 2.0 * asin(min(distance, 1.0));
    }
    if fisheye_map == 2u {
        return 2.0 * atan(distance);
    }
    return distance;
}

fn uv_at(face: u32, place: vec2f) -> vec2f {
    return place * fisheye.uv_from_place[face].xy + fisheye.uv_from_place[face].zw;
}

// What is seen along a direction of view space. The side is that of the largest component, as in a cube map; places on
// it are those of `Side::place` in `fisheye.rs`.
fn seen_along(direction: vec3f) -> vec4f {
    let size = abs(direction);
    let ahead = max(size.z, 1e-6);
    let in_front = textureSampleLevel(front, linear_clamp, uv_at(0u, direction.xy / ahead), 0.0);
    if face_count == 1u {
        return in_front;
    }
    var found = in_front;
    if (size.x >= size.y) & (size.x > size.z) {
        if direction.x > 0.0 {
            found = textureSampleLevel(right, linear_clamp, uv_at(1u, direction.zy / size.x), 0.0);
        } else {
            found = textureSampleLevel(left, linear_clamp, uv_at(2u, vec2f(-direction.z, direction.y) / size.x), 0.0);
        }
    } else if (size.y > size.x) & (size.y > size.z) {
        if direction.y > 0.0 {
            found = textureSampleLevel(up, linear_clamp, uv_at(3u, direction.xz / size.y), 0.0);
        } else {
            found = textureSampleLevel(down, linear_clamp, uv_at(4u, vec2f(direction.x, -direction.z) / size.y), 0.0);
        }
    }
    return found;
}

@fragment
fn fs_fisheye(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let spacing = 1.0 / f32(max(rays_a_side, 1u));
    var sum = vec4f(0.0);
    for (var ray_y = 0u; ray_y < rays_a_side; ray_y++) {
        for (var ray_x = 0u; ray_x < rays_a_side; ray_x++) {
            let in_pixel = (vec2f(f32(ray_x), f32(ray_y)) + 0.5) * spacing - 0.5;
            let place = (position.xy + in_pixel - fisheye.middle_px) * vec2f(1.0, -1.0) * fisheye.inverse_radius_px;
            let radius = length(place);
            let angle_rad = angle_at(radius * fisheye.slope);
            let across = place / max(radius, 1e-9) * sin(angle_rad);
            let seen = seen_along(vec3f(across, -cos(angle_rad)));
            // What is nothing may be no number, which no factor makes nothing.
            sum += select(vec4f(0.0), seen, radius <= 1.0);
        }
    }
    return sum * spacing * spacing;
}
