// How much of a long oscillation is shown at a time: a run that hunts for its whole length would be a block of colour.

const LEAST = 8, SHOWN = 24;

/** Time in which waves of SHOWN pixels have room, where those of the last third are regular, settled and narrower than LEAST pixels; else 0. */
export function shownLength(times, values, width) {
  const all = times[times.length - 1] - times[0], first = times.findIndex((t) => t >= times[0] + (2 * all) / 3), rest = values.slice(first).filter((v) => v !== null);
  const range = (list) => Math.max(...list) - Math.min(...list), middle = Math.min(...rest) + range(rest) / 2, rises = [];
  for (let k = first + 1; k < times.length; k += 1) if (values[k - 1] !== null && values[k - 1] < middle && values[k] >= middle) rises.push(times[k]);
  const waves = rises.slice(1).map((t, k) => t - rises[k]), length = waves.reduce((a, b) => a + b, 0) / waves.length;
  const regular = waves.length > 4 && waves.every((one) => Math.abs(one - length) < 0.3 * length) && range(rest.slice(-rest.length / 6)) > 0.8 * range(rest);
  return regular && (length * width) / all < LEAST ? (length * width) / SHOWN : 0;
}
