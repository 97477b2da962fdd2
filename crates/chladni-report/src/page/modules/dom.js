// Elements. Foreign words are inserted as text only, never as markup.

const SVG = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
}

/** An HTML element: `h("p", { class: "calm" }, "No warnings.")`. */
export function h(tag, attributes, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** An SVG element. */
export function s(tag, attributes, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

/** Words whose options (two dashes and a word) are not broken at the end of a line. */
export function unbroken(text) {
  return text.split(/(--[a-z][a-z-]*)/).map((part, k) => (k % 2 ? h("span", { class: "option" }, part) : part));
}

/** A section of the page with its heading, anchored for the list of contents. */
export function section(id, heading, ...children) {
  return h("section", { id, "aria-labelledby": `${id}-heading` }, h("h2", { id: `${id}-heading` }, heading), ...children);
}

/** Calls `onsize` with width and height of an element (px), once it is laid out and at changes. */
export function sized(element, onsize) {
  new ResizeObserver(([entry]) => onsize(entry.contentRect)).observe(element);
  element.classList.add("sized");
  element.addEventListener("measure", () => onsize({ width: element.clientWidth, height: element.clientHeight }));
}

/** Measures all elements that are `sized` now, also those that are not laid out since they are far from the window. */
export function measureAll() {
  document.querySelectorAll(".sized").forEach((element) => element.dispatchEvent(new Event("measure")));
}

/** Says, once the page as it is now is seen, that it is drawn, and after how many ms. */
export function sayDrawn() {
  requestAnimationFrame(() => setTimeout(() => (document.documentElement.dataset.drawn = String(Math.round(performance.now())))));
}

/** A list to choose from; `onchange` gets the index. */
export function choice(label, names, index, onchange) {
  const select = h("select", { onchange: () => onchange(select.selectedIndex) }, names.map((name) => h("option", {}, name)));
  select.selectedIndex = index;
  return { element: h("label", { class: "control" }, `${label} `, select), select };
}

/** A box to tick. */
export function tick(label, checked, onchange) {
  const box = h("input", { type: "checkbox", checked, onchange: () => onchange(box.checked) });
  return h("label", { class: "control" }, box, ` ${label}`);
}

/** A slider with its value in words; `oninput` gets the number, and true during a drag. */
export function slider(label, { min, max, step, value, words }, oninput) {
  const output = h("output", {}, words(value));
  const said = (moving) => {
    output.textContent = words(input.valueAsNumber);
    oninput(input.valueAsNumber, moving);
  };
  const input = h("input", { type: "range", min, max, step, oninput: () => said(true), onchange: () => said(false) });
  input.value = value;
  const element = h("label", { class: "control slider" }, `${label} `, input, " ", output);
  const set = (to) => {
    input.value = to;
    output.textContent = words(to);
  };
  return { element, input, set };
}

/** Text with a button that copies it. `set` changes the text. */
export function takeAway(label, id) {
  const text = h("textarea", { id, readonly: true, rows: 6, spellcheck: "false", "aria-label": label });
  const said = h("span", { class: "muted", role: "status" });
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(text.value);
      said.textContent = "copied";
    } catch {
      // a file opened from disk has no clipboard: the text is selected, so that a key copies it
      text.focus();
      text.select();
      said.textContent = "selected: copy with Ctrl+C";
    }
  };
  const button = h("button", { type: "button", onclick: copy }, "Copy");
  const set = (words) => {
    text.value = words;
    text.rows = Math.min(24, Math.max(3, words.split("\n").length));
    said.textContent = "";
  };
  return { element: h("div", { class: "take" }, h("p", {}, `${label} `, button, " ", said), text), set, text: () => text.value };
}

/** A list of labels and texts. */
export function factList(rows) {
  return h("dl", {}, rows.map(([word, text]) => [h("dt", {}, word), h("dd", {}, text)]));
}

/** A table: header cells and rows of cells; a cell is text, an element, or `{ number: text }`. */
export function table(header, rows, attributes) {
  const cell = (tag) => (content) => {
    const isNumber = content !== null && typeof content === "object" && "number" in content;
    return h(tag, isNumber ? { class: "number" } : {}, isNumber ? content.number : content);
  };
  const head = h("thead", {}, h("tr", {}, header.map(cell("th"))));
  return h("div", { class: "scroll" }, h("table", attributes ?? {}, head, h("tbody", {}, rows.map((row) => h("tr", {}, row.map(cell("td")))))));
}

/** Replaces the content of `element`; the focus stays on the element with the same `data-focus`. */
export function redraw(element, ...children) {
  const name = element.contains(document.activeElement) ? document.activeElement.dataset.focus : null;
  element.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  if (name) element.querySelector(`[data-focus="${name}"]`)?.focus({ preventScroll: true });
}
