// The chosen cell: its numbers, its curves with every engine's, and box plots.
let detailRun = 0;
const hidden = new Set(); // engines whose curves are switched off

async function drawDetail() {
  const run = ++detailRun;
  const place = document.getElementById("detail");
  const cells = shownCells(state.engine);
  if (!cells.length) { place.replaceChildren(element("p", null, `${data.axes[engineAxis].values[state.engine].text} has no cell with these choices.`)); return; }
  const head = detailHead(cells);
  const cell = furthest(cells);
  if (!data.cells[cell].curves) { place.replaceChildren(...head, element("p", { class: "hint" }, "There are no curves of this cell.")); return; }
  try {
    const shown = data.axes[engineAxis].values.map((_, e) => e)
      .map((engine) => ({ engine, cell: sameContext(cell, engine) })).filter((s) => s.cell !== undefined && data.cells[s.cell].curves);
    const curves = await Promise.all(shown.map(async (s) => ({ ...(await cellCurves(s.cell)), ...s })));
    const stack = await Promise.all(revisions(cell).map(async (c) => ({ ...(await cellCurves(c)), cell: c })));
    if (run !== detailRun) return; // another choice was made while these loaded
    spanDraws = [];
    if (span && span[1] > curves[0].time[curves[0].time.length - 1]) span = null; // another motion, that is shorter
    place.replaceChildren(...head, ...detailPlots(cell, curves, stack, place.clientWidth - 36));
  } catch (error) {
    if (run === detailRun) place.replaceChildren(...head, element("p", { class: "hint" }, `No curves: ${error.message}.`));
  }
}

// Of several cells the one whose curves show most: the largest gap among those that have curves.
function furthest(cells) {
  const drawn = cells.filter((c) => data.cells[c].curves);
  const gap = (c) => stat([c], state.signal, state.target)?.mean ?? -1;
  return drawn.reduce((most, c) => (gap(c) > gap(most) ? c : most), drawn[0]) ?? cells[0];
}

// The cell of another engine that agrees in everything else.
function sameContext(cell, engine) {
  return cellsWhere({ ...Object.fromEntries(data.cells[cell].at.map((v, a) => [a, v])), [engineAxis]: engine })[0];
}

// The cells of the robot's revisions that agree in everything else; none where there is one revision.
function revisions(cell) {
  const axis = switchable.find((a) => data.axes[a].key === "robot_revision");
  if (axis === undefined) return [];
  const at = Object.fromEntries(data.cells[cell].at.map((v, a) => [a, v]));
  return data.axes[axis].values.map((_, v) => cellsWhere({ ...at, [axis]: v })[0]).filter((c) => c !== undefined && data.cells[c].curves);
}

function detailHead(cells) {
  const s = stat(cells, state.signal, state.target);
  const name = data.axes[engineAxis].values[state.engine].text;
  const out = [element("h3", null, `${targetText(state.target)} in ${name}`)];
  const failed = cells.filter((c) => data.cells[c].outcome !== "ok");
  for (const c of failed.slice(0, 3)) out.push(element("p", { class: "verdict worse" }, outcomeText(data.cells[c])));
  if (failed.length > 3) out.push(element("p", { class: "verdict worse" }, `and ${failed.length - 3} more that did not finish`));
  if (!s || !Number.isFinite(s.mean)) return out;
  const fact = (label, value, digits) => element("div", null, element("dt", null, label), element("dd", null, value === null || value === undefined ? "unknown" : quantity(value, s.unit, digits)));
  const facts = [fact(`mean ${data.signals[state.signal].label} gap`, s.mean), fact("noise floor", s.noise, 2), fact("numerical floor", s.numerical, 2)];
  if (s.median !== undefined) facts.push(fact("median", s.median), fact("95 %", s.p95), fact("largest", s.max));
  out.push(element("dl", { class: "facts" }, facts));
  if (s.mean <= floorOf(s)) out.push(element("p", { class: "verdict same" }, `${SAME} from the recording: the gap is not above its floors.`));
  const far = furthest(cells), drawn = data.cells[far].curves ? `; the curves are those of ${recordingText(far)}, which is furthest off` : "";
  if (s.cells > 1) out.push(element("p", { class: "hint" }, `Mean of ${s.cells} recordings${drawn}.`));
  const traces = cells.filter((c) => data.cells[c].whole);
  if (traces.length === 1) out.push(traceLinks(data.cells[traces[0]]));
  return out;
}

// An outcome with its note, which may begin with it, as in "diverged at 1.2 s at knee".
function outcomeText({ outcome, note }) {
  return note.startsWith(`${outcome} `) ? note : `${outcome}: ${note}`;
}

