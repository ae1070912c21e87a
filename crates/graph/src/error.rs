//! Contradictions in a frame's declaration.

use thiserror::Error;

/// Why a graph cannot be executed. `writer` fields say where the texture comes
/// from: the pass that wrote it last, an import, or nothing yet.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[allow(missing_docs, reason = "the message of each variant says what its fields are")]
#[non_exhaustive]
pub enum PlanError {
    /// An attachment differs in size from the others of its pass.
    #[error(
        "pass `{pass}`: `{texture}` ({writer}) is {width}x{height}, but `{other}` ({other_writer}) is \
         {other_width}x{other_height}; give all attachments of a pass one size, or split the pass"
    )]
    SizeMismatch {
        pass: String,
        texture: String,
        writer: String,
        width: u32,
        height: u32,
        other: String,
        other_writer: String,
        other_width: u32,
        other_height: u32,
    },
    /// An attachment differs in sample count from the others of its pass.
    #[error(
        "pass `{pass}`: `{texture}` ({writer}) has {samples} samples, but `{other}` ({other_writer}) has \
         {other_samples}; give all attachments of a pass one sample count"
    )]
    SampleMismatch {
        pass: String,
        texture: String,
        writer: String,
        samples: u32,
        other: String,
        other_writer: String,
        other_samples: u32,
    },
    /// What holds the mean of samples does not fit the colour target that has them.
    #[error(
        "pass `{pass}`: `{texture}` ({writer}) cannot hold the mean of the samples of {color}; declare it after a colour target of \
         several samples, with the same format and one sample"
    )]
    ResolveMismatch { pass: String, texture: String, writer: String, color: String },
    /// A texture of several samples is sampled.
    #[error(
        "pass `{pass}` samples `{texture}` ({writer}), which has {samples} samples a texel, and WebGL 2 cannot do that; read \
         what `Pass::resolve` made of it"
    )]
    SampledSamples { pass: String, texture: String, writer: String, samples: u32 },
    /// A colour format used as depth, or the other way round.
    #[error(
        "pass `{pass}`: `{texture}` ({writer}) has format {format:?}, which cannot be used as {role}; \
         use {remedy}"
    )]
    FormatMismatch {
        pass: String,
        texture: String,
        writer: String,
        format: wgpu::TextureFormat,
        role: &'static str,
        remedy: &'static str,
    },
    /// A pass samples what it has attached.
    #[error(
        "pass `{pass}` reads `{texture}` ({writer}) while it is attached to the same pass; read another \
         mip or layer, an earlier copy, or (for depth) linear depth"
    )]
    Feedback { pass: String, texture: String, writer: String },
    /// A pass attaches one view twice.
    #[error("pass `{pass}` attaches `{texture}` ({writer}) twice; attach each view once")]
    AttachedTwice { pass: String, texture: String, writer: String },
    /// An attachment must be one mip of one layer.
    #[error(
        "pass `{pass}` attaches all of `{texture}` ({writer}), which has {mips} mips and {layers} layers; \
         attach one `Graph::subview` of it"
    )]
    NotOneView { pass: String, texture: String, writer: String, mips: u32, layers: u32 },
    /// A pass has nothing to draw to.
    #[error("pass `{pass}` (after {previous}) has no attachment; call `color` or `depth_stencil`")]
    NoAttachment { pass: String, previous: String },
    /// A pass has more colour targets than the adapter.
    #[error(
        "pass `{pass}` has {count} colour targets (the first of `{first}`, {writer}), the adapter allows \
         {limit}; split the pass or pack targets together"
    )]
    TooManyColorTargets { pass: String, count: u32, limit: u32, first: String, writer: String },
    /// The colour targets of a pass are too wide for the adapter.
    #[error(
        "pass `{pass}`: with `{texture}` ({writer}) the colour targets take {bytes} bytes per sample \
         (Rgba8Unorm counts 8), the adapter allows {limit}; use narrower formats or split the pass"
    )]
    ColorBytesExceeded { pass: String, texture: String, writer: String, bytes: u32, limit: u32 },
    /// A pass needs contents that nothing has written yet.
    #[error(
        "pass `{pass}` reads `{texture}` before anything writes it ({writer}); declare its writer first, \
         or import it"
    )]
    ReadBeforeWrite { pass: String, texture: String, writer: String },
    /// A pass keeps contents that nothing has written yet.
    #[error(
        "pass `{pass}` keeps the contents of `{texture}`, which has none yet ({writer}); clear it, or \
         declare its writer first"
    )]
    KeepUndefined { pass: String, texture: String, writer: String },
    /// A result of the frame has no contents.
    #[error("`{texture}` is exported, but not all of it is written ({writer}); write it, or drop the export")]
    ExportUnwritten { texture: String, writer: String },
    /// A size is zero or beyond the adapter.
    #[error(
        "texture `{texture}` (first used by {user}) is {width}x{height} with {layers} layers, {mips} mips, \
         {samples} samples; sizes go from 1 to {limit}, layers to 256, mips down to one texel, and several samples have one \
         mip of one layer"
    )]
    BadSize { texture: String, user: String, width: u32, height: u32, layers: u32, mips: u32, samples: u32, limit: u32 },
    /// A view outside its texture.
    #[error(
        "`{texture}` has no view of mips {mips:?} and layers {layers:?}: it has {mip_count} mips and {layer_count} layers; \
         name a range within them that is not empty"
    )]
    NoSuchView {
        texture: String,
        mips: std::ops::Range<u32>,
        layers: std::ops::Range<u32>,
        mip_count: u32,
        layer_count: u32,
    },
    /// Layers are sampled in a way in which WebGL 2 shows others.
    #[error(
        "pass `{pass}` samples `{texture}` ({writer}) {how}, which WebGL 2 cannot do (it shows other texels without an \
         error); {remedy}"
    )]
    SampledLayers { pass: String, texture: String, writer: String, how: &'static str, remedy: &'static str },
    /// A texture is sampled through a view of a shape that it does not have.
    #[error(
        "pass `{pass}` samples `{texture}` ({writer}) as {dimension:?}, but it is {width}x{height} with {layers} layers; a \
         cube has six square layers, and nothing has one or three dimensions"
    )]
    WrongDimension {
        pass: String,
        texture: String,
        writer: String,
        dimension: wgpu::TextureViewDimension,
        width: u32,
        height: u32,
        layers: u32,
    },
    /// A pass has two depth-stencil targets.
    #[error(
        "pass `{pass}` attaches `{texture}` ({writer}) beside `{other}`; a pass has one depth-stencil target, split the pass"
    )]
    DepthTwice { pass: String, texture: String, writer: String, other: String },
    /// A pass asked for a read of another pass while it was recorded.
    #[error("pass `{pass}` uses a read that it has not declared; call `Pass::read` in it")]
    UndeclaredRead { pass: String },
    /// A plan was to be run with another graph than its own.
    #[error("the plan belongs to another graph; call `Graph::plan` on the graph that is run")]
    ForeignPlan,
    /// A history has one version a frame.
    #[error("the history `{history}` is asked for twice in one frame; pass its handles on, or name the view")]
    HistoryTwice { history: String },
    /// A handle of one graph was used in another.
    #[error(
        "`{pass}` uses `{texture}`, a handle from another graph; declare the texture in this graph, or \
         import it"
    )]
    ForeignHandle { pass: String, texture: String },
}
