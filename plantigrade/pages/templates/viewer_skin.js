
/* ---- skin: bones from the poses of the bodies, then linear blend skinning in the vertex shader ---- */
const S = D.skin, NS = S ? S.body.length : 0;
const qmul = (a, b) => [a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
  a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]];
const qinv = (a) => [-a[0], -a[1], -a[2], a[3]];
const qturn = (q, p) => { const c = cross(q, p), d = cross(q, c.map((x, i) => x + q[3] * p[i])); return p.map((x, i) => x + 2 * d[i]); };
const untwisted = (q) => { const l = Math.hypot(q[2], q[3]); return l < 1e-9 ? q : qmul(q, [0, 0, -q[2] / l, q[3] / l]); };
const part = (q, n) => {     // the rotation by an n-th of the angle
  const s = q[3] < 0 ? -1 : 1, l = Math.hypot(q[0], q[1], q[2]), a = Math.atan2(l, q[3] * s) / n, f = l < 1e-9 ? s / n : (s * Math.sin(a)) / l;
  return [q[0] * f, q[1] * f, q[2] * f, Math.cos(a)];
};
function skinPose(data) {    // data: position and quaternion of every body, scalar last
  const p = [], q = [], out = new Float32Array(NS * 8);
  for (let i = 0; i < NS; i++) {
    const b = 8 * S.body[i]; q[i] = Array.from(data.subarray(b + 4, b + 8));
    p[i] = qturn(q[i], S.offset[i]).map((x, k) => x + data[b + k]);
  }
  for (const [kind, to, a, b] of S.recipes) { const r = qmul(qinv(q[a]), q[b]); q[to] = qmul(q[a], kind === 1 ? untwisted(r) : part(r, kind)); }
  for (let i = 0; i < NS; i++) {
    const r = qmul(q[i], qinv(S.resting[i].slice(3))), t = qturn(r, S.resting[i].slice(0, 3));
    out.set([p[i][0] - t[0], p[i][1] - t[1], p[i][2] - t[2], 0, ...r], i * 8);
  }
  return out;
}
function skinBuffer() {
  const bytes = (name) => Uint8Array.from(atob(S[name]), (c) => c.charCodeAt(0));
  const words = new Uint16Array(bytes("vertices").buffer), faces = new Uint16Array(bytes("faces").buffer), n = words.length / 3;
  const bones = bytes("bones"), weights = bytes("weights"), marks = bytes("marks");
  const v = Array.from({ length: n }, (_, i) => [0, 1, 2].map((k) => S.low[k] + words[3 * i + k] * S.step[k])), normal = v.map(() => [0, 0, 0]);
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [v[faces[i]], v[faces[i + 1]], v[faces[i + 2]]], x = cross(sub(b, a), sub(c, a));
    for (const j of [0, 1, 2]) for (const k of [0, 1, 2]) normal[faces[i + j]][k] += x[k];
  }
  const rows = new Float32Array(n * 18), four = (a, i, scale) => Array.from(a.subarray(4 * i, 4 * i + 4), (x) => x * scale);
  for (let i = 0; i < n; i++) rows.set([...v[i], ...unit(normal[i]), ...four(bones, i, 1), ...four(weights, i, 1 / 255), ...four(marks, i, 1)], i * 18);
  const vao = gl.createVertexArray(); gl.bindVertexArray(vao);
  arrayBuffer(rows, [[0, 3], [1, 3], [2, 4], [4, 4], [3, 4]], 18);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(faces), gl.STATIC_DRAW);
  S.mesh = { vertices: v, bones: v.map((_, i) => four(bones, i, 1)), weights: v.map((_, i) => four(weights, i, 1 / 255)), faces };   // for picking
  return { vao, count: faces.length };
}
const SKINNED = `
layout(location=0) in vec3 aPos; layout(location=1) in vec3 aNormal; layout(location=2) in vec4 aBones; layout(location=4) in vec4 aWeights; layout(location=3) in vec4 aMarks;
uniform highp sampler2D uPose; uniform vec3 uOffset; uniform mat4 uView;
vec3 turned(vec4 q, vec3 p) { return p + 2.0 * cross(q.xyz, cross(q.xyz, p) + q.w * p); }
void place(out vec3 wp, out vec3 wn) {
  wp = uOffset; wn = vec3(0);
  for (int k = 0; k < 4; k++) {
    int b = int(aBones[k]); vec4 t = texelFetch(uPose, ivec2(2 * b, 0), 0), q = texelFetch(uPose, ivec2(2 * b + 1, 0), 0);
    wp += aWeights[k] * (turned(q, aPos) + t.xyz); wn += aWeights[k] * turned(q, aNormal);
  }
}`;
const glsl = (c) => `vec3(${c.map((x) => x.toFixed(3)).join(",")})`;
function skinShaders() {
  const tone = Object.fromEntries(Object.entries(S.colours).map(([name, hex]) => [name, glsl(colour(hex))]));
  const left = glsl(COLOURS.left), right = glsl(COLOURS.right), body = SHADERS.body[1], sh = S.shoulder.toFixed(4);
  /* garments are level sets, cut to the pixel; sleeves and the legs of the shorts show the side */
  const dressed = `
    vec3 dressed(vec4 m, vec3 at) {
      if (m.z > 0.5) return m.z > 1.5 ? ${tone.iris} : ${tone.eye};
      float shirt = m.x - 128.0, shorts = m.y - 128.0; vec3 side = mix(at.y > 0.0 ? ${left} : ${right}, ${tone.shirt}, 0.25);
      float e = fwidth(shirt) + 1e-3, f = fwidth(shorts) + 1e-3, w = fwidth(at.y) + 1e-5;
      vec3 c = mix(${tone.skin}, mix(${tone.shorts}, side, smoothstep(-w, w, abs(at.y) - 0.035)), smoothstep(-f, f, shorts));
      c = mix(c, mix(${tone.shirt}, side, smoothstep(-w, w, abs(at.y) - 1.06 * ${sh})), smoothstep(-e, e, shirt));
      return mix(c, vec3(0.80), 0.55 * m.w / 255.0);
    }`;
  return {
    skin: [`${SKINNED} out vec3 P, Nn, R; out vec4 M; void main() { place(P, Nn); M = aMarks; R = aPos; gl_Position = uView * vec4(P, 1.0); }`,
      body.replace("in vec3 P, Nn, C;", "in vec3 P, Nn, R; in vec4 M;").replace("void main", `${dressed} void main`).replace("mix(C, ", "mix(dressed(M, R), ").replace("0.22)", "0.10)")],
    skinShadow: [`${SKINNED} void main() { vec3 p, n; place(p, n); gl_Position = uView * vec4(p, 1.0); }`, SHADERS.bodyShadow[1]],
  };
}
