"""Compares the motion variable of a frame with the motion that follows from its depth and two cameras.

    manypass render model.glb --turntable 36 -o 'turn/{frame:04}.exr' --aov depth,motion
    python3 flow_from_depth.py turn/0004.exr turn/0005.exr

Needs NumPy and OpenEXR 3.3 or later (pip install numpy OpenEXR). Every surface must stand still in the world, as in a
turntable; the camera may move. Ends with 1 if any pixel differs by more than 0.01 pixels.
"""

import sys

import numpy as np
import OpenEXR

TOLERANCE_PX = 0.01


def load(path):
    """The parts of a file by name: their headers, and their channels as arrays of height x width."""
    with OpenEXR.File(path, separate_channels=True) as file:
        headers = {part.name(): dict(part.header) for part in file.parts}
        channels = {part.name(): {name: c.pixels.copy() for name, c in part.channels.items()} for part in file.parts}
    return headers, channels


def positions_world(header, depth):
    """The world position of every pixel, height x width x 3, from its depth and the header's camera.

    OpenEXR's matrices are for row vectors: p_camera = p_world @ worldToCamera. Its camera space has +x right, +y up
    and +z ahead, so that depth is z. A picture that is screenWindowWidth wide lies at z = 1.
    """
    height, width = depth.shape
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    metres_per_pixel = header["screenWindowWidth"] / width
    camera = np.stack(
        [
            (x - width / 2) * metres_per_pixel * depth,
            (height / 2 - y) * metres_per_pixel * depth,
            depth,
            np.ones_like(depth),
        ],
        axis=-1,
    )
    return (camera @ np.linalg.inv(header["worldToCamera"].astype(np.float64)))[..., :3]


def pixels(header, position_world, width, height):
    """Where the header's camera sees positions, in pixels from the top left corner of the picture."""
    ones = np.ones(position_world.shape[:-1] + (1,))
    ndc = np.concatenate([position_world, ones], axis=-1) @ header["worldToNDC"].astype(np.float64)
    return ndc[..., :2] / ndc[..., 3:] * [width, height]


def main(path_before, path_now):
    headers_before, _ = load(path_before)
    headers_now, now = load(path_now)
    depth = now["depth"]["Z"].astype(np.float64)
    motion = np.stack([now["motion"]["X"], now["motion"]["Y"]], axis=-1)
    height, width = depth.shape

    surface = np.isfinite(depth)
    position_world = positions_world(headers_now["depth"], np.where(surface, depth, 1.0))
    here = pixels(headers_now["depth"], position_world, width, height)
    there = pixels(headers_before["depth"], position_world, width, height)
    difference = np.linalg.norm((here - there) - motion, axis=-1)[surface]
    longest = np.linalg.norm(motion, axis=-1)[surface].max(initial=0.0)

    print(f"{difference.size} pixels of surfaces, moved by up to {longest:.3f} px")
    print(f"motion differs from that of depth and cameras by at most {difference.max(initial=0.0):.6f} px")
    return 0 if difference.size and difference.max() <= TOLERANCE_PX else 1


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2]))
