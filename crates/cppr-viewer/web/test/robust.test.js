// What goes wrong between a page and a server: strangers, bursts, nonsense, lost connections, many tabs.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFileSync } from "node:fs";
import { request } from "node:http";
import { after, before, test } from "node:test";
import { browser, open, program, root, view } from "./browser.js";
import { eventually, grave, near, settled, solve, threads, tipOf } from "./helpers.js";

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

/** Status of a request with these headers. */
const status = (path, headers) =>
  new Promise((resolve, reject) => {
    const { port } = new URL(server.address);
    const asked = request({ host: "127.0.0.1", port, path, headers }, (answer) => {
      answer.resume();
      resolve(answer.statusCode);
    });
    asked.on("upgrade", (answer, socket) => {
      socket.destroy();
      resolve(answer.statusCode);
    });
    asked.on("error", reject);
    asked.end();
  });

test("strangers are turned away", async () => {
  const { pathname, host } = new URL(server.address);
  assert.equal(await status(pathname, {}), 200);
  assert.equal(await status("/", {}), 404);
  assert.equal(await status(pathname.replace(/[0-9a-f]{4}/, "0000"), {}), 404);
  assert.equal(await status(pathname, { Host: "evil.example" }), 403);
  assert.equal(await status(pathname, { Origin: "http://evil.example" }), 403);
  const socket = { Connection: "Upgrade", Upgrade: "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==" };
  assert.equal(await status(`${pathname}live`, { ...socket, Origin: `http://${host}` }), 101);
  assert.equal(await status(`${pathname}live`, { ...socket, Origin: "http://evil.example" }), 403);
  assert.equal(await status(`${pathname}live`, { ...socket, Host: "evil.example" }), 403);
});

test("a thousand slider events end where the last one says", async () => {
  const [milliseconds, asked] = await page.evaluate(async () => {
    const slider = document.querySelector("input[type=range]");
    const begin = performance.now();
    const before = cppr.source.times.length;
    for (let i = 1; i <= 1000; i++) {
      slider.value = -7 + (14 * i) / 1000;
      slider.dispatchEvent(new Event("input"));
    }
    while (!cppr.source.idle) await new Promise((r) => setTimeout(r, 5));
    return [performance.now() - begin, cppr.source.times.length - before];
  });
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "7mm")), 1e-6);
  assert.ok(asked < 1000, `${asked} requests for one state`);
  assert.ok(milliseconds < 10_000, `${milliseconds} ms`);
});

test("a thousand requests at once are merged, and the newest is answered", async () => {
  const answered = await page.evaluate(async () => {
    const socket = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
    socket.binaryType = "arraybuffer";
    await new Promise((r) => (socket.onopen = r));
    const ids = [];
    const done = new Promise((resolve) => {
      socket.onmessage = ({ data }) => {
        if (typeof data === "string") return;
        const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, new DataView(data).getUint32(0, true))));
        if (head.kind === "pose") ids.push(head.id);
        if (head.id === 1000) resolve();
      };
    });
    socket.send(JSON.stringify({ robot: null }));
    for (let id = 1; id <= 1000; id++) {
      socket.send(JSON.stringify({ solve: { id, scenario: { actuator: [{ tube: 2, pull_mm: 6 * Math.sin(id) }] } } }));
    }
    await done;
    socket.close();
    return ids;
  });
  assert.equal(answered.at(-1), 1000);
  assert.ok(answered.every((id, i) => i === 0 || id > answered[i - 1]), "answers in order");
});

