// Writes the live view as one HTML file that needs no server and no network: the page, its style and script, the kernel and the
// worker that runs it, and the robots that are shipped. Run: node page.js FILE
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const read = (path, encoding = "utf8") => readFileSync(join(root, path), encoding);

/** Nothing may look like the end of the element. */
const inside = (script) => script.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");

const names = readdirSync(join(root, "robots")).filter((f) => f.endsWith(".toml")).sort();
// The first one is shown first.
names.sort((a, b) => (b === "r1.toml") - (a === "r1.toml"));
const robots = JSON.stringify(Object.fromEntries(names.map((name) => [name, read(`robots/${name}`)]))).replaceAll("<", "\\u003c");
const worker = read("crates/cppr-web/dist/kernel.js") + read("crates/cppr-viewer/web/src/worker.js");
const policy = [
  "default-src 'none'", "script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:", "worker-src blob:", "style-src 'unsafe-inline'", "img-src blob: data:",
  "base-uri 'none'", "form-action 'none'",
].join("; ");

const html = `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="${policy}">
<meta name="viewport" content="width=device-width">
<title>cppr</title>
<link rel="icon" href="data:,">
<style>
${read("crates/cppr-viewer/dist/viewer.css")}</style>
</head>
<body>
<div id="app"></div>
<script id="robots" type="application/json">${robots}</script>
<script id="worker" type="text/plain">${inside(worker)}</script>
<script id="kernel" type="text/plain">${read("crates/cppr-web/dist/kernel_bg.wasm", "base64")}</script>
<script>
${inside(read("crates/cppr-viewer/dist/viewer.js"))}</script>
</body>
</html>
`;
const [file] = process.argv.slice(2);
if (!file) {
  console.error("page.js: say where to: node page.js FILE");
  process.exit(2);
}
mkdirSync(dirname(file), { recursive: true });
writeFileSync(file, html);
console.log(`${file}: ${(html.length / 1e6).toFixed(1)} MB`);