// The files with the cell's traces; they lie beside the page, if anywhere.
function traceLinks(cell) {
  const whole = element("a", { href: cell.whole }, "Parquet"), viewed = cell.trace ? element("a", { href: cell.trace }, "MCAP") : null;
  return element("p", { class: "hint" }, "Traces beside this page: ", whole, " (every step, for pandas, Polars, DuckDB)",
    ...(viewed ? [", ", viewed, " (PlotJuggler, Foxglove, Rerun)"] : []), ".");
}

function recordingText(cell) {
  const axis = data.axes.findIndex((a) => a.key === "recording");
  return valueText(axis, cell);
}

function detailPlots(cell, curves, stack, width) {
  const own = curves.find((c) => c.engine === state.engine) || curves[0];
  const signal = data.signals[state.signal].key;
  const available = own.simulated[signal];
  const out = [];
  const joint = state.target.joint !== undefined ? data.joints[state.target.joint] : worstJoint(cell, own, signal);
  const names = available ? Object.keys(available).filter((n) => n === joint || n.startsWith(`${joint} `)) : [];
  names.forEach((name) => out.push(curveFigure(name, signal, curves, width)));
  if (!names.length) out.push(element("p", { class: "hint" }, "There are no curves of this signal."));
  const chosenJoint = own.boxes && own.boxes[signal] ? joint : null;
  if (chosenJoint) out.push(...boxFigures(chosenJoint, signal, own, curves, stack, width));
  return out;
}

// For the mean over joints: the joint that is furthest off in this cell.
function worstJoint(cell, own, signal) {
  let worst = null, most = -1;
  for (const i of rowsOfCell[cell].values()) {
    const s = rowStat(i);
    if (data.rows.signal[i] === state.signal && s.group === state.target.group && !s.excluded && s.mean > most) { most = s.mean; worst = data.joints[data.rows.joint[i]]; }
  }
  return worst ?? Object.keys(own.simulated[signal] || { "": 0 })[0];
}

function curveFigure(name, signal, curves, width) {
  const engines = curves.filter((c) => c.simulated[signal] && c.simulated[signal][name]);
  const unit = engines[0].simulated[signal][name].unit;
  const theirs = engines.find((c) => c.measured && c.measured[signal] && c.measured[signal][name]);
  const measured = theirs ? unpack(theirs.measured[signal][name]) : null;
  const series = engines.map((c) => ({ engine: c.engine, values: unpack(c.simulated[signal][name]),
    style: { ...engineStyle(c.engine), "stroke-width": c.engine === state.engine ? 2.2 : 1.2, opacity: c.engine === state.engine ? 1 : 0.75 } }));
  series.sort((a, b) => (a.engine === state.engine) - (b.engine === state.engine)); // the chosen one on top
  const time = engines[0].time, caption = element("figcaption", null, element("b", null, name), measured ? ", measured and simulated; below, simulated − measured" : ", simulated");
  const help = "Left and right arrows move the cursor, plus and minus zoom, 0 shows the whole motion.";
  const figure = element("figure", { class: "curves", tabindex: 0, "aria-label": `Curves of ${name}. ${help}` });
  const place = element("div", { class: "zoomable", title: "drag to look closer, Shift and drag to move, double click for the whole" });
  let plots = [], cursor = null, toggles = null;
  const show = (k) => {
    cursor = k;
    plots.forEach((p) => p.show(k));
    toggles.outputs.forEach(({ output, values }) => { output.textContent = k === null ? "" : quantity(values[k], unit); });
    toggles.time.textContent = k === null ? "" : `at ${time[k].toFixed(2)} s`;
  };
  const draw = () => {
    const visible = series.filter((s) => !hidden.has(s.engine));
    const ink = { values: measured, style: { stroke: "currentColor", "stroke-width": 1.8, opacity: 0.85 } };
    plots = [linePlot({ time, series: [...(measured ? [ink] : []), ...visible], unit, title: data.signals[state.signal].label, width, height: 206, span,
      label: `${name}: measured and simulated ${signal} over time`, xLabel: measured ? null : "time [s]" })];
    if (measured) plots.push(linePlot({ time, series: visible.map((s) => ({ ...s, values: s.values.map((v, k) => v - measured[k]) })), unit, span,
      title: "difference", floor: cellRow(engines, name), width, height: 146, label: `${name}: difference over time`, xLabel: "time [s]" }));
    toggles = legend(series, measured, draw);
    toggles.node.append(zoomButtons(time));
    place.replaceChildren(...plots.map((p) => p.svg));
    const focused = figure.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label") : null;
    figure.replaceChildren(caption, toggles.node, place);
    if (focused) ([...figure.querySelectorAll("button:not(:disabled)")].find((n) => n.getAttribute("aria-label") === focused) ?? figure).focus();
  };
  place.addEventListener("pointermove", (e) => show(plots[0].at(e.clientX)));
  place.addEventListener("pointerleave", () => show(null));
  zoomable(place, () => plots, time);
  figure.onkeydown = (e) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[e.key] * (e.shiftKey ? 10 : 1), middle = span ? (span[0] + span[1]) / 2 : (time[0] + time[time.length - 1]) / 2;
    if (step) show(Math.min(Math.max((cursor ?? 0) + step, 0), time.length - 1));
    else if (e.key === "+" || e.key === "-") zoom(e.key === "+" ? 0.5 : 2, cursor === null ? middle : time[cursor], time);
    else if (e.key === "0") setSpan(...wholeSpan(time), time);
    else return;
    e.preventDefault();
  };
  draw();
  spanDraws.push(draw);
  return figure;
}

