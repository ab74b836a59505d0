// Looking closer: all curves of the chosen cell share one span of time [from, to] in s; null is the whole motion.
let span = null;
let spanDraws = []; // what draws anew when the span changes
const FEWEST = 8; // samples that a span shows at least

function wholeSpan(time) { return [time[0], time[time.length - 1]]; }

function setSpan(from, to, time) {
  const [first, last] = wholeSpan(time), whole = last - first;
  const width = Math.max(to - from, Math.min((FEWEST * whole) / Math.max(time.length - 1, 1), whole));
  const at = Math.min(Math.max(from, first), last - width);
  span = width < whole * 0.999 ? [at, at + width] : null;
  spanDraws.forEach((draw) => draw());
}

// `factor` below 1 looks closer; the time `at` stays where it is.
function zoom(factor, at, time) {
  const [from, to] = span ?? wholeSpan(time);
  setSpan(at - (at - from) * factor, at + (to - at) * factor, time);
}

function pan(seconds, time) {
  const [from, to] = span ?? wholeSpan(time);
  setSpan(from + seconds, to + seconds, time);
}

function zoomButtons(time) {
  const middle = () => { const [from, to] = span ?? wholeSpan(time); return (from + to) / 2; };
  const width = () => { const [from, to] = span ?? wholeSpan(time); return to - from; };
  const button = (text, label, act, idle) => element("button", { type: "button", title: label, "aria-label": label, onclick: act, disabled: idle }, text);
  return element("span", { class: "zoom" }, button("+", "look closer", () => zoom(0.5, middle(), time)),
    button("−", "look from further away", () => zoom(2, middle(), time), !span),
    button("◂", "earlier", () => pan(-width() / 2, time), !span), button("▸", "later", () => pan(width() / 2, time), !span),
    button("whole", "the whole motion", () => setSpan(...wholeSpan(time), time), !span));
}

// Drag chooses a span, with Shift or one finger it moves it; two fingers or the wheel with Ctrl zoom; a double click
// shows the whole. `plots` gives the plots that `place` holds now: they are drawn anew while a finger is down.
function zoomable(place, plots, time) {
  const down = new Map(); // pointer -> where it is
  let dragged = null; // where a span begins
  const timeAt = (x) => plots()[0].timeAt(x);
  const perPixel = () => timeAt(1) - timeAt(0);
  place.addEventListener("pointerdown", (e) => {
    if (e.button !== 0) return;
    down.set(e.pointerId, e.clientX);
    place.setPointerCapture(e.pointerId);
    dragged = e.pointerType === "mouse" && !e.shiftKey ? e.clientX : null;
    if (e.pointerType === "mouse") e.preventDefault(); // no text is marked
  });
  place.addEventListener("pointermove", (e) => {
    if (!down.has(e.pointerId)) return;
    const before = down.get(e.pointerId);
    if (dragged !== null) plots().forEach((p) => p.mark(timeAt(dragged), timeAt(e.clientX)));
    else if (down.size === 2) {
      const [other] = [...down].filter(([id]) => id !== e.pointerId).map(([, x]) => x);
      const far = Math.abs(e.clientX - other), was = Math.abs(before - other);
      if (far > 10 && was > 10) zoom(was / far, timeAt(other), time);
    } else if (span) pan((before - e.clientX) * perPixel(), time);
    down.set(e.pointerId, e.clientX);
  });
  const up = (e) => {
    if (!down.delete(e.pointerId)) return;
    const from = dragged;
    dragged = null;
    if (from === null) return;
    const [a, b] = [timeAt(Math.min(from, e.clientX)), timeAt(Math.max(from, e.clientX))];
    if (e.type === "pointerup" && Math.abs(e.clientX - from) > 5) setSpan(a, b, time);
    else plots().forEach((p) => p.mark(null));
  };
  place.addEventListener("pointerup", up);
  place.addEventListener("pointercancel", up);
  place.addEventListener("dblclick", () => setSpan(...wholeSpan(time), time));
  place.addEventListener("wheel", (e) => {
    const aside = e.shiftKey ? e.deltaY || e.deltaX : Math.abs(e.deltaX) > Math.abs(e.deltaY) ? e.deltaX : 0;
    if (e.ctrlKey || e.metaKey) zoom(Math.exp(Math.sign(e.deltaY) * Math.min(Math.abs(e.deltaY), 50) * 0.005), timeAt(e.clientX), time);
    else if (aside && span) pan(aside * perPixel(), time);
    else return; // the page scrolls
    e.preventDefault();
  }, { passive: false });
}
