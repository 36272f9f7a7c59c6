
/* ---- what the mouse points at: the nearest triangle of the skin, or of the solids ---- */
function distanceTo({ from, along }, a, b, c) {    // Möller and Trumbore, 1997; Infinity beside the triangle
  const u = sub(b, a), v = sub(c, a), p = cross(along, v), d = dot(u, p);
  if (Math.abs(d) < 1e-14) return Infinity;
  const s = sub(from, a), i = dot(s, p) / d, q = cross(s, u), j = dot(along, q) / d, t = dot(v, q) / d;
  return i < 0 || j < 0 || i + j > 1 || t < 0 ? Infinity : t;
}
function* triangles() {      // corners in the world, and the body they belong to
  if (S && !show.solids) {
    const { vertices, bones, weights, faces } = S.mesh, moved = skinPose(last.poses);
    const main = (i) => S.body[bones[i][weights[i].indexOf(Math.max(...weights[i]))]];
    const at = vertices.map((v, i) => bones[i].reduce((sum, b, j) => {
      const w = weights[i][j]; if (!w) return sum;
      const p = placed(moved, b, v); return sum.map((x, k) => x + w * p[k]);
    }, [0, 0, 0]));
    for (let i = 0; i < faces.length; i += 3) yield [at[faces[i]], at[faces[i + 1]], at[faces[i + 2]], main(faces[i])];
    return;
  }
  for (const s of D.shapes.filter((s) => s.body && !s.thing)) {
    const { v, f } = geometryOf(s, true);
    const at = v.map((p) => placed(last.poses, s.body, turn(s.quat, p.slice(0, 3)).map((x, k) => x + s.position[k])));
    for (const [a, b, c] of f) yield [at[a], at[b], at[c], s.body];
  }
}
function placed(poses, i, p) { const q = Array.from(poses.subarray(8 * i + 4, 8 * i + 8)); return qturn(q, p).map((x, k) => x + poses[8 * i + k]); }
let rope = null;             // the plane in which the hand moves
function grab(ev) {
  if (!last || !show.body) return false;
  const ray = rayAt(ev);
  let best = Infinity, body = 0;
  for (const [a, b, c, own] of triangles()) { const t = distanceTo(ray, a, b, c); if (t < best) [best, body] = [t, own]; }
  if (!(best < Infinity)) return false;
  const at = ray.from.map((x, k) => x + best * ray.along[k]);
  rope = { through: at, normal: ray.normal };
  send("hold", { body, at, end: at });
  return true;
}
function drag(ev) {
  if (!ev) { send("release"); return; }
  const ray = rayAt(ev), t = dot(sub(rope.through, ray.from), rope.normal) / dot(ray.along, rope.normal);
  if (t > 0) send("pull", { end: ray.from.map((x, k) => x + t * ray.along[k]) });
}
