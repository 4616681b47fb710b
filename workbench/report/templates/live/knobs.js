"use strict";

// The bench: the controls of a live page, made of a browser's own inputs, in a region at the side or the bottom.

const EVERY = "every"; // of all scenarios
const NOTCHES = 200; // of a slider
const AT_BASELINE = "At the baseline: the numbers of this page as it was made.";
const ORIGINS = { stated: "stated", derived: "derived", assumed: "assumed" };

// An element with attributes and children; texts go in as texts.
function part(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "onclick") made.addEventListener("click", value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== null) made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

// A number as a reader likes it, with a true minus.
function shortNumber(value, digits = 4) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "none" : value > 0 ? "\u221e" : "\u2212\u221e";
  const size = Math.abs(value);
  const plain = size === 0 || (size >= 1e-4 && size < 1e6);
  const text = plain ? String(Number(value.toPrecision(digits))) : value.toExponential(digits - 1);
  return text.replace("e+", "e").replace(/-/g, "\u2212");
}

// The same with all its digits, for numbers below one another.
function evenNumber(value, digits = 4) {
  const size = Math.abs(value), plain = Number.isFinite(value) && size >= 1e-3 && size < 10 ** digits;
  return plain ? value.toPrecision(digits).replace("-", "\u2212") : shortNumber(value, digits);
}

function withUnit(text, unit) {
  return unit && unit !== "1" ? `${text}\u00a0${unit}` : text;
}

// The scale of a knob: from values to notches of its slider and back, with values as round as a notch is wide.
class Scale {
  constructor({ low, high, log, value }) {
    Object.assign(this, { low, high, log, baseline: value, notches: NOTCHES });
  }

  share(value) {
    const { low, high, log } = this;
    const part = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.min(1, Math.max(0, part));
  }

  notch(value) {
    return Math.round(NOTCHES * this.share(value));
  }

  value(notch) {
    const { low, high, log, baseline } = this;
    if (notch === this.notch(baseline)) return baseline;
    if (notch <= 0 || notch >= NOTCHES) return notch <= 0 ? low : high;
    const value = log ? low * (high / low) ** (notch / NOTCHES) : low + ((high - low) * notch) / NOTCHES;
    const width = log ? value * Math.log(high / low) / NOTCHES : (high - low) / NOTCHES;
    const unit = 10 ** Math.floor(Math.log10(width));
    return Math.min(high, Math.max(low, Number((Math.round(value / unit) * unit).toPrecision(12))));
  }
}

// The scale of a knob whose law was designed at some values: each of them is a notch.
class StopScale {
  constructor({ stops }) {
    Object.assign(this, { stops, notches: stops.length - 1 });
  }

  share(value) {
    return this.notch(value) / this.notches;
  }

  notch(value) {
    return nearestStop(this.stops, value);
  }

  value(notch) {
    return this.stops[notch];
  }
}

// The place of the stop that is nearest to a value.
function nearestStop(stops, value) {
  return stops.reduce((best, stop, i) => (Math.abs(stop - value) < Math.abs(stops[best] - value) ? i : best), 0);
}

// One knob: its name, a slider with a mark at the baseline, a field, where the number is from, and the way back.
class KnobControl {
  constructor(knob, place, turned) {
    Object.assign(this, { knob, scale: knob.stops ? new StopScale(knob) : new Scale(knob), turned, name: `knob-${place}` });
    const { name, unit, origin, value, low, high, share } = knob, id = this.name;
    const about = `${id}-about`;
    this.slider = part("input", { type: "range", id, min: 0, max: this.scale.notches, step: 1, "aria-describedby": about });
    this.field = part("input", { type: "number", min: low, max: high, step: "any", "aria-label": this.spoken() });
    this.back = part("button", { type: "button", class: "bench-back", onclick: () => this.putBack() });
    this.back.append("reset to ", shortNumber(value, 6));
    this.back.setAttribute("aria-label", `${name}: reset to the baseline ${shortNumber(value, 6)}`);
    const track = part("div", { class: "bench-track" }, this.slider);
    track.style.setProperty("--baseline", this.scale.share(value));
    this.origin = part("span", {}, ORIGINS[origin] || "");
    if (knob.interval) this.showInterval(track, knob.interval);
    const ofUnit = part("span", { class: "bench-unit" }, share ? "times" : unit === "1" ? "" : unit);
    this.row = part("div", { class: "bench-knob" },
      part("label", { for: id }, name),
      part("span", { class: "bench-value" }, this.field, ofUnit),
      track,
      part("p", { class: "bench-about", id: about }, this.origin, this.back));
    this.slider.addEventListener("input", () => this.turn(this.scale.value(Number(this.slider.value)), this.slider));
    this.field.addEventListener("input", () => this.typed(false));
    this.field.addEventListener("change", () => this.typed(true));
  }

