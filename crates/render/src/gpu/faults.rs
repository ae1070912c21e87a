//! What went wrong on a device, which reports it when it likes: what it refused of frames, and all else.

use super::GpuError;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The first thing that went wrong on a device since it was last asked.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults(Arc<Mutex<FirstFaults>>);

/// The first of frames and the first of all else.
#[derive(Debug, Default)]
struct FirstFaults {
    /// A loss, or what was refused while no frame was recorded: while a scene was loaded, for instance.
    lasting: Option<GpuError>,
    /// What was refused of the frame.
    of_frame: Option<GpuError>,
    /// Whether a frame is recorded.
    is_frame: bool,
}

impl Faults {
    /// Whether `other` is of the same device.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    fn first(&self) -> MutexGuard<'_, FirstFaults> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, fault: GpuError) {
        let mut first = self.first();
        // A loss outweighs what led to it.
        if matches!(fault, GpuError::Lost(_)) {
            first.lasting = Some(fault);
            return;
        }
        let slot = if first.is_frame { &mut first.of_frame } else { &mut first.lasting };
        slot.get_or_insert(fault);
    }

    /// What went wrong since this was last called. It ends a frame.
    pub fn take(&self) -> Option<GpuError> {
        let FirstFaults { lasting, of_frame, .. } = std::mem::take(&mut *self.first());
        lasting.or(of_frame)
    }

    /// What is refused from now on is the frame's.
    pub fn begin_frame(&self) {
        self.first().is_frame = true;
    }

    /// Ends a frame that nobody asked about.
    pub fn end_frame(&self) {
        let mut first = self.first();
        first.is_frame = false;
        if let Some(fault) = first.of_frame.take() {
            first.lasting.get_or_insert(fault);
        }
    }

    /// Ends a frame and forgets what was refused of it.
    pub fn forget_frame(&self) {
        let mut first = self.first();
        (first.of_frame, first.is_frame) = (None, false);
    }

    /// Takes the place of wgpu's handlers, which panic.
    pub fn watch(&self, device: &wgpu::Device) {
        let refused = self.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            refused.put(match error {
                wgpu::Error::OutOfMemory { .. } => GpuError::Refused("the device ran out of memory".into()),
                error => GpuError::Refused(format!("the device refused a command: {error}")),
            });
        }));
        let lost = self.clone();
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                lost.put(GpuError::Lost(message));
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(what: &str) -> GpuError {
        GpuError::Refused(what.into())
    }

    fn said(faults: &Faults) -> Option<String> {
        faults.take().map(|fault| fault.to_string())
    }

    #[test]
    fn a_frame_forgets_what_was_refused_of_it_and_nothing_of_loading() {
        let faults = Faults::default();
        faults.put(refused("a texture"));
        faults.put(refused("another texture"));
        faults.begin_frame();
        faults.put(refused("a pass"));
        faults.forget_frame();
        assert_eq!(said(&faults).as_deref(), Some("a texture"));
        assert_eq!(said(&faults), None);
        faults.begin_frame();
        faults.put(refused("a pass"));
        assert_eq!(said(&faults).as_deref(), Some("a pass"));
        // To ask ends a frame.
        faults.put(refused("a mesh"));
        faults.forget_frame();
        assert_eq!(said(&faults).as_deref(), Some("a mesh"));
        // A plan ends, and forgets nothing.
        faults.begin_frame();
        faults.put(refused("a pass"));
        faults.end_frame();
        faults.put(refused("a mesh"));
        faults.forget_frame();
        assert_eq!(said(&faults).as_deref(), Some("a pass"));
    }

    #[test]
    fn a_loss_outweighs_all_else_and_is_not_forgotten() {
        let faults = Faults::default();
        faults.put(refused("a texture"));
        faults.begin_frame();
        faults.put(refused("a pass"));
        faults.put(GpuError::Lost("it is gone".into()));
        faults.forget_frame();
        assert_eq!(said(&faults).as_deref(), Some("the device was lost: it is gone"));
        assert_eq!(said(&faults), None);
    }
}
