//! Declaring a frame: textures, passes, and who reads and writes what.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::execute::PassContext;
use crate::pool::HistoryBook;
use crate::subresource::SubresourceRange;
use crate::{Limits, Plan, PlanError, TextureDesc};

/// One version of a texture, or of some mips and layers of it.
///
/// Neither `Clone` nor `Copy`: writing consumes a handle and returns the next
/// version.
#[derive(Debug)]
pub struct Handle {
    pub(crate) graph: u32,
    pub(crate) texture: u32,
    pub(crate) part: SubresourceRange,
    name: Cow<'static, str>,
    desc: TextureDesc,
}

impl Handle {
    /// The texture's name; a view of some mips or layers appends `.mip2`, `.mips1-3`, `.layer1`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The shape of what this handle stands for: of a view, with its first mip as mip 0.
    pub fn desc(&self) -> TextureDesc {
        self.desc
    }
}

/// Fetches what a frame exported, after its run ([`crate::Run::exported`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Export {
    pub(crate) graph: u32,
    pub(crate) index: u32,
}

/// A texture that passes from frame to frame (ping-pong).
#[derive(Debug)]
pub struct History {
    /// What the last frame wrote as [`History::next`]; zeros if there was none.
    pub previous: Handle,
    /// What this frame writes: its writers run as if it were exported. If none writes it, the next frame finds what
    /// this one found.
    pub next: Handle,
    /// Whether there is no earlier frame of this name and shape.
    pub is_first: bool,
}

/// Fetches a view of a declared read while the pass runs
/// ([`PassContext::view`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadKey {
    pub(crate) graph: u32,
    pub(crate) use_index: u32,
}

/// What a colour target holds when its pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorLoad {
    /// One colour everywhere.
    Clear(wgpu::Color),
    /// What earlier passes wrote.
    Keep,
    /// Anything: the pass overwrites every texel that is looked at later. (Executed as a clear, which on GPUs costs
    /// nothing and cannot show stale memory; on software adapters, where it does cost, the texture is left as it is.)
    Discard,
}

/// What a depth-stencil target holds when its pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthLoad {
    /// One value everywhere.
    Clear {
        /// Depth, 0 to 1. With reversed depth the far plane is 0.
        depth: f32,
        /// Stencil; ignored by formats without one.
        stencil: u32,
    },
    /// What earlier passes wrote.
    Keep,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum UseKind {
    Color(ColorLoad),
    DepthStencil(DepthLoad),
    DepthReadOnly,
    /// What the samples of the colour target before it become.
    Resolve,
    Sampled {
        dimension: Option<wgpu::TextureViewDimension>,
        depth_only: bool,
    },
}

impl UseKind {
    pub(crate) fn is_write(self) -> bool {
        matches!(self, Self::Color(_) | Self::DepthStencil(_) | Self::Resolve)
    }

    pub(crate) fn is_attachment(self) -> bool {
        !matches!(self, Self::Sampled { .. })
    }