test("nonsense is answered with a sentence and harms nobody", async () => {
  const answers = await page.evaluate(async () => {
    const socket = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
    socket.binaryType = "arraybuffer";
    await new Promise((r) => (socket.onopen = r));
    const ask = (message) =>
      new Promise((resolve) => {
        socket.onmessage = ({ data }) => typeof data === "string" && resolve(JSON.parse(data));
        socket.send(message);
      });
    const solve = (scenario) => JSON.stringify({ solve: { id: 1, scenario } });
    const list = [];
    for (const message of ["", "x", "{}", "[1,2]", '{"solve":1}', '{"solve":{"id":-1,"scenario":{}}}', '{"fly":{}}', new Uint8Array([1, 2, 3]), solve({})]) {
      list.push(await ask(message));
    }
    await ask('{"robot":null}');
    for (const scenario of [
      { actuator: [{ tube: 2, pull_mm: 1e300 }] },
      { actuator: [{ tube: 9, pull_mm: 1 }] },
      { actuator: [{ tube: 2, pull_mm: 1, tension_N: 1 }] },
      { actuator: [{ tube: 2 }, { tube: 2 }] },
      { tip: { force_N: [1e30, 0, 0] } },
      { point_force: [{ at_mm: 1e9, force_N: [0, 1, 0] }] },
      { notches: [{ tube: 1, deeper_mm: 100 }] },
      { notches: [{ tube: 0, deeper_mm: 0.1 }] },
    ]) {
      list.push(await ask(solve(scenario)));
    }
    list.push(await ask('{"workspace":{"scenario":{},"ranges":[{"tube":7,"pull_mm":[0,1],"rotate_deg":[0,1]}],"count":5}}'));
    list.push(await ask('{"robot":{"name":"a.toml","text":"x"}}'));
    list.push(await ask('{"read_scenario":{"name":"b.toml","text":"pull = 3"}}'));
    const closed = new Promise((r) => (socket.onclose = r));
    socket.send("y".repeat(5_000_000));
    await closed;
    return list;
  });
  for (const answer of answers) {
    assert.ok(["problem", "refused", "bad_file"].includes(answer.kind), JSON.stringify(answer));
    const text = answer.text ?? (answer.reasons ?? answer.problems).join();
    assert.ok(text.length > 15, JSON.stringify(answer));
  }
  await page.evaluate(() => cppr.store.change((s) => (s.actuator[0].pull_mm = 3)));
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "3mm")), 1e-6);
});

test("tabs are independent, and what they used is given back", async () => {
  const idle = threads(server.pid);
  const memory = () => Number(readFileSync(`/proc/${server.pid}/status`, "utf8").match(/VmRSS:\s+(\d+)/)[1]);
  const second = await open(chrome.context, server.address);
  assert.equal(threads(server.pid), idle + 1);
  await second.page.evaluate(() => cppr.store.change((s) => (s.actuator[0].pull_mm = -5)));
  near(await settled(second.page), tipOf(solve("robots/r1.toml", "--pull", "-5mm")), 1e-6);
  near(await settled(page), tipOf(solve("robots/r1.toml", "--pull", "3mm")), 1e-6);
  await second.page.close();
  await eventually(() => threads(server.pid) === idle, "the solver of a closed tab goes on");
  // Connections that ask for much and go away without reading the answers.
  const churn = () =>
    page.evaluate(async () => {
      for (let i = 0; i < 40; i++) {
        const socket = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
        await new Promise((r) => (socket.onopen = r));
        socket.send('{"robot":null}');
        for (let id = 1; id <= 20; id++) socket.send(JSON.stringify({ solve: { id, scenario: { actuator: [{ tube: 2, pull_mm: id / 4 }] } } }));
        socket.close();
        await new Promise((r) => (socket.onclose = r));
      }
    });
  await churn();
  await eventually(() => threads(server.pid) === idle, "solvers without a page go on");
  const before = memory();
  await churn();
  await churn();
  await eventually(() => threads(server.pid) === idle, "solvers without a page go on");
  assert.ok(memory() < before + 20_000, `memory grew from ${before} to ${memory()} kB`);
  assert.deepEqual(grave(errors), []);
});

test("the program ends with Ctrl-C while a page is open, and the page says so", async () => {
  const began = Date.now();
  assert.deepEqual(await server.close("SIGINT"), { code: 0, signal: null });
  assert.ok(Date.now() - began < 2000);
  await eventually(async () => (await page.locator(".banner").textContent()).includes("start it again"), "the page does not say that the program is gone");
});

test("what cannot be served is refused", async () => {
  const run = (...args) =>
    new Promise((resolve) => execFile(program, ["view", ...args], { cwd: root }, (error, out, err) => resolve([error?.code ?? 0, out + err])));
  const [code, text] = await run("robots/none.toml", "--no-open");
  assert.equal(code, 2);
  assert.match(text, /cannot be read/);
  const other = await view("robots/r1.toml");
  const { port } = new URL(other.address);
  const [taken, message] = await run("robots/r1.toml", "--no-open", "--port", port);
  assert.equal(taken, 2);
  assert.match(message, /another program listens there/);
  await other.close();
});
