"""glTF's materials as Mitsuba's shapes and textures.

Mitsuba finds surfaces and looks up textures; what they reflect is in `reflectance.py`, what they let through in `glass.py`.
"""

import math

import drjit as dr
import mitsuba as mi
import numpy as np

WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}


# What a surface has of an extension that its material does not use.
WITHOUT = {"specular": [0.04] * 3, "stretch": [0, 0, 0], "passed": [0, 0, 0], "shares": [0, 0, 0], "iors": [1.5] * 3, "absorption": [0, 0, 0]}


class Surface(mi.BSDF):
    """Holds textures, which the integrator reads by name: `base`, `orm`, `occlusion`, `normal`, `emission`, and
    `kind`: alpha, 1 if it is drawn from behind too, 1 if it takes no light. Of extensions there are
    `specular`: what is not metal reflects at normal incidence;
    `stretch`: along which direction of the tangents' plane highlights are stretched (two numbers), and how strongly;
    `passed`: the colour of light that comes through diffusely;
    `shares`: of light that comes through as through glass, of light that comes through diffusely, 1 if there is a volume;
    `iors`: refractive indices of red, green and blue; `absorption`: in the volume, for each metre."""

    def __init__(self, props):
        super().__init__(props)
        names = ("base", "orm", "occlusion", "normal", "emission", "kind", "color", *WITHOUT)
        self.textures = {name: props[name] for name in names if name in props}
        self.m_flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [self.m_flags]

    def eval_attribute_3(self, name, si, active=True):
        if name not in self.textures:
            return mi.Color3f(WITHOUT[name])
        value = self.textures[name].eval(si, active)
        if name == "base" and "color" in self.textures:
            value *= self.textures["color"].eval(si, active)
        return value

    def has_attribute(self, name, active=True):
        return name in self.textures or name in WITHOUT

    def eval_diffuse_reflectance(self, si, active=True):
        return self.eval_attribute_3("base", si, active)

    def sample(self, *arguments):
        raise NotImplementedError

    eval = pdf = eval_pdf = sample

    def to_string(self):
        return "Surface[]"


def plain(rgb):
    """A texture of one texel."""
    return bitmap(np.array(rgb, np.float32).reshape(1, 1, 3))


def bitmap(pixels, **options):
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(pixels, np.float32)), "raw": True, "format": "variant", **options}


def decoded(model, slot, is_srgb):
    """The texels of a slot's image, linear, with alpha."""
    stream = mi.MemoryStream()
    stream.write(model.image(slot["index"]))
    stream.seek(0)
    image = mi.Bitmap(stream)
    image.set_srgb_gamma(is_srgb)
    return np.array(image.convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.Float32, srgb_gamma=False))


def texture(model, slot, pixels):
    """Texels with the slot's sampler and transform."""
    sampler = model.doc["textures"][slot["index"]].get("sampler")
    sampler = model.doc["samplers"][sampler] if sampler is not None else {}
    wrap = WRAPS[sampler.get("wrapS", 10497)]
    options = {"wrap_mode": wrap, "filter_type": "nearest" if sampler.get("magFilter") == 9728 else "bilinear"}
    moved = slot.get("extensions", {}).get("KHR_texture_transform")
    if moved:
        (x, y), (sx, sy), turn = moved.get("offset", [0, 0]), moved.get("scale", [1, 1]), moved.get("rotation", 0.0)
        c, s = math.cos(turn), math.sin(turn)
        rows = [[c * sx, s * sy, x], [-s * sx, c * sy, y], [0, 0, 1]]
        options["to_uv"] = mi.ScalarTransform3f(rows) if hasattr(mi, "ScalarTransform3f") else rows
    return bitmap(pixels, **options)


def extensions(model, material):
    """The textures of the extensions that a material uses."""
    known = material.get("extensions", {})
    described = {}
    if "KHR_materials_anisotropy" in known:
        stretched = known["KHR_materials_anisotropy"]
        strength, turn = stretched.get("anisotropyStrength", 0.0), stretched.get("anisotropyRotation", 0.0)
        slot = stretched.get("anisotropyTexture")
        pixels = decoded(model, slot, False)[..., :3] if slot else np.array([[[1, 0.5, 1]]], np.float32)
        x, y = pixels[..., 0] * 2 - 1, pixels[..., 1] * 2 - 1
        c, s = math.cos(turn), math.sin(turn)
        pixels = np.stack([c * x - s * y, s * x + c * y, strength * pixels[..., 2]], axis=-1)
        described["stretch"] = texture(model, slot, pixels) if slot else bitmap(pixels)
    if "KHR_materials_diffuse_transmission" in known:
        passing = known["KHR_materials_diffuse_transmission"]
        if any(name.endswith("Texture") for name in passing):
            raise ValueError("textures of diffuse transmission are not read")
        described["passed"] = plain(passing.get("diffuseTransmissionColorFactor", [1, 1, 1]))
    index = known.get("KHR_materials_ior", {}).get("ior", 1.5)
    if "KHR_materials_ior" in known:
        described["specular"] = plain([((index - 1) / (index + 1)) ** 2] * 3)
    volume, transmission = known.get("KHR_materials_volume", {}), known.get("KHR_materials_transmission", {})
    if "transmissionTexture" in transmission:
        raise ValueError("textures of transmission are not read")
    if transmission or "passed" in described:
        diffuse = known.get("KHR_materials_diffuse_transmission", {}).get("diffuseTransmissionFactor", 0.0)
        described["shares"] = plain([transmission.get("transmissionFactor", 0.0), diffuse, float(volume.get("thicknessFactor", 0) > 0)])
        # Red and blue are refracted less and more (KHR_materials_dispersion).
        spread = (index - 1) * 0.025 * known.get("KHR_materials_dispersion", {}).get("dispersion", 0.0)
        described["iors"] = plain([index - spread, index, index + spread])
        reach = volume.get("attenuationDistance", math.inf)
        described["absorption"] = plain(-np.log(np.maximum(volume.get("attenuationColor", [1, 1, 1]), 1e-6)) / reach)
    return described


