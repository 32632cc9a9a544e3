// Where the line leads: place and attitude of the track at an arc length, from a table.

import { Matrix4, Vector3 } from "three";

/** Track as a matrix: x along the line, y to the left in the canted plane, z up; origin on the centre line at the top of rail. */
export class Line {
  constructor(table) { this.table = table; }

  value(name, s) {
    const { start, step } = this.table, list = this.table[name];
    const u = Math.min(list.length - 1.001, Math.max(0, (s - start) / step)), k = Math.floor(u);
    return list[k] + (u - k) * (list[k + 1] - list[k]);
  }

  get from() { return this.table.start; }
  get to() { return this.table.start + (this.table.x.length - 1) * this.table.step; }

  frame(s, target = new Matrix4()) {
    const heading = this.value("heading", s), roll = -Math.asin(this.value("cant", s) / this.table.base);
    const rise = Math.abs(this.value("cant", s)) / 2;
    const x = new Vector3(Math.cos(heading), Math.sin(heading), 0);
    const left = new Vector3(-x.y * Math.cos(roll), x.x * Math.cos(roll), Math.sin(roll));
    target.makeBasis(x, left, new Vector3().crossVectors(x, left));
    return target.setPosition(this.value("x", s), this.value("y", s), rise);
  }
}