    /// Whether the pass needs what was there before.
    pub(crate) fn needs_contents(self) -> bool {
        matches!(
            self,
            Self::Color(ColorLoad::Keep)
                | Self::DepthStencil(DepthLoad::Keep)
                | Self::DepthReadOnly
                | Self::Sampled { .. }
        )
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Use {
    pub(crate) texture: u32,
    pub(crate) part: SubresourceRange,
    pub(crate) kind: UseKind,
}

pub(crate) struct TextureNode {
    pub(crate) name: Cow<'static, str>,
    pub(crate) desc: TextureDesc,
    pub(crate) source: Source,
}

impl TextureNode {
    /// Whether it outlives the frame: it has contents, and what is written to it is stored.
    pub(crate) fn is_persistent(&self) -> bool {
        !matches!(self.source, Source::Transient)
    }
}

/// Where the memory of a texture comes from.
pub(crate) enum Source {
    /// The pool, for as long as the frame needs it.
    Transient,
    /// The caller.
    Import(wgpu::TextureView),
    /// One of the two textures of a history, an index into [`Graph::histories`].
    History { index: u32, is_next: bool },
    /// As if it were imported, for tests, which have no device to make views with.
    #[cfg(test)]
    Fake,
}

/// A history that the frame uses.
pub(crate) struct HistoryNode {
    pub(crate) name: Cow<'static, str>,
    pub(crate) desc: TextureDesc,
}

pub(crate) type RunFn<'frame> = Box<dyn FnOnce(&mut PassContext<'_, '_>) + 'frame>;

pub(crate) struct PassNode<'frame> {
    pub(crate) name: Cow<'static, str>,
    pub(crate) uses: Range<u32>,
    pub(crate) side_effect: bool,
    /// Draw calls, where somebody has counted them.
    pub(crate) draws: Option<u32>,
    pub(crate) run: Option<RunFn<'frame>>,
}

/// The passes and textures of one frame. Built anew every frame.
pub struct Graph<'frame> {
    pub(crate) id: u32,
    pub(crate) limits: Limits,
    pub(crate) textures: Vec<TextureNode>,
    pub(crate) passes: Vec<PassNode<'frame>>,
    /// The uses of all passes in one list: a pass owns a range of it, so that
    /// declaring a pass allocates only its closure.
    pub(crate) uses: Vec<Use>,
    pub(crate) exports: Vec<(u32, SubresourceRange)>,
    pub(crate) histories: Vec<HistoryNode>,
    /// The histories that earlier frames have written.
    known_histories: Arc<HistoryBook>,
    /// Precedes every name that is declared.
    view: Cow<'static, str>,
    /// The first mistake that could be seen while declaring.
    misuse: Option<PlanError>,
}

impl<'frame> Graph<'frame> {
    /// An empty frame for an adapter with these limits, in which every history is new. A frame that is to be run comes
    /// from [`crate::Executor::graph`], which knows what earlier frames have left.
    pub fn new(limits: Limits) -> Self {
        Self::with_histories(limits, Arc::default())
    }

    pub(crate) fn with_histories(limits: Limits, known_histories: Arc<HistoryBook>) -> Self {
        static NEXT_ID: AtomicU32 = AtomicU32::new(0);
        Self {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            limits,
            textures: Vec::with_capacity(64),
            passes: Vec::with_capacity(64),
            uses: Vec::with_capacity(256),
            exports: Vec::new(),
            histories: Vec::new(),
            known_histories,
            view: Cow::Borrowed(""),
            misuse: None,
        }
    }

    /// Names the view whose passes are declared from here on: `mirror` makes `mirror/geometry` of `geometry`, in
    /// passes, textures and histories alike. An empty name, as at first, changes nothing.
    pub fn set_view(&mut self, name: impl Into<Cow<'static, str>>) {
        self.view = name.into();
    }

