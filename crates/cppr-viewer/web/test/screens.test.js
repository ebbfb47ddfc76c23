// Two robots in two themes, on the screens of a laptop and a projector. With SCREENSHOTS=FOLDER the pictures are kept, to be looked at.

import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { browser, open, view } from "./browser.js";
import { grave, settled } from "./helpers.js";

const keep = process.env.SCREENSHOTS;
const robots = { r3: { pull: "8", colour: "strain" }, childs3: { pull: "1", colour: "tube" } };

for (const [theme, width, height] of [["light", 1366, 768], ["dark", 1920, 1080]]) {
  for (const [robot, { pull, colour }] of Object.entries(robots)) {
    test(`${robot}, ${theme}, ${width} × ${height}`, async () => {
      const chrome = await browser({ width, height, theme });
      const server = await view(`robots/${robot}.toml`);
      try {
        const { page, errors } = await open(chrome.context, server.address);
        await page.getByRole("slider", { name: "Pull (mm)" }).first().fill(pull);
        await page.getByLabel("Colour by").selectOption(colour);
        await settled(page);
        await page.evaluate(() => document.activeElement.blur());
        await page.waitForFunction(() => !cppr.stage.moving);
        await page.screenshot(keep ? { path: join(keep, `${robot}-${theme}.png`) } : {});
        const seen = await page.evaluate(() => {
          // Drawn and read in one go: the buffer is not kept.
          cppr.stage.drawNow();
          const copy = document.createElement("canvas");
          [copy.width, copy.height] = [160, 160];
          const context = copy.getContext("2d");
          context.drawImage(cppr.stage.canvas, 0, 0, 160, 160);
          const { data } = context.getImageData(0, 0, 160, 160);
          const colours = new Set();
          for (let i = 0; i < data.length; i += 4) colours.add((data[i] >> 3 << 10) | (data[i + 1] >> 3 << 5) | (data[i + 2] >> 3));
          const [r, g, b] = data;
          const inside = (node) => node.scrollWidth <= node.clientWidth + 1;
          return {
            colours: colours.size, back: (r + g + b) / 3,
            fits: [...document.querySelectorAll(".side, header, main")].every(inside),
            overflow: document.documentElement.scrollHeight <= innerHeight && document.documentElement.scrollWidth <= innerWidth,
          };
        });
        assert.ok(seen.colours > 20, `only ${seen.colours} colours: is the robot drawn?`);
        assert.ok(theme === "dark" ? seen.back < 60 : seen.back > 200, `background ${seen.back}`);
        assert.ok(seen.fits && seen.overflow, "something is wider than its place");
        assert.deepEqual(grave(errors), []);
      } finally {
        await chrome.close();
        await server.close();
      }
    });
  }
}
