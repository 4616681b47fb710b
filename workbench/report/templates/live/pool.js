"use strict";

// The pool: workers that march the loops of a page, each the loops that are its own.

// The bytes behind a text of the page.
async function unpackedModule(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Response(stream).arrayBuffer();
}

// The workers, and which of them runs which loop; each module is compiled once.
class Pool {
  constructor(data, source, hear, fail) {
    Object.assign(this, { data, modules: new Map(), records: new Map(), held: new Map(), ticket: 0, questions: new Map(), asked: 0 });
    const place = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    const count = Math.max(1, Math.min(4, navigator.hardwareConcurrency || 1, data.loops.length));
    this.workers = Array.from({ length: count }, () => new Worker(place));
    for (const worker of this.workers) {
      worker.onmessage = ({ data: told }) => {
        if (told.fault) return fail(told.fault);
        return told.question ? this.take(told) : hear(told);
      };
      worker.onerror = (event) => fail(event.message || "a worker could not start");
    }
    this.owners = this.shared(count);
  }

  // The work of each scenario in equal shares: the heaviest loop first, always to the least busy.
  shared(count) {
    const owners = new Map(), { loops } = this.data;
    for (const scenario of new Set(loops.filter(Boolean).map((loop) => loop.scenario))) {
      const busy = new Array(count).fill(0);
      const mine = [...loops.keys()].filter((i) => loops[i] && loops[i].scenario === scenario);
      for (const i of mine.sort((a, b) => this.weight(b) - this.weight(a))) {
        const least = busy.indexOf(Math.min(...busy));
        owners.set(i, least);
        busy[least] += this.weight(i);
      }
    }
    return owners;
  }

  // About how long a loop takes: its steps, by the length of their code.
  weight(place) {
    const { rows, whole } = this.data.loops[place];
    return rows * whole.stride * this.data.modules[whole.module].length;
  }

  module(place) {
    if (!this.modules.has(place)) {
      this.modules.set(place, unpackedModule(this.data.modules[place]).then((bytes) => WebAssembly.compile(bytes)));
    }
    return this.modules.get(place);
  }

  // The recorded numbers of the steps of a march.
  record(place) {
    if (!this.records.has(place)) {
      this.records.set(place, unpackedModule(this.data.records[place]).then((bytes) => new Float64Array(bytes)));
    }
    return this.records.get(place);
  }

  // Hand a loop to its worker, once.
  prepare(place) {
    if (!this.held.has(place)) this.held.set(place, this.hand(place));
    return this.held.get(place);
  }

  async hand(place) {
    const { p, x0, rows, times = null, whole, half, outputs, coarse = [], linear = null } = this.data.loops[place], modules = {};
    const marches = [whole, half, outputs, ...(linear ? [linear.values, linear.jump, linear.flow] : [])].filter(Boolean);
    const records = {};
    for (const { module, record } of marches) {
      modules[module] = await this.module(module);
      if (record !== undefined) records[record] = await this.record(record);
    }
    const loop = { p, x0, rows, times, whole, half, outputs, coarse, linear };
    this.workers[this.owners.get(place)].postMessage({ place, loop, modules, records });
  }

  // The reply of a loop's worker to a question about its linear answers.
  async ask(place, question) {
    await this.prepare(place);
    const number = (this.asked += 1);
    this.workers[this.owners.get(place)].postMessage({ ...question, place, question: number });
    return new Promise((resolve) => this.questions.set(number, resolve));
  }

  take({ question, reply }) {
    this.questions.get(question)(reply);
    this.questions.delete(question);
  }

  // Ask for runs, those in sight first, then the light ones; what was asked before ends. All answers have the ticket.
  async request(runs, seen) {
    const ticket = (this.ticket += 1);
    await Promise.all(runs.map((run) => this.prepare(run.loop)));
    if (ticket !== this.ticket) return;
    const hidden = (run) => Number(!seen.has(run.loop));
    const order = [...runs].sort((a, b) => hidden(a) - hidden(b) || this.weight(a.loop) - this.weight(b.loop));
    this.workers.forEach((worker, i) => {
      worker.postMessage({ ticket, runs: order.filter((run) => this.owners.get(run.loop) === i) });
    });
  }

  end() {
    this.workers.forEach((worker) => worker.terminate());
  }
}
