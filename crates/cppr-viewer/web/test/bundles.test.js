// A robot with parts and joints on the page: every tube's controls, tubes that end apart, joints, what it does not have.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { browser, open, root, view } from "./browser.js";
import { drop, grave, near, settled, solve, tipOf } from "./helpers.js";

const TWO = "robots/bundles/two_sections.toml";
const UNCUT = "robots/bundles/uncut_ends.toml";
let server, chrome, page, errors;
before(async () => {
  server = await view(TWO);
  chrome = await browser();
  ({ page, errors } = await open(chrome.context, server.address));
});
after(async () => {
  await chrome?.close();
  await server?.close();
});

const set = (pulls) => page.evaluate((p) => cppr.store.change((s) => s.actuator.forEach((a, i) => (a.pull_mm = p[i])), true), pulls);
const motors = (pulls) => pulls.flatMap((pull, i) => ["--pull", `${i + 1}=${pull}mm`]);

test("every tube is driven, and the tip is the program's", async () => {
  await set([0, 3, 0, 2]);
  near(await settled(page), tipOf(solve(TWO, ...motors([0, 3, 0, 2]))), 1e-4);
  assert.deepEqual(await page.evaluate(() => cppr.store.scenario.actuator.map((a) => a.tube)), [1, 2, 3, 4]);
  const shape = await page.evaluate(() => {
    const { stage } = cppr;
    stage.drawNow();
    const ends = stage.centroids.map((line) => [...line.points].slice(-3));
    return { ends, joints: stage.joints.map((j) => j.position.toArray()), pose: { spine: stage.pose.spine, tip: stage.pose.tip_mm } };
  });
  assert.equal(shape.joints.length, 2, "a band at each joint");
  near(shape.joints[1], shape.pose.tip, 1e-3, "the second joint is at the tip");
  assert.ok(Math.hypot(...shape.ends[0].map((v, i) => v - shape.joints[0][i])) < 5, "tube 1 ends at the first joint");
  assert.ok(Math.hypot(...shape.ends[0].map((v, i) => v - shape.ends[3][i])) > 30, "tube 4 goes on");
  assert.match(await page.locator(".status").textContent(), /converged, stable/);
});

test("all tubes advance together, and undo brings them back", async () => {
  await set([0, 3, 0, 2]);
  await settled(page);
  await page.evaluate(() => cppr.store.settle());
  const field = page.getByRole("group", { name: "All tubes" }).getByRole("spinbutton");
  await field.fill("20");
  await field.press("Tab");
  near(await settled(page), tipOf(solve(TWO, ...motors([-20, -17, -20, -18]))), 1e-3);
  await page.getByRole("button", { name: "Undo" }).click();
  near(await settled(page), tipOf(solve(TWO, ...motors([0, 3, 0, 2]))), 1e-3);
});

test("the tip is dragged with all motors, and the scenario follows", async () => {
  await set([0, 3, 0, 2]);
  const [x, y, z] = await settled(page);
  await page.evaluate((p) => cppr.source.solve(cppr.store.scenario, { target_mm: p }), [x + 1, y + 1, z + 2]);
  near(await settled(page), [x + 1, y + 1, z + 2], 0.1);
  const pulls = await page.evaluate(() => cppr.store.scenario.actuator);
  const asked = pulls.flatMap((a) => ["--pull", `${a.tube}=${a.pull_mm}mm`, "--rotate", `${a.tube}=${a.rotate_deg}deg`]);
  near(await settled(page), tipOf(solve(TWO, ...asked)), 1e-2);
});

test("what such a robot has not is said, and refused where it is asked", async () => {
  const printed = page.getByRole("button", { name: "printed" });
  assert.ok(await printed.isDisabled());
  assert.match(await page.locator('[aria-label="Formulation"]').getAttribute("title"), /know no parts and joints/);
  assert.equal(await page.getByRole("checkbox", { name: "workspace" }).count(), 0);
  await page.evaluate(() => cppr.store.change((s) => (s.formulation = "printed")));
  await page.locator(".banner").getByText("not for a robot with parts or joints").waitFor();
  await page.evaluate(() => cppr.store.change((s) => (s.formulation = "consistent")));
  await set([0, 100, 0, 0]);
  await page.locator(".banner").getByText("would lie behind the plate").waitFor();
  await set([0, 0, 0, 0]);
  await settled(page);
  assert.ok(await page.locator(".banner").isHidden());
});

