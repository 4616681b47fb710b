// What a measurement asks of a live page: turns of a knob until all is drawn, and a march by its kernel alone.

// Wait without a timer, whose clock is coarse.
const until = (holds) => new Promise((done) => {
  const channel = new MessageChannel();
  const look = () => (holds() ? done() : channel.port2.postMessage(0));
  channel.port1.onmessage = look;
  look();
});

// The ms from each of some turns, spread over a range, to the frame in which everything that shows is drawn exactly.
async function turned(name, low, high, turns) {
  const knob = livePage.bench.knobs[livePage.data.knobs.findIndex((one) => one.name === name)], spans = [];
  for (let i = 0; i < turns; i++) {
    const began = performance.now();
    knob.turn(low * (high / low) ** ((0.11 + 0.618034 * i) % 1));
    await until(() => livePage.flight && !livePage.flight.whole.size && !livePage.late.size && livePage.drawn > began);
    spans.push(livePage.drawn - began);
    await until(() => !livePage.flight || !livePage.flight.fine.size);
    await new Promise((done) => setTimeout(done, 30));
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
