//! Finds contradictions in a graph, in declaration order.

use crate::graph::{ColorLoad, Graph, PassNode, Source, Use, UseKind};
use crate::{DepthLoad, PlanError, TextureDesc};
use wgpu::TextureViewDimension as Dimension;

/// More layers than any pass needs; the least that WebGL 2 offers.
const MAX_LAYERS: u32 = 256;
const NOBODY: u32 = u32::MAX;

/// The first subresource of each texture in lists of all subresources.
pub(crate) fn subresource_bases(graph: &Graph<'_>) -> (Vec<u32>, u32) {
    let mut total = 0;
    let bases = graph
        .textures
        .iter()
        .map(|texture| {
            let base = total;
            total += texture.desc.subresources();
            base
        })
        .collect();
    (bases, total)
}

pub(crate) fn desc_of(graph: &Graph<'_>, used: &Use) -> TextureDesc {
    used.part.desc(&graph.textures[used.texture as usize].desc)
}

struct Checker<'a, 'frame> {
    graph: &'a Graph<'frame>,
    bases: Vec<u32>,
    /// The pass that wrote each subresource last.
    writers: Vec<u32>,
}

pub(crate) fn check(graph: &Graph<'_>) -> Result<(), PlanError> {
    for (index, texture) in graph.textures.iter().enumerate() {
        check_size(graph, index as u32, &texture.desc)?;
    }
    let (bases, total) = subresource_bases(graph);
    let mut checker = Checker { graph, bases, writers: vec![NOBODY; total as usize] };
    for (index, pass) in graph.passes.iter().enumerate() {
        checker.pass(index as u32, pass)?;
    }
    for &(texture, part) in &graph.exports {
        let used = Use { texture, part, kind: UseKind::DepthReadOnly };
        if !checker.has_contents(&used) {
            return Err(PlanError::ExportUnwritten { texture: checker.name(&used), writer: checker.writer(&used) });
        }
    }
    Ok(())
}

fn check_size(graph: &Graph<'_>, index: u32, desc: &TextureDesc) -> Result<(), PlanError> {
    let limit = graph.limits.max_texture_size;
    let good = (1..=limit).contains(&desc.width)
        && (1..=limit).contains(&desc.height)
        && (1..=MAX_LAYERS).contains(&desc.layers)
        && (1..=desc.max_mips()).contains(&desc.mips)
        && matches!(desc.samples, 1 | 2 | 4 | 8 | 16)
        && (desc.samples == 1 || desc.subresources() == 1);
    if good {
        return Ok(());
    }
    let user = graph.passes.iter().find(|pass| {
        let uses = pass.uses.start as usize..pass.uses.end as usize;
        graph.uses[uses].iter().any(|used| used.texture == index)
    });
    Err(PlanError::BadSize {
        texture: graph.textures[index as usize].name.to_string(),
        user: user.map_or_else(|| "no pass".to_owned(), |pass| format!("pass `{}`", pass.name)),
        width: desc.width,
        height: desc.height,
        layers: desc.layers,
        mips: desc.mips,
        samples: desc.samples,
        limit,
    })
}

impl Checker<'_, '_> {
    fn pass(&mut self, index: u32, pass: &PassNode<'_>) -> Result<(), PlanError> {
        let graph = self.graph;
        let uses = &graph.uses[pass.uses.start as usize..pass.uses.end as usize];
        let mut first: Option<&Use> = None;
        for (position, used) in uses.iter().enumerate() {
            self.format(pass, used)?;
            self.samples(pass, used, &uses[..position])?;
            self.layers(pass, used)?;
            if used.kind.is_attachment() {
                self.attachment(pass, used, first)?;
                first.get_or_insert(used);
            }
            self.overlap(pass, used, &uses[..position])?;
            self.one_depth(pass, used, &uses[..position])?;
            self.contents(index, pass, used)?;
        }
        if first.is_none() {
            let previous = index.checked_sub(1).map_or_else(
                || "the beginning of the frame".to_owned(),
                |previous| format!("`{}`", graph.passes[previous as usize].name),
            );
            return Err(PlanError::NoAttachment { pass: pass.name.to_string(), previous });
        }
        self.color_budget(pass, uses)?;
        for used in uses.iter().filter(|used| used.kind.is_write()) {
            for subresource in self.subresources(used) {
                self.writers[subresource] = index;
            }
        }
        Ok(())
    }

