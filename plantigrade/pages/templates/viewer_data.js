
/* ---- data: arrays come as 16-bit steps in base64; 65535 means "not there" ---- */
function decode(a) {
  if (!a) return null;
  const bytes = Uint8Array.from(atob(a.data), (c) => c.charCodeAt(0));
  const words = new Uint16Array(bytes.buffer);
  const out = new Float32Array(words.length);
  for (let i = 0; i < words.length; i++)
    out[i] = words[i] === 65535 ? NaN : a.low + words[i] * a.step;
  return out;
}
let time, N, T0, T1, body, ref, com, recorded, fitted, force, point, total, cop, estimated, floor, level, M, K;
function readMotion() {      // of D, which another motion of the same person may have replaced
  time = D.time; N = time.length; T0 = time[0]; T1 = time[N - 1];
  body = { p: decode(D.positions), q: decode(D.quats) };
  ref = D.reference ? { p: decode(D.reference.positions), q: decode(D.reference.quats) } : null;
  com = decode(D.com); recorded = decode(D.recorded); fitted = decode(D.fitted);
  force = decode(D.force); point = decode(D.point); total = decode(D.total); cop = decode(D.cop);
  estimated = decode(D.estimated);
  floor = decode(D.floor) || new Float32Array(N); level = decode(D.level) || floor;
  M = D.marker_names.length; K = D.contact_colours.length;
}
readMotion();
state.t = T0; show.ref = !!ref;

/* ---- time ---- */
function frameAt(t) {
  let a = 0, b = N - 1;
  while (b - a > 1) { const m = (a + b) >> 1; if (time[m] <= t) a = m; else b = m; }
  if (N === 1) return [0, 0, 0];
  return [a, b, Math.min(1, Math.max(0, (t - time[a]) / (time[b] - time[a])))];
}
function mix1(array, [a, b, s]) { return array[a] * (1 - s) + array[b] * s; }
function mix3(array, width, column, [a, b, s]) {
  const i = (a * width + column) * 3, j = (b * width + column) * 3;
  const near = s < 0.5 ? i : j, out = [0, 0, 0];
  for (let k = 0; k < 3; k++) {
    const v = array[i + k] * (1 - s) + array[j + k] * s;
    out[k] = Number.isNaN(v) ? array[near + k] : v;
  }
  return out;
}
const PAUSE = 0.6;           // the last frame stays this long before the first comes again [s]
function advance(seconds) {  // however long a picture took: what is late is left out, not slowed down
  const whole = T1 - T0;
  let run = state.t - T0 + state.past + seconds * state.speed;
  if (state.repeat) run %= whole + PAUSE * state.speed;
  else if (run >= whole) { run = whole; pause(); }
  if (run < whole) { state.t = T0 + run; state.past = 0; } else { state.t = T1; state.past = state.repeat ? run - whole : 0; }
  state.dirty = true;
}
function cycleAt(side) {     // percent of the gait cycle; null outside of whole cycles
  const strikes = D.cycles[side], k = strikes.findLastIndex((s) => s <= state.t);
  if (k < 0 || k + 1 >= strikes.length) return null;
  return (100 * (state.t - strikes[k])) / (strikes[k + 1] - strikes[k]);
}
function posesAt(source, at) {   // position, and quaternion with the scalar last, of every body
  const [a, b, s] = at, poses = new Float32Array(NB * 8);
  for (let i = 0; i < NB; i++) {
    const p = mix3(source.p, NB, i, at), out = Number.isNaN(p[0]);   // a thing that is not there yet
    poses.set(out ? AWAY : p, i * 8);
    let qa = source.q.subarray((a * NB + i) * 4, (a * NB + i) * 4 + 4);
    let qb = source.q.subarray((b * NB + i) * 4, (b * NB + i) * 4 + 4);
    if (Number.isNaN(qa[0])) qa = out ? STRAIGHT : qb;
    if (Number.isNaN(qb[0])) qb = qa;
    const sign = qa[0] * qb[0] + qa[1] * qb[1] + qa[2] * qb[2] + qa[3] * qb[3] < 0 ? -1 : 1;
    const q = [0, 1, 2, 3].map((k) => qa[k] * (1 - s) + sign * qb[k] * s), l = Math.hypot(...q) || 1;
    poses.set([q[1] / l, q[2] / l, q[3] / l, q[0] / l], i * 8 + 4);
  }
  return poses;
}
function instant() {         // everything that is drawn together
  const at = frameAt(state.t);
  return { at, com: mix3(com, 1, 0, at), floor: mix1(floor, at), level: mix1(level, at),
    poses: posesAt(body, at), reference: ref && posesAt(ref, at), ground: D.ground };
}

/* ---- forces and markers ---- */
function overlays({ at, com: c, floor: ground }) {
  const near = closeUp() ? 0.5 : 1;      // forces and discs are smaller near the foot
  if (recorded || fitted) for (let i = 0; i < M; i++) {
    const r = recorded && mix3(recorded, M, i, at), f = fitted && mix3(fitted, M, i, at);
    if (f && show.fitted) sphere(f, 0.0105, COLOURS.fitted);
    if (r && show.recorded) sphere(r, 0.0115, COLOURS.recorded);
    if (r && f && show.recorded && show.fitted && Math.hypot(...sub(f, r)) > 0.01)
      put("shaft", r, sub(f, r), 0.003, COLOURS.text);
  }
  if (total && show.force && !(closeUp() && D.many_contacts)) for (let s = 0; s < 3; s++) {
    const c = cop && mix3(cop, 3, s, at);
    const radius = estimated && estimated[at[0] * 3 + s] > 0.5 ? 0.006 : 0.013;
    if (c && !Number.isNaN(c[0])) arrow(c, mix3(total, 3, s, at).map((x) => x * SCALE), radius, SIDE[s]);
  }
  if (force && point && show.pushes) for (const k of D.pushes) {   // the tip is where it pushes, before the body
    const v = mix3(force, K, k, at).map((x) => x * SCALE), l = Math.hypot(...v) || 1;
    arrow(mix3(point, K, k, at).map((x, i) => x - v[i] * (1 + 0.3 / l)), v, 0.016, COLOURS.pushed);
  }
  if (force && point && show.force && D.many_contacts) for (let k = 0; k < K; k++) if (!D.pushes.includes(k))
    arrow(mix3(point, K, k, at), mix3(force, K, k, at).map((x) => x * SCALE * near), 0.006 * near, CONTACT[k]);
  if (cop && show.cop) {
    for (let s = 0; s < 3; s++) {
      for (let i = Math.max(0, at[0] - 150); i <= at[0]; i++) {   // what has been, and not what will be
        const p = mix3(cop, 3, s, [i, i, 0]);
        if (!Number.isNaN(p[0])) put("disc", [p[0], p[1], p[2] + 0.004], UP, 0.011 * near, SIDE[s]);
      }
      const p = mix3(cop, 3, s, at);
      if (!Number.isNaN(p[0])) put("disc", [p[0], p[1], p[2] + 0.006], UP, 0.032 * near, SIDE[s]);
    }
  }
  if (show.com && !closeUp()) centreOfMass(c, ground);
  for (const draw of extras) draw();
}
const extras = [];           // drawn by the page of a task that is solved live
