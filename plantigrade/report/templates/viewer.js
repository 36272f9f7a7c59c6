"use strict";
/* A small WebGL 2 viewer: one body, its ground, markers and forces, driven by one clock. */
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
const M = D.marker_names.length, K = D.contact_colours.length;

const state = { t: T0, playing: false, speed: 1, follow: true, dirty: true };
const show = { body: true, xray: false, ref: !!ref, beside: false, recorded: true, fitted: true,
  force: true, cop: true, com: true };

/* ---- time ---- */
function frameAt(t) {
  let a = 0, b = N - 1;
  while (b - a > 1) { const m = (a + b) >> 1; if (time[m] <= t) a = m; else b = m; }
  if (N === 1) return [0, 0, 0];
  return [a, b, Math.min(1, Math.max(0, (t - time[a]) / (time[b] - time[a])))];
}
function mix3(array, width, column, [a, b, s]) {
  const i = (a * width + column) * 3, j = (b * width + column) * 3;
  const near = s < 0.5 ? i : j, out = [0, 0, 0];
  for (let k = 0; k < 3; k++) {
    const v = array[i + k] * (1 - s) + array[j + k] * s;
    out[k] = Number.isNaN(v) ? array[near + k] : v;
  }
  return out;
}

/* ---- geometry ---- */
function revolve(profile, n) {                 // profile: [radius, z, normal r, normal z] rows
  const v = [], f = [];
  for (let i = 0; i <= n; i++) {
    const a = (2 * Math.PI * i) / n, c = Math.cos(a), s = Math.sin(a);
    for (const [r, z, nr, nz] of profile) v.push([r * c, r * s, z, nr * c, nr * s, nz]);
  }
  const m = profile.length;
  for (let i = 0; i < n; i++) for (let j = 0; j < m - 1; j++) {
    const a = i * m + j, b = a + m;
    f.push([a, b, a + 1], [a + 1, b, b + 1]);
  }
  return { v, f };
}
function arcs(radius, half, n) {
  const rows = [];
  for (let i = 0; i <= 2 * n; i++) {
    const a = -Math.PI / 2 + (Math.PI * i) / (2 * n), shift = i <= n ? -half : half;
    rows.push([radius * Math.cos(a), radius * Math.sin(a) + shift, Math.cos(a), Math.sin(a)]);
    if (i === n) rows.push([radius, half, 1, 0]);
  }
  return rows;
}
function boxOf([x, y, z]) {
  const v = [], f = [];
  for (const axis of [0, 1, 2]) for (const sign of [-1, 1]) {
    const u = (axis + 1) % 3, w = (axis + 2) % 3, base = v.length;
    for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
      const p = [0, 0, 0], n = [0, 0, 0];
      p[axis] = sign; p[u] = a * sign; p[w] = b; n[axis] = sign;
      v.push([p[0] * x, p[1] * y, p[2] * z, ...n]);
    }
    f.push([base, base + 1, base + 2], [base, base + 2, base + 3]);
  }
  return { v, f };
}
function meshOf(s) {
  const v = [], f = [];
  for (const [a, b, c] of s.faces) {
    const [p, q, r] = [s.vertices[a], s.vertices[b], s.vertices[c]];
    const u = q.map((x, i) => x - p[i]), w = r.map((x, i) => x - p[i]);
    let n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
    const l = Math.hypot(...n) || 1; n = n.map((x) => x / l);
    f.push([v.length, v.length + 1, v.length + 2]);
    v.push([...p, ...n], [...q, ...n], [...r, ...n]);
  }
  return { v, f };
}
function geometryOf(s) {
  if (s.kind === "capsule") return revolve(arcs(s.size[0], s.size[1], 9), 24);
  if (s.kind === "cylinder") {
    const [r, h] = s.size;
    return revolve([[0, -h, 0, -1], [r, -h, 0, -1], [r, -h, 1, 0], [r, h, 1, 0], [r, h, 0, 1], [0, h, 0, 1]], 28);
  }
  if (s.kind === "box") return boxOf(s.size);
  if (s.kind === "mesh") return meshOf(s);
  const axes = s.kind === "sphere" ? [s.size[0], s.size[0], s.size[0]] : s.size;
  const g = revolve(arcs(1, 0, 10), 28);
  for (const v of g.v) for (let k = 0; k < 3; k++) { v[k] *= axes[k]; v[k + 3] /= axes[k]; }
  return g;
}
function turn([w, x, y, z], p) {
  const tx = 2 * (y * p[2] - z * p[1]), ty = 2 * (z * p[0] - x * p[2]), tz = 2 * (x * p[1] - y * p[0]);
  return [p[0] + w * tx + y * tz - z * ty, p[1] + w * ty + z * tx - x * tz, p[2] + w * tz + x * ty - y * tx];
}

