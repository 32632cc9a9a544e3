// One run in space: its bodies where they are at a time, what joins them, what they stand on.

import { BoxGeometry, Group, LineBasicMaterial, Matrix4, Mesh, Object3D, Quaternion, Vector3, DoubleSide } from "three";
import { carBody, frame, roller, wheelset } from "./bodies.js";
import { Contacts } from "./contacts.js";
import { Elements } from "./elements.js";
import { rig, Track } from "./ground.js";
import { Line } from "./line.js";
import { dull, polished } from "./surfaces.js";

const X = new Vector3(1, 0, 0), Y = new Vector3(0, 1, 0), Z = new Vector3(0, 0, 1);

function materialsOf() {
  return {
    steel: polished(70, "#777777"), roller: polished(50, "#666666"),
    axle: dull(), dark: dull(), mark: dull({ color: "#e8a33d" }), disc: dull(), frame: dull(), pedestal: dull(),
    rail: dull({ side: DoubleSide }), ballast: dull({ side: DoubleSide }), sleeper: dull(),
    car: dull({ transparent: true, opacity: 0.18, depthWrite: false }), carLine: new LineBasicMaterial({ transparent: true, opacity: 0.45 }),
  };
}

/** A body: its node, the part of it that spins, and points of it in the vehicle's axes. */
class Body {
  constructor(table, number, head, unit, materials) {
    this.table = table; this.number = number;
    this.node = new Object3D(); this.spin = new Group(); this.still = new Object3D();
    this.rest = new Vector3(...table.at);
    this.node.add(this.spin);
    this.node.position.copy(this.rest);
    this.spins = table.kind === "wheelset" || table.kind === "roller";
    this.spin.add(this.shape(head, unit, materials));
    if (table.kind === "wheelset") for (const side of [1, -1]) {
      const box = new Mesh(new BoxGeometry(0.3 * unit, 0.2 * unit, 0.26 * unit), materials.dark);
      box.position.y = side * (head.shapes.tape_circle + 0.25 * unit);
      this.node.add(box);
    }
    this.turn = new Quaternion(); this.offset = new Vector3(); this.line = new Object3D();
  }

  shape(head, unit, materials) {
    switch (this.table.kind) {
      case "wheelset": return wheelset(head.shapes, materials, head.brakes);
      case "roller": return roller(head.shapes, this.table.sides, materials);
      case "frame": return frame(this.table, unit, materials);
      case "car body": return carBody(this.table, unit, materials);
      default: return new Group();
    }
  }

  /** Displacements, larger by a factor; never the spin. */
  update(numbers, factor) {
    const of = (name) => numbers.at(`b${this.number}.${name}`);
    this.shift = [of("longitudinal"), of("lateral"), of("vertical"), of("roll"), of("yaw")];
    this.offset.set(factor * this.shift[0], factor * this.shift[1], factor * this.shift[2]);
    this.node.position.copy(this.rest).add(this.offset);
    this.node.quaternion.setFromAxisAngle(Z, factor * this.shift[4]).multiply(this.turn.setFromAxisAngle(X, factor * this.shift[3]));
    const pitch = of("pitch");
    if (this.spins) this.spin.quaternion.setFromAxisAngle(Y, pitch % (2 * Math.PI));
    else this.node.quaternion.multiply(this.turn.setFromAxisAngle(Y, factor * pitch));
  }

  point(relative, target) { return target.copy(relative).applyQuaternion(this.node.quaternion).add(this.node.position); }

  /** Where the crown or top of rail below a side is: in the middle of the wheelset's design position, moved as what lies there. */
  under(side, target) {
    const support = this.supports[side > 0 ? 0 : 1];
    target.set(this.rest.x, 0, 0);
    return support ? target.add(support.offset) : target;
  }
}

