"use strict";

// The worker: it marches loops in slices of a few milliseconds, and between two slices it listens. The newest request
// wins: whatever an older one asked for ends there.

const STEPS_AT_ONCE = 2000; // share a table of what depends on time alone, as in the engine
const ROWS_OF_A_LOOK = 64; // in the search for the first step that is not finite, as in the engine
const CALL = 4; // ms that one call of a kernel shall take
const SLICE = 12; // ms between two looks for a newer request
const DRAWING = 60; // ms in which the page draws exact runs, before their errors are computed beside it
const GROWTH = 60; // ms between two views of a run that is under way
const COARSE = 60; // ms that the coarse pictures of all loops of this worker shall take together
const SLOWER = 1.25; // how much slower a call may make the pace, as a call that had to wait says nothing of it
const TRIES = 3; // lengths of the step that a coarse picture may try, however long they take
const WARM = 4; // linear answers after which a browser has compiled their code
const TRIAL = 200; // steps by which the pace of a kernel is measured before its first run

// The march of one module, at most so many steps at once, of its own or of other lengths: a memory with all its arrays,
// and the two functions that work on them.
class Kernel {
  constructor(module, march, steps, lengths = [], record = null) {
    Object.assign(this, { march, record });
    const least = Math.min(march.stride, ...lengths.map(({ stride }) => stride)); // steps in a row
    const places = this.places(steps, Math.max(1, Math.floor(steps / least)));
    const memory = new WebAssembly.Memory({ initial: Math.ceil(places.end / 65536) });
    const array = (name, size) => new Float64Array(memory.buffer, places[name], size);
    const { workbench_piece, workbench_table } = new WebAssembly.Instance(module, {
      env: { __linear_memory: memory },
    }).exports;
    this.piece = workbench_piece;
    this.table = march.table ? workbench_table : null;
    this.at = ["runs", "constants", "p", "scratch", "table", "x", "out"].map((name) => places[name]);
    this.recordedAt = places.record;
    if (record) array("record", record.length).set(record);
    this.constants = array("constants", march.constants.length); // and the key of the run is 0
    this.take(march);
    this.p = array("p", march.parameters.length);
    this.x = array("x", march.states);
    this.out = new Float64Array(memory.buffer, places.out);
    this.pace = 0.01; // ms a step, which is measured as it runs
  }

  // Where each array begins: at a multiple of 64 bytes, as the widest loads ask for.
  places(steps, rows) {
    const { constants, parameters, lanes, table, states } = this.march;
    const sizes = {
      runs: 1, constants: constants.length, p: parameters.length, scratch: lanes, table: steps * table,
      x: states, out: rows * states, record: this.record ? this.record.length : 0,
    };
    const places = { end: 64 };
    for (const [name, size] of Object.entries(sizes)) {
      places[name] = places.end;
      places.end += Math.ceil((8 * size) / 64) * 64;
    }
    return places;
  }

  // The numbers of a length of the step.
  take(length) {
    if (length !== this.length) this.constants.set(length.constants);
    this.length = length;
  }

  // How long a step takes, by some of them, in ms.
  measure(p, x) {
    this.load(p, "0");
    for (let round = 0; round < 3; round++) { // the first of which warms up
      this.x.set(x);
      const started = performance.now();
      let steps = 0, passed = 0;
      for (; passed < 1 && steps < 50 * TRIAL; passed = performance.now() - started) { // as its clock is coarse
        this.advance(1, TRIAL, 0);
        steps += TRIAL;
      }
      this.pace = Math.max(1e-5, Math.min(this.pace, passed / steps));
    }
  }

  // All parameters of the loop, and the seed of its noise.
  load(p, seed) {
    this.march.parameters.forEach((place, i) => (this.p[i] = p[place]));
    this.seed = BigInt.asIntN(64, BigInt(seed));
  }

