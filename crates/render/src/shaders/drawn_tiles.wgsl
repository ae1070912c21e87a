// Draws a full-screen pass within square tiles alone: each is a quad, and those of which a texture says that nothing is
// there have no area. Without tiles it is one triangle over the whole target.

// A texel for each tile: 0 where nothing is drawn. Looked at with `tile_side` alone.
@group(1) @binding(11) var drawn_tiles: texture_2d<f32>;

// Texels of the target along a side of a tile, or 0 if all of the target is drawn.
override tile_side: u32 = 0u;

// A corner of the triangle, or of the instance's tile, of a target of so many texels. It lies at depth 0, as that of
// `fullscreen.wgsl`.
fn tile_corner(vertex: u32, instance: u32, target_size: vec2f) -> vec4f {
    if tile_side == 0u {
        let corner = vec2f(f32((vertex << 1u) & 2u), f32(vertex & 2u));
        return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
    }
    let across = textureDimensions(drawn_tiles).x;
    let tile = vec2u(instance % across, instance / across);
    let is_drawn = textureLoad(drawn_tiles, vec2i(tile), 0).r > 0.0;
    // Two triangles: 0 0, 1 0, 0 1 and 1 1, 0 1, 1 0.
    let turned = select(0u, 1u, vertex >= 3u);
    let of_triangle = vertex % 3u;
    let step = vec2u(select(0u, 1u, of_triangle == 1u), select(0u, 1u, of_triangle == 2u));
    let corner = select(step, 1u - step, turned == 1u);
    let texel = min(vec2f((tile + select(vec2u(0u), corner, is_drawn)) * tile_side), target_size);
    let ndc = texel / target_size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    return vec4f(ndc, 0.0, 1.0);
}
