// The page: scenes in, pictures and curves in step out.

import { Chart } from "./charts.js";
import { Clock } from "./clock.js";
import { THEMES } from "./colours.js";
import { button, element, slider } from "./dom.js";
import { honesty, legend } from "./legend.js";
import { Desk, LiveNumbers } from "./live.js";
import { modeChoice, modeNumbers, modePlots } from "./modes.js";
import { Numbers } from "./numbers.js";
import { drawSection } from "./section.js";
import { Stage } from "./stage.js";
import { World } from "./world.js";

const MODES = [["free", "whole", "1"], ["wheelset", "wheelset", "2"], ["track", "along the track", "3"], ["contact", "one contact", "4"]];

class Page {
  constructor(root, content, worlds) {
    this.content = content; this.worlds = worlds; this.modes = content.scenes[0].modes; this.live = content.scenes[0].live;
    this.options = { displacement: 1, patchFactor: 6, arrowFactor: 1, creepFactor: 3, patches: true, arrows: true, arrowUnit: 1 };
    this.wheel = 0;
    this.build(root);
    const end = Math.max(...worlds.map((w) => w.numbers.end));
    this.clock = new Clock(this.bar, end, end / Math.max(1, worlds[0].numbers.times.length - 1));
    this.stage = new Stage(this.canvas, worlds);
    if (this.modes) this.legend.hidden = true; else legend(this.legend, worlds);
    if (this.modes) this.clock.faster(-2);
    const events = { time: (t) => this.clock.set(t), range: (a, b) => this.clock.repeat([a, b]) };
    this.charts = this.wished().map((titles) => new Chart(this.plots, worlds, titles, events));
    this.resize(); this.setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    this.look("free");
    new ResizeObserver(() => this.resize()).observe(this.view);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (e) => this.setTheme(e.matches ? "dark" : "light"));
    addEventListener("keydown", (e) => this.key(e));
    this.last = performance.now();
    this.frames = 0;
    const loop = (now) => { this.tick(now); requestAnimationFrame(loop); };
    requestAnimationFrame(loop);
    if (this.live) this.runLive();
    else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.clock.toggle();
  }

  has(name) { return this.worlds.some((w) => w.numbers.has(name)); }

  /** What the two charts show at first, the first title that there is: in a test on adhesion how axles slide, else how the vehicle moves sideways. */
  wished() {
    if (this.modes) return [["Lateral displacement"], ["Yaw"]];
    return this.has("train_speed") ? [["Speed, at nominal radii"], ["Brake cylinder pressure", "Longitudinal sliding"]] : [["Lateral displacement", "Speed, at nominal radii"], ["Guiding force Y"]];
  }

  build(root) {
    this.canvas = element("canvas", { id: "canvas", tabindex: 0, "aria-label": "the vehicle in motion; drag turns, wheel or two fingers zoom" });
    this.labels = this.worlds.map((w, k) => element("div", { class: `name n${k}` }, w.head.label));
    this.note = element("div", { id: "note", role: "status" });
    this.caption = element("div", { class: "caption", role: "status" });
    this.legend = element("details", { class: "legend", open: innerWidth > 760 ? "" : undefined }, element("summary", {}, "colours"));
    this.sections = this.worlds.map((_, k) => element("canvas", { class: `section s${k}`, hidden: "" }));
    this.view = element("div", { class: "view" }, this.canvas, ...this.labels, this.note, this.caption, this.legend, ...this.sections);
    this.plots = element("div", { class: "plots" });
    this.bar = element("div", { class: "clock" });
    const modes = element("div", { class: "modes", role: "group", "aria-label": "camera" }, ...MODES.map(([mode, text, key]) => button(text, `camera: ${text} (${key})`, () => this.look(mode), `look-${mode}`)));
    this.wheelChoice = element("select", { id: "wheel", "aria-label": "wheel" });
    this.worlds[0].head.wheels.forEach((wheel, k) => this.wheelChoice.add(new Option(wheel.name.replaceAll("_", " "), k)));
    this.wheelChoice.addEventListener("change", () => { this.wheel = Number(this.wheelChoice.value); this.look(this.stage.mode === "contact" ? "contact" : "wheelset"); });
    const head = element("header", {}, element("h1", { title: this.worlds[0].head.title }, this.content.title), modes, this.wheelChoice,
      ...(this.content.scenes[0].modes ? modeChoice(this.content.scenes[0], (mode, speed) => this.chooseMode(mode, speed)) : []),
      button("⚙", "what is drawn (S)", () => this.panel.toggleAttribute("hidden"), "settings"), button("◐", "dark or light (T)", () => this.setTheme(this.theme === "dark" ? "light" : "dark"), "theme"));
    this.panel = this.settings();
    root.append(head, this.view, this.plots, this.bar, this.panel);
  }

  settings() {
    const set = (name) => (value) => { this.options[name] = value; this.refresh(); };
    const box = (text, name) => { const input = element("input", { type: "checkbox", checked: "" }); input.addEventListener("change", () => set(name)(input.checked)); return element("label", {}, input, text); };
    const car = element("select", { id: "car", "aria-label": "car body" });
    for (const mode of ["ghost", "solid", "none"]) car.add(new Option(`car body: ${mode}`, mode));
    car.addEventListener("change", () => { this.worlds.forEach((w) => w.showCar(car.value)); this.stage.dirty = true; });
    return element("div", { class: "panel", hidden: "" },
      slider("displacements ×", 0, 100, 1, 0, (v) => `${factor(v)}`, (v) => set("displacement")(factor(v)), "displacement"),
      slider("patches ×", 0, 100, 1, 46, (v) => `${factor(v)}`, (v) => set("patchFactor")(factor(v)), "patch-size"),
      slider("arrows ×", 0.2, 4, 0.1, 1, (v) => v.toFixed(1), set("arrowFactor"), "arrow-size"),
      slider("creep force ×", 1, 20, 1, 3, (v) => v.toFixed(0), set("creepFactor"), "creep-size"),
      box("patches", "patches"), box("arrows", "arrows"), car,
      element("p", { class: "exact" }, this.live ? this.live.note : this.modes ? "Shapes are those of the linear modes." : honesty(this.worlds)),
      element("p", { class: "exact" }, "Keys: space play, ← → a frame (shift: ten), , . slower and faster, [ ] repeated range, 1 to 4 cameras, W next wheel, E displacements larger, S what is drawn, T dark or light. A click on a curve goes there; a drag repeats that range."));
  }

  /** A simulation that runs now: its desk in place of the clock. */
  runLive() {
    const world = this.worlds[0];
    this.desk = new Desk(world.head, world.numbers, { scene: () => this.anotherScene(), exhibited: (frame) => { this.options.displacement = frame.enlarged; this.caption.textContent = frame.caption; } });
    this.bar.replaceChildren(this.desk.node);
    this.resize();
  }

  /** The rollers have another radius: the vehicle is drawn anew, the camera stays. */
  async anotherScene() {
    const head = (await (await fetch("scene")).json()), old = this.worlds[0];
    head.plots = old.head.plots;
    const world = new World(head, old.numbers);
    world.contacts.slipLargest = old.contacts.slipLargest;
    this.stage.exchange(0, world);
    this.stage.theme(THEMES[this.theme]);
    this.refresh();
  }

  /** Another mode, or another speed. */
  chooseMode(mode, speed) {
    const world = this.worlds[0], { playing } = this.clock;
    world.numbers = modeNumbers(world.head, mode, speed);
    this.clock.bounded(world.numbers.end, playing);
    this.charts.forEach((chart, k) => chart.regroup(modePlots(world.head, world.numbers), k));
    this.refresh();
  }

  look(mode) {
    this.stage.look(mode, this.wheel);
    for (const [name] of MODES) document.getElementById(`look-${name}`).setAttribute("aria-pressed", String(name === mode));
    this.sections.forEach((canvas) => canvas.toggleAttribute("hidden", mode !== "contact"));
    this.view.classList.toggle("close", mode === "contact");
    this.options.arrowUnit = mode === "contact" ? 0.28 : 1;
    this.worlds.forEach((world) => world.glassWheels(mode === "contact"));
    this.refresh();
  }

  setTheme(name) {
    this.theme = name;
    document.documentElement.dataset.theme = name;
    this.stage.theme(THEMES[name]);
    this.charts.forEach((chart) => chart.build(THEMES[name]));
    this.refresh();
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.view;
    if (!w || !h || !this.stage) return;
    this.stage.resize(w, h);
    this.labels.forEach((label, k) => { const [x, , pw, ph] = this.stage.part(k); label.style.left = `${x + 12}px`; label.style.top = this.stage.stacked ? `${k * ph + 10}px` : "10px"; label.style.maxWidth = `${pw - 24}px`; });
    this.sections.forEach((canvas, k) => { const [x, , pw] = this.stage.part(k); canvas.style.left = this.stage.stacked ? `${(k * w) / 2}px` : `${x}px`; canvas.style.width = `${Math.min(this.stage.stacked ? w / 2 : pw, 400)}px`; });
    this.charts.forEach((chart) => chart.resize());
    this.refresh();
  }

  refresh() { if (this.clock) this.clock.dirty = true; }

  tick(now) {
    const passed = now - this.last;
    this.clock.advance(Math.min(0.25, passed / 1e3));
    this.last = now;
    this.keepUp(passed);
    if (this.clock.dirty || this.live) this.show();
    if (this.stage.dirty) { this.stage.render(); this.frames += 1; document.documentElement.dataset.drawn = "1"; }
  }

  /** A slow machine draws fewer pixels while the picture moves, all of them when it stands. What was slow at first is tried again, three times. */
  keepUp(passed) {
    const { stage } = this, calm = performance.now() - (this.changed || 0) > 2000;
    if (!this.clock.playing && !this.live) { this.slow = 0; if (stage.sharpness < 1) stage.setSharpness(1); return; }
    this.slow = 0.8 * (this.slow || 0) + 0.2 * Math.min(passed, 200);
    const sharpness = this.slow > 36 && stage.sharpness > 0.45 ? stage.sharpness * 0.75
      : this.slow < 24 && stage.sharpness < 1 && calm && (this.raised || 0) < 3 ? Math.min(1, stage.sharpness / 0.75) : 0;
    if (!sharpness) return;
    if (sharpness > stage.sharpness) this.raised = (this.raised || 0) + 1;
    stage.setSharpness(sharpness);
    this.slow = 28; this.changed = performance.now();
  }

  /** Everything at the clock's time. */
  show() {
    this.clock.dirty = false;
    const t = this.clock.time;
    for (const world of this.worlds) world.update(Math.min(t, world.numbers.end), this.options);
    this.stage.follow();
    if (!this.live) this.charts.forEach((chart) => chart.mark(t));
    else if (performance.now() - (this.charted || 0) > 200) { this.charted = performance.now(); this.charts.forEach((chart) => chart.renew()); }
    if (this.stage.mode === "contact") this.sections.forEach((canvas, k) => drawSection(canvas, this.worlds[k], Math.min(this.wheel, this.worlds[k].head.wheels.length - 1), THEMES[this.theme], this.worlds[k].head.wheels[this.wheel].name.replaceAll("_", " ")));
    const said = this.modes ? ["a mode has no size of its own: displacements are enlarged, growth and decay left out"] : [];
    if (this.options.displacement > 1) said.push(`displacements × ${this.options.displacement}: bodies seem to part and to overlap where they do not`);
    if (!this.modes && this.options.patches && this.options.patchFactor > 1) said.push(`patches × ${this.options.patchFactor}`);
    if (!this.modes && this.options.arrows && this.options.creepFactor > 1) said.push(`creep forces × ${this.options.creepFactor}`);
    this.note.textContent = said.join(" · ");
    this.stage.dirty = true;
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || (event.target.tagName === "SELECT" && event.key.startsWith("Arrow"))) return;
    if (this.live && " ,.[]lLArrowLeftArrowRightHomeEnd".includes(event.key)) return;
    const step = (event.shiftKey ? 10 : 1) * this.clock.step, c = this.clock;
    const actions = {
      " ": () => c.toggle(), ArrowLeft: () => c.set(c.time - step), ArrowRight: () => c.set(c.time + step), Home: () => c.set(c.first), End: () => c.set(c.last),
      ",": () => c.faster(-1), ".": () => c.faster(1), "[": () => c.limit(0), "]": () => c.limit(1), l: () => c.repeat(null),
      e: () => this.larger(), s: () => this.panel.toggleAttribute("hidden"), t: () => this.setTheme(this.theme === "dark" ? "light" : "dark"),
      w: () => { this.wheel = (this.wheel + 1) % this.worlds[0].head.wheels.length; this.wheelChoice.value = this.wheel; this.look(this.stage.mode); },
      ...Object.fromEntries(MODES.map(([mode, , key]) => [key, () => this.look(mode)])),
    };
    const action = actions[event.key] || actions[event.key.toLowerCase()];
    if (!action) return;
    if (event.target.tagName === "BUTTON" && event.key === " ") return;
    event.preventDefault();
    action();
  }

  larger() {
    const input = document.getElementById("displacement");
    input.value = Number(input.value) >= 100 ? 0 : Math.min(100, Number(input.value) + 35);
    input.dispatchEvent(new Event("input"));
  }
}

/** 0 to 100 of a slider -> 1 to 50. */
const factor = (v) => { const f = 50 ** (v / 100); return f < 10 ? Math.round(f) : 5 * Math.round(f / 5); };

async function start() {
  const content = JSON.parse(document.getElementById("scene").textContent), worlds = [];
  for (const [k, head] of content.scenes.entries()) {
    if (head.live) { worlds.push(new World(head, new LiveNumbers(head))); continue; }
    const numbers = head.modes ? modeNumbers(head, head.mode, head.speed) : await Numbers.of(`numbers${k}`, head.columns);
    if (head.modes) head.plots = modePlots(head, numbers).map(({ title, unit, curves }) => ({ title, unit, curves: curves[0] }));
    worlds.push(new World(head, numbers));
  }
  window.rollerrig = new Page(document.getElementById("view"), content, worlds);
}

start().catch((error) => {
  document.getElementById("view").textContent = `This page could not be drawn: ${error.message}. It needs WebGL and a browser of 2023 or later.`;
  throw error;
});
