// Bundles the page into ../dist. `node build.js --check` compares instead of writing.
import { build } from "esbuild";
import { readFileSync, writeFileSync, mkdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const dist = join(here, "..", "dist");
const bundled = await build({
  absWorkingDir: here,
  entryPoints: { viewer: "src/main.js" },
  outdir: "out",
  bundle: true,
  minify: true,
  write: false,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  banner: { js: "/* Contains three.js, MIT licence, (c) three.js authors. */" },
});
const files = new Map(bundled.outputFiles.map((f) => [f.path.endsWith(".css") ? "viewer.css" : "viewer.js", f.text]));
files.set("index.html", readFileSync(join(here, "index.html"), "utf8"));

const differing = [];
for (const [name, text] of files) {
  const path = join(dist, name);
  if (!process.argv.includes("--check")) {
    mkdirSync(dist, { recursive: true });
    writeFileSync(path, text);
  } else if (readFileSync(path, "utf8") !== text) {
    differing.push(name);
  }
}
if (differing.length > 0) {
  console.error(`dist/ does not match web/: ${differing.join(", ")}. Run: npm ci && node build.js`);
  process.exit(1);
}
