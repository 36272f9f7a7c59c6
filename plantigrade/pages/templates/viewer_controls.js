
/* ---- camera, pointers and legend, as on both pages ---- */
const FOV = 0.55, HEIGHT = D.height;
const VIEWS = { oblique: [-0.95, 0.20], right: [-Math.PI / 2, 0.04], left: [Math.PI / 2, 0.04], front: [0, 0.06], top: [-Math.PI / 2, 1.5], feet: [-Math.PI / 2, 0.1], foot: [-1.05, 0.42] };
const BODY_AT = [HEIGHT * 0.5, HEIGHT * 2.55], FEET_AT = [0.18, 1.5], FOOT_AT = [0, 0.8];   // height of what is looked at, and how far from it [m]
const camera = { azimuth: D.heading + VIEWS.oblique[0], elevation: VIEWS.oblique[1], height: BODY_AT[0], distance: BODY_AT[1], target: [0, 0, 0] };
function eye() {
  const c = Math.cos(camera.elevation);
  return [camera.target[0] + camera.distance * c * Math.cos(camera.azimuth),
    camera.target[1] + camera.distance * c * Math.sin(camera.azimuth),
    camera.target[2] + camera.distance * Math.sin(camera.elevation)];
}
function setView(name) {
  [camera.azimuth, camera.elevation] = [D.heading + VIEWS[name][0], VIEWS[name][1]];
  const at = { feet: FEET_AT, foot: FOOT_AT }[name] ?? BODY_AT;
  if (name === "foot" && !show.xray) option("xray");
  if (at[0] !== camera.height) { if (!state.follow) camera.target[2] += at[0] - camera.height; [camera.height, camera.distance] = at; }
  markView(name); state.dirty = true;
}
function closeUp() { return F && camera.height === FOOT_AT[0]; }   // of the right foot, by its ankle
function markView(name) {
  for (const b of $("views").children) { b.classList.toggle("on", b.dataset.view === name); b.setAttribute("aria-pressed", b.dataset.view === name); }
}
function zoom(k) { camera.distance = Math.min(40, Math.max(0.3, camera.distance * k)); state.dirty = true; }
function move(dx, dy) {
  if (state.follow) $("follow").click();
  const k = camera.distance * 0.0011, s = Math.sin(camera.azimuth), c = Math.cos(camera.azimuth);
  camera.target[0] += k * (s * dx - c * dy * Math.sin(camera.elevation));
  camera.target[1] += k * (-c * dx - s * dy * Math.sin(camera.elevation));
  camera.target[2] += k * dy * Math.cos(camera.elevation);
}
function rayAt(ev) {
  const r = canvas.getBoundingClientRect(), e = last.eye, z = unit(sub(e, camera.target));
  const x = unit(cross([0, 0, 1], z)), y = cross(z, x), f = Math.tan(FOV / 2);
  const a = (2 * (ev.clientX - r.left) / r.width - 1) * f * r.width / r.height, b = (1 - 2 * (ev.clientY - r.top) / r.height) * f;
  return { from: e, along: unit([0, 1, 2].map((k) => a * x[k] + b * y[k] - z[k])), normal: z };
}
function setUpPointers({ hover = () => {}, grab = () => false, drag = () => {} }) {
  const pointers = new Map();
  const pair = () => {
    const [a, b] = [...pointers.values()];
    return { x: (a.clientX + b.clientX) / 2, y: (a.clientY + b.clientY) / 2, d: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) };
  };
  canvas.addEventListener("contextmenu", (ev) => ev.preventDefault());
  let held = false;          // something that the page drags instead of the camera
  canvas.addEventListener("pointerdown", (ev) => {
    canvas.setPointerCapture(ev.pointerId); pointers.set(ev.pointerId, ev);
    held = pointers.size === 1 && ev.button === 0 && !ev.shiftKey && grab(ev);
  });
  const up = (ev) => { pointers.delete(ev.pointerId); if (held) { held = false; drag(null); } };
  canvas.addEventListener("pointerup", up); canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => tell(""));
  canvas.addEventListener("pointermove", (ev) => {
    const was = pointers.get(ev.pointerId);
    if (!was) { hover(ev); return; }
    if (held) { drag(ev); return; }
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
const help = $("help"), ROOMY = 640;   // width of the picture at which the legend leaves the person free [px]
function option(name) { document.querySelector(`#legend input[name=${name}]`)?.click(); }
const VIEW_KEYS = {
  f: () => $("follow").click(), s: () => option("solids"), x: () => option("xray"), q: () => setQuality(quality.simple ? "full" : "simple"),
  "+": () => zoom(0.85), "=": () => zoom(0.85), "-": () => zoom(1 / 0.85),
};
function press(ev) {
  if (ev.ctrlKey || ev.metaKey || ev.altKey) return;
  if (ev.key === "?") { ev.preventDefault(); help.open ? help.close() : help.showModal(); return; }
  if (help.open) return;     // Esc closes it, Tab and Space move in it
  const on = ev.target, view = $("views").children[+ev.key - 1];
  if (ev.key === " ") { ev.preventDefault(); if (!ev.repeat) KEYS[" "](); return; }
  if (ev.key === "Enter" && on.type === "checkbox") { on.click(); return; }
  if (on.tagName === "SELECT") return;
  const act = view ? () => view.click() : KEYS[ev.key.length === 1 ? ev.key.toLowerCase() : ev.key];
  if (act) { ev.preventDefault(); act(ev); }
}
let roomy = null;
function foldLegend() {      // where the picture gets narrow, and open again where it gets wide
  const now = $("stage").clientWidth > ROOMY;
  if (now !== roomy) $("legend").open = roomy = now;
}
function setUpLegend() {
  foldLegend(); new ResizeObserver(foldLegend).observe($("stage"));
  $("quality").addEventListener("change", (ev) => setQuality(ev.target.value));
  $("follow").addEventListener("change", (ev) => { state.follow = ev.target.checked; state.dirty = true; });
  $("ask").addEventListener("click", () => help.showModal());
  help.addEventListener("click", (ev) => { if (ev.target === help) help.close(); });
  document.querySelectorAll("#views button").forEach((b) => b.addEventListener("click", () => setView(b.dataset.view)));
  document.querySelectorAll("#legend input[name]").forEach((i) => {
    i.checked = show[i.name];
    i.addEventListener("change", () => { show[i.name] = i.checked; state.dirty = true; });
  });
  addEventListener("keydown", press);
  addEventListener("keyup", (ev) => { if (ev.key === " " && !help.open) ev.preventDefault(); });  // or a button with the focus is pressed too
  addEventListener("resize", () => { state.dirty = true; });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { state.dirty = true; });
}
