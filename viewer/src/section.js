// The close-up of one contact: cross-section of the wheel on its roller or rail with patch and pressure, and the patch from above.

import { Color } from "three";
import { slipColour } from "./colours.js";

const HALF = 0.047, INWARD = 0.008, colour = new Color();

/** Draws into a canvas of width x height pixels of the page. */
export function drawSection(canvas, world, wheel, theme, title) {
  const ratio = Math.min(2, window.devicePixelRatio || 1), w = canvas.clientWidth, h = canvas.clientHeight;
  if (!w || !h) return;
  canvas.width = Math.round(w * ratio); canvas.height = Math.round(h * ratio);
  const g = canvas.getContext("2d"), n = world.numbers, { shapes, wheels } = world.head, u = world.unit;
  const side = wheels[wheel].side, body = world.bodies[wheels[wheel].body], name = `w${wheel}`;
  const [, lateral, vertical, roll] = body.shift, support = body.supports[side > 0 ? 0 : 1];
  const railY = side * shapes.rail_origin + (n.at(`${name}.rail_lateral`) || 0) + (support ? support.shift[1] + support.shift[3] * support.rest.z : 0);  // of a rail that rolls, its head
  const railZ = (n.at(`${name}.rail_vertical`) || 0) + (support ? support.shift[2] : 0);
  const scale = (w / 2) / (HALF * u), cx = w / 2, cy = 0.46 * h;
  const X = (y) => cx - (y - side * (shapes.rail_origin - INWARD * u)) * scale, Z = (z) => cy - z * scale;
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, w, h);
  const rail = shapes.rail.map(([y, z]) => [railY + side * y, railZ + z]);
  const profile = shapes.wheel.map(([s, up]) => {
    const y = side * (shapes.tape_circle + s), z = -(shapes.wheel_radius + up);
    return [lateral + y * Math.cos(roll) - z * Math.sin(roll), body.rest.z + vertical + y * Math.sin(roll) + z * Math.cos(roll)];
  });
  area(g, rail, X, Z, h + 20, theme.dark, 0.55);
  area(g, profile, X, Z, -20, theme.steel, 0.75);
  g.lineWidth = 1.4; g.strokeStyle = theme.text;
  for (const curve of [rail, profile]) { g.beginPath(); curve.forEach(([y, z], k) => (k ? g.lineTo(X(y), Z(z)) : g.moveTo(X(y), Z(z)))); g.stroke(); }
  g.fillStyle = theme.text; g.font = "12px system-ui, sans-serif"; g.textAlign = "left";
  word(g, title, 10, 18, theme);
  word(g, world.track ? "rail" : "roller", 10, h - 10, theme);
  word(g, "wheel", 10, 36, theme);
  scaleBar(g, w, h, scale, u, theme);
  for (let p = 0; p < world.head.patches; p++) drawPatch(g, world, name, p, side, support, X, Z, theme, w, h);
}

function area(g, curve, X, Z, edge, fill, alpha) {
  g.beginPath();
  curve.forEach(([y, z], k) => (k ? g.lineTo(X(y), Z(z)) : g.moveTo(X(y), Z(z))));
  g.lineTo(X(curve.at(-1)[0]), edge); g.lineTo(X(curve[0][0]), edge); g.closePath();
  g.globalAlpha = alpha; g.fillStyle = fill; g.fill(); g.globalAlpha = 1;
}

function scaleBar(g, w, h, scale, u, theme) {
  const length = 0.01 * u * scale;
  g.fillRect(w - 12 - length, h - 14, length, 2);
  g.textAlign = "right"; word(g, `${(10 * u).toPrecision(2)} mm`, w - 12, h - 20, theme); g.textAlign = "left";
}

