
/* ---- a running simulation: one message is one picture of body, forces and centre of mass ---- */
Object.assign(show, { contacts: true, support: true });
const SMOOTH = 0.3;          // [s] in which the camera follows the ground
const THIN = 0.004, LIFT = 0.003;   // radius of lines, and their height over the ground [m]
let frame = null, ground = 0, pack = "";
function accept(message) {
  const dt = frame ? message.time - frame.time : 0;
  frame = message;
  ground = dt > 0 && dt < 1 ? ground + (frame.floor - ground) * (1 - Math.exp(-dt / SMOOTH)) : frame.floor;
  frame.poses = new Float32Array(NB * 8).fill(0);
  for (let i = 0; i < NB; i++) {
    const p = frame.positions[i] || AWAY, [w, x, y, z] = frame.quats[i] || STRAIGHT;
    frame.poses.set([...p, 0, x, y, z, w], i * 8);
  }
  if (gl && pack !== String(frame.pack)) {
    pack = String(frame.pack);
    setFixed(frame.pack ? [{ kind: "box", size: frame.pack, position: [0, 0, 0], quat: STRAIGHT, colour: colour(D.colours.thing), body: NB - 1 }] : []);
  }
  state.dirty = true;
}
function instant() { return { com: frame.com, floor: frame.floor, level: ground, poses: frame.poses, reference: null, ground: frame.ground ?? D.ground }; }
const lifted = (p) => [p[0], p[1], p[2] + LIFT];
function line(a, b, c, radius = THIN) { put("shaft", a, sub(b, a), radius, c); }
function overlays() {
  const near = closeUp(), thin = near ? 0.5 : 1;
  if (show.force && !near) frame.reactions.forEach((r, s) => r && arrow(r[0], r[1].map((x) => x * SCALE), 0.013, SIDE[s]));
  if (show.contacts) for (const [k, p, f] of frame.contacts) arrow(p, f.map((x) => x * SCALE * thin), 0.006 * thin, CONTACT[k]);
  if (show.cop) {
    frame.reactions.forEach((r, s) => r && put("disc", lifted(r[0]), UP, 0.032 * thin, SIDE[s]));
    if (frame.pressure) put("disc", lifted(lifted(frame.pressure)), UP, 0.018 * thin, COLOURS.com);
  }
  if (show.support) frame.support.forEach((p, k) => line(lifted(p), lifted(frame.support[(k + 1) % frame.support.length]), COLOURS.support, THIN * thin));
  if (show.pushes) for (const [p, f] of frame.pushes) {
    const v = f.map((x) => x * SCALE), l = Math.hypot(...v) || 1;
    arrow(p.map((x, k) => x - v[k] * (1 + 0.3 / l)), v, 0.016, COLOURS.pushed);
  }
  if (frame.rope) { line(frame.rope[0], frame.rope[1], COLOURS.rope, 0.006); sphere(frame.rope[1], 0.018, COLOURS.rope); }
  for (const { colour: hex, lines, points } of frame.drawings) {
    for (const [a, b] of lines) line(a, b, colour(hex));
    for (const p of points) sphere(p, 0.015, colour(hex));
  }
  if (show.com && !near) centreOfMass(frame.com, frame.floor);
}

/* ---- the session ---- */
const RECEIVERS = { frame: accept, panel: showPanel, curves: showCurves };
function receive(message) {
  if (message.world === D.world) RECEIVERS[message.kind]?.(message);
  else if (message.world > D.world) again();   // another body: its shapes come with the page
}
function again() {           // the view and what is shown stay
  sessionStorage.setItem("view", JSON.stringify({ camera: { azimuth: camera.azimuth, elevation: camera.elevation, distance: camera.distance, height: camera.height }, show, follow: state.follow, panels: document.body.className }));
  location.reload();
}
const KEYS = { " ": togglePause, n: () => send("step"), r: () => send("restart"), p: pushTrunk, ...VIEW_KEYS };

let before = null;
function tick(now) {
  if (state.dirty && frame) {
    if (before !== null) measure(Math.min(now - before, 1000));
    state.dirty = false;
    $("clock").textContent = `${frame.time.toFixed(2)} s`;
    if (gl && !gl.isContextLost()) draw();
    document.body.dataset.time = frame.time;
    before = now;
  } else before = null;
  requestAnimationFrame(tick);
}
startDrawing(); setUpPanels();
const kept = JSON.parse(sessionStorage.getItem("view") || "null");
sessionStorage.removeItem("view");
if (kept) Object.assign(show, kept.show);
setUpLegend(); setUpPointers({ grab, drag }); setQuality("auto"); setView("oblique");
if (kept) { Object.assign(camera, kept.camera); document.body.className = kept.panels; markView(null); if (!kept.follow) $("follow").click(); }
connect(receive);
window.plantigrade = { state, camera, show, setView, setQuality, quality, send };
document.body.dataset.ready = "1";
requestAnimationFrame(tick);
