//! The G-buffer: 12 bytes a pixel beside radiance and depth. Packed and unpacked in `gbuffer.wgsl` alone.

use crate::record::{ADD, Fullscreen, PreparedView, Recorder, SurfacePass};
use manypass_graph::{ColorLoad, Graph, Handle};

/// The format of `base_color`: base colour, occlusion of the material.
pub const BASE_COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// The format of `normal`: world normal, octahedral.
pub const NORMAL: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Uint;
/// The format of `material`: metallic, perceptual roughness, reflectance, shading model with lift.
pub const MATERIAL: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// The format of `radiance`: pre-exposed radiance, coverage.
pub const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// The format of `linear_depth`: metres along the view axis.
pub const LINEAR_DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// The G-buffer: textures of the nearest opaque surfaces, which the geometry pass draws, and their linear depth.
#[derive(Debug)]
pub struct Gbuffer {
    /// Base colour; occlusion of the material.
    pub base_color: Handle,
    /// World normal.
    pub normal: Handle,
    /// Metallic, roughness, reflectance, shading model with lift.
    pub material: Handle,
    /// Metres along the view axis.
    pub linear_depth: Handle,
}

impl Gbuffer {
    /// Declares that `step` reads the whole G-buffer, under the names of `gbuffer_textures.wgsl`.
    pub fn read_by<'r, 'f>(&self, step: Fullscreen<'r, 'f>) -> Fullscreen<'r, 'f> {
        self.materials_read_by(step).read("linear_depth", &self.linear_depth)
    }

    fn materials_read_by<'r, 'f>(&self, step: Fullscreen<'r, 'f>) -> Fullscreen<'r, 'f> {
        step.read("base_color", &self.base_color).read("normal", &self.normal).read("material", &self.material)
    }

    /// The same of a step that is drawn over `depth`: where nothing else needs linear depth, it finds distances in that,
    /// and nobody has to make them.
    pub fn read_by_light<'r, 'f>(&self, step: Fullscreen<'r, 'f>, depth: &Handle) -> Fullscreen<'r, 'f> {
        if !step.view().reads_attached_depth {
            return self.read_by(step);
        }
        self.materials_read_by(step).read_depth("linear_depth", depth).constant("reads_attached_depth", 1)
    }
}

/// What light goes into, before anything is there: `radiance`; or, in a view that counts pairs, a sum of their numbers.
#[derive(Debug)]
pub struct LightTarget {
    texture: Handle,
    /// Radiance is that of the nearest surface, while pairs of all that is shaded are added up.
    blend: Option<wgpu::BlendState>,
}

impl LightTarget {
    /// Of the view of `r`.
    pub fn new(r: &mut Recorder<'_, '_>) -> Self {
        if r.view.counts_pairs() {
            let format = r.frame.gpu.capabilities.sum_format();
            return Self { texture: r.texture("pairs", format), blend: Some(ADD) };
        }
        Self { texture: r.multisampled("radiance", RADIANCE), blend: None }
    }

    /// Makes it the target of a pass that draws opaque surfaces. Returns the version that holds the result.
    pub fn begin(self, pass: &mut SurfacePass<'_, '_>) -> Handle {
        if let Some(blend) = self.blend {
            pass.blend(blend);
        }
        pass.color(self.texture, ColorLoad::Clear(wgpu::Color::TRANSPARENT))
    }

    /// Clears it in a pass of its own, for what adds to it.
    pub fn cleared(self, graph: &mut Graph<'_>) -> Handle {
        let mut pass = graph.pass("clear");
        let target = pass.color(self.texture, ColorLoad::Clear(wgpu::Color::TRANSPARENT));
        pass.draw(|_| ());
        target
    }

    /// How blended surfaces of `view` go over it.
    pub fn blend_over(view: &PreparedView) -> wgpu::BlendState {
        if view.counts_pairs() { ADD } else { wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING }
    }
}

