// The map: joints down, engines across. A grid that the arrow keys walk and Enter chooses from.
function drawHeatmap() {
  const place = document.getElementById("heatmap");
  const hadFocus = place.contains(document.activeElement);
  const engines = data.axes[engineAxis].values.map((_, e) => e).filter((e) => shownCells(e).length);
  const targets = mapTargets(engines);
  if (!targets.length) {
    place.replaceChildren(element("p", null, "Nothing was measured here: there is no gap to show, only curves."));
    return;
  }
  const stats = new Map(targets.map((t) => [t, engines.map((e) => stat(shownCells(e), state.signal, t))]));
  const tops = new Map(); // unit -> its largest gap: every unit has a scale of its own
  for (const s of [...stats.values()].flat().filter((s) => s))
    tops.set(s.unit, Math.max(tops.get(s.unit) ?? 0, Number.isFinite(s.mean) ? s.mean : 0));
  const body = [];
  let group = null;
  targets.forEach((target, r) => {
    if (target.section && target.section !== group) {
      group = target.section;
      body.push(element("tr", { class: "section" }, element("th", { colspan: engines.length + 1, scope: "colgroup" },
        group === "base" ? group : `${group} joints`)));
    }
    const cells = stats.get(target).map((s, c) => heatCell(s, engines[c], target, r, c, tops));
    const excluded = stats.get(target).some((s) => s && s.excluded);
    const unit = tops.size > 1 ? element("small", null, ` [${unitLabel(stats.get(target).find((s) => s).unit)}]`) : null;
    const name = [...breakable(targetText(target)), unit, excluded ? element("small", null, " not in the means") : null];
    body.push(element("tr", { class: target.group ? "mean" : null }, element("th", { scope: "row" }, name), cells));
  });
  const head = element("tr", null, element("td", { style: "all:unset" }),
    engines.map((e) => element("th", { scope: "col" }, data.axes[engineAxis].values[e].text)));
  const columns = element("colgroup", null, element("col", { class: "joint" }), engines.map(() => element("col")));
  const units = [...tops.keys()].map(unitLabel);
  const label = `${data.signals[state.signal].label}, mean absolute difference in ${units.join(" and ")}`;
  const table = element("table", { class: engines.length > 4 ? "heat many" : "heat", style: `--columns:${engines.length}`,
    role: "grid", "aria-label": label, onkeydown: walk }, columns,
    element("thead", null, head), element("tbody", null, body));
  place.replaceChildren(element("p", { class: "hint" }, element("b", null, `${data.signals[state.signal].label} [${units.join(", ")}]`),
    contextText() ? ` · ${contextText()}` : ""), table, heatLegend(tops));
  const chosen = table.querySelector("[aria-selected=true]") || table.querySelector("td[data-r]");
  if (chosen) { chosen.tabIndex = 0; if (hadFocus) chosen.focus(); }
}

// Means first, then joints: those that move in any of the cells shown, then the others, then the base.
function mapTargets(engines) {
  const sections = new Map();
  for (const e of engines) for (const cell of shownCells(e)) for (const i of rowsOfCell[cell].values()) {
    if (data.rows.signal[i] !== state.signal) continue;
    const joint = data.rows.joint[i], section = sectionOf(data.groups[data.rows.group[i]]);
    if (sections.get(joint) !== "moving") sections.set(joint, section);
  }
  const joints = [...sections.keys()].sort((a, b) => a - b);
  const out = [];
  for (const group of data.groups)
    if (group !== "base" && engines.some((e) => stat(shownCells(e), state.signal, { group }))) out.push({ group });
  for (const section of ["moving", "unmoving", "base"])
    for (const joint of joints) if (sections.get(joint) === section) out.push({ joint, section });
  return out;
}

function heatCell(s, engine, target, r, c, tops) {
  const name = `${targetText(target)}, ${data.axes[engineAxis].values[engine].text}`;
  const chosen = engine === state.engine && target.joint === state.target.joint && target.group === state.target.group;
  const common = { role: "gridcell", tabindex: -1, "data-r": r, "data-c": c, "aria-selected": String(chosen),
    onclick: () => select(engine, { joint: target.joint, group: target.group }), onmouseleave: () => tooltip("") };
  if (!s) return element("td", { ...common, class: "none", "aria-label": `${name}: not measured` }, "–");
  const failed = s.failed.length ? `${s.failed.length} of ${shownCells(engine).length} did not finish` : "";
  if (!Number.isFinite(s.mean)) {
    const { outcome, note } = data.cells[s.failed[0]];
    return element("td", { ...common, class: "failed", "aria-label": `${name}: ${outcome}: ${note}`,
      onmousemove: (e) => tooltip(`${name}\n${outcome}: ${note}`, e) }, outcome);
  }
  const same = s.mean <= floorOf(s);
  const heat = s.mean / tops.get(s.unit) || 0;
  const words = `${quantity(s.mean, s.unit)}${same ? `, ${SAME}` : ""}; ${floorWords(s)}${failed ? `; ${failed}` : ""}`;
  const kind = same ? "same" : heat > 0.72 ? "hot" : null;
  return element("td", { ...common, class: kind, style: same ? null : heatStyle(heat),
    "aria-label": `${name}: ${words}`, onmousemove: (e) => tooltip(`${name}\n${words.replaceAll("; ", "\n")}`, e) },
    number(s.mean), same ? element("small", null, SAME) : failed ? element("small", null, failed) : null);
}

// Two halves of a ramp of three colours.
function heatStyle(heat) {
  const percent = (v) => `${(Math.min(Math.max(v, 0), 1) * 100).toFixed(1)}%`;
  return `--lower:${percent(heat * 2)};--upper:${percent(heat * 2 - 1)}`;
}

function heatLegend(tops) {
  return element("p", { class: "legend" },
    [...tops].filter(([, top]) => top > 0).map(([unit, top]) => element("span", null, "0 ", element("span", { class: "ramp" }), ` ${quantity(top, unit)}`)),
    element("span", null, element("span", { class: "swatch" }), ` ${SAME}: not above its floors`));
}

function walk(event) {
  const cell = event.target.closest("td[data-r]");
  if (!cell) return;
  const moves = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
  if (event.key === "Enter" || event.key === " ") { event.preventDefault(); cell.click(); return; }
  const all = [...event.currentTarget.querySelectorAll("td[data-r]")];
  let next = null;
  if (event.key === "Home") next = all[0];
  else if (event.key === "End") next = all[all.length - 1];
  else if (moves[event.key]) {
    const [r, c] = [Number(cell.dataset.r) + moves[event.key][0], Number(cell.dataset.c) + moves[event.key][1]];
    next = all.find((t) => Number(t.dataset.r) === r && Number(t.dataset.c) === c);
  } else return;
  event.preventDefault();
  if (!next) return;
  cell.tabIndex = -1;
  next.tabIndex = 0;
  next.focus();
}
