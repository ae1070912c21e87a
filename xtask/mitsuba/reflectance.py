"""The reflectance of glTF 2.0, appendix B, with anisotropy, diffuse transmission, and specular light of any colour.

It is written here because none of Mitsuba's own is glTF's: GGX (Walter et al. 2007), stretched as KHR_materials_anisotropy has it (Burley
2012), with height-correlated Smith masking (Heitz 2014) and Schlick's Fresnel (1994), over Lambert's diffuse light times 1 - F.
The specular lobe is multiplied by 1 + f0 (1 / E - 1), where E is its directional albedo at f0 = 1 (Kulla & Conty 2017, in the form of
Turquin 2019): the specification leaves light scattered more than once open, and without it rough metals lose a part.
"""

import math

import drjit as dr
import mitsuba as mi
import numpy as np

GRAZING = 0.01
ROUGHNESS_MIN = 0.045
# How many strengths of anisotropy there are tables for.
STRENGTHS = 9


def albedos(eye, along, across, samples=1024):
    """E of directions to the eye (rows, z up) and alphas: the mean of G2 / G1 over the half vectors that the eye sees."""
    u = (np.arange(samples) + 0.5) / samples
    phi = 2 * math.pi * ((np.arange(samples) * 0.6180339887498949) % 1)
    stretched = eye * [along, across, 1]
    stretched /= np.linalg.norm(stretched, axis=1, keepdims=True)
    side = np.stack([-stretched[:, 1], stretched[:, 0], np.zeros(len(eye))], axis=1)
    flat = np.linalg.norm(side, axis=1, keepdims=True)
    side = np.where(flat > 1e-9, side / np.maximum(flat, 1e-9), [[1.0, 0, 0]])
    other = np.cross(stretched, side)
    first, share = np.sqrt(u) * np.cos(phi), 0.5 * (1 + stretched[:, 2:])
    second = (1 - share) * np.sqrt(1 - first * first) + share * np.sqrt(u) * np.sin(phi)
    third = np.sqrt(np.maximum(1 - first * first - second * second, 0))
    half = side[:, None] * first[None, :, None] + other[:, None] * second[..., None] + stretched[:, None] * third[..., None]
    half = half * [along, across, 1]
    half /= np.linalg.norm(half, axis=2, keepdims=True)
    light = 2 * (half * eye[:, None]).sum(2, keepdims=True) * half - eye[:, None]
    n_dot_v, n_dot_l = eye[:, None, 2], np.maximum(light[..., 2], 1e-6)
    eye_length = np.linalg.norm(eye * [along, across, 1], axis=1)[:, None]
    light_length = np.linalg.norm(light * [along, across, 1], axis=2)
    ratio = n_dot_l * (n_dot_v + eye_length) / (n_dot_l * eye_length + n_dot_v * light_length)
    return np.where(light[..., 2] > 0, ratio, 0).mean(1)


class Albedos:
    """E over √cos θ, roughness, and cos² of the angle between the eye and the tangent; one table for each strength of anisotropy."""

    SIZE = (5, 48, 32)

    def __init__(self, is_stretched):
        turns, roughs, cosines = self.SIZE
        cos = np.maximum((np.arange(cosines) / (cosines - 1)) ** 2, 1e-4)
        sin, turn = np.sqrt(1 - cos * cos), np.arange(turns) / (turns - 1)
        eye = np.stack([np.sqrt(turn)[:, None] * sin, np.sqrt(1 - turn)[:, None] * sin, np.broadcast_to(cos, (turns, cosines))], axis=-1)
        self.tables = []
        for strength in np.arange(STRENGTHS) / (STRENGTHS - 1):
            table = np.zeros((*self.SIZE, 1), np.float32)
            for row, rough in enumerate(np.arange(roughs) / (roughs - 1)):
                across = max(rough, ROUGHNESS_MIN) ** 2
                along = across + (1 - across) * strength * strength
                table[:, row, :, 0] = albedos(eye.reshape(-1, 3), along, across).reshape(turns, cosines)
            self.tables.append(mi.Texture3f(mi.TensorXf(table), wrap_mode=dr.WrapMode.Clamp))
            if not is_stretched:
                break

    def at(self, eye, rough, strength):
        flat = dr.square(eye.x) + dr.square(eye.y)
        turn = dr.select(flat > 1e-12, dr.square(eye.x) / dr.maximum(flat, 1e-12), 0.5)
        place = [(value * (size - 1) + 0.5) / size for value, size in zip((dr.sqrt(eye.z), rough, turn), self.SIZE[::-1])]
        place, total = mi.Point3f(place), mi.Float(0)
        for number, table in enumerate(self.tables):
            weight = dr.maximum(1 - dr.abs(strength * (STRENGTHS - 1) - number), 0) if len(self.tables) > 1 else 1
            total += weight * table.eval(place)[0]
        return total


