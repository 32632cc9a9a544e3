// Colours: of slip (dark blue to yellow), of forces about their rest (blue, grey, red), and the two themes.

import { Color } from "three";

const SLIP = ["#30123b", "#4458cb", "#3aa2fc", "#1be5b5", "#a4fc3c", "#fbb938", "#e4460a", "#7a0403"].map((c) => new Color(c));
const FORCE = ["#2166ac", "#67a9cf", "#b8bec4", "#ef8a62", "#b2182b"].map((c) => new Color(c));

function along(colours, part, target) {
  const u = Math.min(1, Math.max(0, part)) * (colours.length - 1), k = Math.min(colours.length - 2, Math.floor(u));
  return target.copy(colours[k]).lerp(colours[k + 1], u - k);
}

/** Slip over the largest of the scale, 0 to 1; the lowest quarter is spread by a square root. */
export const slipColour = (part, target) => along(SLIP, Math.sqrt(Math.max(0, part)), target);
/** Force over the largest of the scale, -1 to 1. */
export const forceColour = (part, target) => along(FORCE, 0.5 + 0.5 * part, target);
export const slipCss = () => SLIP.map((c, k) => `#${c.getHexString()} ${(100 * (k / (SLIP.length - 1)) ** 2).toFixed(0)}%`).join(",");
export const forceCss = () => FORCE.map((c) => `#${c.getHexString()}`).join(",");

export const CURVES = ["#2a78d6", "#e4572e", "#2a9d4a", "#a05cc7", "#c78a00", "#00998f", "#c2477f", "#6b7280"];

export const THEMES = {
  light: { sky: "#eef2f6", ground: "#cfd6dc", ballast: "#b6b2aa", steel: "#c3c9cf", dark: "#59636e", frame: "#3f5d7d", car: "#8fb3d1", text: "#1c2733", grid: "#d4dbe2", hemisphere: 2.0 },
  dark: { sky: "#12181f", ground: "#232b33", ballast: "#37342f", steel: "#aeb6be", dark: "#48525c", frame: "#4f7399", car: "#5c86a8", text: "#dfe6ee", grid: "#2e3842", hemisphere: 1.5 },
};
