// Zones as shapes: corners, handles, snapping, hit tests. Lengths in m.

/** True for a zone whose sides are parallel to the axes. */
export function isRectangle({ points }) {
  return points.length === 4 && [0, 1].every((k) => new Set(points.map((point) => point[k])).size === 2);
}

/** [x0, y0, x1, y1] around points. */
export function around(points) {
  const [x, y] = [0, 1].map((k) => points.map((point) => point[k]));
  return [Math.min(...x), Math.min(...y), Math.max(...x), Math.max(...y)];
}

export function rectangle([xa, ya], [xb, yb]) {
  const [x0, y0, x1, y1] = around([[xa, ya], [xb, yb]]);
  return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
}

/** True where the points enclose more than a line, m². */
export function hasArea(points, least) {
  return Math.abs(points.reduce((sum, [x, y], k) => {
    const [nx, ny] = points[(k + 1) % points.length];
    return sum + x * ny - nx * y;
  }, 0)) > 2 * least;
}

/** True inside the polygon, by the crossings of a ray. */
export function contains(points, [px, py]) {
  return points.reduce((inside, [x, y], k) => {
    const [nx, ny] = points[(k + points.length - 1) % points.length];
    const crosses = y > py !== ny > py && px < ((nx - x) * (py - y)) / (ny - y) + x;
    return inside !== crosses;
  }, false);
}

/** Handles of a zone: corners and middles of the sides of a rectangle, corners of a polygon. */
export function handles(zone) {
  if (!isRectangle(zone)) return zone.points.map((at, corner) => ({ at, corner }));
  const [x0, y0, x1, y1] = around(zone.points);
  const sides = [-1, 0, 1].flatMap((sy) => [-1, 0, 1].map((sx) => [sx, sy])).filter(([sx, sy]) => sx || sy);
  return sides.map((side) => ({ at: [(x0 + x1 + side[0] * (x1 - x0)) / 2, (y0 + y1 + side[1] * (y1 - y0)) / 2], side }));
}

/** The points of the zone after a handle was moved to `to`. */
export function pulled(zone, { side, corner }, to) {
  if (side === undefined) return zone.points.map((point, k) => (k === corner ? to : point));
  const ends = around(zone.points);
  side.forEach((sense, k) => { if (sense) ends[sense < 0 ? k : k + 2] = to[k]; });
  return rectangle([ends[0], ends[1]], [ends[2], ends[3]]);
}

/** Rasters to choose from: a step, and cells into which the panel is divided. */
export const SNAPS = [
  { name: "10 mm, cells 2 × 2", step: 0.01, cells: [2, 2] },
  { name: "cells 4 × 4", step: 0, cells: [4, 4] },
  { name: "cells 8 × 8", step: 0, cells: [8, 8] },
  { name: "5 mm", step: 0.005, cells: [1, 1] },
  { name: "off (1 mm)", step: 0.001, cells: null },
];

/** Distance at which lines of cells and sides of the panel catch a point, part of the panel's longer side. */
const CATCH = 0.02;
/** Resolution of places, m. */
const FINEST = 0.001;

/** `place` on the raster of `snap`, inside `ends`. */
export function snapped(place, snap, box, ends) {
  const reach = CATCH * Math.max(box[2] - box[0], box[3] - box[1]);
  return place.map((value, k) => {
    const inside = Math.min(ends[k + 2], Math.max(ends[k], value));
    const lines = snap.cells ? Array.from({ length: snap.cells[k] + 1 }, (_, n) => box[k] + (n / snap.cells[k]) * (box[k + 2] - box[k])) : [];
    const line = lines.reduce((best, at) => (Math.abs(at - inside) < Math.abs(best - inside) ? at : best), Infinity);
    const onLine = Number.isFinite(line) && (!snap.step || Math.abs(line - inside) < reach);
    return Math.round((onLine ? line : Math.round(inside / snap.step) * snap.step) / FINEST) * FINEST;
  });
}

/** `hot zone: 100 × 60 mm at 80, 60`. */
export function inWords(zone) {
  const [x0, y0, x1, y1] = around(zone.points).map((value) => Math.round(1e3 * value));
  return `${zone.kind} zone: ${x1 - x0} × ${y1 - y0} mm at ${x0}, ${y0}`;
}
