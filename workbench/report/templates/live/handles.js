"use strict";

// Handles on Bode plots: a gain crossover that a reader drags to another frequency. One knob of the law, which the reader
// chooses, then takes the number at which |L| is one there, as if it had been turned by hand.

const SAME = 1e-6; // in a logarithm: two frequencies that are one
const KEY_STEP = 10 ** (1 / 20); // by which an arrow key moves a crossover

const onDecades = (omega, other) => Math.abs(Math.log(omega / other));

// The handle of a crossover of one channel in a figure, with the knobs that move it and a line that says what follows.
class CrossoverHandle {
  constructor(handles, { figure, panel, loop, channel, name, layer }) {
    const { page } = handles, ring = part("span", { "aria-hidden": "true" });
    Object.assign(this, { page, figure, panel, loop, channel, name, knobs: [], omega: null, aim: null, refusal: "" });
    this.element = part("div", { class: "live-handle", role: "slider", tabindex: 0, "aria-label": `Gain crossover${name}`, hidden: true }, ring);
    const id = `drag-${figure}-${loop}-${channel}`;
    this.choice = part("select", { id });
    this.choice.addEventListener("change", () => this.say(""));
    [this.told, this.warned] = [part("span"), part("span", { role: "status" })];
    this.row = part("p", { class: "live-drag", hidden: true }, part("label", { for: id }, `Dragging the gain crossover${name} moves`), " ", this.choice, ". ", this.told, this.warned);
    layer.append(this.element);
    this.element.addEventListener("keydown", (event) => this.key(event));
    for (const type of ["pointerdown", "pointermove", "pointercancel"]) {
      this.element.addEventListener(type, (event) => this[type](event));
    }
  }

  // Offer the knobs that move the crossover, the strongest first.
  offer(knobs) {
    Object.assign(this, { knobs, offered: true });
    this.choice.replaceChildren(...knobs.map((knob) => part("option", { value: knob }, this.page.data.knobs[knob].name)));
  }

  get rulers() {
    const { x, y, box } = this.page.figure(this.figure).panels[this.panel];
    return { x, y, box };
  }

  // The crossover of an answer: the one nearest to where the handle was or is to go, at first the highest.
  crossoverOf(answer) {
    const { low, high } = this.rulers.x, rows = (answer?.margins?.[this.channel]?.gainCrossovers ?? []).filter(({ omega }) => omega >= low && omega <= high);
    const near = this.aim ?? this.omega;
    if (near === null) return rows.at(-1);
    return rows.reduce((best, row) => (!best || onDecades(row.omega, near) < onDecades(best.omega, near) ? row : best), undefined);
  }

  // Stand where the crossover is now; without one the handle is not there.
  place(answer, isCurrent) {
    const row = this.knobs.length && this.page.figure(this.figure) ? this.crossoverOf(answer) : undefined;
    const at = row && { x: this.rulers.x.at(row.omega), y: this.rulers.y.at(0) }, shown = Boolean(at && isInBox(at.x, at.y, this.rulers.box));
    this.element.hidden = this.row.hidden = !shown;
    if (!shown) return;
    const { width, height } = this.page.data.plates[this.figure];
    Object.assign(this.element.style, { left: `${100 * at.x / width}%`, top: `${100 * at.y / height}%` });
    this.omega = row.omega;
    if (isCurrent && !this.seeking && this.aim !== null && this.isSettled(row.omega)) this.aim = null;
    const margin = answer.margins[this.channel].stable ? `phase margin ${shortNumber(row.phase)}°` : "the loop is unstable";
    this.text = `Crossover at ${shortNumber(row.omega)}\u00a0rad/s, ${margin}`;
    this.describe();
  }

  // True if the crossover is where it was to go, or other knobs have been turned since.
  isSettled(omega) {
    return onDecades(omega, this.aim) < SAME || !this.sought?.every((value, i) => Object.is(value, this.page.state.values[i]));
  }

  // The numbers of now, as values of the slider and below the figure.
  describe() {
    const { low, high } = this.rulers.x, knob = Number(this.choice.value), { name, unit } = this.page.data.knobs[knob];
    const number = `${name} = ${withUnit(shortNumber(this.page.state.values[knob], 6), unit)}`, text = `${this.text}, ${number}.`;
    const values = { "aria-valuemin": low, "aria-valuemax": high, "aria-valuenow": this.omega, "aria-valuetext": text };
    for (const [key, value] of Object.entries(values)) this.element.setAttribute(key, value);
    this.told.textContent = this.refusal ? "" : text;
    if (this.warned.textContent !== this.refusal) this.warned.textContent = this.refusal;
  }

  // A sentence in the place of the numbers, until the next one.
  say(refusal) {
    this.refusal = refusal;
    this.describe();
  }

