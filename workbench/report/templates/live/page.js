"use strict";

// The page: knobs ask, workers compute, and what comes back goes into the figures and tables of the report. Nothing is
// read, compiled or started before the bench is opened; and whatever fails, the page stays as it was made.

const TOGETHER = 60; // ms after a request within which a linear answer waits for the run, so that both are drawn at once
const HOLD = 200; // ms that a request waits for the first results of the one before, so that dragging shows them
const NEAR = 400; // px beyond the window within which a figure is drawn at once
const MOST_SPOKEN = 8; // results that are read aloud
const REST = 600; // ms without a turn, after which the next one is a step of its own and leaves a trace
const SETTLED = 300; // ms after the last turn, when the address is written

const whenIdle = window.requestIdleCallback
  ? (call) => requestIdleCallback(call, { timeout: 300 })
  : (call) => setTimeout(call, 30);

// The parameters, states and seed of a loop in a state of the knobs, and a text that tells them from others.
function inputsOf(loop, state, printed, knobs) {
  const p = Float64Array.from(loop.p), x = Float64Array.from(loop.x0);
  const seed = isReseeded(loop, state, printed) ? state.seed : loop.seed;
  const turned = [];
  for (const { knob, p: ofParameters, x: ofStates, designs } of loop.moves) {
    const value = state.values[knob], { share, value: printed, stops } = knobs[knob];
    if (Object.is(value, printed)) continue;
    turned.push(`${knob}:${value}`);
    if (stops) {
      ofParameters.forEach((place, i) => (p[place] = designs[nearestStop(stops, value)][i]));
      continue;
    }
    for (const place of ofParameters) p[place] = share ? p[place] * value : value;
    for (const place of ofStates) x[place] = share ? x[place] * value : value;
  }
  if (seed !== loop.seed) turned.push(`seed:${seed}`);
  return { p, x, seed, key: turned.join(",") };
}

// The numbers of one curve from the rows of a run.
function numbersOfCurve(curve, view, loop) {
  if (curve.stages) return numbersOfPlan(curve, view, loop);
  const [first, last] = curve.rows, axis = (which, scale) => {
    const time = loop.times ? (row) => loop.times[row] : (row) => row * loop.every; // of a log they may be uneven
    if (which === "t") return Float64Array.from({ length: last - first }, (_, i) => scale * time(first + i));
    const [name, place] = which, rows = view[name], width = rows.length / (loop.rows + 1);
    return Float64Array.from({ length: last - first }, (_, i) => scale * rows[(first + i) * width + place]);
  };
  return { x: axis(curve.x, curve.scales[0]), y: axis(curve.y, curve.scales[1]) };
}

// The numbers of a plan in the first row of its curve, at times from that row's own on.
function numbersOfPlan({ rows: [row], y: [name, place], scales, stages, spacing }, view, loop) {
  const rows = view[name], first = row * (rows.length / (loop.rows + 1)) + place, start = row * loop.every;
  const each = (number) => Float64Array.from({ length: stages }, (_, j) => number(j));
  return { x: each((j) => scales[0] * (start + j * spacing)), y: each((j) => scales[1] * rows[first + j]) };
}

class LivePage {
  constructor(text, source) {
    Object.assign(this, { text, source, views: new Map(), figures: new Map(), wanted: new Map() });
    this.answers = new Map(); // the newest linear answers, {key, answer} by loops
    Object.assign(this, { late: new Set(), away: new Set() }); // loops and figures that are to be drawn
    this.near = new Set(); // figures in sight
    this.flight = null; // what was asked for last: its inputs, and the loops whose runs are not there yet
    this.bench = new Bench(() => this.begin());
    addEventListener("hashchange", () => this.follow());
    if (isStateAddress(location.hash)) this.bench.open(false);
    else if (document.body.classList.contains("bench-page")) this.openLater();
  }

  // Open the bench of a single loop, whose place is kept from the first, as soon as the pictures are there.
  openLater() {
    this.bench.set(true);
    requestAnimationFrame(() => setTimeout(() => this.bench.open(false)));
  }

