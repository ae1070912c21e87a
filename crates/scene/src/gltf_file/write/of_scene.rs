//! Scenes as glTF files.

use super::{Numbers, Parts};
use crate::material::{TextureRef, TextureTransform, TexturedFactor};
use crate::{
    AlphaMode, Image, ImageSource, Light, LightKind, LightMode, Material, Node, Pixels, Primitive, Projection, Sampler,
    Scene, ShadingModel, Topology, Wrap,
};
use glam::Vec3;
use serde_json::{Map, Value, json};
use std::io::Cursor;

/// What a file says, object by object.
type Object = Map<String, Value>;

/// Puts a value that is not the default one.
fn put(object: &mut Object, key: &str, value: impl Into<Value>, is_default: bool) {
    if !is_default {
        object.insert(key.into(), value.into());
    }
}

fn put_name(object: &mut Object, name: &str) {
    put(object, "name", name, name.is_empty());
}

/// A scene becomes a file.
struct Writer<'s> {
    scene: &'s Scene,
    parts: Parts,
    notes: Vec<String>,
}

impl Parts {
    /// A scene as a file, and what of it glTF, or this, cannot say: one line each. Nodes, meshes, materials, images,
    /// lights and cameras have the indices that they have in the scene; animations, skins and variants are left out. What
    /// glTF has no words for is in `extras`: `castShadow` of materials, nodes and lights, `radius` and `mode` of lights,
    /// `exposureStops` of the asset.
    pub fn of_scene(scene: &Scene) -> (Self, Vec<String>) {
        let mut writer = Writer { scene, parts: Self::empty(), notes: Vec::new() };
        writer.note(!scene.animations.is_empty(), "animations");
        writer.note(!scene.skins.is_empty(), "skins");
        writer.note(!scene.variants.is_empty(), "variants of materials");
        if let Some(stops) = scene.exposure_stops {
            writer.parts.json["asset"]["extras"]["exposureStops"] = stops.into();
        }
        writer.images();
        for material in &scene.materials {
            let material = writer.material(material);
            writer.parts.push("materials", material);
        }
        for mesh in &scene.meshes {
            let primitives: Vec<Value> = mesh.primitives.iter().map(|primitive| writer.primitive(primitive)).collect();
            let mut object = Object::new();
            put_name(&mut object, &mesh.name);
            object.insert("primitives".into(), primitives.into());
            writer.parts.push("meshes", object.into());
        }
        writer.cameras();
        writer.lights();
        for node in &scene.nodes {
            let node = writer.node(node);
            writer.parts.push("nodes", node);
        }
        let roots: Vec<u32> = scene.roots.iter().map(|id| id.0).collect();
        writer.parts.push("scenes", if roots.is_empty() { json!({}) } else { json!({ "nodes": roots }) });
        writer.parts.json["scene"] = 0.into();
        (writer.parts, writer.notes)
    }
}

