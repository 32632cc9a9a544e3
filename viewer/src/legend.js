// What the colours and arrows mean, and what the picture is not: exaggerated, thinned, schematic.

import { forceCss, slipCss } from "./colours.js";
import { element } from "./dom.js";

const scale = (name, css, left, right) => element("div", { class: "scale" }, element("span", {}, name), element("i", { style: `background:linear-gradient(90deg,${css})` }), element("small", {}, element("b", {}, left), element("b", {}, right)));

export function legend(holder, worlds) {
  const slip = Math.max(...worlds.map((w) => w.contacts.slipLargest)), force = Math.max(...worlds.map((w) => w.elements.forces));
  for (const world of worlds) { world.contacts.slipLargest = slip; world.elements.forces = force; }
  holder.append(
    scale("slip in the patches", slipCss(), "0", slip < 0.1 ? `${(1e3 * slip).toPrecision(2)} mm/s` : `${slip.toPrecision(2)} m/s`),
    scale("springs and dampers: force over the start", forceCss(), `−${(force / 1e3).toPrecision(2)}`, `+${(force / 1e3).toPrecision(2)} kN`),
    element("div", { class: "arrows" }, element("span", { class: "blue" }, "contact force"), element("span", { class: "orange" }, "creep force, on the wheel")),
  );
}

/** What the page says of its own exactness. */
export function honesty(worlds) {
  return worlds.map(({ head }) => {
    const e = head.errors, lost = head.frames < head.samples;
    const thinned = lost ? `${head.frames} of ${head.samples} samples; between them the curve is off by at most ${e.position_mm.toPrecision(2)} mm, ${e.angle_mrad.toPrecision(2)} mrad and ${e.force_kn.toPrecision(2)} kN` : `all ${head.samples} samples`;
    return `${head.label}: ${thinned}. `;
  }).join("") + "Numbers have 16 bits of their range. Frames, car bodies, coils and motors are schematic; wheels, rollers and rails have the profiles of the case. All data: the NetCDF file of the run.";
}
