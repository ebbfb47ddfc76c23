// What the person sets: actuators, loads, how to solve, notches, and what is shown.

import { choice, decimals, el, tick, valueControl } from "./dom.js";

/** One degree of freedom of an actuator: by motion or by effort. */
function drive(store, index, { tube, motion, effort }) {
  const own = () => store.scenario.actuator[index];
  const byEffort = () => own()[effort.key] !== undefined;
  const node = el("div", { className: "drive" });
  let [value, used, ranges] = [null, null, []];
  const mark = () => {
    const range = ranges.find((r) => r.tube === tube && r.key === used.key);
    value.safe(range ? [range.low, range.high] : null);
  };
  const build = () => {
    used = byEffort() ? effort : motion;
    value = valueControl({
      ...used,
      label: used.name,
      value: own()[used.key] ?? 0,
      input: (v) => store.change((s) => (s.actuator[index][used.key] = v)),
      done: () => store.settle(),
    });
    mark();
    node.replaceChildren(el("div", { className: "row" }, value.node), mode.node);
  };
  const mode = choice(`${motion.name}: what is prescribed, tube ${tube}`, [["motion", motion.short, motion.title], ["effort", effort.short, effort.title]], "motion", (chosen) => {
    const [to, from] = chosen === "effort" ? [effort, motion] : [motion, effort];
    // The robot stays where it is: the other quantity takes over at its present value.
    const state = store.pose?.actuators.find((a) => a.tube === tube);
    const digits = decimals(to.most) + 1;
    store.change((s) => {
      delete s.actuator[index][from.key];
      s.actuator[index][to.key] = Number((state?.[to.key] ?? 0).toFixed(digits));
    });
    build();
    store.settle();
  });
  build();
  const show = () => {
    mode.set(byEffort() ? "effort" : "motion");
    if (used !== (byEffort() ? effort : motion)) build();
    else value.set(own()[used.key] ?? 0);
  };
  mode.set(byEffort() ? "effort" : "motion");
  const safe = (list) => {
    ranges = list;
    mark();
  };
  return { node, show, safe };
}

function actuator(store, control, index) {
  const { tube } = control;
  const push = drive(store, index, {
    tube,
    motion: { key: "pull_mm", name: "Pull", short: "mm", unit: "mm", most: control.pull_mm, title: "Prescribe the motion; a push is negative" },
    effort: { key: "tension_N", name: "Pull", short: "N", unit: "N", most: control.tension_N, title: "Prescribe the force" },
  });
  const turn = drive(store, index, {
    tube,
    motion: { key: "rotate_deg", name: "Turn", short: "°", unit: "°", most: control.rotate_deg, title: "Prescribe the rotation of its base" },
    effort: { key: "torque_Nmm", name: "Turn", short: "N mm", unit: "N mm", most: control.torque_Nmm, title: "Prescribe the torque" },
  });
  const node = el("fieldset", {}, el("legend", {}, el("i", { className: `swatch tube${tube - 1}` }), `Tube ${tube}`), push.node, turn.node);
  const both = [push, turn];
  return { node, show: () => both.forEach((d) => d.show()), safe: (list) => both.forEach((d) => d.safe(list)) };
}

function forces(store, robot) {
  const controls = ["X", "Y", "Z"].map((axis, i) =>
    valueControl({
      label: axis,
      unit: "N",
      most: robot.force_N,
      value: store.scenario.tip.force_N[i],
      title: `Force on the tip along ${axis} of the base frame`,
      input: (v) => store.change((s) => (s.tip.force_N[i] = v)),
      done: () => store.settle(),
    }),
  );
  const turns = tick("turns with the tip", store.scenario.tip.turns_with_tip, (v) => {
    store.change((s) => (s.tip.turns_with_tip = v));
    store.settle();
  }, "A follower load");
  const node = el("fieldset", {}, el("legend", { title: "Or drag the ring at the tip" }, "Force on the tip"), ...controls.map((c) => c.node), turns.node);
  const show = () => {
    controls.forEach((c, i) => c.set(store.scenario.tip.force_N[i]));
    turns.set(store.scenario.tip.turns_with_tip);
  };
  return { node, show };
}

const GRAVITY = { none: null, "-Z": [0, 0, -9.81], "-Y": [0, -9.81, 0], "+X": [9.81, 0, 0], "-X": [-9.81, 0, 0] };

/** Factors on modes and nodes; a file may have any from 1 to 8. */
const REFINEMENTS = [1, 2, 4, 8];

/** Moves all tubes that are driven by motion together through the plate. */
function advance(store, robot) {
  if (!robot.bundle) return null;
  const own = () => -(store.scenario.actuator.find((a) => a.pull_mm !== undefined)?.pull_mm ?? 0);
  const control = valueControl({
    label: "Push",
    unit: "mm",
    most: robot.advance_mm,
    value: own(),
    title: "Advances the robot: pushes all tubes together through the plate; what they are pulled against each other stays",
    input: (v) => {
      const by = v - own();
      store.change((s) => s.actuator.forEach((a) => a.pull_mm !== undefined && (a.pull_mm = Number((a.pull_mm - by).toFixed(6)))), true);
    },
    done: () => store.settle(),
  });
  const node = el("fieldset", {}, el("legend", {}, "All tubes"), control.node);
  return { node, show: () => control.set(own()) };
}

