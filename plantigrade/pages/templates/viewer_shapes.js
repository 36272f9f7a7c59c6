
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
function geometryOf(s, simple) {
  if (s.geometry) return s.geometry;
  const [rings, around] = simple ? [3, 10] : [9, 26];
  if (s.kind === "capsule") return revolve(arcs(s.size[0], s.size[1], rings), around);
  if (s.kind === "cylinder") {
    const [r, h] = s.size;
    return revolve([[0, -h, 0, -1], [r, -h, 0, -1], [r, -h, 1, 0], [r, h, 1, 0], [r, h, 0, 1], [0, h, 0, 1]], around);
  }
  if (s.kind === "box") return boxOf(s.size);
  if (s.kind === "mesh") return meshOf(s);
  const axes = s.kind === "sphere" ? [s.size[0], s.size[0], s.size[0]] : s.size;
  const g = revolve(arcs(1, 0, rings), around);
  for (const v of g.v) for (let k = 0; k < 3; k++) { v[k] *= axes[k]; v[k + 3] /= axes[k]; }
  return g;
}
function turn([w, x, y, z], p) {
  const tx = 2 * (y * p[2] - z * p[1]), ty = 2 * (z * p[0] - x * p[2]), tz = 2 * (x * p[1] - y * p[0]);
  return [p[0] + w * tx + y * tz - z * ty, p[1] + w * ty + z * tx - x * tz, p[2] + w * tz + x * ty - y * tx];
}