/* ---- WebGL ---- */
const canvas = $("canvas");
const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
if (!gl) $("nogl").hidden = false;

const LIGHT = `
precision highp float; precision highp sampler2DShadow;
uniform mat4 uLight; uniform sampler2DShadow uShadow; uniform vec3 uSun, uEye; uniform vec3 uSky;
float lit(vec3 p, vec3 n) {
  vec4 h = uLight * vec4(p + n * 0.012, 1.0); vec3 s = h.xyz * 0.5 + 0.5;
  if (s.x < 0. || s.x > 1. || s.y < 0. || s.y > 1. || s.z > 1.) return 1.0;
  float sum = 0.0;
  for (int i = -2; i <= 2; i++) for (int j = -2; j <= 2; j++)
    sum += texture(uShadow, vec3(s.xy + vec2(i, j) * 0.0007, s.z - 0.0012));
  return sum / 25.0;
}
vec3 shade(vec3 base, vec3 p, vec3 n, float gloss) {
  vec3 v = normalize(uEye - p); if (dot(n, v) < 0.0) n = -n;
  float sun = max(dot(n, uSun), 0.0) * lit(p, n);
  vec3 sky = mix(vec3(0.36, 0.35, 0.34), vec3(0.58, 0.60, 0.64), 0.5 + 0.5 * n.z);
  float rim = pow(1.0 - max(dot(n, v), 0.0), 3.0) * 0.09;
  float spec = pow(max(dot(n, normalize(v + uSun)), 0.0), 42.0) * gloss * sun;
  return base * (sky + 0.56 * sun + 0.13 * max(dot(n, v), 0.0)) + rim * mix(base, vec3(1.0), 0.5) + spec;
}`;
const POSE = `
uniform highp sampler2D uPose; uniform vec3 uOffset;
vec3 turned(vec4 q, vec3 p) { return p + 2.0 * cross(q.xyz, cross(q.xyz, p) + q.w * p); }
void place(float b, vec3 p, vec3 n, out vec3 wp, out vec3 wn) {
  vec4 t = texelFetch(uPose, ivec2(int(b) * 2, 0), 0), q = texelFetch(uPose, ivec2(int(b) * 2 + 1, 0), 0);
  wp = turned(q, p) + t.xyz + (b > 0.5 ? uOffset : vec3(0)); wn = turned(q, n);
}`;
const INST = `
layout(location=0) in vec3 aPos; layout(location=1) in vec3 aNormal;
layout(location=2) in vec3 iPos; layout(location=3) in vec3 iDir; layout(location=4) in float iRad; layout(location=5) in vec4 iColor;
void placeI(out vec3 wp, out vec3 wn) {
  float l = max(length(iDir), 1e-9); vec3 z = iDir / l;
  vec3 x = normalize(cross(abs(z.z) > 0.9 ? vec3(1, 0, 0) : vec3(0, 0, 1), z)), y = cross(z, x);
  wp = iPos + (x * aPos.x + y * aPos.y) * iRad + iDir * aPos.z;
  wn = normalize((x * aNormal.x + y * aNormal.y) / iRad + z * aNormal.z / l);
}`;
const HEAD = "#version 300 es\n";
const SHADERS = {
  body: [`layout(location=0) in vec3 aPos; layout(location=1) in vec3 aNormal; layout(location=2) in float aBody; layout(location=3) in vec3 aColor;
    uniform mat4 uView; out vec3 P, Nn, C; ${POSE}
    void main() { vec3 n; place(aBody, aPos, aNormal, P, n); Nn = n; C = aColor; gl_Position = uView * vec4(P, 1.0); }`,
    `${LIGHT} in vec3 P, Nn, C; uniform vec4 uTint; uniform float uAlpha; out vec4 o;
    void main() { o = vec4(shade(mix(C, uTint.rgb, uTint.a), P, normalize(Nn), 0.22), uAlpha); }`],
  bodyShadow: [`layout(location=0) in vec3 aPos; layout(location=1) in vec3 aNormal; layout(location=2) in float aBody;
    uniform mat4 uView; ${POSE} void main() { vec3 p, n; place(aBody, aPos, aNormal, p, n); gl_Position = uView * vec4(p, 1.0); }`,
    `precision highp float; out vec4 o; void main() { o = vec4(1.0); }`],
  inst: [`${INST} uniform mat4 uView; out vec3 P, Nn; out vec4 C;
    void main() { vec3 n; placeI(P, n); Nn = n; C = iColor; gl_Position = uView * vec4(P, 1.0); }`,
    `${LIGHT} in vec3 P, Nn; in vec4 C; uniform float uFade; out vec4 o;
    void main() { o = vec4(mix(C.rgb, shade(C.rgb, P, normalize(Nn), 0.1), 0.85), C.a * uFade); }`],
  ground: [`layout(location=0) in vec3 aPos; uniform mat4 uView; uniform vec3 uCentre; out vec3 P;
    void main() { P = vec3(aPos.xy * 60.0 + uCentre.xy, 0.0); gl_Position = uView * vec4(P, 1.0); }`,
    `${LIGHT} in vec3 P; uniform vec3 uCentre, uFloor, uLine; out vec4 o;
    float grid(vec2 p, float w) { vec2 g = abs(fract(p - 0.5) - 0.5) / max(fwidth(p), vec2(1e-5)); return 1.0 - min(min(g.x, g.y) / w, 1.0); }
    void main() {
      float d = length(P.xy - uCentre.xy), fade = exp(-d * d / 90.0);
      float fine = grid(P.xy * 4.0, 1.1) * 0.30 * exp(-d * d / 14.0), metre = grid(P.xy, 1.5) * 0.75;
      vec3 c = mix(uFloor, uLine, max(fine, metre) * fade);
      c *= mix(1.0, 0.55 + 0.45 * lit(P, vec3(0, 0, 1)), fade);
      o = vec4(mix(uSky, c, smoothstep(0.0, 0.5, exp(-d * d / 220.0))), 1.0);
    }`],
};
let programs = {}, buffers = {}, uniforms = {};
function build(name) {
  const p = gl.createProgram();
  SHADERS[name].forEach((source, i) => {
    const s = gl.createShader(i ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
    gl.shaderSource(s, HEAD + source); gl.compileShader(s);
    if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(name + ": " + gl.getShaderInfoLog(s));
    gl.attachShader(p, s);
  });
  gl.linkProgram(p);
  if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(name + ": " + gl.getProgramInfoLog(p));
  uniforms[name] = new Proxy({}, { get: (o, k) => (k in o ? o[k] : (o[k] = gl.getUniformLocation(p, k))) });
  programs[name] = p;
}
function arrayBuffer(data, attributes, stride) {
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
  let offset = 0;
  for (const [location, size] of attributes) {
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, size, gl.FLOAT, false, stride * 4, offset * 4);
    offset += size;
  }
}
function poseTexture() {
  const t = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, t);
  for (const k of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, k, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 2 * NB, 1, 0, gl.RGBA, gl.FLOAT, null);
  return t;
}
const SHADOW = 2048, INSTANCE = 11;
function setUp() {
  Object.keys(SHADERS).forEach(build);
  const vertices = [], faces = [];
  for (const s of D.shapes) {
    const g = geometryOf(s), base = vertices.length / 10;
    for (const v of g.v) {
      const p = turn(s.quat, v.slice(0, 3)), n = turn(s.quat, v.slice(3));
      const l = Math.hypot(...n) || 1;
      vertices.push(p[0] + s.position[0], p[1] + s.position[1], p[2] + s.position[2],
        n[0] / l, n[1] / l, n[2] / l, s.body, ...s.colour);
    }
    for (const f of g.f) faces.push(f[0] + base, f[1] + base, f[2] + base);
  }
  const vao = gl.createVertexArray(); gl.bindVertexArray(vao);
  arrayBuffer(new Float32Array(vertices), [[0, 3], [1, 3], [2, 1], [3, 3]], 10);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(faces), gl.STATIC_DRAW);
  buffers.body = { vao, count: faces.length };
  const unit = {
    sphere: revolve(arcs(1, 0, 5), 14),
    shaft: revolve([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [0, 1, 0, 1]], 14),
    cone: revolve([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 0.9, 0.4], [0, 1, 0.9, 0.4]], 16),
  };
  for (const [name, g] of Object.entries(unit)) {
    const v = gl.createVertexArray(); gl.bindVertexArray(v);
    arrayBuffer(new Float32Array(g.v.flat()), [[0, 3], [1, 3]], 6);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(g.f.flat()), gl.STATIC_DRAW);
    const instances = gl.createBuffer(); gl.bindBuffer(gl.ARRAY_BUFFER, instances);
    let offset = 0;
    for (const [location, size] of [[2, 3], [3, 3], [4, 1], [5, 4]]) {
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, size, gl.FLOAT, false, INSTANCE * 4, offset * 4);
      gl.vertexAttribDivisor(location, 1); offset += size;
    }
    buffers[name] = { vao: v, count: g.f.length * 3, instances, rows: [] };
  }
  const gv = gl.createVertexArray(); gl.bindVertexArray(gv);
  arrayBuffer(new Float32Array([-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0]), [[0, 3]], 3);
  buffers.ground = { vao: gv };
  buffers.pose = poseTexture(); buffers.refPose = poseTexture();
  buffers.shadow = gl.createTexture(); gl.bindTexture(gl.TEXTURE_2D, buffers.shadow);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW, SHADOW);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  buffers.fbo = gl.createFramebuffer(); gl.bindFramebuffer(gl.FRAMEBUFFER, buffers.fbo);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, buffers.shadow, 0);
  gl.drawBuffers([gl.NONE]); gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.enable(gl.DEPTH_TEST);
}

