"""Pictures of glTF files by path tracing with Mitsuba 3 (Jakob et al. 2022): what `cargo xtask fidelity` takes for the truth.

usage: truth.py JOBS.json

JOBS.json is a list of objects with `model`, `world_from_view` (rows), `fov_y_deg`, `size` (pixels), `samples` (a pixel),
`environment` (an equirectangular .hdr, or null), `truth` and `direct` (the .exr files to write): radiance with associated alpha. `truth`
has shadows of everything and light that was reflected up to four times; `direct` has lamps with their shadows and all of the
environment, whatever stands before it, times the file's own occlusion: what a rasterizer shades that knows nothing of its surroundings.

Where it differs from a full path tracer: shadow rays and reflected rays take masked surfaces for whole, and see both sides of
everything, of glass too; reflected rays go on through glass. Glass is smooth. Blended surfaces are covered by chance. There is no
filter but the pixel's square.
"""

import functools
import json
import math
import sys
import time

import mitsuba as mi

mi.set_variant("llvm_ad_rgb")

import drjit as dr
import numpy as np

import glass
import gltf
import reflectance
import surfaces

# How often light is reflected after the first time; surfaces that a ray may pass; rays of a pixel at a time; directions to the
# environment for each, with shadows and without.
REFLECTIONS = 4
LAYERS = 6
BATCH = 16
DIRECTIONS = 4
OPEN_DIRECTIONS = 12


