// What is asked of the robot, as a scenario (the words of scenario files), with undo and redo.

/** A scenario in which everything is held and nothing acts. */
export function rest(robot) {
  return {
    formulation: "consistent",
    stretch: false,
    modes: "default",
    refine: 1,
    rotation_means: "base",
    actuator: robot.controls.map(({ tube }) => ({ tube, pull_mm: 0, rotate_deg: 0 })),
    tip: { force_N: [0, 0, 0], moment_Nmm: [0, 0, 0], point_mm: [0, 0, 0], turns_with_tip: false },
  };
}

/** The same without what says nothing. */
export function trimmed(scenario) {
  const copy = structuredClone(scenario);
  if (copy.tip && ![...copy.tip.force_N, ...copy.tip.moment_Nmm].some((v) => v !== 0)) delete copy.tip;
  copy.notches = (copy.notches ?? []).filter((n) => n.deeper_mm !== 0);
  if (copy.notches.length === 0) delete copy.notches;
  return copy;
}

export class Store extends EventTarget {
  /** @type {any} */ scenario = null;
  /** How the tubes rub: that of the robot's file, until another is chosen. */
  friction = { coefficient: 0, guide_mm: 0 };
  #past = [];
  #future = [];
  #settled = "";

  /** Another robot: everything at rest, no history. */
  begin(robot) {
    this.robot = robot;
    this.scenario = rest(robot);
    this.friction = { coefficient: 0, guide_mm: 0, ...robot.friction };
    this.#past = [];
    this.#future = [];
    this.#settled = JSON.stringify(this.scenario);
    this.#say();
  }

  /** What is asked at first, without a step of undo. */
  start(scenario) {
    this.scenario = this.#whole(scenario);
    this.#settled = JSON.stringify(this.scenario);
    this.#say(true);
  }

  /** Changes the scenario while a control moves; `outside`: what other controls show as well. */
  change(edit, outside = false) {
    edit(this.scenario);
    this.#say(outside);
  }

  /** Other friction: no step of undo. */
  rub(friction) {
    Object.assign(this.friction, friction);
    this.dispatchEvent(new Event("rub"));
  }

  /** Where the actuators stand, found with the shape on the page. */
  adopt(actuators) {
    for (const own of this.scenario.actuator) {
      const state = actuators.find((a) => a.tube === own.tube) ?? {};
      for (const key of Object.keys(own)) if (key !== "tube") own[key] = Number(state[key].toFixed(6));
    }
    this.dispatchEvent(new CustomEvent("change", { detail: { outside: true, solved: true } }));
  }

  /** The control rests: one step of undo. */
  settle() {
    const now = JSON.stringify(this.scenario);
    if (now === this.#settled) return;
    this.#past.push(this.#settled);
    this.#future = [];
    this.#settled = now;
    this.dispatchEvent(new Event("history"));
  }

  /** A state of a motion: no step of undo, and the controls show it. */
  replay(scenario) {
    this.scenario = scenario;
    this.#say(true);
  }

  /** A whole other scenario. */
  replace(scenario) {
    this.scenario = this.#whole(scenario);
    this.#say(true);
    this.settle();
  }

  /** Completed by what is at rest. */
  #whole(scenario) {
    const base = rest(this.robot);
    const actuator = base.actuator.map((a) => {
      const given = scenario.actuator?.find((b) => b.tube === a.tube) ?? {};
      const own = { tube: a.tube, ...given };
      if (own.tension_N === undefined) own.pull_mm ??= 0;
      if (own.torque_Nmm === undefined) own.rotate_deg ??= 0;
      return own;
    });
    return { ...base, ...structuredClone(scenario), actuator, tip: { ...base.tip, ...scenario.tip } };
  }

  get canUndo() {
    return this.#past.length > 0;
  }
  get canRedo() {
    return this.#future.length > 0;
  }
  undo() {
    this.#move(this.#past, this.#future);
  }
  redo() {
    this.#move(this.#future, this.#past);
  }

  #move(from, to) {
    this.settle();
    if (from.length === 0) return;
    to.push(this.#settled);
    this.#settled = from.pop();
    this.scenario = JSON.parse(this.#settled);
    this.#say(true);
    this.dispatchEvent(new Event("history"));
  }

  /** `outside`: the controls did not make the change and must show it. */
  #say(outside = false) {
    this.dispatchEvent(new CustomEvent("change", { detail: { outside } }));
  }
}