test("a robot with an uncut shaft and tip shows its body, notched between them", async () => {
  await drop(page, "uncut_ends.toml", readFileSync(join(root, UNCUT), "utf8"));
  await page.waitForFunction(() => cppr.store.robot.name === "Uncut ends" && cppr.stage.tubes[1]?.coarse && cppr.store.pose);
  await set([-20, -17]);
  near(await settled(page), tipOf(solve(UNCUT, ...motors([-20, -17]))), 1e-3);
  const spread = await page.evaluate(() => {
    const x = cppr.stage.tubes[0].fine.getAttribute("position").array.filter((_, i) => i % 3 === 0);
    const count = (from, to) => x.filter((v) => v > from && v < to).length;
    return [count(0.5, 29.5), count(30, 110), count(110.5, 114.5), Math.max(...x)];
  });
  assert.ok(spread[1] > 20 * spread[0] && spread[1] > 20 * spread[2] && Math.abs(spread[3] - 115) < 1e-3, `${spread}`);
  assert.deepEqual(grave(errors), []);
});

test("a robot with sudden changes along it is one of them, and the page says so", async () => {
  const other = await chrome.context.newPage();
  await other.goto(server.address);
  await other.waitForFunction(() => cppr.store.pose);
  const STEPS = "crates/cppr-cli/tests/data/steps_in_a_table.toml";
  await drop(other, "steps.toml", readFileSync(join(root, STEPS), "utf8"));
  await other.waitForFunction(() => cppr.store.robot.name === "MyNiTi" && cppr.store.pose);
  await other.evaluate(() => cppr.store.change((s) => (s.actuator[1].pull_mm = 2), true));
  near(await settled(other), [88.599, -50.173, 0], 0.02);
  assert.match(await other.getByRole("complementary", { name: "Results" }).textContent(), /sudden changes \(notch depth of tube 1 at 30 mm/);
  await other.close();
});

test("limits of such a robot: in the status, as colours, and as safe ranges", async () => {
  const text = readFileSync(join(root, UNCUT), "utf8").replace("strain_percent = 6", "strain_percent = 1");
  await drop(page, "strict.toml", text.replace("Uncut ends", "Strict"));
  await page.waitForFunction(() => cppr.store.robot.name === "Strict" && cppr.store.pose);
  await set([0, 1]);
  await settled(page);
  assert.match(await page.locator(".status").textContent(), /^converged, stable$/);
  const strains = await page.evaluate(() => cppr.store.pose.limits.filter((l) => l.strain_use !== null).map((l) => l.strain_use));
  assert.ok(strains.length > 150 && Math.max(...strains) < 1, `${strains.length}`);
  const rows = await page.locator(".readout tr.limits").allTextContents();
  assert.equal(rows.length, 3, "a head and two tubes");
  assert.match(rows[2], /Tube 2\d+ % notch \d+/);
  // The pulls' ranges come first, each as soon as it is known.
  const slider = page.getByRole("group", { name: "Tube 2" }).getByRole("slider", { name: "Pull (mm)" });
  await page.waitForFunction(() => document.querySelectorAll("input.ranged").length >= 3, null, { timeout: 60_000 });
  const [low, high] = (await slider.getAttribute("title")).match(/−?[\d.]+/g).map((v) => Number(v.replace("−", "-")));
  assert.ok(Math.abs(low + 3.112) < 0.01 && Math.abs(high - 3.238) < 0.01, `${low} to ${high}`);
  await page.getByLabel("Colour by").selectOption("strain");
  assert.match(await page.locator(".legend").textContent(), /Greatest strain in every notch, teeth rigid \(%\)/);
  const coloured = await page.evaluate(() => cppr.stage.painted);
  assert.ok(coloured.mode === 1 && coloured.range[1] > 0.003 && coloured.range[1] < 0.01, JSON.stringify(coloured));
  await page.getByLabel("Colour by").selectOption("closure");
  assert.match(await page.locator(".legend").textContent(), /Closure of the notches/);
  await page.getByLabel("Colour by").selectOption("tube");
  // Beyond the range: the status says it, and no range is shown.
  await set([0, high + 0.5]);
  await settled(page);
  assert.match(await page.locator(".status").textContent(), /beyond a limit/);
  assert.match(await page.locator(".advice").textContent(), /tube \d.*strain/);
  assert.equal(await page.locator("input.ranged").count(), 0);
  assert.deepEqual(grave(errors), []);
});
