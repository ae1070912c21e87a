//! Nodes, cameras, lights and skins.

use super::accessor::to_f32;
use super::component::Component;
use super::document::Document;
use super::error::LoadError;
use super::faults::List;
use super::json::Json;
use super::needed::index_or_none;
use crate::light::{CONE_MIN_RAD, RANGE_MIN_M};
use crate::{Camera, Light, LightKind, LightMode, Node, NodeId, Projection, Scene, SceneRoots, Skin};
use glam::{Mat4, Quat, Vec3};
use std::collections::BTreeSet;

/// What stands in for a camera that is broken: 45° high.
const DEFAULT_LENS: Projection =
    Projection::Perspective { fov_y_rad: std::f32::consts::FRAC_PI_4, near_m: 0.01, far_m: None };

/// Every camera. One that is broken has another lens: pictures by other cameras do not need it.
pub(super) fn read_cameras(document: &mut Document) -> Result<Vec<Camera>, LoadError> {
    let cameras = document.root.objects("cameras")?;
    let read = |json: &Json| {
        read_camera(json).unwrap_or_else(|error| {
            let pointer = error.pointer().to_owned();
            let message = format!("{}; a perspective lens of 45 degrees is used", error.into_message());
            document.warn(&pointer, &message);
            Camera { name: json.name(), projection: DEFAULT_LENS, aspect: None }
        })
    };
    Ok(cameras.iter().map(read).collect())
}

fn read_camera(json: &Json) -> Result<Camera, LoadError> {
    let positive = |json: &Json, key: &str| match json.number(key)? {
        Some(value) if value > 0.0 => Ok(value),
        _ => Err(json.error(key, "expected a number above 0")),
    };
    let (projection, shape) = match json.string("type")?.unwrap_or("nothing") {
        "perspective" => {
            let lens = json.require_object("perspective")?;
            let near_m = positive(&lens, "znear")?;
            let far_m = if lens.has("zfar") { Some(positive(&lens, "zfar")?) } else { None };
            if far_m.is_some_and(|far_m| far_m <= near_m) {
                return Err(lens.error("zfar", "expected a number above znear"));
            }
            let shape = lens.number("aspectRatio").ok().flatten();
            (Projection::Perspective { fov_y_rad: positive(&lens, "yfov")?, near_m, far_m }, shape)
        }
        "orthographic" => {
            let lens = json.require_object("orthographic")?;
            let ymag = lens.number("ymag")?.filter(|&ymag| ymag != 0.0);
            let ymag = ymag.ok_or_else(|| lens.error("ymag", "expected a number that is not 0"))?;
            let near_m = lens.number_in("znear", -1.0, 0.0, f32::MAX)?;
            let far_m = positive(&lens, "zfar")?;
            if far_m <= near_m {
                return Err(lens.error("zfar", "expected a number above znear"));
            }
            // One that says nothing of its width says nothing of the picture's shape.
            let shape = lens.number("xmag").ok().flatten().map(|xmag| (xmag / ymag).abs());
            (Projection::Orthographic { height_m: 2.0 * ymag.abs(), near_m, far_m }, shape)
        }
        other => return Err(json.error("type", format!("expected perspective or orthographic, found {other}"))),
    };
    let aspect = shape.filter(|aspect| *aspect > 0.0 && aspect.is_finite());
    Ok(Camera { name: json.name(), projection, aspect })
}

/// Every light of `KHR_lights_punctual`; one of an unknown kind shines with intensity 0.
pub(super) fn read_lights(document: &mut Document) -> Result<Vec<Light>, LoadError> {
    let Some(extension) = document.root.extension("KHR_lights_punctual")? else { return Ok(Vec::new()) };
    let mut lights = Vec::new();
    for (index, json) in extension.objects("lights")?.iter().enumerate() {
        let read = read_light(document, json);
        lights.push(document.faults.or(List::Lights, index, read, Light::default()));
    }
    Ok(lights)
}

