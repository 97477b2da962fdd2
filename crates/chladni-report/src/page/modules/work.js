// The settings of the studio: kept in the address of the page, and undone step by step.

/** The settings: band (Hz, null for all lines), number of modes (null: by evidence), poles added and dropped by hand (Hz), and the scene. */
export const work = {
  band: null, modes: null, added: [], dropped: [],
  frequency: 300, profile: "paper", limen: 2, transition: 0.01, off: [], zones: [],
  // length of a burst (null: a steady tone) and of its ramps (null: found), s
  burst: null, ramp: null,
};

/** Most steps that can be undone. */
const MOST_STEPS = 200;

const [past, future] = [[], []];
let now = "";
let first = "";
const listeners = [];

/** Calls `listener(keys, moving)` after every change. */
export function onWork(listener) {
  listeners.push(listener);
}

const isNumber = Number.isFinite;
const isPlace = (place) => Array.isArray(place) && place.length === 2 && place.every(isNumber);
const isZone = (zone) => ["hot", "cold", "ignore"].includes(zone?.kind) && Array.isArray(zone.points) && zone.points.length > 2 && zone.points.every(isPlace) && (zone.level_db === undefined || isNumber(zone.level_db));
const isList = (of) => (list) => Array.isArray(list) && list.every(of);
const SOUND = {
  band: (ends) => ends === null || isPlace(ends), modes: (count) => count === null || Number.isInteger(count), added: isList(isNumber), dropped: isList(isNumber),
  frequency: (hz) => isNumber(hz) && hz > 0, profile: (name) => typeof name === "string", limen: (db) => isNumber(db) && db >= 0, transition: (m) => isNumber(m) && m >= 0,
  burst: (s) => s === null || (isNumber(s) && s > 0), ramp: (s) => s === null || (isNumber(s) && s > 0),
  off: isList((name) => typeof name === "string"), zones: isList(isZone),
};

/** Begins with `defaults`, changed by the address. */
export function beginWork(defaults) {
  Object.assign(work, defaults);
  first = JSON.stringify(work);
  Object.assign(work, fromAddress());
  now = JSON.stringify(work);
}

/** The valid settings in the address; others are ignored. */
function fromAddress() {
  try {
    const said = JSON.parse(decodeURIComponent(location.hash.slice(1)) || "{}");
    return Object.fromEntries(Object.entries(said).filter(([key, value]) => SOUND[key]?.(value)));
  } catch {
    return {};
  }
}

function toAddress() {
  const before = JSON.parse(first);
  const changed = Object.entries(work).filter(([key, value]) => JSON.stringify(value) !== JSON.stringify(before[key]));
  history.replaceState(null, "", changed.length ? `#${encodeURIComponent(JSON.stringify(Object.fromEntries(changed)))}` : location.pathname + location.search);
}

/** Changes settings; during a drag no step is kept for undoing. */
export function edit(changes, moving = false) {
  Object.assign(work, changes);
  if (!moving) record();
  tell(Object.keys(changes), moving);
}

function record() {
  const text = JSON.stringify(work);
  if (text === now) return;
  past.push(now);
  if (past.length > MOST_STEPS) past.shift();
  future.length = 0;
  now = text;
  toAddress();
}

function tell(keys, moving) {
  listeners.forEach((listener) => listener(keys, moving));
}

function step(from, to) {
  if (!from.length) return;
  to.push(now);
  const before = JSON.parse(now);
  now = from.pop();
  Object.assign(work, JSON.parse(now));
  toAddress();
  tell(Object.keys(work).filter((key) => JSON.stringify(work[key]) !== JSON.stringify(before[key])), false);
}

export const undo = () => step(past, future);
export const redo = () => step(future, past);
export const canUndo = () => past.length > 0;
export const canRedo = () => future.length > 0;