impl Writer<'_> {
    fn note(&mut self, is_there: bool, what: &str) {
        if is_there {
            self.notes.push(format!("{what} are left out"));
        }
    }

    fn images(&mut self) {
        for image in &self.scene.images {
            let written = encoded(image);
            if written.is_none() {
                self.notes.push(format!("image `{}` is left out: it has no file", image.name));
            }
            // A white texel keeps the places of the others.
            let white = || Pixels { width: 1, height: 1, format: crate::PixelFormat::Rgba8, data: vec![255; 4] };
            let (kind, bytes) = written.or_else(|| as_png(&white())).unwrap_or(("image/png", Vec::new()));
            self.parts.append_image(&image.name, kind, &bytes);
        }
        for texture in &self.scene.textures {
            let sampler = self.parts.push("samplers", sampler(texture.sampler));
            let mime_type = self.parts.json["images"][texture.image]["mimeType"].clone();
            let extension = match mime_type.as_str() {
                Some("image/ktx2") => Some("KHR_texture_basisu"),
                Some("image/webp") => Some("EXT_texture_webp"),
                _ => None,
            };
            let object = match extension {
                Some(name) => {
                    self.parts.use_extension(name);
                    json!({ "sampler": sampler, "extensions": { name: { "source": texture.image } } })
                }
                None => json!({ "sampler": sampler, "source": texture.image }),
            };
            self.parts.push("textures", object);
        }
    }

    fn texture(&mut self, object: &mut Object, key: &str, reference: Option<TextureRef>) {
        let Some(reference) = reference else { return };
        let mut info = Object::new();
        info.insert("index".into(), reference.texture.into());
        put(&mut info, "texCoord", reference.uv_set, reference.uv_set == 0);
        if reference.transform != TextureTransform::default() {
            let TextureTransform { offset, rotation_rad, scale } = reference.transform;
            let transform = json!({ "offset": offset.to_array(), "rotation": rotation_rad, "scale": scale.to_array() });
            info.insert("extensions".into(), json!({ "KHR_texture_transform": transform }));
            self.parts.use_extension("KHR_texture_transform");
        }
        object.insert(key.into(), info.into());
    }

    fn material(&mut self, material: &Material) -> Value {
        let default = Material::default();
        let mut object = Object::new();
        put_name(&mut object, &material.name);
        let mut plain = Object::new();
        let base = material.base_color_factor;
        put(&mut plain, "baseColorFactor", base.to_array().to_vec(), base == default.base_color_factor);
        put(&mut plain, "metallicFactor", material.metallic_factor, material.metallic_factor == 1.0);
        put(&mut plain, "roughnessFactor", material.roughness_factor, material.roughness_factor == 1.0);
        self.texture(&mut plain, "baseColorTexture", material.base_color_texture);
        self.texture(&mut plain, "metallicRoughnessTexture", material.metallic_roughness_texture);
        object.insert("pbrMetallicRoughness".into(), plain.into());
        self.texture(&mut object, "normalTexture", material.normal_texture);
        if material.normal_texture.is_some() && material.normal_scale != 1.0 {
            object["normalTexture"]["scale"] = material.normal_scale.into();
        }
        self.texture(&mut object, "occlusionTexture", material.occlusion_texture);
        if material.occlusion_texture.is_some() && material.occlusion_strength != 1.0 {
            object["occlusionTexture"]["strength"] = material.occlusion_strength.into();
        }
        self.texture(&mut object, "emissiveTexture", material.emissive_texture);
        let strength = material.emissive_factor.max_element().max(1.0);
        let emissive = material.emissive_factor / strength;
        put(&mut object, "emissiveFactor", emissive.to_array().to_vec(), emissive == Vec3::ZERO);
        match material.alpha_mode {
            AlphaMode::Opaque => {}
            AlphaMode::Mask { cutoff } => {
                object.insert("alphaMode".into(), "MASK".into());
                object.insert("alphaCutoff".into(), cutoff.into());
            }
            AlphaMode::Blend => {
                object.insert("alphaMode".into(), "BLEND".into());
            }
        }
        put(&mut object, "doubleSided", true, !material.double_sided);
        put(&mut object, "extras", json!({ "castShadow": false }), material.casts_shadow);
        let mut extensions = Object::new();
        if strength > 1.0 {
            extensions.insert("KHR_materials_emissive_strength".into(), json!({ "emissiveStrength": strength }));
        }
        if material.shading_model == ShadingModel::Unlit {
            extensions.insert("KHR_materials_unlit".into(), json!({}));
        }
        if material.ior != default.ior {
            extensions.insert("KHR_materials_ior".into(), json!({ "ior": material.ior }));
        }
        self.surface_layers(material, &mut extensions);
        self.transmission(material, &mut extensions);
        self.note(material.height.is_some() || material.detail.is_some(), "height maps and detail maps");
        if material.height.is_some() || material.detail.is_some() {
            self.notes.dedup();
        }
        extensions.keys().for_each(|name| self.parts.use_extension(name));
        let has_none = extensions.is_empty();
        put(&mut object, "extensions", extensions, has_none);
        object.into()
    }

    fn share(
        &mut self,
        object: &mut Object,
        (factor_key, texture_key): (&str, &str),
        share: TexturedFactor<f32>,
        default: f32,
    ) {
        put(object, factor_key, share.factor, share.factor == default);
        self.texture(object, texture_key, share.texture);
    }

    fn color(
        &mut self,
        object: &mut Object,
        (factor_key, texture_key): (&str, &str),
        color: TexturedFactor<Vec3>,
        default: Vec3,
    ) {
        put(object, factor_key, color.factor.to_array().to_vec(), color.factor == default);
        self.texture(object, texture_key, color.texture);
    }

    fn surface_layers(&mut self, material: &Material, extensions: &mut Object) {
        if let Some(specular) = material.specular {
            let mut of = Object::new();
            self.share(&mut of, ("specularFactor", "specularTexture"), specular.weight, 1.0);
            self.color(&mut of, ("specularColorFactor", "specularColorTexture"), specular.color, Vec3::ONE);
            extensions.insert("KHR_materials_specular".into(), of.into());
        }
        if let Some(coat) = material.clearcoat {
            let mut of = Object::new();
            self.share(&mut of, ("clearcoatFactor", "clearcoatTexture"), coat.weight, 0.0);
            let keys = ("clearcoatRoughnessFactor", "clearcoatRoughnessTexture");
            self.share(&mut of, keys, coat.roughness, 0.0);
            self.texture(&mut of, "clearcoatNormalTexture", coat.normal_texture);
            extensions.insert("KHR_materials_clearcoat".into(), of.into());
        }
        if let Some(sheen) = material.sheen {
            let mut of = Object::new();
            self.color(&mut of, ("sheenColorFactor", "sheenColorTexture"), sheen.color, Vec3::ZERO);
            self.share(&mut of, ("sheenRoughnessFactor", "sheenRoughnessTexture"), sheen.roughness, 0.0);
            extensions.insert("KHR_materials_sheen".into(), of.into());
        }
        if let Some(anisotropy) = material.anisotropy {
            let mut of = Object::new();
            put(&mut of, "anisotropyStrength", anisotropy.strength, false);
            put(&mut of, "anisotropyRotation", anisotropy.rotation_rad, anisotropy.rotation_rad == 0.0);
            self.texture(&mut of, "anisotropyTexture", anisotropy.texture);
            extensions.insert("KHR_materials_anisotropy".into(), of.into());
        }
        if let Some(film) = material.iridescence {
            let mut of = Object::new();
            self.share(&mut of, ("iridescenceFactor", "iridescenceTexture"), film.weight, 0.0);
            put(&mut of, "iridescenceIor", film.ior, false);
            put(&mut of, "iridescenceThicknessMinimum", film.thickness_min_nm, false);
            put(&mut of, "iridescenceThicknessMaximum", film.thickness_max_nm, false);
            self.texture(&mut of, "iridescenceThicknessTexture", film.thickness_texture);
            extensions.insert("KHR_materials_iridescence".into(), of.into());
        }
    }

    fn transmission(&mut self, material: &Material, extensions: &mut Object) {
        if let Some(transmission) = material.transmission {
            let mut of = Object::new();
            self.share(&mut of, ("transmissionFactor", "transmissionTexture"), transmission, 0.0);
            extensions.insert("KHR_materials_transmission".into(), of.into());
        }
        if let Some(diffuse) = material.diffuse_transmission {
            let mut of = Object::new();
            let keys = ("diffuseTransmissionFactor", "diffuseTransmissionTexture");
            self.share(&mut of, keys, diffuse.weight, 0.0);
            let keys = ("diffuseTransmissionColorFactor", "diffuseTransmissionColorTexture");
            self.color(&mut of, keys, diffuse.color, Vec3::ONE);
            extensions.insert("KHR_materials_diffuse_transmission".into(), of.into());
        }
        if let Some(volume) = material.volume {
            let mut of = Object::new();
            self.share(&mut of, ("thicknessFactor", "thicknessTexture"), volume.thickness, 0.0);
            let distance = volume.attenuation_distance_m;
            put(&mut of, "attenuationDistance", distance, !distance.is_finite());
            put(&mut of, "attenuationColor", volume.attenuation_color.to_array().to_vec(), false);
            extensions.insert("KHR_materials_volume".into(), of.into());
        }
        if material.dispersion > 0.0 {
            extensions.insert("KHR_materials_dispersion".into(), json!({ "dispersion": material.dispersion }));
        }
    }

    fn primitive(&mut self, primitive: &Primitive) -> Value {
        let mut attributes = Object::new();
        let mut give = |name: &str, numbers: Numbers, is_there: bool| {
            if is_there {
                attributes.insert(name.into(), self.parts.append_accessor(numbers).into());
            }
        };
        give("POSITION", Numbers::Vec3(&primitive.positions), !primitive.positions.is_empty());
        give("NORMAL", Numbers::Vec3(&primitive.normals), !primitive.normals.is_empty());
        give("TANGENT", Numbers::Vec4(&primitive.tangents), !primitive.tangents.is_empty());
        give("TEXCOORD_0", Numbers::Vec2(&primitive.uv0), !primitive.uv0.is_empty());
        give("TEXCOORD_1", Numbers::Vec2(&primitive.uv1), !primitive.uv1.is_empty());
        give("COLOR_0", Numbers::Vec4(&primitive.colors), !primitive.colors.is_empty());
        // Sets are counted without gaps.
        if primitive.uv0.is_empty()
            && let Some(second) = attributes.get("TEXCOORD_1").cloned()
        {
            attributes.insert("TEXCOORD_0".into(), second);
        }
        let mut object = Object::new();
        object.insert("attributes".into(), attributes.into());
        if !primitive.indices.is_empty() {
            object.insert("indices".into(), self.parts.append_accessor(Numbers::Indices(&primitive.indices)).into());
        }
        let mode = match primitive.topology {
            Topology::Points => 0,
            Topology::Lines => 1,
            Topology::Triangles => 4,
        };
        put(&mut object, "mode", mode, mode == 4);
        if let Some(material) = primitive.material {
            object.insert("material".into(), material.into());
        }
        object.into()
    }

    fn cameras(&mut self) {
        for camera in &self.scene.cameras {
            let mut object = match camera.projection {
                Projection::Perspective { fov_y_rad, near_m, far_m } => {
                    let mut lens = json!({ "yfov": fov_y_rad, "znear": near_m });
                    if let Some(aspect) = camera.aspect {
                        lens["aspectRatio"] = aspect.into();
                    }
                    if let Some(far) = far_m {
                        lens["zfar"] = far.into();
                    }
                    json!({ "type": "perspective", "perspective": lens })
                }
                Projection::Orthographic { height_m, near_m, far_m } => {
                    let half = 0.5 * height_m;
                    let lens = json!({ "xmag": half * camera.aspect.unwrap_or(1.0), "ymag": half, "znear": near_m, "zfar": far_m });
                    json!({ "type": "orthographic", "orthographic": lens })
                }
            };
            if !camera.name.is_empty() {
                object["name"] = camera.name.clone().into();
            }
            self.parts.push("cameras", object);
        }
    }

    fn lights(&mut self) {
        if self.scene.lights.is_empty() {
            return;
        }
        let lights: Vec<Value> = self.scene.lights.iter().map(light).collect();
        self.parts.json["extensions"]["KHR_lights_punctual"] = json!({ "lights": lights });
        self.parts.use_extension("KHR_lights_punctual");
    }

    fn node(&mut self, node: &Node) -> Value {
        let mut object = Object::new();
        put_name(&mut object, &node.name);
        let children: Vec<u32> = node.children.iter().map(|id| id.0).collect();
        let has_none = children.is_empty();
        put(&mut object, "children", children, has_none);
        match node.matrix {
            Some(matrix) => put(&mut object, "matrix", matrix.to_cols_array().to_vec(), false),
            None => {
                put(&mut object, "translation", node.translation.to_array().to_vec(), node.translation == Vec3::ZERO);
                let is_turned = node.rotation != glam::Quat::IDENTITY;
                put(&mut object, "rotation", node.rotation.normalize().to_array().to_vec(), !is_turned);
                put(&mut object, "scale", node.scale.to_array().to_vec(), node.scale == Vec3::ONE);
            }
        }
        let drawn =
            node.mesh.filter(|mesh| self.scene.meshes.get(*mesh).is_some_and(|mesh| !mesh.primitives.is_empty()));
        if let Some(mesh) = drawn {
            object.insert("mesh".into(), mesh.into());
        }
        if let Some(camera) = node.camera {
            object.insert("camera".into(), camera.into());
        }
        put(&mut object, "extras", json!({ "castShadow": false }), node.casts_shadow);
        let mut extensions = Object::new();
        if let Some(light) = node.light {
            extensions.insert("KHR_lights_punctual".into(), json!({ "light": light }));
        }
        if !node.is_visible {
            extensions.insert("KHR_node_visibility".into(), json!({ "visible": false }));
            self.parts.use_extension("KHR_node_visibility");
        }
        let has_none = extensions.is_empty();
        put(&mut object, "extensions", extensions, has_none);
        object.into()
    }
}