function options(store, robot) {
  const change = (edit) => {
    store.change(edit);
    store.settle();
  };
  const direction = (g) => Object.entries(GRAVITY).find(([, v]) => JSON.stringify(v) === JSON.stringify(g ?? null))?.[0] ?? "";
  const gravity = choice("Gravity", Object.keys(GRAVITY).map((k) => [k, k.replace("-", "−")]), direction(store.scenario.gravity_m_s2), (k) =>
    change((s) => (GRAVITY[k] ? (s.gravity_m_s2 = GRAVITY[k]) : delete s.gravity_m_s2)),
  );
  const formulation = choice(
    "Formulation",
    [["consistent", "consistent", "Stationary total energy"], ["printed", "printed", "The paper's projection of wrenches, for comparison"]],
    store.scenario.formulation,
    (v) => change((s) => (s.formulation = v)),
  );
  const modes = choice(
    "Modes",
    [["default", "default", "Tip within 1e-4 of the length, for every robot shipped"], ["paper", "paper", "The paper's 3 + 3 + 3 + 2"], ["planar", "planar", "Five modes, nothing leaves the plane X-Y"]],
    store.scenario.modes,
    (v) => change((s) => (s.modes = v)),
  );
  const refine = choice(
    "Times as many modes",
    REFINEMENTS.map((n) => [n, `×${n}`, `${n} times the modes and nodes, to see whether the answer stays`]),
    store.scenario.refine,
    (v) => change((s) => (s.refine = v)),
  );
  const stretch = tick("tubes stretch", store.scenario.stretch, (v) => change((s) => (s.stretch = v)), "Axial strain of every tube");
  if (robot.bundle) {
    for (const [own, why] of [
      [formulation, "The printed equations know no parts and joints"],
      [modes, "Robots with parts and joints are integrated along their length, without modes"],
      [refine, "The steps of the integration follow their error, which the readout states"],
    ]) {
      own.node.querySelectorAll("button").forEach((b) => (b.disabled = true));
      own.node.title = why;
    }
  }
  if (!robot.has_mass) {
    gravity.node.querySelectorAll("button").forEach((b) => (b.disabled = true));
    gravity.node.title = "This robot's file gives no mass";
  }
  if (!robot.can_stretch) {
    stretch.box.disabled = true;
    stretch.node.title = "This robot's file gives no axial stiffness";
  }
  const node = el(
    "fieldset",
    {},
    el("legend", {}, "Model"),
    el("div", { className: "line" }, el("span", {}, "Gravity"), gravity.node),
    el("div", { className: "line" }, el("span", {}, "Formulation"), formulation.node),
    el("div", { className: "line" }, el("span", {}, "Modes"), modes.node),
    el("div", { className: "line" }, el("span", {}, "Refined"), refine.node),
    stretch.node,
  );
  const show = () => {
    gravity.set(direction(store.scenario.gravity_m_s2));
    formulation.set(store.scenario.formulation);
    modes.set(store.scenario.modes);
    refine.set(store.scenario.refine);
    stretch.set(store.scenario.stretch);
  };
  return { node, show };
}

function notches(store, robot) {
  const controls = robot.tubes.flatMap((tube, t) => {
    if (tube.depth_mm.length === 0 || Math.max(...tube.depth_mm) === 0) return [];
    const most = Number(Math.min(0.15 * Math.max(...tube.depth_mm), 0.8 * (tube.depth_limit_mm - Math.max(...tube.depth_mm))).toPrecision(1));
    const own = () => store.scenario.notches?.find((n) => n.tube === t + 1)?.deeper_mm ?? 0;
    const control = valueControl({
      label: `Tube ${t + 1}`,
      unit: "mm",
      most,
      value: own(),
      title: "Added to the depth of every notch",
      input: (v) => store.change((s) => (s.notches = [...(s.notches ?? []).filter((n) => n.tube !== t + 1), { tube: t + 1, deeper_mm: v }])),
      done: () => store.settle(),
    });
    return [{ node: control.node, show: () => control.set(own()) }];
  });
  if (controls.length === 0) return null;
  const node = el("fieldset", {}, el("legend", {}, "Notches deeper by"), ...controls.map((c) => c.node));
  return { node, show: () => controls.forEach((c) => c.show()) };
}

/** How the tubes rub: no part of the state, since it changes no pose, only what is told of it. */
function friction(store, robot) {
  const control = (key, options, least, most) =>
    valueControl({
      ...options,
      least: 0,
      value: store.friction[key],
      input: (v) => store.rub({ [key]: Math.min(most, Math.max(least, v)) }),
      done: () => {},
    });
  const controls = [
    control("coefficient", { label: "μ", unit: "–", most: 0.6, title: "Coefficient of friction between the tubes: between which poses it leaves the robot is told on the right. 0 leaves friction out" }, 0, 2),
    control("guide_mm", { label: "Guide", unit: "mm", most: Number((robot.length_mm / 4).toPrecision(1)), title: "Length of the guide below the plate in which the tubes rub too. 0 leaves it out" }, 0, 1e4),
  ];
  return { node: el("fieldset", {}, el("legend", {}, "Friction"), ...controls.map((c) => c.node)), show: () => {} };
}

/** All controls of a robot; they show again what the store holds after undo. */
export function controlPanel(store, robot) {
  const parts = [
    advance(store, robot),
    ...robot.controls.map((control, i) => actuator(store, control, i)),
    forces(store, robot),
    options(store, robot),
    friction(store, robot),
    notches(store, robot),
  ].filter(Boolean);
  return {
    nodes: parts.map((p) => p.node),
    show: () => parts.forEach((p) => p.show()),
    safe: (list) => parts.forEach((p) => p.safe?.(list)),
  };
}