  // Mark the interval of an estimate on the track, and say it.
  showInterval(track, [from, to]) {
    track.classList.add("has-interval");
    track.style.setProperty("--from", this.scale.share(from));
    track.style.setProperty("--to", this.scale.share(to));
    const size = Math.max(Math.abs(from), Math.abs(to)), narrow = Math.log10(size / (to - from)); // digits that both share
    const digits = Math.min(12, Math.max(3, 2 + Math.ceil(narrow || 0)));
    this.origin.textContent = `95\u00a0%: ${shortNumber(from, digits)} to ${shortNumber(to, digits)}`;
  }

  spoken() {
    const { name, unit, share } = this.knob;
    return share ? `${name}, times the baseline` : unit && unit !== "1" ? `${name} in ${unit}` : name;
  }

  // What stands in the field; out of range it waits until the reader is done, then it is clipped.
  typed(finished) {
    const { low, high, value } = this.knob, number = this.field.value.trim() === "" ? NaN : Number(this.field.value);
    if (finished) this.turn(Number.isNaN(number) ? value : Math.min(high, Math.max(low, number)));
    else if (number >= low && number <= high) this.turn(number, this.field);
  }

  turn(wanted, by = null) {
    const { stops } = this.knob, value = stops ? stops[nearestStop(stops, wanted)] : wanted;
    this.show(value, by);
    this.turned(value);
  }

  // Back to the baseline; the button goes away, and leaves the reader at the slider.
  putBack() {
    this.slider.focus({ preventScroll: true });
    this.turn(this.knob.value);
  }

  // Put the inputs to a value, but the one by which it came.
  show(value, by = null) {
    const { knob, scale, slider, field, back, row } = this;
    if (by !== slider) slider.value = scale.notch(value);
    if (by !== field) field.value = Number(value.toPrecision(7)); // the field is no wider; the value keeps its digits
    slider.setAttribute("aria-valuetext", withUnit(shortNumber(value), knob.unit));
    const moved = !Object.is(value, knob.value);
    row.classList.toggle("turned", moved);
    back.hidden = !moved;
    this.origin.hidden = moved;
  }
}

// How the numbers of this page are rounded beside those of the baseline, and who made them.
function roundingOf(data) {
  const laws = [...new Set(data.loops.filter((loop) => loop && loop.switches).map((loop) => loop.law))];
  const named = laws.length > 4 ? [...laws.slice(0, 3), `${laws.length - 3} more`] : laws;
  const made = `Computed in this page by its own kernel (workbench ${data.version}, loops ${data.fingerprint})`;
  const same = "In stable loops both agree to a billionth";
  const how = `it rounds each product by itself, where the baseline fuses it with its sum. ${same}`;
  const when = "there rounding decides when, and both agree within the error of the step";
  const jumps = `except where a law jumps (${named.join(", ")}): ${when}`;
  return `${made}: ${how}${laws.length ? `, ${jumps}` : ""}.`;
}

// The region with all controls, the first of the page. It is empty until it is opened first; then `opened` fills it.
class Bench {
  constructor(opened) {
    this.opened = opened;
    this.panel = part("div", { id: "bench-panel", class: "bench-panel", hidden: true });
    this.handle = part("button", {
      type: "button", class: "bench-handle", "aria-expanded": "false", "aria-controls": "bench-panel",
      onclick: () => this.open(),
    }, "Turn the knobs");
    this.region = part("section", { class: "bench", "aria-label": "Turn the knobs" }, this.handle, this.panel);
    this.region.addEventListener("keydown", (event) => event.key === "Escape" && this.close());
    this.status = part("p", { class: "bench-status" }, AT_BASELINE);
    this.voice = part("p", { class: "bench-voice", role: "status", "aria-live": "polite" });
    this.head = part("h2", { tabindex: "-1" }, "Turn the knobs");
    const closing = { type: "button", class: "bench-close", "aria-label": "Close", onclick: () => this.close() };
    this.closer = part("button", closing, "\u00d7"); // behind the knobs for those who go by keys
    this.panel.append(part("div", { class: "bench-head" }, this.head, this.status), this.voice, this.closer);
    document.body.prepend(this.region);
  }

