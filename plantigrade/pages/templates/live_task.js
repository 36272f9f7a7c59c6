
/* ---- a task that is solved again whenever somebody changes it ---- */
const BALL = 0.035, NEAR = 16;   // radius of a handle [m], and how near the mouse takes it [px]
const setters = [...document.querySelectorAll("[data-set]")];
let held = null, settled = {}, values = {};
const handles = () => D.handles || [];
extras.push(() => {
  for (const h of handles()) {
    const p = held?.name === h.name ? held.now : h.at;
    sphere(p, BALL, COLOURS.handle);
    if (held?.name === h.name) put("shaft", h.at, sub(p, h.at), 0.006, COLOURS.handle);
    if (h.axis) arrow(p, h.axis.map((x) => 0.16 * x), 0.008, COLOURS.handle);
  }
});
function onScreen(p) {       // in pixels of the page; null behind the camera
  const r = canvas.getBoundingClientRect(), v = last.view;
  const w = v[3] * p[0] + v[7] * p[1] + v[11] * p[2] + v[15];
  if (!(w > 0)) return null;
  return [r.left + ((v[0] * p[0] + v[4] * p[1] + v[8] * p[2] + v[12]) / w + 1) / 2 * r.width,
    r.top + (1 - (v[1] * p[0] + v[5] * p[1] + v[9] * p[2] + v[13]) / w) / 2 * r.height];
}
hands.grab = (ev) => {
  if (!last) return false;
  let best = NEAR; held = null;
  for (const h of handles()) {
    const s = onScreen(h.at), d = s ? Math.hypot(s[0] - ev.clientX, s[1] - ev.clientY) : Infinity;
    if (d < best) { best = d; held = { ...h, now: h.at }; }
  }
  if (held) { const ray = rayAt(ev); held.normal = ray.normal; held.from = along(ray, held); }
  return !!held;
};
function along(ray, h) {     // where the mouse is: how far along the axis, or the point of the plane through the handle that faces the camera
  const w = sub(ray.from, h.at);
  if (!h.axis) { const t = -dot(w, h.normal) / dot(ray.along, h.normal); return ray.from.map((x, k) => x + t * ray.along[k]); }
  const b = dot(h.axis, ray.along), d = dot(h.axis, w), e = dot(ray.along, w), n = 1 - b * b;
  return n < 1e-6 ? 0 : (d - b * e) / n;
}
hands.drag = (ev) => {
  if (!ev) { held = null; state.dirty = true; tell(""); return; }
  const at = along(rayAt(ev), held), c = setters.find((s) => s.name === held.name);
  let value = at, words = "";
  if (held.axis) {
    const free = held.value + held.per_metre * (at - held.from);
    value = Math.min(+c.max, Math.max(+c.min, free));
    const way = (value - held.value) / held.per_metre;
    held.now = held.at.map((x, k) => x + way * held.axis[k]);
    c.value = value; c.held = performance.now(); delete c.dataset.default; sayTask(c); value = +c.value;
    words = `${held.name.replaceAll("_", " ")} ${c.previousElementSibling.value}`;
  } else { held.now = at; words = at.map((x) => x.toFixed(2)).join(", ") + " m"; }
  state.dirty = true; tell(words, ev);
  send("set", { name: held.name, value });
};

/* ---- what the session says ---- */
function sayTask(c) { if (c.type === "range" && c.dataset.default) c.previousElementSibling.value = "default"; else say(c); }
function showMotion({ data }) {
  const first = !ref;
  Object.assign(D, data);
  readMotion();
  if (gl && !gl.isContextLost()) setFixed();
  if (ref && first && !show.ref) option("ref");
  buildCurves(); showTimes();
  if (state.t > T1 || state.t < T0) seek(T0);
  if (!state.playing && N > 1) play();
  state.dirty = true; document.body.dataset.motions = +(document.body.dataset.motions || 0) + 1;
}
function showTask({ busy, problem, note, sentence, limits, values: given, figures, kept, compared }) {
  values = given;
  $("status").replaceChildren(busy ? `Solving: ${busy}` : problem ? "No such motion; the last good one is shown." : sentence);
  if (note) { const b = document.createElement("b"); b.textContent = note; $("status").append(b); }
  document.body.classList.toggle("busy", !!busy);
  $("verdict").textContent = problem || sentence; $("verdict").classList.toggle("wrong", !!problem);
  $("limits").textContent = limits.length ? `Limits that shape it most: ${limits.join("; ")}.` : "";
  for (const c of setters) {
    const v = given[c.name];
    if (c.type === "checkbox") { if (performance.now() - (c.held || -HELD) > HELD) c.checked = v; continue; }
    if (v === null) { if (performance.now() - (c.held || -HELD) > HELD) c.dataset.default = "1"; } else { delete c.dataset.default; follow(c, v); }
    sayTask(c);
  }
  $("figures").replaceChildren(...figures.map((row) => { const tr = document.createElement("tr"); row.forEach((text, k) => { const td = document.createElement(k ? "td" : "th"); td.textContent = text; tr.append(td); }); return tr; }));
  $("kept").replaceChildren(...kept.map((text, k) => {
    const li = document.createElement("li"), name = document.createElement("span");
    name.textContent = text; li.append(name);
    for (const [word, act] of [[compared === k ? "Hide" : "Compare", () => send("compare", { value: compared === k ? -1 : k })], ["Return to it", () => send("restore", { value: k })]]) {
      const b = document.createElement("button"); b.textContent = word; b.addEventListener("click", act); li.append(b);
    }
    return li;
  }));
  document.body.dataset.busy = busy ? "1" : "";
}
const RECEIVERS = { motion: showMotion, panel: showTask };
for (const c of setters) {
  c.addEventListener("input", () => {
    c.held = performance.now(); delete c.dataset.default; sayTask(c);
    send("set", { name: c.name, value: c.type === "checkbox" ? c.checked : valueOf(c) });
  });
  sayTask(c);
}
for (const name of ["reset", "keep", "save"]) $(name)?.addEventListener("click", () => send(name));
setUpToggles();
connect((message) => RECEIVERS[message.kind]?.(message));
