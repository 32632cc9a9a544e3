// The numbers of a scene: columns over time, and the curve that is drawn through their frames.
//
//   base64 of gzip -> bytes -> column by name -> value at a time

const MISSING = -32767;

/** Bytes of the script element `id`. */
async function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

export class Numbers {
  constructor(columns) {
    this.columns = columns;
    this.times = columns.get("time");
    this.frame = 0;
    this.part = 0;
  }

  static async of(id, places) {
    const buffer = await bytesOf(id);
    const columns = new Map();
    for (const [name, [start, count, kind, factor, offset]] of Object.entries(places)) {
      const raw = kind === "f" ? new Float32Array(buffer, start, count) : new Int16Array(buffer, start, count);
      if (kind === "f") columns.set(name, raw);
      else columns.set(name, Float32Array.from(raw, (v) => (v === MISSING ? NaN : offset + factor * v)));
    }
    return new Numbers(columns);
  }

  has(name) { return this.columns.has(name); }
  get end() { return this.times[this.times.length - 1]; }

  /** Frame before a time, and the part of the way to the next one. */
  seek(time) {
    const times = this.times;
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle; else high = middle;
    }
    this.frame = low;
    this.part = Math.min(1, Math.max(0, (time - times[low]) / (times[low + 1] - times[low] || 1)));
  }

  /** Value of a column at the time sought: the cubic of columns.py; beside a gap the nearer frame. 0 where there is no such column. */
  at(name) {
    const c = this.columns.get(name);
    if (!c) return 0;
    const k = this.frame, u = this.part, last = c.length - 1;
    const p0 = c[k], p1 = c[k + 1];
    if (!(p0 === p0 && p1 === p1)) return u < 0.5 ? p0 : p1;
    const before = c[k - 1], after = c[k + 2];
    const m0 = k > 0 && before === before ? (p1 - before) / 2 : p1 - p0;
    const m1 = k + 1 < last && after === after ? (after - p0) / 2 : p1 - p0;
    const r = 1 - u;
    return (1 + u * u * (2 * u - 3)) * p0 + u * u * (3 - 2 * u) * p1 + u * r * r * m0 - u * u * r * m1;
  }

  /** Largest absolute value of a column. */
  largest(name) {
    let found = 0;
    for (const v of this.columns.get(name) || []) if (Math.abs(v) > found) found = Math.abs(v);
    return found;
  }
}
