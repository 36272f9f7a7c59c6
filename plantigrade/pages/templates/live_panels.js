
/* ---- controls of a running simulation ---- */
const setters = [...document.querySelectorAll("[data-set]")];
const field = (name) => +document.querySelector(`#panel [name=${name}]`).value;
function pushTrunk() { send("push", { force: field("force"), direction: field("direction"), duration: field("duration") }); }
let paused = false, targets = "";
function showPaused(on) { paused = on; $("play").classList.toggle("playing", !on); $("play").setAttribute("aria-label", on ? "Continue" : "Pause"); }
function togglePause() { showPaused(!paused); send("pause", { value: paused }); }
function showPanel({ lines, values }) {
  $("status").textContent = lines[0];
  for (const line of lines.slice(1)) { const b = document.createElement("b"); b.textContent = line; $("status").append(b); }
  if (!values) return;
  showPaused(values.pause);
  for (const c of setters) follow(c, values[c.name]);
  const wanted = JSON.stringify(values.targets.map(({ value, ...rest }) => rest));
  if (wanted !== targets) { targets = wanted; $("targets").replaceChildren(...values.targets.map(targetRow)); }
  values.targets.forEach((t, k) => follow($("targets").children[k].lastElementChild, t.value));
}
function targetRow(t) {
  const row = document.createElement("label"), name = document.createElement("span");
  row.className = "row"; name.textContent = t.name; row.append(name);
  const c = document.createElement(t.names.length ? "select" : "input");
  if (t.names.length) { c.dataset.number = ""; t.names.forEach((n, i) => c.add(new Option(n, i))); }
  else { c.type = "range"; c.min = t.low; c.max = t.high; c.step = (t.high - t.low) / 200; c.dataset.unit = t.unit && ` ${t.unit}`; row.append(document.createElement("output")); }
  c.value = t.value; row.append(c);
  onSet(c, (value) => send("target", { name: t.name, value }));
  return row;
}
function setUpPanels() {
  for (const c of setters) onSet(c, (value) => send(c.name, { value }));
  for (const name of ["direction", "duration"]) onSet(document.querySelector(`#panel [name=${name}]`), () => {});
  $("joint").addEventListener("input", (ev) => send("joint", { value: ev.target.value }));
  $("play").addEventListener("click", togglePause);
  $("push").addEventListener("click", pushTrunk);
  for (const name of ["step", "restart", "save"]) $(name)?.addEventListener("click", () => send(name));
  setUpToggles();
}

/* ---- the last seconds ---- */
function showCurves({ plate, seconds, time, charts }) {
  if (!$("curves").checkVisibility()) return;
  $("plate").innerHTML = plate;
  const x = (t) => 100 * (1 + t / seconds);
  $("charts").replaceChildren(...charts.map(({ title, unit, span, lines }) => {
    const all = lines.flatMap((l) => l.values).filter((v) => v !== null);
    let low = Math.min(0, ...all), high = Math.max(0, ...all);
    if (all.length && (low > 0 || Math.min(...all) > 0.5 * high)) low = Math.min(...all);
    if (all.length && Math.max(...all) < 0.5 * low) high = Math.max(...all);
    const more = Math.max(0.06 * (high - low), (span - (high - low)) / 2); low -= more; high += more;
    const y = (v) => 100 * (1 - (v - low) / (high - low)), figure = document.createElement("figure");
    const paths = lines.map((l) => {
      let path = "", pen = false;
      l.values.forEach((v, i) => { if (v === null) { pen = false; return; } path += `${pen ? "L" : "M"}${x(time[i]).toFixed(2)} ${y(v).toFixed(2)}`; pen = true; });
      return `<path d="${path}" style="--c:${l.colour}"/>`;
    });
    const ticks = nice(low, high), seen = [-4, -2, 0].filter((t) => -t < seconds);
    figure.innerHTML = `<figcaption><b></b><span class="now"></span></figcaption><div class="plot"><div class="ticks">${
      ticks.map((v) => `<span style="top:${y(v)}%">${signed(+v.toFixed(3), 3).replace(/\.?0+$/, "")}</span>`).join("")}</div>
      <svg viewBox="0 0 100 100" preserveAspectRatio="none" role="img">${
      ticks.map((v) => `<line class="tick${v === 0 ? " zero" : ""}" x1="0" x2="100" y1="${y(v)}" y2="${y(v)}"/>`).join("")}${paths.join("")}</svg>
      <div class="times">${seen.map((t) => `<span style="left:${x(t)}%">${t ? `${signed(t, 0)} s` : "now"}</span>`).join("")}</div></div>`;
    figure.querySelector("b").textContent = `${title} [${unit}]`;
    figure.querySelector("svg").setAttribute("aria-label", `${title} of the last seconds`);
    for (const l of lines) {
      const s = document.createElement("span"), v = l.values.at(-1);
      s.style.setProperty("--c", l.colour); s.textContent = `${l.label} ${v === null ? "–" : signed(v, Math.abs(v) < 10 ? 2 : 0)}`.trim();
      figure.querySelector(".now").append(s);
    }
    return figure;
  }));
}
