// Bodies as meshes around their centres of mass. Wheels and rollers have their profiles; frames and car bodies are schematic, around the
// ends of their elements.

import { BoxGeometry, CircleGeometry, EdgesGeometry, ExtrudeGeometry, Group, LineSegments, Mesh, Shape } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { rollerGeometry, shaft, wheelGeometry } from "./lathe.js";

const box = (x, y, z, sx, sy, sz) => new BoxGeometry(sx, sy, sz).translate(x, y, z);

/** Marks on the face of a disc that make its turning seen: the dark ones, and the one that differs. */
function marks(radius, size, y, side) {
  const holes = Array.from({ length: 6 }, (_, k) => new CircleGeometry(size, 16).rotateX(side > 0 ? -Math.PI / 2 : Math.PI / 2)
    .translate(radius * Math.cos(k * Math.PI / 3), y + side * 0.002, radius * Math.sin(k * Math.PI / 3)));
  return { mark: [holes[0]], dark: holes.slice(1) };
}

/** One mesh for the marks of a colour on all faces: what a picture costs without a graphics processor is its number of meshes. */
function addMarks(group, faces, materials) {
  for (const name of ["dark", "mark"]) group.add(new Mesh(mergeGeometries(faces.flatMap((face) => face[name])), materials[name]));
}

export function wheelset(shapes, materials, withDiscs) {
  const group = new Group(), R = shapes.wheel_radius, end = shapes.tape_circle + 0.55 * R, faces = [];
  for (const side of [1, -1]) {
    group.add(new Mesh(wheelGeometry(shapes, side), materials.steel));
    const middle = (shapes.back_to_back / 2 + shapes.tape_circle + shapes.wheel.at(-1)[0]) / 2;
    faces.push(marks(0.56 * R, 0.075 * R, side * (middle + 0.05 * R), side), marks(0.56 * R, 0.075 * R, side * (middle - 0.05 * R), -side));
  }
  addMarks(group, faces, materials);
  group.add(new Mesh(mergeGeometries([shaft(0.18 * R, -end + 0.2 * R, end - 0.2 * R), shaft(0.14 * R, -end, end)]), materials.axle));
  if (withDiscs) group.add(new Mesh(mergeGeometries([-0.55 * R, 0.55 * R].map((y) => shaft(0.66 * R, y - 0.05 * R, y + 0.05 * R, 48))), materials.disc));
  return group;
}

export function roller(shapes, sides, materials) {
  const group = new Group(), R = shapes.roller_radius, at = shapes.rail_origin, faces = [];
  for (const name of sides) {
    const side = name === "left" ? 1 : -1;
    group.add(new Mesh(rollerGeometry(shapes, side), materials.roller));
    for (const face of [1, -1]) faces.push(marks(0.6 * R, 0.09 * R, side * at + face * 0.035 * R, face));
  }
  addMarks(group, faces, materials);
  const y0 = sides.includes("right") ? -at - 0.5 * R : at - 0.35 * R, y1 = sides.includes("left") ? at + 0.5 * R : -at + 0.35 * R;
  group.add(new Mesh(shaft(0.12 * R, y0, y1), materials.axle));
  return group;
}

/** A bogie frame: side beams above the primary springs, joined in the middle and where other elements meet it. */
export function frame(body, unit, materials) {
  const ends = body.ends.length ? body.ends : [[1, 1, 0], [-1, -1, 0]];
  const half = Math.max(...ends.map((e) => Math.abs(e[0]))), wide = Math.max(0.6 * unit, ...ends.filter((e) => Math.abs(e[0]) > 0.6 * half).map((e) => Math.abs(e[1])));
  const top = frameHeight(body, unit), parts = [];
  for (const side of [1, -1]) {
    parts.push(box(0, side * wide, top - 0.14 * unit, 1.15 * half, 0.16 * unit, 0.2 * unit));
    for (const way of [1, -1]) {
      const inner = 0.5 * half, end = half + 0.6 * unit;
      parts.push(box(way * (inner + end) / 2, side * wide, top, end - inner, 0.16 * unit, 0.13 * unit));
    }
  }
  for (const x of [-0.32 * unit, 0.32 * unit]) parts.push(box(x, 0, top - 0.14 * unit, 0.16 * unit, 2 * wide, 0.16 * unit));
  for (const x of [-half - 0.56 * unit, half + 0.56 * unit]) parts.push(box(x, 0, top, 0.09 * unit, 2 * wide + 0.16 * unit, 0.09 * unit));
  const outer = Math.max(...ends.map((e) => Math.abs(e[1])));
  if (outer > wide + 0.1 * unit) parts.push(box(0, 0, top - 0.2 * unit, 0.12 * unit, 2 * outer + 0.1 * unit, 0.08 * unit));
  return new Mesh(mergeGeometries(parts), materials.frame);
}

/** Height of the side beams over the centre of mass: above the primary springs. */
export function frameHeight(body, unit) {
  const low = body.ends.length ? Math.min(...body.ends.map((e) => e[2])) : 0;
  return Math.max(0.1 * unit, low + 0.46 * unit);
}

/** A car body over the ends of its elements: a shell that lets one see through. */
export function carBody(body, unit, materials) {
  const xs = body.ends.length ? body.ends.map((e) => e[0]) : [0], zs = body.ends.length ? body.ends.map((e) => e[2]) : [0];
  const overhang = Math.max(...xs) - Math.min(...xs) > 8 * unit ? 3 * unit : 2.2 * unit;
  const x0 = Math.min(...xs) - overhang, x1 = Math.max(...xs) + overhang, low = Math.max(...zs) + 0.42 * unit, high = low + 2.7 * unit, w = 1.42 * unit;
  const section = new Shape();
  section.moveTo(-w, low).lineTo(w, low).lineTo(1.02 * w, low + 1.3 * unit).lineTo(0.96 * w, low + 2.0 * unit);
  section.bezierCurveTo(0.9 * w, high, 0.5 * w, high, 0, high).bezierCurveTo(-0.5 * w, high, -0.9 * w, high, -0.96 * w, low + 2.0 * unit);
  section.lineTo(-1.02 * w, low + 1.3 * unit).lineTo(-w, low);
  const shell = new ExtrudeGeometry(section, { depth: x1 - x0, bevelEnabled: false, curveSegments: 8 });
  shell.rotateX(Math.PI / 2).rotateZ(Math.PI / 2).translate(x0, 0, 0);
  const group = new Group(), floor = new LineSegments(new EdgesGeometry(box((x0 + x1) / 2, 0, low + 0.05 * unit, x1 - x0, 2 * w, 0.1 * unit)), materials.carLine);
  const skin = new Mesh(shell, materials.car), lines = new LineSegments(new EdgesGeometry(shell, 40), materials.carLine);
  skin.renderOrder = 5;
  const windows = [];
  for (let x = x0 + 1.1 * unit; x < x1 - 1.2 * unit; x += 1.75 * unit) for (const side of [1, -1]) windows.push(box(x, side * 1.005 * w, low + 1.45 * unit, 1.2 * unit, 0.01 * unit, 0.75 * unit));
  const glass = windows.length ? new LineSegments(new EdgesGeometry(mergeGeometries(windows)), materials.carLine) : new Group();
  group.add(floor, skin, lines, glass);
  group.userData.shell = true;
  return group;
}