    fn named(&self, name: Cow<'static, str>) -> Cow<'static, str> {
        if self.view.is_empty() { name } else { Cow::Owned(format!("{}/{name}", self.view)) }
    }

    /// A texture that lives within the frame. Its contents are undefined until a
    /// pass writes it, and it may share memory with others.
    pub fn texture(&mut self, name: impl Into<Cow<'static, str>>, desc: TextureDesc) -> Handle {
        self.add_texture(name.into(), desc, Source::Transient)
    }

    /// A texture that outlives the frame: it has contents, shares no memory, and
    /// what is written to it is stored.
    ///
    /// `view` covers what `desc` describes and begins at mip 0 and layer 0. A pass
    /// that writes it runs only if something reads the result, or if the last
    /// version is given to [`Graph::export`].
    pub fn import(&mut self, name: impl Into<Cow<'static, str>>, desc: TextureDesc, view: wgpu::TextureView) -> Handle {
        self.add_texture(name.into(), desc, Source::Import(view))
    }

    /// What the last frame left under this name (and the name of the view), and what this frame leaves for the next.
    /// Another shape than the last frame's begins anew. One frame asks for a name once.
    pub fn history(&mut self, name: impl Into<Cow<'static, str>>, desc: TextureDesc) -> History {
        let name = name.into();
        let full = self.named(name.clone());
        if self.histories.iter().any(|known| known.name == full) {
            self.note_misuse(PlanError::HistoryTwice { history: full.to_string() });
        }
        let is_first = self.known_histories.get(&full) != Some(&desc);
        let index = self.histories.len() as u32;
        self.histories.push(HistoryNode { name: full, desc });
        let mut handle = |which: &str, is_next| {
            self.add_texture(format!("{name}.{which}").into(), desc, Source::History { index, is_next })
        };
        History { previous: handle("previous", false), next: handle("next", true), is_first }
    }

    pub(crate) fn add_texture(&mut self, name: Cow<'static, str>, desc: TextureDesc, source: Source) -> Handle {
        let name = self.named(name);
        let texture = self.textures.len() as u32;
        self.textures.push(TextureNode { name: name.clone(), desc, source });
        Handle { graph: self.id, texture, part: SubresourceRange::whole(&desc), name, desc }
    }

    /// One mip of one layer as a handle of its own; see [`Graph::subresources`].
    pub fn subview(&mut self, handle: &Handle, mip: u32, layer: u32) -> Handle {
        self.subresources(handle, mip..mip.saturating_add(1), layer..layer.saturating_add(1))
    }

    /// Some mips of some layers as a handle of its own, to write (one mip of one layer) or to read, counted from the
    /// first mip and layer of `handle`. Reading the whole texture later sees what was written through its views;
    /// whether a pass reads what it writes is checked for every mip and layer: mip m of one face may be drawn while
    /// mip m − 1 of all faces is sampled.
    ///
    /// A range that is empty, or reaches beyond `handle`, is an error of [`Graph::plan`].
    pub fn subresources(&mut self, handle: &Handle, mips: Range<u32>, layers: Range<u32>) -> Handle {
        let part = handle.part.inner(&mips, &layers).unwrap_or_else(|| {
            self.note_misuse(PlanError::NoSuchView {
                texture: handle.name.to_string(),
                mips: mips.clone(),
                layers: layers.clone(),
                mip_count: handle.desc.mips,
                layer_count: handle.desc.layers,
            });
            handle.part
        });
        let is_own = handle.graph == self.id;
        if !is_own {
            let texture = handle.name.to_string();
            self.note_misuse(PlanError::ForeignHandle { pass: "a view".to_owned(), texture });
        }
        let known = self.textures.get(handle.texture as usize).filter(|_| is_own);
        let whole = known.map_or(handle.desc, |texture| texture.desc);
        // A view is the one declaration that allocates its name.
        let base = known.map_or("", |texture| &texture.name);
        Handle {
            graph: handle.graph,
            texture: handle.texture,
            part,
            name: Cow::Owned(format!("{base}{}", part.suffix(&whole))),
            desc: part.desc(&whole),
        }
    }

    /// Opens the declaration of a pass. Its name is its debug label, its timer and
    /// its key in reports: `occlusion.blur`, folder then step.
    pub fn pass(&mut self, name: impl Into<Cow<'static, str>>) -> Pass<'_, 'frame> {
        let first_use = self.uses.len() as u32;
        let name = self.named(name.into());
        self.passes.push(PassNode { name, uses: first_use..first_use, side_effect: false, draws: None, run: None });
        Pass { graph: self }
    }

    /// Makes this version a result of the frame: its writers run and it is stored.
    pub fn export(&mut self, handle: Handle) -> Export {
        let export = Export { graph: self.id, index: self.exports.len() as u32 };
        if handle.graph == self.id {
            self.exports.push((handle.texture, handle.part));
        } else {
            self.note_misuse(PlanError::ForeignHandle { pass: "export".to_owned(), texture: handle.name.into_owned() });
        }
        export
    }

    /// Checks the declarations and works out how to execute them. Needs no device.
    ///
    /// # Errors
    /// The first contradiction in declaration order, naming the passes involved
    /// and what to change.
    pub fn plan(&self) -> Result<Plan, PlanError> {
        if let Some(misuse) = &self.misuse {
            return Err(misuse.clone());
        }
        crate::check::check(self)?;
        Ok(crate::plan::plan(self))
    }

    fn note_misuse(&mut self, error: PlanError) {
        self.misuse.get_or_insert(error);
    }
}

/// A pass while it is being declared.
///
/// A pass without [`Pass::draw`] still clears its attachments.
pub struct Pass<'graph, 'frame> {
    graph: &'graph mut Graph<'frame>,
}

impl<'frame> Pass<'_, 'frame> {
    /// Writes a colour target; the slot is the order of the calls. Returns the
    /// version that holds the result.
    pub fn color(&mut self, handle: Handle, load: ColorLoad) -> Handle {
        self.add_use(&handle, UseKind::Color(load));
        handle
    }

