// The data of the page. Arrays of numbers are base64 under the name of their type.

const TYPES = { f32: Float32Array, f64: Float64Array, u32: Uint32Array, i16: Int16Array, u8: Uint8Array };

/** Code of a value that is not known. */
const MISSING = -32768;

/** Arrays that are unpacked already, since the studio draws views anew during a drag. */
const known = new WeakMap();

/** The numbers of `{"f32": "..."}`, times `step` where there is one; NaN where not known, null for null. Callers must not change them. */
export function array(coded) {
  if (!coded) return null;
  if (!known.has(coded)) {
    const [name, text] = Object.entries(coded)[0];
    const numbers = new TYPES[name](bytes(text).buffer);
    known.set(coded, coded.step === undefined ? numbers : Float64Array.from(numbers, (number) => (number === MISSING ? NaN : number * coded.step)));
  }
  return known.get(coded);
}

function bytes(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const letters = atob(text);
  const out = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) out[k] = letters.charCodeAt(k);
  return out;
}

/** The data that this page contains. */
export function embedded() {
  return JSON.parse(document.getElementById("data").textContent);
}

/** {re, im} as two arrays, from real and imaginary part in turn. */
export function split(numbers) {
  const count = numbers.length / 2;
  const re = new Float64Array(count);
  const im = new Float64Array(count);
  for (let k = 0; k < count; k++) {
    re[k] = numbers[2 * k];
    im[k] = numbers[2 * k + 1];
  }
  return { re, im };
}
