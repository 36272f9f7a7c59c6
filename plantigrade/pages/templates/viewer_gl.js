
/* ---- WebGL ---- */
const canvas = $("canvas");
let gl = canvas.getContext("webgl2", { antialias: false });

const LIGHT = `
precision highp float; precision highp sampler2DShadow;
uniform mat4 uLight; uniform sampler2DShadow uShadow; uniform vec3 uSun, uEye; uniform vec3 uSky; uniform bool uSimple;
float lit(vec3 p, vec3 n) {
  if (uSimple) return 1.0;
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
    `${LIGHT} in vec3 P, Nn, C; uniform vec4 uTint, uUnder; uniform float uAlpha; out vec4 o;
    void main() { if (dot(uUnder.xyz, P) > uUnder.w) discard; o = vec4(shade(mix(C, uTint.rgb, uTint.a), P, normalize(Nn), 0.22), uAlpha); }`],
  bodyShadow: [`layout(location=0) in vec3 aPos; layout(location=1) in vec3 aNormal; layout(location=2) in float aBody;
    uniform mat4 uView; ${POSE} void main() { vec3 p, n; place(aBody, aPos, aNormal, p, n); gl_Position = uView * vec4(p, 1.0); }`,
    `precision highp float; out vec4 o; void main() { o = vec4(1.0); }`],
  inst: [`${INST} uniform mat4 uView; out vec3 P, Nn; out vec4 C;
    void main() { vec3 n; placeI(P, n); Nn = n; C = iColor; gl_Position = uView * vec4(P, 1.0); }`,
    `${LIGHT} in vec3 P, Nn; in vec4 C; uniform float uFade; out vec4 o;
    void main() { o = vec4(mix(C.rgb, shade(C.rgb, P, normalize(Nn), 0.1), 0.85), C.a * uFade); }`],
  ground: [`layout(location=0) in vec3 aPos; layout(location=1) in vec3 aNormal; layout(location=3) in vec3 aColor;
    uniform mat4 uView; uniform mat3 uGround; uniform vec3 uFrom, uOrigin; uniform float uSize; out vec3 P, Nn; out float S;
    void main() { S = uSize > 0. ? 1.0 : aColor.x; P = uSize > 0. ? uGround * (aPos * uSize + uFrom) + uOrigin : aPos; Nn = uSize > 0. ? uGround[2] : aNormal; gl_Position = uView * vec4(P, 1.0); }`,
    `${LIGHT} in vec3 P, Nn; in float S; uniform vec3 uCentre, uFloor, uLine, uOrigin; uniform mat3 uGround; out vec4 o;
    float grid(vec2 p, float w) { vec2 g = abs(fract(p - 0.5) - 0.5) / max(fwidth(p), vec2(1e-5)); return 1.0 - min(min(g.x, g.y) / w, 1.0); }
    void main() {
      vec3 n = normalize(Nn), g = transpose(uGround) * (P - uOrigin); float up = dot(n, uGround[2]);
      float d = length(P.xy - uCentre.xy), fade = exp(-d * d / 90.0);
      float fine = grid(g.xy * 4.0, 1.1) * 0.30 * exp(-d * d / 14.0), metre = grid(g.xy, 1.5) * 0.75;
      vec3 c = mix(uFloor, uLine, max(fine, metre) * fade * smoothstep(0.5, 0.7, up));
      c *= (0.72 + 0.28 * up) * (uFloor.r < 0.5 ? S * S * S : S);
      c *= mix(1.0, 0.55 + 0.45 * lit(P, n), fade);
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
function poseTexture(n = NB) {
  const t = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, t);
  for (const k of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, k, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 2 * n, 1, 0, gl.RGBA, gl.FLOAT, null);
  return t;
}
const SHADOW = 2048, INSTANCE = 11, SAMPLES = 4, KINDS = ["sphere", "shaft", "cone", "disc"];
function shapeBuffer(shapes, simple) {
  const vertices = [], faces = [];
  for (const s of shapes) {
    const g = geometryOf(s, simple), base = vertices.length / 10;
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
  return { vao, count: faces.length };
}
function setBody() {
  const solids = D.shapes.filter((s) => s.body && !s.thing);
  buffers.body = shapeBuffer(solids, quality.simple);
  if (F) { buffers.bones = boneBuffer([]); buffers.inside = boneBuffer(solids); }
}
function setFixed(more = []) { buffers.fixed = shapeBuffer([...D.shapes.filter((s) => s.thing || !s.body && !s.ground), ...more]); }
function setUp() {
  if (S) Object.assign(SHADERS, skinShaders());
  Object.keys(SHADERS).forEach(build);
  setBody();
  if (S) { buffers.skin = skinBuffer(); buffers.skinPose = poseTexture(NS); buffers.refSkinPose = poseTexture(NS); }
  setFixed();
  buffers.ground = shapeBuffer(D.shapes.filter((s) => s.ground).map((s) => ({ ...s, colour: [s.ground, 0, 0] })));
  const unit = {
    sphere: revolve(arcs(1, 0, 5), 14),
    shaft: revolve([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [0, 1, 0, 1]], 14),
    disc: revolve([[1, 0, 0, 1], [0, 0, 0, 1]], 12),   // of one face: hundreds of them are on the ground
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
  buffers.plane = { vao: gv };
  buffers.smooth = null;
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

/* ---- one frame ---- */
const colour = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
const COLOURS = Object.fromEntries(Object.entries(D.colours).map(([k, v]) => [k, colour(v)]));
const AWAY = [0, 0, -1e4], STRAIGHT = [1, 0, 0, 0], UP = [0, 0, 1];
const CONTACT = D.contact_colours.map(colour), SIDE = D.side_colours.map(colour);
function upload(texture, poses, skin) {
  const write = (into, n, rows) => { gl.bindTexture(gl.TEXTURE_2D, into); gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 2 * n, 1, gl.RGBA, gl.FLOAT, rows); };
  write(texture, NB, poses);
  if (skin) write(skin, NS, skinPose(poses));
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
function centreOfMass(c, ground) {
  sphere(c, 0.035, COLOURS.com);
  put("shaft", [c[0], c[1], ground + 0.002], [0, 0, c[2] - ground], 0.0035, COLOURS.com);
  put("disc", [c[0], c[1], ground + 0.006], UP, 0.028, COLOURS.com);
}
let last = null;             // the last view, for picking
function smoothed(w, h) {    // what is drawn with four samples for a pixel, then brought to the canvas
  if (buffers.smooth && buffers.smooth.w === w && buffers.smooth.h === h) return buffers.smooth.fbo;
  if (buffers.smooth) { buffers.smooth.parts.forEach((r) => gl.deleteRenderbuffer(r)); gl.deleteFramebuffer(buffers.smooth.fbo); }
  const fbo = gl.createFramebuffer(), parts = [];
  gl.bindFramebuffer(gl.FRAMEBUFFER, fbo);
  for (const [format, at] of [[gl.RGBA8, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
    const r = gl.createRenderbuffer(); parts.push(r);
    gl.bindRenderbuffer(gl.RENDERBUFFER, r);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, SAMPLES, format, w, h);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, at, gl.RENDERBUFFER, r);
  }
  buffers.smooth = { fbo, parts, w, h };
  return fbo;
}
function draw(paper = null) {
  const now = instant(), { com: c, level: base } = now, simple = quality.simple && !paper;
  if (state.follow) camera.target = closeUp() ? Array.from(now.poses.subarray(8 * F.body[0], 8 * F.body[0] + 3)) : [c[0], c[1], camera.height + base];
  const ratio = simple ? 0.55 * Math.min(1, devicePixelRatio) : Math.min(2, devicePixelRatio);
  const { width: w, height: h } = paper ?? { width: Math.round(canvas.clientWidth * ratio), height: Math.round(canvas.clientHeight * ratio) };
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  if (!w || !h) return;
  const dark = !paper && matchMedia("(prefers-color-scheme: dark)").matches;
  COLOURS.text = dark ? [0.9, 0.9, 0.9] : [0.15, 0.15, 0.15];
  const sky = dark ? [0.086, 0.098, 0.122] : [0.945, 0.953, 0.965];
  upload(buffers.pose, now.poses, buffers.skinPose);
  if (now.reference) upload(buffers.refPose, now.reference, buffers.refSkinPose);
  const skinned = !!S && !show.solids;
  const [kind, pose, refPose] = skinned ? ["skin", buffers.skinPose, buffers.refSkinPose] : ["body", buffers.pose, buffers.refPose];
  for (const k of KINDS) buffers[k].rows.length = 0;
  overlays(now);
  if (F && show.body && show.xray) contactPoints(now.poses);
  for (const k of KINDS) {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[k].instances);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(buffers[k].rows), gl.DYNAMIC_DRAW);
  }
  const sun = unit([Math.cos(D.heading - 0.55) * 0.85, Math.sin(D.heading - 0.55) * 0.85, 1]);
  const reach = HEIGHT * 1.25, centre = [c[0], c[1], HEIGHT * 0.45 + base];
  const light = mul(ortho(reach, 0.1, 12), lookAt(centre.map((x, i) => x + sun[i] * 6), centre, [1, 0, 0]));
  const e = eye();
  const view = mul(perspective(FOV, w / h, 0.05, 120), lookAt(e, camera.target, [0, 0, 1]));
  const up = now.ground.axes.slice(6);
  const sideways = [-Math.sin(D.heading), Math.cos(D.heading), 0].map((x) => x * (show.beside ? 0.75 : 0));
  last = { ...now, view, eye: e };
  state.drawn += 1;

  if (!simple) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffers.fbo);
    gl.viewport(0, 0, SHADOW, SHADOW); gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.activeTexture(gl.TEXTURE0); gl.bindTexture(gl.TEXTURE_2D, null);
    drawShapes("fixed", "bodyShadow", light, buffers.pose, [0, 0, 0]);
    if (show.body && (skinned || !show.xray)) drawShapes(kind, `${kind}Shadow`, light, pose, [0, 0, 0]);
    if (now.reference && show.ref && show.beside) drawShapes(kind, `${kind}Shadow`, light, refPose, sideways);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, simple ? null : smoothed(w, h));
  gl.viewport(0, 0, w, h); gl.clearColor(...sky, 1); gl.colorMask(true, true, true, true); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.colorMask(true, true, true, false);     // the page behind never shows through
  const common = (name) => {
    gl.useProgram(programs[name]); const u = uniforms[name];
    gl.uniformMatrix4fv(u.uView, false, view); gl.uniformMatrix4fv(u.uLight, false, light); gl.uniform1i(u.uSimple, simple);
    gl.uniform3fv(u.uSun, sun); gl.uniform3fv(u.uEye, e); gl.uniform3fv(u.uSky, sky);
    gl.activeTexture(gl.TEXTURE0); gl.bindTexture(gl.TEXTURE_2D, buffers.shadow); gl.uniform1i(u.uShadow, 0);
    return u;
  };
  drawGround(common("ground"), now.ground, dark);
  const plain = (name, alpha = 1, under = [0, 0, 0, 0]) => { const u = common(name); gl.uniform1f(u.uAlpha, alpha); gl.uniform4f(u.uTint, 0, 0, 0, 0); gl.uniform4fv(u.uUnder, under); };
  plain("body"); drawShapes("fixed", "body", view, buffers.pose, [0, 0, 0]);
  // X-ray: solids inside the skin, and bones in place of those of the feet; in transparent solids, bones alone
  const [shown, solid, solidPose] = show.xray ? [F ? (skinned ? "inside" : "bones") : "body", "body", buffers.pose] : [kind, kind, pose];
  if (show.body && (skinned || F || !show.xray)) {
    if (now.ground.plane && !simple) {    // what is below the ground is seen through it, or feet would be cut off
      gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA); gl.depthFunc(gl.GREATER); gl.depthMask(false);
      plain(solid, 0.5, [...up, now.ground.height + dot(up, now.ground.origin)]); drawShapes(shown, solid, view, solidPose, [0, 0, 0]);
      gl.depthFunc(gl.LESS); gl.depthMask(true); gl.disable(gl.BLEND);
    }
    plain(solid); drawShapes(shown, solid, view, solidPose, [0, 0, 0]);
  }
  gl.uniform1f(common("inst").uFade, 1);
  for (const k of KINDS) {
    gl.bindVertexArray(buffers[k].vao);
    gl.drawElementsInstanced(gl.TRIANGLES, buffers[k].count, gl.UNSIGNED_SHORT, 0, buffers[k].rows.length / INSTANCE);
  }
  /* once more, faintly, where the body hides them */
  gl.uniform1f(uniforms.inst.uFade, 0.28); gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthFunc(gl.GREATER); gl.depthMask(false);
  for (const k of KINDS) {
    gl.bindVertexArray(buffers[k].vao);
    gl.drawElementsInstanced(gl.TRIANGLES, buffers[k].count, gl.UNSIGNED_SHORT, 0, buffers[k].rows.length / INSTANCE);
  }
  gl.depthFunc(gl.LESS); gl.depthMask(true); gl.disable(gl.BLEND);
  const ghost = (texture, tint, alpha, offset) => {
    const u = common(kind); gl.uniform1f(u.uAlpha, alpha); gl.uniform4fv(u.uTint, tint); gl.uniform4f(u.uUnder, 0, 0, 0, 0);
    gl.colorMask(false, false, false, false); drawShapes(kind, kind, view, texture, offset);
    gl.colorMask(true, true, true, false); gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthFunc(gl.LEQUAL); drawShapes(kind, kind, view, texture, offset); gl.depthFunc(gl.LESS); gl.disable(gl.BLEND);
  };
  if (show.body && show.xray) ghost(pose, [0, 0, 0, 0], 0.3, [0, 0, 0]);
  if (now.reference && show.ref) {     // pushed back a little: where both bodies coincide the result is seen
    gl.enable(gl.POLYGON_OFFSET_FILL); gl.polygonOffset(2, 8);
    ghost(refPose, [...COLOURS.reference, 0.8], 0.5, sideways);
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }
  if (!simple) {
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, buffers.smooth.fbo); gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, w, h, 0, 0, w, h, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  }
}
function drawGround(u, g, dark) {
  const k = g.axes, t = sub(camera.target, g.origin);
  gl.uniformMatrix3fv(u.uGround, false, k);
  gl.uniform3fv(u.uCentre, camera.target); gl.uniform3fv(u.uOrigin, g.origin);
  gl.uniform3fv(u.uFloor, dark ? COLOURS.floor_dark : COLOURS.floor);
  gl.uniform3fv(u.uLine, dark ? COLOURS.grid_dark : COLOURS.grid);
  if (g.plane) {             // as wide as is seen, and goes with the camera
    gl.uniform3fv(u.uFrom, [dot(k.slice(0, 3), t), dot(k.slice(3, 6), t), g.height]); gl.uniform1f(u.uSize, 60);
    gl.bindVertexArray(buffers.plane.vao); gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
  gl.uniform1f(u.uSize, 0);
  gl.bindVertexArray(buffers.ground.vao); gl.drawElements(gl.TRIANGLES, buffers.ground.count, gl.UNSIGNED_INT, 0);
}
function drawShapes(which, name, view, texture, offset) {
  if (!buffers[which].count) return;
  gl.useProgram(programs[name]); const u = uniforms[name];
  gl.uniformMatrix4fv(u.uView, false, view); gl.uniform3fv(u.uOffset, offset);
  gl.activeTexture(gl.TEXTURE1); gl.bindTexture(gl.TEXTURE_2D, texture); gl.uniform1i(u.uPose, 1);
  gl.bindVertexArray(buffers[which].vao); gl.drawElements(gl.TRIANGLES, buffers[which].count, gl.UNSIGNED_INT, 0);
}
function noPicture(text) { $("nogl").textContent = text; $("nogl").hidden = !text; document.body.classList.toggle("flat", !!text); }
const NONE = "This browser offers no WebGL 2, so the body cannot be drawn; the curves still play.";
function startDrawing() {
  if (gl) try { setUp(); } catch (error) { console.warn(error.message); gl = null; }
  if (!gl) { noPicture(NONE); return; }
  canvas.addEventListener("webglcontextlost", (ev) => { ev.preventDefault(); noPicture("The browser lost its graphics context. The body reappears when the context is restored or the page is reloaded; the curves still play."); });
  canvas.addEventListener("webglcontextrestored", () => { setUp(); noPicture(""); state.dirty = true; });
}
