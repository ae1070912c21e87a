// run.mjs CASES: opens the page with every model on each backend, fails on errors of page or driver, and saves into
// target/browser what the viewer reads back (NAME-BACKEND.png), what the canvas shows (NAME-BACKEND-canvas.png), the exposure
// (NAME-BACKEND-exposure.json), and variables (NAME-BACKEND-VARIABLE.bin: four bytes a value).
// CASES is JSON: [{ name, model: "demo:NAME" or a file, width, height, groups, variant, options, effects, overlay, time, variables, frames, settles, orbits }]; with `groups`
// eighths of the lights must add up to all of them; `variant` is the name of one or null; `options`, `effects` and `overlay` are what the viewer is given; `time` is
// what is shown, in seconds, or 0; `variables` are { orbits, names }: two views, one after the other, and the variables of the second; `frames` are drawn one after the other, each seen from its own of
// `orbits` if there are any, and the last one is read; with `settles` one more is the same.
import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { withFailures } from "./frames.mjs";
import { failures, launchWithBoth, launchWithNeither, out, serve, Tab, test } from "./harness.mjs";
import { withMany } from "./many.mjs";
import { asUser, withBudget, withLoss, withoutApi, withWrongAddress } from "./page.mjs";
import { withSimulations } from "./simulations.mjs";
import { withSnippets } from "./snippets.mjs";
import { read } from "./variables.mjs";
import { withWarnings } from "./warnings.mjs";

