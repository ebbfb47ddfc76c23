// Elements, and the few controls that everything is made of.

/**
 * An element with properties, attributes (`aria-…`, `data-…`, `role`, `for`) and children.
 * @param {string} tag
 * @param {Record<string, any>} [properties]
 * @param {...(Node|string)} children
 */
export function el(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(properties)) {
    if (key.includes("-") || key === "role" || key === "for") node.setAttribute(key, value);
    else node[key] = value;
  }
  node.append(...children);
  return node;
}

/** An element of a drawing. */
export function shape(tag, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/** A button; one that shows a sign only is read out by its title. */
export const button = (label, title, onclick) =>
  el("button", { type: "button", title, onclick, ...(label.length > 1 ? {} : { "aria-label": title }) }, label);

/** A number for people: four significant digits, a true minus sign. */
export function show(value, digits = 3) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? (0).toFixed(digits) : text).replace("-", "−");
}

/** Decimals that suit values up to `most`. */
export function decimals(most) {
  return Math.max(0, Math.min(4, 3 - Math.floor(Math.log10(Math.max(most, 1e-9)))));
}

let serial = 0;

/**
 * Slider and number field of one value. The slider ends at `most`; the field takes more.
 * @param {{label: string, unit: string, most: number, least?: number, value: number, title?: string,
 *   input: (value: number) => void, done: () => void}} options
 */
export function valueControl({ label, unit, most, least = -most, value, title = "", input, done }) {
  const id = `value${serial++}`;
  const digits = decimals(most);
  const step = 10 ** -digits;
  const slider = el("input", { type: "range", min: least, max: most, step: "any", "aria-label": `${label} (${unit})` });
  const field = el("input", { type: "number", id, step, autocomplete: "off" });
  const name = el("label", { for: id, title }, label);
  const set = (v) => {
    slider.value = v;
    if (document.activeElement !== field) field.value = Number(v.toFixed(digits + 1));
    slider.style.setProperty("--zero", `${(100 * -least) / (most - least)}%`);
  };
  set(value);
  slider.addEventListener("input", () => {
    // Near the middle of the range zero is meant.
    const v = Math.abs(slider.value) < 0.006 * (most - least) ? 0 : Number(slider.value);
    field.value = Number(v.toFixed(digits));
    input(Number(field.value));
  });
  slider.addEventListener("keydown", (event) => {
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (way === undefined) return;
    event.preventDefault();
    const fine = event.shiftKey ? 0.1 : 1;
    const next = Number(slider.value) + (way * fine * (most - least)) / 200;
    const v = Math.min(most, Math.max(least, Number(next.toFixed(digits + 1))));
    slider.value = v;
    field.value = v;
    input(v);
    done();
  });
  slider.addEventListener("dblclick", () => {
    set(0);
    field.value = 0;
    input(0);
    done();
  });
  slider.addEventListener("change", done);
  field.addEventListener("input", () => {
    if (field.value !== "" && Number.isFinite(field.valueAsNumber)) {
      slider.value = field.valueAsNumber;
      input(field.valueAsNumber);
    }
  });
  field.addEventListener("change", done);
  /** Marks the values that keep all limits; nothing where they are not known. */
  const safe = (range) => {
    const place = (v) => `${(100 * (Math.min(most, Math.max(least, v)) - least)) / (most - least)}%`;
    slider.classList.toggle("ranged", range !== null);
    slider.title = range ? `All limits are kept from ${show(range[0], digits)} to ${show(range[1], digits)} ${unit}` : "";
    slider.style.setProperty("--low", range ? place(range[0]) : "0%");
    slider.style.setProperty("--high", range ? place(range[1]) : "0%");
  };
  const node = el("div", { className: "value" }, name, slider, el("span", { className: "number" }, field, el("span", {}, unit)));
  return { node, set, safe };
}

/** Buttons of which one is pressed. */
export function choice(label, options, chosen, change) {
  const node = el("div", { className: "choice", role: "group", "aria-label": label });
  const buttons = options.map(([value, text, title = ""]) => {
    const button = el("button", { type: "button", textContent: text, title });
    button.addEventListener("click", () => {
      set(value);
      change(value);
    });
    return [value, button];
  });
  const set = (value) => buttons.forEach(([v, b]) => b.setAttribute("aria-pressed", String(v === value)));
  set(chosen);
  node.append(...buttons.map(([, b]) => b));
  return { node, set };
}

/** A box to tick. */
export function tick(label, checked, change, title = "") {
  const box = el("input", { type: "checkbox", checked });
  box.addEventListener("change", () => change(box.checked));
  return { node: el("label", { className: "tick", title }, box, label), set: (v) => (box.checked = v), box };
}

/** A list to choose from. */
export function select(label, options, chosen, change) {
  const node = el("select", { "aria-label": label }, ...options.map(([value, text]) => el("option", { value }, text)));
  node.value = chosen;
  node.addEventListener("change", () => change(node.value));
  return node;
}

/** What is done at most once in so many milliseconds, in a task of its own, for whatever woke it last. */
export class Seldom {
  #timer = null;
  #last = -Infinity;

  constructor(interval, work) {
    this.interval = interval;
    this.work = work;
  }

  wake() {
    this.#timer ??= setTimeout(() => this.now(), Math.max(0, this.#last + this.interval - performance.now()));
  }

  /** At once, where it was woken. */
  now() {
    if (this.#timer === null) return;
    clearTimeout(this.#timer);
    this.#timer = null;
    this.#last = performance.now();
    this.work();
  }
}

/** What is done once nothing has woken it for so long (ms). */
export class Rest {
  #timer = null;

  constructor(quiet, work) {
    this.quiet = quiet;
    this.work = work;
  }

  wake() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(this.work, this.quiet);
  }
}

/** Gives a text or a picture to the person as a file. */
export function download(name, data, type) {
  const url = URL.createObjectURL(data instanceof Blob ? data : new Blob([data], { type }));
  const link = el("a", { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
