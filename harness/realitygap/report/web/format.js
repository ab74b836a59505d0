// Words and numbers, as page/style.py writes them, and a helper that makes elements.
const realitygap = {};
const SAME = "no difference seen";
const RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹";
const UNITS = { deg: "°", "deg/s": "°/s" };

function scientific(value, digits) {
  const [mantissa, decades] = value.toExponential(digits - 1).split("e");
  return `${mantissa.replace("-", "−")}·10${decades.replace("+", "").replace(/./g, (c) => RAISED["-0123456789".indexOf(c)])}`;
}

function number(value, digits = 3) {
  if (value === null || Number.isNaN(value)) return "unknown";
  if (value === Infinity) return "∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e6) return scientific(value, digits);
  return value.toFixed(Math.max(digits - 1 - Math.floor(Math.log10(size)), 0)).replace("-", "−");
}

function unitLabel(unit) { return UNITS[unit] || unit; }

function quantity(value, unit, digits = 3) {
  const label = unitLabel(unit);
  return number(value, digits) + (label === "°" ? "" : " ") + label;
}

function floorOf(stat) { return Math.max(stat.noise || 0, stat.numerical || 0); }

function differ(a, b) { return Math.abs(a.mean - b.mean) > Math.max(floorOf(a), floorOf(b)); }

function floorWords(stat) {
  const word = (value) => (value === null ? "unknown" : quantity(value, stat.unit, 2));
  return `noise floor ${word(stat.noise)}, numerical floor ${word(stat.numerical)}`;
}

function mean(values) {
  const known = values.filter((v) => v !== null && !Number.isNaN(v));
  return known.length ? known.reduce((a, b) => a + b, 0) / known.length : null;
}

// element("td", {class: "num", onclick: f}, "text", child): text never becomes markup.
function element(tag, attributes, ...children) {
  const svg = ["svg", "g", "path", "line", "rect", "circle", "text", "title"].includes(tag);
  const node = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key === "value" || key === "checked" || key === "selected") node[key] = value;
    else node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children.flat().filter((c) => c !== null && c !== undefined && c !== false));
  return node;
}

// A long name may wrap behind an underscore or a dot.
const BREAKS = /(?<=[_.])/;
function breakable(name) {
  return name.split(BREAKS).flatMap((part, i) => (i ? [element("wbr"), part] : [part]));
}

// The same for what is shown as an attribute's text, where no element can stand: a space of no width.
function breakableText(name) {
  return name.split(BREAKS).join("\u200b");
}

function tooltip(text, event) {
  const tip = document.getElementById("tooltip");
  tip.style.display = text ? "block" : "none";
  if (!text) return;
  tip.textContent = text;
  const x = Math.min(event.clientX + 14, window.innerWidth - tip.offsetWidth - 8);
  const y = event.clientY + 18 + tip.offsetHeight > window.innerHeight ? event.clientY - tip.offsetHeight - 10 : event.clientY + 18;
  tip.style.left = `${Math.max(x, 8)}px`;
  tip.style.top = `${y}px`;
}