export class World {
  constructor(head, numbers, themes) {
    this.head = head; this.numbers = numbers;
    this.unit = head.shapes.wheel_radius / 0.46;
    this.materials = materialsOf();
    this.root = new Group(); this.vehicle = new Group();
    this.root.add(this.vehicle);
    this.bodies = head.bodies.map((table, k) => new Body(table, k, head, this.unit, this.materials));
    for (const body of this.bodies) { this.vehicle.add(body.node); body.supports = this.supportsOf(body); }
    this.elements = new Elements(head, this.bodies, this.unit, this.vehicle, numbers);
    this.contacts = new Contacts(head, this.bodies, this.unit, this.vehicle, numbers);
    this.line = head.line ? new Line(head.line) : null;
    this.track = this.line ? new Track(this.line, head.shapes, this.unit, this.materials) : null;
    this.ground = this.track ? this.track.root : rig(this.bodies, head.shapes, this.materials);
    this.ground.matrixAutoUpdate = !this.track;
    this.root.add(this.ground);
    this.away = new Matrix4(); this.own = new Matrix4(); this.design = new Matrix4();
  }

  supportsOf(body) {
    const number = body.table.name.replace("wheelset_", "");
    return ["left", "right"].map((side) => this.bodies.find((other) => [`roller_${number}`, `roller_${number}_${side}`, `rail_${number}_${side}`].includes(other.table.name)));
  }

  theme(theme) {
    const m = this.materials;
    m.steel.color.set(theme.steel); m.roller.color.set(theme.steel).lerp(m.roller.color.clone().set("#5f7fa3"), 0.35); m.axle.color.set(theme.dark).lerp(m.steel.color, 0.4);
    m.dark.color.set(theme.dark); m.disc.color.set("#8b6f5a"); m.frame.color.set(theme.frame); m.car.color.set(theme.car); m.carLine.color.set(theme.car);
    m.rail.color.set(theme.steel).multiplyScalar(0.8); m.ballast.color.set(theme.ballast); m.sleeper.color.set(theme.ballast).multiplyScalar(0.72); m.pedestal.color.set(theme.dark).lerp(m.steel.color, 0.25);
    this.colours = theme;
  }

  /** Everything at a time [s]. The vehicle's reference point stays at the origin; the line passes under it. */
  update(time, options) {
    const n = this.numbers;
    n.seek(time);
    for (const body of this.bodies) body.update(n, options.displacement);
    if (this.track) this.onLine(n.at("distance"));
    this.elements.update(n, this.colours);
    this.contacts.update(n, options);
    this.vehicle.updateMatrixWorld(true);
  }

  /** In a curve every body stands in its own frame of the line; seen from the frame of the vehicle's middle. */
  onLine(s) {
    const line = this.line;
    this.away.copy(line.frame(s, this.away)).invert();
    this.ground.matrix.copy(this.away);
    this.track.update(s);
    for (const body of this.bodies) {
      const x = body.rest.x;
      this.own.multiplyMatrices(this.away, line.frame(s + x, this.design));
      this.design.makeTranslation(-x, 0, 0);
      this.own.multiply(this.design);
      body.line.position.setFromMatrixPosition(this.own);
      body.line.quaternion.setFromRotationMatrix(this.own);
      body.node.position.applyMatrix4(this.own);
      body.node.quaternion.premultiply(body.line.quaternion);
    }
  }

  /** Wheels that let a contact be seen through them. */
  glassWheels(glass) {
    for (const name of ["steel", "dark", "mark"]) {
      const material = this.materials[name];
      if (material.transparent !== glass) { material.transparent = glass; material.opacity = glass ? 0.35 : 1; material.needsUpdate = true; }
    }
  }

  showCar(mode) {
    for (const body of this.bodies) body.node.traverse((node) => { if (node.userData.shell) node.visible = mode !== "none"; });
    this.materials.car.opacity = mode === "solid" ? 0.95 : 0.18;
    this.materials.car.depthWrite = mode === "solid";
  }
}
