//! What a portal is: its two ends, and what goes through.

use crate::NodeId;
use crate::capture::LAYERS_ALL;

/// Two flat places of which each shows what the other one faces.
///
/// Whoever looks into the front of one looks out of the front of the other. The meshes of the two nodes say where they are,
/// and are not drawn themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// Its name: in the names of passes.
    pub name: String,
    /// The nodes of its two ends: flat ones.
    pub nodes: [NodeId; 2],
    /// Width and height of what is drawn for it, as a share of those of the picture that shows it.
    pub scale: f32,
    /// The layers that are seen through it ([`crate::Node::layers`]), a bit each.
    pub layers: u32,
    /// The tier of quality whose passes draw what is seen through it; none for that of the picture that shows it.
    pub quality: Option<String>,
    /// What goes through it, and what stands for that at the other end.
    pub carried: Vec<PortalTraveller>,
}

/// A node that goes through a portal, and what stands for it where it comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortalTraveller {
    /// The node.
    pub node: NodeId,
    /// A node that has the same mesh and light. It is visible while the first one is half through, or shines in.
    pub image: NodeId,
    /// The end that the node goes into: an index into [`Portal::nodes`].
    pub end: usize,
}

impl Portal {
    /// As fine as the picture that shows it, and drawn as that is; nothing goes through.
    pub fn new(name: impl Into<String>, nodes: [NodeId; 2]) -> Self {
        Self { name: name.into(), nodes, scale: 1.0, layers: LAYERS_ALL, quality: None, carried: Vec::new() }
    }
}