  // The first opening: the data are read, the controls made, and the machinery when there is time.
  begin() {
    if (!("WebAssembly" in window && "DecompressionStream" in window && "Worker" in window && "BigInt" in window)) {
      return this.bench.refuse("This browser is too old to run the loops of this page; it stays as it was made.");
    }
    try {
      this.data = { linear_marks: [], specifications: [], ...JSON.parse(this.text) };
      this.printed = printedState(this.data);
      this.state = stateOfAddress(location.hash, this.data);
      this.tables = openTables(document, this.data);
      this.holds = new Holds(this);
      this.bench.fill(this.data, copiedState(this.state), (state) => this.turn(state), this.holds.row);
      offerPictures();
      this.motion = new Motion(this, this.bench.stage);
      this.handles = new Handles(this);
      this.specifications = this.data.specifications.map((one, i) => new SpecificationControl(this, one, i));
      this.bench.group.after(...this.specifications.map(({ element }) => element));
      this.watch();
    } catch (error) {
      return this.fail(error);
    }
    this.turn(this.state);
    this.movedAt = -Infinity; // to open a page is no step of a knob
    whenIdle(() => this.warm());
  }

  // A step of a knob begins.
  begun() {
    this.holds.step();
    if (!this.bench.panel.hidden) this.showWhatMoves();
  }

  // What the knobs move and the knobs are seen together.
  showWhatMoves() {
    bringIntoSight(this.data, new Set(this.asked(this.state)), this.bench.panel);
  }

  // Keep the names of the figures that are in the window or little beyond, without asking for a layout.
  watch() {
    const told = (entries) => {
      for (const { target, isIntersecting } of entries) {
        const { figure } = target.dataset;
        this.near[isIntersecting ? "add" : "delete"](figure);
        if (isIntersecting && this.away.has(figure)) this.guarded(() => this.paint(figure));
      }
    };
    const observer = new IntersectionObserver(told, { rootMargin: `${NEAR}px 0px` });
    for (const figure of document.querySelectorAll("[data-figure]")) observer.observe(figure);
  }

  // Start the workers and compile what the scenario needs, before the first turn.
  async warm() {
    try {
      const pool = this.crew();
      for (const place of this.asked(this.state)) await pool.prepare(place);
      this.handles.open();
      for (const one of this.specifications) await one.warm();
    } catch (error) {
      this.fail(error);
    }
  }

  crew() {
    const hear = (view) => this.guarded(() => this.hear(view));
    this.pool ||= new Pool(this.data, this.source, hear, (error) => this.fail(error));
    return this.pool;
  }

  // One sentence; the page goes back to what it was.
  fail(error) {
    if (this.failed) return;
    this.failed = true;
    if (this.pool) this.pool.end();
    this.handles?.remove();
    for (const place of [...this.views.keys(), ...this.answers.keys()]) this.drop(place);
    this.bench.refuse(`The loops cannot run here, and the page stays as it was made (${error.message || error}).`);
  }

  // A fragment that came from elsewhere, as by the reader's own hand.
  follow() {
    if (!isStateAddress(location.hash)) return;
    if (!this.data) return this.bench.open(false);
    const state = stateOfAddress(location.hash, this.data);
    if (addressOfState(state, this.data) === addressOfState(this.state, this.data)) return;
    this.goTo(state);
  }

  // Put the knobs to a state that did not come from them.
  goTo(state) {
    this.bench.show(copiedState(state));
    this.turn(this.bench.state);
  }

  asked(state) {
    return [...this.data.loops.keys()].filter((i) => this.data.loops[i] && isAsked(this.data.loops[i], state));
  }

  // The inputs of the loops of the state that differ from the baseline, as text, by their places.
  inputs() {
    return new Map([...this.wanted].map(([place, { key }]) => [place, key]));
  }

  // A new state: loops that are at the baseline go back to it, the others are asked for.
  turn(state) {
    if (this.failed) return;
    this.state = copiedState(state);
    const isFirst = !(performance.now() - this.movedAt < REST);
    this.turnedAt = this.movedAt = performance.now();
    if (isFirst) this.begun();
    clearTimeout(this.writing);
    this.writing = setTimeout(() => writeAddress(addressOfState(this.state, this.data)), SETTLED);
    this.wanted = new Map();
    for (const place of this.asked(this.state)) {
      const inputs = inputsOf(this.data.loops[place], this.state, this.printed, this.data.knobs);
      if (inputs.key) this.wanted.set(place, inputs);
    }
    for (const place of [...this.views.keys(), ...this.answers.keys()]) if (!this.wanted.has(place)) this.drop(place);
    this.motion.offer();
    if (this.pool) this.handles.open();
    this.ask();
    this.handles.place();
    for (const one of this.specifications) one.place();
  }

