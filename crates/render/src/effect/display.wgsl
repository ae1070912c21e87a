// What an effect that reads display colours finds declared beside the prelude.

// Display colours after the tone curve, linear Rec. 709 from 0 to 1, multiplied by alpha; alpha is coverage.
@group(1) @binding(9) var display: texture_2d<f32>;

// Display colours at a pixel; at the nearest pixel of the picture where there is none.
fn display_at(pixel: vec2i) -> vec4f {
    return textureLoad(display, clamp(pixel, vec2i(0), vec2i(textureDimensions(display)) - 1), 0);
}
