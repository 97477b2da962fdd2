// Fields on a grid: values between its points, and contours.

/** A complex surface: columns `x`, rows `y` (m, rising), values {re, im} row by row, NaN where it is not known. */
export function valueAt(surface, part, px, py) {
  const { x, y } = surface;
  const [column, u] = interval(x, px);
  const [row, v] = interval(y, py);
  const corner = (dr, dc) => part[Math.min(row + dr, y.length - 1) * x.length + Math.min(column + dc, x.length - 1)];
  const inside = column > 0 && row > 0 && column + 2 < x.length && row + 2 < y.length;
  if (inside) {
    const along = (dr) => cubic(u, corner(dr, -1), corner(dr, 0), corner(dr, 1), corner(dr, 2));
    const value = cubic(v, along(-1), along(0), along(1), along(2));
    if (Number.isFinite(value)) return value;
  }
  return (1 - v) * ((1 - u) * corner(0, 0) + u * corner(0, 1)) + v * ((1 - u) * corner(1, 0) + u * corner(1, 1));
}

function interval(axis, value) {
  let k = 0;
  while (k < axis.length - 2 && axis[k + 1] <= value) k++;
  return [k, Math.min(1, Math.max(0, (value - axis[k]) / (axis[k + 1] - axis[k])))];
}

/** Cubic interpolation, Catmull & Rom (1974). */
function cubic(t, a, b, c, d) {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/** The surface on square cells in `columns` columns. */
export function refined(surface, columns) {
  const { x, y } = surface;
  const [width, height] = [x[x.length - 1] - x[0], y[y.length - 1] - y[0]];
  const rows = Math.max(2, Math.min(4 * columns, Math.round((columns * height) / width)));
  const axis = (start, span, count) => Float64Array.from({ length: count }, (_, k) => start + (span * k) / (count - 1));
  const out = { x: axis(x[0], width, columns), y: axis(y[0], height, rows) };
  const fill = (part) => {
    const values = new Float64Array(rows * columns);
    for (let row = 0; row < rows; row++) {
      for (let column = 0; column < columns; column++) values[row * columns + column] = valueAt(surface, part, out.x[column], out.y[row]);
    }
    return values;
  };
  return { ...out, re: fill(surface.re), im: surface.im ? fill(surface.im) : null };
}

/** Contours [[x, y], ...] of `values` at `level`, by marching squares; none next to NaN. A closed one ends at its first point. */
export function contours(x, y, values, level) {
  const columns = x.length;
  // sides of the mesh along x are numbered first, then those along y
  const size = columns * y.length;
  const place = (side) => {
    const from = side % size;
    const to = from + (side < size ? 1 : columns);
    const t = (level - values[from]) / (values[to] - values[from]);
    const between = (axis, a, b) => axis[a] + t * (axis[b] - axis[a]);
    return [between(x, from % columns, to % columns), between(y, Math.floor(from / columns), Math.floor(to / columns))];
  };
  return traced(links(columns, y.length, values, level)).map((line) => line.map(place));
}

/** For each crossed side, the one or two sides to which the contour continues. */
function links(columns, rows, values, level) {
  const next = new Map();
  const join = (a, b) => [[a, b], [b, a]].forEach(([from, to]) => next.set(from, [...(next.get(from) ?? []), to]));
  for (let row = 0; row + 1 < rows; row++) {
    for (let column = 0; column + 1 < columns; column++) {
      const k = row * columns + column;
      const corners = [values[k], values[k + 1], values[k + columns + 1], values[k + columns]];
      if (corners.some(Number.isNaN)) continue;
      const sides = [k, columns * rows + k + 1, k + columns, columns * rows + k];
      const crossed = sides.filter((_, n) => corners[n] >= level !== corners[(n + 1) % 4] >= level);
      // a saddle: the mean of the corners decides which corners are joined
      const turn = crossed.length === 4 && corners.reduce((a, b) => a + b) / 4 >= level !== corners[0] >= level;
      if (turn) crossed.push(crossed.shift());
      for (let n = 0; n + 1 < crossed.length; n += 2) join(crossed[n], crossed[n + 1]);
    }
  }
  return next;
}

/** Follows the links from side to side: open lines first, then closed ones. */
function traced(next) {
  const seen = new Set();
  const lines = [];
  for (const links of [1, 2]) {
    for (const [start, { length }] of next) {
      if (length !== links || seen.has(start)) continue;
      const line = [];
      for (let here = start; here !== undefined; here = next.get(here).find((side) => !seen.has(side))) {
        seen.add(here);
        line.push(here);
      }
      lines.push(links === 2 ? [...line, start] : line);
    }
  }
  return lines;
}
