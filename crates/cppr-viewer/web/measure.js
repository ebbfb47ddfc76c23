// Measures the live page in a headless browser: how many shapes a second, how long from a change to its shape,
// how many pictures a second. Run: node measure.js [ROBOT...]

import { browser, open, view } from "./test/browser.js";

const robots = process.argv.length > 2 ? process.argv.slice(2) : ["r1", "r3", "childs3", "helicoid"].map((r) => `robots/${r}.toml`);
const chrome = await browser();
const row = (cells) => console.log(`| ${cells.join(" | ")} |`);
row(["robot", "updates a second", "latency, median (ms)", "latency, 99 of 100 (ms)", "solve (ms)", "pictures a second"]);
row(["---", "---", "---", "---", "---", "---"]);
for (const robot of robots) {
  const server = await view(robot);
  const { page } = await open(chrome.context, server.address);
  const result = await page.evaluate(async () => {
    const { store, source, stage } = cppr;
    const most = store.robot.controls[0].pull_mm / 2;
    let pictures = 0;
    const { drawn } = stage;
    stage.drawn = () => {
      pictures++;
      drawn();
    };
    const [latency, solves] = [[], []];
    // The message event comes after the shape is on its way to the graphics card and all numbers are written.
    const update = (i) =>
      new Promise((resolve) => {
        const begin = performance.now();
        source.addEventListener("message", ({ detail }) => {
          latency.push(performance.now() - begin);
          solves.push(detail.solve_us / 1000);
          resolve();
        }, { once: true });
        store.change((s) => (s.actuator[0].pull_mm = most * Math.sin(i / 40)));
      });
    for (let i = 0; i < 50; i++) await update(i);
    latency.length = solves.length = pictures = 0;
    const begin = performance.now();
    for (let i = 0; i < 300; i++) await update(i);
    const seconds = (performance.now() - begin) / 1000;
    const at = (list, part) => list.toSorted((a, b) => a - b)[Math.floor(part * (list.length - 1))];
    return { rate: latency.length / seconds, median: at(latency, 0.5), slow: at(latency, 0.99), solve: at(solves, 0.5), pictures: pictures / seconds };
  });
  const { rate, median, slow, solve, pictures } = result;
  row([robot.replace(/.*\//, "").replace(".toml", ""), rate.toFixed(0), median.toFixed(1), slow.toFixed(1), solve.toFixed(2), pictures.toFixed(0)]);
  await page.close();
  await server.close();
}
await chrome.close();
process.exit(0);
