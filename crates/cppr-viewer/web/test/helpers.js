// What tests do with the page.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { program, root } from "./browser.js";

/** What `cppr solve` says, as its JSON. */
export function solve(...args) {
  return JSON.parse(execFileSync(program, ["solve", ...args, "--json", "-"], { cwd: root, stdio: ["ignore", "pipe", "ignore"] }));
}

/** The tip of the program's result (mm). */
export const tipOf = (result) => result.tip_position_m.map((v) => v * 1e3);

/** Waits until nothing is under way; gives the tip on the page (mm). */
export async function settled(page) {
  await page.waitForFunction(() => cppr.source.idle);
  return page.evaluate(() => cppr.store.pose.tip_mm);
}

/** Two points are the same (mm). */
export function near(got, want, tolerance, what = "tip") {
  const distance = Math.hypot(...got.map((v, i) => v - want[i]));
  assert.ok(distance < tolerance, `${what}: ${got} instead of ${want}`);
}

/** Drops a file on the page. */
export async function drop(page, name, text) {
  await page.evaluate(
    ([name, text]) => {
      const data = new DataTransfer();
      data.items.add(new File([text], name));
      document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
    },
    [name, text],
  );
}

/** Number of threads of a process. */
export const threads = (pid) => readdirSync(`/proc/${pid}/task`).length;

/** Tries until it holds, at most five seconds. */
export async function eventually(check, what) {
  for (let i = 0; i < 100; i++) {
    if (await check()) return;
    await new Promise((r) => setTimeout(r, 50));
  }
  assert.fail(what);
}

/** Errors that the page made; drivers of software rendering speak of their speed. */
export const grave = (errors) => errors.filter((e) => !/GL Driver Message|GPU stall/.test(e));
