// Takes the picture of README and book: node picture.js FILE.png

import { browser, open, view } from "./test/browser.js";

const server = await view("robots/r1.toml");
const chrome = await browser({ width: 1440, height: 810 });
const { page } = await open(chrome.context, server.address);
await page.getByRole("slider", { name: "Pull (mm)" }).fill("-6");
await page.getByRole("slider", { name: "Turn (°)" }).fill("60");
await page.evaluate(() => document.activeElement.blur());
await page.waitForFunction(() => cppr.source.idle && !cppr.stage.moving);
await page.screenshot({ path: process.argv[2] });
await chrome.close();
await server.close();
process.exit(0);
