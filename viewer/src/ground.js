// What stands still or passes by: rails on sleepers along the line, or the pit of a rig with the bearings of its rollers.

import { BoxGeometry, CylinderGeometry, Group, InstancedMesh, Matrix4, Mesh } from "three";
import { extruded, railSection } from "./lathe.js";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";

const CHUNK = 40, STEP = 2, SLEEPERS = 140, SPACING = 0.6;

/** Whether a line does not turn from an arc length on over a chunk: two cross-sections are enough then. */
function straight(line, s) {
  const first = line.frame(s, new Matrix4()), e = [0.25, 0.5, 0.75, 1].map((part) => line.frame(Math.min(line.to, s + part * CHUNK), new Matrix4()).elements);
  return e.every((one) => one.every((value, k) => k > 11 || Math.abs(value - first.elements[k]) < 1e-6));
}

/** Rails, sleepers and ballast; in the world's axes, `root` is moved so that the vehicle is near the origin. */
export class Track {
  constructor(line, shapes, unit, materials) {
    this.line = line; this.root = new Group(); this.unit = unit;
    const section = railSection(shapes), m = new Matrix4(), side = new Matrix4();
    for (let s = line.from; s < line.to - 1e-6; s += CHUNK) {
      const middle = line.frame(s + CHUNK / 2), origin = new Matrix4().copyPosition(middle), back = origin.clone().invert();
      const left = [], right = [], bed = [];
      const step = straight(line, s) ? CHUNK : STEP;
      for (let k = 0; k <= CHUNK / step; k++) {
        line.frame(Math.min(line.to, s + k * step), m).premultiply(back);
        left.push(m.clone().multiply(side.makeTranslation(0, shapes.rail_origin, 0)));
        right.push(m.clone().multiply(side.makeTranslation(0, -shapes.rail_origin, 0)));
        bed.push(m.clone());
      }
      const mirrored = section.map(([y, z]) => [-y, z]).reverse();
      const rails = new Mesh(mergeGeometries([extruded(section, left), extruded(mirrored, right)]), materials.rail);
      const w = shapes.gauge / 1.435;
      const ballast = new Mesh(extruded([[-1.6 * w, -0.26], [-2.6 * w, -0.75], [2.6 * w, -0.75], [1.6 * w, -0.26]], bed), materials.ballast);
      for (const mesh of [rails, ballast]) { mesh.position.setFromMatrixPosition(origin); this.root.add(mesh); }
    }
    this.sleepers = new InstancedMesh(new BoxGeometry(0.26, 2.6 * shapes.gauge / 1.435, 0.2), materials.sleeper, SLEEPERS);
    this.sleepers.frustumCulled = false;
    this.root.add(this.sleepers);
    this.m = m;
  }

  /** Sleepers around an arc length. */
  update(s) {
    const first = Math.round(s / SPACING) - SLEEPERS / 2;
    if (first === this.first) return;
    this.first = first;
    const down = new Matrix4().makeTranslation(0, 0, -0.28);
    for (let k = 0; k < SLEEPERS; k++) this.sleepers.setMatrixAt(k, this.line.frame((first + k) * SPACING, this.m).multiply(down));
    this.sleepers.instanceMatrix.needsUpdate = true;
  }
}

/** The floor under the rollers, and a pedestal on either side of each. */
export function rig(bodies, shapes, materials) {
  const root = new Group(), R = shapes.roller_radius, floor = -2 * R - 0.12 * R;
  const rollers = bodies.filter((body) => body.table.kind === "roller"), xs = rollers.map((body) => body.table.at[0]);
  const x0 = Math.min(...xs) - 3 * R, x1 = Math.max(...xs) + 3 * R;
  const slab = new Mesh(new BoxGeometry(x1 - x0, 6.4 * R + shapes.gauge, 0.08 * R).translate((x0 + x1) / 2, 0, floor - 0.04 * R), materials.ballast);
  root.add(slab);
  for (const body of rollers) {
    const ys = [];
    if (body.table.sides.includes("left")) ys.push(shapes.rail_origin + 0.38 * R);
    if (body.table.sides.includes("right")) ys.push(-shapes.rail_origin - 0.38 * R);
    for (const y of ys) {
      const block = new BoxGeometry(0.42 * R, 0.16 * R, R * 1.12).translate(body.table.at[0], y, floor + 0.56 * R);
      const cap = new CylinderGeometry(0.21 * R, 0.21 * R, 0.16 * R, 24).translate(body.table.at[0], y, -R);
      root.add(new Mesh(mergeGeometries([block, cap]), materials.pedestal));
    }
  }
  return root;
}
