//! The description of every AOV, from which help, documentation and encoders take it.

use super::Aov;

/// The description of an AOV: what it holds, its unit and space, and how files hold it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AovInfo {
    /// The name on the command line, and of the layer in files.
    pub name: &'static str,
    /// What it holds.
    pub doc: &'static str,
    /// The names of its channels in EXR, in the order of its values.
    pub channels: &'static [&'static str],
    /// The unit of its values.
    pub unit: &'static str,
    /// The space and the axes that its values refer to.
    pub space: &'static str,
    /// Its value where there is no surface.
    pub background: &'static str,
    /// How a PNG holds it.
    pub png: PngEncoding,
}

/// The encoding of an AOV in a PNG file. All but [`PngEncoding::Srgb8`] are linear numbers, in files without a colour space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PngEncoding {
    /// A picture: 8 bits, the sRGB transfer function.
    Srgb8,
    /// 8 bits of grey for values from 0 to 1.
    Unit8,
    /// 16 bits for values from −1 to 1; black where there is no surface.
    Signed16,
    /// 16 bits from the smallest to the largest value; 65535 in every channel where there is no surface.
    Range16,
    /// 16 bits to both sides of 0, as far as the largest magnitude and at least to 1.
    Symmetric16,
    /// 16 bits from 0 to the largest value of all colours.
    Maximum16,
    /// 16 bits of grey that are the number itself.
    Id16,
}

impl PngEncoding {
    /// The largest number that [`Self::Id16`] holds.
    pub const LARGEST_ID: u32 = 65534;

    /// The kind of PNG, and how its numbers `v` become values. `low`, `high` and the like are the `range` of the
    /// report.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Srgb8 => "8-bit RGB, marked as sRGB; value = sRGB to linear of v / 255",
            Self::Unit8 => "8-bit grey; value = v / 255",
            Self::Signed16 => "16-bit RGB; 0, 0, 0 where there is no surface, else value = 2 · v / 65535 − 1",
            Self::Range16 => "16 bits; 65535 where there is no surface, else value = low + v / 65534 · (high − low)",
            Self::Symmetric16 => "16-bit RGB, blue 0; value = (v − 32768) / 32767 · high",
            Self::Maximum16 => "16 bits; value = v / 65535 · high; alpha, where there is one, = v / 65535",
            Self::Id16 => "16-bit grey; value = v, at most 65534",
        }
    }
}

impl Aov {
    /// The description of the AOV, and how it is written.
    pub fn info(self) -> &'static AovInfo {
        match self {
            Self::BaseColor => &BASE_COLOR,
            Self::Occlusion => &OCCLUSION,
            Self::OcclusionScreen => &OCCLUSION_SCREEN,
            Self::Normal => &NORMAL,
            Self::NormalView => &NORMAL_VIEW,
            Self::Position => &POSITION,
            Self::Depth => &DEPTH,
            Self::Metallic => &METALLIC,
            Self::Roughness => &ROUGHNESS,
            Self::Emission => &EMISSION,
            Self::Motion => &MOTION,
            Self::ObjectId => &OBJECT_ID,
            Self::MaterialId => &MATERIAL_ID,
            Self::Radiance => &RADIANCE,
        }
    }
}

const XYZ: &[&str] = &["X", "Y", "Z"];
const RGB: &[&str] = &["R", "G", "B"];
const UNITLESS: &str = "none, 0 to 1";
const COLOR_SPACE: &str = "linear Rec. 709";
const WORLD_SPACE: &str = "world: right-handed, +y up, as in the glTF file";
const NO_SPACE: &str = "none";

const BASE_COLOR: AovInfo = AovInfo {
    name: "base_color",
    doc: "Base colour of the surface, textures and vertex colours included",
    channels: RGB,
    unit: UNITLESS,
    space: COLOR_SPACE,
    background: "0, 0, 0",
    png: PngEncoding::Srgb8,
};

const OCCLUSION: AovInfo = AovInfo {
    name: "occlusion",
    doc: "Occlusion of the material; 1 is open",
    channels: &["Y"],
    unit: UNITLESS,
    space: NO_SPACE,
    background: "0",
    png: PngEncoding::Unit8,
};