  // Ask for what is not there yet; soon, if first results of an older request are still on their way.
  ask() {
    clearTimeout(this.held);
    this.held = null;
    const wait = this.flight && this.flight.rough.size ? this.flight.began + HOLD - performance.now() : 0;
    if (wait > 0) return void (this.held = setTimeout(() => this.ask(), wait));
    const left = [...this.wanted].filter(([place, { key }]) => (this.views.get(place) || {}).fine !== key);
    const places = left.map(([place]) => place);
    const runs = left.map(([place, { p, x, seed }]) => ({ loop: place, p, x, seed, printed: false }));
    const before = this.motion.missing;
    if (before !== null) {
      const { p, x, seed } = inputsOf(this.data.loops[before], this.printed, this.printed, this.data.knobs);
      runs.push({ loop: before, p, x, seed, printed: true });
    }
    const began = performance.now();
    const sets = { rough: new Set(places), whole: new Set(places), fine: new Set(places) }; // that are waited for
    this.flight = runs.length ? { began, keys: this.inputs(), ...sets } : null;
    this.report();
    if (this.pool || runs.length) this.crew().request(runs, this.inSight()).catch((error) => this.fail(error));
  }

  // The loops that a reader sees in a figure now.
  inSight() {
    const drawn = [...this.data.curves, ...this.data.marks, ...this.data.linear_marks];
    return new Set(drawn.filter((link) => this.near.has(link.figure)).map((link) => link.loop));
  }

  // Rows of a run have come.
  hear(view) {
    const { flight } = this, place = view.loop;
    if (this.failed || !flight || view.ticket !== this.pool.ticket) return;
    if (view.phase === "linear") return this.hearLinear(view);
    if (view.printed) return this.motion.takePrinted(view);
    if (!this.wanted.has(place)) return;
    const { phase, done, ends } = view, errors = phase === "half"; // which have the curves of the step itself
    const key = flight.keys.get(place), shown = { ...this.views.get(place), ...(errors ? { phase } : { ...view, numbers: null }), key, fine: null };
    if (done) flight.rough.delete(place);
    if (phase === "coarse") Object.assign(shown, { done: false, scores: null }); // a picture, and no number of it
    else if (done) {
      if (!errors) shown.whole = ends;
      else shown.fine = key; // the inputs of which it is the last word
      shown.scores = scoresOf(this.data.loops[place], shown.whole, errors ? ends : undefined);
      flight.whole.delete(place);
      if (errors) flight.fine.delete(place);
      this.spent = (performance.now() - this.turnedAt) / 1000;
      this.holds.hear(place, shown);
    }
    this.views.set(place, shown);
    if (done) this.report();
    this.redraw(place);
    if (phase === "whole" && done && !flight.whole.size) this.drawNow();
    if (!done) return;
    if (!flight.rough.size && this.held) this.ask();
  }

  // The linear answer of a loop has come.
  hearLinear({ loop: place, printed, linear }) {
    const about = this.data.loops[place].linear;
    if (printed || !about || !this.wanted.has(place)) return;
    const key = this.flight.keys.get(place), answer = new LoopAnswer(linear, about);
    this.answers.set(place, { key, answer });
    this.holds.hearAnswer(place, key, answer);
    const wait = this.flight.rough.has(place) ? this.flight.began + TOGETHER - performance.now() : 0;
    const show = () => {
      this.report();
      this.redraw(place);
    };
    if (wait <= 0) show();
    else setTimeout(() => this.answers.get(place)?.answer === answer && this.flight?.rough.has(place) && show(), wait);
  }

  // A loop goes back to the baseline.
  drop(place) {
    this.views.delete(place);
    this.answers.delete(place);
    this.redraw(place);
  }

  // The loop's figures, tables and drawing are drawn in the next frame, those out of sight when there is time.
  redraw(place) {
    this.late.add(place);
    this.frame ||= requestAnimationFrame(() => {
      this.frame = null;
      this.draw();
    });
  }

  // All exact runs are there: nothing is gained by waiting for the next frame.
  drawNow() {
    cancelAnimationFrame(this.frame);
    this.frame = null;
    this.draw();
  }

  draw() {
    const places = [...this.late], names = new Set();
    this.late.clear();
    for (const place of places) {
      this.guarded(() => this.drawNumbers(place, this.views.get(place)));
      const { curves, marks, linear_marks: linear } = this.data;
      for (const link of [...curves, ...marks, ...linear]) if (link.loop === place) names.add(link.figure);
    }
    for (const name of names) {
      if (this.near.has(name)) this.guarded(() => this.paint(name));
      else this.away.add(name);
    }
    if (this.away.size && !this.flight?.whole.size) whenIdle(() => this.guarded(() => this.paintAway()));
    this.drawn = performance.now(); // for those who measure how soon a turn is seen
  }

