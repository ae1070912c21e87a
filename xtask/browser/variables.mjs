// Variables of a frame, and what its pixels show.
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { out } from "./harness.mjs";

/** The names of variables in the types of the package. */
async function declaredNames() {
  const types = await readFile("target/web/manypass_settings.d.ts", "utf8");
  const names = /export type VariableName =([^;]*);/.exec(types)?.[1] ?? "";
  return [...names.matchAll(/"(\w+)"/g)].map((match) => match[1]);
}

/** Draws two views, one after the other, and saves the variables of the second as `prefix`-VARIABLE.bin. */
export async function read(page, prefix, { orbits, names }, faults) {
  const result = await page.evaluate(async ({ orbits, names }) => {
    const viewer = window.manypass.viewer;
    const faults = [], variables = {};
    const text = (array) => {
      const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
      let text = "";
      for (let at = 0; at < bytes.length; at += 8192) text += String.fromCharCode(...bytes.subarray(at, at + 8192));
      return btoa(text);
    };
    for (const orbit of orbits) await viewer.render(orbit);
    const before = await viewer.pixels();
    const read = {};
    for (const name of names) {
      const variable = read[name] = await viewer.variable(name);
      const { width, height } = viewer.info();
      const isOfCanvas = variable.name === name && variable.width === width && variable.height === height;
      if (!isOfCanvas || variable.data.length !== width * height * variable.channels) faults.push(`${name} has another shape`);
      variables[name] = text(variable.data);
    }
    const after = await viewer.pixels();
    if (!before.every((value, index) => value === after[index])) faults.push("reading variables changes the picture");
    const { width, height } = read.object_id;
    let objects = 0;
    for (const [x, y] of [[0.3, 0.6], [0.5, 0.95], [0.65, 0.75], [0.99, 0.01]].map(([u, v]) => [u * width, v * height])) {
      const at = Math.floor(y) * width + Math.floor(x), id = read.object_id.data[at];
      const picked = await viewer.pick(x, y);
      const is = (position) => position.every((value, axis) => value === read.position.data[3 * at + axis]);
      const isSame = picked ? picked.objectId === id && picked.materialId === read.material_id.data[at] && is(picked.position) : id === 0;
      if (!isSame) faults.push(`at ${x}, ${y} there is ${id}, but picked is ${JSON.stringify(picked)}`);
      objects += id !== 0;
    }
    if (!objects) faults.push("nothing was picked");
    if (await viewer.pick(-1, 0) || await viewer.pick(0, height)) faults.push("something was picked outside the picture");
    const radiance = await viewer.variable("radiance");
    const isBright = radiance.data.some((value, index) => index % 4 < 3 && value > 0);
    if (radiance.channels !== 4 || radiance.data.length !== 4 * width * height || !isBright) faults.push("radiance is nothing");
    const refused = await viewer.variable("nonsense").then(() => "", (error) => error.message);
    return { faults, variables, refused };
  }, { orbits, names });
  faults.push(...result.faults);
  const known = result.refused.split("there is: ")[1]?.split(", ") ?? [];
  const declared = await declaredNames();
  if (!known.length || known.join() !== declared.join()) faults.push(`the types name ${declared}, but there is ${known}`);
  for (const [name, values] of Object.entries(result.variables)) {
    await writeFile(join(out, `${prefix}-${name}.bin`), Buffer.from(values, "base64"));
  }
}
