// Unit vectors in two numbers: Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
// JCGT 2014. With 16 bits a component the largest error is about 0.0014 degrees.

fn octahedral_wrap(v: vec2f) -> vec2f {
    return (1.0 - abs(v.yx)) * select(vec2f(-1.0), vec2f(1.0), v >= vec2f(0.0));
}

fn octahedral_from_direction(direction: vec3f) -> vec2f {
    let n = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    return select(octahedral_wrap(n.xy), n.xy, n.z >= 0.0);
}

fn direction_from_octahedral(v: vec2f) -> vec3f {
    let z = 1.0 - abs(v.x) - abs(v.y);
    let xy = select(octahedral_wrap(v), v, z >= 0.0);
    return normalize(vec3f(xy, z));
}

// As `direction_from_octahedral`, a little beyond the edges as well: there the map goes on at the other end of the same
// edge.
fn direction_from_octahedral_border(v: vec2f) -> vec3f {
    let beyond_x = abs(v.x) > 1.0;
    let beyond_y = abs(v.y) > 1.0;
    let x = select(v.x, sign(v.x) * 2.0 - v.x, beyond_x);
    let y = select(v.y, sign(v.y) * 2.0 - v.y, beyond_y);
    return direction_from_octahedral(vec2f(select(x, -x, beyond_y), select(y, -y, beyond_x)));
}