    /// Writes the mean of the samples of the colour target that was declared last, which has several a texel, to
    /// `handle`, which has the same shape and one. Returns the version that holds the mean.
    pub fn resolve(&mut self, handle: Handle) -> Handle {
        self.add_use(&handle, UseKind::Resolve);
        handle
    }

    /// Writes the depth-stencil target. Returns the version that holds the result.
    pub fn depth_stencil(&mut self, handle: Handle, load: DepthLoad) -> Handle {
        self.add_use(&handle, UseKind::DepthStencil(load));
        handle
    }

    /// Tests against a depth-stencil target without writing it. Its depth can be sampled in the same pass where
    /// [`Limits::samples_attached_depth`] says so (WebGL 2 forbids that even read-only).
    pub fn depth_stencil_read_only(&mut self, handle: &Handle) {
        self.add_use(handle, UseKind::DepthReadOnly);
    }

    /// Samples a texture: the mips of `handle`, and all of its layers, as `D2`, or `D2Array` if it has layers. To
    /// sample one layer of several is refused, because WebGL 2 shows another one.
    pub fn read(&mut self, handle: &Handle) -> ReadKey {
        self.add_use(handle, UseKind::Sampled { dimension: None, depth_only: false })
    }

    /// Samples a texture through a view of another dimension, such as `Cube`.
    pub fn read_as(&mut self, handle: &Handle, dimension: wgpu::TextureViewDimension) -> ReadKey {
        self.add_use(handle, UseKind::Sampled { dimension: Some(dimension), depth_only: false })
    }

    /// Samples the depth of a depth or depth-stencil texture.
    pub fn read_depth(&mut self, handle: &Handle) -> ReadKey {
        self.add_use(handle, UseKind::Sampled { dimension: None, depth_only: true })
    }

    /// [`Pass::read`] of something that may be absent.
    pub fn read_optional(&mut self, handle: Option<&Handle>) -> Option<ReadKey> {
        handle.map(|handle| self.read(handle))
    }

    /// Runs the pass even if nothing reads what it writes.
    pub fn side_effect(&mut self) {
        if let Some(pass) = self.graph.passes.last_mut() {
            pass.side_effect = true;
        }
    }

    /// Says how many draw calls the pass records, for [`crate::PlannedPass::draws`].
    pub fn count_draws(&mut self, draws: usize) {
        if let Some(pass) = self.graph.passes.last_mut() {
            pass.draws = Some(u32::try_from(draws).unwrap_or(u32::MAX));
        }
    }

    /// Ends the declaration with what to record when the pass runs. It is not
    /// called if the pass is culled.
    pub fn draw(self, run: impl FnOnce(&mut PassContext<'_, '_>) + 'frame) {
        if let Some(pass) = self.graph.passes.last_mut() {
            pass.run = Some(Box::new(run));
        }
    }

    fn add_use(&mut self, handle: &Handle, kind: UseKind) -> ReadKey {
        let graph = &mut *self.graph;
        let use_index = graph.uses.len() as u32;
        let read = ReadKey { graph: graph.id, use_index };
        if handle.graph != graph.id {
            let pass = graph.passes.last().map(|pass| pass.name.to_string());
            graph.note_misuse(PlanError::ForeignHandle {
                pass: pass.unwrap_or_default(),
                texture: handle.name.to_string(),
            });
            return read;
        }
        graph.uses.push(Use { texture: handle.texture, part: handle.part, kind });
        if let Some(pass) = graph.passes.last_mut() {
            pass.uses.end = use_index + 1;
        }
        read
    }
}
