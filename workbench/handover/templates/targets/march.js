"use strict";
const fs = require("fs");
const sizes = JSON.parse(fs.readFileSync("sizes.json", "utf8"));
const rooms = { runs: 1, constants: sizes.constants, p: sizes.p, scratch: sizes.lanes, table: sizes.table,
                x: sizes.states, out: sizes.states };
const at = {};
let end = 1024;
for (const [name, size] of Object.entries(rooms)) {
  at[name] = end;
  end += Math.ceil(8 * size / 64) * 64;
}
const memory = new WebAssembly.Memory({ initial: Math.floor(end / 65536) + 1 });
const code = new WebAssembly.Module(fs.readFileSync("law.wasm"));
const march = new WebAssembly.Instance(code, { env: { __linear_memory: memory } }).exports;
const view = (name) => new Float64Array(memory.buffer, at[name], rooms[name]);
const doubles = (bytes) => new Float64Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 8);
const numbers = doubles(Buffer.from(new Uint8Array(fs.readFileSync("numbers")).buffer));
let past = 0;
for (const name of ["constants", "p", "x"]) {
  view(name).set(numbers.subarray(past, past + rooms[name]));
  past += rooms[name];
}
const p = view("p"), x = view("x"), width = sizes.inputs;
const arrays = ["runs", "constants", "p", "scratch", "table", "x", "out"].map((name) => at[name]);
const inputs = fs.openSync("inputs", "r"), answers = fs.openSync("answers", "w");
const rows = new Float64Array(sizes.block * width), made = new Float64Array(sizes.block * sizes.states);
for (let first = 0; first < sizes.periods; first += sizes.block) {
  const count = Math.min(sizes.block, sizes.periods - first);
  const bytes = new Uint8Array(rows.buffer, 0, 8 * count * width);
  if (fs.readSync(inputs, bytes, 0, bytes.length) !== bytes.length) process.exit(3);
  for (let i = 0; i < count; i++) {
    for (const [place, column] of sizes.varied) p[place] = rows[i * width + column];
    const k = BigInt(first + i);
    if (sizes.table > 0) march.workbench_table(1n, k, at.constants, at.p, at.table);
    march.workbench_piece(1n, 1n, 1n, k, 0n, 1n, 0n, ...arrays);
    made.set(x, i * sizes.states);
  }
  const written = new Uint8Array(made.buffer, 0, 8 * count * sizes.states);
  if (fs.writeSync(answers, written) !== written.length) process.exit(4);
}
