//! Textures that stay allocated between frames.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::TextureDesc;
use crate::graph::{HistoryNode, UseKind};
use crate::subresource::SubresourceRange;

/// Which view of a texture, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ViewKey {
    /// Mips and layers; `None` is all of them.
    pub(crate) part: Option<SubresourceRange>,
    pub(crate) dimension: Option<wgpu::TextureViewDimension>,
    pub(crate) aspect: wgpu::TextureAspect,
}

pub(crate) fn create_view(texture: &wgpu::Texture, key: ViewKey) -> wgpu::TextureView {
    let layers = key.part.map_or(texture.depth_or_array_layers(), |part| part.layers);
    let natural = if layers == 1 { wgpu::TextureViewDimension::D2 } else { wgpu::TextureViewDimension::D2Array };
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(key.dimension.unwrap_or(natural)),
        aspect: key.aspect,
        base_mip_level: key.part.map_or(0, |part| part.mip),
        mip_level_count: key.part.map(|part| part.mips),
        base_array_layer: key.part.map_or(0, |part| part.layer),
        array_layer_count: key.part.map(|part| part.layers),
        ..Default::default()
    })
}

/// How a use sees its texture.
pub(crate) fn view_key(kind: UseKind, desc: &TextureDesc, part: Option<SubresourceRange>) -> ViewKey {
    let (dimension, aspect) = match kind {
        UseKind::Sampled { dimension, .. } if desc.has_depth() => (dimension, wgpu::TextureAspect::DepthOnly),
        UseKind::Sampled { dimension, .. } => (dimension, wgpu::TextureAspect::All),
        _ => (None, wgpu::TextureAspect::All),
    };
    ViewKey { part, dimension, aspect }
}

/// The imported view itself serves wherever it can, because it may have another format than its texture.
pub(crate) fn imported_view(view: &wgpu::TextureView, desc: &TextureDesc, key: ViewKey) -> wgpu::TextureView {
    let is_whole = desc.subresources() == 1 || (key.part.is_none() && key.dimension.is_none());
    if is_whole && key.aspect == wgpu::TextureAspect::All { view.clone() } else { create_view(view.texture(), key) }
}

pub(crate) fn create_texture(
    device: &wgpu::Device,
    label: &str,
    desc: &TextureDesc,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: desc.width, height: desc.height, depth_or_array_layers: desc.layers },
        mip_level_count: desc.mips,
        sample_count: desc.samples,
        dimension: wgpu::TextureDimension::D2,
        format: desc.format,
        usage,
        view_formats: &[],
    })
}

/// The usage of attachments that need no memory. It goes with no other but that of attachments, and asks for them to be
/// cleared and dropped.
pub(crate) const MEMORYLESS: wgpu::TextureUsages = wgpu::TextureUsages::TRANSIENT_ATTACHMENT;

/// The memory of a texture, as far as it needs any.
fn memory_bytes(desc: &TextureDesc, usage: wgpu::TextureUsages) -> u64 {
    if usage.contains(MEMORYLESS) { 0 } else { desc.bytes() }
}

struct PoolEntry {
    desc: TextureDesc,
    usage: wgpu::TextureUsages,
    texture: wgpu::Texture,
    /// Few per texture: a scan is faster than a map.
    views: Vec<(ViewKey, wgpu::TextureView)>,
    taken: bool,
    /// The frame that took it last.
    last_frame: u64,
}

impl PoolEntry {
    /// Whether the texture is of this shape and can be used in these ways, and perhaps in others. One without memory keeps
    /// nothing, so that it serves nobody else.
    fn serves(&self, desc: &TextureDesc, usage: wgpu::TextureUsages) -> bool {
        let is_alike = self.usage.contains(MEMORYLESS) == usage.contains(MEMORYLESS);
        self.desc == *desc && self.usage.contains(usage) && is_alike
    }

    fn bytes(&self) -> u64 {
        memory_bytes(&self.desc, self.usage)
    }
}

/// After this many frames without use a texture is given back, however much memory there is: more than the frames of a
/// still between two that want the same variables, and about two seconds of a live view.
const KEPT_FRAMES: u64 = 120;

/// Transient textures by descriptor and usage.
#[derive(Default)]
pub(crate) struct Pool {
    textures: Vec<PoolEntry>,
    frame: u64,
    /// How many were created so far.
    made: u64,
    /// What is held no longer, and may still stand in an encoder that is not submitted.
    given_back: Vec<wgpu::Texture>,
}

