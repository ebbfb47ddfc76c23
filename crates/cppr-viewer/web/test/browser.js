// Starts the program and a browser for it. Everything ends with `close`.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const root = join(dirname(fileURLToPath(import.meta.url)), "../../../..");
export const program = process.env.CPPR ?? join(root, "target/release/cppr");

/** The program `cppr view`, its address, and how to end it. */
export async function view(robot, options = []) {
  const child = spawn(program, ["view", robot, "--no-open", ...options], { cwd: root, stdio: ["ignore", "pipe", "inherit"] });
  const ended = new Promise((resolve) => child.on("exit", (code, signal) => resolve({ code, signal })));
  // Nothing outlives a test that fails.
  process.on("exit", () => child.kill("SIGKILL"));
  const address = await new Promise((resolve, reject) => {
    let text = "";
    child.stdout.on("data", (data) => {
      text += data;
      const found = text.match(/http:\/\/\S+/);
      if (found) resolve(found[0]);
    });
    child.on("exit", () => reject(new Error(`cppr view ended: ${text}`)));
  });
  return {
    address,
    pid: child.pid,
    ended,
    close: async (signal = "SIGINT") => {
      child.kill(signal);
      return ended;
    },
  };
}

/** A browser with a profile of its own. */
export async function browser({ width = 1366, height = 768, theme = "light" } = {}) {
  const profile = mkdtempSync(join(tmpdir(), "cppr-viewer-"));
  const executablePath = process.env.CHROMIUM ?? ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
  const context = await chromium.launchPersistentContext(profile, {
    executablePath,
    headless: true,
    viewport: { width, height },
    colorScheme: theme,
    acceptDownloads: true,
    args: [
      "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
      "--disable-sync", "--enable-unsafe-swiftshader", "--use-angle=swiftshader",
    ],
  });
  return {
    context,
    close: async () => {
      await context.close();
      rmSync(profile, { recursive: true, force: true });
    },
  };
}

/** A page that notes its errors and every request. */
export async function open(context, address) {
  const page = await context.newPage();
  page.setDefaultTimeout(10_000);
  const [errors, requests] = [[], []];
  page.on("console", (m) => ["error", "warning"].includes(m.type()) && errors.push(m.text()));
  page.on("pageerror", (e) => errors.push(String(e)));
  page.on("request", (r) => requests.push(r.url()));
  page.on("websocket", (w) => requests.push(w.url()));
  await page.goto(address);
  await page.waitForFunction(() => window.cppr?.store.pose);
  return { page, errors, requests };
}
