// What the tests of viewers show that change while they are looked at: a box beside a screen.

/** Six squares of the unit cube, each of two triangles, counter-clockwise as seen from outside. */
function cube() {
  const corners = [];
  for (const axis of [0, 1, 2]) for (const side of [-0.5, 0.5]) {
    const at = (u, v) => {
      const corner = [0, 0, 0];
      [corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]] = [side, side > 0 ? u : -u, v];
      return corner;
    };
    const [a, b, c, d] = [at(-0.5, -0.5), at(0.5, -0.5), at(0.5, 0.5), at(-0.5, 0.5)];
    corners.push(a, b, c, a, c, d);
  }
  return corners.flat();
}

const embedded = (values) => `data:application/octet-stream;base64,${Buffer.from(new Float32Array(values).buffer).toString("base64")}`;

/** A glTF file: a box on the ground, and a square of the material `screen` behind it, which faces +Z; a camera sees both. */
export const model = JSON.stringify((() => {
  const box = cube(), square = [-0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, 0.5, 0];
  const uvs = [0, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 0];
  const accessor = (bufferView, type, count, more) => ({ bufferView, componentType: 5126, count, type, ...more });
  const box_m = { min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5] }, square_m = { min: [-0.5, -0.5, 0], max: [0.5, 0.5, 0] };
  const lists = [box, square, uvs];
  return {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0, 1, 2] }],
    nodes: [{ mesh: 0, translation: [-0.6, 0.5, 0] }, { mesh: 1, translation: [0.6, 0.9, -0.4] }, { camera: 0, translation: [0, 1, 4] }],
    cameras: [{ type: "perspective", perspective: { yfov: 0.7, znear: 0.1 } }],
    materials: [{ name: "box", pbrMetallicRoughness: { baseColorFactor: [0.8, 0.4, 0.2, 1], metallicFactor: 0 } },
      { name: "screen", pbrMetallicRoughness: { metallicFactor: 0 } }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0 }] }, { primitives: [{ attributes: { POSITION: 1, TEXCOORD_0: 2 }, material: 1 }] }],
    accessors: [accessor(0, "VEC3", 36, box_m), accessor(1, "VEC3", 6, square_m), accessor(2, "VEC2", 6)],
    bufferViews: lists.map((list, buffer) => ({ buffer, byteLength: 4 * list.length })),
    buffers: lists.map((list) => ({ uri: embedded(list), byteLength: 4 * list.length })),
  };
})());
