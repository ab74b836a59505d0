// What is shown: a signal, a value per axis, an engine and a target. Everything that draws listens.
const state = { signal: 0, choice: {}, engine: 0, target: { group: "moving" } };
const listeners = [];

function onChange(draw) { listeners.push(draw); }
function changed() { listeners.forEach((draw) => draw()); }

const recordingAxis = data.axes.findIndex((a) => a.key === "recording");

// Whether every recording has one value of an axis, as of its use: it has no switch, it comes with the recording.
function follows(axis) {
  const seen = new Map(), fixed = data.axes.map((_, i) => i).filter((i) => ["scenario", "recording"].includes(data.axes[i].key));
  return !fixed.includes(axis) && data.cells.every((c) => {
    const at = fixed.map((i) => c.at[i]).join();
    if (!seen.has(at)) seen.set(at, c.at[axis]);
    return seen.get(at) === c.at[axis];
  });
}

const switchable = data.axes.map((_, i) => i).filter((i) => i !== engineAxis && data.axes[i].values.length > 1 && !follows(i));

function startState() {
  state.target = { group: firstGroup(() => true) };
  const signals = new Set(data.rows.signal);
  state.signal = signals.size ? Math.min(...signals) : 0;
  const seen = new Set();
  let least = Infinity, best = 0;
  data.cells.forEach((cell, c) => { // the choice that comes closest in the mean of all recordings
    const choice = { [engineAxis]: cell.at[engineAxis], ...Object.fromEntries(switchable.map((a) => [a, a === recordingAxis ? -1 : cell.at[a]])) };
    const key = JSON.stringify(choice);
    if (seen.has(key)) return;
    seen.add(key);
    const gap = stat(cellsWhere(choice), state.signal, state.target)?.mean ?? Infinity;
    if (gap < least) { least = gap; best = c; }
  });
  for (const axis of switchable) state.choice[axis] = axis === recordingAxis ? -1 : data.cells.length ? data.cells[best].at[axis] : 0;
  settle(null);
  state.engine = bestEngine();
}

function shownCells(engine, changes) { return cellsWhere({ ...state.choice, [engineAxis]: engine, ...changes }); }

function bestEngine() {
  let best = cell0Engine(), least = Infinity;
  data.axes[engineAxis].values.forEach((_, e) => {
    const s = stat(shownCells(e), state.signal, state.target);
    if (s && s.mean < least) { least = s.mean; best = e; }
  });
  return best;
}

function cell0Engine() { const cells = cellsWhere(state.choice); return cells.length ? data.cells[cells[0]].at[engineAxis] : 0; }

// After a switch: where no cell has this combination, the other switches follow to one that has; likewise the signal.
function settle(axis) {
  if (!cellsWhere(state.choice).length) {
    const held = axis === null ? {} : { [axis]: state.choice[axis] };
    const candidates = cellsWhere(held);
    const agreement = (c) => switchable.filter((a) => data.cells[c].at[a] === state.choice[a]).length;
    const nearest = candidates.sort((a, b) => agreement(b) - agreement(a) || a - b)[0];
    if (nearest !== undefined)
      for (const a of switchable) if (a !== axis && state.choice[a] !== -1) state.choice[a] = data.cells[nearest].at[a];
  }
  const cells = cellsWhere(state.choice);
  const signals = new Set(cells.flatMap((c) => [...rowsOfCell[c].values()].map((i) => data.rows.signal[i])));
  if (signals.size && !signals.has(state.signal)) state.signal = Math.min(...signals);
  const has = (target) => cells.some((c) => cellStat(c, state.signal, target));
  if (!has(state.target)) state.target = { group: firstGroup((group) => has({ group })) };
}

function choose(axis, value) { state.choice[axis] = value; settle(axis); changed(); }
function chooseSignal(signal) { state.signal = signal; settle(null); changed(); }
function select(engine, target) { state.engine = engine; state.target = target; changed(); }

function showCell(cell) {
  for (const axis of switchable) state.choice[axis] = data.cells[cell].at[axis];
  state.engine = data.cells[cell].at[engineAxis];
  settle(null);
  changed();
  document.getElementById("map").scrollIntoView();
}

function targetText(target) {
  if (target.joint !== undefined) return data.joints[target.joint];
  return target.group === "base" ? "base" : `mean of ${target.group} joints`;
}

function contextText(...without) {
  const parts = switchable.filter((a) => !without.includes(a)).map((a) => {
    const value = state.choice[a];
    if (value < 0) return `all ${data.axes[a].label}s`;
    const { text, value: own } = data.axes[a].values[value];
    return typeof own === "number" && Number(text) === own ? `${data.axes[a].label} ${text}` : text;
  });
  return parts.join(" · ");
}
