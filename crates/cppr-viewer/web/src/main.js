// The page: what is asked, who answers, what is shown.

import "./style.css";
import { Arrow } from "./arrow.js";
import { COLOURINGS, COLOURINGS_OF_BUNDLES, Legend, range, sectionValue } from "./colouring.js";
import { controlPanel } from "./panel.js";
import { Rest, Seldom, button, choice, download, el, select, tick } from "./dom.js";
import { png, svg } from "./picture.js";
import { Player, between } from "./player.js";
import { Plots } from "./plots.js";
import { Pose } from "./pose.js";
import { Readout } from "./readout.js";
import { Saved } from "./saved.js";
import { Stage, VIEWS } from "./scene.js";
import { beginsWith, link } from "./link.js";
import { Live, dialServer } from "./source.js";
import { Store, rest, trimmed } from "./store.js";
import { dialWorker, robots, shownFirst } from "./worker-socket.js";

const saved = document.getElementById("saved");
const source = saved ? new Saved(saved.textContent) : new Live(robots ? dialWorker : dialServer);
const store = new Store();

const app = document.getElementById("app");
const name = el("h1", {}, "cppr");
const tools = el("div", { className: "tools" });
const left = el("form", { className: "side left", "aria-label": "Controls", onsubmit: () => false });
const host = el("div", { className: "stage" });
const readout = new Readout();
const banner = el("div", { className: "banner", role: "alert", hidden: true });
const problems = el("dialog", { className: "problems" });
const legend = new Legend();
const scale = el("div", { className: "scale" });
const plots = new Plots((section) => stage.highlight(section));
/** What is to be known of how this robot is solved. */
const remark = el("p", { className: "note" });
const right = el("aside", { className: "side right", "aria-label": "Results" }, readout.node, remark, plots.node);
app.append(el("header", {}, name, tools), el("main", {}, left, host, right), problems);
const stage = new Stage(host);

let robot = null;
let columns = [];
let panel = null;
let refused = null;
let colouring = COLOURINGS.tube;
let again = false;

const arrow = new Arrow(stage, {
  live: source.live,
  pull: (force) => {
    store.change((s) => (s.tip.force_N = force));
    panel?.show();
  },
  reach: (place) => source.solve(store.scenario, { target_mm: place }),
  done: () => store.settle(),
});
const dragged = choice("What is dragged at the tip", [["pull", "a force", "The ring is the head of the force on the tip"], ["reach", "the tip", "The actuators bring the tip to the pointer"]], "pull", (what) => {
  arrow.moves = what === "reach";
  paint();
});
const drag = el("div", { className: "drag", hidden: !source.live }, "Drag ", dragged.node);

/** A motion: between two states that are asked for, or over the poses of a saved page. */
let [first, last] = [null, null];
let moving = false;
const player = new Player({
  go: (part) => {
    if (!source.live) return source.play(part);
    moving = true;
    last ??= structuredClone(store.scenario);
    store.replay(between(first ?? rest(robot), last, part));
    moving = false;
  },
  rest: () => store.settle(),
  ...(source.live ? { mark: () => (first = structuredClone(store.scenario)) } : {}),
});
host.append(legend.node, scale, banner, drag, player.node);
stage.before = () => arrow.face();

function arrowColour() {
  return stage.theme === "dark" ? "#f0c419" : "#b3540a";
}

function paint() {
  const limits = stage.pose && robot ? range(colouring, stage.pose, robot.tubes) : [0, 1];
  const { mode, signed = false } = colouring;
  stage.paint({ mode, signed, range: limits, dimmed: refused !== null });
  legend.set(colouring, limits);
  if (robot) arrow.update(store.scenario.tip.force_N, arrowColour());
}

function bend() {
  const { pose } = store;
  if (!pose) return;
  stage.bend(pose, (t) => sectionValue(colouring, pose, t));
  const limits = range(colouring, pose, robot.tubes);
  const old = stage.painted;
  if (old.dimmed !== (refused !== null) || String(old.range) !== String(limits) || old.mode !== colouring.mode) paint();
  else arrow.update(store.scenario.tip.force_N, arrowColour());
}

