// Small plots in SVG: lines over time, points with lines, boxes. Drawn at the width there is, so that text stays legible.
const DASHES = ["", "7 3", "2 2.5", "9 3 2 3", "4 4", "14 3", "9 3 2 3 2 3"];

function engineStyle(engine) { return { stroke: data.engines[engine].color, "stroke-dasharray": DASHES[data.engines[engine].dashes] }; }

function ticks(low, high, count) {
  if (!(high > low)) return [low];
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10].map((m) => m * power), at = (step) => {
    const out = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) out.push(k * step);
    return out;
  };
  let i = steps.findIndex((s) => s >= rough);
  while (i > 0 && at(steps[i]).length < 2) i--; // one tick tells no scale
  return at(steps[i]);
}

function tickText(value, all) {
  const step = all.length > 1 ? Math.abs(all[1] - all[0]) : Math.abs(value) || 1;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return Math.abs(value) >= 1e5 ? scientific(value, 1) : value.toFixed(Math.min(digits, 6)).replace("-", "−");
}

function scale(low, high, from, to, log) {
  const f = log ? Math.log10 : (v) => v;
  const width = f(high) - f(low) || 1;
  return (v) => from + ((f(v) - f(low)) / width) * (to - from);
}

function extent(series, ...others) {
  let low = Infinity, high = -Infinity;
  for (const values of series) for (const v of values) if (Number.isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); }
  for (const v of others) { low = Math.min(low, v); high = Math.max(high, v); }
  if (low > high) return [0, 1];
  const room = (high - low) * 0.06 || Math.abs(high) * 0.06 || 1;
  return [low - room, high + room];
}

// The frame of a plot: axes, grid, labels. Returns {svg, x, y, inner}.
function frame({ width, height, xRange, yRange, xTicks, xTickText, yLabel, xLabel, logX, label, left = 46 }) {
  const inner = { left, right: width - 10, top: yLabel ? 26 : 8, bottom: height - (xLabel ? 34 : 20) }; // the label is above
  const x = scale(...xRange, inner.left, inner.right, logX), y = scale(...yRange, inner.bottom, inner.top);
  const yt = ticks(...yRange, Math.max(Math.round((inner.bottom - inner.top) / 38), 2));
  const xt = xTicks || ticks(...xRange, Math.max(Math.round((inner.right - inner.left) / 80), 2));
  const svg = element("svg", { class: "plot", viewBox: `0 0 ${width} ${height}`, height, role: "img", "aria-label": label,
    style: `max-width:${width}px` });
  for (const t of yt) svg.append(
    element("line", { class: "grid", x1: inner.left, x2: inner.right, y1: y(t), y2: y(t) }),
    element("text", { x: inner.left - 6, y: y(t) + 4, "text-anchor": "end" }, tickText(t, yt)));
  for (const t of xt) svg.append(
    element("line", { class: "axis", x1: x(t), x2: x(t), y1: inner.bottom, y2: inner.bottom + 4 }),
    element("text", { x: x(t), y: inner.bottom + 16, "text-anchor": "middle" }, xTickText ? xTickText(t) : tickText(t, xt)));
  svg.append(element("line", { class: "axis", x1: inner.left, x2: inner.right, y1: inner.bottom, y2: inner.bottom }));
  if (yLabel) svg.append(element("text", { class: "name", x: 2, y: 11 }, yLabel));
  if (xLabel) svg.append(element("text", { x: (inner.left + inner.right) / 2, y: height - 4, "text-anchor": "middle" }, xLabel));
  return { svg, x, y, inner };
}

function pathOf(xs, ys, x, y) {
  let d = "", pen = false;
  ys.forEach((v, i) => {
    if (!Number.isFinite(v)) { pen = false; return; }
    d += `${pen ? "L" : "M"}${x(xs[i]).toFixed(1)} ${y(v).toFixed(1)}`;
    pen = true;
  });
  return d;
}

