// A chart of curves, marks and error bars in SVG: zoom, move, read values, pick points, by pointer and by keys.

import { s, h, unbroken, redraw, sized } from "./dom.js";
import { significant, ends } from "./numbers.js";
import { ruler, ticks } from "./scale.js";

const MARGIN = { left: 62, right: 18, top: 10, bottom: 42 };
/** Margins where labels are above the frame and the unit is beside the last number. */
const COMPACT = { left: 40, right: 14, top: 18, bottom: 20 };
/** Room for the unit behind the last number, px. */
const UNIT_PX = 24;
/** Half width of a grip, and of the area in which it is caught, px. */
const GRIP = [4, 12];
/** Width of a turned label with its gaps, and of a digit, px. */
const LABEL_PX = 30;
const LETTER_PX = 7;
/** Size of a letter in the label of a point, px. */
const SMALL_PX = [6.5, 12];
/** Number of ticks along x in a narrow window, and along y in a low chart: fewer could leave one number, which is no scale. */
const LEAST_TICKS = 5;
const LEAST_ROWS = 3;
/** Distance of the numbers along y in a high one, px. */
const ROW_PX = 45;
/** Part of the range that a key moves by, and factor that it zooms by. */
const MOVE = 0.15;
const ZOOM = 1.5;
/** Largest movement of a click, px. */
const CLICK = 5;

/**
 * A chart in a figure. `spec`: {title, caption, height, x: {label, unit, range, log}, y: {...}, right: {label, unit, range},
 * series: [{name, x, y, style, right}], marks: [{name, points: [[x, y]], style, sign, right}], bars: [{x, y, dx, dy, style, right}],
 * stems: [{points, style}], strips: [{colour, runs: [[from, to, row]]}], each as high as one unit of y from its row on,
 * verticals: [{name, at, style}], labels: [{x, y, text}], onpick(x, y, distance), onrange(range|null), square, compact,
 * shades: [[low, high]], grips: [{name, at, label, words, low, high, step, onmove(value, moving)}], lines that are dragged along x}.
 * `update(spec)` draws it anew and keeps the zoom.
 */
