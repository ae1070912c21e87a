// mirrors.outline: begins the depth of a view behind a mirror nearest of all, so that nothing is drawn, but within the
// mirror's outline: depth is that where nothing else is drawn, and the triangle, which is farthest of all, is drawn there.
// Reads: the outline. Writes: depth.
// Program: mirrors_outline.

struct Outline {
    // Of each edge how far inside of it a pixel lies: the product with (x, y, 1), in pixels.
    edges: array<vec4f, 4>,
}

@group(1) @binding(0) var<uniform> outline: Outline;

@fragment
fn fs_mirrors_outline(@builtin(position) position: vec4f) {
    let place = vec3f(position.xy, 1.0);
    for (var edge = 0u; edge < 4u; edge++) {
        if dot(outline.edges[edge].xyz, place) < 0.0 {
            discard;
        }
    }
}
