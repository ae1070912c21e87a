//! Bind groups, kept as long as frames bind the same things.

use super::uniforms::Uniform;
use crate::shader::Program;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;

/// What so many frames did without is given back, be it a bind group or a bundle, and with it the textures that it
/// holds. Two suffice for what alternates, such as the two textures of a mean.
pub(super) const KEPT_FRAMES: u64 = 4;

/// Something that a shader binds.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Resource {
    Uniform(Uniform),
    Texture(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Resource {
    fn binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Uniform(Uniform { buffer, offset, size }) => {
                let size = wgpu::BufferSize::new(*size);
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: *offset, size })
            }
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
        }
    }
}

#[derive(Debug, PartialEq, Eq, Hash)]
struct Key {
    layout: wgpu::BindGroupLayout,
    resources: Vec<Resource>,
}

/// Bind groups by their layout and what they bind.
#[derive(Debug, Default)]
pub(crate) struct BindGroups {
    /// With the frame that used each last.
    groups: RefCell<HashMap<Key, (wgpu::BindGroup, u64)>>,
    frame: Cell<u64>,
    made: Cell<u64>,
}

impl BindGroups {
    /// Begins a frame: forgets what the last ones did without.
    pub fn begin(&self) {
        let frame = self.frame.get() + 1;
        self.frame.set(frame);
        self.made.set(0);
        self.groups.borrow_mut().retain(|_, (_, last)| *last + KEPT_FRAMES >= frame);
    }

    /// Forgets all, with the textures that they hold.
    pub fn clear(&self) {
        self.groups.borrow_mut().clear();
    }

    /// Forgets those that the frame did without, with the textures that they hold.
    pub fn forget_unused(&self) {
        let frame = self.frame.get();
        self.groups.borrow_mut().retain(|_, (_, last)| *last == frame);
    }

    /// How many were made since the frame began.
    pub fn made(&self) -> u64 {
        self.made.get()
    }

    /// The group `group` of `program` with `resources`, one for each of its slots, in their order.
    pub fn of_program(
        &self,
        device: &wgpu::Device,
        program: &Program,
        group: u32,
        resources: Vec<Resource>,
    ) -> Option<wgpu::BindGroup> {
        let bindings: Vec<u32> = program.slots(group).iter().map(|slot| slot.entry.binding).collect();
        let layout = program.group_layout(group)?;
        Some(self.get(device, &program.name, layout, &bindings, resources))
    }

    /// The group of `layout` that binds `resources` to `bindings`.
    pub fn get(
        &self,
        device: &wgpu::Device,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        bindings: &[u32],
        resources: Vec<Resource>,
    ) -> wgpu::BindGroup {
        let key = Key { layout: layout.clone(), resources };
        let mut groups = self.groups.borrow_mut();
        if let Some((group, last)) = groups.get_mut(&key) {
            *last = self.frame.get();
            return group.clone();
        }
        let entries: Vec<_> = bindings
            .iter()
            .zip(&key.resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.binding() })
            .collect();
        let descriptor = wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries };
        let group = device.create_bind_group(&descriptor);
        self.made.set(self.made.get() + 1);
        drop(entries);
        groups.insert(key, (group.clone(), self.frame.get()));
        group
    }
}
