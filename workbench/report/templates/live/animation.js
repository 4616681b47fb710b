"use strict";
// The animation of a plant: its drawing at a time of the live run, and behind it, pale, the printed one.

const ANIMATION = {
  svg: "http://www.w3.org/2000/svg", wide: 640, least: 220, most: 440, margin: 26,
  thinnest: 1.5, stops: 500, longest: 10, track: 400, recent: 1 / 3, far: 10, steps: 20,
};

// The extent of shapes in rows of a run: [xlow, ylow, xhigh, yhigh]; the ground, which goes on, does not count.
function extentOf(drawing, run, first, last) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  const end = Math.min(last, run.rows), stride = Math.max(1, Math.floor((end - first) / 500));
  for (const shape of drawing.shapes) {
    if (shape.tone === "ground") continue;
    for (let row = first; row < end; row += shape.fixed ? run.rows : stride) {
      const at = coordinatesOf(shape, run, row);
      const round = shape.kind === "circle" ? at[2] : (shape.width || 0) / 2;
      for (let i = 0; i + 1 < at.length; i += shape.kind === "line" ? 2 : at.length) {
        if (!Number.isFinite(at[i]) || !Number.isFinite(at[i + 1])) continue;
        box[0] = Math.min(box[0], at[i] - round);
        box[1] = Math.min(box[1], at[i + 1] - round);
        box[2] = Math.max(box[2], at[i] + round);
        box[3] = Math.max(box[3], at[i + 1] + round);
      }
    }
  }
  return box;
}

// The numbers of a shape in a row: fixed ones, or those of its places.
function coordinatesOf(shape, run, row) {
  if (shape.fixed) return shape.fixed;
  return shape.points.map((place) => run.frames[row * run.places + place]);
}

// Frames as a run: rows of so many places each, of which the first `finite` ones have no number that is not finite.
function runOf(frames, places) {
  const rows = places ? frames.length / places : 1;
  let finite = 0;
  const whole = (row) => {
    for (let i = row * places; i < (row + 1) * places; i++) if (!Number.isFinite(frames[i])) return false;
    return true;
  };
  while (finite < rows && whole(finite)) finite++;
  return { frames, places, rows, finite };
}

// The last row at or before a time.
function rowAt(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t + 1e-12 * Math.abs(t)) low = middle;
    else high = middle - 1;
  }
  return low;
}

// The window on the plane: of an extent, with a margin, at a scale of points to the metre. One that is far wider than
// the plant itself stays as large as the plant and follows it.
function windowOf(drawing, run, printed) {
  const given = drawing.view;
  const one = extentOf(drawing, run, 0, 1);
  const size = Math.max(one[2] - one[0], one[3] - one[1], 1e-9);
  if (printed) printed.extent ||= extentOf(drawing, printed, 0, Math.max(1, printed.finite));
  let box = given || (printed ? printed.extent : extentOf(drawing, run, 0, Math.max(1, run.finite)));
  if (!given && printed) {
    const live = extentOf(drawing, run, 0, Math.max(1, run.finite));
    box = [Math.min(box[0], live[0]), Math.min(box[1], live[1]), Math.max(box[2], live[2]), Math.max(box[3], live[3])];
  }
  let [width, height] = [box[2] - box[0], box[3] - box[1]];
  const far = !(Math.max(width, height) < ANIMATION.far * size);
  const follow = drawing.follow || far;
  if (far) [width, height] = [2.5 * size, 2 * size];
  const inner = ANIMATION.wide - 2 * ANIMATION.margin;
  const tall = Math.min(ANIMATION.most, Math.max(ANIMATION.least, 2 * ANIMATION.margin + (inner * height) / width));
  const scale = Math.min(inner / width, (tall - 2 * ANIMATION.margin) / height);
  return { scale, tall, follow, x: (box[0] + box[2]) / 2, y: (box[1] + box[3]) / 2 };
}