fn light(light: &Light) -> Value {
    let mut object = Object::new();
    put_name(&mut object, &light.name);
    let kind = match light.kind {
        LightKind::Directional => "directional",
        LightKind::Point => "point",
        LightKind::Spot { inner_cone_rad, outer_cone_rad } => {
            object.insert("spot".into(), json!({ "innerConeAngle": inner_cone_rad, "outerConeAngle": outer_cone_rad }));
            "spot"
        }
    };
    object.insert("type".into(), kind.into());
    // Colours of a file end at 1.
    let strongest = light.color_linear.max_element().max(1.0);
    object.insert("color".into(), json!((light.color_linear / strongest).to_array()));
    object.insert("intensity".into(), (light.intensity * strongest).into());
    if let Some(range) = light.range_m {
        object.insert("range".into(), range.into());
    }
    // What glTF has no words for.
    let mut extras = Object::new();
    put(&mut extras, "radius", light.radius_m, light.radius_m == 0.0);
    put(&mut extras, "castShadow", false, light.casts_shadows);
    put(&mut extras, "mode", light.mode.name(), light.mode == LightMode::default());
    let has_none = extras.is_empty();
    put(&mut object, "extras", extras, has_none);
    object.into()
}

fn sampler(sampler: Sampler) -> Value {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::MirroredRepeat => 33648,
        Wrap::ClampToEdge => 33071,
    };
    let min = match (sampler.min_linear, sampler.mip_linear) {
        (false, None) => 9728,
        (true, None) => 9729,
        (false, Some(false)) => 9984,
        (true, Some(false)) => 9985,
        (false, Some(true)) => 9986,
        (true, Some(true)) => 9987,
    };
    json!({
        "magFilter": if sampler.mag_linear { 9729 } else { 9728 },
        "minFilter": min,
        "wrapS": wrap(sampler.wrap_u),
        "wrapT": wrap(sampler.wrap_v),
    })
}

fn as_png(pixels: &Pixels) -> Option<(&'static str, Vec<u8>)> {
    let image = image::RgbaImage::from_raw(pixels.width, pixels.height, pixels.data.clone())?;
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png).ok()?;
    Some(("image/png", bytes))
}

/// The media type of an image and its file.
fn encoded(image: &Image) -> Option<(&'static str, Vec<u8>)> {
    match &image.source {
        ImageSource::Encoded(bytes) => Some((super::image_kind(bytes)?, bytes.to_vec())),
        ImageSource::Pixels(pixels) => as_png(pixels),
        ImageSource::Loading(_) | ImageSource::Monitor(_) | ImageSource::Simulation(_) => None,
    }
}