  open(focus = true) {
    this.set(true);
    if (this.opened) this.opened();
    this.opened = null;
    if (focus) this.head.focus({ preventScroll: true });
  }

  close() {
    this.set(false);
    this.handle.focus({ preventScroll: true });
  }

  set(open) {
    this.panel.hidden = !open;
    this.handle.hidden = open;
    this.handle.setAttribute("aria-expanded", String(open));
    document.documentElement.classList.toggle("bench-open", open);
  }

  // One sentence below the head.
  tell(text) {
    this.status.textContent = text;
  }

  // The same for those who listen.
  say(text) {
    this.voice.textContent = text;
  }

  // Fill the bench with the controls of the data, and a row to compare settings; `turned` hears of each new state.
  fill(data, state, turned, compared) {
    Object.assign(this, { data, state, changed: () => this.afterChange(turned) });
    const scenarios = this.scenarios(), laws = this.laws(), seed = this.seeds();
    this.knobs = data.knobs.map((knob, i) => new KnobControl(knob, i, (value) => {
      this.state.values[i] = value;
      this.changed();
    }));
    this.results = part("div", { class: "bench-results", role: "region", hidden: true, "aria-label": "Results" });
    this.stage = part("div", { class: "bench-stage", hidden: true });
    this.back = part("button", { type: "button", onclick: () => this.reset() }, "All to baseline");
    this.restore = part("button", { type: "button", disabled: true, onclick: () => this.undo() }, "Undo");
    this.restore.setAttribute("aria-label", "Undo: the numbers as they were before All to baseline");
    const copies = [this.copyButton("Copy link", () => this.link())];
    if (data.python || data.loops.some((loop) => loop?.linear)) copies.push(this.copyButton("Copy as Python", () => this.python()));
    const pairs = [[this.back, this.restore], copies].map((pair) => part("div", {}, ...pair));
    const buttons = part("div", { class: "bench-buttons" }, ...pairs);
    const still = { class: "bench-copied", readonly: true, hidden: true, rows: 4, "aria-label": "To copy" };
    this.copied = part("textarea", still);
    this.group = part("div", { class: "bench-group" });
    this.body = part("div", { class: "bench-body" }, ...scenarios, this.group, ...seed, ...laws, compared, this.stage);
    const refused = Object.entries(data.refused || {}).map(([name, why]) => part("span", { title: why }, name));
    if (refused.length) {
      const list = refused.flatMap((name, i) => (i ? [", ", name] : [name])), words = "These stay at the baseline: ";
      this.body.append(part("p", { class: "bench-refused" }, words, ...list, "."));
    }
    this.body.append(part("p", { class: "bench-refused" }, roundingOf(data)));
    this.body.append(part("div", { class: "bench-foot" }, buttons, this.copied));
    this.closer.before(this.results, this.body);
    this.show(state);
  }

  // Only one sentence, where nothing can be turned.
  refuse(text) {
    this.tell(text);
    this.say(text);
    if (this.body) this.body.inert = true;
  }

  afterChange(turned) {
    this.copied.hidden = true;
    this.show(this.state);
    turned(this.state);
  }

  scenarios() {
    const names = [...new Set(this.data.loops.filter((loop) => loop && !loop.everywhere).map((loop) => loop.scenario))];
    if (names.length < 2) return [];
    const options = names.map((name) => part("option", { value: name }, name));
    options.push(part("option", { value: EVERY }, "all of them"));
    this.scenario = part("select", { id: "bench-scenario" }, ...options);
    this.scenario.addEventListener("change", () => {
      this.state.scenario = this.scenario.value;
      this.changed();
    });
    return [part("p", { class: "bench-line" }, part("label", { for: "bench-scenario" }, this.data.scenario ? "Experiment" : "Scenario"), this.scenario)];
  }

  laws() {
    const labels = new Map(this.data.loops.filter(Boolean).map((loop) => [loop.law, loop.label]));
    this.boxes = new Map();
    if (labels.size < 2) return [];
    const lines = [...labels].map(([law, label]) => {
      const box = part("input", { type: "checkbox" });
      box.addEventListener("change", () => {
        this.state.off[box.checked ? "delete" : "add"](law);
        this.changed();
      });
      this.boxes.set(law, box);
      return part("label", { class: "bench-law", "data-law": law }, box, label);
    });
    return [part("fieldset", {}, part("legend", {}, "Laws that run; others stay at the baseline"), ...lines)];
  }