// Lines over time: series [{values, style}] within a span [from, to] or the whole, a shaded band of ± floor, a cursor that
// reports an index and a mark that covers a part.
function linePlot({ time, series, unit, title, floor, width, height, label, xLabel, span }) {
  const last = time.length - 1, xRange = span ?? [time[0], time[last]];
  const from = Math.max(time.findIndex((v) => v >= xRange[0]), 0), to = span ? time.findLastIndex((v) => v <= xRange[1]) : last;
  const seen = series.map((s) => s.values.slice(from, to + 1)), clock = time.slice(from, to + 1);
  const yRange = floor ? extent(seen, -floor, floor) : extent(seen);
  const { svg, x, y, inner } = frame({ width, height, xRange, yRange, yLabel: `${title} [${unitLabel(unit)}]`, xLabel, label });
  if (floor) svg.append(element("rect", { class: "floor", x: inner.left, width: inner.right - inner.left, y: y(floor),
    height: y(-floor) - y(floor) }));
  series.forEach((s, i) => svg.append(element("path", { class: "line", d: pathOf(clock, seen[i], x, y), ...s.style })));
  const cursor = element("line", { class: "cursor", y1: inner.top, y2: inner.bottom, visibility: "hidden" });
  const cover = element("rect", { class: "mark", y: inner.top, height: inner.bottom - inner.top, visibility: "hidden" });
  svg.append(cover, cursor);
  const timeAt = (clientX) => {
    const box = svg.getBoundingClientRect();
    return xRange[0] + (((clientX - box.left) * (width / box.width) - inner.left) / (inner.right - inner.left)) * (xRange[1] - xRange[0]);
  };
  const at = (clientX) => {
    const t = timeAt(clientX), k = time.findIndex((v) => v >= t);
    return k < 0 || k > to ? to : Math.max(k, from);
  };
  const show = (k) => {
    const hide = k === null || k < from || k > to;
    cursor.setAttribute("visibility", hide ? "hidden" : "visible");
    if (!hide) { cursor.setAttribute("x1", x(time[k])); cursor.setAttribute("x2", x(time[k])); }
  };
  const mark = (a, b) => {
    cover.setAttribute("visibility", a === null ? "hidden" : "visible");
    if (a === null) return;
    const [low, high] = [Math.min(a, b), Math.max(a, b)].map((t) => x(Math.min(Math.max(t, xRange[0]), xRange[1])));
    cover.setAttribute("x", low);
    cover.setAttribute("width", high - low);
  };
  return { svg, at, timeAt, show, mark };
}

// Boxes one above the other: [{name, box: [low, q1, median, q3, high, max], color, strong}]; `most` ends the scale.
function boxPlot({ boxes, most, unit, width, label }) {
  const row = 22, left = Math.min(Math.max(...boxes.map((b) => b.name.length)) * 6.6 + 10, width * 0.38);
  const height = boxes.length * row + 46;
  const top = Math.max(most ?? 0, ...boxes.map((b) => b.box[5]), 1e-12);
  const { svg, x } = frame({ width, height, xRange: [0, top * 1.03], yRange: [0, 1], xLabel: `absolute difference [${unitLabel(unit)}]`,
    label, left });
  svg.querySelectorAll(".grid, text[text-anchor=end]").forEach((n) => n.remove());
  boxes.forEach(({ name, box, color, strong, pick }, i) => {
    const [low, q1, median, q3, high, max] = box, y = 18 + i * row;
    const words = `${name}: median ${quantity(median, unit)}, quartiles ${number(q1)} to ${number(q3)}, largest ${number(max)}`;
    const shown = name.length * 6.4 > left ? `${name.slice(0, Math.floor(left / 6.4) - 1)}…` : name;
    const text = element("text", { class: "name", x: left - 8, y: y + 4, "text-anchor": "end" }, shown);
    if (strong) text.style.fontWeight = 700;
    svg.append(element("g", { onmousemove: (e) => tooltip(words, e), onmouseleave: () => tooltip(""), onclick: pick,
      style: pick ? "cursor:pointer" : null },
      element("rect", { x: 0, width, y: y - row / 2, height: row, fill: "transparent" }), text,
      element("line", { x1: x(low), x2: x(high), y1: y, y2: y, stroke: color, "stroke-width": 1.3 }),
      element("rect", { x: x(q1), width: Math.max(x(q3) - x(q1), 1), y: y - 6, height: 12, fill: color, "fill-opacity": strong ? 0.55 : 0.25,
        stroke: color, rx: 1.5 }),
      element("line", { x1: x(median), x2: x(median), y1: y - 6, y2: y + 6, stroke: "currentColor", "stroke-width": 2 }),
      element("circle", { cx: x(max), cy: y, r: 2.2, fill: "none", stroke: color })));
  });
  return svg;
}
