// Colours by a curve of SIZE entries for each channel.

fn entry(index: i32) -> vec3f {
    return textureLoad(TABLE, vec3i(index % 256, index / 256, 0), 0).rgb;
}

fn looked_up(color: vec3f) -> vec3f {
    let within = clamp((color - DOMAIN_LEAST) / (DOMAIN_MOST - DOMAIN_LEAST), vec3f(0.0), vec3f(1.0));
    let place = within * f32(SIZE - 1);
    let first = min(vec3i(place), vec3i(SIZE - 2));
    let part = place - vec3f(first);
    return vec3f(
        mix(entry(first.r).r, entry(first.r + 1).r, part.r),
        mix(entry(first.g).g, entry(first.g + 1).g, part.g),
        mix(entry(first.b).b, entry(first.b + 1).b, part.b),
    );
}
