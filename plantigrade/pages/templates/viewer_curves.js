
/* ---- curves ---- */
const cursors = [];
function buildCurves() {
  const host = $("curves"); host.replaceChildren(); cursors.length = 0;
  for (const chart of D.curves) {
    const lines = chart.lines.map((l) => ({ ...l, values: decode(l.values) }));
    let low = Infinity, high = -Infinity;
    for (const l of lines) for (const v of l.values) if (!Number.isNaN(v)) { low = Math.min(low, v); high = Math.max(high, v); }
    if (!(high >= low)) continue;
    const most = Math.max(-low, high), digits = most >= 100 ? 0 : most >= 10 ? 1 : 2;
    const words = (l, v) => `${l.label} ${Number.isNaN(v) ? "–" : signed(v, digits)}${l.unit}`.trim();
    const width = (l) => Math.max(words(l, low).length, words(l, high).length);
    const pad = Math.max((high - low) * 0.06, (chart.span - (high - low)) / 2, 1e-6); low -= pad; high += pad;
    const x = (t) => (100 * (t - T0)) / ((T1 - T0) || 1), y = (v) => 100 * (1 - (v - low) / (high - low));
    const figure = document.createElement("figure");
    let svg = "";
    for (const v of nice(low, high)) svg += `<line class="tick${v === 0 ? " zero" : ""}" x1="0" x2="100" y1="${y(v)}" y2="${y(v)}"/>`;
    lines.forEach((l, k) => {
      let path = "", pen = false;
      l.values.forEach((v, i) => { if (Number.isNaN(v)) { pen = false; return; } path += `${pen ? "L" : "M"}${x(time[i]).toFixed(2)} ${y(v).toFixed(2)}`; pen = true; });
      const hides = k > 0 && l.values.every((v, i) => !(Math.abs(v - lines[0].values[i]) > 0.02 * (high - low)));
      svg += `<path d="${path}" style="--c:${l.colour}"${hides ? ' stroke-dasharray="6 6"' : ""}/>`;
    });
    figure.innerHTML = `<figcaption><b></b><span class="now"></span></figcaption><div class="plot"><div class="ticks"></div>
      <svg viewBox="0 0 100 100" preserveAspectRatio="none" role="img">${svg}</svg><div class="cursor"></div></div>`;
    figure.querySelector("b").textContent = chart.title;
    const plot = figure.querySelector("svg"), ticks = figure.querySelector(".ticks");
    plot.setAttribute("aria-label", `${chart.title} over time: ${lines.map((l) => l.label).filter(Boolean).join(", ") || "one curve"}`);
    for (const v of nice(low, high)) { const s = document.createElement("span"); s.textContent = signed(+v.toFixed(3), 3).replace(/\.?0+$/, ""); s.style.top = y(v) + "%"; ticks.append(s); }
    const now = figure.querySelector(".now"), cells = lines.map((l) => {
      const s = document.createElement("span"); s.style.setProperty("--c", l.colour);
      s.style.minWidth = `${width(l)}ch`;      // or the heading would move while it plays
      now.append(s); return s; });
    const value = (l, at) => words(l, l.values[at[0]] * (1 - at[2]) + l.values[at[1]] * at[2]);
    const timeOf = (ev) => {
      const r = plot.getBoundingClientRect(); return T0 + (T1 - T0) * Math.min(1, Math.max(0, (ev.clientX - r.left) / r.width)); };
    plot.addEventListener("pointerdown", (ev) => { plot.setPointerCapture(ev.pointerId); pause(); seek(timeOf(ev)); });
    plot.addEventListener("pointermove", (ev) => {
      const t = timeOf(ev), at = frameAt(t);
      if (ev.buttons) { seek(t); tell(""); return; }
      tell(`${t.toFixed(2)} s: ${lines.map((l) => value(l, at)).join(", ")}`, ev);
    });
    plot.addEventListener("pointerleave", () => tell(""));
    const cursor = figure.querySelector(".cursor");   // not of the drawing: browsers would draw the curves anew for every picture
    cursors.push((at, readable) => {
      cursor.style.transform = `translateX(${x(state.t)}%)`;
      if (readable) lines.forEach((l, i) => { cells[i].textContent = value(l, at); });
    });
    host.append(figure);
  }
  document.body.classList.toggle("nocurves", !cursors.length);
}