  seeds() {
    if (!this.data.loops.some((loop) => loop && loop.normals > 0)) return [];
    this.seed = part("input", { id: "bench-seed", type: "text", inputmode: "numeric", autocomplete: "off", size: 10 });
    this.seed.addEventListener("change", () => this.sow(this.seed.value.trim()));
    const fresh = () => this.sow(String(crypto.getRandomValues(new Uint32Array(1))[0] % 10000));
    return [part("p", { class: "bench-line" }, part("label", { for: "bench-seed" }, "Noise seed"), this.seed,
      part("button", { type: "button", class: "bench-plain", onclick: fresh }, "new seed"))];
  }

  sow(text) {
    this.state.seed = seedOfText(text, this.state.seed);
    this.changed();
  }

  // All to the baseline; what was turned is kept for `undo`, at which the reader is left.
  reset() {
    const { scenario } = this.state;
    this.before = this.state;
    this.state = { ...printedState(this.data), scenario };
    this.changed();
    this.restore.disabled = false;
    this.restore.focus({ preventScroll: true });
  }

  // The numbers before the last reset, in the scenario that is shown; a second undo takes the first one back.
  undo() {
    const { scenario } = this.state;
    [this.state, this.before] = [{ ...this.before, scenario }, this.state];
    this.changed();
  }

  // Put all controls to a state; knobs that no running loop has are pale, and stand below the others.
  show(state) {
    this.state = state;
    const asked = this.data.loops.filter((loop) => loop && isAsked(loop, state));
    const used = new Set(asked.flatMap((loop) => loop.moves.map((move) => move.knob)));
    this.knobs.forEach((control, i) => {
      if (!Object.is(control.shown, state.values[i])) control.show(state.values[i], document.activeElement);
      control.shown = state.values[i];
      control.row.classList.toggle("unused", !used.has(i));
    });
    const order = [...this.knobs.keys()].sort((a, b) => used.has(b) - used.has(a));
    if (order.join() !== this.order) this.group.replaceChildren(...order.map((i) => this.knobs[i].row));
    this.order = order.join();
    if (this.scenario) this.scenario.value = state.scenario;
    if (this.seed) this.seed.value = state.seed;
    for (const [law, box] of this.boxes) {
      box.checked = !state.off.has(law);
      box.parentElement.hidden = !this.data.loops.some((loop) => loop && loop.law === law && inScenario(loop, state));
    }
    this.back.disabled = addressOfState({ ...state, scenario: printedState(this.data).scenario }, this.data) === "";
  }

  // A line for each loop: its first number now, under the settings that are held by their names, and at the baseline.
  report(head, lines, names) {
    this.results.replaceChildren();
    this.results.hidden = !lines.length;
    if (!lines.length) return;
    const several = new Set(lines.filter((line) => !line.linear).map((line) => line.scenario)).size > 1;
    const rows = lines.flatMap(({ scenario, label, now, held, baseline, rough, linear }, i) => {
      const row = part("tr", rough ? { class: "rough" } : {},
        part("th", { scope: "row", title: label }, label), ...[now, ...held, baseline].map((text) => part("td", {}, text)));
      if (!(several || linear) || (i && lines[i - 1].scenario === scenario)) return [row];
      return [part("tr", {}, part("th", { scope: "rowgroup", colspan: 3 + names.length, class: "bench-scenario" }, scenario)), row];
    });
    const heads = [head, "now", ...names, "baseline"].map((text) => part("th", { scope: "col", title: text }, text));
    this.results.append(part("table", {}, part("thead", {}, part("tr", {}, ...heads)), part("tbody", {}, ...rows)));
    if (lines.length === this.lines) return;
    this.lines = lines.length;
    if (this.results.scrollHeight > this.results.clientHeight) this.results.tabIndex = 0; // to be scrolled by keys
    else this.results.removeAttribute("tabindex");
  }

