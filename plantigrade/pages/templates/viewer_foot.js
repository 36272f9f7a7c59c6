
/* ---- bones of the feet, in an X-ray: rigid on the bodies, in place of the solids of their parts ---- */
const F = D.foot, SOLE = 0.0045;   // radius of the disc at a contact point [m]
function boneBuffer(solids) {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const words = new Int16Array(bytes(F.vertices)), corners = new Uint16Array(bytes(F.faces));
  const n = words.length / 3 / F.body.length, feet = new Set(F.body), tone = colour(F.colour);
  const shapes = solids.filter((s) => !feet.has(s.body));
  F.body.forEach((body, k) => {
    const v = Array.from({ length: n }, (_, i) => [0, 1, 2].map((j) => words[3 * (k * n + i) + j] * F.step)), f = [];
    for (let i = 0; i < corners.length; i += 3) f.push(F.mirrored[k] ? [corners[i], corners[i + 2], corners[i + 1]] : Array.from(corners.subarray(i, i + 3)));
    shapes.push({ kind: "smooth", geometry: smooth(v, f), body, colour: tone, position: [0, 0, 0], quat: STRAIGHT });
  });
  return shapeBuffer(shapes, quality.simple);
}
function smooth(v, f) {      // normals of a mesh without edges
  const normal = v.map(() => [0, 0, 0]);
  for (const [a, b, c] of f) {
    const x = cross(sub(v[b], v[a]), sub(v[c], v[a]));
    for (const i of [a, b, c]) for (const k of [0, 1, 2]) normal[i][k] += x[k];
  }
  return { v: v.map((p, i) => [...p, ...unit(normal[i])]), f };
}
function contactPoints(data) {   // data: position and quaternion of every body, scalar last
  for (const [body, ...p] of F.contacts) {
    const b = 8 * body, q = data.subarray(b + 4, b + 8), at = qturn(q, p).map((x, k) => x + data[b + k]);
    const up = qturn(q, [0, 0, 0.0015]);
    put("sphere", at, up, SOLE, COLOURS.contact);
  }
}
