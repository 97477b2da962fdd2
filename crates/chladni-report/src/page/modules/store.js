// The state that the views share: kept modes, selected mode and pair, frequency range. Values are changed by `change`, which calls the
// listeners.

const listeners = new Map();

/** The state; write to it through `change`. */
export const state = { dropped: new Set(), mode: 0, pair: null, range: null };

/** Listeners of the view under construction. */
let own = null;

/** Calls `listener` whenever one of `keys` changes. */
export function listen(keys, listener) {
  for (const key of keys) listeners.set(key, [...(listeners.get(key) ?? []), listener]);
  own?.push(listener);
}

/** A view that will be replaced: the result of `make`, and a function that removes its listeners. */
export function passing(make) {
  own = [];
  const view = make();
  const ended = new Set(own);
  own = null;
  return [view, () => listeners.forEach((list, key) => listeners.set(key, list.filter((one) => !ended.has(one))))];
}

/** Changes the state and calls each listener once. */
export function change(values) {
  Object.assign(state, values);
  const told = new Set(Object.keys(values).flatMap((key) => listeners.get(key) ?? []));
  told.forEach((listener) => listener());
}

/** Keeps a dropped mode, or drops a kept one. */
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
