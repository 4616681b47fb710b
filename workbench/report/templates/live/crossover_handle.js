"use strict";

// The handle on a Bode plot: a gain crossover that a reader drags to another frequency. One knob of the law, which the reader
// chooses, then takes the number at which |L| is one there, as if it had been turned by hand.

const KEY_STEP = 10 ** (1 / 20); // by which an arrow key moves a crossover

const onDecades = (omega, other) => Math.abs(Math.log(omega / other));

// The handle of a crossover of one channel in a figure, with the knobs that move it and a line that says what follows.
class CrossoverHandle {
  constructor(handles, { figure, panel, loop, channel, name, layer }) {
    const { page } = handles, ring = part("span", { "aria-hidden": "true" });
    Object.assign(this, { page, figure, panel, loop, channel, name, knobs: [], omega: null, refusal: "" });
    this.pursuit = new Pursuit((aim) => this.seek(aim), (error) => page.fail(error));
    this.element = part("div", { class: "live-handle", role: "slider", tabindex: 0, "aria-label": `Gain crossover${name}`, hidden: true }, ring);
    const id = `drag-${figure}-${loop}-${channel}`;
    this.choice = part("select", { id });
    this.choice.addEventListener("change", () => this.say(""));
    [this.told, this.warned] = [part("span"), part("span", { role: "status" })];
    this.row = part("p", { class: "live-drag", hidden: true }, part("label", { for: id }, `Dragging the gain crossover${name} moves`), " ", this.choice, this.told, this.warned);
    layer.append(this.element);
    listenTo(this.element, this);
  }

  // Take what was learnt of the loop: which knobs move the crossover, the strongest first.
  learn({ channels }, places) {
    const found = this.offered ? null : channels[this.channel];
    if (!found) return;
    const knobs = found.map((i) => places[i]);
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
    const near = this.pursuit.target ?? this.omega;
    if (near === null) return rows.at(-1);
    return rows.reduce((best, row) => (!best || onDecades(row.omega, near) < onDecades(best.omega, near) ? row : best), undefined);
  }

  // Stand where the crossover is now; without one the handle is not there.
  place(answer, key, wanted) {
    this.pursuit.hear(key, wanted);
    if (key !== wanted && this.text) return; // it waits where it is for the answer to what is turned
    const row = this.knobs.length && this.page.figure(this.figure) ? this.crossoverOf(answer) : undefined;
    const at = row && { x: this.rulers.x.at(row.omega), y: this.rulers.y.at(0) }, shown = Boolean(at && isInBox(at.x, at.y, this.rulers.box));
    this.element.hidden = this.row.hidden = !shown;
    if (!shown) return;
    const { width, height } = this.page.data.plates[this.figure];
    Object.assign(this.element.style, { left: `${100 * at.x / width}%`, top: `${100 * at.y / height}%` });
    this.omega = row.omega;
    const margin = answer.margins[this.channel].stable ? `phase margin ${shortNumber(row.phase)}°` : "the loop is unstable";
    this.text = `Crossover at ${shortNumber(row.omega)}\u00a0rad/s, ${margin}`;
    this.describe();
  }

  // The numbers of now, as values of the slider and below the figure.
  describe() {
    const { low, high } = this.rulers.x, knob = Number(this.choice.value), { name, unit } = this.page.data.knobs[knob];
    const number = `${name} = ${withUnit(shortNumber(this.page.state.values[knob], 6), unit)}`, text = `${this.text}, ${number}.`;
    const values = { "aria-valuemin": low, "aria-valuemax": high, "aria-valuenow": this.omega, "aria-valuetext": text };
    writeAttributes(this.element, values);
    writeText(this.told, this.refusal ? "" : text);
    writeText(this.warned, this.refusal);
  }

  // A sentence in the place of the numbers, until the next one.
  say(refusal) {
    this.refusal = refusal;
    this.describe();
  }

  key([right, up]) {
    this.wish((this.pursuit.target ?? this.omega) * KEY_STEP ** (right || up));
  }

  grab(at) {
    this.grip = at.x - this.rulers.x.at(this.omega);
  }

  drag(at) {
    const { x } = this.rulers;
    this.wish(10 ** ((at.x - this.grip - x.offset) / x.slope));
  }

  // Move the crossover to a frequency within the plot.
  wish(omega) {
    const { low, high } = this.rulers.x;
    return this.pursuit.wish(Math.min(high, Math.max(low, omega)));
  }

  // Ask the worker for the number of the knob, and turn the knob there.
  async seek(aim) {
    const { page, loop, channel } = this, place = Number(this.choice.value), omega = aim.target;
    const { control, inputs, knobs, isStill } = askedOf(page, loop, [place]);
    if (!knobs[0]) return this.pursuit.end(aim); // a share of nothing
    const { value, ...found } = await page.crew().ask(loop, { kind: "crossover", ...inputs, knob: knobs[0], channel, omega });
    if (page.failed || !isStill() || !this.pursuit.aim) return this.pursuit.end(aim);
    const { name, unit, low, high } = control[0].knob, [least, most, now] = [low, high, value].map((one) => shortNumber(one, 4));
    const some = found.blocked ? ", as far as the loop has linear answers," : "";
    this.refusal = found.reached ? "" : `No value of ${name} from ${least} to ${most}${some} puts this crossover at ${shortNumber(omega)}\u00a0rad/s. It stops at ${withUnit(now, unit)}.`;
    turnKnobs(page, [place], [value]);
    this.pursuit.arrive(aim, found.omega ?? this.omega, keyOf(page, loop));
    page.handles.place(this.figure);
  }

  // True if an answer has what the handle stands on.
  isFound(answer) {
    return Boolean(answer?.margins?.[this.channel]?.gainCrossovers.length);
  }

  remove() {
    this.element.remove();
    this.row.remove();
  }
}
