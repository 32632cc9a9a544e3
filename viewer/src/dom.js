// Small helpers for the page's elements.

/** An element with attributes, classes, and children. */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== undefined) node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
}

export const button = (text, title, onclick, id) => element("button", { type: "button", title, "aria-label": title, onclick, id }, text);

/** A slider with its name and the value it stands for. */
export function slider(name, least, most, step, value, shown, changed, id) {
  const output = element("output", {}, shown(value));
  const input = element("input", { type: "range", min: least, max: most, step, value, id, "aria-label": name });
  input.addEventListener("input", () => { output.textContent = shown(Number(input.value)); changed(Number(input.value)); });
  return element("label", { class: "slider" }, element("span", {}, name), input, output);
}