function shapeElement(shape) {
  const kind = shape.kind === "line" ? "path" : shape.kind === "circle" ? "circle" : "text";
  const element = document.createElementNS(ANIMATION.svg, kind);
  element.setAttribute("class", `${shape.kind} ${shape.tone}${shape.closed ? " closed" : ""}`);
  if (shape.kind === "word") element.textContent = shape.letters;
  return element;
}

// The pictures of one run: an element for each shape; behind the live run only those that move are drawn again.
class Pictures {
  constructor(drawing, name) {
    this.group = document.createElementNS(ANIMATION.svg, "g");
    this.group.setAttribute("class", name);
    const live = name === "live", leaves = (shape) => shape.kind === "circle" && shape.tone === "path" && shape.points;
    this.shapes = drawing.shapes.filter((shape) => live || shape.points);
    this.elements = this.shapes.map(shapeElement);
    this.tips = live ? drawing.shapes.filter(leaves) : []; // of which the tracks are drawn
    this.tracks = this.tips.map(() => shapeElement({ kind: "line", tone: "track" }));
    this.group.append(...this.tracks, ...this.elements);
  }

  // Everything at a row, in a window whose centre is at x, y.
  at(run, row, view, x, y) {
    const across = (value) => (ANIMATION.wide / 2 + (value - x) * view.scale).toFixed(2);
    const down = (value) => (view.tall / 2 - (value - y) * view.scale).toFixed(2);
    this.shapes.forEach((shape, i) => {
      const element = this.elements[i], at = coordinatesOf(shape, run, row);
      if (shape.kind === "line") {
        let path = "";
        for (let k = 0; k < at.length; k += 2) path += `${k ? "L" : "M"}${across(at[k])} ${down(at[k + 1])}`;
        element.setAttribute("d", shape.closed ? `${path}Z` : path);
        element.style.strokeWidth = Math.max(ANIMATION.thinnest, shape.width * view.scale).toFixed(2);
      } else if (shape.kind === "circle") {
        element.setAttribute("cx", across(at[0]));
        element.setAttribute("cy", down(at[1]));
        element.setAttribute("r", Math.max(1.5, at[2] * view.scale).toFixed(2));
      } else {
        element.setAttribute("x", across(at[0]));
        element.setAttribute("y", down(at[1]));
      }
    });
    this.tips.forEach((tip, i) => {
      const length = Math.min(row, Math.ceil(run.rows * ANIMATION.recent));
      const stride = Math.max(1, Math.ceil(length / ANIMATION.track)), [px, py] = tip.points;
      let path = "";
      for (let k = row - stride * Math.floor(length / stride); k <= row; k += stride) {
        const first = k * run.places;
        path += `${path ? "L" : "M"}${across(run.frames[first + px])} ${down(run.frames[first + py])}`;
      }
      this.tracks[i].setAttribute("d", path);
    });
  }
}

