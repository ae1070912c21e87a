// Strong small sources of a picture of the environment, which are taken out of it where it is blurred.

struct EnvironmentSun {
    // Where it is, and the cosine of the angle that holds it.
    direction: vec4f,
    // The radiance of its surroundings; w is 0.
    surroundings: vec4f,
}

fn sun_cut(sun: EnvironmentSun, direction: vec3f, radiance: vec3f) -> vec3f {
    let is_within = dot(sun.direction.xyz, direction) > sun.direction.w;
    return select(radiance, min(radiance, sun.surroundings.rgb), is_within);
}
