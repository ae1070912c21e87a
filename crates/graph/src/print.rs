//! A plan as text, JSON and Mermaid.

use std::fmt::Write as _;

use crate::plan::{Load, Plan, PlannedAttachment, PlannedRead, Target};
use crate::subresource::SubresourceRange;

impl Plan {
    /// One line a pass and a texture, for people and for snapshots.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        self.write_text(&mut text).expect("writing to a string succeeds");
        text
    }

    fn write_text(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "{} passes in {} render passes", self.passes.len(), self.render_passes)?;
        for (index, pass) in self.passes.iter().enumerate() {
            let merged = index > 0 && self.passes[index - 1].group == pass.group;
            let mark = if merged { " (merged)" } else { "" };
            let (width, height) = pass.size;
            writeln!(text, "  {}  {width}x{height}{mark}", pass.name)?;
            for attachment in &pass.attachments {
                let target = match attachment.target {
                    Target::Color(slot) => format!("color {slot}"),
                    Target::DepthStencil => "depth".to_owned(),
                    Target::DepthReadOnly => "depth read-only".to_owned(),
                    Target::Resolve(slot) => format!("mean of color {slot}"),
                };
                write!(text, "    {target}: {}", self.attachment_name(attachment))?;
                if attachment.target == Target::DepthReadOnly {
                    writeln!(text)?;
                    continue;
                }
                let load = match attachment.load {
                    Load::Clear => "clear",
                    Load::Keep => "keep",
                    Load::Discard => "discard",
                };
                let store = if attachment.store { "store" } else { "drop" };
                writeln!(text, ", {load}, {store}")?;
            }
            for read in &pass.reads {
                writeln!(text, "    read: {}", self.read_name(read))?;
            }
        }
        writeln!(text, "{} textures", self.textures.len())?;
        for texture in &self.textures {
            let desc = &texture.desc;
            write!(text, "  {}  {}x{} {:?}", texture.name, desc.width, desc.height, desc.format)?;
            for (count, unit) in [(desc.layers, "layers"), (desc.mips, "mips"), (desc.samples, "samples")] {
                if count > 1 {
                    write!(text, " {count} {unit}")?;
                }
            }
            match texture.slot {
                Some(slot) => write!(text, ", slot {slot}")?,
                None => write!(text, ", imported")?,
            }
            write!(text, ", {}..={}", texture.first, texture.last)?;
            let exported = if texture.exported { ", exported" } else { "" };
            let memoryless = if texture.memoryless { ", memoryless" } else { "" };
            writeln!(text, "{exported}{memoryless}")?;
        }
        let bytes = self.bytes();
        write!(text, "bytes: {} aliased of {}, {} imported", bytes.aliased, bytes.unaliased, bytes.imported)?;
        if bytes.memoryless > 0 {
            write!(text, ", {} of the aliased memoryless", bytes.memoryless)?;
        }
        writeln!(text)?;
        if !self.culled.is_empty() {
            writeln!(text, "culled: {}", self.culled.join(", "))?;
        }
        Ok(())
    }

    /// The plan as indented JSON, with its bytes.
    pub fn to_json(&self) -> String {
        let value = serde_json::json!({ "plan": self, "bytes": self.bytes() });
        format!("{value:#}")
    }

    /// A Mermaid flow chart: passes are boxes, textures are rounded.
    pub fn to_mermaid(&self) -> String {
        let mut text = String::new();
        self.write_mermaid(&mut text).expect("writing to a string succeeds");
        text
    }

    fn write_mermaid(&self, text: &mut String) -> std::fmt::Result {
        let label = |name: &str| name.replace('"', "#quot;");
        writeln!(text, "flowchart LR")?;
        for (index, pass) in self.passes.iter().enumerate() {
            writeln!(text, "  p{index}[\"{}\"]", label(&pass.name))?;
        }
        for (index, texture) in self.textures.iter().enumerate() {
            writeln!(text, "  t{index}([\"{}\"])", label(&texture.name))?;
        }
        for (index, pass) in self.passes.iter().enumerate() {
            for attachment in &pass.attachments {
                let texture = attachment.texture;
                if attachment.load == Load::Keep {
                    writeln!(text, "  t{texture} --> p{index}")?;
                }
                if attachment.target != Target::DepthReadOnly {
                    writeln!(text, "  p{index} --> t{texture}")?;
                }
            }
            for read in &pass.reads {
                writeln!(text, "  t{} --> p{index}", read.texture)?;
            }
        }
        Ok(())
    }

    /// The name of the texture or view that is attached.
    pub(crate) fn attachment_name(&self, attachment: &PlannedAttachment) -> String {
        let texture = &self.textures[attachment.texture as usize];
        let part = SubresourceRange { mip: attachment.mip, mips: 1, layer: attachment.layer, layers: 1 };
        format!("{}{}", texture.name, part.suffix(&texture.desc))
    }

    fn read_name(&self, read: &PlannedRead) -> String {
        let texture = &self.textures[read.texture as usize];
        let suffix = read.view.map_or_else(String::new, |part| part.suffix(&texture.desc));
        format!("{}{suffix}", texture.name)
    }
}
