"""A small reader of glTF 2.0 that shares no code with the renderer: triangles in world space, materials, punctual lights.

Read are core glTF (node transforms, skins and morph targets in the pose of the file, sparse accessors not) and KHR_lights_punctual,
KHR_texture_transform, and those extensions of materials that `surfaces.py` knows. Anything else that a file uses is named in `unread`.
"""

import base64
import json
import math
import pathlib
import struct
import urllib.parse

import numpy as np

TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
READ = {"KHR_lights_punctual", "KHR_texture_transform"} | {
    f"KHR_materials_{name}"
    for name in ("anisotropy", "diffuse_transmission", "dispersion", "emissive_strength", "ior", "pbrSpecularGlossiness", "transmission",
                 "unlit", "volume")
}


class Model:
    """`primitives` have `positions`, `normals`, `faces`, `material` and, if they have them, `uv` (one array for each set),
    `tangents`, `colors`; `lights` have `type`, `position`, `direction`, `rgb`, `range`, `inner`, `outer`."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        data = self.path.read_bytes()
        binary = None
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            document, binary = data[20:20 + length], data[20 + length + 8:]
        else:
            document = data
        self.doc = json.loads(document)
        self.unread = sorted(set(self.doc.get("extensionsUsed", [])) - READ)
        self.buffers = [self._bytes(buffer["uri"]) if "uri" in buffer else binary for buffer in self.doc.get("buffers", [])]
        self.worlds = [None] * len(self.doc.get("nodes", []))
        roots = self.doc["scenes"][self.doc.get("scene", 0)]["nodes"]
        for root in roots:
            self._place(root, np.eye(4))
        self.primitives, self.lights = [], []
        for index, world in enumerate(self.worlds):
            if world is not None:
                self._add(self.doc["nodes"][index], world)

    def _bytes(self, uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.path.parent / urllib.parse.unquote(uri)).read_bytes()

    def _view(self, index):
        view = self.doc["bufferViews"][index]
        return self.buffers[view["buffer"]][view.get("byteOffset", 0):][:view["byteLength"]], view.get("byteStride")

    def accessor(self, index):
        """The values of an accessor, a row for each element; normalized integers as floats."""
        accessor = self.doc["accessors"][index]
        if "sparse" in accessor:
            raise ValueError("sparse accessors are not read")
        kind, count = np.dtype(TYPES[accessor["componentType"]]), COUNTS[accessor["type"]]
        raw, stride = self._view(accessor["bufferView"])
        raw = np.frombuffer(raw, np.uint8)[accessor.get("byteOffset", 0):]
        size = kind.itemsize * count
        rows = np.lib.stride_tricks.as_strided(raw, (accessor["count"], size), (stride or size, 1))
        values = np.ascontiguousarray(rows).view(kind).reshape(accessor["count"], count)
        if accessor.get("normalized"):
            values = np.maximum(values.astype(np.float32) / np.iinfo(kind).max, -1)
        return values

    def image(self, texture):
        """The bytes of the file of a texture's image."""
        image = self.doc["images"][self.doc["textures"][texture]["source"]]
        return self._bytes(image["uri"]) if "uri" in image else bytes(self._view(image["bufferView"])[0])

    def _place(self, index, parent):
        node = self.doc["nodes"][index]
        self.worlds[index] = parent @ matrix(node)
        for child in node.get("children", []):
            self._place(child, self.worlds[index])

    def _add(self, node, world):
        light = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if light is not None:
            self.lights.append(self._light(self.doc["extensions"]["KHR_lights_punctual"]["lights"][light], world))
        if "mesh" not in node:
            return
        mesh = self.doc["meshes"][node["mesh"]]
        weights = node.get("weights", mesh.get("weights", []))
        for primitive in mesh["primitives"]:
            if primitive.get("mode", 4) == 4:
                self.primitives.append(self._primitive(primitive, world, weights, node.get("skin")))

    def _primitive(self, primitive, world, weights, skin):
        attributes = primitive["attributes"]
        values = {name: self.accessor(index).astype(np.float64) for name, index in attributes.items() if not name.startswith("_")}
        for weight, target in zip(weights, primitive.get("targets", [])):
            for name, index in target.items():
                values[name][:, :3] += weight * self.accessor(index)[:, :3]
        positions = values["POSITION"]
        faces = self.accessor(primitive["indices"]).reshape(-1, 3) if "indices" in primitive else np.arange(len(positions)).reshape(-1, 3)
        faces = faces.astype(np.uint32)
        if "NORMAL" not in values:
            # Without normals a mesh is flat, so that no two triangles share a corner.
            values = {name: value[faces.ravel()] for name, value in values.items()}
            positions = values["POSITION"]
            corners = positions.reshape(-1, 3, 3)
            flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            values["NORMAL"] = np.repeat(flat, 3, axis=0)
            faces = np.arange(len(positions), dtype=np.uint32).reshape(-1, 3)
        worlds = np.broadcast_to(world, (len(positions), 4, 4))
        if skin is not None and "JOINTS_0" in values:
            worlds = self._skinned(self.doc["skins"][skin], values)
        linear = worlds[:, :3, :3]
        normals = np.einsum("nji,nj->ni", np.linalg.inv(linear), values["NORMAL"])
        mirrored = np.linalg.det(linear[0]) < 0
        placed = {
            "positions": np.einsum("nij,nj->ni", linear, positions) + worlds[:, :3, 3],
            "normals": normalized(normals),
            "faces": faces[:, ::-1] if mirrored else faces,
            "material": primitive.get("material"),
            "uv": [values[name] for name in ("TEXCOORD_0", "TEXCOORD_1") if name in values],
            "colors": values.get("COLOR_0"),
            "tangents": None,
        }
        if "TANGENT" in values:
            # A mirrored object turns its bitangents around, too.
            sign = values["TANGENT"][:, 3:] * (-1 if mirrored else 1)
            placed["tangents"] = np.hstack([normalized(np.einsum("nij,nj->ni", linear, values["TANGENT"][:, :3])), sign])
        return placed

    def _skinned(self, skin, values):
        inverse = np.tile(np.eye(4), (len(skin["joints"]), 1, 1))
        if "inverseBindMatrices" in skin:
            inverse = self.accessor(skin["inverseBindMatrices"]).astype(np.float64).reshape(-1, 4, 4).transpose(0, 2, 1)
        joints = np.stack([self.worlds[joint] for joint in skin["joints"]]) @ inverse
        return np.einsum("nk,nkij->nij", values["WEIGHTS_0"], joints[values["JOINTS_0"].astype(int)])

    def _light(self, light, world):
        spot = light.get("spot", {})
        axis = -world[:3, 2] / np.linalg.norm(world[:3, 2])
        return {
            "type": light["type"],
            "position": world[:3, 3],
            "direction": axis,
            "rgb": np.array(light.get("color", [1, 1, 1]), float) * light.get("intensity", 1.0),
            "range": light.get("range", math.inf),
            "inner": spot.get("innerConeAngle", 0.0),
            "outer": spot.get("outerConeAngle", math.pi / 4),
        }


def normalized(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)


def matrix(node):
    """object to parent."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    placed = np.eye(4)
    placed[:3, :3] = turn @ np.diag(node.get("scale", [1, 1, 1]))
    placed[:3, 3] = node.get("translation", [0, 0, 0])
    return placed