impl Pool {
    /// A texture that nobody has taken since [`Pool::end_run`]. Its label is
    /// the name of whoever needed it first.
    pub(crate) fn take(
        &mut self,
        device: &wgpu::Device,
        label: &str,
        desc: &TextureDesc,
        usage: wgpu::TextureUsages,
    ) -> usize {
        let free = self.textures.iter().position(|pooled| !pooled.taken && pooled.serves(desc, usage));
        let index = free.unwrap_or_else(|| {
            self.made += 1;
            self.textures.push(PoolEntry {
                desc: *desc,
                usage,
                texture: create_texture(device, label, desc, usage),
                views: Vec::new(),
                taken: false,
                last_frame: self.frame,
            });
            self.textures.len() - 1
        });
        self.textures[index].taken = true;
        self.textures[index].last_frame = self.frame;
        index
    }

    /// Memory of the textures that [`Pool::take`] would create for all of `wanted` together.
    pub(crate) fn missing_bytes(&self, wanted: &[(TextureDesc, wgpu::TextureUsages)]) -> u64 {
        let mut is_free: Vec<bool> = self.textures.iter().map(|pooled| !pooled.taken).collect();
        let mut is_missing = |(desc, usage): &(TextureDesc, wgpu::TextureUsages)| {
            let mut candidates = self.textures.iter().zip(&mut is_free);
            let found = candidates.find(|(pooled, is_free)| **is_free && pooled.serves(desc, *usage));
            found.map(|(_, is_free)| *is_free = false).is_none()
        };
        wanted.iter().filter(|texture| is_missing(texture)).map(|(desc, usage)| memory_bytes(desc, *usage)).sum()
    }

    /// Forgets the textures that `is_gone` names; whoever holds a clone of one keeps it.
    pub(crate) fn remove(&mut self, is_gone: impl Fn(&wgpu::Texture) -> bool) {
        self.textures.retain(|pooled| !is_gone(&pooled.texture));
    }

    pub(crate) fn texture(&self, index: usize) -> &wgpu::Texture {
        &self.textures[index].texture
    }

    pub(crate) fn view(&mut self, index: usize, key: ViewKey) -> wgpu::TextureView {
        let pooled = &mut self.textures[index];
        if let Some((_, view)) = pooled.views.iter().find(|(known, _)| *known == key) {
            return view.clone();
        }
        let view = create_view(&pooled.texture, key);
        pooled.views.push((key, view.clone()));
        view
    }

    /// Ends a run: everything is free again for the next one of the same frame.
    pub(crate) fn end_run(&mut self) {
        self.textures.iter_mut().for_each(|pooled| pooled.taken = false);
    }

    /// Ends a frame: what none of its runs used is given back, the longest unused first, until it takes no more memory
    /// than what was used. So a resized view does not pile up the textures of every size it had.
    pub(crate) fn end_frame(&mut self) {
        let frame = self.frame;
        let used_bytes: u64 =
            self.textures.iter().filter(|pooled| pooled.last_frame == frame).map(PoolEntry::bytes).sum();
        let mut unused: Vec<(u64, u64)> = self
            .textures
            .iter()
            .filter(|pooled| pooled.last_frame != frame)
            .map(|pooled| (pooled.last_frame, pooled.bytes()))
            .collect();
        unused.sort_unstable_by(|a, b| b.cmp(a));
        // The most recent unused textures that fit beside the used ones; of one frame all or none.
        let mut kept_bytes = 0;
        let mut oldest_kept = frame;
        for (index, &(last_frame, bytes)) in unused.iter().enumerate() {
            kept_bytes += bytes;
            if kept_bytes > used_bytes {
                break;
            }
            if unused.get(index + 1).is_none_or(|next| next.0 != last_frame) {
                oldest_kept = last_frame;
            }
        }
        let oldest_kept = oldest_kept.max(frame.saturating_sub(KEPT_FRAMES));
        let given_back = &mut self.given_back;
        self.textures.retain(|pooled| {
            let is_kept = pooled.last_frame >= oldest_kept;
            if !is_kept {
                given_back.push(pooled.texture.clone());
            }
            is_kept
        });
        self.frame += 1;
    }

    /// How many textures were created so far.
    pub(crate) fn made(&self) -> u64 {
        self.made
    }

    /// What was given back since this was last called.
    pub(crate) fn take_given_back(&mut self) -> Vec<wgpu::Texture> {
        std::mem::take(&mut self.given_back)
    }

    pub(crate) fn destroy(&self) {
        self.textures.iter().for_each(|pooled| pooled.texture.destroy());
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.textures.iter().map(PoolEntry::bytes).sum()
    }
}

/// The histories that frames have written, with their shapes: what a frame needs to know while it is declared.
pub(crate) type HistoryBook = BTreeMap<Cow<'static, str>, TextureDesc>;