/* ---- matrices (columns, as WebGL wants them) ---- */
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => { const l = Math.hypot(...a) || 1; return [a[0] / l, a[1] / l, a[2] / l]; };
function lookAt(eye, target, up) {
  const z = unit(sub(eye, target)), x = unit(cross(up, z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}
function perspective(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
}
const ortho = (r, n, f) => [1 / r, 0, 0, 0, 0, 1 / r, 0, 0, 0, 0, -2 / (f - n), 0, 0, 0, -(f + n) / (f - n), 1];
function mul(a, b) {
  const o = new Array(16).fill(0);
  for (let c = 0; c < 4; c++) for (let r = 0; r < 4; r++) for (let k = 0; k < 4; k++) o[c * 4 + r] += a[k * 4 + r] * b[c * 4 + k];
  return o;
}

/* ---- camera ---- */
const FOV = 0.55, HEIGHT = D.height;
const VIEWS = { oblique: [-0.95, 0.20], right: [-Math.PI / 2, 0.04], left: [Math.PI / 2, 0.04], front: [0, 0.06], top: [-Math.PI / 2, 1.5] };
const camera = { azimuth: D.heading + VIEWS.oblique[0], elevation: VIEWS.oblique[1], distance: HEIGHT * 2.55, target: [0, 0, 0] };
function eye() {
  const c = Math.cos(camera.elevation);
  return [camera.target[0] + camera.distance * c * Math.cos(camera.azimuth),
    camera.target[1] + camera.distance * c * Math.sin(camera.azimuth),
    camera.target[2] + camera.distance * Math.sin(camera.elevation)];
}
function setView(name) {
  [camera.azimuth, camera.elevation] = [D.heading + VIEWS[name][0], VIEWS[name][1]];
  document.querySelectorAll("#views button").forEach((b) => b.classList.toggle("on", b.dataset.view === name));
  state.dirty = true;
}

/* ---- one frame ---- */
const colour = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
const COLOURS = Object.fromEntries(Object.entries(D.colours).map(([k, v]) => [k, colour(v)]));
const CONTACT = D.contact_colours.map(colour), SIDE = D.side_colours.map(colour);
function upload(texture, source, at) {
  const [a, b, s] = at, data = new Float32Array(NB * 8);
  for (let i = 0; i < NB; i++) {
    data.set(mix3(source.p, NB, i, at), i * 8);
    const qa = source.q.subarray((a * NB + i) * 4, (a * NB + i) * 4 + 4);
    const qb = source.q.subarray((b * NB + i) * 4, (b * NB + i) * 4 + 4);
    const sign = qa[0] * qb[0] + qa[1] * qb[1] + qa[2] * qb[2] + qa[3] * qb[3] < 0 ? -1 : 1;
    const q = [0, 1, 2, 3].map((k) => qa[k] * (1 - s) + sign * qb[k] * s), l = Math.hypot(...q) || 1;
    data.set([q[1] / l, q[2] / l, q[3] / l, q[0] / l], i * 8 + 4);
  }
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 2 * NB, 1, gl.RGBA, gl.FLOAT, data);
}
function put(kind, p, direction, radius, c, alpha = 1) { buffers[kind].rows.push(...p, ...direction, radius, ...c, alpha); }
function sphere(p, radius, c) { if (!Number.isNaN(p[0])) put("sphere", p, [0, 0, radius], radius, c); }
function arrow(p, v, radius, c) {
  const l = Math.hypot(...v);
  if (!(l > 0.015) || Number.isNaN(p[0])) return;
  const head = Math.min(0.09, 0.4 * l), k = (l - head) / l;
  put("shaft", p, v.map((x) => x * k), radius, c);
  put("cone", p.map((x, i) => x + v[i] * k), v.map((x) => (x * head) / l), radius * 2.4, c);
}
const SCALE = 0.6 / D.weight;   // one body weight is drawn 0.6 m long
function collect(at) {
  for (const k of ["sphere", "shaft", "cone"]) buffers[k].rows.length = 0;
  if (recorded || fitted) for (let i = 0; i < M; i++) {
    const r = recorded && mix3(recorded, M, i, at), f = fitted && mix3(fitted, M, i, at);
    if (f && show.fitted) sphere(f, 0.0105, COLOURS.fitted);
    if (r && show.recorded) sphere(r, 0.0115, COLOURS.recorded);
    if (r && f && show.recorded && show.fitted && !Number.isNaN(r[0]) && !Number.isNaN(f[0]))
      put("shaft", r, sub(f, r), 0.003, COLOURS.text);
  }
  if (total && show.force) for (let s = 0; s < 3; s++) {
    const c = cop && mix3(cop, 3, s, at);
    if (c && !Number.isNaN(c[0])) arrow(c, mix3(total, 3, s, at).map((x) => x * SCALE), 0.013, SIDE[s]);
  }
  if (force && point && show.force && D.many_contacts) for (let k = 0; k < K; k++)
    arrow(mix3(point, K, k, at), mix3(force, K, k, at).map((x) => x * SCALE), 0.006, CONTACT[k]);
  if (cop && show.cop) {
    for (let s = 0; s < 3; s++) {
      for (let i = Math.max(0, at[0] - 150); i < Math.min(N, at[0] + 150); i++) {
        const p = mix3(cop, 3, s, [i, i, 0]);
        if (!Number.isNaN(p[0])) put("sphere", [p[0], p[1], p[2] + 0.003], [0, 0, 0.002], i <= at[0] ? 0.011 : 0.006, SIDE[s]);
      }
      const p = mix3(cop, 3, s, at);
      if (!Number.isNaN(p[0])) put("sphere", [p[0], p[1], p[2] + 0.004], [0, 0, 0.004], 0.032, SIDE[s]);
    }
  }
  if (show.com) {
    const c = mix3(com, 1, 0, at);
    sphere(c, 0.035, COLOURS.com);
    put("shaft", [c[0], c[1], 0.002], [0, 0, c[2]], 0.0035, COLOURS.com);
    put("sphere", [c[0], c[1], 0.004], [0, 0, 0.003], 0.028, COLOURS.com);
  }
}
let last = null;             // the last view, for picking
function draw() {
  const at = frameAt(state.t);
  const c = mix3(com, 1, 0, at);
  if (state.follow) camera.target = [c[0], c[1], HEIGHT * 0.5];
  const w = Math.round(canvas.clientWidth * devicePixelRatio), h = Math.round(canvas.clientHeight * devicePixelRatio);
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  if (!w || !h) return;
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  COLOURS.text = dark ? [0.9, 0.9, 0.9] : [0.15, 0.15, 0.15];
  const sky = dark ? [0.086, 0.098, 0.122] : [0.945, 0.953, 0.965];
  upload(buffers.pose, body, at);
  if (ref) upload(buffers.refPose, ref, at);
  collect(at);
  for (const k of ["sphere", "shaft", "cone"]) {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[k].instances);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(buffers[k].rows), gl.DYNAMIC_DRAW);
  }
  const sun = unit([Math.cos(D.heading - 0.55) * 0.85, Math.sin(D.heading - 0.55) * 0.85, 1]);
  const reach = HEIGHT * 1.25, centre = [c[0], c[1], HEIGHT * 0.45];
  const light = mul(ortho(reach, 0.1, 12), lookAt(centre.map((x, i) => x + sun[i] * 6), centre, [1, 0, 0]));
  const e = eye();
  const view = mul(perspective(FOV, w / h, 0.05, 120), lookAt(e, camera.target, [0, 0, 1]));
  const sideways = [-Math.sin(D.heading), Math.cos(D.heading), 0].map((x) => x * (show.beside ? 0.75 : 0));
  last = { view, w, h, at };

  gl.bindFramebuffer(gl.FRAMEBUFFER, buffers.fbo);
  gl.viewport(0, 0, SHADOW, SHADOW); gl.clear(gl.DEPTH_BUFFER_BIT);
  gl.activeTexture(gl.TEXTURE0); gl.bindTexture(gl.TEXTURE_2D, null);
  if (show.body && !show.xray) drawBody("bodyShadow", light, buffers.pose, [0, 0, 0]);
  if (ref && show.ref && show.beside) drawBody("bodyShadow", light, buffers.refPose, sideways);

  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.viewport(0, 0, w, h); gl.clearColor(...sky, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  const common = (name) => {
    gl.useProgram(programs[name]); const u = uniforms[name];
    gl.uniformMatrix4fv(u.uView, false, view); gl.uniformMatrix4fv(u.uLight, false, light);
    gl.uniform3fv(u.uSun, sun); gl.uniform3fv(u.uEye, e); gl.uniform3fv(u.uSky, sky);
    gl.activeTexture(gl.TEXTURE0); gl.bindTexture(gl.TEXTURE_2D, buffers.shadow); gl.uniform1i(u.uShadow, 0);
    return u;
  };
  const g = common("ground");
  gl.uniform3fv(g.uCentre, [camera.target[0], camera.target[1], 0]);
  gl.uniform3fv(g.uFloor, dark ? [0.125, 0.14, 0.17] : [0.895, 0.908, 0.925]);
  gl.uniform3fv(g.uLine, dark ? [0.32, 0.35, 0.4] : [0.66, 0.70, 0.75]);
  if (D.ground) { gl.bindVertexArray(buffers.ground.vao); gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4); }
  if (show.body && !show.xray) { const u = common("body"); gl.uniform1f(u.uAlpha, 1); gl.uniform4f(u.uTint, 0, 0, 0, 0); drawBody("body", view, buffers.pose, [0, 0, 0]); }
  gl.uniform1f(common("inst").uFade, 1);
  for (const k of ["sphere", "shaft", "cone"]) {
    gl.bindVertexArray(buffers[k].vao);
    gl.drawElementsInstanced(gl.TRIANGLES, buffers[k].count, gl.UNSIGNED_SHORT, 0, buffers[k].rows.length / INSTANCE);
  }
  /* once more, faintly, where the body hides them */
  gl.uniform1f(uniforms.inst.uFade, 0.28); gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthFunc(gl.GREATER); gl.depthMask(false);
  for (const k of ["sphere", "shaft", "cone"]) {
    gl.bindVertexArray(buffers[k].vao);
    gl.drawElementsInstanced(gl.TRIANGLES, buffers[k].count, gl.UNSIGNED_SHORT, 0, buffers[k].rows.length / INSTANCE);
  }
  gl.depthFunc(gl.LESS); gl.depthMask(true); gl.disable(gl.BLEND);
  const ghost = (texture, tint, alpha, offset) => {
    const u = common("body"); gl.uniform1f(u.uAlpha, alpha); gl.uniform4fv(u.uTint, tint);
    gl.colorMask(false, false, false, false); drawBody("body", view, texture, offset);
    gl.colorMask(true, true, true, true); gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthFunc(gl.LEQUAL); drawBody("body", view, texture, offset); gl.depthFunc(gl.LESS); gl.disable(gl.BLEND);
  };
  if (show.body && show.xray) ghost(buffers.pose, [0, 0, 0, 0], 0.38, [0, 0, 0]);
  if (ref && show.ref) {     // pushed back a little: where both bodies coincide the result is seen
    gl.enable(gl.POLYGON_OFFSET_FILL); gl.polygonOffset(2, 8);
    ghost(buffers.refPose, [...COLOURS.reference, 0.8], 0.5, sideways);
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }
}
function drawBody(name, view, texture, offset) {
  gl.useProgram(programs[name]); const u = uniforms[name];
  gl.uniformMatrix4fv(u.uView, false, view); gl.uniform3fv(u.uOffset, offset);
  gl.activeTexture(gl.TEXTURE1); gl.bindTexture(gl.TEXTURE_2D, texture); gl.uniform1i(u.uPose, 1);
  gl.bindVertexArray(buffers.body.vao); gl.drawElements(gl.TRIANGLES, buffers.body.count, gl.UNSIGNED_INT, 0);
}