export function chart(first) {
  let spec = first;
  let zoom = null;
  let width = 0;
  const svg = s("svg", { class: "chart", tabindex: 0, role: "img" });
  const readout = h("div", { class: "readout", hidden: true });
  const legend = h("div", { class: "legend" });
  const caption = h("figcaption", {});
  const title = h("p", { class: "figure-title" });
  const figure = h("figure", {}, title, legend, h("div", { class: "plot-holder" }, svg, readout), caption);
  const hidden = new Set();
  let axes = null;

  function draw() {
    title.replaceChildren(...unbroken(spec.title ?? ""));
    caption.replaceChildren(...unbroken(spec.caption ?? ""));
    drawLegend();
    svg.setAttribute("aria-label", `${spec.title ?? "chart"}: ${spec.y.label} over ${spec.x.label}. Arrow keys move, plus and minus zoom, 0 shows all.`);
    svg.setAttribute("role", spec.grips ? "group" : "img");
    // what is not laid out has its words, and gets its curves with its width
    if (!width) return;
    const height = spec.square ? Math.min(width, 460) : spec.height ?? 300;
    const wide = spec.square ? Math.min(width, 460) : width;
    svg.setAttribute("viewBox", `0 0 ${wide} ${height}`);
    svg.setAttribute("width", wide);
    svg.setAttribute("height", height);
    const margin = spec.compact ? COMPACT : MARGIN;
    const right = spec.right ? (spec.compact ? 34 : 52) : margin.right;
    // wider numbers than usual push the label outwards
    const numbers = ticks(ruler(spec.y.range, [height - margin.bottom, margin.top], spec.y.log).ends, rows(height - margin.bottom - margin.top), spec.y.log, spec.y.step);
    const left = Math.max(margin.left, (spec.compact ? 0 : LABEL_PX) + LETTER_PX * Math.max(0, ...numbers.map(([, text]) => text.length)));
    const box = { left, right: wide - right, top: margin.top, bottom: height - margin.bottom };
    const x = ruler(zoom ?? spec.x.range, [box.left, box.right], spec.x.log);
    const y = ruler(spec.y.range, [box.bottom, box.top], spec.y.log);
    const y2 = spec.right ? ruler(spec.right.range, [box.bottom, box.top]) : y;
    axes = { box, x, y, y2 };
    const clip = `clip-${Math.round(box.right)}-${Math.round(box.bottom)}`;
    redraw(svg,
      s("defs", {}, s("clipPath", { id: clip }, s("rect", { x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top }))),
      ...frame(box, x, y, y2),
      s("g", { "clip-path": `url(#${clip})` }, ...content(box, x, y, y2)),
      ...grips(box, x),
    );
  }

  function frame(box, x, y, y2) {
    const parts = (spec.shades ?? []).map(([low, high]) => {
      const [from, to] = [low, high].map((value) => Math.max(box.left, Math.min(box.right, x.place(value))));
      return s("rect", { class: "shade", x: from, y: box.top, width: Math.max(0, to - from), height: box.bottom - box.top });
    });
    const columns = ticks(x.ends, Math.max(spec.x.names ? 1 : LEAST_TICKS, (box.right - box.left) / 90), spec.x.log, spec.x.step);
    const last = columns.length - 1;
    for (const [k, [value, text]] of columns.entries()) {
      const at = x.place(value);
      parts.push(s("line", { class: "grid", x1: at, x2: at, y1: box.top, y2: box.bottom }));
      parts.push(s("text", { x: at, y: box.bottom + 16, "text-anchor": spec.compact && k === last && box.right - at < UNIT_PX ? "end" : "middle" }, spec.x.names ? (spec.x.names[value] ?? "") : spec.compact && k === last ? `${text} ${spec.x.unit}` : text));
    }
    for (const [value, text] of ticks(y.ends, rows(box.bottom - box.top), spec.y.log, spec.y.step)) {
      const at = y.place(value);
      parts.push(s("line", { class: "grid", x1: box.left, x2: box.right, y1: at, y2: at }));
      parts.push(s("text", { x: box.left - 6, y: at + 4, "text-anchor": "end" }, text));
    }
    if (spec.right) {
      for (const [value, text] of ticks(y2.ends, rows(box.bottom - box.top))) {
        parts.push(s("text", { x: box.right + 6, y: y2.place(value) + 4 }, text));
      }
      if (spec.compact) parts.push(s("text", { x: box.right + 30, y: 11, "text-anchor": "end" }, spec.right.label));
      else parts.push(turned(`${spec.right.label} (${spec.right.unit})`, box.right + 44, (box.top + box.bottom) / 2));
    }
    parts.push(s("rect", { class: "frame", x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top }));
    if (spec.compact) {
      parts.push(s("text", { x: box.left, y: 11 }, [spec.y.unit, spec.y.label].filter(Boolean).join(", ")));
      return parts;
    }
    parts.push(s("text", { x: (box.left + box.right) / 2, y: box.bottom + 35, "text-anchor": "middle" }, `${spec.x.label} (${spec.x.unit})`));
    parts.push(turned(`${spec.y.label} (${spec.y.unit})`, 14, (box.top + box.bottom) / 2));
    return parts;
  }

  function grips(box, x) {
    return (spec.grips ?? []).map(({ name, at, label, words, low, high }, k) => {
      const middle = x.place(at);
      const caught = { x: middle - GRIP[1], y: box.top, width: 2 * GRIP[1], height: box.bottom - box.top };
      const half = (box.top + box.bottom) / 2;
      return s("g", { class: "grip", tabindex: 0, role: "slider", id: name, "data-focus": name, "data-grip": k, "aria-label": label, "aria-valuemin": low, "aria-valuemax": high, "aria-valuenow": at, "aria-valuetext": words(at) },
        s("rect", { class: "caught", ...caught }), s("path", { d: `M${middle} ${box.top}V${box.bottom}` }), s("rect", { x: middle - GRIP[0], y: half - 9, width: 2 * GRIP[0], height: 18, rx: 2 }));
    });
  }

  /** Moves a grip; `moving` is true during a drag. */
  function pull(k, value, moving) {
    const { low, high, onmove } = spec.grips[k];
    onmove(Math.max(low, Math.min(high, value)), moving);
  }

  function turned(text, x, y) {
    return s("text", { transform: `translate(${x} ${y}) rotate(-90)`, "text-anchor": "middle" }, text);
  }

  function content(box, x, y, y2) {
    const high = Math.abs(y.place(1) - y.place(0));
    const run = ([from, to, row]) => `M${x.place(from).toFixed(1)} ${y.place(row + 0.5).toFixed(1)}H${(x.place(to) + 0.3).toFixed(1)}`;
    const parts = (spec.strips ?? []).map(({ colour, runs }) => s("path", { stroke: colour, "stroke-width": high + 0.3, d: runs.map(run).join("") }));
    for (const { at, style, name } of (spec.verticals ?? []).filter((line) => !hidden.has(line.name))) {
      const d = Array.from(at, (value) => x.place(value)).filter((p) => p >= box.left && p <= box.right).map((p) => `M${p.toFixed(1)} ${box.top}V${box.bottom}`);
      parts.push(s("path", { class: style, d: d.join(""), "data-name": name }));
    }
    for (const { at, style } of spec.horizontals ?? []) {
      parts.push(s("path", { class: style, d: `M${box.left} ${y.place(at)}H${box.right}` }));
    }
    for (const series of (spec.series ?? []).filter((one) => !hidden.has(one.name))) {
      parts.push(s("path", { class: `line ${series.style}`, d: path(series, x, series.right ? y2 : y, box), "data-name": series.name }));
    }
    for (const { points, style } of spec.stems ?? []) {
      parts.push(s("path", { class: style, d: points.map(([px, py]) => `M${x.place(px)} ${y.place(0)}V${y.place(py)}`).join("") }));
    }
    for (const { x: px, y: py, dx, dy, style, right } of spec.bars ?? []) {
      const up = right ? y2 : y;
      const [a, b, c, d] = [x.place(px - dx), x.place(px + dx), up.place(py - dy), up.place(py + dy)];
      const [cx, cy] = [x.place(px), up.place(py)];
      parts.push(s("path", { class: style, d: `M${a} ${cy}H${b}M${cx} ${c}V${d}M${a} ${cy - 3}v6M${b} ${cy - 3}v6M${cx - 3} ${c}h6M${cx - 3} ${d}h6` }));
    }
    for (const group of (spec.marks ?? []).filter((one) => !hidden.has(one.name))) {
      const d = group.points.map(([px, py]) => sign(group.sign, x.place(px), (group.right ? y2 : y).place(py)));
      parts.push(s("path", { class: `mark ${group.style}`, d: d.join(""), "data-name": group.name }));
    }
    const places = placed(spec.labels ?? [], box, x, y);
    parts.push(...(spec.labels ?? []).map(({ text }, k) => s("text", { class: "label", ...places[k] }, text)));
    return parts;
  }

  /** Places labels beside their points without overlap; a label without room goes right above. */
  function placed(labels, box, x, y) {
    const taken = [];
    return labels.map(({ x: px, y: py, text }) => {
      const [wide, high] = [text.length * SMALL_PX[0], SMALL_PX[1]];
      const corners = [[7, -5], [7, 5 + high], [-7 - wide, -5], [-7 - wide, 5 + high]].map(([dx, dy]) => ({ x: x.place(px) + dx, y: y.place(py) + dy }));
      const isFree = (at) => at.x > box.left && at.x + wide < box.right && at.y - high > box.top && at.y < box.bottom
        && taken.every((other) => at.x > other.x + other.wide || other.x > at.x + wide || Math.abs(at.y - other.y) > high);
      const at = corners.find(isFree) ?? corners[0];
      taken.push({ ...at, wide });
      return at;
    });
  }

  function drawLegend() {
    const all = [...(spec.series ?? []), ...(spec.marks ?? []), ...(spec.verticals ?? [])].filter((one) => one.name);
    legend.replaceChildren(...all.map((one) => {
      const sample = s("svg", { class: "sample", width: 26, height: 14, viewBox: "0 0 26 14", "aria-hidden": "true" });
      const style = one.points ? `mark ${one.style}` : `line ${one.style}`;
      sample.append(s("path", { class: style, d: one.points ? sign(one.sign, 13, 7) : one.at ? "M13 0V14" : "M0 7H26" }));
      const flip = () => {
        if (!hidden.delete(one.name)) hidden.add(one.name);
        draw();
      };
      return h("button", { type: "button", class: "key", "aria-pressed": String(!hidden.has(one.name)), onclick: flip }, sample, one.name);
    }));
  }

  function setZoom(range, quiet) {
    const [low, high] = spec.x.range;
    zoom = range && (range[0] > low || range[1] < high) ? [Math.max(low, range[0]), Math.min(high, range[1])] : null;
    draw();
    if (!quiet) spec.onrange?.(zoom);
  }

  function moved(event) {
    const at = place(event);
    const { box, x, y } = axes;
    if (at.x < box.left || at.x > box.right || at.y < box.top || at.y > box.bottom) {
      readout.hidden = true;
      return;
    }
    const value = x.value(at.x);
    const lines = [`${significant(value, 6)} ${spec.x.unit}`];
    for (const series of (spec.series ?? []).filter((one) => one.name && !hidden.has(one.name))) {
      const k = nearest(series.x, value);
      if (k >= 0 && Number.isFinite(series.y[k])) lines.push(`${series.name}: ${significant(series.y[k], 4)} ${series.right ? spec.right.unit : spec.y.unit}`);
    }
    if (lines.length === 1) lines.push(`${significant(y.value(at.y), 4)} ${spec.y.unit}`);
    const more = spec.onhover?.(value, y.value(at.y), distanceTo(at));
    if (more) lines.push(more);
    readout.textContent = lines.slice(0, 9).join("\n");
    readout.hidden = false;
    const beyond = at.x > (box.left + box.right) / 2;
    readout.style.left = beyond ? "" : `${at.x + 14}px`;
    readout.style.right = beyond ? `${svg.clientWidth - at.x + 14}px` : "";
    readout.style.top = `${Math.max(0, Math.min(at.y, box.bottom - 60))}px`;
  }

  /** Distance in px from a place to data coordinates. */
  function distanceTo(at) {
    return (px, py, right) => Math.hypot(axes.x.place(px) - at.x, (right ? axes.y2 : axes.y).place(py) - at.y);
  }

  function place(event) {
    const sides = svg.getBoundingClientRect();
    const scale = svg.viewBox.baseVal.width / sides.width;
    return { x: (event.clientX - sides.left) * scale, y: (event.clientY - sides.top) * scale };
  }

  let pressed = null;
  let pulled = null;
  let rubber = null;
  svg.addEventListener("pointerdown", (event) => {
    const grip = event.target.closest?.("[data-grip]");
    svg.setPointerCapture?.(event.pointerId);
    if (grip) {
      pulled = Number(grip.dataset.grip);
      grip.focus({ preventScroll: true });
      event.preventDefault();
    } else pressed = place(event);
  });
  svg.addEventListener("pointermove", (event) => {
    if (pulled !== null) {
      pull(pulled, axes.x.value(place(event).x), true);
      return;
    }
    moved(event);
    if (!pressed || spec.still) return;
    const at = place(event);
    rubber?.remove();
    if (Math.abs(at.x - pressed.x) > CLICK) {
      const { box } = axes;
      const [a, b] = [Math.max(box.left, Math.min(at.x, pressed.x)), Math.min(box.right, Math.max(at.x, pressed.x))];
      rubber = s("rect", { class: "rubber", x: a, y: box.top, width: Math.max(0, b - a), height: box.bottom - box.top });
      svg.append(rubber);
    }
  });
  svg.addEventListener("pointerup", (event) => {
    const at = place(event);
    if (pulled !== null) {
      const k = pulled;
      pulled = null;
      pull(k, axes.x.value(at.x), false);
      return;
    }
    const from = pressed;
    pressed = null;
    rubber?.remove();
    if (!from) return;
    if (Math.abs(at.x - from.x) <= CLICK) spec.onpick?.(axes.x.value(at.x), axes.y.value(at.y), distanceTo(at));
    else if (!spec.still) setZoom([axes.x.value(Math.min(at.x, from.x)), axes.x.value(Math.max(at.x, from.x))]);
  });
  svg.addEventListener("pointerleave", () => { readout.hidden = true; });
  svg.addEventListener("dblclick", () => { if (!spec.still) setZoom(null); });
  svg.addEventListener("keydown", (event) => {
    const grip = event.target.dataset?.grip;
    const sense = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (grip !== undefined && sense) {
      const { at, step } = spec.grips[grip];
      event.preventDefault();
      event.stopPropagation();
      pull(Number(grip), at + sense * step * (event.shiftKey ? 10 : 1), false);
      return;
    }
    if (spec.onkey?.(event.key)) {
      event.preventDefault();
      return;
    }
    if (spec.still || event.ctrlKey || event.metaKey || event.altKey) return;
    const [low, high] = zoom ?? spec.x.range;
    const [middle, span] = [(low + high) / 2, high - low];
    const around = (width) => [middle - width / 2, middle + width / 2];
    const keys = {
      ArrowLeft: () => slide(-MOVE * span), ArrowRight: () => slide(MOVE * span), "+": () => setZoom(around(span / ZOOM)),
      "=": () => setZoom(around(span / ZOOM)), "-": () => setZoom(around(span * ZOOM)), 0: () => setZoom(null),
    };
    const slide = (by) => {
      const [first, last] = spec.x.range;
      const shift = Math.max(first - low, Math.min(last - high, by));
      setZoom([low + shift, high + shift]);
    };
    if (keys[event.key]) {
      event.preventDefault();
      keys[event.key]();
    }
  });

  sized(figure, (now) => {
    const wide = Math.max(280, Math.min(1100, Math.round(now.width)));
    if (wide !== width) {
      width = wide;
      draw();
    }
  });
  draw();
  return {
    element: figure,
    svg,
    update: (changed) => {
      spec = { ...spec, ...changed };
      draw();
    },
    zoomTo: (range) => setZoom(range, true),
    /** Place of data coordinates in the window, for tests and for pointers. */
    at: (px, py, right) => {
      const sides = svg.getBoundingClientRect();
      const scale = sides.width / svg.viewBox.baseVal.width;
      return [sides.left + axes.x.place(px) * scale, sides.top + (right ? axes.y2 : axes.y).place(py) * scale];
    },
  };
}