// The noise floor of what is drawn, for the shaded band.
function cellRow(engines, name) {
  const joint = data.joints.indexOf(name);
  const s = joint >= 0 ? cellStat(engines[0].cell, state.signal, { joint }) : null;
  return s && s.noise ? s.noise : 0;
}

function legend(series, measured, redraw) {
  const stroke = (style) => element("svg", { viewBox: "0 0 26 8" }, element("line", { x1: 0, x2: 26, y1: 4, y2: 4, "stroke-width": 2.4, ...style }));
  const outputs = [], time = element("output");
  const node = element("div", { class: "toggles" });
  if (measured) {
    const output = element("output");
    outputs.push({ output, values: measured });
    node.append(element("label", null, stroke({ stroke: "currentColor" }), "measured", output));
  }
  for (const s of [...series].sort((a, b) => a.engine - b.engine)) {
    const output = element("output");
    outputs.push({ output, values: s.values });
    const box = element("input", { type: "checkbox", checked: !hidden.has(s.engine),
      onchange: () => { if (!hidden.delete(s.engine)) hidden.add(s.engine); redraw(); } });
    node.append(element("label", null, box, stroke(engineStyle(s.engine)), data.engines[s.engine].label, output));
  }
  node.append(time);
  return { node, outputs, time };
}

function boxFigures(joint, signal, own, curves, stack, width) {
  const out = [];
  const unit = curves[0].simulated[signal] && Object.values(own.simulated[signal])[0].unit || "";
  const at = data.joints.indexOf(joint), row = at >= 0 ? cellStat(own.cell, state.signal, { joint: at }) : null;
  const same = row ? row.unit : unit;
  const engines = curves.filter((c) => c.boxes && c.boxes[signal] && c.boxes[signal][joint]);
  if (engines.length > 1) {
    const boxes = engines.map((c) => ({ name: data.engines[c.engine].label, box: c.boxes[signal][joint], color: data.engines[c.engine].color,
      strong: c.engine === state.engine, pick: () => select(c.engine, state.target) }));
    out.push(element("figure", null, element("figcaption", null, element("b", null, joint), ", every engine"),
      boxPlot({ boxes, unit: same, width, label: `Box plots of ${joint} in every engine` })));
  }
  const all = Object.keys(own.boxes[signal] || {}).filter((j) => { // one unit per plot
    const s = data.joints.indexOf(j) >= 0 ? cellStat(own.cell, state.signal, { joint: data.joints.indexOf(j) }) : null;
    return s && s.unit === same;
  });
  if (all.length < 2) return out;
  const several = stack.length > 1, axis = data.axes.findIndex((a) => a.key === "robot_revision");
  const sets = (several ? stack : [own]).filter((c) => c.boxes && c.boxes[signal]);
  const most = Math.max(...sets.flatMap((c) => all.map((j) => (c.boxes[signal][j] || [0])).map((b) => b[b.length - 1])));
  for (const set of sets) { // one above the other, on one scale
    const words = `in ${data.engines[own.engine].label}${several ? `, revision ${valueText(axis, set.cell)}` : ""}`;
    const boxes = all.filter((j) => set.boxes[signal][j]).map((j) => ({ name: j, box: set.boxes[signal][j], color: data.engines[own.engine].color,
      strong: j === joint, pick: () => select(state.engine, { joint: data.joints.indexOf(j) }) }));
    out.push(element("figure", null, element("figcaption", null, element("b", null, "every joint"), ` ${words}`),
      boxPlot({ boxes, most, unit: same, width, label: `Box plots of every joint ${words}` })));
  }
  return out;
}
