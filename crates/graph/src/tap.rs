//! Copies of what passes write.

use serde::Serialize;

use crate::TextureDesc;
use crate::execute::Recorder;
use crate::plan::{PlannedAttachment, PlannedPass, Target};
use crate::report::Run;

/// What to copy of what passes write. What cannot be copied is named in [`Run::untapped`].
#[derive(Clone, Copy, Debug, Default)]
pub enum Taps<'a> {
    /// Nothing.
    #[default]
    None,
    /// Everything, for [`Run::read`].
    All,
    /// One target as it is after one pass, into a texture of the caller's, for an inspector that runs along. It takes a
    /// copy on the device and waits for nothing.
    One {
        /// The name of the pass.
        pass: &'a str,
        /// The name of the target, as in [`Tap::texture`].
        texture: &'a str,
        /// Of the target's size and format, with `COPY_DST`.
        into: &'a wgpu::Texture,
    },
}

impl Taps<'_> {
    /// Whether a render pass ends with this pass, because what it wrote is copied then.
    pub(crate) fn ends_with(&self, name: &str) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::One { pass, .. } => *pass == name,
        }
    }

    /// Whether a texture of this name may have to be copied.
    pub(crate) fn may_copy(&self, name: &str) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            // The name of a view begins with that of its texture.
            Self::One { texture, .. } => texture.starts_with(name),
        }
    }
}

/// A copy of one attachment as it was after one pass.
#[derive(Clone, Debug)]
pub struct Tap {
    /// Name of the pass that wrote it.
    pub pass: String,
    /// Name of the texture or view.
    pub texture: String,
    /// Shape of the copied view. Of a depth format, depth alone is copied.
    pub desc: TextureDesc,
    /// The rows, for mapping after submission.
    pub buffer: wgpu::Buffer,
    /// Distance of rows in `buffer`; a multiple of 256.
    pub bytes_per_row: u32,
}

/// A target that was to be copied and could not be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TapFailure {
    /// Name of the pass that wrote it.
    pub pass: String,
    /// Name of the texture or view.
    pub texture: String,
    /// Why.
    pub reason: &'static str,
}

/// Copies what `pass` has written, as far as it was asked for.
pub(crate) fn record(recorder: &Recorder<'_>, encoder: &mut wgpu::CommandEncoder, pass: &PlannedPass, run: &mut Run) {
    let taps = recorder.options.taps;
    if !taps.ends_with(&pass.name) {
        return;
    }
    for attachment in pass.attachments.iter().filter(|attachment| attachment.target != Target::DepthReadOnly) {
        let name = recorder.plan.attachment_name(attachment);
        let copied = match taps {
            Taps::One { texture, into, .. } if texture == name => copy_into(recorder, encoder, attachment, into),
            Taps::All => copy(recorder, encoder, attachment, &name).map(|(desc, buffer, bytes_per_row)| {
                run.taps.push(Tap { pass: pass.name.to_string(), texture: name.clone(), desc, buffer, bytes_per_row });
            }),
            Taps::One { .. } | Taps::None => continue,
        };
        if let Err(reason) = copied {
            run.untapped.push(TapFailure { pass: pass.name.to_string(), texture: name, reason });
        }
    }
}

/// Where to copy from; or why that is not possible.
fn source<'a>(
    recorder: &'a Recorder<'_>,
    attachment: &PlannedAttachment,
) -> Result<(wgpu::TexelCopyTextureInfo<'a>, TextureDesc), &'static str> {
    let planned = &recorder.plan.textures[attachment.texture as usize];
    let texture = &recorder.resources.textures[attachment.texture as usize];
    let is_depth = planned.desc.format.is_depth_stencil_format();
    if planned.desc.samples > 1 {
        return Err("it has several samples a texel");
    }
    if !texture.usage().contains(wgpu::TextureUsages::COPY_SRC) {
        return Err("it was imported without `COPY_SRC`");
    }
    if is_depth && !recorder.executor.can_copy_depth {
        return Err("OpenGL copies no depth; look at the linear depth");
    }
    let info = wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: attachment.mip,
        origin: wgpu::Origin3d { x: 0, y: 0, z: attachment.layer },
        aspect: if is_depth { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All },
    };
    Ok((info, planned.desc.of_mip(attachment.mip)))
}

fn copy_into(
    recorder: &Recorder<'_>,
    encoder: &mut wgpu::CommandEncoder,
    attachment: &PlannedAttachment,
    into: &wgpu::Texture,
) -> Result<(), &'static str> {
    let (info, desc) = source(recorder, attachment)?;
    let size = wgpu::Extent3d { width: desc.width, height: desc.height, depth_or_array_layers: 1 };
    if into.size() != size || into.format() != desc.format || !into.usage().contains(wgpu::TextureUsages::COPY_DST) {
        return Err("the texture to copy it into has another size or format, or lacks `COPY_DST`");
    }
    // Depth and stencil are copied together or not at all.
    let info = wgpu::TexelCopyTextureInfo { aspect: wgpu::TextureAspect::All, ..info };
    encoder.copy_texture_to_texture(info, into.as_image_copy(), size);
    Ok(())
}

fn copy(
    recorder: &Recorder<'_>,
    encoder: &mut wgpu::CommandEncoder,
    attachment: &PlannedAttachment,
    name: &str,
) -> Result<(TextureDesc, wgpu::Buffer, u32), &'static str> {
    let (info, desc) = source(recorder, attachment)?;
    let (_, texel_bytes) = copied_format(desc.format).ok_or("its format has no layout in buffers")?;
    let bytes_per_row = (desc.width * texel_bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = recorder.executor.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(name),
        size: u64::from(bytes_per_row) * u64::from(desc.height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    encoder.copy_texture_to_buffer(
        info,
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None },
        },
        wgpu::Extent3d { width: desc.width, height: desc.height, depth_or_array_layers: 1 },
    );
    Ok((desc, buffer, bytes_per_row))
}

/// The format and texel size of a copy; `None` if it cannot be copied.
pub(crate) fn copied_format(format: wgpu::TextureFormat) -> Option<(wgpu::TextureFormat, u32)> {
    use wgpu::TextureFormat as F;
    match format {
        F::Depth32Float | F::Depth32FloatStencil8 => Some((F::Depth32Float, 4)),
        F::Depth16Unorm => Some((F::Depth16Unorm, 2)),
        F::Depth24Plus | F::Depth24PlusStencil8 | F::Stencil8 => None,
        other => other.block_copy_size(None).map(|bytes| (other, bytes)),
    }
}