  // March `rows` times `steps` steps from step `begin` on; the rows stand in `out`, the last one in `x`.
  advance(rows, steps, begin) {
    const [, constants, p, , table] = this.at, first = BigInt(begin), count = BigInt(rows);
    if (this.table) this.table(BigInt(rows * steps), first, constants, p, table);
    const recorded = this.record ? [this.recordedAt + 8 * begin * this.march.recorded] : []; // numbers of a step
    this.piece(1n, count, BigInt(steps), first, 0n, count, this.seed, ...this.at, ...recorded);
  }

  // March `span` steps, however many, from step `begin` on.
  walk(begin, span) {
    for (let done = 0; done < span; done += STEPS_AT_ONCE) {
      this.advance(1, Math.min(STEPS_AT_ONCE, span - done), begin + done);
    }
  }
}

function allFinite(numbers, from, to) {
  for (let i = from; i < to; i++) if (!Number.isFinite(numbers[i])) return false;
  return true;
}

// The steps behind `begin` after which a state is not finite any more; it is finite in `state`, and not `span` later.
function firstLoss(kernel, state, begin, span) {
  const stride = Math.ceil(span / ROWS_OF_A_LOOK), rows = Math.floor(span / stride);
  let before = state, bad = 1;
  kernel.x.set(state);
  for (; bad <= rows; bad++) {
    kernel.walk(begin + (bad - 1) * stride, stride);
    if (!allFinite(kernel.x, 0, kernel.x.length)) break;
    before = kernel.x.slice();
  }
  if (stride === 1) return bad;
  const passed = (bad - 1) * stride;
  return passed + firstLoss(kernel, before, begin + passed, Math.min(stride, span - passed));
}

// A run of a loop at a length of the step: the rows that are done, filled call by call.
class Run {
  constructor(loop, kernel, length, outputs, { p, x: x0, seed }) {
    const { states } = kernel.march;
    Object.assign(this, { loop, kernel, length, outputs, p, seed, states, rows: 0, spent: 0, divergedAt: null });
    this.x = new Float64Array((loop.rows + 1) * states).fill(NaN);
    this.x.set(x0);
    this.last = Float64Array.from(x0);
    this.within = 0; // steps behind the last row that are done
    this.seen = 0; // rows whose outputs are known
    this.watched = outputs ? outputs.march.states - states : 0; // behind the states
    this.y = outputs ? new Float64Array((loop.rows + 1) * this.watched).fill(NaN) : null;
  }

  get done() {
    return this.rows === this.loop.rows || this.divergedAt !== null;
  }

  // One call of the kernel: some rows, or a part of one.
  advance() {
    const { kernel, states, length } = this, { stride, h } = length, started = performance.now();
    const most = Math.max(1, Math.min(STEPS_AT_ONCE, Math.floor(CALL / kernel.pace)));
    const whole = stride <= most && this.within === 0;
    const rows = whole ? Math.min(Math.floor(most / stride), this.loop.rows - this.rows) : 1;
    const steps = whole ? stride : Math.min(most, stride - this.within);
    kernel.take(length);
    kernel.load(this.p, this.seed);
    kernel.x.set(this.last);
    kernel.advance(rows, steps, this.rows * stride + this.within);
    this.last.set(kernel.x);
    this.within += steps;
    if (this.within >= stride) {
      this.within = 0;
      this.keep(rows, stride, h);
    }
    const passed = performance.now() - started;
    this.spent += passed;
    if (rows * steps >= 50) kernel.pace = Math.max(1e-5, Math.min(passed / (rows * steps), SLOWER * kernel.pace));
  }

