
/* ---- controls ---- */
const slider = $("slider"), help = $("help");
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
  ArrowLeft: (ev) => frameStep(ev.shiftKey ? -10 : -1), ArrowRight: (ev) => frameStep(ev.shiftKey ? 10 : 1),
  Home: () => { pause(); seek(T0); }, End: () => { pause(); seek(T1); },
  f: () => $("follow").click(), s: () => option("solids"), x: () => option("xray"), q: () => setQuality(quality.simple ? "full" : "simple"),
  "+": () => zoom(0.85), "=": () => zoom(0.85), "-": () => zoom(1 / 0.85),
};
function option(name) { document.querySelector(`#legend input[name=${name}]`)?.click(); }
function press(ev) {
  if (ev.ctrlKey || ev.metaKey || ev.altKey) return;
  if (ev.key === "?") { ev.preventDefault(); help.open ? help.close() : help.showModal(); return; }
  if (help.open) return;     // Esc closes it, Tab and Space move in it
  const on = ev.target, view = $("views").children[+ev.key - 1];
  if (ev.key === " ") { ev.preventDefault(); if (!ev.repeat) toggle(); return; }
  if (ev.key === "Enter" && on.type === "checkbox") { on.click(); return; }
  if (on.tagName === "SELECT") return;
  const act = view ? () => view.click() : KEYS[ev.key.length === 1 ? ev.key.toLowerCase() : ev.key];
  if (act) { ev.preventDefault(); act(ev); }
}
function setUpControls() {
  $("legend").open = innerWidth > 800;
  slider.min = T0; slider.max = T1; slider.step = "any"; slider.value = T0;
  slider.addEventListener("input", () => { pause(); seek(+slider.value); });
  $("play").addEventListener("click", toggle);
  $("play").disabled = $("back").disabled = $("next").disabled = slider.disabled = N < 2;
  $("back").addEventListener("click", () => frameStep(-1));
  $("next").addEventListener("click", () => frameStep(1));
  $("speed").addEventListener("change", (ev) => { state.speed = +ev.target.value; });
  $("repeat").addEventListener("change", (ev) => { state.repeat = ev.target.checked; });
  $("quality").addEventListener("change", (ev) => setQuality(ev.target.value));
  $("follow").addEventListener("change", (ev) => { state.follow = ev.target.checked; state.dirty = true; });
  $("ask").addEventListener("click", () => help.showModal());
  help.addEventListener("click", (ev) => { if (ev.target === help) help.close(); });
  $("subtitle")?.addEventListener("click", (ev) => ev.currentTarget.classList.toggle("whole"));
  document.querySelectorAll("#views button").forEach((b) => b.addEventListener("click", () => setView(b.dataset.view)));
  document.querySelectorAll("#legend input[name]").forEach((i) => {
    i.checked = show[i.name];
    i.addEventListener("change", () => { show[i.name] = i.checked; state.dirty = true; });
  });
  for (const ev of D.events) {
    const s = document.createElement("i");
    s.style.left = (100 * (ev.time - T0)) / ((T1 - T0) || 1) + "%"; s.style.setProperty("--c", ev.colour); s.className = ev.kind;
    s.title = ev.title; s.addEventListener("click", () => { pause(); seek(ev.time); }); $("events").append(s);
  }
  addEventListener("keydown", press);
  addEventListener("keyup", (ev) => { if (ev.key === " " && !help.open) ev.preventDefault(); });  // or a button with the focus is pressed too
  document.addEventListener("visibilitychange", () => { before = null; });
  addEventListener("resize", () => { state.dirty = true; });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { state.dirty = true; });
  setUpPointers();
  setUpPrint();
}
function zoom(k) { camera.distance = Math.min(40, Math.max(0.3, camera.distance * k)); state.dirty = true; }
function move(dx, dy) {
  if (state.follow) $("follow").click();
  const k = camera.distance * 0.0011, s = Math.sin(camera.azimuth), c = Math.cos(camera.azimuth);
  camera.target[0] += k * (s * dx - c * dy * Math.sin(camera.elevation));
  camera.target[1] += k * (-c * dx - s * dy * Math.sin(camera.elevation));
  camera.target[2] += k * dy * Math.cos(camera.elevation);
}
function setUpPointers() {
  const pointers = new Map();
  const pair = () => {
    const [a, b] = [...pointers.values()];
    return { x: (a.clientX + b.clientX) / 2, y: (a.clientY + b.clientY) / 2, d: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) };
  };
  canvas.addEventListener("contextmenu", (ev) => ev.preventDefault());
  canvas.addEventListener("pointerdown", (ev) => { canvas.setPointerCapture(ev.pointerId); pointers.set(ev.pointerId, ev); });
  const up = (ev) => pointers.delete(ev.pointerId);
  canvas.addEventListener("pointerup", up); canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => tell(""));
  canvas.addEventListener("pointermove", (ev) => {
    const was = pointers.get(ev.pointerId);
    if (!was) { hover(ev); return; }
    const dx = ev.clientX - was.clientX, dy = ev.clientY - was.clientY;
    state.dirty = true;
    if (pointers.size === 2) {
      const from = pair(); pointers.set(ev.pointerId, ev); const to = pair();
      if (from.d > 0 && to.d > 0) zoom(from.d / to.d);
      if (Math.hypot(to.x - from.x, to.y - from.y) > 0.5) move(to.x - from.x, to.y - from.y);
      return;
    }
    pointers.set(ev.pointerId, ev);
    if (ev.buttons & 2 || ev.shiftKey) { move(dx, dy); return; }
    camera.azimuth -= dx * 0.008;
    camera.elevation = Math.min(1.55, Math.max(-0.3, camera.elevation + dy * 0.006));
    markView(null);
  });
  canvas.addEventListener("wheel", (ev) => { ev.preventDefault(); zoom(Math.exp(ev.deltaY * 0.0012)); }, { passive: false });
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
let before = null;
function tick(now) {
  if (state.playing && before !== null) { measure(now - before); advance((now - before) / 1000); }
  before = now;
  if (state.dirty) {
    state.dirty = false;
    const at = frameAt(state.t);
    if (gl && !gl.isContextLost()) draw();
    for (const each of cursors) each(at);
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
function noPicture(text) { $("nogl").textContent = text; $("nogl").hidden = !text; document.body.classList.toggle("flat", !!text); }
const NONE = "This browser offers no WebGL 2, so the body cannot be drawn; the curves still play.";
if (gl) try { setUp(); } catch (error) { console.warn(error.message); gl = null; }
if (gl) {
  canvas.addEventListener("webglcontextlost", (ev) => { ev.preventDefault(); noPicture("The browser lost its graphics context. The body reappears when the context is restored or the page is reloaded; the curves still play."); });
  canvas.addEventListener("webglcontextrestored", () => { setUp(); noPicture(""); state.dirty = true; });
} else noPicture(NONE);
camera.target = [...mix3(com, 1, 0, [0, 0, 0]).slice(0, 2), camera.height + level[0]];
buildCurves(); setUpControls(); setQuality("auto"); setView("oblique");
const wanted = new URLSearchParams(location.hash.slice(1));
if (wanted.has("t")) seek(+wanted.get("t")); else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play();
window.plantigrade = { seek, play, pause, state, camera, show, setView, setQuality, quality, times: [T0, T1] };
document.body.dataset.ready = "1";
requestAnimationFrame(tick);