/** Points in one pixel column become one stroke from the least to the largest. */
function path({ x: xs, y: ys, breaks }, x, y, box) {
  const parts = [];
  let pen = false;
  let last = NaN;
  let [column, low, high, end] = [NaN, 0, 0, 0];
  const flush = () => {
    if (high > low) parts.push(`V${low.toFixed(1)}V${high.toFixed(1)}V${end.toFixed(1)}`);
  };
  // one point beyond each end, so that curves reach the frame
  const first = Math.max(0, lower(xs, x.ends[0]) - 1);
  const stop = Math.min(xs.length, lower(xs, x.ends[1]) + 2);
  for (let k = first; k < stop; k++) {
    const value = ys[k];
    const jump = breaks && Math.abs(value - last) > breaks;
    if (!Number.isFinite(value) || jump) {
      flush();
      [pen, column, low, high] = [false, NaN, 0, 0];
    }
    last = value;
    if (!Number.isFinite(value)) continue;
    const px = Math.round(2 * x.place(xs[k])) / 2;
    const py = Math.max(box.top - 2000, Math.min(box.bottom + 2000, y.place(value)));
    if (px === column && pen) {
      low = Math.min(low, py);
      high = Math.max(high, py);
      end = py;
      continue;
    }
    flush();
    parts.push(`${pen ? "L" : "M"}${px} ${py.toFixed(1)}`);
    [pen, column, low, high, end] = [true, px, py, py, py];
  }
  flush();
  return parts.join("");
}