class Numbers:
    """Numbers from 0 to 1 for each ray: the first seven of a sequence that fills seven dimensions evenly (Roberts 2018: multiples of
    powers of the root of x^8 = x + 1), shifted by chance for each pixel (Cranley & Patterson 1976); then by chance alone."""

    def __init__(self, pixels, batch):
        count = pixels * BATCH
        index = dr.arange(mi.UInt32, count)
        self.number = mi.Float(index % BATCH + dr.opaque(mi.UInt32, BATCH * batch))
        # The same numbers for all rays of a pixel, whatever the batch.
        self.shifts = mi.PCG32(size=count, initstate=mi.UInt64(index // BATCH), initseq=mi.UInt64(3))
        self.rest = mi.PCG32(size=count, initstate=dr.opaque(mi.UInt64, 17 + batch))
        root = 1.0
        for _ in range(64):
            root = (1 + root) ** (1 / 8)
        self.steps = [root ** -power for power in range(1, 8)]

    def next_float32(self):
        if not self.steps:
            return self.rest.next_float32()
        place = self.shifts.next_float32() + self.number * self.steps.pop(0)
        return place - dr.floor(place)


class World:
    """What is drawn: Mitsuba's scene, punctual lights, what its materials need beyond core glTF, tables of albedo, and which colour's
    refraction is followed, 1 where they are refracted alike."""

    def __init__(self, scene, model):
        self.scene, self.lights, self.features, self.channel = scene, model.lights, surfaces.features(model), 1
        self.albedos = tables("stretch" in self.features)


@functools.cache
def tables(is_stretched):
    return reflectance.Albedos(is_stretched)


class Hit:
    """What a ray meets, turned towards where it comes from."""

    def __init__(self, world, ray, active):
        self.si = world.scene.ray_intersect(ray, active)
        self.valid = active & self.si.is_valid()
        bsdf = self.si.bsdf(ray)
        read = lambda name: bsdf.eval_attribute_3(name, self.si, self.valid)
        self.base, self.orm, self.emission, self.kind = read("base"), read("orm"), read("emission"), read("kind")
        self.occlusion = read("occlusion").x
        self.to_eye = -ray.d
        self.is_front = dr.dot(self.si.n, self.to_eye) > 0
        shape, normal = self.si.shape, self.si.sh_frame.n
        tangent = shape.eval_attribute_3("vertex_tangent", self.si, self.valid)
        tangent = mi.Vector3f(tangent.x, tangent.y, tangent.z)
        tangent = dr.normalize(tangent - normal * dr.dot(normal, tangent))
        bitangent = dr.cross(normal, tangent) * shape.eval_attribute_1("vertex_sign", self.si, self.valid)
        mapped = read("normal")
        is_mapped = (mapped.x != 0) | (mapped.y != 0)
        normal = dr.select(is_mapped, dr.normalize(tangent * mapped.x + bitangent * mapped.y + normal * mapped.z), normal)
        self.normal = dr.select(self.is_front, normal, -normal)
        self.tangent, self.bitangent, self.specular = tangent, bitangent, mi.Color3f(0.04)
        if "specular" in world.features:
            self.specular = read("specular")
        if "stretch" in world.features:
            self.stretch = read("stretch")
        if world.features & {"passed", "glass"}:
            self.shares, self.passed, self.iors, self.absorption = read("shares"), read("passed"), read("iors"), read("absorption")


def first_hit(world, ray, rng, layers):
    """The first surface that is drawn: single-sided ones are not from behind, others as their alpha says."""
    hit, active, passes = Hit(world, ray, mi.Bool(True)), mi.Bool(True), mi.Bool(True)
    for _ in range(layers - 1):
        # What a ray was stopped by stops it for good.
        passes &= hit.valid & (~(hit.is_front | (hit.kind.y > 0.5)) | (rng.rest.next_float32() >= hit.kind.x))
        ray = mi.Ray3f(dr.select(passes, hit.si.spawn_ray(ray.d).o, ray.o), ray.d)
        hit = Hit(world, ray, active)
    return hit, ray


def lamps(world, hit, bsdf, active):
    """Light of punctual lights; glTF's windows for range and cone (KHR_lights_punctual)."""
    total = mi.Color3f(0)
    for light in world.lights:
        axis = mi.Vector3f(light["direction"].tolist())
        if light["type"] == "directional":
            to_light, strength, reach = -axis, mi.Float(1), mi.Float(math.inf)
        else:
            away = mi.Point3f(light["position"].tolist()) - hit.si.p
            d2 = dr.maximum(dr.squared_norm(away), 1e-8)
            to_light, reach = away * dr.rsqrt(d2), dr.sqrt(d2) * 0.9995
            strength = dr.maximum(1 - dr.square(d2 / light["range"] ** 2), 0) / d2
            if light["type"] == "spot":
                inner, outer = math.cos(light["inner"]), math.cos(light["outer"])
                strength *= dr.square(dr.clip((dr.dot(-to_light, axis) - outer) / max(inner - outer, 1e-3), 0, 1))
        lit = active & (strength > 0) & ((dr.dot(bsdf.normal, to_light) > 0) | (bsdf.back > 0))
        shadow = hit.si.spawn_ray(to_light)
        shadow.maxt = reach
        lit &= ~world.scene.ray_test(shadow, lit)
        total += dr.select(lit, bsdf.value(to_light) * strength * mi.Color3f(light["rgb"].tolist()), 0)
    return total


def sky_radiance(environment, direction, active):
    """The radiance of the environment in a direction."""
    sky = dr.zeros(mi.SurfaceInteraction3f)
    sky.wi, sky.wavelengths = -direction, []
    return environment.eval(sky, active)


def radiance(world, ray, rng, reflections, has_shadows, layers):
    """Radiance along rays, and whether they meet anything. `has_shadows` is of the environment."""
    scene, environment, has_glass = world.scene, world.scene.environment(), "glass" in world.features
    hit, ray = first_hit(world, ray, rng, layers)
    coverage, active = dr.select(hit.valid, mi.Float(1), mi.Float(0)), mi.Bool(hit.valid)
    total, through = mi.Color3f(0), mi.Color3f(1)
    if has_glass:
        meet = lambda ray: Hit(world, ray, mi.Bool(coverage > 0))
        hit, ray, through, passed = glass.behind(meet, hit, ray, world.channel, rng)
        active &= hit.valid
        if environment is not None:
            escaped = passed & ~hit.valid
            total += dr.select(escaped, through * sky_radiance(environment, ray.d, escaped), 0)
    for bounce in range(reflections):
        is_unlit = hit.kind.z > 0.5
        total += dr.select(active, through * (hit.emission + dr.select(is_unlit, hit.base, 0)), 0)
        active &= ~is_unlit
        bsdf = reflectance.Reflectance(world, hit)
        total += through * lamps(world, hit, bsdf, active)
        # What a file bakes stands for what casts shadows.
        openness = mi.Float(1) if has_shadows else hit.occlusion
        # As many directions by the environment's brightness and by reflectance, weighed against each other by the balance heuristic
        # (Veach & Guibas 1995). Without shadows they cost no rays.
        by_light, by_surface = (DIRECTIONS, 1) if has_shadows else (OPEN_DIRECTIONS, OPEN_DIRECTIONS)
        by_light = 1 if bounce > 0 else by_light
        for number in range(by_light if environment is not None else 0):
            uv = mi.Point2f((number + rng.next_float32()) / by_light, rng.next_float32())
            found, light = scene.sample_emitter_direction(hit.si, uv, False, active)
            lit = active & (found.pdf > 0)
            if has_shadows:
                lit &= ~scene.ray_test(hit.si.spawn_ray(found.d), lit)
            weight = found.pdf / (by_light * found.pdf + by_surface * bsdf.pdf(found.d))
            total += dr.select(lit, through * light * bsdf.value(found.d) * weight * openness, 0)
        last, before = hit, through
        for number in range(by_surface):
            uv = mi.Point2f((number + rng.next_float32()) / by_surface, rng.next_float32())
            direction, is_found = bsdf.sample(rng.next_float32(), uv)
            pdf = bsdf.pdf(direction)
            goes_on = active & is_found & (pdf > 1e-9)
            through = before * dr.select(goes_on, bsdf.value(direction) / pdf, 0)
            escaped, passed = goes_on, mi.Bool(False)
            if has_shadows:
                ray = last.si.spawn_ray(direction)
                hit = Hit(world, ray, goes_on)
                if has_glass:
                    meet = lambda ray: Hit(world, ray, goes_on)
                    hit, ray, left, passed = glass.behind(meet, hit, ray, world.channel, rng)
                    through, direction = through * left, ray.d
                escaped = goes_on & ~hit.valid
            if environment is not None:
                found = dr.zeros(mi.DirectionSample3f)
                found.d, found.emitter = direction, mi.EmitterPtr(environment)
                other = environment.pdf_direction(last.si, found, escaped)
                # What comes through glass has no other way to be found.
                weight = dr.select(passed, 1 / by_surface, pdf / (by_light * other + by_surface * pdf))
                total += dr.select(escaped, through * sky_radiance(environment, direction, escaped) * openness * weight, 0)
        active = goes_on
        if not has_shadows:
            break
        active &= hit.valid
    return total, coverage


def rays(job, rng, samples):
    """Rays through random places of all pixels, `samples` each."""
    width, height = job["size"]
    index = dr.arange(mi.UInt32, width * height * samples) // samples
    x = mi.Float(index % width) + rng.next_float32()
    y = mi.Float(index // width) + rng.next_float32()
    world = np.array(job["world_from_view"], float)[:3]
    right, up, ahead, eye = ((column * sign).tolist() for column, sign in zip(world.T, (1, 1, -1, 1)))
    slope = math.tan(math.radians(job["fov_y_deg"]) / 2)
    u, v = (2 * x - width) / height * slope, (height - 2 * y) / height * slope
    direction = mi.Vector3f(ahead) + mi.Vector3f(right) * u + mi.Vector3f(up) * v
    return mi.Ray3f(mi.Point3f(eye), dr.normalize(direction))


def picture(world, job, reflections, has_shadows, layers):
    width, height = job["size"]
    total = np.zeros((height, width, 4))
    batches = max(1, job["samples"] // BATCH)
    for batch in range(batches):
        rng = Numbers(width * height, batch)
        color, alpha = radiance(world, rays(job, rng, BATCH), rng, reflections, has_shadows, layers)
        sums = [dr.block_sum(channel, BATCH) for channel in (color.x, color.y, color.z, alpha)]
        dr.eval(*sums)
        total += np.stack([np.array(channel).reshape(height, width) for channel in sums], axis=-1)
    return (total / (batches * BATCH)).astype(np.float32)


def colors_apart(world, job, reflections, has_shadows, layers):
    """Every colour of a picture by itself, as it is refracted."""
    apart = []
    for world.channel in range(3):
        apart.append(picture(world, job, reflections, has_shadows, layers))
    alpha = np.mean([pixels[..., 3] for pixels in apart], axis=0)
    return np.stack([*(apart[channel][..., channel] for channel in range(3)), alpha], axis=-1)


def run(job):
    start = time.time()
    model = gltf.Model(job["model"])
    described = {"type": "scene", **surfaces.shapes(model)}
    if job.get("environment"):
        # The middle of the plug-in's picture is seen along +Z, that of the renderer's along +X.
        turn = mi.ScalarTransform4f().rotate([0, 1, 0], 90)
        described["sky"] = {"type": "envmap", "filename": job["environment"], "to_world": turn}
    world = World(mi.load_dict(described), model)
    materials = model.doc.get("materials", [])
    is_plain = all(material.get("alphaMode", "OPAQUE") == "OPAQUE" for material in materials)
    layers = 2 if is_plain else LAYERS
    for key, reflections, has_shadows in (("truth", REFLECTIONS + 1, True), ("direct", 1, False)):
        if "dispersion" in world.features:
            pixels = colors_apart(world, job, reflections, has_shadows, layers)
        else:
            pixels = picture(world, job, reflections, has_shadows, layers)
        if not np.isfinite(pixels).all():
            raise ValueError(f"{job['model']}: {np.count_nonzero(~np.isfinite(pixels))} values are no finite numbers")
        bitmap = mi.Bitmap(pixels, mi.Bitmap.PixelFormat.RGBA)
        bitmap.write(job[key])
    unread = f", without {', '.join(model.unread)}" if model.unread else ""
    print(f"{job['model']}: {time.time() - start:.1f} s{unread}", flush=True)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        jobs = json.load(file)
    surfaces.register()
    failed = 0
    for job in jobs:
        try:
            run(job)
        except Exception as error:  # One scene that cannot be read does not hinder the others.
            failed += 1
            print(f"error: {job['model']}: {error!r}", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