  drawNumbers(place, view) {
    if (!view) this.tables.clear(place);
    else if (view.done) this.tables.show(place, view.scores, view.divergedAt);
    if (!view || view.done) this.motion.load(place);
    this.tables.showLinear(place, this.answerOf(place));
  }

  // A fault ends all that is live.
  guarded(call) {
    try {
      call();
    } catch (error) {
      if (!this.failed) this.fail(error);
    }
  }

  // One of the figures out of sight, and then the next, unless exact runs are to come.
  paintAway() {
    const [name] = this.away;
    if (name === undefined || this.flight?.whole.size) return;
    this.paint(name);
    if (this.away.size) whenIdle(() => this.guarded(() => this.paintAway()));
  }

  figure(name) {
    if (!this.figures.has(name)) {
      const svg = document.querySelector(`[data-figure="${CSS.escape(name)}"] svg`), plate = this.data.plates[name];
      this.figures.set(name, svg && plate ? openFigure(svg, plate) : null);
    }
    return this.figures.get(name);
  }

  // Draw a figure, and place its handles.
  paint(name) {
    this.away.delete(name);
    this.paintMarks(name);
    this.handles.place(name);
  }

  // All curves, bars and points of a figure whose loops have run, over those before; without any it is as it was made.
  paintMarks(name) {
    const curves = this.data.curves.filter((curve) => curve.figure === name && this.views.has(curve.loop));
    const marks = this.marksOf(name), pale = this.holds.curves(name), linear = this.linearOf(name);
    const some = curves.length + marks.length + pale.length + linear.curves.length + linear.pale.length + linear.sets.length;
    if (!some && !linear.refused && !this.figures.has(name)) return;
    const figure = this.figure(name);
    if (!figure) return;
    if (!some && !linear.refused) return figure.clear();
    const drawn = curves.map((curve) => {
      const { panel, series, loop } = curve, view = this.views.get(loop), coarse = view.phase === "coarse";
      return { panel, series, coarse, ...this.holds.numbersOf(view, curve, this.data.loops[loop]) };
    });
    figure.show([...drawn, ...linear.curves], marks, [...pale, ...linear.pale], linear);
    figure.refuse?.(linear.refused);
  }

  // The linear answer of a loop now: none at the baseline, and a refusal where a page cannot make the loop linear.
  answerOf(place) {
    const { linear, linear_refused: reason } = this.data.loops[place];
    if (linear) return this.answers.get(place)?.answer ?? null;
    return reason && this.wanted.has(place) ? new LoopAnswer({ rests: false, reason }, { channels: [], period: null }) : null;
  }

  // What a figure shows of linear answers: those of now, and pale ones of the last step and of held settings.
  linearOf(name) {
    const { loops, plates, linear_marks: all } = this.data;
    const links = all.filter(({ figure, loop }) => figure === name && isAsked(loops[loop], this.state));
    const now = { answers: new Map(links.map(({ loop }) => [loop, this.answerOf(loop)])), kind: "now", label: "" };
    return linearDrawing(links, plates[name], links.length ? [now, ...this.holds.answers] : []);
  }

  // The bars and points of a figure that have a score of a run.
  marksOf(name) {
    return this.data.marks.flatMap(({ figure, panel, series, index, axis, loop, metric, number, scale }) => {
      const scores = figure === name && this.views.get(loop)?.scores?.[metric];
      return scores ? [{ panel, series, index, axis, value: scale * scores[number][0] }] : [];
    });
  }

  // What the bench says: the first number of each loop, how long it took, and which runs have diverged.
  report() {
    const { bench, data, wanted } = this, places = this.asked(this.state).filter((place) => !data.loops[place].everywhere);
    const first = places.map((place) => data.loops[place].metrics[0]).find(Boolean);
    const sensors = places.some((place) => data.loops[place].sensors);
    const lines = [...places.flatMap((place) => this.linesOf(place)), ...(places.length === 1 ? this.linearLines(places[0]) : [])];
    bench.report(first ? headOfMetric(first, sensors) : "", lines, this.holds.names);
    document.documentElement.classList.toggle("live-late", Boolean(this.flight?.whole.size));
    if (this.flight?.fine.size) return bench.tell(this.runningText());
    if (!wanted.size) return bench.tell(this.idleText());
    const noun = sensors ? "run" : "loop", loops = wanted.size === 1 ? `One ${noun}` : `${wanted.size} ${noun}s`;
    bench.tell(`${loops} computed here in ${shortNumber(this.spent, 2)}\u00a0s.`);
    const spoken = [...wanted.keys()].filter((place) => !data.loops[place].everywhere).flatMap((place) => this.linesOf(place)).map(({ spoken }) => spoken);
    const more = spoken.length > MOST_SPOKEN ? [`And ${spoken.length - MOST_SPOKEN} more in the bench.`] : [];
    bench.say([...spoken.slice(0, MOST_SPOKEN), ...more].join(" "));
  }

