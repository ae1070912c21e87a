//! What is kept of a view from sample to sample: the means and the picture.

use super::DISPLAY;
use super::temporal::LastFrame;
use crate::aov::AovTextures;
use crate::draws::UnsettledTiles;
use crate::environment::Background;
use crate::frame::Means;
use crate::gpu::Gpu;
use crate::lights::{CachedLists, Rectangle};
use crate::overlay::OverlayState;
use crate::passes::accumulate::{Mean, SUM};
use crate::passes::adaptive::{self, ConvergedTiles};
use crate::record::ViewTables;
use crate::request::FrameRequest;
use manypass_graph::{Graph, Handle, TextureDesc};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// Beside other means.
const MEANS_OF_RADIANCE: [&str; 2] = ["accumulate.previous_radiance", "accumulate.radiance_sum"];

/// A texture that outlives frames, with its view.
#[derive(Debug)]
pub(super) struct PersistentTexture {
    pub texture: wgpu::Texture,
    pub view: wgpu::TextureView,
}

/// Textures of the output, kept from frame to frame.
#[derive(Debug)]
pub(super) struct Output {
    pub size: (u32, u32),
    /// The mean of display colours; of radiance where that is the only one, or of all but what glows. None, one or two
    /// textures.
    pub sums: Vec<PersistentTexture>,
    /// The mean of radiance beside those of the picture. None or two textures.
    pub radiance_sums: Vec<PersistentTexture>,
    /// The mean of what glows. None or two textures.
    glow_sums: Vec<PersistentTexture>,
    /// The mean of what comes through glass of the background beside what alpha says. None, one or two textures.
    pub tint_sums: Vec<PersistentTexture>,
    /// Which tiles of the picture are settled, and the mean of half of its samples; once they were needed.
    settling: Option<[PersistentTexture; 2]>,
    pub display: PersistentTexture,
    /// Whether a frame was drawn into them.
    pub is_drawn: bool,
}

/// The parts of a still's picture that are not settled.
#[derive(Clone, Debug)]
pub(super) struct UnsettledRegion {
    /// Rectangles around them.
    pub rectangles: Arc<[Rectangle]>,
    pub tiles: Arc<UnsettledTiles>,
}

/// What a view leaves for its next frame, and for whoever reads it.
#[derive(Debug)]
pub(super) struct ViewState {
    /// Whether it is within a picture, such as what a monitor shows.
    pub is_within: bool,
    pub tables: ViewTables,
    /// The lists of lights that `tables` hold.
    pub lists: Option<CachedLists>,
    pub output: Option<Output>,
    /// Which of the two sums holds the last frame's.
    pub latest_sum: usize,
    /// Whether tiles of the picture were looked for that are settled.
    pub has_settled: bool,
    /// What is not, if it is known.
    pub unsettled: Option<UnsettledRegion>,
    /// Of how many samples the picture of the last frame is.
    pub sample_count: u32,
    /// Whether that frame made a picture, and was not only added to one.
    pub was_shown: bool,
    /// What the last frame left means of, and what their radiance is multiplied by.
    pub means_of: MeansOf,
    pub pre_exposure: f32,
    /// What radiance is laid over where it is read, if that is a colour, and what makes radiance of it.
    pub background_radiance: (Background, f32),
    /// Whether there is glass before a background that is none of radiance.
    pub has_tint: bool,
    /// Pixels that half floats clamped, as of the last time radiance was read.
    pub clamped_pixels: AtomicU64,
    /// The last frame that was anti-aliased by those before it.
    pub temporal: Option<LastFrame>,
    /// The stops of the exposure of the last picture, in one texel, if it adapted.
    pub adapted: Option<wgpu::Texture>,
    /// What variables are made of, of the last frame that began a picture.
    pub aovs: Option<AovTextures>,
    /// What was drawn over the last picture.
    pub overlay: OverlayState,
}

