// The panel from above: pixels of a field on a canvas, with lines, zones and marks in SVG over it.

import { s, h, redraw, sized } from "./dom.js";
import { themeColour } from "./colour.js";
import { ticks } from "./scale.js";

const WITH_AXES = { left: 52, right: 12, top: 12, bottom: 40 };
/** Margins without axes: the map fills its place. */
const BARE = { left: 6, right: 6, top: 6, bottom: 6 };
/** Free ground around the nodes, part of their larger extent. */
const BORDER = 0.07;

/** A map over `box` = [x0, y0, x1, y1] (m) with the names of its axes; `draw(layers)` shows pixels, contours and marks. A `bare` map has no axes, and
 fits into width and height of its place. */
export function panelMap(box, axes, label, widest = 640, bare = false) {
  const MARGIN = bare ? BARE : WITH_AXES;
  const room = BORDER * Math.max(box[2] - box[0], box[3] - box[1]);
  const ends = [box[0] - room, box[1] - room, box[2] + room, box[3] + room];
  const canvas = h("canvas", { "aria-hidden": "true" });
  const svg = s("svg", { class: "chart map", role: "img", "aria-label": label, tabindex: 0 });
  const element = h("div", { class: "map-holder" }, canvas, svg);
  const groups = Object.fromEntries(["frame", "contours", "outlines", "marks", "extra", "front"].map((name) => [name, s("g", {})]));
  svg.append(...Object.values(groups));
  let layers = {};
  // the data that each group, and the pixels, were drawn from
  const drawn = new Map();
  let outlined = { key: null, parts: [] };
  let scale = 1;
  let width = 0;

  const px = ([x, y]) => [MARGIN.left + (x - ends[0]) * scale, MARGIN.top + (ends[3] - y) * scale];

  /** Draws what has changed; everything after a change of size or theme. */
  function draw(changed) {
    layers = { ...layers, ...changed };
    if (!width) return;
    if (!changed) resize();
    if (drawn.get("colour") !== layers.colour || drawn.get("surface") !== layers.surface || !drawn.has("surface")) paint();
    group("contours", layers.contours, contourLines);
    outlines();
    group("marks", layers.marks, marks);
    group("extra", layers.extra, () => layers.extra?.({ px, scale, s }) ?? []);
    group("front", layers.front, () => layers.front?.({ px, scale, s }) ?? []);
  }

  function group(name, from, parts) {
    if (drawn.has(name) && drawn.get(name) === from) return;
    drawn.set(name, from);
    redraw(groups[name], parts());
  }

  function resize() {
    drawn.clear();
    scale = (width - MARGIN.left - MARGIN.right) / (ends[2] - ends[0]);
    const tall = (ends[3] - ends[1]) * scale;
    const height = MARGIN.top + tall + MARGIN.bottom;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("width", width);
    svg.setAttribute("height", height);
    canvas.width = width;
    canvas.height = Math.round(height);
    redraw(groups.frame, frame(tall, height));
  }

  function frame(tall, height) {
    const parts = [];
    for (const [value, text] of bare ? [] : ticks([1e3 * ends[0], 1e3 * ends[2]], 7)) {
      const [at, y] = px([1e-3 * value, ends[1]]);
      parts.push(s("line", { class: "tick", x1: at, x2: at, y1: y, y2: y + 4 }), s("text", { x: at, y: y + 17, "text-anchor": "middle" }, text));
    }
    for (const [value, text] of bare ? [] : ticks([1e3 * ends[1], 1e3 * ends[3]], 5)) {
      const [x, at] = px([ends[0], 1e-3 * value]);
      parts.push(s("line", { class: "tick", x1: x - 4, x2: x, y1: at, y2: at }), s("text", { x: x - 7, y: at + 4, "text-anchor": "end" }, text));
    }
    const [left, top] = px([ends[0], ends[3]]);
    parts.push(s("rect", { class: "frame", x: left, y: top, width: width - MARGIN.left - MARGIN.right, height: tall }));
    if (!bare) {
      parts.push(s("text", { x: (left + width) / 2, y: height - 6, "text-anchor": "middle" }, `${axes[0]} (mm)`));
      parts.push(s("text", { transform: `translate(13 ${top + tall / 2}) rotate(-90)`, "text-anchor": "middle" }, `${axes[1]} (mm)`));
    }
    return parts;
  }

  function contourLines() {
    return (layers.contours ?? []).flatMap(({ lines, style }) => {
      const d = lines.map((line) => `M${line.map(xy).join("L")}`).join("");
      return [s("path", { class: `casing ${style}`, d }), s("path", { class: style, d })];
    });
  }

  /** Keeps the elements of outlines that have only moved, so that the focus stays. */
  function outlines() {
    const list = layers.outlines ?? [];
    const key = JSON.stringify(list.map(({ style, text, id, label }) => [style, text ?? "", id ?? null, Boolean(label)]));
    if (key !== outlined.key) {
      const parts = list.map(({ style, text, id, label }) => {
        const live = label ? { tabindex: 0, role: "button", "data-focus": `zone-${id}` } : {};
        return { casing: s("path", { class: `casing ${style}` }), line: s("path", { class: style, "data-zone": id, ...live }), name: text ? s("text", { class: "zone-name" }, text) : null };
      });
      outlined = { key, parts };
      redraw(groups.outlines, parts.map(({ casing, line, name }) => [casing, line, name]));
    }
    list.forEach(({ points, label }, k) => {
      const { casing, line, name } = outlined.parts[k];
      const d = `M${points.map(xy).join("L")}Z`;
      casing.setAttribute("d", d);
      line.setAttribute("d", d);
      if (label) line.setAttribute("aria-label", label);
      if (!name) return;
      // in the upper left corner, where it hides the least
      const [x, y] = px([Math.min(...points.map((p) => p[0])), Math.max(...points.map((p) => p[1]))]);
      name.setAttribute("x", x + 7);
      name.setAttribute("y", y + 15);
    });
  }

  function marks() {
    return (layers.marks ?? []).flatMap(({ points, style, mark, hints }) => points.map((point, k) => {
      const [x, y] = px(point);
      const d = { cross: `M${x} ${y}m-4 -4l8 8m0 -8l-8 8`, triangle: `M${x} ${y}m0 -4.5l4.5 8h-9z` }[mark];
      const shape = d ? s("path", { class: style, d }) : s("circle", { class: style, cx: x, cy: y, r: mark === "ring" ? 3 : 1.6 });
      if (hints) shape.append(s("title", {}, hints[k]));
      return shape;
    }));
  }

  const xy = (point) => px(point).map((value) => value.toFixed(1)).join(" ");

  /** Pixels of the surface in the colours that `layers.colour(k, x, y)` gives; three numbers, or null. */
  function paint() {
    drawn.set("surface", layers.surface).set("colour", layers.colour);
    const context = canvas.getContext("2d");
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = themeColour("--band");
    const [left, top] = px([box[0], box[3]]);
    const [right, bottom] = px([box[2], box[1]]);
    context.fillRect(left, top, right - left, bottom - top);
    const surface = layers.surface;
    if (!surface) return;
    const { x, y } = surface;
    const pixels = new ImageData(x.length, y.length);
    for (let row = 0; row < y.length; row++) {
      for (let column = 0; column < x.length; column++) {
        const k = row * x.length + column;
        const rgb = layers.colour(k, x[column], y[row], row, column);
        const to = 4 * ((y.length - 1 - row) * x.length + column);
        if (!rgb) continue;
        [pixels.data[to], pixels.data[to + 1], pixels.data[to + 2], pixels.data[to + 3]] = [rgb[0], rgb[1], rgb[2], 255];
      }
    }
    const small = h("canvas", { width: x.length, height: y.length });
    small.getContext("2d").putImageData(pixels, 0, 0);
    const [x0, y0] = px([x[0], y[y.length - 1]]);
    const [x1, y1] = px([x[x.length - 1], y[0]]);
    context.imageSmoothingEnabled = true;
    context.drawImage(small, x0, y0, x1 - x0, y1 - y0);
  }

  sized(element, ({ width: wide, height: high }) => {
    const [across, up] = [ends[2] - ends[0], ends[3] - ends[1]];
    const fits = bare ? MARGIN.left + MARGIN.right + ((high - MARGIN.top - MARGIN.bottom) * across) / up : Infinity;
    const now = Math.max(bare ? 120 : 260, Math.floor(Math.min(widest, wide, fits)));
    if (now !== width) {
      width = now;
      draw();
    }
  });
  // the colours of the theme are read when pixels are painted
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());

  return {
    element,
    svg,
    draw,
    /** Data coordinates of a pointer, m. */
    where: (event) => {
      const sides = svg.getBoundingClientRect();
      const zoom = svg.viewBox.baseVal.width / sides.width;
      const [x, y] = [(event.clientX - sides.left) * zoom, (event.clientY - sides.top) * zoom];
      return [ends[0] + (x - MARGIN.left) / scale, ends[3] - (y - MARGIN.top) / scale];
    },
    ends,
    /** Pixels in a metre. */
    scale: () => scale,
  };
}

/** The meaning of a map's colours: a bar with its numbers, and lines where the contours lie. */
export function colourBar(colour, [low, high], unit, lines = []) {
  const [width, height] = [300, 12];
  const steps = 60;
  const at = (value) => ((value - low) / (high - low)) * width;
  const cells = Array.from({ length: steps }, (_, k) => {
    const value = low + ((k + 0.5) / steps) * (high - low);
    return s("rect", { x: (k * width) / steps, y: 0, width: width / steps + 0.5, height, fill: `rgb(${colour(value).join(",")})` });
  });
  const numbers = ticks([low, high], 6).map(([value, text]) => s("text", { x: at(value), y: height + 13, "text-anchor": "middle" }, text));
  const marks = lines.map(({ value, style }) => s("path", { class: style, d: `M${at(value)} -3V${height + 3}` }));
  const svg = s("svg", { class: "chart bar", viewBox: `-16 -5 ${width + 32} ${height + 22}`, width: width + 32, height: height + 22, "aria-hidden": "true" }, cells, marks, numbers);
  return h("p", { class: "bar-holder" }, svg, h("span", { class: "muted" }, unit));
}