/* ---- curves ---- */
const cursors = [];
function nice(low, high) {
  const raw = (high - low) / 3, power = 10 ** Math.floor(Math.log10(raw || 1));
  const step = [1, 2, 2.5, 5, 10].map((x) => x * power).find((x) => x >= raw) || power, ticks = [];
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9; v += step) ticks.push(Math.abs(v) < 1e-12 ? 0 : v);
  return ticks;
}
function plural(v) { return Math.abs(v) >= 100 ? v.toFixed(0) : Math.abs(v) >= 10 ? v.toFixed(1) : v.toFixed(2); }
function buildCurves() {
  const host = $("curves");
  for (const chart of D.curves) {
    const lines = chart.lines.map((l) => ({ ...l, values: decode(l.values) }));
    let low = Infinity, high = -Infinity;
    for (const l of lines) for (const v of l.values) if (!Number.isNaN(v)) { low = Math.min(low, v); high = Math.max(high, v); }
    if (!(high >= low)) continue;
    const pad = Math.max((high - low) * 0.06, 1e-6); low -= pad; high += pad;
    const x = (t) => (100 * (t - T0)) / ((T1 - T0) || 1), y = (v) => 100 * (1 - (v - low) / (high - low));
    const figure = document.createElement("figure");
    let svg = "";
    for (const v of nice(low, high)) svg += `<line class="tick${v === 0 ? " zero" : ""}" x1="0" x2="100" y1="${y(v)}" y2="${y(v)}"/>`;
    for (const l of lines) {
      let path = "", pen = false;
      l.values.forEach((v, i) => { if (Number.isNaN(v)) { pen = false; return; } path += `${pen ? "L" : "M"}${x(time[i]).toFixed(2)} ${y(v).toFixed(2)}`; pen = true; });
      svg += `<path d="${path}" style="--c:${l.colour}"/>`;
    }
    figure.innerHTML = `<figcaption><b></b><span class="now"></span></figcaption><div class="plot"><div class="ticks"></div>
      <svg viewBox="0 0 100 100" preserveAspectRatio="none">${svg}<line class="cursor" x1="0" x2="0" y1="0" y2="100"/></svg></div>`;
    figure.querySelector("b").textContent = chart.title;
    const ticks = figure.querySelector(".ticks");
    for (const v of nice(low, high)) { const s = document.createElement("span"); s.textContent = +v.toFixed(3); s.style.top = y(v) + "%"; ticks.append(s); }
    const now = figure.querySelector(".now"), cells = lines.map((l) => {
      const s = document.createElement("span"); s.style.setProperty("--c", l.colour); now.append(s); return s; });
    const plot = figure.querySelector("svg"), scrub = (ev) => {
      const r = plot.getBoundingClientRect(); seek(T0 + (T1 - T0) * Math.min(1, Math.max(0, (ev.clientX - r.left) / r.width))); };
    plot.addEventListener("pointerdown", (ev) => { plot.setPointerCapture(ev.pointerId); pause(); scrub(ev); });
    plot.addEventListener("pointermove", (ev) => { if (ev.buttons) scrub(ev); });
    cursors.push((at) => {
      figure.querySelector(".cursor").setAttribute("transform", `translate(${x(state.t)} 0)`);
      lines.forEach((l, i) => {
        const v = l.values[at[0]] * (1 - at[2]) + l.values[at[1]] * at[2];
        cells[i].textContent = `${l.label} ${Number.isNaN(v) ? "–" : plural(v)}${l.unit}`;
      });
    });
    host.append(figure);
  }
  if (!cursors.length) document.body.classList.add("nocurves");
}