def slots(material):
    """The slots of a material's textures."""
    pbr, known = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
    gloss = known.get("KHR_materials_pbrSpecularGlossiness", {})
    found = [pbr.get("baseColorTexture"), pbr.get("metallicRoughnessTexture"), material.get("normalTexture"),
             material.get("emissiveTexture"), material.get("occlusionTexture"), gloss.get("diffuseTexture"),
             gloss.get("specularGlossinessTexture"), known.get("KHR_materials_anisotropy", {}).get("anisotropyTexture")]
    return [slot for slot in found if slot]


def read_glossiness(model, gloss, described):
    """What KHR_materials_pbrSpecularGlossiness has in place of metals and roughness. Its diffuse light is what enters below the
    specular light of its strongest channel, as that of any dielectric: 1 - max F, at normal incidence the extension's 1 - max specular."""
    color, glossiness = np.array(gloss.get("specularFactor", [1, 1, 1]), np.float32), gloss.get("glossinessFactor", 1.0)
    if "specularGlossinessTexture" in gloss:
        slot = gloss["specularGlossinessTexture"]
        pixels = decoded(model, slot, True)
        rough = 1 - pixels[..., 3] * glossiness
        described["specular"] = texture(model, slot, pixels[..., :3] * color)
        described["orm"] = texture(model, slot, np.stack([np.ones_like(rough), rough, np.zeros_like(rough)], axis=-1))
    else:
        described["specular"], described["orm"] = plain(color), plain([1, 1 - glossiness, 0])


def surface(model, index, has_colors):
    """The description of a material's surface."""
    material = model.doc["materials"][index] if index is not None else {}
    pbr, gloss = material.get("pbrMetallicRoughness", {}), material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness")
    if gloss is not None:
        pbr = {"baseColorFactor": gloss.get("diffuseFactor", [1, 1, 1, 1])}
        if "diffuseTexture" in gloss:
            pbr["baseColorTexture"] = gloss["diffuseTexture"]
    factor = np.array(pbr.get("baseColorFactor", [1, 1, 1, 1]), np.float32)
    mode, cutoff = material.get("alphaMode", "OPAQUE"), material.get("alphaCutoff", 0.5)
    is_double, is_unlit = bool(material.get("doubleSided")), "KHR_materials_unlit" in material.get("extensions", {})

    def kind(alpha):
        alpha = np.ones_like(alpha) if mode == "OPAQUE" else (alpha >= cutoff) if mode == "MASK" else alpha
        rest = [np.full_like(alpha, float(flag), dtype=np.float32) for flag in (is_double, is_unlit)]
        return np.stack([alpha.astype(np.float32), *rest], axis=-1)

    described = {"type": "gltf_surface", **extensions(model, material)}
    if "baseColorTexture" in pbr:
        pixels = decoded(model, pbr["baseColorTexture"], True) * factor
        described["base"] = texture(model, pbr["baseColorTexture"], pixels[..., :3])
        described["kind"] = texture(model, pbr["baseColorTexture"], kind(pixels[..., 3]))
    else:
        described["base"], described["kind"] = plain(factor[:3]), plain(kind(factor[3:4])[0])
    rough, metal = pbr.get("roughnessFactor", 1.0), pbr.get("metallicFactor", 1.0)
    if "metallicRoughnessTexture" in pbr:
        pixels = decoded(model, pbr["metallicRoughnessTexture"], False)[..., :3] * np.array([1, rough, metal], np.float32)
        described["orm"] = texture(model, pbr["metallicRoughnessTexture"], pixels)
    else:
        described["orm"] = plain([1, rough, metal])
    if gloss is not None:
        read_glossiness(model, gloss, described)
    if "occlusionTexture" in material:
        strength = material["occlusionTexture"].get("strength", 1.0)
        pixels = 1 + strength * (decoded(model, material["occlusionTexture"], False)[..., :1] - 1)
        described["occlusion"] = texture(model, material["occlusionTexture"], np.repeat(pixels, 3, axis=-1))
    else:
        described["occlusion"] = plain([1, 1, 1])
    if "normalTexture" in material:
        scale = material["normalTexture"].get("scale", 1.0)
        pixels = (decoded(model, material["normalTexture"], False)[..., :3] * 2 - 1) * np.array([scale, scale, 1], np.float32)
        described["normal"] = texture(model, material["normalTexture"], pixels)
    else:
        described["normal"] = plain([0, 0, 1])
    strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    emissive = np.array(material.get("emissiveFactor", [0, 0, 0]), np.float32) * strength
    if "emissiveTexture" in material:
        described["emission"] = texture(model, material["emissiveTexture"], decoded(model, material["emissiveTexture"], True)[..., :3] * emissive)
    else:
        described["emission"] = plain(emissive)
    if has_colors:
        described["color"] = {"type": "mesh_attribute", "name": "vertex_color"}
    return described


