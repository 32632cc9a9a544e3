// Time: running, slow, repeated over a range; the bar that shows and sets it.

import { button, element } from "./dom.js";

const RATES = [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01];

export class Clock {
  constructor(holder, end, frameStep) {
    this.end = end; this.step = frameStep; this.time = 0; this.playing = false; this.rate = 1; this.range = null;
    this.play = button("▶", "play or pause (space)", () => this.toggle(), "play");
    this.bar = element("input", { type: "range", min: 0, max: end, step: "any", value: 0, id: "time", "aria-label": "time" });
    this.bar.addEventListener("input", () => this.set(Number(this.bar.value)));
    this.text = element("output", { id: "clock" });
    this.speed = element("select", { id: "rate", "aria-label": "speed of the picture", title: "speed of the picture (, slower . faster)" });
    for (const rate of RATES) this.speed.add(new Option(rate === 1 ? "real time" : `1/${Math.round(1 / rate)} speed`, rate));
    this.speed.addEventListener("change", () => { this.rate = Number(this.speed.value); });
    this.from = button("[", "begin of the range that is repeated ([)", () => this.limit(0), "from");
    this.to = button("]", "end of the range that is repeated (])", () => this.limit(1), "to");
    this.clear = button("⟲ all", "repeat the whole run (L)", () => this.repeat(null), "clear");
    holder.append(this.play, element("div", { class: "bar" }, this.bar), this.text, this.speed, this.from, this.to, this.clear);
    this.set(0);
    this.repeat(null);
  }

  /** Another length of the whole; it goes on playing if it did. */
  bounded(end, playing) {
    this.end = end;
    this.bar.max = end;
    this.repeat(null);
    this.set(0);
    if (playing !== this.playing) this.toggle();
  }

  get first() { return this.range ? this.range[0] : 0; }
  get last() { return this.range ? this.range[1] : this.end; }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.time >= this.last - 1e-9) this.set(this.first);
    this.play.textContent = this.playing ? "❚❚" : "▶";
  }

  set(time) {
    this.time = Math.min(this.end, Math.max(0, time));
    this.bar.value = this.time;
    this.text.textContent = `${this.time.toFixed(this.end < 5 ? 3 : 2)} s`;
    this.dirty = true;
  }

  advance(seconds) {
    if (!this.playing) return;
    let next = this.time + this.rate * seconds;
    if (next >= this.last) next = this.first + ((next - this.first) % Math.max(1e-6, this.last - this.first));
    if (next < this.first) next = this.first;
    this.set(next);
  }

  limit(which) {
    const range = this.range ? [...this.range] : [0, this.end];
    range[which] = this.time;
    this.repeat(range[0] < range[1] ? range : null);
  }

  /** Repeat from one time to another [s]; null: everything. */
  repeat(range) {
    this.range = range;
    this.clear.disabled = !range;
    const a = (100 * this.first) / this.end, b = (100 * this.last) / this.end;
    this.bar.style.setProperty("--range", `linear-gradient(90deg, var(--faint) ${a}%, var(--accent) ${a}% ${b}%, var(--faint) ${b}%)`);
    if (range && (this.time < range[0] || this.time > range[1])) this.set(range[0]);
  }

  faster(way) {
    const k = Math.min(RATES.length - 1, Math.max(0, RATES.indexOf(this.rate) - way));
    this.rate = RATES[k]; this.speed.value = String(this.rate);
  }
}