const cases = JSON.parse(process.argv[2]);
const address = ({ name, model }) => `models/${name}${model.endsWith(".stage.toml") ? ".stage.toml" : ".glb"}`;
const pictureOf = ({ options }) => options.settings?.["environment.file"];
const pictures = cases.filter(pictureOf).map((one) => [`/models/${one.name}.hdr`, pictureOf(one)]);
const { origin, close } = await serve(new Map([...cases.map((one) => [`/${address(one)}`, one.model]), ...pictures, ["/models/compass.png", "docs/examples/compass.png"], ["/models/boxes.gltf", "xtask/browser/boxes.gltf"]]));
/** Opens the page with a case on a backend, draws it, and saves what it shows. */
async function draw(tab, backend, { name, model, width, height, groups, variant, options, effects, overlay, time, variables, frames, settles, orbits }) {
  await test(`${name} on ${backend}`, async (faults) => {
    const isChanged = Boolean(variant) || Object.keys(options).length + effects.length > 0;
    const query = { backend, size: `${width}x${height}`, model: model.startsWith("demo:") ? model : address({ name, model }) };
    // The frame before the change would compile shaders that nobody asks for.
    if (isChanged) query.draw = "later";
    const page = await tab.open(query, { width, height }, faults);
    try {
      const result = await page.evaluate(async ({ name, isChanged, groups, variant, options, effects, overlay, time, frames, settles, orbits }) => {
        let groupRatio, offPixels;
        if (window.manypass.error) throw new Error(window.manypass.error);
        const viewer = window.manypass.viewer;
        const draw = async (frame) => {
          if (!orbits) return window.manypass.draw();
          // More than a tenth of a second counts as that.
          await new Promise((done) => setTimeout(done, 110));
          await viewer.render(orbits[frame]);
        };
        if (options.settings?.["environment.file"]) {
          const picture = await fetch(`models/${name}.hdr`);
          viewer.loadEnvironment(new Uint8Array(await picture.arrayBuffer()));
        }
        if (variant) {
          if (!viewer.variants().includes(variant)) throw new Error(`there are the variants ${viewer.variants()}`);
          viewer.showVariant(variant);
        }
        if (isChanged) {
          // The chain among the options names effects.
          viewer.setEffects(effects);
          viewer.configure(options);
          for (const { file, source } of effects.filter(({ source }) => source)) {
            // A broken text is refused with its place, and leaves the effect as it is; a good one takes its place.
            const name = /^\/\/! effect (\S+)/m.exec(source)?.[1] ?? file.replace(/^.*\/|\.(wgsl|cube)$/g, "");
            let refusal = "";
            try {
              viewer.replaceEffect(name, `${source}\nfn broken( {`);
            } catch (error) {
              refusal = String(error.message ?? error);
            }
            if (!refusal.startsWith(`${file}:`)) throw new Error(`a broken effect is no error: ${refusal}`);
            viewer.replaceEffect(name, source);
          }
          await draw(0);
        }
        if (overlay) {
          // What is wrong is refused with its key, and nothing is drawn of it.
          let refusal = "";
          try {
            viewer.setOverlay([{ text: "a", size_px: NaN }]);
          } catch (error) {
            refusal = String(error.message ?? error);
          }
          if (!refusal.includes("`size_px`")) throw new Error(`a wrong item of the overlay is no error: ${refusal}`);
          viewer.setOverlay(overlay);
          await window.manypass.draw();
        }
        if (time) {
          viewer.setTime(time);
          await draw(0);
        }
        for (let frame = 1; frame < frames; frame++) await draw(frame);
        let pixels = await viewer.pixels();
        // The pixels are there, so the frame is finished; the clock began with the navigation, or with the script of the page.
        const first = performance.now() - (window.openedAt ?? 0);
        const drawn = performance.now();
        // The page must show the same frame again when nothing changed.
        await draw(frames - 1);
        const again = await viewer.pixels();
        const second = performance.now() - drawn;
        // An effect that keeps what it made makes more of it, and so does a mean of frames.
        const isSame = pixels.every((value, index) => value === again[index]);
        const keeps = (frames > 1 && !settles) || effects.some(({ source }) => /^\/\/! reads:.*\bprevious\b/m.test(source ?? ""));
        if (keeps && isSame) throw new Error("what has a history makes nothing of it");
        if (!keeps && !isSame) throw new Error("the second frame differs from the first");
        if (groups) {
          const total = async (lightSubset) => {
            viewer.configure({ lightSubset });
            await window.manypass.draw();
            return (await viewer.radiance()).filter((_, i) => i % 4 < 3);
          };
          // What shines by itself is in every group; no scene has so many lights that the last of 65,536 is taken.
          const whole = await total(null), dark = await total([65535, 65536]);
          const sum = Float64Array.from(dark, (value) => -7 * value);
          for (let group = 0; group < 8; group++) (await total([group, 8])).forEach((value, i) => { sum[i] += value; });
          viewer.configure({ lightSubset: null });
          await window.manypass.draw();
          const all = (values) => values.reduce((a, b) => a + b, 0);
          groupRatio = all(sum) / all(whole);
          offPixels = whole.reduce((n, value, i) => n + (Math.abs(sum[i] - value) > 0.01 * Math.max(value, 0.01)), 0) / whole.length;
        }
        const info = viewer.info();
        const canvas = document.createElement("canvas");
        [canvas.width, canvas.height] = [info.width, info.height];
        canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(pixels), info.width, info.height), 0, 0);
        return { info, exposure: viewer.exposure(), first, second, groupRatio, offPixels, warnings: viewer.warnings(), png: canvas.toDataURL("image/png").split(",")[1] };
      }, { name, isChanged, groups, variant, options, effects, overlay, time, frames, settles, orbits });
      await writeFile(join(out, `${name}-${backend}.png`), Buffer.from(result.png, "base64"));
      await writeFile(join(out, `${name}-${backend}-exposure.json`), JSON.stringify(result.exposure));
      await page.screenshot({ path: join(out, `${name}-${backend}-canvas.png`) });
      if (result.info.backend !== backend) faults.push(`asked for ${backend}, got ${result.info.backend}`);
      if (groups) {
        console.log(`    ${name} on ${backend}: 8 groups of lights over all lights ${result.groupRatio.toFixed(5)}, ${(100 * result.offPixels).toFixed(3)} % of values off by more than 1 %`);
        if (!(Math.abs(result.groupRatio - 1) < 0.005 && result.offPixels < 0.001)) faults.push("groups of lights do not add up to the whole");
      }
      if (variables) await read(page, `${name}-${backend}`, variables, faults);
      const notes = result.warnings.length ? `; ${result.warnings.length} warnings, first: ${result.warnings[0]}` : "";
      console.log(`    ${name} on ${backend}: first frame ${result.first.toFixed(0)} ms after the page was opened, next ${result.second.toFixed(0)} ms${notes}`);
    } catch (error) {
      faults.push(String(error));
    } finally { await tab.release(); }
  });
}

// A backend each at a time: what one of them does by itself, the other has a core for.
await Promise.all(["webgpu", "webgl"].map(async (backend) => {
  const browser = await launchWithBoth();
  const tab = new Tab(browser, origin, backend);
  for (const one of cases) await draw(tab, backend, one);
  await tab.close();
  await withBudget(browser, origin, backend);
  await withLoss(browser, origin, backend);
  await withMany(browser, origin, backend);
  await withFailures(browser, origin, backend);
  await withSimulations(browser, origin, backend);
  await withSnippets(browser, origin, backend);
  if (backend === "webgpu") await asUser(browser, origin);
  else {
    await withWrongAddress(browser, origin);
    await withWarnings(browser, origin);
  }
  await browser.close();
}));

const browser = await launchWithNeither();
await withoutApi(browser, origin);
await browser.close();
close();
process.exit(failures() ? 1 : 0);
