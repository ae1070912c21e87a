//! `MSFT_lod`: coarser nodes and materials.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{Model, push};
use glam::Vec3;
use manypass_scene::{LevelOf, NodeId};
use serde_json::{Value, json};

/// A node with two coarser ones that stand outside of the scene, below a node that is moved up by 10.
fn model(ids: Value, extras: Value) -> Model {
    let mut model = Model::triangle();
    model.json["extensionsUsed"] = json!(["MSFT_lod"]);
    model.json["nodes"] = json!([
        { "mesh": 0, "name": "fine", "translation": [1, 0, 0], "extras": extras, "extensions": { "MSFT_lod": { "ids": ids } } },
        { "mesh": 0, "translation": [2, 0, 0] },
        { "translation": [3, 0, 0], "children": [3] },
        { "mesh": 0, "translation": [0, 0, 1] },
        { "children": [0], "translation": [0, 10, 0] },
    ]);
    model.json["scenes"] = json!([{ "nodes": [4] }]);
    model
}

#[test]
fn coarser_nodes_stand_where_the_finer_one_does() {
    let scene = model(json!([1, 2]), json!({ "MSFT_screencoverage": [0.5, 0.2, 0.01] })).load().scene;
    let ids = |list: &[u32]| list.iter().map(|id| NodeId(*id)).collect::<Vec<_>>();
    assert_eq!(scene.visible_nodes(), ids(&[4, 0]));
    let levels = scene.nodes[0].levels.as_ref().unwrap();
    assert_eq!((&levels.coarser, &levels.screen_coverage), (&ids(&[1, 2]), &vec![0.5, 0.2, 0.01]));
    let of = |level| Some(LevelOf { node: NodeId(0), level });
    let drawn: Vec<_> =
        [(4, None), (0, of(0)), (1, of(1)), (2, of(2)), (3, of(2))].map(|(id, of)| (NodeId(id), of)).into();
    assert_eq!(scene.visible_levels(), drawn);
    let place = |node: usize| scene.nodes[node].world_from_object.w_axis.truncate();
    assert_eq!([0, 1, 3].map(place), [Vec3::new(1.0, 10.0, 0.0), Vec3::new(2.0, 10.0, 0.0), Vec3::new(3.0, 10.0, 1.0)]);
    assert!(!scene.nodes[1].bounds_world.is_empty());
}

#[test]
fn a_coarser_node_that_is_in_the_scene_is_drawn_as_a_level_alone() {
    let mut model = model(json!([1]), Value::Null);
    model.json["nodes"][4]["children"] = json!([0, 1]);
    model.json["scenes"][0]["nodes"] = json!([4, 2]);
    model.json["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = json!([1]);
    let scene = model.load().scene;
    assert_eq!(scene.visible_nodes(), [4, 2, 0, 3].map(NodeId));
    assert!(scene.visible_levels().contains(&(NodeId(1), Some(LevelOf { node: NodeId(0), level: 1 }))));
}

#[test]
fn what_cannot_be_a_level_is_none() {
    let warned = |model: Model| {
        let loaded = model.try_load().unwrap();
        assert_eq!(loaded.scene.visible_levels().len(), loaded.scene.visible_nodes().len());
        loaded.warnings.join("\n")
    };
    let place = "at \"/nodes/0/extensions/MSFT_lod/ids\": ";
    for (ids, why) in [
        (json!([0]), "node 0 is a level already"),
        (json!([3]), "node 3 stands elsewhere in the scene, and not beside node 0"),
        (json!([1, 4]), "node 4 is above node 0"),
        (json!([]), "there are no coarser levels"),
        (json!([1, 1]), "a level is named twice"),
    ] {
        let warnings = warned(model(ids, Value::Null));
        assert!(warnings.starts_with(&format!("{place}{why}")), "{warnings}");
    }
    // Without its levels a model is drawn as it is, so that a broken one is no reason to refuse.
    let loaded = model(json!([9]), Value::Null).try_load().unwrap();
    let said = format!("{place}expected indices of node below 5; there are no coarser levels");
    assert_eq!(loaded.warnings, [said]);
    // A level has none itself.
    let mut nested = model(json!([1]), Value::Null);
    nested.json["nodes"][1]["extensions"] = json!({ "MSFT_lod": { "ids": [2] } });
    let loaded = nested.try_load().unwrap();
    assert!(loaded.warnings[0].contains("node 2 is a level already"), "{:?}", loaded.warnings);
}

#[test]
fn coverage_may_be_anything() {
    for (extras, expected, warnings) in [
        (json!({ "MSFT_screencoverage": "half" }), &[][..], 1),
        (json!(5), &[], 0),
        // Two are moved, which is one warning.
        (json!({ "MSFT_screencoverage": [2.0, 0.5, -1.0, 0.5] }), &[1.0, 0.5, 0.0], 1),
        (json!({ "MSFT_screencoverage": [0.2, 0.5] }), &[0.2, 0.2], 1),
        (json!({}), &[], 0),
    ] {
        let loaded = model(json!([1, 2]), extras.clone()).try_load().unwrap();
        let levels = loaded.scene.nodes[0].levels.as_ref().unwrap();
        assert_eq!((&levels.screen_coverage[..], loaded.warnings.len()), (expected, warnings), "{extras}");
    }
}

#[test]
fn materials_have_levels() {
    let mut model = Model::triangle();
    let lod = |ids: Value| json!({ "MSFT_lod": { "ids": ids } });
    push(
        &mut model.json["materials"],
        json!({ "extensions": lod(json!([1])), "extras": { "MSFT_screencoverage": [0.3] } }),
    );
    push(&mut model.json["materials"], json!({ "extensions": lod(json!([1])) }));
    model.primitive()["material"] = json!(0);
    let loaded = model.try_load().unwrap();
    assert!(loaded.warnings[0].contains("/materials/1/extensions/MSFT_lod/ids"), "{:?}", loaded.warnings);
    let levels = loaded.scene.materials[0].levels.clone().unwrap();
    assert_eq!((levels.coarser, levels.screen_coverage), (vec![1], vec![0.3]));
    assert_eq!(loaded.scene.materials[1].levels, None);
}
