// Mode shapes: how the bodies of a mode move over some of its periods, as numbers over time like those of a run.

import { Numbers } from "./numbers.js";
import { element } from "./dom.js";

const PERIODS = 4, FRAMES = 40, REACH = 0.06;

/** Numbers of mode `mode` at speed number `speed`; the largest displacement is drawn with REACH metres. */
export function modeNumbers(head, mode, speed) {
  const one = head.modes[mode], frequency = one.frequency[speed] || 1, shape = one.shapes[speed];
  const count = PERIODS * FRAMES + 1, times = Float32Array.from({ length: count }, (_, k) => k / FRAMES / frequency);
  const columns = new Map([["time", times]]), scale = REACH * head.shapes.wheel_radius / 0.46;
  for (const [name, [amplitude, phase]] of Object.entries(shape)) {
    columns.set(name, Float32Array.from({ length: count }, (_, k) => scale * amplitude * Math.cos((2 * Math.PI * k) / FRAMES + phase)));
  }
  return new Numbers(columns);
}

/** Which curves a mode has. */
export function modePlots(head, numbers) {
  const curves = (way) => head.bodies.map((body, k) => [`b${k}.${way}`, body.name.replaceAll("_", " "), 1e3]).filter(([name]) => numbers.has(name));
  const groups = [["Lateral displacement", "lateral"], ["Yaw", "yaw"], ["Vertical displacement", "vertical"], ["Roll", "roll"], ["Longitudinal displacement", "longitudinal"], ["Pitch", "pitch"]];
  return groups.map(([title, way]) => ({ title, unit: "size arbitrary", curves: [curves(way)] })).filter((group) => group.curves[0].length)
    .sort((a, b) => size(numbers, b) - size(numbers, a));
}

const size = (numbers, group) => Math.max(...group.curves[0].map(([name]) => numbers.largest(name)));

const percent = (part) => `${(Math.round(1000 * (part || 0)) / 10 + 0).toFixed(1)} %`;

/** The two choices, and what the chosen mode is. */
export function modeChoice(head, changed) {
  const mode = element("select", { id: "mode", "aria-label": "mode" }), speed = element("select", { id: "speed", "aria-label": "speed" });
  head.speeds.forEach((v, k) => speed.add(new Option(`${Number(v.toPrecision(4))} km/h`, k)));
  speed.value = head.speed;
  const fill = () => {
    const chosen = mode.value || String(head.mode);
    mode.replaceChildren(...head.modes.map((one, k) => new Option(`${one.name}: ${(one.frequency[speed.value] || 0).toFixed(2)} Hz, damping ${percent(one.damping[speed.value])}`, k)));
    mode.value = chosen;
  };
  fill();
  const tell = () => { fill(); changed(Number(mode.value), Number(speed.value)); };
  mode.addEventListener("change", tell);
  speed.addEventListener("change", tell);
  return [mode, speed];
}
