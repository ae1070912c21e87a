// Colours by a table of SIZE × SIZE × SIZE of them, between which they are mixed along the tetrahedron that a colour lies
// in, so that grey stays grey (Kasson, Nin, Plouffe & Hafner 1995, "Performing Color Space Conversions with
// Three-Dimensional Linear Interpolation").

fn entry(place: vec3i) -> vec3f {
    return textureLoad(TABLE, place, 0).rgb;
}

fn looked_up(color: vec3f) -> vec3f {
    let within = clamp((color - DOMAIN_LEAST) / (DOMAIN_MOST - DOMAIN_LEAST), vec3f(0.0), vec3f(1.0));
    let place = within * f32(SIZE - 1);
    let first = min(vec3i(place), vec3i(SIZE - 2));
    let part = place - vec3f(first);
    // From the darkest corner to the brightest, along the axis of the largest part first.
    let most = max(part.r, max(part.g, part.b));
    let least = min(part.r, min(part.g, part.b));
    let middle = part.r + part.g + part.b - most - least;
    let first_axis = select(select(vec3i(0, 0, 1), vec3i(0, 1, 0), part.g >= part.b), vec3i(1, 0, 0), part.r >= max(part.g, part.b));
    let last_axis = select(select(vec3i(1, 0, 0), vec3i(0, 1, 0), part.g < part.r), vec3i(0, 0, 1), part.b <= min(part.r, part.g) && first_axis.b == 0);
    return entry(first) * (1.0 - most)
        + entry(first + first_axis) * (most - middle)
        + entry(first + vec3i(1) - last_axis) * (middle - least)
        + entry(first + vec3i(1)) * least;
}
