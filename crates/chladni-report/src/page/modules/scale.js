// Axes: from numbers to pixels and back, and round numbers at the ticks.

/** A ruler from data `ends` to pixels `px`. */
export function ruler(ends, px, log = false) {
  const to = log ? Math.log10 : (value) => value;
  const from = log ? (value) => 10 ** value : (value) => value;
  const [low, high] = ends.map(to);
  const span = high - low || 1;
  return {
    ends,
    log,
    place: (value) => px[0] + ((to(value) - low) / span) * (px[1] - px[0]),
    value: (place) => from(low + ((place - px[0]) / (px[1] - px[0] || 1)) * span),
  };
}

/** Round numbers inside `ends`, about `count` of them or `step` apart, with the text of each. */
export function ticks([low, high], count, log = false, fixedStep = null) {
  if (!(high > low)) return [];
  if (log) return logTicks(low, high);
  const rough = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = fixedStep ?? power * ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
    const value = k * step;
    const text = Math.abs(value) < 1e-12 * step ? "0" : value.toFixed(Math.min(9, decimals)).replace("-", "−");
    out.push([value, text]);
  }
  return out;
}

function logTicks(low, high) {
  const out = [];
  for (let exponent = Math.floor(Math.log10(low)); exponent <= Math.ceil(Math.log10(high)); exponent++) {
    const decades = Math.log10(high / low);
    for (const digit of decades < 1.5 ? [1, 2, 5] : [1]) {
      const value = digit * 10 ** exponent;
      if (value >= low * 0.999 && value <= high * 1.001) out.push([value, Number(value.toPrecision(3)).toString()]);
    }
  }
  return out;
}
