"use strict";

// The curves, bars and points of a figure drawn again from live numbers, above the printed ones, which stay below in a
// paler tone, and curves of earlier runs and of settings that are held, pale between both.
//
// `openFigure(svg, plate)` takes the drawn SVG and its plate, as plates.py describes it, and gives a figure:
// show([{panel: 0, series: 1, x: times, y: values}], [{panel: 1, series: 0, index: 3, axis: "x", value: 0.5}]) draws
// all curves that are live, from Float64Arrays, NaN a gap, which are kept, and are not to change, until the next, weaker
// if they are `coarse`; and all bars that are, by their ends, and points, by their numbers along an axis. A third list
// has pale curves, {panel, series, x, y, kind: "before", "held-a" or "held-b", label}. A fourth is what planes need beside
// them, as `linearDrawing` in answers.js gives it: sets of points and arrows, and the ranges of panels. cursor(1.5) draws a
// line at this time and a dot on each live curve; cursor(null) removes them. refuse("why") greys the figure out below a
// sentence, and refuse("") brings it back. clear() leaves the printed figure, to the byte.

const SVG_SPACE = "http://www.w3.org/2000/svg";
const DIGIT_HEIGHT = 0.676, ASCENT = 0.76; // of the size of the letters, as in pen.py
const NEARER = 2; // points: how much nearer to their marks wide numbers may stand

