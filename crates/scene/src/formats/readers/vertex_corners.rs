//! Which corners of faces lie at each vertex.

/// The corners of every vertex: where they start in the second list, in which they keep their order.
pub(super) fn corners_by_vertex(vertex_count: usize, indices: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; vertex_count + 1];
    for &vertex in indices {
        if let Some(count) = starts.get_mut(vertex as usize + 1) {
            *count += 1;
        }
    }
    let mut sum = 0;
    for start in &mut starts {
        sum += *start;
        *start = sum;
    }
    let mut next = starts.clone();
    let mut order = vec![0; indices.len()];
    for (corner, &vertex) in indices.iter().enumerate() {
        if let Some(place) = next.get_mut(vertex as usize) {
            if let Some(slot) = order.get_mut(*place as usize) {
                *slot = corner as u32;
            }
            *place += 1;
        }
    }
    (starts, order)
}