fn read_light(document: &mut Document, json: &Json) -> Result<Light, LoadError> {
    let mut intensity = document.clamped_number(json, "intensity", 1.0, f32::MAX)?;
    let kind = match json.string("type")?.unwrap_or("nothing") {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point,
        "spot" => read_cone(document, &json.require_object("spot")?)?,
        other => {
            document.warn(&json.at("type"), &format!("the kind of light {other} is not known; it gives no light"));
            intensity = 0.0;
            LightKind::Point
        }
    };
    let range_m = read_range(document, json)?;
    let color_linear = Vec3::from(document.clamped(json, "color", [1.0; 3], f32::MAX)?);
    let mode = json.extra("mode").and_then(LightMode::named).unwrap_or_default();
    let radius_m = json.extra_number("radius").unwrap_or(0.0).max(0.0);
    let (name, casts_shadows) = (json.name(), !json.denies("castShadow"));
    Ok(Light { name, color_linear, intensity, range_m, kind, radius_m, casts_shadows, mode })
}

/// The range of a light; the square of what is shorter is nothing in 32 bits.
fn read_range(document: &mut Document, json: &Json) -> Result<Option<f32>, LoadError> {
    let range_m = json.number("range")?;
    if range_m.is_some_and(|range_m| range_m <= 0.0) {
        return Err(json.error("range", "expected a number above 0; leave it out for light without end"));
    }
    let least_m = RANGE_MIN_M as f32;
    if range_m.is_some_and(|range_m| range_m < least_m) {
        document.warn(&json.at("range"), &format!("expected at least {RANGE_MIN_M}, which is used"));
    }
    Ok(range_m.map(|range_m| range_m.max(least_m)))
}

/// The cone of a spot light. Exporters write equal angles for a hard edge, which glTF forbids; they are drawn apart.
fn read_cone(document: &mut Document, spot: &Json) -> Result<LightKind, LoadError> {
    let quarter = std::f32::consts::FRAC_PI_2;
    let outer_cone_rad = spot.number_in("outerConeAngle", quarter / 2.0, 0.0, quarter + 1e-5)?;
    if outer_cone_rad < CONE_MIN_RAD {
        document.warn(&spot.at("outerConeAngle"), &format!("expected at least {CONE_MIN_RAD}, which is used"));
    }
    let outer_cone_rad = outer_cone_rad.clamp(CONE_MIN_RAD, quarter);
    let mut inner_cone_rad = spot.number_in("innerConeAngle", 0.0, 0.0, quarter + 1e-5)?;
    if inner_cone_rad >= outer_cone_rad {
        document.warn(&spot.at("innerConeAngle"), "expected an angle below outerConeAngle; one just below is used");
        inner_cone_rad = 0.999 * outer_cone_rad;
    }
    Ok(LightKind::Spot { inner_cone_rad, outer_cone_rad })
}

/// Every node, and the roots of every scene; those of the one that the file names are shown.
pub(super) fn read_nodes(document: &mut Document, scene: &mut Scene) -> Result<(), LoadError> {
    let nodes = document.root.objects("nodes")?;
    let skin_count = document.root.objects("skins")?.len();
    for (index, json) in nodes.iter().enumerate() {
        let camera = index_or_none(document, json, "camera", scene.cameras.len(), "camera");
        let read = read_node(json, scene, nodes.len(), skin_count).map(|node| Node { camera, ..node });
        scene.nodes.push(document.faults.or(List::Nodes, index, read, Node::default()));
    }
    for (i, json) in nodes.iter().enumerate() {
        // One that is broken has none.
        if document.faults.check(List::Nodes, i).is_err() {
            continue;
        }
        for child in json.indices("children", nodes.len(), "node")? {
            let node = scene.nodes.get_mut(child);
            if node.and_then(|node| node.parent.replace(NodeId(i as u32))).is_some() {
                return Err(json.error("children", format!("node {child} already has a parent; expected a tree")));
            }
        }
    }
    check_cycles(scene)?;
    let orphans = |scene: &Scene| {
        let parentless = scene.nodes.iter().enumerate().filter(|(_, node)| node.parent.is_none());
        parentless.map(|(i, _)| NodeId(i as u32)).collect()
    };
    let scenes = document.root.objects("scenes")?;
    let shown = document.root.index("scene", scenes.len(), "scene")?.unwrap_or(0);
    if scenes.is_empty() {
        scene.roots = orphans(scene);
    }
    // A scene with a fault in its list has nothing to say of the others.
    let listed = |json: &Json| json.indices("nodes", nodes.len(), "node").unwrap_or_default();
    let roots_of_all: BTreeSet<usize> = scenes.iter().flat_map(listed).collect();
    for (i, json) in scenes.iter().enumerate() {
        // A fault in a scene that nobody has asked for yet is no reason to refuse the file.
        let roots = match read_roots(document, json, scene, &roots_of_all) {
            Err(error) if i != shown => {
                document.warn(&json.at("nodes"), &format!("the scene cannot be shown: {}", error.into_message()));
                Vec::new()
            }
            roots => roots?,
        };
        scene.scenes.push(SceneRoots { name: json.name(), roots });
    }
    if let Some(shown_scene) = scene.scenes.get(shown) {
        (scene.roots, scene.shown_scene) = (shown_scene.roots.clone(), Some(shown));
    }
    Ok(())
}

