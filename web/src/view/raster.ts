// A small z-buffer for browsers without WebGL: shaded triangles, seen from far away.
import type { Point } from '../api';

/** An orthographic eye: unit axes of the picture in patient coordinates, and its scale. */
export interface Eye { right: Point; up: Point; towards: Point; centre: Point; pixelsPerMm: number }
export interface Solid { positions: Float32Array; triangles: ArrayLike<number>; colour: Point; opacity: number }

/** From an azimuth around +z; 0 is from the front, 90 degrees from the patient's left. */
export function eyeAt(azimuth_deg: number, centre: Point, pixelsPerMm: number): Eye {
  const a = (azimuth_deg * Math.PI) / 180, s = Math.sin(a), c = Math.cos(a);
  return { right: [c, s, 0], up: [0, 0, 1], towards: [s, -c, 0], centre, pixelsPerMm };
}
export function project(eye: Eye, p: ArrayLike<number>, at: number, width: number, height: number): Point {
  const d = [0, 1, 2].map((c) => p[at + c] - eye.centre[c]), dot = (v: Point): number => v[0] * d[0] + v[1] * d[1] + v[2] * d[2];
  return [width / 2 + eye.pixelsPerMm * dot(eye.right), height / 2 - eye.pixelsPerMm * dot(eye.up), dot(eye.towards)];
}

/** Draws one solid over what is in the picture already; inside itself nearer parts hide farther ones. */
export function draw(image: { data: Uint8ClampedArray; width: number; height: number }, solid: Solid, eye: Eye): void {
  const { data, width, height } = image, n = solid.positions.length / 3;
  const screen = new Float32Array(3 * n), light = brightness(solid, eye);
  for (let v = 0; v < n; ++v) screen.set(project(eye, solid.positions, 3 * v, width, height), 3 * v);
  const depth = new Float32Array(width * height).fill(-Infinity), shade = new Float32Array(width * height);
  for (let t = 0; t < solid.triangles.length; t += 3) {
    fillTriangle(screen, light, [solid.triangles[t], solid.triangles[t + 1], solid.triangles[t + 2]], depth, shade, width, height);
  }
  for (let i = 0; i < depth.length; ++i) {
    if (depth[i] === -Infinity) continue;
    for (let c = 0; c < 3; ++c) data[4 * i + c] = data[4 * i + c] * (1 - solid.opacity) + solid.colour[c] * shade[i] * solid.opacity;
    data[4 * i + 3] = 255;
  }
}

/** Lambert's law with a lamp above the eye, on normals averaged over the triangles of a vertex. */
function brightness({ positions: p, triangles }: Solid, eye: Eye): Float32Array {
  const normals = new Float32Array(p.length), lamp = [0, 1, 2].map((c) => 0.87 * eye.towards[c] + 0.5 * eye.up[c]);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const u = [0, 1, 2].map((k) => p[b + k] - p[a + k]), v = [0, 1, 2].map((k) => p[c + k] - p[a + k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const at of [a, b, c]) for (let k = 0; k < 3; ++k) normals[at + k] += n[k];
  }
  const light = new Float32Array(p.length / 3);
  for (let v = 0; v < light.length; ++v) {
    const n = [normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]], length = Math.hypot(...n) || 1;
    // Both faces of a surface are lit: cut faces and insides are looked at, too.
    light[v] = 0.35 + 0.65 * Math.abs(n[0] * lamp[0] + n[1] * lamp[1] + n[2] * lamp[2]) / length;
  }
  return light;
}

function fillTriangle(s: Float32Array, light: Float32Array, [i, j, k]: Point, depth: Float32Array, shade: Float32Array, width: number, height: number): void {
  const [ax, ay, az, bx, by, bz, cx, cy, cz] = [i, j, k].flatMap((v) => [s[3 * v], s[3 * v + 1], s[3 * v + 2]]);
  const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
  if (area === 0) return;
  const x0 = Math.max(0, Math.ceil(Math.min(ax, bx, cx))), x1 = Math.min(width - 1, Math.floor(Math.max(ax, bx, cx)));
  const y0 = Math.max(0, Math.ceil(Math.min(ay, by, cy))), y1 = Math.min(height - 1, Math.floor(Math.max(ay, by, cy)));
  for (let y = y0; y <= y1; ++y) for (let x = x0; x <= x1; ++x) {
    const wb = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area, wc = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area, wa = 1 - wb - wc;
    if (wa < 0 || wb < 0 || wc < 0) continue;
    const z = wa * az + wb * bz + wc * cz, at = y * width + x;
    if (z > depth[at]) {
      depth[at] = z;
      shade[at] = wa * light[i] + wb * light[j] + wc * light[k];
    }
  }
}
