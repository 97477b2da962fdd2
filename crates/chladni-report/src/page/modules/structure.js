// The measured structure in space: its lines and faces at rest in grey, and moving with a mode; axes in the corner.

import { array } from "./data.js";
import { colourAt, themeColour } from "./colour.js";
import { turnedShape } from "./complexity.js";

/** Length of the axes in the corner, px. */
const AXIS_PX = 26;
const DOT_PX = 3.5;

/** The structure with its numbers unpacked; null where there is none. */
export function unpackStructure(structure) {
  if (!structure) return null;
  const xyz = array(structure.xyz);
  return { ...structure, xyz, count: xyz.length / 3, joined: structure.lines.length + structure.faces.length > 0 };
}

/** Motion of every node in a mode, {re, im} with three parts a node, and which nodes were measured. */
export function motionOf(model, structure, n) {
  const all = model.responses.map((_, k) => k);
  const shape = turnedShape(model, n, all, all.map(() => 1));
  const out = { re: new Float64Array(3 * structure.count), im: new Float64Array(3 * structure.count), measured: new Uint8Array(structure.count) };
  structure.moves.forEach((moves, k) => {
    if (!moves) return;
    const [node, ...to] = moves;
    out.measured[node] = 1;
    to.forEach((part, axis) => {
      out.re[3 * node + axis] += shape.re[k] * part;
      out.im[3 * node + axis] += shape.im[k] * part;
    });
  });
  return out;
}

/** Draws the structure at a phase; `camera(x, y, z)` gives px and depth, `lift` is m per unit of motion. */
export function drawStructure(context, camera, { structure, motion }, phase, lift) {
  const { xyz, count, lines, faces } = structure;
  const [c, s] = [Math.cos(phase), Math.sin(phase)];
  const rest = [];
  const now = [];
  for (let k = 0; k < count; k++) {
    const by = [0, 1, 2].map((axis) => motion.re[3 * k + axis] * c - motion.im[3 * k + axis] * s);
    rest.push(camera(xyz[3 * k], xyz[3 * k + 1], xyz[3 * k + 2]));
    const level = by.reduce((most, part) => (Math.abs(part) > Math.abs(most) ? part : most), 0);
    now.push({ at: camera(xyz[3 * k] + by[0] * lift, xyz[3 * k + 1] + by[1] * lift, xyz[3 * k + 2] + by[2] * lift), level, moves: motion.measured[k] });
  }
  const [ink, muted] = ["--ink", "--muted"].map(themeColour);
  const path = (points, closed) => {
    context.beginPath();
    points.forEach(([x, y], n) => (n ? context.lineTo(x, y) : context.moveTo(x, y)));
    if (closed) context.closePath();
  };
  context.lineWidth = 1;
  context.strokeStyle = muted;
  context.globalAlpha = 0.55;
  context.setLineDash([4, 3]);
  for (const face of faces) path(face.map((k) => rest[k]), true), context.stroke();
  for (const line of lines) path(line.map((k) => rest[k])), context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
  const colour = (level) => `rgb(${colourAt("diverging", 0.5 + 0.5 * level).join(",")})`;
  const whole = faces.filter((face) => face.every((k) => now[k].moves)).map((face) => ({ face, depth: face.reduce((sum, k) => sum + now[k].at[2], 0) / face.length }));
  whole.sort((a, b) => b.depth - a.depth);
  for (const { face } of whole) {
    path(face.map((k) => now[k].at), true);
    context.fillStyle = colour(face.reduce((sum, k) => sum + now[k].level, 0) / face.length);
    context.fill();
    context.strokeStyle = ink;
    context.globalAlpha = 0.5;
    context.stroke();
    context.globalAlpha = 1;
  }
  context.strokeStyle = ink;
  context.lineWidth = 2;
  for (const line of lines) {
    for (let n = 0; n + 1 < line.length; n++) {
      const [a, b] = [now[line[n]], now[line[n + 1]]];
      if (a.moves && b.moves) path([a.at, b.at]), context.stroke();
    }
  }
  context.lineWidth = 1;
  for (const { at, level, moves } of now) {
    context.beginPath();
    context.arc(at[0], at[1], moves ? DOT_PX : DOT_PX - 1, 0, 7);
    context.fillStyle = moves ? colour(level) : themeColour("--paper");
    context.strokeStyle = moves ? ink : muted;
    context.fill();
    context.stroke();
  }
}

/** The axes x, y and z in a corner. */
export function drawAxes(context, seen, height) {
  context.strokeStyle = themeColour("--muted");
  context.fillStyle = themeColour("--muted");
  context.font = "11px system-ui, sans-serif";
  context.lineWidth = 1.2;
  const [x, y] = [AXIS_PX + 12, height - AXIS_PX - 12];
  [[1, 0, 0, "x"], [0, 1, 0, "y"], [0, 0, 1, "z"]].forEach(([a, b, c, name]) => {
    const [right, up] = seen(a, b, c);
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + AXIS_PX * right, y - AXIS_PX * up);
    context.stroke();
    context.fillText(name, x + (AXIS_PX + 8) * right - 3, y - (AXIS_PX + 8) * up + 4);
  });
}
