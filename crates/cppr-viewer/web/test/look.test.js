// What a person sees and plays with: views, limits, safe ranges, motions, the tip that is dragged.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { browser, open, root, view } from "./browser.js";
import { drop, grave, near, settled, solve, tipOf } from "./helpers.js";

let server, chrome, page, errors;
before(async () => {
  server = await view("robots/r1.toml");
  chrome = await browser();
  ({ page, errors } = await open(chrome.context, server.address));
});
after(async () => {
  await chrome?.close();
  await server?.close();
});

const slider = (label) => page.getByRole("slider", { name: label });
const pull = (value) => page.evaluate((v) => cppr.store.change((s) => (s.actuator[0].pull_mm = v)), value);
const reset = async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await settled(page);
};

test("axes turn with the camera, and a view button is pressed while its view is seen", async () => {
  const axes = () => page.evaluate(() => [...document.querySelectorAll(".triad text")].map((t) => [t.textContent, Math.round(t.getAttribute("x")), Math.round(t.getAttribute("y"))]).sort());
  const pressed = () => page.locator('[aria-label="Camera"] [aria-pressed="true"]').allTextContents();
  assert.deepEqual(await pressed(), ["3D"]);
  await page.getByRole("button", { name: "X–Y" }).click();
  await page.waitForFunction(() => !cppr.stage.moving);
  const [x, y] = await axes();
  assert.deepEqual([x[0], x[2] === 0, x[1] > 20, y[0], y[1] === 0, y[2] < -20], ["X", true, true, "Y", true, true], "X to the right, Y up");
  assert.deepEqual(await pressed(), ["X–Y"]);
  await page.locator("canvas").focus();
  await page.keyboard.press("ArrowLeft");
  assert.deepEqual(await pressed(), []);
  await page.keyboard.press("1");
  assert.deepEqual(await pressed(), ["3D"]);
});

test("fit fills the picture, and follow keeps the tip in its place", async () => {
  await pull(7);
  await settled(page);
  await page.getByRole("button", { name: "Fit" }).click();
  const spread = await page.evaluate(() => {
    const { stage } = cppr;
    stage.drawNow();
    const points = stage.pose.points(0, "x");
    let most = 0;
    for (let i = 0; i < points.length; i += 3) {
      const p = stage.tip.position.clone().set(points[i], points[i + 1], points[i + 2]).project(stage.camera);
      most = Math.max(most, Math.abs(p.x), Math.abs(p.y));
    }
    return most;
  });
  assert.ok(spread > 0.5 && spread < 1, `the robot reaches ${spread} of half the picture`);
  const seen = () => page.evaluate(() => {
    cppr.stage.drawNow();
    return cppr.stage.tip.position.clone().project(cppr.stage.camera).toArray().slice(0, 2);
  });
  await page.getByRole("button", { name: "Follow" }).click();
  const [before] = [await seen()];
  await pull(-7);
  await settled(page);
  near(await seen(), before, 1e-6, "tip on the screen");
  await page.getByRole("button", { name: "Follow" }).click();
  await pull(0);
  await settled(page);
  const after = await seen();
  assert.ok(Math.hypot(after[0] - before[0], after[1] - before[1]) > 0.05, "the tip leaves its place again");
  await page.keyboard.press("1");
});

test("a limit that is exceeded is in the status, as the program has it", async () => {
  await reset();
  assert.match(await page.locator(".status").getAttribute("class"), /good/);
  await pull(40);
  await settled(page);
  await page.waitForFunction(() => document.querySelector(".status").className.includes("warn"));
  const advice = await page.locator(".advice").textContent();
  const { text } = solve("robots/r1.toml", "--pull", "40mm").limit_exceeded;
  assert.equal(advice.replace(/\.$/, ""), text.split(";")[0]);
  const used = await page.locator(".limits .low").first().textContent();
  assert.match(used, /^\d{3} % notch \d/);
  await pull(3);
  await settled(page);
  await page.waitForFunction(() => document.querySelector(".status").className.includes("good"));
  assert.ok(await page.locator(".advice").isHidden());
});

test("sliders mark what keeps all limits", async () => {
  await reset();
  await page.waitForFunction(() => document.querySelector("input[type=range]").classList.contains("ranged"));
  // As `cppr limits robots/r1.toml` prints it.
  assert.equal(await slider("Pull (mm)").getAttribute("title"), "All limits are kept from −7.61 to 7.68 mm");
  const low = await page.evaluate(() => parseFloat(document.querySelector("input[type=range]").style.getPropertyValue("--low")));
  assert.ok(low > 5 && low < 45, `the safe part begins at ${low} %`);
  // Beyond a limit there is no range to mark.
  await pull(20);
  await page.waitForFunction(() => !document.querySelector("input[type=range]").classList.contains("ranged"));
});

