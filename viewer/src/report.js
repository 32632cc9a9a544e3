// A report's figures: curves that can be zoomed in place of their pictures, and all other pictures enlarged on request.
//
//   JSON and numbers beside a figure -> uPlot, one per panel, zoomed together; a picture -> a dialog
//
// On paper the pictures stand; without this program too.

import uPlot from "uplot";
import { element } from "./dom.js";
import { enlarged } from "./enlarge.js";
import { Numbers } from "./numbers.js";
import { pinched } from "./pinch.js";
import { shownLength } from "./waves.js";

const dark = matchMedia("(prefers-color-scheme: dark)");
const HEIGHT = 190, NARROW = 560;

/** A colour that stands on a dark page: towards white. */
function onDark(colour) {
  const parts = [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
  return `#${parts.map((v) => Math.round(v + 0.45 * (255 - v)).toString(16).padStart(2, "0")).join("")}`;
}

/** The panels of one figure. */
class Figure {
  constructor(figure, given, numbers, first) {
    this.given = given; this.numbers = numbers; this.plots = [];
    this.box = element("div", { class: "charts" });
    if (given.mark) this.box.dataset.mark = given.mark;
    figure.prepend(this.box);
    if (first) figure.prepend(element("p", { class: "hint" }, "Drag across a chart to zoom it, double click for all of it; on a touch screen two fingers zoom and move it. A click enlarges a picture."));
    figure.classList.add("live");
    this.build();
    this.last();
    let width = this.box.clientWidth;
    new ResizeObserver(() => { if (this.box.clientWidth && this.box.clientWidth !== width) { width = this.box.clientWidth; this.build(); } }).observe(this.box);
    dark.addEventListener("change", () => this.build());
  }

  build() {
    const range = this.range;
    this.plots.forEach((plot) => plot.destroy());
    this.box.replaceChildren();
    let keys = "";
    this.plots = this.given.panels.map((panel, k) => {
      const own = panel.curves.filter((curve) => curve.label).map((curve) => `<i style="border-top:2.5px ${curve.dash.length ? "dashed" : "solid"} ${this.colour(curve)}"></i>`), labels = panel.curves.filter((curve) => curve.label);
      const text = JSON.stringify(labels.map((curve) => [curve.label, curve.colour]));
      this.box.append(element("p", { class: "ordinate" }, panel.label));
      if (labels.length > 1 && text !== keys) {
        keys = text;
        const legend = element("p", { class: "keys" });
        labels.forEach((curve, n) => { const key = element("span"); key.innerHTML = own[n]; key.append(curve.label); legend.append(key); });
        this.box.append(legend);
      }
      const holder = element("div", { class: "panel" });
      this.box.append(holder);
      return this.panel(panel, holder, k === this.given.panels.length - 1);
    });
    if (range) this.zoom(...range);
  }

  /** A long oscillation begins with its last waves, which is said. */
  last() {
    const shown = Math.max(...this.plots.map((plot) => shownLength(plot.data[0], plot.data[1], this.box.clientWidth - 60))), along = this.plots[0].data[0], end = along[along.length - 1];
    if (!shown) return;
    this.box.before(element("p", { class: "hint" }, `Shown first: the last ${shown.toPrecision(2)} of ${(end - along[0]).toPrecision(2)} ${/\[(.*)\]/.exec(this.given.x)?.[1] || ""}; double click for all.`));
    this.zoom(end - shown, end);
  }

  colour(curve) { return dark.matches ? onDark(curve.colour) : curve.colour; }

  panel(panel, holder, last) {
    const style = getComputedStyle(document.documentElement), text = style.getPropertyValue("--text").trim(), grid = style.getPropertyValue("--faint").trim();
    const columns = this.numbers.columns, tables = panel.curves.map((curve) => [columns.get(curve.x), Array.from(columns.get(curve.y), (v) => (v === v ? v : null))]);
    const one = panel.curves.every((curve) => curve.x === panel.curves[0].x);
    const data = one ? [tables[0][0], ...tables.map(([, y]) => y)] : uPlot.join(tables);
    const axis = { stroke: text, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid }, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif" };
    const plot = new uPlot({
      width: holder.clientWidth, height: (holder.clientWidth < NARROW ? 0.9 : 1) * HEIGHT + (last ? 18 : 0),
      series: [{}, ...panel.curves.map((curve) => ({ label: curve.label, stroke: this.colour(curve), dash: curve.dash.length ? curve.dash : undefined, width: 1.4, spanGaps: false, points: { show: false } }))],
      scales: { x: { time: false, range: (_, low, high) => this.range || [low, high] }, y: { range: (_, low, high) => spanned(panel, low, high) } },
      axes: [{ ...axis, label: last ? this.given.x : undefined, labelSize: 18, size: 28 }, { ...axis, size: (_, values) => 16 + 7 * Math.max(3, ...(values || []).map((value) => value.length)) }],
      legend: { show: false }, cursor: { drag: { x: true, y: false, setScale: false }, sync: { key: this.given.id }, points: { size: 6 } },
      hooks: {
        setSelect: [(u) => { if (u.select.width > 4) this.zoom(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")); u.setSelect({ width: 0, height: 0 }, false); }],
        draw: [(u) => levels(u, panel.levels, text)],
      },
    }, data, holder);
    plot.over.addEventListener("dblclick", () => this.zoom());
    pinched(plot, (low, high) => this.zoom(low, high));
    return plot;
  }

  /** All panels from `low` to `high`; without them all that there is. */
  zoom(low, high) {
    this.range = low < high ? [low, high] : undefined;
    for (const plot of this.plots) {
      const all = plot.data[0];
      plot.setScale("x", this.range ? { min: low, max: high } : { min: all[0], max: all[all.length - 1] });
    }
  }
}

/** The range of a panel: that of its picture where this cuts curves off; else a little more than they need, at least what the picture spans by choice. */
function spanned(panel, low, high) {
  if (panel.cut || low === null || high === null) return panel.range;
  const whole = panel.range[1] - panel.range[0], edge = 0.05 * (high - low), least = Math.max(0, panel.least - (high - low) - 2 * edge) / 2 || (high === low ? 0.05 * whole : 0);
  return [low - edge - least, high + edge + least];
}

/** Straight lines across a panel at an ordinate. */
function levels(u, list, colour) {
  const { ctx } = u, { left, width } = u.bbox;
  ctx.save();
  ctx.strokeStyle = colour; ctx.globalAlpha = 0.55; ctx.lineWidth = devicePixelRatio; ctx.setLineDash([5 * devicePixelRatio, 4 * devicePixelRatio]);
  for (const value of list) {
    const y = u.valToPos(value, "y", true);
    if (y < u.bbox.top || y > u.bbox.top + u.bbox.height) continue;
    ctx.beginPath(); ctx.moveTo(left, y); ctx.lineTo(left + width, y); ctx.stroke();
  }
  ctx.restore();
}

async function start() {
  document.querySelectorAll("figure img").forEach(enlarged);
  const charts = JSON.parse(document.getElementById("charts")?.textContent || "[]");
  window.figures = [];
  for (const given of charts) window.figures.push(new Figure(document.getElementById(given.id), given, await Numbers.of(`${given.id}-numbers`, given.columns), given === charts[0]));
  document.documentElement.dataset.drawn = "1";
}

start();