    fn format(&self, pass: &PassNode<'_>, used: &Use) -> Result<(), PlanError> {
        let format = self.graph.textures[used.texture as usize].desc.format;
        let depth_stencil = format.is_depth_stencil_format();
        let (good, role, remedy) = match used.kind {
            UseKind::Color(_) | UseKind::Resolve => (
                !depth_stencil && format.target_pixel_byte_cost().is_some(),
                "a colour target",
                "a renderable colour format, or `depth_stencil`",
            ),
            UseKind::DepthStencil(_) | UseKind::DepthReadOnly => {
                (depth_stencil, "a depth-stencil target", "a depth format, or `color`")
            }
            UseKind::Sampled { depth_only, .. } => (
                format.has_depth_aspect() || (!depth_only && !depth_stencil),
                "a sampled texture this way",
                "`read_depth` for formats with depth and `read` for colour formats",
            ),
        };
        if good {
            return Ok(());
        }
        Err(PlanError::FormatMismatch {
            pass: pass.name.to_string(),
            texture: self.name(used),
            writer: self.writer(used),
            format,
            role,
            remedy,
        })
    }

    /// Samples of a texel are drawn to, and become one by [`UseKind::Resolve`]; nothing else knows them.
    fn samples(&self, pass: &PassNode<'_>, used: &Use, before: &[Use]) -> Result<(), PlanError> {
        let desc = desc_of(self.graph, used);
        let (name, texture, writer) = (|| pass.name.to_string(), self.name(used), self.writer(used));
        match used.kind {
            UseKind::Sampled { .. } if desc.samples > 1 => {
                Err(PlanError::SampledSamples { pass: name(), texture, writer, samples: desc.samples })
            }
            UseKind::Resolve => {
                let last = before.last().filter(|last| matches!(last.kind, UseKind::Color(_)));
                let color = last.map(|last| desc_of(self.graph, last));
                let fits = color.is_some_and(|color| color.samples > 1 && color.format == desc.format);
                if fits && desc.samples == 1 {
                    return Ok(());
                }
                let color = last.map_or_else(|| "no colour target".to_owned(), |last| format!("`{}`", self.name(last)));
                Err(PlanError::ResolveMismatch { pass: name(), texture, writer, color })
            }
            _ => Ok(()),
        }
    }

    /// What OpenGL shows wrong without an error: it has no views, so that a texture is sampled as what it was made, and
    /// what is square with six layers, or twelve, was made as a cube map.
    fn layers(&self, pass: &PassNode<'_>, used: &Use) -> Result<(), PlanError> {
        let UseKind::Sampled { dimension, .. } = used.kind else { return Ok(()) };
        let desc = &self.graph.textures[used.texture as usize].desc;
        let is_cube = desc.width == desc.height && desc.layers.is_multiple_of(6);
        let fault = match dimension {
            Some(Dimension::D2Array) if desc.layers == 1 => Some(("as an array of one layer", "sample it as `D2`")),
            _ if desc.layers == 1 => None,
            Some(Dimension::D2) => Some(("as one layer of several", "give the layer a texture of its own")),
            _ if used.part.layers != desc.layers => {
                Some(("as some layers of several", "sample all layers and choose in the shader"))
            }
            Some(Dimension::Cube | Dimension::CubeArray) => None,
            _ if is_cube => {
                Some(("as an array, though it is square with six layers", "sample it as `Cube`, or add a layer"))
            }
            _ => None,
        };
        let names = || (pass.name.to_string(), self.name(used), self.writer(used));
        if let Some((how, remedy)) = fault {
            let (pass, texture, writer) = names();
            return Err(PlanError::SampledLayers { pass, texture, writer, how, remedy });
        }
        let is_square = desc.width == desc.height;
        match dimension {
            Some(Dimension::Cube) if is_square && used.part.layers == 6 => Ok(()),
            Some(Dimension::CubeArray) if is_square && used.part.layers.is_multiple_of(6) => Ok(()),
            None | Some(Dimension::D2 | Dimension::D2Array) => Ok(()),
            Some(dimension) => {
                let (pass, texture, writer) = names();
                let TextureDesc { width, height, layers, .. } = *desc;
                Err(PlanError::WrongDimension { pass, texture, writer, dimension, width, height, layers })
            }
        }
    }

