// The page as a person uses it, against what the program says.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { browser, open, root, view } from "./browser.js";
import { drop, eventually, grave, near, settled, solve, tipOf } from "./helpers.js";

let server, chrome, page, errors, requests;
before(async () => {
  server = await view("robots/r3.toml");
  chrome = await browser();
  ({ page, errors, requests } = await open(chrome.context, server.address));
});
after(async () => {
  await chrome?.close();
  await server?.close();
});

const slider = (label) => page.getByRole("slider", { name: label });
const scenario = () => page.evaluate(() => cppr.store.scenario);

test("the page shows the robot at rest", async () => {
  near(await settled(page), [150, 0, 0], 1e-9);
  assert.equal(await page.title(), "R3 – cppr");
  assert.equal(await page.locator(".status").textContent(), "converged, stable");
  assert.ok(await page.evaluate(() => cppr.stage.tubes.every((t) => t.mesh.visible && t.mesh.geometry.index.count > 3000)));
});

test("a slider moves the tip by what the program says", async () => {
  await slider("Pull (mm)").fill("5");
  near(await settled(page), tipOf(solve("robots/r3.toml", "--pull", "5mm")), 1e-6);
  await slider("Pull (mm)").fill("-8");
  await slider("Turn (°)").fill("40");
  near(await settled(page), tipOf(solve("robots/r3.toml", "--pull", "-8mm", "--rotate", "40deg")), 1e-6);
});

test("the error of the modes is told once nothing changes", async () => {
  const row = page.getByRole("row", { name: /^Error/ });
  await eventually(async () => /\de-\d+ mm/.test(await row.textContent()), "no error is told");
});

test("shapes do not wait for pictures, and no picture is drawn for nothing", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await settled(page);
  const count = await page.evaluate(async () => {
    const { store, source, stage } = cppr;
    let [shapes, pictures, frames, bytes] = [0, 0, 0, 0];
    const draw = stage.drawNow;
    stage.drawNow = (smooth) => {
      pictures++;
      draw.call(stage, smooth);
    };
    const tick = () => {
      frames++;
      if (shapes < 100) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    while (shapes < 100) {
      const answer = new Promise((resolve) => {
        source.addEventListener("message", function take({ detail }) {
          if (detail.kind !== "pose") return;
          source.removeEventListener("message", take);
          resolve(detail);
        });
      });
      store.change((s) => (s.actuator[0].pull_mm = 5 * Math.sin(shapes / 9)));
      const detail = await answer;
      bytes = Math.max(bytes, detail.floats.byteLength);
      shapes++;
    }
    stage.drawNow = draw;
    return { pictures, frames, bytes };
  });
  assert.ok(count.pictures <= count.frames + 2, `${count.pictures} pictures in ${count.frames} frames of the screen`);
  assert.equal(count.bytes, 97 * 2 * 21 * 4);
});

test("a picture in haste is coarser, one at rest is whole again", async () => {
  await page.evaluate(() => cppr.store.change((s) => (s.actuator[0].pull_mm = 3)));
  await settled(page);
  const cost = (smooth) =>
    page.evaluate((smooth) => {
      const { stage } = cppr;
      stage.renderer.info.autoReset = false;
      stage.renderer.info.reset();
      stage.drawNow(smooth);
      stage.renderer.info.autoReset = true;
      const { triangles, calls } = stage.renderer.info.render;
      return { triangles, calls };
    }, smooth);
  const [haste, rest] = [await cost(false), await cost(true)];
  assert.ok(haste.calls <= 12, `${haste.calls} draw calls`);
  assert.ok(haste.triangles < 9000, `${haste.triangles} triangles`);
  assert.ok(rest.triangles > 1.7 * haste.triangles, `${rest.triangles} triangles at rest, ${haste.triangles} in haste`);
  await page.waitForFunction(() => !cppr.stage.moving);
});

test("force instead of motion takes over where the robot stands", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await slider("Pull (mm)").fill("5");
  const before = await settled(page);
  await page.getByRole("button", { name: "N", exact: true }).click();
  near(await settled(page), before, 0.02);
  assert.equal((await scenario()).actuator[0].pull_mm, undefined);
  await page.locator("#" + (await page.getByLabel("Pull", { exact: true }).getAttribute("id"))).fill("2");
  near(await settled(page), tipOf(solve("robots/r3.toml", "--tension", "2N")), 1e-6);
});

test("undo and redo", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await settled(page);
  await slider("Pull (mm)").fill("4");
  const bent = await settled(page);
  await page.keyboard.press("Control+z");
  near(await settled(page), [150, 0, 0], 1e-9);
  assert.equal(await slider("Pull (mm)").inputValue(), "0");
  await page.keyboard.press("Control+Shift+z");
  near(await settled(page), bent, 1e-6);
});