  key(event) {
    const turns = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (!turns || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    this.wish((this.aim ?? this.omega) * KEY_STEP ** turns);
  }

  pointerdown(event) {
    if (event.button) return;
    event.preventDefault();
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    this.grip = this.across(event) - this.rulers.x.at(this.omega);
  }

  pointermove(event) {
    if (!this.element.hasPointerCapture(event.pointerId)) return;
    const { x } = this.rulers;
    this.wish(10 ** ((this.across(event) - this.grip - x.offset) / x.slope));
  }

  pointercancel() {
    this.aim = null;
  }

  // The abscissa of a pointer on the sheet.
  across({ clientX }) {
    const { left, width } = this.element.parentElement.getBoundingClientRect();
    return (clientX - left) / width * this.page.data.plates[this.figure].width;
  }

  // Move the crossover to a frequency within the plot; what is wished meanwhile follows, the newest alone.
  async wish(omega) {
    const { low, high } = this.rulers.x;
    this.aim = Math.min(high, Math.max(low, omega));
    if (this.seeking) return;
    this.seeking = true;
    try {
      for (let done = null; this.aim !== null && this.aim !== done;) {
        done = this.aim;
        await this.seek(done);
      }
    } catch (error) {
      this.page.fail(error);
    } finally {
      this.seeking = false;
    }
  }

  // Ask the worker for the number of the knob, and turn the knob there.
  async seek(omega) {
    const { page, loop, channel } = this, place = Number(this.choice.value), control = page.bench.knobs[place];
    const { p, x } = inputsOf(page.data.loops[loop], page.state, page.printed, page.data.knobs);
    const knob = movedBy(page, loop).find((one) => one.place === place);
    const { value, reached, blocked } = await page.crew().ask(loop, { kind: "crossover", p, x, knob, channel, omega });
    if (page.failed) return;
    const { name, unit, low, high } = control.knob, [least, most, now] = [low, high, value].map((one) => shortNumber(one, 4));
    const some = blocked ? ", as far as the loop has linear answers," : "";
    this.refusal = reached ? "" : `No value of ${name} from ${least} to ${most}${some} puts this crossover at ${shortNumber(omega)}\u00a0rad/s. It stops at ${withUnit(now, unit)}.`;
    const moves = !Object.is(value, page.state.values[place]);
    if (this.aim === omega && !(reached && moves)) this.aim = null;
    if (moves) control.turn(value);
    this.sought = [...page.state.values];
    this.describe();
  }

  remove() {
    this.element.remove();
    this.row.remove();
  }
}

// The knobs that move parameters of the law of a loop alone, as a worker reads them; `place` is theirs on the page.
function movedBy(page, loop) {
  const { data, state } = page;
  return data.loops[loop].moves.filter(({ p, names }) => p.length && names.every((name) => name.startsWith("controller."))).map(({ knob, p, x }) => {
    const { low, high, log, share } = data.knobs[knob];
    return { place: knob, p, x, low, high, log, share, value: state.values[knob] };
  }).filter(({ share, value }) => !share || value !== 0);
}

// All handles of a page, and the answers at the baseline, which the page has no other use for.
class Handles {
  constructor(page) {
    Object.assign(this, { page, baseline: new Map(), looked: new Map() });
    const { data } = page, links = data.linear_marks.filter(({ quantity, loop }) => quantity === "magnitude" && data.loops[loop].linear);
    this.all = links.flatMap((link) => {
      const sheet = document.querySelector(`[data-figure="${CSS.escape(link.figure)}"] .scroll`);
      if (!sheet || !data.plates[link.figure]) return [];
      const { channels } = data.loops[link.loop].linear, beside = links.filter(({ figure }) => figure === link.figure);
      const laws = new Set(beside.map(({ loop }) => loop)).size > 1 ? ` of ${data.loops[link.loop].label}` : "";
      const name = `${channels.length > 1 ? ` at ${channels[link.channel]}` : ""}${laws}`;
      return [new CrossoverHandle(this, { ...link, name, layer: layerOf(sheet, data.plates[link.figure]) })];
    });
    for (const handle of this.all) document.querySelector(`[data-figure="${CSS.escape(handle.figure)}"] figcaption`)?.before(handle.row);
  }

  // Place the handles of a figure, or of all.
  place(figure = null) {
    for (const handle of this.all) {
      if (figure !== null && handle.figure !== figure) continue;
      const { page } = this, { loop } = handle, wanted = page.wanted.get(loop), found = page.answers.get(loop);
      const answer = wanted ? found?.answer : this.baseline.get(loop), isAway = !isAsked(page.data.loops[loop], page.state);
      const isTurning = page.frame || page.held; // what is turned is not asked for yet
      handle.place(isAway ? null : answer, !isTurning && (!wanted || found?.key === wanted.key));
      const crosses = answer?.margins?.[handle.channel]?.gainCrossovers.length;
      if (!handle.offered && !isAway && crosses) this.survey(loop, wanted?.key ?? "");
    }
  }

  // Learn the answers at the baseline of the loops that are shown, of which a page keeps none.
  open() {
    const shown = new Set(this.all.map(({ loop }) => loop));
    for (const loop of shown) if (!this.baseline.has(loop) && isAsked(this.page.data.loops[loop], this.page.state)) this.survey(loop, "");
  }

  // Ask once, at the numbers of now or at the baseline, which knobs move the crossovers of a loop.
  async survey(loop, key) {
    if (this.looked.get(loop) === key) return;
    this.looked.set(loop, key);
    const { page } = this, { data, printed, state } = page, from = key ? state : printed;
    const { p, x } = inputsOf(data.loops[loop], from, printed, data.knobs), knobs = movedBy({ data, state: from }, loop);
    try {
      const { answer, channels } = await page.crew().ask(loop, { kind: "survey", p, x, knobs });
      if (page.failed) return;
      if (!key) this.baseline.set(loop, new LoopAnswer(answer, data.loops[loop].linear));
      for (const handle of this.all) {
        const found = handle.loop === loop && !handle.offered ? channels[handle.channel] : null;
        if (found) handle.offer(found.map((i) => knobs[i].place));
      }
      this.place();
    } catch (error) {
      page.fail(error);
    }
  }

  remove() {
    for (const handle of this.all) handle.remove();
  }
}

// What holds the handles of a figure above its sheet, outside of the picture itself, which is one image to those who listen.
function layerOf(sheet, { width, height }) {
  const held = sheet.querySelector(".live-handles > div");
  if (held) return held;
  const made = part("div", { style: `aspect-ratio: ${width} / ${height}` });
  sheet.append(part("div", { class: "live-handles" }, made));
  return made;
}
