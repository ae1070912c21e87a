//! Levels of detail: coarser forms of a node or a material, which take its place where it is seen small.

use crate::{NodeId, Scene};

/// The levels of detail of a node or of a material (`MSFT_lod`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Levels<T> {
    /// Finer ones first; level 0 is the node or the material itself, and is none of them.
    pub coarser: Vec<T>,
    /// The share of the picture's area down to which each level is shown, that of level 0 first; below the last,
    /// nothing. What takes the area is the ball around the finest level. Where there are fewer than levels,
    /// [`Self::end_coverage`] says how they go on.
    pub screen_coverage: Vec<f32>,
}

/// Where a file does not say down to which share of the picture's area its node or material itself is shown: a quarter.
const FIRST_COVERAGE: f32 = 0.25;

impl<T> Levels<T> {
    /// How many levels there are, level 0 among them.
    pub fn count(&self) -> usize {
        self.coarser.len() + 1
    }

    /// The share of the picture's area down to which `level` is shown. Where the file does not say it, each ends at
    /// half the size of the one before, which is a quarter of the area, and the last never.
    pub fn end_coverage(&self, level: usize) -> f32 {
        if let Some(coverage) = self.screen_coverage.get(level) {
            return *coverage;
        }
        if level + 1 >= self.count() {
            return 0.0;
        }
        let (known, first) = match self.screen_coverage.last() {
            Some(last) => (self.screen_coverage.len(), 0.25 * last),
            None => (0, FIRST_COVERAGE),
        };
        first * 0.25f32.powi((level - known) as i32)
    }
}

/// A level of a node with levels of detail; 0 is the node itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LevelOf {
    /// The node with levels.
    pub node: NodeId,
    /// 0 is the node itself, 1 the first of [`Levels::coarser`].
    pub level: u32,
}

impl Scene {
    /// As [`Self::visible_nodes`], and with them every node of a coarser level, each with the level that it is drawn
    /// for. Nodes that are of no level are drawn in any case.
    pub fn visible_levels(&self) -> Vec<(NodeId, Option<LevelOf>)> {
        let is_visible = |id: &NodeId| self.node(*id).is_visible;
        let mut order: Vec<(NodeId, Option<LevelOf>)> =
            self.roots.iter().copied().filter(is_visible).map(|id| (id, None)).collect();
        let mut next = 0;
        while next < order.len() {
            let (id, mut of) = order[next];
            if let (Some(levels), None) = (&self.node(id).levels, of) {
                of = Some(LevelOf { node: id, level: 0 });
                order[next].1 = of;
                let coarser = levels.coarser.iter().zip(1..).filter(|(coarser, _)| is_visible(coarser));
                order.extend(coarser.map(|(coarser, level)| (*coarser, Some(LevelOf { node: id, level }))));
            }
            let children = self.node(id).children.iter().copied().filter(is_visible);
            order.extend(children.map(|child| (child, of)));
            next += 1;
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Node;

    #[test]
    fn coverage_goes_on_where_a_file_stops() {
        let mut levels = Levels { coarser: vec![1usize, 2], screen_coverage: Vec::new() };
        let ends = |levels: &Levels<usize>| [0, 1, 2].map(|level| levels.end_coverage(level));
        assert_eq!(ends(&levels), [0.25, 0.0625, 0.0]);
        levels.screen_coverage = vec![0.5];
        assert_eq!(ends(&levels), [0.5, 0.125, 0.0]);
        levels.screen_coverage = vec![0.5, 0.2, 0.01];
        assert_eq!(ends(&levels), [0.5, 0.2, 0.01]);
    }

    #[test]
    fn levels_are_nodes_beside_those_that_are_seen() {
        let mut scene = Scene::default();
        let root = scene.add_node(None, Node::default());
        let fine = scene.add_node(Some(root), Node::default());
        let wheel = scene.add_node(Some(fine), Node::default());
        let coarse = NodeId(scene.nodes.len() as u32);
        scene.nodes.push(Node { parent: Some(root), translation: glam::Vec3::X, ..Node::default() });
        let other = scene.add_node(Some(coarse), Node::default());
        scene.node_mut(fine).levels = Some(Levels { coarser: vec![coarse], screen_coverage: Vec::new() });
        scene.node_mut(root).translation = glam::Vec3::Y;
        scene.update_transforms();
        assert_eq!(scene.visible_nodes(), [root, fine, wheel]);
        let of = |level| Some(LevelOf { node: fine, level });
        let all = [(root, None), (fine, of(0)), (coarse, of(1)), (wheel, of(0)), (other, of(1))];
        assert_eq!(scene.visible_levels(), all);
        assert_eq!(scene.node(other).world_from_object.w_axis.truncate(), glam::Vec3::new(1.0, 1.0, 0.0));
        scene.node_mut(fine).is_visible = false;
        assert_eq!(scene.visible_levels(), [(root, None)]);
    }
}
