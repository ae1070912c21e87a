//! What a mirror is.

use super::options::LAYERS_ALL;
use crate::NodeId;

/// A flat surface that reflects what is before it, off the picture and behind the eye, too.
///
/// What it reflects takes the place of the environment in what its material reflects: colour, roughness, normal map and
/// Fresnel are those of the material.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    /// Its name: in the names of passes.
    pub name: String,
    /// The node whose mesh is the mirror: a flat one.
    pub node: NodeId,
    /// Width and height of what is drawn for it, as a share of those of the picture that shows it.
    pub scale: f32,
    /// The layers that it shows ([`crate::Node::layers`]), a bit each.
    pub layers: u32,
    /// The tier of quality whose passes draw what it shows; none for that of the picture that shows it.
    pub quality: Option<String>,
}

impl Mirror {
    /// As fine as the picture that shows it, and drawn as that is.
    pub fn new(name: impl Into<String>, node: NodeId) -> Self {
        Self { name: name.into(), node, scale: 1.0, layers: LAYERS_ALL, quality: None }
    }
}
