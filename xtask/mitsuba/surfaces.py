"""glTF's materials as Mitsuba's shapes and textures, and the reflectance of glTF 2.0, appendix B.

Mitsuba finds surfaces and looks up textures; the reflectance is written here, because none of Mitsuba's own is glTF's: GGX (Walter et
al. 2007) with height-correlated Smith masking (Heitz 2014) and Schlick's Fresnel (1994), over Lambert's diffuse light times 1 - F.
The specular lobe is multiplied by 1 + f0 (1 / E - 1), where E is its directional albedo at f0 = 1 (Kulla & Conty 2017, in the form of
Turquin 2019): the specification leaves light scattered more than once open, and without it rough metals lose a part.
"""

import math

import drjit as dr
import mitsuba as mi
import numpy as np

GRAZING = 0.01
WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}


class Surface(mi.BSDF):
    """Holds textures, which the integrator reads by name: `base`, `orm`, `occlusion`, `normal`, `emission`, and
    `kind`: alpha, 1 if it is drawn from behind too, 1 if it takes no light."""

    def __init__(self, props):
        super().__init__(props)
        names = ("base", "orm", "occlusion", "normal", "emission", "kind", "color")
        self.textures = {name: props[name] for name in names if name in props}
        self.m_flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [self.m_flags]

    def eval_attribute_3(self, name, si, active=True):
        value = self.textures[name].eval(si, active)
        if name == "base" and "color" in self.textures:
            value *= self.textures["color"].eval(si, active)
        return value

    def has_attribute(self, name, active=True):
        return name in self.textures

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


def surface(model, index, has_colors):
    """The description of a material's surface."""
    material = model.doc["materials"][index] if index is not None else {}
    pbr = material.get("pbrMetallicRoughness", {})
    factor = np.array(pbr.get("baseColorFactor", [1, 1, 1, 1]), np.float32)
    mode, cutoff = material.get("alphaMode", "OPAQUE"), material.get("alphaCutoff", 0.5)
    is_double, is_unlit = bool(material.get("doubleSided")), "KHR_materials_unlit" in material.get("extensions", {})

    def kind(alpha):
        alpha = np.ones_like(alpha) if mode == "OPAQUE" else (alpha >= cutoff) if mode == "MASK" else alpha
        rest = [np.full_like(alpha, float(flag), dtype=np.float32) for flag in (is_double, is_unlit)]
        return np.stack([alpha.astype(np.float32), *rest], axis=-1)

    described = {"type": "gltf_surface"}
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
    pbr = material.get("pbrMetallicRoughness", {})
    slots = [pbr.get("baseColorTexture"), pbr.get("metallicRoughnessTexture"), material.get("normalTexture"),
             material.get("emissiveTexture"), material.get("occlusionTexture")]
    sets = {slot.get("extensions", {}).get("KHR_texture_transform", {}).get("texCoord", slot.get("texCoord", 0)) for slot in slots if slot}
    if len(sets) > 1:
        raise ValueError("a material has two sets of texture coordinates")
    return sets.pop() if sets else 0


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


def albedo_table(size=64, samples=4096):
    """E over cos θ and α, both as their square roots: what a lobe of f0 = 1 reflects of light from all around."""
    rng = np.random.default_rng(1)
    u, phi = (np.arange(samples) + 0.5) / samples, rng.random(samples) * math.pi
    cosines = np.maximum((np.arange(size) / (size - 1)) ** 2, 1e-4)
    table = np.zeros((size, size), np.float32)
    for row, rough in enumerate(np.arange(size) / (size - 1)):
        alpha = max(rough, 0.045) ** 2
        h_cos = 1 / np.sqrt(1 + alpha * alpha * u / (1 - u))
        h_sin = np.sqrt(np.maximum(1 - h_cos * h_cos, 0))
        for column, cos in enumerate(cosines):
            v_dot_h = np.sqrt(1 - cos * cos) * h_sin * np.cos(phi) + cos * h_cos
            n_dot_l = 2 * v_dot_h * h_cos - cos
            lit = (v_dot_h > 0) & (n_dot_l > 0)
            n_dot_l = np.maximum(n_dot_l, 1e-6)
            smith = n_dot_l * np.sqrt(cos * cos * (1 - alpha * alpha) + alpha * alpha) + cos * np.sqrt(n_dot_l * n_dot_l * (1 - alpha * alpha) + alpha * alpha)
            table[row, column] = np.mean(np.where(lit, 0.5 / smith * n_dot_l * 4 * v_dot_h / h_cos, 0))
    return mi.Texture2f(mi.TensorXf(table[..., None]), wrap_mode=dr.WrapMode.Clamp)