/* ---- controls ---- */
const slider = $("slider");
function seek(t) { state.t = Math.min(T1, Math.max(T0, t)); state.dirty = true; }
function play() { if (N < 2) return; if (state.t >= T1 - 1e-6) state.t = T0; state.playing = true; $("play").classList.add("playing"); $("play").setAttribute("aria-label", "Pause"); }
function pause() { state.playing = false; $("play").classList.remove("playing"); $("play").setAttribute("aria-label", "Play"); }
function frameStep(k) { pause(); const at = frameAt(state.t); seek(time[Math.min(N - 1, Math.max(0, (at[2] > 0.5 ? at[1] : at[0]) + k))]); }
function setUpControls() {
  $("legend").open = innerWidth > 800;
  slider.min = T0; slider.max = T1; slider.step = "any"; slider.value = T0;
  slider.addEventListener("input", () => { pause(); seek(+slider.value); });
  $("play").addEventListener("click", () => (state.playing ? pause() : play()));
  $("back").addEventListener("click", () => frameStep(-1));
  $("next").addEventListener("click", () => frameStep(1));
  $("speed").addEventListener("change", (ev) => { state.speed = +ev.target.value; });
  $("follow").addEventListener("change", (ev) => { state.follow = ev.target.checked; state.dirty = true; });
  document.querySelectorAll("#views button").forEach((b) => b.addEventListener("click", () => setView(b.dataset.view)));
  document.querySelectorAll("#legend input").forEach((i) => {
    i.checked = show[i.name];
    i.addEventListener("change", () => { show[i.name] = i.checked; state.dirty = true; });
  });
  for (const ev of D.events) {
    const s = document.createElement("i");
    s.style.left = (100 * (ev.time - T0)) / ((T1 - T0) || 1) + "%"; s.style.background = ev.colour; s.className = ev.kind;
    s.title = ev.title; $("events").append(s);
  }
  addEventListener("keydown", (ev) => {
    if (/INPUT|SELECT/.test(ev.target.tagName) && ev.target.type !== "checkbox") return;
    if (ev.code === "Space") { ev.preventDefault(); state.playing ? pause() : play(); }
    else if (ev.code === "ArrowLeft") frameStep(-1); else if (ev.code === "ArrowRight") frameStep(1);
    else if (ev.key === "f") $("follow").click();
  });
  const pointers = new Map(); let pinch = 0;
  canvas.addEventListener("contextmenu", (ev) => ev.preventDefault());
  canvas.addEventListener("pointerdown", (ev) => { canvas.setPointerCapture(ev.pointerId); pointers.set(ev.pointerId, ev); });
  const up = (ev) => { pointers.delete(ev.pointerId); pinch = 0; };
  canvas.addEventListener("pointerup", up); canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointermove", (ev) => {
    const was = pointers.get(ev.pointerId);
    if (!was) { hover(ev); return; }
    const dx = ev.clientX - was.clientX, dy = ev.clientY - was.clientY;
    pointers.set(ev.pointerId, ev); state.dirty = true;
    if (pointers.size === 2) {
      const [a, b] = [...pointers.values()], d = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
      if (pinch) zoom(pinch / d); pinch = d; return;
    }
    if (ev.buttons & 2 || ev.shiftKey) {
      if (state.follow) $("follow").click();
      const k = camera.distance * 0.0011, s = Math.sin(camera.azimuth), c = Math.cos(camera.azimuth);
      camera.target[0] += k * (s * dx - c * dy * Math.sin(camera.elevation));
      camera.target[1] += k * (-c * dx - s * dy * Math.sin(camera.elevation));
      camera.target[2] += k * dy * Math.cos(camera.elevation);
    } else {
      camera.azimuth -= dx * 0.008;
      camera.elevation = Math.min(1.55, Math.max(-0.3, camera.elevation + dy * 0.006));
      document.querySelectorAll("#views button").forEach((b) => b.classList.remove("on"));
    }
  });
  const zoom = (k) => { camera.distance = Math.min(40, Math.max(0.3, camera.distance * k)); state.dirty = true; };
  canvas.addEventListener("wheel", (ev) => { ev.preventDefault(); zoom(Math.exp(ev.deltaY * 0.0012)); }, { passive: false });
  addEventListener("resize", () => { state.dirty = true; });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { state.dirty = true; });
}
function hover(ev) {
  const tip = $("tip"); tip.hidden = true;
  if (!last || !(recorded || fitted)) return;
  const r = canvas.getBoundingClientRect(); let best = 12, name = "";
  for (let i = 0; i < M; i++) for (const [source, on] of [[recorded, show.recorded], [fitted, show.fitted]]) {
    if (!source || !on) continue;
    const p = mix3(source, M, i, last.at), v = last.view;
    const w = v[3] * p[0] + v[7] * p[1] + v[11] * p[2] + v[15];
    const x = (v[0] * p[0] + v[4] * p[1] + v[8] * p[2] + v[12]) / w, y = (v[1] * p[0] + v[5] * p[1] + v[9] * p[2] + v[13]) / w;
    const d = Math.hypot(((x + 1) / 2) * r.width - (ev.clientX - r.left), ((1 - y) / 2) * r.height - (ev.clientY - r.top));
    if (d < best) {
      best = d; name = D.marker_names[i];
      const a = recorded && mix3(recorded, M, i, last.at), b = fitted && mix3(fitted, M, i, last.at);
      if (a && b) { const e = Math.hypot(...sub(a, b)); name += Number.isNaN(e) ? " · not seen" : ` · ${(1000 * e).toFixed(1)} mm apart`; }
    }
  }
  if (!name) return;
  tip.textContent = name; tip.hidden = false;
  tip.style.left = ev.clientX - r.left + 14 + "px"; tip.style.top = ev.clientY - r.top + 10 + "px";
}