class Reflectance:
    """The reflectance of what is hit, and the share of light that comes through diffusely; both sides of everything in world space."""

    def __init__(self, world, hit):
        # What is interpolated or mapped may be turned away from the eye, where no reflectance is defined: it is turned back to where
        # it is just seen.
        normal, self.has_stretch, self.has_passed = hit.normal, "stretch" in world.features, "passed" in world.features
        n_dot_v = dr.dot(normal, hit.to_eye)
        normal = dr.select(n_dot_v < GRAZING, dr.normalize(normal + hit.to_eye * (GRAZING - n_dot_v)), normal)
        self.normal, self.frame = normal, mi.Frame3f(normal)
        rough = dr.maximum(hit.orm.y, ROUGHNESS_MIN)
        self.across = dr.square(rough)
        self.along, strength = self.across, mi.Float(0)
        if self.has_stretch:
            strength = hit.stretch.z
            self.along = dr.lerp(self.across, 1, dr.square(strength))
            tangent = hit.tangent * hit.stretch.x + hit.bitangent * hit.stretch.y
            tangent -= normal * dr.dot(normal, tangent)
            tangent = dr.select(dr.squared_norm(tangent) > 1e-12, dr.normalize(tangent), self.frame.s)
            self.frame = mi.Frame3f(tangent, dr.cross(normal, tangent), normal)
        self.eye = self.frame.to_local(hit.to_eye)
        self.eye.z = dr.maximum(self.eye.z, 1e-4)
        self.diffuse, self.f0 = hit.base * (1 - hit.orm.z), dr.lerp(hit.specular, hit.base, hit.orm.z)
        self.is_dielectric = "specular" in world.features
        # Light from behind takes a part of the place of diffuse reflectance.
        self.passed, self.back = mi.Color3f(0), mi.Float(0)
        if self.has_passed:
            self.passed = hit.passed * hit.shares.y * (1 - hit.orm.z)
            self.diffuse *= 1 - hit.shares.y
            self.back = dr.select(hit.shares.y > 0, mi.Float(0.4), 0)
        albedo = world.albedos.at(self.eye, rough, strength)
        self.compensation = 1 + self.f0 * (1 / dr.maximum(albedo, 1e-3) - 1)
        self.eye_length = self._length(self.eye)

    def _length(self, direction):
        return dr.norm(mi.Vector3f(self.along * direction.x, self.across * direction.y, direction.z))

    def _density(self, half):
        """D."""
        inner = dr.square(half.x / self.along) + dr.square(half.y / self.across) + dr.square(half.z)
        return dr.rcp(dr.pi * self.along * self.across * dr.square(inner))

    def value(self, to_light):
        """The reflectance times n·l; from below what comes through."""
        light = self.frame.to_local(to_light)
        is_front = light.z > 0
        light.z = dr.abs(light.z)
        half = dr.normalize(light + self.eye)
        smith = light.z * self.eye_length + self.eye.z * self._length(light)
        grazing = dr.maximum(1 - dr.dot(self.eye, half), 0)
        fresnel = self.f0 + (1 - self.f0) * dr.square(dr.square(grazing)) * grazing
        specular = fresnel * self.compensation * self._density(half) * 0.5 / dr.maximum(smith, 1e-7)
        entering = 1 - (mi.Color3f(dr.max(fresnel)) if self.is_dielectric else fresnel)
        above = entering * self.diffuse * dr.inv_pi + specular
        return dr.select(is_front, above, entering * self.passed * dr.inv_pi) * light.z

    def pdf(self, to_light):
        """The density of `sample`: a part below; of that above half as the cosine, half as the half vectors that the eye sees."""
        light = self.frame.to_local(to_light)
        half = dr.normalize(light + self.eye)
        masking = 2 / (self.eye.z + self.eye_length)
        above = 0.5 * light.z * dr.inv_pi + 0.5 * 0.25 * masking * self._density(half)
        return dr.select(light.z > 0, (1 - self.back) * above, self.back * -light.z * dr.inv_pi)

    def sample(self, which, uv):
        """A direction to light, and whether there is one; half vectors after Heitz, "Sampling the GGX Distribution of Visible Normals"
        (2018)."""
        around = mi.warp.square_to_cosine_hemisphere(uv)
        eye = dr.normalize(mi.Vector3f(self.along * self.eye.x, self.across * self.eye.y, self.eye.z))
        flat = dr.square(eye.x) + dr.square(eye.y)
        side = dr.select(flat > 1e-12, mi.Vector3f(-eye.y, eye.x, 0) * dr.rsqrt(dr.maximum(flat, 1e-12)), mi.Vector3f(1, 0, 0))
        other = dr.cross(eye, side)
        radius, (s, c) = dr.sqrt(uv.x), dr.sincos(2 * dr.pi * uv.y)
        first, share = radius * c, 0.5 * (1 + eye.z)
        second = (1 - share) * dr.sqrt(dr.maximum(1 - first * first, 0)) + share * radius * s
        third = dr.sqrt(dr.maximum(1 - first * first - second * second, 0))
        half = side * first + other * second + eye * third
        half = dr.normalize(mi.Vector3f(self.along * half.x, self.across * half.y, dr.maximum(half.z, 1e-6)))
        mirrored = 2 * dr.dot(self.eye, half) * half - self.eye
        is_below, is_around = which < self.back, which < self.back + 0.5 * (1 - self.back)
        found = dr.select(is_below, -around, dr.select(is_around, around, mirrored))
        return self.frame.to_world(dr.normalize(found)), is_around | (mirrored.z > 0)