/// The nodes of one of the file's scenes. They should have no parent: one whose parents no scene has is shown without
/// them, and one that comes with its parents, or twice, is there once.
fn read_roots(
    document: &mut Document,
    json: &Json,
    scene: &mut Scene,
    roots_of_all: &BTreeSet<usize>,
) -> Result<Vec<NodeId>, LoadError> {
    let (mut roots, mut seen) = (Vec::new(), BTreeSet::new());
    for root in json.indices("nodes", scene.nodes.len(), "node")? {
        let id = NodeId(root as u32);
        let parent_of = |id: NodeId| scene.nodes.get(id.0 as usize).and_then(|node| node.parent);
        let mut parents = std::iter::successors(parent_of(id), |parent| parent_of(*parent));
        if !seen.insert(root) || parents.any(|parent| roots_of_all.contains(&(parent.0 as usize))) {
            document.warn(&json.at("nodes"), "expected nodes without a parent, each once; others are there once");
            continue;
        }
        if parent_of(id).is_some() {
            document.warn(&json.at("nodes"), "expected nodes without a parent; others are shown without theirs");
            scene.remove_node(id);
        }
        roots.push(id);
    }
    Ok(roots)
}

/// Every node has one parent at most, so that whatever the parentless do not reach lies on or below a cycle.
fn check_cycles(scene: &Scene) -> Result<(), LoadError> {
    let mut reached = vec![false; scene.nodes.len()];
    let parentless = scene.nodes.iter().enumerate().filter(|(_, node)| node.parent.is_none());
    let mut pending: Vec<usize> = parentless.map(|(i, _)| i).collect();
    while let Some(i) = pending.pop() {
        if let Some(slot) = reached.get_mut(i) {
            *slot = true;
        }
        pending.extend(scene.nodes.get(i).into_iter().flat_map(|node| &node.children).map(|child| child.0 as usize));
    }
    match reached.iter().position(|reached| !reached) {
        Some(i) => Err(LoadError::invalid(&format!("/nodes/{i}"), "the node is its own ancestor; expected a tree")),
        None => Ok(()),
    }
}