// A new element of an SVG.
function svgElement(name, attributes, parent) {
  const element = document.createElementNS(SVG_SPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent?.append(element);
  return element;
}

// Write a number at a point, with a raised part unless that is empty; returns its element.
function writeNumber(text, raised, x, y, size, anchor, parent) {
  const place = { x: coordinate(x), y: coordinate(y), "font-size": coordinate(size), "text-anchor": anchor };
  const number = svgElement("text", place, parent);
  number.textContent = text;
  if (raised === "") return number;
  const power = svgElement("tspan", { dy: coordinate(-0.4 * size), "font-size": coordinate(0.7 * size) }, number);
  power.textContent = raised;
  return number;
}

// A printed line, area or mark, which moves with the rulers of its panel and comes back as it was.
class PrintedPiece {
  constructor(element, names) {
    this.element = element;
    this.names = names; // of the attributes that hold its coordinates: a path, or the place of a mark
    this.held = names.map((name) => element.getAttribute(name));
  }

  // Move by what both rulers say: [factor, shift] across, and [factor, shift] upwards.
  moveBy([acrossBy, acrossTo], [upBy, upTo]) {
    if (this.names.length === 2) {
      this.element.setAttribute("x", coordinate(acrossBy * this.held[0] + acrossTo));
      this.element.setAttribute("y", coordinate(upBy * this.held[1] + upTo));
      return;
    }
    this.points ??= pathPoints(this.held[0]);
    const path = movedPath(this.points, (x) => acrossBy * x + acrossTo, (y) => upBy * y + upTo);
    this.element.setAttribute("d", path);
  }

  restore() {
    this.names.forEach((name, i) => this.element.setAttribute(name, this.held[i]));
  }
}

// All pieces below some elements that have coordinates of their own.
function printedPieces(groups) {
  return groups.flatMap((group) => [
    ...[...group.querySelectorAll("path[d]:not(defs path)")].map((path) => new PrintedPiece(path, ["d"])),
    ...[...group.querySelectorAll("use")].map((mark) => new PrintedPiece(mark, ["x", "y"])),
  ]);
}

// A live curve: its element in the panel, and what was drawn last.
class LiveCurve {
  constructor(look, printed, parent) {
    this.look = look;
    this.marks = look.look === "marks" || look.look === "dots";
    this.sample = this.marks ? printed.querySelector("use") : null;
    this.element = svgElement(this.marks ? "g" : "path", { class: "live-series" }, parent);
    this.dot = null;
  }

  // Take numbers, and thin them, unless they are those that it has.
  take(x, y, ruler, points) {
    if (x === this.x && y === this.y) return;
    this.ruled = "";
    const [first, last] = ruler.printed.fixed ? windowPlaces(x, ruler.low, ruler.high) : [0, x.length];
    [this.x, this.y, this.places] = [x, y, thinnedPlaces(x, y, first, last, points, ruler.even ? null : ruler.straight)];
  }

  draw(across, up, coarse = false) {
    if (coarse !== this.coarse) this.element.setAttribute("class", coarse ? "live-series coarse" : "live-series");
    this.coarse = coarse;
    if (!this.isMoved(across, up)) return;
    if (this.marks) {
      this.drawMarks(across, up);
      return;
    }
    const thin = chatters(this.y, this.places);
    if (thin !== this.thin) {
      this.element.setAttribute("style", lineStyle(this.look, thin));
      this.thin = thin;
    }
    this.element.setAttribute("d", pathOf(across.at, up.at, this.x, this.y, this.places, this.look.look === "steps"));
  }

  // True if it has new numbers, or stands on other rulers than when it was drawn.
  isMoved(across, up) {
    const before = this.ruled;
    this.ruled = `${across.low} ${across.high} ${up.low} ${up.high}`;
    return this.ruled !== before;
  }

  drawMarks(across, up) {
    let count = 0;
    for (const place of this.sample ? this.places : []) {
      const x = across.at(this.x[place]), y = up.at(this.y[place]);
      if (!Number.isFinite(x) || !Number.isFinite(y)) continue;
      const mark = this.element.children[count++] ?? this.element.appendChild(this.sample.cloneNode());
      mark.setAttribute("x", coordinate(x));
      mark.setAttribute("y", coordinate(y));
    }
    while (this.element.children.length > count) this.element.lastChild.remove();
  }

  // Put the dot on the last point at or before a time.
  point(time, across, up, parent) {
    const place = placeBefore(this.x, time, true);
    const x = across.at(this.x[place]), y = up.at(this.y[place]);
    if (!(Number.isFinite(x) && Number.isFinite(y))) {
      this.dot?.remove();
      return;
    }
    this.dot ??= svgElement("circle", {r: 2.4, style: `fill: ${this.look.color}; stroke: var(--cffffff, #ffffff); stroke-width: 0.7`});
    this.dot.setAttribute("cx", coordinate(x));
    this.dot.setAttribute("cy", coordinate(y));
    if (this.dot.parentNode !== parent) parent.append(this.dot);
  }

  remove() {
    this.element.remove();
    this.dot?.remove();
  }
}

// A pale curve of an earlier run, or of a setting that is held, with its name where it differs most from the curve of now.
class PaleCurve {
  constructor(look, kind, parent) {
    Object.assign(this, { look, kind });
    this.element = svgElement("g", { class: `live-pale ${kind}` }, parent);
    this.line = svgElement("path", { style: `fill: none; stroke: ${look.color}` }, this.element);
  }

  take(x, y, ruler, points) {
    LiveCurve.prototype.take.call(this, x, y, ruler, points);
  }

  // Draw it, and its name.
  draw(across, up, label, size, box, now) {
    if (LiveCurve.prototype.isMoved.call(this, across, up)) {
      this.element.classList.toggle("thin", chatters(this.y, this.places));
      this.line.setAttribute("d", pathOf(across.at, up.at, this.x, this.y, this.places, this.look.look === "steps"));
    }
    this.word?.remove();
    this.word = null;
    if (!label) return;
    const place = this.farthestFrom(now), x = across.at(this.x[place]), y = up.at(this.y[place]);
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    const anchor = x > box.left + 0.7 * box.width ? "end" : "start", above = this.kind === "held-a" && y > box.top + 1.4 * size;
    this.word = writeNumber(label, "", x, above ? y - 0.4 * size : y + 1.1 * size, size, anchor, this.element);
  }

  // The place of its point that is farthest from the curve that is drawn now; without one its last.
  farthestFrom(now) {
    let farthest = -1, place = this.places.findLast((one) => Number.isFinite(this.y[one])) ?? 0;
    for (const one of now && now.y.length === this.y.length ? this.places : []) {
      const distance = Math.abs(this.y[one] - now.y[one]);
      if (distance > farthest) [farthest, place] = [distance, one];
    }
    return place;
  }

  remove() {
    this.element.remove();
  }
}

// The style of a line, as the printed one's: thin and whole if it chatters.
function lineStyle(look, thin) {
  const dash = thin || !look.dash.length ? "stroke-linecap: square" : `stroke-dasharray: ${look.dash.join(",")}`;
  return `fill: none; stroke: ${look.color}; stroke-width: ${thin ? 0.5 : look.width}; ${dash}`;
}

let clipCount = 0; // of panels with live curves on this page: names for their clips

// A panel with its rulers, its printed groups and its live curves.
class LivePanel {
  constructor(svg, plate, i) {
    const panel = plate.panels[i], [left, bottom, width, height] = panel.box;
    this.svg = svg;
    this.plate = plate;
    this.panel = panel;
    this.box = { left, top: plate.height - bottom - height, width, height };
    this.x = new LiveRuler(panel.x, left, width, plate.letters);
    this.y = new LiveRuler(panel.y, plate.height - bottom, -height, plate.letters);
    const groups = (kind) => [...svg.querySelectorAll(`g.${kind}[data-panel="${i}"]`)];
    this.rulers = { x: groups("ruler-x"), y: groups("ruler-y") };
    this.printed = new Map(groups("series").map((group) => [Number(group.dataset.series), group]));
    this.marked = new Map(groups("marks").map((group) => [Number(group.dataset.series), group]));
    this.lines = { x: groups("vlines"), y: groups("hlines") };
    this.guides = groups("guides"); // names on printed lines
    const isGuide = (series) => panel.series[series].look === "guides";
    this.printedGrid = [...this.printed].filter(([series]) => isGuide(series)).map(([, group]) => group);
    this.sets = new Map(); // of points and arrows, by kind and series
    this.scales = { x: [], y: [] }; // the elements of rulers that have grown
    this.curves = new Map();
    this.pale = new Map(); // by kind and series
    this.marks = new Map(); // by series and index
    this.clip = `live-clip-${clipCount++}`;
  }

  // Draw these curves, bars, points and pale curves of the panel, and remove all others.
  show(asked, marks, pale, sets = [], plane = null) {
    const kept = new Set(asked.map((one) => one.series));
    for (const [series, curve] of this.curves) if (!kept.has(series)) this.drop(series, curve);
    const some = asked.length || marks.length || pale.length || sets.length;
    if (some) this.open();
    for (const { series, x, y } of asked) this.curveOf(series)?.take(x, y, this.x, this.plate.points);
    this.takeMarks(marks);
    this.takePale(pale);
    this.takeSets(sets);
    this.plane = plane;
    this.fit();
    for (const { series, coarse } of asked) this.curves.get(series)?.draw(this.x, this.y, Boolean(coarse));
    for (const mark of this.marks.values()) mark.draw(this.x, this.y, this.box);
    this.drawPale(pale);
    for (const one of this.sets.values()) one.draw(this.x, this.y, this.box, this.plate.letters.size);
    if (!some) this.shut();
  }

  // Give all sets of points and arrows their numbers, and remove the others.
  takeSets(asked) {
    const keyOf = ({ kind, series }) => `${kind} ${series}`, kept = new Set(asked.map(keyOf));
    for (const [key, one] of this.sets) {
      if (kept.has(key)) continue;
      one.remove();
      this.sets.delete(key);
    }
    for (const one of asked) {
      const layer = one.kind === "now" ? this.markLayer : this.paleLayer, look = this.panel.series[one.series];
      if (!this.sets.has(keyOf(one))) this.sets.set(keyOf(one), new LiveSet(look, this.marked.get(one.series), one.kind, layer));
      this.sets.get(keyOf(one)).take(one);
    }
  }

  // Give all pale curves their numbers, and remove the others.
  takePale(asked) {
    const keyOf = ({ kind, series }) => `${kind} ${series}`, kept = new Set(asked.map(keyOf));
    for (const [key, curve] of this.pale) {
      if (kept.has(key)) continue;
      curve.remove();
      this.pale.delete(key);
    }
    for (const one of asked) {
      const look = this.panel.series[one.series], key = keyOf(one);
      if (!["line", "steps"].includes(look.look)) continue;
      if (!this.pale.has(key)) this.pale.set(key, new PaleCurve(look, one.kind, this.paleLayer));
      this.pale.get(key).take(one.x, one.y, this.x, this.plate.points);
    }
  }

  // Draw the pale curves; of a kind the first in the panel has its name.
  drawPale(asked) {
    const named = new Set();
    for (const { kind, series, label } of asked) {
      const curve = this.pale.get(`${kind} ${series}`), text = named.has(kind) ? "" : label;
      curve?.draw(this.x, this.y, text, this.plate.letters.size, this.box, this.curves.get(series));
      named.add(kind);
    }
  }

  // Give all live bars and points their numbers, a point up to two of them, and remove the others.
  takeMarks(asked) {
    const taken = new Map();
    for (const { series, index, axis, value } of asked) {
      const key = `${series} ${index}`, numbers = { ...taken.get(key), [axis]: value };
      taken.set(key, numbers);
      if (!this.marks.has(key) && this.marked.has(series)) {
        const look = this.panel.series[series], size = this.plate.letters.size;
        this.marks.set(key, new LiveMark(look, index, this.marked.get(series), size, this.markLayer));
      }
      this.marks.get(key)?.take(numbers);
    }
    for (const [key, mark] of this.marks) {
      if (taken.has(key)) continue;
      mark.remove();
      this.marks.delete(key);
    }
  }

  curveOf(series) {
    const look = this.panel.series[series], printed = this.printed.get(series);
    if (!this.curves.has(series) && printed && look.look !== "band") {
      this.curves.set(series, new LiveCurve(look, printed, this.layer));
      printed.setAttribute("class", "series pinned");
      for (const each of this.printed.keys()) { // in the printed order of layers
        if (this.curves.has(each)) this.layer.append(this.curves.get(each).element);
      }
    }
    return this.curves.get(series);
  }

  drop(series, curve) {
    curve.remove();
    this.printed.get(series).setAttribute("class", "series");
    this.curves.delete(series);
  }

  // Make what holds the live curves, above all that is printed.
  open() {
    if (this.layer) return;
    const { left, top, width, height } = this.box;
    this.above = svgElement("g", { class: "live-panel" }, this.svg);
    const clip = svgElement("clipPath", { id: this.clip }, this.above);
    svgElement("rect", { x: left, y: top, width, height }, clip);
    const clipped = svgElement("g", {"clip-path": `url(#${this.clip})`}, this.above);
    this.paleLayer = svgElement("g", {}, clipped);
    this.layer = svgElement("g", {}, clipped);
    this.markLayer = svgElement("g", {}, clipped);
    this.pointer = svgElement("g", {}, clipped);
  }

  shut() {
    this.above?.remove();
    this.above = this.layer = this.markLayer = this.paleLayer = this.pointer = null;
  }

  // Let both rulers hold the live numbers; what is printed moves with them.
  fit() {
    const across = [Infinity, -Infinity], up = [Infinity, -Infinity];
    for (const { x, y } of this.plane?.ranges ?? []) { // which know how far curves are to be seen
      widen(across, x, [0, 1], "linear");
      widen(up, y, [0, 1], "linear");
    }
    for (const { x, y, places } of this.plane ? [] : [...this.curves.values(), ...this.pale.values()]) {
      widen(across, x, places, this.x.printed.scale);
      widen(up, y, places, this.y.printed.scale);
    }
    for (const mark of this.marks.values()) mark.widen(across, up, this.x, this.y);
    const moved = this.panel.equal ? fitEqual(this.x, this.y, across, up) : [this.x.fit(...across), this.y.fit(...up)];
    if (moved[0]) this.rule("x");
    if (moved[1]) this.rule("y");
    if (!(moved[0] || moved[1])) return;
    this.movePrinted();
    this.drawGuides(this.x.grown || this.y.grown);
  }

  // Where rulers have grown, the names of printed lines are hidden; in a map of poles its lines are drawn anew.
  drawGuides(grown) {
    this.grid?.remove();
    this.grid = null;
    const isAnew = grown && this.plane?.poles;
    for (const group of [...this.guides, ...this.printedGrid]) {
      if (isAnew || (grown && this.guides.includes(group))) group.setAttribute("visibility", "hidden");
      else group.removeAttribute("visibility");
    }
    if (!isAnew) return;
    this.grid = svgElement("g", { class: "live-ruler" });
    this.paleLayer.before(this.grid);
    drawGrid(poleGrid(this.x, this.y, this.plane.period), this.x, this.y, this.box, this.grid);
  }

  movePrinted() {
    const still = [1, 0], { x, y } = this;
    const marks = [...this.marked], words = ([series, group]) => printedWords(group, this.panel.series[series], x, y);
    this.pieces ??= [
      [printedPieces([...this.printed.values()]), () => [x.move, y.move]],
      [printedPieces(marks.flatMap(([, group]) => [...group.querySelectorAll(".mark")])), () => [x.move, y.move]],
      [marks.flatMap(words), () => [x.move, y.move]],
      [printedPieces(this.lines.x), () => [x.move, still]],
      [printedPieces(this.lines.y), () => [still, y.move]],
    ];
    for (const [pieces, moves] of this.pieces) {
      const [across, up] = moves();
      for (const piece of pieces) {
        if (x.grown || y.grown) piece.moveBy(across, up);
        else piece.restore();
      }
    }
  }

  // Hide the printed marks and numbers of a ruler that has grown and write its own; or show the printed ones.
  rule(name) {
    const ruler = this[name];
    for (const element of this.scales[name]) element.remove();
    for (const group of this.rulers[name]) {
      if (ruler.grown) group.setAttribute("visibility", "hidden");
      else group.removeAttribute("visibility");
    }
    this.scales[name] = [];
    if (!ruler.grown) return;
    const room = name === "y" ? (ruler.printed.room + NEARER) / this.plate.letters.size : ROOM_ACROSS;
    const { power, marks } = rulerMarks(ruler.printed.scale, ruler.low, ruler.high, ruler.count, room, ruler.printed.steps);
    const grid = svgElement("path", { class: "live-grid", d: this.strokes(name, marks, true) });
    this.rulers[name][0].after(grid);
    const scale = svgElement("g", { class: "live-ruler" }, this.above);
    svgElement("path", { class: "live-marks", d: this.strokes(name, marks, false) }, scale);
    this.write(name, marks, power, scale);
    this.scales[name] = [grid, scale];
  }

  // The lines of the grid, or the marks, of a ruler.
  strokes(name, marks, grid) {
    const { left, top, width, height } = this.box, { tick } = this.plate.letters, foot = top + height;
    return marks.map(([number]) => {
      const at = coordinate(this[name].at(number));
      if (name === "y") return `M${coordinate(left)} ${at}H${coordinate(grid ? left + width : left - tick)}`;
      return `M${at} ${coordinate(foot)}V${coordinate(grid ? top : foot + tick)}`;
    }).join("");
  }

  // The numbers at a ruler, as large as the room beside it allows, where the name of the axis ends it, and their power.
  write(name, marks, power, parent) {
    const { left, top, width, height } = this.box, { size, tick, pad } = this.plate.letters, upwards = name === "y";
    const wide = size * widestText(marks), room = upwards ? this.y.printed.room : Infinity;
    const nearer = Math.min(NEARER, Math.max(0, wide - room));
    const letters = size * Math.min(1, (room + nearer) / wide);
    for (const [number, text, raised] of marks) {
      const at = this[name].at(number), half = letters * textWidth(text) / 2; // of a number that stays on the sheet
      const x = upwards ? left - tick - pad + nearer : Math.min(at, this.plate.width - half);
      const y = upwards ? at + DIGIT_HEIGHT * letters / 2 : top + height + tick + pad + ASCENT * size;
      writeNumber(text, raised, x, y, letters, upwards ? "end" : "middle", parent);
    }
    if (!power) return;
    const within = upwards && !this.y.printed.power ? DIGIT_HEIGHT * size + 4 : -3; // no room above: in the corner
    const x = upwards ? left + (within > 0 ? 3 : 0) : left + width - 2, y = upwards ? top + within : top + height - 3;
    writeNumber("×10", withMinus(power), x, y, size, upwards ? "start" : "end", parent);
  }

  // Draw the line at a time, and the dots of the live curves; null removes them.
  cursor(time) {
    if (!this.panel.x.time) return;
    const { left, top, width, height } = this.box, at = time === null ? NaN : this.x.at(time);
    if (!(at >= left - 0.01 && at <= left + width + 0.01)) {
      this.pointer?.replaceChildren();
      if (!this.curves.size && !this.marks.size && !this.pale.size && !this.sets.size) this.shut();
      return;
    }
    this.open();
    this.hand ??= svgElement("path", { class: "live-cursor" });
    this.hand.setAttribute("d", `M${coordinate(at)} ${coordinate(top)}v${coordinate(height)}`);
    if (this.hand.parentNode !== this.pointer) this.pointer.prepend(this.hand);
    for (const curve of this.curves.values()) curve.point(time, this.x, this.y, this.pointer);
  }
}

// A figure with its live panels.
class LiveFigure {
  constructor(svg, plate) {
    this.svg = svg;
    this.given = svg.getAttribute("class");
    this.panels = plate.panels.map((_, i) => new LivePanel(svg, plate, i));
    this.time = null;
  }

  // Draw these curves, bars and points again, over pale ones, and leave all others as they are printed.
  show(series, marks = [], pale = [], { sets = [], planes = new Map() } = {}) {
    const asked = this.panels.map(() => ({ series: [], marks: [], pale: [], sets: [] }));
    for (const one of series) asked[one.panel].series.push(one);
    for (const one of marks) asked[one.panel].marks.push(one);
    for (const one of pale) asked[one.panel].pale.push(one);
    for (const one of sets) asked[one.panel].sets.push(one);
    this.panels.forEach((panel, i) => {
      const { series, marks, pale, sets } = asked[i];
      panel.show(series, marks, pale, sets, planes.get(i) ?? null);
    });
    if (series.length || marks.length || sets.some(({ kind }) => kind === "now")) this.svg.setAttribute("class", `${this.given ?? ""} live`.trim());
    else if (this.given === null) this.svg.removeAttribute("class");
    else this.svg.setAttribute("class", this.given);
    if (this.time !== null) this.cursor(this.time);
  }

  // Draw the line at a time in all panels over time; null removes it.
  cursor(time) {
    this.time = time;
    for (const panel of this.panels) panel.cursor(time);
  }

  // Grey the figure out below a sentence that says why it shows nothing; an empty one brings it back.
  refuse(sentence) {
    if (sentence === (this.note?.textContent ?? "")) return;
    this.note?.remove();
    this.note = null;
    const figure = this.svg.closest("figure") ?? this.svg.parentElement;
    figure.classList.toggle("live-refused", Boolean(sentence));
    if (!figure.classList.length) figure.removeAttribute("class");
    if (sentence) this.note = part("p", { class: "live-reason" }, sentence);
    if (this.note) figure.prepend(this.note);
  }

  clear() {
    this.refuse("");
    this.cursor(null);
    this.show([]);
  }
}

// A drawn figure, by its SVG and its plate, whose curves, bars and points can be drawn again.
function openFigure(svg, plate) {
  return new LiveFigure(svg, plate);
}
