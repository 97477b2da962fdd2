// The data that the page carries: arrays of numbers stand in it as base64 under the name of their type.

const TYPES = { f32: Float32Array, f64: Float64Array, u32: Uint32Array, i16: Int16Array, u8: Uint8Array };

/** The small number that stands where nothing is known. */
const MISSING = -32768;

/** What was unpacked before: views are drawn anew while the studio's controls move. */
const known = new WeakMap();

/** The numbers of `{"f32": "..."}`, times `step` where there is one, NaN where nothing is known; to be read only; null stays null. */
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

/** The data of this page. */
export function embedded() {
  return JSON.parse(document.getElementById("data").textContent);
}

/** Complex numbers as two arrays, from real and imaginary part in turn. */
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
