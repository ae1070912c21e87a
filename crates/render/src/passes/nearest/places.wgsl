// Where a texel of the frame lies that is nearest to a pixel of a picture of another size.

import package::view::view;

struct Nearest {
    // Texels for each texel of what is written.
    texels_per_px: vec2f,
    // Zero.
    padding: vec2f,
}

@group(1) @binding(0) var<uniform> nearest: Nearest;

fn texel_at(position_px: vec2f, size: vec2u) -> vec2i {
    let place = position_px * nearest.texels_per_px + view.jitter_ndc * vec2f(0.5, -0.5) * view.size_px;
    return clamp(vec2i(floor(place)), vec2i(0), vec2i(size) - 1);
}
