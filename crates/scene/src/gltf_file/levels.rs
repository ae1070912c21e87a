//! `MSFT_lod`: coarser nodes and materials, which take the place of finer ones where those are seen small.
//!
//! Source: the extension's specification (Microsoft, in Khronos' registry). It leaves open what screen coverage is;
//! here it is the share of the picture's area that the ball around a node takes, as Babylon.js has it.

use super::document::Document;
use super::error::LoadError;
use super::json::Json;
use crate::{Levels, NodeId, Scene};
use std::collections::BTreeSet;

const NAME: &str = "MSFT_lod";

/// More coarser levels than these differ in nothing that anybody sees.
const LEVELS_MAX: usize = 16;

/// The levels of a node or a material, of which there are `length`; none if it has none.
fn read(document: &mut Document, json: &Json, (length, what): (usize, &str)) -> Option<Levels<usize>> {
    let found = json.extension(NAME).and_then(|extension| {
        extension.map(|extension| Ok((extension.indices("ids", length, what)?, extension))).transpose()
    });
    let (mut coarser, extension) = match found {
        Ok(found) => found?,
        Err(error) => {
            let pointer = error.pointer().to_owned();
            document.warn(&pointer, &format!("{}; there are no coarser levels", error.into_message()));
            return None;
        }
    };
    if coarser.len() > LEVELS_MAX {
        document.warn(&extension.at("ids"), &format!("only the first {LEVELS_MAX} coarser levels are read"));
        coarser.truncate(LEVELS_MAX);
    }
    if coarser.is_empty() {
        document.warn(&extension.at("ids"), "there are no coarser levels");
        return None;
    }
    Some(Levels { screen_coverage: read_coverage(document, json, coarser.len() + 1), coarser })
}

/// What `extras` say of coverage. They may hold anything, so that nothing of it refuses a file.
fn read_coverage(document: &mut Document, json: &Json, count: usize) -> Vec<f32> {
    let Some(extras) = json.object("extras").ok().flatten() else { return Vec::new() };
    let key = "MSFT_screencoverage";
    let Ok(list) = extras.number_list(key) else {
        document.warn(&extras.at(key), "expected an array of finite numbers; each level ends at half the size instead");
        return Vec::new();
    };
    let mut list = list.unwrap_or_default();
    list.truncate(count);
    let mut most = 1.0f32;
    for coverage in &mut list {
        most = coverage.clamp(0.0, most);
        if *coverage != most {
            document
                .warn(&extras.at(key), "expected shares from 1 to 0, each below the one before; they are moved there");
        }
        *coverage = most;
    }
    list
}

/// The levels of every material.
pub(super) fn of_materials(document: &mut Document, count: usize) -> Result<Vec<Option<Levels<usize>>>, LoadError> {
    let materials = document.root.objects("materials")?;
    let mut all = Vec::with_capacity(count);
    for (index, json) in materials.iter().enumerate() {
        let levels = read(document, json, (count, "material"));
        let is_own = levels.as_ref().is_some_and(|levels| levels.coarser.contains(&index));
        if is_own {
            document.warn(&json.at("extensions/MSFT_lod/ids"), "the material is a level of its own; it has none");
        }
        all.push(levels.filter(|_| !is_own));
    }
    Ok(all)
}

/// Gives nodes their levels. A coarser node stands where the finer one does: it has the same parent, and is none of its
/// children.
pub(super) fn of_nodes(document: &mut Document, scene: &mut Scene) -> Result<(), LoadError> {
    let nodes = document.root.objects("nodes")?;
    let (mut trees, mut taken) = (Trees::new(scene), BTreeSet::new());
    let mut all_coarser: BTreeSet<NodeId> = BTreeSet::new();
    for (index, json) in nodes.iter().enumerate() {
        let Some(levels) = read(document, json, (nodes.len(), "node")) else { continue };
        let is_repeated = levels.coarser.iter().collect::<BTreeSet<_>>().len() < levels.coarser.len();
        let why = if is_repeated { Some("a level is named twice".to_owned()) } else { None };
        let mut faults = levels.coarser.iter().map(|coarser| fault(scene, (index, *coarser), &taken, &mut trees));
        let why = why.or_else(|| faults.find_map(|fault| fault));
        if let Some(why) = why {
            let place = json.at("extensions/MSFT_lod/ids");
            document.warn(&place, &format!("{why}; the node itself is drawn at every size"));
            continue;
        }
        taken.insert(index);
        taken.extend(&levels.coarser);
        let coarser: Vec<NodeId> = levels.coarser.into_iter().map(|coarser| NodeId(coarser as u32)).collect();
        all_coarser.extend(coarser.iter().copied());
        let parent = scene.nodes.get(index).and_then(|node| node.parent);
        for coarser in &coarser {
            scene.node_mut(*coarser).parent = parent;
            trees.grow(*coarser, parent);
        }
        if let Some(node) = scene.nodes.get_mut(index) {
            node.levels = Some(Levels { coarser, screen_coverage: levels.screen_coverage });
        }
    }
    if !all_coarser.is_empty() {
        let is_finest = |id: &NodeId| !all_coarser.contains(id);
        scene.nodes.iter_mut().for_each(|node| node.children.retain(is_finest));
        scene.roots.retain(is_finest);
        scene.scenes.iter_mut().for_each(|roots| roots.roots.retain(is_finest));
    }
    Ok(())
}

/// Why a node cannot be a coarser level of another.
fn fault(
    scene: &Scene,
    (index, coarser): (usize, usize),
    taken: &BTreeSet<usize>,
    trees: &mut Trees,
) -> Option<String> {
    let (node, level) = (scene.nodes.get(index)?, scene.nodes.get(coarser)?);
    if coarser == index || taken.contains(&coarser) || taken.contains(&index) {
        return Some(format!("node {coarser} is a level already"));
    }
    if level.parent.is_some() && level.parent != node.parent {
        return Some(format!("node {coarser} stands elsewhere in the scene, and not beside node {index}"));
    }
    // Its transform would depend on itself.
    (level.parent.is_none() && node.parent.is_some() && trees.root(index) == coarser)
        .then(|| format!("node {coarser} is above node {index}"))
}

/// The root above every node, in nearly constant time (disjoint sets, Tarjan 1975).
struct Trees(Vec<usize>);

impl Trees {
    fn new(scene: &Scene) -> Self {
        let above = |(index, node): (usize, &crate::Node)| node.parent.map_or(index, |parent| parent.0 as usize);
        Self(scene.nodes.iter().enumerate().map(above).collect())
    }

    fn root(&mut self, mut index: usize) -> usize {
        while let Some(&above) = self.0.get(index).filter(|above| **above != index) {
            let next = self.0.get(above).copied().unwrap_or(above);
            if let Some(slot) = self.0.get_mut(index) {
                *slot = next;
            }
            index = above;
        }
        index
    }

    /// A root is put below another node.
    fn grow(&mut self, root: NodeId, parent: Option<NodeId>) {
        if let (Some(slot), Some(parent)) = (self.0.get_mut(root.0 as usize), parent) {
            *slot = parent.0 as usize;
        }
    }
}
