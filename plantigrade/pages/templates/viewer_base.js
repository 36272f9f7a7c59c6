"use strict";
/* A small WebGL 2 viewer: a body, its ground and its forces. This file is shared by the page of a
   recorded motion (viewer.html) and by the page of a running simulation (live.html), as are
   shapes, drawing, skin and camera. Each page adds its own instant(), overlays(), and controls. */
const D = JSON.parse(document.getElementById("scene").textContent);
const $ = (id) => document.getElementById(id);
const NB = D.bodies;
const state = { t: 0, past: 0, playing: false, speed: 1, repeat: true, follow: true, dirty: true, drawn: 0 };
const show = { body: true, solids: false, xray: false, ref: true, beside: false, recorded: true, fitted: true,
  force: true, pushes: true, cop: true, com: true };

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
    ? `Drawn simply: this machine drew ${pictures(quality.rate)} per second. The speed is true.`
    : "Drawn simply.";
  document.body.dataset.quality = simple ? "simple" : "full";
  state.dirty = true;
}

/* ---- text ---- */
function pictures(rate) {   // decimals below ten, and one picture in the singular
  const shown = rate.toFixed(rate < 9.95 ? 1 : 0).replace(/\.0$/, "");
  return `${shown} picture${shown === "1" ? "" : "s"}`;
}
function nice(low, high) {   // two to five round values
  const raw = (high - low) / 4, power = 10 ** Math.floor(Math.log10(raw || 1));
  const steps = [1, 2, 2.5, 5, 10].map((x) => x * power), step = steps.find((x) => x >= raw) || power, ticks = [];
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9; v += step) ticks.push(Math.abs(v) < 1e-12 ? 0 : v);
  return ticks;
}
const signed = (v, digits) => v.toFixed(digits).replace("-", "−");
function tell(text, ev) {
  const tip = $("tip"); tip.hidden = !text;
  if (!text) return;
  tip.textContent = text;
  tip.style.left = Math.max(4, Math.min(ev.clientX + 14, innerWidth - tip.offsetWidth - 6)) + "px";
  tip.style.top = Math.min(ev.clientY + 12, innerHeight - tip.offsetHeight - 4) + "px";
}
