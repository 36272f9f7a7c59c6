"use strict";
/* A small WebGL 2 viewer: one body, its ground, markers and forces, driven by one clock.
   Four files in one script: data and clock, drawing, curves, controls. */
const D = JSON.parse(document.getElementById("scene").textContent);
const $ = (id) => document.getElementById(id);

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
const time = D.time, N = time.length, NB = D.bodies;
const T0 = time[0], T1 = time[N - 1];
const body = { p: decode(D.positions), q: decode(D.quats) };
const ref = D.reference ? { p: decode(D.reference.positions), q: decode(D.reference.quats) } : null;
const com = decode(D.com), recorded = decode(D.recorded), fitted = decode(D.fitted);
const force = decode(D.force), point = decode(D.point), total = decode(D.total), cop = decode(D.cop);
const estimated = decode(D.estimated);
const floor = decode(D.floor) || new Float32Array(N), level = decode(D.level) || floor;
const M = D.marker_names.length, K = D.contact_colours.length;

const state = { t: T0, past: 0, playing: false, speed: 1, repeat: true, follow: true, dirty: true };
const show = { body: true, solids: false, xray: false, ref: !!ref, beside: false, recorded: true, fitted: true,
  force: true, pushes: true, cop: true, com: true };

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

/* ---- quality: drawn simply where the machine is slow ---- */
const SLOW = 20, WINDOW = 1500;   // frames per second; what is measured over [ms]
const quality = { wish: "auto", simple: false, frames: 0, spent: 0, rate: NaN, windows: 0 };
function measure(ms) {
  quality.frames += 1; quality.spent += ms;
  if (quality.spent < WINDOW || quality.frames < 3) return;
  quality.rate = (1000 * quality.frames) / quality.spent;
  quality.frames = quality.spent = 0;
  quality.windows += 1;      // the first one holds the start of the page
  if (quality.wish === "auto" && quality.windows > 1 && quality.rate < SLOW) setSimple(true);
}
function setQuality(wish) {
  Object.assign(quality, { wish, frames: 0, spent: 0, windows: 0 });
  $("quality").value = wish;
  setSimple(wish === "simple");
}
function setSimple(simple) {
  if (simple !== quality.simple && gl) { quality.simple = simple; setBody(); }
  quality.simple = simple;
  const slow = simple && quality.wish === "auto";
  $("slow").hidden = !simple;
  $("slow").textContent = slow
    ? `Drawn simply: this machine drew ${quality.rate.toFixed(0)} pictures per second. The speed is true.`
    : "Drawn simply.";
  document.body.dataset.quality = simple ? "simple" : "full";
  state.dirty = true;
}
