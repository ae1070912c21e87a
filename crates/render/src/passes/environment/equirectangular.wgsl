// The radiance of an equirectangular picture in a direction of length 1, between its four nearest texels. By hand,
// because the left edge goes on at the right one, and a sampler that repeats would do so at the poles, too.

import package::shaders::brdf::PI;

@group(1) @binding(0) var equirectangular: texture_2d<f32>;

fn equirectangular_at(direction: vec3f) -> vec3f {
    let size = vec2i(textureDimensions(equirectangular));
    let u = 0.5 + atan2(direction.z, direction.x) / (2.0 * PI);
    let v = acos(clamp(direction.y, -1.0, 1.0)) / PI;
    let texel = vec2f(u, v) * vec2f(size) - 0.5;
    let corner = vec2i(floor(texel));
    let share = fract(texel);
    var sum = vec3f(0.0);
    for (var i = 0; i < 4; i++) {
        let step = vec2i(i & 1, i >> 1u);
        let at = corner + step;
        let column = (at.x + size.x) % size.x;
        let row = clamp(at.y, 0, size.y - 1);
        let weights = mix(1.0 - share, share, vec2f(step));
        sum += textureLoad(equirectangular, vec2i(column, row), 0).rgb * (weights.x * weights.y);
    }
    return sum;
}
