// Gap against step rate, against iterations and other numbers, and against speed with the front that nothing beats.
function drawTradeoffs() {
  const place = document.getElementById("plots");
  const numeric = switchable.filter((a) => data.axes[a].key !== "recording" && data.axes[a].values.filter((v) => typeof v.value === "number").length > 1);
  const timed = data.engines.length > 1 && data.cells.some((c) => c.speed !== null) && data.rows.cell.length > 0;
  const hide = !numeric.length && !timed;
  document.getElementById("tradeoffs").hidden = hide;
  document.querySelector("[data-section=tradeoffs]").hidden = hide;
  if (hide) return;
  place.replaceChildren();
  const columns = window.innerWidth > 1000 && numeric.length + timed > 1 ? 2 : 1;
  const width = Math.min((place.clientWidth - (columns - 1) * 32) / columns, 760);
  for (const axis of numeric) place.append(axisFigure(axis, width));
  if (timed) place.append(speedFigure(width));
}

function plotCaption(text, ...without) {
  return element("figcaption", null, element("b", null, text), ` – ${data.signals[state.signal].label}, ${targetText(state.target)}${contextText(...without) ? ` · ${contextText(...without)}` : ""}`);
}

function axisFigure(axis, width) {
  const { label, values } = data.axes[axis];
  const lines = data.engines.map((_, e) => ({ engine: e, points: values.map((v, i) => ({ x: v.value, s: stat(shownCells(e, { [axis]: i }), state.signal, state.target) }))
    .filter((p) => typeof p.x === "number" && p.s) })).filter((l) => l.points.length);
  const all = lines.flatMap((l) => l.points), finite = all.filter((p) => Number.isFinite(p.s.mean));
  const figure = element("figure", null, plotCaption(`Gap against ${label}`, axis));
  if (!finite.length) { figure.append(element("p", { class: "hint" }, "Nothing finished here.")); return figure; }
  const xs = [...new Set(all.map((p) => p.x))].sort((a, b) => a - b), logX = xs[0] > 0 && xs[xs.length - 1] / xs[0] > 3;
  const pad = logX ? [xs[0] / 1.15, xs[xs.length - 1] * 1.15] : [xs[0] - (xs[xs.length - 1] - xs[0]) * 0.05, xs[xs.length - 1] + (xs[xs.length - 1] - xs[0]) * 0.05];
  const unit = finite[0].s.unit, top = Math.max(...finite.map((p) => p.s.mean + (p.s.numerical || 0))) * 1.08 || 1;
  const few = xs.filter((v, i) => i === 0 || i === xs.length - 1 || xs.length <= 7 || i % Math.ceil(xs.length / 6) === 0);
  const { svg, x, y, inner } = frame({ width, height: 260, xRange: pad, yRange: [0, top], xTicks: few, xTickText: (v) => String(v), logX,
    yLabel: `gap [${unitLabel(unit)}]`, xLabel: data.axes[axis].key === "step_rate" ? "step rate [Hz]" : label, label: `Gap against ${label}` });
  const noise = mean(finite.map((p) => p.s.noise));
  if (noise) svg.append(element("rect", { class: "floor", x: inner.left, width: inner.right - inner.left, y: y(Math.min(noise, top)), height: inner.bottom - y(Math.min(noise, top)) }));
  for (const { engine, points } of lines) {
    const ran = points.filter((p) => Number.isFinite(p.s.mean)), style = engineStyle(engine);
    svg.append(element("path", { class: "line", d: pathOf(ran.map((p) => p.x), ran.map((p) => p.s.mean), x, y), ...style }));
    for (const p of ran) {
      const words = `${data.engines[engine].label}, ${label} ${p.x}\n${quantity(p.s.mean, unit)}\n${floorWords(p.s).replace(", ", "\n")}`;
      if (p.s.numerical) svg.append(element("line", { x1: x(p.x), x2: x(p.x), y1: y(p.s.mean - p.s.numerical), y2: y(p.s.mean + p.s.numerical), stroke: style.stroke, opacity: 0.6 }));
      svg.append(element("circle", { cx: x(p.x), cy: y(p.s.mean), r: 4, fill: style.stroke, onmousemove: (e) => tooltip(words, e), onmouseleave: () => tooltip("") }));
    }
    points.filter((p) => !Number.isFinite(p.s.mean)).forEach((p) => svg.append(element("text", { x: x(p.x), y: inner.top + 16 + 12 * engine, "text-anchor": "middle",
      style: `fill:${style.stroke}` }, `✕ ${data.cells[p.s.failed[0]].outcome}`)));
  }
  figure.append(engineLegend(lines.map((l) => l.engine), "bars: numerical floor; shaded: noise floor"), svg);
  return figure;
}