/* ---- the loop ---- */
let before = null;
function tick(now) {
  if (state.playing) {
    state.t += before === null ? 0 : (Math.min(100, now - before) / 1000) * state.speed;
    if (state.t > T1) state.t = T0;
    state.dirty = true;
  }
  before = now;
  if (state.dirty) {
    state.dirty = false;
    const at = frameAt(state.t);
    if (gl) draw();
    for (const move of cursors) move(at);
    slider.value = state.t;
    $("clock").textContent = `${state.t.toFixed(2)} s`;
    document.body.dataset.time = state.t.toFixed(4);
  }
  requestAnimationFrame(tick);
}
if (gl) { setUp(); canvas.addEventListener("webglcontextrestored", () => { setUp(); state.dirty = true; }); canvas.addEventListener("webglcontextlost", (ev) => ev.preventDefault()); }
camera.target = [...mix3(com, 1, 0, [0, 0, 0]).slice(0, 2), HEIGHT * 0.5];
buildCurves(); setUpControls();
if (gl) setView("oblique");
const wanted = new URLSearchParams(location.hash.slice(1));
if (wanted.has("t")) seek(+wanted.get("t")); else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play();
window.plantigrade = { seek, play, pause, state, camera, show, setView, times: [T0, T1] };
document.body.dataset.ready = "1";
requestAnimationFrame(tick);