/** Readout and plots follow the picture: nobody reads more than twenty a second. */
const numbers = new Seldom(50, () => {
  const { pose } = store;
  if (!pose) return;
  readout.pose(pose, store.scenario);
  aside.hidden = !source.live || robot.bundle || pose.status !== "unstable";
  readout.note.textContent = source.live ? `${pose.iterations} Newton steps, ${(pose.solve_us / 1000).toFixed(2)} ms` : "";
  plots.pose(pose);
});

function begin(description) {
  const changed = description.changed && robot !== null;
  const same = again && robot?.name === description.name && robot.controls.length === description.controls.length;
  again = false;
  robot = description;
  columns = robot.columns;
  name.textContent = robot.name;
  document.title = `${robot.name} – cppr`;
  remark.textContent = robot.note ?? "";
  remark.hidden = !robot.note;
  stage.begin(robot);
  arrow.begin(robot.force_N);
  plots.begin(robot, source.live);
  readout.rubbed.hidden = true;
  choose();
  scale.textContent = `grid ${stage.gridStep} mm`;
  store.pose = null;
  if (changed) return;
  if (same) {
    store.robot = robot;
    source.solve(store.scenario, { from_rest: true });
  } else {
    refused = null;
    first = null;
    store.begin(robot);
    stage.look("space");
  }
  panel = source.live ? controlPanel(store, robot) : source.panel();
  left.replaceChildren(...panel.nodes, ...views());
  const scenario = linked;
  linked = null;
  try {
    if (scenario) store.start(scenario);
  } catch {
    listProblems("The link cannot be used", ["Its state is not one of a robot. The robot is shown at rest instead."]);
  }
}
/** What the page's link asks for; until its robot is there. */
let linked = null;
let begun = false;

function listProblems(title, list) {
  const close = el("button", { type: "button", textContent: "Close", autofocus: true, onclick: () => problems.close() });
  problems.replaceChildren(el("h2", {}, title), el("ol", {}, ...list.map((p) => el("li", {}, el("pre", {}, p)))), close);
  if (!problems.open) problems.showModal();
}

function refuse(reasons) {
  refused = reasons;
  const shown = reasons.slice(0, 6).join("\n");
  banner.textContent = shown;
  banner.hidden = false;
  numbers.now();
  readout.say("bad", "No equilibrium is shown for this command; the last one is dimmed.");
  paint();
}

const messages = {
  robot: begin,
  mesh: (message) => {
    stage.tubes[message.tube]?.body(message);
    bend();
    paint();
  },
  pose: (message) => {
    if (!robot || message.tubes !== robot.tubes.length) return;
    refused = null;
    banner.hidden = true;
    begun = true;
    store.pose = new Pose(message, columns);
    if (message.dragged) store.adopt(message.actuators);
    bend();
    numbers.wake();
  },
  refused: ({ reasons }) => refuse(reasons),
  bad_file: ({ name: file, problems: list }) => {
    linked = null;
    listProblems(`${file} cannot be used`, list);
  },
  problem: ({ text }) => listProblems("The server does not understand the page", [text]),
  scenario: ({ scenario }) => store.replace(scenario),
  // With which the program was started; not after a lost connection, and not for undo.
  start: ({ scenario }) => begun || store.start(scenario),
  file: ({ text }) => download(`${robot.name}-state.toml`, text, "application/toml"),
  ranges: ({ ranges }) => panel?.safe(ranges),
  error: (message) => readout.error(message),
  touch: (message) => {
    // Of a pose that is still the one on the page.
    if (message.id !== touches) return;
    plots.press(message.contact, store.pose);
    readout.rubs(message, store.friction.coefficient, store.pose, store.scenario);
  },
  cloud: (message) => {
    stage.addCloud(message.floats);
    cloudNote.textContent = message.done ? "" : ` ${message.solved} of ${message.count}`;
  },
};

source.addEventListener("message", ({ detail }) => messages[detail.kind]?.(detail));
source.addEventListener("open", () => (again = robot !== null));
source.addEventListener("lost", () => {
  readout.say("bad", "The connection is lost; trying again …");
  if (store.pose) refuse([source.lost]);
});
store.addEventListener("change", ({ detail }) => {
  if (!moving) {
    last = null;
    player.interrupt();
  }
  // Those of a robot with parts and joints take seconds: none are shown meanwhile.
  if (source.live && robot.bundle) panel?.safe([]);
  if (source.live) ranges.wake();
  touch();
  if (!detail.solved) source.solve(store.scenario, { from_rest: resting });
  resting = false;
  // The arrow is drawn with the answer: a picture now would keep the new shape from being drawn for the rest of its time.
  if (detail.outside) panel?.show();
});
let resting = false;