  // Keep the rows before the first that is not finite, and find the step that lost it.
  keep(rows, stride, h) {
    const { kernel, states, x } = this;
    for (let row = 0; row < rows; row++, this.rows++) {
      if (!allFinite(kernel.out, row * states, (row + 1) * states)) {
        const begin = this.rows * stride, state = x.slice(this.rows * states, (this.rows + 1) * states);
        const isCoarse = this.length !== kernel.march; // of which nobody asks at which step
        const step = begin + (isCoarse ? 0 : firstLoss(kernel, state, begin, stride)), { times } = this.loop;
        this.divergedAt = times ? times[Math.ceil(step / stride)] : step * h; // those of a log may be uneven
        return;
      }
      x.set(kernel.out.subarray(row * states, (row + 1) * states), (this.rows + 1) * states);
    }
  }

  // The outputs of the rows that are done, for at most `limit` ms; true if none is left.
  observe(limit) {
    const { outputs, states, watched, x, y } = this, stride = this.loop.whole.stride; // they count the loop's own steps
    if (!outputs) return true;
    const started = performance.now(), nx = outputs.march.states - watched;
    outputs.load(this.p, this.seed);
    for (; this.seen <= this.rows; this.seen++) {
      outputs.x.set(x.subarray(this.seen * states, this.seen * states + nx));
      outputs.x.fill(0, nx);
      outputs.advance(1, 1, this.seen * stride);
      y.set(outputs.x.subarray(nx), this.seen * watched);
      if (this.seen % 64 === 63 && performance.now() - started > limit) {
        this.seen += 1;
        this.spent += performance.now() - started;
        return this.seen > this.rows;
      }
    }
    this.spent += performance.now() - started;
    return true;
  }

  // The states at the horizon and one step later, from which metrics follow; none of a run that has diverged.
  ends() {
    if (this.divergedAt !== null) return null;
    const x = this.last.slice();
    this.kernel.take(this.length);
    this.kernel.load(this.p, this.seed);
    this.kernel.x.set(x);
    this.kernel.advance(1, 1, this.rows * this.length.stride);
    return { x, z: this.kernel.x.slice() };
  }
}

const loops = new Map(); // by their places in the page: the loop and its kernels
let newest = 0; // the ticket of the newest request

// Lets messages in: what has come meanwhile is heard before this goes on.
const channel = new MessageChannel();
let wake = null;
channel.port1.onmessage = () => wake();
function pause() {
  return new Promise((resolve) => {
    wake = resolve;
    channel.port2.postMessage(0);
  });
}

function take({ place, loop, modules, records }) {
  const kernels = {};
  for (const name of ["whole", "half", "outputs"]) {
    const march = loop[name], steps = name === "outputs" ? 1 : STEPS_AT_ONCE;
    const lengths = name === "whole" ? loop.coarse : [];
    if (march) kernels[name] = new Kernel(modules[march.module], march, steps, lengths, records?.[march.record] ?? null);
  }
  if (loop.coarse.length) kernels.whole.measure(loop.p, loop.x0);
  const linear = loop.linear ? new LinearAnswers(loop.linear, modules) : null;
  for (let round = 0; linear && round < WARM; round++) linear.answer(Float64Array.from(loop.p), Float64Array.from(loop.x0));
  loops.set(place, { loop, kernels, linear });
}

// The linear answer of a run, where its loop has one, before its march.
function answerLinear(ticket, { loop: place, printed, p, x }) {
  const { linear } = loops.get(place);
  if (!linear) return;
  const began = performance.now(), answer = linear.answer(p, x);
  postMessage({ ticket, loop: place, printed, phase: "linear", linear: answer, milliseconds: performance.now() - began });
}

// What the page is told: of a run under way copies, of a run that is done the arrays themselves.
function tell(ticket, { loop: place, printed }, phase, run) {
  const { rows, spent, divergedAt, done, length: { h } } = run;
  const x = done ? run.x : run.x.slice(), y = run.y && !done ? run.y.slice() : run.y;
  const ends = done ? run.ends() : null;
  const view = { ticket, loop: place, printed, phase, h, rows, x, y, ends, divergedAt, done, milliseconds: spent };
  postMessage(view, y ? [x.buffer, y.buffer] : [x.buffer]);
}

