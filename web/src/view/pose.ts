// Between two poses: straight lines of every point. Enough for a slider; results are never read off
// in between.
import type { SceneHead } from '../api';
import { text } from '../text';

export interface Pose { from: string; to: string; t: number }
export const at = (name: string): Pose => ({ from: name, to: name, t: 0 });

export function mixed(into: Float32Array, points: (name: string) => Float32Array, { from, to, t }: Pose): void {
  const a = points(from);
  if (from === to || t === 0) { into.set(a); return; }
  const b = points(to);
  for (let i = 0; i < into.length; ++i) into[i] = a[i] + t * (b[i] - a[i]);
}

/** 'prone' is the pose in which she was captured; a scan alone is of her standing. */
export function poseName(head: SceneHead, pose: string): string {
  return text.view.poses[pose === 'prone' && head.captured === 'scan' ? 'scanned' : pose];
}

/** A slider over a row of poses: 0 is the first, 1 the second ... */
export function along(poses: string[], position: number): Pose {
  const i = Math.max(0, Math.min(poses.length - 2, Math.floor(position)));
  if (poses.length === 1) return at(poses[0]);
  return { from: poses[i], to: poses[i + 1], t: Math.max(0, Math.min(1, position - i)) };
}

/** Length of every point's way from one pose to another [mm]. */
export function distances(a: Float32Array, b: Float32Array): Float32Array {
  const d = new Float32Array(a.length / 3);
  for (let i = 0; i < d.length; ++i) {
    d[i] = Math.hypot(b[3 * i] - a[3 * i], b[3 * i + 1] - a[3 * i + 1], b[3 * i + 2] - a[3 * i + 2]);
  }
  return d;
}