struct Pair {
    desc: TextureDesc,
    textures: [wgpu::Texture; 2],
    /// Views of the two textures, by which of them and what of it.
    views: Vec<(usize, ViewKey, wgpu::TextureView)>,
    /// Which of the two was written last.
    newest: usize,
    /// The frame that used it last.
    last_frame: u64,
}

/// Ping-pong pairs that carry a texture from one frame to the next.
#[derive(Default)]
pub(crate) struct Histories {
    pairs: HashMap<Cow<'static, str>, Pair>,
    book: Arc<HistoryBook>,
    frame: u64,
    /// How many textures were created so far.
    made: u64,
    /// What is held no longer, and may still stand in an encoder that is not submitted.
    given_back: Vec<wgpu::Texture>,
}

impl Histories {
    pub(crate) fn book(&self) -> Arc<HistoryBook> {
        self.book.clone()
    }

    /// The texture that the last frame wrote, or the other one, which this frame writes, and a view of it. Both are made,
    /// and hold zeros, where there is no pair of this shape.
    pub(crate) fn take(
        &mut self,
        device: &wgpu::Device,
        HistoryNode { name, desc }: &HistoryNode,
        is_next: bool,
        key: ViewKey,
    ) -> (&wgpu::Texture, wgpu::TextureView) {
        let make = || {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC;
            let textures = [0, 1].map(|which| create_texture(device, &format!("{name}.history{which}"), desc, usage));
            Pair { desc: *desc, textures, views: Vec::new(), newest: 0, last_frame: 0 }
        };
        if self.pairs.get(name).is_none_or(|pair| pair.desc != *desc) {
            self.made += 2;
        }
        let pair = self.pairs.entry(name.clone()).or_insert_with(make);
        if pair.desc != *desc {
            let former = std::mem::replace(pair, make());
            self.given_back.extend(former.textures);
            Arc::make_mut(&mut self.book).remove(name);
        }
        pair.last_frame = self.frame;
        let which = if is_next { 1 - pair.newest } else { pair.newest };
        let known = pair.views.iter().find(|view| view.0 == which && view.1 == key).map(|view| view.2.clone());
        let view = known.unwrap_or_else(|| {
            let view = create_view(&pair.textures[which], key);
            pair.views.push((which, key, view.clone()));
            view
        });
        (&pair.textures[which], view)
    }

    /// What this frame wrote is what the next one finds.
    pub(crate) fn written(&mut self, name: &str) {
        let Some(pair) = self.pairs.get_mut(name) else { return };
        pair.newest = 1 - pair.newest;
        if self.book.get(name) != Some(&pair.desc) {
            Arc::make_mut(&mut self.book).insert(name.to_owned().into(), pair.desc);
        }
    }

    /// Ends a frame: histories that were long not asked for are given back.
    pub(crate) fn end_frame(&mut self) {
        let oldest_kept = self.frame.saturating_sub(KEPT_FRAMES);
        self.give_back(|_, pair| pair.last_frame < oldest_kept);
        self.frame += 1;
    }

    /// Gives back the histories of these names.
    pub(crate) fn forget(&mut self, is_gone: impl Fn(&str) -> bool) {
        self.give_back(|name, _| is_gone(name));
    }

    fn give_back(&mut self, is_gone: impl Fn(&str, &Pair) -> bool) {
        if !self.pairs.iter().any(|(name, pair)| is_gone(name, pair)) {
            return;
        }
        let given_back = &mut self.given_back;
        self.pairs.retain(|name, pair| {
            let is_kept = !is_gone(name, pair);
            if !is_kept {
                given_back.extend(pair.textures.iter().cloned());
            }
            is_kept
        });
        let pairs = &self.pairs;
        Arc::make_mut(&mut self.book).retain(|name, _| pairs.contains_key(name));
    }

    /// How many textures were created so far.
    pub(crate) fn made(&self) -> u64 {
        self.made
    }

    /// What was given back since this was last called.
    pub(crate) fn take_given_back(&mut self) -> Vec<wgpu::Texture> {
        std::mem::take(&mut self.given_back)
    }

    /// Whether `texture` carries what frames wrote to the next one.
    pub(crate) fn hold(&self, texture: &wgpu::Texture) -> bool {
        self.pairs.values().any(|pair| pair.textures.contains(texture))
    }

    pub(crate) fn destroy(&self) {
        self.pairs.values().flat_map(|pair| &pair.textures).for_each(wgpu::Texture::destroy);
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.pairs.values().map(|pair| 2 * pair.desc.bytes()).sum()
    }
}