impl ViewState {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            is_within: false,
            tables: ViewTables::new(gpu),
            lists: None,
            output: None,
            latest_sum: 0,
            has_settled: false,
            unsettled: None,
            sample_count: 1,
            was_shown: false,
            means_of: MeansOf::Nothing,
            pre_exposure: 1.0,
            background_radiance: (Background::Transparent, 1.0),
            has_tint: false,
            clamped_pixels: AtomicU64::new(0),
            temporal: None,
            adapted: None,
            aovs: None,
            overlay: OverlayState::default(),
        }
    }

    /// After a frame that failed: gives back textures that no frame was drawn into.
    pub fn forget_undrawn(&mut self) {
        if let Some(output) = self.output.take_if(|output| !output.is_drawn) {
            output.destroy();
        }
    }

    /// Bytes of its textures.
    pub fn bytes(&self) -> u64 {
        let of_picture = self.output.iter().flat_map(Output::textures);
        let textures = of_picture.chain(self.aovs.iter().flat_map(AovTextures::all));
        let bytes =
            |texture: &wgpu::Texture| TextureDesc::new_2d(texture.width(), texture.height(), texture.format()).bytes();
        textures.map(bytes).sum::<u64>() + self.tables.bytes()
    }

    /// The texture that says which tiles are settled, if they were looked for.
    pub fn settled_texture(&self) -> Option<&wgpu::Texture> {
        let [settled, _] = self.output.as_ref()?.settling.as_ref()?;
        self.has_settled.then_some(&settled.texture)
    }

    /// Which tiles of the picture that `sample_index` goes on with are settled, if that was looked for.
    pub fn settled(&self, sample_index: u32) -> Option<wgpu::TextureView> {
        let [settled, _] = self.output.as_ref()?.settling.as_ref()?;
        (self.has_settled && sample_index > 0).then(|| settled.view.clone())
    }
}

/// What a view's means are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeansOf {
    /// There are none: the picture is made of the radiance of the only sample.
    Nothing,
    /// The radiance of the only sample, to be read.
    OneSample,
    /// Display colours.
    Display,
    /// Radiance.
    Radiance,
    /// Display colours, and beside them radiance.
    Both,
    /// What glows, and all else.
    Parts,
    /// The same, and beside them the radiance of all.
    PartsAndRadiance,
}

impl MeansOf {
    /// Those that a frame of `request` leaves.
    pub fn request(request: &FrameRequest) -> Self {
        let is_alone = request.sample_count <= 1 && request.sample_index == 0;
        if request.averages_parts() {
            return if request.averages_radiance() { Self::PartsAndRadiance } else { Self::Parts };
        }
        match (request.averages_display(), request.averages_radiance()) {
            (false, false) if is_alone => Self::Nothing,
            (false, true) if is_alone => Self::OneSample,
            (false, _) => Self::Radiance,
            (true, false) => Self::Display,
            (true, true) => Self::Both,
        }
    }

    /// The number of textures for the first mean, for that of radiance beside it, and for that of what glows.
    fn counts(self) -> [usize; 3] {
        match self {
            Self::Nothing => [0, 0, 0],
            Self::OneSample => [1, 0, 0],
            Self::Display | Self::Radiance => [2, 0, 0],
            Self::Both => [2, 2, 0],
            Self::Parts => [2, 0, 2],
            Self::PartsAndRadiance => [2, 2, 2],
        }
    }

    /// Whether the next sample adds to them.
    pub fn go_on(self) -> bool {
        !matches!(self, Self::Nothing | Self::OneSample)
    }
}

fn create(gpu: &Gpu, label: &str, format: wgpu::TextureFormat, (width, height): (u32, u32)) -> PersistentTexture {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    PersistentTexture { view: texture.create_view(&Default::default()), texture }
}

/// The shapes of the textures that tell which tiles of a picture are settled.
fn settling_descs(size: (u32, u32)) -> [TextureDesc; 2] {
    [adaptive::settled_desc(size), TextureDesc::new_2d(size.0, size.1, adaptive::HALF)]
}

impl Output {
    /// Bytes of the textures that [`Self::of`] would create.
    pub fn missing_bytes(slot: Option<&Self>, size: (u32, u32), means_of: MeansOf, settles: bool) -> u64 {
        let shape = |format| TextureDesc::new_2d(size.0, size.1, format).bytes();
        let known = slot.filter(|output| output.size == size);
        let picture_bytes = if known.is_some() { 0 } else { shape(DISPLAY) };
        let held =
            known.map_or([0; 3], |output| [output.sums.len(), output.radiance_sums.len(), output.glow_sums.len()]);
        let missing: usize =
            means_of.counts().into_iter().zip(held).map(|(wanted, held)| wanted.saturating_sub(held)).sum();
        let lacks_settling = settles && known.is_none_or(|output| output.settling.is_none());
        let settling_bytes =
            if lacks_settling { settling_descs(size).map(|desc| desc.bytes()).iter().sum() } else { 0 };
        picture_bytes + missing as u64 * shape(SUM) + settling_bytes
    }

    /// Whether it is for pictures of `size`.
    pub fn is_of(&self, size: (u32, u32)) -> bool {
        self.size == size
    }