const OCCLUSION_SCREEN: AovInfo = AovInfo {
    name: "occlusion_screen",
    doc: "Screen-space ambient occlusion: the share of the environment's light that is left; 1 is open. It follows \
          `occlusion.*`, also with `occlusion.enabled=false`",
    background: "1",
    ..OCCLUSION
};

const NORMAL: AovInfo = AovInfo {
    name: "normal",
    doc: "Shading normal, of length 1, normal maps included",
    channels: XYZ,
    unit: "none, −1 to 1",
    space: WORLD_SPACE,
    background: "0, 0, 0",
    png: PngEncoding::Signed16,
};

const NORMAL_VIEW: AovInfo = AovInfo {
    name: "normal_view",
    doc: "Shading normal in view space",
    space: "view: right-handed, +x right, +y up, −z ahead",
    ..NORMAL
};

const POSITION: AovInfo = AovInfo {
    name: "position",
    doc: "Position of the surface in the middle of the pixel",
    channels: XYZ,
    unit: "metres",
    space: WORLD_SPACE,
    background: "0, 0, 0",
    png: PngEncoding::Range16,
};

const DEPTH: AovInfo = AovInfo {
    name: "depth",
    doc: "Distance from the camera along its axis (not along the ray) in the middle of the pixel",
    channels: &["Z"],
    unit: "metres",
    space: "view: positive ahead",
    background: "+∞",
    png: PngEncoding::Range16,
};

const METALLIC: AovInfo = AovInfo { name: "metallic", doc: "Metallic; 1 is metal", ..OCCLUSION };

const ROUGHNESS: AovInfo =
    AovInfo { name: "roughness", doc: "Perceptual roughness, as in glTF; its square is GGX's α", ..OCCLUSION };

const EMISSION: AovInfo = AovInfo {
    name: "emission",
    doc: "Radiance that the surface emits, without exposure; an unlit surface emits its base colour",
    channels: RGB,
    unit: "cd/m² (nits)",
    space: COLOR_SPACE,
    background: "0, 0, 0",
    png: PngEncoding::Maximum16,
};

const MOTION: AovInfo = AovInfo {
    name: "motion",
    doc: "Motion vector: the movement of the pixel's surface since the frame before (--frames, --time, --turntable); \
          its position now minus its position then",
    channels: &["X", "Y"],
    unit: "pixels",
    space: "picture: +x right, +y down",
    background: "the motion of infinitely far points: 0 unless the camera turns",
    png: PngEncoding::Symmetric16,
};

const OBJECT_ID: AovInfo = AovInfo {
    name: "object_id",
    doc: "Index of the node plus 1; `manypass info --json` and the EXR's header name the nodes",
    channels: &["Id"],
    unit: "none, whole numbers",
    space: NO_SPACE,
    background: "0",
    png: PngEncoding::Id16,
};

const MATERIAL_ID: AovInfo = AovInfo {
    name: "material_id",
    doc: "Index of the material plus 1; surfaces without a material have the number after the last",
    ..OBJECT_ID
};

const RADIANCE: AovInfo = AovInfo {
    name: "radiance",
    doc: "The picture before exposure and tone mapping: the average of all samples, with blended surfaces, effects \
          and background; associated alpha (in PNG unassociated)",
    channels: &["R", "G", "B", "A"],
    unit: "cd/m² (nits)",
    space: COLOR_SPACE,
    background: "the background",
    png: PngEncoding::Maximum16,
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_differ_and_every_variable_says_what_it_is() {
        let infos: Vec<&AovInfo> = Aov::ALL.iter().map(|aov| aov.info()).collect();
        for (index, info) in infos.iter().enumerate() {
            assert!(infos.iter().skip(index + 1).all(|other| other.name != info.name && other.doc != info.doc));
            assert!((1..=4).contains(&info.channels.len()));
            // These texts become cells of a table.
            assert!(
                [info.doc, info.unit, info.space, info.background, info.png.doc()]
                    .iter()
                    .all(|text| { !text.is_empty() && !text.contains(['|', '\n']) })
            );
        }
    }
}
