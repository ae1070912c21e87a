// What shines of itself so brightly that light makes hardly any difference to its display colour: lamps, windows onto a
// bright sky. Where lights take turns, `accumulate` averages it after the tone curve and all else before it. Radiance
// carries the mark to there: alpha, which is coverage, is more than 1 by the share that glows. What is blended over it
// (blended surfaces, fog) covers the mark as it covers the light, and what is added leaves it alone.

import package::view::view;

// 0 up to the display's white, 1 from twice as bright on; 0 everywhere where nothing is marked, since the exposure is 0
// then.
fn glow_share(radiance: vec3f) -> f32 {
    let brightest = max(radiance.r, max(radiance.g, radiance.b));
    return clamp(brightest * view.glow_exposure - 1.0, 0.0, 1.0);
}