// The animation of `drawing` (see Drawing.data in Python) within an element; `onTime(t)` is told each time it shows.
function openAnimation(element, drawing) {
  const make = (name, attributes, text = "") => {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.textContent = text;
    return made;
  };
  const svg = document.createElementNS(ANIMATION.svg, "svg");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", "the plant at the time shown, and pale behind it the baseline run");
  const pictures = { ghost: new Pictures(drawing, "ghost"), live: new Pictures(drawing, "live") };
  svg.append(pictures.ghost.group, pictures.live.group);
  const button = make("button", { type: "button" }, "Play");
  const range = make("input", { type: "range", min: "0", value: "0", step: "1", "aria-label": "time" });
  const clock = make("output", {}), note = make("p", { class: "note", role: "status" });
  const controls = make("div", { class: "controls" });
  controls.append(button, range, clock);
  const root = make("div", { class: "animation" });
  root.append(svg, controls, note);
  element.replaceChildren(root);

  const still = window.matchMedia("(prefers-reduced-motion: reduce)");
  let live = null, printed = null, times = null, view = null, row = 0, ends = NaN, ticket = 0;

  function draw() {
    const shown = Math.max(0, Math.min(row, live.finite - 1));
    let { x, y } = view;
    if (view.follow) {
      const now = extentOf(drawing, live, shown, shown + 1);
      [x, y] = [(now[0] + now[2]) / 2, (now[1] + now[3]) / 2];
    }
    pictures.ghost.group.style.display = printed && printed.finite ? "" : "none";
    if (printed && printed.finite) pictures.ghost.at(printed, Math.min(row, printed.finite - 1), view, x, y);
    pictures.live.group.style.display = live.finite ? "" : "none";
    if (live.finite) pictures.live.at(live, shown, view, x, y);
    const text = `${secondsText(times[row])} s`;
    range.value = String(row);
    range.setAttribute("aria-valuetext", text);
    clock.textContent = text;
    const lost = ends !== null && live.finite < live.rows && row >= live.finite;
    note.textContent = lost ? `diverged at ${secondsText(Number.isNaN(ends) ? times[live.finite] : ends)} s` : "";
    root.classList.toggle("lost", lost);
  }

  // The digits that tell neighbouring rows apart, two at least.
  function secondsText(t) {
    const apart = times.length > 1 ? times[1] - times[0] : 1;
    return t.toFixed(Math.min(6, Math.max(2, Math.ceil(-Math.log10(apart) - 1e-9))));
  }

  function show(at, tell) {
    row = at;
    draw();
    if (tell && animation.onTime) animation.onTime(times[row]);
  }

  const animation = {
    onTime: null,

    // The frames, rows of the drawing's places each, of the live and of the printed run (or null), at the times t in s.
    // `divergedAt` is the time that is told; null if rows that are not finite are those of a run that goes on still.
    load(frames, before, t, divergedAt = NaN) {
      const rows = t.length, places = frames.length / rows;
      live = runOf(frames, places);
      if (!before || !printed || printed.frames !== before) printed = before ? runOf(before, places) : null;
      times = t;
      ends = divergedAt;
      view = windowOf(drawing, live, printed);
      svg.setAttribute("viewBox", `0 0 ${ANIMATION.wide} ${view.tall.toFixed(1)}`);
      range.max = String(rows - 1);
      range.step = String(Math.max(1, Math.ceil((rows - 1) / ANIMATION.stops)));
      show(Math.min(row, rows - 1), false);
    },

    // The plant at the last row at or before a time in s.
    at(t) {
      if (times) show(rowAt(times, t), false);
    },

    // From the time shown to the end, or from the start where that is the end, in ten seconds at most.
    play() {
      if (!times || ticket) return;
      if (row >= times.length - 1) show(0, true);
      button.textContent = "Pause";
      const end = times[times.length - 1], first = times[row], span = end - times[0];
      const speed = Math.max(1, span / ANIMATION.longest), began = performance.now();
      const mine = ticket = Symbol("play");
      const next = (now) => {
        if (ticket !== mine) return;
        show(rowAt(times, first + Math.max(0, now - began) * 1e-3 * speed), true);
        if (row >= times.length - 1) animation.pause();
        else if (still.matches) setTimeout(() => next(performance.now()), (1e3 * span) / speed / ANIMATION.steps);
        else requestAnimationFrame(next);
      };
      if (still.matches) next(began);
      else requestAnimationFrame(next);
    },

    pause() {
      ticket = 0;
      button.textContent = "Play";
    },
  };
  button.addEventListener("click", () => (ticket ? animation.pause() : animation.play()));
  range.addEventListener("input", () => {
    animation.pause();
    if (!times) return;
    const stop = Number(range.value), last = times.length - 1;
    show(stop + Number(range.step) > last ? last : stop, true);  // the last stop is the end, though the step miss it
  });
  return animation;
}