/** Number of ticks along y over so many px. */
function rows(px) {
  return Math.max(LEAST_ROWS, px / ROW_PX);
}

/** Index of the first entry of a rising list that is at least `value`. */
function lower(list, value) {
  let [a, b] = [0, list.length];
  while (a < b) {
    const middle = (a + b) >> 1;
    if (list[middle] < value) a = middle + 1;
    else b = middle;
  }
  return a;
}

function nearest(list, value) {
  const k = lower(list, value);
  if (k === 0) return list.length ? 0 : -1;
  return k < list.length && list[k] - value < value - list[k - 1] ? k : k - 1;
}

function sign(kind, x, y) {
  const [a, b] = [x.toFixed(1), y.toFixed(1)];
  if (kind === "cross") return `M${a} ${b}m-3 -3l6 6m0 -6l-6 6`;
  if (kind === "tiny") return `M${a} ${b}m-1.5 -1.5l3 3m0 -3l-3 3`;
  if (kind === "square") return `M${a} ${b}m-4 -4h8v8h-8z`;
  if (kind === "triangle") return `M${a} ${b}m0 -5l5 8.5h-10z`;
  if (kind === "down") return `M${a} ${b}m-4.5 -4h9l-4.5 8z`;
  if (kind === "bar") return `M${a} ${b}m-3 0h6`;
  const radius = kind === "big" ? 5.5 : kind === "small" ? 1.8 : 3.2;
  return `M${a} ${b}m${-radius} 0a${radius} ${radius} 0 1 0 ${2 * radius} 0a${radius} ${radius} 0 1 0 ${-2 * radius} 0z`;
}

/** Ends of the data with some room on both sides. */
export function padded(lists, part = 0.05, least = null) {
  let [low, high] = ends(lists.flatMap((list) => Array.from(list).filter(Number.isFinite)));
  if (!(low <= high)) [low, high] = [0, 1];
  if (least !== null) low = Math.max(low, high - least);
  const room = (high - low || Math.abs(high) || 1) * part;
  return [low - room, high + room];
}
