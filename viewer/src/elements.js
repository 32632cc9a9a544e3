// Springs, dampers, rods, stops and bars between the bodies, coloured by the force over that at the first sample.
//
// Each is drawn from its end on one body to its end on the other. Where a case gives one point for both, the ends are drawn apart
// along the direction of the force, so that there is something to be seen.

import { BoxGeometry, CatmullRomCurve3, Color, Group, Mesh, Quaternion, TubeGeometry, Vector3 } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { forceColour } from "./colours.js";
import { shaft } from "./lathe.js";
import { dull } from "./surfaces.js";

const UP = new Vector3(0, 1, 0), AXIS = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], roll: [0, 1, 0], pitch: [0, 1, 0], yaw: [1, 0, 0] };

/** A coil of length 1 along y. */
function coil(radius, wire, turns) {
  const points = [];
  for (let k = 0; k <= turns * 10; k++) {
    const u = k / (turns * 10), angle = 2 * Math.PI * turns * u;
    points.push(new Vector3(radius * Math.cos(angle), u, radius * Math.sin(angle)));
  }
  return new TubeGeometry(new CatmullRomCurve3(points), turns * 12, wire, 5);
}

const GEOMETRY = {
  spring: (u, main) => [coil((main ? 0.11 : 0.085) * u, 0.02 * u, 5)],
  damper: (u) => [shaft(0.05 * u, 0, 0.62, 16), shaft(0.028 * u, 0.5, 1, 12)],
  rod: (u) => [shaft(0.03 * u, 0, 1, 12)],
  stop: (u) => [shaft(0.06 * u, 0.1, 0.9, 16)],
  bar: (u) => [shaft(0.025 * u, 0, 1, 12)],
};

class Element {
  constructor(table, bodies, unit, group) {
    this.table = table;
    this.bodies = table.bodies.map((k) => bodies[k]);
    this.material = dull();
    this.mesh = new Group();
    const main = table.carries && !this.bodies.some((body) => body.table.kind === "wheelset");
    this.mesh.add(new Mesh(mergeGeometries(GEOMETRY[table.kind](unit, main)), this.material));
    group.add(this.mesh);
    this.ends = spread(table, this.bodies, unit, main);
    this.from = new Vector3(); this.to = new Vector3(); this.turn = new Quaternion();
  }

  update(numbers, scale) {
    this.bodies[0].point(this.ends[0], this.from);
    this.bodies[1].point(this.ends[1], this.to);
    const along = this.to.sub(this.from), length = along.length() || 1e-6;
    this.mesh.position.copy(this.from);
    this.mesh.quaternion.copy(this.turn.setFromUnitVectors(UP, along.divideScalar(length)));
    this.mesh.scale.set(1, length, 1);
    this.force = numbers.at(`e${this.table.number}`);
    forceColour(this.force / (scale || 1), this.material.color);
  }
}

/** Ends relative to the bodies, drawn apart where they coincide. */
function spread(table, bodies, unit, main) {
  const ends = table.ends.map((end) => new Vector3(...end));
  const world = ends.map((end, k) => end.clone().add(new Vector3(...bodies[k].table.at)));
  if (world[0].distanceTo(world[1]) > 0.05 * unit) return ends;
  const axis = new Vector3(...AXIS[table.direction]), upper = bodies[0].table.at[2] > bodies[1].table.at[2] ? 0 : 1;
  if (table.direction === "z") {
    const [above, below] = main ? [0.3, -0.3] : [0.36, 0.06];
    ends[upper].z += above * unit; ends[1 - upper].z += below * unit;
    return ends;
  }
  const half = (table.kind === "bar" ? 0.75 : table.kind === "rod" ? 0.35 : 0.22) * unit;
  const way = table.direction === "y" && ends[1].y !== 0 ? Math.sign(ends[1].y) : 1;
  ends[0].addScaledVector(axis, -way * half); ends[1].addScaledVector(axis, way * half);
  if (table.kind === "bar") { ends[0].z -= 0.12 * unit; ends[1].z -= 0.12 * unit; }
  if (table.kind === "rod") { ends[0].z -= 0.05 * unit; ends[1].z -= 0.05 * unit; }
  return ends;
}

