//! What a surface has that its triangles have not: relief from heights, detail that repeats, and light that was baked.

use super::layers::TexturedFactor;
use super::texture::TextureRef;

/// What a height map does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightMethod {
    /// Bends normals alone (Blinn 1978, "Simulation of Wrinkled Surfaces").
    Bump,
    /// Moves every map once along the line of sight, no farther than the surface is deep (Kaneko et al. 2001, "Detailed
    /// Shape Representation with Parallax Mapping"; Welsh 2004, with limited offsets).
    Parallax,
    /// Goes along the line of sight in coarse steps, to the last that lies above the heights (after McGuire & McGuire
    /// 2005).
    Steep,
    /// The same in finer steps, and from the last two to where the heights cross the line of sight (Brawley & Tatarchuk
    /// 2004, "Parallax Occlusion Mapping").
    Occlusion,
}

/// Heights of a surface: the texture's red, 1 on the triangles and less below them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightMap {
    /// Linear; images of 16 bits a channel keep them.
    pub texture: TextureRef,
    /// How far below the triangles a height of 0 lies, in metres of the mesh's own space. Of [`HeightMethod::Bump`]
    /// it may be negative: black is then high.
    pub depth_m: f32,
    /// What is done with it.
    pub method: HeightMethod,
    /// Whether its heights are searched for what stands between a point and each light, beside what shadow maps hold.
    /// Only of [`HeightMethod::Steep`] and [`HeightMethod::Occlusion`].
    pub self_shadow: bool,
}

/// Maps that are laid over others and mostly repeat more often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailMaps {
    /// Tangent-space normals, which turn with those below them (Barré-Brisebois & Hill 2012, "Blending in Detail").
    pub normal_texture: Option<TextureRef>,
    /// Scales x and y of these normals.
    pub normal_scale: f32,
    /// sRGB colour; twice its linear value multiplies the base colour, so that 0.5 leaves it as it is.
    pub base_color_texture: Option<TextureRef>,
}

/// How the texels of a light map are written, where they are not those of a file of light, which are linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LightEncoding {
    /// As they are.
    #[default]
    Linear,
    /// In sRGB.
    Srgb,
    /// Linear colour that alpha multiplies: 255 by 255 steps in place of 255 (Karis 2009, "RGBM color encoding"). The
    /// factor of the map is its range.
    Rgbm,
}

impl LightEncoding {
    /// The words for all of them.
    pub const NAMES: [&str; 3] = ["linear", "srgb", "rgbm"];

    /// The one of a word.
    pub fn named(word: &str) -> Option<Self> {
        match word {
            "linear" => Some(Self::Linear),
            "srgb" => Some(Self::Srgb),
            "rgbm" => Some(Self::Rgbm),
            _ => None,
        }
    }
}

/// Light that was computed beforehand: what a white surface sends back of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightMap {
    /// The factor, and the colour that it multiplies: together the irradiance divided by π, which is multiplied by the
    /// base colour of what is not metal. It takes the place of the environment's diffuse light; lights and reflections
    /// are added.
    pub light: TexturedFactor<f32>,
    /// How its texels are written.
    pub encoding: LightEncoding,
    /// Where that light comes from, placed as the light itself is; without it normal maps do not change baked light. Red,
    /// green and blue, linear and of 8 bits, are d / 2 + 1 / 2. The vector d, in world space, is the mean of unit directions
    /// towards the light, each weighted by its share of the luminance of irradiance: d = Σ Y cosθ ω / Σ Y cosθ, where θ is
    /// from the mesh's normal. Its length is 1 for light from one distant place, 2/3 for even light from everywhere, then
    /// along the normal, and 0 where there is none.
    pub direction: Option<TextureRef>,
}
