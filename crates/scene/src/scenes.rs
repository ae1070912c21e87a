//! The scenes of a file, of which one is shown.

mod roots;

pub use roots::SceneRoots;

use crate::{Levels, Scene};

/// The most primitives, counted once for every node that shows them, that a scene may draw: a million. A few bytes of
/// JSON can ask for the product of two long lists.
pub const MAX_DRAWN_PRIMITIVES: usize = 1 << 20;

/// The error of a scene that cannot be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShowError {
    /// The file has no such scene.
    #[error("there is no scene {index}; the file has {count}")]
    Unknown {
        /// What was asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// It draws too much.
    #[error("the nodes of scene {index} draw {count} primitives together, and {MAX_DRAWN_PRIMITIVES} are possible")]
    TooLarge {
        /// What was asked for.
        index: usize,
        /// What it draws.
        count: usize,
    },
}

impl Scene {
    /// Shows another of the file's [`Scene::scenes`], by its index, and brings its transforms up to date.
    ///
    /// # Errors
    /// If there is no such scene, or it draws more than [`MAX_DRAWN_PRIMITIVES`]; the one before stays then.
    pub fn show_scene(&mut self, index: usize) -> Result<(), ShowError> {
        let count = self.scenes.len();
        let shown = self.scenes.get(index).ok_or(ShowError::Unknown { index, count })?;
        let before = std::mem::replace(&mut self.roots, shown.roots.clone());
        let count = self.drawn_primitives();
        if count > MAX_DRAWN_PRIMITIVES {
            self.roots = before;
            return Err(ShowError::TooLarge { index, count });
        }
        self.shown_scene = Some(index);
        self.update_transforms();
        Ok(())
    }

    /// The index in [`Scene::scenes`] of the scene with this name, or else with this index.
    pub fn scene_named(&self, name_or_index: &str) -> Option<usize> {
        let by_name = self.scenes.iter().position(|roots| roots.name == name_or_index);
        by_name.or_else(|| name_or_index.parse().ok().filter(|index| *index < self.scenes.len()))
    }

    /// Whether any node that is shown has a mesh with vertices.
    pub fn draws_anything(&self) -> bool {
        self.drawn_primitives() > 0
    }

    /// How many primitives are drawn, each counted once for every node that shows it, at any level.
    pub fn drawn_primitives(&self) -> usize {
        let forms = |material: Option<usize>| {
            let levels = material.and_then(|material| self.materials.get(material)?.levels.as_ref());
            levels.map_or(1, Levels::count)
        };
        let drawn_by: Vec<usize> = self
            .meshes
            .iter()
            .map(|mesh| {
                let drawn = mesh.primitives.iter().filter(|primitive| !primitive.positions.is_empty());
                drawn.map(|primitive| forms(primitive.material)).sum()
            })
            .collect();
        let nodes = self.visible_levels().into_iter().map(|(id, _)| self.node(id));
        nodes.filter_map(|node| drawn_by.get(node.mesh?)).fold(0, |sum, &count| sum.saturating_add(count))
    }
}
