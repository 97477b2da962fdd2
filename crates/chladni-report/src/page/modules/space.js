// A moving surface in perspective: mode shapes and fields in three dimensions.

import { h, sized } from "./dom.js";
import { colourAt, themeColour } from "./colour.js";
import { drawAxes, drawStructure } from "./structure.js";

/** Drawn size of the largest motion, part of the longer side. */
const HEIGHT = 0.16;
/** Periods in a second. */
const PACE = 0.5;
const TURN = 0.12;

/**
 * A canvas that shows `surface` {x, y, re, im} (m; any unit of motion), or a `structure` with its `motion`.
 * `set` changes what is shown; motion is Re(z·e^{jφ}).
 */
export function space(label) {
  const canvas = h("canvas", { class: "space", tabindex: 0, role: "img", "aria-label": `${label}: arrow keys turn it, blank starts and stops it` });
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let shown = null;
  let [azimuth, elevation] = [-0.6, 0.62];
  let [phase, playing, last, width] = [0, !still, 0, 0];
  let visible = false;
  let frame = 0;

  const button = h("button", { type: "button", onclick: () => play(!playing) }, playing ? "Pause" : "Play");
  const element = h("div", { class: "space-holder" }, canvas, h("p", { class: "controls" }, button, h("span", { class: "muted" }, " Drag or arrow keys turn it.")));

  function play(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    schedule();
  }

  function schedule() {
    if (!frame && visible) frame = requestAnimationFrame(step);
  }

  function step(now) {
    frame = 0;
    if (playing) phase += 2 * Math.PI * PACE * Math.min(0.1, (now - last) / 1000);
    last = now;
    paint();
    if (playing) schedule();
  }

  function paint() {
    if (!shown || !width) return;
    const ratio = Math.min(2, devicePixelRatio || 1);
    const height = Math.round(0.62 * width);
    canvas.style.height = `${height}px`;
    canvas.style.width = `${width}px`;
    if (canvas.width !== Math.round(width * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const camera = view(shown, width, height);
    if (shown.surface) mesh(context, camera);
    else drawStructure(context, camera, shown, phase, (HEIGHT * shown.size) / shown.largest);
    drawAxes(context, turnedAxis, height);
  }

  /** A direction in the view, without perspective: right and up. */
  function turnedAxis(x, y, z) {
    const away = x * Math.sin(azimuth) + y * Math.cos(azimuth);
    return [x * Math.cos(azimuth) - y * Math.sin(azimuth), z * Math.cos(elevation) + away * Math.sin(elevation)];
  }

  /** The projection from m to px that shows the whole box around the motion. */
  function view({ centre: [cx, cy, cz], sides, size }, width, height) {
    const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
    const seen = (x, y, z) => {
      const [u, v, w] = [x - cx, y - cy, z - cz];
      const [right, away] = [u * ca - v * sa, u * sa + v * ca];
      const depth = away * ce - w * se;
      const near = 1 / (1 + (0.35 * depth) / size);
      return [right * near, (w * ce + away * se) * near, depth];
    };
    const lift = HEIGHT * size;
    // a surface moves up and down, a structure in any direction
    const wide = shown.surface ? sides : sides.map(([low, high], axis) => (axis < 2 && high > low ? [low, high] : [low - lift, high + lift]));
    const corners = wide[0].flatMap((x) => wide[1].flatMap((y) => [sides[2][0] - lift, sides[2][1] + lift].map((z) => seen(x, y, z))));
    const [[left, right], [low, high]] = [0, 1].map((k) => [Math.min(...corners.map((corner) => corner[k])), Math.max(...corners.map((corner) => corner[k]))]);
    const zoom = 0.97 * Math.min(width / (right - left), height / (high - low));
    return (x, y, z) => {
      const [across, up, depth] = seen(x, y, z);
      return [width / 2 + (across - (left + right) / 2) * zoom, height / 2 - (up - (low + high) / 2) * zoom, depth];
    };
  }

  function motion(re, im) {
    return re * Math.cos(phase) - im * Math.sin(phase);
  }

  function mesh(context, camera) {
    const { x, y, re, im } = shown.surface;
    const lift = (HEIGHT * shown.size) / shown.largest;
    const columns = x.length;
    const points = Array.from(re, (value, k) => {
      const now = motion(value, im[k]) / 1;
      return { now, at: camera(x[k % columns], y[Math.floor(k / columns)], now * lift) };
    });
    const quads = [];
    for (let row = 0; row + 1 < y.length; row++) {
      for (let column = 0; column + 1 < columns; column++) {
        const k = row * columns + column;
        const corners = [points[k], points[k + 1], points[k + columns + 1], points[k + columns]];
        if (corners.some((corner) => Number.isNaN(corner.now))) continue;
        quads.push({ corners, depth: corners.reduce((sum, corner) => sum + corner.at[2], 0) });
      }
    }
    quads.sort((a, b) => b.depth - a.depth);
    const ink = themeColour("--ink");
    context.lineWidth = 0.4;
    for (const { corners } of quads) {
      const mean = corners.reduce((sum, corner) => sum + corner.now, 0) / 4;
      context.beginPath();
      corners.forEach(({ at }, n) => (n ? context.lineTo(at[0], at[1]) : context.moveTo(at[0], at[1])));
      context.closePath();
      context.fillStyle = `rgb(${colourAt("diverging", 0.5 + (0.5 * mean) / shown.largest).join(",")})`;
      context.fill();
      context.globalAlpha = 0.35;
      context.strokeStyle = ink;
      context.stroke();
      context.globalAlpha = 1;
    }
  }

  function turn(right, up) {
    azimuth += right;
    elevation = Math.max(-1.5, Math.min(1.5, elevation + up));
    schedule();
    if (!playing) paint();
  }

  canvas.addEventListener("pointermove", (event) => { if (event.buttons) turn(0.008 * event.movementX, 0.008 * event.movementY); });
  canvas.addEventListener("keydown", (event) => {
    const keys = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, TURN], ArrowDown: [0, -TURN] };
    if (keys[event.key]) turn(...keys[event.key]);
    else if (event.key === " ") play(!playing);
    else return;
    event.preventDefault();
  });
  sized(element, (now) => {
    width = Math.min(620, Math.round(now.width));
    paint();
  });
  new IntersectionObserver(([entry]) => {
    visible = entry.isIntersecting;
    schedule();
  }).observe(canvas);

  return {
    element,
    canvas,
    set: (next) => {
      const { surface, structure } = next;
      const xyz = structure?.xyz;
      const axis = (k) => (surface ? [surface.x, surface.y, [0]][k] : Array.from({ length: xyz.length / 3 }, (_, n) => xyz[3 * n + k]));
      const sides = [0, 1, 2].map((k) => [Math.min(...axis(k)), Math.max(...axis(k))]);
      const { re, im } = surface ?? next.motion;
      const largest = Array.from(re, (value, k) => Math.hypot(value, im[k])).reduce((most, value) => (value > most ? value : most), 0) || 1;
      shown = { ...next, re, im, largest, sides, centre: sides.map(([low, high]) => (low + high) / 2), size: Math.max(...sides.map(([low, high]) => high - low)) || 1 };
      paint();
      schedule();
    },
  };
}
