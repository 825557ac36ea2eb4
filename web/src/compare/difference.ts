// How far two results of one patient are apart, place by place of her skin.
import { Vector3 } from 'three';
import type { Body } from '../view/body';

/** Length of the difference of the two displacements at every vertex of `b` [mm]. Two meshes of one
 * patient share her shape before surgery; where the meshes differ, the nearest place of `a`'s skin as
 * imaged answers for a vertex of `b`. */
export function differences(a: Body, b: Body): Float32Array {
  const movedA = displacements(a), movedB = displacements(b), result = new Float32Array(movedB.length / 3);
  const same = sameMesh(a, b), answer: [number, number, number] = [0, 0, 0], p = new Vector3();
  const points = b.bundle.f32('points.prone'), place = same ? null : a.nearestPlace('prone');
  for (let v = 0; v < result.length; ++v) {
    if (place) place(p.set(points[3 * v], points[3 * v + 1], points[3 * v + 2]), movedA, answer);
    else for (let c = 0; c < 3; ++c) answer[c] = movedA[3 * v + c];
    result[v] = Math.hypot(movedB[3 * v] - answer[0], movedB[3 * v + 1] - answer[1], movedB[3 * v + 2] - answer[2]);
  }
  return result;
}

/** Equal triangles and equal places as imaged. */
export function sameMesh(a: { bundle: Body['bundle'] }, b: { bundle: Body['bundle'] }): boolean {
  return (['triangles'] as const).every((name) => equal(a.bundle.u32(name), b.bundle.u32(name))) &&
    equal(a.bundle.f32('points.prone'), b.bundle.f32('points.prone'));
}
function equal(a: ArrayLike<number>, b: ArrayLike<number>): boolean {
  if (a.length !== b.length) return false;
  for (let i = 0; i < a.length; ++i) if (a[i] !== b[i]) return false;
  return true;
}
function displacements(body: Body): Float32Array {
  const before = body.bundle.f32('points.before'), after = body.bundle.f32('points.after');
  return after.map((x, i) => x - before[i]);
}