test("a motion plays from rest to the command, in a loop if wanted, and is no step of undo", async () => {
  await reset();
  await slider("Pull (mm)").fill("6");
  const end = await settled(page);
  await page.getByRole("slider", { name: "Part of the motion" }).fill("0.5");
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "3mm")), 1e-6);
  await page.getByRole("slider", { name: "Part of the motion" }).fill("1");
  near(await settled(page), end, 1e-6);
  await page.getByLabel("loop").check();
  await page.getByRole("button", { name: "Play" }).click();
  const seen = await page.evaluate(async () => {
    const parts = [cppr.player.part];
    // There, and a part of the way back.
    for (let top = 0; top < 0.9 || parts.at(-1) > 0.8; top = Math.max(top, parts.at(-1))) {
      await new Promise(requestAnimationFrame);
      parts.push(cppr.player.part);
    }
    return parts;
  });
  assert.ok(seen[0] < 0.2, `it begins at ${seen[0]}`);
  assert.ok(seen.slice(1).every((p, i) => Math.abs(p - seen[i]) < 0.1), "without jumps on the way");
  await slider("Pull (mm)").fill("2");
  assert.ok(!(await page.evaluate(() => cppr.player.playing)), "a hand on a control ends the motion");
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "2mm")), 1e-6);
});

test("the tip is dragged to a place, and the controls say how", async () => {
  await reset();
  await pull(2);
  await settled(page);
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "the tip", exact: true }).click();
  const before = await page.evaluate(() => cppr.store.pose.tip_mm);
  const [x, y] = await page.evaluate(() => cppr.arrow.screen());
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 20, y + 60, { steps: 12 });
  await settled(page);
  await page.mouse.move(x - 20, y + 61);
  const tip = await settled(page);
  const at = await page.evaluate(() => cppr.arrow.screen());
  await page.mouse.up();
  assert.ok(before[1] - tip[1] > 10, `the tip went from ${before} to ${tip}`);
  // One translation and one rotation cannot take the tip everywhere in the plane of the screen.
  assert.ok(Math.abs(at[1] - (y + 61)) < 8, `the tip is at ${at}, the pointer at ${[x - 20, y + 61]}`);
  const { pull_mm, rotate_deg } = await page.evaluate(() => cppr.store.scenario.actuator[0]);
  near(tip, tipOf(solve("robots/r1.toml", "--pull", `${pull_mm}mm`, "--rotate", `${rotate_deg}deg`)), 1e-3);
  assert.ok(Math.abs(Number(await slider("Pull (mm)").inputValue()) - pull_mm) < 1e-3, "the slider shows it");
  await page.keyboard.press("Control+z");
  near(await settled(page), [150, 0, 0], 1e-6);
  await page.getByRole("button", { name: "a force" }).click();
});

test("the trace has gaps where the tip jumps, and reset clears it", async () => {
  await page.getByLabel("tip trace").check();
  await reset();
  for (let i = 1; i <= 6; i++) {
    await pull(i / 2);
    await settled(page);
  }
  const trace = () => page.evaluate(() => cppr.stage.tracePoints);
  const smooth = await trace();
  assert.ok(smooth.length > 4 && smooth.every((p) => !p.gap));
  await pull(-5);
  await settled(page);
  assert.deepEqual((await trace()).filter((p) => p.gap).length, 2, "one gap");
  await reset();
  const [first, ...others] = await trace();
  near(first.at, [150, 0, 0], 1e-6);
  assert.equal(others.length, 0);
  await page.getByLabel("tip trace").uncheck();
});

test("an unstable shape can be left for a stable one", async () => {
  await drop(page, "r3.toml", readFileSync(join(root, "robots/r3.toml"), "utf8"));
  await page.waitForFunction(() => document.title.startsWith("R3"));
  await settled(page);
  await page.evaluate(() => cppr.store.change((s) => {
    s.actuator[0].pull_mm = -5;
    s.tip.force_N = [-2, 0, 0];
  }));
  await settled(page);
  const go = page.getByRole("button", { name: "To a stable shape" });
  await go.click();
  await settled(page);
  await page.waitForFunction(() => cppr.store.pose.status === "converged");
  const want = solve("robots/r3.toml", "--pull", "-5mm", "--tip-force", "-2,0,0N").stable_aside.tip_position_m.map((v) => 1e3 * v);
  const got = await page.evaluate(() => cppr.store.pose.tip_mm);
  // Of two that mirror each other either is one.
  near([got[0], got[1], Math.abs(got[2])], [want[0], want[1], Math.abs(want[2])], 1e-4);
  assert.ok(await go.isHidden());
});