  // The lines that compute the same in Python: those that name a case stand there for each loop that is turned.
  python() {
    const { data, state } = this, turned = (knob) => !Object.is(state.values[knob], data.knobs[knob].value);
    const places = [...data.loops.keys()].filter((place) => data.loops[place] && isAsked(data.loops[place], state));
    const cases = places.map((place) => {
      const loop = data.loops[place];
      const items = loop.moves.map((move) => move.knob).filter(turned)
        .map((knob) => `${JSON.stringify(data.knobs[knob].name)}: ${state.values[knob]}`);
      const seed = isReseeded(loop, state, printedState(data)) ? state.seed : "None";
      return { place, case: JSON.stringify(`${loop.scenario}: ${loop.law}`), values: `{${items.join(", ")}}`, seed };
    });
    const moved = cases.filter(({ values, seed }) => values !== "{}" || seed !== "None");
    const chosen = moved.length ? moved : cases, several = chosen.length > 1;
    if (!data.python) return `import workbench as wb\n\n${linearLines(data, state, places)}`;
    const written = (line, one) => line.replace(/^scores\b/, several ? `scores[${one.case}]` : "scores")
      .replace(/\{(case|values|seed)\}/g, (_, name) => one[name]);
    const linear = chosen.filter((one) => data.loops[one.place].linear)
      .map((one) => written(data.python_linear, one).replace(/^linear\b/, several ? `linear[${one.case}]` : "linear"));
    if (several && linear.length) linear.unshift("linear = {}\n");
    return data.python.split("\n").flatMap((line) => {
      if (!line.includes("{case}")) return [line];
      return [...(several ? ["scores = {}"] : []), ...chosen.map((one) => written(line, one))];
    }).join("\n") + linear.join("");
  }

  // The address of this page with all that is turned.
  link() {
    return location.href.split("#")[0] + addressOfState(this.state, this.data);
  }

  // A button that copies a text; it says so in its own width, so that no other button comes below the pointer.
  copyButton(name, text) {
    const button = part("button", { type: "button", onclick: () => this.copy(text(), button) }, name);
    button.dataset.name = name;
    return button;
  }

  // Copy a text, or show it where a browser lets no page write to the clipboard.
  async copy(text, button) {
    try {
      await navigator.clipboard.writeText(text);
      button.style.minWidth = `${button.getBoundingClientRect().width}px`;
      button.textContent = "Copied";
      setTimeout(() => (button.textContent = button.dataset.name), 1500);
    } catch {
      this.copied.value = text;
      this.copied.hidden = false;
      this.copied.select();
    }
  }
}

// The lines that make the loop of a page without a study linear in Python as it is here; it is named `loop` there.
function linearLines(data, state, places) {
  const lines = places.filter((place) => data.loops[place].linear).map((place) => {
    const loop = data.loops[place], { rests, held, period } = loop.linear;
    const options = [`values={${turnedNumbers(data, state, loop).join(", ")}}`];
    if (held.length) options.push(`freeze=(${held.map((one) => JSON.stringify(one)).join(", ")},)`);
    if (!rests) options.push("at_rest=False");
    if (period !== null) options.push(`substeps=${Math.round(period / loop.whole.h)}`);
    return `linear = wb.linear_loop(loop, ${options.join(", ")})\n`;
  });
  return ["# loop: the one of which this page was made\n", ...lines].join("");
}

// The numbers of a loop that are turned, each by its name in Python; states only where the loop does not seek its rest.
function turnedNumbers(data, state, loop) {
  const { rests, held } = loop.linear;
  return loop.moves.flatMap(({ knob, p, x, names, designs }) => {
    const value = state.values[knob], { share, value: baseline, stops } = data.knobs[knob];
    if (Object.is(value, baseline)) return [];
    const own = [...p.map((place) => loop.p[place]), ...x.map((place) => loop.x0[place])];
    const at = (i) => (stops ? designs[nearestStop(stops, value)][i] : share ? own[i] * value : value);
    const items = names.map((name, i) => [name, at(i), i >= p.length]);
    const isHeld = (name) => held.some((one) => name === one || name.startsWith(`${one}[`));
    return items.filter(([name, , isState]) => !isState || !rests || isHeld(name))
      .map(([name, number]) => `${JSON.stringify(name)}: ${number}`);
  });
}

// A loop of which a page shows nothing but linear answers belongs to each scenario, beside the runs of others.
function inScenario(loop, state) {
  return loop.everywhere || state.scenario === EVERY || loop.scenario === state.scenario;
}

// True for a loop that runs in a state.
function isAsked(loop, state) {
  return inScenario(loop, state) && !state.off.has(loop.law);
}

// True for a loop whose noise has another seed than its own.
function isReseeded(loop, state, printed) {
  return loop.normals > 0 && state.seed !== printed.seed;
}
