// What a measurement asks of a live page: turns of a knob until all is drawn, and a march by its kernel alone.

const rest = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

// Open the bench of a report; that of a single loop opens by itself.
async function openBench() {
  if (!document.body.classList.contains("bench-page")) document.querySelector(".bench-handle").click();
  while (!livePage.pool) await rest(10);
}

// Whether all exact runs are there, and whatever of them is in sight is drawn.
const isDrawn = () => livePage.flight && !livePage.flight.whole.size && !livePage.late.size;

// The time when the page has drawn a turn, and when the browser has painted it.
const drawing = () => new Promise((done) => {
  livePage.draw = function () {
    Object.getPrototypeOf(livePage).draw.call(livePage);
    if (!isDrawn()) return;
    delete livePage.draw;
    const { drawn } = livePage;
    requestAnimationFrame(() => setTimeout(() => done({ drawn, painted: performance.now() })));
  };
});

// The ms from each of some turns, spread over a range, to the moment when everything that shows is drawn exactly; the ms
// until it is painted, too, are in `painted`.
let painted = [];
async function turned(name, low, high, turns) {
  const knob = livePage.bench.knobs[livePage.data.knobs.findIndex((one) => one.name === name)], spans = [];
  painted = [];
  for (let i = 0; i < turns; i++) {
    const drawn = drawing(), began = performance.now();
    knob.turn(low * (high / low) ** ((0.11 + 0.618034 * i) % 1));
    const times = await drawn;
    spans.push(times.drawn - began);
    painted.push(times.painted - began);
    while (livePage.flight?.fine.size) await rest(5);
    await rest(30);
  }
  return spans;
}

// The kernel of a loop in this thread, at the step of its values; then the ms of one run by it.
let marched;
async function prepared(place) {
  const { Kernel, Run } = new Function(`${document.getElementById("live-worker").textContent}; return {Kernel, Run};`)();
  const loop = livePage.data.loops[place], module = await livePage.pool.module(loop.whole.module);
  const kernel = new Kernel(module, loop.whole, 2000), p = Float64Array.from(loop.p), x = Float64Array.from(loop.x0);
  marched = () => {
    const began = performance.now(), run = new Run(loop, kernel, loop.whole, null, { p, x, seed: loop.seed });
    while (!run.done) run.advance();
    return performance.now() - began;
  };
  return true;
}

// The ms from each of some turns of the limit Ms of a specification, or of its law, to the moment when all pictures of the loop with
// the new gains are drawn exactly.
async function specified(low, high, turns, count) {
  const [one] = livePage.specifications, spans = [];
  one.target.count = count;
  for (let i = 0; i < turns; i++) {
    const before = livePage.state.values.join(), drawn = new Promise((done) => {
      livePage.draw = function () {
        Object.getPrototypeOf(livePage).draw.call(livePage);
        if (!isDrawn() || !one.met) return;
        delete livePage.draw;
        done(livePage.drawn);
      };
    });
    const began = performance.now();
    one.met = null;
    one.limits[0].turn(low + (high - low) * ((0.11 + 0.618034 * i) % 1));
    spans.push((await drawn) - began);
    if (livePage.state.values.join() === before) throw new Error("no knob has moved");
    while (livePage.flight?.fine.size) await rest(5);
    await rest(30);
  }
  return spans;
}
