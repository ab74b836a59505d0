// Starts the page once table and curves are there, and draws anew when the window's width changes.
realitygap.start = () => {
  startState();
  [drawSwitches, drawHeatmap, drawDetail, drawTables, drawTradeoffs].forEach(onChange);
  let section = null;
  onChange(() => { // the list of all cells depends on the section alone
    const next = state.target.group ? sectionOf(state.target.group) : section || "moving";
    if (next !== section) { section = next; drawCellTable(section); }
  });
  changed();
  let width = window.innerWidth, waiting = null;
  window.addEventListener("resize", () => {
    if (window.innerWidth === width) return;
    width = window.innerWidth;
    clearTimeout(waiting);
    waiting = setTimeout(() => { drawDetail(); drawTradeoffs(); }, 120);
  });
};