  // What is shown while loops run: a coarse picture, or the exact one, whose errors are on their way.
  runningText() {
    const { flight, views, data } = this, waited = [...flight.whole].filter((place) => views.get(place)?.phase === "coarse");
    if (!flight.whole.size) return "Exact pictures. Their errors are running \u2026";
    if (!waited.length) return "Running \u2026";
    const times = Math.max(...waited.map((place) => views.get(place).h / data.loops[place].whole.h));
    const some = waited.length === 1 ? "Coarse picture" : `${waited.length} coarse pictures`;
    return `${some}, of steps up to ${shortNumber(times, 2)} times as long. The exact ones are running \u2026`;
  }

  idleText() {
    const turned = addressOfState({ ...this.state, scenario: this.printed.scenario, off: new Set() }, this.data);
    return turned ? "At the baseline: what is turned is in no loop that runs here." : AT_BASELINE;
  }

  // The lines of a loop: its first number; of a fitted model that of each sensor.
  linesOf(place) {
    const { sensors } = this.data.loops[place];
    return sensors ? sensors.map((sensor, i) => this.line(place, i, sensor)) : [this.line(place)];
  }

  // A number of a loop now, nothing while it is at the baseline, those of the held settings, and the baseline.
  line(place, number = 0, label = this.data.loops[place].label) {
    const { scenario, scores, metrics } = this.data.loops[place], view = this.views.get(place) || {};
    const [metric] = metrics, value = metric ? Number(scores[0][number][0]) : NaN;
    const baseline = Number.isNaN(value) ? "\u2014" : evenNumber(value);
    const late = this.flight?.whole.has(place), line = { scenario, label, baseline, now: "", spoken: "" };
    Object.assign(line, { rough: late || view.phase !== "half", held: this.holds.numbers(place, baseline, number) });
    if (typeof view.divergedAt === "number") {
      line.now = `diverged at ${shortNumber(view.divergedAt, 3)}\u00a0s`;
      line.spoken = `${label} ${line.now}.`;
    } else if (view.scores && view.scores[0]) {
      line.now = evenNumber(view.scores[0][number][0]);
      line.spoken = `${label}: ${metric.name} ${withUnit(line.now, unitOfMetric(metric, number))} (baseline ${baseline}).`;
    } else if (late) line.now = "\u2026";
    return line;
  }

  // The numbers of the linear answers of a loop, as its table has them, below a sentence on the point.
  linearLines(place) {
    const { cells, loops } = this.data, about = loops[place].linear, several = about && about.channels.length > 1;
    const mine = about ? cells.filter((cell) => cell.quantity && cell.loop === place) : [];
    const wanted = this.wanted.get(place), { key, answer } = this.answers.get(place) ?? {};
    return mine.map((cell) => {
      const { quantity, label, unit, printed } = cell, baseline = typeof printed === "number" ? evenNumber(printed) : cell.words;
      const at = several && label ? ` at ${label}` : "", named = withUnit(`${quantity}${at}`, unit === "1" ? "" : `[${unit}]`);
      const now = !wanted ? "" : answer ? linearText(answer.value(cell)) : "\u2026";
      const held = this.holds.linearNumbers(place, cell, baseline), rough = key !== wanted?.key;
      return { scenario: about.said, label: named, now, held, baseline, rough, linear: true };
    });
  }
}

// A metric of which the first number is shown, with its label and unit.
function headOfMetric(metric, sensors) {
  const { name, labels } = metric, label = labels && labels.length > 1 ? `, ${labels[0]}` : "";
  return sensors ? name : `${name}${label} [${unitOfMetric(metric)}]`;
}

function unitOfMetric({ unit, units }, number = 0) {
  return (units || [])[number] || unit || "1";
}

// A page without data has no bench.
function openLivePage() {
  const data = document.getElementById("live"), worker = document.getElementById("live-worker");
  return data && worker ? new LivePage(data.textContent, worker.textContent) : null;
}

const livePage = openLivePage();
