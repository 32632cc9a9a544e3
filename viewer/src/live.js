// A simulation that runs now: frames that a server on this machine sends, and the sliders that move it.
//
//   server-sent events -> LiveNumbers, like the numbers of a run; sliders -> POST

import { button, element, slider } from "./dom.js";

const KEPT = 180; // 6 s: 30 waves of a bogie that hunts

/** The latest frames as numbers: between the last two the picture goes on in time, the curves have the last KEPT. */
export class LiveNumbers {
  constructor(head) {
    this.names = head.live.columns;
    this.place = new Map(this.names.map((name, k) => [name, k]));
    this.drawn = new Set(head.plots.flatMap((group) => group.curves.map(([column]) => column)));
    this.forget();
  }

  forget() {
    this.columns = new Map([...this.drawn].map((name) => [name, []]));
    this.times = []; this.before = this.now = null; this.part = 1; this.fresh = false;
  }

  take(frame) {
    if (this.times.length && frame.time < this.times.at(-1)) this.forget();
    this.before = this.now || frame.values; this.now = frame.values; this.arrived = performance.now(); this.fresh = true;
    this.times.push(frame.time);
    for (const [name, list] of this.columns) list.push(frame.values[this.place.get(name)] ?? NaN);
    if (this.times.length > KEPT) { this.times.shift(); for (const list of this.columns.values()) list.shift(); }
  }

  has(name) { return this.place.has(name); }
  get end() { return this.times.at(-1) || 1; }
  largest() { return 0; }
  seek() { this.part = Math.min(1, (performance.now() - (this.arrived || 0)) * 0.03); }

  at(name) {
    const k = this.place.get(name);
    if (k === undefined || !this.now) return 0;
    const a = this.before[k] ?? NaN, b = this.now[k] ?? NaN;
    return a === a && b === b ? a + this.part * (b - a) : b;
  }
}

const shown = (one) => (v) => `${Number(v.toPrecision(3))} ${one.unit}`.trim();

/** Sliders of a live simulation, and a push for the vehicle. */
export class Desk {
  constructor(head, numbers, events) {
    this.events = events; this.waiting = new Map(); this.sliders = head.live.sliders;
    this.text = element("p", { class: "exact", role: "status", id: "told" });
    this.node = element("div", { class: "desk" },
      ...head.live.sliders.map((one) => slider(one.label, one.least, one.most, (one.most - one.least) / 200, one.value, shown(one), (v) => { this.waiting.set(one.name, v); this.sendWaiting(); }, `live-${one.name}`)),
      element("div", { class: "modes" }, button("push", "the leading wheelset 3 mm to the left", () => this.send("push", {}), "push"), button("begin again", "as at the start", () => { this.back(); this.send("again", {}); }, "again")),
      this.text, element("p", { class: "exact" }, head.live.note));
    const source = new EventSource("frames");
    source.onmessage = (message) => { const frame = JSON.parse(message.data); numbers.take(frame); this.tell(frame); };
    source.addEventListener("scene", () => this.events.scene());
    source.onerror = () => { this.text.textContent = "The simulation has ended, or its server cannot be reached."; };
  }

  tell(frame) {
    if (frame.caption !== undefined) this.events.exhibited(frame);
    for (const [name, value] of Object.entries(frame.sliders || {})) if (!this.waiting.has(name)) this.move(name, value);
    if (performance.now() > (this.refused || 0)) this.text.textContent = frame.told || `${frame.time.toFixed(1)} s, in real time`;
  }

  /** A slider to where the simulation has it, unless a visitor holds it. */
  move(name, value) {
    const input = document.getElementById(`live-${name}`), one = this.sliders.find((other) => other.name === name);
    if (!input || input.matches(":active") || this.busy || Number(input.value) === value) return;
    input.value = value;
    input.nextSibling.textContent = shown(one)(value);
  }

  /** What sliders ask for, one after the other, of each the latest. */
  async sendWaiting() {
    if (this.busy) return;
    this.busy = true;
    while (this.waiting.size) {
      const [name, value] = this.waiting.entries().next().value;
      this.waiting.delete(name);
      await this.send("set", { name, value });
    }
    this.busy = false;
  }

  /** All sliders where they began. */
  back() {
    for (const one of this.sliders) this.move(one.name, one.first);
  }

  async send(what, body) {
    const answer = await fetch(what, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
    if (answer.ok) return;
    this.text.textContent = await answer.text();
    this.refused = performance.now() + 6000;
  }
}
