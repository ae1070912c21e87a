//! Constants that shaders and Rust share. They are declared here; `build.rs` gives them to shaders as the module
//! `package::constants`, so that there is no second place to change.

macro_rules! shared_constants {
    ($($(#[doc = $doc:literal])* $name:ident: $type:ident = $value:expr;)*) => {
        $($(#[doc = $doc])* pub const $name: $type = $value;)*

        /// Those whose names are `wanted`, as a WGSL module.
        #[allow(dead_code, reason = "only `build.rs`, which compiles this file too, writes the module")]
        pub fn as_wgsl(wanted: impl Fn(&str) -> bool) -> String {
            // Debug output of numbers is valid WGSL: 1024, 3e38, 0.0031308.
            let all = [$((stringify!($name), stringify!($type), format!("{:?}", $name))),*];
            let declare = |(name, kind, value)| format!("const {name}: {kind} = {value};\n");
            all.into_iter().filter(|(name, ..)| wanted(name)).map(declare).collect()
        }
    };
}

shared_constants! {
    /// The distance in metres that stands for infinity in `linear_depth`: this, and nothing nearer, is the background.
    /// It survives every comparison and every product with a weight up to 1.
    DISTANCE_BACKGROUND_M: f32 = 3.0e38;

    /// Shading models of the G-buffer beside those of `gbuffer.wgsl`, of surfaces that are shaded where they are drawn:
    /// one whose roughness a map of glossiness tells, which the G-buffer does not know.
    SHADING_MODEL_UNTRACED: f32 = 80.0 / 255.0;
    /// One with a clear coat that is smooth; the rougher the coat, the greater, up to the next.
    SHADING_MODEL_COATED_SMOOTH: f32 = 129.0 / 255.0;
    /// One with a clear coat as rough as can be.
    SHADING_MODEL_COATED_ROUGH: f32 = 180.0 / 255.0;

    /// Levels of the pyramid of least distances that reflected rays pass over, from pixels to squares of 64.
    REFLECTION_LEVELS: u32 = 7;

    /// Surfaces of less perceptual roughness have rays of each pixel where reflections are of half the picture's size.
    SHARP_ROUGHNESS: f32 = 0.1;

    /// Texels along each side of a square of which metering takes the mean at once.
    METERED_SIDE: i32 = 8;
    /// The binary logarithm of mid grey, 0.18.
    MID_GREY_LEVEL: f32 = -2.473_931_2;

    /// Pixels along each side of a tile of a still that needs no more samples once it is settled.
    SETTLED_TILE_PX: i32 = 4;

    /// Curves from radiance to display colours, as `tone_curve.wgsl` numbers them. None.
    CURVE_NONE: u32 = 0;
    /// Khronos PBR Neutral.
    CURVE_NEUTRAL: u32 = 1;
    /// Hill's fit of ACES.
    CURVE_ACES: u32 = 2;
    /// AgX.
    CURVE_AGX: u32 = 3;
    /// Reinhard, on luminance.
    CURVE_REINHARD: u32 = 4;
    /// 1 − exp(−x).
    CURVE_EXPONENTIAL: u32 = 5;

    /// What half floats hold, with room to spare for rounding: they end at 65,504.
    HALF_LARGEST: f32 = 60000.0;
    /// How many texels of a probe's light lie beside each other.
    PROBE_WIDTH: u32 = 14;
    /// And how many below each other.
    PROBE_HEIGHT: u32 = 5;
    /// The side of a probe's map of distances in texels, without its border.
    PROBE_DISTANCE_SIDE: u32 = 12;
    /// The side of the pictures that frames draw around a probe, in texels.
    PROBE_FACE_SIDE: u32 = 64;

    /// Views of the pass `debug`: how many lights are visited.
    DEBUG_LIGHTS: u32 = 0;
    /// How many fragments there are.
    DEBUG_OVERDRAW: u32 = 1;
    /// Texture coordinates.
    DEBUG_UV: u32 = 2;
    /// Normals.
    DEBUG_NORMALS: u32 = 3;
    /// How fine textures are.
    DEBUG_TEXEL_DENSITY: u32 = 4;
    /// Inputs that cannot be right.
    DEBUG_FLAGS: u32 = 5;
    /// Slices of clusters.
    DEBUG_CLUSTERS: u32 = 6;
    /// Cascades of shadows.
    DEBUG_CASCADES: u32 = 7;
    /// Levels of detail.
    DEBUG_LEVELS: u32 = 8;
    /// The probes that light a place.
    DEBUG_PROBE_WEIGHTS: u32 = 9;

    /// Texels in a row of the tables of joints, morph targets and previous nodes.
    DATA_WIDTH: u32 = 1024;
    /// Texels of a light in the table of lights.
    TEXELS_PER_LIGHT: u32 = 4;
    /// Lights in a row of the table of lights.
    LIGHTS_PER_ROW: u32 = 256;
    /// Classes of lights, a bit each, in the order of their table. Directional lights.
    DIRECTIONAL_LIGHTS: u32 = 1;
    /// Lights at a place that have no range, of all kinds.
    GLOBAL_LIGHTS: u32 = 2;
    /// Point lights that cast no shadow.
    QUIET_POINTS: u32 = 4;
    /// Point lights that cast shadows.
    CASTING_POINTS: u32 = 8;
    /// Spots that cast shadows.
    CASTING_SPOTS: u32 = 16;
    /// Spots that cast no shadow.
    QUIET_SPOTS: u32 = 32;
    /// Lists in a row of the table of clusters.
    TABLE_WIDTH: u32 = 1024;
    /// Entries in a row of the lists of lights. WebGL 2 promises no wider textures.
    LIST_WIDTH: u32 = 2048;
    /// The widest penumbra, as a share of half the side of a shadow's tile.
    PENUMBRA_MAX: f32 = 0.25;
    /// Lights of a batch of the path `forward-batched`.
    LIGHTS_PER_BATCH: u32 = 8;
    /// Texels of a decal in the table of lights.
    DECAL_TEXELS: u32 = 16;
    /// What there is of decals, a bit each. Any.
    DECALS_SHOWN: u32 = 1;
    /// Images of base colour and of how much of a decal there is.
    DECAL_COLOR_IMAGES: u32 = 2;
    /// Normal maps.
    DECAL_NORMALS: u32 = 4;
    /// Roughness.
    DECAL_ROUGHNESS: u32 = 8;
    /// Images of roughness and metallic.
    DECAL_ROUGHNESS_IMAGES: u32 = 16;
    /// Emission.
    DECAL_EMISSION: u32 = 32;
    /// Images of that.
    DECAL_EMISSION_IMAGES: u32 = 64;
    /// Not all are on all layers.
    DECAL_LAYERS: u32 = 128;
    /// Texels along each side of the table of directional albedo.
    DIRECTIONAL_ALBEDO_SIZE: u32 = 32;

    /// The roughness of the first level after the mirror's; four levels double it, up to [`ENVIRONMENT_LEVEL_HALF`].
    ENVIRONMENT_ROUGHNESS_FIRST: f32 = 0.0625;
    /// The first level whose tile is of medium size.
    ENVIRONMENT_LEVEL_MEDIUM: f32 = 6.0;
    /// The first level whose tile is coarse.
    ENVIRONMENT_LEVEL_COARSE: f32 = 12.0;
    /// The level of roughness 0.5; after it roughness rises by 1/16 a level.
    ENVIRONMENT_LEVEL_HALF: f32 = 13.0;
    /// The level of roughness 1, which seen along the normal is that of irradiance, too.
    ENVIRONMENT_LEVEL_LAST: f32 = 21.0;

    /// The least perceptual roughness that is shaded: below it the highlight of a punctual light is smaller than half
    /// floats can hold.
    ROUGHNESS_PERCEPTUAL_MIN: f32 = 0.045;

    /// What a material has beyond metallic-roughness, a bit each, above those of the maps of its layers (`LayerMap`).
    /// Roughness that is read from the alpha of the specular colour.
    LAYER_GLOSSINESS: u32 = 131_072;
    /// A clear coat.
    LAYER_CLEARCOAT: u32 = 262_144;
    /// Sheen.
    LAYER_SHEEN: u32 = 524_288;
    /// Anisotropy.
    LAYER_ANISOTROPY: u32 = 1_048_576;
    /// A thin film.
    LAYER_IRIDESCENCE: u32 = 2_097_152;
    /// Light comes through.
    LAYER_TRANSMISSION: u32 = 4_194_304;
    /// Light comes through, scattered.
    LAYER_DIFFUSE_TRANSMISSION: u32 = 8_388_608;
    /// What light comes through has a thickness.
    LAYER_VOLUME: u32 = 16_777_216;
    /// Colours are refracted apart.
    LAYER_DISPERSION: u32 = 33_554_432;

    /// Light that was baked.
    LAYER_LIGHT_MAP: u32 = 134_217_728;
    /// Normals from heights.
    LAYER_BUMP: u32 = 268_435_456;
    /// Heights shadow each other.
    LAYER_SELF_SHADOW: u32 = 536_870_912;
    /// All maps are shifted along the line of sight: alone once, with [`LAYER_STEPS`] to where fine steps meet the
    /// heights.
    LAYER_PARALLAX: u32 = 1_073_741_824;
    /// To where steps meet the heights; coarse ones without [`LAYER_PARALLAX`].
    LAYER_STEPS: u32 = 2_147_483_648;

    /// Set beside an object id: points or lines that have no normals take no light (glTF 2.0, on the materials of
    /// points and lines).
    WITHOUT_NORMALS: u32 = 0x8000_0000;
    /// The corners of the triangle around the disc of a point: as many vertices it has.
    POINT_CORNERS: u32 = 3;
    /// A point is a disc of this share of the picture's height.
    POINT_HEIGHT_SHARE: f32 = 0.005;
    /// And at least so many pixels wide.
    POINT_DIAMETER_MIN_PX: f32 = 2.0;
    /// Of what fades into another level of detail, object ids are below 2 to the power of this; above them stands how
    /// far.
    FADE_SHIFT: u32 = 23;
    /// In so many steps.
    FADE_STEPS: u32 = 64;
    /// Set above the steps of the level that fades in.
    FADE_COARSER: u32 = 64;

    /// Above this, rgba16float overflows on some drivers into infinity and from there into a NaN.
    HALF_FLOAT_MAX: f32 = 65000.0;
    /// A half float of which three, of emission, of the environment and of lights, add up without overflowing.
    RADIANCE_MAX: f32 = 20992.0;

    /// Of the sRGB transfer functions (IEC 61966-2-1): the slope of the straight part.
    SRGB_SLOPE: f32 = 12.92;
    /// The linear value where the straight part ends.
    SRGB_LINEAR_END: f32 = 0.003_130_8;
    /// The encoded value where the straight part ends.
    SRGB_ENCODED_END: f32 = 0.04045;
    /// What is added before, and taken away after, the power.
    SRGB_OFFSET: f32 = 0.055;
    /// The power.
    SRGB_POWER: f32 = 2.4;
}