def uv_set(model, index):
    """Which set of texture coordinates a material uses; Mitsuba has one a mesh, so it must be the same for all its textures."""
    material = model.doc["materials"][index] if index is not None else {}
    sets = {slot.get("extensions", {}).get("KHR_texture_transform", {}).get("texCoord", slot.get("texCoord", 0)) for slot in slots(material)}
    if len(sets) > 1:
        raise ValueError("a material has two sets of texture coordinates")
    return sets.pop() if sets else 0


def features(model):
    """What reflectance and the integrator need beyond core glTF: others pay nothing for it."""
    used = {name for material in model.doc.get("materials", []) for name in material.get("extensions", {})}
    wanted = {
        "stretch": {"KHR_materials_anisotropy"},
        "passed": {"KHR_materials_diffuse_transmission"},
        "glass": {"KHR_materials_transmission"},
        "specular": {"KHR_materials_pbrSpecularGlossiness", "KHR_materials_ior"},
        "dispersion": {"KHR_materials_dispersion"},
    }
    return {feature for feature, names in wanted.items() if names & used}


def shapes(model):
    """Mitsuba's meshes of a model."""
    made, surfaces = {}, {}
    for number, primitive in enumerate(model.primitives):
        key = (primitive["material"], primitive["colors"] is not None)
        if key not in surfaces:
            surfaces[key] = mi.load_dict(surface(model, *key))
        props = mi.Properties()
        props["bsdf"] = surfaces[key]
        uv = primitive["uv"][uv_set(model, key[0])] if primitive["uv"] else None
        positions, faces = primitive["positions"], primitive["faces"]
        mesh = mi.Mesh("mesh", len(positions), len(faces), props=props, has_vertex_normals=True, has_vertex_texcoords=uv is not None)
        tangents = primitive["tangents"] if primitive["tangents"] is not None else tangents_of(primitive, uv)
        mesh.add_attribute("vertex_tangent", 3, tangents[:, :3].astype(np.float32).ravel())
        mesh.add_attribute("vertex_sign", 1, tangents[:, 3].astype(np.float32).ravel())
        if key[1]:
            mesh.add_attribute("vertex_color", 3, primitive["colors"][:, :3].astype(np.float32).ravel())
        values = mi.traverse(mesh)
        values["vertex_positions"] = positions.astype(np.float32).ravel()
        values["vertex_normals"] = primitive["normals"].astype(np.float32).ravel()
        values["faces"] = faces.ravel()
        if uv is not None:
            # Mitsuba's bitmaps begin at the top, as glTF's do.
            values["vertex_texcoords"] = uv.astype(np.float32).ravel()
        values.update()
        made[f"mesh{number}"] = mesh
    return made


def tangents_of(primitive, uv):
    """Tangents of a mesh without: the directions of growing u, averaged over the triangles of a vertex (Lengyel 2001)."""
    positions, faces, normals = primitive["positions"], primitive["faces"], primitive["normals"]
    tangents, signs = np.zeros_like(positions), np.ones((len(positions), 1))
    if uv is not None:
        along, across = positions[faces[:, 1:]] - positions[faces[:, :1]], uv[faces[:, 1:]] - uv[faces[:, :1]]
        area = across[:, 0, 0] * across[:, 1, 1] - across[:, 1, 0] * across[:, 0, 1]
        scale = np.where(np.abs(area) > 1e-20, np.sign(area), 0)[:, None]
        by_u = (along[:, 0] * across[:, 1, 1:] - along[:, 1] * across[:, 0, 1:]) * scale
        for corner in range(3):
            np.add.at(tangents, faces[:, corner], by_u)
            # v grows downwards in glTF's textures, and bitangents point to where it does not.
            signs[faces[:, corner], 0] = np.where(area > 0, -1, 1)
    tangents -= normals * (tangents * normals).sum(1, keepdims=True)
    length = np.linalg.norm(tangents, axis=1, keepdims=True)
    fallback = np.cross(normals, np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    return np.hstack([np.where(length > 1e-12, tangents / np.maximum(length, 1e-30), fallback), signs])


def register():
    mi.register_bsdf("gltf_surface", Surface)
