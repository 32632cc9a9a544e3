// Materials of solid surfaces. With a graphics processor light is computed for each pixel, by software at the vertices: there light and
// its conversion to sRGB in every pixel make half or more of what a picture costs.

import { Color, MeshLambertMaterial, MeshPhongMaterial, ShaderMaterial, Vector3 } from "three";

/** The sun and the sky, as the stage hangs them up; `sky` follows the theme. */
export const LIGHT = { sun: new Vector3(4, 7, 10), strength: 1.9, above: "#ffffff", below: "#8b93a0", sky: { value: 2 } };

let known;

/** Whether pictures are drawn without a graphics processor. */
export function drawnBySoftware() {
  if (known !== undefined) return known;
  const gl = document.createElement("canvas").getContext("webgl2"), info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return (known = /swiftshader|llvmpipe|software/i.test(name));
}

const VERTEX = `
uniform vec3 color; uniform vec3 sun; uniform float strength; uniform float sky; uniform vec3 above; uniform vec3 below; uniform float shine;
varying vec3 seen;
void main() {
  vec3 n = normal;
  vec4 at = vec4(position, 1.0);
  #ifdef USE_INSTANCING
    n = mat3(instanceMatrix) * n;
    at = instanceMatrix * at;
  #endif
  n = normalize(normalMatrix * n);
  at = modelViewMatrix * at;
  #ifdef DOUBLE_SIDED
    n = faceforward(n, at.xyz, n);
  #endif
  vec3 way = normalize((viewMatrix * vec4(sun, 0.0)).xyz), up = (viewMatrix * vec4(0.0, 1.0, 0.0, 0.0)).xyz;
  float lit = max(dot(n, way), 0.0);
  vec3 light = (strength * lit + sky * mix(below, above, 0.5 + 0.5 * dot(n, up))) / 3.14159265;
  vec3 c = color * light;
  #ifdef SHINE
    float s = max(dot(n, normalize(way - normalize(at.xyz))), 0.0);
    s *= s; s *= s; s *= s;
    c += shine * lit * s * s;
  #endif
  c = min(c, 1.0);
  vec3 a = sqrt(c), b = sqrt(a);
  seen = 0.662 * a + 0.6841 * b - 0.3236 * sqrt(b) - 0.0225 * c;
  gl_Position = projectionMatrix * at;
}`;

const FRAGMENT = `
uniform float opacity;
varying vec3 seen;
void main() { gl_FragColor = vec4(seen, opacity); }`;

/** The light of three's Lambert material, but at the vertices; sRGB there too, by roots (within 0.005) in place of a power. */
class Painted extends ShaderMaterial {
  constructor({ color = "#ffffff", shine = 0, ...options } = {}) {
    const one = (value) => ({ value });
    super({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, defines: shine ? { SHINE: "" } : {},
      uniforms: {
        color: one(new Color(color)), opacity: one(1), sun: one(LIGHT.sun), strength: one(LIGHT.strength), sky: LIGHT.sky,
        above: one(new Color(LIGHT.above)), below: one(new Color(LIGHT.below)), shine: one(shine),
      },
    });
    this.setValues(options);
  }

  get color() { return this.uniforms.color.value; }

  get opacity() { return this.uniforms?.opacity.value ?? 1; }

  set opacity(value) { if (this.uniforms) this.uniforms.opacity.value = value; }
}

/** A dull surface. */
export const dull = (options = {}) => (drawnBySoftware() ? new Painted(options) : new MeshLambertMaterial(options));

/** A polished one. */
export const polished = (shininess, specular) => (drawnBySoftware() ? new Painted({ shine: 0.12 }) : new MeshPhongMaterial({ shininess, specular }));
