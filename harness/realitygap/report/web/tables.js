// Sortable tables: means by group and signal, improvements, and the list of all cells.
function sortable({ columns, rows, caption, page = window.innerWidth < 600 ? 10 : 50 }) {
  let order = null, rising = true, shown = page;
  const body = element("tbody"), more = element("button", { class: "more", type: "button", onclick: () => { shown += page; fill(); } });
  const heads = columns.map((column, i) =>
    element("th", { scope: "col", class: column.num ? "num" : null, "aria-sort": "none" },
      column.label ? element("button", { type: "button", onclick: () => sort(i) }, breakable(column.label)) : null));
  const fill = () => {
    const sorted = order === null ? rows : [...rows].sort((a, b) => {
      const [u, v] = [a[order].sort ?? a[order].text, b[order].sort ?? b[order].text];
      const compared = typeof u === "number" && typeof v === "number" ? u - v || 0 : String(u).localeCompare(String(v), "en", { numeric: true });
      return rising ? compared : -compared;
    });
    body.replaceChildren(...sorted.slice(0, shown).map((row) => element("tr", null, row.map((cell, i) =>
      element("td", { class: [columns[i].num ? "num" : "", cell.class || ""].join(" ").trim() || null, "data-label": breakableText(columns[i].label) }, cell.node || cell.text,
        cell.small ? element("small", null, whole(cell.small)) : null)))));
    more.hidden = rows.length <= shown;
    more.textContent = `Show ${Math.min(page, rows.length - shown)} more of ${rows.length}`;
  };
  const sort = (i) => {
    rising = order === i ? !rising : true;
    order = i;
    heads.forEach((h, k) => h.setAttribute("aria-sort", k !== i ? "none" : rising ? "ascending" : "descending"));
    fill();
  };
  fill();
  const table = element("table", { class: "sortable", "aria-label": caption }, element("thead", null, element("tr", null, heads)), body);
  return element("div", null, element("div", { class: "scroll" }, table), more);
}

// A line breaks between its parts and not within one, as a number with its name: noise 0.022 · num. 0.0013. Sentences break.
function whole(text) {
  return text.split(/(?<=[·;]) /).flatMap((part, i) => [i ? " " : "", part.length > 30 ? part : element("span", null, part)]);
}

const tableChoice = { axis: null, old: null, new: null };

function selectList(label, options, current, pick) {
  const id = `choose-${label.replaceAll(" ", "-")}`;
  return [element("label", { for: id }, label), element("select", { id, onchange: (e) => pick(Number(e.target.value)) },
    options.map((o) => element("option", { value: String(o.value), selected: o.value === current }, o.text)))];
}

// What a table compares: any axis that varies; a revision first, as in the thesis.
function comparable() {
  const axes = [...switchable, engineAxis].filter((a) => data.axes[a].values.length > 1 || a === engineAxis);
  const rank = (a) => { const k = ["robot_revision", "engine", "ground"].indexOf(data.axes[a].key); return k < 0 ? 9 : k; };
  return axes.sort((a, b) => rank(a) - rank(b));
}

function valueCells(axis, value) { return cellsWhere({ ...state.choice, [engineAxis]: state.engine, [axis]: value }); }

function signalStats(axis, value, group) {
  return data.signals.map((_, s) => (presentSignals.has(s) ? stat(valueCells(axis, value), s, { group }) : null));
}

const presentSignals = new Set(data.rows.signal);

function drawTables() {
  const axes = comparable();
  if (tableChoice.axis === null || !axes.includes(tableChoice.axis)) tableChoice.axis = axes[0];
  drawMeans(axes);
  drawImprovement();
}