// The length of the step for the coarse picture of a loop, if all of them are to be so many times as fast, and the next
// ones that are finer.
function coarseLengths({ whole, coarse }, times) {
  const first = coarse.findIndex(({ h }) => h >= times * whole.h);
  return coarse.slice(0, first < 0 ? coarse.length : first + 1).reverse();
}

// How many ms the run of a loop takes at a length of its step.
function timeOf(place, length) {
  const { loop, kernels } = loops.get(place);
  return loop.rows * length.stride * kernels.whole.pace;
}

// A coarse picture of each run that has one, of steps as long as the time allows; where one diverges, of shorter ones.
// Gives the runs that have been drawn so, or null if a newer request has come.
async function sketch(ticket, runs) {
  const drawn = new Set(), asked = runs.filter((run) => !run.printed);
  const whole = asked.reduce((sum, run) => sum + timeOf(run.loop, loops.get(run.loop).loop.whole), 0);
  if (whole <= COARSE) return drawn;
  for (const run of asked) {
    const lengths = coarseLengths(loops.get(run.loop).loop, whole / COARSE), limit = 2 * COARSE / asked.length;
    for (const [i, length] of lengths.entries()) {
      if (i >= TRIES && timeOf(run.loop, length) > limit) break;
      const isDrawn = await march(ticket, "coarse", run, length);
      if (ticket !== newest) return null;
      if (!isDrawn) continue;
      drawn.add(run);
      break;
    }
  }
  return drawn;
}

// One run, slice by slice; false if a newer request has come, or a coarse one has diverged. It is told while it grows,
// unless a coarse picture stands there.
async function march(ticket, phase, asked, length = null, grows = true) {
  const { loop, kernels } = loops.get(asked.loop), coarse = phase === "coarse";
  const outputs = phase === "half" ? null : kernels.outputs; // half of the step is for errors alone
  const kernel = kernels[coarse ? "whole" : phase], run = new Run(loop, kernel, length ?? kernel.march, outputs, asked);
  let told = performance.now(), started = told;
  while (!run.done) {
    run.advance();
    if (performance.now() - started < SLICE - CALL) continue;
    if (phase === "whole" && grows && !run.done && performance.now() - told > GROWTH && run.observe(CALL)) {
      tell(ticket, asked, phase, run);
      told = performance.now();
    }
    await pause();
    if (ticket !== newest) return false;
    started = performance.now();
  }
  if (coarse && run.divergedAt !== null) return false;
  while (!run.observe(SLICE - CALL)) {
    await pause();
    if (ticket !== newest) return false;
  }
  tell(ticket, asked, phase, run);
  return true;
}

// All loops of a request: coarse pictures, where the exact ones take long; then at their step, which gives curves and
// values; then at half of it, which gives errors.
async function serve({ ticket, runs }) {
  newest = ticket;
  await pause();
  if (ticket !== newest) return;
  for (const run of runs) {
    answerLinear(ticket, run);
    await pause();
    if (ticket !== newest) return;
  }
  const drawn = await sketch(ticket, runs);
  if (!drawn) return;
  for (const phase of ["whole", "half"]) {
    if (phase === "half") await new Promise((resolve) => setTimeout(resolve, DRAWING));
    for (const run of runs) {
      if (run.printed && phase === "half") continue; // whose errors nobody asks for
      if (ticket !== newest || !(await march(ticket, phase, run, null, !drawn.has(run)))) return;
    }
  }
}

// A question of the page about the linear answers of a loop, which no request ends.
function reply({ question, place, ...asked }) {
  postMessage({ question, reply: replyTo(loops.get(place).linear, asked) });
}

onmessage = ({ data }) => {
  if (data.loop) return take(data);
  if (data.question) return reply(data);
  return serve(data).catch((error) => postMessage({ ticket: data.ticket, fault: String(error) }));
};