/** Brake callipers and motors of the axles, coloured by cylinder pressure and torque. */
class AxlePart {
  constructor(geometry, holder, at, column, group) {
    this.material = dull();
    this.mesh = new Mesh(geometry, this.material);
    this.holder = holder; this.at = at; this.column = column;
    group.add(this.mesh);
  }

  update(numbers, largest, theme) {
    this.holder.point(this.at, this.mesh.position);
    this.mesh.quaternion.copy(this.holder.node.quaternion);
    const part = numbers.at(this.column) / (largest || 1);
    if (this.column.endsWith("pressure")) this.material.color.set(theme.dark).lerp(HOT, Math.max(0, part));
    else forceColour(part, this.material.color);
  }
}
const HOT = new Color("#ff5a1f");

export class Elements {
  constructor(head, bodies, unit, group, numbers) {
    this.list = head.elements.map((table) => new Element(table, bodies, unit, group));
    this.forces = Math.max(1, ...this.list.filter((e) => "xyz".includes(e.table.direction)).map((e) => e.table.largest));
    this.moments = Math.max(1, ...this.list.filter((e) => !"xyz".includes(e.table.direction)).map((e) => e.table.largest));
    this.parts = axleParts(head, bodies, group, numbers);
  }

  update(numbers, theme) {
    for (const element of this.list) element.update(numbers, "xyz".includes(element.table.direction) ? this.forces : this.moments);
    for (const { part, largest } of this.parts) part.update(numbers, largest, theme);
  }
}

function axleParts(head, bodies, group, numbers) {
  const found = [], R = head.shapes.wheel_radius, largest = {};
  const add = (geometry, holder, at, axle, name) => {
    const column = `a${axle}.${name}`;
    if (!numbers.has(column)) return;
    largest[name] = Math.max(largest[name] || 0, numbers.largest(column));
    found.push({ name, part: new AxlePart(geometry, holder, at, column, group) });
  };
  head.axles.forEach((name, axle) => {
    const set = bodies.find((body) => body.table.name === name);
    const holder = bodies.find((body) => head.elements.some((e) => e.carries && e.bodies.includes(bodies.indexOf(body)) && e.bodies.includes(bodies.indexOf(set)) && body !== set));
    if (!holder) return;
    const at = new Vector3(...set.table.at).sub(new Vector3(...holder.table.at)), way = at.x > 0 ? -1 : 1;
    if (head.brakes) for (const y of [-0.55 * R, 0.55 * R]) add(new BoxGeometry(0.34 * R, 0.2 * R, 0.34 * R), holder, at.clone().add(new Vector3(way * 0.6 * R, y, 0.12 * R)), axle, "cylinder_pressure");
    if (head.motors) add(shaft(0.42 * R, -0.32 * R, 0.32 * R, 32), holder, at.clone().add(new Vector3(way * 1.1 * R, 0, 0.1 * R)), axle, "traction_torque");
    bodies.filter((body) => body.table.kind === "roller" && body.table.at[0] === set.table.at[0]).forEach((roller) => {
      for (const side of roller.table.sides) {
        if (roller.table.sides.length > 1 && side === "right") continue;
        const y = (side === "left" ? 1 : -1) * (head.shapes.rail_origin + 0.95 * head.shapes.roller_radius) - roller.table.at[1];
        const motor = { point: (v, target) => target.copy(v).add(roller.rest), node: roller.still };
        add(shaft(0.38 * head.shapes.roller_radius, -0.3 * head.shapes.roller_radius, 0.3 * head.shapes.roller_radius, 32), motor, new Vector3(0, y, 0), axle, "roller_torque");
      }
    });
  });
  return found.map(({ name, part }) => ({ part, largest: largest[name] }));
}