test("the keyboard does it all", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await slider("Pull (mm)").focus();
  for (let i = 0; i < 3; i++) await page.keyboard.press("ArrowRight");
  const { pull_mm } = (await scenario()).actuator[0];
  assert.ok(pull_mm > 0);
  near(await settled(page), tipOf(solve("robots/r3.toml", "--pull", `${pull_mm}mm`)), 1e-6);
  const camera = () => page.evaluate(() => cppr.stage.camera.position.toArray());
  await page.locator("canvas").focus();
  const before = await camera();
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("+");
  assert.notDeepEqual(await camera(), before);
  await page.keyboard.press("2");
  const [x, y, z] = await camera();
  assert.ok(z > 10 * Math.abs(y) && x > 0, "the second view looks from above");
  await page.keyboard.press("1");
});

test("the force is dragged by its handle", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await settled(page);
  const [x, y] = await page.evaluate(() => cppr.arrow.screen());
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 20, y + 60, { steps: 5 });
  await page.mouse.up();
  const force = (await scenario()).tip.force_N;
  assert.ok(Math.hypot(...force) > 0.05, `${force}`);
  near(await settled(page), tipOf(solve("robots/r3.toml", "--tip-force", `${force}N`)), 1e-5);
});

test("gravity, stretch, formulation", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await slider("Pull (mm)").fill("9");
  await page.getByRole("button", { name: "−Z" }).click();
  await page.getByLabel("tubes stretch").check();
  near(await settled(page), tipOf(solve("robots/r3.toml", "--pull", "9mm", "--gravity", "0,0,-9.81m/s2", "--stretch")), 1e-5);
  await page.getByLabel("tubes stretch").uncheck();
  await page.getByRole("button", { name: "none" }).click();
  await page.getByRole("button", { name: "printed" }).click();
  near(await settled(page), tipOf(solve("robots/r3.toml", "--pull", "9mm", "--formulation", "printed")), 1e-5);
  await page.getByRole("button", { name: "consistent" }).click();
});

test("deeper notches, and the whole state as a file that the program reads", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await slider("Pull (mm)").fill("6");
  const before = await settled(page);
  await slider("Tube 1 (mm)").fill("0.2");
  const after = await settled(page);
  assert.ok(Math.hypot(...after.map((v, i) => v - before[i])) > 0.1, `deeper notches move the tip from ${before} to ${after}`);
  await slider("Z (N)").fill("-0.05");
  const tip = await settled(page);
  await page.getByText("Save", { exact: true }).click();
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "State (TOML)" }).click()]);
  const path = join(mkdtempSync(join(tmpdir(), "cppr-state-")), "state.toml");
  await download.saveAs(path);
  near(tipOf(solve("robots/r3.toml", "--scenario", path)), tip, 1e-5);
  // And back again.
  await page.getByRole("button", { name: "Reset" }).click();
  near(await settled(page), [150, 0, 0], 1e-9);
  await drop(page, "state.toml", readFileSync(path, "utf8"));
  await page.waitForFunction(() => cppr.store.scenario.notches?.length === 1);
  near(await settled(page), tip, 1e-5);
});

test("modes and refinement of a scenario are shown, kept through a reset, and written again", async () => {
  await drop(page, "fine.toml", 'formulation = "consistent"\nmodes = "planar"\nrefine = 2\n[[actuator]]\ntube = 2\npull_mm = 5.0\n');
  await page.waitForFunction(() => cppr.store.scenario.refine === 2);
  const tip = await settled(page);
  near(tipOf(solve("robots/r3.toml", "--pull", "5mm", "--planar", "--refine", "2")), tip, 1e-5);
  const pressed = (name) => page.getByRole("group", { name, exact: true }).locator('[aria-pressed="true"]').textContent();
  await page.getByRole("button", { name: "Reset" }).click();
  await settled(page);
  assert.deepEqual([await pressed("Modes"), await pressed("Times as many modes")], ["planar", "×2"]);
  await page.getByText("Save", { exact: true }).click();
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "State (TOML)" }).click()]);
  const text = readFileSync(await download.path(), "utf8");
  assert.match(text, /^modes = "planar"$/m);
  assert.match(text, /^refine = 2$/m);
  await page.getByRole("group", { name: "Modes", exact: true }).getByRole("button", { name: "default" }).click();
  await page.getByRole("button", { name: "×1" }).click();
});

