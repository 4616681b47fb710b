"use strict";

// The address: what a reader has turned, in the fragment of the page's address, as
//
//     #knobs=phi:0.1,K:20&seed=3&scenario=FS&off=PID,SMC
//
// It is data of a stranger: names are looked up, numbers clipped to their ranges, and all else is passed over.

const LONGEST_ADDRESS = 10000; // characters
const A_NUMBER = /^[+-]?(\d{1,30}(\.\d{0,30})?|\.\d{1,30})(e[+-]?\d{1,4})?$/i;
const A_SEED = /^\d{1,40}$/;
const LARGEST_SEED = 2n ** 64n - 1n;

// What a page shows as printed: the numbers of its knobs, its seed, its first scenario, and all laws.
function printedState(data) {
  const loops = data.loops.filter((loop) => loop && !loop.everywhere), noisy = loops.find((loop) => loop.normals > 0);
  return {
    values: data.knobs.map((knob) => knob.value),
    seed: noisy ? noisy.seed : "0",
    scenario: data.scenario || (loops.length ? loops[0].scenario : ""),
    off: new Set(),
  };
}

function copiedState({ values, seed, scenario, off }) {
  return { values: [...values], seed, scenario, off: new Set(off) };
}

// True for a fragment that speaks of knobs; others name a place of the page.
function isStateAddress(fragment) {
  return fragment.length <= LONGEST_ADDRESS && /^#?(knobs|seed|scenario|off)=/.test(fragment);
}

// A name out of an address, or nothing where it is badly written.
function decodedName(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return null;
  }
}

// The number that a text writes, within the range of a knob, or the nearest of its stops; null for what is no number.
function clippedNumber(text, { low, high, stops }) {
  if (!A_NUMBER.test(text)) return null;
  return stops ? stops[nearestStop(stops, Number(text))] : Math.min(high, Math.max(low, Number(text)));
}

// The state that a fragment tells of, on the ground of the printed one.
function stateOfAddress(fragment, data) {
  const state = printedState(data);
  if (!isStateAddress(fragment)) return state;
  const parts = new Map();
  for (const part of fragment.replace(/^#/, "").split("&")) {
    const middle = part.indexOf("=");
    if (middle > 0) parts.set(part.slice(0, middle), part.slice(middle + 1));
  }
  for (const item of (parts.get("knobs") || "").split(",")) {
    const middle = item.lastIndexOf(":"), name = decodedName(item.slice(0, Math.max(0, middle)));
    const place = data.knobs.findIndex((knob) => knob.name === name);
    const value = place < 0 ? null : clippedNumber(item.slice(middle + 1), data.knobs[place]);
    if (value !== null) state.values[place] = value;
  }
  state.seed = seedOfText(parts.get("seed") || "", state.seed);
  const scenario = decodedName(parts.get("scenario") || ""), loops = data.loops.filter(Boolean);
  const isScenario = loops.some((loop) => !loop.everywhere && loop.scenario === scenario);
  if (scenario === EVERY || isScenario) state.scenario = scenario;
  for (const law of (parts.get("off") || "").split(",").map(decodedName)) {
    if (loops.some((loop) => loop.law === law)) state.off.add(law);
  }
  return state;
}

// A seed as a text of digits, within 64 bits; the other one where a text is none.
function seedOfText(text, other) {
  if (!A_SEED.test(text)) return other;
  const seed = BigInt(text);
  return String(seed > LARGEST_SEED ? LARGEST_SEED : seed);
}

// The fragment of a state: what differs from the printed one, and nothing where nothing does.
function addressOfState(state, data) {
  const printed = printedState(data), parts = [];
  const turned = data.knobs.flatMap((knob, i) =>
    Object.is(state.values[i], printed.values[i]) ? [] : [`${encodeURIComponent(knob.name)}:${state.values[i]}`]);
  if (turned.length) parts.push(`knobs=${turned.join(",")}`);
  if (state.seed !== printed.seed) parts.push(`seed=${state.seed}`);
  if (state.scenario !== printed.scenario) parts.push(`scenario=${encodeURIComponent(state.scenario)}`);
  if (state.off.size) parts.push(`off=${[...state.off].map(encodeURIComponent).join(",")}`);
  return parts.length ? `#${parts.join("&")}` : "";
}

// Write a fragment into the page's address, without a new entry of the history; a page that may not keeps its own. The
// address is written in full, as in the frame of a notebook a short one would lead out of the page.
function writeAddress(fragment) {
  if (fragment === location.hash || (!fragment && !isStateAddress(location.hash))) return;
  try {
    history.replaceState(null, "", location.href.split("#")[0] + fragment);
  } catch {
    // then no link can be copied from the address; the bench has one
  }
}
