// Switches for the signal and for every axis that varies: radio buttons, or a list where there are many values.
const FEW = 6;

function drawSwitches() {
  const bar = document.getElementById("switches");
  const focused = bar.contains(document.activeElement) ? document.activeElement.id : null;
  const present = new Set(data.rows.signal);
  const signals = data.signals.map((s, i) => ({ text: s.label, value: i })).filter((s) => present.has(s.value));
  const switches = [];
  if (signals.length > 1) switches.push(switchFor("signal", "signal", signals, state.signal, chooseSignal));
  for (const axis of switchable) {
    const { key, label, values } = data.axes[axis];
    const options = values.map((v, i) => ({ text: v.text, value: i, absent: !cellsWhere({ ...state.choice, [axis]: i }).length }));
    if (key === "recording") options.unshift({ text: "all, mean", value: -1 });
    switches.push(switchFor(key, label, options, state.choice[axis], (value) => choose(axis, value)));
  }
  bar.replaceChildren(...switches);
  bar.hidden = !switches.length;
  if (focused) document.getElementById(focused)?.focus();
}

function switchFor(key, label, options, current, pick) {
  const id = `switch-${key}`;
  if (options.length > FEW) {
    const choices = options.map((o) => element("option", { value: String(o.value), selected: o.value === current }, o.text));
    const list = element("select", { id, onchange: (e) => pick(Number(e.target.value)) }, choices);
    return element("div", { class: "switch" }, element("label", { class: "name", for: id }, label), list);
  }
  const radios = options.map((o) =>
    element("label", { class: o.absent ? "absent" : null, title: o.absent ? "not with the other choices: they will follow" : null },
      element("input", { type: "radio", id: `${id}-${o.value}`, name: id, value: String(o.value), checked: o.value === current,
        onchange: () => pick(o.value) }),
      element("span", null, o.text)));
  return element("fieldset", { class: "switch" }, element("legend", null, label), element("div", { class: "segments" }, radios));
}
