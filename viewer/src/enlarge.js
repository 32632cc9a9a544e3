// A picture in a window of its own: larger and smaller by buttons, wheel or keys, moved by scrolling or dragging.

import { button, element } from "./dom.js";

const STEP = 1.5, MOST = 8;

/** A click on the picture, or Enter on it, shows it alone. */
export function enlarged(picture) {
  picture.tabIndex = 0;
  picture.setAttribute("role", "button");
  picture.title = "enlarge";
  picture.addEventListener("click", () => open(picture));
  picture.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); open(picture); } });
}

function open(picture) {
  const copy = element("img", { src: picture.src, alt: picture.alt, draggable: "false" }), frame = element("div", { class: "frame" }, copy);
  let size = 1;
  const zoom = (factor, x = frame.clientWidth / 2, y = frame.clientHeight / 2) => {
    const before = size;
    size = Math.min(MOST, Math.max(1, size * factor));
    const part = size / before, left = (frame.scrollLeft + x) * part - x, top = (frame.scrollTop + y) * part - y;
    copy.style.width = `${100 * size}%`;
    frame.scrollTo(left, top);
  };
  const dialog = element("dialog", { class: "enlarged" }, element("div", { class: "buttons" },
    button("+", "larger (+)", () => zoom(STEP)), button("−", "smaller (-)", () => zoom(1 / STEP)), button("×", "close (Esc)", () => dialog.close())), frame);
  frame.addEventListener("wheel", (event) => { event.preventDefault(); const box = frame.getBoundingClientRect(); zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2, event.clientX - box.left, event.clientY - box.top); }, { passive: false });
  frame.addEventListener("pointermove", (event) => { if (event.pointerType === "mouse" && event.buttons & 1) frame.scrollBy(-event.movementX, -event.movementY); });
  dialog.addEventListener("keydown", (event) => { if ("+-".includes(event.key)) zoom(event.key === "+" ? STEP : 1 / STEP); });
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  zoom(frame.clientWidth < 600 ? 2 : 1);
}
