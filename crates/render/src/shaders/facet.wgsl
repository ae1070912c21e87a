// The triangle of a fragment: how its place and its UVs change from pixel to pixel, from which all that lies in its
// plane follows without tangents (Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the GPU"). It holds in any
// space that is affine in the mesh's own.

struct Facet {
    position_dx: vec3f,
    position_dy: vec3f,
    uv_dx: vec4f,
    uv_dy: vec4f,
    // Across the plane, as long as a pixel of it is large.
    across: vec3f,
    // A step in the plane times these is a step in pixels.
    pixel_x: vec3f,
    pixel_y: vec3f,
}

fn facet_of(position: vec3f, uv: vec4f) -> Facet {
    let dx = dpdx(position);
    let dy = dpdy(position);
    var facet: Facet;
    facet.position_dx = dx;
    facet.position_dy = dy;
    facet.uv_dx = dpdx(uv);
    facet.uv_dy = dpdy(uv);
    facet.across = cross(dx, dy);
    let inverse_area_squared = 1.0 / max(dot(facet.across, facet.across), 1e-36);
    facet.pixel_x = cross(dy, facet.across) * inverse_area_squared;
    facet.pixel_y = cross(facet.across, dx) * inverse_area_squared;
    return facet;
}

// By how much UVs change along a step in the plane.
fn uv_step(facet: Facet, step: vec3f) -> vec4f {
    return facet.uv_dx * dot(facet.pixel_x, step) + facet.uv_dy * dot(facet.pixel_y, step);
}

// The direction in the plane in which a value rises, as steeply as that is long, of which the changes from pixel to
// pixel are given.
fn gradient(facet: Facet, value_dx: f32, value_dy: f32) -> vec3f {
    return facet.pixel_x * value_dx + facet.pixel_y * value_dy;
}
