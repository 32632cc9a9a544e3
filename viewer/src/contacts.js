// Contact patches on the surfaces, and the forces in them as arrows on the wheel.
//
// Places, axes and forces are the run's; an ellipse of the recorded semi-axes stands for every patch, larger by the factor of the slider.

import { CircleGeometry, ConeGeometry, CylinderGeometry, DoubleSide, Group, Matrix4, Mesh, MeshBasicMaterial, Quaternion, RingGeometry, Vector3 } from "three";
import { slipColour } from "./colours.js";

const Y = new Vector3(0, 1, 0);
const METRES_PER_NEWTON = 6e-6;

/** An arrow along +y, one metre long per unit of its length. */
class Arrow {
  constructor(colour, group) {
    const material = new MeshBasicMaterial({ color: colour, depthTest: false, transparent: true, opacity: 0.9 });
    this.shaft = new Mesh(new CylinderGeometry(0.011, 0.011, 1, 10).translate(0, 0.5, 0), material);
    this.head = new Mesh(new ConeGeometry(0.032, 0.08, 14).translate(0, 0.04, 0), material);
    this.node = new Group().add(this.shaft, this.head);
    this.shaft.renderOrder = this.head.renderOrder = 20;
    this.turn = new Quaternion();
    this.material = material;
    group.add(this.node);
  }

  set(at, vector, length, unit) {
    const size = length * vector.length();
    this.node.visible = size > 0.01 * unit;
    if (!this.node.visible) return;
    this.node.position.copy(at);
    this.node.quaternion.copy(this.turn.setFromUnitVectors(Y, vector.normalize()));
    this.shaft.scale.set(unit, Math.max(1e-3, size - 0.07 * unit), unit);
    this.head.position.y = Math.max(0, size - 0.08 * unit);
    this.head.scale.setScalar(unit * Math.min(1, size / (0.1 * unit)));
  }
}

class Patch {
  constructor(name, group) {
    this.name = name;
    this.material = new MeshBasicMaterial({ side: DoubleSide, depthTest: false, transparent: true, opacity: 0.92 });
    this.rim = new MeshBasicMaterial({ color: "#ffffff", side: DoubleSide, depthTest: false, transparent: true, opacity: 0.9 });
    this.node = new Group().add(new Mesh(new CircleGeometry(1, 40), this.material), new Mesh(new RingGeometry(1, 1.07, 40), this.rim));
    this.node.children.forEach((mesh, k) => { mesh.renderOrder = 15 + k; });
    this.creep = new Arrow("#ff8a1f", group);
    this.basis = new Matrix4(); this.n = new Vector3(); this.t = new Vector3(); this.i = new Vector3(1, 0, 0); this.force = new Vector3();
    group.add(this.node);
  }

  /** @returns whether there is a patch now */
  update(numbers, place, side, options, unit, slipLargest) {
    const of = (name) => numbers.at(`${this.name}.${name}`), x = of("x"), normal = of("normal");
    const there = x === x && normal > 0;
    this.node.visible = there && options.patches;
    this.creep.node.visible = false;
    if (!there) return null;
    const angle = of("contact_angle");
    this.n.set(0, -side * Math.sin(angle), Math.cos(angle));
    this.t.crossVectors(this.n, this.i);
    this.basis.makeBasis(this.i, this.t, this.n);
    this.node.position.set(x, of("y"), of("z")).add(place);
    this.node.quaternion.setFromRotationMatrix(this.basis);
    this.node.scale.set(options.patchFactor * of("a"), options.patchFactor * of("b"), 1);
    const slip = Math.hypot(of("sliding_x"), of("sliding_y"));
    slipColour(slip / slipLargest, this.material.color);
    if (options.arrows) {
      this.force.copy(this.i).multiplyScalar(of("creep_force_x")).addScaledVector(this.t, of("creep_force_y"));
      this.creep.set(this.node.position, this.force, METRES_PER_NEWTON * options.arrowFactor * options.creepFactor / options.weight, unit);
    }
    return this.node.position;
  }
}

export class Contacts {
  constructor(head, bodies, unit, group, numbers) {
    this.unit = unit;
    this.weight = Math.max(1e-9, head.load || 0, ...head.wheels.map((_, w) => Math.abs(numbers.columns.get(`w${w}.vertical_force`)?.[0] || 0))) / 5.5e4 / unit;
    this.wheels = head.wheels.map((wheel, w) => ({
      ...own(wheel, w, bodies[wheel.body], head.patches, group), vector: new Vector3(), place: new Vector3(),
    }));
    this.slipLargest = slipScale(head, numbers);
  }

  update(numbers, options) {
    options = { ...options, weight: this.weight / options.arrowUnit };
    const unit = this.unit * options.arrowUnit;
    for (const wheel of this.wheels) {
      wheel.body.under(wheel.table.side, wheel.place);
      wheel.node.position.copy(wheel.body.line.position);
      wheel.node.quaternion.copy(wheel.body.line.quaternion);
      const name = `w${wheel.number}`;
      wheel.place.y += numbers.at(`${name}.rail_lateral`) || 0;
      wheel.place.z += numbers.at(`${name}.rail_vertical`) || 0;
      let at = null;
      for (const patch of wheel.patches) at = patch.update(numbers, wheel.place, wheel.table.side, options, unit, this.slipLargest) || at;
      wheel.force.node.visible = false;
      if (at && options.arrows) {
        wheel.vector.set(numbers.at(`${name}.longitudinal_force`), numbers.at(`${name}.lateral_force`), numbers.at(`${name}.vertical_force`));
        wheel.force.set(at, wheel.vector, METRES_PER_NEWTON * options.arrowFactor / options.weight, unit);
      }
    }
  }
}

/** Patches and arrows of a wheel, in the frame of the line in which its wheelset stands. */
function own(table, number, body, patches, group) {
  const node = new Group();
  group.add(node);
  const list = Array.from({ length: patches }, (_, p) => new Patch(`w${number}.p${p}`, node));
  return { table, number, body, node, patches: list, force: new Arrow("#2f7fe6", node) };
}

/** The slip that ends the colours: what all but a hundredth of the frames stay below, at least 1 mm/s. */
function slipScale(head, numbers) {
  const all = [];
  for (let w = 0; w < head.wheels.length; w++) for (let p = 0; p < head.patches; p++) {
    if (head.live) continue;
    const x = numbers.columns.get(`w${w}.p${p}.sliding_x`), y = numbers.columns.get(`w${w}.p${p}.sliding_y`);
    for (let k = 0; k < x.length; k++) if (x[k] === x[k]) all.push(Math.hypot(x[k], y[k]));
  }
  all.sort((a, b) => a - b);
  return Math.max(head.live ? 0.2 : 1e-3, all[Math.floor(0.99 * (all.length - 1))] || 0);
}
