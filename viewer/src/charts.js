// Curves over time in step with the pictures: a click goes there, a drag chooses the range that is repeated.

import uPlot from "uplot";
import { CURVES } from "./colours.js";
import { shownLength } from "./waves.js";

/** One chart with a choice of what it shows. */
export class Chart {
  constructor(holder, worlds, titles, events) {
    this.worlds = worlds; this.events = events;
    this.groups = groupsOf(worlds);
    this.box = document.createElement("div"); this.box.className = "chart";
    this.choice = document.createElement("select"); this.choice.setAttribute("aria-label", "what is plotted");
    this.groups.forEach((group, k) => this.choice.add(new Option(nameOf(group), String(k))));
    this.choice.value = String(Math.max(0, ...titles.map((title) => this.groups.findIndex((group) => group.title === title)).filter((k) => k >= 0).slice(0, 1)));
    this.choice.addEventListener("change", () => this.build());
    this.area = document.createElement("div"); this.area.className = "plot";
    this.now = document.createElement("div"); this.now.className = "now";
    this.box.append(this.choice, this.area);
    holder.append(this.box);
  }

  /** Other groups of curves to choose from; `first` is shown. */
  regroup(groups, first) {
    this.groups = groups;
    this.choice.replaceChildren(...groups.map((group, k) => new Option(nameOf(group), String(k))));
    this.choice.value = String(Math.min(first, groups.length - 1));
    this.build();
  }

  build(theme = this.theme) {
    this.theme = theme;
    this.plot?.destroy();
    const live = this.worlds[0].head.live, group = this.groups[Number(this.choice.value)], tables = [], series = [{}], end = Math.max(...this.worlds.map((w) => w.numbers.end));
    group.curves.forEach((list, run) => {
      const n = this.worlds[run].numbers;
      tables.push([(group.times && n.columns.get(group.times)) || n.times, ...list.map(([column, , factor]) => Array.from(n.columns.get(column), (v) => (v === v ? factor * v : null)))]);
      list.forEach(([, label], k) => series.push({ label: this.worlds.length > 1 ? `${label}, ${this.worlds[run].head.label}` : label, stroke: CURVES[k % CURVES.length], width: 1.3, dash: run ? [6, 4] : undefined, spanGaps: false, points: { show: false } }));
    });
    const axis = { stroke: theme.text, grid: { stroke: theme.grid, width: 1 }, ticks: { stroke: theme.grid }, font: "11px system-ui, sans-serif" };
    const options = {
      width: this.area.clientWidth || 300, height: this.area.clientHeight || 150, series,
      scales: { y: { range: span }, x: { time: false, range: live ? (_, low, high) => [low, Math.max(high, low + 1)] : () => this.page || [0, end] } },
      axes: [{ ...axis, size: 26 }, { ...axis, size: (_, labels) => 18 + 6.5 * Math.max(3, ...(labels || []).map((text) => text.length)) }],
      legend: { show: false }, cursor: { drag: { x: true, y: false, setScale: false }, points: { show: false } },
      hooks: { setSelect: [(u) => { if (u.select.width > 3) this.events.range(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")); u.setSelect({ width: 0, height: 0 }, false); }] },
    };
    this.end = end; this.page = null;
    this.length = live ? 0 : Math.max(...tables.map(([times, values]) => (values ? shownLength(Array.from(times), values, options.width - 60) : 0)));
    this.plot = new uPlot(options, tables.length > 1 ? uPlot.join(tables) : tables[0], this.area);
    this.plot.over.append(this.now);
    this.plot.over.addEventListener("click", () => { if (this.plot.cursor.left >= 0) this.events.time(this.plot.posToVal(this.plot.cursor.left, "x")); });
    this.keys(group);
    this.mark(this.time || 0);
  }

  keys(group) {
    this.legend?.remove();
    this.legend = document.createElement("div"); this.legend.className = "keys";
    const most = group.curves.reduce((a, b) => (b.length > a.length ? b : a)); // a rig has curves that a track has not
    most.forEach(([, label], k) => {
      const key = document.createElement("span");
      key.innerHTML = `<i style="background:${CURVES[k % CURVES.length]}"></i>`;
      key.append(label);
      this.legend.append(key);
    });
    if (this.worlds.length > 1) { const key = document.createElement("span"); key.textContent = `dashed: ${this.worlds[1].head.label}`; this.legend.append(key); }
    this.box.append(this.legend);
  }

  resize() { if (this.plot && this.area.clientWidth) { this.plot.setSize({ width: this.area.clientWidth, height: this.area.clientHeight }); this.mark(this.time || 0); } }

  /** The curves of a simulation that runs. */
  renew() {
    const n = this.worlds[0].numbers, group = this.groups[Number(this.choice.value)];
    this.now.style.display = "none";
    if (n.times.length > 1) this.plot.setData([n.times, ...group.curves[0].map(([column, , factor]) => n.columns.get(column).map((v) => (v === v ? factor * v : null)))]);
  }

  /** A long oscillation is shown page by page. */
  turn(first) {
    if (this.page?.[0] === first) return;
    this.page = [first, first + this.length];
    this.plot.setScale("x", { min: this.page[0], max: this.page[1] });
  }

  mark(time) {
    this.time = time;
    if (this.plot && this.length) this.turn(Math.min(Math.floor(time / this.length) * this.length, this.end - this.length));
    if (this.plot) this.now.style.transform = `translateX(${this.plot.valToPos(time, "x")}px)`;
  }
}

/** What the values need, and no less than a hundredth or a thousandth of them: round-off is not drawn, and ticks have three decimals. */
function span(_, low, high) {
  if (low === null || high === null) return [0, 1];
  const least = Math.max(1e-2, 2e-3 * Math.max(Math.abs(low), Math.abs(high))), missing = Math.max(0, least - (high - low)) / 2, edge = 0.06 * (high - low) + missing;
  return [low - edge, high + edge];
}

/** What is plotted, with its sign, its filter and its unit. */
function nameOf(group) {
  return `${[group.title, group.note].filter(Boolean).join(", ")} [${group.unit}]`;
}

/** Groups of all runs by name; of each run its curves. */
function groupsOf(worlds) {
  const found = new Map();
  worlds.forEach((world, run) => world.head.plots.forEach((group) => {
    const name = nameOf(group);
    if (!found.has(name)) found.set(name, { ...group, curves: worlds.map(() => []) });
    found.get(name).curves[run] = group.curves;
  }));
  return [...found.values()];
}
