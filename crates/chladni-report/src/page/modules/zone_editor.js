// Zones on the panel: drawn, moved, resized and deleted by pointer or by keys, over whatever the board shows.

import { h, choice } from "./dom.js";
import { panelMap } from "./panel_map.js";
import { SNAPS, around, contains, handles, hasArea, inWords, pulled, rectangle, snapped } from "./zone_shapes.js";

/** Largest distance at which a handle is caught, px. */
const REACH = 12;
/** Steps of the arrow keys, m. */
const [STEP, LARGE_STEP, CURSOR_STEP] = [0.001, 0.01, 0.005];
/** Least area of a zone, m²; smaller ones are accidents. */
const LEAST_AREA = 1e-6;

const KINDS = ["hot", "cold", "ignore"];
const TOOL_KEYS = { v: "select", h: "hot", c: "cold", i: "ignore", p: "polygon" };

/**
 * A board for zones [{kind, points, level_db}]. `spec`: {zones, id, tool, bare, onzones(zones, moving), onselect(index or null), onpress(place): true
 * where the press is taken}. `set(zones)` shows others; `show(layers)` puts pixels, contours and marks under them.
 */
export function zoneEditor(geometry, spec) {
  let zones = spec.zones;
  let tool = spec.tool;
  let kind = "hot";
  let snap = SNAPS[0];
  let selected = null;
  // the current drag: {new: {kind, from, points}} or {zone, before, from, handle}
  let drag = null;
  let polygon = null;
  let cursor = null;
  let under = {};
  const plainMarks = [{ points: geometry.places, style: "response", mark: "dot" }, { points: geometry.references.filter(Boolean), style: "actuator", mark: "ring" }];
  const map = panelMap(geometry.box, geometry.axes, "Panel with its zones: arrow keys move a corner, Enter sets it; Tab goes to the zones", spec.bare ? 900 : 640, spec.bare);
  map.svg.id = spec.id;
  map.svg.classList.add("board");
  map.svg.setAttribute("role", "group");
  if (spec.bare) map.element.classList.add("bare");
  const said = h("p", { class: "spoken", role: "status" });

  const onRaster = (place, free = false) => snapped(place, free ? SNAPS[SNAPS.length - 1] : snap, geometry.box, map.ends);
  const shown = () => {
    const fresh = drag?.new ?? (polygon && { kind: polygon.kind, points: polygon.points });
    return fresh && fresh.points.length > 2 && hasArea(fresh.points, LEAST_AREA) ? [...zones, { kind: fresh.kind, points: fresh.points }] : zones;
  };

  function select(index) {
    if (index === selected) return;
    selected = index;
    if (index !== null) said.textContent = inWords(zones[index]);
    spec.onselect?.(index);
    draw();
  }

  function put(next, moving = false) {
    zones = next;
    if (selected !== null && selected >= zones.length) select(null);
    draw();
    spec.onzones(shown(), moving);
  }

  function changed(index, points, moving) {
    put(zones.map((zone, k) => (k === index ? { ...zone, points } : zone)), moving);
    if (!moving) said.textContent = inWords(zones[index]);
  }

  function draw() {
    const outline = ({ kind: of, points, level_db: level }, k) => ({
      points, style: `${of}-zone${k === selected ? " selected" : ""}`, text: level ? `${of} +${level} dB` : of, id: k, label: `${inWords({ kind: of, points })}. Arrow keys move it, with Ctrl they resize it, Delete removes it.`,
    });
    const fresh = drag?.new ?? polygon;
    const open = fresh ? [{ points: fresh.points, style: `${fresh.kind}-zone open`, text: fresh.kind }] : [];
    const [x0, y0, x1, y1] = geometry.box;
    map.draw({
      ...under,
      outlines: [{ points: [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], style: "area" }, ...zones.map(outline), ...open],
      marks: under.marks ?? plainMarks,
      front: (tools) => [...atCursor(tools), ...grips(tools)],
    });
  }

  function atCursor({ px, s }) {
    if (!cursor) return [];
    const [x, y] = px(cursor);
    return [s("path", { class: "cursor", d: `M${x} ${y}m-4 -4l8 8m0 -8l-8 8` })];
  }

  /** Handles of the selected zone, guides and size while it moves. */
  function grips({ px, s }) {
    const zone = drag?.new ?? zones[selected];
    if (!zone || zone.points.length < 3) return [];
    const parts = [];
    if (drag) {
      const [x0, y0, x1, y1] = around(zone.points);
      const [[left, top], [right, bottom]] = [px([map.ends[0], map.ends[3]]), px([map.ends[2], map.ends[1]])];
      const [[a, b], [c, d]] = [px([x0, y1]), px([x1, y0])];
      parts.push(s("path", { class: "guide", d: `M${a} ${top}V${bottom}M${c} ${top}V${bottom}M${left} ${b}H${right}M${left} ${d}H${right}` }));
      parts.push(s("text", { class: "size", x: (a + c) / 2, y: Math.max(top + 12, b - 6), "text-anchor": "middle" }, inWords(zone)));
    }
    if (zone === zones[selected]) {
      for (const { at } of handles(zone)) {
        const [x, y] = px(at);
        parts.push(s("rect", { class: "handle", x: x - 4.5, y: y - 4.5, width: 9, height: 9, rx: 2 }));
      }
    }
    return parts;
  }

  /** The handle of the selected zone near a place, or the zone there, the last drawn first. */
  function meet(place) {
    const near = REACH / map.scale();
    const far = ({ at }) => Math.hypot(at[0] - place[0], at[1] - place[1]);
    if (zones[selected]) {
      const [best] = handles(zones[selected]).sort((a, b) => far(a) - far(b));
      if (far(best) <= near) return { zone: selected, handle: best };
    }
    const index = zones.findLastIndex((zone) => contains(zone.points, place));
    return index < 0 ? null : { zone: index };
  }

  map.svg.addEventListener("pointerdown", (event) => {
    const place = map.where(event);
    const at = onRaster(place, event.altKey);
    event.preventDefault();
    cursor = null;
    if (tool === "select") {
      if (spec.onpress?.(place)) return;
      const met = meet(place);
      select(met ? met.zone : null);
      if (!met) return map.svg.focus({ preventScroll: true });
      map.svg.querySelector(`[data-focus="zone-${met.zone}"]`)?.focus({ preventScroll: true });
      drag = { ...met, before: zones[met.zone], from: place };
    } else if (tool === "polygon") {
      polygon = { kind, points: [...(polygon?.points ?? []), at] };
      draw();
      return;
    } else drag = { new: { kind, from: at, points: rectangle(at, at) } };
    map.svg.setPointerCapture?.(event.pointerId);
  });
  map.svg.addEventListener("pointermove", (event) => {
    if (!drag || !event.buttons) return;
    const place = map.where(event);
    if (drag.new) {
      drag.new.points = rectangle(drag.new.from, onRaster(place, event.altKey));
      put(zones, true);
    } else changed(drag.zone, dragged(place, event.altKey), true);
  });
  map.svg.addEventListener("pointerup", (event) => {
    const done = drag;
    drag = null;
    if (done?.new) finish(done.new);
    else if (done && zones[done.zone] !== done.before) changed(done.zone, zones[done.zone].points, false);
  });
  map.svg.addEventListener("dblclick", () => finish(polygon));
  map.svg.addEventListener("focusin", ({ target }) => { if (target.dataset.zone !== undefined) select(Number(target.dataset.zone)); });

  /** Points of the dragged zone with the pointer at `place`; its lower left corner snaps to the raster. */
  function dragged(place, free) {
    const { before, from, handle } = drag;
    if (handle) return pulled(before, handle, onRaster(place, free));
    const [x0, y0] = around(before.points);
    const corner = onRaster([x0 + place[0] - from[0], y0 + place[1] - from[1]], free);
    return moved(before.points, corner[0] - x0, corner[1] - y0);
  }

  /** The points, shifted as far as they stay on the board. */
  function moved(points, dx, dy) {
    const [x0, y0, x1, y1] = around(points);
    const [left, low, right, high] = map.ends;
    const [byX, byY] = [Math.max(left - x0, Math.min(right - x1, dx)), Math.max(low - y0, Math.min(high - y1, dy))];
    return points.map(([x, y]) => [x + byX, y + byY]);
  }

  /** Adds the new zone if it is large enough. */
  function finish(fresh) {
    polygon = null;
    if (!fresh || fresh.points.length < 3 || !hasArea(fresh.points, LEAST_AREA)) return draw();
    put([...zones, { kind: fresh.kind, points: fresh.points }]);
    said.textContent = inWords(fresh);
    if (spec.tool === "select") {
      setTool("select");
      select(zones.length - 1);
    }
  }

  function remove(index) {
    selected = null;
    spec.onselect?.(null);
    put(zones.filter((_, k) => k !== index));
    map.svg.focus({ preventScroll: true });
  }

  map.svg.addEventListener("keydown", (event) => {
    if (event.altKey || event.metaKey || (event.ctrlKey && !event.key.startsWith("Arrow"))) return;
    const taken = tool === "select" && zones[selected] ? zoneKey(event) : drawKey(event);
    if (!taken) return;
    event.preventDefault();
    event.stopPropagation();
  });

  function zoneKey(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (event.key === "Delete" || event.key === "Backspace") remove(selected);
    else if (event.key === "Escape") select(null);
    else if (way) {
      const [dx, dy] = way.map((sense) => sense * (event.shiftKey ? LARGE_STEP : STEP));
      const zone = zones[selected];
      const [x0, y0, x1, y1] = around(zone.points);
      const corner = handles(zone).find((one) => one.side?.[0] === 1 && one.side[1] === 1);
      if (!event.ctrlKey) changed(selected, moved(zone.points, dx, dy), false);
      else if (corner && x1 + dx > x0 && y1 + dy > y0) changed(selected, pulled(zone, corner, snapped([x1 + dx, y1 + dy], SNAPS[SNAPS.length - 1], geometry.box, map.ends)), false);
    } else return false;
    return true;
  }

  function drawKey(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const middle = () => onRaster([(geometry.box[0] + geometry.box[2]) / 2, (geometry.box[1] + geometry.box[3]) / 2], true);
    if (tool === "select") return false;
    if (way) {
      cursor = cursor ? onRaster([cursor[0] + way[0] * CURSOR_STEP, cursor[1] + way[1] * CURSOR_STEP], true) : middle();
      if (drag?.new) drag.new.points = rectangle(drag.new.from, cursor);
    } else if (event.key === "Enter") {
      cursor ??= middle();
      if (tool === "polygon") polygon = { kind, points: [...(polygon?.points ?? []), cursor] };
      else if (drag?.new) {
        const done = drag.new;
        drag = null;
        finish(done);
        return true;
      } else drag = { new: { kind, from: cursor, points: rectangle(cursor, cursor) } };
    } else if (event.key === "Escape" && (drag || polygon)) [drag, polygon] = [null, null];
    else return false;
    draw();
    spec.onzones(shown(), true);
    return true;
  }

  const radios = ["select", ...KINDS, "polygon"].filter((name) => name !== "select" || spec.tool === "select").map((name) => {
    const input = h("input", { type: "radio", name: `${spec.id}-tool`, value: name, checked: name === tool, onchange: () => setTool(name) });
    return { name, input, element: h("label", { class: "segment" }, input, name[0].toUpperCase() + name.slice(1)) };
  });
  const close = h("button", { type: "button", hidden: true, onclick: () => finish(polygon) }, "Close polygon");

  function setTool(name) {
    tool = name;
    if (KINDS.includes(name)) kind = name;
    [drag, polygon] = [null, null];
    radios.forEach((one) => (one.input.checked = one.name === name));
    close.hidden = name !== "polygon";
    if (name !== "select" && selected !== null) select(null);
    else draw();
  }

  const snaps = choice("Snap", SNAPS.map((one) => one.name), 0, (k) => (snap = SNAPS[k]));
  draw();
  return {
    element: map.element,
    tools: h("div", { class: "controls" }, h("div", { class: "segments", role: "radiogroup", "aria-label": "What the pointer does" }, radios.map((one) => one.element)), close, snaps.element, said),
    map,
    /** Handles a key; true where it chose a tool. */
    toolKey: (key) => {
      const name = TOOL_KEYS[key];
      if (name && radios.some((one) => one.name === name)) setTool(name);
      return Boolean(name);
    },
    set: (next) => {
      zones = next;
      if (selected !== null && !zones[selected]) select(null);
      draw();
    },
    put,
    remove,
    show: (layers) => {
      under = layers;
      draw();
    },
    zones: () => zones,
  };
}