/**
 * How exact the shape is, and how far each actuator may go, is asked where nothing has changed for a while. A page that solves by itself does one thing at a time: of a robot
 * with parts and joints, which may have come meanwhile, it does not ask what takes seconds.
 */
const ranges = new Rest(400, () => {
  if (!refused && store.pose?.status === "converged" && !robot.bundle) source.send("error");
  if (!(robot.bundle && robots)) source.send({ ranges: trimmed(store.scenario) });
});

/** How the tubes touch, asked where nothing has changed for a while and the answer to the last change is here. */
let touches = 0;
const touching = new Rest(250, () => {
  if (!source.idle) touching.wake();
  else if (!refused && store.pose?.status === "converged") source.send({ touch: { id: touches, ...store.friction } });
});
function touch() {
  touches++;
  plots.stale();
  readout.rubbed.classList.add("stale");
  if (source.live) touching.wake();
}
store.addEventListener("rub", touch);

/** What is offered where the shape on the page is unstable. */
const aside = button("To a stable shape", "Under the same command, on a branch that leaves the path from rest; stays here where there is none", () => source.solve(store.scenario, { aside: true }));
aside.hidden = true;
readout.advice.after(aside);

function reset() {
  resting = true;
  first = null;
  stage.clearTrace();
  // How to solve stays.
  const { formulation, stretch, modes, refine, rotation_means } = store.scenario;
  store.replace({ formulation, stretch, modes, refine, rotation_means });
}

/** What is shown, below the controls. */
const cloudNote = el("span");
function views() {
  const toggle = (key, label, title = "") =>
    tick(label, stage.show[key], (v) => {
      stage.show[key] = v;
      if (key === "trace") stage.clearTrace();
      bend();
      paint();
    }, title).node;
  const parts = [toggle("tubes", "tubes"), toggle("glass", "see-through", "Outer tubes let the inner ones shine through"), toggle("lines", "centroid lines"), toggle("frames", "section frames"), toggle("trace", "tip trace"), toggle("grid", "grid")];
  if (source.live && robot.controls.length > 0 && !robot.bundle) {
    const cloud = tick("workspace", false, (v) => {
      stage.addCloud(null);
      cloudNote.textContent = "";
      const ranges = robot.controls.map((c) => ({ tube: c.tube, pull_mm: [-c.pull_mm / 2, c.pull_mm / 2], rotate_deg: [-180, 180] }));
      source.send({ workspace: { scenario: trimmed(store.scenario), ranges, count: v ? 4000 : 0 } });
    }, "Where the tip can go with half the range of every actuator");
    parts.push(el("span", {}, cloud.node, cloudNote));
  }
  return [el("fieldset", {}, el("legend", {}, "Show"), el("div", { className: "ticks-list" }, ...parts))];
}

function setTheme(theme) {
  stage.theme = theme;
  document.documentElement.dataset.theme = theme;
  paint();
}

