"""Light through smooth glass: mirrored or refracted by chance (KHR_materials_transmission, KHR_materials_volume, KHR_materials_dispersion)."""

import drjit as dr
import mitsuba as mi

# How often light is mirrored and refracted one after the other.
EVENTS = 5


def refracted(hit, channel, rng):
    """Where light comes from that leaves glass towards the eye, and its colour. A body's colour is shared by entry and exit, and a wall
    without volume bends no light."""
    cosine, index = dr.maximum(dr.dot(hit.to_eye, hit.normal), 1e-4), hit.iors[channel]
    has_volume = hit.shares.z > 0.5
    reflectance, cosine_below, _, ratio = mi.fresnel(cosine, dr.select(hit.is_front | ~has_volume, index, 1 / index))
    bent = (hit.normal * cosine - hit.to_eye) * ratio + hit.normal * cosine_below
    is_mirrored = rng.next_float32() < reflectance
    direction = dr.select(is_mirrored, 2 * cosine * hit.normal - hit.to_eye, dr.select(has_volume, dr.normalize(bent), -hit.to_eye))
    tint = dr.select(is_mirrored, mi.Color3f(1), dr.select(has_volume, dr.sqrt(hit.base), hit.base))
    inside = ~hit.is_front & has_volume
    return direction, tint * dr.select(inside, dr.exp(-hit.absorption * dr.select(inside, hit.si.t, 0)), 1)


def behind(meet, hit, ray, channel, rng):
    """What is met behind glass (`meet` finds what a ray meets), the ray, what the glass leaves of light, and where there was glass."""
    left, passed = mi.Color3f(1), mi.Bool(False)
    for event in range(EVENTS + 1):
        is_glass = hit.valid & (rng.rest.next_float32() < hit.shares.x)
        if event == EVENTS:
            left = dr.select(is_glass, 0, left)
            break
        direction, tint = refracted(hit, channel, rng.rest)
        left *= dr.select(is_glass, tint, 1)
        spawned = hit.si.spawn_ray(direction)
        ray = mi.Ray3f(dr.select(is_glass, spawned.o, ray.o), dr.select(is_glass, direction, ray.d))
        passed |= is_glass
        hit = meet(ray)
    return hit, ray, left, passed
