// Measures the live page in a headless browser. Run: node measure.js [--alone] [ROBOT...], files seen from the root of the repository.
// With --alone it is the page that solves by itself.
//
// First as a hand moves a slider: one change with every picture of the screen, as the browser hands out a mouse's motion. Then as fast as
// it goes: the next change when the last one's shape is there. Times run from the change: until its shape is decoded and handed to the
// renderer (shape), until the picture of it is sent to the graphics card (picture sent), until that has drawn it (picture drawn).

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { browser, open, root, view } from "./test/browser.js";

const SECONDS = 6;
const asked = process.argv.slice(2).filter((argument) => argument !== "--alone");
const alone = asked.length < process.argv.length - 2;
const robots = asked.length > 0 ? asked : ["r1", "r3", "childs3", "helicoid"].map((r) => `robots/${r}.toml`);
/** The page that solves by itself, as `view` gives that of the program. */
function lone() {
  const folder = mkdtempSync(join(tmpdir(), "cppr-measure-"));
  const file = join(folder, "live.html");
  execFileSync("node", [join(root, "crates/cppr-web/page.js"), file], { stdio: "ignore" });
  return { address: pathToFileURL(file).href, close: () => rmSync(folder, { recursive: true }) };
}

const chrome = await browser();
const row = (cells) => console.log(`| ${cells.join(" | ")} |`);
const head = ["robot", "pictures a second", "shape (ms)", "picture sent (ms)", "picture drawn (ms)", "updates a second at most", "shape then (ms)", "solve (ms)"];
row(head);
row(head.map(() => "---"));
for (const robot of robots) {
  const server = alone ? lone() : await view(robot);
  const { page } = await open(chrome.context, server.address);
  if (alone) {
    const text = readFileSync(join(root, robot), "utf8");
    await page.evaluate((file) => cppr.source.robot(file), { name: robot, text });
    const name = text.match(/^name *= *"(.*)"/m)[1];
    await page.waitForFunction((wanted) => cppr.store.robot?.name === wanted && cppr.source.idle, name);
  }
  const result = await page.evaluate(async (seconds) => {
    const { store, source, stage } = cppr;
    const most = store.robot.controls[0].pull_mm / 2;
    const gl = stage.renderer.getContext();
    const [shape, sent, drawn, solves, fences, pending] = [[], [], [], [], [], []];
    let [count, shown] = [0, null];
    // Every change is another value, by which its answer is known.
    const value = () => most * Math.sin(count++ / 40) + 1e-7 * count;
    const change = () => {
      pending.push({ value: value(), since: performance.now() });
      store.change((s) => (s.actuator[0].pull_mm = pending.at(-1).value));
    };
    const sought = (pose) => pending.find((p) => Math.abs(p.value - pose.actuators[0].pull_mm) < 4e-8);
    source.addEventListener("message", ({ detail }) => {
      if (detail.kind !== "pose") return;
      const { since } = sought(detail) ?? {};
      shape.push(performance.now() - since);
      solves.push(detail.solve_us / 1000);
    });
    const draw = stage.drawNow.bind(stage);
    stage.drawNow = (smooth) => {
      draw(smooth);
      if (stage.pose === shown) return;
      shown = stage.pose;
      const at = pending.findIndex((p) => p === sought(shown));
      if (at < 0) return;
      const [{ since }] = pending.splice(0, at + 1).slice(-1);
      sent.push(performance.now() - since);
      fences.push({ since, fence: gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0) });
      gl.flush();
    };
    let going = true;
    const look = () => {
      while (fences.length > 0 && gl.getSyncParameter(fences[0].fence, gl.SYNC_STATUS) === gl.SIGNALED) {
        const { since, fence } = fences.shift();
        gl.deleteSync(fence);
        drawn.push(performance.now() - since);
      }
      if (going) setTimeout(look, 1);
    };
    look();
    const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
    const at = (list, part) => list.toSorted((a, b) => a - b)[Math.floor(part * (list.length - 1))];
    const pair = (list) => [at(list, 0.5), at(list, 0.95)];
    /** Runs `step` for some seconds, after one that does not count. */
    const run = async (step) => {
      let begin;
      for (const time of [1, seconds]) {
        shape.length = sent.length = drawn.length = solves.length = 0;
        begin = performance.now();
        while (performance.now() - begin < 1000 * time) await step();
      }
      const took = (performance.now() - begin) / 1000;
      return { pictures: drawn.length / took, updates: shape.length / took, shape: pair(shape), sent: pair(sent), drawn: pair(drawn), solve: at(solves, 0.5) };
    };
    const slider = await run(() => frame().then(change));
    await new Promise((resolve) => setTimeout(resolve, 500));
    const fastest = await run(() => new Promise((resolve) => {
      source.addEventListener("message", function take({ detail }) {
        if (detail.kind !== "pose") return;
        source.removeEventListener("message", take);
        resolve();
      });
      change();
    }));
    going = false;
    return { slider, fastest };
  }, SECONDS);
  const { slider, fastest } = result;
  const both = ([median, slow]) => `${median.toFixed(1)} … ${slow.toFixed(1)}`;
  row([
    robot.replace(/.*\//, "").replace(".toml", ""), slider.pictures.toFixed(0), both(slider.shape), both(slider.sent), both(slider.drawn),
    fastest.updates.toFixed(0), both(fastest.shape), slider.solve.toFixed(2),
  ]);
  await page.close();
  await server.close();
}
console.log(`\nTimes: median … 95 of 100. Window 1366 × 768. Load of the machine ${readFileSync("/proc/loadavg", "utf8").split(" ")[0]}.`);
await chrome.close();
process.exit(0);
