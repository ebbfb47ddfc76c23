// A saved page, opened as a file: it shows what the program solves and talks to nobody.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { browser, open, program, root } from "./browser.js";
import { grave, near, solve, tipOf } from "./helpers.js";

let chrome, folder;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), "cppr-saved-"));
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  rmSync(folder, { recursive: true, force: true });
});

async function saved(name, ...args) {
  const path = join(folder, name);
  execFileSync(program, ["view", ...args, "--save", path], { cwd: root });
  return open(chrome.context, pathToFileURL(path).href);
}
const tip = (page) => page.evaluate(() => cppr.store.pose.tip_mm);

test("one slider, poses of the program, no request", async () => {
  const { page, errors, requests } = await saved("r1.html", "robots/r1.toml", "--sweep", "pull=-7..7mm:15");
  near(await tip(page), [150, 0, 0], 1e-9);
  const slider = page.getByRole("slider", { name: "Pull 2" });
  for (const [index, pull] of [[0, -7], [10, 3], [14, 7]]) {
    await slider.fill(String(index));
    near(await tip(page), tipOf(solve("robots/r1.toml", "--pull", `${pull}mm`)), 1e-6);
  }
  assert.ok(await page.evaluate(() => cppr.stage.tubes.every((t) => t.mesh.visible)));
  assert.deepEqual(grave(errors), []);
  assert.deepEqual(requests.filter((u) => !/^(file|data|blob):/.test(u)), []);
  assert.equal(requests.filter((u) => u.startsWith("file:")).length, 1);
  // Even if it wanted to, it may not.
  const barred = await page.evaluate(() => fetch("http://127.0.0.1:9/").then(() => "sent", (e) => String(e)));
  assert.match(barred, /TypeError/);
  await page.close();
});

test("two sliders over a loaded robot, and poses that have no equilibrium", async () => {
  const { page, errors } = await saved("childs3.html", "robots/childs3.toml", "--scenario", "examples/scenario.toml", "--sweep", "pull=2=-1..1mm:3", "--sweep", "rotate=3=-60..60deg:3");
  await page.getByRole("slider", { name: "Pull 2" }).fill("2");
  await page.getByRole("slider", { name: "Turn 3" }).fill("0");
  const want = solve("robots/childs3.toml", "--tip-force", "0,0,-0.5N", "--pull", "2=1mm", "--rotate", "2=30deg", "--tension", "3=-4N", "--rotate", "3=-60deg");
  near(await tip(page), tipOf(want), 1e-6);
  assert.deepEqual(grave(errors), []);
  await page.close();
  const far = await saved("far.html", "robots/r3.toml", "--sweep", "pull=0..149mm:2");
  await far.page.getByRole("slider", { name: "Pull 2" }).fill("1");
  assert.match(await far.page.getByRole("alert").textContent(), /not converged/);
  await far.page.getByRole("slider", { name: "Pull 2" }).fill("0");
  assert.ok(await far.page.getByRole("alert").isHidden());
  await far.page.close();
});