    fn new(gpu: &Gpu, size: (u32, u32), texture_size: (u32, u32)) -> Self {
        let display = create(gpu, "display", DISPLAY, texture_size);
        Self {
            size,
            sums: Vec::new(),
            radiance_sums: Vec::new(),
            glow_sums: Vec::new(),
            tint_sums: Vec::new(),
            settling: None,
            display,
            is_drawn: false,
        }
    }

    /// Adds the textures that these means take beyond those that are there.
    fn with_means(&mut self, gpu: &Gpu, means_of: MeansOf, texture_size: (u32, u32)) {
        let [sums, radiance_sums, glow_sums] = means_of.counts();
        while self.sums.len() < sums {
            self.sums.push(create(gpu, "accumulate.sum", SUM, texture_size));
        }
        while self.radiance_sums.len() < radiance_sums {
            self.radiance_sums.push(create(gpu, "accumulate.radiance_sum", SUM, texture_size));
        }
        while self.glow_sums.len() < glow_sums {
            self.glow_sums.push(create(gpu, "accumulate.glow_sum", SUM, texture_size));
        }
    }

    /// Adds the textures for the mean of what comes through glass, as those for the first mean are.
    pub fn with_tint(&mut self, gpu: &Gpu) {
        let size = self.display.texture.size();
        while self.tint_sums.len() < self.sums.len() {
            self.tint_sums.push(create(gpu, "accumulate.tint_sum", SUM, (size.width, size.height)));
        }
    }

    /// The mean of what comes through glass in a graph, if there is any; `previous` is as for [`Self::means`].
    pub fn tint_mean(&self, graph: &mut Graph<'_>, means_of: MeansOf, previous: usize) -> Option<Mean> {
        let desc = TextureDesc::new_2d(self.size.0, self.size.1, SUM);
        if means_of == MeansOf::Nothing {
            return None;
        }
        let mut import =
            |name, index: usize| Some(graph.import(name, desc, self.tint_sums.get(index & 1)?.view.clone()));
        let before = if means_of.go_on() { import("accumulate.previous_tint", previous) } else { None };
        Some(Mean { previous: before, next: import("accumulate.tint_sum", 1 - (previous & 1))? })
    }

    /// Adds the textures that tell which tiles are settled.
    fn with_settling(&mut self, gpu: &Gpu, texture_size: (u32, u32)) {
        let make = |TextureDesc { format, width, height, .. }| create(gpu, "adaptive", format, (width, height));
        self.settling.get_or_insert_with(|| settling_descs(texture_size).map(make));
    }

    /// For a plan that is never run: the shapes of pictures of `size`, with next to no memory behind them.
    pub fn planned(gpu: &Gpu, size: (u32, u32), means_of: MeansOf, settles: bool) -> Self {
        let mut output = Self::new(gpu, size, (1, 1));
        output.with_means(gpu, means_of, (1, 1));
        if settles {
            output.with_settling(gpu, (1, 1));
        }
        output
    }

