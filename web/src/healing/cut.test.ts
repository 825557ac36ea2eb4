import { expect, test } from 'vitest';
import { cutTetrahedra } from './cut';

/** The unit cube as Kuhn's six tetrahedra. */
const points = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1]);
const cells = new Uint32Array([0, 1, 3, 7, 0, 1, 5, 7, 0, 2, 3, 7, 0, 2, 6, 7, 0, 4, 5, 7, 0, 4, 6, 7]);

function area(p: Float32Array): number {
  let sum = 0;
  for (let i = 0; i < p.length; i += 9) {
    const u = [0, 1, 2].map((c) => p[i + 3 + c] - p[i + c]), v = [0, 1, 2].map((c) => p[i + 6 + c] - p[i + c]);
    sum += 0.5 * Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  return sum;
}

test.each([0, 1, 2] as const)('a cut of a unit cube across axis %i has area 1 and lies in the plane', (axis) => {
  const cut = cutTetrahedra(points, cells, () => 1, axis, 0.3);
  expect(area(cut.positions)).toBeCloseTo(1, 5);
  for (let i = axis; i < cut.positions.length; i += 3) expect(cut.positions[i]).toBeCloseTo(0.3, 6);
});

test('a linear field is reproduced on the cut', () => {
  const field = (v: number): number => points[3 * v] + 2 * points[3 * v + 1] - points[3 * v + 2];
  const cut = cutTetrahedra(points, cells, field, 2, 0.62);
  cut.values.forEach((value, i) => {
    expect(value).toBeCloseTo(cut.positions[3 * i] + 2 * cut.positions[3 * i + 1] - 0.62, 5);
  });
});

test('beside the body there is nothing', () => {
  expect(cutTetrahedra(points, cells, () => 1, 0, 2).values.length).toBe(0);
});
