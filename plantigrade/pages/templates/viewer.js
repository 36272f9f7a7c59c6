
/* ---- controls ---- */
const slider = $("slider");
function seek(t) { state.t = Math.min(T1, Math.max(T0, t)); state.past = 0; state.dirty = true; }
function setPlaying(on) {
  state.playing = on;
  $("play").classList.toggle("playing", on);
  $("play").setAttribute("aria-label", on ? "Pause" : "Play");
}
function play() { if (N < 2) return; if (state.t >= T1 - 1e-6) seek(T0); setPlaying(true); }
function pause() { setPlaying(false); }
function toggle() { state.playing ? pause() : play(); }
function frameStep(k) { pause(); const at = frameAt(state.t); seek(time[Math.min(N - 1, Math.max(0, (at[2] > 0.5 ? at[1] : at[0]) + k))]); }
const KEYS = {
  " ": toggle,
  ArrowLeft: (ev) => frameStep(ev.shiftKey ? -10 : -1), ArrowRight: (ev) => frameStep(ev.shiftKey ? 10 : 1),
  Home: () => { pause(); seek(T0); }, End: () => { pause(); seek(T1); },
  ...VIEW_KEYS,
};
function showTimes() {       // of the motion on the slider
  slider.min = T0; slider.max = T1;
  $("play").disabled = $("back").disabled = $("next").disabled = slider.disabled = N < 2;
  $("events").replaceChildren();
  for (const ev of D.events) {
    const s = document.createElement("i");
    s.style.left = (100 * (ev.time - T0)) / ((T1 - T0) || 1) + "%"; s.style.setProperty("--c", ev.colour); s.className = ev.kind;
    s.title = ev.title; s.addEventListener("click", () => { pause(); seek(ev.time); }); $("events").append(s);
  }
}
const hands = { grab: () => false, drag: () => {} };   // what a page of a task that is solved live drags
function setUpControls() {
  showTimes();
  slider.step = "any"; slider.value = T0;
  slider.addEventListener("input", () => { pause(); seek(+slider.value); });
  $("play").addEventListener("click", toggle);
  $("back").addEventListener("click", () => frameStep(-1));
  $("next").addEventListener("click", () => frameStep(1));
  $("speed").addEventListener("change", (ev) => { state.speed = +ev.target.value; });
  $("repeat").addEventListener("change", (ev) => { state.repeat = ev.target.checked; });
  $("subtitle")?.addEventListener("click", (ev) => ev.currentTarget.classList.toggle("whole"));
  document.addEventListener("visibilitychange", () => { before = null; });
  setUpLegend();
  setUpPointers({ hover, grab: (ev) => hands.grab(ev), drag: (ev) => hands.drag(ev) });
  setUpPrint();
}
function hover(ev) {
  let name = "", best = 12;
  if (last && (recorded || fitted)) {
    const r = canvas.getBoundingClientRect(), v = last.view;
    for (let i = 0; i < M; i++) for (const [source, on] of [[recorded, show.recorded], [fitted, show.fitted]]) {
      if (!source || !on) continue;
      const p = mix3(source, M, i, last.at);
      const w = v[3] * p[0] + v[7] * p[1] + v[11] * p[2] + v[15];
      const x = (v[0] * p[0] + v[4] * p[1] + v[8] * p[2] + v[12]) / w, y = (v[1] * p[0] + v[5] * p[1] + v[9] * p[2] + v[13]) / w;
      const d = Math.hypot(((x + 1) / 2) * r.width - (ev.clientX - r.left), ((1 - y) / 2) * r.height - (ev.clientY - r.top));
      if (d < best) {
        best = d; name = D.marker_names[i];
        const a = recorded && mix3(recorded, M, i, last.at), b = fitted && mix3(fitted, M, i, last.at);
        if (a && b) { const e = Math.hypot(...sub(a, b)); name += Number.isNaN(e) ? " · not seen" : ` · ${(1000 * e).toFixed(1)} mm apart`; }
      }
    }
  }
  tell(name, ev);
}

/* ---- paper: a still of this instant ---- */
function setUpPrint() {
  addEventListener("beforeprint", () => {
    if (!gl || gl.isContextLost()) return;
    draw({ width: 1600, height: 1000 });
    $("still").src = canvas.toDataURL("image/png"); $("still").hidden = false;
    $("legend").dataset.was = $("legend").open ? "open" : ""; $("legend").open = true;
  });
  addEventListener("afterprint", () => { $("still").hidden = true; $("legend").open = !!$("legend").dataset.was; state.dirty = true; });
}

/* ---- the loop ---- */
const READING = 400, TEXTS = 10;   // while it plays, numbers beside the curves change so often [ms], and with every tenth picture at most: text costs more than the body
let before = null, said = -READING;
function tick(now) {
  const late = now - before;
  if (state.playing && before !== null) { measure(now - before); advance((now - before) / 1000); }
  before = now;
  if (state.dirty) {
    state.dirty = false;
    const at = frameAt(state.t);
    if (gl && !gl.isContextLost()) draw();
    const readable = !state.playing || now - said >= Math.max(READING, TEXTS * late);
    if (readable) said = now;
    for (const each of cursors) each(at, readable);
    slider.value = state.t;
    slider.setAttribute("aria-valuetext", `${state.t.toFixed(2)} seconds`);
    $("clock").textContent = `${state.t.toFixed(2)} s`;
    const parts = Object.keys(D.cycles).map((side) => [side, cycleAt(side)]).filter(([, p]) => p !== null);
    $("frame").textContent = `frame ${(at[2] > 0.5 ? at[1] : at[0]) * D.stride}`;
    $("cycle").textContent = parts.map(([side, p]) => `${side} ${p.toFixed(0)} %`).join(" · ");
    document.body.dataset.time = state.t.toFixed(4);
  }
  requestAnimationFrame(tick);
}
startDrawing();
camera.target = [...mix3(com, 1, 0, [0, 0, 0]).slice(0, 2), camera.height + level[0]];
buildCurves(); setUpControls(); setQuality("auto"); setView("oblique");
const wanted = new URLSearchParams(location.hash.slice(1));
if (wanted.has("t")) seek(+wanted.get("t")); else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play();
window.plantigrade = { seek, play, pause, state, camera, show, setView, setQuality, quality, times: [T0, T1] };
document.body.dataset.ready = "1";
requestAnimationFrame(tick);
