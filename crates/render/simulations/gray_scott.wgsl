//! simulation gray_scott
//! start: seeds -> field
//! step: react -> field
//! shows: color
//! rate: 240
//! edges: wrap

// Two substances, of which one is fed and turns into the other where there is some of it, while both spread: spots that divide,
// corals and mazes. Source: Gray & Scott 1984; Pearson 1993, "Complex Patterns in a Simple System".

struct GrayScott {
    /// The feed rate of the first substance, share a step
    // = 0.0545 in 0..0.2
    feed: f32,
    /// The kill rate of the second substance, share a step
    // = 0.062 in 0..0.2
    kill: f32,
    /// The diffusion rate of the first substance, cells² a step
    // = 1 in 0..1
    spread_a: f32,
    /// The diffusion rate of the second substance, cells² a step
    // = 0.5 in 0..1
    spread_b: f32,
    /// The number of initial spots of the second substance, share of blocks of 16 by 16 cells
    // = 0.06 in 0..1
    spots: f32,
    padding_a: f32,
    padding_b: vec2f,
    /// The colour without the second substance, linear Rec. 709
    // = 0.015, 0.03, 0.05 in 0..
    low_color: vec3f,
    padding_c: f32,
    /// The colour of the second substance, linear Rec. 709
    // = 0.95, 0.45, 0.2 in 0..
    high_color: vec3f,
    padding_d: f32,
}

@group(2) @binding(0) var<uniform> gray_scott: GrayScott;

fn seeds(cell: vec2i) -> vec4f {
    let block = cell / 16;
    let chance = random(vec3u(vec2u(block), 1u));
    let away = vec2f(cell - block * 16) + 0.5 - (4.0 + 8.0 * chance.yz);
    let is_spot = chance.x < gray_scott.spots && dot(away, away) < 20.0;
    return vec4f(select(vec2f(1.0, 0.0), vec2f(0.5, 0.5), is_spot), 0.0, 0.0);
}

fn react(cell: vec2i) -> vec4f {
    let here = field_at(cell).xy;
    let beside = field_at(cell + vec2i(1, 0)).xy + field_at(cell - vec2i(1, 0)).xy
        + field_at(cell + vec2i(0, 1)).xy + field_at(cell - vec2i(0, 1)).xy;
    let across = field_at(cell + vec2i(1, 1)).xy + field_at(cell - vec2i(1, 1)).xy
        + field_at(cell + vec2i(1, -1)).xy + field_at(cell + vec2i(-1, 1)).xy;
    let spread = 0.2 * beside + 0.05 * across - here;
    let turned = here.x * here.y * here.y;
    let a = here.x + gray_scott.spread_a * spread.x - turned + gray_scott.feed * (1.0 - here.x);
    let b = here.y + gray_scott.spread_b * spread.y + turned - (gray_scott.feed + gray_scott.kill) * here.y;
    return vec4f(a, b, 0.0, 0.0);
}

fn color(cell: vec2i) -> vec4f {
    let share = smoothstep(0.08, 0.32, field_at(cell).y);
    return vec4f(mix(gray_scott.low_color, gray_scott.high_color, share), 1.0);
}
