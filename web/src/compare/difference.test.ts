import { expect, test } from 'vitest';
import type { SceneHead } from '../api';
import type { Bundle } from '../bundle';
import { Body } from '../view/body';
import { differences, sameMesh } from './difference';

/** A flat square of n x n vertices, whose skin moves by `moved` after surgery. */
function square(n: number, moved: (x: number, z: number) => number): Body {
  const points: number[] = [], after: number[] = [], triangles: number[] = [];
  for (let j = 0; j < n; ++j) for (let i = 0; i < n; ++i) {
    const x = (100 * i) / (n - 1), z = (100 * j) / (n - 1);
    points.push(x, 0, z);
    after.push(x, moved(x, z), z);
    if (i + 1 < n && j + 1 < n) triangles.push(j * n + i, j * n + i + 1, (j + 1) * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i);
  }
  const arrays: Record<string, Float32Array | Uint32Array | Uint8Array> = {
    triangles: new Uint32Array(triangles), breast: new Uint8Array(n * n),
    'points.prone': new Float32Array(points), 'points.before': new Float32Array(points), 'points.after': new Float32Array(after),
  };
  const get = (name: string): never => arrays[name] as never;
  const head = { captured: 'image' as const, poses: ['prone', 'before', 'after'], groups: [{ name: 'skin', first: 0, count: triangles.length / 3 }], midline_x_mm: 0, nipple: { L: {}, R: {} } };
  return new Body({ head: head as unknown as SceneHead, f32: get, u32: get, u8: get, has: (name: string) => name in arrays } as Bundle<SceneHead>);
}

test('plans on one mesh are compared vertex by vertex', () => {
  const a = square(5, () => 2), b = square(5, (x) => (x > 50 ? 5 : 2));
  expect(sameMesh(a, b)).toBe(true);
  const apart = differences(a, b);
  expect(apart[0]).toBe(0);
  expect(apart[4]).toBeCloseTo(3, 5);
});

test('plans on different meshes are compared at the same places of the skin', () => {
  const a = square(9, (x, z) => 0.1 * x + 0.02 * z), b = square(7, (x, z) => 0.1 * x + 0.02 * z + 1);
  expect(sameMesh(a, b)).toBe(false);
  for (const d of differences(a, b)) expect(d).toBeCloseTo(1, 4); // linear fields are interpolated exactly
});
