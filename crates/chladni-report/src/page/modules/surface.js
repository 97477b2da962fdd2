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

/** Catmull & Rom (1974). */
function cubic(t, a, b, c, d) {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/** The surface on so many columns of square cells. */
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

/** Pieces [x0, y0, x1, y1] of the lines along which `values` equal `level`, by marching squares; none beside NaN. */
export function contours(x, y, values, level) {
  const pieces = [];
  const columns = x.length;
  for (let row = 0; row + 1 < y.length; row++) {
    for (let column = 0; column + 1 < columns; column++) {
      const k = row * columns + column;
      const corners = [values[k], values[k + 1], values[k + columns + 1], values[k + columns]];
      if (corners.some(Number.isNaN)) continue;
      const places = [[x[column], y[row]], [x[column + 1], y[row]], [x[column + 1], y[row + 1]], [x[column], y[row + 1]]];
      const crossed = [];
      for (let side = 0; side < 4; side++) {
        const [a, b] = [corners[side], corners[(side + 1) % 4]];
        if (a >= level === b >= level) continue;
        const t = (level - a) / (b - a);
        const [from, to] = [places[side], places[(side + 1) % 4]];
        crossed.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
      }
      // a saddle: the mean of the corners says which corners belong together
      const turn = crossed.length === 4 && corners.reduce((a, b) => a + b) / 4 >= level !== corners[0] >= level;
      if (turn) crossed.push(crossed.shift());
      for (let n = 0; n + 1 < crossed.length; n += 2) pieces.push([...crossed[n], ...crossed[n + 1]]);
    }
  }
  return pieces;
}
