//! The G-buffer: 12 bytes a pixel beside radiance and depth. Packed and unpacked in `gbuffer.wgsl` alone.

use crate::record::{ADD, Fullscreen, PreparedView, Recorder, SurfacePass};
use manypass_graph::{ColorLoad, Graph, Handle};

/// The format of `base_color`: base colour, occlusion of the material.
pub const BASE_COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// The format of `normal`: world normal, octahedral.
pub const NORMAL: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Uint;
/// The format of `material`: metallic, perceptual roughness, reflectance, shading model.
pub const MATERIAL: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// The format of `radiance`: pre-exposed radiance, coverage.
pub const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// The format of `linear_depth`: metres along the view axis.
pub const LINEAR_DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// What the geometry pass leaves behind, once the linear depth has been made of the depth attachment.
#[derive(Debug)]
pub struct Gbuffer {
    /// Base colour; occlusion of the material.
    pub base_color: Handle,
    /// World normal.
    pub normal: Handle,
    /// Metallic, roughness, reflectance, shading model.
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
