// What rays of `reflections` follow of a surface: of its lobes the one that mirrors most sharply, which may be that of
// a clear coat; and how much of what they bring a lobe of a roughness shows.

import package::gbuffer::Surface;
import package::constants::{SHADING_MODEL_COATED_ROUGH, SHADING_MODEL_COATED_SMOOTH, SHADING_MODEL_UNTRACED};

// Half a step of the byte in which the G-buffer holds the shading model.
const HALF_STEP: f32 = 0.5 / 255.0;
// Of the greatest roughness: over so much of it reflections fade out.
const ROUGHNESS_FADE: f32 = 0.2;

// Whether light reaches a surface whose roughness the G-buffer knows.
fn is_traced(surface: Surface) -> bool {
    return surface.shading_model > SHADING_MODEL_UNTRACED + HALF_STEP;
}

fn traced_roughness(surface: Surface) -> f32 {
    let model = surface.shading_model;
    let coat = (model - SHADING_MODEL_COATED_SMOOTH) / (SHADING_MODEL_COATED_ROUGH - SHADING_MODEL_COATED_SMOOTH);
    let is_coated = model > SHADING_MODEL_COATED_SMOOTH - HALF_STEP && model < SHADING_MODEL_COATED_ROUGH + HALF_STEP;
    let sharpest = min(surface.roughness_perceptual, clamp(coat, 0.0, 1.0));
    return select(surface.roughness_perceptual, sharpest, is_coated);
}

// How much a lobe of a perceptual roughness shows of the picture.
fn share_of_roughness(roughness: f32, roughness_max: f32) -> f32 {
    let fade = max(ROUGHNESS_FADE * roughness_max, 1e-6);
    return clamp((roughness_max - roughness) / fade, 0.0, 1.0);
}
