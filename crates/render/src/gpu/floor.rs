//! Devices that draw nothing: on these the frame is planned for what every adapter of a kind offers.

use super::{Capabilities, Faults, Gpu, GpuError};
use crate::setting::choices;

choices! {
    /// What every adapter of a kind offers.
    pub enum Floor {
        /// The limits that every adapter of WebGPU has.
        #[default]
        WebGpu = "webgpu",
        /// The limits that every adapter of WebGL 2 has.
        WebGl2 = "webgl2",
    }
}

impl Floor {
    fn limits(self) -> wgpu::Limits {
        match self {
            Self::WebGpu => wgpu::Limits::default(),
            Self::WebGl2 => wgpu::Limits::downlevel_webgl2_defaults(),
        }
    }

    /// What every adapter of the kind can do, of one that says that it can do all.
    fn capabilities(self, all: Capabilities) -> Capabilities {
        match self {
            Self::WebGpu => all,
            Self::WebGl2 => Capabilities {
                anisotropy: false,
                uniforms_of_any_size: false,
                arrays_of_any_length: false,
                layers_deform: false,
                ..all
            },
        }
    }
}

impl Gpu {
    /// A device without an adapter: shaders, pipelines and the frame's graph are checked and planned against `floor`,
    /// and nothing is drawn. [`crate::Renderer::plan`] is what it is for; what is read of pictures is not theirs.
    ///
    /// # Errors
    /// The frame does not fit the floor.
    pub fn without_adapter(floor: Floor) -> Result<Self, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::NOOP;
        descriptor.backend_options.noop = wgpu::NoopBackendOptions::enabled();
        let instance = wgpu::Instance::new(descriptor);
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::NOOP));
        let adapter = adapters.first().ok_or(GpuError::NoAdapter)?;
        let descriptor =
            wgpu::DeviceDescriptor { label: Some("manypass"), required_limits: floor.limits(), ..Default::default() };
        let device = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = device.map_err(|error| GpuError::Device(error.to_string()))?;
        // This adapter knows nothing of formats. Those of the frame are among what the kind guarantees.
        let capabilities = floor.capabilities(Capabilities::of_device(adapter, &device));
        let faults = Faults::default();
        faults.watch(&device);
        Ok(Self { device, queue, capabilities, adapter: adapter.get_info().into(), faults })
    }
}
