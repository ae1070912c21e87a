//! The device: how it is found, what it can do, and how pixels come back from it.

pub mod capabilities;
pub(crate) mod changes;
pub mod data_texture;
mod faults;
#[cfg(not(target_arch = "wasm32"))]
mod floor;
pub mod readback;
#[cfg(not(target_arch = "wasm32"))]
mod surface;

pub use capabilities::{Capabilities, block_format};
#[cfg(not(target_arch = "wasm32"))]
pub use floor::Floor;

use faults::Faults;

/// The error of a device that could not be created or was lost.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter at all.
    #[error(
        "no usable graphics adapter was found; on Debian and Ubuntu the package mesa-vulkan-drivers brings a software adapter"
    )]
    NoAdapter,
    /// No adapter has the name that was asked for.
    #[error("no adapter is called `{name}`; there are: {known}")]
    UnknownAdapter {
        /// The name that was asked for.
        name: String,
        /// The adapters there are, separated by commas.
        known: String,
    },
    /// The adapter lacks something that the frame cannot do without.
    #[error("the adapter `{adapter}` cannot be used: {missing}")]
    Incapable {
        /// The adapter.
        adapter: String,
        /// What it lacks.
        missing: String,
    },
    /// The adapter gave no device.
    #[error("the adapter gave no device: {0}")]
    Device(String),
    /// The device went away.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// The program has no memory left for pixels.
    #[error("there is no memory left for {bytes} bytes of pixels")]
    Memory {
        /// What was asked for.
        bytes: u64,
    },
    /// The device refused what it was told to do, or ran out of memory.
    #[error("{0}")]
    Refused(String),
}

/// Frees the texture of `view`, which no frame uses any more and no commands that are still to be submitted. To drop it
/// is not enough: browsers free what was dropped when they collect garbage, which textures do not hasten.
pub(crate) fn destroy(view: &wgpu::TextureView) {
    view.texture().destroy();
}

/// The description of an adapter for users.
#[derive(Clone, Debug, serde::Serialize)]
#[non_exhaustive]
pub struct AdapterSummary {
    /// The device's name.
    pub name: String,
    /// Vulkan, Metal, Dx12, WebGPU or OpenGL.
    pub backend: String,
    /// Discrete, integrated, virtual or software.
    pub device_type: String,
    /// The driver's name and version.
    pub driver: String,
}

impl From<wgpu::AdapterInfo> for AdapterSummary {
    fn from(info: wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name,
            backend: match info.backend {
                wgpu::Backend::BrowserWebGpu => "WebGPU".into(),
                wgpu::Backend::Gl => "OpenGL".into(),
                other => format!("{other:?}"),
            },
            device_type: match info.device_type {
                wgpu::DeviceType::Cpu => "Software".into(),
                other => format!("{other:?}"),
            },
            driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
        }
    }
}

/// A device with its queue and capabilities.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What it can do.
    pub capabilities: Capabilities,
    /// The adapter it came from.
    pub adapter: AdapterSummary,
    faults: Faults,
}

impl Gpu {
    /// Shares the caller's device and queue. The adapter tells what the device can do. Errors of the device go to the
    /// caller's handler.
    ///
    /// # Errors
    /// An adapter that cannot render to floating-point targets.
    pub fn from_device(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, GpuError> {
        let capabilities = Capabilities::of(adapter, &device)?;
        Ok(Self { device, queue, capabilities, adapter: adapter.get_info().into(), faults: Faults::default() })
    }

    /// Asks `adapter` for a device with everything the frame can use.
    ///
    /// # Errors
    /// An adapter that lacks what the frame needs, or gives no device.
    pub async fn from_adapter(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let wanted = wgpu::Features::DEPTH32FLOAT_STENCIL8
            | wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::FLOAT32_BLENDABLE
            | wgpu::Features::FLOAT32_FILTERABLE
            | wgpu::Features::TEXTURE_COMPRESSION_BC
            | wgpu::Features::TEXTURE_COMPRESSION_ASTC
            | wgpu::Features::TEXTURE_COMPRESSION_ETC2;
        // The memory of a software adapter is the process's own, in which blocks of 256 MiB for a few small buffers are
        // too much.
        let is_software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let memory_hints = if is_software { wgpu::MemoryHints::MemoryUsage } else { wgpu::MemoryHints::Performance };
        let descriptor = wgpu::DeviceDescriptor {
            memory_hints,
            label: Some("manypass"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) =
            adapter.request_device(&descriptor).await.map_err(|error| GpuError::Device(error.to_string()))?;
        let gpu = Self::from_device(adapter, device, queue)?;
        gpu.faults.watch(&gpu.device);
        Ok(gpu)
    }

    /// Whether `other` is this one or a clone of it. Devices of different instances have equal ids in wgpu, so that
    /// comparing devices tells nothing.
    pub fn is_same(&self, other: &Self) -> bool {
        self.faults.is_same(&other.faults)
    }

    /// Whether the device refused anything, or was lost, since this was last called.
    ///
    /// # Errors
    /// If so.
    pub fn check(&self) -> Result<(), GpuError> {
        self.faults.take().map_or(Ok(()), Err)
    }

    /// Says that the scene is on the device: what it refuses from now on is the frame's. [`Self::check`] ends the frame.
    pub(crate) fn begin_frame(&self) {
        self.faults.begin_frame();
    }

    /// Ends a frame that is not run.
    pub(crate) fn end_frame(&self) {
        self.faults.end_frame();
    }

    /// Forgets what the device refused since [`Self::begin_frame`], for a frame that failed of something else, so that
    /// the next one is not blamed for it. What was refused before, while a scene was loaded, is kept. A device that is
    /// lost stays so.
    pub(crate) fn forget_frame(&self) {
        self.faults.forget_frame();
    }

    /// A device without a window. Without a name a hardware adapter is preferred to a software one.
    ///
    /// # Errors
    /// No adapter, no adapter of that name, or no device.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn headless(name: Option<&str>) -> Result<Self, GpuError> {
        let adapters = enumerate();
        let rank = |adapter: &wgpu::Adapter| match adapter.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        };
        let adapter = match name {
            None => adapters.iter().min_by_key(|adapter| rank(adapter)).ok_or(GpuError::NoAdapter)?,
            Some(_) if adapters.is_empty() => return Err(GpuError::NoAdapter),
            Some(name) => adapters
                .iter()
                .find(|adapter| adapter.get_info().name.to_lowercase().contains(&name.to_lowercase()))
                .ok_or_else(|| GpuError::UnknownAdapter {
                    name: name.into(),
                    known: adapters.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", "),
                })?,
        };
        pollster::block_on(Self::from_adapter(adapter))
    }

    /// All adapters of this machine.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn adapters() -> Vec<AdapterSummary> {
        enumerate().into_iter().map(|adapter| adapter.get_info().into()).collect()
    }

    /// Waits until the device has done all that was submitted.
    pub fn wait(&self) {
        // A device that is lost has nothing left to wait for; the next call on it reports the loss.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
    }
}

impl Gpu {
    /// Waits asynchronously until the device has done all that was submitted, and returns when that was. WebGL tells it
    /// only on request, which browsers make every few milliseconds.
    ///
    /// # Errors
    /// The device was lost.
    pub async fn done(&self) -> Result<web_time::Instant, GpuError> {
        readback::done(self).await
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn enumerate() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}
