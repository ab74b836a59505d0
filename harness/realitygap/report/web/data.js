// The table, indexed: which cells a choice means, and the gap of a joint or of a group's mean in them.
const data = JSON.parse(document.getElementById("data").textContent);
const engineAxis = data.axes.findIndex((a) => a.key === "engine");
const rowsOfCell = data.cells.map(() => new Map()); // cell -> "signal|joint" -> row number
data.rows.cell.forEach((cell, i) => rowsOfCell[cell].set(`${data.rows.signal[i]}|${data.rows.joint[i]}`, i));
// A group's joints are of one kind, so a signal has one unit in it: "signal|group" -> unit.
const unitOf = new Map(data.rows.unit.map((unit, i) => [`${data.rows.signal[i]}|${data.groups[data.rows.group[i]]}`, data.units[unit]]));

// The part of the page that a group stands in: moving, unmoving or base, whatever the kind of its joints.
function sectionOf(group) { return group.split(" ")[0]; }
function firstGroup(exists) { return ["moving", "base", "unmoving"].flatMap((s) => data.groups.filter((g) => sectionOf(g) === s)).find(exists) || "moving"; }

function rowStat(i) {
  const r = data.rows;
  return { mean: r.mean[i] ?? Infinity, median: r.median[i], p95: r.p95[i], max: r.max[i], noise: r.noise[i],
    numerical: r.numerical[i], unit: data.units[r.unit[i]], group: data.groups[r.group[i]], excluded: !!r.excluded[i] };
}

// A target is {joint: number} or {group: "moving"}: a joint's gap, or the mean over a group's joints.
function cellStat(cell, signal, target) {
  if (target.joint !== undefined) {
    const i = rowsOfCell[cell].get(`${signal}|${target.joint}`);
    return i === undefined ? null : rowStat(i);
  }
  const stats = [];
  for (const i of rowsOfCell[cell].values()) {
    if (data.rows.signal[i] !== signal || data.rows.excluded[i]) continue;
    const stat = rowStat(i);
    if (stat.group === target.group) stats.push(stat);
  }
  if (!stats.length) return null;
  return { mean: stats.reduce((a, s) => a + s.mean, 0) / stats.length, noise: mean(stats.map((s) => s.noise)),
    numerical: mean(stats.map((s) => s.numerical)), unit: stats[0].unit, group: target.group, joints: stats.length };
}

// The same over several recordings: the mean of the cells that ran, and how many did not.
function stat(cells, signal, target) {
  const all = cells.map((c) => cellStat(c, signal, target)).filter((s) => s);
  if (!all.length) return null;
  const ran = all.filter((s) => Number.isFinite(s.mean));
  const failed = cells.filter((c) => data.cells[c].outcome !== "ok");
  if (!ran.length) return { ...all[0], mean: Infinity, cells: all.length, failed };
  if (all.length === 1) return { ...ran[0], cells: 1, failed };
  return { mean: mean(ran.map((s) => s.mean)), noise: mean(ran.map((s) => s.noise)), unit: ran[0].unit, group: ran[0].group,
    numerical: mean(ran.map((s) => s.numerical)), cells: ran.length, failed };
}

// Cells that agree with {axis number: value number}; an axis that is not named, or is -1, takes all its values.
function cellsWhere(choice) {
  const fixed = Object.entries(choice).filter(([, value]) => value >= 0);
  return data.cells.map((_, i) => i).filter((i) => fixed.every(([axis, value]) => data.cells[i].at[axis] === value));
}

function valueText(axis, cell) { return data.axes[axis].values[data.cells[cell].at[axis]].text; }

// Curves come with the page or, where there are many, from files beside it.
const curveStore = new Map();
const curveWaiting = new Map();

realitygap.curves = (name, content) => {
  curveStore.set(name, content);
  (curveWaiting.get(name) || []).forEach((resume) => resume(content));
  curveWaiting.delete(name);
};

function loadCurves(name) {
  if (curveStore.has(name)) return Promise.resolve(curveStore.get(name));
  return new Promise((resolve, reject) => {
    if (curveWaiting.has(name)) { curveWaiting.get(name).push(resolve); return; }
    curveWaiting.set(name, [resolve]);
    const script = element("script", { src: `curves/${encodeURIComponent(name)}.js` });
    script.onerror = () => { curveWaiting.delete(name); reject(new Error(`curves/${name}.js is not beside this page`)); };
    document.head.append(script);
  });
}

function unpack(packed) {
  let whole = 0;
  const values = packed.steps.map((step) => (whole += step) * packed.quantum);
  for (const i of packed.missing || []) values[i] = NaN;
  return values;
}

// {time, measured: series or null, simulated: series} of a cell; series[signal][joint] is packed.
async function cellCurves(cell) {
  const content = await loadCurves(data.cells[cell].curves);
  return { ...content, time: unpack(content.time), measured: content.measured ? await loadCurves(content.measured) : null };
}
