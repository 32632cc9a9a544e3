// A chart under fingers: two zoom and move it, one scrolls the page as ever.

/** `zoomed(low, high)` is told the range that two fingers ask for. */
export function pinched(plot, zoomed) {
  const { over } = plot;
  over.style.touchAction = "pan-x pan-y";
  const places = (event) => {
    const { left } = over.getBoundingClientRect(), [a, b] = [...event.touches].map((touch) => touch.clientX - left);
    return a < b ? [a, b] : [b, a];
  };
  let held = null;
  over.addEventListener("touchstart", (event) => {
    held = event.touches.length === 2 ? places(event).map((x) => plot.posToVal(x, "x")) : null;
  }, { passive: true });
  over.addEventListener("touchmove", (event) => {
    if (!held || event.touches.length !== 2) return;
    event.preventDefault();
    const [a, b] = places(event), scale = (held[1] - held[0]) / Math.max(20, b - a), low = held[0] - a * scale, all = plot.data[0];
    const from = Math.max(all[0], low), to = Math.min(all[all.length - 1], low + over.clientWidth * scale);
    if (to > from) zoomed(from, to);
  }, { passive: false });
}
