//! Levels of detail: coarser forms of a node or a material, which take its place where it is seen small.

mod coarser;

pub use coarser::Levels;

use crate::{NodeId, Scene};

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
