"use strict";

// Two settings of the knobs that a reader holds, to compare them by name with each other and with what is shown now.

const SLOTS = ["A", "B"];
const LONGEST_NAME = 24; // letters

// One of the two: an empty one is a button; one that holds has a name to be typed, the way back to it, and the way out.
class Slot {
  constructor(letter, changed) {
    Object.assign(this, { letter, changed, hold: null });
    this.take = part("button", { type: "button", class: "slot-take", onclick: () => changed.hold() }, `Hold as ${letter}`);
    this.sample = part("span", { class: `slot-sample held-${letter.toLowerCase()}`, "aria-hidden": "true" });
    const field = { type: "text", class: "slot-name", maxlength: LONGEST_NAME, autocomplete: "off", spellcheck: "false" };
    this.field = part("input", { ...field, "aria-label": `Name of the setting ${letter}` });
    this.field.addEventListener("input", () => changed.name(this.field.value.trim() || letter));
    this.back = part("button", { type: "button", class: "bench-plain", onclick: () => changed.show() }, "go to");
    this.out = part("button", { type: "button", class: "bench-plain", onclick: () => this.leave() }, "drop");
    this.held = part("span", { class: "slot-held" }, this.sample, this.field, this.back, this.out);
    this.row = part("div", { class: "slot" }, this.take, this.held);
    this.show(null);
  }

  // A setting that is held, by its name, or none.
  show(hold) {
    this.take.hidden = Boolean(hold);
    this.held.hidden = !hold;
    if (!hold) return;
    if (document.activeElement !== this.field) this.field.value = hold.name;
    this.back.setAttribute("aria-label", `Go to the setting ${hold.name}`);
    this.out.setAttribute("aria-label", `Drop the setting ${hold.name}`);
  }

  // Drop the setting, and leave the reader at the button that holds another.
  leave() {
    this.changed.drop();
    this.take.focus({ preventScroll: true });
  }
}

// What a live page has shown before: the runs before the last step of a knob, and those of the settings that are held.
class Holds {
  constructor(page) {
    Object.assign(this, { page, before: new Map(), answersBefore: new Map(), held: SLOTS.map(() => null) });
    this.slots = SLOTS.map((letter, i) => new Slot(letter, {
      hold: () => this.hold(i),
      name: (name) => this.rename(i, name),
      show: () => this.held[i] && page.goTo(this.held[i].state),
      drop: () => this.put(i, null),
    }));
    this.row = part("div", { class: "bench-holds", role: "group", "aria-label": "Settings to compare" },
      ...this.slots.map((slot) => slot.row));
  }

  // A reader begins to turn: the pictures that are whole now become the trace.
  step() {
    const whole = [...this.page.views].filter(([, view]) => view.done || view.phase === "coarse");
    this.before = new Map(whole);
    this.answersBefore = answersOf(this.page.answers);
  }

  hold(i) {
    const { page } = this, inputs = page.inputs();
    const hold = { name: SLOTS[i], state: copiedState(page.state), inputs, views: new Map(), answers: new Map() };
    for (const [place, { key, answer }] of page.answers) if (key === inputs.get(place)) hold.answers.set(place, answer);
    for (const [place, view] of page.views) if (view.done && view.key === inputs.get(place)) hold.views.set(place, view);
    this.put(i, hold);
  }

  put(i, hold) {
    const places = new Set([...placesOf(this.held[i]), ...placesOf(hold)]);
    this.held[i] = hold;
    this.slots[i].show(hold);
    for (const place of places) this.page.redraw(place);
    this.page.report();
  }

  rename(i, name) {
    if (!this.held[i]) return;
    this.held[i].name = name;
    this.slots[i].show(this.held[i]);
    for (const place of placesOf(this.held[i])) this.page.redraw(place);
    this.page.report();
  }

  // A run that is whole now: settings that were held before it was take it.
  hear(place, view) {
    for (const hold of this.held) if (hold && hold.inputs.get(place) === view.key) hold.views.set(place, view);
  }

  // A linear answer that has come, of what is turned as in a setting.
  hearAnswer(place, key, answer) {
    for (const hold of this.held) if (hold && hold.inputs.get(place) === key) hold.answers.set(place, answer);
  }

  // The linear answers of settings, those before the last step first: [{answers, kind, label}].
  get answers() {
    const shown = [{ answers: this.answersBefore, kind: "before", label: "" }];
    this.held.forEach((hold, i) => {
      if (hold) shown.push({ answers: hold.answers, kind: `held-${SLOTS[i].toLowerCase()}`, label: hold.name });
    });
    return shown;
  }

  // The text of a number of the linear answers under each setting that is held.
  linearNumbers(place, cell, baseline) {
    return this.held.filter(Boolean).map(({ inputs, answers }) => {
      if (!inputs.get(place)) return baseline;
      return answers.has(place) ? linearText(answers.get(place).value(cell)) : "\u2026";
    });
  }

  get names() {
    return this.held.filter(Boolean).map(({ name }) => name);
  }

  // A number of a loop under each setting that is held, as text; of one that is not turned there the baseline.
  numbers(place, baseline, number = 0) {
    return this.held.filter(Boolean).map(({ inputs, views }) => {
      if (!inputs.get(place)) return baseline;
      const view = views.get(place);
      if (typeof view?.divergedAt === "number") return "diverged";
      return view?.scores?.[0] ? evenNumber(view.scores[0][number][0]) : "\u2026";
    });
  }

  // The pale curves of a figure: [{panel, series, kind, label, x, y}], of loops that are shown now.
  curves(name) {
    const { data, state } = this.page;
    const shown = [[this.before, "before", ""]];
    this.held.forEach((hold, i) => hold && shown.push([hold.views, `held-${SLOTS[i].toLowerCase()}`, hold.name]));
    const mine = data.curves.filter(({ figure, loop }) => figure === name && isAsked(data.loops[loop], state));
    return shown.flatMap(([views, kind, label]) => mine.filter(({ loop }) => views.has(loop)).map((curve) => {
      const { panel, series, loop } = curve;
      return { panel, series, kind, label, ...this.numbersOf(views.get(loop), curve, data.loops[loop]) };
    }));
  }

  // The numbers of a curve of a run, made once.
  numbersOf(view, curve, loop) {
    view.numbers ??= new Map();
    if (!view.numbers.has(curve)) view.numbers.set(curve, numbersOfCurve(curve, view, loop));
    return view.numbers.get(curve);
  }
}

// The loops that a setting shows, in time or in linear answers.
function placesOf(hold) {
  return new Set(hold ? [...hold.views.keys(), ...hold.answers.keys()] : []);
}

// Answers by loops, out of those that a page holds with their inputs.
function answersOf(held) {
  return new Map([...held].map(([place, { answer }]) => [place, answer]));
}

// A number of a linear answer, or the words in its place, as text.
function linearText(value) {
  return typeof value === "number" ? evenNumber(value) : value;
}