    fn one_depth(&self, pass: &PassNode<'_>, used: &Use, before: &[Use]) -> Result<(), PlanError> {
        let is_depth = |used: &&Use| matches!(used.kind, UseKind::DepthStencil(_) | UseKind::DepthReadOnly);
        let Some(other) = before.iter().find(is_depth).filter(|_| is_depth(&used)) else { return Ok(()) };
        let (pass, texture, writer) = (pass.name.to_string(), self.name(used), self.writer(used));
        Err(PlanError::DepthTwice { pass, texture, writer, other: self.name(other) })
    }

    fn attachment(&self, pass: &PassNode<'_>, used: &Use, first: Option<&Use>) -> Result<(), PlanError> {
        let desc = desc_of(self.graph, used);
        if !used.part.is_one() {
            return Err(PlanError::NotOneView {
                pass: pass.name.to_string(),
                texture: self.name(used),
                writer: self.writer(used),
                mips: desc.mips,
                layers: desc.layers,
            });
        }
        let Some(first) = first else { return Ok(()) };
        let other = desc_of(self.graph, first);
        if (desc.width, desc.height) != (other.width, other.height) {
            return Err(PlanError::SizeMismatch {
                pass: pass.name.to_string(),
                texture: self.name(used),
                writer: self.writer(used),
                width: desc.width,
                height: desc.height,
                other: self.name(first),
                other_writer: self.writer(first),
                other_width: other.width,
                other_height: other.height,
            });
        }
        if desc.samples != other.samples && used.kind != UseKind::Resolve {
            return Err(PlanError::SampleMismatch {
                pass: pass.name.to_string(),
                texture: self.name(used),
                writer: self.writer(used),
                samples: desc.samples,
                other: self.name(first),
                other_writer: self.writer(first),
                other_samples: other.samples,
            });
        }
        Ok(())
    }

    /// Two uses of one subresource in one pass: only two reads are allowed, of which one may be an attachment where the
    /// limits say so.
    fn overlap(&self, pass: &PassNode<'_>, used: &Use, before: &[Use]) -> Result<(), PlanError> {
        for other in before {
            let meets = used.texture == other.texture && used.part.overlaps(other.part);
            let attached = (used.kind.is_attachment(), other.kind.is_attachment());
            let samples_attached = matches!(
                (used.kind, other.kind),
                (UseKind::DepthReadOnly, UseKind::Sampled { depth_only: true, .. })
                    | (UseKind::Sampled { depth_only: true, .. }, UseKind::DepthReadOnly)
            );
            let is_allowed = samples_attached && self.graph.limits.samples_attached_depth;
            if !meets || attached == (false, false) || is_allowed {
                continue;
            }
            let (pass, texture) = (pass.name.to_string(), self.name(used));
            let writer = self.writer(used);
            return Err(if attached == (true, true) {
                PlanError::AttachedTwice { pass, texture, writer }
            } else {
                PlanError::Feedback { pass, texture, writer }
            });
        }
        Ok(())
    }