/// What the shaded view consists of.
#[derive(Debug)]
pub struct ViewOutputs {
    /// Scene-linear radiance, pre-exposed; alpha is coverage, more than 1 where the mark of `shaders/glow.wgsl` is.
    pub radiance: Handle,
    /// Depth at the end: that of the nearest opaque surface, and of others that hide what lies behind them.
    pub depth: Handle,
    /// The G-buffer; none on the forward path.
    pub gbuffer: Option<Gbuffer>,
    /// What surfaces emit, pre-exposed, if a variable needs it.
    pub emission: Option<Handle>,
    /// Nodes and materials, if a variable needs them.
    pub ids: Option<Handle>,
    /// Pixels moved since the previous frame, if a variable or an effect needs it.
    pub motion: Option<Handle>,
    /// The share of the environment's light that reaches surfaces, if it was found.
    pub occlusion: Option<Handle>,
    /// The same at the size of the view, if a variable needs it.
    pub occlusion_screen: Option<Handle>,
    /// What comes through glass of a background that is none of radiance, beside what alpha says (`transmittance`).
    pub tint: Option<Handle>,
}

impl ViewOutputs {
    /// Radiance and depth alone.
    pub fn new(radiance: Handle, depth: Handle) -> Self {
        Self {
            radiance,
            depth,
            gbuffer: None,
            emission: None,
            ids: None,
            motion: None,
            occlusion: None,
            occlusion_screen: None,
            tint: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::RADIANCE;

    /// Bits of the mantissa of red, green and blue.
    const HALF: [i32; 3] = [10; 3];
    const RG11B10: [i32; 3] = [6, 6, 5];
    /// The exponent of the smallest numbers of both formats that have all of their mantissa.
    const LEAST_EXPONENT: i32 = -14;
    const GREY: [f64; 3] = [1.0; 3];
    const ORANGE: [f64; 3] = [1.0, 0.35, 0.02];
    /// The share of `bloom.strength`, by default; reflections of a mirror are all of the picture.
    const BLOOM: f64 = 0.08;
    const MIRROR: f64 = 1.0;

    /// The level of a display, of 255, that shows a linear value (IEC 61966-2-1).
    fn level(linear: f64) -> f64 {
        255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
    }

    /// The nearest number with so many bits of mantissa; or the next one towards zero.
    fn rounded(value: f64, bits: i32, truncates: bool) -> f64 {
        let exponent = if value > 0.0 { value.log2().floor().max(f64::from(LEAST_EXPONENT)) } else { 0.0 };
        let step = (exponent - f64::from(bits)).exp2();
        let steps = value / step;
        step * if truncates { steps.floor() } else { steps.round() }
    }

    /// The largest step between two numbers that follow each other, up to `brightest`, where they are so much of a picture
    /// that is smooth otherwise.
    fn largest_step(brightest: f64, bits: i32, share: f64) -> f64 {
        let per_octave = f64::from(bits).exp2();
        let octaves = (LEAST_EXPONENT..0).map(|exponent| f64::from(exponent).exp2());
        let values = octaves.flat_map(|first| {
            let gap = first / per_octave;
            (0_u32..1 << bits).map(move |index| (first + f64::from(index) * gap, gap))
        });
        let within = values.filter(|(value, gap)| value + gap <= brightest);
        within.map(|(value, gap)| level(value + share * gap) - level(value)).fold(0.0, f64::max)
    }

    fn largest_steps(colour: [f64; 3], bits: [i32; 3], share: f64) -> [f64; 3] {
        std::array::from_fn(|channel| largest_step(colour[channel], bits[channel], share))
    }

    /// The largest distance of two channels of greys, from black to white.
    fn largest_tint(bits: [i32; 3], share: f64) -> f64 {
        let tint = |grey: f64| {
            let levels = bits.map(|bits| level(grey + share * (rounded(grey, bits, false) - grey)));
            levels.into_iter().fold(f64::MIN, f64::max) - levels.into_iter().fold(f64::MAX, f64::min)
        };
        (0..=4096).map(|step| tint(f64::from(step) / 4096.0)).fold(0.0, f64::max)
    }

    #[track_caller]
    fn assert_near(found: [f64; 3], expected: [f64; 3]) {
        let are_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 0.01);
        assert!(are_near, "{found:?} for {expected:?}");
    }

    /// The numbers of docs/targets.md: what mirrors reflect would show bands of 2.6 levels and tints of 1.3 in floats of 11
    /// and 10 bits, bloom neither.
    #[test]
    fn floats_of_eleven_bits_show_bands() {
        assert_near(largest_steps(GREY, RG11B10, MIRROR), [1.31, 1.31, 2.60]);
        assert_near(largest_steps(ORANGE, RG11B10, MIRROR), [1.31, 0.98, 0.61]);
        assert_near(largest_steps(GREY, RG11B10, BLOOM), [0.10, 0.10, 0.21]);
        assert_near(largest_steps(ORANGE, RG11B10, BLOOM), [0.10, 0.08, 0.05]);
        assert_near(largest_steps(GREY, HALF, MIRROR), [0.08; 3]);
        assert_near(largest_steps(ORANGE, HALF, MIRROR), [0.08, 0.06, 0.02]);
        assert_near([largest_tint(RG11B10, MIRROR), largest_tint(RG11B10, BLOOM), 0.0], [1.31, 0.10, 0.0]);
        assert!(largest_tint(HALF, MIRROR) == 0.0, "all channels have as many bits");
        assert_eq!(RADIANCE, wgpu::TextureFormat::Rgba16Float, "docs/targets.md says why");
    }

    /// One line of bloom's pictures: five times half the size, and back, each the mix of one and the next smaller one; what
    /// they hold is rounded by `round`.
    fn bloomed(line: &[f64], round: impl Fn(f64) -> f64) -> Vec<f64> {
        let at = |line: &[f64], index: isize| line[index.clamp(0, line.len() as isize - 1) as usize];
        let up = |line: &[f64], index: usize| {
            let (near, side) = (index as isize / 2, if index.is_multiple_of(2) { -1 } else { 1 });
            0.75 * at(line, near) + 0.25 * at(line, near + side)
        };
        let mut sizes = vec![line.chunks(2).map(|pair| round(0.5 * (pair[0] + pair[1]))).collect::<Vec<_>>()];
        while sizes.len() < 5 {
            let larger = &sizes[sizes.len() - 1];
            let weights = [1.0, 3.0, 3.0, 1.0].map(|weight| weight / 8.0);
            let down = |index: usize| {
                let texels = (-1..3).map(|offset| at(larger, 2 * index as isize + offset));
                round(texels.zip(weights).map(|(texel, weight)| texel * weight).sum())
            };
            let smaller = (0..larger.len() / 2).map(down).collect();
            sizes.push(smaller);
        }
        let mut mixed = sizes.pop().expect("five sizes");
        while let Some(size) = sizes.pop() {
            let mix = |(index, texel): (usize, &f64)| round(texel + 0.7 * (up(&mixed, index) - texel));
            mixed = size.iter().enumerate().map(mix).collect();
        }
        (0..line.len()).map(|index| up(&mixed, index)).collect()
    }

    /// OpenGL (EXT_packed_float) lets adapters round to zero where they write floats of 11 and 10 bits. Nine times one
    /// after the other it shows: by 0.6 levels of blue at the default strength, and by 1.5 at 0.2. Pictures of two adapters
    /// may differ by 2 in all.
    #[test]
    fn adapters_that_round_to_zero_would_show_another_bloom() {
        let line: Vec<f64> = (0..1024).map(|texel| f64::from(texel) / 1023.0).collect();
        let shown = |strength: f64, bits: i32, truncates: bool| -> Vec<f64> {
            let light = bloomed(&line, |value| rounded(value, bits, truncates));
            line.iter().zip(light).map(|(here, light)| level(here + strength * (light - here))).collect()
        };
        let differ = |strength: f64, bits: i32| {
            let pairs = shown(strength, bits, true).into_iter().zip(shown(strength, bits, false));
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        // Blue, which has the fewest bits.
        assert_near([differ(BLOOM, 5), differ(0.2, 5), 0.0], [0.61, 1.52, 0.0]);
        assert!(differ(0.2, 10) < 0.05, "half floats: {}", differ(0.2, 10));
    }
}
