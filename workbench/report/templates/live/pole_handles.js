"use strict";

// The handles on a map of poles: a pole of the closed loop, or a pair, that a reader drags to another place. The knobs that the
// reader chooses take the numbers that put it there; a single knob moves it along its root locus.

const KEY_SHARE = 0.05; // of the distance of a pole from rest: by which an arrow key moves it
const LEAST_KEY = 0.005; // of the width of the panel
const REST_OF_KNOBS = 400; // ms without a turn, after which is learnt which knobs move the poles now

// A list of names in a sentence.
const listed = (names) => (names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`);

// The poles of one loop in a figure, each with a handle, and a line that says what moves and what follows.
class PoleHandles {
  constructor(handles, { figure, panel, loop, name, layer }) {
    const { page } = handles, { period } = page.data.loops[loop].linear, id = `drag-${figure}-${loop}`;
    Object.assign(this, { page, figure, panel, loop, name, layer, period, records: [], active: null, known: null, preferred: "", refusal: "" });
    this.pursuit = new Pursuit((aim) => this.seek(aim), (error) => page.fail(error));
    this.choice = part("select", { id });
    this.choice.addEventListener("change", () => this.prefer(this.choice.value));
    this.label = part("label", { for: id });
    [this.told, this.warned] = [part("span"), part("span", { role: "status" })];
    this.row = part("p", { class: "live-drag", hidden: true }, this.label, " ", this.choice, this.told, this.warned);
  }

  get rulers() {
    const { x, y, box } = this.page.figure(this.figure).panels[this.panel];
    return { x, y, box };
  }

  isFound(answer) {
    return Boolean(answer?.poles);
  }

  // Take what was learnt of the loop with inputs `key`: its poles, each with the choices of knobs that place it.
  learn({ poles }, places, key) {
    const named = ({ knobs, holds }) => ({ holds, knobs: knobs.map((i) => places[i]), key: `${holds ? "all " : ""}${knobs.map((i) => places[i])}` });
    this.known = { key, poles: poles.map(({ choices, ...at }) => ({ ...at, choices: choices.map(named) })) };
    this.offered = true;
  }

  // Learn the choices at the numbers of now, where they are not known.
  async refresh() {
    const { page, loop } = this, key = keyOf(page, loop);
    if (this.known.key === key || page.failed) return;
    const { inputs, all } = askedOf(page, loop, []), poles = await page.crew().ask(loop, { kind: "poles", ...inputs, knobs: all });
    this.learn({ poles }, all.map(({ place }) => place), key);
    page.handles.place(this.figure);
  }

  // Stand at the poles of an answer that are in sight; those that nothing moves have no handle.
  place(answer, key, wanted) {
    this.pursuit.hear(key, wanted);
    const { re, im } = (this.known && this.page.figure(this.figure) && answer?.poles) || { re: [], im: [] };
    const { x, y, box } = re.length ? this.rulers : {}, seen = [...re.keys()].filter((k) => im[k] >= 0 && isInBox(x.at(re[k]), y.at(im[k]), box));
    this.assign(seen.map((k) => ({ re: re[k], im: im[k] })));
    for (const record of this.records) this.stand(record, key, wanted);
    const shown = this.records.filter(({ element }) => !element.hidden);
    if (this.active?.element.hidden ?? true) this.active = shown.find(({ at }) => at.im > 0) ?? shown[0] ?? null;
    this.stable = answer?.stable;
    this.row.hidden = !this.active;
    for (const record of this.records) record.element.classList.toggle("chosen", record === this.active && shown.length > 1);
    if (this.active && key === wanted) this.describe(); // else the answer to what is turned is still to come
    clearTimeout(this.waiting);
    if (this.known && this.known.key !== wanted && key === wanted && this.page.near.has(this.figure)) {
      this.waiting = setTimeout(() => this.pursuit.aim || this.safely(this.refresh()), REST_OF_KNOBS);
    }
  }

  // A fault of the worker ends all that is live.
  safely(promise) {
    promise.catch((error) => this.page.fail(error));
  }

  // Give each handle the pole nearest to it, the one that is dragged first; poles without one get one.
  assign(poles) {
    const left = [...poles], away = ({ re, im }, to) => Math.hypot(re - to.re, im - to.im);
    for (const record of [...this.records].sort((a, b) => (b === this.active) - (a === this.active))) {
      const near = (record === this.active && this.pursuit.target) || record.at;
      const best = left.reduce((one, pole) => (one && away(one, near) <= away(pole, near) ? one : pole), null);
      if (best) left.splice(left.indexOf(best), 1);
      record.isThere = Boolean(best);
      record.at = best ?? record.at;
    }
    for (const record of this.records) if (!record.isThere && record !== this.active) record.element.remove();
    this.records = this.records.filter((record) => record.isThere || record === this.active);
    for (const at of left) this.records.push(this.made(at));
  }

  made(at) {
    const element = part("div", { class: "live-handle live-pole", role: "slider", tabindex: 0, hidden: true }, part("span", { "aria-hidden": "true" }));
    const record = { element, at, choices: null, stands: null, isThere: true }, { page, figure, pursuit } = this;
    const key = (way) => this.step(record, way), grab = (point) => this.grab(record, point), drag = (point) => this.drag(record, point);
    listenTo(element, { page, figure, pursuit, key, grab, drag });
    element.addEventListener("focus", () => this.choose(record));
    this.layer.append(element);
    return record;
  }

  // A handle stands at its pole, if a knob moves it.
  stand(record, key, wanted) {
    const { at, element } = record;
    if (key === wanted) record.stands = null;
    if (record.isThere && this.known.key === key) {
      const isAt = (one) => Math.hypot(one.re - at.re, one.im - at.im) <= 1e-6 * Math.hypot(at.re, at.im);
      record.choices = this.known.poles.find(isAt)?.choices ?? [];
    }
    element.hidden = !record.isThere || !(record.choices?.length || (!record.choices && record === this.active));
    if (element.hidden) return;
    const { width, height } = this.page.data.plates[this.figure], { x, y } = this.rulers;
    Object.assign(element.style, { left: `${100 * x.at(at.re) / width}%`, top: `${100 * y.at(at.im) / height}%` });
    const text = `${this.text(at)}.`, values = { "aria-label": `${at.im > 0 ? "Pair of poles" : "Pole"} of the closed loop${this.name}` };
    Object.assign(values, { "aria-valuemin": x.low, "aria-valuemax": x.high, "aria-valuenow": at.re, "aria-valuetext": text });
    writeAttributes(element, values);
  }

  // A place of the plane, as a reader writes it.
  number({ re, im }) {
    return withUnit(im > 0 ? `${shortNumber(re)} ± ${shortNumber(im)}j` : shortNumber(re), this.period === null ? "rad/s" : "");
  }

  text(at) {
    const damping = at.im > 0 ? `, damping ${shortNumber(leastDamping({ re: [at.re], im: [at.im] }, this.period), 3)}` : "";
    return `${at.im > 0 ? "Poles" : "Pole"} at ${this.number(at)}${damping}`;
  }

  // The choice of knobs that moves a pole: the one that the reader prefers, or else the best one.
  choiceOf({ choices }) {
    return choices?.find(({ key }) => key === this.preferred) ?? choices?.[0] ?? null;
  }

  prefer(key) {
    Object.assign(this, { preferred: key, refusal: "" });
    this.describe();
  }

  // The line below the figure: what moves the pole that was chosen last, and where it is.
  describe() {
    const { data, state } = this.page, { active, refusal } = this, name = (knob) => data.knobs[knob].name, choices = active.choices ?? [];
    const words = ({ knobs, holds }) => `${listed(knobs.map(name))}${holds ? ", and no other pole" : knobs.length < 2 ? " alone" : ""}`;
    const unitOf = (knob) => data.knobs[knob].unit.replace("?", ""), keys = choices.map(({ key }) => key).join(";"), choice = this.choiceOf(active);
    if (keys !== this.shownKeys) this.choice.replaceChildren(...choices.map((one) => part("option", { value: one.key }, words(one))));
    this.shownKeys = keys;
    if (choice) this.choice.value = choice.key;
    writeText(this.label, `Dragging the ${active.at.im > 0 ? "pair of poles" : "pole"}${this.name} moves`);
    const numbers = (choice?.knobs ?? []).map((knob) => `${name(knob)} = ${withUnit(shortNumber(state.values[knob], 6), unitOf(knob))}`);
    writeText(this.told, refusal ? "" : `${[this.text(active.at), `the loop is ${this.stable ? "stable" : "unstable"}`, ...numbers].join(", ")}.`);
    writeText(this.warned, refusal);
  }

  // The pole that the line below the figure tells of.
  choose(record) {
    if (record !== this.active) {
      this.pursuit.end();
      Object.assign(this, { active: record, refusal: "" });
      this.page.handles.place(this.figure);
    }
    this.safely(this.refresh());
  }

  step(record, [right, up]) {
    const from = this.pursuit.target ?? record.at, { x } = this.rulers, rest = this.period === null ? 0 : 1;
    const size = Math.max(KEY_SHARE * Math.hypot(from.re - rest, from.im), LEAST_KEY * (x.high - x.low));
    this.wish(record, { re: from.re + right * size, im: from.im + up * size });
  }

  grab(record, { x, y }) {
    const { rulers } = this;
    this.grip = { x: x - rulers.x.at(record.at.re), y: y - rulers.y.at(record.at.im) };
  }

  drag(record, point) {
    const { x, y } = this.rulers, { grip } = this;
    this.wish(record, { re: (point.x - grip.x - x.offset) / x.slope, im: (point.y - grip.y - y.offset) / y.slope });
  }

  // Move a pole to a place within the picture, on or above the real axis.
  wish(record, { re, im }) {
    const { x, y } = this.rulers;
    return this.pursuit.wish({ record, re: Math.min(x.high, Math.max(x.low, re)), im: Math.min(y.high, Math.max(0, im)) });
  }

  // Ask the worker for the numbers of the knobs, and turn the knobs there.
  async seek(aim) {
    const { page, loop } = this, { record, re, im } = aim.target, target = { re, im };
    if (!record.choices) await this.refresh();
    const choice = this.choiceOf(record), { inputs, all, isStill } = askedOf(page, loop, []);
    const indices = (choice?.knobs ?? []).map((place) => all.findIndex((knob) => knob.place === place));
    if (!choice || indices.includes(-1)) return this.pursuit.end(aim);
    const asked = { kind: "pole", ...inputs, knobs: all, from: record.stands ?? record.at, target, choice: { ...choice, knobs: indices } };
    const found = await page.crew().ask(loop, asked);
    if (page.failed || !isStill() || !this.pursuit.aim) return this.pursuit.end(aim);
    const places = found.knobs.map((i) => all[i].place);
    this.preferred ||= choice.key; // which stays, though another may become the best one
    this.refusal = this.refusalOf(found, target, choice, places);
    record.stands = found.at;
    turnKnobs(page, places, found.values);
    this.pursuit.arrive(aim, { record, ...found.at }, keyOf(page, loop));
    page.handles.place(this.figure);
  }

  // What a reader must know of a drag that did not do what was asked; else nothing.
  refusalOf({ reached, blocked, isUnique, holds, values, at }, target, choice, places) {
    const { knobs } = this.page.data, names = listed(choice.knobs.map((knob) => knobs[knob].name)), stop = this.number(at);
    const some = blocked ? " and as far as the loop has linear answers" : "", pole = at.im > 0 ? "The poles stop" : "The pole stops";
    if (!isUnique && !places.length) return `No number of ${names} moves this pole here.`;
    if (!isUnique) return `Here ${names} do not place this pole in one way: it follows ${knobs[places[0]].name} alone.`;
    if (reached) return "";
    if (places.length > 1) {
      const how = holds ? "as far on the way there as the other poles stay" : "the nearest place that was found";
      return `Within their ranges${some}, ${names} do not put ${at.im > 0 ? "these poles" : "this pole"} at ${this.number(target)}. ${pole} at ${stop}, ${how}.`;
    }
    const { name, low, high, unit } = knobs[places[0]], end = { [low]: "least", [high]: "largest" }[values[0]];
    return end ? `The locus of ${name} ends at its ${end} number, ${withUnit(shortNumber(values[0]), unit)}. ${pole} at ${stop}.` : "";
  }

  remove() {
    for (const { element } of this.records) element.remove();
    this.row.remove();
  }
}