class Reflectance:
    """The reflectance of points seen from `to_eye`, both sides of everything in world space."""

    def __init__(self, table, base, orm, normal, to_eye):
        # What is interpolated or mapped may be turned away from the eye, where no reflectance is defined: it is turned back to where
        # it is just seen.
        n_dot_v = dr.dot(normal, to_eye)
        normal = dr.select(n_dot_v < GRAZING, dr.normalize(normal + to_eye * (GRAZING - n_dot_v)), normal)
        self.normal, self.to_eye = normal, to_eye
        rough = dr.maximum(orm.y, 0.045)
        self.alpha = dr.square(rough)
        self.diffuse = base * (1 - orm.z)
        self.f0 = dr.lerp(mi.Color3f(0.04), base, orm.z)
        self.n_dot_v = dr.maximum(dr.dot(normal, to_eye), 1e-4)
        albedo = table.eval(mi.Point2f(self._texel(dr.sqrt(self.n_dot_v)), self._texel(rough)))[0]
        self.compensation = 1 + self.f0 * (1 / dr.maximum(albedo, 1e-3) - 1)

    @staticmethod
    def _texel(place, size=64):
        return (place * (size - 1) + 0.5) / size

    def _density(self, half):
        """D; 1 - (n·h)² as a cross product, which loses nothing beside 1."""
        a2 = dr.square(self.alpha)
        n_dot_h2 = dr.square(dr.dot(self.normal, half))
        return a2 / (dr.pi * dr.square(dr.squared_norm(dr.cross(self.normal, half)) + n_dot_h2 * a2))

    def value(self, to_light):
        """The reflectance times n·l, 0 from below."""
        half = dr.normalize(to_light + self.to_eye)
        n_dot_l = dr.maximum(dr.dot(self.normal, to_light), 0)
        a2 = dr.square(self.alpha)
        smith = n_dot_l * dr.sqrt(dr.square(self.n_dot_v) * (1 - a2) + a2) + self.n_dot_v * dr.sqrt(dr.square(n_dot_l) * (1 - a2) + a2)
        grazing = dr.maximum(1 - dr.dot(self.to_eye, half), 0)
        fresnel = self.f0 + (1 - self.f0) * dr.square(dr.square(grazing)) * grazing
        specular = fresnel * self.compensation * self._density(half) * 0.5 / dr.maximum(smith, 1e-7)
        return ((1 - fresnel) * self.diffuse * dr.inv_pi + specular) * n_dot_l

    def pdf(self, to_light):
        """The density of `sample`: half of it as the cosine, half as the half vectors that the eye sees."""
        half = dr.normalize(to_light + self.to_eye)
        n_dot_l, a2 = dr.dot(self.normal, to_light), dr.square(self.alpha)
        masking = 2 / (self.n_dot_v + dr.sqrt(dr.square(self.n_dot_v) * (1 - a2) + a2))
        return dr.select(n_dot_l > 0, 0.5 * n_dot_l * dr.inv_pi + 0.5 * 0.25 * masking * self._density(half), 0)

    def sample(self, which, uv):
        """A direction to light; half vectors after Heitz, "Sampling the GGX Distribution of Visible Normals" (2018)."""
        frame = mi.Frame3f(self.normal)
        around = frame.to_world(mi.warp.square_to_cosine_hemisphere(uv))
        eye = frame.to_local(self.to_eye)
        eye = dr.normalize(mi.Vector3f(self.alpha * eye.x, self.alpha * eye.y, dr.maximum(eye.z, 1e-4)))
        across = dr.square(eye.x) + dr.square(eye.y)
        side = dr.select(across > 1e-12, mi.Vector3f(-eye.y, eye.x, 0) * dr.rsqrt(dr.maximum(across, 1e-12)), mi.Vector3f(1, 0, 0))
        other = dr.cross(eye, side)
        radius, (s, c) = dr.sqrt(uv.x), dr.sincos(2 * dr.pi * uv.y)
        first, share = radius * c, 0.5 * (1 + eye.z)
        second = (1 - share) * dr.sqrt(dr.maximum(1 - first * first, 0)) + share * radius * s
        third = dr.sqrt(dr.maximum(1 - first * first - second * second, 0))
        half = side * first + other * second + eye * third
        half = frame.to_world(dr.normalize(mi.Vector3f(self.alpha * half.x, self.alpha * half.y, dr.maximum(half.z, 1e-6))))
        mirrored = 2 * dr.dot(self.to_eye, half) * half - self.to_eye
        return dr.normalize(dr.select(which < 0.5, around, mirrored))


def register():
    mi.register_bsdf("gltf_surface", Surface)