    fn contents(&self, index: u32, pass: &PassNode<'_>, used: &Use) -> Result<(), PlanError> {
        if !used.kind.needs_contents() || self.has_contents(used) {
            return Ok(());
        }
        let (pass, texture) = (pass.name.to_string(), self.name(used));
        let writer = self.later_writer(index, used);
        Err(match used.kind {
            UseKind::Color(ColorLoad::Keep) | UseKind::DepthStencil(DepthLoad::Keep) => {
                PlanError::KeepUndefined { pass, texture, writer }
            }
            _ => PlanError::ReadBeforeWrite { pass, texture, writer },
        })
    }

    /// WebGPU's "calculating color attachment bytes per sample".
    fn color_budget(&self, pass: &PassNode<'_>, uses: &[Use]) -> Result<(), PlanError> {
        let limits = &self.graph.limits;
        let colors = || uses.iter().filter(|used| matches!(used.kind, UseKind::Color(_)));
        let count = colors().count() as u32;
        let mut bytes = 0_u32;
        for used in colors() {
            if count > limits.max_color_attachments {
                return Err(PlanError::TooManyColorTargets {
                    pass: pass.name.to_string(),
                    count,
                    limit: limits.max_color_attachments,
                    first: self.name(used),
                    writer: self.writer(used),
                });
            }
            let format = self.graph.textures[used.texture as usize].desc.format;
            let alignment = format.target_component_alignment().unwrap_or(1);
            let cost = format.target_pixel_byte_cost().unwrap_or(0);
            bytes = bytes.next_multiple_of(alignment) + cost;
            if bytes > limits.max_color_bytes_per_sample {
                return Err(PlanError::ColorBytesExceeded {
                    pass: pass.name.to_string(),
                    texture: self.name(used),
                    writer: self.writer(used),
                    bytes,
                    limit: limits.max_color_bytes_per_sample,
                });
            }
        }
        Ok(())
    }

    fn subresources(&self, used: &Use) -> impl Iterator<Item = usize> + use<> {
        let texture = used.texture as usize;
        let base = self.bases[texture];
        used.part.subresources(&self.graph.textures[texture].desc).map(move |place| (base + place) as usize)
    }

    /// The passes that wrote the subresources of a use last.
    fn writers_of(&self, used: &Use) -> impl Iterator<Item = u32> {
        self.subresources(used).map(|subresource| self.writers[subresource])
    }

    fn has_contents(&self, used: &Use) -> bool {
        self.graph.textures[used.texture as usize].is_persistent()
            || self.writers_of(used).all(|writer| writer != NOBODY)
    }

    fn name(&self, used: &Use) -> String {
        let texture = &self.graph.textures[used.texture as usize];
        format!("{}{}", texture.name, used.part.suffix(&texture.desc))
    }

    /// Where the contents of a use come from.
    fn writer(&self, used: &Use) -> String {
        let last = self.writers_of(used).filter(|writer| *writer != NOBODY).max();
        match last.map(|writer| &self.graph.passes[writer as usize]) {
            Some(pass) => format!("written by `{}`", pass.name),
            None if matches!(self.graph.textures[used.texture as usize].source, Source::History { .. }) => {
                "of the frame before".to_owned()
            }
            None if self.graph.textures[used.texture as usize].is_persistent() => "imported".to_owned(),
            None => "written by no pass before".to_owned(),
        }
    }

    /// The pass that would have to come earlier for a use to have contents.
    fn later_writer(&self, index: u32, wanted: &Use) -> String {
        let later = self.graph.passes[index as usize + 1..].iter().find(|pass| {
            let uses = pass.uses.start as usize..pass.uses.end as usize;
            self.graph.uses[uses]
                .iter()
                .any(|used| used.kind.is_write() && used.texture == wanted.texture && used.part.overlaps(wanted.part))
        });
        match later {
            Some(pass) => format!("`{}` writes it later", pass.name),
            None if self.writers_of(wanted).any(|writer| writer != NOBODY) => {
                format!("only part of it is {}", self.writer(wanted))
            }
            None => "no pass writes it".to_owned(),
        }
    }
}
