//! Textures that stay allocated between frames.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::TextureDesc;

/// Which view of a texture, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ViewKey {
    /// Mip and layer; `None` is all of them.
    pub(crate) part: Option<(u32, u32)>,
    pub(crate) dimension: Option<wgpu::TextureViewDimension>,
    pub(crate) aspect: wgpu::TextureAspect,
}

pub(crate) fn create_view(texture: &wgpu::Texture, key: ViewKey) -> wgpu::TextureView {
    let one = key.part.map(|_| 1);
    let (mip, layer) = key.part.unwrap_or((0, 0));
    let layers = texture.depth_or_array_layers();
    let natural = if key.part.is_some() || layers == 1 {
        wgpu::TextureViewDimension::D2
    } else {
        wgpu::TextureViewDimension::D2Array
    };
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(key.dimension.unwrap_or(natural)),
        aspect: key.aspect,
        base_mip_level: mip,
        mip_level_count: one,
        base_array_layer: layer,
        array_layer_count: one,
        ..Default::default()
    })
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

struct Pooled {
    desc: TextureDesc,
    usage: wgpu::TextureUsages,
    texture: wgpu::Texture,
    /// Few per texture: a scan is faster than a map.
    views: Vec<(ViewKey, wgpu::TextureView)>,
    taken: bool,
    used_since_forget: bool,
}

impl Pooled {
    /// Whether the texture is of this shape and can be used in these ways, and perhaps in others.
    fn serves(&self, desc: &TextureDesc, usage: wgpu::TextureUsages) -> bool {
        self.desc == *desc && self.usage.contains(usage)
    }
}

/// Transient textures by descriptor and usage.
#[derive(Default)]
pub(crate) struct Pool {
    textures: Vec<Pooled>,
}

impl Pool {
    /// A texture that nobody has taken since [`Pool::release_all`]. Its label is
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
            self.textures.push(Pooled {
                desc: *desc,
                usage,
                texture: create_texture(device, label, desc, usage),
                views: Vec::new(),
                taken: false,
                used_since_forget: false,
            });
            self.textures.len() - 1
        });
        self.textures[index].taken = true;
        self.textures[index].used_since_forget = true;
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
        wanted.iter().filter(|texture| is_missing(texture)).map(|(desc, _)| desc.bytes()).sum()
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

    pub(crate) fn release_all(&mut self) {
        for pooled in &mut self.textures {
            pooled.taken = false;
        }
    }

    pub(crate) fn forget_unused(&mut self) {
        self.textures.retain_mut(|pooled| std::mem::take(&mut pooled.used_since_forget));
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.textures.iter().map(|pooled| pooled.desc.bytes()).sum()
    }
}

struct Pair {
    desc: TextureDesc,
    views: [wgpu::TextureView; 2],
    /// Which of the two was written last.
    newest: usize,
    used_since_forget: bool,
}

/// Ping-pong pairs that carry a texture from one frame to the next.
#[derive(Default)]
pub(crate) struct Histories {
    pairs: HashMap<(Cow<'static, str>, u32), Pair>,
}

impl Histories {
    pub(crate) fn swap(
        &mut self,
        device: &wgpu::Device,
        name: Cow<'static, str>,
        view: u32,
        desc: TextureDesc,
    ) -> (wgpu::TextureView, wgpu::TextureView, bool) {
        let key = (name, view);
        let known = self.pairs.get(&key).is_some_and(|pair| pair.desc == desc);
        if !known {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC;
            let views = ["0", "1"].map(|which| {
                let label = format!("{}.history{which}", key.0);
                create_view(
                    &create_texture(device, &label, &desc, usage),
                    ViewKey { part: None, dimension: None, aspect: wgpu::TextureAspect::All },
                )
            });
            let pair = Pair { desc, views, newest: 0, used_since_forget: true };
            let result = (pair.views[1].clone(), pair.views[0].clone(), true);
            self.pairs.insert(key, pair);
            return result;
        }
        let pair = self.pairs.get_mut(&key).expect("the key is known");
        let previous = pair.newest;
        pair.newest = 1 - previous;
        pair.used_since_forget = true;
        (pair.views[previous].clone(), pair.views[pair.newest].clone(), false)
    }

    pub(crate) fn forget_unused(&mut self) {
        self.pairs.retain(|_, pair| std::mem::take(&mut pair.used_since_forget));
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.pairs.values().map(|pair| 2 * pair.desc.bytes()).sum()
    }
}