    /// The textures for pictures of `size`, with those for the means. Textures of other means stay until the size
    /// changes, so that one who shows single samples and refines them in turn makes none.
    pub fn of<'a>(
        gpu: &Gpu,
        slot: &'a mut Option<Self>,
        size: (u32, u32),
        means_of: MeansOf,
        settles: bool,
    ) -> &'a Self {
        if let Some(former) = slot.take_if(|output| output.size != size) {
            former.destroy();
        }
        let output = slot.get_or_insert_with(|| Self::new(gpu, size, size));
        output.with_means(gpu, means_of, size);
        if settles {
            output.with_settling(gpu, size);
        }
        output
    }

    /// Frees the textures at once. Browsers free what is only dropped when they collect garbage, so that a window that is
    /// resized would pile up the textures of every size it had.
    pub fn destroy(self) {
        self.textures().for_each(wgpu::Texture::destroy);
    }

    /// All of its textures.
    fn textures(&self) -> impl Iterator<Item = &wgpu::Texture> {
        let sums = [&self.sums, &self.radiance_sums, &self.glow_sums, &self.tint_sums].into_iter().flatten();
        sums.chain(self.settling.iter().flatten()).chain([&self.display]).map(|kept| &kept.texture)
    }

    /// What is kept of settled tiles, in a graph.
    pub fn settling(&self, graph: &mut Graph<'_>) -> Option<ConvergedTiles> {
        let [settled_desc, half_desc] = settling_descs(self.size);
        let [settled, half] = self.settling.as_ref()?;
        Some(ConvergedTiles {
            settled: graph.import("adaptive.settled", settled_desc, settled.view.clone()),
            half: graph.import("adaptive.half", half_desc, half.view.clone()),
        })
    }

    /// The means in a graph; `previous` of the two textures holds that of the samples so far.
    pub fn means(&self, graph: &mut Graph<'_>, means_of: MeansOf, previous: usize) -> Means {
        let desc = TextureDesc::new_2d(self.size.0, self.size.1, SUM);
        let mut mean = |sums: &[PersistentTexture], names: [&'static str; 2]| {
            let mut import = |name, index: usize| Some(graph.import(name, desc, sums.get(index & 1)?.view.clone()));
            let previous_mean = if means_of.go_on() { import(names[0], previous) } else { None };
            Some(Mean { previous: previous_mean, next: import(names[1], 1 - (previous & 1))? })
        };
        let first = mean(&self.sums, ["accumulate.previous", "accumulate.sum"]);
        match (means_of, first) {
            (MeansOf::Nothing, _) | (_, None) => Means::None,
            (MeansOf::OneSample | MeansOf::Radiance, Some(first)) => Means::Radiance(first),
            (MeansOf::Display, Some(first)) => Means::Display(first),
            (MeansOf::Both, Some(first)) => match mean(&self.radiance_sums, MEANS_OF_RADIANCE) {
                Some(second) => Means::Both([first, second]),
                None => Means::Display(first),
            },
            (MeansOf::Parts | MeansOf::PartsAndRadiance, Some(rest)) => {
                let is_read = means_of == MeansOf::PartsAndRadiance;
                let radiance = if is_read { mean(&self.radiance_sums, MEANS_OF_RADIANCE) } else { None };
                match mean(&self.glow_sums, ["accumulate.previous_glow", "accumulate.glow_sum"]) {
                    Some(glow) => Means::Parts { rest, glow, radiance },
                    None => Means::Radiance(rest),
                }
            }
        }
    }

    /// The picture in a graph.
    pub fn display(&self, graph: &mut Graph<'_>) -> Handle {
        graph.import("display", TextureDesc::new_2d(self.size.0, self.size.1, DISPLAY), self.display.view.clone())
    }
}

#[cfg(test)]
mod tests {
    use crate::aov::AovTextures;
    use crate::gpu::readback;
    use crate::{Aov, FrameRequest, Gpu, Ground, Renderer};

    /// Textures that a renderer keeps from frame to frame, by what they are for.
    fn held(renderer: &Renderer) -> Vec<(&'static str, wgpu::Texture)> {
        let state = &renderer.views[""];
        let shadows = renderer.shadows.atlas.iter().map(|atlas| ("shadows", atlas.view.texture()));
        let ground = renderer.ground.texture.iter().map(|view| ("ground", view.texture()));
        let picture = state.output.iter().map(|output| ("picture", &output.display.texture));
        let variables = state.aovs.iter().flat_map(AovTextures::all).map(|texture| ("variables", texture));
        let all = shadows.chain(ground).chain(picture).chain(variables);
        all.map(|(what, texture)| (what, texture.clone())).collect()
    }

    /// Whether the device refuses to read a texture.
    fn is_destroyed(gpu: &Gpu, texture: &wgpu::Texture) -> bool {
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let _ = pollster::block_on(readback::read_texture(gpu, texture));
        pollster::block_on(scope.pop()).is_some()
    }

    #[test]
    fn textures_of_former_sizes_are_destroyed_and_not_only_dropped() {
        let scene = manypass_testkit::scenes::sun().scene;
        let mut renderer = Renderer::new(Gpu::headless(None).unwrap()).unwrap();
        renderer.load(&scene).unwrap();
        let mut former = Vec::new();
        // The map of the ground is larger for the widest.
        for width in [40, 300, 1400, 40] {
            let mut request = FrameRequest::of_scene(&scene, width, 8);
            request.settings.ground.mode = Ground::Shadow;
            request.want_aovs = vec![Aov::Depth, Aov::ObjectId];
            renderer.render(&scene, &request).unwrap();
            former.extend(held(&renderer));
        }
        let held = held(&renderer);
        for (what, texture) in &held {
            assert!(!is_destroyed(renderer.gpu(), texture), "{what}: destroyed, and held all the same");
        }
        former.retain(|texture| !held.contains(texture));
        for what in ["shadows", "ground", "picture", "variables"] {
            assert!(former.iter().any(|(of, _)| *of == what), "{what}: none took the place of another");
        }
        for (what, texture) in &former {
            assert!(is_destroyed(renderer.gpu(), texture), "{what}: only dropped");
        }
        // Others go on with the device.
        let gpu = renderer.gpu().clone();
        renderer.destroy();
        for (what, texture) in &held {
            assert!(is_destroyed(&gpu, texture), "{what}: left on the device");
        }
    }
}