function drawPatch(g, world, name, p, side, support, X, Z, theme, w, h) {
  const n = world.numbers, of = (key) => n.at(`${name}.p${p}.${key}`), normal = of("normal");
  if (!(normal > 0) || !(of("y") === of("y"))) return;
  const angle = -side * of("contact_angle"), width = of("width"), peak = of("peak_pressure");
  const y = of("y") + (support ? support.shift[1] : 0) + (n.at(`${name}.rail_lateral`) || 0), z = of("z") + (support ? support.shift[2] : 0) + (n.at(`${name}.rail_vertical`) || 0);
  const slip = Math.hypot(of("sliding_x"), of("sliding_y")), css = `#${slipColour(slip / world.contacts.slipLargest, colour).getHexString()}`;
  const x0 = X(y), z0 = Z(z), half = Math.abs(X(width / 2) - X(0)), height = Math.min(90, 60 * peak / 1.2e9);
  g.save();
  g.translate(x0, z0); g.rotate(angle);
  g.beginPath(); g.ellipse(0, 0, half, height, 0, Math.PI, 2 * Math.PI); g.closePath();
  g.globalAlpha = 0.5; g.fillStyle = "#ff8a1f"; g.fill(); g.globalAlpha = 1; g.strokeStyle = "#ff8a1f"; g.lineWidth = 1.6; g.stroke();
  g.fillStyle = css; g.fillRect(-half, -2, 2 * half, 4);
  g.restore();
  g.fillStyle = theme.text; g.textAlign = "center";
  word(g, `${(peak / 1e6).toFixed(0)} MPa`, x0, z0 - height - 8, theme);
  fromAbove(g, of, p, css, side, theme, w, h, world.unit, slip, normal);
}

/** The patch in its plane, x upwards on the page, with slip and creep force on the wheel. */
function fromAbove(g, of, p, css, side, theme, w, h, u, slip, normal) {
  const scale = Math.min(w, h) / (0.1 * u), cx = w * (0.5 + 0.3 * (p - 0.0)) - 0, cy = h * 0.8;
  g.save();
  g.translate(cx, cy);
  g.beginPath(); g.ellipse(0, 0, of("b") * scale, of("a") * scale, 0, 0, 2 * Math.PI);
  g.fillStyle = css; g.globalAlpha = 0.85; g.fill(); g.globalAlpha = 1; g.strokeStyle = theme.text; g.lineWidth = 1; g.stroke();
  const fx = of("creep_force_x"), fy = of("creep_force_y"), k = 46 / Math.max(1, 0.35 * normal);
  arrow(g, -fy * k, -fx * k, "#ff8a1f");
  g.fillStyle = theme.text; g.textAlign = "left"; g.font = "11px system-ui, sans-serif";
  const x = 0.012 * u * scale + 8;
  word(g, `N ${(normal / 1e3).toFixed(1)} kN`, x, -14, theme);
  word(g, `creep force ${(Math.hypot(fx, fy) / 1e3).toFixed(2)} kN`, x, 0, theme);
  word(g, `slip ${slip < 0.1 ? `${(1e3 * slip).toFixed(1)} mm/s` : `${slip.toFixed(2)} m/s`}`, x, 14, theme);
  g.restore();
}

/** Text that can be read over lines. */
function word(g, text, x, y, theme) {
  g.save();
  g.strokeStyle = theme.sky; g.lineWidth = 3; g.lineJoin = "round"; g.globalAlpha = 0.75; g.strokeText(text, x, y);
  g.restore();
  g.fillText(text, x, y);
}

function arrow(g, x, y, fill) {
  const length = Math.hypot(x, y);
  if (length < 2) return;
  g.strokeStyle = g.fillStyle = fill; g.lineWidth = 3;
  g.beginPath(); g.moveTo(0, 0); g.lineTo(x, y); g.stroke();
  const ux = x / length, uy = y / length;
  g.beginPath(); g.moveTo(x + 7 * ux, y + 7 * uy); g.lineTo(x - 5 * uy, y + 5 * ux); g.lineTo(x + 5 * uy, y - 5 * ux); g.fill();
}
