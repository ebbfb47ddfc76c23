// The site, opened from its folder: the book leads to the page that solves by itself, which gives what the program gives, takes
// links that carry robot and state, and talks to nobody.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { browser, open, root } from "./browser.js";
import { drop, eventually, grave, near, settled, solve, tipOf } from "./helpers.js";

let chrome, folder, address;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), "cppr-alone-"));
  execFileSync(join(root, "site.sh"), [join(folder, "site")], { stdio: ["ignore", "inherit", "inherit"] });
  address = pathToFileURL(join(folder, "site/live/index.html")).href;
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  rmSync(folder, { recursive: true, force: true });
});

const set = (page, edit) => page.evaluate(`cppr.store.change((s) => { ${edit} })`);

test("the book leads to the page and fetches nothing", async () => {
  const page = await chrome.context.newPage();
  const requests = [];
  page.on("request", (r) => requests.push(r.url()));
  await page.goto(pathToFileURL(join(folder, "site/index.html")).href);
  await page.getByRole("link", { name: "Robot files" }).first().click();
  await page.getByRole("heading", { name: "Robot files" }).waitFor();
  await page.goBack();
  await page.getByRole("link", { name: "Try it: the live view" }).click();
  await page.waitForFunction(() => window.cppr?.store.pose);
  assert.equal(page.url(), address);
  assert.deepEqual(requests.filter((u) => !/^(file|data|blob):/.test(u)), []);
  await page.close();
});

test("takes a robot of parts and joints", async () => {
  const { page, errors } = await open(chrome.context, address);
  // A while after a change the page asks for the safe ranges, which take such a robot a minute: those that a change of the old robot has set going
  // are not asked of it.
  await page.evaluate(() => {
    const send = cppr.source.send;
    cppr.source.send = (message) => {
      if (message.ranges) cppr.asked = cppr.store.robot.name;
      send.call(cppr.source, message);
    };
  });
  await set(page, "s.actuator[0].pull_mm = 1");
  await drop(page, "two_sections.toml", readFileSync(join(root, "robots/bundles/two_sections.toml"), "utf8"));
  await eventually(() => page.evaluate(() => cppr.store.robot?.name === "Two sections" && cppr.source.idle), "the dropped robot is shown");
  await set(page, "s.actuator.find((a) => a.tube === 2).pull_mm = 3");
  near(await settled(page), tipOf(solve("robots/bundles/two_sections.toml", "--pull", "2=3mm")), 1e-4);
  await page.waitForTimeout(500);
  assert.notEqual(await page.evaluate(() => cppr.asked), "Two sections");
  assert.deepEqual(grave(errors), []);
  await page.close();
});

test("solves what the program solves, without a request", async () => {
  const { page, errors, requests } = await open(chrome.context, address);
  assert.equal(await page.title(), "R1 – cppr");
  near(await settled(page), [150, 0, 0], 1e-9);
  await set(page, "s.actuator[0].pull_mm = 5; s.actuator[0].rotate_deg = 20; s.tip.force_N = [0, 0, 0.1]");
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "5mm", "--rotate", "20deg", "--tip-force", "0,0,0.1N")), 1e-4);
  await set(page, "s.actuator[0].pull_mm = 149");
  await settled(page);
  assert.match(await page.getByRole("alert").textContent(), /not converged/);
  await set(page, "s.actuator[0].pull_mm = 1");
  await settled(page);
  assert.ok(await page.getByRole("alert").isHidden());
  assert.ok(await page.evaluate(() => cppr.stage.tubes.every((t) => t.mesh.visible)));
  assert.deepEqual(grave(errors), []);
  assert.deepEqual(requests.filter((u) => !/^(data|blob):/.test(u)), [address]);
  const barred = await page.evaluate(() => fetch("http://127.0.0.1:9/").then(() => "sent", (e) => String(e)));
  assert.match(barred, /TypeError/);
  await page.close();
});

test("takes robots that are dropped or chosen, and says what is wrong with one", async () => {
  const { page, errors } = await open(chrome.context, address);
  await drop(page, "childs3.toml", readFileSync(join(root, "robots/childs3.toml"), "utf8"));
  await eventually(() => page.evaluate(() => cppr.store.robot?.name === "Childs3" && cppr.source.idle), "the dropped robot is shown");
  await set(page, "s.actuator[1].pull_mm = 1");
  near(await settled(page), tipOf(solve("robots/childs3.toml", "--pull", "3=1mm")), 1e-4);
  await page.getByRole("combobox", { name: "Robot", exact: true }).selectOption("helicoid.toml");
  await eventually(() => page.evaluate(() => cppr.store.robot?.name === "Helicoid" && cppr.source.idle), "the chosen robot is shown");
  await set(page, "s.actuator[0].pull_mm = 6");
  near(await settled(page), tipOf(solve("robots/helicoid.toml", "--pull", "6mm")), 1e-4);
  await drop(page, "bad.toml", 'name = "Bad"\nlength = 3\n');
  await page.getByRole("dialog").getByText("length_mm").first().waitFor();
  assert.deepEqual(grave(errors), []);
  await page.close();
});

test("shows the workspace, and answers while it is solved", async () => {
  const { page } = await open(chrome.context, address);
  await page.getByRole("checkbox", { name: "workspace" }).check();
  await set(page, "s.actuator[0].pull_mm = 3");
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "3mm")), 1e-4);
  await page.close();
});

test("a link carries robot and state", async () => {
  const { page } = await open(chrome.context, address);
  await drop(page, "mine.toml", readFileSync(join(root, "robots/r3.toml"), "utf8").replace('"R3"', '"Mine ≤"'));
  await eventually(() => page.evaluate(() => cppr.store.robot?.name === "Mine ≤" && cppr.source.idle), "the dropped robot is shown");
  await set(page, "s.actuator[0].pull_mm = 4; s.tip.force_N = [0, 0, 0.2]");
  const tip = await settled(page);
  await page.getByRole("button", { name: "Link" }).click();
  await page.waitForFunction(() => location.hash.length > 100);
  const link = page.url();
  assert.ok(link.length < 2000, `${link.length} characters`);
  await page.close();
  const other = await open(chrome.context, link);
  assert.equal(await other.page.title(), "Mine ≤ – cppr");
  near(await settled(other.page), tip, 1e-6);
  assert.deepEqual(grave(other.errors), []);
  await other.page.close();
});

test("a link that is cut says so and shows the first robot", async () => {
  const page = await chrome.context.newPage();
  await page.goto(`${address}#eJxkdkd-`);
  await page.getByRole("dialog").getByText("copy it again").waitFor();
  await page.waitForFunction(() => window.cppr?.store.pose);
  assert.equal(await page.title(), "R1 – cppr");
  await page.close();
});

test("a solver that stops is started again", async () => {
  const { page } = await open(chrome.context, address);
  await set(page, "s.actuator[0].pull_mm = 2");
  await settled(page);
  await page.evaluate(() => cppr.source.drop());
  await eventually(() => page.evaluate(() => cppr.source.idle), "it answers again");
  await set(page, "s.actuator[0].pull_mm = 5");
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "5mm")), 1e-4);
  await page.close();
});
