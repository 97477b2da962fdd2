// What the views share: the modes that are kept, the mode and the pair that are looked at, the frequency range. Who changes a value says
// so; who shows it listens.

const listeners = new Map();

/** The state; write to it through `change`. */
export const state = { dropped: new Set(), mode: 0, pair: null, range: null };

/** Listeners of the view that is being made. */
let own = null;

/** Calls `listener` whenever one of `keys` changes. */
export function listen(keys, listener) {
  for (const key of keys) listeners.set(key, [...(listeners.get(key) ?? []), listener]);
  own?.push(listener);
}

/** A view that is to be replaced: what `make` gives, and what ends its listening. */
export function passing(make) {
  own = [];
  const view = make();
  const ended = new Set(own);
  own = null;
  return [view, () => listeners.forEach((list, key) => listeners.set(key, list.filter((one) => !ended.has(one))))];
}

/** Changes the state and tells who listens, each once. */
export function change(values) {
  Object.assign(state, values);
  const told = new Set(Object.keys(values).flatMap((key) => listeners.get(key) ?? []));
  told.forEach((listener) => listener());
}

/** Keeps a dropped mode, drops a kept one. */
export function toggleMode(index) {
  const dropped = new Set(state.dropped);
  if (!dropped.delete(index)) dropped.add(index);
  change({ dropped, mode: index });
}

/** Forgets state and listeners: the page is drawn anew. */
export function reset() {
  listeners.clear();
  Object.assign(state, { dropped: new Set(), mode: 0, pair: null, range: null });
}