function engineLegend(engines, note) {
  return element("div", { class: "toggles" }, engines.map((e) => element("span", null,
    element("svg", { viewBox: "0 0 26 8", style: "width:1.6rem;height:.6rem" }, element("line", { x1: 0, x2: 26, y1: 4, y2: 4, "stroke-width": 2.4, ...engineStyle(e) })),
    ` ${data.engines[e].label}`)), element("span", { class: "same" }, note));
}

// Everything that was simulated over all the time it took: a short cell counts little.
function totalSpeed(cells) {
  const timed = cells.map((c) => data.cells[c]).filter((c) => c.speed !== null && c.wall);
  const sum = (f) => timed.reduce((a, c) => a + f(c), 0);
  return timed.length ? sum((c) => c.speed * c.wall) / sum((c) => c.wall) : null;
}

// One point per engine, step rate and iterations; the other switches hold.
function speedFigure(width) {
  const tuning = switchable.filter((a) => ["step_rate", "solver_iterations"].includes(data.axes[a].key));
  const groups = new Map();
  for (const c of cellsWhere({ ...state.choice, ...Object.fromEntries(tuning.map((a) => [a, -1])) })) {
    const at = [engineAxis, ...tuning].map((a) => data.cells[c].at[a]).join();
    groups.set(at, [...(groups.get(at) || []), c]);
  }
  const points = [...groups.values()].map((cells) => ({ cells, engine: data.cells[cells[0]].at[engineAxis], s: stat(cells, state.signal, state.target),
    speed: totalSpeed(cells) })).filter((p) => p.s && Number.isFinite(p.s.mean) && p.speed);
  const figure = element("figure", null, plotCaption("Gap against speed", ...tuning));
  if (!points.length) { figure.append(element("p", { class: "hint" }, "No timings here.")); return figure; }
  const front = points.filter((p) => !points.some((q) => q.s.mean <= p.s.mean && q.speed >= p.speed && (q.s.mean < p.s.mean || q.speed > p.speed)));
  front.sort((a, b) => a.speed - b.speed);
  const speeds = points.map((p) => p.speed), range = [Math.min(...speeds) / 1.4, Math.max(...speeds) * 1.4];
  const decades = [];
  for (let e = Math.floor(Math.log10(range[0])); e <= Math.log10(range[1]); e++) for (const m of [1, 2, 5]) { const t = m * 10 ** e; if (t > range[0] && t < range[1]) decades.push(t); }
  const unit = points[0].s.unit, top = Math.max(...points.map((p) => p.s.mean)) * 1.1 || 1;
  const { svg, x, y } = frame({ width, height: 260, xRange: range, yRange: [0, top], xTicks: decades, xTickText: (v) => String(Number(v.toPrecision(1))), logX: true,
    yLabel: `gap [${unitLabel(unit)}]`, xLabel: "real-time factor (right is faster)", label: "Gap against real-time factor" });
  svg.append(element("path", { class: "front", d: pathOf(front.map((p) => p.speed), front.map((p) => p.s.mean), x, y) }));
  for (const p of points) {
    const best = front.includes(p), color = data.engines[p.engine].color;
    const name = [data.engines[p.engine].label, ...tuning.map((a) => valueText(a, p.cells[0]))].join(", ");
    const words = `${name}\n${quantity(p.s.mean, unit)}, ${number(p.speed)} × real time\n${floorWords(p.s).replace(", ", "\n")}${best ? "\non the Pareto front" : ""}`;
    svg.append(element("circle", { cx: x(p.speed), cy: y(p.s.mean), r: best ? 6 : 4.5, fill: color, "fill-opacity": best ? 1 : 0.45, stroke: best ? "currentColor" : "none",
      "stroke-width": 1.4, onmousemove: (e) => tooltip(words, e), onmouseleave: () => tooltip("") }));
  }
  const used = [...new Set(points.map((p) => p.engine))].sort((a, b) => a - b);
  figure.append(engineLegend(used, "ringed, dotted: Pareto front, nothing is both closer and faster"), svg);
  return figure;
}
