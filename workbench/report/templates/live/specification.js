"use strict";

// A specification that a reader turns: limits of S and T. The knobs of a PID take the numbers of the largest Ki that meets them,
// as if they had been turned by hand.

const LAWS = ["PI", "PID"];

class SpecificationControl {
  constructor(page, { name, loop, channel, knobs, Ms, Mt }, place) {
    Object.assign(this, { page, loop, channel, knobs, met: null, target: { Ms: Ms.value, Mt: Mt?.value ?? Infinity, count: 2 } });
    this.pursuit = new Pursuit((aim) => this.seek(aim), (error) => page.fail(error));
    const id = `specification-${place}`, { data } = page, several = data.specifications.some((one) => one.loop !== loop);
    const limit = (one) => new KnobControl({ ...one, unit: "1", log: false, share: false, origin: "" }, `${id}-${one.name}`, (value) => this.wish({ [one.name]: value }));
    this.limits = [Ms, Mt].filter(Boolean).map(limit);
    for (const control of this.limits) control.show(control.knob.value);
    this.law = part("select", { id: `${id}-law` }, ...LAWS.slice(0, knobs.length - 1).map((one, i) => part("option", { value: i + 2 }, `${one}: ${this.names(i + 2)}`)));
    this.law.addEventListener("change", () => this.wish({ count: Number(this.law.value) }));
    this.told = part("p", { class: "bench-told", role: "status" });
    this.again = part("button", { type: "button", class: "bench-plain", onclick: () => this.wish({}) }, "meet it again");
    this.element = part("fieldset", { class: "bench-specification" },
      part("legend", {}, `${name}${several ? ` of ${data.loops[loop].label}` : ""}: the largest ${this.name(1)} with |S| \u2264 Ms${Mt ? " and |T| \u2264 Mt" : ""}`),
      ...this.limits.map(({ row }) => row),
      part("p", { class: "bench-line", hidden: knobs.length < 3 }, part("label", { for: `${id}-law` }, "Law"), this.law), this.told);
  }

  name(i) {
    return this.page.data.knobs[this.knobs[i]].name;
  }

  names(count) {
    return listed([...Array(count).keys()].map((i) => this.name(i)));
  }

  // Ask for gains with a limit, or a law, that is another one.
  wish(changed) {
    Object.assign(this.target, changed);
    this.pursuit.wish({ ...this.target });
  }

  // The numbers of the knobs are others: what the line says may not be true of them any more.
  place() {
    const { page, met } = this, { values } = page.state, same = (one) => one.every((value, i) => Object.is(value, values[i]));
    this.element.hidden = !isAsked(page.data.loops[this.loop], page.state);
    if (met && same(met)) return;
    const isBaseline = same(page.printed.values);
    this.met = null;
    if (this.pursuit.aim) return;
    if (isBaseline || !this.wasMet) this.say(`A turn of a limit moves ${this.names(this.target.count)}.`);
    else this.say("A knob has been turned since: ", this.again, ".");
  }

  say(...texts) {
    this.told.replaceChildren(...texts);
  }

  // Ask once without a turn, so that a browser has compiled what answers.
  async warm() {
    const { page, loop, channel, target: { Ms, Mt } } = this, { inputs, all } = askedOf(page, loop, []);
    const gains = this.knobs.slice(0, 2).map((place) => all.find((one) => one.place === place));
    if (!gains.includes(undefined)) await page.crew().ask(loop, { kind: "specification", ...inputs, channel, gains, Ms, Mt });
  }

  // Ask the worker for the gains, and turn the knobs there.
  async seek(aim) {
    const { page, loop, channel } = this, { Ms, Mt, count } = aim.target, { inputs, all, isStill } = askedOf(page, loop, []);
    const places = this.knobs.slice(0, count), gains = places.map((place) => all.find((one) => one.place === place));
    if (gains.includes(undefined)) return this.refuse(aim, "structure");
    const found = await page.crew().ask(loop, { kind: "specification", ...inputs, channel, gains, Ms, Mt });
    if (page.failed || this.pursuit.aim !== aim) return;
    if (!isStill()) return this.pursuit.wish(aim.target); // other knobs have been turned meanwhile
    if (found.reason) return this.refuse(aim, found.reason);
    const values = found.values.map((value, i) => Math.min(gains[i].high, Math.max(gains[i].low, value)));
    this.pursuit.end(aim);
    this.met = page.state.values.map((value, i) => (places.includes(i) ? values[places.indexOf(i)] : value));
    this.wasMet = true;
    this.tell(places, values, found);
    turnKnobs(page, places, values);
  }

  // The gains, the margins of the loop with them, and which range ends there.
  tell(places, values, { Ms, Mt }) {
    const { knobs } = this.page.data, number = (place, i) => withUnit(shortNumber(values[i]), knobs[place].unit.replace("?", ""));
    const gains = places.map((place, i) => `${knobs[place].name} = ${number(place, i)}`);
    const ends = places.filter((place, i) => [knobs[place].low, knobs[place].high].some((end) => Math.abs(values[i] - end) <= 1e-6 * Math.abs(end)));
    const more = ends.length ? ` ${listed(ends.map((place) => knobs[place].name))} ${ends.length > 1 ? "stand" : "stands"} at the end of a range.` : "";
    this.say(`${listed(gains)}. The loop has Ms\u00a0=\u00a0${evenNumber(Ms)} and Mt\u00a0=\u00a0${evenNumber(Mt)}.${more}`);
  }

  // One sentence on why the knobs stay where they are.
  refuse(aim, reason) {
    const { page } = this, { Ms, Mt, count } = aim.target, { knobs } = page.data;
    this.pursuit.end(aim);
    this.met = null;
    const ranges = this.knobs.slice(0, count).map((place) => `${knobs[place].name} from ${shortNumber(knobs[place].low)} to ${shortNumber(knobs[place].high)}`);
    const limits = `Ms \u2264 ${shortNumber(Ms)}${Number.isFinite(Mt) ? ` and Mt \u2264 ${shortNumber(Mt)}` : ""}`;
    const known = {
      none: `No ${listed(ranges)} give a stable loop with ${limits}. The knobs stay where they are.`,
      structure: `${this.names(count)} are not the gains of one PID at this input of the plant.`,
      unproved: "The margins of the loop do not confirm the gains that were found. The knobs stay where they are.",
    };
    this.say(known[reason] ?? `${reason} The knobs stay where they are.`);
  }
}