fn read_node(json: &Json, scene: &Scene, node_count: usize, skin_count: usize) -> Result<Node, LoadError> {
    let children = json.indices("children", node_count, "node")?;
    let mut node = Node {
        casts_shadow: !json.denies("castShadow"),
        name: json.name(),
        children: children.into_iter().map(|child| NodeId(child as u32)).collect(),
        translation: Vec3::from(json.numbers("translation")?.unwrap_or([0.0; 3])),
        scale: Vec3::from(json.numbers("scale")?.unwrap_or([1.0; 3])),
        mesh: json.index("mesh", scene.meshes.len(), "mesh")?,
        skin: json.index("skin", skin_count, "skin")?,
        morph_weights: json.number_list("weights")?.unwrap_or_default(),
        ..Node::default()
    };
    if let Some(rotation) = json.numbers::<4>("rotation")? {
        let rotation = Quat::from_array(rotation);
        let length = rotation.length();
        if !(0.5..2.0).contains(&length) {
            return Err(json.error("rotation", format!("expected a unit quaternion, found one of length {length}")));
        }
        node.rotation = rotation.normalize();
    }
    if let Some(columns) = json.numbers::<16>("matrix")? {
        let matrix = Mat4::from_cols_array(&columns);
        if matrix.row(3) != glam::Vec4::W {
            return Err(json.error("matrix", "expected an affine transform, its last row 0 0 0 1"));
        }
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let again = Mat4::from_scale_rotation_translation(scale, rotation, translation);
        let tolerance = 1e-6 * scale.abs().max_element();
        if again.is_finite() && matrix.abs_diff_eq(again, tolerance) {
            (node.scale, node.rotation, node.translation) = (scale, rotation, translation);
        } else {
            node.matrix = Some(matrix);
        }
    }
    if let Some(extension) = json.extension("KHR_lights_punctual")? {
        node.light = extension.index("light", scene.lights.len(), "light")?;
    }
    if let Some(extension) = json.extension("KHR_node_visibility")? {
        node.is_visible = extension.bool("visible", true)?;
    }
    if let Some(mesh) = node.mesh.and_then(|mesh| scene.meshes.get(mesh))
        && !node.morph_weights.is_empty()
        && !mesh.primitives.is_empty()
        && node.morph_weights.len() != mesh.default_morph_weights.len()
    {
        return Err(json.error("weights", format!("expected {} weights", mesh.default_morph_weights.len())));
    }
    Ok(node)
}

/// Every skin; the joints that meshes use exist in it.
pub(super) fn read_skins(document: &mut Document, scene: &mut Scene) -> Result<(), LoadError> {
    for (index, json) in document.root.objects("skins")?.iter().enumerate() {
        let read = read_skin(document, json, scene);
        scene.skins.push(document.faults.or(List::Skins, index, read, Skin::default()));
    }
    check_joints(document, scene);
    Ok(())
}

fn read_skin(document: &mut Document, json: &Json, scene: &Scene) -> Result<Skin, LoadError> {
    let joints = json.indices("joints", scene.nodes.len(), "node")?;
    if joints.is_empty() {
        return Err(json.error("joints", "expected at least 1 joint"));
    }
    let mut inverse_bind_matrices = vec![Mat4::IDENTITY; joints.len()];
    if let Some(index) = json.index("inverseBindMatrices", document.accessors.len(), "accessor")? {
        let pointer = json.at("inverseBindMatrices");
        let header = document.accessor_header(index, &pointer)?;
        if header.component != Component::F32 || header.count < joints.len() {
            return Err(json.error("inverseBindMatrices", "expected a MAT4 of floats for every joint"));
        }
        let matrices = document.read::<f32, 16>(index, &pointer, to_f32)?;
        for (slot, columns) in inverse_bind_matrices.iter_mut().zip(matrices) {
            *slot = Mat4::from_cols_array(&columns);
            if !slot.is_finite() {
                return Err(json.error("inverseBindMatrices", "expected finite numbers"));
            }
        }
    }
    let joints = joints.into_iter().map(|joint| NodeId(joint as u32)).collect();
    Ok(Skin { joints, inverse_bind_matrices })
}

/// Nodes whose mesh names joints that their skin does not have are broken.
fn check_joints(document: &mut Document, scene: &mut Scene) {
    let last_joints: Vec<u16> = scene
        .meshes
        .iter()
        .map(|mesh| {
            mesh.primitives.iter().flat_map(|primitive| primitive.joints.iter().flatten()).copied().max().unwrap_or(0)
        })
        .collect();
    for (i, node) in scene.nodes.iter_mut().enumerate() {
        let skin = node.skin.and_then(|skin| scene.skins.get(skin));
        if let (Some(skin), Some(&last)) = (skin, node.mesh.and_then(|mesh| last_joints.get(mesh)))
            && !skin.joints.is_empty()
            && usize::from(last) >= skin.joints.len()
        {
            let message = format!("the mesh uses joint {last}, but the skin has {}", skin.joints.len());
            let error = LoadError::invalid(&format!("/nodes/{i}/skin"), message);
            document.faults.or(List::Nodes, i, Err(error), ());
            node.skin = None;
        }
    }
}
