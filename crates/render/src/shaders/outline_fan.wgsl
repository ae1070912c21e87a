// The outline of a flat surface as a fan of triangles around its first corner.

// Which corner a vertex is.
fn corner_of_vertex(vertex: u32) -> u32 {
    let of_triangle = vertex % 3u;
    return select(vertex / 3u + of_triangle, 0u, of_triangle == 0u);
}
