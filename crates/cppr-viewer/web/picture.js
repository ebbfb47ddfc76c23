// Takes the pictures of README and book: node picture.js ROBOT.png BUNDLE.png

import { browser, open, view } from "./test/browser.js";

/** The page in a state that `set` makes of it. */
async function picture(robot, file, set) {
  const server = await view(robot);
  const chrome = await browser({ width: 1440, height: 810 });
  const { page } = await open(chrome.context, server.address);
  await set(page);
  await page.evaluate(() => document.activeElement.blur());
  await page.waitForFunction(() => cppr.source.idle && !cppr.stage.moving);
  await page.screenshot({ path: file });
  await chrome.close();
  await server.close();
}

const [robot, bundle] = process.argv.slice(2);
await picture("robots/r1.toml", robot, async (page) => {
  await page.getByRole("slider", { name: "Pull (mm)" }).fill("-6");
  await page.getByRole("slider", { name: "Turn (°)" }).fill("60");
  await page.getByRole("spinbutton", { name: "μ" }).fill("0.2");
  await page.getByLabel("Plotted quantity").last().selectOption("contact");
  await page.waitForFunction(() => cppr.plots.pressed.pose && !cppr.plots.pressed.stale);
});
await picture("robots/bundles/hybrid.toml", bundle, async (page) => {
  const control = (tube, name) => page.getByRole("group", { name: `Tube ${tube}`, exact: true }).getByRole("spinbutton", { name });
  await control(2, "Pull").fill("1");
  await control(3, "Pull").fill("-10");
  await control(3, "Turn").fill("-60");
  await page.waitForFunction(() => cppr.source.idle);
  await page.getByRole("button", { name: "Fit" }).click();
});
process.exit(0);