const undo = button("↶", "Undo (Ctrl+Z)", () => store.undo());
const redo = button("↷", "Redo (Ctrl+Shift+Z)", () => store.redo());
const showHistory = () => {
  undo.disabled = !store.canUndo;
  redo.disabled = !store.canRedo;
};
store.addEventListener("history", showHistory);
store.addEventListener("change", showHistory);
const camera = choice("Camera", Object.entries(VIEWS).map(([key, v], i) => [key, v.label, `${v.title} (${i + 1})`]), "", (key) => stage.look(key));
stage.turned = () => camera.set(stage.view);
const fit = button("Fit", "The robot as it is fills the picture (F)", () => stage.fit());
const follow = button("Follow", "The camera goes with the tip", () => {
  stage.follow(!stage.following);
  follow.setAttribute("aria-pressed", String(stage.following));
});
follow.setAttribute("aria-pressed", "false");
const colour = select("Colour by", Object.entries(COLOURINGS).map(([key, c]) => [key, c.label]), "tube", () => {
  choose();
  bend();
  paint();
});
function choose() {
  colouring = (robot.bundle ? COLOURINGS_OF_BUNDLES : COLOURINGS)[colour.value];
}
const file = el("input", { type: "file", accept: ".toml", hidden: true, onchange: () => file.files[0] && open(file.files[0]) });
const menu = el(
  "details",
  { className: "menu" },
  el("summary", {}, "Save"),
  el(
    "div",
    {},
    button("Picture (PNG)", "The view as pixels", async () => download(`${robot.name}.png`, await png(stage), "image/png")),
    button("Picture (SVG)", "The view as vector graphics", () => store.pose && download(`${robot.name}.svg`, svg(stage), "image/svg+xml")),
    ...(source.live ? [button("State (TOML)", "What is asked, for cppr solve --scenario", () => source.send({ write_scenario: trimmed(store.scenario) }))] : []),
  ),
);
menu.addEventListener("click", (e) => e.target instanceof HTMLButtonElement && (menu.open = false));
menu.addEventListener("focusout", (e) => !menu.contains(e.relatedTarget) && (menu.open = false));
/** Robots that came with the page, and a link that carries robot and state to another one. */
function alone() {
  const list = select("Robot", [["", "Robots…"], ...Object.keys(robots).map((key) => [key, key])], "", (key) => {
    list.value = "";
    source.robot({ name: key, text: robots[key] });
  });
  const share = button("Link", "An address that carries this robot and its state", async () => {
    history.replaceState(null, "", await link(source.file ?? { name: shownFirst, text: robots[shownFirst] }, trimmed(store.scenario)));
    // A page that was opened as a file may be kept from the clipboard; the address bar has the link as well.
    const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
    share.textContent = copied ? "Copied" : "In the address bar";
    setTimeout(() => (share.textContent = "Link"), 2000);
  });
  return [list, share];
}
const theme = button("◐", "Light or dark (T)", () => setTheme(stage.theme === "dark" ? "light" : "dark"));
tools.append(
  ...(robots ? alone() : []),
  ...(source.live ? [button("Open…", "Another robot, or a state; or drop a file on the page", () => file.click()), file] : []),
  ...(source.live ? [el("span", { className: "group" }, undo, redo, button("Reset", "Everything held, no load (R)", reset))] : []),
  el("label", { className: "group" }, "Colour ", colour),
  el("span", { className: "group" }, camera.node, fit, follow),
  menu,
  theme,
);

/** A robot file or a state: they have no key in common that is required. */
async function open(chosen) {
  file.value = "";
  if (chosen.size > 1 << 20) {
    listProblems(`${chosen.name} cannot be used`, ["The file is larger than 1 MiB. A robot file has a few lines. Is it another file?"]);
    return;
  }
  const text = await chosen.text();
  const state = /^\s*(\[\[actuator\]\]|formulation\s*=|\[tip\])/m.test(text) && !/^\s*(\[\[tube\]\]|length_mm\s*=)/m.test(text);
  if (state) source.send({ read_scenario: { name: chosen.name, text } });
  else source.robot({ name: chosen.name, text });
}
if (source.live) {
  addEventListener("dragover", (e) => {
    e.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (e) => e.relatedTarget === null && document.body.classList.remove("dropping"));
  addEventListener("drop", (e) => {
    e.preventDefault();
    document.body.classList.remove("dropping");
    if (e.dataTransfer.files[0]) open(e.dataTransfer.files[0]);
  });
}

addEventListener("keydown", (e) => {
  const typing = e.target instanceof HTMLInputElement && e.target.type === "number";
  if ((e.ctrlKey || e.metaKey) && e.key.toLowerCase() === "z" && source.live) {
    e.preventDefault();
    if (e.shiftKey) store.redo();
    else store.undo();
  } else if (!typing && !e.ctrlKey && !e.metaKey && !e.altKey && !problems.open) {
    const views = Object.keys(VIEWS);
    if (e.key >= "1" && e.key <= String(views.length)) stage.look(views[e.key - 1]);
    else if (e.key === "f") fit.click();
    else if (e.key === " " && e.target === document.body) {
      e.preventDefault();
      player.play.click();
    } else if (e.key === "t") theme.click();
    else if (e.key === "r" && source.live) reset();
  }
});

setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
if (robots) {
  beginsWith(location.hash).then(({ file, scenario, problem }) => {
    if (problem) listProblems("The link cannot be used", [problem]);
    linked = scenario;
    source.connect(file);
  });
  addEventListener("hashchange", () => location.reload());
} else source.connect();
// For the console, tests and measurements.
window.cppr = { store, source, stage, arrow, readout, plots, player, svg: () => svg(stage) };