test("where there is no equilibrium the reason is shown and the last shape dimmed", async () => {
  await page.getByRole("button", { name: "Reset" }).click();
  await slider("Pull (mm)").fill("5");
  const good = await settled(page);
  await page.evaluate(() => cppr.store.change((s) => (s.actuator[0].pull_mm = 149)));
  await page.waitForFunction(() => cppr.source.idle);
  const alert = await page.getByRole("alert").textContent();
  assert.match(alert, /not converged: applied step by step from rest, no equilibrium was found beyond/);
  assert.ok(await page.evaluate(() => cppr.stage.painted.dimmed));
  near(await settled(page), good, 1e-9);
  await page.evaluate(() => cppr.store.change((s) => (s.actuator[0].pull_mm = 500)));
  await page.waitForFunction(() => cppr.source.idle);
  assert.match(await page.getByRole("alert").textContent(), /only 150.000 mm long/);
  await slider("Pull (mm)").fill("5");
  near(await settled(page), good, 1e-6);
  assert.ok(await page.getByRole("alert").isHidden());
});

test("a broken file shows all its problems, a sound one its robot", async () => {
  const broken = readFileSync(join(root, "robots/r1.toml"), "utf8").replace("depth_mm = 5.0", "depth_mm = 50.0").replace("length_mm = 150.0", "lenght_mm = 150.0");
  await drop(page, "broken.toml", broken);
  const dialog = page.getByRole("dialog");
  await dialog.waitFor();
  const text = await dialog.textContent();
  for (const part of ["broken.toml", "lenght_mm", "depth_mm", "line "]) assert.ok(text.includes(part), `${part} is missing in ${text}`);
  assert.ok((await dialog.getByRole("listitem").count()) >= 2);
  await page.keyboard.press("Escape");
  assert.equal(await page.title(), "R3 – cppr");
  for (const [name, bytes] of [["empty.toml", ""], ["binary.toml", "\0\u0001\u0002"], ["large.toml", "#".repeat(2_000_000)]]) {
    await drop(page, name, bytes);
    await dialog.waitFor();
    await page.keyboard.press("Escape");
    await dialog.waitFor({ state: "hidden" });
  }
  await drop(page, "childs3.toml", readFileSync(join(root, "robots/childs3.toml"), "utf8"));
  await page.waitForFunction(() => document.title.startsWith("Childs3"));
  near(await settled(page), [30, 0, 0], 1e-9);
  await slider("Pull (mm)").first().fill("1");
  near(await settled(page), tipOf(solve("robots/childs3.toml", "--pull", "2=1mm")), 1e-6);
  assert.ok(await page.getByRole("button", { name: "−Z" }).isDisabled(), "a robot without mass has no weight");
});

test("the connection comes back with robot and command", async () => {
  const before = await settled(page);
  await page.evaluate(() => {
    window.lost = false;
    cppr.source.addEventListener("lost", () => (window.lost = true));
    cppr.source.drop();
  });
  await page.waitForFunction(() => window.lost && cppr.source.idle && cppr.stage.pose);
  assert.ok((await page.title()).startsWith("Childs3"));
  near(await settled(page), before, 1e-6);
  assert.ok(await page.getByRole("alert").isHidden());
});

test("pictures, workspace, frames, colours", async () => {
  await page.getByLabel("workspace").check();
  await page.waitForFunction(() => cppr.stage.cloud.geometry.getAttribute("position")?.count > 3000, null, { timeout: 30000 });
  await page.getByLabel("workspace").uncheck();
  await drop(page, "r3.toml", readFileSync(join(root, "robots/r3.toml"), "utf8"));
  await page.waitForFunction(() => document.title.startsWith("R3"));
  await slider("Pull (mm)").fill("9");
  await settled(page);
  for (const label of ["section frames", "tip trace", "see-through"]) await page.getByLabel(label).check();
  for (const colour of ["curvature", "strain", "closure", "tube"]) {
    await page.getByLabel("Colour by").selectOption(colour);
    assert.equal(await page.locator(".legend").isVisible(), colour !== "tube");
  }
  for (const [name, kind] of [["Picture (PNG)", /^\u0089PNG|^�PNG/], ["Picture (SVG)", /^<svg/]]) {
    await page.getByText("Save", { exact: true }).click();
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name }).click()]);
    const data = readFileSync(await download.path());
    assert.ok(data.length > 20_000, `${name}: ${data.length} bytes`);
    assert.match(data.toString("utf8").slice(0, 10), kind);
  }
  const shapes = await page.evaluate(() => new DOMParser().parseFromString(cppr.svg(), "image/svg+xml").querySelectorAll("path").length);
  assert.ok(shapes > 50, `${shapes} faces`);
});

test("nothing went wrong on the way, and no request left the machine", () => {
  assert.deepEqual(grave(errors), []);
  const { host } = new URL(server.address);
  assert.ok(requests.length >= 4);
  for (const url of requests.filter((u) => !/^(data|blob):/.test(u))) assert.equal(new URL(url).host, host, url);
});
