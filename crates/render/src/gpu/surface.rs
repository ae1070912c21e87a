//! A device that can present to a surface of the caller's: a window's, of any windowing library.

use super::{Gpu, GpuError};

/// The formats of surfaces that pictures are drawn to, the best first: sRGB blends in linear light.
const FORMATS: [wgpu::TextureFormat; 4] = [
    wgpu::TextureFormat::Bgra8UnormSrgb,
    wgpu::TextureFormat::Rgba8UnormSrgb,
    wgpu::TextureFormat::Bgra8Unorm,
    wgpu::TextureFormat::Rgba8Unorm,
];

impl Gpu {
    /// A device that can present to `surface`, which `instance` made, and the surface's configuration for a size in
    /// pixels: a format that [`crate::Renderer::render_to`] draws to, frames in step with the display. Configure the
    /// surface with it, and again with the new size when the window changes. A hardware adapter is preferred.
    ///
    /// # Errors
    /// No adapter can present to the surface in 8 bits a channel, or it gives no device.
    ///
    /// ```no_run
    /// # fn begin(window: std::sync::Arc<winit::window::Window>) -> Result<(), Box<dyn std::error::Error>> {
    /// use manypass::{Gpu, Renderer, wgpu};
    ///
    /// let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    /// let surface = instance.create_surface(window)?;
    /// let (gpu, configuration) = Gpu::for_surface(&instance, &surface, (960, 540))?;
    /// surface.configure(&gpu.device, &configuration);
    /// let renderer = Renderer::new(gpu)?;
    /// # Ok(()) }
    /// ```
    pub fn for_surface(
        instance: &wgpu::Instance,
        surface: &wgpu::Surface<'_>,
        (width, height): (u32, u32),
    ) -> Result<(Self, wgpu::SurfaceConfiguration), GpuError> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(surface),
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(|_| GpuError::NoAdapter)?;
        let incapable =
            |missing: &str| GpuError::Incapable { adapter: adapter.get_info().name, missing: missing.into() };
        // A window that is minimised has no pixels, and no surface may have none.
        let configuration = surface.get_default_config(&adapter, width.max(1), height.max(1));
        let mut configuration = configuration.ok_or_else(|| incapable("it cannot present to the surface"))?;
        let known = surface.get_capabilities(&adapter).formats;
        let format = FORMATS.into_iter().find(|format| known.contains(format));
        configuration.format = format.ok_or_else(|| incapable("it presents in no format of 8 bits a channel"))?;
        configuration.present_mode = wgpu::PresentMode::AutoVsync;
        Ok((pollster::block_on(Self::from_adapter(&adapter))?, configuration))
    }
}
