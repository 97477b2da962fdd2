// Numbers in print, and complex arithmetic on pairs.

/** A number with `decimals` places and a true minus sign; a dash for NaN. */
export function fixed(value, decimals) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  const digits = Math.abs(value).toFixed(decimals);
  return (value < 0 && Number(digits) !== 0 ? "−" : "") + digits;
}

/** A level with its sign, one decimal: `+2.0`, `−5.8`. */
export function signed(db) {
  return (db >= 0 ? "+" : "") + fixed(db, 1);
}

/** A number with significant digits, and a power of ten where it is very large or small. */
export function significant(value, digits) {
  if (!Number.isFinite(value) || value === 0) return fixed(value, 0);
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  if (exponent >= -4 && exponent < 6) return fixed(value, Math.max(0, digits - 1 - exponent));
  return `${fixed(value / 10 ** exponent, digits - 1)}·10${raised(exponent)}`;
}

function raised(exponent) {
  return String(exponent).replace("-", "⁻").replace(/\d/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);
}

/** Value ± bound, both rounded to the first digit of the bound. */
export function withBound(value, bound) {
  if (!(bound > 0)) return significant(value, 6);
  const exponent = Number(bound.toExponential(0).split("e")[1]);
  const decimals = Math.min(12, Math.max(0, -exponent));
  return `${fixed(value, decimals)} ± ${fixed(bound, decimals)}`;
}

/** A share in percent. */
export function percent(share) {
  return share === null || share === undefined ? "–" : `${fixed(100 * share, 1)} %`;
}

/** Level of an amplitude, dB; NaN for zero, so that curves break there. */
export function level(amplitude) {
  return amplitude > 0 ? 20 * Math.log10(amplitude) : NaN;
}

/** A count with its noun: `1 mode`, `2 modes`. */
export function counted(count, word) {
  return `${count} ${word}${count === 1 ? "" : "s"}`;
}

/** Words of the server with true minus signs. */
export function printed(words) {
  return words.replace(/-(?=\d)/g, "\u2212");
}

/** A number for TOML: no more digits than a micrometre needs. */
export function tomlNumber(value, decimals) {
  const text = String(Number(value.toFixed(decimals)));
  return /[.e]/.test(text) ? text : `${text}.0`;
}

/** Standard deviations of a bound: 95 % of a normal distribution. */
export const SIGMAS = 1.96;

/** Least and largest finite number of a list. */
export function ends(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}
