// Wheels, rollers and rails from their profiles.
//
// Bodies of revolution turn about y, as three's LatheGeometry does. A sharp edge is where two pieces meet, so that each has its own normals.

import { BufferGeometry, CylinderGeometry, Float32BufferAttribute, LatheGeometry, Vector2 } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { drawnBySoftware } from "./surfaces.js";

/** Fewer points of a profile: what leaves a chord by less than `flat` [m] is not seen from where a whole wheel is. */
function coarse(points, flat) {
  const kept = [points[0]];
  for (let i = 0; i < points.length - 1; ) {
    let j = i + 1;
    while (j + 1 < points.length && points.slice(i + 1, j + 1).every((p) => off(p, points[i], points[j + 1]) < flat)) j += 1;
    kept.push(points[j]);
    i = j;
  }
  return kept;
}

function off([x, y], [ax, ay], [bx, by]) {
  return Math.abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / (Math.hypot(bx - ax, by - ay) || 1);
}

/** By software every corner of a triangle counts: fewer along a profile [m] and round a turn. */
const flat = () => (drawnBySoftware() ? 6e-4 : 2.5e-4);
const lathe = (points, segments) => new LatheGeometry(points.map(([r, y]) => new Vector2(r, y)), drawnBySoftware() ? Math.round(0.7 * segments) : segments);

/** A cylinder about y from y0 to y1. */
export function shaft(radius, y0, y1, segments = 24) {
  return new CylinderGeometry(radius, radius, Math.abs(y1 - y0), segments).translate(0, (y0 + y1) / 2, 0);
}

function pieces(corners, segments) {
  return corners.slice(1).map((corner, k) => lathe([corners[k], corner], segments));
}

/** The part that rolls, for the left side; `side` -1 mirrors it. */
function revolve(running, inner, side, segments) {
  const parts = [running, ...inner].map((list) => list.map(([r, y]) => [r, side * y]));
  if (side > 0) parts.forEach((list) => list.reverse());
  return mergeGeometries([lathe(parts[0], segments), ...parts.slice(1).flatMap((list) => pieces(list, segments))]);
}

/** A wheel with web and hub, about the axle; profile: abscissa from the tape circle outward, increase of radius. */
export function wheelGeometry(shapes, side, segments = 56) {
  const R = shapes.wheel_radius, tape = shapes.tape_circle;
  const running = coarse(shapes.wheel, flat()).map(([s, up]) => [R + up, tape + s]);
  const back = shapes.back_to_back / 2, face = running[running.length - 1][1], rim = 0.86 * R;
  const middle = (back + face) / 2, web = 0.03 * R, hub = 0.29 * R, bore = 0.18 * R;
  const inside = [[running[0][0], running[0][1]], [rim, Math.min(back, running[0][1])], [rim - 0.03 * R, middle - web], [hub, middle - 1.6 * web], [hub, back + 0.01 * R], [bore, back + 0.01 * R]];
  const outside = [[bore, face - 0.02 * R], [hub, face - 0.02 * R], [hub, middle + 1.6 * web], [rim - 0.03 * R, middle + web], [rim, face], [running[running.length - 1][0], face]];
  return revolve(running.slice().reverse(), [inside, outside], side, segments);
}

/** A roller of a rig: the rail head bent round. */
export function rollerGeometry(shapes, side, segments = 72) {
  const R = shapes.roller_radius, at = shapes.rail_origin;
  const running = coarse(shapes.rail, flat()).map(([y, h]) => [R + h, at + y]);
  const first = running[0], last = running[running.length - 1], rim = 0.88 * R, web = 0.03 * R, hub = 0.24 * R, bore = 0.12 * R;
  const inside = [first, [rim, first[1] - 0.004], [rim - 0.02 * R, at - web], [hub, at - web], [hub, at - 0.16 * R], [bore, at - 0.16 * R]];
  const outside = [[bore, at + 0.16 * R], [hub, at + 0.16 * R], [hub, at + web], [rim - 0.02 * R, at + web], [rim, last[1] + 0.004], last];
  return revolve(running.slice().reverse(), [inside, outside], side, segments);
}

/** Cross-section of the left rail: its head, and a web and a foot below it, which no case gives. (y outward, z) */
export function railSection(shapes) {
  const head = coarse(shapes.rail, 4e-4), gauge = head[0], field = head[head.length - 1], low = Math.min(gauge[1], field[1]) - 0.012;
  return [...head, [field[0], low], [0.009, low - 0.016], [0.008, -0.14], [0.07, -0.16], [0.075, -0.172], [-0.075, -0.172], [-0.07, -0.16], [-0.008, -0.14], [-0.009, low - 0.016], [gauge[0], low]];
}

/** A cross-section (y, z) drawn along places, each a matrix. */
export function extruded(section, matrices) {
  const positions = [], index = [], n = section.length;
  const point = { x: 0, y: 0, z: 0 };
  for (const m of matrices) for (let k = 0; k < n; k++) for (const [y, z] of [section[k], section[(k + 1) % n]]) {
    const e = m.elements;
    point.x = e[4] * y + e[8] * z + e[12]; point.y = e[5] * y + e[9] * z + e[13]; point.z = e[6] * y + e[10] * z + e[14];
    positions.push(point.x, point.y, point.z);
  }
  for (let i = 0; i + 1 < matrices.length; i++) for (let k = 0; k < n; k++) {
    const a = 2 * (i * n + k), b = a + 1, c = 2 * ((i + 1) * n + k), d = c + 1;
    index.push(a, b, c, b, d, c);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setIndex(index);
  geometry.computeVertexNormals();
  return geometry;
}
