"use strict";

// The plant in motion: the run of one loop, with its printed run pale behind it, in the bench.
class Motion {
  constructor(page, stage) {
    Object.assign(this, { page, stage, printed: new Map(), place: null, animation: null });
    this.choice = part("select", { "aria-label": "Law in motion" });
    this.room = part("div");
    const head = part("summary", {}, "Watch it move");
    this.fold = part("details", { class: "bench-motion" }, head, this.choice, this.room);
    this.choice.addEventListener("change", () => this.choose());
    this.fold.addEventListener("toggle", () => this.choose());
    stage.append(this.fold);
    this.offer();
  }

  // The loops of a state that can be drawn, of which the reader has chosen one.
  offer() {
    const { loops } = this.page.data, places = this.page.asked(this.page.state).filter((i) => loops[i].drawing);
    this.stage.hidden = !places.length;
    if (places.join() === this.offered) return;
    this.offered = places.join();
    const several = new Set(places.map((i) => loops[i].scenario)).size > 1;
    const named = (i) => (several ? `${loops[i].scenario}: ${loops[i].label}` : loops[i].label);
    this.choice.replaceChildren(...places.map((i) => part("option", { value: i }, named(i))));
    if (places.includes(this.place)) this.choice.value = this.place;
    this.choice.hidden = places.length < 2;
    if (this.fold.open) this.choose();
  }

  choose() {
    const place = this.fold.open && this.choice.value !== "" ? Number(this.choice.value) : null;
    if (place === this.place) return;
    if (this.animation) this.animation.pause();
    this.point(null);
    this.place = place;
    this.animation = null;
    if (place === null) return this.room.replaceChildren();
    this.animation = openAnimation(this.room, this.page.data.loops[place].drawing);
    this.animation.onTime = (time) => this.point(time);
    if (this.missing !== null) this.page.ask();
    this.load(place);
  }

  // The loop whose printed run is asked for and not there yet.
  get missing() {
    return this.place === null || this.printed.has(this.place) ? null : this.place;
  }

  takePrinted(view) {
    this.printed.set(view.loop, view);
    this.load(view.loop);
  }

  // Show the run of a loop as it is now.
  load(place) {
    const { views, data } = this.page, before = this.printed.get(place), now = views.get(place);
    if (place !== this.place || !this.animation || !before) return;
    const loop = data.loops[place], times = Float64Array.from({ length: loop.rows + 1 }, (_, i) => i * loop.every);
    const live = now && now.done ? now : before, ghost = live === before ? null : this.frames(before, loop);
    this.animation.load(this.frames(live, loop), ghost, times, live.divergedAt);
  }

  // The coordinates of the drawing, row by row, out of the outputs of a run.
  frames({ y }, loop) {
    const { first, places } = loop.drawing, width = y.length / (loop.rows + 1);
    const frames = new Float64Array((loop.rows + 1) * places);
    for (let row = 0; row <= loop.rows; row++) {
      frames.set(y.subarray(row * width + first, row * width + first + places), row * places);
    }
    return frames;
  }

  // A line at the time shown in the figures of this loop that are in sight; null takes it away everywhere.
  point(time) {
    const { data, figures } = this.page; // those that were opened
    const mine = new Set(data.curves.filter((curve) => curve.loop === this.place).map((curve) => curve.figure));
    for (const name of mine) {
      const figure = time === null ? figures.get(name) : this.page.figure(name);
      if (figure && (time === null || this.page.near.has(name))) figure.cursor(time);
    }
  }
}
