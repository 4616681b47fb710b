"use strict";

// Handles on pictures of a live page: what a reader drags there by pointer, finger or keys turns knobs, as if by hand. Each kind
// of handle says what it is and what to ask the worker; here is what all of them share.

const ARROWS = { ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowLeft: [-1, 0], ArrowDown: [0, -1] }; // to the right, upwards

// Write attributes and text where they are others than before, as each write asks for a layout.
function writeAttributes(element, values) {
  for (const [name, value] of Object.entries(values)) {
    if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
  }
}

function writeText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

// The way of a handle to where it was dragged last. An answer ends only the aim to which it belongs.
class Pursuit {
  constructor(seek, fail) {
    Object.assign(this, { seek, fail, aim: null, isSeeking: false });
  }

  // Where the handle is to go, or comes to stand once the answer is there; null where it stands.
  get target() {
    return this.aim?.target ?? null;
  }

  // Go to a target; what is wished meanwhile follows, the newest alone.
  async wish(target) {
    this.aim = { target, key: null };
    if (this.isSeeking) return;
    this.isSeeking = true;
    try {
      for (let done = null; this.aim && this.aim !== done;) {
        done = this.aim;
        await this.seek(done);
      }
    } catch (error) {
      this.fail(error);
    } finally {
      this.isSeeking = false;
    }
  }

  // The knobs have been turned for an aim: with the inputs `key` the handle comes to stand at `at`.
  arrive(aim, at, key) {
    if (aim === this.aim) Object.assign(aim, { target: at, key });
  }

  // Give an aim up, if it is the newest.
  end(aim = this.aim) {
    if (aim === this.aim) this.aim = null;
  }

  // An answer of the inputs `key` is shown, while those of `wanted` are asked for.
  hear(key, wanted) {
    if (this.aim && this.aim.key !== null && (key === this.aim.key || wanted !== this.aim.key)) this.aim = null;
  }
}

// Let an element be dragged and moved by keys: `handle` has key([right, up]), grab(at) and drag(at), in units of its sheet.
function listenTo(element, handle) {
  const on = (type, call) => element.addEventListener(type, call);
  const at = ({ clientX, clientY }) => {
    const { left, top, width } = element.parentElement.getBoundingClientRect(), scale = handle.page.data.plates[handle.figure].width / width;
    return { x: (clientX - left) * scale, y: (clientY - top) * scale };
  };
  on("keydown", (event) => {
    const way = ARROWS[event.key];
    if (!way || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    handle.key(way);
  });
  on("pointerdown", (event) => {
    if (event.button) return;
    event.preventDefault();
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    handle.grab(at(event));
  });
  on("pointermove", (event) => element.hasPointerCapture(event.pointerId) && handle.drag(at(event)));
  on("pointercancel", () => handle.pursuit.end());
}

// The knobs that move parameters of the law of a loop alone, as a worker reads them; `place` is theirs on the page.
function movedBy(page, loop) {
  const { data, state } = page;
  return data.loops[loop].moves.filter(({ p, names, knob }) => p.length && !data.knobs[knob].stops && names.every((name) => name.startsWith("controller."))).map(({ knob, p, x }) => {
    const { low, high, log, share } = data.knobs[knob];
    return { place: knob, p, x, low, high, log, share, value: state.values[knob] };
  }).filter(({ share, value }) => !share || value !== 0);
}

// What a question about some knobs of a loop says, their controls, and whether all knobs still stand as they did.
function askedOf(page, loop, places) {
  const { data, state, printed, bench } = page, { p, x } = inputsOf(data.loops[loop], state, printed, data.knobs), all = movedBy(page, loop);
  return {
    control: places.map((place) => bench.knobs[place]), inputs: { p, x },
    knobs: places.map((place) => all.find((one) => one.place === place)), all,
    isStill: () => state.values.every((value, i) => Object.is(value, page.state.values[i])),
  };
}

// Turn some knobs at once.
function turnKnobs(page, places, values) {
  const { bench } = page;
  if (places.every((place, i) => Object.is(values[i], page.state.values[place]))) return;
  places.forEach((place, i) => (bench.state.values[place] = values[i]));
  bench.changed();
}

// The inputs of a loop that are asked for now, as text; at the baseline it is empty.
const keyOf = (page, loop) => page.wanted.get(loop)?.key ?? "";

// All handles of a page, and the answers at the baseline, which the page has no other use for.
class Handles {
  constructor(page) {
    Object.assign(this, { page, baseline: new Map(), looked: new Map() });
    const { data } = page, kinds = { magnitude: CrossoverHandle, "poles of the closed loop": PoleHandles };
    const links = data.linear_marks.filter(({ quantity, loop }) => quantity in kinds && data.loops[loop].linear);
    this.all = links.flatMap((link) => {
      const sheet = document.querySelector(`[data-figure="${CSS.escape(link.figure)}"] .scroll`);
      if (!sheet || !data.plates[link.figure]) return [];
      const { channels } = data.loops[link.loop].linear, beside = links.filter(({ figure }) => figure === link.figure);
      const laws = new Set(beside.map(({ loop }) => loop)).size > 1 ? ` of ${data.loops[link.loop].label}` : "";
      const channel = link.quantity === "magnitude" && channels.length > 1 ? ` at ${channels[link.channel]}` : "";
      return [new kinds[link.quantity](this, { ...link, name: `${channel}${laws}`, layer: layerOf(sheet, data.plates[link.figure]) })];
    });
    for (const handle of this.all) document.querySelector(`[data-figure="${CSS.escape(handle.figure)}"] figcaption`)?.before(handle.row);
  }

  // Place the handles of a figure, or of all.
  place(figure = null) {
    for (const handle of this.all) {
      if (figure !== null && handle.figure !== figure) continue;
      const { page } = this, { loop } = handle, wanted = keyOf(page, loop), found = page.answers.get(loop);
      const answer = wanted ? found?.answer : this.baseline.get(loop), isAway = !isAsked(page.data.loops[loop], page.state);
      if (isAway || answer) handle.place(isAway ? null : answer, wanted ? found.key : "", wanted); // else it waits where it is
      if (!handle.offered && !isAway && handle.isFound(answer)) this.survey(loop, wanted);
    }
  }

  // Learn the answers at the baseline of the loops that are shown, of which a page keeps none.
  open() {
    const shown = new Set(this.all.map(({ loop }) => loop));
    for (const loop of shown) if (!this.baseline.has(loop) && isAsked(this.page.data.loops[loop], this.page.state)) this.survey(loop, "");
  }

  // Ask once, at the numbers of now or at the baseline, what moves the crossovers and the poles of a loop.
  async survey(loop, key) {
    if (this.looked.get(loop) === key) return;
    this.looked.set(loop, key);
    const { page } = this, { data, printed, state } = page, from = key ? state : printed;
    const { p, x } = inputsOf(data.loops[loop], from, printed, data.knobs), knobs = movedBy({ data, state: from }, loop);
    try {
      const { answer, ...found } = await page.crew().ask(loop, { kind: "survey", p, x, knobs });
      if (page.failed) return;
      if (!key) this.baseline.set(loop, new LoopAnswer(answer, data.loops[loop].linear));
      for (const handle of this.all) if (handle.loop === loop) handle.learn(found, knobs.map(({ place }) => place), key);
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
