// The canvas: one view per run with the same camera, side by side or, on a narrow screen, one above the other.

import { Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { drawnBySoftware, LIGHT } from "./surfaces.js";

export class Stage {
  constructor(canvas, worlds) {
    this.worlds = worlds;
    this.renderer = new WebGLRenderer({ canvas, antialias: !drawnBySoftware() /* by software smooth edges cost four times as much */, powerPreference: "high-performance" });
    this.sharpness = 1;
    this.renderer.setScissorTest(worlds.length > 1);
    this.camera = new PerspectiveCamera(32, 1, 0.05, 400);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.maxDistance = 120;
    this.controls.addEventListener("change", () => { this.dirty = true; });
    this.scenes = worlds.map((world) => {
      const scene = new Scene(), sun = new DirectionalLight("#ffffff", LIGHT.strength), sky = new HemisphereLight(LIGHT.above, LIGHT.below, LIGHT.sky.value);
      sun.position.copy(LIGHT.sun);
      scene.add(world.root, sun, sky);
      scene.userData = { sky };
      return scene;
    });
    this.followed = new Vector3();
    this.before = new Vector3();
    this.mode = "free";
    this.dirty = true;
  }

  resize(width, height) {
    this.width = width; this.height = height;
    this.stacked = this.worlds.length > 1 && width < height * 1.15;
    this.setSharpness(this.sharpness);
    const parts = this.worlds.length;
    this.camera.aspect = this.stacked ? width / (height / parts) : width / parts / height;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  /** Pixels of the picture per pixel of the page: fewer where a slow machine would not keep up. */
  setSharpness(sharpness) {
    this.sharpness = sharpness;
    this.renderer.setPixelRatio(sharpness * Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(this.width, this.height, false);
    this.dirty = true;
  }

  theme(theme) {
    for (const [k, scene] of this.scenes.entries()) {
      scene.background = new Color(theme.sky);
      scene.userData.sky.intensity = LIGHT.sky.value = theme.hemisphere;
      this.worlds[k].theme(theme);
    }
    this.dirty = true;
  }

  /** Another world in place of one; the page has the same list. */
  exchange(k, world) {
    this.scenes[k].remove(this.worlds[k].root);
    this.worlds[k] = world;
    this.scenes[k].add(world.root);
  }

  /** Where a mode looks: at the middle of the vehicle, a wheelset, down the track, at a wheel's contact. */
  target(mode, wheel, out) {
    const world = this.worlds[0], { wheels } = world.head;
    const body = world.bodies[wheels[wheel].body];
    if (mode === "free" || mode === "track") return out.set(0, 0, 0.35 * world.unit);
    out.copy(body.node.position);
    if (mode === "contact") out.y += wheels[wheel].side * world.head.shapes.rail_origin, out.z -= body.rest.z;
    return out;
  }

  look(mode, wheel = 0) {
    const world = this.worlds[0], u = world.unit, side = world.head.wheels[wheel].side;
    this.mode = mode; this.wheel = wheel;
    const sets = world.bodies.filter((body) => body.table.kind === "wheelset"), reach = Math.max(...sets.map((body) => Math.abs(body.rest.x)), 0.6 * u);
    const narrow = Math.max(1, 1.25 / this.camera.aspect), far = (2.6 * reach + 3.2 * u) * narrow;
    const from = {
      free: [0.62 * far, 0.8 * far, 0.33 * far],
      wheelset: [2.9 * u * narrow, 1.9 * u * narrow, 0.75 * u],
      track: [far * 1.15, 0, 0.5 * u + 0.12 * far],
      contact: [0.55 * u * narrow, side * 0.45 * u * narrow, 0.3 * u],
    }[mode];
    this.target(mode, wheel, this.before);
    this.controls.target.copy(this.before);
    this.camera.position.set(...from).add(this.before);
    this.controls.update();
    this.dirty = true;
  }

  /** The camera goes along with what it looks at. */
  follow() {
    this.target(this.mode, this.wheel, this.followed);
    const moved = this.followed.clone().sub(this.before);
    if (this.mode !== "free" && this.mode !== "track" && moved.lengthSq() > 0) {
      this.camera.position.add(moved);
      this.controls.target.add(moved);
      this.controls.update();
    }
    this.before.copy(this.followed);
  }

  /** Lower-left corner and size of a view in pixels of the page. */
  part(k) {
    const n = this.worlds.length;
    if (n === 1) return [0, 0, this.width, this.height];
    return this.stacked ? [0, (n - 1 - k) * this.height / n, this.width, this.height / n] : [k * this.width / n, 0, this.width / n, this.height];
  }

  render() {
    this.scenes.forEach((scene, k) => {
      const [x, y, w, h] = this.part(k);
      this.renderer.setViewport(x, y, w, h);
      if (this.scenes.length > 1) this.renderer.setScissor(x, y, w, h);
      this.renderer.render(scene, this.camera);
    });
    this.dirty = false;
  }
}