test("how hard the tubes press is drawn, and between which poses friction leaves the robot is told, once the robot is at rest", async () => {
  const original = readFileSync(join(root, "robots/r1.toml"), "utf8");
  await drop(page, "r1.toml", original);
  await page.waitForFunction(() => document.title.startsWith("R1"));
  await settled(page);
  const panel = page.getByRole("group", { name: "Friction" });
  const rubbed = page.locator(".rubbed");
  const fresh = () => page.waitForFunction(() => cppr.source.idle && cppr.plots.pressed.pose && !cppr.plots.pressed.stale);
  const quantity = page.getByLabel("Plotted quantity").last();
  await quantity.selectOption("contact");
  await pull(5);
  assert.equal(await page.locator(".plots figure.stale").count(), 1, "what is drawn is of another pose");
  await fresh();
  assert.equal(await page.locator(".plots figure.stale").count(), 0);
  assert.ok(await rubbed.isHidden(), "no friction unless it is asked for");
  const told = solve("robots/r1.toml", "--pull", "5mm", "--contact", "--friction", "0.2", "--guide", "20mm");
  const { contact } = told;
  const most = Math.max(...contact.pairs[0].force_N_m.map((f) => Math.hypot(...f))) * 1e-3;
  const drawn = await page.evaluate(() => cppr.plots.plots[2].lines().map((l) => Math.max(...l.values)));
  assert.ok(drawn.length === 1 && Math.abs(drawn[0] / most - 1) < 1e-3, `${drawn} instead of ${most}`);
  const before = await page.evaluate(() => cppr.store.pose.id);
  await panel.getByRole("spinbutton", { name: "μ" }).fill("0.2");
  await panel.getByRole("spinbutton", { name: "Guide" }).fill("20");
  await rubbed.getByText("driven on").waitFor();
  await fresh();
  assert.equal(await page.evaluate(() => cppr.store.pose.id), before, "friction changes no pose");
  const cells = await rubbed.locator("tr").evaluateAll((rows) => rows.map((r) => [...r.querySelectorAll("td")].map((c) => Number(c.textContent.replace("−", "-").split(" ")[0]))));
  [told.friction.loading, told.friction.unloading].forEach((side, i) => {
    assert.ok(Math.abs(cells[2][i] - 1e3 * side.tip_position_m[1]) < 0.006, `tip ${cells[2]}`);
    assert.ok(Math.abs(cells[4][i] - side.actuators[1].tension_N) < 6e-4, `pull ${cells[4]}`);
  });
  await panel.getByRole("spinbutton", { name: "μ" }).fill("0");
  await fresh();
  assert.ok(await rubbed.isHidden());
  // A file that says how its tubes rub.
  await drop(page, "rubs.toml", `${original.replace('"R1"', '"Rubs"')}\n[friction]\ncoefficient = 0.3\n`);
  await page.waitForFunction(() => document.title.startsWith("Rubs"));
  assert.equal(await panel.getByRole("spinbutton", { name: "μ" }).inputValue(), "0.3");
  await pull(3);
  await rubbed.getByText("Friction 0.3").waitFor();
  await quantity.selectOption("axial_force");
});

test("with three tubes everything at the right is seen on a screen of 768 pixels", async () => {
  await drop(page, "childs3.toml", readFileSync(join(root, "robots/childs3.toml"), "utf8"));
  await page.waitForFunction(() => document.title.startsWith("Childs3"));
  await settled(page);
  await page.waitForFunction(() => document.querySelectorAll(".plots figure path").length === 9);
  const { scrolls, plots } = await page.evaluate(() => {
    const side = document.querySelector(".right");
    return { scrolls: side.scrollHeight - side.clientHeight, plots: [...document.querySelectorAll(".plots figure svg")].map((s) => s.getBoundingClientRect().height) };
  });
  assert.ok(scrolls <= 1, `${scrolls} px are hidden`);
  assert.ok(plots.every((h) => h > 60), `plots of ${plots} px`);
  assert.deepEqual(grave(errors), []);
});