function drawMeans(axes) {
  const axis = tableChoice.axis, { label, values } = data.axes[axis];
  const signals = [...presentSignals].sort((a, b) => a - b), rows = [];
  const units = signals.map((s) => [...new Set(data.groups.map((group) => unitOf.get(`${s}|${group}`)).filter(Boolean))]);
  for (const group of data.groups) values.forEach((value, v) => {
    const stats = signalStats(axis, v, group);
    if (!stats.some((s) => s)) return;
    rows.push([{ text: value.text, sort: v }, { text: group }, ...signals.map((s, k) => meanCell(stats[s], units[k].length > 1))]);
  });
  const columns = [{ label }, { label: "joints" }, ...signals.map((s, k) => ({ label: units[k].length > 1 ? data.signals[s].label : withUnit(s, units[k][0]), num: true }))];
  const context = [axis === engineAxis ? "" : data.axes[engineAxis].values[state.engine].text, contextText(axis)].filter(Boolean).join(" · ");
  const chooser = element("div", { class: "choose" }, axes.length > 1 ? selectList("rows", axes.map((a) => ({ text: data.axes[a].label, value: a })), axis,
    (a) => { tableChoice.axis = a; tableChoice.old = tableChoice.new = null; drawTables(); }) : null);
  document.getElementById("means").replaceChildren(element("h3", null, `Mean gap by ${label}`), element("p", { class: "hint" }, context), chooser,
    rows.length ? sortable({ columns, rows, caption: `Mean gap by ${label}` }) : element("p", null, "Nothing was measured here."));
}

function withUnit(signal, unit) { return `${data.signals[signal].label} [${unitLabel(unit)}]`; }

// A mean and its floors; with its unit where the column's head has none, because its rows have several.
function meanCell(s, ownUnit = false) {
  if (!s) return { text: "–", sort: Infinity };
  if (!Number.isFinite(s.mean)) return { text: data.cells[s.failed[0]].outcome, sort: Infinity, class: "worse" };
  const same = s.mean <= floorOf(s);
  return { text: ownUnit ? quantity(s.mean, s.unit) : number(s.mean), sort: s.mean, class: same ? "same" : null,
    small: `${same ? `${SAME}; ` : ""}noise ${number(s.noise, 2)} · num. ${number(s.numerical, 2)}${s.failed.length ? ` · ${s.failed.length} failed` : ""}` };
}

function drawImprovement() {
  const place = document.getElementById("improvement"), axis = tableChoice.axis, { label, values } = data.axes[axis];
  const signals = [...presentSignals].sort((a, b) => a - b);
  const recordings = axis === recordingAxis || !switchable.includes(recordingAxis) ? [null] : data.axes[recordingAxis].values.map((_, i) => i);
  const compared = (before, after) => recordings.flatMap((recording) => data.groups.flatMap((group) => {
    const at = (value) => cellsWhere({ ...state.choice, [engineAxis]: state.engine, ...(recording === null ? {} : { [recordingAxis]: recording }), [axis]: value });
    const pairs = signals.map((s) => [stat(at(before), s, { group }), stat(at(after), s, { group })]);
    if (!pairs.some(([a, b]) => a && b)) return [];
    const name = recording === null ? [] : [{ text: data.axes[recordingAxis].values[recording].text, sort: recording }];
    return [[...name, { text: group }, ...pairs.map(([a, b]) => improvementCell(a, b))]];
  }));
  if (tableChoice.old === null) {
    const all = values.map((_, i) => i), pairs = [...all].reverse().flatMap((o) => all.filter((n) => n !== o).map((n) => [o, n]));
    const alike = pairs.find(([o, n]) => compared(o, n).length);
    if (!alike) { place.replaceChildren(); return; } // nothing to compare
    [tableChoice.old, tableChoice.new] = alike;
  }
  const rows = compared(tableChoice.old, tableChoice.new);
  const options = values.map((v, i) => ({ text: v.text, value: i }));
  const chooser = element("div", { class: "choose" }, selectList("old", options, tableChoice.old, (v) => { tableChoice.old = v; drawImprovement(); }),
    selectList("new", options, tableChoice.new, (v) => { tableChoice.new = v; drawImprovement(); }));
  const columns = [...(recordings[0] === null ? [] : [{ label: "recording" }]), { label: "joints" }, ...signals.map((s) => ({ label: data.signals[s].label, num: true }))];
  place.replaceChildren(element("h3", null, `Improvement from one ${label} to another`), element("p", { class: "hint" }, "Old − new; positive is better."), chooser,
    rows.length ? sortable({ columns, rows, caption: `Improvement from one ${label} to another` }) : element("p", null, "These two were not measured alike."));
}

