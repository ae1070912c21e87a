// The curve from radiance to display colours. Which it is is constant when a shader runs, because the software adapters
// execute every branch of what a uniform chooses.
// Sources: Khronos PBR Neutral (Khronos 2024); ACES fit (Hill 2016); AgX (Sobotka 2022, polynomial fit of Wrensch
// 2023); Reinhard et al. 2002, on luminance; exponential (1 - exp(-x)).

import package::constants::{CURVE_ACES, CURVE_AGX, CURVE_EXPONENTIAL, CURVE_NEUTRAL, CURVE_NONE, CURVE_REINHARD, HALF_FLOAT_MAX};

override curve: u32 = CURVE_NONE;

fn neutral(color_in: vec3f) -> vec3f {
    let start_compression = 0.8 - 0.04;
    let desaturation = 0.15;
    var color = color_in;
    let smallest = min(color.r, min(color.g, color.b));
    let offset = select(0.04, smallest - 6.25 * smallest * smallest, smallest < 0.08);
    color -= offset;
    let peak = max(color.r, max(color.g, color.b));
    if peak < start_compression {
        return color;
    }
    let d = 1.0 - start_compression;
    let new_peak = 1.0 - d * d / (peak + d - start_compression);
    color *= new_peak / peak;
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(color, vec3f(new_peak), g);
}

fn aces(color_in: vec3f) -> vec3f {
    let input = mat3x3f(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    let output = mat3x3f(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    let v = input * (color_in / 0.6);
    let a = v * (v + 0.0245786) - 0.000090537;
    let b = v * (0.983729 * v + 0.4329510) + 0.238081;
    return clamp(output * (a / b), vec3f(0.0), vec3f(1.0));
}

fn agx_contrast(x: vec3f) -> vec3f {
    let x2 = x * x;
    let x4 = x2 * x2;
    return 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
}

fn agx(color_in: vec3f) -> vec3f {
    let inset = mat3x3f(
        0.842479062253094, 0.0423282422610123, 0.0423756549057051,
        0.0784335999999992, 0.878468636469772, 0.0784336,
        0.0792237451477643, 0.0791661274605434, 0.879142973793104,
    );
    let outset = mat3x3f(
        1.19687900512017, -0.0528968517574562, -0.0529716355144438,
        -0.0980208811401368, 1.15190312990417, -0.0980434501171241,
        -0.0990297440797205, -0.0989611768448433, 1.15107367264116,
    );
    // Log2 range of the curve: 10 stops below and 6.5 above middle grey.
    let ev_min = -12.47393;
    let ev_max = 4.026069;
    let logarithm = clamp(log2(max(inset * color_in, vec3f(1e-10))), vec3f(ev_min), vec3f(ev_max));
    let curve = agx_contrast((logarithm - ev_min) / (ev_max - ev_min));
    // The curve's output is for a display of gamma 2.2.
    return pow(max(outset * curve, vec3f(0.0)), vec3f(2.2));
}

fn reinhard(color: vec3f) -> vec3f {
    let luminance = dot(color, vec3f(0.2126, 0.7152, 0.0722));
    return color / (1.0 + luminance);
}

fn tone_curve(color: vec3f) -> vec3f {
    if curve == CURVE_NEUTRAL {
        return neutral(color);
    }
    if curve == CURVE_ACES {
        return aces(color);
    }
    if curve == CURVE_AGX {
        return agx(color);
    }
    if curve == CURVE_REINHARD {
        return reinhard(color);
    }
    if curve == CURVE_EXPONENTIAL {
        return 1.0 - exp(-color);
    }
    return color;
}

// The display colour of radiance that exposure has multiplied: linear light of the display, 0 to 1. No curve tells what
// is above the limit from white, and exposure must not make it infinite.
fn display_linear(color: vec3f) -> vec3f {
    return clamp(tone_curve(min(color, vec3f(HALF_FLOAT_MAX))), vec3f(0.0), vec3f(1.0));
}