function improvementCell(a, b) {
  if (!a || !b) return { text: "–", sort: -Infinity };
  if (!Number.isFinite(a.mean) || !Number.isFinite(b.mean)) return { text: `${Number.isFinite(a.mean) ? "new" : "old"} did not finish`, sort: -Infinity, class: "worse" };
  const gain = a.mean - b.mean, unit = a.unit;
  const small = `${number(a.mean)} → ${quantity(b.mean, unit)}; larger floor ${number(Math.max(floorOf(a), floorOf(b)), 2)}`;
  if (!differ(a, b)) return { text: SAME, sort: 0, class: "same", small };
  return { text: `${gain > 0 ? "▲ +" : "▼ "}${quantity(gain, unit)}`, sort: gain, class: gain > 0 ? "better" : "worse", small };
}

// One row per cell, one column per signal and group: of the joints of a section, or of the base.
function drawCellTable(section) {
  const axes = data.axes.map((_, a) => a).filter((a) => a === engineAxis || data.axes[a].values.length > 1);
  const means = [...presentSignals].sort((a, b) => a - b).flatMap((signal) => data.groups.filter((group) => unitOf.has(`${signal}|${group}`) &&
    sectionOf(group) === (data.signals[signal].key.startsWith("base_") ? "base" : section)).map((group) => ({ signal, group, unit: unitOf.get(`${signal}|${group}`) })));
  const timed = data.cells.some((c) => c.speed !== null);
  const columns = [...axes.map((a) => ({ label: data.axes[a].label, num: typeof data.axes[a].values[0].value === "number" })), { label: "outcome" },
    ...means.map((m) => ({ label: withUnit(m.signal, m.unit), num: true })), ...(timed ? [{ label: "× real time", num: true }] : []), { label: "" }];
  const build = (text) => data.cells.map((cell, c) => ({ cell, c })).filter(({ cell, c }) =>
    text.split(/\s+/).every((word) => `${axes.map((a) => valueText(a, c)).join(" ")} ${cell.outcome} ${cell.note}`.toLowerCase().includes(word))).map(({ cell, c }) => [
    ...axes.map((a) => ({ text: valueText(a, c), sort: cell.at[a] })), { text: cell.outcome, small: cell.note, class: cell.outcome === "ok" ? null : "worse" },
    ...means.map(({ signal, group }) => { const value = cellStat(c, signal, { group }); return value ? meanCell({ ...value, failed: data.cells[c].outcome === "ok" ? [] : [c] }) : { text: "–", sort: Infinity }; }),
    ...(timed ? [{ text: cell.speed === null ? "–" : number(cell.speed), sort: cell.speed ?? -1 }] : []),
    { node: element("span", null, element("button", { class: "open", type: "button", onclick: () => showCell(c) }, "show"),
      cell.trace ? [" ", element("a", { href: cell.trace }, "trace")] : null), text: "" }]);
  const place = document.getElementById("celltable"), list = element("div");
  const fill = (text) => list.replaceChildren(sortable({ columns, rows: build(text), caption: "All cells" }));
  const search = element("input", { type: "search", id: "filter", oninput: (e) => fill(e.target.value.trim().toLowerCase()) });
  const filter = element("div", { class: "choose" }, element("label", { for: "filter" }, "filter"), search);
  place.replaceChildren(element("p", { class: "hint" }, section === "base" ? "Gaps of the base." : `Means of ${section} joints.`),
    ...(data.cells.length > 10 ? [filter] : []), list);
  fill("");
}
